r"""Dry friction, regularized after Oden & Martins (1985).

:math:`F = F_f\,\phi(|v|)\,\mathrm{sign}(v)` with :math:`\phi(s) = (s/\epsilon)(2 - s/\epsilon)` for
:math:`s < \epsilon`, 1 beyond: C1 everywhere (Cardona, Geradin & Doan 1991, eq. 34).
"""

from mecano.jit.kernel import kernel
from mecano.laws.term import Term
from mecano.schema import NUMBER, Field, not_negative, positive


@kernel
def dry_friction(a, i, s, v):
    """Evaluate the term; numbers: force, regularization."""
    if v >= a[i + 1]:
        return a[i], 0.0, 0.0
    if v <= -a[i + 1]:
        return -a[i], 0.0, 0.0
    u = abs(v) / a[i + 1]
    return a[i] * v / a[i + 1] * (2.0 - u), 0.0, 2.0 * a[i] / a[i + 1] * (1.0 - u)


DRY_FRICTION = Term(
    name="dry_friction",
    doc="F = force phi(|v|) sign(v), phi = u (2 - u) with u = |v|/regularization up to u = 1, then 1; C1.",
    role="force",
    fields=(
        Field("force", NUMBER, "N or N m", "friction force in sliding", check=not_negative),
        Field("regularization", NUMBER, "m/s or rad/s", "rate at which the full force is reached", check=positive),
    ),
    evaluate=dry_friction,
)

r"""Coulomb friction, smooth at rest (Oden & Martins 1985).

A normal force N and a sliding speed u give the friction :math:`\mu(u)\,\phi(u)\,N` against the sliding, with
:math:`\phi(u) = (u/\epsilon)(2 - u/\epsilon)` for :math:`u < \epsilon`, 1 beyond: C1 in the velocity vector.
"""

from mecano.jit.kernel import kernel
from mecano.laws.law_table import curve
from mecano.maths.dual import at_least, select
from mecano.schema import NUMBER, Field, positive


@kernel
def sticking(eps, u):
    """Return phi/u [s/m] for the sliding speed u >= 0 [m/s]; finite at u = 0."""
    return select(u < eps, (2.0 - u / eps) / eps, 1.0 / at_least(u, eps))


@kernel
def friction(laws, law, eps, u):
    """Return mu phi/u [s/m] for the sliding speed u >= 0 [m/s], the friction per normal force and velocity."""
    return at_least(curve(laws, law, u), 0.0) * sticking(eps, u)


def regularization(speed="sliding speed"):
    """Return the field of the ``speed`` below which friction is regularized, epsilon [m/s]."""
    doc = f"{speed} at which friction reaches its full value; below it, sticking parts creep"
    return Field("regularization", NUMBER, "m/s", doc, check=positive)

r"""Gas spring: polytropic compression of a gas column of length L.

:math:`F = -F_0 (L/(L + s))^n`, a push for every extension s > -L, with the potential
:math:`U = -F_0 \int_0^s (L/(L + s))^n ds`. A real gas column is never fully compressed: below the fraction ``LEAST``
of its length, the force continues along its tangent, so that trial states of Newton's iteration beyond it give finite
and smooth (C1) forces.
"""

import math

from mecano.jit.kernel import kernel
from mecano.laws.term import Term
from mecano.schema import NUMBER, Field, positive

LEAST = 0.01  # fraction of the gas column below which the force continues along its tangent


@kernel
def gas_force(F0, L, n, s):
    """Return the force and its derivative."""
    column = max(1.0 + s / L, LEAST)
    F = -F0 * column ** (-n)
    slope = -n * F / (L * column)
    return F + slope * (s - L * (column - 1.0)), slope


@kernel
def gas_spring(a, i, s, v):
    """Evaluate the term; numbers: force F0, length L, exponent n."""
    F, slope = gas_force(a[i], a[i + 1], a[i + 2], s)
    return F, slope, 0.0


@kernel
def gas_work(F0, L, n, s):
    """Return the potential, zero at s = 0; the form with expm1 is accurate for n near and equal to 1."""
    column = max(1.0 + s / L, LEAST)
    x = (1.0 - n) * math.log(column)
    mean = math.expm1(x) / x if x != 0.0 else 1.0
    beyond = s - L * (column - 1.0)
    F, slope = gas_force(F0, L, n, L * (column - 1.0))
    return -F0 * L * math.log(column) * mean + beyond * (F + 0.5 * slope * beyond)


@kernel
def gas_energy(a, i, s):
    """Return the potential of the term; numbers as of ``gas_spring``."""
    return gas_work(a[i], a[i + 1], a[i + 2], s)


GAS_SPRING = Term(
    name="gas_spring",
    doc="F = -F0 (L/(L + s))^n; below 1 % of the gas column, along the tangent there (C1, finite).",
    role="force",
    fields=(
        Field("force", NUMBER, "N", "push F0 at zero extension", check=positive),
        Field("length", NUMBER, "m", "length L of the gas column at zero extension", check=positive),
        Field("exponent", NUMBER, "-", "polytropic exponent n: 1 isothermal, 1.4 adiabatic (air)", check=positive),
    ),
    evaluate=gas_spring, integral=gas_energy,
)  # fmt: skip

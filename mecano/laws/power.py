r"""Power terms: :math:`c\,\mathrm{sign}(s)|s|^p` of the argument, or of the rate, for any real exponent p > 0.

A sphere on a plane gives p = 3/2 (Hertz 1881), turbulent drag p = 2. For p < 1 the slope at zero is infinite: within
``NEAR`` of zero the derivatives are those at ``NEAR``, while the value stays exact.
"""

import numpy as np

from mecano.jit.kernel import kernel
from mecano.laws.polynomial import SHOWN
from mecano.laws.term import OF_A_POWER, Term, of_rate
from mecano.schema import NUMBER, Field, not_negative, positive

NEAR = 1e-9


@kernel
def power(a, i, s):
    """Evaluate the term; numbers: coefficient, exponent."""
    c, p = a[i], a[i + 1]
    sign, size = (-1.0, -s) if s < 0.0 else (1.0, s)
    near = max(size, NEAR)
    slope = c * p * (size if p >= 1.0 else near) ** (p - 1.0)  # finite at zero
    return sign * c * size**p, slope, sign * c * p * (p - 1.0) * near ** (p - 2.0)


@kernel
def power_integral(a, i, s):
    """Return the antiderivative that is zero at s = 0."""
    return a[i] * abs(s) ** (a[i + 1] + 1.0) / (a[i + 1] + 1.0)


def shape_of_power(values, low, high):
    """Return equally spaced arguments, and both sides of zero."""
    return [*np.linspace(low, high, SHOWN), *(s for s in (-NEAR, NEAR) if low < s < high)]


EXPONENT = Field("exponent", NUMBER, "-", "exponent p: 1.5 of a Hertz contact, 2 of turbulent drag", check=positive)

POWER = Term(
    name="power", doc="y = coefficient sign(s) |s|^exponent, for any exponent > 0.", role="curve",
    fields=(Field("coefficient", NUMBER, OF_A_POWER, "coefficient c"), EXPONENT),
    evaluate=power, integral=power_integral, shape=shape_of_power,
    along_line=lambda values, slope, offset: (
        None if offset else {"coefficient": values["coefficient"] * slope ** values["exponent"]}
    ),
    breakpoints=lambda values: [] if values["exponent"] % 2.0 == 1.0 else [0.0],  # some derivative jumps if not odd
)  # fmt: skip

DAMPER_POWER = Term(
    name="damper_power",
    doc="F = coefficient sign(v) |v|^exponent, a power of the rate, for any exponent > 0.",
    role="force",
    fields=(Field("coefficient", NUMBER, OF_A_POWER, "coefficient c", check=not_negative), EXPONENT),
    evaluate=of_rate(power),
)

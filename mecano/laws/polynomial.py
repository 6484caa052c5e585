"""Polynomial curves: constant, linear, polynomial."""

import numpy as np

from mecano.jit.kernel import kernel
from mecano.laws.term import ARGUMENT, OF_A_POWER, SLOPE, VALUE, Term, along
from mecano.schema import COEFFICIENT_LIST, NUMBER, Field, requirement

SHOWN = 257  # number of arguments that resolve the shape of a polynomial


@kernel
def polynomial(a, i, s):
    """Evaluate by Horner's scheme; a[i] is the number of coefficients."""
    y = d = h = 0.0
    for j in range(i + int(a[i]), i, -1):
        h = h * s + 2.0 * d
        d = d * s + y
        y = y * s + a[j]
    return y, d, h


@kernel
def polynomial_integral(a, i, s):
    """Return the antiderivative that is zero at s = 0."""
    n = int(a[i])
    y = 0.0
    for j in range(n, 0, -1):
        y = y * s + a[i + j] / j
    return y * s


def pack_polynomial(values):
    """Return count and coefficients."""
    return [len(values["coefficients"]), *values["coefficients"]]


def polynomial_along_line(values, slope, offset):
    """Return the coefficients by powers of t of the polynomial at slope t + offset."""
    line = np.polynomial.Polynomial([offset, slope])
    return {"coefficients": np.polynomial.Polynomial(values["coefficients"])(line).coef.tolist()}


def shape_of_polynomial(values, low, high):
    """Return equally spaced arguments, and those where the slope is zero."""
    roots = np.polynomial.Polynomial(values["coefficients"]).deriv().roots()
    level = roots.real[np.abs(roots.imag) <= 1e-9 * np.abs(roots)]
    return [*np.linspace(low, high, SHOWN), *level[(low < level) & (level < high)]]


COEFFICIENTS = Field(
    "coefficients", COEFFICIENT_LIST, OF_A_POWER, "c0, c1, c2 ..., in ascending powers p from 0",
    check=requirement(lambda coefficients: len(coefficients) > 0, "must hold at least one coefficient"),
)  # fmt: skip

CONSTANT = Term(
    name="constant", doc="The same value everywhere; a plain number means the same.", role="curve",
    fields=(Field("value", NUMBER, VALUE, "the value"),),
    along_line=along(),
    pack=lambda values: [1, values["value"]],
    evaluate=polynomial, integral=polynomial_integral,
)  # fmt: skip

LINEAR = Term(
    name="linear", doc="y = slope s + offset.", role="curve",
    fields=(
        Field("slope", NUMBER, SLOPE, "slope"),
        Field("offset", NUMBER, VALUE, "value at the argument zero", 0.0),
    ),
    pack=lambda values: [2, values["offset"], values["slope"]],
    along_line=lambda values, slope, offset: {
        "slope": values["slope"] * slope,
        "offset": values["offset"] + values["slope"] * offset,
    },
    evaluate=polynomial, integral=polynomial_integral,
)  # fmt: skip

POLYNOMIAL = Term(
    name="polynomial", doc=f"y = c0 + c1 s + c2 s^2 + ..., s in the {ARGUMENT}.", role="curve",
    fields=(COEFFICIENTS,),
    pack=pack_polynomial,
    along_line=polynomial_along_line,
    evaluate=polynomial, integral=polynomial_integral, shape=shape_of_polynomial,
)  # fmt: skip

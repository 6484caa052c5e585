r"""Dual numbers :math:`a + \dot a\, \epsilon`, :math:`\epsilon^2 = 0`: a value and its derivative along a direction.

Computing with them instead of numbers gives exact derivatives by the chain rule. The slope is a number, or several
numbers, the derivatives along as many directions: Lanes in compiled code (jit/lanes.py), an array in Python.
"""

import math
import operator
from typing import NamedTuple

import numpy as np

from mecano.jit.methods import Generic, algebraic, method

NUMBER = float
TINY = 1e-150  # below this value, the slope of a root is taken as zero
DUAL = np.dtype([("value", "f8"), ("slope", "f8")], align=True)  # a stored Dual with one slope


@algebraic
class Dual(NamedTuple):
    """A value and its slope."""

    value: float
    slope: float


@method(operator.add, Dual, Dual)
def _(a, b):
    return Dual(a.value + b.value, a.slope + b.slope)


@method(operator.add, Dual, NUMBER)
def _(a, b):
    return Dual(a.value + b, a.slope)


@method(operator.add, NUMBER, Dual)
def _(a, b):
    return Dual(a + b.value, b.slope)


@method(operator.sub, Dual, Dual)
def _(a, b):
    return Dual(a.value - b.value, a.slope - b.slope)


@method(operator.sub, Dual, NUMBER)
def _(a, b):
    return Dual(a.value - b, a.slope)


@method(operator.sub, NUMBER, Dual)
def _(a, b):
    return Dual(a - b.value, -b.slope)


@method(operator.neg, Dual)
def _(a):
    return Dual(-a.value, -a.slope)


@method(operator.mul, Dual, Dual)
def _(a, b):
    return Dual(a.value * b.value, a.slope * b.value + b.slope * a.value)


@method(operator.mul, Dual, NUMBER)
def _(a, b):
    return Dual(a.value * b, a.slope * b)


@method(operator.mul, NUMBER, Dual)
def _(a, b):
    return Dual(a * b.value, b.slope * a)


@method(operator.truediv, Dual, Dual)
def _(a, b):
    inverse, quotient = 1.0 / b.value, a.value / b.value
    return Dual(quotient, (a.slope - b.slope * quotient) * inverse)


@method(operator.truediv, Dual, NUMBER)
def _(a, b):
    return Dual(a.value / b, a.slope * (1.0 / b))


@method(operator.truediv, NUMBER, Dual)
def _(a, b):
    quotient = a / b.value
    return Dual(quotient, b.slope * (-quotient / b.value))


def _comparison(compare):
    @method(compare, Dual, NUMBER)
    def _(a, b):
        return compare(a.value, b)

    @method(compare, NUMBER, Dual)
    def _(a, b):
        return compare(a, b.value)

    @method(compare, Dual, Dual)
    def _(a, b):
        return compare(a.value, b.value)


for _compare in (operator.lt, operator.le, operator.gt, operator.ge):
    _comparison(_compare)


@method(abs, Dual)
def _(a):
    return Dual(abs(a.value), a.slope * select(a.value > 0.0, 1.0, select(a.value < 0.0, -1.0, 0.0)))


@Generic
def number(a):
    """Return a number read from an array, as a Dual if compiled code reads a record."""
    return a


@method(number, Dual)
def _(a):
    return Dual(a.value, a.slope)


@Generic
def value(a):
    """Return a number without its slope."""
    return a


@method(value, Dual)
def _(a):
    return a.value


@Generic
def sqrt(a):
    """Return the square root; its slope at zero is taken as zero."""
    return math.sqrt(a)


@method(sqrt, Dual)
def _(a):
    root = sqrt(a.value)
    return Dual(root, a.slope * select(root > TINY, 0.5 / at_least(root, TINY), 0.0))


@Generic
def sin(a):
    """Return the sine."""
    return math.sin(a)


@method(sin, Dual)
def _(a):
    return Dual(sin(a.value), a.slope * cos(a.value))


@Generic
def cos(a):
    """Return the cosine."""
    return math.cos(a)


@method(cos, Dual)
def _(a):
    return Dual(cos(a.value), a.slope * -sin(a.value))


@Generic
def tan(a):
    """Return the tangent."""
    return math.tan(a)


@method(tan, Dual)
def _(a):
    y = tan(a.value)
    return Dual(y, a.slope * (1.0 + y * y))


@Generic
def exp(a):
    """Return the exponential."""
    return math.exp(a)


@method(exp, Dual)
def _(a):
    y = exp(a.value)
    return Dual(y, a.slope * y)


@Generic
def log(a):
    """Return the natural logarithm."""
    return math.log(a)


@method(log, Dual)
def _(a):
    return Dual(log(a.value), a.slope / a.value)


@Generic
def power(a, exponent):
    """Return a number that is not negative to the power of an ``exponent``, which has no slope.

    At zero the slope is that of the number 1e-150: zero for an exponent above 1.
    """
    return math.pow(a, exponent)


@method(power, Dual, NUMBER)
def _(a, exponent):
    return Dual(power(a.value, exponent), a.slope * (exponent * power(at_least(a.value, TINY), exponent - 1.0)))


@Generic
def atan2(a, b):
    """Return the angle of the point (b, a) in the plane."""
    return math.atan2(a, b)


@method(atan2, Dual, Dual)
def _(a, b):
    inverse = 1.0 / (a.value * a.value + b.value * b.value)
    return Dual(atan2(a.value, b.value), a.slope * (b.value * inverse) - b.slope * (a.value * inverse))


@method(atan2, Dual, NUMBER)
def _(a, b):
    return Dual(atan2(a.value, b), a.slope * (b / (a.value * a.value + b * b)))


@method(atan2, NUMBER, Dual)
def _(a, b):
    return Dual(atan2(a, b.value), b.slope * (-a / (a * a + b.value * b.value)))


@Generic
def constant(a, like):
    """Return a constant of the type of ``like``."""
    return a


@method(constant, NUMBER, Dual)
def _(a, like):
    return Dual(a, constant(0.0, like.slope))


@Generic
def chain(a, y, slope):
    """Return the value y of a function of ``a`` with derivative ``slope``; its slope follows by the chain rule."""
    return y


@method(chain, Dual, NUMBER, NUMBER)
def _(a, y, slope):
    return Dual(y, a.slope * slope)


@Generic
def implicit(root, residual, slope):
    """Return a ``root`` found numerically, with its slope by the implicit function theorem.

    ``residual`` is the equation at the root, with the slopes of all its arguments except the root; ``slope`` is its
    derivative with respect to the root.
    """
    return root


@method(implicit, NUMBER, Dual, NUMBER)
def _(root, residual, slope):
    return Dual(root, -residual.slope / slope)


@Generic
def select(condition, a, b):
    """Return ``a`` if the condition holds, else ``b``; both are evaluated."""
    return a if condition else b


@method(select, NUMBER, Dual, NUMBER)
def _(condition, a, b):
    return Dual(select(condition, a.value, b), select(condition, a.slope, 0.0))


@method(select, NUMBER, NUMBER, Dual)
def _(condition, a, b):
    return Dual(select(condition, a, b.value), select(condition, 0.0, b.slope))


@method(select, NUMBER, Dual, Dual)
def _(condition, a, b):
    return Dual(select(condition, a.value, b.value), select(condition, a.slope, b.slope))


@Generic
def everywhere(condition):
    """Return whether a condition holds for all elements that are computed at once."""
    return condition


@Generic
def anywhere(condition):
    """Return whether a condition holds for one of the elements that are computed at once."""
    return condition


@Generic
def at_least(a, least):
    """Return the larger of a number and a bound."""
    return select(a > least, a, least)


@Generic
def at_most(a, most):
    """Return the smaller of a number and a bound."""
    return select(a < most, a, most)

"""Vectors with operators and dual numbers: the same numbers in Python and compiled, derivatives against differences."""

import math
import operator

import numpy as np
import pytest

from mecano.jit import digest
from mecano.jit.entry import Vector, entry
from mecano.jit.kernel import kernel
from mecano.jit.methods import code_for, method
from mecano.maths.dual import Dual, atan2, chain, cos, exp, log, power, select, sin, sqrt, tan, value
from mecano.maths.vector import EYE, ZERO, Mat3, Vec3, cross, dot, mat, norm, outer, skew, vec

A, B = np.random.default_rng(1).normal(size=(2, 3, 3))
X, Y = np.random.default_rng(2).normal(size=(2, 3))


@kernel
def expression(x, y):
    """Something of every operator and function."""
    M = outer(x, y) - 2.0 * EYE + skew(x) / norm(y)
    z = M.T @ (x - y * dot(x, y)) + -cross(x, M @ y)
    s = sqrt(dot(z, z)) * exp(-x[0]) + sin(y[1]) / (2.0 + cos(x[2])) - atan2(x[1], y[2]) + log(power(x[0] * x[0], 1.5))
    return select(s > 1e3, s, s * s) + dot(z, (M @ M) @ x)


@entry
def compiled(x: Vector, x_1: Vector, y: Vector) -> (float, float, float):
    """The expression of numbers; its value and slope for x with the slopes ``x_1``."""
    seeded = Vec3(Dual(x[0], x_1[0]), Dual(x[1], x_1[1]), Dual(x[2], x_1[2]))
    found = expression(seeded, vec(y, 0))
    return expression(vec(x, 0), vec(y, 0)), found.value, found.slope


def seeded(x, direction):
    """A Vec3 of Duals."""
    return Vec3(*(Dual(*pair) for pair in zip(x.tolist(), direction.tolist(), strict=True)))


def test_operators_are_those_of_numpy():
    a, b, M, N = vec(X, 0), vec(Y, 0), mat(A), mat(B)
    for found, expected in (
        (a + b, X + Y), (a - b, X - Y), (-a, -X), (2.0 * a, 2.0 * X), (a * np.float64(2.0), 2.0 * X),
        (a / 3.0, X / 3.0),
        (np.float64(2.0) * M, 2.0 * A), (M + N, A + B), (M - N, A - B), (-M, -A), (M / 2.0, A / 2.0), (M @ a, A @ X),
        (M @ N, A @ B), (M.T, A.T), (cross(a, b), np.cross(X, Y)), (outer(a, b), np.outer(X, Y)),
        (skew(a) @ b, np.cross(X, Y)), (dot(a, b), X @ Y), (norm(a), np.linalg.norm(X)),
    ):  # fmt: skip
        np.testing.assert_allclose(np.array(found), expected, rtol=1e-14, atol=1e-14)


def test_python_and_compiled_code_agree_to_the_last_bit():
    found = compiled(X, Y, Y)
    python = expression(seeded(X, Y), vec(Y, 0))
    assert found == (expression(vec(X, 0), vec(Y, 0)), python.value, python.slope)
    assert python.value == found[0]


def test_slopes_are_derivatives():
    def along(h):
        return expression(vec(X + h * Y, 0), vec(Y, 0))

    h = 1e-3
    difference = (8.0 * (along(h) - along(-h)) - along(2.0 * h) + along(-2.0 * h)) / (12.0 * h)
    assert expression(seeded(X, Y), vec(Y, 0)).slope == pytest.approx(difference, rel=1e-8)


@pytest.mark.parametrize("compute", [
    lambda a: a + 1.0, lambda a: 1.0 + a, lambda a: a - 1.0, lambda a: 1.0 - a, lambda a: -a, lambda a: 3.0 * a,
    lambda a: a * 3.0, lambda a: a / 3.0, lambda a: 3.0 / a, lambda a: a * a, lambda a: (a + 1.0) / a, sqrt, sin, cos,
    exp, tan, log, abs, lambda a: power(a, 2.5), lambda a: power(a, -0.5), lambda a: abs(-a),
    lambda a: atan2(a, 2.0), lambda a: atan2(2.0, a),
    lambda a: atan2(a, a * a), lambda a: a - a * a, lambda a: chain(a, value(a) ** 3, 3.0 * value(a) ** 2),
    lambda a: select(a > 0.5, a * a, 7.0), lambda a: select(a < 0.5, 7.0, a), lambda a: select(0.5 <= a, a, a * a),
])  # fmt: skip
def test_each_rule_of_dual_numbers(compute):
    h, found = 1e-5, compute(Dual(0.7, 1.0))
    assert found.value == compute(0.7)
    assert found.slope == pytest.approx((compute(0.7 + h) - compute(0.7 - h)) / (2.0 * h), rel=1e-8)


def test_the_root_of_zero_has_no_slope():
    assert norm(Vec3(Dual(0.0, 1.0), Dual(0.0, 2.0), Dual(0.0, 3.0))) == Dual(0.0, 0.0)


@pytest.mark.parametrize(("exponent", "slope"), [(1.0, 2.0), (1.5, 0.0), (2.0, 0.0)])
def test_the_power_of_zero_has_the_slope_of_its_limit(exponent, slope):
    found = power(Dual(0.0, 2.0), exponent)
    assert found.value == 0.0 and found.slope == pytest.approx(slope, abs=1e-60)


def test_what_is_not_defined_is_an_error():
    with pytest.raises(TypeError):
        ZERO + 1.0
    with pytest.raises(TypeError):
        mat(A) * vec(X, 0)


def test_a_changed_method_changes_the_digests_of_its_callers():
    """An object is found in the store by a digest of all it is made of, operators among it."""
    key, add = (Vec3, Vec3), code_for(operator.add, (Vec3, Vec3))
    before = digest.digest(expression.__wrapped__)

    def forget():
        digest._digests.clear()
        digest._describe_methods.cache_clear()

    forget()
    assert digest.digest(expression.__wrapped__) == before
    try:
        other = method(operator.add, *key)(lambda a, b: Vec3(a[0] + b[1], a[1] + b[0], a[2] + b[2]))
        other.__module__ = add.__module__
        forget()
        assert digest.digest(expression.__wrapped__) != before
    finally:
        method(operator.add, *key)(add)
        forget()
    assert digest.digest(expression.__wrapped__) == before
    assert isinstance(mat(A), Mat3) and math.isfinite(expression(vec(X, 0), vec(Y, 0)))

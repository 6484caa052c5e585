"""Rotations against matrix exponentials, power series and differences, from tiny angles to beyond pi."""

import math

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from mecano.maths import so3
from mecano.maths.dual import Dual
from mecano.maths.vector import Mat3, Vec3, mat, skew, vec

RNG = np.random.default_rng(7)
AXES = [axis / np.linalg.norm(axis) for axis in RNG.normal(size=(4, 3))] + list(np.eye(3))
SWITCH = so3.SERIES
TINY = [0.0, 1e-160, 1e-9, 1e-5]
AT_SWITCH = [SWITCH * (1.0 - 1e-12), SWITCH * (1.0 + 1e-12), 1.5 * SWITCH]
NEAR_PI = [math.pi - 1e-3, math.pi - 1e-8, math.pi - 1e-13]
ANGLES = [*TINY, *AT_SWITCH, 0.3, 2.0, *NEAR_PI]
UP_TO_ROUNDING = 1e-14

every_angle = pytest.mark.parametrize("angle", ANGLES)
every_axis = pytest.mark.parametrize("axis", AXES, ids=range(len(AXES)))


def hat(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def series(psi, terms=60):
    """T = sum (-H)^k/(k + 1)!, the definition of the tangent operator."""
    H, term, total = hat(psi), np.eye(3), np.eye(3)
    for k in range(1, terms):
        term = -term @ H / (k + 1)
        total = total + term
    return total


def difference(function, h):
    near, far = (np.asarray(function(s)) - np.asarray(function(-s)) for s in (h, 2.0 * h))
    return (8.0 * near - far) / (12.0 * h)


@every_axis
@every_angle
def test_exp_is_the_matrix_exponential(axis, angle):
    R = np.array(so3.exp(vec(angle * axis, 0)))
    np.testing.assert_allclose(R, expm(hat(angle * axis)), rtol=0, atol=UP_TO_ROUNDING)
    np.testing.assert_allclose(R.T @ R, np.eye(3), rtol=0, atol=UP_TO_ROUNDING)


def test_a_small_rotation_is_not_rounded_away():
    R = np.array(so3.exp(Vec3(1e-11, -2e-12, 3e-13)))
    np.testing.assert_allclose(R - R.T, 2.0 * hat((1e-11, -2e-12, 3e-13)), rtol=1e-14, atol=0)


@every_axis
@every_angle
def test_log_is_the_inverse_of_exp(axis, angle):
    psi = so3.log(so3.exp(vec(angle * axis, 0)))
    np.testing.assert_allclose(psi, angle * axis, rtol=0, atol=4e-15 * angle)


@every_axis
def test_log_at_half_a_turn(axis):
    R = 2.0 * np.outer(axis, axis) - np.eye(3)
    psi = np.array(so3.log(mat(R)))
    assert np.linalg.norm(psi) == pytest.approx(math.pi, abs=1e-14)
    np.testing.assert_allclose(np.abs(psi @ axis), math.pi, rtol=0, atol=1e-14)
    np.testing.assert_allclose(so3.exp(vec(psi, 0)), R, rtol=0, atol=UP_TO_ROUNDING)


@every_axis
def test_log_is_the_shorter_way(axis):
    np.testing.assert_allclose(
        so3.log(so3.exp(vec(4.0 * axis, 0))), (4.0 - 2.0 * math.pi) * axis, rtol=0, atol=UP_TO_ROUNDING
    )


def test_quaternion_has_a_positive_real_part():
    for rotation in Rotation.random(50, RNG):
        w, x, y, z = so3.quaternion(mat(rotation.as_matrix()))
        np.testing.assert_allclose((x, y, z, w), rotation.as_quat(canonical=True), rtol=0, atol=UP_TO_ROUNDING)


@every_axis
@every_angle
def test_tangent_agrees_with_its_series(axis, angle):
    T = so3.tangent(vec(angle * axis, 0))
    np.testing.assert_allclose(T, series(angle * axis), rtol=0, atol=UP_TO_ROUNDING)


@every_axis
@pytest.mark.parametrize("angle", [0.0, SWITCH, 0.3, 2.0, 3.0])
def test_tangent_gives_the_material_variation(axis, angle):
    psi, d = angle * axis, AXES[0] + AXES[1]
    R = np.array(so3.exp(vec(psi, 0)))
    expected = difference(lambda h: so3.log(mat(R.T @ np.array(so3.exp(vec(psi + h * d, 0))))), 1e-3)
    np.testing.assert_allclose(np.array(so3.tangent(vec(psi, 0))) @ d, expected, rtol=0, atol=1e-10)


@every_axis
@every_angle
def test_tangent_inverse(axis, angle):
    psi = vec(angle * axis, 0)
    product = np.array(so3.tangent_inverse(psi)) @ np.array(so3.tangent(psi))
    np.testing.assert_allclose(product, np.eye(3), rtol=0, atol=UP_TO_ROUNDING)


@pytest.mark.parametrize("name", ["s", "c", "b"])
def test_both_branches_agree_at_the_switch(name):
    i = "scb".index(name)
    below, above = (so3.coefficients((SWITCH * f) ** 2)[i] for f in (1.0 - 1e-13, 1.0 + 1e-13))
    # b enters the operators times the square of the angle
    weight = SWITCH**2 if name == "b" else 1.0
    assert abs(below - above) * weight < UP_TO_ROUNDING


@every_axis
@pytest.mark.parametrize("angle", [0.0, *TINY, *AT_SWITCH, 0.3, 2.0, 3.0])
@pytest.mark.parametrize("function", [so3.exp, so3.tangent, so3.tangent_inverse])
def test_slopes_by_dual_numbers_against_differences(axis, angle, function):
    psi, d = angle * axis, np.array([0.3, -1.2, 0.7])
    seeded = Vec3(*(Dual(*pair) for pair in zip(psi.tolist(), d.tolist(), strict=True)))
    slopes = [[entry.slope for entry in row] for row in function(seeded)]
    expected = difference(lambda h: function(vec(psi + h * d, 0)), 1e-3)
    np.testing.assert_allclose(slopes, expected, rtol=0, atol=1e-10)


@every_axis
@pytest.mark.parametrize("angle", [1e-9, SWITCH, 0.3, 2.0, 3.1])
def test_the_slope_of_the_logarithm_is_the_inverse_tangent(axis, angle):
    psi, spin = vec(angle * axis, 0), Vec3(0.3, -1.2, 0.7)
    R = so3.exp(psi)
    change = R @ skew(spin)
    seeded = Mat3(*(Vec3(*(Dual(*pair) for pair in zip(*rows, strict=True))) for rows in zip(R, change, strict=True)))
    found = so3.log(seeded)
    np.testing.assert_allclose([x.value for x in found], psi, rtol=0, atol=UP_TO_ROUNDING)
    np.testing.assert_allclose([x.slope for x in found], so3.tangent_inverse(psi) @ spin, rtol=0, atol=1e-9)

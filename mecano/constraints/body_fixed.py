r"""Scalar product of two vectors fixed in nodes, and angles between nodes over whole turns.

For m fixed in node 0 and s in node 1 (material components), with :math:`A = R_0^T R_1`, the product
:math:`(R_0 m) \cdot (R_1 s)` has, in material variations, the gradients

.. math::  b_0 = m \times A s, \qquad b_1 = s \times A^T m,

which in inertial axes are :math:`\mu \times \xi` and :math:`-\mu \times \xi`. Their own derivatives are not symmetric.
"""

import math

from mecano.jit.kernel import kernel
from mecano.maths.dual import value
from mecano.maths.vector import add_mat, cross, dot, mat, skew


@kernel
def product_gradient(A, m, s):
    """Return the gradients (b_0, b_1) of (R_0 m) . (R_1 s) by the material variations of both nodes."""
    return cross(m, A @ s), cross(s, A.T @ m)


@kernel
def product_curvature(A, m, s):
    """Return ((H_00, H_01), (H_10, H_11)): derivatives of b_i by the material rotation of node j, not symmetric."""
    hat_m, hat_s = skew(m), skew(s)
    H_00 = hat_m @ skew(A @ s)
    H_01 = -(hat_m @ (A @ hat_s))
    H_10 = -(hat_s @ (A.T @ hat_m))
    return (H_00, H_01), (H_10, hat_s @ skew(A.T @ m))


@kernel
def turning_rate(gradient, omega_0, omega_1):
    """Return the rate of a function of the relative rotation from its gradients and material angular velocities."""
    return dot(gradient[0], omega_0) + dot(gradient[1], omega_1)


@kernel
def whole_turns(previous, angle):
    """Return the whole turns [rad] that bring an angle [rad] closest to ``previous``.

    A constraint that adds angles of many turns adds their whole turns first: they do not change in an iteration, and
    the angles within a turn are not rounded to the last digit of the large ones.
    """
    return -2.0 * math.pi * math.ceil((value(angle) - previous) / (2.0 * math.pi) - 0.5)


@kernel
def wrap(angle):
    """Return the angle [rad] reduced to (-pi, pi] by whole turns."""
    return angle + whole_turns(0.0, angle)


@kernel
def follow(previous, angle):
    """Return the angle [rad] plus the whole turns that bring it closest to ``previous``."""
    return previous + wrap(angle - previous)


@kernel
def relative_rotation(at):
    """Return R_0^T R_1 of the first two rotations of an element."""
    return mat(at.R[0]).T @ mat(at.R[1])


@kernel
def add_blocks(K, i, j, s, H):
    """Add s ((H_00, H_01), (H_10, H_11)) to K; i, j are the local indices of two rotations."""
    add_mat(K, i, i, s, H[0][0])
    add_mat(K, i, j, s, H[0][1])
    add_mat(K, j, i, s, H[1][0])
    add_mat(K, j, j, s, H[1][1])

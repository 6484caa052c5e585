r"""Vectors carried by nodes: their rates, the product of two of them, the angle of two triads.

For m carried by node 0 and s by node 1 (material components), with :math:`A = R_0^T R_1`, the product
:math:`(R_0 m) \cdot (R_1 s)` has, in material variations, the gradients

.. math::  b_0 = m \times A s, \qquad b_1 = s \times A^T m,

which in inertial axes are :math:`\mu \times \xi` and :math:`-\mu \times \xi`. Their own derivatives are not symmetric.
"""

import math

from mecano.compiled.kernel import kernel
from mecano.maths.dual import atan2, value
from mecano.maths.vector import add_mat, cross, dot, outer, skew


@kernel
def carried(R, omega, alpha, m):
    """R m and its first and second rate, inertial; omega, alpha material angular velocity and acceleration."""
    spin = cross(omega, m)
    return R @ m, R @ spin, R @ (cross(alpha, m) + cross(omega, spin))


@kernel
def product_rates(u, w):
    """u . w and its first two rates for two vectors given with theirs."""
    value, rate = dot(u[0], w[0]), dot(u[1], w[0]) + dot(u[0], w[1])
    return value, rate, dot(u[2], w[0]) + 2.0 * dot(u[1], w[1]) + dot(u[0], w[2])


@kernel
def product_gradient(A, m, s):
    """Gradients (b_0, b_1) of (R_0 m) . (R_1 s) by the material variations of both nodes."""
    return cross(m, A @ s), cross(s, A.T @ m)


@kernel
def product_curvature(A, m, s):
    """((H_00, H_01), (H_10, H_11)): derivative of b_i by the material rotation of node j, not symmetric."""
    hat_m, hat_s = skew(m), skew(s)
    H_00 = hat_m @ skew(A @ s)
    H_01 = -(hat_m @ (A @ hat_s))
    H_10 = -(hat_s @ (A.T @ hat_m))
    return (H_00, H_01), (H_10, hat_s @ skew(A.T @ m))


@kernel
def twist(A, mu, xi):
    """Angle of node 1 about mu_3 relative to node 0, in (-pi, pi] [rad].

    ``mu`` and ``xi`` are the unit axes of the nodes (rows, material). It does not depend on which mu_1 is chosen, and
    where mu_3 and xi_3 differ it is that part of the relative rotation which is left when the smallest rotation that
    turns mu_3 into xi_3 is taken off.
    """
    X, Y = A @ xi[0], A @ xi[1]
    return atan2(dot(mu[1], X) - dot(mu[0], Y), dot(mu[0], X) + dot(mu[1], Y))


@kernel
def twist_gradient(A, mu_3, xi_3):
    """Gradients (-G_0, G_1) of the angle; G_0 and G_1 are (mu_3 + xi_3)/(1 + mu_3 . xi_3), material."""
    xi, mu = A @ xi_3, A.T @ mu_3
    size = 1.0 / (1.0 + dot(mu_3, xi))
    return -size * (mu_3 + xi), size * (mu + xi_3)


@kernel
def twist_curvature(A, mu_3, xi_3):
    """((H_00, H_01), (H_10, H_11)): derivative of gradient i by the material rotation of node j, not symmetric."""
    xi, mu = A @ xi_3, A.T @ mu_3
    size = 1.0 / (1.0 + dot(mu_3, xi))
    b_0, b_1 = -size * (mu_3 + xi), size * (mu + xi_3)
    by_0, by_1 = -size * cross(mu_3, xi), -size * cross(xi_3, mu)
    H_00 = -size * skew(xi) + outer(b_0, by_0)
    H_01 = size * (A @ skew(xi_3)) + outer(b_0, by_1)
    H_10 = -size * (A.T @ skew(mu_3)) + outer(b_1, by_0)
    H_11 = size * skew(mu) + outer(b_1, by_1)
    return (H_00, H_01), (H_10, H_11)


@kernel
def turning_rate(gradient, omega_0, omega_1):
    """Rate of a quantity of the relative rotation, from its gradients and the material angular velocities."""
    return dot(gradient[0], omega_0) + dot(gradient[1], omega_1)


@kernel
def turned(R_0, omega_0, mu, R_1, omega_1, xi):
    """The angle of ``twist`` [rad] and its rate [rad/s] from rotations and material angular velocities."""
    A = relative_rotation(R_0, R_1)
    return twist(A, mu, xi), turning_rate(twist_gradient(A, mu[2], xi[2]), omega_0, omega_1)


@kernel
def wrap(angle):
    """The angle brought to (-pi, pi] by whole turns [rad]."""
    return angle - 2.0 * math.pi * math.ceil(value(angle) / (2.0 * math.pi) - 0.5)


@kernel
def follow(previous, angle):
    """The angle plus the whole turns that bring it nearest to ``previous`` [rad]."""
    return previous + wrap(angle - previous)


@kernel
def relative_rotation(R_0, R_1):
    """R_0^T R_1"""
    return R_0.T @ R_1


@kernel
def add_blocks(K, i, j, s, H):
    """Add s ((H_00, H_01), (H_10, H_11)) to K; i, j are the local indices of two rotations."""
    add_mat(K, i, i, s, H[0][0])
    add_mat(K, i, j, s, H[0][1])
    add_mat(K, j, i, s, H[1][0])
    add_mat(K, j, j, s, H[1][1])

r"""Vectors carried by nodes: their rates, the product of two of them, the angle of two triads.

For m carried by node 0 and s by node 1 (material components), with :math:`A = R_0^T R_1`, the product
:math:`(R_0 m) \cdot (R_1 s)` has, in material variations, the gradients

.. math::  b_0 = m \times A s, \qquad b_1 = s \times A^T m,

which in inertial axes are :math:`\mu \times \xi` and :math:`-\mu \times \xi`. Their own derivatives are not symmetric.
"""

import math

from numba import njit

from mecano.maths.vec import (
    ZERO,
    add,
    add_mat,
    cross,
    dot,
    matmul,
    mul,
    outer,
    scale,
    skew,
    sub,
    tmul,
    transpose,
)


@njit
def carried(R, omega, alpha, m):
    """R m and its first and second rate, inertial; omega, alpha material angular velocity and acceleration."""
    spin = cross(omega, m)
    return mul(R, m), mul(R, spin), mul(R, add(cross(alpha, m), cross(omega, spin)))


@njit
def product_rates(u, w):
    """u . w and its first two rates for two vectors given with theirs."""
    value, rate = dot(u[0], w[0]), dot(u[1], w[0]) + dot(u[0], w[1])
    return value, rate, dot(u[2], w[0]) + 2.0 * dot(u[1], w[1]) + dot(u[0], w[2])


@njit
def product_gradient(A, m, s):
    """Gradients (b_0, b_1) of (R_0 m) . (R_1 s) by the material variations of both nodes."""
    return cross(m, mul(A, s)), cross(s, tmul(A, m))


@njit
def add_product_curvature(K, i, j, g, A, m, s):
    """Add g times the derivative of (b_0, b_1) to K; i, j are the local indices of the two rotations."""
    hat_m, hat_s = skew(m), skew(s)
    add_mat(K, i, i, g, matmul(hat_m, skew(mul(A, s))))
    add_mat(K, i, j, -g, matmul(hat_m, matmul(A, hat_s)))
    add_mat(K, j, j, g, matmul(hat_s, skew(tmul(A, m))))
    add_mat(K, j, i, -g, matmul(hat_s, matmul(transpose(A), hat_m)))


@njit
def twist(A, mu, xi):
    """Angle of node 1 about mu_3 relative to node 0, in (-pi, pi], and the vectors c, h that make its gradient.

    ``mu`` and ``xi`` are the axes of the nodes (rows, material). The angle is the argument of u + i w with
    u = mu_1 . xi_1 + mu_2 . xi_2, w = mu_2 . xi_1 - mu_1 . xi_2: it does not depend on which mu_1 is chosen, and where
    mu_3 and xi_3 differ it is twice the argument of the quaternion's parts along mu_3.
    """
    X, Y = mul(A, xi[0]), mul(A, xi[1])
    u, w = dot(mu[0], X) + dot(mu[1], Y), dot(mu[1], X) - dot(mu[0], Y)
    size = 1.0 / (u * u + w * w)
    c = scale(size, sub(scale(u, mu[1]), scale(w, mu[0])))
    return math.atan2(w, u), c, scale(size, add(scale(u, mu[0]), scale(w, mu[1])))


@njit
def twist_gradient(A, c, h, xi):
    """Gradients of the angle, (b_0, b_1), and of log |u + i w|, (h_0, h_1); c and h from ``twist``."""
    c_1, c_2 = product_gradient(A, c, xi[0]), product_gradient(A, c, xi[1])
    h_1, h_2 = product_gradient(A, h, xi[0]), product_gradient(A, h, xi[1])
    return (sub(c_1[0], h_2[0]), sub(c_1[1], h_2[1])), (add(h_1[0], c_2[0]), add(h_1[1], c_2[1]))


@njit
def add_twist_curvature(K, g, A, c, h, xi):
    """Add g times the derivative of (b_0, b_1) to K; the rotations are the first two slots.

    Of the second derivative of log z it is the imaginary part: -(b h^T + h b^T) and the curvature of u + i w.
    """
    add_product_curvature(K, 0, 3, g, A, c, xi[0])
    add_product_curvature(K, 0, 3, -g, A, h, xi[1])
    b_blocks, h_blocks = twist_gradient(A, c, h, xi)
    for i in range(2):
        for j in range(2):
            add_mat(K, 3 * i, 3 * j, -g, outer(b_blocks[i], h_blocks[j]))
            add_mat(K, 3 * i, 3 * j, -g, outer(h_blocks[i], b_blocks[j]))


@njit
def argument_rates(u, w):
    """Argument of u + i w in (-pi, pi] and its first two rates; u and w are given with theirs."""
    size = u[0] * u[0] + w[0] * w[0]
    rate = (u[0] * w[1] - w[0] * u[1]) / size
    second = (u[0] * w[2] - w[0] * u[2]) / size - 2.0 * rate * (u[0] * u[1] + w[0] * w[1]) / size
    return math.atan2(w[0], u[0]), rate, second


@njit
def twist_rates(mu_1, mu_2, xi_1, xi_2):
    """The angle of ``twist`` and its first two rates; vectors given with theirs."""
    u = product_rates(mu_1, xi_1), product_rates(mu_2, xi_2)
    w = product_rates(mu_2, xi_1), product_rates(mu_1, xi_2)
    return argument_rates(add(u[0], u[1]), sub(w[0], w[1]))


@njit
def turned(R_0, omega_0, mu, R_1, omega_1, xi):
    """The angle of ``twist`` [rad] and its rate [rad/s] from rotations and material angular velocities."""
    mu_1, mu_2 = carried(R_0, omega_0, ZERO, mu[0]), carried(R_0, omega_0, ZERO, mu[1])
    xi_1, xi_2 = carried(R_1, omega_1, ZERO, xi[0]), carried(R_1, omega_1, ZERO, xi[1])
    angle, rate, _ = twist_rates(mu_1, mu_2, xi_1, xi_2)
    return angle, rate


@njit
def wrap(angle):
    """The angle brought to (-pi, pi] by whole turns [rad]."""
    return angle - 2.0 * math.pi * math.ceil(angle / (2.0 * math.pi) - 0.5)


@njit
def follow(previous, angle):
    """The angle plus the whole turns that bring it nearest to ``previous`` [rad]."""
    return previous + wrap(angle - previous)


@njit
def relative_rotation(R_0, R_1):
    """R_0^T R_1"""
    return matmul(transpose(R_0), R_1)

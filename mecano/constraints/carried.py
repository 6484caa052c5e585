r"""Vectors carried by nodes: their rates, the product of two of them, the angle between them.

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
def angle_gradient(A, m_1, m_2, s):
    """Angle of s from m_1 towards m_2, the vectors c, c_h of node 0 that make its gradient and curvature.

    The angle is the argument of u + i w with u = mu_1 . xi, w = mu_2 . xi. Its gradient is that of a product with
    c = (u m_2 - w m_1)/(u^2 + w^2) held constant; c_h = (u m_1 + w m_2)/(u^2 + w^2) gives that of log |u + i w|.
    """
    S = mul(A, s)
    u, w = dot(m_1, S), dot(m_2, S)
    size = 1.0 / (u * u + w * w)
    c = scale(size, sub(scale(u, m_2), scale(w, m_1)))
    return math.atan2(w, u), c, scale(size, add(scale(u, m_1), scale(w, m_2)))


@njit
def add_angle_curvature(K, i, j, g, A, c, c_h, s):
    """Add g times the derivative of the gradient of the angle: with dlog z = h + i b, its part -(b h^T + h b^T)."""
    add_product_curvature(K, i, j, g, A, c, s)
    b, h = product_gradient(A, c, s), product_gradient(A, c_h, s)
    for r in range(2):
        for q in range(2):
            row, column = (i, j)[r], (i, j)[q]
            add_mat(K, row, column, -g, outer(b[r], h[q]))
            add_mat(K, row, column, -g, outer(h[r], b[q]))


@njit
def angle_rates(mu_1, mu_2, xi):
    """Angle of xi from mu_1 towards mu_2 in (-pi, pi] and its first two rates; vectors given with their rates."""
    u, u1, u2 = product_rates(mu_1, xi)
    w, w1, w2 = product_rates(mu_2, xi)
    size = u * u + w * w
    rate = (u * w1 - w * u1) / size
    second = (u * w2 - w * u2) / size - 2.0 * rate * (u * u1 + w * w1) / size
    return math.atan2(w, u), rate, second


@njit
def turned(R_0, omega_0, mu, R_1, omega_1, xi):
    """Angle in (-pi, pi] of node 1 about mu_3 relative to node 0, and its rate [rad, rad/s].

    ``mu`` are the three axes carried by node 0 (rows), xi is carried by node 1 and started along mu_1.
    """
    mu_1, mu_2 = carried(R_0, omega_0, ZERO, mu[0]), carried(R_0, omega_0, ZERO, mu[1])
    angle, rate, _ = angle_rates(mu_1, mu_2, carried(R_1, omega_1, ZERO, xi))
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

r"""Angle of a pin carried by the second node, about the axis :math:`\mu_3` carried by the first.

With :math:`u = \mu_1 \cdot \xi` and :math:`w = \mu_2 \cdot \xi` the angle is :math:`\mathrm{atan2}(w, u)`, with
the gradient :math:`(u \nabla w - w \nabla u)/(u^2 + w^2)`: how far the cross of a universal joint has turned.
"""

import math

from mecano.compiled.kernel import kernel
from mecano.constraints.carried import product_curvature, product_gradient
from mecano.maths.vector import dot, outer


@kernel
def pin_angle(A, mu, xi):
    """Angle [rad] in (-pi, pi]; A = R_0^T R_1, mu (3, 3) rows, xi (3,) material."""
    pin = A @ xi
    return math.atan2(dot(mu[1], pin), dot(mu[0], pin))


@kernel
def pin_gradient(A, mu, xi):
    """Gradients (b_0, b_1) of the angle by the material variations of both nodes."""
    pin = A @ xi
    u, w = dot(mu[0], pin), dot(mu[1], pin)
    by_u, by_w = product_gradient(A, mu[0], xi), product_gradient(A, mu[1], xi)
    inverse = 1.0 / (u * u + w * w)
    b_0 = u * inverse * by_w[0] - w * inverse * by_u[0]
    return b_0, u * inverse * by_w[1] - w * inverse * by_u[1]


@kernel
def pin_curvature(A, mu, xi):
    """((H_00, H_01), (H_10, H_11)): derivative of b_i by the material rotation of node j, not symmetric."""
    pin = A @ xi
    u, w = dot(mu[0], pin), dot(mu[1], pin)
    by_u, by_w = product_gradient(A, mu[0], xi), product_gradient(A, mu[1], xi)
    H_u, H_w = product_curvature(A, mu[0], xi), product_curvature(A, mu[1], xi)
    b, inverse = pin_gradient(A, mu, xi), 1.0 / (u * u + w * w)
    return (
        (_entry(u, w, inverse, b, by_u, by_w, H_u, H_w, 0, 0), _entry(u, w, inverse, b, by_u, by_w, H_u, H_w, 0, 1)),
        (_entry(u, w, inverse, b, by_u, by_w, H_u, H_w, 1, 0), _entry(u, w, inverse, b, by_u, by_w, H_u, H_w, 1, 1)),
    )


@kernel
def _entry(u, w, inverse, b, by_u, by_w, H_u, H_w, i, j):
    """H_ij from the numerator u grad w - w grad u and the denominator u^2 + w^2."""
    crossed = outer(by_w[i], by_u[j]) - outer(by_u[i], by_w[j])
    bent = u * H_w[i][j] - w * H_u[i][j]
    grown = 2.0 * u * by_u[j] + 2.0 * w * by_w[j]
    return inverse * (crossed + bent - outer(b[i], grown))

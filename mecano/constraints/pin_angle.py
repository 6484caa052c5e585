r"""Angle of a pin carried by the second node, about the axis :math:`\mu_3` carried by the first.

With :math:`u = \mu_1 \cdot \xi` and :math:`w = \mu_2 \cdot \xi` the angle is :math:`\mathrm{atan2}(w, u)`, with
the gradient :math:`(u \nabla w - w \nabla u)/(u^2 + w^2)`: how far the cross of a universal joint has turned.
"""

from mecano.compiled.kernel import kernel
from mecano.constraints.carried import product_gradient
from mecano.maths.dual import atan2
from mecano.maths.vector import dot


@kernel
def pin_angle(A, mu, xi):
    """Angle [rad] in (-pi, pi]; A = R_0^T R_1, mu (3, 3) rows, xi (3,) material."""
    pin = A @ xi
    return atan2(dot(mu[1], pin), dot(mu[0], pin))


@kernel
def pin_gradient(A, mu, xi):
    """Gradients (b_0, b_1) of the angle by the material variations of both nodes."""
    pin = A @ xi
    u, w = dot(mu[0], pin), dot(mu[1], pin)
    by_u, by_w = product_gradient(A, mu[0], xi), product_gradient(A, mu[1], xi)
    inverse = 1.0 / (u * u + w * w)
    b_0 = u * inverse * by_w[0] - w * inverse * by_u[0]
    return b_0, u * inverse * by_w[1] - w * inverse * by_u[1]

r"""Angle of a pin fixed in the second node, about the axis :math:`\mu_3` fixed in the first.

With :math:`u = \mu_1 \cdot \xi` and :math:`w = \mu_2 \cdot \xi` the angle is :math:`\mathrm{atan2}(w, u)`, with
the gradient :math:`(u \nabla w - w \nabla u)/(u^2 + w^2)`: the rotation of the cross of a universal joint.
"""

from mecano.constraints.body_fixed import product_gradient, relative_rotation
from mecano.constraints.coordinates.coordinate import Coordinate
from mecano.jit.kernel import kernel
from mecano.maths.dual import atan2
from mecano.maths.vector import dot, mat, vec


@kernel
def pin_angle(A, mu, xi):
    """Return the angle [rad] in (-pi, pi]; A = R_0^T R_1, mu (3, 3) rows, xi (3,) material."""
    pin = A @ xi
    return atan2(dot(mu[1], pin), dot(mu[0], pin))


@kernel
def pin_gradient(A, mu, xi):
    """Return the gradients (b_0, b_1) of the angle by the material variations of both nodes."""
    pin = A @ xi
    u, w = dot(mu[0], pin), dot(mu[1], pin)
    by_u, by_w = product_gradient(A, mu[0], xi), product_gradient(A, mu[1], xi)
    inverse = 1.0 / (u * u + w * w)
    b_0 = u * inverse * by_w[0] - w * inverse * by_u[0]
    return b_0, u * inverse * by_w[1] - w * inverse * by_u[1]


@kernel
def _value(p, at):
    return pin_angle(relative_rotation(at), mat(p.mu), vec(p.xi, 0))


@kernel
def _gradient(p, at):
    b_0, b_1 = pin_gradient(relative_rotation(at), mat(p.mu), vec(p.xi, 0))
    return (0, b_0), (3, b_1)


PIN_ANGLE = Coordinate(("R0", "R1"), "rad", {"mu": (3, 3), "xi": 3}, _value, _gradient, periodic=True)

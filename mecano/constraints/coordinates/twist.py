r"""Twist: the angle of the second node about an axis, relative to the first.

Axes :math:`\mu_i` are fixed in the first node, :math:`\xi_i` in the second; initially they coincide. With Q the
rotation of the second triad in the first,

.. math::  \theta = \mathrm{atan2}(Q_{21} - Q_{12},\; Q_{11} + Q_{22}),

the rotation about :math:`\mu_3` where :math:`\xi_3 = \mu_3`, smooth and symmetric in both nodes away from that
alignment, up to :math:`\xi_3 = -\mu_3`. With :math:`g = (\mu_3 + \xi_3)/(1 + \mu_3 \cdot \xi_3)`, inertial, its rate is
:math:`\dot\theta = g \cdot (\omega_1 - \omega_0)`. The derivative of g does not vanish even where the axes are aligned.
"""

from mecano.constraints.body_fixed import add_blocks, relative_rotation, turning_rate
from mecano.constraints.coordinates.coordinate import Coordinate
from mecano.jit.kernel import kernel
from mecano.maths.dual import atan2
from mecano.maths.vector import cross, dot, mat, outer, skew, vec


@kernel
def twist(A, mu, xi):
    """Return the angle of node 1 about mu_3 relative to node 0, in (-pi, pi] [rad].

    ``mu`` and ``xi`` are the unit axes of the nodes (rows, material). The angle does not depend on the choice of mu_1.
    If mu_3 and xi_3 differ, it is the part of the relative rotation that remains after removing the smallest rotation
    from mu_3 to xi_3.
    """
    X, Y = A @ xi[0], A @ xi[1]
    return atan2(dot(mu[1], X) - dot(mu[0], Y), dot(mu[0], X) + dot(mu[1], Y))


@kernel
def twist_gradient(A, mu_3, xi_3):
    """Return the gradients (-G_0, G_1) of the angle; G_0 and G_1 are (mu_3 + xi_3)/(1 + mu_3 . xi_3), material."""
    xi, mu = A @ xi_3, A.T @ mu_3
    size = 1.0 / (1.0 + dot(mu_3, xi))
    return -size * (mu_3 + xi), size * (mu + xi_3)


@kernel
def twist_curvature(A, mu_3, xi_3):
    """Return ((H_00, H_01), (H_10, H_11)): derivative of gradient i by material rotation of node j, not symmetric."""
    xi, mu = A @ xi_3, A.T @ mu_3
    size = 1.0 / (1.0 + dot(mu_3, xi))
    b_0, b_1 = twist_gradient(A, mu_3, xi_3)
    by_0, by_1 = -size * cross(mu_3, xi), -size * cross(xi_3, mu)
    H_00 = -size * skew(xi) + outer(b_0, by_0)
    H_01 = size * (A @ skew(xi_3)) + outer(b_0, by_1)
    H_10 = -size * (A.T @ skew(mu_3)) + outer(b_1, by_0)
    H_11 = size * skew(mu) + outer(b_1, by_1)
    return (H_00, H_01), (H_10, H_11)


@kernel
def turned(p, at):
    """Return the angle [rad] and its rate [rad/s] of two nodes with the local unknowns x0, R0, x1, R1."""
    A, mu, xi = relative_rotation(at), mat(p.mu), mat(p.xi)
    return twist(A, mu, xi), turning_rate(twist_gradient(A, mu[2], xi[2]), vec(at.v, 3), vec(at.v, 9))


@kernel
def _value(p, at):
    return twist(relative_rotation(at), mat(p.mu), mat(p.xi))


@kernel
def _gradient(p, at):
    A = relative_rotation(at)
    b_0, b_1 = twist_gradient(A, vec(p.mu[2], 0), vec(p.xi[2], 0))
    return (0, b_0), (3, b_1)


@kernel
def _add_curvature(p, at, g, K):
    A = relative_rotation(at)
    add_blocks(K, 0, 3, g, twist_curvature(A, vec(p.mu[2], 0), vec(p.xi[2], 0)))


TWIST = Coordinate(("R0", "R1"), "rad", {"mu": (3, 3), "xi": (3, 3)}, _value, _gradient, _add_curvature, periodic=True)

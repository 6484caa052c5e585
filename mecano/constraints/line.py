r"""The line between two nodes, and a force along it.

With :math:`d = x_1 - x_0`, the length :math:`\ell = |d|` and :math:`u = d/\ell`, a force N that pulls the nodes
together gives :math:`f_1 = -f_0 = N u`. With :math:`P = I - u u^T` and :math:`w = P (v_1 - v_0)/\ell` the tangents of
:math:`f_1` by :math:`d` and :math:`\dot d` are

.. math::  K = u\,(N_\ell u + N_{\dot\ell} w)^T + \frac{N}{\ell} P, \qquad C = N_{\dot\ell}\, u u^T
"""

from mecano.jit.kernel import kernel
from mecano.maths.dual import at_least
from mecano.maths.vector import EYE, add_mat, add_vec, dot, norm, outer, vec

SHORTEST = 1e-12  # [m]: below it the line has no direction


@kernel
def line(q, v):
    """Return length, rate, (1/length, u, relative velocity) of the line from the node at q[0:3] to that at q[3:6]."""
    d, velocity = vec(q, 3) - vec(q, 0), vec(v, 3) - vec(v, 0)
    length = norm(d)
    inverse = 1.0 / at_least(length, SHORTEST)
    u = inverse * d
    return length, dot(u, velocity), (inverse, u, velocity)


@kernel
def add_line_force(f, K, C, rate, geometry, N, N_length, N_rate):
    """Add the force N [N] along the line, given with its derivatives by length and rate; the rest is from ``line``."""
    inverse, u, velocity = geometry
    add_vec(f, 0, -N, u)
    add_vec(f, 3, N, u)
    across = EYE - outer(u, u)
    w = inverse * (velocity - rate * u)
    stiffness = outer(u, N_length * u + N_rate * w) + N * inverse * across
    damping = N_rate * outer(u, u)
    for i in range(2):
        for j in range(2):
            sign = 1.0 if i == j else -1.0
            add_mat(K, 3 * i, 3 * j, sign, stiffness)
            add_mat(C, 3 * i, 3 * j, sign, damping)

r"""The line between two nodes, and a force along it.

With :math:`d = x_1 - x_0`, the length :math:`\ell = |d|` and :math:`u = d/\ell`, a force N that pulls the nodes
together gives :math:`f_1 = -f_0 = N u`.
"""

from mecano.jit.kernel import kernel
from mecano.maths.dual import at_least
from mecano.maths.vector import add_vec, dot, norm, vec

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
def add_line_force(f, N, u):
    """Add the force N [N] along the line, which pulls the nodes together."""
    add_vec(f, 0, -N, u)
    add_vec(f, 3, N, u)

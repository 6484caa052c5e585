r"""Tilt: :math:`c = \mu \cdot \xi` for mu fixed in the first node and xi in the second.

For unit vectors that are initially perpendicular, c is the sine of the angle by which they tilt towards each other. A
force g along c is the moment -g on the second node about :math:`\xi \times \mu`. The gradients are those of
body_fixed.py (equations (12)-(17) of Cardona, Geradin & Doan 1991).
"""

from mecano.constraints.body_fixed import (
    add_blocks,
    product_curvature,
    product_gradient,
    relative_rotation,
    turning_rate,
)  # fmt: skip
from mecano.constraints.coordinates.coordinate import Coordinate
from mecano.jit.kernel import kernel
from mecano.maths.vector import dot, vec


@kernel
def tilted(at, mu, xi):
    """Return c and its rate [1/s] for two nodes with the local unknowns x0, R0, x1, R1."""
    A = relative_rotation(at)
    return dot(mu, A @ xi), turning_rate(product_gradient(A, mu, xi), vec(at.v, 3), vec(at.v, 9))


@kernel
def _value(p, at):
    return dot(vec(p.mu, 0), relative_rotation(at) @ vec(p.xi, 0))


@kernel
def _gradient(p, at):
    b_0, b_1 = product_gradient(relative_rotation(at), vec(p.mu, 0), vec(p.xi, 0))
    return (0, b_0), (3, b_1)


@kernel
def _add_curvature(p, at, g, K):
    A = relative_rotation(at)
    add_blocks(K, 0, 3, g, product_curvature(A, vec(p.mu, 0), vec(p.xi, 0)))


TILT = Coordinate(("R0", "R1"), "rad", {"mu": 3, "xi": 3}, _value, _gradient, _add_curvature)

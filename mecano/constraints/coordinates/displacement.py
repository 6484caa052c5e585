r"""Displacement of a node from a point o along a direction n, both inertial: :math:`n \cdot (x - o)`."""

from mecano.constraints.coordinates.coordinate import Coordinate
from mecano.jit.kernel import kernel
from mecano.maths.vector import dot, vec


@kernel
def _value(p, at):
    return dot(vec(p.direction, 0), vec(at.q, 0) - vec(p.origin, 0))


@kernel
def _gradient(p, at):
    return ((0, vec(p.direction, 0)),)


@kernel
def _add_curvature(p, at, g, K):
    pass


DISPLACEMENT = Coordinate(("x0",), "m", {"direction": 3, "origin": 3}, _value, _gradient, _add_curvature)

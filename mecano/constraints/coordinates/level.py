r"""Level: :math:`a \cdot n` for an axis a fixed in the node and an inertial direction n.

A force along it is a moment on the node about the driving direction a x n (equation (19) of Cardona, Geradin &
Doan 1991).
"""

from mecano.constraints.coordinates.coordinate import Coordinate
from mecano.jit.kernel import kernel
from mecano.maths.vector import add_mat, cross, dot, mat, skew, vec


@kernel
def _value(p, at):
    return dot(vec(p.axis, 0), mat(at.R[0]).T @ vec(p.normal, 0))


@kernel
def _gradient(p, at):
    return ((0, cross(vec(p.axis, 0), mat(at.R[0]).T @ vec(p.normal, 0))),)


@kernel
def _add_curvature(p, at, g, K):
    add_mat(K, 0, 0, g, skew(vec(p.axis, 0)) @ skew(mat(at.R[0]).T @ vec(p.normal, 0)))


LEVEL = Coordinate(("R0",), "rad", {"axis": 3, "normal": 3}, _value, _gradient, _add_curvature)

r"""Distance of two nodes: :math:`\ell = |x_1 - x_0|`. A force along it pushes the nodes apart."""

from mecano.constraints.coordinates.coordinate import Coordinate
from mecano.jit.kernel import kernel
from mecano.maths.vector import EYE, add_mat, norm, outer, vec


@kernel
def _value(p, at):
    return norm(vec(at.q, 3) - vec(at.q, 0))


@kernel
def _gradient(p, at):
    d = vec(at.q, 3) - vec(at.q, 0)
    n = d / norm(d)
    return (0, -n), (3, n)


@kernel
def _add_curvature(p, at, g, K):
    d = vec(at.q, 3) - vec(at.q, 0)
    length = norm(d)
    n = d / length
    across = g / length * (EYE - outer(n, n))
    for i, s in ((0, -1.0), (3, 1.0)):
        for j, s_j in ((0, -1.0), (3, 1.0)):
            add_mat(K, i, j, s * s_j, across)


DISTANCE = Coordinate(("x0", "x1"), "m", {}, _value, _gradient, _add_curvature)

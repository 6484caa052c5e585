"""Section forces, strains and stresses in the middle and at the ends of a beam element, from the loads at its ends.

``p`` is the record of the element, ``s`` its screw (beam_elastic.py); the force and the second moment at the ends are
in section axes of node 2, the first moment in those of node 1.
"""

from typing import NamedTuple

from mecano.jit.kernel import kernel
from mecano.maths.dual import at_least, sqrt
from mecano.maths.so3 import exp, tangent
from mecano.maths.vector import EYE, Vec3, cross, cross_columns, dot, mat, skew


class Helix(NamedTuple):
    """The helix from the first to the second end section, in the axes of the first one."""

    half: tuple  # rotation of the middle
    whole: tuple  # rotation of the second end
    ahead: tuple  # vector from the first end to the middle


@kernel
def helix(s):
    """Return the Helix of a Screw."""
    half = 0.5 * s.phi
    return Helix(exp(half), exp(s.phi), 0.5 * (tangent(half).T @ (s.H @ s.y)))


@kernel
def middle_rotation(p, s, path, ends, length):
    """Return the rotation from the axes of the middle section to those of the first one.

    ``path``: the Helix; ``ends``: force, first moment; ``length`` of the bent line.

    Along the line of shear centres, with the curvature k in section axes, the wrench changes by N' = N x k, M' = M x k
    + N x e_1, and the strain of curvature by kappa'. In such an S shape the middle section turns against that of the
    helix by -kappa' L^2/8. N and M are those in its own axes: with X = T L^2/(8 EI), for a tension T, the turn follows
    from (X + X^2/6) instead of X, the first terms of cosh(sqrt(2 X)) - 1 in the solution of M'' = T M/EI.
    """
    axes, c, F_pp = mat(p.axes), skew(_shear_center(p)), mat(p.F_pp)
    force, moment, _ = _carried(path, path.half, path.ahead, *ends)
    N, k = axes.T @ force, skew(axes.T @ s.phi)
    M = axes.T @ moment - c @ N
    by_force = mat(p.F_up).T @ k + F_pp @ (skew(Vec3(length, 0.0, 0.0)) + c @ k)
    by_moment, eighth = F_pp @ k, 0.125 * length
    X = -eighth * (cross_columns(by_force, N) + cross_columns(by_moment, M))
    more = EYE + (1.0 / 6.0) * X
    turn = _solution(EYE + X @ more, more @ (eighth * (by_force @ N + by_moment @ M)))
    return path.half @ exp(axes @ turn)


@kernel
def _solution(A, b):
    """Return x with A x = b, by Cramer's rule."""
    u, v, w = A.T[0], A.T[1], A.T[2]
    v_w = cross(v, w)
    return (1.0 / dot(u, v_w)) * Vec3(dot(b, v_w), dot(b, cross(w, u)), dot(b, cross(u, v)))


@kernel
def _shear_center(p):
    """Return the shear centre from the node, in section axes."""
    return mat(p.axes).T @ Vec3(p.shift[1, 2], p.shift[2, 0], p.shift[0, 1])


@kernel
def _carried(path, middle, ahead, force, first):
    """Return force and moment at ``ahead`` of the first end, in the axes ``middle``, and the force at this end."""
    first_force = path.whole @ force
    return middle.T @ first_force, middle.T @ (first - cross(ahead, first_force)), first_force


@kernel
def section_forces(p, path, middle, force, first, second):
    """Return force and moment in the middle, force and moment at both ends, in the section axes of each place.

    The middle section is turned about its shear centre, at c from the nodes.
    """
    axes = mat(p.axes)
    c = axes @ _shear_center(p)
    ahead = path.ahead + path.half @ c - middle @ c
    middle_force, middle_moment, first_force = _carried(path, middle, ahead, force, first)
    return (
        axes.T @ middle_force, axes.T @ middle_moment, axes.T @ first_force, axes.T @ force,
        axes.T @ first, axes.T @ second,
    )  # fmt: skip


@kernel
def local_strains(p, N, M):
    """Return the strains and curvatures of a section force and moment."""
    F_up = mat(p.F_up)
    return mat(p.F_uu) @ N + F_up @ M, F_up.T @ N + mat(p.F_pp) @ M


@kernel
def largest_stresses(p, N, M):
    """Return the largest normal stress of the fibres, shear stress of torsion, equivalent stress [Pa]."""
    strain, curvature = local_strains(p, N, M)
    largest = abs(strain[0]) + p.radius * sqrt(curvature[1] * curvature[1] + curvature[2] * curvature[2])
    for i in range(p.n_points):
        fibre = strain[0] + curvature[1] * p.points[i, 1] - curvature[2] * p.points[i, 0]
        largest = at_least(largest, abs(fibre))
    normal, shear = p.E * largest, p.G * p.torsion_radius * abs(curvature[0])
    return normal, shear, sqrt(normal * normal + 3.0 * shear * shear)

r"""Touching of a capsule or cylinder fixed in node a and a capsule fixed in node b: two lines and the distance of both.

The points :math:`o_a + s\,\alpha` and :math:`o_b + t\,\beta` of both axes, each within its ends, are the nearest ones;
their distance less both radii is the gap:

.. math::  g = |d| - \rho_a - \rho_b, \qquad d = (o_b + t\,\beta) - (o_a + s\,\alpha), \qquad n = d/|d|

Both lines are stationary there or end there, so that the rate of the gap is that of the points of the bodies,
:math:`\dot g = n \cdot (v_b + \omega_b \times b - v_a - \omega_a \times a)` with the arms a and b from the nodes to the
contact. Parallel lines touch along a part of both: the force then acts in its middle (Ericson, Real-Time Collision
Detection, 2005, section 5.1.9).
"""

from mecano.constraints.touching import (
    SURFACE_RECORD,
    Shapes,
    Touch,
    approach_of_turning,
    arm_of_b,
    check_place_on_b,
    named_surface,
    origin_on_b,
    surface_record,
    touch_at_start,
)
from mecano.constraints.triads import unit
from mecano.jit.kernel import kernel
from mecano.maths.dual import at_least, at_most, select
from mecano.maths.vector import dot, mat, norm, vec
from mecano.schema import DIRECTION, NUMBER, POINT, Field, mapping, positive

PARALLEL = 1e-12  # square of the sine of the angle of two lines that count as parallel
SHORTEST = 1e-100  # [m]: below it two axes intersect, and there is no normal
ROD_RECORD = {"axis_b": 3, "origin_b": 3, "length_b": (), **SURFACE_RECORD}
ROD = Field(
    "rod",
    mapping(
        Field("axis", DIRECTION, "-", "from the centre of its first end to the other, at the start, inertial"),
        Field("length", NUMBER, "m", "distance of the centres of both ends", check=positive),
        Field("center", POINT, "m", "centre of its first end at the start, inertial; node b when absent", None),
    ),
    "-", "capsule of the 'radius' fixed in node b, instead of a ball; for 'capsule' and 'cylinder'", None,
)  # fmt: skip


@kernel
def _nearest(p, along, back, cosine):
    """Return s and t of the nearest points, from alpha.r, beta.r and alpha.beta with r = o_b - o_a."""
    D = 1.0 - cosine * cosine
    crossing = (along - cosine * back) / at_least(D, PARALLEL)
    far = along + cosine * p.length_b  # s of both ends of b
    low, high = at_least(at_most(along, far), p.first), at_most(at_least(along, far), p.last)
    s = at_most(at_least(select(D > PARALLEL, crossing, 0.5 * (low + high)), p.first), p.last)
    t = at_most(at_least(cosine * s - back, 0.0), p.length_b)
    return at_most(at_least(along + cosine * t, p.first), p.last), t


@kernel
def touch(p, at):
    """Return the Touch of nodes with x0, R0, x1, R1 first among the local unknowns."""
    A, B = mat(at.R[0]), mat(at.R[1])
    alpha, beta = A @ vec(p.axis, 0), B @ vec(p.axis_b, 0)
    from_a, o_a, o_b = vec(at.q, 6) - vec(at.q, 0), A @ vec(p.origin, 0), B @ vec(p.origin_b, 0)
    r = from_a + o_b - o_a
    s, t = _nearest(p, dot(alpha, r), dot(beta, r), dot(alpha, beta))
    d = r + t * beta - s * alpha
    distance = norm(d)
    n = 1.0 / at_least(distance, SHORTEST) * d
    gap = distance - p.distance - p.radius
    b = o_b + t * beta - arm_of_b(p.radius, gap, 1.0 / (p.distance + p.radius)) * n
    return Touch(gap, n, from_a + b, b)


def rod_record(d, nodes, context=None):
    """Return the values of ROD_RECORD."""
    rod, (_, R_b) = d["rod"], nodes[1]
    of_b = {"axis_b": R_b.T @ unit(rod["axis"]), "origin_b": origin_on_b(rod, nodes)}
    return {**of_b, "length_b": rod["length"], **surface_record(d, nodes)}


def check_rod(d, nodes):
    """Return errors for a rod at a surface that is not a line, without a position, and for axes that meet."""
    name, values = named_surface(d)
    if name not in ("capsule", "cylinder") or values.get("inside"):
        return [
            "a 'rod' touches a 'capsule', or a 'cylinder' from outside; on a plane or inside a cylinder use instead of "
            "'rod' a ball of this 'radius' at each of its ends, on nodes 'attached' to its body"
        ]
    if d["radius"] <= 0.0:
        return ["the 'radius' of a 'rod' must be greater than zero"]
    if unplaced := check_place_on_b(d, "rod"):
        return unplaced
    radii = values["radius"] + d["radius"]
    distance = touch_at_start(RODS, d, nodes).gap + radii
    return (
        []
        if distance > 0.5 * radii
        else [f"the axes of the rod and of the {name} are {distance:.3g} m apart: move them apart"]
    )


RODS = Shapes("rod_", touch, approach_of_turning, True, ROD_RECORD, rod_record, check_rod)

r"""Skate: a blade, or a freely rotating wheel, that moves only along itself.

At its node, where it touches the ground, the velocity across the blade is zero,

    v.l = 0,   l = (a - s n)/q,   s = n.a,

with the direction a across the blade, fixed in the node, projected onto the plane of the ground. The reaction is the
force on the blade along l. Nothing keeps the node on the ground, and the blade may rotate about any axis.
"""

import numpy as np

from mecano.constraints.ground import LEAN, check_axle, end_conditions, lean_of, slope_below
from mecano.constraints.no_slip import no_slip, on_a_plane
from mecano.constraints.triads import carried_axis, unit
from mecano.element_interface import Display, Kind, Output, Row, named, record
from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.maths.surface import directions, disc_contact
from mecano.maths.vector import ZERO, dot, mat, put, vec
from mecano.schema import DIRECTION, GROUND, NODE, Field

RECORD = record(axis=3, normal=3)
LATERAL = 6  # local index of the multiplier


@kernel
def _contact(p, at):
    """Return no arm, and the direction across the blade."""
    return ZERO, on_a_plane(p, at.R)[1:]


@kernel
def observe(p, at, F, y, e):
    """Write reaction and speed."""
    axis = mat(at.R[0]) @ vec(p.axis, 0)
    g = disc_contact(p, vec(p.normal, 0), 0.0, axis)
    along, across = directions(axis, g)
    y[0] = number(at.q[LATERAL])
    put(y, 1, number(at.q[LATERAL]) * across)
    y[4] = dot(along, vec(at.v, 0))
    y[5] = lean_of(g)


def check(d, nodes):
    """Return errors for a ground that is not a plane, or a blade that lies flat."""
    if d["ground"].get("profile"):
        return ["a skate moves on a plane only"]
    point = np.array(d["ground"]["plane"]["point"]) + np.array(d["ground"]["plane"]["normal"])
    return check_axle(d["ground"], point, d["axis"])


def sample(rng):
    """Return a leaning blade on a slope."""
    ground, normal, level = slope_below(rng)
    return [({"axis": level + 0.3 * normal, "ground": ground}, 1, "")]


SKATE = Kind(
    name="skate", section="elements", doc=__doc__, display=Display(pictures=("wheels",), force="contact_force"),
    dtype=RECORD, layout=("x0", "R0"),
    fields=(
        Field("node", NODE, "-", "where the blade touches the ground"),
        Field("axis", DIRECTION, "-", "direction across the blade at the start, inertial; forward is axis x normal"),
        Field("ground", GROUND, "-", "plane it moves on"),
    ),
    outputs=(
        Output("lateral_force", "N", "force of the ground on the blade along l"),
        Output("contact_force", "N", "the same, inertial", (3,)),
        Output("speed", "m/s", "velocity of the node along the blade, t = a x n/|a x n|"),
        LEAN,
    ),
    multipliers=(Row("force across the blade", "N", "m/s"),),
    **no_slip(_contact, 1),
    prepare=lambda d, nodes, context: {"axis": carried_axis(d, nodes), "normal": unit(d["ground"]["plane"]["normal"])},
    **named(check, end_conditions, observe, sample),
)  # fmt: skip

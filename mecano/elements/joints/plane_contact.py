r"""Contact of a node with the plane of a ground, rigid and without friction.

With the unit normal n and a point P of the plane, and the radius r of a ball around the node (zero: the node itself):

.. math::  \Phi = n \cdot (x - P) - r \ge 0, \qquad N \ge 0

N, the multiplier, is the force along n. The node hits the plane with a shock (docs/shocks.md), rebounds with the
coefficient of ``restitution``, and leaves it when N falls to zero. While in contact it is held at the gap of the last
step before the impact.
"""

import numpy as np

from mecano.constraints.augmented_lagrangian import held_from_event, in_phase
from mecano.constraints.triads import unit
from mecano.element_interface import CONTACT, Event, Kind, Output, Row, named, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import dot, vec
from mecano.schema import GROUND, NODE, NUMBER, Field, not_negative, share

RECORD = record(point=3, normal=3, radius=(), restitution=())
CLOSED = 1  # phase
MULTIPLIER = 3


@kernel
def _gap(p, at):
    """Return the gap and its gradient."""
    normal = vec(p.normal, 0)
    return dot(normal, vec(at.q, 0) - vec(p.point, 0)) - p.radius, ((0, normal),)


@kernel
def observe(p, at, F, y, e):
    """Write gap, force, state."""
    y[0], y[1], y[2] = _gap(p, at)[0], at.q[MULTIPLIER], float(at.phase)


@kernel
def event_values(p, at, g):
    """Write depth below the plane [m], -N [N]."""
    g[0], g[1] = -_gap(p, at)[0], -at.q[MULTIPLIER]


def prepare(d, nodes, context):
    """Return unit normal and point of the plane."""
    plane = d["ground"]["plane"]
    own = {name: d[name] for name in ("radius", "restitution")}
    return {"point": plane["point"], "normal": unit(plane["normal"]), **own}


def check(d, nodes):
    """Check that the ground is a plane, and that the node is not below it."""
    if d["ground"].get("profile"):
        return ["'ground' must be a plane, without a profile"]
    p = prepare(d, nodes, None)
    gap = p["normal"] @ np.subtract(nodes[0][0], p["point"]) - p["radius"]
    return [f"the node starts {-gap:.6g} m below the plane"] if gap < -1e-9 else []


def sample(rng):
    """Return a node above a slope, and one on it."""
    ground = {"plane": {"point": rng.normal(size=3), "normal": rng.normal(size=3)}, "profile": None}
    normal = unit(ground["plane"]["normal"])
    x = ground["plane"]["point"] + np.cross(normal, rng.normal(size=3)) + 0.5 * normal
    values = {"ground": ground, "radius": 0.2, "restitution": 0.6}
    return [(values, [(x, np.eye(3))], "air"), (values, [(x - 0.3 * normal, np.eye(3))], "contact")]


PLANE_CONTACT = Kind(
    name="plane_contact", section="elements", doc=__doc__, dtype=RECORD, layout=("x0",),
    fields=(
        Field("node", NODE, "-", "the node, which may have mass of its own or move with others"),
        Field("ground", GROUND, "-", "the ground, a plane"),
        Field("radius", NUMBER, "m", "radius of the ball around the node", 0.0, not_negative),
        Field("restitution", NUMBER, "-", "ratio of the speeds after and before a shock, 0 to 1", 0.0, share),
    ),
    outputs=(
        Output("gap", "m", "distance from the plane", geometric=True),
        Output("normal_force", "N", "force of the plane on the node; impulses are recorded with the events"),
        Output("closed", "-", "1 while it touches, otherwise 0"),
    ),
    multipliers=(Row("normal force of the plane", "N", "m", unilateral=True),),
    phases=("air", "contact"),
    events=(
        Event("touches", "air", "contact", "the ball reaches the plane: it stays or rebounds; a shock", CONTACT,
              "restitution", brief=True),
        Event("lifts off", "contact", "air", "the normal force falls to zero"),
    ),
    memory=("held",),
    **held_from_event(_gap, MULTIPLIER, in_phase(CLOSED)),
    **named(prepare, check, observe, event_values, sample),
)  # fmt: skip

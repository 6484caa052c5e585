r"""Rigid wheel of Cardona, Geradin and Doan (1991) to the letter: for comparison only.

The small-inclination equations of section 3.2 of CMAME 89, kept unchanged at any lean of the wheel, on a plane:

    (x - P).n - radius = 0           the centre keeps its height (18)
    u.t = 0, u.l = 0                 the point x - radius n below the centre does not slip (22), (25)

The contact does not move sideways over the rim as the wheel leans, so gravity does not tip the wheel: an upright
thin disc wobbles with omega^2 = C (C + m r^2) n^2/(A (A + m r^2)) at any spin n and has no critical speed, whereas the
exact one (``rigid_wheel``) falls over below v^2 = g r/3. A, C are the moments of inertia about a diameter and the axis.
"""

import numpy as np

from mecano.constraints.ground import check_axle, end_conditions, normal_and_level, on_the_slope, slope_below
from mecano.constraints.no_slip import no_slip, on_a_plane
from mecano.constraints.of_coordinates import HELD_COORDINATE
from mecano.constraints.rolling import ROWS
from mecano.constraints.triads import carried_axis, unit
from mecano.constraints.wheels import FIELDS, OUTPUTS, WHEEL_DISPLAY, Wheel, check_touching, put_outputs
from mecano.element_interface import Kind, Part, named, record
from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.maths.surface import disc_contact
from mecano.maths.vector import dot, mat, vec

RECORD = record(axis=3, radius=(), normal=3)
HEIGHT, DRIVING, LATERAL = 6, 7, 8  # multipliers of the parts, after its own unknowns


@kernel
def _below(p, at):
    """Return the arm to the point below the centre, and the directions in which it does not slip."""
    return -p.radius * vec(p.normal, 0), on_a_plane(p, at.R)


def _sample_rolling(rng):
    """Return a leaning disc."""
    normal, level = normal_and_level(rng)
    values = {"axis": unit(level + 0.3 * normal), "normal": normal, "radius": 0.7}
    return [(values, [(rng.normal(size=3), np.eye(3))], "")]


UPRIGHT_ROLLING = Kind(
    name="upright_rolling", doc="Upright rolling: the point below the centre of a disc does not slip.", dtype=RECORD,
    layout=("x0", "R0"), multipliers=ROWS, sample=_sample_rolling, **no_slip(_below, len(ROWS)),
)  # fmt: skip


@kernel
def observe(p, at, F, y, e):
    """Write the reactions from the multipliers of the parts; the wheel neither stores nor dissipates energy."""
    Rn, n = mat(at.R[0]), vec(p.normal, 0)
    axis = Rn @ vec(p.axis, 0)
    g = disc_contact(p, n, p.radius, axis)
    push = number(at.q[HEIGHT]), number(at.q[DRIVING]), number(at.q[LATERAL])
    spin = dot(Rn @ vec(at.v, 3), axis)
    put_outputs(y, at.q, push, p.radius, Wheel(g, axis, -p.radius * n, spin, g.r * g.q))


def prepare(d, nodes, context):
    """Return the record: axis in the node's frame, radius, normal."""
    return {"axis": carried_axis(d, nodes), "radius": d["radius"], "normal": unit(d["ground"]["plane"]["normal"])}


def parts(d, nodes, context):
    """Return the Parts: the centre keeps its height, the point below it does not slip."""
    p = prepare(d, nodes, context)
    origin = np.array(d["ground"]["plane"]["point"], float) + d["radius"] * p["normal"]
    height = {"direction": p["normal"], "origin": origin, "offset": 0.0, "law": 0}
    return [Part(HELD_COORDINATE, (0,), height), Part(UPRIGHT_ROLLING, (0,), p)]


def check(d, nodes):
    """Return errors for a ground that is not a plane, a wheel that lies flat or starts below the ground."""
    if d["ground"].get("profile"):
        return ["the paper's wheel rolls on a plane only; use rigid_wheel on a ground with a profile"]
    plane, x = d["ground"]["plane"], nodes[0][0]
    gap = unit(plane["normal"]) @ np.subtract(x, plane["point"]) - d["radius"]
    return check_axle(d["ground"], x, d["axis"]) or check_touching(gap, gap, d["radius"])


def sample(rng):
    """Return a wheel that leans on a slope."""
    ground, normal, level = slope_below(rng)
    return [({"radius": 8.0, "axis": level + 0.3 * normal, "ground": ground}, on_the_slope(rng, normal), "")]


CARDONA_WHEEL = Kind(
    name="cardona_wheel", section="elements", doc=__doc__, display=WHEEL_DISPLAY, dtype=RECORD, layout=("x0", "R0"),
    fields=FIELDS,
    outputs=OUTPUTS,
    **named(prepare, parts, check, end_conditions, observe, sample),
)  # fmt: skip

r"""Wheel with free rollers on its rim: Mecanum wheel (rollers at 45 degrees), omni wheel (at 90 degrees).

The wheel touches the ground as a rigid disc, r - radius = 0. There a roller turns freely about its axis e, which has
the angle gamma from the axle in the plane of the ground, so that the wheel slips across e but not along it (Siegwart
and Nourbakhsh, Introduction to Autonomous Mobile Robots, 2011, section 3.2.3, the Swedish wheel):

    u.e = 0,   e = cos(gamma) l + sin(gamma) t,   u = v + omega x r c

with the driving direction t and the lateral direction l = n x t. gamma = 90 degrees is an omni wheel, u.t = 0: it rolls
as any wheel and is free to move sideways. With gamma = 45 degrees a wheel that spins on the spot is pushed along e. The
reactions are the radial force and the force along e.

The rollers are many and light: neither their passage nor their inertia is modelled. The wheel cannot leave the ground.
"""

import math

import numpy as np

from mecano.constraints.ground import (
    GROUND_RECORD,
    check_axle,
    check_ground,
    end_conditions,
    on_the_slope,
    slope_below,
    touch,
)
from mecano.constraints.no_slip import no_slip
from mecano.constraints.rolling_radius import ROLLING_RADIUS, leaning_discs
from mecano.constraints.tread import tread_above
from mecano.constraints.wheels import FIELDS as WHEEL_FIELDS
from mecano.constraints.wheels import OUTPUTS, WHEEL_DISPLAY, Wheel, check_touching, disc_record, put_outputs
from mecano.element_interface import Kind, Part, Row, named, record
from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.maths.surface import directions
from mecano.maths.vector import dot, mat, vec
from mecano.schema import NUMBER, Field

RECORD = record(axis=3, radius=(), along=2, **GROUND_RECORD)
RADIAL, ALONG = 6, 7  # multipliers of the parts
FLAT_ROLLERS = 0.05  # of the sine of gamma: rollers whose axes are along the axle cannot drive
FIELDS = (
    *WHEEL_FIELDS,
    Field(
        "roller_angle", NUMBER, "rad", "gamma, from the axle to the axis of the roller on the ground, positive towards "
        "the driving direction: 45 deg or -45 deg for a Mecanum wheel, 90 deg for an omni wheel",
    ),
)  # fmt: skip


@kernel
def _touching(p, at):
    """Return the axis of the wheel, its Contact and the direction e there; p.along is (sin gamma, cos gamma)."""
    axis = mat(at.R[0]) @ vec(p.axis, 0)
    g = touch(p, at.laws, vec(at.q, 0), axis)
    t, l = directions(axis, g)
    return axis, g, p.along[0] * t + p.along[1] * l


@kernel
def _held(p, at):
    """Return the arm of the contact, and the direction along which it does not slip."""
    _, g, along = _touching(p, at)
    return g.arm, (along,)


def _sample_rollers(rng):
    """Return leaning discs with rollers at an angle."""
    angles = [(rng.uniform(-1.5, 1.5), values, nodes) for values, nodes, _ in leaning_discs(rng)]
    return [({**values, "along": np.array([np.sin(a), np.cos(a)])}, nodes, "") for a, values, nodes in angles]


ROLLER = Kind(
    name="roller", doc="Roller: the point of a disc nearest to the ground does not slip along the axis of the roller.",
    dtype=RECORD, layout=("x0", "R0"), multipliers=(Row("force of the ground along the roller", "N", "m/s"),),
    sample=_sample_rollers, **no_slip(_held, 1),
)  # fmt: skip


@kernel
def observe(p, at, F, y, e):
    """Write the reactions from the multipliers of the parts; the wheel neither stores nor dissipates energy."""
    axis, g, along = _touching(p, at)
    t, l = directions(axis, g)
    pushed = number(at.q[ALONG])
    push = number(at.q[RADIAL]) / g.q, pushed * dot(along, t), pushed * dot(along, l)
    spin = dot(mat(at.R[0]) @ vec(at.v, 3), axis)
    put_outputs(y, at.q, push, g.r, Wheel(g, axis, g.arm, spin, g.r * g.q))


def prepare(d, nodes, context):
    """Return the record, that of the parts."""
    angle = d["roller_angle"]
    return {**disc_record(d, nodes, context), "along": np.array([math.sin(angle), math.cos(angle)])}


def parts(d, nodes, context):
    """Return the Parts: contact, no slip along the roller."""
    disc, own = disc_record(d, nodes, context), prepare(d, nodes, context)
    return [Part(ROLLING_RADIUS, (0,), disc), Part(ROLLER, (0,), own)]


def check(d, nodes):
    """Return errors for an unusable ground, a wheel that lies flat or is off the ground, rollers that cannot drive."""
    texts = check_ground(d["ground"]) + check_axle(d["ground"], nodes[0][0], d["axis"])
    if not texts:
        texts = check_touching(*tread_above(d["ground"], d["radius"], 0.0, nodes[0][0], d["axis"]), d["radius"])
    if abs(math.sin(d["roller_angle"])) < FLAT_ROLLERS:
        texts.append("'roller_angle' must not be near 0 or 180 deg: rollers along the axle cannot drive")
    return texts


def sample(rng):
    """Return wheels that lean on a slope and on waves, with rollers at 45 degrees and an omni wheel."""
    wave = (("sine", {"amplitude": 0.2, "frequency": 0.03, "phase": 1.0, "offset": 0.0}),)
    found = []
    for height, angle in ((None, -math.pi / 4), (wave, math.pi / 2)):
        ground, normal, level = slope_below(rng, height)
        values = {"radius": 8.0, "axis": level + 0.3 * normal, "ground": ground, "roller_angle": angle}
        found.append((values, on_the_slope(rng, normal), ""))
    return found


MECANUM_WHEEL = Kind(
    name="mecanum_wheel", section="elements", doc=__doc__, display=WHEEL_DISPLAY,
    dtype=RECORD, layout=("x0", "R0"),
    fields=FIELDS,
    outputs=OUTPUTS,
    **named(prepare, parts, check, end_conditions, observe, sample),
)  # fmt: skip

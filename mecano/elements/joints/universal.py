r"""Universal joint: a cross with one pin that rotates in node a, and another, perpendicular to it, in node b.

Both nodes share one position. With :math:`\mu_3` the pin fixed in a and :math:`\xi_3` the one fixed in b:

.. math::  \mu_3 \cdot \xi_3 = 0

The multiplier is the moment on b about :math:`\xi_3 \times \mu_3`, the only one that the cross transmits.

``friction`` acts at both pins, driven by the three multipliers that then hold the position, and by that of the cross.
``compliance`` replaces rigid constraints by laws: along axis_b, axis_a x axis_b and axis_a, as fixed in a (1, 2, axis),
and for the moment of the cross. The outputs force and moment include only what holds b; laws and friction have outputs
of their own.
"""

from dataclasses import replace

import numpy as np

from mecano.constraints.along_coordinate.friction import (
    LENGTH,
    check_friction,
    friction_fields,
    friction_record,
    radius,
)
from mecano.constraints.along_coordinate.law import SET_POINT, check_set_point, law_values
from mecano.constraints.along_coordinate.measure import angle_outputs
from mecano.constraints.body_fixed import follow, relative_rotation, turning_rate
from mecano.constraints.coordinates.pin_angle import pin_angle, pin_gradient
from mecano.constraints.coordinates.tilt import tilted
from mecano.constraints.joint_nodes import NODES, check_one_place, check_perpendicular, one_position
from mecano.constraints.joint_samples import RUBBING, SPRUNG, STICKING
from mecano.constraints.of_coordinates import ORTHOGONAL, PIN_LAW, TILT_LAW, law_part
from mecano.constraints.pair import (
    FIRST_ROW,
    PAIR_RECORD,
    compliance_field,
    held,
    law_outputs,
    pair_force,
    pair_parts,
    pair_record,
)
from mecano.constraints.pin_friction import PIN_FRICTION
from mecano.constraints.release import FIRST_ROW as FIRST_RELEASED
from mecano.constraints.release import RELEASE, SAMPLE, check_release, releasable
from mecano.constraints.rigid_offset import RIGID_OFFSET
from mecano.constraints.triads import triad
from mecano.element_interface import Display, Kind, Output, Part, named, record
from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.maths.vector import mat, put, vec
from mecano.schema import CONTINUOUS_DRIVE, DIRECTION, LAW, Field

RECORD = record(mu=(3, 3), xi=(3, 3))
CROSS = "about_cross"
PIN_LENGTH = "distance between the ends of each pin, which carry the couple; when absent the couple causes no friction"
ELASTIC = ("about_2", "along_1", "along_2", "along_axis")  # of pair.py; the first one stands for the cross


@kernel
def _angles(p, at):
    """Return angle and rate of the cross about the pin of a, and of b about its pin relative to the cross.

    Both angles are continued over whole turns.
    """
    mu, xi = mat(p.mu), mat(p.xi)
    A, omega_a, omega_b = relative_rotation(at), vec(at.v, 3), vec(at.v, 9)
    back = A.T
    first_rate = turning_rate(pin_gradient(A, mu, xi[2]), omega_a, omega_b)
    second_rate = turning_rate(pin_gradient(back, xi, mu[2]), omega_b, omega_a)
    # seen from b, the cross rotates the other way
    first, second = pin_angle(A, mu, xi[2]), -pin_angle(back, xi, mu[2])
    return follow(at.m[0], first), first_rate, follow(at.m[1], second), -second_rate


@kernel
def observe(p, at, F, y, e):
    """Write both angles and the reactions."""
    y[0], y[1], y[2], y[3] = _angles(p, at)
    put(y, 4, -vec(F, 6))
    y[7] = number(at.q[12])


def _held(first):
    """Return ``observe`` if multipliers, from the local index ``first`` on, hold the cross and the position."""

    @kernel
    def observe(p, at, F, y, e):
        """Write both angles and the reactions."""
        y[0], y[1], y[2], y[3] = _angles(p, at)
        put(y, 4, vec(at.q, first + 1))
        y[7] = number(at.q[first])

    return observe


@kernel
def observe_elastic(p, at, F, y, e):
    """Write both angles and the reactions, if laws hold some axes."""
    y[0], y[1], y[2], y[3] = _angles(p, at)
    put(y, 4, mat(at.R[0]) @ (mat(p.mu).T @ pair_force(p, at)))
    tilt, rate = tilted(at, vec(p.mu[2], 0), vec(p.xi[2], 0))
    y[7] = held(p, at, 0, tilt, rate)


@kernel
def commit(p, at, m_out):
    """Write both angles."""
    m_out[0], _, m_out[1], _ = _angles(p, at)


def prepare(d, nodes, context):
    """Return the axes of both nodes: third its own pin, first the initial pin of the other."""
    mu = triad(d["axis_a"], np.asarray(d["axis_b"], float))
    xi = triad(mu[0], mu[2])
    return {"mu": mu @ nodes[0][1], "xi": xi @ nodes[1][1]}


def parts(d, nodes, context):
    """Return the Parts that keep the pins perpendicular, and the laws of their angles."""
    p = prepare(d, nodes, context)
    return [Part(ORTHOGONAL, (0, 1), {"mu": p["mu"][2], "xi": p["xi"][2]}), *_turning(d, p, context)]


def _seen_by_pins(p):
    """Return (nodes, axes, other pin, a or b) per pin; axis 2 of b is reversed: its angle is relative to the cross."""
    return (((0, 1), p["mu"], p["xi"][2], "a"), ((1, 0), p["xi"] * [[1], [-1], [1]], p["mu"][2], "b"))


def _turning(d, p, context):
    return [
        law_part(PIN_LAW, {"mu": mu, "xi": xi}, law, d[f"natural_angle_{end}"], context, on=on, label=f"_{end}")
        for on, mu, xi, end in _seen_by_pins(p)
        if (law := d[f"turning_law_{end}"])
    ]


def parts_with_friction(d, nodes, context):
    """Return the Parts with the position held by multipliers, and the friction of both pins."""
    p, given = prepare(d, nodes, context), d["friction"]
    perpendicular, *turning = parts(d, nodes, context)
    friction = []
    for on, mu, xi, end in _seen_by_pins(p) if given else ():
        values = friction_record({**given, "radius": given[f"radius_{end}"]}, context, PIN_FRICTION.dtype.names)
        friction.append(Part(PIN_FRICTION, on, {"mu": mu, "xi": xi, **values}, (0, 1), f"_{end}"))
    return [perpendicular, Part(RIGID_OFFSET, (0, 1), {"d": np.zeros(3)}), *friction, *turning]


def prepare_elastic(d, nodes, context):
    """Return the axes of both nodes, and the constraint or law of each of four axes, of which one is the cross."""
    laws = {(ELASTIC[0] if axis == CROSS else axis): law for axis, law in d["compliance"].items()}
    return pair_record({**prepare(d, nodes, context), "start": np.zeros(3)}, ELASTIC, laws, context)


def parts_elastic(d, nodes, context):
    """Return the Parts that hold position and cross along each axis by a constraint or a law."""
    p = {**prepare(d, nodes, context), "start": np.zeros(3)}
    perpendicular, *turning = parts(d, nodes, context)
    if law := d["compliance"].get(CROSS):
        values = law_values({"mu": p["mu"][2], "xi": p["xi"][2]}, law, 0.0, context)
        perpendicular = Part(TILT_LAW, (0, 1), values, label=f"_{CROSS}")
    return [perpendicular, *pair_parts(p, ELASTIC[1:], d["compliance"], context), *turning]


def check(d, nodes):
    """Check that the nodes coincide initially, that the pins are perpendicular, and that set points have laws."""
    set_points = [text for end in "ab" for text in check_set_point(d, f"turning_law_{end}", f"natural_angle_{end}")]
    pins = check_perpendicular(d, "axis_a", "axis_b")
    return check_one_place(d, nodes) + check_friction(d) + pins + set_points + check_release(d, OPTIONS)


OPTIONS = ("turning_law_a", "turning_law_b", "friction", "compliance")  # which exclude a release
PINS = {"axis_a": (0.6, 0.0, 0.8), "axis_b": (-0.8, 1.0, 0.6)}  # of samples, as the others
RADII = {"radius_a": 0.3, "radius_b": 0.2}
PINS_SPRUNG = {**PINS, "turning_law_a": SPRUNG, "turning_law_b": SPRUNG, "natural_angle_b": 0.3}
UNIVERSAL_RUBBING = Kind(
    name="universal_rubbing", section="joints", doc=__doc__, display=Display(pictures=("angles",), force="force"),
    dtype=RECORD, layout=("x0", "R0", "x1", "R1"),
    fields=(
        NODES,
        Field("axis_a", DIRECTION, "-", "pin carried by a at the start, inertial"),
        Field("axis_b", DIRECTION, "-", "pin carried by b at the start, inertial, perpendicular to axis_a"),
        *(
            field
            for end in "ab"
            for field in (
                Field(
                    f"turning_law_{end}", LAW, "-",
                    f"moment [N m] from angle_{end} [rad] and its rate [rad/s]; > 0 turns b back", None, argument="rad"
                ),
                Field(
                    f"natural_angle_{end}", CONTINUOUS_DRIVE, "rad", f"angle_{end} {SET_POINT.format('turning')}", 0.0
                ),
            )
        ),
        friction_fields(
            radius("radius_a", "radius of the pin in a"), radius("radius_b", "radius of the pin in b"),
            replace(LENGTH, doc=PIN_LENGTH),
        ),
        compliance_field((CROSS, *ELASTIC[1:])),
        RELEASE,
    ),
    outputs=(
        *angle_outputs("rotation of the cross about axis_a since the start, over any number of turns", "_a"),
        *angle_outputs("rotation of b about axis_b since the start, over any number of turns", "_b"),
        Output("force", "N", "force of a on b, inertial axes", (3,)),
        Output("moment", "N m", "moment of a on b about axis_b x axis_a"),
    ),
    optional=(
        ("turning_law_a", PIN_LAW, "_a"), ("turning_law_b", PIN_LAW, "_b"),
        ("friction", PIN_FRICTION, "_a"), ("friction", PIN_FRICTION, "_b"),
        ("compliance", TILT_LAW, f"_{CROSS}"), *law_outputs("compliance", ELASTIC[1:]),
    ),
    memory=("angle_a", "angle_b"),
    parts=parts_with_friction,
    observe=_held(FIRST_ROW),
    variant=lambda d: next((kind for name, kind in VARIANTS.items() if d[name]), UNIVERSAL),
    cases=(
        PINS,
        {**PINS, **SAMPLE},
        {**PINS_SPRUNG, "friction": {**RUBBING, **RADII}},
        {**PINS, "friction": {**STICKING, **RADII}},
        {**PINS_SPRUNG, "natural_angle_b": "command"},
        {**PINS_SPRUNG, "compliance": {CROSS: SPRUNG, "along_2": SPRUNG}},
        {**PINS, "compliance": {"along_1": SPRUNG, "along_axis": SPRUNG}},
    ),
    **named(prepare, check, commit),
)  # fmt: skip

UNIVERSAL_ELASTIC = replace(
    UNIVERSAL_RUBBING, name="universal_elastic", dtype=PAIR_RECORD, prepare=prepare_elastic, parts=parts_elastic,
    observe=observe_elastic,
)  # fmt: skip
UNIVERSAL = replace(
    UNIVERSAL_RUBBING, name="universal", shares=one_position, parts=parts, observe=observe, hidden={"force": ""},
    revealed=UNIVERSAL_RUBBING,
)  # fmt: skip
VARIANTS = {
    "release": releasable(UNIVERSAL_RUBBING, observe=_held(FIRST_RELEASED)), "compliance": UNIVERSAL_ELASTIC,
    "friction": UNIVERSAL_RUBBING,
}  # fmt: skip
"""The kinds for the options of the deck, of which the first one given counts."""

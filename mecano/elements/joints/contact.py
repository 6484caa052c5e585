r"""Contact of a ball, rod, ellipsoid or face at node b with a surface of node a: plane, sphere, cylinder, cam.

Without ``law`` the contact is rigid: it closes with a shock (docs/shocks.md), rebounds with the coefficient of
``restitution``, and opens where the normal force N, its multiplier, falls to zero. While closed it is held at the gap
of the last step before the shock.

With a ``law`` of the depth w by which the bodies overlap it is elastic, and damped after Hunt and Crossley:

.. math::  N = F(w)\,\max(0, 1 + c\,\dot w)

``friction`` opposes the velocity u of the ball along the surface, :math:`F_t = -\mu(|u|)\,\phi(|u|)\,N u/|u|`, with
:math:`\phi(u) = (u/\epsilon)(2 - u/\epsilon)` below the speed :math:`\epsilon` of the ``regularization``, 1 beyond: a
resting ball creeps. A rigid contact exerts it while it is closed, with its multiplier N, and in a shock as an impulse
by Coulomb's law.

* A ``cylinder`` is infinite. Model a pin in a hole by a ball of the radius of the pin ``inside`` a cylinder.
* A ``revolution`` (a drum, cone or groove) has the radius ``profile``; the ball touches the nearest point of its
  meridian.
* A ``cam`` has a radius that depends on the angle about its axis; a follower with a roller, the ball, leaves it where
  the cam would have to pull. A ``face`` in place of the ball, a flat follower, touches a convex cam in the point
  farthest along its normal.
* A ``rod`` in place of the ball, a capsule, touches another capsule or cylinder in one point. Where both are parallel,
  the force acts in the middle of the part along which they touch, and does not resist their turning: two long parallel
  bodies need a contact near each end.
* An ``ellipsoid`` in place of the ball touches a plane in the point whose normal is that of the plane.

Model a capsule or a box on a plane by a ball at each end or corner, on nodes attached to the body. Node a needs an
orientation (a body, a beam or the ground); with friction, a rod or an ellipsoid, node b needs one, too.

A rigid contact whose bodies overlap when it is activated begins to act when they no longer overlap, whether or not the
condition still holds.
"""

import math
from dataclasses import replace

from mecano.constraints.activation import with_activation
from mecano.constraints.along_coordinate.friction import check_friction, friction_fields
from mecano.constraints.along_coordinate.trigger import trigger_of
from mecano.constraints.contact_functions import (
    elastic,
    impact_friction,
    observed_rigid,
    observed_rubbing,
    rigid,
    rubbing,
)
from mecano.constraints.contact_samples import samples
from mecano.constraints.release import COMMAND, SAMPLE, with_release
from mecano.constraints.touching import BALL, FIELDS, ROUNDING, check_one_surface, touch_at_start
from mecano.constraints.touching_cam import CAMS
from mecano.constraints.touching_ellipsoid import ELLIPSOID, ELLIPSOIDS
from mecano.constraints.touching_face import FACE, FACES
from mecano.constraints.touching_revolution import REVOLUTIONS
from mecano.constraints.touching_rods import ROD, RODS
from mecano.element_interface import CONTACT as SHOCK
from mecano.element_interface import RELEASES, WAITS, Display, Event, Kind, Output, Part, Row, named, record
from mecano.laws.probe import curve_at, table_bounds
from mecano.schema import CURVE, NODE_PAIR, NUMBER, Field, not_negative, share

MATERIAL = {"law": "i", "damping": (), "restitution": (), "coefficient": "i", "regularization": ()}
PHASES = ("open", "closed")
NORMAL = Row("normal force of the contact", "N", "m", unilateral=True)
CLOSES = Event(
    "closes", "open", "closed", "the ball reaches the surface; a shock if it is rigid", SHOCK, "restitution", brief=True
)
OPENS = Event("opens", "closed", "open", "the normal force falls to zero")
SHAPES = {  # by fields of the deck
    "rod": RODS, "ellipsoid": ELLIPSOIDS, "face": FACES, "revolution": REVOLUTIONS, "cam": CAMS, "ball": BALL,
}  # fmt: skip


def _record(shapes):
    """Return the dtype of the record of a contact of two Shapes."""
    return record(**MATERIAL, **shapes.record)


def _shapes(d):
    """Return the name of the Shapes that the deck describes."""
    return next((name for name in SHAPES if d.get(name) is not None), "ball")


def prepare(d, nodes, context):
    """Return the record of one contact."""
    values = {"damping": d["damping"], "restitution": d["restitution"], "law": context.laws.add(d["law"])}
    values |= SHAPES[_shapes(d)].values(d, nodes, context)
    if d["friction"] is not None:
        values["coefficient"] = context.laws.add(d["friction"]["coefficient"])
        values["regularization"] = d["friction"]["regularization"]
    return values


def variant(d):
    """Return the kind of a rigid or elastic contact of two shapes, with or without friction."""
    return KINDS[_shapes(d)]["rigid" if d["law"] is None else "elastic"][d["friction"] is not None]


def variant_in_time(d):
    """Return the same kind, of a contact that is activated or released if the deck says so."""
    if d["law"] is None and (d["activate"] is not None or d["release"] is not None):
        return KINDS[_shapes(d)]["switched"][d["friction"] is not None]
    return ELASTIC_CONTACT.chosen(d)


def check(d, nodes):
    """Return errors in the surface, in the law, and for values that have no effect on this contact."""
    shapes = SHAPES[_shapes(d)]
    several = ["give only one of 'rod', 'ellipsoid' and 'face'"] if len(_shapes_of_b(d)) > 1 else []
    texts = check_one_surface(d) or several or shapes.check(d, nodes)
    if d["law"] is None:
        texts += ["'damping' needs 'law': a rigid contact has none"] if d["damping"] else []
        texts += check_friction(d)
        if not texts and not d["activate"] and (gap := touch_at_start(shapes, d, nodes).gap) < -ROUNDING:
            shape = (*_shapes_of_b(d), "ball")[0]
            texts.append(f"the {shape} starts {-gap:.6g} m within the surface, which is rigid without 'law'")
        return texts
    if d["restitution"]:
        texts.append("'restitution' applies to a rigid contact only; with 'law' give 'damping'")
    at_zero, slope, _ = curve_at(d["law"], 0.0)
    if at_zero != 0.0 or slope < 0.0:
        texts.append("'law' must be zero at zero depth and must not fall there")
    return texts + check_friction(d)


def bounds(d):
    """Return the gap at which a table of the law ends."""
    found = table_bounds("gap", d["law"], "the force")
    return [(gap, (-depth, math.inf), text) for gap, (_, depth), text in found if depth < math.inf]


def _shapes_of_b(d):
    return [name for name in ("rod", "ellipsoid", "face") if d[name] is not None]


def sample_in_time(rng):
    """Return those samples, and rigid contacts that are activated or released, in all phases."""
    timed = {**SAMPLE, "activate": {"time": 0.1, "when": None}}
    found = ELASTIC_CONTACT.sample(rng)
    held = [(d, nodes) for d, nodes, phase in found if phase == "closed" and "law" not in d]
    smooth, rough = (next(one for one in held if ("friction" in one[0]) == dry) for dry in (False, True))
    return found + [({**d, **timed}, nodes, phase) for d, nodes in (smooth, rough) for phase in SWITCHES["phases"]]


_ALWAYS_ACTIVE = Kind(
    name="contact", section="elements", doc=__doc__, display=Display("contact", force="force", force_at="point"),
    dtype=_record(BALL), layout=BALL.layout,
    fields=(
        Field("nodes", NODE_PAIR, "-", "node a, which carries the surface, and node b, of the ball or other shape"),
        *FIELDS,
        ROD,
        ELLIPSOID,
        FACE,
        Field(
            "law", CURVE, "N", "normal force, a curve of the depth [m], zero at zero; rigid when absent", None,
            argument="m",
        ),
        Field("damping", NUMBER, "s/m", "c in the factor max(0, 1 + c dw/dt) on the law", 0.0, not_negative),
        friction_fields(),
        Field(
            "restitution", NUMBER, "-", "for a rigid contact: ratio of the speeds after and before a shock", 0.0, share
        ),
    ),
    outputs=(
        Output("gap", "m", "distance of ball and surface, negative where they overlap", geometric=True),
        Output("normal_force", "N", "force of the surface on the ball along the normal"),
        Output("friction_force", "N", "magnitude of the friction"),
        Output("sliding_speed", "m/s", "speed of the ball along the surface at the contact; zero without friction"),
        Output("force", "N", "force of the surface on the ball, inertial", (3,)),
        Output("point", "m", "point of the ball nearest to the surface, inertial", (3,), geometric=True),
        Output("closed", "-", "1 while they touch, otherwise 0"),
    ),
    multipliers=(NORMAL,),
    phases=PHASES,
    events=(CLOSES, OPENS),
    memory=("held",),
    **named(prepare, variant, check, bounds),
    sample=samples,
    **rigid(BALL),
    **observed_rigid(BALL),
)  # fmt: skip
ELASTIC = {
    "multipliers": (), "memory": (), "commit": None, "constraints": None,
    "events": (
        Event("closes", "open", "closed", CLOSES.doc, elastic=True, brief=True), replace(OPENS, elastic=True),
    ),
}  # fmt: skip
ROUGH_LAYOUT = RODS.layout
INACTIVE, RELEASED, OVERLAPPING = "inactive", "released", "overlapping"
ACTIVATES = Event("activates", INACTIVE, "open", "the contact begins to act")
SWITCHES = {
    "phases": (*PHASES, INACTIVE, RELEASED, OVERLAPPING),
    "events": (
        CLOSES, OPENS, ACTIVATES,
        Event(WAITS, INACTIVE, OVERLAPPING, "it is due, and acts as soon as the bodies no longer overlap"),
        Event("activates", OVERLAPPING, "open", ACTIVATES.doc),
        *(
            Event(RELEASES, phase, RELEASED, "the contact is released", command=COMMAND)
            for phase in (*PHASES, INACTIVE, OVERLAPPING)
        ),
    ),
    "inputs": ("activate", COMMAND),
    "reads": lambda d: [
        f"{trigger_of(d['activate'])} + {ROUNDING}" if d["activate"] else "1",  # at once if due at the start
        trigger_of(d["release"]) if d["release"] else "-1",
    ],
    "at_start": lambda p: 2,
}  # fmt: skip
"""Switches of a rigid contact: when it is activated and released. Without them it is always active."""


def _elastic_kinds(shapes):
    """Return {rough: Kind} of the elastic contacts of two shapes."""
    smooth = replace(
        _ALWAYS_ACTIVE, name=f"smooth_{shapes.name}contact", dtype=_record(shapes), layout=shapes.layout, variant=None,
        **ELASTIC | elastic(shapes, False),
    )  # fmt: skip
    rough = replace(smooth, name=f"rough_{shapes.name}contact", layout=ROUGH_LAYOUT, **elastic(shapes, True))
    return {False: smooth, True: rough}


def _rigid_kinds(shapes, switches):
    """Return {rough: Kind} of the rigid contacts of two shapes; ``switches`` are those of SWITCHES or none."""
    inputs, phases, dtype = len(switches.get("inputs", ())), switches.get("phases", PHASES), _record(shapes)
    held = replace(
        _ALWAYS_ACTIVE, name=f"{shapes.name}contact", dtype=dtype, layout=shapes.layout, variant=None,
        **rigid(shapes, inputs), **observed_rigid(shapes, inputs), **switches,
    )  # fmt: skip
    constraint = Kind(
        name=f"rigid_{shapes.name}contact_part", doc="Constraint of a rigid contact with friction.", dtype=dtype,
        layout=shapes.layout, multipliers=(NORMAL,), phases=phases, memory=_ALWAYS_ACTIVE.memory, **rigid(shapes),
    )  # fmt: skip
    friction = Kind(
        name=f"{shapes.name}contact_friction", doc="Friction of a rigid contact.", dtype=dtype, layout=ROUGH_LAYOUT,
        coupled_multipliers=(NORMAL,), residual=rubbing(shapes), phases=phases,
        idle={phase: () for phase in phases if phase != "closed"}, impact_friction=impact_friction(shapes),
    )  # fmt: skip

    def parts(d, nodes, context):
        p = prepare(d, nodes, context)
        return [Part(constraint, (0, 1), p), Part(friction, (0, 1), p, coupled_to=(0,))]

    rubbed = replace(
        held, name=f"rigid_rough_{shapes.name}contact", layout=ROUGH_LAYOUT, multipliers=(), memory=(), commit=None,
        constraints=None, residual=None, parts=parts, **observed_rubbing(shapes, inputs),
    )  # fmt: skip
    return {False: held, True: rubbed}


KINDS = {
    name: {"rigid": _rigid_kinds(one, {}), "switched": _rigid_kinds(one, SWITCHES), "elastic": _elastic_kinds(one)}
    for name, one in SHAPES.items()
}
FORCES = (1, 3, 10)  # outputs of an elastic contact that are zero while it does not act
ELASTIC_CONTACT = with_activation(with_release(_ALWAYS_ACTIVE, "contact", FORCES), "contact", FORCES)
CONTACT = replace(ELASTIC_CONTACT, variant=variant_in_time, sample=sample_in_time)

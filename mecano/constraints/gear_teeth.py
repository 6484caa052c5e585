"""Teeth of a gear pair or of a rack: rigid or elastic, with backlash and friction; variants of a joint with a mesh."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from mecano.constraints.along_coordinate.stops import STOP_PHASES
from mecano.constraints.backlash import EVENTS, backlash_events, backlash_kind
from mecano.constraints.coordinates.coordinate import rate_of
from mecano.constraints.elastic_teeth import TEETH, check_teeth, elastic_teeth, teeth_values
from mecano.constraints.stop_phases import PHASES as ELASTIC_PHASES
from mecano.constraints.tooth_friction import FRICTION, friction_values, push, tooth_friction, tooth_friction_kind
from mecano.element_interface import Event, Kind, Output, Part, with_fields
from mecano.jit.kernel import kernel
from mecano.schema import NUMBER, Field, not_negative, share

VALUES = {
    "loss": 2, "regularization": (), "half_play": (), "restitution": (), "damping": (), "law": "i", "variation": "i",
}  # fmt: skip
"""Fields of the record of a joint before those of its mesh."""
FIELDS = (
    Field("backlash", NUMBER, "m", "play of the teeth along the pitch circle; half of it on each side at the start",
          0.0, not_negative),
    Field("restitution", NUMBER, "-", "for rigid teeth with backlash: speed after over before a shock", 0.0,
          share),
    TEETH,
    FRICTION,
)  # fmt: skip
ELASTIC_EVENTS = tuple(
    event
    for side, beyond in (("lower", "below"), ("upper", "above"))
    for event in (
        Event(f"meets {side} flank", "between", beyond, "elastic teeth touch, without a shock", elastic=True),
        Event(f"leaves {side} flank", beyond, "between", "elastic teeth part", elastic=True),
    )
)
"""In the order of ``stop_phases.put_stop_events``."""
OUTPUTS = (
    Output("transmission_error", "m", "travel of the pitch circles relative to one another; 0 if rigid without play"),
    Output("dissipated_power", "W", "power dissipated by friction and damping of the teeth"),
)


class Mesh(NamedTuple):
    """Two pitch circles, or a pitch circle and a rack."""

    held: Kind  # the constraint of rigid teeth without play, on the transmission error s
    travel: Callable  # (p, at) -> (s [m], its gradient), (mean travel w [m], its gradient)
    driver: int  # part that drives if power passes forward: 0, the part that s > 0 is ahead, or 1


def with_teeth(kind, mesh, put_motion, radius):
    """Return the ``kind`` of a joint whose two nodes or gears have a ``mesh``, with teeth of all sorts.

    ``prepare`` of the ``kind`` returns the values of the constraint of the mesh; it has four outputs, which
    ``put_motion(p, at, y)`` writes, before the force of the teeth. ``radius`` names the field of the pitch radius.
    """
    kind, dtype = replace(kind, layout=mesh.held.layout), with_fields(mesh.held.dtype, **VALUES)
    flanks, friction = backlash_kind(mesh), tooth_friction_kind(mesh, dtype)
    flank_friction = replace(friction, name=f"{mesh.held.name}_flank_friction", phases=STOP_PHASES)
    nodes = tuple(range(1 + max(int(slot[1:]) for slot in mesh.held.layout)))

    def prepare(d, at_start, context):
        teeth = teeth_values(d, d[radius], context)
        return {**kind.prepare(d, at_start, context), **teeth, **friction_values(d["friction"], mesh.driver),
                "restitution": d["restitution"]}  # fmt: skip

    def parts(d, at_start, context):
        first = Part(flanks if d["backlash"] else mesh.held, nodes, kind.prepare(d, at_start, context))
        if d["friction"] is None:
            return [first]
        dry = flank_friction if d["backlash"] else friction
        return [first, Part(dry, nodes, prepare(d, at_start, context), coupled_to=(0,))]

    held = replace(
        kind, dtype=dtype, fields=(*kind.fields, *FIELDS), outputs=(*kind.outputs, *OUTPUTS),
        prepare=prepare, parts=parts, check=lambda d, at_start: kind.check(d, at_start) + check_teeth(d),
        sample=lambda rng: [*kind.samples(rng), *_samples(kind.samples(rng)[0])],
        observe=_observe_held(mesh, put_motion),
    )  # fmt: skip
    rubbing = _observe_rigid(mesh, put_motion)
    rough = replace(held, name=f"rough_{kind.name}", observe=rubbing)
    loose = replace(
        held, name=f"{kind.name}_backlash", phases=STOP_PHASES, events=EVENTS, event_values=backlash_events(mesh),
        observe=rubbing,
    )  # fmt: skip
    elastic = _elastic(held, mesh, put_motion)

    def variant(d):
        return elastic if d["teeth"] else loose if d["backlash"] else rough if d["friction"] else held

    return replace(held, variant=variant)


def _observe_held(mesh, put_motion):
    """Return ``observe`` of rigid teeth without play and friction; their error is zero."""
    row = 3 * len(mesh.held.layout)

    @kernel
    def observe(p, at, F, y, e):
        put_motion(p, at, y)
        y[4] = at.q[row]

    return observe


def _observe_rigid(mesh, put_motion):
    """Return ``observe`` of rigid teeth with play or friction."""
    travel, row = mesh.travel, 3 * len(mesh.held.layout)

    @kernel
    def observe(p, at, F, y, e):
        put_motion(p, at, y)
        (s, _), (_, along) = travel(p, at)
        rate = rate_of(along, at.v)
        y[4], y[5] = -push(at.phase, at.q[row]), s
        y[6] = tooth_friction(p, -y[4], rate) * rate

    return observe


def _elastic(held, mesh, put_motion):
    """Return the variant of a joint with elastic teeth."""
    residual, put, event_values = elastic_teeth(mesh)

    @kernel
    def observe(p, at, F, y, e):
        put_motion(p, at, y)
        put(p, at, y[4:], e)

    return replace(
        held, name=f"elastic_{held.name}", phases=ELASTIC_PHASES, events=ELASTIC_EVENTS, residual=residual,
        observe=observe, event_values=event_values, parts=lambda d, nodes, context: [],
    )  # fmt: skip


def _samples(first):
    """Return samples of all sorts of teeth from the ``first`` one of a joint, on each flank and between them."""
    values, nodes, _ = first
    dry = {"friction": {"efficiency": 0.8, "backdriving_efficiency": -0.2, "regularization": 0.6}}
    spring = {"stiffness": 40.0, "damping": 3.0, "impact_damping": 0.0, "number": None, "variation": (), "phases": ()}
    rippled = {**spring, "number": 7.0, "variation": [0.3, -0.2], "phases": [0.4, 1.0]}
    damped = {**rippled, "impact_damping": 0.2}
    plays = (1e-6, 2.0, 1e-6)  # random states are beyond a play that is so small
    found = [
        ({**values, "teeth": damped, "backlash": play, **dry}, nodes, phase)
        for phase, play in zip(ELASTIC_PHASES, plays, strict=True)
    ]
    found += [({**values, "teeth": teeth, **dry}, nodes, "between") for teeth in (spring, rippled)]
    for phase in STOP_PHASES:
        found += [({**values, "backlash": 0.02, "restitution": 0.4, **more}, nodes, phase) for more in ({}, dry)]
    return [*found, ({**values, **dry}, nodes, "")]

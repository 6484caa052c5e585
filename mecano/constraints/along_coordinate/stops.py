r"""Latches, locks, stops of a joint coordinate c: constraints that become active at a located event, with a shock.

A latch is reached by c on its way from the initial value, and then holds it, for good or until its release; it does not
lock while the trigger of its release holds. A lock holds c where it is, while a condition is true. A stop is reached at
the ``lower`` or at the ``upper`` value; it pushes c back, :math:`\Phi = \pm (c - c_0) \ge 0`, rebounds with the
coefficient of ``restitution``, and opens where its reaction falls to zero.

The held value :math:`c_0` is that at the end of the last step before the event, the memory of the part: several latches
and stops reached together hold consistent values, to the last bit. Docs: docs/shocks.md.
"""

from dataclasses import replace
from math import inf

from mecano.constraints.along_coordinate.hold import holding
from mecano.constraints.along_coordinate.law import counted
from mecano.constraints.along_coordinate.trigger import TRIGGER, check_trigger, trigger_of
from mecano.constraints.stop_phases import FAR
from mecano.element_interface import CONTACT, LOCK, Event, Kind, Output, Part, Row, named, record
from mecano.jit.kernel import kernel
from mecano.laws.formula import difference_of
from mecano.schema import CONDITION, NUMBER, Field, mapping, requirement, share

LATCH_RECORD = {"value": (), "direction": ()}
STOP_RECORD = {"lower": (), "upper": (), "restitution": ()}
FREE, LOCKED = 0, 1
NEVER = -1.0  # value of an event that does not occur
BETWEEN, LOWER, UPPER = 0, 1, 2
LATCH_PHASES = ("free", "locked")
LOCK_EVENTS = (
    Event("locks", "free", "locked", "the condition becomes true; a shock", LOCK, condition=True),
    Event("unlocks", "locked", "free", "the condition becomes false", condition=True),
)
STOP_PHASES = ("between", "lower stop", "upper stop")
LATCH_EVENTS = (Event("locks", "free", "locked", "it reaches the latch; a shock", LOCK),)
UNLOCKS = Event("unlocks", "locked", "released", "the latch is released, for good", command="release")
OPENS = Event("is held open", "free", "held open", "released before it locks", command=UNLOCKS.command)
CLOSES = Event("may lock", "held open", "free", "the condition of the release is false again", condition=True)


def stop_events(end, reaction):
    """Return the Events at the lower and the upper ``end`` ("stop", "flank"), which its ``reaction`` opens."""
    return tuple(
        event
        for side in ("lower", "upper")
        for event in (
            Event(f"meets {side} {end}", "between", f"{side} stop", f"it rests on the {end} or rebounds; a shock",
                  CONTACT, "restitution"),
            Event(f"leaves {side} {end}", f"{side} stop", "between", f"the {reaction} falls to zero"),
        )
    )  # fmt: skip


@kernel
def put_end_events(g, lower, upper, c, reaction):
    """Write the values of ``stop_events`` for a coordinate c between ``lower`` and ``upper``."""
    g[0], g[1] = lower - c, -reaction
    g[2], g[3] = c - upper, -reaction


@kernel
def side_of(phase):
    """Return 1 at the lower end, -1 at the upper one, the sense in which it pushes the coordinate; 0 between."""
    return 0.0 if phase == BETWEEN else 1.0 if phase == LOWER else -1.0


@kernel
def _locked(p, at):
    return 1.0 if at.phase == LOCKED else 0.0, at.m[0], 0.0


@kernel
def _stopped(p, at):
    return side_of(at.phase), at.m[0], 0.0


def latch_kind(name, doc, coordinate):
    """Return the Kind of a latch of a coordinate."""
    value = counted(coordinate)

    @kernel
    def event_values(p, at, g):
        g[0] = p.direction * (value(p, at) - p.value)

    return _locking_kind(name, doc, coordinate, "latch", LATCH_RECORD, events=LATCH_EVENTS, **named(event_values))


def lock_kind(name, doc, coordinate):
    """Return the Kind of a lock of a coordinate, whose input is positive while it holds."""
    commanded = replace(coordinate, inputs=1)
    command = commanded.row - 1

    @kernel
    def event_values(p, at, g):
        g[0], g[1] = at.q[command], -at.q[command]

    changes = {"inputs": ("closing",), "events": LOCK_EVENTS, **named(event_values)}
    return _locking_kind(name, doc, commanded, "lock", {}, **changes)


def _locking_kind(name, doc, coordinate, end, fields, **changes):
    """Return the Kind that holds a coordinate where it is in the phase "locked"; its ``end`` is "latch" or "lock"."""
    value, row = counted(coordinate), coordinate.row

    @kernel
    def observe(p, at, F, y, e):
        y[0], y[1] = at.q[row], 1.0 if at.phase == LOCKED else 0.0

    @kernel
    def commit(p, at, m_out):
        m_out[0] = at.m[0] if at.phase == LOCKED else value(p, at)

    state = Output(f"{end}ed", "-", "1 while it is locked, otherwise 0")
    return Kind(
        name=name, doc=doc, dtype=record(**coordinate.axes, **fields), **_reaction(coordinate, end, state),
        phases=LATCH_PHASES, **holding(coordinate, _locked), **named(observe, commit), **changes,
    )  # fmt: skip


def releasable_latch_kind(name, doc, coordinate):
    """Return the Kind of a latch of a coordinate that a trigger, its input, releases.

    It does not lock where the trigger already holds. Beyond its place, it locks only on another way through it.
    """
    phases, released = (*LATCH_PHASES, UNLOCKS.after, OPENS.after), replace(coordinate, inputs=1)
    kind, command = latch_kind(name, doc, released), released.row - 1
    beyond, keep = kind.event_values, kind.commit

    @kernel
    def event_values(p, at, g):
        beyond(p, at, g)
        g[0] = g[0] if at.m[1] >= 0.0 else NEVER
        g[3] = -at.q[command]

    @kernel
    def commit(p, at, m_out):
        keep(p, at, m_out)
        m_out[1] = p.direction * (p.value - m_out[0])

    return replace(
        kind, inputs=(UNLOCKS.command,), phases=phases, events=(*LATCH_EVENTS, UNLOCKS, OPENS, CLOSES),
        memory=(*kind.memory, "ahead"), **named(event_values, commit),
    )  # fmt: skip


def stop_kind(name, doc, coordinate):
    """Return the Kind of a pair of stops of a coordinate."""
    value, row = counted(coordinate), coordinate.row

    @kernel
    def observe(p, at, F, y, e):
        side = side_of(at.phase)
        y[0], y[1] = side * at.q[row], 0.0 - side  # not -0

    @kernel
    def event_values(p, at, g):
        put_end_events(g, p.lower, p.upper, value(p, at), at.q[row])

    @kernel
    def commit(p, at, m_out):
        m_out[0] = value(p, at) if at.phase == BETWEEN else at.m[0]

    state = Output("stopped", "-", "-1 at the lower stop, 1 at the upper stop, 0 between them")
    return Kind(
        name=name, doc=doc, dtype=record(**coordinate.axes, **STOP_RECORD),
        **_reaction(coordinate, "stop", state, unilateral=True), phases=STOP_PHASES,
        events=stop_events("stop", "reaction of the stop"), **holding(coordinate, _stopped),
        **named(observe, event_values, commit),
    )  # fmt: skip


def _reaction(coordinate, end, state, unilateral=False):
    """Return the declarations of the reaction of an ``end`` ("latch", "lock", "stop"), and of its ``state``."""
    what, unit = coordinate.load
    doc = f"{what} of the {end} on b, towards increasing {_quantity(coordinate)}"
    return {
        "layout": coordinate.layout, "outputs": (Output(f"{end}_{what}", unit, doc), state), "memory": ("held",),
        "multipliers": (Row(f"{what} of the {end}", unit, coordinate.unit, unilateral),),
    }  # fmt: skip


def _quantity(coordinate):
    return "displacement" if coordinate.sliding else "angle"


LOCKED_LATER = requirement(
    lambda value: value != 0.0,
    "must not be zero: for a joint locked from the start use another kind of joint; 'lock: {while: time < 1}' locks it "
    "while a condition is true",
)
BELOW = requirement(lambda value: value <= 0.0, "must not be greater than zero, the initial value")
ABOVE = requirement(lambda value: value >= 0.0, "must not be less than zero, the initial value")
SOME = requirement(lambda stops: stops["lower"] != -inf or stops["upper"] != inf, "'lower' or 'upper' must be given")


def end_fields(coordinate):
    """Return the fields ``latch``, ``lock`` and ``stops`` of a joint for a coordinate."""
    quantity, unit = _quantity(coordinate), coordinate.unit
    latch = (
        Field(quantity, NUMBER, unit, f"{quantity} since the start at which b locks to a", check=LOCKED_LATER),
        Field("release", TRIGGER, "-", "when it unlocks for good: {time: ...} or {when: ...}; never when absent", None),
    )
    lock = Field("while", CONDITION, "-", f"condition: while it is true b is locked to a, at its {quantity} then")
    stops = (
        Field("lower", NUMBER, unit, f"{quantity} since the start of the lower stop; none when absent", -inf, BELOW),
        Field("upper", NUMBER, unit, f"{quantity} since the start of the upper stop; none when absent", inf, ABOVE),
        Field("restitution", NUMBER, "-", "ratio of the speeds after and before a shock, 0 to 1", 0.0, share),
    )
    return (
        Field("latch", mapping(*latch), "-", "locks when reached, with a shock (docs/shocks.md)", None),
        Field("lock", mapping(lock), "-", "locks while a condition is true: brakes, dog clutches, down-locks", None),
        Field("stops", mapping(*stops), "-", "rigid stops, reached with a shock (docs/shocks.md)", None, SOME),
    )


def check_ends(d):
    """Return errors for the release of a latch."""
    return check_trigger("latch.release", d["latch"]["release"]) if d.get("latch") else []


def end_parts(d, coordinate, axes, start, ends):
    """Return [Part] for the fields ``end_fields`` of a joint; ``axes``, ``start``: axes and initial value of c.

    ``ends`` are the Kinds of a latch for good, of one that is released, of a lock and of stops.
    """
    (*latches, lock, stop), parts = ends, []
    if d["lock"]:
        parts.append(Part(lock, (0, 1), axes, reads=(difference_of(d["lock"]["while"]),)))
    if d["latch"]:
        value, release = d["latch"][_quantity(coordinate)], d["latch"]["release"]
        ends = {"value": start + value, "direction": 1.0 if value > 0.0 else -1.0}
        reads = () if release is None else (trigger_of(release),)
        parts.append(Part(latches[len(reads)], (0, 1), {**axes, **ends}, reads=reads))
    if d["stops"]:
        lower, upper = max(d["stops"]["lower"], -FAR), min(d["stops"]["upper"], FAR)
        ends = {"lower": start + lower, "upper": start + upper, "restitution": d["stops"]["restitution"]}
        parts.append(Part(stop, (0, 1), {**axes, **ends}))
    return parts

"""Release of a joint, cable or spring at a given time or by a condition: from then on it carries no force, permanently.

The trigger is an input, a formula that rises through zero. The release does not change velocities, accelerations jump.
The release of a joint loses no energy; the elastic energy of a cable or spring is lost, and recorded with the event.
"""

from dataclasses import replace
from functools import cache

from mecano.constraints.along_coordinate.hold import RELEASE_PHASES
from mecano.constraints.along_coordinate.trigger import TRIGGER, check_trigger, trigger_of
from mecano.constraints.of_coordinates import RELEASED
from mecano.element_interface import RELEASES, Event
from mecano.schema import Field

INPUT = 12  # local index of the trigger, after the positions and rotations of two nodes
FIRST_ROW = INPUT + 1
COMMAND = "release"
EVENT = Event(RELEASES, "held", "free", "the joint is released", command=COMMAND)
RELEASE = Field("release", TRIGGER, "-", "release of the joint: {time: ...} or {when: ...}", None)


def elastic_release(word):
    """Return the field ``release`` of an elastic element; ``word``: "spring", "cable", its name in texts."""
    doc = f"release of the {word}, which carries no force from then on: {{time: ...}} or {{when: ...}}"
    return Field("release", TRIGGER, "-", doc, None)


ATTACHED_PHASE, RELEASED_PHASE = "attached", "released"
SAMPLE = {"release": {"time": 0.3, "when": None}}


def releasable(kind):
    """Return the ``kind`` of a joint, all of whose axes are held by its parts, with a release; see FIRST_ROW."""

    def held(d, nodes, context):
        return [replace(part, kind=RELEASED[part.kind]) for part in kind.parts(d, nodes, context)]

    return replace(
        kind, name=f"{kind.name}_release", phases=RELEASE_PHASES, events=(EVENT,), inputs=(COMMAND,), parts=held,
        reads=lambda d: [trigger_of(d[COMMAND])], variant=None,
    )  # fmt: skip


def detached(kind, word, forces):
    """Return the ``kind`` of an elastic element that is released into the additional phase "released".

    Once released, it has no force, energy or power; ``forces`` are the indices of its outputs that are zero then. If
    ``forces`` is None, its own functions ensure this in any additional phase. ``word`` is its name in texts.
    """
    phases = kind.phases if kind.events else (ATTACHED_PHASE,)
    releases = tuple(
        Event(RELEASES, phase, RELEASED_PHASE, f"the {word} is released", changes_energy=True, command=COMMAND)
        for phase in phases
    )
    return replace(
        kind, name=f"{kind.name}_release", phases=(*phases, RELEASED_PHASE), events=(*kind.events, *releases),
        inputs=(*kind.inputs, COMMAND), variant=None, reads=lambda d: [*kind.read(d), trigger_of(d[COMMAND])],
        idle=kind.idle if forces is None else {**kind.idle, RELEASED_PHASE: forces},
    )  # fmt: skip


def with_release(kind, word, forces):
    """Return the ``kind`` of an elastic element with the field ``release``; the arguments are those of ``detached``."""
    released = cache(lambda base: detached(base, word, forces))

    def sample(rng):
        found = kind.samples(rng)
        values, nodes, phase = found[0]
        return found + [({**values, **SAMPLE}, nodes, at) for at in (phase or ATTACHED_PHASE, RELEASED_PHASE)]

    return replace(
        kind, fields=(*kind.fields, elastic_release(word)), sample=sample,
        variant=lambda d: kind.chosen(d) if d["release"] is None else released(kind.chosen(d)),
        check=lambda d, nodes: kind.check(d, nodes) + check_trigger("release", d["release"]),
    )  # fmt: skip


def check_release(d, options):
    """Return errors for a release without a time or condition, or with ``options`` that would remain active."""
    if d["release"] is None:
        return []
    given = [name for name in options if d[name]]
    found = [f"'release' and {name!r} exclude one another" for name in given]
    return found + check_trigger("release", d["release"])

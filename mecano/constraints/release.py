"""Release of a joint or a cable at a given time or by a condition: from then on it carries no force, permanently.

The trigger is an input, a formula that rises through zero. The release does not change velocities, accelerations jump.
That of a joint loses no energy; the elastic energy of a cable is lost, and recorded with the event.
"""

from dataclasses import replace

from mecano.constraints.along_coordinate.hold import RELEASE_PHASES
from mecano.constraints.along_coordinate.trigger import TRIGGER, check_trigger, trigger_of
from mecano.constraints.of_coordinates import RELEASED
from mecano.element_interface import Event
from mecano.jit.kernel import kernel
from mecano.schema import Field

INPUT = 12  # local index of the trigger, after the positions and rotations of two nodes
FIRST_ROW = INPUT + 1
EVENT = Event("releases", "held", "free", "the joint is released")
RELEASE = Field("release", TRIGGER, "-", "release of the joint: {time: ...} or {when: ...}", None)
CABLE_RELEASE = Field(
    "release",
    TRIGGER,
    "-",
    "release of the cable, which carries no force from then on: {time: ...} or {when: ...}",
    None,
)
RELEASED_PHASE = "released"
SAMPLE = {"release": {"time": 0.3, "when": None}}


@kernel
def event_values(p, at, g):
    """Write the trigger."""
    g[0] = at.q[INPUT]


def releasable(kind, parts):
    """Return the ``kind`` of a joint, all of whose axes are held by ``parts``, with a release; see FIRST_ROW."""

    def held(d, nodes, context):
        return [replace(part, kind=RELEASED[part.kind]) for part in parts(d, nodes, context)]

    return replace(
        kind, name=f"{kind.name}_release", phases=RELEASE_PHASES, events=(EVENT,), event_values=event_values,
        inputs=("release",), reads=lambda d: [trigger_of(d["release"])], parts=held, variant=None,
    )  # fmt: skip


def cut(kind):
    """Return the ``kind`` of a cable with a release, after which it is in the additional phase "released".

    In this phase its forces must vanish, and its ``observe`` must give neither force nor elastic energy.
    """
    trigger, n_events, n_phases, put = kind.n_local, len(kind.events), len(kind.phases), kind.event_values

    @kernel
    def event_values(p, at, g):
        put(p, at, g)
        for i in range(n_phases):
            g[n_events + i] = at.q[trigger]

    releases = tuple(
        Event("releases", phase, RELEASED_PHASE, "the cable is released", frees_energy=True) for phase in kind.phases
    )
    return replace(
        kind, name=f"{kind.name}_release", phases=(*kind.phases, RELEASED_PHASE), events=(*kind.events, *releases),
        event_values=event_values, inputs=(*kind.inputs, "release"), variant=None,
        reads=lambda d: [*(d[name] for name in kind.inputs), trigger_of(d["release"])],
    )  # fmt: skip


def check_release(d, options):
    """Return errors for a release without a time or condition, or with ``options`` that would remain active."""
    if d["release"] is None:
        return []
    given = [name for name in options if d[name]]
    found = [f"'release' and {name!r} exclude one another" for name in given]
    return found + check_trigger("release", d["release"])

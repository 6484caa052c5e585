"""Release of a joint, cable or spring at a given time or by a condition: from then on it carries no force, permanently.

The trigger is an input, a formula that rises through zero. The release does not change velocities, accelerations jump.
The release of a joint loses no energy; the elastic energy of a cable or spring is lost, and recorded with the event.
"""

from dataclasses import replace
from functools import cache

from mecano.constraints.along_coordinate.trigger import TRIGGER, check_trigger, trigger_of
from mecano.element_interface import RELEASES, Event
from mecano.jit.kernel import kernel
from mecano.schema import Field

HELD = 0
RELEASE_PHASES = ("held", "free")
FIRST_ROW = 13  # of a joint with positions and rotations of two nodes, after the trigger
COMMAND = "release"
EVENT = Event(RELEASES, "held", "free", "the joint is released", command=COMMAND)
RELEASE = Field("release", TRIGGER, "-", "release of the joint: {time: ...} or {when: ...}", None)


def elastic_release(word):
    """Return the field ``release`` of an elastic element; ``word``: "spring", "cable", its name in texts."""
    doc = f"when the {word} ceases to act, for good, and loses its elastic energy: {{time: ...}} or {{when: ...}}"
    return Field("release", TRIGGER, "-", doc, None)


ATTACHED_PHASE, RELEASED_PHASE = "attached", "released"
SAMPLE = {"release": {"time": 0.3, "when": None}}


def releasable(kind, **changes):
    """Return the ``kind`` of a joint, all of whose constraints are its parts, with a release, and these ``changes``.

    Its input precedes the multipliers of the parts, whose local indices are larger by one than without a release.
    """

    def held(d, nodes, context):
        return [replace(part, kind=until_released(part.kind)) for part in kind.parts(d, nodes, context)]

    changes["observe"] = _without_power(changes.get("observe", kind.observe))
    given = {
        "name": f"{kind.name}_release", "phases": RELEASE_PHASES, "events": (EVENT,), "inputs": (COMMAND,),
        "parts": held, "reads": lambda d: [trigger_of(d[COMMAND])], "variant": None,
    }  # fmt: skip
    return replace(kind, **{**given, **changes})


def _without_power(observe):
    """Return ``observe`` of a joint that gives no power in the phase "free"."""

    @kernel
    def observe_until(p, at, F, y, e):
        observe(p, at, F, y, e)
        if at.phase != HELD:
            e[3] = 0.0

    return observe_until


@cache
def until_released(kind):
    """Return the ``kind`` of constraints that are active in the phase "held", and not in the phase "free"."""
    first, force, residual, constraints = kind.first_reaction, kind.force, kind.residual, kind.constraints
    end = first + len(kind.multipliers)

    @kernel
    def force_until(p, at, f, K, C, M):
        if at.phase == HELD:
            force(p, at, f, K, C, M)
        else:
            for row in range(first, end):
                f[row] -= at.q[row]
                K[row, row] -= at.k

    @kernel
    def residual_until(p, at, f):
        if at.phase == HELD:
            residual(p, at, f)
        else:
            for row in range(first, end):
                f[row] -= at.q[row]

    @kernel
    def constraints_until(p, at, g):
        if at.phase == HELD:
            constraints(p, at, g)

    return replace(
        kind, name=f"{kind.name}_release", doc=f"{kind.doc}\n\nUntil it is released.", phases=RELEASE_PHASES,
        force=force and force_until, residual=residual and residual_until, constraints=constraints_until,
        observe=kind.observe and _without_power(kind.observe),
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
    if d.get("release") is None:
        return []
    given = [name for name in options if d[name]]
    found = [f"'release' and {name!r} exclude one another" for name in given]
    return found + check_trigger("release", d["release"])

"""Activation of a spring, bushing, cable, belt or contact at a time or by a condition; before, it exerts no force.

The trigger is an input, a formula that rises through zero. Velocities do not change, accelerations jump. The energy
that the element stores at that instant is given by the surroundings, and recorded with the event as a negative loss.
Activated stress-free, it stores none: its set point is shifted by the extension at that instant, the memory of the
element.
"""

from dataclasses import replace
from functools import cache

from mecano.constraints.along_coordinate.trigger import TIME, WHEN, check_trigger, trigger_of
from mecano.constraints.release import ATTACHED_PHASE
from mecano.element_interface import Event
from mecano.jit.kernel import kernel
from mecano.schema import BOOLEAN, Field, mapping

INACTIVE = "inactive"
COMMAND = "activate"
SHIFT = "shift"  # beginning of the names of the memory of a set point
STRESS_FREE = Field("stress_free", BOOLEAN, "-", "shift its set point so that it begins without force", False)


def since_activation(set_point, i):
    """Return the compiled ``set_point`` (p, at) -> value, rate, shifted by the memory i."""

    @kernel
    def shifted(p, at):
        n, rate = set_point(p, at)
        return n + at.m[i], rate

    return shifted


def activate_field(word, *options):
    """Return the field ``activate`` of an elastic element, with these ``options`` in addition to its trigger.

    ``word`` is its name in texts: "spring", "cable".
    """
    doc = f"when the {word} begins to act, and is given its elastic energy: {{time: ...}} or {{when: ...}}"
    return Field("activate", mapping(TIME, WHEN, *options), "-", doc, None)


def is_stress_free(d):
    """Return whether the deck values ``d`` are those of an element that is activated stress-free."""
    return d["activate"] is not None and d["activate"].get("stress_free", False)


def with_activation(kind, word, forces, stress_free=None, free=STRESS_FREE):
    """Return the ``kind`` of an elastic element with the field ``activate``; ``word`` is its name in texts.

    Before the activation it has no force, energy or power, and its outputs with the indices ``forces`` are zero. If
    ``forces`` is None, the functions of the kind ensure this in any additional phase. If the element may be activated
    stress-free, ``stress_free`` is (its kind with set points that are shifted by the last number of its memory, the
    indices of the outputs that are zero before the activation), and ``free`` the field of the deck for this option.
    """
    families, activated_once = {False: (kind, forces), True: stress_free}, cache(activated)
    given = activate_field(word, *([free] if stress_free else []))

    def variant(d):
        if d["activate"] is None:
            return kind.chosen(d)
        family, zero = families[is_stress_free(d)]
        return activated_once(family.chosen(d), word, zero)

    return replace(
        kind, fields=(*kind.fields, given), variant=variant,
        check=lambda d, nodes: kind.check(d, nodes) + check_trigger("activate", d["activate"]),
        sample=lambda rng: _with_samples(kind.samples(rng), bool(stress_free)),
    )  # fmt: skip


def activated(kind, word, forces):
    """Return the ``kind`` with the phase "inactive", its last, in which it begins; see ``with_activation``.

    The activation leads to the first of its phases that is not left at once: for a spring beyond a stop, or a contact
    that already overlaps, to the phase after the first of its events with a positive value.
    """
    inactive, phases = len(kind.phases), kind.phases if kind.events else (ATTACHED_PHASE,)
    engaged = "between" if "between" in phases else phases[0]
    leaving = tuple(k for k, event in enumerate(kind.events) if event.before == engaged)
    begins = tuple(
        Event("activates", INACTIVE, after, f"the {word} begins to act", changes_energy=True, command=COMMAND, beyond=k)
        for after, k in ((engaged, -1), *((kind.events[k].after, k) for k in leaving))
    )
    return replace(
        kind, name=f"{kind.name}_activate", phases=(*phases, INACTIVE), events=(*kind.events, *begins),
        at_start=lambda p: inactive, inputs=(*kind.inputs, COMMAND), variant=None,
        reads=lambda d: [*kind.read(d), trigger_of(d[COMMAND])], kept=kept_shifts(kind.memory, phases),
        idle=kind.idle if forces is None else {**kind.idle, INACTIVE: forces},
    )  # fmt: skip


def kept_shifts(memory, phases):
    """Return {phase: indices} of a ``memory`` that is kept: shifts of set points change only while inactive."""
    shifts = tuple(i for i, name in enumerate(memory) if name.startswith(SHIFT))
    return {phase: shifts for phase in phases if phase != INACTIVE}


def _with_samples(found, stress_free):
    """Return samples, and the first of them before and after its activation."""
    values, nodes, phase = found[0]
    given = {"time": 0.3, "when": None}
    triggers = [given, {**given, "stress_free": True}] if stress_free else [given]
    phases = INACTIVE, phase or ATTACHED_PHASE
    return found + [({**values, "activate": trigger}, nodes, at) for trigger in triggers for at in phases]

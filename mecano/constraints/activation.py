"""Activation of a spring, bushing, cable, belt or contact at a time or by a condition: before, it exerts no force.

The trigger is an input, a formula that rises through zero. Velocities do not change, accelerations jump. The energy
that the element stores at that instant is given by the surroundings, and recorded with the event as a negative loss.
Activated stress-free, it stores none: its set point is shifted by the extension at that instant, the memory of the
element.
"""

from dataclasses import replace

from mecano.constraints.along_coordinate.trigger import TIME, WHEN, check_trigger, trigger_of
from mecano.constraints.release import ATTACHED_PHASE
from mecano.element_interface import Event
from mecano.jit.kernel import kernel
from mecano.schema import BOOLEAN, Field, mapping

INACTIVE = "inactive"
NEVER = -1.0  # number of an event that does not occur
SHIFT = "shift"  # beginning of the names of the memory of a set point
STRESS_FREE = Field("stress_free", BOOLEAN, "-", "its set point is shifted so that it is without force then", False)


def since_activation(set_point, i):
    """Return the compiled ``set_point`` (p, at) -> value, rate, shifted by the memory i."""

    @kernel
    def shifted(p, at):
        n, rate = set_point(p, at)
        return n + at.m[i], rate

    return shifted


def activate_field(what, *options):
    """Return the field ``activate`` of an elastic element, the ``what``, with these ``options`` besides its trigger."""
    doc = f"activation of the {what}, which exerts no force before: {{time: ...}} or {{when: ...}}"
    return Field("activate", mapping(TIME, WHEN, *options), "-", doc, None)


def is_stress_free(d):
    """Return whether the deck values ``d`` are those of an element that is activated stress-free."""
    return d["activate"] is not None and d["activate"].get("stress_free", False)


def with_activation(kind, what, forces, stress_free=None, free=STRESS_FREE):
    """Return the ``kind`` of an elastic element, the ``what``, with the field ``activate``.

    Before the activation it has no force, energy or power, and its outputs with the indices ``forces`` are zero. If
    these are None, its own functions are so in any additional phase. ``stress_free``, if it may be activated so, is
    (the kind like it whose set points are shifted by the last of its memory, the indices of its outputs that are zero
    before); ``free`` is the option of the deck.
    """
    families, made = {False: (kind, forces), True: stress_free}, {}
    given = activate_field(what, *([free] if stress_free else []))

    def variant(d):
        if d["activate"] is None:
            return kind.chosen(d)
        family, zero = families[is_stress_free(d)]
        base = family.chosen(d)
        if id(base) not in made:
            made[id(base)] = activated(base, what, zero)
        return made[id(base)]

    def check(d, nodes):
        return kind.check(d, nodes) + check_trigger("activate", d["activate"])

    return replace(
        kind, fields=(*kind.fields, given), variant=variant, check=check,
        sample=lambda rng: _with_samples(kind.sample(rng), bool(stress_free)),
    )  # fmt: skip


def activated(kind, what, forces):
    """Return the ``kind`` with the phase "inactive", its last, in which it begins; see ``with_activation``."""
    inactive, phases = len(kind.phases), kind.phases if kind.events else (ATTACHED_PHASE,)
    engaged = "between" if "between" in phases else phases[0]
    leaving = tuple(k for k, event in enumerate(kind.events) if event.before == engaged)
    begins = tuple(
        Event("activates", INACTIVE, after, f"the {what} begins to act", changes_energy=True)
        for after in (engaged, *(kind.events[k].after for k in leaving))
    )
    return replace(
        kind, name=f"{kind.name}_activate", phases=(*phases, INACTIVE), events=(*kind.events, *begins),
        event_values=_event_values(kind, leaving), at_start=lambda p: inactive, inputs=(*kind.inputs, "activate"),
        reads=lambda d: [*kind.read(d), trigger_of(d["activate"])], commit=keeping(kind, inactive), variant=None,
        idle=kind.idle if forces is None else {**kind.idle, INACTIVE: forces},
    )  # fmt: skip


def _event_values(kind, leaving):
    """Return ``event_values`` of an activated kind: its own, and those of the activation.

    The activation leads to the first of its phases that is not left at once: of a spring beyond a stop, of a contact
    that overlaps already, it is that after the first of the events ``leaving`` (indices) whose number is positive.
    """
    trigger, n, put = kind.n_local, len(kind.events), kind.event_values

    @kernel
    def of_one_phase(p, at, g):
        g[0] = at.q[trigger]

    @kernel
    def event_values(p, at, g):
        """Write the own values, and the trigger to the activation whose phase is not left at once."""
        put(p, at, g)
        due, i = at.q[trigger], n
        g[n] = due
        for k in leaving:
            i += 1
            g[i] = NEVER
            if g[k] > 0.0 and g[n] == due:
                g[n], g[i] = NEVER, due

    return event_values if leaving else of_one_phase


def keeping(kind, inactive):
    """Return ``commit`` of a kind, which no longer changes the shift of its set points once it is active."""
    put, n = kind.commit, len(kind.memory)
    first = n - sum(name.startswith(SHIFT) for name in kind.memory)
    if first == n:
        return put

    @kernel
    def commit(p, at, m_out):
        put(p, at, m_out)
        if at.phase != inactive:
            for i in range(first, n):
                m_out[i] = at.m[i]

    return commit


def _with_samples(found, stress_free):
    """Return samples together with those of the first of them that waits, and that was activated."""
    values, nodes, phase = found[0]
    given = {"time": 0.3, "when": None}
    triggers = [given, {**given, "stress_free": True}] if stress_free else [given]
    phases = INACTIVE, phase or ATTACHED_PHASE
    return found + [({**values, "activate": trigger}, nodes, at) for trigger in triggers for at in phases]

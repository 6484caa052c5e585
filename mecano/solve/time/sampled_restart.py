"""Restart between two steps at a sampling time, in one call from the compiled loop over steps (stride.py)."""

from mecano.jit.entry import Records, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats
from mecano.maths.neighbours import successor
from mecano.model.assembly_driver import assemble_residual, commit, loops_at, observe, observe_loops, residual_loops
from mecano.model.state import Instant
from mecano.solve.time.output import OUTPUT, begin_row
from mecano.solve.time.restart import RESTART
from mecano.solve.time.step_control import first_size
from mecano.solve.time.stride import STRIDE, evaluate_events, next_stop, observation_of
from mecano.solve.time.workspace import (
    BEGIN,
    BETWEEN,
    STEP,
    TRIAL,
    copy_history,
    copy_state,
    state_of,
    system_of,
    time_of,
)


@entry
def restart_at_sample(
    integrator: Records(STRIDE), restarting: Records(RESTART), work: Records(STEP), output: Records(OUTPUT)
):
    """Restart at BEGIN just behind the present time; ``restarted`` reports whether that was possible.

    Otherwise BEGIN is as before, for Python to restart there.
    """
    m, r, w = integrator[0], restarting[0], work[0]
    before = w.h, w.stiffness, w.known, w.has, w.age, w.drift, w.spent, w.taken, m.planned
    copy_state(w, BEGIN, BETWEEN)
    t = time_of(w, BEGIN)
    t[0] = successor(t[0])
    m.planned = min(m.planned, m.longest_restart)
    stop, jumps = next_stop(m, w, t[0])
    r.h = first_size(t[0], m.planned, stop, jumps)
    call(r.restart, r.restart_words, 0)
    m.restarted = 1 if r.done and not some_due(m, w) else 0
    if m.restarted:
        m.renewed_tangents += 1
        if r.n_jump_loops:
            follow_jumps(r, w)
        take_restart(m, w)
        if m.records:
            begin_row(output[0], w)
        return
    copy_state(w, BETWEEN, BEGIN)
    copy_history(w, TRIAL, BEGIN)
    w.h, w.stiffness, w.known, w.has, w.age, w.drift, w.spent, w.taken, m.planned = before


@kernel
def some_due(m, w):
    """Return whether an event follows at once, which Python judges."""
    values = floats(m.before_values, m.n_events)
    if m.n_events:
        evaluate_events(m, w, state_of(w, BEGIN), values)
    for i in range(m.n_events):
        if values[i] > 0.0:
            return True
    return False


@kernel
def follow_jumps(r, w):
    """Commit the memories that follow jumps; those before are at BETWEEN."""
    s = state_of(w, BEGIN)
    before = Instant(s.t, s.z, s.v, s.a, s.R, s.phases, state_of(w, BETWEEN).memory)
    commit(loops_at(r.n_jump_loops, r.jump_loops, r.jump_batches), system_of(w), before, s.memory)


@kernel
def take_restart(m, w):
    """Write outputs and energies at BEGIN."""
    s, system = state_of(w, BEGIN), system_of(w)
    assemble_residual(residual_loops(w), system, s, 1.0, 0.0)
    observe(observe_loops(m), observation_of(m), s, floats(system[0].force, system[0].n_slots))
    energy = floats(observation_of(m)[0].energy, 4)
    m.power_dissipated, m.power_given = energy[2], energy[3]

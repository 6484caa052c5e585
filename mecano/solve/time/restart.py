"""Restart of generalized-alpha in compiled code, where forces jump but the motion and all phases do not.

As ``GeneralizedAlpha.start``, for models without released constraints, friction by reactions, and scalars without
inertia besides signals: consistent velocities, signals, accelerations and multipliers, and a new history.
"""

import numpy as np

from mecano.jit.entry import Records, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats, integers, items
from mecano.model.batch import Batch
from mecano.model.loop_records import Pointers, fields
from mecano.model.loops import commit
from mecano.model.numbering import SCALAR, SIGNAL
from mecano.model.state import History, Instant, State
from mecano.solve.events.compliance import soften
from mecano.solve.linear.newton import CONVERGED
from mecano.solve.time.compiled_signals import SIGNALS, CompiledSignals, settle_at_once
from mecano.solve.time.constrained_mass import (
    MASS,
    ConstrainedMass,
    accelerate,
    assemble_mass,
    change,
    deflect,
    factor_mass,
)
from mecano.solve.time.contradictions import AT_START
from mecano.solve.time.generalized_alpha import GeneralizedAlpha
from mecano.solve.time.increments import move
from mecano.solve.time.massless_scalars import DIFFERENCE
from mecano.solve.time.step import gap_of, largest_speeds
from mecano.solve.time.workspace import BEGIN, STEP, TANGENT, TRIAL, copy_state, history_of, state_of, unknowns_of

RESTART = fields(
    floats="h",
    words="done mass signals n_soft soft along displacement still change_step change_step_words restart restart_words",
    loops="jump",
)


@entry
def restart(restarting: Records(RESTART), work: Records(STEP)):
    """Restart at BEGIN for steps of size ``h``; ``done`` reports whether that was possible."""
    r, w = restarting[0], work[0]
    s = state_of(w, BEGIN)
    r.done = 0
    if accelerated(r, w, s):
        begin_history(w, s, r.h, integers(items(r.mass, 1, MASS)[0].kind, w.n_all))
        call(r.change_step, r.change_step_words, 0)
        w.changed = 0  # a change of step size before the first step begins with this history
        r.done = 1 if w.code == CONVERGED else 0


@kernel
def accelerated(r, w, s):
    """Make velocities, signals, accelerations and multipliers consistent; return whether that was possible.

    Positions have the deflection of the compliances, which they would otherwise oscillate about.
    """
    mass = items(r.mass, 1, MASS)
    m = mass[0]
    assemble_mass(mass, s)
    if scalars_are_loose(m) or not factor_mass(m):
        return False
    change_rigidly(m, gap_of(w, s, 1), s.v)
    if contradicted(r, w, s) or not settle_at_once(items(r.signals, 1, SIGNALS), s, DIFFERENCE * r.h):
        return False
    accelerate(m, s, s.v, s.z, s.a)
    if m.n_entries:
        deflect_positions(r, w, m, s)
    return True


@kernel
def change_rigidly(m, gap, x_out):
    """Add to x_out (n_q,) the least change that closes the ``gap`` (n_l,), also of constraints with compliances."""
    x, yielding = change(m, gap, -1.0), floats(m.violated, m.n_l)
    for i in range(m.n_q):
        x_out[i] += x[i]
    if m.n_entries:
        deflect(m, x[m.n_q : m.n], m.k, yielding)
        x = change(m, yielding, 1.0)
        for i in range(m.n_q):
            x_out[i] += x[i]


@kernel
def contradicted(r, w, s):
    """Return whether others leave redundant constraints a rate beyond AT_START, which Python reports."""
    if not r.n_soft:
        return False
    soft, along, rates = integers(r.soft, r.n_soft), integers(r.along, r.n_soft), gap_of(w, s, 1)
    linear, angular = largest_speeds(w, s, r.h)
    for i in range(r.n_soft):
        if abs(rates[soft[i]]) > AT_START * (linear if along[i] else angular):
            return True
    return False


@kernel
def deflect_positions(r, w, m, s):
    """Move the positions of ``s`` by the deflection of the compliances under its reactions."""
    dq, gap, still = floats(r.displacement, w.n_all), gap_of(w, s, 0), floats(r.still, w.n_all)
    starts, columns = integers(m.soft_starts, m.n_l + 1), integers(m.soft_columns, m.n_entries)
    soften(-1.0, starts, columns, floats(m.soft_base, m.n_entries), s.z[w.n_q : w.n], gap)
    of_rates = integers(w.exact_rates, w.n_l)
    for i in range(w.n_l):
        gap[i] = 0.0 if of_rates[i] else gap[i]
    dq[:] = 0.0
    change_rigidly(m, gap, dq)
    copy_state(w, BEGIN, TRIAL)
    begin = state_of(w, TRIAL)
    move(unknowns_of(w), 1.0, Instant(s.t, begin.z, dq, still, begin.R, s.phases, s.memory), s)


@kernel
def scalars_are_loose(m):
    """Return whether scalars other than signals have neither mass nor constraint."""
    loose, kind = integers(m.loose, m.n_q), integers(m.kind, m.n_all)
    for i in range(m.n_q):
        if loose[i] and kind[i] == SCALAR:
            return True
    return False


@kernel
def begin_history(w, s, h, kind):
    """Write the history of a start to BEGIN: accelerations, and slopes of algebraic signals over steps of size h."""
    a, slope, bend = history_of(w, BEGIN)
    for i in range(w.n_all):
        a[i] = s.a[i]
    for i in range(w.n):
        slope[i], bend[i] = h * s.v[i] if kind[i] == SIGNAL else 0.0, 0.0
    floats(w.v_shift, w.n_all)[:] = 0.0
    w.known, w.has, w.age, w.changed, w.factored = 0, 0, 0, 0, 0
    w.h, w.next_h, w.taken, w.stiffness, w.drift, w.spent = h, h, 0.0, 1.0, 0.0, 0.0


class Restart(Pointers):
    """Restarts of a GeneralizedAlpha in compiled code."""

    def __init__(self, method: GeneralizedAlpha):
        super().__init__(RESTART)
        self.method, system, change_step = method, method.system, method.change_step
        self.mass, signals = system.kept(ConstrainedMass), system.kept(CompiledSignals)
        self.mass.solve_by(method.linear)
        n_all = system.numbering.n_all
        self.point_to(
            mass=self.mass.record, signals=signals.record, change_step=change_step.function,
            change_step_words=change_step.words, displacement=np.zeros(n_all), still=np.zeros(n_all),
        )  # fmt: skip
        self.point_to_loops(jump=system.loops(commit, Batch.follows_jumps))
        call = restart.call_from_compiled_code(self.record, method.workspace.record)
        self.point_to(restart=call.function, restart_words=call.words)
        coupled = system.coupled_multipliers, system.sensed_multipliers, system.driving_signals
        self._coupled = any(map(len, coupled))

    def prepare(self) -> bool:
        """Prepare the restarts that follow; return whether the present model admits them."""
        method = self.method
        if self._coupled or len(method.released):
            return False
        self.mass.use(method.compliance)
        self.mass.record["length"] = method.length
        soft, along = method.contradictions.soft
        self.point_to(n_soft=len(soft), soft=soft, along=along)
        return True

    def start(self, s: State, h: float) -> tuple[State, History] | None:
        """Return the same as ``GeneralizedAlpha.start``, or None if this is left to Python."""
        method, w = self.method, self.method.workspace
        if not self.prepare():
            return None
        w.held = None
        method.light.begin(w, s)
        self.record["h"] = h
        restart(self.record, w.record)
        method.linear.solved(w.state(TANGENT, s.phases))
        if not self.record["done"][0]:
            return None
        return w.state(BEGIN, s.phases, s.memory), w.new_history(BEGIN, w.v_shift.copy(), None)

"""Restart of generalized-alpha in compiled code, where forces jump but the motion and all phases do not.

As ``GeneralizedAlpha.start``, for models without redundant constraints, friction by reactions, and scalars without
inertia besides signals: consistent velocities, signals, accelerations and multipliers, and a new history.
"""

from typing import TYPE_CHECKING

from mecano.jit.entry import Records, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats, integers, items
from mecano.model.loop_records import Pointers, fields
from mecano.model.numbering import SCALAR, SIGNAL
from mecano.solve.linear.newton import CONVERGED
from mecano.solve.time.compiled_signals import SIGNALS, CompiledSignals, settle_at_once
from mecano.solve.time.constrained_mass import MASS, ConstrainedMass, accelerate, assemble_mass, change, factor_mass
from mecano.solve.time.massless_scalars import DIFFERENCE
from mecano.solve.time.step import gap_of
from mecano.solve.time.workspace import BEGIN, STEP, TANGENT, history_of, state_of

if TYPE_CHECKING:
    from mecano.model.state import History, State
    from mecano.solve.time.generalized_alpha import GeneralizedAlpha

RESTART = fields(floats="h", words="done mass signals change_step change_step_words restart restart_words")


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
    """Make velocities, signals, accelerations and multipliers consistent; return whether that was possible."""
    mass = items(r.mass, 1, MASS)
    m = mass[0]
    assemble_mass(mass, s)
    if scalars_are_loose(m) or not factor_mass(m):
        return False
    x = change(m, gap_of(w, s, 1), -1.0)
    for i in range(w.n_q):
        s.v[i] += x[i]
    if not settle_at_once(items(r.signals, 1, SIGNALS), s, DIFFERENCE * r.h):
        return False
    accelerate(m, s, s.v, s.z, s.a)
    return True


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

    def __init__(self, method: "GeneralizedAlpha"):
        super().__init__(RESTART)
        self.method, system, change_step = method, method.system, method.change_step
        self.mass, signals = system.kept(ConstrainedMass), system.kept(CompiledSignals)
        self.mass.solve_by(method.linear)
        self.point_to(
            mass=self.mass.record, signals=signals.record, change_step=change_step.function,
            change_step_words=change_step.words,
        )  # fmt: skip
        call = restart.call_from_compiled_code(self.record, method.workspace.record)
        self.point_to(restart=call.function, restart_words=call.words)
        self._by_multipliers = bool(len(system.coupled_multipliers) or len(system.sensed_multipliers))

    def prepare(self) -> bool:
        """Prepare the restarts that follow; return whether the present model admits them."""
        if self._by_multipliers or self.method.compliance is not None:
            return False
        self.mass.use(None)
        self.mass.record["length"] = self.method.length
        return True

    def start(self, s: "State", h: float) -> "tuple[State, History] | None":
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

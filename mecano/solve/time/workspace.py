"""The arrays of one step of generalized-alpha, in the memory that compiled code works on.

A step goes from the state BEGIN to the state TRIAL. TANGENT is the state at which the factored tangent of an earlier
step was evaluated, FORMER is TANGENT before the step size was changed, RENEWED the state of a tangent evaluated in this
step; BETWEEN is interpolated.
"""

import ctypes
import time
from dataclasses import replace
from typing import Any

import numpy as np

from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats, integers, items
from mecano.maths.vector import mat, put, put_matrix, vec
from mecano.model import loops
from mecano.model.assembly import Assembly
from mecano.model.loop_records import SYSTEM, Pointers, fields
from mecano.model.numbering import TRANSLATION, Unknowns
from mecano.model.state import History, Instant, State
from mecano.model.system import System
from mecano.solve.time.run_state import RunState

BEGIN, TRIAL, TANGENT, RENEWED, BETWEEN, FORMER = range(6)
UNCHANGED = 2  # row of ``history``: that at BEGIN before the step size was changed

# Numbers and addresses of a step; the lengths of the arrays stand in the model's numbering (n_...).
STEP = fields(
    floats="due am af beta gamma error length duration tolerance force_tolerance constraint_tolerance "
    "increment_tolerance h taken k penalty cC cM stiffness reach farthest farthest_fixed loudest motion last_motion "
    "change lag turn signalled drift next_drift "
    "spent next_spent last_spent "
    "next_h last_h last_stiffness metric_k similar_stiffness fixed_k fixed_penalty "
    "penalty_share largest_penalty largest_penalty_share",
    words="code begun strict by_velocity paused factored delegated similar masses_kept changed has kept "
    "usable stale pending "
    "renewed age last_age last_has known next_has next_age next_known most most_kept factorizations "
    "n_q n_l n n_all n_rotations n_memory n_phases n_massless n_light n_searched n_entries n_feedback state_size "
    "system residual size increment T kind rotation_dof "
    "derivatives gap exact_rates feedback added masses nnz rows columns diagonal "
    "massless light searched knows_light relax relax_words "
    "soft_starts soft_columns soft_values soft_base soft_kinds soft_in_tangent "
    "entry_places entry_values solve solve_words solve_results substitute substitute_words clock clock_id now "
    "states phases history guess carried v_shift report",
    loops="residual tangent constraint",
)


@kernel
def unknowns_of(w):
    """Return the Unknowns of the model."""
    return Unknowns(integers(w.kind, w.n_all), integers(w.rotation_dof, w.n_rotations), w.n_q, w.n)


@kernel
def state_of(w, which):
    """Return one of the states."""
    at, n, m = w.states + 8 * which * w.state_size, w.n_all, w.n_rotations
    z, v, a, R = floats(at, n), floats(at + 8 * n, n), floats(at + 16 * n, n), floats(at + 24 * n, (m, 3, 3))
    memory = floats(at + 24 * n + 72 * m, w.n_memory)
    return Instant(time_of(w, which)[0], z, v, a, R, integers(w.phases, w.n_phases), memory)


@kernel
def start_spins(w, which):
    """Return the angular velocities (n_rotations, 3) at the beginning of the step within which one of the states is."""
    m = w.n_rotations
    return floats(w.states + 8 * ((which + 1) * w.state_size - 1 - 3 * m), (m, 3))


@kernel
def put_start_spins(w):
    """Enter the angular velocities at BEGIN as those from which the step to TRIAL starts."""
    v, spins, rotation_dof = state_of(w, BEGIN).v, start_spins(w, TRIAL), integers(w.rotation_dof, w.n_rotations)
    for r in range(w.n_rotations):
        put(spins[r], 0, vec(v, rotation_dof[r]))


@kernel
def time_of(w, which):
    """Return the time [s] of one of the states, as an array (1,)."""
    return floats(w.states + 8 * ((which + 1) * w.state_size - 1), 1)


@kernel
def copy_state(w, source, target):
    """Copy one of the states to the place of another one."""
    read = floats(w.states + 8 * source * w.state_size, w.state_size)
    written = floats(w.states + 8 * target * w.state_size, w.state_size)
    for i in range(w.state_size):
        written[i] = read[i]


@kernel
def copy_to_state(w, s, target):
    """Copy the motion of an Instant to the place of one of the states."""
    out = state_of(w, target)
    time_of(w, target)[0] = s.t
    for i in range(w.n_all):
        out.z[i], out.v[i], out.a[i] = s.z[i], s.v[i], s.a[i]
    for i in range(w.n_rotations):
        put_matrix(out.R[i], mat(s.R[i]))
    for i in range(w.n_memory):
        out.memory[i] = s.memory[i]


@kernel
def history_of(w, which):
    """Return the algorithmic acceleration (n_all,), slope (n,) and bend (n,) at BEGIN or TRIAL, or UNCHANGED."""
    at = w.history + 8 * which * (w.n_all + 2 * w.n)
    slope = at + 8 * w.n_all
    return floats(at, w.n_all), floats(slope, w.n), floats(slope + 8 * w.n, w.n)


@kernel
def copy_history(w, source, target):
    """Copy one of the rows of ``history``."""
    n = w.n_all + 2 * w.n
    read, written = floats(w.history + 8 * source * n, n), floats(w.history + 8 * target * n, n)
    for i in range(n):
        written[i] = read[i]


@kernel
def system_of(w):
    """Return the record SYSTEM as an array (1,)."""
    return items(w.system, 1, SYSTEM)


@kernel
def in_own_axes(w):
    """Return the array T (3 n_rotations, 3, 3) with identities: derivatives of material variations by themselves."""
    T = floats(w.T, (3 * w.n_rotations, 3, 3))
    for r in range(3 * w.n_rotations):
        for i in range(3):
            for j in range(3):
                T[r, i, j] = 1.0 if i == j else 0.0
    return T


@kernel
def is_due(w):
    """Return whether Python must check for signals now, by the wall-clock time."""
    call(w.clock, w.clock_id, w.now)
    now = integers(w.now, 2)
    return now[0] + 1e-9 * now[1] >= w.due


class Workspace(Pointers):
    """The arrays of steps of one system, and the record STEP that holds their addresses.

    Parameters
    ----------
    system : System
    assembly : Assembly
        Written by the steps.
    fixed : dict
        Fields of STEP that never change: numbers, and arrays in the place of their addresses.
    """

    def __init__(self, system: System, assembly: Assembly, **fixed: Any):
        of = system.numbering
        super().__init__(STEP)
        self.system, self._shapes = system, (of.n_all, len(of.rotation_dof))
        state = system.initial_state()
        n_all, n_rotations, n_memory = of.n_all, len(of.rotation_dof), len(state.memory)
        self.states = np.zeros((6, 3 * n_all + 12 * n_rotations + n_memory + 1))
        self.phases = np.zeros(len(state.phases), np.int64)
        self.farthest_fixed = float(np.abs(state.z[of.n :][of.kind[of.n :] == TRANSLATION]).max(initial=0.0))  # m
        self.history = np.zeros((3, n_all + 2 * of.n))
        self.guess, self.v_shift, self.report = np.zeros((2, of.n)), np.zeros(n_all), np.zeros(8)
        self.carried = np.zeros((4, n_all))
        own = ("states", "phases", "history", "guess", "carried", "v_shift", "report")
        self.held: RunState | None = None  # from which compiled code can step on without anything being entered
        self.assembly = assembly  # which holds the arrays of the record SYSTEM
        self.point_to(
            n_q=of.n_q, n_l=of.n_l, n=of.n, n_all=n_all, n_rotations=n_rotations, n_memory=n_memory,
            n_phases=len(state.phases), state_size=self.states.shape[1], clock=CLOCK, clock_id=time.CLOCK_MONOTONIC,
            now=np.zeros(2, np.int64), system=assembly.record, residual=assembly.residual, size=assembly.size,
            kind=of.kind.copy(), rotation_dof=of.rotation_dof, T=np.tile(np.eye(3), (3 * n_rotations, 1, 1)),
            exact_rates=of.of_rates.astype(np.int64), derivatives=np.zeros((4, of.n_l, 3)), gap=np.zeros(of.n_l),
            nnz=system.nnz, rows=system.rows, columns=system.cols, diagonal=system.diagonal,
            **{name: getattr(self, name) for name in own}, **fixed,
        )  # fmt: skip
        self.point_to_loops(
            residual=system.loops(loops.residual), tangent=system.loops(loops.tangent),
            constraint=system.loops(loops.constraint_derivatives),
        )  # fmt: skip

    def parts(self, which: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return views of z, v, a (n_all,), R (n_rotations, 3, 3) and memory (n_memory,) of one of the states."""
        row, (n, m) = self.states[which], self._shapes
        end = 3 * n + 9 * m
        return row[:n], row[n : 2 * n], row[2 * n : 3 * n], row[3 * n : end].reshape(-1, 3, 3), row[end : -1 - 3 * m]

    def start_spins(self, which: int) -> np.ndarray:
        """Return the angular velocities (n_rotations, 3) at the beginning of the step of one of the states: a view."""
        return self.states[which, -1 - 3 * self._shapes[1] : -1].reshape(-1, 3)

    def put_state(self, which: int, s: State) -> None:
        """Enter a State, with its phases."""
        for place, values in zip(self.parts(which), (s.z, s.v, s.a, s.R, s.memory), strict=True):
            place[...] = values
        if s.start_spins is not None:
            self.start_spins(which)[...] = s.start_spins
        self.states[which, -1] = s.t
        self.phases[:] = s.phases

    def put_step(self, before: State, after: State) -> None:
        """Enter the states between which a step was made."""
        self.held = None
        self.put_state(BEGIN, before)
        self.put_state(TRIAL, after)

    def state(self, which: int, phases: np.ndarray, memory: np.ndarray | None = None) -> State:
        """Return one of the states as a State with these ``phases`` (n_elements,), which are not copied."""
        z, v, a, R, own = [part.copy() for part in self.parts(which)]
        spins = self.start_spins(which).copy() if which in (TANGENT, RENEWED, FORMER) else None
        return State(float(self.states[which, -1]), z, v, a, R, phases, own if memory is None else memory, spins)

    def put_history(self, history: History) -> None:
        """Enter the History with which a step begins."""
        n, row = self.system.n, self.history[BEGIN]
        row[: len(history.a)], row[-2 * n : -n], row[-n:] = history.a, history.slope, history.bend
        self.v_shift[:] = history.v_shift
        r = self.record
        r["known"], r["stiffness"], r["h"], r["changed"] = history.known, history.k, history.h, False
        r["taken"] = history.taken
        r["has"], r["age"], r["drift"] = history.tangent is not None, history.age, history.drift
        r["spent"] = history.spent

    def put_unchanged(self, history: History) -> None:
        """Enter the History at BEGIN before the change of its step size; a second change starts from it again."""
        n, row, r = self.system.n, self.history[UNCHANGED], self.record
        row[: len(history.a)], row[-2 * n : -n], row[-n:] = history.a, history.slope, history.bend
        r["changed"], r["last_h"], r["last_stiffness"] = True, history.h, history.k
        r["last_has"], r["last_age"], r["last_spent"] = history.tangent is not None, history.age, history.spent

    def last_history(self, tangent: State | None) -> History:
        """Return the History at BEGIN with which the last step ended; ``tangent`` is a State."""
        r = self.record[0]
        if not r["changed"]:
            return self.new_history(BEGIN, self.v_shift.copy(), tangent)
        former = self.state(FORMER, self.phases.copy()) if r["last_has"] else None
        changed = self.new_history(UNCHANGED, np.zeros(len(self.v_shift)), former)
        return replace(
            changed,
            h=float(r["last_h"]),
            k=float(r["last_stiffness"]),
            age=int(r["last_age"]),
            tangent=former,
            spent=float(r["last_spent"]),
        )

    def new_history(self, which: int, v_shift: np.ndarray, tangent: State | None) -> History:
        """Return the History at BEGIN or TRIAL; ``v_shift`` (n_all,) is not copied, ``tangent`` a State."""
        n, row, r, now = self.system.n, self.history[which], self.record[0], "next_" if which == TRIAL else ""
        return History(
            row[: -2 * n].copy(), float(r["h"]), row[-2 * n : -n].copy(), row[-n:].copy(), int(r[f"{now}known"]),
            v_shift, float(r["stiffness"]), tangent if r[f"{now}has"] else None, int(r[f"{now}age"]),
            float(r[f"{now}drift"]), float(r["h"] if now else r["taken"]), float(r[f"{now}spent"]),
        )  # fmt: skip


CLOCK = ctypes.cast(ctypes.CDLL(None).clock_gettime, ctypes.c_void_p).value

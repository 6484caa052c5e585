r"""Consistent signals in compiled code: values of algebraic signals and rates of those with a state.

Newton's method; the Jacobian :math:`J` of the equations by these unknowns is eliminated without exchanging rows, so
that no decision depends on the units of the signals: for :math:`D^{-1} J D` each pivot has the same share of its terms.
What needs more, a loop that may be singular or values that are not finite, is left to signals.py.
"""

import numpy as np

from mecano.jit.entry import Records, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import floats, integers, items
from mecano.maths.vector import mat, put_matrix
from mecano.model import loops
from mecano.model.assembly import Assembly
from mecano.model.assembly_driver import assemble, assemble_residual, residual_loops, tangent_loops
from mecano.model.batch import Batch
from mecano.model.loop_records import SYSTEM, Pointers, fields
from mecano.model.numbering import Unknowns
from mecano.model.state import Instant, State
from mecano.model.system import System
from mecano.solve.diagnostics.scales import SMALL
from mecano.solve.time.increments import move
from mecano.solve.time.signals import TOLERANCE

# Numbers and addresses; ``own``: the unknowns of the n signals; ``places`` (n_entries,) in J of entries of the tangent
SIGNALS = fields(
    words="n own states n_entries entries places J factors by_rates r reads_rates regular "
    "n_q n_unknowns n_all n_rotations kind rotation_dof system T still z v R",
    loops="residual tangent",
)
EVALUATIONS, MOST_KEPT, SLOW = 5, 4, 0.1  # of J; iterations with one J; factor by which each reduces the correction
JUMP = 1e-9  # of a signal: a greater change of one that has converged is a jump
LEAST_PIVOT = 1e-8  # of its terms, which cancel: signals.py decides whether the equations are singular


@entry
def settle_at_once(signals: Records(SIGNALS), s_out: Instant, dt: float) -> bool:
    """Do as ``signals.settle_signals``; return whether that was possible."""
    q = signals[0]
    if not solved(q, s_out):
        return False
    own = integers(q.own, q.n)
    for i in range(q.n):
        s_out.a[own[i]] = 0.0
    if not find_rates(q, s_out, dt):
        return False
    return q.reads_rates == 0 or (solved(q, s_out) and find_rates(q, s_out, dt))


@kernel
def solved(q, s):
    """Solve the equations by Newton's method; return whether it converges, and leaves the J of the solution.

    Just behind a jump of a law of the time, the last correction may be the rounding that carries the time over it.
    """
    for _ in range(EVALUATIONS):
        if not factored(q, s):
            return False
        if corrected(q, s):
            find_change(q, s)
            if largest_share(q, s) <= JUMP:
                return factored(q, s)
    return False


@kernel
def factored(q, s):
    """Evaluate J and eliminate it, unless it is the last one; return whether it is regular."""
    system = items(q.system, 1, SYSTEM)
    data = floats(system[0].data, system[0].n_data)
    entries, places = integers(q.entries, q.n_entries), integers(q.places, q.n_entries)
    J, by_rates, states = floats(q.J, q.n * q.n), floats(q.by_rates, q.n * q.n), integers(q.states, q.n)
    T = floats(q.T, (3 * q.n_rotations, 3, 3))
    assemble(tangent_loops(q), system, s, T, 1.0, 0.0, 0.0, 1.0, 0.0)
    q.reads_rates = 0
    for i in range(q.n_entries):
        by_rates[places[i]] = data[entries[i]]
        if data[entries[i]] != 0.0 and not states[places[i] % q.n]:
            q.reads_rates = 1
    assemble(tangent_loops(q), system, s, T, 1.0, 0.0, 1.0, 0.0, 0.0)
    changed = False
    for i in range(q.n_entries):
        now = by_rates[places[i]] if states[places[i] % q.n] else data[entries[i]]
        changed = changed or now != J[places[i]]
        J[places[i]] = now
    if changed:
        q.regular = 1 if eliminated(J, floats(q.factors, q.n * q.n), q.n) else 0
    return q.regular == 1


@kernel
def eliminated(J, LU, n):
    """Write the triangular factors of J (n * n,); return whether it is regular."""
    for i in range(n * n):
        LU[i] = J[i]
    regular = True
    for i in range(n):
        for j in range(n):
            size = abs(LU[i * n + j])
            for k in range(min(i, j)):
                term = LU[i * n + k] * LU[k * n + j]
                LU[i * n + j] -= term
                size += abs(term)
            if j < i:
                LU[i * n + j] /= LU[j * n + j]
            elif j == i and not abs(LU[i * n + i]) > LEAST_PIVOT * size:
                regular = False
    return regular


@kernel
def corrected(q, s):
    """Correct the signals with the last J a few times; return whether they converge."""
    last = np.inf
    for _ in range(MOST_KEPT):
        change = correction(q, s)
        if change <= TOLERANCE:
            return True
        if not change <= SLOW * last:
            return False
        last = change
    return False


@kernel
def correction(q, s):
    """Correct the signals once; return the largest change over its signal, or nan."""
    find_change(q, s)
    r, own, states = floats(q.r, q.n), integers(q.own, q.n), integers(q.states, q.n)
    for i in range(q.n):
        values = s.v if states[i] else s.z
        values[own[i]] -= r[i]
    return largest_share(q, s)


@kernel
def find_change(q, s):
    """Write the change of the signals that follows from their residual into r (n,)."""
    system, r, own = items(q.system, 1, SYSTEM), floats(q.r, q.n), integers(q.own, q.n)
    assemble_residual(residual_loops(q), system, s, 1.0, 0.0)
    residual = floats(system[0].residual, q.n_all)
    for i in range(q.n):
        r[i] = residual[own[i]]
    substitute(floats(q.factors, q.n * q.n), q.n, r)


@kernel
def largest_share(q, s):
    """Return the largest change in r over its signal, or nan."""
    r, own, states, largest = floats(q.r, q.n), integers(q.own, q.n), integers(q.states, q.n), 0.0
    for i in range(q.n):
        value = s.v[own[i]] if states[i] else s.z[own[i]]
        share = abs(r[i]) / max(abs(value), SMALL)
        largest = share if not share <= largest else largest
    return largest


@kernel
def substitute(LU, n, r):
    """Replace r (n,) by the solution x of J x = r."""
    for i in range(n):
        for j in range(i):
            r[i] -= LU[i * n + j] * r[j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            r[i] -= LU[i * n + j] * r[j]
        r[i] /= LU[i * n + i]


@kernel
def find_rates(q, s, dt):
    """Set rates and second rates by forward differences over ``dt`` of second order; return whether that succeeded."""
    first, second = ahead(q, s, dt, 0), ahead(q, s, 2.0 * dt, 1)
    if not (corrected(q, first) and corrected(q, second)):
        return False
    own, states = integers(q.own, q.n), integers(q.states, q.n)
    for i in range(q.n):
        j = own[i]
        if states[i]:
            s.a[j] = (4.0 * first.v[j] - 3.0 * s.v[j] - second.v[j]) / (2.0 * dt)
        else:
            s.v[j] = (4.0 * first.z[j] - 3.0 * s.z[j] - second.z[j]) / (2.0 * dt)
    return True


@kernel
def ahead(q, s, dt, which):
    """Return the state moved by dt [s] at its velocities, in one of two places; it shares phases and memory."""
    n, m = q.n_all, q.n_rotations
    z, v, still = floats(q.z + 8 * which * n, n), floats(q.v + 8 * which * n, n), floats(q.still, n)
    R = floats(q.R + 72 * which * m, (m, 3, 3))
    for i in range(n):
        z[i], v[i] = s.z[i], s.v[i]
    for r in range(m):
        put_matrix(R[r], mat(s.R[r]))
    of = Unknowns(integers(q.kind, n), integers(q.rotation_dof, m), q.n_q, q.n_unknowns)
    moved = Instant(s.t + dt, z, v, still, R, s.phases, s.memory)
    move(of, dt, Instant(s.t, s.z, s.v, still, s.R, s.phases, s.memory), moved)
    return moved


class CompiledSignals(Pointers):
    """The equations of the signals of a system, and the record SIGNALS that holds the addresses of their arrays."""

    def __init__(self, system: System):
        super().__init__(SIGNALS)
        of, own, self.assembly = system.numbering, np.flatnonzero(system.signals), Assembly(system)
        n, n_rotations, place = len(own), len(of.rotation_dof), np.full(system.n, -1)
        place[own] = np.arange(n)
        rows, columns = place[system.rows], place[system.cols]
        entries = np.flatnonzero((rows >= 0) & (columns >= 0))
        self.point_to(
            n=n, own=own, states=system.states[own].astype(np.int64), n_entries=len(entries), entries=entries,
            places=rows[entries] * n + columns[entries], J=np.zeros(n * n), factors=np.zeros(n * n),
            by_rates=np.zeros(n * n), r=np.zeros(n), n_q=of.n_q, n_unknowns=of.n, n_all=of.n_all,
            n_rotations=n_rotations, kind=of.kind, rotation_dof=of.rotation_dof, system=self.assembly.record,
            T=np.tile(np.eye(3), (3 * n_rotations, 1, 1)), still=np.zeros(of.n_all),
            z=np.zeros((2, of.n_all)), v=np.zeros((2, of.n_all)), R=np.zeros((2, n_rotations, 3, 3)),
        )  # fmt: skip
        residual, tangent = (system.loops(purpose, Batch.has_signals) for purpose in (loops.residual, loops.tangent))
        self.point_to_loops(residual=residual, tangent=tangent)

    def settle(self, s: State, dt: float) -> bool:
        """Set the signals of ``s`` in place as ``signals.settle_signals``; return whether that was possible.

        Otherwise ``s`` is not changed.
        """
        own, motion = self.array("own"), (s.z, s.v, s.a)
        before = [x[own] for x in motion]
        done = settle_at_once(self.record, s, dt)
        for x, values in zip(motion, before, strict=True) if not done else ():
            x[own] = values
        return done

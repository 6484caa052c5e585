r"""The mass matrix under constraints, in compiled code: the matrix of consistent.py, and solutions with its factors.

.. math:: \begin{bmatrix} M + p B^T B & -k B^T \\ -k B & -k^2 c \end{bmatrix}, \qquad p = k

with the mean k of the masses. It belongs to a *bare* state, without accelerations and multipliers.
"""

import numpy as np

from mecano.jit.entry import Records, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats, integers, items
from mecano.model.assembly import Assembly
from mecano.model.assembly_driver import (
    add,
    assemble,
    assemble_residual,
    constraint_derivatives,
    constraint_loops,
    loops_at,
    residual_loops,
    tangent_loops,
)
from mecano.model.batch import Batch
from mecano.model.loop_records import SYSTEM, Pointers, fields
from mecano.model.loops import constraint_derivatives as of_constraints
from mecano.model.loops import residual as of_residuals
from mecano.model.loops import tangent as of_tangents
from mecano.model.numbering import LENGTH_CONSTRAINT, ROTATION, SCALAR
from mecano.model.state import Instant, State
from mecano.model.system import System
from mecano.solve.events.compliance import OF_RELEASED, RELEASED_COMPLIANCE, Compliance, compliance_fields
from mecano.solve.linear import multifrontal
from mecano.solve.linear.rounding import TINY
from mecano.solve.linear.sparse import ACCEPT_BELOW, LinearSolver

# Numbers and addresses; flags of the unknowns: ``signals``, ``massless`` (by their kinds), ``loose`` (at the state)
MASS = fields(
    floats="k length softness penalty_share",
    words="n_q n_l n n_all n_rotations nnz n_data system z a T kind rows columns diagonal signals massless loose alone "
    "by_positions plain penalized derivatives "
    "n_entries penalty_factors entry_places soft_starts soft_columns soft_base soft_kinds soft_in_tangent deflection "
    "violated solve solve_words solve_results substitute substitute_words right solution",
    loops="residual tangent position rate constraint",
)
SECOND = 2  # column of the second rates of the constraints
SOFTNESS = 1e-8  # of the accelerations, those by compliances: rounding disturbs the reactions by as much of themselves


@entry
def assemble_mass(mass: Records(MASS), s: Instant):
    """Assemble the matrix at the positions of ``s``, and find k and the unknowns that are ``loose``.

    Loose unknowns have neither mass nor constraint and stay at rest; massless scalars follow their own equations.
    """
    m = mass[0]
    bare, system, T = bare_state(m, s, s.v), items(m.system, 1, SYSTEM), floats(m.T, (3 * m.n_rotations, 3, 3))
    assemble(tangent_loops(m), system, bare, T, 1.0, 0.0, 0.0, 0.0, 1.0)
    m.k = mean_mass(m)
    penalty, loops = m.k * m.penalty_share, loops_at(m.n_position_loops, m.position_loops, m.position_batches)
    add(loops, system, bare, T, m.k, penalty, 1.0, 0.0)
    if m.n_rate_loops:
        add_rates(m, system, bare, T)
    hold_loose(m)
    soften_mass(m)


@kernel
def values_of(m):
    """Return the values (n_data,) of the matrix."""
    return floats(items(m.system, 1, SYSTEM)[0].data, m.n_data)


@kernel
def bare_state(m, s, v):
    """Return ``s`` with velocities ``v`` and without accelerations and multipliers; overwrites the last one."""
    z, a = floats(m.z, m.n_all), floats(m.a, m.n_all)
    for i in range(m.n_all):
        z[i] = 0.0 if m.n_q <= i < m.n else s.z[i]
    return Instant(s.t, z, v, a, s.R, s.phases, s.memory)


@kernel
def mean_mass(m):
    """Return the mean of the masses, inertias over the squared length; mark signals and massless unknowns as loose."""
    data, diagonal, kind = values_of(m), integers(m.diagonal, m.n), integers(m.kind, m.n_all)
    loose, signals, total, number = integers(m.loose, m.n_q), integers(m.signals, m.n_q), 0.0, 0
    for i in range(m.n_q):
        x = data[diagonal[i]]
        loose[i] = 1 if x <= 0.0 or signals[i] else 0  # signals may not be known yet
        if not loose[i]:
            total += x / (m.length * m.length) if kind[i] == ROTATION else x
            number += 1
    return total / number if number and total > 0.0 else 1.0


@kernel
def add_rates(m, system, bare, T):
    """Replace the gradients of constraints on velocities by positions with those by velocities."""
    loops, own = loops_at(m.n_rate_loops, m.rate_loops, m.rate_batches), system[0].data
    add_alone(m, system, loops, bare, T, 0.0, 1.0, 0.0, m.by_positions)
    add_alone(m, system, loops, bare, T, 0.0, 0.0, 1.0, m.plain)
    add_alone(m, system, loops, bare, T, m.k * m.penalty_share, 0.0, 1.0, m.penalized)
    system[0].data = own
    data, rows, columns = values_of(m), integers(m.rows, m.nnz), integers(m.columns, m.nnz)
    by_positions, plain, penalized = (floats(m.by_positions, m.nnz), floats(m.plain, m.nnz), floats(m.penalized, m.nnz))
    for i in range(m.nnz):
        of_motion = plain[i] if rows[i] >= m.n_q else penalized[i] - plain[i]
        data[i] += by_positions[i] if columns[i] >= m.n_q else of_motion


@kernel
def add_alone(m, system, loops, bare, T, penalty, cK, cC, place):
    """Write the tangent of these loops alone to the values (n_data,) at ``place``."""
    system[0].data = place
    floats(place, m.n_data)[:] = 0.0
    add(loops, system, bare, T, m.k, penalty, cK, cC)


@kernel
def hold_loose(m):
    """Hold the unknowns that are loose, apart from all others: rows and columns of k alone."""
    data, diagonal = values_of(m), integers(m.diagonal, m.n)
    loose, massless, signals = integers(m.loose, m.n_q), integers(m.massless, m.n_q), integers(m.signals, m.n_q)
    kind, alone, several = integers(m.kind, m.n_all), integers(m.alone, m.n), 0
    for i in range(m.n_q):
        if loose[i] and not (massless[i] or signals[i]) and data[diagonal[i]] > 0.0:
            loose[i] = 0
        alone[i] = 1 if signals[i] or (loose[i] and kind[i] == SCALAR) else 0
        several += alone[i]
    if several:
        rows, columns = integers(m.rows, m.nnz), integers(m.columns, m.nnz)
        for i in range(m.nnz):
            if alone[rows[i]] or alone[columns[i]]:
                data[i] = 0.0
    for i in range(m.n_q):
        if loose[i]:
            data[diagonal[i]] = m.k


@kernel
def soften_mass(m):
    """Add the compliances of redundant constraints (compliance.py), -k^2 c times their ``softness`` in this metric.

    In the metric of positions the least of them would be lost in the rounding of the elimination.
    """
    n, data = m.n_entries, values_of(m)
    m.softness = softness(m)
    base, kinds, in_tangent = floats(m.soft_base, n), integers(m.soft_kinds, n), floats(m.soft_in_tangent, n)
    places = integers(m.entry_places, n)
    for i in range(n):
        c = base[i] * (RELEASED_COMPLIANCE / m.k if kinds[i] == OF_RELEASED else m.softness)
        data[places[i]] -= m.k * m.k * c * in_tangent[i]


@kernel
def softness(m):
    """Return the factor [1/s2] with which the largest compliance is SOFTNESS over the mean mass."""
    base, kinds, places = (
        floats(m.soft_base, m.n_entries),
        integers(m.soft_kinds, m.n_entries),
        integers(m.entry_places, m.n_entries),
    )
    rows, columns, kind = integers(m.rows, m.nnz), integers(m.columns, m.nnz), integers(m.kind, m.n_all)
    largest = TINY
    for i in range(m.n_entries):
        if kinds[i] != OF_RELEASED and places[i] < m.nnz and rows[places[i]] == columns[places[i]]:
            lever = 1.0 if kind[rows[places[i]]] == LENGTH_CONSTRAINT else m.length
            largest = max(largest, base[i] * lever * lever)
    return SOFTNESS / (m.k * largest)


@kernel
def factor_mass(m):
    """Factor the matrix; return whether the fixed order of elimination suffices."""
    floats(m.right, m.n)[:] = 0.0
    call(m.solve, m.solve_words, m.solve_results)
    return floats(m.solve_results, 3)[2] <= ACCEPT_BELOW


@kernel
def change(m, rates, share):
    """Return the least change (n,) of positions or velocities with these ``rates`` (n_l,), times a ``share``.

    The impulses over k, without those of the penalty, follow after its first n_q entries.
    """
    b = floats(m.right, m.n)
    for i in range(m.n_q):
        b[i] = 0.0
    for i in range(m.n_l):
        b[m.n_q + i] = -m.k * share * rates[i]
    call(m.substitute, m.substitute_words, 0)
    return floats(m.solution, m.n)


@kernel
def accelerate(m, s, v, z_out, a_out):
    """Compute the accelerations and multipliers in ``z_out`` at the positions of ``s`` and velocities ``v``."""
    bare, system = bare_state(m, s, v), items(m.system, 1, SYSTEM)
    g, b, x = floats(m.derivatives, (m.n_l, 3)), floats(m.right, m.n), floats(m.solution, m.n)
    constraint_derivatives(constraint_loops(m), system, bare, g)
    assemble_residual(residual_loops(m), system, bare, 1.0, 0.0)
    residual, loose, signals = floats(system[0].residual, m.n_q), integers(m.loose, m.n_q), integers(m.signals, m.n_q)
    for i in range(m.n_q):
        b[i] = 0.0 if loose[i] else -residual[i]
    for i in range(m.n_l):
        b[m.n_q + i] = m.k * g[i, SECOND]
    call(m.substitute, m.substitute_words, 0)
    for i in range(m.n_q):
        a_out[i] = a_out[i] if signals[i] else x[i]
    for i in range(m.n_q, m.n_all):
        a_out[i] = 0.0
    factors = floats(m.penalty_factors, m.n_l)
    for i in range(m.n_l):
        penalty = m.k * m.penalty_share * factors[i]
        z_out[m.n_q + i] = m.k * x[m.n_q + i] + penalty * g[i, SECOND]  # to the bits of consistent.py
    if m.n_entries:
        kept = floats(m.violated, m.n_l)
        deflect(m, x[m.n_q : m.n], m.k, kept)
        share(m, z_out[m.n_q : m.n], kept, a_out)


@kernel
def deflect(m, reactions, factor, rates_out):
    """Compute the rates (n_l,) at which compliances yield to reactions (n_l,) times a factor."""
    c, kinds, starts, columns = (
        floats(m.soft_base, m.n_entries),
        integers(m.soft_kinds, m.n_entries),
        integers(m.soft_starts, m.n_l + 1),
        integers(m.soft_columns, m.n_entries),
    )
    for i in range(m.n_l):
        rates_out[i] = 0.0
        for j in range(starts[i], starts[i + 1]):
            if kinds[j] != OF_RELEASED:
                rates_out[i] += m.softness * factor * c[j] * reactions[columns[j]]


@kernel
def share(m, reactions, violated, a):
    """Change reactions (n_l,) to those of least norm and the same effect, which the compliances do not disturb.

    ``violated`` (n_l,) are the second rates that the compliances have left to the accelerations ``a`` (n_q,), which
    receive them (``Consistent.share``).
    """
    yielding, signals = floats(m.deflection, m.n_l), integers(m.signals, m.n_q)
    for turn in range(2):
        deflect(m, reactions, 1.0 if turn else -1.0, yielding)
        for i in range(m.n_l):
            yielding[i] += violated[i] if turn else 0.0
        x = change(m, yielding, 1.0)
        for i in range(m.n_q):
            a[i] += 0.0 if signals[i] else x[i]
        for i in range(m.n_l):
            reactions[i] += m.k * x[m.n_q + i]


class ConstrainedMass(Pointers):
    """The arrays of the matrix of a system, and the record MASS that holds their addresses."""

    def __init__(self, system: System):
        super().__init__(MASS)
        of, self.assembly, self._compliance = system.numbering, Assembly(system), None
        self.point_to(
            n_q=of.n_q, n_l=of.n_l, n=of.n, n_all=of.n_all, n_rotations=len(of.rotation_dof), nnz=system.nnz,
            n_data=system.n_data, system=self.assembly.record, z=np.zeros(of.n_all), a=np.zeros(of.n_all),
            T=np.tile(np.eye(3), (3 * len(of.rotation_dof), 1, 1)), kind=of.kind, rows=system.rows, columns=system.cols,
            diagonal=system.diagonal, signals=system.signals.astype(np.int64),
            massless=system.massless.astype(np.int64), loose=np.zeros(of.n_q, np.int64), alone=np.zeros(of.n, np.int64),
            derivatives=np.zeros((of.n_l, 3)), penalty_factors=system.penalty_factors,
            penalty_share=system.penalty_share, deflection=np.zeros(of.n_l),
            violated=np.zeros(of.n_l), right=np.zeros(of.n),
            solution=np.zeros(of.n), solve_results=np.zeros(len(multifrontal.solve.returns)),
            **compliance_fields(None),
        )  # fmt: skip
        self.point_to_loops(
            residual=system.loops(of_residuals), tangent=system.loops(of_tangents),
            constraint=system.loops(of_constraints),
            position=system.loops(of_tangents, Batch.constrains_positions),
            rate=system.loops(of_tangents, Batch.constrains_rates),
        )  # fmt: skip
        n = system.n_data if of.of_rates.any() else 0
        self.point_to(by_positions=np.zeros(n), plain=np.zeros(n), penalized=np.zeros(n))

    def use(self, compliance: Compliance | None) -> None:
        """Set the compliances of redundant constraints; None for none."""
        if compliance is not self._compliance:
            self._compliance = compliance
            self.point_to(**compliance_fields(compliance))

    def solve_by(self, linear: LinearSolver) -> None:
        """Factor and solve by this LinearSolver in compiled code."""
        self._calls = new, kept = linear.calls(self.assembly.data, self.array("right"), self.array("solution"))
        self.point_to(solve=new.function, solve_words=new.words, substitute=kept.function, substitute_words=kept.words)

    def at(self, s: State, length: float, compliance: Compliance | None) -> tuple[np.ndarray, np.ndarray, float, float]:
        """Return the values (n_data,) of the matrix at ``s``, the loose unknowns (n_q,) bool, k and the softness."""
        self.use(compliance)
        self.record["length"] = length
        assemble_mass(self.record, s)
        k, softness = float(self.record["k"][0]), float(self.record["softness"][0])
        return self.assembly.data.copy(), self.array("loose").astype(bool), k, softness

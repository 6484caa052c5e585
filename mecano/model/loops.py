"""Compiled loops over the elements of a batch: gather, call the function of the kind, scatter.

There is one loop per purpose: a C function of two addresses, those of the batch record (BATCH) and of the system record
(SYSTEM), which hold everything else. It serves all kinds, whose functions it calls by their addresses (``function``,
``inertia`` of the batch; element_calls.py). assembly_driver.py calls the loops of all batches one after the other.
"""

from mecano.jit.kernel import kernel
from mecano.jit.memory import LANES, call, floats, integers
from mecano.maths.vector import put, vec
from mecano.model.gather_scatter import (
    add_energies,
    add_forces,
    add_masses,
    clear_other_events,
    gather,
    gather_observed,
    is_idle,
    keep_memory,
    lag_of,
    put_commands,
    put_observation,
    work,
)
from mecano.model.loop_records import batch_at, system_at
from mecano.model.seeded_duals import add_columns, add_dual_force, gather_duals, gather_motion, put_derivatives, seed


@kernel
def turn_columns(A, c, T):
    """Multiply the three columns of A from c on by T, in place."""
    for i in range(A.shape[0]):
        a0, a1, a2 = A[i, c], A[i, c + 1], A[i, c + 2]
        for j in range(3):
            A[i, c + j] = a0 * T[0, j] + a1 * T[1, j] + a2 * T[2, j]


def tangent(batch, system):
    """Compute forces, their magnitudes, masses, and the tangent cK K T_q + cC C T_v + cM M T_a (System.assemble)."""
    b, s = batch_at(batch), system_at(system)
    n, n_vectors, lag, cK, cC, cM = b.n_local, b.n_vectors, lag_of(b, s), s.cK, s.cC, s.cM
    dofs, rots, columns = (
        integers(b.dofs, (b.n, n)),
        integers(b.rots, (b.n, b.n_rotations)),
        integers(b.columns, b.n_rotations),
    )
    slots, entries = integers(b.slots, (b.n, n)), integers(b.entries, (b.n, n, n))
    q, v, a, R = work(b)
    f, K, C, M = floats(b.f, n), floats(b.K, (n, n)), floats(b.C, (n, n)), floats(b.M, (n, n))
    T, data_out, first_row = floats(s.T, (3, s.n_rotations, 3, 3)), floats(s.data, s.n_data), n - b.n_multipliers
    force_out, size_out, mass_out = floats(s.force, s.n_slots), floats(s.size, s.n_slots), floats(s.mass, s.n_slots)
    moves = b.of_rates or not b.n_multipliers  # constraints on positions have neither damping nor mass
    for e in range(b.n):
        b.element = e
        f[:] = 0.0
        K[:] = 0.0
        C[:] = 0.0
        M[:] = 0.0
        gather(dofs[e], rots[e], n_vectors, s, q, v, a, R)
        call(b.function, batch, system)
        if b.of_rates:
            for i in range(first_row, n):
                f[i] *= lag
                for j in range(n):
                    K[i, j] *= lag
                    C[i, j] *= lag
        add_forces(f, slots[e], n_vectors, force_out, size_out)
        for i in range(n):
            mass_out[slots[e, i]] += abs(M[i, i])
        for r in range(b.n_rotations):
            at = rots[e, r]
            turn_columns(K, columns[r], T[0, at])
            if moves:
                turn_columns(C, columns[r], T[1, at])
                turn_columns(M, columns[r], T[2, at])
        for i in range(n):
            row = entries[e, i]
            for c in range(0, 3 * n_vectors, 3):
                block = cK * vec(K[i], c) + cC * vec(C[i], c) + cM * vec(M[i], c)
                put(data_out, row[c], vec(data_out, row[c]) + block)
            for j in range(3 * n_vectors, n):
                data_out[row[j]] += cK * K[i, j] + cC * C[i, j] + cM * M[i, j]


def dual_tangent(batch, system):
    """Compute forces, their magnitudes, masses, and the tangent (as ``tangent``) of a kind with a residual only.

    One pass for LANES local unknowns gives their columns. If no columns are requested, one gives the forces alone.
    """
    b, s = batch_at(batch), system_at(system)
    lag = lag_of(b, s)
    for e in range(b.n):
        b.element = e
        if is_idle(b, s):
            continue
        gather_duals(b, s)
        for first in range(0, b.n_local if s.columns else 1, LANES):
            seed(b, s, first)
            call(b.function, batch, system)
            add_columns(b, s, first, lag)
        add_dual_force(b, s, lag)
        if b.inertia != 0 and s.columns:
            floats(b.f, b.n_local)[:] = 0.0
            call(b.inertia, batch, system)
            add_masses(b, s)


def residual(batch, system):
    """Compute forces and their magnitudes."""
    b, s = batch_at(batch), system_at(system)
    n, n_vectors, lag = b.n_local, b.n_vectors, lag_of(b, s)
    dofs, rots, slots = integers(b.dofs, (b.n, n)), integers(b.rots, (b.n, b.n_rotations)), integers(b.slots, (b.n, n))
    q, v, a, R = work(b)
    f, force_out, size_out = floats(b.f, n), floats(s.force, s.n_slots), floats(s.size, s.n_slots)
    for e in range(b.n):
        b.element = e
        if is_idle(b, s):
            continue
        f[:] = 0.0
        gather(dofs[e], rots[e], n_vectors, s, q, v, a, R)
        call(b.function, batch, system)
        if b.of_rates:
            for i in range(n - b.n_multipliers, n):
                f[i] *= lag
        add_forces(f, slots[e], n_vectors, force_out, size_out)


def constraint_derivatives(batch, system):
    """Compute values, rates and second rates of the constraints; the last are slopes along the motion."""
    b, s = batch_at(batch), system_at(system)
    for e in range(b.n):
        b.element = e
        gather_motion(b, s)
        call(b.function, batch, system)
        put_derivatives(b, s)


def observe(batch, system):
    """Compute outputs and energies of the elements, and add the energies to the totals."""
    b, s = batch_at(batch), system_at(system)
    for e in range(b.n):
        b.element = e
        gather_observed(b, s)
        put_observation(b, s)
        call(b.function, batch, system)
        add_energies(b, s)


def event_values(batch, system):
    """Compute one number for each event of each element; -inf for an event that is not monitored."""
    b, s = batch_at(batch), system_at(system)
    for e in range(b.n):
        b.element = e
        gather_observed(b, s)
        call(b.function, batch, system)
        put_commands(b, s)
        clear_other_events(b, s)


def commit(batch, system):
    """Write the memories after an accepted step."""
    b, s = batch_at(batch), system_at(system)
    for e in range(b.n):
        b.element = e
        gather_observed(b, s)
        call(b.function, batch, system)
        keep_memory(b, s)

"""Compiled loops over all elements of one kind: gather, call the element's function, scatter.

There is one loop per kind and purpose: a C function of two addresses, those of the batch record (BATCH) and of the
system record (SYSTEM), which hold everything else. assembly_driver.py calls them one after the other.

The functions here are templates: loop_code.py puts the function of the element among their globals. What does not
depend on the kind stands in gather_scatter.py.
"""

from mecano.element_interface import Place
from mecano.jit.kernel import kernel
from mecano.jit.memory import floats, integers, items
from mecano.jit.null_matrix import NULL_MATRIX
from mecano.model.gather_scatter import (
    add_column,
    add_dual_force,
    add_energies,
    add_masses,
    clear_other_events,
    dual_constraints,
    dual_forces,
    dual_place,
    event_values_of,
    gather,
    gather_duals,
    gather_motion,
    gather_observed,
    gather_unknowns,
    given,
    idle_phases,
    is_idle,
    keep_memory,
    masses,
    moving_place,
    new_memory_of,
    observation,
    place,
    put_commands,
    put_derivatives,
    put_dual_derivatives,
    seed,
    work,
)
from mecano.model.loop_records import batch_at, system_at


@kernel
def no_inertia(p, at, m):
    """Write no masses."""


@kernel
def no_event_values(p, at, g):
    """Write no numbers: all events are by command."""


def tangent(batch, system):
    """Compute forces, their magnitudes, masses, and the tangent cK K + cC C + cM M."""
    b, s = batch_at(batch), system_at(system)
    n, p = b.n_local, items(b.p, b.n, parameters)  # noqa: F821
    memory, phase, laws = given(b, s)
    dofs, rots, columns = (
        integers(b.dofs, (b.n, n)),
        integers(b.rots, (b.n, b.n_rotations)),
        integers(b.columns, b.n_rotations),
    )
    slots, entries = integers(b.slots, (b.n, n)), integers(b.entries, (b.n, n, n))
    q, v, a, R = work(b)
    f, K, C, M = floats(b.f, n), floats(b.K, (n, n)), floats(b.C, (n, n)), floats(b.M, (n, n))
    T, data_out, first_row = floats(s.T, (s.n_rotations, 3, 3)), floats(s.data, s.n_data), n - b.n_multipliers
    penalty = s.penalty * s.lag if of_rates else s.penalty  # noqa: F821
    force_out, size_out, mass_out = floats(s.force, s.n_slots), floats(s.size, s.n_slots), floats(s.mass, s.n_slots)
    for e in range(b.n):
        f[:] = 0.0
        K[:] = 0.0
        C[:] = 0.0
        M[:] = 0.0
        gather(dofs[e], rots[e], s, q, v, a, R)
        at = Place(s.t, phase[e], s.k, penalty, laws, memory[e], q, v, a, R)
        function(p[e], at, f, K, C, M)  # noqa: F821
        if of_rates:  # noqa: F821
            for i in range(first_row, n):
                f[i] *= s.lag
                for j in range(n):
                    K[i, j] *= s.lag
                    C[i, j] *= s.lag
        for i in range(n):
            slot = slots[e, i]
            force_out[slot] += f[i]
            size_out[slot] += abs(f[i])
            mass_out[slot] += abs(M[i, i])
        # K is the derivative with respect to the material variation; T maps it to the rotation increment
        for r in range(b.n_rotations):
            c, turn = columns[r], T[rots[e, r]]
            for i in range(n):
                k0, k1, k2 = K[i, c], K[i, c + 1], K[i, c + 2]
                for j in range(3):
                    K[i, c + j] = k0 * turn[0, j] + k1 * turn[1, j] + k2 * turn[2, j]
        cK, cC, cM = s.cK, s.cC, s.cM
        for i in range(n):
            for j in range(n):
                data_out[entries[e, i, j]] += cK * K[i, j] + cC * C[i, j] + cM * M[i, j]


def dual_tangent(batch, system):
    """Compute forces, their magnitudes, masses, and the tangent cK K + cC C + cM M of a kind with a residual only.

    One pass per local unknown j gives column j. If no columns are wanted, one pass gives the forces alone.
    """
    b, s = batch_at(batch), system_at(system)
    p, lag = items(b.p, b.n, parameters), s.lag if of_rates else 1.0  # noqa: F821
    for e in range(b.n):
        if is_idle(b, s, e):
            continue
        gather_duals(b, s, e)
        for j in range(b.n_local if s.columns else 1):
            seed(b, s, e, j)
            function(p[e], dual_place(b, s, e, lag), dual_forces(b))  # noqa: F821
            add_column(b, s, e, j, lag)
        add_dual_force(b, s, e, lag)
        if has_inertia and s.columns:  # noqa: F821
            inertia(p[e], place(b, s, e), masses(b))  # noqa: F821
            add_masses(b, s, e)


def residual(batch, system):
    """Compute forces and their magnitudes."""
    b, s = batch_at(batch), system_at(system)
    n, p = b.n_local, items(b.p, b.n, parameters)  # noqa: F821
    memory, phase, laws = given(b, s)
    dofs, rots, slots = integers(b.dofs, (b.n, n)), integers(b.rots, (b.n, b.n_rotations)), integers(b.slots, (b.n, n))
    q, v, a, R = work(b)
    f, force_out, size_out = floats(b.f, n), floats(s.force, s.n_slots), floats(s.size, s.n_slots)
    penalty = s.penalty * s.lag if of_rates else s.penalty  # noqa: F821
    for e in range(b.n):
        f[:] = 0.0
        gather(dofs[e], rots[e], s, q, v, a, R)
        at = Place(s.t, phase[e], s.k, penalty, laws, memory[e], q, v, a, R)
        function(p[e], at, f, NULL_MATRIX, NULL_MATRIX, NULL_MATRIX)  # noqa: F821
        if of_rates:  # noqa: F821
            for i in range(n - b.n_multipliers, n):
                f[i] *= s.lag
        for i in range(n):
            slot = slots[e, i]
            force_out[slot] += f[i]
            size_out[slot] += abs(f[i])


def plain_residual(batch, system):
    """Compute forces and their magnitudes for a kind with a residual only."""
    b, s = batch_at(batch), system_at(system)
    n, p = b.n_local, items(b.p, b.n, parameters)  # noqa: F821
    memory, phase, laws = given(b, s)
    dofs, rots, slots = integers(b.dofs, (b.n, n)), integers(b.rots, (b.n, b.n_rotations)), integers(b.slots, (b.n, n))
    q, v, a, R = work(b)
    f, force_out, size_out = floats(b.f, n), floats(s.force, s.n_slots), floats(s.size, s.n_slots)
    first_row, penalty = n - b.n_multipliers, s.penalty * s.lag if of_rates else s.penalty  # noqa: F821
    idle = idle_phases(b)
    for e in range(b.n):
        if idle[phase[e], 0]:
            continue
        f[:] = 0.0
        gather(dofs[e], rots[e], s, q, v, a, R)
        function(p[e], Place(s.t, phase[e], s.k, penalty, laws, memory[e], q, v, a, R), f)  # noqa: F821
        if of_rates:  # noqa: F821
            for i in range(first_row, n):
                f[i] *= s.lag
        for i in range(n):
            slot = slots[e, i]
            force_out[slot] += f[i]
            size_out[slot] += abs(f[i])


def constraint_derivatives(batch, system):
    """Compute values, rates and second rates of the constraints."""
    b, s = batch_at(batch), system_at(system)
    p, g = items(b.p, b.n, parameters), floats(b.g, (b.n_multipliers, 3))  # noqa: F821
    for e in range(b.n):
        gather_unknowns(b, s, e)
        function(p[e], place(b, s, e), g)  # noqa: F821
        put_derivatives(b, s, e)


def dual_constraint_derivatives(batch, system):
    """Compute values, rates and second rates of the constraints; the last are slopes along the motion."""
    b, s = batch_at(batch), system_at(system)
    p = items(b.p, b.n, parameters)  # noqa: F821
    for e in range(b.n):
        gather_motion(b, s, e)
        function(p[e], moving_place(b, s, e), dual_constraints(b))  # noqa: F821
        put_dual_derivatives(b, s, e)


def observe(batch, system):
    """Compute outputs and energies of the elements, and add the energies to the totals."""
    b, s = batch_at(batch), system_at(system)
    p = items(b.p, b.n, parameters)  # noqa: F821
    for e in range(b.n):
        gather_observed(b, s, e)
        F, y, energies = observation(b, s, e)
        function(p[e], place(b, s, e), F, y, energies)  # noqa: F821
        add_energies(b, s, e)


def event_values(batch, system):
    """Compute one number for each event of each element; -inf for an event that is not monitored."""
    b, s = batch_at(batch), system_at(system)
    p = items(b.p, b.n, parameters)  # noqa: F821
    for e in range(b.n):
        gather_observed(b, s, e)
        function(p[e], place(b, s, e), event_values_of(b, s, e))  # noqa: F821
        put_commands(b, s, e)
        clear_other_events(b, s, e)


def commit(batch, system):
    """Write the memories after an accepted step."""
    b, s = batch_at(batch), system_at(system)
    p = items(b.p, b.n, parameters)  # noqa: F821
    for e in range(b.n):
        gather_observed(b, s, e)
        function(p[e], place(b, s, e), new_memory_of(b, s, e))  # noqa: F821
        keep_memory(b, s, e)

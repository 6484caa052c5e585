"""Compiled loops over all elements of one kind: gather, call the element's function, scatter.

There is one loop per kind and purpose: a C function of two addresses, those of the batch record (BATCH) and of the
system record (SYSTEM), which hold everything else. assembly_driver.py calls them one after the other.

The functions here are templates: loop_code.py puts the function of the element among their globals.
"""

import math

import numpy as np

from mecano.element_interface import Place
from mecano.jit.kernel import kernel
from mecano.jit.memory import floats, integers, items
from mecano.jit.null_matrix import NULL_MATRIX
from mecano.maths.dual import DUAL, Dual
from mecano.maths.vector import Vec3, mat, skew, vec


def fields(floats="", words=""):
    """Return the type of a record of numbers and of words (addresses, lengths)."""
    return np.dtype([(name, "f8") for name in floats.split()] + [(name, "i8") for name in words.split()], align=True)


# Addresses of arrays, and their lengths (n, n_...); shapes as in batch.py.
BATCH = fields(
    words="n n_local n_rotations n_multipliers first_reaction n_reactions n_output_dofs n_forces n_outputs n_phases "
    "n_events n_memory p dofs rots slots columns entries multipliers output_dofs output_slots "
    "q v a R f K C M seeded F g idle before first_phase first_memory first_output first_event"
)
# Addresses of the arrays of the system, of the state on which the loops work, and of the values that they write.
SYSTEM = fields(
    floats="t k penalty lag cK cC cM",
    words="n_all n_rotations z v a R T phases memory memory_out "
    "n_states states n_laws laws n_slots force size mass slot_dof residual scale n_data data "
    "n_transmitted partition_starts partition_members transmitted outputs energies energy event_values "
    "n_constraints constraint_derivatives",
)
SIZE = DUAL.itemsize


def record(dtype, **values):
    """Return an array (1,) of one record."""
    out = np.zeros(1, dtype)
    for name, value in values.items():
        out[name] = value
    return out


@kernel
def batch_at(address):
    """Return the record of a batch."""
    return items(address, 1, BATCH)[0]


@kernel
def system_at(address):
    """Return the record of the system."""
    return items(address, 1, SYSTEM)[0]


@kernel
def given(b, s):
    """Return the memories (n, n_memory) and phases (n,) of a batch, and the table of laws."""
    memory = floats(s.memory + 8 * b.first_memory, (b.n, b.n_memory))
    return memory, integers(s.phases + 8 * b.first_phase, b.n), floats(s.laws, s.n_laws)


@kernel
def work(b):
    """Return work arrays for local unknowns, velocities, accelerations (n_local,), rotations (n_rotations, 3, 3)."""
    n = max(b.n_local, b.n_output_dofs)
    return floats(b.q, n), floats(b.v, n), floats(b.a, n), floats(b.R, (b.n_rotations, 3, 3))


@kernel
def idle_phases(b):
    """Return flags (n_phases, 1 + n_outputs): the elements are idle, and which of their outputs vanish then."""
    return integers(b.idle, (b.n_phases, 1 + b.n_outputs))


@kernel
def gather(dofs, rots, s, q_out, v_out, a_out, R_out):
    """Copy local unknowns, velocities, accelerations (n_local,) and rotations (n_rotations, 3, 3) of one element."""
    z, v, a = floats(s.z, s.n_all), floats(s.v, s.n_all), floats(s.a, s.n_all)
    R = floats(s.R, (s.n_rotations, 3, 3))
    for i in range(dofs.shape[0]):
        d = dofs[i]
        q_out[i] = z[d]
        v_out[i] = v[d]
        a_out[i] = a[d]
    for r in range(rots.shape[0]):
        for i in range(3):
            for j in range(3):
                R_out[r, i, j] = R[rots[r], i, j]


@kernel
def seeded(b):
    """Return arrays of Duals for q, v, a, forces (n_local,), and rotations (n_rotations, 3, 3)."""
    n, place, size = b.n_local, b.seeded, SIZE * b.n_local
    q, v, a = items(place, n, DUAL), items(place + size, n, DUAL), items(place + 2 * size, n, DUAL)
    return q, v, a, items(place + 3 * size, n, DUAL), items(place + 4 * size, (b.n_rotations, 3, 3), DUAL)


@kernel
def rotation_of(j, columns):
    """Return the index of the rotation to which the local unknown j belongs, or -1."""
    for r in range(columns.shape[0]):
        if columns[r] <= j < columns[r] + 3:
            return r
    return -1


@kernel
def put_constant(R_out, R):
    """Store a constant rotation."""
    for i in range(3):
        for j in range(3):
            R_out[i, j] = R[i][j]


@kernel
def put_turned(R_out, R, turn):
    """Store R (1 + hat(turn) epsilon)."""
    change = R @ skew(turn)
    for i in range(3):
        for j in range(3):
            R_out[i, j].slope = change[i][j]


@kernel
def no_inertia(p, at, m):
    """Write no masses."""


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

    One pass per local unknown j gives column j: q_j varies by cK, v_j by cC, a_j by cM, a rotation by R hat(cK T_j).
    """
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
    q_1, v_1, a_1, f_1, R_1 = seeded(b)
    T, data_out = floats(s.T, (s.n_rotations, 3, 3)), floats(s.data, s.n_data)
    first_row, penalty = n - b.n_multipliers, s.penalty * s.lag if of_rates else s.penalty  # noqa: F821
    force_out, size_out, mass_out = floats(s.force, s.n_slots), floats(s.size, s.n_slots), floats(s.mass, s.n_slots)
    m, idle = floats(b.f, n), idle_phases(b)
    for e in range(b.n):
        if idle[phase[e], 0]:
            continue
        gather(dofs[e], rots[e], s, q, v, a, R)
        for i in range(n):
            q_1[i] = q[i]
            v_1[i] = v[i]
            a_1[i] = a[i]
        for r in range(b.n_rotations):
            put_constant(R_1[r], mat(R[r]))
        for j in range(n):
            for i in range(n):
                f_1[i] = 0.0
            turned = rotation_of(j, columns)
            if turned < 0:
                reaction = b.first_reaction <= j < b.first_reaction + b.n_reactions
                q_1[j].slope = s.cK * (s.k if reaction else 1.0)
            else:
                turn = T[rots[e, turned]]
                c = j - columns[turned]
                put_turned(R_1[turned], mat(R[turned]), s.cK * Vec3(turn[0, c], turn[1, c], turn[2, c]))
            v_1[j].slope = s.cC
            a_1[j].slope = s.cM
            at = Place(s.t, phase[e], s.k, penalty, laws, memory[e], q_1, v_1, a_1, R_1)
            function(p[e], at, f_1)  # noqa: F821
            for i in range(n):
                lag = s.lag if of_rates and i >= first_row else 1.0  # noqa: F821
                data_out[entries[e, i, j]] += lag * f_1[i].slope
            q_1[j].slope = 0.0
            v_1[j].slope = 0.0
            a_1[j].slope = 0.0
            if turned >= 0:
                put_constant(R_1[turned], mat(R[turned]))
        for i in range(n):
            f = f_1[i].value * (s.lag if of_rates and i >= first_row else 1.0)  # noqa: F821
            force_out[slots[e, i]] += f
            size_out[slots[e, i]] += abs(f)
        if has_inertia:  # noqa: F821
            m[:] = 0.0
            inertia(p[e], Place(s.t, phase[e], s.k, penalty, laws, memory[e], q, v, a, R), m)  # noqa: F821
            for i in range(n):
                mass_out[slots[e, i]] += abs(m[i])


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
    n, p = b.n_local, items(b.p, b.n, parameters)  # noqa: F821
    memory, phase, laws = given(b, s)
    dofs, rots = integers(b.dofs, (b.n, n)), integers(b.rots, (b.n, b.n_rotations))
    multipliers = integers(b.multipliers, (b.n, b.n_multipliers))
    q, v, a, R = work(b)
    g, g_out = floats(b.g, (b.n_multipliers, 3)), floats(s.constraint_derivatives, (s.n_constraints, 3))
    for e in range(b.n):
        gather(dofs[e], rots[e], s, q, v, a, R)
        function(p[e], Place(s.t, phase[e], s.k, s.penalty, laws, memory[e], q, v, a, R), g)  # noqa: F821
        for i in range(b.n_multipliers):
            for j in range(3):
                g_out[multipliers[e, i], j] = g[i, j]


def dual_constraint_derivatives(batch, system):
    """Compute values, rates and second rates of the constraints; the last are slopes along the motion."""
    b, s = batch_at(batch), system_at(system)
    n, p = b.n_local, items(b.p, b.n, parameters)  # noqa: F821
    memory, phase, laws = given(b, s)
    dofs, rots = integers(b.dofs, (b.n, n)), integers(b.rots, (b.n, b.n_rotations))
    columns, multipliers = integers(b.columns, b.n_rotations), integers(b.multipliers, (b.n, b.n_multipliers))
    q, v, a, R = work(b)
    q_1, v_1, _, _, R_1 = seeded(b)
    g_1 = items(b.seeded + 2 * SIZE * b.n_local, (b.n_multipliers, 2), DUAL)  # in the place of accelerations, forces
    g_out = floats(s.constraint_derivatives, (s.n_constraints, 3))
    for e in range(b.n):
        gather(dofs[e], rots[e], s, q, v, a, R)
        for i in range(n):
            q_1[i] = Dual(q[i], v[i])
            v_1[i] = Dual(v[i], a[i])
        for r in range(b.n_rotations):
            put_constant(R_1[r], mat(R[r]))
            put_turned(R_1[r], mat(R[r]), vec(v, columns[r]))
        at = Place(Dual(s.t, 1.0), phase[e], s.k, s.penalty, laws, memory[e], q_1, v_1, a, R_1)
        for i in range(b.n_multipliers):
            g_1[i, 0], g_1[i, 1] = 0.0, 0.0
        function(p[e], at, g_1)  # noqa: F821
        for i in range(b.n_multipliers):
            g_out[multipliers[e, i], 0] = g_1[i, 0].value
            g_out[multipliers[e, i], 1] = g_1[i, 1].value
            g_out[multipliers[e, i], 2] = g_1[i, 1].slope


def observe(batch, system):
    """Compute outputs and energies of the elements, and add the energies to the totals."""
    b, s = batch_at(batch), system_at(system)
    p = items(b.p, b.n, parameters)  # noqa: F821
    memory, phase, laws = given(b, s)
    dofs, rots = integers(b.output_dofs, (b.n, b.n_output_dofs)), integers(b.rots, (b.n, b.n_rotations))
    slots, force, F = (
        integers(b.output_slots, (b.n, b.n_forces)),
        floats(s.transmitted, s.n_transmitted),
        floats(b.F, b.n_forces),
    )
    q, v, a, R = work(b)
    y_out = floats(s.outputs + 8 * b.first_output, (b.n, b.n_outputs))
    e_out, total_out = floats(s.energies + 32 * b.first_phase, (b.n, 4)), floats(s.energy, 4)
    idle = idle_phases(b)
    for e in range(b.n):
        gather(dofs[e], rots[e], s, q, v, a, R)
        for i in range(b.n_forces):
            F[i] = force[slots[e, i]]
        y_out[e] = 0.0
        e_out[e] = 0.0
        function(p[e], Place(s.t, phase[e], s.k, s.penalty, laws, memory[e], q, v, a, R), F, y_out[e], e_out[e])  # noqa: F821
        if idle[phase[e], 0]:
            e_out[e] = 0.0
            for i in range(b.n_outputs):
                if idle[phase[e], 1 + i]:
                    y_out[e, i] = 0.0
        for i in range(4):
            total_out[i] += e_out[e, i]


def event_values(batch, system):
    """Compute one number for each event of each element; -inf for an event that is not monitored."""
    b, s = batch_at(batch), system_at(system)
    p = items(b.p, b.n, parameters)  # noqa: F821
    memory, phase, laws = given(b, s)
    dofs, rots = integers(b.output_dofs, (b.n, b.n_output_dofs)), integers(b.rots, (b.n, b.n_rotations))
    before, g_out = integers(b.before, b.n_events), floats(s.event_values + 8 * b.first_event, (b.n, b.n_events))
    q, v, a, R = work(b)
    for e in range(b.n):
        gather(dofs[e], rots[e], s, q, v, a, R)
        function(p[e], Place(s.t, phase[e], s.k, s.penalty, laws, memory[e], q, v, a, R), g_out[e])  # noqa: F821
        for i in range(b.n_events):
            if phase[e] != before[i]:
                g_out[e, i] = -math.inf


def commit(batch, system):
    """Write the memories after an accepted step."""
    b, s = batch_at(batch), system_at(system)
    p = items(b.p, b.n, parameters)  # noqa: F821
    memory, phase, laws = given(b, s)
    dofs, rots = integers(b.output_dofs, (b.n, b.n_output_dofs)), integers(b.rots, (b.n, b.n_rotations))
    m_out = floats(s.memory_out + 8 * b.first_memory, (b.n, b.n_memory))
    q, v, a, R = work(b)
    for e in range(b.n):
        gather(dofs[e], rots[e], s, q, v, a, R)
        function(p[e], Place(s.t, phase[e], s.k, s.penalty, laws, memory[e], q, v, a, R), m_out[e])  # noqa: F821

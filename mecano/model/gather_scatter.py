"""Gather the state of an element and scatter its results: code shared by the loops over elements of all kinds.

``b`` and ``s`` are the records BATCH and SYSTEM, ``element`` of the batch is the index of the element. These functions
look up the arrays for each element; loops in which this would take a noticeable part of the time keep them instead.
"""

import math

from mecano.element_interface import Place
from mecano.jit.kernel import kernel
from mecano.jit.memory import floats, integers, items, lanes
from mecano.maths.dual import DUAL, Dual
from mecano.maths.vector import Vec3, mat, put, put_matrix, skew, vec

SIZE = DUAL.itemsize
NEVER = -1.0  # value of an event that does not occur


@kernel
def work(b):
    """Return work arrays for local unknowns, velocities, accelerations (n_local,), rotations (n_rotations, 3, 3)."""
    n = max(b.n_local, b.n_output_dofs)
    return floats(b.q, n), floats(b.v, n), floats(b.a, n), floats(b.R, (b.n_rotations, 3, 3))


@kernel
def idle_phases(b):
    """Return flags (n_phases, 1 + n_outputs): whether the elements are idle, and which outputs vanish in the phase."""
    return integers(b.idle, (b.n_phases, 1 + b.n_outputs))


@kernel
def gather(dofs, rots, n_vectors, s, q_out, v_out, a_out, R_out):
    """Copy local unknowns, velocities, accelerations (n_local,) and rotations (n_rotations, 3, 3) of one element.

    The first 3 ``n_vectors`` unknowns are those of nodes, three by three.
    """
    z, v, a = floats(s.z, s.n_all), floats(s.v, s.n_all), floats(s.a, s.n_all)
    R = floats(s.R, (s.n_rotations, 3, 3))
    for j in range(n_vectors):
        i = 3 * j
        d = dofs[i]
        put(q_out, i, vec(z, d))
        put(v_out, i, vec(v, d))
        put(a_out, i, vec(a, d))
    for i in range(3 * n_vectors, dofs.shape[0]):
        d = dofs[i]
        q_out[i] = z[d]
        v_out[i] = v[d]
        a_out[i] = a[d]
    for r in range(rots.shape[0]):
        put_matrix(R_out[r], mat(R[rots[r]]))


@kernel
def is_idle(b, s):
    """Return whether an element has no force in its phase."""
    return idle_phases(b)[phase_of(b, s), 0] != 0


@kernel
def phase_of(b, s):
    """Return the phase of an element."""
    return integers(s.phases + 8 * b.first_phase, b.n)[b.element]


@kernel
def memory_of(b, s):
    """Return the memory (n_memory,) of an element."""
    return floats(s.memory + 8 * b.first_memory, (b.n, b.n_memory))[b.element]


@kernel
def rotations_of(b):
    """Return the indices (n_rotations,) of the rotations of an element."""
    return integers(b.rots, (b.n, b.n_rotations))[b.element]


@kernel
def gather_unknowns(b, s):
    """Copy the local unknowns of an element to the work arrays."""
    q, v, a, R = work(b)
    dofs, rots = integers(b.dofs, (b.n, b.n_local)), integers(b.rots, (b.n, b.n_rotations))
    gather(dofs[b.element], rots[b.element], b.n_vectors, s, q, v, a, R)


@kernel
def gather_observed(b, s):
    """Copy the unknowns that ``observe`` reads of an element to the work arrays."""
    q, v, a, R = work(b)
    dofs, rots = integers(b.output_dofs, (b.n, b.n_output_dofs)), integers(b.rots, (b.n, b.n_rotations))
    gather(dofs[b.element], rots[b.element], b.n_vectors, s, q, v, a, R)


@kernel
def lag_of(b, s):
    """Return the factor of the rows and penalty of constraints: 1 for those on positions."""
    return s.lag if b.of_rates else 1.0


@kernel
def place(b, s, lag):
    """Return the Place of a gathered element; ``lag`` multiplies the penalty."""
    q, v, a, R = work(b)
    laws = floats(s.laws, s.n_laws)
    return Place(s.t, phase_of(b, s), s.k, s.penalty * lag, laws, memory_of(b, s), q, v, a, R)


@kernel
def lanes_place(b, s):
    """Return the Place of a gathered group of elements, which have one phase and no memory."""
    n, laws = max(b.n_local, b.n_output_dofs), floats(s.laws, s.n_laws)
    q, v, a, R = lanes(b.q, n), lanes(b.v, n), lanes(b.a, n), lanes(b.R, (b.n_rotations, 3, 3))
    return Place(s.t, 0, s.k, s.penalty, laws, laws, q, v, a, R)


@kernel
def seeded(b):
    """Return arrays of Duals for q, v, a (n_local,) and rotations (n_rotations, 3, 3)."""
    n, at, size = b.n_local, b.seeded, SIZE * b.n_local
    q, v, a = items(at, n, DUAL), items(at + size, n, DUAL), items(at + 2 * size, n, DUAL)
    return q, v, a, items(at + 4 * size, (b.n_rotations, 3, 3), DUAL)


@kernel
def dual_forces(b):
    """Return the array (n_local,) of Duals for forces."""
    return items(b.seeded + 3 * SIZE * b.n_local, b.n_local, DUAL)


@kernel
def dual_constraints(b):
    """Return the array (n_multipliers, 2) of Duals for constraints and their rates, which overlays accelerations."""
    return items(b.seeded + 2 * SIZE * b.n_local, (b.n_multipliers, 2), DUAL)


@kernel
def dual_place(b, s, lag):
    """Return the Place of a gathered element with Duals; ``lag`` multiplies the penalty."""
    q, v, a, R = seeded(b)
    laws = floats(s.laws, s.n_laws)
    return Place(s.t, phase_of(b, s), s.k, s.penalty * lag, laws, memory_of(b, s), q, v, a, R)


@kernel
def moving_place(b, s):
    """Return the Place of a gathered element with Duals whose slopes are rates in time."""
    q, v, _, R = seeded(b)
    laws, a = floats(s.laws, s.n_laws), floats(b.a, b.n_local)
    return Place(Dual(s.t, 1.0), phase_of(b, s), s.k, s.penalty, laws, memory_of(b, s), q, v, a, R)


@kernel
def gather_duals(b, s):
    """Copy the state of an element to the work arrays, including those of Duals, without slopes."""
    gather_unknowns(b, s)
    q, v, a, R = work(b)
    q_1, v_1, a_1, R_1 = seeded(b)
    for i in range(b.n_local):
        q_1[i] = q[i]
        v_1[i] = v[i]
        a_1[i] = a[i]
    for r in range(b.n_rotations):
        put_matrix(R_1[r], mat(R[r]))


@kernel
def seed(b, s, j):
    """Set forces to zero, and the slopes along the local unknown j if columns are requested.

    q_j varies by cK, v_j by cC, a_j by cM; a rotation by R hat(cK T_q), its rates by cC T_v, cM T_a (System.assemble).
    """
    q_1, v_1, a_1, R_1 = seeded(b)
    columns, f_1 = integers(b.columns, b.n_rotations), dual_forces(b)
    for i in range(b.n_local):
        f_1[i] = 0.0
    if not s.columns:
        return
    r = rotation_of(j, columns)
    if r < 0:
        reaction = b.first_reaction <= j < b.first_reaction + b.n_reactions
        q_1[j].slope = s.cK * (s.k if reaction else 1.0)
        v_1[j].slope = s.cC
        a_1[j].slope = s.cM
    else:
        T, first, at = floats(s.T, (3, s.n_rotations, 3, 3)), columns[r], rotations_of(b)[r]
        R, c = mat(floats(b.R, (b.n_rotations, 3, 3))[r]), j - first
        put_turned(R_1[r], R, s.cK * Vec3(T[0, at, 0, c], T[0, at, 1, c], T[0, at, 2, c]))
        for i in range(3):
            v_1[first + i].slope = s.cC * T[1, at, i, c]
            a_1[first + i].slope = s.cM * T[2, at, i, c]


@kernel
def add_column(b, s, j, lag):
    """Add the column j of the tangent of an element, the slopes of its forces, if requested; clear the seeds."""
    if not s.columns:
        return
    n, data_out, entries = (
        b.n_local,
        floats(s.data, s.n_data),
        integers(b.entries, (b.n, b.n_local, b.n_local))[b.element],
    )
    columns, f_1, first_row = integers(b.columns, b.n_rotations), dual_forces(b), n - b.n_multipliers
    for i in range(n):
        data_out[entries[i, j]] += (lag if i >= first_row else 1.0) * f_1[i].slope
    q_1, v_1, a_1, R_1 = seeded(b)
    r = rotation_of(j, columns)
    first, end = (columns[r], columns[r] + 3) if r >= 0 else (j, j + 1)
    for i in range(first, end):
        q_1[i].slope = 0.0
        v_1[i].slope = 0.0
        a_1[i].slope = 0.0
    if r >= 0:
        put_matrix(R_1[r], mat(floats(b.R, (b.n_rotations, 3, 3))[r]))


@kernel
def add_dual_force(b, s, lag):
    """Add the values of the forces of an element and their magnitudes; those of its own multipliers times ``lag``."""
    n, f_1, slots = b.n_local, dual_forces(b), integers(b.slots, (b.n, b.n_local))
    force_out, size_out = floats(s.force, s.n_slots), floats(s.size, s.n_slots)
    for i in range(n):
        f = f_1[i].value * (lag if i >= n - b.n_multipliers else 1.0)
        force_out[slots[b.element, i]] += f
        size_out[slots[b.element, i]] += abs(f)


@kernel
def add_forces(f, slots, n_vectors, force_out, size_out):
    """Add forces (n_local,) and their magnitudes to the slots; the first 3 ``n_vectors`` are those of nodes."""
    for j in range(n_vectors):
        i = 3 * j
        own, slot = vec(f, i), slots[i]
        put(force_out, slot, vec(force_out, slot) + own)
        put(size_out, slot, vec(size_out, slot) + Vec3(abs(own[0]), abs(own[1]), abs(own[2])))
    for i in range(3 * n_vectors, slots.shape[0]):
        force_out[slots[i]] += f[i]
        size_out[slots[i]] += abs(f[i])


@kernel
def add_masses(b, s):
    """Add the masses of an element."""
    m, slots, mass_out = floats(b.f, b.n_local), integers(b.slots, (b.n, b.n_local)), floats(s.mass, s.n_slots)
    for i in range(b.n_local):
        mass_out[slots[b.element, i]] += abs(m[i])


@kernel
def put_derivatives(b, s):
    """Store values, rates and second rates of the constraints of an element."""
    multipliers, g = integers(b.multipliers, (b.n, b.n_multipliers)), floats(b.g, (b.n_multipliers, 3))
    g_out = floats(s.constraint_derivatives, (s.n_constraints, 3))
    for i in range(b.n_multipliers):
        for j in range(3):
            g_out[multipliers[b.element, i], j] = g[i, j]


@kernel
def gather_motion(b, s):
    """Copy the state of an element to arrays of Duals whose slopes are rates in time; set its constraints to zero."""
    gather_unknowns(b, s)
    columns, g_1 = integers(b.columns, b.n_rotations), dual_constraints(b)
    q, v, a, R = work(b)
    q_1, v_1, _, R_1 = seeded(b)
    for i in range(b.n_local):
        q_1[i] = Dual(q[i], v[i])
        v_1[i] = Dual(v[i], a[i])
    for r in range(b.n_rotations):
        put_matrix(R_1[r], mat(R[r]))
        put_turned(R_1[r], mat(R[r]), vec(v, columns[r]))
    for i in range(b.n_multipliers):
        g_1[i, 0], g_1[i, 1] = 0.0, 0.0


@kernel
def put_dual_derivatives(b, s):
    """Store values, rates and second rates of the constraints of an element; the last are slopes of the rates."""
    multipliers, g_1 = integers(b.multipliers, (b.n, b.n_multipliers)), dual_constraints(b)
    g_out = floats(s.constraint_derivatives, (s.n_constraints, 3))
    for i in range(b.n_multipliers):
        g_out[multipliers[b.element, i], 0] = g_1[i, 0].value
        g_out[multipliers[b.element, i], 1] = g_1[i, 1].value
        g_out[multipliers[b.element, i], 2] = g_1[i, 1].slope


@kernel
def put_observation(b, s):
    """Copy the forces on an element to the work array F, and set its outputs and energies to zero."""
    slots, force = integers(b.output_slots, (b.n, b.n_forces)), floats(s.transmitted, s.n_transmitted)
    F = floats(b.F, b.n_forces)
    for i in range(b.n_forces):
        F[i] = force[slots[b.element, i]]
    y, energies = observed(b, s)
    y[:] = 0.0
    energies[:] = 0.0


@kernel
def observed(b, s):
    """Return the outputs (n_outputs,) and energies (4,) of an element."""
    y = floats(s.outputs + 8 * b.first_output, (b.n, b.n_outputs))[b.element]
    return y, floats(s.energies + 32 * b.first_phase, (b.n, 4))[b.element]


@kernel
def add_energies(b, s):
    """Set outputs and energies that vanish in the phase of an element to zero, and add its energies to the totals."""
    y, energies = observed(b, s)
    idle, total_out = idle_phases(b)[phase_of(b, s)], floats(s.energy, 4)
    if idle[0]:
        energies[:] = 0.0
        for i in range(b.n_outputs):
            if idle[1 + i]:
                y[i] = 0.0
    for i in range(4):
        total_out[i] += energies[i]


@kernel
def event_values_of(b, s):
    """Return the array (n_events,) for the event values of an element."""
    return floats(s.event_values + 8 * b.first_event, (b.n, b.n_events))[b.element]


@kernel
def put_commands(b, s):
    """Write the numbers of the events by command: the value of the input, or NEVER of those that do not replace one."""
    commands, q, g_out, first = integers(b.commands, (b.n_events, 2)), work(b)[0], event_values_of(b, s), 0
    for i in range(b.n_events):
        command, beyond = commands[i, 0], commands[i, 1]
        if command >= 0:
            g_out[i] = q[command]
            if beyond < 0:
                first = i
            elif g_out[beyond] > 0.0 and g_out[first] == q[command]:
                g_out[first] = NEVER
            else:
                g_out[i] = NEVER


@kernel
def clear_other_events(b, s):
    """Set the values of events that are not monitored in the phase of an element to -inf."""
    phase, before, g_out = phase_of(b, s), integers(b.before, b.n_events), event_values_of(b, s)
    for i in range(b.n_events):
        if phase != before[i]:
            g_out[i] = -math.inf


@kernel
def new_memory_of(b, s):
    """Return the array (n_memory,) to which an element writes its memory."""
    return floats(s.memory_out + 8 * b.first_memory, (b.n, b.n_memory))[b.element]


@kernel
def keep_memory(b, s):
    """Restore the values of the memory of an element that its phase keeps."""
    kept, old, m_out = integers(b.kept, (b.n_phases, b.n_memory)), memory_of(b, s), new_memory_of(b, s)
    phase = phase_of(b, s)
    for i in range(b.n_memory):
        if kept[phase, i]:
            m_out[i] = old[i]


@kernel
def rotation_of(j, columns):
    """Return the index of the rotation to which the local unknown j belongs, or -1."""
    for r in range(columns.shape[0]):
        if columns[r] <= j < columns[r] + 3:
            return r
    return -1


@kernel
def put_turned(R_out, R, turn):
    """Store R (1 + hat(turn) epsilon)."""
    change = R @ skew(turn)
    for i in range(3):
        for j in range(3):
            R_out[i, j].slope = change[i][j]

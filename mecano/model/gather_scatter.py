"""Gather the state of an element and scatter its results: code shared by the loops over elements of all kinds.

``b`` and ``s`` are the records BATCH and SYSTEM, ``element`` of the batch is the index of the element. These functions
look up the arrays for each element; loops in which this would take a noticeable part of the time keep them instead.
"""

import math

from mecano.element_interface import Place
from mecano.jit.kernel import kernel
from mecano.jit.memory import floats, integers, lanes
from mecano.maths.vector import Vec3, mat, put, put_matrix, vec

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
def penalty_of(b, s, lag):
    """Return the penalty of the constraints of a batch; ``lag`` multiplies it."""
    return s.penalty * lag * b.penalty_factor


@kernel
def place(b, s, lag):
    """Return the Place of a gathered element; ``lag`` multiplies the penalty."""
    q, v, a, R = work(b)
    laws = floats(s.laws, s.n_laws)
    return Place(s.t, phase_of(b, s), s.k, penalty_of(b, s, lag), laws, memory_of(b, s), q, v, a, R)


@kernel
def lanes_place(b, s):
    """Return the Place of a gathered group of elements, which have one phase and no memory."""
    n, laws = max(b.n_local, b.n_output_dofs), floats(s.laws, s.n_laws)
    q, v, a, R = lanes(b.q, n), lanes(b.v, n), lanes(b.a, n), lanes(b.R, (b.n_rotations, 3, 3))
    return Place(s.t, 0, s.k, s.penalty, laws, laws, q, v, a, R)


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

"""Loops over the elements of kinds that are computed by lanes: LANES elements at once, one in each lane.

Entry i of the element in lane l is stored at [i, l] of the work arrays, so that compiled code reads the entries of all
lanes as one. Lanes beyond the last element repeat it. A batch that begins or ends between two groups of elements, as
those of divided_loops.py do, leaves out the lanes before and after. The results are those of loops.py, bit for bit.
"""

from mecano.jit.kernel import kernel
from mecano.jit.memory import LANES, call, floats, integers, lanes
from mecano.maths.vector import Vec3, put, vec
from mecano.model.gather_scatter import observed
from mecano.model.loop_records import batch_at, system_at


@kernel
def groups(b):
    """Return the indices of the first group of elements and of the one after the last."""
    return b.first_element // LANES, (b.first_element + b.n - 1) // LANES + 1


@kernel
def first_of(b, group):
    """Return the index of the element in the first lane of a group, negative if it is left out."""
    return LANES * group - b.first_element


@kernel
def members(b, group):
    """Return the indices of the first element of a group and of the one after its last."""
    first = first_of(b, group)
    return max(first, 0), min(first + LANES, b.n)


@kernel
def nearest_in(b, group, lane):
    """Return the index of the element in a lane, or of the nearest one for a lane that is left out."""
    return min(max(first_of(b, group) + lane, 0), b.n - 1)


@kernel
def gather(b, s, group, dofs):
    """Copy the local unknowns, their rates and the rotations of a group of elements to the work arrays."""
    n = dofs.shape[1]
    z, v, a = floats(s.z, s.n_all), floats(s.v, s.n_all), floats(s.a, s.n_all)
    q_out, v_out, a_out = floats(b.q, (n, LANES)), floats(b.v, (n, LANES)), floats(b.a, (n, LANES))
    for lane in range(LANES):
        e = nearest_in(b, group, lane)
        for i in range(n):
            d = dofs[e, i]
            q_out[i, lane] = z[d]
            v_out[i, lane] = v[d]
            a_out[i, lane] = a[d]
    gather_matrices(b, floats(s.R, (s.n_rotations, 3, 3)), group)


@kernel
def gather_matrices(b, matrices, group):
    """Copy the ``matrices`` (s.n_rotations, 3, 3) of the rotations of a group of elements to the work array R."""
    n = b.n_rotations
    rots, R_out = integers(b.rots, (b.n, n)), floats(b.R, (n, 3, 3, LANES))
    for lane in range(LANES):
        e = nearest_in(b, group, lane)
        for r in range(n):
            matrix = matrices[rots[e, r]]
            for i in range(3):
                for j in range(3):
                    R_out[r, i, j, lane] = matrix[i, j]


@kernel
def turn_columns(A, columns, T):
    """Multiply the columns of A of the rotations by their T, in place."""
    for r in range(columns.shape[0]):
        c = columns[r]
        for i in range(A.shape[0]):
            a0, a1, a2 = A[i, c], A[i, c + 1], A[i, c + 2]
            for j in range(3):
                A[i, c + j] = a0 * T[r, 0, j] + a1 * T[r, 1, j] + a2 * T[r, 2, j]


@kernel
def combine(b, s):
    """Replace K by the derivatives cK K T_q + cC C T_v + cM M T_a with respect to the unknowns (System.assemble)."""
    n = b.n_local
    K, C, M = lanes(b.K, (n, n)), lanes(b.C, (n, n)), lanes(b.M, (n, n))
    cK, cC, cM = s.cK, s.cC, s.cM
    for i in range(n):
        for j in range(n):
            K[i, j] = cK * K[i, j] + cC * C[i, j] + cM * M[i, j]


@kernel
def add_forces(f, slots, lane, force_out, size_out):
    """Add the forces of the element in a lane and their magnitudes to its slots."""
    for i in range(slots.shape[0]):
        slot, force = slots[i], f[i, lane]
        force_out[slot] += force
        size_out[slot] += abs(force)


def tangent(batch, system):
    """Compute forces, their magnitudes, masses, and the tangent cK K T_q + cC C T_v + cM M T_a (System.assemble)."""
    b, s = batch_at(batch), system_at(system)
    n, n_vectors, (first, end) = b.n_local, b.n_vectors, groups(b)
    dofs, slots, entries = (
        integers(b.dofs, (b.n, n)), integers(b.slots, (b.n, n)), integers(b.entries, (b.n, n, n))
    )  # fmt: skip
    f = floats(b.f, (n, LANES))
    K, C, M = floats(b.K, (n, n, LANES)), floats(b.C, (n, n, LANES)), floats(b.M, (n, n, LANES))
    T, data_out = floats(s.T, (3, s.n_rotations, 3, 3)), floats(s.data, s.n_data)
    columns, turns, tangents = integers(b.columns, b.n_rotations), lanes(b.R, (b.n_rotations, 3, 3)), (b.K, b.C, b.M)
    force_out, size_out, mass_out = floats(s.force, s.n_slots), floats(s.size, s.n_slots), floats(s.mass, s.n_slots)
    for group in range(first, end):
        b.element = group
        f[:, :] = 0.0
        K[:, :, :] = 0.0
        C[:, :, :] = 0.0
        M[:, :, :] = 0.0
        gather(b, s, group, dofs)
        call(b.function, batch, system)
        for i in range(3):
            gather_matrices(b, T[i], group)
            turn_columns(lanes(tangents[i], (n, n)), columns, turns)
        combine(b, s)
        begin, behind = members(b, group)
        for e in range(begin, behind):
            lane = e - first_of(b, group)
            add_forces(f, slots[e], lane, force_out, size_out)
            for i in range(n):
                mass_out[slots[e, i]] += abs(M[i, i, lane])
                row = entries[e, i]
                for c in range(0, 3 * n_vectors, 3):
                    block = Vec3(K[i, c, lane], K[i, c + 1, lane], K[i, c + 2, lane])
                    put(data_out, row[c], vec(data_out, row[c]) + block)
                for j in range(3 * n_vectors, n):
                    data_out[row[j]] += K[i, j, lane]


def residual(batch, system):
    """Compute forces and their magnitudes."""
    b, s = batch_at(batch), system_at(system)
    n, (first, end) = b.n_local, groups(b)
    dofs, slots = integers(b.dofs, (b.n, n)), integers(b.slots, (b.n, n))
    f, force_out, size_out = floats(b.f, (n, LANES)), floats(s.force, s.n_slots), floats(s.size, s.n_slots)
    for group in range(first, end):
        b.element = group
        f[:, :] = 0.0
        gather(b, s, group, dofs)
        call(b.function, batch, system)
        begin, behind = members(b, group)
        for e in range(begin, behind):
            add_forces(f, slots[e], e - first_of(b, group), force_out, size_out)


@kernel
def gather_forces(b, s, group):
    """Copy the forces on a group of elements to the work array F."""
    slots, force = integers(b.output_slots, (b.n, b.n_forces)), floats(s.transmitted, s.n_transmitted)
    F = floats(b.F, (b.n_forces, LANES))
    for lane in range(LANES):
        e = nearest_in(b, group, lane)
        for i in range(b.n_forces):
            F[i, lane] = force[slots[e, i]]


def observe(batch, system):
    """Compute outputs and energies of the elements, and add the energies to the totals."""
    b, s = batch_at(batch), system_at(system)
    first, end = groups(b)
    dofs = integers(b.output_dofs, (b.n, b.n_output_dofs))
    y, energies = floats(b.y, (b.n_outputs, LANES)), floats(b.energies, (4, LANES))
    total_out = floats(s.energy, 4)
    for group in range(first, end):
        b.element = group
        gather(b, s, group, dofs)
        gather_forces(b, s, group)
        y[:, :] = 0.0
        energies[:, :] = 0.0
        call(b.function, batch, system)
        begin, behind = members(b, group)
        for e in range(begin, behind):
            lane = e - first_of(b, group)
            b.element = e
            y_out, energies_out = observed(b, s)
            for i in range(b.n_outputs):
                y_out[i] = y[i, lane]
            for i in range(4):
                energies_out[i] = energies[i, lane]
                total_out[i] += energies[i, lane]

"""Gather the state of an element as Duals, seed them, and scatter the slopes of its results.

The arguments are those of gather_scatter.py.
"""

from mecano.element_interface import Place
from mecano.jit.kernel import kernel
from mecano.jit.memory import LANES, duals, floats, integers, items
from mecano.maths.dual import DUAL, Dual
from mecano.maths.vector import Vec3, mat, put_matrix, skew, vec
from mecano.model.gather_scatter import gather_unknowns, memory_of, penalty_of, phase_of, rotations_of, work

NUMBERS = 1 + LANES  # of a Dual: its value and its slopes along LANES local unknowns
SIZE = 8 * NUMBERS


@kernel
def seeded(b):
    """Return arrays of Duals for q, v, a (n_local,) and rotations (n_rotations, 3, 3)."""
    n, at, size = b.n_local, b.seeded, SIZE * b.n_local
    q, v, a = duals(at, n), duals(at + size, n), duals(at + 2 * size, n)
    return q, v, a, duals(at + 4 * size, (b.n_rotations, 3, 3))


@kernel
def slopes(b):
    """Return the arrays of Duals for q, v, a, forces and rotations as numbers: of each its value, then its slopes."""
    n, at, size = b.n_local, b.seeded, SIZE * b.n_local
    q, v, a = floats(at, (n, NUMBERS)), floats(at + size, (n, NUMBERS)), floats(at + 2 * size, (n, NUMBERS))
    return q, v, a, floats(at + 3 * size, (n, NUMBERS)), floats(at + 4 * size, (b.n_rotations, 3, 3, NUMBERS))


@kernel
def dual_forces(b):
    """Return the array (n_local,) of Duals for forces."""
    return duals(b.seeded + 3 * SIZE * b.n_local, b.n_local)


@kernel
def dual_constraints(b):
    """Return the array (n_multipliers, 2) of Duals for constraints and their rates, which overlays accelerations."""
    return items(b.seeded + 2 * SIZE * b.n_local, (b.n_multipliers, 2), DUAL)


@kernel
def moving(b):
    """Return arrays of Duals with one slope, the rate in time, for q, v (n_local,), rotations (n_rotations, 3, 3)."""
    n, at, size = b.n_local, b.seeded, SIZE * b.n_local
    return items(at, n, DUAL), items(at + size, n, DUAL), items(at + 4 * size, (b.n_rotations, 3, 3), DUAL)


@kernel
def dual_place(b, s, lag):
    """Return the Place of a gathered element with Duals; ``lag`` multiplies the penalty."""
    q, v, a, R = seeded(b)
    laws = floats(s.laws, s.n_laws)
    return Place(s.t, phase_of(b, s), s.k, penalty_of(b, s, lag), laws, memory_of(b, s), q, v, a, R)


@kernel
def moving_place(b, s):
    """Return the Place of a gathered element with Duals whose slopes are rates in time."""
    q, v, R = moving(b)
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
def seed(b, s, first):
    """Set forces to zero, and the slopes along LANES local unknowns from ``first`` on if columns are requested."""
    f_1 = dual_forces(b)
    for i in range(b.n_local):
        f_1[i] = 0.0
    if s.columns:
        for j in range(first, min(first + LANES, b.n_local)):
            put_seeds(b, s, j, 1 + j - first)


@kernel
def put_seeds(b, s, j, place):
    """Set the slopes along the local unknown j, which are at a ``place`` of Duals.

    q_j varies by cK, v_j by cC, a_j by cM; a rotation by R hat(cK T_q), its rates by cC T_v, cM T_a (System.assemble).
    """
    q_1, v_1, a_1, _, R_1 = slopes(b)
    columns = integers(b.columns, b.n_rotations)
    r = rotation_of(j, columns)
    if r < 0:
        reaction = b.first_reaction <= j < b.first_reaction + b.n_reactions
        q_1[j, place] = s.cK * (s.k if reaction else 1.0)
        v_1[j, place] = s.cC
        a_1[j, place] = s.cM
    else:
        T, first, at = floats(s.T, (3, s.n_rotations, 3, 3)), columns[r], rotations_of(b)[r]
        R, c = mat(floats(b.R, (b.n_rotations, 3, 3))[r]), j - first
        change = R @ skew(s.cK * Vec3(T[0, at, 0, c], T[0, at, 1, c], T[0, at, 2, c]))
        for i in range(3):
            for k in range(3):
                R_1[r, i, k, place] = change[i][k]
            v_1[first + i, place] = s.cC * T[1, at, i, c]
            a_1[first + i, place] = s.cM * T[2, at, i, c]


@kernel
def add_columns(b, s, first, lag):
    """Add LANES columns of the tangent of an element, the slopes of its forces, if requested; clear the seeds."""
    if not s.columns:
        return
    n, f_1 = b.n_local, slopes(b)[3]
    data_out, entries = floats(s.data, s.n_data), integers(b.entries, (b.n, n, n))[b.element]
    for j in range(first, min(first + LANES, n)):
        place = 1 + j - first
        for i in range(n):
            data_out[entries[i, j]] += (lag if i >= n - b.n_multipliers else 1.0) * f_1[i, place]
        clear_seeds(b, j, place)


@kernel
def clear_seeds(b, j, place):
    """Set the slopes that ``put_seeds`` has set to zero."""
    q_1, v_1, a_1, _, R_1 = slopes(b)
    columns = integers(b.columns, b.n_rotations)
    r = rotation_of(j, columns)
    first, end = (columns[r], columns[r] + 3) if r >= 0 else (j, j + 1)
    for i in range(first, end):
        q_1[i, place] = 0.0
        v_1[i, place] = 0.0
        a_1[i, place] = 0.0
    if r >= 0:
        for i in range(3):
            for k in range(3):
                R_1[r, i, k, place] = 0.0


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
def gather_motion(b, s):
    """Copy the state of an element to arrays of Duals whose slopes are rates in time; set its constraints to zero."""
    gather_unknowns(b, s)
    columns, g_1 = integers(b.columns, b.n_rotations), dual_constraints(b)
    q, v, a, R = work(b)
    q_1, v_1, R_1 = moving(b)
    for i in range(b.n_local):
        q_1[i] = Dual(q[i], v[i])
        v_1[i] = Dual(v[i], a[i])
    for r in range(b.n_rotations):
        put_matrix(R_1[r], mat(R[r]))
        put_turned(R_1[r], mat(R[r]), vec(v, columns[r]))
    for i in range(b.n_multipliers):
        g_1[i, 0], g_1[i, 1] = 0.0, 0.0


@kernel
def put_derivatives(b, s):
    """Store values, rates and second rates of the constraints of an element; the last are slopes of the rates."""
    multipliers, g_1 = integers(b.multipliers, (b.n, b.n_multipliers)), dual_constraints(b)
    g_out = floats(s.constraint_derivatives, (s.n_constraints, 3))
    for i in range(b.n_multipliers):
        g_out[multipliers[b.element, i], 0] = g_1[i, 0].value
        g_out[multipliers[b.element, i], 1] = g_1[i, 1].value
        g_out[multipliers[b.element, i], 2] = g_1[i, 1].slope


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

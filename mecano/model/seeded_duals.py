"""Gather the state of an element as Duals, seed them, and scatter the slopes of its results.

The arguments are those of gather_scatter.py.
"""

from mecano.element_interface import Place
from mecano.jit.kernel import kernel
from mecano.jit.memory import LANES, duals, floats, in_lane, integers, items
from mecano.maths.dual import DUAL, Dual
from mecano.maths.vector import Vec3, mat, put_matrix, skew, vec
from mecano.model.gather_scatter import gather_unknowns, memory_of, penalty_of, phase_of, rotations_of, work

SIZE = 8 * (1 + LANES)  # B, of a Dual: its value and its slopes along LANES local unknowns


@kernel
def seeded(b):
    """Return arrays of Duals for q, v, a (n_local,) and rotations (n_rotations, 3, 3)."""
    n, at, size = b.n_local, b.seeded, SIZE * b.n_local
    q, v, a = duals(at, n), duals(at + size, n), duals(at + 2 * size, n)
    return q, v, a, duals(at + 4 * size, (b.n_rotations, 3, 3))


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
    """Set forces to zero, and the slopes along LANES local unknowns from ``first`` on if columns are requested.

    q_j varies by cK, v_j by cC, a_j by cM; a rotation by R hat(cK T_q), its rates by cC T_v, cM T_a (System.assemble).
    """
    f_1, columns = dual_forces(b), integers(b.columns, b.n_rotations)
    q_1, v_1, a_1, R_1 = seeded(b)
    for i in range(b.n_local):
        f_1[i] = 0.0
    if not s.columns:
        return
    for j in range(b.n_local):
        reaction = b.first_reaction <= j < b.first_reaction + b.n_reactions
        q_1[j].slope = in_lane(s.cK * (s.k if reaction else 1.0), j - first)
        v_1[j].slope = in_lane(s.cC, j - first)
        a_1[j].slope = in_lane(s.cM, j - first)
    T, R = floats(s.T, (3, s.n_rotations, 3, 3)), floats(b.R, (b.n_rotations, 3, 3))
    for r in range(b.n_rotations):
        at, start = rotations_of(b)[r], columns[r]
        put_turned(R_1[r], mat(R[r]), s.cK * in_lanes(T[0, at], start - first))
        v, a = in_lanes(T[1, at], start - first), in_lanes(T[2, at], start - first)
        for i in range(3):
            q_1[start + i].slope = 0.0
            v_1[start + i].slope = s.cC * v[i]
            a_1[start + i].slope = s.cM * a[i]


@kernel
def in_lanes(T, lane):
    """Return a vector with the columns of T (3, 3) in this lane and the two after it, as far as there are these."""
    found = Vec3(in_lane(T[0, 0], lane), in_lane(T[1, 0], lane), in_lane(T[2, 0], lane))
    for c in range(1, 3):
        found = found + Vec3(in_lane(T[0, c], lane + c), in_lane(T[1, c], lane + c), in_lane(T[2, c], lane + c))
    return found


@kernel
def add_columns(b, s, first, lag):
    """Add LANES columns of the tangent of an element, the slopes of its forces, if requested."""
    if not s.columns:
        return
    n, data_out, size = b.n_local, floats(s.data, s.n_data), 1 + LANES
    f_1, entries = floats(b.seeded + 3 * SIZE * n, (n, size)), integers(b.entries, (b.n, n, n))[b.element]
    for i in range(n):
        factor, row = lag if i >= n - b.n_multipliers else 1.0, entries[i]
        for j in range(first, min(first + LANES, n)):
            data_out[row[j]] += factor * f_1[i, 1 + j - first]


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
def put_turned(R_out, R, turn):
    """Store R (1 + hat(turn) epsilon)."""
    change = R @ skew(turn)
    for i in range(3):
        for j in range(3):
            R_out[i, j].slope = change[i][j]

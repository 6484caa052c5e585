r"""Flexible wheel whose patch does not slip, whatever the force: the limit of ``flexible_wheel`` without any creep.

The same unknowns y and psi, forces and tyre law (47)-(51), but the two components of the patch velocity v_C vanish as
constraints on velocities (Cardona, Geradin and Doan, CMAME 89 (1991), section 3.4):

    v_C.t = 0,   v_C.l = 0          reactions: the driving and the lateral force on the wheel

The friction law of the tyre is not used; the friction coefficient that would be needed is an output. In mode "air"
the patch is let go. At a touch-down the wheel is spun up at once: the velocities jump to the nearest, by kinetic
energy, that do not slip, and the energy of this shock is lost. Sideways there is no shock, since y has no inertia.
"""

from numba import njit

from mecano.constraints.ground import GROUND_RECORD, ends
from mecano.constraints.tire_patch import (
    PSI,
    Y,
    add_patch_force,
    add_patch_tangent,
    by_positions,
    by_velocities,
    patch,
    patch_column,
)
from mecano.contract import Event, Kind, Row, record
from mecano.elements.lateral_force import lateral_law, law_rows, relax
from mecano.elements.lateral_law import LATERAL_RECORD
from mecano.elements.patch_wheel import (
    FIELDS,
    OUTPUTS,
    SCALARS,
    check,
    event_values,
    limits,
    prepare,
    put_patch,
    sample,
    start,
)
from mecano.elements.tire_law import TIRE_RECORD, radial_force, speed_over_ground
from mecano.maths.surface import Block as OfContact
from mecano.maths.surface import directions, directions_variation
from mecano.maths.vec import (
    EYE,
    ZERO,
    add,
    add_col,
    add_mat,
    add_row,
    add_vec,
    cross,
    dot,
    madd,
    mat,
    matmul,
    mscale,
    mul,
    norm,
    outer,
    scale,
    skew,
    sub,
    tmul,
    vec,
)  # fmt: skip

AIR, CONTACT = 0, 1
MULTIPLIERS = 9  # driving, lateral
NO_MATRIX = (ZERO, ZERO, ZERO)


@njit
def _forces(p, laws, k, q, v):
    """Radial force F_r and its derivatives by w and dw/dt, N, speed of the axle, its direction, the Lateral."""
    radial, F_w, F_w1 = radial_force(p, laws, p.radius - k.g.r, k.w1)
    N = radial / k.g.q
    axle, ahead = speed_over_ground(k.g.n, vec(v, 0))
    law = lateral_law(p, laws, vec(q, Y), vec(v, Y), N, axle, dot(k.g.n, k.omega))
    return radial, F_w, F_w1, N, ahead, law


@njit
def _add_block(A, j, Rn, frame, k, forces, F, G, de, sizes, penalty, k_scale, d, paces, by_law, moment):
    """Add the derivatives by one block of variables.

    ``de`` are those of t and l, ``sizes`` the forces along them, ``paces`` the derivatives of speed and turning rate.
    """
    radial, F_w, F_w1, N, ahead, law = forces
    t, l = directions(k.a, k.g)
    by_t = add(tmul(de[0], k.v_C), tmul(d.v_C, t))
    by_l = add(tmul(de[1], k.v_C), tmul(d.v_C, l))
    dF = madd(mscale(sizes[0], de[0]), outer(scale(penalty, t), by_t))
    dF = madd(dF, madd(mscale(sizes[1], de[1]), outer(scale(penalty, l), by_l)))
    dN = add(scale(1.0 / k.g.q, add(scale(F_w, d.w), scale(F_w1, d.w1))), scale(N * k.g.s / k.g.q**2, d.s))
    rows, turn = law_rows(law, by_law, dN, paces[0], paces[1])
    aligned = madd(outer(scale(-1.0, k.g.n), turn), mscale(-law.turn, d.n))
    add_patch_tangent(A, j, Rn, frame, k, F, N, G, dF, dN, d, madd(moment, aligned))
    add_mat(A, Y, j, 1.0, matmul(rows, frame))
    add_row(A, MULTIPLIERS, j, -k_scale, tmul(frame, by_t))
    add_row(A, MULTIPLIERS + 1, j, -k_scale, tmul(frame, by_l))


@njit
def _add_multipliers(K, Rn, k, k_scale):
    """Columns of the two multipliers."""
    along = directions(k.a, k.g)
    for i in range(2):
        force, moment, own = patch_column(k, along[i])
        add_col(K, 0, MULTIPLIERS + i, -k_scale, force)
        add_col(K, 3, MULTIPLIERS + i, -k_scale, tmul(Rn, moment))
        K[Y, MULTIPLIERS + i] -= k_scale * own[0]
        K[PSI, MULTIPLIERS + i] -= k_scale * own[1]


@njit
def _turning(k, d, da):
    """Derivatives of t and l by the block ``d``."""
    t, _ = directions(k.a, k.g)
    return directions_variation(k.a, k.g, t, OfContact(d.n, d.s, NO_MATRIX), da)


@njit
def force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """Forces of ground and tyre law, constraints, and their derivatives; see the contract."""
    if mode == AIR:
        relax(p, q, v, f, K, C)
        for row in range(MULTIPLIERS, MULTIPLIERS + 2):
            f[row] -= q[row]
            K[row, row] -= k
        return
    Rn = mat(R[0])
    at = patch(p, laws, q, v, R)
    forces = _forces(p, laws, at, q, v)
    along, across = directions(at.a, at.g)
    Phi = (dot(along, at.v_C), dot(across, at.v_C))
    sizes = (penalty * Phi[0] - q[MULTIPLIERS], penalty * Phi[1] - q[MULTIPLIERS + 1])
    F, law = add(scale(sizes[0], along), scale(sizes[1], across)), forces[5]
    G = add_patch_force(f, Rn, at, F, forces[3])
    add_vec(f, 3, -law.turn, tmul(Rn, at.g.n))
    add_vec(f, Y, 1.0, law.f)
    f[MULTIPLIERS] -= k * Phi[0]
    f[MULTIPLIERS + 1] -= k * Phi[1]
    _add_multipliers(K, Rn, at, k)

    none, still, nothing = (ZERO, ZERO, ZERO), (NO_MATRIX, NO_MATRIX), (NO_MATRIX, ZERO)
    by_q, by_v = (law.f_q, law.turn_q), (law.f_v, law.turn_v)
    turning = skew(sub(cross(at.rho, G), scale(law.turn, at.g.n)))
    rise, frames = -dot(at.g.n, vec(v, 0)), (EYE, Rn, EYE)
    by_place, by_motion = by_positions(p, at, v[Y]), by_velocities(at)
    laws_of_place, laws_of_motion = (nothing, nothing, by_q), (nothing, nothing, by_v)
    moments, ahead = (none, turning, none), ((forces[4], ZERO), (ZERO, at.g.n), (ZERO, ZERO))
    swings = (ZERO, cross(at.omega, at.g.n), ZERO)
    for i in range(3):
        d = by_place[i]
        paces = (scale(rise, tmul(d.n, forces[4])), add(tmul(d.n, at.omega), swings[i]))
        de = _turning(at, d, d.a)
        _add_block(
            K, 3 * i, Rn, frames[i], at, forces, F, G, de, sizes, penalty, k, d, paces, laws_of_place[i],
            moments[i],
        )  # fmt: skip
        d = by_motion[i]
        _add_block(
            C, 3 * i, Rn, frames[i], at, forces, F, G, still, sizes, penalty, k, d, ahead[i],
            laws_of_motion[i], none,
        )  # fmt: skip


@njit
def levels(p, m, mode, t, laws, q, v, a, R, g):
    """Velocity of the patch along t and l, and its rate."""
    g[:, :] = 0.0
    if mode == AIR:
        return
    at = patch(p, laws, q, v, R)
    v_rate, e_rate = ZERO, (ZERO, ZERO)
    X, T, S = by_positions(p, at, v[Y])
    along = directions(at.a, at.g)
    for d, rate in ((X, vec(v, 0)), (T, at.omega), (S, (v[Y], v[PSI], 0.0))):
        de = _turning(at, d, d.a)
        v_rate = add(v_rate, mul(d.v_C, rate))
        e_rate = (add(e_rate[0], mul(de[0], rate)), add(e_rate[1], mul(de[1], rate)))
    V, W, S1 = by_velocities(at)
    for d, rate in ((V, vec(a, 0)), (W, mul(mat(R[0]), vec(a, 3))), (S1, (a[Y], a[PSI], 0.0))):
        v_rate = add(v_rate, mul(d.v_C, rate))
    for i in range(2):
        g[i, 1] = dot(along[i], at.v_C)
        g[i, 2] = dot(e_rate[i], at.v_C) + dot(along[i], v_rate)


@njit
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Outputs and energies; see OUTPUTS and the contract."""
    k = patch(p, laws, q, v, R)
    radial, _, _, N, _, law = _forces(p, laws, k, q, v)
    along, across = directions(k.a, k.g)
    reaction = add(scale(q[MULTIPLIERS], along), scale(q[MULTIPLIERS + 1], across))
    grip = norm(reaction) / N if N > 0.0 else 0.0
    put_patch(p, laws, mode == CONTACT, k, q, v, radial, reaction, grip, 0.0, law, y, e)


ADHESIVE_WHEEL = Kind(
    name="adhesive_wheel",
    section="elements",
    doc=__doc__,
    dtype=record(start=3, **LATERAL_RECORD, axis=3, **GROUND_RECORD, **TIRE_RECORD),
    layout=("x0", "R0"),
    scalars=SCALARS,
    relaxing=("psi", "bow"),
    multipliers=(Row("driving force of the ground", "N", "m/s"), Row("lateral force of the ground", "N", "m/s")),
    fields=FIELDS,
    outputs=OUTPUTS,
    modes=("air", "contact"),
    events=(
        Event("touch_down", "air", "contact", "the undeformed rim reaches the ground; a shock"),
        Event("lift_off", "contact", "air", "the deformation returns to zero"),
    ),
    prepare=prepare,
    start=start,
    check=check,
    limits=limits,
    ends=ends,
    force=force,
    levels=levels,
    observe=observe,
    event_values=event_values,
    sample=sample,
)

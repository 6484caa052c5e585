r"""Flexible wheel whose patch does not slip, whatever the force: the limit of ``flexible_wheel`` without any creep.

The same unknowns y and psi, forces and tyre law (47)-(51), but the two components of the patch velocity v_C vanish as
constraints on velocities (Cardona, Geradin and Doan, CMAME 89 (1991), section 3.4):

    v_C.t = 0,   v_C.l = 0          reactions: the driving and the lateral force on the wheel

The friction law of the tyre is not used; the friction coefficient that would be needed is an output. In mode "air"
the patch is let go. At a touch-down the wheel is spun up at once: the velocities jump to the nearest, by kinetic
energy, that do not slip, and the energy of this shock is lost. Sideways there is no shock, since y has no inertia.
"""

from numba import njit

from mecano.constraints.ground import GROUND_RECORD
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
from mecano.elements.lateral_law import LATERAL_RECORD, lateral_law, relax
from mecano.elements.patch_wheel import FIELDS, OUTPUTS, check, event_values, limits, prepare, put_patch, sample
from mecano.elements.tire_law import TIRE_RECORD, radial_force, speed_over_ground
from mecano.maths.surface import Block as OfContact
from mecano.maths.surface import directions, directions_variation
from mecano.maths.vec import (
    EYE,
    ZERO,
    add,
    add_col,
    add_vec,
    cross,
    dot,
    madd,
    mat,
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
MULTIPLIERS = 8  # driving, lateral
NO_MATRIX = (ZERO, ZERO, ZERO)


@njit
def _forces(p, laws, k, q, v):
    """Radial force F_r and its derivatives by w and dw/dt, N, speed of the axle, its direction, the Lateral."""
    radial, F_w, F_w1 = radial_force(p, laws, p.radius - k.g.r, k.w1)
    N = radial / k.g.q
    axle, ahead = speed_over_ground(k.g.n, vec(v, 0))
    return radial, F_w, F_w1, N, ahead, lateral_law(p, laws, (q[Y], q[PSI]), (v[Y], v[PSI]), N, axle)


@njit
def _add_block(A, j, n_columns, Rn, frame, k, forces, F, G, de, sizes, penalty, k_scale, d, d_speed, by_law, moment):
    """Add the derivatives by one block of variables; ``de`` those of t and l, ``sizes`` the forces along them."""
    radial, F_w, F_w1, N, ahead, law = forces
    t, l = directions(k.a, k.g)
    by_t = add(tmul(de[0], k.v_C), tmul(d.v_C, t))
    by_l = add(tmul(de[1], k.v_C), tmul(d.v_C, l))
    dF = madd(mscale(sizes[0], de[0]), outer(scale(penalty, t), by_t))
    dF = madd(dF, madd(mscale(sizes[1], de[1]), outer(scale(penalty, l), by_l)))
    dN = add(scale(1.0 / k.g.q, add(scale(F_w, d.w), scale(F_w1, d.w1))), scale(N * k.g.s / k.g.q**2, d.s))
    aligned = madd(outer(scale(-1.0, k.g.n), by_law[2]), mscale(-law.turn, d.n))
    add_patch_tangent(A, j, n_columns, Rn, frame, k, F, N, G, dF, dN, d, madd(moment, aligned))
    rows = (
        tmul(frame, add(by_law[0], add(scale(law.F_N, dN), scale(law.F_u, d_speed)))),
        tmul(frame, add(by_law[1], add(scale(law.M_N, dN), scale(law.M_u, d_speed)))),
        scale(-k_scale, tmul(frame, by_t)), scale(-k_scale, tmul(frame, by_l)),
    )  # fmt: skip
    for c in range(n_columns):
        for r in range(4):
            A[Y + r, j + c] += rows[r][c]


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
        relax(p, q, v, f, K, C, Y)
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
    f[Y] += law.F
    f[PSI] += law.M
    f[MULTIPLIERS] -= k * Phi[0]
    f[MULTIPLIERS + 1] -= k * Phi[1]
    _add_multipliers(K, Rn, at, k)

    none, b, still = (ZERO, ZERO, ZERO), p.aligning, (NO_MATRIX, NO_MATRIX)
    by_q = ((law.F_q[0], law.F_q[1], 0.0), (law.M_q[0], law.M_q[1], 0.0), (b[0], b[1], 0.0))
    by_v = ((law.F_v[0], law.F_v[1], 0.0), (law.M_v[0], law.M_v[1], 0.0), (b[2], b[3], 0.0))
    turning = skew(sub(cross(at.rho, G), scale(law.turn, at.g.n)))
    rise, frames = -dot(at.g.n, vec(v, 0)), (EYE, Rn, EYE)
    by_place, by_motion = by_positions(p, at, v[Y]), by_velocities(at)
    laws_of_place, laws_of_motion = (none, none, by_q), (none, none, by_v)
    moments, ahead = (none, turning, none), (forces[4], ZERO, ZERO)
    for i in range(3):
        n_columns, d = 3 if i < 2 else 2, by_place[i]
        climb, de = scale(rise, tmul(d.n, forces[4])), _turning(at, d, d.a)
        _add_block(
            K, 3 * i, n_columns, Rn, frames[i], at, forces, F, G, de, sizes, penalty, k, d, climb, laws_of_place[i],
            moments[i],
        )  # fmt: skip
        d = by_motion[i]
        _add_block(
            C, 3 * i, n_columns, Rn, frames[i], at, forces, F, G, still, sizes, penalty, k, d, ahead[i],
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
    dtype=record(**LATERAL_RECORD, axis=3, **GROUND_RECORD, **TIRE_RECORD),
    layout=("x0", "R0"),
    scalars=("lateral displacement", "torsion"),
    relaxing=("torsion",),
    multipliers=(Row("driving force of the ground", "N", "m/s"), Row("lateral force of the ground", "N", "m/s")),
    fields=FIELDS,
    outputs=OUTPUTS,
    modes=("air", "contact"),
    events=(
        Event("touch_down", "air", "contact", "the undeformed rim reaches the ground; a shock"),
        Event("lift_off", "contact", "air", "the deformation returns to zero"),
    ),
    prepare=prepare,
    check=check,
    limits=limits,
    force=force,
    levels=levels,
    observe=observe,
    event_values=event_values,
    sample=sample,
)

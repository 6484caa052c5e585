r"""Flexible wheel whose patch does not slip, whatever the force: the limit of ``flexible_wheel`` without any creep.

The same unknowns y and psi, forces and tyre law (47)-(51), but the two components of the patch velocity v_C vanish as
constraints on velocities (Cardona, Geradin and Doan, CMAME 89 (1991), section 3.4):

    v_C.t = 0,   v_C.l = 0          reactions: the driving and the lateral force on the wheel

The friction law of the tyre is not used; the friction coefficient that would be needed is an output. In mode "air"
the patch is let go. At a touch-down the wheel is spun up at once: the velocities jump to the nearest, by kinetic
energy, that do not slip. The impulse of this shock is that of the driving force, and its energy is lost
(docs/shocks.md). Sideways there is no shock, since y has no inertia.
"""

from typing import NamedTuple

from mecano.compiled.kernel import kernel
from mecano.constraints.augmented import let_go
from mecano.constraints.rolling import ROWS
from mecano.constraints.tire_patch import NO_MATRIX, PSI, Y, by_positions, by_velocities, patch, patch_column
from mecano.contract import GRIP, Event
from mecano.elements.lateral_force import relax
from mecano.elements.patch_load import add_load, add_load_tangent, changes, load_of, normal_change
from mecano.elements.patch_wheel import patch_wheel, put_patch
from mecano.elements.tire_wheel import AIR, CONTACT, LIFT_OFF
from mecano.maths.surface import Block, directions, directions_variation
from mecano.maths.vec import (
    ZERO,
    add,
    add_col,
    add_row,
    dot,
    madd,
    mat,
    mscale,
    mul,
    norm,
    outer,
    scale,
    tmul,
    vec,
)  # fmt: skip

MULTIPLIERS = 9  # driving, lateral


class Hold(NamedTuple):
    """The constraints: their directions (t, l), the forces along them [N], of which F is the sum, penalty, k."""

    along: tuple
    sizes: tuple
    F: tuple
    penalty: float
    k: float


@kernel
def _add_block(A, j, Rn, at, load, hold, G, c):
    """Add the derivatives by the variables of the Change ``c``."""
    dF, de = NO_MATRIX, _turning(at, c.d)
    for i in range(2):
        e = hold.along[i]
        by = add(tmul(de[i], at.v_C), tmul(c.d.v_C, e))
        dF = madd(dF, madd(mscale(hold.sizes[i], de[i]), outer(scale(hold.penalty, e), by)))
        add_row(A, MULTIPLIERS + i, j, -hold.k, tmul(c.frame, by))
    add_load_tangent(A, j, Rn, at, load, hold.F, G, dF, normal_change(at, load, c.d), c)


@kernel
def _add_multipliers(K, Rn, at, hold):
    """Columns of the two multipliers."""
    for i in range(2):
        force, moment, own = patch_column(at, hold.along[i])
        add_col(K, 0, MULTIPLIERS + i, -hold.k, force)
        add_col(K, 3, MULTIPLIERS + i, -hold.k, tmul(Rn, moment))
        add_col(K, Y, MULTIPLIERS + i, -hold.k, own)


@kernel
def _turning(k, d):
    """Derivatives of t and l by the variables of the Variation ``d``."""
    t, _ = directions(k.a, k.g)
    return directions_variation(k.a, k.g, t, Block(d.n, d.s, NO_MATRIX), d.a)


@kernel
def force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """Forces of ground and tyre law, constraints, and their derivatives; see the contract."""
    if mode == AIR:
        relax(p, q, v, f, K, C)
        for row in range(MULTIPLIERS, MULTIPLIERS + 2):
            let_go(f, K, row, k, q[row])
        return
    Rn, at = mat(R[0]), patch(p, laws, q, v, R)
    load = load_of(p, laws, at, q, v)
    along, across = directions(at.a, at.g)
    Phi = (dot(along, at.v_C), dot(across, at.v_C))
    sizes = (penalty * Phi[0] - q[MULTIPLIERS], penalty * Phi[1] - q[MULTIPLIERS + 1])
    F = add(scale(sizes[0], along), scale(sizes[1], across))
    hold = Hold((along, across), sizes, F, penalty, k)
    f[MULTIPLIERS] -= k * Phi[0]
    f[MULTIPLIERS + 1] -= k * Phi[1]
    _add_multipliers(K, Rn, at, hold)
    G = add_load(f, Rn, at, load, F)
    places, motions = changes(p, at, load, G, Rn, v[Y])
    for i in range(3):
        _add_block(K, 3 * i, Rn, at, load, hold, G, places[i])
        _add_block(C, 3 * i, Rn, at, load, hold, G, motions[i])


@kernel
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
        de = _turning(at, d)
        v_rate = add(v_rate, mul(d.v_C, rate))
        e_rate = (add(e_rate[0], mul(de[0], rate)), add(e_rate[1], mul(de[1], rate)))
    V, W, S1 = by_velocities(at)
    for d, rate in ((V, vec(a, 0)), (W, mul(mat(R[0]), vec(a, 3))), (S1, (a[Y], a[PSI], 0.0))):
        v_rate = add(v_rate, mul(d.v_C, rate))
    for i in range(2):
        g[i, 1] = dot(along[i], at.v_C)
        g[i, 2] = dot(e_rate[i], at.v_C) + dot(along[i], v_rate)


@kernel
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Outputs and energies; see OUTPUTS and the contract."""
    k = patch(p, laws, q, v, R)
    load = load_of(p, laws, k, q, v)
    along, across = directions(k.a, k.g)
    reaction = add(scale(q[MULTIPLIERS], along), scale(q[MULTIPLIERS + 1], across))
    grip = norm(reaction) / load.N if load.N > 0.0 else 0.0
    put_patch(p, laws, mode == CONTACT, k, q, v, load.radial, reaction, grip, 0.0, load.law, y, e)


ADHESIVE_WHEEL = patch_wheel(
    "adhesive_wheel",
    __doc__,
    ("psi", "bow"),
    force,
    observe,
    events=(Event("touch_down", "air", "contact", "the undeformed rim reaches the ground; a shock", GRIP), LIFT_OFF),
    multipliers=ROWS,
    levels=levels,
)

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
from mecano.constraints.tire_patch import PSI, Y, by_positions, by_velocities, patch, patch_column
from mecano.contract import GRIP, Event
from mecano.elements.lateral_force import relax
from mecano.elements.patch_load import add_load, add_load_tangent, changes, load_of, normal_change
from mecano.elements.patch_wheel import patch_wheel, put_patch
from mecano.elements.tire_wheel import AIR, CONTACT, LIFT_OFF
from mecano.maths.surface import Block, directions, directions_variation
from mecano.maths.vector import NO_MATRIX, ZERO, Vec3, add_col, add_row, dot, mat, norm, outer, vec

MULTIPLIERS = 9  # driving, lateral


class Hold(NamedTuple):
    """The constraints: their directions (t, l), the forces along them [N], of which F is the sum, penalty, k."""

    along: tuple
    sizes: tuple
    F: tuple
    penalty: float
    k: float


@kernel
def _add_block(A, j, Rn, here, load, hold, G, c):
    """Add the derivatives by the variables of the Change ``c``."""
    dF, de = NO_MATRIX, _turning(here, c.d)
    for i in range(2):
        e = hold.along[i]
        by = de[i].T @ here.v_C + c.d.v_C.T @ e
        dF = dF + (hold.sizes[i] * de[i] + outer(hold.penalty * e, by))
        add_row(A, MULTIPLIERS + i, j, -hold.k, c.frame.T @ by)
    add_load_tangent(A, j, Rn, here, load, hold.F, G, dF, normal_change(here, load, c.d), c)


@kernel
def _add_multipliers(K, Rn, here, hold):
    """Columns of the two multipliers."""
    for i in range(2):
        force, moment, own = patch_column(here, hold.along[i])
        add_col(K, 0, MULTIPLIERS + i, -hold.k, force)
        add_col(K, 3, MULTIPLIERS + i, -hold.k, Rn.T @ moment)
        add_col(K, Y, MULTIPLIERS + i, -hold.k, own)


@kernel
def _turning(k, d):
    """Derivatives of t and l by the variables of the Variation ``d``."""
    t, _ = directions(k.a, k.g)
    return directions_variation(k.a, k.g, t, Block(d.n, d.s, NO_MATRIX), d.a)


@kernel
def force(p, at, f, K, C, M):
    """Forces of ground and tyre law, constraints, and their derivatives; see the contract."""
    if at.phase == AIR:
        relax(p, at.q, at.v, f, K, C)
        for row in range(MULTIPLIERS, MULTIPLIERS + 2):
            let_go(f, K, row, at.k, at.q[row])
        return
    Rn, here = mat(at.R[0]), patch(p, at.laws, at.q, at.v, at.R)
    load = load_of(p, at.laws, here, at.q, at.v)
    along, across = directions(here.a, here.g)
    Phi = (dot(along, here.v_C), dot(across, here.v_C))
    sizes = (at.penalty * Phi[0] - at.q[MULTIPLIERS], at.penalty * Phi[1] - at.q[MULTIPLIERS + 1])
    F = sizes[0] * along + sizes[1] * across
    hold = Hold((along, across), sizes, F, at.penalty, at.k)
    f[MULTIPLIERS] -= at.k * Phi[0]
    f[MULTIPLIERS + 1] -= at.k * Phi[1]
    _add_multipliers(K, Rn, here, hold)
    G = add_load(f, Rn, here, load, F)
    places, motions = changes(p, here, load, G, Rn, at.v[Y])
    for i in range(3):
        _add_block(K, 3 * i, Rn, here, load, hold, G, places[i])
        _add_block(C, 3 * i, Rn, here, load, hold, G, motions[i])


@kernel
def levels(p, at, g):
    """Velocity of the patch along t and l, and its rate."""
    g[:, :] = 0.0
    if at.phase == AIR:
        return
    here = patch(p, at.laws, at.q, at.v, at.R)
    v_rate, e_rate = ZERO, (ZERO, ZERO)
    X, T, S = by_positions(p, here, at.v[Y])
    along = directions(here.a, here.g)
    for d, rate in ((X, vec(at.v, 0)), (T, here.omega), (S, Vec3(at.v[Y], at.v[PSI], 0.0))):
        de = _turning(here, d)
        v_rate = v_rate + d.v_C @ rate
        e_rate = (e_rate[0] + de[0] @ rate, e_rate[1] + de[1] @ rate)
    V, W, S1 = by_velocities(here)
    for d, rate in ((V, vec(at.a, 0)), (W, mat(at.R[0]) @ vec(at.a, 3)), (S1, Vec3(at.a[Y], at.a[PSI], 0.0))):
        v_rate = v_rate + d.v_C @ rate
    for i in range(2):
        g[i, 1] = dot(along[i], here.v_C)
        g[i, 2] = dot(e_rate[i], here.v_C) + dot(along[i], v_rate)


@kernel
def observe(p, at, F, y, e):
    """Outputs and energies; see OUTPUTS and the contract."""
    k = patch(p, at.laws, at.q, at.v, at.R)
    load = load_of(p, at.laws, k, at.q, at.v)
    along, across = directions(k.a, k.g)
    reaction = at.q[MULTIPLIERS] * along + at.q[MULTIPLIERS + 1] * across
    grip = norm(reaction) / load.N if load.N > 0.0 else 0.0
    put_patch(p, at.laws, at.phase == CONTACT, k, at.q, at.v, load.radial, reaction, grip, 0.0, load.law, y, e)


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

r"""Rolling radius: a disc of given radius touches the ground, :math:`r - radius = 0`.

With axis a, contact C = x + r c and q = |n - (n.a) a| of surface.py. On a plane this is (18) of Cardona, Geradin & Doan
1991 divided by q, (x - P).n - radius q = 0. The gradient is n/q at C, so the multiplier is the force in the plane of
the disc and the normal force N = k lambda/q. The constraint is inactive in the phase "air".
Its tangent is written by hand: rolling.py says why.
"""

import numpy as np

from mecano.constraints.augmented_lagrangian import deactivate
from mecano.constraints.ground import GROUND_RECORD, normal_and_level, touch
from mecano.constraints.triads import unit
from mecano.element_interface import Kind, Row, named, record
from mecano.jit.kernel import kernel
from mecano.maths.force_at_point import add_force, add_multiplier_column, add_position_tangent
from mecano.maths.surface import disc_variation
from mecano.maths.vector import add_row, cross, dot, mat, outer, vec

RECORD = record(axis=3, radius=(), **GROUND_RECORD)
CONTACT, AIR = 0, 1
MULTIPLIER = 6


@kernel
def _press(g, by):
    """Return d(n/q), 3x3, by the variables of the Block ``by``."""
    return by.n / g.q + outer(g.s / g.q**3 * g.n, by.s)


@kernel
def force(p, at, f, K, C, M):
    """Add the force n/q at C, and its moment."""
    if at.phase == AIR:
        deactivate(f, K, MULTIPLIER, at.k, at.q[MULTIPLIER])
        return
    Rn = mat(at.R[0])
    axis = Rn @ vec(p.axis, 0)
    g = touch(p, at.laws, vec(at.q, 0), axis)
    Phi, b = g.r - p.radius, g.n / g.q
    size = at.penalty * Phi - at.q[MULTIPLIER]
    pull, b_turn = size * b, cross(g.arm, b)
    add_force(f, Rn, g.arm, pull)
    f[MULTIPLIER] -= at.k * Phi
    add_multiplier_column(K, MULTIPLIER, at.k, Rn, g.arm, b)
    add_row(K, MULTIPLIER, 0, -at.k, b)
    add_row(K, MULTIPLIER, 3, -at.k, Rn.T @ b_turn)
    by_x, by_t = disc_variation(vec(p.direction, 0), axis, g)
    pull_x = size * _press(g, by_x) + outer(at.penalty * b, b)
    pull_t = size * _press(g, by_t) + outer(at.penalty * b, b_turn)
    add_position_tangent(K, Rn, g.arm, (by_x.arm, by_t.arm), pull, (pull_x, pull_t))


@kernel
def constraints(p, at, out):
    """Write value and rate."""
    if at.phase == CONTACT:
        Rn = mat(at.R[0])
        g = touch(p, at.laws, vec(at.q, 0), Rn @ vec(p.axis, 0))
        u = vec(at.v, 0) + cross(Rn @ vec(at.v, 3), g.arm)
        out[0, 0], out[0, 1] = g.r - p.radius, dot(g.n, u) / g.q


def leaning_discs(rng):
    """Return samples: leaning discs above a plane about 8 m from the origin, in contact and in the air."""
    found = []
    for phase in ("contact", "air"):
        normal, level = normal_and_level(rng)
        axis = unit(level + rng.uniform(-0.5, 0.5) * normal)
        ground = {"point": -8.0 * normal, "normal": normal, "direction": level, "height": 0}
        found.append(({"axis": axis, "radius": 7.0, **ground}, [(rng.normal(size=3), np.eye(3))], phase))
    return found


ROLLING_RADIUS = Kind(
    name="rolling_radius",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0"),
    multipliers=(Row("radial force of the ground", "N", "m", unilateral=True),),
    phases=("contact", "air"),
    **named(force, constraints),
    sample=leaning_discs,
)

r"""Blade: a point of a body that touches the ground does not move across a direction carried by the body.

:math:`v \cdot l = 0` with l = (a - s n)/q, the axis a of the body laid into the plane of the ground. The point is the
node. The multiplier is the force on the body along l.
"""

import numpy as np
from numba import njit

from mecano.constraints.ground import normal_and_level
from mecano.constraints.no_slip import NO_MATRIX, Direction, Place, hold, put_rates
from mecano.contract import Kind, Row, record
from mecano.maths.surface import Block, directions, directions_variation, disc_contact
from mecano.maths.vec import ZERO, cross, mat, mscale, mul, skew, vec

RECORD = record(axis=3, normal=3)


@njit
def _geometry(p, R):
    """Place of the contact, (l,)."""
    axis, n = mul(mat(R[0]), vec(p.axis, 0)), vec(p.normal, 0)
    g = disc_contact(n, ZERO, 0.0, axis)
    t, l = directions(axis, g)
    _, l_t = directions_variation(axis, g, t, Block(NO_MATRIX, cross(axis, n), NO_MATRIX), mscale(-1.0, skew(axis)))
    return Place(ZERO, (NO_MATRIX, NO_MATRIX)), (Direction(l, (NO_MATRIX, l_t)),)


@njit
def force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """Force across the blade."""
    place, across = _geometry(p, R)
    hold(k, penalty, place, across, q, v, R, f, K, C)


@njit
def levels(p, m, mode, t, laws, q, v, a, R, g):
    """Velocity across the blade and its rate."""
    place, across = _geometry(p, R)
    put_rates(place, across, v, a, R, g)


def sample(rng):
    """A leaning blade."""
    normal, level = normal_and_level(rng)
    axis = level + 0.3 * normal
    values = {"axis": axis / np.linalg.norm(axis), "normal": normal}
    return [(values, [(rng.normal(size=3), np.eye(3))], "")]


BLADE = Kind(
    name="blade",
    section="",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0"),
    multipliers=(Row("force across the blade", "N", "m/s"),),
    force=force,
    levels=levels,
    sample=sample,
)

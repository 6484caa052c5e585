r"""Upright rolling: the point below the centre of a disc does not slip, however the disc leans.

As rolling.py, but with the contact always at x - radius n: the small-inclination equations (22) and (25) of Cardona,
Geradin & Doan 1991 taken literally. On a plane only.
"""

import numpy as np
from numba import njit

from mecano.constraints.ground import normal_and_level
from mecano.constraints.no_slip import NO_MATRIX, Direction, Place, hold, put_rates
from mecano.constraints.rolling import ROWS
from mecano.contract import Kind, record
from mecano.maths.surface import Block, directions, directions_variation, disc_contact
from mecano.maths.vec import ZERO, cross, mat, mscale, mul, scale, skew, vec

RECORD = record(axis=3, radius=(), normal=3)


@njit
def _geometry(p, R):
    """Place of the contact, (t, l)."""
    axis, n = mul(mat(R[0]), vec(p.axis, 0)), vec(p.normal, 0)
    g = disc_contact(n, ZERO, p.radius, axis)
    t, l = directions(axis, g)
    t_t, l_t = directions_variation(axis, g, t, Block(NO_MATRIX, cross(axis, n), NO_MATRIX), mscale(-1.0, skew(axis)))
    place = Place(scale(-p.radius, n), (NO_MATRIX, NO_MATRIX))
    return place, (Direction(t, (NO_MATRIX, t_t)), Direction(l, (NO_MATRIX, l_t)))


@njit
def force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """Tangential forces below the centre and their moment."""
    place, along = _geometry(p, R)
    hold(k, penalty, place, along, q, v, R, f, K, C)


@njit
def levels(p, m, mode, t, laws, q, v, a, R, g):
    """Velocity of the point below the centre and its rate."""
    place, along = _geometry(p, R)
    put_rates(place, along, v, a, R, g)


def sample(rng):
    """A leaning disc."""
    normal, level = normal_and_level(rng)
    axis = level + 0.3 * normal
    values = {"axis": axis / np.linalg.norm(axis), "radius": 0.7, "normal": normal}
    return [(values, [(rng.normal(size=3), np.eye(3))], "")]


UPRIGHT_ROLLING = Kind(
    name="upright_rolling",
    section="",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0"),
    multipliers=ROWS,
    force=force,
    levels=levels,
    sample=sample,
)

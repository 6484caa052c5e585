"""Coordinates of several joints in one constraint: angles, any number of turns, and displacements.

The local unknowns are those of the angles, two rotations each, then those of the displacements, with ``x0``, ``R0`` and
``x1`` of their nodes, then the multiplier. The memory has the angles. Coordinates are numbered in the same order.
"""

from collections import namedtuple

import numpy as np

from mecano.constraints.along_coordinate.law import counted
from mecano.constraints.coordinates.coordinate import add_along, rate_of
from mecano.constraints.coordinates.slide import SLIDE
from mecano.constraints.coordinates.twist import TWIST
from mecano.element_interface import Place, Row, record
from mecano.jit.kernel import kernel

Turning = namedtuple("Turning", TWIST.axes)
Sliding = namedtuple("Sliding", SLIDE.axes)
angle, angle_in_turn, along_angle = counted(TWIST), TWIST.value, TWIST.gradient
displacement, along_displacement = SLIDE.value, SLIDE.gradient


@kernel
def _from(at, memory, unknown, rotation):
    """Return the Place of a coordinate whose memory, unknowns and rotations begin at these local indices."""
    q, v, a = at.q[unknown:], at.v[unknown:], at.a[unknown:]
    return Place(at.t, at.phase, at.k, at.penalty, at.laws, at.m[memory:], q, v, a, at.R[rotation:])


@kernel
def turning(p, at, i):
    """Return axes and Place of angle i."""
    return Turning(p.mu[i], p.xi[i]), _from(at, i, 6 * i, 2 * i)


@kernel
def sliding(p, at, i):
    """Return axes and Place of displacement i, which follow all angles."""
    n = len(p.mu)
    return Sliding(p.along[i]), _from(at, n, 6 * n + 9 * i, 2 * n + i)


@kernel
def row_of(p):
    """Return the local index of the multiplier."""
    return 6 * len(p.mu) + 9 * len(p.along)


@kernel
def commit(p, at, m_out):
    """Write the angles."""
    for i in range(len(p.mu)):
        m_out[i] = value_of(p, at, i)


@kernel
def value_of(p, at, i):
    """Return the value of coordinate i."""
    if i < len(p.mu):
        axes, place = turning(p, at, i)
        return angle(axes, place)
    axes, place = sliding(p, at, i - len(p.mu))
    return displacement(axes, place)


@kernel
def rate_along(p, at, i):
    """Return the rate of coordinate i."""
    if i < len(p.mu):
        axes, place = turning(p, at, i)
        return rate_of(along_angle(axes, place), place.v)
    axes, place = sliding(p, at, i - len(p.mu))
    return rate_of(along_displacement(axes, place), place.v)


@kernel
def add_load(p, at, f, i, load):
    """Add a load along coordinate i."""
    turns = len(p.mu)
    if i < turns:
        axes, place = turning(p, at, i)
        add_along(f[6 * i :], load, along_angle(axes, place))
    else:
        axes, place = sliding(p, at, i - turns)
        add_along(f[6 * turns + 9 * (i - turns) :], load, along_displacement(axes, place))


def axes_of(turns, slides):
    """Return the values of ``mu``, ``xi`` and ``along`` for the Measured of all angles and displacements."""
    return {
        "mu": np.reshape([one.axes["mu"] for one in turns], (-1, 3, 3)),
        "xi": np.reshape([one.axes["xi"] for one in turns], (-1, 3, 3)),
        "along": np.reshape([one.axes["mu"] for one in slides], (-1, 3)),
    }


def declarations(turns, slides, first, **own_record):
    """Return the declarations of a Kind whose angles and displacements begin at these nodes.

    ``first`` is the coordinate along which the multiplier is the load, ``own_record`` the fields of its record besides
    the axes.
    """
    what, unit = first.load
    rotations = (f"R{j + k}" for j in turns for k in (0, 1))
    ends = (slot for j in slides for slot in (f"x{j}", f"R{j}", f"x{j + 1}"))
    axes = {"mu": (len(turns), 3, 3), "xi": (len(turns), 3, 3), "along": (len(slides), 3)}
    return {
        "dtype": record(**axes, **own_record),
        "layout": (*rotations, *ends),
        "multipliers": (Row(f"{what} on the first joint", unit, first.unit),),
        "memory": tuple(f"angle_{i}" for i in range(1, len(turns) + 1)),
        "commit": commit if turns else None,
    }

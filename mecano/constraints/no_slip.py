r"""Constraints on the velocity of a contact point.

The point is at ``arm`` from the node and moves, as a point of the body, with u = v + omega x arm. Each constraint is
:math:`\Phi = e \cdot u = 0` for a unit vector e; both arm and e depend on position and rotation. The gradient with
respect to the velocities is (e, arm x e): the multiplier is the force on the body along e at the contact ((22), (24) of
Cardona, Geradin & Doan 1991).

The tangents are written by hand. With dual numbers that of a rolling disc takes three times as long on a plane (2.2
instead of 0.8 us) and nine times on a profile (69 instead of 7.6 us), where each pass searches the contact anew, and
compiling it takes as long: the decks rolling_disc and trailing_wheel_bump would take 6 and 13 % more processor time.
"""

from typing import NamedTuple

import numpy as np

from mecano.constraints.augmented_lagrangian import deactivate as release
from mecano.constraints.augmented_lagrangian import put_derivatives
from mecano.constraints.ground import normal_and_level
from mecano.jit.kernel import kernel
from mecano.maths.contact_force import add_force, add_multiplier_column, add_position_tangent, add_velocity_tangent
from mecano.maths.surface import Block, directions, directions_variation, disc_contact
from mecano.maths.vector import NO_MATRIX, ZERO, add_row, cross, dot, mat, outer, skew, vec

CONTACT, AIR = 0, 1
MULTIPLIERS = 6


class Place(NamedTuple):
    """A contact point, inertial: its arm, and the derivatives of the arm (by dx, by inertial dtheta), 3x3."""

    arm: tuple
    d_arm: tuple


class Direction(NamedTuple):
    """A unit vector, inertial, and its derivatives (by dx, by inertial dtheta), 3x3."""

    e: tuple
    de: tuple


@kernel
def on_a_plane(p, R):
    """Return the Directions t and l (surface.py) for a body axis on a plane; they depend only on its rotation."""
    axis, n = mat(R[0]) @ vec(p.axis, 0), vec(p.normal, 0)
    g = disc_contact(n, ZERO, 0.0, axis)
    t, l = directions(axis, g)
    by_turn = Block(NO_MATRIX, cross(axis, n), NO_MATRIX)
    t_t, l_t = directions_variation(axis, g, t, by_turn, -skew(axis))
    return Direction(t, (NO_MATRIX, t_t)), Direction(l, (NO_MATRIX, l_t))


def leaning(rng):
    """Return, for samples, the record of ``on_a_plane`` and the node of a leaning body."""
    normal, level = normal_and_level(rng)
    axis = level + 0.3 * normal
    return {"axis": axis / np.linalg.norm(axis), "normal": normal}, [(rng.normal(size=3), np.eye(3))]


@kernel
def velocity(place, Rn, v):
    """Return u [m/s], its derivatives (by dx, by inertial dtheta), 3x3, and the inertial angular velocity."""
    omega = Rn @ vec(v, 3)
    w = skew(omega)
    u = vec(v, 0) + cross(omega, place.arm)
    by_turn = skew(place.arm) @ w + w @ place.d_arm[1]
    return u, (w @ place.d_arm[0], by_turn), omega


@kernel
def hold(k, penalty, place, directions, q, v, R, f, K, C):
    """Add the constraints along the Directions ``directions``: the ``force`` of a part while in contact."""
    Rn = mat(R[0])
    u, du, _ = velocity(place, Rn, v)
    pull, pull_x, pull_t, by_u = ZERO, NO_MATRIX, NO_MATRIX, NO_MATRIX
    for i in range(len(directions)):
        e, de = directions[i]
        row, Phi = MULTIPLIERS + i, dot(e, u)
        size = penalty * Phi - q[row]
        by_x = de[0].T @ u + du[0].T @ e
        by_t = de[1].T @ u + du[1].T @ e
        pull = pull + size * e
        pull_x = pull_x + (size * de[0] + outer(penalty * e, by_x))
        pull_t = pull_t + (size * de[1] + outer(penalty * e, by_t))
        by_u = by_u + outer(penalty * e, e)
        f[row] -= k * Phi
        add_multiplier_column(K, row, k, Rn, place.arm, e)
        add_row(K, row, 0, -k, by_x)
        add_row(K, row, 3, -k, Rn.T @ by_t)
        add_row(C, row, 0, -k, e)
        add_row(C, row, 3, -k, Rn.T @ cross(place.arm, e))
    add_force(f, Rn, place.arm, pull)
    add_velocity_tangent(C, Rn, place.arm, by_u)
    add_position_tangent(K, Rn, place.arm, place.d_arm, pull, (pull_x, pull_t))


@kernel
def deactivate(n, k, q, f, K):
    """Deactivate ``n`` constraints: the ``force`` of a part in the air."""
    for row in range(MULTIPLIERS, MULTIPLIERS + n):
        release(f, K, row, k, q[row])


@kernel
def put_rates(place, directions, v, a, R, g):
    """Write the derivatives of the constraints: zero, the velocity, its rate."""
    Rn = mat(R[0])
    u, _, omega = velocity(place, Rn, v)
    x_rate = vec(v, 0)
    arm_rate = place.d_arm[0] @ x_rate + place.d_arm[1] @ omega
    u_rate = vec(a, 0) + (cross(Rn @ vec(a, 3), place.arm) + cross(omega, arm_rate))
    for i in range(len(directions)):
        e, de = directions[i]
        e_rate = de[0] @ x_rate + de[1] @ omega
        put_derivatives(g, i, 0.0, dot(e, u), dot(e_rate, u) + dot(e, u_rate))

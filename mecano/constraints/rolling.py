r"""Rolling: the point of a disc nearest to the ground does not slip.

:math:`u \cdot t = 0` and :math:`u \cdot l = 0` with u = v + omega x r c, the driving direction t = a x n/q and the
lateral direction l = n x t, all at the contact C of surface.py, at any inclination. The multipliers are the driving and
the lateral force on the disc, (22)-(24) of Cardona, Geradin & Doan 1991. They are inactive in the phase "air".

The tangent is written by hand: with dual numbers that of a rolling disc takes three times as long on a plane, and nine
times on a profile, where each pass searches for the contact again; the time integration of the decks rolling_disc and
bicycle takes 7 and 11 % more processor time (together with rolling_radius.py).
"""

from typing import NamedTuple

from mecano.constraints.augmented_lagrangian import deactivate
from mecano.constraints.ground import GROUND_RECORD, touch
from mecano.constraints.no_slip import MULTIPLIERS, put_slip
from mecano.constraints.rolling_radius import AIR, leaning_discs
from mecano.element_interface import Kind, Row, named, record
from mecano.jit.kernel import kernel
from mecano.maths.force_at_point import add_force, add_multiplier_column, add_position_tangent, add_velocity_tangent
from mecano.maths.surface import directions, directions_variation, disc_variation
from mecano.maths.vector import NO_MATRIX, ZERO, add_row, cross, dot, mat, outer, skew, vec

RECORD = record(axis=3, radius=(), **GROUND_RECORD)
ROWS = (Row("driving force of the ground", "N", "m/s"), Row("lateral force of the ground", "N", "m/s"))


class Variable(NamedTuple):
    """A vector, inertial, and its derivatives by dx and by the inertial dtheta, 3x3."""

    value: tuple
    by_x: tuple
    by_turn: tuple


@kernel
def _contact(p, at):
    """Return the arm of the contact and the directions t and l."""
    axis = mat(at.R[0]) @ vec(p.axis, 0)
    g = touch(p, at.laws, vec(at.q, 0), axis)
    return g.arm, directions(axis, g)


@kernel
def _varied_contact(p, at):
    """Return arm and directions of the contact as Variables."""
    axis = mat(at.R[0]) @ vec(p.axis, 0)
    g = touch(p, at.laws, vec(at.q, 0), axis)
    by_x, by_t = disc_variation(vec(p.direction, 0), axis, g)
    t, l = directions(axis, g)
    t_x, l_x = directions_variation(axis, g, t, by_x, NO_MATRIX)
    t_t, l_t = directions_variation(axis, g, t, by_t, -skew(axis))
    return Variable(g.arm, by_x.arm, by_t.arm), (Variable(t, t_x, t_t), Variable(l, l_x, l_t))


@kernel
def _velocity(arm, Rn, v):
    """Return the velocity [m/s] of the contact as a Variable."""
    omega = Rn @ vec(v, 3)
    w = skew(omega)
    return Variable(vec(v, 0) + cross(omega, arm.value), w @ arm.by_x, skew(arm.value) @ w + w @ arm.by_turn)


@kernel
def force(p, at, f, K, C, M):
    """Add tangential forces at C and their moment."""
    if at.phase == AIR:
        for row in range(MULTIPLIERS, MULTIPLIERS + 2):
            deactivate(f, K, row, at.k, at.q[row])
        return
    k, penalty, Rn = at.k, at.penalty, mat(at.R[0])
    arm, along = _varied_contact(p, at)
    u = _velocity(arm, Rn, at.v)
    pull, pull_x, pull_t, by_u = ZERO, NO_MATRIX, NO_MATRIX, NO_MATRIX
    for i in range(len(along)):
        e, row = along[i], MULTIPLIERS + i
        Phi = dot(e.value, u.value)
        size = penalty * Phi - at.q[row]
        by_x = e.by_x.T @ u.value + u.by_x.T @ e.value
        by_t = e.by_turn.T @ u.value + u.by_turn.T @ e.value
        pull = pull + size * e.value
        pull_x = pull_x + (size * e.by_x + outer(penalty * e.value, by_x))
        pull_t = pull_t + (size * e.by_turn + outer(penalty * e.value, by_t))
        by_u = by_u + outer(penalty * e.value, e.value)
        f[row] -= k * Phi
        add_multiplier_column(K, row, k, Rn, arm.value, e.value)
        add_row(K, row, 0, -k, by_x)
        add_row(K, row, 3, -k, Rn.T @ by_t)
        add_row(C, row, 0, -k, e.value)
        add_row(C, row, 3, -k, Rn.T @ cross(arm.value, e.value))
    add_force(f, Rn, arm.value, pull)
    add_velocity_tangent(C, Rn, arm.value, by_u)
    add_position_tangent(K, Rn, arm.value, (arm.by_x, arm.by_turn), pull, (pull_x, pull_t))


@kernel
def constraints(p, at, g):
    """Write the velocity of the contact."""
    if at.phase != AIR:
        arm, along = _contact(p, at)
        put_slip(at, arm, along, g)


ROLLING = Kind(
    name="rolling",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0"),
    multipliers=ROWS,
    phases=("contact", "air"),
    **named(force, constraints),
    sample=leaning_discs,
)

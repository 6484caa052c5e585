r"""Constraints on the velocity of a contact point.

The point is at ``arm`` from the node and moves, as a point of the body, with u = v + omega x arm. Each constraint is
:math:`\Phi = e \cdot u = 0` for a unit vector e; both arm and e depend on position and rotation. The gradient with
respect to the velocities is (e, arm x e): the multiplier is the force on the body along e at the contact ((22), (24) of
Cardona, Geradin & Doan 1991).
"""

from mecano.element_interface import named
from mecano.jit.kernel import kernel
from mecano.maths.surface import directions, disc_contact
from mecano.maths.vector import add_vec, cross, dot, mat, vec

MULTIPLIERS = 6
CONTACT, AIR = 0, 1  # phases


@kernel
def on_a_plane(p, R):
    """Return the unit vectors t and l (surface.py) for a body axis on a plane."""
    axis = mat(R[0]) @ vec(p.axis, 0)
    return directions(axis, disc_contact(p, vec(p.normal, 0), 0.0, axis))


@kernel
def velocity_at(at, arm):
    """Return the velocity [m/s] of the point of the body at ``arm``."""
    return vec(at.v, 0) + cross(mat(at.R[0]) @ vec(at.v, 3), arm)


def no_slip(contact, rows):
    """Return ``residual`` and ``constraints`` of a contact that does not slip; inactive in the phase AIR.

    ``contact(p, at)`` returns the arm from the node and ``rows`` unit vectors, along which the point is held.
    """

    @kernel
    def residual(p, at, f):
        if at.phase == AIR:
            for row in range(MULTIPLIERS, MULTIPLIERS + rows):
                f[row] -= at.q[row]
        else:
            arm, along = contact(p, at)
            Rn, u = mat(at.R[0]), velocity_at(at, arm)
            for i in range(rows):
                row, Phi = MULTIPLIERS + i, dot(along[i], u)
                force = (at.penalty * Phi - at.q[row]) * along[i]
                add_vec(f, 0, 1.0, force)
                add_vec(f, 3, 1.0, Rn.T @ cross(arm, force))
                f[row] -= at.k * Phi

    @kernel
    def constraints(p, at, g):
        if at.phase != AIR:
            arm, along = contact(p, at)
            u = velocity_at(at, arm)
            for i in range(rows):
                g[i, 1] = dot(along[i], u)

    return named(residual, constraints)

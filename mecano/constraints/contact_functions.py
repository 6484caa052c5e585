"""Compiled functions of a contact of two bodies, for any pair of shapes; equations in elements/joints/contact.py.

Local unknowns: x0, R0, x1, and R1 where the shape on b turns with its node or friction turns it; then the inputs and
the multiplier of a rigid contact, held at the gap m[0]. ``shapes`` are Shapes (touching.py).
"""

import math

import numpy as np

from mecano.constraints.augmented_lagrangian import held_from_event, in_phase
from mecano.constraints.touching import ROUNDING, sliding
from mecano.constraints.triads import hat, triad
from mecano.jit.kernel import kernel
from mecano.laws.contact_force import contact_force, elastic_energy, elastic_force
from mecano.laws.friction import friction
from mecano.laws.law_table import curve
from mecano.maths.dual import at_least, number, select, value
from mecano.maths.vector import ZERO, add_vec, cross, dot, mat, norm, put, vec

OPEN, CLOSED = 0, 1
TURNING = 12  # number of local unknowns of two nodes with rotations


@kernel
def _add_on_a(f, at, touched, on_b):
    """Add the force opposite to that on b, and its moment about node a."""
    add_vec(f, 0, 1.0, on_b)
    add_vec(f, 3, 1.0, mat(at.R[0]).T @ cross(touched.a, on_b))


@kernel
def _add_forces(f, at, touched, on_b):
    """Add the force on b and the opposite one on a, with their moments about both nodes."""
    _add_on_a(f, at, touched, on_b)
    add_vec(f, 6, -1.0, on_b)
    add_vec(f, 9, -1.0, mat(at.R[1]).T @ cross(touched.b, on_b))


@kernel
def _add_central_forces(f, at, touched, on_b):
    """Add the force through the centre of b and the opposite one on a, with its moment about node a."""
    _add_on_a(f, at, touched, on_b)
    add_vec(f, 6, -1.0, on_b)


@kernel
def _central_gradient(at, touched):
    """Return the gradient of the gap to a ball on b by blocks of the local unknowns."""
    return (0, -touched.n), (3, -(mat(at.R[0]).T @ cross(touched.a, touched.n))), (6, touched.n)


@kernel
def _gradient(at, touched):
    """Return the gradient of the gap to a shape that turns with b by blocks of the local unknowns."""
    return *_central_gradient(at, touched), (9, mat(at.R[1]).T @ cross(touched.b, touched.n))


@kernel
def _put(at, touched, N, F_t, u, y):
    """Write gap, normal force, friction, speed of sliding, force on b, contact point, state."""
    y[0], y[1], y[2], y[3] = touched.gap, N, norm(F_t), norm(u)
    put(y, 4, N * touched.n + F_t)
    put(y, 7, vec(at.q, 6) + touched.b)
    y[10] = 1.0 if at.phase == CLOSED else 0.0


@kernel
def _friction(p, at, touched, N):
    """Return the friction on b [N] and the velocity of sliding [m/s], inertial."""
    u = sliding(touched, at)
    return -(N * friction(at.laws, p.coefficient, p.regularization, norm(u))) * u, u


@kernel
def _no_friction(p, at, touched, N):
    """Return the friction on b and the velocity of sliding of a smooth contact."""
    return ZERO, ZERO


def _event_values(shapes, row, inputs=0):
    """Return ``event_values``: the depth [m]; then -N [N] of the multiplier at ``row``, or the gap without one.

    For a rigid contact with two ``inputs``, before its multiplier, the trigger of activation while nothing overlaps,
    the same while the bodies overlap, and the end of the overlap [m] follow.
    """
    touch = shapes.touch

    @kernel
    def of_elastic(p, at, g):
        gap = touch(p, at).gap
        g[0], g[1] = -gap, gap

    @kernel
    def of_rigid(p, at, g):
        g[0], g[1] = -touch(p, at).gap, -at.q[row]

    @kernel
    def of_switched(p, at, g):
        of_rigid(p, at, g)
        apart, due = ROUNDING - g[0], at.q[row - 2]
        g[2], g[3], g[4] = min(due, apart), min(due, -apart), apart

    return of_elastic if row is None else of_switched if inputs else of_rigid


def elastic(shapes, rubs):
    """Return the functions of an elastic contact, with friction if it ``rubs``, as fields of a Kind."""
    touch, approach, friction_of = shapes.touch, shapes.approach, _friction if rubs else _no_friction
    add_forces = _add_forces if rubs or shapes.turning else _add_central_forces

    @kernel
    def normal_force(p, at, touched):
        return contact_force(at.laws, p.law, p.damping, -touched.gap, approach(touched, at))

    @kernel
    def residual(p, at, f):
        if at.phase == CLOSED:
            touched = touch(p, at)
            N = normal_force(p, at, touched)
            add_forces(f, at, touched, N * touched.n + friction_of(p, at, touched, N)[0])

    @kernel
    def observe(p, at, F, y, e):
        touched = touch(p, at)
        w, N = -touched.gap, select(at.phase == CLOSED, normal_force(p, at, touched), 0.0)
        F_t, u = friction_of(p, at, touched, N)
        if at.phase == CLOSED:
            e[1] = elastic_energy(at.laws, p.law, at_least(value(w), 0.0))
            e[2] = (N - elastic_force(at.laws, p.law, w)) * approach(touched, at) - dot(F_t, u)
        _put(at, touched, N, F_t, u, y)

    return {"residual": residual, "observe": observe, "event_values": _event_values(shapes, None)}


def rigid(shapes, inputs=0):
    """Return the functions of the constraint of a rigid contact with ``inputs`` inputs, as fields of a Kind."""
    touch, row = shapes.touch, 3 * len(shapes.layout) + inputs
    gradient = _gradient if shapes.turning else _central_gradient

    @kernel
    def gap(p, at):
        touched = touch(p, at)
        return touched.gap, gradient(at, touched)

    return held_from_event(gap, row, in_phase(CLOSED))


def observed_rigid(shapes, inputs=0):
    """Return ``observe`` and ``event_values`` of a rigid contact without friction, as fields of a Kind."""
    touch, row = shapes.touch, 3 * len(shapes.layout) + inputs

    @kernel
    def observe(p, at, F, y, e):
        _put(at, touch(p, at), number(at.q[row]), ZERO, ZERO, y)

    return {"observe": observe, "event_values": _event_values(shapes, row, inputs)}


def rubbing(shapes):
    """Return the residual of the friction of a rigid contact, whose multiplier is coupled."""
    touch = shapes.touch

    @kernel
    def residual(p, at, f):
        touched = touch(p, at)
        _add_forces(f, at, touched, _friction(p, at, touched, at_least(at.q[TURNING], 0.0))[0])

    return residual


def impact_friction(shapes):
    """Return ``impact_friction`` of the friction of a rigid contact."""

    def found(p, at):
        touched = shapes.touch(p, at)
        along = triad(touched.n)[:2]
        turning_a, turning_b = along @ hat(touched.a) @ at.R[0], -along @ hat(touched.b) @ at.R[1]
        gradients = np.hstack([-along, turning_a, along, turning_b, np.zeros((2, 1))])
        u = gradients[:, :TURNING] @ at.v[:TURNING]
        mu = curve(at.laws, p.coefficient, math.sqrt(u @ u))
        return max(mu, 0.0), gradients

    return found


def observed_rubbing(shapes, inputs):
    """Return ``observe`` and ``event_values`` of a rigid contact with friction, as fields of a Kind."""
    touch, row = shapes.touch, TURNING + inputs

    @kernel
    def observe(p, at, F, y, e):
        touched, N = touch(p, at), select(at.phase == CLOSED, at_least(number(at.q[row]), 0.0), 0.0)
        F_t, u = _friction(p, at, touched, N)
        e[2] = -dot(F_t, u)
        _put(at, touched, N, F_t, u, y)

    return {"observe": observe, "event_values": _event_values(shapes, row, inputs)}

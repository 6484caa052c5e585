r"""Friction of a ball in its socket: a moment against the relative angular velocity.

With the force F that the joint transmits, the radius r, the relative angular velocity w (of b relative to a) and
:math:`u = r |w|`:

.. math::  M = r\, |F|\, \mu(u)\,\phi(u)\, w/|w|

on a along w, on b against it: the ball bears at one point, assumed where the sliding speed is largest.
"""

from mecano.constraints.along_coordinate.friction import FRICTION_RECORD, POWER, REGULARIZED
from mecano.constraints.body_fixed import relative_rotation
from mecano.element_interface import Kind, Output, Row, named, record
from mecano.jit.kernel import kernel
from mecano.laws.friction import friction
from mecano.maths.vector import add_vec, dot, norm, vec

RECORD = record(radius=(), **FRICTION_RECORD)
COUPLED = 6


@kernel
def _sliding(p, at):
    """Return the angular velocity w of b relative to a, the friction moment on b against it, both in axes of a; |F|."""
    w = relative_rotation(at) @ vec(at.v, 3) - vec(at.v, 0)
    N, r = norm(vec(at.q, COUPLED)), p.radius
    return w, N * r * r * friction(at.laws, p.coefficient, p.regularization, r * norm(w)) * w, N


@kernel
def residual(p, at, f):
    """Add opposite moments to both nodes."""
    _, moment, _ = _sliding(p, at)
    add_vec(f, 0, -1.0, moment)
    add_vec(f, 3, 1.0, relative_rotation(at).T @ moment)


@kernel
def observe(p, at, F, y, e):
    """Write moment, normal force, power."""
    w, moment, y[1] = _sliding(p, at)
    y[0] = norm(moment)
    y[2] = dot(moment, w)
    e[2] = y[2]


BALL_FRICTION = Kind(
    name="ball_friction", doc=__doc__ + REGULARIZED, dtype=RECORD, layout=("R0", "R1"),
    coupled_multipliers=tuple(Row(f"force {axis} of the joint", "N", "m") for axis in "xyz"),
    outputs=(
        Output("friction_moment", "N m", "magnitude of the friction moment"),
        Output("normal_force", "N", "magnitude of the force that the ball transmits"),
        POWER,
    ),
    **named(residual, observe),
)  # fmt: skip

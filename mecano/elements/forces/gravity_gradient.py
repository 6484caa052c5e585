r"""Gravity gradient of a circular orbit on a body: satellites that librate, tethers, formations.

Positions are relative to a point that moves on the orbit, in axes that do not turn. With the mean motion n, the
direction u from or to the centre of attraction, which turns at n about the ``normal`` of the orbit, and
:math:`y = x_C - o` from the point o on the orbit to the centre of mass, force and moment about it are

.. math::  F = -m n^2 (y - 3 u\, (u \cdot y)), \qquad M = 3 n^2\, u \times J_C\, u

to the first order in the extent of the model over the radius of the orbit (Hughes, Spacecraft Attitude Dynamics, 1986,
chapter 8; in turning axes F gives the equations of Clohessy and Wiltshire, 1960). Without ``inertia`` the mass is a
point, and the node needs no orientation. Give the deck ``gravity: none``: the point on the orbit falls freely.
"""

import math
from dataclasses import replace

import numpy as np

from mecano.constraints.triads import triad, unit
from mecano.element_interface import Display, Kind, Output, named, record
from mecano.jit.kernel import kernel
from mecano.maths.inertia import inertia_matrix
from mecano.maths.vector import add_vec, cross, dot, mat, put, vec
from mecano.schema import DIRECTION, INERTIA, NODE, NODE_VECTOR, NUMBER, POINT, Field, positive

CENTER = (0.4, 1.0, -0.6)  # of samples
LEAST_SINE = 1e-6  # of the angle between both directions
RECORD = record(n=(), mass=(), center=3, radial=3, transverse=3, c=3, J=(3, 3))


@kernel
def _radial(p, at):
    """Return the direction u."""
    angle = p.n * at.t
    return math.cos(angle) * vec(p.radial, 0) + math.sin(angle) * vec(p.transverse, 0)


@kernel
def _force(p, u, x):
    """Return the force on the mass at x."""
    y = x - vec(p.center, 0)
    return -p.mass * p.n * p.n * (y - 3.0 * dot(u, y) * u)


@kernel
def _on_body(p, at):
    """Return force, inertial, and moment about the centre of mass, material, on a body."""
    A, u = mat(at.R[0]), _radial(p, at)
    seen = A.T @ u
    return _force(p, u, vec(at.q, 0) + A @ vec(p.c, 0)), 3.0 * p.n * p.n * cross(seen, mat(p.J) @ seen)


@kernel
def point_residual(p, at, f):
    """Add the force on a point mass."""
    add_vec(f, 0, -1.0, _force(p, _radial(p, at), vec(at.q, 0)))


@kernel
def observe_point(p, at, F, y, e):
    """Write force, no moment, and power."""
    force = _force(p, _radial(p, at), vec(at.q, 0))
    put(y, 0, force)
    y[6] = dot(force, vec(at.v, 0))
    e[3] = y[6]


@kernel
def body_residual(p, at, f):
    """Add force and moment on a body."""
    force, moment = _on_body(p, at)
    add_vec(f, 0, -1.0, force)
    add_vec(f, 3, -1.0, moment + cross(vec(p.c, 0), mat(at.R[0]).T @ force))


@kernel
def observe_body(p, at, F, y, e):
    """Write force and moment, inertial, and their power."""
    force, moment = _on_body(p, at)
    A, omega = mat(at.R[0]), vec(at.v, 3)
    put(y, 0, force)
    put(y, 3, A @ moment)
    y[6] = dot(force, vec(at.v, 0) + A @ cross(omega, vec(p.c, 0))) + dot(moment, omega)
    e[3] = y[6]


def prepare(d, nodes, context):
    """Return the record of one body; u turns from ``radial`` to ``transverse`` by a quarter of the orbit."""
    normal = triad(d["normal"])[2]
    radial = unit(np.asarray(d["radial"], float) - normal * (normal @ d["radial"]))
    return {
        "n": d["rate"], "mass": d["mass"], "center": np.zeros(3) if d["center"] is None else np.asarray(d["center"]),
        "radial": radial, "transverse": np.cross(normal, radial), "c": np.asarray(d["center_of_mass"], float),
        "J": np.zeros((3, 3)) if d["inertia"] is None else inertia_matrix(d["inertia"]),
    }  # fmt: skip


def check(d, nodes):
    """Return errors for a radial direction along the normal, and for a point mass away from its node."""
    sine = np.linalg.norm(np.cross(unit(d["normal"]), unit(d["radial"])))
    texts = ["'radial' must not be along 'normal'"] if sine < LEAST_SINE else []
    if d["inertia"] is None and np.any(d["center_of_mass"]):
        texts.append("'center_of_mass' belongs to 'inertia'")
    return texts


GRAVITY_GRADIENT = Kind(
    name="gravity_gradient", section="loads", doc=__doc__, display=Display(force="force"), dtype=RECORD, layout=("x0",),
    fields=(
        Field("node", NODE, "-", "node of the body"),
        Field("mass", NUMBER, "kg", "its mass", check=positive),
        Field("inertia", INERTIA, "kg m2", "its inertia about the centre of mass, in the axes of the node; a point "
              "mass when absent", None),
        Field("center_of_mass", NODE_VECTOR, "m", "its centre of mass from the node, in the axes of the node",
              (0.0,) * 3),
        Field("rate", NUMBER, "rad/s", "n, mean motion of the orbit: square root of mu/r^3", check=positive),
        Field("normal", DIRECTION, "-", "normal of the orbit, about which it turns, inertial"),
        Field("radial", DIRECTION, "-", "direction from the centre of attraction at t = 0, inertial; only its part "
              "normal to 'normal' counts"),
        Field("center", POINT, "m", "point o on the orbit; the origin when absent", None),
    ),
    outputs=(
        Output("force", "N", "force, inertial", (3,)),
        Output("moment", "N m", "moment about the centre of mass, inertial", (3,)),
        Output("power", "W", "power of force and moment"),
    ),
    residual=point_residual,
    observe=observe_point,
    variant=lambda d: GRAVITY_GRADIENT if d["inertia"] is None else ON_BODY,
    cases=(
        {"center_of_mass": (0.0,) * 3, "center": CENTER},
        {"inertia": np.diag([2.0, 1.3, 0.9]), "center": CENTER},
    ),
    **named(prepare, check),
)  # fmt: skip
ON_BODY = replace(GRAVITY_GRADIENT, layout=("x0", "R0"), residual=body_residual, observe=observe_body, variant=None)

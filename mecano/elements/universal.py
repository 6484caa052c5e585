r"""Universal joint: a cross whose one pin turns in node a, the other, perpendicular to it, in node b.

Both nodes share one position. With :math:`\mu_3` the pin carried by a and :math:`\xi_3` the one carried by b:

.. math::  \mu_3 \cdot \xi_3 = 0

The multiplier is the moment on b about :math:`\xi_3 \times \mu_3`, the only one that the cross transmits.
"""

import math

import numpy as np
from numba import njit

from mecano.constraints.carried import carried, follow, product_rates
from mecano.constraints.joint_frame import not_at_one_place, triad
from mecano.constraints.orthogonal import ORTHOGONAL
from mecano.contract import Kind, Output, Part, record
from mecano.maths.vec import ZERO, mat, put, scale, vec
from mecano.schema import DIRECTION, NODE_PAIR, Field

RECORD = record(mu=(3, 3), xi=(3, 3))
PERPENDICULAR = 1e-6  # cosine up to which the pins count as perpendicular


@njit
def _pin_angle(A, omega_a, mu, B, omega_b, pin):
    """Angle and rate, about mu_3 carried by the rotation A, of a pin carried by B."""
    xi = carried(B, omega_b, ZERO, pin)
    u, du, _ = product_rates(carried(A, omega_a, ZERO, mu[0]), xi)
    w, dw, _ = product_rates(carried(A, omega_a, ZERO, mu[1]), xi)
    return math.atan2(w, u), (u * dw - w * du) / (u * u + w * w)


@njit
def _angles(p, v, R):
    """Angle and rate of the cross about the pin of a, and of b about its own pin relative to the cross."""
    mu, xi = mat(p.mu), mat(p.xi)
    A, B, omega_a, omega_b = mat(R[0]), mat(R[1]), vec(v, 3), vec(v, 9)
    first, first_rate = _pin_angle(A, omega_a, mu, B, omega_b, xi[2])
    # seen from b the cross turns the other way
    second, second_rate = _pin_angle(B, omega_b, xi, A, omega_a, mu[2])
    return first, first_rate, -second, -second_rate


@njit
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Both angles and the reactions."""
    first, y[1], second, y[3] = _angles(p, v, R)
    y[0] = follow(m[0], first)
    y[2] = follow(m[1], second)
    put(y, 4, scale(-1.0, vec(F, 6)))
    y[7] = q[12]


@njit
def commit(p, m, mode, t, laws, q, v, a, R, m_out):
    """Follow both angles over whole turns."""
    first, _, second, _ = _angles(p, v, R)
    m_out[0] = follow(m[0], first)
    m_out[1] = follow(m[1], second)


def prepare(d, nodes, context):
    """Axes of both nodes: third the own pin, first the pin of the other at the start."""
    mu = triad(d["axis_a"], np.asarray(d["axis_b"], float))
    xi = triad(mu[0], mu[2])
    return {"mu": mu @ nodes[0][1], "xi": xi @ nodes[1][1]}


def parts(d, nodes, context):
    """The pins are perpendicular."""
    p = prepare(d, nodes, context)
    return [Part(ORTHOGONAL, (0, 1), {"mu": p["mu"][2], "xi": p["xi"][2]})]


def shares(d, n_nodes):
    """One position."""
    return [("x", 0, 1)]


def check(d, nodes):
    """The nodes start at one place and the pins are perpendicular."""
    cosine = triad(d["axis_a"])[2] @ triad(d["axis_b"])[2]
    texts = not_at_one_place(nodes)
    if abs(cosine) > PERPENDICULAR:
        degrees = np.degrees(np.arccos(cosine))
        texts.append(f"'axis_a' and 'axis_b' must be perpendicular; they are {degrees:.6g} degrees apart")
    return texts


def sample(rng):
    """Random perpendicular pins."""
    pins = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    x = rng.normal(size=3)
    return [({"axis_a": pins[0], "axis_b": 2 * pins[1]}, [(x, np.eye(3)), (x, np.diag([-1.0, 1.0, -1.0]))], "")]


UNIVERSAL = Kind(
    name="universal",
    section="joints",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0", "x1", "R1"),
    fields=(
        Field("nodes", NODE_PAIR, "-", "nodes a and b; either may be ground"),
        Field("axis_a", DIRECTION, "-", "pin carried by a at the start, inertial"),
        Field("axis_b", DIRECTION, "-", "pin carried by b at the start, inertial, perpendicular to axis_a"),
    ),
    outputs=(
        Output("angle_a", "rad", "rotation of the cross relative to a about axis_a since the start, over any turns"),
        Output("rate_a", "rad/s", "rate of angle_a"),
        Output("angle_b", "rad", "rotation of b relative to the cross about axis_b since the start, over any turns"),
        Output("rate_b", "rad/s", "rate of angle_b"),
        Output("force", "N", "force of a on b, inertial axes", (3,)),
        Output("moment", "N m", "moment of a on b about axis_b x axis_a"),
    ),
    memory=("angle_a", "angle_b"),
    prepare=prepare,
    shares=shares,
    parts=parts,
    check=check,
    observe=observe,
    commit=commit,
    sample=sample,
)

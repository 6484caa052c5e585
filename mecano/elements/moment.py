r"""Moments at a node, as functions of time: dead (fixed direction) or following the node.

With M(t) from a curve and the unit direction d: ``moment`` keeps d inertial, so that its material components turn,
:math:`f_\Theta = -M R^T d` with the tangent :math:`-M \widehat{R^T d}`, which is not symmetric (a dead moment has no
potential); ``follower_moment`` carries d with the node, :math:`f_\Theta = -M d` in material axes, without tangent.
"""

import numpy as np
from numba import njit

from mecano.contract import Kind, Output, record
from mecano.laws.table import evaluate_curve
from mecano.maths.vec import add_mat, add_vec, dot, mat, mul, put, scale, skew, tmul, vec
from mecano.schema import CURVE, DIRECTION, NODE, Field

RECORD = record(law="i", direction=3)
OUTPUTS = (
    Output("moment", "N m", "moment on the node, inertial", (3,)),
    Output("power", "W", "power given to the node"),
)
VALUE = Field("value", CURVE, "N m", "moment as a function of time [s]")


@njit
def moment(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """The dead moment."""
    size, d = evaluate_curve(laws, p.law, t)[0], tmul(mat(R[0]), vec(p.direction, 0))
    add_vec(f, 0, -size, d)
    add_mat(K, 0, 0, -size, skew(d))


@njit
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Moment and power."""
    size, d = evaluate_curve(laws, p.law, t)[0], vec(p.direction, 0)
    _report(size, d, tmul(mat(R[0]), d), v, y, e)


@njit
def _report(size, direction, material, v, y, e):
    put(y, 0, scale(size, direction))
    y[3] = size * dot(material, vec(v, 0))
    e[3] = y[3]


@njit
def follower_moment(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """The moment carried by the node; it has no tangent in material axes."""
    add_vec(f, 0, -evaluate_curve(laws, p.law, t)[0], vec(p.direction, 0))


@njit
def follower_observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Moment and power."""
    size, d = evaluate_curve(laws, p.law, t)[0], vec(p.direction, 0)
    _report(size, mul(mat(R[0]), d), d, v, y, e)


def prepare(d, nodes, context):
    """Record of a dead moment."""
    direction = np.asarray(d["direction"], float)
    return {"law": context.laws.add(d["value"]), "direction": direction / np.linalg.norm(direction)}


def prepare_follower(d, nodes, context):
    """Record of a follower moment: the direction in the axes of the node."""
    values = prepare(d, nodes, context)
    return {**values, "direction": nodes[0][1].T @ values["direction"]}


def sample(rng):
    """A smooth step about a random direction."""
    value = (
        ("step", {"time": -5.0, "rise": 10.0, "from": 1.0, "to": 3.0}),
        ("constant", {"value": rng.uniform(1, 2)}),
    )
    return [({"direction": rng.normal(size=3), "value": value}, 1, "")]


MOMENT = Kind(
    name="moment",
    section="loads",
    doc=__doc__,
    dtype=RECORD,
    layout=("R0",),
    fields=(
        Field("node", NODE, "-", "node that it acts on"),
        Field("direction", DIRECTION, "-", "direction, inertial, made a unit vector"),
        VALUE,
    ),
    outputs=OUTPUTS,
    prepare=prepare,
    force=moment,
    observe=observe,
    sample=sample,
)

FOLLOWER_MOMENT = Kind(
    name="follower_moment",
    section="loads",
    doc=__doc__,
    dtype=RECORD,
    layout=("R0",),
    fields=(
        Field("node", NODE, "-", "node that it acts on and that carries its direction"),
        Field("direction", DIRECTION, "-", "direction at the start, inertial, made a unit vector"),
        VALUE,
    ),
    outputs=OUTPUTS,
    prepare=prepare_follower,
    force=follower_moment,
    observe=follower_observe,
    sample=sample,
)

r"""Forces at a node, as functions of time: dead (fixed direction) or following the node.

With F(t) from a curve and the unit direction d: ``force`` keeps d inertial, :math:`f = -F d`;
``follower_force`` carries it with the node, :math:`f = -F R d`, whose tangent
:math:`F R \hat d` by the material rotation is not symmetric: a follower force has no potential.
"""

import numpy as np
from numba import njit

from mecano.contract import Kind, Output, record
from mecano.laws.table import evaluate_curve
from mecano.maths.vec import add_mat, add_vec, dot, mat, matmul, mul, put, scale, skew, vec
from mecano.schema import CURVE, DIRECTION, NODE, Field

RECORD = record(law="i", direction=3)
OUTPUTS = (
    Output("force", "N", "force on the node, inertial", (3,)),
    Output("power", "W", "power given to the node"),
)
VALUE = Field("value", CURVE, "N", "force as a function of time [s]")


@njit
def force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """The dead force; it has no tangent."""
    add_vec(f, 0, -evaluate_curve(laws, p.law, t)[0], vec(p.direction, 0))


@njit
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Force and power."""
    _report(evaluate_curve(laws, p.law, t)[0], vec(p.direction, 0), v, y, e)


@njit
def _report(size, direction, v, y, e):
    put(y, 0, scale(size, direction))
    y[3] = size * dot(direction, vec(v, 0))
    e[3] = y[3]


@njit
def follower_force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """The force carried by the node."""
    size, d = evaluate_curve(laws, p.law, t)[0], vec(p.direction, 0)
    add_vec(f, 0, -size, mul(mat(R[0]), d))
    add_mat(K, 0, 3, size, matmul(mat(R[0]), skew(d)))


@njit
def follower_observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Force and power."""
    _report(evaluate_curve(laws, p.law, t)[0], mul(mat(R[0]), vec(p.direction, 0)), v, y, e)


def prepare(d, nodes, context):
    """Record of a dead force."""
    direction = np.asarray(d["direction"], float)
    return {"law": context.laws.add(d["value"]), "direction": direction / np.linalg.norm(direction)}


def prepare_follower(d, nodes, context):
    """Record of a follower force: the direction in the axes of the node."""
    values = prepare(d, nodes, context)
    return {**values, "direction": nodes[0][1].T @ values["direction"]}


def sample(rng):
    """A swelling sine in a random direction."""
    value = (
        ("sine", {"amplitude": 2.0, "frequency": 0.3, "phase": 0.4, "offset": 0.0}),
        ("linear", {"slope": 0.5, "offset": rng.uniform(3, 4)}),
    )
    return [({"direction": rng.normal(size=3), "value": value}, 1, "")]


FORCE = Kind(
    name="force",
    section="loads",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0",),
    fields=(
        Field("node", NODE, "-", "node that it acts on"),
        Field("direction", DIRECTION, "-", "direction, inertial, made a unit vector"),
        VALUE,
    ),
    outputs=OUTPUTS,
    prepare=prepare,
    force=force,
    observe=observe,
    sample=sample,
)

FOLLOWER_FORCE = Kind(
    name="follower_force",
    section="loads",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0"),
    fields=(
        Field("node", NODE, "-", "node that it acts on and that carries its direction"),
        Field("direction", DIRECTION, "-", "direction at the start, inertial, made a unit vector"),
        VALUE,
    ),
    outputs=OUTPUTS,
    prepare=prepare_follower,
    force=follower_force,
    observe=follower_observe,
    sample=sample,
)

r"""Load along a line of nodes, such as those of a beam: a force per length, of a fixed direction or turning with them.

Each node carries the load of half of both neighbouring segments, whose lengths are those at the start:

.. math::  F_i = \tfrac12 (\ell_{i-1} + \ell_i)\, q(t)\, d

with the unit direction d, inertial, or fixed in each node if the load ``follows`` them, as pressure does. Displacements
converge with the square of the length of the elements.
"""

import numpy as np

from mecano.element_interface import Kind, Output, Part, record
from mecano.jit.kernel import kernel
from mecano.laws.table import curve, evaluate_curve
from mecano.maths.vector import add_vec, dot, mat, vec
from mecano.schema import BOOLEAN, DIRECTION, NODES, TIME_CURVE, Field

RECORD = record(load=3, law="i")  # load of a node per unit of the law
OF_LINE = record(length=(), law="i")


@kernel
def dead_residual(p, at, f):
    """Add the force of a fixed direction."""
    add_vec(f, 0, -curve(at.laws, p.law, at.t), vec(p.load, 0))


@kernel
def observe_dead(p, at, F, y, e):
    """Write its power."""
    e[3] = curve(at.laws, p.law, at.t) * dot(vec(p.load, 0), vec(at.v, 0))


@kernel
def following_residual(p, at, f):
    """Add the force that turns with the node."""
    add_vec(f, 0, -curve(at.laws, p.law, at.t), mat(at.R[0]) @ vec(p.load, 0))


@kernel
def observe_following(p, at, F, y, e):
    """Write its power."""
    e[3] = curve(at.laws, p.law, at.t) * dot(mat(at.R[0]) @ vec(p.load, 0), vec(at.v, 0))


@kernel
def observe(p, at, F, y, e):
    """Write load per length, and in all."""
    y[0] = evaluate_curve(at.laws, p.law, at.t)[0]
    y[1] = p.length * y[0]


def _share_samples(rng):
    return [({"load": rng.normal(size=3), "law": 0}, 1, "")]


DEAD = Kind(
    name="dead_share", section="", doc="Share of a node in a load along a line.", dtype=RECORD, layout=("x0",),
    residual=dead_residual, observe=observe_dead, sample=_share_samples,
)  # fmt: skip
FOLLOWING = Kind(
    name="following_share", section="", doc="Share of a node in a load that turns with it.", dtype=RECORD,
    layout=("x0", "R0"), residual=following_residual, observe=observe_following, sample=_share_samples,
)  # fmt: skip


def _lengths(nodes):
    return np.linalg.norm(np.diff([x for x, _ in nodes], axis=0), axis=1)


def prepare(d, nodes, context):
    """Return the record of the whole line."""
    return {"length": _lengths(nodes).sum(), "law": context.laws.add(d["value"])}


def parts(d, nodes, context):
    """Return the Parts: the share of each node."""
    half = 0.5 * _lengths(nodes)
    share = np.append(half, 0.0) + np.append(0.0, half)
    direction = np.asarray(d["direction"], float) / np.linalg.norm(d["direction"])
    kind, law = FOLLOWING if d["follows"] else DEAD, context.laws.add(d["value"])
    turned = [R.T @ direction if d["follows"] else direction for _, R in nodes]
    return [Part(kind, (i,), {"load": share[i] * turned[i], "law": law}) for i in range(len(nodes))]


def check(d, nodes):
    """Return errors for a line of less than two nodes, or with nodes at one place."""
    if len(nodes) < 2:
        return ["'line' must name at least 2 nodes"]
    return [] if _lengths(nodes).min() > 0.0 else ["consecutive nodes of 'line' must not coincide"]


def sample(rng):
    """Return a growing load on three nodes, dead and following."""
    law = (("linear", {"slope": 0.5, "offset": 3.0}),)
    nodes = [(rng.normal(size=3), np.linalg.qr(rng.normal(size=(3, 3)))[0]) for _ in range(3)]
    nodes = [(x, Q * np.linalg.det(Q)) for x, Q in nodes]
    values = {"line": ["a", "b", "c"], "direction": rng.normal(size=3), "value": law}
    return [(values, nodes, ""), ({**values, "follows": True}, nodes, "")]


LINE_LOAD = Kind(
    name="line_load",
    section="loads",
    doc=__doc__,
    dtype=OF_LINE,
    fields=(
        Field("line", NODES, "-", "nodes from one end to the other, including those created by 'mesh'"),
        Field("direction", DIRECTION, "-", "direction at the start, inertial, made a unit vector"),
        Field("value", TIME_CURVE, "N/m", "force per length: a number, or a function of time [s]"),
        Field("follows", BOOLEAN, "-", "whether the direction turns with each node", False),
    ),
    outputs=(
        Output("value", "N/m", "force per length"),
        Output("total", "N", "sum of the forces on all nodes, if they had one direction"),
    ),
    prepare=prepare,
    parts=parts,
    check=check,
    observe=observe,
    sample=sample,
)

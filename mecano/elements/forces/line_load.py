r"""Load along a line of nodes, such as those of a beam: a force per length, of a fixed direction or turning with them.

Each node carries the load of half of both neighbouring segments, whose lengths are those at the start:

.. math::  F_i = \tfrac12 (\ell_{i-1} + \ell_i)\, q\, d

with the force per length q, a function of time or a formula of signals, and the unit direction d, inertial, or fixed in
each node if the load ``follows`` them, as pressure does. Displacements converge with the square of the length of the
elements.
"""

from dataclasses import replace

import numpy as np

from mecano.constraints.along_coordinate.demand import is_formula, law_of, of_input, of_time, on_demand
from mecano.element_interface import Kind, Output, Part, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import add_vec, dot, mat, vec
from mecano.schema import BOOLEAN, DIRECTION, DRIVE, NODES, Field

RECORD = record(load=3, law="i")  # load of a node per unit of the law
OF_LINE = record(length=(), law="i")


def _dead(demand):
    """Return ``residual`` and ``observe`` of the share of a node in a load of fixed direction."""

    @kernel
    def residual(p, at, f):
        add_vec(f, 0, -demand(p, at), vec(p.load, 0))

    @kernel
    def observe(p, at, F, y, e):
        e[3] = demand(p, at) * dot(vec(p.load, 0), vec(at.v, 0))

    return residual, observe


def _following(demand):
    """Return ``residual`` and ``observe`` of the share of a node in a load that turns with it."""

    @kernel
    def residual(p, at, f):
        add_vec(f, 0, -demand(p, at), mat(at.R[0]) @ vec(p.load, 0))

    @kernel
    def observe(p, at, F, y, e):
        e[3] = demand(p, at) * dot(mat(at.R[0]) @ vec(p.load, 0), vec(at.v, 0))

    return residual, observe


def _share(name, doc, layout, functions):
    """Return the Kinds of the share of a node: of a load that is a law of time, and of one that is a signal."""

    def kind(demand):
        residual, observe = functions(demand)
        return Kind(
            name=name, doc=doc, dtype=RECORD, layout=layout, residual=residual, observe=observe,
            sample=lambda rng: [({"load": rng.normal(size=3), "law": 0}, 1, "")],
        )  # fmt: skip

    return kind(of_time), replace(kind(of_input(3 * len(layout))), inputs=("value",))


DEAD = _share("dead_share", "Share of a node in a load along a line.", ("x0",), _dead)
FOLLOWING = _share("following_share", "Share of a node in a load that turns with it.", ("x0", "R0"), _following)


def _lengths(nodes):
    return np.linalg.norm(np.diff([x for x, _ in nodes], axis=0), axis=1)


def prepare(d, nodes, context):
    """Return the record of the whole line."""
    return {"length": _lengths(nodes).sum(), "law": law_of(d["value"], context)}


def parts(d, nodes, context):
    """Return the Parts: the share of each node."""
    half = 0.5 * _lengths(nodes)
    share = np.append(half, 0.0) + np.append(0.0, half)
    direction = np.asarray(d["direction"], float) / np.linalg.norm(d["direction"])
    kinds, by_signal = FOLLOWING if d["follows"] else DEAD, is_formula(d["value"])
    kind, law, reads = kinds[by_signal], law_of(d["value"], context), (d["value"],) if by_signal else ()
    turned = [R.T @ direction if d["follows"] else direction for _, R in nodes]
    return [Part(kind, (i,), {"load": share[i] * turned[i], "law": law}, reads=reads) for i in range(len(nodes))]


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
    loads = values, {**values, "value": "command"}
    return [({**d, "follows": follows}, nodes, "") for d in loads for follows in (False, True)]


def _kind(demand):
    @kernel
    def observe(p, at, F, y, e):
        y[0] = demand(p, at)
        y[1] = p.length * y[0]

    return Kind(
        name="line_load",
        section="loads",
        doc=__doc__,
        dtype=OF_LINE,
        fields=(
            Field("line", NODES, "-", "nodes from one end to the other, including those created by 'mesh'"),
            Field("direction", DIRECTION, "-", "direction at the start, inertial, made a unit vector"),
            Field("value", DRIVE, "N/m", "force per length: a function of time [s], or a formula of signals"),
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


LINE_LOAD = on_demand(_kind, "value", 0)

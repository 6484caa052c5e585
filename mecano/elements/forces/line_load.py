r"""Loads along a line of nodes, such as those of a beam: a force or a moment per length.

Each node carries half of the load on both adjacent segments, whose lengths are those at the start:

.. math::  F_i = \tfrac12 (\ell_{i-1} + \ell_i)\, q\, d

with the force or moment per length q, a function of time or a formula of signals, and the unit direction d, inertial,
or fixed in each node if the load ``follows`` them. Displacements converge with the square of the length of the
elements; the twist and the rotation by a moment are exact.
"""

import numpy as np

from mecano.constraints.along_coordinate.demand import by_law_and_signal, is_formula, law_of, on_demand, reads_of
from mecano.constraints.line_of_nodes import LINE_FIELD, check_line, lengths, sample_line
from mecano.constraints.triads import unit
from mecano.element_interface import Kind, Output, Part, named, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import add_vec, dot, mat, vec
from mecano.schema import BOOLEAN, DIRECTION, DRIVE, Field

EQUATIONS = __doc__.partition("\n\n")[2]
RECORD = record(load=3, law="i")  # load of a node per unit of the law
OF_LINE = record(length=(), law="i")


@kernel
def _constant(p, at):
    """Return the components of a force of fixed direction, or of a moment in material axes that follows its node."""
    return vec(p.load, 0)


@kernel
def _turned(p, at):
    """Return the inertial components of a force that follows its node."""
    return mat(at.R[0]) @ vec(p.load, 0)


@kernel
def _turned_back(p, at):
    """Return the material components of a moment of fixed direction."""
    return mat(at.R[0]).T @ vec(p.load, 0)


def _share(name, layout, components):
    """Return the Kinds of the share of a node: of a load that is a law of time, and of one that is a signal.

    components(p, at) are those of the load per unit of the law, in the axes of the velocity of the first slot.
    """

    def functions(demand):
        """Return the functions of the kind whose value is ``demand(p, at)``."""

        @kernel
        def residual(p, at, f):
            add_vec(f, 0, -demand(p, at), components(p, at))

        @kernel
        def observe(p, at, F, y, e):
            e[3] = demand(p, at) * dot(components(p, at), vec(at.v, 0))

        return named(residual, observe)

    kind = Kind(name=name, doc="Share of a node in a load along a line.", dtype=RECORD, layout=layout)
    return by_law_and_signal(kind, functions, "value")


def _of_line(demand):
    """Return ``observe`` of a load along a line."""

    @kernel
    def observe(p, at, F, y, e):
        y[0], y[1] = demand(p, at), p.length * demand(p, at)

    return named(observe)


def sample(rng):
    """Return loads on three nodes, dead and following."""
    values, nodes = {"line": ["a", "b", "c"], "direction": rng.normal(size=3)}, sample_line(rng)
    return [({**values, "follows": follows}, nodes, "") for follows in (False, True)]


def _load(name, quantity, unit_of_load, dead, following):
    """Return the Kind of a load along a line, a ``quantity`` per length.

    ``dead`` and ``following`` are the Kinds of the share of a node: of a law of time, and of a signal.
    """

    def parts(d, nodes, context):
        half, direction = 0.5 * lengths(nodes), unit(d["direction"])
        share = np.append(half, 0.0) + np.append(0.0, half)
        kind = (following if d["follows"] else dead)[is_formula(d["value"])]
        law, reads = law_of(d["value"], context), reads_of(d["value"])
        turned = [R.T @ direction if d["follows"] else direction for _, R in nodes]
        return [Part(kind, (i,), {"load": share[i] * turned[i], "law": law}, reads=reads) for i in range(len(nodes))]

    per = f"{quantity} per length"
    kind = Kind(
        name=name, section="loads",
        doc=f"{quantity.capitalize()} per length along a line of nodes, such as those of a beam.\n\n{EQUATIONS}",
        dtype=OF_LINE,
        fields=(
            LINE_FIELD,
            Field("direction", DIRECTION, "-", "direction at the start, inertial, made a unit vector"),
            Field("value", DRIVE, f"{unit_of_load}/m", per),
            Field("follows", BOOLEAN, "-", "whether the direction turns with each node", False),
        ),
        outputs=(
            Output("value", f"{unit_of_load}/m", per),
            Output("total", unit_of_load, f"sum of the {quantity}s on all nodes, if they had one direction"),
        ),
        check=check_line,
        prepare=lambda d, nodes, context: {"length": lengths(nodes).sum(), "law": law_of(d["value"], context)},
        **named(parts, sample),
    )  # fmt: skip
    return on_demand(kind, _of_line, "value")


LINE_LOAD = _load(
    "line_load", "force", "N", _share("dead_share", ("x0",), _constant),
    _share("following_share", ("x0", "R0"), _turned),
)  # fmt: skip
LINE_MOMENT = _load(
    "line_moment", "moment", "N m", _share("dead_moment_share", ("R0",), _turned_back),
    _share("following_moment_share", ("R0",), _constant),
)  # fmt: skip

r"""Pressure on one side of a line of nodes, such as those of a beam or of an arch; it follows the deformation.

On a segment from :math:`x_i` to :math:`x_{i+1}`, with the unit vector b across it, fixed in its nodes, the width w and
the pressure p, a function of time or a formula of signals, each of both nodes carries

.. math::  F = \tfrac12\, p\, w\; b \times (x_{i+1} - x_i)

with its own b. The force is normal to the segment, and grows with its length. Seen against b, a positive pressure
pushes the line to its left: a ring that runs counterclockwise is pressed from outside. Where b does not turn, a
pressure that is constant on a closed line, or between fixed ends, has the potential p w A with the area A inside.
Displacements converge with the square of the length of the elements.
"""

import numpy as np

from mecano.constraints.along_coordinate.demand import by_law_and_signal, is_formula, law_of, on_demand, reads_of
from mecano.constraints.line_of_nodes import LINE_FIELD, check_line, sample_line
from mecano.constraints.triads import unit
from mecano.element_interface import Kind, Output, Part, named, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import add_vec, cross, dot, mat, vec
from mecano.schema import DIRECTION, DRIVE, NUMBER, Field, positive

RECORD = record(across_0=3, across_1=3, half_width=(), law="i")
OF_LINE = record(width=(), law="i")
LEAST_SINE = 0.1  # of the angle between a segment and 'across'


@kernel
def _forces(p, at, pressure):
    """Return the forces [N] on both nodes of a segment."""
    along = (p.half_width * pressure) * (vec(at.q, 6) - vec(at.q, 0))
    return cross(mat(at.R[0]) @ vec(p.across_0, 0), along), cross(mat(at.R[1]) @ vec(p.across_1, 0), along)


def _of_segment(demand):
    """Return ``residual`` and ``observe`` of the pressure on a segment."""

    @kernel
    def residual(p, at, f):
        first, second = _forces(p, at, demand(p, at))
        add_vec(f, 0, -1.0, first)
        add_vec(f, 6, -1.0, second)

    @kernel
    def observe(p, at, F, y, e):
        first, second = _forces(p, at, demand(p, at))
        e[3] = dot(first, vec(at.v, 0)) + dot(second, vec(at.v, 6))

    return named(residual, observe)


def _of_line(demand):
    """Return ``observe`` of the pressure on a line."""

    @kernel
    def observe(p, at, F, y, e):
        y[0] = demand(p, at)
        y[1] = p.width * y[0]

    return named(observe)


SEGMENTS = by_law_and_signal(
    Kind(name="pressed_segment", doc="Pressure on one side of a segment between two nodes.", dtype=RECORD,
         layout=("x0", "R0", "x1", "R1")),
    _of_segment, "value",
)  # fmt: skip


def _across(d, nodes):
    """Return 'across' at the start, inertial, made normal to each of the n - 1 segments; not of unit length."""
    along = np.diff([x for x, _ in nodes], axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    across = unit(d["across"])
    return across - (along @ across)[:, None] * along


def parts(d, nodes, context):
    """Return the Parts: the pressed segments."""
    kind, reads = SEGMENTS[is_formula(d["value"])], reads_of(d["value"])
    shared = {"half_width": 0.5 * d["width"], "law": law_of(d["value"], context)}
    found = []
    for i, b in enumerate(_across(d, nodes)):
        in_nodes = [nodes[j][1].T @ b / np.linalg.norm(b) for j in (i, i + 1)]
        values = {"across_0": in_nodes[0], "across_1": in_nodes[1], **shared}
        found.append(Part(kind, (i, i + 1), values, reads=reads))
    return found


def check(d, nodes):
    """Return errors in the line, and for a segment that runs along 'across'."""
    if texts := check_line(d, nodes):
        return texts
    sines = np.linalg.norm(_across(d, nodes), axis=1)
    i = int(np.argmin(sines))
    names = f"'{d['line'][i]}' and '{d['line'][i + 1]}'"
    return [] if sines[i] > LEAST_SINE else [f"'across' runs along the line between nodes {names}; it must cross it"]


def sample(rng):
    """Return a pressure on three nodes."""
    return [({"line": ["a", "b", "c"], "across": rng.normal(size=3), "width": 0.8}, sample_line(rng), "")]


PRESSURE = on_demand(
    Kind(
        name="pressure", section="loads", doc=__doc__, dtype=OF_LINE,
        fields=(
            LINE_FIELD,
            Field("across", DIRECTION, "-", "across the line, along the width of the side, at the start, inertial"),
            Field("width", NUMBER, "m", "width of the side", check=positive),
            Field("value", DRIVE, "Pa", "pressure"),
        ),
        outputs=(
            Output("value", "Pa", "pressure"),
            Output("line_load", "N/m", "force per length, pressure times width"),
        ),
        prepare=lambda d, nodes, context: {"width": d["width"], "law": law_of(d["value"], context)},
        **named(parts, check, sample),
    ),
    _of_line, "value",
)  # fmt: skip

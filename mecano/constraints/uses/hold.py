r"""Hold a coordinate c: at a constant, :math:`c - c_0 = 0`, or where a law of time drives it, :math:`c - f(t) = 0`.

The multiplier is the force, or the moment, along the coordinate. The difference of an angle to what is wanted is
brought to :math:`(-\pi, \pi]`, so that any number of turns needs no memory.
"""

from dataclasses import replace

import numpy as np

from mecano.compiled.kernel import kernel
from mecano.constraints.augmented import add_constraint, let_go, put_levels
from mecano.constraints.carried import wrap
from mecano.contract import Kind, Row, record
from mecano.laws.table import evaluate_curve

HELD = 0
RELEASE_MODES = ("held", "free")
TARGET = {"law": "i", "offset": ()}
"""Of a record; the law first, as numba takes a record that begins as another one, of a hold, for the same."""


@kernel
def target(p, laws, t):
    """Return value, rate and second rate of offset + law(t) of a record with the fields ``TARGET``; law 0 is zero."""
    y, y1, y2 = evaluate_curve(laws, p.law, t)
    return p.offset + y, y1, y2


@kernel
def _minus(c, wanted):
    return c - wanted


@kernel
def _turn_between(c, wanted):
    return wrap(c - wanted)


def holding(coordinate):
    """Return compiled functions that hold a coordinate: (hold, levels_of).

    ``hold(p, at, sign, wanted, f, K)`` adds the constraint sign (c - wanted) = 0, ``levels_of(p, at, sign, wanted, g)``
    writes its levels; ``wanted`` is there a value with both rates.
    """
    value, gradient, add_curvature = coordinate.value, coordinate.gradient, coordinate.add_curvature
    rates, row = coordinate.rates, coordinate.row
    difference = _turn_between if coordinate.periodic else _minus

    @kernel
    def hold(p, at, sign, wanted, f, K):
        Phi, multiplier = difference(value(p, at), wanted), sign * at.q[row]
        g = add_constraint(f, K, row, sign * at.k, at.penalty, Phi, multiplier, gradient(p, at))
        add_curvature(p, at, g, K)

    @kernel
    def levels_of(p, at, sign, wanted, g):
        rate, second = rates(p, at)
        Phi = sign * difference(value(p, at), wanted[0])
        put_levels(g, 0, Phi, sign * (rate - wanted[1]), sign * (second - wanted[2]))

    return hold, levels_of


def hold_kind(name, doc, coordinate, row):
    """Return the Kind that holds a coordinate at the ``offset`` of its record; ``row`` says what the multiplier is."""
    hold, levels_of = holding(coordinate)

    @kernel
    def force(p, at, f, K, C, M):
        hold(p, at, 1.0, p.offset, f, K)

    @kernel
    def levels(p, at, g):
        levels_of(p, at, 1.0, (p.offset, 0.0, 0.0), g)

    return _kind(name, doc, coordinate, row, {**coordinate.axes, "offset": ()}, force, levels)


def release_kind(name, doc, coordinate, row):
    """Return the Kind that holds a coordinate at its ``offset`` in the phase "held", and not in the phase "free"."""
    hold, levels_of = holding(coordinate)
    multiplier = coordinate.row

    @kernel
    def force(p, at, f, K, C, M):
        if at.phase == HELD:
            hold(p, at, 1.0, p.offset, f, K)
        else:
            let_go(f, K, multiplier, at.k, at.q[multiplier])

    @kernel
    def levels(p, at, g):
        g[:] = 0.0
        if at.phase == HELD:
            levels_of(p, at, 1.0, (p.offset, 0.0, 0.0), g)

    kind = _kind(name, doc, coordinate, row, {**coordinate.axes, "offset": ()}, force, levels)
    ((values, nodes, _),) = kind.sample(np.random.default_rng(0))
    return replace(kind, modes=RELEASE_MODES, sample=lambda rng: [(values, nodes, phase) for phase in RELEASE_MODES])


def drive_kind(name, doc, coordinate, row):
    """Return the Kind that holds a coordinate at ``target``."""
    hold, levels_of = holding(coordinate)

    @kernel
    def force(p, at, f, K, C, M):
        hold(p, at, 1.0, target(p, at.laws, at.t)[0], f, K)

    @kernel
    def levels(p, at, g):
        levels_of(p, at, 1.0, target(p, at.laws, at.t), g)

    return _kind(name, doc, coordinate, row, {**coordinate.axes, **TARGET}, force, levels)


def _kind(name, doc, coordinate, row, fields, force, levels):
    nodes = len({slot[1] for slot in coordinate.layout})
    return Kind(
        name=name, section="", doc=doc, dtype=record(**fields), layout=coordinate.layout,
        multipliers=(Row(row, coordinate.load[1], coordinate.unit),), force=force, levels=levels,
        sample=lambda rng: [({**coordinate.sample(rng), "offset": rng.uniform(0.5, 2.0)}, nodes, "")],
    )  # fmt: skip

r"""Hold a coordinate c: at a constant, :math:`c - c_0 = 0`, or at a law of time that drives it, :math:`c - f(t) = 0`.

The multiplier is the force, or the moment, along the coordinate. The difference between an angle and its target is
reduced to :math:`(-\pi, \pi]`, so that any number of turns needs no memory.
"""

from dataclasses import replace

import numpy as np

from mecano.constraints.augmented_lagrangian import add_constraint, deactivate, put_derivatives
from mecano.constraints.body_fixed import wrap
from mecano.element_interface import Kind, Row, record
from mecano.jit.kernel import kernel
from mecano.laws.table import evaluate_curve

HELD = 0
RELEASE_PHASES = ("held", "free")
TARGET = {"law": "i", "offset": ()}
"""Fields of a record; law first, as numba does not distinguish a record from one with the same leading fields."""


@kernel
def target(p, laws, t):
    """Return value, rate and second rate of offset + law(t) for a record with the fields ``TARGET``; law 0 is zero."""
    y, y1, y2 = evaluate_curve(laws, p.law, t)
    return p.offset + y, y1, y2


@kernel
def _minus(c, wanted):
    return c - wanted


@kernel
def _turn_between(c, wanted):
    return wrap(c - wanted)


def holding(coordinate):
    """Return compiled functions that hold a coordinate: (hold, derivatives_of).

    ``hold(p, at, sign, wanted, f, K)`` adds the constraint sign (c - wanted) = 0; ``derivatives_of(p, at, sign, wanted,
    g)`` writes its derivatives, with ``wanted`` a value and its two rates.
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
    def derivatives_of(p, at, sign, wanted, g):
        rate, second = rates(p, at)
        Phi = sign * difference(value(p, at), wanted[0])
        put_derivatives(g, 0, Phi, sign * (rate - wanted[1]), sign * (second - wanted[2]))

    return hold, derivatives_of


def hold_kind(name, doc, coordinate, row):
    """Return the Kind that holds a coordinate at the ``offset`` of its record; ``row`` names the multiplier."""
    hold, derivatives_of = holding(coordinate)

    @kernel
    def force(p, at, f, K, C, M):
        hold(p, at, 1.0, p.offset, f, K)

    @kernel
    def constraint_derivatives(p, at, g):
        derivatives_of(p, at, 1.0, (p.offset, 0.0, 0.0), g)

    return _kind(name, doc, coordinate, row, {**coordinate.axes, "offset": ()}, force, constraint_derivatives)


def release_kind(name, doc, coordinate, row):
    """Return the Kind that holds a coordinate at its ``offset`` in the phase "held", and not in the phase "free"."""
    hold, derivatives_of = holding(coordinate)
    multiplier = coordinate.row

    @kernel
    def force(p, at, f, K, C, M):
        if at.phase == HELD:
            hold(p, at, 1.0, p.offset, f, K)
        else:
            deactivate(f, K, multiplier, at.k, at.q[multiplier])

    @kernel
    def constraint_derivatives(p, at, g):
        g[:] = 0.0
        if at.phase == HELD:
            derivatives_of(p, at, 1.0, (p.offset, 0.0, 0.0), g)

    kind = _kind(name, doc, coordinate, row, {**coordinate.axes, "offset": ()}, force, constraint_derivatives)
    ((values, nodes, _),) = kind.sample(np.random.default_rng(0))
    return replace(kind, phases=RELEASE_PHASES, sample=lambda rng: [(values, nodes, phase) for phase in RELEASE_PHASES])


def drive_kind(name, doc, coordinate, row):
    """Return the Kind that holds a coordinate at ``target``; ``row`` names the multiplier."""
    hold, derivatives_of = holding(coordinate)

    @kernel
    def force(p, at, f, K, C, M):
        hold(p, at, 1.0, target(p, at.laws, at.t)[0], f, K)

    @kernel
    def constraint_derivatives(p, at, g):
        derivatives_of(p, at, 1.0, target(p, at.laws, at.t), g)

    return _kind(name, doc, coordinate, row, {**coordinate.axes, **TARGET}, force, constraint_derivatives)


def _kind(name, doc, coordinate, row, fields, force, constraint_derivatives):
    nodes = len({slot[1] for slot in coordinate.layout})
    return Kind(
        name=name, section="", doc=doc, dtype=record(**fields), layout=coordinate.layout,
        multipliers=(Row(row, coordinate.load[1], coordinate.unit),), force=force,
        constraint_derivatives=constraint_derivatives,
        sample=lambda rng: [({**coordinate.sample(rng), "offset": rng.uniform(0.5, 2.0)}, nodes, "")],
    )  # fmt: skip

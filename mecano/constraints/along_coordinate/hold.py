r"""Hold a coordinate c: at a constant, :math:`c - c_0 = 0`, or at a motion that drives it, :math:`c - f(t) = 0`.

The motion is a law of time, or a formula of the time, whose two rates are formulas, too; or the integral from the time
0 of a law of its rate. A rate u that is a signal is a constraint on velocities, :math:`\dot c - u = 0`.

The multiplier is the force, or the moment, along the coordinate. The difference between an angle and its target is
reduced to :math:`(-\pi, \pi]`, so that any number of turns needs no memory.

The tangents are written by hand, here and in the coordinates: with dual numbers a step of the deck bricard takes 4 %
more processor time, of andrews 10 %.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from mecano.constraints.along_coordinate.demand import is_formula
from mecano.constraints.augmented_lagrangian import add_constraint, add_reaction
from mecano.constraints.body_fixed import wrap
from mecano.constraints.coordinates.coordinate import rate_of
from mecano.element_interface import UNUSED, Kind, Row, named, record
from mecano.jit.kernel import kernel
from mecano.laws.formula import evaluate_formula
from mecano.laws.formula_rate import with_rates
from mecano.laws.law_table import evaluate_curve, potential
from mecano.maths.dual import chain, number, value


class Motion(NamedTuple):
    """The motion of a driven coordinate: fields of its record, and a compiled function."""

    fields: dict
    at: Callable  # (p, at) -> value with the offset, rate; Duals if the time is one


@kernel
def _of_law(p, at):
    y, y1, y2 = evaluate_curve(at.laws, p.law, value(at.t))
    return p.offset + chain(at.t, y, y1), chain(at.t, y1, y2)


@kernel
def _of_formula(p, at):
    y, y1 = _evaluated(p.motion, at), _evaluated(p.rate, at)
    return p.offset + chain(at.t, y, y1), chain(at.t, y1, _evaluated(p.second_rate, at))


@kernel
def _of_rate(p, at):
    t, (y, y1, _) = value(at.t), evaluate_curve(at.laws, p.law, value(at.t))
    integral = potential(at.laws, p.law, t) - potential(at.laws, p.law, 0.0)
    return p.offset + chain(at.t, integral, y), chain(at.t, y, y1)


@kernel
def _evaluated(start, at):
    return value(evaluate_formula(at.laws, start, value(at.t), at.q, 0))


BY_LAW = Motion({"law": "i", "offset": ()}, _of_law)
"""The law is the first field because numba does not distinguish a record from one with the same leading fields.
Law 0 is zero."""
BY_FORMULA = Motion({"motion": "i", "rate": "i", "second_rate": "i", "offset": ()}, _of_formula)
BY_RATE = Motion(BY_LAW.fields, _of_rate)


def motion_values(given, offset, context):
    """Return the values of the fields of a Motion from a checked law, or a formula of the time (text)."""
    if not is_formula(given):
        return {"law": context.laws.add(given), "offset": offset}
    starts = [context.laws.append(formula.numbers) for formula in with_rates(given)]
    return {**dict(zip(("motion", "rate", "second_rate"), starts, strict=True)), "offset": offset}


@kernel
def _minus(c, wanted):
    return c - wanted


@kernel
def _turn_between(c, wanted):
    """Return the difference of two angles, in (-pi, pi]; ``wanted`` is reduced first, to keep all digits of c."""
    return wrap(c - wrap(wanted))


def holding(coordinate, target):
    """Return ``force`` and ``constraints`` that hold a coordinate c: side (c - wanted) = 0.

    ``target(p, at)`` returns the side, 1 or -1, or 0 where the constraint is inactive; the wanted value, and its rate.
    """
    value, gradient, add_curvature = coordinate.value, coordinate.gradient, coordinate.add_curvature
    row, difference = coordinate.row, _turn_between if coordinate.periodic else _minus

    @kernel
    def force(p, at, f, K, C, M):
        side, wanted, _ = target(p, at)
        if side != 0.0:
            Phi = difference(value(p, at), wanted)
            add_curvature(p, at, add_constraint(f, K, at, row, Phi, gradient(p, at), side), K)
        else:
            f[row] -= at.q[row]
            K[row, row] -= at.k

    @kernel
    def constraints(p, at, g):
        side, wanted, wanted_rate = target(p, at)
        if side != 0.0:
            g[0, 0] = side * difference(value(p, at), wanted)
            g[0, 1] = side * (rate_of(gradient(p, at), at.v) - wanted_rate)

    return named(force, constraints)


@kernel
def _at_offset(p, at):
    return 1.0, p.offset, 0.0


def hold_kind(name, doc, coordinate, row):
    """Return the Kind that holds a coordinate at the ``offset`` of its record; ``row`` names the multiplier."""
    return _kind(name, doc, coordinate, row, {"offset": ()}, holding(coordinate, _at_offset))


def drive_kind(name, doc, coordinate, row, motion=BY_LAW):
    """Return the Kind that holds a coordinate at a ``motion``; ``row`` names the multiplier."""
    moving = motion.at

    @kernel
    def target(p, at):
        wanted, rate = moving(p, at)
        return 1.0, wanted, rate

    return _kind(name, doc, coordinate, row, motion.fields, holding(coordinate, target))


def rate_kind(name, doc, coordinate, row):
    """Return the Kind that holds a coordinate at the integral of a law of its rate, whose power is given."""
    moving, multiplier = BY_RATE.at, coordinate.row

    @kernel
    def observe(p, at, F, y, e):
        e[3] = at.q[multiplier] * moving(p, at)[1]

    return replace(drive_kind(name, doc, coordinate, row, BY_RATE), **named(observe))


def signal_rate_kind(name, doc, coordinate, row):
    """Return the Kind that holds the rate of a coordinate at its input, a signal; its power is given, too."""
    gradient, signal = coordinate.gradient, coordinate.row
    multiplier = signal + 1

    @kernel
    def excess(p, at):
        along = gradient(p, at)
        return rate_of(along, at.v) - number(at.q[signal]), along

    @kernel
    def residual(p, at, f):
        Phi, along = excess(p, at)
        add_reaction(f, at, multiplier, Phi, along)

    @kernel
    def constraints(p, at, g):
        g[0, 1] = excess(p, at)[0]

    @kernel
    def observe(p, at, F, y, e):
        e[3] = at.q[multiplier] * at.q[signal]

    kind = _kind(name, doc, coordinate, row, {}, named(residual, constraints, observe), "/s")
    return replace(kind, inputs=("rate",))


def _kind(name, doc, coordinate, row, fields, functions, per=""):
    return Kind(
        name=name, doc=doc, dtype=record(**{**coordinate.axes, **fields} or {UNUSED: ()}), layout=coordinate.layout,
        multipliers=(Row(row, coordinate.load[1], f"{coordinate.unit}{per}"),), **functions,
    )  # fmt: skip

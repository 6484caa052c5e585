r"""Nonlinear coupler: the coordinate of a joint is a function of that of another: non-circular gears, indexing drives.

With the coordinate :math:`c_1`, the ``angle`` or the ``displacement`` of a joint, the coordinate :math:`c_2` of another
joint (``of_angle`` or ``of_displacement``), the function f and its argument s at the ``start``,

.. math::  c_1 = f(s + c_2) - f(s), \qquad \Phi = c_1 - f(s + c_2) + f(s)

The multiplier :math:`\lambda` is the load along :math:`c_1`, a moment or a force; the load along :math:`c_2` is
:math:`-f'\lambda`. Each acts between the two nodes of its joint, and together they do no work. It has no inertia, play
or friction of its own.

The ``function`` f is a law, or a ``formula`` of s, whose slopes are formulas, too. Coordinates are zero at the start,
angles count any number of turns. With a ``period`` P the function is given from 0 to P and continued,
f(x + P) = f(x) + f(P) - f(0), as that of gears, whose rotations follow from one turn, or of a cam. The function must
not jump or have corners, at which :math:`c_1` would need a shock; where its second derivative jumps, accelerations and
loads do. In a table, write ``interpolation: spline``, and for a period points somewhat beyond it on both sides, so that
the ends of the spline do not matter.
"""

import math
from dataclasses import replace
from functools import cache

from mecano.constraints.coordinates.slide import SLIDE
from mecano.constraints.coordinates.twist import TWIST
from mecano.constraints.joint_coordinates import add_load, axes_of, declarations, rate_along, row_of, value_of
from mecano.constraints.joint_samples import two_places
from mecano.element_interface import Display, Kind, Output, named
from mecano.jit.kernel import kernel
from mecano.laws.formula import evaluate_formula
from mecano.laws.formula_rate import with_slopes
from mecano.laws.law_table import curve_and_slope
from mecano.laws.probe import corners, curve_at
from mecano.laws.term import ARGUMENT, VALUE
from mecano.maths.dual import chain, number, value
from mecano.schema import CURVE, FUNCTION, NUMBER, Field, joint_with, positive

DRIVEN, DRIVING = ("angle", "displacement"), ("of_angle", "of_displacement")
BY_FORMULA = ("function", "slope", "bend")  # fields of the record: where a formula and its slopes stand
MATCH = 1e-4  # relative difference of the slopes of a function at both ends of a period, by rounded points


@kernel
def _of_law(p, laws, s):
    """Return f and its slope at s, without periods; Duals if s is one."""
    return curve_and_slope(laws, p.function, s)


@kernel
def _of_formula(p, laws, s):
    """Return the same of a formula."""
    x, slope = value(s), _evaluated(laws, p.slope, value(s))
    return chain(s, _evaluated(laws, p.function, x), slope), chain(s, slope, _evaluated(laws, p.bend, x))


@kernel
def _evaluated(laws, start, x):
    return evaluate_formula(laws, start, x, laws, 0)


def _functions(first, second, function):
    """Return the compiled functions of a Kind whose coordinates c_1 and c_2 have these numbers."""

    @kernel
    def relation(p, at):
        """Return the value of the constraint and the slope of the function."""
        s = value_of(p, at, second) + p.shift
        turns = math.floor(value(s) / p.period) if p.period > 0.0 else 0.0
        y, slope = function(p, at.laws, s - turns * p.period)
        return value_of(p, at, first) - (y + turns * p.rise) - p.offset, slope

    @kernel
    def residual(p, at, f):
        row, (Phi, slope) = row_of(p), relation(p, at)
        f[row] -= at.k * Phi
        load = -number(at.q[row]) + at.penalty * Phi
        add_load(p, at, f, first, load)
        add_load(p, at, f, second, -slope * load)

    @kernel
    def constraints(p, at, g):
        Phi, slope = relation(p, at)
        g[0, 0], g[0, 1] = Phi, rate_along(p, at, first) - slope * rate_along(p, at, second)

    @kernel
    def observe(p, at, F, y, e):
        load, (_, slope) = at.q[row_of(p)], relation(p, at)
        y[0], y[1] = load, -slope * load

    return named(residual, constraints, observe)


def _driven(d):
    """Return which of two coordinates are displacements."""
    return tuple(d[names[0]] is None for names in (DRIVEN, DRIVING))


def prepare(d, nodes, context):
    """Return the axes of both coordinates, and the function."""
    slides, found = _driven(d), []
    for i, names in enumerate((DRIVEN, DRIVING)):
        joint, output = d[names[slides[i]]], DRIVEN[slides[i]]
        found.append(context.kinds[joint["type"]].measures[output](joint, nodes[2 * i : 2 * i + 2], context))
    axes = [[one for one, slides_ in zip(found, slides, strict=True) if slides_ is wanted] for wanted in (False, True)]
    period, start = d["period"] or 0.0, d["start"]
    rise = _at(d, period)[0] - _at(d, 0.0)[0] if period else 0.0
    turns = math.floor(start / period) if period else 0.0
    return {
        **axes_of(*axes), **_packed(d, context), "period": period, "rise": rise, "shift": start - found[1].zero,
        "offset": found[0].zero - (_at(d, start - turns * period)[0] + turns * rise),
    }  # fmt: skip


def _packed(d, context):
    """Return where the function stands in the table of laws, and the slopes of a formula."""
    if d["formula"] is None:
        return {"function": context.laws.add(d["function"])}
    starts = [context.laws.append(formula.numbers) for formula in with_slopes(d["formula"])]
    return dict(zip(BY_FORMULA, starts, strict=True))


def _at(d, s):
    """Return the function and its slope at s, without periods."""
    if d["formula"] is None:
        return curve_at(d["function"], s)[:2]
    return tuple(evaluate_formula(one.numbers, 0, s, [0.0], 0) for one in with_slopes(d["formula"])[:2])


def check(d, nodes):
    """Check that there are two coordinates, of different joints, and a function without corners."""
    texts = [
        f"give one of {names[0]!r} and {names[1]!r}"
        for names in (DRIVEN, DRIVING)
        if (d[names[0]] is None) == (d[names[1]] is None)
    ]
    if (d["function"] is None) == (d["formula"] is None):
        texts.append("give one of 'function' and 'formula'")
    if texts:
        return texts
    (first, second) = (d[names[slide]] for names, slide in zip((DRIVEN, DRIVING), _driven(d), strict=True))
    return [*(["both coordinates are those of one joint"] * (first is second)), *_check_function(d)]


def _check_function(d):
    """Return errors for corners of the function, also between its periods."""
    period, name = d["period"], "function" if d["formula"] is None else "formula"
    found = [s for s in corners(d["function"]) if period is None or 0.0 < s < period]
    if found:
        how = "a table needs 'interpolation: spline', and 'beyond: extend' or points farther out"
        return [f"'function' has a jump or a corner at {found[0]:g}, where the joint would need a shock; {how}"]
    if period is None:
        return []
    low, high = (_at(d, s)[1] for s in (0.0, math.nextafter(period, 0.0)))
    if abs(high - low) <= MATCH * (1.0 + abs(low)):
        return []
    return [f"{name!r} has another slope at 0 ({low:.6g}) than at the 'period' {period:g} ({high:.6g})"]


def sample(rng):
    """Return couplers of angles and displacements, of functions with and without a period."""
    joint, samples = {"type": "cylindrical", "axis_1": None}, []
    parabola = (("polynomial", {"coefficients": [0.3, 0.8, 0.4]}),)
    sine = {"amplitude": 0.3, "frequency": 0.5, "phase": 0.4, "offset": 0.0}
    wave = (("linear", {"slope": 0.7, "offset": 0.2}), ("sine", sine))
    for slides in ((False, False), (False, True), (True, False), (True, True)):
        joints = [{**joint, "axis": rng.normal(size=3)} for _ in slides]
        given = {names[slide]: one for names, slide, one in zip((DRIVEN, DRIVING), slides, joints, strict=True)}
        places = [place for _ in slides for place in two_places(rng)]
        samples += [
            ({**given, "function": parabola, "start": 0.3}, places, ""),
            ({**given, "function": wave, "period": 2.0, "start": 0.4}, places, ""),
            ({**given, "formula": "s + sin(pi*s)/4", "period": 2.0, "start": 0.4}, places, ""),
        ]
    return samples


@cache
def _with_coordinates(slides, by_formula=False):
    """Return the Kind of two coordinates, which are displacements or not."""
    nodes = [[2 * i for i in (0, 1) if slides[i] is wanted] for wanted in (False, True)]
    numbers = [sum(nodes, []).index(2 * i) for i in (0, 1)]
    of = [SLIDE if slide else TWIST for slide in slides]
    function, starts = (_of_formula, BY_FORMULA) if by_formula else (_of_law, ("function",))
    own = {**dict.fromkeys(starts, "i"), "period": (), "rise": (), "shift": (), "offset": ()}
    loads = tuple(
        Output(f"load_{i}", c.load[1], f"{c.load[0]} along c_{i}, > 0 increases it") for i, c in enumerate(of, 1)
    )
    given = {**_functions(*numbers, function), **declarations(*nodes, of[0], **own)}
    return Kind(**{**DECLARED, "outputs": loads, **given})


DECLARED = {
    "name": "nonlinear_coupler",
    "section": "joints",
    "doc": __doc__,
    "display": Display("nothing"),
    "fields": (
        Field("angle", joint_with("angle"), "-", "joint whose angle is c_1", None),
        Field("displacement", joint_with("displacement"), "-", "joint whose displacement is c_1", None),
        Field("of_angle", joint_with("angle"), "-", "joint whose angle is c_2", None),
        Field("of_displacement", joint_with("displacement"), "-", "joint whose displacement is c_2", None),
        Field("function", CURVE, VALUE, "f, both c_1 and c_2 in SI units: rad, m", None),
        Field("formula", FUNCTION, VALUE, "f as a formula of s, instead, such as 's + 0.2*sin(s)'", None),
        Field("start", NUMBER, ARGUMENT, "argument of the function at the start", 0.0),
        Field("period", NUMBER, ARGUMENT, "period P of the function, such as 1 rev of gears; none when absent", None,
              positive),
    ),
    **named(prepare, check, sample),
}  # fmt: skip


NONLINEAR_COUPLER = replace(
    _with_coordinates((False, False)), variant=lambda d: _with_coordinates(_driven(d), d["formula"] is not None)
)

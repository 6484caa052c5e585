r"""Coupler: a linear relation between coordinates of joints: a differential, gears, a synchronisation cable, a linkage.

With the coordinates :math:`c_i` of two or more joints, the output ``angle`` of each of the ``angles``, any number of
turns, and then the output ``displacement`` of each of the ``displacements``, and with the ``factors`` :math:`h_i` in
the same order and the ``constant`` c,

.. math::  \sum h_i c_i = c, \qquad \Phi = \sum \frac{h_i}{h_1}\, c_i - \frac{c}{h_1}

The multiplier is the load along :math:`c_1`, a moment or a force; the load along :math:`c_i` is :math:`h_i/h_1` times
it. Each load acts between the two nodes of its joint, and together they do no work. A coupler has no inertia or play of
its own.

With ``friction`` the coupler has an efficiency: with the multiplier :math:`\lambda` and the mean rate
:math:`\dot w = \tfrac12 (\dot c_1 - \sum_{i \ge 2} h_i/h_1\, \dot c_i)`, which is that of :math:`c_1`,

.. math::  F_r = \mu\,|\lambda|\,\phi(|\dot w|)\,\mathrm{sign}\,\dot w, \qquad \mu = 2\,\frac{1 - \eta}{1 + \eta}

acts against :math:`\dot w`, with :math:`\phi(u) = (u/\epsilon)(2 - u/\epsilon)` below the rate :math:`\epsilon` of
the ``regularization``, 1 beyond: the load along :math:`c_1` is :math:`\lambda - F_r/2`, along the others
:math:`h_i/h_1\,(\lambda + F_r/2)`. If coordinate 1 drives (:math:`\lambda\dot w < 0`), all the others together
receive :math:`\eta` times its power; if they drive, it receives the ``backdriving_efficiency`` times theirs.

With a ``ratio`` r, a law of time or a signal, two coordinates are coupled by their rates, as by a continuously variable
transmission:

.. math::  \dot c_1 - r\,\dot c_2 = 0

The load along :math:`c_2` is :math:`-r` times the multiplier: whatever the ratio does, both loads together do no work.

Angles and displacements are zero at the start. A cable by which a second hinge turns twice as far as the first one, in
the opposite direction, has ``angles: [first, second]`` and ``factors: [2, 1]``.
"""

from dataclasses import replace
from functools import cache

import numpy as np

from mecano.constraints.along_coordinate.demand import LAW, is_formula, law_of, of_input, of_law
from mecano.constraints.body_fixed import whole_turns
from mecano.constraints.coordinates.slide import SLIDE
from mecano.constraints.coordinates.twist import TWIST
from mecano.constraints.joint_coordinates import (
    add_load,
    angle_in_turn,
    axes_of,
    declarations,
    displacement,
    rate_along,
    row_of,
    sliding,
    turning,
)
from mecano.constraints.joint_samples import two_places
from mecano.constraints.tooth_friction import friction_field, friction_values, tooth_friction
from mecano.element_interface import Display, Kind, Output, Part, Row, named, with_fields
from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.schema import CONTINUOUS_DRIVE, NUMBER, Field, joint_with, list_of, not_zero, positive

COORDINATES = {"angles": ("angle", TWIST), "displacements": ("displacement", SLIDE)}
DISSIPATED = Output("dissipated_power", "W", "power dissipated, with friction")


@kernel
def _ratio(p, i):
    """Return the derivative of the constraint by coordinate i."""
    return p.ratios[i]


@kernel
def _share(p, i):
    """Return the derivative of the mean rate by the rate of coordinate i."""
    return 0.5 if i == 0 else -0.5 * p.ratios[i]


def _sum_with(factor):
    """Return the rate of the sum of all coordinates times factor(p, i), and the function that adds a load along it."""

    @kernel
    def rate(p, at):
        """Return the rate of the sum, a number of the type of q."""
        total = 0.0 * number(at.q[row_of(p)])
        for i in range(len(p.ratios)):
            total = total + factor(p, i) * rate_along(p, at, i)
        return total

    @kernel
    def add(p, at, f, load):
        for i in range(len(p.ratios)):
            add_load(p, at, f, i, factor(p, i) * load)

    return rate, add


_rate, _add_load = _sum_with(_ratio)
_mean_rate, _add_friction = _sum_with(_share)


@kernel
def _relation(p, at):
    """Return the value of the constraint; whole turns are added first (body_fixed.py)."""
    turns = len(p.mu)
    whole, total = 0.0, 0.0 * number(at.q[row_of(p)])
    for i in range(turns):
        axes, place = turning(p, at, i)
        in_turn = angle_in_turn(axes, place)
        whole += p.ratios[i] * whole_turns(place.m[0], in_turn)
        total = total + p.ratios[i] * in_turn
    total = total + (whole - p.offset)
    for i in range(len(p.along)):
        axes, place = sliding(p, at, i)
        total = total + p.ratios[turns + i] * displacement(axes, place)
    return total


@kernel
def residual(p, at, f):
    """Add the constraint and its forces; their sum over the coordinates is in the row of the multiplier."""
    row, relation = row_of(p), _relation(p, at)
    f[row] -= at.k * relation
    _add_load(p, at, f, -number(at.q[row]) + at.penalty * relation)


@kernel
def constraints(p, at, g):
    """Write the constraint and its rate."""
    g[0, 0], g[0, 1] = _relation(p, at), _rate(p, at)


@kernel
def observe(p, at, F, y, e):
    """Write the loads along the coordinates."""
    for i in range(len(p.ratios)):
        y[i] = p.ratios[i] * at.q[row_of(p)]


@kernel
def friction_residual(p, at, f):
    """Add the friction of the load with the penalty, whose rounding the multiplier then balances for both loads."""
    load = -number(at.q[row_of(p)]) + at.penalty * _relation(p, at)
    _add_friction(p, at, f, tooth_friction(p, load, _mean_rate(p, at)))


@kernel
def observe_friction(p, at, F, y, e):
    """Write the dissipated power of the friction."""
    rate = _mean_rate(p, at)
    e[2] = tooth_friction(p, -at.q[row_of(p)], rate) * rate


@kernel
def observe_lossy(p, at, F, y, e):
    """Write the loads along the coordinates with friction, and the dissipated power."""
    n, load, rate = len(p.ratios), at.q[row_of(p)], _mean_rate(p, at)
    loss = tooth_friction(p, -load, rate)
    for i in range(n):
        y[i] = p.ratios[i] * load - _share(p, i) * loss
    y[n] = loss * rate


def _variable(kind, by_signal):
    """Return the variant of a ``kind`` of two coordinates with a ratio of their rates, a law of time or a signal."""
    signal = 3 * len(kind.layout)
    row, ratio_of = signal + by_signal, of_input(signal) if by_signal else of_law

    @kernel
    def slip(p, at):
        """Return the rate that violates the constraint, and the ratio."""
        ratio = ratio_of(p, at)
        return rate_along(p, at, 0) - ratio * rate_along(p, at, 1), ratio

    @kernel
    def residual(p, at, f):
        Phi, ratio = slip(p, at)
        f[row] -= at.k * Phi
        load = -number(at.q[row]) + at.penalty * Phi
        add_load(p, at, f, 0, load)
        add_load(p, at, f, 1, -ratio * load)

    @kernel
    def constraints(p, at, g):
        g[0, 1] = slip(p, at)[0]

    @kernel
    def observe(p, at, F, y, e):
        y[0], y[1] = at.q[row], -ratio_of(p, at) * at.q[row]

    first = kind.multipliers[0]
    return replace(
        kind, name="variable_coupler", dtype=with_fields(kind.dtype, law="i"), inputs=("ratio",) * by_signal,
        multipliers=(Row(first.name, first.unit, f"{first.constraint_unit}/s"),),
        prepare=lambda d, nodes, context: {
            **prepare({**d, "factors": (1.0, 1.0)}, nodes, context), "law": law_of(d["ratio"], context),
        },
        **named(residual, constraints, observe),
    )  # fmt: skip


def _joints(d):
    """Return [(output, checked values of the joint)] of all coordinates, in their order."""
    return [(output, joint) for field, (output, _) in COORDINATES.items() for joint in d[field]]


def prepare(d, nodes, context):
    """Return axes and initial values of all coordinates, and the relation."""
    ratios = np.array(d["factors"]) / d["factors"][0]
    found = [
        context.kinds[joint["type"]].measures[output](joint, nodes[2 * i : 2 * i + 2], context)
        for i, (output, joint) in enumerate(_joints(d))
    ]
    turns = len(d["angles"])
    return {
        **axes_of(found[:turns], found[turns:]),
        "ratios": ratios,
        "offset": d["constant"] / d["factors"][0] + ratios @ [one.zero for one in found],
    }


def _prepare_lossy(d, nodes, context):
    """Return the same with the values of the friction."""
    return {**prepare(d, nodes, context), **friction_values(d["friction"], 0)}


def _lossy(kind):
    """Return the variant with friction of a ``kind``: a part for the relation, and one for the friction."""
    alike = {"layout": kind.layout, "memory": kind.memory, "commit": kind.commit,
             "dtype": with_fields(kind.dtype, loss=2, regularization=())}  # fmt: skip
    held = Kind(
        name="coupler_relation", doc=__doc__, multipliers=kind.multipliers, residual=residual, constraints=constraints,
        **alike,
    )  # fmt: skip
    friction = Kind(
        name="coupler_friction", doc=__doc__, coupled_multipliers=kind.multipliers, residual=friction_residual,
        observe=observe_friction, **alike,
    )  # fmt: skip

    def parts(d, nodes, context):
        values, on = _prepare_lossy(d, nodes, context), tuple(range(len(nodes)))
        return [Part(held, on, values), Part(friction, on, values, coupled_to=(0,))]

    return replace(
        kind, name="lossy_coupler", multipliers=(), residual=None, constraints=None, parts=parts, observe=observe_lossy,
        prepare=_prepare_lossy, outputs=(*kind.outputs, DISSIPATED), dtype=alike["dtype"],
    )  # fmt: skip


def check(d, nodes):
    """Check that there are at least two coordinates, each named once, with a factor for each."""
    n = len(_joints(d))
    if n < 2:
        return ["'angles' and 'displacements' must name at least two joints together"]
    texts = [
        f"{field!r} names the same joint twice: add its factors"
        for field in COORDINATES
        if len({id(joint) for joint in d[field]}) < len(d[field])
    ]
    if d["ratio"] is not None:
        other = [name for name in ("factors", "constant", "friction") if d[name]]
        texts += ["'ratio' is that of the rates of two coordinates"] * (n != 2)
        return texts + [f"'ratio' and {name!r} exclude one another" for name in other]
    if len(d["factors"]) != n:
        given = len(d["factors"])
        texts.append(f"'factors' must have {n} numbers: of the 'angles', then the 'displacements'; it has {given}")
    return texts


def sample(rng):
    """Return couplers of angles, of displacements, and of both."""
    joint, samples = {"type": "cylindrical", "axis_1": None}, []
    for turns, slides in ((2, 0), (0, 2), (2, 1)):
        n = turns + slides
        joints = [{**joint, "axis": rng.normal(size=3)} for _ in range(n)]
        d = {
            "angles": joints[:turns],
            "displacements": joints[turns:],
            "factors": [0.5, -1.5, 0.8][:n],
            "constant": 0.2,
        }
        places = [place for _ in range(n) for place in two_places(rng)]
        dry = {"efficiency": 0.8, "backdriving_efficiency": -0.2, "regularization": 0.6}
        samples += [(d, places, ""), ({**d, "friction": dry}, places, "")]
        if n == 2:
            samples += [
                ({**d, "factors": (), "constant": 0.0, "ratio": ratio}, places, "") for ratio in (LAW, "command")
            ]
    return samples


def _declarations(turns, slides):
    """Return the declarations of a Kind that depend on the numbers of angles and displacements."""
    n = turns + slides
    first = TWIST if turns else SLIDE
    return declarations(range(0, 2 * turns, 2), range(2 * turns, 2 * n, 2), first, ratios=(n,), offset=())


@cache
def _of_size(turns, slides, lossy, by_signal):
    coordinates = [TWIST] * turns + [SLIDE] * slides
    loads = (
        Output(f"load_{i}", c.load[1], f"{c.load[0]} along coordinate {i}, > 0 increases it")
        for i, c in enumerate(coordinates, 1)
    )
    kind = replace(COUPLER, variant=None, outputs=tuple(loads), **_declarations(turns, slides))
    return _lossy(kind) if lossy else kind if by_signal is None else _variable(kind, by_signal)


def _variant(d):
    by_signal = None if d["ratio"] is None else is_formula(d["ratio"])
    return _of_size(len(d["angles"]), len(d["displacements"]), d["friction"] is not None, by_signal)


COUPLER = Kind(
    name="coupler", section="joints", doc=__doc__, display=Display("nothing"),
    fields=(
        Field("angles", list_of(joint_with("angle")), "-", "joints whose angles are the first coordinates", ()),
        Field("displacements", list_of(joint_with("displacement")), "-", "joints whose displacements follow", ()),
        Field("factors", list_of(NUMBER, not_zero), "-", "h_i, of the angles and then of the displacements; the ratio "
              "of two has the unit that makes the terms alike", ()),
        Field("constant", NUMBER, "-", "c, in the unit of h_1 c_1", 0.0),
        Field("ratio", CONTINUOUS_DRIVE, "-", "instead of factors: rate of coordinate 1 over that of coordinate 2, a "
              "law of time or a formula of signals", None),
        friction_field(
            "from the other coordinates to the first one",
            Field("regularization", NUMBER, "-", "rate of coordinate 1, in its unit per second, at which friction "
                  "reaches its full value; below it, sticking parts creep", check=positive),
            "friction proportional to the loads: the efficiency of the first coordinate with all the others",
        ),
    ),
    outputs=(
        Output("load_1", "N m", "moment or force along coordinate 1, > 0 increases it; and so on"),
        DISSIPATED,
    ),
    variant=_variant,
    **named(prepare, check, residual, constraints, observe, sample),
    **_declarations(1, 0),
)  # fmt: skip

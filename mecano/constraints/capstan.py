r"""Capstan friction of a cable on the pulleys and eyelets over which it slides: the tensions of its spans differ.

Over pulley i, with the angle of its arc :math:`\theta_i`, or through an eyelet at which the cable bends by this angle,
with the coefficient :math:`\mu_i`, the cable slides at the speed :math:`u_i`, > 0 towards the span before it. The
tensions of the spans before and after it (:math:`N_0` is the output ``tension_1``) satisfy

.. math::  N_i = N_{i-1}\, \exp(-\mu_i\, \theta_i\, \phi(|u_i|)\, \mathrm{sign}\, u_i)

with :math:`\phi(u) = (u/\epsilon)(2 - u/\epsilon)` below :math:`\epsilon`, the ``regularization``, and 1 above: beyond
this speed their ratio is that of the capstan, below it the cable creeps as fast as its tensions require.

The stretch is spread evenly over the cable, whose mean tension N follows from the strain as without friction. With the
parts :math:`w_i` of the path of length :math:`\ell`, a span and half of the arcs at its ends,

.. math::  \sum w_i N_i = N, \qquad
   u_i = \sum_{j<i} (\dot\lambda_j - w_j \dot\ell) - (1 + \varepsilon)\,\dot L \sum_{j\ge i} w_j

where :math:`\dot\lambda_i` is the rate at which span i becomes longer and its pulleys take up cable, and
:math:`\dot L` is paid out at the first node. The forces that this adds, and their power, are

.. math::  f = \sum (N_i - N)\, \partial\lambda_i/\partial q, \qquad
   P_{dissipated} = \sum (N_{i-1} - N_i)\, u_i \ge 0, \qquad P_{given} = -(1 + \varepsilon)\,\dot L\,(N_0 - N)

The surface of a pulley moves with its node alone, and the difference of the tensions turns this node. In a static
equilibrium nothing slides, and there is no friction.
"""

from dataclasses import replace
from functools import cache

from mecano.constraints.activation import kept_shifts
from mecano.constraints.body_fixed import follow
from mecano.constraints.line_phases import PHASES, TAUT, follows, pulled
from mecano.constraints.reeved_path import (
    path_record,
    path_unknowns,
    payout_of,
    pull,
    relative,
    shifted_path,
    side,
    span,
    strain_by,
)
from mecano.element_interface import Kind, Output, named, record
from mecano.jit.kernel import kernel
from mecano.laws.friction import regularization, sticking
from mecano.maths.dual import at_least, atan2, constant, exp, sqrt, value
from mecano.maths.vector import add_vec, cross, dot, vec
from mecano.schema import NUMBERS, Field, mapping

STRAIGHT = 1e-30  # square of the sine of a bend below which it has no slope


@kernel
def _bend(p, at, i):
    """Return the angle [rad] by which the cable bends at eyelet i."""
    a, b = span(p, at.q, i - 1)[0], span(p, at.q, i)[0]
    across = cross(a, b)
    straight = STRAIGHT * value(dot(a, a)) * value(dot(b, b))
    return atan2(sqrt(at_least(dot(across, across), straight)), dot(a, b))


@kernel
def _pulley(p, at, i):
    """Return half of the arc on pulley i, the angle of the arc, and gradients of the lengths that it takes up.

    They are those that it takes up from the spans at its sides. An eyelet is a pulley without an arc.
    """
    if p.radii[i] == 0.0:
        none = 0.0 * span(p, at.q, i)[0]
        return dot(none, none), _bend(p, at, i), (none, none), (none, none)
    before, g_before, turning_before = side(p, at, i, i - 1)
    behind, g_behind, turning_behind = side(p, at, i, i)
    r = p.radii[i]
    half = at_least(0.5 * r * follow(p.start[i - 1] + at.m[i - 1], behind - before), 0.0)
    return half, 2.0 * half / abs(r), (-r * g_before, -r * turning_before), (r * g_behind, r * turning_behind)


@kernel
def _rate(at, i, k, taken_up):
    """Return the rate at which pulley i takes up cable of span k."""
    g, turning = taken_up
    return dot(g, relative(at.v, k)) + dot(turning, vec(at.v, 6 * i))


@kernel
def _begin(p, at, cable, tension):
    """Return the sums of ``_over`` before the first pulley; ``tension`` is that of span 0."""
    d, _, free = span(p, at.q, 0)
    part = free / cable[0]
    return part, dot(d, relative(at.v, 0)) / free, constant(1.0, part) * tension, part * tension


@kernel
def _over(p, at, i, pulley, cable, sums):
    """Return the sliding speed over pulley i, and the ``sums`` continued to the end of the free span after it.

    They are the part of the path, the rate at which it takes up cable, the tension, and the contribution to the mean.
    """
    half, angle, before, behind = pulley
    length, rate, feed, _ = cable
    part, taken, tension, mean = sums
    d, _, free = span(p, at.q, i)
    arc, own = half / length, (half + free) / length
    part, taken = part + arc, taken + _rate(at, i, i - 1, before)
    u = taken - part * rate - feed * (1.0 - part)
    after = tension * exp(-p.coefficients[i - 1] * angle * sticking(p.regularization, abs(u)) * u)
    taken = taken + _rate(at, i, i, behind) + dot(d, relative(at.v, i)) / free
    return u, (part + own, taken, after, mean + arc * tension + own * after)


@kernel
def _first_tension(p, at, cable):
    """Return the tension of span 0 for the given mean, from the mean that a tension of 1 gives."""
    sums = _begin(p, at, cable, 1.0)
    for i in range(1, len(p.radii) - 1):
        _, sums = _over(p, at, i, _pulley(p, at, i), cable, sums)
    return cable[3] / sums[3]


@kernel
def _pull_span(p, at, f, i, T):
    """Add the tension T of the free span after node i."""
    d, _, free = span(p, at.q, i)
    pull(f, i, (T / free) * d)


@kernel
def _pull_pulley(f, i, k, taken_up, T):
    """Add the tension T of span k on pulley i."""
    g, turning = taken_up
    pull(f, k, T * g)
    add_vec(f, 6 * i, T, turning)


def _functions(strain_of):
    """Return ``residual`` and ``observe`` for the strain of reeved_path.strain_by."""

    @kernel
    def cable_of(p, at):
        """Return the length of the path, its rate, the speed of the payout, and the mean tension."""
        length, rate, strain, strain_rate, _, L_rate = strain_of(p, at)
        return length, rate, (1.0 + strain) * L_rate, p.EA * pulled(p, at, strain, strain_rate)[1]

    @kernel
    def residual(p, at, f):
        """Add the differences of the tensions to their mean."""
        if at.phase != TAUT and not follows(p, at):
            return
        cable = cable_of(p, at)
        mean, first = cable[3], _first_tension(p, at, cable)
        sums = _begin(p, at, cable, first)
        _pull_span(p, at, f, 0, first - mean)
        for i in range(1, len(p.radii) - 1):
            pulley, tension = _pulley(p, at, i), sums[2]
            _, sums = _over(p, at, i, pulley, cable, sums)
            _pull_pulley(f, i, i - 1, pulley[2], tension - mean)
            _pull_pulley(f, i, i, pulley[3], sums[2] - mean)
            _pull_span(p, at, f, i, sums[2] - mean)

    @kernel
    def observe(p, at, F, y, e):
        """Write the dissipated power, the tensions of the spans and the sliding speeds; the powers."""
        n, cable = len(p.coefficients), cable_of(p, at)
        if at.phase != TAUT and not value(cable[3]) > 0.0:
            return
        first = _first_tension(p, at, cable)
        sums = _begin(p, at, cable, first)
        y[1], lost = at_least(first, 0.0), constant(0.0, first)
        for i in range(1, n + 1):
            tension = sums[2]
            u, sums = _over(p, at, i, _pulley(p, at, i), cable, sums)
            lost = lost + (tension - sums[2]) * u
            y[1 + i], y[1 + n + i] = at_least(sums[2], 0.0), u
        y[0] = e[2] = lost
        e[3] = -cable[2] * (first - cable[3])

    return named(residual, observe)


def friction_field():
    """Return the field ``friction`` of a cable."""
    coefficients = Field(
        "coefficients", NUMBERS, "-", "mu on each pulley and eyelet, in their order; 0 where the cable slides freely"
    )
    doc = "capstan friction on the pulleys, which turn with their nodes alone, and eyelets; none when absent"
    return Field("friction", mapping(coefficients, regularization()), "-", doc, None)


@cache
def capstan(n, by_signal=False, phases=PHASES, stress_free=False):
    """Return the Kind of the friction on n pulleys of a cable, with a payout by a law or a signal, and its phases.

    A ``stress_free`` cable has the natural length of its path at its activation; before, it is in its last phase.
    """
    payout = payout_of(n, by_signal)
    unknowns, strain_of = shifted_path(n, payout) if stress_free else (path_unknowns(n), strain_by(payout))
    found = Kind(
        name="capstan_friction", doc=__doc__, dtype=record(coefficients=(n,), regularization=(), **path_record(n)),
        **unknowns,
        outputs=(
            Output("dissipated_power", "W", "power dissipated by friction"),
            *(Output(f"tension_{i}", "N", f"tension of span {i}") for i in range(1, n + 2)),
            *(Output(f"slip_{i}", "m/s", f"sliding speed over pulley {i}, > 0 to span {i}") for i in range(1, n + 1)),
        ),
        phases=phases,
        inputs=("payout",) if by_signal else (),
        **_functions(strain_of),
    )  # fmt: skip
    return replace(found, kept=kept_shifts(found.memory, phases))


CAPSTAN = capstan(1)

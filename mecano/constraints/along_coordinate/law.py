"""Load a coordinate c by a law: P(s, ds/dt) adds P times the gradient of c to the forces; s = c - n(t) - natural.

P > 0 acts against increasing c. The set point n(t) is a law of time; its power -P dn/dt is given by the surroundings.
An angle is continued over whole turns with the memory of the last accepted step.
"""

from mecano.constraints.body_fixed import follow
from mecano.constraints.coordinates.coordinate import add_along, rate_of
from mecano.constraints.stop_phases import EVENTS, PHASES, law_record, put_stop_events
from mecano.element_interface import Kind, Output, record
from mecano.jit.kernel import kernel
from mecano.laws.table import evaluate_curve, evaluate_force, law_force, potential
from mecano.schema import LAW, TIME_CURVE, Field

SET_POINT = "at which the extension of the {} law is zero, as a function of time [s]"

TURNING_FIELDS = (
    Field("turning_law", LAW, "-", "moment [N m] from angle [rad] and rate [rad/s]; > 0 opposes the angle", None),
    Field("natural_angle", TIME_CURVE, "rad", f"angle {SET_POINT.format('turning')}", 0.0),
)
SLIDING_FIELDS = (
    Field(
        "sliding_law",
        LAW,
        "-",
        "force [N] from displacement [m] and velocity [m/s]; > 0 opposes the displacement",
        None,
    ),
    Field("natural_displacement", TIME_CURVE, "m", f"displacement {SET_POINT.format('sliding')}", 0.0),
)
LAW_RECORD = {"law": "i", "natural": (), "low": (), "high": (), "set_point": "i"}


@kernel
def extension(p, at, c):
    """Return the extension of the law at a value of the coordinate."""
    return c - p.natural - evaluate_curve(at.laws, p.set_point, at.t)[0]


@kernel
def extension_rate(p, at, rate):
    """Return the rate of the extension from that of the coordinate."""
    return rate - evaluate_curve(at.laws, p.set_point, at.t)[1]


@kernel
def report(p, at, coordinate, rate, y, e):
    """Write the force of the law to y[0], potential energy, dissipated and given power to e."""
    s, s_rate = extension(p, at, coordinate), extension_rate(p, at, rate)
    P, _, _ = evaluate_force(at.laws, p.law, s, s_rate)
    elastic, _, _ = evaluate_force(at.laws, p.law, s, 0.0)
    y[0] = P
    e[1] = potential(at.laws, p.law, s)
    e[2] = (P - elastic) * s_rate
    e[3] = P * (s_rate - rate)


@kernel
def _as_it_is(m, c):
    return c


@kernel
def _over_turns(m, c):
    return follow(m[0], c)


def counted(coordinate):
    """Return the compiled function (p, at) -> c; an angle is continued over whole turns from the memory."""
    value, turns = coordinate.value, _over_turns if coordinate.periodic else _as_it_is

    @kernel
    def count(p, at):
        return turns(at.m, value(p, at))

    return count


def law_kind(name, doc, coordinate):
    """Return the Kind of a law along a coordinate."""
    value, gradient = counted(coordinate), coordinate.gradient

    @kernel
    def residual(p, at, f):
        along = gradient(p, at)
        s, s_rate = extension(p, at, value(p, at)), extension_rate(p, at, rate_of(along, at.v))
        add_along(f, law_force(at.laws, p.law, s, s_rate), along)

    @kernel
    def observe(p, at, F, y, e):
        report(p, at, value(p, at), rate_of(gradient(p, at), at.v), y, e)
        y[1] = e[2]

    @kernel
    def event_values(p, at, g):
        put_stop_events(g, p.low, p.high, extension(p, at, value(p, at)))

    @kernel
    def commit(p, at, m_out):
        m_out[0] = value(p, at)

    what, unit = coordinate.load
    return Kind(
        name=name, section="", doc=doc, dtype=record(**coordinate.axes, **LAW_RECORD), layout=coordinate.layout,
        outputs=(
            Output(f"law_{what}", unit, f"{what} of the law; > 0 acts against the coordinate"),
            Output(f"law_{what}_dissipation", "W", "power dissipated by the law"),
        ),
        phases=PHASES, events=EVENTS, memory=("angle",) if coordinate.periodic else (),
        residual=residual, observe=observe, event_values=event_values, commit=commit if coordinate.periodic else None,
    )  # fmt: skip


def law_values(axes, law, natural, context, zero=0.0):
    """Return the record of a law of the deck on a coordinate with these ``axes``.

    ``natural`` is the set point, a number or a law of time, relative to the value ``zero`` of the coordinate.
    """
    is_law = isinstance(natural, tuple)
    given = {"natural": zero if is_law else zero + natural, "set_point": context.laws.add(natural) if is_law else 0}
    return {**axes, **given, **law_record(law, context)}

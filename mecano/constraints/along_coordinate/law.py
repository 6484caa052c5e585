"""Load a coordinate c by a law: P(c - natural, dc/dt) adds P times the gradient of c to the forces.

P > 0 acts against increasing c. An angle is continued over whole turns with the memory of the last accepted step.
"""

from mecano.constraints.body_fixed import follow
from mecano.constraints.coordinates.coordinate import add_along, rate_of
from mecano.constraints.stop_phases import EVENTS, PHASES, law_record, put_stop_events
from mecano.element_interface import Kind, Output, record
from mecano.jit.kernel import kernel
from mecano.laws.table import evaluate_force, law_force, potential
from mecano.schema import LAW, NUMBER, Field

TURNING_FIELDS = (
    Field("turning_law", LAW, "-", "moment [N m] from angle [rad] and rate [rad/s]; > 0 opposes the angle", None),
    Field("natural_angle", NUMBER, "rad", "angle at which the extension of the turning law is zero", 0.0),
)
SLIDING_FIELDS = (
    Field(
        "sliding_law",
        LAW,
        "-",
        "force [N] from displacement [m] and velocity [m/s]; > 0 opposes the displacement",
        None,
    ),
    Field("natural_displacement", NUMBER, "m", "displacement at which the extension of the sliding law is zero", 0.0),
)
LAW_RECORD = {"law": "i", "natural": (), "low": (), "high": ()}


@kernel
def report(p, laws, coordinate, rate, y, e):
    """Write the force of the law to y[0], potential energy and dissipated power to e."""
    P, _, _ = evaluate_force(laws, p.law, coordinate - p.natural, rate)
    elastic, _, _ = evaluate_force(laws, p.law, coordinate - p.natural, 0.0)
    y[0] = P
    e[1] = potential(laws, p.law, coordinate - p.natural)
    e[2] = (P - elastic) * rate


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
        add_along(f, law_force(at.laws, p.law, value(p, at) - p.natural, rate_of(along, at.v)), along)

    @kernel
    def observe(p, at, F, y, e):
        report(p, at.laws, value(p, at), rate_of(gradient(p, at), at.v), y, e)

    @kernel
    def event_values(p, at, g):
        put_stop_events(g, p.low, p.high, value(p, at) - p.natural)

    @kernel
    def commit(p, at, m_out):
        m_out[0] = value(p, at)

    what, unit = coordinate.load
    return Kind(
        name=name, section="", doc=doc, dtype=record(**coordinate.axes, **LAW_RECORD), layout=coordinate.layout,
        outputs=(Output(f"law_{what}", unit, f"{what} of the law; > 0 acts against the coordinate"),),
        phases=PHASES, events=EVENTS, memory=("angle",) if coordinate.periodic else (),
        residual=residual, observe=observe, event_values=event_values, commit=commit if coordinate.periodic else None,
    )  # fmt: skip


def law_values(axes, law, natural, context):
    """Return the record of a law of the deck on a coordinate with these ``axes``."""
    return {**axes, "natural": natural, **law_record(law, context)}

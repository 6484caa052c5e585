"""Load a coordinate c by a law: P(s, ds/dt) adds P times the gradient of c to the forces; s = c - n(t) - natural.

P > 0 acts against increasing c. The set point n is a law of time or a signal; its power -P dn/dt is given by the
surroundings. An angle is continued over whole turns with the memory of the last accepted step.
"""

from dataclasses import replace

from mecano.constraints.along_coordinate.demand import is_formula, with_rate
from mecano.constraints.body_fixed import follow
from mecano.constraints.coordinates.coordinate import add_along, rate_of
from mecano.constraints.stop_phases import EVENTS, PHASES, law_record, put_stop_events
from mecano.element_interface import Kind, Output, record
from mecano.jit.kernel import kernel
from mecano.laws.law_table import evaluate_curve, law_force, potential, terms_of
from mecano.laws.probe import table_bounds
from mecano.maths.dual import value
from mecano.schema import CONTINUOUS_DRIVE, LAW, Field

SET_POINT = "at which the extension of the {} law is zero"
STILL = (0.0, 0.0)  # a set point that does not move, and its rate
NOT_GIVEN = 0.0, (("constant", {"value": 0.0}),)  # set points

TURNING_FIELDS = (
    Field(
        "turning_law", LAW, "-", "moment [N m] from angle [rad] and rate [rad/s]; > 0 opposes the angle", None,
        argument="rad",
    ),
    Field("natural_angle", CONTINUOUS_DRIVE, "rad", f"angle {SET_POINT.format('turning')}", 0.0),
)  # fmt: skip
SLIDING_FIELDS = (
    Field(
        "sliding_law", LAW, "-", "force [N] from displacement [m] and velocity [m/s]; > 0 opposes the displacement",
        None, argument="m",
    ),
    Field("natural_displacement", CONTINUOUS_DRIVE, "m", f"displacement {SET_POINT.format('sliding')}", 0.0),
)  # fmt: skip
COORDINATES = (TURNING_FIELDS, "angle", "the moment"), (SLIDING_FIELDS, "displacement", "the force")
LAW_RECORD = {"law": "i", "natural": (), "low": (), "high": (), "set_point": "i"}


def check_set_point(d, law, set_point):
    """Return an error if a joint has a ``set_point`` without the ``law`` to which it belongs."""
    alone = d[law] is None and d[set_point] not in NOT_GIVEN
    return [f"{set_point!r} is that of a {law!r}, which is missing"] if alone else []


def bounds(d):
    """Yield the ends of the tables of laws of a joint with a constant set point, as ``Kind.bounds``."""
    for (law, set_point), output, what in COORDINATES:
        moved = d.get(set_point.name)
        if d.get(law.name) is None or is_formula(moved) or any(term != "constant" for term, _ in terms_of(moved)):
            continue
        yield from table_bounds(output, d[law.name], what, sum(values["value"] for _, values in terms_of(moved)))


@kernel
def set_point_of_law(p, at):
    """Return the set point of a law of time, and its rate."""
    return evaluate_curve(at.laws, p.set_point, at.t)[:2]


@kernel
def extension(p, set_point, c):
    """Return the extension of the law at a value of the coordinate, for a set point (value, rate)."""
    return c - p.natural - set_point[0]


@kernel
def report(p, at, set_point, coordinate, rate, y, e):
    """Write the force of the law to y[0], potential energy, dissipated and given power to e; return what dissipates."""
    s, s_rate = extension(p, set_point, coordinate), rate - set_point[1]
    P, elastic = law_force(at.laws, p.law, s, s_rate), law_force(at.laws, p.law, s, 0.0)
    dissipated = (P - elastic) * s_rate
    y[0] = P
    e[1] = potential(at.laws, p.law, value(s))
    e[2] = dissipated
    e[3] = P * (s_rate - rate)
    return dissipated


@kernel
def as_it_is(before, c):
    """Return the value c of a coordinate that is not periodic."""
    return c


@kernel
def _over_turns(m, c):
    return follow(m[0], c)


def counted(coordinate):
    """Return the compiled function (p, at) -> c; an angle is continued over whole turns from the memory."""
    value, turns = coordinate.value, _over_turns if coordinate.periodic else as_it_is

    @kernel
    def count(p, at):
        return turns(at.m, value(p, at))

    return count


def law_kind(name, doc, coordinate, set_point=set_point_of_law):
    """Return the Kind of a law along a coordinate with a ``set_point``, of time or of a signal."""
    count, gradient = counted(coordinate), coordinate.gradient

    @kernel
    def residual(p, at, f):
        along, point = gradient(p, at), set_point(p, at)
        s, s_rate = extension(p, point, count(p, at)), rate_of(along, at.v) - point[1]
        add_along(f, law_force(at.laws, p.law, s, s_rate), along)

    @kernel
    def observe(p, at, F, y, e):
        y[1] = report(p, at, set_point(p, at), count(p, at), rate_of(gradient(p, at), at.v), y, e)

    @kernel
    def event_values(p, at, g):
        put_stop_events(g, p.low, p.high, extension(p, set_point(p, at), count(p, at)))

    @kernel
    def commit(p, at, m_out):
        m_out[0] = count(p, at)

    what, unit = coordinate.load
    return Kind(
        name=name, doc=doc, dtype=record(**coordinate.axes, **LAW_RECORD), layout=coordinate.layout,
        outputs=(
            Output(f"law_{what}", unit, f"{what} of the law; > 0 acts against the coordinate"),
            Output(f"law_{what}_dissipation", "W", "power dissipated by the law"),
        ),
        phases=PHASES, events=EVENTS, memory=("angle",) if coordinate.periodic else (),
        residual=residual, observe=observe, event_values=event_values, commit=commit if coordinate.periodic else None,
    )  # fmt: skip


def law_kind_of_signal(name, doc, coordinate):
    """Return the Kind of a law along a coordinate whose set point is its input."""
    return replace(law_kind(name, doc, coordinate, with_rate(3 * len(coordinate.layout))), inputs=("set_point",))


def law_values(axes, law, natural, context, zero=0.0):
    """Return the record of a law of the deck on a coordinate with these ``axes``.

    ``natural`` is the set point, a number, a law of time or a formula, relative to the value ``zero`` of the
    coordinate.
    """
    is_law, moves = isinstance(natural, tuple), isinstance(natural, tuple | str)
    given = {"natural": zero if moves else zero + natural, "set_point": context.laws.add(natural) if is_law else 0}
    return {**axes, **given, **law_record(law, context)}

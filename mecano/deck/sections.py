"""Sections of a deck, version 1, without the fields declared by kinds of elements, joints and loads, and by laws."""

import math
from dataclasses import replace

from mecano.deck.limits import AUTOMATIC, above_rounding, at_least_one, distinct, not_empty, resolvable, spectral_radius
from mecano.deck.static_section import INITIAL_STATIC_FIELDS, SCALE_FIELDS, STATIC_FIELDS, check_static
from mecano.elements.members.cross_section import check_section
from mecano.schema import (
    BOOLEAN,
    CONDITION,
    CURVE,
    DIRECTION,
    INTEGER,
    NODE_SET,
    NODES,
    NUMBER,
    ORIENTATION,
    POSITION,
    SIGNAL_ENTRY,
    TEXT,
    TIME_CURVE,
    VECTOR,
    Field,
    Type,
    Values,
    choice,
    either,
    list_of,
    mapping,
    named,
    not_negative,
    one_of_kinds,
    positive,
    shorthand,
)


class TireLawFields:
    """The fields of a tyre law, one for each slip law among them; their modules are imported when a deck has one."""

    def __iter__(self):
        from mecano.elements.wheels.tire_law import TIRE_LAW_FIELDS

        return iter(TIRE_LAW_FIELDS)


PARAMETER = Type("parameter", "a number")
LAW_IN_PLACE = Type("law_in_place", "a number or a mapping of terms")
ZERO = (0.0, 0.0, 0.0)
MOST_INTERVALS = 1e12
LEAST_ULPS = 16.0  # spacings of floating-point times in a step


def check_time(time: Values) -> str | None:
    """Check the interval, and that steps fit into it and into their bounds; return the error text or None."""
    if not time["end"] > time["start"]:
        return f"'end' must be later than 'start', {time['start']:g} s"
    if time["step"] > time["end"] - time["start"]:
        return "'step' must not be longer than the time from 'start' to 'end'"
    if time["step"] < (shortest := shortest_interval(time)):
        return f"'step' must be at least {shortest:g} s here, because times have 16 digits"
    if time["method"] == "hht" and time["rho_inf"] < 0.5:
        return "'rho_inf' must be at least 0.5 with the method hht"
    if time["method"] == "newmark" and time["rho_inf"] < 1.0 and time["adaptive"]:
        return (
            "'rho_inf' must be 1 with the method newmark and 'adaptive': with numerical damping newmark is of first "
            "order, and its errors exceed the tolerance"
        )
    bounds = time["adaptive"] or {"minimum_step": AUTOMATIC, "maximum_step": AUTOMATIC}
    low, high = bounds["minimum_step"], bounds["maximum_step"]
    if low != AUTOMATIC and low > time["step"]:
        return "'step' must not be less than 'adaptive.minimum_step'"
    if low != AUTOMATIC and low < (finest := finest_step(time)):
        return f"'adaptive.minimum_step' must be at least {finest:.3g} s here, or a step would not change the time"
    if high != AUTOMATIC and high < time["step"]:
        return "'step' must not be greater than 'adaptive.maximum_step'"
    return None


def shortest_interval(time: Values) -> float:
    """Return the shortest interval [s] of steps and saved times, which must exceed the rounding of times."""
    return max(abs(time["start"]), abs(time["end"])) / MOST_INTERVALS


def finest_step(time: Values) -> float:
    """Return the shortest step [s] that changes every time of the run by more than rounding."""
    return LEAST_ULPS * math.ulp(max(abs(time["start"]), abs(time["end"])))


def check_initial(initial: Values) -> str | None:
    """Check that only one kind of initial state is given; return the error text or None."""
    given = [name for name in ("static", "steady", "from") if initial[name] is not None]
    return f"'{given[0]}' and '{given[1]}' exclude one another" if len(given) > 1 else None


def check_steady(steady: Values) -> str | None:
    """Check that one steady motion is given, a rotation with its axis; return the error text or None."""
    straight, turns = steady["velocity"] is not None, steady["angular_velocity"] is not None
    if straight == turns:
        return "give either 'velocity', of straight running, or 'angular_velocity', of a rotation"
    if turns and steady["about"] is None:
        return "'about' is missing: a point of the axis of rotation"
    if straight and (steady["about"] is not None or steady["at_rest"]):
        return f"'{'about' if steady['about'] is not None else 'at_rest'}' belongs to 'angular_velocity'"
    return None


def check_velocity(entry: Values) -> str | None:
    """Check that a rotating set of nodes has a centre of rotation; return the error text or None."""
    several = entry["nodes"] == "all" or len(entry["nodes"]) > 1
    if several and any(entry["angular_velocity"]) and entry["about"] is None:
        return "'about' is missing: the point about which the nodes turn, or 'own' for each about itself"
    return None


NODE_FIELDS = (
    Field("position", POSITION, "m", "position at the start, inertial"),
    Field(
        "orientation", ORIENTATION, "rad",
        "rotation vector at the start, from the inertial axes to those of the node", ZERO,
    ),
    Field("fixed", BOOLEAN, "-", "whether the node is fixed in space", False),
)  # fmt: skip

PLANE_FIELDS = (
    Field("point", POSITION, "m", "a point of the plane"),
    Field("normal", DIRECTION, "-", "normal of the plane, out of the ground"),
)
PROFILE_FIELDS = (
    Field("direction", DIRECTION, "-", "direction of the distance, taken in the plane"),
    Field("height", CURVE, "m", "height over the plane, a curve of the distance [m] from its point", argument="m"),
)
GRIP_FIELDS = (
    Field("direction", DIRECTION, "-", "direction of the distance, taken in the plane"),
    Field(
        "factor",
        CURVE,
        "-",
        "factor on the friction of tyres, a curve of the distance [m] from the plane's point",
        argument="m",
    ),
)
MOTION_FIELDS = (
    Field("direction", DIRECTION, "-", "direction in which it moves (a belt)", None),
    Field("speed", TIME_CURVE, "m/s", "speed along the direction, a function of time [s]", None),
    Field("rate", TIME_CURVE, "rad/s", "angular velocity about the normal (a turntable), a function of time [s]", None),
    Field("centre", POSITION, "m", "point about which it turns; that of the plane when absent", None),
)
GROUND_FIELDS = (
    Field("plane", mapping(*PLANE_FIELDS), "-", "plane of the ground, or reference plane of its profile"),
    Field("profile", mapping(*PROFILE_FIELDS), "-", "unevenness; the ground is flat when absent", None),
    Field(
        "friction", mapping(*GRIP_FIELDS), "-", "friction varying along the ground; for wheels with a tyre law", None
    ),
    Field("motion", mapping(*MOTION_FIELDS), "-", "motion of a flat ground; wheel and transient_wheel only", None),
)

VELOCITY_FIELDS = (
    Field("nodes", either(NODE_SET, "all"), "-", "nodes with this motion, and members with all of theirs",
          check=distinct),
    Field("velocity", VECTOR, "m/s", "velocity, inertial; with 'about', of this point", ZERO),
    Field("angular_velocity", VECTOR, "rad/s", "angular velocity, inertial axes", ZERO),
    Field(
        "about", either(VECTOR, "own"), "m",
        "point about which the nodes turn as one rigid body; 'own': each about itself", None,
    ),
)  # fmt: skip
STEADY_FIELDS = (
    Field("velocity", VECTOR, "m/s", "straight running: velocity of all nodes, along the road, inertial", None),
    Field(
        "angular_velocity", VECTOR, "rad/s", "rotation: angular velocity of all nodes that turn, inertial; wheels on a "
        "ground roll as well, in a steady turn", None,
    ),
    Field("about", VECTOR, "m", "rotation: a point of the axis", None),
    Field(
        "at_rest", NODES, "-", "rotation: nodes that do not turn, such as those of the support", None, check=distinct
    ),
)  # fmt: skip
INITIAL_FIELDS = (
    Field(
        "static", shorthand(mapping(*INITIAL_STATIC_FIELDS), {True: {}}), "-",
        "start from the static equilibrium at the start time, with the velocities below", None,
    ),
    Field(
        "steady", mapping(*STEADY_FIELDS), "-",
        "start from straight steady running, solved for deflections, spins of the wheels and reactions, or from steady "
        "rotation or a steady turn, solved for deflections under centrifugal and other forces as well; the velocities "
        "below are added as a disturbance", None, check=check_steady,
    ),
    Field(
        "from", TEXT, "-",
        "start from a saved time of another run: 'stowed.h5:2.0' (file, relative to the deck, and time [s]; without a "
        "time the last one); the velocities below are added", None,
    ),
    Field(
        "velocities", list_of(mapping(*VELOCITY_FIELDS), check_velocity), "-",
        "rigid-body motions of sets of nodes, v = velocity + angular_velocity x (x - about), added to one another",
        (),
    ),
)  # fmt: skip

ADAPTIVE_FIELDS = (
    Field(
        "tolerance",
        NUMBER,
        "-",
        "error of the run relative to 'length_scale', or [rad]; taken as 0.03 if larger",
        check=resolvable,
    ),
    Field(
        "minimum_step", either(NUMBER, AUTOMATIC), "s", "the run stops if a smaller step is needed", AUTOMATIC, positive
    ),
    Field("maximum_step", either(NUMBER, AUTOMATIC), "s", "longest step", AUTOMATIC, positive),
    Field("length_scale", either(NUMBER, AUTOMATIC), "m", "size of the mechanism", AUTOMATIC, positive),
)
NEWTON_FIELDS = (
    Field(
        "force_tolerance",
        NUMBER,
        "-",
        "residual forces relative to the forces at work; at most a hundredth of 'adaptive.tolerance'; not for radau",
        1e-7,
        above_rounding,
    ),
    Field(
        "constraint_tolerance",
        NUMBER,
        "-",
        "constraints relative to the size of the mechanism; taken as 1e-14 in models with redundant ones",
        1e-10,
        above_rounding,
    ),
    Field("maximum_iterations", INTEGER, "-", "iterations before the step is abandoned", 15, at_least_one),
)
TIME_FIELDS = (
    Field("start", NUMBER, "s", "time at the start", 0.0),
    Field("end", NUMBER, "s", "time at the end"),
    Field(
        "until", CONDITION, "-",
        "condition on signals, outputs and motions at which the run ends before 'end', as in hinge.angle > 1.5", None,
    ),
    Field("step", NUMBER, "s", "time step; with 'adaptive' the first one", check=positive),
    Field(
        "method", choice("generalized_alpha", "hht", "newmark", "radau"), "-",
        "time integration (Lie group); radau: Radau IIA of order 5, for smooth motion and tight tolerances; newmark is "
        "of first order unless 'rho_inf' is 1",
        "generalized_alpha",
    ),
    Field(
        "rho_inf", NUMBER, "-",
        "spectral radius at infinite frequency; 1: no numerical damping, 0: most; not for radau", 0.8, spectral_radius,
    ),
    Field("adaptive", mapping(*ADAPTIVE_FIELDS), "-", "step size from the error; a fixed step when absent", None),
    Field(
        "rest_speed", NUMBER, "1/s",
        "contacts that approach more slowly do not rebound: in length scales, or rad, per second", 1e-4, not_negative,
    ),
    Field(
        "located_events", INTEGER, "-",
        "instants with events of cables, belts, stops of springs and elastic contacts that are located, beyond one "
        "in each step; further events are taken at the ends of steps (docs/theory.md)", 100, at_least_one,
    ),
    Field("newton", mapping(*NEWTON_FIELDS), "-", "convergence criteria of Newton's iteration", {}),
    Field("scale", mapping(*SCALE_FIELDS), "-", "scales of the augmented Lagrangian", {}),
)  # fmt: skip

GRAVITY = replace(VECTOR, expects="a list of 3 numbers, such as [0, 0, -9.81],")

OUTPUT_FIELDS = (
    Field("every", either(NUMBER, "step"), "s", "time between saved results; 'step': every step", "step", positive),
)

SECTIONS = (
    Field("mecano", INTEGER, "-", "version of the deck"),
    Field("title", TEXT, "-", "title of the model", ""),
    Field(
        "parameters", named(PARAMETER), "-",
        "numbers by name, for expressions in all numbers: '$speed / 0.35'; words for names: 'node: $side'", {},
    ),
    Field(
        "gravity", shorthand(GRAVITY, {"none": ZERO}), "m/s2",
        "acceleration of gravity, inertial; required if an element has mass", "none",
    ),
    Field(
        "nodes", named(mapping(*NODE_FIELDS)), "-", "named frames, which elements and joints connect", check=not_empty
    ),
    Field("elements", named(one_of_kinds("elements")), "-", "bodies, springs, wheels...", check=not_empty),
    Field("joints", named(one_of_kinds("joints")), "-", "constraints between nodes", {}),
    Field("loads", named(one_of_kinds("loads")), "-", "forces, moments, motors, drag, brakes", {}),
    Field(
        "signals", named(SIGNAL_ENTRY), "-",
        "named quantities that follow from the motion, from the time and from one another: sensors, controllers", {},
    ),
    Field("laws", named(LAW_IN_PLACE), "-", "named laws, each a number or a sum of terms", {}),
    Field("grounds", named(mapping(*GROUND_FIELDS)), "-", "surfaces on which wheels roll", {}),
    Field("tire_laws", named(Type("mapping", "a mapping", TireLawFields())), "-", "properties of tyres", {}),
    Field("sections", named(one_of_kinds("sections"), check_section), "-", "cross sections of beams", {}),
    Field(
        "initial", shorthand(mapping(*INITIAL_FIELDS), {"static": {"static": {}}}), "-",
        "initial state: velocities, static equilibrium ('initial: static'), steady running, a state of another run",
        {}, check_initial,
    ),
    Field("time", mapping(*TIME_FIELDS), "-", "interval, step and method of the integration", None, check_time),
    Field("static", mapping(*STATIC_FIELDS), "-", "loading and method of a static analysis", None, check_static),
    Field("output", mapping(*OUTPUT_FIELDS), "-", "saved results", {}),
)  # fmt: skip

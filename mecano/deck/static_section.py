"""The section ``static`` of a deck, and ``initial.static``: search for an equilibrium."""

import math

from mecano.deck.limits import AUTOMATIC, above_rounding, at_least_one, below_one
from mecano.schema import (
    DIRECTION,
    INTEGER,
    NODE,
    NUMBER,
    Field,
    Values,
    choice,
    either,
    mapping,
    not_negative,
    not_zero,
    positive,
)


def check_static(static: Values) -> str | None:
    """Check the interval, and the criteria of the end against the method; return the error text or None."""
    over_time = static["over"] == "time"
    if static["end"] <= (static["start"] if over_time else 0.0):
        return "'end' must be greater than " + (f"'start', {static['start']:g} s" if over_time else "zero")
    if over_time and static["method"] == "arc_length":
        return "'method' arc_length follows the load factor; over time it would have to go backwards"
    if static["method"] != "arc_length":
        for name in ("until", "lowest"):
            if static[name] not in (None, -math.inf):
                return f"'{name}' belongs to the method arc_length"
    return None


STATIC_TOLERANCES = (
    Field("force_tolerance", NUMBER, "-", "residual forces relative to the forces at work", 1e-9, above_rounding),
    Field(
        "constraint_tolerance", NUMBER, "-", "constraints relative to the size of the mechanism", 1e-11, above_rounding
    ),
    Field("maximum_iterations", INTEGER, "-", "iterations before a step is cut back", 25, at_least_one),
)
SCALE_FIELDS = (
    Field("k", either(NUMBER, AUTOMATIC), "N/m", "scale of the constraint equations", AUTOMATIC, positive),
    Field("penalty", either(NUMBER, AUTOMATIC), "N/m", "penalty of the constraints", AUTOMATIC, not_negative),
)
STEPS_FIELD = Field(
    "steps", either(INTEGER, AUTOMATIC), "-",
    "number of equal steps, cut back where needed; 'automatic': first a tenth, then as large as the iterations allow",
    AUTOMATIC, at_least_one,
)  # fmt: skip
UNTIL_FIELDS = (
    Field("node", NODE, "-", "node whose displacement is monitored"),
    Field("direction", DIRECTION, "-", "direction of the displacement, inertial"),
    Field("displacement", NUMBER, "m", "displacement from the start at which the path ends", check=not_zero),
)
INITIAL_STATIC_FIELDS = (
    Field(
        "method", choice("relaxation", "steps"), "-",
        "relaxation: the mechanism creeps to a stable equilibrium; steps: the loads grow in steps", "relaxation",
    ),
    STEPS_FIELD,
    Field("newton", mapping(*STATIC_TOLERANCES), "-", "convergence criteria of an equilibrium", {}),
)  # fmt: skip
STATIC_FIELDS = (
    Field(
        "over", choice("load_factor", "time"), "-",
        "parameter of the path: the load factor of loads and gravity, or the time in the laws", "load_factor",
    ),
    Field("start", NUMBER, "s", "time in the laws; over time, that of the first equilibrium", 0.0),
    Field("end", NUMBER, "-", "load factor, or time [s], at the end", 1.0),
    Field(
        "method", choice("steps", "arc_length", "relaxation"), "-",
        "steps of this parameter; arc_length: past limit points; relaxation: creep to a stable equilibrium (over time: "
        "for the first one, then steps)",
        "steps",
    ),
    STEPS_FIELD,
    Field(
        "minimum_step", NUMBER, "-", "the run stops if a smaller fraction of the first step is needed", 1e-4, below_one
    ),
    Field("maximum_steps", INTEGER, "-", "steps after which arc_length gives up (exit code 3)", 1000, at_least_one),
    Field("lowest", NUMBER, "-", "arc_length stops if the load factor falls to this value", -math.inf),
    Field("until", mapping(*UNTIL_FIELDS), "-", "displacement at which arc_length stops", None),
    Field("length_scale", either(NUMBER, AUTOMATIC), "m", "size of the mechanism", AUTOMATIC, positive),
    Field("newton", mapping(*STATIC_TOLERANCES), "-", "convergence criteria of an equilibrium", {}),
    Field("scale", mapping(*SCALE_FIELDS), "-", "scales of the augmented Lagrangian", {}),
)  # fmt: skip

"""Trigger of an event by command: a time, or a condition of signals, outputs and motions."""

from mecano.laws.formula import difference_of
from mecano.schema import CONDITION, NUMBER, Field, mapping

TIME = Field("time", NUMBER, "s", "time at which it happens", None)
WHEN = Field("when", CONDITION, "-", "condition on signals, outputs and motions at which it happens", None)
TRIGGER = mapping(TIME, WHEN)


def trigger_of(given):
    """Return the formula that rises through zero when the trigger with these deck values is due."""
    return f"time - ({given['time']!r})" if given["when"] is None else difference_of(given["when"])


def check_trigger(name, given):
    """Return an error for a trigger, the field ``name``, with neither or both of time and condition."""
    clear = given is None or (given["time"] is None) != (given["when"] is None)
    return [] if clear else [f"{name!r} needs either 'time' or 'when'"]

"""Phases and events shared by springs: on which side of its stops the extension of a force law is.

The law itself contains the stops, so the force does not depend on the phase; the events make time steps end where the
force has a corner.
"""

from mecano.element_interface import Event
from mecano.jit.kernel import kernel
from mecano.laws.law_table import kinks

FAR = 1e30  # [m or rad]: a stop that is never reached, for event values that must be finite
PHASES = ("below", "between", "above")
EVENTS = (
    Event(
        "lower stop closes", "between", "below", "the extension falls to the lower stop, or end of a play", elastic=True
    ),
    Event("lower stop opens", "below", "between", "the extension rises from the lower stop", elastic=True),
    Event(
        "upper stop closes", "between", "above", "the extension rises to the upper stop, or end of a play", elastic=True
    ),
    Event("upper stop opens", "above", "between", "the extension falls from the upper stop", elastic=True),
)


@kernel
def put_stop_events(g, low, high, extension):
    """Write the values of ``EVENTS`` [m or rad] to g (4,)."""
    g[0] = low - extension
    g[1] = extension - low
    g[2] = extension - high
    g[3] = high - extension


def law_record(law, context):
    """Return the values of the fields law (start in the table), low and high (stops) of a record."""
    low, high = kinks(law)
    return {"law": context.laws.add(law), "low": max(low, -FAR), "high": min(high, FAR)}

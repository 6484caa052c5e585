"""A value held between two limits, with the events at which it reaches and leaves them."""

from typing import Any

from mecano.element_interface import Event
from mecano.jit.kernel import kernel
from mecano.maths.dual import select
from mecano.schema import Values

LOWER, WITHIN, UPPER = range(3)
PHASES = "lower", "within", "upper"
NONE = 1e300  # no limit


@kernel
def limited(p, at, u):
    """Return ``u`` in the phase "within", otherwise the limit of the record p that holds it."""
    return select(at.phase == WITHIN, u, select(at.phase == UPPER, p.upper, p.lower))


@kernel
def write_distances(p, u, g):
    """Write the distances of ``u`` beyond each limit, and back from it, in the order of the events."""
    g[0], g[1] = u - p.upper, p.upper - u
    g[2], g[3] = p.lower - u, u - p.lower


def between_limits(what: str) -> dict[str, Any]:
    """Return phases and events as fields of a Kind; ``what`` reaches and leaves the limits: "the input"."""
    events = (
        Event("upper limit", "within", "upper", f"{what} rises to the upper limit"),
        Event("upper limit left", "upper", "within", f"{what} falls from the upper limit"),
        Event("lower limit", "within", "lower", f"{what} falls to the lower limit"),
        Event("lower limit left", "lower", "within", f"{what} rises from the lower limit"),
    )
    return {"phases": PHASES, "events": events, "at_start": lambda p: WITHIN}


def limits_of(d: Values) -> dict[str, float]:
    """Return the limits of the record from the deck values ``d``, where they may be infinite."""
    return {"lower": max(d["lower"], -NONE), "upper": min(d["upper"], NONE)}

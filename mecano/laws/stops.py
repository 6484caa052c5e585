r"""Stops and dead bands: no force between two extensions, an elastic force outside.

With the penetration d >= 0 of a stop, :math:`F = \mp k d (1 + \chi \dot d)`, never adhesive (Hunt & Crossley
1975): the force is continuous when contact begins, at any speed. It has a corner at the stop and, with
damping, another one where it would become adhesive.
"""

import math

from mecano.jit.kernel import kernel
from mecano.laws.term import Term
from mecano.schema import NUMBER, Field, not_negative, positive


@kernel
def stop(a, i, s, v):
    """Evaluate the term; numbers: stiffness, lower, upper, damping."""
    k, lower, upper, chi = a[i], a[i + 1], a[i + 2], a[i + 3]
    if s < lower:
        d, factor = s - lower, 1.0 - chi * v
    elif s > upper:
        d, factor = s - upper, 1.0 + chi * v
    else:
        return 0.0, 0.0, 0.0
    if factor <= 0.0:
        return 0.0, 0.0, 0.0
    return k * d * factor, k * factor, k * chi * abs(d)


@kernel
def stop_energy(a, i, s):
    """Return half the stiffness times the penetration squared."""
    d = min(s - a[i + 1], 0.0) + max(s - a[i + 2], 0.0)
    return 0.5 * a[i] * d * d


def pack_play(values):
    """Return the numbers of a stop that are those of a dead band.

    Without width the upper end is just below the lower one, so that no extension lies between them.
    """
    lower, upper = values["lower"], values["upper"]
    return [values["stiffness"], lower, upper if lower < upper else math.nextafter(lower, -math.inf), 0.0]


def lower_below_upper(values):
    """Return the error for ends in the wrong order, of stops or limits, if any."""
    return [] if values["lower"] < values["upper"] else ["'lower' must be less than 'upper'"]


def some_stop(values):
    """Check that there is at least one stop, and that two stops are in order."""
    if math.isinf(values["lower"]) and math.isinf(values["upper"]):
        return ["at least one of 'lower' and 'upper' must be given"]
    return lower_below_upper(values)


def corners(values):
    """Return both stops, except those at infinity."""
    both = ((values["lower"], -values["stiffness"]), (values["upper"], values["stiffness"]))
    return [(s, k) for s, k in both if not math.isinf(s)]


STIFFNESS = Field("stiffness", NUMBER, "N/m or N m/rad", "force per extension outside", check=positive)

STOP = Term(
    name="stop",
    doc="F = -k d (1 + damping ddot) at the lower stop, +k d (1 + damping ddot) at the upper, d the penetration; "
    "never adhesive.",
    role="force",
    fields=(
        STIFFNESS,
        Field("lower", NUMBER, "m or rad", "extension of the lower stop; none when absent", -math.inf),
        Field("upper", NUMBER, "m or rad", "extension of the upper stop; none when absent", math.inf),
        Field("damping", NUMBER, "s/m or s/rad", "damping relative to the elastic force", 0.0, not_negative),
    ),
    evaluate=stop, integral=stop_energy,
    check=some_stop,
    stops=corners,
)  # fmt: skip

DEAD_BAND = Term(
    name="dead_band",
    doc="F = 0 from 'lower' to 'upper', F = stiffness times the excess outside: a spring with free play, "
    "which may have no width.",
    role="force",
    fields=(
        STIFFNESS,
        Field("lower", NUMBER, "m or rad", "extension at which the free play begins"),
        Field("upper", NUMBER, "m or rad", "extension at which the free play ends"),
    ),
    pack=pack_play,
    evaluate=stop, integral=stop_energy,
    check=lambda values: (
        [] if values["lower"] <= values["upper"] else ["'lower' must not be greater than 'upper'"]
    ),
    stops=lambda values: corners(values) if values["lower"] < values["upper"] else [],
)  # fmt: skip

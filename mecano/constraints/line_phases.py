"""Phases and events shared by lines that only pull: taut, relaxing and slack.

A line with damping goes slack when it would push, while it is still longer than its natural length. Until it reaches
this length it is relaxing: the remaining elastic energy is dissipated. The dissipated power vanishes there with a
corner, so the end is an event, at which a time step ends.

The viscous tension is at most as large as the elastic one. So the tension is a continuous function of strain and rate,
which grows with both: an implicit step has one solution, whatever the phases. With a viscous tension that jumps where
the line becomes taut, none would exist in a step longer than mass over damping: slack the line would be too long at its
end, taut too short.
"""

from mecano.constraints.stop_phases import FAR
from mecano.element_interface import Event
from mecano.jit.kernel import kernel
from mecano.maths.dual import at_least, select

TAUT, RELAXING, SLACK = range(3)
PHASES = ("taut", "relaxing", "slack")
EVENTS = (
    Event("goes taut", "slack", "taut", "the length rises to the natural length", elastic=True, brief=True),
    Event("goes taut", "relaxing", "taut", "the damped tension rises from zero again", elastic=True),
    Event("goes slack", "taut", "slack", "the tension falls to zero", elastic=True, one_sided=True),
    Event("goes slack", "taut", "relaxing", "the same, with damping, above the natural length", elastic=True,
          one_sided=True),
    Event("is relaxed", "relaxing", "slack", "the length falls to the natural length", elastic=True),
)  # fmt: skip


def is_damped(p):
    """Return which lines of a record (n,) have damping, (n,) bool."""
    return p["damping"] != 0.0


@kernel
def follows(p, at):
    """Return whether the tension of a line follows from its strain and rate alone, in any of ``PHASES``."""
    return p.damping != 0.0 and at.phase <= SLACK


@kernel
def pulled(p, at, strain, strain_rate):
    """Return the strains of ``pulling`` of a line in one of ``PHASES``, or in another, in which it does not act."""
    return pulling(at.phase == TAUT, follows(p, at), strain, strain_rate, p.damping)


@kernel
def pulling(is_taut, follows, strain, strain_rate, damping):
    """Return two strains of a line: times its stiffness they are its elastic tension and its tension.

    The viscous tension is at most as large as the elastic one. A line that is neither taut nor ``follows`` has none.
    """
    tension, twice = strain + damping * strain_rate, 2.0 * strain
    low, high = select(strain < 0.0, twice, 0.0), select(strain < 0.0, 0.0, twice)
    if damping != 0.0:
        tension = select(tension > high, high, select(tension < low, low, tension))
    elastic = select(is_taut or follows and strain > 0.0, strain, 0.0)
    return elastic, select(is_taut, tension, select(follows, at_least(tension, 0.0), 0.0))


@kernel
def put_line_events(g, is_taut, strain, strain_rate, damping):
    """Write the values of ``EVENTS`` [the unit of the strain] to g: the tension follows the smaller of two strains.

    A line that was not taut and is activated shorter than its natural length is slack at once.
    """
    taut = min(strain, strain + damping * strain_rate)
    g[0] = g[1] = taut
    relaxes = damping != 0.0 and (is_taut or strain > 0.0)
    g[2], g[3] = (-FAR, -taut) if relaxes else (-taut, -FAR)
    g[4] = -strain

"""Phases and events shared by lines that only pull: taut, relaxing and slack.

A line with damping goes slack when it would push, while it is still longer than its natural length. Until it reaches
this length it is relaxing: the remaining elastic energy is dissipated. The dissipated power vanishes there with a
corner, so the end is an event, at which a time step ends.
"""

from mecano.constraints.stop_phases import FAR
from mecano.element_interface import Event
from mecano.jit.kernel import kernel

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

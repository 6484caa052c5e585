"""End of a run by a condition: the event at which the time integration stops (``time.until``)."""

from mecano.element_interface import Event, Kind
from mecano.jit.kernel import kernel
from mecano.laws.formula import difference_of


@kernel
def residual(p, at, f):
    """Add nothing: it only reads its input."""


@kernel
def event_values(p, at, g):
    """Write the number that rises through zero where the condition becomes true."""
    g[0] = at.q[0]


RUN_END = Kind(
    name="time", doc="The condition at which a run ends.",
    inputs=("condition",),
    reads=lambda d: [difference_of(d["until"])],
    phases=("running", "ended"),
    events=(Event("ends the run", "running", "ended", "the condition becomes true", condition=True, ends_run=True),),
    residual=residual, event_values=event_values,
)  # fmt: skip

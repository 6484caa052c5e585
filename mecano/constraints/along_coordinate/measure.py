"""Outputs of joints of two nodes: motions about and along an axis, reactions.

Local unknowns x0, R0, x1, R1; the record has AXES_FIELDS (pair.py). Functions ``put(p, at, F, y, i)`` write outputs
starting at y[i]; the other arguments are those of ``observe``.
"""

from collections.abc import Callable
from dataclasses import field

from mecano.constraints.body_fixed import follow
from mecano.constraints.coordinates.slide import SLIDE, slide
from mecano.constraints.coordinates.twist import TWIST, turned
from mecano.element_interface import Measured, Output
from mecano.immutable import immutable
from mecano.jit.kernel import kernel
from mecano.maths.vector import vec

OVER_TURNS = "rotation of b relative to a about the axis since the start, over any number of turns"


@immutable
class Outputs:
    """Outputs of a joint that belong together, and the compiled function that writes them."""

    declared: tuple  # of Output
    put: Callable  # (p, at, F, y, i): write them starting at y[i]
    memory: tuple = ()  # names of the values that they keep from step to step
    commit: Callable | None = None
    measures: dict = field(default_factory=dict)  # {output: place of the joint (pair.py) -> Measured}

    @property
    def size(self):
        """Number of values, the components of vectors counted."""
        return sum(output.shape[0] if output.shape else 1 for output in self.declared)


def angle_outputs(doc, end=""):
    """Return the Outputs of an angle, which ``doc`` describes, and of its rate; ``end`` ends both names."""
    of = f"angle{end}" if end else "the angle"
    return Output(f"angle{end}", "rad", doc, rate=f"rate{end}"), Output(f"rate{end}", "rad/s", f"rate of {of}")


@kernel
def _put_turning(p, at, F, y, i):
    angle, y[i + 1] = turned(p, at)
    y[i] = follow(at.m[0], angle)


@kernel
def put_sliding(p, at, F, y, i):
    """Write the outputs of ``SLIDING``."""
    along, y[i + 1] = slide(at, vec(p.mu[2], 0))
    y[i] = along - p.start[2]


@kernel
def put_translation(p, at, F, y, i):
    """Write the outputs of ``translation``."""
    for j in range(3):
        along, y[i + 3 + j] = slide(at, vec(p.mu[j], 0))
        y[i + j] = along - p.start[j]


@kernel
def _follow_turning(p, at, m_out):
    """Continue the angle over whole turns."""
    m_out[0] = follow(at.m[0], turned(p, at)[0])


TURNING = Outputs(
    angle_outputs(OVER_TURNS), _put_turning, ("angle",), _follow_turning,
    {"angle": lambda place: Measured(TWIST, (0, 1), {"mu": place["mu"], "xi": place["xi"]})},
)  # fmt: skip
SLIDING = Outputs(
    (
        Output("displacement", "m", "sliding of b relative to a along the axis since the start", rate="velocity"),
        Output("velocity", "m/s", "rate of the displacement"),
    ),
    put_sliding,
    measures={"displacement": lambda place: Measured(SLIDE, (0, 1), {"mu": place["mu"][2]}, place["start"][2])},
)


def translation(along):
    """Return the Outputs of the sliding along three axes, which ``along`` names."""
    doc = f"sliding of b relative to a along {along} since the start"
    return Outputs(
        (
            Output("displacement", "m", doc, (3,), rate="velocity"),
            Output("velocity", "m/s", "rate of the displacement", (3,)),
        ),
        put_translation,
    )


MOMENT = Output("moment", "N m", "moment of a on b at node b, about mu_1, mu_2 and the axis", (3,))
REACTIONS = (Output("force", "N", "force of a on b along mu_1, mu_2 and the axis", (3,)), MOMENT)

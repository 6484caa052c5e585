r"""Rigid rod: two nodes keep their distance, :math:`|x_b - x_a| = L`; both ends rotate freely."""

from mecano.constraints.joint_nodes import ENDS, check_apart, distance
from mecano.constraints.of_coordinates import SAME_DISTANCE
from mecano.constraints.release import RELEASE, check_release, releasable
from mecano.element_interface import Display, Kind, Output, Part, named
from mecano.jit.kernel import kernel
from mecano.maths.vector import norm, vec
from mecano.schema import NUMBER, Field, positive


def _observed(multiplier):
    """Return ``observe``; ``multiplier`` is the local index of that of the rod."""

    @kernel
    def observe(p, at, F, y, e):
        """Write tension and length."""
        y[0] = -at.q[multiplier]
        y[1] = norm(vec(at.q, 3) - vec(at.q, 0))

    return observe


def parts(d, nodes, context):
    """Return the Part of one distance."""
    return [Part(SAME_DISTANCE, (0, 1), {"offset": distance(nodes) if d["length"] is None else d["length"]})]


RIGID_ROD = Kind(
    name="rigid_rod", section="joints", doc=__doc__, display=Display("line"), layout=("x0", "x1"),
    fields=(
        ENDS,
        Field("length", NUMBER, "m", "length; the distance at the start when not given", None, check=positive),
        RELEASE,
    ),
    outputs=(
        Output("tension", "N", "force in the rod, positive when it pulls its ends together"),
        Output("length", "m", "distance of the nodes", geometric=True),
    ),
    check=lambda d, nodes: check_apart(d, nodes) + check_release(d, ()),
    cases=({"length": None}, {"length": 1.3}),
    variant=lambda d: RELEASED_ROD if d["release"] else RIGID_ROD,
    observe=_observed(6),
    **named(parts),
)  # fmt: skip
RELEASED_ROD = releasable(RIGID_ROD, observe=_observed(7))

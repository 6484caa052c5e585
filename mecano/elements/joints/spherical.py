"""Spherical joint: two nodes share one position and rotate freely (Boolean identification: no equation).

With ``friction``, the force is that of three multipliers, and no unknowns are shared.
"""

from dataclasses import replace

import numpy as np

from mecano.constraints.along_coordinate.friction import check_friction, friction_fields, friction_record, radius
from mecano.constraints.ball_friction import BALL_FRICTION
from mecano.constraints.joint_nodes import NODES, check_one_place, one_position
from mecano.constraints.joint_samples import FALLING
from mecano.constraints.release import RELEASE, SAMPLE, check_release, releasable
from mecano.constraints.rigid_offset import RIGID_OFFSET
from mecano.element_interface import Display, Kind, Output, Part, nothing
from mecano.jit.kernel import kernel
from mecano.maths.vector import put, vec


@kernel
def observe(p, at, F, y, e):
    """Write the reaction."""
    put(y, 0, -vec(F, 3))


def _held(first):
    """Return ``observe`` for three multipliers from the local index ``first`` on."""

    @kernel
    def observe(p, at, F, y, e):
        """Write the reaction."""
        put(y, 0, vec(at.q, first))

    return observe


def parts_held(d, nodes, context):
    """Return the Parts of three multipliers, and of the friction that they drive, if any."""
    found = [Part(RIGID_OFFSET, (0, 1), {"d": np.zeros(3)})]
    if d["friction"]:
        values = friction_record(d["friction"], context, BALL_FRICTION.dtype.names)
        found.append(Part(BALL_FRICTION, (0, 1), values, coupled_to=(0,)))
    return found


SPHERICAL_HELD = Kind(
    name="spherical_held", section="joints", doc=__doc__, display=Display(force="force"), layout=("x0", "x1"),
    fields=(
        NODES,
        friction_fields(radius("radius", "radius of the ball")),
        RELEASE,
    ),
    outputs=(Output("force", "N", "force of a on b, inertial axes", (3,)),),
    optional=(("friction", BALL_FRICTION, ""),),
    parts=parts_held,
    observe=_held(6),
    variant=lambda d: RELEASED if d["release"] else SPHERICAL_HELD if d["friction"] else SPHERICAL,
    check=lambda d, nodes: check_one_place(d, nodes) + check_friction(d) + check_release(d, ("friction",)),
    holds=lambda d: () if d["release"] else ("along_1", "along_2", "along_axis"),
    cases=(
        {},
        SAMPLE,
        *({"friction": {"coefficient": FALLING, "regularization": u, "radius": 0.3}} for u in (0.2, 50.0)),
    ),
)  # fmt: skip

SPHERICAL = replace(
    SPHERICAL_HELD, name="spherical", shares=one_position, parts=nothing, observe=observe, hidden={"force": ""},
    revealed=SPHERICAL_HELD,
)  # fmt: skip
RELEASED = releasable(SPHERICAL_HELD, observe=_held(7))

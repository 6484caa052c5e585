"""Held rotation: two nodes share their rotation, and move freely in position (Boolean identification: no equation).

With ground as the first node, the second one can only translate; the moment of the joint is the reaction.
"""

from mecano.constraints.joint_nodes import check_one_rotation, one_rotation
from mecano.element_interface import Display, Kind, Output
from mecano.jit.kernel import kernel
from mecano.maths.vector import mat, put, vec
from mecano.schema import NODE_PAIR, Field


@kernel
def observe(p, at, F, y, e):
    """Write the reaction."""
    put(y, 0, -(mat(at.R[1]) @ vec(F, 3)))


HELD_ROTATION = Kind(
    name="held_rotation", section="joints", doc=__doc__, display=Display("nothing"), layout=("R0", "R1"),
    fields=(Field("nodes", NODE_PAIR, "-", "nodes a and b, usually [ground, the node that must not rotate]"),),
    outputs=(Output("moment", "N m", "moment of a on b, inertial axes", (3,)),),
    shares=one_rotation,
    check=check_one_rotation,
    hidden={"moment": "use a 'generic' joint with free: [along_1, along_2, along_axis]"},
    observe=observe,
)  # fmt: skip

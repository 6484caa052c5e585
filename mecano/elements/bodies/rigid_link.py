r"""Rigid link: a massless rigid arm between two nodes.

With the initial arm d, material:

.. math::  x_f - x_m - R_m d = 0

The follower shares the rotation of the master (Boolean identification); a follower with another initial orientation is
held by three constraints.
"""

from mecano.constraints.attachment import attached_rotations, attachment, is_marker
from mecano.constraints.joint_samples import at_distance, two_places
from mecano.element_interface import Display, Kind, Output, record
from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.maths.vector import Vec3, mat, put, vec
from mecano.schema import NODE_PAIR, Field

RECORD = record(turned=())  # 1: three multipliers hold the rotation, in the axes of the master
FORCE, MOMENT = 12, 15  # in q


@kernel
def observe(p, at, F, y, e):
    """Write the reactions on the follower."""
    put(y, 0, vec(at.q, FORCE))
    if p.turned > 0.0:
        put(y, 3, mat(at.R[0]) @ Vec3(-number(at.q[MOMENT + 1]), number(at.q[MOMENT]), number(at.q[MOMENT + 2])))
    else:
        put(y, 3, -(mat(at.R[1]) @ vec(F, 9)))


RIGID_LINK = Kind(
    name="rigid_link", section="elements", doc=__doc__, display=Display(pictures=("reactions",), force="force"),
    dtype=RECORD, layout=("x0", "R0", "x1", "R1"),
    fields=(Field("nodes", NODE_PAIR, "-", "master and follower"),),
    outputs=(
        Output("force", "N", "force of the link on the follower, inertial axes", (3,)),
        Output("moment", "N m", "moment of the link on the follower, inertial axes", (3,)),
    ),
    shares=attached_rotations,
    hidden={"moment": "use a 'generic' joint, which holds the second node in its initial place"},
    prepare=lambda d, nodes, context: {"turned": float(is_marker(nodes, 1))},
    parts=lambda d, nodes, context: attachment(nodes, 1, context),
    sample=lambda rng: [({}, nodes, "") for nodes in (two_places(rng), at_distance(rng, 1.2))],
    observe=observe,
)  # fmt: skip

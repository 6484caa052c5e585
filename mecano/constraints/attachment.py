"""Attachment of nodes that move as if welded to a first one.

A node with the initial rotation of the first one shares its rotation (Boolean identification). A node with an
orientation of its own, a marker, is held by three constraints between the axes of both. Positions are held by a rigid
offset.
"""

from dataclasses import replace

import numpy as np

from mecano.constraints.joint_nodes import ANGLE, turn_between
from mecano.constraints.pair import pair_parts
from mecano.constraints.rigid_offset import RIGID_OFFSET
from mecano.element_interface import Part

TURNS = ("about_2", "about_1", "about_axis")


def attached_rotations(d, nodes):
    """Return the ``shares`` of nodes attached to the first: the rotations of those with the same initial rotation."""
    return [("R", 0, i) for i in range(1, len(nodes)) if not is_marker(nodes, i)]


def attachment(nodes, i, context):
    """Return the Parts that attach node i to the first one: an offset, and for a marker the three rotations."""
    x, R = nodes[0]
    parts = [Part(RIGID_OFFSET, (0, i), {"d": R.T @ np.subtract(nodes[i][0], x)})]
    if is_marker(nodes, i):
        place = {"mu": np.eye(3), "xi": R.T @ nodes[i][1], "start": np.zeros(3)}
        parts += [replace(part, nodes=(0, i)) for part in pair_parts(place, TURNS, None, context)]
    return parts


def is_marker(nodes, i):
    """Return whether the initial rotation of node i differs from that of the first one."""
    return bool(turn_between(nodes[0], nodes[i]) > ANGLE)

"""What the rigid wheels have in common: deck fields, outputs, records of the constraints that they are made of."""

import numpy as np
from numba import njit

from mecano.constraints.ground import LEAN, prepare_ground
from mecano.contract import Output
from mecano.maths.vec import add, add_vec, norm, put, scale, vec
from mecano.schema import DIRECTION, GROUND, NODE, NUMBER, Field, positive

FIELDS = (
    Field("node", NODE, "-", "centre of the wheel; its rotation spins with the wheel"),
    Field("radius", NUMBER, "m", "radius", check=positive),
    Field("axis", DIRECTION, "-", "spin axis at the start, inertial; rolling forward turns right-handed"),
    Field("ground", GROUND, "-", "ground it rolls on"),
)
OUTPUTS = (
    Output("height", "m", "height of the centre over the ground, along the normal at the contact"),
    Output("loaded_radius", "m", "distance from the centre to the contact; the radius when in the air"),
    Output("normal_force", "N", "normal force N of the ground on the wheel"),
    Output("longitudinal_force", "N", "force of the ground on the wheel along t = a x n/|a x n|"),
    Output("lateral_force", "N", "force of the ground on the wheel along l = n x t (upright: the axis)"),
    Output("contact_force", "N", "force of the ground on the wheel, inertial", (3,)),
    Output("friction_needed", "-", "tangential over normal force: the least friction with which it does not slip"),
    Output("spin_rate", "rad/s", "angular velocity of the wheel along its axis"),
    Output("contact_point", "m", "contact, inertial; in the air, the lowest point of the rim", (3,)),
    LEAN,
)


def carried_axis(d, nodes):
    """The unit axis of the deck in the axes of the first node."""
    axis = np.asarray(nodes[0][1], float).T @ np.asarray(d["axis"], float)
    return axis / np.linalg.norm(axis)


def disc_record(d, nodes, context):
    """Values of axis, radius and ground for the basic constraints."""
    return {"axis": carried_axis(d, nodes), "radius": d["radius"], **prepare_ground(d["ground"], context)}


@njit
def put_outputs(y, q, N, driving, lateral, frame, height, arm, spin, lean):
    """Write OUTPUTS: forces [N] along the ``frame`` (n, t, l), height [m], arm of the contact (3,), spin rate, lean."""
    n, t, l = frame
    y[0] = height
    y[1] = norm(arm)
    y[2] = N
    y[3] = driving
    y[4] = lateral
    put(y, 5, add(scale(N, n), add(scale(driving, t), scale(lateral, l))))
    y[8] = norm((driving, lateral, 0.0)) / N if N > 0.0 else 0.0
    y[9] = spin
    put(y, 10, vec(q, 0))
    add_vec(y, 10, 1.0, arm)
    y[13] = lean

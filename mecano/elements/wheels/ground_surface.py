"""Surface of a ground: a friction factor that varies along it, and a motion in its plane.

The factor on the friction is a curve of the distance along a direction (a wet or icy runway). A flat ground may move
along a direction in its plane (a belt) and rotate about its normal (a turntable), at rates that are functions of time.
Its material at the contact C has the velocity

    v_g = speed(t) d + rate(t) n x (C - centre)
"""

from typing import NamedTuple

import numpy as np

from mecano.constraints.ground import in_plane
from mecano.constraints.triads import unit
from mecano.jit.kernel import kernel
from mecano.laws.law_table import curve
from mecano.laws.probe import negative_curves
from mecano.maths.dual import at_least, constant
from mecano.maths.vector import cross, dot, vec

SURFACE_RECORD = {
    "grip": "i", "grip_direction": 3, "moves": (), "belt": "i", "belt_direction": 3, "turn": "i", "centre": 3,
}  # fmt: skip


class Surface(NamedTuple):
    """The ground at a contact; 3-vectors in the inertial frame."""

    grip: float  # factor on the friction
    v: tuple  # velocity of its material [m/s]
    omega: tuple  # its angular velocity [rad/s]


def prepare_surface(ground, context):
    """Return the values of SURFACE_RECORD that are not zero."""
    normal, motion, friction = unit(ground["plane"]["normal"]), ground.get("motion"), ground.get("friction")
    values = {}
    if friction:
        direction = unit(in_plane(friction["direction"], normal))
        values |= {"grip": context.laws.add(friction["factor"]), "grip_direction": direction}
    if motion:
        values |= {"moves": 1.0, "belt": context.laws.add(motion["speed"]), "turn": context.laws.add(motion["rate"])}
        if motion["direction"] is not None:
            values["belt_direction"] = unit(in_plane(motion["direction"], normal))
    centre = motion["centre"] if motion and motion["centre"] is not None else ground["plane"]["point"]
    return {**values, "centre": np.array(centre, float)}


def check_surface(ground):
    """Return errors for a friction factor or a motion out of the plane, or incompatible with other values."""
    motion, friction, normal = ground.get("motion"), ground.get("friction"), unit(ground["plane"]["normal"])
    texts = []
    if friction and np.linalg.norm(in_plane(friction["direction"], normal)) < OUT_OF_PLANE:
        texts.append("'ground.friction.direction' is along the normal of the plane; it must lie in the plane")
    texts += negative_curves("ground.friction", {"factor": friction["factor"]}) if friction else []
    if not motion:
        return texts
    if motion["speed"] is None and motion["rate"] is None:
        texts.append("'ground.motion' needs 'speed' or 'rate'")
    if ground.get("profile"):
        texts.append("'ground.motion' requires a flat ground: remove 'profile'")
    direction = motion["direction"]
    if direction is not None and np.linalg.norm(in_plane(direction, normal)) < OUT_OF_PLANE:
        texts.append("'ground.motion.direction' is along the normal of the plane; it must lie in the plane")
    if direction is None and motion["speed"] is not None:
        texts.append("'ground.motion.direction' is missing: the direction of 'speed'")
    return texts


OUT_OF_PLANE = 1e-6


@kernel
def surface_at(p, at, n, x):
    """Return the Surface at the point x (3,) of the ground with the normal n; p has SURFACE_RECORD, GROUND_RECORD."""
    along = dot(vec(p.grip_direction, 0), x - vec(p.point, 0))
    grip = constant(1.0, along)
    if p.grip > 0:
        grip = at_least(curve(at.laws, p.grip, along), 0.0)
    omega = p.moves * curve(at.laws, p.turn, at.t) * n
    v = p.moves * curve(at.laws, p.belt, at.t) * vec(p.belt_direction, 0) + cross(omega, x - vec(p.centre, 0))
    return Surface(grip, v, omega)

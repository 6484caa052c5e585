"""Values and nodes shared by the samples of elements and joints for the generic tests."""

import numpy as np

SPRUNG = (("spring", {"stiffness": 3.0}), ("damper_polynomial", {"coefficients": [0.0, 2.0, 0.0, 1.0]}))
FALLING = (("exponential", {"start": 0.5, "limit": 0.3, "rate": 0.1, "origin": 0.0}),)
PLAY = (("dead_band", {"stiffness": 9.0, "lower": -0.01, "upper": 0.02}), ("damper", {"coefficient": 0.3}))
TURNING_SPRUNG = {"turning_law": SPRUNG, "natural_angle": 0.2}
AXIS_1 = (0.3, -1.0, 0.5)
RUBBING = {"coefficient": FALLING, "regularization": 0.2, "length": 0.7}
STICKING = {"coefficient": FALLING, "regularization": 50.0, "length": None}
SLIDE_STOPPED = {
    "latch": {"displacement": -0.5, "release": None},
    "lock": {"while": "time > 0.3"},
    "stops": {"lower": -1.0, "upper": 2.0, "restitution": 0.4},
}
ORIENTATIONS = np.eye(3), np.diag([-1.0, 1.0, -1.0])


def two_places(rng):
    """Return two nodes (x (3,), R (3, 3)) at different positions, rotated relative to each other."""
    return [(rng.normal(size=3), R) for R in ORIENTATIONS]


def at_distance(rng, length):
    """Return two nodes at this distance in a random direction, without rotation."""
    x, direction = rng.normal(size=(2, 3))
    return [(x, np.eye(3)), (x + length * direction / np.linalg.norm(direction), np.eye(3))]


def rotation(rng):
    """Return a random rotation (3, 3)."""
    Q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return Q * np.linalg.det(Q)

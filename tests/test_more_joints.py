"""Planar joint, screw, gears, rack and pinion: their decks of inputs/ against closed forms, and what they refuse."""

import numpy as np
from marching import March, input_deck


def close(value, expected, size=1.0):
    """A motion with constant accelerations is integrated without error: only the tolerance of Newton is left."""
    np.testing.assert_allclose(value, expected, rtol=1e-6, atol=1e-6 * size)


def test_puck_slides_and_turns_on_a_slope():
    """Constant acceleration g sin(30 deg) down the slope, pressed by m g cos(30 deg), over six turns."""
    march = March(input_deck("planar_slide"))
    t, slope = march.time, "joints/slope"
    close(march[f"{slope}/displacement"][:, 0], 0.25 * 9.81 * t**2)
    close(march[f"{slope}/displacement"][:, 1], t)
    close(march[f"{slope}/velocity"][:, 0], 0.5 * 9.81 * t)
    close(march[f"{slope}/angle"], 20.0 * t)
    close(march[f"{slope}/force"], 2.0 * 9.81 * np.cos(np.pi / 6))
    close(march[f"{slope}/moment"], 0.0, 2.0)


def test_screw_is_driven_by_its_moment():
    """In the nut 2 N m act on J = 0.01 kg m2 and, by the pitch, on the load of 50 kg: J + m h^2, h = P/(2 pi)."""
    march = March(input_deck("screw_jack"))
    t, jack, h = march.time, "joints/jack", 0.02 / (2.0 * np.pi)
    thrust = 50.0 * 9.81
    acceleration = (2.0 - thrust * h) / (0.01 + 50.0 * h**2)
    close(march[f"{jack}/angle"], 0.5 * acceleration * t**2, 10.0)
    close(march[f"{jack}/displacement"], 0.5 * h * acceleration * t**2, 0.1)
    close(march[f"{jack}/rate"], acceleration * t, 10.0)
    force = thrust + 50.0 * h * acceleration
    close(march[f"{jack}/force"][:, 2], force)
    close(march[f"{jack}/moment"][:, 2], -h * force)
    assert march[f"{jack}/angle"][-1] > 4.0 * np.pi

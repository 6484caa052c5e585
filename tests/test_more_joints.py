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
    close(march[f"{slope}/displacement_1"], 0.25 * 9.81 * t**2)
    close(march[f"{slope}/displacement_2"], t)
    close(march[f"{slope}/velocity_1"], 0.5 * 9.81 * t)
    close(march[f"{slope}/angle"], 20.0 * t)
    close(march[f"{slope}/force"], 2.0 * 9.81 * np.cos(np.pi / 6))
    close(march[f"{slope}/moment"], 0.0, 2.0)

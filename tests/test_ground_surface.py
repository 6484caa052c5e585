"""Grounds whose friction differs along the way, and grounds that move: belts and turntables."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from time_runs import INPUTS, RecordedRun, deck, input_deck

from mecano.errors import DeckError

SLIDING = (INPUTS / "icy_runway.yaml").read_text()


def test_a_locked_wheel_slides_from_dry_ground_onto_ice(verify):
    """m v dv/dx = -mu f(x) m g: v^2 = v_0^2 - 2 mu g times the integral of the factor f."""
    recorded = RecordedRun(input_deck("icy_runway"))
    x, v = recorded["nodes/hub/position"][:, 0], recorded["nodes/hub/velocity"][:, 0]
    factor = lambda s: np.interp(s, [0.0, 4.0, 6.0, 12.0, 14.0], [1.0, 1.0, 0.15, 0.15, 0.6])  # noqa: E731
    way = np.array([quad(factor, 0.0, s, points=[4, 6, 12, 14], limit=100)[0] for s in x[::100]])
    expected = np.sqrt(15.0**2 - 2.0 * 0.8 * 9.81 * way)
    assert x[-1] > 14.0
    verify("Tyres", "a locked wheel slides onto ice and off it: speed [m/s]", v[::100], expected,
           "v^2 = v_0^2 - 2 mu g integral of the factor", relative=1e-5)  # fmt: skip
    np.testing.assert_allclose(
        recorded["elements/tire/friction_coefficient"].ravel()[1:], 0.8 * factor(x[1:]), rtol=1e-6
    )


TURNING = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {{axle: {{position: [2, 0, 0.29]}}, hub: {{position: [2, 0, 0.29]}}}}
    elements:
      body: {{type: rigid_body, node: hub, mass: 100.0, inertia: [1, 2, 1]}}
      tire: {{type: wheel, node: hub, axis: {axis}, tire_law: rubber, ground: table}}
    joints:
      level: {{type: held_rotation, nodes: [ground, axle]}}
      place: {{type: prescribed_position, node: axle, direction: [1, 0, 0], value: 0.0}}
      side: {{type: prescribed_position, node: axle, direction: [0, 1, 0], value: 0.0}}
      bearing: {{type: hinge, nodes: [axle, hub], axis: {axis}}}
    tire_laws:
      rubber: {{radius: 0.3, radial: {{linear: {{slope: 98.1 kN/m}}}}, {law}}}
    grounds:
      table: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}, motion: {motion}}}
    time: {{end: 2.0, step: 1.0e-3}}
"""


def spun(axis, law, motion):
    """A wheel that may spin about ``axis`` and rise, 2 m from the origin, on a ground with a ``motion``."""
    return RecordedRun(deck(TURNING.format(axis=axis, law=law, motion=motion)))


FRICTION = "friction: 0.8, slip_regularization: 1.0e-3"


def test_a_belt_spins_a_wheel_up():
    """The belt runs back at 6 m/s under a wheel that stands: it slides, then turns with that speed over its radius."""
    recorded = spun("[0, 1, 0]", FRICTION, "{direction: [-1, 0, 0], speed: 6.0}")
    spin, time = recorded["elements/tire/spin_rate"].ravel(), recorded.time
    sliding = 6.0 / 0.29 * 2.0 / (0.8 * 981.0 * 0.29)  # inertia times rate over the moment of friction
    early = time < 0.95 * sliding
    np.testing.assert_allclose(spin[early], 0.8 * 981.0 * 0.29 / 2.0 * time[early], rtol=1e-6, atol=1e-9)
    assert spin[-1] == pytest.approx(6.0 / 0.29, rel=1e-6)
    given, lost = recorded["energy/given"][-1], recorded["energy/dissipated"][-1]
    assert given == pytest.approx(2.0 * lost, rel=1e-5)  # half of the work of the belt is lost in sliding
    assert np.ptp(recorded["energy/balance"]) < 1e-3 * given


def test_a_turntable_turns_a_wheel_on_it():
    """At 2 m from its centre the table moves with rate x 2 m: a wheel whose plane is tangential rolls with it."""
    recorded = spun("[1, 0, 0]", FRICTION, "{rate: 1.5}")
    assert recorded["elements/tire/spin_rate"][-1] == pytest.approx(1.5 * 2.0 / 0.29, rel=1e-6)
    offset = spun("[1, 0, 0]", FRICTION, "{rate: 1.5, centre: [1.0, 0, 0]}")
    assert offset["elements/tire/spin_rate"][-1] == pytest.approx(1.5 / 0.29, rel=1e-6)


def test_a_tilted_wheel_on_a_belt_has_the_force_of_the_slip_angle():
    """As on inputs/fiala_sweep.yaml, but the ground moves instead of the wheel."""
    alpha, C, mu_N = 0.05, 6e4, 0.8 * 981.0
    axis = f"[{-math.sin(alpha)!r}, {math.cos(alpha)!r}, 0]"
    recorded = spun(axis, "fiala: {cornering_stiffness: 6.0e3, friction: 0.8}", "{direction: [-1, 0, 0], speed: 20.0}")
    z = 0.1 * C * np.tan(alpha)
    closed = z - z**2 / (3 * mu_N) + z**3 / (27 * mu_N**2)
    assert abs(recorded["elements/tire/lateral_force"][-1]) == pytest.approx(closed, rel=1e-4)
    assert abs(recorded["elements/tire/slip_angle"][-1]) == pytest.approx(alpha, rel=1e-4)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("direction: [1, 0, 0], factor", "direction: [0, 0, 1], factor", "'ground.friction.direction' is along"),
        ("friction: {direction", "motion: {speed: 3}\n    friction: {direction", "'ground.motion.direction' is"),
        ("factor: wetness", "factor: -0.5", "'ground.friction.factor' must not be negative"),
        ("friction: {direction", "motion: {}\n    friction: {direction", "'ground.motion' needs 'speed' or 'rate'"),
        ("friction: {direction", "motion: {rate: 3}\n    profile: {direction: [1, 0, 0], height: 0}\n"
         "    friction: {direction", "'ground.motion' requires a flat ground"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_a_surface(old, new, said):
    assert SLIDING.count(old) == 1
    with pytest.raises(DeckError) as error:
        deck(SLIDING.replace(old, new))
    assert said in str(error.value)

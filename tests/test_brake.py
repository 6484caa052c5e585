"""The brake of a wheel: bounds by speed, by the load on its tyre and by its slip; refused input."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from time_runs import RecordedRun, deck

from mecano.errors import DeckError

MASS, SPIN_INERTIA, SPEED, GRAVITY = 100.0, 0.4, 30.0, 9.81
DECK = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      leg: {{position: [0, 0, 0.3]}}
      hub: {{position: [0, 0, 0.3]}}
    elements:
      load: {{type: rigid_body, node: leg, mass: 90, inertia: [10, 10, 10]}}
      rim: {{type: rigid_body, node: hub, mass: 10, inertia: [0.2, 0.4, 0.2]}}
      tire: {{type: wheel, node: hub, axis: [0, 1, 0], tire_law: rubber, ground: road}}
    joints:
      upright: {{type: held_rotation, nodes: [ground, leg]}}
      bearing: {{type: hinge, nodes: [leg, hub], axis: [0, 1, 0]}}
    loads:
      brake: {{type: brake, nodes: {nodes}, axis: {axis}, torque: {torque}, {bound}}}
    tire_laws:
      rubber:
        radius: 0.301
        radial: {{linear: {{slope: 9.81e5}}}} # 981 N at 1 mm
        friction: 0.8
        friction_by_speed: {{exponential: {{start: 1.0, rate: 0.02}}}}
        slip_regularization: 0.05
        radial_damping: 1.0
    grounds:
      road: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}
    initial:
      velocities:
        - {{nodes: all, velocity: [30, 0, 0]}}
        - {{nodes: [hub], angular_velocity: [0, 100, 0]}}
    time: {{end: {end}, step: 2.0e-3, rho_inf: 0.5}}
"""


def braked(bound, torque="1.0e9", nodes="[leg, hub]", axis="[0, 1, 0]", end=1.0):
    return deck(DECK.format(bound=bound, torque=torque, nodes=nodes, axis=axis, end=end))


def test_a_brake_bound_by_the_load_of_its_tire_does_not_skid():
    """(m + I/r^2) v' = -0.9 mu_0 exp(-kappa v) m g; of the smaller of both 1 - s^2 is left for a huge torque."""
    recorded = RecordedRun(braked("wheel: tire, adhesion: {exponential: {start: 0.72, rate: 0.02}}"))
    drive = (1 - 0.02**2) * 0.72 * GRAVITY * MASS / (MASS + SPIN_INERTIA / 0.3**2)
    speed, later = recorded["nodes/hub/velocity"][:, 0], recorded.time > 0.1  # the wheel has settled to its creep
    time, fast = recorded.time[later] - recorded.time[later][0], speed[later][0]
    expected = np.log(math.exp(0.02 * fast) - 0.02 * drive * time) / 0.02
    np.testing.assert_allclose(speed[later], expected, rtol=1e-6)
    assert np.abs(recorded["elements/tire/longitudinal_slip"][later]).max() < 0.05
    bound = recorded["loads/brake/bound"]
    np.testing.assert_allclose(bound[-1], 0.72 * math.exp(-0.02 * expected[-1]) * MASS * GRAVITY * 0.3, rtol=1e-8)


def test_the_same_torque_without_a_bound_locks_the_wheel():
    recorded = RecordedRun(braked("bound: null", torque="400", end=0.5))
    assert abs(recorded["elements/tire/spin_rate"][-1]) < 0.1 and recorded["nodes/hub/velocity"][-1, 0] > 25.0


def test_anti_skid_holds_the_slip_and_a_stopped_wheel():
    """The slip ratio settles where the torque that is left balances the friction; stopped, it carries full torque."""
    slip = "wheel: tire, anti_skid: {slip: 0.1, width: 0.1}"
    recorded = RecordedRun(braked(slip, torque="400", end=5.5))
    speed, found = recorded["nodes/hub/velocity"][:, 0], recorded["loads/brake/slip_ratio"]
    i = int(np.searchsorted(recorded.time, 1.0))
    friction = 0.8 * math.exp(-0.02 * speed[i]) * MASS * GRAVITY
    deceleration = friction / MASS

    def balance(kappa):
        x, spin_down = (kappa - 0.1) / 0.1, (1.0 - kappa) * deceleration / 0.3
        return 400.0 * (1 - x * x * (3 - 2 * x)) - friction * 0.3 - SPIN_INERTIA * spin_down

    assert found[i] == pytest.approx(brentq(balance, 0.1, 0.2), rel=2e-3)
    assert found.max() < 0.2 and recorded["elements/tire/spin_rate"][recorded.time < 3.0].min() > 0.0
    assert abs(speed[-1]) < 1e-3 and abs(recorded["elements/tire/spin_rate"][-1]) < 1e-2
    assert recorded["energy/balance"][-1] == pytest.approx(
        recorded["energy/balance"][0], abs=1e-4 * 0.5 * MASS * SPEED**2
    )


@pytest.mark.parametrize(
    ("bound", "more", "text"),
    [
        ("adhesion: 0.5", {}, "'adhesion' needs 'wheel'"),
        ("wheel: rim, adhesion: 0.5", {}, "'wheel' must be a wheel with a tire law, got a rigid_body"),
        ("wheel: tyre, adhesion: 0.5", {}, "unknown element 'tyre'"),
        ("wheel: tire", {}, "'wheel' has no effect without"),
        ("wheel: tire, bound: 100, adhesion: 0.5", {}, "exclude one another"),
        ("wheel: tire, adhesion: 0.5", {"nodes": "[hub, leg]"}, "'nodes' must end with 'hub'"),
        ("wheel: tire, adhesion: 0.5", {"axis": "[0, 1, 0.1]"}, "'axis' is not parallel"),
        ("bound: 100", {"nodes": "[hub]"}, "'nodes' must be a list of 2 node names"),
        ("wheel: tire, anti_skid: {slip: 1.5}", {}, "must lie between 0 and 1"),
        ("bound: 100", {"torque": "-9"}, "'torque' must not be negative: a brake opposes every rotation"),
    ],
)
def test_what_a_deck_may_not_ask_of_a_brake(bound, more, text):
    with pytest.raises(DeckError) as error:
        braked(bound, **more)
    assert "brake 'brake'" in str(error.value) and text in f"{error.value} {error.value.problems[0].hint}"


def test_a_brake_without_a_reference_node():
    with pytest.raises(DeckError, match=r"brake 'brake': missing 'nodes', a list of 2 node names: reference node"):
        deck(DECK.format(bound="bound: 100", torque=9, nodes="", axis="[0, 1, 0]", end=1).replace("nodes: , ", ""))


def test_a_checked_brake_names_its_wheel_again():
    resolved = braked("wheel: tire, adhesion: 0.5").resolved()
    assert resolved["loads"]["brake"]["wheel"] == "tire" and resolved["elements"]["tire"]["tire_law"] == "rubber"

"""Velocity constraints implied by position constraints are released, without ringing (docs/theory.md, 3)."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.prepare import prepare
from mecano.errors import AssemblyError, ConvergenceError
from mecano.solve.diagnostics.mobility import analyse
from mecano.solve.events.compliance import Compliance, compliance

DRIVE = 0.981 * 30.0 / (30.0 + 2 * 0.1 / 0.0625)  # m/s2, inputs/axle_on_slope.yaml
ADAPTIVE = "time.adaptive={tolerance: 1.0e-4}"


def released(prepared):
    names = prepared.system.numbering.name[prepared.system.n_q :]
    return [names[row] for row in prepared.analysis.released]


def test_what_is_released():
    """One of two wheels on an axle is released, with the reaction of the other; all else is exact."""
    arm, axle = prepare(input_deck("trailing_wheel_bump")), prepare(input_deck("axle_on_slope"))
    assert released(arm) == ["rigid_wheel 'wheel': lateral force of the ground"]
    assert released(axle) == ["rigid_wheel 'left_wheel': lateral force of the ground"]
    np.testing.assert_allclose(arm.compliance.matrix.values, [1.0], atol=1e-12)
    np.testing.assert_allclose(axle.compliance.matrix.values, [0.5, -0.5], atol=1e-12)


def test_compliances_survive_a_checkpoint():
    soft = prepare(input_deck("axle_on_slope")).compliance
    again = Compliance.from_plain(soft.to_plain())
    assert all(map(np.array_equal, again.matrix, soft.matrix))
    assert np.array_equal(again.released, soft.released) and np.array_equal(again.places, soft.places)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4])
def test_long_steps_behind_a_bump_do_not_ring(tolerance):
    """A wheel that spins at 50 rad/s in steps up to 0.04 s, 2 rad each: the plane of the motion bears nothing."""
    fast = "parameters.speed=15", "time.step=1.0e-3", "initial={steady: {velocity: [15, 0, 0]}}"
    recorded = RecordedRun(input_deck("trailing_wheel_bump", *fast, f"time.adaptive={{tolerance: {tolerance}}}"))
    assert np.diff(recorded.time).max() > 0.03
    balance = recorded["energy/balance"].ravel()
    # with rows that rang 0.2 and 101 J; the balance falls with the tolerance (0.19 and 0.018 J)
    assert np.ptp(balance) < 300.0 * tolerance
    assert np.abs(recorded["elements/wheel/lateral_force"]).max() < 1e-6
    assert np.abs(recorded["joints/straight/force"]).max() < 1e-3
    short = RecordedRun(
        input_deck("trailing_wheel_bump", *fast, "time.adaptive={tolerance: 1.0e-4, maximum_step: 2.0e-3}")
    )
    for path in ("elements/wheel/normal_force", "elements/wheel/longitudinal_force"):
        assert recorded[path].max() == pytest.approx(short[path].max(), rel=20.0 * tolerance)


def test_two_wheels_share_what_their_axle_could_bear():
    """Half of 30 kg (g' + 0.981) sin t each, at every step from the first on; adaptive steps up to 7 ms."""
    recorded = RecordedRun(input_deck("axle_on_slope", "time.step=5.0e-3", ADAPTIVE))
    t, path = recorded.time, recorded["nodes/axle/position"]
    for side in ("left", "right"):
        force = recorded[f"elements/{side}_wheel/lateral_force"].ravel()
        np.testing.assert_allclose(force, 15.0 * (DRIVE + 0.981) * np.sin(t), rtol=0, atol=1e-3)
    cycloid = np.stack([DRIVE / 4 * (1 - np.cos(2 * t)), DRIVE / 2 * (t - np.sin(2 * t) / 2)], axis=1)
    np.testing.assert_allclose(path[:, :2], cycloid, rtol=0, atol=3e-5)


MOTOR = """
    mecano: 1
    gravity: [0, 0, -9.81]
    parameters: {{speed: 5.0}}
    nodes:
      carriage: {{position: [0, 0, 0.3]}}
      hub: {{position: [0, 0, 0.3]}}
    elements:
      load: {{type: rigid_body, node: carriage, mass: 20.0, inertia: [1, 1, 1]}}
      rim: {{type: rigid_body, node: hub, mass: 10.0, inertia: [0.25, 0.45, 0.25]}}
      wheel: {{type: rigid_wheel, node: hub, radius: 0.3, axis: [0, 1, 0], ground: track}}
    joints:
      level: {{type: held_rotation, nodes: [ground, carriage]}}
      tow: {{type: prescribed_position, node: carriage, direction: [1, 0, 0], value: {{linear: {{slope: $speed}}}}}}
      motor: {{type: hinge, nodes: [carriage, hub], axis: [0, 1, 0]}}
      spin: {{type: prescribed_angle, nodes: [carriage, hub], axis: [0, 1, 0], value: {{linear: {{slope: {rate}}}}}}}
    grounds:
      track:
        plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}
        profile: {{direction: [1, 0, 0], height: {{bump: {{start: 1.0, length: 1.0, height: {height}}}}}}}
    initial:
      velocities:
        - {{nodes: all, velocity: [$speed, 0, 0]}}
        - {{nodes: [hub], angular_velocity: [0, {rate}, 0]}}
    time: {{end: 0.3, step: 1.0e-3}}
"""


def test_a_contradiction_is_reported_and_not_slipped_over():
    """A motor that turns as the wheel rolls bears nothing; one percent more, or the same on a bump, is refused."""
    fitting = RecordedRun(deck(MOTOR.format(rate=5.0 / 0.3, height=0.0)))
    assert np.abs(fitting["joints/spin/moment"]).max() < 1e-6
    slips = (
        "constraints contradict one another: the constraints on positions leave a slip of .* m/s to rigid_wheel 'wheel'"
    )
    with pytest.raises(AssemblyError, match=slips):
        RecordedRun(deck(MOTOR.format(rate=5.05 / 0.3, height=0.0)))
    with pytest.raises(ConvergenceError, match=slips):
        RecordedRun(deck(MOTOR.format(rate=5.0 / 0.3, height=0.1)))


WALL = """
    mecano: 1
    gravity: [0, 0, 0]
    nodes: {plate: {position: [0, 0, 0]}}
    elements:
      body: {type: rigid_body, node: plate, mass: 2.0, inertia: [0.1, 0.1, 0.1]}
      knife: {type: skate, node: plate, axis: [0, 1, 0], ground: ice}
      wall: {type: plane_contact, node: plate, ground: wall}
    joints:
      level: {type: held_rotation, nodes: [ground, plate]}
      height: {type: prescribed_position, node: plate, direction: [0, 0, 1], value: 0.0}
    loads:
      pull: {type: force, node: plate, direction: [0, 1, 0], value: {table: {points: [[0, -10], [1, 10]]}}}
    grounds:
      ice: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
      wall: {plane: {point: [0, 0, 0], normal: [0, 1, 0]}}
    initial: {velocities: [{nodes: [plate], velocity: [1, 0, 0]}]}
    time: {end: 1.0, step: 0.01}
"""


def closed(prepared):
    """Start the run with the plate at the wall."""
    s, system = prepared.state, prepared.system
    for batch in system.batches:
        s.phases[batch.phases] = len(batch.kind.phases) - 1
    system.follow(s.phases)
    prepared.compliance = compliance(system, s, prepared.length, analyse(system, s, prepared.length))


def test_a_blade_holds_again_where_the_wall_that_held_it_lets_go():
    recorded = RecordedRun(deck(WALL), start=closed)
    assert recorded.event_records[-1].name == "lifts off" and recorded.event_records[-1].t == pytest.approx(
        0.5, abs=1e-9
    )
    pull, late = 20.0 * recorded.time - 10.0, recorded.time > 0.5
    np.testing.assert_allclose(recorded["elements/wall/normal_force"].ravel(), np.where(late, 0.0, -pull), atol=1e-9)
    np.testing.assert_allclose(recorded["elements/knife/lateral_force"].ravel(), np.where(late, -pull, 0.0), atol=1e-9)
    assert np.abs(recorded["nodes/plate/position"][:, 1]).max() < 1e-12

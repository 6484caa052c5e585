"""Grips: momentum, energy and motion after they close, and their commands."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.dynamic import run
from mecano.analyses.prepare import prepare
from mecano.errors import DeckError
from mecano.results.reader import open_results

M_CHASER, M_TARGET, J_CHASER, J_TARGET = 600.0, 900.0, 300.0, 450.0
ARM = np.array([-1.0, 0.3])  # [m] of the chaser from the target when the grip closes
REACHED = "part.position.x > -0.5"
PASSING = """
    mecano: 1
    gravity: none
    nodes:
      hand: {position: [0, 0, 0]}
      part: {position: [-1, 0, 0]}
    elements:
      hand: {type: rigid_body, node: hand, mass: 3, inertia: [1, 1, 1]}
      part: {type: point_mass, node: part, mass: 1}
    joints:
      hook: {type: grip, nodes: [hand, part], rotation: false, MORE}
    initial: {velocities: [{nodes: [part], velocity: [1, 0, 0]}]}
    time: {end: 2, step: 0.01}
    """


def turned(angle):
    """Return the rotation (2, 2) by an angle [rad]."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def events(run):
    return [(h.name, round(h.t, 9), h.after) for h in run.event_records]


def test_two_spacecraft_move_on_as_one(verify):
    """Linear and angular momentum stay; the energy of the relative motion is lost."""
    run, mass = RecordedRun(input_deck("docking")), M_CHASER + M_TARGET
    assert events(run) == [("closes", 2.0, "closed"), ("releases", 14.0, "released")]
    reduced = M_CHASER * M_TARGET / mass
    J = J_CHASER + J_TARGET + reduced * ARM @ ARM
    omega = (J_CHASER * 0.02 - reduced * ARM[1] * 0.1) / J
    drift, about = np.array([M_CHASER * 0.1 / mass, 0.0]), omega * turned(np.pi / 2)
    lost = 0.5 * (M_CHASER * 0.01 + J_CHASER * 0.0004 - mass * drift @ drift - J * omega**2)
    impulse = M_TARGET * np.linalg.norm(drift - about @ ARM * M_CHASER / mass)
    found = [run.event_records[0].lost, run.event_records[0].impulse]
    verify("Shocks", "docking: energy lost [J], impulse [N s]", found, [lost, impulse], "momentum", relative=1e-11)
    middle = ARM * M_CHASER / mass + drift * (run.time[:, None] - 2.0)
    arms = np.array([turned(omega * (t - 2.0)) @ ARM * M_TARGET / mass for t in run.time])
    held = (run.time > 2.001) & (run.time < 14.0)
    path, spin = run["nodes/chaser/position"][:, :2], run["nodes/chaser/angular_velocity"][:, 2]
    what = "docked spacecraft: path of the chaser [m]"
    verify("Shocks", what, path[held], (middle + arms)[held], "motion of one body", absolute=1e-8)
    np.testing.assert_allclose(spin[held], omega, rtol=1e-8)
    parting = middle[-1] - 6.0 * drift + turned(12.0 * omega) @ ARM * M_TARGET / mass
    velocity = drift + about @ turned(12.0 * omega) @ ARM * M_TARGET / mass
    np.testing.assert_allclose(path[-1], parting + 6.0 * velocity, atol=1e-8)
    np.testing.assert_array_equal(run["joints/port/force"][run.time > 14.001], 0.0)
    assert np.ptp(run["energy/balance"]) < 1e-10


def test_a_grip_holds_a_body_as_it_stands_in_space():
    """Turned about all axes when it closes, b stays where it is in a; linear and angular momentum stay."""
    text = PASSING.replace("point_mass, node: part, mass: 1", "rigid_body, node: part, mass: 1, inertia: [1, 2, 3]")
    text = text.replace("velocity: [1, 0, 0]", "velocity: [1, 0.2, 0.1], angular_velocity: [2, -1, 3]")
    text = text.replace("rotation: false, MORE", "close: {time: 0.5}").replace("step: 0.01", "step: 0.0025")
    run = RecordedRun(deck(text))
    (closed,) = np.flatnonzero(run.time > 0.5 - 1e-9)[:1]
    x = {name: run[f"nodes/{name}/position"] for name in ("hand", "part")}
    R = {name: Rotation.from_quat(run[f"nodes/{name}/rotation"], scalar_first=True) for name in ("hand", "part")}
    place = R["hand"].inv().apply(x["part"] - x["hand"])[closed:]
    turn = (R["hand"].inv() * R["part"])[closed:].as_rotvec()
    assert np.linalg.norm(turn[0]) > 1.0  # far from the orientation in the deck
    np.testing.assert_allclose(place, np.broadcast_to(place[0], place.shape), atol=1e-9)
    np.testing.assert_allclose(turn, np.broadcast_to(turn[0], turn.shape), atol=1e-9)
    momentum = sum(
        np.cross(x[name], mass * run[f"nodes/{name}/velocity"])
        + R[name].apply(R[name].inv().apply(run[f"nodes/{name}/angular_velocity"]) * inertia)
        for name, mass, inertia in (("hand", 3.0, [1, 1, 1]), ("part", 1.0, [1, 2, 3]))
    )
    np.testing.assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), atol=1e-4)
    np.testing.assert_allclose(momentum[closed + 1], momentum[closed], atol=2e-6)


@pytest.mark.parametrize("command", ["close: {time: 0.5}", f"close: {{when: {REACHED}}}", f"while: {REACHED}"])
def test_a_hook_holds_the_position(command):
    run = RecordedRun(deck(PASSING.replace("MORE", command)))
    assert events(run) == [("closes", 0.5, "closed")]
    assert run.event_records[0].lost == pytest.approx(0.5 * 0.75)
    np.testing.assert_allclose(run["nodes/part/velocity"][-1], [0.25, 0, 0], atol=1e-12)
    np.testing.assert_allclose(run["nodes/hand/position"][-1], [0.375, 0, 0], atol=1e-10)
    np.testing.assert_array_equal(run["joints/hook/closed"], run.time > 0.5 + 1e-9)


def test_a_grip_that_begins_closed_exchanges_momentum_at_the_start():
    run = RecordedRun(deck(PASSING.replace("MORE", "close: {time: 0}")))
    assert events(run) == [("closes", 0.0, "closed")]
    np.testing.assert_allclose(run["nodes/part/velocity"][-1], [0.25, 0, 0], atol=1e-12)


LOCKED = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {a: {position: [0, 0, 0]}, tip: {position: [0, 1, 0]}, b: {position: [0, 1, 0]}}
    elements:
      a: {type: rigid_body, node: a, mass: 1, center_of_mass: [0, 0.5, 0], inertia: [0.1, 0.1, 0.1], attached: [tip]}
      b: {type: rigid_body, node: b, mass: 1, center_of_mass: [0, 0.5, 0], inertia: [0.1, 0.1, 0.1]}
    joints:
      root: {type: hinge, nodes: [ground, a], axis: [1, 0, 0]}
      knee: {type: hinge, nodes: [tip, b], axis: [1, 0, 0]}
      lock: {type: grip, nodes: [a, b], while: HOLDS}
    signals: {held: {type: switch, input: time, upper: 0.5, low: 1, high: 0}}
    time: {end: 0.6, step: 1 ms}
    """


@pytest.mark.parametrize("holds", ["time < 0.5", "held > 0.5", "'min(0.001 - abs(knee.angle), 0.5 - time) > 0'"])
def test_a_grip_that_is_closed_from_the_start_locks_a_hinge(holds):
    """Five of its constraints repeat those of the hinge: both rods swing as one, and fold when it opens."""
    given = deck(LOCKED.replace("HOLDS", holds))
    assert len(prepare(given).analysis.redundant) == 5
    run = RecordedRun(given)
    locked = run.time < 0.5 + 1e-9
    angle, rate = -run["joints/root/angle"][locked], run["joints/root/rate"][locked]
    np.testing.assert_allclose(rate**2, 2.0 * 2.0 * 9.81 * np.sin(angle) / (0.2 + 0.5**2 + 1.5**2), atol=1e-4)
    assert np.abs(run["joints/knee/angle"][locked]).max() < 1e-10 < 1e-3 < abs(run["joints/knee/angle"][-1])
    assert ("opens", 0.5, "open") in events(run)


def test_a_grip_that_is_closed_from_the_start_takes_part_in_the_equilibrium():
    """Both rods hang in one line, at the angle of gravity; without the grip the knee would be free to turn, too."""
    hanging = LOCKED.replace("HOLDS", "time < 0.5").replace("[0, 0, -9.81]", "[0, 6, -8]")
    run = RecordedRun(deck(hanging.replace("time: {end: 0.6", "initial: static\n    time: {end: 0.1")))
    np.testing.assert_allclose(run["joints/root/angle"], -np.arctan2(8.0, 6.0), atol=1e-9)
    np.testing.assert_allclose(run["joints/knee/angle"], 0.0, atol=1e-9)
    np.testing.assert_array_equal(run["joints/lock/closed"], 1.0)


@pytest.mark.parametrize(
    ("release", "found"),
    [
        ("{time: 0.3}", []),
        ("{when: 'abs(time - 0.8) < 0.6'}", [("closes", 1.4, "closed")]),
        ("{when: 'abs(time - 0.3) < 0.1'}", [("closes", 0.5, "closed")]),
    ],
)
def test_a_grip_that_is_released_does_not_close(release, found):
    """Nor does it lose energy; it closes where its release is no longer commanded."""
    run = RecordedRun(deck(PASSING.replace("MORE", f"close: {{when: {REACHED}}}, release: {release}")))
    assert events(run) == found
    assert run["nodes/part/velocity"][-1, 0] == pytest.approx(0.25 if found else 1.0, abs=1e-12)


def test_a_grip_closes_and_opens_again_as_its_condition_says():
    held = PASSING.replace("hand: {position: [0, 0, 0]}", "hand: {position: [0, 0, 0], fixed: true}")
    run = RecordedRun(deck(held.replace("MORE", "while: sin(2*pi*time) > 0.5")))
    times = [(n + part) / 12 for n in (0, 12) for part in (1, 5)]
    assert [h.name for h in run.event_records] == ["closes", "opens"] * 2
    np.testing.assert_allclose([h.t for h in run.event_records], times, atol=1e-9)
    assert run["nodes/part/position"][-1, 0] == pytest.approx(-1 + 1 / 12, abs=1e-9)  # it stays where it was held


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("", "give either 'close' or 'while'"),
        ("close: {}", "'close' needs either 'time' or 'when'"),
        ("close: {time: 1}, while: time > 1", "give either 'close' or 'while'"),
        ("close: {time: 1}, release: {time: 1}", "'release.time' must be later than 'close.time', 1 s"),
        ("release: {time: 1}, while: time > 1", "'release' and 'while' exclude one another"),
    ],
)
def test_wrong_commands(command, message):
    with pytest.raises(DeckError) as error:
        deck(PASSING.replace("MORE", command))
    assert message in error.value.problems[0].message and error.value.problems[0].mark


@pytest.mark.parametrize(
    ("more", "unmet"),
    [
        ("close: {when: part.position.x > 5}", "'close: {when: part.position.x > 5}'"),
        ("close: {when: part.position.x > -0.5}, release: {when: time > 3}", "'release: {when: time > 3}'"),
        ("close: {when: part.position.x > -0.5}", ""),
        ("close: {when: part.position.x > -0.5}, release: {when: hook.force.magnitude > 1e3}", ""),
        ("while: part.position.x > 5", "'while: part.position.x > 5'"),
        ("while: part.position.x < -0.5", ""),
    ],
)
def test_a_grip_that_waits_to_the_end_is_reported(more, unmet, tmp_path):
    """Except for one that would open at a load of its own, which is a fuse, and one that closed for a while."""
    run(deck(PASSING.replace("MORE", more)), tmp_path / "run.h5")
    with open_results(tmp_path / "run.h5") as results:
        found = [text for text in results.warnings if "did not become true" in text]
    assert found == ([f"conditions that did not become true: grip 'hook', {unmet}"] if unmet else [])

"""Locks of joints: motion, momentum and energy while their condition is true and afterwards."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.dynamic import run
from mecano.analyses.prepare import prepare, warnings_of
from mecano.errors import DeckError
from mecano.results.reader import open_results

G, MASS, ARM = 9.81, 1.0, 0.75
INERTIA = 0.1875 + MASS * ARM**2  # about the pin
PENDULUM = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {pin: {position: [0, 0, 0]}}
    elements:
      bar: {type: rigid_body, node: pin, mass: 1, center_of_mass: [0.75, 0, 0], inertia: [1e-4, 0.1875, 0.1875]}
    joints:
      hinge: {type: hinge, nodes: [ground, pin], axis: [0, 1, 0], lock: {while: CONDITION}}
    time: {end: 1, step: STEP}
    """
TWICE = "time < 0.2 or (time > 0.5 and time < 0.7)"


def swing(t, angle=0.0):
    """Return angle and rate of the pendulum a time t after it was released at rest, from the horizontal at 0."""
    motion = solve_ivp(
        lambda t, y: [y[1], MASS * G * ARM * np.cos(y[0]) / INERTIA], (0.0, t), (angle, 0.0), "DOP853",
        rtol=1e-12, atol=1e-13,
    )  # fmt: skip
    return motion.y[:, -1]


def test_a_brake_holds_a_pendulum_twice(verify):
    """It begins locked, locks at speed with a shock, and swings on from rest."""
    angle, rate = swing(0.3)
    exact = np.array([angle, rate, *swing(0.3, angle), -INERTIA * rate, 0.5 * INERTIA * rate**2])
    found = []
    for step in ("4e-3", "2e-3"):
        m = RecordedRun(deck(PENDULUM.replace("CONDITION", TWICE).replace("STEP", step)))
        opens, locks, opens_again = m.event_records
        names = [(h.name, round(h.t, 9)) for h in m.event_records]
        assert names == [("unlocks", 0.2), ("locks", 0.5), ("unlocks", 0.7)]
        held = m["joints/hinge/locked"] == 1.0
        turned = m["joints/hinge/angle"]
        np.testing.assert_allclose(m["joints/hinge/lock_moment"][0], -MASS * G * ARM, rtol=1e-9)
        np.testing.assert_array_equal(m["joints/hinge/lock_moment"][~held], 0.0)
        later = held & (m.time > 0.6)
        assert np.ptp(turned[later]) < 1e-12 and abs(m["joints/hinge/rate"][later]).max() < 1e-10
        before = np.flatnonzero(np.isclose(m.time, 0.5))[0]
        end = m["joints/hinge/rate"][-1]
        found.append(
            np.array([turned[before], m["joints/hinge/rate"][before], turned[-1], end, locks.impulse, locks.lost])
        )
    verify.second_order("Locks", "pendulum held by a brake: angles, rates, impulse, loss", *found, exact, 1e-6, "SciPy")


def test_a_dog_clutch_joins_two_shafts():
    """The speeds before and after follow from angular momentum alone."""
    m = RecordedRun(
        deck("""
        mecano: 1
        gravity: none
        nodes: {a: {position: [0, 0, 0]}, b: {position: [0, 0, 0]}}
        elements:
          a: {type: rigid_body, node: a, mass: 1, inertia: [2, 2, 2]}
          b: {type: rigid_body, node: b, mass: 1, inertia: [3, 3, 3]}
        joints:
          shaft: {type: hinge, nodes: [ground, a], axis: [1, 0, 0]}
          clutch: {type: hinge, nodes: [a, b], axis: [1, 0, 0], lock: {while: time > 0.25 and time < 0.5}}
        loads: {motor: {type: joint_moment, joint: shaft, value: 4}}
        time: {end: 1, step: 0.01}
        """)
    )
    speeds = [m[f"nodes/{name}/angular_velocity"][:, 0] for name in "ab"]
    joined, apart = np.isclose(m.time, 0.5), np.isclose(m.time, 1.0)
    common = (4.0 * 0.25 + 4.0 * 0.25) / 5.0  # impulse of the motor, over both inertias
    for speed, end in zip(speeds, (common + 4.0 * 0.5 / 2.0, common), strict=True):
        np.testing.assert_allclose(speed[joined][-1], common, rtol=1e-9)
        np.testing.assert_allclose(speed[apart], end, rtol=1e-9)
    (locks, _) = m.event_records
    np.testing.assert_allclose(locks.lost, 0.5 * (2.0 * 3.0 / 5.0) * 0.5**2, rtol=1e-9)  # reduced inertia, 0.5 rad/s


def test_a_gearbox_shifts(verify):
    """Inertia of all that turns with the motor: 0.05, the wheels 0.009/3^2 and 0.002 kg m2; impulse of the shock."""
    m = RecordedRun(input_deck("gearbox"))
    turning, load = 0.05 + 9.0e-3 / 9.0 + 2.0e-3, 0.2
    first = 10.0 * 1.0 / (turning + load / 9.0)
    impulse = load * turning / (load + turning) * (first - first / 3.0)
    last = first - impulse / turning + 10.0 * 0.8 / (turning + load)
    (locks,) = [h for h in m.event_records if h.name == "locks"]
    shifts, ends = np.isclose(m.time, 1.2), np.isclose(m.time, 2.0)
    motor, driven = m["joints/motor/rate"], m["joints/load/rate"]
    found = [motor[shifts][0], driven[shifts][0], motor[ends][0], driven[ends][0], abs(locks.impulse)]
    exact = [first, -first / 3.0, last, -last, impulse]
    what = "gearbox: speeds [rad/s] before the shift and 0.8 s after it, impulse [N m s]"
    verify("Locks", what, found, exact, "angular momentum", relative=1e-9)


def test_a_locked_guide_is_in_equilibrium():
    """A static start holds the load by the lock, and needs no redundant constraint for it."""
    given = deck("""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {car: {position: [0, 0, 0]}}
        elements: {car: {type: rigid_body, node: car, mass: 3, inertia: [1, 1, 1]}}
        joints:
          rail: {type: prismatic, nodes: [ground, car], axis: [0, 0, 1], lock: {while: time < 0.1}}
        initial: static
        time: {end: 0.3, step: 0.01}
        """)
    assert not warnings_of(prepare(given))
    m = RecordedRun(given)
    np.testing.assert_allclose(m["joints/rail/lock_force"][m.time < 0.09], 3.0 * G, rtol=1e-9)
    np.testing.assert_allclose(m["joints/rail/displacement"][-1], -0.5 * G * 0.2**2, rtol=1e-9)


def test_a_lock_that_never_locks(tmp_path):
    run(deck(PENDULUM.replace("CONDITION", "hinge.angle < -1").replace("STEP", "0.01")), tmp_path / "r.h5")
    (text,) = [text for text in open_results(tmp_path / "r.h5").warnings if "did not become true" in text]
    assert "hinge 'hinge', 'lock.while: hinge.angle < -1'" in text


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ("lock: {while: time}", "a condition compares two formulas by > or <"),
        ("lock: {}", "missing 'lock.while'"),
        ("lock: {while: time > 1}, release: {time: 1}", "'release' and 'lock' exclude one another"),
        ("latch: {angle: 0}", "'lock: {while: time < 1}' locks it while a condition is true"),
    ],
)
def test_wrong_locks(option, message):
    with pytest.raises(DeckError) as error:
        deck(PENDULUM.replace("lock: {while: CONDITION}", option).replace("STEP", "0.01"))
    assert message in str(error.value)

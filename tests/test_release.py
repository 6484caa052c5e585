"""Joints that are released at a time or by a condition."""

import numpy as np
import pytest
from scipy.integrate import quad
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.dynamic import run
from mecano.errors import DeckError
from mecano.results.reader import open_results

G = 9.81


@pytest.fixture(scope="module")
def recorded():
    return [RecordedRun(input_deck("release", f"time.step={h}")) for h in (4e-3, 2e-3)]


def test_a_clamp_is_released_at_a_time(verify, recorded):
    m = recorded[1]
    fall = -0.5 * G * np.maximum(m.time - 0.3, 0.0) ** 2
    height = m["nodes/weight/position"][:, 2]
    verify("Release", "clamp released at 0.3 s: height [m]", height, fall, "free fall", absolute=1e-9)
    (released,) = [h for h in m.event_records if h.element == "fixed 'clamp'"]
    assert released.t == pytest.approx(0.3, abs=1e-12)
    force = m["joints/clamp/force"]
    np.testing.assert_allclose(force[m.time < 0.3 - 1e-9, 2], 3.0 * G, rtol=1e-9)
    np.testing.assert_array_equal(force[m.time > 0.3 + 1e-9], 0.0)


def test_a_hinge_is_released_by_a_condition(verify, recorded):
    """The rate at an angle a is sqrt(3 g sin(a)/L); of a = s^2 the time to 1 rad is an integral without a pole."""
    instant, rate = (
        quad(lambda s: 2.0 * s / np.sqrt(3.0 * G * np.sin(s * s)), 0.0, 1.0)[0],
        np.sqrt(3.0 * G * np.sin(1.0)),
    )
    after = 1.0 - instant
    x = 0.5 * np.cos(1.0) - 0.5 * rate * np.sin(1.0) * after
    z = -0.5 * np.sin(1.0) - 0.5 * rate * np.cos(1.0) * after - 0.5 * G * after**2
    found = []
    for m in recorded:
        (released,) = [h for h in m.event_records if h.element == "hinge 'hinge'"]
        bar = m["elements/bar/center_of_mass"][-1]
        found.append(np.array([released.t, m["nodes/pin/angular_velocity"][-1, 1], bar[0], bar[2]]))
        np.testing.assert_array_equal(m["joints/hinge/force"][-5:], 0.0)
    what = "hinge released at 1 rad: instant, spin and place of the bar"
    verify.second_order("Release", what, *found, np.array([instant, rate, x, z]), 2e-6, "energy, parabola")


def test_energy_passes_a_release(recorded):
    drift = [np.ptp(m["energy/balance"]) for m in recorded]
    assert drift[0] / drift[1] == pytest.approx(4.0, abs=0.05) and drift[1] < 1.5e-4


@pytest.mark.parametrize(("when", "said"), [("hinge.angle < 0.5", 1), ("hinge.angle > 1", 0)])
def test_a_release_that_is_due_at_the_start_is_reported(when, said, tmp_path):
    run(input_deck("release", f"joints.hinge.release={{when: {when}}}", "time.end=0.01"), tmp_path / "r.h5")
    found = [text for text in open_results(tmp_path / "r.h5").warnings if "true at the start" in text]
    assert len(found) == said
    for text in found:
        assert "release.yaml:45:3: hinge 'hinge': the condition of its release, hinge.angle < 0.5, is true" in text


BAD = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}}
    elements: {body: {type: rigid_body, node: a, mass: 2, inertia: [1, 1, 1]}}
    joints: {pin: {type: hinge, nodes: [ground, a], axis: [1, 0, 0], release: RELEASE}}
    time: {end: 0.1, step: 0.01}
    """


@pytest.mark.parametrize(
    ("release", "message"),
    [
        ("{}", "'release' needs either 'time' or 'when'"),
        ("{time: 1, when: pin.angle > 1}", "'release' needs either 'time' or 'when'"),
        ("{when: pin.angle}", "a condition compares two formulas by > or <, as in 'hinge.angle > 1.5'"),
        ("{when: pin.angle > 1 and pin.rate < 0}", "of several, all are true if the smallest difference is above zero"),
        ("{when: pin.angel > 1}", "'angel' of 'pin' cannot be measured"),
        ("{time: 1}, latch: {angle: 1}", "'release' and 'latch' exclude one another"),
    ],
)
def test_wrong_releases(release, message):
    with pytest.raises(DeckError) as error:
        deck(BAD.replace("RELEASE", release))
    assert message in error.value.problems[0].message

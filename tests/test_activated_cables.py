"""Cables over pulleys that begin to act at a time or by a condition: motion, energy, resuming, modes."""

import math

import numpy as np
import pytest
from surviving import check_same, contents, resumed
from time_runs import RecordedRun, deck

from mecano.analyses.dynamic import run
from mecano.analyses.operating_point import operating_point
from mecano.errors import MecanoError
from mecano.solve.modal.linearize import linearize
from mecano.solve.modal.modes import solve

S, g = "Cables that slide over pulleys", 9.81
WEIGHTS = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      left: {position: [-0.2, 0, -1]}
      wheel: {position: [0, 0, 0], fixed: true}
      right: {position: [0.2, 0, -1]}
    elements:
      left: {type: point_mass, node: left, mass: 3}
      right: {type: point_mass, node: right, mass: 2}
      rope: {type: reeved_cable, nodes: [left, wheel, right], radii: [0, -0.2, 0], axis: [0, -1, 0],
             axial_stiffness: 2.0e4, MORE}
    time: {end: 0.36, step: STEP}
"""
EA, AT_START = 2e4, 2.0 + 0.2 * math.pi  # stiffness, length of the path at the start
INSTANT = 0.3
LENGTH = AT_START + g * INSTANT**2  # both weights have fallen by g t^2/2
MASS = 3.0 * 2.0 / 5.0  # reduced


def weights(activation, pretension=0.0, step="2e-4", more=""):
    activate = f"activate: {activation}, pretension: {pretension}{more}"
    return deck(WEIGHTS.replace("MORE", activate).replace("STEP", step))


def oscillation(pretension, stress_free):
    """Return natural length, stiffness, initial tension and extension of the rope, and its angular frequency."""
    natural = (LENGTH if stress_free else AT_START) / (1.0 + pretension / EA)
    stiffness = EA / natural
    return natural, stiffness, EA * (LENGTH / natural - 1.0), math.sqrt(stiffness / MASS)


@pytest.mark.parametrize(
    ("trigger", "pretension", "stress_free"),
    [("time: 0.3", 40.0, True), (f"when: rope.length > {LENGTH}", 0.0, True), ("time: 0.3", 0.0, False)],
    ids=["with its pretension", "by its length", "as given"],
)
def test_a_rope_takes_hold_of_two_falling_weights(verify, trigger, pretension, stress_free):
    """Between both falls a, b there is an oscillation, u'' = 2 g - N/m with N = T + k u; 3 a - 2 b falls freely.

    The rope goes slack where N = 0 on its way back: its energy at the activation is given.
    """
    natural, k, tension, w = oscillation(pretension, stress_free)
    mean, speed = (2.0 * g * MASS - tension) / k, 2.0 * g * INSTANT
    size, phase = math.hypot(mean, speed / w), math.atan2(-mean, speed / w)  # u = mean + size sin(w t + phase)
    slack = (math.pi + math.asin((tension / k + mean) / size) - phase) / w
    after = 0.36 - INSTANT
    if slack < after:
        at_slack = -tension / k + size * w * math.cos(w * slack + phase) * (after - slack)
        u = at_slack + g * (after - slack) ** 2
    else:
        u = mean + size * math.sin(w * after + phase)
    free, both = 0.5 * g * 0.36**2, LENGTH - AT_START + u
    known = [(free + 2.0 * both) / 5.0, (3.0 * both - free) / 5.0, *([INSTANT + slack] if slack < after else [])]
    found = []
    for step in ("4e-4", "2e-4"):
        m = RecordedRun(weights(f"{{{trigger}, stress_free: {str(stress_free).lower()}}}", pretension, step))
        activated, *others = m.event_records
        assert (activated.name, activated.after) == ("activates", "taut")
        assert activated.t == pytest.approx(INSTANT, abs=1e-9)
        assert activated.lost == pytest.approx(-0.5 * tension**2 * natural / EA, rel=1e-8, abs=1e-12)
        ends = [-1.0 - m[f"nodes/{name}/position"][-1, 2] for name in ("left", "right")]
        found.append(np.array([*ends, *(event.t for event in others)]))
        assert [event.name for event in others] == ["goes slack"] * (len(known) - 2)
        assert np.ptp(m["energy/balance"]) < 1e-3 * np.ptp(m["energy/kinetic"])
    what = f"weights caught by a rope that is activated ({trigger}): falls [m], instant of slackening"
    verify.second_order(S, what, *found, known, 1e-7, "harmonic oscillation")
    before = m.time <= INSTANT
    np.testing.assert_array_equal(m["elements/rope/tension"][before], 0.0)
    np.testing.assert_allclose(m["elements/rope/natural_length"][~before], natural, rtol=1e-9)


def test_modes_about_a_saved_time_use_the_natural_length_of_its_replay(tmp_path):
    """The weights oscillate against each other at the frequency of the natural length that follows from the replay."""
    model = weights("{time: 0.3, stress_free: true}", 40.0)
    run(model, tmp_path / "r.h5")
    for time, there in ((0.29, False), (0.32, True)):
        base = operating_point(model, f"{tmp_path / 'r.h5'}:{time}")
        found = solve(linearize(base.prepared.system, base.state, 1.0)).values
        nearest = np.abs(found - 1j * oscillation(40.0, True)[3]).min()
        assert (nearest < 1e-7 * oscillation(40.0, True)[3]) == there


DRUM = """
    mecano: 1
    gravity: none
    nodes:
      left: {position: [-0.2, 0, -1], fixed: true}
      wheel: {position: [0, 0, 0]}
      right: {position: [0.2, 0, -1], fixed: true}
    elements:
      drum: {type: rigid_body, node: wheel, mass: 1, inertia: [0.5, 0.5, 0.5]}
      rope: {type: reeved_cable, nodes: [left, wheel, right], radii: [0, -0.2, 0], axis: [0, -1, 0], pretension: 50,
             axial_stiffness: 1.0e4, friction: {coefficients: [0.3], regularization: 0.01}, MORE}
    joints: {bearing: {type: hinge, nodes: [ground, wheel], axis: [0, 1, 0]}}
    initial: {velocities: [{nodes: [wheel], angular_velocity: [0, 40, 0]}]}
    time: {end: 1.0, step: 5.0e-3}
"""


@pytest.mark.parametrize(
    "more", ["activate: {time: 0.3, stress_free: true}", "activate: {time: 0.3}, release: {time: 0.8}"]
)
def test_a_drum_is_braked_by_a_rope_that_is_activated(verify, more):
    """T_2 = T_1 exp(mu pi) with the mean T_0 on equal spans: the moment is 2 T_0 r tanh(mu pi/2) until the release."""
    m = RecordedRun(deck(DRUM.replace("MORE", more)))
    moment = 2.0 * 50.0 * 0.2 * math.tanh(0.15 * math.pi)
    braked = np.clip(m.time, 0.3, 0.8 if "release" in more else 1.0) - 0.3
    rates, exact = m["joints/bearing/rate"], 40.0 - moment / 0.5 * braked
    what = f"drum braked by a rope, {more}: rates [rad/s]"
    verify(S, what, rates, exact, "capstan formula", relative=1e-6)
    natural = AT_START / (1.0 + 50.0 / 1e4)
    energy = 0.5 * 50.0**2 * natural / 1e4
    assert [e.lost for e in m.event_records] == pytest.approx([-energy, energy][: len(m.event_records)], rel=1e-9)
    assert np.ptp(m["energy/balance"]) < 1e-6 * 400.0


def test_a_winch_hauls_from_the_activation_on():
    """Only what is paid out after the activation changes the natural length of the path that the cable took."""
    fixed = WEIGHTS.replace("right: {type: point_mass, node: right, mass: 2}", "").replace(
        "right: {position: [0.2, 0, -1]}", "right: {position: [0.2, 0, -1], fixed: true}"
    )
    activate = "activate: {time: 0.3, stress_free: true}, payout: 0.1*time"
    m = RecordedRun(deck(fixed.replace("MORE", activate).replace("STEP", "5e-4")))
    after, length = m.time > INSTANT + 1e-9, AT_START + 0.5 * g * INSTANT**2
    natural = m["elements/rope/natural_length"]
    np.testing.assert_allclose(natural[after], length + 0.1 * (m.time[after] - INSTANT), rtol=1e-9)
    assert np.ptp(m["energy/balance"]) < 1e-3 * np.ptp(m["energy/kinetic"])


def test_a_rope_that_is_taken_is_resumed_to_the_same_bits(tmp_path):
    model = deck(DRUM.replace("MORE", "activate: {time: 0.3, stress_free: true}, payout: 0.01*time"))
    run(model, tmp_path / "whole.h5")
    resumed(model, tmp_path / "r.h5", (40, 100))
    check_same(contents(tmp_path / "r.h5"), contents(tmp_path / "whole.h5"))


PASSING = """
    mecano: 1
    gravity: none
    nodes:
      left: {position: [-1, 0, -0.2], fixed: true}
      wheel: {position: [0, 0, 0], fixed: true}
      right: {position: [1, 0, HEIGHT]}
    elements:
      right: {type: point_mass, node: right, mass: 1}
      rope: {type: reeved_cable, nodes: [left, wheel, right], radii: [0, -0.2, 0], axis: [0, -1, 0],
             axial_stiffness: 1.0e3, activate: {time: TIME}}
    initial: {velocities: [{nodes: [right], velocity: [-1, 0, 0]}]}
    time: {end: 2.2, step: 0.01}
"""


def test_before_its_activation_a_rope_may_have_no_path(tmp_path):
    """The right end flies through the wheel, where the outputs are zero, or touches it on its way, to the left."""
    for height in (-0.1, -0.2):
        m = RecordedRun(deck(PASSING.replace("TIME", "3").replace("HEIGHT", str(height))))
        assert np.all(np.isfinite(m.rows))
        inside = np.hypot(*m["nodes/right/position"][:, [0, 2]].T) <= 0.2
        assert inside.any()
        np.testing.assert_array_equal(m["elements/rope/length"] == 0.0, inside)
        np.testing.assert_array_equal(m["nodes/right/velocity"][-1], [-1, 0, 0])
    with pytest.raises(MecanoError, match="reeved_cable 'rope' has no free span left"):
        run(deck(PASSING.replace("TIME", "1.0").replace("HEIGHT", "-0.1")), tmp_path / "within.h5")


LINE = """
    mecano: 1
    gravity: [0, 0, -1]
    nodes: {top: {position: [0, 0, 0], fixed: true}, b: {position: [0, 0, -1]}}
    elements:
      b: {type: point_mass, node: b, mass: 1}
      line: {type: cable, nodes: [top, b], axial_stiffness: 100, natural_length: 1.5, MORE}
    time: {end: 0.2, step: 0.01}
"""


@pytest.mark.parametrize("text", [LINE, WEIGHTS.replace("MORE", "payout: 0.5, MORE").replace("STEP", "0.01")])
def test_a_damped_line_that_is_activated_slack_has_no_energy(text):
    """Nothing is given with its activation: shorter than its natural length, it is slack and not relaxing."""
    recorded = RecordedRun(deck(text.replace("MORE", "damping: 0.01, activate: {time: 0.1}")))
    event = recorded.event_records[0]
    assert (event.name, event.after, event.lost) == ("activates", "slack", 0.0)
    np.testing.assert_array_equal(recorded["energy/given"][recorded.time <= 0.15], 0.0)

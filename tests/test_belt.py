"""Belts and cables over pulleys: hoists, tackles, drives, drums."""

import math
import re

import numpy as np
import pytest
from time_runs import INPUTS, RecordedRun, deck, input_deck

from mecano.analyses.dynamic import run
from mecano.analyses.prepare import prepare, warnings_of
from mecano.deck.format import deck_error_text
from mecano.deck.read import deck_of_bytes
from mecano.errors import ConvergenceError, DeckError

S, g = "Belts and cables over pulleys", 9.81


def test_a_closed_belt_without_pretension_is_warned_of():
    (said,) = warnings_of(prepare(input_deck("belt_drive", "elements.belt.pretension=0")))
    assert "belt 'belt': it is closed without 'pretension'" in said and "belt_drive.yaml:" in said
    assert warnings_of(prepare(input_deck("belt_drive"))) == []


def test_a_block_and_tackle(verify):
    recorded = RecordedRun(input_deck("block_and_tackle"))
    M, m, turned = 10.5, 4.0, 2.5e-3 / 0.1**2
    a = (M - 2 * m) * g / (M + 4 * m + 5 * turned)
    falls = -recorded["nodes/loose/velocity"][-1, 2]
    verify(S, "block and tackle: speed of the load after 0.5 s [m/s]", falls, 0.5 * a, "momentum", relative=1e-4)
    assert recorded["nodes/weight/velocity"][-1, 2] == pytest.approx(a, rel=1e-9)
    assert recorded["joints/bearing/rate"][-1] == pytest.approx(-10 * a, rel=1e-9)
    tensions = np.array([recorded[f"elements/rope/tension_{i}"][-1] for i in (1, 2, 3)])
    exact = m * (g + 2 * a) + turned * a * np.array([3.0, 2.0, 0.0])
    verify(S, "block and tackle: tensions [N]", tensions, exact, "equilibrium of each pulley", relative=1e-5)
    assert np.ptp(recorded["energy/balance"]) < 1e-6 * M * g


@pytest.mark.parametrize(("radius", "sense"), [(0.25, 1.0), (-0.25, -1.0)], ids=["open", "crossed"])
def test_a_belt_drive(verify, radius, sense):
    recorded = RecordedRun(input_deck("belt_drive", f"elements.belt.radii=[0.1, {radius}]"))
    name = "open" if sense > 0.0 else "crossed"
    rates = [recorded[f"joints/{joint}/rate"][-1] for joint in ("motor", "machine")]
    verify(S, f"belt drive, {name}: rates after 1 s [rad/s]", rates, [60.0, sense * 24.0], "momentum", relative=1e-4)
    tensions = sorted(recorded[f"elements/belt/tension_{i}"][-1] for i in (1, 2))
    verify(S, f"belt drive, {name}: tensions [N]", tensions, [176.0, 224.0], "momentum", relative=1e-4)


def test_a_loose_belt_slackens_on_one_side():
    """The mean of the tensions remains that at rest only while both spans are taut; then one span carries all."""
    recorded = RecordedRun(input_deck("belt_drive", "elements.belt.pretension=10"))
    assert "goes slack" in {event.name for event in recorded.event_records}
    tensions = sorted(recorded[f"elements/belt/tension_{i}"][-1] for i in (1, 2))
    np.testing.assert_allclose(tensions, [0.0, 48.0], rtol=1e-9, atol=1e-9)


CREEP = """
    mecano: 1
    gravity: none
    parameters: {sense: SENSE, moment: -40}
    nodes: {motor: {position: [0, 0, 0]}, machine: {position: [0.8, 0, 0]}}
    elements:
      motor: {type: rigid_body, node: motor, mass: 2, inertia: [0.02, 0.02, 0.02]}
      machine: {type: rigid_body, node: machine, mass: 8, inertia: [0.3, 0.05, 0.3]}
      belt: {type: belt, nodes: [motor, machine], radii: [0.1, 0.2], axis: [0, 1, 0], closed: true,
             axial_stiffness: 20 kN, damping: 5 ms, pretension: 300, creep: true}
    joints:
      motor: {type: hinge, nodes: [ground, motor], axis: [0, 1, 0]}
      shaft: {type: hinge, nodes: [ground, machine], axis: [0, 1, 0]}
      drive: {type: prescribed_angle, nodes: [ground, motor], axis: [0, 1, 0], value: 50*$sense*time}
    loads: {load: {type: joint_moment, joint: shaft, value: $moment*$sense}}
    initial:
      velocities:
        - {nodes: [motor], angular_velocity: [0, 50*$sense, 0], about: own}
        - {nodes: [machine], angular_velocity: [0, 25*$sense, 0], about: own}
    time: {end: 0.5, step: 1 ms}
"""


@pytest.mark.slow
def test_a_belt_creeps(verify):
    """The belt is fed at the same mass per time everywhere: (1 + e_2)/(1 + e_1) of the speed, 1 - (T_1 - T_2)/EA."""
    ratios, lost = [], []
    for sense, moment in ((1, -40), (-1, -40), (1, 40)):
        m = RecordedRun(deck(CREEP.replace("SENSE", str(sense)).replace("moment: -40", f"moment: {moment}")))
        slack, tight = sorted(m[f"elements/belt/tension_{i}"][-1] for i in (1, 2))
        assert tight - slack == pytest.approx(200.0, rel=1e-5) and slack == pytest.approx(200.0, rel=5e-3)
        fast, slow = (20e3 + tight, 20e3 + slack) if moment > 0 else (20e3 + slack, 20e3 + tight)
        ratios.append([m["joints/shaft/rate"][-1] / (25.0 * sense), fast / slow])
        power = np.diff(m["energy/dissipated"].ravel()[-2:])[0] / np.diff(m.time[-2:])[0]
        lost.append([power, moment * (abs(m["joints/shaft/rate"][-1]) - 25.0)])
        assert abs(ratios[-1][0] - 1.0) == pytest.approx(0.01, rel=0.03)
    source = "conservation of mass"
    verify(S, "belt that creeps, either way: speed ratio", *np.transpose(ratios), source, relative=1e-6)
    verify(S, "the same: dissipated power [W]", *np.transpose(lost), "speed lost times moment", relative=1e-4)


@pytest.mark.slow
def test_a_belt_that_creeps_is_elastic_at_rest():
    """A moment of 40 N m on a shaft at rest: the tensions differ by 200 N, about the pretension."""
    text = CREEP.replace("SENSE", "0").replace("value: $moment*$sense", "value: -40")
    text = re.sub("initial:(\n.*)*    time:", "initial: static\n    time:", text).replace("end: 0.5", "end: 5 ms")
    m = RecordedRun(deck(text))
    assert sorted(m[f"elements/belt/tension_{i}"][-1] for i in (1, 2)) == pytest.approx([200.0, 400.0], rel=1e-6)
    assert max(abs(m[f"elements/belt/creep_{i}"]).max() for i in (1, 2)) < 1e-12


@pytest.mark.parametrize("option", ["release", "activate"])
def test_a_belt_that_creeps_is_neither_released_nor_activated(option):
    with pytest.raises(DeckError) as error:
        deck(CREEP.replace("SENSE", "1").replace("creep: true", f"creep: true, {option}: {{time: 1}}"))
    assert f"'creep' and '{option}' exclude one another" in error.value.problems[0].message


def test_a_belt_along_a_panel_synchronises_the_next():
    """As the coupler of the deck does: it turns by -2 times the angle of the first, which latches at 3.5154 s."""
    text = (INPUTS / "synchronised_panels.yaml").read_text()
    coupler = re.search(r"  synchronisation: .*\n", text)[0]
    belt = """  cable: {type: belt, nodes: [base, end], radii: [0.1, 0.05], axis: [0, 0, 1], closed: true,
          axial_stiffness: 1.0e5, pretension: 50, damping: 5 ms}
"""
    text = text.replace(coupler, "").replace("nodes:\n", "nodes:\n  base: {position: [0, 0, 0], fixed: true}\n", 1)
    recorded = RecordedRun(deck(text.replace("elements:\n", "elements:\n" + belt, 1)))
    (locked,) = (event.t for event in recorded.event_records if event.name == "locks")
    assert locked == pytest.approx(3.5154, abs=2e-3)
    before = recorded.time < 3.5
    first, second = (recorded[f"joints/{name}_hinge/angle"][before] for name in ("root", "elbow"))
    np.testing.assert_allclose(second, -2.0 * first, atol=1.5e-3)  # 0.6 N m over the 500 N m/rad of the cable


FAST = """
    mecano: 1
    gravity: none
    nodes: {motor: {position: [0, 0, 0]}, machine: {position: [0.3, 0, 0]}}
    elements:
      motor: {type: rigid_body, node: motor, mass: 1, inertia: [2, 2, 3]}
      machine: {type: rigid_body, node: machine, mass: 1, inertia: [0.1, 0.1, 0.1]}
      belt: {type: belt, nodes: [motor, machine], radii: [0.1, 0.05], axis: [0, 0, 1], closed: true,
             axial_stiffness: 1.0e7, pretension: 100, damping: 0.1 ms}
    joints:
      shaft_$i: {repeat: {i: [motor, machine]}, type: hinge, nodes: [ground, $i], axis: [0, 0, 1]}
    initial:
      velocities:
        - {nodes: [motor], angular_velocity: [0, 0, 500], about: own}
        - {nodes: [machine], angular_velocity: [0, 0, 1000], about: own}
    time: {end: 6, step: 2 ms}
"""


def test_a_belt_turns_as_long_as_it_likes():
    """Within a step the stretch of a span keeps its digits beside the 300 m that have run over the pulleys."""
    recorded = RecordedRun(deck(FAST))
    assert recorded["joints/shaft_machine/angle"][-1] == pytest.approx(6000.0, rel=1e-12)
    assert recorded["elements/belt/tension_1"][-1] == pytest.approx(100.0, rel=1e-7)
    assert recorded.run.iterations == recorded.run.steps == 3000


DRUM = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      drum: {position: [0, 0, 0], orientation: [0.3, 0, 0]}
      weight: {position: [0.1, 0, -1]}
    elements:
      drum: {type: rigid_body, node: drum, mass: 5, inertia: [0.06, 0.06, 0.06]}
      weight: {type: point_mass, node: weight, mass: 4}
      rope: {type: belt, nodes: [weight, drum], radii: [0, RADIUS], axis: AXIS, axial_stiffness: 1.0e6, damping: 0.001,
             pretension: 23.544}
    joints:
      bearing: {type: hinge, nodes: [ground, drum], axis: [0, 1, 0]}
    time: {end: 1.0, step: 1.0e-3}
"""


@pytest.mark.parametrize(("radius", "axis"), [("-0.1", "[0, 1, 0]"), ("0.1", "[0, -1, 0]")])
def test_a_drum_unwinds_over_many_turns(radius, axis):
    """The weight falls with m g/(m + I/r^2) = g 4/10, three turns of the drum in 1 s; its own axes are inclined."""
    recorded = RecordedRun(deck(DRUM.replace("RADIUS", radius).replace("AXIS", axis)))
    a = 0.4 * g
    assert recorded["nodes/weight/velocity"][-1, 2] == pytest.approx(-a, rel=1e-9)
    angle = abs(recorded["joints/bearing/angle"][-1])
    assert angle > 2 * math.pi * 3 and angle == pytest.approx(0.5 * a / 0.1, rel=1e-9)
    assert recorded["elements/rope/tension_1"][-1] == pytest.approx(4 * (g - a), rel=1e-5)


@pytest.mark.parametrize(
    "change, message",
    [
        (("radii: [0, 0.1]", "radii: [0, 0.1, 0]"), "'radii' must have 2 numbers, one for each node; it has 3"),
        (("radii: [0, 0.1]", "radii: [0, 0]"), "a cable without pulleys is a 'cable'"),
        (
            ("radii: [0, 0.1]", "radii: [0, 2]"),
            "'drum' and 'weight' are 1.005 m apart, and must be more than 2 m apart",
        ),
        (("axis: [0, -1, 0], axial", "axis: [0, -1, 0.9], axial"), "apart along it, not in one plane"),
        (("nodes: [weight, drum]", "nodes: [weight, drum, weight]"), "node 'weight' is named twice"),
    ],
)
def test_errors(change, message):
    text = DRUM.replace("RADIUS", "0.1").replace("AXIS", "[0, -1, 0]")
    assert change[0] in text
    with pytest.raises(DeckError) as info:
        deck_of_bytes(text.replace(*change).replace("\n    ", "\n").strip().encode(), "deck.yaml")
    found = deck_error_text(info.value)
    assert found.startswith("deck.yaml:") and message in found


@pytest.mark.parametrize("control", ["step: 1.0e-3", "step: 1.0e-3, method: radau"])
def test_pulleys_that_touch_end_the_run(control, tmp_path):
    """At the distance of the difference of the radii the belt has no free span."""
    text = f"""
        mecano: 1
        gravity: none
        nodes: {{a: {{position: [0, 0, 0], fixed: true}}, b: {{position: [1, 0, 0]}}}}
        elements:
          wheel: {{type: rigid_body, node: b, mass: 1, inertia: [1, 1, 1]}}
          loop: {{type: belt, nodes: [a, b], radii: [0.1, 0.3], axis: [0, 0, 1], axial_stiffness: 500}}
        joints: {{slide: {{type: prismatic, nodes: [ground, b], axis: [1, 0, 0]}}}}
        initial: {{velocities: [{{nodes: [b], velocity: [-2, 0, 0]}}]}}
        time: {{end: 1, {control}}}
    """
    with pytest.raises(ConvergenceError, match="belt 'loop' has no free span left between 'a' and 'b': they are too"):
        run(deck(text), tmp_path / "closing.h5")


def test_a_satellite_is_stopped_by_a_yo_yo(verify):
    """Energy and angular momentum are conserved while the cords unwind; they are cut when the spin has vanished."""
    recorded = RecordedRun(input_deck("yo_yo_despin"))
    radius, inertia, mass, start, spin = 0.5, 4.0, 0.2, 0.05, 2 * np.pi
    C = radius**2 + inertia / (2 * mass)
    free, rate = recorded["elements/cord_1/span_1"], recorded["joints/axle/rate"]
    taut = free < np.sqrt(C)
    length = free[taut]
    # C W + l^2 u = (C + l_0^2) W_0 and C W^2 + l^2 u^2 = (C + l_0^2) W_0^2, with u the rate of the cords' direction
    total = (C + start**2) * spin
    root = np.sqrt(C * np.maximum(length**2 - start**2, 0.0) * (C + start**2)) / length
    u = (total + spin * root) / (C + length**2)
    exact = (total - length**2 * u) / C
    verify(S, "yo-yo despin: spin while the cords unwind [rad/s]", rate[taut], exact, "Fedor 1961", absolute=1e-4)
    verify(S, "yo-yo despin: spin at the end [rad/s]", rate[-1], 0.0, "Fedor 1961", absolute=1e-3)

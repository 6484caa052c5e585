"""Rigid contacts with friction of blocks, balls and dominoes, compared with closed forms."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from time_runs import RecordedRun, deck

from mecano.errors import ConvergenceError

S, g = "Contact", 9.81


def stack(n, side=0.1, turn=0.0):
    """Return the text of a deck of n cubes of 1 kg, turned about z, on one another, with contacts at four corners."""
    turned = math.sqrt(0.5) * side * np.exp(1j * (turn + math.pi / 4 * np.array([1, 3, 5, 7])))
    orientation, nodes, elements = f"orientation: [0, 0, {turn}]", [], []
    for i in range(n):
        own = [f"corner_{i}_{c}" for c in range(4)]
        nodes.append(f"block_{i}: {{position: [0, 0, {(i + 0.5) * side}], {orientation}}}")
        nodes += [f"{c}: {{position: [{p.real}, {p.imag}, {i * side}]}}" for c, p in zip(own, turned, strict=True)]
        inertia = f"inertia: {[side**2 / 6] * 3}"
        elements.append(f"body_{i}: {{type: rigid_body, node: block_{i}, attached: {own}, mass: 1, {inertia}}}")
        below = f"block_{i - 1}" if i else "ground"
        plane = f"plane: {{normal: [0, 0, 1], point: [0, 0, {i * side}]}}"
        rough = "friction: {coefficient: 0.5, regularization: 1 mm/s}"
        elements += [f"on_{i}_{c}: {{type: contact, nodes: [{below}, {own[c]}], {plane}, {rough}}}" for c in range(4)]
    sections = "nodes:\n  {}\nelements:\n  {}\n".format("\n  ".join(nodes), "\n  ".join(elements))
    return f"mecano: 1\ngravity: [0, 0, -9.81]\n{sections}time: {{end: 0.1, step: 1 ms, rho_inf: 0}}"


@pytest.mark.parametrize("turn", [0.0, 0.3, 0.8, 1.9, 2.6, 4.1, 5.5])
def test_the_corners_of_a_block_share_its_weight_however_it_is_turned(turn):
    """One of the four is redundant, which the intermediate values of its pivot do not show at every angle."""
    recorded = RecordedRun(deck(stack(1, turn=turn)))
    assert recorded.run.compliance is not None
    forces = [recorded[f"elements/on_0_{c}/normal_force"] for c in range(4)]
    np.testing.assert_allclose(forces, g / 4, rtol=1e-4)


def test_a_stack_of_blocks_at_rest_stays_at_rest():
    """All contacts close at the start, though the compliances of redundant ones displace the blocks below."""
    n = 4
    recorded = RecordedRun(deck(stack(n)))
    assert sorted((event.t, event.name) for event in recorded.event_records) == 4 * n * [(0.0, "closes")]
    assert recorded.run.dissipated == pytest.approx(0.0, abs=1e-15)
    for i in range(n):
        forces = [recorded[f"elements/on_{i}_{c}/normal_force"] for c in range(4)]
        np.testing.assert_allclose(forces, (n - i) * g / 4, rtol=1e-5)
        np.testing.assert_allclose(recorded[f"nodes/block_{i}/position"][:, 2], 0.1 * (i + 0.5), atol=1e-10)


def test_a_block_slides_to_rest_on_its_corners(verify):
    """It stops after v^2/(2 mu g), and loses its kinetic energy; no corner opens."""
    v, mu = 2.0, 0.3
    recorded = RecordedRun(deck(f"""
        mecano: 1
        gravity: [0, 0, -{g}]
        nodes:
          block: {{position: [0, 0, 0.05]}}
          $corner:
            repeat: [{{corner: a, x: 0.1, y: 0.1}}, {{corner: b, x: 0.1, y: -0.1}},
                     {{corner: c, x: -0.1, y: 0.1}}, {{corner: d, x: -0.1, y: -0.1}}]
            position: [$x, $y, 0]
        elements:
          body: {{type: rigid_body, node: block, attached: [a, b, c, d], mass: 2, inertia: [0.01, 0.01, 0.01]}}
          on_$corner:
            repeat: [{{corner: a}}, {{corner: b}}, {{corner: c}}, {{corner: d}}]
            type: contact
            nodes: [ground, $corner]
            plane: {{normal: [0, 0, 1], point: [0, 0, 0]}}
            friction: {{coefficient: {mu}, regularization: 1 mm/s}}
        initial: {{velocities: [{{nodes: all, velocity: [{v}, 0, 0]}}]}}
        time: {{end: 1, step: 2 ms, rho_inf: 0}}
    """))  # fmt: skip
    way, source = recorded["nodes/block/position"][-1, 0], "v^2/(2 mu g)"
    verify(S, "block sliding to rest: distance [m]", way, v**2 / (2 * mu * g), source, relative=1e-5)
    verify(S, "block sliding to rest: energy lost [J]", recorded.run.dissipated, v**2, "m v^2/2", relative=1e-6)
    assert {event.t for event in recorded.event_records} == {0.0}
    front, back = (recorded[f"elements/on_{corner}/normal_force"] for corner in "ac")
    sliding = recorded.time < 0.9 * v / (mu * g)
    np.testing.assert_allclose((front - back)[sliding], 2 * g * mu * 0.05 / 0.2, rtol=1e-4)  # moment of the friction
    np.testing.assert_allclose((front + back)[sliding], g, rtol=1e-6)


def test_a_ball_slides_then_rolls_with_five_sevenths_of_its_speed(verify):
    """On a rigid plane: 2/7 of the energy are lost, and the ball rolls after 2 v/(7 mu g)."""
    recorded = RecordedRun(deck(f"""
        mecano: 1
        gravity: [0, 0, -{g}]
        nodes: {{ball: {{position: [0, 0, 0.1]}}}}
        elements:
          ball: {{type: rigid_body, node: ball, mass: 2, inertia: [8.0e-3, 8.0e-3, 8.0e-3]}}
          floor: {{type: contact, nodes: [ground, ball], plane: {{normal: [0, 0, 1], point: [0, 0, 0]}}, radius: 0.1,
                   friction: {{coefficient: 0.2, regularization: 0.1 mm/s}}}}
        initial: {{velocities: [{{nodes: [ball], velocity: [1.4, 0, 0]}}]}}
        time: {{end: 0.3, step: 1 ms, rho_inf: 0}}
    """))  # fmt: skip
    speed = recorded["nodes/ball/velocity"][:, 0]
    verify(S, "ball on a rigid plane: rolls at [m/s]", speed[-1], 1.0, "5/7 v (Coriolis 1835)", relative=1e-9)
    verify(S, "ball on a rigid plane: energy lost [J]", recorded.run.dissipated, 0.56, "m v^2/7", relative=1e-6)
    rolls = recorded.time[np.argmax(speed < 1.0005)]
    verify(S, "ball on a rigid plane: rolls after [s]", rolls, 2.8 / (1.4 * g), "2 v/(7 mu g)", absolute=1e-3)


def test_a_domino_topples_the_next(verify):
    """Dominoes on hinges at their lower front edges, smooth: both leave the impact with half of the rate of the first.

    The time of the fall follows from the energy of the first domino. The contact under the back edge of the second
    opens in the impact.
    """
    h, t, pitch, mass, rate = 0.05, 0.008, 0.025, 0.02, 12.0
    own, about_edge = mass / 12 * (h**2 + t**2), mass / 3 * (h**2 + t**2)
    recorded = RecordedRun(deck(f"""
        mecano: 1
        gravity: [0, 0, -{g}]
        parameters: {{m: {mass}, own: {own}}}
        nodes:
          first: {{position: [0, 0, {h / 2}]}}
          first_front: {{position: [{t / 2}, 0, 0]}}
          top: {{position: [{t / 2}, 0, {h}]}}
          second: {{position: [{pitch}, 0, {h / 2}]}}
          front: {{position: [{pitch + t / 2}, 0, 0]}}
          back: {{position: [{pitch - t / 2}, 0, 0]}}
        elements:
          first: {{type: rigid_body, node: first, attached: [first_front, top], mass: $m, inertia: [$own, $own, $own]}}
          second: {{type: rigid_body, node: second, attached: [front, back], mass: $m, inertia: [$own, $own, $own]}}
          floor: {{type: contact, nodes: [ground, back], plane: {{normal: [0, 0, 1], point: [0, 0, 0]}}}}
          hit: {{type: contact, nodes: [second, top], plane: {{normal: [-1, 0, 0], point: [{pitch - t / 2}, 0, 0]}}}}
        joints:
          one: {{type: hinge, nodes: [ground, first_front], axis: [0, 1, 0]}}
          two: {{type: hinge, nodes: [ground, front], axis: [0, 1, 0]}}
        initial:
          velocities:
            - {{nodes: [first, first_front, top], angular_velocity: [0, {rate}, 0], about: [{t / 2}, 0, 0]}}
        time: {{end: 0.03, step: 0.25 ms}}
    """))  # fmt: skip

    def falling(angle):
        """Return the rate [rad/s] of the first domino."""
        sinks = (h - t * math.sin(angle) - h * math.cos(angle)) / 2
        return math.sqrt(rate**2 + 2 * mass * g * sinks / about_edge)

    angle = math.asin((pitch - t) / h)
    before, hit = falling(angle), next(event for event in recorded.event_records if event.element == "contact 'hit'")
    source, time = "energy and moments about the edges", quad(lambda x: 1 / falling(x), 0.0, angle)[0]
    verify(S, "domino: falls on the next after [s]", hit.t, time, source, relative=1e-5)
    impulse = about_edge * before / (2 * h * math.cos(angle))
    verify(S, "domino: impulse [N s]", hit.impulse, impulse, source, relative=1e-5)
    verify(S, "domino: energy lost [J]", hit.lost, about_edge * before**2 / 4, source, relative=1e-5)
    assert [event.name for event in recorded.event_records if event.t == hit.t] == ["closes", "opens"]


def test_a_ball_rolls_over_the_corner_of_two_rails_if_one_contact_is_elastic(verify):
    """On the common end of both rails each rigid contact repeats the other, and neither opens where the ball leaves it.

    A rolling ball has 7/5 of the kinetic energy of its translation.
    """
    radius, v, rough = 0.01, 0.2, "friction: {coefficient: 0.6, regularization: 0.1 mm/s}"
    text = f"""
        mecano: 1
        gravity: [0, 0, -{g}]
        nodes: {{ball: {{position: [-0.02, 0, 0.011]}}}}
        elements:
          ball: {{type: rigid_body, node: ball, mass: 0.1, inertia: [4e-6, 4e-6, 4e-6]}}
          flat:
            {{type: contact, nodes: [ground, ball], radius: {radius}, {rough},
             capsule: {{axis: [1, 0, 0], length: 0.1, radius: 1 mm, center: [-0.1, 0, 0]}}}}
          slope:
            {{type: contact, nodes: [ground, ball], radius: {radius}, {rough}, LAW
             capsule: {{axis: [1, 0, -0.5], length: 0.2, radius: 1 mm, center: [0, 0, 0]}}}}
        joints: {{plane: {{type: planar, nodes: [ground, ball], axis: [0, 1, 0]}}}}
        initial:
          velocities: [{{nodes: [ball], angular_velocity: [0, {v / radius}, 0], about: [-0.02, 0, 0.001]}}]
        time: {{end: 0.25, step: 1 ms}}
    """
    with pytest.raises(ConvergenceError, match="contradict one another") as error:
        RecordedRun(deck(text.replace("LAW", "")))
    assert "a law in one of them" in str(error.value)
    recorded = RecordedRun(deck(text.replace("LAW", "law: {polynomial: [0, 1.0e5]}, damping: 10,")))
    fall = 0.011 - recorded["nodes/ball/position"][-1, 2]
    speed = np.linalg.norm(recorded["nodes/ball/velocity"][-1])
    verify(S, "ball over a corner: speed [m/s]", speed, math.sqrt(v**2 + 10 / 7 * g * fall), "energy", relative=2e-3)

"""Forces that oscillate faster than the steps are reported by name; resolved oscillations are not."""

from itertools import pairwise

import numpy as np
import pytest
from time_runs import deck, input_deck

from mecano import open_results
from mecano.analyses.diagnostics import _remedy
from mecano.analyses.dynamic import run
from mecano.solve.time.unresolved_oscillation import OscillationMonitor

OSCILLATOR = """
mecano: 1
gravity: [0, 0, 0]
nodes:
  wall: {{position: [0, 0, 0], fixed: true}}
  mass: {{position: [1, 0, 0]}}
elements:
  body: {{type: point_mass, node: mass, mass: 1.0}}
  spring:
    {{type: spring_damper, nodes: [wall, mass], natural_length: 0.999, law: {{spring: {{stiffness: {stiffness}}}}}}}
time: {{end: 1.0, step: 0.01, rho_inf: 1.0}}
"""


@pytest.mark.parametrize(("phase", "rings"), [(0.3, False), (10.0, True)])
def test_a_spring_that_swings_within_a_step_is_named(phase, rings, tmp_path):
    """Circular frequency times step: 0.3 has 21 steps in a period, 10 more than one period in a step."""
    said = []
    run(deck(OSCILLATOR.format(stiffness=(phase / 0.01) ** 2)), tmp_path / "r.h5", announce=said.append)
    with open_results(tmp_path / "r.h5") as results:
        reason = results.reason
    texts = [text for text in said if "do not resolve" in text]
    assert len(texts) == rings and ("elements.spring.force by" in reason) == rings
    if rings:
        assert "use a smaller 'time.step'" in texts[0] and texts[0] in reason and "larger tolerance" not in texts[0]


def test_a_run_with_error_control_may_need_a_larger_tolerance():
    """The rounding of positions, divided by the squares of tiny steps, oscillates in forces, too."""
    text = _remedy({"adaptive": {"tolerance": 1e-4}, "method": "generalized_alpha", "rho_inf": 0.9})
    assert "use a smaller 'time.adaptive.tolerance'" in text and text.endswith("use a larger tolerance then")


DRIVEN = """
mecano: 1
gravity: none
nodes: {{mass: {{position: [0, 0, 0]}}}}
elements: {{body: {{type: rigid_body, node: mass, mass: 2.0, inertia: [1, 1, 1]}}}}
joints:
  rail: {{type: prismatic, nodes: [ground, mass], axis: [1, 0, 0]}}
  drive: {{type: prescribed_position, node: mass, direction: [1, 0, 0], value: {{acceleration: {{points: {points}}}}}}}
time: {{end: 1.0, step: {step}, rho_inf: {rho_inf}}}
"""


@pytest.mark.parametrize(("step", "rho_inf", "grows"), [(1e-2, 1.0, True), (1e-3, 1.0, True), (1e-2, 0.8, False)])
def test_without_numerical_damping_a_kink_of_the_acceleration_rings_more_and_more(step, rho_inf, grows, tmp_path):
    """The trapezoidal rule, solved for its rates, has the double root -1.

    After the slope of the acceleration changes by D, here 20 m/s3 at 0.1 s, velocities err by h^2 D/12 with alternating
    sign, and the error of accelerations grows in every step by 4/h of this: to D t/3, up to two of the 90 steps.
    """
    said = []
    given = DRIVEN.format(points="[[0, 0], [0.1, 2], [1, 2]]", step=step, rho_inf=rho_inf)
    run(deck(given), tmp_path / "r.h5", announce=said.append)
    with open_results(tmp_path / "r.h5") as results:
        force = results["drive.force"].values
    assert sum("use a smaller 'rho_inf'" in text for text in said) == grows
    swing = 0.5 * abs(force[-1] - force[-2])
    assert swing == pytest.approx(2.0 * 20.0 * 0.9 / 3.0, rel=2 / 90) if grows else swing < 1e-3


def test_rounding_of_a_free_motion_is_no_oscillation(tmp_path):
    """A grip in a free body carries 1e-11 N m; the kinetic energy is 0.1 J, the length scale 1 m."""
    said = []
    text = """
        mecano: 1
        gravity: none
        nodes: {a: {position: [0, 0, 0]}, b: {position: [0, 0, 0]}}
        elements:
          one: {type: rigid_body, node: a, mass: 1, inertia: [0.1, 0.1875, 0.1875]}
          two: {type: rigid_body, node: b, mass: 1, inertia: [0.1, 0.1875, 0.1875]}
        joints:
          pin: {type: hinge, nodes: [a, b], axis: [0, 1, 0]}
          hold: {type: grip, nodes: [a, b], close: {time: 0.1}}
        initial: {velocities: [{nodes: [b], angular_velocity: [0, 1, 0]}]}
        time: {end: 1, step: 0.01}
        """
    run(deck(text), tmp_path / "r.h5", announce=said.append)
    assert not [line for line in said if "do not resolve" in line]


def test_rounding_of_a_drive_that_needs_no_moment_is_no_oscillation(tmp_path):
    """A balanced crank turns at a constant rate and moves rods without mass: its drive carries 2e-12 N m."""
    said = []
    text = """
        mecano: 1
        gravity: none
        nodes:
          o: {position: [0, 0, 0], fixed: true}
          crank: {position: [0.2, 0, 0]}
          pin: {position: [0.36506712298193567, 0, 0.11292849467900707]}
          a: {position: [0.1956, 0, 0.4602]}
        elements:
          crank: {type: rigid_body, node: crank, mass: 1, inertia: [1.0e-3, 1.0e-3, 1.0e-3], attached: [pin]}
        joints:
          hinge: {type: hinge, nodes: [ground, crank], axis: [0, -1, 0]}
          drive: {type: prescribed_angle, nodes: [ground, crank], axis: [0, -1, 0], value: -1.3*time}
          outer: {type: rigid_rod, nodes: [o, a]}
          inner: {type: rigid_rod, nodes: [pin, a]}
          plane: {type: prescribed_position, node: a, direction: [0, 1, 0], value: 0}
        time: {end: 1, step: 5 ms}
        """
    run(deck(text), tmp_path / "r.h5", announce=said.append)
    assert not [line for line in said if "do not resolve" in line]


@pytest.mark.parametrize("name", ["elliptical_gears", "gimbal"])
def test_residuals_beside_moments_are_no_oscillation(name, tmp_path):
    """Moments of some N m and no forces: what Newton's iteration leaves of these, 1e-8 N, changes from step to step."""
    said = []
    run(input_deck(name), tmp_path / "r.h5", announce=said.append)
    assert not [line for line in said if "do not resolve" in line]


def test_swings_are_counted_from_step_to_step():
    """Five changes of sign in eight steps; an event resets the count; the largest oscillation and its time are kept."""
    watch = OscillationMonitor(np.array([1]))
    for i, (x0, x) in enumerate(pairwise((5.0, 6.0, 4.0, 6.0, 4.0, 7.0, 4.0))):
        assert not watch.found(np.zeros(1))
        watch.take(0.1 * i, np.array([0.0, x0]), np.array([0.0, x]))
    (found,) = watch.found(np.zeros(1))
    assert (found.column, found.swing, found.largest, found.time) == (1, 3.0, 7.0, 0.5)
    assert not watch.found(np.array([3.0]))
    again = OscillationMonitor(np.array([1]))
    again.from_plain(watch.to_plain())
    assert [vars(one) for one in again.found(np.zeros(1))] == [vars(found)]
    watch.begin()
    for i, (x0, x) in enumerate(pairwise((0.0, 9.0, 0.0, 9.0, 0.0))):
        watch.take(1.0 + 0.1 * i, np.array([0.0, x0]), np.array([0.0, x]))
    assert watch.found(np.zeros(1))[0].time == 0.5
    smooth = OscillationMonitor(np.array([0]))
    sines = [np.array([np.sin(0.5 * np.pi * i)]) for i in range(101)]  # a period of four steps
    for i, (x0, x) in enumerate(pairwise(sines)):
        smooth.take(0.1 * i, x0, x)
    assert not smooth.found(np.zeros(1))

"""Oscillations too fast for the steps gain no energy and are filtered from the error; resolved motions are not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from time_runs import RecordedRun, deck

import mecano
from mecano.analyses import dynamic

TOLERANCE = 1e-3


def oscillator(k, stretch, time):
    """Return a mass of 1 kg on a spring of k [N/m], displaced by ``stretch`` [m], beside one that moves slowly."""
    return deck(f"""
        mecano: 1
        gravity: [0, 0, 0]
        nodes:
          hook: {{position: [0, 0, 0], fixed: true}}
          weight: {{position: [{1.0 + stretch}, 0, 0]}}
          slow: {{position: [0, 3, 0]}}
        elements:
          mass: {{type: point_mass, node: weight, mass: 1.0}}
          spring:
            {{type: spring_damper, nodes: [hook, weight], law: {{spring: {{stiffness: {k}}}}}, natural_length: 1}}
          load: {{type: point_mass, node: slow, mass: 1.0}}
          string: {{type: spring_damper, nodes: [hook, slow], law: {{spring: {{stiffness: 1.0}}}}, natural_length: 2}}
        time: {time}
    """)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8])
def test_a_stiff_member_gains_no_energy_at_a_start_and_where_steps_grow(rho):
    """With the unfiltered acceleration, energy grows by (omega h)^2/16 of itself for rho_inf 0 (theory.md, 2.1)."""
    stiffness, stretch = 4e6, 1e-6  # omega h = 40

    time = f"{{end: 0.4, step: 0.02, rho_inf: {rho}}}"
    recorded = RecordedRun(oscillator(stiffness, stretch, time), change=lambda integrator, run: replace(run, h=1e-3))
    x, v = (recorded[f"nodes/weight/{name}"][:, 0] for name in ("position", "velocity"))
    assert recorded.run.steps > 20 and np.diff(recorded.time).max() > 19e-3
    assert (0.5 * v**2 + 0.5 * stiffness * (x - 1.0) ** 2).max() <= 1.01 * 0.5 * stiffness * stretch**2


@pytest.mark.parametrize(("rho", "damping"), [(0.8, 1e-9), (0.5, 1e4)])
def test_a_stiff_member_that_turns_does_not_ring_at_a_start_and_after_a_corner(rho, damping):
    """The tension stays m w^2 r up to half the square of the turn in a step, 0.03 rad; F alone: off by 0.24."""
    stiffness, speed = 1e8, 30.0  # omega h = 10
    text = f"""
        mecano: 1
        gravity: none
        nodes:
          hook: {{position: [0, 0, 0], fixed: true}}
          weight: {{position: [{(radius := stiffness / (stiffness - speed**2))!r}, 0, 0]}}
          slow: {{position: [0, 3, 0]}}
        elements:
          mass: {{type: point_mass, node: weight, mass: 1.0}}
          spring: {{type: spring_damper, nodes: [hook, weight], natural_length: 1,
                    law: {{spring: {{stiffness: {stiffness}}}, damper: {{coefficient: {damping}}}}}}}
          load: {{type: point_mass, node: slow, mass: 1.0}}
        loads:
          push: {{type: force, node: slow, direction: [1, 0, 0],
                  value: {{table: {{points: [[0, 0], [0.0105, 0], [0.02, 1]], interpolation: linear}}}}}}
        initial: {{velocities: [{{nodes: [weight], velocity: [0, {speed * radius!r}, 0]}}]}}
        time: {{end: 0.03, step: 1.0e-3, rho_inf: {rho}}}
    """
    force = RecordedRun(deck(text))["elements/spring/force"]
    np.testing.assert_allclose(force, speed**2 * radius, rtol=0.5 * (speed * 1e-3) ** 2)


def test_steps_of_a_slow_motion_are_not_held_by_a_small_fast_one():
    """An oscillation of 1e-6 m at 1600 Hz beside one of 1 m changes the number of steps by less than a tenth."""
    time = "{end: 6, step: 1.0e-3, rho_inf: 0.8, adaptive: {tolerance: 1.0e-4, maximum_step: 0.5}}"
    still, swinging = (RecordedRun(oscillator(1e8, stretch, time)).run for stretch in (0.0, 1e-6))
    assert swinging.steps <= 1.1 * still.steps


@pytest.mark.parametrize("phase", [0.03, 0.1, 0.3, 1.0])
def test_a_mode_is_off_by_its_amplitude_at_most(phase):
    """At any resolution, the error counted is about the amplitude; the sum of errors is 60 to 70,000 times that."""
    frequency, amplitude, duration = 1e3, 1e-5, 1e3  # rad/s, m, s
    h = phase / frequency
    recorded = RecordedRun(oscillator(frequency**2, amplitude, f"{{end: {20 * h}, step: {h}, rho_inf: 0.8}}"))
    method, s = recorded.integrator.method, recorded.run.motion
    method.workspace.point_to(duration=duration)
    history, sums = recorded.run.history, []
    for _ in range(12):
        s, history, info = method.step(s, history, h)
        errors = np.array([method.bounded_error(s, history, info), info.plain])
        sums.append(errors * duration / h * method.length / amplitude)
    counted, plain = np.max(sums, axis=0)
    assert 0.5 <= counted <= 1.5 and plain > 40.0


def pendulum(angle, end):
    """Return a bar of 1 m on a hinge, ``angle`` [rad] from hanging, with the error at its end [rad]."""
    recorded = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes:
          pin: {{position: [0, 0, 0]}}
        elements:
          bar: {{type: rigid_body, node: pin, mass: 1.0, inertia: [1.0e-4, 0.1, 0.1],
            center_of_mass: [{np.sin(angle)}, 0, {-np.cos(angle)}]}}
        joints:
          hinge: {{type: hinge, nodes: [ground, pin], axis: [0, 1, 0]}}
        time: {{end: {end}, step: 1.0e-3, rho_inf: 0.9, adaptive: {{tolerance: {TOLERANCE}, maximum_step: 0.5}}}}
    """)
    )
    swing = lambda t, y: (y[1], -9.81 / 1.1 * np.sin(y[0]))
    exact = solve_ivp(swing, (0.0, end), (angle, 0.0), method="DOP853", rtol=1e-12, atol=1e-14).y[0, -1]
    # turning about y by the angle of the hinge takes off the angle from the vertical
    return recorded, abs(angle - recorded["joints/hinge/angle"][-1] - exact)


def test_a_motion_that_steps_resolve_keeps_to_the_tolerance():
    """Small oscillations for 75 periods: error within a factor 10 of the tolerance, as in test_adaptive.py."""
    recorded, error = pendulum(0.05, 150.0)
    assert recorded.run.steps > 75 * 20
    assert error <= 10.0 * TOLERANCE


@pytest.mark.parametrize("angle, counts_whole", [(np.pi - 0.05, True), (0.05, False)])
def test_what_grows_is_not_called_small(angle, counts_whole):
    """The error of a pendulum near its top, where the stiffness is negative, is not reduced by the filter."""
    recorded, _ = pendulum(angle, 0.1)
    method, run = recorded.integrator.method, recorded.run
    method.workspace.point_to(duration=1e5)
    s, history, info = method.step(run.motion, method.restart(run.motion, run.history, 0.02), 0.02)
    assert (method.bounded_error(s, history, info) == info.error) == counts_whole


def test_steps_of_a_beam_on_a_hinge_are_not_those_of_its_fast_modes():
    """A spring unfolds a tube: the error is within the tolerance in a fifth of the steps that its fast modes ask for.

    The multipliers of the hinge have no diagonal: factors with rows exchanged would not tell stable from unstable.
    """

    def unfolded(tolerance):
        run = RecordedRun(
            deck(f"""
            mecano: 1
            gravity: none
            sections: {{tube: {{type: tube, diameter: 30 mm, thickness: 1 mm, E: 120 GPa, nu: 0.3, density: 1600}}}}
            nodes: {{root: {{position: [0, 0, 0]}}, tip: {{position: [2, 0, 0]}}}}
            elements:
              rib: {{type: beam, nodes: [root, tip], section: tube, mesh: 4}}
              mass: {{type: point_mass, node: tip, mass: 0.3}}
            joints:
              hinge: {{type: hinge, nodes: [ground, root], axis: [0, 1, 0], natural_angle: 75 deg,
                       turning_law: {{spring: 1.2, damper: 0.5}}}}
            time: {{end: 0.5, step: 1 ms, rho_inf: 0.5, adaptive: {{tolerance: {tolerance}}}}}
        """)
        )
        return run.run.steps, run["nodes/tip/position"][-1]

    (steps, found), (_, expected) = unfolded(1e-4), unfolded(1e-6)
    assert steps < 1000
    np.testing.assert_allclose(found, expected, atol=2e-4)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-5])
def test_the_motion_between_long_steps_keeps_to_the_tolerance(tolerance, tmp_path):
    """A load of 2 kg follows the set point of its stiff spring (24 rad/s), in steps of up to 0.7 s."""
    stiffness, damping, mass, end = 1150.0, 23.0, 2.0, 15.0
    following = deck(f"""
        mecano: 1
        gravity: none
        nodes: {{hook: {{position: [0, 0, 0], fixed: true}}, load: {{position: [10, 0, 0]}}}}
        elements:
          load: {{type: point_mass, node: load, mass: {mass}}}
          spring: {{type: spring_damper, nodes: [hook, load], law: {{spring: {stiffness}, damper: {damping}}},
                    natural_length: {{step: {{time: 1, rise: 10, from: 10, to: 15}}}}}}
        time: {{end: {end}, step: 0.01, adaptive: {{tolerance: {tolerance}, length_scale: 20}}}}
        output: {{every: 50 ms}}
    """)
    steps = dynamic.run(following, tmp_path / "r.h5").steps
    saved = mecano.open_results(tmp_path / "r.h5")

    def motion(t, y):
        s = np.clip((t - 1.0) / 10.0, 0.0, 1.0)
        natural, rate = 10.0 + 5.0 * s**3 * (10.0 + s * (6.0 * s - 15.0)), 15.0 * (s - s * s) ** 2
        return y[1], -(stiffness * (y[0] - natural) + damping * (y[1] - rate)) / mass

    exact = solve_ivp(motion, (0.0, end), (10.0, 0.0), "LSODA", saved.time, rtol=1e-10, atol=1e-12, max_step=0.1).y[0]
    assert steps < 400
    assert np.abs(saved["nodes/load/position"][:, 0] - exact).max() <= 20.0 * tolerance

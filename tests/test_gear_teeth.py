"""Backlash, elasticity and efficiency of gear stages: against closed forms, an independent integration, Modelica."""

import math

import numpy as np
import pytest
from convergence import at_times
from scipy.integrate import solve_ivp
from time_runs import INPUTS, RecordedRun, deck, input_deck

from mecano.analyses.modal import modes
from mecano.errors import ConvergenceError, DeckError

S = "Gear stages"
MASSES = 1.0, 2.0  # of the gears a and b, reduced to the pitch circles [kg]


@pytest.fixture(scope="module")
def stages():
    return RecordedRun(input_deck("gear_stages"))


def test_rebounds_in_the_backlash(stages, verify):
    """Free flight of 2 mm between shocks with the restitution 1/2, and 2/3 kg of reduced mass at 1 m/s."""
    found = [(r.t, r.impulse, r.lost) for r in stages.event_records]
    n = np.arange(6)
    times = 1e-3 + 2e-3 * (2.0 * (2.0**n - 1.0))
    verify(S, "backlash: times of the shocks [s]", np.array(found)[:, 0], times, "free flight", relative=1e-9)
    verify(S, "backlash: impulses [N s]", np.array(found)[:, 1], 0.5**n, "momentum", relative=1e-9)
    verify(S, "backlash: energies lost [J]", np.array(found)[:, 2], 0.25 * 0.25**n, "momentum", relative=1e-9)
    assert np.ptp(stages["joints/loose/transmission_error"]) == pytest.approx(2e-3, rel=1e-9)
    assert not stages["joints/loose/force"].any()  # it never rests on a flank


RESTING = (
    "loads.motor.nodes=[ground, a_1]",
    "joints.loose.restitution=0",
    "joints.loose.friction={efficiency: 0.8, backdriving_efficiency: 0.6, regularization: 0.1 mm/s}",
)


def test_flanks_on_which_it_rests():
    """The motor presses a against the upper flank, until it reverses and crosses the play in sqrt(2 j/(30 m/s2))."""
    run = RecordedRun(input_deck("gear_stages", *RESTING))
    names, times, lost = zip(*((r.name, r.t, r.lost) for r in run.event_records), strict=True)
    assert names == ("meets upper flank", "leaves upper flank", "meets lower flank")
    crossing = math.sqrt(2.0 * 2e-3 / 30.0)
    assert times[1:] == pytest.approx([0.08, 0.08 + crossing], rel=1e-9)
    assert lost[2] == pytest.approx(0.5 * (2.0 / 3.0) * (30.0 * crossing) ** 2, rel=1e-9)
    force, t = run["joints/loose/force"], run.time
    driving, braking = 30.0 / (1.0 + 2.0 / 0.8), 30.0 / (1.0 + 2.0 * 0.6)
    np.testing.assert_allclose(force[(t > 0.01) & (t < 0.08)], -0.5 * (2.0 / 0.8 + 2.0) * driving, rtol=1e-6)
    np.testing.assert_allclose(force[t > 0.1], 0.5 * (2.0 * 0.6 + 2.0) * braking, rtol=1e-6)


def test_efficiency_in_both_directions(stages, verify):
    """The driven gear receives 0.8 of the power: 30 N on 1 kg + 2 kg/0.8 if a drives, on 1 kg + 2 kg 0.8 if b does."""
    t, v = stages.time, 0.1 * stages["joints/lossy/rate_a"]
    ends = at_times(stages, v, [0.08, 0.13])
    forward, backward = 30.0 / (1.0 + 2.0 / 0.8), 30.0 / (1.0 + 2.0 * 0.8)
    exact = 1.0 + 0.08 * forward, 1.0 + 0.08 * forward - 0.05 * backward
    verify(S, "efficiency: speeds after driving and braking [m/s]", ends, exact, "momentum", relative=1e-9)
    driving = (t > 1e-9) & (t < 0.08)
    np.testing.assert_allclose(stages["joints/lossy/force"][driving], -0.5 * (2.0 / 0.8 + 2.0) * forward, rtol=1e-6)
    power = stages["joints/lossy/dissipated_power"]
    np.testing.assert_allclose(power[driving], 0.2 * (2.0 / 0.8) * forward * v[driving], rtol=1e-6)
    braking = t > 0.08 + 1e-9
    np.testing.assert_allclose(power[braking], 0.2 * 2.0 * backward * v[braking], rtol=1e-6)


WORM = "joints.lossy.friction={efficiency: 0.4, backdriving_efficiency: -0.2, regularization: 0.1 mm/s}"
ENDS = "time={end: 0.09, step: 2.0e-5}", "output={every: 0.001}"


def test_a_worm_that_brakes_stops_itself(verify):
    """The worm a, 1 kg, cannot be driven by the wheel b, 2 kg, of which it takes 0.2 times the force to be turned.

    The motor drives with 30 N, then brakes, and drives backward after the stop.
    """
    run = RecordedRun(input_deck("gear_stages", WORM, "loads.motor.value.step.time=20 ms", *ENDS))
    forward, braking = 30.0 / (1.0 + 2.0 / 0.4), 30.0 / (1.0 - 2.0 * 0.2)
    speed = 1.0 + 0.02 * forward
    stop = 0.02 + speed / braking
    found = at_times(run, 0.1 * run["joints/lossy/rate_a"], [0.02, 0.04, 0.09])
    exact = speed, speed - 0.02 * braking, -forward * (0.09 - stop)
    within = 2e-5 * (braking - forward)  # the acceleration changes within the step of the stop
    verify(S, "worm: speeds [m/s]", found, exact, "momentum", absolute=within)
    assert np.ptp(run["energy/balance"]) < 1e-4 * np.ptp(run["energy/dissipated"])


def test_a_worm_locks_itself(verify):
    """The load on the wheel b makes it creep at the speed u with mu phi(u) = 2, and does not reach the worm a."""
    start = "initial.velocities=[]"
    run = RecordedRun(input_deck("gear_stages", WORM, start, "loads.motor.nodes=[ground, b_3]", "time.end=0.05"))
    creep = 1e-4 * (1.0 - math.sqrt(1.0 - 2.0 / 3.0))
    found = -0.1 * run["joints/lossy/rate_a"][-1], 0.2 * run["joints/lossy/rate_b"][-1]
    verify(S, "worm driven by its wheel: speeds [m/s]", found, [creep, creep], "balance of forces", relative=1e-6)
    force = run["joints/lossy/force"][-1]
    assert abs(force) == pytest.approx(0.5 * 15.0, rel=1e-6)  # the mean of 3 N m/0.2 m and none
    assert run["joints/lossy/dissipated_power"][-1] == pytest.approx(15.0 * creep, rel=1e-6)


LIGHT = "elements.gear_a_3.inertia=[1.0e-3, 1.0e-3, 2.0e-3]"  # 0.2 kg, less than 0.2 times the 2 kg of the wheel


def test_a_light_worm_jams():
    """Rigid teeth have no acceleration when the wheel drives; elastic ones stop worm and wheel within 20 ms."""
    changes = WORM, LIGHT, "loads.motor.value=-0.5", "time={end: 0.05, step: 1.0e-4}"
    with pytest.raises(ConvergenceError, match="gear_pair 'lossy' binds"):
        RecordedRun(input_deck("gear_stages", *changes))
    elastic = "joints.lossy.teeth={stiffness: 1 MN/m, damping: 200}"
    run = RecordedRun(input_deck("gear_stages", *changes, elastic))
    braking = np.abs(0.1 * run["joints/lossy/rate_a"]) > 0.9
    assert run.time[braking].max() < 0.02
    assert np.abs(0.2 * run["joints/lossy/rate_b"][-50:]).max() < 0.05
    assert np.ptp(run["energy/balance"]) < 5e-3 * np.ptp(run["energy/dissipated"])


def test_energy_of_all_stages(stages):
    """Friction, shocks and the motor account for all changes of energy; varying teeth give and take nothing."""
    assert np.ptp(stages["energy/balance"]) < 1e-4 * np.ptp(stages["energy/given"])


def test_mode_of_elastic_teeth(verify):
    """Two masses over the stiffness at the tooth phase of the start."""
    _, found, _ = modes(input_deck("gear_stages"), None)
    exact = math.sqrt(1.2e6 * 1.5)
    verify(S, "elastic teeth: frequency [rad/s]", abs(found.values).max(), exact, "two masses", relative=1e-9)


def motion_of_two_masses(end):
    """Return the transmission error [m] over time, a function, of two masses on the pitch circles, by SciPy."""
    k, play, chi, c, eps, per_metre, force = 1e6, 1e-4, 0.5, 20.0, 0.01, 24.0 / 0.1, 30.0

    def rates(t, y):
        u, v = y[:2], y[2:]
        s, s1, w, w1 = u[0] - u[1], v[0] - v[1], 0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1])
        kappa, slope = 1.0 + 0.2 * math.cos(per_metre * w), -0.2 * per_metre * math.sin(per_metre * w)
        d = max(abs(s) - 0.5 * play, 0.0)
        N = kappa * k * math.copysign(d, s) * max(1.0 + chi * math.copysign(s1, s * s1), 0.0) + c * s1
        ratio, loss = min(abs(w1) / eps, 1.0), 0.2 / 1.9 if N * w1 > 0.0 else 0.6 / 1.7
        half = 0.5 * (slope * 0.5 * k * d * d + loss * abs(N) * ratio * (2.0 - ratio) * math.copysign(1.0, w1))
        return [v[0], v[1], (force - N - half) / MASSES[0], (N - half) / MASSES[1]]

    start = [0.0, 0.0, 1.0, 0.8]
    found = solve_ivp(rates, (0.0, end), start, "DOP853", dense_output=True, rtol=1e-7, atol=1e-12, max_step=2e-4)
    return lambda t: found.sol(t)[0] - found.sol(t)[1]


ALL = (
    "joints.elastic.backlash=0.1 mm",
    "joints.elastic.teeth.damping=20",
    "joints.elastic.teeth.impact_damping=0.5",
    "joints.elastic.friction={efficiency: 0.9, backdriving_efficiency: 0.7, regularization: 0.01}",
    "loads.motor.nodes=[ground, a_2]",
    "time.end=0.03",
)


def test_elastic_teeth_with_backlash_damping_and_friction(verify):
    """Varying stiffness, both kinds of damping, friction, a motor, and 16 contacts on alternate flanks."""
    errors, motion = [], motion_of_two_masses(0.03)
    for step in ("5e-5", "2.5e-5"):
        run = RecordedRun(input_deck("gear_stages", *ALL, f"time.step={step}"))
        exact = motion(run.time)
        errors.append(np.abs(run["joints/elastic/transmission_error"] - exact).max() / np.abs(exact).max())
    order = np.log2(errors[0] / errors[1])
    verify(S, "elastic teeth with backlash: order", order, 2.0, "integration by SciPy", absolute=0.1)
    verify(S, "elastic teeth with backlash: relative error", errors[1], 0.0, "integration by SciPy", absolute=1e-3)
    assert sum("flank" in event.name and "elastic" in event.element for event in run.event_records) == 17
    assert np.ptp(run["energy/balance"]) < 1e-5 * np.ptp(run["energy/dissipated"])


MODELICA = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}, b: {position: [1, 0, 0]}}
    elements:
      a: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}
      b: {type: rigid_body, node: b, mass: 1, inertia: [1.5, 1.5, 1.5]}
    joints:
      a: {type: hinge, nodes: [ground, a], axis: [0, 0, 1]}
      b: {type: hinge, nodes: [ground, b], axis: [0, 0, 1]}
      gears: {type: gear_pair, nodes: [ground, a, b], axis_a: [0, 0, 1], radius_a: 1, ratio: 2,
              friction: {efficiency: 0.5, regularization: 1.0e-6}}
    loads:
      drive: {type: couple, nodes: [ground, a], axis: [0, 0, 1], value: {sine: {amplitude: 10, frequency: 1}}}
      load: {type: couple, nodes: [ground, b], axis: [0, 0, 1], value: {linear: {slope: 2.5, offset: -10}}}
    time: {end: 0.5, step: 1.0e-3, adaptive: {tolerance: 1.0e-6}}
"""
LOSSY_GEAR = {  # time, angle of b [rad], its rate [rad/s]
    0.02: (-0.000174926581606674, -0.0157158634878876),
    0.04: (-0.000557993606148222, -0.0208414999681292),
    0.08: (-0.00111677364942685, -0.000478297425440985),
    0.15: (-0.00111688794297108, 0.0),
    0.355: (0.000146406939338428, 0.00709183579349648),
    0.45: (0.000208357924638682, 0.0),
    0.5: (1.66216871678419e-05, -0.0162619240385781),
}


def test_the_lossy_gear_of_modelica(verify):
    """LossyGearDemo1 of the Modelica Standard Library: rolling backward, stuck, forward, stuck, backward."""
    run, reference = RecordedRun(deck(MODELICA)), np.array(list(LOSSY_GEAR.values()))
    source = "reference results of the Modelica Association"
    for i, (name, unit) in enumerate((("angle", "rad"), ("rate", "rad/s"))):
        exact = reference[:, i]
        found = np.interp(list(LOSSY_GEAR), run.time, run[f"joints/gears/{name}_b"])
        what = f"LossyGearDemo1: {name} [{unit}]"
        verify(S, what, found, exact, source, absolute=float(1e-3 * np.abs(exact).max()))
    assert np.ptp(run["energy/balance"]) < 1e-3 * np.ptp(run["energy/given"])


PLANETARY = """
    mecano: 1
    gravity: none
    nodes:
      ring: {position: [0, 0, 0], fixed: true}
      sun: {position: [0, 0, 0]}
      arm: {position: [0, 0, 0]}
      pin: {position: [0.2, 0, 0]}
      planet: {position: [0.2, 0, 0]}
    elements:
      shaft: {type: rigid_body, node: sun, mass: 1, inertia: [0.01, 0.01, 0.01]}
      carrier: {type: rigid_body, node: arm, mass: 1, inertia: [0.5, 0.5, 0.5], attached: [pin]}
      planet: {type: rigid_body, node: planet, mass: 1.0e-6, inertia: [1.0e-9, 1.0e-9, 1.0e-9]}
    joints:
      input: {type: hinge, nodes: [ground, sun], axis: [0, 0, 1]}
      output: {type: hinge, nodes: [ground, arm], axis: [0, 0, 1]}
      bearing: {type: hinge, nodes: [pin, planet], axis: [0, 0, 1]}
      inner: {type: gear_pair, nodes: [arm, sun, planet], axis_a: [0, 0, 1], radius_a: 0.1, radius_b: 0.1,
              friction: &dry {efficiency: 0.9, regularization: 1.0e-4}}
      outer: {type: gear_pair, nodes: [arm, planet, ring], axis_a: [0, 0, 1], radius_a: 0.1, radius_b: 0.3,
              friction: *dry}
    loads: {motor: {type: couple, nodes: [ground, sun], axis: [0, 0, 1], value: 3}}
    initial: {velocities: [
      {nodes: [sun], about: own, angular_velocity: [0, 0, 4]}, {nodes: [arm], about: own, angular_velocity: [0, 0, 1]},
      {nodes: [planet], about: [0, 0, 0], angular_velocity: [0, 0, 1]},
      {nodes: [planet], about: own, angular_velocity: [0, 0, -2]}]}
    time: {end: 0.2, step: 5.0e-3}
"""


def test_efficiency_of_a_planetary_gear(verify):
    """Teeth roll relative to the carrier: its torque is 1 - i_0 eta_0 times that of the sun; i_0 = -3, eta_0 = 0.81."""
    run = RecordedRun(deck(PLANETARY))
    rates = [run[f"joints/{name}/rate"][-1] for name in ("input", "output")]
    torque = 1.0 + 3.0 * 0.81
    second = 3.0 * torque / (0.5 + 0.01 * 4.0 * torque)  # of the carrier; the sun turns 4 times as fast
    exact = np.array([4.0, 1.0]) * (1.0 + 0.2 * second)
    verify(S, "planetary gear with losses: rates [rad/s]", rates, exact, "Willis's equation", relative=1e-6)


OPENING = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}, b: {position: [0.3, 0, 0]}}
    elements:
      gear_a: {type: rigid_body, node: a, mass: 1, inertia: [0.01, 0.01, 0.01]}
      gear_b: {type: rigid_body, node: b, mass: 4, inertia: [0.08, 0.08, 0.08]}
    joints:
      bearing_a: {type: hinge, nodes: [ground, a], axis: [0, 0, 1]}
      bearing_b: {type: hinge, nodes: [ground, b], axis: [0, 0, 1]}
      mesh:
        {type: gear_pair, nodes: [ground, a, b], axis_a: [0, 0, 1], radius_a: 0.1, radius_b: 0.2, backlash: 2 mm,
         restitution: 0.3}
    loads: {motor: {type: joint_moment, joint: bearing_a, value: {sine: {amplitude: 3, frequency: 50}}}}
    initial: {velocities: [{nodes: [a], about: own, angular_velocity: [0, 0, 10]}]}
    time: {end: 0.03, step: 2.0e-5}
"""


def test_modes_of_a_planetary_gear_with_elastic_teeth(verify):
    """Sun, carrier and three planets, the ring held (A. Kahraman, J. Sound Vib. 173, 1994): angles are the unknowns."""
    r_s, r_r, r_p, J_s, J_c, J_p, m_p, k_s, k_r = 0.024, 0.1, 0.038, 5e-4, 2e-2, 6e-4, 0.6, 1e8, 1.2e8
    r_c = r_s + r_p
    M, K = np.diag([J_s, J_c + 3.0 * m_p * r_c**2, J_p, J_p, J_p]), np.zeros((5, 5))
    for planet in np.eye(3):
        for k, on_sun, on_carrier in ((k_s, r_s, -r_s - r_p), (k_r, 0.0, r_r - r_p)):
            travel = np.array([on_sun, on_carrier, *(r_p * planet)])
            K += k * np.outer(travel, travel)
    wanted = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)[1:]) / (2.0 * np.pi)
    place = f"['{r_c}*cos(2*pi*$i/3)', '{r_c}*sin(2*pi*$i/3)', 0]"
    text = f"""
        mecano: 1
        gravity: none
        nodes:
          sun: {{position: [0, 0, 0]}}
          carrier: {{position: [0, 0, 0]}}
          ring: {{position: [0, 0, 0], fixed: true}}
          seat$i: {{repeat: {{i: 0..2}}, position: {place}}}
          planet$i: {{repeat: {{i: 0..2}}, position: {place}}}
        elements:
          sun: {{type: rigid_body, node: sun, mass: 1, inertia: [1e-3, 1e-3, {J_s}]}}
          carrier: {{type: rigid_body, node: carrier, mass: 1, inertia: [1e-2, 1e-2, {J_c}],
            attached: [seat0, seat1, seat2]}}
          planet$i: {{repeat: {{i: 0..2}}, type: rigid_body, node: planet$i, mass: {m_p}, inertia: [1e-3, 1e-3, {J_p}]}}
        joints:
          shaft_$i: {{repeat: {{i: [sun, carrier]}}, type: hinge, nodes: [ground, $i], axis: [0, 0, 1]}}
          pin$i: {{repeat: {{i: 0..2}}, type: hinge, nodes: [seat$i, planet$i], axis: [0, 0, 1]}}
          inner$i: {{repeat: {{i: 0..2}}, type: gear_pair, nodes: [carrier, sun, planet$i], axis_a: [0, 0, 1],
            radius_a: {r_s}, radius_b: {r_p}, teeth: {{stiffness: {k_s}}}}}
          outer$i: {{repeat: {{i: 0..2}}, type: gear_pair, nodes: [carrier, planet$i, ring], axis_a: [0, 0, 1],
            radius_a: {r_p}, radius_b: {r_r}, teeth: {{stiffness: {k_r}}}}}
        time: {{end: 1, step: 1 ms}}
    """
    _, found, _ = modes(deck(text), None)
    assert found.kinds == ["free"] + ["oscillation"] * 4
    verify(
        S, "planetary gear with elastic teeth: frequencies [Hz]", found.frequency[1:], wanted, "5 x 5", relative=1e-9
    )


def test_flanks_open_where_all_forces_vanish():
    """There the rounding of angles, in short steps, is a force far above a share of all others.

    The circles have the momentum J_a w_a/r_a - J_b w_b/r_b, whatever the teeth do; the motor changes it.
    """
    run = RecordedRun(deck(OPENING))
    (opens,) = [event.t for event in run.event_records if event.name.startswith("leaves")]
    assert opens == pytest.approx(0.02, abs=1e-9)  # where the motor, which brakes from 10 ms on, drives again
    momentum = 0.1 * run["joints/bearing_a/rate"] - 0.4 * run["joints/bearing_b/rate"]
    w = 100.0 * np.pi
    wanted = 1.0 + 30.0 / w * (1.0 - np.cos(w * run.time))
    np.testing.assert_allclose(momentum, wanted, rtol=1e-9, atol=1e-6)


PAIR = "joints.elastic"
REFUSED = [
    ((f"{PAIR}.restitution=0.5",), "'restitution' applies to rigid teeth with 'backlash'"),
    ((f"{PAIR}.teeth.impact_damping=0.5",), "'teeth.impact_damping' needs 'backlash'"),
    ((f"{PAIR}.teeth.number=null",), "'teeth.variation' needs the 'number' of teeth"),
    ((f"{PAIR}.teeth.variation=[0.7, 0.4]",), "whose sum is less than 1"),
    ((f"{PAIR}.teeth.phases=[0, 1]",), "'teeth.phases' must be as many as the amplitudes"),
    (("joints.lossy.friction.efficiency=0",), "must be greater than 0 and at most 1"),
    (("joints.lossy.friction.backdriving_efficiency=-1",), "must be greater than -1 and at most 1"),
]


@pytest.mark.parametrize("changes, text", REFUSED)
def test_teeth_that_do_not_fit_are_refused(changes, text):
    with pytest.raises(DeckError, match=text):
        input_deck("gear_stages", *changes)


def test_errors_of_teeth_point_at_their_values():
    text = (INPUTS / "gear_stages.yaml").read_text().replace("variation: [0.2]", "variation: [1.2]")
    with pytest.raises(DeckError) as info:
        deck(text)
    (problem,) = info.value.problems
    assert text.splitlines()[problem.mark.line - 1][problem.mark.column - 1 :].startswith("[1.2]")


RACK = (
    "joints.teeth.backlash=2 mm",
    "joints.teeth.teeth={stiffness: 1 MN/m, damping: 1 kN s/m}",
    "joints.teeth.friction={efficiency: 0.9, backdriving_efficiency: 0.5, regularization: 1 mm/s}",
)


def test_a_rack_with_elastic_teeth_and_backlash():
    """The motor, 40 N at the pitch circle, drives 4 kg and 10 kg/0.9; the teeth close half of the play and bend."""
    run = RecordedRun(input_deck("rack", *RACK, "time.end=0.3", "time.step=2.0e-4"))
    acceleration = 40.0 / (4.0 + 10.0 / 0.9)
    force = 0.5 * (10.0 / 0.9 + 10.0) * acceleration  # the mean of that on the pinion and that on the rack
    steady = run.time > 0.2
    np.testing.assert_allclose(run["joints/teeth/force"][steady], force, rtol=1e-6)
    np.testing.assert_allclose(run["joints/teeth/transmission_error"][steady], -1e-3 - 1e-6 * force, rtol=1e-6)
    gained = np.ptp(run["joints/teeth/rate"][steady]) / np.ptp(run.time[steady])
    assert gained == pytest.approx(acceleration / 0.05, rel=1e-6)
    assert np.ptp(run["energy/balance"]) < 1e-4 * np.ptp(run["energy/given"])

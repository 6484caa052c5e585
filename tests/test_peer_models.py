"""Models of other programs and of their lectures, compared with published numbers or with equations of their own.

Exudyn (Gerstmayr, Multibody System Dynamics 2023) publishes its test models; the rimless wheel and the compass gait are
the walkers of the lectures with Drake (Tedrake, Underactuated Robotics), after McGeer 1990.
"""

import math
import re
from textwrap import dedent

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from small_motions import eigenvalues
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.static import run
from mecano.analyses.sweep import sweep
from mecano.results.sweep_file import whirl_word

S, g = "Models of other programs", 9.81

FRAME = """
    mecano: 1
    gravity: none
    parameters: {E: 71.24 GPa, G: $E/2.62, w: 0.6 mm, h: 30 mm}
    sections:
      strip: {type: stiffness, EA: $E*$w*$h, GA2: $G*$w*$h, GA3: $G*$w*$h, GJ: $G*$h*$w**3/3, EI2: $E*$w*$h**3/12,
              EI3: $E*$h*$w**3/12, mass_per_length: 1, rotary_inertia: [1e-3, 1e-3, 1e-3]}
    nodes: {root: {position: [0, 0, 0], fixed: true}, bend: {position: [0.24, 0, 0]}, tip: {position: [0.24, -0.24, 0]}}
    elements:
      a: {type: beam, nodes: [root, bend], section: strip, up: [0, 1, 0], mesh: 16}
      b: {type: beam, nodes: [bend, tip], section: strip, up: [1, 0, 0], mesh: 16}
    loads: {pull: {type: force, node: tip, direction: [1, 0, 0], value: 1.1 N}}
    static: {steps: 11}
"""


def test_a_right_angle_frame_buckles_sideways(verify, tmp_path):
    """Two thin strips leave their plane at a load in it (Exudyn: rightAngleFrame)."""
    notes = []
    run(deck(FRAME), tmp_path / "frame.h5", announce=notes.append)
    critical = 1.1 * float(re.search(r"near ([\d.]+), the equilibrium becomes unstable", notes[0])[1])
    source = "Argyris et al. 1979, Simo & Vu-Quoc 1986"
    verify(S, "right-angle frame: buckles sideways at [N]", critical, 1.088, source, relative=5e-4)


WHEEL = """
    mecano: 1
    gravity: [0, 0, -9.81]
    parameters: {half: pi/8, slope: 0.08, x: cos($half)*sin($slope), z: cos($half)*cos($slope)}
    nodes:
      hub: {position: [$x, 0, $z]}
      foot$i:
        repeat: {i: 0..7}
        position: [$x + sin($half*(2*$i + 1) - $slope), 0, $z - cos($half*(2*$i + 1) - $slope)]
    elements:
      body: {type: rigid_body, node: hub, mass: 1, inertia: [0.01, 0.01, 0.01],
             attached: [foot0, foot1, foot2, foot3, foot4, foot5, foot6, foot7]}
      stand$i:
        {repeat: {i: 0..7}, type: contact, nodes: [ground, foot$i], friction: {coefficient: 5, regularization: 1 mm/s},
         plane: {normal: [sin($slope), 0, cos($slope)], point: [0, 0, 0]}}
    joints: {plane: {type: generic, nodes: [ground, hub], axis: [0, 1, 0], free: [along_1, along_2, about_axis]}}
    initial:
      velocities:
        - {nodes: all, angular_velocity: [0, 2.5, 0], about: [$x + sin($half - $slope), 0, $z - cos($half - $slope)]}
    time: {end: 0.8, step: 1 ms}
"""


def test_a_rimless_wheel_loses_the_energy_of_its_steps(verify):
    """It falls over a foot, and turns about the next one with its moment of momentum about that; J = 1.01 kg m2."""
    run = RecordedRun(deck(WHEEL))
    drop = 2.0 * g * (math.cos(0.08 - math.pi / 8) - math.cos(0.08 + math.pi / 8))
    kept, square, lost = (math.cos(math.pi / 4) + 0.01) / 1.01, 2.5**2, []
    for _ in range(2):
        before = square + drop / 1.01
        square = kept**2 * before
        lost.append(0.5 * 1.01 * (before - square))
    found = [event.lost for event in run.event_records if event.name == "closes" and event.t > 0.0]
    source = "McGeer 1990, moment of momentum about the new foot"
    verify(S, "rimless wheel: energy lost in its first two steps [J]", found, lost, source, relative=1e-4)


LEAN = math.radians(3.0)
WEIGHT = g * np.array([math.sin(LEAN), -math.cos(LEAN)])  # along and across the ground
LEGS = np.array([[10.0, 1.0, 0.0], [5.0, 0.5, 0.0], [5.0, 1.0, -0.5]])  # masses [kg], along both legs from the foot [m]


def across(angle):
    """Return the derivative of the direction (sin, cos) of a leg."""
    return np.array([math.cos(angle), -math.sin(angle)])


def walking(_, y):
    """Rates of the angles of the standing and the swinging leg and of their rates, by Kane's method."""
    M, f = np.zeros((2, 2)), np.zeros(2)
    for mass, *arms in LEGS:
        J = np.column_stack([arm * across(angle) for arm, angle in zip(arms, y, strict=False)])
        inward = sum(arm * w**2 * across(a + math.pi / 2.0) for arm, a, w in zip(arms, y, y[2:], strict=False))
        M, f = M + mass * J.T @ J, f + mass * J.T @ (WEIGHT - inward)
    return [*y[2:], *np.linalg.solve(M, f)]


def strike(_, y):
    """Rise through zero where the swinging foot, ahead by 0.1 m or more, reaches the ground."""
    return min(math.cos(y[1]) - math.cos(y[0]), math.sin(y[0]) - math.sin(y[1]) - 0.1)


strike.terminal, strike.direction = True, 1


def struck(y):
    """Return the state after the swinging foot has struck and become the standing one, impulse and lost energy."""
    (a, b), (w_a, w_b) = np.split(y, 2)
    legs = np.column_stack([across(a), across(b)])
    J = [np.column_stack([np.eye(2), legs * arms]) for arms in ([0.0, 0.0], [-0.5, 0.0], [0.0, -0.5])]  # from the hip
    M = sum(mass * j.T @ j for mass, j in zip(LEGS[:, 0], J, strict=True))
    foot = np.column_stack([np.eye(2), 0.0 * across(a), -across(b)])
    before = np.array([*w_a * across(a), w_a, w_b])
    impulse = np.linalg.solve(foot @ np.linalg.solve(M, foot.T), -foot @ before)
    after = before + np.linalg.solve(M, foot.T @ impulse)
    lost = 0.5 * (before @ M @ before - after @ M @ after)
    return np.array([b, a, after[3], after[2]]), np.linalg.norm(impulse), lost


def test_a_compass_gait_repeats_its_steps(verify):
    """Drake: CompassGait, after Goswami, Thuilot & Espiau 1996; feet are held by grips that change at each strike."""
    start = np.array([-0.2710286805, 0.2710286805, 1.0923835899, 0.3773739489])
    step = solve_ivp(walking, (0, 2), start, events=strike, rtol=1e-11, atol=1e-12)
    again, impulse, lost = struck(step.y[:, -1])
    np.testing.assert_allclose(again, start, atol=2e-9)
    known = [step.t[-1], impulse, lost]
    np.testing.assert_allclose(known, [0.734346, 13.98315, 5.49812], rtol=1e-6)  # those of the deck
    found = []
    for h in (2e-3, 1e-3):
        run = RecordedRun(input_deck("compass_walker", f"time.step={h}", "time.end=0.8"))
        (closes,) = [event for event in run.event_records if event.unit]
        found.append(np.array([closes.t, closes.impulse, closes.lost]))
    what = "compass gait: duration of a step [s], impulse [N s] and loss [J] at its end"
    verify.second_order(S, what, *found, known, 1e-6, "Kane's equations, SciPy")


def test_a_compass_gait_walks_on():
    """Four steps: the cycle is stable, so that errors of the integration do not add up."""
    run = RecordedRun(input_deck("compass_walker"))
    strikes = [event for event in run.event_records if event.unit]
    assert [event.element for event in strikes] == ["grip 'stand_b'", "grip 'stand_a'"] * 2
    np.testing.assert_allclose(np.diff([0.0, *(event.t for event in strikes)]), 0.734346, atol=1e-5)


ROTOR = """
    mecano: 1
    gravity: none
    sections: {shaft: {type: circle, diameter: 0.02, E: 2.1e11, nu: 0.3, density: 7850}}
    nodes: {left: {position: [0, 0, 0]}, disc: {position: [0.2, 0, 0]}, right: {position: [0.5, 0, 0]}}
    elements:
      a: {type: beam, nodes: [left, disc], section: shaft, mesh: 8}
      b: {type: beam, nodes: [disc, right], section: shaft, mesh: 12}
      disc: {type: rigid_body, node: disc, mass: 5, inertia: [0.025, 0.013, 0.013]}
      bearing_1: {type: bushing, nodes: [ground, left], stiffness: [1.0e6, 2.0e6, 2.0e6, 0, 0, 0]}
      bearing_2: {type: bushing, nodes: [ground, right], stiffness: [0, 2.0e6, 2.0e6, 0, 0, 0]}
    initial: {velocities: [{nodes: all, angular_velocity: [400, 0, 0], about: [0, 0, 0]}]}
    time: {end: 1, step: 1 ms}
"""


def whirl(speed, damping=0.0):
    """Eigenvalues [1/s] of the rotor by Timoshenko's finite elements with gyroscopic matrices (Nelson 1980).

    The deflections z = y + i x of both planes and their slopes are complex: M z'' - i w G z' + K z = 0. ``damping`` [s]
    in proportion to the stiffness of the shaft, which turns, adds damping K (z' - i w z).
    """
    E, G, rho, radius = 2.1e11, 2.1e11 / 2.6, 7850.0, 0.01
    A, inertia, shear = math.pi * radius**2, math.pi * radius**4 / 4, 6 * 1.3 / (7 + 6 * 0.3)
    x = np.concatenate([np.linspace(0, 0.2, 9), np.linspace(0.2, 0.5, 13)[1:]])
    M, spin, K = (np.zeros((2 * len(x), 2 * len(x))) for _ in range(3))
    for e, h in enumerate(np.diff(x)):
        soft, at = 12 * E * inertia / (shear * G * A * h**2), slice(2 * e, 2 * e + 4)
        row, turn = np.array([12, 6 * h, -12, 6 * h]), np.array([[4 + soft, 2 - soft], [2 - soft, 4 + soft]]) * h**2
        k = np.outer([1, 0, -1, 0], row) + np.outer(row, [1, 0, -1, 0]) - 12 * np.outer([1, 0, -1, 0], [1, 0, -1, 0])
        k[1::2, 1::2] = turn
        K[at, at] += E * inertia / ((1 + soft) * h**3) * k
        m = [[156, 22 * h, 54, -13 * h], [0, 4 * h**2, 13 * h, -3 * h**2], [0, 0, 156, -22 * h], [0, 0, 0, 4 * h**2]]
        n = [[36, 3 * h, -36, 3 * h], [0, 4 * h**2, -3 * h, -(h**2)], [0, 0, 36, -3 * h], [0, 0, 0, 4 * h**2]]
        m, n = (np.triu(a) + np.triu(a, 1).T for a in (np.array(m), np.array(n)))
        rotary = rho * inertia / (30 * h) * n
        M[at, at] += rho * A * h / 420 * m + rotary
        spin[at, at] += 2 * rotary
    M[16, 16], M[17, 17], spin[17, 17] = M[16, 16] + 5, M[17, 17] + 0.013, spin[17, 17] + 0.025
    C, K = damping * K - 1j * speed * spin, (1 - 1j * speed * damping) * K
    K[0, 0], K[-2, -2] = K[0, 0] + 2e6, K[-2, -2] + 2e6
    below = -np.hstack([np.linalg.solve(M, K), np.linalg.solve(M, C)])
    return np.linalg.eigvals(np.vstack([np.hstack([np.zeros_like(K), np.eye(len(K))]), below]))


def test_a_shaft_with_a_disc_whirls(verify):
    """Backward and forward whirl of a disc on a flexible shaft in elastic bearings (Exudyn: rotors with discs)."""
    found = eigenvalues(deck(ROTOR), largest=2000.0)
    found = np.sort(found.imag[found.imag > 1.0]) / (2 * math.pi)
    exact = np.sort(np.abs(whirl(400.0).imag))[:4] / (2 * math.pi)
    lateral = [f for f in found if abs(f - 63.66) > 0.1]  # the shaft moves along itself
    verify(S, "rotor at 400 rad/s: whirl [Hz]", lateral[:4], exact, "finite elements of Nelson 1980", relative=1e-5)


@pytest.mark.parametrize(("speed", "grows"), [(300.0, False), (400.0, True)])
def test_internal_damping_makes_a_fast_shaft_unstable(speed, grows, verify):
    """Damping of the beams turns with the shaft: above the critical speed of 320 rad/s it drives the forward whirl."""
    damped = ROTOR.replace("density: 7850", "density: 7850, damping: 2.0e-5").replace("400", f"{speed}")
    found, exact = eigenvalues(deck(damped), largest=350.0), whirl(speed, 2e-5)
    found = found[found.imag > 310.0]
    exact = exact[np.abs(exact) < 350.0]  # circles, of which the backward one has a negative rate
    order, backward_first = np.argsort(found.real), np.argsort(exact.real)
    assert np.any(found.real > 0.0) == grows
    what = f"rotor with internal damping at {speed:g} rad/s: growth of backward and forward whirl [1/s]"
    source = "finite elements of Nelson 1980"
    verify(S, what, found.real[order], exact.real[backward_first], source, absolute=1e-5)
    np.testing.assert_allclose(found.imag[order], np.abs(exact.imag[backward_first]), rtol=1e-6)


def critical_speed(sense, near):
    """The speed [rad/s], within 20 of ``near``, at which a mode of ``whirl`` turns ``sense`` times as fast."""
    k = int(np.argmin(np.abs(np.sort(whirl(near).imag) - sense * near)))
    return brentq(lambda speed: np.sort(whirl(speed).imag)[k] - sense * speed, near - 20.0, near + 20.0)


@pytest.mark.slow
def test_critical_speeds_of_a_shaft_with_a_disc(verify, tmp_path):
    """Speeds at which an eigenvalue of the finite elements turns with the rotor, or backward as fast."""
    start = "{steady: {angular_velocity: [$speed, 0, 0], about: [0, 0, 0]}}"
    text = dedent(ROTOR).replace("sections:", "parameters: {speed: 400}\nsections:")
    (tmp_path / "rotor.yaml").write_text(re.sub("initial: .*", f"initial: {start}", text))
    (locus,) = sweep(tmp_path / "rotor.yaml", (), ["speed=200:1000:200"], rotor="disc").loci
    for sense, word, count in ((1.0, "forward", 1), (-1.0, "backward", 2)):
        found = [one.speed for one in locus.resonances if whirl_word(one.whirl) == word]
        exact = [critical_speed(sense, round(speed, -1)) for speed in found]
        assert len(found) == count
        name = f"shaft with a disc: {word} critical speeds [rad/s]"
        verify(S, name, found, exact, "finite elements of Nelson 1980", relative=1e-5)


HOOP = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {hoop: {position: [0, 0, 0]}, bead: {position: [0.4*sin(0.3), 0, -0.4*cos(0.3)]}}
    elements:
      hoop: {type: rigid_body, node: hoop, mass: 1, inertia: [0.05, 0.05, 0.08]}
      bead: {type: point_mass, node: bead, mass: 0.3}
    joints:
      axle: {type: hinge, nodes: [ground, hoop], axis: [0, 0, 1]}
      ring:
        {type: point_on_curve, nodes: [hoop, bead], center: [0, 0, 0], semi_axis_1: [0, 0, -0.4],
         semi_axis_2: [0.4, 0, 0]}
    initial: {velocities: [{nodes: all, angular_velocity: [0, 0, 8], about: [0, 0, 0]}]}
    time: {end: 1, step: STEP}
"""


def test_a_bead_on_a_hoop_that_turns_freely(verify):
    """The hoop slows down as the bead rises: the moment of momentum about the vertical is constant."""
    momentum = (0.08 + 0.3 * 0.16 * math.sin(0.3) ** 2) * 8

    def motion(t, y):
        turning = momentum / (0.08 + 0.3 * 0.16 * math.sin(y[0]) ** 2)
        return [y[1], turning**2 * math.sin(y[0]) * math.cos(y[0]) - g / 0.4 * math.sin(y[0]), turning]

    exact = solve_ivp(motion, (0, 1), [0.3, 0, 0], rtol=1e-10, atol=1e-12).y[[0, 2], -1]
    ends = []
    for step in ("2 ms", "1 ms"):
        run = RecordedRun(deck(HOOP.replace("STEP", step)))
        x = run["nodes/bead/position"][-1]
        ends.append(np.array([math.atan2(math.hypot(x[0], x[1]), -x[2]), run["joints/axle/angle"][-1]]))
    what = "bead on a hoop: its angle, that of the hoop [rad]"
    verify.second_order(S, what, *ends, exact, 1e-6, "conserved moment of momentum")


ARM = """
    mecano: 1
    gravity: [0, -9.81, 0]
    nodes: {arm: {position: [0, 0, 0]}, eye: {position: [0.25, 0, 0]}, base: {position: [0, -0.25, 0], fixed: true}}
    elements:
      arm: {type: rigid_body, node: arm, mass: 120, center_of_mass: [0.5, 0, 0], inertia: [10, 10, 10], attached: [eye]}
      gauge: {type: spring_damper, nodes: [base, eye], law: {spring: 0}}
    joints: {pin: {type: hinge, nodes: [ground, arm], axis: [0, 0, 1]}}
    signals:
      target: "0.1*max(0, 0.5 - cos(pi*time)) + 0.25*sqrt(2)"
      valve: 2*(target - gauge.length)
      flow_0: "2.0e-5*(max(valve, 0)*sqrt(2.0e7 - p_0) + min(valve, 0)*sqrt(p_0))"
      flow_1: "2.0e-5*(max(-valve, 0)*sqrt(2.0e7 - p_1) + min(-valve, 0)*sqrt(p_1))"
      p_0: {type: integrator, input: 1.0e11*(flow_0 - 0.01*gauge.rate), initial: 2.0e6, unit: Pa}
      p_1: {type: integrator, input: 1.0e11*(flow_1 + 0.01*gauge.rate), initial: 2.0e6, unit: Pa}
    loads: {cylinder: {type: line_force, nodes: [base, eye], value: 0.01*(p_0 - p_1) - 2.0e5*gauge.rate}}
    initial: {velocities: [{nodes: [arm, eye], angular_velocity: [0, 0, 0.5], about: [0, 0, 0]}]}
    time: {end: 0.4, step: 0.5 ms}
"""


def lifted(t, y):
    """Rates of the angle of the arm, its rate and both pressures [Pa], while no root is negative."""
    angle, rate, p_0, p_1 = y
    x = 0.25 * np.array([math.cos(angle), math.sin(angle) + 1.0])
    length = math.hypot(*x)
    lever = 0.25 * (x[1] * math.cos(angle) - x[0] * math.sin(angle)) / length
    valve = 2.0 * (0.1 * max(0.0, 0.5 - math.cos(math.pi * t)) + 0.25 * math.sqrt(2.0) - length)
    flows = [
        2e-5 * (max(v, 0.0) * math.sqrt(2e7 - p) + min(v, 0.0) * math.sqrt(p)) for v, p in ((valve, p_0), (-valve, p_1))
    ]
    moment = (0.01 * (p_0 - p_1) - 2e5 * lever * rate) * lever - 60.0 * g * math.cos(angle)
    return [rate, moment / 40.0, 1e11 * (flows[0] - 0.01 * lever * rate), 1e11 * (flows[1] + 0.01 * lever * rate)]


def test_a_cylinder_lifts_an_arm(verify):
    """Exudyn (hydraulicActuatorSimpleTest) has 6441296 and 3008420 Pa, accurate to 1e-5 in its own words."""
    run = RecordedRun(deck(ARM))
    found = [run[path][-1] for path in ("joints/pin/rate", "signals/p_0/value", "signals/p_1/value")]
    known = solve_ivp(lifted, (0, 0.4), [0, 0.5, 2e6, 2e6], method="Radau", rtol=1e-8, atol=1e-8, max_step=5e-3).y[
        1:, -1
    ]
    np.testing.assert_allclose(known[1:], [6441296.0, 3008420.0], rtol=2e-5)
    what = "hydraulic arm: its rate [rad/s], pressures [Pa]"
    verify(S, what, found, known, "SciPy, Radau", relative=2e-5)


TACKLE = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      a: {position: [0, 0, 5], fixed: true}
      block: {position: [0.3, 0, 2]}
      top: {position: [0.6, 0, 5.2], fixed: true}
      weight: {position: [1.5, 0, 1]}
    elements:
      block: {type: rigid_body, node: block, mass: 10, center_of_mass: [0, 0, -0.3], inertia: [0.2, 0.2, 0.2]}
      weight: {type: rigid_body, node: weight, mass: 4, inertia: [0.1, 0.1, 0.1]}
      rope: {type: reeved_cable, nodes: [a, block, top, weight], radii: [0, -0.15, 0.2, 0], axis: [0, 1, 0],
             axial_stiffness: 50 kN, damping: 2 ms, pretension: 45}
    time: {end: 1, step: 0.5 ms}
"""


def test_a_block_and_a_weight_swing_on_one_rope(verify):
    """Both masses swing and slide on the rope: places after 1 s (Exudyn: ReevingSystemSprings, steps of 0.5 ms)."""
    run = RecordedRun(deck(TACKLE))
    found = np.concatenate([run[f"nodes/{name}/position"][-1, [0, 2]] for name in ("block", "weight")])
    known = [0.20276877, 1.6197568, 0.74682179, 1.69951053]
    verify(S, "block and weight on one rope: places [m]", found, known, "Exudyn 1.13.6", absolute=1e-6)

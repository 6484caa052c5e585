"""Static equilibrium: paths against closed forms, stability, named failures, initial states of dynamic runs."""

import re

import numpy as np
import pytest
from equilibria import G, Path, arm, chain, truss, truss_force
from scipy.optimize import brentq, fsolve, minimize_scalar
from scipy.spatial.transform import Rotation
from scipy.special import ellipe, ellipk
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.equilibria import equilibrium
from mecano.analyses.initial_state import set_initial_state
from mecano.analyses.prepare import integrator_of, prepare
from mecano.analyses.static import run
from mecano.deck.read import deck_of_bytes
from mecano.errors import ConvergenceError, DeckError, NonFiniteError
from mecano.model.sampler import Sampler
from mecano.results.reader import open_results
from mecano.solve.statics.continuation import Follower
from mecano.solve.statics.stability import DENSE, FEW, LOWEST, _lowest

LIMIT = -minimize_scalar(lambda z: -truss_force(z), bounds=(0.0, 0.3), method="bounded", options={"xatol": 1e-12}).fun


def test_load_factor_is_the_share_of_gravity():
    """k theta = mu m g c cos(theta) at every point: the moment of the weight turns with the body."""
    path = Path(arm("static: {steps: 4}"))
    np.testing.assert_allclose(path.factors, [0, 0.25, 0.5, 0.75, 1])
    expected = [brentq(lambda t, mu=mu: 6.0 * t - mu * 2.0 * G * 0.5 * np.cos(t), 0, 2) for mu in path.factors]
    np.testing.assert_allclose(path.turns_about_y("pin"), expected, atol=2e-9)


def test_load_factor_is_the_share_of_dead_and_follower_loads():
    """A dead and a follower moment about the hinge: k theta = mu M."""
    loads = (
        "loads: {a: {type: follower_moment, node: pin, direction: [0, 1, 0], value: 3}, "
        "b: {type: moment, node: pin, direction: [0, 1, 1], value: 3}}"
    )
    path = Path(arm("static: {steps: 5}", gravity=0.0, more=loads))
    expected = path.factors * (3.0 + 3.0 / np.sqrt(2.0)) / 6.0
    np.testing.assert_allclose(path.turns_about_y("pin"), expected, atol=1e-12)


def test_arc_length_turns_back_at_a_stop():
    """A stop catches the truss over centre, where the load pulls up: the load increases again, as the stop pushes."""
    height = -0.05
    text = truss("{method: arc_length, end: 4, lowest: -4, steps: 40}").replace(
        "plane: {type: prescribed_position, node: top, direction: [0, 1, 0], value: 0}",
        f"guide: {{type: prismatic, nodes: [ground, top], axis: [0, 0, 1], stops: {{lower: {height - 0.3}}}}}",
    )
    path = Path(text)
    z = path.positions("top")[:, 2]
    on_stop = np.abs(z - height) < 1e-8
    assert path.result.reason == "the end was reached" and path.factors[-1] == 4.0
    assert np.count_nonzero(on_stop) > 3 and np.all(z > height - 1e-8)
    np.testing.assert_allclose(30.0 * path.factors[~on_stop], truss_force(z[~on_stop]), atol=1e-6)
    np.testing.assert_allclose(30.0 * path.factors[on_stop].min(), truss_force(height), atol=1e-6)


def test_the_tension_of_guys_is_balanced_by_the_mast_at_every_load():
    """Two guys at 12 m hold a mast of 20 m on a hinge; the one to the lee slackens: moments about the foot."""
    text = """
        mecano: 1
        gravity: none
        nodes:
          foot: {position: [0, 0, 0]}
          top: {position: [0, 0, 20]}
          left: {position: [-12, 0, 0], fixed: true}
          right: {position: [12, 0, 0], fixed: true}
        elements:
          mast: {type: rigid_body, node: foot, mass: 100, inertia: [100, 100, 100], attached: [top]}
          windward: {type: cable, nodes: [left, top], axial_stiffness: 2 MN, pretension: 5 kN}
          lee: {type: cable, nodes: [right, top], axial_stiffness: 2 MN, pretension: 5 kN}
        joints: {hinge: {type: hinge, nodes: [ground, foot], axis: [0, 1, 0]}}
        loads: {wind: {type: force, node: top, direction: [1, 0, 0], value: 20 kN}}
        static: {steps: 8}
        """
    path = Path(text)
    top, moments = path.positions("top"), 20e3 * path.factors * path.positions("top")[:, 2]
    for x in (-12.0, 12.0):
        guy = np.array([x, 0.0, 0.0]) - top
        length, natural = np.linalg.norm(guy, axis=1), np.hypot(12.0, 20.0) / (1.0 + 5e3 / 2e6)
        tension = 2e6 * np.maximum(length / natural - 1.0, 0.0)
        moments += tension / length * (top[:, 2] * guy[:, 0] - top[:, 0] * guy[:, 2])
    assert np.abs(moments).max() < 1e-3 and top[-1, 0] > 0.5  # N m, of 400,000


BALANCED = f"""
    mecano: 1
    gravity: [0, 0, -{G}]
    parameters: {{k: {2 * G * 0.6 / (0.25 * 0.2)}}}
    nodes:
      arm: {{position: [0, 0, 0]}}
      hook: {{position: [0.25, 0, 0]}}
      mast: {{position: [0, 0, 0.2], fixed: true}}
    elements:
      arm: {{type: rigid_body, node: arm, mass: 2, center_of_mass: [0.6, 0, 0], inertia: [1, 1, 1], attached: [hook]}}
      spring: {{type: spring_damper, nodes: [mast, hook], law: {{spring: $k}}, natural_length: 0}}
    joints: {{elbow: {{type: hinge, nodes: [ground, arm], axis: [0, -1, 0]}}}}
    static: {{METHOD}}
    """


@pytest.mark.parametrize("method", ["steps: 4", "method: relaxation"])
def test_an_arm_balanced_by_a_spring_without_length_is_neutral(method):
    """Its energy (m g c - k r h) sin t does not depend on the angle t: a lamp that stays where it is put."""
    path = Path(BALANCED.replace("METHOD", method))
    assert path.points[-1].stability.neutral == 1 and path.points[-1].stability.unstable == 0
    np.testing.assert_allclose(path.turns_about_y("arm")[-1], 0.0, atol=1e-8)


def test_arc_length_to_a_neutral_equilibrium_is_singular():
    with pytest.raises(ConvergenceError, match="the tangent is singular"):
        Path(BALANCED.replace("METHOD", "method: arc_length"))


ROBERVAL = f"""
    mecano: 1
    gravity: [0, -{G}, 0]
    parameters: {{c: "0.3*cos(0.4)", s: "0.3*sin(0.4)"}}
    nodes:
      top: {{position: [0, 0.2, 0]}}
      low: {{position: [0, 0, 0]}}
      top_$side: {{repeat: &sides [{{side: left, x: -1}}, {{side: right, x: 1}}], position: [$x*$c, 0.2 + $x*$s, 0]}}
      low_$side: {{repeat: *sides, position: [$x*$c, $x*$s, 0]}}
      pan_$side: {{repeat: *sides, position: [$x*$c, 0.2 + $x*$s, 0]}}
      foot_$side: {{repeat: *sides, position: [$x*$c, $x*$s, 0]}}
    elements:
      beam: {{type: rigid_body, node: top, mass: 1, inertia: [0.1, 0.1, 0.1], attached: [top_left, top_right]}}
      stay: {{type: rigid_body, node: low, mass: 1, inertia: [0.1, 0.1, 0.1], attached: [low_left, low_right]}}
      left: {{type: rigid_body, node: pan_left, mass: 2, center_of_mass: [-0.25, 0.1, 0], inertia: [0.1, 0.1, 0.1], attached: [foot_left]}}
      right: {{type: rigid_body, node: pan_right, mass: 2, center_of_mass: [0.05, 0, 0], inertia: [0.1, 0.1, 0.1], attached: [foot_right]}}
    joints:
      pivot: {{type: hinge, nodes: [ground, top], axis: [0, 0, 1]}}
      pivot_low: {{type: hinge, nodes: [ground, low], axis: [0, 0, 1]}}
      hang_$side: {{repeat: *sides, type: hinge, nodes: [top_$side, pan_$side], axis: [0, 0, 1]}}
      guide_$side: {{repeat: *sides, type: hinge, nodes: [low_$side, foot_$side], axis: [0, 0, 1]}}
    static: {{METHOD}}
    """  # noqa: E501


@pytest.mark.parametrize("method", ["steps: 3", "method: relaxation"])
def test_a_roberval_balance_stays_at_any_tilt(method):
    """Equal weights anywhere on its pans move up and down alike: reactions change, no force acts along the motion."""
    path = Path(ROBERVAL.replace("METHOD", method))
    turn = path.rotations("top")[-1]
    assert path.points[-1].stability.neutral == 1 and abs(turn[1, 0]) < 2e-3


def test_kinematics_without_forces():
    """A driven crank without springs and loads: over any number of steps, the slider is at 2 r cos(theta)."""
    path = Path("""
        mecano: 1
        gravity: none
        nodes: {pin: {position: [0, 0, 0]}, end: {position: [0.5, 0, 0]}, slider: {position: [1, 0, 0]}}
        elements:
          crank: {type: rigid_body, node: pin, mass: 1, inertia: [1, 1, 1], attached: [end]}
          slide: {type: point_mass, node: slider, mass: 1}
        joints:
          hinge: {type: hinge, nodes: [ground, pin], axis: [0, 1, 0]}
          motor: {type: prescribed_angle, nodes: [ground, pin], axis: [0, 1, 0], value: {linear: {slope: 1}}}
          rod: {type: rigid_rod, nodes: [end, slider]}
          guide: {type: prismatic, nodes: [ground, slider], axis: [1, 0, 0]}
        static: {over: time, end: 1, steps: 40}
    """)
    np.testing.assert_allclose(path.positions("slider")[:, 0], np.cos(path.factors), atol=1e-11)


def controlled(static, torque, gravity=G, signals=""):
    """The arm without its spring, held by a motor with this torque."""
    more = f"signals: {{torque: {torque}{signals}}}"
    more += "\n        loads: {motor: {type: joint_moment, joint: hinge, value: torque}}"
    text = arm(static, gravity=gravity, more=more)
    return "\n".join(line for line in text.splitlines() if "spring:" not in line)


@pytest.mark.parametrize("method", ["steps", "relaxation", "arc_length"])
def test_stiffness_of_a_controller(method):
    """k (theta - theta_0) = mu m g c cos(theta) - (1 - mu) k theta_0: the motor acts wholly at every load factor."""
    path = Path(controlled(f"static: {{method: {method}}}", "6*(0.3 - hinge.angle)"))

    def out_of_balance(t, mu):
        return 6.0 * (t - mu * 0.3) - mu * 2.0 * G * 0.5 * np.cos(t)

    expected = [brentq(out_of_balance, -2, 2, args=(mu,), xtol=1e-13) for mu in path.factors]
    np.testing.assert_allclose(path.turns_about_y("pin"), expected, atol=2e-8)
    assert path.factors[-1] == 1.0 and np.all(path.unstable == 0) and len(path.points) < 20


@pytest.mark.parametrize("torque, unstable", [("-6*hinge.angle", 0), ("6*hinge.angle", 1)])
def test_stability_with_a_controller(torque, unstable):
    path = Path(controlled("static: {}", torque, gravity=0.0))
    assert np.all(path.unstable == unstable)
    assert path.points[-1].stability.stiffness == pytest.approx(6.0 if not unstable else -6.0)


@pytest.mark.parametrize("soft", [0, 1, LOWEST - 1, LOWEST, LOWEST + 3])
def test_the_lowest_stiffnesses_include_all_unstable_directions(soft):
    """However many directions are ``soft``, and the next one, which bounds how near to zero the others are."""
    known = np.append(np.linspace(-5.0, -1.0, soft), np.linspace(2.0, 9.0, FEW))
    Q = np.linalg.qr(np.random.default_rng(soft).normal(size=(len(known), len(known))))[0]
    values, vectors = _lowest(Q @ np.diag(known) @ Q.T, 1e-13)
    assert len(values) > soft
    np.testing.assert_allclose(values, known[: len(values)], atol=1e-12)
    np.testing.assert_allclose(np.abs(Q.T @ vectors)[: len(values)], np.eye(len(values)), atol=1e-10)


def test_stability_is_unknown_with_an_integrator():
    """The integral of the error has any value at rest: no stiffness tells whether the loop is stable."""
    signals = ", sum: {type: integrator, input: hinge.angle}"
    path = Path(controlled("static: {}", "-6*hinge.angle - sum", gravity=0.0, signals=signals))
    assert np.all(path.unstable == -1)


def test_the_imbalance_of_the_start_is_released():
    """A preloaded spring without loads: it ends where the spring is slack, the angle is followed over half a turn."""
    text = arm("static: {}", gravity=0.0).replace("axis: [0, 1, 0], law", "axis: [0, 1, 0], natural_angle: 4.0, law")
    path = Path(text)
    angles = np.unwrap(path.turns_about_y("pin"))
    np.testing.assert_allclose(angles, 4.0 * path.factors, atol=1e-9)
    assert np.all(path.unstable == 0)


def test_arc_length_passes_limit_points():
    """Von Mises truss: the force over the height is known; the path goes up, down to below zero, and up again."""
    path = Path(truss("{method: arc_length, end: 1.5, steps: 10}"))
    z = path.positions("top")[:, 2]
    np.testing.assert_allclose(30.0 * path.factors, truss_force(z), atol=1e-7)
    assert path.factors[-1] == 1.5 and path.result.reason == "the end was reached"
    assert np.all(np.diff(z) < 0) and path.factors.min() < -0.3
    falls = np.abs(z) < 0.3 * np.sqrt(((1 + 0.09) ** (1 / 3) - 1) / 0.09)  # between the limit points z^2 = L^(2/3) - 1
    np.testing.assert_array_equal(path.unstable, falls)


@pytest.mark.parametrize("end", [1.5, 1000.0])
def test_arc_length_does_not_skip_limit_points_on_its_way_to_a_displacement(end):
    """However far the end of the load factor lies beyond them."""
    until = "{node: top, direction: [0, 0, -1], displacement: 0.7}"
    path = Path(truss(f"{{method: arc_length, end: {end}, until: {until}}}"))
    z = path.positions("top")[:, 2]
    np.testing.assert_allclose(30.0 * path.factors, truss_force(z), atol=1e-7)
    assert z[-1] == pytest.approx(-0.4, abs=1e-9) and 8 <= len(z) <= 40
    assert path.unstable.sum() >= 2 and path.factors[: len(z) // 2].max() > 0.9 * LIMIT / 30.0


@pytest.mark.parametrize("end", [12, 20])
def test_arc_length_steps_follow_a_path_whose_tangent_is_the_same_beyond_two_limit_points(end):
    path = Path(truss(f"{{method: arc_length, end: {end}}}"))
    np.testing.assert_allclose(30.0 * path.factors, truss_force(path.positions("top")[:, 2]), atol=1e-7 * 30 * end)
    assert path.unstable.sum() >= 3 and path.factors.min() < -0.7 * LIMIT / 30.0


def test_arc_length_ends_where_it_is_reported():
    static = "{method: arc_length, until: {node: top, direction: [0, 0, -1], displacement: 0.25}}"
    path = Path(truss(static))
    assert path.positions("top")[-1, 2] == pytest.approx(0.05, abs=1e-9)
    assert path.result.reason == "node 'top' was displaced by 0.25 m"
    path = Path(truss("{method: arc_length, lowest: -0.2}"))
    assert path.factors[-1] == pytest.approx(-0.2, abs=1e-8) and path.positions("top")[-1, 2] > -0.2


@pytest.mark.parametrize(("end", "factor"), [("", 1.0), ("lowest: -0.2, ", -0.2)])
def test_arc_length_that_ends_before_its_displacement(end, factor, tmp_path):
    """The end of the load factor is an end, with a warning in file and messages that says how far the node came."""
    until = "{node: top, direction: [0, 0, -1], displacement: 5.0}"
    said, path = [], tmp_path / "truss.h5"
    run(deck(truss(f"{{method: arc_length, {end}until: {until}}}")), path, announce=said.append)
    with open_results(path) as results:
        reached = 0.3 - results["nodes/top/position"].values[-1, 2]
        text = (
            f"the path ended at load factor {factor:g} before node 'top' was displaced by 5 m (static.until): it is "
            f"displaced by {reached:.6g} m"
        )
        assert text in results.reason and any(one.startswith(text) for one in said)
    met = Path(truss(f"{{method: arc_length, until: {until.replace('5.0', '0.25')}}}"))
    assert not any("static.until" in one for one in met.result.warnings)


def test_arc_length_that_does_not_reach_its_end(tmp_path):
    """The run fails, says where and why it stopped, and the file keeps the points on the way."""
    with pytest.raises(ConvergenceError) as caught:
        run(deck(truss("{method: arc_length, maximum_steps: 3, lowest: -0.5}")), tmp_path / "truss.h5")
    with open_results(tmp_path / "truss.h5") as results:
        assert len(results.time) == 4
        factors, places = results["static/load_factor"].values, results.time[:]
    text = str(caught.value)
    assert text.startswith(
        "the path did not reach its end (load factor 1 or -0.5, falling); it stopped at load factor "
    )
    reported = re.search(
        r"stopped at load factor (\S+), (\S+) along it, after a step of (\S+): 3 steps were made", text
    )
    assert [float(reported[i]) for i in (1, 2, 3)] == pytest.approx(
        [factors[-1], places[-1], places[-1] - places[-2]], rel=1e-2
    )
    assert "static.maximum_steps" in text and caught.value.exit_code == 3


def test_arc_length_that_cannot_go_on():
    """A force on a free body: the path stops at its start, and the free motion is named."""
    with pytest.raises(ConvergenceError, match="it stopped at load factor 0") as caught:
        Path(arm("static: {method: arc_length}", stiffness=0.0))
    assert "node 'pin' turns about [0, 1, 0]" in str(caught.value)


def test_steps_stop_at_a_limit_point():
    """The message names the load factor of the limit point, to the smallest step, and the motion that is soft."""
    with pytest.raises(ConvergenceError, match=r"node 'top' moves along \[0, 0, 1\]") as caught:
        Path(truss("{steps: 10}"))
    text = str(caught.value)
    factor = float(text.split("at load factor ")[2].split(":")[0])
    assert 0 < LIMIT / 30.0 - factor < 1e-4
    assert "method: arc_length" in text and "the units of loads and stiffness" in text and caught.value.exit_code == 3


@pytest.mark.parametrize("static", ["{steps: 1}", "{steps: 2}", "{end: 12, steps: 1}", "{end: 20}"])
def test_steps_far_beyond_a_limit_load_do_not_snap_through(static):
    """The loads are three times the limit load or more, under which the snapped truss is in equilibrium, too."""
    with pytest.raises(ConvergenceError, match="arc_length past a limit point") as caught:
        Path(truss(static))
    reached = float(re.search(r"at load factor ([0-9.]+): stable", str(caught.value)).group(1))
    assert 0.99 * LIMIT / 30.0 < reached < LIMIT / 30.0


def test_steps_that_fail_beside_a_free_motion_advise_to_hold_it():
    """The truss snaps through next to a rotor that spins freely, which may be the cause."""
    rotor = "hub: {type: rigid_body, node: hub, mass: 1, inertia: [1, 1, 1]}\n          a: {type: spring"
    text = truss("{steps: 10}").replace("top: {position", "hub: {position: [0, 3, 0]}\n          top: {position", 1)
    text = text.replace("a: {type: spring", rotor, 1).replace("joints:", "joints:\n          axle: AXLE", 1)
    for axle, free in (("hinge, nodes: [ground, hub], axis: [0, 1, 0]", True), ("fixed, nodes: [ground, hub]", False)):
        with pytest.raises(ConvergenceError) as caught:
            Path(text.replace("AXLE", f"{{type: {axle}}}"))
        assert ("a joint or spring that holds motions without stiffness" in str(caught.value)) == free


def test_pendulum_falls_into_place():
    """A pendulum, horizontal and without stiffness at first, comes to hang; the joint carries its weight."""
    text = arm("static: {method: relaxation}", stiffness=1e-9)
    path = Path(text)
    assert path.turns_about_y("pin")[-1] == pytest.approx(np.pi / 2, abs=1e-8)
    assert path.points[-1].stability.stable and path.points[-1].stability.stiffness == pytest.approx(
        2 * G * 0.5, rel=1e-6
    )
    with pytest.raises(ConvergenceError, match=r"node 'pin' turns about \[0, 1, 0\]"):
        Path(arm("static: {}", stiffness=1e-9))


def test_chain_hangs_in_its_catenary():
    """Closed form of a chain of rods with equal masses: each rod along (H, V - i w); H and V from the span."""
    links, length, weight = 8, 1.2 / 8, 0.5 * G

    def ends(unknowns, i=8):
        H, V = unknowns
        pulls = [(H, V - weight * j) for j in range(i)]
        return np.sum([length * np.array([h, -v]) / np.hypot(h, v) for h, v in pulls], axis=0)

    H, V = fsolve(lambda u: ends(u) - (1.0, 0.0), (15.0, 17.0), xtol=1e-13)
    path = Path(chain("static: {method: relaxation}", links))
    for i in range(1, links):
        np.testing.assert_allclose(path.positions(f"p{i}")[-1][[0, 2]], ends((H, V), i), atol=1e-12)
        assert abs(path.positions(f"p{i}")[-1][1]) < 1e-12
    assert path.points[-1].stability.stable


def test_buckling_is_reported():
    """An inverted pendulum on a spring buckles at mu = k/(m g c); the straight position stays an equilibrium."""
    path = Path(arm("static: {steps: 4}", centre="[0, 0, 0.5]"))
    critical = 6.0 / (2.0 * G * 0.5)
    np.testing.assert_array_equal(path.unstable, path.factors > critical)
    assert f"near {critical:.6g}, the equilibrium becomes unstable: node 'pin' turns about" in path.result.warnings[0]
    assert path.result.warnings[1].startswith("the equilibrium at load factor 1 is unstable")
    arc = Path(arm("static: {method: arc_length, steps: 4}", centre="[0, 0, 0.5]"))
    reported = re.search(r"between load factor .*, near (.*), the equilibrium becomes unstable", arc.result.warnings[0])
    assert float(reported[1]) == pytest.approx(critical, rel=1e-5)  # the least stiffness is linear in the load factor


def test_an_equilibrium_where_stability_is_lost_lies_within_the_reported_interval():
    """The second of four steps ends where the spring is just as strong as the weight: neither stable nor unstable."""
    path = Path(arm("static: {steps: 4}", centre="[0, 0, 0.5]", stiffness=0.5 * 2.0 * G * 0.5))
    np.testing.assert_array_equal(path.unstable, [0, 0, 0, 1, 1])
    assert path.points[2].stability.neutral == 1
    assert path.result.warnings[0].startswith("between load factor 0.25 and 0.75, near 0.5, the equilibrium becomes")


def test_a_slender_column_under_a_follower_force_has_no_static_instability():
    """Beck 1952: it flutters from 20.05 EI/L^2 on, but no other equilibrium is near at any force.

    The stiffness of the force is small beside the axial one, not beside that of bending.
    """
    path = Path("""
        mecano: 1
        gravity: none
        sections:
          s: {type: stiffness, EA: 1.0e8, GA2: 1.0e6, GA3: 1.0e6, GJ: 10, EI2: 1, EI3: 50, mass_per_length: 1,
              rotary_inertia: [1.0e-6, 1.0e-6, 1.0e-6]}
        nodes: {root: {position: [0, 0, 0], fixed: true}, tip: {position: [0, 0, 1]}}
        elements: {column: {type: beam, nodes: [root, tip], section: s, up: [1, 0, 0], mesh: 8}}
        loads: {push: {type: follower_force, node: tip, direction: [0, 0, -1], value: 40}}
        static: {steps: 4}
        """)
    assert not any("unstable" in text for text in path.result.warnings)


def test_mechanism_with_nothing_to_drive_it_is_neutral():
    path = Path(arm("static: {}", gravity=0.0, stiffness=0.0))
    assert path.points[-1].stability.neutral == 1 and not path.points[-1].stability.unstable
    assert "neutral" in path.result.warnings[0] and "node 'pin' turns about [0, 1, 0]" in path.result.warnings[0]


@pytest.mark.parametrize(("joint", "neutral"), [("", False), ("pin: {type: spherical, nodes: [ground, hub]}", True)])
def test_what_nothing_holds_may_float(joint, neutral):
    """A satellite of a hub and a boom has six motions without stiffness, which is no news; on a pin it has three."""
    prepared = prepare(
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{hub: {{position: [1, 2, 3], orientation: [0.3, 0.2, 0.1]}}, tip: {{position: [2, 2, 3]}}}}
        elements:
          hub: {{type: rigid_body, node: hub, mass: 5, inertia: [1, 1, 1]}}
          tip: {{type: rigid_body, node: tip, mass: 1, inertia: [0.1, 0.1, 0.1]}}
          boom: {{type: beam, nodes: [hub, tip], section: tube, mesh: 2}}
        joints: {{{joint}}}
        sections: {{tube: {{type: tube, diameter: 0.04, thickness: 0.002, E: 5.7e9, nu: 0.3, density: 1500}}}}
        initial: {{static: true}}
        time: {{end: 0.1, step: 2 ms}}
        """)
    )
    warnings = set_initial_state(prepared)
    assert any("3 direction(s) without stiffness" in text for text in warnings) == neutral == bool(warnings)


@pytest.mark.parametrize("method,why", [("steps", "the tangent is singular"), ("relaxation", "it still moves")])
def test_free_fall_has_no_equilibrium(method, why):
    text = """
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {a: {position: [0, 0, 0]}}
        elements: {m: {type: point_mass, node: a, mass: 1}}
        static: {method: METHOD}
        """
    with pytest.raises(ConvergenceError, match=why) as caught:
        Path(text.replace("METHOD", method))
    assert "3 direction(s) without stiffness" in str(caught.value) and "node a: force z" in str(caught.value)
    assert ("what to try: a joint or spring that holds this motion" in str(caught.value)) == (method == "steps")


def test_quasi_static_over_time():
    """A prescribed displacement takes the truss through its limit points; the reaction is the closed form."""
    text = truss("{over: time, end: 2, steps: 8}").replace(
        "        static", "          down: {type: prescribed_position, node: top, direction: [0, 0, 1], "
        "value: {linear: {slope: -0.3}}}\n        static"
    ).replace("value: 30.0", "value: 0")  # fmt: skip
    path = Path(text)
    z = path.positions("top")[:, 2]
    np.testing.assert_allclose(z, 0.3 - 0.3 * np.linspace(0, 2, 9), atol=1e-12)
    reaction = np.array([point.state.z[path.system.n_q + 1] for point in path.points])
    np.testing.assert_allclose(-reaction, truss_force(z), atol=1e-9)


def test_a_path_over_time_that_turns_back_advises_a_run():
    """The load of the truss grows beyond its limit load; arc_length and relaxation do not follow a path over time."""
    with pytest.raises(ConvergenceError, match="no equilibrium was found at t 0.33166") as caught:
        Path(truss("{over: time, steps: 20}", load="{linear: {slope: 30}}"))
    assert "a run (time: in place of static:" in str(caught.value) and "arc_length" not in str(caught.value)


def test_prescribed_angles_turn_many_times_between_two_equilibria(tmp_path):
    """A motor turns a gear four times within each of two steps; a spring on the other gear feels all turns."""
    geared = """
    mecano: 1
    gravity: none
    nodes: {pinion: {position: [0, 0, 0]}, wheel: {position: [0.27, 0, 0]}}
    elements:
      coil: {type: torsion_spring_damper, nodes: [ground, wheel], axis: [0, 0, 1], law: {spring: {stiffness: 0.5}}}
    joints:
      shaft: {type: hinge, nodes: [ground, pinion], axis: [0, 0, 1]}
      axle: {type: hinge, nodes: [ground, wheel], axis: [0, 0, 1]}
      teeth: {type: gear_pair, nodes: [ground, pinion, wheel], axis_a: [0, 0, 1], radius_a: 0.1, radius_b: 0.17}
      motor: {type: prescribed_angle, nodes: [ground, pinion], axis: [0, 0, 1], value: {linear: {slope: =16*pi}}}
    static: {over: time, end: 1, steps: 2}
    """
    run(deck(geared), tmp_path / "geared.h5")
    with open_results(tmp_path / "geared.h5") as results:
        turned = 16 * np.pi * results.time
        assert {0.5, 1.0} <= set(results.time)
        np.testing.assert_allclose(results["joints/shaft/angle"].values, turned, atol=1e-9)
        np.testing.assert_allclose(results["elements/coil/moment"].values, -0.5 * turned / 1.7, atol=1e-9)
        np.testing.assert_allclose(results["joints/motor/moment"].values, 0.5 * turned / 1.7**2, atol=1e-9)


def test_loads_that_ramp_over_time_start_from_their_value_at_the_start():
    loads = "loads: {a: {type: couple, nodes: [ground, pin], axis: [0, 1, 0], value: {linear: {slope: 2, offset: 1}}}}"
    path = Path(arm("static: {over: time, start: 1, end: 3, steps: 4}", gravity=0.0, more=loads))
    np.testing.assert_allclose(path.turns_about_y("pin"), (1.0 + 2.0 * np.linspace(1, 3, 5)) / 6.0, atol=1e-9)


@pytest.mark.parametrize(
    "load",
    [
        "{table: {points: [[0, 0], [3, 0], [3.2, 60], [3.4, 0], [10, 0]], interpolation: linear}}",
        "{table: {points: [[0, 0], [3, 0], [3.2, 60], [3.4, 0], [10, 0]]}}",
        "{bump: {start: 3, length: 0.4, height: 60}}",
    ],
    ids=["linear", "cubic", "bump"],
)
def test_automatic_steps_over_time_meet_the_peak_of_a_load(load):
    """Elsewhere nothing changes, and steps would grow beyond the peak; the arm has a spring of 6 N m/rad."""
    loads = f"loads: {{a: {{type: couple, nodes: [ground, pin], axis: [0, 1, 0], value: {load}}}}}"
    path = Path(arm("static: {over: time, end: 10}", gravity=0.0, more=loads.replace("60", "0.6")))
    assert path.turns_about_y("pin").max() == pytest.approx(0.1, abs=1e-9)
    assert len(path.points) < 16


def standing_wheel(method):
    """The wheel of inputs/wheel_drop.yaml, without speed."""
    text = input_deck("wheel_drop").text
    return text[: text.index("initial:")] + f"static: {{method: {method}}}\n"


def test_wheel_settles_on_the_ground():
    """From the air: the tyre is pressed in by m g/k; the lean of a wheel that only stands is unstable."""
    path = Path(standing_wheel("steps"))
    assert path.positions("hub")[-1, 2] == pytest.approx(0.3 - 20.0 * G / 2e5, abs=1e-9)
    assert [h.name for point in path.points for h in point.event_records] == ["touch_down"]
    assert path.unstable[-1] == 1 and "node 'hub' turns about [1, 0, 0]" in path.result.warnings[-1]


def test_relaxation_does_not_end_at_an_unstable_equilibrium(tmp_path):
    """The wheel falls flat, outside the range of its tyre: motion and elements are named, the file keeps the path."""
    with pytest.raises(ConvergenceError, match="no stable equilibrium was found at load factor 1") as caught:
        run(deck_of_bytes(standing_wheel("relaxation").encode(), "wheel.yaml"), tmp_path / "wheel.h5")
    text = str(caught.value)
    assert "node 'hub' turns about [1, 0, 0]; on it act rigid_body 'rim', wheel 'tire'" in text
    assert "lies flat" in text and "method: steps" in text and caught.value.exit_code == 3
    with open_results(tmp_path / "wheel.h5") as results:
        np.testing.assert_array_equal(results["static/unstable_directions"].values, (0, 1))
        assert results["nodes/hub/position"].values[-1, 2] == pytest.approx(0.3 - 20.0 * G / 2e5, abs=1e-9)


def elastica(ratio):
    """Tip (x, y) over the length of a clamped column under ``ratio`` = P L^2/EI: K(k)^2 = ratio, k the sine of half
    the angle of the tip (Timoshenko & Gere, Theory of Elastic Stability, 2.7)."""
    m = brentq(lambda m: ellipk(m) ** 2 - ratio, 1e-6, 1.0 - 1e-9)
    return 2.0 * ellipe(m) / ellipk(m) - 1.0, 2.0 * np.sqrt(m) / ellipk(m)


@pytest.mark.parametrize("load", [3000.0, 6272.77])
def test_relaxation_leaves_the_straight_column(load):
    """Beyond Euler's load, with one part in 10,000 of it sideways: the bent column, though the straight one is near."""
    path = Path(f"""
        mecano: 1
        gravity: [0, 0, 0]
        sections:
          strip: {{type: stiffness, EA: 1.0e9, GA2: 1.0e9, GA3: 1.0e9, GJ: 1.0e3, EI2: 1.0e3, EI3: 1.0e3,
                  mass_per_length: 1.0, rotary_inertia: [2.0e-4, 1.0e-4, 1.0e-4]}}
        nodes: {{root: {{position: [0, 0, 0], fixed: true}}, tip: {{position: [1, 0, 0]}}}}
        elements: {{strip: {{type: beam, nodes: [root, tip], section: strip, up: [0, 0, 1], mesh: 16}}}}
        loads:
          push: {{type: force, node: tip, direction: [-1, 0, 0], value: {load}}}
          side: {{type: force, node: tip, direction: [0, 1, 0], value: {1e-4 * load}}}
        static: {{method: relaxation}}
        """)
    x, y = elastica(load / 1.0e3)
    np.testing.assert_allclose(path.positions("tip")[-1], (x, y, 0.0), atol=2e-4)
    assert path.points[-1].stability.stable and "was found and left on the way" in path.result.warnings[0]


def test_relaxation_leaves_a_column_in_balance():
    """An inverted pendulum beyond its critical weight has no side of its own: k theta = m g c sin theta."""
    path = Path(arm("static: {method: relaxation}", centre="[0, 0, 0.5]"))
    expected = brentq(lambda theta: 6.0 * theta - 2.0 * G * 0.5 * np.sin(theta), 0.1, 3.0)
    assert path.turns_about_y("pin")[-1] == pytest.approx(expected, abs=1e-8)


def test_relaxation_leaves_an_unstable_equilibrium_of_a_large_model():
    """The same by pivots, in a model of more than 400 unknowns: a row of such pendulums, two of them top-heavy."""
    counts, heavy = range(140), (3, 40)
    bars = "\n".join(
        f"          b{i}: {{type: rigid_body, node: p{i}, mass: 2, "
        f"center_of_mass: [0, 0, {0.5 if i in heavy else 0.1}], inertia: [0.1, 0.1, 0.1]}}\n"
        f"          s{i}: {{type: torsion_spring_damper, nodes: [ground, p{i}], axis: [0, 1, 0], "
        "law: {spring: {stiffness: 6.0}}}"
        for i in counts
    )
    nodes = "\n".join(f"          p{i}: {{position: [0, {i}, 0]}}" for i in counts)
    hinges = "\n".join(f"          h{i}: {{type: hinge, nodes: [g{i}, p{i}], axis: [0, 1, 0]}}" for i in counts)
    feet = "\n".join(f"          g{i}: {{position: [0, {i}, 0], fixed: true}}" for i in counts)
    path = Path(f"""
        mecano: 1
        gravity: [0, 0, -{G}]
        nodes:
{nodes}
{feet}
        elements:
{bars}
        joints:
{hinges}
        static: {{method: relaxation}}
        """)
    expected = brentq(lambda theta: 6.0 * theta - 2.0 * G * 0.5 * np.sin(theta), 0.1, 3.0)
    assert path.system.n_q > DENSE and path.points[-1].stability.stable
    for i in counts:
        assert abs(path.turns_about_y(f"p{i}")[-1]) == pytest.approx(expected if i in heavy else 0.0, abs=1e-7)


def test_redundant_supports_share_the_weight():
    """A door on two hinges: the vertical reactions are not unique, their sum and the couple of the others are."""
    text = """
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {low: {position: [0, 0, 0]}, high: {position: [0, 0, 1]}}
        elements:
          door: {type: rigid_body, node: low, mass: 20, center_of_mass: [0.4, 0, 0], inertia: [1, 1, 1],
                 attached: [high]}
        joints:
          a: {type: hinge, nodes: [ground, low], axis: [0, 0, 1]}
          b: {type: hinge, nodes: [ground, high], axis: [0, 0, 1]}
        static: {}
        """
    path = Path(text)
    assert path.points[-1].stability.neutral == 1 and path.prepared.analysis.redundant
    assert np.abs(path.positions("high")[-1] - (0, 0, 1)).max() < 1e-9


def test_relaxation_ends_where_redundant_reactions_are_rounding():
    """A cantilever of two beams, whose latched hinges a coupler holds once more: F L^3/(3 EI), and F L/(GA) by shear.

    The reactions of redundant constraints follow from gaps of 1e-11 m, of which 1e-16 m is rounding: a force above the
    tolerance of an equilibrium.
    """
    text = """
        mecano: 1
        gravity: none
        sections:
          tube: {type: stiffness, EA: 1.0e7, GA2: 1.0e6, GA3: 1.0e6, GJ: 1000, EI2: 1500, EI3: 1500,
                 mass_per_length: 2, rotary_inertia: [1.0e-3, 5.0e-4, 5.0e-4]}
        nodes:
          root: {position: [0, 0, 0], fixed: true}
          s1: {position: [0, 0, 0]}
          e1: {position: [1, 0, 0]}
          s2: {position: [1, 0, 0]}
          tip: {position: [2, 0, 0]}
        elements:
          inner: {type: beam, nodes: [s1, e1], section: tube, up: [0, 0, 1], mesh: 3}
          outer: {type: beam, nodes: [s2, tip], section: tube, up: [0, 0, 1], mesh: 3}
        joints:
          h1: {type: hinge, nodes: [root, s1], axis: [0, 1, 0], turning_law: {preload: 1}}
          h2: {type: hinge, nodes: [e1, s2], axis: [0, -1, 0], turning_law: {preload: 0.25}}
          latch1: {type: prescribed_angle, nodes: [root, s1], axis: [0, 1, 0], value: 0}
          latch2: {type: prescribed_angle, nodes: [e1, s2], axis: [0, -1, 0], value: 0}
          cable: {type: coupler, angles: [h1, h2], factors: [1, 1]}
        loads: {push: {type: force, node: tip, direction: [0, 0, 1], value: 0.1}}
        static: {method: relaxation}
        """
    path = Path(text)
    assert path.prepared.analysis.redundant
    assert path.positions("tip")[-1, 2] == pytest.approx(0.1 * 2**3 / (3 * 1500) + 0.1 * 2 / 1e6, rel=1e-5)


STARTS = ("static", "{static: true}", "{static: {method: steps}}", "{static: {method: relaxation}}")


@pytest.mark.parametrize("start", STARTS)
def test_run_from_equilibrium_starts_without_acceleration(start):
    process = f"initial: {start}\n        time: {{end: 0.1, step: 0.01}}"
    prepared = prepare(deck(arm(process)))
    assert not equilibrium(prepared)
    run = integrator_of(prepared).begin(prepared.state, 0.01)
    assert np.abs(run.motion.a).max() < 1e-13 * G
    assert np.abs(run.motion.v).max() == 0.0


def test_run_of_a_chain_from_equilibrium_stays_there():
    process = "initial: static\ntime: {end: 0.5, step: 0.01}"
    recorded = RecordedRun(deck(chain(process)), start=equilibrium)
    for i in range(1, 8):
        position = recorded[f"nodes/p{i}/position"]
        assert np.abs(position - position[0]).max() < 1e-13


def test_velocities_come_on_top_of_the_equilibrium():
    process = (
        "initial: {static: true, velocities: [{nodes: [pin], angular_velocity: [0, 2, 0]}]}\n"
        "        time: {end: 0.1, step: 0.01}"
    )
    prepared = prepare(deck(arm(process)))
    equilibrium(prepared)
    run = integrator_of(prepared).begin(prepared.state, 0.01)
    spin = run.motion.v[prepared.system.numbering.r[0] :][:3]
    np.testing.assert_allclose(spin, (0, 2, 0), atol=1e-12)
    assert np.abs(run.motion.a[prepared.system.numbering.r[0] :][:3]).max() < 1e-12


@pytest.mark.parametrize(
    "static,text",
    [
        ("{end: 0}", "'end' must be greater than zero"),
        ("{over: time, start: 2}", "'end' must be greater than 'start', 2 s"),
        ("{over: time, method: arc_length}", "'method' arc_length follows the load factor"),
        ("{until: {node: top, direction: [1, 0, 0], displacement: 1}}", "'until' belongs to the method arc_length"),
        ("{method: arc_length, until: {node: tip, direction: [1, 0, 0], displacement: 1}}", "unknown node 'tip'"),
        ("{}\n        time: {end: 1, step: 0.1}", "'static' and 'time' exclude one another"),
        ("{}\n        initial: static", "'initial.static' belongs to a deck with 'time'"),
    ],
)
def test_decks_that_cannot_be(static, text):
    with pytest.raises(DeckError) as caught:
        deck(truss(static))
    assert text in str(caught.value)


def test_resolved_deck_stands_for_itself():
    import json

    from mecano.deck.read import deck_of_bytes

    for text in (truss("{method: arc_length}"), arm("initial: static\n        time: {end: 1, step: 0.1}")):
        first = deck(text)
        again = deck_of_bytes(json.dumps(first.resolved()).encode(), "again.yaml")
        assert again.values == first.values


def test_an_output_that_is_not_finite_ends_the_path(tmp_path, monkeypatch):
    """The moment of the third equilibrium: it is named, and not in the file, which keeps the equilibria before."""
    text = deck(arm("static: {steps: 4}"))
    sampler = Sampler(prepare(text).system)
    moment = next(c.start for c in sampler.columns if c.path == "joints/hinge/moment") - sampler.node_size
    observe = Follower.observe

    def spoiled(follower, s, p):
        found = observe(follower, s, p)
        found.outputs[moment] = np.nan if p == 0.5 else found.outputs[moment]
        return found

    monkeypatch.setattr(Follower, "observe", spoiled)
    with pytest.raises(NonFiniteError, match="from load factor 0.5: hinge 'hinge': moment is not finite"):
        run(text, tmp_path / "r.h5")
    with open_results(tmp_path / "r.h5") as results:
        assert results.status == "failed" and "moment is not finite" in results.reason
        np.testing.assert_array_equal(results.time, [0.0, 0.25])


@pytest.mark.parametrize("turn", [[1.3, 0.5, -0.9], [0.3, 0.2, 0.1], [1.0, 2.0, 0.5]])
def test_a_free_motion_in_any_direction_leaves_an_equilibrium(turn):
    """A load of 3 kg on 1200 N/m that turns freely about the vertical, all of it turned: m g/k below its place.

    Rounding keeps the tangent from being singular, and Newton's method from settling along the free motion.
    """
    Q = Rotation.from_rotvec(turn).as_matrix()
    first, _, up = Q.T.tolist()
    body = f"nodes.body={{position: {(0.2 * Q[:, 2]).tolist()}, orientation: {turn}}}"
    axes = f"joints.table.axis={up}", f"joints.table.axis_1={first}"
    prepared = prepare(
        input_deck("shaker_table", f"gravity={(-9.81 * Q[:, 2]).tolist()}", *axes, body, "initial={static: true}")
    )
    (warning,) = set_initial_state(prepared)
    assert "neutral: it may lie anywhere along a free motion; 1 direction" in warning
    place = prepared.state.z[prepared.system.numbering.x[0] :][:3]
    np.testing.assert_allclose(place, (0.2 - 3.0 * 9.81 / 1200.0) * Q[:, 2], rtol=0, atol=1e-9)


def test_rounding_along_free_motions_moves_nothing_away():
    """A ball that rolls on a turntable: Newton's method took it 1e30 m away, where every force is rounding."""
    prepared = prepare(input_deck("ball_on_turntable", "initial={static: true}"))
    start = prepared.state.copy()
    set_initial_state(prepared)
    first = prepared.system.numbering.x[[node.name for node in prepared.system.nodes].index("ball")]
    np.testing.assert_allclose(prepared.state.z[first:][:2], start.z[first:][:2], rtol=0, atol=1e-9)


def cruising(speed):
    """A block on a spring, and a flywheel that a controller of the speed drives, with an integrator."""
    return f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {{block: {{position: [0, 0, 0]}}, wheel: {{position: [0, 0, 0]}}}}
        elements:
          block: {{type: rigid_body, node: block, mass: 2, inertia: [1, 1, 1]}}
          wheel: {{type: rigid_body, node: wheel, mass: 1, inertia: [1, 1, 1]}}
        joints:
          guide: {{type: prismatic, nodes: [ground, block], axis: [0, 0, 1], sliding_law: {{spring: 1000}}}}
          axle: {{type: hinge, nodes: [block, wheel], axis: [0, 1, 0]}}
        signals:
          missing: {speed} - block.velocity.magnitude
          stored: {{type: integrator, input: missing}}
          torque: 20*missing + 10*stored
        loads: {{motor: {{type: joint_moment, joint: axle, value: torque}}}}
        static: {{}}
        """


def test_the_integrator_of_a_velocity_keeps_its_value_at_rest():
    """The flywheel does not turn away under a torque that rounding errors drive; its free motion is reported."""
    path = Path(cruising(0))
    assert path.positions("block")[-1, 2] == pytest.approx(-3 * G / 1000, rel=1e-9)
    assert path.turns_about_y("wheel")[-1] == pytest.approx(0, abs=1e-9)
    assert (path.points[-1].stability.neutral, path.points[-1].stability.unstable) == (1, 0)


def test_an_integrator_that_cannot_rest_is_named():
    with pytest.raises(ConvergenceError, match="integrator 'stored' cannot rest: the rate vanishes at no position"):
        Path(cruising(3))

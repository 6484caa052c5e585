"""Cables that slide over pulleys: cranes, machines with weights, arcs of many turns."""

import math
import textwrap

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from time_runs import RecordedRun, deck, input_deck

import mecano
from mecano.analyses.dynamic import run
from mecano.deck.format import deck_error_text
from mecano.deck.read import deck_of_bytes
from mecano.errors import ConvergenceError, DeckError
from mecano.post.belt_lines import belt_lines
from mecano.post.runs import opened_runs
from mecano.post.shapes import Motion

S, g = "Cables that slide over pulleys", 9.81


def test_a_crane(verify):
    recorded = RecordedRun(input_deck("crane"))
    strain = 4905 / 5e6
    height = recorded["nodes/hook/position"][-1, 2]
    verify(S, "crane: height of the hook after 15 s [m]", height, 7 + 5 * (1 + strain), "geometry", relative=1e-6)
    tension = recorded["elements/rope/tension"][-1]
    verify(S, "crane: tension of the rope [N]", tension, 4905.0, "equilibrium", relative=1e-4)
    np.testing.assert_allclose([recorded[f"elements/rope/wrap_{i}"][-1] for i in (1, 2, 3, 4)], math.pi, atol=1e-6)
    length = 68 + 0.8 * math.pi
    assert recorded["elements/rope/length"][0] == pytest.approx(length, rel=1e-12)
    assert recorded["elements/rope/natural_length"][-1] == pytest.approx(length / (1 + strain) - 20, rel=1e-12)
    given, lost = (recorded[f"energy/{name}"][-1] for name in ("given", "dissipated"))
    verify(S, "crane: work of the winch [J]", given - lost, 98148.1, "energies of load and rope", relative=1e-6)
    assert np.ptp(recorded["energy/balance"]) < 1e-6 * 98e3


TWO_WEIGHTS = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      left: {position: [-0.2, 0, -1]}
      wheel: {position: [0, 0, 0], fixed: true, orientation: [0.3, 0.2, 0]}
      right: {position: [0.2, 0, -1]}
    elements:
      left: {type: point_mass, node: left, mass: 3}
      right: {type: point_mass, node: right, mass: 2}
      rope: {type: reeved_cable, nodes: [left, wheel, right], radii: [0, -0.2, 0], axis: [0, -1, 0],
             axial_stiffness: 1.0e6, damping: 0.002, pretension: 23.544}
    time: {end: 0.5, step: 1.0e-3}
"""
FALL = 0.2 * g  # (m_1 - m_2) g/(m_1 + m_2)


def test_two_weights_over_pulleys_of_which_one_turns():
    """The heavier weight falls, with the tension 2 m_1 m_2 g/(m_1 + m_2), over one pulley and over two.

    The second of two pulleys turns by 20 rad meanwhile: the cable neither turns nor brakes it.
    """
    text = TWO_WEIGHTS.replace("    elements:", BESIDE_NODES + "    elements:")
    recorded = RecordedRun(deck(text.replace("    time:", BESIDE + "    time:")))
    for weight, rope in (("left", "rope"), ("low", "line")):
        assert recorded[f"nodes/{weight}/velocity"][-1, 2] == pytest.approx(-0.5 * FALL, rel=1e-5)
        assert recorded[f"elements/{rope}/tension"][-1] == pytest.approx(2.4 * g, rel=1e-5)
    wraps = [recorded[f"elements/line/wrap_{i}"] for i in (1, 2)]
    np.testing.assert_allclose(wraps, math.pi / 2, atol=1e-9)
    np.testing.assert_allclose(recorded["joints/bearing/rate"], 40.0, rtol=1e-9)
    assert np.ptp(recorded["energy/balance"]) < 1e-6


BESIDE_NODES = """\
      low: {position: [-0.2, 2, -1]}
      first: {position: [0, 2, 0], fixed: true}
      second: {position: [1, 2, 0]}
      high: {position: [1.2, 2, -1]}
"""
BESIDE = """\
      low: {type: point_mass, node: low, mass: 3}
      high: {type: point_mass, node: high, mass: 2}
      second: {type: rigid_body, node: second, mass: 1, inertia: [1, 1, 1]}
      line: {type: reeved_cable, nodes: [low, first, second, high], radii: [0, -0.2, -0.2, 0], axis: [0, -1, 0],
             axial_stiffness: 1.0e6, damping: 0.002, pretension: 23.544}
    joints:
      bearing: {type: hinge, nodes: [ground, second], axis: [0, 1, 0]}
    initial: {velocities: [{nodes: [second], angular_velocity: [0, 40, 0]}]}
"""


def test_a_slack_cable_goes_taut():
    """Both weights, thrown up at 1 m/s, fly freely until they are back after 2 v/g."""
    thrown = "initial: {velocities: [{nodes: [left, right], velocity: [0, 0, 1]}]}\n    time:"
    recorded = RecordedRun(deck(TWO_WEIGHTS.replace("time:", thrown)))
    taut = next(event.t for event in recorded.event_records if event.name == "goes taut")
    assert taut == pytest.approx(2 / g, abs=1e-4)
    assert np.all(recorded["elements/rope/tension"][recorded.time < taut] == 0.0)
    assert {event.name for event in recorded.event_records} == {"goes taut", "goes slack", "is relaxed"}


def test_a_rope_brake(verify):
    """The capstan formula with exp(mu theta) = 2: the drum loses its speed at m g r/I, and then both spans hold m g."""
    recorded = RecordedRun(input_deck("rope_brake"))
    rope = {
        name: recorded[f"elements/rope/{name}"] for name in ("tension_1", "tension_2", "slip_1", "dissipated_power")
    }
    sliding = recorded.time <= 0.99
    braked = 39.24 * (1.0 - recorded.time[sliding])
    found = np.array([rope["tension_1"], rope["tension_2"]]).T[sliding]
    verify(S, "rope brake: tensions [N]", found, [20 * g, 10 * g], "capstan formula", relative=1e-6)
    np.testing.assert_allclose(recorded["joints/bearing/rate"][sliding], braked, rtol=1e-6)
    np.testing.assert_allclose(rope["slip_1"][sliding], 0.2 * braked, rtol=1e-6)
    np.testing.assert_allclose(rope["dissipated_power"][sliding], 10 * g * rope["slip_1"][sliding], rtol=1e-6)
    assert np.all(rope["dissipated_power"] >= 0.0)
    turned = recorded["joints/bearing/angle"][-1]  # the last 1 cm/s of sliding are not those of Coulomb's law
    verify(S, "rope brake: angle at rest [rad]", turned, 19.62, "capstan formula", relative=2e-5)
    np.testing.assert_allclose([rope["tension_1"][-1], rope["tension_2"][-1]], 10 * g, rtol=1e-6)
    stretched, at_last = (0.5e-6 * (2.0 + 0.2 * math.pi) * N * N for N in (15 * g, 10 * g))
    risen = 1e-6 * (2.0 + 0.2 * math.pi) * 5 * g
    energy = 0.25 * 39.24**2 + stretched - at_last - 10 * g * risen
    verify(S, "rope brake: energy dissipated [J]", recorded["energy/dissipated"][-1], energy, "energies", relative=1e-6)
    assert np.ptp(recorded["energy/balance"]) < 1e-6 * energy


HOIST = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      winch: {position: [-0.1, 0, 0], fixed: true}
      head: {position: [0, 0, 6], fixed: true}
      hook: {position: [0.2, 0, 2]}
      anchor: {position: [0.3, 0, 6], fixed: true}
    elements:
      load: {type: rigid_body, node: hook, mass: 50, inertia: [1, 1, 1]}
      rope: {type: reeved_cable, nodes: [winch, head, hook, anchor], radii: [0, -0.1, 0.1, 0], axis: [0, -1, 0],
             axial_stiffness: 1.0e6, damping: 0.02, pretension: MEAN, payout: -time,
             friction: {coefficients: [0.1, 0.2], regularization: 0.01}}
    joints:
      guide: {type: prismatic, nodes: [ground, hook], axis: [0, 0, 1]}
    initial: {velocities: [{nodes: [hook], velocity: [0, 0, 0.5]}]}
    time: {end: 1.0, step: 2.0e-3}
"""


def test_a_winch_hauls_over_pulleys_with_friction(verify):
    """Two falls with the tensions q_1 N and q_1 q_2 N carry the load: the winch pulls with N = m g/(q_1 + q_1 q_2).

    Its payout is a formula.
    """
    q_1, q_2 = math.exp(-0.1 * math.pi), math.exp(-0.2 * math.pi)
    N = 50 * g / (q_1 + q_1 * q_2)
    spans = N * np.array([1.0, q_1, q_1 * q_2])
    halves = np.array([6.0 + 0.05 * math.pi, 4.0 + 0.1 * math.pi, 4.0 + 0.05 * math.pi])
    recorded = RecordedRun(deck(HOIST.replace("MEAN", str(halves @ spans / halves.sum()))))
    found = [recorded[f"elements/rope/tension_{i}"][-1] for i in (1, 2, 3)]
    verify(
        S, "hoist of two falls with friction: tensions [N]", np.array(found), spans, "capstan formula", relative=1e-7
    )
    strain, strain_rate = (recorded[f"elements/rope/{name}"][-1] for name in ("strain", "strain_rate"))
    rise, speed = recorded["nodes/hook/position"][-1, 2] - 2.0, recorded["nodes/hook/velocity"][-1, 2]
    slips = [recorded[f"elements/rope/slip_{i}"][-1] for i in (1, 2)]
    stretching = strain_rate / (1.0 + strain) * np.array([-halves[0], halves[2] - rise])
    np.testing.assert_allclose(slips, np.array([1.0 + strain, speed]) + stretching, rtol=1e-9)
    given = recorded["energy/given"][-1]
    assert given == pytest.approx(N, rel=strain)  # over 1 m of natural length
    assert np.ptp(recorded["energy/balance"]) < 1e-7 * given


WOUND = """
    mecano: 1
    gravity: none
    nodes:
      start: {position: [-2, 0, -0.2], fixed: true}
      wheel: {position: [0, 0, 0], fixed: true}
      hub: {position: [0, 0, 0]}
      tip: {position: [1, 0, 0]}
    elements:
      arm: {type: rigid_body, node: hub, mass: 1, inertia: [1, 1, 1], attached: [tip]}
      cable: {type: reeved_cable, nodes: [start, wheel, tip], radii: [0, 0.2, 0], axis: [0, -1, 0],
              axial_stiffness: 1.0e3, pretension: 5}
    joints:
      drive: {type: prescribed_angle, nodes: [ground, hub], axis: [0, -1, 0], value: {linear: {slope: 10}}}
      bearing: {type: hinge, nodes: [ground, hub], axis: [0, -1, 0]}
    initial: {velocities: [{nodes: [hub], angular_velocity: [0, -10, 0]}]}
    time: {end: 2.0, step: 0.02}
"""


def test_an_arc_of_many_turns():
    """The tip turns by 20 rad about the pulley: the free spans keep their lengths, the arc takes all of the angle."""
    recorded = RecordedRun(deck(WOUND))
    arc = math.pi / 2 - math.acos(0.2) + 20.0
    assert recorded["elements/cable/wrap_1"][-1] == pytest.approx(arc, rel=1e-9)
    length = 2.0 + math.sqrt(1 - 0.2**2) + 0.2 * arc
    assert recorded["elements/cable/length"][-1] == pytest.approx(length, rel=1e-9)


RISING = """
    mecano: 1
    gravity: none
    nodes:
      left: {position: [-1, 0, 0.1], fixed: true}
      wheel: {position: [0, 0, 0], fixed: true}
      right: {position: [1, 0, 0.1]}
    elements:
      right: {type: point_mass, node: right, mass: 1}
      rope: {type: reeved_cable, nodes: [left, wheel, right], radii: [0, -0.2, 0], axis: [0, -1, 0],
             axial_stiffness: 1.0}
    initial: {velocities: [{nodes: [right], velocity: [0, 0, 1]}]}
    time: {end: 1.0, step: 1.0e-3}
"""


def test_a_run_ends_where_the_cable_leaves_a_pulley(tmp_path):
    """The right end rises through the tangent from the left end to the circle, and 0.01 rad beyond."""
    path = tmp_path / "rising.h5"
    with pytest.raises(
        ConvergenceError, match=r"from t = 0\.\d+ s: reeved_cable 'rope' leaves pulley 1, at node 'wheel'"
    ):
        run(deck(RISING), path)
    results = mecano.open_results(path)
    wrap, (x, _, z) = results["elements/rope/wrap_1"].values, results["nodes/right/position"].values.T
    contact_left = math.atan2(0.1, -1.0) - math.acos(0.2 / math.hypot(1.0, 0.1))
    contact_right = np.arctan2(z, x) + np.arccos(0.2 / np.hypot(x, z))
    np.testing.assert_allclose(wrap, contact_left - contact_right, atol=1e-12)
    assert wrap[0] > 0.2 and wrap[-1] < 0.0 and wrap[:-1].min() > -0.01


def test_the_pulley_that_a_cable_leaves_is_named(tmp_path):
    """The second of two."""
    two = RISING.replace("nodes: [left, wheel", "nodes: [low, left, wheel").replace("radii: [0,", "radii: [0, -0.2,")
    two = two.replace("nodes:\n", "nodes:\n      low: {position: [-2, 0, -0.5], fixed: true}\n", 1)
    with pytest.raises(ConvergenceError, match="leaves pulley 2, at node 'wheel', where its arc \\(wrap_2\\)"):
        run(deck(two), tmp_path / "rising.h5")


def test_a_run_ends_where_a_load_is_hauled_into_its_pulley(tmp_path):
    hauled = TWO_WEIGHTS.replace("damping: 0.002", "payout: {linear: {slope: -5}}")
    with pytest.raises(ConvergenceError, match="reeved_cable 'rope' has no free span left"):
        run(deck(hauled), tmp_path / "hauled.h5")


ROUGH = "friction: {coefficients"


@pytest.mark.parametrize(
    "change, message",
    [
        (("radii: [0, -0.2, 0]", "radii: [0, -0.2]"), "'radii' must have 3 numbers, one for each node; it has 2"),
        ((", axis: [0, -1, 0]", ""), "missing 'axis', that of the pulleys"),
        (("radii: [0, -0.2, 0]", "radii: [0, -0.2, 0.1]"), "the cable ends at 'right', a point with the radius 0"),
        (("radii: [0, -0.2, 0]", "radii: [0, -2, 0]"), "'left' and 'wheel' are 1.02 m apart, and must be more than 2"),
        (("nodes: [left, wheel, right], radii: [0, -0.2, 0]", "nodes: [left, right], radii: [0, 0]"), "is a 'cable'"),
        (("axis: [0, -1, 0]", "axis: [0, -1, 0.9]"), "apart along it, not in one plane"),
        (
            ("damping: 0.002", f"{ROUGH}: [0.1, 0.2], regularization: 0.01}}"),
            "'friction' needs 1 coefficients, one for",
        ),
        (
            ("damping: 0.002", f"{ROUGH}: [-0.1], regularization: 0.01}}"),
            "'friction' needs coefficients that are not neg",
        ),
        (("damping: 0.002", "payout: -4"), "'payout' is -4 m at t = 0, and the cable is 2.628 m long"),
    ],
)
def test_errors(change, message):
    assert change[0] in TWO_WEIGHTS
    with pytest.raises(DeckError) as info:
        deck_of_bytes(textwrap.dedent(TWO_WEIGHTS).strip().replace(*change).encode(), "deck.yaml")
    found = deck_error_text(info.value)
    assert found.startswith("deck.yaml:") and message in found


SWINGING = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      anchor: {position: [-0.2, 0, 0], fixed: true}
      block: {position: [0, 0, -4]}
      head: {position: [0.35, 0, 0], fixed: true}
      weight: {position: [0.5, 0, -3]}
    elements:
      block: {type: rigid_body, node: block, mass: 100, inertia: [2, 2, 2]}
      weight: {type: rigid_body, node: weight, mass: 45, inertia: [1, 1, 1]}
      rope: {type: reeved_cable, nodes: [anchor, block, head, weight], radii: [0, 0.2, -0.15, 0], axis: [0, -1, 0],
        axial_stiffness: 1.0e5, pretension: 450}
    initial: {velocities: [{nodes: [block], velocity: [1.5, 0, 0]}]}
    time: {end: 2, step: STEP, rho_inf: 1.0}
"""
SWUNG = np.array([[0.16048129, 0, -4.79376100], [0.5, 0, -1.41107754]])


def test_a_swinging_block_and_tackle():
    """Positions of block and weight by SciPy (DOP853, 1e-10) from the potential EA (l - L)^2/(2 L) of the path alone.

    With the same steps Exudyn 1.13 gives those of mecano to 5e-11 m (tests/benchmarks/reeving.py).
    """
    errors = []
    for step in ("2e-3", "1e-3"):
        m = RecordedRun(deck(SWINGING.replace("STEP", step)))
        ends = [m[f"nodes/{name}/position"][-1] for name in ("block", "weight")]
        errors.append(np.abs(np.array(ends) - SWUNG).max())
    assert errors[1] < 4e-6 and 3.8 < errors[0] / errors[1] < 4.2


DRUM = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      drum: {position: [0, 0, 0]}
      foot: {position: [0, 0, 0.2], fixed: true}
      head: {position: [2, 0, 3], fixed: true}
      load: {position: [2.3, 0, 1]}
    elements:
      drum: {type: rigid_body, node: drum, mass: 10, inertia: [0.5, 0.5, 0.5]}
      load: {type: point_mass, node: load, mass: 20}
      rope: {type: reeved_cable, nodes: [foot, head, load], radii: [0, -0.3, 0], axis: [0, -1, 0],
        axial_stiffness: 1.0e8, pretension: 75.4615384615, damping: 0.1 ms, payout: 0.2*bearing.angle}
    joints: {bearing: {type: hinge, nodes: [ground, drum], axis: [0, 1, 0]}}
    loads: {pull: {type: joint_moment, joint: bearing, value: 0.2*rope.tension}}
    time: {end: 1, step: 1 ms}
"""


def test_a_drum_that_pays_out_a_rope_bears_its_tension(verify):
    """The load of 20 kg falls with the drum of J = 0.5 kg m2 and r = 0.2 m: a = m g/(m + J/r^2), T = m (g - a)."""
    m, fall = RecordedRun(deck(DRUM)), 20 * g / (20 + 0.5 / 0.2**2)
    source = "rope on a drum with inertia, closed form"
    found = m["joints/bearing/rate"][-1] * 0.2
    verify(S, "drum that pays out a rope: speed after 1 s [m/s]", found, fall, source, relative=1e-5)
    np.testing.assert_allclose(m["elements/rope/tension"][-1], 20 * (g - fall), rtol=1e-5)
    assert np.ptp(m["energy/balance"]) < 1e-7 * np.ptp(m["energy/kinetic"])


THREADED = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      post: {position: [0, 0, 3], fixed: true}
      ring: {position: [1.5, 0.5, 1.8]}
      corner: {position: [3, -1, 3], fixed: true}
      weight: {position: [3.4, -1.3, 1.5]}
    elements:
      ring: {type: point_mass, node: ring, mass: 2}
      weight: {type: point_mass, node: weight, mass: 1.5}
      rope: {type: reeved_cable, nodes: [post, ring, corner, weight], radii: [0, 0, 0, 0], axial_stiffness: 400,
             pretension: 15}
    joints: {level: {type: held_rotation, nodes: [ground, ring]}}
    initial: {velocities: [{nodes: [ring], velocity: [0.5, 1, 0]}, {nodes: [weight], velocity: [0, 0.6, 0]}]}
    time: {end: 1.2, step: STEP, rho_inf: 1}
"""


def test_a_rope_slides_through_a_ring_and_a_corner(verify):
    """In space, from the potential EA (l - L)^2/(2 L) of its length alone, with the tension at the start."""
    corners = np.array([[0.0, 0.0, 3.0], [3.0, -1.0, 3.0]])
    start, masses = np.array([1.5, 0.5, 1.8, 3.4, -1.3, 1.5]), np.repeat([2.0, 1.5], 3)

    def spans(x):
        points = np.array([corners[0], x[:3], corners[1], x[3:]])
        d = np.diff(points, axis=0)
        return d, np.linalg.norm(d, axis=1)

    natural = spans(start)[1].sum() / (1.0 + 15.0 / 400.0)

    def motion(_, y):
        d, lengths = spans(y[:6])
        pulls = 400.0 * (lengths.sum() / natural - 1.0) * d / lengths[:, None]
        force = np.concatenate([pulls[1] - pulls[0], -pulls[2]]) / masses
        return np.concatenate([y[6:], force - np.tile([0.0, 0.0, g], 2)])

    begin = np.concatenate([start, [0.5, 1.0, 0.0, 0.0, 0.6, 0.0]])
    exact = solve_ivp(motion, (0.0, 1.2), begin, "DOP853", rtol=1e-11, atol=1e-11).y[:6, -1]
    found = []
    for step in ("1 ms", "0.5 ms"):
        m = RecordedRun(deck(THREADED.replace("STEP", step)))
        found.append(np.concatenate([m[f"nodes/{name}/position"][-1] for name in ("ring", "weight")]))
        assert not any(event.name == "goes slack" for event in m.event_records)
    verify.second_order(
        S, "rope through a ring and an eyelet: places [m]", *found, exact, 1e-8, "SciPy, from its length"
    )


HAULED = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      winch: {position: [0, 0, 0], fixed: true}
      ring: {position: [1, 0.5, 2], fixed: true}
      block: {position: [2.1, -1, 3], fixed: true}
      load: {position: [2, -1, 1]}
    elements:
      load: {type: point_mass, node: load, mass: 20}
      rope: {type: reeved_cable, nodes: [winch, ring, block, load], radii: [0, 0, BLOCK, 0], axis: [0, -1, 0],
             axial_stiffness: 1.0e5, damping: 0.02, pretension: 300, payout: PAYOUT,
             friction: {coefficients: [0.2, 0.3], regularization: 0.01}}
    joints:
      x: {type: prescribed_position, node: load, direction: [1, 0, 0], value: 0}
      y: {type: prescribed_position, node: load, direction: [0, 1, 0], value: 0}
    time: {end: 1.5, step: 1 ms}
"""


@pytest.mark.parametrize(("payout", "sense"), [("-0.5*time", 1.0), ("0.5*time", -1.0)], ids=["hauled", "lowered"])
def test_tensions_of_a_rope_that_slides_through_eyelets(verify, payout, sense):
    """In space: at each eyelet the tensions differ by exp(mu times the angle between the spans)."""
    m = RecordedRun(deck(HAULED.replace("BLOCK", "0").replace("PAYOUT", payout)))
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.5, 2.0], [2.1, -1.0, 3.0], m["nodes/load/position"][-1]])
    along = np.diff(points, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    bends = np.arccos([along[0] @ along[1], along[1] @ along[2]])
    found = np.array([m[f"elements/rope/tension_{i}"][-1] for i in (1, 2, 3)])
    ratios = np.exp(sense * np.array([0.2, 0.3]) * bends)
    what = f"rope {'hauled' if sense > 0.0 else 'lowered'} through two eyelets: ratios of the tensions"
    verify(S, what, found[:-1] / found[1:], ratios, "capstan formula", relative=1e-9)
    assert found[2] * -along[2, 2] == pytest.approx(20 * g, rel=2e-3)
    lost, drift = m["energy/dissipated"], m["energy/balance"]
    assert np.all(np.diff(lost) > -1e-12) and lost[-1] > 10.0
    assert np.ptp(drift) < 1e-5 * lost[-1]


def test_a_small_pulley_is_nearly_an_eyelet():
    """Of the radius 1 mm, in a plane, instead of the second eyelet; the first one stays."""
    plane = HAULED.replace("1, 0.5, 2]", "1, 0, 2]").replace("-1, 3]", "0, 3]").replace("2, -1, 1]", "2, 0, 1]")
    eyelet, pulley = (RecordedRun(deck(plane.replace("BLOCK", r).replace("PAYOUT", "-time/2"))) for r in ("0", "-1e-3"))
    for i in (1, 2, 3):
        name = f"elements/rope/tension_{i}"
        np.testing.assert_allclose(pulley[name][-1], eyelet[name][-1], rtol=2e-3)
        assert pulley[name][-1] != eyelet[name][-1]


def test_the_spans_of_a_rope_through_eyelets_are_drawn(tmp_path):
    """Straight from node to node; there are no pulleys."""
    run(deck(THREADED.replace("STEP", "1 ms").replace("end: 1.2", "end: 0.01")), tmp_path / "rope.h5")
    with opened_runs([tmp_path / "rope.h5"]) as [recorded]:
        motion = Motion(recorded, slice(None))
        lines = belt_lines(motion, recorded.deck["elements"]["rope"])
        places = [motion.position(node) for node in ("post", "ring", "corner", "weight")]
    for line, ends in zip(lines, zip(places, places[1:], strict=False), strict=True):
        np.testing.assert_allclose(line, np.stack(ends, axis=1), atol=1e-12)

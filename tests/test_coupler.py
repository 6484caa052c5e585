"""Couplers: synchronised deployment against the integral of its energy, a spindle, errors of decks."""

import numpy as np
import pytest
from convergence import at_times
from scipy.integrate import quad
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.friction_and_play import sticking_warnings
from mecano.analyses.kind_samples import samples
from mecano.deck.build import build, set_velocities
from mecano.elements.joints.coupler import COUPLER
from mecano.errors import DeckError
from mecano.model.system import System

MOTOR = 0.5  # N m


@pytest.fixture(scope="module")
def panels():
    return [RecordedRun(input_deck("synchronised_panels", "time.end=3.6", f"time.step={h}")) for h in (4e-3, 2e-3)]


def test_two_panels_deploy_together(verify, panels):
    """With u = s^2 the time to u = pi/2, from the energy of the deck's first lines, is an integral without a pole."""
    instant, _ = quad(lambda s: 2.0 * np.sqrt((2 / 3 + 2 * np.cos(s * s) ** 2) / (2 * MOTOR)), 0.0, np.sqrt(np.pi / 2))
    found = [np.array([locked.t, locked.lost]) for m in panels for locked in m.event_records]
    what = "two synchronised panels: instant of the latch [s], energy lost [J]"
    verify.second_order("Coupler", what, *found, np.array([instant, MOTOR * np.pi / 2]), 1e-6, "energy")


def test_the_synchronisation_turns_the_outer_panel(panels):
    for m in panels:
        np.testing.assert_allclose(2.0 * m["joints/root_hinge/angle"] + m["joints/elbow_hinge/angle"], 0.0, atol=1e-9)
        assert m["joints/synchronisation/load_2"][0] == pytest.approx(5 / 16 * MOTOR, rel=1e-6)
        assert m["joints/synchronisation/load_1"][0] == pytest.approx(5 / 8 * MOTOR, rel=1e-6)


SPINDLE = """
    mecano: 1
    gravity: none
    nodes: {wheel: {position: [0, 0, 0]}, nut: {position: [1, 0, 0]}}
    elements:
      wheel: {type: rigid_body, node: wheel, mass: 1, inertia: [0.02, 0.02, 0.02]}
      nut: {type: rigid_body, node: nut, mass: 2, inertia: [1, 1, 1]}
    joints:
      bearing: {type: hinge, nodes: [ground, wheel], axis: [0, 0, 1]}
      guide: {type: prismatic, nodes: [ground, nut], axis: [1, 0, 0]}
      drive: {type: coupler, GIVEN}
    loads: {motor: {type: joint_moment, joint: bearing, value: 0.3}}
    time: {end: 0.5, step: 0.005}
    """
TRAVEL = 0.1  # m/rad, of the nut


def test_an_angle_drives_a_displacement():
    """The moment M turns the inertia I and, by the travel r, moves the mass m: the acceleration is M/(I + m r^2)."""
    m = RecordedRun(deck(SPINDLE.replace("GIVEN", "angles: [bearing], displacements: [guide], factors: [0.1, -1]")))
    acceleration = 0.3 / (0.02 + 2.0 * TRAVEL**2)
    np.testing.assert_allclose(m["joints/bearing/angle"], 0.5 * acceleration * m.time**2, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(m["joints/guide/displacement"], TRAVEL * m["joints/bearing/angle"], atol=1e-10)
    np.testing.assert_allclose(m["joints/drive/load_2"], 2.0 * TRAVEL * acceleration, rtol=1e-6)
    np.testing.assert_allclose(m["joints/drive/load_1"], -2.0 * TRAVEL**2 * acceleration, rtol=1e-6)
    assert np.ptp(m["energy/balance"]) < 1e-6 * m["energy/kinetic"].max()


CHAIN = """
    mecano: 1
    gravity: none
    nodes: {inner: {position: [0, 0, 0]}, outer: {position: [0, 0, 0]}}
    elements:
      inner: {type: rigid_body, node: inner, mass: 1, inertia: [1, 1, 0.3]}
      outer: {type: rigid_body, node: outer, mass: 1, inertia: [1, 1, 0.2]}
    joints:
      first: {type: hinge, nodes: [ground, inner], axis: [0, 0, 1]}
      second: {type: hinge, nodes: [inner, outer], axis: [0, 0, 1]}
      relation: {type: coupler, angles: [first, second], factors: [3, 1], constant: 0.6}
    loads: {motor: {type: joint_moment, joint: first, value: 0.7}}
    time: {end: 6, step: 0.01}
    """


def test_both_joints_share_a_node_and_turn_many_times():
    """The outer body turns by c - 2 u when the inner one turns by u: I = I_inner + 4 I_outer."""
    m = RecordedRun(deck(CHAIN))
    inner, outer = m["joints/first/angle"], m["joints/second/angle"]
    np.testing.assert_allclose(3.0 * inner + outer, 0.6, atol=1e-8)
    np.testing.assert_allclose(inner - inner[0], 0.35 / (0.3 + 4.0 * 0.2) * m.time**2, rtol=1e-6, atol=1e-8)
    assert outer[-1] < -10.0 * np.pi


ENGINE, BRAKE = 60.0, 20.0  # N m, of the deck
CARRIER, LEFT, RIGHT = 1.5, 0.8, 1.2  # kg m2


def test_a_differential_halves_the_moment_of_its_carrier(verify):
    """Lagrange's equations of both wheels, with the angle of the carrier (left + right)/2."""
    m = RecordedRun(input_deck("differential", "time.end=0.5"))
    inertia = np.diag([LEFT, RIGHT]) + CARRIER / 4.0
    left, right = np.linalg.solve(inertia, [ENGINE / 2.0, ENGINE / 2.0 - BRAKE])
    load = CARRIER * (left + right) / 2.0 - ENGINE
    for name, acceleration in (("carrier", (left + right) / 2.0), ("left", left), ("right", right)):
        angle = m[f"joints/{name}_bearing/angle"]
        np.testing.assert_allclose(angle, 0.5 * acceleration * m.time**2, rtol=1e-9, atol=1e-9)
    loads = np.array([m[f"joints/differential/load_{i}"] for i in (1, 2, 3)]).T
    what = "differential of three shafts: moments [N m]"
    verify("Coupler", what, loads, load * np.array([1.0, -0.5, -0.5]), "Lagrange's equations", relative=1e-9)
    assert np.ptp(m["energy/balance"]) < 1e-9 * m["energy/kinetic"].max()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("angles: [bearing], factors: [1]", "'angles' and 'displacements' must name at least two joints together"),
        ("angles: [bearing, bearing], factors: [1, 2]", "'angles' names the same joint twice: add its factors"),
        ("angles: [bearing], displacements: [guide], factors: [1]", "'factors' must have 2 numbers: of the 'angles', "),
        ("angles: [bearing], displacements: [guide], factors: [1, 0]", "'factors[1]' must not be zero"),
        ("angles: [bearing, guide], factors: [1, 1]", "prismatic 'guide' has no angle"),
        ("angles: [bearing, gide], factors: [1, 1]", "unknown joint 'gide'"),
        ("angles: bearing, factors: [1, 1]", "'angles' must be a list"),
    ],
)
def test_wrong_couplers(given, message):
    with pytest.raises(DeckError) as error:
        deck(SPINDLE.replace("GIVEN", given))
    assert message in error.value.problems[0].message


LOSSY = "friction: {efficiency: 0.8, backdriving_efficiency: 0.5, regularization: 1.0e-6}"


def test_efficiency_by_the_direction_of_the_power():
    """The driven side receives 0.8 or, backward, -0.2 of the load of the driving one, whatever the coordinates are."""
    found = [sample for sample in samples(COUPLER) if sample.values["friction"]]
    for sample in found:
        joint, relation = sample.instances[:2]
        joint.p["regularization"] = 1e-12
        state = joint.local(sample.motion)
        for reaction in (0.7, -0.7):
            state[0][-1] = reaction
            y = np.zeros(len(joint.kind.outputs))
            joint.run("observe", 0.0, state, np.zeros_like(state[0]), y, np.zeros(4))
            first, others = y[0], y[1:-1] / joint.p["ratios"][0, 1:]
            forward = reaction * (others[0] - first) < 0.0  # the difference has the sign of the rate
            expected = 0.8 * first if forward else first / -0.2
            np.testing.assert_allclose(others, expected, rtol=1e-12)
    assert len(found) == 3


def test_a_multiplier_balances_a_violation_of_a_lossy_coupler():
    """The penalty of a violation, such as the rounding of angles, acts as a change of the multiplier does."""
    penalty, found = 1e3, [sample for sample in samples(COUPLER) if sample.values["friction"]]
    for sample in found:
        _, relation, friction = sample.instances
        state = relation.local(sample.motion)
        violation = relation.constraint_derivatives(0.0, state)[0, 0]
        penalized = [one.residual(0.0, state, penalty=penalty) for one in (relation, friction)]
        assert abs(penalty * violation) > 10.0
        state[0][-1] -= penalty * violation
        balanced = [one.residual(0.0, state) for one in (relation, friction)]
        np.testing.assert_allclose(penalized, balanced, rtol=1e-12)
        assert np.abs(penalized[1]).max() > 1.0
    assert len(found) == 3


@pytest.mark.slow
def test_a_lossy_coupler_drives_and_brakes(verify):
    """The motor drives the nut with 0.8 of its power; reversed, the nut is braked and gives back 0.5 of its own."""
    text = SPINDLE.replace("GIVEN", f"angles: [bearing], displacements: [guide], factors: [0.1, -1], {LOSSY}")
    text = text.replace("value: 0.3", "value: {step: {time: 0.25, rise: 0, from: 0.3, to: -0.3}}")
    m = RecordedRun(deck(text.replace("end: 0.5", "end: 0.4")))
    wheel, nut = 0.02, 2.0 * TRAVEL**2
    driving, braking = 0.3 / (wheel + nut / 0.8), -0.3 / (wheel + 0.5 * nut)
    rate, speed = m["joints/bearing/rate"].ravel(), [driving * 0.25, driving * 0.25 + braking * 0.15]
    found = [rate[np.searchsorted(m.time, t)] for t in (0.25, 0.4)]
    verify("Coupler", "efficiency: rates after driving and braking [rad/s]", found, speed, "momentum", relative=1e-6)
    load_1, load_2, lost = (m[f"joints/drive/{name}"].ravel() for name in ("load_1", "load_2", "dissipated_power"))
    drives, brakes = (m.time > 0.01) & (m.time < 0.24), m.time > 0.26
    np.testing.assert_allclose(load_2[drives] * TRAVEL, -0.8 * load_1[drives], rtol=1e-6)
    np.testing.assert_allclose(load_1[brakes], -0.5 * load_2[brakes] * TRAVEL, rtol=1e-6)
    np.testing.assert_allclose(lost, -(load_1 + TRAVEL * load_2) * rate, atol=1e-6)
    assert np.ptp(m["energy/balance"]) < lost[1] * m.time[1]  # the first step, in which the friction sets in


@pytest.mark.slow
def test_a_self_locking_coupler_holds_its_load():
    """A worm of 40 % and driven backward by the nut -20 %: the load of 5 N creeps below the regularization."""
    lock = "friction: {efficiency: 0.4, backdriving_efficiency: -0.2, regularization: 1.0e-3}"
    text = SPINDLE.replace("GIVEN", f"angles: [bearing], displacements: [guide], factors: [0.1, -1], {lock}")
    text = text.replace("joint: bearing, value: 0.3", "joint: guide, value: 5").replace("joint_moment", "joint_force")
    m = RecordedRun(deck(text.replace("end: 0.5", "end: 0.1")))
    mu = 2.0 * 1.2 / 0.8  # 3; it creeps where mu phi = 2
    creep = 1e-3 * (1.0 - np.sqrt(1.0 - 2.0 / mu))
    assert m["joints/bearing/rate"][-1] == pytest.approx(creep, rel=1e-3)
    assert abs(m["joints/drive/load_1"][-1]) < 1e-3 * 0.5


@pytest.mark.parametrize(("speed", "sticks"), [(0.0, True), (0.1, False)])
def test_modes_of_a_coupler_that_sticks_are_warned_of(speed, sticks):
    """The rate of the first coordinate is compared with the regularization, a rate in its unit."""
    text = SPINDLE.replace("GIVEN", f"angles: [bearing], displacements: [guide], factors: [0.1, -1], {LOSSY}")
    text = text.replace("time:", "initial: {velocities: [{nodes: [wheel], angular_velocity: [0, 0, SPEED], about: own},"
                        "\n               {nodes: [nut], velocity: [TRAVEL, 0, 0]}]}\n    time:")  # fmt: skip
    text = text.replace("SPEED", str(speed)).replace("TRAVEL", str(TRAVEL * speed))
    checked = deck(text)
    system = System(build(checked))
    start = system.initial_state(0.0)
    set_velocities(checked, system, start)
    warnings = list(sticking_warnings(checked, system, start))
    assert len(warnings) == sticks and all("coupler 'drive': regularized friction acts" in one for one in warnings)


@pytest.mark.parametrize(
    ("friction", "message"),
    [
        ("{efficiency: 1.2, regularization: 1}", "must be greater than 0 and at most 1"),
        ("{efficiency: 0.9, backdriving_efficiency: -1, regularization: 1}", "must be greater than -1 and at most 1"),
        ("{efficiency: 0.9}", "missing 'friction.regularization'"),
    ],
)
def test_wrong_efficiencies(friction, message):
    with pytest.raises(DeckError) as error:
        deck(
            SPINDLE.replace(
                "GIVEN", f"angles: [bearing], displacements: [guide], factors: [0.1, -1], friction: {friction}"
            )
        )
    assert message in error.value.problems[0].message


SHAFTS = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}, b: {position: [0.3, 0, 0]}, c: {position: [0, 1, 0]}}
    elements:
      shaft_$i: {repeat: {i: [a, b, c]}, type: rigid_body, node: $i, mass: 1, inertia: [2, 2, 3]}
    joints:
      bearing_$i: {repeat: {i: [a, b, c]}, type: hinge, nodes: [ground, $i], axis: [0, 0, 1]}
      gears: {type: gear_pair, nodes: [ground, a, b], axis_a: [0, 0, 1], radius_a: 0.1, radius_b: 0.2}
      chain: {type: coupler, angles: [bearing_a, bearing_c], factors: [1, 0.7]}
    initial:
      velocities:
        - {nodes: [a], angular_velocity: [0, 0, 700], about: own}
        - {nodes: [b], angular_velocity: [0, 0, -350], about: own}
        - {nodes: [c], angular_velocity: [0, 0, -1000], about: own}
    time: {end: 15, step: 2 ms}
"""


def test_gears_and_couplers_turn_as_long_as_they_like():
    """After 15,000 rad, which are known to 2e-12 rad, the iterations of a step still converge to its tolerances."""
    recorded = RecordedRun(deck(SHAFTS))
    for shaft, angle in (("a", 10500.0), ("b", -5250.0), ("c", -15000.0)):
        assert recorded[f"joints/bearing_{shaft}/angle"][-1] == pytest.approx(angle, rel=1e-12)
    assert recorded.run.iterations < 2.0 * recorded.run.steps


FLYWHEELS = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}, b: {position: [1, 0, 0]}}
    elements:
      first: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 0.3]}
      second: {type: rigid_body, node: b, mass: 1, inertia: [1, 1, 0.2]}
    joints:
      shaft_a: {type: hinge, nodes: [ground, a], axis: [0, 0, 1]}
      shaft_b: {type: hinge, nodes: [ground, b], axis: [0, 0, 1]}
      variator: {type: coupler, angles: [shaft_b, shaft_a], ratio: RATIO}
    initial: {velocities: [{nodes: [a], angular_velocity: [0, 0, 10]}, {nodes: [b], angular_velocity: [0, 0, 5]}]}
    time: {end: 2, step: STEP}
    """
RAMP = "{step: {time: 0.5, rise: 1, from: 0.5, to: 2}}"


def _ramp(t):
    u = np.clip(t - 0.5, 0.0, 1.0)
    return 0.5 + 1.5 * u**3 * (10.0 - 15.0 * u + 6.0 * u**2), 45.0 * u**2 * (1.0 - u) ** 2


@pytest.mark.parametrize("ratio", [RAMP, '"0.5 + 1.5*step(time, 0.5, 1.5)"'], ids=["law", "signal"])
def test_two_flywheels_keep_their_energy_while_the_ratio_is_ramped(verify, ratio):
    """(J_a + J_b r^2) w^2 is constant; the moment on b is J_b (r w)'."""
    runs = [RecordedRun(deck(FLYWHEELS.replace("RATIO", ratio).replace("STEP", step))) for step in ("4e-3", "2e-3")]
    t = np.arange(0.6, 1.45, 0.1)
    found = [
        np.concatenate([at_times(m, m[f"joints/{name}"], t) for name in ("shaft_a/rate", "variator/load_1")])
        for m in runs
    ]
    r, slope = _ramp(t)
    inertia = 0.3 + 0.2 * r**2
    rate = 10.0 * np.sqrt((0.3 + 0.2 * 0.25) / inertia)
    moment = 0.2 * slope * rate * (1.0 - 0.2 * r**2 / inertia)
    what = f"two flywheels, ratio ramped by a {'law' if ratio is RAMP else 'signal'}: rate [rad/s], moment [N m]"
    verify.second_order("Coupler", what, *found, np.concatenate([rate, moment]), 3e-6, "energy")
    for m in runs:
        energy = m["energy/kinetic"]
        np.testing.assert_allclose(energy, energy[0], rtol=1e-5)
        power = m["joints/variator/load_1"] * m["joints/shaft_b/rate"] + (
            m["joints/variator/load_2"] * m["joints/shaft_a/rate"]
        )
        np.testing.assert_allclose(power, 0.0, atol=1e-9)
        assert not m["energy/given"].any() and not m["energy/dissipated"].any()


def test_a_ratio_that_depends_on_an_angle():
    """b' = (1/2 + a/20) a' is b = a/2 + a^2/40, and the energy is kept."""
    m = RecordedRun(deck(FLYWHEELS.replace("RATIO", "0.5 + shaft_a.angle/20").replace("STEP", "1e-3")))
    a, b, rate = m["joints/shaft_a/angle"], m["joints/shaft_b/angle"], m["joints/shaft_a/rate"]
    np.testing.assert_allclose(b, a / 2.0 + a**2 / 40.0, rtol=0.0, atol=1e-5)
    np.testing.assert_allclose((0.3 + 0.2 * (0.5 + a / 20.0) ** 2) * rate**2, 35.0, rtol=1e-6)


def test_a_ratio_that_depends_on_a_speed():
    """A governed ratio 1/2 + w/20: with the energy also w is constant, until a moment acts."""
    text = FLYWHEELS.replace("RATIO", "shaft_a.rate/20").replace("STEP", "1e-3")
    m = RecordedRun(deck(text))
    np.testing.assert_allclose(m["joints/shaft_a/rate"], 10.0, rtol=1e-9)
    m = RecordedRun(
        deck(text.replace("initial:", "loads: {push: {type: joint_moment, joint: shaft_a, value: 1}}\n    initial:"))
    )
    a, w = m["joints/shaft_a/angle"], m["joints/shaft_a/rate"]
    np.testing.assert_allclose(0.15 * w**2 + 0.1 * (w**2 / 20.0) ** 2, 17.5 + a, rtol=1e-6)
    # J_a w' + r J_b (r w)' = M with r w = w^2/20
    assert m["joints/variator/load_1"][0] == pytest.approx(0.2 / (0.3 + 0.2 * 0.5 * 1.0), rel=1e-6)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("ratio: 1, factors: [1, 1]", "'ratio' and 'factors' exclude one another"),
        ("ratio: sign(time - 1)", "a set point must not jump"),
        ("constant: 1", "'factors' must have 2 numbers"),
    ],
)
def test_errors_of_a_ratio(given, message):
    with pytest.raises(DeckError, match=message):
        deck(FLYWHEELS.replace("ratio: RATIO", given).replace("STEP", "1e-3"))


def test_a_motor_of_given_speed_lets_go_of_two_flywheels(verify):
    """The moment of the motor while the ratio is 1/2, then speeds and moment of the variator by the energy."""
    runs = [RecordedRun(input_deck("variator", f"time.step={h}")) for h in (4e-3, 2e-3)]
    driven, free = np.arange(0.2, 0.95, 0.1), np.arange(2.2, 2.95, 0.1)
    found = []
    for m in runs:
        moment = at_times(m, m["joints/motor/moment"], driven)
        found.append(np.concatenate([moment, *(at_times(m, m[f"joints/{n}"], free) for n in LATER)]))
    r, slope = _ramp(free - 1.5)
    inertia = 0.3 + 0.2 * r**2
    rate = 20.0 * np.sqrt(0.35 / inertia)
    moment = 0.35 * 20.0 * 30.0 * driven**2 * (1.0 - driven) ** 2
    known = [moment, rate, r * rate, 0.2 * slope * rate * (1.0 - 0.2 * r**2 / inertia)]
    what = "motor of given speed, variator: moments [N m], speeds [rad/s]"
    verify.second_order("Coupler", what, *found, np.concatenate(known), 2e-6, "closed form, energy")
    (released,) = runs[0].event_records
    assert released.t == pytest.approx(1.5, abs=1e-12)
    for m in runs:
        after = m.time > 1.5 + 1e-9
        np.testing.assert_array_equal(m["joints/motor/moment"][after], 0.0)
        np.testing.assert_allclose(m["energy/given"][after], 0.5 * 0.35 * 400.0, rtol=1e-4)


LATER = "shaft_a/rate", "shaft_b/rate", "variator/load_1"

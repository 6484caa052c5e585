"""Planar joint, screw, gears, rack and pinion: their decks of inputs/ against closed forms, and refused input."""

import numpy as np
import pytest
from convergence import at_times, check_second_order
from time_runs import RecordedRun, deck, input_deck

from mecano.elements import KINDS
from mecano.errors import DeckError

X, Y, Z = np.eye(3)


def close(value, expected, size=1.0):
    """A motion with constant accelerations is integrated without error: only the tolerance of Newton is left."""
    np.testing.assert_allclose(value, expected, rtol=1e-6, atol=1e-6 * size)


def test_puck_slides_and_turns_on_a_slope():
    """Constant acceleration g sin(30 deg) down the slope, pressed by m g cos(30 deg), over six turns."""
    recorded = RecordedRun(input_deck("planar_slide"))
    t, slope = recorded.time, "joints/slope"
    close(recorded[f"{slope}/displacement"][:, 0], 0.25 * 9.81 * t**2)
    close(recorded[f"{slope}/displacement"][:, 1], t)
    close(recorded[f"{slope}/velocity"][:, 0], 0.5 * 9.81 * t)
    close(recorded[f"{slope}/angle"], 20.0 * t)
    close(recorded[f"{slope}/force"], 2.0 * 9.81 * np.cos(np.pi / 6))
    close(recorded[f"{slope}/moment"], 0.0, 2.0)


def test_screw_is_driven_by_its_moment():
    """In the nut 2 N m act on J = 0.01 kg m2 and, by the pitch, on the load of 50 kg: J + m h^2, h = P/(2 pi)."""
    recorded = RecordedRun(input_deck("screw_jack"))
    t, jack, h = recorded.time, "joints/jack", 0.02 / (2.0 * np.pi)
    thrust = 50.0 * 9.81
    acceleration = (2.0 - thrust * h) / (0.01 + 50.0 * h**2)
    close(recorded[f"{jack}/angle"], 0.5 * acceleration * t**2, 10.0)
    close(recorded[f"{jack}/displacement"], 0.5 * h * acceleration * t**2, 0.1)
    close(recorded[f"{jack}/rate"], acceleration * t, 10.0)
    force = thrust + 50.0 * h * acceleration
    close(recorded[f"{jack}/force"][:, 2], force)
    close(recorded[f"{jack}/moment"][:, 2], -h * force)
    assert recorded[f"{jack}/angle"][-1] > 4.0 * np.pi


@pytest.mark.parametrize("rate, moment, ratio", [(1.0, 5.0, 1.0 / 0.4), (-1.0, -2.0, -0.5), (-1.0, 0.0, -0.5)])
def test_thread_with_an_efficiency(rate, moment, ratio):
    """Lifting takes h/0.4 times the load, lowering 0.5 h times it: the thread locks itself, the motor must turn it."""
    h, load = 0.02 / (2.0 * np.pi), 50.0
    start = f"velocity: [0, 0, {h * rate}], angular_velocity: [0, 0, {rate}]"
    recorded = RecordedRun(
        input_deck(
            "screw_jack",
            "joints.jack.friction={efficiency: 0.4, backdriving_efficiency: -0.5, regularization: 1.0e-5}",
            f"loads.motor.value={moment}",
            f"initial.velocities=[{{nodes: [spindle], {start}}}]",
            "time={end: 0.05, step: 1.0e-3}",
            "output={}",
        )
    )
    t, jack = recorded.time, "joints/jack"
    second = (moment - ratio * h * load * 9.81) / (0.01 + load * h**2 * ratio)
    moves = rate * (rate + second * t) > 0.0
    close(recorded[f"{jack}/rate"][moves], (rate + second * t)[moves], 10.0)
    thrust = load * (9.81 + h * second)  # what the load feels: force of the thread without friction, less friction
    friction, force = recorded[f"{jack}/friction_force"], recorded[f"{jack}/force"][:, 2]
    close((force - friction)[moves][1:], thrust, 1e3)
    close((h * force + recorded[f"{jack}/friction_moment"])[moves][1:], ratio * h * thrust, 10.0)
    if moment == 0.0:  # it stops, and creeps where mu phi = 2, mu = 6
        close(recorded[f"{jack}/velocity"][-1] / 1e-5, np.sqrt(1.0 - 2.0 / 6.0) - 1.0, 1.0)
        close(recorded[f"{jack}/dissipated_power"][-1] / (load * 9.81e-5), 1.0 - np.sqrt(1.0 - 2.0 / 6.0), 1.0)


LEAD, MEAN_RADIUS, LOAD, INERTIA = 0.02, 0.012, 50.0, 0.01  # m, m, kg, kg m2
THREAD = (
    f"parameters={{lead: atan({LEAD}/(2*pi*{MEAN_RADIUS})), rho: atan(FRICTION)}}",
    "joints.jack.friction={efficiency: tan($lead)/tan($lead + $rho), "
    "backdriving_efficiency: tan($lead - $rho)/tan($lead), regularization: 1.0e-5}",
    "time.end=0.2",
)


@pytest.mark.parametrize(
    ("friction", "motor", "why"),
    [
        (0.1, 3.0, "raised"),
        (0.1, 0.0, "falls"),  # by 15 degrees of the thread beside 6 of friction
        (0.4, -1.5, "driven down"),  # 22 degrees of friction: self-locking
    ],
)
def test_a_lead_screw_with_friction(verify, friction, motor, why):
    """The moment of a square thread of mean radius r is F r tan(lead +- rho), F = m (g + a) (Shigley, power screws).

    The thread falls by itself if the lead angle exceeds the friction angle; if not, the motor turns it down, too.
    """
    changes = [text.replace("FRICTION", str(friction)) for text in THREAD]
    recorded = RecordedRun(input_deck("screw_jack", *changes, f"loads.motor.value={motor}"))
    h, lead, rho = LEAD / (2 * np.pi), np.arctan(LEAD / (2 * np.pi * MEAN_RADIUS)), np.arctan(friction)
    lever = MEAN_RADIUS * np.tan(lead + rho if why == "raised" else lead - rho)  # of the load, about the axis
    acceleration = (motor - lever * LOAD * 9.81) / (INERTIA + lever * LOAD * h)
    assert (acceleration > 0.0) == (why == "raised")
    rate = recorded["joints/jack/rate"]
    found = (rate[-1] - rate[len(rate) // 2]) / (recorded.time[-1] - recorded.time[len(rate) // 2])
    what = f"screw jack that is {why}: acceleration [rad/s2]"
    verify("Gears", what, found, acceleration, "moments of a square thread", relative=1e-6)
    assert np.ptp(recorded["energy/balance"]) < 1e-3 * np.ptp(recorded["energy/given"] - recorded["energy/potential"])


def test_a_lead_screw_locks_itself():
    """With 22 degrees of friction and 15 of lead the load creeps below the regularization."""
    changes = [text.replace("FRICTION", "0.4") for text in THREAD]
    recorded = RecordedRun(input_deck("screw_jack", *changes, "loads.motor.value=0"))
    assert -1e-5 < recorded["joints/jack/velocity"][-1] < 0.0
    assert np.abs(recorded["joints/jack/displacement"]).max() < 0.2 * 1e-5


def test_screw_locks_and_rebounds():
    """At 20 mm it locks with the impulse (J + m h^2) omega/h, or comes back from a stop with half its rate."""
    h, inertia = 0.02 / (2.0 * np.pi), 0.01 + 50.0 * (0.02 / (2.0 * np.pi)) ** 2
    second = (2.0 - 50.0 * 9.81 * h) / inertia
    rate = np.sqrt(2.0 * second * 0.02 / h)
    recorded = RecordedRun(input_deck("screw_jack", "joints.jack.latch.displacement=0.02"))
    (lock,) = recorded.event_records
    close((lock.impulse, lock.lost), (-inertia * rate / h, 0.5 * inertia * rate**2))
    close(recorded["joints/jack/angle"][-1], 2.0 * np.pi, 10.0)
    recorded = RecordedRun(
        input_deck("screw_jack", "joints.jack.stops={upper: 0.02, restitution: 0.5}", "time.end=0.6")
    )
    (met,) = recorded.event_records
    assert met.name == "meets upper stop"
    back = recorded.time > met.t + 1e-9
    close(recorded["joints/jack/rate"][back], -0.5 * rate + second * (recorded.time[back] - met.t), rate)


def test_gears_share_one_inertia():
    """Rates of an inertia reduced to the driven gear; the teeth and the bearings carry what accelerates the others."""
    recorded = RecordedRun(input_deck("gears"))
    t, spur, bevel = recorded.time, "joints/spur", "joints/bevel"
    for path, second in ((f"{spur}/angle_a", 75.0), (f"{spur}/angle_b", -37.5), (f"{bevel}/angle_b", -75.0)):
        close(recorded[path], 0.5 * second * t**2, 40.0)
        close(recorded[path.replace("angle", "rate")], second * t, 75.0)
    close(recorded["joints/bearing_c/angle"], -37.5 * t**2, 40.0)
    close(recorded[f"{spur}/force"], -18.75)
    close(recorded[f"{bevel}/force"], 7.5)
    close(recorded["joints/bearing_a/force"][-1], (0.0, 18.75, 3.0 * 9.81), 20.0)  # mu_1 = x, mu_2 = y
    close(recorded["joints/bearing_a/moment"][-1], 0.0, 2.0)


CHAIN = """
    mecano: 1
    gravity: [0, 0, 0]
    nodes: {a: {position: [0, 0, 0]}, b: {position: [1, 0, 0.5]}}
    elements:
      a: {type: rigid_body, node: a, mass: 1, inertia: [0.01, 0.01, 0.01]}
      b: {type: rigid_body, node: b, mass: 1, inertia: [0.04, 0.04, 0.04]}
    joints:
      a: {type: hinge, nodes: [ground, a], axis: [0, 0, 1]}
      b: {type: hinge, nodes: [ground, b], axis: [1, 0, 0]}
      chain: {type: gear_pair, nodes: [ground, a, b], axis_a: [0, 0, 1], axis_b: [1, 0, 0], radius_a: 0.1, ratio: -2}
    loads: {motor: {type: couple, nodes: [ground, a], axis: [0, 0, 1], value: 3.0}}
    time: {end: 1.0, step: 0.01}
"""


def test_ratio_of_gears_that_do_not_touch():
    """Inertia J_a + J_b/i^2 = 0.02 kg m2 under 3 N m; the chain takes 3 - 0.01 * 150 N m off a, at 0.1 m."""
    recorded = RecordedRun(deck(CHAIN))
    t = recorded.time
    close(recorded["joints/chain/angle_a"], 75.0 * t**2, 75.0)
    close(recorded["joints/chain/angle_b"], -37.5 * t**2, 37.5)
    close(recorded["joints/chain/force"], -15.0)
    close(recorded["joints/a/force"], 0.0, 15.0)


PLANET = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      sun: {position: [0, 0, 0], fixed: true}
      arm: {position: [0, 0, 0]}
      pin: {position: [0.2, 0, 0]}
      planet: {position: [0.2, 0, 0]}
    elements:
      beam: {type: rigid_body, node: arm, mass: 1.0, inertia: [0.1, 0.1, 0.1], attached: [pin]}
      disc: {type: rigid_body, node: planet, mass: 2.0, inertia: [5.0e-3, 5.0e-3, 5.0e-3]}
    joints:
      pivot: {type: hinge, nodes: [sun, arm], axis: [0, 0, 1]}
      bearing: {type: hinge, nodes: [pin, planet], axis: [0, 0, 1]}
      mesh: {type: gear_pair, nodes: [arm, sun, planet], axis_a: [0, 0, 1], radius_a: 0.1, radius_b: 0.1}
    loads:
      motor: {type: couple, nodes: [ground, arm], axis: [0, 0, 1], value: 2.0}
    time: {end: 1.0, step: STEP}
"""


def test_planet_on_a_fixed_sun():
    """A planet as large as its sun turns twice as fast as the arm: J + m d^2 + 4 J_p = 0.1 + 0.08 + 0.02 kg m2."""
    times, pair = np.arange(1, 11) / 10, []
    for step in ("4.0e-3", "2.0e-3"):
        recorded = RecordedRun(deck(PLANET.replace("STEP", step)))
        turned = recorded["joints/pivot/angle"]
        np.testing.assert_allclose(recorded["joints/bearing/angle"], turned, rtol=0, atol=1e-9)
        np.testing.assert_allclose(recorded["joints/mesh/angle_a"], -turned, rtol=0, atol=1e-9)
        pair.append(at_times(recorded, turned, times))
    check_second_order(*pair, 5.0 * times**2, 2e-6)
    # on the sun, which the planet pushes along: its 20 rad/s2 need J_p 20/0.1 m, of the second order too
    np.testing.assert_allclose(recorded["joints/mesh/force"][-1], 1.0, rtol=0, atol=1e-3)


@pytest.mark.parametrize("nodes", ["[arm, ground, planet]", "[arm, planet, ground]"])
def test_a_gear_on_the_ground_is_centred_at_the_carrier(nodes):
    """The planet turns as on a sun of its own node, whichever of both gears it is."""
    text = PLANET.replace("[arm, sun, planet]", nodes).replace("1.0, step: STEP", "0.1, step: 4.0e-3")
    recorded = RecordedRun(deck(text))
    turned = recorded["joints/pivot/angle"]
    assert 0.03 < turned[-1] < 0.07
    np.testing.assert_allclose(recorded["joints/bearing/angle"], turned, rtol=0, atol=1e-9)


def test_pinion_pulls_a_rack():
    """2 N m on J + m r^2 = 0.035 kg m2; the hinge of the pinion feels the teeth."""
    recorded = RecordedRun(input_deck("rack"))
    t, teeth, second = recorded.time, "joints/teeth", 2.0 / 0.035
    close(recorded[f"{teeth}/angle"], 0.5 * second * t**2, 30.0)
    close(recorded[f"{teeth}/rate"], second * t, 60.0)
    close(recorded["joints/guide/displacement"], -0.025 * second * t**2)
    close(recorded[f"{teeth}/force"], 10.0 * 0.05 * second)
    close(recorded["joints/bearing/force"][-1], (-0.5 * second, -9.81, 0.0), 30.0)  # mu_1 = x, mu_2 = -z
    close(recorded["joints/guide/moment"][-1], 0.0, 2.0)


RIGID = {"backlash": 0.0, "restitution": 0.0, "teeth": None, "friction": None}
GEARS = {"axis_a": Z, "axis_b": None, "radius_a": 0.1, "radius_b": 0.2, "ratio": None, **RIGID}
REFUSED = [
    ("gear_pair", GEARS, (0 * X, 0.31 * X), "they are 0.01 m apart"),
    ("gear_pair", GEARS, (0 * X, 0.3 * X + 0.02 * Z), "they are 0.02 m apart"),
    ("gear_pair", {**GEARS, "axis_b": X}, (0 * X, 0.1 * X + 0.2 * Z + 0.05 * Y), "they are 0.05 m apart"),
    ("gear_pair", GEARS, (0 * X, Z), "must not lie on one axis"),
    ("gear_pair", {**GEARS, "ratio": -2.0}, (0 * X, 0.3 * X), "give either 'radius_b'"),
    ("gear_pair", {**GEARS, "radius_b": None}, (0 * X, 0.3 * X), "give either 'radius_b'"),
    (
        "rack_and_pinion",
        {"axis": Z, "direction": X + Z, **RIGID},
        (0 * X, X),
        "perpendicular; they are 45 degrees apart",
    ),
    (
        "planar",
        {"axis": Z, "axis_1": -Z, "turning_law": None, "natural_angle": 0.0},
        (0 * X, X),
        "'axis_1' must not be parallel to the axis",
    ),
    (
        "screw",
        {"axis": Z, "axis_1": Z, "turning_law": None, "natural_angle": 0.0},
        (0 * X, X),
        "'axis_1' must not be parallel to the axis",
    ),
]


@pytest.mark.parametrize("kind, values, places, text", REFUSED)
def test_what_does_not_fit_is_refused(kind, values, places, text):
    nodes = [(x, np.eye(3)) for x in places]
    nodes = [nodes[0], *nodes] if kind == "gear_pair" else nodes
    (found,) = KINDS[kind].check(values, nodes)
    assert text in found


@pytest.mark.parametrize("center, sign", [(0.3 * X, -1.0), (-0.3 * X, -1.0), (0.1 * X, 1.0), (-0.1 * X, 1.0)])
def test_internal_gears_turn_the_same_way(center, sign):
    """0.1 m in 0.2 m: h_a theta_a + h_b theta_b = 0 with h_a = 0.1 m, theta_b = sign theta_a/2."""
    nodes = [(0 * X, np.eye(3)), (0 * X, np.eye(3)), (center, np.eye(3))]
    assert KINDS["gear_pair"].check(GEARS, nodes) == []
    np.testing.assert_allclose(KINDS["gear_pair"].prepare(GEARS, nodes, None)["travel"], (0.1, -0.2 * sign), atol=1e-15)


def test_a_screw_needs_a_pitch():
    with pytest.raises(DeckError, match="must not be zero; without a pitch use a hinge"):
        input_deck("screw_jack", "joints.jack.pitch=0")

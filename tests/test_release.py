"""Joints that are released at a time or by a condition."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.spatial.transform import Rotation
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.dynamic import run
from mecano.analyses.prepare import prepare, warnings_of
from mecano.errors import DeckError
from mecano.results.reader import open_results

G = 9.81


@pytest.fixture(scope="module")
def recorded():
    return [RecordedRun(input_deck("release", f"time.step={h}")) for h in (4e-3, 2e-3)]


def test_a_clamp_is_released_at_a_time(verify, recorded):
    m = recorded[1]
    fall = -0.5 * G * np.maximum(m.time - 0.3, 0.0) ** 2
    height = m["nodes/weight/position"][:, 2]
    verify("Release", "clamp released at 0.3 s: height [m]", height, fall, "free fall", absolute=1e-9)
    (released,) = [h for h in m.event_records if h.element == "fixed 'clamp'"]
    assert released.t == pytest.approx(0.3, abs=1e-12)
    force = m["joints/clamp/force"]
    np.testing.assert_allclose(force[m.time < 0.3 - 1e-9, 2], 3.0 * G, rtol=1e-9)
    np.testing.assert_array_equal(force[m.time > 0.3 + 1e-9], 0.0)


def test_a_hinge_is_released_by_a_condition(verify, recorded):
    """The rate at an angle a is sqrt(3 g sin(a)/L); of a = s^2 the time to 1 rad is an integral without a pole."""
    instant, rate = (
        quad(lambda s: 2.0 * s / np.sqrt(3.0 * G * np.sin(s * s)), 0.0, 1.0)[0],
        np.sqrt(3.0 * G * np.sin(1.0)),
    )
    after = 1.0 - instant
    x = 0.5 * np.cos(1.0) - 0.5 * rate * np.sin(1.0) * after
    z = -0.5 * np.sin(1.0) - 0.5 * rate * np.cos(1.0) * after - 0.5 * G * after**2
    found = []
    for m in recorded:
        (released,) = [h for h in m.event_records if h.element == "hinge 'hinge'"]
        bar = m["elements/bar/center_of_mass"][-1]
        found.append(np.array([released.t, m["nodes/pin/angular_velocity"][-1, 1], bar[0], bar[2]]))
        np.testing.assert_array_equal(m["joints/hinge/force"][-5:], 0.0)
    what = "hinge released at 1 rad: instant, spin and place of the bar"
    verify.second_order("Release", what, *found, np.array([instant, rate, x, z]), 2e-6, "energy, parabola")


def test_energy_passes_a_release(recorded):
    drift = [np.ptp(m["energy/balance"]) for m in recorded]
    assert drift[0] / drift[1] == pytest.approx(4.0, abs=0.05) and drift[1] < 1.5e-4


@pytest.mark.parametrize(("when", "said"), [("hinge.angle < 0.5", 1), ("hinge.angle > 1", 0)])
def test_a_release_that_is_due_at_the_start_is_reported(when, said, tmp_path):
    run(input_deck("release", f"joints.hinge.release={{when: {when}}}", "time.end=0.01"), tmp_path / "r.h5")
    found = [text for text in open_results(tmp_path / "r.h5").warnings if "true at the start" in text]
    assert len(found) == said
    for text in found:
        assert "release.yaml:45:3: hinge 'hinge': the condition of its release, hinge.angle < 0.5, is true" in text


@pytest.mark.parametrize(
    ("when", "instant"),
    [
        ("time > 0.2 and hinge.angle > 1", 0.4), ("time > 0.5 and hinge.angle > 1", 0.5),
        ("hinge.angle > 1 or time > 0.3", 0.3), ("hinge.angle > 1 and time > 0.5 or time > 0.6 and time < 3", 0.5),
        ("(hinge.angle > 1 or time > 0.1) and (time > 0.2 and (hinge.rate > 2))", 0.2),
        ("((time + 0.1)*2 > (0.5 + 0.1) and time < (3)) and hinge.angle > 0", 0.2),
    ],
)  # fmt: skip
def test_conditions_are_joined(when, instant, tmp_path):
    """A drive turns the hinge by 2.5 rad/s; comparisons of different quantities give no warning of units."""
    given = deck(f"""
        mecano: 1
        gravity: none
        nodes: {{a: {{position: [0, 0, 0]}}, b: {{position: [0, 0, 0]}}}}
        elements:
          a: {{type: rigid_body, node: a, mass: 2, inertia: [1, 1, 1]}}
          b: {{type: rigid_body, node: b, mass: 2, inertia: [1, 1, 1]}}
        joints:
          hinge: {{type: hinge, nodes: [ground, a], axis: [1, 0, 0]}}
          drive: {{type: prescribed_angle, nodes: [ground, a], axis: [1, 0, 0], value: 2.5*time}}
          clamp: {{type: fixed, nodes: [a, b], release: {{when: "{when}"}}}}
        time: {{end: 0.7, step: 0.01}}
        """)
    assert not warnings_of(prepare(given))
    run(given, tmp_path / "r.h5")
    (event,) = open_results(tmp_path / "r.h5").events
    assert event.time == pytest.approx(instant, abs=1e-9)


BAD = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}}
    elements: {body: {type: rigid_body, node: a, mass: 2, inertia: [1, 1, 1]}}
    joints: {pin: {type: hinge, nodes: [ground, a], axis: [1, 0, 0], release: RELEASE}}
    time: {end: 0.1, step: 0.01}
    """


@pytest.mark.parametrize(
    ("release", "message"),
    [
        ("{}", "'release' needs either 'time' or 'when'"),
        ("{time: 1, when: pin.angle > 1}", "'release' needs either 'time' or 'when'"),
        ("{when: pin.angle}", "a condition compares two formulas by > or <, as in 'hinge.angle > 1.5'"),
        ("{when: 0 < pin.angle < 1}", "; join several by 'and' or 'or', as in 'time > 1 and hinge.angle > 0.5'"),
        ("{when: pin.angle > 1 and pin.rate}", "a condition compares two formulas by > or <"),
        ("{when: (pin.angle > 1) > 0}", "a condition compares two formulas by > or <"),
        ("{when: (pin.angle > 1 or time > 2}", "a bracket is not closed"),
        ("{when: time > 2) or (pin.angle > 1}", "a bracket is closed that was not opened"),
        ("{when: " + 60 * "(" + "time > 2" + 60 * ")" + "}", "it has too many levels of brackets"),
        ("{when: pin.angel > 1}", "'angel' of 'pin' cannot be measured"),
        ("{time: 1}, latch: {angle: 1}", "'release' and 'latch' exclude one another"),
    ],
)
def test_wrong_releases(release, message):
    with pytest.raises(DeckError) as error:
        deck(BAD.replace("RELEASE", release))
    assert message in error.value.problems[0].message


SHORT, TIP, CENTRE = (math.sqrt(0.5) * arm * np.ones(2) for arm in (2.0, -10.0, -4.0))  # x and z from the axle [m]
MASSES = np.diag([2400.0 + 200.0 * 4.0**2, 4000.0, 4000.0, 40.0, 40.0])


def turned(point, angle):
    """Return a point of the beam of the trebuchet, turned about y."""
    (x, z), c, s = point, math.cos(angle), math.sin(angle)
    return np.array([c * x + s * z, c * z - s * x])


def thrown(y, in_chute):
    """Return accelerations of the angle, the counterweight and the stone, and multipliers; the last is the chute's."""
    q, v = np.split(y, 2)
    rows, right = [], []
    for point, k in ((SHORT, 1), (TIP, 3)):
        end, slope = turned(point, q[0]), turned(point, q[0] + math.pi / 2.0)
        d, rate, row = q[k : k + 2] - end, v[k : k + 2] - v[0] * slope, np.zeros(5)
        row[0], row[k : k + 2] = -d @ slope, d
        rows.append(row)
        right.append(-rate @ rate - v[0] ** 2 * d @ end)
    if in_chute:
        rows.append(np.eye(5)[4])
        right.append(0.0)
    f = np.array([-200.0 * G * turned(CENTRE, q[0] + math.pi / 2.0)[1], 0.0, -4000.0 * G, 0.0, -40.0 * G])
    A, n = np.array(rows), len(rows)
    solved = np.linalg.solve(np.block([[MASSES, -A.T], [A, np.zeros((n, n))]]), np.append(f, right))
    return np.split(solved, [5])


def until(event, t, y, in_chute):
    """Integrate from (t, y) until the event; return its time and state."""
    event.terminal = True
    motion = solve_ivp(
        lambda t, y: np.append(y[5:], thrown(y, in_chute)[0]), (t, t + 5.0), y, "DOP853", events=event,
        rtol=1e-11, atol=1e-11,
    )  # fmt: skip
    return motion.t[-1], motion.y[:, -1]


def test_a_sling_lets_go_of_a_stone(verify):
    """A rigid rod whose release depends on the velocity of its end."""
    start = np.array([0.0, *SHORT + [0.0, -1.5], *TIP + [8.0, 0.0], 0.0, 0.0, 0.0, 0.0, 0.0])
    lifts, y = until(lambda t, y: thrown(y, True)[1][2], 0.0, start, True)
    leaves, y = until(lambda t, y: y[8] - y[9], lifts, y, False)
    flight = (20.0 - y[3]) / y[8]
    exact = np.array([lifts, leaves, leaves + flight, math.hypot(*y[8:])])
    np.testing.assert_allclose(exact, [0.471517, 1.326391, 1.946713, 66.6003], rtol=1e-6)  # those of the deck
    found = []
    for step in (2e-3, 1e-3):
        m = RecordedRun(input_deck("trebuchet", f"time.step={step}"))
        _, opens, _, let_go, ends = [h.t for h in m.event_records]
        vx, _, vz = m["nodes/stone/velocity"][-1]
        found.append(np.array([opens, let_go, ends, math.hypot(vx, vz + G * (ends - let_go))]))
        tension = m["joints/sling/tension"]
        assert tension[m.time < let_go].min() > 0.0
        np.testing.assert_array_equal(tension[m.time > let_go + 1e-9], 0.0)
    what = "trebuchet: instants at which the stone leaves chute and sling and is 20 m away; its speed"
    verify.second_order("Release", what, *found, exact, 1e-5, "SciPy, with Lagrange's multipliers")


TWO = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}, b: {position: [0, 0, 0]}}
    elements:
      first: {type: rigid_body, node: a, mass: 2, center_of_mass: [-0.5, 0.1, 0], inertia: [0.3, 0.2, 0.1]}
      second: {type: rigid_body, node: b, mass: 1, center_of_mass: [0.4, 0, 0.2], inertia: [0.05, 0.1, 0.08]}
    joints:
      joint: {JOINT, release: RELEASE}
      OTHER
    initial: {velocities: [{nodes: [a, b], velocity: [1, 2, -1], angular_velocity: [1, -2, 3], about: [0, 0, 0]}]}
    time: {end: 0.6, step: STEP}
    """
AXES = "nodes: [a, b], axis: [0, 0, 1]"
JOINTS = {
    "spherical": "type: spherical, nodes: [a, b]",
    "universal": "type: universal, nodes: [a, b], axis_a: [1, 0, 0], axis_b: [0, 1, 0]",
    "planar": f"type: planar, {AXES}",
    "screw": f"type: screw, {AXES}, pitch: 0.1",
    "generic": f"type: generic, {AXES}, free: [about_1]",
    "driven": f"type: generic, {AXES}, driven: {{along_1: time**2}}, driven_rates: {{along_2: time/2, about_axis: 2}}",
}
DRIVES = {
    "position": "type: prescribed_position, node: b, direction: [1, 0, 0], value: time + time**2",
    "angle": f"type: prescribed_angle, {AXES}, value: time**2",
    "rate": f"type: prescribed_angle, {AXES}, rate: 2*sin(time)",
    "law": f"type: prescribed_angle, {AXES}, rate: 3",
}


def two_bodies(joint, release, step, other=""):
    text = TWO.replace("JOINT", joint).replace("RELEASE", release).replace("STEP", str(step)).replace("OTHER", other)
    return RecordedRun(deck(text))


def momenta(m):
    """Return the momentum and the moment of momentum about the origin (n, 6) of both bodies."""
    total = np.zeros((len(m.time), 6))
    for body, node, mass, J in (("first", "a", 2.0, [0.3, 0.2, 0.1]), ("second", "b", 1.0, [0.05, 0.1, 0.08])):
        x, v = m[f"elements/{body}/center_of_mass"], m[f"nodes/{node}/velocity"]
        w, R = m[f"nodes/{node}/angular_velocity"], Rotation.from_quat(m[f"nodes/{node}/rotation"][:, [1, 2, 3, 0]])
        R = R.as_matrix()
        p = mass * (v + np.cross(w, x - m[f"nodes/{node}/position"]))
        spin = np.einsum("nij,j,nkj,nk->ni", R, np.array(J), R, w)
        total += np.hstack([p, np.cross(x, p) + spin])
    return total


@pytest.mark.parametrize("name", JOINTS)
def test_a_released_joint_keeps_momentum_and_energy(name):
    """Also the work of drives until then; the bodies are free afterwards, and the reactions zero."""
    errors = []
    for step in (2e-3, 1e-3):
        m = two_bodies(JOINTS[name], "{time: 0.3}", step)
        (released,) = m.event_records
        assert released.t == pytest.approx(0.3, abs=1e-12) and released.name == "releases"
        after, total = m.time > 0.3 + 1e-9, momenta(m)
        for reaction in ("force", "moment")[: 1 if name == "spherical" else 2]:
            assert np.abs(m[f"joints/joint/{reaction}"][~after]).max() > 0.05
            np.testing.assert_array_equal(m[f"joints/joint/{reaction}"][after], 0.0)
        body = m["elements/second/center_of_mass"][after]
        np.testing.assert_allclose(np.diff(body, 2, axis=0), 0.0, rtol=0.0, atol=1e-9)
        given, kinetic = m["energy/given"], m["energy/kinetic"]
        np.testing.assert_array_equal(given[after], given[-1])
        assert (abs(given[-1]) > 0.1) == (name == "driven")
        errors.append([np.abs(total - total[0]).max(), np.abs(kinetic - given - kinetic[0]).max()])
    coarse, fine = np.array(errors)
    assert np.all(fine < 1e-4) and np.all((coarse > 3.0 * fine) | (fine < 1e-9))


@pytest.mark.parametrize("name", DRIVES)
def test_a_released_drive_lets_go(name):
    """It gives no power afterwards; a hinge keeps the bodies together."""
    m = two_bodies(
        DRIVES[name], "{when: time > 0.3}", 1e-3, "" if name == "position" else f"pin: {{type: hinge, {AXES}}}"
    )
    (released,) = m.event_records
    after, given = m.time > 0.3 + 1e-9, m["energy/given"]
    load = m["joints/joint/force" if name == "position" else "joints/joint/moment"]
    assert released.t == pytest.approx(0.3, abs=1e-9) and np.abs(load[~after]).max() > 0.05
    np.testing.assert_array_equal(load[after], 0.0)
    np.testing.assert_array_equal(given[after], given[-1])
    np.testing.assert_allclose(m["energy/kinetic"] - given, m["energy/kinetic"][0], rtol=0.0, atol=2e-4)
    if name != "position":
        np.testing.assert_allclose(m["joints/joint/angle"], m["joints/pin/angle"], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("joint", "other"),
    [
        (f"type: screw, {AXES}, pitch: 1, turning_law: {{spring: 1}}", "turning_law"),
        (f"type: generic, {AXES}, compliance: {{about_1: {{spring: 1}}}}", "compliance"),
        ("type: spherical, nodes: [a, b], friction: {coefficient: 0.1, regularization: 0.1, radius: 0.1}", "friction"),
    ],
)
def test_options_that_would_remain_are_refused(joint, other):
    with pytest.raises(DeckError, match=f"'release' and '{other}' exclude one another"):
        two_bodies(joint, "{time: 1}", 1e-3)


def test_a_ball_joint_is_a_fuse():
    """A pendulum that breaks off when its own force exceeds 2 m g: at sin(a) = 2/3 below the horizontal."""
    text = """
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {weight: {position: [1, 0, 0]}, eye: {position: [0, 0, 0]}}
        elements:
          bar: {type: rigid_body, node: weight, mass: 1, inertia: [1e-9, 1e-9, 1e-9], attached: [eye]}
        joints: {ball: {type: spherical, nodes: [ground, eye],
          release: {when: "ball.force.x**2 + ball.force.z**2 > (2*9.81)**2"}}}
        time: {end: 1, step: 1e-3}
    """
    m = RecordedRun(deck(text))
    (released,) = m.event_records
    at = np.searchsorted(m.time, released.t - 1e-12)
    x, _, z = m["nodes/weight/position"][at]
    assert math.asin(-z) == pytest.approx(math.asin(2.0 / 3.0), abs=1e-4) and math.hypot(x, z) == pytest.approx(1.0)
    np.testing.assert_array_equal(m["joints/ball/force"][m.time > released.t + 1e-9], 0.0)

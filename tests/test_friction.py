"""Friction in joints, driven by their reactions: a braked pendulum, a strut that binds, spinning bodies and shafts."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.prepare import prepare, startup_warnings
from mecano.elements import KINDS
from mecano.errors import ConvergenceError, DeckError

g = 9.81


def drag(mu, eps, v):
    """Friction over normal force: mu phi(|v|) sign v (Oden & Martins 1985)."""
    u = min(abs(v) / eps, 1.0)
    return mu * u * (2.0 - u) * math.copysign(1.0, v)


def pendulum(times, mu=0.4, r=0.04, eps=2e-3, start=1.2, m=1.0, L=0.5, J=0.01):
    """Angle from the vertical at the times, of the one equation with the force in the pin, integrated to 1e-11."""

    def rate(t, y):
        theta, omega = y
        c, turning = r * drag(mu, eps, r * omega), 0.0
        for _ in range(60):  # the force in the pin depends on the angular acceleration
            across, along = m * (L * turning + g * math.sin(theta)), m * (L * omega**2 + g * math.cos(theta))
            found = -(m * g * L * math.sin(theta) + c * math.hypot(across, along)) / (m * L**2 + J)
            if abs(found - turning) < 1e-15 * abs(found):
                break
            turning = found
        return omega, turning

    found = solve_ivp(
        rate, (0.0, times[-1]), [start, 0.0], method="DOP853", rtol=1e-11, atol=1e-12, t_eval=times, max_step=2e-3
    )
    return found.y[0]


def test_pendulum_braked_by_its_pin():
    """The angle is that of the one equation, with errors of the second order in the step."""
    errors, drifts = [], []
    for step in (2e-3, 1e-3):
        recorded = RecordedRun(input_deck("friction_pendulum", f"time.step={step}", "time.end=1.5"))
        exact = pendulum(recorded.time)
        errors.append(np.abs(1.2 - recorded["joints/hinge/angle"] - exact).max())
        drifts.append(np.ptp(recorded["energy/balance"]))
    assert errors[1] < 1e-5 and drifts[1] < 1e-5  # [rad], [J] of 1
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.2)
    assert drifts[0] / drifts[1] == pytest.approx(4.0, rel=0.01)


def test_small_swings_lose_a_constant_amplitude_and_end():
    """Rigid bob, N = m g: each half swing is smaller by 2 mu r m g/(m g L); then it sticks within half of that."""
    recorded = RecordedRun(input_deck("friction_pendulum", "nodes.pin.orientation=[0, -0.2, 0]", "time.end=5"))
    angle = 0.2 - recorded["joints/hinge/angle"]
    turns = np.abs(angle[np.r_[0, np.flatnonzero(np.diff(np.sign(recorded["joints/hinge/rate"][1:]))) + 1]])
    np.testing.assert_allclose(-np.diff(turns[:3]), 2 * 0.4 * 0.04 / 0.5, rtol=0.02)
    assert abs(angle[-1]) < 0.4 * 0.04 / 0.5 and abs(recorded["joints/hinge/rate"][-1]) < 2e-3 / 0.04


def test_strut_binds_beyond_the_threshold():
    """mu < b/(2 a) slides with P/m (1 - 2 mu a/b); mu > b/(2 a) creeps at eps (1 - sqrt(1 - b/(2 mu a)))."""
    recorded = RecordedRun(input_deck("binding_strut"))
    np.testing.assert_allclose(recorded["joints/rail_1/normal_force"], 6000.0, rtol=1e-9)
    acceleration = np.diff(recorded["joints/rail_1/velocity"]) / np.diff(recorded.time)
    np.testing.assert_allclose(acceleration[100:], 100.0 * (1 - 2 * 0.15 * 3), rtol=1e-7)
    creep = 1e-3 * (1 - math.sqrt(1 - 1 / (6 * 0.18)))
    assert recorded["joints/rail_2/velocity"][-1] == pytest.approx(creep, rel=1e-9)
    assert recorded["joints/rail_2/friction_force"][-1] == pytest.approx(1000.0, rel=1e-9)


def test_errors_of_a_start_of_sliding():
    """m a = P - 6 P drag(v): fixed steps lose up to half a step of friction; adaptive ones about 6 tolerances."""
    rate = lambda t, y: (y[1], 100.0 * (1.0 - 6.0 * drag(0.15, 1e-3, y[1])))  # noqa: E731
    path, speed = solve_ivp(rate, (0.0, 0.2), [0.0, 0.0], "LSODA", rtol=1e-10, atol=1e-13, max_step=1e-4).y[:, -1]
    for step in (2e-3, 1e-3):
        recorded = RecordedRun(input_deck("binding_strut", f"time.step={step}"))
        assert 0.4 < (recorded["joints/rail_1/velocity"][-1] - speed) / (step * 90.0) < 0.5
    for tolerance in (1e-3, 1e-4):  # relative to the diagonal of the box around the nodes
        recorded = RecordedRun(
            input_deck("binding_strut", f"time.adaptive={{tolerance: {tolerance}}}", "time.step=1e-3")
        )
        assert abs(recorded["joints/rail_1/displacement"][-1] - path) < 7.0 * tolerance * math.hypot(1.0, 0.3)


@pytest.mark.parametrize(("mu", "slides"), [(0.166, True), (0.1675, False)])
@pytest.mark.parametrize("kind", ["prismatic", "cylindrical"])
def test_threshold_is_sharp_in_both_guides(kind, mu, slides):
    """b/(2 a) = 0.16667; a cylindrical guide binds alike."""
    rails = [f"joints.rail_{i}.{key}" for i in (1, 2) for key in (f"type={kind}", f"friction.coefficient={mu}")]
    recorded = RecordedRun(input_deck("binding_strut", *rails, "time.end=0.1"))
    assert bool(recorded["joints/rail_2/velocity"][-1] > 2e-3) is slides


BRAKED = """
    mecano: 1
    gravity: [0, 0, 0]
    nodes: {{slider: {{position: [0, 0, 0]}}}}
    elements:
      body: {{type: rigid_body, node: slider, mass: 10, inertia: [0.1, 0.1, 0.1], center_of_mass: [0.3, 0, 0]}}
    joints:
      rail:
        type: prismatic
        nodes: [ground, slider]
        axis: [0, 0, 1]
        friction: {{coefficient: {mu}, regularization: 1.0e-3, length: 0.1}}
    loads: {{brake: {{type: force, node: slider, direction: [0, 0, 1], value: -100}}}}
    initial: {{velocities: [{{nodes: [slider], velocity: [0, 0, 1]}}]}}
    time: {{end: 3.0e-3, step: 1.0e-3}}
"""


@pytest.mark.parametrize("mu", [0.1, 0.15, 0.16])
def test_a_guide_that_inertia_presses(mu):
    """A mass at the arm a: m s'' = P - 2 mu m |s''| a/b, so s'' = (P/m)/(1 - 2 mu a/b), from the first instant on."""
    recorded = RecordedRun(deck(BRAKED.format(mu=mu)))
    exact = -10.0 / (1 - 2 * mu * 0.3 / 0.1)
    np.testing.assert_allclose(np.diff(recorded["joints/rail/velocity"]) / 1e-3, exact, rtol=1e-7)
    np.testing.assert_allclose(recorded["joints/rail/normal_force"], -2 * 10 * exact * 0.3 / 0.1, rtol=1e-6)


@pytest.mark.parametrize("how", ["", ", adaptive: {tolerance: 1.0e-4, length_scale: 1}", ", method: radau"])
def test_a_guide_that_no_acceleration_satisfies_is_reported(how):
    """Beyond mu = b/(2 a) that equation has no solution: the run ends, and says that the guide binds."""
    text = BRAKED.format(mu=0.18).replace("step: 1.0e-3", f"step: 1.0e-3{how}")
    with pytest.raises(ConvergenceError, match="prismatic 'rail' binds: its friction grows faster"):
        RecordedRun(deck(text))


def test_a_guide_with_several_accelerations_is_reported():
    """Its friction jumped from one solution to another, in some hundred thousand steps of 1e-7 s."""
    text = """
    mecano: 1
    gravity: none
    nodes:
      body: {position: [0.1088, 1.1997, -0.3723], orientation: [2.2618, -0.4679, 0.1225]}
      slider: {position: [0.3019, 0.9454, -0.2998]}
    elements:
      body: {type: rigid_body, node: body, mass: 1.522, inertia: [0.21, 0.23, 0.26], attached: [slider]}
    joints:
      rail:
        type: prismatic
        nodes: [ground, slider]
        axis: [-0.1913, 0.4394, -0.8777]
        sliding_law: {spring: 315, damper: 0.165}
        friction: {coefficient: 0.361, regularization: 0.0014, length: 0.13}
    initial: {velocities: [{nodes: all, velocity: [-0.27, 0.51, -0.98]}]}
    time: {end: 0.6, step: 0.002}
    """
    with pytest.raises(ConvergenceError, match="prismatic 'rail' binds"):
        RecordedRun(deck(text))


SPIN = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {{body: {{position: [0, 0, 0]}}}}
    elements:
      body: {{type: rigid_body, node: body, mass: 2.0, inertia: [0.3, 0.3, 0.3], center_of_mass: {center}}}
    joints:
      joint: {{type: {kind}, nodes: [ground, body], {axes} friction: {{coefficient: 0.25, regularization: 1.0e-4, {geometry}}}}}
    initial: {{velocities: [{{nodes: [body], angular_velocity: {spin}}}]}}
    time: {{end: 0.1, step: 5.0e-3}}
"""  # noqa: E501
WEIGHT = 2.0 * g
ENDS = abs(WEIGHT / 2 + 0.3 * WEIGHT / 0.4) + abs(WEIGHT / 2 - 0.3 * WEIGHT / 0.4)
SPINNING = {
    "radial": ("hinge", "axis: [0, 1, 0],", "radius: 0.05", [0, 0, 0], [0, 9, 0], 0.05 * WEIGHT),
    "couple": ("hinge", "axis: [0, 1, 0],", "radius: 0.05, length: 0.4", [0, 0.3, 0], [0, 9, 0], 0.05 * ENDS),
    "collar": ("hinge", "axis: [0, 0, 1],", "radius: 0.05, collar_radius: 0.2", [0, 0, 0], [0, 0, 9], 0.2 * WEIGHT),
    "ball": ("spherical", "", "radius: 0.05", [0, 0, 0], [1, -4, 8], 0.05 * WEIGHT),
    "pin of a": (
        "universal", "axis_a: [1, 0, 0], axis_b: [0, 1, 0],", "radius_a: 0.05, radius_b: 0.07", [0, 0, 0], [9, 0, 0],
        0.05 * WEIGHT,
    ),
    "pin of b": (
        "universal", "axis_a: [1, 0, 0], axis_b: [0, 1, 0],", "radius_a: 0.05, radius_b: 0.07", [0, 0, 0], [0, -9, 0],
        0.07 * WEIGHT,
    ),
    "around a guide": ("cylindrical", "axis: [0, 1, 0],", "radius: 0.05", [0, 0, 0], [0, 9, 0], 0.05 * WEIGHT),
}  # fmt: skip


@pytest.mark.parametrize("case", SPINNING)
def test_a_spinning_body_is_braked_evenly(case):
    """J omega' = -mu (r N): constant, so that the rate falls linearly; N of both ends of a bearing by hand."""
    kind, axes, geometry, center, spin, arm = SPINNING[case]
    recorded = RecordedRun(deck(SPIN.format(kind=kind, axes=axes, geometry=geometry, center=center, spin=spin)))
    rate = np.linalg.norm(recorded["nodes/body/angular_velocity"], axis=1)
    np.testing.assert_allclose(rate, np.linalg.norm(spin) - 0.25 * arm / 0.3 * recorded.time, rtol=1e-6)
    powers = [recorded[path] for path in recorded.columns if "dissipated_power" in path]
    np.testing.assert_allclose(sum(powers), 0.25 * arm * rate, rtol=1e-6)
    assert np.ptp(recorded["energy/balance"]) < 1e-6 * recorded["energy/kinetic"][0]


def test_a_turning_shaft_slides_easily():
    """Friction acts against the sliding of the surfaces, (s', r theta'): two equations, integrated to 1e-11."""
    text = SPIN.format(
        kind="cylindrical", axes="axis: [0, 1, 0],", geometry="radius: 0.05", center=[0, 0, 0], spin=[0, 20, 0]
    )
    text += "    loads: {push: {type: force, node: body, direction: [0, 1, 0], value: 2.0}}\n"
    recorded = RecordedRun(deck(text.replace("1.0e-4", "1.0e-2").replace("5.0e-3", "5.0e-4")))

    def rate(t, y):
        slide, turn = y[2], y[3]
        u = math.hypot(slide, 0.05 * turn)
        c = WEIGHT * drag(0.25, 1e-2, u) / u
        return slide, turn, (2.0 - c * slide) / 2.0, -c * 0.05**2 * turn / 0.3

    found = solve_ivp(rate, (0.0, 0.1), [0, 0, 0, 20.0], method="DOP853", rtol=1e-11, atol=1e-13, t_eval=recorded.time)
    assert found.y[0, -1] > 1e-3  # the push alone is less than the friction of a shaft at rest, 4.9 N
    np.testing.assert_allclose(recorded["joints/joint/displacement"], found.y[0], rtol=0, atol=1e-6 * found.y[0, -1])
    np.testing.assert_allclose(recorded["joints/joint/rate"], found.y[3], rtol=1e-7)


def test_friction_on_redundant_reactions_is_reported():
    """Two hinges on one axis share their loads in a way that the rigid model does not determine."""
    text = SPIN.format(kind="hinge", axes="axis: [0, 1, 0],", geometry="radius: 0.05", center=[0, 0, 0], spin=[0, 9, 0])
    for old, new in (
        ("0, 0]}}", "0, 0]}, end: {position: [0, 1, 0]}}"),
        ("center_of_mass", "attached: [end], center_of_mass"),
        ("joints:\n", "joints:\n      other: {type: hinge, nodes: [ground, end], axis: [0, 1, 0]}\n"),
    ):
        assert old in text
        text = text.replace(old, new, 1)
    said = startup_warnings(prepare(deck(text)))
    assert any("hinge 'joint'" in line and "friction" in line and "not unique" in line for line in said)
    assert not any("the friction" in line for line in startup_warnings(prepare(input_deck("friction_pendulum"))))


SEATED = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {sleeve: {position: [0, 0, 0]}, shaft: {position: [0, 0, 0]}}
    elements: {bar: {type: rigid_body, node: shaft, mass: 2, inertia: [0.1, 0.1, 0.1], center_of_mass: [0.3, 0, 0]}}
    joints:
      seat: {type: fixed, nodes: [ground, sleeve], axis: [0, 1, 0], compliance: {along_1: LAW, along_2: LAW}}
      pin: {type: hinge, nodes: [sleeve, shaft], axis: [0, 1, 0],
            friction: {coefficient: 0.2, regularization: 1.0e-4, radius: 0.02}}
    time: {end: 0.2, step: 2.0e-3}
"""


def test_friction_in_an_elastic_seat():
    """The force of the seat, k s + c ds/dt, is that of the bearing: M = mu r of it once the pin slides."""
    k, c = 1e5, 100.0
    recorded = RecordedRun(deck(SEATED.replace("LAW", f"{{spring: {{stiffness: {k}}}, damper: {{coefficient: {c}}}}}")))
    s, rate = recorded["nodes/sleeve/position"], recorded["nodes/sleeve/velocity"]
    force = np.linalg.norm(k * s + c * rate, axis=1)
    slides = recorded["joints/pin/rate"] * 0.02 > 1e-4
    assert slides[1:].all() and np.linalg.norm(s, axis=1).max() > 1e-4
    np.testing.assert_allclose(recorded["joints/pin/normal_force"], force, rtol=1e-6)
    np.testing.assert_allclose(recorded["joints/pin/friction_moment"][slides], 0.2 * 0.02 * force[slides], rtol=1e-6)


REFUSED = [
    ("hinge", {"radius": 0.1, "collar_radius": 0.0, "length": None}, {}, "'friction.coefficient' must not be negative"),
    ("hinge", {"coefficient": 0.1}, {"compliance": {"along_1": 1}}, "cannot be combined with 'compliance'"),
    ("prismatic", {"coefficient": 0.1}, {"compliance": {"along_1": 1}}, "cannot be combined with 'compliance'"),
]


def test_friction_must_not_be_negative_at_any_speed():
    falling = "joints.hinge.friction.coefficient={table: {points: [[0, 0.4], [1, -0.2]]}}"
    with pytest.raises(DeckError, match=r"'friction.coefficient' must not be negative; it is -0.2 at 1"):
        input_deck("friction_pendulum", falling)


@pytest.mark.parametrize(("kind", "friction", "more", "text"), REFUSED)
def test_errors_in_friction(kind, friction, more, text):
    nodes = [(np.zeros(3), np.eye(3))] * 2
    defaults = {field.name: field.default for field in KINDS[kind].fields if not field.required}
    values = {**defaults, "axis": [0, 0, 1], "friction": {"coefficient": -0.1, **friction}, **more}
    (found,) = KINDS[kind].check(values, nodes)
    assert text in found


JENKINS = """
    mecano: 1
    gravity: none
    nodes: {m: {position: [0, 0, 0]}, slider: {position: [1, 0, 0]}}
    elements:
      m: {type: point_mass, node: m, mass: 1}
      spring: {type: spring_damper, nodes: [m, slider], law: {spring: {stiffness: 1000}}}
    joints:
      track: {type: prismatic, nodes: [ground, m], axis: [1, 0, 0]}
      pad:
        {type: prismatic, nodes: [ground, slider], axis: [1, 0, 0],
         sliding_law: {dry_friction: {force: 10, regularization: 1 mm/s}}}
    initial: {velocities: [{nodes: [m], velocity: [1, 0, 0]}]}
    time: {end: 0.3, step: STEP}
"""


@pytest.mark.parametrize(
    ("step", "tolerance"),
    [("1 ms, adaptive: {tolerance: 1.0e-3}", 1e-4), ("1 ms, adaptive: {tolerance: 1.0e-4}", 1e-5), ("1 ms", 5e-5)],
)
def test_a_node_without_mass_slips_and_sticks_between_a_spring_and_friction(step, tolerance):
    """It slips from F/k = 10 mm until the mass has lost its energy, 1 m2/s2 - 1000 (10 mm)^2 = 2 10 N 45 mm/kg.

    The creep below the regularization adds 1e-5 m at the most.
    """
    recorded = RecordedRun(deck(JENKINS.replace("STEP", step)))
    farthest = recorded["nodes/m/position"][:, 0].max()
    assert farthest == pytest.approx(0.055, abs=tolerance + 1e-5)
    assert recorded["nodes/slider/position"][-1, 0] == pytest.approx(1.045, abs=tolerance + 1e-5)

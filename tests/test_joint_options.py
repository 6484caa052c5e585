"""Bushings, laws and compliance in joints: closed forms, and joints modelled in two equivalent ways."""

import math

import numpy as np
import pytest
from scipy.linalg import expm
from time_runs import RecordedRun, deck, input_deck

from mecano.elements import KINDS

g = 9.81


def test_bushing_moves_as_a_linear_system_at_large_angles():
    """y(t) = exp(A t) y(0) for sliding and turning about one axis; errors of the second order."""
    mass, S, D = np.diag([5.0, 0.2]), np.array([[800.0, 60.0], [60.0, 20.0]]), np.diag([6.0, 0.15])
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(mass, S), -np.linalg.solve(mass, D)]])
    errors = []
    for step in (2e-3, 1e-3):
        recorded = RecordedRun(input_deck("bushing", f"time.step={step}", "time.end=0.6"))
        exact = np.array([expm(A * t) @ [0.0, 0.0, 2.0, 20.0] for t in recorded.time])
        found = np.stack(
            [recorded["elements/mount/displacement"][:, 0], recorded["elements/mount/rotation_vector"][:, 2]], axis=1
        )
        assert np.abs(exact[:, 1]).max() > 1.5
        errors.append(np.abs(found - exact[:, :2]).max())
    assert errors[1] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.01)


BODY = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      arm: {{position: [0, 0, 0]}}
      body: {{position: {place}}}
    elements:
      arm: {{type: rigid_body, node: arm, mass: 1.5, inertia: [0.02, 0.03, 0.04], center_of_mass: [0.1, 0.2, 0.05]}}
      body: {{type: rigid_body, node: body, mass: 2.0, inertia: [0.05, 0.06, 0.07], center_of_mass: [0.1, -0.2, 0.3]}}
      {more}
    joints:
      root: {{type: hinge, nodes: [ground, arm], axis: [0.2, 1, 0.3]}}
      joint: {{type: {kind}, nodes: [arm, body] {options}}}
    initial: {{velocities: [{{nodes: all, angular_velocity: [0, 2, 0.5], about: [0, 0, 0]}}]}}
    time: {{end: 0.3, step: 2.0e-3, newton: {{force_tolerance: 1.0e-12, constraint_tolerance: 1.0e-13}}}}
"""


def two_bodies(kind, options, place=(0, 0, 0), more=""):
    """Run two bodies, one joined to the ground by a hinge, and to the other by the joint."""
    return RecordedRun(deck(BODY.format(kind=kind, options=options, place=list(place), more=more)))


HERE, THERE = (0, 0, 0), (0.3, 0.1, -0.2)
RUBBING = {
    "hinge": (", axis: [1, 0.2, 0]", HERE, "radius: 0.1"),
    "spherical": ("", HERE, "radius: 0.1"),
    "universal": (", axis_a: [1, 0, 0], axis_b: [0, 0, 1]", HERE, "radius_a: 0.1, radius_b: 0.1"),
    "prismatic": (", axis: [1, 0.2, 0]", THERE, ""),
    "cylindrical": (", axis: [1, 0.2, 0]", THERE, ""),
}
ELASTIC = {**{kind: RUBBING[kind][:2] for kind in RUBBING if kind != "spherical"}, "fixed": ("", HERE)}
SAME = [
    (kind, axes, place, f", friction: {{coefficient: 0.0, regularization: 0.1, {more}}}")
    for kind, (axes, place, more) in RUBBING.items()
]
SAME += [(kind, axes, place, ", compliance: {}") for kind, (axes, place) in ELASTIC.items()]


@pytest.mark.parametrize(("kind", "axes", "place", "option"), SAME, ids=[f"{s[0]}{s[3][:6]}" for s in SAME])
def test_a_joint_that_is_held_by_multipliers_is_the_joint(kind, axes, place, option):
    """With no friction, or compliance along no axis: motion, reactions and energies are those of the plain joint."""
    plain, held = two_bodies(kind, axes, place), two_bodies(kind, axes + option, place)
    assert held.system.n_l >= plain.system.n_l
    compared = 0
    for path in plain.columns:
        size = np.abs(plain[path]).max()
        np.testing.assert_allclose(held[path], plain[path], rtol=0, atol=1e-6 * max(size, 1e-3), err_msg=path)
        compared += path.startswith("joints/joint/")
    assert compared == len(KINDS[kind].outputs)
    assert np.abs(plain["joints/joint/force"]).max() > 1.0


SPRING = "{spring: {stiffness: 7.0}, damper: {coefficient: 0.3}}"
TORSION = "type: torsion_spring_damper, nodes: [arm, body], axis: [1, 0.2, 0]"
SAME_LAW = [
    (
        "hinge", HERE, f", axis: [1, 0.2, 0], turning_law: {SPRING}, natural_angle: 0.4", ", axis: [1, 0.2, 0]",
        f"law: {{{TORSION}, natural_angle: 0.4, law: {SPRING}}}",
    ),
    (
        "cylindrical", THERE, f", axis: [1, 0.2, 0], turning_law: {SPRING}", ", axis: [1, 0.2, 0]",
        f"law: {{{TORSION}, law: {SPRING}}}",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "place", "option", "plain", "element"), SAME_LAW)
def test_a_law_in_a_joint_is_the_spring_beside_it(kind, place, option, plain, element):
    """The same motion as with a torsion_spring_damper, and its moment."""
    one, two = two_bodies(kind, option, place), two_bodies(kind, plain, place, element)
    for name in ("body", "arm"):
        path = f"nodes/{name}/rotation"
        np.testing.assert_allclose(one[path], two[path], rtol=0, atol=1e-10)
    np.testing.assert_allclose(one["joints/joint/law_moment"], two["elements/law/moment"], rtol=0, atol=1e-8)
    np.testing.assert_allclose(one["energy/total"], two["energy/total"], rtol=1e-10)


SINGLE = """
    mecano: 1
    gravity: [0, 0, {gravity}]
    nodes: {{body: {{position: [0, 0, 0]}}}}
    elements:
      body: {{type: rigid_body, node: body, mass: 2.0, inertia: [0.05, 0.05, 0.05], center_of_mass: {center}}}
    joints: {{joint: {{type: {kind}, nodes: [ground, body], {options}}}}}
    initial: {{velocities: [{{nodes: [body], velocity: {velocity}, angular_velocity: {spin}}}]}}
    time: {{end: {end}, step: {step}}}
"""


def single(kind, options, gravity=0.0, center=(0, 0, 0), velocity=(0, 0, 0), spin=(0, 0, 0), end=0.5, step=1e-3):
    """Run one body joined to the ground."""
    vectors = {"center": list(center), "velocity": list(velocity), "spin": list(spin)}
    return RecordedRun(deck(SINGLE.format(kind=kind, options=options, gravity=gravity, end=end, step=step, **vectors)))


OSCILLATING = [
    ("prismatic", "axis: [0, 1, 0], sliding_law: {spring: {stiffness: 200}}", "displacement", 2.0),
    ("cylindrical", "axis: [0, 1, 0], sliding_law: {spring: {stiffness: 200}}", "displacement", 2.0),
    ("hinge", "axis: [0, 1, 0], turning_law: {spring: {stiffness: 5}}", "angle", 0.05),
    ("universal", "axis_a: [0, 1, 0], axis_b: [1, 0, 0], turning_law_a: {spring: {stiffness: 5}}", "angle_a", 0.05),
    ("universal", "axis_a: [1, 0, 0], axis_b: [0, 1, 0], turning_law_b: {spring: {stiffness: 5}}", "angle_b", 0.05),
]


@pytest.mark.parametrize(("kind", "options", "name", "inertia"), OSCILLATING)
def test_a_law_along_a_free_axis_makes_an_oscillator(kind, options, name, inertia):
    """v0/w sin(w t), w = 10 rad/s: amplitudes over a whole turn for those that turn."""
    speed = 80.0 if name.startswith("angle") else 0.3
    motion = {"spin": (0, speed, 0)} if name.startswith("angle") else {"velocity": (0, speed, 0)}
    recorded = single(kind, options, **motion)
    w = 10.0
    np.testing.assert_allclose(
        recorded[f"joints/joint/{name}"], speed / w * np.sin(w * recorded.time), rtol=0, atol=1e-3 * speed / w
    )
    law = next(recorded[path] for path in recorded.columns if "/law_" in path)
    np.testing.assert_allclose(law, inertia * w * w * recorded[f"joints/joint/{name}"], rtol=1e-12, atol=1e-9)
    assert np.ptp(recorded["energy/total"]) < 1e-3 * recorded["energy/total"][0]


def test_free_play_and_stops_are_met_at_their_times():
    """A slider flies at 2 m/s through a free play of 0.1 m, is thrown back in half a period, and flies on."""
    law = "{dead_band: {stiffness: 2.0e4, lower: -0.1, upper: 0.1}}"
    recorded = single("prismatic", f"axis: [0, 1, 0], sliding_law: {law}", velocity=(0, 2, 0), end=0.22)
    times = [event.t for event in recorded.event_records]
    assert [event.name for event in recorded.event_records] == [
        "upper stop closes", "upper stop opens", "lower stop closes", "lower stop opens",
    ]  # fmt: skip
    assert all(event.element == "prismatic 'joint'" for event in recorded.event_records)
    half = math.pi / 100
    np.testing.assert_allclose(times[:3], [0.05, 0.05 + half, 0.15 + half], rtol=0, atol=5e-5)
    assert times[0] == pytest.approx(0.05, abs=1e-10)


LOADED = "{{spring: {{stiffness: {}}}, damper: {{coefficient: {}}}}}"
STATIC = {  # kind: options, what is left free
    "fixed": ("axis: [0, 0, 1]", ("along_1", "along_2", "along_axis", "about_1", "about_2", "about_axis")),
    "hinge": ("axis: [1, 0, 0]", ("along_1", "along_2", "along_axis", "about_1", "about_2")),
    "prismatic": ("axis: [0, 1, 0]", ("along_1", "along_2", "about_1", "about_2", "about_axis")),
    "cylindrical": ("axis: [1, 0, 0]", ("along_1", "along_2", "about_1", "about_2")),
}


@pytest.mark.parametrize("kind", STATIC)
def test_an_elastic_joint_gives_way_under_a_weight(kind):
    """At rest after some damped oscillations: sag m g/k, tilt M/c about y, the reactions of the rigid joint."""
    options, axes = STATIC[kind]
    soft = LOADED.format(4000.0, 60.0), LOADED.format(500.0, 2.0)
    laws = ", ".join(f"{axis}: {soft[axis.startswith('about')]}" for axis in axes)
    recorded = single(kind, f"{options}, compliance: {{{laws}}}", gravity=-g, center=(0.1, 0, 0), end=3.0, step=5e-3)
    weight = 2.0 * g
    assert recorded.system.n_l == 0
    assert recorded["nodes/body/position"][-1, 2] == pytest.approx(-weight / 4000.0, rel=1e-8)
    assert np.linalg.norm(recorded["joints/joint/force"][-1]) == pytest.approx(weight, rel=1e-8)
    tilt = 2.0 * abs(recorded["nodes/body/rotation"][-1, 2])
    assert np.linalg.norm(recorded["joints/joint/moment"][-1]) == pytest.approx(0.1 * weight, rel=5e-5)
    assert tilt == pytest.approx(0.1 * weight / 500.0, rel=5e-5)


def test_a_joint_may_be_elastic_along_one_axis_only():
    """The others stay rigid, and free play hangs at its end: lower - m g/k."""
    law = "{dead_band: {stiffness: 4000.0, lower: -0.01, upper: 0.01}, damper: {coefficient: 60.0}}"
    recorded = single("fixed", f"compliance: {{along_axis: {law}}}", gravity=-g, end=2.0, step=5e-3)
    assert recorded.system.n_l == 5
    assert recorded["nodes/body/position"][-1, 2] == pytest.approx(-0.01 - 2.0 * g / 4000.0, rel=1e-8)
    np.testing.assert_allclose(recorded["joints/joint/force"][-1], [0, 0, 2.0 * g], rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(recorded["joints/joint/law_force_along_axis"][-1], -2.0 * g, rtol=1e-8)


def test_rotor_whirls_in_its_elastic_bearing():
    """Jeffcott's rotor: radius of the whirl, force of the bearing, moment and power of the motor, once it is steady."""
    m, k, c, W, e = 10.0, 1e5, 200.0, 70.0, 1e-3
    radius = m * e * W**2 / math.hypot(k - m * W**2, c * W)
    errors = []
    for step in (1e-3, 5e-4):
        recorded = RecordedRun(input_deck("elastic_bearing", f"time.step={step}", "time.end=1.6"))
        late = recorded.time > 1.5
        found = np.linalg.norm(recorded["nodes/shaft/position"][late], axis=1)
        errors.append(np.abs(found / radius - 1).max())
        np.testing.assert_allclose(
            np.linalg.norm(recorded["joints/bearing/force"][late], axis=1), radius * math.hypot(k, c * W), rtol=5e-3
        )
        np.testing.assert_allclose(recorded["joints/motor/moment"][late], c * W * radius**2, rtol=1e-2)
    assert errors[1] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.01)


BUSHING = [
    ({}, "give 'stiffness', 'damping' or 'laws'"),
    ({"stiffness": [1, 1, 1, 1, 1, -1]}, "'stiffness' must not generate energy"),
    ({"stiffness": np.eye(6) + np.eye(6, k=1)}, "'stiffness' must be symmetric"),
    ({"damping": [1, 1, 1, 1, 1, -1]}, "'damping' must not generate energy"),
    ({"damping": [1] * 6, "axis_1": [1, 0, 0]}, "'axis_1' is given without 'axis'"),
    ({"damping": [1] * 6, "axis": [2, 0, 0], "axis_1": [1, 0, 0]}, "'axis_1' must not be parallel to the axis"),
]


@pytest.mark.parametrize(("values", "text"), BUSHING)
def test_what_a_bushing_cannot_be(values, text):
    kind, nodes = KINDS["bushing"], [(np.zeros(3), np.eye(3))] * 2
    (found,) = kind.check({**{field.name: field.default for field in kind.fields}, **values}, nodes)
    assert found.startswith(text)

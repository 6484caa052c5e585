"""Warnings about laws that are left in a run: tables that hold their last value, strains beyond linear elasticity."""

import numpy as np
import pytest

import mecano
from mecano.laws.probe import held_beyond

HELD = {"points": [[-0.1, -5.0], [0.0, 0.0], [0.2, 8.0]], "file": None, "interpolation": "linear", "beyond": "hold"}
HEAD = "mecano: 1\ngravity: none\nnodes: {a: {position: [0, 0, 0], fixed: true}, b: {position: [1, 0, 0]}}\n"
SPRING = """
elements:
  weight: {type: point_mass, node: b, mass: 1}
  spring: {type: spring_damper, nodes: [a, b], law: {table: {points: [[-0.1, -100], [0, 0], [0.1, 100]]BEYOND}}}
initial: {velocities: [{nodes: [b], velocity: [SPEED, 0, 0]}]}
time: {end: 0.08, step: 1 ms}
"""
STRETCHED = """
sections: {rod: {type: circle, diameter: 10 mm, E: 1 GPa, nu: 0.3, density: 1000}}
elements:
  weight: {type: point_mass, node: b, mass: 1}
  line: {KIND}
loads: {pull: {type: force, node: b, direction: [1, 0, 0], value: FORCE}}
static: {}
"""
AREA = 0.25 * np.pi * 0.01**2


def warnings_of(text, tmp_path):
    """The warnings of a run."""
    path = tmp_path / "limits.yaml"
    path.write_text(text)
    with mecano.run(path, tmp_path / "limits.h5", quiet=True, force=True) as results:
        return results.warnings


@pytest.mark.parametrize(
    ("changed", "ends"),
    [
        ({}, (-0.1, 0.2)),
        ({"interpolation": "cubic"}, (-0.1, 0.2)),
        ({"points": [[-0.1, 0.0], [0.0, 0.0], [0.2, 8.0]]}, (-np.inf, 0.2)),  # a level end
        ({"beyond": "extend"}, (-np.inf, np.inf)),
    ],
)
def test_where_a_table_stops_to_change(changed, ends):
    assert held_beyond((("spring", {"stiffness": 3.0}), ("table", {**HELD, **changed}))) == ends


@pytest.mark.parametrize(
    ("speed", "beyond", "said"),
    [
        # half of the square of the speed, less 5 J, is the work of 100 N beyond 0.1 m; 1 m/s stretches by 0.0316 m
        (5.0, "", "extension reached 0.1"),
        (-5.0, "", "extension reached -0.1"),
        (5.0, ", beyond: extend", ""),
        (1.0, "", ""),
    ],
)
def test_a_spring_that_leaves_its_table(speed, beyond, said, tmp_path):
    found = warnings_of(HEAD + SPRING.replace("SPEED", str(speed)).replace("BEYOND", beyond), tmp_path)
    wanted = [f"spring_damper 'spring': {said}", f"but a table of the force ends at {np.sign(speed) * 0.1:g} and holds"]
    assert len(found) == bool(said)
    assert not said or all(part in found[0] for part in wanted)


@pytest.mark.parametrize(
    ("kind", "strain", "said"),
    [
        ("type: beam, nodes: [a, b], section: rod, mesh: 3", 0.11, "normal_stress reached 1.1e+08 at load factor 1"),
        ("type: beam, nodes: [a, b], section: rod, mesh: 3", 0.09, ""),
        (f"type: bar, nodes: [a, b], axial_stiffness: {1e9 * AREA}", 0.51, "tension reached 4.006e+04 at load factor"),
        (f"type: bar, nodes: [a, b], axial_stiffness: {1e9 * AREA}", 0.49, ""),
    ],
)
def test_strains_beyond_linear_elasticity(kind, strain, said, tmp_path):
    """The stress is E times the strain; of three elements of a beam the first is named."""
    text = HEAD + STRETCHED.replace("KIND", kind).replace("FORCE", str(1e9 * AREA * strain))
    found = [text for text in warnings_of(text, tmp_path) if "section 'rod'" not in text]
    assert len(found) == bool(said)
    assert not said or said in found[0]
    assert ("(and 2 more beyond it)" in "".join(found)) == ("beam" in kind and bool(said))


ROTOR = """
elements: {rotor: {type: rigid_body, node: b, mass: 1, inertia: [1, 1, 1]}}
joints:
  hinge:
    {type: hinge, nodes: [ground, b], axis: [0, 0, 1],
     turning_law: {dry_friction: {force: 0.5, regularization: REGULARIZATION}}}
loads: {motor: {type: joint_moment, joint: hinge, value: MOMENT}}
initial: {velocities: [{nodes: [b], angular_velocity: [0, 0, SPEED]}]}
time: {end: 0.5, step: 1 ms}
"""


@pytest.mark.parametrize(
    ("regularization", "moment", "speed", "said"),
    [
        (2.0, 0.0, 1.0, "at up to 1 rad/s, below the 'regularization' of 2 rad/s, braked as by a damper"),
        (0.01, 0.0, 1.0, ""),
        (0.01, 0.4, 0.0, ""),  # it sticks, and creeps by 3 mrad
    ],
)
def test_dry_friction_that_is_never_full(regularization, moment, speed, said, tmp_path):
    values = {"REGULARIZATION": regularization, "MOMENT": moment, "SPEED": speed}
    text = HEAD.replace("a: {position: [0, 0, 0], fixed: true}, ", "") + ROTOR
    for name, value in values.items():
        text = text.replace(name, str(value))
    found = [one for one in warnings_of(text, tmp_path) if "dry friction" in one]
    assert len(found) == bool(said)
    assert not said or found[0].startswith("hinge 'hinge': its dry friction never reached") and said in found[0]


@pytest.mark.parametrize(
    ("natural", "speed", "said"),
    [
        ("0", 1.0, "angle reached 0.3"),
        ("-0.15", -1.0, "angle reached -0.4"),  # the table reaches from -0.35 to 0.05 rad
        ("0.15", 0.5, ""),
        ("0.1*time", 1.0, ""),  # a set point that moves is not followed
    ],
)
def test_a_hinge_that_leaves_the_table_of_its_law(natural, speed, said, tmp_path):
    table = "{table: {points: [[-0.2, -0.1], [0, 0], [0.2, 0.1]]}}"
    text = HEAD.replace("a: {position: [0, 0, 0], fixed: true}, ", "") + ROTOR
    law = "{dry_friction: {force: 0.5, regularization: REGULARIZATION}}"
    values = {law: f"{table}, natural_angle: {natural}", "MOMENT": 0, "SPEED": speed, "end: 0.5": "end: 0.4"}
    for name, value in values.items():
        text = text.replace(name, str(value))
    found = warnings_of(text, tmp_path)
    beyond = [one for one in found if "a table of the moment ends at " in one]
    assert len(beyond) == bool(said)
    assert not said or beyond[0].startswith(f"hinge 'hinge': {said}")

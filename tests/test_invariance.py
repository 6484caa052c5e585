"""Frame invariance: a rotated and translated deck gives the rotated and translated motion."""

from dataclasses import replace

import numpy as np
import pytest
from instances import KINDS
from scipy.spatial.transform import Rotation
from time_runs import RecordedRun, input_deck
from time_runs import deck as text_deck

from mecano.analyses.invariance_tests import turned_values
from mecano.element_interface import SECTIONS

TURN, SHIFT = Rotation.from_rotvec([0.7, -1.9, 1.1]), np.array([0.6, -0.4, 1.0])
CASES = {  # deck: end [s] of 100 steps
    "pendulum": 1.0,
    "n_four_bar": 1.0,
    "four_bar": 1.0,
    "heavy_top": 0.1,
    "double_pendulum": 1.0,
    "slider_crank": 0.1,
    "cardan": 1.0,
    "torsion_pendulum": 1.0,
    "base_excitation": 1.0,
    "thruster": 5.0,
    "strut": 0.5,
    "wheel_drop": 0.4,
    "cable_snatch": 0.8,
    "friction_pendulum": 0.3,
    "bushing": 0.3,
    "moving_load": 0.47,  # no step ends where the load passes a node
}


def turned(deck):
    """The checked deck as if it had been written in axes turned by TURN and moved by SHIFT."""
    values, Q = dict(deck.values), TURN.as_matrix()
    values["gravity"] = list(Q @ values["gravity"])
    values["nodes"] = {name: turned_node(d, Q) for name, d in values["nodes"].items()}
    velocities = [turned_velocity(d, Q) for d in values["initial"]["velocities"]]
    values["initial"] = {**values["initial"], "velocities": velocities}
    for section in SECTIONS:
        items = values[section].items()
        values[section] = {name: turned_values(KINDS[d["type"]].fields, d, Q, SHIFT) for name, d in items}
    return replace(deck, values=values)


def turned_node(d, Q):
    rotation = TURN * Rotation.from_rotvec(d["orientation"])
    return {**d, "position": list(Q @ d["position"] + SHIFT), "orientation": list(rotation.as_rotvec())}


def turned_velocity(d, Q):
    about = d["about"] if d["about"] in (None, "own") else list(Q @ d["about"] + SHIFT)
    velocity, spin = (list(Q @ d[key]) for key in ("velocity", "angular_velocity"))
    return {**d, "velocity": velocity, "angular_velocity": spin, "about": about}


def largest_by_unit(recorded):
    """Return the largest value of the run for each unit, the scale of differences."""
    sizes = {}
    for c in recorded.columns.values():
        sizes[c.unit] = max(sizes.get(c.unit, 0.0), np.abs(recorded[c.path]).max())
    for unit in ("-", "rad"):  # one turn, however little there is of it
        sizes[unit] = max(sizes.get(unit, 0.0), 1.0)
    sizes["m/s"] = max(sizes["m/s"], sizes["rad/s"] * recorded.prepared.length)
    return sizes


def expected(recorded, column):
    """An output as it must be in the turned deck, or None for components along axes that a joint chooses."""
    values = recorded[column.path]
    if column.path.endswith("/rotation"):
        return (TURN * Rotation.from_quat(np.roll(values, -1, axis=-1))).as_matrix()
    if column.shape == (3,):
        moves = column.unit == "m"
        return TURN.apply(values) + (SHIFT if moves else 0.0) if "inertial" in column.doc else None
    return values


def compare(here, there):
    """Number of outputs compared, each to 1e-9 of the largest of its unit; energies count from the start."""
    sizes, compared = largest_by_unit(here), 0
    for path, column in here.columns.items():
        wanted, found = expected(here, column), there[path]
        if wanted is None:
            continue
        if path.endswith("/rotation"):
            found = Rotation.from_quat(np.roll(found, -1, axis=-1)).as_matrix()
        if path.startswith("energy/"):
            wanted, found = wanted - wanted[0], found - found[0]
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 * sizes[column.unit], err_msg=path)
        compared += 1
    return compared


@pytest.mark.parametrize("name", CASES)
def test_turned_and_moved(name):
    """Positions, rotations, velocities, inertial and scalar outputs of every step."""
    step = CASES[name] / 100
    tight = ("time.newton.force_tolerance=1e-13", "time.newton.constraint_tolerance=1e-14")
    deck = input_deck(name, f"time.step={step}", f"time.end={CASES[name]}", *tight)
    deck.values["time"]["adaptive"] = None
    here, there = RecordedRun(deck), RecordedRun(turned(deck))
    np.testing.assert_allclose(there.time, here.time, rtol=0, atol=1e-9 * CASES[name])
    assert compare(here, there) >= 4 * len(deck.values["nodes"]) + 6
    assert np.ptp(here["energy/kinetic"]) > 0.0  # it moves


MOVING_BASE = """
    mecano: 1
    gravity: {gravity}
    nodes:
      base: {{position: [0, 0, 0]}}
      weight: {{position: [0.3, 0.2, 0.9]}}
      arm: {{position: [0, 0, 0]}}
    elements:
      plate: {{type: rigid_body, node: base, mass: 1, inertia: [1, 1, 1]}}
      weight: {{type: point_mass, node: weight, mass: 1.3}}
      arm: {{type: rigid_body, node: arm, mass: 2, inertia: [0.1, 0.12, 0.2], center_of_mass: [0.4, 0.1, 0.2]}}
      first: {{type: spring_damper, nodes: [base, weight], law: {{spring: 300, damper: 2}}}}
      second: {{type: spring_damper, nodes: [arm, weight], law: {{spring: 200, damper: 1}}}}
    joints:
      hinge: {{type: hinge, nodes: [base, arm], axis: [0.2, 1, 0.3], turning_law: {{spring: 5, damper: 0.1}}}}
      level: {{type: held_rotation, nodes: [ground, base]}}
      x: {{type: prescribed_position, node: base, direction: [1, 0, 0], value: {values[0]}}}
      y: {{type: prescribed_position, node: base, direction: [0, 1, 0], value: {values[1]}}}
      z: {{type: prescribed_position, node: base, direction: [0, 0, 1], value: {values[2]}}}
    time: {{end: 0.5, step: 1 ms, newton: {{force_tolerance: 1.0e-12, constraint_tolerance: 1.0e-13}}}}
"""


@pytest.mark.parametrize(
    "value",
    ["{{polynomial: [0, 0, {half}]}}", "{{acceleration: {{points: [[0, {a}], [1, {a}]]}}}}", "{half}*time**2"],
    ids=["polynomial", "acceleration", "formula"],
)
def test_a_base_with_an_acceleration_is_a_change_of_gravity(value):
    """Relative to a base with the acceleration a, all moves as on a base at rest with the gravity g - a.

    Steps are exact at a constant acceleration: what remains are the tolerances of the iterations.
    """
    a, g = np.array([1.5, -0.7, 2.0]), np.array([0.0, 0.0, -9.81])
    values = [value.format(a=x, half=x / 2) for x in a.tolist()]
    moving = RecordedRun(text_deck(MOVING_BASE.format(gravity=g.tolist(), values=values)))
    at_rest = RecordedRun(text_deck(MOVING_BASE.format(gravity=(g - a).tolist(), values=[0, 0, 0])))
    along = 0.5 * np.outer(moving.time**2, a)
    for node in ("weight", "arm"):
        position, spin = f"nodes/{node}/position", f"nodes/{node}/angular_velocity"
        np.testing.assert_allclose(moving[position] - along, at_rest[position], rtol=0, atol=1e-10)
        np.testing.assert_allclose(moving[spin], at_rest[spin], rtol=0, atol=1e-9)
    assert np.ptp(at_rest["nodes/arm/angular_velocity"], axis=0).max() > 1.0

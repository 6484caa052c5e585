"""Frame invariance: a whole deck turned and moved gives the motion turned and moved."""

from dataclasses import replace

import numpy as np
import pytest
from instances import KINDS, turned_values
from marching import March, input_deck
from scipy.spatial.transform import Rotation

TURN, SHIFT = Rotation.from_rotvec([0.7, -1.9, 1.1]), np.array([3.0, -2.0, 5.0])
SECTIONS = ("elements", "joints", "loads")
CASES = {  # deck: end [s] of 100 steps
    "four_bar": 1.0,
    "heavy_top": 0.1,
    "double_pendulum": 1.0,
    "slider_crank": 0.1,
    "cardan": 1.0,
    "torsion_pendulum": 1.0,
    "base_excitation": 1.0,
    "thruster": 5.0,
    "strut": 0.5,
}


def turned(deck):
    """The checked deck as if it had been written in axes turned by TURN and moved by SHIFT."""
    values, Q = dict(deck.values), TURN.as_matrix()
    values["gravity"] = list(Q @ values["gravity"])
    values["nodes"] = {name: turned_node(d, Q) for name, d in values["nodes"].items()}
    values["initial"] = {"velocities": [turned_velocity(d, Q) for d in values["initial"]["velocities"]]}
    for section in SECTIONS:
        items = values[section].items()
        values[section] = {name: turned_values(KINDS[d["type"]], d, Q, SHIFT) for name, d in items}
    return replace(deck, values=values)


def turned_node(d, Q):
    rotation = TURN * Rotation.from_rotvec(d["orientation"])
    return {**d, "position": list(Q @ d["position"] + SHIFT), "orientation": list(rotation.as_rotvec())}


def turned_velocity(d, Q):
    about = d["about"] if d["about"] in (None, "own") else list(Q @ d["about"] + SHIFT)
    velocity, spin = (list(Q @ d[key]) for key in ("velocity", "angular_velocity"))
    return {**d, "velocity": velocity, "angular_velocity": spin, "about": about}


def columns_that_turn(march):
    """Paths of the outputs that are scalars, and of those whose doc calls them inertial."""
    scalars = [c.path for c in march.columns.values() if c.shape == ()]
    vectors = [c.path for c in march.columns.values() if c.shape == (3,) and "inertial" in c.doc]
    return scalars, vectors


@pytest.mark.parametrize("name", CASES)
def test_turned_and_moved(name):
    """Positions, rotations, velocities and outputs to 1e-9 of their largest values over the run."""
    step = CASES[name] / 100
    tight = ("time.newton.force_tolerance=1e-13", "time.newton.constraint_tolerance=1e-14")
    deck = input_deck(name, f"time.step={step}", f"time.end={CASES[name]}", *tight)
    here, there = March(deck), March(turned(deck))
    np.testing.assert_allclose(there.time, here.time, rtol=0, atol=1e-12)
    Q = TURN.as_matrix()
    scalars, vectors = columns_that_turn(here)
    assert len(vectors) >= 3
    for path in vectors:
        shift = SHIFT if here.columns[path].unit == "m" else 0.0
        close(path, there[path], here[path] @ Q.T + shift)
    for path in here.columns:
        if path.endswith("/rotation"):
            expected = (TURN * Rotation.from_quat(here[path], scalar_first=True)).as_matrix()
            close(path, Rotation.from_quat(there[path], scalar_first=True).as_matrix(), expected)
    for path in scalars:
        close(path, there[path], here[path])


def close(path, actual, expected):
    size = np.abs(expected).max()
    print(path, np.abs(actual - expected).max() / max(size, 1e-300))

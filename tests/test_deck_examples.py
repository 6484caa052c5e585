"""The example lines of `mecano explain`: every kind, shape and term has one, and all are valid."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from mecano.deck.catalogue import explain
from mecano.deck.examples import EXAMPLES
from mecano.deck.read import read_deck
from mecano.elements import KINDS
from mecano.elements.members.cross_section import SHAPES
from mecano.elements.wheels.slip_laws import SLIP_LAWS
from mecano.laws import TERMS

CONTEXT = """\
mecano: 1
gravity: [0, 0, -9.81]
nodes:
  crank: {position: [0, 0, 1]}
  pin: {position: [0.4, 0, 1]}
  rod: {position: [0, 0, 1]}
  slider: {position: [1, 0, 1]}
  wheel: {position: [0, 0, 0.3]}
elements:
  girder: {type: beam, nodes: [crank, slider], section: pipe, mesh: 2}
  masses$i: {repeat: [{i: 1, at: crank}, {i: 2, at: rod}, {i: 3, at: slider}, {i: 4, at: wheel}, {i: 5, at: pin}],
    type: rigid_body, node: $at, mass: 1, inertia: [1, 1, 1]}
joints:
  knee: {type: hinge, nodes: [crank, rod], axis: [0, 1, 0]}
  rail: {type: prismatic, nodes: [ground, slider], axis: [1, 0, 0]}
laws:
  viscous: {spring: {stiffness: 1e3}, damper: {coefficient: 10}}
sections:
  pipe: {type: tube, diameter: 0.1, thickness: 0.01, E: 2e11, nu: 0.3, density: 7850}
grounds:
  road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
tire_laws:
  tyre: {radius: 0.3, radial: {linear: {slope: 1e5}}, friction: 0.8, slip_regularization: 0.1}
  brush:
    radius: 0.3
    radial: {linear: {slope: 1e5}}
    fiala: {cornering_stiffness: 6e4, friction: 0.8, carcass_stiffness: [3e5, 2e5]}
  soft_tyre:
    radius: 0.3
    radial: {linear: {slope: 1e5}}
    friction: 0.8
    slip_regularization: 0.1
    lateral: {relaxation: {cornering_stiffness: 2e5, relaxation_length: 0.3}}
time: {end: 1, step: 0.01}
"""
OWNERS = {**KINDS, **SHAPES, **dict.fromkeys(TERMS), **dict.fromkeys(SLIP_LAWS)}
del OWNERS["friction"]


def test_there_is_an_example_of_everything():
    named = [name for name, kind in OWNERS.items() if kind is None or kind.section]
    assert set(named) == set(EXAMPLES), "each needs one line in mecano/deck/examples.py"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the file of the superelement."""
    path = tmp_path_factory.mktemp("examples")
    spring = np.diag([1e3, 1e3, 1e3, 1e2, 1e2, 1e2])
    lever = np.eye(6)  # the motion of the second node, 1 m along x from the first, with that of the first one
    lever[1, 5], lever[2, 4] = 1.0, -1.0
    B = np.hstack([-lever, np.eye(6)])
    shutil.copy(Path(__file__).parent.parent / "inputs" / "passenger_car.tir", path)
    np.savez(path / "wing.npz", positions=[[0, 0, 0], [1, 0, 0]], stiffness=B.T @ spring @ B, mass=np.eye(12))
    return path


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_are_right(name, folder):
    """As they are shown, in the deck that they are of."""
    shown = re.search(r"\nExample\n  (\w+):\n((?:    .*\n)+)", explain(name))
    section, lines = shown[1], shown[2].replace("\n  ", "\n")[2:]
    if f"\n{section}:\n" in CONTEXT:
        text = CONTEXT.replace(f"\n{section}:\n", f"\n{section}:\n{lines}")
    else:
        text = f"{CONTEXT}{section}:\n{lines}"
    (folder / "deck.yaml").write_text(text)
    read = read_deck(folder / "deck.yaml").values[section]
    written = read[EXAMPLES[name].partition(":")[0]]
    assert name in (dict(written) if section in ("laws", "tire_laws") else (written["type"],))

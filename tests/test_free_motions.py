"""Motions without stiffness: their number follows from the mechanism, not from the order in which a deck is written."""

import random
from dataclasses import replace

import numpy as np
import pytest
from time_runs import deck, input_deck

from mecano.analyses.modal import modes


def kinds(name, seed):
    """Kinds of the modes of a deck of inputs/ with its nodes in another order."""
    read = input_deck(name)
    nodes = list(read.values["nodes"].items())
    random.Random(seed).shuffle(nodes)
    return modes(replace(read, values={**read.values, "nodes": dict(nodes)}), None, number=100)[1].kinds


@pytest.mark.parametrize("seed", range(4))
def test_a_gear_whose_wheel_just_meets_the_ground_is_free_to_move_with_its_load_and_to_spin(seed):
    """The load moves along three axes without stiffness; only the arm on the oleo has some."""
    assert kinds("nose_gear_rigid", seed) == ["free"] * 4 + ["decay"] * 2


def test_a_platform_on_mecanum_wheels_is_free_to_move_in_its_plane_and_to_turn_its_wheels():
    """Three motions of the platform and the angles of four wheels: nothing has stiffness, so nothing else remains."""
    assert kinds("mecanum", 1) == ["free"] * 7


@pytest.mark.parametrize("seed", range(4))
def test_a_wheel_that_rolls_behind_its_arm_has_one_free_motion(seed):
    """Its angle: at a given speed nothing else moves."""
    assert kinds("trailing_wheel_bump", seed) == ["free"]


def test_a_small_stiffness_is_not_taken_for_rounding():
    """A torsion balance of 2e-16 N m/rad and 3e-17 kg m2, as of nanotubes: sqrt(k/I)."""
    text = """
        mecano: 1
        gravity: none
        nodes: {mirror: {position: [0, 0, 0]}}
        elements: {mirror: {type: rigid_body, node: mirror, mass: 1.0e-12, inertia: [3.0e-17, 3.0e-17, 3.0e-17]}}
        joints: {tube: {type: hinge, nodes: [ground, mirror], axis: [0, 0, 1], turning_law: {spring: 2.0e-16}}}
        time: {end: 1, step: 0.01}
        """
    (value,) = modes(deck(text), None)[1].values
    assert value == pytest.approx(1j * np.sqrt(2.0e-16 / 3.0e-17), rel=1e-9)

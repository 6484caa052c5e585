"""Nodes attached to a body with orientations of their own: the motion is unchanged."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck

from mecano.deck.physics import rotations

TURN = (0.3, -0.5, 0.8)
MODEL = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      arm: {{position: [0, 0, 0]}}
      lug: {{position: [0.6, 0.1, 0.2], orientation: {turn}}}
      block: {{position: [0.6, 0.1, 0.2], orientation: {turn}}}
    elements:
      {arm}
      block: {{type: rigid_body, node: block, mass: 0.7, inertia: {inertia}, center_of_mass: {center}}}
    joints:
      pivot: {{type: hinge, nodes: [ground, arm], axis: [0, 1, 0]}}
      rail: {{type: prismatic, nodes: [lug, block], axis: [1, 0.4, 0.2]}}
    loads:
      push: {{type: follower_force, node: lug, direction: [0, 3, 1], value: 2.0}}
    time: {{end: 0.5, step: 2.0e-3}}
"""
BODY = "arm: {type: rigid_body, node: arm, mass: 2, inertia: [0.1, 0.2, 0.3], attached: [lug]}"
LINK = """arm: {type: rigid_body, node: arm, mass: 2, inertia: [0.1, 0.2, 0.3]}
      link: {type: rigid_link, nodes: [arm, lug]}"""
INERTIA, CENTER = np.diag([0.02, 0.03, 0.04]), np.array([0.05, 0.0, 0.02])


def march_of(arm, turn):
    """Run the model with lug and block turned; the inertia of the block is unchanged in inertial axes."""
    (R,) = rotations(np.array([turn]))
    J = R.T @ INERTIA @ R
    J, center = 0.5 * (J + J.T), R.T @ CENTER
    return RecordedRun(deck(MODEL.format(arm=arm, turn=list(turn), inertia=J.tolist(), center=center.tolist())))


@pytest.mark.parametrize("arm", [BODY, LINK], ids=["attached", "rigid_link"])
def test_joint_on_a_turned_node(arm):
    plain, turned = march_of(arm, (0.0, 0.0, 0.0)), march_of(arm, TURN)
    paths = ["joints/pivot/angle", "joints/rail/displacement", "joints/rail/force", "joints/rail/moment"]
    paths += ["elements/link/force", "elements/link/moment"] if arm is LINK else []
    for path in paths:
        size = np.abs(plain[path]).max()
        assert size > 1e-3
        np.testing.assert_allclose(turned[path], plain[path], rtol=0, atol=1e-6 * size, err_msg=path)

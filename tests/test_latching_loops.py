"""Latches that lock coupled joints share their load with the coupler, whatever was redundant before they closed."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck

# two folded panels on the ground; the coupler turns the second hinge twice as far, until both lock in a line
PANELS = """
    mecano: 1
    gravity: none
    nodes:
      a: {{position: [0, 0, 0]}}
      a2: {{position: [0, 0, 1]}}
      b: {{position: [0, 0, 1]}}
      bc: {{position: [0, 0, 0.5]}}
    elements:
      A: {{type: rigid_body, node: a, center_of_mass: [0, 0, 0.5], mass: 4, inertia: [1, 0.33, 0.7], attached: [a2]}}
      B: {{type: rigid_body, node: b, center_of_mass: [0, 0, -0.5], mass: 4, inertia: [1, 0.33, 0.7], attached: [bc]}}
    joints:
      h1:
        {{type: hinge, nodes: [ground, a], axis: [0, 1, 0], turning_law: {{spring: 0.5}}, natural_angle: 120 deg,
         latch: {{angle: 90 deg}}}}
      h2:
        {{type: hinge, nodes: [a2, b], axis: [0, -1, 0], turning_law: {{spring: 0.5}}, natural_angle: 210 deg,
         latch: {{angle: 180 deg}}}}
      sync: {{type: coupler, angles: [h1, h2], factors: [2, -1]}}
      {tie}
    time: {{end: 2.8, step: 2 ms}}
"""
TIES = {
    "free": "",
    "fixed": "tie: {type: fixed, nodes: [ground, bc], release: {time: 0.2}}",
    "hinge": "tie: {type: hinge, nodes: [ground, bc], axis: [0, 1, 0], release: {time: 0.2}}",
}
ROWS = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, -0.5]])  # of the latches and the coupler, by the two angles: B^T
ROUNDING = 1e-4  # of the acting forces: redundant reactions, with which rounded positions interfere (theory.md, 3)


def least_norm(load):
    """Return the loads (2,) of the latches that balance ``load`` (2,) [N m] along the angles with the coupler."""
    return np.linalg.lstsq(ROWS, -np.asarray(load), rcond=None)[0][:2]


def momenta():
    """Return the momenta (2,) [N m s] along the angles of the hinges when the panels are in a line.

    The springs, of 0.5 N m/rad, have moved 1/2 (2 m (1/2 m)^2 + 2 J) w^2. The first panel turns at w about y, the
    second at -w, and both centres of mass move at w/2.
    """
    turned = np.radians([120.0, 210.0]) ** 2 - np.radians([30.0, 30.0]) ** 2
    w = np.sqrt(0.5 * turned.sum() / (2 * 4.0 * 0.5**2 + 2 * 0.33))
    first, second = 0.33 + 4.0 * 0.5 * 0.5, 1.5 * 4.0 * 0.5 - 0.33
    return w * np.array([first + second, 0.33 - 0.5 * 4.0 * 0.5])


@pytest.mark.parametrize("tie", TIES)
def test_latches_share_impulse_and_load_with_the_coupler(tie):
    """The tie makes the model redundant from the start, and is away before the latches close."""
    recorded = RecordedRun(deck(PANELS.format(tie=TIES[tie])))
    locks = {event.element: event for event in recorded.event_records if event.name == "locks"}
    found = [locks[f"hinge '{name}'"].impulse for name in ("h1", "h2")]
    np.testing.assert_allclose(found, least_norm(momenta()), rtol=1e-5)
    loads = np.stack([recorded[f"joints/{name}/latch_moment"][-1] for name in ("h1", "h2")]).ravel()
    acting = np.abs(recorded["joints/h1/force"]).max()  # N, on panels of 1 m
    np.testing.assert_allclose(loads, least_norm(0.5 * np.radians([30.0, 30.0])), rtol=0, atol=ROUNDING * acting)
    (remark,) = recorded.integrator.warnings
    assert "1 constraint(s) are redundant among: hinge 'h1', 'h2': moment of the latch" in remark

"""Rigid stops, flanks of gears and contacts that close on the way to an equilibrium hold where they are met."""

import pytest
from equilibria import Equilibrium

DECK = """
    mecano: 1
    gravity: none
    nodes:
      a: {position: [0, 0, 0]}
      b: {position: [0.3, 0, 0]}
      c: {position: [0, 2, 0.11]}
    elements:
      gear_a: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}
      gear_b: {type: rigid_body, node: b, mass: 1, inertia: [1, 1, 1]}
      ball: {type: rigid_body, node: c, mass: 1, inertia: [1, 1, 1]}
      floor: {type: contact, nodes: [ground, c], plane: {normal: [0, 0, 1], point: [0, 0, 0]}, radius: 0.1}
    joints:
      bearing_a: {type: hinge, nodes: [ground, a], axis: [0, 0, 1], turning_law: {spring: 100}}
      bearing_b: {type: hinge, nodes: [ground, b], axis: [0, 0, 1], turning_law: {spring: 100}, stops: STOPS}
      mesh: {type: gear_pair, nodes: [ground, a, b], axis_a: [0, 0, 1], radius_a: 0.1, radius_b: 0.2, backlash: 2 mm}
      guide: {type: prismatic, nodes: [ground, c], axis: [0, 0, 1], sliding_law: {spring: 1000}}
    loads:
      motor: {type: couple, nodes: [ground, a], axis: [0, 0, 1], value: 5}
      press: {type: force, node: c, direction: [0, 0, -1], value: 40}
    static: {METHOD}
    """


@pytest.mark.parametrize("method", ["steps: 2", "method: arc_length", "method: relaxation"])
def test_contacts_of_an_equilibrium_hold_where_they_meet(method):
    """Of 40 N the spring of the ball carries 1000*0.01; gear b rests on its stop, and s = 0.1*0.03 - 0.2*0.01 m.

    The spring of a takes 100*0.03 of 5 N m, the teeth 2/0.1 N, the stop of b 0.2*20 - 100*0.01 N m.
    """
    m = Equilibrium(DECK.replace("METHOD", method).replace("STOPS", "{lower: -0.01, upper: 1}"))
    known = {
        "elements/floor/gap": 0.0, "elements/floor/normal_force": 30.0, "joints/mesh/transmission_error": 1e-3,
        "joints/mesh/force": -20.0, "joints/bearing_b/angle": -0.01, "joints/bearing_b/stop_moment": 3.0,
    }  # fmt: skip
    assert {path: float(m.output(path)[0]) for path in known} == pytest.approx(known, rel=1e-9, abs=1e-12)

"""Free motions with flexible members held rigid, against linkages with known motions."""

import pytest
from time_runs import deck, input_deck

from mecano.analyses.prepare import prepare
from mecano.solve.diagnostics.rigidity import stiff_mechanisms


def counts(checked):
    """How many motions each group has."""
    prepared = prepare(checked)
    found = stiff_mechanisms(prepared.system, prepared.state, prepared.length, prepared.analysis)
    return found if found is None else sorted(group.count for group in found)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("nose_landing_gear", [1, 1, 3]),  # as nose_gear_rigid: sideways; the wheel; load and arm in their plane
        ("flexible_ring", [3, 3]),  # free in and out of its plane
        ("lateral_buckling", []),
        ("four_bar", None),
    ],
)
def test_decks(name, expected):
    assert counts(input_deck(name)) == expected


CRANK = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      a: {{position: [0, 0, 0]}}
      b: {{position: [1, 0.3, 0.2], orientation: [0.3, -0.2, 0.5]}}
      c: {{position: [2, 0, 0], orientation: [0, 1, 0]}}
      s: {{position: [2, 0, 0]}}
    elements:
      first: {{type: beam, nodes: [a, b], section: rod, mesh: 3}}
      second: {{type: beam, nodes: [b, c], section: rod}}
      sled: {{type: point_mass, node: s, mass: 1}}
    sections: {{rod: {{type: circle, diameter: 0.01, E: 2.0e11, nu: 0.3, density: 7800}}}}
    joints:
      pin: {{type: hinge, nodes: [ground, a], axis: [0, 1, 0]}}
      far: {{type: hinge, nodes: [c, s], axis: [0, 1, 0]}}
      rail: {{type: prismatic, nodes: [ground, s], axis: {axis}}}
    time: {{end: 1, step: 0.1}}
"""


@pytest.mark.parametrize(("axis", "expected"), [("[0, 0, 1]", [1]), ("[1, 0, 0]", []), ("[1, 0, 1]", [])])
def test_a_bent_arm_between_two_pins(axis, expected):
    """Its end goes along z when it turns about y, and nowhere else."""
    assert counts(deck(CRANK.format(axis=axis))) == expected


def test_members_that_hang_on_one_another_are_one_body():
    """Without joints the arm has the six motions of a body, beside the three of the sled."""
    text = CRANK.format(axis="[1, 0, 0]")
    free = text.partition("    joints:")[0] + "    time: {end: 1, step: 0.1}\n"
    assert counts(deck(free)) == [1, 1, 1, 6]

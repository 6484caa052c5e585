"""Pressure and moments along beams against closed forms; the load factor of loads along lines."""

import math
import re

import numpy as np
import pytest
from scipy.integrate import quad
from time_runs import deck, input_deck

from mecano.analyses.static import run
from mecano.deck.format import deck_error_text
from mecano.errors import DeckError
from mecano.results.reader import open_results

S = "Loads along beams"
ONLY_BENT = (
    "loads.water.value=1", "loads.torque.value=0", "elements.bent.mesh=4", "static.steps=1",
    "loads.bending.line=[root_2, bent.1, bent.2, bent.3, tip_2]",
)  # fmt: skip


def results_of(a_deck, folder, names):
    """Run statics; return the values of the named outputs at all equilibria, and the warnings."""
    path, notes = folder / f"{len(list(folder.iterdir()))}.h5", []
    run(a_deck, path, announce=notes.append)
    with open_results(path) as results:
        return [results[name].values for name in names], notes


def test_a_pressed_ring_and_cantilevers_under_moments(verify, tmp_path):
    outputs = "tip_1.rotation", "tip_2.rotation", "tip_2.position", "east.position"
    (twisted, bent, tip, east), notes = results_of(input_deck("loads_along_beams"), tmp_path, outputs)
    critical = 4000.0 * float(re.search(r"near ([\d.]+), the equilibrium becomes unstable", notes[0])[1])
    verify(S, "ring under pressure: buckles at [N/m]", critical, 3000.0, "Levy 1884, 3 EI/R^3", relative=5e-4)
    assert 1.0 - east[-1, 0] == pytest.approx(4000.0 / 1e7, rel=2e-3)  # p w R^2/EA
    angles = 2.0 * np.arctan2(twisted[-1, 1], twisted[-1, 0]), 2.0 * np.arctan2(bent[-1, 3], bent[-1, 0])
    known = 0.25, math.pi / 2.0
    verify(
        S, "distributed moments: twist, rotation of the tip [rad]", angles, known, "m L^2/2 over GJ, EI", relative=1e-8
    )
    coarse = results_of(input_deck("loads_along_beams", *ONLY_BENT), tmp_path, ["tip_2.position"])[0][0]
    found = (4.0 * tip[-1] - coarse[-1]) / 3.0
    x, y = (quad(lambda s, f=f: f(math.pi * (s - s**2 / 2)), 0.0, 1.0)[0] for f in (math.cos, math.sin))
    what, remark = "distributed moments: tip of Euler's spiral [m]", "extrapolated from 4 and 8 elements"
    verify(S, what, found[:2], (x, 3.0 + y), "quadrature", absolute=1e-4, remark=remark)
    assert (coarse[-1, 0] - x) / (tip[-1, 0] - x) == pytest.approx(4.0, abs=0.05)


BAR = """
    mecano: 1
    gravity: none
    sections: {rod: {type: circle, diameter: 0.1, E: 1.0e9, nu: 0.3, density: 1000}}
    nodes: {foot: {position: [0, 0, 0], fixed: true}, top: {position: [0, 0, 10]}}
    elements: {mast: {type: beam, nodes: [foot, top], section: rod, mesh: 3}}
    loads: {load: {LOAD, line: [foot, mast.1, mast.2, top]}}
    static: {steps: STEPS}
"""
LOADS = (
    "type: line_load, direction: [1, 0, 0], value: VALUE, follows: true",
    "type: line_moment, direction: [0, 1, 1], value: VALUE",
    "type: pressure, across: [0, 1, 0], width: 1, value: VALUE",
)


@pytest.mark.parametrize("load", LOADS)
def test_the_load_factor_is_the_share_of_a_load_along_a_line(tmp_path, load):
    """At half the load factor the mast bends as under half the load, although the load turns with it."""

    def top(value, steps):
        text = BAR.replace("LOAD", load.replace("VALUE", str(value)), 1).replace("STEPS", str(steps))
        return results_of(deck(text), tmp_path, ["top.position", "load.value"])[0]

    (whole, values), (half, _) = top(30.0, 2), top(15.0, 1)
    np.testing.assert_allclose(values, [0.0, 15.0, 30.0])
    assert np.linalg.norm(half[-1] - half[0]) > 0.5
    np.testing.assert_allclose(whole[1], half[1], atol=1e-7)


def test_errors():
    with pytest.raises(DeckError) as info:
        input_deck("loads_along_beams", "loads.water.across=[0, 1, 0.05]")
    text = "'across' runs along the line between nodes 'east' and 'ring.1'; it must cross it"
    assert text in deck_error_text(info.value)


LINES = """
mecano: 1
gravity: none
sections: {tube: {type: tube, diameter: 0.1, thickness: 5 mm, E: 70 GPa, nu: 0.3, density: 2700}}
nodes: {tip: {position: [0, 0, 3]}}
elements: {mass: {type: point_mass, node: tip, mass: 1}}
templates:
  mast:
    nodes: {foot: {position: [0, 0, 0], fixed: true}, top: {position: [0, 0, 1]}, boom: {position: [0, 0, 2]}}
    elements:
      mast: {type: beam, nodes: [foot, top], section: tube, mesh: 3}
      boom: {type: beam, nodes: [boom, top], section: tube, mesh: 2}
      bar: {type: rigid_body, node: boom, mass: 1, inertia: [1, 1, 1]}
    loads: {wind: {type: line_load, line: [mast, boom.1, boom], direction: [1, 0, 0], value: 3 N/m}}
place: {p: {template: mast}}
loads: {wind: {type: line_load, line: LINE, direction: [1, 0, 0], value: 3 N/m}}
time: {end: 1, step: 0.1}
"""


@pytest.mark.parametrize(
    ("line", "nodes"),
    [
        ("p_mast", "p_foot p_mast.1 p_mast.2 p_top"),
        ("[p_mast, tip]", "p_foot p_mast.1 p_mast.2 p_top tip"),
        ("[p_mast.2, p_top, p_boom.1]", "p_mast.2 p_top p_boom.1"),
    ],
)
def test_a_member_in_a_line_stands_for_its_nodes(line, nodes):
    """The beam boom runs to the top, against the line, but the name is that of a node, too, which comes first."""
    loads = deck(LINES.replace("LINE", line)).values["loads"]
    assert loads["wind"]["line"] == nodes.split()
    assert loads["p_wind"]["line"] == "p_foot p_mast.1 p_mast.2 p_top p_boom.1 p_boom".split()
    with_a_name = LINES.replace("LINE", line).replace("boom: {position", "end: {position").replace("[boom,", "[end,")
    with_a_name = with_a_name.replace("[mast, boom.1, boom]", "[mast, boom]").replace("node: boom", "node: end")
    loads = deck(with_a_name).values["loads"]
    assert loads["p_wind"]["line"] == "p_foot p_mast.1 p_mast.2 p_top p_boom.1 p_end".split()


@pytest.mark.parametrize("line", ["p_mats", "[p_foot, p_bar]", "3"])
def test_a_line_of_what_is_no_member(line):
    with pytest.raises(DeckError) as error:
        deck(LINES.replace("LINE", line))
    expected = {"p_mats": "did you mean 'p_mast'?", "3": "must be the name of a member, or a list of names"}
    assert expected.get(line, "unknown node 'p_bar'") in deck_error_text(error.value)

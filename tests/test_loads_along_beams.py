"""Loads along beams in statics: their load factor."""

import numpy as np
import pytest
from time_runs import deck

from mecano.analyses.static import run
from mecano.results.reader import open_results


def results_of(a_deck, folder, names):
    """Run statics; return the values of the named outputs at all equilibria, and the warnings."""
    path, notes = folder / f"{len(list(folder.iterdir()))}.h5", []
    run(a_deck, path, announce=notes.append)
    with open_results(path) as results:
        return [results[name].values for name in names], notes


BAR = """
    mecano: 1
    gravity: none
    sections: {rod: {type: circle, diameter: 0.1, E: 1.0e9, nu: 0.3, density: 1000}}
    nodes: {foot: {position: [0, 0, 0], fixed: true}, top: {position: [0, 0, 10]}}
    elements: {mast: {type: beam, nodes: [foot, top], section: rod, mesh: 3}}
    loads: {load: {LOAD, line: [foot, mast.1, mast.2, top]}}
    static: {steps: STEPS}
"""
LOADS = ("type: line_load, direction: [1, 0, 0], value: VALUE, follows: true",)


@pytest.mark.parametrize("load", LOADS)
def test_the_load_factor_is_the_share_of_a_load_along_a_line(tmp_path, load):
    """At half the load factor the mast bends as under half the load, although the load turns with it."""

    def top(value, steps):
        text = BAR.replace("LOAD", load.replace("VALUE", str(value)), 1).replace("STEPS", str(steps))
        return results_of(deck(text), tmp_path, ["top.position", "load.value"])[0]

    (whole, values), (half, _) = top(60.0, 2), top(30.0, 1)
    np.testing.assert_allclose(values, [0.0, 30.0, 60.0])
    assert np.linalg.norm(half[-1] - half[0]) > 0.5
    np.testing.assert_allclose(whole[1], half[1], atol=1e-7)

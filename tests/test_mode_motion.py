"""Modes in motion: the displacements of a file of modes, played one after the other."""

import re
import textwrap
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mecano
from mecano.element_interface import Display
from mecano.errors import ResultsError, UsageError
from mecano.post.animation import animate, page_data
from mecano.post.mode_motion import CYCLES, MOST, write_motions
from mecano.post.mode_shapes import AMPLITUDE
from mecano.post.runs import open_runs
from mecano.results.modes_file import ModesFile
from mecano.results.reader import open_results

ROW = """
    mecano: 1
    gravity: none
    nodes: {wall: {position: [0, 0, 0], fixed: true}, tip: {position: [1, 0, 0]}}
    elements:
      mass: {type: point_mass, node: tip, mass: 1}
      spring: {type: spring_damper, nodes: [wall, tip], law: {spring: 100}}
    time: {end: 1, step: 0.1}
"""
QUARTER = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # by -90 degrees about z


def modes_file():
    """A whirl of the tip about x at 2 Hz, and a mode in which only the hub turns; the mechanism is 2 m long."""
    still, none = np.zeros((2, 3), complex), np.eye(3)
    whirl, turn = still.copy(), still.copy()
    whirl[0], turn[1] = (0.0, 1.0, 1.0j), (0.0, 0.0, 1.0)
    nodes = {
        "hub": {"position": np.zeros(3), "orientation": QUARTER, "translation": still, "rotation": turn},
        "tip": {"position": np.array([2.0, 0, 0]), "orientation": none, "translation": whirl, "rotation": still},
    }
    numbers = {
        "frequency": np.array([2.0, 5.0]), "damping_ratio": np.array([0.01, 0.0]), "real_part": np.array([-0.1, 0.0]),
    }  # fmt: skip
    resolved = {
        "title": "Whirl", "nodes": {"hub": {"position": [0, 0, 0]}, "tip": {"position": [2, 0, 0]}},
        "elements": {"shaft": {"type": "beam", "nodes": ["hub", "tip"]}}, "gravity": [0.0, 0.0, 0.0],
    }  # fmt: skip
    return ModesFile(
        Path("a_modes.h5"), "Whirl", "initial state", np.array([-0.1 + 12.6j, 31.4j]), ["oscillation", "oscillation"],
        np.ones(2, bool), numbers, nodes, {}, resolved, {"beam": Display("beam")}, frozenset(),
    )  # fmt: skip


@pytest.fixture
def motions(tmp_path):
    write_motions(modes_file(), tmp_path / "motions.h5")
    return tmp_path / "motions.h5"


def test_modes_have_no_plots_over_time(motions):
    """Their file has no outputs, which the standard plots of a deck expect: hinges with latch and law, for example."""
    [run] = open_runs([motions])
    run.deck["joints"] = {"hinge": {"type": "hinge", "turning_law": "drive", "latch": {"angle": 1.5}}}
    assert page_data(run)["plots"] == []


def test_each_mode_moves_by_the_real_part_of_its_shape(motions):
    with open_results(motions) as results:
        time, tip = results.time, results["tip.position"].values
        hub = results["hub.rotation"].values
    size, first = AMPLITUDE * 2.0, (time >= 1.0) & (time < 2.0)
    np.testing.assert_array_equal(tip[0], [2.0, 0.0, 0.0])  # the state itself, from which parts turn
    phase = 2.0 * np.pi * CYCLES * (time[first] - 1.0)
    expected = np.stack([2.0 + 0.0 * phase, size * np.cos(phase), -size * np.sin(phase)], axis=1)
    np.testing.assert_allclose(tip[first], expected, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(tip[time >= 2.0], np.tile([2.0, 0.0, 0.0], (MOST, 1)))
    turned = np.angle(1j * (hub[:, 0] + 1j * hub[:, 3]) ** 2)  # about z, from the orientation of the state
    np.testing.assert_allclose(turned[time < 2.0], 0.0, rtol=0, atol=1e-14)
    np.testing.assert_allclose(turned[time >= 2.0], 2.0 * AMPLITUDE * np.cos(phase), rtol=0, atol=1e-14)


def test_the_page_names_the_modes(motions):
    [run] = open_runs([motions])
    data = page_data(run)
    assert [(one["time"], one["name"]) for one in data["events"]] == [
        (1.0, "mode 1: 2 Hz, damping 0.01"), (2.0, "mode 2: 5 Hz"),
    ]  # fmt: skip
    assert data["axis"] == ("mode", "") and [shape["name"] for shape in data["shapes"]] == ["shaft"]


def test_a_file_of_modes_is_animated(tmp_path):
    """The modes of a mass between springs, from their file to the page."""
    path = tmp_path / "a_modes.h5"
    (tmp_path / "a.yaml").write_text(textwrap.dedent(ROW))
    mecano.modes(tmp_path / "a.yaml", path)
    assert re.search("mode [123]: 1.5915 Hz", animate(path, tmp_path / "page.html").read_text())  # sqrt(100)/(2 pi)
    with pytest.raises(UsageError, match="is a file of modes, which has no plots over time"):
        animate(path, tmp_path / "page.html", ["tip.position"])


def test_without_modes_there_is_nothing_to_play(tmp_path):
    nothing = replace(modes_file(), values=np.zeros(0, complex))
    with pytest.raises(ResultsError, match="nothing moves, so there are no shapes to draw"):
        write_motions(nothing, tmp_path / "none.h5")

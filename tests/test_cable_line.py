"""Cables with a mesh: the chain in which they hang, their vibrations, what they refuse, how they are drawn."""

import math

import numpy as np
import pytest
from time_runs import deck

from mecano.analyses.dynamic import run
from mecano.analyses.modal import modes
from mecano.elements import KINDS
from mecano.errors import DeckError
from mecano.post.runs import open_runs
from mecano.post.shapes import Motion, shapes

ROPE = """mecano: 1
gravity: [0, 0, -9.81]
nodes:
  a: {{position: [0, 0, 0], fixed: true}}
  b: {{position: [3, 1, 2], fixed: true}}
elements:
  rope: {{type: cable, nodes: [a, b], axial_stiffness: 50 kN, mass_per_length: 2, {more}}}
{rest}
time: {{end: 0.1, step: 1.0e-2}}
"""


def rope(more, rest=""):
    """Return the deck of a rope."""
    return deck(ROPE.format(more=more, rest=rest))


@pytest.mark.parametrize(("n", "longer"), [(2, 1.1), (7, 1.00001), (30, 1.3), (500, 8.0)])
def test_the_elements_hang_as_a_chain(n, longer):
    """They are equally long, just taut, and the slope grows equally: the horizontal force is constant."""
    a, b, down = np.array([0.3, -1.0, 0.2]), np.array([2.0, 0.4, 1.1]), np.array([0.2, 0.3, -2.0])
    d = rope("mesh: 2").values["elements"]["rope"]
    d = {**d, "mesh": n, "sag": down, "natural_length": longer * np.linalg.norm(b - a)}
    nodes = [(a, np.eye(3)), (b, np.eye(3))]
    assert KINDS["cable"].check(d, nodes) == []
    inner, pieces = KINDS["cable"].divide(d, nodes)
    steps = np.diff([a, *(x for x, _ in inner), b], axis=0)
    np.testing.assert_allclose(np.linalg.norm(steps, axis=1), (1.0 + 1e-6) * d["natural_length"] / n, rtol=1e-10)
    assert {piece["natural_length"] for piece in pieces} == {d["natural_length"] / n}
    up = -down / np.linalg.norm(down)
    across = steps - np.outer(steps @ up, up)
    flat = np.cross(across[0], across)
    np.testing.assert_allclose(flat, 0.0, atol=1e-10 * np.abs(across).max() ** 2)
    slopes = steps @ up / np.linalg.norm(across, axis=1)
    np.testing.assert_allclose(np.diff(slopes), (slopes[-1] - slopes[0]) / (n - 1), rtol=1e-6)
    assert slopes[-1] > slopes[0]


def test_a_rope_without_damping_starts(tmp_path):
    """Elements between taut and slack would have events without end at the start."""
    ended = run(rope("mesh: 50, natural_length: 4.2, sag: [0, 0, -1]"), tmp_path / "rope.h5").motion
    assert ended.t == pytest.approx(0.1)


def test_a_stretched_cable_vibrates_as_a_string(verify):
    """Masses and springs across of n elements, consistent: w^2 = 6 N/(m d) (1 - cos p)/(2 + cos p), p = k pi/n."""
    n, span, N, EA = 40, math.sqrt(14.0), 2000.0, 5e4
    _, found, _ = modes(rope(f"mesh: {n}, pretension: {N}"), None, number=6)
    element, mass = span / n, 2.0 * span / n / (1.0 + N / EA)
    p = np.array([1, 1, 2, 2, 3, 3]) * math.pi / n
    exact = np.sqrt(6.0 * N / (mass * element) * (1.0 - np.cos(p)) / (2.0 + np.cos(p))) / (2.0 * math.pi)
    verify("Cables", "string of 40 cables: six frequencies [Hz]", found.frequency, exact, "closed form", relative=1e-9)


@pytest.mark.parametrize(
    ("more", "text"),
    [
        ("mesh: 0", "must be 1 to 10000"),
        ("mesh: 4, release: {time: 1}", "no 'release': give it to a cable of one element"),
        ("mesh: 4, activate: {time: 1}", "no 'activate'"),
        ("mesh: 4, natural_length: 9, payout_tension: 10", "no 'payout_tension'"),
        ("mesh: 4, natural_length: 9, at_full_length: hold", "no 'at_full_length'"),
        ("mesh: 4, natural_length: {linear: {slope: 0.1, offset: 3}}", "is a number: wind up a cable of one element"),
        ("mesh: 4, natural_length: 4 + 0.1*time", "is a number"),
        ("mesh: 4, sag: [0, 0, -1]", "needs a 'natural_length' greater than 3.74166 m"),
        ("mesh: 4, sag: [0, 0, -1], natural_length: 3.7", "needs a 'natural_length' greater"),
        ("mesh: 4, sag: [-3, -1, -2], natural_length: 4", "must not point along the line of its nodes"),
        ("mesh: 4, sag: [0, 0, -1], natural_length: 20", "4 elements cannot hang between its nodes"),
    ],
)
def test_wrong_divisions(more, text):
    with pytest.raises(DeckError, match=text):
        rope(more)


def test_a_sag_of_one_element_has_no_effect():
    (warning,) = [problem.message for problem in rope("sag: [0, 0, -1], natural_length: 4").warnings]
    assert "'sag' has no effect" in warning and "give the cable a 'mesh'" in warning


def test_formulas_do_not_read_a_divided_cable():
    with pytest.raises(DeckError, match="divided by its 'mesh'; end it with an element of its own"):
        rope("mesh: 4", "signals: {pull: rope.tension}")


def test_the_line_through_all_nodes_is_drawn(tmp_path):
    path = tmp_path / "rope.h5"
    run(rope("mesh: 5, natural_length: 5, sag: [0, 0, -1]"), path)
    [found] = open_runs([path])
    (line,) = [shape for shape in shapes(Motion(found, slice(1))) if shape.name == "rope"]
    assert line.nodes == ("a", "rope.1", "rope.2", "rope.3", "rope.4", "b")
    assert line.points[0, 1:5, 2].min() < -0.5

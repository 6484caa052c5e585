"""Drag on nodes and loads along lines of nodes against closed forms."""

import math

import numpy as np
import pytest
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.static import run
from mecano.deck.format import deck_error_text
from mecano.deck.read import deck_of_bytes
from mecano.errors import DeckError
from mecano.results.reader import open_results

S, g = "Loads of air", 9.81


def test_a_parachute_reaches_its_terminal_speed(verify):
    V = math.sqrt(2 * 100 * g / (1.225 * 1.5 * 50))
    falls = [
        -RecordedRun(input_deck("parachute", f"time.step={h}"))["nodes/load/position"][-1, 2] for h in (1e-2, 5e-3)
    ]
    way = V**2 / g * math.log(math.cosh(2 * g / V))
    verify.second_order(S, "parachute: way in 2 s [m]", *falls, way, 1e-6, "closed form")


GUST = """
    mecano: 1
    gravity: none
    nodes: {body: {position: [0, 0, 0]}}
    elements: {body: {type: point_mass, node: body, mass: 2}}
    loads: {wind: {type: drag, node: body, area: 0.5, coefficient: 0.8, density: 2, direction: [0, 3, 4], speed: SPEED}}
    time: {end: 3, step: 2.0e-3}
"""


def test_a_stream_takes_a_body_along():
    """w - v = w/(1 + k w t) with k = rho c_d A/2m; the energy that the stream gives is moved or dissipated."""
    recorded = RecordedRun(deck(GUST.replace("SPEED", "10")))
    speed = recorded["nodes/body/velocity"] @ [0, 0.6, 0.8]
    k = 0.5 * 2 * 0.8 * 0.5 / 2
    np.testing.assert_allclose(speed, 10 - 10 / (1 + 10 * k * recorded.time), atol=1e-4)
    assert recorded["nodes/body/velocity"][:, 0].any() == 0
    given, dissipated = recorded["energy/given"][-1], recorded["energy/dissipated"][-1]
    assert given - dissipated == pytest.approx(speed[-1] ** 2, rel=1e-4) and dissipated > 0.0


def test_a_stream_needs_speed_and_direction():
    with pytest.raises(DeckError) as info:
        deck_of_bytes(GUST.replace(", speed: SPEED", "").replace("\n    ", "\n").strip().encode(), "deck.yaml")
    assert "'direction' and 'speed' of the stream belong together" in deck_error_text(info.value)


def mast(n, folder, *more):
    """Return position of the top [m] and moment at the foot [N m] with n elements."""
    path = folder / f"{n}{len(more)}.h5"
    line = ", ".join(["foot", *(f"mast.{i}" for i in range(1, n)), "top"])
    changes = (f"elements.mast.mesh={n}", f"loads.wind.line=[{line}]", *more)
    run(input_deck("mast_in_wind", *changes), path)
    with open_results(path) as results:
        return results["top.position"].values[-1], results["joints.foot.moment"].values[-1]


def test_wind_on_a_mast(verify, tmp_path):
    """The loads at the nodes of n elements are a trapezoidal rule, with an error of 1/3 n^2."""
    inertia = math.pi / 64 * (0.12**4 - 0.108**4)
    (coarse, _), (fine, moment) = mast(4, tmp_path), mast(8, tmp_path)
    bent, shear = 20 * 10**4 / (8 * 210e9 * inertia), 20 * 10**2 / (2 * 0.533 * 210e9 / 2.6 * math.pi * 0.006 * 0.114)
    exact = bent + shear  # 0.533: shear coefficient of the tube (Cowper 1966)
    assert coarse[0] / exact - 1 == pytest.approx(1 / 48, rel=0.02)
    verify(S, "mast in the wind: top [m]", (4 * fine[0] - coarse[0]) / 3, exact, "Bernoulli, Cowper", relative=2e-5)
    verify(S, "mast in the wind: moment at the foot [N m]", np.linalg.norm(moment), 1000.0, "Bernoulli", relative=1e-4)


def test_pressure_follows_a_beam(tmp_path):
    """A load that follows bends a soft mast further than one of a fixed direction, and shortens it more."""
    fixed, _ = mast(4, tmp_path, "loads.wind.value=4000")
    follows, _ = mast(4, tmp_path, "loads.wind.value=4000", "loads.wind.follows=true")
    assert follows[2] < fixed[2] < 9.9


def test_errors_of_a_line():
    with pytest.raises(DeckError) as info:
        input_deck("mast_in_wind", "loads.wind.line=[foot]")
    assert "'line' must name at least 2 nodes" in deck_error_text(info.value)

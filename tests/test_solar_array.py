"""The four-panel array of inputs/: momentum, synchronisation, and modes at rest after its latches."""

import numpy as np
import pytest
from time_runs import INPUTS, deck

from mecano.analyses.dynamic import run
from mecano.analyses.modal import modes
from mecano.deck.read import read_deck
from mecano.results.reader import open_results
from mecano.study.grammar import OF_EVENTS
from mecano.study.outputs import Output

STRAIGHT = """
    mecano: 1
    gravity: none
    nodes:
      bus: {position: [0, 0, 0]}
      root: {position: [0, 0.8, 0]}
      tip: {position: [0, 8.8, 0]}
    sections:
      panel: {type: stiffness, EA: 2 MN, GA2: 1 MN, GA3: 1 MN, GJ: 2000 N m2, EI2: 3000 N m2, EI3: 1 MN m2,
              mass_per_length: 4, rotary_inertia: [0.5, 0.05, 0.45], damping: 1 ms}
    elements:
      satellite: {type: rigid_body, node: bus, attached: [root], mass: 900 kg, inertia: [500, 400, 600]}
      array: {type: beam, nodes: [root, tip], section: panel, up: [1, 0, 0], mesh: 8}
    time: {end: 1, step: 0.1}
    """


@pytest.fixture(scope="module")
def deployed(tmp_path_factory):
    path = tmp_path_factory.mktemp("array") / "array.h5"
    run(read_deck(INPUTS / "solar_array.yaml"), path)
    return path


def test_hinges_turn_together_until_all_lock_at_once(deployed):
    with open_results(deployed) as results:
        locks = [event for event in results.events if event.name == "locks"]
        assert len(locks) == 4 and np.ptp([event.time for event in locks]) < 1e-9
        angle = {i: results[f"joints/hinge{i}/angle"].values for i in (1, 2, 3, 4)}
        for i in (2, 3, 4):
            np.testing.assert_allclose(angle[i], 2.0 * angle[1], atol=1e-8)
        assert angle[1][-1] == pytest.approx(np.pi / 2, abs=1e-8)


def test_the_centre_of_mass_stays_and_the_satellite_turns_back(deployed):
    """Without outer forces, the satellite moves against the array: sum m x stays zero."""
    with open_results(deployed) as results:
        x = results["nodes/bus/position"].values
        array = 0.0
        for i in range(1, 5):  # two elements of 4 kg, whose ends carry their mass alike, as far as they are straight
            inner, middle, outer = (
                results[f"nodes/{name}/position"].values for name in (f"inner{i}", f"panel{i}.1", f"outer{i}")
            )
            array = array + 2.0 * (inner + 2.0 * middle + outer)
        centre = (900.0 * x + array) / 932.0
        np.testing.assert_allclose(centre, np.broadcast_to(centre[0], centre.shape), atol=1e-4)


def test_a_study_takes_times_impulses_and_losses_of_shocks(deployed):
    with open_results(deployed) as results:
        lock = next(e for e in results.events if e.name == "locks" and results.subject(e)[1] == "hinge1")
        taken = {take: Output("x", None, "hinge1 locks", take).value(results) for take in OF_EVENTS}
        assert taken == {
            "first": (lock.time, "s"),
            "last": (lock.time, "s"),
            "count": (1.0, ""),
            "impulse": (abs(lock.impulse), "N m s"),
            "energy_lost": (lock.energy_lost, "J"),
        }
        extremes = results.extremes["joints/hinge1/latch_moment"]
        largest, unit = Output("x", "hinge1.latch_moment", None, "largest").value(results)
        assert (largest, unit) == (max(extremes.maximum, extremes.minimum, key=abs), "N m")
        every = [e for e in results.events if e.name == "locks"]
        assert len(every) > 1
        lost, unit = Output("x", None, "* locks", "energy_lost").value(results)
        assert (lost, unit) == (pytest.approx(sum(e.energy_lost for e in every), rel=1e-12), "J")
        impulse = Output("x", None, "hinge? locks", "impulse").value(results)
        assert impulse == (max(abs(e.impulse) for e in every if results.subject(e)[1].startswith("hinge")), "N m s")
        never = [Output("x", None, "hinge1 releases", take).value(results) for take in OF_EVENTS]
        np.testing.assert_equal(never, [(np.nan, "s"), (np.nan, "s"), (0.0, ""), (np.nan, ""), (0, "J")])


def test_modes_at_rest_are_those_of_the_straight_array(deployed, verify):
    """Latches and cables repeat one another; the modes are those of one beam on the satellite."""
    _, at_rest, _ = modes(read_deck(INPUTS / "solar_array.yaml"), None, at=f"{deployed}:25", at_rest=True, number=12)
    _, straight, _ = modes(deck(STRAIGHT), None, number=12)
    found, known = (np.sort(m.values.imag[m.values.imag > 0.1]) / (2 * np.pi) for m in (at_rest, straight))
    assert len(found) == len(known) == 6
    verify("Modes", "array at rest after its latches [Hz]", found, known, "straight beam", relative=1e-6)

"""Values saved between two steps never exceed those of the steps."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from time_runs import deck as deck_of
from time_runs import input_deck

from mecano.analyses.dynamic import run
from mecano.analyses.recorder import Recorder
from mecano.results.reader import open_results

DECKS = sorted(path.stem for path in (Path(__file__).parent.parent / "inputs").glob("*.yaml"))
MORE = [pytest.param(name, marks=pytest.mark.slow) for i, name in enumerate(DECKS) if i % 4]
ENDS = {  # [s] of decks of many steps, of which a beginning with events is enough
    "andrews": 0.01, "anti_skid": 1.5, "ball_on_turntable": 3.0, "crosswind_landing": 0.8, "flexible_ring": 0.1,
    "flexible_slider_crank": 0.02, "four_bar": 1.0, "friction_pendulum": 2.0, "n_four_bar": 2.0,
    "nose_gear_rigid": 2.0, "nose_landing_gear": 1.5, "reflector": 1.2, "reflector_template": 1.2,
    "shimmy_freeplay": 0.7, "sleigh": 2.0, "solar_array": 5.0, "superelement_arm": 4.0, "trailing_wheel_bump": 0.3,
    "twin_wheel_gear": 0.8, "two_bodies": 1.0,
}  # fmt: skip


def motions(sampler):
    """Which numbers of a row are positions, velocities, coordinates with their rates, or geometric: (n,) bool."""
    found = np.zeros(len(sampler.row), bool)
    found[: sampler.node_size] = True
    found[sampler.pairs.ravel()] = found[sampler.geometric] = True
    found[(sampler.rotations[:, None] + np.arange(4)).ravel()] = True
    return found


@pytest.mark.parametrize("name", [*DECKS[::4], *MORE])
def test_no_saved_value_lies_beyond_those_of_the_steps_around_it(name, tmp_path, monkeypatch):
    """Forces, energies, slips and all that is no motion; and nothing that is saved exceeds the extremes."""
    deck = input_deck(name, *([f"time.end={ENDS[name]}"] if name in ENDS else []))
    if deck.values["static"]:
        pytest.skip("points of a path are saved as they are")
    checked, recorders, row0 = [], [], []

    def restarted(recorder, state, **passing):
        original(recorder, state, **passing)
        recorders[:], row0[:] = [recorder], [recorder.row.copy()]

    def check(accepted):
        recorder, row = recorders[0], recorders[0].row
        rows = recorder.output.rows[: recorder.output.record["n_rows"][0], 1:]
        if len(rows):
            compare(accepted, recorder, row, rows)
        row0[:] = [row.copy()]

    def compare(accepted, recorder, row, rows):
        around = [row0[0], row]
        if accepted.h and accepted.info.stages:
            around = [row0[0], *recorder.output.stage_rows, row]
        low, high = np.min(around, axis=0), np.max(around, axis=0)
        outside = (((rows < low) | (rows > high)) & ~motions(recorder.sampler)).any(axis=0)
        assert not outside.any(), [
            c.path for c in recorder.sampler.columns if outside[c.start : c.start + c.size].any()
        ]
        checked.extend(rows)
        recorder.flush()

    original = Recorder.restarted
    monkeypatch.setattr(Recorder, "restarted", restarted)
    run(deck, tmp_path / "r.h5", observers=(check,))
    with h5py.File(tmp_path / "r.h5") as file:
        rows = file["storage/output"][:, 1:]
        count = file["run/acknowledged"][0]
        high, low = file["extremes/maximum"][:].max(0), file["extremes/minimum"][:].min(0)
    assert np.all(rows[:count] <= high) and np.all(rows[:count] >= low)
    assert checked or deck.values["output"]["every"] == "step" or not deck.values["time"]["adaptive"]


BALL = """
    mecano: 1
    gravity: [0, 0, -8]
    nodes: {ball: {position: [0, 0, 1]}}
    grounds: {table: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
    elements:
      body: {type: point_mass, node: ball, mass: 1}
      floor: {type: plane_contact, node: ball, ground: table, restitution: 0.5}
    time: {end: 0.6, step: 0.01}
    output: {every: EVERY}
    """


@pytest.mark.parametrize("every", ["step", "0.5", "0.025"])
def test_the_row_at_the_time_of_an_event_holds_the_values_before_it(every, tmp_path):
    """A ball falls from 1 m with 8 m/s2: it meets the floor at 0.5 s with 4 m/s and rebounds with 2 m/s."""
    run(deck_of(BALL.replace("EVERY", every)), tmp_path / "ball.h5")
    with h5py.File(tmp_path / "ball.h5") as file:
        time, velocity = file["time"][:], file["nodes/ball/velocity"][:, 2]
        (at,) = np.flatnonzero(np.abs(time - 0.5) < 1e-9)
        np.testing.assert_allclose(file["events/event_time"][:], 0.5, rtol=1e-12)
        np.testing.assert_allclose(velocity[at], -4.0, rtol=1e-12)
        np.testing.assert_allclose(velocity[at + 1], 2.0 - 8.0 * (time[at + 1] - 0.5), rtol=1e-12)
    with open_results(tmp_path / "ball.h5") as results:
        of_velocity = results.extremes["nodes/ball/velocity.z"]
    np.testing.assert_allclose([of_velocity.maximum, of_velocity.minimum], [2.0, -4.0], rtol=1e-12)
    np.testing.assert_allclose([of_velocity.maximum_time, of_velocity.minimum_time], 0.5, rtol=1e-12)


@pytest.mark.parametrize("method", ["generalized_alpha", "radau"])
def test_geometric_outputs_are_those_of_the_saved_motion(method, tmp_path):
    """The length of a rope, also a slack one in free fall, is the distance of its node from the origin."""
    control = f"time.method={method}", "time.adaptive={tolerance: 1.0e-4}"
    run(input_deck("cable_snatch", *control), tmp_path / "r.h5")
    with open_results(tmp_path / "r.h5") as results:
        within = ~np.isin(results.time, results.steps["time"])
        length = np.linalg.norm(results["nodes/load/position"].values, axis=1)
        np.testing.assert_allclose(results["elements/rope/length"].values, length, rtol=1e-12)
    assert within.sum() > 50

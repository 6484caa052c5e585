"""Output of `mecano run`: saved times and extremes, against a run of the same deck that saves every step."""

import signal

import numpy as np
import pytest
from process import mecano_process, settings
from time_runs import INPUTS, input_deck

import mecano
from mecano.analyses.checkpoint_writer import CheckpointWriter
from mecano.analyses.dynamic import run
from mecano.analyses.prepare import prepare
from mecano.elements import KINDS
from mecano.errors import NonFiniteError
from mecano.model.sampler import Sampler
from mecano.model.system import System
from mecano.process.interrupt import Interruption, Stopped
from mecano.solve.time.time_integration import TimeIntegrator

DECKS = {  # deck: overrides, interval of saving [s], what peaks between the saved times
    "wheel_drop": (["parameters.wave_amplitude=0.02"], 0.03, "elements/tire/radial_force"),
    "double_pendulum": (["time.end=1"], 0.0137, "joints/elbow_hinge/rate"),
    "strut": (["time.end=1"], 0.05, "elements/strut/stroke"),
}
COORDINATES = [output for kind in KINDS.values() for output in kind.outputs if output.rate]
MOTIONS = {name for output in COORDINATES for name in (output.name, output.rate)}


def run_of(name, path, *overrides):
    """A process of its own: `mecano run` of a deck of inputs/ to a file."""
    assert mecano_process("run", INPUTS / f"{name}.yaml", "-q", "-o", path, *settings(*overrides)) == (0, "", "")
    return mecano.open_results(path)


@pytest.fixture(scope="module", params=DECKS)
def both(request, tmp_path_factory):
    """(every step, saved now and then, interval, what peaks) of one deck."""
    name, folder = request.param, tmp_path_factory.mktemp(request.param)
    overrides, every, peaking = DECKS[name]
    whole = run_of(name, folder / "whole.h5", *overrides, "output.every=step")
    thin = run_of(name, folder / "thin.h5", *overrides, f"output.every={every}")
    with whole, thin:
        yield whole, thin, every, peaking


MODELS = {"double_pendulum": (2.0, 16, 2), "wheel_drop": (20.0, 6, 6), "strut": (500.0, 5, 1)}


def test_the_model_is_counted_in_the_file(both):
    """Mass [kg], unknowns, mobility: two bodies of 1 kg on two pins, a free rim, a head that only rises and falls."""
    model = both[0].model
    name = both[0].metadata["deck_path"].rpartition("/")[2].removesuffix(".yaml")
    assert (model["mass"], model["unknowns"], model["mobility"]) == MODELS[name]
    assert model["unknowns"] == model["degrees_of_freedom"] + model["multipliers"]
    assert model["redundant_constraints"] == 0


def test_saving_does_not_change_the_steps(both):
    whole, thin, _, _ = both
    assert np.array_equal(whole.steps, thin.steps) and len(whole.steps) > 100
    assert whole.events == thin.events
    assert np.array_equal(whole.time[1:], whole.steps["time"])


def test_saved_times_are_the_multiples_and_the_end(both):
    whole, thin, every, _ = both
    end = whole.time[-1]
    multiples = every * np.arange(int(end / every * (1 + 1e-12)) + 1)
    wanted = multiples if abs(multiples[-1] - end) < 1e-9 else np.append(multiples, end)
    np.testing.assert_allclose(thin.time, wanted, rtol=0, atol=1e-15)


def test_saved_motion_is_the_cubic_between_the_steps(both):
    """Position and velocity at both ends of the step that covers the time; to rounding, since nothing else enters."""
    whole, thin, _, _ = both
    t, compared = whole.time, 0
    for name in (path for path in thin.names("nodes/*") if path.endswith("/position")):
        x, v = whole[name].values, whole[name.replace("position", "velocity")].values
        i = np.clip(np.searchsorted(t, thin.time, side="left") - 1, 0, len(t) - 2)
        h, u = (t[i + 1] - t[i])[:, None], ((thin.time - t[i]) / (t[i + 1] - t[i]))[:, None]
        cubic = (1 + 2 * u) * (1 - u) ** 2 * x[i] + u**2 * (3 - 2 * u) * x[i + 1]
        cubic += h * u * (1 - u) * ((1 - u) * v[i] - u * v[i + 1])
        np.testing.assert_allclose(thin[name].values, cubic, rtol=0, atol=1e-12 * np.abs(x).max(), err_msg=name)
        compared += int(np.sum((u > 1e-3) & (u < 1 - 1e-3)))
    assert compared > 20  # most saved times lie within steps


def test_saved_outputs_lie_on_the_curves_of_the_steps(both):
    """All of them: off the straight line between the ends of the step by a fifth of what they change around it."""
    whole, thin, _, _ = both
    t = whole.time
    i = np.clip(np.searchsorted(t, thin.time, side="left") - 1, 0, len(t) - 2)
    energy = max(np.abs(whole[f"energy/{name}"].values).max() for name in ("kinetic", "potential"))
    for name in thin.names():
        if name.endswith("/rotation"):
            continue
        y = whole[name].values
        u = ((thin.time - t[i]) / (t[i + 1] - t[i])).reshape(-1, *[1] * (y.ndim - 1))
        around = np.stack([y[np.clip(i + k, 0, len(t) - 1)] for k in (-1, 0, 1, 2)])
        rounding = 1e-5 * energy if name.startswith("energy/") else 1e-9 * np.abs(y).max()
        off = np.abs(thin[name].values - ((1 - u) * y[i] + u * y[i + 1]))
        assert np.all(off <= 0.2 * np.ptp(around, axis=0) + rounding), name


def test_extremes_are_those_of_all_steps(both):
    """Bit for bit, with the times at which they were first reached, whatever is saved; motions peak within a step."""
    whole, thin, _, peaking = both
    behind = {event.time for event in whole.events}  # where values jump: rows have those before
    for name, extreme in thin.extremes.items():
        of_steps, values = whole.extremes[name], whole[name].values
        high, low = int(np.argmax(values)), int(np.argmin(values))
        for found, i in (
            ((of_steps.maximum, of_steps.maximum_time), high),
            ((of_steps.minimum, of_steps.minimum_time), low),
        ):
            assert found == (values[i], whole.time[i]) or found[1] in behind, name
        assert of_steps.maximum >= values[high] and of_steps.minimum <= values[low], name
        if extreme != of_steps:
            assert name.startswith("nodes/") or name.rpartition("/")[2].partition(".")[0] in MOTIONS, name
            peak = 0.01 * np.ptp(values)  # of a wheel that turns by 0.2 rad in a step
            assert 0.0 <= extreme.maximum - of_steps.maximum <= peak, name
            assert 0.0 <= of_steps.minimum - extreme.minimum <= peak, name
    saved = np.abs(thin[peaking].values).max()
    extreme = thin.extremes[peaking]
    assert max(extreme.maximum, -extreme.minimum) > 1.0001 * saved  # a peak that the saved times miss


def test_saving_within_one_step_looks_at_signals(tmp_path, monkeypatch):
    """A signal that comes while 100,000 times of one step are being saved ends the run after some thousands."""
    interruption = Interruption()
    monkeypatch.setattr(interruption, "_number", signal.SIGTERM)
    # it came after the last question of the step
    monkeypatch.setattr(CheckpointWriter, "__call__", lambda writer, run: None)
    deck = input_deck("free_body", "time={end: 10, step: 1}", "output.every=1.01e-5")
    with pytest.raises(Stopped, match="stopped by SIGTERM between two saved times of a step"):
        run(deck, tmp_path / "r.h5", interruption=interruption)
    with mecano.open_results(tmp_path / "r.h5") as results:
        assert results.status == "stopped" and 1000 < len(results.time) < 20_000


def test_an_energy_that_is_not_finite_is_that_of_an_element(tmp_path, monkeypatch):
    """A cable has no output of its own mass: only the kinetic energy of all depends on it."""
    observe, times = System.observe, []

    def spoiled(system, s, *at):
        times.append(s.t)
        if len(times) > 4:
            next(batch for batch in system.batches if batch.names[0] == "cable 'cable'").p["mass"] = np.nan
        return observe(system, s, *at)

    monkeypatch.setattr(System, "observe", spoiled)
    monkeypatch.setattr(TimeIntegrator, "ordinary", lambda integrator, run, stop: (run, None, True))
    with pytest.raises(NonFiniteError, match="t = .* s: cable 'cable': "):
        run(input_deck("winder", "time.end=0.05", "output.every=step"), tmp_path / "r.h5")


def test_an_output_that_is_not_finite_ends_the_run_and_stands_in_no_file(tmp_path, monkeypatch):
    observe = System.observe

    def spoiled(system, s, *at):
        found = observe(system, s, *at)
        if s.t > 0.0195:
            found.outputs[column] = np.nan
        return found

    deck = input_deck("pendulum", "output.every=step")
    sampler = Sampler(prepare(deck).system)
    column = next(c.start for c in sampler.columns if c.path == "joints/hinge/angle") - sampler.node_size
    monkeypatch.setattr(System, "observe", spoiled)
    monkeypatch.setattr(TimeIntegrator, "ordinary", lambda integrator, run, stop: (run, None, True))
    with pytest.raises(NonFiniteError, match="t = .* s: hinge 'hinge': angle is not finite"):
        run(deck, tmp_path / "r.h5")
    with mecano.open_results(tmp_path / "r.h5") as results:
        assert results.status == "failed" and len(results.time) == 20 == len(results.steps) + 1
        assert np.isfinite(results["hinge.angle"].values).all()

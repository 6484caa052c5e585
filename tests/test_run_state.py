"""The state of a run is one value: saved, loaded and continued, it gives the same bits."""

import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
import surviving
from time_runs import deck, in_python, input_deck

from mecano.analyses.prepare import integrator_of, prepare
from mecano.errors import Failure
from mecano.results.state import load_state, save_state
from mecano.solve.time.generalized_alpha import GeneralizedAlpha
from mecano.solve.time.run_state import from_plain, to_plain
from mecano.solve.time.step_info import StepInfo
from mecano.solve.time.time_integration import TimeIntegrator

DECK = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      a: {position: [0, 0, 0]}
      b: {position: [1, 0, 0]}
      c: {position: [1, 0, 0]}
    elements:
      upper: {type: rigid_body, node: a, mass: 1, center_of_mass: [0.5, 0, 0], inertia: [0.01, 0.1, 0.1], attached: [b]}
      lower: {type: rigid_body, node: c, mass: 1, center_of_mass: [0.5, 0, 0], inertia: [0.01, 0.1, 0.1]}
    joints:
      shoulder: {type: hinge, nodes: [ground, a], axis: [0, 1, 0]}
      elbow: {type: hinge, nodes: [b, c], axis: [0, 1, 0.2]}
    time: {end: 1.0, step: 0.005, %s}
"""


@pytest.mark.parametrize("control", ["rho_inf: 0.9", "adaptive: {tolerance: 1.0e-3}"])
def test_a_run_continues_from_its_saved_state_with_the_same_bits(control, tmp_path):
    checked = deck(DECK % control)
    prepared = prepare(checked)
    integrator = integrator_of(prepared)
    middle = integrator.to(0.5, integrator.begin(prepared.state, 0.005))
    end = integrator.to(1.0, middle)
    with h5py.File(tmp_path / "state.h5", "w") as file:
        save_state(file, "middle", to_plain(middle))
        loaded = from_plain(load_state(file["middle"]))
    again = prepare(checked)
    other = integrator_of(again).to(1.0, loaded)
    assert other.steps == end.steps > 100
    assert np.array_equal(other.motion.z, end.motion.z) and np.array_equal(other.motion.R, end.motion.R)
    assert other.dissipated == end.dissipated and other.h == end.h


IN_VAIN = """
from mecano.solve.time import step_change
step_change.ACCEPT_BELOW = -1.0  # as where the fixed order of elimination does not factor the matrix
from time_runs import in_python, input_deck
from mecano.analyses.initial_state import set_initial_state
from mecano.analyses.prepare import integrator_of, prepare
from mecano.errors import Failure
from mecano.solve.time.generalized_alpha import GeneralizedAlpha

change, changes, ends = GeneralizedAlpha._change_with_superlu, [], []
GeneralizedAlpha._change_with_superlu = lambda self, tangent: changes.append(tangent) or change(self, tangent)
checked = input_deck("nose_gear_rigid", "time.end=0.1")
for observers, alter in (((), id), ((lambda accepted: None,), id), ((), in_python)):
    prepared = prepare(checked)
    set_initial_state(prepared)
    integrator = integrator_of(prepared, observers)
    alter(integrator)
    run = integrator.to(0.1, integrator.begin(prepared.state, checked.values["time"]["step"]))
    ends.append((run.motion.z.tobytes(), run.steps, run.iterations))
assert len(changes) > 30 and len(set(ends)) == 1, [end[1:] for end in ends]
"""


def test_changes_of_step_size_that_compiled_code_cannot_make_give_the_same_bits():
    """Many steps in one call, one in each call, and all of them by Python."""
    subprocess.run([sys.executable, "-c", IN_VAIN], cwd=Path(__file__).parent, check=True)


def test_rejected_steps_leave_nothing_behind():
    prepared = prepare(deck(DECK % "rho_inf: 0.9"))
    integrator = integrator_of(prepared)
    plain = integrator.to(1.0, integrator.begin(prepared.state, 0.005))
    integrator = integrator_of(prepare(deck(DECK % "rho_inf: 0.9")))
    step, calls = integrator.method.step, []

    def every_third_twice(s, history, h):
        calls.append(h)
        if len(calls) % 3 == 0:
            step(s, integrator.method.restart(s, history, 0.3 * h), 0.3 * h)
        return step(s, history, h)

    integrator.method.step = every_third_twice
    in_python(integrator)
    disturbed = integrator.to(1.0, integrator.begin(prepared.state, 0.005))
    assert len(calls) >= 200
    assert np.array_equal(disturbed.motion.z, plain.motion.z)


def test_a_step_that_is_left_among_its_trials_leaves_the_method_as_it_was():
    """A Simulation may continue after Ctrl-C: later steps must not be judged as those after a failed trial."""
    prepared = prepare(input_deck("pendulum"))
    integrator, sizes = integrator_of(prepared), []
    start = integrator.begin(prepared.state, 1e-3)

    def failing(s, history, h):
        sizes.append(h)
        if len(sizes) == 2:
            assert integrator.method.workspace.record["strict"][0]
            raise KeyboardInterrupt
        return s, history, StepInfo(False, 1, (0.0, 0.0, 0.0), np.nan, history, "", Failure.NOT_CONVERGED)

    integrator.method.step = failing
    in_python(integrator)
    with pytest.raises(KeyboardInterrupt):
        integrator.to(1.0, start)
    assert sizes == [1e-3, 0.25e-3] and not integrator.method.workspace.record["strict"][0]


def reject_every_third(integrator):
    """Let a time integration reject every third acceptable trial, and repeat it with the same size."""
    judge, accepted = integrator.trials._size_to_retry, [0]

    def instead(run, trial, h, cuts):
        smaller = judge(run, trial, h, cuts)
        accepted[0] += smaller is None
        return h if smaller is None and accepted[0] % 3 == 0 else smaller

    integrator.trials._size_to_retry = instead
    in_python(integrator)


@pytest.mark.parametrize("name", surviving.decks())
def test_every_third_trial_rejected_changes_no_bit(name):
    """With adaptive steps and fixed ones, across events, shocks and corners of laws of time."""
    checked, ends = surviving.decks()[name], []
    for disturb in (lambda integrator: None, reject_every_third):
        prepared, happened = prepare(checked), []
        tell = lambda accepted, happened=happened: happened.extend(accepted.event_records)  # noqa: E731
        usual = integrator_of(prepared)
        integrator = TimeIntegrator(
            prepared.system, usual.method, usual.control, (tell,), usual.breakpoints, usual.rest
        )
        disturb(integrator)
        start = integrator.begin(prepared.state, checked.values["time"]["step"])
        ends.append((integrator.to(checked.values["time"]["end"], start), happened))
    (plain, events), (disturbed, same) = ends
    assert disturbed.rejected > plain.rejected + plain.steps // 4 and events == same
    for one in (plain, disturbed):
        one.rejected = one.iterations = 0
        one.h = 0.0  # after the last step, which the end may have cut short, it is planned otherwise
    check_equal(to_plain(disturbed), to_plain(plain))


def check_equal(one, other, path=""):
    """Two plain states are the same, bit for bit."""
    if isinstance(one, dict):
        assert one.keys() == other.keys(), path
        for key in one:
            check_equal(one[key], other[key], f"{path}/{key}")
        return
    assert np.array_equal(one, other), path


def marched(checked, run=None, times=(), end=None):
    """Run a deck from its start, or from ``run``, via ``times`` to the end; return (RunStates at these, events)."""
    prepared, happened = prepare(checked), []
    integrator = integrator_of(prepared, (lambda accepted: happened.extend(accepted.event_records),))
    run = run or integrator.begin(prepared.state, checked.values["time"]["step"])
    runs = []
    for t in (*times, end or checked.values["time"]["end"]):
        run = integrator.to(t, run)
        runs.append(run)
    return runs, happened


FALL = 0.14278431229270644  # [s] from 0.4 m to the radius of 0.3 m: sqrt(2 x 0.1/9.81)
EVENTFUL = {  # deck, overrides, times at which the run is saved: in flight, at and after events, at corners of laws
    "wheel_drop": ((), (0.1, FALL, 0.15, 0.3)),
    "wheel_drop, fixed steps": (("time.adaptive=null",), (0.1, FALL, 0.15, 0.3)),
    "strut": (("time.end=1",), (0.05, 0.1, 0.4)),
    "nose_gear_rigid": (("time.end=0.8",), (0.001, 0.45, 0.6)),
}


@pytest.mark.parametrize("name", EVENTFUL)
def test_a_run_continues_across_events_with_the_same_bits(name, tmp_path):
    """Wherever the state is saved: what comes, events among it, is what would have come."""
    overrides, times = EVENTFUL[name]
    file_name = name.partition(",")[0]
    runs, happened = marched(input_deck(file_name, *overrides), times=times)
    left = set()
    for number, t in enumerate(times):
        with h5py.File(tmp_path / f"{number}.h5", "w") as file:
            save_state(file, "middle", to_plain(runs[number]))
            loaded = from_plain(load_state(file["middle"]))
        assert loaded.motion.t == t
        on, later = marched(input_deck(file_name, *overrides), loaded, times[number + 1 :])
        check_equal(to_plain(on[-1]), to_plain(runs[-1]))
        assert later == happened[len(happened) - len(later) :]
        assert all(h.t < t for h in happened[: len(happened) - len(later)]) or t == FALL
        left.add(len(later))
    assert len(left) >= 2 and max(left) >= 2  # events lie between the times, and after them


ARM = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {a: {position: [0, 0, 0]}, e: {position: [1, 0, 0]}, b: {position: [1, 0, 0]}}
    elements:
      arm: {type: rigid_body, node: a, mass: 2, inertia: [0.4, 0.4, 0.4], center_of_mass: [0.5, 0, 0], attached: [e]}
      fore: {type: rigid_body, node: b, mass: 1, inertia: [0.2, 0.2, 0.2], center_of_mass: [1.5, 0, 0]}
    joints:
      shoulder: {type: hinge, nodes: [ground, a], axis: [0, 1, 0]}
      elbow: {type: hinge, nodes: [e, b], axis: [0, 1, 0]}
    signals:
      torque: {type: sample_and_hold, input: 60*(0.5 - shoulder.angle) - 8*shoulder.rate, period: 3 ms}
      second: {type: sample_and_hold, input: 20*(0.2 - elbow.angle) - 2*elbow.rate, period: 1.7 ms}
      low: {type: lag, input: second, time_constant: 0.01}
    loads:
      motor: {type: joint_moment, joint: shoulder, value: torque}
      other: {type: joint_moment, joint: elbow, value: low}
      push: {type: force, node: b, direction: [0, 0, 1], value: {table: {points: [[0, 0], [0.03, 5], [1, 0]]}}}
    time: {end: 0.1 s, step: 1 ms}
    """
ALSO = "axis: [0, 1, 0]}\n    signals"  # behind the elbow
SAMPLED = {
    "fixed steps": (ARM, True),
    "adaptive steps": (ARM.replace("1 ms}", "1 ms, adaptive: {tolerance: 1.0e-6}}"), True),
    "a latch that closes": (ARM.replace(ALSO, ALSO.replace("}", ", latch: {angle: -0.05}}")), True),
    "redundant joints": (
        ARM.replace(ALSO, ALSO.replace("s:", "s: [0, 1, 0]}\n      twin: {type: hinge, nodes: [e, b], axis:", 1)),
        True,
    ),
    "late torque": (
        ARM.replace("loads:", "  late: {type: delay, input: torque, time: 0.7 ms}\n    loads:").replace(
            "value: torque", "value: late"
        ),
        True,
    ),
    "friction by reactions": (
        ARM.replace(ALSO, ALSO.replace("}", ", friction: {coefficient: 0.1, radius: 0.2, regularization: 0.01}}")),
        False,
    ),
    "a signal that reads a reaction": (ARM.replace("input: second", "input: second + 0.01*elbow.force.z"), False),
}


@pytest.mark.parametrize(("text", "compiled"), SAMPLED.values(), ids=SAMPLED.keys())
def test_restarts_at_samples_in_compiled_code_change_no_bit(text, compiled, monkeypatch):
    """Where the model admits them, and where Python restarts; a call of the time loop may end at a sample."""
    found = march_sampled(deck(text))
    interrupted = march_sampled(deck(text), interrupt)
    in_steps_of_python = march_sampled(deck(text), in_python)
    monkeypatch.setattr(GeneralizedAlpha, "use_compiled_restarts", lambda self: None)
    in_python_alone = march_sampled(deck(text))
    check_equal(interrupted[0], found[0])
    check_equal(in_steps_of_python[0], found[0])
    check_equal(in_python_alone[0], found[0])
    assert found[1] <= 1 if compiled else found[1] == in_python_alone[1]  # behind the event


def interrupt(integrator):
    """Let Python look for signals of the process in each step."""
    integrator.method.patience = 0.0


def march_sampled(checked, disturb=lambda integrator: None):
    """Return the RunState after 0.1 s as plain data, and the number of restarts by Python."""
    prepared, restarts = prepare(checked), []
    integrator = integrator_of(prepared)
    start_again = integrator.start_again
    integrator.start_again = lambda *given, **more: restarts.append(given) or start_again(*given, **more)
    disturb(integrator)
    run = integrator.to(0.051, integrator.begin(prepared.state, checked.values["time"]["step"]))
    return to_plain(integrator.to(0.1, run)), len(restarts)

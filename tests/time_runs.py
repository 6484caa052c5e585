"""Dynamic runs in memory, for tests that compare motions with known solutions."""

import textwrap
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mecano.analyses.initial_state import set_initial_state
from mecano.analyses.prepare import integrator_of, prepare
from mecano.deck.read import deck_of_bytes, read_deck
from mecano.model.extremes import Extremes
from mecano.model.sampler import Sampler
from mecano.solve.time.output import Output
from mecano.solve.time.unresolved_oscillation import OscillationMonitor

INPUTS = Path(__file__).parent.parent / "inputs"


def deck(text):
    """Return the checked deck of a text with any indentation."""
    return deck_of_bytes(textwrap.dedent(text).encode(), "test.yaml")


def input_deck(name, *overrides):
    """Return the checked deck of inputs/ with overrides "a.b=value"."""
    return read_deck(INPUTS / f"{name}.yaml", overrides)


def in_python(integrator, run=None):
    """Have every step of a time integration made by Python, where a test can interfere; returns the run."""
    integrator.ordinary = lambda run, stop: (run, None, True)
    return run


def one_by_one(integrator, run):
    """Have each step made by a call of its own, after which Python looks at the run; returns the run."""
    integrator.observers = (lambda accepted: None,)
    return run


class Step(NamedTuple):
    """Newton iterations, error and norms over their tolerances (3,) of a step."""

    iterations: int
    error: float
    norms: tuple


class Rows:
    """Takes the row, the Step and the events of each step; those of compiled code from buffers, many at a time."""

    def __init__(self, sampler, integrator, time):
        self.sampler, self.observation = sampler, integrator.observation
        self.rows, self.steps, self.event_records = [], [], []
        none, times = np.zeros(0, np.int64), (time["start"], time["end"], 0.0)
        extremes = Extremes(len(sampler.row))
        self.output = Output(sampler, self.observation, extremes, OscillationMonitor(none), times, ())
        integrator.method.use_output(self.output)

    def __call__(self, accepted):
        """Take a step that Python made."""
        self.empty()
        self.event_records += accepted.event_records
        if accepted.h:
            info = accepted.info
            self.steps.append(Step(info.iterations, info.error, info.norms))
            self.take(accepted.run)

    def take(self, run):
        """Take the row of a run."""
        self.rows.append(np.concatenate([[run.motion.t], self.sampler.take(run, self.observation)])[None])

    def restarted(self, run, passing=False):
        """Begin the next step behind a jump of the forces, which rows of whole steps do not show."""

    def empty(self, again=False):
        """Take what the buffers hold."""
        rows, steps = self.output.taken()
        self.rows.append(rows.copy())
        self.steps += [Step(int(line[2]), line[3], tuple(line[6:9])) for line in steps]

    def refuse(self, t):
        """Refuse rows that are not finite."""
        raise AssertionError(f"an output is not finite at t = {t} s")


class RecordedRun:
    """A run of a deck to its end: ``time`` (n,), ``self[path]`` (n, ...) at the start and every accepted step.

    ``infos`` are the Steps, ``event_records`` the events.
    """

    def __init__(self, deck, *, start=lambda prepared: None, change=lambda integrator, run: run):
        """Run; ``start(prepared)`` may alter the state, ``change(integrator, run)`` both before the first step."""
        prepared, time = prepare(deck), deck.values["time"]
        set_initial_state(prepared)
        start(prepared)
        self.prepared, self.system = prepared, prepared.system
        self.sampler = Sampler(prepared.system)
        self.columns = {c.path: c for c in self.sampler.columns}
        self.integrator = integrator = integrator_of(prepared)
        integrator.recorder = taken = Rows(self.sampler, integrator, time)
        run = change(integrator, integrator.begin(prepared.state, time["step"]))
        taken.event_records += integrator.start_events
        taken.take(run)
        self.run = integrator.to(time["end"], run)
        taken.empty()
        rows = np.concatenate(taken.rows)
        self.time, self.rows = rows[:, 0].copy(), rows[:, 1:].copy()
        self.infos, self.event_records = taken.steps, taken.event_records

    def __getitem__(self, path):
        c = self.columns[path]
        return self.rows[:, c.start : c.start + c.size].reshape(len(self.rows), *c.shape)

    @property
    def iterations(self):
        """Newton iterations of every accepted step."""
        return np.array([info.iterations for info in self.infos])


def with_history(run, **changes):
    """Return the RunState with parts of its history replaced."""
    return replace(run, history=replace(run.history, **changes))

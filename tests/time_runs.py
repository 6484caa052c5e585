"""Dynamic runs in memory, for tests that compare motions with known solutions."""

import textwrap
from dataclasses import replace
from pathlib import Path

import numpy as np

from mecano.analyses.initial_state import set_initial_state
from mecano.analyses.prepare import integrator_of, prepare
from mecano.deck.read import deck_of_bytes, read_deck
from mecano.model.sampler import Sampler

INPUTS = Path(__file__).parent.parent / "inputs"


def deck(text):
    """Return the checked deck of a text with any indentation."""
    return deck_of_bytes(textwrap.dedent(text).encode(), "test.yaml")


def input_deck(name, *overrides):
    """Return the checked deck of inputs/ with overrides "a.b=value"."""
    return read_deck(INPUTS / f"{name}.yaml", overrides)


def in_python(integrator, run=None):
    """Have every step of a march made by Python, where a test can interfere; returns the run."""
    integrator.ordinary = lambda run, stop: (run, None, True)
    return run


class RecordedRun:
    """A run of a deck to its end: ``time`` (n,), ``self[path]`` (n, ...) at the start and every accepted step."""

    def __init__(self, deck, *, start=lambda prepared: None, change=lambda integrator, run: run):
        """Run; ``start(prepared)`` may alter the state, ``change(integrator, run)`` both before the first step."""
        prepared = prepare(deck)
        set_initial_state(prepared)
        start(prepared)
        self.prepared, self.system = prepared, prepared.system
        self.sampler = Sampler(prepared.system)
        self.columns = {c.path: c for c in self.sampler.columns}
        self.infos, self.event_records, times, rows = [], [], [], []

        def keep(run):
            times.append(run.motion.t)
            rows.append(self.sampler.take(run, integrator.observation).copy())

        def observe(accepted):
            self.event_records += accepted.event_records
            if accepted.h:
                self.infos.append(accepted.info)
                keep(accepted.run)

        integrator = integrator_of(prepared, (observe,))
        self.integrator = integrator
        run = change(integrator, integrator.begin(prepared.state, deck.values["time"]["step"]))
        self.event_records += integrator.start_events
        keep(run)
        self.run = integrator.to(deck.values["time"]["end"], run)
        self.time, self.rows = np.array(times), np.array(rows)

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

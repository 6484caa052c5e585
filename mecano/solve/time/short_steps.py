"""Stretches of a run in which steps are very short, and the unknowns whose errors limit them."""

from collections.abc import Iterator
from math import floor, log10

import numpy as np

from mecano.model.numbering import ROTATION, SIGNAL
from mecano.solve.diagnostics.failure import acting_clause
from mecano.solve.time.run_state import Method, RunState
from mecano.solve.time.step_control import StepControl
from mecano.solve.time.workspace import TRIAL

SHORT = 1e-3  # of the mean of the other steps: shorter ones are reported
MANY = 0.1  # of all steps


def changing_most(method: "Method", control: StepControl) -> int:
    """Return the index of the unknown with the largest error in the last step, as it counts; signals have none."""
    w, of, n_q = method.workspace, method.system.numbering, method.system.n_q
    change, kind = np.abs(w.history[TRIAL, :n_q] - w.carried[1, :n_q]), of.kind[:n_q]
    change[method.system.massless[:n_q]] *= control.forgotten(1.0, float(w.record["h"][0]))
    change[kind >= SIGNAL] = 0.0
    return int(np.argmax(change / np.where(kind == ROTATION, 1.0, method.length)))


class Decade:
    """Stretches whose mean steps have the same order of magnitude."""

    def __init__(self, begin: float):
        self.steps, self.time, self.begin, self.end = 0, 0.0, begin, begin  # number; total, first and last time [s]
        self.limiting: dict[int, int] = {}  # unknown -> number of stretches at whose end its error is the largest


class ShortSteps:
    """Stretches of a run by ``method`` in which steps are short."""

    def __init__(self, method: "Method", control: StepControl):
        self.method, self.control = method, control
        self._decades: dict[int, Decade] = {}

    def add(self, before: RunState, run: RunState) -> None:
        """Add the stretch from ``before`` to ``run``, where the workspace of the method has the last step."""
        steps, time = run.steps - before.steps, run.motion.t - before.motion.t
        size = floor(log10(max(time, np.finfo(float).tiny) / steps))
        decade = self._decades.setdefault(size, Decade(before.motion.t))
        decade.steps, decade.time, decade.end = decade.steps + steps, decade.time + time, run.motion.t
        i = changing_most(self.method, self.control)
        decade.limiting[i] = decade.limiting.get(i, 0) + 1

    def warnings(self, run: RunState) -> Iterator[str]:
        """Yield a warning if many of the steps of ``run`` are much shorter than the others."""
        for size in sorted(self._decades, reverse=True):
            short = [decade for key, decade in self._decades.items() if key <= size]
            steps, time = sum(decade.steps for decade in short), sum(decade.time for decade in short)
            usual = (self.control.duration - time) / max(run.steps - steps, 1)
            if steps >= MANY * run.steps and time / steps <= SHORT * usual:
                yield self._text(short, steps, run.steps, time / steps, usual)
                return

    def _text(self, short, steps, of, mean, usual):
        """Return the warning about ``steps`` of all of a run, in Decades, with their mean and the usual step [s]."""
        most = max(short, key=lambda decade: decade.steps).limiting
        worst, system = max(most, key=lambda i: most[i]), self.method.system
        begin, end = min(decade.begin for decade in short), max(decade.end for decade in short)
        return (
            f"{steps} of {of} steps, between t = {begin:.6g} s and {end:.6g} s, have {mean:.2g} s on average, "
            f"{usual / mean:.2g} times less than the others; there the acceleration changes most in "
            f"{system.numbering.name[worst].motion}{acting_clause(system, worst)}. Are stiffness, damping and "
            "frequencies there as intended? Laws without jumps, friction with a greater regularization, or mass where "
            "there is none make the steps longer"
        )

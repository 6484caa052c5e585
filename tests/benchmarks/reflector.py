"""Deployable reflectors: work and precision of one module, growth with their number.

    python tests/benchmarks/reflector.py precision | growth

Recorded in docs/examples/reflector.md.
"""

import os
import resource
import sys
import time
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

for _variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

import numpy as np

from mecano.deck.read import deck_of_bytes
from mecano.model.sampler import Sampler
from mecano.prepare import march_of, prepare

WRITER = Path(__file__).parent.parent.parent / "inputs" / "make_reflector.py"
STEPS = 0.02, 0.01, 0.005, 0.002, 0.001  # [s]; the last is the reference
MODULES = 1, 7, 19, 37
WINDER = "payout_tension: $payout_tension, "
EARLY = 0.5  # [s] of a growing reflector


def deck(*arguments, without=""):
    """A checked deck, from whose text ``without`` is taken out."""
    spec = spec_from_file_location("make_reflector", WRITER)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    text = module.deck(module.options(arguments))
    return deck_of_bytes(text.replace(without, "").encode() if without else text.encode(), "reflector")


class Deployment:
    """A deck marched to ``end`` [s], its events, the CPU [s] of preparation and march, outputs of every step."""

    def __init__(self, deck, end=None):
        begun = time.process_time()
        prepared = prepare(deck)
        march, self.happenings, rows = march_of(prepared), [], []
        sampler = Sampler(prepared.system)
        self.columns = {c.path: c for c in sampler.columns}

        def observe(accepted):
            self.happenings += accepted.happenings
            if accepted.h and not end:
                rows.append((accepted.run.motion.t, sampler.take(accepted.run).copy()))

        march.observers = (observe,)
        started = time.process_time()
        run = march.begin(prepared.state, deck.values["time"]["step"])
        self.run = march.to(end or deck.values["time"]["end"], run)
        self.preparation, self.march = started - begun, time.process_time() - started
        self.unknowns = prepared.system.n
        self.time, self.rows = np.array([t for t, _ in rows]), np.array([row for _, row in rows])

    def __getitem__(self, path):
        c = self.columns[path]
        return self.rows[:, c.start : c.start + c.size].reshape(len(self.rows), *c.shape)

    def locks(self):
        """Time and impulse of the lock of each hinge."""
        return {h.element.split("'")[1]: (h.t, h.impulse, h.lost) for h in self.happenings if h.name == "locks"}


def precision():
    """CPU and errors for several steps, against the last."""
    runs = {h: Deployment(deck("--step", str(h))) for h in STEPS}
    best = runs[STEPS[-1]]
    stress = [path for path in best.columns if path.endswith("/stress") and "ing/" in path]
    places = [path for path in best.columns if path.endswith("/position")]
    for h, run in runs.items():
        lag = max(abs(run.locks()[name][0] - t) for name, (t, *_) in best.locks().items())
        peak = [max(one[path].max() for path in stress) for one in (run, best)]
        grid = np.linspace(0.0, 4.0, 81)[1:]
        off = max(np.abs(_at(run, path, grid) - _at(best, path, grid)).max() for path in places)
        moment = [max(abs(i) for _, i, _ in one.locks().values()) for one in (run, best)]
        print(
            f"step {h:g} s  {run.run.steps} steps, {run.run.rejected} rejected  march {run.march:.2f} s  "
            f"nodes {off:.1e} m  locks {lag * 1e3:.2f} ms, largest impulse {moment[0] / moment[1] - 1:+.1%}  "
            f"stress {peak[0] / peak[1] - 1:+.1%}  complete {max(t for t, *_ in run.locks().values()):.4f} s"
        )


def _at(run, path, grid):
    values = run[path]
    return np.array([np.interp(grid, run.time, values[:, i]) for i in range(values.shape[1])])


def growth():
    """CPU per unknown and step of larger reflectors that begin to deploy, their diagonals still slack."""
    for modules in MODULES:
        done = Deployment(deck("--modules", str(modules), without=WINDER), EARLY)
        each = done.march / done.unknowns / done.run.steps
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(
            f"{modules} modules  {done.unknowns} unknowns  preparation {done.preparation:.1f} s  "
            f"march {done.march:.2f} s  {done.run.steps} steps  {done.run.iterations} iterations  "
            f"{each * 1e6:.2f} us  {memory:.0f} MiB",
            flush=True,
        )


if __name__ == "__main__":
    {"precision": precision, "growth": growth}[sys.argv[1]]()

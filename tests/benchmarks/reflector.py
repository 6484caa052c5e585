"""Deployable reflectors: work and precision of one module, growth with their number.

    python tests/benchmarks/reflector.py precision | growth

Recorded in docs/examples/reflector.md.
"""

import os
import re
import resource
import sys
import time
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

for _variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

import numpy as np

from mecano.analyses.prepare import integrator_of, prepare
from mecano.deck.read import deck_of_bytes
from mecano.model.sampler import Sampler
from mecano.solve.time.interpolate import interpolate

WRITER = Path(__file__).parent.parent.parent / "inputs" / "make_reflector.py"
FIXED = "{{end: 4, step: {}, rho_inf: 0.0}}"
ADAPTIVE = "{{end: 4, step: 0.01, adaptive: {{tolerance: {}, maximum_step: {}}}, rho_inf: {}}}"
TIMES = {
    **{f"fixed {h:g} s": FIXED.format(h) for h in (0.02, 0.01, 0.005)},
    **{
        f"{tolerance:g}, up to {longest:g} s, rho_inf {rho}": ADAPTIVE.format(tolerance, longest, rho)
        for tolerance, longest, rho in (
            (2e-2, 0.02, 0.0), (1e-2, 0.03, 0.0), (3e-3, 0.05, 0.0),
        )
    },
}  # fmt: skip
REFERENCE = ADAPTIVE.format(3e-4, 0.05, 0.0)
MODULES = 1, 7, 19, 37
WINDER = "payout_tension: $payout_tension, "
COMPARED = re.compile("/rate$|ing/stress$")  # of hinges, and of rising and falling diagonals
EVERY = 0.05  # [s]: times at which nodes are compared
EARLY = 0.5  # [s] of a growing reflector


def deck(*arguments, without="", time=None):
    """A checked deck, from whose text ``without`` is taken out, with another section ``time``."""
    spec = spec_from_file_location("make_reflector", WRITER)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    text = module.deck(module.options(arguments))
    text = text.replace(without, "") if without else text
    text = re.sub("^time: .*$", f"time: {time}", text, flags=re.MULTILINE) if time else text
    return deck_of_bytes(text.encode(), "reflector")


class Deployment:
    """A deck run to ``end`` [s]: its events, the CPU time [s] of preparation and run, outputs of all steps."""

    def __init__(self, deck, end=None):
        begun = time.process_time()
        prepared = prepare(deck)
        integrator, self.event_records, rows, self.nodes = integrator_of(prepared), [], [], []
        sampler, of = Sampler(prepared.system), prepared.system.numbering
        self.columns = [c for c in sampler.columns if COMPARED.search(c.path)]
        kept = [c.start for c in self.columns]

        def observe(accepted):
            self.event_records += accepted.event_records
            while (t := EVERY * (1 + len(self.nodes))) <= accepted.run.motion.t:
                self.nodes.append(
                    interpolate(accepted.before, accepted.run.motion, t, of).z[of.x[:, None] + np.arange(3)]
                )
            if accepted.h and not end:
                rows.append((accepted.run.motion.t, sampler.take(accepted.run, integrator.observation)[kept]))

        integrator.observers = (observe,)
        started = time.process_time()
        run = integrator.begin(prepared.state, deck.values["time"]["step"])
        self.run = integrator.to(end or deck.values["time"]["end"], run)
        self.preparation, self.wall_time = started - begun, time.process_time() - started
        self.unknowns = prepared.system.n
        self.time, self.rows = np.array([t for t, _ in rows]), np.array([row for _, row in rows])

    def __getitem__(self, path):
        """The values of an output at all steps."""
        return self.rows[:, [c.path for c in self.columns].index(path)]

    def stress(self):
        """The largest stress of a diagonal [Pa]."""
        return max(self[c.path].max() for c in self.columns if c.path.endswith("/stress"))

    def locks(self):
        """Time and impulse of the lock of each hinge."""
        return {h.element.split("'")[1]: (h.t, h.impulse, h.lost) for h in self.event_records if h.name == "locks"}


def precision():
    """CPU and errors for several steps and tolerances, against the reference."""
    best = Deployment(deck(time=REFERENCE))
    print(f"reference: {best.run.steps} steps, integration {best.wall_time:.1f} s", flush=True)
    for name, text in TIMES.items():
        run = Deployment(deck(time=text))
        lag = max(abs(run.locks()[name][0] - t) for name, (t, *_) in best.locks().items())
        off = max(np.abs(mine - its).max() for mine, its in zip(run.nodes, best.nodes, strict=True))
        rates = [_rates(one) for one in (run, best)]
        change = max(abs(rates[0][name] / rate - 1.0) for name, rate in rates[1].items())
        print(
            f"{name}  {run.run.steps} steps, {run.run.rejected} rejected  integration {run.wall_time:.2f} s  "
            f"nodes {off:.1e} m  locks {lag * 1e3:.2f} ms, rates {change:.1%}  "
            f"stress {run.stress() / best.stress() - 1:+.1%}  "
            f"complete {max(t for t, *_ in run.locks().values()):.4f} s",
            flush=True,
        )


def _rates(run):
    """Rate of each hinge [rad/s] at its lock, before the shock."""
    return {name: run[f"joints/{name}/rate"][run.time == t][0] for name, (t, *_) in run.locks().items()}


def growth():
    """CPU per unknown and step of larger reflectors that begin to deploy, their diagonals still slack."""
    for modules in MODULES:
        done = Deployment(deck("--modules", str(modules), without=WINDER, time=FIXED.format(0.01)), EARLY)
        each = done.wall_time / done.unknowns / done.run.steps
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(
            f"{modules} modules  {done.unknowns} unknowns  preparation {done.preparation:.1f} s  "
            f"integration {done.wall_time:.2f} s  {done.run.steps} steps  {done.run.iterations} iterations  "
            f"{each * 1e6:.2f} us  {memory:.0f} MiB",
            flush=True,
        )


if __name__ == "__main__":
    {"precision": precision, "growth": growth}[sys.argv[1]]()

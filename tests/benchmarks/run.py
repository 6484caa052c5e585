"""CPU time and accuracy of mecano on a few models, beside Exudyn where that is installed.

    python tests/benchmarks/run.py CASE [--json]      one case, or "all"
    python tests/benchmarks/run.py all --write        all cases and beams, into the tables of docs/benchmarks.md
    python tests/benchmarks/run.py tune CASE          every setting of Exudyn worth trying
    python tests/benchmarks/run.py startup            whole process of `mecano run inputs/pendulum.yaml`
    python tests/benchmarks/run.py beams|deploy|mast  what the file of that name in this folder says

What is measured and how: docs/benchmarks.md.
"""

import argparse
import dataclasses
import functools
import json
import math
import os
import statistics
import sys
import tempfile
from importlib import import_module
from pathlib import Path

for _variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "MECANO_THREADS"):
    os.environ.setdefault(_variable, "1")  # the processor time of two threads includes waiting for one another

sys.path.append(str(Path(__file__).parent.parent))

import numpy as np
from cases import CASES
from mecano_side import Mecano
from process import processor_time

STUDIES = ("beams", "deploy", "mast")
ALIKE = 1.02  # errors up to this ratio are equal
# steps between two samples that are tried for an error
PER_SAMPLE = (
    1, 2, 3, 4, 5, 6, 8, 10, 13, 16, 20, 25, 32, 40, 50, 64, 80, 100, 128, 160,
    200, 256, 320, 400, 512, 640, 800, 1280,
)  # fmt: skip
PENDULUM = Path(__file__).parent.parent.parent / "inputs" / "pendulum.yaml"


def exudyn():
    """The module of the other side, or None where Exudyn is not installed."""
    try:
        import exudyn_side
    except ImportError:
        return None
    return exudyn_side


def converged(case, run):
    """The probes of a much finer integration, extrapolated: run(step) -> (n_samples, n_probes)."""
    coarse, fine = run(2.0 * case.step / case.finer), run(case.step / case.finer)
    return fine + (fine - coarse) / 3.0


def error(case, trace, reference):
    """Largest difference of any probe at any sample, over its scale."""
    scale = np.array([probe.scale for probe in case.probes])
    return float(np.max(np.abs(trace - reference) / scale))


def measure(case, repetitions, other):
    """Everything about one case, as a dictionary."""
    ours = Mecano(case)
    theirs = other and other.Exudyn(case)
    own = converged(case, lambda step: Mecano(case, step).trace())
    found = {"case": case.name, "words": case.words, "steps": case.steps, "step": case.step, "required": case.required}
    found["mecano"] = {"error": error(case, ours.trace(), own), "rho_inf": case.rho}
    if theirs:
        found["exudyn"], found["agreement"] = _accuracy(case, theirs, own, other)
    ours.integrate()
    pairs = [(ours.integrate(), theirs.integrate() if theirs else 0.0) for _ in range(repetitions)]
    for name, code, spent in zip(("mecano", "exudyn"), (ours, theirs), zip(*pairs, strict=True), strict=True):
        if code:
            found[name] |= {"us_per_step": 1e6 * statistics.median(spent) / case.steps, "counts": code.counts}
            found[name]["spread"] = (max(spent) - min(spent)) / statistics.median(spent)
    if theirs:
        found["ratio"] = found["mecano"]["us_per_step"] / found["exudyn"]["us_per_step"]
        found["equal_accuracy"] = _equal_accuracy(case, found, own, repetitions)
        found["at_errors"] = at_errors(case, theirs, own, repetitions, other)
    return found


def _equal_accuracy(case, found, own, repetitions):
    """The longest steps with the error of Exudyn or less, and the ratio then."""
    spent, step, off = cheapest(case, Mecano, ALIKE * found["exudyn"]["error"], own, repetitions)
    theirs = 1e-6 * found["exudyn"]["us_per_step"] * case.steps
    return {"step": step, "error": off, "ratio": spent / theirs}


def cheapest(case, code, least, reference, repetitions):
    """CPU [s], step [s] and error of the longest steps of a code with an error of at most ``least``."""

    @functools.cache
    def tried(i):
        step = case.step * case.every / PER_SAMPLE[i]
        return step, error(case, code(case, step=step).trace(), reference)

    i = PER_SAMPLE.index(case.every)
    while tried(i)[1] > least and i + 1 < len(PER_SAMPLE):
        i += 1
    while tried(i)[1] <= least and i > 0 and tried(i - 1)[1] <= least:
        i -= 1
    step, reached = tried(i)
    model = code(case, step=step)
    return statistics.median(model.integrate() for _ in range(repetitions)), step, reached


def at_errors(case, theirs, own, repetitions, other):
    """CPU ratios where both codes reach the same errors, each with its longest steps that do."""
    own_law = converged(case, lambda step: other.Exudyn(case, other.precise(case), step).trace())
    found = []
    for least in case.errors:
        ours, step, _ = cheapest(case, Mecano, least, own, repetitions)
        others, their_step, reached = cheapest(case, other.Exudyn, least, own_law, repetitions)
        met = reached <= least
        found.append({"error": least, "ratio": ours / others if met else None, "step": step, "their_step": their_step})
    return found


def _accuracy(case, theirs, own, other):
    """Error of Exudyn against its converged solution, and how far the converged solutions of both codes agree."""
    settings = other.precise(case)
    same = converged(case, lambda step: other.Exudyn(case, other.same_law(settings), step).trace())
    agreement = error(case, same, own)
    if not case.same_physics:
        same = converged(case, lambda step: other.Exudyn(case, settings, step).trace())
    return {"error": error(case, theirs.trace(), same), "settings": vars(theirs.settings)}, agreement


def tune(case, repetitions, other):
    """Print what every setting of Exudyn costs and how far it is from its converged solution."""
    settings = other.precise(case)
    reference = converged(case, lambda step: other.Exudyn(case, settings, step).trace())
    for settings in other.candidates(case):
        code = other.Exudyn(case, settings)
        try:
            off = error(case, code.trace(), reference)
            spent = statistics.median(code.integrate() for _ in range(repetitions))
        except RuntimeError:
            print(f"{'fails':>10s} {'':11s} {settings}")
            continue
        print(f"{1e6 * spent / case.steps:7.1f} us error {off:.2e} {settings}", flush=True)


def startup(repetitions):
    """Least processor time [s] of the whole process of a warm `mecano run inputs/pendulum.yaml`."""
    with tempfile.TemporaryDirectory() as folder:
        call = ("run", PENDULUM, "-q", "--force", "-o", Path(folder) / "r.h5")
        processor_time(*call)  # compiles, if need be
        return min(processor_time(*call) for _ in range(repetitions))


def table(found):
    """One case as a line of text."""
    own = found["mecano"]
    text = f"{found['case']:12s} mecano {own['us_per_step']:8.1f} us/step, error {own['error']:.1e}"
    if "ratio" in found:
        other = found["exudyn"]
        text += f"; Exudyn {other['us_per_step']:8.1f} us/step, error {other['error']:.1e}"
        text += f"; ratio {found['ratio']:.2f} (required: {found['required']})"
        equal = found["equal_accuracy"]
        text += f"; with steps of {equal['step']:g} s and error {equal['error']:.1e} ratio {equal['ratio']:.2f}"
        text += f"; converged solutions agree to {found['agreement']:.1e}"
        for level in found["at_errors"]:
            text += f"; at error {level['error']:.0e} ratio {level['ratio'] or math.nan:.2f}"
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=[*CASES, "all", "tune", "startup", *STUDIES])
    parser.add_argument("case", nargs="?", choices=list(CASES))
    parser.add_argument("--json", action="store_true", help="one JSON object per case")
    parser.add_argument("--write", action="store_true", help="write the tables of docs/benchmarks.md")
    parser.add_argument("--repetitions", type=int, default=7)
    parser.add_argument("--steps", type=int, help="take so many steps only")
    parser.add_argument("--mecano-only", action="store_true", help="leave Exudyn out even where it is installed")
    given = parser.parse_args()
    if given.what in STUDIES:
        sys.argv[1:], sys.exudynFast = [], True  # without range checks, as its users run it
        import_module(given.what).main()
        return
    if given.what == "startup":
        print(f"{startup(given.repetitions):.2f} s")
        return
    other = None if given.mecano_only else exudyn()
    if given.what == "tune":
        tune(CASES[given.case], given.repetitions, other)
        return
    cases = list(CASES.values()) if given.what == "all" else [CASES[given.what]]
    measured = []
    for case in cases:
        case = dataclasses.replace(case, steps=given.steps or case.steps)
        measured.append(found := measure(case, given.repetitions, other))
        print(json.dumps(found) if given.json else table(found), flush=True)
    if given.write:
        import beams
        from tables import write

        write(measured, list(beams.measured(beams.ELEMENTS)))


if __name__ == "__main__":
    sys.exit(main())

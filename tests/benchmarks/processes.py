"""Whole processes: `mecano run` of a deck beside a script for Exudyn, each with its start and its results file.

    python tests/benchmarks/processes.py [case ...] [--write]

Processor time of the processes, run in turn, medians of five. Machine code is in the store before the first. Both save
their state after every 20 steps: mecano motion, outputs and energies in HDF5, Exudyn coordinates with their rates in a
text. Exudyn takes its fastest settings (exudyn_side.py). ``--write`` replaces the table in docs/benchmarks.md.
"""

import argparse
import os
import statistics
import sys
import tempfile
from pathlib import Path

sys.path.append(str(Path(__file__).parent.parent))

import yaml
from cases import CASES
from mecano_side import deck_of
from process import processor_time

REPETITIONS = 5
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "MECANO_THREADS")


def measured(case, folder):
    """Return the median processor times [s] of both codes for a case."""
    deck = folder / f"{case.name}.yaml"
    content = deck_of(case, case.step)
    content["output"] = {"every": case.every * case.step}
    deck.write_text(yaml.safe_dump(content, sort_keys=False))
    run = ("run", deck, "--quiet", "--force", "-o", folder / "results.h5")
    script = (Path(__file__).with_name("exudyn_side.py"), case.name, folder / "solution.txt")
    processor_time(*run)  # compiles, if need be
    pairs = [(processor_time(*run), processor_time(*script, command=(sys.executable,))) for _ in range(REPETITIONS)]
    return tuple(statistics.median(spent) for spent in zip(*pairs, strict=True))


def main():
    """Measure all cases, or those that are named."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", choices=[*CASES, []])
    parser.add_argument("--write", action="store_true", help="write the table of docs/benchmarks.md")
    given = parser.parse_args()
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for case in [CASES[name] for name in given.cases] or CASES.values():
            own, other = measured(case, Path(folder))
            rows.append((case, own, other))
            print(f"{case.name:18s} mecano {own:6.2f} s, Exudyn {other:6.2f} s, ratio {own / other:.2f}", flush=True)
    if given.write:
        from tables import write_processes

        write_processes(rows)


if __name__ == "__main__":
    main()

"""What checkpoints and check sums cost, in processor time.

    python tests/benchmarks/results_cost.py [--write]

Runs in this process, after one that compiles; medians of ``REPEATS``. With --write the tables go into
docs/long-runs.md and docs/results-file.md.
"""

import datetime
import math
import os
import statistics
import subprocess
import sys
import tempfile
import textwrap
import time
from contextlib import contextmanager
from pathlib import Path

for _variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

import h5py

from mecano.analyses.checkpoint_writer import CheckpointWriter
from mecano.analyses.dynamic import run
from mecano.deck.read import read_deck
from mecano.results.disk import Disk
from mecano.results.live_checksums import LiveChecksums
from mecano.results.opening import open_checked

ROOT = Path(__file__).resolve().parents[2]
INPUTS, DOCS = ROOT / "inputs", ROOT / "docs"
CHECKPOINTED = (
    ("`nose_gear_rigid.yaml`", "nose_gear_rigid", ()),
    ("the same to 400 s", "nose_gear_rigid", ("time.end=400",)),
    ("`nose_landing_gear.yaml` to 40 s", "nose_landing_gear", ("time.end=40",)),
)
INTERVALS = (30.0, 1.0, 0.0)  # s
# all steps, the cheapest ones: the worst case
SAVED = "pendulum", ("time={end: 40, step: 1e-3}", "output.every=step")
HEAD = "run", "processor time", "`--checkpoint 30` (default)", "`--checkpoint 1`", "`--checkpoint 0`"
REPEATS = 3


@contextmanager
def timed(*methods):
    """In this block the list has the processor time [s] of every call of (class, name of a method)."""
    spent, originals, inside = [], [(owner, name, getattr(owner, name)) for owner, name in methods], []

    def counted(original):
        def call(*arguments):
            if inside:
                return original(*arguments)
            inside.append(True)
            begun = time.process_time()
            try:
                return original(*arguments)
            finally:
                spent.append(time.process_time() - begun)
                inside.clear()

        return call

    for owner, name, original in originals:
        setattr(owner, name, counted(original))
    try:
        yield spent
    finally:
        for owner, name, original in originals:
            setattr(owner, name, original)


def processor_time(action):
    """The processor time of ``action()`` [s], and what it returns."""
    begun = time.process_time()
    found = action()
    return time.process_time() - begun, found


def checkpoints(folder):
    """Rows of the table: the run, its time, and number, time and share of its checkpoints for each interval."""
    for title, name, settings in CHECKPOINTED:
        deck, path, cells = read_deck(INPUTS / f"{name}.yaml", settings), folder / "r.h5", []
        run(deck, path, force=True)
        for interval in INTERVALS:
            found = []
            for _ in range(REPEATS):
                with timed((CheckpointWriter, "write")) as spent:
                    total, last = processor_time(lambda: run(deck, path, force=True, interval=interval))  # noqa: B023
                found.append((total, len(spent), sum(spent)))
            total, count, cost = (statistics.median(column) for column in zip(*found, strict=True))
            each = f"{count:.0f} of {1e3 * cost / count:.0f} ms: {cost / total:.1%}" if count else "none"
            cells.append((total, each.replace("%", " %")))
        times = f"{title}, {last.steps:,} steps", f"{cells[0][0]:.2g} s"
        yield "| " + " | ".join([*times, *(text for _, text in cells)]) + " |"


def sums(folder):
    """A sentence on the cost of the check sums where most is saved."""
    name, settings = SAVED
    deck, path, totals, costs = read_deck(INPUTS / f"{name}.yaml", settings), folder / "r.h5", [], []
    run(deck, path, force=True)
    for _ in range(REPEATS):
        methods = [(LiveChecksums, one) for one in ("cover", "announce")] + [(Disk, "seal")]
        with timed(*methods) as spent:
            total, last = processor_time(lambda: run(deck, path, force=True))
        totals.append(total)
        costs.append(sum(spent))
    with_sums, without = ([] for _ in range(2))
    for _ in range(REPEATS):
        with_sums.append(processor_time(lambda: through_sums(path))[0])
        without.append(processor_time(lambda: directly(path))[0])
    low, high = math.floor(1e3 * min(costs)), math.ceil(1e3 * max(costs))
    share = statistics.median(cost / total for cost, total in zip(costs, totals, strict=True))
    slow, fast = (1e3 * statistics.median(times) for times in (with_sums, without))
    text = (
        f"Cost: for `inputs/{name}.yaml` with `output: {{every: step}}`, {last.steps:,} steps and "
        f"{path.stat().st_size / 1e6:.1f} MB, the worst case, {low} to {high} ms of {min(totals):.3f} to "
        f"{max(totals):.3f} s of processor time ({100 * share:.1f} %, median of {REPEATS} runs); a run that "
        f"saves less, or has longer steps, spends a smaller share. Reading all of this file takes {slow:.1f} ms with "
        f"the sums, {fast:.1f} ms without them (commit {commit()}, {datetime.date.today()})."
    )
    return textwrap.fill(text, 120)


def commit():
    """The abbreviated name of the commit that is measured."""
    command = ["git", "rev-parse", "--short", "HEAD"]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()


def read_all(file):
    """Read every dataset of an HDF5 file."""
    file.visititems(lambda _, item: item[()] if isinstance(item, h5py.Dataset) else None)


def through_sums(path):
    """Read a file as mecano does."""
    with open_checked(path) as file:
        read_all(file)


def directly(path):
    """Read a file by HDF5 alone."""
    with h5py.File(path) as file:
        read_all(file)


def written(page, mark, text):
    """Put a text between the marks of a page."""
    before, begin, rest = page.partition(f"<!-- {mark} -->\n")
    _, end, after = rest.partition(f"\n<!-- end of {mark} -->")
    return before + begin + text + end + after


def main():
    """Measure, print, and write where that is asked for."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        cost, rows = sums(folder), "\n".join(checkpoints(folder))
    print(rows, cost, sep="\n")
    if "--write" in sys.argv:
        head = f"| {' | '.join(HEAD)} |\n|---|---|---|---|---|\n"
        table = f"{head}{rows}\n\n(commit {commit()}, {datetime.date.today()})"
        for file, mark, text in (("long-runs", "checkpoints", table), ("results-file", "sums", cost)):
            page = DOCS / f"{file}.md"
            page.write_text(written(page.read_text(), mark, text))


if __name__ == "__main__":
    main()

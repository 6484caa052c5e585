"""The reliability scorecard: trials of mecano as software, made anew from a seed; prints trials and points by line.

    python tests/scorecard/run.py                 all trials of all lines; many hours
    python tests/scorecard/run.py --quick         a few of the trials, in minutes
    python tests/scorecard/run.py --line 4 --line 5 --seed 7 --keep FOLDER
    python tests/scorecard/run.py --write         and write the rows that were made into docs/reliability.md

The points of a line are its weight times the share of its trials that were held. What a trial that was not held has
left lies in the folder of --keep.
"""

import os
import sys
from collections import Counter
from importlib import import_module
from pathlib import Path

for _variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")
sys.path[0] = str(Path(__file__).resolve().parents[1])  # tests/, of which this is the package scorecard
sys.path.insert(1, str(Path(__file__).resolve().parents[2]))

import argparse
import secrets
import subprocess
import tempfile
import time
from datetime import UTC, datetime

from scorecard.outcome import warm
from scorecard.trial import spread

MODULES = (
    "malformed", "hostile", "semantic", "killed", "disk", "extreme_numbers", "singular", "hard", "size", "damaged",
    "physics", "signals",
)  # fmt: skip
QUICK = {  # of the trials of the module, for continuous integration: a minute of processor time in all
    "malformed": 0.002, "hostile": 0.03, "semantic": 0.05, "killed": 0.02, "disk": 0.02, "extreme_numbers": 0.02,
    "singular": 0.2, "hard": 0.1, "size": 0.01, "damaged": 0.01, "physics": 0.1, "signals": 0.02,
}  # fmt: skip
PAGE = Path(__file__).resolve().parents[2] / "docs" / "reliability.md"
HEAD = ["#", "what", "trials", "held", "points", "seed, commit, date"]
BEGIN, END = "<!-- table -->", "<!-- end of table -->"
SHOWN = 5  # failures of a line that are named


def main(arguments=None):
    """Make the trials that were asked for, print them, and return the exit code: 0 where all were held."""
    asked = parsed(arguments)
    seed = asked.seed if asked.seed is not None else secrets.randbelow(10**6)
    keep = Path(asked.keep or tempfile.mkdtemp(prefix="scorecard-kept-"))
    print(f"seed {seed}; what was not held lies in {keep}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        warm(folder)
    lines, tallies, begun = {}, {}, time.monotonic()
    for name in MODULES:
        module = import_module(f"scorecard.{name}")
        wanted = [line for line in module.LINES if not asked.line or line.number in asked.line]
        if not wanted:
            continue
        lines |= {line.number: line for line in wanted}
        numbers = [line.number for line in wanted]
        factor = asked.trials_factor * (QUICK[name] if asked.quick else 1.0)
        for trial in made(module.jobs(numbers, factor, seed), keep, asked.workers):
            if trial.line in numbers:
                tallies.setdefault(trial.line, Tally()).take(trial)
        for number in numbers:
            tell(lines[number], tallies.setdefault(number, Tally()), time.monotonic() - begun)
    made_by = f"{seed}, {commit()}, {datetime.now(UTC):%Y-%m-%d}"
    rows = {number: row(lines[number], tallies[number], made_by) for number in lines}
    print(table(rows))
    if asked.write:
        write(rows)
    return 0 if all(not tally.failures for tally in tallies.values()) else 1


def parsed(arguments):
    """The options."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help="a few of the trials, in minutes")
    parser.add_argument("--seed", type=int, help="of all random choices; default: a new one, which is printed")
    parser.add_argument("--line", type=int, action="append", default=[], help="only this line; may be repeated")
    parser.add_argument("--keep", metavar="FOLDER", help="folder for the files of trials that were not held")
    parser.add_argument("--trials-factor", type=float, default=1.0, help="times the trials of the table")
    parser.add_argument("--workers", type=int, default=2, help="trials side by side")
    parser.add_argument("--write", action="store_true", help=f"write the table into {PAGE.name}")
    return parser.parse_args(arguments)


class Tally:
    """What came out of the trials of one line."""

    def __init__(self):
        self.count, self.failures = 0, []

    def take(self, trial):
        """Count a trial."""
        self.count += 1
        if not trial.held:
            self.failures.append(trial)

    @property
    def share(self):
        """Share of the trials held; 0 if none was made."""
        return 1.0 - len(self.failures) / self.count if self.count else 0.0


def made(jobs, keep, workers):
    """Yield the Trials of jobs, and say now and then how far they are."""
    jobs, reported = list(jobs), time.monotonic()
    for done, trials in enumerate(spread(jobs, keep, workers), 1):
        yield from trials
        if time.monotonic() - reported > 30.0:
            reported = time.monotonic()
            print(f"  {done} of {len(jobs)}", flush=True)


def tell(line, tally, seconds):
    """Print how a line came out."""
    held = tally.count - len(tally.failures)
    points = f"{line.weight * tally.share:.2f} of {line.weight:g} points"
    print(f"line {line.number}: {held} of {tally.count} held, {points}, at {seconds:.0f} s", flush=True)
    causes = Counter(trial.why for trial in tally.failures)
    for why, count in causes.most_common(SHOWN):
        first = next(trial for trial in tally.failures if trial.why == why)
        print(f"    {count} x {why}\n        first: {first.name}", flush=True)


def row(line, tally, made_by):
    """The row of the table for a line, as its cells; ``made_by`` is the seed, the commit and the date."""
    held = tally.count - len(tally.failures)
    points = f"{line.weight * tally.share:.2f} of {line.weight:g}"
    return [str(line.number), line.what, f"{tally.count:,}", f"{held:,}", points, made_by]


def table(rows):
    """The table of rows {number of the line: cells}, as Markdown, with the sum of all."""
    cells = [HEAD, ["---"] * len(HEAD), *(rows[number] for number in sorted(rows)), total(rows.values())]
    return "\n".join(f"| {' | '.join(row)} |" for row in cells)


def total(rows):
    """The last row: the sums of all others."""
    rows = list(rows)
    count, held = (sum(int(row[i].replace(",", "")) for row in rows) for i in (2, 3))
    points, weight = (sum(float(row[4].split(" of ")[i]) for row in rows) for i in (0, 1))
    return ["", "all", f"{count:,}", f"{held:,}", f"{points:.2f} of {weight:g}", ""]


def write(rows):
    """Put rows into the table of the page, in the place of those of the same lines; the others stay."""
    page = PAGE.read_text()
    head, _, rest = page.partition(BEGIN)
    before, _, tail = rest.partition(END)
    split = [[cell.strip() for cell in text.strip("| ").split(" | ")] for text in before.splitlines()]
    kept = {int(cells[0]): cells for cells in split if cells[0].isdigit()}
    PAGE.write_text(f"{head}{BEGIN}\n{table(kept | rows)}\n{END}{tail}")


def commit():
    """The commit that was tried."""
    reported = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=PAGE.parent, capture_output=True, text=True)
    return reported.stdout.strip() or "unknown"


if __name__ == "__main__":
    sys.exit(main())

"""A study of 200 cases of the nose gear, 20 of them spoiled: all others complete, the table right, both cores busy.

python tests/benchmarks/study.py [folder]
"""

import csv
import os
import random
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import mecano
from mecano.results.study_file import read_study

DECK = Path(__file__).parents[2] / "inputs" / "nose_gear_rigid.yaml"
SPEED, FRICTION, STIFFNESS = (
    "parameters.speed", "tire_laws.nose_tire.friction.exponential.start",
    "tire_laws.nose_tire.radial.polynomial.coefficients.1",
)  # fmt: skip
SPOILED = {  # an override, and the exit code that it leads to
    "elements.rim.mass=-50": 2,  # an invalid value
    "time.adaptive.tolerance=1.0e-3 bar": 2,  # a unit that does not fit
    "time.adaptive.minimum_step=9.0e-5": 3,  # no step small enough for the touch-down
    "parameters.ballast=60000": -9,  # too many masses for the memory
}
MEMORY = 280  # MB, of each case; those that are as they should be take 225
BALLAST = "\n  ballast$i: {repeat: {i: 1..$ballast}, type: point_mass, node: top, mass: 1.0e-9}"
STUDY = """\
study: 1
title: Touch-down of a nose gear
deck: gear.yaml
csv: cases.csv
outputs:
  peak_load: {of: wheel.radial_force, take: max}
  stroke: {of: absorber.extension, take: min}
  last_touch_down: {event: wheel touch_down, take: last}
  touch_downs: {event: wheel touch_down, take: count}
"""


def rows():
    """(speed, friction, stiffness, override or "") of 200 cases: a grid, 20 places of it spoiled."""
    grid = [(v, f, k) for v in np.linspace(40, 80, 10) for f in np.linspace(0.6, 1.0, 5)
            for k in np.linspace(7.0e5, 9.5e5, 4)]  # fmt: skip
    spoiled = dict(zip(random.Random(6).sample(range(200), 20), list(SPOILED) * 5, strict=True))
    return [(*row, spoiled.get(i, "")) for i, row in enumerate(grid)]


def write(folder, cases):
    """The study and its table of cases: what spoils one has a column, in which the others have the deck's value."""
    usual = {"elements.rim.mass": "50", "time.adaptive.tolerance": "1.0e-3", "time.adaptive.minimum_step": "automatic",
             "parameters.ballast": "1"}  # fmt: skip
    with open(folder / "cases.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow([SPEED, FRICTION, STIFFNESS, *usual])
        for *numbers, override in cases:
            path, _, value = override.partition("=")
            table.writerow([*map(float, numbers), *{**usual, **({path: value} if path else {})}.values()])
    deck = DECK.read_text().replace("\nelements:", "\nelements:" + BALLAST)
    (folder / "gear.yaml").write_text(deck.replace("\nparameters:", "\nparameters:\n  ballast: 1"))
    (folder / "study.yaml").write_text(STUDY)


def main(folder):
    """Run the study, and compare its table with what was asked for."""
    cases = rows()
    write(folder, cases)
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    words = [sys.executable, "-m", "mecano", "sweep", "study.yaml", "--memory-limit", str(MEMORY), "--plot", "--force"]
    ended = subprocess.run(words, cwd=folder, capture_output=True, text=True)
    took, after = time.monotonic() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    print(ended.stdout, ended.stderr.splitlines()[-1], f"\nexit code {ended.returncode}, {took:.1f} s, {used:.1f} s of "
          f"the processor: {used / took / len(os.sched_getaffinity(0)):.1%} of all cores", sep="")  # fmt: skip
    compare(folder, cases)
    slots = read_study(folder / "study_runs" / "table.h5")["case/wall_time"].sum() / took / len(os.sched_getaffinity(0))
    print(f"a case runs on {slots:.1%} of all cores and time, the beginning and the table included")


def compare(folder, cases):
    """The table against the cases and their results files."""
    table = read_study(folder / "study_runs" / "table.h5")
    for i, (speed, friction, stiffness, override) in enumerate(cases):
        reported = [table[f"parameters/{path}"][i] for path in (SPEED, FRICTION, STIFFNESS)]
        assert reported == [speed, friction, stiffness], i
        assert table["case/exit_code"][i] == SPOILED.get(override, 0), (i, override, table["case/reason"][i])
        if override:
            assert table["case/status"][i] == "failed" and np.isnan(table["outputs/peak_load"][i]), i
            continue
        with mecano.open_results(folder / "study_runs" / f"{i + 1:04d}.h5") as results:
            assert f"{SPEED}={speed}" in results.metadata["overrides"], i
            assert table["outputs/peak_load"][i] == results.extremes["elements/wheel/radial_force"].maximum, i
            assert table["outputs/touch_downs"][i] == sum(e.name == "touch_down" for e in results.events), i
    complete = int(np.sum(table["case/status"] == "complete"))
    print(f"{complete} of {len(cases)} complete; the table is that of the files")
    assert complete == 180


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(Path(sys.argv[1]))
    else:
        with tempfile.TemporaryDirectory() as place:
            main(Path(place))

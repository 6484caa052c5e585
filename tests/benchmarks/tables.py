"""The tables of docs/benchmarks.md that ``run.py all --write`` and ``processes.py --write`` measure.

Also the rows of the README taken from them.
"""

import datetime
import importlib.metadata
import math
import platform
import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE, README = ROOT / "docs" / "benchmarks.md", ROOT / "README.md"
PROCESSES_HEAD = """
| case | `mecano run` [s] | script for Exudyn [s] | ratio |
|---|---|---|---|
"""
SHORT = 6  # columns of the rows in the README
CASES_HEAD = """
| case | mecano [µs/step] | error | Exudyn [µs/step] | error | ratio | at equal error | wanted |
|---|---|---|---|---|---|---|---|
"""
BEAMS_HEAD = """
| elements | mecano [µs/step] | error [m] | element of Exudyn | [µs/step] | error [m] | ratio | at equal error |
|---|---|---|---|---|---|---|---|
"""


def write(cases, beams):
    """Replace both tables of the page between their marks, and the rows of the README with the same cases."""
    rows = [_case(found) for found in cases]
    text = PAGE.read_text(encoding="utf-8")
    text = _between(text, "cases", _measured() + CASES_HEAD + "\n".join(rows))
    text = _between(text, "beams", _measured() + BEAMS_HEAD + "\n".join(_beam(row) for row in beams))
    PAGE.write_text(text, encoding="utf-8")
    text = README.read_text(encoding="utf-8")
    for row in rows:
        name, short = row.split("|")[1], "|".join(row.split("|")[: SHORT + 1]) + "|"
        text = re.sub(f"^[|]{re.escape(name)}[|].*$", lambda _, short=short: short, text, flags=re.MULTILINE)
    README.write_text(text, encoding="utf-8")


def write_processes(rows):
    """Replace the table of whole processes; rows of (Case, processor time of mecano [s], of Exudyn [s])."""
    lines = (
        f"| {case.name}: {case.words} | {own:.2f} | {other:.2f} | {own / other:.2f} |" for case, own, other in rows
    )
    text = _between(PAGE.read_text(encoding="utf-8"), "processes", _measured() + PROCESSES_HEAD + "\n".join(lines))
    PAGE.write_text(text, encoding="utf-8")


def _between(text, name, new):
    """The text with what stands between the marks of a table replaced."""
    begin, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
    before, rest = text.split(begin)
    return before + begin + new.rstrip() + "\n\n" + end + rest.split(end)[1]


def _measured():
    """When, of which commit, with which versions and on which machine."""
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True)
    names = ("numba", "numpy", "exudyn")
    versions = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in names)
    return (
        f"{datetime.date.today()}, commit {commit.stdout.strip()}; Python {platform.python_version()}, {versions}; "
        f"{platform.machine()}, {_processor()}.\n"
    )


def _processor():
    cpuinfo = Path("/proc/cpuinfo")
    found = re.search(r"model name\s*: (.*)", cpuinfo.read_text()) if cpuinfo.exists() else None
    return found[1] if found else platform.processor() or "unknown processor"


def _number(x):
    return f"{x:.1f}" if x < 100.0 else f"{x:.0f}"


def _ratio(x):
    return f"{x:.2f}" if x is not None and math.isfinite(x) else "–"


def _case(found):
    own, other = found["mecano"], found["exudyn"]
    levels = " / ".join(_ratio(of["ratio"]) for of in found["at_errors"])
    equal = levels or f"{found['equal_accuracy']['ratio']:.2f}"
    values = _number(own["us_per_step"]), f"{own['error']:.1e}", _number(other["us_per_step"]), f"{other['error']:.1e}"
    ratios = f"{found['ratio']:.2f} | {equal} | {found['required']}"
    return f"| {found['case']}: {found['words']} | {' | '.join(values)} | {ratios} |"


def _beam(row):
    own = f"| {row['elements']} | {_number(row['us_per_step'])} | {row['error']:.1e} | {row['element']} "
    if "exudyn" not in row:
        return own + "| no solution | | | |"
    other = f"{_number(row['exudyn'])} | {row['exudyn_error']:.1e} | {row['ratio']:.2f} | {_ratio(row['equal_ratio'])}"
    return own + f"| {other} |"

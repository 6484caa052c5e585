"""The page of evidence: summaries of the verification manual, the scorecard and the benchmarks; limits, versions."""

import json
import re
from importlib.metadata import requires, version
from itertools import groupby
from pathlib import Path

from verification import FOUND

ROOT = Path(__file__).parents[2]
HYPHEN = "\N{NON-BREAKING HYPHEN}"
TOP = """# Evidence

How accurate, reliable and fast mecano is, by which tests and measurements, and what has not been tested. The numbers on
this page are copied from the linked pages when the site is built.
"""
ELEMENTS = """
## Every element

Generic tests ([contributing](../contributing.md#an-element)) cover every element, joint and load in every phase: they
compare tangents with finite differences, and the power of forces with the change of energy, and test invariance under a
rigid motion of the whole model. Every kind is also used by a deck of `inputs/`. Laws and tyre laws have generic tests
of their own. `mecano check-kind` runs these tests on [kinds of your own](../plugins.md).
"""
LIMITS = """
## Other programs

* 300 random mechanisms of two to seven rigid bodies, with Pinocchio 4.1: trees of hinges, prismatic, cylindrical,
  planar, spherical and universal joints and screws, with springs, dampers and up to two loops. Positions, velocities,
  coordinates of joints and reactions after one second, 10109 outputs, agree within 5.1e-9 of their size
  (`python tests/benchmarks/pinocchio_side.py 1 300`, commit ba38e1e5, 2026-12-01). So do static equilibria and
  eigenvalues of 100 such trees, within 4.6e-10 (`pinocchio_modes.py 1 100`, commit 73987790, 2026-12-01).
* 28 random space frames of two to ten members, with OpenSees 3.7, and 2 that were passed over near limit points.
  Displacements and end forces of linear statics agree within 1.2e-6. Extrapolated from two meshes, displacements of a
  third of a member agree within 4e-5, the first eight frequencies about that state within 1.3e-4, and displacements
  under loads that grow to it within two periods within 4e-5 (`opensees_side.py 1 30`, commit 7c6320fb, 2026-12-01).
* 40 random rotors, with ROSS 2.3: shafts of stepped diameter with discs in bearings of unequal and of coupled
  stiffness. The eigenvalues of the first 12 modes at rest and at two speeds, extrapolated from two meshes, agree
  within 5.5e-5; the median of the largest differences is 1.3e-6 (`ross_side.py 0 39`, commit 7c6320fb, 2026-12-01).
* 40 random nets of hanging cables with masses, with MoorPy 1.3. Extrapolated from two meshes, positions agree within
  5.0e-8 of the radius of the net and tensions within 3.1e-4 of the largest one (`moorpy_side.py 0 39`, commit 3c0c994a,
  2026-12-01).
* 200 random bicycles, with BicycleParameters 1.5: the four eigenvalues at a speed between 0.5 and 9 m/s agree within
  1.7e-11 (`bicycle_side.py 0 199`, commit 7c6320fb, 2026-12-01).

## Published results

Both examples of the paper that mecano follows are reproduced and compared: the [landing
gear](../examples/nose_landing_gear.md) and the [reflector](../examples/reflector.md). Both pages give the differences.

## Known limits

* What mecano cannot model: [comparison](../comparison.md#what-mecano-cannot-do).
* [Beams](../beams.md#limits): the inertia of curved lines that stretch, slender ring-like elements under radial load,
  buckling of one element.
* [Superelements](../superelements.md#when-one-is-not-enough): no stiffening by their own internal forces.
* [Friction](../theory.md#25-forces-that-depend-on-reactions): sticking contacts creep; rigid guides that bind have no
  solution; with redundant constraints the motion depends on the real compliances.
* [Redundant constraints](../theory.md#3-redundant-constraints): the motion is unique, single reactions are not, and are
  marked as such.
* [Shocks](../shocks.md#rules): one coefficient of restitution for contacts that close together.
* [Error control](../step-control.md): bounds displacements and rotations, but not stresses and reactions of vibrations
  that the steps do not resolve; a warning names them.
* [Reliability](../reliability.md): known failures that are not fixed are listed below its table.

## Platforms

| platform | what was run |
|---|---|
| x86-64 Linux, Python 3.11 | the whole test suite, with the oldest and with the newest dependencies |
| x86-64 Linux, Python 3.13 | the landing gear and the pendulum, from the wheel with compiled code |
| 64-bit Arm Linux | under emulation: a landing gear, compiled and with shipped code; the results of x86-64 to 1e-20 |
| macOS, Windows | nothing |
| container images | the Dockerfile was built and run, on Debian 12 with Python 3.11; the other recipes were checked |
"""


def page():
    """Return Markdown of the page."""
    return "\n".join([TOP, *_verification(), ELEMENTS, *_scorecard(), *_speed(), LIMITS, *_versions()]) + "\n"


def _verification():
    yield "## Numbers with a source\n"
    if not FOUND.exists():
        yield "This page was made without a run of the tests; see the [manual](verification.md)."
        return
    records = sorted(json.loads(FOUND.read_text(encoding="utf-8")), key=lambda record: record["subject"])
    yield f"The [verification manual](verification.md) lists {len(records)} comparisons with closed forms, publications"
    yield "and independent integrations, each a test with a tolerance:\n"
    yield "| subject | comparisons | largest error over its tolerance |\n|---|---|---|"
    for subject, group in groupby(records, key=lambda record: record["subject"]):
        shares = [record["error"] / record["tolerance"] for record in group]
        yield f"| {subject} | {len(shares)} | {max(shares):.2g} |"


def _scorecard():
    yield "## Reliability\n"
    rows = _rows("reliability.md", "| # |")
    trials, held, points = rows[-1][2:5]
    yield f"The [scorecard](../reliability.md) tries to break mecano in {len(rows) - 1} ways, with hostile decks,"
    yield f"kills, full disks, damaged files and singular models: {held} of {trials} trials ended as required,"
    yield f"{points} points. Its table names seed, commit and date of each line, and what failed."


def _speed():
    yield "\n## Speed\n"
    yield "CPU time of a step on one core, and of Exudyn at equal steps ([how, when and on what](../benchmarks.md)):\n"
    yield "| case | mecano [µs/step] | error | Exudyn [µs/step] | error | ratio |\n|---|---|---|---|---|---|"
    for row in _rows("benchmarks.md", "| case | mecano"):
        yield f"| {' | '.join(re.sub('(?<=e)-', HYPHEN, cell) for cell in row[:6])} |"


def _versions():
    yield "## Versions of libraries\n"
    yield "The suite was run with the oldest versions ([how](../architecture.md#dependencies)); the newest are those"
    yield "with which this page was made.\n"
    yield "| library | oldest | newest |\n|---|---|---|"
    for text in requires("mecano"):
        if "extra ==" not in text:
            name, oldest = re.match(r"([\w-]+)>=([\d.]+)", text).groups()
            yield f"| {name} | {oldest} | {version(name)} |"


def _rows(page, heading):
    """Return the cells of the rows of a table of docs/, found by the beginning of its heading."""
    lines = (ROOT / "docs" / page).read_text(encoding="utf-8").splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith(heading)) + 2
    last = next(i for i in range(first, len(lines)) if not lines[i].startswith("|"))
    return [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in lines[first:last]]

"""Work and error of generalized-alpha and Radau IIA: ``python tests/benchmarks/methods.py [--write]``.

Each case runs at several tolerances with both methods, interleaved. The error is that of positions (over the length
scale) and rotations [rad] at the end, against a run of Radau IIA with a tolerance of 1e-12; CPU time is that of the
time integration alone. --write draws docs/images/work_precision.png and writes the table into docs/step-control.md.
"""

import subprocess
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from time_runs import input_deck

from mecano.analyses.initial_state import set_initial_state
from mecano.analyses.prepare import integrator_of, prepare
from mecano.errors import ConvergenceError
from mecano.model.numbering import ROTATION

CASES = {"heavy_top": 0.5, "bicycle": 1.0, "andrews": 0.03, "four_bar": 1.5, "double_pendulum": 1.0}  # ends [s]
TOLERANCES = {
    "generalized_alpha": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9),
    "radau": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10),
}
REFERENCE, WANTED = 1e-12, 1e-8
NAMES = {"generalized_alpha": "generalized-alpha", "radau": "Radau IIA"}
PAGE, PICTURE = ROOT / "docs" / "step-control.md", ROOT / "docs" / "images" / "work_precision.png"
BEGIN, END = "<!-- methods -->", "<!-- end of methods -->"


def motion(name, method, tolerance):
    """Return (System, final State, accepted steps, CPU time [s]) of a case."""
    control = (f"time.method={method}", f"time.end={CASES[name]}", f"time.adaptive.tolerance={tolerance}")
    deck = input_deck(name, *control)
    prepared = prepare(deck)
    set_initial_state(prepared)
    integrator = integrator_of(prepared)
    run = integrator.begin(prepared.state, deck.values["time"]["step"])
    begun = time.process_time()
    run = integrator.to(CASES[name], run)
    return prepared, run.motion, run.steps, time.process_time() - begun


def error(prepared, s, exact):
    """Return the largest error of positions, over the length scale, and rotations [rad]."""
    of, n_q = prepared.system.numbering, prepared.system.n_q
    place = np.where(of.kind[:n_q] == ROTATION, 0.0, (s.z - exact.z)[:n_q]) / prepared.length
    turn = np.einsum("rji,rjk->rik", exact.R, s.R) - np.eye(3)
    return max(np.abs(place).max(), np.abs(turn).max(initial=0.0))


def measured(name):
    """Return {method: [(tolerance, error, steps, CPU time)]} of a case."""
    _, exact, *_ = motion(name, "radau", REFERENCE)
    found = {method: [] for method in TOLERANCES}
    pairs = [(method, tolerance) for method, all_ in TOLERANCES.items() for tolerance in all_]
    for method, tolerance in sorted(pairs, key=lambda pair: -pair[1]):
        try:
            prepared, s, steps, cpu = motion(name, method, tolerance)
        except ConvergenceError as refused:  # by rounding
            print(f"{name} {method} {tolerance:.0e}: {refused}", flush=True)
            continue
        found[method].append((tolerance, error(prepared, s, exact), steps, cpu))
        print(
            f"{name} {method} {tolerance:.0e}: error {found[method][-1][1]:.1e}, {steps} steps, {cpu:.3f} s", flush=True
        )
    return found


def at(rows, wanted):
    """Return steps and CPU time at an error, (text, number) each; those of the least error if it is not reached."""
    last = int(np.argmin([row[1] for row in rows]))
    errors, steps, cpu = (np.log([row[i] for row in rows[: last + 1]])[::-1] for i in (1, 2, 3))
    at_least = "" if errors[0] <= np.log(wanted) else "> "
    found = [float(np.exp(np.interp(np.log(wanted), errors, of))) for of in (steps, cpu)]
    return [(f"{at_least}{value:.2g}", value) for value in found]


def table(found):
    """Return the table of all cases as Markdown."""
    lines = [
        "| case | unknowns | generalized-alpha: steps | CPU time [s] | Radau IIA: steps | CPU time [s] | ratio |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, rows in found.items():
        (many, long), (few, short) = (at(rows[method], WANTED) for method in TOLERANCES)
        n = prepare(input_deck(name)).system.n
        texts = f"{name}.yaml, {CASES[name]:g} s", n, many[0], long[0], few[0], short[0], f"{short[1] / long[1]:.2f}"
        lines.append("| " + " | ".join(map(str, texts)) + " |")
    return "\n".join(lines)


def draw(found):
    """Draw CPU time over error of all cases."""
    import matplotlib
    from matplotlib.figure import Figure

    from mecano.post.style import COLOURS, SETTINGS

    with matplotlib.rc_context(SETTINGS):
        figure = Figure(figsize=(7.5, 4.0), layout="constrained")
        axes = figure.add_subplot(xscale="log", yscale="log", xlabel="error at the end", ylabel="CPU time [s]")
        axes.xaxis.set_major_formatter("{x:.0e}")
        axes.yaxis.set_major_formatter("{x:g}")
        for i, (name, rows) in enumerate(found.items()):
            for method, style in (("generalized_alpha", "--"), ("radau", "-")):
                _, errors, _, cpu = zip(*rows[method], strict=True)
                axes.plot(errors, cpu, style, marker=".", color=COLOURS[i], label=f"{name}\n{NAMES[method]}")
        axes.invert_xaxis()
        axes.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5))
        figure.savefig(PICTURE, dpi=150)


def write(text):
    """Write the table into its page, with commit and date."""
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout
    page = PAGE.read_text()
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    note = f"(commit {commit.strip()}, {datetime.now(UTC):%Y-%m-%d})"
    PAGE.write_text(f"{before}{BEGIN}\n{text}\n\n{note}\n{END}{after}")


def main():
    """Measure all cases, or those named."""
    names = [name for name in sys.argv[1:] if name in CASES] or CASES
    found = {name: measured(name) for name in names}
    print(table(found))
    if "--write" in sys.argv:
        draw(found)
        write(table(found))


if __name__ == "__main__":
    main()

"""Compare the results of every deck of inputs/ between another clone of mecano and this one.

    python tests/benchmarks/same_results.py ../mecano-before [--out FOLDER] [deck.yaml ...]

Every output must agree within 1e-9 of its largest value in the run, or of 1e-6 in its unit where that is more; what
does not is printed, with the largest difference relative to that. Results that stand in FOLDER already are used again.
The exit code is 1 where something differs.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import click
import h5py
import numpy as np

HERE = Path(__file__).parents[2]
TOLERANCE = 1e-9
LEAST = 1e-6  # size of an output that is rounding alone, such as the slip of a wheel that rolls
APART = ("run/", "solver/", "extremes/")  # times of the machine, norms of residuals, when what is constant was largest


def run(deck, clone, results):
    """Solve a deck with the program of a clone, unless its results are there."""
    if not results.exists():
        results.parent.mkdir(parents=True, exist_ok=True)
        command = [sys.executable, "-m", "mecano", "run", str(deck), "--output", str(results), "--quiet"]
        environment = os.environ | {"PYTHONPATH": str(clone)}
        subprocess.run(command, env=environment, cwd=results.parent, capture_output=True)  # not where a clone is


def arrays(path):
    """Return {name: array} of all floating-point datasets of a results file."""
    found = {}

    def visit(name, item):
        if isinstance(item, h5py.Dataset) and item.dtype.kind == "f" and not name.startswith(APART):
            found[name] = item[()]

    with h5py.File(path) as file:
        file.visititems(visit)
    return found


def difference(a, b):
    """Return the largest difference of two arrays relative to the largest value; infinite for unlike shapes."""
    if a.shape != b.shape or (np.isnan(a) != np.isnan(b)).any():
        return np.inf
    finite = np.isfinite(a)
    if (a[~finite & ~np.isnan(a)] != b[~finite & ~np.isnan(a)]).any() or not finite.any():
        return 0.0 if not finite.any() else np.inf
    return np.abs(a - b)[finite].max() / max(np.abs(a[finite]).max(), LEAST)


@click.command(help=__doc__)
@click.argument("before", type=click.Path(exists=True, path_type=Path))
@click.argument("decks", nargs=-1, type=click.Path(exists=True, path_type=Path))
@click.option("--out", type=click.Path(path_type=Path))
def main(before, decks, out):  # noqa: D103
    out = (out or Path(tempfile.mkdtemp())).resolve()
    unlike = 0
    for deck in decks or sorted((HERE / "inputs").glob("*.yaml")):
        old, new = out / "before" / f"{deck.stem}.h5", out / "after" / f"{deck.stem}.h5"
        run(deck.resolve(), before.resolve(), old)
        run(deck.resolve(), HERE, new)
        if not (old.exists() and new.exists()):
            print(f"{deck.stem:28} no results: before {old.exists()}, after {new.exists()}", flush=True)
            continue
        a, b = arrays(old), arrays(new)
        worst = {name: difference(a[name], b[name]) if name in b else np.inf for name in a}
        above = sorted((name for name in worst if worst[name] > TOLERANCE), key=worst.get, reverse=True)
        unlike += bool(above)
        print(f"{deck.stem:28} {len(a):4} arrays, largest difference {max(worst.values()):.1e}", flush=True)
        for name in above[:5]:
            print(f"    {name}: {worst[name]:.1e}", flush=True)
    sys.exit(unlike > 0)


if __name__ == "__main__":
    main()

"""Spin-up of an arm of 10 m (Simo & Vu-Quoc 1986) cut into superelements: error and cost against the beam model.

    python tests/benchmarks/superelements.py [pieces ...]

The beam model has 32 elements, each superelement is reduced from its share of them. Error: largest difference of the
tip's lag over the run, over the largest lag. Recorded in docs/superelements.md.
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from time_runs import RecordedRun

from mecano.analyses.reduction import reduce_part
from mecano.deck.read import deck_of_bytes
from mecano.errors import MecanoError

ELEMENTS, MODES, LENGTH, END, STEP = 32, 6, 10.0, 15.0, 0.02
SECTION = """
sections:
  arm: {type: stiffness, EA: 2.8e7, GA2: 1.0e7, GA3: 1.0e7, GJ: 1.4e4, EI2: 1.4e4, EI3: 1.4e4,
        mass_per_length: 1.2, rotary_inertia: [1.2e-3, 6.0e-4, 6.0e-4]}
"""
MOTION = """
gravity: [0, 0, 0]
joints:
  bearing: {{type: hinge, nodes: [ground, n0], axis: [0, 0, 1]}}
  motor: {{type: prescribed_angle, nodes: [ground, n0], axis: [0, 0, 1], value: spin_up}}
laws:
  spin_up:
    polynomial: {{coefficients: [-2.279726631, 0, 0.2]}}
    sine: {{amplitude: 2.279726631, frequency: 0.0666666667, phase: 1.5707963268}}
time: {{end: {end}, step: {step}}}
"""


def nodes(n):
    """The section ``nodes`` with n + 1 nodes n0 ... along the arm."""
    places = "\n".join(f"  n{i}: {{position: [{LENGTH * i / n}, 0, 0]}}" for i in range(n + 1))
    return f"mecano: 1\nnodes:\n{places}\n"


def beams(n, end=END, step=STEP):
    """The deck of n beams; the tip is n1."""
    arm = f"elements:\n  arm: {{type: beam, nodes: [n0, n1], section: arm, up: [0, 0, 1], mesh: {n}}}\n"
    return nodes(1) + SECTION + arm + MOTION.format(end=end, step=step)


def superelements(n, folder, end=END, step=STEP, modes=MODES):
    """The deck of n superelements; writes their file."""
    piece = nodes(n).split("  n2:")[0] + SECTION + MOTION.format(end=end, step=step)
    piece += f"elements:\n  arm: {{type: beam, nodes: [n0, n1], section: arm, up: [0, 0, 1], mesh: {ELEMENTS // n}}}\n"
    path = folder / f"piece{n}.npz"
    reduce_part(checked(piece, folder), path, elements=["arm"], nodes=["n0", "n1"], number=modes, force=True)
    lines = "\n".join(f"  s{i}: {{type: superelement, nodes: [n{i}, n{i + 1}], file: {path.name}}}" for i in range(n))
    return nodes(n) + f"elements:\n{lines}\n" + MOTION.format(end=end, step=step)


def checked(text, folder):
    """The checked deck of a text in a folder."""
    return deck_of_bytes(text.encode(), str(folder / "deck.yaml"))


def run(text, folder, tip):
    """Times, lag of the tip [m], its stretch [m], processor time [s], iterations."""
    deck = checked(text, folder)
    RecordedRun(checked(text.replace(f"end: {END}", f"end: {STEP}"), folder))  # compiled
    begun = time.process_time()
    recorded = RecordedRun(deck)
    cost = time.process_time() - begun
    x, t = recorded[f"nodes/{tip}/position"], recorded.time
    angle = 0.2 * t**2 + 2.279726631 * (np.cos(2 * np.pi * 0.0666666667 * t) - 1.0)
    lag = -np.sin(angle) * x[:, 0] + np.cos(angle) * x[:, 1]
    along = np.cos(angle) * x[:, 0] + np.sin(angle) * x[:, 1]
    return t, lag, along - LENGTH, cost, recorded.iterations.sum()


def main(pieces):
    """Print the table."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        times, full, stretch, cost, iterations = run(beams(ELEMENTS), folder, "n1")
        largest = np.abs(full).max()
        print(f"{ELEMENTS} beams: largest lag {largest:.5f} m, stretch at the end {stretch[-1]:.3e} m, {cost:.2f} s, "
              f"{iterations} iterations", flush=True)  # fmt: skip
        for n in pieces:
            try:
                t, lag, stretch, cost, iterations = run(superelements(n, folder), folder, f"n{n}")
            except MecanoError as error:
                print(f"{n} superelements: {str(error)[:300]}", flush=True)
                continue
            error = np.abs(np.interp(times, t, lag) - full).max() / largest
            print(f"{n} superelements: error {100.0 * error:.3f} %, stretch at the end {stretch[-1]:.3e} m, "
                  f"{cost:.2f} s, {iterations} iterations", flush=True)  # fmt: skip


if __name__ == "__main__":
    main([int(text) for text in sys.argv[1:]] or [1, 2, 4, 8])

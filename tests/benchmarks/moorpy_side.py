"""Compare random nets of hanging cables with MoorPy, a library of mooring lines.

    pip install moorpy
    python tests/benchmarks/moorpy_side.py 0 39      # the seeds of the first and the last net

Three to five anchors on a circle and one to three points with masses inside it are joined by elastic cables with
weight, longer than the distances of their ends at the start. MoorPy solves the equations of elastic catenaries; here
cables have a mesh and a sag. Positions are extrapolated from two meshes, of second order, and tensions at the ends of
lines, of the first order. A difference of positions is relative to the radius of the circle.
"""

import contextlib
import io
import sys
import tempfile
from pathlib import Path

import moorpy
import numpy as np

import mecano

GRAVITY, RADIUS, DEEP = 9.81, 8.0, 500.0  # m/s2, m, m: nothing touches the ground
MESHES = (32, 64)


class Net:
    """Random points, of which the first ones are anchors, masses of the others, and lines between them."""

    def __init__(self, seed):
        rng = np.random.default_rng(seed)
        free, self.anchors = int(rng.integers(1, 4)), int(rng.integers(3, 6))
        angles = 2.0 * np.pi * (np.arange(self.anchors) / self.anchors + rng.uniform(0.0, 0.1, self.anchors))
        circle = RADIUS * np.column_stack([np.cos(angles), np.sin(angles)])
        inside = np.column_stack([rng.uniform(-3.0, 3.0, (free, 2)), rng.uniform(-1.0, 1.0, free)])
        self.points = np.vstack([np.column_stack([circle, rng.uniform(0.0, 6.0, self.anchors)]), inside])
        self.masses = rng.uniform(1.0, 30.0, free)
        pairs = [(int(a), self.anchors + i) for i in range(free)
                 for a in rng.choice(self.anchors, int(rng.integers(2, 4)), replace=False)]  # fmt: skip
        pairs += [(self.anchors + i - 1, self.anchors + i) for i in range(1, free)]
        self.lines = [self._line(rng, a, b) for a, b in pairs]

    def _line(self, rng, a, b):
        """Return the ends, length [m], axial stiffness [N] and mass per length [kg/m]."""
        length = np.linalg.norm(self.points[a] - self.points[b]) * rng.uniform(1.02, 1.4)
        return a, b, length, 10 ** rng.uniform(3.5, 5.0), rng.uniform(0.2, 3.0)


def of_moorpy(net):
    """Return the positions (points, 3) [m] and the tensions at the ends of the lines (lines, 2) [N]."""
    sea = moorpy.System(depth=2.0 * DEEP, rho=0.0, g=GRAVITY)
    masses = [0.0] * net.anchors + list(net.masses)
    for i, (x, mass) in enumerate(zip(net.points, masses, strict=True)):
        sea.addPoint(1 if i < net.anchors else 0, x - [0.0, 0.0, DEEP], m=mass, v=0.0)
    for k, (a, b, length, stiffness, mass) in enumerate(net.lines):
        sea.lineTypes[f"line_{k}"] = {
            "name": f"line_{k}", "d_vol": 1e-6, "m": mass, "w": mass * GRAVITY, "EA": stiffness, "cost": 0.0,
            "notes": "", "input_type": "", "input_d": 1e-6, "material": "", "EAd": 0.0, "EAd_Lm": 0.0,
        }  # fmt: skip
        sea.addLine(length, f"line_{k}", pointA=a + 1, pointB=b + 1)
    with contextlib.redirect_stdout(io.StringIO()):
        sea.initialize()
        sea.solveEquilibrium(tol=1e-8, maxIter=2000)
    ends = [[np.linalg.norm(line.fA), np.linalg.norm(line.fB)] for line in sea.lineList]
    return np.array([point.r for point in sea.pointList]) + [0.0, 0.0, DEEP], np.array(ends)


def of_mecano(net, mesh, path):
    """Return the same; the results are written to ``path``."""
    used = {i for line in net.lines for i in line[:2]}
    masses = {f"mass_{i}": {"type": "point_mass", "node": f"point_{net.anchors + i}", "mass": mass}
              for i, mass in enumerate(net.masses)}  # fmt: skip
    lines = {f"line_{k}": {"type": "cable", "nodes": [f"point_{a}", f"point_{b}"], "natural_length": length,
                           "axial_stiffness": stiffness, "mass_per_length": mass, "mesh": mesh, "sag": [0, 0, -1]}
             for k, (a, b, length, stiffness, mass) in enumerate(net.lines)}  # fmt: skip
    deck = mecano.Deck({
        "gravity": [0, 0, -GRAVITY], "elements": masses | lines, "static": {"method": "relaxation"},
        "nodes": {f"point_{i}": {"position": net.points[i], "fixed": i < net.anchors} for i in sorted(used)},
    })  # fmt: skip
    results = mecano.run(deck, path, quiet=True, force=True)
    positions = [results[f"nodes.point_{i}.position"][-1] if i in used else x for i, x in enumerate(net.points)]
    ends = [[results[f"elements.line_{k}.{i}.tension"][-1] for i in (1, mesh)] for k in range(len(net.lines))]
    return np.array(positions), np.array(ends)


def differences(seed, folder):
    """Return the largest differences of positions and tensions, and the error of positions of the finer mesh."""
    net = Net(seed)
    x, ends = of_moorpy(net)
    (coarse, ends_coarse), (fine, ends_fine) = (of_mecano(net, mesh, Path(folder) / "net.h5") for mesh in MESHES)
    limit = fine + (fine - coarse) / 3.0
    tension = np.abs(2.0 * ends_fine - ends_coarse - ends).max() / ends.max()
    return np.abs(limit - x).max() / RADIUS, tension, np.abs(fine - limit).max() / RADIUS


def main(first, last):
    """Print the differences of each net, and the largest of all."""
    worst = np.zeros(2)
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(first, last + 1):
            position, tension, error = differences(seed, folder)
            print(f"{seed}: positions {position:.1e} (mesh: {error:.1e}), tensions {tension:.1e}", flush=True)
            worst = np.maximum(worst, [position, tension])
    print(f"at most: positions {worst[0]:.1e}, tensions {worst[1]:.1e}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))

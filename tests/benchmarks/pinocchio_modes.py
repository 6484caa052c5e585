"""Compare equilibria and eigenvalues of random mechanisms with Pinocchio: ``python .../pinocchio_modes.py 1 60``.

The mechanisms are those of pinocchio_side.py without loops and without spherical and planar joints, which have no
springs of their own, and with stiffer springs. The reference refines the coordinates of the equilibrium until the
accelerations vanish, and finds the eigenvalues of differences of the accelerations.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
import pinocchio_side
import yaml
from pinocchio_side import Mechanism, Reference, deck
from scipy.optimize import root

import mecano

STEP = 1e-6, 1e-3  # of differences, by coordinates and rates
COORDINATES = {
    "hinge": ["angle"],
    "screw": ["angle"],
    "prismatic": ["displacement"],
    "cylindrical": ["displacement", "angle"],
    "universal": ["angle_a", "angle_b"],
}


def stiff_tree(seed):
    """Return a Mechanism with springs in all joints that hold it near its start."""
    mechanism = Mechanism(seed)
    mechanism.closures = []
    for body in mechanism.bodies[1:]:
        body["turning"] = body["turning"] * [20.0, 1.0] + [40.0, 0.0]
        body["sliding"] = body["sliding"] * [20.0, 1.0] + [100.0, 0.0]
    return mechanism


def linearized(reference, q):
    """Return d(v, a)/d(q, v) at rest by central differences, of fourth order by coordinates."""
    n, rest = len(q), np.zeros(len(q))
    matrix = np.zeros((2 * n, 2 * n))
    matrix[:n, n:] = np.eye(n)
    for k, unit in enumerate(np.eye(n)):
        near, far = (difference(lambda x: reference.accelerations(q + x, rest)[0], unit * h * STEP[0]) for h in (1, 2))
        matrix[n:, k] = (8.0 * near - far) / (12.0 * STEP[0])
        rates = difference(lambda x: reference.accelerations(q, x)[0], unit * STEP[1])
        matrix[n:, n + k] = rates / (2.0 * STEP[1])
    return matrix


def difference(function, x):
    return function(x) - function(-x)


def differences(seed, folder):
    """Return the differences of the coordinates, absolute, and of the eigenvalues, relative or to 1 / s."""
    mechanism, path = stiff_tree(seed), Path(folder) / f"{seed}.yaml"
    text = deck(mechanism) | {"initial": {"static": True}, "time": {"end": 1e-3, "step": 1e-3}}
    path.write_text(yaml.safe_dump(text, sort_keys=False))
    results = mecano.run(path, path.with_suffix(".h5"), quiet=True)
    found = np.array([
        results[f"joints.joint_{i}.{name}"][0]
        for i, body in enumerate(mechanism.bodies[1:], 1)
        for name in COORDINATES[body["joint"]]
    ])  # fmt: skip
    reference = Reference(mechanism)
    q = root(lambda q: reference.accelerations(q, np.zeros(len(q)))[0], found, tol=1e-13).x
    expected = np.linalg.eigvals(linearized(reference, q))
    modes = np.asarray(mecano.modes(path, number=len(expected)).eigenvalues)
    nearest = np.abs(modes[:, None] - expected).min(axis=1) / np.maximum(np.abs(modes), 1.0)
    assert len(modes) == np.sum(expected.imag >= 0.0)
    return np.abs(q - found).max(), nearest.max()


def main(first, last):
    """Print the differences of each mechanism, and the largest."""
    with tempfile.TemporaryDirectory() as folder:
        found = []
        for seed in range(first, last + 1):
            found.append(differences(seed, folder))
            print("{}: coordinates {:.1e}, eigenvalues {:.1e}".format(seed, *found[-1]), flush=True)
    print("at most {:.1e}, {:.1e}".format(*np.max(found, axis=0)))


if __name__ == "__main__":
    for joint in ("spherical", "planar"):
        del pinocchio_side.FREEDOM[joint]
    main(*map(int, sys.argv[1:]))

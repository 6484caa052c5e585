"""Compare the eigenvalues of random bicycles with BicycleParameters, a library of Whipple's model.

    pip install bicycleparameters
    python tests/benchmarks/bicycle_side.py 0 199      # the seeds of the first and the last bicycle

A bicycle has random wheels, frame and fork, trail and tilt of the steering axis, and a speed. BicycleParameters gives
the four eigenvalues by the linear equations of Meijaard, Papadopoulos, Ruina & Schwab (Proc. R. Soc. A 463 (2007)
1955-1982); here rigid wheels roll on a plane. A difference is relative to the modulus.
"""

import math
import sys

import numpy as np
from bicycleparameters.models import Meijaard2007Model
from bicycleparameters.parameter_sets import Meijaard2007ParameterSet

import mecano


def bicycle(seed):
    """Return the parameters of the paper: its z points down, x forward, from the contact of the rear wheel."""
    rng = np.random.default_rng(seed)
    uniform, w = rng.uniform, rng.uniform(0.8, 1.4)
    b = {
        "w": w, "c": uniform(-0.02, 0.15), "lam": uniform(-0.1, 0.6), "g": 9.81, "v": uniform(0.5, 9.0),
        "rR": uniform(0.15, 0.4), "mR": uniform(1, 5), "rF": uniform(0.15, 0.45), "mF": uniform(1, 5),
        "xB": uniform(0.1, 0.7) * w, "zB": -uniform(0.5, 1.2), "mB": uniform(20, 120),
        "xH": uniform(0.7, 1.1) * w, "zH": -uniform(0.5, 0.9), "mH": uniform(2, 8),
    }  # fmt: skip
    for wheel in "RF":
        polar = b[f"m{wheel}"] * b[f"r{wheel}"] ** 2 * uniform(0.6, 0.95)
        b |= {f"I{wheel}yy": polar, f"I{wheel}xx": polar * uniform(0.5, 0.6)}
    for part, size in (("B", 0.4), ("H", 0.15)):
        m, breadth = b[f"m{part}"], uniform(0.2, 1.0) * size
        x, z = size * rng.normal(size=(2, 3))  # of three points in the plane of symmetry
        x, z = x - x.mean(), z - z.mean()
        b |= {f"I{part}xx": m * (breadth**2 + z @ z), f"I{part}yy": m * (x @ x + z @ z),
              f"I{part}zz": m * (breadth**2 + x @ x), f"I{part}xz": -m * (x @ z)}  # fmt: skip
    return {name: float(value) for name, value in b.items()}


def deck(b):
    """Return the deck of a bicycle, in axes with z up."""
    up = np.array([-math.sin(b["lam"]), 0.0, math.cos(b["lam"])])  # steering axis
    head = np.array([b["w"] + b["c"], 0.0, 0.0]) + 0.8 / math.cos(b["lam"]) * up
    places = {
        "frame": [b["xB"], 0, -b["zB"]], "frame_rear": [0, 0, b["rR"]], "frame_head": head, "rear": [0, 0, b["rR"]],
        "fork": [b["xH"], 0, -b["zH"]], "fork_front": [b["w"], 0, b["rF"]], "fork_head": head,
        "front": [b["w"], 0, b["rF"]],
    }  # fmt: skip
    elements = {
        "frame": body(b, "B", "frame") | {"attached": ["frame_rear", "frame_head"]},
        "fork": body(b, "H", "fork") | {"attached": ["fork_front", "fork_head"]},
    }
    for letter, name in (("R", "rear"), ("F", "front")):
        across, polar = b[f"I{letter}xx"], b[f"I{letter}yy"]
        rim = {"type": "rigid_body", "node": name, "mass": b[f"m{letter}"], "inertia": [across, polar, across]}
        wheel = {"type": "rigid_wheel", "node": name, "radius": b[f"r{letter}"], "axis": [0, 1, 0], "ground": "road"}
        elements |= {f"{name}_rim": rim, f"{name}_wheel": wheel}
    return mecano.Deck({
        "gravity": [0, 0, -b["g"]], "elements": elements,
        "nodes": {name: {"position": x} for name, x in places.items()},
        "joints": {"rear_axle": hinge("frame_rear", "rear", [0, 1, 0]),
                   "front_axle": hinge("fork_front", "front", [0, 1, 0]),
                   "steering": hinge("frame_head", "fork_head", up)},
        "grounds": {"road": {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}},
        "initial": {"steady": {"velocity": [b["v"], 0, 0]}}, "time": {"end": 1, "step": 0.01},
    })  # fmt: skip


def body(b, part, node):
    """Return the body of frame or fork; the product of inertia changes its sign with z."""
    xx, yy, zz, xz = (b[f"I{part}{axes}"] for axes in ("xx", "yy", "zz", "xz"))
    return {"type": "rigid_body", "node": node, "mass": b[f"m{part}"], "inertia": [xx, yy, zz, 0, -xz, 0]}


def hinge(a, b, axis):
    """Return a hinge of the nodes ``a`` and ``b``."""
    return {"type": "hinge", "nodes": [a, b], "axis": axis}


def difference(seed):
    """Return the largest difference of the four eigenvalues, relative."""
    b = bicycle(seed)
    expected = np.ravel(Meijaard2007Model(Meijaard2007ParameterSet(b, True)).calc_eigen()[0])
    found = np.asarray(mecano.modes(deck(b), number=20).eigenvalues)
    found = np.concatenate([found, found.conj()])
    return max(np.abs(found - value).min() / abs(value) for value in expected)


def main(first, last):
    """Print the difference of each bicycle, and the largest of all."""
    found = {}
    for seed in range(first, last + 1):
        found[seed] = difference(seed)
        print(f"{seed}: {found[seed]:.1e}", flush=True)
    print(f"at most {max(found.values()):.1e}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))

"""A lattice mast of flexible beams, from 1,000 to 100,000 unknowns: cost of statics and of dynamics per unknown.

    python tests/benchmarks/mast.py [unknowns ...]

Three longerons, and in every bay of 1 m three battens and three diagonals, all welded, each of four beam elements. A
force across the tip bends it, statically, by about a thousandth of its length; without the force it then swings for 100
steps. CPU of the preparation, of one static solution (with the judgement of its stability), of the steps, and the
memory, each size in a process of its own, one thread. Recorded in docs/benchmarks.md.
"""

import json
import math
import os
import resource
import subprocess
import sys
import time

for _variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")

import yaml

MESH, SIDE, BAY = 4, 1.0, 1.0  # elements of a member; of a batten, of a bay [m]
UNKNOWNS_OF_BAY = 6 * (3 + 9 * (MESH - 1))
STEPS = 100
FORCE = 3e6  # times 1/bays^2: the tip moves by about a thousandth of the length [N]


def deck(bays):
    """The deck as bytes."""
    corners = [(SIDE / math.sqrt(3) * math.cos(a), SIDE / math.sqrt(3) * math.sin(a)) for a in (0, 2.0944, 4.1888)]
    nodes, elements = {}, {}
    for i in range(bays + 1):
        for j, (x, y) in enumerate(corners):
            nodes[f"n{i}_{j}"] = {"position": [x, y, i * BAY]}

    def beam(name, first, last):
        elements[name] = {"type": "beam", "nodes": [first, last], "section": "tube", "mesh": MESH}

    for i in range(bays):
        for j in range(3):
            beam(f"longeron{i}_{j}", f"n{i}_{j}", f"n{i + 1}_{j}")
            beam(f"diagonal{i}_{j}", f"n{i}_{j}", f"n{i + 1}_{(j + 1) % 3}")
            beam(f"batten{i}_{j}", f"n{i + 1}_{j}", f"n{i + 1}_{(j + 1) % 3}")
    tube = {"type": "tube", "diameter": 0.05, "thickness": 0.003, "E": 70e9, "nu": 0.33, "density": 2700}
    fixed = {f"foot{j}": {"type": "fixed", "nodes": ["ground", f"n0_{j}"]} for j in range(3)}
    pull = {"type": "force", "node": f"n{bays}_0", "direction": [0, 1, 0], "value": FORCE / bays**2}
    return yaml.safe_dump({
        "mecano": 1, "gravity": [0, 0, 0], "sections": {"tube": tube}, "nodes": nodes, "elements": elements,
        "joints": fixed, "loads": {"pull": pull}, "time": {"end": 1.0, "step": 1e-3},
    }, sort_keys=False).encode()  # fmt: skip

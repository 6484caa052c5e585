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
STEPS, STEP = 100, 1e-3  # [s]
FORCE = 4e4  # times 1/bays^2: the tip moves by about a thousandth of the length [N]


def deck(bays, **analysis):
    """The deck as bytes; ``analysis``: its section static or time."""
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
        "joints": fixed, "loads": {"pull": pull}, **analysis,
    }, sort_keys=False).encode()  # fmt: skip


def measured(bays):
    """Everything about one size, as a dictionary."""
    from mecano.analyses.equilibria import follow
    from mecano.analyses.prepare import integrator_of, prepare
    from mecano.deck.read import deck_of_bytes

    def prepared(bays, **analysis):
        return prepare(deck_of_bytes(deck(bays, **analysis), "mast"))

    statics, motion = {"static": {"steps": 1}}, {"time": {"end": 1.0, "step": STEP}}
    follow(prepared(2, **statics))  # compiles
    found, start = {}, time.process_time()
    static = prepared(bays, **statics)
    found["prepare"], start = time.process_time() - start, time.process_time()
    result = follow(static)
    found["static"] = time.process_time() - start
    tip = static.system.numbering.x[[node.name for node in static.system.nodes].index(f"n{bays}_0")]
    found["deflection"] = float(result.point.state.z[tip + 1] - static.state.z[tip + 1])
    found["unstable"] = int(result.point.stability.unstable)
    found["unknowns"] = static.system.n
    del static, result
    moving = prepared(bays, **motion)
    integrator = integrator_of(moving)
    start = time.process_time()
    run = integrator.begin(moving.state, STEP)
    found["begin"], start = time.process_time() - start, time.process_time()
    run = integrator.to(STEPS * STEP, run)
    found["steps"] = time.process_time() - start
    found["iterations"], found["accepted"] = run.iterations, run.steps
    found["memory"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return found


def main():
    """Measure every size in a process of its own."""
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(measured(int(sys.argv[2]))))
        return
    for unknowns in [int(text) for text in sys.argv[1:]] or [1_000, 10_000, 100_000]:
        bays = round(unknowns / UNKNOWNS_OF_BAY)
        one = subprocess.run([sys.executable, __file__, "--one", str(bays)], stdout=subprocess.PIPE, check=True)
        found = json.loads(one.stdout)
        n = found["unknowns"]
        print(
            f"{n:7d} unknowns: prepared in {found['prepare']:.2f} s; static {found['static']:.2f} s, "
            f"{1e6 * found['static'] / n:.1f} us per unknown; start {found['begin']:.2f} s; {found['accepted']} steps "
            f"of {found['iterations']} iterations in {found['steps']:.2f} s, "
            f"{1e6 * found['steps'] / n / STEPS:.2f} us per unknown and step; {found['memory']:.0f} MiB; tip at "
            f"{found['deflection']:.3g} m, {found['unstable']} unstable directions",
            flush=True,
        )


if __name__ == "__main__":
    main()

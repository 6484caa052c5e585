"""A lattice mast of flexible beams, from 1,000 to a million unknowns: cost of statics and of dynamics per unknown.

    python tests/benchmarks/mast.py [unknowns ...]

Three longerons, and in every bay of 1 m three battens and three diagonals, all welded, each of four beam elements. A
force across the tip bends it, statically, by about a thousandth of its length; without the force it then swings for 100
steps. Wall-clock time of the preparation (from the text of the deck), of one static solution (with the judgement of its
stability) and of the steps, by one thread and by two in turn, and the memory, each size in a process of its own.
Recorded in docs/benchmarks.md.
"""

import gc
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
THREADS = [1, 2]
LARGE = 500_000  # unknowns from which on nothing is repeated
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


class Clock:
    """Wall-clock time [s] since the last look."""

    def __init__(self):
        self.last = time.perf_counter()

    def look(self):
        before, self.last = self.last, time.perf_counter()
        return self.last - before


def measured(bays, repeats):
    """Everything about one size, as a dictionary; static solution and steps: the fastest of ``repeats``, by threads."""
    from mecano.analyses.equilibria import follow
    from mecano.analyses.prepare import integrator_of, prepare
    from mecano.deck.read import deck_of_bytes
    from mecano.jit import thread_pool

    gc.set_threshold(200_000, 20, 20)  # as the command does (__main__.py)
    statics, motion = {"static": {"steps": 1}}, {"time": {"end": 1.0, "step": STEP}}
    follow(prepare(deck_of_bytes(deck(2, **statics), "mast")))  # compiles
    text, clock = deck(bays, **statics), Clock()
    static = prepare(deck_of_bytes(text, "mast"))
    found = {"prepare": clock.look(), "unknowns": static.system.n}
    times, bits = {(what, n): [] for what in ("static", "steps") for n in THREADS}, set()
    for n in THREADS * repeats:
        thread_pool.use(n)
        clock.look()
        result = follow(static)
        times["static", n].append(clock.look())
        bits.add(hash(result.point.state.z.tobytes()))
    tip = static.system.numbering.x[[node.name for node in static.system.nodes].index(f"n{bays}_0")]
    found["deflection"] = float(result.point.state.z[tip + 1] - static.state.z[tip + 1])
    found["unstable"] = int(result.point.stability.unstable)
    del static, result
    moving = prepare(deck_of_bytes(deck(bays, **motion), "mast"))
    integrator = integrator_of(moving)
    clock.look()
    start = integrator.begin(moving.state, STEP)
    found["begin"] = clock.look()
    for n in THREADS * repeats:
        thread_pool.use(n)
        clock.look()
        run = integrator.to(STEPS * STEP, start)
        times["steps", n].append(clock.look())
        bits.add(hash(run.motion.z.tobytes()))
    assert len(bits) == 2, "threads change the bits"
    found["iterations"], found["accepted"] = run.iterations, run.steps
    found["memory"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return found | {f"{what} {n}": min(of) for (what, n), of in times.items()}


def main():
    """Measure every size in a process of its own."""
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(measured(*map(int, sys.argv[2:]))))
        return
    for unknowns in [int(text) for text in sys.argv[1:]] or [1_000, 10_000, 20_000, 100_000]:
        bays, repeats = round(unknowns / UNKNOWNS_OF_BAY), 3 if unknowns < LARGE else 1
        words = [sys.executable, __file__, "--one", str(bays), str(repeats)]
        found = json.loads(subprocess.run(words, stdout=subprocess.PIPE, check=True).stdout)
        n = found["unknowns"]
        static, steps = ([found[f"{what} {n_threads}"] for n_threads in THREADS] for what in ("static", "steps"))
        print(
            f"{n:8d} unknowns: prepared in {found['prepare']:.2f} s; static {static[0]:.2f} s, {static[1]:.2f} s by "
            f"two threads ({static[0] / static[1]:.2f}), {1e6 * static[0] / n:.1f} us per unknown; start "
            f"{found['begin']:.2f} s; {found['accepted']} steps of {found['iterations']} iterations in "
            f"{steps[0]:.2f} s, {steps[1]:.2f} s ({steps[0] / steps[1]:.2f}), "
            f"{1e6 * steps[0] / n / STEPS:.2f} us per unknown and step; {found['memory']:.0f} MiB; tip at "
            f"{found['deflection']:.3g} m, {found['unstable']} unstable directions",
            flush=True,
        )


if __name__ == "__main__":
    main()

"""Line 10: large models, long runs, and memory that is not enough."""

import random
import re
import resource
from functools import partial

import numpy as np
from scorecard.killed import held
from scorecard.outcome import in_command, last_line, unfit
from scorecard.trial import Job, Line

LINES = (
    Line(
        10, "1e5 nodes checked, 1e6 steps at constant memory, linear growth of files, too little memory: exit 7", 5, 25
    ),
)
NODES = 100_000
CHECK_CPU, CHECK_MEMORY = 60.0, 2000.0  # s, MB
STEPS = 1_000_000
GROWTH = 1.1  # memory of a long run over that of a short one
LINEAR = 0.05  # of the bytes per row: how much they may differ between a short and a long run
PREDICTED = 0.25  # of the memory that a run takes
LIMITS = 20
ROWS = (20_000, 40_000, 80_000)
LONG = """mecano: 1
gravity: [0, 0, -9.81]
nodes: {{a: {{position: [0, 0, 1]}}}}
elements: {{m: {{type: point_mass, node: a, mass: 1}}}}
time: {{end: {end}, step: 1e-3}}
output: {{every: {every}}}
"""


def jobs(lines, factor, seed):
    """The single ones, and 20 limits of memory."""
    nodes, steps = (NODES, STEPS) if factor >= 1 else (NODES // 20, STEPS // 50)
    yield Job(10, f"check of {nodes} nodes", partial(large_check, nodes), wall=900.0)
    yield Job(10, f"{steps} steps", partial(many_steps, steps), wall=1800.0)
    yield Job(10, "growth of the file", linear_growth, wall=900.0)
    for share in (1, 4)[: 2 if factor >= 1 else 1]:
        yield Job(
            10, f"predicted memory, {nodes // 50 * share} nodes", partial(prediction, nodes // 50 * share), wall=1800.0
        )
    rng = random.Random(f"{seed} size")
    for i in range(max(round(factor * LIMITS), 2)):
        yield Job(10, f"memory limit {i}", partial(too_little, rng.uniform(0.0, 1.0), nodes // 10), wall=900.0)


def chain(nodes, end="0.01"):
    """A deck of a chain of point masses on springs."""
    links = zip(["wall", *(f"n{i}" for i in range(nodes))], (f"n{i}" for i in range(nodes)), strict=False)
    return "".join((
        "mecano: 1\ngravity: [0, 0, 0]\nnodes:\n  wall: {position: [-1, 0, 0], fixed: true}\n",
        *(f"  n{i}: {{position: [{i}, 0, 0]}}\n" for i in range(nodes)),
        "elements:\n",
        *(f"  m{i}: {{type: point_mass, node: n{i}, mass: 1}}\n" for i in range(nodes)),
        *(f"  s{b[1:]}: {{type: spring_damper, nodes: [{a}, {b}], law: stiff}}\n" for a, b in links),
        "laws: {stiff: {spring: {stiffness: 100}}}\n",
        f"time: {{end: {end}, step: 1e-3}}\noutput: {{every: {end}}}\n",
    ))  # fmt: skip


def large_check(nodes, folder):
    """`check` of a large deck within its time and memory."""
    (folder / "deck.yaml").write_text(chain(nodes))
    outcome = in_command(["check", "deck.yaml"], folder, timeout=800.0)
    if why := unfit(outcome, (0,), cpu=CHECK_CPU):
        return why
    return "" if outcome.memory < CHECK_MEMORY else f"{outcome.memory:.0f} MB"


def many_steps(steps, folder):
    """A run of so many steps takes the memory of one a hundredth as long."""
    memories = []
    for count in (steps // 100, steps):
        (folder / "deck.yaml").write_text(LONG.format(end=count / 1000, every=count / 1e5))
        outcome = in_command(["run", "deck.yaml", "--quiet", "--force"], folder, timeout=1700.0)
        if why := unfit(outcome, (0,), cpu=1700.0):
            return why
        memories.append(outcome.memory)
    return (
        ""
        if memories[1] < GROWTH * memories[0]
        else f"{memories[0]:.0f} MB for {steps // 100} steps, {memories[1]:.0f} MB"
    )


def linear_growth(folder):
    """Bytes for each row of a run are those of a shorter one."""
    sizes = []
    for count in ROWS:
        (folder / "deck.yaml").write_text(LONG.format(end=count / 1000, every="step"))
        outcome = in_command(["run", "deck.yaml", "--quiet", "--force"], folder, timeout=800.0)
        if why := unfit(outcome, (0,), cpu=800.0):
            return why
        sizes.append((folder / "deck.h5").stat().st_size)
    short, long = np.diff(sizes) / np.diff(ROWS)
    return "" if abs(long - short) <= LINEAR * short + 1.0 else f"{short:.0f} bytes a row, then {long:.0f}"


def prediction(nodes, folder):
    """The memory that `check` predicts is what the run takes, within a quarter."""
    (folder / "deck.yaml").write_text(chain(nodes))
    said = in_command(["check", "deck.yaml"], folder, timeout=800.0)
    found = re.search(r"memory\D*?([\d.]+)\s*(MB|GB)", said.out)
    if not found:
        return "check predicts no memory"
    outcome = in_command(["run", "deck.yaml", "--quiet"], folder, timeout=1700.0)
    if why := unfit(outcome, (0,), cpu=1700.0):
        return why
    predicted = float(found[1]) * {"MB": 1.0, "GB": 1000.0}[found[2]]
    return (
        ""
        if abs(predicted - outcome.memory) <= PREDICTED * outcome.memory
        else f"{predicted:.0f} MB predicted, {outcome.memory:.0f} MB taken"
    )


def too_little(share, nodes, folder):
    """RLIMIT_AS somewhere between what Python needs and what the run needs: exit code 7, and no signal."""
    (folder / "deck.yaml").write_text(chain(nodes))
    limit = int((120 + 680 * share) * 2**20)
    outcome = in_command(["run", "deck.yaml", "--quiet"], folder, [(resource.RLIMIT_AS, limit)], timeout=800.0)
    if outcome.code == 0:
        found = held(folder / "deck.h5")
        return "" if isinstance(found, dict) and all(np.isfinite(found["time"])) else "no file is left"
    return (
        unfit(outcome, (7,), cpu=800.0)
        and f"{limit / 2**20:.0f} MB: {unfit(outcome, (7,), cpu=800.0)}; {last_line(outcome.err)[:60]}"
    )

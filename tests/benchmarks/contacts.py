"""Processor time of rigid contacts with friction of many bodies: ``python tests/benchmarks/contacts.py [CASE ...]``.

Balls dropped on a plane, a heap of balls in a box with contacts of every pair, a row of dominoes, a stack of blocks.
The time is that of the time integration, the instants those at which events happen; the digest of the last state shows
whether two clones compute the same: ``PYTHONPATH=../mecano-before python tests/benchmarks/contacts.py CASE``.
"""

import hashlib
import os
import sys
import time
from pathlib import Path

for variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):  # before numpy
    os.environ.setdefault(variable, "1")
sys.path.append(str(Path(__file__).parents[2]))

import numpy as np

from mecano.analyses.prepare import integrator_of, prepare
from mecano.deck.read import deck_of_bytes

FLOOR = "plane: {normal: [0, 0, 1], point: [0, 0, 0]}"
RUNS = 3


def friction(coefficient):
    """Return the entry of a deck."""
    return f"friction: {{coefficient: {coefficient}, regularization: 1 mm/s}}"


def text(nodes, elements, end, more=()):
    """Return a deck of lines of nodes and elements."""
    lines = ["mecano: 1", "gravity: [0, 0, -9.81]", "nodes:", *(f"  {line}" for line in nodes), "elements:"]
    lines += [*(f"  {line}" for line in elements), *more, f"time: {{end: {end}, step: 1 ms, rho_inf: 0}}"]
    return "\n".join(lines)


def balls(n, end=0.7):
    """Balls that fall on a plane and bounce, each at other times."""
    nodes = [f"n{i}: {{position: [{0.3 * i}, 0, {0.3 + 0.01 * i}]}}" for i in range(n)]
    bodies = [f"b{i}: {{type: rigid_body, node: n{i}, mass: 1, inertia: [4.0e-3, 4.0e-3, 4.0e-3]}}" for i in range(n)]
    on = f"{FLOOR}, radius: 0.1, restitution: 0.5, {friction(0.4)}"
    bodies += [f"on{i}: {{type: contact, nodes: [ground, n{i}], {on}}}" for i in range(n)]
    given = [f"    - {{nodes: [n{i}], velocity: [{0.5 + 0.01 * i}, 0.1, 0]}}" for i in range(n)]
    return text(nodes, bodies, end, ["initial:", "  velocities:", *given])


def heap(n, end=0.15):
    """Balls that fall on one another in a box: contacts of all with one another, the floor and four walls."""
    rng, side, nodes, elements = np.random.default_rng(2), 2 if n <= 20 else 3, [], []
    half, of = 0.06 * side + 0.02, f"radius: 0.05, restitution: 0.3, {friction(0.3)}"
    for i in range(n):
        layer, row, column = i // side**2, i // side % side, i % side
        place = np.array([column - (side - 1) / 2, row - (side - 1) / 2, 0.0]) * 0.12 + [0, 0, 0.1 + 0.13 * layer]
        nodes.append(f"n{i}: {{position: {(place + rng.uniform(-0.008, 0.008, 3)).tolist()}}}")
        elements.append(f"b{i}: {{type: rigid_body, node: n{i}, mass: 1, inertia: [1.0e-3, 1.0e-3, 1.0e-3]}}")
        elements.append(f"floor{i}: {{type: contact, nodes: [ground, n{i}], {FLOOR}, {of}}}")
        for wall, (x, y) in enumerate([(1, 0), (-1, 0), (0, 1), (0, -1)]):
            plane = f"plane: {{normal: [{-x}, {-y}, 0], point: [{x * half}, {y * half}, 0]}}"
            elements.append(f"wall{wall}_{i}: {{type: contact, nodes: [ground, n{i}], {plane}, {of}}}")
        elements += [
            f"pair{j}_{i}: {{type: contact, nodes: [n{j}, n{i}], sphere: {{radius: 0.05}}, {of}}}" for j in range(i)
        ]
    return text(nodes, elements, end)


def dominoes(n, end=0.8, height=0.05, thick=0.008, pitch=0.025, mass=0.02):
    """A row of dominoes, the first of which is pushed; they stand on two edges and hit the next by the upper one."""
    nodes, elements, joints = [], [], ["joints:"]
    inertia = mass / 12 * np.array([height**2 + 0.025**2, height**2 + thick**2, thick**2 + 0.025**2])
    for i in range(n):
        x, front, back = i * pitch, i * pitch + thick / 2, i * pitch - thick / 2
        nodes += [f"d{i}: {{position: [{x}, 0, {height / 2}]}}", f"r{i}: {{position: [{front}, 0, 0]}}"]
        nodes += [f"l{i}: {{position: [{back}, 0, 0]}}", f"t{i}: {{position: [{front}, 0, {height}]}}"]
        of = f"mass: {mass}, inertia: {inertia.tolist()}"
        elements.append(f"b{i}: {{type: rigid_body, node: d{i}, attached: [r{i}, l{i}, t{i}], {of}}}")
        elements += [f"f{e}{i}: {{type: contact, nodes: [ground, {e}{i}], {FLOOR}, {friction(0.9)}}}" for e in "rl"]
        if i:
            plane = f"plane: {{normal: [-1, 0, 0], point: [{back}, 0, {height / 2}]}}"
            elements.append(f"hit{i}: {{type: contact, nodes: [d{i}, t{i - 1}], {plane}, {friction(0.2)}}}")
        joints.append(f"  plane{i}: {{type: planar, nodes: [ground, d{i}], axis: [0, 1, 0]}}")
    first = f"nodes: [d0, r0, l0, t0], angular_velocity: [0, {0.6 / height}, 0], about: [{thick / 2}, 0, 0]"
    return text(nodes, elements, end, [*joints, "initial:", "  velocities:", f"    - {{{first}}}"])


def stack(n, end=0.03, side=0.1):
    """Blocks that stand on one another, with contacts at four corners each."""
    nodes, elements = [], []
    for i in range(n):
        nodes.append(f"b{i}: {{position: [0, 0, {(i + 0.5) * side}]}}")
        plane = f"plane: {{normal: [0, 0, 1], point: [0, 0, {i * side}]}}, {friction(0.5)}"
        for c, (x, y) in enumerate([(1, 1), (1, -1), (-1, 1), (-1, -1)]):
            nodes.append(f"c{i}_{c}: {{position: [{x * side / 2}, {y * side / 2}, {i * side}]}}")
            elements.append(
                f"on{i}_{c}: {{type: contact, nodes: [{f'b{i - 1}' if i else 'ground'}, c{i}_{c}], {plane}}}"
            )
        own, inertia = [f"c{i}_{c}" for c in range(4)], [side**2 / 6] * 3
        elements.append(f"body{i}: {{type: rigid_body, node: b{i}, attached: {own}, mass: 1, inertia: {inertia}}}")
    return text(nodes, elements, end)


CASES = {f"{kind.__name__}-{n}": (kind, n) for kind, sizes in (
    (balls, (5, 20, 60)), (heap, (5, 20, 40)), (dominoes, (5, 20)), (stack, (5, 20)),
) for n in sizes}  # fmt: skip


def measured(name):
    """Return (CPU [s], instants of events, steps, digest of the last state) of a case."""
    kind, n = CASES[name]
    deck = deck_of_bytes(kind(n).encode(), f"{name}.yaml")
    prepared, instants = prepare(deck), []
    integrator = integrator_of(prepared)
    notify = integrator._notify
    integrator._notify = lambda accepted: (instants.extend([1] * bool(accepted.event_records)), notify(accepted))
    begin = time.process_time()
    run = integrator.begin(prepared.state, deck.values["time"]["step"])
    run = integrator.to(deck.values["time"]["end"], run)
    took, s = time.process_time() - begin, run.motion
    digest = hashlib.sha256(b"".join((x + 0.0).tobytes() for x in (s.z, s.v, s.R))).hexdigest()
    return took, len(instants), run.steps, digest[:8]


def main(names):
    print("| case | CPU [s] | instants of events | steps | last state |\n|---|---|---|---|---|")
    for name in names or CASES:
        found = [measured(name) for _ in range(RUNS)]
        took, *rest = sorted(found)[RUNS // 2]
        print(f"| {name} | {took:.3g} | {' | '.join(map(str, rest))} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])

"""What reference runs cost, in counts that do not depend on the machine.

Steps, Newton iterations, factorizations; lines of the functions that a first run compiles.
"""

import pytest
from test_reflector import writer
from time_runs import input_deck

from mecano.analyses import dynamic
from mecano.analyses.compilation import GENERALIZED_ALPHA, TIME_INTEGRATION
from mecano.analyses.prepare import prepare
from mecano.deck.read import deck_of_bytes
from mecano.jit import digest
from mecano.model import loop_code
from mecano.solve.linear.sparse import LinearSolver

GROWTH = 1.03  # from which on a count is one of a slower program: find out why, or say why it must be so
REFERENCE = {  # deck and overrides: steps accepted, Newton iterations of all trials, factorizations
    ("pendulum",): (2000, 2000, 4),
    ("double_pendulum",): (5000, 10616, 660),
    ("four_bar",): (3000, 6434, 324),
    ("rolling_disc",): (4000, 7826, 174),
    ("nose_gear_rigid", "time.end=0.8"): (687, 1927, 749),
    ("strut", "time.end=1"): (1001, 1299, 33),
    ("bouncing_ball",): (535, 535, 336),
    ("flexible_pendulum", "time.end=0.2"): (200, 468, 81),
    ("car", "time.end=1", "time.adaptive={tolerance: 1.0e-3}"): (133, 263, 271),
    ("reflector",): (411, 876, 575),
    ("andrews", "time.method=radau", "time.adaptive={tolerance: 1.0e-8}", "time.end=0.003"): (27, 53, 55),
}

CHAIN = """
mecano: 1
gravity: [0, 0, -9.81]
nodes:
  a$i: {{repeat: {{i: 1..{n}}}, position: [$i - 1, 0, 0]}}
  b$i: {{repeat: {{i: 1..{n}}}, position: [$i, 0, 0]}}
elements:
  link$i:
    {{repeat: {{i: 1..{n}}}, type: rigid_body, node: a$i, attached: [b$i], mass: 1, center_of_mass: [0.5, 0, 0],
     inertia: [4.2e-4, 8.35e-2, 8.35e-2]}}
joints:
  hinge1: {{type: hinge, nodes: [ground, a1], axis: [0, 1, 0]}}
  hinge$i: {{repeat: {{i: 2..{n}}}, type: hinge, nodes: [b$(i - 1), a$i], axis: [0, 1, 0]}}
time: {{end: 1, step: 1 ms, rho_inf: 0.9}}
output: {{every: 100 ms}}
"""  # that of tests/benchmarks, of n bars
CHAINS = {10: (1000, 2162, 170), 100: (1000, 2006, 240)}  # bars: the same counts

COMPILED = {"pendulum": (31, 2138), "nose_gear_rigid": (48, 2959)}  # machine code objects, lines of their functions


SEVEN_MODULES = {  # end [s]: the same counts of a reflector, instants with events, instants with shocks
    0.1: (19, 77, 134, 16, 0),
    5.8: (320, 705, 895, 38, 2),
    7.25: (507, 2503, 3309, 164, 63),
}


def counts(deck, path, monkeypatch, observers=()):
    """(steps, iterations, factorizations) of a run."""
    solve, solved, integrators = LinearSolver.solve, [], []
    original = dynamic.integrator_of

    def counted(*arguments, **options):
        solved.append(1)
        return solve(*arguments, **options)

    def integrator_of(prepared):
        integrators.append(original(prepared))
        return integrators[0]

    monkeypatch.setattr(LinearSolver, "solve", counted)
    monkeypatch.setattr(
        dynamic, "integrator_of", lambda *given: integrators.append(integrator_of(*given)) or integrators[0]
    )
    final = dynamic.run(deck, path, observers=observers)
    renewed = int(integrators[0].method.workspace.record["factorizations"][0])
    return final.steps, final.iterations, renewed + len(solved)


def cost_no_more(found, reference):
    for what, now, before in zip(("steps", "Newton iterations", "factorizations"), found, reference, strict=True):
        assert now <= GROWTH * before, f"{what}: {now}, were {before}; all counts: {found}"
        assert now >= before / GROWTH, f"{what}: {now}, were {before}: enter the better counts {found}"


@pytest.mark.parametrize("deck", REFERENCE, ids=lambda deck: deck[0])
def test_reference_runs_cost_no_more(deck, tmp_path, monkeypatch):
    found = counts(input_deck(*deck), tmp_path / "r.h5", monkeypatch)
    cost_no_more(found, REFERENCE[deck])


@pytest.mark.parametrize("n", CHAINS)
def test_chains_of_rigid_bodies_cost_no_more(n, tmp_path, monkeypatch):
    found = counts(deck_of_bytes(CHAIN.format(n=n).encode(), "chain"), tmp_path / "r.h5", monkeypatch)
    cost_no_more(found, CHAINS[n])


@pytest.mark.parametrize("end", [0.1, 5.8, pytest.param(7.25, marks=pytest.mark.slow)])
def test_events_of_seven_modules_cost_no_more(end, tmp_path, monkeypatch):
    module, instants, shocks = writer(), set(), set()
    options = f"--modules 7 --curvature 20 --step 0.02 --end {end}".split()
    deck = deck_of_bytes(module.deck(module.options(options)).encode(), "seven_modules")

    def observe(accepted):
        instants.update(event.t for event in accepted.event_records)
        shocks.update(event.t for event in accepted.event_records if event.unit)

    found = *counts(deck, tmp_path / "r.h5", monkeypatch, (observe,)), len(instants), len(shocks)
    names = "steps", "Newton iterations", "factorizations", "instants", "shocks"
    for what, now, before in zip(names, found, SEVEN_MODULES[end], strict=True):
        assert now <= GROWTH * before, f"{what}: {now}, were {before}; all counts: {found}"
        if what != "Newton iterations":  # 80 or 85 at the events of equal members, by the rounding of the processor
            assert now >= before / GROWTH, f"{what}: {now}, were {before}: enter the better counts {found}"


@pytest.mark.parametrize("name", COMPILED)
def test_a_first_run_compiles_no_more_lines(name, monkeypatch):
    def forget():
        for codes in (loop_code._code, loop_code.loop_code):
            codes.cache_clear()
        digest._digests.clear()

    monkeypatch.setattr(digest, "_digests", {})
    forget()
    system = prepare(input_deck(name)).system
    forget()
    objects = {
        code.file for code in (*(entry.code for entry in (*GENERALIZED_ALPHA, *TIME_INTEGRATION)), *system.codes())
    }
    found = len(objects), sum(map(_lines, digest._digests))
    for what, now, before in zip(("objects", "lines"), found, COMPILED[name], strict=True):
        assert now <= GROWTH * before, f"{what}: {now}, were {before}; both counts: {found}"
        assert now >= before / GROWTH, f"{what}: {now}, were {before}: enter the better counts {found}"


def _lines(function):
    """Return the number of lines with code of a function."""
    return len({line for *_, line in function.__code__.co_lines() if line})

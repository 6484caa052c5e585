"""Models in halves, on which two threads work: the division, the same bits for any number of threads."""

import ctypes
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from surviving import StopAfter, check_same, contents, ended, forked
from test_linear import ACCURATE, MODELS, beam_chain, chain, mechanism, mesh
from time_runs import INPUTS, RecordedRun, input_deck

import mecano
from mecano.analyses.dynamic import resume, run
from mecano.analyses.equilibria import follow
from mecano.analyses.prepare import prepare
from mecano.errors import UsageError
from mecano.jit import thread_pool
from mecano.jit.entry import entry
from mecano.jit.thread_pool import run_parts
from mecano.model import halves as module
from mecano.model.halves import ONE, OTHER, halves
from mecano.model.loop_code import codes_of
from mecano.model.loops import residual
from mecano.process.interrupt import Stopped
from mecano.solve.linear.symbolic_analysis import PIVOTS, SIZE

SMALL = 20  # unknowns from which on models are divided here
DYNAMIC = {  # decks of many kinds, with events, wheels, contacts, signals, members, redundant constraints
    "nose_gear_rigid": "time.end=0.3", "nose_landing_gear": "time.end=0.2",
    "flexible_pendulum": "time.end=0.1", "reflector": "time.end=0.02",
}  # fmt: skip


@pytest.fixture(autouse=True)
def divided(monkeypatch):
    """Have also small models divided, however many unknowns lie between the halves."""
    monkeypatch.setattr(module, "LARGE", SMALL)
    monkeypatch.setattr(module, "PRICE", 1)
    monkeypatch.setattr(module, "MOST", 0.999)
    before = thread_pool._wanted
    yield
    thread_pool.use(before)


def two_chains(n):
    """Two chains that nothing connects."""
    hinges = [(i, i + 1) for i in range(2 * n - 1) if i != n - 1]
    return mechanism(2 * n, [], hinges, [(0, 5), (n, 5)])


PROBLEMS = {name: build for name, build in MODELS.items() if name != "star" and build().n >= 2 * SMALL} | {
    "long chain": lambda: chain(300), "long beams": lambda: beam_chain(400), "large mesh": lambda: mesh(16),
    "two chains": lambda: two_chains(20),
}  # fmt: skip


def part_of(problem):
    return halves(problem.n, problem.rows.astype(np.int64), problem.cols.astype(np.int64), problem.groups)


class TestHalves:
    @pytest.mark.parametrize("name", PROBLEMS)
    def test_no_entry_couples_them(self, name):
        problem = PROBLEMS[name]()
        part = part_of(problem)
        rows, cols = part[problem.rows], part[problem.cols]
        assert set(np.unique(part)) >= {ONE, OTHER}
        assert not np.any((rows == ONE) & (cols == OTHER)) and not np.any((rows == OTHER) & (cols == ONE))

    @pytest.mark.parametrize("name", PROBLEMS)
    def test_multipliers_follow_all_their_unknowns(self, name):
        problem = PROBLEMS[name]()
        part, tied = part_of(problem), problem.rows >= problem.n_q
        assert np.all(part[problem.rows[tied]] >= part[problem.cols[tied]])

    @pytest.mark.parametrize("build", [lambda: chain(300), lambda: beam_chain(400), lambda: two_chains(50)])
    def test_of_a_chain_one_node_lies_between_them(self, build):
        """Of 6 unknowns, with the five multipliers of each hinge that is cut, or has the node on one side: three."""
        one, other, rest = np.bincount(part_of(build()), minlength=3)
        assert rest <= 6 + 3 * 5 and abs(one - other) <= 6 + 3 * 5

    @pytest.mark.parametrize("build", [lambda: chain(300), lambda: beam_chain(400), lambda: mesh(20)])
    def test_each_half_is_half_of_the_work(self, build):
        """By the fronts: their pivots times the squares of their sizes."""
        problem = build()
        analysis = problem.solver(parts=part_of(problem)).analysis
        cost = analysis.fronts[:, PIVOTS] * analysis.fronts[:, SIZE] ** 2
        one, other, rest = (part.sum() / cost.sum() for part in np.split(cost, analysis.ends[:-1]))
        assert max(one, other) + rest <= 1 / 1.6  # 1.6 times as fast

    def test_small_models_and_those_without_a_small_separator_stay_whole(self, monkeypatch):
        dense = mechanism(40, [(i, j) for i in range(40) for j in range(i)], [], [])
        monkeypatch.setattr(module, "PRICE", 4)
        monkeypatch.setattr(module, "MOST", 0.6)
        assert part_of(dense) is None
        monkeypatch.setattr(module, "LARGE", chain(300).n + 1)
        assert part_of(chain(300)) is None


class TestFactorization:
    @pytest.mark.parametrize("name", PROBLEMS)
    def test_in_halves_it_solves_the_same_equations(self, name):
        problem = PROBLEMS[name]()
        solver, b, x, again = problem.solver(parts=part_of(problem)), problem.rhs(), *np.zeros((2, problem.n))
        status = solver.solve(problem.data, b, x)
        assert status.ok and not status.fallback and problem.error(x, b) < ACCURATE
        solver.solve_again(b, again)
        np.testing.assert_allclose(again, x, rtol=1e-7, atol=1e-9 * np.abs(x).max())
        b_and_x = b.copy()
        solver.solve_again(b_and_x, b_and_x)
        np.testing.assert_array_equal(b_and_x, again)

    @pytest.mark.parametrize("name", PROBLEMS)
    def test_its_bits_do_not_depend_on_the_threads(self, name):
        problem, found = PROBLEMS[name](), set()
        solver, b = problem.solver(parts=part_of(problem)), problem.rhs()
        for n in (1, 2, 3, 2, 1):
            thread_pool.use(n)
            x, y = np.zeros((2, problem.n))
            solver.solve(problem.data, b, x)
            solver.solve_again(b, y)
            found.add((x.tobytes(), y.tobytes(), solver.pivots().tobytes(), solver.cancellation().tobytes()))
        assert len(found) == 1

    @pytest.mark.parametrize("name", PROBLEMS)
    def test_pivots_have_the_determinant_of_the_matrix(self, name):
        problem = PROBLEMS[name]()
        solver = problem.solver(parts=part_of(problem), tolerance=0.0)
        solver.solve(problem.data, problem.rhs(), np.zeros(problem.n))
        sign, logarithm = np.linalg.slogdet(problem.matrix.toarray())
        assert np.prod(np.sign(solver.pivots())) == sign
        assert np.log(np.abs(solver.pivots())).sum() == pytest.approx(logarithm, rel=1e-9)

    def test_null_pivots_of_both_halves_are_counted(self):
        problem = two_chains(20)
        last = [problem.n - 1, problem.n - 6]  # a multiplier of each chain, which constrains nothing
        problem.data[np.isin(problem.rows, last) | np.isin(problem.cols, last)] = 0.0
        b = problem.rhs()
        b[last] = 0.0
        status = problem.solver(parts=part_of(problem)).solve(problem.data, b, np.zeros(problem.n))
        assert status.null_pivots == 2


class TestModels:
    @pytest.mark.parametrize("name", DYNAMIC)
    def test_a_run_has_the_same_bits_with_any_number_of_threads(self, name):
        found = set()
        for n in (1, 2, 3):
            thread_pool.use(n)
            ended = RecordedRun(input_deck(name, DYNAMIC[name]))
            assert ended.system.halves is not None
            found.add((ended.rows.tobytes(), ended.time.tobytes(), ended.run.iterations))
        assert len(found) == 1

    @pytest.mark.parametrize("name", [*DYNAMIC, "mast_in_wind"])  # whose line load has no unknowns
    def test_the_sums_of_a_divided_model_are_those_of_the_whole(self, name, monkeypatch):
        """To rounding: forces, tangents and energies are added in another order."""
        deck = input_deck(name)

        def sums():
            prepared = prepare(deck)
            system, s = prepared.system, prepared.state
            random = np.random.default_rng(0)
            s.v[: system.n_q], s.a[: system.n_q] = random.standard_normal((2, system.n_q))
            assembly, observation = system.assemble(s, 2.0, 3.0, cK=1.0, cC=0.5, cM=0.25), system.observe(s)
            return [
                assembly.residual, assembly.size, assembly.data[: system.nnz], observation.energy, observation.energies,
                observation.outputs, system.event_values(s), system.commit(s),
            ]  # fmt: skip

        parts = sums()
        monkeypatch.setattr(module, "LARGE", 10**6)
        for divided, whole in zip(parts, sums(), strict=True):
            largest = np.abs(whole[np.isfinite(whole)]).max(initial=1.0)
            np.testing.assert_allclose(divided, whole, rtol=1e-10, atol=1e-12 * largest)

    def test_every_element_is_in_one_part(self):
        system = prepare(input_deck("reflector")).system
        system.loops(residual)
        counts = [records["n"].sum() for _, records, _ in system._divided_loops[residual].found]
        assert sum(counts) == sum(len(b.p) for b in system.batches if codes_of(b.kind, residual)) and min(counts) > 0

    def test_statics_has_the_same_bits(self):
        found = set()
        for n in (1, 2):
            thread_pool.use(n)
            found.add(follow(prepare(input_deck("princeton_beam"))).point.state.z.tobytes())
        assert len(found) == 1

    def test_a_run_with_two_threads_is_resumed_with_one_to_the_same_bits(self, tmp_path):
        deck, whole, path = input_deck("nose_gear_rigid", "time.end=0.3"), tmp_path / "whole.h5", tmp_path / "r.h5"
        thread_pool.use(1)
        run(deck, whole)
        for n in (2, 1, 2):
            thread_pool.use(n)
            end = StopAfter(60)
            with pytest.raises(Stopped):
                resume(deck, path, interruption=end, observers=(end,))
        thread_pool.use(1)
        resume(deck, path)
        check_same(contents(path), contents(whole))


PROGRAM = f"""
from mecano.model import halves
halves.LARGE, halves.PRICE, halves.MOST = {SMALL}, 1, 0.999
from mecano.cli import main
main()
"""


def solved():
    """Bits of a solution by the threads of this process."""
    problem = chain(60)
    solver, b, x = problem.solver(parts=part_of(problem)), problem.rhs(), np.zeros(problem.n)
    solver.solve(problem.data, b, x)
    return x.tobytes()


class TestThreads:
    def test_a_fork_does_all_work_itself(self):
        thread_pool.use(2)
        expected = solved()

        def child(threads):
            thread_pool._pool[thread_pool.THREADS] = threads
            b, x = problem.rhs(), np.zeros(problem.n)
            solver.solve(problem.data, b, x)
            assert x.tobytes() == expected

        problem = chain(60)
        solver = problem.solver(parts=part_of(problem))
        for threads in (1, 2):  # 2: of helpers that do not exist
            assert ended(forked(child, threads)) == 0

    def test_two_threads_share_one_core(self):
        thread_pool.use(1)
        expected, cores = solved(), os.sched_getaffinity(0)
        thread_pool.use(2)
        try:
            os.sched_setaffinity(0, {min(cores)})
            for helper in thread_pool._helpers:
                os.sched_setaffinity(helper.native_id, {min(cores)})
            assert solved() == expected
        finally:
            for thread in (0, *(helper.native_id for helper in thread_pool._helpers)):
                os.sched_setaffinity(thread, cores)

    def test_the_helper_takes_parts(self):
        """With the first thread held up in its part, until the helper is done with the other."""
        thread_pool.use(2)
        pool, seen = thread_pool.pool(), []
        meeting = threading.Barrier(2, timeout=60)

        @ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_int64)
        def part(address, _):
            meeting.wait()
            seen.append((address, threading.get_native_id()))

        function = ctypes.cast(part, ctypes.c_void_p).value
        shared = ctypes.CFUNCTYPE(None, ctypes.c_char_p, ctypes.c_void_p)(run_on_pool.address)
        shared(run_on_pool.pack(id(np.ndarray), pool, function, 1000, 8), None)
        assert sorted(address for address, _ in seen) == [1000, 1008]
        assert {thread for _, thread in seen} == {threading.get_native_id(), thread_pool._helpers[0].native_id}

    def test_without_semaphores_one_thread_does_all(self, monkeypatch):
        monkeypatch.setattr(thread_pool, "_initialize_semaphores", lambda: False)
        monkeypatch.setattr(thread_pool, "_pool", np.zeros_like(thread_pool._pool))
        monkeypatch.setattr(thread_pool, "_helpers", [])
        expected = solved()
        thread_pool.use(2)
        assert thread_pool._pool[thread_pool.THREADS] == 1 and solved() == expected

    def test_the_number_of_threads(self, monkeypatch):
        thread_pool.use(None)
        monkeypatch.setattr(thread_pool, "cores", lambda: 64)
        monkeypatch.delenv(thread_pool.VARIABLE, raising=False)
        assert thread_pool.threads() == thread_pool.PARTS
        monkeypatch.setenv(thread_pool.VARIABLE, "1")
        assert thread_pool.threads() == 1
        for wrong in ("0", "two", "-1", "", "²"):
            monkeypatch.setenv(thread_pool.VARIABLE, wrong)
            with pytest.raises(UsageError, match="MECANO_THREADS must be a number of threads"):
                thread_pool.threads()
        monkeypatch.delenv(thread_pool.VARIABLE)

    def test_the_file_says_how_many_and_ctrl_c_ends_them(self, tmp_path):
        deck, path = INPUTS / "nose_gear_rigid.yaml", tmp_path / "r.h5"
        words = ["run", str(deck), "-o", str(path), "--threads", "2", "-q", "--set", "time.end=1000"]
        process = subprocess.Popen([sys.executable, "-c", PROGRAM, *words])
        deadline = time.monotonic() + 120
        while not path.exists() and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.05)
        time.sleep(0.5)
        before = time.monotonic()
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=60) == 130 and time.monotonic() - before < 2.0  # docs/long-runs.md
        with mecano.open_results(path) as results:
            assert results.metadata["solver_threads"] == 2 and results.resumable


@entry
def run_on_pool(pool: int, function: int, first: int, stride: int):
    run_parts(pool, function, first, stride)

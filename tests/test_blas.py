"""Threads of BLAS in programs that call mecano."""

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import mecano
from mecano.process.cores import blas_threads, bounded_blas


def threads_now():
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


@pytest.mark.parametrize(("given", "used"), [("3", 3), ("", 1), ("²", 1)])
def test_blas_has_the_threads_of_the_environment_or_one(monkeypatch, given, used):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", given)
    with bounded_blas():
        pass  # SciPy's BLAS is loaded from now on
    with threadpool_limits(2, user_api="blas"):
        with bounded_blas():
            assert threads_now() == {used} == {blas_threads()}
        assert threads_now() == {2}


def test_a_run_is_computed_with_one_thread_and_gives_the_others_back(tmp_path, monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "")
    seen = []
    monkeypatch.setattr("mecano.interface.solving.run_with_progress", lambda *a, **k: seen.append(threads_now()))
    monkeypatch.setattr("mecano.interface.solving.Results", lambda path: path)
    with bounded_blas():
        pass
    with threadpool_limits(2, user_api="blas"):
        mecano.run("inputs/pendulum.yaml", tmp_path / "r.h5")
        assert seen == [{1}] and threads_now() == {2}


def test_the_block_of_a_simulation_has_one_thread_also_if_it_cannot_begin(tmp_path, monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "")
    with bounded_blas():
        pass
    with threadpool_limits(2, user_api="blas"):
        with mecano.Simulation("inputs/pendulum.yaml", tmp_path / "r.h5") as simulation:
            assert threads_now() == {1}
            simulation.advance(0.01)
        assert threads_now() == {2}
        with pytest.raises(mecano.errors.ResultsError), mecano.Simulation("inputs/pendulum.yaml", tmp_path / "r.h5"):
            pass
        assert threads_now() == {2}


@pytest.mark.parametrize("function", [mecano.run, mecano.check, mecano.modes, mecano.margins, mecano.response])
def test_all_that_computes_is_bounded(function):
    assert function.__wrapped__

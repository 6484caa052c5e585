"""Steps of several sizes from one state share factors, and end where single steps do nevertheless."""

import numpy as np
import pytest
from time_runs import input_deck

from mecano.analyses.prepare import integrator_of, prepare

SIZES = 4e-3, 4.1e-3, 4.1001e-3, 9e-3  # [s]: two similar to the first, one that is not


class FromOneState:
    """Steps of a reflector from its start, and from a later state."""

    def __init__(self, t):
        prepared = prepare(input_deck("reflector"))
        integrator = integrator_of(prepared)
        run = integrator.begin(prepared.state, 0.01)
        self.run = integrator.to(t, run) if t else run
        self.method, self.length = integrator.method, prepared.length
        self.last = self.single(self.run.h)[0]

    def single(self, h):
        """A step of size h alone."""
        s, history = self.run.motion, self.run.history
        return self.method.step(s, history if h == history.h else self.method.restart(s, history, h), h)

    def repeated(self):
        """A function of h for steps that share factors."""
        return self.method.repeated(self.run.motion, self.run.history, self.last)


@pytest.fixture(scope="module", params=[0.0, 2.0], ids=["at the start", "later"])
def steps(request):
    return FromOneState(request.param)


def test_repeated_steps_end_where_single_steps_end(steps):
    """To a tenth of the tolerance of the constraints, and of the velocities and accelerations that it causes."""
    repeated, nearest = steps.repeated(), 0.1 * steps.method.tolerances.constraint * steps.length
    for h in SIZES:
        (found, _, info), (right, _, _) = repeated(h), steps.single(h)
        assert info.ok
        assert np.abs(found.z - right.z)[: steps.method.system.n_q].max() < nearest
        assert np.abs(found.R - right.R).max() < nearest
        assert np.abs(found.v - right.v).max() < nearest / h
        assert np.abs(found.a - right.a).max() < nearest / h**2


def test_the_same_steps_give_the_same_bits(steps):
    ends = [[repeated(h)[0].z.tobytes() for h in SIZES] for repeated in map(FromOneState.repeated, [steps, steps])]
    assert ends[0] == ends[1]


def test_a_step_that_is_lost_in_the_rounding_of_the_time_gives_no_slope(steps):
    repeated, nearest = steps.repeated(), 0.1 * steps.method.tolerances.constraint * steps.length
    for h in (1e-17, SIZES[0]):
        found, right = repeated(h)[0], steps.single(h)[0]
        assert np.abs(found.z - right.z)[: steps.method.system.n_q].max() < nearest


def test_similar_steps_factor_nothing(steps, monkeypatch):
    method, factored, found = steps.method, [], []
    repeated = steps.repeated()
    for solver in (method.linear, *repeated.__self__.solvers):
        monkeypatch.setattr(solver, "solve", lambda *given, solve=solver.solve: factored.append(1) or solve(*given))
    for h in SIZES:
        before = method.workspace.record["factorizations"][0] + len(factored)
        repeated(h)
        found.append(int(method.workspace.record["factorizations"][0] + len(factored) - before))
    assert found[1] == found[2] == 0 < min(found[0], found[3])


def test_a_solve_that_raises_leaves_compiled_code_as_it_was(steps, monkeypatch):
    """An interrupt in Python must not leave a pointer to a function that no longer exists."""
    repeated, record = steps.repeated(), steps.method.workspace.record
    flags = "substitute", "delegated", "similar"
    before = {name: record[name][0] for name in flags}

    def interrupted(*_):
        raise KeyboardInterrupt

    metric, _ = repeated.__self__.solvers
    with monkeypatch.context() as patch:
        patch.setattr(metric, "solve", interrupted)
        with pytest.raises(KeyboardInterrupt):
            repeated(SIZES[0])
    assert {name: record[name][0] for name in flags} == before
    nearest, again, right = 0.1 * steps.method.tolerances.constraint * steps.length, steps.repeated(), steps.single
    assert np.abs(again(SIZES[0])[0].z - right(SIZES[0])[0].z)[: steps.method.system.n_q].max() < nearest

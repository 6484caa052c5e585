"""Processes of cases: forks of one that has loaded what all need behave as separate ones."""

import os
import select
import signal
import time
from contextlib import closing
from pathlib import Path

import h5py
import numpy as np
import pytest

from mecano.study.case_processes import CAN_FORK, ForkedProcesses, SeparateProcesses

pytestmark = pytest.mark.skipif(not CAN_FORK, reason="processes are forked on Linux only")
DECK = str(Path(__file__).parents[1] / "inputs" / "pendulum.yaml")
SHORT = ("--set", "time.end=0.05")


def run(file, *further):
    return ["run", DECK, "-o", str(file), "-q", *further]


def ends(processes, numbers, wait=60.0):
    """Return {number: End} of the processes ``numbers``."""
    found, until = {}, time.monotonic() + wait
    while not set(numbers) <= set(found) and time.monotonic() < until:
        select.select(processes.readable(), [], [], 0.05)
        found |= {end.number: end for end in processes.ended()}
    return found


@pytest.fixture
def forked():
    with closing(ForkedProcesses(DECK, ["time.end=0.05"])) as processes:
        yield processes


def test_a_fork_writes_what_a_separate_process_writes_in_half_of_its_time(forked, tmp_path):
    """It takes about a fifth; the rest is that of imports."""
    times = {}
    with closing(SeparateProcesses()) as separate:
        for name, processes in (("forked", forked), ("separate", separate)):
            number = processes.start(run(tmp_path / f"{name}.h5", *SHORT), tmp_path / "log")
            (end,) = ends(processes, [number]).values()
            assert end.code == 0
            times[name] = end.processor_time
    assert 0.0 < times["forked"] < 0.5 * times["separate"]
    with h5py.File(tmp_path / "forked.h5") as one, h5py.File(tmp_path / "separate.h5") as other:
        for name in ("time", "elements", "energy"):
            same(one[name], other[name])


def same(one, other):
    if isinstance(one, h5py.Dataset):
        np.testing.assert_array_equal(one[()], other[()])
    else:
        assert one.keys() == other.keys()
        for name in one:
            same(one[name], other[name])


def test_a_fork_reports_errors_as_a_separate_process(forked, tmp_path):
    number = forked.start(["run", "absent.yaml"], tmp_path / "log")
    assert ends(forked, [number])[number].code == 2
    assert "absent.yaml" in (tmp_path / "log").read_text()


def test_the_time_of_a_fork_begins_with_it(forked, tmp_path):
    """A limit of wall-clock time that has passed since the server began."""
    begun = time.monotonic()
    first = forked.start(run(tmp_path / "1.h5", *SHORT), tmp_path / "log")
    ends(forked, [first])
    time.sleep(max(0.0, begun + 3.0 - time.monotonic()))
    second = forked.start(run(tmp_path / "2.h5", "--max-walltime", "3", *SHORT), tmp_path / "log")
    assert ends(forked, [second])[second].code == 0, (tmp_path / "log").read_text()


def test_a_fork_that_a_signal_ends_at_once_has_a_log(forked, tmp_path):
    """The study reads there why it ended."""
    for i in range(4):
        log = tmp_path / f"{i}.log"
        number = forked.start(run(tmp_path / f"{i}.h5"), log)
        forked.send(number, signal.SIGINT)
        assert log.exists()
        assert ends(forked, [number])[number].code in (-signal.SIGINT, 130) and "Traceback" not in log.read_text()


def test_signals_reach_a_fork(forked, tmp_path):
    number = forked.start(run(tmp_path / "long.h5", "--set", "time.end=1e4"), tmp_path / "log")
    while not (tmp_path / "long.h5").exists():
        time.sleep(0.01)
    forked.send(number, signal.SIGTERM)
    assert ends(forked, [number])[number].code == 143
    forked.send(number, signal.SIGTERM)  # has ended


def test_without_its_server_a_fork_is_killed_and_the_next_has_another(forked, tmp_path):
    number = forked.start(run(tmp_path / "1.h5", "--set", "time.end=1e4"), tmp_path / "log")
    os.kill(forked._server.process.pid, signal.SIGKILL)
    assert ends(forked, [number])[number].code == -signal.SIGKILL
    number = forked.start(run(tmp_path / "2.h5", *SHORT), tmp_path / "log")
    assert ends(forked, [number])[number].code == 0

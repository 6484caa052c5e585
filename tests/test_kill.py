"""Runs killed at random instants: acknowledged data are readable and equal to the uninterrupted run, bit for bit."""

import random
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import pytest
from time_runs import INPUTS

import mecano
from mecano.errors import ResultsError

KILLS = 30
ATTEMPTS = 3
# `mecano run` that reports, as soon as each flush has returned, the acknowledged data: saved times, steps, events
WITNESS = """
import os
from mecano.results.writer import Writer
flush = Writer.flush
def told(writer):
    count = flush(writer)
    os.write(1, f"{count} {writer._steps.written} {writer._events.written}\\n".encode())
    return count
Writer.flush = told
from mecano.cli import main
main()
"""
COMMAND = [sys.executable, "-c", WITNESS, "run", str(INPUTS / "double_pendulum.yaml"), "--quiet"]
SETTINGS = ["--set", "time.end=1.4", "--set", "time.step=5.0e-5", "--set", "output.every=1.0e-4"]


@dataclass
class Held:
    """Return the content of a results file."""

    times: np.ndarray
    series: dict
    steps: np.ndarray
    events: list
    status: str

    @classmethod
    def of(cls, path):
        with mecano.open_results(path) as results:
            series = {name: results[name].values for name in results.names()}
            return cls(results.time, series, results.steps, results.events, results.status)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return the uninterrupted run, and the duration of its time integration [s]."""
    path = tmp_path_factory.mktemp("whole") / "whole.h5"
    compiling = [*COMMAND, *SETTINGS, "-o", str(path)]  # if need be
    subprocess.run(compiling, check=True, stdout=subprocess.DEVNULL)
    again = path.with_name("again.h5")
    process = subprocess.Popen([*COMMAND, *SETTINGS, "-o", str(again)], stdout=subprocess.DEVNULL)
    begun = appearance(again)
    process.wait()
    return Held.of(path), time.monotonic() - begun


def appearance(path):
    """Wait until the file appears, when the time integration begins, and return that time."""
    while not path.exists():
        time.sleep(0.002)
    return time.monotonic()


def killed(path, after):
    """Run, kill -9 ``after`` seconds of integration, and return the rows acknowledged by the process."""
    process = subprocess.Popen([*COMMAND, *SETTINGS, "-o", str(path)], stdout=subprocess.PIPE)
    appearance(path)
    time.sleep(after)
    process.kill()
    said, _ = process.communicate()
    counts = [line.split() for line in said.decode().split("\n")[:-1]]  # the last one may be half written
    return tuple(map(int, counts[-1])) if counts else (0, 0, 0)


def check_killed(path, said, run):
    """Compare what a killed process has left with the whole run; return whether it died within the run."""
    try:
        left = Held.of(path)
    except ResultsError as error:
        raise AssertionError(f"{path.name} cannot be read") from error
    count = len(left.times)
    found = (count, len(left.steps), len(left.events))
    assert all(there >= promised for there, promised in zip(found, said, strict=True)), (path.name, found, said)
    assert left.status == "killed" or found == (14001, 28000, 0)
    assert np.array_equal(left.times, run.times[:count])
    assert np.array_equal(left.steps, run.steps[: len(left.steps)])
    assert left.events == run.events[: len(left.events)]
    for name, array in left.series.items():
        assert np.array_equal(array, run.series[name][:count]), name
    return 0 < said[0] <= count < len(run.times)


@pytest.mark.slow  # of fewer kills, test_results_crash.py
def test_acknowledged_steps_survive_a_kill(whole, tmp_path):
    """A third of the processes dies after the first flush and before the end; on a loaded machine more are tried."""
    run, duration = whole
    assert run.status == "complete" and (len(run.times), len(run.steps)) == (14001, 28000)
    rng, within = random.Random(0), 0
    for attempt in range(ATTEMPTS):
        plans = [(tmp_path / f"{attempt}_{i}.h5", rng.uniform(0.0, 1.0) * duration) for i in range(KILLS)]
        with ThreadPoolExecutor(2) as pool:
            acknowledged = list(pool.map(lambda plan: killed(*plan), plans))
        within += sum(check_killed(path, said, run) for (path, _), said in zip(plans, acknowledged, strict=True))
        if within >= KILLS // 3:
            break
    assert within >= KILLS // 3

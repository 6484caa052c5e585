"""Runs killed at random instants: what was acknowledged is readable and equal to the uninterrupted run, bit for bit."""

import random
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from marching import INPUTS

import mecano
from mecano.errors import ResultsError

KILLS = 30
COMMAND = [sys.executable, "-m", "mecano", "run", str(INPUTS / "double_pendulum.yaml"), "--quiet"]
SETTINGS = ["--set", "time.end=1.4", "--set", "time.step=5.0e-5", "--set", "output.every=1.0e-4"]


def rows(path):
    """Saved times and all series of a results file."""
    with mecano.open_results(path) as results:
        return results.time, {name: results[name].values for name in results.names()}, results.status


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "whole.h5"
    subprocess.run([*COMMAND, *SETTINGS, "-o", str(path)], check=True)  # compiles, if need be
    process = subprocess.Popen([*COMMAND, *SETTINGS, "--force", "-o", str(path.with_name("again.h5"))])
    begun = appearance(path.with_name("again.h5"))
    process.wait()
    return rows(path), time.monotonic() - begun


def appearance(path):
    """When the file got its name: the march begins."""
    while not path.exists():
        time.sleep(0.002)
    return time.monotonic()


def killed(path, after):
    """Run and kill -9 so many seconds after the march began."""
    process = subprocess.Popen([*COMMAND, *SETTINGS, "-o", str(path)])
    appearance(path)
    time.sleep(after)
    process.kill()
    process.wait()


def test_acknowledged_steps_survive_a_kill(whole, tmp_path):
    (times, series, status), duration = whole
    assert status == "complete" and len(times) == 14001
    rng = random.Random(0)
    plans = [(tmp_path / f"{i}.h5", rng.uniform(0.0, 1.0) * duration) for i in range(KILLS)]
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda plan: killed(*plan), plans))
    counts = []
    for path, _ in plans:
        try:
            t, values, _ = rows(path)
        except ResultsError as error:
            raise AssertionError(f"{path.name} cannot be read") from error
        assert np.array_equal(t, times[: len(t)])
        for name, array in values.items():
            assert np.array_equal(array, series[name][: len(t)]), name
        counts.append(len(t))
    # not all died before the first flush or after the end
    assert sum(0 < count < len(times) for count in counts) >= KILLS // 5

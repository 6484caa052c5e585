"""The lock of a results file: no file being written is replaced, and stale records do not block."""

import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import pytest
from process import mecano_process
from surviving import SWING, decks, ended, forked

import mecano
from mecano.analyses.dynamic import resume, run
from mecano.errors import ResultsError
from mecano.results import lock
from mecano.results.lock import lock_of, locked


@pytest.fixture
def path(tmp_path):
    return tmp_path / "r.h5"


@pytest.fixture
def running(tmp_path):
    """A living run that writes r.h5 beside deck.yaml."""
    (tmp_path / "deck.yaml").write_text(SWING)
    words = [sys.executable, "-m", "mecano", "run", "deck.yaml", "-o", "r.h5", "-q"]
    process = subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.DEVNULL)
    while not (tmp_path / "r.h5").exists():
        assert process.poll() is None
        time.sleep(0.01)
    yield process
    process.kill()
    process.wait()


@pytest.mark.parametrize("command", [("run", "--force"), ("run", "--resume"), ("modes", "--force")])
def test_a_file_that_a_living_run_writes_is_not_replaced(running, tmp_path, command):
    before = os.stat(tmp_path / "r.h5").st_ino
    code, _, said = mecano_process(command[0], "deck.yaml", "-o", "r.h5", command[1], cwd=tmp_path)
    assert code == 5 and f"r.h5 is being written by process {running.pid} on" in said and said.count("\n") == 1
    assert os.stat(tmp_path / "r.h5").st_ino == before and running.poll() is None
    running.send_signal(signal.SIGTERM)
    assert running.wait() == 143
    assert sorted(os.listdir(tmp_path)) == ["deck.yaml", "r.h5"]
    assert mecano.open_results(tmp_path / "r.h5").status == "stopped"


def test_a_run_that_was_killed_is_not_in_the_way(running, tmp_path):
    running.kill()
    running.wait()
    assert lock_of(tmp_path / "r.h5").exists()
    code, _, said = mecano_process(
        "run", "deck.yaml", "-o", "r.h5", "--force", "--set", "time.end=0.01", cwd=tmp_path
    )  # fmt: skip
    assert code == 0, said
    assert sorted(os.listdir(tmp_path)) == ["deck.yaml", "r.h5"]


def hold(path, seconds):
    with locked(path):
        time.sleep(seconds)


def hold_and_tell(path, reported):
    with locked(path):
        begun = time.monotonic()
        time.sleep(0.02)
        reported.write_text(f"{begun} {time.monotonic()}")


@pytest.mark.parametrize("times", [12, pytest.param(40, marks=pytest.mark.slow)])
def test_of_those_that_start_at_once_no_two_write_at_the_same_time(times, path, tmp_path):
    """Each time there is a stale record of a process that is gone, which all of them find."""
    gone = subprocess.Popen(["true"])
    gone.wait()
    for _ in range(times):
        record(path, process=gone.pid)
        children = [forked(hold_and_tell, path, tmp_path / f"{i}.txt") for i in range(4)]
        codes = list(map(ended, children))
        held = sorted(tuple(map(float, reported.read_text().split())) for reported in tmp_path.glob("*.txt"))
        assert len(held) == codes.count(0) >= 1 and set(codes) <= {0, 5}
        assert all(before[1] <= after[0] for before, after in pairwise(held))
        for reported in tmp_path.glob("*.txt"):
            reported.unlink()
        assert os.listdir(tmp_path) == []


def record(path, **changed):
    """Put a record of this process there, with some changes."""
    lock_of(path).write_text(json.dumps(lock._own_record() | changed))


@pytest.mark.parametrize(
    "changed, message",
    [
        ({}, r"is being written by process \d+ on .*: wait for it, end it"),
        (
            {"host": "node7", "process": 4711},
            r"process 4711 on node7 .*be determined on .*remove .*\.r\.h5\.lock and",
        ),
        ({"machine": "another of the same name"}, "which cannot be determined on"),
        ({"space": "pid:[1]"}, "which cannot be determined on"),
        ({"process": None}, "does not name it"),
    ],
)
def test_records_that_are_respected(path, changed, message):
    record(path, **changed)
    with pytest.raises(ResultsError, match=message), locked(path):
        pass
    assert lock_of(path).exists()


@pytest.mark.parametrize("changed", [{"boot": "the one before"}, {"ticks": 1}, {"process": 2**22 + 5}])
def test_records_that_are_stale(path, changed):
    """Of a system that was started anew since, and of a process whose number another one has by now."""
    record(path, **changed)
    with locked(path):
        assert json.loads(lock_of(path).read_text())["process"] == os.getpid()
    assert os.listdir(path.parent) == []


def test_a_record_that_is_cut_is_respected(path):
    lock_of(path).write_text('{"process": 47')
    with (
        pytest.raises(ResultsError, match=r"does not name it; if no process .* remove .*\.r\.h5\.lock"),
        locked(path),
    ):
        pass


def test_a_requeued_job_continues_on_another_node(path, monkeypatch):
    """Its node has failed: Slurm has started it anew on another one, under the same number."""
    record(path, host="node7", job=["815", "0"])
    with pytest.raises(ResultsError, match="on node7"), locked(path):
        pass
    monkeypatch.setenv("SLURM_JOB_ID", "815")
    monkeypatch.setenv("SLURM_RESTART_COUNT", "1")
    with locked(path):
        pass


def test_a_record_that_was_removed_by_hand_is_not_missed(path):
    with locked(path):
        lock_of(path).unlink()
        record(path, host="node7")
    assert json.loads(lock_of(path).read_text())["host"] == "node7"


def test_a_file_system_without_links(path, monkeypatch):
    def link(*_):
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(os, "link", link)
    with locked(path):
        with pytest.raises(ResultsError, match="being written"), locked(path):
            pass
    assert os.listdir(path.parent) == []


def test_an_answer_that_was_lost_counts(path, monkeypatch):
    """NFS may make the link and say that it has not."""
    link = os.link

    def lossy(*arguments):
        link(*arguments)
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(os, "link", lossy)
    with locked(path):
        assert lock_of(path).exists()
    assert os.listdir(path.parent) == []


def test_runs_of_one_process_exclude_each_other_too(path):
    deck, refused = decks()["bouncing_ball"], []

    def again(accepted):
        if accepted.run.steps == 20:
            for action in (resume, run):
                with pytest.raises(ResultsError) as error:
                    action(deck, path, **({"force": True} if action is run else {}))
                refused.append(str(error.value))

    run(deck, path, observers=(again,))
    assert len(refused) == 2 and all("is being written by process" in text for text in refused)
    assert mecano.open_results(path).status == "complete"


def test_many_names_at_once(tmp_path):
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(lambda i: hold(tmp_path / f"{i}.h5", 0.01), range(32)))
    assert os.listdir(tmp_path) == []

"""Functions compiled by several processes before the first is needed."""

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import pytest
from time_runs import input_deck

from mecano.analyses import compilation
from mecano.analyses import warmup as warming
from mecano.analyses.prepare import prepare
from mecano.jit import ahead, image, machine_code, store
from mecano.jit.machine_code import Code

PATIENCE = 20.0  # s


@pytest.fixture
def empty_store(tmp_path, monkeypatch):
    monkeypatch.setattr(store, "folder", lambda: tmp_path)
    monkeypatch.setattr(machine_code, "_listeners", [])
    monkeypatch.setattr(image, "POSSIBLE", False)  # nothing is linked: the functions have no machine code
    return tmp_path


def made(name, tmp_path, seconds=0.0):
    """A function whose compilation takes some seconds and leaves a line in a file."""

    def generate(_):
        with open(tmp_path / "made.txt", "a") as file:
            file.write(f"{name} {os.getpid()}\n")
        time.sleep(seconds)
        if name == "bad":
            raise SystemError("bad")
        return name, b"machine code"

    return Code(name, "0", generate)


def test_processes_share_the_work(empty_store, monkeypatch):
    """Each function is compiled once, none by this process; what is there, or given twice, is not compiled again."""
    monkeypatch.setattr(ahead, "cores", lambda: 2)
    codes = [made(name, empty_store, 0.2) for name in ("a", "b", "c", "d", "e")]
    store.write(codes[0].file, b"e\nmachine code")
    reported = []
    with machine_code.while_compiling(lambda *counts: reported.append(counts)):
        ahead.compile_ahead([*codes, codes[1]])
    with machine_code.compiling(1):
        pass  # no longer reported
    names, processes = zip(*(line.split() for line in (empty_store / "made.txt").read_text().splitlines()), strict=True)
    assert sorted(names) == ["b", "c", "d", "e"]
    assert len(set(processes)) == 2 and str(os.getpid()) not in processes
    assert reported == [(i, 4) for i in range(5)]
    assert all(store.read(code.file) == b"%s\nmachine code" % code.name.encode() for code in codes[1:])


def test_code_that_fails_to_compile_ahead_is_compiled_at_its_first_use(empty_store, monkeypatch):
    monkeypatch.setattr(ahead, "cores", lambda: 2)
    bad, good = made("bad", empty_store), [made(name, empty_store) for name in ("a", "b")]
    ahead.compile_ahead([bad, *good])
    assert [store.contains(code.file) for code in (bad, *good)] == [False, True, True]
    with pytest.raises(SystemError, match="bad"):
        machine_code.address(bad)


def test_fewer_processes_than_wanted_do_the_work(empty_store, monkeypatch):
    """The system refuses the second process; all pipes are closed, and no process is left."""
    monkeypatch.setattr(ahead, "cores", lambda: 2)
    fork, forked = os.fork, []

    def once():
        if forked:
            raise BlockingIOError("Resource temporarily unavailable")
        forked.append(True)
        return fork()

    monkeypatch.setattr(os, "fork", once)
    codes, opened = [made(name, empty_store) for name in ("a", "b", "c")], os.listdir("/proc/self/fd")
    ahead.compile_ahead(codes)
    assert all(store.contains(code.file) for code in codes)
    assert os.listdir("/proc/self/fd") == opened
    with pytest.raises(ChildProcessError):
        os.waitpid(-1, os.WNOHANG)


def test_a_file_is_compiled_by_one_process_at_a_time(empty_store):
    code = made("once", empty_store, 0.3)
    child = os.fork()
    if not child:
        machine_code.compile_code(code)
        os._exit(0)
    machine_code.compile_code(code)
    os.waitpid(child, 0)
    assert (empty_store / "made.txt").read_text().count("once") == 1
    assert not list(empty_store.glob("*.lock"))


def test_threads_compile_one_after_the_other(empty_store):
    """Tables of numba belong to one at a time, and a process forked meanwhile would wait for locks of the others."""
    working, most = [], []

    def generate(_):
        working.append(1)
        most.append(len(working))
        time.sleep(0.05)
        working.pop()
        return "name", b"machine code"

    codes = [Code(f"code_{i}", "0", generate) for i in range(3)]
    threads = [threading.Thread(target=machine_code.compile_code, args=(code,)) for code in codes]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == [1, 1, 1]


def test_processes_end_with_the_one_that_started_them(tmp_path):
    script = """
        import os, pathlib, sys, time
        from mecano.jit import ahead
        from mecano.jit.machine_code import Code

        def generate(compiler):
            pathlib.Path(sys.argv[1], str(os.getpid())).touch()
            time.sleep(1000.0)

        ahead.cores = lambda: 2
        ahead.compile_ahead([Code(name, "0", generate) for name in "abc"])
    """
    environment = {**os.environ, store.FOLDER: str(tmp_path / "store")}
    (tmp_path / "running").mkdir()
    command = [sys.executable, "-c", textwrap.dedent(script), str(tmp_path / "running")]
    with subprocess.Popen(command, env=environment) as process:
        deadline = time.monotonic() + PATIENCE
        while len(os.listdir(tmp_path / "running")) < 2 and time.monotonic() < deadline:
            time.sleep(0.05)
        process.send_signal(signal.SIGKILL)
    children = [int(name) for name in os.listdir(tmp_path / "running")]
    assert len(children) == 2
    while any(map(lives, children)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(map(lives, children))


def lives(process):
    """True while a process runs: one that ended, and that nobody waits for, is a zombie in a container."""
    try:
        with open(f"/proc/{process}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_a_warm_store_has_what_runs_compile_ahead(monkeypatch):
    """Massless unknowns with adaptive steps, many unknowns with events, Radau, fixed steps."""
    warm, needed = [], []
    monkeypatch.setattr(warming, "_compile", warm.extend)
    monkeypatch.setattr(warming, "_compile_and_step", lambda deck: None)
    list(warming.warmup())
    monkeypatch.setattr(compilation, "compile_ahead", needed.extend)
    for name in ("nose_landing_gear", "reflector", "andrews", "pendulum"):
        prepared = prepare(input_deck(name))
        for method in ("generalized_alpha", "radau"):
            compilation.compile_time_integration(prepared.system, prepared.deck.values["time"] | {"method": method})
    assert {code.file for code in needed} <= {code.file for code in warm}

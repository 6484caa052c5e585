"""Signals at random instants, limits of CPU time, closed terminals, killed parents: which processes end, and how."""

import os
import pty
import random
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from process import COMMAND, mecano_process
from surviving import SWING, check_same, contents, decks, ended, forked, listening_resume

import mecano
from mecano.analyses.dynamic import run
from mecano.errors import ResultsError
from mecano.process.interrupt import CLOCK, EXIT_CODES
from mecano.results.verify import verify
from mecano.study.folder import Folder
from mecano.study.pool import Limits, Pool
from mecano.study.read import read_study

ALL = tuple(number for number in EXIT_CODES if number != CLOCK)
SLOW = pytest.mark.slow
FEW = "nose_gear_rigid", "four_feet"
ANSWER = 2.0  # s of processor time after a signal, which other processes do not change
STUDY = "study: 1\ndeck: deck.yaml\nset: {output.every: 1}\nlist: [{time.end: 1.0e5}, {time.end: 2.0e5}]\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A new working folder with the deck of a run of hours, and a study of it."""
    (tmp_path / "deck.yaml").write_text(SWING)
    (tmp_path / "study.yaml").write_text(STUDY)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_ctrl_c_while_modules_are_imported():
    """The operating system ends the process: nothing is printed."""
    code = (
        "import os, runpy, signal, sys\n"
        "class Finder:\n"
        "    def find_spec(name, path, target=None):\n"
        "        if name == 'click': os.kill(os.getpid(), signal.SIGINT)\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "sys.meta_path.insert(0, Finder)\n"
        "runpy.run_module('mecano', run_name='__main__', alter_sys=True)\n"
    )
    ended = subprocess.run([sys.executable, "-c", code, "list"], capture_output=True)
    assert (ended.returncode, ended.stdout, ended.stderr) == (-signal.SIGINT, b"", b"")


@pytest.fixture
def started():
    """Starts processes of the command line, of which nothing is heard but errors; none is left in the end.

    Each calls ``first`` before it begins.
    """
    processes = []

    def start(*words, first=lambda: None, **options):
        def begin():
            for ignored in (signal.SIGINT, signal.SIGHUP):  # by shells in the background, by nohup
                signal.signal(ignored, signal.SIG_DFL)
            first()

        process = subprocess.Popen(
            [*COMMAND, *words], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, preexec_fn=begin, **options
        )
        processes.append(process)
        return process

    yield start
    for process in processes:
        process.kill()
        process.communicate()


def processor_time(number):
    """Processor time [s] of a process that runs."""
    fields = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def answered(number, wanted):
    """Send a signal to a child: its exit code; it must end within ANSWER."""
    before = processor_time(number)
    os.kill(number, wanted)
    return ended_soon(number, before)


def ended_soon(number, before):
    """Wait for a child that had used some processor time ``before``: its exit code; it must end within ANSWER."""
    _, status, used = os.wait4(number, 0)
    assert used.ru_utime + used.ru_stime - before < ANSWER
    return os.waitstatus_to_exitcode(status)


def reported(process, wanted):
    """Send a signal to a process; return its exit code and messages."""
    process.returncode = answered(process.pid, wanted)
    return process.returncode, process.stderr.read().decode()


def wait_until(true, seconds=120.0):
    """Wait until something is true; AssertionError when that takes too long."""
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.mark.parametrize("name", [name if name in FEW else pytest.param(name, marks=SLOW) for name in decks()])
def test_at_any_instant_of_a_run(name, tmp_path):
    """From before the process listens to after the end, with checkpoints every 5 ms; then on to the same bits."""
    deck, path, rng = decks()[name], tmp_path / "r.h5", random.Random(name)
    run(deck, tmp_path / "whole.h5")
    begun = time.monotonic()
    assert ended(forked(listening_resume, deck, path, 0.005)) == 0
    duration, codes = time.monotonic() - begun, set()
    path.unlink()
    for wanted in rng.sample(ALL, len(ALL)):
        child = forked(listening_resume, deck, path, 0.005)
        time.sleep(rng.uniform(0.0, 0.5) * duration)
        codes.add(code := answered(child, wanted))
        assert code in (0, -wanted, EXIT_CODES[wanted])  # too late, too early, or as documented
        duration *= 1.0 if code else 0.7  # the first run may have had more to load
        if path.exists():
            verify(path)
    assert codes & set(EXIT_CODES.values())
    assert ended(forked(listening_resume, deck, path, 0.005)) == 0
    check_same(contents(path), contents(tmp_path / "whole.h5"))


@pytest.mark.parametrize(
    "wanted",
    [signal.SIGTERM, *(pytest.param(one, marks=SLOW) for one in ALL if one not in (signal.SIGINT, signal.SIGTERM))],
)
def test_signals_during_the_start_of_the_process(folder, started, wanted):
    """Until it listens the system ends it, with the same code but for SIGUSR1: 138 in a shell.

    Python itself hears SIGINT from its own beginning on, and may call it a fatal error there.
    """
    rng = random.Random(int(wanted))
    for _ in range(3):
        process = started("run", "deck.yaml", "--resume", "-q")
        time.sleep(rng.uniform(0.0, 1.0))
        code, said = reported(process, wanted)
        assert code in (-wanted, EXIT_CODES[wanted]), said
        assert "Traceback" not in said
        if (folder / "deck.h5").exists():
            verify(folder / "deck.h5")


def test_signals_during_compilation(folder, started):
    """A compiler answers no signal for seconds."""
    process = started("run", "deck.yaml", env={**os.environ, "MECANO_CACHE_DIR": str(folder / "cache")})
    assert b"compiling" in process.stderr.readline()
    wait_until(lambda: list((folder / "cache").rglob("*.o")))
    code, said = reported(process, signal.SIGUSR1)
    assert code == 75 and "stopped by SIGUSR1" in said


def rows(path):
    """Return the number of saved times of a results file that is being written."""
    with mecano.open_results(path) as results:
        return len(results.time)


def test_a_limit_of_processor_time(folder, started):
    """That of batch systems: SIGXCPU every second from the soft limit on, SIGKILL at the hard one."""
    limit = lambda: resource.setrlimit(resource.RLIMIT_CPU, (2, 30))  # noqa: E731
    process = started("run", "deck.yaml", "--resume", "-q", first=limit)
    said = process.communicate(timeout=120)[1].decode()
    assert process.returncode == 152 and "stopped by SIGXCPU at t = " in said and "--resume" in said
    with mecano.open_results("deck.h5") as results:
        assert results.status == "stopped" and results.checkpoint is not None
        reached = results["hinge.angle"].values
    process = started("run", "deck.yaml", "--resume", "-q")
    inode = os.stat("deck.h5").st_ino
    wait_until(lambda: os.stat("deck.h5").st_ino != inode)
    wait_until(lambda: rows("deck.h5") > len(reached))
    assert reported(process, signal.SIGTERM)[0] == 143
    with mecano.open_results("deck.h5") as results:
        angle = results["hinge.angle"].values
    assert len(angle) > len(reached) > 1 and angle[: len(reached)].tobytes() == reached.tobytes()


def test_a_terminal_that_is_closed(folder):
    """The run receives SIGHUP, and its terminal is gone."""
    child, terminal = pty.fork()
    if child == 0:
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
        os.execv(COMMAND[0], [*COMMAND, "run", "deck.yaml"])
    text = b""
    while b"of 100000 s" not in text:  # the bar
        text += os.read(terminal, 4096)
    before = processor_time(child)
    os.close(terminal)
    assert ended_soon(child, before) == 129
    with mecano.open_results("deck.h5") as results:
        assert results.status == "stopped" and "SIGHUP" in results.reason and results.checkpoint is not None


def test_nohup(folder, started):
    process = started("run", "deck.yaml", "-q", first=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    wait_until((folder / "deck.h5").exists)
    os.kill(process.pid, signal.SIGHUP)
    time.sleep(0.5)
    assert process.poll() is None and reported(process, signal.SIGTERM)[0] == 143


def children(number):
    """Ids of the children of a process, and of theirs."""
    found = []
    for task in Path(f"/proc/{number}/task").iterdir():
        own = (task / "children").read_text().split()
        found += [int(child) for child in own] + [one for child in own for one in children(int(child))]
    return found


def alive(number):
    """Return whether a process runs; zombies do not, which the init of a container may leave."""
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.parametrize(
    ("executor", "further", "processes"),
    [("local", "", 2), ("local", ", {time.end: 3.0e5}, {time.end: 4.0e5}", 3), ("dask", "", 4)],
)
def test_a_killed_study_leaves_no_orphans(folder, started, executor, further, processes):
    """Its cases end as by SIGTERM, with checkpoints from which the study resumes; of four, a server forks them."""
    (folder / "study.yaml").write_text(STUDY.replace("]\n", f"{further}]\n"))
    if executor == "dask":
        pytest.importorskip("distributed")
    words = ["sweep", "study.yaml", "--jobs", "2", "--executor", executor]
    process = started(*words)
    files = [folder / "study_runs" / name for name in ("0001.h5", "0002.h5")]
    wait_until(lambda: all(file.exists() for file in files))
    cases = children(process.pid)
    assert len(cases) == processes
    process.kill()
    process.wait()
    wait_until(lambda: not any(map(alive, cases)), 30.0)
    for file in files:
        with mecano.open_results(file) as results:
            assert results.status == "stopped" and "SIGTERM" in results.reason and results.checkpoint is not None
    code, out, _ = mecano_process("sweep", "study.yaml", "--resume", "--time-limit", "2")
    assert code == 3 and f"{(n := 4 if further else 2)} cases: {n} stopped" in out


def test_a_study_that_is_killed_while_it_compiles_leaves_no_orphans(folder, started):
    process = started("sweep", "study.yaml", env={**os.environ, "MECANO_CACHE_DIR": str(folder / "cache")})
    wait_until(lambda: list((folder / "cache").rglob("*.o")))
    (compiling,) = children(process.pid)
    assert "warmup" in Path(f"/proc/{compiling}/cmdline").read_text()
    process.kill()
    process.wait()
    wait_until(lambda: not alive(compiling), 30.0)


@pytest.mark.parametrize(("wanted", "code"), [(signal.SIGINT, 130), pytest.param(signal.SIGTERM, 143, marks=SLOW)])
def test_a_study_that_is_stopped_while_it_compiles_ends_after_what_it_has_begun(folder, started, wanted, code):
    process = started("sweep", "study.yaml", env={**os.environ, "MECANO_CACHE_DIR": str(folder / "cache")})
    wait_until(lambda: list((folder / "cache").rglob("*.o")))
    (compiling,) = children(process.pid)
    process.send_signal(wanted)
    assert process.wait(30.0) == code
    assert not alive(compiling)


def test_an_error_in_a_study_leaves_no_orphans(folder, monkeypatch):
    """A failed write ends the parent, after its cases have written checkpoints."""
    monkeypatch.chdir(folder)
    study = read_study("study.yaml")
    pool = Pool(Folder(folder / "study_runs", study), 2, Limits())
    (folder / "study_runs").mkdir()
    numbers = []

    def watch():
        if all(pool.folder.file(one.case, ".h5").exists() for one in pool.running):
            numbers.extend(one.number for one in pool.running)
            raise ResultsError("no room")

    monkeypatch.setattr(pool, "_watch", watch)
    with pytest.raises(ResultsError):
        pool.run(study.cases)
    assert len(numbers) == 2 and not any(map(alive, numbers))
    for case in study.cases[:2]:
        with mecano.open_results(pool.folder.file(case, ".h5")) as results:
            assert results.status == "stopped"


@pytest.mark.parametrize(("wanted", "code"), [(signal.SIGHUP, 129), pytest.param(signal.SIGXCPU, 152, marks=SLOW)])
def test_of_a_study(folder, started, wanted, code):
    process = started("sweep", "study.yaml", "--jobs", "2")
    files = [folder / "study_runs" / name for name in ("0001.h5", "0002.h5")]
    wait_until(lambda: all(file.exists() for file in files))
    process.send_signal(wanted)
    assert process.wait(60.0) == code
    assert "2 stopped" in mecano_process("sweep", "study.yaml", "--collect")[1]

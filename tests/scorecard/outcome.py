"""Commands of mecano, called in this process, in a fork of it, or as by a user; and how they must never end."""

import contextlib
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from dataclasses import dataclass
from pathlib import Path

from scorecard.trial import end_with_parent

INPUTS = Path(__file__).parents[2] / "inputs"
COMMAND = (sys.executable, "-m", "mecano")
DOCUMENTED = {0, 2, 3, 4, 5, 6, 7, 75, 129, 130, 143, 152}  # exit codes
WARNING = re.compile(r"^.*\b\w*Warning: .*$", re.MULTILINE)  # as Python prints them
PLACE = re.compile(r"^[^\n]+?:\d+:\d+: \S")  # file:line:column: what
CPU = 5.0  # s of processor time that a command on a small deck may take


@dataclass(frozen=True)
class Outcome:
    """How a command ended; ``code`` negative: by a signal."""

    code: int
    out: str = ""
    err: str = ""
    cpu: float = 0.0  # s
    memory: float = 0.0  # MB
    seconds: float = 0.0


def in_process(arguments, cwd=None):
    """Call the command line in this process."""
    before = os.getcwd()
    handlers = {number: signal.getsignal(number) for number in CAUGHT}
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        begun = time.process_time(), time.monotonic()
        with _onto(1, out), _onto(2, err):
            os.chdir(cwd or before)
            code = _called(arguments)
            os.chdir(before)
        spent, seconds = time.process_time() - begun[0], time.monotonic() - begun[1]
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        for number, handler in handlers.items():
            signal.signal(number, handler)
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        return Outcome(code, _text(out), _text(err), spent, memory, seconds)


CAUGHT = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1, signal.SIGHUP, signal.SIGXCPU, signal.SIGALRM)


def _called(arguments):
    """The exit code of the command line; whatever else it raises is printed, as by Python."""
    from mecano.cli import main

    sys.argv = ["mecano", *map(str, arguments)]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("always")
            for ignored in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
                warnings.simplefilter("ignore", ignored)
            main()
    except SystemExit as ended:
        return ended.code or 0
    except BaseException:
        traceback.print_exc()
        return 1
    return 0


@contextlib.contextmanager
def _onto(number, file):
    """Let a file descriptor of this process go to a file."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = os.dup(number)
    os.dup2(file.fileno(), number)
    try:
        yield
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os.dup2(kept, number)
        os.close(kept)


def _text(file):
    file.seek(0)
    return file.read().decode("utf-8", "replace")


def warm(folder):
    """Import what runs need, and load their code, before processes are forked that then have it."""
    path = os.path.join(folder, "warm.h5")
    for deck in ("nose_gear_rigid.yaml", "deployment_lock.yaml", "bouncing_ball.yaml", "four_bar.yaml"):
        outcome = in_process(["run", INPUTS / deck, "-o", path, "--force", "--quiet", "--set", "time.end=0.02"])
        assert outcome.code == 0, outcome.err
        for words in (["info", path], ["verify", path], ["check", INPUTS / deck]):
            in_process(words)


@dataclass
class Forked:
    """A command that runs in a fork of this process, which has imported all modules."""

    pid: int
    out: object
    err: object
    begun: float

    def kill(self, number):
        """Send a signal; one that comes too late is no error."""
        with contextlib.suppress(ProcessLookupError):
            os.kill(self.pid, number)

    def ended(self):
        """Wait for its Outcome."""
        _, status, usage = os.wait4(self.pid, 0)
        with self.out, self.err:
            return Outcome(
                os.waitstatus_to_exitcode(status), _text(self.out), _text(self.err),
                usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, time.monotonic() - self.begun,
            )  # fmt: skip


def forked(arguments, cwd=None, before=lambda: None):
    """Start a command in a fork of this process; ``before()`` is called in it first."""
    out, err, begun = tempfile.TemporaryFile(), tempfile.TemporaryFile(), time.monotonic()
    child = os.fork()
    if child:
        return Forked(child, out, err, begun)
    code = 1
    try:
        end_with_parent()
        for number in CAUGHT:
            signal.signal(number, signal.SIG_DFL)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        os.dup2(out.fileno(), 1)
        os.dup2(err.fileno(), 2)
        os.chdir(cwd or ".")
        import mecano.process.interrupt

        mecano.process.interrupt.BEGUN = time.monotonic()
        before()
        code = _called(arguments)
        sys.stdout.flush()
        sys.stderr.flush()
    finally:
        os._exit(code)


def in_command(arguments, cwd=None, limits=(), timeout=120.0, environment=None):
    """Call mecano as a user does, with ``limits`` (resource, value) on its process."""

    def limited():
        for what, value in limits:
            resource.setrlimit(what, (value, value))

    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        begun = time.monotonic()
        process = subprocess.Popen(
            [*COMMAND, *map(str, arguments)], cwd=cwd, stdin=subprocess.DEVNULL, stdout=out, stderr=err,
            preexec_fn=limited, env={**os.environ, **(environment or {})},
        )  # fmt: skip
        code, usage = _waited(process, begun + timeout)
        return Outcome(
            code, _text(out), _text(err), usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024,
            time.monotonic() - begun,
        )  # fmt: skip


def _waited(process, deadline):
    """(exit code, resources) of a process, which is killed at the deadline (monotonic, s)."""
    while True:
        pid, status, usage = os.wait4(process.pid, os.WNOHANG)
        if pid:
            process.returncode = os.waitstatus_to_exitcode(status)
            return process.returncode, usage
        if time.monotonic() > deadline:
            process.kill()
            deadline = float("inf")
        time.sleep(0.005)


def unfit(outcome, codes=DOCUMENTED, cpu=CPU):
    """Why a command did not end as it may: a signal, a bug, a traceback, a warning of Python, a hang; or empty."""
    if outcome.code < 0:
        return f"ended by {signal.Signals(-outcome.code).name}"
    if "Traceback (most recent call last)" in outcome.err:
        return f"a traceback: {last_line(outcome.err)}"
    if outcome.code not in codes:
        return f"exit code {outcome.code}: {last_line(outcome.err)}"
    if warned := WARNING.search(outcome.err):
        return f"a warning of Python: {warned[0]}"
    if outcome.cpu > cpu:
        return f"{outcome.cpu:.1f} s of processor time"
    return ""


def unplaced(outcome):
    """Why the refusal of a deck is not as it should be: exit code 2 and a place in front of each error; or empty."""
    if outcome.code != 2:
        return f"exit code {outcome.code} instead of 2: {last_line(outcome.err)}"
    if not PLACE.match(outcome.err):
        return f"no file:line:column in front: {outcome.err.strip().splitlines()[:1]}"
    return "" if not outcome.out else f"something on the standard output: {outcome.out[:80]!r}"


def last_line(text):
    """The last line of a text that is not empty."""
    lines = text.strip().splitlines()
    return lines[-1] if lines else "nothing was said"

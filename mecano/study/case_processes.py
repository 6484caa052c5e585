"""Processes of cases: separate ones, or forks of one that has loaded what all cases need (fork_server.py).

A fork begins in a fifth of the time of a separate process. The forks of Python's multiprocessing would import the
user's script again.
"""

import contextlib
import json
import os
import select
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import IO, NamedTuple, Protocol

from mecano.errors import ResultsError
from mecano.jit import thread_pool
from mecano.process.lifeline import popen_options

PROGRAM = (sys.executable, "-m", "mecano")
SERVER = (sys.executable, "-m", "mecano.study.fork_server")
ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"), "1")
REPORTS = 4096  # B of reports read at once
CAN_FORK = sys.platform == "linux"  # libraries of macOS do not survive a fork


class End(NamedTuple):
    """End of a process: its number, its exit code or minus the number of a signal, and its processor time [s]."""

    number: int
    code: int
    processor_time: float


def end_of(number: int, options: int = 0) -> End | None:
    """Wait for a child process, with the ``options`` of os.waitpid, and return its End; None if it still runs."""
    found, status, used = os.wait4(number, options)
    return End(found, os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime) if found else None


def _options():
    """Return options of Popen for a process with one thread, in a process group of its own, that ends with this one."""
    options = popen_options()
    return {**options, "env": {thread_pool.VARIABLE: "1", **options["env"], **ONE_THREAD}, "process_group": 0}


class CaseProcesses(Protocol):
    """Processes of cases, which end with this process."""

    def start(self, words: Sequence[str], log: Path) -> int:
        """Start `mecano WORDS`, with its output appended to the file ``log``; return the number of the process."""
        ...

    def send(self, number: int, wanted: int) -> None:
        """Send the signal ``wanted`` to a process, if it still runs."""
        ...

    def ended(self) -> list[End]:
        """Return the End of each process that has ended since the last call."""
        ...

    def readable(self) -> list[int]:
        """Return the file descriptors that become readable when a process ends, if SIGCHLD does not report it."""
        ...

    def close(self) -> None:
        """Wait until all processes have ended."""
        ...


class SeparateProcesses:
    """CaseProcesses of which each loads what it needs."""

    def __init__(self) -> None:
        self._running: dict[int, subprocess.Popen[bytes]] = {}

    def start(self, words: Sequence[str], log: Path) -> int:  # noqa: D102
        with open(log, "ab") as stream:
            process: subprocess.Popen[bytes] = subprocess.Popen(
                [*PROGRAM, *words], stdin=subprocess.DEVNULL, stdout=stream, stderr=stream, **_options()
            )
        self._running[process.pid] = process
        return process.pid

    def send(self, number: int, wanted: int) -> None:  # noqa: D102
        if number in self._running:
            os.kill(number, wanted)  # Popen.send_signal would wait for it first

    def ended(self) -> list[End]:  # noqa: D102
        found = [end for number in self._running if (end := end_of(number, os.WNOHANG))]
        for end in found:
            self._running.pop(end.number).returncode = end.code
        return found

    def readable(self) -> list[int]:  # noqa: D102
        return []

    def close(self) -> None:  # noqa: D102
        for process in self._running.values():
            process.wait()


class Server(NamedTuple):
    """The running server, what it reads, and what it writes."""

    process: subprocess.Popen[bytes]
    requests: IO[bytes]
    reports: IO[bytes]


class ForkedProcesses:
    """CaseProcesses forked from a process that has run the start of a deck.

    Parameters
    ----------
    deck : str
        File of the deck.
    overrides : sequence of str
        Texts of `mecano run --set`.
    plugins : sequence of str
        Files that it needs.
    """

    def __init__(self, deck: str, overrides: Sequence[str], plugins: Sequence[str] = ()):
        self._words = [*SERVER, json.dumps([deck, [*overrides], [*plugins]])]
        self._server: Server | None = None
        self._running: set[int] = set()
        self._started: list[int] = []  # numbers, and ends, that the server has reported
        self._ends: list[End] = []
        self._unread = b""  # beginning of a line

    def start(self, words: Sequence[str], log: Path) -> int:  # noqa: D102
        server = self._server = self._server or self._begun()
        log.touch()  # a signal may end the process before it opens the file
        with contextlib.suppress(BrokenPipeError):
            server.requests.write(f"{json.dumps([list(words), str(log)])}\n".encode())
            server.requests.flush()
        while not self._started and self._server:
            self._receive(self._server)
        if not self._started:
            raise ResultsError("the process that starts the cases has been killed; --resume continues the study")
        self._running.add(number := self._started.pop())
        return number

    def _begun(self):
        process: subprocess.Popen[bytes] = subprocess.Popen(
            self._words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, **_options()
        )
        assert process.stdin and process.stdout, "both are pipes"
        return Server(process, process.stdin, process.stdout)

    def _receive(self, server):
        """Wait for reports of the ``server``; if it has been killed, kill all processes, which nobody can await."""
        reports = os.read(server.reports.fileno(), REPORTS)
        if not reports:
            self._lose(server)
        *lines, self._unread = (self._unread + reports).split(b"\n")
        for values in map(json.loads, lines):
            if len(values) == 1:
                self._started += values
            else:
                self._ends.append(End(*values))

    def _lose(self, server):
        self._end(server)
        for number in self._running:
            with contextlib.suppress(ProcessLookupError):
                os.kill(number, signal.SIGKILL)
            self._ends.append(End(number, -signal.SIGKILL, 0.0))

    def send(self, number: int, wanted: int) -> None:  # noqa: D102
        if number in self._running:
            with contextlib.suppress(ProcessLookupError):
                os.kill(number, wanted)

    def ended(self) -> list[End]:  # noqa: D102
        while self._server and select.select([self._server.reports], [], [], 0.0)[0]:
            self._receive(self._server)
        found, self._ends = self._ends, []
        self._running.difference_update(end.number for end in found)
        return found

    def readable(self) -> list[int]:  # noqa: D102
        return [self._server.reports.fileno()] if self._server else []

    def close(self) -> None:  # noqa: D102
        self.ended()
        while self._running and self._server:
            self._receive(self._server)
            self.ended()
        if self._server:
            self._end(self._server)

    def _end(self, server):
        with contextlib.suppress(BrokenPipeError):
            server.requests.close()
        server.reports.close()
        server.process.wait()
        self._server, self._unread = None, b""

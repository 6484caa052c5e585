"""Parallel cases on this machine: one process for each, so that no case can affect another."""

import os
import re
import select
import signal
import time
from collections.abc import Callable, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

from mecano.elements import plugins
from mecano.process.interrupt import CLOCK, EXIT_CODES, SIGNALS
from mecano.study.case_processes import CAN_FORK, CaseProcesses, ForkedProcesses, SeparateProcesses
from mecano.study.error_location import line_in_study
from mecano.study.folder import COMPLETE, FAILED, RESUMABLE, STOPPED, Folder, Record
from mecano.study.read import Case

FEW = 4  # cases: for fewer, loading what they need once is not faster
LOOK = 0.2  # s between two checks of memory and time
GRACE, SHARE = 10.0, 0.1  # s, and share of its time limit, after which a case that does not end is killed
END_BY = set(SIGNALS) - {CLOCK}
LONGEST_REASON = 300  # characters
Ended: TypeAlias = "Callable[[Case, Record], object]"  # called with each case as it ends
HIGH_WATER = re.compile(r"VmHWM:\s*(\d+) kB")


@dataclass(frozen=True)
class Limits:
    """Limits of one case: wall-clock time [s] and memory [B]; None: no limit."""

    time: int | None = None
    memory: int | None = None


def case_words(folder: Folder, limits: Limits) -> tuple[str, ...]:
    """Return the arguments of a command that runs one case of a study; the number of the case must be appended."""
    words = ["sweep", os.path.abspath(folder.study.file), "-o", str(folder.path.absolute())]
    words += plugin_words()
    words += ["--memory-limit", str(limits.memory // 10**6)] if limits.memory else []
    words += ["--time-limit", str(limits.time)] if limits.time else []
    return (*words, "--case")


def plugin_words() -> list[str]:
    """Return the options by which another process loads the plugins of this one."""
    return [word for file in plugins.files() for word in ("--plugin", file)]


def run_here(folder: Folder, cases: Sequence[Case], ended: Ended, *, limits: Limits, jobs: int) -> int | None:
    """Run cases on this machine, ``jobs`` in parallel; ``ended`` and the return value: see ``Pool``."""
    processes: CaseProcesses = SeparateProcesses()
    if CAN_FORK and len(cases) >= FEW:
        processes = ForkedProcesses(folder.study.deck, folder.study.overrides(cases[0]), plugins.files())
    with folder.held():
        return Pool(folder, jobs, limits, ended, processes).run(cases)


@dataclass
class Running:
    """A running case; ``before`` is the Record of its earlier processes."""

    case: Case
    number: int  # of its process
    before: Record
    log: Path
    log_start: int  # B in the log before this process
    memory: int = 0  # B, peak
    begun: float = field(default_factory=time.monotonic)
    killed: str = ""  # reason, if it was killed


class Pool:
    """Runner of cases, at most ``jobs`` at a time, that saves a Record of each.

    Parameters
    ----------
    folder : Folder
    jobs : int
    limits : Limits
    ended : function
        Called with (case, Record) of each as it ends.
    processes : CaseProcesses, optional
        Default: separate ones.
    """

    def __init__(
        self,
        folder: Folder,
        jobs: int,
        limits: Limits,
        ended: Ended = lambda case, record: None,
        processes: CaseProcesses | None = None,
    ):
        self.folder, self.jobs, self.limits, self.ended = folder, jobs, limits, ended
        self.processes = processes or SeparateProcesses()
        self.running: list[Running] = []
        self.received: list[int] = []  # signals that end the study
        self._forwarded = 0

    def run(self, cases: Sequence[Case]) -> int | None:
        """Run all cases to their ends, or until a signal ends them; return the number of the signal, or None."""
        waiting = list(reversed(cases))
        with self._listening() as wakeup:
            try:
                self._run(waiting, wakeup)
            finally:
                self._end()
        return self.received[0] if self.received else None

    def _run(self, waiting, wakeup):
        while (waiting and not self.received) or self.running:
            while waiting and not self.received and len(self.running) < self.jobs:
                self.running.append(self._start(waiting.pop()))
            self._wait(wakeup)
            self._forward()
            self._watch()
            self._gather()

    def _end(self):
        """End all processes if this one fails: each writes a checkpoint, and --resume continues from it."""
        for one in self.running:
            self.processes.send(one.number, signal.SIGTERM)
        self.processes.close()

    def _start(self, case):
        folder, study, log = self.folder, self.folder.study, self.folder.file(case, ".log")
        limit = ["--max-walltime", str(self.limits.time)] if self.limits.time else []
        settings = [word for text in study.overrides(case) for word in ("--set", text)]
        words = ["run", study.deck, "-o", str(folder.file(case, ".h5")), "-q", "--resume", *limit, *settings]
        words += plugin_words()
        before, log_start = folder.record(case), os.path.getsize(log) if log.exists() else 0
        return Running(case, self.processes.start(words, log), before, log, log_start)

    @contextmanager
    def _listening(self):
        """Provide within this block a file descriptor that becomes readable on signals and ends of processes."""
        wakeup, writing_end = os.pipe()
        os.set_blocking(wakeup, False)
        os.set_blocking(writing_end, False)
        handlers = {number: signal.signal(number, self._receive) for number in END_BY}
        handlers[signal.SIGCHLD] = signal.signal(signal.SIGCHLD, lambda *_: None)
        fd = signal.set_wakeup_fd(writing_end, warn_on_full_buffer=False)
        try:
            yield wakeup
        finally:
            signal.set_wakeup_fd(fd)
            for number, handler in handlers.items():
                signal.signal(number, handler)
            os.close(wakeup)
            os.close(writing_end)

    def _receive(self, number, frame):
        self.received.append(number)

    def _wait(self, wakeup):
        """Wait until a process ends, a signal arrives, or some time has passed."""
        select.select([wakeup, *self.processes.readable()], [], [], LOOK)
        try:
            os.read(wakeup, 4096)
        except BlockingIOError:
            pass

    def _forward(self):
        """Forward received signals to the processes, which are in process groups of their own."""
        for number in self.received[self._forwarded :]:
            for one in self.running:
                self.processes.send(one.number, number)
            self._forwarded += 1

    def _watch(self):
        """Kill processes that use too much memory, or exceed their time."""
        for one in self.running:
            one.memory = max(one.memory, _memory(one.number))
            if self.limits.memory and one.memory > self.limits.memory:
                one.killed = f"used more than {self.limits.memory / 1e6:.0f} MB of memory"
            elif self.limits.time and time.monotonic() > one.begun + (1.0 + SHARE) * self.limits.time + GRACE:
                one.killed = f"did not end in its time of {self.limits.time} s"
            if one.killed:
                self.processes.send(one.number, signal.SIGKILL)

    def _gather(self):
        """Save the Records of ended processes."""
        running = {one.number: one for one in self.running}
        for end in self.processes.ended():
            one = running[end.number]
            self.running.remove(one)
            record = self._record(one, end)
            self.folder.write(one.case, record)
            self.ended(one.case, record)

    def _record(self, one, end):
        code, before = end.code, one.before
        if code == 0:
            status, reason = COMPLETE, ""
        elif self.received or (code in RESUMABLE and not one.killed):
            status, reason = STOPPED, _reason(one, code)
        else:
            status, reason = FAILED, line_in_study(_reason(one, code), self.folder.study, one.case)
        return Record(
            status, code, before.processor_time + end.processor_time,
            before.wall_time + time.monotonic() - one.begun, max(before.memory, one.memory), reason,
        )  # fmt: skip


def _memory(number):
    """Return the peak memory of a process [B]; 0 after its end, or if unknown.

    getrusage is not used: it reports at least the memory that this process had when it started the other.
    """
    try:
        found = HIGH_WATER.search(Path(f"/proc/{number}/status").read_text())
    except OSError:
        return 0
    return 1024 * int(found[1]) if found else 0


def _reason(one, code):
    """Return the reason why a case ended on one line: its message, or the signal."""
    if one.killed:
        return one.killed
    if code < 0 and -code not in EXIT_CODES:
        return f"ended by {signal.Signals(-code).name}"
    with open(one.log, encoding="utf-8", errors="replace") as stream:
        stream.seek(one.log_start)
        reason = reason_in(stream.read())
    return reason or (f"ended by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}")


def reason_in(output: str) -> str:
    """Return the line of the output of a process that gives the reason of its end, or ""."""
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    line = lines[-1 if lines[0].startswith("Traceback") else 0] if lines else ""
    return line.removeprefix("mecano: ").partition("; continue with: ")[0][:LONGEST_REASON]

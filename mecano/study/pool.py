"""Cases side by side on this machine: a process for each, so that none can hurt another."""

import os
import re
import select
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from mecano.elements import plugins
from mecano.process.interrupt import CLOCK, EXIT_CODES, SIGNALS
from mecano.process.lifeline import tied
from mecano.study.folder import COMPLETE, FAILED, GO_ON, STOPPED, Record
from mecano.study.places import line_in_study

PROGRAM = (sys.executable, "-m", "mecano")
ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"), "1")
LOOK = 0.2  # s between two looks at memory and time
GRACE, SHARE = 10.0, 0.1  # s, and share of its time, after which a case that does not end is killed
END_BY = set(SIGNALS) - {CLOCK}
LONGEST_REASON = 300  # characters
HIGH_WATER = re.compile(r"VmHWM:\s*(\d+) kB")


@dataclass(frozen=True)
class Limits:
    """Of one case: wall-clock time [s] and memory in use [B]; None: without."""

    time: int | None = None
    memory: int | None = None


def case_words(folder, limits):
    """Arguments of a command that runs one case of a study alone, whose number is to follow."""
    words = ["sweep", os.path.abspath(folder.study.file), "-o", str(folder.path.absolute())]
    words += plugin_words()
    words += ["--memory-limit", str(limits.memory // 10**6)] if limits.memory else []
    words += ["--time-limit", str(limits.time)] if limits.time else []
    return (*words, "--case")


def plugin_words():
    """Options that name the plugins of this process to another one."""
    return [word for file in plugins.files() for word in ("--plugin", file)]


def run_here(folder, cases, ended, *, limits, jobs):
    """Run cases on this machine, ``jobs`` side by side; ``ended`` and what is returned as of ``Pool``."""
    with folder.held():
        return Pool(folder, jobs, limits, ended).run(cases)


@dataclass
class Running:
    """A case that runs; ``before`` is the Record of its earlier processes."""

    case: object
    process: subprocess.Popen
    before: Record
    log: Path
    said: int  # B in the log before this process
    memory: int = 0  # B in use at most
    begun: float = field(default_factory=time.monotonic)
    killed: str = ""  # why, if it was


class Pool:
    """Runs cases, as many at a time as there are ``jobs``, and keeps a Record of each.

    Parameters
    ----------
    folder : Folder
    jobs : int
    limits : Limits
    ended : function
        Told of (case, Record) of each as it ends.
    """

    def __init__(self, folder, jobs, limits, ended=lambda case, record: None):
        self.folder, self.jobs, self.limits, self.ended = folder, jobs, limits, ended
        self.running = []
        self.asked = []  # signals that came, of those that end the study
        self._forwarded = 0

    def run(self, cases):
        """Run cases to the end of each, or until a signal ends them all; returns the number of the signal, or None."""
        waiting = list(reversed(cases))
        with self._listening() as bell:
            try:
                self._run(waiting, bell)
            finally:
                self._end()
        return self.asked[0] if self.asked else None

    def _run(self, waiting, bell):
        while (waiting and not self.asked) or self.running:
            while waiting and not self.asked and len(self.running) < self.jobs:
                self.running.append(self._start(waiting.pop()))
            _rest(bell)
            self._forward()
            self._watch()
            self._gather()

    def _end(self):
        """Let no process outlive an error in this one: each writes a checkpoint, and --resume continues from it."""
        for one in self.running:
            os.kill(one.process.pid, signal.SIGTERM)
        for one in self.running:
            one.process.wait()

    def _start(self, case):
        folder, study, log = self.folder, self.folder.study, self.folder.file(case, ".log")
        limit = ["--max-walltime", str(self.limits.time)] if self.limits.time else []
        settings = [word for text in study.overrides(case) for word in ("--set", text)]
        words = ["run", study.deck, "-o", str(folder.file(case, ".h5")), "-q", "--resume", *limit, *settings]
        words += plugin_words()
        before, child = folder.record(case), tied()
        child["env"] |= ONE_THREAD
        with open(log, "ab") as stream:
            said = stream.tell()
            process = subprocess.Popen(
                [*PROGRAM, *words], stdin=subprocess.DEVNULL, stdout=stream, stderr=stream, process_group=0, **child
            )
        return Running(case, process, before, log, said)

    @contextmanager
    def _listening(self):
        """In this block signals, and the ends of processes, ring a bell: a file to wait for."""
        bell, rope = os.pipe()
        os.set_blocking(bell, False)
        os.set_blocking(rope, False)
        handlers = {number: signal.signal(number, self._ask) for number in END_BY}
        handlers[signal.SIGCHLD] = signal.signal(signal.SIGCHLD, lambda *_: None)
        fd = signal.set_wakeup_fd(rope, warn_on_full_buffer=False)
        try:
            yield bell
        finally:
            signal.set_wakeup_fd(fd)
            for number, handler in handlers.items():
                signal.signal(number, handler)
            os.close(bell)
            os.close(rope)

    def _ask(self, number, frame):
        self.asked.append(number)

    def _forward(self):
        """Tell the processes, which are in groups of their own, what this one was told."""
        for number in self.asked[self._forwarded :]:
            for one in self.running:
                os.kill(one.process.pid, number)  # Popen.send_signal would wait for it first
            self._forwarded += 1

    def _watch(self):
        """Kill what uses too much memory, or does not end in its time."""
        for one in self.running:
            one.memory = max(one.memory, _memory(one.process.pid))
            if self.limits.memory and one.memory > self.limits.memory:
                one.killed = f"used more than {self.limits.memory / 1e6:.0f} MB of memory"
            elif self.limits.time and time.monotonic() > one.begun + (1.0 + SHARE) * self.limits.time + GRACE:
                one.killed = f"did not end in its time of {self.limits.time} s"
            if one.killed:
                os.kill(one.process.pid, signal.SIGKILL)

    def _gather(self):
        """Keep the Records of those that have ended."""
        ended = [(one, used) for one in self.running if (used := _used(one.process)) is not None]
        for one, used in ended:
            self.running.remove(one)
            record = self._record(one, used)
            self.folder.write(one.case, record)
            self.ended(one.case, record)

    def _record(self, one, used):
        code, before = one.process.returncode, one.before
        if code == 0:
            status, reason = COMPLETE, ""
        elif self.asked or (code in GO_ON and not one.killed):
            status, reason = STOPPED, _words(one, code)
        else:
            status, reason = FAILED, line_in_study(_words(one, code), self.folder.study, one.case)
        return Record(
            status, code, before.processor_time + used.ru_utime + used.ru_stime,
            before.wall_time + time.monotonic() - one.begun, max(before.memory, one.memory), reason,
        )  # fmt: skip


def _rest(bell):
    """Wait until a process ends or a signal comes, or some time."""
    select.select([bell], [], [], LOOK)
    try:
        os.read(bell, 4096)
    except BlockingIOError:
        pass


def _used(process):
    """What an ended process has used, as of getrusage; None while it runs."""
    number, status, used = os.wait4(process.pid, os.WNOHANG)
    if number == 0:
        return None
    process.returncode = os.waitstatus_to_exitcode(status)
    return used


def _memory(number):
    """Memory that a process has used at most [B]; 0 when it has ended, or where this cannot be known.

    What getrusage says of an ended process is not less than what this one used when it was started.
    """
    try:
        found = HIGH_WATER.search(Path(f"/proc/{number}/status").read_text())
    except OSError:
        return 0
    return 1024 * int(found[1]) if found else 0


def _words(one, code):
    """Why a case ended, in a line: what it said, or what ended it."""
    if one.killed:
        return one.killed
    if code < 0 and -code not in EXIT_CODES:
        return f"ended by {signal.Signals(-code).name}"
    with open(one.log, encoding="utf-8", errors="replace") as stream:
        stream.seek(one.said)
        said = gist(stream.read())
    return said or (f"ended by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}")


def gist(said):
    """The line of what a process said that tells why it ended; "" where there is none."""
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    line = lines[-1 if lines[0].startswith("Traceback") else 0] if lines else ""
    return line.removeprefix("mecano: ").partition("; go on with: ")[0][:LONGEST_REASON]

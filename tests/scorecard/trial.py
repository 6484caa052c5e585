"""Trials of the scorecard: what one is, and how many are made side by side, each safe from the crashes of others.

A trial is made in a worker process. Where it ends its worker (a signal, a hang), it counts as not held and a new worker
takes the next one. What lies in the folder of a trial that was not held is kept.
"""

import contextlib
import ctypes
import multiprocessing
import os
import re
import shutil
import signal
import tempfile
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import wait
from pathlib import Path

FORK = multiprocessing.get_context("fork")
LARGEST_KEPT = 20e6  # bytes of a file that is kept
LONGEST_NAME = 80
PR_SET_PDEATHSIG = 1


@dataclass(frozen=True)
class Line:
    """One line of the scorecard."""

    number: int
    what: str
    weight: float
    count: int  # trials of a full run


@dataclass(frozen=True)
class Trial:
    """The outcome of one trial; ``why`` it was not held, empty where it was."""

    line: int
    name: str
    why: str = ""

    @property
    def held(self):
        """True where the trial was held."""
        return not self.why


@dataclass(frozen=True)
class Job:
    """One trial to be made, or several that share their work.

    ``action(folder)`` returns why it was not held (text, empty where it was), or a list of Trials. ``cpu`` limits its
    processor time and ``wall`` its wall-clock time [s].
    """

    line: int
    name: str
    action: Callable
    cpu: float = 0.0  # none
    wall: float = 300.0


def spread(jobs, keep, workers=2):
    """Make the ``jobs`` in worker processes; yield lists of Trials as they end.

    ``keep`` is the folder into which the files of trials go that were not held.
    """
    jobs, pool = list(jobs), []
    pending = iter(range(len(jobs)))
    with tempfile.TemporaryDirectory(prefix="scorecard") as scratch:
        try:
            pool = [_Worker(jobs, Path(scratch) / str(i), keep) for i in range(min(workers, len(jobs)))]
            for worker in pool:
                worker.give(next(pending, None))
            while busy := [worker for worker in pool if worker.job is not None]:
                wait([worker.pipe for worker in busy], 1.0)
                for worker in busy:
                    trials = worker.answer()
                    if trials is not None:
                        worker.give(next(pending, None))
                        yield trials
        finally:
            for worker in pool:
                worker.end()


class _Worker:
    """A process that makes one job after another, and its replacement where it ends."""

    def __init__(self, jobs, folder, keep):
        self.jobs, self.folder, self.keep, self.job = jobs, folder, keep, None
        self._start()

    def _start(self):
        self.pipe, theirs = FORK.Pipe()
        self.process = FORK.Process(target=_work, args=(self.jobs, self.folder, self.keep, theirs))
        self.process.start()
        theirs.close()

    def give(self, index):
        """Let it make the job of this index; None ends its work."""
        self.job = None if index is None else self.jobs[index]
        if index is not None:
            self.begun = time.monotonic()
            self.pipe.send(index)

    def answer(self):
        """The Trials of its job, None where it has not ended yet."""
        if self.pipe.poll():
            try:
                return self.pipe.recv()
            except EOFError:
                self.process.join()
                return self._lost(why_ended(self.process.exitcode, self.job.cpu))
        if time.monotonic() - self.begun > self.job.wall:
            self.end()
            return self._lost(f"no end within {self.job.wall:g} s")
        return None

    def _lost(self, why):
        self.end()
        _keep(self.folder, self.keep, self.job)
        trials = [Trial(self.job.line, self.job.name, why)]
        self._start()
        return trials

    def end(self):
        """Kill the process and what it has started."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        with contextlib.suppress(ProcessLookupError):
            os.kill(self.process.pid, signal.SIGKILL)
        self.process.join()
        self.pipe.close()


def why_ended(code, cpu):
    """Why a worker that ended with this code has not held its trial."""
    if code == -signal.SIGPROF:
        return f"more than {cpu:g} s of processor time"
    return (
        f"the process was ended by {signal.Signals(-code).name}" if code < 0 else f"the process ended with code {code}"
    )


def end_with_parent():
    """Let this process be killed when the one that has started it ends (Linux)."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def _work(jobs, folder, keep, pipe):
    os.setpgid(0, 0)
    end_with_parent()
    while True:
        job = jobs[pipe.recv()]
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        if job.cpu:
            signal.setitimer(signal.ITIMER_PROF, job.cpu)
        try:
            found = job.action(folder)
        except Exception:
            (folder / "judge.txt").write_text(traceback.format_exc())
            found = "the judge itself failed: " + traceback.format_exc().strip().splitlines()[-1]
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
        trials = [Trial(job.line, job.name, found)] if isinstance(found, str) else list(found)
        if not all(trial.held for trial in trials):
            _keep(folder, keep, job)
        pipe.send(trials)


def _keep(folder, keep, job):
    """Copy what a trial has left."""
    target = Path(keep) / f"line_{job.line}" / re.sub(r"[^\w.=+-]+", "_", job.name)[:LONGEST_NAME]
    for path in sorted(Path(folder).rglob("*")) if folder.exists() else ():
        with contextlib.suppress(OSError):
            if path.is_file() and not path.is_symlink() and path.stat().st_size <= LARGEST_KEPT:
                place = target / path.relative_to(folder)
                place.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(path, place)

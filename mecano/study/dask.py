"""Cases of a study as tasks of Dask, whose workers start the same processes as the tasks of a Slurm array."""

import json
import logging
import queue
import signal
import subprocess
from collections.abc import Sequence
from contextlib import contextmanager
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING
from uuid import uuid4

from mecano.errors import UsageError
from mecano.process.lifeline import popen_options
from mecano.study.case_processes import PROGRAM
from mecano.study.folder import STOPPED, Folder, Record
from mecano.study.pool import END_BY, LOOK, Ended, Limits, case_words, reason_in

if TYPE_CHECKING:
    import os

    from distributed import Client, Future

    from mecano.study.read import Case

PATIENCE = 10  # s until a scheduler must answer
CHECK = 1.0  # s between two checks of a worker for the end of the study
MISSING = "--executor dask needs Dask, which is not installed: pip install mecano[dask]"
AT_ONCE = 2  # signals that end the study without waiting for its cases


def require(scheduler: str | None = None) -> None:
    """Raise UsageError if Dask is not installed, or the ``scheduler`` at an address does not answer."""
    if not find_spec("distributed"):
        raise UsageError(MISSING)
    if scheduler is not None:
        _connected(scheduler).close()


def _connected(scheduler):
    """Return a Client of the scheduler at an address. Raises UsageError if it does not answer."""
    from distributed import Client

    try:
        return Client(scheduler, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise UsageError(f"no Dask scheduler answers at {scheduler}: {error}") from error


def run_in_tasks(
    folder: Folder, cases: "Sequence[Case]", ended: Ended, *, limits: Limits, jobs: int, scheduler: str | None = None
) -> int | None:
    """Run cases on the workers of the ``scheduler`` at an address, which share the folder, or ``jobs`` at a time here.

    ``ended`` and the return value: see ``Pool``. Raises UsageError without Dask, or if no scheduler answers.
    """
    try:
        from distributed import Client, LocalCluster
    except ImportError:
        raise UsageError(MISSING) from None
    with folder.held():
        pass  # from now on the tasks lock it
    if scheduler is None:
        workers = {"n_workers": 1, "threads_per_worker": jobs, "processes": False, "dashboard_address": None}
        with LocalCluster(silence_logs=logging.CRITICAL, **workers) as cluster, Client(cluster) as client:
            return Tasks(folder, limits, ended, client).run(cases)
    with _connected(scheduler) as client:
        return Tasks(folder, limits, ended, client).run(cases)


class Tasks:
    """Runner of cases as tasks of a Dask client; otherwise like ``Pool``."""

    def __init__(self, folder: Folder, limits: Limits, ended: Ended, client: "Client"):
        self.folder, self.ended, self.client = folder, ended, client
        self.words = case_words(folder, limits)
        self.received: list[int] = []  # signals that end the study

    def run(self, cases: "Sequence[Case]") -> int | None:
        """Run all cases to their ends, or until a signal ends them; return the number of the signal, or None."""
        from distributed import Event

        stop = Event(f"mecano-{uuid4()}", client=self.client)
        done: queue.SimpleQueue[Future] = queue.SimpleQueue()  # tasks that have ended
        futures = {self._submit(case, stop.name, done): case for case in cases}
        with self._listening():
            while futures and self.client.status == "running" and len(self.received) < AT_ONCE:
                if self.received and not stop.is_set():
                    stop.set()
                self._take(done, futures)
            if self.received and not stop.is_set():
                stop.set()
        return self.received[0] if self.received else None

    def _submit(self, case, stop, done):
        file = self.folder.file(case, ".json").absolute()
        future = self.client.submit(run_case, (*self.words, str(case.number)), file, stop, pure=False)
        future.add_done_callback(done.put)
        return future

    def _take(self, done, futures):
        """Wait for the end of a task, or some time; report its case if it was begun."""
        try:
            future = done.get(timeout=LOOK)
        except queue.Empty:
            return
        case = futures.pop(future)
        record = self._record(case, future)
        if record is not None:
            self.ended(case, record)

    def _record(self, case, future):
        if future.status != "error":
            return future.result() if future.status == "finished" else None  # the scheduler is lost
        record = replace(self.folder.record(case), status=STOPPED, reason=f"its task failed: {future.exception()}")
        self.folder.write(case, record)
        return record

    @contextmanager
    def _listening(self):
        """Record signals within this block."""
        handlers = {number: signal.signal(number, lambda number, _: self.received.append(number)) for number in END_BY}
        try:
            yield
        finally:
            for number, handler in handlers.items():
                signal.signal(number, handler)


def run_case(words: Sequence[str], file: "str | os.PathLike[str]", stop: str) -> Record | None:
    """Run a case on a worker by the ``words`` of a command; return the Record that its process wrote to ``file``.

    The process is terminated once the Event named ``stop`` is set; if it is already set, None is returned. Raises
    RuntimeError with the output of the process if it wrote no Record.
    """
    from distributed import Event

    stop_event, before = Event(stop), _content(file)
    if stop_event.is_set():
        return None
    process = subprocess.Popen(
        [*PROGRAM, *words], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        process_group=0, **popen_options(),
    )  # fmt: skip
    errors = _error_output(process, stop_event)
    content = _content(file)
    if content == before:
        raise RuntimeError(reason_in(errors) or f"exit code {process.returncode}")
    return Record(**json.loads(content)["ended"])


def _error_output(process, stop_event):
    """Wait until a process ends, and terminate it once the Event is set; return its error output."""
    while True:
        try:
            return process.communicate(timeout=CHECK)[1]
        except subprocess.TimeoutExpired:
            if stop_event.is_set():
                process.terminate()


def _content(file):
    return Path(file).read_text(encoding="utf-8") if Path(file).exists() else ""

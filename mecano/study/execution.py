"""Execution of a study: select the cases, run them here, by Slurm or by Dask, and write the table."""

import os
import subprocess
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, TypeAlias

from mecano.analyses.progress import COMPILING, StudyProgress
from mecano.deck.deck import Deck
from mecano.errors import BeyondLimitsError, IncompleteStudyError, UsageError
from mecano.process.interrupt import Interruption, Stopped, resume_command
from mecano.process.lifeline import popen_options
from mecano.study.case_processes import PROGRAM
from mecano.study.folder import COMPLETE, FAILED, Folder, Record
from mecano.study.pool import Ended, Limits, Pool, plugin_words
from mecano.study.read import Case
from mecano.study.table import Table

RunCases: TypeAlias = "Callable[[Folder, Sequence[Case], Ended], int | None]"
"""Runs cases; returns the number of the signal that ended them, or None"""


class Due(NamedTuple):
    """Cases to run, and those among them that start again, whose files are removed first."""

    cases: list[Case]
    again: list[Case]


def due(folder: Folder, *, resume: bool = False, failed: bool = False, force: bool = False) -> Due:
    """Return the Due cases: all cases of a new study, the incomplete cases of one that has begun.

    Failed cases are included only with ``failed``; these and, with ``force``, all cases start again. Raises UsageError
    if cases have been run and none of ``resume``, ``failed`` and ``force`` is given.
    """
    cases = folder.study.cases
    if os.path.exists(folder.path) and not os.path.isdir(folder.path):
        raise UsageError(f"{folder.path} is a file; the cases need a folder")
    if folder.begun() and not (resume or failed or force):
        raise UsageError(
            f"{folder.path} has cases: --resume (in Python resume=True) continues them, "
            "--force (force=True) deletes them and runs all"
        )
    if force:
        return Due(list(cases), list(cases))
    records = {case.number: folder.record(case) for case in cases}
    again = [case for case in cases if failed and records[case.number].status == FAILED]
    done = (COMPLETE,) if failed else (COMPLETE, FAILED)
    return Due([case for case in cases if records[case.number].status not in done], again)


def clear(folder: Folder, cases: Sequence[Case]) -> None:
    """Remove all files of some cases. Raises UsageError if another process runs cases of the study."""
    if cases and folder.begun():
        with folder.held():
            folder.clear(cases)


def _compile_first(deck, announce):
    """Run the beginning of a checked Deck in a separate process, so that no case has to compile.

    A case that compiles may exceed its limits of time and memory. ``announce(text)`` is called if something is
    compiled.
    """
    settings = [word for text in deck.overrides for word in ("--set", text)]
    process = subprocess.Popen(
        [*PROGRAM, "warmup", deck.file, *settings, *plugin_words()],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        **popen_options(),
    )
    with process:
        try:
            for line in process.stderr or ():
                if COMPILING in line:
                    announce(COMPILING)
        except BaseException:  # a signal: end the child first, then handle it
            process.kill()
            process.wait()
            raise


def execute(
    deck: Deck,
    folder: Folder,
    units: Mapping[str, str],
    due: Due,
    run_cases: RunCases,
    interruption: Interruption,
    *,
    quiet: bool = False,
) -> Table:
    """Delete the cases that run again, compile the code that the Deck needs, run the cases, write and return the Table.

    Parameters
    ----------
    deck : Deck
        That of the study, checked.
    folder : Folder
    units : dict
        Units of the varied values (units.py).
    due : Due
    run_cases : function
        (folder, cases, ended) -> number of the signal that ended them, or None (see ``run_here``).
    interruption : Interruption
    quiet : bool
        Print no progress on the standard error.

    Raises
    ------
    Stopped
        A signal has ended the study; the message states the command that resumes it.
    """
    clear(folder, due.again)
    progress, cases = StudyProgress(quiet, folder.path), due.cases
    if cases:
        _compile_first(deck, progress.note)
    interruption.raise_if_asked("before the cases started")
    table = _with_table(folder, units, cases, run_cases, progress, interruption.again or resume_command())
    progress.done(len(cases))
    return table


def _with_table(folder, units, cases, run_cases, progress, resume_by):
    """Run cases with ``progress(done, total, text)`` after every case, write the table, and return the Table."""
    table, failed = Table(folder, units), []

    def ended(case, record):
        table.take(case, record)
        if record.status != COMPLETE:
            failed.append(case)
        done = len(table.records)
        progress(done, len(cases), f"{len(failed)} not complete" if failed else "all complete")

    number = run_cases(folder, cases, ended)
    done = len(table.records)
    table.written()
    if number is not None:
        raise Stopped(number, f" after {done} of {len(cases)} cases; continue with: {resume_by}")
    return table


def one_case(folder: Folder, number: int, limits: Limits) -> int:
    """Run one case by its number, as a task of an array does; return its exit code. Raises UsageError."""
    if not 1 <= number <= len(folder.study.cases):
        raise UsageError(f"there is no case {number}: the study has {len(folder.study.cases)}")
    case = folder.study.cases[number - 1]
    ended: list[Record] = []
    with folder.held(alone=False):
        signal = Pool(folder, 1, limits, lambda case, record: ended.append(record)).run([case])
    if signal is not None and not ended:
        raise Stopped(signal, f" before case {case.number} was begun")
    code = ended[0].exit_code
    assert code is not None, "a case that has ended has an exit code"
    return code if code >= 0 else 128 - code


def collect(folder: Folder, units: Mapping[str, str]) -> Table:
    """Write the table of the existing cases, with the ``units`` of the varied values; return the Table.

    Raises UsageError if the study has no folder.
    """
    if not os.path.isdir(folder.path):
        raise UsageError(f"there is no folder {folder.path} with cases: run the study first, without --collect")
    table = Table(folder, units)
    table.written()
    return table


def require_success(table: Table) -> None:
    """Raise IncompleteStudyError unless all cases of a Table are complete, BeyondLimitsError unless all pass."""
    if table.incomplete:
        raise IncompleteStudyError(f"not all cases are complete: {table.incomplete}; see {table.folder.path}/table.csv")
    if table.beyond:
        counted = f"{len(table.beyond)} of {len(table.records)} cases"
        raise BeyondLimitsError(f"{counted} have outputs beyond their limits: see {table.folder.path}/table.csv")

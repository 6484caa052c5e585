"""A whole study: which cases are to be run, here, by Slurm or by Dask, and the table in the end."""

import os
import subprocess

from mecano.analyses.progress import COMPILING
from mecano.errors import IncompleteStudyError, UsageError
from mecano.process.interrupt import Stopped, again
from mecano.process.lifeline import tied
from mecano.study.folder import COMPLETE, FAILED
from mecano.study.pool import PROGRAM, Pool
from mecano.study.table import Table


def cores():
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()


def due(folder, *, resume=False, failed=False, force=False):
    """The cases that are to be run: all of a new study, of one that has begun those that are not complete.

    Those that have failed only if ``failed``; these and, with ``force``, all begin anew. Raises UsageError where cases
    have been run and neither ``resume``, ``failed`` nor ``force`` is asked for.
    """
    cases = folder.study.cases
    if folder.begun() and not (resume or failed or force):
        raise UsageError(f"there are cases in {folder.path}: --resume goes on with them, --force begins anew")
    if force:
        folder.clear(cases)
        return list(cases)
    records = {case.number: folder.record(case) for case in cases}
    if failed:
        folder.clear([case for case in cases if records[case.number].status == FAILED])
    done = (COMPLETE,) if failed else (COMPLETE, FAILED)
    return [case for case in cases if records[case.number].status not in done]


def compile_first(deck, announce=lambda text: None):
    """Run the beginning of a checked Deck in a process of its own: what it compiles, no case has to.

    A case that compiles needs more time and memory than its limits may give it. ``announce(text)`` is called where
    something is compiled.
    """
    settings = [word for text in deck.overrides for word in ("--set", text)]
    process = subprocess.Popen(
        [*PROGRAM, "warmup", deck.file, *settings], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        **tied(),
    )  # fmt: skip
    with process:
        try:
            for line in process.stderr:
                if COMPILING in line:
                    announce(COMPILING)
        except BaseException:  # a signal, which this process answers once the other has ended
            process.kill()
            process.wait()
            raise


def perform(folder, units, cases, run_cases, progress=lambda done, total, text: None, resume_by=""):
    """Let ``run_cases(folder, cases, ended)`` run cases (``run_here``), and write the table; returns the Table.

    ``units`` are those of what is varied (units.py). ``progress(done, total, text)`` is told of every case. Raises
    Stopped where a signal ends the study; it says how to resume: ``resume_by``, or the command of this process.
    """
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
        raise Stopped(number, f" after {done} of {len(cases)} cases; go on with: {resume_by or again()}")
    return table


def one_case(folder, number, limits):
    """Run the case of that number alone, as a task of an array does; returns its exit code. Raises UsageError."""
    if not 1 <= number <= len(folder.study.cases):
        raise UsageError(f"there is no case {number}: the study has {len(folder.study.cases)}")
    case, codes = folder.study.cases[number - 1], []
    with folder.held(alone=False):
        number = Pool(folder, 1, limits, lambda case, record: codes.append(record.exit_code)).run([case])
    if not codes:
        raise Stopped(number, f" before case {case.number} was begun")
    return codes[0] if codes[0] >= 0 else 128 - codes[0]


def collect(folder, units):
    """Write the table of what there is, with the ``units`` of what is varied; returns the Table."""
    table = Table(folder, units)
    table.written()
    return table


def judge(table):
    """Raise IncompleteStudyError unless all cases of a Table are complete."""
    if table.incomplete:
        raise IncompleteStudyError(f"not all cases are complete: {table.incomplete}; see {table.folder.path}/table.csv")

"""Commands for many runs, on this machine and on clusters."""

import os
import shlex
import sys
from functools import partial
from typing import NamedTuple

import click

from mecano.commands import grouped, overrides, plugins, show
from mecano.process.cores import cores
from mecano.process.interrupt import Interruption, seconds


def _as_words(context, parameter, text):
    """Return an option split into words as by a shell."""
    try:
        return shlex.split(text)
    except ValueError as error:
        raise click.BadParameter(str(error).lower(), context, parameter) from None


class Limits(NamedTuple):
    """Limits of each case."""

    time_limit: str | None
    memory_limit: int | None


class Cases(NamedTuple):
    """Which cases are run."""

    resume: bool
    again: str | None
    force: bool
    only_table: bool
    number: int | None


class Executor(NamedTuple):
    """Who runs the cases, and how."""

    executor: str
    jobs: int | None
    scheduler: str | None
    options: list[str]
    wait: bool


@click.command(short_help="Run a deck many times with varied values.")
@click.argument("study", type=click.Path())
@click.option(
    "-o",
    "--output",
    type=click.Path(),
    help="Folder of the cases; default: the study's name with _runs, in this folder.",
)
@click.option("--jobs", type=click.IntRange(1), metavar="N", help="Number of parallel cases; default: one per core.")
@click.option("--time-limit", metavar="TIME", help="Wall-clock time of each case: 3600, 2h30m or 02:30:00.")
@click.option("--memory-limit", type=click.IntRange(1), metavar="MB", help="Memory of each case.")
@click.option("--resume", is_flag=True, help="Run the cases that are neither complete nor failed.")
@click.option(
    "--again", type=click.Choice(["failed"]), help="As --resume, but also run failed cases again from their start."
)
@click.option("--force", is_flag=True, help="Delete existing cases and run all.")
@click.option(
    "--executor",
    type=click.Choice(["local", "slurm", "dask"]),
    default="local",
    show_default=True,
    help="Where the cases run: on this machine, or on a cluster with Slurm or Dask.",
)
@click.option("--scheduler", metavar="ADDRESS", help="Scheduler of Dask; default: workers on this machine.")
@click.option(
    "--sbatch",
    "options",
    metavar="OPTIONS",
    default="",
    callback=_as_words,
    help="Passed to sbatch: '--partition=x --time=1:00:00'.",
)
@click.option("--wait", is_flag=True, help="With Slurm: wait until all tasks have ended, then write the table.")
@click.option("--collect", "only_table", is_flag=True, help="Run nothing; write the table of existing results.")
@click.option("--case", "number", type=int, metavar="N", help="Run only this case, as each task of an array does.")
@click.option("--plot", is_flag=True, help="Draw the outputs over the varied parameters, next to the table.")
@click.option("-q", "--quiet", is_flag=True, help="Print no progress.")
@plugins
@grouped(limited=Limits, cases=Cases, by=Executor)
def sweep(study: str, output: str | None, limited: Limits, cases: Cases, by: Executor, plot: bool, quiet: bool) -> None:
    """Run a deck many times with varied values, each case in a separate process.

    STUDY is a file that names the deck, the variations (grid, list, csv, latin_hypercube, seeds) and the outputs of
    each run (docs/studies.md). The folder receives a results file and a log for each case, table.csv and table.h5. A
    failed case does not stop the others. Exit code 0: all cases are complete, 3: some are not, 8: some are beyond the
    limits of the outputs.
    """
    _refuse_strays(cases, by)
    interruption = Interruption()
    interruption.listen()
    from mecano.study import execution, pool
    from mecano.study.folder import Folder
    from mecano.study.read import read_study, try_deck
    from mecano.study.units import units_of

    time, memory = limited
    limits = pool.Limits(seconds(time) if time else None, memory and memory * 10**6)
    checked = read_study(study)
    folder = Folder(output or os.path.splitext(os.path.basename(study))[0] + "_runs", checked)
    if cases.number is not None:
        sys.exit(execution.one_case(folder, cases.number, limits))
    deck = try_deck(checked)
    units = units_of(checked, deck)
    if cases.only_table:
        return _finish(execution.collect(folder, units), plot)
    due = execution.due(folder, resume=cases.resume, failed=cases.again == "failed", force=cases.force)
    if by.executor == "slurm" and due.cases:
        from mecano.study.slurm import submit

        show(submit(folder, due, limits, by.options, by.wait))
        if not by.wait:
            return show(f"`mecano sweep {study} -o {folder.path} --collect` writes the table")
        return _finish(execution.collect(folder, units), plot)
    if by.executor == "dask":
        from mecano.study.dask import require

        require(by.scheduler)  # before cases are deleted that could not run again
    run_cases = partial(_runner(by), limits=limits, jobs=by.jobs or cores())
    _finish(execution.execute(deck, folder, units, due, run_cases, interruption, quiet=quiet), plot)


def _refuse_strays(cases, by):
    """Raise UsageError for options that exclude each other."""
    if (cases.resume or cases.again) and cases.force:
        raise click.UsageError("--resume and --again continue the cases, --force runs all anew")
    if by.scheduler and by.executor != "dask":
        raise click.UsageError("--scheduler belongs to --executor dask")
    if (by.options or by.wait) and by.executor != "slurm":
        raise click.UsageError("--sbatch and --wait belong to --executor slurm")
    if by.jobs and (by.scheduler or by.executor == "slurm"):
        raise click.UsageError("--jobs is for this machine: elsewhere Slurm, or the workers of Dask, set the number")


def _runner(by):
    """Return the function by which an Executor runs cases, for ``execution.execute``."""
    if by.executor == "dask":
        from mecano.study.dask import run_in_tasks

        return partial(run_in_tasks, scheduler=by.scheduler)
    from mecano.study.pool import run_here

    return run_here


def _finish(table, plot):
    """Print a summary of the study, and draw it if ``plot``. Raises the errors of ``execution.judge``."""
    from mecano.study.execution import require_success

    show(table.summary())
    if plot:
        from mecano.post.pictures import draw_alone

        show(str(draw_alone(table.folder.table)))
    require_success(table)


@click.command(short_help="Compile ahead of the first run.")
@click.argument("decks", nargs=-1, type=click.Path())
@overrides
@click.option("--share", type=click.Path(), metavar="FOLDER", help="Copy all compiled code here, for other users.")
@plugins
def warmup(decks: tuple[str, ...], overrides: tuple[str, ...], share: str | None) -> None:
    """Compile everything a deck can contain, or what the given DECKS contain, ahead of the first run.

    Compiled code is kept on disk, in the folder printed. For clusters see docs/cluster.md.
    """
    from mecano.analyses.progress import SweepProgress
    from mecano.analyses.warmup import share as copy_to
    from mecano.analyses.warmup import warmup as compile_all

    with SweepProgress(False, "").announcing_compiling():
        for text in compile_all(decks, overrides):
            show(text)
    if share:
        show(copy_to(share))

"""Export of results for other programs: comma-separated values, and points and cells for ParaView."""

import os
from collections.abc import Sequence
from pathlib import Path

from mecano.errors import ResultsError, UsageError
from mecano.post.columns import columns_of
from mecano.post.grid import grids_of
from mecano.post.quantity import time_of
from mecano.post.request import found
from mecano.post.runs import opened_runs
from mecano.post.sheet import Curve
from mecano.results.disk import atomic_hdf5_file
from mecano.results.file_names import refuse_existing
from mecano.results.lock import locked
from mecano.results.vtk_group import add_grids, write_grids
from mecano.results.whole_file import exists, refuse_other_than_file, refuse_present, write_csv

OF_COLUMNS, OF_CELLS = ".csv", ".vtkhdf"


def export(
    path: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    *,
    series: Sequence[str] = (),
    vtk: bool = False,
    force: bool = False,
) -> Path:
    """Write the content of a results file for other programs, and return the Path written.

    Parameters
    ----------
    path : str or Path
        The results file.
    output : str or Path
        File with the extension .csv or .vtkhdf, which is added if missing; by default, columns are written to the name
        of the results file with .csv, cells to the results file itself.
    series : sequence of str
        Columns, as in ``mecano post --plot``: outputs, components, patterns; empty for all series.
    vtk : bool
        Write cells (VTKHDF) instead of columns.
    force : bool
        Replace an existing file or group.

    Raises
    ------
    UsageError, UnknownNameError
        ``output`` has another extension, or ``series`` names an unknown output.
    ResultsError
        The file cannot be read, has no saved times, or the target exists or cannot be written.
    """
    target = _target(output, vtk)
    _check(target, series, vtk)
    with opened_runs([path]) as [run]:
        if not len(run.results.time):
            raise ResultsError(f"{path}: no saved times yet")
        if target is None and vtk:
            return _into_results(run, force)
        target = target or run.results.path.with_suffix(OF_COLUMNS)
        _refuse(run, target, force)
        if target.suffix == OF_CELLS:
            with atomic_hdf5_file(target) as file:
                write_grids(file, grids_of(run), run.results.time)
        else:
            write_csv(target, _all_columns(run, series), force)
    return target


def _target(output, vtk):
    """Return the Path to be written, with an extension, or None if ``output`` is not given."""
    target = Path(output) if output else None
    if target and not target.name:
        refuse_other_than_file(target)
    if target and not target.suffix:
        return target.with_name(target.name + (OF_CELLS if vtk else OF_COLUMNS))
    return target


def _check(target, series, vtk):
    if target and target.suffix not in (OF_COLUMNS, OF_CELLS):
        raise UsageError(f"-o {target}: the extension must be {OF_COLUMNS} or {OF_CELLS}")
    if target and vtk and target.suffix == OF_COLUMNS:
        raise UsageError(f"-o {target}: --vtk writes {OF_CELLS} files, or into the results file without -o")
    if series and (vtk or (target and target.suffix == OF_CELLS)):
        raise UsageError("--series selects columns of a .csv file; cells always have all forces, moments and stresses")


def _refuse(run, target, force):
    if exists(target) and target.samefile(run.results.path):
        raise UsageError(f"-o {target} is the results file itself")
    if target.suffix == OF_CELLS:
        refuse_existing(target, force)
    else:
        refuse_present(target, force)


def _into_results(run, force):
    """Add the cells to the results file. Raises ResultsError if it is being written or truncated."""
    if run.results.status in ("running", "truncated"):
        state = "is still being written" if run.results.status == "running" else "is cut short"
        raise ResultsError(f"{run.results.path} {state}: nothing is added to it; write another file with -o")
    with locked(run.results.path):
        add_grids(run.results.path, grids_of(run), run.results.time, force=force)
    return run.results.path


def _all_columns(run, series):
    quantities = [quantity for name in series or run.results.names() for quantity in found(run, name)]
    return columns_of([Curve(time_of(y), y, 0, y.subject) for y in quantities])

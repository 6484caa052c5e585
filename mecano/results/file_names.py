"""Names of results files: which are refused, and how a file gets its name when it is ready."""

import glob
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mecano.errors import ResultsError, UsageError
from mecano.results.disk import SIGNATURE
from mecano.results.lock import locked
from mecano.results.provenance import is_running
from mecano.results.whole_file import exists, first_bytes, hidden_name, refuse_other_than_file

_EXISTS = "{} already exists; give another name, or --force (in Python force=True) to replace it"
OTHERS = (".csv", ".txt", ".xlsx", ".mat", ".json", ".yaml", ".yml", ".png", ".html", ".vtkhdf")  # of other formats


def refuse_other_ending(path: str | os.PathLike[str], instead: str) -> None:
    """Raise UsageError if the name of a results file ends like that of another format; ``instead``: what writes it."""
    ending = os.path.splitext(path)[1].lower()
    if ending in OTHERS:
        raise UsageError(f"results are HDF5, not '{ending}': name them .h5; {instead}")


def refuse_existing(path: str | os.PathLike[str], force: bool) -> None:
    """Raise ResultsError if ``path`` exists, unless ``force`` is True and it is an HDF5 file."""
    refuse_other_than_file(path)
    if not exists(path):
        return
    if not force:
        raise ResultsError(_EXISTS.format(path))
    if first_bytes(path, len(SIGNATURE)) != SIGNATURE:
        raise ResultsError(f"{path} already exists and is not a results file; give another name")


@contextmanager
def to_be_written(path: str | os.PathLike[str] | None, force: bool, instead: str) -> Iterator[None]:
    """Lock a file within a block that computes and writes it, once its name is not refused; do nothing for None.

    Raises the errors of ``refuse_other_ending``, ``refuse_existing`` and ``locked``.
    """
    if path is None:
        yield
        return
    refuse_other_ending(path, instead)
    with locked(path):
        refuse_existing(path, force)
        yield


def remove_abandoned(path: Path) -> None:
    """Remove hidden files left by runs that were killed before the results file ``path`` appeared."""
    for hidden in path.parent.glob(f"{glob.escape(hidden_name(path))}.*.part"):
        process = hidden.name.split(".")[-2]
        if process.isdecimal() and not is_running(int(process)):
            hidden.unlink(missing_ok=True)


def give_name(hidden: Path, path: Path, force: bool) -> None:
    """Give the file ``hidden`` the name ``path``; an existing file is replaced only if ``force``.

    Raises ResultsError.
    """
    if force:
        os.replace(hidden, path)
        return
    try:
        os.link(hidden, path)
    except FileExistsError:
        raise ResultsError(_EXISTS.format(path)) from None
    except OSError:  # a file system without hard links
        os.rename(hidden, path)
        return
    os.unlink(hidden)

"""Opening of HDF5 files of mecano, and the messages for files that cannot be read."""

import os
import struct
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress

import h5py

from mecano.errors import MecanoError, ResultsError
from mecano.results.checked import SIGNATURE, Checked
from mecano.results.trial_reading import refuse_crashing
from mecano.results.whole_file import other_than_file

UNREADABLE = (
    OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError, IndexError, OverflowError, struct.error,
)  # fmt: skip
"""Exceptions raised for damaged files by h5py and by the interpretation of its data."""


@contextmanager
def open_checked(path: str | os.PathLike[str]) -> Iterator[h5py.File]:
    """Open the HDF5 file ``path`` for reading within a block.

    Raises ResultsError, which names the damage, if the file or anything read in the block is unreadable.
    """
    source = open_source(path)
    try:
        with h5py.File(source, "r") as file:
            yield file
    except UNREADABLE as error:
        raise ResultsError(unreadable(source, error)) from error
    finally:
        source.close()


@contextmanager
def open_format(path: str | os.PathLike[str], format_: str, what: str) -> Iterator[h5py.File]:
    """Open a file of mecano of this format, as ``open_checked`` does. Raises ResultsError if it is not ``what``."""
    with open_checked(path) as file:
        if file.attrs.get("format") != format_:
            raise ResultsError(f"{path} is not {what}")
        yield file


def format_of(path: str | os.PathLike[str]) -> str:
    """Return the attribute ``format`` of a file of mecano, or "" if it cannot be read."""
    try:
        with open_checked(path) as file:
            found = file.attrs.get("format", "")
            return found if isinstance(found, str) else ""
    except ResultsError:
        return ""


def open_source(path: str | os.PathLike[str]) -> Checked:
    """Return a Checked of an HDF5 file. Raises ResultsError if it is unreadable or not an HDF5 file."""
    try:
        if os.path.exists(path) and (other := other_than_file(path)):
            table = os.path.join(path, "table.h5")
            hint = f"; the table of its study is {table}" if os.path.exists(table) else ""
            raise ResultsError(f"cannot read {path}: it is {other}{hint}")
        source = Checked(path)
    except (OSError, ValueError) as error:
        deck = f"{os.path.splitext(path)[0]}.yaml"
        missing = isinstance(error, FileNotFoundError) and os.path.exists(deck)
        hint = f"; `mecano run {deck} -o {path}` writes it" if missing else ""
        raise ResultsError(f"cannot read {path}: {getattr(error, 'strerror', None) or error}{hint}") from error
    try:
        if source.size < len(SIGNATURE) or source.read(len(SIGNATURE)) != SIGNATURE:
            hint = f"; if it is a deck: mecano run {path}" if str(path).endswith((".yaml", ".yml")) else ""
            raise ResultsError(f"{path} is not a results file of mecano: not an HDF5 file{hint}")
        if source.sums is None:
            refuse_crashing(path)
    except (OSError, ResultsError) as error:
        source.close()
        raise error if isinstance(error, ResultsError) else ResultsError(unreadable(source, error)) from error
    return source


def unreadable(source: Checked, error: BaseException, what: str = "") -> str:
    """Return the message for an ``error`` in reading ``what``, or anything, from the file of a Checked."""
    name = f"'{what}' in {source.path}" if what else source.path
    if source.damaged:
        return (
            f"{name} cannot be read: bytes have changed {source.place(source.damaged)}; "
            f"`mecano verify {source.path}` names the data affected"
        )
    if source.missing:
        return f"{name} cannot be read: the file is cut short by {source.missing} bytes ({error})"
    text = str(error.args[0]) if isinstance(error, KeyError) and error.args else str(error)
    text = f"there is no '{text}'" if isinstance(error, KeyError) and text.isidentifier() else text
    lost = "; the checksums at its end are missing or have changed" if source.sums is None else ""
    return f"{name} cannot be read: {text}{lost}"


def cut_short(paths: Iterable[str | os.PathLike[str]]) -> Iterator[str]:
    """Yield a warning for each truncated file; only its remaining data are shown."""
    for path in paths:
        with suppress(OSError, ValueError):
            source = Checked(path)
            source.close()
            if source.missing:
                yield f"{path} is cut short by {source.missing} bytes: only the remaining data are shown"


@contextmanager
def errors_as_damage(*paths: str | os.PathLike[str]) -> Iterator[None]:
    """Attribute unexpected exceptions in this block to damage of files without checksums.

    If one of the files has no checksums, raises ResultsError instead of any exception other than a MecanoError.
    """
    try:
        yield
    except MecanoError:
        raise
    except Exception as error:
        for path in paths:
            with suppress(OSError):
                source = Checked(path)
                source.close()
                if source.sums is None:
                    raise ResultsError(unreadable(source, error)) from error
        raise

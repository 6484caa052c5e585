"""Atomic creation of files, which appear only when complete; their hidden names; folders."""

import csv
import hashlib
import io
import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

from mecano.errors import ResultsError
from mecano.results.provenance import Source, provenance

if TYPE_CHECKING:
    from pathlib import Path

    import h5py

LONGEST = 200  # bytes of a name used in a hidden one: file systems allow 255

LONGEST_ENDING = 20
MARKED = (".png", ".svg", ".html", ".htm")  # files in which mecano is named as the program that wrote them
MARK, BEGINNING = b"mecano", 4096  # in the first bytes


@contextmanager
def atomic_file(path: "Path") -> "Iterator[Path]":
    """Give the Path of a hidden file that replaces ``path`` at the end of the block; on failure it is removed.

    Raises ResultsError.
    """
    refuse_other_than_file(path)
    ending = path.suffix if len(path.suffix) < LONGEST_ENDING else ""
    hidden = path.with_name(f"{hidden_name(path)}.{os.getpid()}{ending}")
    try:
        yield hidden
        os.replace(hidden, path)
    except OSError as error:
        raise ResultsError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        with suppress(OSError):
            hidden.unlink()


def hidden_name(path: "Path") -> str:
    """Return the prefix of the names of all hidden files that belong to a Path: a dot and its name.

    A very long name is replaced by its SHA-256, as the names of hidden files are longer still.
    """
    name = path.name
    short = name if len(os.fsencode(name)) <= LONGEST else hashlib.sha256(os.fsencode(name)).hexdigest()
    return f".{short}"


def exists(path: str | os.PathLike[str]) -> bool:
    """Return whether a file or folder has that name. Raises ResultsError if this cannot be determined."""
    try:
        os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        return False
    except (OSError, ValueError) as error:  # too long a name, no permission, a null character
        raise ResultsError(f"cannot write {path}: {getattr(error, 'strerror', None) or error}") from error
    return True


def refuse_other_than_file(path: str | os.PathLike[str]) -> None:
    """Raise ResultsError if ``path`` is a folder, a pipe or a device, or not a valid name of a file."""
    if exists(path) and (other := other_than_file(path)):
        raise ResultsError(f"cannot write {path}: it is {other}; give the name of a file")


def refuse_foreign(path: "Path", force: bool, heading: Sequence[str] | None = None) -> None:
    """Raise ResultsError if a file ``path`` exists that is not known as one of mecano's, unless ``force`` is True.

    Known are pictures and pages, by the name of mecano at their beginning, and tables (CSV) with the same ``heading``,
    a list of texts. Films are not.
    """
    refuse_other_than_file(path)
    if force or not exists(path):
        return
    expected = MARK if heading is None else csv_line(heading).encode()
    if expected not in first_bytes(path, BEGINNING if heading is None else len(expected)):
        other = ", and is not known to be written by mecano" if path.suffix in MARKED else ""
        raise ResultsError(f"{path} already exists{other}; --force replaces it")


def first_bytes(path: str | os.PathLike[str], count: int) -> bytes:
    """Return the first bytes of a file that would be replaced. Raises ResultsError."""
    try:
        with open(path, "rb") as file:
            return file.read(count)
    except OSError as error:
        raise ResultsError(f"cannot read {path}, which would be replaced: {error.strerror}") from error


def refuse_present(path: str | os.PathLike[str], force: bool) -> None:
    """Raise ResultsError if a file ``path`` exists, whatever it contains, unless ``force`` is True."""
    refuse_other_than_file(path)
    if exists(path) and not force:
        raise ResultsError(f"{path} already exists; --force replaces it")


def write_csv(path: "Path", rows: Iterable[Sequence[str]], force: bool) -> None:
    """Write rows, the first of them the heading, as comma-separated values.

    Raises ResultsError as ``refuse_foreign``, and if the file cannot be written.
    """
    heading, *rows = rows
    refuse_foreign(path, force, heading)
    with atomic_file(path) as hidden, open(hidden, "w", newline="", encoding="utf-8") as file:
        file.write(csv_line(heading))
        csv.writer(file, lineterminator="\n").writerows(rows)


def write_page(page: "Path", text: str) -> "Path":
    """Write a page, make its folder if needed, and return its Path. Raises ResultsError."""
    make_folder(page.parent)
    with atomic_file(page) as hidden:
        hidden.write_text(text, encoding="utf-8")
    return page


def csv_line(cells: Sequence[str]) -> str:
    """Return a row of comma-separated values with the end of its line."""
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(cells)
    return line.getvalue()


def other_than_file(path: str | os.PathLike[str]) -> str:
    """Return the sort of an existing path that is not a file, such as "a folder", or ""."""
    return "a folder" if os.path.isdir(path) else "" if os.path.isfile(path) else "a pipe or a device"


def make_folder(folder: "Path") -> None:
    """Create a folder and its parents unless it exists. Raises ResultsError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ResultsError(f"cannot make the folder {folder}: {error.strerror}") from error


def put_source(file: "h5py.File", source: Source, format_: str, version: int, **facts: str) -> None:
    """Write the deck, the provenance, the ``facts`` of the run and the format to an HDF5 ``file``."""
    for name, text in source.texts().items():
        file[f"deck/{name}"] = text
    run = file.create_group("run")
    run.attrs.update({"title": source.title, "deck_path": source.deck_path, **provenance(), **facts})
    file.attrs.update({"format": format_, "format_version": version})

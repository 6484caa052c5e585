"""A results file opened for reading: datasets by name, read again while a running writer changes them."""

import json
import os
import time as clocks
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import h5py

from mecano.errors import ResultsError
from mecano.results.opening import UNREADABLE, open_source, unreadable

T = TypeVar("T", dict[str, Any], list[Any])
_ATTEMPTS = 5


class OpenedFile:
    """Datasets, texts and JSON data of a results file; everything that cannot be read raises ResultsError.

    Attributes
    ----------
    path : Path
    h5 : h5py.File
    source : Checked
        Its bytes.
    """

    def __init__(self, path: str | os.PathLike[str]):
        self.path = Path(path)
        self._where = self.path.absolute()  # also after os.chdir
        self._open(self.path)

    def _open(self, path):
        self.source, self.h5 = _open_patiently(path)
        self._closing = weakref.finalize(self, _close, self.source, self.h5)

    def close(self) -> None:
        """Close the file, as also happens when nothing refers to it: h5py alone would keep it open."""
        self._closing()
        self.h5 = None

    @contextmanager
    def reading(self, what: str) -> Iterator[None]:
        """Raise ResultsError for anything that cannot be read within the block."""
        try:
            yield
        except UNREADABLE as error:
            raise ResultsError(unreadable(self.source, error, what)) from error

    def read(self, name: str, selection: Any) -> Any:
        """Return part of a dataset; open the file again if the writer has changed it meanwhile."""
        for attempt in range(_ATTEMPTS):
            try:
                return self.h5[name][selection]
            except UNREADABLE as error:
                if attempt == _ATTEMPTS - 1 or self.source.missing or self.source.damaged:
                    raise ResultsError(unreadable(self.source, error, name)) from error
                clocks.sleep(0.01 * attempt)
                self.close()
                self._open(self._where)

    def rows_present(self, name: str, rows: int) -> int:
        """Return how many of the first ``rows`` of a dataset can be read."""
        with self.reading(name):
            dataset = self.h5[name]
            rows = max(min(rows, len(dataset)), 0)
            return _rows_within(dataset, rows, self.source.size) if self.source.missing else rows

    def text(self, name: str) -> str:
        """Return a text."""
        with self.reading(name):
            text = self.read(name, ())
            if not isinstance(text, bytes):
                raise TypeError("it is not a text")
            return text.decode()

    def json(self, name: str, type_: type[T]) -> T:
        """Return the data of a JSON text, a dict or a list."""
        text = self.text(name)
        with self.reading(name):
            data = json.loads(text)
            if not isinstance(data, type_):
                raise TypeError(f"it is not a {'mapping' if type_ is dict else 'list'}")
            return data


def _close(source, h5):
    h5.close()
    source.close()


def _open_patiently(path):
    """Return (Checked, h5py.File) of a path, with retries, as a writer may be active. Raises ResultsError."""
    for attempt in range(_ATTEMPTS):
        source = open_source(path)
        try:
            return source, h5py.File(source, "r")
        except UNREADABLE as error:
            source.close()
            if attempt == _ATTEMPTS - 1 or source.missing or source.damaged:
                raise ResultsError(unreadable(source, error)) from error
            clocks.sleep(0.01 * (1 + attempt))


def _rows_within(dataset, rows, size):
    """Return how many of the first ``rows`` rows of a chunked dataset lie in the first ``size`` bytes of the file."""
    height = dataset.chunks[0]
    for start in range(0, rows, height):
        if not _chunks_within(dataset, start, size):
            return start
    return rows


def _chunks_within(dataset, row, size):
    starts: list[tuple[int, ...]] = [(row,)]
    if dataset.ndim > 1:
        starts = [(row, column) for column in range(0, dataset.shape[1], dataset.chunks[1])]
    try:
        chunks = [dataset.id.get_chunk_info_by_coord(start) for start in starts]
    except (OSError, RuntimeError, ValueError):
        return False
    return all(c.byte_offset is not None and c.byte_offset + c.size <= size for c in chunks)

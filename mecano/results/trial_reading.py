"""Trial reading of files without checksums by a child process, since a damaged one may crash HDF5 or never end."""

import os
import signal
from contextlib import suppress

import h5py

from mecano.errors import ResultsError
from mecano.results.checked import Checked

PATIENCE = 5.0  # s of processor time in which HDF5 must read the metadata of a file without checksums
SHORT = 2**20  # bytes
_ends: dict[tuple[int, ...], int] = {}
"""Version of a file without checksums -> exit code of trial reading, or minus the signal"""


def refuse_crashing(path: str | os.PathLike[str]) -> None:
    """Raise ResultsError for a file without checksums that crashes HDF5, as found by a child process that reads it."""
    at = os.stat(path)
    version = at.st_dev, at.st_ino, at.st_size, at.st_mtime_ns
    if not hasattr(os, "fork"):
        return
    if version not in _ends:
        child = os.fork()
        if not child:
            _read_all(path)
        _ends[version] = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if _ends[version] < 0:
        how = signal.Signals(-_ends[version])
        raise ResultsError(
            f"{path} is damaged: the checksums at its end are missing, and reading it "
            + ("does not end" if how == signal.SIGPROF else f"ends by {how.name}")
        )


def _read_all(path):
    """Read the metadata and the short datasets of a file, and end this process."""
    try:
        _read_quietly(path)
    finally:
        os._exit(0)


def _read_quietly(path):
    for number in (signal.SIGPROF, signal.SIGINT, signal.SIGTERM, signal.SIGSEGV, signal.SIGABRT):
        signal.signal(number, signal.SIG_DFL)
    quiet = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(quiet, stream)
    signal.setitimer(signal.ITIMER_PROF, PATIENCE)
    with suppress(Exception), h5py.File(Checked(path), "r") as file:
        file.visititems(_read_item)
        _read_item("", file)


def _read_item(_, item):
    with suppress(Exception):
        dict(item.attrs)
    with suppress(Exception):
        if isinstance(item, h5py.Dataset) and item.size * item.dtype.itemsize < SHORT:
            item[()]

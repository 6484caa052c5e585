"""The store: files of machine code on disk, of the user, shared, or installed with the package.

There is one file per function, named by the function and by a digest of everything that its code depends on
(digest.py), in a folder named by a hash of the compiler, the processor and Python. Files are signed (trust.py).
machine_code.py loads them.
"""

import atexit
import hashlib
import os
import sys
import time
from contextlib import contextmanager, suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import llvmlite

from mecano.jit import processor, shipped, trust

try:
    import fcntl
except ImportError:  # not a POSIX system
    fcntl = None

COMPILER = (
    "aggregates", "array_object", "arrays", "compiler", "convention", "entry", "image", "indexing", "kernel", "lanes",
    "library", "memory", "methods", "named_tuple", "null_matrix", "numba_methods", "passes", "symbols",
)  # fmt: skip
"""Modules that generate code."""
DAY = 86400.0  # s
UNUSED = 90 * DAY  # files that have not been used for this long are removed when one is added
FOLDER = "MECANO_CACHE_DIR"  # environment variable: parent of the folders of compiled code
SHARED = "MECANO_SHARED_CACHE"  # environment variable: a folder written by `mecano warmup --share`, read-only here


@cache
def folder():
    """Return the folder of the store, or a temporary one for this process if it cannot be created.

    Raises ResultsError if it belongs to another user or is writable by others.
    """
    base = os.environ.get(FOLDER) or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    found = Path(base).absolute() / f"mecano-{_key()}"
    if found.is_dir():
        trust.refuse_foreign(found)
        with suppress(OSError):
            os.utime(found)
        return found
    try:
        found.parent.mkdir(parents=True, exist_ok=True)
        found.mkdir(exist_ok=True, mode=0o700)
    except OSError:
        import shutil
        import tempfile

        found = Path(tempfile.mkdtemp(prefix="mecano-"))
        atexit.register(shutil.rmtree, found, ignore_errors=True)
        return found
    trust.refuse_foreign(found)
    _remove_old(found.parent.glob("mecano-" + 16 * "[0-9a-f]"))
    return found


@cache
def shared_folder():
    """Return the shared folder for this compiler and processor, or None if there is none.

    Raises ResultsError if untrusted users could have written it.
    """
    base = os.environ.get(SHARED)
    found = Path(base).absolute() / f"mecano-{_key()}" if base else None
    if found is None or not found.is_dir():
        return None
    trust.refuse_untrusted(found)
    return found


@cache
def _trusted_folders():
    """Return the folders of others whose files are trusted."""
    own_package = shipped.folder(_sources())
    if own_package is not None and trust.is_writable_by_others(own_package):
        own_package = None
    return [found for found in (shared_folder(), own_package) if found is not None]


@cache
def _secret():
    return trust.secret()


@cache
def _key():
    """Return a key that identifies compiler, processor and Python."""
    found = find_spec("numba")  # an installation that holds machine code can do without
    numba = Path(found.origin).with_name("_version.py").read_bytes() if found else b""
    versions = [llvmlite.__version__, sys.implementation.cache_tag, getattr(sys, "abiflags", "")]
    depends = " ".join([_sources(), *versions, processor.key()])
    return hashlib.sha256(numba + depends.encode()).hexdigest()[:16]


def _sources():
    """Return the digest of the modules that generate code."""
    here = Path(__file__).parent
    return hashlib.sha256(b"".join((here / f"{name}.py").read_bytes() for name in COMPILER)).hexdigest()


def _remove_old(paths):
    """Remove files and folders that have not been used for long."""
    import shutil

    for path in paths:
        with suppress(OSError):  # another process may be faster
            if time.time() - path.stat().st_mtime > UNUSED:
                shutil.rmtree(path) if path.is_dir() else path.unlink()


def contains(file):
    """Return whether the shared or the own store has a file of this name; its signature may be invalid."""
    return any((place / file).exists() for place in (*_trusted_folders(), folder()))


@contextmanager
def locked(file):
    """Keep other processes from compiling the same file, where the file system can lock it."""
    path = folder() / f"{file}.lock"
    try:
        descriptor = os.open(path, os.O_CREAT | os.O_RDWR, 0o600)
    except OSError:
        yield
        return
    try:
        if fcntl:
            with suppress(OSError):
                fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        with suppress(OSError):
            path.unlink()
        os.close(descriptor)


def size():
    """Return the size of the store on disk in bytes."""
    return _size(folder())


def _size(of):
    """Return the size of the files in a folder in bytes; other processes may remove some meanwhile."""
    total = 0
    for path in of.iterdir():
        with suppress(FileNotFoundError):
            total += path.stat().st_size if path.is_file() else 0
    return total


def write_atomically(path, data):
    """Write a file atomically, even with concurrent writers; leaves no file if the disk is full."""
    own = path.with_name(f"{path.name}.{os.urandom(8).hex()}")
    try:
        own.write_bytes(data)
        own.replace(path)
    except OSError:
        with suppress(OSError):
            own.unlink()


def read(file):
    """Return the contents of a file of the shared or own store, or None if it is missing or has no valid signature."""
    for trusted in _trusted_folders():
        found = _read(trusted / file, b"", trust.is_trusted)
        if found is not None:
            return found
    return _read(folder() / file, _secret(), lambda _: True)


def _read(path, key, is_trusted):
    try:
        with open(path, "rb") as file:
            signature, data = file.read().split(b"\n", 1)
            used = os.fstat(file.fileno()).st_mtime
            if not (trust.is_signed(key, path.name, data, signature.decode("ascii")) and is_trusted(file)):
                return None
    except (OSError, ValueError):
        return None
    if time.time() - used > DAY:
        with suppress(OSError):
            os.utime(path)
    return data


def write(file, data):
    """Write ``data`` to the own store, signed."""
    _remove_unused()
    _write(folder() / file, _secret(), data)


def keep_newest(pattern, most):
    """Remove all files of the own store that match the pattern, except the ``most`` most recently used."""
    with suppress(OSError):
        kept = sorted(folder().glob(pattern), key=lambda path: path.stat().st_mtime)
        for path in kept[:-most]:
            path.unlink(missing_ok=True)


@cache
def _remove_unused():
    """Remove files of the store that have not been used for long; once per process."""
    _remove_old(list(folder().glob("*")))


def _write(path, key, data):
    write_atomically(path, trust.sign(key, path.name, data).encode() + b"\n" + data)


def share(base):
    """Copy the objects of the own store to a shared one below the folder ``base``; return its folder and size [bytes].

    Raises OSError if it cannot be written.
    """
    target = Path(base).absolute() / f"mecano-{_key()}"
    return target, _copy_to(target)


def ship(level):
    """Copy the objects of the own store, compiled for a ``level`` of processors, into the package.

    Returns the folder and its size [bytes]. Raises ValueError if this process compiles for other processors, OSError if
    the package cannot be written.
    """
    if processor.target() != (level, ""):
        raise ValueError(
            f"this process compiles for {processor.target()[0]}: set NUMBA_CPU_NAME={level} NUMBA_CPU_FEATURES="
        )
    target = shipped.place(_sources(), level)
    return target, _copy_to(target)


def _copy_to(target):
    """Copy the objects of the own store to a folder that others read; return its size [bytes]."""
    target.mkdir(parents=True, exist_ok=True, mode=0o755)
    trust.refuse_untrusted(target)
    for path in sorted(folder().glob("*.o")):
        data = _read(path, _secret(), lambda _: True)
        if data is not None:
            _write(target / path.name, b"", data)
            (target / path.name).chmod(0o644)
    return _size(target)

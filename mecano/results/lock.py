"""Lock of a results file: a record of the writing process next to the file while it is written.

``.NAME.lock`` is created by linking a complete file to that name, which fails if the name exists, also on NFS. A record
is stale if its process has ended (killed, or the machine rebooted), and the next run replaces it; this can be decided
on the same machine only. If two processes find a stale record at the same time, one removes it under a system lock, and
the other finds the new record of the first.
"""

import errno
import json
import os
import platform
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path

from mecano.errors import ResultsError
from mecano.results.provenance import is_running, start_ticks
from mecano.results.whole_file import hidden_name, refuse_other_than_file

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]  # its absence is asked for where a file is locked

READ_ONLY = (errno.EACCES, errno.EROFS, errno.EPERM)
HERE, ELSEWHERE, GONE = "here", "elsewhere", "gone"
_ATTEMPTS = 20
_JOB = ("SLURM_JOB_ID", "SLURM_RESTART_COUNT")


@contextmanager
def locked(path: str | os.PathLike[str]) -> Iterator[None]:
    """Lock a results file within a block: no other process, on any machine, writes or replaces it.

    Raises
    ------
    ResultsError
        Another process is writing it, or the record cannot be written.
    """
    path = Path(path)
    refuse_other_than_file(path)
    record = lock_of(path)
    absolute = record.absolute()  # also after os.chdir
    content = json.dumps(_own_record()).encode()
    try:
        _take(path, record, content)
    except OSError as error:
        if error.errno not in READ_ONLY:  # on a read-only file system no process can write the file either
            raise ResultsError(f"cannot write {path}: {error.strerror or error}") from error
    try:
        yield
    finally:
        with suppress(OSError):
            if absolute.read_bytes() == content:  # otherwise it was removed by hand, and another run has made its own
                absolute.unlink()


def lock_of(path: str | os.PathLike[str]) -> Path:
    """Return the Path of the record of a results file."""
    path = Path(path)
    return path.with_name(f"{hidden_name(path)}.lock")


def _take(path, record, content):
    """Create the record. Raises ResultsError if a living process has one, OSError."""
    for _ in range(_ATTEMPTS):
        if _create(record, content):
            return
        try:
            with open(record, "rb") as there:
                _refuse_living(path, record, there.read())
                _remove_stale(record, there)
        except FileNotFoundError:  # its process has just ended
            continue
    raise ResultsError(f"{path}: other processes keep starting to write it")


def _create(record, content):
    """Create the record completely or not at all, and return whether it was created. Raises OSError."""
    own = record.with_name(f"{record.name}.{platform.node()[:20]}.{os.urandom(4).hex()}")
    try:
        own.write_bytes(content)
        try:
            os.link(own, record)
        except FileExistsError:
            return False
        except OSError:
            if os.stat(own).st_nlink == 2:  # created, although the reply of the server was lost
                return True
            return _create_without_links(record, content)
        return True
    finally:
        with suppress(OSError):
            own.unlink()


def _create_without_links(record, content):
    """Do as ``_create`` on a file system without hard links."""
    try:
        descriptor = os.open(record, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    except FileExistsError:
        return False
    try:
        os.write(descriptor, content)
    finally:
        os.close(descriptor)
    return True


def _remove_stale(record, there):
    """Remove the record open as ``there``, unless another process has replaced it."""
    if fcntl:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(there, fcntl.LOCK_EX)
    if os.path.samestat(os.fstat(there.fileno()), os.stat(record)):
        record.unlink()


def _refuse_living(path, record, content):
    """Raise ResultsError unless the process of a record is known to have ended."""
    advice = f"if no process is writing it, remove {record} and try again"
    try:
        reported = json.loads(content)
        state = _state(reported)
        who = f"process {reported['process']} on {reported['host']} (since {reported['since']})"
    except (ValueError, KeyError, TypeError, AttributeError):
        raise ResultsError(f"another process may be writing {path}: {record} does not name it; {advice}") from None
    if state == HERE:
        raise ResultsError(f"{path} is being written by {who}: wait for it, end it, or give another name with -o")
    if state == ELSEWHERE:
        raise ResultsError(
            f"{path} is being written by {who}, unless it has ended, which cannot be determined on {platform.node()}: "
            f"{advice}"
        )


def _state(reported):
    """Decide whether the process of a record lives HERE, may live ELSEWHERE, or is GONE."""
    own = _own_record()
    if _was_requeued(reported["job"], own["job"]):
        return GONE
    if any(reported[key] != own[key] for key in ("host", "machine")) or os.name != "posix":
        return ELSEWHERE
    if reported["boot"] != own["boot"]:
        return GONE
    if reported["space"] != own["space"]:
        return ELSEWHERE  # in another container, which has process numbers of its own
    process = int(reported["process"])
    return HERE if is_running(process) and start_ticks(process) == reported["ticks"] else GONE


def _was_requeued(before, now):
    """Return whether a job of Slurm was requeued after it made a record, so that the recorded process has ended."""
    return None not in (*before, *now) and before[0] == now[0] and int(now[1]) > int(before[1])


def _own_record():
    """Return the record of this process, by which others decide whether it lives."""
    process = os.getpid()
    job, restarts = (os.environ.get(name) for name in _JOB)
    return {
        "process": process,
        "host": platform.node(),
        "since": datetime.now(UTC).isoformat(timespec="seconds"),
        "ticks": start_ticks(process),
        "machine": _line("/etc/machine-id"),
        "boot": _line("/proc/sys/kernel/random/boot_id"),
        "space": _target("/proc/self/ns/pid"),
        "job": [job, restarts or ("0" if job else None)],
    }


def _line(path):
    with suppress(OSError), open(path, encoding="utf-8") as file:
        return file.read().strip()
    return ""


def _target(path):
    with suppress(OSError):
        return os.readlink(path)
    return ""

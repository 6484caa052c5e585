"""Protection against machine code from other users.

Loading an object runs it. The store of a user therefore contains only objects that the user has signed: each carries a
keyed hash (BLAKE2b, RFC 7693) of its name and contents, and the key is a secret file that only the user can read. A
store shared by many users cannot be signed in this way; it is trusted if nobody could have written to it except the
user, root, or the owner of mecano's own sources, whose code the process runs anyway.
"""

import hashlib
import hmac
import os
import stat
from contextlib import suppress
from pathlib import Path

from mecano.errors import ResultsError

LENGTH = 32  # bytes of the secret and of a signature
WRITABLE_BY_OTHERS = stat.S_IWGRP | stat.S_IWOTH
READABLE_BY_OTHERS = stat.S_IRWXG | stat.S_IRWXO


def sign(key, name, data):
    """Return the signature (64 hexadecimal digits) of ``data`` and its ``name``; unkeyed for the key b""."""
    return hashlib.blake2b(name.encode() + b"\0" + data, key=key, digest_size=LENGTH).hexdigest()


def is_signed(key, name, data, signature):
    """Return whether the signature is valid."""
    return hmac.compare_digest(sign(key, name, data), signature)


def refuse_foreign(folder):
    """Raise ResultsError if a folder of machine code is not the user's own or is writable by others."""
    problem = _problem(folder, {os.getuid()}) if hasattr(os, "getuid") else ""
    if problem:
        raise ResultsError(
            f"the folder of compiled code {folder} {problem}: it is not used, since loading code runs it; remove the "
            "folder, or set MECANO_CACHE_DIR to another one"
        )


def refuse_untrusted(folder):
    """Raise ResultsError if an untrusted user could have written to a shared folder of machine code."""
    problem = _problem(folder, _installers()) if hasattr(os, "getuid") else ""
    if problem:
        raise ResultsError(
            f"the shared folder of compiled code {folder} {problem}: it is not used, since loading code runs it; "
            "root or the user who installed mecano must own it, and nobody else may write to it"
        )


def is_writable_by_others(folder):
    """Return whether an untrusted user could have written to a folder of an installed package."""
    return hasattr(os, "getuid") and bool(_problem(folder, _installers()))


def is_trusted(file):
    """Return whether only trusted users could have written an open file of a shared store."""
    return not hasattr(os, "getuid") or not _problem_of(os.fstat(file.fileno()), _installers())


def _installers():
    return {os.getuid(), 0, Path(__file__).stat().st_uid}


def _problem(path, owners):
    return _problem_of(os.lstat(path), owners)


def _problem_of(status, owners):
    if stat.S_ISLNK(status.st_mode):
        return "is a symbolic link"
    if status.st_uid not in owners:
        return f"belongs to another user (uid {status.st_uid})"
    return "can be written by other users" if status.st_mode & WRITABLE_BY_OTHERS else ""


def secret():
    """Return the user's secret (32 bytes), created at first use; valid for this process only if it cannot be saved."""
    path = _secret_path()
    with suppress(OSError):
        return _read(path) or _create(path)
    return os.urandom(LENGTH)


def _secret_path():
    base = os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config"
    return Path(base).absolute() / "mecano" / "store.key"


def _read(path):
    """Return the secret in a file, or None if it is missing or if others may know it or have written it."""
    with suppress(FileNotFoundError), open(path, "rb") as file:
        status = os.fstat(file.fileno())
        own = not hasattr(os, "getuid") or (status.st_uid == os.getuid() and not status.st_mode & READABLE_BY_OTHERS)
        found = file.read()
        return found if own and len(found) == LENGTH else None
    return None


def _create(path):
    """Create a secret; if two processes do so at the same time, both get the one that was stored."""
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    if path.exists() and _read(path) is None:  # not usable; another process may have just created a good one
        path.unlink()
    own = path.with_name(f"{path.name}.{os.urandom(8).hex()}")
    with open(os.open(own, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        file.write(os.urandom(LENGTH))
    try:
        os.link(own, path)
    except FileExistsError:
        own.unlink()
    except OSError:  # a file system without links
        own.replace(path)
    else:
        own.unlink()
    return _read(path)

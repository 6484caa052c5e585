"""Files that commands write for users, and replace only when asked to."""

import os

from mecano.errors import ResultsError, UsageError


def write_text(path: str | os.PathLike[str], text: str, replace: bool = False) -> None:
    """Write a text file; raises as ``write_bytes``."""
    write_bytes(path, text.encode(), replace)


def write_bytes(path: str | os.PathLike[str], data: bytes, replace: bool = False) -> None:
    """Write a file; raises UsageError if it exists and ``replace`` is False, ResultsError if it cannot be written."""
    try:
        with open(os.fspath(path), "wb" if replace else "xb") as stream:
            stream.write(data)
    except FileExistsError:
        raise UsageError(f"{os.fspath(path)} already exists and is not replaced") from None
    except (OSError, ValueError) as error:
        raise ResultsError(f"{os.fspath(path)} cannot be written: {getattr(error, 'strerror', error)}") from None

"""Files that are written at once, and appear only when they are complete; their hidden names; folders for them."""

import hashlib
import os
from contextlib import contextmanager, suppress

from mecano.errors import ResultsError
from mecano.results.provenance import provenance

LONGEST = 200  # bytes of a name that is part of a hidden one: systems take 255

LONGEST_ENDING = 20


@contextmanager
def appearing(path):
    """Give the Path of a hidden file beside ``path`` that takes its place in the end; nothing is left if that fails.

    Raises ResultsError.
    """
    refuse_folder(path)
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


def hidden_name(path):
    """How the names begin of all hidden files that belong to the file of a Path: with a dot and its name.

    A very long name is shortened to its SHA-256, as those of the hidden files are longer still.
    """
    name = path.name
    short = name if len(os.fsencode(name)) <= LONGEST else hashlib.sha256(os.fsencode(name)).hexdigest()
    return f".{short}"


def exists(path):
    """True where a file or folder has that name. Raises ResultsError where the system cannot tell."""
    try:
        os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        return False
    except (OSError, ValueError) as error:  # too long a name, no right to look, a zero in it
        raise ResultsError(f"cannot write {path}: {getattr(error, 'strerror', None) or error}") from error
    return True


def refuse_folder(path):
    """Raise ResultsError when ``path`` names a folder, or nothing that a file could be."""
    if exists(path) and os.path.isdir(path):
        raise ResultsError(f"cannot write {path}: it is a folder; give the name of a file")


def make_folder(folder):
    """Make a folder, and those above it, where there is none. Raises ResultsError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ResultsError(f"cannot make the folder {folder}: {error.strerror}") from error


def put_source(file, source, format_, version, **facts):
    """Write the deck, where the numbers come from, the ``facts`` of the run and the format to an HDF5 ``file``."""
    for name, text in source.texts().items():
        file[f"deck/{name}"] = text
    run = file.create_group("run")
    run.attrs.update({"title": source.title, "deck_path": source.deck_path, **provenance(), **facts})
    file.attrs.update({"format": format_, "format_version": version})

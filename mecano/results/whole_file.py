"""Files that are written at once, and appear only when they are complete; and the folders for them."""

import os
from contextlib import contextmanager

from mecano.errors import ResultsError
from mecano.results.provenance import provenance


@contextmanager
def appearing(path):
    """Give the Path of a hidden file beside ``path`` that takes its place in the end; nothing is left if that fails.

    Raises ResultsError.
    """
    hidden = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        yield hidden
        os.replace(hidden, path)
    except OSError as error:
        raise ResultsError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        hidden.unlink(missing_ok=True)


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

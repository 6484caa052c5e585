"""Decks to begin with, the files of mecano/deck/starters, and files that are written for a user."""

import json
import os
from importlib.resources import files

from mecano.deck.wording import quoted, suggestion
from mecano.errors import ResultsError, UsageError

FOLDER = files("mecano.deck") / "starters"


def starters():
    """{name: text} of all starters."""
    names = sorted(path.name for path in FOLDER.iterdir() if path.name.endswith(".yaml"))
    return {name.removesuffix(".yaml"): (FOLDER / name).read_text(encoding="utf-8") for name in names}


def starter(name):
    """The text of a starter; raises UsageError for an unknown name."""
    known = starters()
    if name not in known:
        raise UsageError(f"there is no deck {quoted(name)} to begin with; {suggestion(name, known)}")
    return known[name]


def list_of_starters():
    """Names of the starters, and what each is: the first line of its text."""
    known = starters()
    width = max(map(len, known))
    lines = [f"  {name:<{width}}  {text.splitlines()[0].lstrip('# ')}" for name, text in known.items()]
    return "\n".join(["decks to begin with:", *lines, "", "mecano new NAME [deck.yaml] writes one of them."])


def schema_text(schema):
    """A JSON Schema as text."""
    return json.dumps(schema, indent=1) + "\n"


def write_text(path, text, replace=False):
    """Write a file; raises UsageError when it is there and not to be replaced, ResultsError when it cannot be."""
    try:
        with open(path, "w" if replace else "x", encoding="utf-8") as stream:
            stream.write(text)
    except FileExistsError:
        raise UsageError(f"{os.fspath(path)} is there already; it is not replaced") from None
    except (OSError, ValueError) as error:
        raise ResultsError(f"{os.fspath(path)} cannot be written: {getattr(error, 'strerror', error)}") from None

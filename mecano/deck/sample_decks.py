"""Sample decks: starters of `mecano new` (mecano/deck/starters) and examples of `mecano example` (inputs/)."""

import os
import re
from importlib.resources import files
from itertools import takewhile
from pathlib import Path

from mecano.deck.new_file import write_bytes, write_text
from mecano.deck.wording import quoted, suggestion
from mecano.errors import UsageError

STARTERS = files("mecano.deck") / "starters"
EXAMPLES = files("mecano") / "inputs"  # in a clone a link to the folder inputs/
TESTED_BY = re.compile(r",?\s*\(?tests/\w+\.py\)?")  # in comments
TITLE = re.compile("^title: *(.+)$", re.MULTILINE)


def starters() -> dict[str, str]:
    """Return {name: text} of all starters."""
    return _decks(STARTERS)


def examples() -> dict[str, str]:
    """Return {name: text} of all example decks."""
    return _decks(EXAMPLES)


def _decks(folder):
    paths = sorted((path for path in folder.iterdir() if path.name.endswith(".yaml")), key=lambda path: path.name)
    return {path.name.removesuffix(".yaml"): path.read_text(encoding="utf-8") for path in paths}


def starter(name: str) -> str:
    """Return the text of a starter; raises UsageError for an unknown name."""
    known = starters()
    if name not in known:
        hint = f"mecano example {name} writes the example" if name in examples() else _similar(name, known, "new")
        raise UsageError(f"there is no deck {quoted(name)} to begin with; {hint}")
    return known[name]


def write_example(name: str, path: str | os.PathLike[str]) -> list[str]:
    """Write an example deck to ``path``, and the files that it reads next to it; return the names of these files.

    Raises UsageError for an unknown name or if a file would be replaced; ResultsError if one cannot be written.
    """
    known = examples()
    if name not in known:
        raise UsageError(f"there is no example {quoted(name)}; {_similar(name, known, 'example')}")
    files = (file for file in EXAMPLES.iterdir() if file.is_file() and not file.name.endswith(".yaml"))
    needed = [file for file in files if file.name in known[name]]
    for file in needed:
        beside = Path(path).with_name(file.name)
        if not (beside.is_file() and beside.read_bytes() == file.read_bytes()):
            write_bytes(beside, file.read_bytes())
    write_text(path, known[name])
    return [file.name for file in needed]


def example_text(name: str) -> str:
    """Return a text that says what the example deck ``name`` is, and how to see it; "" for an unknown name."""
    name = name.removesuffix(".yaml")
    text = examples().get(name)
    if text is None:
        return ""
    lines = takewhile(lambda line: line.startswith("#"), text.splitlines())
    head = TESTED_BY.sub("", "\n".join(line.lstrip("# ") for line in lines))
    return "\n".join([
        f"{name} (example deck): {_title(text)}", "", head, "",
        f"mecano example {name}    # writes {name}.yaml", f"mecano run {name}.yaml", "",
    ])  # fmt: skip


def _similar(name, known, command):
    return suggestion(name, known) or f"`mecano {command}` lists them"


def list_of_starters() -> str:
    """Return the text that lists the starters, each with the first line of its deck."""
    summaries = {name: text.splitlines()[0].lstrip("# ") for name, text in starters().items()}
    return _list("decks to start from:", summaries, "mecano new NAME [deck.yaml] writes one of them.")


def list_of_examples() -> str:
    """Return the text that lists the examples, each with its title."""
    titles = {name: _title(text) for name, text in examples().items()}
    return _list("examples with known answers:", titles, "mecano example NAME [deck.yaml] writes one of them.")


def _title(text):
    found = TITLE.search(text)
    return found[1] if found else ""


def _list(heading, summaries, usage):
    width = max(map(len, summaries))
    lines = [f"  {name:<{width}}  {text}" for name, text in summaries.items()]
    return "\n".join([heading, *lines, "", usage])

"""Decks made of plain Python objects, checked like deck files."""

import os
from collections.abc import Iterator, Mapping, MutableMapping
from contextlib import contextmanager
from copy import deepcopy
from datetime import date, datetime
from pathlib import Path, PurePath
from typing import Any, Self

import numpy as np
import yaml

from mecano.deck.check import VERSION
from mecano.deck.compose import compose
from mecano.deck.deck import Deck as CheckedDeck
from mecano.deck.format import deck_error_text
from mecano.deck.new_file import write_text
from mecano.deck.read import deck_of_bytes, read_deck
from mecano.deck.scalar import resolved
from mecano.deck.source import Unreadable, read_source
from mecano.errors import DeckError, Mark, Problem, UsageError

WIDTH = 110


class Deck(MutableMapping[str, Any]):
    """A deck of dicts, lists, numbers and strings; quantities with units and expressions are strings.

    A deck is checked when it is used. Errors refer to lines and columns of its ``text``.

    Parameters
    ----------
    sections : mapping
        Sections by name; the version ``mecano: 1`` may be omitted.
    folder : str or Path
        Folder to which the names of files in the deck are relative.
    name : str
        Stem of the default name of results files.

    Raises
    ------
    TypeError
        If ``sections`` is not a mapping.

    Examples
    --------
    >>> deck = mecano.Deck.read("pendulum.yaml")
    >>> deck["elements"]["bar"]["mass"] = "2 kg"
    >>> deck["time"]["end"] = 0.5
    >>> mecano.check(deck).mass
    2.0
    """

    def __init__(self, sections: Mapping[str, Any], *, folder: "AnyPath" = "", name: str = "deck"):
        if not isinstance(sections, Mapping):
            given = type(sections).__name__
            raise TypeError(f"a Deck is made of a mapping of sections, not of {given}; Deck.read reads a file")
        self.folder, self.name = os.fspath(folder), name
        self._sections = {"mecano": VERSION, **dict(sections)}

    @classmethod
    def read(cls, path: "AnyPath") -> Self:
        """Read a deck from a file; comments are lost. Raises DeckError if it is not valid YAML."""
        problems: list[Problem] = []
        path = Path(path)
        with explained():
            try:
                root = compose(read_source(path)[0], problems)
            except Unreadable as error:
                raise DeckError([Problem(f"the deck cannot be read: {error}", Mark(str(path), 1, 1))]) from None
            if problems or root is None or type(root.value) is not dict:
                deck_of_bytes(path.read_bytes(), str(path))  # raises the error of the command line
        return cls(_plain(root), folder=path.parent, name=path.stem)

    def __getitem__(self, section: str) -> Any:
        return self._sections[section]

    def __setitem__(self, section: str, value: Any) -> None:
        self._sections[section] = value

    def __delitem__(self, section: str) -> None:
        del self._sections[section]

    def __iter__(self) -> Iterator[str]:
        return iter(self._sections)

    def __len__(self) -> int:
        return len(self._sections)

    def __repr__(self):
        return f"Deck {self.name!r}: {', '.join(self._sections)}"

    def copy(self) -> "Deck":
        """Return an independent copy of the deck."""
        return Deck(deepcopy(self._sections), folder=self.folder, name=self.name)

    @property
    def text(self) -> str:
        """The deck as YAML. Raises TypeError for objects that a deck cannot hold."""
        return _yaml(self._sections, flow=None, width=WIDTH)

    def save(self, path: "AnyPath", *, replace: bool = False) -> None:
        """Write the text to a file. Raises UsageError if the file exists, unless ``replace``, and ResultsError."""
        try:
            write_text(path, self.text, replace)
        except UsageError as error:
            raise UsageError(f"{error}; replace=True replaces it") from None


AnyPath = str | os.PathLike[str]
AnyDeck = AnyPath | Deck | Mapping[str, Any]
Values = Mapping[str, Any]  # {"path.to.key": value}


def checked_deck(deck: AnyDeck, overrides: Values | None) -> CheckedDeck:
    """Return the checked deck of a path, Deck or dict; ``overrides`` {"path.to.key": value}. Raises DeckError."""
    texts = _override_texts(overrides)
    if isinstance(deck, Mapping) and not isinstance(deck, Deck):
        deck = Deck(deck)
    with explained():
        if isinstance(deck, Deck):
            file = os.path.join("" if deck.folder == os.curdir else deck.folder, f"<{deck.name}>")
            return deck_of_bytes(deck.text.encode(), file, overrides=texts)
        if not isinstance(deck, (str, os.PathLike)):
            raise TypeError(f"a deck is a path, a mecano.Deck or a dict, not {type(deck).__name__}")
        return read_deck(os.fspath(deck), texts)


def _override_texts(overrides):
    """Return overrides as texts for `mecano run --set`."""
    if not isinstance(overrides, Mapping | None):
        raise TypeError(f"'set' takes a dict such as {{'time.end': 2}}, not {overrides!r}")
    return tuple(f"{path}={_in_one_line(value)}" for path, value in (overrides or {}).items())


def _in_one_line(value):
    text = _yaml(value, flow=True, width=np.inf)
    return text.removesuffix("...\n").strip()  # the end mark of a document after a scalar


def _yaml(value, flow, width):
    """Return a value as YAML. Raises TypeError for objects that a deck cannot hold."""
    try:
        return yaml.dump(
            value, Dumper=_Dumper, sort_keys=False, default_flow_style=flow, width=width, allow_unicode=True
        )
    except yaml.representer.RepresenterError as error:
        found = error.args[-1]
        place = f"but '{where}' is of the type" if (where := _path_to(found, value)) else "not"
        raise TypeError(f"a deck holds dicts, lists, numbers and strings, {place} {type(found).__name__}") from None
    except RecursionError:
        raise TypeError("a deck cannot hold itself") from None


def _path_to(wanted, within):
    """Return the path of an object within dicts and lists, keys joined by dots; "" if it is not there."""
    if isinstance(within, (list, tuple)):
        within = dict(enumerate(within))
    children = within.items() if isinstance(within, Mapping) else ()
    for key, child in children:
        if child is wanted:
            return str(key)
        if inner := _path_to(wanted, child):
            return f"{key}.{inner}"
    return ""


def name_of(deck: AnyDeck) -> str:
    """Return the stem of the names of results files of a path, Deck or dict."""
    if isinstance(deck, Mapping):
        return deck.name if isinstance(deck, Deck) else "deck"
    return Path(deck).stem


@contextmanager
def explained() -> Iterator[None]:
    """Format a DeckError as the command line does: lines of the deck, carets, suggestions."""
    try:
        yield
    except DeckError as error:
        error.args = ("\n" + deck_error_text(error),)
        raise


def _plain(node):
    if type(node.value) is dict:
        return {key: _plain(child) for key, (_, child) in node.value.items()}
    if type(node.value) is list:
        return [_plain(child) for child in node.value]
    return node.value


class _Dumper(yaml.SafeDumper):
    """Write YAML that ``compose`` reads back to equal values; without aliases."""

    def ignore_aliases(self, data):
        return True


def _text(dumper, value):
    style = None if resolved(value) == value else '"'
    return dumper.represent_scalar("tag:yaml.org,2002:str", value, style=style)


_Dumper.add_representer(str, _text)
for _kind in (set, bytes, date, datetime):  # decks have none of them; a date would be read as a difference
    _Dumper.add_representer(_kind, _Dumper.represent_undefined)
_Dumper.add_representer(np.ndarray, lambda dumper, value: dumper.represent_data(value.tolist()))
_Dumper.add_multi_representer(np.generic, lambda dumper, value: dumper.represent_data(value.item()))
_Dumper.add_multi_representer(PurePath, lambda dumper, value: dumper.represent_data(os.fspath(value)))

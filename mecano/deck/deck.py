"""A deck that has been read and checked."""

import math
from dataclasses import field
from typing import Any

import numpy as np

from mecano.deck.compose import Node
from mecano.errors import Mark, Problem
from mecano.immutable import immutable
from mecano.schema import Values


@immutable
class Deck:
    """Values of a checked deck.

    ``values`` is a tree of dicts and lists in SI units with all sections and all defaults filled in. An element is
    {"type": name of its kind, and all fields of the kind}. Names of nodes stay names; names of laws, grounds and tire
    laws are replaced by the objects of their sections. A law is a tuple of (term, {field: value}); tables from CSV
    files are arrays of points (n, 2).
    """

    file: str  # as given by the user
    text: str
    sha256: str
    values: Values
    overrides: tuple[str, ...] = ()  # "path=value"
    files: dict[str, str] = field(default_factory=dict)  # name of each table read -> SHA-256
    warnings: tuple[Problem, ...] = ()  # legal but suspicious input
    keys: dict[str, dict[str, Node]] = field(default_factory=dict, repr=False)
    """section -> {name: node of the tree that holds the name}"""
    formulas: dict[str, Mark] = field(default_factory=dict, repr=False)
    """text of a formula -> Mark of its first place"""
    units_in_formulas: dict[str, dict[int, str]] = field(default_factory=dict, repr=False)
    """text of a formula -> {i: SI unit} of its operands that were parameters with units"""
    motions: tuple[tuple[Any, str | int, str], ...] = field(default=(), repr=False)
    """(mapping in ``values``, key, formula as written, with names of signals) of prescribed motions"""

    def mark(self, section: str, name: str) -> Mark | None:
        """Return the mark of a name in the deck, or None if it is not in the deck."""
        node = self.keys.get(section, {}).get(name)
        return node.mark if node else None

    def resolved(self) -> dict[str, Any]:
        """Return the checked values as a self-contained deck, without defaults, overrides, parameters or files.

        The deck consists of plain dicts, lists, texts and numbers, so that JSON (a subset of YAML) can represent it;
        reading it as a deck gives the same values. Absent values (None, or an infinite bound) are omitted.
        """
        names: dict[int, str] = {}  # by the id of the entry
        for section in ("laws", "grounds", "tire_laws", "sections", "elements", "joints"):
            names |= {id(value): name for name, value in self.values[section].items()}
        return {key: _plain_section(value, names) for key, value in self.values.items() if value is not None}


def _plain_section(value, names):
    """Return a section in the grammar of decks, with its own entries written in full."""
    if not isinstance(value, dict):
        return _plain(value, names)
    return {name: _written(item, names) for name, item in value.items() if not _absent(item)}


def _plain(value, names):
    """Return a checked value in the grammar of decks, with references as names."""
    return names[id(value)] if id(value) in names else _written(value, names)


def _written(value, names):
    if isinstance(value, tuple):
        terms = [{term: _written(values, names)} for term, values in value]
        once = {key: term for mapping in terms for key, term in mapping.items()}
        return once if len(once) == len(terms) else terms
    if isinstance(value, list):
        return [_plain(item, names) for item in value]
    if isinstance(value, dict):
        return {key: _plain(item, names) for key, item in value.items() if not _absent(item)}
    return value.tolist() if isinstance(value, np.ndarray) else value


def _absent(value):
    return value is None or (isinstance(value, float) and math.isinf(value))

"""A study file -> a checked Study: deck, values of the cases, and outputs."""

import json
import os
from dataclasses import dataclass, field
from typing import Any

from mecano.analyses.prepare import prepare
from mecano.deck.compose import Node, compose
from mecano.deck.containers import filled
from mecano.deck.deck import Deck
from mecano.deck.read import read_deck
from mecano.deck.scope import Scope
from mecano.deck.source import Unreadable, read_source
from mecano.deck.wording import similar_files
from mecano.errors import DeckError, Mark, Problem
from mecano.schema import TEXT, Field
from mecano.study.error_location import in_study
from mecano.study.grammar import FIELDS, NAME, STUDY_CHECKS, VERSION, Entries, plain_value, shown_value
from mecano.study.outputs import Output, checked_outputs
from mecano.study.variation import rows_of

TRIED = 5  # cases, spread over the study, of which at least one must have a valid deck
NOT_FINITE = {"inf": ".inf", "-inf": "-.inf", "nan": ".nan"}  # as written in decks


@dataclass(frozen=True)
class Case:
    """One run of a study: its number, from 1, {path: Entry} of the varied values, and its name, if given."""

    number: int
    entries: Entries = field(repr=False, compare=False)
    name: str = ""

    @property
    def values(self) -> dict[str, Any]:
        """{path: value} of the varied values as plain JSON data."""
        return _plain(self.entries)

    @property
    def shown(self) -> dict[str, float | str]:
        """Values as shown in tables: numbers, in SI units, and texts."""
        return {path: shown_value(value) for path, value in self.values.items()}


@dataclass(frozen=True)
class Study:
    """A checked study: ``common`` {path: Entry} is set in all cases, ``digest`` is the SHA-256 of the deck's file."""

    file: str
    text: str
    title: str
    deck: str
    digest: str
    common: Entries
    cases: tuple[Case, ...]
    outputs: tuple[Output, ...]
    tree: Node = field(repr=False, compare=False)

    @property
    def paths(self) -> tuple[str, ...]:
        """Paths of the varied values."""
        return tuple(dict.fromkeys(path for case in self.cases for path in case.entries))

    def given(self, path: str) -> list[str]:
        """Return the values of a path in the cases, as written; for a range its lower end."""
        return [case.entries[path].node.raw for case in self.cases if path in case.entries]

    def entries(self, case: Case) -> Entries:
        """Return {path: Entry} of all values set in a case."""
        return {**self.common, **case.entries}

    def overrides(self, case: Case) -> tuple[str, ...]:
        """Return the texts of `mecano run --set` for a case."""
        return tuple(f"{path}={_as_yaml(value)}" for path, value in _plain(self.entries(case)).items())


def read_study(path: str | os.PathLike[str]) -> Study:
    """Return the Study of a file; raises DeckError with all problems of the first step that finds any."""
    source, _ = _source(path, Mark(str(path), 1, 1), "study")
    problems: list[Problem] = []
    root = compose(source, problems) or Node(None, source)
    scope = Scope(STUDY_CHECKS, {}, {}, "", problems)
    values = _values(root, scope)
    rows = rows_of(values, root, lambda name: _table_source(path, name, root, scope), scope)
    _stop_at(problems)
    deck = os.path.join(os.path.dirname(path), values["deck"])
    _, digest = _source(deck, root.value["deck"][1].mark, "deck")
    cases = tuple(_case(i + 1, row) for i, row in enumerate(rows))
    outputs = tuple(Output(name, **given) for name, given in values["outputs"].items())
    return Study(str(path), source.text, values["title"], deck, digest, values["set"], cases, outputs, root)


def try_deck(study: Study) -> Deck:
    """Check the deck of a study with the values of some cases, and the outputs; return the first valid Deck.

    Raises DeckError if none of these decks is valid, or an output refers to something that the model lacks.
    """
    checked, scope = _one_deck(study), Scope(STUDY_CHECKS, {}, {}, "", [])
    if study.outputs:
        checked_outputs(
            study.outputs, prepare(checked), lambda name: study.tree.value["outputs"][1].value[name][1], scope
        )
    _stop_at(scope.problems)
    return checked


def _case(number, row):
    given = plain_value(row[NAME].node) if NAME in row else None
    name = "" if given is None else str(shown_value(given))
    return Case(number, {path: entry for path, entry in row.items() if path != NAME}, name)


def _plain(entries):
    return {path: plain_value(entry.node) for path, entry in entries.items()}


def _as_yaml(value):
    """Return a value as a text of YAML: that of JSON, but for numbers that JSON does not have."""
    return NOT_FINITE.get(str(value)) or json.dumps(value) if isinstance(value, float) else json.dumps(value)


def _source(path, mark, what):
    try:
        return read_source(path)
    except Unreadable as error:
        hint = similar_files(str(path), (".yaml", ".yml"))
        raise DeckError([Problem(f"the {what} {path} cannot be read: {error}", mark, hint)]) from None


def _table_source(path, name, root, scope):
    file = os.path.join(os.path.dirname(path), name)
    try:
        return read_source(file)[0]
    except Unreadable as error:
        hint = similar_files(file, (".csv",))
        scope.refuse(root.value["csv"][1], f"the table {file} cannot be read: {error}", hint)
        return None


def _values(root, scope):
    """Return the checked values of the fields; the version is checked first."""
    if type(root.value) is not dict or "study" not in root.value:
        deck = "mecano" in (root.value or ())
        hint = "this is a deck: run it by `mecano run`" if deck else "begin with 'study: 1'"
        scope.problems.append(Problem("missing 'study', the version of the study file", root.mark, hint))
    elif root.value["study"][1].value != VERSION:
        scope.refuse(root.value["study"][1], f"this program reads studies of version {VERSION}", "write 'study: 1'")
    _stop_at(scope.problems)
    values = filled(root, Field("", TEXT, "-", "a study"), FIELDS, scope)
    _stop_at(scope.problems)
    return values


def _one_deck(study):
    """Return the first valid deck of some cases; raises the errors of the first case if none is valid."""
    count = len(study.cases)
    first: DeckError | None = None
    for number in dict.fromkeys(i * (count - 1) // (TRIED - 1) for i in range(TRIED)):
        case = study.cases[number]
        try:
            return read_deck(study.deck, study.overrides(case))
        except DeckError as error:
            first = first or in_study(error, study, case)
    assert first is not None, "a study has a case"
    raise first


def _stop_at(problems):
    if problems:
        raise DeckError(problems)

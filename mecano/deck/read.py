"""Read and check a deck in steps; each step requires that the one before found no errors, which would cause others."""

import os
import re
from collections.abc import Mapping, MutableMapping, Sequence
from typing import Any

from mecano.deck.check import UNCHECKED, checked_values, scope_of, written_out
from mecano.deck.compose import Node, compose
from mecano.deck.deck import Deck
from mecano.deck.expanded_sections import EXPANDED_SECTIONS
from mecano.deck.include import Inclusion
from mecano.deck.lint import suspicious, unplaced
from mecano.deck.overrides import overridden, settled
from mecano.deck.sections import SECTIONS
from mecano.deck.source import Source, Unreadable, decoded, read_source
from mecano.deck.wording import similar_files
from mecano.element_interface import SECTIONS as ELEMENT_SECTIONS
from mecano.element_interface import Kind
from mecano.elements import KINDS
from mecano.elements.plugins import load_installed
from mecano.errors import DeckError, Mark, Problem
from mecano.laws import TERMS
from mecano.laws.term import Term
from mecano.process.memory import reserve_blas_buffer
from mecano.schema import Field

BEFORE_COPIES = r"\s*(mecano|parameters|templates|place)\s*[.=]"  # overrides that affect the expansion


def read_deck(
    path: str | os.PathLike[str],
    overrides: Sequence[str] = (),
    kinds: MutableMapping[str, Kind] = KINDS,
    sections: Sequence[Field] = SECTIONS,
    terms: Mapping[str, Term] = TERMS,
) -> Deck:
    """Return the checked Deck of a file; ``overrides`` are texts "path.to.key=value".

    Raises DeckError with all problems of the first step that finds any: the bytes; the YAML and the structure (keys,
    types, units, finite numbers), with references to unknown names; the types of references; the physics.
    """
    load_installed()
    try:
        source, digest = read_source(path)
    except Unreadable as error:
        problem = Problem(
            f"the deck cannot be read: {error}", Mark(str(path), 1, 1), similar_files(str(path), (".yaml", ".yml"))
        )
        raise DeckError([problem]) from None
    return deck_of(source, digest, overrides, kinds, sections, terms)


def deck_of(
    source: Source,
    digest: str = "",
    overrides: Sequence[str] = (),
    kinds: MutableMapping[str, Kind] = KINDS,
    sections: Sequence[Field] = SECTIONS,
    terms: Mapping[str, Term] = TERMS,
) -> Deck:
    """Return the checked Deck of a Source; see ``read_deck``."""
    reserve_blas_buffer()  # before the checks, which are the first to use linear algebra
    problems: list[Problem] = []
    root = compose(source, problems)
    if root is None or type(root.value) is not dict:
        what = "the deck is empty" if root is None or root.value is None else "a deck is a mapping of sections"
        raise DeckError([*problems, Problem(what, (root or Node(None, source)).mark, "begin with 'mecano: 1'")])
    folder = os.path.dirname(source.file)
    known_sections = (*sections, *EXPANDED_SECTIONS)
    inclusion = Inclusion(folder, known_sections, problems)
    root = inclusion.merged(root)
    if inclusion.unread:
        raise DeckError(problems, UNCHECKED)
    early = [pair for pair in inclusion.settings if re.match(BEFORE_COPIES, f"{pair[0].value}=")]
    before, root = root, settled(root, early, known_sections, problems)
    doubts = _doubts(before, root, [str(path.value) for path, _ in early])
    first = [text for text in overrides if re.match(BEFORE_COPIES, text)]
    before, root = root, overridden(root, first, known_sections, problems)
    doubts += _doubts(before, root, [text.partition("=")[0] for text in first])
    scope = scope_of(root, kinds, terms, folder, problems)
    scope.files, scope.included = inclusion.files, inclusion.beside
    root, copies = written_out(root, sections, scope)
    later = [pair for pair in inclusion.settings if pair not in early]
    before, root = root, settled(root, later, sections, problems, copies.with_items)
    doubts += _doubts(before, root, [str(path.value) for path, _ in later])
    others = [text for text in overrides if text not in first]
    before, root = root, overridden(root, others, sections, problems, copies.with_items)
    doubts += _doubts(before, root, [text.partition("=")[0] for text in others])
    values = checked_values(root, sections, scope)
    lint = suspicious(values, root, scope.used_names(), kinds, bool(overrides or scope.parameters.words))
    idle = [] if overrides else unplaced(scope.unplaced)  # an override may remove the copies of a template
    known = {str(problem.mark) for problem in lint}  # of a number, one warning is enough
    doubts = [doubt for doubt in doubts if str(doubt.mark) not in known]
    warnings = (*lint, *idle, *scope.doubts, *doubts)
    keys = {section: _keys(root, section) for section in ("nodes", "initial", *ELEMENT_SECTIONS)}
    formulas = {found.text: node.mark for found, node, _ in reversed(scope.formulas)}
    return Deck(
        source.file, source.text, digest, values, tuple(overrides), scope.files, warnings, keys, formulas,
        scope.units_in_formulas, tuple(scope.motions),
    )  # fmt: skip


def _doubts(before, after, paths):
    """Return warnings about the values at ``paths`` that replace quantities of the tree ``before`` without a unit."""
    if not paths:
        return []
    from mecano.deck.forgotten_units import forgotten_units  # most decks are read as they are

    return forgotten_units(before, after, paths)


def _keys(root, section):
    """Return {name: node of the name} of a section of a checked tree."""
    given = root.value.get(section)
    return {name: key for name, (key, _) in given[1].value.items()} if given and type(given[1].value) is dict else {}


def deck_of_bytes(data: bytes, file: str, **options: Any) -> Deck:
    """Return the checked Deck of bytes, as if they were in ``file``."""
    return deck_of(decoded(data, file), **options)

"""Messages of failed analyses, with remedies for the elements that failed and the places of their formulas."""

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import islice

from mecano.deck.deck import Deck
from mecano.element_interface import SECTIONS
from mecano.elements import KINDS
from mecano.elements.signals.formula import FORMULA
from mecano.errors import AssemblyError, MecanoError, NonFiniteError, name_list
from mecano.model.model import title_of

MOST_NAMES = 4  # elements named with the same remedies, or with their places


@contextmanager
def locating(deck: Deck) -> Iterator[None]:
    """Add to a NonFiniteError the places of the formulas that failed, to an AssemblyError those of what it names."""
    try:
        yield
    except NonFiniteError as error:
        raise NonFiniteError(failure_text(error, deck, ())) from error
    except AssemblyError as error:
        text = "\n".join([str(error), *_places(str(error), deck)])
        raise AssemblyError(text, error.failure, error.timed) from error


def _places(text, deck):
    """Yield the places in the deck of the first elements, joints and others that a text without places names."""
    if f"{deck.file}:" in text:
        return
    titled = {name: (section, d["type"]) for section in SECTIONS for name, d in deck.values[section].items()}
    quoted = dict.fromkeys(re.findall(r"'([\w-]+)'", text))
    marks = ((titled[name], name, deck.mark(titled[name][0], name)) for name in quoted if name in titled)
    yield from islice((f"{title_of(kind, name)} is at {mark}" for (_, kind), name, mark in marks if mark), MOST_NAMES)


def failure_text(error: MecanoError, deck: Deck, warnings: Iterable[str]) -> str:
    """Return the text of an ``error`` with remedies for the elements that failed, and the places of their formulas.

    The text ends with the ``warnings`` about these elements and about the places of the equations that failed.
    """
    remedies: dict[str, list[str]] = {}
    affected = [*error.elements, *(f"{place}: " for place in error.places)]
    for section in SECTIONS:
        for name, d in deck.values[section].items():
            title = title_of(d["type"], name)
            if title in error.elements and (found := KINDS[d["type"]].remedies(d)):
                remedies.setdefault("; ".join(found), []).append(title)
    tries = [f"in {name_list(titles, MOST_NAMES, '; ')}: {found}" for found, titles in remedies.items()]
    known = [f"warning: {one}" for one in dict.fromkeys(warnings) if any(text in one for text in affected)]
    places = list(_formulas(error, deck)) or _places(" ".join(error.elements), deck)
    return "\n".join([str(error), *places, *tries, *known])


def _formulas(error, deck):
    """Yield the places in the deck of the formulas among the elements that failed."""
    marks = {title_of(FORMULA.name, text): mark for text, mark in deck.formulas.items()}
    named = {title_of(FORMULA.name, name): deck.mark("signals", name) for name in deck.values["signals"]}
    for title in error.elements:
        if mark := named.get(title) or marks.get(title):
            yield f"{title} is at {mark}"

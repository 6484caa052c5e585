"""Positions of errors in the deck of a case: an error of a value from the study points to the study file."""

import re
from dataclasses import replace
from typing import TYPE_CHECKING

from mecano.deck.overrides import shown
from mecano.errors import DeckError, Mark
from mecano.study.grammar import Entries, Entry

if TYPE_CHECKING:
    from mecano.study.read import Case, Study

OVERRIDE = re.compile(r"(override .+?):1:(\d+)")
MOST_REPORTED = 3  # values of a case


def in_study(error: DeckError, study: "Study", case: "Case") -> DeckError:
    """Return the DeckError of a case with positions in the study; errors of the deck itself name the case."""
    places = _places(study.entries(case))
    return DeckError([_moved(problem, places, case) for problem in error.problems], error.unchecked)


def line_in_study(said: str, study: "Study", case: "Case") -> str:
    """Return an error line of `mecano run` with its position in the study."""
    return _in_words(said, _places(study.entries(case)))


def _in_words(text: str, places: dict[str, tuple[str, Entry]]) -> str:
    """Return a text with the positions in the study of the values that it mentions."""
    return OVERRIDE.sub(
        lambda match: str(_mark(*places[match[1]], int(match[2]))) if match[1] in places else match[0], text
    )


def _moved(problem, places, case):
    problem, mark = replace(problem, hint=_in_words(problem.hint, places)), problem.mark
    if mark and mark.file in places:
        path, entry = places[mark.file]
        return replace(problem, mark=_mark(path, entry, mark.column))
    reported = [f"{path} = {value}" for path, value in case.values.items()]
    hint = f"in case {case.number} of the study" + (
        f" ({', '.join(reported)})" if len(reported) <= MOST_REPORTED else ""
    )
    return replace(problem, hint=f"{problem.hint}; {hint}" if problem.hint else hint)


def _places(entries: Entries) -> dict[str, tuple[str, Entry]]:
    """Return {text shown in place of a file: (path, Entry)}."""
    return {shown(path): (path, entry) for path, entry in entries.items()}


def _mark(path: str, entry: Entry, column: int) -> Mark:
    """Return the Mark of the path, or of the value, for a column of "path=value"."""
    return (entry.key if column <= len(path) else entry.node).mark

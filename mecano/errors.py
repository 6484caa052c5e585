"""Errors that a user can cause or encounter, each with the exit code of the command line."""

from collections.abc import Iterable, Sequence
from dataclasses import field
from enum import Enum
from typing import Self, TypeAlias

from mecano.immutable import immutable

LocatedWarning: TypeAlias = tuple[tuple[str, ...], str]  # path of keys to a suspicious value, text of the warning


@immutable
class Mark:
    """Location of a value of a deck: file, line and column (both from 1), and the chain of includes and templates."""

    file: str
    line: int
    column: int
    stack: "tuple[Mark, ...]" = ()  # of the includes and of the placed templates, outermost first
    text: str = field(default="", repr=False)  # the whole line, to be printed with a caret
    role: str = "in"  # role of a Mark in a stack: "included at", "placed at"

    def __str__(self):
        return f"{self.file}:{self.line}:{self.column}"


@immutable
class Problem:
    """An error or warning about a deck: message, location, and hint on the correct input."""

    message: str
    mark: Mark | None = None
    hint: str = ""

    def __post_init__(self):
        """Replace characters of the deck that cannot be printed by "?"."""
        for name in ("message", "hint"):
            text = getattr(self, name)
            if not text.isprintable():
                shown = "".join(c if c.isprintable() or c == "\n" else "?" for c in text)
                object.__setattr__(self, name, shown)


class Failure(Enum):
    """Reason why equations could not be solved, on which the advice depends."""

    NOT_CONVERGED = "not converged"
    NOT_FINITE = "not finite"
    SINGULAR = "singular"
    CONTRADICTION = "contradiction"


class MecanoError(Exception):
    """Error with a message for the user; the command line returns its ``exit_code``."""

    exit_code = 1
    elements: tuple[str, ...] = ()  # titles, "kind 'name'", of the elements in the equations that failed
    places: tuple[str, ...] = ()  # of these equations, "node a"

    def about(self, elements: Iterable[str]) -> Self:
        """Return this error with the titles of the ``elements`` in the equations that failed."""
        self.elements = tuple(elements)
        return self


class DeckError(MecanoError):
    """A deck is invalid; ``problems`` holds every Problem found.

    ``unchecked`` says what happens once they are fixed: "consistency is checked", or "".
    """

    exit_code = 2

    def __init__(self, problems: Iterable[Problem], unchecked: str = ""):
        self.problems, self.unchecked = list(problems), unchecked
        super().__init__("\n".join(f"{p.mark}: {p.message}" if p.mark else p.message for p in self.problems))

    def __reduce__(self):
        """Return what makes an equal error in another process, with the same text."""
        return type(self), (self.problems, self.unchecked), {**self.__dict__, "args": self.args}


class ConvergenceError(MecanoError):
    """Newton's iteration or the step control failed; the message names equations and remedies."""

    exit_code = 3


class IncompleteStudyError(MecanoError):
    """Some cases of a study did not complete; the message gives their number."""

    exit_code = 3


class BeyondLimitsError(MecanoError):
    """All cases of a study are complete, and some have outputs beyond their limits; the message gives their number."""

    exit_code = 8


class AssemblyError(MecanoError):
    """The initial configuration cannot be assembled or the equations are singular.

    ``timed`` is True if the message says at which time of a run.
    """

    exit_code = 4

    def __init__(self, message: str, failure: Failure = Failure.NOT_CONVERGED, timed: bool = False):
        self.failure, self.timed = failure, timed
        super().__init__(message)


class CompilationError(MecanoError):
    """A kernel contains something that cannot be compiled; the message says what."""


class ResultsError(MecanoError):
    """A results file cannot be read or written."""

    exit_code = 5


class NonFiniteError(MecanoError):
    """A force or an unknown became infinite or not a number."""

    exit_code = 6


class UsageError(MecanoError):
    """The command line is invalid or refers to something that does not exist."""

    exit_code = 2


class UnknownNameError(ResultsError):
    """A results file or study has nothing of that name, or more than one."""

    exit_code = 2


def name_list(names: Sequence[str], most: int, separator: str = ", ") -> str:
    """Return up to ``most`` names as text, with the number of further ones: "a, b, and 3 more"."""
    more = len(names) - most
    return separator.join([*names[:most], *([f"and {more} more"] if more > 0 else [])])

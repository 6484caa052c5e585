"""Errors that a user can cause or meet, each with the exit code of the command line."""

from dataclasses import dataclass, field
from enum import Enum


@dataclass(frozen=True)
class Mark:
    """Where a value of a deck was written: file, line and column (both from 1), and how it came there."""

    file: str
    line: int
    column: int
    stack: tuple = ()  # the marks of the including file or the place of the template, outermost first
    text: str = field(default="", repr=False, compare=False)  # the whole line, to be printed with a caret
    role: str = "in"  # of a mark in a stack: "included at", "placed at"

    def __str__(self):
        return f"{self.file}:{self.line}:{self.column}"


@dataclass(frozen=True)
class Problem:
    """One thing wrong in a deck: what, where, and what would be right."""

    message: str
    mark: Mark | None = None
    hint: str = ""


class Failure(Enum):
    """Why equations could not be solved: what is advised depends on it."""

    NOT_CONVERGED = "not converged"
    NOT_FINITE = "not finite"
    SINGULAR = "singular"
    CONTRADICTION = "contradiction"


class MecanoError(Exception):
    """An error with a message for the user; ``exit_code`` is what the command line returns."""

    exit_code = 1
    elements = ()  # titles, "kind 'name'", of those that act in the equations in which a run failed


class DeckError(MecanoError):
    """The deck cannot be used; ``problems`` holds every ``Problem`` found, ``unchecked`` says what was left out."""

    exit_code = 2

    def __init__(self, problems, unchecked=""):
        self.problems, self.unchecked = list(problems), unchecked
        super().__init__("\n".join(f"{p.mark}: {p.message}" if p.mark else p.message for p in self.problems))


class ConvergenceError(MecanoError):
    """Newton or the step control gave up; the message names equations and what to try."""

    exit_code = 3


class IncompleteStudyError(MecanoError):
    """Some cases of a study did not come to their end; the message counts them."""

    exit_code = 3


class AssemblyError(MecanoError):
    """The initial configuration cannot be assembled or the equations are singular."""

    exit_code = 4

    def __init__(self, message, failure=Failure.NOT_CONVERGED):
        self.failure = failure
        super().__init__(message)


class ResultsError(MecanoError):
    """A results file cannot be read or written."""

    exit_code = 5


class NonFiniteError(MecanoError):
    """A force or an unknown became infinite or not a number."""

    exit_code = 6


class UsageError(MecanoError):
    """The command line asks for something that does not exist or cannot be understood."""

    exit_code = 2


class UnknownNameError(ResultsError):
    """A results file has no output of that name, or several."""

    exit_code = 2

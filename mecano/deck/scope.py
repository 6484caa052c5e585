"""Shared state of the checks of a deck: problems found so far, current subject, parameters and references."""

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import field
from enum import Enum
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from mecano.deck.compose import Given, Node
from mecano.deck.expressions import ExpressionError, evaluate, is_evaluated, is_expression, names_in
from mecano.deck.parameters import CircularParameter, Parameters, Refused
from mecano.deck.similar_names import similar
from mecano.deck.source import Source
from mecano.deck.units import is_quantity
from mecano.deck.wording import as_list, corrected, found, how_to_write, quoted, suggestion, unit_text
from mecano.errors import DeckError, Mark, Problem
from mecano.immutable import mutable
from mecano.schema import SECTION_OF, Field

if TYPE_CHECKING:
    from mecano.laws.formula import Formula
    from mecano.laws.term import Term

MAX_PROBLEMS = 10_000
MAX_COMPARED = 1_000_000  # words: looking for similar ones is slow in a large deck
MAX_SUGGESTIONS = 100
MAX_REMEMBERED = 50  # words that are known, of suggestions that are kept
QUOTED_KEY = r"'([A-Za-z0-9_]+)'"
KEYWORDS = {  # type -> keywords that may replace a value
    "boolean": lambda type_: ("true", "false"),
    "either": lambda type_: type_.options[1],
    "shorthand": lambda type_: ["true" if word is True else word for word, _ in type_.options[1]],
}
MAX_KEYWORD = 20  # letters
MAX_EXPRESSION = 80  # letters of a text that may be meant as an expression
WORD = r"[A-Za-z_][A-Za-z0-9_]*"
MOST_PARAMETERS = 3  # named in a hint
MOST_PARAMETERS_DEEP = 10  # parameters given by one another
BARE = re.compile(r"\$([A-Za-z_][A-Za-z0-9_-]*)")  # nothing but a parameter
MOST_NODES = 1000  # of a value, in which parameters are looked for
DEFAULT = Source("default", "")


class Invalid(Enum):
    """The type of INVALID, the placeholder of a refused value."""

    INVALID = "invalid"


INVALID: Final = Invalid.INVALID
Checked: TypeAlias = Any  # value of a field, of any type, a Reference to another one, or INVALID
Check: TypeAlias = "Callable[[Node, Field, Scope], Checked]"


@mutable
class Reference:
    """A name of an entry of a section; the entry replaces the name once all sections have been read."""

    name: str
    section: str
    wanted: str  # name of the type: "law", "curve", "ground"...
    node: Node
    subject: str
    options: tuple[Any, ...] = ()  # of the type
    home: tuple[Any, str | int] | None = None  # (container, key) of the checked value
    use: Field | None = None  # of a law


@mutable
class Scope:
    """State of one check of a deck."""

    checks: Mapping[str, Check]  # by the name of the type
    kinds: Mapping[str, Any]  # Kind of an element, joint, load or signal, or Shape of a cross section, by name
    terms: "Mapping[str, Term]"
    folder: str  # of the deck; table files are relative to it
    problems: list[Problem]
    included: dict[str, str] = field(default_factory=dict)  # file as shown -> its folder relative to that of the deck
    parameters: Parameters = field(default_factory=Parameters)
    references: list[Reference] = field(default_factory=list)
    lines: list[list[str]] = field(default_factory=list)  # names of nodes and members
    node_sets: list[list[str]] = field(default_factory=list)  # the same, in any order
    formulas: "list[tuple[Formula, Node, str]]" = field(default_factory=list)  # with their subjects, all that are read
    continuous: "list[tuple[Any, Node, str]]" = field(default_factory=list)  # Formulas, laws without jumps
    motions: list[tuple[Any, str | int, str]] = field(default_factory=list)  # (container, key, formula as written)
    files: dict[str, str] = field(default_factory=dict)  # name of a file read -> SHA-256
    tables: dict[Any, Any] = field(default_factory=dict)  # name of a file read -> points, or reduced matrices
    beside: str = ""  # folder, relative to that of the deck, of the current file; files named in it are relative to it
    defaults: dict[int, Checked] = field(default_factory=dict)  # id of a Field -> checked default
    own_names: dict[int, Collection[str]] = field(default_factory=dict)
    """id of a Node with a name that its template does not define -> names that the template defines in that section"""
    unplaced: dict[str, Mark] = field(default_factory=dict)  # name of a template without a copy -> its place
    units_in_formulas: dict[str, dict[int, str]] = field(default_factory=dict)  # of parameters; see deck.Deck
    doubts: list[Problem] = field(default_factory=list)  # warnings on units of expressions
    misplaced: set[str] = field(default_factory=set)  # names of sections that are written inside others
    subject: str = ""  # "hinge 'knee'"
    path: list[str] = field(default_factory=list)  # keys between the subject and the current value
    owner: Node | None = None  # node of the key of the current value: a missing key is reported here
    suggestions: int = 0
    compared: int = 0  # words compared for suggestions
    suggested: dict[tuple[str, ...], str] = field(default_factory=dict)  # (word, known words) -> hint

    def refuse(self, node: Node, message: str, hint: str = "") -> Invalid:
        """Report a problem of the subject at the position of a node; return INVALID."""
        text = f"{self.subject}: {message}" if self.subject else message
        self.problems.append(Problem(text, node.mark, hint))
        if len(self.problems) >= MAX_PROBLEMS:
            raise DeckError(self.problems)
        return INVALID

    def where_given(self, node: Node) -> str:
        """Return a hint on the lines of the parameters from which a value comes, or "" if there are none or many."""
        names = dict.fromkeys(name for text in texts_in(node) for name in names_in(text, self.parameters))
        given = {name: at for name in names if (at := self.parameters.node(name))}
        if not 0 < len(names) <= MOST_PARAMETERS or len(given) < len(names):
            return ""
        places = {n: f"line {at.line + 1}" if at.source is node.source else str(at.mark) for n, at in given.items()}
        return ", ".join(f"${name} is given in {place}" for name, place in places.items())

    def refuse_value(self, node: Node, declared: Field, what: str | None = None, hint: str = "") -> Invalid:
        """Report that the value of a field is not of the required form; return INVALID."""
        name = self.name_of(declared.name)
        what = what or f"must be {declared.type.expects}"
        subject = f"{quoted(name)} " if name else ""
        expression = type(node.value) is str and is_evaluated(node.value)
        hint = hint or (self.where_given(node) if expression else self._keyword(node, declared))
        hint = hint or as_list(node, declared)
        hint = hint or ("" if expression else self._of_parameters(node, declared) or how_to_write(node, declared))
        return self.refuse(node, f"{subject}{what}{unit_text(declared)}, got {self.got(node)}", hint)

    def _of_parameters(self, node, declared):
        """Return a hint on a text that would be an expression of parameters with a '$', in place of a number, or ""."""
        if type(node.value) is not str or declared.type.name != "number" or len(node.value) > MAX_EXPRESSION:
            return ""
        text = re.sub(WORD, lambda word: f"${word[0]}" if self.parameters.known(word[0]) else word[0], node.value)
        return f"a parameter begins with '$': {text}" if text != node.value else ""

    def _keyword(self, node, declared):
        """Return a hint for a mistyped keyword of the type, or "" if none is similar."""
        words = KEYWORDS.get(declared.type.name, lambda type_: ())(declared.type)
        near = type(node.value) is str and len(node.value) <= MAX_KEYWORD and similar(node.value, words)
        return self.suggest(node.value, near) if near else ""

    def name_of(self, name: str) -> str:
        """Return the dotted path of a key below the subject."""
        return ".".join([*self.path, name] if name else self.path)

    def got(self, node: Node) -> str:
        """Return the text of a value for messages, with the value of an expression."""
        if type(node.value) is str and is_evaluated(node.value):
            try:
                return f"{evaluate(node.value, self.parameters)} ({node.value})"
            except (ExpressionError, Refused):
                pass
        return found(node)

    def used_names(self) -> dict[str, set[str]]:
        """Return {section: names that the deck refers to}; valid once the whole deck has been checked."""
        used: dict[str, set[str]] = {section: set() for section in SECTION_OF.values()}
        for reference in self.references:
            used[reference.section].add(reference.name)
        return {**used, "parameters": self.parameters.used}

    def suggest(self, word: str, known: Collection[str]) -> str:
        """Return a hint for an unknown word, as long as few different hints have been given."""
        again = (word, *known) if len(known) <= MAX_REMEMBERED else None  # a key that is misspelt in all entries
        if again in self.suggested:
            return self.suggested[again]
        self.suggestions += 1
        self.compared += len(known)
        few = self.suggestions <= MAX_SUGGESTIONS and self.compared <= MAX_COMPARED
        hint = suggestion(word, known) if few else ""
        if again:
            self.suggested[again] = hint
        return hint

    def evaluated(self, node: Node) -> float | Invalid | None:
        """Return the number of an expression; None if the text is not an expression."""
        if not is_evaluated(node.value):
            return None
        try:
            return evaluate(node.value, self.parameters)
        except Refused:
            return INVALID
        except ExpressionError as error:
            return self.refuse_expression(node, error)

    def quantity_of(self, text: str) -> str:
        """Return the number with a unit by which the parameter of an expression "$name" is given, or ""."""
        for _ in range(MOST_PARAMETERS_DEEP):
            name = BARE.fullmatch(text)
            node = self.parameters.node(name[1]) if name else None
            if node is None or type(node.value) is not str:
                return node.given if type(node) is Given else ""
            if is_quantity(node.value):
                return node.value
            text = node.value
        return ""

    def refuse_expression(self, node: Node, error: ExpressionError) -> Invalid:
        """Report an error of an expression, with names similar to an unknown one; that of a circle at its parameter."""
        if isinstance(error, CircularParameter):
            user, self.subject = self.subject, f"parameter '{error.name}'"
            try:
                return self.refuse(error.node, error.message)
            finally:
                self.subject = user
        hint = ""
        if error.near:
            hint = self.suggest(*error.near) if error.near[1] else "the deck has no 'parameters'"
        elif right := corrected(node.value):
            hint = f"write {right}"
        return self.refuse_at(node, error, hint)

    def refuse_at(self, node: Node, error: ExpressionError, hint: str) -> Invalid:
        """Report an ExpressionError with a hint, at its character in the line if that is known."""
        line, start = node.mark.text, node.column
        if line[start : start + 1] in "'\"":
            start += 1
        exact = line[start : start + len(node.value)] == node.value
        place = Node(node.value, node.source, node.line, start + error.column) if exact else node
        return self.refuse(place, error.message, hint)


def texts_in(node: Node) -> list[str]:
    """Return the expressions in the first MOST_NODES values of a node."""
    todo, found = [node], []
    for _ in range(MOST_NODES):
        if not todo:
            break
        value = todo.pop().value
        if type(value) is str and is_expression(value):
            found.append(value)
        elif type(value) is list:
            todo += reversed(value)
        elif type(value) is dict:
            todo += [item for _, item in reversed(value.values())]
    return found


def place(container: Any, key: str | int, value: Checked, scope: Scope) -> None:
    """Put a checked value into a dict or list; a reference there will be replaced by its entry."""
    container[key] = value
    if type(value) is Reference:
        value.home = (container, key)
        scope.references.append(value)


def node_of(value: Any) -> Node:
    """Return the node equivalent to a default, a Python value."""
    if isinstance(value, dict):
        return Node({key: (node_of(key), node_of(item)) for key, item in value.items()}, DEFAULT)
    if isinstance(value, list | tuple):
        return Node([node_of(item) for item in value], DEFAULT)
    return Node(value, DEFAULT, raw=str(value))


def place_of(text: str, node: Node, otherwise: Node) -> Node:
    """Return the node to which a text on a mapping refers: the quoted key at its beginning, or ``otherwise``."""
    match = re.match(QUOTED_KEY, text)
    if match and type(node.value) is dict and match[1] in node.value:
        return node.value[match[1]][1]
    return otherwise

"""Named numbers, defined in any order; circular definitions are refused.

They come from the section ``parameters`` of the deck, and from each copy of a template or of an entry with ``repeat``.
They may also be words, which are inserted into names: ``side: left``.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from mecano.deck.compose import Node
from mecano.deck.expressions import CONSTANTS, ExpressionError, evaluate, is_evaluated, is_expression, names_in
from mecano.deck.scalar import number
from mecano.deck.units import ANY, UnitError, converted, is_quantity


class Refused(Exception):
    """Error for a parameter without a value, whose cause is reported at its own position."""


class CircularParameter(ExpressionError):
    """Error for a parameter whose value depends on itself."""

    def __init__(self, names: list[str], node: Node):
        """``names``: from the parameter with the value ``node`` back to itself."""
        super().__init__(f"parameters depend on one another in a circle: {' -> '.join(names)}", 0)
        self.name, self.node = names[0], node


class Parameters:
    """Named numbers and words, evaluated on demand."""

    def __init__(self, nodes: dict[str, Node] | None = None, outer: "Parameters | None" = None):
        """``nodes``: {name: node of its value}; ``outer``: Parameters that are searched for names not in ``nodes``."""
        self.nodes = nodes or {}
        self.outer = outer
        self.values: dict[str, float | None] = {}  # name -> number, or None when it was refused
        self.dimensions: dict[str, tuple[float, ...] | None] = {}  # name -> powers of m, kg and s; None if unknown
        self.used: set[str] = set()  # names that have been referred to
        self.words: set[str] = set()  # names of the deck's parameters that are words
        self._open: list[str] = []  # names being evaluated

    def known(self, name: str) -> bool:
        """Return True if there is such a parameter."""
        return name in self.nodes or (self.outer is not None and self.outer.known(name))

    def names(self) -> list[str]:
        """Return the names of all parameters."""
        return list(dict.fromkeys([*self.nodes, *(self.outer.names() if self.outer else ())]))

    def node(self, name: str) -> Node | None:
        """Return the node of the value of a parameter, or None."""
        return self.nodes.get(name) or (self.outer.node(name) if self.outer else None)

    def word(self, name: str) -> Node | None:
        """Return the node of a parameter that is a word, or None."""
        if name not in self.nodes:
            return self.outer.word(name) if self.outer else None
        node = self.nodes[name]
        return node if name in self.words or (self.outer and is_word(node)) else None

    @contextmanager
    def working_on(self, name: str) -> Iterator[None]:
        """Mark ``name`` as being evaluated, so that a reference to it is a circle."""
        self._open.append(name)
        try:
            yield
        finally:
            self._open.pop()

    def __call__(self, name: str, column: int = 0) -> float:
        """Return the number of a parameter, for a character of an expression; raises ExpressionError, Refused."""
        if name not in self.nodes:
            if self.outer and self.outer.known(name):
                return self.outer(name, column)
            if name in CONSTANTS:
                raise ExpressionError(f"'{name}' is a constant: write {name} without $, in an expression", column)
            raise ExpressionError(f"unknown parameter '{name}'", column, (name, self.names()))
        self.used.add(name)
        if name in self._open:
            raise CircularParameter([*self._open[self._open.index(name) :], name], self.nodes[name])
        if self.word(name) and not _reads_as_number(self.nodes[name].value):
            raise ExpressionError(f"parameter '{name}' is the word '{self.nodes[name].value}', not a number", column)
        self._work_out(name)
        value = self.values[name]
        if value is None:
            raise Refused
        return value

    def _work_out(self, name):
        """Evaluate ``name`` after everything it depends on, without recursion: chains may have any length."""
        chain = {name: None}  # each needs the next one
        while chain:
            last = next(reversed(chain))
            needed = next((other for other in self._needed(last) if other not in self.values), None)
            if needed in chain or needed in self._open:
                self._refuse_circle([*self._open, *chain], needed)
            if needed is not None:
                chain[needed] = None
                continue
            if last not in self.values:
                self.values[last] = self._worked_out(last)
            del chain[last]

    def _needed(self, name):
        """Return the names of these parameters on which the value of ``name`` depends."""
        value = self.nodes[name].value
        if name in self.values or type(value) is not str or not is_expression(value):
            return []
        return [other for other in names_in(value, self) if other in self.nodes and not self.word(other)]

    def _refuse_circle(self, path, name):
        """Raise CircularParameter where ``path`` returns to ``name``, refused once; none of them has a value."""
        first = path.index(name)
        self.values |= dict.fromkeys([other for other in path if other not in self._open])
        raise CircularParameter([*path[first:], name], self.nodes[name])

    def _worked_out(self, name):
        value = self.nodes[name].value
        if type(value) in (int, float):
            return value
        if type(value) is not str:
            return None
        if (quoted_number := number(value)) is not None:
            return quoted_number
        if is_quantity(value):
            try:
                return converted(value, ANY)
            except UnitError:
                return None
        if not is_evaluated(value):
            return None
        with self.working_on(name):
            try:
                return evaluate(value, self)
            except (ExpressionError, Refused):
                return None


def _reads_as_number(text):
    return number(text) is not None or is_evaluated(text)


def is_word(node: Node) -> bool:
    """Return True if a value is a text that names use literally; "01" and 1/3 are numbers in expressions."""
    return type(node.value) is str and not is_expression(node.value) and not is_quantity(node.value)

"""The numbers of the section ``parameters``, in any order; those that need one another in a circle are refused."""

from contextlib import contextmanager

from mecano.deck.expressions import ExpressionError, evaluate, is_expression


class Refused(Exception):
    """A parameter has no value; why is told at its own place."""


class Circle(ExpressionError):
    """A parameter needs itself."""


class Parameters:
    """Numbers by name, worked out when they are asked for."""

    def __init__(self, nodes=None):
        """``nodes``: {name: node of its value}."""
        self.nodes = nodes or {}
        self.values = {}  # name -> number, or None when it was refused
        self._open = []  # names that are being worked out

    def known(self, name):
        """True when the deck has the parameter."""
        return name in self.nodes

    @contextmanager
    def working_on(self, name):
        """While the value of ``name`` is worked out, it may not be asked for."""
        self._open.append(name)
        try:
            yield
        finally:
            self._open.pop()

    def __call__(self, name, column=0):
        """The number of a parameter, asked for at a character of an expression; raises ExpressionError, Refused."""
        if name not in self.nodes:
            raise ExpressionError(f"unknown parameter '{name}'", column, (name, self.nodes))
        if name in self._open:
            circle = [*self._open[self._open.index(name) :], name]
            raise Circle(f"parameters go round in a circle: {' -> '.join(circle)}", column)
        if name not in self.values:
            self.values[name] = self._worked_out(name, column)
        if self.values[name] is None:
            raise Refused
        return self.values[name]

    def _worked_out(self, name, column):
        value = self.nodes[name].value
        if type(value) in (int, float):
            return value
        if type(value) is not str or not is_expression(value):
            return None
        with self.working_on(name):
            try:
                return evaluate(value, self)
            except Circle as error:
                raise Circle(error.message, column) from None
            except (ExpressionError, Refused):
                return None

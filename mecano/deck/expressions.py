"""Arithmetic in decks: ``$speed / 0.35``, ``=2*pi/3``; parsed with an allow-list, never executed.

A text is an expression if it has a ``$``, begins with ``=``, or is arithmetic of numbers alone, such as ``1/3`` or
``-pi/2``. Names with a ``$`` are parameters; angles are plain numbers [rad]. In the names of copies, values are
inserted: ``post$(i + 1)``, ``post$i``.
"""

import ast
import math
import operator
import re
from collections.abc import Callable, Collection, Iterator, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

from mecano.deck.wording import quoted

if TYPE_CHECKING:
    from mecano.deck.compose import Node
    from mecano.deck.parameters import Parameters

LONGEST, DEEPEST = 500, 50  # characters, levels of brackets and signs
NAME = re.compile(r"\$([A-Za-z_][A-Za-z0-9_]*)")
WHOLE = re.compile(r"(-?)\$([A-Za-z_][A-Za-z0-9_-]*)")
INSERT = re.compile(r"\$\(([^()$]*(?:\([^()$]*\)[^()$]*)*)\)|\$([A-Za-z_][A-Za-z0-9_]*)")
INSERTED = r"\$\(|[A-Za-z0-9_.)]\$[A-Za-z_]"  # the nodes of a meshed beam have names with dots
IN_A_NAME = r"[\w)]\$[(A-Za-z_]"  # a name begins with a letter
WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
NESTED = r"(\$\([^)$]*)\$([A-Za-z_]\w*)"
UNIT = r"[0-9.] ?(?![eE][-+0-9])[A-Za-z°%]"  # 90 deg
LONGEST_NAME = 200
OPERATORS: dict[type, Callable[..., float]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.Mod: operator.mod, ast.Pow: operator.pow, ast.UAdd: operator.pos, ast.USub: operator.neg,
}  # fmt: skip
ANGLES = ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "degrees", "radians")
FUNCTIONS = {name: getattr(math, name) for name in (*ANGLES, "sqrt", "exp", "log", "hypot")}
FUNCTIONS |= {"abs": abs, "min": min, "max": max}
CONSTANTS = {"pi": math.pi}
NO_NAMES = "constants: pi; this value is a number, no formula of signals and outputs"
WORDS = "|".join([*FUNCTIONS, *CONSTANTS])
DATE = "[0-9]{4}-[0-9]{1,2}-[0-9]{1,2}"
ARITHMETIC = re.compile(rf"(?:[-+*/%(), .0-9]|(?<=[0-9.])[eE](?=[-+0-9])|\b(?:{WORDS})\b)+")


class ExpressionError(Exception):
    """Error in an expression, at a character ``column`` of it; ``near`` is (unknown name, known names) or None."""

    def __init__(self, message: str, column: int = 0, near: tuple[str, Sequence[str]] | None = None):
        self.message, self.column, self.near = message, column, near
        super().__init__(message)


def is_expression(text: str) -> bool:
    """Return True if a text must be evaluated as an expression."""
    return "$" in text or text.startswith("=")


def is_arithmetic(text: str) -> bool:
    """Return True if a text is arithmetic of numbers, pi and functions, which needs no '='; "0" is, "pi" is a name.

    A date, 2026-11-29, is no difference.
    """
    return (
        len(text) <= LONGEST
        and ARITHMETIC.fullmatch(text) is not None
        and re.search("[0-9]|pi", text) is not None
        and not text.strip().isidentifier()
        and not re.fullmatch(DATE, text)
        and ("," not in text or "(" in text)
    )


def is_evaluated(text: str) -> bool:
    """Return True if ``evaluate`` finds the number of a text."""
    return is_expression(text) or is_arithmetic(text)


def names_in(text: str, parameters: "Parameters") -> list[str]:
    """Return the names of the parameters in an expression."""
    whole = WHOLE.fullmatch(text)
    if whole and parameters.known(whole[2]):
        return [whole[2]]
    return NAME.findall(text)


def has_inserts(text: str) -> bool:
    """Return True if a text is a name into which values are inserted; no expression has this form."""
    return re.search(INSERTED, text) is not None


def mentions(node: "Node", words: set[str], parameters: Collection[str]) -> bool:
    """Return whether a text of a tree has an expression with one of the ``words``, or a name with a parameter."""
    for text in texts_in(node):
        known = parameters if re.search(IN_A_NAME, text) else words
        if any(name in known for match in INSERT.finditer(text) for name in WORD.findall(inner_text(match))):
            return True
    return False


def texts_in(node: "Node") -> Iterator[str]:
    """Yield the texts with a $ in a tree."""
    todo = [node]
    while todo:
        value = todo.pop().value
        if type(value) is str and "$" in value:
            yield value
        elif type(value) is list:
            todo += value
        elif type(value) is dict:
            todo += [one for pair in value.values() for one in pair]


def inserted(text: str, parameters: "Parameters") -> str:
    """Return a name with whole numbers and words inserted; raises the errors of ``evaluate``."""
    if len(text) > LONGEST:
        raise _wrong(text, f"has more than {LONGEST} characters")
    parts, end = [], 0
    for match in INSERT.finditer(text):
        parts += [text[end : match.start()], insert(match, parameters)]
        end = match.end()
    parts.append(text[end:])
    if any("$" in part for part in parts):
        raise ExpressionError(f"the name {quoted(text)} has a $ without a value after it", text.find("$"))
    if sum(map(len, parts)) > LONGEST_NAME:
        raise ExpressionError(f"the name would have more than {LONGEST_NAME} characters")
    name = "".join(parts)
    if name.startswith("=") or is_arithmetic(name):
        raise ExpressionError(f"{quoted(text)} is read as a name, '{name}'; is an operator missing?", text.find("$", 1))
    return name


def check_inserts(text: str) -> None:
    """Raise an ExpressionError if a name in the brackets of an insert has a $ of its own."""
    if nested := re.search(NESTED, text):
        right = re.sub(NESTED, r"\1\2", text)
        raise ExpressionError(f"within $( ) names have no $: write {quoted(right)}", nested.end(1))


def inner_text(match: re.Match[str]) -> str:
    """Return the name or expression of a match of INSERT."""
    return (match[1] if match[2] is None else match[2]).strip()


def inner_value(match: re.Match[str], parameters: "Parameters") -> float:
    """Return the number of a match of INSERT; raises the errors of ``evaluate``, at their characters in the text."""
    try:
        return evaluate(f"={inner_text(match)}", parameters, bare=True)
    except ExpressionError as error:
        column = match.start() + (1 + error.column if match[2] is None else 0)
        raise type(error)(error.message, column, error.near) from None


def insert(match: re.Match[str], parameters: "Parameters") -> str:
    """Return the word or whole number of a match of INSERT, as part of a name."""
    word = parameters.word(inner_text(match))
    if word:
        return word.value
    value = inner_value(match, parameters)
    if value != int(value):
        raise ExpressionError(
            f"only whole numbers and words can be part of a name; {match[0]} is {value:g}", match.start()
        )
    return str(int(value))


def evaluate(text: str, parameters: "Parameters", bare: bool = False) -> float:
    """Return the value of an expression as a float; ``parameters(name)`` gives the numbers of names.

    ``bare``: names of parameters are written without a $.
    Raises ExpressionError, and the errors of ``parameters`` for a name without a number.
    """
    whole = WHOLE.fullmatch(text)
    if whole and ("-" not in whole[2] or parameters.known(whole[2])):
        return -parameters(whole[2]) if whole[1] else parameters(whole[2])
    if len(text) > LONGEST:
        raise _wrong(text, f"has more than {LONGEST} characters")
    if not text.isascii():
        raise _wrong(text, "may have ASCII characters only")
    body = text.removeprefix("=")
    skipped = len(text) - len(body.lstrip())
    try:
        tree = _tree(body.replace("$", "_").strip())
    except SyntaxError as error:
        units = ": expressions contain no units, give them to a parameter" if re.search(UNIT, body) else ""
        raise _wrong(text, f"cannot be understood{units}", skipped + max((error.offset or 1) - 1, 0)) from None
    except (ValueError, MemoryError, RecursionError):
        raise _wrong(text, "cannot be understood") from None
    try:
        value = _Reading(text, skipped, parameters, bare).value(tree.body, 0)
    except ZeroDivisionError:
        raise _wrong(text, "divides by zero") from None
    except (ArithmeticError, ValueError):
        raise _wrong(text, "has no finite real value") from None
    if not math.isfinite(value):
        raise _wrong(text, "has no finite real value")
    return value


@lru_cache(maxsize=1024)  # copies have the same expressions
def _tree(body):
    return ast.parse(body, mode="eval")


def _wrong(text, what, column=0):
    return ExpressionError(f"the expression {quoted(text)} {what}", column)


class _Reading:
    """One traversal of the tree of an expression."""

    def __init__(self, text, skipped, parameters, bare):
        self.text, self.skipped, self.parameters, self.bare = text, skipped, parameters, bare

    def value(self, tree, depth):
        """Return the value of a part of the tree."""
        if depth > DEEPEST:
            raise _wrong(self.text, f"is nested more than {DEEPEST} levels deep")
        inner = [self.value(part, depth + 1) for part in _operands(tree)]
        if isinstance(tree, ast.BinOp | ast.UnaryOp) and type(tree.op) in OPERATORS:
            return _real(OPERATORS[type(tree.op)](*inner))
        number = tree.value if isinstance(tree, ast.Constant) else None
        if type(number) is int or type(number) is float:
            return float(number)
        if isinstance(tree, ast.Name):
            return self._named(tree)
        if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and not tree.keywords:
            return self._called(tree, inner)
        what = "may contain numbers, $parameters, + - * / ** ( ) and functions only"
        if isinstance(tree, ast.BinOp) and isinstance(tree.op, ast.BitXor):
            what = "has the power ^, which is written **, as in 2**3"
        raise _wrong(self.text, what, self._column(tree))

    def _called(self, tree, inner):
        name = tree.func.id
        if name not in FUNCTIONS:
            raise ExpressionError(f"there is no function '{name}'", self._column(tree), (name, list(FUNCTIONS)))
        try:
            return _real(FUNCTIONS[name](*inner))
        except TypeError:
            raise ExpressionError(f"'{name}' takes a different number of arguments", self._column(tree)) from None

    def _named(self, tree):
        column = self._column(tree)
        match = NAME.match(self.text, column)
        if match is None:
            if tree.id in CONSTANTS:
                return CONSTANTS[tree.id]
            if self.bare:
                return self.parameters(tree.id, column)
            if self.text[column] == "$":
                raise _wrong(self.text, "has a $ without the name of a parameter after it", column)
            hint = "a parameter is written with a $" if self.parameters.known(tree.id) else NO_NAMES
            raise ExpressionError(f"there is no constant '{tree.id}'; {hint}", column)
        if len(match[0]) < len(tree.id):
            raise _wrong(
                self.text, f"has a $ right after '{match[0]}'; is an operator missing?", column + len(match[0])
            )
        return self.parameters(match[1], column)

    def _column(self, tree):
        """Return the character of the text at which a part begins; bytes of the tree count as characters."""
        return min(self.skipped + tree.col_offset, len(self.text))


def _operands(tree):
    if isinstance(tree, ast.BinOp):
        return (tree.left, tree.right)
    if isinstance(tree, ast.UnaryOp):
        return (tree.operand,)
    return tree.args if isinstance(tree, ast.Call) else ()


def _real(value):
    if isinstance(value, complex):
        raise ValueError("it is not real")
    return float(value)

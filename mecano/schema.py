"""What a deck field is: name, type, unit, meaning, default, check. Knows nothing of YAML.

One declaration gives the deck check, `mecano explain`, the documentation and the JSON Schema.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

REQUIRED = object()


@dataclass(frozen=True)
class Type:
    """The type of a field; ``expects`` completes the sentence "'mass' must be ..."."""

    name: str
    expects: str
    options: tuple = ()  # choices, length of a list, or the fields and types inside; see the functions below
    moves: str = ""  # what the value is in inertial axes, "point", "direction" or "orientation", if it is one at all
    schema: object = field(default=None, compare=False)  # JSON Schema, of a type of which deck/json_schema.py has none


NUMBER = Type("number", "a number")
INTEGER = Type("integer", "a whole number")
BOOLEAN = Type("boolean", "true or false")
TEXT = Type("text", "a text")
VECTOR = Type("vector", "a list of 3 numbers", moves="direction")  # inertial components
NODE_VECTOR = Type("vector", "a list of 3 numbers, in the axes of the node")
POINT = Type("vector", "a list of 3 numbers, a point", moves="point")  # inertial
POSITION = Type("vector", "a list of 3 numbers", moves="point")  # inertial
ORIENTATION = Type("vector", "a list of 3 numbers", moves="orientation")  # rotation vector from the inertial axes
DIRECTION = Type("direction", "a list of 3 numbers, not all zero", moves="direction")
INERTIA = Type("inertia", "3 principal moments, 6 numbers [xx, yy, zz, xy, xz, yz], or a 3x3 symmetric matrix")
MATRIX_6 = Type("matrix_6", "6 numbers (a diagonal) or a 6x6 matrix")
NODE = Type("node", "the name of a node")
NODES = Type("nodes", "a list of node names")
NUMBERS = Type("numbers", "a list of numbers")
COEFFICIENT_LIST = Type("coefficients", "a list of numbers")  # of ascending powers, with units that go together
POINTS = Type("points", "a list of [x, y] pairs")
COLUMNS = Type("columns", "a list of 2 headers, or numbers of columns, from 1")
UNITS = Type("units", "a list of 2 units")
LAW = Type("law", "the name of a law, or a law written in place")
CURVE = Type("curve", "a number, the name of a law, or a law of one variable written in place")
DRIVE = Type("drive", "a number, the name of a law or of a signal, a law of the time, or a formula of signals")
FORMULA = Type("formula", "a formula of signals, outputs of elements, motions of nodes and the time")
CONDITION = Type("condition", "a condition, such as hinge.angle > 1.5")
SIGNAL_ENTRY = Type("signal_entry", "a formula, or a mapping with the key 'type'", ("signals",))
GROUND = Type("ground", "the name of a ground")
TIRE_LAW = Type("tire_law", "the name of a tire law")
WHEEL = Type("wheel", "the name of a wheel")  # of the elements; its checked values take the place of the name

SECTION = Type("section", "the name of a cross section")
SECTION_OF = {  # name of a type -> the section of a deck whose names its values are
    "node": "nodes", "nodes": "nodes", "law": "laws", "curve": "laws", "ground": "grounds", "tire_law": "tire_laws",
    "wheel": "elements", "section": "sections", "drive": "laws", "joint": "joints",
}  # fmt: skip
REDUCED = Type("reduced", "a .yaml, .npz or .h5 file of reduced matrices, or a mapping as in such a file")
ROWS = Type("rows", "a list of rows of numbers, or the name of a .mtx or .npy file")


def pair_of(type_):
    """A list of exactly two nodes, numbers...: here only of nodes."""
    return Type("nodes", f"a list of 2 {type_.name} names", (2,))


NODE_PAIR = pair_of(NODE)


def joint_with(output):
    """The name of a joint with a coordinate that is this output; its checked values take the place of the name."""
    return Type("joint", f"the name of a joint with the output '{output}'", (output,))


def choice(*names):
    """One of the given words."""
    return Type("choice", "one of: " + ", ".join(names), names)


def mapping(*fields):
    """Keys and values, each declared by a ``Field``."""
    return Type("mapping", "a mapping", fields)


def named(type_, check=None):
    """A mapping of names the user gives to values of one type; ``check`` as in ``Field``, for each value."""
    return Type("named", "a mapping of names", (type_, check))


def list_of(type_, check=None):
    """A list of values of one type; ``check`` as in ``Field``, for each value."""
    return Type("list", "a list", (type_, check))


def either(type_, *words):
    """A value of the given type, or one of the given words."""
    return Type("either", " or ".join([type_.expects, *(f"'{word}'" for word in words)]), (type_, words))


def shorthand(type_, words):
    """A mapping or list of the given type, or a word (or true) that stands for one: {word: value}."""
    expects = " or ".join([type_.expects, *("true" if word is True else f"'{word}'" for word in words)])
    return Type("shorthand", expects, (type_, tuple(words.items())))


def one_of_kinds(section):
    """One element, joint or load: a mapping whose ``type`` names the kind, with the fields of that kind."""
    return Type("kind", "a mapping with the key 'type'", (section,))


@dataclass(frozen=True)
class Field:
    """One key of a deck: SI ``unit`` ("-" for none), one-line ``doc``, ``check`` -> error text or None.

    The text of a check completes "'mass' ..."; that of a check of a whole mapping is a sentence of its own, and
    points at the key with which it begins in quotes.
    """

    name: str
    type: Type
    unit: str
    doc: str
    default: object = field(default=REQUIRED)
    check: Callable[[object], str | None] | None = None

    @property
    def required(self):
        """True when the deck must give the field."""
        return self.default is REQUIRED


def positive(value):
    """Check: > 0."""
    return None if value > 0 else "must be greater than zero"


def not_negative(value):
    """Check: >= 0."""
    return None if value >= 0 else "must not be negative"


def not_zero(value):
    """Check: not zero."""
    return None if value else "must not be zero"


def share(value):
    """Check: from 0 to 1."""
    return None if 0.0 <= value <= 1.0 else "must be from 0 to 1"

"""Declaration of deck fields: name, type, unit, meaning, default, check. Independent of YAML.

The deck check, `mecano explain`, the documentation and the JSON Schema are all derived from these declarations.
"""

from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Any, TypeAlias

from mecano.immutable import immutable

REQUIRED = object()
ValueCheck: TypeAlias = Callable[[Any], str | None]  # of a checked value: the text of its error, or None
Values: TypeAlias = dict[str, Any]  # checked values of a mapping in a deck: name of the field -> value


@immutable
class Type:
    """The type of a field; ``expects`` completes the sentence "'mass' must be ..."."""

    name: str
    expects: str
    options: Any = ()  # choices, length of a list, or the fields and types inside; see the functions below
    moves: str = ""  # "point", "direction" or "orientation" in inertial axes; "" for any other value
    schema: object = field(default=None)  # JSON Schema, if deck/json_schema.py does not cover the type


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
LINE = Type("nodes", "the name of a member, or a list of names of nodes and members", (None, "members"))
"""Nodes from one end of a line to the other; a member, such as a beam with a mesh, stands for all of its nodes."""
NODE_SET = Type("nodes", "a list of names of nodes and members", LINE.options)
"""Nodes in any order; a member stands for all of its nodes."""
NUMBERS = Type("numbers", "a list of numbers")
COEFFICIENT_LIST = Type("coefficients", "a list of numbers")  # of ascending powers, with consistent units
POINTS = Type("points", "a list of [x, y] pairs")
COLUMNS = Type("columns", "a list of 2 column headers, or column numbers from 1")
UNITS = Type("units", "a list of 2 units")
LAW = Type("law", "the name of a law, or a law written in place")
CURVE = Type("curve", "a number, the name of a law, or a law of one variable written in place")
TIME_CURVE = Type("curve", "a number, the name of a law, or a law of time written in place")
DRIVE = Type("drive", "a number, the name of a law or of a signal, a law of time, or a formula of signals")
CONTINUOUS_DRIVE = Type("drive", DRIVE.expects, ("continuous",))  # without jumps
MOTION = Type("drive", "a number, the name of a law, a law of time, or a formula of the time", ("motion",))
UNIT = Type("unit", "a unit, such as N m, deg or m/s")
FORMULA = Type("formula", "a formula of signals, outputs of elements, motions of nodes and the time")
FUNCTION = Type("function", "a formula of s")
CONDITION = Type("condition", "a condition, such as hinge.angle > 1.5")
SIGNAL_ENTRY = Type("signal_entry", "a formula, or a mapping with the key 'type'", ("signals",))
GROUND = Type("ground", "the name of a ground")
TIRE_LAW = Type("tire_law", "the name of a tire law")
WHEEL = Type("wheel", "the name of a wheel")  # among the elements; replaced by its checked values

SECTION = Type("section", "the name of a cross section")
SECTION_OF = {  # type -> section of the deck whose entries it refers to
    "node": "nodes", "nodes": "nodes", "law": "laws", "curve": "laws", "ground": "grounds", "tire_law": "tire_laws",
    "wheel": "elements", "section": "sections", "drive": "laws", "joint": "joints",
}  # fmt: skip
REDUCED = Type("reduced", "a .yaml, .npz or .h5 file of reduced matrices, or a mapping as in such a file")
ROWS = Type("rows", "a list of rows of numbers, or the name of a .mtx or .npy file")


def pair_of(type_: Type) -> Type:
    """Return the type of a list of exactly two names; used for nodes only."""
    return Type("nodes", f"a list of 2 {type_.name} names", (2,))


NODE_PAIR = pair_of(NODE)


def joint_with(output: str) -> Type:
    """Return the type of the name of a joint with this output; its checked value is the values of the joint."""
    return Type("joint", "the name of a joint", (output,))


def choice(*names: str) -> Type:
    """Return the type of one of the given words."""
    return Type("choice", "one of: " + ", ".join(names), names)


def mapping(*fields: "Field") -> Type:
    """Return the type of a mapping whose keys are declared by ``Field``."""
    return Type("mapping", "a mapping", fields)


def named(type_: Type, check: ValueCheck | None = None) -> Type:
    """Return the type of a mapping from user-defined names to values of one type; ``check`` as in ``Field``."""
    return Type("named", "a mapping of names", (type_, check))


def list_of(type_: Type, check: ValueCheck | None = None) -> Type:
    """Return the type of a list of values of one type; ``check`` as in ``Field``, for each value."""
    return Type("list", f"a list, each item {type_.expects}", (type_, check))


def either(type_: Type, *words: str) -> Type:
    """Return the type of a value of the given type or one of the given words."""
    return Type("either", " or ".join([type_.expects, *(f"'{word}'" for word in words)]), (type_, words))


def shorthand(type_: Type, words: Mapping[Any, Any]) -> Type:
    """Return the type of a mapping or list, or of a word (or true) that abbreviates one: {word: value}."""
    expects = " or ".join([type_.expects, *("true" if word is True else f"'{word}'" for word in words)])
    return Type("shorthand", expects, (type_, tuple(words.items())))


def one_of_kinds(section: str) -> Type:
    """Return the type of an element, joint or load: a mapping with the fields of the kind that its ``type`` names."""
    return Type("kind", "a mapping with the key 'type'", (section,))


@immutable
class Field:
    """A key of a deck: SI ``unit`` ("-" if dimensionless), one-line ``doc``, ``check`` -> error text or None.

    ``argument`` is the SI unit of the argument of a curve or of a law: the units in its terms are checked against both.
    A law of a length is a force, one of an angle a moment; a curve of time or a drive has seconds.

    The text of a check completes "'mass' ..."; for a check of a whole mapping it is a complete sentence, and the error
    is located at the key that it quotes first.
    """

    name: str
    type: Type
    unit: str
    doc: str
    default: object = field(default=REQUIRED)
    check: ValueCheck | None = None
    argument: str = ""

    @property
    def required(self) -> bool:
        """True if the deck must give the field."""
        return self.default is REQUIRED


def requirement(holds: Callable[[Any], bool], text: str) -> ValueCheck:
    """Return the check of a value for which ``holds(value)`` must be true; ``text`` is its error."""
    return lambda value: None if holds(value) else text


positive = requirement(lambda value: value > 0, "must be greater than zero")
not_negative = requirement(lambda value: value >= 0, "must not be negative")
not_zero = requirement(lambda value: value != 0, "must not be zero")
share = requirement(lambda value: 0.0 <= value <= 1.0, "must be from 0 to 1")

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
    options: tuple = ()  # choices, or the section a reference points into, or the length of a list


NUMBER = Type("number", "a number")
INTEGER = Type("integer", "a whole number")
BOOLEAN = Type("boolean", "true or false")
TEXT = Type("text", "a text")
VECTOR = Type("vector", "a list of 3 numbers")  # inertial components
NODE_VECTOR = Type("vector", "a list of 3 numbers, in the axes of the node")
DIRECTION = Type("direction", "a list of 3 numbers, not all zero")
INERTIA = Type("inertia", "3 principal moments, 6 numbers [xx, yy, zz, xy, xz, yz], or a 3x3 symmetric matrix")
NODE = Type("node", "the name of a node")
NODES = Type("nodes", "a list of node names")
LAW = Type("law", "the name of a law, or a law written in place")
CURVE = Type("curve", "a number, the name of a law, or a law of one variable written in place")
GROUND = Type("ground", "the name of a ground")
TIRE_LAW = Type("tire_law", "the name of a tire law")


def pair_of(type_):
    """A list of exactly two nodes, numbers...: here only of nodes."""
    return Type("nodes", f"a list of 2 {type_.name} names", (2,))


NODE_PAIR = pair_of(NODE)


def choice(*names):
    """One of the given words."""
    return Type("choice", "one of: " + ", ".join(names), names)


@dataclass(frozen=True)
class Field:
    """One key of a deck: SI ``unit`` ("-" for none), one-line ``doc``, ``check`` -> error text or None."""

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

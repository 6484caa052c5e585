"""Placement of a copy of a template: points, directions and orientations are moved, names get a prefix.

The fields concerned are declared by their types (mecano/schema.py).
"""

import math
from collections.abc import Collection, Mapping, Sequence
from typing import TypeAlias

from mecano.deck.compose import Node
from mecano.deck.copied_formulas import is_own, with_prefix
from mecano.deck.scope import INVALID, Scope, node_of
from mecano.schema import LINE, SECTION_OF, Field

Quaternion: TypeAlias = tuple[float, float, float, float]  # w, x, y, z of a rotation
LEAST = 1e-100  # smaller numbers, which no deck may contain, are what rounding leaves of a turn
FORMULAS = ("formula", "condition", "drive", "signal_entry")  # types of texts that may name signals and outputs


class Word(Node):
    """A word from a parameter, a name from outside: the prefixes of the next ``rise`` templates are not added to it."""

    __slots__ = ("rise",)

    def __init__(self, value: str, node: Node, rise: int):
        super().__init__(value, node.source, node.line, node.column, value)
        self.rise = rise


def quaternion(vector: Sequence[float]) -> Quaternion:
    """Return the unit quaternion (w, x, y, z) of a rotation vector (3,) [rad]."""
    angle = math.hypot(*vector)
    factor = math.sin(0.5 * angle) / angle if angle > 0.0 else 0.5
    x, y, z = vector
    return math.cos(0.5 * angle), factor * x, factor * y, factor * z


def rotation_vector(q: Quaternion) -> list[float]:
    """Return the rotation vector (3,) [rad] of a unit quaternion, of an angle up to pi."""
    w, *v = q if q[0] >= 0.0 else [-c for c in q]
    size = math.hypot(*v)
    factor = 2.0 * math.atan2(size, w) / size if size > 0.0 else 2.0
    return [factor * c for c in v]


def product(p: Quaternion, q: Quaternion) -> Quaternion:
    """Return the quaternion of the rotation q followed by p."""
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z, a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x, a * z + b * y - c * x + d * w,
    )  # fmt: skip


class Placement:
    """Position (3,) [m] and orientation, a rotation vector (3,) [rad], of a copy; inertial."""

    def __init__(self, position: Sequence[float], orientation: Sequence[float]):
        self.x, self.q = position, quaternion(orientation)
        self.turns = any(orientation)

    def moved(self, value: list[float], what: str) -> list[float]:
        """Return the three numbers of a "point", "direction" or "orientation" of the template in the copy."""
        if what == "orientation":
            return rotation_vector(product(self.q, quaternion(value))) if self.turns else value
        turned = self._turned(value) if self.turns else value
        return [a + b for a, b in zip(self.x, turned, strict=True)] if what == "point" else turned

    def _turned(self, v):
        w, x, y, z = self.q
        t = [2.0 * c for c in (y * v[2] - z * v[1], z * v[0] - x * v[2], x * v[1] - y * v[0])]
        return [
            v[0] + w * t[0] + y * t[2] - z * t[1],
            v[1] + w * t[1] + z * t[0] - x * t[2],
            v[2] + w * t[2] + x * t[1] - y * t[0],
        ]


class Placing:
    """Mover of the entries of a template, in place, to the position of one copy."""

    def __init__(self, prefix: str, placement: Placement, own: Mapping[str, Collection[str]], scope: Scope):
        """``own``: {section: names defined by the template}."""
        self.prefix, self.placement, self.own, self.scope = prefix, placement, own, scope

    def take(self, node: Node, field: Field) -> None:
        """Move a value, and everything inside it, declared by ``field``."""
        type_ = field.type
        if type_.moves:
            self._move(node, field)
        elif type_.name in FORMULAS and type(node.value) is str:
            self._rename_formula(node)
        elif type_.name in SECTION_OF:
            self._rename(node, SECTION_OF[type_.name], type_ == LINE)
        elif type_.name == "mapping":
            self._fields(node, type_.options)
        elif type_.name in ("kind", "signal_entry") and type(node.value) is dict:
            named = node.value.get("type", (None, node))[1].value
            kind = self.scope.kinds.get(named) if type(named) is str else None
            self._fields(node, kind.fields if kind else ())
        elif type_.name in ("either", "shorthand", "list", "named") and type(node.value) in (dict, list):
            self._inside(node, field)

    def _inside(self, node, field):
        inner = Field(field.name, field.type.options[0], field.unit, field.doc)
        if field.type.name in ("either", "shorthand"):
            self.take(node, inner)
        else:
            for item in node.value if type(node.value) is list else [pair[1] for pair in node.value.values()]:
                self.take(item, inner)

    def _fields(self, node, fields):
        if type(node.value) is not dict:
            return
        for field in fields:
            if field.name in node.value:
                self.take(node.value[field.name][1], field)
            elif field.type.moves and not field.required and field.default is not None and self.placement.turns:
                given = node_of(field.default)
                self._move(given, field)
                node.value[field.name] = (node, given)

    def _move(self, node, field):
        value = self.scope.checks[field.type.name](node, field, self.scope)
        if value is not INVALID:
            moved = [c if abs(c) >= LEAST else 0.0 for c in self.placement.moved(value, field.type.moves)]
            place = node.value
            node.value = [Node(c, at.source, at.line, at.column, at.raw) for c, at in zip(moved, place, strict=True)]

    def _rename(self, node, section, members):
        if type(node.value) is list:
            for item in node.value:
                self._rename(item, section, members)
        elif type(node) is Word and node.rise > 0:
            node.rise -= 1
        elif type(node.value) is str and (
            self._is_own(node.value, section) or (members and self._is_own(node.value, "elements"))
        ):
            node.value = self.prefix + node.value
        elif type(node.value) is str:
            self.scope.own_names[id(node)] = self.own[section]

    def _rename_formula(self, node):
        if type(node) is Word and node.rise > 0:
            node.rise -= 1
        elif type(node) is Word or node.value.isidentifier():
            node.value = self.prefix + node.value if is_own(node.value, self.own) else node.value
        else:
            node.value = with_prefix(node.value, self.prefix, self.own)

    def _is_own(self, name, section):
        """Return True for a name of the template; nodes inside its members, such as ``leg.1``, belong to it too."""
        member, dot, _ = name.partition(".")
        return name in self.own[section] or (section == "nodes" and dot != "" and member in self.own["elements"])

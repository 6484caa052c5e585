"""Warnings about angles whose axis nothing holds: a motor or a gear without the bearing in which it turns."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from mecano.deck.physics import own_nodes
from mecano.deck.turning_axes import bodies, turning_together
from mecano.deck.wording import quoted
from mecano.element_interface import SECTIONS, Kind, nothing
from mecano.model.model import GROUND

if TYPE_CHECKING:
    from mecano.deck.lint import LocatedWarning
    from mecano.schema import Values

POINT = {"along_1", "along_2", "along_axis"}  # axes that hold a point of a body: it may turn about any axis


def loose_axes(values: "Values", kinds: Mapping[str, Kind]) -> "Iterator[LocatedWarning]":
    """Yield (path, text) on joints that hold angles of bodies which are held at one point, or not at all.

    A body with more joints or members is not judged: two spherical joints are a bearing, too.
    """
    body = bodies(values, kinds, turning_together)
    at: dict[str, list[tuple[str, bool]]] = {}  # by body: name of a joint or member, whether it holds a point only
    for section in SECTIONS[:2]:
        for name, d in values[section].items():
            kind, names = kinds[d["type"]], own_nodes(kinds[d["type"]], d)
            if kind.counts_angles is nothing and len(names) > 1 and "attached" not in d:
                point = set(kind.holds(d)) == POINT
                for one in body(names):
                    at.setdefault(one, []).append((name, point))
    for name, d in values["joints"].items():
        for node in dict.fromkeys(node for *_, pair in kinds[d["type"]].counts_angles(d) for node in pair):
            (one,) = body([node])
            found = at.get(one, [])
            if body([node]) != body([GROUND]) and len(found) < 2 and all(point for _, point in found):
                held = f"only {quoted(found[0][0])} holds it, at a point" if found else "no joint or member holds it"
                text = f"{d['type']} {quoted(name)}: node {quoted(node)} can turn about any axis, as {held}"
                yield ("joints", name), f"{text}; the joint holds the angle about its axis alone: is a hinge missing?"
                break

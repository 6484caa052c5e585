"""Warnings that concern few decks: each check is in a module of its own, imported only where it applies."""

import math
from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from typing import NamedTuple

from mecano.element_interface import Kind, nothing
from mecano.errors import LocatedWarning
from mecano.laws.law_table import breakpoints
from mecano.schema import Values

ROOM = 0.05  # of the size of a body, as AMONG in misplaced_bodies.py


class Check(NamedTuple):
    """A check: the function ``name`` in a module of mecano/deck, and a condition on the decks that it concerns."""

    module: str
    name: str
    applies: Callable[[Values, Mapping[str, Kind]], bool]
    of_kinds: bool = True  # whether it also takes the kinds


def rare_warnings(values: Values, kinds: Mapping[str, Kind]) -> Iterator[LocatedWarning]:
    """Yield (path, text) of all checks that concern a deck.

    ``values`` are those of the checked deck, ``kinds`` is {name: Kind} of all elements.
    """
    for check in CHECKS:
        if check.applies(values, kinds):
            found = getattr(import_module(f"mecano.deck.{check.module}"), check.name)
            yield from found(values, kinds) if check.of_kinds else found(values)


def _any(section, condition):
    """Return the condition that some entry of a section, with values d, satisfies condition(d)."""
    return lambda values, kinds: any(condition(d) for d in values[section].values())


def _counting_angles(*sections):
    """Return the condition that kinds in these sections count angles."""
    return lambda values, kinds: any(
        kinds[d["type"]].counts_angles is not nothing for section in sections for d in values[section].values()
    )


def _has_wheels(values, kinds):
    return any("wheels" in kinds[d["type"]].display.pictures for d in values["elements"].values())


def _has_friction(values, kinds):
    return bool(values["tire_laws"]) or any(d.get("friction") for d in values["joints"].values())


def _prescribes_corners(values, kinds):
    """Return whether laws of prescribed motions have breakpoints, or are tables."""
    joints = values["joints"].values()
    laws = [law for d in joints for law in (*kinds[d["type"]].drives(d), *(d.get("driven") or {}).values())]
    return any(breakpoints(law) or any(name == "table" for name, _ in law) for law in laws if isinstance(law, tuple))


def _has_misplaced_bodies(values, kinds):
    """Return whether a centre of mass is far away or may count from the origin, or a node is attached to two bodies."""
    low, high = _box(values["nodes"].values())
    size = math.dist(low, high)
    bodies = values["elements"].values()
    attached = [node for d in bodies for node in d.get("attached") or ()]
    far = size > 0.0 and any(math.hypot(*d.get("center_of_mass", ())) > size for d in bodies)
    return far or len(set(attached)) < len(attached) or any(_may_count_from_origin(d, values["nodes"]) for d in bodies)


def _may_count_from_origin(d, nodes):
    """Return whether a centre of mass may count from the origin: it would be among its nodes, which are not turned."""
    if not d.get("attached") or not any(d.get("center_of_mass", ())):
        return False
    node = nodes[d["node"]]
    if not any(node["position"]) or any(node["orientation"]):
        return False
    low, high = _box([nodes[node] for node in (d["node"], *d["attached"])])
    room = ROOM * math.dist(low, high)
    return all(a - room <= x <= b + room for a, x, b in zip(low, d["center_of_mass"], high, strict=True))


def _box(nodes):
    """Return the least and the largest coordinates of the positions of nodes."""
    along = list(zip(*(node["position"] for node in nodes), strict=True))
    return [min(x) for x in along], [max(x) for x in along]


CHECKS = (
    Check("wheel_bearings", "misplaced_bearings", _has_wheels),
    Check("tyre_sides", "one_sided_tyres", _any("tire_laws", lambda d: d.get("magic_formula"))),
    Check("latches", "latches_pushed_away", _any("joints", lambda d: d.get("latch")), False),
    Check("bound_joints", "binding_joints", lambda values, kinds: len(values["joints"]) > 1),
    Check("loose_axes", "loose_axes", _counting_angles("joints")),
    Check("loose_axes", "loose_followers", _any("joints", lambda d: d.get("across") == "free")),
    Check("loose_axes", "acting_on_released", _any("joints", lambda d: d.get("release"))),
    Check("idle_axes", "idle_axes", _counting_angles("elements", "loads")),
    Check("idle_axes", "idle_racks", _any("joints", lambda d: {"direction", "radius"} <= d.keys())),
    Check("jumping_motions", "jumping_motions", _prescribes_corners),
    Check("misplaced_bodies", "misplaced_bodies", _has_misplaced_bodies, False),
    Check("large_frictions", "large_frictions", _has_friction, False),
    Check("orbits", "orbits", _any("loads", lambda d: d["type"] == "gravity_gradient"), False),
    Check("delayed_inputs", "delayed_inputs", _any("signals", lambda d: d["type"] == "delay"), False),
)

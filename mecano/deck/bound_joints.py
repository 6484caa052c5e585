"""Warnings about joints that bind: each leaves two bodies some motion, but all between the same bodies leave none.

A body that moves by v + w x (x - o) relative to another one is held by a joint along and about some of its axes mu_i:
mu_i . (v + w x r) = 0 with r from o to its second node, and mu_i . w = 0. The bodies can move if these rows of all
joints between them have a rank below six. Lines of hinges that miss each other by a rounded number therefore bind, too:
a rigid body has no play.
"""

from collections.abc import Iterator, Mapping
from math import atan2
from typing import NamedTuple

import numpy as np

from mecano.constraints.pair import AXES
from mecano.constraints.triads import triad
from mecano.deck.physics import own_nodes
from mecano.deck.turning_axes import OTHER_AXIS, bodies
from mecano.deck.wording import quoted
from mecano.element_interface import Kind, nothing
from mecano.errors import LocatedWarning, name_list
from mecano.model.model import GROUND
from mecano.schema import Values

RANK = 1e-9  # least singular value of six independent rows, as in the search for redundant constraints
NEARLY = 0.1  # least singular value beyond which flexible parts are held as in a frame, and not by an error
MOST_NAMED = 4
NORMAL_TO = {"about_2": 1, "about_1": 0, "about_axis": 2, "along_1": 0, "along_2": 1, "along_axis": 2}
HOLDING, DEFLECTING = "hold them", "let them move only by deformation of what lies between them"


class Holding(NamedTuple):
    """A joint: its name and type, the axes that it holds, their triad (3, 3) of rows mu_i, the position of its node b.

    ``lined`` is False for a joint that has no axis in the deck.
    """

    name: str
    type: str
    lined: bool
    held: tuple[str, ...]
    mu: np.ndarray
    x: np.ndarray


def binding_joints(values: Values, kinds: Mapping[str, Kind]) -> Iterator[LocatedWarning]:
    """Yield (path, text) on the joints between the same two bodies that together hold them, but none of them alone.

    Flexible members and superelements count as bodies if their joints would almost allow a motion.
    """
    held = {
        name: axes for name, d in values["joints"].items() if 0 < len(axes := kinds[d["type"]].holds(d)) < len(AXES)
    }
    if len(held) < 2:
        return
    connections = (
        [_rigidly, _connected] if any(kinds[d["type"]].flexible for d in values["elements"].values()) else [_rigidly]
    )
    rigid, *flexible = (list(_between_bodies(held, values, bodies(values, kinds, one))) for one in connections)
    bound = [(found, HOLDING) for found in rigid if _sixth_value(found) > RANK]
    named = {joint.name for found, _ in bound for joint in found}
    for found in (found for alike in flexible for found in alike):
        if not named & {joint.name for joint in found} and OTHER_AXIS < _sixth_value(found) < NEARLY:
            bound.append((found, DEFLECTING))
    more = f" (and {len(bound) - MOST_NAMED} more pairs of bodies)" if len(bound) > MOST_NAMED else ""
    for i, (found, what) in enumerate(bound[:MOST_NAMED], start=1):
        yield ("joints", found[-1].name), f"{_text(found, what)}{more if i == MOST_NAMED else ''}"


def _between_bodies(held, values, body):
    """Yield the lists of several Holdings between the same two bodies; ``held``: axes of the joints by name."""
    found: dict[frozenset[str], list[str]] = {}
    for name in held:
        found.setdefault(body(values["joints"][name]["nodes"]), []).append(name)
    for pair, names in found.items():
        if len(pair) == 2 and len(names) > 1:
            yield [_holding(name, values["joints"][name], held[name], values["nodes"]) for name in names]


def _holding(name, d, held, nodes):
    """Return the Holding of a joint with checked values ``d``."""
    node = next(node for node in reversed(d["nodes"]) if node != GROUND)
    axis_1 = d.get("axis_1")
    mu = triad(d.get("axis", (0.0, 0.0, 1.0)), None if axis_1 is None else np.array(axis_1))
    return Holding(name, d["type"], "axis" in d, held, mu, np.array(nodes[node]["position"]))


def _sixth_value(joints):
    """Return the sixth singular value of the rows (n, 6) of several joints, with distances relative to the largest."""
    arms = [joint.x - joints[0].x for joint in joints]
    size = max(np.linalg.norm(arm) for arm in arms) or 1.0
    rows = []
    for joint, arm in zip(joints, arms, strict=True):
        for axis in joint.held:
            mu = joint.mu[NORMAL_TO[axis]]
            along = np.hstack([mu, np.cross(arm / size, mu)])
            rows.append(np.hstack([np.zeros(3), mu]) if axis.startswith("about") else along)
    return np.linalg.svd(np.array(rows), compute_uv=False)[5] if len(rows) >= 6 else 0.0


def _rigidly(kind, d, at):
    """Return the pairs of nodes of an element or joint that belong to one rigid body."""
    names = own_nodes(kind, d)
    if kind.section == "elements" and kind.shares is not nothing:  # a rigid body or link
        return [(names[0], name) for name in names[1:]]
    beside = [name for name in names if name != GROUND]
    given = [at[beside[0] if name == GROUND else name] for name in names] if beside and set(beside) <= at.keys() else []
    shared = [(i, j, what) for what, i, j in (kind.shares(d, given) if given else ())]
    return [(names[i], names[j]) for i, j, what in shared if what == "R" and (i, j, "x") in shared]


def _connected(kind, d, at):
    """Return the pairs of nodes of an element or joint that belong to one body, rigid or flexible."""
    names = own_nodes(kind, d)
    if not kind.flexible:
        return _rigidly(kind, d, at)
    return [(names[0], name) for name in names[1:] if GROUND not in (names[0], name)]


def _text(joints, what):
    names = name_list([f"{joint.type} {quoted(joint.name)}" for joint in joints], MOST_NAMED)
    return f"{names} join the same two bodies and bind: each lets them move, together they {what}{_apart(joints)}"


def _apart(joints):
    """Return the words for the directions and places of several joints relative to the first that has an axis."""
    lined = [joint for joint in joints if joint.lined]
    if not lined:
        return ""
    first, others = lined[0], [joint for joint in joints if joint is not lined[0]]
    angle = max((_turned(first, other) for other in lined[1:]), default=0.0)
    found = [(angle, "{:.3g} rad from its direction"), (max(_beside(first, o) for o in others), "{:.3g} m beside it")]
    apart = " and ".join(text.format(size) for size, text in found if size > RANK)
    return f". From the axis of {quoted(first.name)} the others are {apart}; is this intended?"


def _turned(a, b):
    """Return the angle [rad] between the axes of two joints, without their senses."""
    return atan2(float(np.linalg.norm(np.cross(a.mu[2], b.mu[2]))), abs(float(a.mu[2] @ b.mu[2])))


def _beside(a, b):
    """Return the distance [m] of the second joint from the axis of the first."""
    return float(np.linalg.norm(np.cross(a.mu[2], b.x - a.x)))

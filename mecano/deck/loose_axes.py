"""Warnings about angles whose axis nothing holds: a motor or a gear without a bearing, or once it is released."""

from collections.abc import Iterator, Mapping

from mecano.constraints.along_coordinate.demand import is_formula
from mecano.deck.physics import named_joints, own_nodes
from mecano.deck.turning_axes import bodies, turning_together
from mecano.deck.wording import quoted
from mecano.element_interface import SECTIONS, Kind, nothing
from mecano.errors import LocatedWarning, name_list
from mecano.model.model import GROUND
from mecano.schema import Values

POINT = {"along_1", "along_2", "along_axis"}  # axes that hold a point of a body: it may turn about any axis


def loose_axes(values: Values, kinds: Mapping[str, Kind]) -> Iterator[LocatedWarning]:
    """Yield (path, text) on joints that hold angles of bodies which are held at one point, or not at all.

    A body with more joints or members is not judged: two spherical joints are a bearing, too. Those with a release are
    no longer there after it.
    """
    body, at = bodies(values, kinds, turning_together), _around(values, kinds)
    for name, d in values["joints"].items():
        for node in dict.fromkeys(node for *_, pair in kinds[d["type"]].counts_angles(d) for node in pair):
            (one,) = body([node])
            if body([node]) != body([GROUND]) and (held := _loosely_held(at.get(one, []))):
                text = f"{d['type']} {quoted(name)}: node {quoted(node)} can turn about any axis, {held}"
                yield ("joints", name), f"{text}; the joint holds the angle about its axis alone: is a hinge missing?"
                break


def _around(values, kinds):
    """Return {body: [(name, whether it holds a point only, whether it has a release)]} of joints and members."""
    body = bodies(values, kinds, turning_together)
    at: dict[str, list[tuple[str, bool, bool]]] = {}
    for section in SECTIONS[:2]:
        for name, d in values[section].items():
            kind, names = kinds[d["type"]], own_nodes(kinds[d["type"]], d)
            if kind.counts_angles is nothing and len(names) > 1 and "attached" not in d:
                point = set(kind.holds(d)) == POINT
                for one in body(names):
                    at.setdefault(one, []).append((name, point, bool(d.get("release"))))
    return at


def _loosely_held(found):
    """Return the words for joints and members that hold a body loosely, or do so after a release; "" for others."""
    lasting = [one for one in found if not one[2]]
    if len(lasting) > 1 or not all(point for _, point, _ in lasting):
        return ""
    if len(lasting) < len(found):
        return f"once {name_list([quoted(name) for name, _, released in found if released], 3)} is released"
    return f"as only {quoted(found[0][0])} holds it, at a point" if found else "as no joint or member holds it"


def loose_followers(values: Values, kinds: Mapping[str, Kind]) -> Iterator[LocatedWarning]:
    """Yield (path, text) on followers that may leave the plane of their curve, and that nothing else holds."""
    body, at = bodies(values, kinds, turning_together), _around(values, kinds)
    for name, d in values["joints"].items():
        if d.get("across") != "free" or (node := d["nodes"][1]) == GROUND:
            continue
        (one,) = body([node])
        if len(at[one]) == 1:
            text = f"nothing but {quoted(name)} holds node {quoted(node)}, which may leave the plane of the curve"
            text = f"{d['type']} {quoted(name)}: {text}; is a guide missing, or 'across: held'?"
            yield ("joints", name, "across"), text


def acting_on_released(values: Values, kinds: Mapping[str, Kind]) -> Iterator[LocatedWarning]:
    """Yield (path, text) on joints and loads along coordinates of joints that are released, which they outlast.

    The formula of a load may end with the joint, and is not judged.
    """
    names = {id(d): name for name, d in values["joints"].items()}
    for section in ("joints", "loads"):
        for name, d in values[section].items():
            for joint in named_joints(kinds[d["type"]], d):
                if joint.get("release") and not is_formula(d.get("value")):
                    of = f"{joint['type']} {quoted(names[id(joint)])}"
                    end = "; let its value become zero then" if section == "loads" else ""
                    yield (section, name), f"{d['type']} {quoted(name)}: it acts on after the release of {of}{end}"

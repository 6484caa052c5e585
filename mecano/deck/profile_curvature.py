"""Check of grounds for hollows that are too narrow for the wheels that roll on them."""

import math
from collections.abc import Container
from typing import TYPE_CHECKING

import numpy as np

from mecano.constraints.profile_curvature import tightest_concave_stretch
from mecano.deck.error_location import pointed_at
from mecano.deck.wording import quoted
from mecano.schema import GROUND, Values

if TYPE_CHECKING:
    from mecano.deck.compose import Node
    from mecano.deck.physics import Poses
    from mecano.deck.scope import Scope


def check_profile_curvature(
    values: Values, at: "Poses", sound: Container[tuple[str, str]], root: "Node", scope: "Scope"
) -> None:
    """Report each ground with a hollow that is narrower than a wheel; ``at``: poses of the nodes by name.

    Wheels with other errors, whose ("elements", name) is not in ``sound``, are skipped.
    """
    kinds = {type_: scope.kinds[type_] for type_ in {d["type"] for d in values["elements"].values()}}
    wheels = {name for name, kind in kinds.items() if any(field.type is GROUND for field in kind.fields)}
    noted, way = set(), _way(values)
    for name, d in values["elements"].items():
        if d["type"] not in wheels or ("elements", name) not in sound:
            continue
        if not d["ground"]["profile"] or id(d["ground"]) in noted:
            continue
        radius = d.get("tire_law", d)["radius"]
        with np.errstate(all="ignore"):
            stretch = tightest_concave_stretch(d["ground"], at[d["node"]][0], d["axis"], radius, way)
        if stretch:
            noted.add(id(d["ground"]))
            scope.subject = f"{d['type']} {quoted(name)}"
            text, entry = _text(stretch, radius), root.value["elements"][1].value[name]
            scope.refuse(pointed_at(text, kinds[d["type"]], entry, root), text, _hint(stretch, radius))


def _way(values):
    """Return the displacement (3,) [m] of the fastest initial velocity over the duration of the run."""
    initial, time = values["initial"], values["time"]
    given = [entry["velocity"] for entry in initial["velocities"]]
    given += [initial["steady"]["velocity"]] if initial["steady"] and initial["steady"]["velocity"] else []
    duration = time["end"] - time["start"] if time else 0.0
    return duration * np.array(max(given, key=lambda v: float(np.linalg.norm(v)), default=np.zeros(3)), float)


def _text(stretch, radius):
    text = (
        f"'ground.profile.height' has a hollow at {stretch.place:.5g} m whose radius, {stretch.radius:.4g} m, is less "
        f"than that of the wheel, {radius:g} m: the wheel would touch both of its sides, but has only one contact"
    )
    if stretch.count > 1:
        text += f"; so have {stretch.count} hollows between {stretch.low:.5g} and {stretch.high:.5g} m"
    return text


def _hint(stretch, radius):
    """Return the admissible factors: the radii of hollows grow with the square of lengths, and fall with heights."""
    ratio = stretch.radius / radius
    heights, lengths = math.floor(990 * ratio) / 1000, math.ceil(101 / math.sqrt(ratio)) / 100
    return f"multiply heights by {heights:g} or less, or lengths by {lengths:g} or more"

"""Check of grounds for hollows that are too narrow for the wheels that roll on them."""

import math

import numpy as np

from mecano.constraints.hollows import narrowest_hollow
from mecano.deck.pointing import pointed_at
from mecano.deck.wording import quoted
from mecano.schema import GROUND


def check_hollows(values, at, sound, root, scope):
    """Report each ground with a hollow that is narrower than a wheel; ``at``: poses of the nodes by name.

    Wheels with other errors, whose ("elements", name) is not in ``sound``, are skipped.
    """
    wheels = {kind.name for kind in scope.kinds.values() if any(field.type is GROUND for field in kind.fields)}
    told, way = set(), _way(values)
    for name, d in values["elements"].items():
        if d["type"] not in wheels or ("elements", name) not in sound:
            continue
        if not d["ground"]["profile"] or id(d["ground"]) in told:
            continue
        kind, radius = scope.kinds[d["type"]], d.get("tire_law", d)["radius"]
        with np.errstate(all="ignore"):
            hollow = narrowest_hollow(d["ground"], at[d["node"]][0], d["axis"], radius, way)
        if hollow:
            told.add(id(d["ground"]))
            scope.subject = f"{kind.name} {quoted(name)}"
            text, entry = _text(hollow, radius), root.value["elements"][1].value[name]
            scope.refuse(pointed_at(text, kind, entry, root), text, _hint(hollow, radius))


def _way(values):
    """Return the displacement (3,) [m] of the fastest initial velocity over the duration of the run."""
    initial, time = values["initial"], values["time"]
    given = [entry["velocity"] for entry in initial["velocities"]]
    given += [initial["steady"]["velocity"]] if initial["steady"] else []
    duration = time["end"] - time["start"] if time else 0.0
    return duration * np.array(max(given, key=np.linalg.norm, default=np.zeros(3)), float)


def _text(hollow, radius):
    text = (
        f"'ground.profile.height' has a hollow at {hollow.place:.5g} m whose radius, {hollow.radius:.4g} m, is less "
        f"than that of the wheel, {radius:g} m: the wheel would touch both of its sides, but has only one contact"
    )
    if hollow.count > 1:
        text += f"; so have {hollow.count} hollows between {hollow.low:.5g} and {hollow.high:.5g} m"
    return text


def _hint(hollow, radius):
    """Return the admissible factors: the radii of hollows grow with the square of lengths, and fall with heights."""
    ratio = hollow.radius / radius
    heights, lengths = math.floor(990 * ratio) / 1000, math.ceil(101 / math.sqrt(ratio)) / 100
    return f"multiply heights by {heights:g} or less, or lengths by {lengths:g} or more"

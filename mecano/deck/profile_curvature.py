r"""Check of grounds for hollows that are too narrow for the wheels that roll on them, which would touch at two points.

In the plane of an upright wheel that rolls at an angle :math:`\chi` to the profile's direction, the height H(s) of the
profile has the curvature

.. math::  \kappa = \frac{H'' \cos^2\chi}{(1 + H'^2 \cos^2\chi)^{3/2}}

A disc of radius r that touches the profile at one point touches it nowhere else, and is nowhere below it, if
:math:`\kappa r < 1` everywhere: the profile then turns upwards more slowly than the rim. Where :math:`\kappa r > 1` the
disc cannot touch without penetrating the profile nearby, and the point nearest to its centre jumps across.
"""

import math
from collections.abc import Container
from typing import NamedTuple

import numpy as np

from mecano.constraints.ground import in_plane
from mecano.constraints.triads import unit
from mecano.deck.compose import Node
from mecano.deck.error_location import pointed_at
from mecano.deck.physics import Poses
from mecano.deck.scope import Scope
from mecano.deck.wording import quoted
from mecano.laws.probe import shape_of_curve
from mecano.schema import GROUND, Values

ROUNDING = 1e-6  # of 1: a wheel of exactly the radius of curvature is accepted


class ConcaveStretch(NamedTuple):
    """The sharpest of the concave parts that are too narrow for a wheel."""

    place: float  # [m] along the profile
    radius: float  # [m] of its curvature in the plane of the wheel
    number: int  # of such parts
    low: float  # [m] start and
    high: float  # [m] end of the part of the profile that was examined


def check_profile_curvature(
    values: Values, at: Poses, sound: Container[tuple[str, str]], root: Node, scope: Scope
) -> None:
    """Report each ground with a hollow that is narrower than a wheel; ``at``: poses of the nodes by name.

    Wheels with other errors, whose ("elements", name) is not in ``sound``, are skipped.
    """
    kinds = {type_: scope.kinds[type_] for type_ in {d["type"] for d in values["elements"].values()}}
    wheels = {name for name, kind in kinds.items() if any(field.type is GROUND for field in kind.fields)}
    noted, way = set(), _travel(values)
    for name, d in values["elements"].items():
        if d["type"] not in wheels or ("elements", name) not in sound:
            continue
        if not d["ground"]["profile"] or id(d["ground"]) in noted or d.get("tire_law", {}).get("enveloping"):
            continue
        radius = d.get("tire_law", d)["radius"]
        with np.errstate(all="ignore"):
            stretch = _tightest_concave_stretch(d["ground"], at[d["node"]][0], d["axis"], radius, way)
        if stretch:
            noted.add(id(d["ground"]))
            scope.subject = f"{d['type']} {quoted(name)}"
            text, entry = _text(stretch, radius), root.value["elements"][1].value[name]
            scope.refuse(pointed_at(text, kinds[d["type"]], entry, root), text, _hint(stretch, radius))


def _tightest_concave_stretch(ground, x, axis, radius, way):
    """Return the sharpest concave part that is too narrow for a wheel, or None.

    ``ground`` is checked and has a profile; the wheel of that radius [m] has initially its centre at ``x`` (3,) [m] and
    the direction ``axis`` (3,), and travels the ``way`` (3,) [m]: unbounded terms of the profile are examined only
    there.
    """
    plane, profile = ground["plane"], ground["profile"]
    normal = unit(plane["normal"])
    direction = unit(in_plane(profile["direction"], normal))
    cosine = abs(unit(np.cross(axis, normal)) @ direction)
    start, along = direction @ (np.array(x, float) - plane["point"]), direction @ np.array(way, float)
    low, high = start + min(along, 0.0) - radius, start + max(along, 0.0) + radius
    s, values = shape_of_curve(profile["height"], low, high)
    _, slope, bend = values.T
    curvature = cosine**2 * bend / (1.0 + (cosine * slope) ** 2) ** 1.5
    narrow = curvature * radius > 1.0 + ROUNDING
    if not narrow.any():
        return None
    sharpest, begins = int(np.argmax(curvature)), np.diff(narrow.astype(int), prepend=0) > 0
    return ConcaveStretch(s[sharpest], 1.0 / curvature[sharpest], int(begins.sum()), s[0], s[-1])


def _travel(values):
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
    if stretch.number > 1:
        text += f"; there are {stretch.number} such hollows between {stretch.low:.5g} and {stretch.high:.5g} m"
    return text


def _hint(stretch, radius):
    """Return the admissible factors: the radii of hollows grow with the square of lengths, and fall with heights."""
    ratio = stretch.radius / radius
    heights, lengths = math.floor(990 * ratio) / 1000, math.ceil(101 / math.sqrt(ratio)) / 100
    return f"multiply heights by {heights:g} or less, or lengths by {lengths:g} or more"

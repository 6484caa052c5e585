r"""Profile curvature: concave parts of a ground that are too narrow for a wheel, which would touch at two points.

In the plane of an upright wheel that rolls at an angle :math:`\chi` to the profile's direction, the height H(s) of the
profile has the curvature

.. math::  \kappa = \frac{H'' \cos^2\chi}{(1 + H'^2 \cos^2\chi)^{3/2}}

A disc of radius r that touches the profile at one point touches it nowhere else, and is nowhere below it, if
:math:`\kappa r < 1` everywhere: the profile then turns upwards more slowly than the rim. Where :math:`\kappa r > 1` the
disc cannot touch without penetrating the profile nearby, and the point nearest to its centre jumps across.
"""

from typing import NamedTuple

import numpy as np

from mecano.constraints.ground import in_plane
from mecano.constraints.triads import unit
from mecano.laws.probe import shape_of_curve

ROUNDING = 1e-6  # of 1: a wheel of exactly the radius of curvature is accepted


class ConcaveStretch(NamedTuple):
    """The sharpest of the concave parts that are too narrow for a wheel."""

    place: float  # [m] along the profile
    radius: float  # [m] of its curvature in the plane of the wheel
    count: int  # number of such parts
    low: float  # [m] start and
    high: float  # [m] end of the part of the profile that was examined


def tightest_concave_stretch(ground, x, axis, radius, way):
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

"""Rounded treads of tyres: field of the tyre law, its slip law, and the equations, whose contact is in torus.py.

The tyre of a motorcycle is a torus that is pressed into the ground along the normal: its tread has the radius e =
``crown_radius``, seen along the wheel, around a middle circle of the radius R_m = radius - e. As the wheel leans, its
contact C moves across the tread. With the deformation w and the normal n at C of torus.py, and c of a disc
(mecano/maths/surface.py):

    normal force         N = F_r(w, dw/dt)                along n, not in the plane of the wheel
    slip velocity        v_C = (I - n n^T)(v + omega x (C - x))

The moment about the centre, R_m N c x n from the normal force, is the overturning moment of the geometry: about t it is
R_m N s with s of the camber, where a disc has (h/q) N s. The moments of a slip law act about C. The contact rolls on a
circle of the radius R_m + (e - w) q about the axle: the effective rolling radius is that of an upright wheel less
(e - w) (1 - q).
"""

from dataclasses import replace
from functools import cache

from mecano.schema import NUMBER, Field, not_negative

CROWN = Field(
    "crown_radius", NUMBER, "m", "radius of a rounded tread, seen along the wheel; part of 'radius'; the radial force "
    "acts along the normal of the ground", 0.0, not_negative,
)  # fmt: skip


@cache
def crowned_law(law):
    """Return the SlipLaw ``law`` for a wheel with a rounded tread."""
    return replace(law.rounded(law), name=f"{law.name}_crowned", crowned=True)


def crown_of(d):
    """Return the radius [m] of the rounded tread of a wheel from its deck values, or 0."""
    return d["tire_law"].get("crown_radius") or 0.0


def with_crown(sample):
    """Return a sample (values, nodes, phase) of a wheel of 12 m with a rounded tread."""
    values, nodes, phase = sample
    return {**values, "tire_law": {**values["tire_law"], "crown_radius": 3.0}}, nodes, phase

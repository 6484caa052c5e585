r"""Tyres with a rounded tread: a torus that is pressed into the ground along the normal.

The tyre of a motorcycle is a torus: its tread has the radius e = ``crown_radius``, seen along the wheel, around a
middle circle of the radius R_m = radius - e. As the wheel leans, its contact moves across the tread. With the height h
of the centre over a plane with the normal n, and q, c of a disc (mecano/maths/surface.py):

    deformation          w = R_m q + e - h                dw/dt = -n.(v + omega x (C - x))
    contact              C = x + R_m c - (e - w) n,       on the plane below the middle circle
    normal force         N = F_r(w, dw/dt)                along n, not in the plane of the wheel
    slip velocity        v_C = (I - n n^T)(v + omega x (C - x))

The variation of w is -n.(dx + dtheta x R_m c), as that of q is -n.(dtheta x c): the work of N n at C. The moment about
the centre, R_m N c x n from the normal force, is the overturning moment of the geometry: about t it is -R_m N s with s
of the camber, where a disc has -(h/q) N s. The moments of a slip law act about C. The contact rolls on a circle of the
radius R_m + (e - w) q about the axle: the effective rolling radius is that of an upright wheel less (e - w) (1 - q).
"""

from dataclasses import replace
from functools import cache

from mecano.constraints.ground import rim_above
from mecano.jit.kernel import kernel
from mecano.maths.dual import at_least, sqrt
from mecano.maths.surface import LEAST_Q, Contact
from mecano.maths.vector import dot, vec
from mecano.schema import NUMBER, Field, not_negative

CROWN = Field(
    "crown_radius", NUMBER, "m", "radius of a rounded tread, seen along the wheel; part of 'radius'; the radial force "
    "acts along the normal of the ground: wheel, transient_wheel", 0.0, not_negative,
)  # fmt: skip


@cache
def crowned_law(law):
    """Return the SlipLaw ``law`` for a wheel with a rounded tread."""
    return replace(law.rounded(law), name=f"{law.name}_crowned", crowned=True)


def crown_of(d):
    """Return the radius [m] of the rounded tread of a wheel from its deck values, or 0."""
    return d["tire_law"].get("crown_radius") or 0.0


def refuse_crown(d):
    """Return an error for a kind of wheel whose tyre has no rounded tread."""
    return ["'tire_law.crown_radius' is available for the kinds wheel and transient_wheel only"] if crown_of(d) else []


def tread_above(d, ground, x, axis):
    """Return the height [m] of the tread above the ``ground``, as the deformation is counted, and along the normal.

    ``d``: deck values of a wheel; centre ``x`` (3,) [m] and ``axis`` (3,) must have passed ``check_axle``.
    """
    crown = crown_of(d)
    in_plane, along_normal = rim_above(ground, d["tire_law"]["radius"] - crown, x, axis, crown)
    return along_normal if crown else in_plane, along_normal


@kernel
def touch_crown(p, x, a):
    """Return the Contact of a torus of centre ``x`` and unit axis ``a`` with a plane; its r is the radius minus w.

    ``p`` has GROUND_RECORD, whose point is raised by the crown radius, and the ``radius`` [m] with the crown.
    """
    n = vec(p.normal, 0)
    s, above = dot(n, a), dot(n, x - vec(p.point, 0))
    m = n - s * a
    q = at_least(sqrt(dot(m, m)), LEAST_Q)
    c, middle = -m / q, p.radius - p.crown
    w = middle * q - above
    return Contact(n, c, s, q, p.radius - w, middle * c - (p.crown - w) * n)


def with_crown(sample):
    """Return a sample (values, nodes, phase) of a wheel of 12 m with a rounded tread, on a plane."""
    values, nodes, phase = sample
    ground, law = {**values["ground"], "profile": None}, {**values["tire_law"], "crown_radius": 3.0}
    return {**values, "ground": ground, "tire_law": law}, nodes, phase

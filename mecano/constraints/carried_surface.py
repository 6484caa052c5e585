r"""A surface fixed in a body on which a wheel rolls: a plane (ship's deck, treadmill) or a cylinder (drum).

A disc of centre x and unit axis a touches it at C = x + r c, as on a ground at rest (maths/surface.py):

    c = -(n - s a)/q,   s = n.a,   q = sqrt(1 - s^2),   r = h/q

with the normal n towards the wheel and the height h of the centre, both taken at C. For a plane through P0 they are
n and h = n.(x - P0). For a cylinder of radius rho about the axis alpha through P0, with X = x - P0 and the unit vector
e(phi) from the axis, turned by phi from the direction of the centre about alpha,

    n = sigma e,   h = sigma (X.e - rho),   sigma = 1 outside, -1 inside

and C lies on the line of the cylinder along which n is normal: (C - P0).de/dphi = 0, that is

    f(phi) = X.de/dphi + (h s/q^2) a.de/dphi = 0.

phi is zero for an upright wheel. The contact is single inside a drum if rho > r. For a torus (torus.py) the radius of
the middle circle stands for r = h/q.
"""

from types import SimpleNamespace
from typing import NamedTuple

from mecano.constraints.torus import torus_contact
from mecano.constraints.touching import named_surface, surface_point
from mecano.constraints.triads import unit
from mecano.jit.kernel import kernel
from mecano.maths.dual import at_least, cos, implicit, sin, sqrt, value
from mecano.maths.surface import LEAST_Q, disc_contact
from mecano.maths.vector import Vec3, cross, dot, norm
from mecano.schema import BOOLEAN, DIRECTION, NUMBER, POINT, Field, mapping, positive

CARRIED_RECORD = {
    "surface_axis": 3, "surface_origin": 3, "cylindrical": (), "drum_radius": (), "drum_side": (), "drum_curvature": (),
    "crown": (),
}  # fmt: skip
PLANE = mapping(
    Field("normal", DIRECTION, "-", "normal at the start, inertial, towards the wheel"),
    Field("point", POINT, "m", "a point at the start, inertial; the first node when absent", None),
)
CYLINDER = mapping(
    Field("axis", DIRECTION, "-", "axis at the start, inertial"),
    Field("radius", NUMBER, "m", "radius of the drum", check=positive),
    Field("center", POINT, "m", "a point of the axis at the start, inertial; the first node when absent", None),
    Field("inside", BOOLEAN, "-", "whether the wheel rolls on the inner surface", False),
)
FIELDS = (
    Field("plane", PLANE, "-", "plane fixed in the first node", None),
    Field("cylinder", CYLINDER, "-", "infinite cylinder, fixed in the first node", None),
)
LEAST_DISTANCE = 1e-9  # [m] of the centre from the axis of a drum, where the direction to the wheel is not defined
LEAST_SLOPE = 1e-6  # [m] bound of -df/dphi, which is positive where the contact is single
ITERATIONS = 30  # 2 to 5 are usual
LONGEST = 0.3  # [rad] step of the iteration
CONVERGED = 1e-12  # [rad]; the iteration converges quadratically


class Foot(NamedTuple):
    """The equation f(phi) = 0 of the contact with a cylinder, and its terms."""

    f: float  # [m]
    slope: float  # df/dphi [m]
    n: Vec3
    height: float  # h [m]


@kernel
def _lever_of_disc(p, s, s1, q2, height, height1):
    """Return r s/q [m] of a disc, which reaches to the ground, and its derivative by phi, from those of s and h."""
    lever = height * s / q2
    return lever, (height * s1 + height1 * s + 2.0 * lever * s * s1) / q2


@kernel
def _lever_of_torus(p, s, s1, q2, height, height1):
    """Return the same of the middle circle of a torus."""
    middle, q = p.radius - p.crown, sqrt(q2)
    return middle * s / q, middle * s1 / (q2 * q)


def touching_by(lever_of, contact_of):
    """Return the kernel that gives the Contact of a wheel with the surface of a body."""

    @kernel
    def touch_carried(p, x, a, origin, main):
        """Return the Contact of a wheel (centre ``x`` [m], unit axis ``a``) with the surface of record ``p``.

        ``origin`` [m] and ``main``, the normal or the axis, are those of CARRIED_RECORD in inertial axes.
        """
        X = x - origin
        along = dot(main, X)
        if p.cylindrical == 0.0:
            return contact_of(p, main, along, a)
        away = X - along * main
        distance = at_least(norm(away), LEAST_DISTANCE)
        e = away / distance
        ahead = cross(main, e)
        phi = angle(p, value(a), value(e), value(ahead), value(distance))
        now = foot(p, a, e, ahead, distance, phi)
        found = foot(p, a, e, ahead, distance, implicit(phi, now.f, value(now.slope)))
        return contact_of(p, found.n, found.height, a)

    @kernel
    def angle(p, a, e, ahead, distance):
        """Return the angle [rad] from the direction ``e`` of the centre to the contact, by Newton's method."""
        phi, step, i = 0.0, LONGEST, 0
        while abs(step) > CONVERGED and i < ITERATIONS:
            now = foot(p, a, e, ahead, distance, phi)
            step = max(-LONGEST, min(LONGEST, now.f / max(-now.slope, LEAST_SLOPE)))
            phi, i = phi + step, i + 1
        return phi

    @kernel
    def foot(p, a, e, ahead, distance, phi):
        """Return the Foot at the angle ``phi`` of a centre at the ``distance`` [m] along ``e`` from the axis."""
        outward, tangent = cos(phi) * e + sin(phi) * ahead, cos(phi) * ahead - sin(phi) * e
        n = p.drum_side * outward
        height = p.drum_side * (distance * cos(phi) - p.drum_radius)
        s, across = dot(n, a), dot(tangent, a)
        s1, q2 = p.drum_side * across, at_least(1.0 - s * s, LEAST_Q * LEAST_Q)
        lever, lever1 = lever_of(p, s, s1, q2, height, -p.drum_side * distance * sin(phi))
        f = lever * across - distance * sin(phi)
        return Foot(f, lever1 * across - lever * dot(outward, a) - distance * cos(phi), n, height)

    return touch_carried


touch_carried = touching_by(_lever_of_disc, disc_contact)
touch_carried_round = touching_by(_lever_of_torus, torus_contact)


def carried_record(d, nodes):
    """Return the values of CARRIED_RECORD; the first of ``nodes`` carries the surface."""
    (name, values), (x, R) = named_surface(d), nodes[0]
    place, main = _place_at_start(d, nodes)
    side = -1.0 if values.get("inside") else 1.0
    return {
        "surface_axis": R.T @ main, "surface_origin": R.T @ (place - x), "cylindrical": float(name == "cylinder"),
        "drum_radius": values.get("radius", 0.0), "drum_side": side,
        "drum_curvature": side / values["radius"] if name == "cylinder" else 0.0,
        "crown": d["tire_law"].get("crown_radius") or 0.0,
    }  # fmt: skip


def _place_at_start(d, nodes):
    """Return origin [m] and unit normal or axis of the surface at the start, inertial, (3,) each."""
    name, values = named_surface(d)
    return surface_point(values, nodes), unit(values["normal" if name == "plane" else "axis"])


def contact_at_start(d, nodes, axis):
    """Return the Contact at the start of a wheel of the unit ``axis`` (3,), inertial, around the second node."""
    p = SimpleNamespace(radius=d["tire_law"]["radius"], **carried_record(d, nodes))
    touch = touch_carried_round if p.crown else touch_carried
    return touch(p, *(Vec3(*map(float, one)) for one in (nodes[1][0], axis, *_place_at_start(d, nodes))))

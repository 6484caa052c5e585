r"""Obstacles shorter than the contact of a tyre: the effective plane of two cams that follow the ground.

A tyre swallows a cleat or a cable: its contact bridges what is beside it, and its forces are smoother than the
obstacle. In the tandem model of Zegelaar and Schmeitz (A. Schmeitz, A semi-empirical three-dimensional model of the
pneumatic tyre rolling over arbitrarily uneven road surfaces, TU Delft 2004; Pacejka, Tire and Vehicle Dynamics, 3rd ed.
2012, chapter 10) two equal cams, which do not turn, rest on the ground one behind the other. A cam has the outline
(|x|/a_c)^e + (|z|/b_c)^e = 1; its lowest point, at the distance s along the profile H, has the height

    Z(s) = max over |x| < a_c of {H(s + x) - b_c + b_c (1 - (|x|/a_c)^e)^(1/e)}

Cams at the distance l, a share of the length of the contact, ahead of and behind the axle along the heading t of the
wheel give the effective plane, which takes the place of the ground: below the axle it has the height and the slope

    h = (Z_f + Z_r)/2,   tan beta = (Z_f - Z_r)/l

With a ``contact_width`` there are five cams side by side in front and behind, at the places y across the heading l, for
obstacles met at an angle. The plane has the mean height h, the slope of the means of both rows, and across the heading
the slope of least squares, sum(y Z)/sum(y^2). In the plane of the wheel, at the angle psi to the direction of the
profile, an obstacle is longer: Z is that of the profile H(s + x cos psi), of tables for angles up to 69 degrees.

The wheel stands on this plane with the forces of its tyre law. Z is a table made when the deck is read, so the profile
may have corners and steps. As the plane is not tangent to the path of its height, it moves along its normal when the
wheel rolls on, and exchanges the power N n.V with the wheel, V being the velocity of its point of contact: over an
obstacle it sums up to zero at a constant normal force. A profile that is much longer than the contact has no such
power, and the effective plane is its tangent.
"""

import math
from dataclasses import replace
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np

from mecano.elements.wheels.slip_law import default_values
from mecano.jit.kernel import kernel
from mecano.laws.law_table import breakpoints, curve_and_slope
from mecano.laws.probe import curve_values
from mecano.laws.tabulated import table_law
from mecano.maths.dual import at_least, select, sqrt, value
from mecano.maths.vector import cross, dot, vec
from mecano.schema import NUMBER, Field, mapping, not_negative, positive, share

FINENESS = 200  # points of the path of a cam in a radius: a corner of the path is rounded over two of them
MOST_POINTS = 200_000  # of a path, 300 m for a radius of 0.3 m
ACROSS = np.linspace(-0.5, 0.5, 5)  # places of the cams across the heading, over the width of the contact
ANGLES, RATIO = 12, 1.1  # of the lengths of obstacles in the plane of the wheel, 1/cos psi, for which Z is a table
BEYOND = (0.01, 0.37, 1.3, 17.0)  # [m] places beyond the ends of a profile where it must be level
LEVEL = 1e-9  # slope up to which it is

ENVELOPING = Field(
    "enveloping",
    mapping(
        Field("contact_length", NUMBER, "m", "length of the contact, under the usual load", check=positive),
        Field(
            "contact_width", NUMBER, "m", "width of the contact, for obstacles met at an angle, by five cams "
            "side by side; 0: one cam, which meets all obstacles squarely", 0.0, not_negative,
        ),
        Field("distance", NUMBER, "-", "distance l of the cams, over the length of the contact", 0.8, positive),
        Field("cam_length", NUMBER, "-", "a_c, half length of a cam over the radius of the tyre", 1.0, share),
        Field("cam_height", NUMBER, "-", "b_c, half height of a cam over the radius of the tyre", 1.0, positive),
        Field("cam_exponent", NUMBER, "-", "exponent e of the outline of a cam", 1.8, positive),
    ),
    "-", "obstacles shorter than the contact, on a ground with a 'profile'; for wheel and transient_wheel", None,
)  # fmt: skip


@cache
def enveloping_law(law, wide):
    """Return the SlipLaw with the forces of ``law`` for a wheel on the effective plane; ``wide``: of rows of cams."""
    across, tables = (ACROSS, ANGLES) if wide else (np.zeros(1), 1)

    def prepare(d, context):
        cams = d["enveloping"]
        places = across * cams["contact_width"]
        return {
            **law.prepare(d, context), "cam_distance": cams["distance"] * cams["contact_length"], "across": places,
            "spread": 2.0 * places @ places or 1.0,
        }  # fmt: skip

    own = {"cam_distance": (), "spread": (), "across": (len(across),), "paths": (tables,)}
    name, plane = ("_crossing", CROSSING) if wide else ("_enveloping", SQUARE)
    return replace(law, name=law.name + name, record={**law.record, **own}, prepare=prepare, plane=plane)


def check_enveloping(d):
    """Return errors in the ground of a wheel whose tyre law has cams, from its deck values."""
    profile = d["ground"].get("profile")
    if d["tire_law"].get("enveloping") is None or not profile:
        return []
    s = breakpoints(profile["height"])
    beyond = np.array([place for x in BEYOND for place in (s[0] - x, s[-1] + x)]) if s else np.zeros(1)
    if not s or np.abs(curve_values(profile["height"], beyond)[:, 1]).max() > LEVEL:
        return [
            "'ground.profile.height' must be level before its first and beyond its last obstacle, as tables and bumps "
            "are, for a tyre with 'enveloping'"
        ]
    radius = d["tire_law"]["radius"]
    points = (s[-1] - s[0]) / radius * FINENESS
    most = MOST_POINTS / (ANGLES if d["tire_law"]["enveloping"]["contact_width"] else 1)
    if points > most:
        longest = most / FINENESS * radius
        return [
            f"'ground.profile.height' is {s[-1] - s[0]:.4g} m long; for a tyre with 'enveloping' of this radius, "
            f"at most {longest:.4g} m are possible"
        ]
    return []


def refuse_enveloping(d):
    """Return an error for a kind of wheel that has no effective plane."""
    given = d["tire_law"].get("enveloping") is not None
    return ["'tire_law.enveloping' is available for the kinds wheel and transient_wheel only"] if given else []


def ground_of(d):
    """Return the ground of a wheel from its deck values, with the path of a cam as its profile if the tyre has cams."""
    cams, ground = d["tire_law"].get("enveloping"), d["ground"]
    if cams is None or not ground.get("profile"):
        return ground
    height = _kept_path(_Same(ground["profile"]["height"]), tuple(cams.items()), d["tire_law"]["radius"])
    return {**ground, "profile": {**ground["profile"], "height": height}}


def prepare_paths(d, context):
    """Return the starts of the tables of the path of a cam by angles, or nothing for a wheel without cams."""
    cams, profile = d["tire_law"].get("enveloping"), d["ground"].get("profile")
    if cams is None:
        return {}
    stretches = RATIO ** np.arange(ANGLES if cams["contact_width"] else 1)
    if not profile:
        return {"paths": np.zeros(len(stretches))}
    same, shape, radius = _Same(profile["height"]), tuple(cams.items()), d["tire_law"]["radius"]
    return {"paths": [context.laws.add(_kept_path(same, shape, radius, stretch)) for stretch in stretches]}


class _Same:
    """A law that equals itself only: laws are not hashable, and their comparison takes long."""

    def __init__(self, law):
        self.law = law

    def __hash__(self):
        return id(self.law)

    def __eq__(self, other):
        return self.law is other.law


@lru_cache(maxsize=16 * ANGLES)
def _kept_path(same, cams, radius, stretch=1.0):
    """Return the path of a cam as ``cam_path``, of the same law once: checks and wheels ask for it several times."""
    return cam_path(same.law, dict(cams), radius, stretch)


def with_enveloping(sample, width=0.0):
    """Return a sample (values, nodes, phase) of a wheel of 12 m with cams, on a profile with corners."""
    values, nodes, phase = sample
    points = [[-30.0, 0.2], [-4.0, 0.3], [-3.0, 0.9], [2.0, 0.5], [6.0, 0.1], [30.0, 0.4]]
    height = (("table", {"points": points, "interpolation": "linear", "beyond": "hold"}),)
    profile = {**values["ground"]["profile"], "height": height}
    cams = default_values(ENVELOPING.type.options, {"contact_length": 5.0, "contact_width": width})
    return {
        **values, "ground": {**values["ground"], "profile": profile},
        "tire_law": {**values["tire_law"], "enveloping": cams},
    }, nodes, phase  # fmt: skip


def cam_path(law, cams, radius, stretch=1.0):
    """Return the path Z of a cam on a checked profile ``law`` that ends, as a law of one table.

    ``stretch`` >= 1: length of an obstacle in the plane of the wheel over that along the profile.
    """
    corners, step, half = np.array(breakpoints(law)), radius / FINENESS, cams["cam_length"] * radius / stretch
    reach = int(np.ceil(half / step))
    s = corners[0] + step * np.arange(-2 * reach, int(np.ceil((corners[-1] - corners[0]) / step)) + 2 * reach + 1)
    rise = outline(stretch * step * np.arange(-reach, reach + 1), cams, radius)
    H, n = curve_values(law, s)[:, 0], len(s) - 2 * reach
    Z = H[reach : reach + n].copy()
    for i in range(2 * reach + 1):
        np.maximum(Z, H[i : i + n] - rise[i], out=Z)
    s = s[reach : reach + n]
    for corner, height in zip(corners, curve_values(law, corners)[:, 0], strict=True):
        near = slice(*np.searchsorted(s, (corner - half, corner + half)))
        Z[near] = np.maximum(Z[near], height - outline(stretch * (s[near] - corner), cams, radius))
    return table_law(np.column_stack([s, Z]), "hold")


def outline(x, cams, radius):
    """Return the height [m] of the lower side of a cam above its lowest point, at the distances ``x`` (n,) [m]."""
    e, part = cams["cam_exponent"], np.minimum(np.abs(x) / (cams["cam_length"] * radius), 1.0)
    return cams["cam_height"] * radius * (1.0 - (1.0 - part**e) ** (1.0 / e))


class EffectivePlane(NamedTuple):
    """The effective plane of a wheel, of the height h below the axle, with its slopes; ``rate_`` is d/dt."""

    t: tuple  # heading of the wheel, in the plane of the ground
    l: tuple  # n0 x t
    rate_t: tuple
    rate_l: tuple
    above: float  # height of the axle above h [m]
    slope: float  # along t
    across: float  # slope along l
    rate_h: float  # [m/s]
    rate_slope: float
    rate_across: float


@kernel
def squarely(p, laws, s, c):
    """Return Z [m] at s, dZ/ds and dZ/dc of a cam that meets the profile squarely, whatever the cosine c is."""
    Z, Z_s = curve_and_slope(laws, int(p.paths[0]), s)
    return Z, Z_s, 0.0 * s


@kernel
def at_an_angle(p, laws, s, c):
    """Return Z [m] at s, dZ/ds and dZ/dc of a cam that meets the profile at an angle of the cosine c."""
    size = c * select(value(c) < 0.0, -1.0, 1.0)
    longest = RATIO ** (ANGLES - 1)
    stretch = 1.0 / at_least(size, 1.0 / longest)
    i = max(0, min(int(math.log(value(stretch)) / math.log(RATIO)), ANGLES - 2))
    low = math.exp(i * math.log(RATIO))
    Z_0, slope_0 = curve_and_slope(laws, int(p.paths[i]), s)
    Z_1, slope_1 = curve_and_slope(laws, int(p.paths[i + 1]), s)
    share = (stretch - low) / (low * (RATIO - 1.0))
    by_size = (Z_0 - Z_1) / (low * (RATIO - 1.0)) * stretch * stretch
    by_size = select(value(size) * longest > 1.0, by_size, 0.0)
    return Z_0 + share * (Z_1 - Z_0), slope_0 + share * (slope_1 - slope_0), select(value(c) < 0.0, -1.0, 1.0) * by_size


def plane_by(height):
    """Return the kernel that gives the EffectivePlane of a wheel whose cams have the ``height`` (Z, dZ/ds, dZ/dc)."""

    @kernel
    def plane(p, laws, x, a, v, omega):
        """Return it at the centre x and the axis a, with their velocities; p has GROUND_RECORD and that of the cams."""
        n0, d, X = vec(p.normal, 0), vec(p.direction, 0), x - vec(p.point, 0)
        normal, turned = cross(a, n0), cross(cross(omega, a), n0)
        size = sqrt(dot(normal, normal))
        t = normal / size
        t1 = (turned - dot(t, turned) * t) / size
        l, l1 = cross(n0, t), cross(n0, t1)
        s, c, q, half = dot(d, X), dot(d, t), dot(d, l), 0.5 * p.cam_distance
        s1, c1, q1 = dot(d, v), dot(d, t1), dot(d, l1)
        n, zero = len(p.across), 0.0 * s + 0.0 * s1
        h, slope, across, h1, slope1, across1 = zero, zero, zero, zero, zero, zero
        for i in range(2 * n):
            ahead, y = 1.0 if i < n else -1.0, p.across[i % n]
            Z, by_s, by_c = height(p, laws, s + ahead * half * c + y * q, c)
            Z1 = by_s * (s1 + ahead * half * c1 + y * q1) + by_c * c1
            h, slope, across = h + Z, slope + ahead * Z, across + y * Z
            h1, slope1, across1 = h1 + Z1, slope1 + ahead * Z1, across1 + y * Z1
        mean, along = 0.5 / n, 1.0 / (n * p.cam_distance)
        return EffectivePlane(
            t, l, t1, l1, dot(n0, X) - mean * h, along * slope, across / p.spread, mean * h1, along * slope1,
            across1 / p.spread,
        )  # fmt: skip

    return plane


SQUARE, CROSSING = plane_by(squarely), plane_by(at_an_angle)


def contact_with(contact_of):
    """Return the kernel that gives the Contact of a wheel of the axis a with its EffectivePlane ``e``.

    ``contact_of(p, n, height, a)`` is that of its tread with a plane.
    """

    @kernel
    def contact(p, e, a):
        length = sqrt(1.0 + e.slope * e.slope + e.across * e.across)
        n = (vec(p.normal, 0) - e.slope * e.t - e.across * e.l) / length
        return contact_of(p, n, e.above / length, a)

    return contact


@kernel
def rise_of_plane(e, g, v):
    """Return the velocity [m/s] of the EffectivePlane along its normal, at the Contact ``g`` of a wheel.

    The plane holds the points Y with N.(Y - P) = 0, N = n0 - slope t - across l and P below the axle.
    """
    rate_N = e.rate_slope * e.t + e.slope * e.rate_t + e.rate_across * e.l + e.across * e.rate_l
    along = e.rate_h - e.slope * dot(e.t, v) - e.across * dot(e.l, v) + dot(rate_N, g.arm)
    return along / sqrt(1.0 + e.slope * e.slope + e.across * e.across)

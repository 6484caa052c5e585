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

The wheel stands on this plane with the forces of its tyre law. Z is a table made when the deck is read, so the profile
may have corners and steps. As the plane is not tangent to the path of its height, it moves along its normal when the
wheel rolls on, and exchanges the power N n.V with the wheel, V being the velocity of its point of contact: over an
obstacle it sums up to zero at a constant normal force. A profile that is much longer than the contact has no such
power, and the effective plane is its tangent.
"""

from dataclasses import replace
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np

from mecano.elements.wheels.slip_law import default_values
from mecano.jit.kernel import kernel
from mecano.laws.probe import curve_values
from mecano.laws.table import breakpoints, curve_and_slope
from mecano.maths.dual import sqrt
from mecano.maths.surface import disc_contact
from mecano.maths.vector import cross, dot, vec
from mecano.schema import NUMBER, Field, mapping, positive, share

FINENESS = 200  # points of the path of a cam in a radius: a corner of the path is rounded over two of them
MOST_POINTS = 200_000  # of a path, 300 m for a radius of 0.3 m
BEYOND = (0.01, 0.37, 1.3, 17.0)  # [m] places beyond the ends of a profile where it must be level
LEVEL = 1e-9  # slope up to which it is

ENVELOPING = Field(
    "enveloping",
    mapping(
        Field("contact_length", NUMBER, "m", "length of the contact, under the usual load", check=positive),
        Field("distance", NUMBER, "-", "distance l of the cams, over the length of the contact", 0.8, positive),
        Field("cam_length", NUMBER, "-", "a_c, half length of a cam over the radius of the tyre", 1.0, share),
        Field("cam_height", NUMBER, "-", "b_c, half height of a cam over the radius of the tyre", 1.0, positive),
        Field("cam_exponent", NUMBER, "-", "exponent e of the outline of a cam", 1.8, positive),
    ),
    "-", "obstacles shorter than the contact, on a ground with a 'profile': wheel, transient_wheel", None,
)  # fmt: skip


@cache
def enveloping_law(law):
    """Return the SlipLaw with the forces of ``law`` for a wheel on the effective plane."""

    def prepare(d, context):
        cams = d["enveloping"]
        return {**law.prepare(d, context), "cam_distance": cams["distance"] * cams["contact_length"]}

    return replace(
        law, name=f"{law.name}_enveloping", record={**law.record, "cam_distance": ()}, prepare=prepare, enveloping=True
    )


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
    if points > MOST_POINTS:
        longest = MOST_POINTS / FINENESS * radius
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


class _Same:
    """A law that equals itself only: laws are not hashable, and their comparison takes long."""

    def __init__(self, law):
        self.law = law

    def __hash__(self):
        return id(self.law)

    def __eq__(self, other):
        return self.law is other.law


@lru_cache(maxsize=16)
def _kept_path(same, cams, radius):
    """Return the path of a cam as ``cam_path``, of the same law once: checks and wheels ask for it several times."""
    return cam_path(same.law, dict(cams), radius)


def with_enveloping(sample):
    """Return a sample (values, nodes, phase) of a wheel of 12 m with cams, on a profile with corners."""
    values, nodes, phase = sample
    points = [[-30.0, 0.2], [-4.0, 0.3], [-3.0, 0.9], [2.0, 0.5], [6.0, 0.1], [30.0, 0.4]]
    height = (("table", {"points": points, "interpolation": "linear", "beyond": "hold"}),)
    profile = {**values["ground"]["profile"], "height": height}
    cams = default_values(ENVELOPING.type.options, {"contact_length": 5.0})
    return {
        **values, "ground": {**values["ground"], "profile": profile},
        "tire_law": {**values["tire_law"], "enveloping": cams},
    }, nodes, phase  # fmt: skip


def cam_path(law, cams, radius):
    """Return the path Z of a cam on a checked profile ``law`` that ends, as a law of one table."""
    corners, step, half = np.array(breakpoints(law)), radius / FINENESS, cams["cam_length"] * radius
    reach = int(np.ceil(half / step))
    s = corners[0] + step * np.arange(-2 * reach, int(np.ceil((corners[-1] - corners[0]) / step)) + 2 * reach + 1)
    rise = outline(step * np.arange(-reach, reach + 1), cams, radius)
    H, n = curve_values(law, s)[:, 0], len(s) - 2 * reach
    Z = H[reach : reach + n].copy()
    for i in range(2 * reach + 1):
        np.maximum(Z, H[i : i + n] - rise[i], out=Z)
    s = s[reach : reach + n]
    for corner, height in zip(corners, curve_values(law, corners)[:, 0], strict=True):
        near = slice(*np.searchsorted(s, (corner - half, corner + half)))
        Z[near] = np.maximum(Z[near], height - outline(s[near] - corner, cams, radius))
    return (("table", {"points": np.column_stack([s, Z]), "interpolation": "cubic", "beyond": "hold"}),)


def outline(x, cams, radius):
    """Return the height [m] of the lower side of a cam above its lowest point, at the distances ``x`` (n,) [m]."""
    e, part = cams["cam_exponent"], np.minimum(np.abs(x) / (cams["cam_length"] * radius), 1.0)
    return cams["cam_height"] * radius * (1.0 - (1.0 - part**e) ** (1.0 / e))


class Cams(NamedTuple):
    """The two cams of a wheel on a ground with the path of a cam as its profile."""

    t: tuple  # heading of the wheel, in the plane of the ground
    size: float  # |a x n0|
    z: float  # height of the axle above the plane of the ground [m]
    front: tuple  # Z [m] and dZ/ds of the front cam
    rear: tuple  # of the rear one


@kernel
def cams_at(p, laws, x, a):
    """Return the Cams of a wheel with the centre ``x`` and the axis ``a``; ``p`` has GROUND_RECORD, cam_distance."""
    n0, d, X = vec(p.normal, 0), vec(p.direction, 0), x - vec(p.point, 0)
    across = cross(a, n0)
    size = sqrt(dot(across, across))
    t = across / size
    s, half = dot(d, X), 0.5 * p.cam_distance * dot(d, t)
    front, rear = curve_and_slope(laws, p.height, s + half), curve_and_slope(laws, p.height, s - half)
    return Cams(t, size, dot(n0, X), front, rear)


@kernel
def effective_contact(p, laws, x, a):
    """Return the Contact of a wheel with its effective plane, and its Cams."""
    c = cams_at(p, laws, x, a)
    tilt = (c.front[0] - c.rear[0]) / p.cam_distance
    length = sqrt(1.0 + tilt * tilt)
    n = (vec(p.normal, 0) - tilt * c.t) / length
    return disc_contact(n, 0.0 * n, (c.z - 0.5 * (c.front[0] + c.rear[0])) / length, a), c


@kernel
def rise_of_plane(p, c, g, v, a, omega):
    """Return the velocity [m/s] of the effective plane along its normal, at the Contact ``g`` of a wheel.

    The plane holds the points Y with N.(Y - P) = 0, N = n0 - tan(beta) t and P = x + (h - z) n0 below the axle.
    """
    n0, d = vec(p.normal, 0), vec(p.direction, 0)
    turned = cross(cross(omega, a), n0)
    t1 = (turned - dot(c.t, turned) * c.t) / c.size
    s1, half1 = dot(d, v), 0.5 * p.cam_distance * dot(d, t1)
    front1, rear1 = c.front[1] * (s1 + half1), c.rear[1] * (s1 - half1)
    tilt, tilt1 = (c.front[0] - c.rear[0]) / p.cam_distance, (front1 - rear1) / p.cam_distance
    along = 0.5 * (front1 + rear1) - tilt * dot(c.t, v) + dot(tilt1 * c.t + tilt * t1, g.arm)
    return along / sqrt(1.0 + tilt * tilt)

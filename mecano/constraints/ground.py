"""Grounds: a plane, optionally with a profile, on which all kinds of wheels roll.

A checked ground is {"plane": {"point", "normal"}, "profile": {"direction", "height"} or None}: points and vectors
of 3 numbers [m], height a law [m] of the distance [m] from the point along the direction. The maths is in
mecano/maths/surface.py.
"""

import math

import numpy as np

from mecano.constraints.triads import unit
from mecano.element_interface import Output
from mecano.jit.kernel import kernel
from mecano.laws.law_table import breakpoints, evaluate_curve
from mecano.laws.probe import corners, curve_at, jumps
from mecano.maths.dual import chain, implicit, sqrt, value
from mecano.maths.surface import disc_contact, foot_residual, profile_normal
from mecano.maths.vector import dot, vec

GROUND_RECORD = {"point": 3, "normal": 3, "direction": 3, "height": "i", "crown": ()}

LEAST_Q = 0.1  # of |n x a|: below it the wheel lies flat, and its contact runs around the rim
STANDING = 1e-3  # of the radius: a rim initially no farther from the ground stands on it
LEAN = Output(
    "lean", "rad", "angle of the wheel's plane from the ground normal at the contact, right-handed about t",
    geometric=True,
)  # fmt: skip
LYING = "lean", math.acos(LEAST_Q), "lies flat: its axis is along the normal of the ground"
MOST_BENDS = 8
_ITERATIONS = 50  # 3 to 5 are usual; more only far above a concave part whose radius is smaller than the distance
_STEP_END = 1e-11  # of the radius; the iteration converges quadratically


def prepare_ground(ground, context, crown=0.0):
    """Return the values of GROUND_RECORD; without a profile the direction is zero and the law 0.

    ``crown`` [m]: radius of a rounded tread of the wheel, 0 for a disc.
    """
    plane, profile = ground["plane"], ground.get("profile")
    normal = unit(plane["normal"])
    direction = in_plane(profile["direction"], normal) if profile else np.zeros(3)
    return {
        "point": np.array(plane["point"], float),
        "normal": normal,
        "direction": unit(direction) if profile else direction,
        "height": context.laws.add(profile["height"]) if profile else 0,
        "crown": crown,
    }


def check_ground(ground):
    """Return errors in the combination of a ground's values."""
    profile = ground.get("profile")
    if not profile:
        return []
    texts = []
    if np.linalg.norm(in_plane(profile["direction"], unit(ground["plane"]["normal"]))) < 1e-6:
        texts.append("'ground.profile.direction' is along the normal of the plane; it must lie in the plane")
    if places := corners(profile["height"]):
        texts.append(
            f"'ground.profile.height' has a jump or a corner at {places[0]:g} m; a wheel without 'enveloping' needs a "
            "smooth one (a table: 'interpolation: cubic', and flat ends or 'beyond: extend')"
        )
    return texts


def bends(ground):
    """Return the positions of curvature jumps along the profile, ascending, (MOST_BENDS,) [m], padded with inf.

    There the acceleration of a rolling wheel jumps: at the ends of bumps and of smooth edges, but not at the knots of a
    cubic table. If there are more than MOST_BENDS, none is returned.
    """
    profile, found = ground.get("profile"), np.full(MOST_BENDS, math.inf)
    places = [s for s in breakpoints(profile["height"]) if jumps(profile["height"], s)[2]] if profile else []
    if len(places) <= MOST_BENDS:
        found[: len(places)] = places
    return found


def lies_flat(normal, axis):
    """Return whether the axis (3,) of a wheel is along the normal (3,) of the ground: it has no lowest point."""
    return np.linalg.norm(np.cross(unit(normal), unit(axis))) < LEAST_Q


def check_axle(ground, x, axis, clear=np.inf):
    """Return errors in a wheel's initial position: centre ``x`` (3,) [m], direction ``axis`` (3,).

    A wheel whose centre is higher than ``clear`` [m] above the ground may lie flat.
    """
    normal = unit(ground["plane"]["normal"])
    arm = np.asarray(x, float) - ground["plane"]["point"]
    height, profile = normal @ arm, ground.get("profile")
    if profile:
        direction = in_plane(profile["direction"], normal)
        size = np.linalg.norm(direction)
        height -= curve_at(profile["height"], direction @ arm / size)[0] if size > 0.0 else 0.0
    if height <= 0.0:
        shown = ", ".join(f"{component:g}" for component in ground["plane"]["normal"])
        return [f"the wheel's centre is {abs(height):g} m below the ground, on the side away from its normal [{shown}]"]
    if height < clear and lies_flat(normal, axis):
        return ["the wheel lies flat: its axis is along the normal of the ground"]
    return []


def check_crown(radius, crown):
    """Return errors in the ``crown`` radius [m] of the tread of a wheel."""
    return [] if crown < radius else [f"'crown_radius' must be less than the 'radius' of {radius:g} m"]


def too_low(depth, lift, because=""):
    """Return an error for a rim initially ``depth`` [m] below the ground, by ``lift`` [m] along its normal."""
    return (
        f"the rim is {depth:.4g} m below the ground at the start{because}; it just touches with its node "
        f"{lift:.4g} m higher along the normal of the ground"
    )


def end_conditions(d):
    """Return the end condition of a wheel that comes to lie flat, where its contact is undefined."""
    return [LYING]


def in_plane(direction, normal):
    """Return the projection (3,) of a direction onto the plane with this unit normal; not of unit length."""
    direction = unit(direction)
    return direction - (direction @ normal) * normal


@kernel
def lean_of(g):
    """Return LEAN [rad] of a disc at the Contact ``g``."""
    return chain(g.s, math.asin(max(-1.0, min(1.0, value(g.s)))), 1.0 / value(g.q))


@kernel
def along_profile(p, x):
    """Return the distance [m] of the point x (3,) along the profile of the ground with record ``p``."""
    return dot(vec(p.direction, 0), x - vec(p.point, 0))


@kernel
def profile_at(laws, height, sigma):
    """Return height [m], slope [-] and second derivative [1/m] of the profile; the last is not differentiated."""
    H, H1, H2 = evaluate_curve(laws, height, value(sigma))
    return chain(sigma, H, H1), chain(sigma, H1, H2), H2


def touch_on_profile(residual, contact_of):
    """Return the kernel that gives the Contact (surface.py) of a ground with a wheel.

    ``residual(p, n0, d, a, z, delta, H, H1, H2)`` returns what is zero at the contact, and its derivative by ``delta``;
    ``contact_of(p, n, height, a)`` the Contact, from the normal there and the height [m] of the centre above the plane
    through it.
    """

    @kernel
    def place(p, laws, n0, d, a, z, centre):
        """Return the distance [m] along the profile from the centre, at ``centre`` and height ``z``, to the contact."""
        delta, step = 0.0, p.radius
        for i in range(_ITERATIONS + 1):
            H, H1, H2 = evaluate_curve(laws, p.height, centre + delta)
            if p.height == 0 or abs(step) < _STEP_END * p.radius or i == _ITERATIONS:
                break
            r, slope = residual(p, n0, d, a, z, delta, H, H1, H2)
            # far from the ground the slope may vanish or change sign: then take a short step along the residual
            step = r / max(-slope, 0.05)
            step = max(-0.5 * p.radius, min(0.5 * p.radius, step))
            delta += step
        return delta

    @kernel
    def touch(p, laws, x, a):
        """Return the Contact of the ground with record ``p`` and a wheel of centre ``x`` and unit axis ``a``.

        ``p`` has GROUND_RECORD and ``radius`` [m], the undeformed radius, which bounds the steps of the iteration.
        """
        n0, d = vec(p.normal, 0), vec(p.direction, 0)
        X = x - vec(p.point, 0)
        z, centre = dot(n0, X), dot(d, X)
        delta = place(p, laws, n0, d, value(a), value(z), value(centre))
        # evaluate the root again as a function of z, a and the centre
        H, H1, H2 = profile_at(laws, p.height, centre + delta)
        r, slope = residual(p, n0, d, a, z, delta, H, H1, value(H2))
        delta = implicit(delta, r, value(slope))
        H, H1, _ = profile_at(laws, p.height, centre + delta)
        return contact_of(p, profile_normal(n0, d, H1), (z - H + H1 * delta) / sqrt(1.0 + H1 * H1), a)

    return touch


touch = touch_on_profile(foot_residual, disc_contact)


def normal_and_level(rng):
    """Return, for samples, a random unit normal of a ground and a random unit direction perpendicular to it."""
    normal = unit(rng.normal(size=3))
    return normal, unit(np.cross(normal, rng.normal(size=3)))


def slope_below(rng, height=None):
    """Return, for samples, a checked ground 8 m below the origin, its unit normal, and a perpendicular unit direction.

    ``height`` is the law of its profile, if any.
    """
    normal, level = normal_and_level(rng)
    profile = None if height is None else {"direction": rng.normal(size=3), "height": height}
    return {"plane": {"point": -8.0 * normal, "normal": normal}, "profile": profile}, normal, level


def on_the_slope(rng, normal):
    """Return, for samples, the node of a wheel of about 8 m that nearly stands on the ground of ``slope_below``."""
    return [(np.cross(normal, rng.normal(size=3)) + 0.2 * normal, np.eye(3))]

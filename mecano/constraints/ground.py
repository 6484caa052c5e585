"""Grounds: a plane, on which a profile may stand; what every kind of wheel rolls on.

A checked ground is {"plane": {"point", "normal"}, "profile": {"direction", "height"} or None}: points and vectors
of 3 numbers [m], height a law [m] of the distance [m] from the point along the direction. The maths is in
mecano/maths/surface.py.
"""

import math
from types import SimpleNamespace

import numpy as np

from mecano.element_interface import Context, Output
from mecano.jit.kernel import kernel
from mecano.laws.probe import curve_at
from mecano.laws.table import LawTable, breakpoints, evaluate_curve
from mecano.maths.dual import chain, implicit, sqrt, value
from mecano.maths.surface import disc_contact, foot_residual, profile_normal
from mecano.maths.vector import Vec3, dot, vec

GROUND_RECORD = {"point": 3, "normal": 3, "direction": 3, "height": "i"}

LEAST_Q = 0.1  # of |n x a|: a wheel with less lies flat; its contact runs round the rim
STANDING = 1e-3  # of the radius: a rim that is no farther from the ground at the start stands on it
LEAN = Output("lean", "rad", "angle of the wheel's plane from the ground normal at the contact, right-handed about t")
MOST_BENDS = 8
JUMP = 1e-6  # m, -, 1/m: a smaller one is rounding
_ITERATIONS = 50  # 3 to 5 are usual; more only far above a hollow that is narrower than the distance
_STEP_END = 1e-11  # of the radius; the iteration converges quadratically


def prepare_ground(ground, context):
    """Values of GROUND_RECORD; without a profile the direction is any and the law 0."""
    plane, profile = ground["plane"], ground.get("profile")
    normal = unit(plane["normal"])
    direction = in_plane(profile["direction"], normal) if profile else np.zeros(3)
    return {
        "point": np.array(plane["point"], float),
        "normal": normal,
        "direction": unit(direction) if profile else direction,
        "height": int(context.laws.add(profile["height"])) if profile else 0,
    }


def check_ground(ground):
    """Texts on what is wrong with a ground's values taken together."""
    profile = ground.get("profile")
    if not profile:
        return []
    texts = []
    if np.linalg.norm(in_plane(profile["direction"], unit(ground["plane"]["normal"]))) < 1e-6:
        texts.append("'ground.profile.direction' is along the normal of the plane; it must lie in the plane")
    corners = [s for s in breakpoints(profile["height"]) if _jumps(profile["height"], s)[:2].any()]
    if corners:
        texts.append(
            f"'ground.profile.height' has a jump or a corner at {corners[0]:g} m; a wheel needs a smooth one "
            "(a table: 'interpolation: cubic', and ends that run out flat or 'beyond: extend')"
        )
    return texts


def bends(ground):
    """Where along the profile its curvature jumps, ascending, (MOST_BENDS,) [m], inf behind the last.

    There the acceleration of what rolls on it jumps: the ends of bumps and of smooth edges, not the knots of a cubic
    table. Of a profile with more of them none is told.
    """
    profile, found = ground.get("profile"), np.full(MOST_BENDS, math.inf)
    places = [s for s in breakpoints(profile["height"]) if _jumps(profile["height"], s)[2]] if profile else []
    if len(places) <= MOST_BENDS:
        found[: len(places)] = places
    return found


def _jumps(law, s):
    """Whether value [m], slope [-] and second derivative [1/m] of the curve jump at s."""
    step = 1e-9 * (1.0 + abs(s))
    return np.abs(np.subtract(curve_at(law, s + step), curve_at(law, s - step))) > JUMP


def check_axle(ground, x, axis):
    """Texts on what is wrong with a wheel's start: centre ``x`` (3,) [m], direction ``axis`` (3,)."""
    normal = unit(ground["plane"]["normal"])
    if np.linalg.norm(np.cross(normal, unit(axis))) < LEAST_Q:
        return ["the wheel lies flat: its axis is along the normal of the ground"]
    arm = np.asarray(x, float) - ground["plane"]["point"]
    height, profile = normal @ arm, ground.get("profile")
    if profile:
        direction = in_plane(profile["direction"], normal)
        size = np.linalg.norm(direction)
        height -= curve_at(profile["height"], direction @ arm / size)[0] if size > 0.0 else 0.0
    if height <= 0.0:
        return [f"the wheel's centre is {-height:g} m below the ground"]
    return []


def rim_above(ground, radius, x, axis):
    """How far [m] the rim of a wheel is above the ground, less than zero below it: in its own plane, along the normal.

    ``check_axle`` has nothing against the ``ground``, the centre ``x`` (3,) [m] and the direction ``axis`` (3,).
    """
    laws = LawTable()
    p = SimpleNamespace(radius=radius, **prepare_ground(ground, Context(laws, np.zeros(3))))
    g = touch(p, laws.array(), Vec3(*np.array(x, float)), Vec3(*unit(axis)))
    return g.r - radius, (g.r - radius) * g.q


def too_low(depth, lift, because=""):
    """Text on a rim that starts ``depth`` [m] below the ground, and stands on it with its node ``lift`` [m] higher."""
    return (
        f"the rim is {depth:.4g} m below the ground at the start{because}; it just touches with its node "
        f"{lift:.4g} m higher along the normal of the ground"
    )


def ends(d):
    """A run ends where the wheel comes to lie flat: its contact is undefined there."""
    return [("lean", math.acos(LEAST_Q), "lies flat: its axis has come along the normal of the ground")]


def unit(a):
    """The direction (3,) of a vector."""
    a = np.array(a, float)
    return a / np.linalg.norm(a)


def in_plane(direction, normal):
    """The part (3,) of a direction that lies in the plane with this unit normal; not of unit length."""
    direction = unit(direction)
    return direction - (direction @ normal) * normal


@kernel
def lean_of(g):
    """LEAN [rad] of a disc in the Contact ``g``."""
    return math.asin(max(-1.0, min(1.0, g.s)))


@kernel
def along_profile(p, x):
    """Distance [m] of the point x (3,) along the profile of the ground of record ``p``."""
    return dot(vec(p.direction, 0), x - vec(p.point, 0))


@kernel
def touch(p, laws, x, a):
    """Contact (see surface.py) of the ground of record ``p`` and a disc of centre ``x`` and unit axis ``a``.

    ``p`` has GROUND_RECORD and ``radius`` [m], the undeformed one, which bounds the iteration's steps.
    """
    n0, d = vec(p.normal, 0), vec(p.direction, 0)
    X = x - vec(p.point, 0)
    z, centre = dot(n0, X), dot(d, X)
    delta = _foot(p, laws, n0, d, value(a), value(z), value(centre))
    # the root again, as a function of z, a and the centre
    H, H1, H2 = _profile(laws, p.height, centre + delta)
    residual, slope = foot_residual(n0, d, a, z, delta, H, H1, value(H2))
    delta = implicit(delta, residual, value(slope))
    H, H1, H2 = _profile(laws, p.height, centre + delta)
    n, dn = profile_normal(n0, d, H1, H2)
    return disc_contact(n, dn, (z - H + H1 * delta) / sqrt(1.0 + H1 * H1), a)


@kernel
def _profile(laws, height, sigma):
    """Height [m], slope [-] and second derivative [1/m] of the profile; the last without its own slope."""
    H, H1, H2 = evaluate_curve(laws, height, value(sigma))
    return chain(sigma, H, H1), chain(sigma, H1, H2), H2


@kernel
def _foot(p, laws, n0, d, a, z, centre):
    """How far [m] along the profile the contact is from the centre, which stands at ``centre``, ``z`` high."""
    delta, step = 0.0, p.radius
    for i in range(_ITERATIONS + 1):
        H, H1, H2 = evaluate_curve(laws, p.height, centre + delta)
        if p.height == 0 or abs(step) < _STEP_END * p.radius or i == _ITERATIONS:
            break
        residual, slope = foot_residual(n0, d, a, z, delta, H, H1, H2)
        # far from the ground the slope may vanish or change its sign: then a short step along the residual
        step = residual / max(-slope, 0.05)
        step = max(-0.5 * p.radius, min(0.5 * p.radius, step))
        delta += step
    return delta


def normal_and_level(rng):
    """For samples: a random unit normal of a ground and a random unit direction across it."""
    normal = rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    level = np.cross(normal, rng.normal(size=3))
    return normal, level / np.linalg.norm(level)


def slope_below(rng, height=None):
    """For samples: a checked ground 8 m below the origin, its unit normal, a unit direction across that.

    ``height`` is the law of its profile, if it has one.
    """
    normal, level = normal_and_level(rng)
    profile = None if height is None else {"direction": rng.normal(size=3), "height": height}
    return {"plane": {"point": -8.0 * normal, "normal": normal}, "profile": profile}, normal, level


def on_the_slope(rng, normal):
    """For samples: the node of a wheel some 8 m large that nearly stands on the ground of ``slope_below``."""
    return [(np.cross(normal, rng.normal(size=3)) + 0.2 * normal, np.eye(3))]

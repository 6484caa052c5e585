"""Curves that guide a point: an ellipse, a circle or a helix; a spline through points.

Along a circle or a helix s is the length of the curve (equations in point_on_curve.py). A closed spline repeats for any
number of turns; an open one has no curvature at its ends and continues straight beyond them.
"""

import math

import numpy as np

from mecano.jit.kernel import kernel
from mecano.laws.tabulated import interval
from mecano.maths.dual import at_least, at_most, constant, cos, sin, value
from mecano.maths.vector import vec

CURVE_RECORD = {
    "pieces": "i", "table": "i", "length": (), "closed": (),
    "center": 3, "semi_axis_1": 3, "semi_axis_2": 3, "advance": 3,
}  # fmt: skip
SAMPLES = 64  # per turn or piece, to find the nearest point
HALVINGS = 60  # of the interval of two samples: down to round-off
FLAT = 1e-6  # of the size of a curve: permitted distance of its points from a plane
KEYS = ("center", "semi_axis_1", "semi_axis_2", "advance")


@kernel
def curve_at(p, laws, s):
    """Return the place X (3,) [m] at s [m] and its derivative by s, in the axes of the curve."""
    if p.pieces > 0:
        return _spline_at(p, laws, s)
    a, b, h = vec(p.semi_axis_1, 0), vec(p.semi_axis_2, 0), vec(p.advance, 0)
    u = s / p.length
    cosine, sine = cos(u), sin(u)
    return vec(p.center, 0) + cosine * a + sine * b + u * h, (cosine * b - sine * a + h) / p.length


@kernel
def _spline_at(p, laws, s):
    if p.closed > 0.0:
        s = s - p.length * math.floor(value(s) / p.length)
    inside = at_most(at_least(s, 0.0), p.length)
    i = interval(laws, p.table, p.pieces + 1, value(inside))
    u, first = inside - laws[p.table + i], p.table + p.pieces + 1 + 12 * i
    c_0, c_1, c_2, c_3 = vec(laws, first), vec(laws, first + 3), vec(laws, first + 6), vec(laws, first + 9)
    slope = c_1 + u * (2.0 * c_2 + 3.0 * u * c_3)
    return c_0 + u * (c_1 + u * (c_2 + u * c_3)) + (s - inside) * slope, slope


@kernel
def overrun(p, s):
    """Return the distance of s beyond the ends of an open curve [m]; 0 on the curve."""
    if p.pieces == 0 or p.closed > 0.0:
        return constant(0.0, s)
    return at_least(at_least(-s, 0.0), s - p.length)


def prepare_curve(d, frame, x, laws):
    """Return the record of the curve in axes ``frame`` (rows) with origin x (3,); append its table to ``laws``."""
    if d["points"] is None:
        center, a, b, h = _ellipse(d)
        return {
            "center": frame @ (center - x), "semi_axis_1": frame @ a, "semi_axis_2": frame @ b, "advance": frame @ h,
            "length": _length(a, b, h),
        }  # fmt: skip
    spline = _spline(d)
    coefficients = spline.c[::-1].transpose(1, 0, 2) @ frame.T  # of powers 0 to 3 of the distance from each point
    coefficients[:, 0] -= frame @ x
    table = laws.append(spline.x)
    laws.append(coefficients)
    return {"pieces": len(coefficients), "table": table, "length": spline.x[-1], "closed": float(d["closed"])}


def _ellipse(d):
    """Return centre, semi-axes and advance per radian, inertial."""
    center, a, b, h = (np.zeros(3) if d[key] is None else np.array(d[key], float) for key in KEYS)
    return center, a, b, h / (2.0 * math.pi)


def _length(a, b, h):
    return math.sqrt(0.5 * (a @ a + b @ b) + h @ h)


def _places(d):
    """Return the points (n, 3) of the spline; a closed one ends with its first point."""
    places = np.array(d["points"], float)
    return np.concatenate([places, places[:1]]) if d["closed"] else places


def _spline(d):
    from scipy.interpolate import CubicSpline  # not imported for decks without splines

    return CubicSpline(knots(d), _places(d), bc_type="periodic" if d["closed"] else "natural")


def knots(d):
    """Return s [m] at each point (n,) of a spline; the last one is its length."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(_places(d), axis=0), axis=1))])


def nearest(d, x):
    """Return s [m] of the point of the curve with deck values ``d`` nearest to x (3,), inertial, at any distance.

    On an open spline this may be an end; of several equally near points it is the first; on a helix it is searched in
    the turn around x. Between the neighbours of the nearest sample the distance first decreases, then increases, unless
    the curve winds more than once between samples.
    """
    place, slope, grid = _to_search(d, x)
    s, step = min(grid, key=lambda at: np.sum((place(at) - x) ** 2)), grid[1] - grid[0]
    low, high = s - step, s + step
    if has_ends(d):
        low, high = max(low, grid[0]), min(high, grid[-1])
    for _ in range(HALVINGS):
        s = 0.5 * (low + high)
        low, high = (low, s) if (place(s) - x) @ slope(s) > 0.0 else (s, high)
    return s


def has_ends(d):
    """Return True for an open spline."""
    return d["points"] is not None and not d["closed"]


def drawn(d):
    """Return points (n, 3) [m] of the initial curve, inertial; one turn of a helix. ``d`` may lack defaults."""
    d = {"points": None, "closed": False, **dict.fromkeys(KEYS), **d}
    place, _, grid = _to_search(d, np.array(d["center"] if d["points"] is None else d["points"][0], float))
    return np.array([place(s) for s in grid])


def _to_search(d, x):
    """Return X(s), X'(s), and the values of s at which to search for the nearest point."""
    if d["points"] is not None:
        spline = _spline(d)
        return spline, spline.derivative(), np.linspace(0.0, spline.x[-1], 1 + SAMPLES * (len(spline.x) - 1))
    center, a, b, h = _ellipse(d)
    length, turn = _length(a, b, h), h @ (x - center) / (h @ h) if h.any() else 0.0

    def place(s):
        return center + np.cos(s / length) * a + np.sin(s / length) * b + s / length * h

    def slope(s):
        return (np.cos(s / length) * b - np.sin(s / length) * a + h) / length

    return place, slope, length * (turn + np.linspace(-math.pi, math.pi, 1 + SAMPLES))


def normal_of(d):
    """Return the unit normal (3,) of the plane of a curve, inertial; None if there is no such plane, or many."""
    if d["points"] is None:
        normal = np.cross(d["semi_axis_1"], d["semi_axis_2"])
        return normal / np.linalg.norm(normal) if d["advance"] is None or not np.any(d["advance"]) else None
    around = np.array(d["points"], float)
    _, sizes, axes = np.linalg.svd(around - around.mean(axis=0), full_matrices=True)
    flat = len(around) > 2 and sizes[1] > FLAT * sizes[0] and sizes[2] <= FLAT * sizes[0]
    return axes[2] if flat else None


def check_curve(d):
    """Return errors for an invalid guide curve."""
    names = [name for name in KEYS if d[name] is not None]
    if d["points"] is None:
        missing = [name for name in KEYS[:3] if d[name] is None]
        if missing:
            return [f"missing '{missing[0]}'; or give 'points'"]
        across = np.cross(d["semi_axis_1"], d["semi_axis_2"])
        if not np.linalg.norm(across) > FLAT * np.linalg.norm(d["semi_axis_1"]) * np.linalg.norm(d["semi_axis_2"]):
            return ["'semi_axis_2' must not be parallel to 'semi_axis_1', and neither may be zero"]
        return ["'closed' applies to 'points' only"] if d["closed"] else []
    if names:
        return [f"'{names[0]}' and 'points' exclude one another"]
    if len(d["points"]) < 2 + d["closed"]:
        return [f"'points' must contain at least {2 + d['closed']} points"]
    steps = np.linalg.norm(np.diff(_places(d), axis=0), axis=1)
    return ["consecutive 'points' must not coincide"] if not steps.min() > 0.0 else []

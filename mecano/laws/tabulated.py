r"""Table: a curve through given points, monotone cubic, spline or linear between them.

The cubic is the Hermite cubic with the slopes of Fritsch & Butland (SIAM J. Sci. Stat. Comput. 5, 1984), which
satisfies the theorem of Fritsch & Carlson (SIAM J. Numer. Anal. 17, 1980): it is monotone where the points are and
never overshoots. It is C1; its second derivative jumps at the points. The spline is C2 and may overshoot: it is meant
for prescribed motions, whose accelerations must not jump. The linear curve has a corner at every point. Outside the
points the curve holds its last value (a corner, unless the end slope is zero) or continues along its end tangent.
"""

import numpy as np

from mecano.jit.kernel import kernel
from mecano.laws.term import ARGUMENT, VALUE, Term
from mecano.schema import COLUMNS, POINTS, TEXT, UNITS, Field, choice

PARTS = 4  # subdivisions between points that resolve the shape of a table
SEEN = 0.1  # of the range of a table: what steps that end at its landmarks see of it at least
HEAD = 3  # numbers before the points: linear (0 or 1), hold (0 or 1), number of points


@kernel
def interval(a, first, n, s):
    """Return the index j of the interval x_j <= s < x_{j+1} (the last one closed); x_0 = a[first]."""
    low, high = 0, n - 1
    while high - low > 1:
        middle = (low + high) // 2
        if a[first + middle] <= s:
            low = middle
        else:
            high = middle
    return low


@kernel
def piece(a, i, s):
    """Return, for the interval that contains s: its length h, u from 0 to 1 in it, y0, (c1, c2, c3), its index.

    There y = y0 + h (c1 u + c2 u^2 + c3 u^3).
    """
    n = int(a[i + 2])
    x = i + HEAD
    y, d = x + n, x + 2 * n
    j = interval(a, x, n, s)
    h = a[x + j + 1] - a[x + j]
    chord = (a[y + j + 1] - a[y + j]) / h
    d0, d1 = (chord, chord) if a[i] == 1.0 else (a[d + j], a[d + j + 1])
    return h, (s - a[x + j]) / h, a[y + j], (d0, 3.0 * chord - 2.0 * d0 - d1, d0 + d1 - 2.0 * chord), j


@kernel
def end(a, i, s):
    """Return (is s outside, x, y, slope beyond, integral) at the end of the table nearest to s."""
    n = int(a[i + 2])
    x = i + HEAD
    j = n - 1 if s > a[x] else 0
    outside = s < a[x] or s > a[x + n - 1]
    slope = 0.0 if a[i + 1] == 1.0 else a[x + 2 * n + j]
    return outside, a[x + j], a[x + n + j], slope, a[x + 3 * n + j]


@kernel
def table(a, i, s):
    """Return value and derivatives of the Hermite cubic, or of its continuation."""
    outside, x_end, y_end, slope, _ = end(a, i, s)
    if outside:
        return y_end + slope * (s - x_end), slope, 0.0
    h, u, y0, (c1, c2, c3), _ = piece(a, i, s)
    y = y0 + h * u * (c1 + u * (c2 + u * c3))
    return y, c1 + u * (2.0 * c2 + 3.0 * u * c3), (2.0 * c2 + 6.0 * u * c3) / h


@kernel
def table_integral(a, i, s):
    """Return the antiderivative, zero at the first point."""
    outside, x_end, y_end, slope, area = end(a, i, s)
    if outside:
        w = s - x_end
        return area + w * (y_end + 0.5 * slope * w)
    h, u, y0, (c1, c2, c3), j = piece(a, i, s)
    before = a[i + HEAD + 3 * int(a[i + 2]) + j]
    return before + h * u * (y0 + h * u * (c1 / 2.0 + u * (c2 / 3.0 + u * c3 / 4.0)))


def monotone_slopes(x, y):
    """Return the slopes (n,) of the monotone cubic at the points (x, y)."""
    h, chord = np.diff(x), np.diff(y) / np.diff(x)
    if len(x) == 2:
        return np.repeat(chord, 2)
    d = np.zeros(len(x))
    same = chord[:-1] * chord[1:] > 0
    w1, w2 = 2 * h[1:] + h[:-1], h[1:] + 2 * h[:-1]
    m0, m1 = np.where(same, chord[:-1], 1.0), np.where(same, chord[1:], 1.0)
    d[1:-1] = np.where(same, (w1 + w2) / (w1 / m0 + w2 / m1), 0.0)
    d[0] = end_slope(h[0], h[1], chord[0], chord[1])
    d[-1] = end_slope(h[-1], h[-2], chord[-1], chord[-2])
    return d


def spline_slopes(x, y):
    """Return the slopes (n,) of the C2 cubic spline through the points, which is not-a-knot at its ends."""
    from scipy.interpolate import CubicSpline  # slow to import, and not needed by other tables

    return CubicSpline(x, y)(x, 1)


def end_slope(h0, h1, m0, m1):
    """Return the slope at an end from three points, bounded to preserve the shape of the curve."""
    d = ((2 * h0 + h1) * m0 - h0 * m1) / (h0 + h1)
    if np.sign(d) != np.sign(m0):
        return 0.0
    if np.sign(m0) != np.sign(m1) and abs(d) > 3 * abs(m0):
        return 3 * m0
    return d


def pack_points(points, interpolation, beyond):
    """Return the numbers of a table: head, x, y, slopes, areas up to each point."""
    x, y = np.asarray(points, float).T
    h, chord = np.diff(x), np.diff(y) / np.diff(x)
    if interpolation == "linear":
        d, bulge = np.append(chord, chord[-1]), 0.0
    else:
        d = spline_slopes(x, y) if interpolation == "spline" else monotone_slopes(x, y)
        bulge = h**2 / 12 * (d[:-1] - d[1:])
    area = np.concatenate([[0.0], np.cumsum(h * (y[:-1] + y[1:]) / 2 + bulge)])
    return np.concatenate([[interpolation == "linear", beyond == "hold", len(x)], x, y, d, area])


def pack_table(values):
    """Return the numbers of the term."""
    return pack_points(values["points"], values["interpolation"], values["beyond"])


def table_law(points, beyond):
    """Return the checked law that is a monotone cubic through ``points`` [x, y]."""
    read = {"points": points, "file": None, "columns": None, "units": None}
    return (("table", {**read, "interpolation": "cubic", "beyond": beyond}),)


def two_increasing(points):
    """Check that there are at least 2 points [x, y] with strictly increasing x."""
    if points is None:
        return None
    if len(points) < 2:
        return "must hold at least 2 points"
    rising = np.diff(np.asarray(points, float)[:, 0]) > 0.0
    if rising.all():
        return None
    i = int(np.argmin(rising)) + 1
    return f"must have strictly increasing x: point {i + 1} has {points[i][0]} after {points[i - 1][0]}"


def some_points(values):
    """Check that the points are given, in the deck or read from the file."""
    return ["one of 'points' and 'file' must be given"] if values["points"] is None else []


def table_breakpoints(values):
    """Return the corners: every point of a linear table, and the ends of a table that holds its values."""
    x = [float(point[0]) for point in values["points"]]
    inner = x[1:-1] if values["interpolation"] == "linear" else []
    return sorted(inner + ([x[0], x[-1]] if values["beyond"] == "hold" else []))


def held_ends(values):
    """Return the arguments (low, high), or -inf, inf, beyond which the table holds a value that changes up to there."""
    n, numbers = len(values["points"]), pack_table(values)
    x, slopes = numbers[HEAD : HEAD + n], numbers[HEAD + 2 * n : HEAD + 3 * n]
    holds = values["beyond"] == "hold"
    return (float(x[0]) if holds and slopes[0] else -np.inf, float(x[-1]) if holds and slopes[-1] else np.inf)


def table_landmarks(values):
    """Return points of a smooth table between which straight lines follow the others within SEEN of their range.

    They are those of Douglas and Peucker (Cartographica 10, 1973).
    """
    if values["interpolation"] == "linear":
        return []  # its points are corners
    x, y = np.array(values["points"], float).T
    chosen, parts = {0, len(x) - 1}, [(0, len(x) - 1)]
    while parts:
        i, j = parts.pop()
        inner = slice(i + 1, j)
        apart = np.abs(y[inner] - y[i] - (x[inner] - x[i]) * ((y[j] - y[i]) / (x[j] - x[i])))
        if apart.max(initial=0.0) > SEEN * np.ptp(y):
            k = i + 1 + int(apart.argmax())
            chosen.add(k)
            parts += [(i, k), (k, j)]
    return x[sorted(chosen)].tolist()


def shape_of_table(values, low, high):
    """Return both sides of every point, where the second derivative jumps, and points between, where it is linear."""
    x = np.array(values["points"], float)[:, 0]
    between = (x[:-1, None] + np.diff(x)[:, None] * np.arange(1, PARTS) / PARTS).ravel()
    return np.concatenate([np.nextafter(x, -np.inf), x, between])


POINTS_FIELD = Field(
    "points", POINTS, f"{ARGUMENT}, {VALUE}", "points [x, y], x strictly increasing", None, two_increasing
)
FILE_FIELDS = (
    Field("file", TEXT, "-", "CSV file with the columns x and y, in place of 'points'", None),
    Field("columns", COLUMNS, "-", "columns of x and y in the file, if it has more than two", None),
    Field("units", UNITS, "-", "units of the columns, in place of those in the header, as in 'force [kN]'", None),
)
INTERPOLATION = Field(
    "interpolation", choice("cubic", "spline", "linear"), "-",
    "monotone cubic (C1), spline (C2, for prescribed motions) or linear between the points", "cubic",
)  # fmt: skip
BEYOND = Field(
    "beyond", choice("hold", "extend"), "-", "outside the points: hold the last value or extend the end tangent",
    "hold",
)  # fmt: skip

TABLE = Term(
    name="table",
    doc="Curve through given points: monotone cubic (no overshoot), spline (C2) or linear.",
    role="curve",
    fields=(POINTS_FIELD, *FILE_FIELDS, INTERPOLATION, BEYOND),
    pack=pack_table,
    evaluate=table, integral=table_integral, shape=shape_of_table,
    along_line=lambda values, slope, offset: {"points": [[(x - offset) / slope, y] for x, y in values["points"]]},
    check=some_points,
    breakpoints=table_breakpoints,
    landmarks=table_landmarks,
)  # fmt: skip

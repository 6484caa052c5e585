r"""Motion from its measured acceleration: the curve whose second derivative is piecewise linear.

Between the points :math:`(t_i, a_i)` the acceleration is linear, so that the displacement is a cubic, integrated
exactly from :math:`y(t_0) = 0` and :math:`\dot y(t_0) = v_0`. Outside the points the rate is constant. An accelerometer
drifts: with ``end_at_rest``, :math:`c_0 + c_1 (t - t_0)` is subtracted from the acceleration, such that displacement
and rate are zero at the last point (Boore and Bommer, Soil Dyn. Earthq. Eng. 25, 2005, describe such corrections).
"""

import numpy as np

from mecano.jit.kernel import kernel
from mecano.laws.tabulated import FILE_FIELDS, interval, some_points, two_increasing
from mecano.laws.term import ARGUMENT, SLOPE, Term
from mecano.schema import NUMBER, POINTS, Field, choice

TWICE = "unit of the value / unit of the argument^2"
AS_GIVEN, END_AT_REST = "as_given", "end_at_rest"
COLUMNS = 5  # numbers of each point: argument, acceleration, rate, displacement, integral of the displacement


@kernel
def _from(a, i, s):
    """Return s - t_j and, at t_j, acceleration, jerk, rate, displacement and its integral; from j on s is reached."""
    n, first, acceleration, jerk = int(a[i]), i + 1, 0.0, 0.0
    if s < a[first] or s >= a[first + n - 1]:
        j = 0 if s < a[first] else n - 1
    else:
        j = interval(a, first, n, s)
        acceleration = a[first + n + j]
        jerk = (a[first + n + j + 1] - acceleration) / (a[first + j + 1] - a[first + j])
    return s - a[first + j], acceleration, jerk, a[first + 2 * n + j], a[first + 3 * n + j], a[first + 4 * n + j]


@kernel
def motion(a, i, s):
    """Return displacement, rate and acceleration; numbers: count, then the columns of all points."""
    w, acceleration, jerk, rate, y, _ = _from(a, i, s)
    return (
        y + w * (rate + w * (acceleration / 2.0 + w * jerk / 6.0)),
        rate + w * (acceleration + w * jerk / 2.0),
        acceleration + w * jerk,
    )


@kernel
def motion_integral(a, i, s):
    """Return the antiderivative, zero at the first point."""
    w, acceleration, jerk, rate, y, area = _from(a, i, s)
    return area + w * (y + w * (rate / 2.0 + w * (acceleration / 6.0 + w * jerk / 24.0)))


def integrated(t, a, rate):
    """Return rates, displacements and their integrals (n,) at the points of a piecewise linear acceleration."""
    h, jerk = np.diff(t), np.diff(a) / np.diff(t)
    v = rate + np.append(0.0, np.cumsum(h * (a[:-1] + h * jerk / 2.0)))
    y = np.append(0.0, np.cumsum(h * (v[:-1] + h * (a[:-1] / 2.0 + h * jerk / 6.0))))
    area = np.append(0.0, np.cumsum(h * (y[:-1] + h * (v[:-1] / 2.0 + h * (a[:-1] / 6.0 + h * jerk / 24.0)))))
    return v, y, area


def pack(values):
    """Return the numbers of the term."""
    t, a = np.asarray(values["points"], float).T
    a, rate = values["factor"] * a, values["initial_rate"]
    if values["baseline"] == END_AT_REST:
        T, (v, y, _) = t[-1] - t[0], integrated(t, a, rate)
        drift = np.linalg.solve([[T, T * T / 2.0], [T * T / 2.0, T**3 / 6.0]], [v[-1], y[-1]])
        a = a - drift[0] - drift[1] * (t - t[0])
    return np.concatenate([[len(t)], t, a, *integrated(t, a, rate)])


def shape(values, low, high):
    """Return the points, between which the second derivative is linear, and points between."""
    t = np.array(values["points"], float)[:, 0]
    return np.concatenate([np.nextafter(t, -np.inf), t, (t[:-1] + t[1:]) / 2.0])


ACCELERATION = Term(
    name="acceleration",
    doc=(
        "The motion that has this acceleration, linear between the points: the base of a shaker or in an earthquake. "
        "y = 0 at the first point; outside the points the rate is constant."
    ),
    role="curve",
    fields=(
        Field(
            "points", POINTS, f"{ARGUMENT}, {TWICE}", "points [t, acceleration], t strictly increasing", None,
            two_increasing,
        ),
        *FILE_FIELDS,
        Field("factor", NUMBER, "-", "factor on all accelerations: 9.80665 for those in g", 1.0),
        Field("initial_rate", NUMBER, SLOPE, "rate v_0 at the first point", 0.0),
        Field(
            "baseline", choice(AS_GIVEN, END_AT_REST), "-",
            "end_at_rest: subtract the line from the acceleration that makes displacement and rate zero at the last "
            "point", AS_GIVEN,
        ),
    ),
    pack=pack,
    evaluate=motion,
    integral=motion_integral,
    shape=shape,
    along_line=lambda values, slope, offset: {
        "points": [[(t - offset) / slope, a] for t, a in values["points"]],
        "factor": values["factor"] * slope * slope, "initial_rate": values["initial_rate"] * slope,
    },
    check=some_points,
    breakpoints=lambda values: [float(values["points"][0][0]), float(values["points"][-1][0])],
)  # fmt: skip

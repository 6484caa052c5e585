r"""Point on a curve: node b is held on a curve fixed in node a, as a cam guides its follower.

The curve is an ellipse, a circle or a helix, on which s [m] measures the angle, times the radius on a circle,

.. math::  X(s) = c + \cos(s/L)\, a_1 + \sin(s/L)\, a_2 + \frac{s}{2\pi L}\, h, \qquad
           L^2 = \tfrac12 (|a_1|^2 + |a_2|^2) + |h|^2/4\pi^2

or a spline through ``points``, cubic with continuous curvature, on which s adds up the distances of the points; two
points give a straight line. A run ends when b reaches the end of an open spline. The position s is an additional
unknown, so that any number of turns needs no memory. With the axes :math:`\epsilon_i` and the curve fixed in a, and
:math:`d = R_a^T (x_b - x_a)`,

.. math::  \epsilon_i \cdot d - X_i(s) = 0, \qquad i = 1, 2, 3

The multipliers are the components of the force of the curve on b. The equation of s states that this force is normal to
the curve: there is no friction. With ``across: free`` the third axis is the normal of the plane of the curve, along
which b is not held: the curve is the profile of a cam of any width, which avoids redundant constraints in a planar
mechanism.

In the deck, b should be on the curve. If it is not, the assembly starts from the nearest point of the curve, the
first of several equally near; beyond the end of an open spline this is its end.

b is held from both sides, as by a groove. For a roller, give the curve of its centre: for a circular cam, a circle with
the radius increased by that of the roller.
"""

from dataclasses import replace

import numpy as np

from mecano.constraints.augmented_lagrangian import add_reaction
from mecano.constraints.coordinates.coordinate import rate_of
from mecano.constraints.coordinates.slide import slide, slide_gradient
from mecano.constraints.triads import triad
from mecano.element_interface import Display, Kind, Output, Row, named, record
from mecano.elements.joints.guiding_curve import (
    CURVE_RECORD,
    check_curve,
    curve_at,
    has_ends,
    knots,
    nearest,
    normal_of,
    overrun,
    prepare_curve,
)  # fmt: skip
from mecano.jit.kernel import kernel
from mecano.maths.dual import at_most, atan2, constant, number, sqrt
from mecano.maths.vector import dot, mat, norm, put, vec
from mecano.schema import BOOLEAN, NODE_PAIR, POINT, VECTOR, Field, choice, list_of

RECORD = record(axes=(3, 3), rows="i", start=(), **CURVE_RECORD)
S, ROW = 9, 10  # local unknowns after both positions and the rotation of a: s, the first multiplier
ROUNDING = 1e-9  # of the length of an open curve
STILL = 1e-12  # of the speed along the curve: a slower node has no direction of motion


@kernel
def _distance(p, at, X, i):
    """Return the constraint along axis i [m] at the place X of the curve, and its gradient by the nodes."""
    axis = vec(p.axes[i], 0)
    return slide(at, axis)[0] - X[i], slide_gradient(at, axis)


@kernel
def residual(p, at, f):
    """Add forces on both nodes, the moment on the first, the force along the curve."""
    X, slope = curve_at(p, at.laws, number(at.q[S]))
    for i in range(p.rows):
        Phi, along = _distance(p, at, X, i)
        f[S] -= slope[i] * add_reaction(f, at, ROW + i, Phi, along)


@kernel
def constraints(p, at, g):
    """Write value and rate along each axis."""
    X, slope = curve_at(p, at.laws, number(at.q[S]))
    for i in range(p.rows):
        Phi, along = _distance(p, at, X, i)
        g[i, 0], g[i, 1] = Phi, rate_of(along, at.v) - slope[i] * at.v[S]


@kernel
def observe(p, at, F, y, e):
    """Write the position on the curve, the force and the pressure angle."""
    place, rate = number(at.q[S]), number(at.v[S])
    _, slope = curve_at(p, at.laws, place)
    along = norm(slope) * rate
    y[0], y[1], y[2] = place, rate, along
    on_b = constant(0.0, place) * vec(p.axes[0], 0)
    for i in range(p.rows):
        on_b = on_b + number(at.q[ROW + i]) * (mat(at.R[0]) @ vec(p.axes[i], 0))
    put(y, 3, on_b)
    velocity, force = vec(at.v, 6), norm(on_b)
    speed = norm(velocity)
    y[6] = force
    if speed > STILL * abs(along) and force > 0.0:
        cosine = at_most(abs(dot(velocity, on_b)) / (speed * force), 1.0)
        y[7] = atan2(sqrt(1.0 - cosine * cosine), cosine)
    y[8] = overrun(p, place)


def prepare(d, nodes, context):
    """Return axes and curve fixed in a, and the initial position of b on the curve."""
    (x_a, R_a), (x_b, _) = nodes
    frame = triad(normal_of(d)) if d["across"] == "free" else np.eye(3)
    curve = prepare_curve(d, frame, np.asarray(x_a, float), context.laws)
    rows = 2 if d["across"] == "free" else 3
    return {"axes": frame @ R_a, "rows": rows, "start": nearest(d, np.asarray(x_b, float)), **curve}


def check(d, nodes):
    """Check the curve, and that a profile is planar."""
    texts = check_curve(d)
    if not texts and d["across"] == "free" and normal_of(d) is None:
        return [
            "'across' cannot be free: the curve is straight or not plane; for a pin in a straight slot use a generic "
            "joint, with all axes free but the one across the slot"
        ]
    return texts


def end_conditions(d):
    """Return the end condition of an open curve."""
    return [("overrun", ROUNDING * knots(d)[-1], "has reached the end of its curve")] if has_ends(d) else []


def sample(rng):
    """Return a helix, an elliptic profile, an open spline on and beyond its end, a closed profile, a straight line."""
    bare = dict.fromkeys(("points", "center", "semi_axis_1", "semi_axis_2", "advance"))
    first, second, third, center = rng.normal(size=(4, 3))
    ellipse = {**bare, "center": center, "semi_axis_1": first, "semi_axis_2": 2.0 * second}
    bent = [list(center + first * u + second * u * u + third * u**3) for u in (-1.0, -0.3, 0.6, 1.2)]
    flat = [list(center + first * np.cos(u) + second * np.sin(u)) for u in (0.0, 1.5, 3.0, 5.0)]
    cases = (
        {**ellipse, "advance": third},
        {**ellipse, "across": "free"},
        {**bare, "points": bent},
        {**bare, "points": flat, "closed": True, "across": "free"},
        {**bare, "points": bent[:2]},
    )
    nodes = [(rng.normal(size=3), np.diag([-1.0, 1.0, -1.0])), (rng.normal(size=3), np.eye(3))]
    return [(values, nodes, "") for values in cases]


POINT_ON_CURVE = Kind(
    name="point_on_curve", section="joints", doc=__doc__, display=Display("curve", pictures=("curves",), force="force"),
    dtype=RECORD, layout=("x0", "R0", "x1"), scalars=("position",),
    fields=(
        Field("nodes", NODE_PAIR, "-", "node a, in which the curve is fixed, and node b, held on it"),
        Field("center", POINT, "m", "centre of an ellipse, circle or helix at the start, inertial", None),
        Field("semi_axis_1", VECTOR, "m", "from the centre to the point where s = 0; inertial", None),
        Field("semi_axis_2", VECTOR, "m", "the other semi-axis, towards which s increases; inertial", None),
        Field("advance", VECTOR, "m", "advance of a helix per turn; inertial", None),
        Field("points", list_of(POINT), "m", "points of a spline at the start, inertial, instead of an ellipse", None),
        Field("closed", BOOLEAN, "-", "whether the spline continues from the last point to the first", False),
        Field("across", choice("held", "free"), "-", "free: b may leave the plane of the curve", "held"),
    ),
    outputs=(
        Output(
            "position", "m", "s, where b is on the curve; it continues over any number of turns", rate="position_rate"
        ),
        Output("position_rate", "m/s", "rate of s"),
        Output("speed", "m/s", "speed of b along the curve, relative to a"),
        Output("force", "N", "force of the curve on b, inertial", (3,)),
        Output("normal_force", "N", "magnitude of that force, which is normal to the curve"),
        Output(
            "pressure_angle", "rad", "angle between that force and the inertial velocity of b, 0 to pi/2; 0 at rest"
        ),
        Output("overrun", "m", "how far b is beyond the end of an open curve", geometric=True),
    ),
    multipliers=tuple(Row(f"force of the curve along its axis {i}", "N", "m") for i in (1, 2, 3)),
    start=lambda p: (p["start"],),
    variant=lambda d: FLAT if d["across"] == "free" else POINT_ON_CURVE,
    **named(prepare, check, end_conditions, residual, constraints, observe, sample),
)  # fmt: skip
FLAT = replace(POINT_ON_CURVE, multipliers=POINT_ON_CURVE.multipliers[:2])

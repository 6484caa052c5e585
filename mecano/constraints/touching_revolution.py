r"""Touching of a ball around node b and a surface of revolution fixed in node a, such as a drum, a cone or a groove.

The surface has the radius :math:`\rho(z)`, the *profile*, at the distance z along its axis :math:`\alpha` from a point
of the axis. The centre of the ball, at a along the axis and h from it, is nearest to the point of the meridian with

.. math::  z - a + (\rho(z) - h)\,\rho'(z) = 0

There, with the radial direction e of the centre and the radius r of the ball, the normal and the gap are

.. math::  n = s\,\frac{e - \rho'\alpha}{\sqrt{1 + \rho'^2}}, \qquad
           g = s\,\frac{h - \rho - \rho'\,(a - z)}{\sqrt{1 + \rho'^2}} - r

s is 1 outside of the surface and -1 inside. This point is unique, and depends smoothly on the centre, if the ball is
smaller than the radius of curvature of the concave parts of the meridian.
"""

import numpy as np

from mecano.constraints.touching import CENTRED, Shapes, Touch, approach, surface_point, touch_at_start
from mecano.constraints.triads import unit
from mecano.jit.kernel import kernel
from mecano.laws.law_table import curve_and_slope, evaluate_curve
from mecano.laws.probe import corners, curve_at, shape_of_curve
from mecano.maths.dual import at_least, implicit, sqrt, value
from mecano.maths.vector import dot, mat, norm, vec

REVOLUTION_RECORD = {"axis": 3, "origin": 3, "profile": "i", "side": (), "radius": ()}
ITERATIONS = 50  # 1 on a cone, 3 to 5 usually; more only far from concave parts
END = 1e-12  # of the radius of the surface, for the last step; the iteration converges quadratically
LEAST_RISE = 0.05  # of the equation's derivative, which is 1 or more at straight and convex parts
BESIDE = 3.0  # radii of the surface on both sides of the ball, where a profile without ends is examined
ROUNDING = 1e-6  # of 1: a ball of exactly the radius of curvature is accepted


@kernel
def _rise(rho, slope, bend, away):
    """Return the derivative of the equation of the nearest point, bounded where there is none."""
    return max(1.0 + slope * slope + (rho - away) * bend, LEAST_RISE)


@kernel
def _nearest(laws, profile, along, away):
    """Return z [m] of the meridian's point nearest to a centre at ``along`` [m] and ``away`` [m] from the axis."""
    z = along
    for _ in range(ITERATIONS):
        rho, slope, bend = evaluate_curve(laws, profile, z)
        step = (along - z + (away - rho) * slope) / _rise(rho, slope, bend, away)
        most = 0.5 * abs(rho)  # where the profile turns away from the ball, the step would be too long
        step = max(-most, min(most, step))
        z += step
        if abs(step) <= END * abs(rho):
            break
    return z


@kernel
def touch(p, at):
    """Return the Touch of nodes with x0, R0, x1 first among the local unknowns."""
    R, from_a = mat(at.R[0]), vec(at.q, 6) - vec(at.q, 0)
    d, axis = from_a - R @ vec(p.origin, 0), R @ vec(p.axis, 0)
    along = dot(axis, d)
    outwards = d - along * axis
    away = norm(outwards)
    z = _nearest(at.laws, p.profile, value(along), value(away))
    rho, slope, bend = evaluate_curve(at.laws, p.profile, z)
    z = implicit(z, z - along + (rho - away) * slope, _rise(rho, slope, bend, value(away)))
    rho, slope = curve_and_slope(at.laws, p.profile, z)
    shrink = p.side / sqrt(1.0 + slope * slope)
    gap = shrink * (away - rho - slope * (along - z)) - p.radius
    n = shrink * (1.0 / at_least(away, CENTRED) * outwards - slope * axis)
    return Touch(gap, n, from_a - p.radius * n, -p.radius * n)


def revolution_record(d, nodes, context):
    """Return the values of REVOLUTION_RECORD."""
    values, (x_a, R_a) = d["revolution"], nodes[0]
    return {
        "axis": R_a.T @ unit(values["axis"]), "origin": R_a.T @ (surface_point(values, nodes) - x_a),
        "profile": context.laws.add(values["profile"]), "side": _side(values), "radius": d["radius"],
    }  # fmt: skip


def nearest_at_start(d, nodes):
    """Return the distance [m] of the centre of the ball from the surface, and z [m] of its nearest point, at the start.

    The distance is negative on the wrong side.
    """
    values, touched = d["revolution"], touch_at_start(REVOLUTIONS, d, nodes)
    distance = touched.gap + d["radius"]
    point = np.subtract(nodes[1][0], surface_point(values, nodes)) - distance * np.array(touched.n)
    return distance, float(point @ unit(values["axis"]))


def check_revolution(d, nodes):
    """Return errors for a profile with corners or too narrow for the ball, and for a ball on the wrong side."""
    values = d["revolution"]
    if places := corners(values["profile"]):
        return [
            f"'revolution.profile' has a jump or a corner at {places[0]:g} m; a ball needs a smooth one "
            "(a table: 'interpolation: spline' or 'cubic', and flat ends or 'beyond: extend')"
        ]
    distance, z = nearest_at_start(d, nodes)
    radius = curve_at(values["profile"], z)[0]
    if radius <= 0.0:
        return [
            f"'revolution.profile' is {radius:.4g} m at {z:.4g} m, next to node b; a radius must be greater than zero"
        ]
    if distance < 0.0:
        where, wanted = ("outside", "false") if values["inside"] else ("inside", "true")
        return [f"node b is {where} the surface 'revolution': move it, or write 'inside: {wanted}'"]
    return _too_narrow(d, z, BESIDE * radius)


def _too_narrow(d, z, beside):
    """Return an error for a concave part of the profile that is too narrow for the ball."""
    s, values = shape_of_curve(d["revolution"]["profile"], z - beside, z + beside)
    _, slope, bend = values.T
    curvature = _side(d["revolution"]) * bend / (1.0 + slope**2) ** 1.5
    if not len(s) or curvature.max() * d["radius"] <= 1.0 + ROUNDING:
        return []
    place = s[np.argmax(curvature)]
    return [
        f"'revolution.profile' has a hollow at {place:.5g} m whose radius, {1.0 / curvature.max():.4g} m, is less than "
        "that of the ball, which would touch both of its sides, but has only one contact"
    ]


def _side(values):
    return -1.0 if values["inside"] else 1.0


REVOLUTIONS = Shapes("revolution_", touch, approach, False, REVOLUTION_RECORD, revolution_record, check_revolution)

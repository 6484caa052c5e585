r"""Touching of a ball around node b, such as a roller, and a cam fixed in node a: a cylinder over a closed curve.

The curve has the radius :math:`\rho(\varphi)`, the *profile*, at the angle :math:`\varphi` about the axis. With the
radial and the circumferential direction :math:`e_r, e_\varphi` at this angle and the centre d of the ball, from the
axis and across it, the nearest point of the cam is that of

.. math::  \rho'\, d \cdot e_r + \rho\, d \cdot e_\varphi - \rho \rho' = 0

There, with the radius r of the ball, the normal and the gap are

.. math::  n = \frac{\rho\, e_r - \rho'\, e_\varphi}{\sqrt{\rho^2 + \rho'^2}}, \qquad
           g = n \cdot (d - \rho\, e_r) - r

This point is unique, and depends smoothly on the centre, if the ball is smaller than the radius of curvature of the
concave parts of the curve.
"""

import math

import numpy as np

from mecano.constraints.touching import Shapes, Touch, approach, surface_point, touch_at_start
from mecano.constraints.triads import unit
from mecano.jit.kernel import kernel
from mecano.laws.law_table import curve_and_slope, evaluate_curve
from mecano.laws.probe import corners, curve_values, shape_of_curve
from mecano.maths.dual import cos, implicit, sin, sqrt, value
from mecano.maths.vector import dot, mat, vec

CAM_RECORD = {"zero": 3, "quarter": 3, "origin": 3, "profile": "i", "radius": ()}
TURN = 2.0 * math.pi
ITERATIONS = 50  # 3 to 5 usually
END = 1e-13  # [rad] of the last step; the iteration converges quadratically
MOST = 0.3  # [rad] of a step
LEAST_RISE = 0.05  # of the equation's derivative, over that of a circle of the radius
CLOSED = 1e-6  # of the radius: largest difference of radius and slope after a turn
ROUNDING = 1e-6  # of 1: a ball of exactly the radius of curvature is accepted
PROBES = 721  # angles at which the curvature of a profile is checked, besides those of its points


@kernel
def _equation(rho, slope, bend, radial, around):
    """Return the residual of the equation of the nearest point, and its derivative, bounded where there is none."""
    rise = rho * radial + slope * slope + rho * bend - bend * radial - 2.0 * slope * around
    return slope * radial + rho * around - rho * slope, max(rise, LEAST_RISE * rho * rho)


@kernel
def _nearest(laws, profile, x, y):
    """Return the angle in a turn from 0 on of the point of the curve that is nearest to a centre at (x, y) [m]."""
    angle = math.atan2(y, x)
    for _ in range(ITERATIONS):
        angle -= TURN * math.floor(angle / TURN)
        rho, slope, bend = evaluate_curve(laws, profile, angle)
        c, s = math.cos(angle), math.sin(angle)
        residual, rise = _equation(rho, slope, bend, x * c + y * s, y * c - x * s)
        step = max(-MOST, min(MOST, residual / rise))
        angle += step
        if abs(step) <= END:
            break
    return angle


@kernel
def touch(p, at):
    """Return the Touch of nodes with x0, R0, x1 first among the local unknowns."""
    R, from_a = mat(at.R[0]), vec(at.q, 6) - vec(at.q, 0)
    d, zero, quarter = from_a - R @ vec(p.origin, 0), R @ vec(p.zero, 0), R @ vec(p.quarter, 0)
    x, y = dot(zero, d), dot(quarter, d)
    root = _nearest(at.laws, p.profile, value(x), value(y))
    rho, slope, bend = evaluate_curve(at.laws, p.profile, root)
    c, s = math.cos(root), math.sin(root)
    radial, around = c * x + s * y, c * y - s * x
    _, rise = _equation(rho, slope, bend, value(radial), value(around))
    angle = implicit(root, rho * slope - slope * radial - rho * around, rise)
    rho, slope = curve_and_slope(at.laws, p.profile, angle)
    c, s = cos(angle), sin(angle)
    e_r, e_phi = c * zero + s * quarter, c * quarter - s * zero
    n = (rho * e_r - slope * e_phi) / sqrt(rho * rho + slope * slope)
    gap = dot(n, d) - rho * dot(n, e_r) - p.radius
    return Touch(gap, n, from_a - p.radius * n, -p.radius * n)


def cam_record(d, nodes, context):
    """Return the values of CAM_RECORD."""
    values, (x_a, R_a) = d["cam"], nodes[0]
    zero, quarter = _directions(values)
    return {
        "zero": R_a.T @ zero, "quarter": R_a.T @ quarter, "origin": R_a.T @ (surface_point(values, nodes) - x_a),
        "profile": context.laws.add(values["profile"]), "radius": d["radius"],
    }  # fmt: skip


def _directions(values):
    """Return the directions (3,) of the angles 0 and 90 degrees at the start."""
    axis = unit(values["axis"])
    zero = unit(np.array(values["zero"], float) - (axis @ np.array(values["zero"], float)) * axis)
    return zero, np.cross(axis, zero)


def check_cam(d, nodes):
    """Return errors for a profile that is not closed, smooth and positive, or too narrow, and for a ball inside."""
    both = "is less than that of the ball, which would touch both of its sides, but has only one contact"
    if texts := check_cam_for(d, d["radius"], both):
        return texts
    gap = touch_at_start(CAMS, d, nodes).gap
    return ["node b is inside the cam: move it outside"] if gap + d["radius"] < 0.0 else []


def check_cam_for(d, radius, because):
    """Return errors for a cam that a follower of this radius [m] cannot follow, ``because`` of its concave parts."""
    if np.linalg.norm(np.cross(unit(d["cam"]["axis"]), unit(d["cam"]["zero"]))) < ROUNDING:
        return ["'cam.zero' must not be along 'cam.axis': it is a direction across it"]
    return _not_smooth(d["cam"]["profile"]) or _too_narrow(d["cam"]["profile"], radius, because)


def _not_smooth(profile):
    """Return errors for a profile with a jump or a corner, or that does not end as it begins."""
    places = [s for s in corners(profile) if 0.0 < s < TURN]
    if places:
        return [
            f"'cam.profile' has a jump or a corner at {math.degrees(places[0]):g} deg; a follower needs a smooth one "
            "(a table: 'interpolation: spline' or 'cubic')"
        ]
    (start, first, _), (end, last, _) = curve_values(profile, np.array([0.0, TURN])).tolist()
    if max(abs(end - start), abs(last - first)) > CLOSED * abs(start):
        return [
            f"'cam.profile' must be closed: its radius and slope are {start:.6g} m and {first:.6g} m/rad at 0, but "
            f"{end:.6g} m and {last:.6g} m/rad after a turn (360 deg); repeat ten points of a table beyond both ends"
        ]
    return []


def _too_narrow(profile, radius, because):
    """Return errors for radii of the profile that are not positive, or concave parts narrower than this radius."""
    s = np.linspace(0.0, TURN, PROBES)
    s = np.sort(np.append(s, np.clip(shape_of_curve(profile, 0.0, TURN)[0], 0.0, TURN)))
    rho, slope, bend = curve_values(profile, s).T
    if rho.min() <= 0.0:
        angle = math.degrees(s[np.argmin(rho)])
        return [f"'cam.profile' is {rho.min():.4g} m at {angle:.4g} deg; a radius must be greater than zero"]
    hollow = -(rho**2 + 2.0 * slope**2 - rho * bend) / (rho**2 + slope**2) ** 1.5
    if hollow.max() * radius > 1.0 + ROUNDING:
        place = math.degrees(s[np.argmax(hollow)])
        return [f"'cam.profile' has a hollow at {place:.4g} deg whose radius, {1.0 / hollow.max():.4g} m, {because}"]
    return []


CAMS = Shapes("cam_", touch, approach, False, CAM_RECORD, cam_record, check_cam)

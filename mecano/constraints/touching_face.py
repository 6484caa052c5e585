r"""Touching of a flat face fixed in node b and a cam fixed in node a, as in a valve train with flat tappets.

The cam is its curve in the plane through its 'center'. With the direction n from the cam to the face, opposite to
the normal of the face, and its angle :math:`\theta` about the axis of the cam, the point C of the curve that is
farthest along n, its support point, has the angle :math:`\varphi` and gives the gap, with a point F of the face:

.. math::  \varphi - \arctan\frac{\rho'}{\rho} = \theta, \qquad g = n \cdot (x_F - x_C)

The left side grows with :math:`\varphi` if the curve is convex, so this point is unique. As the curve is stationary
there along the face, the rate of the gap is that of the points of the bodies at C.
"""

import math

import numpy as np

from mecano.constraints.touching import Shapes, Touch, approach_of_turning, check_place_on_b, named_surface, origin_on_b
from mecano.constraints.touching_cam import CAM_RECORD, END, ITERATIONS, MOST, ROUNDING, TURN, cam_record, check_cam_for
from mecano.constraints.triads import unit
from mecano.jit.kernel import kernel
from mecano.laws.law_table import curve_and_slope, evaluate_curve
from mecano.maths.dual import atan2, cos, implicit, sin, value
from mecano.maths.vector import dot, mat, vec
from mecano.schema import DIRECTION, POINT, Field, mapping

FACE_RECORD = {**CAM_RECORD, "away": 3, "origin_b": 3}
FACE = Field(
    "face",
    mapping(
        Field("normal", DIRECTION, "-", "normal at the start, inertial, towards the cam"),
        Field("center", POINT, "m", "a point of it at the start, inertial; node b when absent", None),
    ),
    "-", "flat face fixed in node b, instead of a ball; for 'cam'", None,
)  # fmt: skip


@kernel
def _farthest(laws, profile, theta):
    """Return the angle in a turn from 0 on of the point of the curve that is farthest along a direction."""
    angle = theta
    for _ in range(ITERATIONS):
        rho, slope, bend = evaluate_curve(laws, profile, angle - TURN * math.floor(angle / TURN))
        step = (theta - angle + math.atan2(slope, rho)) / _rise(rho, slope, bend)
        step = max(-MOST, min(MOST, step))
        angle += step
        if abs(step) <= END:
            break
    return angle - TURN * math.floor(angle / TURN)


@kernel
def _rise(rho, slope, bend):
    """Return the derivative of phi - arctan(rho'/rho), > 0 of a convex curve."""
    return max((rho * rho + 2.0 * slope * slope - rho * bend) / (rho * rho + slope * slope), ROUNDING)


@kernel
def touch(p, at):
    """Return the Touch of nodes with x0, R0, x1, R1 first among the local unknowns."""
    A, B = mat(at.R[0]), mat(at.R[1])
    n, zero, quarter = B @ vec(p.away, 0), A @ vec(p.zero, 0), A @ vec(p.quarter, 0)
    theta = atan2(dot(n, quarter), dot(n, zero))
    root = _farthest(at.laws, p.profile, value(theta))
    rho, slope, bend = evaluate_curve(at.laws, p.profile, root)
    angle = implicit(root, value(theta) - theta, _rise(rho, slope, bend))
    rho, _ = curve_and_slope(at.laws, p.profile, angle)
    a = A @ vec(p.origin, 0) + rho * (cos(angle) * zero + sin(angle) * quarter)
    b = a - (vec(at.q, 6) - vec(at.q, 0))
    return Touch(dot(n, B @ vec(p.origin_b, 0) - b), n, a, b)


def face_record(d, nodes, context):
    """Return the values of FACE_RECORD."""
    face, (_, R_b) = d["face"], nodes[1]
    return {
        **cam_record(d, nodes, context), "away": -R_b.T @ unit(face["normal"]), "origin_b": origin_on_b(face, nodes)
    }  # fmt: skip


def check_face(d, nodes):
    """Return errors for a face at a surface that is not a convex cam, along its axis, with a radius or no position."""
    if named_surface(d)[0] != "cam":
        return [f"a 'face' touches a 'cam', not a '{named_surface(d)[0]}'"]
    if d["radius"]:
        return ["'radius' is that of a ball or rod; a 'face' has none"]
    if np.linalg.norm(np.cross(unit(d["cam"]["axis"]), unit(d["face"]["normal"]))) < ROUNDING:
        return ["'face.normal' must not be along 'cam.axis'"]
    return check_place_on_b(d, "face") or check_cam_for(d, math.inf, "a face touches convex cams only")


FACES = Shapes("face_", touch, approach_of_turning, True, FACE_RECORD, face_record, check_face)

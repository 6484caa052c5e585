r"""Touching of a plane fixed in node a and an ellipsoid fixed in node b.

The ellipsoid has the semi-axes of the diagonal matrix D along the axes of node b, turned by :math:`R_b`, and its centre
at o in them. With the normal n of the plane and one of its points P, its point nearest to the plane is the one whose
normal is -n, the support point, and the gap is the height of the centre less that of this point:

.. math::  b = R_b \left(o - \frac{D^2 m}{|D m|}\right), \quad m = R_b^T n, \qquad
           g = n \cdot (x_b + R_b o - P) - |D m|

b is the arm from node b to the point. As the ellipsoid is stationary there along the plane, the rate of the gap is that
of the points of the bodies, :math:`\dot g = n \cdot (v_b + \omega_b \times b - v_a - \omega_a \times a)`.
"""

from mecano.constraints.touching import (
    Shapes,
    Touch,
    approach_of_turning,
    check_place_on_b,
    named_surface,
    origin_on_b,
    surface_record,
)
from mecano.jit.kernel import kernel
from mecano.maths.vector import Vec3, dot, mat, norm, vec
from mecano.schema import NODE_VECTOR, POINT, Field, mapping, requirement

ELLIPSOID_RECORD = {"axis": 3, "origin": 3, "origin_b": 3, "semi_axes": 3}
ALL_POSITIVE = requirement(lambda semi_axes: min(semi_axes) > 0.0, "must be greater than zero, each of them")
ELLIPSOID = Field(
    "ellipsoid",
    mapping(
        Field("semi_axes", NODE_VECTOR, "m", "semi-axes along the axes of node b", check=ALL_POSITIVE),
        Field("center", POINT, "m", "centre at the start, inertial; node b when absent", None),
    ),
    "-", "ellipsoid fixed in node b, instead of a ball; for 'plane'", None,
)  # fmt: skip


@kernel
def touch(p, at):
    """Return the Touch of nodes with x0, R0, x1, R1 first among the local unknowns."""
    A, B = mat(at.R[0]), mat(at.R[1])
    n, from_a = A @ vec(p.axis, 0), vec(at.q, 6) - vec(at.q, 0)
    to_center = B @ vec(p.origin_b, 0)
    stretched = _times(p.semi_axes, B.T @ n)
    height = norm(stretched)
    b = to_center - B @ _times(p.semi_axes, stretched) / height
    gap = dot(n, from_a + to_center - A @ vec(p.origin, 0)) - height
    return Touch(gap, n, from_a + b, b)


@kernel
def _times(semi_axes, m):
    """Return D m."""
    return Vec3(semi_axes[0] * m.x, semi_axes[1] * m.y, semi_axes[2] * m.z)


def ellipsoid_record(d, nodes, context=None):
    """Return the values of ELLIPSOID_RECORD."""
    of_a, ellipsoid = surface_record(d, nodes), d["ellipsoid"]
    of_b = {"origin_b": origin_on_b(ellipsoid, nodes), "semi_axes": ellipsoid["semi_axes"]}
    return {"axis": of_a["axis"], "origin": of_a["origin"], **of_b}


def check_ellipsoid(d, nodes):
    """Return errors for an ellipsoid at a surface that is not a plane, with a radius, or without a position."""
    if named_surface(d)[0] != "plane":
        return [f"an 'ellipsoid' touches a 'plane', not a '{named_surface(d)[0]}'"]
    if d["radius"]:
        return ["'radius' is that of a ball or rod; an 'ellipsoid' has 'semi_axes' only"]
    return check_place_on_b(d, "ellipsoid")


ELLIPSOIDS = Shapes("ellipsoid_", touch, approach_of_turning, True, ELLIPSOID_RECORD, ellipsoid_record, check_ellipsoid)

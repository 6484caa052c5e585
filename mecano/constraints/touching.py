r"""Touching of a ball around node b and a surface fixed in node a: a plane, sphere, cylinder or capsule.

With the point o and the axis :math:`\alpha` fixed in a, :math:`d = x_b - x_a - R_a o` and the radius r of the ball, the
gap is

.. math::  g = \alpha \cdot d - r \quad\text{(plane)}, \qquad g = s\,(|e| - \rho) - r, \qquad
           e = d - t\,\alpha, \quad t = \min(\max(\alpha \cdot d, t_0), t_1)

for the surface at the distance :math:`\rho` from a point (sphere, :math:`t_0 = t_1 = 0`), a line (cylinder) or a part
of a line (capsule). s is 1 outside of it and -1 inside (a ball in a bowl, a pin in a hole). The normal n, alpha or
:math:`s\,e/|e|`, points from the surface to the centre of the ball. Forces act at the point
:math:`x_b - r\,n` of the ball, or, where a ball and a convex surface overlap, at the point that divides the distance of
their centres in the ratio of the radii, :math:`x_b - r\,(1 + \min(g, 0)/(r + \rho))\,n`: either of two balls may be the
surface. The rate of the gap is

.. math::  \dot g = n \cdot (v_b - v_a - \omega_a \times (x_b - x_a))
"""

from collections.abc import Callable
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from mecano.constraints.stop_phases import FAR
from mecano.constraints.triads import unit
from mecano.element_interface import Context
from mecano.jit.kernel import kernel
from mecano.laws.law_table import LawTable
from mecano.maths.dual import at_least, at_most
from mecano.maths.vector import Vec3, cross, dot, mat, norm, vec
from mecano.schema import BOOLEAN, CURVE, DIRECTION, NUMBER, POINT, Field, mapping, not_negative, positive

ROUNDING = 1e-9  # [m]: bodies that overlap by less touch
CENTRED = 1e-100  # [m] of the middle of a hole, where there is no normal and no contact
SURFACE_RECORD = {
    "axis": 3, "origin": 3, "planar": (), "side": (), "distance": (), "first": (), "last": (), "radius": ()
}  # fmt: skip
RADIUS = Field("radius", NUMBER, "m", "radius of the surface", check=positive)
INSIDE = Field("inside", BOOLEAN, "-", "whether the ball touches it from inside", False)


def _at(name, what):
    return Field(name, POINT, "m", f"{what} at the start, inertial; node a when absent", None)


PRESSED = 0.01  # of the radius: a node less deep in a surface is pressed into it, not inside it
SURFACES = {
    "plane": mapping(
        Field("normal", DIRECTION, "-", "normal at the start, inertial, towards the ball"), _at("point", "a point")
    ),
    "sphere": mapping(RADIUS, _at("center", "centre"), INSIDE),
    "cylinder": mapping(
        Field("axis", DIRECTION, "-", "axis at the start, inertial"),
        RADIUS,
        _at("center", "a point of the axis"),
        INSIDE,
    ),
    "capsule": mapping(
        Field("axis", DIRECTION, "-", "from the centre of the first end to the other, at the start, inertial"),
        Field("length", NUMBER, "m", "distance of the centres of both ends", check=positive),
        RADIUS,
        _at("center", "centre of the first end"),
    ),
    "revolution": mapping(
        Field("axis", DIRECTION, "-", "axis at the start, inertial"),
        Field(
            "profile", CURVE, "m", "radius of the surface, a curve of the distance [m] along the axis from 'center'",
            argument="m",
        ),
        _at("center", "the point of the axis from which distances are measured"),
        INSIDE,
    ),
    "cam": mapping(
        Field("axis", DIRECTION, "-", "axis at the start, inertial"),
        Field("zero", DIRECTION, "-", "direction of the angle 0 across the axis, at the start, inertial"),
        Field(
            "profile", CURVE, "m", "radius, a curve of the angle [rad] about the axis, from 0 to 2 pi (360 deg)",
            argument="rad",
        ),
        _at("center", "a point of the axis"),
    ),
}  # fmt: skip
FIELDS = (
    Field("plane", SURFACES["plane"], "-", "plane fixed in node a", None),
    Field("sphere", SURFACES["sphere"], "-", "sphere fixed in node a", None),
    Field("cylinder", SURFACES["cylinder"], "-", "infinite cylinder, fixed in node a", None),
    Field("capsule", SURFACES["capsule"], "-", "cylinder with rounded ends, fixed in node a", None),
    Field("revolution", SURFACES["revolution"], "-", "infinite surface of revolution, fixed in node a", None),
    Field("cam", SURFACES["cam"], "-", "cam of any width, a cylinder over a closed curve, fixed in node a", None),
    Field("radius", NUMBER, "m", "radius of the ball around node b", 0.0, not_negative),
)


class Touch(NamedTuple):
    """Gap [m], its normal, and the arms from both nodes to the contact [m], inertial."""

    gap: float
    n: Vec3
    a: Vec3
    b: Vec3


class Shapes(NamedTuple):
    """Two shapes that may touch: their compiled functions, and those that read them from a deck."""

    name: str  # prefix of the names of their kinds
    touch: Callable  # (p, at) -> Touch
    approach: Callable  # (Touch, at) -> rate [m/s] at which the gap closes
    turning: bool  # the shape on b turns with its node
    record: dict  # fields of the record
    values: Callable  # (d, nodes, context) -> their values
    check: Callable  # (d, nodes) -> errors

    @property
    def layout(self):
        """Slots of a contact without friction."""
        return ("x0", "R0", "x1", "R1") if self.turning else ("x0", "R0", "x1")


@kernel
def touch(p, at):
    """Return the Touch of nodes with x0, R0, x1 first among the local unknowns."""
    R, from_a = mat(at.R[0]), vec(at.q, 6) - vec(at.q, 0)
    d, axis = from_a - R @ vec(p.origin, 0), R @ vec(p.axis, 0)
    along = dot(axis, d)
    share = 0.0
    if p.planar > 0.0:
        gap, n = along - p.radius, axis
    else:
        e = d - at_least(at_most(along, p.last), p.first) * axis
        away = norm(e)
        gap, n = p.side * (away - p.distance) - p.radius, p.side / at_least(away, CENTRED) * e
        share = 1.0 / (p.radius + p.distance) if p.side > 0.0 else 0.0
    b = -arm_of_b(p.radius, gap, share) * n
    return Touch(gap, n, from_a + b, b)


@kernel
def arm_of_b(radius, gap, share):
    """Return the distance [m] of the contact from the centre of b; ``share``: of an overlap over that of b's radius."""
    return radius * (1.0 + share * at_most(gap, 0.0))


@kernel
def approach(touched, at):
    """Return the rate [m/s] at which the gap closes."""
    omega = mat(at.R[0]) @ vec(at.v, 3)
    return dot(touched.n, vec(at.v, 0) + cross(omega, touched.a - touched.b) - vec(at.v, 6))


@kernel
def approach_of_turning(touched, at):
    """Return the rate [m/s] at which the gap of a shape that turns with node b closes."""
    return -dot(touched.n, _relative_velocity(touched, at))


@kernel
def sliding(touched, at):
    """Return the velocity [m/s] of the ball relative to the surface at the contact, in the plane of the contact."""
    u = _relative_velocity(touched, at)
    return u - dot(u, touched.n) * touched.n


@kernel
def _relative_velocity(touched, at):
    """Return the velocity [m/s] of b relative to a at the contact, inertial; both turn."""
    of_a = vec(at.v, 0) + cross(mat(at.R[0]) @ vec(at.v, 3), touched.a)
    return vec(at.v, 6) + cross(mat(at.R[1]) @ vec(at.v, 9), touched.b) - of_a


def named_surface(d):
    """Return name and values of the surface, from the values of the deck that name exactly one."""
    return next((name, d[name]) for name in SURFACES if d.get(name) is not None)


def surface_point(values, nodes):
    """Return the point of the surface at the start, inertial (3,), from its deck values."""
    point = next((values[name] for name in ("point", "center") if values.get(name) is not None), nodes[0][0])
    return np.asarray(point, float)


def origin_on_b(shape, nodes):
    """Return the centre (3,) of a shape on node b, in the axes of the node, from its deck values."""
    x_b, R_b = nodes[1]
    center = x_b if shape["center"] is None else np.asarray(shape["center"], float)
    return R_b.T @ (center - x_b)


def check_place_on_b(d, name):
    """Return an error if the shape ``name`` on node b, the ground, has no centre."""
    if d["nodes"][1] == "ground" and d[name]["center"] is None:
        return [f"'{name}' needs 'center': the ground has no position"]
    return []


def surface_record(d, nodes, context=None):
    """Return the values of SURFACE_RECORD."""
    (name, values), (x_a, R_a) = named_surface(d), nodes[0]
    axis = unit(values.get("normal", values.get("axis", (0.0, 0.0, 1.0))))
    last = {"cylinder": FAR, "capsule": values.get("length")}.get(name, 0.0)
    return {
        "axis": R_a.T @ axis, "origin": R_a.T @ (surface_point(values, nodes) - x_a),
        "planar": float(name == "plane"), "side": -1.0 if values.get("inside") else 1.0,
        "distance": values.get("radius", 0.0), "first": -FAR if name == "cylinder" else 0.0, "last": last,
        "radius": d["radius"],
    }  # fmt: skip


def touch_at_start(shapes, d, nodes):
    """Return the Touch of two Shapes at the start."""
    laws, ((x_a, R_a), (x_b, R_b)) = LawTable(), nodes
    p = SimpleNamespace(**shapes.values(d, nodes, Context(laws, np.zeros(3))))
    q = np.concatenate([x_a, np.zeros(3), x_b, np.zeros(3)])
    return shapes.touch(p, SimpleNamespace(q=q, R=(R_a, R_b), laws=laws.array()))


def check_one_surface(d):
    """Return errors for none or several surfaces, and for a surface, ball or wheel of the ground without a position."""
    surfaces = [name for name in SURFACES if name in d]
    if sum(d[name] is not None for name in surfaces) != 1:
        return [f"give exactly one of {', '.join(map(repr, surfaces))}"]
    name, values = named_surface(d)
    place = "point" if name == "plane" else "center"
    if d["nodes"][0] == "ground" and values[place] is None:
        return [f"'{name}' needs '{place}': the ground has no position"]
    if d["nodes"][1] == "ground" and not any(d.get(shape) for shape in ("rod", "ellipsoid", "face")):
        first = f"the node that carries the {name} comes first, as in [ground, {d['nodes'][0]}]"
        return [f"'nodes': node b cannot be the ground, which has no position; {first}"]
    return []


def check_side(d, nodes):
    """Return errors for a ball on the wrong side of a surface other than one of revolution."""
    name, values = named_surface(d)
    if name == "plane":
        return []
    if values.get("inside"):
        small = d["radius"] < values["radius"]
        return [] if small else [f"'radius' of the ball must be less than the radius of the {name} around it"]
    away = touch_at_start(BALL, d, nodes).gap + d["radius"] + values["radius"]
    if away >= (1.0 - PRESSED) * values["radius"] or "inside" not in values:
        return []
    return [
        f"node b is {away:.3g} m from the middle of the {name}, inside it: move it outside, or write 'inside: true'"
    ]


BALL = Shapes("", touch, approach, False, SURFACE_RECORD, surface_record, check_side)

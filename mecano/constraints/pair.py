r"""A pair of nodes held along some of six axes: rigidly, by one multiplier each, or elastically, by one law each.

In the axes :math:`\mu_i` of a and :math:`\xi_i` of b, with :math:`d = R_a^T (x_b - x_a)`: sliding ``along_1``,
``along_2``, ``along_axis`` is :math:`\mu_i \cdot d - c_i`; tilt ``about_1`` is :math:`-\mu_2 \cdot \xi_3`, ``about_2``
is :math:`\mu_1 \cdot \xi_3` (the sines of the angles); ``about_axis`` is the twist. A joint is the list of axes that it
holds; where its deck gives a law for one of them (``compliance``), the law replaces the constraint.
"""

import numpy as np

from mecano.constraints.body_fixed import relative_rotation
from mecano.constraints.coordinates.slide import slide
from mecano.constraints.coordinates.tilt import tilted
from mecano.constraints.coordinates.twist import turned, twist_gradient
from mecano.constraints.of_coordinates import (
    BOTH,
    IN_PLANE,
    ORTHOGONAL,
    SAME_ANGLE,
    SLIDE_LAW,
    TILT_LAW,
    TWIST_LAW,
    law_part,
)
from mecano.constraints.triads import triad, turned_onto
from mecano.element_interface import Part, record
from mecano.jit.kernel import kernel
from mecano.laws.law_table import law_force
from mecano.maths.dual import constant, number, select
from mecano.maths.vector import Vec3, cross, mat, put
from mecano.schema import DIRECTION, LAW, Field, mapping

HELD_BY = {
    "about_2": (ORTHOGONAL, TILT_LAW), "about_1": (ORTHOGONAL, TILT_LAW), "about_axis": (SAME_ANGLE, TWIST_LAW),
    "along_1": (IN_PLANE, SLIDE_LAW), "along_2": (IN_PLANE, SLIDE_LAW), "along_axis": (IN_PLANE, SLIDE_LAW),
}  # fmt: skip
"""For each axis the kind of the constraint that holds it, and that of the law that may replace it."""
AXES = tuple(HELD_BY)
AXES_FIELDS = {"mu": (3, 3), "xi": (3, 3), "start": 3}
"""Fields of a record: axes mu and xi, constants c. Additional fields precede them: numba does not distinguish a record
from another one with the same leading fields."""
AXES_RECORD = record(**AXES_FIELDS)
PAIR_RECORD = record(row=6, law=6, **AXES_FIELDS)
"""For each of ``AXES`` the index of its multiplier in q or -1, and the start of its law in the table or 0; the axes."""
FIRST_ROW = 12
AXIS_1 = Field(
    "axis_1", DIRECTION, "-",
    "direction of mu_1 at the start, inertial, made perpendicular to the axis; when absent, the inertial axis most "
    "perpendicular to it", None,
)  # fmt: skip

AXIS_B = Field("axis_b", DIRECTION, "-", "axis carried by b at the start, inertial, where it differs", None)


def law_fields(axes):
    """Return an optional law field for each of ``axes``."""
    of = {"along": ("force [N] from displacement [m]", "m"), "about": ("moment [N m] from angle [rad]", "rad")}
    return [
        Field(axis, LAW, "-", f"{doc} and rate; none when absent", None, argument=unit)
        for axis, (doc, unit) in ((axis, of[axis[:5]]) for axis in _ordered(axes))
    ]


def compliance_field(axes):
    """Return the field ``compliance`` of a joint that holds ``axes``."""
    doc = "laws that replace rigid constraints: elasticity, damping, free play; 1, 2: mu_1, mu_2"
    return Field("compliance", mapping(*law_fields(axes)), "-", doc, None)


def pair_record(place, axes, compliance, context, first=FIRST_ROW):
    """Return the owner's record for ``place`` {mu, xi, start}, ``axes`` held, and the deck's ``compliance`` or None.

    ``first``: local index of the first multiplier of its parts.
    """
    row, law, next_row = np.full(6, -1), np.zeros(6), first
    for i, axis in enumerate(AXES):
        if given := _law(compliance, axis):
            law[i] = context.laws.add(given)
        elif axis in axes:
            row[i], next_row = next_row, next_row + 1
    return {**place, "row": row, "law": law}


def pair_parts(place, axes, compliance, context):
    """Return one Part for each of the ``axes``, in the order of ``AXES``."""
    return [
        _elastic(axis, place, law, context) if (law := _law(compliance, axis)) else _rigid(axis, place)
        for axis in AXES
        if axis in axes
    ]


def rigid_axes(axes, compliance):
    """Return those of the ``axes`` for which ``compliance``, which may be None, has no law."""
    return tuple(axis for axis in axes if not _law(compliance, axis))


def law_outputs(field, axes):
    """Return ``Kind.optional`` for the laws of the mapping ``field``."""
    return tuple((field, HELD_BY[axis][1], f"_{axis}") for axis in _ordered(axes))


def _ordered(axes):
    """Return the axes in order: sliding, then turning."""
    return sorted(axes, key=lambda axis: (axis.startswith("about"), axis))


def law_parts(place, axes, laws, natural, context):
    """Return [Part] for the laws given for some of the ``axes``, with their set points; both may be None."""
    return [
        _elastic(axis, place, law, context, 0.0 if (point := _law(natural, axis)) is None else point)
        for axis in axes
        if (law := _law(laws, axis))
    ]


def _law(compliance, axis):
    return (compliance or {}).get(axis)


def coordinate_of(axis, place):
    """Return the record's axes and the initial value of the coordinate along one of ``AXES``."""
    mu, xi, start = place["mu"], place["xi"], place["start"]
    if axis == "about_axis":
        return {"mu": mu, "xi": xi}, 0.0
    if axis.startswith("about"):
        return {"mu": mu[0] if axis == "about_2" else mu[1], "xi": xi[2]}, 0.0
    i = ("along_1", "along_2", "along_axis").index(axis)
    return {"mu": mu[i]}, start[i]


def _rigid(axis, place):
    axes, start = coordinate_of(axis, place)
    return Part(HELD_BY[axis][0], BOTH, {**axes, "offset": start})


def _elastic(axis, place, law, context, natural=0.0):
    axes, start = coordinate_of(axis, place)
    if axis == "about_1":  # the angle about mu_1 is -mu_2 . xi_3
        axes["mu"] = -axes["mu"]
    return law_part(HELD_BY[axis][1], axes, law, natural, context, start, label=f"_{axis}")


@kernel
def held(p, at, i, coordinate, rate):
    """Return the reaction on b along the axis with index i in ``AXES``, from its multiplier or law; 0 if it is free."""
    if p.row[i] >= 0.0:
        return constant(0.0, coordinate) + number(at.q[int(p.row[i])])
    return -law_force(at.laws, int(p.law[i]), coordinate, rate)


@kernel
def pair_force(p, at):
    """Return the force of a on b [N] along mu_1, mu_2, mu_3, for a pair with the local unknowns x0, R0, x1, R1."""
    mu = mat(p.mu)
    s_1, v_1 = slide(at, mu[0])
    s_2, v_2 = slide(at, mu[1])
    s_3, v_3 = slide(at, mu[2])
    F_1, F_2 = held(p, at, 3, s_1 - p.start[0], v_1), held(p, at, 4, s_2 - p.start[1], v_2)
    return Vec3(F_1, F_2, held(p, at, 5, s_3 - p.start[2], v_3))


@kernel
def pair_moment(p, at):
    """Return the moment of a on b at node b [N m] about mu_1, mu_2, mu_3.

    Each reaction acts along the gradient of its coordinate with respect to the rotation of b: mu_2 x xi_3, xi_3 x mu_1,
    and that of the twist. They differ from mu_1, mu_2, mu_3 where the axes mu_3 and xi_3 are not aligned.
    """
    mu, xi = mat(p.mu), mat(p.xi)
    tilt_2, rate_2 = tilted(at, mu[0], xi[2])
    # the constraint about_1 is mu_2 . xi_3 = 0; its law acts on the angle -mu_2 . xi_3 about mu_1
    tilt_1, rate_1 = tilted(at, -mu[1], xi[2])
    angle, rate = turned(p, at)
    M_1 = held(p, at, 1, tilt_1, rate_1)
    M_1 = select(p.row[1] >= 0.0, -M_1, M_1)
    M_2, M_3 = held(p, at, 0, tilt_2, rate_2), held(p, at, 2, angle, rate)
    if p.row[0] >= 0.0 and p.row[1] >= 0.0:  # the axes stay aligned
        return Vec3(M_1, M_2, M_3)
    A = relative_rotation(at)
    axis = A @ xi[2]
    M = M_1 * cross(mu[1], axis) + M_2 * cross(axis, mu[0]) - M_3 * twist_gradient(A, mu[2], xi[2])[0]
    return mu @ M


@kernel
def put_reactions(p, at, F, y, i):
    """Write force and moment of a on b, along and about mu_1, mu_2, mu_3, starting at y[i]."""
    put(y, i, pair_force(p, at))
    put(y, i + 3, pair_moment(p, at))


def axis_place(d, nodes, context):
    """Return {mu, xi, start} of a joint whose deck has ``axis`` and ``axis_1``: its ``prepare``."""
    return triads_together(nodes, triad(d["axis"], d["axis_1"]))


def bent_place(d, nodes, context):
    """Return the same with ``axis_b``: the axes of b are those of a, turned from the axis of a to that of b."""
    mu = triad(d["axis"], d["axis_1"])
    axis_b = d["axis"] if d["axis_b"] is None else d["axis_b"]
    return {**triads_together(nodes, mu, mu @ turned_onto(d["axis"], axis_b).T), "start": np.zeros(3)}


def triads_together(nodes, mu, xi=None):
    """Return {mu, xi, start} of a pair from inertial unit axes (3, 3), rows; those of b default to the same."""
    start = mu @ np.subtract(nodes[1][0], nodes[0][0])
    return {"mu": mu @ nodes[0][1], "xi": (mu if xi is None else xi) @ nodes[1][1], "start": start}

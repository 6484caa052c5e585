r"""Coupler: a linear relation between the coordinates of two joints, as by a synchronisation cable, gears or a linkage.

With the coordinates :math:`c_a, c_b` of the joints, each its output ``angle`` or ``displacement``, any number of
turns, and the ``factors`` :math:`h_a, h_b` and the ``constant`` c of the deck,

.. math::  h_a c_a + h_b c_b = c, \qquad \Phi = c_a + (h_b/h_a)\, c_b - c/h_a

The multiplier is the load along :math:`c_a`, a moment or a force; the load along :math:`c_b` is :math:`h_b/h_a` times
it. Each load acts between the two nodes of its joint, and together they do no work. A coupler has no inertia, friction
or play of its own.
"""

from collections import namedtuple

from mecano.constraints.along_coordinate.law import counted
from mecano.constraints.coordinates.coordinate import add_along, rate_of
from mecano.constraints.coordinates.slide import SLIDE
from mecano.constraints.coordinates.twist import TWIST
from mecano.constraints.joint_samples import two_places
from mecano.element_interface import Display, Kind, Output, Place, Row, record
from mecano.jit.kernel import kernel
from mecano.schema import NUMBER, Field, joint_with, list_of, not_zero

COORDINATES = {"angle": TWIST, "displacement": SLIDE}
Turning = namedtuple("Turning", TWIST.axes)
Sliding = namedtuple("Sliding", SLIDE.axes)


@kernel
def _turning_a(p):
    return Turning(p.mu_a, p.xi_a)


@kernel
def _turning_b(p):
    return Turning(p.mu_b, p.xi_b)


@kernel
def _sliding_a(p):
    return Sliding(p.mu_a)


@kernel
def _sliding_b(p):
    return Sliding(p.mu_b)


AXES = {TWIST: (_turning_a, _turning_b), SLIDE: (_sliding_a, _sliding_b)}
"""The axes of a coordinate of the first and of the second joint, from the record of a coupler."""


def _mechanics(first, second):
    """Return the declarations of a Kind that couples these coordinates."""
    n, turns = 3 * len(first.layout), sum(slot[0] == "R" for slot in first.layout)
    row, kept, more = n + 3 * len(second.layout), int(first.periodic), int(second.periodic)
    value_a, value_b, along_a, along_b = counted(first), counted(second), first.gradient, second.gradient
    axes_a, axes_b = AXES[first][0], AXES[second][1]

    @kernel
    def place_b(at):
        return Place(at.t, at.phase, at.k, at.penalty, at.laws, at.m[kept:], at.q[n:], at.v[n:], at.a[n:], at.R[turns:])

    @kernel
    def difference(p, at):
        return value_a(axes_a(p), at) + p.ratio * value_b(axes_b(p), place_b(at)) - p.offset

    @kernel
    def residual(p, at, f):
        Phi = difference(p, at)
        g = at.penalty * Phi - at.q[row]
        f[row] -= at.k * Phi
        add_along(f, g, along_a(axes_a(p), at))
        add_along(f[n:], p.ratio * g, along_b(axes_b(p), place_b(at)))

    @kernel
    def constraints(p, at, g):
        b = place_b(at)
        g[0, 0] = difference(p, at)
        g[0, 1] = rate_of(along_a(axes_a(p), at), at.v) + p.ratio * rate_of(along_b(axes_b(p), b), b.v)

    @kernel
    def observe(p, at, F, y, e):
        y[0] = at.q[row]
        y[1] = p.ratio * at.q[row]

    @kernel
    def commit(p, at, m_out):
        if kept:
            m_out[0] = value_a(axes_a(p), at)
        if more:
            m_out[kept] = value_b(axes_b(p), place_b(at))

    memory = [name for name, one in (("angle_a", first), ("angle_b", second)) if one.periodic]
    (load, unit), (_, unit_b) = first.load, second.load
    return {
        "dtype": record(**_record(first, "a"), **_record(second, "b"), ratio=(), offset=()),
        "layout": (*first.layout, *(f"{what}{int(node) + 2}" for what, node in second.layout)),
        "multipliers": (Row(f"{load} on the first joint", unit, first.unit),),
        "outputs": (
            Output("load_a", unit, "moment or force along the coordinate of the first joint, > 0 increases it"),
            Output("load_b", unit_b, "moment or force along the coordinate of the second joint, > 0 increases it"),
        ),
        "memory": tuple(memory), "commit": commit if memory else None,
        "residual": residual, "constraints": constraints, "observe": observe,
    }  # fmt: skip


def _record(coordinate, end):
    return {f"{name}_{end}": shape for name, shape in coordinate.axes.items()}


def _given(d, end):
    """Return the names of the coordinates that the deck gives for one end; there must be one."""
    return [name for name in COORDINATES if d[f"{name}_{end}"] is not None]


def prepare(d, nodes, context):
    """Return axes and initial values of both coordinates, and the relation."""
    found, ratio = {}, d["factors"][1] / d["factors"][0]
    offset = d["constant"] / d["factors"][0]
    for end, factor, ends in (("a", 1.0, nodes[:2]), ("b", ratio, nodes[2:])):
        (name,) = _given(d, end)
        joint = d[f"{name}_{end}"]
        measured = context.kinds[joint["type"]].measures[name](joint, ends, context)
        found |= {f"{axis}_{end}": value for axis, value in measured.axes.items()}
        offset += factor * measured.zero
    return {**found, "ratio": ratio, "offset": offset}


def check(d, nodes):
    """Check that there is one coordinate at each end, and not the same."""
    texts = [f"give either 'angle_{end}' or 'displacement_{end}'" for end in "ab" if len(_given(d, end)) != 1]
    if any(d[f"{name}_a"] is not None and d[f"{name}_a"] is d[f"{name}_b"] for name in COORDINATES):
        texts.append("its two coordinates are the same one")
    return texts if len(d["factors"]) == 2 else [*texts, "'factors' must be two numbers, h_a and h_b"]


def variant(d):
    """Return the kind for the coordinates of the deck."""
    return COUPLERS[_given(d, "a")[0], _given(d, "b")[0]]


def sample(rng):
    """Return every pair of coordinates, of joints at different places."""
    given = {f"{name}_{end}": None for name in COORDINATES for end in "ab"}
    joints = [{"type": "cylindrical", "axis": rng.normal(size=3), "axis_1": None} for _ in "ab"]
    relation = {"factors": [0.5, -1.5], "constant": 0.2}
    return [
        ({**given, f"{a}_a": joints[0], f"{b}_b": joints[1], **relation}, [*two_places(rng), *two_places(rng)], "")
        for a, b in COUPLERS
    ]


def _coordinate(name, end, which):
    text = f"joint whose {name} is the {which} coordinate"
    return Field(f"{name}_{end}", joint_with(name), "-", text, None)


def _kind(a, b):
    return Kind(
        name="coupler",
        section="joints",
        doc=__doc__,
        display=Display("nothing"),
        fields=(
            *(
                _coordinate(name, end, which)
                for end, which in (("a", "first"), ("b", "second"))
                for name in COORDINATES
            ),
            Field("factors", list_of(NUMBER, not_zero), "-", "h_a and h_b; their ratio has the unit of c_a/c_b"),
            Field("constant", NUMBER, "-", "c, in the unit of h_a c_a", 0.0),
        ),
        prepare=prepare,
        check=check,
        variant=variant,
        sample=sample,
        **_mechanics(COORDINATES[a], COORDINATES[b]),
    )


COUPLERS = {(a, b): _kind(a, b) for a in COORDINATES for b in COORDINATES}
COUPLER = COUPLERS["angle", "angle"]

r"""Slider on a beam: a node is held on the axis of a line of beam elements and slides along it, past their nodes.

Between two nodes at distance L of the undeformed beam, with its tangents :math:`t_j` fixed in the nodes, the axis is
the cubic through positions and directions of both; this is the shape of an Euler beam element under loads at its nodes:

.. math::  X(s) = H_0 x_j + L H_1\, R_j t_j + H_2\, x_{j+1} + L H_3\, R_{j+1} t_{j+1}, \qquad x - X(s) = 0

s [m], the length of the undeformed beam up to the slider, is an additional unknown. The multipliers are the force on
the slider; the equation of s states that it is normal to the axis: there is no friction. The opposite force acts on the
beam, distributed to forces and moments at both nodes by the principle of virtual work, so that no energy is lost.

Position and direction are continuous from one element to the next, the curvature jumps: the time integration locates
that instant, ends a step there and restarts (the event ``passes``), which preserves its order. Directions are those of
the sections: the kink that shear causes at a loaded node is neglected, and so is the bending of the element under the
slider itself, up to F L^3/(192 EI) in its middle: both decrease with the size of the elements.
"""

from dataclasses import replace
from functools import cache

import numpy as np

from mecano.constraints.joint_samples import rotation
from mecano.constraints.line_of_nodes import check_line, nearest_station, smooth_line
from mecano.constraints.triads import unit
from mecano.element_interface import Display, Event, Kind, Output, Row, named, record
from mecano.jit.kernel import kernel
from mecano.maths.dual import at_least, number
from mecano.maths.vector import add_vec, cross, dot, mat, norm, put, vec
from mecano.schema import LINE, NODE, Field

RECORD = record(n_nodes="i", table="i", first="i", start=(), length=())
PAST = 1e-6  # of an element: distance past a node at which the next one takes over; lets a slider rest at a node
ROUNDING = 1e-9  # m


@kernel
def _element(p, m):
    """Return the element that the slider is on."""
    return p.first + int(round(m[0]))


@kernel
def _shape(p, laws, i, s):
    """Return H (4,) and its derivative by s of the element i, those of tangents times its length."""
    start, L = laws[p.table + i], laws[p.table + i + 1] - laws[p.table + i]
    u = (s - start) / L
    w = 1.0 - u
    H = (1.0 + u * u * (2.0 * u - 3.0), L * u * w * w, u * u * (3.0 - 2.0 * u), L * u * u * (u - 1.0))
    bend = 6.0 * u * (u - 1.0) / L
    return H, (bend, w * (1.0 - 3.0 * u), -bend, u * (3.0 * u - 2.0))


@kernel
def _tangent(p, laws, j):
    """Return the direction of the beam at its node j, fixed in the node."""
    return vec(laws, p.table + p.n_nodes + 3 * j)


@kernel
def _sum(H, y):
    """Return H_0 y_0 + ... + H_3 y_3."""
    return H[0] * y[0] + H[1] * y[1] + (H[2] * y[2] + H[3] * y[3])


@kernel
def _ends(p, at, i):
    """Return places and directions at both nodes of the element i, and their rates, inertial."""
    j, l = 3 + 6 * i, 9 + 6 * i
    A, B, t_0, t_1 = mat(at.R[i]), mat(at.R[i + 1]), _tangent(p, at.laws, i), _tangent(p, at.laws, i + 1)
    turning_0, turning_1 = A @ cross(vec(at.v, j + 3), t_0), B @ cross(vec(at.v, l + 3), t_1)
    return (
        (vec(at.q, j), A @ t_0, vec(at.q, l), B @ t_1), (vec(at.v, j), turning_0, vec(at.v, l), turning_1),
    )  # fmt: skip


@kernel
def residual(p, at, f):
    """Add the force on the slider, its opposite on two nodes of the beam, the force along it."""
    i, own = _element(p, at.m), 3 + 6 * p.n_nodes
    j, l = 3 + 6 * i, 9 + 6 * i
    H, H_1 = _shape(p, at.laws, i, number(at.q[own]))
    y, _ = _ends(p, at, i)
    Phi = vec(at.q, 0) - _sum(H, y)
    g = at.penalty * Phi - vec(at.q, own + 1)
    add_vec(f, 0, 1.0, g)
    add_vec(f, own + 1, -at.k, Phi)
    add_vec(f, j, -H[0], g)
    add_vec(f, j + 3, -H[1], cross(_tangent(p, at.laws, i), mat(at.R[i]).T @ g))
    add_vec(f, l, -H[2], g)
    add_vec(f, l + 3, -H[3], cross(_tangent(p, at.laws, i + 1), mat(at.R[i + 1]).T @ g))
    f[own] -= dot(g, _sum(H_1, y))


@kernel
def constraints(p, at, g):
    """Write value and rate along the inertial axes."""
    i, own = _element(p, at.m), 3 + 6 * p.n_nodes
    H, H_1 = _shape(p, at.laws, i, number(at.q[own]))
    y, y_1 = _ends(p, at, i)
    Phi = vec(at.q, 0) - _sum(H, y)
    rate = vec(at.v, 0) - _sum(H, y_1) - at.v[own] * _sum(H_1, y)
    for r in range(3):
        g[r, 0], g[r, 1] = Phi[r], rate[r]


@kernel
def observe(p, at, F, y, e):
    """Write position on the beam, speed along it, force."""
    i, own = _element(p, at.m), 3 + 6 * p.n_nodes
    s, s_rate = number(at.q[own]), number(at.v[own])
    _, H_1 = _shape(p, at.laws, i, s)
    places, _ = _ends(p, at, i)
    y[0], y[1], y[2] = s, s_rate, norm(_sum(H_1, places)) * s_rate
    put(y, 3, vec(at.q, own + 1))
    y[6] = norm(vec(at.q, own + 1))
    y[7] = at_least(at_least(-s, 0.0), s - p.length)


@kernel
def event_values(p, at, g):
    """Write the distance of the slider past the nodes of its element [m], if another one follows."""
    i, s = _element(p, at.m), at.q[3 + 6 * p.n_nodes]
    start, end = at.laws[p.table + i], at.laws[p.table + i + 1]
    past = PAST * (end - start)
    back = start - s if i > 0 else -1.0
    g[0] = max(back, s - end if i + 2 < p.n_nodes else -1.0) - past


@kernel
def commit(p, at, m_out):
    """Write the index of the element that the slider is on, relative to the initial one."""
    i, s = _element(p, at.m), at.q[3 + 6 * p.n_nodes]
    past = 0.5 * PAST * (at.laws[p.table + i + 1] - at.laws[p.table + i])
    while i + 2 < p.n_nodes and s > at.laws[p.table + i + 1] + past:
        i += 1
    while i > 0 and s < at.laws[p.table + i] - past:
        i -= 1
    m_out[0] = i - p.first


def prepare(d, nodes, context):
    """Return lengths and directions of the line at its nodes, and the position of the slider on it."""
    (x, _), line = nodes[0], nodes[1:]
    places = np.array([place for place, _ in line], float)
    tangents, stations = smooth_line(places)
    table = context.laws.append(stations)
    for (_, R), tangent in zip(line, tangents, strict=True):
        context.laws.append(R.T @ tangent)
    first, start = nearest_station(places, stations, np.asarray(x, float))
    return {"n_nodes": len(line), "table": table, "first": first, "start": start, "length": stations[-1]}


@cache
def _of_size(n_nodes):
    layout = tuple(f"{slot}{i}" for i in range(1, n_nodes + 1) for slot in "xR")
    return replace(SLIDER_ON_BEAM, variant=None, layout=("x0", *layout))


def sample(rng):
    """Return sliders on a bent line of three nodes, on its first and second element, and on a single element."""
    found = []
    for count, place in ((3, 0.0), (3, 1.6), (2, 0.0)):
        axis, across = rng.normal(size=(2, 3))
        axis, across = unit(axis), unit(np.cross(axis, across))
        line = [(axis * i + 0.2 * i * i * across, rotation(rng)) for i in range(count)]
        names = ["slider", *(f"node_{i}" for i in range(count))]
        nodes = [(axis * place + 0.2 * place**2 * across, np.eye(3)), *line]
        found.append(({"node": names[0], "line": names[1:]}, nodes, ""))
    return found


SLIDER_ON_BEAM = Kind(
    name="slider_on_beam", section="joints", doc=__doc__, display=Display(pictures=("curves",), force="force"),
    dtype=RECORD, scalars=("position",),
    fields=(
        Field("node", NODE, "-", "the slider, free to rotate"),
        Field("line", LINE, "-", "the beam, or its nodes from its start to its end"),
    ),
    outputs=(
        Output(
            "position", "m", "s, the position on the beam: undeformed length from its first node", rate="position_rate"
        ),
        Output("position_rate", "m/s", "rate of s"),
        Output("speed", "m/s", "speed along the beam"),
        Output("force", "N", "force of the beam on the slider, inertial", (3,)),
        Output("normal_force", "N", "magnitude of that force, which is normal to the beam"),
        Output("overrun", "m", "how far the slider is beyond the ends of the beam", geometric=True),
    ),
    multipliers=tuple(Row(f"force on the slider along {axis}", "N", "m") for axis in "xyz"),
    events=(Event("passes", "", "", "the slider passes from one element of the beam to the next"),),
    memory=("element",),
    start=lambda p: (p["start"],),
    check=lambda d, nodes: check_line(d, nodes[1:]),
    end_conditions=lambda d: [("overrun", ROUNDING, "has reached the end of the beam")],
    variant=lambda d: _of_size(len(d["line"])),
    **named(prepare, sample),
    **named(residual, constraints, observe, event_values, commit),
)  # fmt: skip

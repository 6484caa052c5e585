r"""Slider on a beam: a node is held on the axis of a line of beam elements and slides along it, past their nodes.

Between two nodes at distance L of the undeformed beam, with its tangents :math:`t_j` fixed in the nodes,
the axis is the cubic through positions and directions of both; this is the shape of an Euler beam element under
loads at its nodes:

.. math::  X(s) = H_0 x_j + L H_1\, R_j t_j + H_2\, x_{j+1} + L H_3\, R_{j+1} t_{j+1}, \qquad x - X(s) = 0

s [m], the length of the undeformed beam up to the slider, is an additional unknown. The multipliers are the
force on the slider; the equation of s states that it is normal to the axis: there is no friction. The opposite force
acts on the beam, distributed to forces and moments at both nodes by the principle of virtual work, so that no energy is
lost.

Position and direction are continuous from one element to the next, the curvature jumps: the time integration locates
that instant, ends a step there and restarts (the event ``passes``), which preserves its order. Directions are those of
the sections: the kink that shear causes at a loaded node is neglected, and so is the bending of the element under the
slider itself, up to F L^3/(192 EI) in its middle: both decrease with the size of the elements.
"""

from functools import cache

import numpy as np

from mecano.constraints.augmented_lagrangian import add_constraint, add_scalar, put_derivatives
from mecano.constraints.body_fixed import carried
from mecano.element_interface import Display, Event, Kind, Output, Row, record
from mecano.elements.members.smooth_line import nearest_station, smooth_line
from mecano.jit.kernel import kernel
from mecano.maths.vector import EYE, add_col, add_mat, add_row, cross, mat, norm, put, skew, vec
from mecano.schema import NODE, NODES, Field

RECORD = record(n_nodes="i", table="i", first="i", start=(), length=())
PAST = 1e-6  # of an element: distance past a node at which the next one takes over; lets a slider rest at a node
ROUNDING = 1e-9  # m


@kernel
def _element(p, m):
    """Return the element that the slider is on."""
    return p.first + int(round(m[0]))


@kernel
def _shape(p, laws, i, s):
    """Return (H (4,), first and second derivatives by s) of the element i; those of tangents times its length."""
    start, L = laws[p.table + i], laws[p.table + i + 1] - laws[p.table + i]
    u = (s - start) / L
    H = (1.0 + u * u * (2.0 * u - 3.0), L * u * (1.0 - u) ** 2, u * u * (3.0 - 2.0 * u), L * u * u * (u - 1.0))
    bend = 6.0 * u * (u - 1.0) / L
    H_1 = (bend, (1.0 - u) * (1.0 - 3.0 * u), -bend, u * (3.0 * u - 2.0))
    bend = (12.0 * u - 6.0) / (L * L)
    return H, H_1, (bend, (6.0 * u - 4.0) / L, -bend, (6.0 * u - 2.0) / L)


@kernel
def _tangent(p, laws, j):
    """Return the direction of the beam at its node j, fixed in the node."""
    return vec(laws, p.table + p.n_nodes + 3 * j)


@kernel
def _sum(H, y):
    """Return H_0 y_0 + ... + H_3 y_3."""
    return H[0] * y[0] + H[1] * y[1] + (H[2] * y[2] + H[3] * y[3])


@kernel
def _of_beam(H, j, e, turn_0, turn_1):
    """Return gradients of -e . X at the nodes of an element with unknowns from j on, as blocks of add_constraint."""
    return (
        (j, -H[0] * e), (j + 3, -H[1] * turn_0), (j + 6, -H[2] * e), (j + 9, -H[3] * turn_1),
    )  # fmt: skip


@kernel
def _ends(p, laws, i, q, v, a, R):
    """Return positions and directions at both nodes of the element i, their rates and second rates, inertial."""
    j, l = 3 + 6 * i, 9 + 6 * i
    t_0 = carried(mat(R[i]), vec(v, j + 3), vec(a, j + 3), _tangent(p, laws, i))
    t_1 = carried(mat(R[i + 1]), vec(v, l + 3), vec(a, l + 3), _tangent(p, laws, i + 1))
    return (
        (vec(q, j), t_0[0], vec(q, l), t_1[0]), (vec(v, j), t_0[1], vec(v, l), t_1[1]),
        (vec(a, j), t_0[2], vec(a, l), t_1[2]),
    )  # fmt: skip


@kernel
def force(p, at, f, K, C, M):
    """Add the force on the slider, its opposite on two nodes of the beam, the force along it."""
    i, own = _element(p, at.m), 3 + 6 * p.n_nodes
    j, l = 3 + 6 * i, 9 + 6 * i
    A, B, t_0, t_1 = mat(at.R[i]), mat(at.R[i + 1]), _tangent(p, at.laws, i), _tangent(p, at.laws, i + 1)
    H, H_1, H_2 = _shape(p, at.laws, i, at.q[own])
    y = (vec(at.q, j), A @ t_0, vec(at.q, l), B @ t_1)
    X, slope, curvature = _sum(H, y), _sum(H_1, y), _sum(H_2, y)
    for r in range(3):
        e = EYE[r]
        turn_0, turn_1 = cross(t_0, A.T @ e), cross(t_1, B.T @ e)
        blocks = ((0, e),) + _of_beam(H, j, e, turn_0, turn_1)
        row = own + 1 + r
        g = add_constraint(f, K, row, at.k, at.penalty, at.q[r] - X[r], at.q[row], blocks)
        add_scalar(f, K, own, row, at.k, at.penalty, g, -slope[r], -curvature[r], blocks)
        for place, b in _of_beam(H_1, j, e, turn_0, turn_1):
            add_col(K, place, own, g, b)
            add_row(K, own, place, g, b)
        add_mat(K, j + 3, j + 3, -g * H[1], skew(t_0) @ skew(A.T @ e))
        add_mat(K, l + 3, l + 3, -g * H[3], skew(t_1) @ skew(B.T @ e))


@kernel
def constraint_derivatives(p, at, g):
    """Write value and rates along the inertial axes."""
    i, own = _element(p, at.m), 3 + 6 * p.n_nodes
    H, H_1, H_2 = _shape(p, at.laws, i, at.q[own])
    y, y_1, y_2 = _ends(p, at.laws, i, at.q, at.v, at.a, at.R)
    slope, turning, rate = _sum(H_1, y), _sum(H_1, y_1), at.v[own]
    X_1 = _sum(H, y_1) + rate * slope
    X_2 = _sum(H, y_2) + 2.0 * rate * turning
    X_2 = X_2 + (rate * rate * _sum(H_2, y) + at.a[own] * slope)
    X = _sum(H, y)
    for r in range(3):
        put_derivatives(g, r, at.q[r] - X[r], at.v[r] - X_1[r], at.a[r] - X_2[r])


@kernel
def observe(p, at, F, y, e):
    """Write position on the beam, speed along it, force."""
    i, own = _element(p, at.m), 3 + 6 * p.n_nodes
    _, H_1, _ = _shape(p, at.laws, i, at.q[own])
    places, _, _ = _ends(p, at.laws, i, at.q, at.v, at.a, at.R)
    y[0], y[1], y[2] = at.q[own], at.v[own], norm(_sum(H_1, places)) * at.v[own]
    put(y, 3, vec(at.q, own + 1))
    y[6] = norm(vec(at.q, own + 1))
    y[7] = max(-at.q[own], at.q[own] - p.length, 0.0)


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


def start(p):
    """Return the initial position on the beam."""
    return (p["start"],)


def check(d, nodes):
    """Return errors for an invalid line."""
    if len(d["line"]) < 2:
        return ["'line' must name at least 2 nodes"]
    apart = np.linalg.norm(np.diff([x for x, _ in nodes[1:]], axis=0), axis=1)
    return ["consecutive nodes of 'line' must not coincide"] if not apart.min() > 0.0 else []


def ends(d):
    """Return the end condition of a slider that reaches the end of the beam."""
    return [("overrun", ROUNDING, "has reached the end of the beam")]


def variant(d):
    """Return the kind for a line with as many nodes as these values name."""
    return _of_size(len(d["line"]))


@cache
def _of_size(n_nodes):
    layout = tuple(f"{slot}{i}" for i in range(1, n_nodes + 1) for slot in "xR")
    return Kind(**DECLARED, layout=("x0", *layout))


def sample(rng):
    """Return sliders on a bent line of three nodes, on its first and second element, and on a single element."""
    found = []
    for count, place in ((3, 0.0), (3, 1.6), (2, 0.0)):
        axis, across = rng.normal(size=(2, 3))
        axis, across = axis / np.linalg.norm(axis), np.cross(axis, across) / np.linalg.norm(np.cross(axis, across))
        turns = [np.linalg.qr(rng.normal(size=(3, 3)))[0] for _ in range(count)]
        line = [(axis * i + 0.2 * i * i * across, A * np.linalg.det(A)) for i, A in enumerate(turns)]
        names = ["slider", *(f"node_{i}" for i in range(count))]
        nodes = [(axis * place + 0.2 * place**2 * across, np.eye(3)), *line]
        found.append(({"node": names[0], "line": names[1:]}, nodes, ""))
    return found


DECLARED = {
    "name": "slider_on_beam",
    "section": "joints",
    "doc": __doc__,
    "display": Display(pictures=("curves",), force="force"),
    "dtype": RECORD,
    "scalars": ("position",),
    "fields": (
        Field("node", NODE, "-", "the slider, free to rotate"),
        Field("line", NODES, "-", "nodes of the beam from its start to its end, including those created by 'mesh'"),
    ),
    "outputs": (
        Output(
            "position", "m", "s, the position on the beam: undeformed length from its first node", rate="position_rate"
        ),
        Output("position_rate", "m/s", "rate of s"),
        Output("speed", "m/s", "speed along the beam"),
        Output("force", "N", "force of the beam on the slider, inertial", (3,)),
        Output("normal_force", "N", "magnitude of that force, which is normal to the beam"),
        Output("overrun", "m", "how far the slider is beyond the ends of the beam"),
    ),
    "multipliers": tuple(Row(f"force on the slider along {axis}", "N", "m") for axis in "xyz"),
    "events": (Event("passes", "", "", "the slider passes from one element of the beam to the next"),),
    "memory": ("element",),
    "prepare": prepare,
    "start": start,
    "variant": variant,
    "check": check,
    "ends": ends,
    "force": force,
    "constraint_derivatives": constraint_derivatives,
    "observe": observe,
    "event_values": event_values,
    "commit": commit,
    "sample": sample,
}
SLIDER_ON_BEAM = Kind(**DECLARED)

r"""Span of a belt: an elastic line between two pulleys, or a pulley and a point, on which it does not slip.

A pulley i has the axis :math:`a_i`, fixed in its node, and the radius :math:`\rho_i`, negative where the belt turns
clockwise about the axis and zero at a point. With :math:`d = x_1 - x_0`, its component across the axis, of the length
:math:`D_i`, and :math:`\delta = \rho_1 - \rho_0`, the common tangent has the length L and the angle :math:`\psi_i`:

.. math::  L = \sqrt{|d|^2 - \delta^2}, \qquad \psi_i = \varphi_i - \arcsin(\delta/D_i)

where :math:`\varphi_i` is the angle of d in the axes of node i, over any number of turns. Belt that leaves the arc of a
pulley enters the span, so the span stretches by

.. math::  \Delta = \lambda - \lambda_0 + T_0/k, \qquad \lambda = L + \rho_0 \psi_0 - \rho_1 \psi_1

since the start, where it has the tension :math:`T_0`. With the stiffness k and the damping time :math:`\tau`,

.. math::  T = k\,(\Delta + \tau \dot\Delta), \qquad f = T\,\partial \lambda/\partial q, \qquad
           V = \tfrac12 k \Delta^2

while it is taut, where both :math:`\Delta` and :math:`\Delta + \tau\dot\Delta` are positive; the viscous tension is at
most as large as the elastic one. Energy that remains when it goes slack is dissipated until :math:`\Delta = 0`. L and
the angles are exact for parallel axes and pulleys in one plane; small inclinations are allowed. The span of a belt that
is activated stress-free has the tension :math:`T_0` at that instant; before, or after a release, no tangent need exist.
"""

import math
from dataclasses import replace
from functools import cache

import numpy as np

from mecano.constraints.activation import SHIFT, activated
from mecano.constraints.body_fixed import whole_turns
from mecano.constraints.coordinates.coordinate import add_along, rate_of
from mecano.constraints.line_phases import EVENTS, PHASES, SLACK, TAUT, follows, is_damped, pulled, put_line_events
from mecano.constraints.release import detached
from mecano.element_interface import Kind, Output, named, record
from mecano.jit.kernel import kernel
from mecano.maths.dual import atan2, sqrt, value
from mecano.maths.vector import Vec3, cross, dot, mat, norm, vec

CLOSENESS = 3  # index of this output
CLOSEST = 0.999  # difference of the radii of neighbours over their distance
INCLINATION = 0.2  # of the distance: largest offset along the axis
OUTPUTS = (
    Output("tension", "N", "tension of the span; zero while it is slack"),
    Output("stretch", "m", "elongation of the belt in the span, negative while it is slack"),
    Output("span", "m", "free length between the pulleys"),
    Output("closeness", "-", "difference of the radii over the distance of the nodes; 1 where the span vanishes"),
)
RECORD = record(
    radius_0=(), axes_0=(3, 3), angle_0=(), radius_1=(), axes_1=(3, 3), angle_1=(), length=(), stretch=(), stiffness=(),
    damping=(),
)  # fmt: skip


@kernel
def tangent_direction(axes, d, delta):
    """Return the angle of the tangent in the plane of a pulley, and its gradient by d; both in axes of the node."""
    c = axes @ d
    across = c.x * c.x + c.y * c.y
    tangent = sqrt(across - delta * delta)
    lean = delta / tangent
    gradient = Vec3((lean * c.x - c.y) / across, (c.x + lean * c.y) / across, 0.0 * c.z)
    return atan2(c.y, c.x) - atan2(delta, tangent), axes.T @ gradient


@kernel
def _since_start(angle, at_start, turned):
    """Return the whole turns since the start, next to the last known angle ``turned``, and the angle beyond them."""
    beyond = angle - at_start
    return whole_turns(turned, beyond), beyond


@kernel
def between_pulleys(p, at):
    """Return stretch, gradient, free length, and the angles since the start of the tangent on both pulleys."""
    R_0, R_1, delta = mat(at.R[0]), mat(at.R[1]), p.radius_1 - p.radius_0
    d = vec(at.q, 6) - vec(at.q, 0)
    d_0, d_1, L = R_0.T @ d, R_1.T @ d, sqrt(dot(d, d) - delta * delta)
    psi_0, g_0 = tangent_direction(mat(p.axes_0), d_0, delta)
    psi_1, g_1 = tangent_direction(mat(p.axes_1), d_1, delta)
    turns_0, psi_0 = _since_start(psi_0, p.angle_0, at.m[0])
    turns_1, psi_1 = _since_start(psi_1, p.angle_1, at.m[1])
    G = d / L + p.radius_0 * (R_0 @ g_0) - p.radius_1 * (R_1 @ g_1)
    turning = (3, -p.radius_0 * cross(d_0, g_0)), (9, p.radius_1 * cross(d_1, g_1))
    whole = p.radius_0 * turns_0 - p.radius_1 * turns_1  # they cancel, and are large (body_fixed.py)
    stretch = L - p.length + p.stretch + whole + (p.radius_0 * psi_0 - p.radius_1 * psi_1)
    return stretch, ((0, -G), (6, G), *turning), L, turns_0 + psi_0, turns_1 + psi_1


@kernel
def to_a_point(p, at):
    """Return the same of a span between a pulley and a point."""
    R_0, d = mat(at.R[0]), vec(at.q, 6) - vec(at.q, 0)
    d_0, L = R_0.T @ d, sqrt(dot(d, d) - p.radius_0 * p.radius_0)
    psi_0, g_0 = tangent_direction(mat(p.axes_0), d_0, -p.radius_0)
    turns_0, psi_0 = _since_start(psi_0, p.angle_0, at.m[0])
    G = d / L + p.radius_0 * (R_0 @ g_0)
    along = (0, -G), (6, G), (3, -p.radius_0 * cross(d_0, g_0))
    return L - p.length + p.stretch + p.radius_0 * (turns_0 + psi_0), along, L, turns_0 + psi_0, 0.0


def _since_activation(geometry, i):
    """Return the ``geometry`` with a stretch that is shifted by the memory i."""

    @kernel
    def shifted(p, at):
        stretch, along, L, psi_0, psi_1 = geometry(p, at)
        return stretch + at.m[i], along, L, psi_0, psi_1

    return shifted


@kernel
def _lost(at, stretch):
    """Return whether the span does not act, and no tangent exists, so that its stretch is not a number."""
    return at.phase > SLACK and not math.isfinite(value(stretch))


def observed(stretch_of):
    """Return ``observe`` and ``event_values`` for the stretch (p, at) -> value, rate, gradient, free length."""

    @kernel
    def observe(p, at, F, y, e):
        """Write tension, stretch, length, closeness, energy and dissipated power."""
        stretch, rate, _, L = stretch_of(p, at)
        y[3] = abs(p.radius_1 - p.radius_0) / norm(vec(at.q, 6) - vec(at.q, 0))
        if not math.isfinite(value(rate)):  # there is no tangent
            return
        elastic, tension = pulled(p, at, stretch, rate)
        elastic, T = p.stiffness * elastic, p.stiffness * tension
        y[0], y[1], y[2] = T, stretch, L
        e[1] = 0.5 * elastic * stretch
        e[2] = (T - elastic) * rate

    @kernel
    def event_values(p, at, g):
        stretch, rate, _, _ = stretch_of(p, at)
        put_line_events(g, at.phase == TAUT, stretch, rate, p.damping)

    return named(observe, event_values)


def _functions(geometry, angles, always):
    """Return the functions of a span with this ``geometry`` and ``angles`` angles in its memory.

    ``always``: the span acts in all of its phases, and a tangent always exists.
    """

    @kernel
    def stretch_of(p, at):
        stretch, along, L, _, _ = geometry(p, at)
        return stretch, rate_of(along, at.v), along, L

    @kernel
    def residual(p, at, f):
        if at.phase == TAUT or follows(p, at):
            stretch, rate, along, _ = stretch_of(p, at)
            add_along(f, p.stiffness * pulled(p, at, stretch, rate)[1], along)

    @kernel
    def commit(p, at, m_out):
        stretch, _, _, psi_0, psi_1 = geometry(p, at)
        if not always and _lost(at, stretch):
            return
        m_out[0] = psi_0
        if angles > 1:
            m_out[1] = psi_1

    return {**named(residual, commit), **observed(stretch_of)}


def _kind(name, doc, layout, geometry, radii):
    """Return the Kind of a span with this ``geometry``; ``radii`` of the pulleys in its samples."""
    memory = ("angle_0", "angle_1")[: len(layout) - 2]
    return Kind(
        name=name, doc=doc, dtype=RECORD, layout=layout, outputs=OUTPUTS, phases=PHASES, events=EVENTS, memory=memory,
        cornered=is_damped, sample=samples_of_spans(radii, PHASES), **_functions(geometry, len(memory), True),
    )  # fmt: skip


def _stress_free(kind, geometry):
    """Return the ``kind`` of a span whose tension at its activation is that of the record at the start."""
    n = len(kind.memory)
    follow = kind.commit

    @kernel
    def commit(p, at, m_out):
        follow(p, at, m_out)
        stretch = geometry(p, at)[0]
        if not _lost(at, stretch):
            m_out[n] = p.stretch - stretch

    return replace(
        kind, memory=(*kind.memory, SHIFT), **{**_functions(_since_activation(geometry, n), n, False), "commit": commit}
    )


@cache
def span_kind(at_a_point, released, activation):
    """Return the Kind of a span that ends ``at_a_point``, not at a second pulley, of a belt that may be ``released``.

    ``activation`` is None if the belt is always active, otherwise whether it is activated stress-free.
    """
    plain, geometry, radii = (BELT_END, to_a_point, RADII_OF_END) if at_a_point else (BELT_SPAN, between_pulleys, RADII)
    if not released and activation is None:
        return plain
    kind = replace(plain, **_functions(geometry, len(plain.memory), False))
    kind = _stress_free(kind, geometry) if activation else kind
    if released:
        kind = detached(kind, "belt", (0, CLOSENESS))
    if activation is not None:
        kind = activated(kind, "belt", (0, 1, CLOSENESS) if activation else (0, CLOSENESS))
    return replace(kind, name=plain.name, sample=samples_of_spans(radii, kind.phases))


def span_record(first, second):
    """Return geometry of a span at the start: values of RECORD, without stretch, stiffness and damping.

    ``first`` and ``second`` are (position (3,), axes (3, 3) in the node, rotation (3, 3), radius) of both ends.
    """
    d = second[0] - first[0]
    delta = second[3] - first[3]
    found = {"length": np.sqrt(d @ d - delta * delta)}
    for i, (_, axes, R, radius) in enumerate((first, second)):
        x, y, _ = axes @ R.T @ d
        angle = np.arctan2(y, x) - np.arctan2(delta, np.sqrt(x * x + y * y - delta * delta))
        found |= {f"radius_{i}": radius, f"axes_{i}": axes, f"angle_{i}": angle}
    return found


def check_tangent(names, places, radii, frame):
    """Return errors of two neighbours between which a belt has no tangent, or none in the plane of both pulleys.

    ``names``, ``places`` (3,) and ``radii`` are those of both nodes; ``frame`` (3, 3) has the axis in its last row.
    """
    across, along = np.hypot(*(frame @ np.subtract(places[1], places[0]))[:2]), frame[2] @ np.subtract(*places)
    if not any(radii):  # two points
        across, along = np.linalg.norm(np.subtract(*places)), 0.0
    least, both = abs(radii[1] - radii[0]), f"'{names[0]}' and '{names[1]}'"
    if across <= least:
        return [
            f"'radii': {both} are {across:.4g} m apart, and must be more than {least:.4g} m apart for the belt between "
            "them"
        ]
    if abs(along) > INCLINATION * across:
        return [f"'axis': {both} are {abs(along):.4g} m apart along it, not in one plane"]
    return []


def samples_of_spans(radii, phases):
    """Return ``Kind.sample`` of spans between pulleys of these ``radii`` at random places, in each phase."""

    def sample(rng):
        found = []
        for phase in phases:
            values = {
                "radius_0": radii[0], "radius_1": radii[1], "angle_0": 0.2, "angle_1": -0.3, "length": 1.1,
                "stretch": -9.0 if phase == "slack" else 0.4, "stiffness": 30.0, "damping": 0.2,
                "axes_0": np.linalg.qr(rng.normal(size=(3, 3)))[0], "axes_1": np.linalg.qr(rng.normal(size=(3, 3)))[0],
            }  # fmt: skip
            nodes = [(rng.normal(size=3), np.eye(3)), (rng.normal(size=3) + [2.0, 2.0, 2.0], np.eye(3))]
            found.append((values, nodes, phase))
        return found

    return sample


RADII, RADII_OF_END = (0.2, -0.3), (0.2, 0.0)
BELT_SPAN = _kind("belt_span", __doc__, ("x0", "R0", "x1", "R1"), between_pulleys, RADII)
BELT_END = _kind(
    "belt_end", "Span of a belt between a pulley and a point, see the span.", ("x0", "R0", "x1"), to_a_point,
    RADII_OF_END,
)  # fmt: skip

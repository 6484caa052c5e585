r"""Path of a cable over pulleys and through eyelets (equations in elements/members/reeved_cable.py).

The record p of its users has the fields of ``path_record``; the local unknowns are the position of the first node,
position and rotation of each pulley, the position of the last node, and the payout if that is a signal. In phases
beyond those of a line no path need exist: then its length and rate are not numbers.
"""

import math

from mecano.constraints.activation import SHIFT, since_activation
from mecano.constraints.along_coordinate.demand import of_law_with_rate, with_rate
from mecano.constraints.belt_span import tangent_direction
from mecano.constraints.body_fixed import follow
from mecano.constraints.elastic_line import strained
from mecano.constraints.line_phases import SLACK
from mecano.jit.kernel import kernel
from mecano.maths.dual import sqrt, value
from mecano.maths.vector import add_vec, cross, dot, mat, vec


def path_record(n):
    """Return the fields of the record of a path over n pulleys: {name: shape}."""
    return {
        "EA": (), "damping": (), "natural": (), "prestrain": (), "law": "i",
        "radii": (n + 2,), "axes": (n, 3, 3), "start": (n,),
    }  # fmt: skip


def path_unknowns(n):
    """Return the declarations of a Kind on a path over n pulleys: unknowns and memory."""
    pulleys = range(1, n + 1)
    return {
        "layout": ("x0", *(f"{slot}{i}" for i in pulleys for slot in "xR"), f"x{n + 1}"),
        "memory": tuple(f"turned_{i}" for i in pulleys),
        "commit": commit,
    }


def shifted_path(n, payout):
    """Return (unknowns and memory, strain) of a path whose natural length is its length at the activation.

    The arguments are the number of pulleys and the ``payout``, which counts from the activation; see ``strain_by``.
    """

    @kernel
    def commit_shift(p, at, m_out):
        """Write the changes of the arcs since the start, and the shift of the natural length."""
        commit(p, at, m_out)
        if not lost(p, at):
            m_out[n] = path(p, at)[0] / (1.0 + p.prestrain) - p.natural - payout(p, at)[0]

    unknowns = path_unknowns(n)
    memory = (*unknowns["memory"], SHIFT)
    return {**unknowns, "memory": memory, "commit": commit_shift}, strain_by(since_activation(payout, n))


@kernel
def place(i):
    """Return the local index of the position of node i; the rotations of pulleys follow their positions."""
    return max(6 * i - 3, 0)


@kernel
def span(p, q, i):
    """Return d, the difference of the radii, and the free length of the span after node i."""
    d, delta = vec(q, place(i + 1)) - vec(q, place(i)), p.radii[i + 1] - p.radii[i]
    return d, delta, sqrt(dot(d, d) - delta * delta)


@kernel
def side(p, at, i, k):
    """Return the direction of span k in the axes of pulley i, and its gradients by d and by the rotation."""
    R = mat(at.R[i - 1])
    d, delta, _ = span(p, at.q, k)
    seen = R.T @ d
    psi, g = tangent_direction(mat(p.axes[i - 1]), seen, delta)
    return psi, R @ g, cross(g, seen)


@kernel
def arc(p, at, i):
    """Return the angle of the arc on pulley i, and its gradients by d before and after it and by the rotation."""
    before, g_before, turning_before = side(p, at, i, i - 1)
    behind, g_behind, turning_behind = side(p, at, i, i)
    angle = follow(p.start[i - 1] + at.m[i - 1], behind - before)
    return angle, -g_before, g_behind, turning_behind - turning_before


@kernel
def relative(v, i):
    """Return the velocity of node i + 1 minus that of node i."""
    return vec(v, place(i + 1)) - vec(v, place(i))


@kernel
def path(p, at):
    """Return the length of the path and its rate."""
    d, _, length = span(p, at.q, 0)
    rate = dot(d, relative(at.v, 0)) / length
    for i in range(1, len(p.radii) - 1):
        d, _, free = span(p, at.q, i)
        length = length + free
        rate = rate + dot(d, relative(at.v, i)) / free
        if p.radii[i] != 0.0:
            angle, before, behind, turning = arc(p, at, i)
            turned = (
                dot(before, relative(at.v, i - 1)) + dot(behind, relative(at.v, i)) + dot(turning, vec(at.v, 6 * i))
            )
            length = length + p.radii[i] * angle
            rate = rate + p.radii[i] * turned
    return length, rate


def payout_of(n, by_signal):
    """Return the compiled function (p, at) -> payout and its rate over n pulleys: of a law of time, or of a signal."""
    return with_rate(6 * (n + 1)) if by_signal else of_law_with_rate  # the signal follows the unknowns of the nodes


def strain_by(payout):
    """Return the compiled function (p, at) -> length and its rate, strain and its rate, natural length and its rate."""

    @kernel
    def cable_strain(p, at):
        length, rate = path(p, at)
        paid_out, L_rate = payout(p, at)
        L = p.natural + paid_out
        return length, rate, *strained(length, rate, L, L_rate), L, L_rate

    return cable_strain


@kernel
def lost(p, at):
    """Return whether the cable does not act, and no path exists."""
    return at.phase > SLACK and not math.isfinite(value(path(p, at)[1]))


@kernel
def pull(f, i, pull):
    """Add the force that stretches the span after node i."""
    add_vec(f, place(i), -1.0, pull)
    add_vec(f, place(i + 1), 1.0, pull)


@kernel
def commit(p, at, m_out):
    """Write the changes of the arcs since the start."""
    if lost(p, at):
        return
    for i in range(1, len(p.radii) - 1):
        if p.radii[i] != 0.0:
            m_out[i - 1] = arc(p, at, i)[0] - p.start[i - 1]

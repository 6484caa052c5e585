r"""Updates of a state: prediction, correction, rotations from their increments.

Within a step the components of angular velocities and accelerations are those in the axes of the body at its beginning,
so that the formulas of displacements hold for rotations, up to the turning of the axis of rotation:

.. math::
    R_{n+1} = R_n \exp(\hat\psi), \quad
    \psi = h \omega_n + h^2 [(\tfrac12 - \beta) a_n + \beta a_{n+1}] - h^2 d\, \omega_n \times \omega_{n+1}

d(|omega_n| h), 1/12 for small angles (Magnus 1954), is exact for a spin whose axis turns at a small and constant rate.
At the end of the step they are turned to the axes there, :math:`\Omega_{n+1} = \exp(\hat\psi)^T \omega_{n+1}`.
"""

import math
from typing import NamedTuple

import numpy as np

from mecano.jit.entry import Indices, Matrices, Matrix, Vector, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import floats
from mecano.maths.so3 import exp, inverse_coefficient, tangent
from mecano.maths.vector import EYE, cross, dot, mat, put, put_matrix, skew, vec
from mecano.model.numbering import MASSLESS, ROTATION, SCALAR, SIGNAL, TRANSLATION, Numbering, Unknowns
from mecano.model.state import Motion, State
from mecano.solve.linear.rounding import HUGE
from mecano.solve.time.workspace import BEGIN, TRIAL, copy_state, history_of, state_of, time_of, unknowns_of


@kernel
def place_rotations(rotation_dof, n_q, z, R0, R_out):
    """Compute R = R0 exp(hat(psi)) of all free rotations, with psi in z."""
    for r in range(rotation_dof.shape[0]):
        d = rotation_dof[r]
        if d < n_q:
            psi = vec(z, d)
            put_matrix(R_out[r], mat(R0[r]) @ exp(psi))


@kernel
def place(r, d, R0, s_out):
    """Compute R = R0 exp(hat(psi)) of a rotation, and turn its rate and acceleration from the axes of R0 to its own.

    ``r`` and ``d``: the indices of the rotation and of its first unknown.
    """
    turn = exp(vec(s_out.z, d))
    put_matrix(s_out.R[r], mat(R0[r]) @ turn)
    put(s_out.v, d, turn.T @ vec(s_out.v, d))
    put(s_out.a, d, turn.T @ vec(s_out.a, d))


@kernel
def axis_share(h, omega):
    """Return h^2 d(|omega| h), the factor of omega x omega_{n+1} in the rotation vector of a step from omega."""
    return h * h * inverse_coefficient(h * h * dot(omega, omega))


class Weights(NamedTuple):
    """Derivatives by the increments of a step of size h [s]: of multipliers, velocities and accelerations."""

    k: float
    cC: float
    cM: float
    h: float


@entry
def tangents(rotation_dof: Indices, n_q: int, z: Vector, T_out: Matrices):
    """Compute T(psi) (n_rotations, 3, 3) of all free rotations, with psi in z."""
    for r in range(rotation_dof.shape[0]):
        d = rotation_dof[r]
        if d < n_q:
            put_matrix(T_out[r], tangent(vec(z, d)))


@entry
def motion_tangents(rotation_dof: Indices, n_q: int, spins: Matrix, s: Motion, by: Weights, T_out: Matrices):
    """Compute the derivatives of free rotations, angular velocities and accelerations in a step, (3 n_rotations, 3, 3).

    They are material, with respect to the increments of ``correct``; of the last two they are over cC and cM. ``spins``
    (n_rotations, 3) are the angular velocities at the beginning. Of a state between two steps, whose increments are
    zero, they are identities: it varies in its own axes.
    """
    n = rotation_dof.shape[0]
    for r in range(n):
        d = rotation_dof[r]
        if d < n_q:
            psi = vec(s.z, d)
            if dot(psi, psi) == 0.0:
                for i in range(3):
                    put_matrix(T_out[i * n + r], EYE)
                continue
            turn = exp(psi)
            T = tangent(psi) @ (EYE - (by.cC * axis_share(by.h, vec(spins[r], 0))) * skew(vec(spins[r], 0)))
            put_matrix(T_out[r], T)
            put_matrix(T_out[n + r], turn.T + (1.0 / by.cC) * (skew(vec(s.v, d)) @ T))
            put_matrix(T_out[2 * n + r], turn.T + (1.0 / by.cM) * (skew(vec(s.a, d)) @ T))


@kernel
def predict(w, of, start, history, s_out):
    """Move a state to the end of a step: accelerations and multipliers extrapolated by a parabola.

    ``w`` is the record STEP (workspace.py) with coefficients and step size. ``start`` and ``s_out`` are the Motion at
    the beginning; ``s_out`` is moved. ``history``: algorithmic acceleration (n_all,) there, slope and bend (n,), the
    differences of the true ones, of the multipliers and of the signals that follow at once, and v_shift (n_all,).
    The rates of such a signal are difference quotients of its values: those of a recursion, as for a motion, would
    grow in steps that are cut again and again. Returns the largest coordinate [m] and the largest signal.
    """
    a0, slope, bend, v_shift = history
    am, af, beta, gamma, h = w.am, w.af, w.beta, w.gamma, w.h  # which loops that write arrays would read again
    kind, farthest, loudest = of.kind, 0.0, 0.0
    for i in range(of.n_q):
        if kind[i] == SIGNAL:
            increment = slope[i] + bend[i]
            rate = (slope[i] + 1.5 * bend[i]) / h
            guess = bend[i] / (h * h)
        else:
            guess = start.a[i] + slope[i] + bend[i]
            a1 = ((1.0 - af) * guess + af * start.a[i] - am * a0[i]) / (1.0 - am)
            v0 = s_out.v[i] + v_shift[i]
            increment = h * v0 + h * h * ((0.5 - beta) * a0[i] + beta * a1)
            rate = v0 + h * ((1.0 - gamma) * a0[i] + gamma * a1)
        s_out.z[i] = increment if kind[i] == ROTATION else s_out.z[i] + increment
        s_out.v[i] = rate
        s_out.a[i] = guess
        if kind[i] >= SIGNAL:
            loudest = max(loudest, abs(s_out.z[i]))
        elif kind[i] != ROTATION:
            farthest = max(farthest, abs(s_out.z[i]))
    for i in range(of.n_q, of.n):
        s_out.z[i] += slope[i] + bend[i]
    for r in range(of.rotation_dof.shape[0]):
        d = of.rotation_dof[r]
        if d < of.n_q:
            omega = vec(start.v, d)
            put(s_out.z, d, vec(s_out.z, d) - axis_share(h, omega) * cross(omega, vec(s_out.v, d)))
            place(r, d, start.R, s_out)
    return farthest, loudest


def reach_of(z: np.ndarray, of: Numbering, length: float) -> float:
    """Return the largest coordinate of a node in z (n_all,), free or fixed, over the length scale; at least 1."""
    return max(np.abs(z[of.kind == TRANSLATION]).max(initial=0.0) / length, 1.0)


def longest_step(v: np.ndarray, of: Numbering, turn: float) -> float:
    """Return the longest step [s] in which no body turns by more than ``turn`` [rad] about an axis at v (n_all,)."""
    fastest = np.abs(v[: of.n_q][of.kind[: of.n_q] == ROTATION]).max(initial=0.0)
    return turn / fastest if fastest > 0.0 else np.inf


@entry
def correct(of: Unknowns, length: float, dz: Vector, by: Weights, start: Motion, s_out: Motion) -> float:
    """Subtract the correction dz (n,), with the weights ``by``; return its ``largest`` component.

    Rotations are counted from those of the Motion ``start``, in whose axes their corrections are. Axes are turned by
    exp(psi) alone: products of the matrices R, which rounding leaves orthogonal to 1e-14 only, would change rates.
    """
    for i in range(of.n_q):
        if of.kind[i] != ROTATION:
            s_out.z[i] -= dz[i]
            s_out.v[i] -= by.cC * dz[i]
            s_out.a[i] -= by.cM * dz[i]
    for i in range(of.n_q, of.n):
        s_out.z[i] -= by.k * dz[i]
    for r in range(of.rotation_dof.shape[0]):
        d = of.rotation_dof[r]
        if d < of.n_q:
            turn, change, omega = exp(vec(s_out.z, d)), vec(dz, d), vec(start.v, d)
            put(s_out.v, d, turn @ vec(s_out.v, d) - by.cC * change)
            put(s_out.a, d, turn @ vec(s_out.a, d) - by.cM * change)
            put(s_out.z, d, vec(s_out.z, d) - change + (by.cC * axis_share(by.h, omega)) * cross(omega, change))
            place(r, d, start.R, s_out)
    return largest(dz, of.kind, of.n_q, length)


@entry
def largest(dz: Vector, kind: Indices, n_q: int, length: float) -> float:
    """Return the largest displacement over the length scale, or rotation [rad], of dz (n,); inf if not finite.

    Signals, which have other units, do not count.
    """
    worst = 0.0
    for i in range(n_q):
        x = abs(dz[i]) / (1.0 if kind[i] == ROTATION else length)
        if not x <= HUGE:
            return np.inf
        if kind[i] < SIGNAL:
            worst = max(worst, x)
    return worst


@kernel
def finish(w, of, start, s, before, after_out):
    """Compute the algorithmic acceleration (n_all,), and the differences (n,) of ``predict`` over a step.

    ``w`` is the record STEP (workspace.py); ``start`` and ``s`` are the Motion at both ends, ``before`` the true and
    the algorithmic acceleration, slope and bend at the beginning in the axes of the end (``carried_history``), and
    ``after_out`` the history (``history_of``) at the end.

    Returns the largest change of the acceleration (``compared``) of a node (the length of the vector), over the length
    scale for displacements, or of a scalar with inertia; and the largest component of a rotation increment [rad].
    """
    true, a0, slope, bend = before
    a, slope_out, bend_out = after_out
    am, af, known, last, turn = w.am, w.af, w.known, w.taken / w.h, 0.0
    for i in range(of.n_q):
        a[i] = ((1.0 - af) * s.a[i] + af * true[i] - am * a0[i]) / (1.0 - am)
        if of.kind[i] == ROTATION:
            turn = max(turn, abs(s.z[i]))
        slope_out[i] = s.z[i] - start.z[i] if of.kind[i] == SIGNAL else s.a[i] - true[i]
    for i in range(of.n_q, of.n):
        slope_out[i] = s.z[i] - start.z[i]
    for i in range(of.n):  # the parabola through both ends of this step and the beginning of the last one
        bent = 2.0 / (1.0 + last) * (slope_out[i] - slope[i] - 0.5 * (1.0 - last) * bend[i])
        bend_out[i] = bent if known or of.kind[i] == SIGNAL else 0.0
    began, ended = compared(am, true, s.a, a0, a)
    return largest_change(began, ended, of.kind, of.n_q, w.length), turn


@kernel
def carried_history(w):
    """Return the true and algorithmic accelerations (n_all,), slope and bend (n,) of BEGIN in the axes of TRIAL."""
    start, s, of, (a0, slope, bend) = state_of(w, BEGIN), state_of(w, TRIAL), unknowns_of(w), history_of(w, BEGIN)
    at, size = w.carried, 8 * w.n_all
    true, a, slope_out, bend_out = (
        floats(at, w.n_all), floats(at + size, w.n_all), floats(at + 2 * size, w.n), floats(at + 3 * size, w.n)
    )  # fmt: skip
    for i in range(w.n_q):
        true[i], a[i] = start.a[i], a0[i]
    for i in range(w.n):
        slope_out[i], bend_out[i] = slope[i], bend[i]
    for r in range(w.n_rotations):
        d = of.rotation_dof[r]
        if d < of.n_q:
            turn = exp(vec(s.z, d)).T
            put(true, d, turn @ vec(start.a, d))
            put(a, d, turn @ vec(a0, d))
            put(slope_out, d, turn @ vec(slope, d))
            put(bend_out, d, turn @ vec(bend, d))
    return true, a, slope_out, bend_out


@kernel
def compared(am, a0, a1, algorithmic0, algorithmic1):
    """Return the accelerations at both ends of a step, the algorithmic ones or those of the motion, for its error.

    A difference of both kinds, as the modal filter leaves at starts, moves nothing: it changes its sign in each step,
    and falls by am/(1 - am). With am = 1/2 (rho_inf = 1) it never falls, and would make the steps ever shorter.
    """
    return (algorithmic0, algorithmic1) if am < 0.5 else (a0, a1)


@entry
def largest_change(x0: Vector, x: Vector, kind: Indices, n_q: int, length: float) -> float:
    """Return the largest change from x0 to x (n_q,) of a node (length of its vector), or a scalar with inertia.

    It counts over ``length`` for displacements and scalars.
    """
    worst = square = 0.0
    for i in range(n_q):
        if kind[i] == MASSLESS or kind[i] >= SIGNAL:
            continue
        change = (x[i] - x0[i]) / (1.0 if kind[i] == ROTATION else length)
        begins = i % 3 == 0 or kind[i] == SCALAR  # the unknowns of nodes come first, in threes
        square = change * change + (0.0 if begins else square)
        worst = max(worst, square)
    return math.sqrt(worst)


@entry
def move(of: Unknowns, dt: float, s: Motion, s_out: Motion):
    """Write positions and rotations of ``s`` moved by dt v + dt^2/2 a; v, a (>= n_q,), rotations materially."""
    half = 0.5 * dt * dt
    for i in range(of.n_q):
        s_out.z[i] = (0.0 if of.kind[i] == ROTATION else s.z[i]) + (dt * s.v[i] + half * s.a[i])
    place_rotations(of.rotation_dof, of.n_q, s_out.z, s.R, s_out.R)


@kernel
def extrapolate(w, source, dt, target):
    """Write the state ``source`` of the workspace, moved by dt [s] at its accelerations, to ``target``."""
    copy_state(w, source, target)
    s, s_out = state_of(w, source), state_of(w, target)
    move(unknowns_of(w), dt, s, s_out)
    time_of(w, target)[0] += dt
    for i in range(w.n_all):
        s_out.v[i] += dt * s.a[i]


def displaced(s: State, dq: np.ndarray, of: Numbering) -> State:
    """Return a copy of ``s`` with positions (and rotations, by material increments) moved by dq (n_q,)."""
    out = s.copy()
    move(of, 1.0, Motion(s.z, dq, np.zeros(of.n_q), s.R), out)
    return out


def moved(s: State, dt: float, of: Numbering) -> State:
    """Return the state extrapolated by dt [s] along its velocities and accelerations (second order)."""
    out = s.copy()
    move(of, dt, s, out)
    out.v += dt * s.a
    out.t = s.t + dt
    return out

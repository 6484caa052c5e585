"""Updates of a state: prediction, correction, rotations from their increments."""

import math

import numpy as np

from mecano.jit.entry import Indices, Matrices, Vector, entry
from mecano.jit.kernel import kernel
from mecano.maths.so3 import exp, tangent
from mecano.maths.vector import mat, put_matrix, vec
from mecano.model.numbering import MASSLESS, ROTATION, SCALAR, SIGNAL, TRANSLATION, Numbering, Unknowns
from mecano.model.state import Motion, State
from mecano.solve.time.turning_error import turning_error
from mecano.solve.time.workspace import copy_state, state_of, time_of, unknowns_of


@kernel
def place_rotations(rotation_dof, n_q, z, R0, R_out):
    """Compute R = R0 exp(hat(psi)) of all free rotations, with psi in z."""
    for r in range(rotation_dof.shape[0]):
        d = rotation_dof[r]
        if d < n_q:
            psi = vec(z, d)
            put_matrix(R_out[r], mat(R0[r]) @ exp(psi))


@entry
def tangents(rotation_dof: Indices, n_q: int, z: Vector, T_out: Matrices):
    """Compute T(psi) (n_rotations, 3, 3) of all free rotations, with psi in z."""
    for r in range(rotation_dof.shape[0]):
        d = rotation_dof[r]
        if d < n_q:
            put_matrix(T_out[r], tangent(vec(z, d)))


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
    place_rotations(of.rotation_dof, of.n_q, s_out.z, start.R, s_out.R)
    return farthest, loudest


def reach_of(z: np.ndarray, of: Numbering, length: float) -> float:
    """Return the largest coordinate of a node in z (n_all,), free or fixed, over the length scale; at least 1."""
    return max(np.abs(z[of.kind == TRANSLATION]).max(initial=0.0) / length, 1.0)


def longest_step(v: np.ndarray, of: Numbering, turn: float) -> float:
    """Return the longest step [s] in which no body turns by more than ``turn`` [rad] about an axis at v (n_all,)."""
    fastest = np.abs(v[: of.n_q][of.kind[: of.n_q] == ROTATION]).max(initial=0.0)
    return turn / fastest if fastest > 0.0 else np.inf


@entry
def correct(
    of: Unknowns, length: float, dz: Vector, k: float, cC: float, cM: float, R0: Matrices, s_out: Motion
) -> float:  # fmt: skip
    """Subtract the correction dz (n,); velocities and accelerations by cC and cM, multipliers by k.

    R0 (n_rotations, 3, 3) are the rotations from which those of the state are counted. Returns the ``largest``
    component of dz.
    """
    for i in range(of.n_q):
        s_out.z[i] -= dz[i]
        s_out.v[i] -= cC * dz[i]
        s_out.a[i] -= cM * dz[i]
    for i in range(of.n_q, of.n):
        s_out.z[i] -= k * dz[i]
    place_rotations(of.rotation_dof, of.n_q, s_out.z, R0, s_out.R)
    return largest(dz, of.kind, of.n_q, length)


@entry
def largest(dz: Vector, kind: Indices, n_q: int, length: float) -> float:
    """Return the largest displacement over the length scale, or rotation [rad], of dz (n,); inf if not finite.

    Signals, which have other units, do not count.
    """
    worst = 0.0
    for i in range(n_q):
        x = abs(dz[i]) / (1.0 if kind[i] == ROTATION else length)
        if not x <= 1e300:
            return np.inf
        if kind[i] < SIGNAL:
            worst = max(worst, x)
    return worst


@kernel
def finish(w, of, start, s, before, after_out):
    """Compute the algorithmic acceleration (n_all,), and the differences (n,) of ``predict`` over a step.

    ``w`` is the record STEP (workspace.py); ``start`` and ``s`` are the Motion, ``before`` and ``after_out`` the
    history (``history_of``) at both ends.

    Returns the largest change of the acceleration (``compared``) of a node (the length of the vector), over the length
    scale for displacements, or of a scalar with inertia; the largest component of a rotation increment [rad]; and the
    error of bodies that spin [rad] (turning_error.py) in a run.
    """
    a0, slope, bend = before
    a, slope_out, bend_out = after_out
    am, af, known, last, turn = w.am, w.af, w.known, w.taken / w.h, 0.0
    for i in range(of.n_q):
        a[i] = ((1.0 - af) * s.a[i] + af * start.a[i] - am * a0[i]) / (1.0 - am)
        if of.kind[i] == ROTATION:
            turn = max(turn, abs(s.z[i]))
        slope_out[i] = s.z[i] - start.z[i] if of.kind[i] == SIGNAL else s.a[i] - start.a[i]
    for i in range(of.n_q, of.n):
        slope_out[i] = s.z[i] - start.z[i]
    for i in range(of.n):  # the parabola through both ends of this step and the beginning of the last one
        bent = 2.0 / (1.0 + last) * (slope_out[i] - slope[i] - 0.5 * (1.0 - last) * bend[i])
        bend_out[i] = bent if known or of.kind[i] == SIGNAL else 0.0
    turning = turning_error(w.h, w.duration, of.rotation_dof, of.n_q, s.v, a0, a, a[:0])
    began, ended = compared(am, start.a, s.a, a0, a)
    return largest_change(began, ended, of.kind, of.n_q, w.length), turn, turning


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

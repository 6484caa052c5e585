"""Updates of a state: prediction, correction, rotations from their increments."""

import math

import numpy as np

from mecano.jit.entry import Indices, Matrices, Vector, entry
from mecano.jit.kernel import kernel
from mecano.maths.so3 import exp, tangent
from mecano.maths.vector import mat, vec
from mecano.model.numbering import MASSLESS, ROTATION, SCALAR, SIGNAL, TRANSLATION
from mecano.solve.time.turning_error import turning_error


@kernel
def put_matrix(A, out):
    """out[:, :] = A"""
    for i in range(3):
        row = A[i]
        out[i, 0] = row[0]
        out[i, 1] = row[1]
        out[i, 2] = row[2]


@kernel
def place_rotations(rotation_dof, n_q, z, R0, R_out):
    """Compute R = R0 exp(hat(psi)) of all free rotations, with psi in z."""
    for r in range(rotation_dof.shape[0]):
        d = rotation_dof[r]
        if d < n_q:
            psi = vec(z, d)
            put_matrix(mat(R0[r]) @ exp(psi), R_out[r])


@entry
def tangents(rotation_dof: Indices, n_q: int, z: Vector, T_out: Matrices):
    """Compute T(psi) (n_rotations, 3, 3) of all free rotations, with psi in z."""
    for r in range(rotation_dof.shape[0]):
        d = rotation_dof[r]
        if d < n_q:
            put_matrix(tangent(vec(z, d)), T_out[r])


@kernel
def predict(
    am, af, beta, gamma, kind, rotation_dof, n_q, n, h, a0, acceleration0, slope, bend, v_shift, R0,
    z_out, v_out, acceleration_out, R_out,
):  # fmt: skip
    """Move a state to the end of a step of size h: accelerations and multipliers extrapolated by a parabola.

    z_out, v_out, acceleration_out (n_all,) and R_out hold the state at the beginning of the step and are moved. a0
    (n_all,) algorithmic, acceleration0 (n_all,) true acceleration there; slope, bend (n,) differences of the true ones
    and of the multipliers. Returns the largest coordinate [m] and the largest signal.
    """
    farthest = loudest = 0.0
    for i in range(n_q):
        guess = acceleration0[i] + slope[i] + bend[i]
        a1 = ((1.0 - af) * guess + af * acceleration0[i] - am * a0[i]) / (1.0 - am)
        v0 = v_out[i] + v_shift[i]
        increment = h * v0 + h * h * ((0.5 - beta) * a0[i] + beta * a1)
        z_out[i] = increment if kind[i] == ROTATION else z_out[i] + increment
        v_out[i] = v0 + h * ((1.0 - gamma) * a0[i] + gamma * a1)
        acceleration_out[i] = guess
        if kind[i] >= SIGNAL:
            loudest = max(loudest, abs(z_out[i]))
        elif kind[i] != ROTATION:
            farthest = max(farthest, abs(z_out[i]))
    for i in range(n_q, n):
        z_out[i] += slope[i] + bend[i]
    place_rotations(rotation_dof, n_q, z_out, R0, R_out)
    return farthest, loudest


def reach_of(z, of, length):
    """Return the largest coordinate of a node in z (n_all,), free or fixed, over the length scale; at least 1."""
    return max(np.abs(z[of.kind == TRANSLATION]).max(initial=0.0) / length, 1.0)


@entry
def correct(
    length: float, kind: Indices, rotation_dof: Indices, n_q: int, n: int, dz: Vector, k: float, cC: float, cM: float,
    R0: Matrices, z_out: Vector, v_out: Vector, a_out: Vector, R_out: Matrices,
) -> float:  # fmt: skip
    """Subtract the correction dz (n,); velocities and accelerations by cC and cM, multipliers by k.

    Returns its ``largest`` component.
    """
    for i in range(n_q):
        z_out[i] -= dz[i]
        v_out[i] -= cC * dz[i]
        a_out[i] -= cM * dz[i]
    for i in range(n_q, n):
        z_out[i] -= k * dz[i]
    place_rotations(rotation_dof, n_q, z_out, R0, R_out)
    return largest(dz, kind, n_q, length)


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
def finish(
    am, af, length, duration, kind, rotation_dof, n_q, n, h, a0, slope, known, acceleration0, z0, acceleration, z, v,
    a_out, slope_out, bend_out,
):  # fmt: skip
    """Compute the algorithmic acceleration (n_all,), differences of accelerations and multipliers (n,) of a step.

    Returns the largest change of the algorithmic acceleration of a node (the length of the vector), over ``length`` for
    displacements, or of a scalar with inertia; the largest component of a rotation increment [rad]; and the error of
    bodies that spin [rad] (turning_error.py) in a run of the ``duration`` [s].
    """
    turn = 0.0
    for i in range(n_q):
        a_out[i] = ((1.0 - af) * acceleration[i] + af * acceleration0[i] - am * a0[i]) / (1.0 - am)
        if kind[i] == ROTATION:
            turn = max(turn, abs(z[i]))
        slope_out[i] = acceleration[i] - acceleration0[i]
    for i in range(n_q, n):
        slope_out[i] = z[i] - z0[i]
    for i in range(n):
        bend_out[i] = slope_out[i] - slope[i] if known else 0.0
    turning = turning_error(h, duration, rotation_dof, n_q, v, a0, a_out)
    return largest_change(a0, a_out, kind, n_q, length), turn, turning


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
def move(
    kind: Indices, rotation_dof: Indices, n_q: int, dt: float, z: Vector, v: Vector, a: Vector, R: Matrices,
    z_out: Vector, R_out: Matrices,
):  # fmt: skip
    """Move positions and rotations by dt v + dt^2/2 a; v, a (>= n_q,), rotations by material increments."""
    half = 0.5 * dt * dt
    for i in range(n_q):
        z_out[i] = (0.0 if kind[i] == ROTATION else z[i]) + (dt * v[i] + half * a[i])
    place_rotations(rotation_dof, n_q, z_out, R, R_out)


def displaced(s, dq, of):
    """Return a copy of ``s`` with positions (and rotations, by material increments) moved by dq (n_q,)."""
    out = s.copy()
    move(of.kind, of.rotation_dof, of.n_q, 1.0, s.z, dq, np.zeros(of.n_q), s.R, out.z, out.R)
    return out


def moved(s, dt, of):
    """Return the state extrapolated by dt [s] along its velocities and accelerations (second order)."""
    out = s.copy()
    move(of.kind, of.rotation_dof, of.n_q, dt, s.z, s.v, s.a, s.R, out.z, out.R)
    out.v += dt * s.a
    out.t = s.t + dt
    return out

"""Moving a state: prediction, correction, and rotations placed from their increments."""

import numpy as np
from numba import njit

from mecano.maths.so3 import exp, tangent
from mecano.maths.vec import mat, matmul, vec
from mecano.model.numbering import ROTATION


@njit
def put_matrix(A, out):
    """out[:, :] = A"""
    for i in range(3):
        row = A[i]
        out[i, 0] = row[0]
        out[i, 1] = row[1]
        out[i, 2] = row[2]


@njit(cache=True)
def place_rotations(rotation_dof, n_q, z, R0, R_out, T_out):
    """R = R0 exp(hat(psi)) and T = T(psi) for all free rotations; psi stands in z."""
    for r in range(rotation_dof.shape[0]):
        d = rotation_dof[r]
        if d < n_q:
            psi = vec(z, d)
            put_matrix(matmul(mat(R0[r]), exp(psi)), R_out[r])
            put_matrix(tangent(psi), T_out[r])


@njit(cache=True)
def predict(h, am, af, beta, gamma, a0, acceleration0, guess, v_shift, rate, kind, n_q, n, z, v, acceleration):
    """Positions, rotation increments, velocities of a step whose accelerations are ``guess``; z, v, a in place.

    a0 (n_all,) algorithmic and acceleration0 (n_all,) true acceleration at the start of the step; rate (n_l,) of the
    multipliers.
    """
    for i in range(n_q):
        a1 = ((1.0 - af) * guess[i] + af * acceleration0[i] - am * a0[i]) / (1.0 - am)
        v0 = v[i] + v_shift[i]
        increment = h * v0 + h * h * ((0.5 - beta) * a0[i] + beta * a1)
        z[i] = increment if kind[i] == ROTATION else z[i] + increment
        v[i] = v0 + h * ((1.0 - gamma) * a0[i] + gamma * a1)
        acceleration[i] = guess[i]
    for i in range(n_q, n):
        z[i] += h * rate[i - n_q]


@njit(cache=True)
def correct_motion(dz, n_q, n, k, cC, cM, z, v, a):
    """Add a Newton correction dz (n,): velocities and accelerations follow by cC and cM; multipliers scaled by k."""
    for i in range(n_q):
        z[i] += dz[i]
        v[i] += cC * dz[i]
        a[i] += cM * dz[i]
    for i in range(n_q, n):
        z[i] += k * dz[i]


def displaced(s, dq, of):
    """A copy of ``s`` with its positions (and rotations, material increments) moved by dq (n_q,)."""
    out = s.copy()
    rotations = of.kind[: of.n_q] == ROTATION
    out.z[: of.n_q] = np.where(rotations, 0.0, out.z[: of.n_q]) + dq
    place_rotations(of.rotation_dof, of.n_q, out.z, s.R, out.R, out.T)
    return out


def moved(s, dt, of):
    """The state carried on by dt [s] along its velocities and accelerations (second order)."""
    n_q = of.n_q
    out = displaced(s, dt * s.v[:n_q] + 0.5 * dt * dt * s.a[:n_q], of)
    out.v += dt * s.a
    out.t = s.t + dt
    return out

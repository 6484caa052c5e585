"""Eigenvalues of small motions about a state, non-holonomic constraints included: dense, from the element matrices."""

import numpy as np
import scipy.linalg as la
from marching import March

from mecano.maths.vec import skew


def matrices(system, s):
    """M, C, K (n, n) by inertial, non-spinning variations of the rotations, at a state with its reactions."""
    found = []
    for weights in ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)):
        system.assemble(s, 1.0, 0.0, *weights)
        A = np.zeros((system.n, system.n))
        A[system.rows, system.cols] = system.data[:-1]
        found.append(A)
    M, C, K = found
    P, G = np.eye(system.n), np.zeros((system.n, system.n))
    for r, d in enumerate(system.numbering.rotation_dof):
        if d < system.n_q:
            block = slice(d, d + 3)
            P[block, block] = s.R[r].T
            G[block, block] = -np.array(skew(tuple(s.R[r] @ s.v[block])))
    return P.T @ M @ P, P.T @ (C @ P + M @ P @ G), P.T @ K @ P


def eigenvalues(deck, largest=1e5):
    """Finite eigenvalues [1/s] of small motions about the start of a deck, by ascending modulus."""
    march = March(deck)
    run = march.march.begin(march.prepared.state, 1e-3)
    M, C, K = matrices(march.system, run.motion)
    n = len(M)
    eye, zero = np.eye(n), np.zeros((n, n))
    scale = 1e-6  # of the multipliers: forces and displacements of one size
    S = np.diag([*np.ones(march.system.n_q), *np.full(march.system.n_l, 1.0 / scale)])
    pencil = np.block([[zero, eye], [-K @ S, -C]]), np.block([[eye, zero], [zero, M]])
    alpha, beta = la.eig(*pencil, right=False, homogeneous_eigvals=True)
    finite = np.abs(alpha) < largest * np.abs(beta)
    return np.array(sorted(alpha[finite] / beta[finite], key=lambda x: (abs(x), x.imag)))

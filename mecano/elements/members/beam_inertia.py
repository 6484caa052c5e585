r"""Inertia and weight of a two-node beam: cubic (Hermite) interpolation of the line of mass centres.

The line of mass centres is interpolated from its ends :math:`x_i + R_i c_i` and its tangents :math:`R_i t_i` there,
which rotate with the sections (t: tangent of the strain-free shape times the length). With the nodal values
:math:`w = (x_1 + R_1 c_1, R_1 t_1, x_2 + R_2 c_2, R_2 t_2)` the kinetic energy of translation is
:math:`\tfrac12 \sum m_{kl}\, \dot w_k \cdot \dot w_l`; the weight acts on the same interpolation, so that a - g
replaces a. The constants are those of the cubics plus 19/420 m z z^T, z = (-1, -1/2, 1, -1/2),
which is of sixth order in bending and makes axial waves accurate to fourth order too:

.. math::  (m_{kl}) = m \begin{pmatrix} 5/12 & 3/40 & 1/12 & -1/120\\ & 1/48 & 1/120 & 1/240\\ & & 5/12 & -3/40\\
           & & & 1/48 \end{pmatrix}

The rotary inertia is interpolated from the angular velocities in section axes, with the weights 5/12, 1/12 that make
torsional waves accurate to fourth order.
"""

from typing import NamedTuple

import numpy as np

from mecano.jit.kernel import inlined, kernel
from mecano.maths.vector import EYE, add_mat, add_vec, cross, cross_columns, dot, mat, outer, skew, vec

# products of line (L) and tangent (T) functions, of one node (M) and of both (N); opposite sign for T of node 2
M_LL, M_LT, M_TT = 5.0 / 12.0, 3.0 / 40.0, 1.0 / 48.0
N_LL, N_LT, N_TT = 1.0 / 12.0, 1.0 / 120.0, 1.0 / 240.0
OWN, OTHER = 5.0 / 12.0, 1.0 / 12.0  # weights of the rotary inertia


class Lever(NamedTuple):
    """The acceleration of A b for a vector b fixed in a node, and its derivatives, 3x3."""

    by_alpha: tuple  # by -alpha
    by_omega: tuple  # by -omega
    by_turn: tuple  # by -Theta
    acceleration: tuple


class Node(NamedTuple):
    """One end of the beam: the Levers of the tangent and of the mass centre there."""

    slot: int
    tangent: tuple
    center: tuple


class Weights(NamedTuple):
    """Constants [kg] of lines (L) and tangents (T) that couple one node to another."""

    LL: float
    LT: float
    TL: float
    TT: float


@inlined
def add_inertia(p, at, f, K, C, M):
    """Add residual and tangents of inertia and weight."""
    m, v, a, R1, R2 = p.mass, at.v, at.a, mat(at.R[0]), mat(at.R[1])
    u1, u2 = vec(a, 0) - vec(p.gravity, 0), vec(a, 6) - vec(p.gravity, 0)
    tangent_1 = _lever(R1, vec(p.t1, 0), vec(v, 3), vec(a, 3))
    tangent_2 = _lever(R2, vec(p.t2, 0), vec(v, 9), vec(a, 9))
    center_1, center_2 = tangent_1, tangent_2
    if p.eccentric:
        center_1 = _lever(R1, vec(p.c1, 0), vec(v, 3), vec(a, 3))
        center_2 = _lever(R2, vec(p.c2, 0), vec(v, 9), vec(a, 9))
        u1, u2 = u1 + center_1.acceleration, u2 + center_2.acceleration
    g1, g2 = tangent_1.acceleration, tangent_2.acceleration
    line_1 = M_LL * m * u1 + M_LT * m * g1 + (N_LL * m * u2 - N_LT * m * g2)
    line_2 = N_LL * m * u1 + N_LT * m * g1 + (M_LL * m * u2 - M_LT * m * g2)
    turn_1 = M_LT * m * u1 + M_TT * m * g1 + (N_LT * m * u2 + N_TT * m * g2)
    turn_2 = -N_LT * m * u1 + N_TT * m * g1 + (-M_LT * m * u2 + M_TT * m * g2)
    off = p.eccentric
    _add_force(off, (vec(p.c1, 0), vec(p.t1, 0)), R1, line_1, turn_1, 0, f, K)
    _add_force(off, (vec(p.c2, 0), vec(p.t2, 0)), R2, line_2, turn_2, 6, f, K)
    one, two = Node(0, tangent_1, center_1), Node(6, tangent_2, center_2)
    LL, LT, TT = M_LL * m, M_LT * m, M_TT * m
    _add_pair(off, one, one, Weights(LL, LT, LT, TT), K, C, M)
    _add_pair(off, two, two, Weights(LL, -LT, -LT, TT), K, C, M)
    LL, LT, TT = N_LL * m, N_LT * m, N_TT * m
    _add_pair(off, one, two, Weights(LL, -LT, LT, TT), K, C, M)
    _add_pair(off, two, one, Weights(LL, LT, -LT, TT), K, C, M)
    _add_rotary(mat(p.J1), mat(p.J2), mat(p.J12), v, a, f, C, M)


@inlined
def _lever(A, b, omega, alpha):
    """Return the Lever of b in a node with rotation A."""
    spin = cross(omega, b)
    g = cross(alpha, b) + cross(omega, spin)
    n = _turning(omega, b, spin)
    return Lever(cross_columns(A, b), A @ n, cross_columns(A, g), A @ g)


@kernel
def _turning(omega, b, spin):
    """Return hat(omega x b) + hat(omega) hat(b)."""
    return skew(spin) + (outer(b, omega) - dot(omega, b) * EYE)


@inlined
def _add_force(eccentric, arms, A, line, turn, i, f, K):
    """Add the forces on the node at slot i, and to K their change as they rotate with the node."""
    (c, t), line_body, turn_body = arms, A.T @ line, A.T @ turn
    add_vec(f, i, 1.0, line)
    moment, turned = cross(t, turn_body), skew(t) @ skew(turn_body)
    if eccentric:
        moment, turned = moment + cross(c, line_body), turned + skew(c) @ skew(line_body)
    add_vec(f, i + 3, 1.0, moment)
    add_mat(K, i + 3, i + 3, 1.0, turned)


@inlined
def _add_pair(eccentric, own, other, weights, K, C, M):
    """Add the inertia coupling of the Node ``other`` to the Node ``own``."""
    i, j = own.slot, other.slot
    levers = own.tangent.by_alpha.T, own.center.by_alpha.T
    for k in range(3):
        M[i + k, j + k] += weights.LL
    add_mat(M, i + 3, j, -weights.TL, levers[0])
    if eccentric:
        add_mat(M, i + 3, j, -weights.LL, levers[1])
    _add_columns(eccentric, levers, (other.tangent.by_alpha, other.center.by_alpha), (i, j), weights, M)
    _add_columns(eccentric, levers, (other.tangent.by_omega, other.center.by_omega), (i, j), weights, C)
    _add_columns(eccentric, levers, (other.tangent.by_turn, other.center.by_turn), (i, j), weights, K)


@inlined
def _add_columns(eccentric, levers, derivatives, slots, w, out):
    """Add derivatives by the rotation at slot j + 3, with which X (tangent) and X_c (mass centre) rotate."""
    (lever, lever_c), (X, X_c), (i, j) = levers, derivatives, slots
    add_mat(out, i, j + 3, -w.LT, X)
    add_mat(out, i + 3, j + 3, w.TT, lever @ X)
    if eccentric:
        add_mat(out, i, j + 3, -w.LL, X_c)
        add_mat(out, i + 3, j + 3, w.TL, lever @ X_c)
        line = w.LT * X + w.LL * X_c
        add_mat(out, i + 3, j + 3, 1.0, lever_c @ line)


@inlined
def _add_rotary(J1, J2, J12, v, a, f, C, M):
    """Add the rotary inertia: 1/2 Omega_1 . J1 Omega_1 + Omega_1 . J12 Omega_2 + 1/2 Omega_2 . J2 Omega_2."""
    omega_1, omega_2, alpha_1, alpha_2 = vec(v, 3), vec(v, 9), vec(a, 3), vec(a, 9)
    J21 = J12.T
    L_1, L_2 = J1 @ omega_1 + J12 @ omega_2, J21 @ omega_1 + J2 @ omega_2
    add_vec(f, 3, 1.0, J1 @ alpha_1 + J12 @ alpha_2 + cross(omega_1, L_1))
    add_vec(f, 9, 1.0, J21 @ alpha_1 + J2 @ alpha_2 + cross(omega_2, L_2))
    hat_1, hat_2 = skew(omega_1), skew(omega_2)
    add_mat(M, 3, 3, 1.0, J1)
    add_mat(M, 3, 9, 1.0, J12)
    add_mat(M, 9, 3, 1.0, J21)
    add_mat(M, 9, 9, 1.0, J2)
    add_mat(C, 3, 3, 1.0, hat_1 @ J1 + skew(-L_1))
    add_mat(C, 3, 9, 1.0, hat_1 @ J12)
    add_mat(C, 9, 3, 1.0, hat_2 @ J21)
    add_mat(C, 9, 9, 1.0, hat_2 @ J2 + skew(-L_2))


@kernel
def energies(p, q, v, R1, R2):
    """Return kinetic energy and potential energy of the weight [J]."""
    m, gravity, omega_1, omega_2 = p.mass, vec(p.gravity, 0), vec(v, 3), vec(v, 9)
    c1, c2, t1, t2 = R1 @ vec(p.c1, 0), R2 @ vec(p.c2, 0), R1 @ vec(p.t1, 0), R2 @ vec(p.t2, 0)
    w1, w2 = R1 @ omega_1, R2 @ omega_2
    v1, v2 = vec(v, 0) + cross(w1, c1), vec(v, 6) + cross(w2, c2)
    d1, d2 = cross(w1, t1), cross(w2, t2)
    total = 0.5 * M_LL * (dot(v1, v1) + dot(v2, v2)) + 0.5 * M_TT * (dot(d1, d1) + dot(d2, d2))
    total += M_LT * (dot(v1, d1) - dot(v2, d2)) + N_LL * dot(v1, v2) + N_TT * dot(d1, d2)
    total = m * (total + N_LT * (dot(d1, v2) - dot(v1, d2)))
    total += 0.5 * dot(omega_1, mat(p.J1) @ omega_1) + 0.5 * dot(omega_2, mat(p.J2) @ omega_2)
    total += dot(omega_1, mat(p.J12) @ omega_2)
    ends = vec(q, 0) + c1 + (vec(q, 6) + c2)
    line = (M_LL + N_LL) * ends + (M_LT + N_LT) * (t1 - t2)
    return total, -m * dot(gravity, line)


def inertia_record(mass, rotary, S_1, S_2, c, tangent):
    """Return the values of the record of one element.

    mass [kg] and rotary inertia (3, 3) [kg m2] about the line of mass centres are those of the whole element; c: mass
    centre from the node, tangent: that of the line times the length [m]; all in section axes, S_i: section to node
    axes.
    """
    return {
        "mass": mass, "eccentric": int(np.any(c != 0.0)),
        "c1": S_1 @ c, "t1": S_1 @ tangent, "c2": S_2 @ c, "t2": S_2 @ tangent,
        "J1": OWN * S_1 @ rotary @ S_1.T, "J2": OWN * S_2 @ rotary @ S_2.T, "J12": OTHER * S_1 @ rotary @ S_2.T,
    }  # fmt: skip

r"""Inertia and weight of a two-node beam: cubic (Hermite) interpolation of the line of mass centres.

The line of mass centres is interpolated from its ends :math:`x_i + R_i c_i` and its tangents :math:`R_i t_i` there,
which turn with the sections (t: tangent of the strain-free shape times the length). With the nodal values
:math:`w = (x_1 + R_1 c_1, R_1 t_1, x_2 + R_2 c_2, R_2 t_2)` the kinetic energy of translation is
:math:`\tfrac12 \sum m_{kl}\, \dot w_k \cdot \dot w_l` and the weight acts on the same interpolation, so that a - g takes
the place of a. The constants are those of the cubics plus 19/420 m z z^T, z = (-1, -1/2, 1, -1/2), of sixth order in
bending, which makes axial waves of fourth order too:

.. math::  (m_{kl}) = m \begin{pmatrix} 5/12 & 3/40 & 1/12 & -1/120\\ & 1/48 & 1/120 & 1/240\\ & & 5/12 & -3/40\\
           & & & 1/48 \end{pmatrix}

The angular velocities in section axes interpolate the rotary inertia, with the weights 5/12, 1/12 that make torsional
waves of fourth order. The products within one node are those of a rigid body (mass, first moment s, inertia J).
"""

import numpy as np
from numba import njit

from mecano.maths.vec import (
    add,
    add_mat,
    add_vec,
    cross,
    dot,
    madd,
    mat,
    matmul,
    mscale,
    mul,
    outer,
    scale,
    skew,
    sub,
    tmul,
    transpose,
    vec,
)  # fmt: skip

WEIGHTS = np.array(
    [
        [5 / 12, 3 / 40, 1 / 12, -1 / 120],
        [3 / 40, 1 / 48, 1 / 120, 1 / 240],
        [1 / 12, 1 / 120, 5 / 12, -3 / 40],
        [-1 / 120, 1 / 240, -3 / 40, 1 / 48],
    ]
)
OWN, OTHER = 5 / 12, 1 / 12  # of the rotary inertia


@njit
def add_inertia(p, v, a, R1, R2, W, f, K, C, M):
    """Add residual and tangents of inertia and weight; W = R1^T R2."""
    _add_own(p.mass, vec(p.s1, 0), mat(p.J1), p.gravity, v, a, R1, 0, f, K, C, M)
    _add_own(p.mass, vec(p.s2, 0), mat(p.J2), p.gravity, v, a, R2, 6, f, K, C, M)
    _add_rotary(mat(p.J12), vec(v, 3), vec(v, 9), vec(a, 3), vec(a, 9), f, C, M)
    WT = transpose(W)
    _add_cross(p, vec(p.c1, 0), vec(p.t1, 0), vec(p.q2, 0), vec(p.r2, 0), v, a, R1, R2, W, 0, 6, f, K, C, M)
    _add_cross(p, vec(p.c2, 0), vec(p.t2, 0), vec(p.q1, 0), vec(p.r1, 0), v, a, R2, R1, WT, 6, 0, f, K, C, M)


@njit
def _add_own(mass, s, J, gravity, v, a, A, i, f, K, C, M):
    """A rigid body on the node at slot i: mass, first moment s and inertia J in node axes."""
    omega, alpha = vec(v, i + 3), vec(a, i + 3)
    u = sub(vec(a, i), vec(gravity, 0))
    u_body, spin, momentum = tmul(A, u), cross(omega, s), mul(J, omega)
    w = add(cross(alpha, s), cross(omega, spin))
    add_vec(f, i, 1.0, add(scale(mass, u), mul(A, w)))
    add_vec(f, i + 3, 1.0, add(add(mul(J, alpha), cross(omega, momentum)), cross(s, u_body)))
    hat_s, hat_omega = skew(s), skew(omega)
    lever = matmul(A, hat_s)
    for j in range(3):
        M[i + j, i + j] += mass
    add_mat(M, i, i + 3, -1.0, lever)
    add_mat(M, i + 3, i, -1.0, transpose(lever))
    add_mat(M, i + 3, i + 3, 1.0, J)
    add_mat(C, i, i + 3, -1.0, matmul(A, madd(skew(spin), matmul(hat_omega, hat_s))))
    add_mat(C, i + 3, i + 3, 1.0, madd(matmul(hat_omega, J), mscale(-1.0, skew(momentum))))
    add_mat(K, i, i + 3, -1.0, matmul(A, skew(w)))
    add_mat(K, i + 3, i + 3, 1.0, matmul(hat_s, skew(u_body)))


@njit
def _add_rotary(J12, omega_1, omega_2, alpha_1, alpha_2, f, C, M):
    """The product Omega_1 . J12 Omega_2 of the rotary inertia."""
    J21 = transpose(J12)
    L_1, L_2 = mul(J12, omega_2), mul(J21, omega_1)
    add_vec(f, 3, 1.0, add(mul(J12, alpha_2), cross(omega_1, L_1)))
    add_vec(f, 9, 1.0, add(mul(J21, alpha_1), cross(omega_2, L_2)))
    add_mat(M, 3, 9, 1.0, J12)
    add_mat(M, 9, 3, 1.0, J21)
    add_mat(C, 3, 3, -1.0, skew(L_1))
    add_mat(C, 9, 9, -1.0, skew(L_2))
    add_mat(C, 3, 9, 1.0, matmul(skew(omega_1), J12))
    add_mat(C, 9, 3, 1.0, matmul(skew(omega_2), J21))


@njit
def _add_cross(p, c, t, q, r, v, a, A, B, W, i, j, f, K, C, M):
    """What the motion of the node at slot j asks of the node at slot i; W = A^T B, q and r: moments of node j.

    The line function and the tangent function of node i feel the accelerations m_ij (a_j - g) + R_j (...)(q) and
    m_tj (a_j - g) + R_j (...)(r).
    """
    omega, alpha = vec(v, j + 3), vec(a, j + 3)
    u = sub(vec(a, j), vec(p.gravity, 0))
    tangent_mass = p.tangent_mass if i == 0 else -p.tangent_mass
    g_q = add(cross(alpha, q), cross(omega, cross(omega, q)))
    g_r = add(cross(alpha, r), cross(omega, cross(omega, r)))
    line, tangent = mul(B, g_q), mul(B, g_r)
    line = add(line, scale(p.cross_mass, u))
    tangent = add(tangent, scale(tangent_mass, u))
    line_body, tangent_body = tmul(A, line), tmul(A, tangent)
    add_vec(f, i, 1.0, line)
    add_vec(f, i + 3, 1.0, add(cross(c, line_body), cross(t, tangent_body)))
    hat_c, hat_t, hat_q, hat_r = skew(c), skew(t), skew(q), skew(r)
    for k in range(3):
        M[i + k, j + k] += p.cross_mass
    lever = add(scale(p.cross_mass, c), scale(tangent_mass, t))
    add_mat(M, i + 3, j, 1.0, matmul(skew(lever), transpose(A)))
    add_mat(M, i, j + 3, -1.0, matmul(B, hat_q))
    cW, tW = matmul(hat_c, W), matmul(hat_t, W)
    add_mat(M, i + 3, j + 3, -1.0, madd(matmul(cW, hat_q), matmul(tW, hat_r)))
    hat_omega = skew(omega)
    n_q = madd(skew(cross(omega, q)), matmul(hat_omega, hat_q))
    n_r = madd(skew(cross(omega, r)), matmul(hat_omega, hat_r))
    add_mat(C, i, j + 3, -1.0, matmul(B, n_q))
    add_mat(C, i + 3, j + 3, -1.0, madd(matmul(cW, n_q), matmul(tW, n_r)))
    add_mat(K, i, j + 3, -1.0, matmul(B, skew(g_q)))
    add_mat(K, i + 3, j + 3, -1.0, madd(matmul(cW, skew(g_q)), matmul(tW, skew(g_r))))
    add_mat(K, i + 3, i + 3, 1.0, madd(matmul(hat_c, skew(line_body)), matmul(hat_t, skew(tangent_body))))


@njit
def kinetic_energy(p, v, R1, R2):
    """Kinetic energy [J]."""
    omega_1, omega_2 = vec(v, 3), vec(v, 9)
    v1, v2 = vec(v, 0), vec(v, 6)
    total = dot(omega_1, mul(mat(p.J12), omega_2))
    for x_rate, omega, A, s, J in ((v1, omega_1, R1, p.s1, p.J1), (v2, omega_2, R2, p.s2, p.J2)):
        spin = mul(A, cross(omega, vec(s, 0)))
        total += 0.5 * p.mass * dot(x_rate, x_rate) + dot(x_rate, spin) + 0.5 * dot(omega, mul(mat(J), omega))
    line = add(scale(p.cross_mass, v2), mul(R2, cross(omega_2, vec(p.q2, 0))))
    tangent = add(scale(p.tangent_mass, v2), mul(R2, cross(omega_2, vec(p.r2, 0))))
    total += dot(add(v1, mul(R1, cross(omega_1, vec(p.c1, 0)))), line)
    return total + dot(mul(R1, cross(omega_1, vec(p.t1, 0))), tangent)


@njit
def weight_energy(p, q, R1, R2):
    """Potential energy of the weight [J]: -g . (integral of the line of mass centres)."""
    first = mul(R1, vec(p.g1, 0))
    second = mul(R2, vec(p.g2, 0))
    ends = scale(p.mass + p.cross_mass, add(vec(q, 0), vec(q, 6)))
    return -dot(vec(p.gravity, 0), add(ends, add(first, second)))


def inertia_record(mass, rotary, S_1, S_2, c, tangent):
    """Values of the record of one element.

    mass [kg] and rotary inertia (3, 3) [kg m2] about the line of mass centres, of the whole element; c mass centre from
    the node, tangent of that line times the length [m]; all in section axes, S_i section to node axes.
    """
    m, values = mass * WEIGHTS, {}
    for i, S in ((1, S_1), (2, S_2)):
        levers, here, there = np.array([S @ c, S @ tangent]), slice(2 * i - 2, 2 * i), slice(4 - 2 * i, 6 - 2 * i)
        own, other = m[here, here] @ levers, m[there, here] @ levers
        J = OWN * S @ rotary @ S.T + np.sum(own * levers) * np.eye(3) - own.T @ levers
        weight = mass * (0.5 * levers[0] + (1.5 - i) / 6.0 * levers[1])
        moments = (levers[0], levers[1], own[0], other[0], other[1], weight)
        values |= {f"J{i}": J, **{f"{letter}{i}": value for letter, value in zip("ctsqrg", moments, strict=True)}}
    J12 = OTHER * S_1 @ rotary @ S_2.T
    return {**values, "J12": J12, "mass": m[0, 0], "cross_mass": m[0, 2], "tangent_mass": m[1, 2]}

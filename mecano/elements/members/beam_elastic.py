r"""Elastic and viscous forces of a two-node beam, from the relative motion of its end sections on SE(3).

The section axes at the ends are :math:`A_1 = R_1 S` and :math:`A_2 = R_2` (S constant: all section data are
stored in the axes of the second node). The strain measure is the screw motion from one section to the other,

.. math::  \varphi = \log(A_1^T A_2), \qquad u = H y + \varphi \times c, \quad y = A_2^T (x_2 - x_1), \quad
    H = T^{-1}(\varphi)

that is :math:`(u, \varphi) = \log_{SE(3)}`, here of the line of shear centres, at c from the nodes; it is constant
along a helix, hence along every circular arc (Sonneville, Cardona & Bruels 2014). With the strains
:math:`e = (u - u_0, \varphi - \varphi_0)` and the constant element stiffness :math:`K_e` of beam_flexibility.py,

.. math::  V = \tfrac12 \bar e \cdot K_e \bar e, \qquad \bar e = (e_u + a\, (\lambda - a \cdot u), e_\varphi), \qquad
    \lambda^2 = (a \cdot u)^2 + e_u \cdot D e_u

.. math::  (p_u, p_\varphi) = \bar G^T K_e (\bar e + \tau \dot{\bar e}), \qquad \bar G = \partial \bar e/\partial e

.. math::  f_{x2} = A_2 P = -f_{x1}, \quad P = H^T p_u, \qquad
    m_2 = P \times y + H^T Q, \quad m_1 = -S H Q, \quad Q = p_\varphi + (\partial u/\partial\varphi)^T p_u

The length :math:`\lambda` of the line, with the unit vector a along the beam, is part of the flexibility: where the end
sections are tilted by gamma relative to the chord because the element bends in an S shape, its line is longer than its
component along the section axes, by :math:`\tfrac35 \gamma^2 L` for a slender element (D = 6/5 across the beam). With
the component alone, every tension of more than 12 EI/L^2 would tilt the sections.
"""

from typing import NamedTuple

from mecano.jit.kernel import inlined, kernel
from mecano.maths.dual import anywhere, select, sqrt
from mecano.maths.rotation_vector import (
    first_derivative,
    inverse_coefficients,
    inverse_tangent,
    inverse_tangent_rate,
    second_derivative,
    second_form,
)
from mecano.maths.so3 import log
from mecano.maths.vector import add_mat, add_vec, cross, cross_columns, dot, mat, outer, skew, vec


class Screw(NamedTuple):
    """The screw motion from the first to the second end section, and derivatives of its strains."""

    u: tuple
    phi: tuple
    y: tuple
    H: tuple  # du/dy = T^-1(phi)
    E: tuple  # du/dphi
    c: float  # coefficients of T^-1 (rotation_vector.inverse_coefficients)
    c1: float
    c2: float


class Line(NamedTuple):
    """The bent line of an element."""

    length: float  # lambda
    more: float  # lambda - a.u
    g: tuple  # its derivative by u


class Rates(NamedTuple):
    """Rates of the screw motion."""

    u: tuple
    phi: tuple
    y: tuple


class Jacobian(NamedTuple):
    """Derivatives, 3x3, of stretched strain and phi by d = x_2 - x_1 and by the material rotations of both nodes."""

    U_d: tuple
    U_1: tuple
    U_2: tuple
    F_1: tuple
    F_2: tuple


@inlined
def strains(p, at, u0, phi0):
    """Return the Screw and the strains u - u0, phi - phi0."""
    R2 = mat(at.R[1])
    phi = log(mat(p.S).T @ (mat(at.R[0]).T @ R2))
    c, c1, c2 = inverse_coefficients(dot(phi, phi))
    y = R2.T @ (vec(at.q, 6) - vec(at.q, 0))
    H = inverse_tangent(phi, c)
    shift = mat(p.shift)
    u = H @ y + shift @ phi
    return Screw(u, phi, y, H, first_derivative(phi, y, -0.5, c, c1) + shift, c, c1, c2), u - u0, phi - phi0


@inlined
def bent_line(p, u, e_u):
    """Return the Line of an element with the screw u and the strain e_u = u - u0."""
    a, De = vec(p.along, 0), mat(p.D) @ e_u
    axial, square = dot(a, u), dot(e_u, De)
    length = sqrt(axial * axial + square)
    more = select(axial > 0.0, square / (length + axial), length - axial)
    return Line(length, more, (1.0 / length) * (De - more * a))


@inlined
def _curvature(p, line):
    """Return the second derivative of the length of the line by u."""
    a, g = vec(p.along, 0), line.g
    coupled = outer(a, g)
    return (1.0 / line.length) * (mat(p.D) - coupled - coupled.T - outer(g, g))


@kernel
def rate_along(p, rate, g):
    """Return the rate of the stretched strains for that of u."""
    return rate + dot(rate, g) * vec(p.along, 0)


@kernel
def stresses(p, e_u, e_phi):
    """Return K_e e: the generalized forces [N], [N m] of the stretched strains."""
    K_up = mat(p.K_up)
    p_u = mat(p.K_uu) @ e_u + K_up @ e_phi
    return p_u, K_up.T @ e_u + mat(p.K_pp) @ e_phi


@kernel
def unstretched(p, p_u, g):
    """Return the force conjugate to u from that conjugate to its stretched strain."""
    return p_u + dot(vec(p.along, 0), p_u) * g


@kernel
def strain_rates(p, at, s):
    """Return the Rates of the Screw ``s``."""
    v = at.v
    omega_1, omega_2 = mat(p.S).T @ vec(v, 3), vec(v, 9)
    y_rate = mat(at.R[1]).T @ (vec(v, 6) - vec(v, 0)) + cross(s.y, omega_2)
    phi_rate = s.H @ omega_2 - s.H.T @ omega_1
    return Rates(s.H @ y_rate + s.E @ phi_rate, phi_rate, y_rate)


@inlined
def end_loads(p, s, p_u, p_phi):
    """Return P, Q and the material moments m_1, m_2 on the nodes."""
    P = s.H.T @ p_u
    Q = p_phi + s.E.T @ p_u
    m_2 = cross(P, s.y) + s.H.T @ Q
    return P, Q, -(mat(p.S) @ (s.H @ Q)), m_2


@kernel
def add_elastic(p, at, u0, phi0, f, K, C):
    """Add residual and tangents of the elastic and viscous forces; (u0, phi0) is the strain-free screw."""
    s, e_u, e_phi = strains(p, at, u0, phi0)
    R2, line = mat(at.R[1]), bent_line(p, s.u, e_u)
    e_u = e_u + line.more * vec(p.along, 0)
    if anywhere(p.damping > 0.0):
        rates = strain_rates(p, at, s)
        _add_viscous(p, at, s, rates, line, K, C)
        e_u, e_phi = e_u + p.damping * rate_along(p, rates.u, line.g), e_phi + p.damping * rates.phi
    p_bar, p_phi = stresses(p, e_u, e_phi)
    p_u = unstretched(p, p_bar, line.g)
    P, Q, m_1, m_2 = end_loads(p, s, p_u, p_phi)
    n = R2 @ P
    add_vec(f, 0, -1.0, n)
    add_vec(f, 3, 1.0, m_1)
    add_vec(f, 6, 1.0, n)
    add_vec(f, 9, 1.0, m_2)
    _add_stiffness(p, s, _current_stiffness(p, line, dot(vec(p.along, 0), p_bar)), (p_u, P, Q), R2, K)


@kernel
def add_free_derivative(p, at, u0, phi0, change, column, K):
    """Add the derivative of the residual of ``add_elastic`` by a number with which u0 and phi0 ``change``.

    The change of u0 is along the beam, where D vanishes: the line keeps its length.
    """
    s, e_u, _ = strains(p, at, u0, phi0)
    p_bar, p_phi = stresses(p, *change)
    P, _, m_1, m_2 = end_loads(p, s, unstretched(p, p_bar, bent_line(p, s.u, e_u).g), p_phi)
    n = mat(at.R[1]) @ P
    for i in range(3):
        K[i, column] += n[i]
        K[3 + i, column] -= m_1[i]
        K[6 + i, column] -= n[i]
        K[9 + i, column] -= m_2[i]


@inlined
def _current_stiffness(p, line, tension):
    """Return the derivatives of p_u by u and phi: G^T K_uu G + N d2(lambda)/du2 and G^T K_up with G = I + a g^T."""
    K_uu, K_up, along, g = mat(p.K_uu), mat(p.K_up), vec(p.along, 0), line.g
    axial = K_uu @ along
    column = axial + 0.5 * dot(along, axial) * g
    K_uu = K_uu + tension * _curvature(p, line) + (outer(column, g) + outer(g, column))
    return K_uu, K_up + outer(g, K_up.T @ along)


@inlined
def _add_stiffness(p, s, stiffness, loads, R2, K):
    """Add material and geometric stiffness; only the blocks of a rotation with itself are not symmetric."""
    u, phi, y, H, E, c, c1, c2 = s
    (K_uu, K_up), (p_u, P, Q) = stiffness, loads
    S, HT = mat(p.S), H.T
    SHT = (S @ H).T  # H^T S^T
    HK = HT @ K_uu
    W_yy = HK @ H
    W_yp = HK @ E + HT @ K_up + first_derivative(phi, p_u, 0.5, c, c1)
    ET = E.T
    coupled = ET @ K_up
    W_pp = ET @ K_uu @ E + (coupled + coupled.T)
    W_pp = W_pp + (mat(p.K_pp) + second_form(phi, p_u, y, c, c1, c2))
    curl = first_derivative(phi, Q, 0.5, c, c1)  # d(H^T Q)/dphi
    Z = cross_columns(W_yy, y) + W_yp @ H + skew(-P)
    x_x = R2 @ W_yy @ R2.T
    x_1, x_2 = -(R2 @ (W_yp @ SHT)), R2 @ Z
    for i in range(2):
        sign = 1.0 if i else -1.0
        add_mat(K, 6 * i, 0, -sign, x_x)
        add_mat(K, 6 * i, 6, sign, x_x)
        add_mat(K, 6 * i, 3, sign, x_1)
        add_mat(K, 3, 6 * i, sign, x_1.T)
        add_mat(K, 6 * i, 9, sign, x_2)
        add_mat(K, 9, 6 * i, sign, x_2.T)
    U = HT @ W_pp + curl + cross_columns(W_yp.T, y).T
    two_one = -(U @ SHT)
    add_mat(K, 9, 3, 1.0, two_one)
    add_mat(K, 3, 9, 1.0, two_one.T)
    add_mat(K, 9, 9, 1.0, cross_columns(Z.T, y) + U @ H)
    turned = H @ W_pp + first_derivative(phi, Q, -0.5, c, c1)  # d(H Q)/dphi
    add_mat(K, 3, 3, 1.0, S @ (turned @ SHT))


@kernel
def _add_viscous(p, at, s, rates, line, K, C):
    """Add C = J^T (tau K_e) J and the part J^T (tau K_e) d(J v)/dq of K, J = d(u, phi)/d(d, Theta_1, Theta_2)."""
    u, phi, y, H, E, c, c1, c2 = s
    u_rate, phi_rate, y_rate = rates
    S, RT = mat(p.S), mat(at.R[1]).T
    omega_1, omega_2 = S.T @ vec(at.v, 3), vec(at.v, 9)
    F_1, F_2 = -(S @ H).T, H
    V_d, V_1, V_2 = H @ RT, E @ F_1, cross_columns(H, y) + E @ F_2
    stretch = outer(vec(p.along, 0), line.g)
    U_d, U_1, U_2 = V_d + stretch @ V_d, V_1 + stretch @ V_1, V_2 + stretch @ V_2
    J, zero = Jacobian(U_d, U_1, U_2, F_1, F_2), 0.0 * H
    _add_block(p, J, U_d, zero, 0, C)
    _add_block(p, J, U_1, F_1, 1, C)
    _add_block(p, J, U_2, F_2, 2, C)
    # rate of phi by phi
    slope = first_derivative(phi, omega_2, -0.5, c, c1) - first_derivative(phi, omega_1, 0.5, c, c1)
    N = first_derivative(phi, y_rate, -0.5, c, c1) + E @ slope
    N = N + second_derivative(phi, phi_rate, y, c, c1, c2)
    by_y = inverse_tangent_rate(phi, phi_rate, c, c1) - H @ skew(omega_2)
    carried = y_rate - cross(y, omega_2)
    D_2 = cross_columns(by_y, y) + cross_columns(H, carried) + N @ F_2
    D_d, D_1, turning = by_y @ RT, N @ F_1, outer(vec(p.along, 0), _curvature(p, line) @ u_rate)
    D_d = D_d + stretch @ D_d + turning @ V_d
    D_1 = D_1 + stretch @ D_1 + turning @ V_1
    D_2 = D_2 + stretch @ D_2 + turning @ V_2
    _add_block(p, J, D_d, zero, 0, K)
    _add_block(p, J, D_1, slope @ F_1, 1, K)
    _add_block(p, J, D_2, slope @ F_2, 2, K)


@kernel
def _add_block(p, J, U, F, columns, out):
    """Add J^T (tau K_e) (U; F) to the columns of d (0), Theta_1 (1) or Theta_2 (2)."""
    K_up, tau = mat(p.K_up), p.damping
    G_u = tau * (mat(p.K_uu) @ U + K_up @ F)
    G_phi = tau * (K_up.T @ U + mat(p.K_pp) @ F)
    d = J.U_d.T @ G_u
    one = J.U_1.T @ G_u + J.F_1.T @ G_phi
    two = J.U_2.T @ G_u + J.F_2.T @ G_phi
    for i in range(2):
        j, s = 3 + 6 * (columns - 1), 1.0
        if columns == 0:
            j, s = 6 * i, 1.0 if i else -1.0
        elif i == 0:
            continue
        add_mat(out, 0, j, -s, d)
        add_mat(out, 3, j, s, one)
        add_mat(out, 6, j, s, d)
        add_mat(out, 9, j, s, two)

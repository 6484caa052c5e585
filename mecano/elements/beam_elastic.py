r"""Elastic and viscous forces of a two-node beam, from the relative motion of its end sections on SE(3).

The section axes at the ends are :math:`A_1 = R_1 S` and :math:`A_2 = R_2` (S constant: everything of the section is
kept in the axes of the second node). The strain measure is the screw motion from one section to the other,

.. math::  \varphi = \log(A_1^T A_2), \qquad u = H y, \quad y = A_2^T (x_2 - x_1), \quad H = T^{-1}(\varphi)

that is :math:`(u, \varphi) = \log_{SE(3)}`; it is constant along a helix, hence along every circular arc (Sonneville,
Cardona & Bruels 2014). With the strains :math:`e = (u - u_0, \varphi - \varphi_0)` and the constant element
stiffness :math:`K_e` of beam_flexibility.py,

.. math::  V = \tfrac12 \bar e \cdot K_e \bar e, \qquad \bar e = (e_u + a\, (e_u \cdot B e_u), e_\varphi), \qquad
    (p_u, p_\varphi) = \bar G^T K_e (\bar e + \tau \dot{\bar e}), \quad \bar G = \partial \bar e/\partial e

.. math::  f_{x2} = A_2 P = -f_{x1}, \quad P = H^T p_u, \qquad
    m_2 = P \times y + H^T Q, \quad m_1 = -S H Q, \quad Q = p_\varphi + (\partial u/\partial\varphi)^T p_u
The second term of :math:`\bar e`, with the unit vector a along the beam, belongs to the flexibility: where the end
sections are tilted by gamma against the chord because the element bends as an S, its line is longer than its part
along the section axes, by :math:`\tfrac35 \gamma^2 L` for a slender element. Without it every tension of more than
12 EI/L^2 would tilt the sections.
"""

from mecano.compiled.kernel import inlined, kernel
from mecano.maths.rotation_vector import (
    first_derivative,
    inverse_coefficients,
    inverse_tangent,
    inverse_tangent_rate,
    second_derivative,
    second_form,
)
from mecano.maths.so3 import log
from mecano.maths.vec import (
    add,
    add_mat,
    add_vec,
    cross,
    cross_columns,
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


@inlined
def strains(p, q, W, R2):
    """phi, y, H, c, c1, c2, and the strains u - u0, phi - phi0; W = R1^T R2."""
    phi = log(matmul(transpose(mat(p.S)), W))
    c, c1, c2 = inverse_coefficients(dot(phi, phi))
    y = tmul(R2, sub(vec(q, 6), vec(q, 0)))
    H = inverse_tangent(phi, c)
    return phi, y, H, c, c1, c2, sub(mul(H, y), vec(p.u0, 0)), sub(phi, vec(p.phi0, 0))


@kernel
def stretched(p, e_u, b):
    """The strain e_u with the elongation a (e_u . b) of the bent line, b = B e_u; a rate is stretched(p, rate, 2 b)."""
    return add(e_u, scale(dot(e_u, b), vec(p.along, 0)))


@kernel
def stresses(p, e_u, e_phi):
    """K_e e: the generalized forces [N], [N m] of the stretched strains."""
    K_up = mat(p.K_up)
    p_u = add(mul(mat(p.K_uu), e_u), mul(K_up, e_phi))
    return p_u, add(tmul(K_up, e_u), mul(mat(p.K_pp), e_phi))


@kernel
def unstretched(p, p_u, b):
    """The force conjugate to u from that conjugate to its stretched strain."""
    return add(p_u, scale(2.0 * dot(vec(p.along, 0), p_u), b))


@kernel
def strain_rates(p, v, y, R2, H, E):
    """Rates of u and phi, and dy/dt."""
    omega_1, omega_2 = tmul(mat(p.S), vec(v, 3)), vec(v, 9)
    y_rate = add(tmul(R2, sub(vec(v, 6), vec(v, 0))), cross(y, omega_2))
    phi_rate = sub(mul(H, omega_2), tmul(H, omega_1))
    return add(mul(H, y_rate), mul(E, phi_rate)), phi_rate, y_rate


@inlined
def end_loads(p, y, H, E, p_u, p_phi):
    """P, Q and the material moments m_1, m_2 on the nodes."""
    P = tmul(H, p_u)
    Q = add(p_phi, tmul(E, p_u))
    m_2 = add(cross(P, y), tmul(H, Q))
    return P, Q, scale(-1.0, mul(mat(p.S), mul(H, Q))), m_2


@kernel
def add_elastic(p, q, v, W, R2, f, K, C):
    """Add residual and tangents of the elastic and viscous forces."""
    phi, y, H, c, c1, c2, e_u, e_phi = strains(p, q, W, R2)
    E = first_derivative(phi, y, -0.5, c, c1)
    b = mul(mat(p.B), e_u)
    e_u = stretched(p, e_u, b)
    if p.damping > 0.0:
        u_rate, phi_rate, y_rate = strain_rates(p, v, y, R2, H, E)
        _add_viscous(p, v, phi, y, H, E, b, c, c1, c2, u_rate, phi_rate, y_rate, R2, K, C)
        rate = stretched(p, u_rate, scale(2.0, b))
        e_u, e_phi = add(e_u, scale(p.damping, rate)), add(e_phi, scale(p.damping, phi_rate))
    p_bar, p_phi = stresses(p, e_u, e_phi)
    p_u = unstretched(p, p_bar, b)
    P, Q, m_1, m_2 = end_loads(p, y, H, E, p_u, p_phi)
    n = mul(R2, P)
    add_vec(f, 0, -1.0, n)
    add_vec(f, 3, 1.0, m_1)
    add_vec(f, 6, 1.0, n)
    add_vec(f, 9, 1.0, m_2)
    K_uu, K_up = _current_stiffness(p, b, dot(vec(p.along, 0), p_bar))
    _add_stiffness(p, phi, y, H, E, c, c1, c2, K_uu, K_up, p_u, P, Q, R2, K)


@inlined
def _current_stiffness(p, b, tension):
    """Derivatives of p_u by u and phi: G^T K_uu G + 2 N B and G^T K_up with G = I + 2 a b^T."""
    K_uu, K_up, along = mat(p.K_uu), mat(p.K_up), vec(p.along, 0)
    b = scale(2.0, b)
    axial = mul(K_uu, along)
    column = add(axial, scale(0.5 * dot(along, axial), b))
    K_uu = madd(madd(K_uu, mscale(2.0 * tension, mat(p.B))), madd(outer(column, b), outer(b, column)))
    return K_uu, madd(K_up, outer(b, tmul(K_up, along)))


@inlined
def _add_stiffness(p, phi, y, H, E, c, c1, c2, K_uu, K_up, p_u, P, Q, R2, K):
    """Material and geometric stiffness; the blocks of different unknowns are symmetric, those of one rotation not."""
    S, HT = mat(p.S), transpose(H)
    SHT = transpose(matmul(S, H))  # H^T S^T
    HK = matmul(HT, K_uu)
    W_yy = matmul(HK, H)
    W_yp = madd(madd(matmul(HK, E), matmul(HT, K_up)), first_derivative(phi, p_u, 0.5, c, c1))
    ET = transpose(E)
    coupled = matmul(ET, K_up)
    W_pp = madd(matmul(matmul(ET, K_uu), E), madd(coupled, transpose(coupled)))
    W_pp = madd(W_pp, madd(mat(p.K_pp), second_form(phi, p_u, y, c, c1, c2)))
    curl = first_derivative(phi, Q, 0.5, c, c1)  # d(H^T Q)/dphi
    Z = madd(madd(cross_columns(W_yy, y), matmul(W_yp, H)), skew(scale(-1.0, P)))
    x_x = matmul(matmul(R2, W_yy), transpose(R2))
    x_1, x_2 = mscale(-1.0, matmul(R2, matmul(W_yp, SHT))), matmul(R2, Z)
    for i in range(2):
        s = 1.0 if i else -1.0
        add_mat(K, 6 * i, 0, -s, x_x)
        add_mat(K, 6 * i, 6, s, x_x)
        add_mat(K, 6 * i, 3, s, x_1)
        add_mat(K, 3, 6 * i, s, transpose(x_1))
        add_mat(K, 6 * i, 9, s, x_2)
        add_mat(K, 9, 6 * i, s, transpose(x_2))
    U = madd(madd(matmul(HT, W_pp), curl), transpose(cross_columns(transpose(W_yp), y)))
    two_one = mscale(-1.0, matmul(U, SHT))
    add_mat(K, 9, 3, 1.0, two_one)
    add_mat(K, 3, 9, 1.0, transpose(two_one))
    add_mat(K, 9, 9, 1.0, madd(cross_columns(transpose(Z), y), matmul(U, H)))
    turned = madd(matmul(H, W_pp), first_derivative(phi, Q, -0.5, c, c1))  # d(H Q)/dphi
    add_mat(K, 3, 3, 1.0, matmul(S, matmul(turned, SHT)))


@kernel
def _add_viscous(p, v, phi, y, H, E, b, c, c1, c2, u_rate, phi_rate, y_rate, R2, K, C):
    """C = J^T (tau K_e) J and the part J^T (tau K_e) d(J v)/dq of K, with J = d(u, phi)/d(d, Theta_1, Theta_2)."""
    S, RT = mat(p.S), transpose(R2)
    omega_1, omega_2 = tmul(S, vec(v, 3)), vec(v, 9)
    F_1, F_2 = mscale(-1.0, transpose(matmul(S, H))), H
    V_d, V_1, V_2 = matmul(H, RT), matmul(E, F_1), madd(cross_columns(H, y), matmul(E, F_2))
    stretch = outer(vec(p.along, 0), scale(2.0, b))
    U_d, U_1, U_2 = madd(V_d, matmul(stretch, V_d)), madd(V_1, matmul(stretch, V_1)), madd(V_2, matmul(stretch, V_2))
    zero = mscale(0.0, H)
    _add_block(p, U_d, U_1, U_2, F_1, F_2, U_d, zero, 0, C)
    _add_block(p, U_d, U_1, U_2, F_1, F_2, U_1, F_1, 1, C)
    _add_block(p, U_d, U_1, U_2, F_1, F_2, U_2, F_2, 2, C)
    slope = madd(
        first_derivative(phi, omega_2, -0.5, c, c1), mscale(-1.0, first_derivative(phi, omega_1, 0.5, c, c1))
    )  # of the rate of phi by phi
    N = madd(first_derivative(phi, y_rate, -0.5, c, c1), matmul(E, slope))
    N = madd(N, second_derivative(phi, phi_rate, y, c, c1, c2))
    by_y = madd(inverse_tangent_rate(phi, phi_rate, c, c1), mscale(-1.0, matmul(H, skew(omega_2))))
    carried = sub(y_rate, cross(y, omega_2))
    D_2 = madd(madd(cross_columns(by_y, y), cross_columns(H, carried)), matmul(N, F_2))
    D_d, D_1, turning = matmul(by_y, RT), matmul(N, F_1), outer(vec(p.along, 0), scale(2.0, mul(mat(p.B), u_rate)))
    D_d = madd(madd(D_d, matmul(stretch, D_d)), matmul(turning, V_d))
    D_1 = madd(madd(D_1, matmul(stretch, D_1)), matmul(turning, V_1))
    D_2 = madd(madd(D_2, matmul(stretch, D_2)), matmul(turning, V_2))
    _add_block(p, U_d, U_1, U_2, F_1, F_2, D_d, zero, 0, K)
    _add_block(p, U_d, U_1, U_2, F_1, F_2, D_1, matmul(slope, F_1), 1, K)
    _add_block(p, U_d, U_1, U_2, F_1, F_2, D_2, matmul(slope, F_2), 2, K)


@kernel
def _add_block(p, U_d, U_1, U_2, F_1, F_2, U, F, columns, out):
    """Add J^T (tau K_e) (U; F) to the columns of d (0), Theta_1 (1) or Theta_2 (2)."""
    K_up, tau = mat(p.K_up), p.damping
    G_u = mscale(tau, madd(matmul(mat(p.K_uu), U), matmul(K_up, F)))
    G_phi = mscale(tau, madd(matmul(transpose(K_up), U), matmul(mat(p.K_pp), F)))
    d = matmul(transpose(U_d), G_u)
    one = madd(matmul(transpose(U_1), G_u), matmul(transpose(F_1), G_phi))
    two = madd(matmul(transpose(U_2), G_u), matmul(transpose(F_2), G_phi))
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

"""Forces of the lateral law of a tyre (lateral_law.py) on (y, psi, bow) of its patch, and their exact derivatives."""

from typing import NamedTuple

from mecano.compiled.kernel import kernel
from mecano.constraints.tire_patch import Y
from mecano.elements.string_law import NO_PACE, OF_STRING, pace
from mecano.laws.table import evaluate_curve
from mecano.maths.vector import EYE, Mat3, Vec3, dot, mat, outer, vec


class Lateral(NamedTuple):
    """(F [N], M [N m], X [N]) and the aligning moment [N m], and their derivatives."""

    f: tuple
    turn: float
    f_q: tuple  # 3x3, by y, psi, bow
    f_v: tuple  # by their rates
    turn_q: tuple
    turn_v: tuple
    f_N: tuple
    turn_N: float
    f_u: tuple
    turn_u: float
    f_n: tuple  # by the turning rate of the wheel about n
    f_rolled: tuple  # by dy/dt of a patch that does not slip sideways


@kernel
def lateral_law(p, laws, q, v, rolled, N, u, turning):
    """The Lateral for (y, psi, bow) = ``q``, their rates ``v``, normal force [N], speed u [m/s], turning rate.

    ``rolled`` [m/s] is dy/dt of a patch that does not slip sideways: it takes the place of dy/dt in the law of a
    string, whose contact line is laid down by rolling.
    """
    kN, kN_1, _ = evaluate_curve(laws, p.stiffness_by_load, N)
    ku, ku_1, _ = evaluate_curve(laws, p.stiffness_by_speed, u)
    dN, dN_1, _ = evaluate_curve(laws, p.damping_by_load, N)
    du, du_1, _ = evaluate_curve(laws, p.damping_by_speed, u)
    k, k_N, k_u, d, d_N, d_u = kN * ku, kN_1 * ku, kN * ku_1, dN * du, dN_1 * du, dN * du_1
    if p.pace != NO_PACE:  # its rates are those of rolling, no damping
        d, d_N, d_u = k, k_N, k_u
    g0, g0_u, g1, g1_u = pace(p, u)
    A0, A1, b, m = mat(p.A0), mat(p.A1), p.aligning, vec(p.moment, 0)
    lays = 1.0 if p.pace == OF_STRING else 0.0
    by_y = Vec3(A1[0][0], A1[1][0], A1[2][0])
    still, moved = A0 @ q, A1 @ v + turning * vec(p.turning, 0)
    moved = moved + lays * (rolled - v[0]) * by_y
    own = b[0] * q[0] + b[1] * q[1] + b[2] * v[0] + b[3] * v[1]
    along = dot(m, q)
    return Lateral(
        _paced(k, g0, still) + _paced(d, g1, moved), own + k * along, _rows(k, g0, A0),
        _rows(d, g1, A1 + outer(-lays * by_y, EYE[0])),
        Vec3(b[0], b[1], 0.0) + k * m, Vec3(b[2], b[3], 0.0),
        _paced(k_N, g0, still) + _paced(d_N, g1, moved), k_N * along,
        _paced(k_u, g0, still) + _paced(d_u, g1, moved) + _of_pace(k * g0_u, still, d * g1_u, moved),
        k_u * along, _paced(d, g1, vec(p.turning, 0)), _paced(d, g1, lays * by_y),
    )  # fmt: skip


@kernel
def _paced(k, g, a):
    """k diag(1, g, g) a"""
    return Vec3(k * a[0], k * g * a[1], k * g * a[2])


@kernel
def _rows(k, g, A):
    """k diag(1, g, g) A"""
    return Mat3(k * A[0], k * g * A[1], k * g * A[2])


@kernel
def _of_pace(g0, a, g1, b):
    """diag(0, g0, g0) a + diag(0, g1, g1) b"""
    return Vec3(0.0, g0 * a[1] + g1 * b[1], g0 * a[2] + g1 * b[2])


@kernel
def law_rows(law, by_law, dN, d_speed, d_turning, d_rolled):
    """Derivatives, three (3,), of (F, M, X) and (3,) of the aligning moment of a Lateral by three variables.

    ``by_law`` are those of both through y, psi and bow or their rates; dN, d_speed, d_turning, d_rolled those of N, u,
    omega_n and ``rolled``.
    """
    f, turn = by_law
    rows = Mat3(
        _row(f[0], law.f_N[0], dN, law.f_u[0], d_speed, law.f_n[0], d_turning) + law.f_rolled[0] * d_rolled,
        _row(f[1], law.f_N[1], dN, law.f_u[1], d_speed, law.f_n[1], d_turning) + law.f_rolled[1] * d_rolled,
        _row(f[2], law.f_N[2], dN, law.f_u[2], d_speed, law.f_n[2], d_turning) + law.f_rolled[2] * d_rolled,
    )
    return rows, _row(turn, law.turn_N, dN, law.turn_u, d_speed, 0.0, d_turning)


@kernel
def _row(a, N, dN, u, d_speed, n, d_turning):
    return a + (N * dN + (u * d_speed + n * d_turning))


@kernel
def relax(p, q, v, f, K, C):
    """Add F = M = X = 0 of the air to the rows and columns of y, psi and bow."""
    A0, A1 = mat(p.A0), mat(p.A1_air)
    loose = A0 @ vec(q, Y) + A1 @ vec(v, Y)
    for r in range(3):
        f[Y + r] += loose[r]
        for c in range(3):
            K[Y + r, Y + c] += A0[r][c]
            C[Y + r, Y + c] += A1[r][c]


@kernel
def lateral_energy(p, y, psi):
    """Energy of the symmetric part of A0 for y and psi [J]: what the law may be said to store."""
    A = p.A0
    return 0.5 * (A[0, 0] * y * y + (A[0, 1] + A[1, 0]) * y * psi + A[1, 1] * psi * psi)


@kernel
def lateral_energy_rate(p, y, psi, y1, psi1):
    """Rate of ``lateral_energy`` [W]."""
    mixed = 0.5 * (p.A0[0, 1] + p.A0[1, 0])
    return (p.A0[0, 0] * y + mixed * psi) * y1 + (mixed * y + p.A0[1, 1] * psi) * psi1

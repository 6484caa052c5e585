r"""Lateral law of a tyre: force F along y and moment M along psi of its patch, linear in both and their rates.

(47) of Cardona, Geradin and Doan 1991, after Moreland 1954 and Collins and Black 1968:

    {F; M} = A0 {y; psi} + A1 {dy/dt; dpsi/dt},      A0, A1 in general not symmetric

each multiplied, where the deck says so, by curves of the normal force N and of the speed u of the axle over the ground.
Rolling freely a patch bears no moment, M = 0, which is Moreland's yaw equation psi + C1 dpsi/dt = C F, F = K y + D
dy/dt, with

    A0 = [[K, 0], [-kap C K, kap]],   A1 = [[D, 0], [-kap C D, kap C1]]

for any kap: 1/C is the cornering stiffness, 1/(C K) the relaxation length. Under braking kap matters. The law with a
relaxation length is Moreland's without D and C1.

In the air F = M = 0, so y and psi decay; where A1 is singular they do so in the time ``relaxation_in_air``, with A1 +
T A0 in place of A1.

An aligning moment on the wheel about n, linear in (y, psi, dy/dt, dpsi/dt), may be added; the equations (51) have none.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from mecano.laws.table import evaluate_curve
from mecano.schema import CURVE, NUMBER, NUMBERS, Field, mapping, not_negative, positive

SINGULAR = 1e-12  # of the sizes of its rows, below which a determinant counts as zero


def four(numbers):
    """Check: a matrix of two rows and two columns, or four coefficients."""
    return None if len(numbers) == 4 else "must hold 4 numbers"


MATRICES = mapping(
    Field("stiffness", NUMBERS, "N/m, N, N, N m", "A0 by rows: [F/y, F/psi, M/y, M/psi]", check=four),
    Field("damping", NUMBERS, "N s/m, N s, N s, N m s", "A1 by rows, by the rates of y and psi", check=four),
)
MORELAND = mapping(
    Field("lateral_stiffness", NUMBER, "N/m", "K in F = K y + D dy/dt", check=positive),
    Field("lateral_damping", NUMBER, "N s/m", "D", 0.0, not_negative),
    Field(
        "yaw_coefficient",
        NUMBER,
        "rad/N",
        "C in psi + C1 dpsi/dt = C F; 1/C is the cornering stiffness",
        check=positive,
    ),
    Field("yaw_time", NUMBER, "s", "C1", 0.0, not_negative),
    Field("torsional_stiffness", NUMBER, "N m/rad", "kap of the patch; matters under braking", 1.0e4, positive),
)
RELAXATION = mapping(
    Field("cornering_stiffness", NUMBER, "N/rad", "lateral force per slip angle in steady rolling", check=positive),
    Field("relaxation_length", NUMBER, "m", "way in which the force builds up", check=positive),
    Field("torsional_stiffness", NUMBER, "N m/rad", "kap of the patch; matters under braking", 1.0e4, positive),
)
FACTOR = "factor on {}, a curve of {}"
LATERAL_FIELDS = (
    Field("matrices", MATRICES, "-", "A0 and A1 in full", None),
    Field("moreland", MORELAND, "-", "Moreland's constants", None),
    Field("relaxation", RELAXATION, "-", "cornering stiffness and relaxation length", None),
    Field("stiffness_by_load", CURVE, "-", FACTOR.format("A0", "the normal force [N]"), 1.0),
    Field("stiffness_by_speed", CURVE, "-", FACTOR.format("A0", "the speed of the axle [m/s]"), 1.0),
    Field("damping_by_load", CURVE, "-", FACTOR.format("A1", "the normal force [N]"), 1.0),
    Field("damping_by_speed", CURVE, "-", FACTOR.format("A1", "the speed of the axle [m/s]"), 1.0),
    Field(
        "aligning_moment", NUMBERS, "N, N m/rad, N s, N m s/rad", "moment on the wheel about n by y, psi, their rates",
        [0.0, 0.0, 0.0, 0.0], four,
    ),
    Field("relaxation_in_air", NUMBER, "s", "time in which y and psi decay where A1 is singular", 1.0e-3, positive),
)  # fmt: skip
LATERAL_TYPE = mapping(*LATERAL_FIELDS)
CURVES = "stiffness_by_load", "stiffness_by_speed", "damping_by_load", "damping_by_speed"
LATERAL_RECORD = {"A0": 4, "A1": 4, "A1_air": 4, "aligning": 4, **dict.fromkeys(CURVES, "i")}


class Lateral(NamedTuple):
    """F [N], M [N m] and the aligning moment, and their derivatives by y, psi, their rates, N and u."""

    F: float
    M: float
    turn: float
    F_q: tuple  # by y, psi
    M_q: tuple
    F_v: tuple  # by their rates
    M_v: tuple
    F_N: float
    M_N: float
    F_u: float
    M_u: float


def matrices(law):
    """A0, A1, (2, 2)."""
    if law["matrices"]:
        return (np.array(law["matrices"][name], float).reshape(2, 2) for name in ("stiffness", "damping"))
    if law["relaxation"]:
        d = law["relaxation"]
        C, kap = 1.0 / d["cornering_stiffness"], d["torsional_stiffness"]
        K, D, C1 = d["cornering_stiffness"] / d["relaxation_length"], 0.0, 0.0
    else:
        d = law["moreland"]
        C, kap = d["yaw_coefficient"], d["torsional_stiffness"]
        K, D, C1 = d["lateral_stiffness"], d["lateral_damping"], d["yaw_time"]
    return np.array([[K, 0.0], [-kap * C * K, kap]]), np.array([[D, 0.0], [-kap * C * D, kap * C1]])


def prepare_lateral(law, context):
    """Values of LATERAL_RECORD."""
    A0, A1 = matrices(law)
    rows = np.abs(A1).sum(axis=1)
    singular = abs(np.linalg.det(A1)) <= SINGULAR * rows.prod()
    A1_air = A1 + law["relaxation_in_air"] * A0 if singular else A1
    values = {"A0": A0.ravel(), "A1": A1.ravel(), "A1_air": A1_air.ravel(), "aligning": law["aligning_moment"]}
    return values | {name: int(context.laws.add(law[name])) for name in CURVES}


def check_lateral(law):
    """Texts on what is wrong with a lateral law, None where the tyre law has none."""
    if law is None:
        return ["the tire law has no 'lateral' law: how the patch gives way sideways"]
    given = [name for name in ("matrices", "moreland", "relaxation") if law[name]]
    if len(given) != 1:
        return ["the lateral law must be one of 'matrices', 'moreland' and 'relaxation'"]
    A0, A1 = matrices(law)
    texts = []
    if abs(np.linalg.det(A0)) <= SINGULAR * np.abs(A0).sum(axis=1).prod():
        texts.append("the stiffness A0 of the lateral law is singular")
    elif np.linalg.eigvals(np.linalg.solve(A0, A1)).real.min() < -1e-12 * np.abs(np.linalg.solve(A0, A1)).max():
        texts.append("y and psi of the lateral law grow in the air: A0 and A1 do not fit together")
    return texts


@njit
def lateral_law(p, laws, q, v, N, u):
    """The Lateral for (y, psi) = ``q``, their rates ``v``, normal force [N] and speed of the axle [m/s]."""
    kN, kN_1, _ = evaluate_curve(laws, p.stiffness_by_load, N)
    ku, ku_1, _ = evaluate_curve(laws, p.stiffness_by_speed, u)
    dN, dN_1, _ = evaluate_curve(laws, p.damping_by_load, N)
    du, du_1, _ = evaluate_curve(laws, p.damping_by_speed, u)
    A0, A1, b = p.A0, p.A1, p.aligning
    k, d = kN * ku, dN * du
    F0, M0 = A0[0] * q[0] + A0[1] * q[1], A0[2] * q[0] + A0[3] * q[1]
    F1, M1 = A1[0] * v[0] + A1[1] * v[1], A1[2] * v[0] + A1[3] * v[1]
    turn = b[0] * q[0] + b[1] * q[1] + b[2] * v[0] + b[3] * v[1]
    return Lateral(
        k * F0 + d * F1, k * M0 + d * M1, turn, (k * A0[0], k * A0[1]), (k * A0[2], k * A0[3]),
        (d * A1[0], d * A1[1]), (d * A1[2], d * A1[3]),
        kN_1 * ku * F0 + dN_1 * du * F1, kN_1 * ku * M0 + dN_1 * du * M1,
        kN * ku_1 * F0 + dN * du_1 * F1, kN * ku_1 * M0 + dN * du_1 * M1,
    )  # fmt: skip


@njit
def relax(p, q, v, f, K, C, i):
    """Add F = M = 0 of the air to the rows and columns i, i + 1 of y and psi."""
    for r in range(2):
        f[i + r] += (
            p.A0[2 * r] * q[i] + p.A0[2 * r + 1] * q[i + 1] + p.A1_air[2 * r] * v[i] + p.A1_air[2 * r + 1] * v[i + 1]
        )
        for c in range(2):
            K[i + r, i + c] += p.A0[2 * r + c]
            C[i + r, i + c] += p.A1_air[2 * r + c]


@njit
def lateral_energy(p, q):
    """Energy of the symmetric part of A0 [J]: what the law may be said to store."""
    return 0.5 * (p.A0[0] * q[0] * q[0] + (p.A0[1] + p.A0[2]) * q[0] * q[1] + p.A0[3] * q[1] * q[1])


@njit
def lateral_energy_rate(p, q, v):
    """Rate of ``lateral_energy`` [W]."""
    mixed = 0.5 * (p.A0[1] + p.A0[2])
    return (p.A0[0] * q[0] + mixed * q[1]) * v[0] + (mixed * q[0] + p.A0[3] * q[1]) * v[1]

r"""Lateral law of a tyre: force F along y and moment M along psi of its patch, linear in both and their rates.

(47) of Cardona, Geradin and Doan 1991, after Moreland 1954 and Collins and Black 1968:

    {F; M} = A0 {y; psi} + A1 {dy/dt; dpsi/dt},      A0, A1 in general not symmetric

each multiplied, if the deck gives them, by curves of the normal force N and of the speed u of the axle over the ground.
In free rolling a patch carries no moment, M = 0, which is Moreland's yaw equation psi + C1 dpsi/dt = C F, F = K y + D
dy/dt, with

    A0 = [[K, 0], [-kap C K, kap]],   A1 = [[D, 0], [-kap C D, kap C1]]

for any kap: 1/C is the cornering stiffness, 1/(C K) the relaxation length. kap matters only under braking.

The law with a relaxation length sigma, F = K y and psi = y/sigma, has A0 of this form without D and C1. Its psi is the
slip angle of a point-like patch, not a twist against a stiffness: a change of psi does not carry a displaced patch
along, and the longitudinal force does not turn it (``twist`` = 0, docs/tyre-equations.md). Its kap, K sigma^2, only
scales the equation. The same holds for Moreland's law without C1.

Where the wheel rolls backward, psi = -C F, and the moment of a trail changes its sign: the terms of y in M and in the
aligning moment are multiplied by the direction of rolling, in all laws but ``matrices`` and ``string``.

Laws with a contact length, ``string`` and ``straight_tangent``, have a moment M that also depends on the speed u and on
the turning rate omega_n of the wheel about n, and an aligning moment of their own. The string has a third unknown, the
bow b of its contact line, with an equation X = 0 (string_law.py). In general, with q = (y, psi, b),

    (F, M, X) = diag(1, g_0, g_0) A0 q + diag(1, g_1, g_1) (A1 dq/dt + A_n omega_n)

where g_0 and g_1 depend on u and are 1 in laws without a contact length; their bow is zero.

In the air F = M = 0, so y and psi decay; where A1 is singular, with A1 + T A0 in place of A1, T = ``relaxation_in_air``
(in laws with a contact length T A0). The energies of the law are in docs/tyre-equations.md. An aligning moment on the
wheel about n, linear in (y, psi, dy/dt, dpsi/dt), may be added; the equations (51) have none.
"""

from typing import NamedTuple

import numpy as np

from mecano.constraints.tire_patch import Y
from mecano.constraints.wheels import slow
from mecano.elements.wheels.string_law import (
    CORNERING_STIFFNESS,
    NO_PACE,
    OF_STRING,
    STRING_TYPE,
    TANGENT_TYPE,
    TORSIONAL_STIFFNESS,
    pace,
    prepare_string,
)
from mecano.jit.kernel import kernel
from mecano.laws.friction import sticking
from mecano.laws.law_table import curve
from mecano.maths.vector import Vec3, add_vec, dot, mat, vec
from mecano.schema import CURVE, NUMBER, NUMBERS, Field, mapping, not_negative, positive, requirement

ABOUT_N = Vec3(0.0, 1.0, 0.0)
LEAST_FORWARD = 0.1  # [m/s] speed of the axle from which on psi has turned over; of small wheels less
SINGULAR = 1e-12  # relative to the magnitudes of its rows, a determinant below this counts as zero
FOUR = requirement(lambda numbers: len(numbers) == 4, "must hold 4 numbers")  # a 2 x 2 matrix, or coefficients
MATRICES = mapping(
    Field("stiffness", NUMBERS, "N/m, N, N, N m", "A0 by rows: [F/y, F/psi, M/y, M/psi]", check=FOUR),
    Field("damping", NUMBERS, "N s/m, N s, N s, N m s", "A1 by rows, by the rates of y and psi", check=FOUR),
)
MORELAND = mapping(
    Field("lateral_stiffness", NUMBER, "N/m", "K in F = K y + D dy/dt", check=positive),
    Field("lateral_damping", NUMBER, "N s/m", "D", 0.0, not_negative),
    Field(
        "yaw_coefficient", NUMBER, "rad/N", "C in psi + C1 dpsi/dt = C F; 1/C is the cornering stiffness",
        check=positive,
    ),
    Field("yaw_time", NUMBER, "s", "C1", 0.0, not_negative),
    TORSIONAL_STIFFNESS,
)  # fmt: skip
RELAXATION = mapping(
    CORNERING_STIFFNESS,
    Field("relaxation_length", NUMBER, "m", "rolling distance over which the force builds up", check=positive),
)
FACTOR = "factor on {}, a curve of {}"
LATERAL_FIELDS = (
    Field("matrices", MATRICES, "-", "A0 and A1 in full", None),
    Field("moreland", MORELAND, "-", "Moreland's constants", None),
    Field("relaxation", RELAXATION, "-", "cornering stiffness and relaxation length", None),
    Field("string", STRING_TYPE, "-", "stretched string (von Schlippe, Dietrich), its contact line a cubic", None),
    Field("straight_tangent", TANGENT_TYPE, "-", "stretched string, its contact line the tangent at the front", None),
    Field("stiffness_by_load", CURVE, "-", FACTOR.format("A0", "the normal force [N]"), 1.0, argument="N"),
    Field("stiffness_by_speed", CURVE, "-", FACTOR.format("A0", "the speed of the axle [m/s]"), 1.0, argument="m/s"),
    Field("damping_by_load", CURVE, "-", FACTOR.format("A1", "the normal force [N]"), 1.0, argument="N"),
    Field("damping_by_speed", CURVE, "-", FACTOR.format("A1", "the speed of the axle [m/s]"), 1.0, argument="m/s"),
    Field(
        "aligning_moment", NUMBERS, "N, N m/rad, N s, N m s/rad", "moment on the wheel about n by y, psi, their rates",
        [0.0, 0.0, 0.0, 0.0], FOUR,
    ),
    Field("relaxation_in_air", NUMBER, "s", "time in which y and psi decay where A1 is singular", 1.0e-3, positive),
)  # fmt: skip
LATERAL_TYPE = mapping(*LATERAL_FIELDS)
CURVES = "stiffness_by_load", "stiffness_by_speed", "damping_by_load", "damping_by_speed"
LATERAL_RECORD = {
    "A0": (3, 3), "A1": (3, 3), "A1_air": (3, 3), "aligning": 4, "turning": 3, "moment": 3, "pace": (),
    "least_speed": (), "reverses": (), "twist": (), "stored": (3, 3), "damped": (3, 3), "damped_air": (3, 3),
    **dict.fromkeys(CURVES, "i"),
}  # fmt: skip
FORMS = "matrices", "moreland", "relaxation", "string", "straight_tangent"


class Course(NamedTuple):
    """Motion of a wheel over the ground, as a lateral law reads it."""

    speed: float  # u of the axle [m/s]
    forward: float  # its component along t, negative in reverse [m/s]
    turning: float  # rate omega_n about n [rad/s]
    rolled: float  # dy/dt of a patch without lateral slip [m/s]


class Lateral(NamedTuple):
    """Forces of a lateral law."""

    f: tuple  # F [N], M [N m], X [N]
    turn: float  # aligning moment [N m]
    damped: float  # power that its damping dissipates [W]
    way: float  # 1 forward, -1 in reverse


@kernel
def lateral_law(p, at, N, course):
    """Return the Lateral of a wheel with the local unknowns y, psi, bow for the normal force N [N] and the Course.

    ``rolled`` replaces dy/dt in the law of a string, whose contact line is laid down by rolling. In reverse other laws
    turn psi over.
    """
    q, v, laws, u, forward = vec(at.q, Y), vec(at.v, Y), at.laws, course.speed, course.forward
    k = curve(laws, p.stiffness_by_load, N) * curve(laws, p.stiffness_by_speed, u)
    d = curve(laws, p.damping_by_load, N) * curve(laws, p.damping_by_speed, u)
    if p.pace != NO_PACE:  # its rates are those of rolling, no damping
        d = k
    g0, g1 = pace(p, u)
    b, lays = p.aligning, 1.0 if p.pace == OF_STRING else 0.0
    rates = Vec3(v[0] + lays * (course.rolled - v[0]), v[1], v[2])
    still, moved = mat(p.A0) @ q, mat(p.A1) @ rates + course.turning * vec(p.turning, 0)
    ahead = forward * sticking(slow(p.radius, LEAST_FORWARD), abs(forward))
    change = p.reverses * (ahead - 1.0)  # 0 forward, -2 in reverse
    still = still + change * p.A0[1, 0] * q[0] * ABOUT_N
    moved = moved + change * p.A1[1, 0] * rates[0] * ABOUT_N
    damped = d * dot(v, mat(p.damped) @ v)
    way = 1.0 + change
    own = way * (b[0] * q[0] + b[2] * v[0]) + b[1] * q[1] + b[3] * v[1]
    f, trailing = _paced(k, g0, still) + _paced(d, g1, moved), way * k * dot(vec(p.moment, 0), q)
    return Lateral(f, own + trailing, damped, way)


@kernel
def _paced(k, g, a):
    """Return k diag(1, g, g) a."""
    return Vec3(k * a[0], k * g * a[1], k * g * a[2])


@kernel
def relax(p, at, f):
    """Add F = M = X = 0, which hold in the air, to the equations of y, psi and bow."""
    add_vec(f, Y, 1.0, mat(p.A0) @ vec(at.q, Y) + mat(p.A1_air) @ vec(at.v, Y))


def matrices(law):
    """Return A0, A1 (2, 2) of a law without a contact length."""
    if law["matrices"]:
        return tuple(np.array(law["matrices"][name], float).reshape(2, 2) for name in ("stiffness", "damping"))
    if law["relaxation"]:
        d = law["relaxation"]
        C, kap = 1.0 / d["cornering_stiffness"], d["cornering_stiffness"] * d["relaxation_length"]
        K, D, C1 = d["cornering_stiffness"] / d["relaxation_length"], 0.0, 0.0
    else:
        d = law["moreland"]
        C, kap = d["yaw_coefficient"], d["torsional_stiffness"]
        K, D, C1 = d["lateral_stiffness"], d["lateral_damping"], d["yaw_time"]
    return np.array([[K, 0.0], [-kap * C * K, kap]]), np.array([[D, 0.0], [-kap * C * D, kap * C1]])


def prepare_lateral(law, context):
    """Return the values of LATERAL_RECORD."""
    values = prepare_string(law) or _prepare_matrices(law)
    values |= {**_energies(values), "reverses": 0.0 if law["matrices"] or law["string"] else 1.0}
    curves = {name: context.laws.add(law[name]) for name in CURVES}
    return {"aligning": law["aligning_moment"], **values, **curves}


def _energies(values):
    """Return matrices (3, 3) of the stored energy and of the power dissipated by damping on the ground and in the air.

    If psi is not a twist, its equation M = 0 does no work. A law with a contact length rolls and has no damping.
    """
    n = 2 if values["twist"] else 1
    A0, A1, air = (values[name][:n, :n] for name in ("A0", "A1", "A1_air"))
    damped = np.zeros((n, n)) if "pace" in values else _not_negative(A1)
    found = {"stored": 0.5 * (A0 + A0.T), "damped": damped, "damped_air": _not_negative(air)}
    return {name: np.pad(A, (0, 3 - n)) for name, A in found.items()}


def _not_negative(A):
    """Return the symmetric part of a matrix without its negative eigenvalues."""
    values, vectors = np.linalg.eigh(0.5 * (A + A.T))
    return vectors * np.maximum(values, 0.0) @ vectors.T


def _prepare_matrices(law):
    """Return A0, A1 and A1 of the air of a law without a contact length, whose bow is zero."""
    A0, A1 = matrices(law)
    singular = abs(np.linalg.det(A1)) <= SINGULAR * np.abs(A1).sum(axis=1).prod()
    wait = law["relaxation_in_air"]
    air, stiff = A1 + wait * A0 if singular else A1, abs(A0[0, 0])
    twist = 1.0 if twists(law) else 0.0
    return {"A0": _with(A0, stiff), "A1": _with(A1, 0.0), "A1_air": _with(air, wait * stiff), "twist": twist}


def twists(law):
    """Return True if psi is a twist of the patch against a stiffness, False if it is the slip angle y/sigma, C F."""
    return not (law["relaxation"] or law["straight_tangent"] or (law["moreland"] and not law["moreland"]["yaw_time"]))


def _with(A, own):
    """Return the matrix (3, 3) made of A (2, 2) and the diagonal entry ``own``."""
    out = np.zeros((3, 3))
    out[:2, :2], out[2, 2] = A, own
    return out


def runaway(law):
    """Return (field, text) if the rates of a sliding patch may grow without bound, or None.

    They are bounded if the symmetric part of A1 is not negative: for Moreland's law if C1 >= kap C^2 D/4.
    """
    if law["string"] or law["straight_tangent"] or not twists(law):
        return None
    _, A1 = matrices(law)
    if np.linalg.eigvalsh(A1 + A1.T)[0] >= -SINGULAR * np.abs(A1).max():
        return None
    what = "the rates of a sliding patch may grow without bound (docs/tyre-equations.md)"
    if law["matrices"]:
        return "matrices.damping", f"'lateral.matrices.damping' has a negative symmetric part: {what}"
    d = law["moreland"]
    least = 0.25 * d["torsional_stiffness"] * d["yaw_coefficient"] ** 2 * d["lateral_damping"]
    text = f"'lateral.moreland.yaw_time' is {d['yaw_time']:g} s, less than torsional_stiffness yaw_coefficient^2 "
    return "moreland.yaw_time", f"{text}lateral_damping/4 = {least:.3g} s: {what}"


def check_forms(law):
    """Return an error for a lateral law of no form, or of several; or None."""
    given = [name for name in FORMS if law[name]]
    forms, both = (", ".join(f"'{name}'" for name in names) for names in (FORMS, given))
    text = f"give exactly one of {forms}" + (f"; it has {both}" if given else "")
    return None if len(given) == 1 else text


def check_lateral(law):
    """Return errors in a lateral law; None if the tyre law has none."""
    if law is None:
        return ["'tire_law.lateral' is missing: the lateral law of the patch"]
    if law["string"] or law["straight_tangent"]:
        return []
    A0, A1 = matrices(law)
    texts = []
    if abs(np.linalg.det(A0)) <= SINGULAR * np.abs(A0).sum(axis=1).prod():
        texts.append("'tire_law.lateral' has a singular stiffness A0")
    elif np.linalg.eigvals(np.linalg.solve(A0, A1)).real.min() < -1e-12 * np.abs(np.linalg.solve(A0, A1)).max():
        texts.append("'tire_law.lateral' lets y and psi grow in the air: A0 and A1 are inconsistent")
    return texts

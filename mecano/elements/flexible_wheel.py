r"""Wheel that deforms radially, sideways and in torsion, and slips on the ground, at any lean and heading.

Section 3.4 of Cardona, Geradin and Doan, CMAME 89 (1991), equations (47)-(51). Unknowns of its own: the patch is
displaced by y against the wheel plane (contact at x + r c - y a, on the ground) and turned by psi; with Q = 1 + psi
hat(n), rho = r c - y a, and n, q, r taken at the contact of the disc displaced by y:

    radial deformation   w = radius - r                  dw/dt = -n.(v + omega x rho - a dy/dt)/q
    normal force         N = F_r(w, dw/dt)/q
    patch velocity       v_C = (I - n n^T)[v + Q (omega x rho) - Q a dy/dt] - dpsi/dt y (n x a)
    friction             F_fr = mu(|v_C|) sigma(u) phi(|v_C|) N v_C/|v_C|
    tyre law             {F; M} = A0 {y; psi} + A1 {dy/dt; dpsi/dt}

A third one, the bow of the contact line, has an equation X = 0 of its own, trivial but for the tyre law of a string.
v_C is defined so; it is not the rate of the place of the patch, for psi turns the rolling velocity too: rolling
straight without slip, dy/dt = v_lat - V psi. Internal forces (51), with G = Q^T F_fr - N n:

    x: F_fr - N n      Theta: R^T (rho x G)      y: F - a.G      psi: M - y (n x a).F_fr

Upright this is the paper's (51) and the overturning moment y N about t, which it leaves out. Their power is F_fr.v_C +
F_r dw/dt + F dy/dt + M dpsi/dt. The law stores the energy of the symmetric part of A0; the rest of its power counts as
dissipated or, where negative (its unsymmetric part draws on the rolling), as given.

In mode "air" F = M = 0 and y, psi decay. For a patch that never slips see ``adhesive_wheel``. Validity as ``wheel``.
"""

from typing import NamedTuple

from numba import njit

from mecano.constraints.ground import GROUND_RECORD, ends
from mecano.constraints.tire_patch import (
    Y,
    add_patch_force,
    add_patch_tangent,
    by_positions,
    by_velocities,
    patch,
)
from mecano.contract import Event, Kind, record
from mecano.elements.lateral_force import Lateral, lateral_law, law_rows, relax
from mecano.elements.lateral_law import LATERAL_RECORD
from mecano.elements.patch_wheel import (
    FIELDS,
    OUTPUTS,
    SCALARS,
    check,
    event_values,
    limits,
    prepare,
    put_patch,
    sample,
    start,
)
from mecano.elements.tire_law import (
    TIRE_RECORD,
    gripping,
    radial_force,
    speed_over_ground,
)
from mecano.maths.vec import (
    EYE,
    ZERO,
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
    norm,
    outer,
    scale,
    skew,
    sub,
    tmul,
    vec,
)  # fmt: skip

AIR, CONTACT = 0, 1


class Load(NamedTuple):
    """Forces in the patch and their derivatives."""

    radial: float  # F_r [N]
    F_w: float
    F_w1: float
    N: float
    F: tuple  # F_fr [N]
    e: tuple  # direction of the slip, zero at rest
    grip: float
    b: float  # F_fr = N b v_C [s/m]
    b1: float
    b_u: float
    v: tuple  # of the axle [m/s]
    ahead: tuple  # its direction over the ground
    law: Lateral


@njit
def load_of(p, laws, k, q, v):
    """The Load of the Patch ``k``."""
    radial, F_w, F_w1 = radial_force(p, laws, p.radius - k.g.r, k.w1)
    slip, N = norm(k.v_C), radial / k.g.q
    axle, ahead = speed_over_ground(k.g.n, vec(v, 0))
    grip, b, b1, b_u = gripping(p, laws, slip, axle)
    e = scale(1.0 / slip, k.v_C) if slip > 0.0 else ZERO
    law = lateral_law(p, laws, vec(q, Y), vec(v, Y), N, axle, dot(k.g.n, k.omega))
    return Load(radial, F_w, F_w1, N, scale(N * b, k.v_C), e, grip, b, b1, b_u, vec(v, 0), ahead, law)


@njit
def _add_block(A, j, Rn, frame, k, load, G, d, paces, by_law, moment):
    """Add the derivatives by one block of variables.

    ``paces`` are those of speed and turning rate, ``by_law`` those of the lateral law through its own unknowns.
    """
    d_speed, d_turning = paces
    n, law = k.g.n, load.law
    d_radial = add(scale(load.F_w, d.w), scale(load.F_w1, d.w1))
    dN = add(scale(1.0 / k.g.q, d_radial), scale(load.N * k.g.s / k.g.q**2, d.s))
    grown = add(scale(load.b, dN), scale(load.N * load.b_u, d_speed))
    slid = madd(mscale(load.b, d.v_C), outer(scale(load.b1, load.e), tmul(d.v_C, load.e)))
    dF = madd(outer(k.v_C, grown), mscale(load.N, slid))
    rows, turn = law_rows(law, by_law, dN, d_speed, d_turning)
    aligned = madd(outer(scale(-1.0, n), turn), mscale(-law.turn, d.n))
    add_patch_tangent(A, j, Rn, frame, k, load.F, load.N, G, dF, dN, d, madd(moment, aligned))
    add_mat(A, Y, j, 1.0, matmul(rows, frame))


@njit
def force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """Forces of ground and tyre law, and their derivatives; see the contract."""
    if mode == AIR:
        relax(p, q, v, f, K, C)
        return
    Rn = mat(R[0])
    place = patch(p, laws, q, v, R)
    load = load_of(p, laws, place, q, v)
    law = load.law
    G = add_patch_force(f, Rn, place, load.F, load.N)
    add_vec(f, 3, -law.turn, tmul(Rn, place.g.n))
    add_vec(f, Y, 1.0, law.f)

    none, nothing = (ZERO, ZERO, ZERO), ((ZERO, ZERO, ZERO), ZERO)
    by_q, by_v = (law.f_q, law.turn_q), (law.f_v, law.turn_v)
    turning = _turned(place, G, law.turn)
    rise, frames = -dot(place.g.n, load.v), (EYE, Rn, EYE)
    by_place, by_motion = by_positions(p, place, v[Y]), by_velocities(place)
    laws_of_place, laws_of_motion = (nothing, nothing, by_q), (nothing, nothing, by_v)
    moments, ahead = (none, turning, none), ((load.ahead, ZERO), (ZERO, place.g.n), (ZERO, ZERO))
    swings = (ZERO, cross(place.omega, place.g.n), ZERO)
    for i in range(3):
        d = by_place[i]
        paces = (scale(rise, tmul(d.n, load.ahead)), add(tmul(d.n, place.omega), swings[i]))
        _add_block(K, 3 * i, Rn, frames[i], place, load, G, d, paces, laws_of_place[i], moments[i])
        d = by_motion[i]
        _add_block(C, 3 * i, Rn, frames[i], place, load, G, d, ahead[i], laws_of_motion[i], none)


@njit
def _turned(k, G, turn):
    """hat of the inertial moment on the node: what its material components change by when the node turns."""
    return skew(sub(mul(skew(k.rho), G), scale(turn, k.g.n)))


@njit
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Outputs and energies; see OUTPUTS and the contract."""
    k = patch(p, laws, q, v, R)
    load = load_of(p, laws, k, q, v)
    put_patch(
        p,
        laws,
        mode == CONTACT,
        k,
        q,
        v,
        load.radial,
        scale(-1.0, load.F),
        load.grip,
        dot(load.F, k.v_C),
        load.law,
        y,
        e,
    )


FLEXIBLE_WHEEL = Kind(
    name="flexible_wheel",
    section="elements",
    doc=__doc__,
    dtype=record(start=3, **LATERAL_RECORD, axis=3, **GROUND_RECORD, **TIRE_RECORD),
    layout=("x0", "R0"),
    scalars=SCALARS,
    relaxing=SCALARS,
    fields=FIELDS,
    outputs=OUTPUTS,
    modes=("air", "contact"),
    events=(
        Event("touch_down", "air", "contact", "the undeformed rim reaches the ground"),
        Event("lift_off", "contact", "air", "the deformation returns to zero"),
    ),
    prepare=prepare,
    start=start,
    check=check,
    limits=limits,
    ends=ends,
    force=force,
    observe=observe,
    event_values=event_values,
    sample=sample,
)

r"""Wheel that deforms radially, sideways and in torsion, and slips on the ground, at any lean and heading.

Section 3.4 of Cardona, Geradin and Doan, CMAME 89 (1991), equations (47)-(51). Unknowns of its own: the patch is
displaced by y against the wheel plane (contact at x + r c - y a, on the ground) and turned by psi; with Q = 1 + psi
hat(n), rho = r c - y a, and n, q, r taken at the contact of the disc displaced by y:

    radial deformation   w = radius - r                  dw_0/dt = -n.(v + omega x rho)/q
    normal force         N = F_r(w, dw_0/dt)/q
    patch velocity       v_C = (I - n n^T)[v + Q (omega x rho) - Q a dy/dt] - dpsi/dt y (n x a)
    friction             F_fr = mu(|v_0|) sigma(u) phi(|v_C|) N v_C/|v_C|
    tyre law             {F; M} = A0 {y; psi} + A1 {dy/dt; dpsi/dt}

y and psi have no inertia. So that their rates are unique, radial damping and the coefficient of friction are those of
the wheel with its patch held: dw_0/dt and v_0 are dw/dt and v_C without dy/dt and dpsi/dt (docs/tyres.md).

A third one, the bow of the contact line, has an equation X = 0 of its own, trivial but for the tyre law of a string.
v_C is defined so; it is not the rate of the place of the patch, for psi turns the rolling velocity too: rolling
straight without slip, dy/dt = v_lat - V psi. Internal forces (51), with G = Q^T F_fr - N n:

    x: F_fr - N n      Theta: R^T (rho x G)      y: F - a.G - s N_d      psi: M - y (n x a).F_fr

with N_d the part of N by damping. Upright this is the paper's (51) and the overturning moment y N about t, which it
leaves out. Laws without a rate of psi have psi: M, and no dpsi/dt in v_C. The law stores the energy of
the symmetric part of A0; the rest of its power counts as dissipated or, where negative (its unsymmetric part draws on
the rolling), as given.

In mode "air" F = M = 0 and y, psi decay. For a patch that never slips see ``adhesive_wheel``. Validity as ``wheel``.
"""

from typing import NamedTuple

from mecano.compiled.kernel import kernel
from mecano.constraints.tire_patch import Y, patch
from mecano.elements.lateral_force import relax
from mecano.elements.patch_load import add_load, add_load_tangent, changes, load_of, normal_change
from mecano.elements.patch_wheel import SCALARS, patch_wheel, put_patch
from mecano.elements.tire_law import patch_gripping
from mecano.elements.tire_wheel import AIR, CONTACT
from mecano.maths.vector import ZERO, dot, mat, norm, outer


class Slip(NamedTuple):
    """Friction of the patch and its derivatives."""

    F: tuple  # [N]
    e: tuple  # its direction, zero at rest
    grip: float
    b: float  # F = N b v_C [s/m]
    b1: float  # |v_C| db/d|v_C|
    b_slip: float  # by the slip speed |v_0| of the wheel
    b_u: float  # by the speed of the axle


@kernel
def _slip(p, laws, k, load):
    """The Slip of the Patch ``k``."""
    speed = norm(k.v_C)
    grip, b, b1, b_slip, b_u = patch_gripping(p, laws, norm(k.v_0), speed, load.speed)
    e = k.v_C / speed if speed > 0.0 else ZERO
    return Slip(load.N * b * k.v_C, e, grip, b, b1, b_slip, b_u)


@kernel
def force(p, at, f, K, C, M):
    """Forces of ground and tyre law, and their derivatives; see the contract."""
    if at.phase == AIR:
        relax(p, at.q, at.v, f, K, C)
        return
    Rn, here = mat(at.R[0]), patch(p, at.laws, at.q, at.v, at.R)
    load = load_of(p, at.laws, here, at.q, at.v)
    slip = _slip(p, at.laws, here, load)
    G = add_load(f, Rn, here, load, slip.F)
    places, motions = changes(p, here, load, G, Rn, at.v[Y])
    for i in range(3):
        _add_block(K, 3 * i, Rn, here, load, slip, G, places[i])
        _add_block(C, 3 * i, Rn, here, load, slip, G, motions[i])


@kernel
def _add_block(A, j, Rn, k, load, slip, G, c):
    """Add the derivatives by the variables of the Change ``c``."""
    dN = normal_change(k, load, c.d)
    grown = slip.b * dN + load.N * (slip.b_u * c.speed + slip.b_slip * c.d.slip)
    slid = slip.b * c.d.v_C + outer(slip.b1 * slip.e, c.d.v_C.T @ slip.e)
    dF = outer(k.v_C, grown) + load.N * slid
    add_load_tangent(A, j, Rn, k, load, slip.F, G, dF, dN, c)


@kernel
def observe(p, at, F, y, e):
    """Outputs and energies; see OUTPUTS and the contract."""
    k = patch(p, at.laws, at.q, at.v, at.R)
    load = load_of(p, at.laws, k, at.q, at.v)
    slip = _slip(p, at.laws, k, load)
    on_wheel, lost = -slip.F, dot(slip.F, k.v_C)
    put_patch(p, at.laws, at.phase == CONTACT, k, at.q, at.v, load.radial, on_wheel, slip.grip, lost, load.law, y, e)


FLEXIBLE_WHEEL = patch_wheel("flexible_wheel", __doc__, SCALARS, force, observe)

r"""Wheel that deforms radially, laterally and in torsion, and slips on the ground, at any lean and heading.

Section 3.4 of Cardona, Geradin and Doan, CMAME 89 (1991), equations (47)-(51). Unknowns of its own: the patch is
displaced by y against the wheel plane (contact at x + r c - y a, on the ground) and turned by psi; with Q = 1 + psi
hat(n), rho = r c - y a, and n, q, r taken at the contact of the disc displaced by y:

    radial deformation   w = radius - r                  dw_0/dt = -n.(v + omega x rho)/q
    normal force         N = F_r(w, dw_0/dt)/q
    patch velocity       v_C = (I - n n^T)[v + Q (omega x rho) - Q a dy/dt] - dpsi/dt y (n x a)
    friction             F_fr = mu(|v_0|) sigma(u) phi(|v_C|) N v_C/|v_C|
    tyre law             {F; M} = A0 {y; psi} + A1 {dy/dt; dpsi/dt}

y and psi have no inertia. To make their rates unique, radial damping and the coefficient of friction are those of the
wheel with its patch held: dw_0/dt and v_0 are dw/dt and v_C without dy/dt and dpsi/dt (docs/tyre-equations.md).

A third unknown, the bow of the contact line, has its own equation X = 0, trivial except in the tyre law of a string.
v_C is defined as above; it is not the rate of the position of the patch, because psi also turns the rolling velocity:
in straight rolling without slip, dy/dt = v_lat - V psi. Internal forces (51), with G = Q^T F_fr - N n:

    x: F_fr - N n      Theta: R^T (rho x G)      y: F - a.G - s N_d      psi: M - y (n x a).F_fr

with N_d the part of N by damping. Upright this is the paper's (51) and the overturning moment y N about t, which it
neglects. Laws without a rate of psi have psi: M, and no dpsi/dt in v_C. The energy that the lateral law stores,
dissipates and exchanges with the rolling is given in docs/tyre-equations.md.

With a ``crown_radius`` the tyre is a torus, as that of the kind wheel: its w, C and n, and 1 for q in dw_0/dt and N.

In the phase "air" F = M = 0 and y, psi decay. For a patch that never slips see ``adhesive_wheel``. Validity as
``wheel``.
"""

from dataclasses import replace
from functools import cache

from mecano.constraints.tire_patch import FLAT_PATCH, ROUND_PATCH
from mecano.element_interface import named, record
from mecano.elements.wheels.crown import with_crown
from mecano.elements.wheels.lateral_law import relax
from mecano.elements.wheels.patch_wheel import (
    RECORD,
    SCALARS,
    PatchFriction,
    add_load,
    loads_by,
    patch_wheel,
    prepare,
    put_patch,
    sample,
    with_round_tread,
)
from mecano.elements.wheels.rolling_tyre import with_rolling
from mecano.elements.wheels.sliding_friction import SLIDING_FRICTION
from mecano.elements.wheels.tire_law import slip_law_of
from mecano.elements.wheels.tire_wheel import AIR
from mecano.jit.kernel import kernel
from mecano.maths.vector import add_vec, mat


def compiled(law):
    """Return ``residual`` and ``observe`` of a wheel with this friction, a SlipLaw."""
    forces, load_of, patch = law.forces, loads_by(law.slip), ROUND_PATCH if law.crowned else FLAT_PATCH

    @kernel
    def residual(p, at, f):
        """Add the forces of ground and tyre law; see element_interface."""
        if at.phase == AIR:
            relax(p, at, f)
            return
        k = patch(p, at)
        load = load_of(p, at, k)
        ground = forces(p, at.laws, load.slip)
        add_load(f, at, k, load, -ground.F)
        add_vec(f, 3, -1.0, mat(at.R[0]).T @ ground.M)

    @kernel
    def observe(p, at, F, y, e):
        """Write outputs and energies; see OUTPUTS and element_interface."""
        k = patch(p, at)
        load = load_of(p, at, k)
        ground = forces(p, at.laws, load.slip)
        put_patch(p, at, k, load, PatchFriction(load.slip.v, ground.F, ground.lost), y, e)

    return named(residual, observe)


@cache
def kind_with(law):
    """Return the Kind of a wheel with this friction, a SlipLaw, perhaps with a rounded tread, or a rolling radius."""
    kind = replace(
        FLEXIBLE_WHEEL, name=f"flexible_wheel_{law.name}", dtype=record(**RECORD, **law.record),
        prepare=lambda d, nodes, context: {**prepare(d, nodes, context), **law.prepare(d["tire_law"], context)},
        variant=None, **compiled(law),
    )  # fmt: skip
    return with_round_tread(kind) if law.crowned else kind


def variant(d):
    """Return the kind with or without a rounded tread, a rolling radius or a rolling resistance."""
    law = slip_law_of(d["tire_law"])
    return FLEXIBLE_WHEEL if law is SLIDING_FRICTION else kind_with(law)


def samples(rng):
    """Return samples of any wheel with a patch, and some with a rolling radius, a resistance, a rounded tread."""
    found = sample(rng)
    return [*found, with_rolling(found[0]), *map(with_crown, (found[1], found[2], found[3], with_rolling(found[0])))]


FLEXIBLE_WHEEL = replace(
    patch_wheel("flexible_wheel", __doc__, SCALARS, **compiled(SLIDING_FRICTION)), variant=variant, sample=samples
)

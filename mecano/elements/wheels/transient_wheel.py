r"""Wheel whose forces build up over a relaxation length: a massless carcass between the wheel and its contact.

Like ``wheel``, with two additional unknowns: the contact is deflected by x along t and by y along l relative to the
wheel. Its slip velocity is that of the wheel's point of contact plus that of the deflection (Pacejka, Tire and Vehicle
Dynamics, 2012, chapters 7 and 8),

    v' = v_C + dx/dt t + dy/dt l

and the slip law (Fiala, Magic Formula, or a user-defined one with a carcass) gives the force F at v'. F is balanced by
the carcass, with the stiffnesses K of the tyre law and a small damping:

    F.t = K_t (x + b_t (dx/dt)/V),   F.l = K_l (y + b_l (dy/dt)/V),   V = sqrt(V_x^2 + v_0^2)

with the velocity V_x of the axle along t; v_0 is 1 m/s here, whatever the 'least_speed' of the law, and for a radius
r < 0.1 m it is r per 0.1 s. Linearized with a slip stiffness C, the relaxation length is sigma = C/K + b. If the whole
contact slides, or the force falls with the slip, the deflection settles over the distance b; without b, its rate would
not be unique. The wheel loses F.v_C: the carcass stores (K_t x^2 + K_l y^2)/2, its damping and the slip dissipate the
rest, for any variation of the load. The force acts at the undeflected contact. Stiffnesses are those at the nominal
load of a .tir file.

With a torsional stiffness K_a of the tyre law the contact is also twisted by psi about n relative to the wheel. Its
turn slip is that of the rate of the wheel plus dpsi/dt, and its moment about n is that of the carcass:

    M.n = K_a (psi + b (dpsi/dt)/V)

A wheel that is steered on the spot then winds up before it slides, and stays wound up when the steering stops.

In the phase "air" all deflections decay in 1 ms.
"""

import numpy as np

from mecano.constraints.ground import GROUND_RECORD
from mecano.constraints.wheels import slow
from mecano.element_interface import Output, named
from mecano.elements.wheels.crown import with_crown
from mecano.elements.wheels.enveloping import with_enveloping
from mecano.elements.wheels.ground_surface import SURFACE_RECORD
from mecano.elements.wheels.rolling_contact import (
    FIRST,
    OUTPUTS,
    add_ground,
    by_slip_law,
    contact_of,
    law_samples,
    put_rolling,
    wheel_on_ground,
    with_slip,
)
from mecano.elements.wheels.rolling_tyre import with_rolling
from mecano.elements.wheels.slip_law import Slip, slipping
from mecano.elements.wheels.slip_laws import SLIP_LAWS, given_law
from mecano.elements.wheels.tire_law import slip_law_of
from mecano.elements.wheels.tire_wheel import AIR, CONTACT, check_wheel, prepare_wheel
from mecano.jit.kernel import kernel
from mecano.maths.dual import number, select, sqrt
from mecano.maths.vector import dot

X, Y, PSI = 6, 7, 8  # local unknowns
SCALARS = ("x", "y")
DECAY = 1e-3  # [s] time constant in the air
LEAST_SPEED = 1.0  # [m/s] v_0
CARCASS_RECORD = {"carcass_K": 2, "carcass_b": 2}
CARCASS_OUTPUTS = (
    Output("x", "m", "deflection of the contact along t relative to the wheel", rate="x_rate"),
    Output("y", "m", "deflection of the contact along l relative to the wheel", rate="y_rate"),
    Output("x_rate", "m/s", "rate of x"),
    Output("y_rate", "m/s", "rate of y"),
    Output("psi", "rad", "twist of the contact about n relative to the wheel; 0 if rigid", rate="psi_rate"),
    Output("psi_rate", "rad/s", "rate of psi"),
)
BEHIND = FIRST + 5  # index of the first of these outputs


@kernel
def carried(at, slip):
    """Return the Slip of the contact that moves with its deflection."""
    return slipping(slip, slip.v + (number(at.v[X]) * slip.t + number(at.v[Y]) * slip.l), slip.v_0)


@kernel
def twisted(at, k):
    """Return the Slip ``k`` of a contact that turns with its twist."""
    omega = k.omega + number(at.v[PSI]) * k.n
    return Slip(k.N, k.w, k.grip, k.v, k.v_0, k.u, omega, k.spin, k.lean, k.t, k.l, k.n, k.curvature)


@kernel
def untwisted(at, k):
    """Return the Slip ``k`` of a contact that does not twist."""
    return k


@kernel
def decay(p, at, slip):
    """Return b/V [s] along t and l, in which the carcass settles under a constant force; in the air DECAY."""
    forward = dot(slip.t, slip.u)
    least = slow(p.radius, LEAST_SPEED)
    V, air = sqrt(forward * forward + least * least), at.phase == AIR
    return select(air, DECAY, p.carcass_b[0] / V), select(air, DECAY, p.carcass_b[1] / V)


@kernel
def add_spring(f, at, i, K, tau, force):
    """Add the force of a part of the carcass for the unknown ``i``, of the stiffness ``K``, less that of the ground."""
    f[i] += K * (number(at.q[i]) + tau * number(at.v[i])) - force


@kernel
def put_spring(e, at, i, K, tau):
    """Add the energies of this part of the carcass to ``e``."""
    e[1] += 0.5 * K * at.q[i] * at.q[i]
    e[2] += K * tau * at.v[i] * at.v[i]


def compiled(law):
    """Return ``residual`` and ``observe`` of a wheel with a SlipLaw."""
    forces, slip, seen, (rolling, _) = law.forces, law.slip, law.seen, contact_of(law)
    twists, twist = law.twists, twisted if law.twists else untwisted

    @kernel
    def residual(p, at, f):
        """Add the forces of ground and carcass; see element_interface."""
        if at.phase == AIR:
            add_spring(f, at, X, p.carcass_K[0], DECAY, 0.0)
            add_spring(f, at, Y, p.carcass_K[1], DECAY, 0.0)
            if twists:
                add_spring(f, at, PSI, p.torsion, DECAY, 0.0)
            return
        k = rolling(p, at, True)
        k = with_slip(k, slip(p, k.slip))
        ground = forces(p, at.laws, twist(at, carried(at, k.slip)))
        add_ground(f, at, k, ground)
        tau_t, tau_l = decay(p, at, k.slip)
        add_spring(f, at, X, p.carcass_K[0], tau_t, dot(ground.F, k.slip.t))
        add_spring(f, at, Y, p.carcass_K[1], tau_l, dot(ground.F, k.slip.l))
        if twists:
            add_spring(f, at, PSI, p.torsion, tau_t, dot(ground.M, k.slip.n))

    @kernel
    def observe(p, at, F, y, e):
        """Write outputs and energies."""
        k = rolling(p, at, at.phase == CONTACT)
        k = with_slip(k, slip(p, k.slip))
        ground = forces(p, at.laws, twist(at, carried(at, k.slip)))
        put_rolling(p, at, with_slip(k, seen(p, k.slip)), ground, y, e)
        y[BEHIND], y[BEHIND + 1], y[BEHIND + 2], y[BEHIND + 3] = at.q[X], at.q[Y], at.v[X], at.v[Y]
        tau_t, tau_l = decay(p, at, k.slip)
        put_spring(e, at, X, p.carcass_K[0], tau_t)
        put_spring(e, at, Y, p.carcass_K[1], tau_l)
        if twists:
            y[BEHIND + 4], y[BEHIND + 5] = at.q[PSI], at.v[PSI]
            put_spring(e, at, PSI, p.torsion, tau_t)

    return named(residual, observe)


def check(d, nodes):
    """Return errors of any wheel with a tyre law, and for a law without a carcass."""
    texts, law = check_wheel(d, nodes), slip_law_of(d["tire_law"])
    if texts:
        return texts
    name = given_law(d["tire_law"]).name
    if law.carcass is None:
        known = ", ".join(name for name, other in SLIP_LAWS.items() if other.carcass)
        return [f"'tire_law.{name}' has no carcass, which a transient_wheel needs; laws with a carcass: {known}"]
    if law.carcass(d["tire_law"]) is None:
        return [
            f"'tire_law.{name}' has no carcass stiffness, which a transient_wheel needs: "
            "'carcass_stiffness' of fiala; PTX1 and PTY1, or LONGITUDINAL_STIFFNESS and LATERAL_STIFFNESS, of a file"
        ]
    return []


def sample(rng):
    """Return large wheels with each slip law that has a carcass, in contact and in the air."""
    laws = [law for law in SLIP_LAWS.values() if law.carcass]
    found = [one for law, own in zip(laws, rng.spawn(len(laws)), strict=True) for one in law_samples(own, law)]
    rounded = [one for one in found if one[0]["tire_law"].get("magic_formula")][1:3]
    return [*found, with_rolling(found[0]), with_enveloping(found[0]), *map(with_crown, rounded)]


def prepare(d, nodes, context):
    """Return the values of the record; see element_interface."""
    carcass = slip_law_of(d["tire_law"]).carcass(d["tire_law"])
    return {
        **prepare_wheel(d, nodes, context),
        "carcass_K": np.array(carcass.stiffness),
        "carcass_b": np.array(carcass.creep),
    }


def with_law(law):
    """Return the Kind with a SlipLaw, whose contact is twisted if the law says so."""
    scalars = (*SCALARS, "psi") if law.twists else SCALARS
    return wheel_on_ground(
        law, compiled,
        own_record={**CARCASS_RECORD, **GROUND_RECORD, **SURFACE_RECORD},
        name="transient_wheel", doc=__doc__, scalars=scalars, massless=scalars,
        outputs=(*OUTPUTS, *CARCASS_OUTPUTS),
        **named(prepare, check, sample),
    )  # fmt: skip


TRANSIENT_WHEEL = by_slip_law(with_law, SLIP_LAWS["fiala"])

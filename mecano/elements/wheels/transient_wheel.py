r"""Wheel whose forces build up over a relaxation length: a massless carcass between the wheel and its contact.

Like ``wheel``, with two additional unknowns: the contact is deflected by x along t and by y along l relative to the
wheel. Its slip velocity is that of the wheel's point of contact plus that of the deflection (Pacejka, Tire and Vehicle
Dynamics, 2012, chapters 7 and 8),

    v' = v_C + dx/dt t + dy/dt l

and the slip law (Fiala, Magic Formula, or a user-defined one with a carcass) gives the force F at v'. F is balanced by
the carcass, with the stiffnesses K of the tyre law and a small damping:

    F.t = K_t (x + b_t (dx/dt)/V),   F.l = K_l (y + b_l (dy/dt)/V),   V = sqrt(V_x^2 + v_0^2)

with the velocity V_x of the axle along t; v_0 is 1 m/s here, whatever the 'least_speed' of the law.
Linearized with a slip stiffness C, the relaxation length is sigma = C/K + b. If the whole contact slides, or the force
falls with the slip, the deflection settles over the distance b; without b, its rate would not be unique. The wheel
loses F.v_C: the carcass stores (K_t x^2 + K_l y^2)/2, its damping and the slip dissipate the rest, for any variation of
the load. The force acts at the undeflected contact. Stiffnesses are those at the nominal load of a .tir file.

In the phase "air" both deflections decay in 1 ms.
"""

from functools import partial

import numpy as np

from mecano.constraints.ground import GROUND_RECORD
from mecano.element_interface import Output, named
from mecano.elements.wheels.enveloping import with_enveloping
from mecano.elements.wheels.ground_surface import SURFACE_RECORD
from mecano.elements.wheels.rolling_contact import (
    FIRST,
    OUTPUTS,
    add_ground,
    by_slip_law,
    law_samples,
    put_rolling,
    rolling_of,
    wheel_on_ground,
    with_slip,
)
from mecano.elements.wheels.rolling_tyre import with_rolling
from mecano.elements.wheels.slip_law import slipping
from mecano.elements.wheels.slip_laws import SLIP_LAWS, given_law
from mecano.elements.wheels.tire_law import slip_law_of
from mecano.elements.wheels.tire_wheel import AIR, CONTACT, check_wheel, prepare_wheel
from mecano.jit.kernel import kernel
from mecano.maths.dual import number, select, sqrt
from mecano.maths.vector import dot

X, Y = 6, 7  # local unknowns
SCALARS = ("x", "y")
DECAY = 1e-3  # [s] time constant in the air
LEAST_SPEED = 1.0  # [m/s] v_0
CARCASS_RECORD = {"stiffness": 2, "creep": 2}
CARCASS_OUTPUTS = (
    Output("x", "m", "deflection of the contact along t relative to the wheel", rate="x_rate"),
    Output("y", "m", "deflection of the contact along l relative to the wheel", rate="y_rate"),
    Output("x_rate", "m/s", "rate of x"),
    Output("y_rate", "m/s", "rate of y"),
)
BEHIND = FIRST + 5  # index of the first of these outputs


@kernel
def carried(at, slip):
    """Return the Slip of the contact that moves with its deflection."""
    return slipping(slip, slip.v + (number(at.v[X]) * slip.t + number(at.v[Y]) * slip.l), slip.v_0)


@kernel
def damping(p, slip):
    """Return the damping of the carcass along t and l [N s/m]."""
    forward = dot(slip.t, slip.u)
    V = sqrt(forward * forward + LEAST_SPEED * LEAST_SPEED)
    return p.stiffness[0] * p.creep[0] / V, p.stiffness[1] * p.creep[1] / V


def compiled(law):
    """Return ``residual`` and ``observe`` of a wheel with a SlipLaw."""
    forces, slip, seen, rolling = law.forces, law.slip, law.seen, rolling_of(law)

    @kernel
    def residual(p, at, f):
        """Add the forces of ground and carcass; see element_interface."""
        x, y, x1, y1 = number(at.q[X]), number(at.q[Y]), number(at.v[X]), number(at.v[Y])
        if at.phase == AIR:
            f[X] += p.stiffness[0] * (x + DECAY * x1)
            f[Y] += p.stiffness[1] * (y + DECAY * y1)
            return
        k = rolling(p, at, True)
        k = with_slip(k, slip(p, k.slip))
        ground = forces(p, at.laws, carried(at, k.slip))
        add_ground(f, at, k, ground)
        d_t, d_l = damping(p, k.slip)
        f[X] += p.stiffness[0] * x + d_t * x1 - dot(ground.F, k.slip.t)
        f[Y] += p.stiffness[1] * y + d_l * y1 - dot(ground.F, k.slip.l)

    @kernel
    def observe(p, at, F, y, e):
        """Write outputs and energies."""
        k = rolling(p, at, at.phase == CONTACT)
        k = with_slip(k, slip(p, k.slip))
        ground = forces(p, at.laws, carried(at, k.slip))
        put_rolling(p, at, with_slip(k, seen(p, k.slip)), ground, y, e)
        x1, y1 = at.v[X], at.v[Y]
        y[BEHIND], y[BEHIND + 1], y[BEHIND + 2], y[BEHIND + 3] = at.q[X], at.q[Y], x1, y1
        c_t, c_l = damping(p, k.slip)
        d_t = select(at.phase == AIR, DECAY * p.stiffness[0], c_t)
        d_l = select(at.phase == AIR, DECAY * p.stiffness[1], c_l)
        e[1] += 0.5 * (p.stiffness[0] * at.q[X] * at.q[X] + p.stiffness[1] * at.q[Y] * at.q[Y])
        e[2] += d_t * x1 * x1 + d_l * y1 * y1

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
    return [*found, with_rolling(found[0]), with_enveloping(found[0])]


def prepare(d, nodes, context):
    """Return the values of the record; see element_interface."""
    carcass = slip_law_of(d["tire_law"]).carcass(d["tire_law"])
    return {
        **prepare_wheel(d, nodes, context),
        "stiffness": np.array(carcass.stiffness),
        "creep": np.array(carcass.creep),
    }


with_law = partial(
    wheel_on_ground,
    compiled=compiled,
    own_record={**CARCASS_RECORD, **GROUND_RECORD, **SURFACE_RECORD},
    name="transient_wheel",
    doc=__doc__,
    scalars=SCALARS,
    massless=SCALARS,
    outputs=(*OUTPUTS, *CARCASS_OUTPUTS),
    **named(prepare, check, sample),
)
TRANSIENT_WHEEL = by_slip_law(with_law, SLIP_LAWS["fiala"])

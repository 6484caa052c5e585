r"""Wheel that deforms radially and slips on the ground, at any lean and heading.

Theory: section 3.3 of Cardona, Geradin and Doan, CMAME 89 (1991), equations (27)-(46), here for leaning wheels too.
With the axis a = R a0, the contact C = x + r c (n, q = |n - (n.a) a| and r taken at C), and the tyre law:

    radial deformation   w = radius - r                  dw/dt = -n.(v + omega x r c)/q
    normal force         N = F_r(w, dw/dt)/q             F_r acts in the plane of the wheel
    slip velocity        v_C = (I - n n^T)(v + omega x r c)
    force and moment     F, M of the slip law: friction, fiala, magic_formula, ...

The whole ground force F + N n acts at C. Internal forces, with f = -(F + N n) (36):

    force: f          material moment: R^T (r c x f - M)

For an upright wheel with friction this is the paper's vector; for a leaning one, -N (r c) x n is the tipping moment.
The power is -(F.v_C + M.omega) + F_r dw/dt: the power dissipated by slip and damping (never negative), exchanged with
the rolling by the slip law, and stored by the radial law. dw/dt depends on q and on v.

With a ``crown_radius`` the tyre is a torus, whose radial force acts along n at its own contact with the ground
(docs/tyre-equations.md, Rounded treads).

In the phase "air" there is no force. In the phase "contact" the tyre law is continued smoothly to w < 0, for steps that
end at the lift-off; no accepted step ends there. A regularized contact creeps: at rest under a driving force T it
slides at about eps T/(2 mu N).

Validity: one contact; on concave ground, a radius of curvature larger than the wheel's radius; the wheel does not lie
flat on the ground (q > 0: checked initially, finite at all times). The node is that of the wheel body: its rotation
includes the spin of the wheel.
"""

from functools import partial

from mecano.constraints.ground import GROUND_RECORD
from mecano.element_interface import named
from mecano.elements.wheels.crown import with_crown
from mecano.elements.wheels.enveloping import with_enveloping
from mecano.elements.wheels.ground_surface import SURFACE_RECORD
from mecano.elements.wheels.rolling_contact import (
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
from mecano.elements.wheels.slip_laws import SLIP_LAWS
from mecano.elements.wheels.tire_wheel import AIR, CONTACT, check_wheel, large_wheel, prepare_wheel
from mecano.jit.kernel import kernel


def compiled(law):
    """Return ``residual`` and ``observe`` of a wheel with a SlipLaw."""
    forces, slip, seen, (rolling, _) = law.forces, law.slip, law.seen, contact_of(law)

    @kernel
    def residual(p, at, f):
        """Add force and material moment of the ground; see element_interface."""
        if at.phase == AIR:
            return
        k = rolling(p, at, True)
        k = with_slip(k, slip(p, k.slip))
        add_ground(f, at, k, forces(p, at.laws, k.slip))

    @kernel
    def observe(p, at, F, y, e):
        """Write outputs and energies."""
        k = rolling(p, at, at.phase == CONTACT)
        k = with_slip(k, slip(p, k.slip))
        put_rolling(p, at, with_slip(k, seen(p, k.slip)), forces(p, at.laws, k.slip), y, e)

    return named(residual, observe)


def sample(rng):
    """Return large wheels on a plane and a profile, slipping, sticking, in the air, and with each other slip law."""
    friction = (("exponential", {"start": 0.8, "limit": 0.3, "rate": 0.1, "origin": 0.0}),)
    by_speed = (("exponential", {"start": 1.0, "limit": 0.0, "rate": 0.2, "origin": 0.0}),)
    found = [
        (large_wheel(rng, profile, eps, friction, by_speed, None), 1, phase)
        for profile, eps, phase in ((False, 0.05, "contact"), (True, 50.0, "contact"), (True, 0.05, "air"))
    ]
    for law, own in zip(SLIP_LAWS.values(), rng.spawn(len(SLIP_LAWS)), strict=True):
        found += law_samples(own, law)
    return [
        *found,
        *(with_rolling(found[i]) for i in (0, 3)),
        *(with_enveloping(found[i], b) for i, b in ((1, 0.0), (2, 0.0), (1, 3.0))),
        *(with_crown(one) for one in (found[1], with_rolling(found[0]), found[-2], with_enveloping(found[1], 3.0))),
    ]


with_law = partial(
    wheel_on_ground,
    compiled=compiled,
    own_record={**GROUND_RECORD, **SURFACE_RECORD},
    prepare=prepare_wheel,
    name="wheel", doc=__doc__,
    outputs=OUTPUTS,
    check=check_wheel,
    sample=sample,
)  # fmt: skip
WHEEL = by_slip_law(with_law, SLIP_LAWS["friction"])

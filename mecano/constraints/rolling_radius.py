r"""Rolling radius: a disc of given radius touches the ground, :math:`r - radius = 0`.

With axis a, contact C = x + r c and q = |n - (n.a) a| of surface.py. On a plane this is (18) of Cardona, Geradin & Doan
1991 divided by q, (x - P).n - radius q = 0. The gradient is n/q at C, so the multiplier is the force in the plane of
the disc and the normal force N = k lambda/q. The constraint is inactive in the phase "air". For a
torus (torus.py) it is -w = 0, with the gradient n at C.
"""

from dataclasses import replace

import numpy as np

from mecano.constraints.augmented_lagrangian import in_phase, scalar_constraint
from mecano.constraints.ground import GROUND_RECORD, normal_and_level
from mecano.constraints.no_slip import CONTACT
from mecano.constraints.tread import flat_on_ground, rounded_on_ground
from mecano.constraints.triads import unit
from mecano.element_interface import Kind, Row, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import cross, mat, vec

RECORD = record(axis=3, radius=(), **GROUND_RECORD)
MULTIPLIER = 6


def pressed_by(tread_on_ground):
    """Return the functions of the constraint for a tread of tread.py."""

    @kernel
    def press(p, at):
        """Return r - radius and its gradient."""
        Rn = mat(at.R[0])
        k = tread_on_ground(p, at.laws, vec(at.q, 0), Rn @ vec(p.axis, 0))
        b = k.g.n / k.tilt
        return k.g.r - p.radius, ((0, b), (3, Rn.T @ cross(k.g.arm, b)))

    return scalar_constraint(press, MULTIPLIER, in_phase(CONTACT))


def leaning_discs(rng):
    """Return samples: leaning discs above a plane about 8 m from the origin, in contact and in the air."""
    found = []
    for phase in ("contact", "air"):
        normal, level = normal_and_level(rng)
        axis = unit(level + rng.uniform(-0.5, 0.5) * normal)
        ground = {"point": -8.0 * normal, "normal": normal, "direction": level, "height": 0, "crown": 0.0}
        found.append(({"axis": axis, "radius": 7.0, **ground}, [(rng.normal(size=3), np.eye(3))], phase))
    return found


ROLLING_RADIUS = Kind(
    name="rolling_radius", doc=__doc__, dtype=RECORD, layout=("x0", "R0"),
    multipliers=(Row("radial force of the ground", "N", "m", unilateral=True),),
    phases=("contact", "air"),
    **pressed_by(flat_on_ground),
    sample=leaning_discs,
)  # fmt: skip
ROUND_RADIUS = replace(ROLLING_RADIUS, name="rolling_radius_crowned", **pressed_by(rounded_on_ground))

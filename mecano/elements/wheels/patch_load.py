"""Load in the patch of a wheel: radial force and lateral law.

The friction F in the ground is left to the kind of wheel: its patch slips, or it is held.
"""

from typing import NamedTuple

from mecano.constraints.tire_patch import Y, add_patch_force
from mecano.elements.wheels.ground_surface import surface_at
from mecano.elements.wheels.lateral_force import Lateral, lateral_law
from mecano.elements.wheels.slip_law import Slip
from mecano.elements.wheels.tire_law import radial_force
from mecano.jit.kernel import kernel
from mecano.laws.contact_force import elastic_force
from mecano.maths.surface import directions
from mecano.maths.vector import add_vec, dot, mat, norm, vec


class Load(NamedTuple):
    """Forces in the patch except its friction."""

    radial: float  # F_r [N]
    N: float  # normal force [N]
    damping: float  # its part by radial damping [N]
    slip: Slip
    law: Lateral


@kernel
def load_of(p, at, k):
    """Return the Load of the Patch ``k``."""
    w = p.radius - k.g.r
    v, radial = vec(at.v, 0), radial_force(p, at.laws, w, k.w1)
    N, damping = radial / k.g.q, (radial - elastic_force(at.laws, p.radial, w)) / k.g.q
    u, (t, l) = v - dot(k.g.n, v) * k.g.n, directions(k.a, k.g)
    grip = surface_at(p, at, k.g.n, vec(at.q, 0) + k.rho).grip
    slip = Slip(N, w, grip, k.v_C, k.v_0, u, k.omega, dot(k.omega, k.a), k.g.s, t, l, k.g.n, 0.0)
    turning = dot(k.g.n, k.omega)
    law = lateral_law(p, at.laws, vec(at.q, Y), vec(at.v, Y), k.rolled, N, norm(u), dot(t, u), turning)
    return Load(radial, N, damping, slip, law)


@kernel
def add_load(f, at, k, load, F):
    """Add the forces of a Load and of the friction F (3,) [N] in the ground."""
    R = mat(at.R[0])
    add_patch_force(f, R, k, F, load.N, load.damping)
    add_vec(f, 3, -load.law.turn, R.T @ k.g.n)
    add_vec(f, Y, 1.0, load.law.f)

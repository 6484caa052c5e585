"""The contact patch of a tyre, displaced sideways by y and rotated by psi relative to the wheel: kinematics, forces.

Section 3.4 of Cardona, Geradin & Doan 1991, equations (48)-(51), here for leaning wheels and uneven ground, as in
elements/wheels/flexible_wheel.py. Radial damping acts on dw_0/dt, the rate of deformation with the patch fixed in the
wheel; so do the laws that depend on v_0, which is v_C without the rates of y and psi (docs/tyre-equations.md). The
terms of v_C and of psi with dpsi/dt y and y are omitted (``twist`` = 0) where psi is not a twist.
"""

from typing import NamedTuple

from mecano.constraints.tread import Tread, flat_on_ground, rounded_on_ground
from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.maths.surface import Contact
from mecano.maths.vector import add_vec, cross, dot, mat, vec

Y, PSI, BOW = 6, 7, 8  # local unknowns


class Patch(NamedTuple):
    """The moving patch; 3-vectors in the inertial frame."""

    g: Contact
    a: tuple  # axis
    across: tuple  # n x a
    omega: tuple
    rho: tuple
    y: float
    psi: float
    v_C: tuple  # [m/s]
    v_0: tuple  # v_C with the patch fixed in the wheel [m/s]
    w1: float  # dw/dt with the patch fixed in the wheel [m/s]
    tread: Tread
    twist: float  # 1 if the twist moves a displaced patch, 0 if psi is only the slip angle


def patch_with(tread_on_ground):
    """Return the kernel that gives the Patch of a wheel with a tread of tread.py."""

    @kernel
    def patch(p, at):
        """Return the Patch of a wheel whose record has GROUND_RECORD, axis, radius and twist."""
        R, v, y, psi, psi1 = mat(at.R[0]), at.v, number(at.q[Y]), number(at.q[PSI]), number(at.v[PSI])
        a, omega = R @ vec(p.axis, 0), R @ vec(v, 3)
        tread = tread_on_ground(p, at.laws, vec(at.q, 0) - y * a, a)
        g = tread.g
        rho, across = g.arm - y * a, cross(g.n, a)
        z = cross(omega, rho) - v[Y] * a
        u = vec(v, 0) + (z + psi * cross(g.n, z))
        lift = dot(g.n, u)
        aside = a - g.s * g.n + psi * across  # Q a in the ground
        v_C = u - lift * g.n - p.twist * psi1 * y * across
        v_0 = v_C + (v[Y] * aside + p.twist * psi1 * y * across)
        w1 = -(lift + v[Y] * g.s) / tread.tilt
        return Patch(g, a, across, omega, rho, y, psi, v_C, v_0, w1, tread, p.twist)

    return patch


FLAT_PATCH, ROUND_PATCH = patch_with(flat_on_ground), patch_with(rounded_on_ground)


@kernel
def add_patch_force(f, R, k, F, N, damping):
    """Add the force of the patch: F in the ground plane, N normal to it [N]; its part ``damping`` does not act on y."""
    G = F - k.psi * cross(k.g.n, F) - N * k.g.n
    add_vec(f, 0, 1.0, F - N * k.g.n)
    add_vec(f, 3, 1.0, R.T @ cross(k.rho, G))
    f[Y] -= dot(k.a, G) + k.g.s * damping
    f[PSI] -= k.twist * k.y * dot(k.across, F)

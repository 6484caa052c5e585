r"""The patch of a tyre that is displaced sideways by y and turned by psi against the wheel: kinematics and forces.

Section 3.4 of Cardona, Geradin & Doan 1991, equations (48)-(51), here for leaning wheels and uneven ground. With the
axis a, the contact C = x' + r c of a disc at x' = x - y a (surface.py), rho = r c - y a, and Q = 1 + psi hat(n):

.. math::
    v_C = (1 - n n^T)[v + Q (\omega \times \rho) - Q a \dot y] - \dot\psi\, y\, (n \times a), \qquad
    \dot w_0 = -n \cdot (v + \omega \times \rho)/q

Radial damping acts on :math:`\dot w_0`, the rate of deformation with the patch held in the wheel; so do the laws that
depend on v_0, which is v_C without the rates of y and psi (docs/tyres.md).

A force of the patch on the ground, F in the ground and -N n along its normal, N_d of N by damping, G = Q^T F - N n:

.. math::
    x: F - N n, \quad \Theta: R^T (\rho \times G), \quad y: -a \cdot G - s N_d, \quad
    \psi: -y\, (n \times a) \cdot F

The terms of v_C and of psi with :math:`\dot\psi\, y` and y are left out (``twist`` = 0) where psi is no twist.

Derivatives come in blocks of three variables: X (dx), T (inertial dtheta), S (dy, dpsi and a third own unknown, on
which nothing here depends), each 3x3 or 3; those by the velocities likewise.
"""

from typing import NamedTuple

from mecano.compiled.kernel import kernel
from mecano.constraints.ground import touch
from mecano.maths.surface import Contact, disc_variation
from mecano.maths.vector import (
    EYE,
    NO_MATRIX,
    ZERO,
    Mat3,
    Vec3,
    add_mat,
    add_row,
    add_vec,
    cross,
    dot,
    mat,
    norm,
    outer,
    skew,
    vec,
)

Y, PSI, BOW = 6, 7, 8  # local unknowns
OF_Y, OF_PSI = EYE[0], EYE[1]  # derivatives of y and psi in the block S


class Patch(NamedTuple):
    """The patch in motion; 3-vectors in the inertial frame."""

    g: Contact
    a: tuple  # axis
    across: tuple  # n x a
    omega: tuple
    rho: tuple
    y: float
    psi: float
    psi1: float
    z: tuple  # omega x rho - a dy/dt [m/s]
    u: tuple  # v + Q z [m/s]
    lift: float  # n.u [m/s]
    v_C: tuple  # [m/s]
    v_0: tuple  # v_C with the patch held in the wheel [m/s]
    w1: float  # dw/dt with the patch held in the wheel [m/s]
    rolled: float  # dy/dt of a patch that does not slip sideways [m/s]
    twist: float  # 1 where the twist moves a displaced patch along, 0 where psi is but the slip angle


class Variation(NamedTuple):
    """Derivatives by three variables, 3x3 or 3; zero where the variables are velocities: those of geometry."""

    n: tuple
    a: tuple
    s: tuple
    across: tuple
    rho: tuple
    y: tuple
    psi: tuple
    w: tuple  # of the deformation
    v_C: tuple
    slip: tuple  # of |v_0|
    rolled: tuple
    w1: tuple


@kernel
def columns(a, b):
    """The matrix (a, b, 0)."""
    return Mat3(a, b, ZERO).T


@kernel
def patch(p, laws, q, v, R):
    """The Patch of a wheel of record ``p`` (GROUND_RECORD, axis, radius), local unknowns q and v."""
    Rn = mat(R[0])
    a, omega, y, psi = Rn @ vec(p.axis, 0), Rn @ vec(v, 3), q[Y], q[PSI]
    g = touch(p, laws, vec(q, 0) - y * a, a)
    rho, across = g.arm - y * a, cross(g.n, a)
    z = cross(omega, rho) - v[Y] * a
    u = vec(v, 0) + (z + psi * cross(g.n, z))
    lift = dot(g.n, u)
    aside = a - g.s * g.n + psi * across  # Q a in the ground
    v_C = u - lift * g.n - p.twist * v[PSI] * y * across
    v_0 = v_C + (v[Y] * aside + p.twist * v[PSI] * y * across)
    w1, rolled = -(lift + v[Y] * g.s) / g.q, dot(v_0, a) / g.q**2
    return Patch(g, a, across, omega, rho, y, psi, v[PSI], z, u, lift, v_C, v_0, w1, rolled, p.twist)


@kernel
def by_positions(p, k, y1):
    """Variations of the Patch ``k`` by X, T and S; ``y1`` = dy/dt."""
    at_x, at_t = disc_variation(vec(p.direction, 0), k.a, k.g)
    turn, y_turn, w = skew(k.a), k.y * skew(k.a), skew(k.omega)
    # x' moves by dx - a dy + y a x dtheta
    n_t, s_t = at_t.n + at_x.n @ y_turn, at_t.s + y_turn.T @ at_x.s
    arm_t = at_t.arm + at_x.arm @ y_turn
    n_y, s_y = columns(-(at_x.n @ k.a), ZERO), Vec3(-dot(at_x.s, k.a), 0.0, 0.0)
    arm_y = -(at_x.arm @ k.a)
    X = _variation(k, y1, at_x.n, NO_MATRIX, at_x.s, at_x.arm, at_x.arm, NO_MATRIX, ZERO, ZERO)
    T = _variation(k, y1, n_t, -turn, s_t, arm_t, arm_t + y_turn, skew(k.rho) @ w, ZERO, ZERO)
    rho_y = columns(arm_y - k.a, ZERO)
    S = _variation(k, y1, n_y, NO_MATRIX, s_y, columns(arm_y, ZERO), rho_y, NO_MATRIX, OF_Y, OF_PSI)
    return X, T, S


@kernel
def _variation(k, y1, n, a, s, arm, rho, z_turned, y, psi):
    """The Variation from those of normal, axis, s, r c, rho, y and psi; ``z_turned`` is that of z by dR Omega."""
    g = k.g
    z = skew(k.omega) @ rho + z_turned - y1 * a
    swing = -(skew(k.z) @ n) + skew(g.n) @ z
    u = z + (k.psi * swing + outer(cross(g.n, k.z), psi))
    lift = n.T @ k.u + u.T @ g.n
    across = -(skew(k.a) @ n) + skew(g.n) @ a
    twisted = k.twist * k.psi1 * (k.y * across + outer(k.across, y))
    v_C = u + outer(-g.n, lift) + (-k.lift * n - twisted)
    aside = a - g.s * n + outer(-g.n, s)
    aside = aside + (k.psi * across + outer(k.across, psi))
    v_0 = v_C + (y1 * aside + twisted)
    w1 = -(lift + y1 * s) / g.q + k.w1 * g.s / g.q**2 * s
    along = v_0.T @ k.a + (a.T @ k.v_0 + 2.0 * k.rolled * g.s * s)
    rolled, slip = along / g.q**2, v_0.T @ _along(k)
    return Variation(n, a, s, across, rho, y, psi, -(arm.T @ g.c), v_C, slip, rolled, w1)


@kernel
def _along(k):
    """The direction of v_0, zero at rest."""
    speed = norm(k.v_0)
    return k.v_0 / speed if speed > 0.0 else ZERO


@kernel
def by_velocities(k):
    """Variations of the Patch ``k`` by v, inertial omega, and (dy/dt, dpsi/dt)."""
    V = _by_velocity(k, EYE, NO_MATRIX, 1.0)
    W = _by_velocity(k, _with_psi(k, -skew(k.rho)), NO_MATRIX, 1.0)
    aside = columns(ZERO, -k.twist * k.y * k.across)
    return V, W, _by_velocity(k, _with_psi(k, columns(-k.a, ZERO)), aside, 0.0)


@kernel
def _with_psi(k, z):
    """Q z for a matrix z."""
    return z + k.psi * (skew(k.g.n) @ z)


@kernel
def _by_velocity(k, u, aside, of_wheel):
    """The Variation by three velocities; ``of_wheel`` is 1 for those of the wheel, 0 for those of the patch in it."""
    lift = u.T @ k.g.n
    v_C = u + outer(-k.g.n, lift) + aside
    no, slip = NO_MATRIX, of_wheel * (v_C.T @ _along(k))
    rolled, w1 = of_wheel / k.g.q**2 * (v_C.T @ k.a), -of_wheel / k.g.q * lift
    return Variation(no, no, ZERO, no, no, ZERO, ZERO, ZERO, v_C, slip, rolled, w1)


@kernel
def add_patch_force(f, Rn, k, F, N, damping):
    """Add the force of the patch: F in the ground, N against it [N], of which ``damping`` is not on y. Returns G."""
    G = F - k.psi * cross(k.g.n, F) - N * k.g.n
    add_vec(f, 0, 1.0, F - N * k.g.n)
    add_vec(f, 3, 1.0, Rn.T @ cross(k.rho, G))
    f[Y] -= dot(k.a, G) + k.g.s * damping
    f[PSI] -= k.twist * k.y * dot(k.across, F)
    return G


@kernel
def patch_column(k, F):
    """What a force F (inertial, in the ground) does on x, theta (inertial) and (y, psi, 0)."""
    G = F - k.psi * cross(k.g.n, F)
    return F, cross(k.rho, G), Vec3(-dot(k.a, G), -k.twist * k.y * dot(k.across, F), 0.0)


@kernel
def add_patch_tangent(A, j, Rn, frame, k, F, N, damping, G, dF, dN, d_damping, d, moment):
    """Add the derivatives of ``add_patch_force`` by three variables, to the columns of A from j on.

    ``dF`` 3x3, ``dN`` (3,) and ``d_damping`` (3,) are those of F, N and the damping, ``d`` the Variation, ``frame``
    turns the variables; ``moment`` 3x3 is what the turning of the node itself adds.
    """
    n = k.g.n
    dP = dF - (outer(n, dN) + N * d.n)
    swing = -(skew(F) @ d.n) + skew(n) @ dF
    dG = dP + (-k.psi * swing + outer(-cross(n, F), d.psi))
    turn = skew(k.rho) @ dG - skew(G) @ d.rho + moment
    side = d.a.T @ G + dG.T @ k.a + (damping * d.s + k.g.s * d_damping)
    yaw = k.y * (d.across.T @ F + dF.T @ k.across) + dot(k.across, F) * d.y
    add_mat(A, 0, j, 1.0, dP @ frame)
    add_mat(A, 3, j, 1.0, Rn.T @ (turn @ frame))
    add_row(A, Y, j, -1.0, frame.T @ side)
    add_row(A, PSI, j, -k.twist, frame.T @ yaw)

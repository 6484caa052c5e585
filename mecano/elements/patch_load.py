"""Load in the patch of a wheel: radial force, lateral law, and what every block of variables changes of them.

The friction F in the ground and its derivatives are left to the kind of wheel: it slips, or it is held.
"""

from typing import NamedTuple

from mecano.compiled.kernel import kernel
from mecano.constraints.tire_patch import (
    Variation,
    Y,
    add_patch_force,
    add_patch_tangent,
    by_positions,
    by_velocities,
)  # fmt: skip
from mecano.elements.lateral_force import Lateral, lateral_law, law_rows
from mecano.elements.tire_law import damped_force, elastic_force, speed_over_ground
from mecano.maths.vector import EYE, NO_MATRIX, ZERO, add_mat, add_vec, cross, dot, outer, skew, vec


class Load(NamedTuple):
    """Forces in the patch but its friction, and what they depend on; 3-vectors in the inertial frame."""

    radial: float  # F_r [N]
    F_w: float  # dF_r/dw [N/m]
    F_w1: float  # dF_r/d(dw/dt) [N s/m]
    slope: float  # dF/dw of the elastic force F [N/m]
    N: float  # normal force [N]
    damping: float  # its part by radial damping [N]
    v: tuple  # velocity of the axle [m/s]
    speed: float  # of the axle over the ground [m/s]
    ahead: tuple  # its direction
    law: Lateral


class Change(NamedTuple):
    """Derivatives by three variables."""

    d: Variation  # of the patch
    speed: tuple  # of the speed of the axle
    turning: tuple  # of the turning rate of the wheel about n
    by_law: tuple  # of the Lateral through its own unknowns
    moment: tuple  # of the moment on the node through its turning, 3x3
    frame: tuple  # turns the variables, 3x3


@kernel
def load_of(p, laws, k, q, v):
    """The Load of the Patch ``k``."""
    elastic, slope = elastic_force(p, laws, p.radius - k.g.r)
    radial, F_w, F_w1 = damped_force(p, elastic, slope, k.w1)
    N, damping, velocity = radial / k.g.q, (radial - elastic) / k.g.q, vec(v, 0)
    speed, ahead = speed_over_ground(k.g.n, velocity)
    law = lateral_law(p, laws, vec(q, Y), vec(v, Y), k.rolled, N, speed, dot(k.g.n, k.omega))
    return Load(radial, F_w, F_w1, slope, N, damping, velocity, speed, ahead, law)


@kernel
def add_load(f, Rn, k, load, F):
    """Add the forces of a Load and of the friction F (3,) [N] in the ground. Returns G of tire_patch.py."""
    G = add_patch_force(f, Rn, k, F, load.N, load.damping)
    add_vec(f, 3, -load.law.turn, Rn.T @ k.g.n)
    add_vec(f, Y, 1.0, load.law.f)
    return G


@kernel
def changes(p, k, load, G, Rn, y1):
    """Three Changes by x, inertial theta and (y, psi, bow), three by their rates; ``y1`` = dy/dt."""
    n, law, none = k.g.n, load.law, (NO_MATRIX, ZERO)
    X, T, S = by_positions(p, k, y1)
    turned = skew(cross(k.rho, G) - law.turn * n)
    places = (
        _of_place(k, load, X, ZERO, none, NO_MATRIX, EYE),
        _of_place(k, load, T, cross(k.omega, n), none, turned, Rn),
        _of_place(k, load, S, ZERO, (law.f_q, law.turn_q), NO_MATRIX, EYE),
    )
    V, W, S1 = by_velocities(k)
    motions = (
        Change(V, load.ahead, ZERO, none, NO_MATRIX, EYE),
        Change(W, ZERO, n, none, NO_MATRIX, Rn),
        Change(S1, ZERO, ZERO, (law.f_v, law.turn_v), NO_MATRIX, EYE),
    )
    return places, motions


@kernel
def _of_place(k, load, d, swing, by_law, moment, frame):
    speed = -dot(k.g.n, load.v) * (d.n.T @ load.ahead)
    return Change(d, speed, d.n.T @ k.omega + swing, by_law, moment, frame)


@kernel
def normal_change(k, load, d):
    """Derivatives (3,) of N by the three variables of the Variation ``d``."""
    return _normal(k, load.N, load.F_w, load.F_w1, d)


@kernel
def _normal(k, N, F_w, F_w1, d):
    """Derivatives (3,) of N = F/q where F has the derivatives F_w and F_w1."""
    radial = F_w * d.w + F_w1 * d.w1
    return radial / k.g.q + N * k.g.s / k.g.q**2 * d.s


@kernel
def add_load_tangent(A, j, Rn, k, load, F, G, dF, dN, c):
    """Add the derivatives of ``add_load`` by the variables of the Change ``c``, to the columns of A from j on.

    ``dF`` 3x3 are those of F, ``dN`` (3,) those of N.
    """
    rows, turn = law_rows(load.law, c.by_law, dN, c.speed, c.turning, c.d.rolled)
    aligned = outer(-k.g.n, turn) - load.law.turn * c.d.n
    damped, moment = _normal(k, load.damping, load.F_w - load.slope, load.F_w1, c.d), c.moment + aligned
    add_patch_tangent(A, j, Rn, c.frame, k, F, load.N, load.damping, G, dF, dN, damped, c.d, moment)
    add_mat(A, Y, j, 1.0, rows @ c.frame)

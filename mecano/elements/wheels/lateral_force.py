"""Forces of the lateral law of a tyre (lateral_law.py) on (y, psi, bow) of its patch."""

from typing import NamedTuple

from mecano.constraints.tire_patch import Y
from mecano.elements.wheels.string_law import NO_PACE, OF_STRING, pace
from mecano.jit.kernel import kernel
from mecano.laws.friction import sticking
from mecano.laws.table import curve
from mecano.maths.vector import Vec3, add_vec, dot, mat, vec

ABOUT_N = Vec3(0.0, 1.0, 0.0)
LEAST_FORWARD = 0.1  # [m/s] speed of the axle from which on psi has turned over


class Lateral(NamedTuple):
    """Forces of a lateral law."""

    f: tuple  # F [N], M [N m], X [N]
    turn: float  # aligning moment [N m]
    damped: float  # power that its damping dissipates [W]
    way: float  # 1 forward, -1 in reverse


@kernel
def lateral_law(p, laws, q, v, rolled, N, u, forward, turning):
    """Return the Lateral for (y, psi, bow) = ``q``, their rates ``v``, normal force [N], speed u [m/s], turning rate.

    ``rolled`` [m/s] is dy/dt of a patch without lateral slip: it replaces dy/dt in the law of a string, whose contact
    line is laid down by rolling. In reverse, where ``forward`` [m/s] is negative, other laws turn psi over.
    """
    k = curve(laws, p.stiffness_by_load, N) * curve(laws, p.stiffness_by_speed, u)
    d = curve(laws, p.damping_by_load, N) * curve(laws, p.damping_by_speed, u)
    if p.pace != NO_PACE:  # its rates are those of rolling, no damping
        d = k
    g0, g1 = pace(p, u)
    b, lays = p.aligning, 1.0 if p.pace == OF_STRING else 0.0
    rates = Vec3(v[0] + lays * (rolled - v[0]), v[1], v[2])
    still, moved = mat(p.A0) @ q, mat(p.A1) @ rates + turning * vec(p.turning, 0)
    change = p.reverses * (forward * sticking(LEAST_FORWARD, abs(forward)) - 1.0)  # 0 forward, -2 in reverse
    still = still + change * p.A0[1, 0] * q[0] * ABOUT_N
    moved = moved + change * p.A1[1, 0] * rates[0] * ABOUT_N
    damped = d * dot(v, mat(p.damped) @ v)
    way = 1.0 + change
    own = way * (b[0] * q[0] + b[2] * v[0]) + b[1] * q[1] + b[3] * v[1]
    f, trailing = _paced(k, g0, still) + _paced(d, g1, moved), way * k * dot(vec(p.moment, 0), q)
    return Lateral(f, own + trailing, damped, way)


@kernel
def _paced(k, g, a):
    """Return k diag(1, g, g) a."""
    return Vec3(k * a[0], k * g * a[1], k * g * a[2])


@kernel
def relax(p, at, f):
    """Add F = M = X = 0, which hold in the air, to the equations of y, psi and bow."""
    add_vec(f, Y, 1.0, mat(p.A0) @ vec(at.q, Y) + mat(p.A1_air) @ vec(at.v, Y))

"""The motion between two accepted steps, to the order of the integrator."""

import numpy as np

from mecano.maths.so3 import exp, log, tangent, tangent_inverse
from mecano.maths.vec import mat, matmul, mul, transpose
from mecano.model.numbering import ROTATION


def interpolate(s0, s1, t, of):
    """State at t in [s0.t, s1.t]: cubic Hermite for positions and rotations, linear for accelerations and multipliers.

    Positions are exact to O(h^4), velocities to O(h^3), the rest to O(h^2) of the accepted states. The modes are
    those of the step, i.e. of ``s0``.
    """
    h = s1.t - s0.t
    u = (t - s0.t) / h
    out = s1.copy()
    out.t, out.modes, out.memories = t, s0.modes, s0.memories
    out.a = (1 - u) * s0.a + u * s1.a
    out.z = (1 - u) * s0.z + u * s1.z
    free = np.arange(of.n_all) < of.n_q
    moving = free & (of.kind != ROTATION)
    out.z[moving], out.v[moving] = hermite(u, h, s0.z[moving], s1.z[moving], s0.v[moving], s1.v[moving])
    for r, d in enumerate(of.rotation_dof):
        if d < of.n_q:
            R0 = mat(s0.R[r])
            psi = log(matmul(transpose(R0), mat(s1.R[r])))
            rate1 = mul(tangent_inverse(psi), tuple(s1.v[d : d + 3]))
            value, rate = hermite(u, h, np.zeros(3), np.array(psi), s0.v[d : d + 3], np.array(rate1))
            out.R[r] = matmul(R0, exp(tuple(value)))
            out.v[d : d + 3] = mul(tangent(tuple(value)), tuple(rate))
    out.z[free & (of.kind == ROTATION)] = 0.0
    out.T[:] = np.eye(3)
    return out


def hermite(u, h, x0, x1, v0, v1):
    """Cubic Hermite value and rate at the fraction u of an interval of length h."""
    d = x1 - x0
    c2, c3 = 3 * d - h * (2 * v0 + v1), h * (v0 + v1) - 2 * d
    return x0 + u * (h * v0 + u * (c2 + u * c3)), v0 + (2 * u * c2 + 3 * u * u * c3) / h

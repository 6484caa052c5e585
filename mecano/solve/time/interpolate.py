"""The motion between two accepted steps, to the order of the integrator."""

from mecano.jit.entry import entry
from mecano.jit.kernel import kernel
from mecano.maths.hermite import hermite, quintic
from mecano.maths.so3 import exp, log, tangent, tangent_inverse, tangent_rate
from mecano.maths.vector import Vec3, mat, put, put_matrix, vec
from mecano.model.numbering import ROTATION, Numbering, Unknowns
from mecano.model.state import Motion, State


@entry
def between_states(u: float, h: float, of: Unknowns, s0: Motion, s1: Motion, s_out: Motion):
    """Interpolate the motion at the fraction u of a step of size h by polynomials of degree 3."""
    for i in range(s0.z.shape[0]):
        s_out.a[i] = (1.0 - u) * s0.a[i] + u * s1.a[i]
        s_out.z[i] = (1.0 - u) * s0.z[i] + u * s1.z[i]
        if i < of.n_q and of.kind[i] != ROTATION:
            s_out.z[i], s_out.v[i] = hermite(u, h, s0.z[i], s1.z[i], s0.v[i], s1.v[i])
    for r in range(of.rotation_dof.shape[0]):
        d = of.rotation_dof[r]
        if d < of.n_q:
            start = mat(s0.R[r])
            psi = log(start.T @ mat(s1.R[r]))
            last = tangent_inverse(psi) @ vec(s1.v, d)
            p0, r0 = hermite(u, h, 0.0, psi[0], s0.v[d], last[0])
            p1, r1 = hermite(u, h, 0.0, psi[1], s0.v[d + 1], last[1])
            p2, r2 = hermite(u, h, 0.0, psi[2], s0.v[d + 2], last[2])
            between = Vec3(p0, p1, p2)
            put_matrix(s_out.R[r], start @ exp(between))
            put(s_out.v, d, tangent(between) @ Vec3(r0, r1, r2))
            put(s_out.z, d, (0.0, 0.0, 0.0))


@kernel
def between_smooth_states(u, h, of, s0, s1, s_out):
    """Interpolate the motion at the fraction u of a step of size h by polynomials of degree 5.

    Positions are accurate to O(h^6), velocities to O(h^5), where accelerations are as exact as positions.
    """
    for i in range(s0.z.shape[0]):
        s_out.a[i] = (1.0 - u) * s0.a[i] + u * s1.a[i]
        s_out.z[i] = (1.0 - u) * s0.z[i] + u * s1.z[i]
        if i < of.n_q and of.kind[i] != ROTATION:
            s_out.z[i], s_out.v[i] = quintic(u, h, s0.z[i], s1.z[i], s0.v[i], s1.v[i], s0.a[i], s1.a[i])
    for r in range(of.rotation_dof.shape[0]):
        d = of.rotation_dof[r]
        if d < of.n_q:
            start = mat(s0.R[r])
            psi = log(start.T @ mat(s1.R[r]))
            back = tangent_inverse(psi)
            rate = back @ vec(s1.v, d)
            bend = back @ (vec(s1.a, d) - tangent_rate(psi, rate))  # at the beginning the two are those of the state
            p0, r0 = quintic(u, h, 0.0, psi[0], s0.v[d], rate[0], s0.a[d], bend[0])
            p1, r1 = quintic(u, h, 0.0, psi[1], s0.v[d + 1], rate[1], s0.a[d + 1], bend[1])
            p2, r2 = quintic(u, h, 0.0, psi[2], s0.v[d + 2], rate[2], s0.a[d + 2], bend[2])
            between = Vec3(p0, p1, p2)
            put_matrix(s_out.R[r], start @ exp(between))
            put(s_out.v, d, tangent(between) @ Vec3(r0, r1, r2))
            put(s_out.z, d, (0.0, 0.0, 0.0))


def interpolate(s0: State, s1: State, t: float, of: Numbering) -> State:
    """Return the State at t in [s0.t, s1.t] by cubic Hermite interpolation of positions and rotations.

    They are accurate to O(h^4) between accepted states, velocities to O(h^3). Accelerations and multipliers are
    interpolated linearly, O(h^2). Phases and memory are those of ``s0``.
    """
    out = s1.copy()
    out.t, out.phases, out.memory = t, s0.phases, s0.memory
    u, h = (t - s0.t) / (s1.t - s0.t), s1.t - s0.t
    between_states(u, h, of, s0, s1, out)
    return out

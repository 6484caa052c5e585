"""The motion between two accepted steps, to the order of the integrator."""

from mecano.jit.entry import Indices, Matrices, Vector, entry
from mecano.maths.hermite import hermite, quintic
from mecano.maths.so3 import exp, log, tangent, tangent_inverse, tangent_rate
from mecano.maths.vector import Vec3, mat, put, vec
from mecano.model.numbering import ROTATION
from mecano.solve.time.increments import put_matrix


@entry
def between_states(
    # place in the step
    u: float, h: float,
    # state at both ends
    z0: Vector, v0: Vector, a0: Vector, R0: Matrices, z1: Vector, v1: Vector, a1: Vector, R1: Matrices,
    # model
    kind: Indices, rotation_dof: Indices, n_q: int,
    # out
    z_out: Vector, v_out: Vector, a_out: Vector, R_out: Matrices,
):  # fmt: skip
    """Interpolate the motion at the fraction u of a step of size h by polynomials of degree 3."""
    for i in range(z0.shape[0]):
        a_out[i] = (1.0 - u) * a0[i] + u * a1[i]
        z_out[i] = (1.0 - u) * z0[i] + u * z1[i]
        if i < n_q and kind[i] != ROTATION:
            z_out[i], v_out[i] = hermite(u, h, z0[i], z1[i], v0[i], v1[i])
    for r in range(rotation_dof.shape[0]):
        d = rotation_dof[r]
        if d < n_q:
            start = mat(R0[r])
            psi = log(start.T @ mat(R1[r]))
            last = tangent_inverse(psi) @ vec(v1, d)
            p0, r0 = hermite(u, h, 0.0, psi[0], v0[d], last[0])
            p1, r1 = hermite(u, h, 0.0, psi[1], v0[d + 1], last[1])
            p2, r2 = hermite(u, h, 0.0, psi[2], v0[d + 2], last[2])
            between = Vec3(p0, p1, p2)
            put_matrix(start @ exp(between), R_out[r])
            put(v_out, d, tangent(between) @ Vec3(r0, r1, r2))
            put(z_out, d, (0.0, 0.0, 0.0))


@entry
def between_smooth_states(
    # place in the step
    u: float, h: float,
    # state at both ends
    z0: Vector, v0: Vector, a0: Vector, R0: Matrices, z1: Vector, v1: Vector, a1: Vector, R1: Matrices,
    # model
    kind: Indices, rotation_dof: Indices, n_q: int,
    # out
    z_out: Vector, v_out: Vector, a_out: Vector, R_out: Matrices,
):  # fmt: skip
    """Interpolate the motion at the fraction u of a step of size h by polynomials of degree 5."""
    for i in range(z0.shape[0]):
        a_out[i] = (1.0 - u) * a0[i] + u * a1[i]
        z_out[i] = (1.0 - u) * z0[i] + u * z1[i]
        if i < n_q and kind[i] != ROTATION:
            z_out[i], v_out[i] = quintic(u, h, z0[i], z1[i], v0[i], v1[i], a0[i], a1[i])
    for r in range(rotation_dof.shape[0]):
        d = rotation_dof[r]
        if d < n_q:
            start = mat(R0[r])
            psi = log(start.T @ mat(R1[r]))
            back = tangent_inverse(psi)
            rate = back @ vec(v1, d)
            bend = back @ (vec(a1, d) - tangent_rate(psi, rate))  # at the beginning the two are those of the state
            p0, r0 = quintic(u, h, 0.0, psi[0], v0[d], rate[0], a0[d], bend[0])
            p1, r1 = quintic(u, h, 0.0, psi[1], v0[d + 1], rate[1], a0[d + 1], bend[1])
            p2, r2 = quintic(u, h, 0.0, psi[2], v0[d + 2], rate[2], a0[d + 2], bend[2])
            between = Vec3(p0, p1, p2)
            put_matrix(start @ exp(between), R_out[r])
            put(v_out, d, tangent(between) @ Vec3(r0, r1, r2))
            put(z_out, d, (0.0, 0.0, 0.0))


def interpolate(s0, s1, t, of, between=between_states):
    """Return the State at t in [s0.t, s1.t], by ``between_states`` or ``between_smooth_states``.

    The first is the cubic Hermite interpolation of positions and rotations, accurate to O(h^4) between accepted states,
    their velocities to O(h^3). The second is the quintic one, O(h^6) and O(h^5) where accelerations are as exact as
    positions. Accelerations and multipliers are interpolated linearly, O(h^2). Phases and memory are those of ``s0``.
    """
    out = s1.copy()
    out.t, out.phases, out.memory = t, s0.phases, s0.memory
    u, h = (t - s0.t) / (s1.t - s0.t), s1.t - s0.t
    between(
        u, h, s0.z, s0.v, s0.a, s0.R, s1.z, s1.v, s1.a, s1.R, of.kind, of.rotation_dof, of.n_q,
        out.z, out.v, out.a, out.R,
    )  # fmt: skip
    return out

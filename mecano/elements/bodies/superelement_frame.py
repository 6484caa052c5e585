r"""The frame that follows the boundary nodes of a superelement, and the motion relative to it; on tuples and arrays.

With the positions :math:`X_i` of the boundary nodes about their mean, in the axes of the superelement, the rotations
:math:`A_i` of these axes fixed in the nodes, and a length L, the frame is the rotation nearest to the motion of all:

.. math::  R = \mathrm{polar}\, \frac1n \sum_i \left[ (x_i - \bar x) X_i^T + L^2 A_i \right] , \qquad
    y_i = R^T (x_i - \bar x), \quad E_i = R^T A_i

Its material variation is linear in :math:`r_i = R^T \delta x_i` and the material variations :math:`\phi_i` of
:math:`A_i`, with :math:`H = \frac1n \sum_i (y_i X_i^T + L^2 E_i)`, which is symmetric,

.. math::  D\, \delta\Theta = \frac1n \sum_i \left[ X_i \times r_i + L^2 (\mathrm{tr} E_i - E_i^T) \phi_i \right] ,
    \qquad D = \mathrm{tr} H - H

so the same expression gives its angular velocity. The frame rotates with the nodes for any motion, independent of the
path. Elastic coordinates are :math:`d_i = y_i - X_i`, :math:`\theta_i = \log E_i` and the amplitudes of the modes.
"""

from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.maths.polar import inverse, nearest_rotation
from mecano.maths.rotation_vector import inverse_coefficients, inverse_tangent
from mecano.maths.so3 import log
from mecano.maths.vector import EYE, Mat3, Vec3, cross, dot, mat, outer, put, put_matrix, vec

# Rows of the work array (ROWS, n): elastic coordinates, their rates; velocities and accelerations in the axes of the
# frame, the rates of these velocities; forces on the coordinates, momenta, inertia forces; second rates of the
# coordinates.
ROWS = 9
U, U_RATE, V, A, V_RATE, FORCE, MOMENTUM, INERTIA, U_SECOND = range(ROWS)


@kernel
def trace_minus_transpose(E):
    """Return tr E - E^T, the moment of a rotating node about the frame."""
    t = E[0][0] + E[1][1] + E[2][2]
    return Mat3(
        Vec3(t - E[0][0], -E[1][0], -E[2][0]),
        Vec3(-E[0][1], t - E[1][1], -E[2][1]),
        Vec3(-E[0][2], -E[1][2], t - E[2][2]),
    )


@kernel
def place(p, laws, i):
    """Return X_i, (3,)."""
    return vec(laws, p.table + 12 * i)


@kernel
def axes(p, laws, i):
    """Return the rotation from the axes of the superelement to the initial axes of node i: A_i = R_i axes."""
    j = p.table + 12 * i + 3
    return Mat3(vec(laws, j), vec(laws, j + 3), vec(laws, j + 6))


@kernel
def mean(q, n):
    """Return the mean of the translations of n nodes in local unknowns."""
    total = vec(q, 0)
    for i in range(1, n):
        total = total + vec(q, 6 * i)
    return total / n


@kernel
def frame(p, laws, q, R):
    """Return the rotation of the frame and the mean of the boundary nodes."""
    n = p.n_nodes
    centre, B = mean(q, n), 0.0 * mat(R[0])
    for i in range(n):
        A_i = mat(R[i]) @ axes(p, laws, i)
        B = B + (outer(vec(q, 6 * i) - centre, place(p, laws, i)) + p.square * A_i)
    return nearest_rotation(B / n), centre


@kernel
def configuration(p, laws, q, R, work, turns):
    """Return frame, mean, D^-1; write elastic coordinates to ``work`` (ROWS, n), E_i and T^-1(theta_i) to ``turns``."""
    n = p.n_nodes
    R_f, centre = frame(p, laws, q, R)
    H = 0.0 * R_f
    for i in range(n):
        y, X = R_f.T @ (vec(q, 6 * i) - centre), place(p, laws, i)
        E = R_f.T @ (mat(R[i]) @ axes(p, laws, i))
        theta = log(E)
        c, _, _ = inverse_coefficients(dot(theta, theta))
        put(work[U], 6 * i, y - X)
        put(work[U], 6 * i + 3, theta)
        put_matrix(turns[i, 0], E)
        put_matrix(turns[i, 1], inverse_tangent(theta, c))
        H = H + (outer(y, X) + p.square * E)
    for j in range(6 * n, work.shape[1]):
        work[U, j] = number(q[j])
    return R_f, centre, inverse(trace_minus(H / n))


@kernel
def trace_minus(H):
    """Return D = tr H - H."""
    return (H[0][0] + H[1][1] + H[2][2]) * EYE - H


@kernel
def axes_spin(p, laws, v, i):
    """Return the material angular velocity of A_i from that of node i in local unknowns."""
    return axes(p, laws, i).T @ vec(v, 6 * i + 3)


@kernel
def frame_spin(p, laws, v, R_f, D_inverse, turns):
    """Return the angular velocity of the frame in its own axes, for the velocities ``v``."""
    total = 0.0 * vec(v, 0)
    for i in range(p.n_nodes):
        r, phi = R_f.T @ vec(v, 6 * i), axes_spin(p, laws, v, i)
        total = total + (cross(place(p, laws, i), r) + p.square * (trace_minus_transpose(mat(turns[i, 0])) @ phi))
    return D_inverse @ total / p.n_nodes


@kernel
def put_in_frame(p, laws, v, R_f, turns, out):
    """Write velocities or accelerations of the nodes in the axes of the frame to ``out`` (n,)."""
    for i in range(p.n_nodes):
        put(out, 6 * i, R_f.T @ vec(v, 6 * i))
        put(out, 6 * i + 3, mat(turns[i, 0]) @ axes_spin(p, laws, v, i))
    for j in range(6 * p.n_nodes, out.shape[0]):
        out[j] = number(v[j])


@kernel
def put_rates(p, laws, v, a, R_f, spin, work, turns):
    """Write velocities, accelerations, rates of the velocities and of the elastic coordinates to ``work``."""
    n = p.n_nodes
    put_in_frame(p, laws, v, R_f, turns, work[V])
    put_in_frame(p, laws, a, R_f, turns, work[A])
    centre = mean(work[V], n)
    for j in range(6 * n, work.shape[1]):
        work[U_RATE, j] = number(v[j])
        work[V_RATE, j] = number(a[j])
    for i in range(2 * n):
        put(work[V_RATE], 3 * i, vec(work[A], 3 * i) - cross(spin, vec(work[V], 3 * i)))
    for i in range(n):
        y = place(p, laws, i) + vec(work[U], 6 * i)
        put(work[U_RATE], 6 * i, vec(work[V], 6 * i) - centre + cross(y, spin))
        relative = axes_spin(p, laws, v, i) - mat(turns[i, 0]).T @ spin
        put(work[U_RATE], 6 * i + 3, mat(turns[i, 1]) @ relative)

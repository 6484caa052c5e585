r"""Motion of the centre of mass of a superelement, in the axes of the frame.

The centre of mass is :math:`\bar x + R s` with :math:`m s = S_0 + B^T u`. With the relative spins :math:`\xi_i =
\phi_i - E_i^T \Omega` of the nodes and :math:`d_i = y_i - X_i`, its velocity c and acceleration :math:`\alpha` are

.. math::
    c = \bar v + \Omega \times s + \dot s , \qquad
    \alpha = \bar a + \dot\Omega \times s + \Omega \times (\Omega \times s) + 2\, \Omega \times \dot s + \ddot s

    D \dot\Omega = \frac1n \sum_i \left[ X_i \times \dot r_i + L^2 (\mathrm{tr} \dot E_i - \dot E_i^T) \phi_i
    + L^2 (\mathrm{tr} E_i - E_i^T) \dot\phi_i \right] - \dot D \Omega , \qquad \dot E_i = E_i \hat\xi_i

    \ddot d_i = \dot r_i - \bar{\dot r} + \dot d_i \times \Omega + y_i \times \dot\Omega , \qquad
    \ddot\theta_i = T_i^{-1} \dot\xi_i + \dot T_i^{-1} \xi_i , \qquad
    \dot\xi_i = \dot\phi_i + \xi_i \times E_i^T \Omega - E_i^T \dot\Omega
"""

from typing import NamedTuple

from mecano.elements.bodies.superelement_frame import (
    U_RATE,
    U_SECOND,
    V_RATE,
    A,
    U,
    V,
    mean,
    place,
    trace_minus,
    trace_minus_transpose,
)  # fmt: skip
from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.maths.rotation_vector import inverse_coefficients, inverse_tangent_rate
from mecano.maths.vector import cross, cross_columns, dot, mat, outer, put, vec


class Centre(NamedTuple):
    """Motion of the centre of mass, in the axes of the frame."""

    velocity: tuple  # c [m/s]
    acceleration: tuple  # alpha [m/s2]


@kernel
def first_moment(p, laws, u):
    """Return B^T u, (3,)."""
    start = p.table + 12 * p.n_nodes
    total = number(u[0]) * vec(laws, start)
    for i in range(1, u.shape[0]):
        total = total + number(u[i]) * vec(laws, start + 3 * i)
    return total


@kernel
def relative_spin(spin, work, E, i):
    """Return xi_i, in the axes A_i."""
    return E.T @ (vec(work[V], 6 * i + 3) - spin)


@kernel
def centre_of(p, laws, spin, moment, D_inverse, work, turns):
    """Return the Centre, with ``moment`` = m s; write the row U_SECOND of ``work``."""
    H, total = 0.0 * D_inverse, 0.0 * spin
    for i in range(p.n_nodes):
        E, X = mat(turns[i, 0]), place(p, laws, i)
        E_rate = cross_columns(E, relative_spin(spin, work, E, i))
        H = H + (outer(vec(work[U_RATE], 6 * i), X) + p.square * E_rate)
        turned = trace_minus_transpose(E_rate) @ (E.T @ vec(work[V], 6 * i + 3))
        turned = turned + trace_minus_transpose(E) @ (E.T @ vec(work[A], 6 * i + 3))
        total = total + (cross(X, vec(work[V_RATE], 6 * i)) + p.square * turned)
    D_rate = trace_minus(H / p.n_nodes)
    spin_rate = D_inverse @ (total / p.n_nodes - D_rate @ spin)
    _put_second_rates(p, laws, spin, spin_rate, work, turns)
    s2 = first_moment(p, laws, work[U_SECOND]) / p.mass
    s, s1, c = relative_motion(p, laws, spin, moment, work)
    acceleration = mean(work[A], p.n_nodes) + (cross(spin_rate, s) + cross(spin, c + s1) + s2)
    return Centre(mean(work[V], p.n_nodes) + c, acceleration)


@kernel
def relative_motion(p, laws, spin, moment, work):
    """Return s, its rate in the axes of the frame, and c - mean v."""
    s, s1 = moment / p.mass, first_moment(p, laws, work[U_RATE]) / p.mass
    return s, s1, cross(spin, s) + s1


@kernel
def _put_second_rates(p, laws, spin, spin_rate, work, turns):
    """Write the second rates of the coordinates."""
    centre = mean(work[V_RATE], p.n_nodes)
    for i in range(p.n_nodes):
        E, y = mat(turns[i, 0]), place(p, laws, i) + vec(work[U], 6 * i)
        turned = cross(vec(work[U_RATE], 6 * i), spin) + cross(y, spin_rate)
        put(work[U_SECOND], 6 * i, vec(work[V_RATE], 6 * i) - centre + turned)
        xi, theta, rate = relative_spin(spin, work, E, i), vec(work[U], 6 * i + 3), vec(work[U_RATE], 6 * i + 3)
        xi_rate = E.T @ (vec(work[A], 6 * i + 3) - spin_rate) + cross(xi, E.T @ spin)
        c, c1, _ = inverse_coefficients(dot(theta, theta))
        second = mat(turns[i, 1]) @ xi_rate + inverse_tangent_rate(theta, rate, c, c1) @ xi
        put(work[U_SECOND], 6 * i + 3, second)
    for j in range(6 * p.n_nodes, work.shape[1]):
        work[U_SECOND, j] = number(work[V_RATE, j])

r"""Motion of the centre of mass of a superelement, and its variation, in the axes of the frame.

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
    DU,
    DU_RATE,
    DU_SECOND,
    DV,
    DV_RATE,
    ROWS,
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
from mecano.maths.rotation_vector import (
    first_derivative,
    inverse_coefficients,
    inverse_tangent_rate,
    second_derivative,
)  # fmt: skip
from mecano.maths.vector import NO_MATRIX, ZERO, cross, cross_columns, dot, mat, outer, put, vec

PSI = ROWS  # row of the variations of the rotations of the nodes relative to the frame


class Centre(NamedTuple):
    """Motion of the centre of mass, and what it follows from, in the axes of the frame."""

    spin_rate: tuple  # rate of Omega [rad/s2]
    D_rate: tuple
    velocity: tuple  # c [m/s]
    acceleration: tuple  # alpha [m/s2]


@kernel
def first_moment(p, laws, u):
    """Return B^T u, (3,)."""
    total, start = ZERO, p.table + 12 * p.n_nodes
    for i in range(u.shape[0]):
        total = total + u[i] * vec(laws, start + 3 * i)
    return total


@kernel
def relative_spin(spin, work, E, i):
    """Return xi_i, in the axes A_i."""
    return E.T @ (vec(work[V], 6 * i + 3) - spin)


@kernel
def centre_of(p, laws, spin, moment, D_inverse, work, turns):
    """Return the Centre, with ``moment`` = m s; write the row U_SECOND of ``work``."""
    H, total = NO_MATRIX, ZERO
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
    s, s1 = moment / p.mass, first_moment(p, laws, work[U_RATE]) / p.mass
    s2 = first_moment(p, laws, work[U_SECOND]) / p.mass
    c = cross(spin, s) + s1
    acceleration = mean(work[A], p.n_nodes) + (cross(spin_rate, s) + cross(spin, c + s1) + s2)
    return Centre(spin_rate, D_rate, mean(work[V], p.n_nodes) + c, acceleration)


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
        work[U_SECOND, j] = work[V_RATE, j]


@kernel
def acceleration_by_amplitude(p, laws, s, order, column):
    """Return the change of alpha with an amplitude, its rate or its second rate (``order`` 0, 1, 2)."""
    share = vec(laws, p.table + 12 * p.n_nodes + 3 * column) / p.mass
    if order == 0:
        return cross(s.centre_of_mass.spin_rate, share) + cross(s.spin, cross(s.spin, share))
    return 2.0 * cross(s.spin, share) if order == 1 else share


@kernel
def acceleration_by_acceleration(p, laws, s):
    """Return the change of alpha with the accelerations of the nodes, of which DV_RATE are the changes."""
    work, n, total = s.work, p.n_nodes, ZERO
    for i in range(n):
        E, r, turned = mat(s.turns[i, 0]), vec(work[DV_RATE], 6 * i), vec(work[DV_RATE], 6 * i + 3)
        total = total + (cross(place(p, laws, i), r) + p.square * (trace_minus_transpose(E) @ (E.T @ turned)))
    spin_rate, centre = s.D_inverse @ total / n, mean(work[DV_RATE], n)
    for i in range(n):
        E, y = mat(s.turns[i, 0]), place(p, laws, i) + vec(work[U], 6 * i)
        put(work[DU_SECOND], 6 * i, vec(work[DV_RATE], 6 * i) - centre + cross(y, spin_rate))
        relative = E.T @ (vec(work[DV_RATE], 6 * i + 3) - spin_rate)
        put(work[DU_SECOND], 6 * i + 3, mat(s.turns[i, 1]) @ relative)
    return centre + (cross(spin_rate, s.moment) + first_moment(p, laws, work[DU_SECOND])) / p.mass


@kernel
def acceleration_by_motion(p, laws, s, change, moment_change):
    """Return the change of alpha with positions or velocities; ``moment_change`` is that of m s."""
    work, spin, about, n = s.work, s.spin, s.centre_of_mass, p.n_nodes
    spin_rate = _spin_rate_change(p, laws, s, change)
    _vary_second_rates(p, laws, s, change, spin_rate)
    at, at1 = s.moment / p.mass, first_moment(p, laws, work[U_RATE]) / p.mass
    ds, ds1 = moment_change / p.mass, first_moment(p, laws, work[DU_RATE]) / p.mass
    ds2 = first_moment(p, laws, work[DU_SECOND]) / p.mass
    dc = cross(change.spin, at) + cross(spin, ds) + 2.0 * ds1
    mean_change = mean(work[DV_RATE], n) + cross(change.spin, mean(work[V], n)) + cross(spin, mean(work[DV], n))
    turned = cross(spin_rate, at) + cross(about.spin_rate, ds) + cross(spin, dc)
    return mean_change + (turned + cross(change.spin, cross(spin, at) + 2.0 * at1) + ds2)


@kernel
def _own_change(s, change, i):
    """Return the changes of xi_i and phi_i, in the axes A_i."""
    work, E, psi = s.work, mat(s.turns[i, 0]), vec(s.work[PSI], 6 * i)
    phi = E.T @ vec(work[DV], 6 * i + 3) - cross(psi, E.T @ vec(work[V], 6 * i + 3))
    return phi - _turned_change(E, psi, s.spin, change.spin), phi


@kernel
def _turned_change(E, psi, w, w_change):
    """Return the change of E^T w."""
    return E.T @ w_change - cross(psi, E.T @ w)


@kernel
def _spin_rate_change(p, laws, s, change):
    """Return the change of the rate of Omega."""
    work, H, total = s.work, NO_MATRIX, ZERO
    for i in range(p.n_nodes):
        E, X, psi = mat(s.turns[i, 0]), place(p, laws, i), vec(work[PSI], 6 * i)
        xi = relative_spin(s.spin, work, E, i)
        dxi, dphi = _own_change(s, change, i)
        E_change = cross_columns(E, psi)
        E_rate, E_rate_change = cross_columns(E, xi), cross_columns(E_change, xi) + cross_columns(E, dxi)
        H = H + (outer(vec(work[DU_RATE], 6 * i), X) + p.square * E_rate_change)
        phi, phi_rate = E.T @ vec(work[V], 6 * i + 3), E.T @ vec(work[A], 6 * i + 3)
        turned = trace_minus_transpose(E_rate_change) @ phi + trace_minus_transpose(E_rate) @ dphi
        turned = turned + trace_minus_transpose(E_change) @ phi_rate
        total = total + (cross(X, vec(work[DV_RATE], 6 * i)) + p.square * turned)
    about = s.centre_of_mass
    held = trace_minus(H / p.n_nodes) @ s.spin + about.D_rate @ change.spin + change.D @ about.spin_rate
    return s.D_inverse @ (total / p.n_nodes - held)


@kernel
def _vary_second_rates(p, laws, s, change, spin_rate_change):
    """Write the changes of the second rates of the coordinates."""
    work, turns, spin, spin_rate = s.work, s.turns, s.spin, s.centre_of_mass.spin_rate
    centre = mean(work[DV_RATE], p.n_nodes)
    for i in range(p.n_nodes):
        E, psi, y = mat(turns[i, 0]), vec(work[PSI], 6 * i), place(p, laws, i) + vec(work[U], 6 * i)
        turned = cross(vec(work[DU_RATE], 6 * i), spin) + cross(vec(work[U_RATE], 6 * i), change.spin)
        turned = turned + (cross(vec(work[DU], 6 * i), spin_rate) + cross(y, spin_rate_change))
        put(work[DU_SECOND], 6 * i, vec(work[DV_RATE], 6 * i) - centre + turned)
        xi = relative_spin(spin, work, E, i)
        dxi, _ = _own_change(s, change, i)
        held = E.T @ spin
        xi_rate = E.T @ (vec(work[A], 6 * i + 3) - spin_rate) + cross(xi, held)
        dxi_rate = cross(dxi, held) + cross(xi, _turned_change(E, psi, spin, change.spin))
        dxi_rate = dxi_rate - _turned_change(E, psi, spin_rate, spin_rate_change)
        second = _second_rotation_change(work, mat(turns[i, 1]), i, (xi, xi_rate), (dxi, dxi_rate))
        put(work[DU_SECOND], 6 * i + 3, second)


@kernel
def _second_rotation_change(work, inverse, i, spins, changes):
    """Return the change of the second rate of theta_i from those of xi_i and its rate."""
    theta, rate = vec(work[U], 6 * i + 3), vec(work[U_RATE], 6 * i + 3)
    dtheta, drate = vec(work[DU], 6 * i + 3), vec(work[DU_RATE], 6 * i + 3)
    c, c1, c2 = inverse_coefficients(dot(theta, theta))
    slope = first_derivative(theta, spins[1], -0.5, c, c1) @ dtheta
    slope = slope + second_derivative(theta, rate, spins[0], c, c1, c2) @ dtheta
    slope = slope + inverse_tangent_rate(theta, drate, c, c1) @ spins[0]
    return slope + inverse @ changes[1] + inverse_tangent_rate(theta, rate, c, c1) @ changes[0]

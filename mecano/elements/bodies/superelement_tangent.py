r"""Exact tangents of the forces of a superelement, column by column: variation of all forces with one unknown.

A variation of the nodes varies the frame by rho, the rotations relative to it by :math:`\psi_i = \phi_i - E_i^T \rho`,
and with them all terms of superelement_force.py. Columns of amplitudes cost one row of a matrix each: with dual
numbers, half as many lines, the time integration of the deck superelement_arm takes 13 % more processor time, and that
of a superelement with 40 modes 2.4 times as much.
"""

from typing import NamedTuple

from mecano.elements.bodies.superelement_centre import (
    PSI,
    acceleration_by_acceleration,
    acceleration_by_amplitude,
    acceleration_by_motion,
    first_moment,
)  # fmt: skip
from mecano.elements.bodies.superelement_force import (
    inertia_moment,
    material_moment,
    mean_force,
    put_products,
)
from mecano.elements.bodies.superelement_frame import (
    DFORCE,
    DINERTIA,
    DMOMENTUM,
    DU,
    DU_RATE,
    DV,
    DV_RATE,
    FORCE,
    INERTIA,
    MOMENTUM,
    ROWS,
    A,
    U,
    V,
    axes,
    axes_spin,
    mean,
    place,
    trace_minus,
    trace_minus_transpose,
)  # fmt: skip
from mecano.jit.kernel import kernel
from mecano.maths.rotation_vector import first_derivative, inverse_coefficients
from mecano.maths.vector import NO_MATRIX, ZERO, add_vec, cross, cross_columns, dot, mat, outer, put, vec

COLUMN = PSI + 1
TANGENT_ROWS = ROWS + 2


class Change(NamedTuple):
    """Variations of the frame, in its axes."""

    rho: tuple  # of its rotation
    spin: tuple  # of Omega
    D: tuple


UNCHANGED = Change(ZERO, ZERO, NO_MATRIX)


@kernel
def add_tangents(p, laws, s, K, C, M):
    """Add K, C and M to those of the State ``s`` of the forces, with ``work`` (TANGENT_ROWS, n)."""
    work = s.work
    n, nodes = work.shape[1], 6 * p.n_nodes
    for column in range(n):
        for order in range(3):
            work[DU:] = 0.0
            if column >= nodes:
                change = UNCHANGED
                vary_amplitude(order, column, work)
                moment_change = first_moment(p, laws, work[DU])
                acceleration_change = acceleration_by_amplitude(p, laws, s, order, column)
            else:
                change = vary_node(p, laws, s, order, column)
                moment_change = first_moment(p, laws, work[DU])
                if order == 2:
                    acceleration_change = acceleration_by_acceleration(p, laws, s)
                else:
                    acceleration_change = acceleration_by_motion(p, laws, s, change, moment_change)
            put_column(p, laws, s, change, moment_change, acceleration_change)
            for i in range(n):
                if order == 0:
                    K[i, column] += work[COLUMN, i]
                elif order == 1:
                    C[i, column] += work[COLUMN, i]
                else:
                    M[i, column] += work[COLUMN, i]


@kernel
def vary_amplitude(order, column, work):
    """Write the variation of an amplitude, its rate or its second rate."""
    if order == 0:
        work[DU, column] = 1.0
    elif order == 1:
        work[DU_RATE, column] = 1.0
        work[DV, column] = 1.0
    else:
        work[DV_RATE, column] = 1.0


@kernel
def vary_node(p, laws, s, order, column):
    """Vary a node's position or rotation, velocity or acceleration; return the Change of the frame."""
    work, k = s.work, column // 6
    work[COLUMN, column] = 1.0
    r, phi = s.R.T @ vec(work[COLUMN], 6 * k), axes_spin(p, laws, work[COLUMN], k)
    work[COLUMN, column] = 0.0
    if order == 2:
        put(work[DV_RATE], 6 * k, r)
        put(work[DV_RATE], 6 * k + 3, mat(s.turns[k, 0]) @ phi)
        return UNCHANGED
    moving = cross(place(p, laws, k), r) + p.square * (trace_minus_transpose(mat(s.turns[k, 0])) @ phi)
    turn = s.D_inverse @ moving / p.n_nodes
    if order == 1:
        vary_velocity(p, laws, s, k, r, phi, turn)
        return Change(ZERO, turn, NO_MATRIX)
    D_change = vary_position(p, laws, s, k, r, phi, turn)
    spin_change = frame_spin_change(p, laws, s, D_change)
    vary_rates(p, laws, s, spin_change)
    return Change(turn, spin_change, D_change)


@kernel
def vary_velocity(p, laws, s, k, r, phi, spin_change):
    """Vary the velocities r and phi of node k."""
    work, turns = s.work, s.turns
    put(work[DV], 6 * k, r)
    put(work[DV], 6 * k + 3, mat(turns[k, 0]) @ phi)
    centre = r / p.n_nodes
    for i in range(p.n_nodes):
        y = place(p, laws, i) + vec(work[U], 6 * i)
        put(work[DU_RATE], 6 * i, vec(work[DV], 6 * i) - centre + cross(y, spin_change))
        relative = mat(turns[i, 0]).T @ (vec(work[DV], 6 * i + 3) - spin_change)
        put(work[DU_RATE], 6 * i + 3, mat(turns[i, 1]) @ relative)
    vary_velocity_rates(p, s, spin_change)


@kernel
def vary_velocity_rates(p, s, spin_change):
    """Subtract the variation of Omega x v from that of the rates of the velocities."""
    work = s.work
    for i in range(2 * p.n_nodes):
        turned = cross(spin_change, vec(work[V], 3 * i)) + cross(s.spin, vec(work[DV], 3 * i))
        add_vec(work[DV_RATE], 3 * i, -1.0, turned)


@kernel
def vary_position(p, laws, s, k, r, phi, rho):
    """Vary coordinates, velocities and accelerations with r and phi of node k; return the change of D."""
    work, turns = s.work, s.turns
    H, centre = NO_MATRIX, r / p.n_nodes
    for i in range(p.n_nodes):
        E, X = mat(turns[i, 0]), place(p, laws, i)
        own = -(E.T @ rho)
        y = cross(X + vec(work[U], 6 * i), rho) - centre
        if i == k:
            own, y = own + phi, y + r
        put(work[PSI], 6 * i, own)
        put(work[DU], 6 * i, y)
        put(work[DU], 6 * i + 3, mat(turns[i, 1]) @ own)
        H = H + (outer(y, X) + p.square * cross_columns(E, own))
        turned = E @ own
        put(work[DV], 6 * i, cross(vec(work[V], 6 * i), rho))
        put(work[DV], 6 * i + 3, cross(turned, vec(work[V], 6 * i + 3)))
        put(work[DV_RATE], 6 * i, cross(vec(work[A], 6 * i), rho))
        put(work[DV_RATE], 6 * i + 3, cross(turned, vec(work[A], 6 * i + 3)))
    return trace_minus(H / p.n_nodes)


@kernel
def frame_spin_change(p, laws, s, D_change):
    """Return the change of the angular velocity of the frame with the positions."""
    work, total = s.work, ZERO
    for i in range(p.n_nodes):
        E = mat(s.turns[i, 0])
        own = E.T @ vec(work[V], 6 * i + 3)
        turned = trace_minus_transpose(cross_columns(E, vec(work[PSI], 6 * i))) @ own
        total = total + (cross(place(p, laws, i), vec(work[DV], 6 * i)) + p.square * turned)
    return s.D_inverse @ (total / p.n_nodes - D_change @ s.spin)


@kernel
def vary_rates(p, laws, s, spin_change):
    """Write the changes of the rates of coordinates and velocities with the positions."""
    work, spin = s.work, s.spin
    vary_velocity_rates(p, s, spin_change)
    centre = mean(work[DV], p.n_nodes)
    for i in range(p.n_nodes):
        E, y = mat(s.turns[i, 0]), place(p, laws, i) + vec(work[U], 6 * i)
        turned = cross(vec(work[DU], 6 * i), spin) + cross(y, spin_change)
        put(work[DU_RATE], 6 * i, vec(work[DV], 6 * i) - centre + turned)
        theta = vec(work[U], 6 * i + 3)
        c, c1, _ = inverse_coefficients(dot(theta, theta))
        relative = E.T @ (vec(work[V], 6 * i + 3) - spin)
        change = cross(vec(work[PSI], 6 * i), E.T @ spin) - E.T @ spin_change
        slope = first_derivative(theta, relative, -0.5, c, c1) @ vec(work[DU], 6 * i + 3)
        put(work[DU_RATE], 6 * i + 3, slope + mat(s.turns[i, 1]) @ change)


@kernel
def put_column(p, laws, s, change, moment_change, acceleration_change):
    """Write the column: the change of all forces, from those of coordinates, velocities and their rates.

    ``moment_change``, ``acceleration_change``: of m s and of the acceleration of the centre of mass.
    """
    work, n = s.work, p.n_nodes
    load_change = cross(s.load + s.centre_of_mass.acceleration, change.rho) - acceleration_change
    put_products(p, laws, load_change, work, (DU, DU_RATE, DV, DV_RATE), DFORCE)
    total = cross(moment_change, s.load) + cross(s.moment, load_change)
    for i in range(n):
        total = total + frame_moment_change(p, laws, work, s.turns, i)
    nu_change = -(s.D_inverse @ (total + change.D @ s.nu))
    mean_change = mean_force(p, load_change, work[DFORCE])
    for i in range(n):
        z, dz = node_force_change(p, laws, s, change.spin, mean_change, nu_change, i)
        put(work[COLUMN], 6 * i, s.R @ (dz + cross(change.rho, z)))
        moment = node_moment_change(p, s, change.spin, nu_change, i)
        put(work[COLUMN], 6 * i + 3, axes(p, laws, i) @ moment)
    for j in range(6 * n, work.shape[1]):
        work[COLUMN, j] = work[DFORCE, j] + work[DINERTIA, j]


@kernel
def elastic_moment_change(work, turns, i):
    """Return the change of T_i^-T p_r."""
    theta = vec(work[U], 6 * i + 3)
    c, c1, _ = inverse_coefficients(dot(theta, theta))
    slope = first_derivative(theta, vec(work[FORCE], 6 * i + 3), 0.5, c, c1)
    return slope @ vec(work[DU], 6 * i + 3) + mat(turns[i, 1]).T @ vec(work[DFORCE], 6 * i + 3)


@kernel
def frame_moment_change(p, laws, work, turns, i):
    """Return the change of the contribution of node i to superelement_force.frame_moment, with the same sign."""
    y = place(p, laws, i) + vec(work[U], 6 * i)
    total = cross(vec(work[DU], 6 * i), vec(work[FORCE], 6 * i)) + cross(y, vec(work[DFORCE], 6 * i))
    own = cross(vec(work[PSI], 6 * i), material_moment(turns, work, i))
    total = total + mat(turns[i, 0]) @ (own + elastic_moment_change(work, turns, i))
    for j in (6 * i, 6 * i + 3):
        total = total + cross(vec(work[DMOMENTUM], j), vec(work[V], j))
        total = total + cross(vec(work[MOMENTUM], j), vec(work[DV], j))
    return total


@kernel
def node_force_change(p, laws, s, spin_change, mean_change, nu_change, i):
    """Return the force on node i in the axes of the frame, and its change."""
    work, X, share = s.work, place(p, laws, i), 1.0 / p.n_nodes
    P, dP = vec(work[MOMENTUM], 6 * i), vec(work[DMOMENTUM], 6 * i)
    inertia, change = vec(work[INERTIA], 6 * i), vec(work[DINERTIA], 6 * i)
    z = vec(work[FORCE], 6 * i) - s.mean + (inertia + cross(s.spin, P))
    dz = vec(work[DFORCE], 6 * i) - mean_change + (change + (cross(spin_change, P) + cross(s.spin, dP)))
    return z + share * cross(s.nu, X), dz + share * cross(nu_change, X)


@kernel
def node_moment_change(p, s, spin_change, nu_change, i):
    """Return the change of the moment on node i, in the axes A_i."""
    work, E, psi, j = s.work, mat(s.turns[i, 0]), vec(s.work[PSI], 6 * i), 6 * i + 3
    P, dP, w, dw = vec(work[MOMENTUM], j), vec(work[DMOMENTUM], j), vec(work[V], j), vec(work[DV], j)
    inertia = vec(work[DINERTIA], j) + (cross(spin_change - dw, P) + cross(s.spin - w, dP))
    turned = E.T @ inertia - cross(psi, E.T @ inertia_moment(s.spin, work, i))
    tails = trace_minus_transpose(cross_columns(E, psi)).T @ s.nu + trace_minus_transpose(E).T @ nu_change
    return elastic_moment_change(work, s.turns, i) + turned + p.square / p.n_nodes * tails

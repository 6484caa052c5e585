r"""Forces of a superelement: elastic, damping, weight and inertia, from the motion relative to its frame.

With the elastic coordinates u, the velocities :math:`v = (R^T \dot x_i, R^T \omega_i, \dot\eta)` of the boundary nodes
in the axes of the frame, and the centre of mass :math:`x_c = \bar x + R (S_0 + B^T u)/m`,

.. math::
    V = \tfrac12 u^T K u - m\, g \cdot x_c , \qquad
    T = \tfrac12 m |\dot x_c|^2 + \tfrac12 v^T \tilde M v , \qquad \tilde M = M - \tfrac1m B B^T

where B = M r for the three rigid translations r, and :math:`\hat S_0` follows from M and the rigid rotations. For a
uniform velocity :math:`\tilde M v` vanishes, so that it causes no forces. (M in place of both parts of T would bend a
part that turns, in proportion to the speed at which all of it moves: its momentum would not be the rate of anything.)
The inertia of the centre of mass acts like a weight in the field :math:`-\ddot x_c`. The forces are those of Lagrange's
equations for T and V, with no terms neglected: with :math:`\gamma = R^T (g - \ddot x_c)` (superelement_centre.py),
:math:`p = K u + C \dot u - B \gamma`, :math:`P = \tilde M v`, :math:`h = \tilde M \dot v` and the angular velocity
Omega of the frame

.. math::
    \mu  &= -\sum_i (y_i \times p_{x,i} + E_i T_i^{-T} p_{r,i}) - (S_0 + B^T u) \times \gamma
            - \sum_i (P_{x,i} \times v_i + P_{r,i} \times \omega_i) , \qquad \nu = D^{-1} \mu \\
    R^T f_{x,i} &= p_{x,i} - \tfrac1n \left( \textstyle\sum_j p_{x,j} + m \gamma \right) + h_{x,i}
            + \Omega \times P_{x,i} + \tfrac1n \nu \times X_i \\
    f_{\Theta,i} &= T_i^{-T} p_{r,i} + E_i^T (h_{r,i} + \Omega \times P_{r,i} + P_{r,i} \times \omega_i)
            + \tfrac{L^2}{n} (\mathrm{tr} E_i - E_i) \nu , \qquad f_\eta = p_\eta + h_\eta
"""

from typing import NamedTuple

import numpy as np

from mecano.elements.bodies.superelement_centre import centre_of, first_moment
from mecano.elements.bodies.superelement_frame import (
    FORCE,
    INERTIA,
    MOMENTUM,
    U_RATE,
    V_RATE,
    U,
    V,
    axes,
    configuration,
    frame_spin,
    place,
    put_rates,
    trace_minus_transpose,
)  # fmt: skip
from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.maths.vector import Vec3, add_vec, cross, mat, vec


class State(NamedTuple):
    """Motion of the frame, and the forces that follow from it, in its axes."""

    R: tuple  # rotation of the frame
    centre: tuple  # mean of the boundary nodes, inertial [m]
    spin: tuple  # Omega
    load: tuple  # gamma, of weight and of the inertia of the centre of mass
    moment: tuple  # S_0 + B^T u
    mean: tuple  # force on the mean of the nodes
    nu: tuple
    centre_of_mass: tuple  # its Centre
    work: np.ndarray  # rows of superelement_frame.py
    turns: np.ndarray  # (n_nodes, 2, 3, 3): E_i, T_i^-1


@kernel
def state_of(p, at, work, turns):
    """Return the State; write ``work`` up to the row INERTIA, and ``turns``."""
    R, centre, D_inverse = configuration(p, at.laws, at.q, at.R, work, turns)
    spin = frame_spin(p, at.laws, at.v, R, D_inverse, turns)
    put_rates(p, at.laws, at.v, at.a, R, spin, work, turns)
    moment = vec(p.moment, 0) + first_moment(p, at.laws, work[U])
    about = centre_of(p, at.laws, spin, moment, D_inverse, work, turns)
    load = R.T @ vec(p.gravity, 0) - about.acceleration
    put_products(p, at.laws, load, work)
    nu = D_inverse @ frame_moment(p, at.laws, load, moment, work, turns)
    return State(R, centre, spin, load, moment, mean_force(p, load, work[FORCE]), nu, about, work, turns)


@kernel
def add_product(laws, start, x, out):
    """Add A x to out, for the symmetric matrix A (n, n) at ``start`` of the table."""
    n, zero = x.shape[0], 0.0 * number(x[0])
    for i in range(0, n - 2, 3):
        total = Vec3(zero, zero, zero)
        for j in range(n):
            total = total + number(x[j]) * vec(laws, start + j * n + i)
        add_vec(out, i, 1.0, total)
    for i in range(n - n % 3, n):
        for j in range(n):
            out[i] += number(x[j]) * laws[start + i * n + j]


@kernel
def put_products(p, laws, load, work):
    """Write coordinate forces, momenta and inertia forces."""
    n = work.shape[1]
    loads = p.table + 12 * p.n_nodes
    stiffness = loads + 3 * n
    for i in range(n):
        b = vec(laws, loads + 3 * i)
        work[FORCE, i] = -(b[0] * load[0] + b[1] * load[1] + b[2] * load[2])
        work[MOMENTUM, i] = 0.0
        work[INERTIA, i] = 0.0
    add_product(laws, stiffness, work[U], work[FORCE])
    add_product(laws, stiffness + n * n, work[V], work[MOMENTUM])
    add_product(laws, stiffness + n * n, work[V_RATE], work[INERTIA])
    if p.damped > 0:
        add_product(laws, stiffness + 2 * n * n, work[U_RATE], work[FORCE])


@kernel
def material_moment(turns, work, i):
    """Return T_i^-T p_r, the moment of the elastic forces on node i in the axes A_i."""
    return mat(turns[i, 1]).T @ vec(work[FORCE], 6 * i + 3)


@kernel
def inertia_moment(spin, work, i):
    """Return the moment of the inertia forces on node i, in the axes of the frame."""
    momentum = vec(work[MOMENTUM], 6 * i + 3)
    turned = cross(spin - vec(work[V], 6 * i + 3), momentum)
    return vec(work[INERTIA], 6 * i + 3) + turned


@kernel
def frame_moment(p, laws, load, moment, work, turns):
    """Return the moment mu conjugate to rotations of the frame; ``moment`` is S_0 + B^T u."""
    total = cross(moment, load)
    for i in range(p.n_nodes):
        y = place(p, laws, i) + vec(work[U], 6 * i)
        total = total + cross(y, vec(work[FORCE], 6 * i))
        total = total + mat(turns[i, 0]) @ material_moment(turns, work, i)
        total = total + cross(vec(work[MOMENTUM], 6 * i), vec(work[V], 6 * i))
        total = total + cross(vec(work[MOMENTUM], 6 * i + 3), vec(work[V], 6 * i + 3))
    return -total


@kernel
def mean_force(p, load, force):
    """Return the part of the forces that acts on the mean of the nodes, (3,)."""
    total = p.mass * load
    for i in range(p.n_nodes):
        total = total + vec(force, 6 * i)
    return total / p.n_nodes


@kernel
def node_force(p, laws, s, i):
    """Return the force on node i in the axes of the frame."""
    turned = vec(s.work[INERTIA], 6 * i) + cross(s.spin, vec(s.work[MOMENTUM], 6 * i))
    own = vec(s.work[FORCE], 6 * i) - s.mean
    return own + turned + cross(s.nu, place(p, laws, i)) / p.n_nodes


@kernel
def node_moment(p, s, i):
    """Return the moment on node i in the axes A_i."""
    E = mat(s.turns[i, 0])
    own = material_moment(s.turns, s.work, i) + E.T @ inertia_moment(s.spin, s.work, i)
    return own + p.square / p.n_nodes * (trace_minus_transpose(E).T @ s.nu)


@kernel
def add_forces(p, laws, s, f):
    """Add all forces to ``f`` (n,)."""
    for i in range(p.n_nodes):
        add_vec(f, 6 * i, 1.0, s.R @ node_force(p, laws, s, i))
        add_vec(f, 6 * i + 3, 1.0, axes(p, laws, i) @ node_moment(p, s, i))
    for j in range(6 * p.n_nodes, f.shape[0]):
        f[j] += number(s.work[FORCE, j]) + number(s.work[INERTIA, j])

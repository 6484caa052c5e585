r"""Rigid body: mass and inertia at one node.

With x, R the node, c the centre of mass (node frame), :math:`J = J_C + m(c\cdot c\,I - c c^T)` the inertia about the
node and :math:`w = \alpha \times c + \Omega \times (\Omega \times c)`, all in the material frame:

.. math::  f_x = m (a + R w - g), \qquad f_\Theta = J \alpha + \Omega \times J \Omega + m\, c \times R^T (a - g)

``attached`` nodes move with the body as if welded to it: the position of each is held by three constraints. They share
the rotation of the body, except a node with an ``orientation`` of its own (a marker), which is held by three more.
"""

import numpy as np

from mecano.constraints.attachment import attached_rotations, attachment
from mecano.constraints.joint_samples import ORIENTATIONS
from mecano.element_interface import Display, Kind, Output, named, record
from mecano.jit.kernel import kernel
from mecano.maths.inertia import inertia_matrix
from mecano.maths.vector import EYE, add_mat, add_vec, cross, dot, mat, put, skew, vec
from mecano.schema import INERTIA, NODE, NODE_VECTOR, NODES, NUMBER, Field, positive

RECORD = record(mass=(), c=3, J=(3, 3), J_C=(3, 3), gravity=3)


# The tangents are written by hand: with dual numbers a chain of a hundred bodies takes as long, but the deck
# nose_gear_rigid 2 to 4 % longer, and a pendulum compiles 8 % longer.
@kernel
def force(p, at, f, K, C, M):
    """Add inertia and weight of one body; see element_interface for the arguments."""
    c, J, A = vec(p.c, 0), mat(p.J), mat(at.R[0])
    omega, alpha = vec(at.v, 3), vec(at.a, 3)
    u = vec(at.a, 0) - vec(p.gravity, 0)
    u_body = A.T @ u
    spin = cross(omega, c)
    w = cross(alpha, c) + cross(omega, spin)
    momentum = J @ omega

    add_vec(f, 0, p.mass, u + A @ w)
    add_vec(f, 3, 1.0, J @ alpha + cross(omega, momentum))
    add_vec(f, 3, p.mass, cross(c, u_body))

    hat_c, hat_omega = skew(c), skew(omega)
    add_mat(M, 0, 0, p.mass, EYE)
    add_mat(M, 0, 3, -p.mass, A @ hat_c)
    add_mat(M, 3, 0, p.mass, hat_c @ A.T)
    add_mat(M, 3, 3, 1.0, J)
    add_mat(C, 0, 3, -p.mass, A @ (skew(spin) + hat_omega @ hat_c))
    add_mat(C, 3, 3, 1.0, hat_omega @ J - skew(momentum))
    add_mat(K, 0, 3, -p.mass, A @ skew(w))
    add_mat(K, 3, 3, p.mass, hat_c @ skew(u_body))


@kernel
def observe(p, at, F, y, e):
    """Write centre of mass, its velocity, energies."""
    c, A, omega = vec(p.c, 0), mat(at.R[0]), vec(at.v, 3)
    x_C = vec(at.q, 0) + A @ c
    v_C = vec(at.v, 0) + A @ cross(omega, c)
    put(y, 0, x_C)
    put(y, 3, v_C)
    kinetic = 0.5 * p.mass * dot(v_C, v_C) + 0.5 * dot(omega, mat(p.J_C) @ omega)
    y[6] = kinetic
    e[0] = kinetic
    e[1] = -p.mass * dot(vec(p.gravity, 0), x_C)


def prepare(d, nodes, context):
    """Return the record of one body; J is the inertia about the node."""
    c, J_C = np.asarray(d["center_of_mass"], float), inertia_matrix(d["inertia"])
    J = J_C + d["mass"] * (c @ c * np.eye(3) - np.outer(c, c))
    return {"mass": d["mass"], "c": c, "J": J, "J_C": J_C, "gravity": context.gravity}


def check(d, nodes):
    """Check that the principal moments are positive and satisfy the triangle inequality."""
    J = inertia_matrix(d["inertia"])
    if not np.allclose(J, J.T, rtol=1e-9, atol=0):
        return ["'inertia' must be a symmetric matrix"]
    moments = np.linalg.eigvalsh(J)
    text = ", ".join(f"{moment:.6g}" for moment in moments)
    if moments[0] <= 0:
        return [f"'inertia' must be positive definite; its principal moments are {text} kg m2"]
    if moments[0] + moments[1] < moments[2] * (1 - 1e-9):
        return [
            f"'inertia' is impossible: of the principal moments {text} kg m2 the largest exceeds the sum of "
            "the two others (triangle inequality)"
        ]
    return []


def sample(rng):
    """Return random bodies with an offset centre of mass, without and with attached nodes."""
    A = rng.normal(size=(3, 3))
    masses = A @ A.T + np.eye(3)
    J = np.trace(masses) * np.eye(3) - masses
    d = {"mass": rng.uniform(1, 9), "center_of_mass": rng.normal(size=3), "inertia": J, "attached": []}
    nodes = [(rng.normal(size=3), R) for R in (*ORIENTATIONS, ORIENTATIONS[0])]
    return [(d, 1, ""), ({**d, "attached": ["marker", "lug"]}, nodes, "")]


RIGID_BODY = Kind(
    name="rigid_body", section="elements", doc=__doc__, display=Display("body", pictures=("bodies",)), dtype=RECORD,
    layout=("x0", "R0"),
    fields=(
        Field("node", NODE, "-", "node that carries the body"),
        Field("mass", NUMBER, "kg", "mass", check=positive),
        Field(
            "inertia", INERTIA, "kg m2",
            "inertia about the centre of mass, in the axes of the node; xy, of the tensor, is minus the sum of x y dm",
        ),
        Field("center_of_mass", NODE_VECTOR, "m", "centre of mass from the node, in the axes of the node", (0.0,) * 3),
        Field("attached", NODES, "-", "further nodes that move with the body, of any orientation", ()),
    ),  # fmt: skip
    outputs=(
        Output("center_of_mass", "m", "position of the centre of mass, inertial", (3,), rate="velocity"),
        Output("velocity", "m/s", "velocity of the centre of mass, inertial", (3,)),
        Output("kinetic_energy", "J", "kinetic energy"),
    ),
    shares=attached_rotations,
    parts=lambda d, nodes, context: [part for i in range(1, len(nodes)) for part in attachment(nodes, i, context)],
    **named(prepare, check, force, observe, sample),
)  # fmt: skip

"""Nodes that move together as one body at the start, but begin to deform or to move apart.

Members between them lack the forces of a steady motion, such as the centrifugal forces in the blades of a rotor.
"""

from typing import TYPE_CHECKING

import numpy as np

from mecano.solve.modal.linearize import RESTING

if TYPE_CHECKING:
    import scipy.sparse as sp

    from mecano.model.state import State
    from mecano.model.system import System

ALIKE = 1e-9  # of the largest velocity: difference of two velocities that is rounding
STRAINS = 1e-9  # of the stiffness: less change of the forces between nodes is rounding
BALANCED = 1e-6  # of the largest force: inertia forces below which nodes move on as one body


def unsteady_bodies(
    system: "System", s: "State", M: "sp.csr_matrix", K: "sp.csr_matrix", size: float
) -> list[tuple[list[int], bool]]:
    """Return (nodes, whether they turn) of bodies that move at ``s`` and begin to deform.

    Nodes belong to one body if they have the velocities of one rigid motion, at least two of them its angular velocity.
    It deforms if its accelerations are not those of a rigid body, and change forces between nodes. ``M``, ``K`` (n_q,
    n_q) are the mass and stiffness matrices, ``size`` the largest force on a node [N].
    """
    of, nodes = system.numbering, np.arange(len(system.nodes))  # those that are fixed may lie on the axis of a rotor
    x, v = (part[of.x[:, None] + np.arange(3)] for part in (s.z, s.v))
    omega = np.einsum("ijk,ik->ij", s.R[of.rotation], s.v[of.r[:, None] + np.arange(3)])
    found = []
    for w, u in _rigid_motions(x, v, omega):
        along = _alike(v, u + np.cross(w, x))
        turning = along & _alike(omega, w)
        a, whole = _deforming(system, s, nodes[along], nodes[turning], w)
        forces, change = np.abs(M @ a).max(initial=0.0), np.abs(K @ a).max(initial=0.0)
        least = STRAINS * np.abs(K.data).max(initial=0.0) * np.abs(a).max(initial=0.0)
        if forces > BALANCED * max(size, np.abs(M @ whole).max(initial=0.0)) and change > least:
            found.append((nodes[turning].tolist(), bool(np.any(np.abs(w) > RESTING))))
    return found


def _rigid_motions(x, v, omega):
    """Yield (angular velocity (3,), velocity (3,) of the origin) of the motions that two or more nodes share."""
    u = v - np.cross(omega, x)
    units = [ALIKE * np.abs(part).max(initial=0.0) or 1.0 for part in (omega, v)]
    rounded = np.round(np.hstack([omega / units[0], u / units[1]]))
    _, first, counts = np.unique(rounded, axis=0, return_index=True, return_counts=True)
    for i in first[counts > 1]:
        if max(np.abs(omega[i]).max(), np.abs(u[i]).max()) > RESTING:
            yield omega[i], u[i]


def _alike(a, b):
    """Return (n,) bool: rows of velocities a (n, 3) that are those of b, up to rounding."""
    return np.abs(a - b).max(axis=1, initial=0.0) <= ALIKE * max(np.abs(a).max(initial=0.0), RESTING)


def _deforming(system, s, along, turning, w):
    """Return the accelerations (n_q,) of nodes beyond those of the nearest rigid motion, and the whole ones.

    Nodes ``along`` have its velocities, those ``turning`` also its angular velocity ``w`` (3,).
    """
    of = system.numbering
    at = np.unique(of.x[along])[:, None] + np.arange(3)
    x, a = s.z[at], s.a[at] - np.cross(w, s.v[at])
    eye, by_turn = np.broadcast_to(np.eye(3), (len(x), 3, 3)), np.cross(np.eye(3), x[:, None, :]).transpose(0, 2, 1)
    rotations, first = np.unique(of.r[turning], return_index=True)
    rotations = rotations[:, None] + np.arange(3)
    R = s.R[of.rotation[turning[first]]].transpose(0, 2, 1)
    A = np.concatenate([np.concatenate([eye, by_turn], axis=2), np.concatenate([np.zeros_like(R), R], axis=2)])
    where, b = np.concatenate([at, rotations]).ravel(), np.concatenate([a, s.a[rotations]]).ravel()
    A = A.reshape(-1, 6)
    rest, whole = np.zeros_like(s.a), np.zeros_like(s.a)
    rest[where], whole[where] = b - A @ np.linalg.lstsq(A, b, rcond=1e-12)[0], b
    return rest[: system.n_q], whole[: system.n_q]

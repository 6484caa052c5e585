r"""Mechanisms that remain if all flexible members are held rigid.

Connected nodes of flexible members then move as one body with six unknowns,
:math:`\delta x = t + \varphi \times (x - o)` and :math:`\delta\Theta = R^T \varphi`, and the scalars of members and
tyres are constant. Unknowns that two bodies share, and those of the ground, give further constraints. The rigid model
has lengths as its only scale; stiffness would be no criterion: the softest bending of 64 beams is 1e-9 of the stiffest.
"""

from typing import TYPE_CHECKING

import numpy as np

from mecano.maths.vector import skew
from mecano.model.numbering import SCALAR, Classes
from mecano.solve.diagnostics.mobility import RANK_TOLERANCE, Analysis, Group, groups

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.model.system import System


def stiff_mechanisms(system: "System", s: "State", length: float, analysis: Analysis) -> tuple[Group, ...] | None:
    """Return the groups of unknowns of ``system`` that can move at ``s`` with all flexible members rigid.

    None if nothing is flexible, or if there are too many unknowns. ``analysis`` is the Analysis of the constraints, in
    which rotations are multiplied by the length scale.
    """
    bodies, resting = _bodies(system), _resting(system)
    if not (bodies or resting.any()) or not analysis.small:
        return None
    T, ties = _as_bodies(system, s, length, bodies, resting)
    rows = np.vstack([ties, analysis.gradient.dense(np.arange(analysis.gradient.shape[0])) @ T])
    _, sigma, Vt = np.linalg.svd(np.linalg.qr(rows, mode="r"))
    Q, _ = np.linalg.qr(T @ Vt[int(np.sum(sigma > RANK_TOLERANCE)) :].T)
    return groups(Q @ Q.T, analysis.motions)


def _bodies(system):
    """Return the nodes of each body as lists of (index of its position in z, of its rotation in z, of its matrix)."""
    nodes: dict[tuple[int, int, int], int] = {}
    pairs: list[tuple[int, int]] = []
    for b in system.batches:
        if b.kind.flexible:
            for dofs, rots in zip(b.dofs, b.rots, strict=True):
                found = [(int(dofs[6 * i]), int(dofs[6 * i + 3]), int(R)) for i, R in enumerate(rots)]
                numbers = [nodes.setdefault(node, len(nodes)) for node in found]
                pairs += [(numbers[0], other) for other in numbers[1:]]
    classes = Classes(len(nodes))
    bodies: dict[int, list[tuple[int, int, int]]] = {}
    for i, j in pairs:
        classes.join(i, j)
    for node, i in nodes.items():
        bodies.setdefault(classes.find(i), []).append(node)
    return list(bodies.values())


def _resting(system):
    """Return (n_q,) bool: scalars of flexible members and of tyres (kinds with massless scalars), and signals."""
    resting = np.zeros(system.n_q, bool)
    for b in system.batches:
        if b.kind.flexible or b.kind.massless:
            own = b.dofs[:, 3 * len(b.kind.layout) :]
            own = own[own < system.n_q]
            resting[own[system.numbering.kind[own] == SCALAR]] = True
    return resting | system.signals


def _as_bodies(system, s, length, bodies, resting):
    """Return T (n_q, m) from the unknowns of bodies and all others, and the constraints (k, m) between bodies."""
    n_q, first = system.n_q, 6 * len(bodies)
    own = np.ones(n_q, bool)
    for x, r, _ in (node for body in bodies for node in body):
        own[[d + i for d in (x, r) for i in range(3) if d < n_q]] = False
    own = np.flatnonzero(own & ~resting)
    T, ties, placed = np.zeros((n_q, first + len(own))), [], np.zeros(n_q, bool)
    T[own, first + np.arange(len(own))] = 1.0
    for number, body in enumerate(bodies):
        origin = s.z[body[0][0] : body[0][0] + 3]
        for x, r, rotation in body:
            arm = s.z[x : x + 3] - origin
            moves = np.hstack([np.eye(3), -np.array(skew(arm / length))])
            turns = np.hstack([np.zeros((3, 3)), s.R[rotation].T])
            for d, rows in ((x, moves), (r, turns)):
                whole = np.zeros((3, T.shape[1]))
                whole[:, 6 * number : 6 * number + 6] = rows
                if d < n_q and not placed[d]:
                    T[d : d + 3], placed[d] = whole, True
                else:
                    ties.append(whole - T[d : d + 3] if d < n_q else whole)
    return T, np.vstack([np.zeros((0, T.shape[1])), *ties])

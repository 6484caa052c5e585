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
from mecano.solve.diagnostics.mobility import MANY, Analysis, Group, allowed_motions, groups
from mecano.solve.diagnostics.null_space import Entries, NullSpace

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.model.system import System


def stiff_mechanisms(system: "System", s: "State", length: float, analysis: Analysis) -> tuple[Group, ...] | None:
    """Return the groups of unknowns of ``system`` that can move at ``s`` with all flexible members rigid.

    None if nothing is flexible, or if there are too many unknowns. ``analysis`` is the Analysis of the constraints, in
    which rotations are multiplied by the length scale.
    """
    bodies, resting = _bodies(system), _resting(system)
    if not (bodies or resting.any()) or system.n_q > MANY:
        return None
    from scipy.sparse import csr_matrix, vstack  # few models need it

    T, ties = _as_bodies(system, s, length, bodies, resting)
    B, m = analysis.gradient, T.shape[1]
    rows = vstack([ties, csr_matrix((B.values, (B.rows, B.cols)), B.shape) @ T]).tocoo()
    entries = Entries(rows.row.astype(np.int64), rows.col.astype(np.int64), rows.data, rows.shape)
    of_body = np.append(np.repeat(np.arange(len(bodies)), 6), np.arange(len(bodies), m - 5 * len(bodies)))
    motions = allowed_motions(entries, of_body, np.ones(m, bool))
    Q, _ = np.linalg.qr(T @ motions.dense(np.arange(m)))
    return groups(NullSpace(system.n_q, ((np.arange(system.n_q), Q),)), analysis.motions)


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
    from scipy.sparse import csr_matrix

    n_q, first = system.n_q, 6 * len(bodies)
    own = np.ones(n_q, bool)
    for x, r, _ in (node for body in bodies for node in body):
        own[[d + i for d in (x, r) for i in range(3) if d < n_q]] = False
    own = np.flatnonzero(own & ~resting)
    shape = n_q, first + len(own)
    moved, tied, placed = [], [], {}
    for number, body in enumerate(bodies):
        origin = s.z[body[0][0] : body[0][0] + 3]
        for x, r, rotation in body:
            arm = s.z[x : x + 3] - origin
            moves = np.hstack([np.eye(3), -np.array(skew(arm / length))])
            turns = np.hstack([np.zeros((3, 3)), s.R[rotation].T])
            for d, rows in ((x, moves), (r, turns)):
                if d < n_q and d not in placed:
                    placed[d] = number, rows
                    moved.append((d, number, rows))
                else:
                    tied.append([(number, rows)] + ([(placed[d][0], -placed[d][1])] if d < n_q else []))
    T = _of_blocks([(d, 6 * number, rows) for d, number, rows in moved], shape)
    T += csr_matrix((np.ones(len(own)), (own, first + np.arange(len(own)))), shape)
    ties = [(3 * row, 6 * number, rows) for row, parts in enumerate(tied) for number, rows in parts]
    return T, _of_blocks(ties, (3 * len(tied), shape[1]))


def _of_blocks(blocks, shape):
    """Return a sparse matrix of blocks (3, 6), each given as (first row, first column, block)."""
    from scipy.sparse import csr_matrix

    row, column = np.array([(row, column) for row, column, _ in blocks], np.int64).reshape(-1, 2, 1, 1).swapaxes(0, 1)
    rows, columns = row + np.arange(3)[:, None], column + np.arange(6)
    rows, columns = np.broadcast_arrays(rows, columns)
    values = np.array([block for _, _, block in blocks]).reshape(-1, 3, 6)
    return csr_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape)

"""Unknowns of nodes that can move although nothing of what moves has mass: their motion follows from forces alone."""

import numpy as np

from mecano.model.numbering import ROTATION, TRANSLATION, Classes
from mecano.solve.diagnostics.analysis import DENSE_ROWS, RANK_TOLERANCE, SHARE, gradient


def massless_unknowns(system, s, length):
    """Return the numbers (n,), ascending, of positions and rotations of nodes that move in massless motions at ``s``.

    A massless motion fulfils the constraints and moves only unknowns on which no element with mass works. Rotations are
    counted by the length scale. Where more than ``DENSE_ROWS`` such unknowns hang together, none of them is found.
    """
    kind = system.numbering.kind[: system.n_q]
    light = ~_heavy(system) & ((kind == TRANSLATION) | (kind == ROTATION))
    if not light.any():
        return np.zeros(0, np.int64)
    B, _, _ = gradient(system, s, length)
    at = light[B.cols]
    found = [
        columns[_moving(B.rows[entries], B.cols[entries], B.values[entries], columns)]
        for columns, entries in _apart(np.flatnonzero(light), B.rows[at], B.cols[at], np.flatnonzero(at))
        if len(columns) <= DENSE_ROWS
    ]
    return np.sort(np.concatenate([*found, np.zeros(0, np.int64)]))


def _heavy(system):
    """Unknowns (n_q,) of the nodes of elements with mass, as booleans."""
    heavy = np.zeros(system.numbering.n_all, bool)
    for b in system.batches:
        if "mass" in b.p.dtype.names:
            heavy[b.dofs[b.p["mass"] > 0.0, : 3 * len(b.kind.layout)]] = True
    return heavy[: system.n_q]


def _apart(light, rows, cols, entries):
    """Sets of unknowns ``light`` (n,) that constraints tie, each with the numbers of its entries of the gradient."""
    index = np.searchsorted(light, cols)
    classes, first = Classes(len(light)), {}
    for row, i in zip(rows.tolist(), index.tolist(), strict=True):
        classes.join(first.setdefault(row, i), i)
    of = np.array([classes.find(i) for i in range(len(light))])
    order, members = np.argsort(of[index], kind="stable"), np.argsort(of, kind="stable")
    bounds = np.searchsorted(of[members], np.unique(of), side="right")[:-1]
    owners = of[index][order]
    for columns in np.split(light[members], bounds):
        owner = of[np.searchsorted(light, columns[0])]
        low, high = np.searchsorted(owners, owner), np.searchsorted(owners, owner, side="right")
        yield columns, entries[order[low:high]]


def _moving(rows, cols, values, columns):
    """Which of the ``columns`` (n,) move in the null space of a matrix given by its entries, as booleans (n,)."""
    _, i = np.unique(rows, return_inverse=True)
    block = np.zeros((max(i.max(initial=-1) + 1, 1), len(columns)))
    block[i, np.searchsorted(columns, cols)] = values
    _, sigma, Vt = np.linalg.svd(block)
    null = Vt[int(np.sum(sigma > RANK_TOLERANCE)) :]
    return np.sum(null**2, axis=0) > SHARE

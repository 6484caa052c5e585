r"""Families of modes, by the dominant direction or axis of their motion.

With the axes longitudinal (the horizontal mean velocity of the nodes; x for a model at rest), vertical (against
gravity; z without gravity) and lateral (vertical x longitudinal), a shape y is split into translations along each axis,
rotations about each axis, and scalar unknowns of elements. The part :math:`y_k` with the largest kinetic energy
:math:`y_k^* M y_k` determines the family: longitudinal, lateral, vertical; roll, pitch, yaw; deformation. For a motion
without inertia the squared displacements are compared instead, with rotations times the length scale. Signals, which
may have any unit, are ignored; a mode of signals alone, such as the pole of a filter, counts as deformation.
"""

import numpy as np

from mecano.model.numbering import ROTATION, SIGNAL, TRANSLATION
from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.linear.rounding import TINY
from mecano.solve.modal.linearize import Linearization

FAMILIES = ("longitudinal", "lateral", "vertical", "roll", "pitch", "yaw", "deformation")
SLOW = 1e-6  # of the largest velocity: a smaller mean velocity counts as zero
STILL = 1e-13  # of the largest component: displacements of a mode of signals alone
MASSLESS = 1e-12  # of the largest inertia, times the square of the displacement


def running_axes(system: System, s: State) -> np.ndarray:
    """Return the unit vectors longitudinal, lateral, vertical as rows (3, 3), inertial."""
    gravity, of = system.context.gravity, system.numbering
    size = np.linalg.norm(gravity)
    up = -gravity / size if size > 0.0 else np.array([0.0, 0.0, 1.0])
    places = np.unique(of.x[of.x < of.n_q])
    v = s.v[places[:, None] + np.arange(3)]
    fastest = np.linalg.norm(v, axis=1).max(initial=0.0)
    mean = v.mean(axis=0) if len(v) else np.zeros(3)
    for forward, least in ((mean, max(SLOW * fastest, TINY)), (np.eye(3)[0], 0.5), (np.eye(3)[1], 0.0)):
        level = forward - (forward @ up) * up
        if np.linalg.norm(level) > least:
            break
    forward = level / np.linalg.norm(level)
    return np.array([forward, np.cross(up, forward), up])


def families(lin: Linearization, kind: np.ndarray, axes: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    """Return the indices (m,) into FAMILIES of the ``shapes`` (m, n_q) of a Linearization.

    ``kind`` (n_q,) as in numbering.py, ``axes`` (3, 3) by rows.
    """
    M = lin.M[: lin.n_q, : lin.n_q]
    largest = abs(M.diagonal()).max(initial=0.0)
    found = np.zeros(len(shapes), int)
    for i, shape in enumerate(shapes):
        parts = _parts(kind, axes, shape)
        size = np.sum(np.abs(parts * lin.root) ** 2, axis=1)
        if size.sum() <= (STILL * np.abs(shape).max(initial=0.0)) ** 2:
            found[i] = FAMILIES.index("deformation")
            continue
        energy = np.array([abs(np.vdot(part, M @ part)) for part in parts])
        found[i] = np.argmax(energy if energy.max() > MASSLESS * largest * size.sum() else size)
    return found


def _parts(kind, axes, shape):
    """Return the shape (n_q,) split by families, (7, n_q)."""
    n = int(np.isin(kind, (TRANSLATION, ROTATION)).sum())  # unknowns of nodes come first, in groups of three
    along = shape[:n].reshape(-1, 3) @ axes.T
    parts = np.zeros((len(FAMILIES), len(shape)), complex)
    for k in range(3):
        moves = (along[:, k, None] * axes[k]).ravel()
        parts[k, :n] = np.where(kind[:n] == TRANSLATION, moves, 0.0)
        parts[3 + k, :n] = np.where(kind[:n] == ROTATION, moves, 0.0)
    parts[-1, n:] = np.where(kind[n:] >= SIGNAL, 0.0, shape[n:])
    return parts

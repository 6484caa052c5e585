r"""Growing poles of a Plant in which signals read earlier values.

Without the late entries f_k(s) in row i_k and column j_k, the equations A(s) of small motions have the growing poles of
their modes, P in number; with them the determinant changes by the factor

.. math::  F(s) = \det(1 - \mathrm{diag}(f_k)\, E^T A^{-1} D),

where D and E select the rows and columns; F tends to 1 for large s in the right half-plane. By the principle of the
argument there are P + W growing poles, where W is the number of turns of F around zero along the border of that
half-plane (Nyquist 1932).
"""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from mecano.solve.modal.encirclements import encirclements
from mecano.solve.modal.frequency_response import Plant, TransferFunction
from mecano.solve.modal.linearize import Linearization
from mecano.solve.modal.modes import DENSE, solve, unstable

SLOWEST = 1e-3  # of the lowest frequency: radius of the contour around zero
FASTEST = 1e4  # of the highest frequency: end of the contour
NEAREST = 20  # modes of a large model that are computed
ENDED = 0.1  # distance of F from 1 there, at most


def growing_poles(plant: Plant, low: float, high: float) -> int | None:
    """Return the number of growing poles; None if it is not determined.

    It is not if F does not tend to 1, for a large model none of whose modes nearest to zero grows, and if a mode grows
    more slowly than the equations change, unless another one grows faster and no entry is late.

    ``low``, ``high`` [rad/s]: range of frequencies of interest, beyond which the contour reaches.
    """
    lin = without_late(plant)
    large = lin.n_q > DENSE
    values = solve(lin, NEAREST if large else 1, "sparse" if large else "dense").values
    growing = [value for value in values if unstable(value)]
    faster = [value for value in growing if value.real > lin.pace]
    number = sum(1 + int(value.imag > 0.0) for value in faster)
    if large:
        return number or None
    if len(faster) < len(growing) and (plant.late or not faster):  # late entries turn the factor for all poles
        return None
    turns = _turns(replace(plant, lin=lin), low, high) if plant.late else 0
    return None if turns is None else number + turns


def without_late(plant: Plant) -> Linearization:
    """Return the Linearization in which the signals that read earlier values are constant."""
    late = {(row, column) for row, column, _ in plant.late}
    parts = []
    for A in (plant.lin.M, plant.lin.C, plant.lin.K):
        A = A.tocoo(copy=True)
        if late:
            A.data[[(i, j) in late for i, j in zip(A.row.tolist(), A.col.tolist(), strict=True)]] = 0.0
        parts.append(A.tocsr())
    M, C, K = parts
    return replace(plant.lin, M=M, C=C, K=K)


def _turns(plant, low, high):
    """Return how many more growing poles there are with the late entries than without, or None."""
    rows, columns, f = zip(*plant.late, strict=True)
    n, k = plant.lin.K.shape[0], len(rows)
    D, none = np.zeros((n, k)), np.zeros((n, k))
    D[rows, range(k)] = 1.0
    E = sp.csr_matrix((np.ones(k), (range(k), columns)), shape=(k, n))
    G = TransferFunction(Plant(plant.lin, [D, none, none], [E, sp.csr_matrix((k, n)), sp.csr_matrix((k, n))]))

    def factor(s):
        return complex(np.linalg.det(np.eye(k) - np.array([one(s) for one in f])[:, None] * G(s)))

    if not abs(factor(1j * FASTEST * high) - 1.0) <= ENDED:
        return None
    return encirclements(factor, SLOWEST * low, FASTEST * high)

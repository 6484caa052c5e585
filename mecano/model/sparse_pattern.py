"""The sparse pattern of the tangent of a model, and the places of the entries of elements in it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mecano.maths.distinct import distinct
from mecano.model.batch import Batch


class SparsePattern(NamedTuple):
    """Entries of a matrix (n, n) that may not be zero, by rows, each once, and the whole diagonal."""

    rows: np.ndarray  # (nnz,)
    cols: np.ndarray  # (nnz,)
    diagonal: np.ndarray  # (n,) indices of the diagonal entries


def sparse_pattern(n: int, batches: Sequence[Batch]) -> SparsePattern:
    """Return the pattern of n equations, and set the ``entries`` of the batches; nnz for those of fixed unknowns."""
    codes = [np.arange(n) * (n + 1)]
    for b in batches:
        i, j = b.dofs[:, :, None], b.dofs[:, None, :]
        codes.append(np.where((i < n) & (j < n), i * n + j, -1).ravel())
    unique = distinct(np.concatenate(codes))
    unique = unique[unique >= 0]
    for b, code in zip(batches, codes[1:], strict=True):
        place = np.where(code >= 0, np.searchsorted(unique, code), len(unique))
        b.entries = place.reshape(len(b.p), b.dofs.shape[1], b.dofs.shape[1])
    return SparsePattern(unique // n, unique % n, np.searchsorted(unique, codes[0]))

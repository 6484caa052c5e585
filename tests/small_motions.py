"""Eigenvalues of `mecano modes`, with their conjugates."""

import numpy as np

from mecano.analyses.modal import modes


def eigenvalues(deck, largest=1e5, frame="inertial"):
    """Eigenvalues [1/s] of small motions about the start of a deck, by ascending modulus, free motions as zeros."""
    _, found, _ = modes(deck, None, number=10_000, frame=frame)
    assert found.residuals.max() < 1e-6
    values = np.concatenate([found.values, found.values[found.values.imag > 0.0].conj()])
    values = values[np.abs(values) < largest]
    return np.array(sorted(values, key=lambda x: (abs(x), x.imag)))

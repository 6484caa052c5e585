r"""Coefficients of the Radau IIA method of three stages: order 5, stiffly accurate (Hairer & Wanner 1996, IV.5, IV.8).

The increments of the stages are :math:`\theta_i = h \sum_j A_{ij} \dot\theta_j`, so that :math:`\dot\theta_i = \sum_j
D_{ij} \theta_j / h` with :math:`D = A^{-1}`, whose eigenvalues are one real and a pair of complex numbers.
"""

from collections.abc import Sequence

import numpy as np

ROOT = np.sqrt(6.0)
NODES = np.array([(4.0 - ROOT) / 10.0, (4.0 + ROOT) / 10.0, 1.0])
A = np.array([
    [(88.0 - 7.0 * ROOT) / 360.0, (296.0 - 169.0 * ROOT) / 1800.0, (-2.0 + 3.0 * ROOT) / 225.0],
    [(296.0 + 169.0 * ROOT) / 1800.0, (88.0 + 7.0 * ROOT) / 360.0, (-2.0 - 3.0 * ROOT) / 225.0],
    [(16.0 - ROOT) / 36.0, (16.0 + ROOT) / 36.0, 1.0 / 9.0],
])  # fmt: skip
D = np.linalg.inv(A)
ERROR = np.array([-13.0 - 7.0 * ROOT, -13.0 + 7.0 * ROOT, -1.0]) / 3.0  # of the embedded formula, IV.8 (8.19)

_values, _vectors = np.linalg.eig(D)
_real, _complex = int(np.argmin(np.abs(_values.imag))), int(np.argmax(_values.imag))
REAL, COMPLEX = float(_values[_real].real), complex(_values[_complex])
FROM_REAL, FROM_COMPLEX = _vectors[:, _real].real, _vectors[:, _complex]  # eigenvectors, (3,) each
TO_REAL, TO_COMPLEX = np.linalg.inv(_vectors)[_real].real.copy(), np.linalg.inv(_vectors)[_complex]
TO_BOTH = np.stack([TO_COMPLEX.real, TO_COMPLEX.imag], axis=1)  # (3, 2)
FROM_BOTH = np.stack([FROM_REAL, 2.0 * FROM_COMPLEX.real, -2.0 * FROM_COMPLEX.imag], axis=1)  # (3, 3)


def to_coefficients(times: np.ndarray | Sequence[float]) -> np.ndarray:
    """Return the matrix from values at the ``times`` (m,) to the coefficients of their polynomial, ascending."""
    return np.linalg.inv(np.vander(times, increasing=True))


TO_CUBIC, TO_PARABOLA = to_coefficients([0.0, *NODES]), to_coefficients(NODES)

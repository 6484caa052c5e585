"""Eigenvalues of small motions followed over a parameter: which mode of one value is which of the next.

Both eigenvalues of a conjugate pair are followed, so that pairs may part into real ones and real ones meet to pairs.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

SHAPE = 0.5  # how much a shape that is quite another counts, beside an eigenvalue that is
GROWS = 1e-7  # of an eigenvalue: a real part below it is rounding
ALIKE = 1e-9  # difference of damping ratios that is rounding
ROUNDED = 1e-12  # of the largest eigenvalue: smaller ones are rounding


@dataclass(frozen=True)
class Spectrum:
    """All eigenvalues of one state that are not zero, conjugates among them, and their shapes."""

    values: np.ndarray  # (m,) complex [1/s]
    shapes: np.ndarray  # (m, n_q) complex, rotations counted by the length scale
    least: float = 0.0  # [1/s]: what is smaller means no more than zero
    families: np.ndarray | None = None  # (m,) numbers in families.py
    converged: np.ndarray | None = None  # (m,) bool

    @classmethod
    def of(cls, found, root, pace=0.0, families=None):
        """That of Modes, which tell one of each conjugate pair; ``root`` (n_q,) and ``pace`` as in Linearization.

        ``families`` (m,) numbers of the modes in families.py.
        """
        moving = np.flatnonzero(found.values != 0.0)
        values = found.values[moving]
        pairs = moving[values.imag > 0.0]
        least = max(pace, ROUNDED * np.abs(values).max(initial=0.0))
        all_of = np.concatenate([moving, pairs])
        both = np.concatenate([values, found.values[pairs].conj()])
        shapes = np.concatenate([found.shapes[moving], found.shapes[pairs].conj()]) * root
        numbers = np.zeros(len(found.values), int) if families is None else families
        return cls(both, shapes, least, numbers[all_of], found.converged[all_of])

    @property
    def counting(self):
        """The eigenvalues of positive or no imaginary part that mean more than zero."""
        return self.values[(self.values.imag >= 0.0) & (np.abs(self.values) > self.least)]

    def costs(self, value, shape, largest):
        """How unlike each eigenvalue with its shape is to ``value`` with ``shape``, (m,)."""
        apart = np.abs(self.values - value) / (np.abs(self.values) + abs(value) + 0.01 * largest)
        sizes = np.linalg.norm(self.shapes, axis=1) * np.linalg.norm(shape)
        alike = np.abs(self.shapes.conj() @ shape) / np.maximum(sizes, 1e-300)
        return apart + SHAPE * (1.0 - alike**2)

    def nearest(self, value, shape):
        """Number of the eigenvalue most like ``value`` with ``shape``."""
        return int(np.argmin(self.costs(value, shape, float(np.abs(self.values).max()))))


def unstable(value):
    """True where an eigenvalue, or each of an array, grows by more than rounding."""
    return np.real(value) > GROWS * np.abs(value)


def damping(values):
    """Damping ratios of eigenvalues; nan where they are nan or zero."""
    size = np.abs(values)
    return -np.real(values) / np.where(size > 0.0, size, np.nan)


def least_damped(values, least=0.0):
    """Place of the eigenvalue (n,) of the least damping ratio, of equal ones that which decays most slowly.

    Those that are nan do not count, nor those up to ``least``, (n,) or one, unless there are no others.
    """
    counts = np.isfinite(values) & (np.abs(values) > least)
    counts = counts if counts.any() else np.isfinite(values)
    ratio = np.where(counts, np.nan_to_num(damping(values)), np.inf)
    alike = ratio <= ratio.min() + ALIKE
    return int(np.argmax(np.where(alike, np.real(values), -np.inf)))


def growing(row, spectra):
    """Whether a branch grows at each place (n,); a stretch of growth in which it nowhere means more than zero is none.

    ``row`` (n,): its numbers in the ``spectra``, see ``track``.
    """
    known = np.flatnonzero(row >= 0)
    values = np.array([spectra[i].values[row[i]] for i in known])
    grows, means = unstable(values), np.abs(values) > [spectra[i].least for i in known]
    reported = np.zeros(len(row), bool)
    for stretch in np.split(np.arange(len(known)), np.flatnonzero(np.diff(grows)) + 1):
        reported[known[stretch]] = np.any(grows[stretch] & means[stretch])
    return reported


def track(spectra, places):
    """Numbers (branches, n) of the eigenvalues of each branch in the spectra at ``places`` (n,), -1 where it has none.

    A branch goes on where the eigenvalue, extrapolated, and the shape change least, all branches together. Spectra that
    are None, where nothing was found, are passed over.
    """
    known = [i for i, spectrum in enumerate(spectra) if spectrum is not None]
    rows = []
    for before, i in zip([None, *known], known, strict=False):
        open_rows = [row for row in rows if before is not None and row[before] >= 0]
        left = set(range(len(spectra[i].values)))
        if open_rows and left:
            costs = np.array([_costs(row, spectra, places, before, i) for row in open_rows])
            for r, j in zip(*linear_sum_assignment(costs), strict=True):
                open_rows[r][i] = j
                left.discard(int(j))
        for j in sorted(left, key=lambda j: abs(spectra[i].values[j])):
            rows.append(np.full(len(spectra), -1))
            rows[-1][i] = j
    return np.array(rows, int).reshape(len(rows), len(spectra))


def _costs(row, spectra, places, before, i):
    """How little each eigenvalue of spectrum i goes on the branch ``row``, last seen at ``before``."""
    value, shape = spectra[before].values[row[before]], spectra[before].shapes[row[before]]
    earlier = [j for j in range(before) if row[j] >= 0]
    largest = float(np.abs(spectra[i].values).max())
    if earlier and places[before] != places[earlier[-1]]:
        slope = (value - spectra[earlier[-1]].values[row[earlier[-1]]]) / (places[before] - places[earlier[-1]])
        value = value + slope * (places[i] - places[before])
    return spectra[i].costs(value, shape, largest)


def loci(rows, spectra):
    """Eigenvalues (branches, n) along branches, imaginary parts not negative, nan where there is none; and the rows.

    Of two branches that are conjugate everywhere one is kept.
    """
    values = np.full(rows.shape, np.nan, complex)
    for b, i in zip(*np.nonzero(rows >= 0), strict=True):
        value = spectra[i].values[rows[b, i]]
        values[b, i] = complex(value.real, abs(value.imag))
    kept = []
    for b in range(len(values)):
        if not any(np.array_equal(values[b], values[c], equal_nan=True) for c in kept):
            kept.append(b)
    return values[kept], rows[kept]

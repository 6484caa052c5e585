"""Tracking of modes over a parameter: branches of eigenvalues through the spectra at successive values.

Both eigenvalues of a conjugate pair are tracked, so that pairs can split into real ones and real ones merge into pairs.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.optimize import linear_sum_assignment

from mecano.solve.linear.rounding import TINY
from mecano.solve.modal.modes import Modes, damping, unstable

SHAPE = 0.5  # weight of a change of shape relative to a change of eigenvalue

ALIKE = 1e-9  # damping ratios that differ less are equal
ROUNDED = 1e-12  # of the largest eigenvalue: smaller ones count as zero


@dataclass(frozen=True)
class Spectrum:
    """All nonzero eigenvalues of one state, including conjugates, and their shapes."""

    values: np.ndarray  # (m,) complex [1/s]
    shapes: np.ndarray  # (m, n_q) complex, rotations times the length scale
    least: float = 0.0  # [1/s] modulus up to which an eigenvalue is not significant
    families: np.ndarray | None = None  # (m,) indices into FAMILIES of families.py
    converged: np.ndarray | None = None  # (m,) bool
    whirl: np.ndarray | None = None  # (m,) see whirl.py; None without a rotor
    speed: float = 0.0  # [rad/s] of the rotor

    @classmethod
    def of(
        cls, found: Modes, root: np.ndarray, pace: float = 0.0, families: np.ndarray | None = None,
        whirl: np.ndarray | None = None, speed: float = 0.0,
    ) -> Self:  # fmt: skip
        """Return the Spectrum of Modes, which contain one of each conjugate pair.

        ``root`` (n_q,) and ``pace`` as in Linearization; ``families`` (m,): indices into FAMILIES of families.py;
        ``whirl`` (m,), the same of both of a pair, and ``speed`` [rad/s]: of the rotor.
        """
        moving = np.flatnonzero(found.values != 0.0)
        values = found.values[moving]
        pairs = moving[values.imag > 0.0]
        least = max(pace, ROUNDED * np.abs(values).max(initial=0.0))
        all_of = np.concatenate([moving, pairs])
        both = np.concatenate([values, found.values[pairs].conj()])
        shapes = np.concatenate([found.shapes[moving], found.shapes[pairs].conj()]) * root
        numbers = np.zeros(len(found.values), int) if families is None else families
        turns = None if whirl is None else whirl[all_of]
        return cls(both, shapes, least, numbers[all_of], found.converged[all_of], turns, speed)

    @property
    def counting(self) -> np.ndarray:
        """The significant eigenvalues (n,) with nonnegative imaginary part."""
        return self.values[(self.values.imag >= 0.0) & (np.abs(self.values) > self.least)]

    @property
    def upper(self) -> np.ndarray:
        """(m,) Index of each eigenpair, or of its conjugate if that has the positive imaginary part."""
        found = np.arange(len(self.values))
        above = np.flatnonzero(self.values.imag > 0.0)
        for i in np.flatnonzero(self.values.imag < 0.0):
            same = above[self.values[above] == self.values[i].conj()]
            shapes = np.abs(self.shapes[same] - self.shapes[i].conj()).max(axis=1, initial=0.0)
            found[i] = same[np.argmin(shapes)] if len(same) else i
        return found

    def costs(self, value: complex, shape: np.ndarray, largest: float) -> np.ndarray:
        """Return the dissimilarity (m,) of each eigenpair to ``value`` with ``shape``."""
        apart = np.abs(self.values - value) / (np.abs(self.values) + abs(value) + 0.01 * largest)
        sizes = np.linalg.norm(self.shapes, axis=1) * np.linalg.norm(shape)
        alike = np.abs(self.shapes.conj() @ shape) / np.maximum(sizes, TINY)
        return apart + SHAPE * (1.0 - alike**2)

    def nearest(self, value: complex, shape: np.ndarray) -> int:
        """Return the index of the eigenpair most similar to ``value`` with ``shape``."""
        return int(np.argmin(self.costs(value, shape, float(np.abs(self.values).max()))))


def least_damped(values: np.ndarray, least: float | np.ndarray = 0.0) -> int:
    """Return the index of the least damped of the eigenvalues (n,); among equal ones, the one with the slowest decay.

    Ignores nan, and moduli up to ``least`` (a number or (n,)) unless there are no others.
    """
    counts = np.isfinite(values) & (np.abs(values) > least)
    counts = counts if counts.any() else np.isfinite(values)
    ratio = np.where(counts, np.nan_to_num(damping(values)), np.inf)
    alike = ratio <= ratio.min() + ALIKE
    return int(np.argmax(np.where(alike, np.real(values), -np.inf)))


def growing(row: np.ndarray, spectra: Sequence[Spectrum | None]) -> np.ndarray:
    """Return whether a branch is unstable at each place (n,); intervals without a significant eigenvalue are not.

    ``row`` (n,): indices of the branch in the ``spectra``, see ``track``.
    """
    known = np.flatnonzero(row >= 0)
    of = [(spectrum, i) for spectrum, i in zip(spectra, row, strict=True) if spectrum is not None and i >= 0]
    values = np.array([spectrum.values[i] for spectrum, i in of])
    grows, means = unstable(values), np.abs(values) > [spectrum.least for spectrum, _ in of]
    reported = np.zeros(len(row), bool)
    for stretch in np.split(np.arange(len(known)), np.flatnonzero(np.diff(grows)) + 1):
        reported[known[stretch]] = np.any(grows[stretch] & means[stretch])
    return reported


def track(spectra: Sequence[Spectrum | None], places: np.ndarray) -> np.ndarray:
    """Return the indices (branches, n) of the eigenvalues of each branch in the spectra at ``places`` (n,), or -1.

    Branches are continued by the assignment with the least total change of shape and of eigenvalue relative to its
    extrapolation. Spectra that are None, where nothing was found, are skipped.
    """
    known = {i: spectrum for i, spectrum in enumerate(spectra) if spectrum is not None}
    rows: list[np.ndarray] = []
    for before, i in zip([None, *known], known, strict=False):
        open_rows = [row for row in rows if before is not None and row[before] >= 0]
        unassigned = set(range(len(known[i].values)))
        if open_rows and unassigned:
            costs = np.array([_costs(row, known, places, before, i) for row in open_rows])
            for r, j in zip(*linear_sum_assignment(costs), strict=True):
                open_rows[r][i] = j
                unassigned.discard(int(j))
        for j in sorted(unassigned, key=lambda j: abs(known[i].values[j])):  # noqa: B023
            rows.append(np.full(len(spectra), -1))
            rows[-1][i] = j
    return np.array(rows, int).reshape(len(rows), len(spectra))


def _costs(row, spectra, places, before, i):
    """Return the cost (m,) of continuing the branch ``row``, last found at ``before``, with each eigenvalue of i."""
    value, shape = spectra[before].values[row[before]], spectra[before].shapes[row[before]]
    earlier = [j for j in range(before) if row[j] >= 0]
    largest = float(np.abs(spectra[i].values).max())
    if earlier and places[before] != places[earlier[-1]]:
        slope = (value - spectra[earlier[-1]].values[row[earlier[-1]]]) / (places[before] - places[earlier[-1]])
        value = value + slope * (places[i] - places[before])
    return spectra[i].costs(value, shape, largest)


def loci(rows: np.ndarray, spectra: Sequence[Spectrum | None]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the eigenvalues (branches, n) along branches, imaginary parts nonnegative, nan where missing; rows; shown.

    Of two branches that are conjugate everywhere, one is kept. Two that are so in part, as real ones that meet, are
    kept, but the later one lacks the common part in the eigenvalues and in ``shown``, which otherwise equals the rows.
    """
    values, shown = np.full(rows.shape, np.nan, complex), np.full(rows.shape, -1)
    taken: list[set[int]] = [set() for _ in spectra]
    upper = [None if spectrum is None else spectrum.upper for spectrum in spectra]
    for b, i in zip(*np.nonzero(rows >= 0), strict=True):
        pair = int(upper[i][rows[b, i]])
        if pair not in taken[i]:
            taken[i].add(pair)
            value = spectra[i].values[rows[b, i]]
            values[b, i], shown[b, i] = complex(value.real, abs(value.imag)), rows[b, i]
    kept = np.any(shown >= 0, axis=1)
    return values[kept], rows[kept], shown[kept]

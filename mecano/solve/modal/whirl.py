r"""Whirl of modes about the axis of a rotor, and critical speeds, at which a mode has a multiple of the rotor's speed.

In a shape y with time factor :math:`e^{\lambda t}` the displacement of each node, and its rotation, are split by the
unit vector e of the angular velocity into

.. math::
   y_F = \tfrac12 (1 - e e^T - i \hat e)\, y, \qquad y_B = \tfrac12 (1 - e e^T + i \hat e)\, y, \qquad y_A = e e^T y,

circles in the sense of the rotor, circles against it, and motions along or about the axis. The whirl is
:math:`(T_F - T_B)/(T_F + T_B + T_A)` with the kinetic energies :math:`T = y^* M y`: 1 for forward, -1 for backward
whirl. Shapes of equal eigenvalues, such as those of a disc in isotropic bearings, may be combined arbitrarily: the
combinations of extreme whirl are used.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as la

from mecano.errors import AssemblyError, ConvergenceError, NonFiniteError
from mecano.maths.root import root
from mecano.maths.vector import skew
from mecano.model.numbering import Numbering
from mecano.solve.linear.rounding import TINY
from mecano.solve.modal.critical import Trace, branch_end
from mecano.solve.modal.linearize import Linearization
from mecano.solve.modal.modes import Modes
from mecano.solve.modal.tracking import Spectrum

EQUAL = 1e-7  # of an eigenvalue: difference of equal ones
JUMPED = 1e-6  # of the eigenvalue: difference from a multiple of the speed, where branches were confused
TOLERANCE = 1e-11  # of the value of the parameter


@dataclass(frozen=True)
class Resonance:
    """A value of the parameter at which a mode has ``order`` times the angular velocity of the rotor."""

    place: float  # value of the parameter
    speed: float  # [rad/s] of the rotor
    value: complex  # eigenvalue there [1/s], imaginary part not negative
    branch: int
    order: float
    whirl: float


def whirling(found: Modes, lin: Linearization, of: Numbering, omega: np.ndarray) -> tuple[Modes, np.ndarray]:
    """Return (Modes with shapes of extreme whirl, whirl (m,), nan if the rotor is at rest).

    ``found``: Modes of the Linearization ``lin``; ``of``: Numbering; ``omega`` (3,) [rad/s]: angular velocity.
    """
    size = np.linalg.norm(omega)
    if size == 0.0:
        return found, np.full(len(found.values), np.nan)
    e = omega / size
    M, shapes = lin.M[: lin.n_q, : lin.n_q], found.shapes.astype(complex)
    for group in _equal(found.values):
        forward, backward, along = (_energies(M, part) for part in _parts(of, e, shapes[group]))
        whole = forward + backward + along
        least = 1e-12 * max(np.trace(whole).real, TINY)
        shapes[group] = la.eigh(forward - backward, whole + least * np.eye(len(group)))[1].T @ shapes[group]
    forward, backward, along = (
        np.einsum("mi,mi->m", part.conj(), (M @ part.T).T).real for part in _parts(of, e, shapes)
    )
    whole = forward + backward + along
    return replace(found, shapes=shapes), (forward - backward) / np.where(whole > 0.0, whole, 1.0)


def _equal(values):
    """Return lists of the indices of equal oscillations, by ascending modulus, each with more than one."""
    groups: list[list[int]] = []
    for i in np.flatnonzero(values.imag > 0.0).tolist():
        if groups and abs(values[i] - values[groups[-1][-1]]) <= EQUAL * abs(values[i]):
            groups[-1].append(i)
        else:
            groups.append([i])
    return [group for group in groups if len(group) > 1]


def _energies(M, part):
    """Return the Hermitian matrix (m, m) of y_i^* M y_j of the rows of ``part`` (m, n_q)."""
    T = part.conj() @ (M @ part.T)
    return 0.5 * (T + T.conj().T)


def _parts(of, e, shapes):
    """Return the forward, backward and axial parts (m, n_q) of ``shapes``; scalars of elements have none."""
    first = np.unique(np.concatenate([of.x[of.x < of.n_q], of.rotation_dof[of.rotation_dof < of.n_q]]))
    at, axis, hat = first[:, None] + np.arange(3), np.outer(e, e), np.array(skew(tuple(e)))
    parts = []
    for P in (0.5 * (np.eye(3) - axis - 1j * hat), 0.5 * (np.eye(3) - axis + 1j * hat), axis):
        part = np.zeros(shapes.shape, complex)
        part[:, at] = shapes[:, at] @ P.T
        parts.append(part)
    return parts


def resonances(
    rows: np.ndarray,
    spectra: Sequence[Spectrum | None],
    places: np.ndarray,
    orders: Sequence[float],
    spectrum_at: Callable[[float], Spectrum],
) -> tuple[list[Resonance], list[tuple[int, float, float, float]]]:
    """Return (Resonances by ascending order and place, and (branch, order, low, high) of those not refined).

    ``rows`` (branches, n): indices of the branches in the ``spectra`` at ``places`` (n,); ``spectrum_at(place)``
    returns a Spectrum; ``orders``: multiples of the angular velocity.
    """
    found, unrefined = [], []
    for branch, row in enumerate(rows):
        known = np.flatnonzero(row >= 0)
        for i, j in zip(known[:-1], known[1:], strict=True):
            ends = [branch_end(spectra, places, row, k) for k in (i, j)]
            for order in orders:
                both = [(abs(end[1].imag), order * spectra[k].speed) for end, k in zip(ends, (i, j), strict=True)]
                if _no_crossing(*both):
                    continue
                try:
                    found.append(_resonance(spectrum_at, ends, branch, order, spectra[i], spectra[j]))
                except (AssemblyError, ConvergenceError, NonFiniteError):
                    unrefined.append((branch, order, ends[0][0], ends[1][0]))
    return sorted(found, key=lambda one: (one.order, one.place)), unrefined


def _no_crossing(left, right):
    """Return whether (frequency, multiple of the speed) [rad/s] have one order at both ends, or both are zero at one.

    A mode that does not oscillate, for example for large damping, has the frequency zero of a rotor at rest, but no
    resonance.
    """
    zero = not any(left) or not any(right)
    return zero or (left[0] < left[1]) == (right[0] < right[1])


def _resonance(spectrum_at, ends, branch, order, *known):
    """Return the Resonance between two ``ends`` of a branch, whose Spectra are ``known``.

    Raises ConvergenceError if the branch is not continuous between them, and the errors of ``spectrum_at``.
    """
    spectra = {end[0]: spectrum for end, spectrum in zip(ends, known, strict=True)}

    def at(place):
        spectra[place] = spectrum_at(place)
        return spectra[place]

    trace = Trace(at, *ends)
    low, high = ends[0][0], ends[1][0]
    xtol = TOLERANCE * max(abs(low), abs(high))
    place = root(lambda p: abs(trace(p).imag) - order * spectra[p].speed, low, high, xtol)
    value, spectrum = trace(place), spectra[place]
    missed = abs(abs(value.imag) - order * spectrum.speed)
    if value.imag == 0.0 or missed > JUMPED * abs(value):
        raise ConvergenceError("the mode could not be followed")
    whirl = spectrum.whirl[int(np.argmin(np.abs(spectrum.values - value)))]
    return Resonance(place, spectrum.speed, complex(value.real, abs(value.imag)), branch, order, float(whirl))

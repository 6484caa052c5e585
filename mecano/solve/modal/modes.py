r"""Modes of small motions under constraints: complex eigenvalues and shapes of

.. math::  (\lambda^2 M + \lambda C + K)\, y + D \mu = 0, \qquad B y = 0, \qquad (\lambda E + F)\, y = 0.

All modes of small models (modes_dense.py), those nearest to zero of large ones (modes_sparse.py). Every pair is
checked by its residual in the equations above, relative to the magnitudes of their terms.
"""

from dataclasses import dataclass
from typing import overload

import numpy as np

from mecano.errors import ConvergenceError
from mecano.solve.linear.rounding import TINY
from mecano.solve.modal.linearize import Linearization
from mecano.solve.modal.modes_dense import dense, unstrained
from mecano.solve.modal.modes_sparse import sparse
from mecano.solve.modal.refined_mode import refined, without_strain
from mecano.solve.modal.separated_basis import separated_basis
from mecano.solve.modal.small_motions import SmallMotions

DENSE = 400  # motions up to which all eigenvalues are computed
FREE = 1e-9  # of the magnitudes of its terms: K y up to which a motion has no stiffness
ROUNDED = 1e-12  # of the same: inertia and damping forces that are rounding errors, as K y is where stiff forces cancel
OF_ENTRIES = 1e-16  # of the largest stiffness: rounding error of its entry
EIGENVALUES = 1e-14  # of the largest squared eigenvalue: rounding error of all eigenvalues of a dense matrix
LEAST = 1e-6  # of the largest stiffness: lower bound of these magnitudes; FREE times it is rounding error
PERTURBED = 1e-7  # of the largest eigenvalue: rounding of zeros in a Jordan chain, the root of that of others
TWINS = 0.1  # relative difference of the moduli of both eigenvalues of such a chain
REAL = 1e-9  # of an eigenvalue: imaginary part up to which it is real
CONVERGED = 1e-6  # residual up to which a mode is converged
GROWS = 1e-7  # of an eigenvalue: positive real part above which the mode grows
EQUAL = 1e-6  # relative difference of moduli up to which rounding determines their order
DRIFTS = 1e-2  # of the terms of (2 value M + C) y, and of a value: rounding of a drift in axes that turn
SLOW = 1e-3  # of the largest eigenvalue: those that may be zeros of a Jordan chain, split by rounding
GROWING = ("flutter", "divergence")
FIRST, MOST = 40, 320  # modes of a large model that are computed first, and at most, to find all of a range


@dataclass(frozen=True)
class Modes:
    """Modes by ascending natural frequency; of a conjugate pair, the one with the positive imaginary part."""

    values: np.ndarray  # (m,) complex eigenvalues [1/s]; zero for motions without stiffness
    shapes: np.ndarray  # (m, n_q) complex; displacements inertial [m], rotations inertial [rad], scalars
    residuals: np.ndarray  # (m,) relative to the magnitudes of the terms
    method: str
    found: int  # number of modes of the model; of a sparse solution, number of modes computed

    @property
    def frequency(self) -> np.ndarray:
        """Damped frequencies (m,) [Hz]."""
        return np.abs(self.values.imag) / (2.0 * np.pi)

    @property
    def natural_frequency(self) -> np.ndarray:
        """Moduli of the eigenvalues over 2 pi (m,) [Hz]."""
        return np.abs(self.values) / (2.0 * np.pi)

    @property
    def damping_ratio(self) -> np.ndarray:
        """Minus the real part over the modulus (m,); nan for free motions."""
        return damping(self.values)

    @property
    def converged(self) -> np.ndarray:
        """(m,) bool: False for a mode that does not satisfy the equations."""
        return self.residuals <= CONVERGED

    @property
    def kinds(self) -> list[str]:
        """(m,) names: free, oscillation, flutter, decay or divergence."""
        return [_kind(value) for value in self.values]


def _kind(value):
    if value == 0.0:
        return "free"
    if value.imag:
        return "flutter" if unstable(value) else "oscillation"
    return "divergence" if unstable(value) else "decay"


@overload
def unstable(value: np.ndarray) -> np.ndarray: ...
@overload
def unstable(value: complex) -> bool: ...
def unstable(value: complex | np.ndarray) -> bool | np.ndarray:
    """Return whether an eigenvalue (or each of an array) is unstable, beyond rounding."""
    return np.real(value) > GROWS * np.abs(value)


def damping(values: complex | np.ndarray) -> np.ndarray:
    """Return the damping ratios (n,) of eigenvalues (n,), or of one; nan where they are nan or zero."""
    size = np.abs(values)
    return -np.real(values) / np.where(size > 0.0, size, np.nan)


def solve(lin: Linearization, number: int = 10, method: str = "automatic") -> Modes:
    """Return the ``number`` Modes of lowest natural frequency of a Linearization, and all computed unstable ones.

    A growing mode among them is followed by the decaying one of the same modulus.

    ``method``: one of SOLVERS. Shapes are scaled so that their largest component is 1 (rotations
    times the length scale). Raises ConvergenceError if ARPACK fails.
    """
    scaled = SmallMotions(lin)
    if method != "automatic":
        return _found(scaled, lin, number, method)
    if lin.n_q > DENSE:
        found = _found(scaled, lin, number, "sparse")
        return found if found.converged.all() else _about_larger_shift(scaled, lin, number, found)
    found = _found(scaled, lin, number, "dense")
    if found.converged.all():
        return found
    return _nearest_to_zero(scaled, lin, number, found)


def poles_up_to(lin: Linearization, omega: float) -> np.ndarray:
    """Return the eigenvalues (m,) of a Linearization with moduli up to ``omega`` [1/s], one of each conjugate pair.

    For a large model at most MOST eigenvalues, those nearest to zero, are computed. Raises ConvergenceError if ARPACK
    fails.
    """
    scaled, number = SmallMotions(lin), FIRST
    while True:
        values, _, _ = dense(scaled) if lin.n_q <= DENSE else sparse(scaled, number)
        if lin.n_q <= DENSE or number >= MOST or np.abs(values).max(initial=0.0) > omega or len(values) < number:
            return values[(values.imag >= 0.0) & (np.abs(values) <= omega)]
        number *= 2


def _about_larger_shift(scaled, lin, number, found):
    """Return the Modes about a larger shift, or those ``found`` where they are more accurate."""
    try:
        return _better(found, _found(scaled, lin, number, "sparse", far=True))
    except ConvergenceError:
        return found


def _better(found, other):
    """Return the one of two Modes that is more accurate."""
    return other if other.residuals.max() < found.residuals.max() else found


def _found(scaled, lin, number, method, *, far=False):
    """Return the Modes of a method; ``far``: about a larger shift."""
    values, shapes, text = dense(scaled) if method == "dense" else sparse(scaled, number, far=far)
    values, shapes = (values, shapes) if method == "dense" else _without_chains(scaled, values, shapes)
    free = _free_shapes(scaled) if method == "dense" else np.zeros((0, scaled.n_q))
    exact = method == "dense" and scaled.on_velocity.any() and np.sum(values == 0.0) >= len(free)  # zeros are deflated
    found = _plain_zeros(values, shapes) if exact else _with_free(scaled, values, shapes, free)
    values, shapes = _one_of_each_pair(*found)
    for i in np.flatnonzero(unstable(values) & (values.real <= DRIFTS * np.abs(values.imag))):
        if _is_drift(scaled, values[i], shapes[i]):
            values[i] = 1j * values[i].imag
    chosen = _lowest(values, number)
    residuals = np.array([scaled.residual(values[i], shapes[i]) for i in chosen])
    free = values[chosen] == 0.0
    if residuals[free].max(initial=0.0) > CONVERGED and not exact and scaled.n_q <= DENSE:
        shapes[chosen[free]] -= _strained(scaled, shapes[chosen[free]])
        residuals = np.array([scaled.residual(values[i], shapes[i]) for i in chosen])
    if method == "sparse":
        residuals = _refined(scaled, values, shapes, chosen, residuals)
    shapes = np.array([_normal(shapes[i] * scaled.units) / lin.root for i in chosen]).reshape(len(chosen), lin.n_q)
    return Modes(values[chosen], shapes, residuals, text, len(values))


def _lowest(values, number):
    """Return the indices of the ``number`` values nearest to zero and of all that grow, first among equal moduli.

    A growing mode and the decaying one of the same modulus, of a motion that is reversible in time, are not separated.
    """
    order = np.argsort(np.abs(values), kind="stable")
    size = np.abs(values[order])
    group = np.cumsum(np.diff(size, prepend=size[:1]) > EQUAL * size)  # of equal moduli
    grows = np.array([_kind(value) in GROWING for value in values[order]], bool)
    places = np.lexsort((~grows, group))
    order, group, grows = order[places], group[places], grows[places]
    kept = (np.arange(len(order)) < number) | grows
    of_pairs = np.intersect1d(group[kept & grows], group[:number])
    return order[kept | np.isin(group, of_pairs)]


def _refined(scaled, values, shapes, chosen, residuals):
    """Refine those of the ``chosen`` modes that are not converged, in place; return the residuals of all."""
    free, wrong = values[chosen] == 0.0, residuals > CONVERGED
    if (wrong & free).any() and not free.all():
        i = chosen[wrong & free]
        shapes[i] = without_strain(scaled, shapes[i], float(np.abs(values[chosen[~free]]).min()))
    for i in chosen[wrong & ~free]:
        values[i], shapes[i] = refined(scaled, values[i], shapes[i])
    again = [scaled.residual(values[i], shapes[i]) if bad else 0.0 for i, bad in zip(chosen, wrong, strict=True)]
    return np.where(wrong, again, residuals)


def _nearest_to_zero(scaled, lin, number, found):
    """Return the Modes nearest to zero, found alone, if they are more accurate than those ``found`` by dense matrices.

    Rounding perturbs all eigenvalues of a dense matrix in proportion to the largest one, such as that of a damped
    member much lighter than its load. Growing modes may lie far from zero: if there are any, all modes are kept.
    """
    if any(kind in GROWING for kind, converged in zip(found.kinds, found.converged, strict=True) if converged):
        return found
    try:
        nearest = _found(scaled, lin, number, "sparse")
    except ConvergenceError:
        return found
    enough = len(nearest.values) >= min(number, len(found.values))
    return _better(found, nearest) if enough else found


def _normal(shape):
    """Return the shape scaled so that its largest component is 1."""
    largest = shape[np.argmax(np.abs(shape))]
    return shape / largest if largest else shape


def _with_free(scaled, values, shapes, further):
    """Return the pairs, with those without stiffness replaced by a basis of their space with eigenvalue zero.

    ``further`` (m, n_q) are shapes of this space: eigenvectors of a zero that rounding perturbs may be too few. As many
    pairs as these add motions are perturbed zeros, and are left out.
    """
    largest = np.abs(values).max(initial=0.0)
    still = np.array([_is_free(scaled, value, y, largest) for value, y in zip(values, shapes, strict=True)], bool)
    if not still.any() and not len(further):
        return values, shapes
    free = _span(np.concatenate([shapes[still], further]))
    left = ~still
    left[_perturbed(values, shapes, free, left, len(free) - len(_span(shapes[still])))] = False
    return np.concatenate([np.zeros(len(free)), values[left]]), np.concatenate([separated_basis(free), shapes[left]])


def _without_chains(scaled, values, shapes):
    """Return the pairs, with zero for both values of a double zero that rounding has split into opposite values.

    Their shapes are y + value z and y - value z, with a motion y without stiffness, as of a rotor that turns freely.
    """
    found, even = values.copy(), shapes.copy()
    for i in np.flatnonzero(np.abs(values) <= SLOW * np.abs(values).max(initial=0.0)):
        value, y, j = values[i], shapes[i], np.argmin(np.abs(values + values[i]))
        if abs(values[j] + value) > TWINS * abs(value):
            continue
        both = y + np.exp(1j * np.angle(np.vdot(shapes[j], y))) * shapes[j]
        if np.linalg.norm(_strain(scaled, both)) <= _of_rounding(scaled, both):
            found[i], even[i] = 0.0, both
    return found, even


def _span(shapes):
    """Return an orthonormal real basis (m, n_q) of the span of shapes and their conjugates."""
    if not len(shapes):
        return np.zeros(shapes.shape)
    parts = np.array([part for y in shapes for part in (y.real, y.imag)]).T
    U, sigma, _ = np.linalg.svd(parts / np.maximum(np.linalg.norm(parts, axis=0), TINY), full_matrices=False)
    return U[:, sigma > 1e-3 * sigma[0]].T


def _perturbed(values, shapes, free, left, missing):
    """Return the indices of pairs ``left`` (m,) bool that are zeros perturbed by rounding, of ``missing`` moduli.

    Their shapes are in the span of the ``free`` motions (k, n_q).
    """
    outside = np.linalg.norm(shapes - (shapes @ free.T) @ free, axis=1)
    inside = outside <= CONVERGED * np.linalg.norm(shapes, axis=1)
    sizes = np.abs(values)
    slow = np.flatnonzero(left & inside & (sizes <= PERTURBED * sizes.max(initial=0.0)))
    slow = slow[np.argsort(sizes[slow], kind="stable")]
    moduli = np.cumsum(np.diff(sizes[slow], prepend=-1.0) > TWINS * sizes[slow])
    return slow[moduli <= missing]


def _strained(scaled, shapes):
    """Return the parts (m, n_q) of shapes that have forces of stiffness: the least x with K x + D mu = K y, B x = B y.

    Free motions are combinations of eigenvectors; where these are nearly parallel, the combinations magnify rounding
    errors.
    """
    K, D, B = (A.toarray() for A in (scaled.K, scaled.D, scaled.B))
    whole = np.block([[K, D], [B, np.zeros((len(B), D.shape[1]))]])
    return np.linalg.lstsq(whole, np.vstack([K, B]) @ shapes.T, rcond=1e-12)[0][: scaled.n_q].T


def _plain_zeros(values, shapes):
    """Return the pairs, with a sparser basis for the shapes of eigenvalue zero."""
    free, shapes = values == 0.0, shapes.astype(complex)
    if free.any():
        shapes[free] = separated_basis(shapes[free].real)
    return values, shapes


def _free_shapes(scaled):
    """Return shapes (m, n_q) for which K y, up to multipliers, is rounding error."""
    shapes = [y for y in unstrained(scaled) if np.linalg.norm(_strain(scaled, y)) <= _of_rounding(scaled, y)]
    return np.array(shapes).reshape(-1, scaled.n_q)


def _strain(scaled, y):
    """Return K y, up to multipliers."""
    r = scaled.K @ y
    return r + scaled.D @ scaled.balancing_multipliers(r) if scaled.D.shape[1] else r


def _of_rounding(scaled, y):
    """Return the rounding error of K y."""
    own = ~scaled.signals  # signals have any unit
    K = scaled.K[own][:, own]
    of_entries = OF_ENTRIES * np.abs(K.data).max(initial=0.0) * np.linalg.norm(y[own])
    return max(ROUNDED * _terms(scaled, y), of_entries)


def _terms(scaled, y):
    """Return the magnitude of the terms of K y, or a bound of rounding."""
    return max(np.linalg.norm(abs(scaled.K) @ abs(y)), LEAST * scaled.size[2] * np.linalg.norm(y))


def _forces(scaled, value, y):
    """Return the largest force of inertia or damping of the pair."""
    return max(np.linalg.norm(value**2 * (scaled.M @ y)), np.linalg.norm(value * (scaled.C @ y)))


def _is_free(scaled, value, y, largest):
    """Return whether the pair is a free motion: K y, up to multipliers, and inertia and damping vanish to rounding."""
    size = _terms(scaled, y)
    if not size:
        return abs(value) <= 1e-7 * largest
    rounding = max(_of_rounding(scaled, y), EIGENVALUES * largest**2 * np.linalg.norm(scaled.M @ y))
    if _forces(scaled, value, y) > min(rounding, FREE * size):
        return False
    error = np.linalg.norm(_strain(scaled, y))  # no inertia or damping balances it: an error of the shape
    return error <= CONVERGED * size


def _is_drift(scaled, value, y):
    r"""Return whether the pair is a drift of a free body in turning axes: :math:`y\, t e^{\lambda t}` is a motion, too.

    Then :math:`(2 \lambda M + C)\, y` vanishes up to multipliers, and rounding splits the double eigenvalue.
    """
    inertia, turning = 2.0 * value * (scaled.M @ y), scaled.C @ y
    r = inertia + turning
    r = r + scaled.D @ scaled.balancing_multipliers(r) if scaled.D.shape[1] else r
    return np.linalg.norm(r) <= DRIFTS * np.linalg.norm(inertia)


def _one_of_each_pair(values, shapes):
    """Return one of each conjugate pair, with imaginary parts at rounding level set to zero."""
    real = np.abs(values.imag) <= REAL * np.abs(values)
    values = np.where(real, values.real + 0j, values)
    keep = values.imag >= 0.0
    return values[keep], shapes[keep]

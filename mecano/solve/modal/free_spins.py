r"""Free spins of a system in steady motion: rotations that leave all forces constant, at the rates of rolling wheels.

With the columns K_r of the tangent for rotations, the free spins N are the null space of K_r. The force on a sliding
wheel hardly depends on its spin. Therefore the spin of a wheel without a rolling constraint is found from the moment
about its axle, which increases with the spin.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mecano.maths.root import root
from mecano.maths.vector import skew
from mecano.solve.linear.rounding import ROUNDING, TINY
from mecano.solve.modal.separated_basis import separated_basis

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.solve.modal.steady import Steady, Tangent

SPINS = 1e-9  # of the largest singular value: rotations below leave the forces constant
WIDER, WIDENINGS = 2.0, 40  # factor on the bracket of a spin; number of times it is widened


class Turning(NamedTuple):
    """The singular value decomposition of scaled columns of a tangent for rotations, up to its rank."""

    U: np.ndarray  # (n, rank)
    sigma: np.ndarray  # (rank,)
    Vt: np.ndarray  # (rank, rotations)
    scale: np.ndarray  # (n,) of the rows
    N: np.ndarray  # (n_q, spins) free spins


def turning(steady: "Steady", at: "Tangent", K: np.ndarray) -> Turning:
    """Return the Turning of derivatives K (n, n_q) of a state with the Tangent ``at``."""
    scale = np.concatenate([1.0 / (at.k * steady.root), np.ones(steady.system.n_l)])
    U, sigma, Vt = np.linalg.svd(K[:, steady.turning] * scale[:, None] / steady.length, full_matrices=True)
    rank = int(np.sum(sigma > SPINS * max(sigma.max(initial=0.0), TINY)))
    N = np.zeros((steady.n_q, Vt.shape[0] - rank))
    N[steady.turning] = Vt[rank:].T
    spins = separated_basis(N.T).T
    return Turning(U[:, :rank], sigma[:rank], Vt[:rank], scale, spins / np.linalg.norm(spins, axis=0))


def unturned(steady: "Steady", at: "Tangent") -> np.ndarray:
    """Return the derivatives (n, n_q) of a Tangent with out-of-balance moments in inertial axes.

    A spin does not rotate them.
    """
    K = at.K[:, : steady.n_q].copy()
    for d in steady.system.numbering.rotation_dof:
        if d < steady.n_q:
            K[d : d + 3, d : d + 3] -= np.array(skew(tuple(at.f[d : d + 3])))
    return K


def roll(steady: "Steady", s: "State", N: np.ndarray, at: "Tangent") -> None:
    """Set the free spins N (n_q, spins) of the state ``s`` with the Tangent ``at``, in place, so that wheels roll."""
    n_q = steady.n_q
    B = -np.where(steady.of_rates[:, None], at.C[n_q:], at.K[n_q:, :n_q]) @ N
    held = np.abs(B).max(axis=0, initial=0.0) > SPINS * steady.length
    if held.any():  # the others would only balance rounding errors
        s.v[:n_q] -= N[:, held] @ np.linalg.lstsq(B[:, held], at.rates, rcond=SPINS)[0]
    for j in np.flatnonzero(~held):
        roll_one(steady, s, N[:, j], ROUNDING * steady.length * (at.size / steady.root).max())


def roll_one(steady: "Steady", s: "State", direction: np.ndarray, rounding: float) -> None:
    """Set the spin of ``s`` along ``direction`` (n_q,), in place, so that the moment about it vanishes.

    A moment below ``rounding`` [N m], as of a wheel in the air, determines no spin.
    """
    n_q = steady.n_q
    before = s.v[:n_q].copy()

    def moment(spin):
        s.v[:n_q] = before + spin * direction
        return float(direction @ steady.system.assemble(s).residual[:n_q])

    here, width = moment(0.0), 1e-3 * steady.speed / steady.length
    low = high = found = 0.0
    for _ in range(WIDENINGS if abs(here) > rounding else 0):
        low, high = high, -np.sign(here) * width
        if np.sign(moment(high)) != np.sign(here):
            found = root(moment, min(low, high), max(low, high))
            break
        width *= WIDER
    s.v[:n_q] = before + found * direction

r"""Straight steady running: a motion that is constant in a frame moving with the vehicle.

All nodes have the velocity V, angular velocities are constant, accelerations are zero: only wheels and parts that
rotate with them spin. Positions (deflections of tyres and springs, y and psi of patches), spins and reactions are found
by steady.py.

The angular velocities that leave the forces constant follow from the tangent: with its columns K_x for displacements
and K_r for rotations, :math:`K_r \omega = - K_x V` (in the rows of constraints on positions: minus their rates) has the
minimum-norm solution :math:`\omega_0`, and N are the free spins (free_spins.py).
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mecano.errors import name_list
from mecano.model.each_element import each_alone
from mecano.model.numbering import SIGNAL
from mecano.solve.modal.free_spins import roll, turning, unturned

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.model.system import System
    from mecano.solve.modal.steady import Steady, Tangent

STEADY = 1e-6  # largest relative change of forces per radian or length scale
DRAG = 0.5  # of the largest out-of-balance force: a smaller sum along the road is not its cause
ALONG = (
    "along",
    ("backward", "forward"),
    "causes are toe, rolling resistance, drag, loads or a slope; a drive that controls the speed balances them if it "
    "has an integrator, as in docs/tyres.md",
)
ACROSS = (
    "across",
    ("to the right", "to the left"),
    "wheels that lean or toe to one side, and loads, push the vehicle aside: let it be symmetric, or hold it by a "
    "joint, such as a prescribed_position",
)
SHARE, MOST_NAMES = 0.1, 4  # of that sum: smaller forces of elements are not named; number of names


class Straight:
    """The motion of a system with the velocity ``V`` (3,) [m/s] of all nodes, inertial; ``steady`` below: a Steady."""

    relaxes = False  # a relaxed state of another shape is used only if it is nearer than that of Newton's method
    fading = 0.8  # additional factor on the drag in each step of the relaxation: wheels and arms may move far
    remedy = (
        "initial positions nearer to it; stiffnesses in N/m, masses in kg; a velocity along the road, which is flat at "
        "the start, in the forward direction of the wheels; a force that balances the drag; wheels in balance about "
        "their axles (inertias are given in the axes of the node)"
    )
    remedy_for_constraints = remedy_for_forces = remedy

    def __init__(self, system: "System", V: Sequence[float]):
        of, self.V = system.numbering, np.asarray(V, float)
        self.n_q, self.at_once = system.n_q, np.flatnonzero(of.kind[: system.n_q] == SIGNAL)
        self.along = np.zeros(of.n_all)
        self.free = np.unique(of.x[of.x < self.n_q])[:, None] + np.arange(3)  # positions that are unknown
        self.along[self.free] = self.V

    def speed(self, length: float) -> float:
        """Return the speed [m/s]; at rest, one length scale per second."""
        return float(np.linalg.norm(self.V)) or length

    def begin(self, s: "State") -> None:
        """Set the velocities of the state ``s`` in place, without spins."""
        s.v[:] = self.along

    def total_derivatives(self, steady: "Steady", s: "State", K: np.ndarray, C: np.ndarray) -> np.ndarray:
        """Return the derivatives K (n, n) by positions, with which the velocities do not change."""
        return K

    def derivatives_by_spins(self, steady: "Steady", s: "State", C: np.ndarray) -> np.ndarray:
        """Return the derivatives C (n, n) by velocities, with which the accelerations do not change."""
        return C

    def without_drift(self, start: "State", s: "State") -> "State":
        """Return the state with the mean displacement along the road removed, which relaxation leaves arbitrary."""
        direction = self.V / (np.linalg.norm(self.V) or 1.0)
        s.z[self.free] -= float(direction @ (s.z - start.z)[self.free].mean(axis=0)) * direction
        return s

    def drift(self, shift: np.ndarray) -> np.ndarray:
        """Return the translation (3,) [m] that is no change of shape: the mean of the displacements (n, 3) of nodes."""
        return shift.mean(axis=0)

    def follow(self, steady: "Steady", start: "State", s: "State") -> "tuple[State, bool]":
        """Return (``s``, False): there is no alternative to Newton's method, which ended at ``s``."""
        return s, False

    def impose(self, steady: "Steady", s: "State") -> "tuple[State, np.ndarray, Tangent]":
        """Return (state with steady angular velocities and rolling wheels, N, its Tangent).

        Elements are put into the phases that belong to the state.
        """
        s = steady.monitor.settle(s.copy())
        at = steady.tangent(s)
        if not np.all(np.isfinite(at.K)):  # a formula outside its domain: no spins follow, and its merit is not finite
            return s, np.zeros((self.n_q, 0)), at
        omega, N = self._turning(steady, s, at)
        s.v[: self.n_q] = self.along[: self.n_q] + omega + N @ (np.linalg.pinv(N) @ (s.v[: self.n_q] - omega))
        at = steady.tangent(s)
        if N.shape[1]:
            roll(steady, s, N, at)
            at = steady.tangent(s)
        return s, N, at

    def _turning(self, steady, s, at):
        """Return the angular velocities (n_q,) that follow from V, and the free spins N (n_q, spins)."""
        running = s.copy()
        running.v[:] = self.along
        K = self._without_signals(unturned(steady, at))
        change = K @ self.along[: self.n_q]
        change[self.n_q :] = np.where(
            steady.of_rates, change[self.n_q :], -steady.system.constraint_derivatives(running)[:, 1]
        )
        t, omega = turning(steady, at, K), np.zeros(self.n_q)
        omega[steady.turning] = -t.Vt.T @ ((t.U.T @ (change * t.scale)) / t.sigma) / steady.length
        return omega, t.N

    def _without_signals(self, K):
        """Return the derivatives K (n, n_q) with algebraic signals as functions of the other unknowns.

        A signal may vary in steady running, such as a position along the road, if no force changes with it.
        """
        if not len(self.at_once):
            return K
        own = K[self.at_once]
        K = K - K[:, self.at_once] @ np.linalg.lstsq(own[:, self.at_once], own, rcond=None)[0]
        K[self.at_once] = K[:, self.at_once] = 0.0
        return K

    @property
    def title(self) -> str:
        """The motion in the words of an error."""
        return f"straight steady running with the velocity {np.round(self.V, 9).tolist()} m/s"

    def change_of_forces(self, steady: "Steady", s: "State", at: "Tangent") -> tuple[np.ndarray, float]:
        """Return the rates (n_q,) [N/s] of the out-of-balance forces, moments over the length scale; the largest one.

        Forces may change by STEADY of the largest while the vehicle runs a length scale, or its wheels turn by 1 rad.
        """
        K, v = self._without_signals(at.K[: self.n_q, : self.n_q]), s.v[: self.n_q]
        rate = max(steady.speed / steady.length, np.abs(v[steady.turning]).max(initial=0.0))
        return np.abs(K @ v) / steady.root, STEADY * float((at.size / steady.root).max(initial=0.0)) * rate

    def cause_of_imbalance(self, steady: "Steady", s: "State", at: "Tangent") -> str:
        """Return sentences on the sums of all forces along and across the road, if large; reactions have none."""
        way = self.V / (np.linalg.norm(self.V) or 1.0)
        across = np.cross(way, steady.system.context.gravity)
        across /= np.linalg.norm(across) or 1.0
        total, alone = at.f[self.free].sum(axis=0), None
        texts = []
        for direction, *words in ((way, *ALONG), (across, *ACROSS)):
            left = float(direction @ total)
            if abs(left) > DRAG * at.force:
                alone = self._sums(steady, s) if alone is None else alone
                texts.append(_imbalance(left, {name: float(direction @ f) for name, f in alone.items()}, *words))
        return "".join(texts)

    def _sums(self, steady, s):
        """Return {name of an element: sum (3,) of its forces [N]}."""
        sums: dict[str, np.ndarray] = {}
        for name, alone in each_alone(steady.system, s):
            sums[name] = sums.get(name, 0.0) + alone.residual[: self.n_q][self.free].sum(axis=0)
        return sums


def _imbalance(left, shares, place, sides, remedy):
    """Return a sentence on a sum ``left`` [N] of residuals, and the elements with the largest ``shares`` in it."""
    if all(share / left <= SHARE for share in shares.values()):
        shares = _by_kind(shares)
    alike = sorted((name for name in shares if shares[name] * left > 0.0), key=lambda name: -abs(shares[name]))
    causes = [f"{name} {abs(shares[name]):.3g} N" for name in alike if abs(shares[name]) > SHARE * abs(left)]
    named, side = name_list(causes, MOST_NAMES), sides[left < 0.0]
    return f"\n{place} the road some {abs(left):.3g} N remain {side}: {named}; {remedy}"


def _by_kind(shares):
    """Return the sums of the ``shares`` of all elements of a kind, such as "80 wheel", of which each is small."""
    kinds: dict[str, list[float]] = {}
    for name, share in shares.items():
        kinds.setdefault(name.partition(" ")[0], []).append(share)
    return {f"{len(alike)} {kind}": sum(alike) for kind, alike in kinds.items()}

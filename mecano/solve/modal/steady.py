r"""Steady motion: positions, reactions and spins that are constant in axes moving with the mechanism.

The motion, straight running (straight_running.py), rotation about a fixed axis (steady_rotation.py) or a turn on wheels
(steady_turn.py), gives velocities v(q) and accelerations a(q). Unknown are positions q, spins :math:`\sigma` along the
directions N and reactions with

.. math::
   f(q, v, a) - B^T \Lambda = 0, \quad \Phi(q) = 0, \quad \Phi_v(q, v) = 0, \quad v = v(q) + N \sigma.

Newton's method on :math:`(q, \sigma, \Lambda)` takes the minimum-norm step: positions along the motion, angles of spin
and reactions that are undetermined stay unchanged; steps are halved until the residual decreases. If Newton's method
halves many steps, or the mechanism ends in another shape, as a vehicle whose wheels just touch may balance on one of
them, it begins again from a start that is levelled and lowered onto its wheels (lowered_start.py). If this does not
help, that state is relaxed first, against a drag that decreases with the forces, and Newton's method continues from
there: so a strut gets through states in which the weight compresses it by itself. A rotation
that is not found in this way is followed from rest (spin_up.py). Signals may have any unit: their changes limit no
step, and the drag of the relaxation does not act on them.

The forces are in balance to 1e-9 of the largest one, or to the rounding of the positions times the stiffness: in a
straight shaft that turns, no other forces act.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from mecano.errors import ConvergenceError
from mecano.model.numbering import ROTATION
from mecano.solve.events.events import Searching
from mecano.solve.events.impact_candidates import ImpactCandidates
from mecano.solve.linear.rounding import ROUNDING, TINY
from mecano.solve.modal.lowered_start import lowered_starts
from mecano.solve.modal.steadiness import require_steady
from mecano.solve.time.increments import displaced, reach_of

if TYPE_CHECKING:
    from mecano.model.assembly import Assembly
    from mecano.model.state import State
    from mecano.model.system import System
    from mecano.solve.modal.steady_rotation import Rotation
    from mecano.solve.modal.straight_running import Straight

LARGEST = 4000  # largest number of equations, which are solved by dense least squares
ITERATIONS, CREEPS = 60, 300  # largest numbers of Newton iterations and of relaxation steps
RANK = 1e-12  # of the largest singular value: smaller ones are zero
FARTHEST = 0.2  # largest change in one iteration, in length scales or rad
FORCE, GAP, CHANGE = 1e-9, 1e-10, 1e-9  # tolerances: of the force scale; of length scale or speed; length scales or rad
ROUGHLY = 1e-8  # of the force scale: residual at which relaxation ends and Newton's method continues
FEW_ITERATIONS = 12  # from a nearby state; if more are needed, continuation takes a shorter step
HALVINGS = 16  # of steps, after which the state is relaxed before Newton's method has all its iterations
LEAST_GAIN, SMALLEST_SHARE = 1e-4, 2.0**-20  # required relative decrease of the residual by a full step; least share
FIRST_CREEP, FADES = 0.01, (0.1, 2.0)  # first displacement in length scales; limits of the change of the drag per step
LESS, HOPELESS = 0.9, 60  # relaxation ends if the force does not fall by this factor in that number of steps
MOST_GROWTH, HARDER = 1.5, 4.0  # largest growth of the force in a relaxation step; factor on the drag beyond it
ROUNDED = 1e-12  # of the speed, or of speed over length scale: smaller velocities are set to zero
NOTICEABLE = 0.1  # of the length scale: a state displaced by more has another shape


@dataclass
class Tangent:
    """Derivatives and residuals of a state in steady motion."""

    K: np.ndarray  # (n, n) derivatives by positions, with v(q) and a(q), and multipliers
    C: np.ndarray  # (n, n_q) derivatives by velocities, with a(q, v)
    k: float  # mean stiffness [N/m], which makes rows of forces and of constraints comparable
    f: np.ndarray  # (n_q,) out-of-balance forces
    size: np.ndarray  # (n_q,) sums of the magnitudes of the forces
    rounding: np.ndarray  # (n_q,) forces caused by rounding errors of positions
    gap: np.ndarray  # (n_l,) values of constraints on positions [m]; of those on velocities, times length scale / speed
    rates: np.ndarray  # (n_l,) rates of constraints on positions; values of constraints on velocities
    force: float  # largest out-of-balance force [N], moments divided by the length scale
    merit: float  # norm of all residuals
    excess: float  # largest ratio of a residual to its tolerance


class Steady:
    """Solver for the steady ``motion`` of a system, a Straight or a Rotation; ``length`` [m]: size of the mechanism.

    ``notify`` is called at each iteration with the largest out-of-balance force [N].
    """

    def __init__(
        self, system: "System", length: float, motion: "Straight | Rotation",
        notify: Callable[[float], object] = lambda force: None,
    ):  # fmt: skip
        self.notify = notify
        self.system, self.length, self.motion = system, length, motion
        of = system.numbering
        self.n_q, self.of_rates = system.n_q, of.of_rates
        self.turning = of.kind[: self.n_q] == ROTATION
        self.signals, self.moving = np.flatnonzero(system.signals), np.flatnonzero(~system.signals)
        self.root = np.where(self.turning, length, 1.0)
        self.speed = motion.speed(length)
        self.monitor = Searching(system)
        self._held: tuple[np.ndarray, np.ndarray] | None = None  # target of forces and gaps, zero by default
        self.k = None  # [N/m] mean stiffness at the start, at least that of its forces over the length scale

    def find(self, start: "State") -> "State":
        """Return the steady State near ``start``; raises ConvergenceError with the reason if none is found."""
        if self.system.n > LARGEST:
            raise ConvergenceError(f"steady motion can be computed for models of at most {LARGEST} equations")
        start = self._resting(start)
        s, arrived = self._newton(self.in_motion(start), HALVINGS)
        if not arrived or self.reshaped(start, s) > NOTICEABLE * self.length:
            start, s, arrived = self._from_below(start, s, arrived)
        if not arrived or self.reshaped(start, s) > NOTICEABLE * self.length:
            crept = self.motion.without_drift(start, self._creep(self.in_motion(start)))
            crept, settled = self._newton(crept, HALVINGS)
            if not (arrived or settled):
                s, arrived = self._newton(self.in_motion(start))
            better = self.motion.relaxes or self.reshaped(start, crept) < self.reshaped(start, s)
            if not arrived or (settled and better):
                s, arrived = crept, settled
            if not arrived:
                s, arrived = self.motion.follow(self, start, s)
        require_steady(self, s, arrived)
        s.v[np.abs(s.v) < ROUNDED * max(1.0, 1.0 / self.length) * self.speed] = 0.0
        return s

    def _resting(self, start):
        """Return ``start`` with the contacts and stops closed that touch there: they open where they would pull."""
        candidates = ImpactCandidates(self.system)
        touching = candidates.standing_open(self.monitor.values(start) + GAP * self.length)
        if not touching:
            return start
        return candidates.in_phase(replace(start, memory=self.system.commit(start)), touching, "after")

    def _from_below(self, start, s, arrived):
        """Return (start, state, whether it is steady) from the start lowered onto its wheels; ``s`` unless nearer.

        The start returned is the one from which the state was found, or a lowered one if none is steady: to level and
        to lower a vehicle is no change of its shape.
        """
        lows = lowered_starts(self, start)
        for low in lows:
            new, found = self._newton(low, HALVINGS)
            if found and (not arrived or self.reshaped(low, new) < self.reshaped(start, s)):
                start, s, arrived = low, new, True
            if arrived and self.reshaped(start, s) <= NOTICEABLE * self.length:
                break
        return start if arrived or not lows else lows[0], s, arrived

    def in_motion(self, start: "State") -> "State":
        """Return a State at the positions of ``start`` with the velocities of the motion, without reactions."""
        s = self.system.bare(start)
        self.motion.begin(s)
        return s

    def reshaped(self, start: "State", s: "State") -> float:
        """Return the largest change of shape [m] of a node from ``start`` to ``s``."""
        return float(self.change_of_shape(start, s).max(initial=0.0))

    def change_of_shape(self, before: "State", after: "State") -> np.ndarray:
        """Return the displacements (n_nodes,) [m] of all nodes between two states, without those of no consequence.

        Nodes that are not part of the deck, such as those of the ground, count as undisplaced.
        """
        own = ~np.array([node.internal for node in self.system.nodes])
        shift = (after.z - before.z)[self.system.numbering.x[:, None] + np.arange(3)]
        return np.where(own, np.linalg.norm(shift - self.motion.drift(shift[own]), axis=1), 0.0)

    def correct(self, s: "State") -> "tuple[State, bool]":
        """Return (state, whether Newton's method converged) near ``s``, by full steps.

        The first one bends slender members, whose tension falls with the second; their residual grows in between.
        """
        s, N, at = self.motion.impose(self, s)
        last = np.inf
        for _ in range(FEW_ITERATIONS):
            if at.excess <= 1.0 and last <= CHANGE:
                return s, True
            step, last = self._step(at, N)
            if not last <= FARTHEST:
                break
            s, N, at = self.motion.impose(self, self._moved(s, step, N, 1.0))
        return s, False

    def release(self, at: Tangent | None, share: float) -> None:
        """Seek states with a ``share`` of the forces and gaps of a Tangent, or in balance (None)."""
        self._held = None if at is None else (share * at.f, share * at.gap)

    def _newton(self, s, halvings=np.inf):
        """Return (state, whether Newton's method converged); steps are halved until the residual decreases.

        It gives up after more than ``halvings`` in total.
        """
        s, N, at = self.motion.impose(self, s)
        last = np.inf
        for _ in range(ITERATIONS):
            if at.excess <= 1.0 and last <= CHANGE:
                return s, True
            step, last = self._step(at, N)
            share = min(1.0, FARTHEST / max(last, TINY))
            while np.isfinite(last):
                trial = self.motion.impose(self, self._moved(s, step, N, share))
                if trial[2].merit <= (1.0 - LEAST_GAIN * share) * at.merit or max(trial[2].excess, at.excess) <= 1.0:
                    break
                share, halvings = 0.5 * share, halvings - 1
                if share < SMALLEST_SHARE or halvings < 0:
                    return s, at.excess <= 1.0
            else:
                return s, False
            s, N, at = trial
        return s, False

    def _creep(self, s):
        """Return the state after relaxation by implicit Euler steps against a drag, close to an equilibrium if any."""
        s, N, at = self.motion.impose(self, s)
        drag = at.force / (FIRST_CREEP * self.length)
        least, since = at.force, 0
        for i in range(CREEPS):
            least, since = (at.force, i) if at.force < LESS * least else (least, since)
            if at.excess <= ROUGHLY / FORCE or i - since > HOPELESS:
                break
            trial = self._crept(s, N, at, drag)
            if trial is None:
                drag *= HARDER
                continue
            drag *= self.motion.fading * min(max(trial[2].force / max(at.force, TINY), FADES[0]), FADES[1])
            s, N, at = trial
        return s

    def _crept(self, s, N, at, drag):
        """Return (state, N, Tangent) after a step of relaxation; None if a node moves too far or the force grows.

        The force of stiff ropes grows in the first iteration, which moves them along straight lines.
        """
        most, resistance, path = MOST_GROWTH * at.force, np.where(self.system.signals, 0.0, drag * self.root**2), 0.0
        for _ in range(FEW_ITERATIONS):
            step, change = self._step(replace(at, f=at.f + resistance * path), N, drag)
            if not change <= FARTHEST:
                return None
            s, N, at = self.motion.impose(self, self._moved(s, step, N, 1.0))
            if at.force <= most:
                return s, N, at
            path = path + step[0]
        return None

    def tangent(self, s: "State") -> Tangent:
        """Return the Tangent of a state."""
        C, _ = self.matrix(s, 0.0, 1.0, 0.0)
        K, assembly = self.matrix(s, 1.0, 0.0, 0.0)
        K, C = self.motion.total_derivatives(self, s, K, C), self.motion.derivatives_by_spins(self, s, C)
        f, size = assembly.residual[: self.n_q], assembly.size[: self.n_q]
        derivatives = self.system.constraint_derivatives(s)
        gap = np.where(self.of_rates, derivatives[:, 1] * self.length / self.speed, derivatives[:, 0])
        if self._held is not None:
            f, gap = f - self._held[0], gap - self._held[1]
        force = float(np.abs(f / self.root).max(initial=0.0))
        k = self.k = self.k or max(self._stiffness(K), force / self.length)
        merit = float(np.hypot(np.linalg.norm(f / (k * self.root)), np.linalg.norm(gap)))
        rounding = self._rounding(s, K)
        excess = self._excess(f, size, rounding, gap)
        return Tangent(K, C[:, : self.n_q], k, f, size, rounding, gap, derivatives[:, 1], force, merit, excess)

    def matrix(self, s: "State", cK: float, cC: float, cM: float) -> "tuple[np.ndarray, Assembly]":
        """Return the weighted sum (n, n) of derivatives by positions, velocities and accelerations; the Assembly."""
        system = self.system
        assembly, matrix = system.assemble(s, cK=cK, cC=cC, cM=cM), np.zeros((system.n, system.n))
        matrix[system.rows, system.cols] = assembly.data[: system.nnz]
        return matrix, assembly

    def _rounding(self, s, K):
        """Return the forces (n_q,) caused by rounding errors of positions, with the tangent ``K``."""
        stiffest = (np.abs(K[: self.n_q, : self.n_q]) / self.root).max(axis=1, initial=0.0)
        return ROUNDING * self.length * reach_of(s.z, self.system.numbering, self.length) * stiffest

    def allowed(self, size: np.ndarray, rounding: np.ndarray, relative: float) -> np.ndarray:
        """Return the tolerances (n_q,) of forces, moments over the length scale, ``relative`` to the largest force."""
        return np.maximum(relative * max((size / self.root).max(initial=0.0), TINY), rounding / self.root)

    def _excess(self, f, size, rounding, gap):
        """Return the largest ratio of a residual to its tolerance."""
        forces = (np.abs(f / self.root) / self.allowed(size, rounding, FORCE)).max(initial=0.0)
        worst = max(forces, np.abs(gap).max(initial=0.0) / (GAP * self.length))
        return worst if np.isfinite(worst) else np.inf

    def _step(self, at, N, drag=0.0):
        """Return the step of an iteration, or of relaxation if ``drag``: (changes of q, spins, reactions), largest q.

        The largest change of q is in length scales or rad, except signals, which may have any unit and have no drag;
        inf if the equations are not finite or cannot be solved.
        """
        self.notify(at.force)
        n_q, spins, k = self.n_q, N.shape[1], at.k
        rows = np.where(self.of_rates, self.length / self.speed, 1.0)
        A = np.hstack([at.K[:, :n_q] / self.root, at.C @ N * (self.speed / self.length), at.K[:, n_q:] * k])
        A[self.moving, self.moving] += (drag * self.root)[self.moving]
        A *= np.concatenate([1.0 / (k * self.root), rows])[:, None]
        b = np.concatenate([-at.f / (k * self.root), at.gap])
        if not (np.all(np.isfinite(A)) and np.all(np.isfinite(b))):
            return None, np.inf
        size = np.abs(A).max(axis=0, initial=0.0)
        weight = np.ones(A.shape[1])  # signals, in any unit, balance forces rather than motions against the drag
        with np.errstate(divide="ignore"):
            weight[self.signals] = size.max(initial=0.0) / size[self.signals]
        weight[~np.isfinite(weight)] = 0.0  # nothing reads these signals: they keep their initial values
        try:
            x = weight * np.linalg.lstsq(A * weight, b, rcond=RANK)[0]
        except np.linalg.LinAlgError:  # the iteration for the singular values may fail where many of them are zero
            return None, np.inf
        spin, reaction = x[n_q : n_q + spins] * (self.speed / self.length), k * x[n_q + spins :]
        return (x[:n_q] / self.root, spin, reaction), float(np.abs(x[self.moving]).max(initial=0.0)) / self.length

    def _moved(self, s, step, N, share):
        """Return the state after a share of a step."""
        dq, spin, reaction = step
        s = displaced(s, share * dq, self.system.numbering)
        s.v[: self.n_q] += share * (N @ spin)
        s.z[self.n_q : self.system.n] += share * reaction
        return s

    def _stiffness(self, K):
        """Return the mean stiffness [N/m] of the tangent."""
        diagonal = np.abs(np.diag(K)[: self.n_q]) / self.root**2
        return float(diagonal[diagonal > 0].mean()) if np.any(diagonal > 0) else 1.0

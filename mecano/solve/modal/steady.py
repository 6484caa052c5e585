r"""Straight steady running: a motion that looks the same at every instant to one who moves along.

All nodes have the velocity V, angular velocities are constant, nothing accelerates: only wheels and what turns with
them spin. Wanted are positions (deflections of tyres and springs, y and psi of patches), spins and reactions with

.. math::
   f(q, v, a = 0) - B^T \Lambda = 0, \quad \Phi(q) = 0, \quad \Phi_v(q, v) = 0, \quad v = (V, \omega_0 + N \sigma).

Which angular velocities change nothing follows from the tangent: with its columns K_x by displacements and K_r by
rotations, :math:`K_r \omega = - K_x V` (in the rows of constraints on positions: minus their rates) has the least
solution :math:`\omega_0`, and N spans what may turn besides: the spins.

Newton's method on :math:`(q, \sigma, \Lambda)`, solved for the least change: the place on the road, an angle of spin, a
reaction that nothing determines stay where they are; steps are halved until the residual falls. A sliding wheel does
not tell how far from rolling it is: the spin of a wheel that no constraint makes roll is found from the moment about
its axle alone, which grows with it, at every iteration. Where Newton's method does not arrive the state creeps, against
a drag that fades with the forces, and Newton's method goes on from there.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
from scipy.optimize import brentq

from mecano.errors import ConvergenceError
from mecano.maths.vector import skew
from mecano.model.numbering import ROTATION
from mecano.solve.diagnostics.failure import worst_equations
from mecano.solve.events.events import EventMonitor
from mecano.solve.time.increments import displaced

LARGEST = 4000  # equations, solved by dense least squares
ITERATIONS, CREEPS = 60, 300
RANK = 1e-12  # of the largest singular value: what counts as zero
SPINS = 1e-9  # the same, for what may turn without any change
FARTHEST = 0.2  # of the length scale, or rad, in one iteration
FORCE, GAP, CHANGE = 1e-9, 1e-10, 1e-9  # of the forces at work; of length scale or speed; of length scale, or rad
ROUGHLY = 1e-4  # of the forces at work: Newton's method goes on from there
LEAST_GAIN, SMALLEST_SHARE = 1e-4, 2.0**-20  # of the residual that a step must take away, the whole one; of a step
FIRST_CREEP, FADES = 0.01, (0.1, 2.0)  # of the length scale, by the largest force; change of the drag in a step
MOST_GROWTH, HARDER = 1.5, 4.0  # of the largest force in a creeping step; of the drag where it grows more
STEADY = 1e-6  # of the forces at work, that may change per radian or length scale; of the speed
ROUNDED = 1e-12  # of the speed, and of that over the length scale: slower motions are rounding
WIDER, WIDENINGS = 2.0, 40  # of the bracket of a spin


@dataclass
class Tangent:
    """A state without accelerations: its derivatives by positions K (n, n) and velocities C (n, n_q), and residuals."""

    K: np.ndarray
    C: np.ndarray
    k: float  # mean stiffness [N/m], which makes rows of forces and of constraints comparable
    f: np.ndarray  # (n_q,) forces out of balance
    size: np.ndarray  # (n_q,) the forces at work
    gap: np.ndarray  # (n_l,) constraints on positions; those on velocities over speed and length scale
    rates: np.ndarray  # (n_l,) rates of the constraints on positions; the constraints on velocities
    force: float  # the largest force out of balance, moments over the length scale [N]
    merit: float  # norm of all residuals
    excess: float  # the largest residual over its tolerance


class Steady:
    """The search of one system for running with the velocity ``V`` (3,) [m/s], inertial."""

    def __init__(self, system, length, V):
        self.system, self.length, self.V = system, length, np.asarray(V, float)
        of = system.numbering
        self.n_q, self.of_rates = system.n_q, of.of_rates
        self.turning = of.kind[: self.n_q] == ROTATION
        self.root = np.where(self.turning, length, 1.0)
        self.speed = float(np.linalg.norm(self.V)) or length  # [m/s]; at rest a length per second
        self.along = np.zeros(of.n_all)
        for first in np.unique(of.x[of.x < self.n_q]):
            self.along[first : first + 3] = self.V
        self.monitor = EventMonitor(system)
        self.k = None  # [N/m] mean stiffness at the start

    def find(self, start):
        """The steady State near ``start``. Raises ConvergenceError, which says why there is none."""
        if self.system.n > LARGEST:
            raise ConvergenceError(f"steady running is searched for in models of up to {LARGEST} equations only")
        s, arrived = self._newton(self._begun(start))
        if not arrived:
            s, arrived = self._newton(self._creep(self._begun(start)))
        self._judge(s, arrived)
        s.v[np.abs(s.v) < ROUNDED * max(1.0, 1.0 / self.length) * self.speed] = 0.0
        return s

    def _begun(self, start):
        s = start.copy()
        s.a[:] = 0.0
        s.v[:] = self.along
        s.z[self.n_q : self.system.n] = 0.0
        return s

    def _newton(self, s):
        """(state, whether it is steady to rounding); steps are halved until the residual falls."""
        s, N, at = self._spun(s)
        last = np.inf
        for _ in range(ITERATIONS):
            if at.excess <= 1.0 and last <= CHANGE:
                return s, True
            step, last = self._step(at, N)
            share = min(1.0, FARTHEST / max(last, 1e-300))
            while np.isfinite(last):
                trial = self._spun(self._moved(s, step, N, share))
                if trial[2].merit <= (1.0 - LEAST_GAIN * share) * at.merit or max(trial[2].excess, at.excess) <= 1.0:
                    break
                share *= 0.5
                if share < SMALLEST_SHARE:
                    return s, at.excess <= 1.0
            else:
                return s, False
            s, N, at = trial
        return s, False

    def _creep(self, s):
        """The state near an equilibrium, after steps of implicit Euler against a drag; or as far as they come."""
        s, N, at = self._spun(s)
        drag = at.force / (FIRST_CREEP * self.length)
        for _ in range(CREEPS):
            if at.excess <= ROUGHLY / FORCE:
                break
            step, change = self._step(at, N, drag)
            if not np.isfinite(change):
                break
            trial = self._spun(self._moved(s, step, N, 1.0)) if change <= FARTHEST else None
            if trial is None or not trial[2].force <= MOST_GROWTH * at.force:
                drag *= HARDER
                continue
            drag *= min(max(trial[2].force / max(at.force, 1e-300), FADES[0]), FADES[1])
            s, N, at = trial
        return s

    def tangent(self, s):
        """The Tangent of a state."""
        system, n = self.system, self.system.n
        parts = []
        for weights in ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0)):
            system.assemble(s, 1.0, 0.0, *weights)
            matrix = sp.csr_matrix((system.data[: system.nnz], (system.rows, system.cols)), shape=(n, n))
            parts.append(matrix.toarray())
        C, K = parts
        f, size, derivatives = (
            system.residual[: self.n_q].copy(),
            system.size[: self.n_q].copy(),
            system.constraint_derivatives(s),
        )
        gap = np.where(self.of_rates, derivatives[:, 1] * self.length / self.speed, derivatives[:, 0])
        k = self.k = self.k or self._stiffness(K)
        merit = float(np.hypot(np.linalg.norm(f / (k * self.root)), np.linalg.norm(gap)))
        force = float(np.abs(f / self.root).max(initial=0.0))
        return Tangent(
            K, C[:, : self.n_q], k, f, size, gap, derivatives[:, 1], force, merit, self._excess(f, size, gap)
        )

    def _excess(self, f, size, gap):
        """What is left of the equations, over the tolerances."""
        forces = np.abs(f / self.root).max(initial=0.0) / (FORCE * max((size / self.root).max(initial=0.0), 1e-300))
        worst = max(forces, np.abs(gap).max(initial=0.0) / (GAP * self.length))
        return worst if np.isfinite(worst) else np.inf

    def _step(self, at, N, drag=0.0):
        """An iteration, or a creeping step: changes of (q, spins, reactions), scaled, and the largest of q."""
        n_q, spins, k = self.n_q, N.shape[1], at.k
        rows = np.where(self.of_rates, self.length / self.speed, 1.0)
        A = np.hstack([at.K[:, :n_q] / self.root, at.C @ N * (self.speed / self.length), at.K[:, n_q:] * k])
        A[np.arange(n_q), np.arange(n_q)] += drag * self.root
        A *= np.concatenate([1.0 / (k * self.root), rows])[:, None]
        b = np.concatenate([-at.f / (k * self.root), at.gap])
        if not (np.all(np.isfinite(A)) and np.all(np.isfinite(b))):
            return None, np.inf
        x = la.lstsq(A, b, cond=RANK, lapack_driver="gelsy")[0]
        spin, reaction = x[n_q : n_q + spins] * (self.speed / self.length), k * x[n_q + spins :]
        return (x[:n_q] / self.root, spin, reaction), float(np.abs(x[:n_q]).max(initial=0.0)) / self.length

    def _moved(self, s, step, N, share):
        """The state after a share of a step."""
        dq, spin, reaction = step
        s = displaced(s, share * dq, self.system.numbering)
        s.v[: self.n_q] += share * (N @ spin)
        s.z[self.n_q : self.system.n] += share * reaction
        return s

    def _stiffness(self, K):
        """Mean stiffness [N/m] of the tangent."""
        diagonal = np.abs(np.diag(K)[: self.n_q]) / self.root**2
        return float(diagonal[diagonal > 0].mean()) if np.any(diagonal > 0) else 1.0

    def _spun(self, s):
        """The state with angular velocities that change nothing, wheels rolling as far as that can be told; N; Tangent.

        Elements are in the modes that the state tells.
        """
        s = self.monitor.settle(s.copy())
        omega, N = self._turning(s)
        s.v[: self.n_q] = self.along[: self.n_q] + omega + N @ (np.linalg.pinv(N) @ (s.v[: self.n_q] - omega))
        at = self.tangent(s)
        if N.shape[1]:
            B = -np.where(self.of_rates[:, None], at.C[self.n_q :], at.K[self.n_q :, : self.n_q]) @ N
            s.v[: self.n_q] -= N @ la.lstsq(B, at.rates, cond=SPINS)[0] if len(B) else 0.0
            for j in np.flatnonzero(np.abs(B).max(axis=0, initial=0.0) <= SPINS * self.length):
                self._roll(s, N[:, j])
            at = self.tangent(s)
        return s, N, at

    def _turning(self, s):
        """Angular velocities (n_q,) that follow from the running, and what may turn besides, N (n_q, spins)."""
        running = s.copy()
        running.v[:] = self.along
        at = self.tangent(s)
        K = at.K[:, : self.n_q].copy()
        for d in self.system.numbering.rotation_dof:
            if d < self.n_q:  # of moments in inertial axes: a spin does not turn those that are out of balance
                K[d : d + 3, d : d + 3] -= np.array(skew(tuple(at.f[d : d + 3])))
        change = K @ self.along[: self.n_q]
        change[self.n_q :] = np.where(
            self.of_rates, change[self.n_q :], -self.system.constraint_derivatives(running)[:, 1]
        )
        scale = np.concatenate([1.0 / (at.k * self.root), np.ones(self.system.n_l)])
        U, sigma, Vt = la.svd(K[:, self.turning] * scale[:, None] / self.length, full_matrices=True)
        rank = int(np.sum(sigma > SPINS * max(sigma.max(initial=0.0), 1e-300)))
        omega, N = np.zeros(self.n_q), np.zeros((self.n_q, Vt.shape[0] - rank))
        omega[self.turning] = -Vt[:rank].T @ ((U[:, :rank].T @ (change * scale)) / sigma[:rank]) / self.length
        N[self.turning] = Vt[rank:].T
        return omega, _plain(N)

    def _roll(self, s, direction):
        """Set the spin along ``direction`` (n_q,) of ``s`` in place so that no moment is left about it."""
        before = s.v[: self.n_q].copy()

        def moment(spin):
            s.v[: self.n_q] = before + spin * direction
            self.system.assemble(s, 1.0, 0.0, 0.0, 0.0, 0.0)
            return float(direction @ self.system.residual[: self.n_q])

        here, width = moment(0.0), 1e-3 * self.speed / self.length
        low = high = found = 0.0
        for _ in range(WIDENINGS):
            if here == 0.0:
                break
            low, high = high, -np.sign(here) * width
            if moment(high) * here <= 0.0:
                found = brentq(moment, low, high, xtol=1e-15 * width, rtol=1e-15)
                break
            width *= WIDER
        s.v[: self.n_q] = before + found * direction

    def _judge(self, s, arrived):
        """Refuse what is no steady running."""
        at = self.tangent(s)
        text = f"no straight steady running with the velocity {np.round(self.V, 9).tolist()} m/s was found"
        tries = (
            "what to try: initial positions nearer to it; a velocity along the road; what balances the drag; wheels in "
            "balance about their axles (inertias are given in the axes of the node)"
        )
        self.system.assemble(s, 1.0, 0.0, 0.0, 0.0, 0.0)
        if not arrived:
            raise ConvergenceError(
                f"{text}: forces remain out of balance, or constraints unfulfilled; most of all\n"
                f"{worst_equations(self.system)}\n{tries}"
            )
        off = np.abs(at.rates) / self.speed
        if off.max(initial=0.0) > STEADY:
            name = self.system.numbering.name[self.n_q + int(np.argmax(off))]
            raise ConvergenceError(f"{text}: it would not fulfil '{name}' as time goes by\n{tries}")
        K, v = at.K[: self.n_q, : self.n_q], s.v[: self.n_q]
        change, force = np.abs(K @ v) / self.root, (at.size / self.root).max(initial=0.0)
        rate = max(self.speed / self.length, np.abs(v[self.turning]).max(initial=0.0))
        if change.max(initial=0.0) > STEADY * force * rate:
            name = self.system.numbering.name[int(np.argmax(change))]
            raise ConvergenceError(f"{text}: the forces change as time goes by, in {name}\n{tries}")


def _plain(N):
    """The same space (n, s) by unit directions of which each has a place of its own where the others vanish."""
    if not N.shape[1]:
        return N
    _, _, order = la.qr(N.T, pivoting=True, mode="economic")
    plain = N @ np.linalg.inv(N[order[: N.shape[1]]])
    return plain / np.linalg.norm(plain, axis=0)

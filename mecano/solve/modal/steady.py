r"""Straight steady running: a motion that is constant in a frame moving with the vehicle.

All nodes have the velocity V, angular velocities are constant, accelerations are zero: only wheels and parts that
rotate with them spin. Unknown are positions (deflections of tyres and springs, y and psi of patches), spins and
reactions with

.. math::
   f(q, v, a = 0) - B^T \Lambda = 0, \quad \Phi(q) = 0, \quad \Phi_v(q, v) = 0, \quad v = (V, \omega_0 + N \sigma).

The angular velocities that leave the forces constant follow from the tangent: with its columns K_x for displacements
and K_r for rotations, :math:`K_r \omega = - K_x V` (in the rows of constraints on positions: minus their rates) has
the minimum-norm solution :math:`\omega_0`, and N is the null space of K_r: the free spins.

Newton's method on :math:`(q, \sigma, \Lambda)` takes the minimum-norm step: positions along the road, angles of spin
and reactions that are undetermined stay unchanged; steps are halved until the residual decreases. The force on a
sliding wheel hardly depends on its spin: therefore the spin of a wheel that no constraint makes roll is found, in every
iteration, from the moment about its axle, which increases with the spin. If Newton's method halves many steps, the
state is relaxed first, against a drag that decreases with the forces, and Newton's method continues from there; so it
is if the mechanism has another shape, as a vehicle whose wheels just touch may be balanced on one of them. Signals have
any unit: their changes limit no step, and the drag of the relaxation does not act on them.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from mecano.errors import ConvergenceError
from mecano.maths.vector import skew
from mecano.model.numbering import ROTATION, SIGNAL
from mecano.solve.diagnostics.failure import worst_equations
from mecano.solve.events.events import EventMonitor
from mecano.solve.time.increments import displaced

LARGEST = 4000  # largest number of equations, which are solved by dense least squares
ITERATIONS, CREEPS = 60, 300  # largest numbers of Newton iterations and of relaxation steps
RANK = 1e-12  # of the largest singular value: smaller ones are zero
SPINS = 1e-9  # the same, for rotations that leave the forces constant
FARTHEST = 0.2  # largest change in one iteration, in length scales or rad
FORCE, GAP, CHANGE = 1e-9, 1e-10, 1e-9  # tolerances: of the force scale; of length scale or speed; length scales or rad
ROUGHLY = 1e-4  # of the force scale: residual at which relaxation ends and Newton's method continues
HALVINGS = 16  # of steps, after which the state is relaxed before Newton's method has all its iterations
LEAST_GAIN, SMALLEST_SHARE = 1e-4, 2.0**-20  # required relative decrease of the residual by a full step; least share
FIRST_CREEP, FADES = 0.01, (0.1, 2.0)  # first displacement in length scales; limits of the change of the drag per step
LESS, HOPELESS = 0.9, 60  # relaxation ends if the force does not fall by this factor in so many steps
MOST_GROWTH, HARDER = 1.5, 4.0  # largest growth of the force in a relaxation step; factor on the drag beyond it
STEADY = 1e-6  # largest relative change of forces per radian or length scale; of constraints relative to the speed
ROUNDED = 1e-12  # of the speed, or of speed over length scale: smaller velocities are set to zero
DRAG = 0.5  # of the largest out-of-balance force: a smaller sum along the road is not its cause
NOTICEABLE = 0.1  # of the length scale: a state displaced by more has another shape
WIDER, WIDENINGS = 2.0, 40  # factor on the bracket of a spin; number of times it is widened


@dataclass
class Tangent:
    """Derivatives and residuals of a state without accelerations."""

    K: np.ndarray  # (n, n) derivatives by positions and multipliers
    C: np.ndarray  # (n, n_q) derivatives by velocities
    k: float  # mean stiffness [N/m], which makes rows of forces and of constraints comparable
    f: np.ndarray  # (n_q,) out-of-balance forces
    size: np.ndarray  # (n_q,) sums of the magnitudes of the forces
    gap: np.ndarray  # (n_l,) values of constraints on positions [m]; of those on velocities, times length scale / speed
    rates: np.ndarray  # (n_l,) rates of constraints on positions; values of constraints on velocities
    force: float  # largest out-of-balance force [N], moments divided by the length scale
    merit: float  # norm of all residuals
    excess: float  # largest ratio of a residual to its tolerance


class Steady:
    """Solver for the steady running of a system with the velocity ``V`` (3,) [m/s], inertial."""

    def __init__(self, system, length, V):
        self.system, self.length, self.V = system, length, np.asarray(V, float)
        of = system.numbering
        self.n_q, self.of_rates = system.n_q, of.of_rates
        self.turning = of.kind[: self.n_q] == ROTATION
        self.at_once = np.flatnonzero(of.kind[: self.n_q] == SIGNAL)
        self.signals, self.moving = np.flatnonzero(system.signals), np.flatnonzero(~system.signals)
        self.root = np.where(self.turning, length, 1.0)
        self.speed = float(np.linalg.norm(self.V)) or length  # [m/s]; at rest, one length scale per second
        self.along = np.zeros(of.n_all)
        self.free = np.unique(of.x[of.x < self.n_q])[:, None] + np.arange(3)  # positions that are unknown
        self.along[self.free] = self.V
        self.monitor = EventMonitor(system)
        self.k = None  # [N/m] mean stiffness at the start, at least that of its forces over the length scale

    def find(self, start):
        """Return the steady State near ``start``; raises ConvergenceError with the reason if none is found."""
        if self.system.n > LARGEST:
            raise ConvergenceError(f"steady running can be computed for models of at most {LARGEST} equations")
        s, arrived = self._newton(self._begun(start), HALVINGS)
        if not arrived or self._reshaped(start, s) > NOTICEABLE * self.length:
            crept, settled = self._newton(self._put_back(start, self._creep(self._begun(start))))
            if not (arrived or settled):
                s, arrived = self._newton(self._begun(start))
            if not arrived or (settled and self._reshaped(start, crept) < self._reshaped(start, s)):
                s, arrived = crept, settled
        self._judge(s, arrived)
        s.v[np.abs(s.v) < ROUNDED * max(1.0, 1.0 / self.length) * self.speed] = 0.0
        return s

    def _reshaped(self, start, s):
        """Return the largest displacement [m] of a node from ``start`` to ``s``, the mean translation removed."""
        return float(reshaping(self.system, start, s).max(initial=0.0))

    def _put_back(self, start, s):
        """Return the state with the mean displacement along the road removed, which relaxation leaves arbitrary."""
        direction = self.V / self.speed
        s.z[self.free] -= float(direction @ (s.z - start.z)[self.free].mean(axis=0)) * direction
        return s

    def _begun(self, start):
        s = start.copy()
        s.a[:] = 0.0
        s.v[:] = self.along
        s.z[self.n_q : self.system.n] = 0.0
        return s

    def _newton(self, s, halvings=np.inf):
        """Return (state, whether Newton's method converged); steps are halved until the residual decreases.

        Newton's method gives up after more than ``halvings`` in all.
        """
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
                share, halvings = 0.5 * share, halvings - 1
                if share < SMALLEST_SHARE or halvings < 0:
                    return s, at.excess <= 1.0
            else:
                return s, False
            s, N, at = trial
        return s, False

    def _creep(self, s):
        """Return the state after relaxation by implicit Euler steps against a drag, close to an equilibrium if any."""
        s, N, at = self._spun(s)
        drag = at.force / (FIRST_CREEP * self.length)
        least, since = at.force, 0
        for i in range(CREEPS):
            least, since = (at.force, i) if at.force < LESS * least else (least, since)
            if at.excess <= ROUGHLY / FORCE or i - since > HOPELESS:
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
        """Return the Tangent of a state."""
        system, n = self.system, self.system.n
        parts = []
        for weights in ((0.0, 1.0, 0.0), (1.0, 0.0, 0.0)):
            assembly = system.assemble(s, 1.0, 0.0, *weights)
            matrix = sp.csr_matrix((assembly.data[: system.nnz], (system.rows, system.cols)), shape=(n, n))
            parts.append(matrix.toarray())
        C, K = parts
        f, size = assembly.residual[: self.n_q], assembly.size[: self.n_q]
        derivatives = system.constraint_derivatives(s)
        gap = np.where(self.of_rates, derivatives[:, 1] * self.length / self.speed, derivatives[:, 0])
        force = float(np.abs(f / self.root).max(initial=0.0))
        k = self.k = self.k or max(self._stiffness(K), force / self.length)
        merit = float(np.hypot(np.linalg.norm(f / (k * self.root)), np.linalg.norm(gap)))
        return Tangent(
            K, C[:, : self.n_q], k, f, size, gap, derivatives[:, 1], force, merit, self._excess(f, size, gap)
        )

    def _excess(self, f, size, gap):
        """Return the largest ratio of a residual to its tolerance."""
        forces = np.abs(f / self.root).max(initial=0.0) / (FORCE * max((size / self.root).max(initial=0.0), 1e-300))
        worst = max(forces, np.abs(gap).max(initial=0.0) / (GAP * self.length))
        return worst if np.isfinite(worst) else np.inf

    def _step(self, at, N, drag=0.0):
        """Return the step of an iteration, or of relaxation if ``drag``: (changes of q, spins, reactions), largest q.

        The largest change of q is in length scales or rad, signals excepted, which have any unit and no drag; inf if
        the equations are not finite.
        """
        n_q, spins, k = self.n_q, N.shape[1], at.k
        rows = np.where(self.of_rates, self.length / self.speed, 1.0)
        A = np.hstack([at.K[:, :n_q] / self.root, at.C @ N * (self.speed / self.length), at.K[:, n_q:] * k])
        A[self.moving, self.moving] += (drag * self.root)[self.moving]
        A *= np.concatenate([1.0 / (k * self.root), rows])[:, None]
        b = np.concatenate([-at.f / (k * self.root), at.gap])
        if not (np.all(np.isfinite(A)) and np.all(np.isfinite(b))):
            return None, np.inf
        size = np.abs(A).max(axis=0, initial=0.0)
        weight = np.ones(A.shape[1])  # signals have any unit; they balance forces rather than motions against the drag
        weight[self.signals] = size.max(initial=0.0) / np.maximum(size[self.signals], 1e-300)
        x = weight * la.lstsq(A * weight, b, cond=RANK, lapack_driver="gelsy")[0]
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

    def _spun(self, s):
        """Return (state with steady angular velocities and rolling wheels, N, its Tangent).

        Elements are put into the phases that belong to the state.
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
        """Return the angular velocities (n_q,) that follow from V, and the free spins N (n_q, spins)."""
        running = s.copy()
        running.v[:] = self.along
        at = self.tangent(s)
        K = at.K[:, : self.n_q].copy()
        for d in self.system.numbering.rotation_dof:
            if d < self.n_q:  # out-of-balance moments are fixed in inertial axes: a spin does not rotate them
                K[d : d + 3, d : d + 3] -= np.array(skew(tuple(at.f[d : d + 3])))
        K = self._without_signals(K)
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

    def _without_signals(self, K):
        """Return the derivatives K (n, n_q) with algebraic signals as functions of the other unknowns.

        A signal may vary in steady running, such as a position along the road, if no force changes with it.
        """
        if not len(self.at_once):
            return K
        own = K[self.at_once]
        K = K - K[:, self.at_once] @ la.lstsq(own[:, self.at_once], own)[0]
        K[self.at_once] = K[:, self.at_once] = 0.0
        return K

    def _roll(self, s, direction):
        """Set the spin of ``s`` along ``direction`` (n_q,), in place, so that the moment about it vanishes."""
        before = s.v[: self.n_q].copy()

        def moment(spin):
            s.v[: self.n_q] = before + spin * direction
            assembly = self.system.assemble(s, 1.0, 0.0, 0.0, 0.0, 0.0)
            return float(direction @ assembly.residual[: self.n_q])

        here, width = moment(0.0), 1e-3 * self.speed / self.length
        low = high = found = 0.0
        for _ in range(WIDENINGS):
            if here == 0.0:
                break
            low, high = high, -np.sign(here) * width
            if np.sign(moment(high)) != np.sign(here):  # their product may underflow
                from scipy.optimize import brentq  # takes 0.3 s to import, hence only when needed

                found = brentq(moment, low, high, xtol=1e-15 * width, rtol=1e-15)
                break
            width *= WIDER
        s.v[: self.n_q] = before + found * direction

    def _judge(self, s, arrived):
        """Raise ConvergenceError if the state is not in steady running."""
        at = self.tangent(s)
        text = f"no straight steady running with the velocity {np.round(self.V, 9).tolist()} m/s was found"
        tries = (
            "what to try: initial positions nearer to it; a velocity along the road; a force that balances the drag; "
            "wheels in balance about their axles (inertias are given in the axes of the node)"
        )
        if not arrived:
            assembly = self.system.assemble(s, 1.0, 0.0, 1.0, 0.0, 0.0)
            raise ConvergenceError(
                f"{text}: forces remain out of balance or constraints violated; the worst equations:\n"
                f"{worst_equations(self.system, assembly)}{self._drag(at)}\n{tries}"
            )
        off = np.abs(at.rates) / self.speed
        if off.max(initial=0.0) > STEADY:
            name = self.system.numbering.name[self.n_q + int(np.argmax(off))]
            raise ConvergenceError(f"{text}: the constraint '{name}' would be violated over time\n{tries}")
        K, v = self._without_signals(at.K[: self.n_q, : self.n_q]), s.v[: self.n_q]
        change, force = np.abs(K @ v) / self.root, (at.size / self.root).max(initial=0.0)
        rate = max(self.speed / self.length, np.abs(v[self.turning]).max(initial=0.0))
        if change.max(initial=0.0) > STEADY * force * rate:
            name = self.system.numbering.name[int(np.argmax(change))]
            raise ConvergenceError(f"{text}: the forces change over time, in {name}\n{tries}")

    def _drag(self, at):
        """Return a sentence on the sum of all forces along the road, if it is the largest; reactions have none."""
        drag = abs(float(self.V @ at.f[self.free].sum(axis=0))) / self.speed
        if drag < DRAG * at.force:
            return ""
        return (
            f"\nalong the road some {drag:.3g} N remain, of toe, rolling resistance, drag or a slope: a drive that "
            "controls the speed balances them if it has an integrator, as in docs/tyres.md"
        )


def reshaping(system, before, after):
    """Return the displacements (n_nodes,) [m] of all nodes between two states, the mean translation removed."""
    shift = (after.z - before.z)[system.numbering.x[:, None] + np.arange(3)]
    return np.linalg.norm(shift - shift.mean(axis=0), axis=1)


def _plain(N):
    """Return unit vectors (n, s) that span the same space, each with one component where all others vanish."""
    if not N.shape[1]:
        return N
    _, _, order = la.qr(N.T, pivoting=True, mode="economic")
    plain = N @ np.linalg.inv(N[order[: N.shape[1]]])
    return plain / np.linalg.norm(plain, axis=0)

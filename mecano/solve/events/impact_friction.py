r"""Coulomb friction in impacts (docs/shocks.md, Friction in impacts).

Each rough contact has, in addition to its normal impulse :math:`P_n`, an impulse :math:`P_t` (2,) along the surface
that opposes the velocity of sliding u after the impact:

.. math::  |P_t| \le \mu P_n, \qquad P_t = -\mu P_n\, u^+/|u^+| \text{ if } u^+ \ne 0

The coefficient is that of the velocity of sliding before the impact.
"""

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mecano.element_interface import Place
from mecano.element_interface.records import with_attributes
from mecano.errors import AssemblyError, Failure
from mecano.immutable import immutable
from mecano.solve.linear.rounding import TINY

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.model.system import System

ACCELERATED = 60  # first sweeps, with Anderson acceleration
SHARES = 1.0, 0.3, 0.1  # relaxation factors of the sweeps, tried one after the other
SWEEPS = 300  # largest number of sweeps with one of these factors
ROUNDING = 1e-13  # of the largest impulse: a sweep that changes less has converged
ACCEPTED = 1e-2  # of the largest impulse, or velocity: redundant contacts, as corners of a box, converge slowly
STALLS = 1e-8, 10  # of the largest impulse, sweeps: smaller changes that so many sweeps do not halve are rounding
DIVERGED = 1e3  # of the largest impulse: the sweeps with this factor diverge
PRESSED = 1e6  # times the impulse that stops the contacts one by one: beyond, velocities lose ten digits by rounding
REPEATED = 1e-9  # relative: changes of two sweeps that differ by less are equal
MASSLESS = 1e-14  # of the largest response: a contact that moves no mass along its surface is without friction


@immutable
class RoughContact:
    """Friction of one contact: its index among the contacts of an impact, and its geometry."""

    contact: int
    mu: float
    dofs: np.ndarray  # (n_local,) indices into the velocities
    gradients: np.ndarray  # (2, n_local) of the velocities of sliding

    def sliding(self, v: np.ndarray) -> np.ndarray:
        """Return the velocities of sliding (2,) [m/s] at velocities v (n_all,)."""
        return self.gradients @ v[self.dofs]

    def forces(self, n_q: int) -> np.ndarray:
        """Return the forces (2, n_q) of unit forces along the surface."""
        out, own = np.zeros((2, n_q)), self.dofs < n_q
        for force, gradient in zip(out, self.gradients, strict=True):
            np.add.at(force, self.dofs[own], gradient[own])
        return out


class RubbingParts:
    """The parts with friction in impacts of a system, by the multipliers of their contacts, in the order of batches."""

    def __init__(self, system: "System"):
        batches = [batch for batch in system.batches if batch.kind.impact_friction is not None]
        places = [(batch, e, with_attributes(p)) for batch in batches for e, p in enumerate(batch.p)]
        leads = [batch.dofs[:, batch.kind.first_reaction] - system.n_q for batch in batches]
        self.by_lead = dict(
            zip(np.concatenate([*leads, np.zeros(0, np.int64)]).tolist(), enumerate(places), strict=True)
        )


def rough_contacts(system: "System", s: "State", leads: np.ndarray) -> list[RoughContact]:
    """Return the RoughContacts among contacts with the multipliers ``leads`` (n,), at the state before the impact."""
    by_lead, found, contacts = system.kept(RubbingParts).by_lead, [], {lead: i for i, lead in enumerate(leads.tolist())}
    for _, (batch, e, p), contact in sorted((*by_lead[lead], i) for lead, i in contacts.items() if lead in by_lead):
        dofs = batch.dofs[e]
        at = Place(s.t, 0, 1.0, 0.0, system.laws, np.zeros(0), s.z[dofs], s.v[dofs], s.a[dofs], s.R[batch.rots[e]])
        mu, gradients = batch.kind.impact_friction(p, at)
        found.append(RoughContact(contact, mu, dofs, gradients))
    return found


def solve_with_friction(
    normal: Callable[[np.ndarray], np.ndarray],
    W_nt: np.ndarray,
    W_tt: np.ndarray,
    b: np.ndarray,
    u: np.ndarray,
    contacts: Sequence[RoughContact],
    start: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the impulses (n,) along the normals and (2 m,) along the surfaces of the m rough ``contacts``.

    ``normal(b)`` solves the problem of the normals for rates b (n,) without their impulses; W_nt (n, 2 m) and
    W_tt (2 m, 2 m) are responses to impulses along the surfaces, u (2 m,) the velocities of sliding without impulses;
    ``start`` (2 m,) is the first guess of the impulses along the surfaces.
    Alternates between normals and surfaces (block Gauss-Seidel), at first with Anderson acceleration, then without it,
    and under-relaxed if that does not converge. Raises AssemblyError if the impulses along the surfaces, or the
    velocities, stay undetermined by more than ``ACCEPTED``, or if the impulses grow without limit.
    """
    bound_of, mu = [contact.contact for contact in contacts], np.array([contact.mu for contact in contacts])
    blocks = _blocks(W_tt)
    fastest = max(-b.min(initial=0.0), np.abs(u).max(initial=0.0))
    most = _largest_impulse(W_tt, fastest)
    sizes: list[float] = []

    def sweep(along):
        pushes = normal(b + W_nt @ along)
        change = _along_surfaces(W_tt, blocks, u + W_nt.T @ pushes, mu * pushes[bound_of], along) - along
        largest = pushes.max(initial=0.0)
        with np.errstate(over="ignore"):  # of sweeps that diverge
            size = np.abs(change).max() / max(largest, TINY) if largest <= most else np.inf
        sizes.append(size)
        return size, change, pushes, along

    best = last = sweep(np.zeros(len(u)) if start is None else start)
    points: list[np.ndarray] = []
    changes: list[np.ndarray] = []
    stride, former = 1.0, np.inf
    for _ in range(ACCELERATED):
        if best[0] <= ROUNDING or last[0] > DIVERGED or _stalls(sizes):
            break
        points, changes = [*points, last[3]][-len(u) - 1 :], [*changes, last[1]][-len(u) - 1 :]
        if last[0] > 0.1 * former and _repeats(changes):
            stride *= 2.0
        elif stride > 1.0:  # a contact slips
            points, changes, stride = points[-1:], changes[-1:], 1.0
        former = last[0]
        last = sweep(_extrapolated(points, changes) if stride == 1.0 else last[3] + stride * last[1])
        best = min(best, last, key=lambda found: found[0])
    for share in SHARES:
        last = best
        for _ in range(SWEEPS):
            if best[0] <= ROUNDING or last[0] > DIVERGED or _stalls(sizes):
                break
            last = sweep(last[-1] + share * last[1])
            best = min(best, last, key=lambda found: found[0])
    if best[0] > ROUNDING and max(best[0], np.abs(W_tt @ best[1]).max() / max(fastest, TINY)) > ACCEPTED:
        raise AssemblyError(
            "the friction in an impact presses the bodies together more and more: give the contact a 'law', which "
            "resolves the impact in time",
            Failure.NOT_CONVERGED,
        )
    return best[2], best[3]


def _largest_impulse(W, fastest):
    """Return the largest impulse [N s] to accept, for responses W along the surfaces and speeds up to ``fastest``."""
    responses = np.diag(W)
    massive = responses[responses > MASSLESS * responses.max(initial=0.0)]
    return PRESSED * fastest / massive.min() if len(massive) else np.inf


def _stalls(sizes):
    """Return whether the ``sizes`` of the changes of all sweeps are small and no longer fall.

    Sticking contacts that repeat one another contradict one another by the rounding of their positions.
    """
    least, sweeps = STALLS
    return len(sizes) > sweeps and (best := min(sizes)) <= least and min(sizes[:-sweeps]) <= 2.0 * best


def _repeats(changes):
    """Return whether the last change (k,) is the one before: friction grows by the same amount in each sweep.

    It does so between contacts that stick, until one of them slips.
    """
    return len(changes) > 1 and np.abs(changes[-1] - changes[-2]).max() <= REPEATED * np.abs(changes[-1]).max()


def _extrapolated(points, changes):
    """Return the point (k,) at which the change vanishes if it is linear in the last points (n, k).

    Anderson acceleration of the iteration x + change(x) (Walker & Ni 2011); with one point it is this iteration.
    """
    steps, differences = np.diff(points, axis=0), np.diff(changes, axis=0)
    shares = np.linalg.lstsq(differences.T, changes[-1], rcond=1e-12)[0] if len(points) > 1 else np.zeros(0)
    return points[-1] + changes[-1] - shares @ (steps + differences)


def _blocks(W):
    """Return {index: (block A, eigenvalues, eigenvectors)} of the contacts that move some mass along their surfaces."""
    A, largest = np.array([W[i : i + 2, i : i + 2] for i in range(0, len(W), 2)]), np.diag(W).max(initial=0.0)
    of, Q = np.linalg.eigh(A)
    return {i: (A[i], of[i], Q[i]) for i in range(len(A)) if np.trace(A[i]) > MASSLESS * largest}


def _along_surfaces(W, blocks, u, bounds, start):
    """Return impulses (2 m,) along the surfaces, at most ``bounds`` (m,), that oppose W x + u: one sweep."""
    x = start.copy()
    for i, (A, of, Q) in blocks.items():
        own = slice(2 * i, 2 * i + 2)
        x[own] = within_disc(of, Q, u[own] + W[own] @ x - A @ x[own], bounds[i])
    return x


def within_disc(of: np.ndarray, Q: np.ndarray, c: np.ndarray, radius: float) -> np.ndarray:
    """Return the x (2,) with |x| <= radius that minimizes x A x/2 + c x.

    ``of`` (2,), ``Q`` (2, 2) are eigenvalues and eigenvectors of A, symmetric and positive semidefinite. On the edge
    A x + c = -s x with s >= 0: the remaining velocity of sliding is opposite to x.
    """
    if radius <= TINY or not c.any():
        return np.zeros(2)
    d = Q.T @ c
    if of[0] <= ROUNDING * of[1]:
        d[0] = 0.0  # in a direction in which no impulse moves the contact, its velocity is rounding
    if of[0] > MASSLESS * of[1] and _norm(d / of) <= radius:
        return -Q @ (d / of)
    s = max(_norm(d) / radius - of[1], MASSLESS * of[1])
    while (size := _norm(d / (of + s))) > radius:
        # Newton's method on 1/size, which is concave (Hebden 1973): it approaches the root from below
        larger = s + (size / radius - 1.0) * size * size / (d @ (d / (of + s) ** 3))
        if not larger > s:
            break
        s = larger
    return -Q @ (d / (of + s))


def _norm(x):
    """Return the length of a vector, as np.linalg.norm, which takes three times as long."""
    return math.sqrt(x.dot(x))

"""Coefficients of restitution of contacts that close together (docs/shocks.md, Rules)."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mecano.solve.linear.rounding import ROUNDING

if TYPE_CHECKING:
    from mecano.solve.events.impact_candidates import ImpactCandidate


def restitutions(
    contacts: "Mapping[ImpactCandidate, int]",
    fast: "Sequence[ImpactCandidate]",
    owners: Sequence[int],
    W: np.ndarray,
    reactions: np.ndarray,
) -> np.ndarray:
    """Return the coefficients of restitution (n,): the least of the ``fast`` ones connected with each contact.

    Parameters
    ----------
    contacts : dict
        Indices of the n contacts, by ImpactCandidate.
    fast : list of ImpactCandidate
        Contacts that close faster than their rest speed, and latches, which count as 0. A contact that is connected
        with none of them has the coefficient 0.
    owners : list of int
        Indices of the contacts of m unit impulses, the first n of which act along the normals.
    W, reactions : ndarray (m, m), (n_l, m)
        Responses to these impulses: rates along them, and reactions of all constraints.
    """
    n, values = len(contacts), np.array([max(c.restitution, 0.0) for c in fast])
    if len(set(values)) < 2:
        return np.full(n, min(values, default=0.0))
    held = [c for c in fast if c not in contacts]
    numbers = {**contacts, **{c: n + i for i, c in enumerate(held)}}
    at, e = np.array([numbers[c] for c in fast]), np.zeros(len(numbers))
    for part in _connected(_meets(n, [c.rows for c in held], owners, W, reactions)):
        e[part] = min(values[part[at]], default=0.0)
    return e[:n]


def _meets(n, held, owners, W, reactions):
    """Return whether an impulse at a contact moves another, or meets a reaction in rows ``held``, (n + h, n + h)."""
    meets, sizes = np.zeros((n + len(held), n + len(held)), bool), np.sqrt(np.abs(np.diag(W)))
    np.logical_or.at(meets, np.ix_(owners, owners), np.abs(W) > ROUNDING * np.outer(sizes, sizes))
    least = ROUNDING * np.abs(reactions).max(axis=0)
    for i, rows in enumerate(held, n):
        np.logical_or.at(meets[i], owners, np.abs(reactions[rows]).max(axis=0) > least)
    return meets


def _connected(coupled: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the masks (n,) of the connected components of the graph with edges ``coupled`` (n, n) bool."""
    coupled, unvisited = coupled | coupled.T, np.ones(len(coupled), bool)
    while unvisited.any():
        component, reached = np.zeros_like(unvisited), np.zeros_like(unvisited)
        reached[np.argmax(unvisited)] = True
        while reached.any():
            component |= reached
            reached = coupled[reached].any(axis=0) & ~component
        unvisited &= ~component
        yield component

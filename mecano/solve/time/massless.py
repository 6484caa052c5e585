"""Massless unknowns of nodes: positions and rotations that can move without moving any mass, by forces alone."""

from typing import TYPE_CHECKING

import numpy as np

from mecano.maths.distinct import distinct
from mecano.model.numbering import ROTATION, TRANSLATION
from mecano.solve.diagnostics.mobility import allowed_motions, gradient
from mecano.solve.time.workspace import BEGIN

if TYPE_CHECKING:
    from mecano.jit.entry import PackedCall
    from mecano.model.state import State
    from mecano.model.system import System
    from mecano.solve.time.workspace import Workspace


def massless_unknowns(system: "System", s: "State", length: float) -> np.ndarray:
    """Return the indices (n,), ascending, of positions and rotations of nodes that move in massless motions at ``s``.

    A massless motion satisfies the constraints and moves only unknowns on which no element with mass acts. Rotations
    count times the length scale.
    """
    kind = system.numbering.kind[: system.n_q]
    light = ~_heavy(system) & ((kind == TRANSLATION) | (kind == ROTATION))
    if not light.any():
        return np.zeros(0, np.int64)
    B, _, _ = gradient(system, s, length)
    return allowed_motions(B, system.numbering.group, light).members


class LightUnknowns:
    """The unknowns without mass of a system: scalars, and nodes that move in massless motions.

    The workspace of a step has those of its phases once they are needed (``knows_light``), before them the scalars.
    """

    def __init__(self, system: "System", length: float):
        self._system, self._length = system, length
        kind = system.numbering.kind[: system.n_q]
        self._some_of_nodes = bool(np.any(~_heavy(system) & ((kind == TRANSLATION) | (kind == ROTATION))))
        self._at_corners = unknowns_at_corners(system)
        self._scalars = np.flatnonzero(system.massless)
        self._in_phases: dict[bytes, np.ndarray] = {}
        self._relax: PackedCall | None = None  # to be kept, as compiled code refers to it

    def at(self, s: "State") -> np.ndarray:
        """Return their indices (n,), ascending, in the phases of ``s``: the same in all but singular positions."""
        key = s.phases.tobytes()
        if key not in self._in_phases:
            of_nodes = massless_unknowns(self._system, s, self._length)
            self._in_phases[key] = distinct(np.concatenate([self._scalars, of_nodes]).astype(np.int64))
        return self._in_phases[key]

    def begin(self, w: "Workspace", s: "State") -> None:
        """Enter the state ``s`` as that at BEGIN into a workspace; in other phases its unknowns are to be found."""
        if self._some_of_nodes and not np.array_equal(w.phases, s.phases):
            self.forget(w)
        w.put_state(BEGIN, s)

    def forget(self, w: "Workspace") -> None:
        """Enter the scalars alone into a workspace, which the step completes where it must."""
        self._enter(w, self._scalars, not self._some_of_nodes)

    def enter(self, w: "Workspace") -> None:
        """Enter all of them, in the phases at BEGIN, into a workspace."""
        self._enter(w, self.at(w.state(BEGIN, w.phases.copy())), True)

    def search(self, w: "Workspace") -> None:
        """Enter those in whose corrections Newton's iteration searches into a workspace, and those at corners.

        These are all of the workspace if it is ``strict``.
        """
        light = w.array("light") if w.record["strict"][0] and w.record["n_light"][0] else self._at_corners[:0]
        found = distinct(np.concatenate([light, self._at_corners]))
        w.point_to(n_searched=len(found), searched=found)

    def _enter(self, w, light, known):
        w.point_to(n_light=len(light), light=light, knows_light=known)
        self.search(w)
        if len(light) and self._relax is None and w.record["tolerance"][0] < np.inf:
            from mecano.solve.time.relaxed_error import relax_error  # compiled for such runs only

            self._relax = relax_error.call_from_compiled_code(w.record)
            w.point_to(relax=self._relax.function, relax_words=self._relax.words)


def held_by_lines(system: "System", i: int) -> tuple[str, ...]:
    """Return the titles of the lines on the unknown ``i`` if nothing else holds it.

    Lines are elements whose force has one sign only (``Event.one_sided``). Loads hold nothing.
    """
    on_it: dict[str, None] = {}
    lines: set[str] = set()
    for b in system.batches:
        if any(event.one_sided for event in b.kind.events):
            lines.update(b.names)
        if b.kind.acts and b.kind.section != "loads":
            on_it |= {b.names[e]: None for e in np.flatnonzero((b.dofs == i).any(axis=1))}
    return tuple(on_it) if lines.issuperset(on_it) else ()


def loose_knots(system: "System", s: "State", length: float) -> dict[str, tuple[str, ...]]:
    """Return {place: titles of its lines} of the nodes without mass that only lines hold at ``s``."""
    of = system.numbering
    first = {of.name[i].place: i for i in massless_unknowns(system, s, length) if of.kind[i] == TRANSLATION}
    found = {place: held_by_lines(system, i) for place, i in first.items()}
    return {place: lines for place, lines in found.items() if lines}


def unknowns_at_corners(system: "System") -> np.ndarray:
    """Return the indices (n,), ascending, of positions and rotations on which elements with corners act."""
    acted_on = [b.dofs[b.kind.cornered(b.p)].ravel() for b in system.batches if b.kind.cornered is not None]
    found = distinct(np.concatenate([*acted_on, np.zeros(0, np.int64)]).astype(np.int64))
    kind = system.numbering.kind[found]
    return found[(found < system.n_q) & ((kind == TRANSLATION) | (kind == ROTATION))]


def _heavy(system):
    """Return (n_q,) bool: whether an unknown belongs to a node of an element with mass."""
    heavy = np.zeros(system.numbering.n_all, bool)
    for b in system.batches:
        if "mass" in (b.p.dtype.names or ()):
            heavy[b.dofs[b.p["mass"] > 0.0, : 3 * len(b.kind.layout)]] = True
    return heavy[: system.n_q]

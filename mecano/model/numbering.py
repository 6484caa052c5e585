"""Numbering of the unknowns: shared positions and rotations, free and fixed ones, and the names of the equations.

Position and rotation of a node are numbered separately, so that joints can share one of them (Boolean
identification, Cardona, Geradin & Doan 1991, section 3.1).
"""

from collections.abc import Iterable, Sequence, Set
from typing import NamedTuple, Self

import numpy as np

from mecano.element_interface import Row
from mecano.immutable import mutable
from mecano.jit.entry import Indices

TRANSLATION, ROTATION, SCALAR, LENGTH_CONSTRAINT, ANGLE_CONSTRAINT = range(5)
SIGNAL, STATE = 5, 6  # an algebraic signal, and one whose equation gives its rate
MASSLESS = -1  # replaces SCALAR, for solvers, for a scalar without inertia
RELEASED = -2  # replaces the kind of a constraint, for solvers, if its row states that reactions are shared
AXES = "xyz"


class EquationName(str):
    """Name of an equation for users, "place: what", with its constituents.

    Attributes
    ----------
    place : str
        The nodes, joint or element to which it belongs.
    what : str
        Its force, moment, scalar or constraint.
    nodes : tuple of str
        Names of the nodes that share it; empty if it belongs to an element.
    """

    __slots__ = ("_moves", "nodes", "place", "what")
    place: str
    what: str
    nodes: tuple[str, ...]
    _moves: str

    def __new__(cls, place: str, what: str, moves: str = "", nodes: tuple[str, ...] = ()) -> Self:
        """Make a name; ``moves`` is the displacement or rotation to which a force or moment of a node belongs."""
        name = super().__new__(cls, f"{place}: {what}")
        name.place, name.what, name.nodes, name._moves = place, what, nodes, moves
        return name

    @property
    def motion(self) -> "EquationName":
        """Name of the motion of its unknown: "node tip: displacement x" for "node tip: force x"."""
        return EquationName(self.place, self._moves, self._moves, self.nodes) if self._moves else self


class Classes:
    """Disjoint sets of indices that denote the same unknown."""

    def __init__(self, n: int):
        self.parent = list(range(n))

    def find(self, i: int) -> int:
        """Return the representative (first member) of the set of i."""
        while self.parent[i] != i:
            self.parent[i] = self.parent[self.parent[i]]
            i = self.parent[i]
        return i

    def join(self, i: int, j: int) -> None:
        """Merge the sets of i and j; the lower index represents both."""
        i, j = sorted((self.find(i), self.find(j)))
        self.parent[j] = i


class Unknowns(NamedTuple):
    """Unknowns in z: a Numbering as an argument of compiled code."""

    kind: Indices
    rotation_dof: Indices
    n_q: int
    n: int


@mutable
class Numbering:
    """Indices of all unknowns in z; see state.py for the order."""

    n_q: int  # free degrees of freedom
    n_l: int  # multipliers
    n_all: int
    x: np.ndarray  # (n_nodes,) index of the first of the 3 entries of the position of each node
    r: np.ndarray  # (n_nodes,) index of the first of the 3 entries of its rotation
    rotation: np.ndarray  # (n_nodes,) index of its rotation matrix
    rotation_dof: np.ndarray  # (n_rotations,) index of the first entry of each rotation
    n_scalars: int  # scalar unknowns of elements, including signals: the last of the n_q
    kind: np.ndarray  # (n_all,) TRANSLATION ... STATE
    group: np.ndarray  # (n_q,) group number: unknowns of one node share it
    name: Sequence[EquationName]  # (n_all,) EquationName
    of_rates: np.ndarray  # (n_l,) bool: constraint on velocities

    @property
    def n(self) -> int:
        """Number of equations."""
        return self.n_q + self.n_l


class _Entries(Sequence):
    """Entries of z: kinds, the first entry of each class of shared unknowns, and, as a sequence, their EquationNames.

    Names are made on request: a large model has many, and few are used.
    """

    def __init__(self, sharing):
        self.kind, self.first, self.sharing, self._names = [], {}, sharing, []

    def add(self, names, kinds):
        self._names += names
        self.kind += kinds

    def add_class(self, c):
        self.first[c] = len(self._names)
        self.add([(c, axis) for axis in range(3)], [ROTATION if c % 2 else TRANSLATION] * 3)

    def __len__(self):
        return len(self._names)

    def __getitem__(self, i):
        if isinstance(i, slice):
            return [self[j] for j in range(*i.indices(len(self)))]
        found = self._names[i]
        return _names(self.sharing[found[0]], found[0])[found[1]] if type(found) is tuple else found


def number(
    nodes: Sequence[str],
    used: Set[tuple[str, int]],
    shared: Iterable[tuple[str, int, int]],
    fixed: Set[int],
    scalars: Sequence[tuple[EquationName, int]],
    multipliers: Sequence[tuple[EquationName, Row]],
) -> Numbering:
    """Return the Numbering of all unknowns.

    nodes: names; used: set of ("x" or "R", node index) of the unknowns that elements act on; shared: list of
    ("x" or "R", i, j); fixed: set of node indices; scalars: list of (EquationName, kind);
    multipliers: list of (EquationName, Row).
    """
    of = _classes(len(nodes), shared)
    sharing: dict[int, list[str]] = {}  # class -> names of its nodes
    for i, c in enumerate(of):
        sharing.setdefault(c, []).append(nodes[i // 2])
    members, free, entries = sorted(sharing), _free(of, used, fixed), _Entries(sharing)
    for c in free:
        entries.add_class(c)
    entries.add([name for name, _ in scalars], [kind for _, kind in scalars])
    n_q = len(entries)
    units = [row.constraint_unit for _, row in multipliers]
    kinds = [ANGLE_CONSTRAINT if unit[:3] == "rad" else LENGTH_CONSTRAINT for unit in units]
    entries.add([text for text, _ in multipliers], kinds)
    for c in members:
        if c not in entries.first:
            entries.add_class(c)
    rotations = [c for c in members if c % 2]
    index = {c: i for i, c in enumerate(rotations)}
    group = [c // 2 for c in free for _ in AXES] + [len(nodes) + i for i in range(len(scalars))]
    return Numbering(
        n_q=n_q,
        n_l=len(multipliers),
        n_all=len(entries),
        n_scalars=len(scalars),
        x=np.array([entries.first[c] for c in of[::2]], np.int64),
        r=np.array([entries.first[c] for c in of[1::2]], np.int64),
        rotation=np.array([index[c] for c in of[1::2]], np.int64),
        rotation_dof=np.array([entries.first[c] for c in rotations], np.int64),
        kind=np.array(entries.kind, np.int64),
        group=np.array(group, np.int64),
        name=entries,
        of_rates=np.array([unit.endswith("/s") for unit in units], bool),
    )


def _classes(n_nodes, shared):
    """Return the class (2 n_nodes,) of the position (even indices) and the rotation (odd indices) of each node."""
    classes = Classes(2 * n_nodes)
    for what, i, j in shared:
        classes.join(2 * i + (what == "R"), 2 * j + (what == "R"))
    return np.array([classes.find(i) for i in range(2 * n_nodes)], np.int64)


def _free(of, used, fixed):
    """Return the classes, ascending, that elements act on and that contain no fixed node."""
    held = {of[2 * i + k] for i in fixed for k in (0, 1)}
    return sorted({of[2 * i + (what == "R")] for what, i in used} - held)


def _names(sharing, c):
    """Return the names of the three entries of the class c, which list all nodes that share it."""
    what, moves = ("moment about material", "rotation about material") if c % 2 else ("force", "displacement")
    place, nodes = f"node {', '.join(sharing)}", tuple(sharing)
    return [EquationName(place, f"{what} {axis}", f"{moves} {axis}", nodes) for axis in AXES]

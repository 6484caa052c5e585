"""Numbers for the unknowns: which nodes share a position or a rotation, which are free, and what each is called.

Position and rotation of a node are numbered separately, so that joints can share one of them (Boolean
identification, Cardona, Geradin & Doan 1991, section 3.1).
"""

from dataclasses import dataclass

import numpy as np

TRANSLATION, ROTATION, SCALAR, LENGTH_CONSTRAINT, ANGLE_CONSTRAINT = range(5)
AXES = "xyz"


class Classes:
    """Disjoint sets of things that are one and the same unknown."""

    def __init__(self, n):
        self.parent = list(range(n))

    def find(self, i):
        """The first member of the set of i."""
        while self.parent[i] != i:
            self.parent[i] = self.parent[self.parent[i]]
            i = self.parent[i]
        return i

    def join(self, i, j):
        """Make i and j one; the lower number represents both."""
        i, j = sorted((self.find(i), self.find(j)))
        self.parent[j] = i


@dataclass
class Numbering:
    """Where everything stands in z; see state.py for the order."""

    n_q: int  # free degrees of freedom
    n_l: int  # multipliers
    n_all: int
    x: np.ndarray  # (n_nodes,) first of the 3 entries of the position of each node
    r: np.ndarray  # (n_nodes,) first of the 3 entries of its rotation
    rotation: np.ndarray  # (n_nodes,) index of its rotation matrix
    rotation_dof: np.ndarray  # (n_rotations,) first entry of each rotation
    kind: np.ndarray  # (n_all,) TRANSLATION ... ANGLE_CONSTRAINT
    group: np.ndarray  # (n_q,) unknowns of one node have one number
    name: list  # (n_all,) names a user can read

    @property
    def n(self):
        """Number of equations."""
        return self.n_q + self.n_l


def number(nodes, used, shared, fixed, scalars, multipliers):
    """Number all unknowns.

    nodes: names; used: set of ("x" or "R", node index) that some element works on; shared: list of
    ("x" or "R", i, j); fixed: set of node indices; scalars: names; multipliers: list of (name, Row).
    """
    n_nodes = len(nodes)
    classes = Classes(2 * n_nodes)
    for what, i, j in shared:
        classes.join(2 * i + (what == "R"), 2 * j + (what == "R"))
    of = np.array([classes.find(i) for i in range(2 * n_nodes)])
    held = {of[2 * i + k] for i in fixed for k in (0, 1)}
    working = {of[2 * i + (what == "R")] for what, i in used}
    members = sorted(set(of))
    free = [c for c in members if c in working and c not in held]
    rest = [c for c in members if not (c in working and c not in held)]

    sharing = {c: [] for c in members}
    for i in range(2 * n_nodes):
        sharing[of[i]].append(nodes[i // 2])
    first, name, kind, group = {}, [], [], []
    for c in free:
        first[c] = len(name)
        name += _names(sharing[c], c)
        kind += [ROTATION if c % 2 else TRANSLATION] * 3
        group += [c // 2] * 3
    name += scalars
    kind += [SCALAR] * len(scalars)
    group += range(n_nodes, n_nodes + len(scalars))
    n_q = len(name)
    name += [text for text, _ in multipliers]
    kind += [ANGLE_CONSTRAINT if row.constraint_unit == "rad" else LENGTH_CONSTRAINT for _, row in multipliers]
    for c in rest:
        first[c] = len(name)
        name += _names(sharing[c], c)
        kind += [ROTATION if c % 2 else TRANSLATION] * 3

    rotations = [c for c in members if c % 2]
    index = {c: i for i, c in enumerate(rotations)}
    return Numbering(
        n_q=n_q,
        n_l=len(multipliers),
        n_all=len(name),
        x=np.array([first[of[2 * i]] for i in range(n_nodes)], np.int64),
        r=np.array([first[of[2 * i + 1]] for i in range(n_nodes)], np.int64),
        rotation=np.array([index[of[2 * i + 1]] for i in range(n_nodes)], np.int64),
        rotation_dof=np.array([first[c] for c in rotations], np.int64),
        kind=np.array(kind, np.int64),
        group=np.array(group, np.int64),
        name=name,
    )


def motion_name(name):
    """What moves where the equation of a node is called ``name``: "node tip: displacement x" for "node tip: force x"."""
    for equation, motion in (
        (": force ", ": displacement "),
        (": moment about material ", ": rotation about material "),
    ):
        name = name.replace(equation, motion)
    return name


def _names(sharing, c):
    """Names of the three entries of the class c, after all nodes that share it."""
    what = "moment about material {}" if c % 2 else "force {}"
    return [f"node {', '.join(sharing)}: {what.format(axis)}" for axis in AXES]

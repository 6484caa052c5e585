"""The numbers of one instant as one flat row: motion of the nodes, outputs of the elements, energies."""

import math
from dataclasses import dataclass

import numpy as np

from mecano.compiled.entry import Indices, Matrices, Vector, entry
from mecano.maths.so3 import quaternion
from mecano.maths.vec import mat, mul, put, vec


@dataclass(frozen=True)
class Column:
    """A named quantity of the row, with its unit and meaning; ``shape`` () or (3,) or (4,)."""

    path: str
    unit: str
    doc: str
    shape: tuple
    start: int

    @property
    def size(self):
        """How many numbers it is."""
        return math.prod(self.shape)


NODE_OUTPUTS = (
    ("position", "m", "position, inertial", (3,)),
    ("rotation", "-", "unit quaternion (w, x, y, z) of the rotation from material to inertial axes", (4,)),
    ("velocity", "m/s", "velocity, inertial", (3,)),
    ("angular_velocity", "rad/s", "angular velocity, inertial", (3,)),
)
ENERGIES = (
    ("kinetic", "J", "kinetic energy"),
    ("potential", "J", "potential energy of gravity and of elastic forces"),
    ("dissipated", "J", "energy dissipated since the start"),
    ("given", "J", "work done by loads and prescribed motions since the start"),
    ("total", "J", "kinetic + potential"),
    (
        "balance",
        "J",
        "kinetic + potential + dissipated - given; keeps its value of the start, up to integration errors",
    ),
)


def row_size(system):
    """How many numbers the row of a System has."""
    nodes = sum(not node.internal for node in system.nodes) * sum(math.prod(shape) for *_, shape in NODE_OUTPUTS)
    return nodes + sum(len(b.paths) * b.n_outputs for b in system.batches) + len(ENERGIES)


class Sampler:
    """Builds the row; ``columns`` describe it."""

    def __init__(self, system):
        self.system, self.columns = system, []
        of = system.numbering
        shown = [i for i, node in enumerate(system.nodes) if not node.internal]
        self.nodes = tuple(np.array([table[i] for i in shown], np.int64) for table in (of.x, of.r, of.rotation))
        for i in shown:
            self._declare(f"nodes/{system.nodes[i].name}", NODE_OUTPUTS)
        self.node_size = self._size()
        self.batches = [b for b in system.batches if b.n_outputs]
        for b in self.batches:
            for path, label in b.paths:
                self._declare(path, [(o.name + label, o.unit, o.doc, o.shape) for o in b.kind.outputs])
        self.energy_start = self._size()
        self._declare("energy", [(*item, ()) for item in ENERGIES])
        self.row = np.zeros(self._size())

    def _size(self):
        return self.columns[-1].start + self.columns[-1].size if self.columns else 0

    def _declare(self, path, outputs):
        start = self._size()
        for name, unit, doc, shape in outputs:
            self.columns.append(Column(f"{path}/{name}", unit, doc, tuple(shape), start))
            start += self.columns[-1].size

    def take(self, run):
        """The row at ``run.motion``, whose outputs stand in the batches (system.observe); the array is reused."""
        s, row = run.motion, self.row
        kinetic, potential = self.system.energy[:2].tolist()
        _node_rows(*self.nodes, s.z, s.v, s.R, row)
        i = self.node_size
        for b in self.batches:
            row[i : i + b.y.size] = b.y.ravel()
            i += b.y.size
        total = kinetic + potential
        row[i:] = kinetic, potential, run.dissipated, run.given, total, total + run.dissipated - run.given
        return row


@entry
def _node_rows(x: Indices, r: Indices, rotation: Indices, z: Vector, v: Vector, R: Matrices, row_out: Vector):
    """Position, quaternion, velocity, inertial angular velocity of each node, 13 numbers each."""
    for i in range(x.shape[0]):
        A = mat(R[rotation[i]])
        j = 13 * i
        put(row_out, j, vec(z, x[i]))
        w = quaternion(A)
        for k in range(4):
            row_out[j + 3 + k] = w[k]
        put(row_out, j + 7, vec(v, x[i]))
        put(row_out, j + 10, mul(A, vec(v, r[i])))

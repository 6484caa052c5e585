"""All output values at one instant as a flat row: motion of the nodes, outputs of the elements, energies."""

import math
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from mecano.jit.entry import Indices, Table, Vector, entry
from mecano.jit.kernel import kernel
from mecano.maths.hermite import between, hermite, is_smooth
from mecano.maths.so3 import quaternion
from mecano.maths.vector import mat, put, vec
from mecano.model.state import Motion, State

if TYPE_CHECKING:
    from mecano.model.assembly import Observation
    from mecano.model.system import System

QUATERNION = (4,)


class Column(NamedTuple):
    """A named quantity of the row, with its unit and meaning; ``shape`` is (), (3,) or (4,)."""

    path: str
    unit: str
    doc: str
    shape: tuple[int, ...]
    start: int
    rate: str = ""  # path of the quantity that is its time derivative
    geometric: bool = False  # follows from positions, rotations and time alone

    @property
    def size(self) -> int:
        """Number of values."""
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
    ("balance", "J", "kinetic + potential + dissipated - given; constant up to integration errors"),
)


def row_size(system: "System") -> int:
    """Return the number of values in the row of a System."""
    nodes = sum(not node.internal for node in system.nodes) * sum(math.prod(shape) for *_, shape in NODE_OUTPUTS)
    return nodes + sum(len(b.paths) * b.n_outputs for b in system.batches) + len(ENERGIES)


class Sampled(Protocol):
    """A motion with the work since the start, such as a RunState."""

    motion: State
    dissipated: float  # [J]
    given: float  # [J]


class StaticSample:
    """A motion without dissipated and supplied work, for the sampler."""

    dissipated = 0.0
    given = 0.0

    def __init__(self, motion: State):
        self.motion = motion


class Sampler:
    """Builder of the row; ``columns`` describe it, ``starts`` are the indices of their first numbers by path."""

    def __init__(self, system: "System"):
        self.system, self.columns, units = system, [], system.signal_units
        of = system.numbering
        shown = [i for i, node in enumerate(system.nodes) if not node.internal]
        self.nodes = Nodes(*(np.array([table[i] for i in shown], np.int64) for table in (of.x, of.r, of.rotation)))
        for i in shown:
            self._declare(f"nodes/{system.nodes[i].name}", [(*item, "", False) for item in NODE_OUTPUTS])
        self.node_size = self._size()
        for b in system.batches:
            for path, label in b.paths:
                self._declare(
                    path, [_labelled(o, label, units.get(f"{path}/{o.name}", o.unit)) for o in b.kind.outputs]
                )
        self._declare("energy", [(*item, (), "", False) for item in ENERGIES])
        self.row = np.zeros(self._size())
        self._fill = fill.bind(self.row, self.nodes)
        self.starts = {column.path: column.start for column in self.columns}
        rated = [(column.start, self.starts[column.rate], column.size) for column in self.columns if column.rate]
        pairs = [(first + i, rate + i) for first, rate, size in rated for i in range(size)]
        self.pairs = np.array(pairs, np.int64).reshape(-1, 2)
        turned = [c.start for c in self.columns if c.shape == QUATERNION and c.start >= self.node_size]
        self.rotations = np.array(turned, np.int64)
        placed = [c.start + i for c in self.columns if c.geometric for i in range(c.size)]
        self.geometric = np.array(placed, np.int64)

    def _size(self):
        return self.columns[-1].start + self.columns[-1].size if self.columns else 0

    def _declare(self, path, outputs):
        start = self._size()
        for name, unit, doc, shape, rate, geometric in outputs:
            rate = rate and f"{path}/{rate}"
            self.columns.append(Column(f"{path}/{name}", unit, doc, tuple(shape), start, rate, geometric))
            start += self.columns[-1].size

    def take(self, run: Sampled, observation: "Observation") -> np.ndarray:
        """Return the row (row_size,) at ``run.motion``, with its ``observation``. The array is reused."""
        self._fill(observation, run.motion, run.dissipated, run.given)
        return self.row


def _labelled(output, label, unit):
    """Return name, unit, meaning, shape and rate of an Output of one element, and whether it is geometric."""
    rate = output.rate and output.rate + label
    return output.name + label, unit or output.unit, output.doc, output.shape, rate, output.geometric


@entry
def blend(
    u: float, h: float, first: int, pairs: Table, rotations: Indices, row0: Vector, row1: Vector, row_out: Vector
):  # fmt: skip
    """Interpolate the row from ``first`` on; ``pairs`` (m, 2) of coordinate and rate; ``rotations``: quaternions."""
    for i in range(first, row0.shape[0]):
        row_out[i] = between(u, row0[i], row1[i])
    for k in range(pairs.shape[0]):
        i, j = pairs[k, 0], pairs[k, 1]
        x0, x1, v0, v1 = row0[i], row1[i], row0[j], row1[j]
        if is_smooth(h, x0, x1, v0, v1):
            row_out[i], row_out[j] = hermite(u, h, x0, x1, v0, v1)
    for k in range(rotations.shape[0]):
        _turn(u, rotations[k], row0, row1, row_out)


@kernel
def _turn(u, i, row0, row1, row_out):
    """Interpolate the unit quaternion at index i along the shorter arc."""
    alike = square = 0.0
    for k in range(i, i + 4):
        alike += row0[k] * row1[k]
    for k in range(i, i + 4):
        row_out[k] = (1.0 - u) * row0[k] + math.copysign(u, alike) * row1[k]
        square += row_out[k] * row_out[k]
    for k in range(i, i + 4):
        row_out[k] /= math.sqrt(square)


class Nodes(NamedTuple):
    """Index of the motion of each node in the row (n_nodes,)."""

    x: Indices  # in z
    r: Indices  # in v
    rotation: Indices  # in R


class Observed(NamedTuple):
    """The arrays of an Observation."""

    outputs: Vector
    energy: Vector


@entry
def fill(row_out: Vector, nodes: Nodes, observed: Observed, s: Motion, dissipated: float, given: float):
    """Write the motion of the nodes, the outputs of the elements, and the ENERGIES into the row."""
    node_rows(nodes, s, row_out)
    outputs, kinetic, potential = observed.outputs, observed.energy[0], observed.energy[1]
    energies = kinetic, potential, dissipated, given, kinetic + potential, kinetic + potential + dissipated - given
    first = row_out.shape[0] - len(energies)
    for i in range(outputs.shape[0]):
        row_out[first - outputs.shape[0] + i] = outputs[i]
    for i in range(len(energies)):
        row_out[first + i] = energies[i]


@entry
def node_rows(nodes: Nodes, s: Motion, row_out: Vector):
    """Write position, quaternion, velocity, inertial angular velocity of each node, 13 numbers each."""
    for i in range(nodes.x.shape[0]):
        A = mat(s.R[nodes.rotation[i]])
        j = 13 * i
        put(row_out, j, vec(s.z, nodes.x[i]))
        w = quaternion(A)
        for k in range(4):
            row_out[j + 3 + k] = w[k]
        put(row_out, j + 7, vec(s.v, nodes.x[i]))
        put(row_out, j + 10, A @ vec(s.v, nodes.r[i]))

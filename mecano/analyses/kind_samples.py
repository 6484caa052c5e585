"""Samples of every registered kind, expanded into single elements that can be evaluated and moved."""

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from dataclasses import field as value_of
from typing import TypeAlias

import numpy as np
from scipy.spatial.transform import Rotation

from mecano.element_interface import Context, Kind, Place
from mecano.element_interface.records import with_attributes
from mecano.elements import KINDS
from mecano.jit.null_matrix import NULL_MATRIX, NullMatrix
from mecano.laws.law_table import LawTable
from mecano.maths.dual import Dual
from mecano.maths.dual import value as number_in
from mecano.model.mesh import Frame
from mecano.schema import Values

GRAVITY = np.array([0.7, -0.4, -9.3])
BEYOND = 30  # places after the outputs that must stay empty
K_SCALE, PENALTY = 1.7, 2.3  # k and penalty of the constraints
SENSED = 0.3  # value of a sensor
SPREAD = 0.05  # of the random states about the nodes of a sample [m, rad]

Local: TypeAlias = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""q, v, a (n_local,) and R (n_rotations, 3, 3) of an element, as defined in element_interface"""


EYES = np.cross(np.eye(3)[:, None], np.eye(3)).transpose(2, 1, 0)  # EYES @ a = hat(a), which turns b into a x b


def duals(values: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Return an array of Duals."""
    out = np.empty(values.shape, object)
    for place in np.ndindex(values.shape):
        out[place] = Dual(values[place], slopes[place])  # type: ignore[arg-type]  # a slope may have many directions
    return out


@dataclass
class Motion:
    """Nodes in motion; material angular velocities and accelerations, everything else inertial."""

    t: float
    x: np.ndarray  # (n, 3, 3): node; position, velocity, acceleration; component
    R: np.ndarray  # (n, 3, 3)
    turn: np.ndarray  # (n, 3, 3): node; zero, velocity, acceleration; component

    def after(self, h: float) -> "Motion":
        """Return the motion h seconds later, exact to second order."""
        x, turn = self.x.copy(), self.turn.copy()
        x[:, 0] += h * x[:, 1] + 0.5 * h * h * x[:, 2]
        increments = h * turn[:, 1] + 0.5 * h * h * turn[:, 2]
        for rates in (x, turn):
            rates[:, 1] += h * rates[:, 2]
        return Motion(self.t + h, x, self.R @ Rotation.from_rotvec(increments).as_matrix(), turn)

    def moved(self, Q: np.ndarray, shift: np.ndarray) -> "Motion":
        """Return the same motion rotated by Q (3, 3) and shifted."""
        x = self.x @ Q.T
        x[:, 0] += shift
        return Motion(self.t, x, Q @ self.R, self.turn.copy())


@dataclass
class Instance:
    """One element, constraint or joint on its nodes, with its functions."""

    kind: Kind
    p: np.ndarray  # (1,) record
    nodes: tuple[int, ...]
    phase: int
    memory: np.ndarray
    laws: np.ndarray
    scalars: np.ndarray  # (3, n_scalars) values, rates, second rates; then those of its inputs
    multipliers: np.ndarray  # k lambda
    coupled: "list[Instance]" = value_of(default_factory=list)  # instances whose multipliers it sees

    def local(self, motion: Motion) -> Local:
        """Return (q, v, a, R) as defined in element_interface."""
        slots, R = [], []
        for slot in self.kind.layout:
            node = self.nodes[int(slot[1:])]
            slots.append((motion.x if slot[0] == "x" else motion.turn)[node])
            R += [motion.R[node]] if slot[0] == "R" else []
        reactions = np.concatenate([self.multipliers, *(other.multipliers for other in self.coupled)])
        q, v, a = np.concatenate([*slots, self.scalars, np.zeros((3, len(reactions)))], axis=1)
        q[len(q) - len(reactions) :] = reactions
        return q, v, a, np.array(R).reshape(-1, 3, 3)

    def after(self, h: float) -> "Instance":
        """Return the instance with its scalars h seconds later."""
        s = self.scalars
        later = np.array([s[0] + h * s[1] + 0.5 * h * h * s[2], s[1] + h * s[2], s[2]])
        return Instance(**{**vars(self), "scalars": later})

    def run(
        self,
        name: str,
        t: float | Dual,
        state: Local,
        *out: np.ndarray | NullMatrix,
        k: float = 1.0,
        penalty: float = 0.0,
    ) -> None:
        """Call the function ``name`` of the kind as plain Python, without compilation."""
        with np.errstate(divide="ignore", invalid="ignore"):  # as in compiled code
            at = Place(t, self.phase, k, penalty, self.laws, self.memory, *state)  # type: ignore[arg-type]  # or Duals
            getattr(self.kind, name)(with_attributes(self.p[0]), at, *out)

    @property
    def is_idle(self) -> bool:
        """True in a phase in which it has no force."""
        return self.kind.phases[self.phase] in self.kind.idle

    def force(self, t: float, state: Local, k: float = 1.0, penalty: float = 0.0) -> tuple[np.ndarray, ...]:
        """Return f, K, C, M at the local ``state`` (q, v, a, R)."""
        if self.kind.residual is not None:
            return self._dual_force(t, state, k, penalty)
        n = self.kind.n_local
        out = (np.zeros(n), np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n)))
        self.run("force", t, state, *out, k=k, penalty=penalty)
        return out

    def residual(self, t: float, state: Local, k: float = 1.0, penalty: float = 0.0) -> np.ndarray:
        """Return f alone, as the model computes it where no tangents are needed."""
        f = np.zeros(self.kind.n_local)
        if self.kind.residual is not None:
            if not self.is_idle:
                self.run("residual", t, state, f, k=k, penalty=penalty)
        else:
            self.run("force", t, state, f, NULL_MATRIX, NULL_MATRIX, NULL_MATRIX, k=k, penalty=penalty)
        return f

    def _dual_force(self, t, state, k, penalty):
        """Return f, K, C and M of a kind with a ``residual``, by dual numbers."""
        q, v, a, R = state
        n, f = self.kind.n_local, np.zeros(self.kind.n_local)
        if self.is_idle:
            return f, *np.zeros((3, n, n))
        end = n - len(self.kind.multipliers) - len(self.kind.coupled_multipliers)
        self.run("residual", t, state, f, k=k, penalty=penalty)
        seeds = np.eye(3 * n).reshape(3, n, 3 * n)
        turns = [np.einsum("ijk,kl->ijl", EYES, seeds[0, c : c + 3]) for c in self.rotation_columns()]
        slopes = np.array([np.einsum("ij,jkl->ikl", *both) for both in zip(R, turns, strict=True)])
        out = duals(np.zeros(n), np.zeros((n, 3 * n)))
        of_q, of_v, of_a = (duals(x, seed) for x, seed in zip((q, v, a), seeds, strict=True))
        self.run("residual", t, (of_q, of_v, of_a, duals(R, slopes)), out, k=k, penalty=penalty)
        np.testing.assert_array_equal([x.value for x in out], f)
        found = np.array([np.broadcast_to(x.slope, 3 * n) for x in out]).reshape(n, 3, n)
        tangents = found.transpose(1, 0, 2).copy()
        tangents[0, :, end:] *= k
        tangents[1:, :, end:] = 0.0
        return f, *tangents

    def along(self, t: float, state: Local, direction: np.ndarray) -> np.ndarray:
        """Return f of a sensor of the value SENSED as Duals along the ``direction`` (2, n) of q and v of ``state``."""
        q, v, a, R = state
        n = self.kind.n_local
        values = np.append(q, SENSED), np.append(v, 0.0)
        of_q, of_v = (duals(x, np.append(d, 0.0)) for x, d in zip(values, direction, strict=True))
        out = duals(np.zeros(n), np.zeros(n))
        self.run("residual", t, (of_q, of_v, np.append(a, 0.0), duals(R, self._rotation_slopes(R, direction[0]))), out)
        return out

    def inertia(self, t: float, state: Local) -> np.ndarray:
        """Return the diagonal of M as a kind with a ``residual`` writes it, (n_local,)."""
        m = np.zeros(self.kind.n_local)
        if self.kind.inertia is not None:
            self.run("inertia", t, state, m)
        return m

    def rotation_columns(self) -> list[int]:
        """Return the first column in q of each rotation."""
        return [3 * i for i, slot in enumerate(self.kind.layout) if slot[0] == "R"]

    def _rotation_slopes(self, R, direction):
        """Return the derivatives of the rotations R along a ``direction`` (n_local,) of the unknowns."""
        slopes = [R_r @ (EYES @ direction[c : c + 3]) for R_r, c in zip(R, self.rotation_columns(), strict=True)]
        return np.array(slopes).reshape(R.shape)

    def constraint_derivatives(self, t: float, state: Local) -> np.ndarray:
        """Return the constraint derivatives (n_multipliers, 3)."""
        g = np.zeros((len(self.kind.multipliers), 3))
        if self.kind.constraints is not None:
            q, v, a, R = state
            out = duals(g[:, :2], g[:, :2])
            rotations = duals(R, self._rotation_slopes(R, v))
            self.run("constraints", Dual(t, 1.0), (duals(q, v), duals(v, a), a, rotations), out)
            g[:] = [(number_in(x), number_in(rate), getattr(rate, "slope", 0.0)) for x, rate in out]
        return g

    def observe(self, t: float, state: Local, F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return outputs (n_outputs,) and energies (4,)."""
        n = sum(output.size for output in self.kind.outputs)
        y, e = np.zeros(n + BEYOND), np.zeros(4)
        if self.kind.observe is not None:
            self.run("observe", t, state, F, y, e)
        if self.is_idle:
            y[list(self.kind.idle[self.kind.phases[self.phase]])], e[:] = 0.0, 0.0
        assert not y[n:].any(), "more outputs are written than declared"
        return y[:n].copy(), e

    def written(self, name: str, size: int, t: float, state: Local) -> np.ndarray:
        """Return the numbers (size,) that ``event_values`` or ``commit`` writes."""
        out = np.zeros(size)
        self.run(name, t, state, out)
        return out


@dataclass
class Sample:
    """One sample of a kind: the element itself, then its parts, in a random motion near its nodes."""

    name: str
    values: Values
    nodes: list[Frame]
    phase: str
    instances: list[Instance]
    motion: Motion

    @property
    def in_phase(self) -> str:
        """The phase as the end of a message; "" for a kind without phases."""
        return f", in the phase '{self.phase}'" if self.phase else ""


def seed_of(name: str) -> np.random.Generator:
    """Return a random generator for each name, the same in every run."""
    return np.random.default_rng(zlib.crc32(name.encode()))


def samples(kind: Kind) -> list[Sample]:
    """Return all samples of a kind."""
    rng = seed_of(kind.name)
    found = []
    given = kind.samples(rng)
    for i, (values, nodes, phase) in enumerate([*given, *given[: kind.apart is not None]]):
        defaults = {field.name: field.default for field in kind.fields if not field.required}
        values = {**defaults, **values}
        if isinstance(nodes, int):
            nodes = _random_nodes(kind, values, nodes, rng, turned_apart=i == len(given))
        instances = expand(kind, values, nodes, phase, GRAVITY, rng)
        found.append(Sample(kind.name, values, nodes, phase, instances, _motion(kind, values, nodes, rng)))
    return found


def _random_nodes(kind, values, n, rng, turned_apart):
    """Return n nodes (x (3,), R (3, 3)), of which those of a joint share unknowns, but no rotation if turned apart."""
    nodes = [(rng.normal(size=3), Rotation.random(None, rng).as_matrix()) for _ in range(n)]
    for what, i, j in kind.shares(values, nodes):
        (x_i, R_i), (x_j, R_j) = nodes[i], nodes[j]
        nodes[j] = (x_i, R_j) if what == "x" else (x_j, R_j if turned_apart else R_i)
    return nodes


def elements(kind: Kind) -> list[tuple[Sample, Instance]]:
    """Return [(sample, instance)] of all instances with a force in the samples of a kind."""
    return [(s, i) for s in samples(kind) for i in s.instances if i.kind.acts]


def expand(
    kind: Kind, values: Values, nodes: Sequence[Frame], phase: str, gravity: np.ndarray, rng: np.random.Generator
) -> list[Instance]:
    """Return [Instance]: the element and its parts, with random scalars and multipliers."""
    laws, kind = LawTable(), kind.placed(values, nodes)
    context = Context(laws, gravity, KINDS)
    own = kind.record_values(values, nodes, context) if kind.section else values
    parts = kind.parts(values, nodes, context)
    packed = laws.array()
    listed = [(kind, own, tuple(range(len(nodes))), kind.phases.index(phase))]
    for part in parts:
        follows = len(part.kind.phases) > 1 and part.kind.phases == kind.phases
        listed.append((part.kind, part.parameters, part.nodes, kind.phases.index(phase) if follows else 0))
    instances = []
    for of, record, on, phase_number in listed:
        p = np.zeros(1, of.dtype)
        for key, value in record.items():
            p[key][0] = value
        memory = np.zeros(len(of.memory))
        scalars = 0.1 * rng.normal(size=(3, len(of.scalars) + len(of.inputs)))
        scalars[0, len(of.scalars) :] += 0.3  # inputs of loads that may only push
        multipliers = rng.normal(size=len(of.multipliers))
        instances.append(Instance(of, p, on, phase_number, memory, packed, scalars, multipliers))
    for part, instance in zip(parts, instances[1:], strict=True):
        instance.coupled = [instances[1 + i] for i in part.coupled_to]
        units = [row.unit for other in instance.coupled for row in other.kind.multipliers]
        assert units == [row.unit for row in part.kind.coupled_multipliers]
    if not kind.acts:
        instances[0].coupled = instances[1:]
    return instances


def _motion(kind, values, nodes, rng):
    n = len(nodes)
    x, turn = rng.normal(size=(2, n, 3, 3))
    R = np.array([node[1] for node in nodes]) @ Rotation.from_rotvec(SPREAD * rng.normal(size=(n, 3))).as_matrix()
    x[:, 0] = [node[0] for node in nodes] + SPREAD * x[:, 0]
    turn[:, 0] = 0.0
    for what, i, j in kind.placed(values, nodes).shares(values, nodes):
        if what == "x":
            x[j] = x[i]
        else:
            R[j], turn[j] = R[i], turn[i]
    return Motion(rng.uniform(0.1, 0.9), x, R, turn)

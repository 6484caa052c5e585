"""The model in equations: residual, tangent, constraint levels, outputs, energies, all by batches of one kind."""

from dataclasses import dataclass

import numpy as np

from mecano.contract import Context
from mecano.model import batch as loops
from mecano.model.model import with_ground
from mecano.model.numbering import number
from mecano.model.state import State


@dataclass
class Batch:
    """All elements of one kind: records, tables, compiled loops and work arrays."""

    kind: object
    names: list  # (n,) names of the owners, from the deck
    p: np.ndarray  # (n,) records
    dofs: np.ndarray  # (n, n_local) entries of z
    rots: np.ndarray  # (n, n_rotations) rotation matrices
    slots: np.ndarray  # (n, n_local) force slots
    watched: np.ndarray  # (n, n_watched) entries of z for the outputs
    watched_slots: np.ndarray  # (n, 3 len(layout)) slots of the forces for the outputs
    columns: np.ndarray  # (n_rotations,) local columns of the rotations
    multipliers: np.ndarray  # (n, n_multipliers) numbers of the constraints
    entries: np.ndarray = None  # (n, n_local, n_local) places in the values of the tangent

    def __post_init__(self):
        kind, n = self.kind, self.dofs.shape[1]
        w = max(n, self.watched.shape[1])
        n_rotations = len(self.columns)
        self.work = tuple(np.zeros(w) for _ in "qva") + (np.zeros((n_rotations, 3, 3)),)
        self.matrices = (np.zeros(n), np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n)))
        self.n_outputs = sum(int(np.prod(o.shape, dtype=int)) for o in kind.outputs)
        self.y = np.zeros((len(self.p), self.n_outputs))
        self.e = np.zeros((len(self.p), 4))
        self.F = np.zeros(self.watched_slots.shape[1])

    def loop(self, template, name):
        """The compiled loop for one of the kind's functions, or None when the kind has none."""
        function = getattr(self.kind, name)
        return None if function is None else loops.loop_over(template, function, f"{name}_{self.kind.name}")


class System:
    """Equations of a model; built once, never changed by solving."""

    def __init__(self, model):
        model = with_ground(model)
        self.nodes = model.nodes
        self.context = Context(model.laws, np.asarray(model.gravity, float))
        instances, shared, used = _expand(model, self.context)
        multipliers = [
            (f"{item.title}: {row.name}", row) for item in instances for row in item.kind.multipliers
        ]
        scalars = [f"{item.title}: {name}" for item in instances for name in item.kind.scalars]
        fixed = {i for i, node in enumerate(model.nodes) if node.fixed}
        names = [node.name for node in model.nodes]
        self.numbering = number(names, used, [s[:3] for s in shared], fixed, scalars, multipliers)
        self.n_q, self.n_l, self.n = self.numbering.n_q, self.numbering.n_l, self.numbering.n
        self._slots(len(names))
        sides = _Sides(len(names), shared, self.n_slots)
        self.batches = _batches(instances, self.numbering, self.n_slots - self.n_l, sides)
        self._pattern()
        self.laws = model.laws.array()
        self.side_starts, self.side_members = sides.tables()
        self.force = np.zeros(self.n_slots)
        self._slot_size = np.zeros(self.n_slots)
        self.transmitted = np.zeros(self.n_slots + len(self.side_starts) - 1)
        self.energy = np.zeros(4)  # kinetic, potential [J], dissipated, given power [W] of the last ``observe``
        self.residual = np.zeros(self.numbering.n_all)
        self.size = np.zeros(self.numbering.n_all)
        self._bind()

    def _slots(self, n_nodes):
        """One force slot for each unknown of each node, shared or not; then scalars, then multipliers."""
        of = self.numbering
        three = np.arange(3)
        nodes = np.concatenate([np.stack([of.x, of.r], 1).reshape(-1, 1) + three], axis=1).ravel()
        n_scalars = int(np.sum(of.kind[: of.n_q] == 2))
        rest = np.arange(of.n_q - n_scalars, of.n)
        self.slot_dof = np.concatenate([nodes, rest]) if n_nodes else rest
        self.n_slots = len(self.slot_dof)

    def _pattern(self):
        """Sparse pattern (each entry once, all of the diagonal) and the place of every element entry in it."""
        n = self.n
        codes = [np.arange(n) * (n + 1)]
        for b in self.batches:
            i, j = b.dofs[:, :, None], b.dofs[:, None, :]
            codes.append(np.where((i < n) & (j < n), i * n + j, -1).ravel())
        unique = np.unique(np.concatenate(codes))
        unique = unique[unique >= 0]
        self.rows, self.cols = unique // n, unique % n
        self.nnz = len(unique)
        self.diagonal = np.searchsorted(unique, np.arange(n) * (n + 1))
        for b, code in zip(self.batches, codes[1:], strict=True):
            place = np.where(code >= 0, np.searchsorted(unique, code), self.nnz)
            b.entries = place.reshape(len(b.p), b.dofs.shape[1], b.dofs.shape[1])
        self.data = np.zeros(self.nnz + 1)  # the last entry takes what belongs to fixed unknowns

    def _bind(self):
        """Compiled loops with their constant arguments, in the order in which they are called."""
        self._assembly, self._constraints, self._observers, self._events, self._commits = [], [], [], [], []
        for i, b in enumerate(self.batches):
            if loop := b.loop(loops._assemble, "force"):
                q, v, a, R = b.work
                item = (i, loop, b.p, (b.dofs, b.rots, b.slots, b.columns, b.entries), (q, v, a, R, *b.matrices))
                self._assembly.append(item)
            if loop := b.loop(loops._levels, "levels"):
                g = np.zeros((len(b.kind.multipliers), 3))
                self._constraints.append((i, loop, b.p, (b.dofs, b.rots, b.multipliers), (*b.work, g)))
            if loop := b.loop(loops._observe, "observe"):
                tables = (b.watched, b.rots, b.watched_slots)
                self._observers.append((i, loop, b.p, tables, (b.y, b.e, *b.work, b.F)))
            if loop := b.loop(loops._write, "event_values"):
                g = np.zeros((len(b.p), len(b.kind.events)))
                self._events.append((i, loop, b.p, (b.watched, b.rots), g, b.work))
            if loop := b.loop(loops._write, "commit"):
                self._commits.append((i, loop, b.p, (b.watched, b.rots), b.work))

    @property
    def has_events(self):
        """True when some element has events."""
        return bool(self._events)

    def initial_state(self, t=0.0):
        """State at rest in the configuration of the deck; every element in the mode its event values tell."""
        of = self.numbering
        n = of.n_all
        n_rotations = len(of.rotation_dof)
        z, R = np.zeros(n), np.zeros((n_rotations, 3, 3))
        for node, x, r in zip(self.nodes, of.x, of.rotation, strict=True):
            z[x : x + 3] = node.x
            R[r] = node.R
        modes = tuple(np.zeros(len(b.p), np.int64) for b in self.batches)
        memories = tuple(np.zeros((len(b.p), len(b.kind.memory))) for b in self.batches)
        T = np.tile(np.eye(3), (n_rotations, 1, 1))
        return State(t, z, np.zeros(n), np.zeros(n), R, T, modes, memories)

    def assemble(self, s, k, penalty, cK, cC, cM):
        """Residual and tangent at the state ``s``, into ``residual``, ``size`` (n_all,) and ``data`` (nnz + 1,).

        data = cK K T + cC C + cM M; ``k`` and ``penalty`` scale the constraints (contract.py). ``size`` sums the
        absolute contributions: the scale on which a residual is small.
        """
        loops.clear(self.force, self._slot_size, self.data)
        state = (s.z, s.v, s.a, s.R, s.T, self.force, self._slot_size, self.data, cK, cC, cM)
        for i, loop, p, tables, work in self._assembly:
            loop(p, s.memories[i], s.modes[i], *tables, s.t, k, penalty, self.laws, *state, *work)
        loops.collect(self.force, self._slot_size, self.slot_dof, self.residual, self.size)

    def add_constraints(self, s, k, penalty, data):
        """Add the constraint gradients (columns -k B^T, rows -k B, penalty B^T B) at ``s`` to ``data``."""
        force, size = np.zeros(self.n_slots), np.zeros(self.n_slots)
        state = (s.z, s.v, s.a, s.R, s.T, force, size, data, 1.0, 0.0, 0.0)
        for i, loop, p, tables, work in self._assembly:
            if self.batches[i].kind.multipliers:
                loop(p, s.memories[i], s.modes[i], *tables, s.t, k, penalty, self.laws, *state, *work)

    def levels(self, s):
        """Phi, dPhi/dt and d2Phi/dt2 of all constraints, (n_l, 3), along the velocities and accelerations of s."""
        g = np.zeros((self.n_l, 3))
        for i, loop, p, tables, work in self._constraints:
            loop(p, s.memories[i], s.modes[i], *tables, s.t, self.laws, s.z, s.v, s.a, s.R, g, *work)
        return g

    def observe(self, s):
        """Outputs (batch.y) and energies (batch.e, energy) at ``s``; ``assemble`` must have been called at s before."""
        loops.transmitted(self.force, self.n_slots, self.side_starts, self.side_members, self.transmitted, self.energy)
        for i, loop, p, tables, work in self._observers:
            loop(
                p, s.memories[i], s.modes[i], *tables, s.t, self.laws, s.z, s.v, s.a, s.R, self.transmitted, self.energy, *work
            )  # fmt: skip

    def event_values(self, s):
        """[(batch index, values (n, n_events))] of the kinds that have events; the arrays are reused."""
        for i, loop, p, tables, g, work in self._events:
            loop(p, s.memories[i], s.modes[i], *tables, s.t, self.laws, s.z, s.v, s.a, s.R, g, *work)
        return [(item[0], item[4]) for item in self._events]

    def commit(self, s):
        """The memories after an accepted step at ``s``."""
        if not self._commits:
            return s.memories
        memories = list(s.memories)
        for i, loop, p, tables, work in self._commits:
            new = s.memories[i].copy()
            loop(p, s.memories[i], s.modes[i], *tables, s.t, self.laws, s.z, s.v, s.a, s.R, new, *work)
            memories[i] = new
        return tuple(memories)


@dataclass
class _Instance:
    """One element or part of an element, before it is numbered."""

    owner: str
    kind: object
    nodes: tuple  # indices
    parameters: dict
    n_parts: int = 0  # parts that follow it in the list

    @property
    def title(self):
        return f"{self.owner}"


def _expand(model, context):
    """Elements and their parts; shared unknowns (what, i, j, element name); used unknowns."""
    index = {node.name: i for i, node in enumerate(model.nodes)}
    instances, shared, used = [], [], set()
    for element in model.elements:
        kind, nodes = element.kind, tuple(index[name] for name in element.nodes)
        frames = [(np.asarray(model.nodes[i].x, float), model.nodes[i].R) for i in nodes]
        title = f"{kind.name} '{element.name}'"
        record = kind.prepare(element.values, frames, context)
        parts = kind.parts(element.values, frames, context)
        instances.append(_Instance(title, kind, nodes, record, len(parts)))
        for part in parts:
            on = tuple(nodes[i] for i in part.nodes)
            instances.append(_Instance(title, part.kind, on, part.parameters))
        for what, i, j in kind.shares(element.values, len(nodes)):
            shared.append((what, nodes[i], nodes[j], len(instances) - len(parts) - 1))
    for item in instances:
        if item.kind.force is not None:
            used |= {(slot[0], item.nodes[int(slot[1:])]) for slot in item.kind.layout}
    return instances, shared, used


class _Sides:
    """For each joint that shares an unknown: the slots of all that hangs on its second node.

    The force that such a joint transmits is no multiplier: it is the sum of what the nodes on one side of it exert.
    """

    def __init__(self, n_nodes, shared, n_slots):
        self.n_slots = n_slots
        self.starts, self.members = [0], []
        self.neighbours = {}
        for number_, (what, i, j, _) in enumerate(shared):
            self.neighbours.setdefault((what, i), []).append((j, number_))
            self.neighbours.setdefault((what, j), []).append((i, number_))
        self.shared = {}
        for number_, (what, i, j, owner) in enumerate(shared):
            self.shared[owner, what, j] = (number_, i)
            self.shared[owner, what, i] = (number_, j)

    def slots(self, owner, what, node):
        """3 slots whose forces are what all nodes on the side of ``node`` exert through the joint ``owner``."""
        plain = 6 * node + 3 * (what == "R")
        if (owner, what, node) not in self.shared:
            return [plain, plain + 1, plain + 2]
        edge, other = self.shared[owner, what, node]
        side = self._side(what, node, edge)
        if side == [node] or other in side:
            return [plain, plain + 1, plain + 2]
        first = self.n_slots + len(self.starts) - 1
        for axis in range(3):
            self.members += [6 * i + 3 * (what == "R") + axis for i in side]
            self.starts.append(len(self.members))
        return [first, first + 1, first + 2]

    def _side(self, what, node, edge):
        seen, stack = [node], [node]
        while stack:
            for j, number_ in self.neighbours.get((what, stack.pop()), []):
                if number_ != edge and j not in seen:
                    seen.append(j)
                    stack.append(j)
        return seen

    def tables(self):
        """CSR lists (starts, members) of the sums."""
        return np.array(self.starts, np.int64), np.array(self.members, np.int64)


def _batches(instances, of, first_multiplier_slot, sides):
    """Batches in the order in which their kinds first appear."""
    by_kind, row, scalar, n_nodes_slots = {}, 0, 0, None
    n_scalars = int(np.sum(of.kind[: of.n_q] == 2))
    for number_, item in enumerate(instances):
        rows = list(range(row, row + len(item.kind.multipliers)))
        row += len(rows)
        own = list(range(scalar, scalar + len(item.kind.scalars)))
        scalar += len(own)
        parts = sum(len(part.kind.multipliers) for part in instances[number_ + 1 : number_ + 1 + item.n_parts])
        by_kind.setdefault(id(item.kind), []).append((number_, item, own, rows, list(range(row, row + parts))))
    batches = []
    for group in by_kind.values():
        kind = group[0][1].kind
        p = np.zeros(len(group), kind.dtype)
        dofs, rots, slots, watched, watched_slots, multipliers = [], [], [], [], [], []
        for e, (number_, item, own, rows, part_rows) in enumerate(group):
            for key, value in item.parameters.items():
                p[key][e] = value
            of_slot = [(slot[0], item.nodes[int(slot[1:])]) for slot in kind.layout]
            place = [(of.x if what == "x" else of.r)[node] + i for what, node in of_slot for i in range(3)]
            scalars = [of.n_q - n_scalars + i for i in own]
            mine = place + scalars + [of.n_q + i for i in rows]
            dofs.append(mine)
            watched.append(mine + ([of.n_q + i for i in part_rows] if kind.force is None else []))
            rots.append([of.rotation[node] for what, node in of_slot if what == "R"])
            slots.append(
                [6 * node + 3 * (what == "R") + i for what, node in of_slot for i in range(3)]
                + [first_multiplier_slot - n_scalars + i for i in own]
                + [first_multiplier_slot + i for i in rows]
            )
            watched_slots.append([s for what, node in of_slot for s in sides.slots(number_, what, node)])
            multipliers.append(rows)
        table = lambda rows, n=len(group): np.array(rows, np.int64).reshape(n, -1)  # noqa: E731
        columns = [3 * i for i, slot in enumerate(kind.layout) if slot[0] == "R"]
        names = [item.owner for _, item, *_ in group]
        batches.append(
            Batch(
                kind, names, p, table(dofs), table(rots), table(slots), table(watched), table(watched_slots),
                np.array(columns, np.int64), table(multipliers),
            )  # fmt: skip
        )
    return batches

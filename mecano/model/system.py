"""The model in equations: residual, tangent, constraint levels, outputs, energies, all by batches of one kind."""

import numpy as np

from mecano.contract import Context
from mecano.model import loops
from mecano.model.batch import batches
from mecano.model.instances import expand
from mecano.model.mesh import divided
from mecano.model.model import with_ground
from mecano.model.numbering import SCALAR, number
from mecano.model.sides import Sides
from mecano.model.state import State


class System:
    """Equations of a model; built once, never changed by solving."""

    def __init__(self, model):
        model = with_ground(divided(model))
        self.nodes = model.nodes
        self.context = Context(model.laws, np.asarray(model.gravity, float))
        instances, shared, used = expand(model, self.context)
        multipliers = [(f"{item.owner}: {row.name}", row) for item in instances for row in item.kind.multipliers]
        scalars = [f"{item.owner}: {name}" for item in instances for name in item.kind.scalars]
        fixed = {i for i, node in enumerate(model.nodes) if node.fixed}
        names = [node.name for node in model.nodes]
        self.numbering = number(names, used, [s[:3] for s in shared], fixed, scalars, multipliers)
        self.n_q, self.n_l, self.n = self.numbering.n_q, self.numbering.n_l, self.numbering.n
        self._slots(len(names))
        sides = Sides(shared, fixed, self.n_slots)
        self.batches = batches(instances, self.numbering, self.n_slots, sides)
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
        n_scalars = int(np.sum(of.kind[: of.n_q] == SCALAR))
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

        data = cK K T + cC C + cM M, untouched where all three are zero; ``k`` and ``penalty`` scale the constraints
        (contract.py). ``size`` sums the absolute contributions of the elements and of their inertia: the scale on
        which a residual is small.
        """
        loops.clear(self.force, self._slot_size, self.data, cK == cC == cM == 0.0)
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

    def scale_loads(self, s, factor, cK, cC, cM):
        """Count the kinds of the section "loads" ``factor`` times in what ``assemble`` has just added up at ``s``."""
        force, size, data = np.zeros(self.n_slots), np.zeros(self.n_slots), np.zeros(self.nnz + 1)
        state = (s.z, s.v, s.a, s.R, s.T, force, size, data, cK, cC, cM)
        for i, loop, p, tables, work in self._assembly:
            if self.batches[i].kind.section == "loads":
                loop(p, s.memories[i], s.modes[i], *tables, s.t, 1.0, 0.0, self.laws, *state, *work)
        self.force += (factor - 1.0) * force
        self._slot_size += abs(factor - 1.0) * size
        if not cK == cC == cM == 0.0:
            self.data += (factor - 1.0) * data
        loops.collect(self.force, self._slot_size, self.slot_dof, self.residual, self.size)

    def levels(self, s):
        """Phi, dPhi/dt and d2Phi/dt2 of all constraints, (n_l, 3), along the velocities and accelerations of s."""
        g = np.zeros((self.n_l, 3))
        for i, loop, p, tables, work in self._constraints:
            loop(p, s.memories[i], s.modes[i], *tables, s.t, self.laws, s.z, s.v, s.a, s.R, g, *work)
        return g

    def observe(self, s):
        """Outputs (batch.y) and energies (batch.e, energy) at ``s``; ``assemble`` must have been called at s before."""
        loops.transmitted(self.force, self.n_slots, self.side_starts, self.side_members, self.transmitted, self.energy)
        motion, forces = (s.t, self.laws, s.z, s.v, s.a, s.R), (self.transmitted, self.energy)
        for i, loop, p, tables, work in self._observers:
            loop(p, s.memories[i], s.modes[i], *tables, *motion, *forces, *work)

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

    def inadmissible(self, s):
        """What the kinds object to in an assembled configuration although it satisfies the equations: texts."""
        return [
            f"{name}: {text}"
            for b in self.batches
            if b.kind.admissible
            for name, p, dofs, rots in zip(b.names, b.p, b.watched, b.rots, strict=True)
            if (text := b.kind.admissible(p, s.z[dofs], s.R[rots]))
        ]

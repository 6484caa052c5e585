"""The model in equations: residual, tangent, constraint levels, outputs, energies, all by batches of one kind."""

from functools import cached_property

import numpy as np

from mecano.contract import Context
from mecano.model import loops
from mecano.model.batch import batches
from mecano.model.instances import expand
from mecano.model.model import with_ground
from mecano.model.numbering import SCALAR, number
from mecano.model.sides import Sides
from mecano.model.state import State


class System:
    """Equations of a model; built once, never changed by solving."""

    def __init__(self, model):
        model = with_ground(model)
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
        self._slot_mass = np.zeros(self.n_slots)  # diagonal of the mass matrices at the last tangent
        self.transmitted = np.zeros(self.n_slots + len(self.side_starts) - 1)
        self.energy = np.zeros(4)  # kinetic, potential [J], dissipated, given power [W] of the last ``observe``
        self.events = np.zeros(sum(b.n_events for b in self.batches))
        for b, end in zip(self.batches, np.cumsum([b.n_events for b in self.batches]), strict=True):
            b.events = self.events[end - b.n_events : end].reshape(len(b.p), -1)
        self.residual = np.zeros(self.numbering.n_all)
        self.size = np.zeros(self.numbering.n_all)

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

    def _bound(self, template, name, arguments):
        """[(batch index, compiled loop)] of the kinds that have the function ``name``.

        arguments(batch) -> (tables and arrays that are the same in every call, examples of the others that come after
        those every loop takes: memories, modes, time).
        """
        loops_of, s = [], self.initial_state()
        for i, b in enumerate(self.batches):
            if loop := b.loop(template, name):
                first, others = arguments(b, s)
                item = (i, loops.direct(loop, (b.p, self.laws, *first), (s.memories[i], s.modes[i], s.t, *others)))
                loops_of.append(item)
        return loops_of

    @cached_property
    def _assembly(self):
        def arguments(b, s):
            tables = (b.dofs, b.rots, b.slots, b.columns, b.entries)
            out = (self.force, self._slot_size, self._slot_mass, self.data)
            return (*tables, *b.work, *b.matrices), (1.0,) * 5 + (*_motion(s), s.T, *out)

        return self._bound(loops._assemble, "force", arguments)

    @cached_property
    def _residuals(self):
        def arguments(b, s):
            first = (b.dofs, b.rots, b.slots, *b.work, b.matrices[0])
            return first, (1.0, 1.0, *_motion(s), self.force, self._slot_size)

        return self._bound(loops._residual, "force", arguments)

    @cached_property
    def _constraints(self):
        def arguments(b, s):
            g = np.zeros((len(b.kind.multipliers), 3))
            return (b.dofs, b.rots, b.multipliers, *b.work, g), (*_motion(s), np.zeros((self.n_l, 3)))

        return self._bound(loops._levels, "levels", arguments)

    @cached_property
    def _observers(self):
        def arguments(b, s):
            out = (self.transmitted, b.y, b.e, self.energy)
            return (b.watched, b.rots, b.watched_slots, *b.work, b.F, *out), _motion(s)

        return self._bound(loops._observe, "observe", arguments)

    @cached_property
    def _events(self):
        def arguments(b, s):
            kind = b.kind
            before = np.array([kind.modes.index(event.before) for event in kind.events], np.int64)
            return (b.watched, b.rots, *b.work, before, b.events), _motion(s)

        return self._bound(loops._watch, "event_values", arguments)

    @cached_property
    def _commits(self):
        def arguments(b, s):
            return (b.watched, b.rots, *b.work), (*_motion(s), np.zeros((len(b.p), len(b.kind.memory))))

        return self._bound(loops._write, "commit", arguments)

    @cached_property
    def _clear(self):
        return loops.direct(loops.clear, (self.force, self._slot_size, self._slot_mass), (self.data, True))

    @cached_property
    def _collect(self):
        slots = (self.force, self._slot_size, self._slot_mass, self.slot_dof)
        return loops.direct(loops.collect, (*slots, self.residual, self.size), (self.residual,))

    @cached_property
    def _transmit(self):
        sides = (self.side_starts, self.side_members, self.transmitted, self.energy)
        return loops.direct(loops.transmitted, (self.force, self.n_slots, *sides), ())

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
        (contract.py). ``size`` sums the absolute contributions of the elements and of their inertia (with the masses of
        the last tangent): the scale on which a residual is small.
        """
        memories, modes, motion = s.memories, s.modes, (s.z, s.v, s.a, s.R)
        force, size = self.force, self._slot_size
        if cK == cC == cM == 0.0:
            self._clear(self.data, True)
            rest = (s.t, k, penalty, *motion, force, size)
            for i, loop in self._residuals:
                loop(memories[i], modes[i], *rest)
        else:
            self._clear(self.data, False)
            rest = (s.t, k, penalty, cK, cC, cM, *motion, s.T, force, size, self._slot_mass, self.data)
            for i, loop in self._assembly:
                loop(memories[i], modes[i], *rest)
        self._collect(s.a)

    def add_constraints(self, s, k, penalty, data):
        """Add the constraint gradients (columns -k B^T, rows -k B, penalty B^T B) at ``s`` to ``data``."""
        unused = np.zeros(self.n_slots)
        rest = (s.t, k, penalty, 1.0, 0.0, 0.0, *_motion(s), s.T, unused, unused, unused, data)
        for i, loop in self._assembly:
            if self.batches[i].kind.multipliers:
                loop(s.memories[i], s.modes[i], *rest)

    def levels(self, s):
        """Phi, dPhi/dt and d2Phi/dt2 of all constraints, (n_l, 3), along the velocities and accelerations of s."""
        g = np.zeros((self.n_l, 3))
        for i, loop in self._constraints:
            loop(s.memories[i], s.modes[i], s.t, *_motion(s), g)
        return g

    def observe(self, s):
        """Outputs (batch.y) and energies (batch.e, energy) at ``s``; ``assemble`` must have been called at s before."""
        self._transmit()
        rest = (s.t, s.z, s.v, s.a, s.R)
        for i, loop in self._observers:
            loop(s.memories[i], s.modes[i], *rest)

    def event_values(self, s):
        """One number for each event of each element, (n_events,), batch by batch; -inf where it is not watched."""
        rest = (s.t, s.z, s.v, s.a, s.R)
        for i, loop in self._events:
            loop(s.memories[i], s.modes[i], *rest)
        return self.events.copy()

    def commit(self, s):
        """The memories after an accepted step at ``s``."""
        if not self._commits:
            return s.memories
        memories = list(s.memories)
        for i, loop in self._commits:
            new = s.memories[i].copy()
            loop(s.memories[i], s.modes[i], s.t, s.z, s.v, s.a, s.R, new)
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


def _motion(s):
    """What every loop reads of a state."""
    return s.z, s.v, s.a, s.R

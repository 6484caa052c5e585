"""The equations of a model, batch by batch: residual, tangent, constraint derivatives, outputs, energies."""

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from mecano.element_interface import Context
from mecano.element_interface.kind import nothing
from mecano.maths.distinct import distinct
from mecano.model import assembly_driver, loops
from mecano.model.assembly import Assembly, Observation
from mecano.model.assembly_driver import Loops
from mecano.model.batch import Batch, batches, calling, followers
from mecano.model.expansion import expand
from mecano.model.halves import halves
from mecano.model.loop_code import all_codes, calls_of
from mecano.model.loop_records import SYSTEM, WORD, record
from mecano.model.mesh import divided
from mecano.model.model import Model, length_scale, with_ground
from mecano.model.numbering import LENGTH_CONSTRAINT, ROTATION, SCALAR, SIGNAL, STATE, TRANSLATION, EquationName, number
from mecano.model.reaction_partition import ReactionPartition
from mecano.model.signal_units import signal_units
from mecano.model.sparse_pattern import sparse_pattern
from mecano.model.state import State
from mecano.model.wiring import IN_PLACE

if TYPE_CHECKING:
    from mecano.jit.machine_code import Code
    from mecano.model.divided_loops import DividedLoops


Made = TypeVar("Made")


class System:
    """Equations of a model; built once, and not changed by solvers, whose results are separate objects."""

    def __init__(self, model: Model):
        model = with_ground(divided(model))
        self.model, self.nodes = model, model.nodes
        kinds = {element.kind.name: element.kind for element in model.elements}
        self.context = Context(model.laws, np.asarray(model.gravity, float), kinds, length_scale(model.nodes))
        instances, shared, used = expand(model, self.context)
        self.shared = [(what, i, j, instances[owner].owner) for what, i, j, owner in shared]
        multipliers = [(EquationName(item.owner, row.name), row) for item in instances for row in item.kind.multipliers]
        scalars = [
            (EquationName(item.owner, name), _kind_of_scalar(item.kind, name))
            for item in instances
            for name in item.kind.scalars
        ]
        fixed = {i for i, node in enumerate(model.nodes) if node.fixed}
        names = [node.name for node in model.nodes]
        self.numbering = number(names, used, [s[:3] for s in shared], fixed, scalars, multipliers)
        self.n_q, self.n_l, self.n = self.numbering.n_q, self.numbering.n_l, self.numbering.n
        of_lengths = self.numbering.kind[self.n_q : self.n] == LENGTH_CONSTRAINT
        self.penalty_factors = np.where(of_lengths, 1.0, self.context.length**2)
        """Factor on the penalty of each constraint (n_l,): 1, or the square of the length scale [m2] for an angle."""
        self._slots(len(names))
        partition = ReactionPartition(shared, fixed, self.n_slots)
        self.batches = batches(instances, self.numbering, self.n_slots, partition, self.context.length)
        self.massless = self._scalars(lambda kind: kind.massless)
        self.places_of_arrivals = np.array([i for b in self.batches for i in b.places_of_arrivals()], np.int64)
        self.places_of_past = np.array([i for b in self.batches for i in b.places_of_past()], np.int64)
        self.signals = self.numbering.kind[: self.n_q] >= SIGNAL
        self.states = self.numbering.kind[: self.n_q] == STATE
        self._state_dofs = np.flatnonzero(self.states)
        self.followers = followers(instances, self.batches)
        self.rows, self.cols, self.diagonal = sparse_pattern(self.n, self.batches)
        self.nnz = len(self.rows)
        self.n_data = self.nnz + 3  # terms of fixed unknowns, three by three, follow the values of the tangent
        self._divided_loops: dict[Callable[..., None], DividedLoops] = {}  # by purpose
        self._drivers: dict[tuple, Callable[..., Any]] = {}  # by driver, purpose and choice of batches
        self._kept: dict[Callable[[System], Any], Any] = {}
        self.laws = model.laws.array()
        self.partition_starts, self.partition_members, self.partition_weights = partition.tables()
        self.n_transmitted = self.n_slots + len(self.partition_starts) - 1
        self._no_turn = np.tile(np.eye(3), (3 * len(self.numbering.rotation_dof), 1, 1))
        self._record()

    def _scalars(self, names):
        """Return (n_q,) bool: unknowns that are the scalars ``names(kind)`` of their kind."""
        found = np.zeros(self.n_q, bool)
        for b in self.batches:
            first = 3 * len(b.kind.layout)
            for name in names(b.kind):
                found[b.dofs[:, first + b.kind.scalars.index(name)]] = True
        return found

    def _slots(self, n_nodes):
        """Assign one force slot to each unknown of each node, shared or not; then to scalars, then to multipliers."""
        of = self.numbering
        nodes = (np.stack([of.x, of.r], 1).reshape(-1, 1) + np.arange(3)).ravel()
        rest = np.arange(of.n_q - of.n_scalars, of.n)
        self.slot_dof = np.concatenate([nodes, rest]) if n_nodes else rest
        self.n_slots = len(self.slot_dof)

    def _record(self):
        """Create the record SYSTEM of the loops, without arrays to be written, and the records of the batches."""
        self.n_elements, _, self.n_outputs, self.n_events = self.batches[-1].ends if self.batches else (0, 0, 0, 0)
        self._batch_records = np.concatenate([b.record() for b in self.batches])
        arrays = {
            "states": self._state_dofs, "laws": self.laws, "slot_dof": self.slot_dof,
            "partition_starts": self.partition_starts, "partition_members": self.partition_members,
            "partition_weights": self.partition_weights,
        }  # fmt: skip
        self._record_of_tables = record(
            SYSTEM, n_all=self.numbering.n_all, n_rotations=len(self.numbering.rotation_dof), n_laws=len(self.laws),
            n_states=len(self._state_dofs), n_slots=self.n_slots, n_vectors=2 * len(self.nodes), n_data=self.n_data,
            n_transmitted=self.n_transmitted, n_constraints=self.n_l, k=1.0,
            **{name: array.ctypes.data for name, array in arrays.items()},
        )  # fmt: skip

    def record_with(self, **arrays: np.ndarray) -> np.ndarray:
        """Return a record SYSTEM (1,) of the loops that write these ``arrays``, by the names of its fields."""
        words = self._record_of_tables.view(np.int64).copy()  # a record is copied, and written, field by field
        words[[WORD[name] for name in arrays]] = [array.ctypes.data for array in arrays.values()]
        return words.view(SYSTEM)

    @cached_property
    def penalty_share(self) -> float:
        """Share of the mean stiffness of a step that is its penalty: the harmonic over the arithmetic mean of masses.

        Far above the mass of a light body over the square of the step, a penalty would leave few digits of the forces
        on it. The masses are those at the start, inertias over the square of the length scale.
        """
        data, kind = self.assemble(self.initial_state(0.0), cM=1.0).data, self.numbering.kind[: self.n_q]
        masses = data[self.diagonal[: self.n_q]] / np.where(kind == ROTATION, self.context.length**2, 1.0)
        masses = masses[(masses > 0.0) & ((kind == TRANSLATION) | (kind == ROTATION))]
        return float(1.0 / (masses.mean() * (1.0 / masses).mean())) if len(masses) else 1.0

    def kept(self, make: "Callable[[System], Made]") -> Made:
        """Return ``make(system)``, computed once and kept as long as the system."""
        if make not in self._kept:
            self._kept[make] = make(self)
        return self._kept[make]

    def codes(self) -> "list[Code]":
        """Return the Codes of all loops of the model, and of the functions that they call."""
        return all_codes(b.kind for b in self.batches)

    @cached_property
    def halves(self) -> np.ndarray | None:
        """Half to which each unknown belongs (n,), or None for a model that is not divided (halves.py)."""
        return halves(self.n, self.rows, self.cols, self.numbering.group)

    def loops(self, purpose: Callable[..., None], chosen: Callable[[Batch], bool] | None = None) -> Loops:
        """Return the Loops of all kinds that have them.

        If ``chosen`` is given, only of batches for which it is true; otherwise the only loop may be that of a divided
        model.
        """
        of_batches = [calls_of(b.kind, purpose) if chosen is None or chosen(b) else None for b in self.batches]
        found = {i: calls for i, calls in enumerate(of_batches) if calls is not None}
        if chosen is None and found and self.halves is not None:
            return self._divided(purpose, [(self.batches[i], calls) for i, calls in found.items()])
        records = self._batch_records[list(found)]
        for i, calls in enumerate(found.values()):
            calling(records[i : i + 1], calls)
        return Loops(np.array([calls.loop for calls in found.values()], np.int64), records)

    def _divided(self, purpose, loops):
        if purpose not in self._divided_loops:
            from mecano.model.divided_loops import DividedLoops  # no small model needs it

            self._divided_loops[purpose] = DividedLoops(self, loops)
        found = self._divided_loops[purpose]
        return Loops(found.loops, found.batches)

    def _driver(self, driver, purpose, chosen=None):
        """Return a ``driver`` of assembly_driver.py bound to the loops of one purpose, for the batches ``chosen``."""
        key = driver, purpose, chosen
        if key not in self._drivers:
            self._drivers[key] = driver.bind(self.loops(purpose, chosen))
        return self._drivers[key]

    @cached_property
    def signal_units(self) -> dict[str, str]:
        """{path: unit} of the values of signals."""
        paths = [path for batch in self.batches for path, _ in batch.paths if path.startswith(IN_PLACE)]
        return signal_units(self.model, paths)

    @cached_property
    def _add_coupled_multipliers(self):
        found = self.loops(loops.tangent, Batch.acts_by_multipliers)
        batches = [b for b in self.batches if b.acts_by_multipliers()]
        self._coupled_entries = [b.entries.copy() for b in batches]
        for entries, b, record_of in zip(self._coupled_entries, batches, found.batches, strict=True):
            entries[:, :, : b.kind.n_local - len(b.kind.coupled_multipliers)] = self.nnz
            record_of["entries"] = entries.ctypes.data
        return assembly_driver.add.bind(found)

    def initial_state(self, t: float = 0.0) -> State:
        """Return the state at rest in the configuration of the deck, with every element in its initial phase."""
        of = self.numbering
        n = of.n_all
        n_rotations = len(of.rotation_dof)
        z, R = np.zeros(n), np.zeros((n_rotations, 3, 3))
        for node, x, r in zip(self.nodes, of.x, of.rotation, strict=True):
            z[x : x + 3] = node.x
            R[r] = node.R
        for b in self.batches:
            if b.kind.start is not None:
                first = 3 * len(b.kind.layout)
                own = b.dofs[:, first : first + len(b.kind.scalars)]
                z[own] = [b.kind.start(p) for p in b.p]
        phases = np.zeros(sum(len(b.p) for b in self.batches), np.int64)
        for b in self.batches:
            if b.kind.at_start is not None:
                phases[b.phases] = [b.kind.at_start(p) for p in b.p]
        self.follow(phases)
        memory = np.zeros(sum(len(b.p) * len(b.kind.memory) for b in self.batches) + len(self._state_dofs))
        return State(t, z, np.zeros(n), np.zeros(n), R, phases, memory)

    def bare(self, s: State) -> State:
        """Return a copy of ``s`` without accelerations and multipliers."""
        out = s.unaccelerated()
        out.z[self.n_q : self.n] = 0.0
        return out

    def assemble(
        self,
        s: State,
        k: float = 1.0,
        penalty: float = 0.0,
        *,
        cK: float = 0.0,
        cC: float = 0.0,
        cM: float = 0.0,
        T: np.ndarray | None = None,
        into: Assembly | None = None,
    ) -> Assembly:
        """Return residual and tangent at the state ``s`` as an Assembly: a new one, or the one to be written ``into``.

        data = cK K T_q + cC C T_v + cM M T_a, unchanged if all three are zero. T (3 n_rotations, 3, 3) holds T_q of the
        rotations, T_v of their angular velocities and T_a of their angular accelerations: derivatives of these, all
        material, with respect to the unknown increments; the default is the identity. ``k`` and ``penalty`` scale the
        constraints (element_interface). ``size`` sums the absolute contributions of the elements and of their inertia
        (with the masses of the last tangent in the Assembly): the scale against which a residual is judged.
        """
        found = Assembly(self) if into is None else into
        if cK == cC == cM == 0.0:
            self._driver(assembly_driver.assemble_residual, loops.residual)(found.record, s, k, penalty)
        else:
            assemble = self._driver(assembly_driver.assemble, loops.tangent)
            assemble(found.record, s, self._no_turn if T is None else T, k, penalty, cK, cC, cM)
        return found

    def forces(self, s: State) -> np.ndarray:
        """Return the forces (n_slots,) at ``s``: the reactions are the multipliers alone, without a penalty."""
        return self.assemble(s, into=self.kept(Assembly)).forces.copy()

    def add_constraints(self, s: State, k: float, penalty: float, data: np.ndarray, rates: bool = True) -> None:
        """Add constraint gradients (columns -k B^T, rows -k B, penalty B^T B) at ``s`` to ``data``, multipliers apart.

        For constraints on velocities, B is the gradient with respect to velocities; ``rates=False`` omits them.
        """
        s = self.bare(s)
        self._add(self._adding(Batch.constrains_positions), s, k, penalty, 1.0, 0.0, data)
        if rates and self.numbering.of_rates.any():
            by_positions, plain, penalized = (np.zeros_like(data) for _ in range(3))
            cases = (0.0, 1.0, 0.0, by_positions), (0.0, 0.0, 1.0, plain), (penalty, 0.0, 1.0, penalized)
            for p, cK, cC, out in cases:
                self._add(self._adding(Batch.constrains_rates), s, k, p, cK, cC, out)
            by_positions, plain, penalized = (out[: self.nnz] for out in (by_positions, plain, penalized))
            of_motions = np.where(self.rows >= self.n_q, plain, penalized - plain)
            data[: self.nnz] += np.where(self.cols >= self.n_q, by_positions, of_motions)

    def scale_loads(
        self, assembly: Assembly, s: State, factor: float, *, cK: float = 0.0, cC: float = 0.0, cM: float = 0.0,
        T: np.ndarray | None = None,
    ) -> None:  # fmt: skip
        """Scale the contribution of the loads (``is_scaled``) by ``factor`` in the sums of an ``assembly`` at ``s``."""
        T, scratch = self._no_turn if T is None else T, np.zeros((2, self.n_slots))
        add_scaled = self._driver(assembly_driver.add_scaled, loops.tangent, Batch.is_scaled)
        add_scaled(assembly.record, s, T, cK, cC, cM, factor - 1.0, scratch)

    def is_sampled(self) -> bool:
        """Return whether signals are sampled at given times, or set by a program."""
        return any(batch.kind.is_set or batch.kind.sampling_times is not nothing for batch in self.batches)

    @cached_property
    def coupled_multipliers(self) -> np.ndarray:
        """Indices (n,), ascending, of the multipliers that act on forces other than as reactions, such as friction."""
        return self._multipliers_of(b for b in self.batches if b.acts_by_multipliers())

    @cached_property
    def sensed_multipliers(self) -> np.ndarray:
        """Indices (n,), ascending, of the multipliers that signals read."""
        return self._multipliers_of(b for b in self.batches if b.kind.senses)

    @cached_property
    def driving_signals(self) -> np.ndarray:
        """Indices (n,), ascending, of the signals without a state that constraints on velocities follow."""
        found = [np.zeros(0, np.int64)]
        for b in filter(Batch.constrains_rates, self.batches):
            found += [b.dofs[:, b.kind.place_of(name)] for name in b.kind.inputs]
        own = distinct(np.concatenate(found))
        return own[~self.states[own]]

    @cached_property
    def feedback(self) -> np.ndarray:
        """Indices (n,) of the entries of the tangent in rows of constraints and columns of ``driving_signals``."""
        driving = np.zeros(self.n, bool)
        driving[self.driving_signals] = True
        return np.flatnonzero((self.rows >= self.n_q) & driving[self.cols])

    def _multipliers_of(self, batches):
        """Return the indices (n,), ascending, of the multipliers to which elements of the ``batches`` are coupled."""
        found = [np.zeros(0, np.int64)]
        for b in batches:
            first, count = b.kind.first_reaction, len(b.kind.coupled_multipliers)
            found.append(b.dofs[:, first : first + count].ravel() - self.n_q)
        return distinct(np.concatenate(found))

    def add_coupled_multipliers(self, s: State, k: float, data: np.ndarray) -> None:
        """Add the derivatives of the forces at ``s`` with respect to the coupled multipliers (columns by lambda)."""
        self._add(self._add_coupled_multipliers, s, k, 0.0, 1.0, 0.0, data)

    def _adding(self, chosen):
        return self._driver(assembly_driver.add, loops.tangent, chosen)

    def _add(self, driver, s, k, penalty, cK, cC, data):
        """Add the tangent cK K + cC C at ``s`` of the elements to which the ``driver`` is bound to ``data``."""
        assembly = Assembly(self, data)
        driver(assembly.record, s, self._no_turn, k, penalty, cK, cC)

    def constraint_derivatives(self, s: State) -> np.ndarray:
        """Return Phi, dPhi/dt, d2Phi/dt2 of all constraints, (n_l, 3), along the velocities and accelerations of s."""
        g = np.zeros((self.n_l, 3))
        derivatives = self._driver(assembly_driver.constraint_derivatives, loops.constraint_derivatives)
        derivatives(self._record_of_tables, s, g)
        return g

    def observe(self, s: State, forces: np.ndarray | None = None, into: Observation | None = None) -> Observation:
        """Return outputs and energies at ``s`` as an Observation: a new one, or the one to be written ``into``.

        ``forces`` (n_slots,) are those of an Assembly at ``s``; by default they are computed.
        """
        found = Observation(self) if into is None else into
        observe = self._driver(assembly_driver.observe, loops.observe)
        observe(found.record, s, self.forces(s) if forces is None else forces)
        return found

    def event_values(self, s: State) -> np.ndarray:
        """Return one number for each event of each element, (n_events,), by batch; -inf for an event not monitored."""
        values = np.zeros(self.n_events)
        if self.n_events:
            self._driver(assembly_driver.event_values, loops.event_values)(self._record_of_tables, s, values)
        return values

    def commit(self, s: State) -> np.ndarray:
        """Return the memory (n_memory,) after an accepted step at ``s``."""
        return self._committed(s, None) if len(s.memory) else s.memory

    def commit_jumps(self, s: State) -> np.ndarray:
        """Return the memory (n_memory,) after an event or a corner at ``s``, where signals may have jumped."""
        return self._committed(s, Batch.follows_jumps) if any(map(Batch.follows_jumps, self.batches)) else s.memory

    def arrivals(self, memory: np.ndarray) -> list[float]:
        """Return the next times [s] at which steps must end that follow from the ``memory``, or such far off."""
        return memory[self.places_of_arrivals].tolist() if self.places_of_arrivals.size else []

    def _committed(self, s, chosen):
        memory = s.memory.copy()
        self._driver(assembly_driver.commit, loops.commit, chosen)(self._record_of_tables, s, memory)
        return memory

    def inadmissible(self, s: State) -> list[str]:
        """Return texts on why kinds reject the assembled configuration ``s``."""
        return [
            f"{name}: {text}"
            for b in self.batches
            if b.kind.admissible
            for name, p, dofs, rots in zip(b.names, b.p, b.output_dofs, b.rots, strict=True)
            if (text := b.kind.admissible(p, s.z[dofs], s.R[rots]))
        ]

    def follow(self, phases: np.ndarray) -> None:
        """Set parts that share the phase of their owner to it, in the ``phases`` (n_elements,) of a state, in place."""
        phases[self.followers[:, 0]] = phases[self.followers[:, 1]]


def _kind_of_scalar(kind, name):
    """Return SCALAR, SIGNAL or STATE (numbering.py)."""
    return STATE if name in kind.states else SIGNAL if kind.of_signals else SCALAR

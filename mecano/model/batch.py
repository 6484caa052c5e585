"""Elements of one kind, with the tables that map them to the unknowns of the model.

Joints whose parts have additional multipliers, because of an option, form a separate batch.
"""

from collections.abc import Sequence
from dataclasses import field

import numpy as np

from mecano.element_interface import Kind
from mecano.immutable import mutable
from mecano.jit.memory import LANES, lanes_dtype
from mecano.model.instance import Instance
from mecano.model.loop_code import Calls
from mecano.model.loop_records import BATCH, record
from mecano.model.numbering import Numbering
from mecano.model.reaction_partition import ReactionPartition

OF_ELEMENTS = "p", "dofs", "rots", "slots", "output_dofs", "output_slots", "multipliers", "entries"
LINES = 128  # B, two lines of the cache
WORK = ("q", "v", "a", "R", "f", "K", "C", "M", "seeded", "F", "y", "energies")


@mutable
class Batch:
    """Elements of one kind: records, tables, and their addresses for the compiled loops.

    It also has the scratch arrays of the loops for one element, whose contents are not used afterwards.
    """

    kind: Kind
    names: list[str]  # (n,) names of the owners, from the deck
    paths: list[tuple[str, str]]  # (n,) of (path, label): section and name of the owner, suffix of the outputs
    p: np.ndarray  # (n,) records
    dofs: np.ndarray  # (n, n_local) indices into z
    rots: np.ndarray  # (n, n_rotations) indices of the rotation matrices
    slots: np.ndarray  # (n, n_local) force slots
    output_dofs: np.ndarray  # (n, n_output_dofs) indices into z of the unknowns passed to ``observe``
    output_slots: np.ndarray  # (n, 3 len(layout)) slots of the forces passed to ``observe``
    columns: np.ndarray  # (n_rotations,) first local column of each rotation
    multipliers: np.ndarray  # (n, n_multipliers) indices of the constraints
    instances: list[int]  # (n,) indices into the list of all instances
    penalty_factor: float  # on the penalty of constraints: 1, or for angles the square of the length scale [m2]
    first_phase: int  # index into the phases of a state
    first_memory: int  # index into the memory of a state
    first_output: int  # index into the outputs of the system
    first_event: int  # index into the event values of the system
    entries: np.ndarray = field(init=False)  # (n, n_local, n_local) indices into the values of the sparse tangent

    def __post_init__(self):
        kind, n = self.kind, self.dofs.shape[1]
        n_work, n_rotations = max(n, self.output_dofs.shape[1]), len(self.columns)
        lanes = LANES if kind.by_lanes else 1
        self.q, self.v, self.a = (np.zeros((n_work, lanes)) for _ in range(3))
        self.R = np.zeros((n_rotations, 3, 3, lanes))
        self.f, (self.K, self.C, self.M) = np.zeros((n, lanes)), (np.zeros((n, n, lanes)) for _ in range(3))
        self.seeded = np.zeros((4 * n + 9 * n_rotations, 1 + LANES))
        self.F = np.zeros((self.output_slots.shape[1], lanes))
        self.groups = _of_groups(self.p) if kind.by_lanes else self.p[:0]
        self.n_outputs = sum(output.size for output in kind.outputs)
        self.y, self.energies = np.zeros((self.n_outputs, lanes)), np.zeros((4, lanes))
        self.n_events = len(kind.events)
        self.idle = np.zeros((len(kind.phases), 1 + self.n_outputs), np.int64)  # flags: the phase, vanishing outputs
        for phase, outputs in kind.idle.items():
            self.idle[kind.phases.index(phase), [0, *(1 + i for i in outputs)]] = 1
        self.before = np.array([kind.phases.index(event.before) for event in kind.events], np.int64)
        self.commands = np.array(  # (n_events, 2): local unknown of its command, event after which it begins; or -1
            [(kind.place_of(event.command) if event.command else -1, event.beyond) for event in kind.events], np.int64
        ).reshape(-1, 2)
        self.kept = np.zeros((len(kind.phases), len(kind.memory)), np.int64)  # flags
        for phase, values in kind.kept.items():
            self.kept[kind.phases.index(phase), list(values)] = 1

    @property
    def phases(self) -> slice:
        """Slice of these elements in the phases of a state."""
        return slice(self.first_phase, self.first_phase + len(self.p))

    @property
    def ends(self) -> tuple[int, int, int, int]:
        """The indices ``first_phase``, ``first_memory``, ``first_output``, ``first_event`` of the next batch."""
        n = len(self.p)
        return (
            self.first_phase + n, self.first_memory + n * len(self.kind.memory),
            self.first_output + n * self.n_outputs, self.first_event + n * self.n_events,
        )  # fmt: skip

    def is_scaled(self) -> bool:
        """Return whether a load factor multiplies the elements.

        True for loads and parts of loads, unless signals, such as those of a controller, give their value.
        """
        return self.paths[0][0].startswith("loads/") and not self.kind.inputs

    def constrains_positions(self) -> bool:
        """Return whether the elements have constraints on positions."""
        return len(self.kind.multipliers) > 0 and not self.kind.of_rates

    def constrains_rates(self) -> bool:
        """Return whether the elements have constraints on velocities."""
        return self.kind.of_rates

    def follows_jumps(self) -> bool:
        """Return whether the memories follow jumps of inputs."""
        return self.kind.follows_jumps

    def places_of_arrivals(self) -> list[int]:
        """Return the places in the memory of a state at which times stand when steps must end, one for each element."""
        if not self.kind.arrival:
            return []
        own, width = self.kind.memory.index(self.kind.arrival), len(self.kind.memory)
        return [self.first_memory + i * width + own for i in range(len(self.p))]

    def places_of_past(self) -> range:
        """Return the places in the memory of a state at which earlier inputs of signals stand."""
        size = len(self.p) * len(self.kind.memory) if self.kind.reads_past else 0
        return range(self.first_memory, self.first_memory + size)

    def has_signals(self) -> bool:
        """Return whether the elements have equations of signals, or of states."""
        return self.kind.of_signals or len(self.kind.states) > 0

    def acts_by_multipliers(self) -> bool:
        """Return whether multipliers of other parts determine forces of the elements, such as friction."""
        return bool(self.kind.coupled_multipliers) and not self.kind.senses

    def outputs(self, values: np.ndarray) -> np.ndarray:
        """Return the view (n, n_outputs) of this batch in ``values``, one for each output of the system."""
        n = len(self.p)
        return values[self.first_output : self.first_output + n * self.n_outputs].reshape(n, self.n_outputs)

    def events(self, values: np.ndarray) -> np.ndarray:
        """Return the view (n, n_events) of this batch in ``values``, one for each event of the system."""
        n = len(self.p)
        return values[self.first_event : self.first_event + n * self.n_events].reshape(n, self.n_events)

    def record(self) -> np.ndarray:
        """Return the record BATCH for the loops; ``entries`` must be set."""
        n, n_local = self.dofs.shape
        sizes = {
            "function": 0, "inertia": 0, "element": 0, "of_rates": self.kind.of_rates,
            "n": n, "n_local": n_local, "n_vectors": len(self.kind.layout), "n_rotations": len(self.columns),
            "n_multipliers": self.multipliers.shape[1], "first_reaction": self.kind.first_reaction,
            "n_reactions": len(self.kind.multipliers) + len(self.kind.coupled_multipliers),
            "n_output_dofs": self.output_dofs.shape[1], "n_forces": self.output_slots.shape[1],
            "n_outputs": self.n_outputs, "n_phases": len(self.idle), "n_events": self.n_events,
            "n_memory": len(self.kind.memory), "first_phase": self.first_phase, "first_memory": self.first_memory,
            "first_output": self.first_output, "first_event": self.first_event, "first_element": 0,
            "penalty_factor": self.penalty_factor,
        }  # fmt: skip
        names = [name for name in BATCH.names if name not in sizes]
        return record(BATCH, **sizes, **{name: getattr(self, name).ctypes.data for name in names})

    def record_of(self, e: int) -> np.ndarray:
        """Return the record BATCH of the element ``e`` alone."""
        return self.records_of(np.array([e]), np.array([e + 1]))

    def records_of(self, begins: np.ndarray, ends: np.ndarray) -> np.ndarray:
        """Return the records BATCH (n,) of the elements begins[i] ... ends[i] - 1."""
        out = np.repeat(self.record(), len(begins))
        for name in OF_ELEMENTS:
            out[name] += begins * getattr(self, name).strides[0]
        out["n"], out["first_element"] = ends - begins, begins
        out["first_phase"] += begins
        out["first_memory"] += begins * len(self.kind.memory)
        out["first_output"] += begins * self.n_outputs
        out["first_event"] += begins * self.n_events
        return out

    def give_work(self, records: np.ndarray) -> np.ndarray:
        """Give records of this batch work arrays of their own, for another thread; return the objects to keep alive."""
        sizes = [getattr(self, name).nbytes for name in WORK]
        memory = np.zeros(sum(sizes) + 2 * LINES, np.uint8)  # lines of the cache that no other thread writes
        for name, size, end in zip(WORK, sizes, np.cumsum(sizes), strict=True):
            records[name] = memory.ctypes.data + LINES + end - size
        return memory


def calling(records: np.ndarray, calls: Calls) -> np.ndarray:
    """Give records of a batch the addresses of the functions that its loop calls (Calls), and return them."""
    records["function"], records["inertia"] = calls.function, calls.inertia
    return records


def batches(
    instances: Sequence[Instance], of: Numbering, n_slots: int, partition: ReactionPartition, length: float
) -> list[Batch]:
    """Return the batches in the order in which their kinds first appear; ``length`` [m] is the length scale."""
    places = _Places(of, n_slots)
    taken = [places.take(item.kind) for item in instances]
    groups: dict[tuple[int, int], list[tuple]] = {}  # by kind, and number of multipliers of parts
    for number, item in enumerate(instances):
        scalars, rows = taken[number]
        last = []
        if item.senses is not None:  # the unknowns of that instance come first
            scalars, last = taken[item.senses][0], scalars
        scalars = scalars + [taken[source][0][0] for source in item.inputs]
        coupled = [row for other in item.coupled_to for row in taken[other][1]]
        of_parts = [row for part in range(number + 1, number + 1 + item.n_parts) for row in taken[part][1]]
        output_dofs = len(of_parts) if not item.kind.acts else 0  # an option may add a part with a multiplier
        member = number, item, scalars, rows, coupled, of_parts, last
        groups.setdefault((id(item.kind), output_dofs), []).append(member)
    found, begins = [], (0, 0, 0, 0)
    for members in groups.values():
        found.append(_batch(members, of, places, partition, begins, length))
        begins = found[-1].ends
    return found


def followers(instances: Sequence[Instance], batches: Sequence[Batch]) -> np.ndarray:
    """Return (m, 2) indices into the phases of a state: instances that share a phase, and the owners of that phase.

    They are parts that share the phase of their owner, and sensors.
    """
    place = {number: b.first_phase + e for b in batches for e, number in enumerate(b.instances)}
    found = [
        (place[part], place[owner])
        for owner, item in enumerate(instances)
        for part in range(owner + 1, owner + 1 + item.n_parts)
        if len(item.kind.phases) > 1 and instances[part].kind.phases == item.kind.phases
    ]
    owner = dict(found)
    sensed = [(place[i], place[item.senses]) for i, item in enumerate(instances) if item.senses is not None]
    found += [(sensor, owner.get(part, part)) for sensor, part in sensed]
    return np.array(found, np.int64).reshape(-1, 2)


class _Places:
    """Indices of scalars and multipliers, assigned in the order of the instances, as in the numbering."""

    def __init__(self, of: Numbering, n_slots: int):
        self.first_scalar, self.first_row = of.n_q - of.n_scalars, of.n_q
        self.first_slot = n_slots - of.n_l - of.n_scalars
        self.scalar = self.row = 0

    def take(self, kind: Kind) -> tuple[list[int], list[int]]:
        """Return the indices (scalars, rows) of the next instance, which is of the given kind."""
        scalars = list(range(self.scalar, self.scalar + len(kind.scalars)))
        rows = list(range(self.row, self.row + len(kind.multipliers)))
        self.scalar += len(scalars)
        self.row += len(rows)
        return scalars, rows


def _batch(members, of, places, partition, begins, length):
    kind, n = members[0][1].kind, len(members)
    numbers = [number for number, *_ in members]
    layout = [(slot[0], int(slot[1:])) for slot in kind.layout]
    nodes = np.array([[item.nodes[i] for _, i in layout] for _, item, *_ in members], np.int64).reshape(n, -1)
    scalars, multipliers, coupled, last = (_table([member[i] for member in members]) for i in (2, 3, 4, 6))
    reactions = [places.first_row + multipliers, places.first_row + coupled]
    own = np.hstack([places.first_scalar + scalars, *reactions, places.first_scalar + last])
    parts = [] if kind.acts else [places.first_row + _table([of_parts for *_, of_parts, _ in members])]
    of_nodes = [_three((of.x if what == "x" else of.r)[nodes[:, j]]) for j, (what, _) in enumerate(layout)]
    plain = [_three(6 * nodes[:, j] + 3 * (what == "R")) for j, (what, _) in enumerate(layout)]
    rotations = [j for j, (what, _) in enumerate(layout) if what == "R"]
    output_slots = np.hstack([*plain, np.zeros((n, 0), np.int64)])
    for e in np.flatnonzero(np.isin(numbers, list(partition.owners))):
        pairs = zip(layout, nodes[e].tolist(), strict=True)
        output_slots[e] = [s for (what, _), node in pairs for s in partition.slots(numbers[e], what, node)]
    return Batch(
        kind, [item.owner for _, item, *_ in members], [(item.path, item.label) for _, item, *_ in members],
        _records(kind, [item.parameters for _, item, *_ in members]),
        np.hstack([*of_nodes, own]), np.ascontiguousarray(of.rotation[nodes[:, rotations]]),
        np.hstack([*plain, places.first_slot + own - places.first_scalar]),
        np.hstack([*of_nodes, own, *parts]), output_slots, np.array([3 * j for j in rotations], np.int64),
        multipliers, numbers, length * length if kind.of_angles else 1.0, *begins,
    )  # fmt: skip


def _records(kind, parameters):
    """Return the records (n,) of elements with these parameters; equal ones may share a dictionary."""
    p = np.zeros(len(parameters), kind.dtype)
    first: dict[int, int] = {}  # id of a dictionary -> the first element that has it
    for e, values in enumerate(parameters):
        if (known := first.setdefault(id(values), e)) < e:
            p[e] = p[known]
        else:
            for key, value in values.items():
                p[key][e] = value
    return p


def _of_groups(p):
    """Return the records ``p`` (n,) in groups of LANES; the last group may repeat the last record.

    For integers, which are flags and counts, a group has the largest.
    """
    places = np.minimum(np.arange(-(-len(p) // LANES) * LANES), len(p) - 1).reshape(-1, LANES)
    out = np.zeros(len(places), lanes_dtype(p.dtype))
    for name in p.dtype.names:
        of_lanes = p[name][places]  # (groups, LANES, ...)
        out[name] = of_lanes.max(axis=1) if of_lanes.dtype.kind == "i" else np.moveaxis(of_lanes, 1, -1)
    return out


def _table(rows):
    """Return lists of the same length as an array (n, length) of int."""
    return np.array(rows, np.int64).reshape(len(rows), -1)


def _three(first):
    """Return the indices (n, 3) from each of ``first`` (n,) on."""
    return first[:, None] + np.arange(3)

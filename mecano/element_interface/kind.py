"""A kind of element, joint, load, signal or basic constraint: its entry in a deck, its mechanics, its events."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from mecano.element_interface.declarations import Display, Event, Measured, Output, Row
from mecano.element_interface.records import UNUSED, random_record, record, recorded, recorded_values
from mecano.immutable import immutable
from mecano.schema import Field, Values

if TYPE_CHECKING:
    from mecano.laws.law_table import LawTable

SECTIONS = ("elements", "joints", "loads", "signals")  # of a deck; each entry belongs to a kind
FREELY, BY_COMMAND = "freely", "by command"  # how the nodes of a joint may turn about its axis
NODES = ("node", "nodes")  # types of fields that name nodes
Nodes: TypeAlias = Sequence[tuple[np.ndarray, np.ndarray]]  # x (3,) [m] and R (3, 3) of each node
RANDOM: "dict[str, Callable[[np.random.Generator], Any]]" = {
    "number": lambda rng: rng.uniform(0.5, 1.0),
    "vector": lambda rng: rng.normal(size=3),
    "direction": lambda rng: rng.normal(size=3),
    "formula": lambda rng: "a",
}  # values of samples, by type of field; in quotes above because np.random is imported by its first use
NOT_RANDOM = (None, -math.inf, math.inf)  # defaults that samples keep


def nothing(*_: Any) -> list[Any]:
    """Return an empty list: no shares, no parts."""
    return []


def never(_: Any) -> bool:
    """Return False."""
    return False


def named(*functions: Any) -> dict[str, Any]:
    """Return {name: function}: functions that are named as the fields of a Kind, as its arguments."""
    return {function.__name__: function for function in functions}


class NodeAtStart(NamedTuple):
    """A node in the assembled state at the start of an analysis."""

    orientation: np.ndarray  # (3, 3) of the deck
    x: np.ndarray  # (3,) position [m]
    R: np.ndarray  # (3, 3) after the assembly
    v: np.ndarray  # (3,) velocity [m/s]
    w: np.ndarray  # (3,) angular velocity, inertial [rad/s]; nan where it is held, or found later with steady running
    inertia: Callable  # () -> (3, 3) of all that is attached, material [kg m2]
    gravity: np.ndarray  # (3,) [m/s2] of the deck


class OwnOutput(NamedTuple):
    """An output of a part of the same owner, as an input of a part: its name with the label of that part."""

    name: str


@immutable
class Part:
    """A basic constraint or element that is part of a kind: its nodes and its parameters.

    A part that has the phases of its owner is always in the phase of its owner.
    """

    kind: "Kind"
    nodes: tuple[int, ...]  # indices into the nodes of the owner
    parameters: Values
    coupled_to: tuple[int, ...] = ()  # indices of the parts of the owner to whose multipliers it is coupled
    label: str = ""  # suffix of the names of its outputs
    reads: tuple[str | OwnOutput, ...] = ()  # the inputs of its kind, in their order: formulas, own outputs


@immutable
class Context:
    """Data available to ``prepare`` and ``parts`` besides their own deck values."""

    laws: "LawTable"  # laws.add(law) -> start of the packed law in the flat table
    gravity: np.ndarray  # (3,) [m/s2]
    kinds: Mapping[str, "Kind"] = field(default_factory=dict)
    """kinds of the model by name, for loads along coordinates of another one"""
    length: float = 1.0  # length scale of the model [m]


@immutable(kw_only=True)
class DeckEntry:
    """The entry of a kind in a deck: its fields, their checks, and the conversion of the values."""

    section: str = ""  # one of SECTIONS; "" for a basic constraint, which cannot be used in a deck
    doc: str  # its page of the reference
    fields: tuple[Field, ...] = ()  # the node fields first
    optional: "tuple[tuple[str, Kind, str], ...]" = ()
    """(field, Kind of a part, label): outputs that are added to its own when the deck gives the field"""
    check: Callable = nothing
    """(deck values, nodes) -> [text]: errors in the combination of the values"""
    prepare: Callable | None = None
    """(deck values, [(x (3,), R (3, 3)) of each node], Context) -> values of the record; by default the deck values of
    the same names, of a law its start in the table, and the gravity"""
    parts: Callable = nothing
    """(deck values, nodes, Context) -> [Part]"""
    shares: Callable = nothing
    """(deck values, nodes) -> [("x" or "R", i, j)]: node j shares that unknown of node i"""
    divide: Callable | None = None
    """(deck values, nodes) -> ([(x, R)] of the intermediate nodes, [values of each element]): division of a member into
    ``mesh`` elements of the kind"""
    variant: Callable | None = None
    """deck values -> the Kind that replaces it in the model for these values. It has the same fields and outputs, but
    as many numbered outputs (force_1, force_2) as the values require, where this kind has only the first"""
    reads: Callable | None = None
    """deck values -> formulas (texts) of its ``inputs``; by default the fields of these names"""
    turns: str = ""
    """FREELY, for a joint that leaves free only the angle about its 'axis'; BY_COMMAND, for one that prescribes the
    angle about its 'axis'"""
    holds: Callable = nothing
    """deck values -> names of the axes of constraints/pair.py along and about which a joint holds its two nodes rigidly
    in the whole run; none if they are not those of 'axis' and 'axis_1' at the start"""
    counts_angles: Callable = nothing
    """deck values -> [(field of the axis, axis (3,), (node a, node b))] of a joint that holds angles of b relative to
    a, or of an element or load that acts about the axis: a joint of their bodies that turns FREELY must have the same
    axis"""
    drives: Callable = nothing
    """deck values -> [motion]: laws or formulas of time that a joint prescribes, if it does nothing else"""
    limits: Callable = nothing
    """deck values -> [(output, value, text)]: a warning with the text when |output| exceeds the value in a run"""
    bounds: Callable = nothing
    """deck values -> [(output, (low, high), text)]: a warning with the text when the output leaves them"""
    without_effect: Callable = nothing
    """deck values -> [(field, text)]: a warning for each value that the other values make irrelevant; why"""
    end_conditions: Callable = nothing
    """deck values -> [(output, value, text)]: the run fails with the text if |output| exceeds the value; instead of the
    text, a function of (name of an output -> its value) that returns it; with a fourth item, an output, only where that
    is not zero"""
    strains: tuple[float, ...] = ()
    """(lowest, highest) strain at the start that needs no warning, relative to 'natural_length' or, without it, to the
    distance of the two nodes in the deck"""
    start_warnings: Callable = nothing
    """(deck values, [NodeAtStart]) -> [text]: warnings about the state at the start"""
    remedies: Callable = nothing
    """deck values -> [text]: what to try, with actual values, when the solution of the equations fails"""
    cases: tuple[Values, ...] = ({},)
    """deck values (for a basic constraint: of the record) of the samples for the generic tests, each in every phase, on
    random nodes; those that a case does not give are numbers from 0.5 to 1, random vectors or the defaults"""
    sample: Callable | None = None
    """rng -> list of (values, nodes, phase): the samples of a kind whose values and nodes depend on one another, or
    that not every phase admits. values: deck values without defaults (for a basic constraint: the record); nodes: their
    number, or [(x (3,), R (3, 3))]"""


@immutable(kw_only=True)
class Mechanics:
    """The equations of a kind: unknowns, record of parameters, compiled functions of one element, outputs."""

    dtype: np.dtype = None  # type: ignore[assignment]  # declared by the fields where it is not given
    """of its record; by default, without ``prepare``, all fields that are numbers, vectors or laws"""
    layout: tuple[str, ...] = ()  # slots: "x0", "R0", "x1", ...
    flexible: bool = False  # its nodes, each with a position and a rotation, belong to one deformable body
    scalars: tuple[str, ...] = ()  # names of its scalar unknowns
    massless: tuple[str, ...] = ()  # massless scalars, whose rates follow from their own equations alone
    states: tuple[str, ...] = ()  # names of the scalars whose rates are determined by their equations
    of_signals: bool = False  # its scalars are signals
    in_fluid: bool = False  # its forces depend on velocities relative to a fluid, also if this is at rest
    jumps: Callable = never
    """deck values of a signal -> True if its value may jump although its inputs do not"""
    output_jumps: Callable = never
    """(deck values of a signal, output) -> True if this output may jump although the inputs do not"""
    smooths: Callable = never
    """deck values of a signal -> True if its value does not jump with its inputs"""
    same_unit_as: Callable = never
    """deck values of a signal -> formula (text) of the same unit as its value; "" if there is none"""
    power_of_seconds: Callable = never
    """deck values of a signal -> power of seconds by which the unit of its value exceeds that of ``same_unit_as``:
    1.0 of an integral"""
    inputs: tuple[str, ...] = ()  # names of the signals that it reads
    multipliers: tuple[Row, ...] = ()
    coupled_multipliers: tuple[Row, ...] = ()  # of other parts of the same owner
    outputs: tuple[Output, ...] = ()
    measures: dict[str, Callable[..., Measured]] = field(default_factory=dict)
    """{output: (deck values, nodes, Context) -> Measured}: coordinates, whose sensors need no other unknowns than those
    of the nodes; they also measure the output that is declared as the rate. Other outputs are measured by ``observe``,
    called with Duals"""
    hidden: dict[str, str] = field(default_factory=dict)
    """{output: text, what to do instead}: outputs that signals cannot read, because ``observe`` has them from F, from
    accelerations, or not from Duals"""
    revealed: "Kind | None" = None  # variant without shared unknowns, in which nothing is hidden
    apart: Callable | None = None
    """(deck values, nodes) -> True if the nodes cannot share their unknowns, so that ``revealed`` replaces it"""
    senses: "Kind | None" = None  # the kind whose output it measures; see constraints/output_sensor.py
    start: Callable | None = None
    """record -> initial values (n_scalars,) of its scalars; zeros by default"""
    idle: dict[str, Sequence[int]] = field(default_factory=dict)
    """{phase: indices of outputs}: phases in which an element with a ``residual`` has no force, energy or power, and
    these outputs are zero; its ``residual`` is not called then"""
    by_lanes: bool = False
    """True if ``force`` and ``observe`` also compute several elements at once; see element_interface"""
    cornered: Callable | None = None
    """record (n,) -> (n,) bool: elements whose force has corners within a phase, so that corrections of Newton's
    iteration may overshoot"""
    residual: Callable | None = None
    inertia: Callable | None = None
    force: Callable | None = None
    constraints: Callable | None = None
    observe: Callable | None = None
    impact_friction: Callable | None = None
    """(record, Place) -> (coefficient of friction, gradients (2, n_local) of the velocities of sliding along two
    perpendicular directions): friction in impacts of the contact to whose multiplier it is coupled; called from
    Python"""
    admissible: Callable | None = None
    """(record, q, R) -> text: why an assembled configuration is unacceptable although it satisfies the equations, or
    ""; q and R as passed to ``observe``; called from Python after the assembly"""

    @property
    def acts(self) -> bool:
        """True if the kind has a residual of its own, not only parts."""
        return self.residual is not None or self.force is not None

    @property
    def of_rates(self) -> bool:
        """True if its constraints are on velocities."""
        return any(row.constraint_unit.endswith("/s") for row in self.multipliers)

    @property
    def of_angles(self) -> bool:
        """True if all of its constraints are on angles."""
        return bool(self.multipliers) and all(row.constraint_unit == "rad" for row in self.multipliers)

    @property
    def first_reaction(self) -> int:
        """Index of the first multiplier, own or coupled, among the local unknowns; the value of a sensor follows."""
        last = len(self.scalars) if self.senses else 0
        return self.n_local - len(self.multipliers) - len(self.coupled_multipliers) - last

    def place_of(self, name: str) -> int:
        """Return the index of an input among the local unknowns."""
        return 3 * len(self.layout) + len(self.scalars) + self.inputs.index(name)

    @property
    def n_local(self) -> int:
        """Number of local unknowns, including inputs and coupled multipliers."""
        own = len(self.scalars) + len(self.inputs) + len(self.multipliers)
        return 3 * len(self.layout) + own + len(self.coupled_multipliers)


@immutable(kw_only=True)
class Events:
    """The discrete behaviour of a kind: phases, events that change them, memory, times at which steps must end."""

    phases: tuple[str, ...] = ("",)
    events: tuple[Event, ...] = ()
    event_values: Callable | None = None
    at_start: Callable | None = None
    """record -> index of the initial phase, where the deck specifies it; by default the first of ``phases``"""
    memory: tuple[str, ...] = ()  # names of the values kept from step to step
    in_run: Callable | None = None
    """(deck values, checked section 'time') -> the Kind that replaces it in such a run, whose memory is another"""
    commit: Callable | None = None
    is_set: bool = False  # a program sets its memory between steps
    reads_past: bool = False  # its memory is that of earlier inputs, of which an equilibrium has none
    follows_jumps: bool = False  # ``commit`` is also called after events and corners, where its inputs may have jumped
    kept: dict[str, Sequence[int]] = field(default_factory=dict)
    """{phase: indices of values of the memory that ``commit`` does not change in it}"""
    times: Callable = nothing
    """(deck values, start, end) -> [time]: times between start and end of a run at which a step must end"""
    sampling_times: Callable = nothing
    """as ``times``: those at which the memory takes new values, and nothing else jumps"""
    arrival: str = ""
    """name of the value of the memory that is the next such time, such as that at which a late jump arrives"""


@immutable(kw_only=True)
class Kind(DeckEntry, Mechanics, Events):
    """A kind of element: everything that the rest of mecano may know about it.

    A name, four groups of declarations (``DeckEntry``, ``Mechanics``, ``Events``, and ``Display`` as one value), and
    the methods that combine them. Those that a kind does not need keep their defaults: most kinds have no events.
    """

    name: str
    display: Display = Display()

    def __post_init__(self):
        """Declare the record by the fields if it is not given; raise ValueError for what lanes cannot have."""
        if self.by_lanes and (self.force is None or self.observe is None):
            raise ValueError(f"{self.name}: a kind with 'by_lanes' needs 'force', with tangents by hand, and 'observe'")
        if self.by_lanes and (len(self.phases) > 1 or self.multipliers or self.coupled_multipliers or self.memory):
            raise ValueError(f"{self.name}: a kind with 'by_lanes' has one phase, no multipliers and no memory")
        if self.dtype is None:
            own = recorded(self.fields) if self.acts and not self.prepare else {}
            object.__setattr__(self, "dtype", record(**own or {UNUSED: ()}))

    def record_values(self, values: Values, nodes: Nodes, context: Context) -> dict[str, Any]:
        """Return the values of the record of an element; the arguments are those of ``prepare``."""
        if self.prepare:
            return self.prepare(values, nodes, context)
        names = [name for name in self.dtype.names or () if name != UNUSED]
        return recorded_values(names, self.fields, {"gravity": context.gravity, **values}, context)

    def samples(self, rng: "np.random.Generator") -> list[tuple[Values, Any, str]]:
        """Return the samples of the kind; see ``cases`` and ``sample``."""
        if self.sample:
            return self.sample(rng)
        nodes, found = 1 + max((int(slot[1:]) for slot in self.layout), default=0), []
        for case in self.cases:
            values = {**(self._random_values(case, rng) if self.section else random_record(self.dtype, rng)), **case}
            kind = self.chosen({**{one.name: one.default for one in self.fields}, **values})
            found += [(values, nodes, phase) for phase in kind.phases]
        return found

    def _random_values(self, case, rng):
        """Return random values of the fields that a case does not give; raise ValueError for one that needs a case."""
        values = {}
        for given in self.fields:
            if given.type.name in RANDOM and given.default not in NOT_RANDOM:
                values[given.name] = RANDOM[given.type.name](rng)
            elif given.required and given.type.name not in NODES and given.name not in case:
                raise ValueError(f"{self.name} needs 'cases': the field {given.name!r} has no random values")
        return values

    def read(self, values: Values) -> tuple[str, ...]:
        """Return the formulas (texts) of its inputs."""
        return tuple(self.reads(values) if self.reads else (values[name] for name in self.inputs))

    def chosen(self, values: Values) -> "Kind":
        """Return the kind itself, or its variant for these deck values."""
        return self.variant(values) if self.variant else self

    def placed(self, values: Values, nodes: Nodes) -> "Kind":
        """Return the kind for these deck values between ``nodes`` at the start."""
        kind = self.chosen(values)
        return kind.revealed if kind.revealed and kind.apart and kind.apart(values, nodes) else kind

"""The interface that every kind of element, joint, load and basic constraint implements.

A ``Kind`` consists of a name, its entry in a deck, its mechanics, its events and its display, with one class for each
of these groups. The local unknowns of one element are ordered as follows: the slots of ``layout`` (3 unknowns each;
"x0" is the position of its first node, "R0" its rotation), its ``scalars``, its ``multipliers``, and the multipliers
of other parts to which it is coupled (``coupled_multipliers``). All compiled functions work on ONE element; their first
arguments are

    p       record of parameters (``dtype``); a field ``mass`` is the mass of the element [kg]
    at      Place: time, state and memory of the element, all read-only

``force(p, at, f, K, C, M)`` adds the residual of the equations of motion (internal minus external forces, including
inertia) to ``f`` (n_local,) and its exact derivatives K = df/dq, C = df/dv, M = df/da to (n_local, n_local) arrays that
are zero on entry. Rotations are varied in the material frame, dR = R hat(dTheta); the rotation rows of ``f`` are
material moments. A constraint Phi adds B^T (penalty Phi - k_lambda) and the rows -k Phi; its multiplier columns in K
are -k B^T. A kind with multipliers has no other stiffness or damping: that of a joint is a separate part.

A part of a joint may depend on the multipliers of other parts of the same joint (friction driven by reactions). These
*coupled multipliers* are at the end of q, in the order of ``Part.coupled_to``. The part adds nothing to their rows;
their columns in K are derivatives with respect to lambda, like those of all multipliers: k times the derivative with
respect to the reaction k*lambda in q. Only a kind with coupled multipliers may let its forces depend on reactions, and
such a kind has no multipliers and no inertia of its own.

``residual(p, at, f)``, in the place of ``force``, adds f alone, for numbers and for Duals (maths/dual.py), from which
the tangents are derived. Branches on varying quantities are written with ``select``, roots of equations with
``implicit``. If it has inertia, ``inertia(p, at, m)`` writes the diagonal of the mass matrix M to ``m`` (n_local,),
zero on entry: times the accelerations, it is part of the scale against which residuals are judged.

``constraint_derivatives(p, at, g)`` writes the constraint derivatives to ``g`` (n_multipliers, 3): Phi, dPhi/dt,
d2Phi/dt2 along v and a. A constraint on velocities, Phi(q, v), writes 0, Phi, dPhi/dt. All constraints of one kind are
on positions, or all on velocities (``Row.constraint_unit`` per second): then B = dPhi/dv is in C and -k dPhi/dq in K,
and the loops scale rows and penalty to those of a displacement. A constraint that is inactive in a phase writes zeros
to ``g``, and the rows -k_lambda: its reaction is zero.

``constraints(p, at, g)`` replaces ``constraint_derivatives``: it writes Phi and dPhi/dt = B v to ``g`` (n_multipliers,
2), zero on entry; of a constraint on velocities it writes Phi(q, v) in place of dPhi/dt, of an inactive one nothing.
The last column of the constraint derivatives is computed with dual numbers; so that it includes the rates of functions
of time, the time is a Dual there, too: ``chain(at.t, rate, second_rate)``.

``observe(p, at, F, y, e)`` writes the outputs to ``y`` (n_outputs,) and the energies to ``e`` (4,), both zero on entry:
kinetic energy [J], potential energy [J], dissipated power [W] (>= 0), power supplied by the surroundings [W].
``F`` (n_local,) are the forces and moments that the rest of the model exerts on the nodes of the element's slots (the
forces that a joint transmits); for a kind without ``force``, the multipliers of its ``parts`` follow its own unknowns
in ``q``, in their order. Signals read outputs by calling it with Duals, with all ``F`` zero; outputs that do not follow
from these are ``hidden``. The energies of an element are those of its own ``observe`` plus those of its parts, whose
outputs are written next to its own.

``event_values(p, at, g)`` writes one number per event; an event that is monitored in the current phase occurs when its
number rises through zero. For a kind without ``force``, ``q`` is that of ``observe``. The number of an event by command
(``Event.command``) is the value of an input, which the loops write.

An event may involve a *shock* (``Event.shock``): constraints of the element, or of the parts that share its phase,
become active, and momentum is exchanged at fixed positions (docs/shocks.md). The number of such an event is -Phi, or
increases with it; a contact, which can only push, is a ``Row.unilateral``, with Phi >= 0 while it is open and a
reaction >= 0 while it is closed. A contact also has an event for its opening, at which its reaction falls to zero. A
grip holds in both directions until another event releases it, whose number may depend on anything. As positions do not
change during a shock, a constraint may use the memory that its ``commit`` has just written.

``commit(p, at, m_out)`` writes the new memory after an accepted step.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

LOCK, CONTACT, GRIP = "lock", "contact", "grip"  # kinds of shocks
RELEASES = "releases"  # name of the events after which an element is no longer there
WAITS = "waits"  # name of the events after which an element that is due does not act yet
FREELY, BY_COMMAND = "freely", "by command"  # how the nodes of a joint may turn about its axis
UNUSED = "unused"  # field of an empty record
RECORDED = {"number": (), "vector": 3, "direction": 3, "law": "i", "curve": "i"}  # shape in a record, by type of field
NODES = ("node", "nodes")  # types of fields that name nodes
LAWS = ("law", "curve")  # types of fields of which a record has the start in the table of laws
RANDOM = {
    "number": lambda rng: rng.uniform(0.5, 1.0),
    "vector": lambda rng: rng.normal(size=3),
    "direction": lambda rng: rng.normal(size=3),
    "formula": lambda rng: "a",
}  # values of samples, by type of field
SECTIONS = ("elements", "joints", "loads", "signals")  # of a deck; each entry belongs to a kind


class Place(NamedTuple):
    """Time, state and memory at which a function of an element is evaluated."""

    t: float  # time [s]
    phase: int  # index into ``phases``
    k: float  # scale of the multipliers
    penalty: float  # of the constraints
    laws: np.ndarray  # flat table of all laws of the model (see mecano.laws), and of the matrices of superelements
    m: np.ndarray  # (n_memory,) values written by ``commit`` at the last accepted step
    q: np.ndarray  # (n_local,) positions [m], 0 for rotations, scalars, multipliers k*lambda [N, N m], coupled ones
    v: np.ndarray  # (n_local,) velocities [m/s], material angular velocities [rad/s], rates of scalars, else 0
    a: np.ndarray  # (n_local,) accelerations, in the same frames
    R: np.ndarray  # (n_rotations, 3, 3) rotations, material to inertial, in the order of the "R" slots


@dataclass(frozen=True)
class Output:
    """An output of each element: unit and meaning; ``shape`` is (3,) for vectors, (4,) for quaternions.

    A coordinate names the output that is its ``rate``: between two steps, both are interpolated by a cubic. All other
    outputs are interpolated linearly.
    """

    name: str
    unit: str
    doc: str
    shape: tuple = ()
    rate: str = ""


@dataclass(frozen=True)
class Row:
    """A constraint equation: name of its multiplier, units of the multiplier and of the constraint."""

    name: str
    unit: str  # of k*lambda: N or N m
    constraint_unit: str  # of Phi: m or rad; m/s or rad/s for a constraint on velocities
    unilateral: bool = False  # a contact, whose reaction is never negative; the first row of its element


@dataclass(frozen=True)
class Event:
    """A zero crossing, monitored in the phase ``before``; after the event the phase is ``after``."""

    name: str
    before: str
    after: str
    doc: str
    shock: str = ""
    """LOCK: constraints hold from now on; CONTACT: they may push and open again; GRIP: they hold until another event;
    "": no shock"""
    restitution: str = ""
    """for a CONTACT: field of the record with its coefficient of restitution; a negative value means that the contact
    never opens. Without a name the coefficient is 0"""
    changes_energy: bool = False
    """True if potential energy that the element loses by the change of phase is lost to the model, and what it gains is
    given by the surroundings"""
    through: str = ""
    """phase whose constraints hold during the shock, if they are not those of ``after``"""
    elastic: bool = False
    """True if no constraint holds before or after, so that the event may be captured (solve/events/capture.py): the
    phase at the end of a step follows from the motion there, without the shock that the event may have"""
    command: str = ""
    """input whose value is its number"""
    beyond: int = -1
    """index of an event: by command, this one replaces the first of the same command if that event would follow at
    once, its number being positive"""


@dataclass(frozen=True)
class Measured:
    """A coordinate of an element that sensors measure: its nodes and its axes.

    The measured value is that of the coordinate minus ``zero``.
    """

    coordinate: object  # constraints.coordinates.Coordinate
    nodes: tuple  # indices into the nodes of the element
    axes: dict  # values of the ``axes`` of the coordinate
    zero: float = 0.0


@dataclass(frozen=True)
class Display:
    """How a kind is drawn and to which of the standard pictures its outputs belong; stored in results files.

    Attributes
    ----------
    shape : str
        One of post/shapes.py: body, mass, line, cable, beam, superelement, spring, wheel, wheel_on_body, curve,
        contact, gears, belt, joint, nothing.
        By default an element is a line between its nodes, a joint a dot at its last node.
    support : bool
        True if a joint with the ground holds a point and is drawn as a support.
    pictures : tuple of str
        Names of pictures of post/plans.py; if empty, the kind has a picture of its own with all its outputs.
    force : str
        Name of the output, a vector [N], that is drawn as an arrow.
    along_axes : bool
        True if the components of that vector are along mu_1, mu_2 and the axis of the joint, False if inertial.
    force_at : str
        Name of the output with its point of application, inertial [m]; the last node by default.
    axial : str
        Name of the output with the axial force, > 0 in tension; for a vector, its first component.
    """

    shape: str = ""
    support: bool = True
    pictures: tuple = ()
    force: str = ""
    along_axes: bool = False
    force_at: str = ""
    axial: str = ""


@dataclass(frozen=True)
class Part:
    """A basic constraint or element of which a kind is composed: its nodes and its parameters.

    A part that has the phases of its owner is always in the phase of its owner.
    """

    kind: "Kind"
    nodes: tuple  # indices into the nodes of the owner
    parameters: dict
    coupled_to: tuple = ()  # indices of the parts of the owner to whose multipliers it is coupled
    label: str = ""  # suffix of the names of its outputs
    reads: tuple = ()  # formulas of the inputs of its kind, in their order


def nothing(*_):
    """Return an empty list: no shares, no parts."""
    return []


def never(_):
    """Return False."""
    return False


class NodeAtStart(NamedTuple):
    """A node in the assembled state at the start of an analysis."""

    orientation: np.ndarray  # (3, 3) of the deck
    x: np.ndarray  # (3,) position [m]
    R: np.ndarray  # (3, 3) after the assembly
    v: np.ndarray  # (3,) velocity [m/s]
    inertia: Callable  # () -> (3, 3) of all that is attached, material [kg m2]
    gravity: np.ndarray  # (3,) [m/s2] of the deck


@dataclass(frozen=True, kw_only=True)
class DeckEntry:
    """The entry of a kind in a deck: its fields, their checks, and the conversion of the values."""

    section: str = ""  # one of SECTIONS; "" for a basic constraint, which cannot be used in a deck
    doc: str  # its page of the reference
    fields: tuple = ()  # schema.Field, the node fields first
    optional: tuple = ()
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
    angle about its 'axis': two between the same nodes must have the same axis"""
    limits: Callable = nothing
    """deck values -> [(output, value, text)]: a warning with the text when |output| exceeds the value in a run"""
    ends: Callable = nothing
    """deck values -> [(output, value, text)]: the run fails with the text if |output| exceeds the value"""
    strains: tuple = ()
    """(lowest, highest) strain at the start that needs no warning, relative to 'natural_length' or, without it, to the
    distance of the two nodes in the deck"""
    suspicious: Callable = nothing
    """(deck values, [NodeAtStart]) -> [text]: warnings about the state at the start"""
    remedies: Callable = nothing
    """deck values -> [text]: what to try, with actual values, when the solution of the equations fails"""
    sample: Callable | None = None
    """rng -> list of (values, nodes, phase): valid samples for the generic tests, covering every phase. values: deck
    values without defaults (for a basic constraint: the record); nodes: their number, or [(x (3,), R (3, 3))]. By
    default numbers from 0.5 to 1 and random vectors in every phase, for a kind that has no other fields"""


@dataclass(frozen=True, kw_only=True)
class Mechanics:
    """The equations of a kind: unknowns, record of parameters, compiled functions of one element, outputs."""

    dtype: np.dtype | None = None
    """of its record; by default, without ``prepare``, all fields that are numbers, vectors or laws"""
    layout: tuple = ()  # slots: "x0", "R0", "x1", ...
    flexible: bool = False  # its nodes, each with a position and a rotation, belong to one deformable body
    scalars: tuple = ()  # names of its scalar unknowns
    massless: tuple = ()  # massless scalars, whose rates follow from their own equations alone
    states: tuple = ()  # names of the scalars whose rates are determined by their equations
    of_signals: bool = False  # its scalars are signals
    jumps: bool = False  # the value of a signal may jump although its inputs do not
    smooths: Callable = never
    """deck values of a signal -> True if its value does not jump with its inputs"""
    like: Callable = never
    """deck values of a signal -> formula (text) of the same unit as its value; "" if there is none"""
    inputs: tuple = ()  # names of the signals that it reads
    multipliers: tuple = ()  # Row
    coupled_multipliers: tuple = ()  # Row: coupled multipliers, of other parts of the same owner
    outputs: tuple = ()  # Output
    measures: dict = field(default_factory=dict, compare=False)
    """{output: (deck values, nodes, Context) -> Measured}: coordinates, whose sensors need no other unknowns than those
    of the nodes; they also measure the output that is declared as the rate. Other outputs are measured by ``observe``,
    called with Duals"""
    hidden: dict = field(default_factory=dict, compare=False)
    """{output: text, what to do instead}: outputs that signals cannot read, because ``observe`` has them from F, from
    accelerations, or not from Duals"""
    revealed: "Kind | None" = None  # variant without shared unknowns, in which nothing is hidden
    senses: "Kind | None" = None  # the kind of which it measures an output; see constraints/output_sensor.py
    start: Callable | None = None
    """record -> initial values (n_scalars,) of its scalars; zeros by default"""
    idle: dict = field(default_factory=dict, compare=False)
    """{phase: indices of outputs}: phases in which an element with a ``residual`` has no force, energy or power, and
    these outputs are zero; its ``residual`` is not called then"""
    residual: Callable | None = None
    inertia: Callable | None = None
    force: Callable | None = None
    constraints: Callable | None = None
    constraint_derivatives: Callable | None = None
    observe: Callable | None = None
    rubs: Callable | None = None
    """(record, Place) -> (coefficient of friction, gradients (2, n_local) of the velocities of sliding along two
    perpendicular directions): friction in impacts of the contact to whose multiplier it is coupled; called from
    Python"""
    admissible: Callable | None = None
    """(record, q, R) -> text: why an assembled configuration is unacceptable although it satisfies the equations, or
    ""; q and R as passed to ``observe``; called from Python after the assembly"""

    @property
    def acts(self):
        """True if the kind has a residual of its own, not only parts."""
        return self.residual is not None or self.force is not None

    @property
    def of_rates(self):
        """True if its constraints are on velocities."""
        return any(row.constraint_unit.endswith("/s") for row in self.multipliers)

    @property
    def first_reaction(self):
        """Index of the first multiplier, own or coupled, among the local unknowns; the value of a sensor follows."""
        last = len(self.scalars) if self.senses else 0
        return self.n_local - len(self.multipliers) - len(self.coupled_multipliers) - last

    def place_of(self, name):
        """Return the index of an input among the local unknowns."""
        return 3 * len(self.layout) + len(self.scalars) + self.inputs.index(name)

    @property
    def n_local(self):
        """Number of local unknowns, including inputs and coupled multipliers."""
        own = len(self.scalars) + len(self.inputs) + len(self.multipliers)
        return 3 * len(self.layout) + own + len(self.coupled_multipliers)


@dataclass(frozen=True, kw_only=True)
class Events:
    """The discrete behaviour of a kind: phases, events that change them, memory, times at which steps must end."""

    phases: tuple = ("",)
    events: tuple = ()  # Event
    event_values: Callable | None = None
    at_start: Callable | None = None
    """record -> index of the initial phase, where the deck specifies it; by default the first of ``phases``"""
    memory: tuple = ()  # names of the values kept from step to step
    commit: Callable | None = None
    kept: dict = field(default_factory=dict, compare=False)
    """{phase: indices of values of the memory that ``commit`` does not change in it}"""
    times: Callable = nothing
    """(deck values, start, end) -> [time]: times between start and end of a run at which a step must end"""


@dataclass(frozen=True, kw_only=True)
class Kind(DeckEntry, Mechanics, Events):
    """A kind of element: everything that the rest of mecano may know about it.

    A name, four groups of declarations (``DeckEntry``, ``Mechanics``, ``Events``, and ``Display`` as one value), and
    the methods that combine them. What a kind does not need keeps its default: most have no events.
    """

    name: str
    display: Display = Display()

    def __post_init__(self):
        """Declare the record by the fields if it is not given."""
        if self.dtype is None:
            own = recorded(self.fields) if self.acts and not self.prepare else {}
            object.__setattr__(self, "dtype", record(**own or {UNUSED: ()}))

    def record_values(self, values, nodes, context):
        """Return the values of the record of an element; the arguments are those of ``prepare``."""
        if self.prepare:
            return self.prepare(values, nodes, context)
        names = [name for name in self.dtype.names if name != UNUSED]
        return recorded_values(names, self.fields, {"gravity": context.gravity, **values}, context)

    def samples(self, rng):
        """Return the samples of the kind; see ``sample``."""
        if self.sample:
            return self.sample(rng)
        values = {}
        for given in self.fields:
            if given.type.name in RANDOM and given.default is not None:
                values[given.name] = RANDOM[given.type.name](rng)
            elif given.required and given.type.name not in NODES:
                raise ValueError(f"{self.name} needs 'sample': the field {given.name!r} has no random values")
        nodes = 1 + max((int(slot[1:]) for slot in self.layout), default=0)
        return [(values, nodes, phase) for phase in self.phases]

    def read(self, values):
        """Return the formulas (texts) of its inputs."""
        return tuple(self.reads(values) if self.reads else (values[name] for name in self.inputs))

    def chosen(self, values):
        """Return the kind itself, or its variant for these deck values."""
        return self.variant(values) if self.variant else self


@dataclass(frozen=True)
class Context:
    """Data available to ``prepare`` and ``parts`` besides their own deck values."""

    laws: object  # LawTable: laws.add(law) -> start of the packed law in the flat table
    gravity: np.ndarray  # (3,) [m/s2]
    kinds: dict = field(default_factory=dict)  # kinds of the model by name, for loads along coordinates of another one


def record(**fields):
    """Return a structured dtype from names and shapes: record(mass=(), r_C=3, J=(3, 3)); shape "i" for an integer."""
    return np.dtype(
        [(name, "i8") if shape == "i" else (name, "f8", shape) for name, shape in fields.items()], align=True
    )


def recorded(fields):
    """Return {name: shape} of the fields that a record can hold: numbers, vectors and laws that are always given."""
    return {f.name: RECORDED[f.type.name] for f in fields if f.type.name in RECORDED and f.default is not None}


def recorded_values(names, fields, values, context):
    """Return the values of a record with these names from those of the ``fields``; of a law, its start in the table."""
    laws = [f.name for f in fields if f.type.name in LAWS]
    return {name: context.laws.add(values[name]) if name in laws else values[name] for name in names}

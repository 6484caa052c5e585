"""The one contract that every kind of element, joint, load and basic constraint fulfils.

A kind is a record of data and functions. The local unknowns of one element are, in this order: the slots of
``layout`` (3 each; "x0" the position of its first node, "R0" its rotation), its ``scalars``, its ``inputs``, its
``multipliers``, those that it has ``borrowed``. All compiled functions work on ONE element and take first

    p       record of parameters (``dtype``); a field ``mass`` is the mass of the element [kg]
    at      Place: time, state and memory of the element, all of it read only

``force(p, at, f, K, C, M)`` adds the residual of the equations of motion
(internal minus external forces, inertia included) to ``f`` (n_local,) and its exact derivatives K = df/dq,
C = df/dv, M = df/da to (n_local, n_local) arrays that arrive zeroed. Rotations are varied in the material frame,
dR = R hat(dTheta); the rotation rows of ``f`` are material moments. A constraint Phi adds
B^T (penalty Phi - k_lambda) and the rows -k Phi; its multiplier columns in K are -k B^T. A kind with multipliers
has no other stiffness or damping: those of its owner are another part.

A part of a joint may *borrow* the multipliers of other parts of it (friction that the reactions drive): they stand at
the end of q, in the order of ``Part.borrows``. It adds nothing to their rows; their columns in K are, as those of all
multipliers, derivatives by lambda: k times that by the reaction k*lambda in q. Forces may depend on reactions in a
kind that borrows only, and there without multipliers or inertia of its own.

An element may read *signals*, numbers that other elements determine (docs/signals.md): its ``inputs`` are their values.
It adds nothing to their rows; their columns in K are exact, so that a force may depend on whatever is measured. The
scalars of a kind ``of_signals`` are signals themselves, of any unit and size: each is determined by its own row alone,
which says y - c = 0, or dy/dt - c = 0 for those named by ``states``, whose value at the start is given.

``residual(p, at, f)`` of a kind without inertia adds f alone, for numbers and for Duals (maths/dual.py): its tangents
are made from it. Branches on what varies are written with ``select``, roots of equations with ``implicit``.

``levels(p, at, g)`` writes value, rate and second rate of the constraints to
``g`` (n_multipliers, 3): Phi, dPhi/dt, d2Phi/dt2 along v and a. A constraint on velocities, Phi(q, v),
writes 0, Phi, dPhi/dt. All constraints of one kind are on positions, or all on velocities (``Row.constraint_unit`` per
second): then B = dPhi/dv stands in C, -k dPhi/dq in K, and the loops turn rows and penalty into those of a
displacement. A constraint that is let go in some mode writes no levels there, and the rows -k_lambda: no reaction.

``velocity_constraints(p, at, g)``, of a kind with a ``residual`` in the place of ``levels``, writes Phi(q, v) to ``g``
(n_multipliers,), zero where it is let go: its rate is found by dual numbers.

``observe(p, at, F, y, e)`` writes the outputs to ``y`` (n_outputs,) and to ``e`` (4,), which
arrive zeroed: kinetic
energy [J], potential energy [J], dissipated power [W] (>= 0), power given by the surroundings [W]. ``F`` (n_local,)
are the forces and moments that everything else exerts on the nodes of the element's slots (what a joint transmits);
for a kind without ``force``, ``q`` carries after its own unknowns the multipliers of its ``parts``, in their order.
The energies of an element are those of its own ``observe`` and of its parts, whose outputs are written beside its own.

``event_values(p, at, g)`` writes one number per event; an event that is watched in the
current mode happens where its number rises through zero. For a kind without ``force``, ``q`` is that of ``observe``.

An event may come with a *shock* (``Event.shock``): constraints of the element, or of the parts that follow its mode,
begin to hold, and momentum is exchanged at frozen positions (docs/shocks.md). They are written so that the number of
the event is -Phi, or grows with it; what a contact can only push with is a ``Row.unilateral``, with Phi >= 0 where it
is open and a reaction >= 0 where it is closed. A contact has an event back, which happens where its reaction falls to
zero. What grips holds in both directions until another event lets go of it; the number of its event may be of anything
else. As positions do not change in a shock, a constraint may hold what its ``commit`` has just written.

``commit(p, at, m_out)`` writes the new memory after an accepted step.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

LOCK, CONTACT, GRIP = "lock", "contact", "grip"  # kinds of shocks
SECTIONS = ("elements", "joints", "loads", "signals")  # of a deck, whose entries are each of a kind


class Place(NamedTuple):
    """Where a function of an element is evaluated."""

    t: float  # time [s]
    phase: int  # index into ``modes``
    k: float  # scale of the multipliers
    penalty: float  # of the constraints
    laws: np.ndarray  # flat table of all laws of the model (see mecano.laws), and of the matrices of superelements
    m: np.ndarray  # (n_memory,) what ``commit`` wrote on the last accepted step
    q: np.ndarray  # (n_local,) positions [m], 0 for rotations, scalars, multipliers k*lambda [N, N m], borrowed ones
    v: (
        np.ndarray
    )  # (n_local,) velocities [m/s], material angular velocities [rad/s], rates of scalars, 0 for multipliers
    a: np.ndarray  # (n_local,) accelerations, in the same frames
    R: np.ndarray  # (n_rotations, 3, 3) rotations, material to inertial, in the order of the "R" slots


@dataclass(frozen=True)
class Output:
    """A number written for each element: unit, meaning; ``shape`` (3,) for vectors.

    A coordinate names the output that is its ``rate``: between two steps both are then interpolated by a cubic. All
    other outputs are interpolated linearly.
    """

    name: str
    unit: str
    doc: str
    shape: tuple = ()
    rate: str = ""


@dataclass(frozen=True)
class Row:
    """A constraint equation: what its multiplier is, in words, and the units of multiplier and constraint."""

    name: str
    unit: str  # of k*lambda: N or N m
    constraint_unit: str  # of Phi: m or rad; m/s or rad/s for a constraint on velocities
    unilateral: bool = False  # the row of a contact whose reaction is never negative, the first of its element


@dataclass(frozen=True)
class Event:
    """A zero crossing: watched in the mode ``before``, after it the mode is ``after``."""

    name: str
    before: str
    after: str
    doc: str
    shock: str = ""
    """LOCK: constraints begin to hold for good; CONTACT: they may push, and let go again; GRIP: they hold until another
    event; "": no shock"""
    restitution: str = ""
    """of a CONTACT: the number of the record that is its coefficient of restitution, or, where it is negative, tells
    that the contact never opens; 0 without a name"""
    through: str = ""
    """the mode whose constraints hold during the shock, where they are not those of ``after``"""


@dataclass(frozen=True)
class Measured:
    """A coordinate of an element, for what measures or drives it: on which nodes of the element, with which axes.

    What is measured is the coordinate minus its value ``zero``.
    """

    coordinate: object  # constraints.coordinates.Coordinate
    nodes: tuple  # indices into the nodes of the element
    axes: dict  # values of the ``axes`` of the coordinate
    zero: float = 0.0


@dataclass(frozen=True)
class Part:
    """A basic constraint or element that a kind is made of: on which of its nodes, with which values of its record.

    A part that has the modes of its owner is in its owner's mode.
    """

    kind: "Kind"
    nodes: tuple  # indices into the nodes of the owner
    parameters: dict
    borrows: tuple = ()  # indices of the parts of the owner whose multipliers it borrows
    label: str = ""  # what is appended to the names of its outputs
    reads: tuple = ()  # formulas, each the value of one of the inputs of its kind


def nothing(*_):
    """No shares, no parts."""
    return []


@dataclass(frozen=True)
class Kind:
    """All that the rest of mecano may know about a kind of element."""

    name: str
    section: str  # deck section: elements, joints, loads; "" for a basic constraint, which no deck names
    doc: str
    dtype: np.dtype = np.dtype([("unused", "f8")])
    layout: tuple = ()
    fields: tuple = ()  # schema.Field, the node fields first
    outputs: tuple = ()  # Output
    optional: tuple = ()
    """(field, Kind of a part, label): outputs that stand beside its own when the deck gives the field"""
    scalars: tuple = ()  # names of own scalar unknowns
    relaxing: tuple = ()  # those of them, without inertia, whose rates follow from their own equations alone
    flexible: bool = False  # its nodes, each with a position and a rotation, are those of one body that deforms
    of_signals: bool = False  # its scalars are signals
    states: tuple = ()  # names of those of them whose rates their rows determine
    inputs: tuple = ()  # names of the signals that it reads
    multipliers: tuple = ()  # Row
    borrowed: tuple = ()  # Row: multipliers of other parts of the same owner
    modes: tuple = ("",)
    events: tuple = ()  # Event
    memory: tuple = ()  # names of the numbers kept from step to step
    prepare: Callable = lambda d, nodes, context: {}
    """(deck values, [(x (3,), R (3, 3)) of each node], Context) -> values of the record"""
    start: Callable | None = None
    """record -> values (n_scalars,) of its own scalars at the start; zeros without it"""
    at_start: Callable | None = None
    """record -> index of the mode in which it starts, where the deck puts it; the first of ``modes`` without it"""
    shares: Callable = nothing
    """(deck values, nodes) -> [("x" or "R", i, j)]: node j shares that unknown of node i"""
    parts: Callable = nothing
    """(deck values, nodes, Context) -> [Part]"""
    reads: Callable | None = None
    """deck values -> formulas (texts), each the value of one of its ``inputs``; without it those are fields"""
    measures: dict = field(default_factory=dict, compare=False)
    """{output: (deck values, nodes, Context) -> Measured, or a Part whose first scalar it is}: what signals can take;
    of a Measured also the output that is declared as its rate"""
    divide: Callable | None = None
    """(deck values, nodes) -> ([(x, R)] of the nodes between, [values of each element]) of a member that its value
    ``mesh`` divides into several elements of the kind"""
    variant: Callable | None = None
    """deck values -> the Kind, of the same fields and outputs, that takes its place in the model for these values; of
    outputs that are numbered (force_1, force_2) it has as many as the values ask for, this kind only the first"""
    check: Callable = nothing
    """(deck values, nodes) -> [text]: what is wrong with the values taken together"""
    limits: Callable = nothing
    """deck values -> [(output, value, text)]: a warning with the text when the output exceeds the value in a run"""
    remedies: Callable = nothing
    """deck values -> [text]: what to try, with the values at hand, where a run fails in its equations"""
    times: Callable = nothing
    """(deck values, start, end) -> [time]: when, between start and end of a run, steps of time must end"""
    ends: Callable = nothing
    """deck values -> [(output, value, text)]: a run fails with the text when the output's size exceeds the value"""
    residual: Callable | None = None
    force: Callable | None = None
    levels: Callable | None = None
    velocity_constraints: Callable | None = None
    observe: Callable | None = None
    event_values: Callable | None = None
    commit: Callable | None = None
    admissible: Callable | None = None
    """(record, q, R) -> text: what is wrong with an assembled configuration that satisfies the equations, or "";
    q and R as ``observe`` receives them; called from Python after the assembly"""
    sample: Callable | None = None
    """rng -> list of (values, nodes, mode): admissible samples for the generic tests, every mode among them. values:
    deck values without defaults (of a basic constraint: the record); nodes: their number, or [(x (3,), R (3, 3))]"""

    @property
    def acts(self):
        """True when it has a residual of its own, not only parts."""
        return self.residual is not None or self.force is not None

    @property
    def of_rates(self):
        """True when its constraints are on velocities."""
        return any(row.constraint_unit.endswith("/s") for row in self.multipliers)

    @property
    def n_local(self):
        """Number of local unknowns, inputs and borrowed multipliers among them."""
        own = len(self.scalars) + len(self.inputs) + len(self.multipliers)
        return 3 * len(self.layout) + own + len(self.borrowed)

    def read(self, values):
        """Return the formulas (texts) of its inputs."""
        return tuple(self.reads(values) if self.reads else (values[name] for name in self.inputs))

    def chosen(self, values):
        """The kind itself, or its variant for these deck values."""
        return self.variant(values) if self.variant else self


@dataclass(frozen=True)
class Context:
    """What ``prepare`` and ``parts`` may use besides their own deck values."""

    laws: object  # LawTable: laws.add(law) -> start of the packed law in the flat table
    gravity: np.ndarray  # (3,) [m/s2]
    kinds: dict = field(default_factory=dict)  # those of the model by name, for what acts along coordinates of another


def record(**fields):
    """Structured dtype from names and shapes: record(mass=(), r_C=3, J=(3, 3)); integers by the shape "i"."""
    return np.dtype(
        [(name, "i8") if shape == "i" else (name, "f8", shape) for name, shape in fields.items()], align=True
    )

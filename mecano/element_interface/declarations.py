"""Declarations of a Kind: outputs, constraint equations, events, measured coordinates, display."""

import math
from typing import TYPE_CHECKING, Any

from mecano.immutable import immutable

if TYPE_CHECKING:
    from mecano.constraints.coordinates.coordinate import Coordinate

LOCK, CONTACT, GRIP = "lock", "contact", "grip"  # kinds of shocks
POWERS = {"dissipated_power": 2, "given_power": 3}
"""{name: index among the energies that ``observe`` writes} of the powers that signals read of an element in total"""
RELEASES = "releases"  # name of the events after which an element is no longer there
WAITS = "waits"  # name of the events after which an element that is due does not act yet


@immutable
class Output:
    """An output of each element: unit and meaning; ``shape`` is (3,) for vectors, (4,) for quaternions.

    Between two steps, an output that is ``geometric``, a function of positions, rotations and time, is that of the
    interpolated motion. A coordinate that names the output that is its ``rate`` is interpolated by a cubic, as this is,
    and all other outputs linearly. An angle that ``wraps`` is known within one turn only, in (-pi, pi].
    """

    name: str
    unit: str
    doc: str
    shape: tuple[int, ...] = ()
    rate: str = ""
    wraps: bool = False
    geometric: bool = False

    @property
    def size(self) -> int:
        """Number of values."""
        return math.prod(self.shape)


@immutable
class Row:
    """A constraint equation: name of its multiplier, units of the multiplier and of the constraint."""

    name: str
    unit: str  # of k*lambda: N or N m
    constraint_unit: str  # of Phi: m or rad; m/s or rad/s for a constraint on velocities
    unilateral: bool = False  # a contact, whose reaction is never negative; the first row of its element


@immutable
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
    one_sided: bool = False
    """True if the force beyond it would have the wrong sign: where a step begins beyond it, as after a shock, it
    happens at once, also if the motion departs from it before the end of the step"""
    brief: bool = False
    """True if bodies that pass one another may cause it and undo it within one step, in which it is then sought
    (solve/events/passing.py)"""
    condition: bool = False
    """True if its number is that of a signal, which may rise through zero and fall again within one step"""
    command: str = ""
    """input whose value is its number; then it is also a condition"""
    ends_run: bool = False
    """True if the time integration stops at it"""
    beyond: int = -1
    """index of an event: by command, this one replaces the first of the same command if that event would follow at
    once, its number being positive"""


@immutable
class Measured:
    """A coordinate of an element that sensors measure: its nodes and its axes.

    The measured value is that of the coordinate minus ``zero``.
    """

    coordinate: "Coordinate"
    nodes: tuple[int, ...]  # indices into the nodes of the element
    axes: dict[str, Any]  # values of the ``axes`` of the coordinate
    zero: float = 0.0


@immutable
class Display:
    """Shape of a kind in pictures, and the standard pictures of its outputs; stored in results files.

    Attributes
    ----------
    shape : str
        One of post/shapes.py: body, mass, line, cable, beam, superelement, spring, actuator, wheel, wheel_on_body,
        curve, contact, gears, belt, joint, nothing.
        By default an element is a line between its nodes, a joint a dot at its last node, a load nothing.
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
    pictures: tuple[str, ...] = ()
    force: str = ""
    along_axes: bool = False
    force_at: str = ""
    axial: str = ""

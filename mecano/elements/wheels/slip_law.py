"""Slip laws: the force and moment of the ground on a tyre as one function of the kinematics of the contact.

A slip law states what it dissipates, and what it exchanges with the rolling of the wheel: the power that the ground
takes from a wheel with the velocity v of its point of contact and the angular velocity omega is

    -(F.v + M.omega) = lost - given,      lost >= 0

A law with ``passive`` gives nothing but the power of its moment. Its derivatives are made by dual numbers: branches
on what varies are written with ``select``, and the normal force may be zero or, on the way to the lift-off, negative.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from mecano.schema import Type


class Slip(NamedTuple):
    """Kinematics and load of a contact; 3-vectors in the inertial frame, velocities within the ground."""

    N: float  # normal force [N]
    w: float  # radial deformation [m]
    grip: float  # factor on the friction, of the place on the ground
    v: tuple  # slip velocity: of the material of the tyre at the point of contact against the ground [m/s]
    v_0: tuple  # the same with a patch without mass held in the wheel, v of a wheel without one [m/s]
    u: tuple  # velocity of the axle over the ground [m/s]
    omega: tuple  # angular velocity of the wheel against the ground [rad/s]
    spin: float  # about its axis [rad/s]
    lean: float  # sine of the camber angle: n.a
    t: tuple  # driving direction
    l: tuple  # lateral direction
    n: tuple  # normal of the ground; (t, l, n) is right-handed


class SlipForces(NamedTuple):
    """What the ground does to a wheel in the contact, but for its normal force."""

    F: tuple  # force in the ground [N]
    M: tuple  # moment about the point of contact [N m]
    lost: float  # power that is dissipated [W]
    given: float  # power that is given to the wheel [W]


class Carcass(NamedTuple):
    """Stiffness of a tyre between rim and ground along t and l; for ``transient_wheel``."""

    stiffness: tuple  # (along t, along l) [N/m]
    creep: tuple  # lengths in which a deflection decays under a force that does not grow with the slip [m]


@dataclass(frozen=True, eq=False)
class SlipLaw:
    """A slip law: its deck fields and its compiled function. A tyre law names exactly one."""

    name: str  # of the field of a tyre law
    doc: str
    type: Type  # of that field; a ``mapping`` of its own fields
    record: dict
    """names and shapes of the numbers that ``forces`` finds in its record, as for ``contract.record``"""
    prepare: Callable
    """(values of the tyre law, Context) -> values of the record"""
    forces: Callable
    """kernel (record, table of laws, Slip) -> SlipForces; the record has RADIAL_RECORD too"""
    check: Callable = lambda values: []
    """values of the tyre law -> [text]: what is wrong with them taken together"""
    limits: Callable = lambda values: []
    """values of the tyre law -> [(output, value, text)], as ``Kind.limits``"""
    carcass: Callable | None = None
    """values of the tyre law -> Carcass"""
    completed: Callable = lambda values: {}
    """values of the tyre law -> values of its other fields that the law knows, where the deck gives none"""
    sample: Callable | None = None
    """rng -> [values of the field], of a wheel of 12 m under some 10 kN, for the generic tests"""
    passive: bool = True
    """True where the force never drives what slips: lost = -F.v, given = M.omega"""

    @property
    def summary(self):
        """The first sentence of its documentation."""
        return " ".join(self.doc.strip().split("\n\n")[0].split()).rstrip(".")


def given_law(values, laws):
    """Return the law of those in ``laws`` ({name: SlipLaw}) that a tyre law has; None without one."""
    return next((law for law in laws.values() if values.get(law.name) is not None), None)


def default_values(fields, values):
    """Return ``values`` with the defaults of the fields that they lack, for samples."""
    return {**{field.name: field.default for field in fields if not field.required}, **values}

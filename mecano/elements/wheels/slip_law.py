"""Slip laws: the force and moment of the ground on a tyre as one function of the kinematics of the contact.

A slip law states the power that it dissipates and the power that it exchanges with the rolling of the wheel: the ground
takes from a wheel, whose point of contact has the velocity v and which has the angular velocity omega, the power

    -(F.v + M.omega) = lost - given,      lost >= 0

A ``passive`` law gives only the power of its moment. Derivatives are computed by dual numbers: branches on varying
quantities are written with ``select``, and the normal force may be zero or, on the way to the lift-off, negative.
"""

from collections.abc import Callable
from typing import NamedTuple

from mecano.element_interface import recorded, recorded_values
from mecano.immutable import immutable
from mecano.jit.kernel import kernel
from mecano.laws.law_table import curve
from mecano.maths.dual import at_least
from mecano.maths.vector import norm
from mecano.schema import NUMBER, NUMBERS, Field, Type, positive, requirement

LEAST_FORCE = 1e-9  # [N] lower bound of mu N, which is zero in the air


class Slip(NamedTuple):
    """Kinematics and load of a contact; 3-vectors in the inertial frame, velocities within the ground."""

    N: float  # normal force [N]
    w: float  # radial deformation [m]
    grip: float  # factor on the friction at this point of the ground
    v: tuple  # slip velocity: of the tyre's material at the point of contact relative to the ground [m/s]
    v_0: tuple  # the same for a massless patch held in the wheel; v for a wheel without patch [m/s]
    u: tuple  # velocity at which the contact passes over the ground, that of the axle on a plane [m/s]
    omega: tuple  # angular velocity of the wheel relative to the ground [rad/s]
    spin: float  # the part of it along the axis [rad/s]
    lean: float  # sine of the camber angle: n.a
    t: tuple  # driving direction; of a twisted patch the one in which it rolls
    l: tuple  # lateral direction
    n: tuple  # normal of the ground; (t, l, n) is right-handed
    curvature: float  # of the ground along t, > 0 on a drum [1/m]; 0 on grounds, whatever their shape


@kernel
def slipping(k, v, v_0):
    """Return the Slip ``k`` with other slip velocities."""
    return Slip(k.N, k.w, k.grip, v, v_0, k.u, k.omega, k.spin, k.lean, k.t, k.l, k.n, k.curvature)


@kernel
def friction_limit(p, laws, k):
    """Return mu N > 0 [N] of the Slip ``k``; ``p`` has ``friction``, a curve of the slip speed."""
    mu = k.grip * at_least(curve(laws, p.friction, norm(k.v_0)), 0.0)
    return at_least(mu * at_least(k.N, 0.0), LEAST_FORCE)


@kernel
def unchanged(p, k):
    """Return a Slip unchanged."""
    return k


class SlipForces(NamedTuple):
    """Action of the ground on a wheel at the contact, without the normal force."""

    F: tuple  # force in the ground [N]
    M: tuple  # moment about the point of contact [N m]
    lost: float  # dissipated power [W]
    given: float  # power supplied to the wheel [W]


class Carcass(NamedTuple):
    """Carcass of a tyre between rim and ground along t and l, for ``transient_wheel``."""

    stiffness: tuple  # (along t, along l) [N/m]
    creep: tuple  # (along t, along l) rolling distances in which a deflection decays under a constant force [m]


TORSIONAL_STIFFNESS = Field(
    "torsional_stiffness", NUMBER, "N m/rad",
    "for a transient_wheel with turn slip: moment per twist of the contact before it slides; rigid when absent", None,
    positive,
)  # fmt: skip
CARCASS_FIELDS = (
    Field(
        "carcass_stiffness", NUMBERS, "N/m",
        "for a transient_wheel, K [along t, along l]: relaxation length C/K + creep_length",
        None, requirement(lambda K: len(K) == 2 and min(K) > 0.0, "must hold 2 numbers greater than zero"),
    ),
    Field(
        "creep_length", NUMBER, "m", "rolling distance in which the carcass settles when the whole contact slides; "
        "its share of the relaxation length acts at once", 0.02, positive,
    ),
    TORSIONAL_STIFFNESS,
)  # fmt: skip


def check_twist(name, d, needed="contact_width"):
    """Return an error for a torsional stiffness among the values ``d`` of the law ``name`` without turn slip."""
    if d["torsional_stiffness"] is None or d[needed]:
        return []
    return [f"'tire_law.{name}.torsional_stiffness' needs '{needed}': without it no moment twists the contact"]


def carcass_of(d):
    """Return the Carcass of values of CARCASS_FIELDS, or None if the deck gives no stiffness."""
    return d["carcass_stiffness"] and Carcass(tuple(d["carcass_stiffness"]), 2 * (d["creep_length"],))


@immutable
class SlipLaw:
    """A slip law: its deck fields and its compiled function. A tyre law names exactly one."""

    name: str  # of the field of a tyre law
    doc: str
    type: Type  # of that field; a ``mapping`` of the fields of the law
    forces: Callable
    """kernel (record, table of laws, Slip) -> SlipForces; the record also contains RADIAL_RECORD"""
    record: dict | None = None
    """names and shapes of the parameters of ``forces``, as for ``element_interface.record``; by default all fields that
    are numbers, vectors or laws"""
    prepare: Callable | None = None
    """(values of the tyre law, Context) -> values of the record; by default those of the fields of these names"""
    check: Callable = lambda values: []
    """values of the tyre law -> [text]: errors in the combination of the values"""
    limits: Callable = lambda values: []
    """values of the tyre law -> [(output, value, text)], as ``Kind.limits``"""
    carcass: Callable | None = None
    """values of the tyre law -> Carcass, or None if they lack it; by default those of CARCASS_FIELDS, if it has them"""
    completed: Callable = lambda values: {}
    """values of the tyre law -> values that the law provides for its other fields, if the deck gives none"""
    sample: Callable | None = None
    """rng -> [values of the field] for a wheel of 12 m radius under about 10 kN, for the generic tests"""
    slip: Callable = unchanged
    """kernel (record, Slip) -> Slip that ``forces`` receives and that is output: that of the rim at another radius"""
    seen: Callable = unchanged
    """kernel (record, Slip that ``forces`` receives) -> Slip that is output: that on which ``forces`` are based"""
    passive: bool = True
    """True if the force never drives the slip: lost = -F.v, given = M.omega"""

    turning: Callable | None = None
    """as ``forces``, with turn slip: for tyre laws with a 'contact_width' (turn_slip.py) or 'turn_slip'"""
    plane: Callable | None = None
    """kernel that gives the effective plane of the cams of a wheel (enveloping.py), which takes the place of the
    ground"""
    crowned: bool = False
    """True for a tyre with a rounded tread (crown.py)"""
    rounded: Callable = lambda law: law
    """SlipLaw -> the SlipLaw for a rounded tread, which rolls on another radius as it leans"""
    twists: bool = False
    """True if the contact of a ``transient_wheel`` is twisted against the torsional stiffness of its carcass"""

    def __post_init__(self):
        """Declare record, ``prepare`` and ``carcass`` by the fields if they are not given."""
        fields = self.type.options
        if self.record is None:
            object.__setattr__(self, "record", recorded(fields))
        if self.prepare is None:
            object.__setattr__(
                self, "prepare", lambda d, context: recorded_values(self.record, fields, d[self.name], context)
            )
        if self.carcass is None and CARCASS_FIELDS[0] in fields:
            object.__setattr__(self, "carcass", lambda d: carcass_of(d[self.name]))

    @property
    def summary(self):
        """The first sentence of its documentation."""
        return " ".join(self.doc.strip().split("\n\n")[0].split()).rstrip(".")


def default_values(fields, values):
    """Return ``values`` completed by the defaults of missing fields, for samples."""
    return {**{field.name: field.default for field in fields if not field.required}, **values}

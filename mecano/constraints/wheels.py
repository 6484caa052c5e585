"""Deck fields and outputs shared by all wheels; records of the constraints of rigid wheels."""

from typing import NamedTuple

from mecano.constraints.ground import LEAN, lean_of, prepare_ground, too_low
from mecano.constraints.triads import carried_axis
from mecano.element_interface import Display, Output
from mecano.jit.kernel import kernel
from mecano.maths.surface import directions
from mecano.maths.vector import Vec3, norm, put, vec
from mecano.schema import DIRECTION, GROUND, NODE, NUMBER, Field, positive

SMALL = 0.1  # m, radius of a wheel below which speeds that mean a slow one are smaller in proportion
CARRIED = 0.1  # of the radius: largest distance over which the assembly moves a wheel onto the ground
PLACED = (
    Field("node", NODE, "-", "centre of the wheel; its rotation spins with the wheel"),
    Field("axis", DIRECTION, "-", "spin axis at the start, inertial; rolling forward turns right-handed"),
    Field("ground", GROUND, "-", "ground it rolls on"),
)
FIELDS = (*PLACED, Field("radius", NUMBER, "m", "radius", check=positive))
WHEEL_DISPLAY = Display("wheel", pictures=("wheels",), force="contact_force", force_at="contact_point")
CONTACT_OUTPUTS = (
    Output("height", "m", "height of the centre over the ground, along the normal at the contact", geometric=True),
    Output(
        "loaded_radius",
        "m",
        "distance from centre to contact in the wheel plane, with a crown to the tread there; in the air the radius",
        geometric=True,
    ),
    Output("normal_force", "N", "normal force N of the ground on the wheel"),
    Output("longitudinal_force", "N", "force of the ground on the wheel along t = a x n/|a x n|"),
    Output("lateral_force", "N", "force of the ground on the wheel along l = n x t (upright: the axis)"),
    Output("contact_force", "N", "force of the ground on the wheel, inertial", (3,)),
    Output("spin_rate", "rad/s", "angular velocity of the wheel along its axis"),
    Output("contact_point", "m", "contact, inertial; in the air, the lowest point of the rim", (3,), geometric=True),
    LEAN,
)
OUTPUTS = (
    *CONTACT_OUTPUTS,
    Output("friction_needed", "-", "tangential over normal force: the friction coefficient needed to prevent slip"),
)


def disc_record(d, nodes, context):
    """Return the values of axis, radius and ground for the basic constraints."""
    crown = d.get("crown_radius", 0.0)
    ground = prepare_ground(d["ground"], context, crown)
    return {"axis": carried_axis(d, nodes), "radius": d["radius"], **ground}


def check_touching(gap, along_normal, radius, otherwise=""):
    """Return errors for a permanently touching wheel whose rim is farther from the ground than an assembly may move it.

    ``gap`` [m] in its plane and ``along_normal`` [m] are those of ``tread_above``; ``otherwise`` is an alternative to
    suggest.
    """
    if gap < -CARRIED * radius:
        return [too_low(-gap, -along_normal)]
    if gap > CARRIED * radius:
        return [
            f"the rim is {gap:.4g} m above the ground at the start, but this wheel must touch it: lower its node by "
            f"{along_normal:.4g} m along the normal of the ground{otherwise}"
        ]
    return []


class Wheel(NamedTuple):
    """A wheel at its contact; 3-vectors in the inertial frame."""

    g: tuple  # Contact (surface.py)
    axis: tuple
    arm: tuple  # from the centre to the contact, or to the lowest point of the rim [m]
    spin: float  # angular velocity along the axis [rad/s]
    height: float  # of the centre over the ground, along the normal at the contact [m]


@kernel
def put_contact(y, q, push, radius, wheel):
    """Write CONTACT_OUTPUTS of a Wheel; ``push`` (3,) [N]: force of the ground along n, t, l; loaded radius [m]."""
    g, (t, l) = wheel.g, directions(wheel.axis, wheel.g)
    y[0] = wheel.height
    y[1] = radius
    put(y, 2, push)
    put(y, 5, push[0] * g.n + (push[1] * t + push[2] * l))
    y[8] = wheel.spin
    put(y, 9, vec(q, 0) + wheel.arm)
    y[12] = lean_of(g)


@kernel
def put_outputs(y, q, push, radius, wheel):
    """Write OUTPUTS, as ``put_contact``."""
    put_contact(y, q, push, radius, wheel)
    if push[0] > 0.0:
        y[13] = norm(Vec3(push[1], push[2], 0.0)) / push[0]


@kernel
def slow(radius, speed):
    """Return the ``speed`` [m/s] below which a wheel counts as slow, for one of this ``radius`` [m]."""
    return speed * min(1.0, radius / SMALL)

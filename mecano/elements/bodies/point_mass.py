r"""Point mass: a mass at a node, without rotation: :math:`f_x = m (a - g)`."""

from mecano.element_interface import Display, Kind, Output, named, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import add_vec, dot, vec
from mecano.schema import NODE, NUMBER, Field, positive

RECORD = record(mass=(), gravity=3)


@kernel
def residual(p, at, f):
    """Add inertia and weight."""
    add_vec(f, 0, p.mass, vec(at.a, 0) - vec(p.gravity, 0))


@kernel
def inertia(p, at, m):
    """Write the mass of each component."""
    m[0], m[1], m[2] = p.mass, p.mass, p.mass


@kernel
def observe(p, at, F, y, e):
    """Write kinetic and potential energy."""
    velocity = vec(at.v, 0)
    e[0] = 0.5 * p.mass * dot(velocity, velocity)
    e[1] = -p.mass * dot(vec(p.gravity, 0), vec(at.q, 0))
    y[0] = 0.5 * p.mass * dot(velocity, velocity)


POINT_MASS = Kind(
    name="point_mass", section="elements", doc=__doc__, display=Display("mass", pictures=("bodies",)), dtype=RECORD,
    layout=("x0",),
    fields=(
        Field("node", NODE, "-", "node that carries the mass"),
        Field("mass", NUMBER, "kg", "mass", check=positive),
    ),
    outputs=(Output("kinetic_energy", "J", "kinetic energy"),),
    **named(residual, inertia, observe),
)  # fmt: skip

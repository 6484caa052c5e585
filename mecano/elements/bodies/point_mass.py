r"""Point mass: a mass at a node, without rotation: :math:`f_x = m (a - g)`."""

from mecano.element_interface import Display, Kind, Output, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import EYE, add_mat, add_vec, dot, vec
from mecano.schema import NODE, NUMBER, Field, positive

RECORD = record(mass=(), gravity=3)


@kernel
def force(p, at, f, K, C, M):
    """Add inertia and weight."""
    add_vec(f, 0, p.mass, vec(at.a, 0) - vec(p.gravity, 0))
    add_mat(M, 0, 0, p.mass, EYE)


@kernel
def observe(p, at, F, y, e):
    """Write kinetic and potential energy."""
    velocity = vec(at.v, 0)
    e[0] = 0.5 * p.mass * dot(velocity, velocity)
    e[1] = -p.mass * dot(vec(p.gravity, 0), vec(at.q, 0))
    y[0] = 0.5 * p.mass * dot(velocity, velocity)


POINT_MASS = Kind(
    name="point_mass",
    section="elements",
    doc=__doc__,
    display=Display("mass", pictures=("bodies",)),
    dtype=RECORD,
    layout=("x0",),
    fields=(
        Field("node", NODE, "-", "node that carries the mass"),
        Field("mass", NUMBER, "kg", "mass", check=positive),
    ),
    outputs=(Output("kinetic_energy", "J", "kinetic energy"),),
    force=force,
    observe=observe,
)

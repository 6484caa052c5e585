r"""Gear pair: the pitch circles of the gears a and b roll on one another; parallel axes or a bevel pair.

Each node is the centre of its gear's pitch circle; another joint (usually a hinge) lets it rotate about its axis in
the carrier, a body or ground. The circles must touch initially: with the unit vectors :math:`e_a, e_b` from each
centre, perpendicular to its axis, to the pitch point,

.. math::  x_a + r_a e_a = x_b + r_b e_b,

which determines whether the gears are external, internal or bevel. With the tangent :math:`\tau = n_a \times e_a` and
the angles relative to the carrier, counted over any number of turns,

.. math::  r_a \theta_a - r_b\, n_b \cdot (e_b \times \tau)\, \theta_b + \tau \cdot (x_a - x_b) - c = 0

so that external gears with parallel axes turn as :math:`r_a\theta_a = -r_b\theta_b`. The multiplier is the tangential
force of the teeth on a, along :math:`\tau` at the pitch point; the opposite force acts on b, and the joints of both
gears transmit their reactions to the carrier. The separating force of inclined flanks does no work and is omitted.

Gears that do not touch, coupled by a chain or by intermediate gears, have a ``ratio`` i instead of the radius of b:

.. math::  r_a \theta_a - r_a\, i\, \theta_b - c = 0

for any axes and centres. Only a moment acts on each gear, on a :math:`r_a` times the multiplier; the balancing moments
act on the carrier.

The left-hand side is the transmission error s. With ``backlash`` the teeth are free within it, and meet with a shock
(docs/gears.md); with ``teeth`` they are elastic, and s causes the tooth force; ``friction`` gives the stage an
efficiency.
"""

from itertools import product

import numpy as np

from mecano.constraints.along_coordinate.measure import angle_outputs
from mecano.constraints.gear_mesh import GEAR_MESH, gear, gear_travel
from mecano.constraints.gear_teeth import Mesh, with_teeth
from mecano.constraints.triads import triad
from mecano.element_interface import Display, Kind, Output, named
from mecano.jit.kernel import kernel
from mecano.maths.vector import dot, vec
from mecano.schema import DIRECTION, NODE, NUMBER, Field, Type, not_zero, positive

PARALLEL = 1e-6  # sine of the angle up to which two axes are parallel
GAP = 1e-4  # of the smaller radius: permitted distance of the circles in the deck
TRIPLE = Type("nodes", f"a list of 3 {NODE.name} names", (3,))


@kernel
def _put_motion(p, at, y):
    """Write angles and rates."""
    for i in range(2):
        now = gear(p, at, i)
        y[2 * i] = now.turns + now.angle
        y[2 * i + 1] = dot(now.by_carrier, vec(at.v, 3)) + dot(now.by_gear, vec(at.v, 9 + 3 * i))


def _axes(d):
    return triad(d["axis_a"]), triad(d["axis_a"] if d["axis_b"] is None else d["axis_b"])


def _touching(d, nodes):
    """Return (e_a, e_b, gap) of the closest pair of points on both circles, in the plane of the axes; e 0 if undefined.

    Unit vectors (3,), inertial, and the distance of the points [m].
    """
    (mu_a, mu_b), apart = _axes(d), np.subtract(nodes[2][0], nodes[1][0])
    n_a, n_b = mu_a[2], mu_b[2]
    across = np.cross(n_a, n_b)
    if np.linalg.norm(across) < PARALLEL:
        across = np.cross(n_a, apart)
    if (size := np.linalg.norm(across)) < PARALLEL * d["radius_a"]:
        return np.zeros(3), np.zeros(3), abs(d["radius_a"] - d["radius_b"])
    e_a, e_b = np.cross(across / size, n_a), np.cross(across / size, n_b)
    pairs = [(i * e_a, j * e_b) for i, j in product((1.0, -1.0), repeat=2)]
    gaps = [np.linalg.norm(apart + d["radius_b"] * b - d["radius_a"] * a) for a, b in pairs]
    return *pairs[int(np.argmin(gaps))], min(gaps)


def prepare(d, nodes, context):
    """Return axes of the gears in the carrier and in the gears, travels, tangent and its constant."""
    (mu_a, mu_b), (carrier, a, b) = _axes(d), nodes
    axes = {"mu": (mu_a @ carrier[1], mu_b @ carrier[1]), "xi": (mu_a @ a[1], mu_b @ b[1])}
    if d["ratio"] is not None:
        return {**axes, "travel": (d["radius_a"], -d["radius_a"] * d["ratio"]), "tangent": np.zeros(3), "offset": 0.0}
    e_a, e_b, _ = _touching(d, nodes)
    tangent = np.cross(mu_a[2], e_a)
    return {
        **axes,
        "travel": (d["radius_a"], -d["radius_b"] * (mu_b[2] @ np.cross(e_b, tangent))),
        "tangent": tangent @ carrier[1],
        "offset": tangent @ np.subtract(a[0], b[0]),
    }


def check(d, nodes):
    """Check that the pitch circles touch at a point, or that there is a ratio."""
    if (d["radius_b"] is None) == (d["ratio"] is None):
        return ["give either 'radius_b', of gears whose pitch circles touch, or 'ratio'"]
    if d["ratio"] is not None:
        return []
    e_a, _, gap = _touching(d, nodes)
    if not e_a.any():
        return ["its nodes a and b must not lie on one axis"]
    if gap <= GAP * min(d["radius_a"], d["radius_b"]):
        return []
    text = f"its pitch circles must touch at a point in the plane of both axes; they are {gap:.6g} m apart there"
    return [f"{text} (gears with a chain or other gears between them have a 'ratio' in place of 'radius_b')"]


def angles(d):
    """Return the angles that it holds, as in ``Kind.counts_angles``: those of both gears relative to the carrier."""
    carrier, a, b = d["nodes"]
    axis_b = d["axis_a"] if d["axis_b"] is None else d["axis_b"]
    return [("axis_a", d["axis_a"], (carrier, a)), ("axis_b", axis_b, (carrier, b))]


def sample(rng):
    """Return external, internal and bevel gears in general position, and a ratio."""
    frame, x = triad(rng.normal(size=3)), rng.normal(size=3)
    e, _, n = frame
    tilted = np.cos(1.2) * n + np.sin(1.2) * e
    pitch = x + 0.5 * e
    cases = [
        ({"radius_b": 0.3}, x + 0.8 * e),
        ({"radius_b": 0.9}, x - 0.4 * e),
        ({"radius_b": 0.3, "axis_b": tilted}, pitch + 0.3 * np.cross(np.cross(n, e), tilted)),
        ({"ratio": -2.5, "axis_b": tilted}, x + 2.0 * e),
    ]
    found = []
    for values, center in cases:
        nodes = [(rng.normal(size=3), np.eye(3)), (x, np.diag([-1.0, 1.0, -1.0])), (center, np.diag([1.0, -1.0, -1.0]))]
        found.append(({"axis_a": n, "radius_a": 0.5, **values}, nodes, ""))
    return found


_PAIR = Kind(
    name="gear_pair", section="joints", doc=__doc__, display=Display(shape="gears", support=False, pictures=("gears",)),
    fields=(
        Field(
            "nodes", TRIPLE, "-",
            "the carrier, and the centres of the gears a and b; one may be ground, a gear then at the carrier",
        ),
        Field("axis_a", DIRECTION, "-", "axis of a at the start, inertial; fixed in the carrier and in a"),
        Field("axis_b", DIRECTION, "-", "axis of b at the start, inertial; when absent, that of a", None),
        Field("radius_a", NUMBER, "m", "radius of the pitch circle of a", check=positive),
        Field("radius_b", NUMBER, "m", "radius of the pitch circle of b, which touches that of a", None, positive),
        Field(
            "ratio", NUMBER, "-",
            "angle_a over angle_b, < 0 if they rotate in opposite directions; instead of radius_b", None, not_zero,
        ),
    ),
    outputs=(
        *angle_outputs("rotation of a in the carrier about its axis since the start, over any number of turns", "_a"),
        *angle_outputs("rotation of b in the carrier about its axis since the start, over any number of turns", "_b"),
        Output("force", "N", "tangential force on a at radius_a, without friction; > 0 turns a about +axis_a"),
    ),
    memory=("angle_a", "angle_b"),
    commit=GEAR_MESH.commit,
    counts_angles=angles,
    **named(prepare, check, sample),
)  # fmt: skip
GEAR_PAIR = with_teeth(_PAIR, Mesh(GEAR_MESH, gear_travel, driver=0), _put_motion, "radius_a")
del _PAIR  # its record lacks the axes that `commit` reads: `mecano warmup` must not compile it

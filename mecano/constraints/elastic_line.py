r"""Record, strain, inertia and outputs shared by bars and cables (equations in elements/members/cable.py)."""

from mecano.constraints.along_coordinate.demand import is_formula, law_of
from mecano.constraints.joint_nodes import distance
from mecano.constraints.line import SHORTEST
from mecano.element_interface import Output
from mecano.jit.kernel import kernel
from mecano.laws.probe import curve_at
from mecano.maths.dual import at_least, number
from mecano.maths.vector import add_vec, dot, vec
from mecano.schema import NUMBER, Field, not_negative, positive

STRAIN_OF_STEEL = 2e-3  # at its yield strength
LINE_RECORD = {
    "EA": (), "inverse_area": (), "damping": (), "law": "i", "mass": (), "own": (), "cross": (), "gravity": 3,
}  # fmt: skip
DAMPING = Field("damping", NUMBER, "s", "tau: viscous over elastic stiffness", 0.0, not_negative)
AXIAL_STIFFNESS = Field("axial_stiffness", NUMBER, "N", "EA: force per strain", check=positive)
STRAINS = (
    Output("natural_length", "m", "length without force", geometric=True),
    Output("strain", "-", "extension over natural length"),
    Output("strain_rate", "1/s", "rate of the strain"),
)


@kernel
def strained(length, rate, L, L_rate):
    """Return the strain of a line of natural length L, and its rate."""
    L = at_least(L, SHORTEST)
    stretch = length / L
    return stretch - 1.0, (rate - stretch * L_rate) / L


@kernel
def add_line_inertia(p, a, f):
    """Add inertia forces and weight."""
    half_weight = 0.5 * p.mass * vec(p.gravity, 0)
    for i, j in ((0, 3), (3, 0)):
        add_vec(f, i, 1.0, p.own * vec(a, i) + p.cross * vec(a, j) - half_weight)


@kernel
def line_inertia(p, at, m):
    """Write the diagonal of the mass matrix."""
    for i in range(6):
        m[i] = p.own


@kernel
def put_line(p, y, length, L, strain, strain_rate, N):
    """Write the outputs."""
    y[0], y[1], y[2], y[3], y[4], y[5] = length, L, strain, strain_rate, N, N * p.inverse_area


@kernel
def put_no_push(y):
    """Write tension and stress of a cable, clipped at zero.

    When an accepted step ends where the cable goes slack, its tension is zero within round-off, of either sign.
    """
    y[4], y[5] = at_least(number(y[4]), 0.0), at_least(number(y[5]), 0.0)


@kernel
def put_line_energy(p, q, v, e):
    """Write the kinetic energy and the potential energy of the weight."""
    v_0, v_1, g = vec(v, 0), vec(v, 3), vec(p.gravity, 0)
    e[0] = 0.5 * p.own * (dot(v_0, v_0) + dot(v_1, v_1)) + p.cross * dot(v_0, v_1)
    e[1] = -0.5 * p.mass * dot(g, vec(q, 0) + vec(q, 3))


@kernel
def add_strain_energy(elastic, viscous, strain, strain_rate, L, L_rate, e):
    """Add the elastic energy EA eps^2 L/2 of a line [J]; write the power dissipated, and the power given by dL/dt [W].

    ``elastic`` and ``viscous`` are the parts of its tension [N].
    """
    e[1] += 0.5 * elastic * strain * L
    e[2] = viscous * L * strain_rate
    e[3] = -(elastic * (1.0 + 0.5 * strain) + viscous * (1.0 + strain)) * L_rate


def line_record(d, nodes, context):
    """Return the values of ``LINE_RECORD``; the natural length defaults to that of the pretension at the start.

    If it is a formula, it is not known yet, and the mass is that of the initial distance.
    """
    natural = distance(nodes) / (1.0 + prestrain(d)) if d["natural_length"] is None else d["natural_length"]
    known = distance(nodes) if is_formula(natural) else natural
    mass, area = d["mass_per_length"] * curve_at(known, 0.0)[0], d["area"]
    own, cross = (mass / 3, mass / 6) if d["mass_distribution"] == "consistent" else (mass / 2, 0.0)
    return {
        "EA": axial_stiffness(d),
        "inverse_area": 0.0 if area is None else 1.0 / area,
        "damping": d["damping"],
        "law": law_of(natural, context),
        "mass": mass, "own": own, "cross": cross, "gravity": context.gravity,
    }  # fmt: skip


def axial_stiffness(d):
    """Return EA [N]."""
    return d["E"] * d["area"] if d["axial_stiffness"] is None else d["axial_stiffness"]


def prestrain(d):
    """Return the strain of the pretension."""
    return d["pretension"] / axial_stiffness(d)

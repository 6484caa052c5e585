r"""Bar and cable: an elastic line between two nodes; a cable carries tension only.

With the length :math:`\ell`, the natural length :math:`L(t)`, the axial stiffness EA and the damping time
:math:`\tau`:

.. math::  \varepsilon = \frac{\ell - L}{L}, \qquad N = EA\,(\varepsilon + \tau \dot\varepsilon), \qquad
   f_1 = -f_0 = N u, \qquad V = \tfrac12 EA\, L\, \varepsilon^2

A cable is taut as long as both :math:`\varepsilon` and :math:`\varepsilon + \tau \dot\varepsilon` are positive: it
never pushes, with damping either. The change from slack to taut and back is an event. What is left of the elastic
energy when it goes slack with :math:`\varepsilon > 0` is dissipated while it shortens to its natural length.

A natural length that changes does work, which is given by the surroundings (a winder). With
:math:`N_d = N - EA\varepsilon` (:math:`-EA\varepsilon` in a cable that is slack and still longer than L) the powers are

.. math::  P_{dissipated} = N_d L \dot\varepsilon, \qquad
   P_{given} = -[EA\,\varepsilon\,(1 + \varepsilon/2) + N_d\,(1 + \varepsilon)]\, \dot L

The mass, that of the natural length at t = 0, stays. It is consistent with the linear velocity between the nodes,
:math:`\frac{m}{6}\begin{bmatrix} 2 & 1 \\ 1 & 2 \end{bmatrix}` for each component, or one half at each node.
"""

import numpy as np
from numba import njit

from mecano.constraints.joint_frame import at_one_place
from mecano.constraints.line import SHORTEST, add_line_force, line
from mecano.contract import Event, Kind, Output, record
from mecano.laws.probe import curve_at
from mecano.laws.table import evaluate_curve
from mecano.maths.vec import EYE, add, add_mat, add_vec, dot, scale, sub, vec
from mecano.schema import CURVE, NODE_PAIR, NUMBER, Field, choice, not_negative, positive

RECORD = record(EA=(), inverse_area=(), damping=(), law="i", mass=(), own=(), cross=(), gravity=3)
TAUT = 0  # a bar is always in this mode
CABLE_MODES = ("taut", "slack")


@njit
def _strain(p, laws, t, length, rate):
    """Strain, its rate, natural length and its rate."""
    L, L_rate, _ = evaluate_curve(laws, p.law, t)
    L = max(L, SHORTEST)
    stretch = length / L
    return stretch - 1.0, (rate - stretch * L_rate) / L, L, L_rate


@njit
def force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """Tension, inertia and weight."""
    half_weight = scale(0.5 * p.mass, vec(p.gravity, 0))
    for i, j in ((0, 3), (3, 0)):
        add_vec(f, i, 1.0, sub(add(scale(p.own, vec(a, i)), scale(p.cross, vec(a, j))), half_weight))
        add_mat(M, i, i, p.own, EYE)
        add_mat(M, i, j, p.cross, EYE)
    if mode != TAUT:
        return
    length, rate, geometry = line(q, v)
    strain, strain_rate, L, L_rate = _strain(p, laws, t, length, rate)
    N = p.EA * (strain + p.damping * strain_rate)
    N_length = p.EA / L * (1.0 - p.damping * L_rate / L)
    add_line_force(f, K, C, rate, geometry, N, N_length, p.EA * p.damping / L)


@njit
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Length, strain, tension, stress; energies."""
    length, rate, _ = line(q, v)
    strain, strain_rate, L, L_rate = _strain(p, laws, t, length, rate)
    elastic = p.EA * strain if mode == TAUT or strain > 0.0 else 0.0
    N = p.EA * (strain + p.damping * strain_rate) if mode == TAUT else 0.0
    viscous = N - elastic
    y[0], y[1], y[2], y[3], y[4], y[5] = length, L, strain, strain_rate, N, N * p.inverse_area
    v_0, v_1, g = vec(v, 0), vec(v, 3), vec(p.gravity, 0)
    e[0] = 0.5 * p.own * (dot(v_0, v_0) + dot(v_1, v_1)) + p.cross * dot(v_0, v_1)
    e[1] = 0.5 * elastic * strain * L - 0.5 * p.mass * dot(g, add(vec(q, 0), vec(q, 3)))
    e[2] = viscous * L * strain_rate
    e[3] = -(elastic * (1.0 + 0.5 * strain) + viscous * (1.0 + strain)) * L_rate


@njit
def event_values(p, m, mode, t, laws, q, v, a, R, g):
    """How taut the cable is: the lesser of the elastic strain and the whole, which the tension follows."""
    length, rate, _ = line(q, v)
    strain, strain_rate, _, _ = _strain(p, laws, t, length, rate)
    tautness = min(strain, strain + p.damping * strain_rate)
    g[0] = tautness
    g[1] = -tautness


def prepare(d, nodes, context):
    """Record of one bar or cable; its natural length is the initial distance unless given."""
    distance = float(np.linalg.norm(np.subtract(nodes[1][0], nodes[0][0])))
    natural = distance if d["natural_length"] is None else d["natural_length"]
    mass, area = d["mass_per_length"] * curve_at(natural, 0.0)[0], d["area"]
    own, cross = (mass / 3, mass / 6) if d["mass_distribution"] == "consistent" else (mass / 2, 0.0)
    return {
        "EA": d["young_modulus"] * area if d["axial_stiffness"] is None else d["axial_stiffness"],
        "inverse_area": 0.0 if area is None else 1.0 / area,
        "damping": d["damping"],
        "law": context.laws.add(natural),
        "mass": mass, "own": own, "cross": cross, "gravity": context.gravity,
    }  # fmt: skip


def check(d, nodes):
    """The line has a direction and a natural length at the start, and one axial stiffness."""
    texts = at_one_place(nodes)
    if (d["axial_stiffness"] is None) == (d["young_modulus"] is None):
        texts.append("give either 'axial_stiffness' or 'young_modulus' with 'area'")
    elif d["young_modulus"] is not None and d["area"] is None:
        texts.append("'area' is missing: 'young_modulus' alone gives no axial stiffness")
    if d["natural_length"] is not None and not curve_at(d["natural_length"], 0.0)[0] > 0.0:
        texts.append("'natural_length' must be greater than zero at t = 0")
    return texts


def sample_bar(rng):
    """A heavy bar that is pushed, a lumped one with a section whose natural length grows."""
    growing = (("linear", {"slope": 0.4, "offset": 1.0}),)
    given = {"axial_stiffness": 50.0, "mass_per_length": 2.0, "natural_length": 1.9, "damping": 0.3}
    lumped = {
        "young_modulus": 200.0, "area": 0.1, "natural_length": growing, "damping": 0.2, "mass_per_length": 0.7,
        "mass_distribution": "lumped",
    }  # fmt: skip
    return [(given, _apart(rng, 1.5), ""), (lumped, _apart(rng, 2.0), "")]


def sample_cable(rng):
    """Taut while it is wound up, and slack."""
    d = {"axial_stiffness": 80.0, "area": 0.01, "mass_per_length": 0.5, "damping": 0.05}
    wound = (("linear", {"slope": -0.3, "offset": 1.5}),)
    return [
        ({**d, "natural_length": wound}, _apart(rng, 2.0), "taut"),
        ({**d, "natural_length": 3.0}, _apart(rng, 2.0), "slack"),
    ]


def _apart(rng, distance):
    x, direction = rng.normal(size=(2, 3))
    return [(x, np.eye(3)), (x + distance * direction / np.linalg.norm(direction), np.eye(3))]


FIELDS = (
    Field("nodes", NODE_PAIR, "-", "its two nodes, not at the same place"),
    Field("axial_stiffness", NUMBER, "N", "EA: force per strain; or give young_modulus and area", None, positive),
    Field("young_modulus", NUMBER, "Pa", "Young's modulus, where axial_stiffness is not given", None, positive),
    Field("area", NUMBER, "m2", "area of the cross-section; without it the stress is written as zero", None, positive),
    Field("natural_length", CURVE, "m", "length without force, as a function of time [s]; the initial distance", None),
    Field("damping", NUMBER, "s", "tau: viscous over elastic stiffness", 0.0, not_negative),
    Field("mass_per_length", NUMBER, "kg/m", "mass per natural length at t = 0", 0.0, not_negative),
    Field("mass_distribution", choice("consistent", "lumped"), "-", "how the nodes share the mass", "consistent"),
)
OUTPUTS = (
    Output("length", "m", "distance of the nodes"),
    Output("natural_length", "m", "length without force"),
    Output("strain", "-", "extension over natural length"),
    Output("strain_rate", "1/s", "rate of the strain"),
    Output("tension", "N", "axial force; > 0 pulls the nodes together"),
    Output("stress", "Pa", "axial force over area"),
)

BAR = Kind(
    name="bar",
    section="elements",
    doc="Bar: an elastic line between two nodes that pulls and pushes.\n\n" + __doc__,
    dtype=RECORD,
    layout=("x0", "x1"),
    fields=FIELDS,
    outputs=OUTPUTS,
    prepare=prepare,
    check=check,
    force=force,
    observe=observe,
    sample=sample_bar,
)

CABLE = Kind(
    name="cable",
    section="elements",
    doc="Cable: an elastic line between two nodes that carries tension only.\n\n" + __doc__,
    dtype=RECORD,
    layout=("x0", "x1"),
    fields=FIELDS,
    outputs=OUTPUTS,
    modes=CABLE_MODES,
    events=(
        Event("goes taut", "slack", "taut", "the length rises to the natural length"),
        Event("goes slack", "taut", "slack", "the tension falls to zero"),
    ),
    prepare=prepare,
    check=check,
    force=force,
    observe=observe,
    event_values=event_values,
    sample=sample_cable,
)

r"""Spring-damper: a force along the line between two nodes, from a law of its extension and rate.

With :math:`d = x_1 - x_0`, the length :math:`\ell = |d|` and :math:`u = d/\ell` (theory.md section 3):

.. math::  e = \ell - \ell_0, \qquad \dot e = u \cdot (v_1 - v_0), \qquad N = N(e, \dot e), \qquad f_1 = -f_0 = N u

N > 0 pulls the nodes together.
"""

import numpy as np

from mecano.constraints.along_coordinate.signal import SIGNAL
from mecano.constraints.coordinates.distance import DISTANCE
from mecano.constraints.joint_frame import at_one_place
from mecano.constraints.line import line
from mecano.constraints.stop_phases import EVENTS, PHASES, law_record, put_stop_events
from mecano.element_interface import Display, Kind, Measured, Output, Part, record
from mecano.jit.kernel import kernel
from mecano.laws.table import evaluate_force, law_force, potential
from mecano.maths.dual import number
from mecano.maths.vector import add_vec
from mecano.schema import LAW, NODE_PAIR, NUMBER, Field, not_negative

RECORD = record(law="i", natural_length=(), low=(), high=())


@kernel
def residual(p, at, f):
    """Add equal and opposite forces along the line."""
    length, rate, (_, u, _) = line(at.q, at.v)
    N = law_force(at.laws, p.law, length - p.natural_length, rate)
    add_vec(f, 0, -N, u)
    add_vec(f, 3, N, u)


@kernel
def observe(p, at, F, y, e):
    """Write length, extension, rate, force, stroke; energies."""
    length, rate, _ = line(at.q, at.v)
    extension = length - p.natural_length
    N, _, _ = evaluate_force(at.laws, p.law, extension, rate)
    elastic, _, _ = evaluate_force(at.laws, p.law, extension, 0.0)
    y[0] = length
    y[1] = extension
    y[2] = rate
    y[3] = N
    y[4] = -extension
    e[1] = potential(at.laws, p.law, extension)
    e[2] = (N - elastic) * rate


@kernel
def event_values(p, at, g):
    """Write the event values of the stops of the law."""
    put_stop_events(g, p.low, p.high, line(at.q, at.v)[0] - p.natural_length)


def prepare(d, nodes, context):
    """Return the record of one spring; the natural length defaults to the initial distance."""
    distance = np.linalg.norm(np.subtract(nodes[1][0], nodes[0][0]))
    natural = d["natural_length"]
    return {"natural_length": distance if natural is None else natural, **law_record(d["law"], context)}


def check(d, nodes):
    """Check that the line has an initial direction."""
    return at_one_place(nodes)


def sample(rng):
    """Return a landing gear strut between its stops and on them, and a nonlinear spring with a natural length."""
    strut = (
        ("gas_spring", {"force": rng.uniform(5, 9), "length": rng.uniform(8, 9), "exponent": 1.3}),
        ("oil_damper", {"compression": 2.0, "rebound": 5.0}),
        ("stop", {"stiffness": 30.0, "lower": -0.4, "upper": 0.4, "damping": 0.1}),
        ("dry_friction", {"force": 1.5, "regularization": 0.6}),
    )
    cubic = (("polynomial", {"coefficients": [1.0, 20.0, 0.0, 7.0]}), ("damper", {"coefficient": 3.0}))
    samples = []
    for phase, length in zip(PHASES, (1.0, 2.0, 3.0), strict=True):
        x, line = rng.normal(size=(2, 3))
        nodes = [(x, np.eye(3)), (x + length * line / np.linalg.norm(line), np.eye(3))]
        samples.append(({"law": strut, "natural_length": 2.0}, nodes, phase))
    return [*samples, ({"law": cubic}, 2, "between")]


@kernel
def force_residual(p, at, f):
    """Add the row of the sensor of the force."""
    length, rate, _ = line(at.q, at.v)
    f[6] += number(at.q[6]) - law_force(at.laws, p.law, length - p.natural_length, rate)


def _measured(zero):
    return lambda d, nodes, context: Measured(DISTANCE, (0, 1), {}, zero(prepare(d, nodes, context)))


def _measured_force(d, nodes, context):
    return Part(FORCE_SENSOR, (0, 1), prepare(d, nodes, context))


FORCE_SENSOR = Kind(
    name="spring_force_sensor", section="", doc="Sensor of the axial force of a spring-damper.", dtype=RECORD,
    layout=("x0", "x1"), residual=force_residual, **SIGNAL,
)  # fmt: skip
SPRING_DAMPER = Kind(
    name="spring_damper",
    section="elements",
    doc=__doc__,
    display=Display("spring", pictures=("struts", "drop_test"), axial="force"),
    dtype=RECORD,
    layout=("x0", "x1"),
    fields=(
        Field("nodes", NODE_PAIR, "-", "its two nodes, not at the same place"),
        Field("law", LAW, "-", "axial force [N] from extension [m] and rate [m/s]; > 0 pulls the nodes together"),
        Field(
            "natural_length", NUMBER, "m", "length at the extension zero; the initial distance when absent", None,
            not_negative,
        ),
    ),
    outputs=(
        Output("length", "m", "distance of the nodes", rate="rate"),
        Output("extension", "m", "length - natural length", rate="rate"),
        Output("rate", "m/s", "rate of the extension"),
        Output("force", "N", "axial force; > 0 pulls the nodes together"),
        Output("stroke", "m", "compression: natural length - length"),
    ),
    phases=PHASES,
    events=EVENTS,
    prepare=prepare,
    check=check,
    strains=(-0.5, 0.5),
    residual=residual,
    observe=observe,
    event_values=event_values,
    sample=sample,
    measures={
        "length": _measured(lambda p: 0.0), "extension": _measured(lambda p: p["natural_length"]),
        "force": _measured_force,
    },
)  # fmt: skip

r"""Spring-damper: a force along the line between two nodes, from a law of its extension and rate.

With :math:`d = x_1 - x_0`, the length :math:`\ell = |d|` and :math:`u = d/\ell`:

.. math::  e = \ell - \ell_0, \qquad \dot e = u \cdot (v_1 - v_0) - \dot\ell_0, \qquad N = N(e, \dot e), \qquad
   f_1 = -f_0 = N u

N > 0 pulls the nodes together. The natural length :math:`\ell_0` may be a law of time or a formula of signals: the
set point of an elastic actuator, whose power :math:`-N\dot\ell_0` the surroundings give. With a ``stress_free``
activation the extension counts from that instant.
"""

from mecano.constraints.activation import SHIFT, since_activation, with_activation
from mecano.constraints.along_coordinate.demand import is_formula, on_demand, with_rate
from mecano.constraints.along_coordinate.law import LAW_RECORD, extension, law_values, report, set_point_of_law
from mecano.constraints.coordinates.distance import DISTANCE
from mecano.constraints.joint_nodes import check_apart, distance
from mecano.constraints.line import add_line_force, line
from mecano.constraints.release import with_release
from mecano.constraints.stop_phases import EVENTS, PHASES, put_stop_events
from mecano.element_interface import Display, Kind, Measured, Output, named, record
from mecano.jit.kernel import kernel
from mecano.laws.law_table import law_force
from mecano.laws.probe import curve_at, table_bounds
from mecano.schema import CONTINUOUS_DRIVE, LAW, NODE_PAIR, Field, not_negative

RECORD = record(**LAW_RECORD)


def _functions(set_point):
    """Return ``residual``, ``observe`` and ``event_values`` for a natural length (p, at) -> (value, rate)."""

    @kernel
    def residual(p, at, f):
        (length, rate, (_, u, _)), point = line(at.q, at.v), set_point(p, at)
        add_line_force(f, law_force(at.laws, p.law, extension(p, point, length), rate - point[1]), u)

    @kernel
    def observe(p, at, F, y, e):
        """Write length l [m], extension l - l_0 [m], dl/dt [m/s], force N [N], stroke l_0 - l [m], d(l - l_0)/dt [m/s].

        Energies: the potential of the law in e[1] [J], the power dissipated in e[2] and given by l_0 in e[3] [W].
        """
        length, rate, _ = line(at.q, at.v)
        point = set_point(p, at)
        y[0] = length
        y[1] = extension(p, point, length)
        y[2] = rate
        report(p, at, point, length, rate, y[3:], e)
        y[4] = -extension(p, point, length)
        y[5] = rate - point[1]

    @kernel
    def event_values(p, at, g):
        put_stop_events(g, p.low, p.high, extension(p, set_point(p, at), line(at.q, at.v)[0]))

    return named(residual, observe, event_values)


def prepare(d, nodes, context):
    """Return the record of one spring; the natural length defaults to the initial distance."""
    natural = distance(nodes) if d["natural_length"] is None else d["natural_length"]
    return law_values({}, d["law"], natural, context)


def check(d, nodes):
    """Check that the line has an initial direction, and that the natural length is not negative at the start."""
    texts, natural = check_apart(d, nodes), d["natural_length"]
    if natural is None or is_formula(natural):
        return texts
    error = not_negative(curve_at(natural, 0.0)[0])
    return [*texts, f"'natural_length' {error} at t = 0"] if error else texts


STRUT = (
    ("gas_spring", {"force": 7.0, "length": 8.5, "exponent": 1.3}),
    ("oil_damper", {"compression": 2.0, "rebound": 5.0}),
    ("stop", {"stiffness": 30.0, "lower": -0.4, "upper": 0.4, "damping": 0.1}),
    ("dry_friction", {"force": 1.5, "regularization": 0.6}),
)  # of samples, as the next one
CUBIC = (("polynomial", {"coefficients": [1.0, 20.0, 0.0, 7.0]}), ("damper", {"coefficient": 3.0}))


def _stress_free(set_point):
    """Return the functions and the memory of a spring whose extension counts from its activation."""

    @kernel
    def commit(p, at, m_out):
        m_out[0] = extension(p, set_point(p, at), line(at.q, at.v)[0])

    return {**_functions(since_activation(set_point, 0)), "memory": (SHIFT,), "commit": commit}


def _spring(functions):
    """Return the Kind of a spring with these ``functions`` of its set point, and with a release."""
    kind = Kind(
        name="spring_damper", section="elements", doc=__doc__,
        display=Display("spring", pictures=("struts", "drop_test"), axial="force"), dtype=RECORD, layout=("x0", "x1"),
        fields=(
            Field("nodes", NODE_PAIR, "-", "its two nodes, not at the same place"),
            Field("law", LAW, "-", "axial force [N] from extension [m] and rate [m/s]; > 0 pulls the nodes together",
                  argument="m"),
            Field("natural_length", CONTINUOUS_DRIVE, "m",
                  "length at the extension zero; the initial distance when absent", None),
        ),
        outputs=(
            Output("length", "m", "distance of the nodes", rate="rate"),
            Output("extension", "m", "length - natural length", rate="extension_rate"),
            Output("rate", "m/s", "rate of the length"),
            Output("force", "N", "axial force; > 0 pulls the nodes together"),
            Output("stroke", "m", "compression: natural length - length", geometric=True),
            Output("extension_rate", "m/s", "rate of the extension"),
        ),
        phases=PHASES,
        events=EVENTS,
        strains=(-0.5, 0.5),
        cases=({"law": STRUT, "natural_length": 2.2}, {"law": CUBIC}, {"law": CUBIC, "natural_length": None}),
        **named(prepare, check),
        bounds=lambda d: table_bounds("extension", d["law"], "the force"),
        measures={"length": lambda d, nodes, context: Measured(DISTANCE, (0, 1), {})},
    )  # fmt: skip
    return with_release(on_demand(kind, functions, "natural_length", set_point_of_law, with_rate), "spring", (3,))


SPRING_DAMPER = with_activation(_spring(_functions), "spring", (3,), (_spring(_stress_free), (1, 3, 4, 5)))

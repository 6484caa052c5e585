r"""Cable that slides over pulleys: tackles, cranes, elevators, tendons; one tension along all of it without friction.

It runs through ``nodes`` in their order, from a point to a point, to which it is fixed. Each node between them is the
centre of a pulley, on a body or the ground, and has a radius: positive where the cable turns counter-clockwise about
the ``axis``, negative where it turns clockwise. The pulleys need neither a body nor a hinge of their own, because the
cable does not turn them: on pulleys with inertia or a torque use a ``belt``, which does not slip. A node between the
ends whose radius is zero is an eyelet: the cable slides through this point, in any direction.

A span from node i to node j is along the common tangent of both circles; on a pulley of the radius :math:`\rho_i` (zero
at a point) the cable lies on an arc from the direction :math:`\psi_i^-` of the span before to that of the span after,
:math:`\psi_i^+`, over any number of turns. With :math:`d = x_j - x_i`, the length of its path is

.. math::  \ell = \sum \sqrt{|d|^2 - (\rho_j - \rho_i)^2} + \sum \rho_i\,(\psi_i^+ - \psi_i^-)

With the natural length :math:`L(t)`, its value at the start plus the ``payout`` (a law of time or a signal), the axial
stiffness EA and the damping time :math:`\tau`, the forces on all nodes follow from the gradient of the length:

.. math::  \varepsilon = \frac{\ell - L}{L}, \qquad N = EA\,(\varepsilon + \tau \dot\varepsilon), \qquad
   f = N\, \partial \ell/\partial q, \qquad V = \tfrac12 EA\, L\, \varepsilon^2

as in a ``cable``, with the same events: it is taut while :math:`\varepsilon` and
:math:`\varepsilon + \tau\dot\varepsilon` are positive, and its viscous tension is at most as large as the elastic one.
The power given by a varying natural length is also that of a cable. The cable has no mass. With ``friction`` on pulleys
and eyelets each span has its own tension (capstan friction). A ``release`` cuts the cable: its outputs are then zero.

The natural length of a cable with ``activate`` follows from the path at the start; with ``stress_free`` it follows from
the path at the activation, where the tension is ``pretension``, and only the payout from then on is added. Arcs are
counted from the start in both cases. Before the activation the nodes may be anywhere; where no path is possible, the
outputs are zero.

The length is exact for parallel axes and pulleys in one plane, and small inclinations of a span to the planes of its
pulleys are allowed (``inclination``). Arcs at the start must be less than one turn. The run ends where the cable leaves
a pulley, because the arc would become negative and the path change, and where a span vanishes.
"""

import math
from dataclasses import replace
from functools import cache, partial

import numpy as np

from mecano.constraints.activation import is_stress_free, with_activation
from mecano.constraints.along_coordinate.demand import is_formula, law_of, reads_of
from mecano.constraints.belt_span import CLOSEST, INCLINATION, check_tangent, span_record
from mecano.constraints.capstan import CAPSTAN, capstan, friction_field
from mecano.constraints.elastic_line import AXIAL_STIFFNESS, DAMPING, STRAINS, add_strain_energy
from mecano.constraints.joint_samples import rotation
from mecano.constraints.line_phases import EVENTS, PHASES, TAUT, follows, is_damped, pulled, put_line_events
from mecano.constraints.reeved_path import (
    arc,
    lost,
    path_record,
    path_unknowns,
    payout_of,
    pull,
    shifted_path,
    span,
    strain_by,
)
from mecano.constraints.release import SAMPLE, check_release, detached, elastic_release
from mecano.constraints.triads import triad
from mecano.element_interface import Display, Kind, Output, Part, named, record
from mecano.jit.kernel import kernel
from mecano.laws.probe import curve_at
from mecano.maths.dual import at_least, number, select, value
from mecano.maths.vector import add_vec, dot, mat, norm
from mecano.schema import BOOLEAN, CONTINUOUS_DRIVE, DIRECTION, NODES, NUMBER, NUMBERS, Field, not_negative

LIFTED = 0.01  # [rad]: the length of a path off a pulley by this angle is in error by less than its square
TURN = 2.0 * np.pi
NO_AXIS = (0.0, 0.0, 1.0)  # of a cable without pulleys


@kernel
def _add_tension(p, at, f, N):
    """Add the tension N along each span, and its moment at each pulley."""
    for i in range(len(p.radii) - 1):
        d, _, free = span(p, at.q, i)
        pull(f, i, (N / free) * d)
    for i in range(1, len(p.radii) - 1):
        if p.radii[i] == 0.0:
            continue
        _, before, behind, turning = arc(p, at, i)
        couple = N * p.radii[i]
        pull(f, i - 1, couple * before)
        pull(f, i, couple * behind)
        add_vec(f, 6 * i, couple, turning)


@kernel
def _put_closeness(p, at, y):
    """Write how close neighbours are."""
    for i in range(len(p.radii) - 1):
        d, delta, _ = span(p, at.q, i)
        y[8] = at_least(number(y[8]), abs(delta) / norm(d))


@kernel
def _put_arcs(p, at, y):
    """Write how the path lies on the pulleys: the angles of the arcs, the largest inclination and lift-off."""
    for i in range(1, len(p.radii) - 1):
        if p.radii[i] == 0.0:
            continue
        angle, _, _, _ = arc(p, at, i)
        wrap = select(p.radii[i] > 0.0, angle, -angle)
        axis = mat(at.R[i - 1]) @ mat(p.axes[i - 1]).z
        for k in (i - 1, i):
            d, _, _ = span(p, at.q, k)
            y[6] = at_least(number(y[6]), abs(dot(axis, d)) / norm(d))
        y[7] = at_least(number(y[7]), -wrap)
        y[8 + i] = wrap


def _functions(strain_of):
    """Return ``residual``, ``observe`` and ``event_values`` for the strain of reeved_path.strain_by."""

    @kernel
    def residual(p, at, f):
        if at.phase == TAUT or follows(p, at):
            _, _, strain, strain_rate, _, _ = strain_of(p, at)
            _add_tension(p, at, f, p.EA * pulled(p, at, strain, strain_rate)[1])

    @kernel
    def observe(p, at, F, y, e):
        """Write lengths, strains, tension, state, how the path lies on the pulleys; energies."""
        length, _, strain, strain_rate, L, L_rate = strain_of(p, at)
        _put_closeness(p, at, y)
        if not math.isfinite(value(strain_rate)):  # there is no path
            y[8] = at_least(number(y[8]), 1.0)
            return
        elastic, tension = pulled(p, at, strain, strain_rate)
        elastic, N = p.EA * elastic, p.EA * tension
        y[0], y[1], y[2], y[3], y[4] = length, L, strain, strain_rate, at_least(N, 0.0)
        y[5] = 1.0 if at.phase == TAUT else 0.0
        _put_arcs(p, at, y)
        add_strain_energy(elastic, N - elastic, strain, strain_rate, L, L_rate, e)

    @kernel
    def event_values(p, at, g):
        _, _, strain, strain_rate, _, _ = strain_of(p, at)
        if lost(p, at):
            strain, strain_rate = -1.0, 0.0
        put_line_events(g, at.phase == TAUT, strain, strain_rate, p.damping)

    return named(residual, observe, event_values)


def _frame(d):
    """Return the triad (3, 3) of the axis of the pulleys; of any axis without pulleys."""
    return triad(NO_AXIS if d["axis"] is None else d["axis"])


def _start(d, nodes):
    """Return axes (n - 2, 3, 3) and arcs (n - 2,) [rad] of the pulleys, and the length of the path [m]."""
    frame, radii = _frame(d), np.array(d["radii"])
    ends = [(np.asarray(x, float), frame, np.eye(3), radius) for (x, _), radius in zip(nodes, radii, strict=True)]
    spans = [span_record(*pair) for pair in zip(ends, ends[1:], strict=False)]
    turned = np.array([b["angle_0"] - a["angle_1"] for a, b in zip(spans, spans[1:], strict=False)])
    side = np.sign(radii[1:-1])
    arcs = side * ((side * turned + LIFTED) % TURN - LIFTED)
    axes = np.array([frame @ R for _, R in nodes[1:-1]])
    return axes, arcs, sum(span["length"] for span in spans) + radii[1:-1] @ arcs


def prepare(d, nodes, context):
    """Return the record."""
    axes, arcs, length = _start(d, nodes)
    prestrain = d["pretension"] / d["axial_stiffness"]
    return {
        "EA": d["axial_stiffness"], "damping": d["damping"], "radii": d["radii"], "axes": axes, "start": arcs,
        "natural": length / (1.0 + prestrain), "prestrain": prestrain,
        "law": law_of(d["payout"], context),
    }  # fmt: skip


def parts(d, nodes, context):
    """Return the Part of the friction, if there is any."""
    if d["friction"] is None:
        return []
    kind = capstan(len(nodes) - 2, is_formula(d["payout"]), REEVED_CABLE.chosen(d).phases, is_stress_free(d))
    values = {**prepare(d, nodes, context), **d["friction"]}
    return [Part(kind, tuple(range(len(nodes))), values, reads=reads_of(d["payout"]))]


def check(d, nodes):
    """Return errors in the number of nodes and radii, of pulleys that overlap, and in the length at the start."""
    names, radii = d["nodes"], d["radii"]
    if len(names) != len(radii):
        return [f"'radii' must have {len(names)} numbers, one for each node; it has {len(radii)}"]
    if len(names) < 3:
        return ["'nodes' must name two points and the pulleys between them; a cable without pulleys is a 'cable'"]
    texts = _check_pulleys(d, nodes) + _check_friction(d) + check_release(d, [])
    return texts or _check_length(d, nodes)


def _check_pulleys(d, nodes):
    """Return errors in the radii, and for neighbours that leave no tangent between them."""
    names, radii = d["nodes"], d["radii"]
    texts = [
        f"'radii': the cable ends at '{names[i]}', a point with the radius 0; a drum at an end needs a 'belt'"
        for i in (0, -1) if radii[i]
    ]  # fmt: skip
    if any(radii) and d["axis"] is None:
        texts.append("missing 'axis', that of the pulleys, about which a radius > 0 means counter-clockwise")
    frame = _frame(d)
    for i in range(len(names) - 1):
        ends = slice(i, i + 2)
        texts += check_tangent(names[ends], [x for x, _ in nodes[ends]], radii[ends], frame)
    return texts


def _check_friction(d):
    """Return errors in the number and signs of the coefficients of friction."""
    if d["friction"] is None:
        return []
    coefficients, pulleys, texts = d["friction"]["coefficients"], len(d["nodes"]) - 2, []
    if len(coefficients) != pulleys:
        texts.append(
            f"'friction' needs {pulleys} coefficients, one for each pulley and eyelet; it has {len(coefficients)}"
        )
    if min(coefficients, default=0.0) < 0.0:
        texts.append("'friction' needs coefficients that are not negative")
    return texts


def _check_length(d, nodes):
    """Return an error in the natural length at the start."""
    if d["payout"] is None or is_formula(d["payout"]):
        return []
    length, paid_out = _start(d, nodes)[2], curve_at(d["payout"], 0.0)[0]
    if length + paid_out > 0.0:
        return []
    return [f"'payout' is {paid_out:.4g} m at t = 0, and the cable is {length:.4g} m long"]


def _leaving(d, output):
    """Return a text on the pulley that the cable has left, by the function ``output`` (name) -> value."""
    i = min(range(1, len(d["nodes"]) - 1), key=lambda i: output(f"wrap_{i}"))
    return f"leaves pulley {i}, at node '{d['nodes'][i]}', where its arc (wrap_{i}) falls below zero"


@cache
def _of(n, by_signal, released, stress_free):
    wraps = (Output(f"wrap_{i}", "rad", f"angle of the arc on pulley {i}", geometric=True) for i in range(1, n + 1))
    outputs = (*OUTPUTS, *wraps)
    found = replace(_ALWAYS_ACTIVE, variant=None, outputs=outputs, dtype=record(**path_record(n)), **path_unknowns(n))
    payout = payout_of(n, by_signal)
    if by_signal:
        found = replace(found, inputs=("payout",), **_functions(strain_by(payout)))
    if stress_free:
        unknowns, strain_of = shifted_path(n, payout)
        found = replace(found, **unknowns, **_functions(strain_of))
    return detached(found, "cable", tuple(range(len(outputs)))) if released else found


def sample(rng):
    """Return a cable over two pulleys that is hauled in, taut and slack, and one around a single pulley.

    Some are released or activated.
    """
    places = np.array([[0.0, 0.0, 0.0], [0.4, 0.05, 1.0], [1.4, 0.0, 1.1], [1.8, -0.03, 0.2]])
    nodes = [(x, rotation(rng)) for x in places]
    hauled = (("linear", {"slope": -0.3, "offset": 0.1}),)
    d = {
        "nodes": ["a", "b", "c", "d"], "radii": [0.0, -0.2, -0.15, 0.0], "axis": [0.0, 1.0, 0.0],
        "axial_stiffness": 50.0, "pretension": 20.0, "damping": 0.1, "payout": hauled,
    }  # fmt: skip
    single = {**d, "nodes": ["a", "b", "d"], "radii": [0.0, 0.2, 0.0]}
    threaded, apart = {**d, "radii": [0.0] * 4, "axis": None}, [(x + rng.normal(size=3) / 3.0, R) for x, R in nodes]
    rough = [{**d, "friction": {"coefficients": [0.3, 0.1], "regularization": u}} for u in (0.01, 30.0)]
    released = [({**one, **SAMPLE}, nodes, phase) for one in (d, rough[0]) for phase in (*PHASES, "released")]
    taken = {"time": 0.3, "when": None, "stress_free": True}
    activated = [({**one, "activate": taken}, nodes, at) for one in (d, rough[0]) for at in ("taut", "inactive")]
    return [
        *released, *activated, (d, nodes, "taut"), ({**d, "payout": 3.0}, nodes, "slack"),
        (single, [*nodes[:2], nodes[3]], "taut"), (threaded, apart, "taut"),
        ({**d, "radii": [0.0, 0.0, -0.15, 0.0]}, nodes, "taut"),
        ({**threaded, "friction": rough[1]["friction"]}, apart, "taut"),
        *((one, nodes, "taut") for one in (*rough, {**rough[0], "radii": [0.0, 0.0, -0.15, 0.0]})),
        ({**rough[0], "payout": 3.0}, nodes, "slack"),
        *(({**one, "payout": "0.1*command"}, nodes, "taut") for one in (d, rough[0])),
    ]  # fmt: skip


FIELDS = (
    Field("nodes", NODES, "-", "a point, the centres of the pulleys as the cable runs, and a point"),
    Field("radii", NUMBERS, "m", "radius at each node, > 0 counter-clockwise about the axis; 0: ends and eyelets"),
    Field("axis", DIRECTION, "-", "axis of all pulleys at the start, inertial; fixed in their nodes", None),
    AXIAL_STIFFNESS,
    Field("pretension", NUMBER, "N", "tension at the start, without payout and friction", 0.0, not_negative),
    Field("payout", CONTINUOUS_DRIVE, "m", "natural length paid out at the first node since the start; a winch that "
          "hauls in has negative values", None),
    DAMPING,
    friction_field(),
    elastic_release("cable"),
)  # fmt: skip
OUTPUTS = (
    Output("length", "m", "length of the path: free spans and arcs", geometric=True),
    *STRAINS,
    Output("tension", "N", "tension of the whole cable, with friction its mean; zero while it is slack"),
    Output("state", "-", "0 relaxing, slack or released, 1 taut"),
    Output("inclination", "-", "sine of the largest angle of a span to the plane of its pulleys"),
    Output("lift_off", "rad", "angle by which the cable has left a pulley", geometric=True),
    Output("closeness", "-", "largest difference of radii over distance of neighbours; 1 where a span vanishes"),
)
TOO_CLOSE = "has no free span left between two neighbouring pulleys, or a pulley and its end: they are too close"
_ALWAYS_ACTIVE = Kind(
    name="reeved_cable", section="elements", doc=__doc__,
    display=Display("belt", pictures=("cables",), axial="tension"),
    fields=FIELDS,
    outputs=(*OUTPUTS, Output("wrap_1", "rad", "angle of the arc on pulley 1; and so on", geometric=True)),
    phases=PHASES,
    events=EVENTS,
    cornered=is_damped,
    dtype=record(**path_record(1)),
    **path_unknowns(1),
    optional=(("friction", CAPSTAN, ""),),
    limits=lambda d: [("inclination", INCLINATION, "the length is exact only in the plane of the pulleys")],
    variant=lambda d: _of(len(d["nodes"]) - 2, is_formula(d["payout"]), d["release"] is not None, is_stress_free(d)),
    end_conditions=lambda d: [("lift_off", LIFTED, partial(_leaving, d)), ("closeness", CLOSEST, TOO_CLOSE)],
    **named(prepare, parts, check, sample),
    **_functions(strain_by(payout_of(1, False))),
)  # fmt: skip
LYING = (6, 7, 8)  # indices of the outputs that say whether the cable lies on its pulleys
STRESS_FREE = Field("stress_free", BOOLEAN, "-", "when it begins to act, its tension is its pretension", False)
REEVED_CABLE = with_activation(_ALWAYS_ACTIVE, "cable", LYING, (_ALWAYS_ACTIVE, (1, 2, 3, *LYING)), STRESS_FREE)

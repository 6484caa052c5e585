r"""Bar and cable: an elastic line between two nodes; a cable carries tension only.

With the length :math:`\ell`, the natural length :math:`L(t)`, the axial stiffness EA and the damping time :math:`\tau`:

.. math::  \varepsilon = \frac{\ell - L}{L}, \qquad N = EA\,(\varepsilon + \tau \dot\varepsilon), \qquad
   f_1 = -f_0 = N u, \qquad V = \tfrac12 EA\, L\, \varepsilon^2

A cable is taut as long as both :math:`\varepsilon` and :math:`\varepsilon + \tau \dot\varepsilon` are positive: it
never pushes, even with damping. The viscous part of its tension is at most as large as the elastic one,

.. math::  N = EA\,(\varepsilon + \nu), \qquad
   \nu = \max(-\varepsilon, \min(\tau \dot\varepsilon, \varepsilon)),

so that the tension rises from zero, and does not jump, where the cable becomes taut at a speed (as in contacts of Hunt
and Crossley 1975). The changes from slack to taut and back are events. If elastic energy remains when it goes slack
with :math:`\varepsilon > 0`, it is dissipated while the cable is relaxing: while it shortens to its natural length, at
which the event ``is relaxed`` occurs. A ``release`` cuts the cable, whose mass remains;
``release: {when: rope.tension > 5000}`` breaks it. An ``activate`` that is ``stress_free`` shifts its natural length so
that it then has only its ``pretension``, as a cable that is hooked on.

With ``mesh: n`` a cable named rope becomes the cables rope.1 ... rope.n between nodes rope.1 ... rope.(n-1), and
sags and vibrates as a rope. If it is longer than the distance of its nodes, ``sag: [0, 0, -1]`` lets it start as the
chain in which it hangs.

A varying natural length, a law of time or a formula of signals, does work, which the surroundings (a winder) supply.
With :math:`N_d = N - EA\varepsilon` (:math:`-EA\varepsilon` while it is relaxing) the powers are

.. math::  P_{dissipated} = N_d L \dot\varepsilon, \qquad
   P_{given} = -[EA\,\varepsilon\,(1 + \varepsilon/2) + N_d\,(1 + \varepsilon)]\, \dot L

A cable may be paid out by a winder, and may reach its full length with a shock (``payout_tension``,
``at_full_length``): see docs/shocks.md.

The mass, that of the natural length at t = 0 (of a formula: of the initial distance), is constant. It is consistent
with a linear velocity between the nodes, :math:`\frac{m}{6}\begin{bmatrix} 2 & 1 \\ 1 & 2 \end{bmatrix}` for each
component, or lumped, one half at each node.
"""

from dataclasses import replace

import numpy as np

from mecano.constraints import wound_line
from mecano.constraints.activation import SHIFT, is_stress_free, since_activation, with_activation
from mecano.constraints.along_coordinate.demand import is_formula, of_law_with_rate, on_demand, with_rate
from mecano.constraints.coordinates.distance import DISTANCE
from mecano.constraints.elastic_line import (
    DAMPING,
    LINE_RECORD,
    STRAIN_OF_STEEL,
    STRAINS,
    add_line_inertia,
    add_strain_energy,
    axial_stiffness,
    line_inertia,
    line_record,
    prestrain,
    put_line,
    put_line_energy,
    put_no_push,
    strained,
)
from mecano.constraints.joint_nodes import check_apart, distance
from mecano.constraints.joint_samples import at_distance
from mecano.constraints.line import add_line_force, line
from mecano.constraints.line_phases import EVENTS, PHASES, TAUT, follows, is_damped, pulled, put_line_events
from mecano.constraints.release import SAMPLE, with_release
from mecano.constraints.wound_line import CATCHES
from mecano.element_interface import Display, Kind, Measured, Output, named, record
from mecano.elements.members.cable_line import DIVISION, check_division, divide, without_effect_of_division
from mecano.jit.kernel import kernel
from mecano.laws.law_table import terms_of
from mecano.laws.probe import curve_at
from mecano.schema import BOOLEAN, CONTINUOUS_DRIVE, CURVE, NODE_PAIR, NUMBER, Field, choice, not_negative, positive

_BOTH = __doc__.partition("\n\n")[2]  # the page without its heading
STRETCHED = 0.5  # strain
VANISHING = 1e3  # strain: of a natural length that has fallen to zero


@kernel
def _of_a_bar(p, at, strain, strain_rate):
    """Return the strains that give the elastic and the whole tension of a bar."""
    return strain, strain + p.damping * strain_rate


def _functions(natural, strains):
    """Return ``residual``, ``observe`` and ``event_values`` for a natural length (p, at) -> (value, rate).

    ``strains``: (p, at, strain, strain rate) -> strains that give the elastic and the whole tension.
    """

    @kernel
    def residual(p, at, f):
        """Add f = (-N u, N u) [N], (6,), and the inertia of the line.

        N = EA (eps + c d eps/dt) with eps = l/L - 1, the unit vector u from the first to the second node, l their
        distance and L the natural length; N = 0 unless taut.
        """
        add_line_inertia(p, at.a, f)
        if at.phase == TAUT or follows(p, at):
            length, rate, (_, u, _) = line(at.q, at.v)
            add_line_force(f, p.EA * strains(p, at, *strained(length, rate, *natural(p, at)))[1], u)

    @kernel
    def observe(p, at, F, y, e):
        """Write length, natural length L [m], strain eps, its rate [1/s], tension N [N], stress [Pa]; energies."""
        length, rate, _ = line(at.q, at.v)
        L, L_rate = natural(p, at)
        strain, strain_rate = strained(length, rate, L, L_rate)
        elastic, tension = strains(p, at, strain, strain_rate)
        elastic, N = p.EA * elastic, p.EA * tension
        put_line(p, y, length, L, strain, strain_rate, N)
        put_line_energy(p, at.q, at.v, e)
        add_strain_energy(elastic, N - elastic, strain, strain_rate, L, L_rate, e)

    @kernel
    def event_values(p, at, g):
        length, rate, _ = line(at.q, at.v)
        put_line_events(g, at.phase == TAUT, *strained(length, rate, *natural(p, at)), p.damping)

    return residual, observe, event_values


def _cable_functions(natural):
    """Return the functions of a cable: those of a bar, events, and outputs that say whether it is taut."""
    residual, put, event_values = _functions(natural, pulled)

    @kernel
    def observe(p, at, F, y, e):
        """Write y and e of a bar, without a tension that pushes, and y[6] = 1 while taut, 0 while slack."""
        put(p, at, F, y, e)
        put_no_push(y)
        y[6] = 1.0 if at.phase == TAUT else 0.0

    return named(residual, observe, event_values)


def prepare_wound(d, nodes, context):
    """Return the record of a cable with winder or shock."""
    wound = d["payout_tension"] is not None
    return {
        **line_record(d, nodes, context), "wound": float(wound), "start": distance(nodes),
        "payout": context.laws.add(d["payout_tension"]), "catch": CATCHES.index(d["at_full_length"]),
    }  # fmt: skip


def check(d, nodes):
    """Check that the line has a direction and an initial natural length, and exactly one axial stiffness."""
    texts = check_apart(d, nodes)
    if (d["axial_stiffness"] is None) == (d["E"] is None):
        texts.append("give either 'axial_stiffness' or 'E' with 'area'")
    elif d["E"] is not None and d["area"] is None:
        texts.append("'area' is missing: 'E' alone gives no axial stiffness")
    natural = d["natural_length"]
    if natural is not None and not is_formula(natural) and not curve_at(natural, 0.0)[0] > 0.0:
        texts.append("'natural_length' must be greater than zero at t = 0")
    if not texts and prestrain(d) <= -1.0:
        texts.append("'pretension' must be greater than -EA")
    shifted = bool(d.get("activate")) and is_stress_free(d)  # a bar has no activation
    if d["pretension"] and natural is not None and not shifted:
        texts.append("give either 'natural_length' or 'pretension', from which it follows")
    return texts


def _winds(d):
    """Return which of the fields of a winder, and of a shock at the full length, are given: {field: bool}."""
    return {"payout_tension": d["payout_tension"] is not None, "at_full_length": d["at_full_length"] != "stretch"}


def check_cable(d, nodes):
    """Check the values as for a bar, and that a winder has a full length that is not yet reached."""
    texts, winds = check(d, nodes) + check_division(d, nodes), _winds(d)
    if d["pretension"] < 0.0:
        texts.append("'pretension' of a cable must not be negative")
    texts += [
        f"{timed!r} and {name!r} exclude one another"
        for timed in ("release", "activate") for name in winds if winds[name] and d[timed]
    ]  # fmt: skip
    if is_formula(d["natural_length"]) and any(winds.values()):
        texts.append("with 'payout_tension' or 'at_full_length' the 'natural_length' is a number or a law of time")
    if d["payout_tension"] is None or texts:
        return texts
    full = terms_of(d["natural_length"])
    if {name for name, _ in full} != {"constant"} or not curve_at(full, 0.0)[0] > distance(nodes):
        return [
            "'natural_length', at which it is fully paid out, must be a number greater than the distance of the nodes, "
            "the length paid out at the start"
        ]
    if curve_at(d["payout_tension"], 0.0)[0] < 0.0:
        return ["'payout_tension' must not be negative at zero rate"]
    return []


def without_effect(d):
    """Return the values that have no effect on a line without mass."""
    if d["mass_distribution"] == "lumped" and not d["mass_per_length"]:
        yield "mass_distribution", "without 'mass_per_length' there is no mass"


def without_effect_on_cable(d):
    """Return the same, and the values that have no effect on a cable of one element, or one that is not stretched."""
    yield from without_effect(d)
    yield from without_effect_of_division(d)
    if d["at_full_length"] == "hold" and d["damping"]:
        yield "damping", "with 'at_full_length: hold' the cable is not stretched"


def sample_cable(rng):
    """Return cables: taut while it is wound up, and slack; with winder and shock in all phases."""
    d = {"axial_stiffness": 80.0, "area": 0.01, "mass_per_length": 0.5, "damping": 0.05}
    wound, hooked = (("linear", {"slope": -0.3, "offset": 1.5}),), {"time": 0.3, "when": None, "stress_free": True}
    winder = {"payout_tension": (("linear", {"slope": 4.0, "offset": 0.03}),), "at_full_length": "shock"}
    return [
        *(({**d, "natural_length": wound}, at_distance(rng, 2.0), phase) for phase in ("taut", "relaxing")),
        ({**d, "natural_length": 3.0}, at_distance(rng, 2.0), "slack"),
        ({**d, **SAMPLE, "natural_length": 3.0}, at_distance(rng, 2.0), "slack"),
        ({**d, "natural_length": "command"}, at_distance(rng, 2.0), "taut"),
        ({**d, **SAMPLE, "natural_length": "command"}, at_distance(rng, 2.0), "taut"),
        ({**d, "activate": hooked, "pretension": 5.0, "natural_length": "command"}, at_distance(rng, 2.0), "taut"),
        ({**d, "natural_length": wound, "at_full_length": "hold"}, at_distance(rng, 2.0), "held"),
        ({**d, "natural_length": 3.0, "at_full_length": "hold"}, at_distance(rng, 2.0), "slack"),
        *(({**d, **winder, "natural_length": 2.6}, at_distance(rng, 2.0), phase) for phase in ("taut", "paying out")),
    ]


FIELDS = (
    Field("nodes", NODE_PAIR, "-", "its two nodes, not at the same place"),
    Field("axial_stiffness", NUMBER, "N", "EA: force per strain; or give E and area", None, positive),
    Field("E", NUMBER, "Pa", "modulus of elasticity, where axial_stiffness is not given", None, positive),
    Field("area", NUMBER, "m2", "area of the cross-section; without it the stress is written as zero", None, positive),
    Field("natural_length", CONTINUOUS_DRIVE, "m", "length without force; when absent, from the pretension", None),
    Field("pretension", NUMBER, "N", "tension at the start, at the initial distance", 0.0),
    DAMPING,
    Field("mass_per_length", NUMBER, "kg/m", "mass per natural length at t = 0", 0.0, not_negative),
    Field(
        "mass_distribution", choice("consistent", "lumped"), "-", "distribution of the mass to the nodes", "consistent"
    ),
)  # fmt: skip
WINDER_FIELDS = (
    Field("at_full_length", choice(*CATCHES), "-",
          "when it becomes taut at its full length: stretch: elastic, without a shock; shock: exchange of momentum, "
          "then elastic; hold: the same, then inextensible (docs/shocks.md)", "stretch"),
    Field("payout_tension", CURVE, "N",
          "a winder pays the cable out, from the initial distance to the natural length, at this tension: a function "
          "of the rate of the distance [m/s], which limits the rate if it increases; no winder when absent", None,
          argument="m/s"),
)  # fmt: skip
OUTPUTS = (
    Output("length", "m", "distance of the nodes", geometric=True),
    *STRAINS,
    Output("tension", "N", "axial force; > 0 pulls the nodes together"),
    Output("stress", "Pa", "axial force over area"),
)


def bounds(d):
    """Return the tension that stretches a line by half of its length, as it does none but rubber."""
    strained = f"that strains it by more than {100.0 * STRETCHED:g} %, which only rubber withstands"
    text = f"{strained}: are stiffness and loads in SI units?"
    return [("tension", (-np.inf, STRETCHED * axial_stiffness(d)), text)]


def end_conditions(d):
    """Return the strain of a line whose varying natural length has fallen to zero, as a formula may at the start."""
    return [] if _is_constant(d["natural_length"]) else [("strain", VANISHING, _vanished)]


def _is_constant(natural):
    return natural is None or (not is_formula(natural) and {name for name, _ in terms_of(natural)} == {"constant"})


def _vanished(output):
    return (
        f"has 'natural_length' {output('natural_length'):.3g} m, at a distance of its nodes of {output('length'):.3g} "
        "m: it must stay greater than zero, such as a length at the start plus that of a winch"
    )


def _of_length(kind, functions):
    """Return the ``kind`` with these ``functions`` of its natural length, a law of time or a formula of signals."""
    return on_demand(kind, functions, "natural_length", of_law_with_rate, with_rate)


_BAR = Kind(
    name="bar", section="elements",
    doc=f"Bar: an elastic line between two nodes that carries tension and compression.\n\n{_BOTH}",
    display=Display("cable", pictures=("cables",), axial="tension"), dtype=record(**LINE_RECORD), layout=("x0", "x1"),
    fields=FIELDS,
    outputs=OUTPUTS,
    prepare=line_record,
    check=check,
    bounds=bounds,
    end_conditions=end_conditions,
    without_effect=without_effect,
    strains=(-STRAIN_OF_STEEL, STRAIN_OF_STEEL),
    inertia=line_inertia,
    measures={"length": lambda d, nodes, context: Measured(DISTANCE, (0, 1), {})},
    cases=(
        {"axial_stiffness": 50.0, "natural_length": 1.9, "pretension": 0.0},
        {"axial_stiffness": 50.0, "pretension": 0.0},
        {"E": 200.0, "area": 0.1, "pretension": 0.0, "mass_distribution": "lumped"},
    ),
)  # fmt: skip
_TENSION_ONLY = replace(
    _BAR,
    name="cable",
    doc=f"Cable: an elastic line between two nodes that carries tension only.\n\n{_BOTH}",
    fields=(*FIELDS, *DIVISION, *WINDER_FIELDS),
    outputs=(*OUTPUTS, Output("state", "-", "0 relaxing, slack or released, 1 taut, 2 paying out")),
    phases=PHASES,
    events=EVENTS,
    cornered=is_damped,
    check=check_cable,
    divide=divide,
    without_effect=without_effect_on_cable,
    strains=(-np.inf, STRAIN_OF_STEEL),  # it may be slack
    sample=sample_cable,
)
BAR = _of_length(_BAR, lambda natural: named(*_functions(natural, _of_a_bar)[:2]))  # it has no events


def _cable(functions):
    """Return the Kind of a cable with these ``functions`` of its natural length, and with a release."""
    return with_release(_of_length(_TENSION_ONLY, functions), "cable", None)


def _stress_free(natural):
    """Return the functions, the memory and the record of a cable that is activated stress-free."""

    @kernel
    def commit(p, at, m_out):
        m_out[0] = line(at.q, at.v)[0] / (1.0 + p.prestrain) - natural(p, at)[0]

    return {
        **_cable_functions(since_activation(natural, 0)), "memory": (SHIFT,), "commit": commit,
        "dtype": record(**LINE_RECORD, prestrain=()),
        "prepare": lambda d, nodes, context: {**line_record(d, nodes, context), "prestrain": prestrain(d)},
    }  # fmt: skip


_GIVEN, _HOOKED = _cable(_cable_functions), _cable(_stress_free)
WOUND_CABLE = replace(
    _GIVEN,
    name="wound_cable", dtype=wound_line.RECORD,
    phases=wound_line.PHASES, events=wound_line.EVENTS, memory=wound_line.MEMORY,
    prepare=prepare_wound,
    parts=lambda d, nodes, context: wound_line.wound_parts(prepare_wound(d, nodes, context)),
    variant=None,
    residual=None, inertia=None, observe=wound_line.observe, event_values=wound_line.event_values,
    commit=wound_line.commit,
)  # fmt: skip
STRESS_FREE = Field(
    "stress_free", BOOLEAN, "-", "when it begins to act it has only its pretension, whatever the distance", False
)
CABLE = with_activation(
    replace(_GIVEN, variant=lambda d: WOUND_CABLE if any(_winds(d).values()) else _GIVEN.chosen(d)), "cable", None,
    (_HOOKED, None), STRESS_FREE,
)  # fmt: skip

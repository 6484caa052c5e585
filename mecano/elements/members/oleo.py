r"""Oleo-pneumatic shock strut: a gas chamber above oil that is forced through an orifice.

The axial force along the line between the nodes follows from pressures, areas and volumes, as they are on a drawing
(Milwitzky and Cook, Analysis of Landing-Gear Behavior, NACA Report 1154, 1953). With the stroke s, the shortening from
the fully extended length, and the piston speed u at which oil passes the orifice,

.. math::  N = -(p_g - p_a) A_g - F_h, \qquad F_h = \frac{\rho A_h^3}{2 (C_d A_o)^2}\, (|u| + u_0)\, u

* gas: :math:`p_g = p_1 (V_1/(V_1 - A_g s))^n`, absolute. A second chamber behind a separator opens when :math:`p_g`
  reaches its pressure :math:`p_2`; from there both have the same pressure, with
  :math:`V_1 (p_1/p_g)^{1/n} + V_2 (p_2/p_g)^{1/n_2} = V_1 + V_2 - A_g s`.
* seals: the gas presses them on the piston; they rub with :math:`\mu_s (p_g - p_a) A_g` against its motion.
* oil: the orifice area :math:`A_o` is a curve of the stroke (a metering pin). The rebound has its own orifice (a
  recoil valve) and, with a recoil chamber, the area of this chamber in place of :math:`A_h`; without one the oil is
  sucked back. Below the ``laminar_speed`` :math:`u_0` the flow is laminar, and the factors :math:`r_c, r_r` of
  compression and rebound blend: the laminar part is
  :math:`u_0 (\frac{r_c + r_r}{2} u + \frac{r_c - r_r}{2} (\sqrt{u^2 + u_0^2} - u_0))`. Small motions about rest
  therefore have the mean of both, whatever the sign of a rounded speed. For a sharp-edged round orifice, whose pressure
  drop at slow flow is :math:`50.4\,\mu Q/(\pi d^3)` (Wuest, in Merritt, Hydraulic Control Systems, 1967),
  :math:`u_0 = 22\,C_d^2\,\nu \sqrt{A_o}/A_h`, with the kinematic viscosity :math:`\nu`: 0.1 to 1 mm/s in landing gears.
* the oil in the chamber is compressed by c, the unknown of the element: :math:`u = \dot s - \dot c` and
  :math:`F_h = k c` with :math:`k = K A_h^2/V`.

N > 0 pulls the nodes together. A ``law`` of the extension -s adds stops and dry friction; for friction from the
reactions of the bearings use ``friction`` of the cylindrical joint. Gas and compressed oil store energy,
the orifice dissipates :math:`F_h u`. Cavitation is not modelled: it begins where ``oil_pressure`` falls to zero.
"""

import numpy as np

from mecano.constraints.along_coordinate.law import LAW_RECORD, STILL, extension, law_values, report
from mecano.constraints.coordinates.distance import DISTANCE
from mecano.constraints.joint_nodes import check_apart, distance
from mecano.constraints.joint_samples import at_distance
from mecano.constraints.line import add_line_force, line
from mecano.constraints.stop_phases import EVENTS, FAR, PHASES, put_stop_events
from mecano.element_interface import Display, Kind, Measured, Output, named, record
from mecano.jit.kernel import kernel
from mecano.laws.friction import regularization, sticking
from mecano.laws.gas_chambers import GAS_RECORD, gas_at, gas_pull, gas_values
from mecano.laws.law_table import curve, law_force, terms_of
from mecano.laws.probe import curve_at
from mecano.maths.dual import at_least, number, select, sqrt, value
from mecano.schema import CURVE, LAW, NODE_PAIR, NUMBER, Field, mapping, positive

OIL = 6  # local unknown: compression c of the oil [m], measured along the stroke
LEAST_COMPRESSION = 0.1  # share of the gas volume that a full stroke displaces; two thirds or more in landing gears
LONGEST_STROKE = 10.0  # times the length of the strut
UNLIKE = 20.0  # ratio of the areas by which a piston displaces oil and gas
CLOSED = 1e-9  # of the largest area of an orifice: less is the rounding of a curve that ends at zero
LARGEST_EXPONENT = 5.0 / 3.0  # adiabatic exponent of a monatomic gas; nitrogen at 100 bar has 1.6
LONGER = 0.01  # of the extended length: beyond it the deformation of a stop is improbable
FREE_SEALS = {"coefficient": 0.0, "regularization": 1.0}
RECORD = record(
    **LAW_RECORD, **GAS_RECORD, ambient=(), oil_stiffness=(), orifice="i", rebound_orifice="i", drag=2, pressing=2,
    laminar=(), seal_friction=(), seal_speed=(),
)  # fmt: skip


@kernel
def through_orifice(p, at, e, u):
    """Return F_h [N] at the extension e and the flow speed u."""
    inwards, outwards = curve(at.laws, p.orifice, -e), curve(at.laws, p.rebound_orifice, -e)
    compression, rebound = p.drag[0] / (inwards * inwards), p.drag[1] / (outwards * outwards)
    turbulent = select(u > 0.0, compression * u, -(rebound * u)) * u
    smooth = sqrt(u * u + p.laminar * p.laminar) - p.laminar
    return turbulent + 0.5 * p.laminar * ((compression + rebound) * u + (compression - rebound) * smooth)


@kernel
def seal_friction(p, gas, rate):
    """Return the friction [N] > 0 in tension of seals that the ``gas`` force [N] presses on, at the ``rate`` [m/s]."""
    return p.seal_friction * at_least(-gas, 0.0) * sticking(p.seal_speed, abs(rate)) * rate


@kernel
def residual(p, at, f):
    """Add the axial force along the line, and the balance of the pressure in the oil with that at the orifice."""
    length, rate, (_, along, _) = line(at.q, at.v)
    e, oil, oil_rate = extension(p, STILL, length), number(at.q[OIL]), number(at.v[OIL])
    F_h = through_orifice(p, at, e, -rate - oil_rate)
    gas = gas_pull(p, e) + p.ambient * p.gas_area
    N = gas + seal_friction(p, gas, rate) - F_h + law_force(at.laws, p.law, e, rate)
    add_line_force(f, N, along)
    f[OIL] += p.oil_stiffness * oil - F_h


@kernel
def observe(p, at, F, y, e):
    """Write length, extension, rate, force, stroke, pressures, flow, compression of the oil; energies."""
    length, rate, _ = line(at.q, at.v)
    s, oil, u = extension(p, STILL, length), number(at.q[OIL]), -rate - number(at.v[OIL])
    report(p, at, STILL, length, rate, y[3:], e)
    gas, F_h = gas_pull(p, s), through_orifice(p, at, s, u)
    seals = seal_friction(p, gas + p.ambient * p.gas_area, rate)
    y[0], y[1], y[2] = length, s, rate
    y[3] += gas + p.ambient * p.gas_area + seals - F_h
    y[4] = -s
    y[5] = -gas / p.gas_area
    pressing = select(u > 0.0, p.pressing[0], p.pressing[1])
    y[6] = -gas / p.gas_area + F_h * pressing
    y[7] = u / abs(pressing)
    y[8], y[9] = oil, at.v[OIL]
    e[1] += gas_at(p, value(s))[2] + p.ambient * p.gas_area * s + 0.5 * p.oil_stiffness * oil * oil
    e[2] += F_h * u + seals * rate


@kernel
def event_values(p, at, g):
    """Write the event values of the stops of the law."""
    put_stop_events(g, p.low, p.high, extension(p, STILL, line(at.q, at.v)[0]))


def prepare(d, nodes, context):
    """Return the record of one strut; the extended length defaults to the initial distance."""
    gas, oil, seals = d["gas"], d["oil"], d["seal_friction"] or FREE_SEALS
    k = oil["bulk_modulus"] * oil["area"] ** 2 / oil["volume"]
    recoil = oil["recoil_area"]
    areas = np.array([oil["area"], oil["area"] if recoil is None else recoil])
    pressing = np.array([1.0, 1.0 if recoil is None else -1.0]) / areas
    drag = oil["density"] * areas**3 / (2.0 * oil["discharge_coefficient"] ** 2)
    rebound = oil["orifice"] if oil["rebound_orifice"] is None else oil["rebound_orifice"]
    return {
        **law_values({}, d["law"], extended(d, nodes), context), **gas_values(gas, d["second_gas"]),
        "seal_friction": seals["coefficient"], "seal_speed": seals["regularization"],
        "ambient": gas["ambient_pressure"], "oil_stiffness": k, "drag": drag, "pressing": pressing,
        "laminar": oil["laminar_speed"],
        "orifice": context.laws.add(oil["orifice"]), "rebound_orifice": context.laws.add(rebound),
    }  # fmt: skip


def extended(d, nodes):
    """Return the length at the stroke zero [m]."""
    return distance(nodes) if d["extended_length"] is None else d["extended_length"]


def check(d, nodes):
    """Check that the line has a direction, the orifices are open, and the second chamber has the higher pressure."""
    texts, gas, second = check_apart(d, nodes), d["gas"], d["second_gas"]
    if second is not None and second["pressure"] <= gas["pressure"]:
        texts.append("'second_gas.pressure' must be higher than 'gas.pressure': its separator opens under compression")
    texts += [text for name in ("orifice", "rebound_orifice") for text in _closed(name, d["oil"][name])]
    return texts or _used_up(d, nodes)


def _used_up(d, nodes):
    """Return an error if the strut starts at a stroke at which all gas is used up."""
    stroke = extended(d, nodes) - distance(nodes)
    if stroke < (last := _last_stroke(d)):
        return []
    return [
        f"it starts at a stroke of {stroke:g} m, 'extended_length' less the distance of its nodes; all gas is used up "
        f"at {last:g} m (volume over area)"
    ]


def _last_stroke(d):
    """Return the stroke [m] at which all gas is used up: the volume over the area."""
    gas, second = d["gas"], d["second_gas"]
    return (gas["volume"] + (0.0 if second is None else second["volume"])) / gas["area"]


def _closed(name, area):
    """Return a text if an orifice is closed at zero stroke or a corner of its curve."""
    areas = _areas(area) or [1.0]
    return [f"'oil.{name}' must have areas greater than zero"] if min(areas) <= CLOSED * max(areas) else []


def _areas(area):
    """Return the areas of an orifice at zero stroke and at the corners of its curve; none if it is absent."""
    return [] if area is None else [curve_at(area, float(x))[0] for x in [0.0, *_corners(area)]]


def _corners(area):
    """Return the strokes of the points of an orifice's curve."""
    return [x for _, values in terms_of(area) for x, _ in values.get("points") or ()]


def start_warnings(d, nodes):
    """Yield warnings about a strut that starts beyond its full extension, the gas, stops and orifices."""
    full, length = d["extended_length"], float(np.linalg.norm(nodes[1].x - nodes[0].x))
    if full is not None and length > (1.0 + LONGER) * full:
        yield (
            f"it starts {length - full:.3g} m longer than its 'extended_length', {full:g} m: beyond the stop of the "
            "extended strut; is the length right?"
        )
    yield from _unlike_gas(d)
    yield from _reversed_stops(d["law"])
    yield from _beyond(d["oil"], length if full is None else full)
    yield from _unlike_sizes(d)


def _unlike_gas(d):
    """Yield texts on a pressure less than that of the air, and on exponents that no gas has."""
    gas = d["gas"]
    if gas["pressure"] < gas["ambient_pressure"]:
        yield (
            f"'gas.pressure' is {gas['pressure']:g} Pa, less than the {gas['ambient_pressure']:g} Pa of the air: "
            "the extended strut pulls; is this intended? Pressures are absolute"
        )
    for name in ("gas", "second_gas"):
        n = (d[name] or {}).get("exponent")
        if n is not None and not 1.0 <= n <= LARGEST_EXPONENT:
            yield f"'{name}.exponent' is {n:g}: it lies between 1, isothermal, and 1.67, adiabatic, for all gases"


def _unlike_sizes(d):
    """Yield texts on volumes and areas that do not suit the stroke or one another."""
    gas, oil, used_up = d["gas"], d["oil"], _last_stroke(d)
    stroke = min((-values["lower"] for term, values in d["law"] or () if term == "stop"), default=0.0)
    if used_up <= stroke < FAR:
        yield (
            f"the stop is at a stroke of {stroke:g} m, but all gas is used up at {used_up:g} m (volume over area): the "
            "strut cannot reach the stop; is the volume right?"
        )
    if 0.0 < stroke < LEAST_COMPRESSION * used_up:
        yield (
            f"the whole stroke of {stroke:g} m compresses the gas by {stroke / used_up:.2g} of its volume, so that it "
            "hardly springs; is 'gas.volume' right, in m3?"
        )
    if not 1.0 / UNLIKE < oil["area"] / gas["area"] < UNLIKE:
        yield (
            f"'oil.area' is {oil['area']:g} m2 and 'gas.area' {gas['area']:g} m2: the same piston displaces oil and "
            "gas; is a unit missing?"
        )
    widest = max(_areas(oil["orifice"]) + _areas(oil["rebound_orifice"]))
    if widest >= oil["area"]:
        yield (
            f"an orifice has {widest:g} m2, not less than the {oil['area']:g} m2 of 'oil.area', the piston that "
            "displaces the oil: is this intended, or is a unit missing?"
        )


def _reversed_stops(law):
    """Yield a text if the lower stop prevents all compression."""
    for term, values in law or ():
        if term == "stop" and values["lower"] >= 0.0:
            yield (
                f"its stop at 'lower' = {values['lower']:g} prevents all compression, in which the extension is "
                "negative; for a stroke S write 'lower: -S, upper: 0'"
            )


def _beyond(oil, length):
    """Yield a text if a curve of an orifice extends to strokes much longer than the strut."""
    last = max((x for name in ("orifice", "rebound_orifice") for x in _corners(oil[name])), default=0.0)
    if last > LONGEST_STROKE * length:
        yield f"an orifice is given up to a stroke of {last:g} m, of a strut {length:.3g} m long; is it in mm?"


def bounds(d):
    """Return the limit of the oil pressure, at which the oil cavitates."""
    chamber = "the recoil chamber needs" if d["oil"]["recoil_area"] else "without 'oil.recoil_area' the rebound needs"
    text = f"below zero the oil cavitates, which is not modelled: {chamber} a larger 'oil.rebound_orifice'"
    return [("oil_pressure", (0.0, np.inf), text)]


def sample(rng):
    """Return a strut with one chamber and a metering pin, and one with two chambers, a recoil valve and stops."""
    gas = {"pressure": 3.0, "volume": 4.0, "exponent": 1.3, "area": 1.2, "ambient_pressure": 0.4}
    oil = {
        "area": 1.1, "orifice": (("polynomial", {"coefficients": [1.2, -0.1]}),), "rebound_orifice": None,
        "recoil_area": None, "discharge_coefficient": 0.8, "density": 1.5, "bulk_modulus": 20.0, "volume": 2.0,
        "laminar_speed": 1e-3,
    }  # fmt: skip
    one = {"gas": gas, "oil": oil, "second_gas": None, "law": None, "extended_length": 2.5, "seal_friction": None}
    valve = {**oil, "rebound_orifice": 0.7, "recoil_area": 0.9}
    both, seals = {"pressure": 3.6, "volume": 2.0, "exponent": 1.1}, {"coefficient": 0.1, "regularization": 0.5}
    stop = (("stop", {"stiffness": 30.0, "lower": -0.9, "upper": 0.1, "damping": 0.1}),)
    two = {"gas": gas, "oil": valve, "second_gas": both, "law": stop, "extended_length": 2.0, "seal_friction": seals}
    lengths = zip(PHASES, (1.0, 1.5, 2.3), strict=True)
    return [(one, 2, "between"), *((two, at_distance(rng, length), phase) for phase, length in lengths)]


GAS_FIELDS = (
    Field("pressure", NUMBER, "Pa", "absolute pressure p_1 of the extended strut", check=positive),
    Field("volume", NUMBER, "m3", "volume V_1 of the gas in the extended strut", check=positive),
    Field("area", NUMBER, "m2", "area A_g by which the stroke compresses the gas", check=positive),
    Field("exponent", NUMBER, "-", "polytropic exponent n: 1 isothermal, 1.4 adiabatic", 1.3, positive),
    Field("ambient_pressure", NUMBER, "Pa", "pressure p_a of the ambient air", 101325.0, positive),
)
SECOND_FIELDS = (
    Field("pressure", NUMBER, "Pa", "absolute pressure p_2 at which its separator opens", check=positive),
    Field("volume", NUMBER, "m3", "volume of its gas", check=positive),
    Field("exponent", NUMBER, "-", "polytropic exponent n_2; that of the first gas when absent", None, positive),
)
SEAL_FIELDS = (
    Field("coefficient", NUMBER, "-", "friction over the net force of gas and ambient air", check=positive),
    regularization("speed of the piston"),
)
OIL_FIELDS = (
    Field("area", NUMBER, "m2", "area A_h of the piston that displaces the oil", check=positive),
    Field(
        "orifice", CURVE, "m2", "area A_o of the orifice, less that of the metering pin; a curve of the stroke [m]",
        argument="m",
    ),
    Field(
        "rebound_orifice", CURVE, "m2", "the same in rebound, a curve of the stroke [m]; that of 'orifice' when absent",
        None, argument="m",
    ),
    Field(
        "recoil_area", NUMBER, "m2",
        "area of the recoil chamber, from which the rebound displaces oil; no such chamber when absent", None,
        positive,
    ),
    Field("volume", NUMBER, "m3", "volume V of the oil under pressure", check=positive),
    Field("discharge_coefficient", NUMBER, "-", "C_d of the orifice", 0.7, positive),
    Field("density", NUMBER, "kg/m3", "density rho", 860.0, positive),
    Field("bulk_modulus", NUMBER, "Pa", "bulk modulus K, with the air dissolved in the oil", 1.4e9, positive),
    Field("laminar_speed", NUMBER, "m/s", "piston speed u_0 below which the flow is laminar", 1e-3, positive),
)  # fmt: skip
OLEO = Kind(
    name="oleo", section="elements", doc=__doc__,
    display=Display("spring", pictures=("struts", "drop_test"), axial="force"), dtype=RECORD, layout=("x0", "x1"),
    scalars=("oil_compression",), massless=("oil_compression",),
    fields=(
        Field("nodes", NODE_PAIR, "-", "its two nodes, not at the same place"),
        Field("gas", mapping(*GAS_FIELDS), "-", "the gas chamber"),
        Field("oil", mapping(*OIL_FIELDS), "-", "the oil chamber and its orifice"),
        Field("second_gas", mapping(*SECOND_FIELDS), "-", "a second gas chamber, of a higher pressure", None),
        Field("seal_friction", mapping(*SEAL_FIELDS), "-", "friction of seals that the gas presses on", None),
        Field("extended_length", NUMBER, "m", "length at the stroke zero; the initial distance when absent", None,
              positive),
        Field("law", LAW, "-", "further axial force [N] from extension [m] and rate [m/s]: stops, dry friction", None,
              argument="m"),
    ),
    outputs=(
        Output("length", "m", "distance of the nodes", rate="rate"),
        Output("extension", "m", "length - extended length", rate="rate"),
        Output("rate", "m/s", "rate of the length"),
        Output("force", "N", "axial force; > 0 pulls the nodes together"),
        Output("stroke", "m", "compression: extended length - length", geometric=True),
        Output("gas_pressure", "Pa", "absolute pressure of the gas"),
        Output("oil_pressure", "Pa", "absolute pressure of the oil in the chamber of the piston; in the rebound "
               "that of a recoil chamber"),
        Output("flow", "m3/s", "flow through the orifice; > 0 in compression"),
        Output("oil_compression", "m", "part of the stroke by which the oil is compressed",
               rate="oil_compression_rate"),
        Output("oil_compression_rate", "m/s", "rate of oil_compression"),
    ),
    phases=PHASES,
    events=EVENTS,
    **named(prepare, check, start_warnings, bounds, residual, observe, event_values, sample),
    measures={
        "length": lambda d, nodes, context: Measured(DISTANCE, (0, 1), {}),
        "extension": lambda d, nodes, context: Measured(DISTANCE, (0, 1), {}, extended(d, nodes)),
    },
)  # fmt: skip

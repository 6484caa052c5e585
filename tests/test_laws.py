"""Laws: derivatives by differences, potentials by quadrature, tables against scipy, values by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from mecano.analyses.law_tests import OF_TERMS
from mecano.laws import TERMS
from mecano.laws.law_table import LawTable, breakpoints, evaluate_curve, evaluate_force, kinks, potential
from mecano.laws.line_of_time import along_line, line_of_time
from mecano.laws.probe import curve_at, shape_of_curve
from mecano.schema import REQUIRED

CUBIC = {"points": [[-2, 1.0], [-1, 0.2], [0, 0], [0.5, 0.3], [2, 4.0]], "interpolation": "cubic", "beyond": "extend"}
LINEAR = {**CUBIC, "interpolation": "linear", "beyond": "hold"}
DAMPING = [[-2, -3.0], [-0.5, -1.0], [0, 0], [1, 0.4], [2, 2.0]]
OIL = {"density": 870.0, "piston_area": 0.01, "discharge_coefficient": 0.7, "interpolation": "cubic"}
RANDOM = {
    "density": 0.1, "reference": 0.1, "exponent": 2.0, "lowest": 0.05, "highest": 1.0, "waves": 12, "seed": 5,
    "lead_in": 0.0, "start": 0.0, "origin": 0.0,
}  # fmt: skip
QUAKE = {"points": CUBIC["points"], "factor": 0.7, "initial_rate": -0.3, "baseline": "as_given"}

# name of the case: term, values, corners in s (no differences are taken across them)
CASES = {
    "constant": ("constant", {"value": 3.0}, []),
    "linear": ("linear", {"slope": 2.0, "offset": -1.0}, []),
    "polynomial": ("polynomial", {"coefficients": [1.0, -2.0, 0.5, 3.0, -1.0]}, []),
    "power": ("power", {"coefficient": 3.0, "exponent": 1.5}, [0.0]),
    "power, cube": ("power", {"coefficient": -3.0, "exponent": 3.0}, []),
    "power, root": ("power", {"coefficient": 2.0, "exponent": 0.5}, [0.0]),
    "damper_power": ("damper_power", {"coefficient": 3.0, "exponent": 2.0}, []),
    "cubic table": ("table", CUBIC, []),
    "cubic table, held": ("table", {**CUBIC, "beyond": "hold"}, [-2, 2]),
    "spline": ("table", {**CUBIC, "interpolation": "spline"}, []),
    "linear table": ("table", LINEAR, [-2, -1, 0, 0.5, 2]),
    "linear table, extended": ("table", {**LINEAR, "beyond": "extend"}, [-1, 0, 0.5]),
    "sine": ("sine", {"amplitude": 2.0, "frequency": 0.4, "phase": 0.3, "offset": 1.0}, []),
    "ramp": ("ramp", {"start": -1.0, "end": 1.5, "from": 2.0, "to": -3.0}, [-1.0, 1.5]),
    "step": ("step", {"time": -1.0, "rise": 2.0, "from": 1.0, "to": 4.0}, []),
    "jump": ("step", {"time": 0.3, "rise": 0.0, "from": 1.0, "to": 4.0}, [0.3]),
    "exponential": ("exponential", {"start": 0.8, "limit": 0.3, "rate": 1.2, "origin": -0.5}, [-0.5]),
    "exponential, rate 0": ("exponential", {"start": 0.8, "limit": 0.3, "rate": 0.0, "origin": -0.5}, []),
    "bump": ("bump", {"start": -1.0, "length": 2.5, "height": 0.6}, [-1.0, 1.5]),
    "random": ("random", RANDOM, []),
    "random, after a lead-in": ("random", {**RANDOM, "lead_in": 1.8, "start": -1.2}, [-1.2, 0.6]),
    "random, after a lead-in as long as a wave": ("random", {**RANDOM, "lead_in": 10.0, "start": -2.5}, [-2.5]),
    "random, shifted": ("random", {**RANDOM, "origin": 0.7}, []),
    "acceleration": ("acceleration", QUAKE, [-2, 2]),
    "acceleration, at rest in the end": ("acceleration", {**QUAKE, "baseline": "end_at_rest"}, [-2, 2]),
    "spring": ("spring", {"stiffness": 7.0}, []),
    "preload": ("preload", {"force": -5.0}, []),
    "damper": ("damper", {"coefficient": 3.0}, []),
    "damper_polynomial": ("damper_polynomial", {"coefficients": [0.0, 2.0, -0.3, 1.0]}, []),
    "damper_table": ("damper_table", {**CUBIC, "points": DAMPING}, []),
    "gas_spring": ("gas_spring", {"force": 4.0, "length": 2.0, "exponent": 1.3}, []),
    "gas_spring, isothermal": ("gas_spring", {"force": 4.0, "length": 2.0, "exponent": 1.0}, []),
    "gas_spring, nearly isothermal": ("gas_spring", {"force": 4.0, "length": 2.0, "exponent": 1.0 + 1e-9}, []),
    "oil_damper": ("oil_damper", {"compression": 2.0, "rebound": 9.0}, []),
    "metering_pin": ("metering_pin", {**OIL, "points": [[-1, 2e-4], [0, 3e-4], [2, 1e-4]]}, [-2, 1]),
    "dry_friction": ("dry_friction", {"force": 6.0, "regularization": 0.5}, []),
    "stop": ("stop", {"stiffness": 8.0, "lower": -1.0, "upper": 0.7, "damping": 0.4}, [-1.0, 0.7]),
    "stop, lower only": ("stop", {"stiffness": 8.0, "lower": -1.0, "upper": math.inf, "damping": 0.0}, [-1.0]),
    "dead_band": ("dead_band", {"stiffness": 8.0, "lower": -0.4, "upper": 0.7}, [-0.4, 0.7]),
    "dead_band without width": ("dead_band", {"stiffness": 8.0, "lower": 0.3, "upper": 0.3}, []),
}
every_case = pytest.mark.parametrize(("name", "values", "corners"), CASES.values(), ids=CASES)
of_role = {role: [case for case in CASES.items() if TERMS[case[1][0]].role == role] for role in ("curve", "force")}


def packed(*terms):
    """(table, start) of a law; another law stands before it, so that no start is accidentally right."""
    table = LawTable()
    table.add((("sine", {"amplitude": 9.0, "frequency": 1.0, "phase": 0.0, "offset": 0.0}),))
    start = table.add(terms)
    return table.array(), start


def points_away_from(corners, rng):
    s = rng.uniform(-3, 3, 40)
    return [x for x in s if all(abs(x - corner) > 1e-3 for corner in corners)]


def test_every_term_has_a_case():
    assert {case[0] for case in CASES.values()} == set(TERMS)


@pytest.mark.parametrize("check", OF_TERMS, ids=lambda check: check.__name__)
@every_case
def test_every_term(name, values, corners, check):
    check(replace(TERMS[name], sample=lambda: [values]))


def test_the_slope_of_a_ramp_at_its_corners_is_that_behind_them():
    """As that of a table: a motion that begins there has this velocity."""
    values = {"start": 0.0, "end": 2.0, "from": 1.0, "to": 5.0}
    points = [[-1.0, 1.0], [0.0, 1.0], [2.0, 5.0], [3.0, 5.0]]
    table = {"points": points, "interpolation": "linear", "beyond": "hold"}
    for s, slope in ((0.0, 2.0), (2.0, 0.0)):
        assert curve_at((("ramp", values),), s)[1] == curve_at((("table", table),), s)[1] == slope


def test_a_spline_has_no_jumps_of_its_second_derivative():
    """A prescribed motion through samples of a sine: its acceleration to the order of the spacing squared."""
    t = np.linspace(0, 2, 41)
    law = (("table", {"points": np.stack([t, np.sin(np.pi * t)], 1), "interpolation": "spline", "beyond": "hold"}),)
    for at in t[5:-5]:
        before, after = (curve_at(law, at + side)[2] for side in (-1e-9, 1e-9))
        assert before == pytest.approx(after, abs=1e-6)
        assert after == pytest.approx(-(np.pi**2) * np.sin(np.pi * at), abs=0.03)


@pytest.mark.parametrize("n", [2, 3, 12])
def test_cubic_table_is_scipys_pchip(n):
    rng = np.random.default_rng(n)
    for _ in range(20):
        x = np.cumsum(rng.uniform(0.1, 2, n))
        y = np.round(rng.normal(size=n), 1) * rng.integers(0, 2, n)  # flat pieces and turns of sign among them
        reference = PchipInterpolator(x, y)
        values = {"points": np.stack([x, y], 1).tolist(), "interpolation": "cubic", "beyond": "hold"}
        laws, start = packed(("table", values))
        for s in np.concatenate([x, rng.uniform(x[0], x[-1], 30)]):
            y_s, d, _ = evaluate_curve(laws, start, s)
            assert y_s == pytest.approx(float(reference(s)), rel=1e-12, abs=1e-12)
            assert d == pytest.approx(float(reference(s, 1)), rel=1e-10, abs=1e-10)


def test_cubic_table_of_steep_data_is_monotone():
    values = {"points": [[0, 0], [1, 0.01], [1.1, 5], [4, 5.1]], "interpolation": "cubic", "beyond": "hold"}
    laws, start = packed(("table", values))
    y = [evaluate_curve(laws, start, s)[0] for s in np.linspace(-1, 5, 3001)]
    assert np.all(np.diff(y) >= 0) and y[0] == 0 and y[-1] == pytest.approx(5.1, rel=1e-15)


def test_table_outside_its_points():
    held, start = packed(("table", LINEAR))
    extended, _ = packed(("table", {**LINEAR, "beyond": "extend"}))
    assert evaluate_curve(held, start, 4.0) == (4.0, 0.0, 0.0)
    assert evaluate_curve(held, start, -5.0) == (1.0, 0.0, 0.0)
    slope = 3.7 / 1.5
    assert evaluate_curve(extended, start, 4.0) == pytest.approx((4.0 + 2 * slope, slope, 0.0))
    assert evaluate_curve(extended, start, -5.0) == pytest.approx((1.0 + 3 * 0.8, -0.8, 0.0))


def test_gas_spring_by_hand():
    laws, start = packed(("gas_spring", {"force": 1.085e5, "length": 0.6, "exponent": 1.0}))
    assert evaluate_force(laws, start, 0.0, 5.0)[0] == pytest.approx(-1.085e5, rel=1e-15)
    assert evaluate_force(laws, start, -0.3, 0.0)[0] == pytest.approx(-2.17e5, rel=1e-14)  # half the gas, twice p
    assert potential(laws, start, -0.3) == pytest.approx(1.085e5 * 0.6 * math.log(2), rel=1e-14)


def test_gas_spring_is_finite_and_smooth_beyond_its_end():
    laws, start = packed(("gas_spring", {"force": 10.0, "length": 0.5, "exponent": 1.4}))
    join = -0.5 * 0.99
    inside, outside = (np.array(evaluate_force(laws, start, join + d, 0.0)) for d in (1e-12, -1e-12))
    np.testing.assert_allclose(outside, inside, rtol=1e-8)
    at_join, slope, _ = evaluate_force(laws, start, join, 0.0)
    assert at_join == pytest.approx(-10 * 100**1.4, rel=1e-11)
    F, F_s, _ = evaluate_force(laws, start, -3.0, 0.0)  # 2.5 m beyond the end of the cylinder
    assert F == pytest.approx(at_join + slope * (-3.0 - join), rel=1e-9)
    assert F_s == pytest.approx(slope, rel=1e-9)


def test_dampers_by_hand():
    laws, start = packed(("oil_damper", {"compression": 1.18e3, "rebound": 1.27e4}))
    assert evaluate_force(laws, start, 0.0, -3.0) == pytest.approx((-1.18e3 * 9, 0.0, 1.18e3 * 6), rel=1e-14)
    assert evaluate_force(laws, start, 0.0, 2.0) == pytest.approx((1.27e4 * 4, 0.0, 1.27e4 * 4), rel=1e-14)
    laws, start = packed(("metering_pin", {**OIL, "points": [[0, 3e-4], [0.2, 1e-4]], "interpolation": "linear"}))
    F = 870 * 1e-6 / (2 * (0.7 * 2e-4) ** 2) * 4  # rho A^3/(2 (Cd Ao)^2) v^2, half way along the pin
    assert evaluate_force(laws, start, -0.1, -2.0)[0] == pytest.approx(-F, rel=1e-12)
    laws, start = packed(("dry_friction", {"force": 10.0, "regularization": 0.2}))
    assert evaluate_force(laws, start, 0.0, 0.1)[0] == pytest.approx(7.5, rel=1e-14)  # phi(1/2) = 3/4
    assert evaluate_force(laws, start, 0.0, 0.0) == (0.0, 0.0, 100.0)  # 2 force/eps
    assert evaluate_force(laws, start, 0.0, -0.3) == (-10.0, 0.0, 0.0)


def test_stop_never_pulls_back():
    laws, start = packed(("stop", {"stiffness": 100.0, "lower": -1.0, "upper": 1.0, "damping": 0.5}))
    assert evaluate_force(laws, start, -1.2, -1.0)[0] == pytest.approx(-30.0, rel=1e-14)
    assert evaluate_force(laws, start, 1.2, 1.0)[0] == pytest.approx(30.0, rel=1e-14)
    assert evaluate_force(laws, start, -1.2, 2.5) == (0.0, 0.0, 0.0)
    assert evaluate_force(laws, start, 1.2, -2.5) == (0.0, 0.0, 0.0)
    assert evaluate_force(laws, start, -1.0, -50.0) == (0.0, 0.0, 0.0)  # no jump at contact, whatever the speed


@pytest.mark.parametrize("at", [-0.2, 0.0, 0.3])
def test_a_dead_band_without_width_is_a_spring(at):
    """Also where it has no force, about which small motions of a model at rest are: there is no play to lie in."""
    laws, start = packed(("dead_band", {"stiffness": 8.0, "lower": at, "upper": at}))
    for s in (at - 0.5, at, at + 1e-9, at + 2.0):
        assert evaluate_force(laws, start, s, 1.0) == pytest.approx((8.0 * (s - at), 8.0, 0.0), rel=1e-12, abs=1e-15)
    assert kinks((("dead_band", {"stiffness": 8.0, "lower": at, "upper": at}),)) == (-math.inf, math.inf)


def test_terms_are_summed():
    terms = (("spring", {"stiffness": 10.0}), ("polynomial", {"coefficients": [1.0, 0.0, 2.0]}), ("table", LINEAR))
    laws, start = packed(*terms, ("damper", {"coefficient": 3.0}))
    assert evaluate_force(laws, start, 1.0, 2.0) == pytest.approx((10 + 3 + 0.3 + 3.7 / 3 + 6, 10 + 4 + 3.7 / 1.5, 3.0))


def test_numbers_and_no_law():
    table = LawTable()
    assert table.add(None) == 0
    start = table.add(2.5)
    laws = table.array()
    assert laws.dtype == np.float64 and laws[0] == 0.0
    assert evaluate_curve(laws, start, 7.0) == (2.5, 0.0, 0.0)
    assert evaluate_curve(laws, 0, 7.0) == evaluate_force(laws, 0, 7.0, 1.0) == (0.0, 0.0, 0.0)
    assert potential(laws, 0, 7.0) == 0.0


def test_a_force_term_is_no_curve():
    laws, start = packed(("spring", {"stiffness": 1.0}))
    assert np.all(np.isnan(evaluate_curve(laws, start, 1.0)))


def test_kinks_are_the_stiffest_corners():
    stop = ("stop", {"stiffness": 1e6, "lower": -0.3, "upper": math.inf, "damping": 0.0})
    band = ("dead_band", {"stiffness": 1e4, "lower": -0.01, "upper": 0.02})
    assert kinks((("spring", {"stiffness": 1.0}), stop)) == (-0.3, math.inf)
    assert kinks((band, stop)) == kinks((stop, band)) == (-0.3, 0.02)
    assert kinks(None) == kinks(3.0) == (-math.inf, math.inf)


@pytest.mark.parametrize("name", [name for name, _ in of_role["curve"]])
def test_what_shows_the_shape_of_a_curve_misses_no_bend(name):
    """The largest second derivative of each sign between -1 and 2, at 3,000 points, is reported to 0.5 %."""
    law = (CASES[name][:2],)
    places, reported = shape_of_curve(law, -1.0, 2.0)
    assert np.all(np.diff(places) > 0.0)
    inner = np.linspace(-1.0, 2.0, 3000)
    bend = np.array([curve_at(law, s)[2] for s in inner])
    for sign in (1.0, -1.0):
        assert np.max(sign * reported[:, 2], initial=0.0) >= 0.995 * np.max(sign * bend, initial=0.0)


def test_breakpoints():
    ramp, step = CASES["ramp"][:2], CASES["step"][:2]
    assert breakpoints((ramp, step)) == [-1.0, 1.0, 1.5]
    assert breakpoints((("table", LINEAR),)) == [-2, -1, 0, 0.5, 2]
    assert breakpoints((("table", {**LINEAR, "beyond": "extend"}),)) == [-1, 0, 0.5]
    assert breakpoints((("table", {**CUBIC, "beyond": "hold"}),)) == [-2, 2]
    assert breakpoints((CASES["jump"][:2], CASES["exponential"][:2])) == [-0.5, 0.3]
    assert breakpoints((CASES["sine"][:2],)) == breakpoints(4.0) == []


WRONG = [
    ("table", {**CUBIC, "points": None}, "one of 'points' and 'file' must be given"),
    ("ramp", {"start": 1.0, "end": 1.0, "from": 0.0, "to": 1.0}, "'end' must be greater than 'start'"),
    ("damper_polynomial", {"coefficients": [1.0, 2.0]}, "begin with 0: a damper gives no force at rest"),
    ("damper_table", {**CUBIC, "points": [[-1, -1], [1, 1]]}, "must hold the point [0, 0]"),
    ("damper_table", {**CUBIC, "points": [[0, 0], [1, -1], [2, 3]]}, "must oppose the motion: force and rate"),
    ("metering_pin", {**OIL, "points": [[0, 1e-4], [1, 0]]}, "must have orifice areas greater than zero"),
    ("stop", {"stiffness": 1.0, "lower": -math.inf, "upper": math.inf, "damping": 0.0}, "at least one of 'lower'"),
    ("stop", {"stiffness": 1.0, "lower": 1.0, "upper": 0.0, "damping": 0.0}, "'lower' must be less than 'upper'"),
    ("dead_band", {"stiffness": 1.0, "lower": 1.0, "upper": 0.5}, "'lower' must not be greater than 'upper'"),
]


@pytest.mark.parametrize(("name", "values", "text"), WRONG)
def test_checks_of_terms(name, values, text):
    (found,) = TERMS[name].check(values)
    assert text in found


@every_case
def test_cases_pass_the_checks(name, values, corners):
    assert TERMS[name].check(values) == []
    for field in TERMS[name].fields:
        value = values.get(field.name, field.default)
        assert value is not REQUIRED and (field.check is None or field.check(value) is None)


@pytest.mark.parametrize(("case", "offset"), [(case, b) for case in of_role["curve"] for b in (0.0, 0.4)])
def test_a_curve_along_a_line_is_the_curve_of_the_line(case, offset):
    """Value and derivatives at t are those at 1.7 t + offset, by the chain rule."""
    _, (name, values, corners) = case
    law = along_line(((name, values),), 1.7, offset)
    if law is None:
        assert name == "power" and offset
        return
    assert all(type(point) is list for _, own in law for point in own.get("points", ()))  # as resolved decks write them
    (laws, start), (moved, first) = packed((name, values)), packed(*law)
    for s in points_away_from(corners, np.random.default_rng(3)):
        found, of_line = evaluate_curve(moved, first, (s - offset) / 1.7), evaluate_curve(laws, start, s)
        np.testing.assert_allclose(found, of_line * np.array([1.0, 1.7, 1.7**2]), rtol=1e-9, atol=1e-9)
    assert breakpoints(law) == pytest.approx([(s - offset) / 1.7 for s in breakpoints(((name, values),))])


def test_a_shift_of_a_random_road_moves_it():
    (laws, start), (moved, first) = packed(("random", RANDOM)), packed(("random", {**RANDOM, "origin": 0.7}))
    for s in (0.2, 1.9):
        np.testing.assert_allclose(evaluate_curve(moved, first, s + 0.7), evaluate_curve(laws, start, s), rtol=1e-11)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("20*time", (20.0, 0.0)), ("(time - 0.5)*(-3)/4 + 1", (-0.75, 1.375)), ("time", (1.0, 0.0)), ("3", None),
        ("time**2", None), ("2*time + speed", None), ("abs(time)", None), ("sin(2)*time", (math.sin(2.0), 0.0)),
    ],
)  # fmt: skip
def test_straight_lines_of_the_time(text, line):
    found = line_of_time(text)
    assert found == (line if line is None else pytest.approx(line, rel=1e-15))


def test_some_lines_give_no_law():
    """A slope that is negative, an offset beside which the points of a table are equal."""
    assert along_line((("bump", {"start": 1.0, "length": 1.0, "height": 1.0}),), -2.0, 0.0) is None
    assert along_line((("table", LINEAR),), 2.0, 1e17) is None


WRONG_FIELDS = [
    ("table", "points", [[0, 1]], "must hold at least 2 points"),
    ("table", "points", [[0, 1], [2, 1], [2, 3]], "strictly increasing x: point 3 has 2 after 2"),
    ("polynomial", "coefficients", [], "at least one coefficient"),
    ("dry_friction", "regularization", 0.0, "must be greater than zero"),
    ("gas_spring", "length", -1.0, "must be greater than zero"),
    ("oil_damper", "rebound", -1.0, "must not be negative"),
]


@pytest.mark.parametrize(("term", "name", "value", "text"), WRONG_FIELDS)
def test_checks_of_fields(term, name, value, text):
    (field,) = (field for field in TERMS[term].fields if field.name == name)
    assert text in field.check(value)


@pytest.mark.parametrize("term", TERMS.values(), ids=TERMS)
def test_terms_are_documented(term):
    assert term.doc.endswith(".")
    assert all(field.doc and field.unit for field in term.fields)

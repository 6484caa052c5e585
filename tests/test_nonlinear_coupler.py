"""Nonlinear couplers: elliptical gears against the integral of their energy, a yoke, errors of decks."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from time_runs import RecordedRun, deck, input_deck

from mecano.errors import DeckError

E, J_1, J_2, RATE = 0.3, 0.02, 0.05, 4.0 * np.pi  # eccentricity, inertias [kg m2], initial rate of gear 1 [rad/s]


def ratio(a):
    """Rate of gear 2 over that of gear 1 (Litvin et al., Noncircular Gears, 2009), and its derivative by a."""
    below = 1.0 + E * E + 2.0 * E * np.cos(a)
    return (1.0 - E * E) / below, (1.0 - E * E) * 2.0 * E * np.sin(a) / below**2


def inertia(a):
    return J_1 + J_2 * ratio(a)[0] ** 2


@pytest.fixture(scope="module")
def gears():
    return [RecordedRun(input_deck("elliptical_gears", f"time.step={h}")) for h in (4e-3, 2e-3)]


def test_elliptical_gears_keep_their_energy(verify, gears):
    """a' = rate sqrt(J(0)/J(a)) with the inertia J(a) = J_1 + f'^2 J_2, over more than two turns of gear 1."""
    coarse, fine = gears
    rate = lambda t, a: RATE * np.sqrt(inertia(0.0) / inertia(a))  # noqa: E731
    a = solve_ivp(rate, (0.0, 1.6), [0.0], "DOP853", coarse.time, rtol=1e-12, atol=1e-12).y[0]
    angles = [m["joints/bearing_1/angle"] for m in gears]
    what = "elliptical gears: angle of gear 1 [rad]"
    verify.second_order("Nonlinear coupler", what, angles[0], angles[1][::2], a, 2e-6, "energy")
    f, slope = ratio(a)
    a_2 = -J_2 * f * slope * rate(0, a) ** 2 / inertia(a)  # from J a'' + J'/2 a'^2 = 0
    moment = J_2 * (slope * rate(0, a) ** 2 + f * a_2)
    np.testing.assert_allclose(fine["joints/teeth/load_1"][::2], moment, atol=3e-3)  # f'' of the spline: 3e-3 of it
    assert a[-1] > 4.0 * np.pi


def test_the_turn_of_elliptical_gears_takes_the_time_of_the_deck(gears):
    turn, _ = quad(lambda a: np.sqrt(inertia(a) / inertia(0.0)) / RATE, 0.0, 2.0 * np.pi, epsabs=1e-12)
    angle = gears[1]["joints/bearing_1/angle"]
    found = np.interp(2.0 * np.pi, angle, gears[1].time)  # the rate changes by 3 % in a step
    assert turn == pytest.approx(0.725608, abs=5e-7) and found == pytest.approx(turn, abs=1e-5)


def test_the_angles_of_elliptical_gears(gears):
    """tan(b/2) = (1 - e)/(1 + e) tan(a/2), as far as the spline through the table agrees, 4e-7 rad."""
    a, b = (gears[1][f"joints/bearing_{i}/angle"] for i in (1, 2))
    half = np.arctan2((1.0 - E) * np.sin(0.5 * a), (1.0 + E) * np.cos(0.5 * a))
    np.testing.assert_allclose(b, 2.0 * np.unwrap(half, period=np.pi), atol=1e-6)


YOKE = """
    mecano: 1
    gravity: none
    nodes: {crank: {position: [0, 0, 0]}, yoke: {position: [1, 0, 0]}}
    elements:
      crank: {type: rigid_body, node: crank, mass: 1, inertia: [0.02, 0.02, 0.02]}
      yoke: {type: point_mass, node: yoke, mass: 2}
    joints:
      bearing: {type: hinge, nodes: [ground, crank], axis: [0, 0, 1]}
      guide: {type: cylindrical, nodes: [ground, yoke], axis: [1, 0, 0]}
      motor: {type: prescribed_angle, nodes: [ground, crank], axis: [0, 0, 1], value: 5*time}
      coupling: {type: nonlinear_coupler, GIVEN}
    laws: {stroke: {sine: {amplitude: 0.1, frequency: 0.15915494309189535}}}
    time: {end: 2, step: 0.005}
    """
YOKE_OF_CRANK = "displacement: guide, of_angle: bearing, function: stroke, start: 0.4"


def test_a_crank_drives_a_yoke():
    """Displacement r (sin(s + w t) - sin s): the force m x'' on the yoke, and its power by the motor."""
    m = RecordedRun(deck(YOKE.replace("GIVEN", YOKE_OF_CRANK)))
    phase = 0.4 + 5.0 * m.time
    np.testing.assert_allclose(m["joints/guide/displacement"], 0.1 * (np.sin(phase) - np.sin(0.4)), atol=1e-9)
    force = -2.0 * 0.1 * 25.0 * np.sin(phase)
    np.testing.assert_allclose(m["joints/coupling/load_1"], force, atol=5e-3)
    np.testing.assert_allclose(m["joints/coupling/load_2"], -m["joints/motor/moment"], atol=1e-9)
    np.testing.assert_allclose(m["joints/coupling/load_2"], -0.1 * np.cos(phase) * force, atol=1e-3)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ("displacement: guide, function: stroke", "give one of 'of_angle' and 'of_displacement'"),
        (YOKE_OF_CRANK + ", angle: bearing", "give one of 'angle' and 'displacement'"),
        ("angle: bearing, of_angle: bearing, function: stroke", "both coordinates are those of one joint"),
        (
            "displacement: guide, of_angle: bearing, function: {table: {points: [[0, 0], [1, 2], [3, 4]]}}",
            "'function' has a jump or a corner at 0, where the joint would need a shock; a table needs 'interpol",
        ),
        (
            "displacement: guide, of_angle: bearing, function: {polynomial: [0, 1, 1]}, period: 3",
            "'function' has another slope at 0 (1) than at the 'period' 3 (7)",
        ),
    ],
)
def test_couplers_that_are_refused(given, text):
    with pytest.raises(DeckError) as error:
        deck(YOKE.replace("GIVEN", given))
    assert text in error.value.problems[0].message


def test_a_formula_is_the_same_as_its_closed_form(verify):
    """Elliptical gears by a formula: tan(b/2) = (1 - e)/(1 + e) tan(a/2), continued over turns, exact at any step."""
    formula = "s - 2*atan2(0.3*sin(s), 1 + 0.3*cos(s))"
    text = ["joints.teeth.function=null", f"joints.teeth.formula={formula}", "joints.teeth.period=null"]
    coarse, fine = (RecordedRun(input_deck("elliptical_gears", *text, f"time.step={h}")) for h in (4e-3, 2e-3))
    rate = lambda t, a: RATE * np.sqrt(inertia(0.0) / inertia(a))  # noqa: E731
    a = solve_ivp(rate, (0.0, 1.6), [0.0], "DOP853", coarse.time, rtol=1e-12, atol=1e-12).y[0]
    angles = [m["joints/bearing_1/angle"] for m in (coarse, fine)]
    what = "elliptical gears by a formula: angle of gear 1 [rad]"
    verify.second_order("Nonlinear coupler", what, angles[0], angles[1][::2], a, 2e-6, "energy")
    own, b = (fine[f"joints/bearing_{i}/angle"] for i in (1, 2))
    np.testing.assert_allclose(b, own - 2.0 * np.arctan2(E * np.sin(own), 1.0 + E * np.cos(own)), rtol=0.0, atol=1e-12)
    f, slope = ratio(a)
    a_2 = -J_2 * f * slope * rate(0, a) ** 2 / inertia(a)
    moment = J_2 * (slope * rate(0, a) ** 2 + f * a_2)
    np.testing.assert_allclose(fine["joints/teeth/load_1"][::2], moment, rtol=0.0, atol=3e-4)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("abs(s)", "'abs' has a corner"),
        ("s + time", "must depend on s alone"),
        ("sin(x)", "must depend on s alone"),
        ("sin(s", "a bracket is not closed"),
    ],
)
def test_errors_of_formulas(given, message):
    with pytest.raises(DeckError, match=message):
        input_deck("elliptical_gears", "joints.teeth.function=null", f"joints.teeth.formula='{given}'")


def test_a_function_is_given_once():
    with pytest.raises(DeckError, match="give one of 'function' and 'formula'"):
        input_deck("elliptical_gears", "joints.teeth.formula=s")

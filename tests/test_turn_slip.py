"""Turn slip of brush tyres: spin moment and lateral force against bristles on the whole contact, and on the spot."""

import numpy as np
import pytest
from time_runs import INPUTS, RecordedRun, deck, input_deck

from mecano.analyses.law_tests import Tyre
from mecano.elements.wheels.fiala import FIALA
from mecano.elements.wheels.slip_law import default_values
from mecano.elements.wheels.tire_law import slip_law_of
from mecano.elements.wheels.turn_slip import reach
from mecano.elements.wheels.yawed_rolling import YAWED_ROLLING
from mecano.errors import DeckError

MU, LOAD, HALF, WIDE, C = 0.8, 4000.0, 0.06, 0.05, 6e4  # friction, N [N], a, b [m], slip stiffness [N/rad]
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(60)


def fiala(**fields):
    values = {
        "cornering_stiffness": C, "friction": MU, "contact_length": 2 * HALF, "contact_width": 2 * WIDE,
        "least_speed": 1e-6, **fields,
    }  # fmt: skip
    law = {"fiala": default_values(FIALA.type.options, values)}
    return Tyre(slip_law_of(law), law)


def over_contact(a=HALF, b=WIDE):
    """Return x, y, (n, n) [m] and the shares of the load, parabolic along x and uniform along y, at points of it."""
    x, y = np.meshgrid(a * POINTS, b * POINTS, indexing="ij")
    return x, y, np.outer(0.75 * WEIGHTS * (1.0 - POINTS**2), 0.5 * WEIGHTS)


def sliding(v, W):
    """Return force (2,) [N] and moment [N m] of a contact that slides as a whole with v (2,) and turns with W."""
    x, y, share = over_contact()
    v_t, v_l = v[0] - W * y, v[1] + W * x
    pressed = -MU * LOAD * share / np.hypot(v_t, v_l)
    return (pressed * v_t).sum(), (pressed * v_l).sum(), (pressed * (x * v_l - y * v_t)).sum()


def bristles(v, W, V_r, steps=4000):
    """Return force (2,) [N] and moment [N m] of elastic bristles that enter in front and slide at the friction limit.

    A bristle at (x, y) moves with v + W x (x, y) over the ground while it passes the contact with V_r; its shear is
    clipped to mu times the pressure in every step.
    """
    step = 2.0 * HALF / steps
    y, weight = WIDE * POINTS, 0.5 * WEIGHTS
    c, e_t, e_l, total = C / (2.0 * HALF**2), np.zeros_like(y), np.zeros_like(y), np.zeros(3)
    for x in HALF - step * (np.arange(steps) + 0.5):
        e_t, e_l = e_t + (v[0] - W * y) * step / V_r, e_l + (v[1] + W * x) * step / V_r
        most = MU * 0.75 * LOAD / HALF * (1.0 - (x / HALF) ** 2) / c
        kept = np.minimum(1.0, most / np.maximum(np.hypot(e_t, e_l), 1e-30))
        e_t, e_l = kept * e_t, kept * e_l
        total -= c * step * np.array([weight @ e_t, weight @ e_l, weight @ (x * e_l - y * e_t)])
    return total


def found(tyre, v, W, V_r):
    k = tyre.forces(LOAD, v, (V_r + v[0], 0.0), (0.0, 0.0, W))
    return np.array([k.F[0], k.F[1], k.M[2]])


@pytest.mark.parametrize("ratio", [0.0, 0.1, 0.3, 0.5, 0.8, 1.0, 1.5, 3.0, 10.0, 1e6])
def test_reach_is_the_mean_distance_of_the_pressure(ratio):
    x, y, share = over_contact(1.0, ratio)
    assert reach(1.0, ratio) == pytest.approx((share * np.hypot(x, y)).sum(), rel=0.012)


def test_a_tyre_that_turns_on_the_spot_has_the_moment_of_friction(verify):
    """All of the contact slides: mu N k, against the integral of the friction over the contact, and Gough's formula."""
    moment = found(fiala(), (0.0, 0.0), 0.5, 0.0)
    whole = sliding((0.0, 0.0), 0.5)[2]
    np.testing.assert_allclose(moment, [0.0, 0.0, whole], rtol=0.012, atol=1e-9)
    source = "friction integrated over the contact"
    verify("Tyres", "Fiala's tyre turned on the spot: moment [N m]", moment[2], whole, source, relative=0.012)


def test_parking_moment_is_near_the_formula_of_gough():
    """M = (mu/3) sqrt(N^3/p), p: the mean pressure of the contact (Gough; Sharp and Granger, Proc. IMechE D 217, 2003).

    It is fitted to car tyres, whose contacts are about as wide as long.
    """
    pressure = LOAD / (4 * HALF * WIDE)
    moment = found(fiala(), (0.0, 0.0), -0.5, 0.0)[2]
    assert moment == pytest.approx(MU / 3.0 * np.sqrt(LOAD**3 / pressure), rel=0.1)


@pytest.mark.parametrize("V_r", [20.0, -20.0])
def test_small_turn_slip_is_that_of_bristles(V_r):
    """C b^2 W/(3 V) and C (a/3) W/V, with a moment against the turn; 4000 steps along the contact."""
    W = 0.01
    expected = bristles((0.0, 0.0), W, 20.0)
    F_t, F_l, M = found(fiala(), (0.0, 0.0), W, V_r)
    assert [F_t, F_l] == pytest.approx([0.0, np.sign(V_r) * expected[1]], rel=5e-3, abs=1e-9)
    assert pytest.approx(expected[2], rel=5e-3) == M


@pytest.mark.parametrize(("radius", "most"), [(5.0, 0.025), (1.0, 0.11), (0.3, 0.25), (0.05, 0.12)])
def test_turn_slip_between_adhesion_and_sliding_is_near_that_of_bristles(radius, most):
    """Errors over mu N and mu N k at several slips, as in docs/tyre-equations.md; bristles have no closed form."""
    W, unit = 20.0 / radius, MU * LOAD * np.array([1.0, 1.0, reach(HALF, WIDE)])
    for v in (0.0, 0.0), (0.0, 0.3), (0.4, -0.4), (0.0, 1.5), (0.0, -1.0), (2.0, 0.5):
        error = (found(fiala(), v, W, 20.0) - bristles(v, W, 20.0, 600)) / unit
        assert np.abs(error).max() < most


@pytest.mark.parametrize("angle", np.radians([0.0, 20.0, 45.0, 70.0, 90.0]))
def test_sliding_and_turning_share_the_friction(angle):
    """Against friction over a contact that slides and turns: the ellipsoid is within 0.13 of mu N."""
    k = reach(HALF, WIDE)
    v, W = (0.0, np.cos(angle)), np.sin(angle) / k
    error = (found(fiala(), v, W, 0.0) - sliding(v, W)) / (MU * LOAD * np.array([1.0, 1.0, k]))
    assert np.abs(error).max() < 0.13


def test_a_leaning_wheel_that_runs_straight_has_no_turn_slip():
    """The spin about the normal of a leaning wheel is no turn of its plane."""
    lean = 0.2
    axis = np.array([0.0, np.sqrt(1.0 - lean * lean), lean])
    with_width = fiala().forces(LOAD, (0.0, 0.0), omega=60.0 * axis, lean=lean)
    without = fiala(contact_width=0.0).forces(LOAD, (0.0, 0.0), omega=60.0 * axis, lean=lean)
    np.testing.assert_allclose([*with_width.F, *with_width.M], [*without.F, *without.M], atol=1e-6)


def test_an_aircraft_tyre_turns_on_the_spot_with_the_moment_of_its_contact():
    """``yawed_rolling`` with the half length 0.85 sqrt(w (2r - w)) of its deflection: mu N k of this contact."""
    values = {"cornering_stiffness": C, "friction": MU, "contact_width": 2 * WIDE, "least_speed": 1e-6}
    law = {"yawed_rolling": default_values(YAWED_ROLLING.type.options, values)}
    tyre = Tyre(slip_law_of(law), law)
    x, y, share = over_contact(0.85 * np.sqrt(0.02 * (0.6 - 0.02)))
    k = tyre.forces(LOAD, (0.0, 0.0), (0.0, 0.0), (0.0, 0.0, 0.5))
    assert k.M[2] == pytest.approx(-MU * LOAD * (share * np.hypot(x, y)).sum(), rel=0.012)
    assert k.lost == pytest.approx(-0.5 * k.M[2], rel=1e-12)


def test_tyres_on_a_turning_carriage_have_the_moments_of_bristles():
    """The deck: on the spot within 1.2 %, on the circle within 5 % of the bristles, both ways; no energy is missing."""
    run = RecordedRun(input_deck("turn_slip"))
    on_the_spot, circle = sliding((0.0, 0.0), 0.25)[2], bristles((0.0, 0.0), 0.25, 1.0)
    times = np.searchsorted(run.time, [0.2, 1.8])
    for name, expected, share in ("parked", on_the_spot, 0.012), ("rolling", circle[2], 0.05):
        moments = run[f"elements/{name}_tyre/slip_moment"][times, 2]
        np.testing.assert_allclose(moments, [expected, -expected], rtol=share)
    np.testing.assert_allclose(run["elements/rolling_tyre/lateral_force"].ravel()[times], circle[1], rtol=0.05)
    assert np.ptp(run["energy/balance"]) < 1e-4 * run["energy/dissipated"].ravel()[-1]


def test_a_carcass_winds_up_before_the_contact_slides():
    """A parked ``transient_wheel``, steered to and fro by A: elastic up to mu N k, then sliding.

    The loop of an elastic, ideally plastic spring has the area 4 M (A - M/K).
    """
    K, A = 6e3, 0.05
    text = (INPUTS / "turn_slip.yaml").read_text().replace("swing: 0.5 rad", f"swing: {A}")
    carcass = f"least_speed: 0.02 mm/s, carcass_stiffness: [2.0e5, 2.0e5], creep_length: 1 mm, torsional_stiffness: {K}"
    text = text.replace("type: wheel,", "type: transient_wheel,").replace("least_speed: 1 mm/s", carcass)
    run = RecordedRun(deck(text.replace("end: $period", "end: 2*$period")))
    angle, moment = run["joints/steering/angle"].ravel(), run["elements/parked_tyre/slip_moment"][:, 2]
    most, first = MU * LOAD * reach(HALF, WIDE), run.time < 0.12
    assert np.abs(moment).max() == pytest.approx(most, rel=1e-6)
    np.testing.assert_allclose(moment[first], -K * angle[first], atol=0.04 * most)
    np.testing.assert_allclose(run["elements/parked_tyre/psi"].ravel(), moment / K, atol=0.01 * most / K)
    last = run.time >= 4.0
    work = -np.sum(0.5 * (moment[last][1:] + moment[last][:-1]) * np.diff(angle[last]))
    assert work == pytest.approx(4.0 * most * (A - most / K), rel=0.03)


def test_a_twist_needs_a_moment():
    changes = (f"tire_laws.brush.fiala.{change}" for change in ("torsional_stiffness=100", "contact_width=0"))
    with pytest.raises(DeckError) as info:
        input_deck("turn_slip", *changes)
    assert "'tire_law.fiala.torsional_stiffness' needs 'contact_width'" in info.value.problems[0].message

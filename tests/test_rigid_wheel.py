"""Rolling without slip: rigid wheel, the wheel of the paper, skate; constraints on velocities in the solver.

References: a1_rolling_disc (a thin disc, from three quasi-velocity equations and again from Newton-Euler equations with
multipliers, to 1e-9), a3_a4 (Chaplygin's sleigh, closed form; braking), a6 (the paper's equations taken literally).
"""

import numpy as np
import pytest
from convergence import at_times, check_second_order
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from small_motions import eigenvalues
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.modal import modes
from mecano.errors import DeckError

TIMES = [0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0]
CENTRE = [
    [0.9624148165043946, 0.3331484723178318, 0.30556510781523577],
    [1.6751455383002716, 1.0253372968729695, 0.3038575940659686],
    [1.9503266230011491, 1.9805650581997196, 0.3111851238303117],
    [1.7258423673230077, 2.94932980797236, 0.3074697694084281],
    [1.0546031802571636, 3.6819235700789, 0.30270815581234184],
    [0.10744479253345018, 3.983043524829879, 0.31023395893100997],
    [-0.8668737122851882, 3.783629443060484, 0.309224725646207],
    [-1.6184365870566735, 3.133489571173387, 0.30238412078289073],
]
CONTACT = [
    [1.0192477490099334, 0.24708900062131137],
    [1.7646817037091078, 0.9648386389347758],
    [2.0348666084873646, 1.9757630210586674],
    [1.8082302119737943, 3.0011065783788453],
    [1.117001247262459, 3.7740132200874306],
    [0.11700482783506012, 4.070620613449131],
    [-0.9128516775704492, 3.8628275854456144],
    [-1.7114683180098424, 3.1960610545681036],
]
REACTION = [
    [-1.1377592778916468, 1.810796577920909, 9.894950362809205],
    [-1.8721907715619055, 1.212892419547684, 10.055933611808715],
    [-1.8746079203941621, 0.09901511643347642, 9.536021838548116],
    [-1.7514125125398263, -1.0520297438938548, 9.741560525991432],
    [-1.268370315012806, -1.9143748384547026, 10.175817917584352],
    [-0.1900892928435541, -1.9078725967460026, 9.575312538762327],
    [0.9607919006133911, -1.7101640236358742, 9.627547970000489],
    [1.918990039080964, -1.2957539006360832, 10.211211845137548],
]


def test_a_disc_released_leaning_converges_to_the_reference(verify):
    """Centre, contact and reactions, multipliers of constraints on velocities among them, at second order."""
    quantities = (
        ("nodes/centre/position", CENTRE, 1e-6),
        ("elements/rim/contact_force", REACTION, 2e-6),
    )
    exactly = "time.newton.force_tolerance=1e-10"  # by default Newton's iteration leaves some 1e-5 N
    marches = [RecordedRun(input_deck("rolling_disc", f"time.step={h}", exactly)) for h in (2e-3, 1e-3)]
    for path, reference, left in quantities:
        coarse, fine = (at_times(recorded, recorded[path], TIMES) for recorded in marches)
        what = f"disc released leaning: {path.split('/')[-1].replace('_', ' ')} over 4 s [m, N]"
        verify.second_order("Rolling", what, coarse, fine, reference, left, "minimal coordinates, tight tolerance")
    contact = [at_times(recorded, recorded["elements/rim/contact_point"][:, :2], TIMES) for recorded in marches]
    check_second_order(*contact, CONTACT, 1e-6)
    leaks = [np.ptp(recorded["energy/total"]) for recorded in marches]
    assert leaks[0] / leaks[1] == pytest.approx(4.0, abs=0.01) and leaks[1] < 2e-6


def test_reactions_are_of_second_order_from_the_first_step_on():
    """Errors of the first eight steps fall fourfold with the step, each against its own; a fine run as reference."""
    fine = RecordedRun(input_deck("rolling_disc", "time.step=1.25e-4", "time.end=0.032"))
    errors = []
    for h in (4e-3, 2e-3):
        recorded = RecordedRun(input_deck("rolling_disc", f"time.step={h}", "time.end=0.032"))
        times = np.arange(1, 9) * h
        reaction = [at_times(m, m["elements/rim/contact_force"], times) for m in (recorded, fine)]
        errors.append(np.linalg.norm(reaction[0] - reaction[1], axis=1))
    assert errors[0].max() / errors[1].max() == pytest.approx(4.0, abs=0.2)


def test_reactions_stay_of_second_order_with_steps_that_change():
    """Adaptive steps, which change by factors up to two: errors follow the square of the step, as positions do.

    Values at 4 s are interpolated: a last step of any length, to end there, would decide the error of the reaction.
    """
    errors = []
    for tolerance in (1e-3, 1e-5):
        step = f"time={{end: 4.05, step: 1e-3, adaptive: {{tolerance: {tolerance}}}}}"
        recorded = RecordedRun(input_deck("rolling_disc", step))
        last = recorded.time > 3.9
        outputs = (("nodes/centre/position", CENTRE), ("elements/rim/contact_force", REACTION))
        at_4 = [CubicSpline(recorded.time[last], recorded[path][last])(4.0) for path, _ in outputs]
        errors.append([np.abs(one - known[-1]).max() for one, (_, known) in zip(at_4, outputs, strict=True)])
    (x0, f0), (x1, f1) = errors
    assert x1 < 1e-4 and f1 < 5e-5
    assert f0 / f1 > 0.3 * x0 / x1  # reactions converge as the positions do


@pytest.mark.parametrize("tolerance", [1e-4, 1e-5, 1e-6])
def test_the_error_of_a_rolling_disc_is_the_tolerance_asked_for(tolerance):
    """Of the size of the tolerance, though the acceleration of the disc varies little at times: steps stay short."""
    step = f"time={{end: 4.05, step: 1e-3, adaptive: {{tolerance: {tolerance}, length_scale: 1}}}}"
    run = RecordedRun(input_deck("rolling_disc", step))
    found = CubicSpline(run.time, run["nodes/centre/position"])(TIMES)
    assert np.abs(found - CENTRE).max() < 3.0 * tolerance


R, E, MASS, G = 0.3225, 0.12, 1.0, 9.81  # radius with the tread, its crown, kg, m/s2
TORUS_TIMES = [0.25, 0.5, 0.75, 1.0]
TORUS = f"""
    mecano: 1
    gravity: [0, 0, -{G}]
    nodes: {{{{centre: {{{{position: [0, 0, HEIGHT], orientation: [-0.4, 0, 0]}}}}}}}}
    elements:
      wheel: {{{{type: rigid_body, node: centre, mass: {MASS}, inertia: [0.03, 0.05, 0.03]}}}}
      rim: {{{{type: rigid_wheel, node: centre, radius: {R}, crown_radius: {E}, axis: [AXIS], ground: floor}}}}
    grounds: {{{{floor: {{{{plane: {{{{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}}}}}}}
    initial: {{{{velocities: [{{{{nodes: [centre], velocity: [VELOCITY], angular_velocity: [SPIN]}}}}]}}}}
    time: {{{{end: 1.0, step: {{step}}}}}}
"""


def contact_of_torus(axis, spin):
    """Arm from the centre to the contact, and its rate as the axis turns."""
    n = np.array([0.0, 0.0, 1.0])
    s, turning = n @ axis, np.cross(spin, axis)
    q, s1 = np.sqrt(1.0 - s * s), n @ turning
    rate = (s1 * axis + s * turning) / q - (n - s * axis) * s * s1 / q**3
    return -(R - E) * (n - s * axis) / q - E * n, (R - E) * rate


def rates_of_torus(t, y):
    """Newton and Euler: rates of centre, rotation and angular velocity of a torus that rolls, v = -omega x arm."""
    A, spin = y[3:12].reshape(3, 3), y[12:]
    arm, turning = contact_of_torus(A[:, 1], spin)
    J = A @ np.diag([0.03, 0.05, 0.03]) @ A.T
    about_contact = J + MASS * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    pulled = MASS * np.cross(arm, np.array([0.0, 0.0, G]) - np.cross(spin, turning)) - np.cross(spin, J @ spin)
    across = [[0.0, -spin[2], spin[1]], [spin[2], 0.0, -spin[0]], [-spin[1], spin[0], 0.0]]
    return np.concatenate([-np.cross(spin, arm), (across @ A).ravel(), np.linalg.solve(about_contact, pulled)])


def test_a_wheel_with_a_rounded_tread_rolls_as_a_torus(verify):
    """Released leaning; its contact moves across the tread."""
    c, s = np.cos(0.4), np.sin(0.4)
    A, spin = np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]]), np.array([0.1, 6.0, -1.5])
    velocity, height = -np.cross(spin, contact_of_torus(A[:, 1], spin)[0]), E + (R - E) * c
    text = TORUS.replace("HEIGHT", repr(float(height)))
    for name, vector in (("AXIS", A[:, 1]), ("VELOCITY", velocity), ("SPIN", spin)):
        text = text.replace(name, ", ".join(map(repr, vector.tolist())))
    start = np.concatenate([[0.0, 0.0, height], A.ravel(), spin])
    exact = solve_ivp(rates_of_torus, (0.0, 1.0), start, t_eval=TORUS_TIMES, rtol=1e-11, atol=1e-12).y
    marches = [RecordedRun(deck(text.format(step=step))) for step in (2e-3, 1e-3)]
    centre = [at_times(run, run["nodes/centre/position"], TORUS_TIMES) for run in marches]
    verify.second_order("Rolling", "torus released leaning: centre over 1 s [m]", *centre, exact[:3].T, 2e-8, "SciPy")
    run, arms = marches[1], [contact_of_torus(y[3:12].reshape(3, 3)[:, 1], y[12:])[0] for y in exact.T]
    contact = at_times(run, run["elements/rim/contact_point"], TORUS_TIMES)
    np.testing.assert_allclose(contact, exact[:3].T + arms, atol=1e-6)
    np.testing.assert_allclose(run["elements/rim/contact_point"][:, 2], 0.0, atol=1e-9)
    np.testing.assert_allclose(run["elements/rim/height"].ravel(), run["nodes/centre/position"][:, 2], atol=1e-12)
    assert np.ptp(run["energy/total"]) < 1e-5  # J of 11 J


def test_a_crown_is_smaller_than_the_wheel():
    given = UPRIGHT.format(kind="rigid_wheel", v=1.0, w=1.0 / 0.3225).replace(
        "0.3225, axis", "0.3225, crown_radius: 0.3225, axis"
    )
    with pytest.raises(DeckError, match=r"'crown_radius' must be less than the 'radius' of 0\.3225 m"):
        deck(given)


UPRIGHT = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      centre: {{position: [0, 0, 0.3225]}}
    elements:
      disc: {{type: rigid_body, node: centre, mass: 1.0, inertia: [0.0260015625, 0.052003125, 0.0260015625]}}
      rim: {{type: {kind}, node: centre, radius: 0.3225, axis: [0, 1, 0], ground: floor}}
    grounds:
      floor: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}
    initial:
      velocities: [{{nodes: [centre], velocity: [{v}, 0, 0], angular_velocity: [0, {w}, 0]}}]
    time: {{end: 1.0, step: 1.0e-3}}
"""


def upright(kind, v):
    """Eigenvalues of a thin disc that rolls upright at v [m/s]."""
    return eigenvalues(deck(UPRIGHT.format(kind=kind, v=v, w=v / 0.3225)))


def test_wobble_of_the_upright_disc(verify):
    """omega^2 = (12/5) (v/r)^2 - (4/5) g/r; falls below v^2 = g r/3."""
    found, exact = abs(upright("rigid_wheel", 2.0)[-1].imag), 8.244225954135265
    verify("Rolling", "upright disc: wobble at 2 m/s [rad/s]", found, exact, "closed form", relative=1e-9)
    slow, fast = (upright("rigid_wheel", 1.0269250216057646 * factor)[-2:] for factor in (0.999, 1.001))
    assert slow.real.max() > 0.1 and abs(slow.imag).max() < 1e-6
    assert abs(fast.real).max() < 1e-6 and abs(fast.imag).max() > 0.1


def test_the_wheel_of_the_paper_has_no_critical_speed(verify):
    """omega = sqrt(C (C + m r^2)/(A (A + m r^2))) v/r at any speed (a6)."""
    for v, omega in ((2.0, 9.607400548731578), (5.0, 24.018501371828943), (0.5, 9.607400548731578 / 4)):
        what, found = f"wheel of the paper: wobble at {v:g} m/s [rad/s]", abs(upright("cardona_wheel", v)[-1].imag)
        verify("Rolling", what, found, omega, "closed form", relative=1e-9)


def test_the_paper_disc_wobbles_in_time():
    recorded = RecordedRun(input_deck("paper_disc"))
    rate = recorded["nodes/centre/angular_velocity"][:, 2]
    crossings = recorded.time[1:][np.diff(np.sign(rate)) != 0]
    period = 2 * np.diff(crossings).mean()
    assert period == pytest.approx(2 * np.pi / 9.607400548731578, rel=2e-3)


def steady(theta_deg, psidot, w3):
    """Run a thin disc that rolls on a circle."""
    theta = np.radians(theta_deg)
    c, s, r = np.cos(theta), np.sin(theta), 0.3225
    lean, w2 = np.pi / 2 - theta, psidot * s
    return RecordedRun(
        deck(f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes:
          centre: {{position: [0, {float(r * c)!r}, {float(r * s)!r}], orientation: [{float(-lean)!r}, 0, 0]}}
        elements:
          disc: {{type: rigid_body, node: centre, mass: 1.0, inertia: [0.0260015625, 0.052003125, 0.0260015625]}}
          rim: {{type: rigid_wheel, node: centre, radius: {r}, axis: [0, {float(s)!r}, {float(-c)!r}], ground: floor}}
        grounds:
          floor: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}
        initial:
          velocities:
            - nodes: [centre]
              velocity: [{float(-w3 * r)!r}, 0, 0]
              angular_velocity: [0, {float(w2 * c - w3 * s)!r}, {float(w2 * s + w3 * c)!r}]
        time: {{end: 0.2, step: 5.0e-4}}
        """)
    )


def test_steady_circles(verify):
    """Reactions and friction of steady motions at 80 and 30 degrees (a1, steady)."""
    for theta, psidot, w3, friction, needed in (
        (80.0, 1.0, -3.5468057807248496, 1.143844864283764, 0.11659988422872211),
        (30.0, 8.0, -3.2358468575511594, 8.348484892481991, 0.8510178279798156),
    ):
        recorded = steady(theta, psidot, w3)
        rim = {name: recorded[f"elements/rim/{name}"] for name in ("normal_force", "lateral_force", "friction_needed")}
        np.testing.assert_allclose(rim["normal_force"], 9.81, rtol=1e-4)
        found, what = np.abs(rim["lateral_force"]), f"disc in a steady circle at {theta:g} deg: friction [N]"
        verify("Rolling", what, found, friction, "steady motion, closed form", relative=1e-4)
        np.testing.assert_allclose(rim["friction_needed"], needed, rtol=1e-6)
        np.testing.assert_allclose(
            recorded["nodes/centre/position"][:, 2], 0.3225 * np.sin(np.radians(theta)), rtol=1e-5
        )


SLEIGH_TIMES = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0]
SLEIGH_EDGE = [
    [-0.4886554864345279, -0.05465369848759357],
    [-0.836368040031133, -0.27944219013033056],
    [-0.8814379291620312, -0.37108006262115245],
    [-1.2142977039023377, -0.35638099248806404],
    [-1.9580121333987388, -0.9816222633941071],
    [-2.572661837498485, -1.7763076606538581],
    [-3.762749309810773, -3.3962356463333894],
]
SLEIGH_TURN = [
    0.2736374535524882, 1.0406919561496941, 2.4434171187442537, 3.4767593963509125, 4.0145623311244165,
    4.0732914827360664, 4.080260757568924,
]  # fmt: skip


def sleigh_force(t):
    """Force on the knife of Chaplygin's sleigh, closed form: m (v w + a dw/dt)."""
    m, a, E = 2.0, 0.25, 1.010125
    J, K = 0.1 + m * a * a, np.sqrt(2 * E / m)
    rate, s0 = a * m * K / J, np.arctanh(-1.0 / K)
    v, w = K * np.tanh(rate * t + s0), np.sqrt(2 * E / J) / np.cosh(rate * t + s0)
    return m * (v * w - a * rate * w * np.tanh(rate * t + s0))


def test_chaplygins_sleigh(verify):
    marches = [RecordedRun(input_deck("sleigh", f"time.step={h}")) for h in (4e-3, 2e-3)]
    at = [[at_times(m, m[path], SLEIGH_TIMES) for m in marches] for path in (
        "nodes/edge/position", "joints/turning/angle", "elements/knife/lateral_force",
    )]  # fmt: skip
    edge, force, source = (values[:, :2] for values in at[0]), sleigh_force(np.array(SLEIGH_TIMES)), "closed form"
    verify.second_order("Rolling", "sleigh of Chaplygin: path [m]", *edge, SLEIGH_EDGE, 2e-6, source)
    verify.second_order("Rolling", "sleigh of Chaplygin: heading [rad]", *at[1], SLEIGH_TURN, 9e-7, source)
    verify.second_order("Rolling", "sleigh of Chaplygin: force on the knife [N]", *at[2], force, 2.5e-6, source)
    assert np.ptp(marches[1]["energy/total"]) < 1e-4 * 1.010125


def test_eigenvalues_of_the_benchmark_bicycle():
    """Meijaard, Papadopoulos, Ruina & Schwab 2007, table 2, at 0 and 5 m/s."""
    fast = eigenvalues(input_deck("bicycle"))
    expected = [-0.322866429004087, -0.775341882195845 - 4.464867713788229j, -0.775341882195845 + 4.464867713788229j,
                -14.078389692798215]  # fmt: skip
    np.testing.assert_allclose(fast[-4:], expected, rtol=1e-8)
    slow = eigenvalues(input_deck("bicycle", "parameters.speed=0"))
    np.testing.assert_allclose(
        np.sort(slow[-4:].real), [-5.53094371765393, -3.13164324790656, 3.13164324790656, 5.53094371765393], rtol=1e-8
    )


def test_the_bicycle_rights_itself():
    recorded = RecordedRun(input_deck("bicycle"))
    lean = recorded["nodes/frame/angular_velocity"][:, 0]
    assert np.abs(lean[recorded.time > 4.0]).max() < 0.1 * np.abs(lean).max()
    assert np.ptp(recorded["energy/total"]) < 1e-6 * recorded["energy/total"][0]


def test_an_axle_goes_across_the_slope_on_a_cycloid():
    """Lateral constraints of both wheels repeat one another; each takes half of the force, of second order."""
    g, times = 0.981 * 30.0 / (30.0 + 2 * 0.1 / 0.0625), np.arange(1, 9) * 0.5
    path = np.stack([g / 4 * (1 - np.cos(2 * times)), g / 2 * (times - np.sin(2 * times) / 2)], axis=1)
    marches = [RecordedRun(input_deck("axle_on_slope", f"time.step={h}")) for h in (1e-2, 5e-3)]
    assert [group.count for group in marches[0].prepared.analysis.redundant] == [1]
    coarse, fine = (at_times(m, m["nodes/axle/position"][:, :2], times) for m in marches)
    check_second_order(coarse, fine, path, 3e-7)
    for side in ("left", "right"):
        coarse, fine = (at_times(m, m[f"elements/{side}_wheel/lateral_force"].ravel(), times) for m in marches)
        check_second_order(coarse, fine, 15.0 * (g + 0.981) * np.sin(times), 1e-5)
        first = marches[1][f"elements/{side}_wheel/lateral_force"].ravel()[:40]
        np.testing.assert_allclose(first, 15.0 * (g + 0.981) * np.sin(marches[1].time[:40]), rtol=0, atol=1e-4)


def test_a_trailing_wheel_follows_the_curve_parallel_to_the_bump():
    recorded = RecordedRun(input_deck("trailing_wheel_bump"))
    hub = recorded["nodes/hub/position"]

    def curve(s):
        inside = 1.0 < s < 2.0
        H = 0.025 * (1 - np.cos(2 * np.pi * (s - 1))) if inside else 0.0
        H1 = 0.05 * np.pi * np.sin(2 * np.pi * (s - 1)) if inside else 0.0
        length = np.sqrt(1 + H1 * H1)
        return s - 0.3 * H1 / length, H + 0.3 / length

    for i in range(0, len(hub), 40):
        s = brentq(lambda s, i=i: curve(s)[0] - hub[i, 0], hub[i, 0] - 0.3, hub[i, 0] + 0.3, xtol=1e-14)
        assert hub[i, 2] == pytest.approx(curve(s)[1], abs=1e-10)
    speed = np.linalg.norm(recorded["nodes/hub/velocity"], axis=1)
    np.testing.assert_allclose(recorded["elements/wheel/spin_rate"], speed / 0.3, rtol=2e-5)
    passed = [(h.t, h.name) for h in recorded.event_records if h.element == "rigid_wheel 'wheel'"]
    np.testing.assert_allclose([t for t, _ in passed], [0.28, 0.48], atol=1e-8)  # (1, 2 m + 0.4 m)/5 m/s
    assert {name for _, name in passed} == {"bend"}


BUMP = """
    mecano: 1
    gravity: [0, 0, 0]
    nodes: {{one: {{position: [0, 0, 0.3]}}, other: {{position: [{apart!r}, 1, 0.3]}}}}
    elements:
      disc_1: {{type: rigid_body, node: one, mass: 10.0, inertia: [0.25, 0.45, 0.25]}}
      disc_2: {{type: rigid_body, node: other, mass: 10.0, inertia: [0.25, 0.45, 0.25]}}
      rim_1: {{type: rigid_wheel, node: one, radius: 0.3, axis: [0, 1, 0], ground: floor, axle: level}}
      rim_2: {{type: rigid_wheel, node: other, radius: 0.3, axis: [0, 1, 0], ground: floor, axle: level}}
    grounds:
      floor:
        plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}
        profile: {{direction: [1, 0, 0], height: {{bump: {{start: 1.0, length: 4.0, height: 0.02}}}}}}
    initial:
      velocities: [{{nodes: all, velocity: [{speed!r}, 0, 0], angular_velocity: [0, {spin!r}, 0], about: own}}]
    time: {{end: {end!r}, step: {step!r}}}
"""


@pytest.mark.parametrize(
    ("speed", "step", "apart"),
    [
        (20.0, 0.025, 0.0),  # a step ends on the bend, and its first 1e-7 covers more than the event lies behind
        (2.0, 0.01, 1.2e-9),  # the second wheel comes when the step to the event of the first has just ended
        (2.0, 0.01, 1e-8),
        (2.0, 0.01, 0.004),
    ],
)
def test_each_wheel_reports_each_bend_once(speed, step, apart):
    recorded = RecordedRun(deck(BUMP.format(speed=speed, step=step, apart=apart, spin=speed / 0.3, end=2.0 / speed)))
    assert sorted(h.element for h in recorded.event_records) == ["rigid_wheel 'rim_1'", "rigid_wheel 'rim_2'"]
    np.testing.assert_allclose([h.t for h in recorded.event_records], 1.0 / speed, atol=1e-7 + apart / speed)


def test_braking_without_slip():
    """a = T r/(m r^2 + I), and the force of the ground (a3_a4, braking_no_slip)."""
    recorded = RecordedRun(input_deck("braked_wheel"))
    braked = recorded.time > 0.75
    np.testing.assert_allclose(recorded["loads/brake/torque"][braked], 3000.0, rtol=1e-12)
    np.testing.assert_allclose(recorded["elements/wheel/longitudinal_force"][braked], -9274.631856716338, rtol=1e-8)
    v = recorded["nodes/leg/velocity"][braked, 0]
    np.testing.assert_allclose(np.diff(v) / np.diff(recorded.time[braked]), -1.4401602261982, rtol=1e-7)
    assert np.ptp(recorded["energy/balance"]) < 1e-6 * recorded["energy/kinetic"][0]


def test_a_unilateral_wheel_leaves_a_crest_and_lands():
    """A disc at 4 m/s on a bump whose crest is too narrow: it flies a parabola."""
    recorded = RecordedRun(
        deck("""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes:
          centre: {position: [0, 0, 0.3]}
        elements:
          disc: {type: rigid_body, node: centre, mass: 10.0, inertia: [0.25, 0.45, 0.25]}
          rim: {type: rigid_wheel, node: centre, radius: 0.3, axis: [0, 1, 0], ground: floor, unilateral: true}
        grounds:
          floor:
            plane: {point: [0, 0, 0], normal: [0, 0, 1]}
            profile: {direction: [1, 0, 0], height: {bump: {start: 0.5, length: 2.0, height: 0.2}}}
        initial:
          velocities:
            - {nodes: [centre], velocity: [4, 0, 0], angular_velocity: [0, 13.333333333333334, 0]}
        time: {end: 1.0, step: 1.0e-3}
        """)
    )
    names = [event.name for event in recorded.event_records]
    assert names[:3] == ["bend", "lift_off", "touch_down"]
    up, down = (event.t for event in recorded.event_records[1:3])
    flight = (recorded.time > up + 1e-9) & (recorded.time < down - 1e-9)
    v = recorded["nodes/centre/velocity"][flight]
    np.testing.assert_allclose(np.diff(v[:, 2]) / np.diff(recorded.time[flight]), -9.81, rtol=1e-6)
    assert np.ptp(v[:, 0]) < 1e-9 and flight.sum() > 20
    assert not recorded["elements/rim/normal_force"][flight].any()
    on = recorded["elements/rim/normal_force"][~flight]
    assert on.min() > -1e-3
    assert recorded["energy/total"][-1] < recorded["energy/total"][0]  # the shock takes energy


def test_errors_in_rigid_wheels():
    from mecano.elements.wheels.cardona_wheel import CARDONA_WHEEL
    from mecano.elements.wheels.rigid_wheel import RIGID_WHEEL

    flat = {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}, "profile": None}
    wavy = {
        **flat,
        "profile": {"direction": [1, 0, 0], "height": (("bump", {"start": 0, "length": 1, "height": 0.1}),)},
    }
    node, low = [(np.array([0, 0, 0.3]), np.eye(3))], [(np.array([0, 0, -0.3]), np.eye(3))]
    values = {
        "radius": 0.3,
        "axis": [0, 1, 0],
        "ground": flat,
        "axle": "free",
        "unilateral": False,
        "crown_radius": 0.0,
    }
    assert RIGID_WHEEL.check(values, node) == [] == RIGID_WHEEL.check({**values, "ground": wavy}, node)
    assert "below the ground" in RIGID_WHEEL.check(values, low)[0]
    assert "lies flat" in RIGID_WHEEL.check({**values, "axis": [0, 0, 1]}, node)[0]
    assert "'axle'" in RIGID_WHEEL.check({**values, "axle": "level", "unilateral": True}, node)[0]
    assert "plane only" in CARDONA_WHEEL.check({**values, "ground": wavy}, node)[0]


def test_a_level_axle_needs_a_moment():
    """A towed wheel whose mass hangs at the side: without ``axle: level`` it would fall."""
    recorded = RecordedRun(
        deck("""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes:
          centre: {position: [0, 0, 0.3]}
        elements:
          disc: {type: rigid_body, node: centre, mass: 10.0, inertia: [0.25, 0.45, 0.25]}
          rim: {type: rigid_wheel, node: centre, radius: 0.3, axis: [0, 1, 0], ground: floor, axle: level}
        grounds:
          floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
        initial:
          velocities: [{nodes: [centre], velocity: [1, 0, 0], angular_velocity: [0, 3.3333333333333335, 0.5]}]
        time: {end: 2.0, step: 2.0e-3}
        """)
    )
    # turns at 0.5 rad/s on a circle of 2 m, upright
    x = recorded["nodes/centre/position"]
    np.testing.assert_allclose(np.hypot(x[:, 0], x[:, 1] - 2.0), 2.0, rtol=1e-5)
    np.testing.assert_allclose(x[:, 2], 0.3, rtol=1e-12)
    np.testing.assert_allclose(recorded["elements/rim/lateral_force"], 10.0 * 1.0 * 0.5, rtol=3e-5)


@pytest.mark.parametrize("trail", [0.08, -0.08])
def test_a_light_caster_follows_its_cart_or_turns_over(trail, verify):
    """Without stiffness, and with next to no inertia: e psi' = -V psi; a caster that is pushed turns to the rear."""
    text = f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes:
          cart: {{position: [0, 0, 0.5]}}
          fork: {{position: [0, 0, 0.5]}}
          axle: {{position: [{-trail}, 0, 0.1]}}
          hub: {{position: [{-trail}, 0, 0.1]}}
        elements:
          cart: {{type: rigid_body, node: cart, mass: 50, inertia: [10, 10, 10]}}
          fork: {{type: rigid_body, node: fork, mass: 1.0e-3, inertia: [1.0e-6, 1.0e-6, 1.0e-6], attached: [axle]}}
          rim: {{type: rigid_body, node: hub, mass: 1.0e-3, inertia: [1.0e-6, 1.0e-6, 1.0e-6]}}
          wheel: {{type: rigid_wheel, node: hub, axis: [0, 1, 0], radius: 0.1, ground: floor}}
        joints:
          rail:
            {{type: generic, nodes: [ground, cart], axis: [0, 0, 1], axis_1: [1, 0, 0], free: [along_1, along_axis]}}
          swivel: {{type: hinge, nodes: [cart, fork], axis: [0, 0, 1]}}
          bearing: {{type: hinge, nodes: [axle, hub], axis: [0, 1, 0]}}
        grounds: {{floor: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
        initial: {{steady: {{velocity: [1.5, 0, 0]}}}}
        time: {{end: 1, step: 1 ms}}
    """
    found = modes(deck(text), None)[1].values
    assert np.sum(found == 0.0) == 2
    swings = found[found != 0.0]
    verify("Rolling", f"caster, trail {trail} m: eigenvalue [1/s]", swings, -1.5 / trail, "V/e", relative=1e-9)

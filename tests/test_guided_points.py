"""Points on curves and along beams: decks of inputs/ and others against closed forms, and refused input."""

import numpy as np
import pytest
from convergence import at_times, check_second_order
from equilibria import Equilibrium, Path
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.dynamic import run
from mecano.elements import KINDS
from mecano.elements.joints.guiding_curve import nearest
from mecano.errors import ConvergenceError

G = 9.81


def test_cam_lifts_its_follower():
    """Position, pressure angle and place on the cam are geometry; m (g + z'') gives the force, to (omega h)^2."""
    recorded = RecordedRun(input_deck("cam"))
    theta, e, rho = 15.0 * recorded.time, 0.02, 0.05
    sine, cosine = e * np.sin(theta), e * np.cos(theta)
    root = np.sqrt(rho**2 - sine**2)
    np.testing.assert_allclose(recorded["nodes/roller/position"][:, 2], cosine + root, rtol=0, atol=1e-12)
    np.testing.assert_allclose(recorded["joints/profile/position"], -rho * (theta + np.arcsin(sine / rho)), atol=1e-11)
    np.testing.assert_allclose(recorded["joints/profile/pressure_angle"], np.arcsin(abs(sine) / rho), rtol=0, atol=1e-8)
    by_angle = -sine - sine * cosine / root
    second = -cosine - (cosine**2 - sine**2) / root - (sine * cosine) ** 2 / root**3
    lifting = 0.5 * (G + 15.0**2 * second)
    np.testing.assert_allclose(recorded["joints/profile/normal_force"], lifting * rho / root, rtol=0, atol=1e-3)
    np.testing.assert_allclose(recorded["joints/motor/moment"], by_angle * lifting, rtol=0, atol=2e-5)
    assert recorded.prepared.analysis.redundant == ()


BEAD = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {bead: {position: START}}
    elements: {bead: {type: point_mass, node: bead, mass: 2.0}}
    joints: {wire: {type: point_on_curve, nodes: [ground, bead], CURVE}}
    time: {end: END, step: STEP}
"""


def bead(start, curve, end, step):
    """The deck of a bead on a wire."""
    text = BEAD.replace("START", str(list(map(float, start)))).replace("CURVE", curve)
    return deck(text.replace("END", str(end)).replace("STEP", str(step)))


def test_bead_on_a_helix():
    """Constant acceleration g h/sqrt(r^2 + h^2) along it, h the descent per radian; across it what is left of g."""
    r, h, times, pair = 0.5, 0.3, np.arange(1, 11) / 5, []
    helix = f"center: [1, 0, 0], semi_axis_1: [{r}, 0, 0], semi_axis_2: [0, {r}, 0], advance: [0, 0, {-2 * np.pi * h}]"
    length = np.hypot(r, h)
    along = G * h / length
    for step in (4e-3, 2e-3):
        recorded = RecordedRun(bead([1.0 + r, 0.0, 0.0], helix, 2.0, step))
        pair.append(at_times(recorded, recorded["joints/wire/position"], times))
    check_second_order(*pair, 0.5 * along * times**2, 1e-4)
    expected = 2.0 * np.hypot(G * r / length, r / length**2 * (along * recorded.time) ** 2)
    np.testing.assert_allclose(recorded["joints/wire/normal_force"], expected, rtol=1e-3)


@pytest.mark.parametrize("amplitude", [0.9, 1.8])
def test_cycloid_is_a_tautochrone(amplitude):
    """From every place at rest a bead is at the bottom after pi sqrt(a/g): a quarter of T = 4 pi sqrt(a/g)."""
    a = 0.5

    def place(u):
        return np.array([a * (u + np.sin(u)), 0.0 * u, a * (1.0 - np.cos(u))]).T

    points = place(np.linspace(-2.4, 2.4, 41)).round(12).tolist()
    recorded = RecordedRun(bead(place(amplitude), f"points: {points}", 1.0, 2e-3))
    x = recorded["nodes/bead/position"][:, 0]
    passing = np.interp(0.0, -x, recorded.time)
    assert passing == pytest.approx(np.pi * np.sqrt(a / G), rel=2e-5)  # the spline is 1e-5 off the curvature
    energy = 2.0 * G * recorded["nodes/bead/position"][:, 2] + np.sum(recorded["nodes/bead/velocity"] ** 2, axis=1)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-5)


def test_closed_spline_is_no_drift_over_turns():
    """Eight points on a circle: the spline stays within 0.2 % of it, the speed is kept, over any number of turns."""
    angle = np.arange(8) * np.pi / 4
    points = np.array([np.cos(angle), np.sin(angle), 0 * angle]).T.tolist()
    ring = bead(points[0], f"points: {points}, closed: true", 3.0, 2.5e-3)
    ring.values["initial"]["velocities"].append(
        {"nodes": ["bead"], "velocity": [0.0, 8.0, 0.0], "angular_velocity": [0.0, 0.0, 0.0], "about": None}
    )
    ring.values["gravity"] = [0.0, 0.0, 0.0]
    recorded = RecordedRun(ring)
    radius = np.linalg.norm(recorded["nodes/bead/position"], axis=1)
    assert np.abs(radius - 1.0).max() < 2e-3
    assert recorded["joints/wire/position"][-1] > 3.5 * 2 * np.pi
    np.testing.assert_allclose(recorded["joints/wire/speed"], 8.0, rtol=2e-4)  # (v h)^2/r^2 is 4e-4


def test_run_ends_at_the_end_of_the_curve(tmp_path):
    path = tmp_path / "out.h5"
    with pytest.raises(ConvergenceError, match="point_on_curve 'wire' has reached the end of its curve"):
        run(bead([0.0, 0.0, 1.0], "points: [[0, 0, 1], [1, 0, 0.5]]", 1.0, 0.01), path)
    assert path.exists()


CIRCLE = {"points": None, "closed": False, "across": "held", "advance": None}
CIRCLE |= {"center": [0, 0, 0], "semi_axis_1": [1, 0, 0], "semi_axis_2": [0, 1, 0]}
SPLINE = dict.fromkeys(CIRCLE) | {"points": [[0, 0, 0], [1, 0, 0], [1, 1, 1]], "closed": False, "across": "held"}
REFUSED = [
    (CIRCLE | {"center": None}, "missing 'center'; or give 'points'"),
    (CIRCLE | {"semi_axis_2": [2, 0, 0]}, "'semi_axis_2' must not be parallel"),
    (CIRCLE | {"closed": True}, "'closed' applies to 'points' only"),
    (CIRCLE | {"advance": [0, 0, 1], "across": "free"}, "'across' cannot be free"),
    (SPLINE | {"center": [0, 0, 0]}, "'center' and 'points' exclude one another"),
    (SPLINE | {"points": [[0, 0, 0]]}, "'points' must contain at least 2 points"),
    (SPLINE | {"points": [[0, 0, 0], [0, 0, 0]]}, "consecutive 'points' must not coincide"),
    (
        SPLINE | {"points": [[0, 0, 0], [1, 0, 0], [2, 0, 0]], "across": "free"},
        "for a pin in a straight slot use a generic joint",
    ),
]


@pytest.mark.parametrize("values, text", REFUSED)
def test_what_is_no_curve_is_refused(values, text):
    (found,) = KINDS["point_on_curve"].check(values, None)
    assert text in found


@pytest.mark.parametrize("radius", [1e-3, 0.4, 1.0, 7.0, 1e4])
@pytest.mark.parametrize("angle", [-3.1, 0.0, 2.0])
def test_nearest_point_of_a_circle_is_below_any_point(radius, angle):
    """Inside, on and far outside: s is the angle, times a radius of 1 m."""
    x = np.array([radius * np.cos(angle), radius * np.sin(angle), 0.3])
    assert nearest(CIRCLE, x) == pytest.approx(angle, abs=1e-12)


def test_nearest_point_of_an_open_curve_is_not_beyond_its_ends():
    """Of a straight line of 2 m: the foot of the perpendicular, from beyond its ends these."""
    line = SPLINE | {"points": [[0, 0, 0], [1, 0, 0], [2, 0, 0]]}
    found = [nearest(line, np.array([x, 5.0, 0.0])) for x in (-3.0, -1e-3, 0.0, 0.7, 2.0, 30.0)]
    np.testing.assert_allclose(found, [0.0, 0.0, 0.0, 0.7, 2.0, 2.0], rtol=0, atol=1e-14)


def test_nearest_point_of_a_closed_curve_may_be_on_both_sides_of_its_first_point():
    """A rounded square, below x = -0.1 and 0.1 from its lowest point, which is the first one of 4 sqrt(2) m."""
    ring = SPLINE | {"points": [[0, -1, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0]], "closed": True}
    before, after = (nearest(ring, np.array([x, -3.0, 0.0])) for x in (-0.1, 0.1))
    assert before == pytest.approx(4.0 * np.sqrt(2.0) - after, rel=1e-12) and 0.01 < after < 0.1


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e4])
def test_end_of_a_curve_is_located_to_a_share_of_its_length(size):
    points = [[0, 0, 0], [0.6 * size, 0, 0], [0.6 * size, 0.4 * size, 0]]
    ((output, limit, _),) = KINDS["point_on_curve"].end_conditions(SPLINE | {"points": points})
    assert (output, limit) == ("overrun", pytest.approx(1e-9 * size))
    assert KINDS["point_on_curve"].end_conditions(SPLINE | {"points": points, "closed": True}) == []
    assert KINDS["point_on_curve"].end_conditions(CIRCLE) == []


SPAN, SPEED, FORCE, MASS = 20.0, 20.0, 1e4, 785.0  # m, m/s, N, kg/m: the bridge of inputs/moving_load.yaml
STIFFNESS = 2.1e11 * 0.5 * 0.2**3 / 12.0  # N m2
NUMBERS = np.arange(1, 13) * np.pi / SPAN
FREQUENCIES = NUMBERS**2 * np.sqrt(STIFFNESS / MASS)


def under_a_force(x, t):
    """Deflection [m] of the bridge at x by Fryba's series, with that of Euler's beam."""
    passing = NUMBERS * SPEED
    swing = np.sin(np.multiply.outer(t, passing))
    swing -= passing / FREQUENCIES * np.sin(np.multiply.outer(t, FREQUENCIES))
    modes = np.sin(np.multiply.outer(x, NUMBERS))
    return 2.0 * FORCE / (MASS * SPAN) * np.sum(modes * swing / (FREQUENCIES**2 - passing**2), axis=-1)


def under_a_mass(mass, times):
    """Deflection [m] of the middle under a mass that the force presses down, by modes of Euler's beam.

    The mass pushes with F - m w'' with the second rate of w along its way, w_tt + 2 v w_xt + v^2 w_xx.
    """
    n, share = len(NUMBERS), 2.0 / (MASS * SPAN)

    def rates(t, y):
        q, q_rate, at = y[:n], y[n:], NUMBERS * SPEED * t
        shape, slope, bend = np.sin(at), NUMBERS * np.cos(at), -(NUMBERS**2) * np.sin(at)
        push = FORCE - mass * (2.0 * SPEED * slope @ q_rate + SPEED**2 * bend @ q)
        heavy = np.eye(n) + share * mass * np.outer(shape, shape)
        return np.concatenate([q_rate, np.linalg.solve(heavy, share * shape * push - FREQUENCIES**2 * q)])

    found = solve_ivp(rates, (0.0, times[-1]), np.zeros(2 * n), t_eval=times, rtol=1e-7, atol=1e-10)
    return np.sin(NUMBERS * SPAN / 2.0) @ found.y[:n]


def test_force_runs_over_a_bridge():
    """Fryba's series to 0.1 % of the largest deflection, in the middle and under the force, past seven nodes."""
    recorded = RecordedRun(input_deck("moving_load"))
    t, middle = recorded.time, -recorded["nodes/girder.4/position"][:, 2]
    expected = under_a_force(SPAN / 2.0, t)
    largest = expected.max()
    assert (largest, t[expected.argmax()]) == pytest.approx((0.0392, 0.595), rel=2e-3)
    np.testing.assert_allclose(middle, expected, rtol=0, atol=1e-3 * largest)
    under = -recorded["nodes/load/position"][:, 2]
    np.testing.assert_allclose(under, under_a_force(SPEED * t, t), rtol=0, atol=1e-3 * largest)
    passed = [h.t for h in recorded.event_records if h.name == "passes"]
    np.testing.assert_allclose(passed, np.arange(1, 8) / 8.0, rtol=0, atol=1e-5)
    assert np.ptp(recorded["energy/balance"]) < 1e-4 * recorded["energy/given"][-1]


def test_force_runs_to_and_fro():
    """x = 10 + 6 sin(2 pi t) m from a node of the bridge, past nodes every 2.5 m, in both directions."""
    swinging = "joints.running.value={sine: {amplitude: 6.0, frequency: 1.0}}"
    recorded = RecordedRun(input_deck("moving_load", "nodes.load.position=[10, 0, 0]", swinging, "time.end=0.95"))
    quarter = np.arcsin(np.array([2.5, 5.0]) / 6.0) / (2.0 * np.pi)
    expected = [*quarter, *(0.5 - quarter[::-1]), 0.5, *(0.5 + quarter), *(1.0 - quarter[::-1])]
    np.testing.assert_allclose([h.t for h in recorded.event_records if h.t > 1e-3], expected, rtol=0, atol=1e-5)
    assert np.ptp(recorded["energy/balance"]) < 3e-4 * np.ptp(recorded["energy/given"])


def test_mass_runs_over_a_bridge():
    """30 % of the mass of the bridge raise the largest deflection by 8 %; independent modes agree to 0.2 %."""
    recorded, mass = RecordedRun(input_deck("moving_load", "elements.trolley.mass=4710")), 4710.0
    times = np.linspace(0.05, 0.95, 37)
    expected = under_a_mass(mass, times)
    middle = np.interp(times, recorded.time, -recorded["nodes/girder.4/position"][:, 2])
    np.testing.assert_allclose(middle, expected, rtol=0, atol=2e-3 * expected.max())
    assert expected.max() > 1.05 * under_a_force(SPAN / 2.0, times).max()


def at_rest(place):
    """Return the deflection [m] under 100 N: F a^2 b^2/(3 EI L) + F a b/(k G A L), less the bending within an element.

    That is F c^3 d^3/(3 EI h^3) for a force at c and d = h - c from its ends, as in a beam held at both ends.
    """
    c, h, shearing = place % (SPAN / 8.0), SPAN / 8.0, 5.0 / 6.0 * 2.1e11 / 2.6 * 0.5 * 0.2
    bent = (place * (SPAN - place)) ** 2 / (3.0 * STIFFNESS * SPAN) - (c * (h - c) / h) ** 3 / (3.0 * STIFFNESS)
    return 100.0 * (bent + place * (SPAN - place) / (shearing * SPAN))


@pytest.mark.parametrize("place", [2.5, 7.3, 16.1])
def test_slider_at_rest_bends_its_beam(place):
    text = input_deck("moving_load").text.replace("{linear: {slope: 20.0}}", "0").replace("value: 10000", "value: 100")
    text = text.replace("load: {position: [0, 0, 0]}", f"load: {{position: [{place}, 0, 0]}}")
    still = Equilibrium(text.replace("time: {end: 0.98, step: 2.0e-3}\noutput: {every: 0.01}", "static: {}"))
    assert -still.position("load")[2] == pytest.approx(
        at_rest(place), rel=1.5e-4
    )  # of shear, 5e-4, it knows that at nodes
    np.testing.assert_allclose(still.output("joints/rail/force"), [0.0, 0.0, 100.0], rtol=0, atol=1e-2)


def test_a_slider_at_rest_is_moved_to_other_elements():
    text = input_deck("moving_load").text.replace("value: 10000", "value: 100")
    static = "static: {over: time, end: 0.95, steps: 5}"  # past no node, one or two of them in a step
    path = Path(text.replace("time: {end: 0.98, step: 2.0e-3}\noutput: {every: 0.01}", static))
    along, _, down = -path.positions("load").T * [[-1.0], [1.0], [1.0]]
    np.testing.assert_allclose(along, np.linspace(0.0, 19.0, 6), atol=1e-9)
    np.testing.assert_allclose(down, at_rest(along), rtol=0, atol=1e-4 * 2.3e-4)  # of shear, it knows that at nodes


def test_a_slider_falls_to_the_middle_of_a_tightrope(verify):
    """F L/(4 H) (1 - tanh(u)/u), u = (L/4) sqrt(H/EI), under a small force in the middle of a clamped line."""
    span, H, EI, F = 10.0, 3000.0, 300.0, 10.0
    rope = Equilibrium(f"""
        mecano: 1
        gravity: none
        sections:
          s: {{type: stiffness, EA: 1.0e6, GA2: 1.0e9, GA3: 1.0e9, GJ: 1, EI2: {EI}, EI3: {EI}, mass_per_length: 0,
              rotary_inertia: [0, 0, 0]}}
        nodes:
          a: {{position: [0, 0, 0], fixed: true}}
          b: {{position: [{span}, 0, 0], fixed: true}}
          walker: {{position: [4.2, 0, 0]}}
        elements: {{rope: {{type: beam, nodes: [a, b], section: s, mesh: 20, up: [0, 0, 1],
          thermal: {{strain: -3.0e-3}}}}}}
        joints: {{feet: {{type: slider_on_beam, node: walker, line: rope}}}}
        loads: {{weight: {{type: force, node: walker, direction: [0, 0, -1], value: {F}}}}}
        static: {{method: relaxation}}
    """)
    u = span / 4.0 * np.sqrt(H / EI)
    place, _, height = rope.position("walker")
    assert place == pytest.approx(span / 2.0, abs=0.02)  # in the equilibrium of the elements; the curvature jumps there
    known = -F * span / (4.0 * H) * (1.0 - np.tanh(u) / u)
    what = "walker on a tightrope of 20 beams, who starts 0.8 m beside its middle: height [m]"
    verify("Beams at rest", what, height, known, "closed form", relative=2e-3)


RAMP = """
    mecano: 1
    gravity: [0, 0, -9.81]
    sections: {rod: {type: circle, diameter: 0.012, E: 7.0e10, nu: 0.3, density: 2700}}
    nodes:
      top: {position: [0, 0, 0], fixed: true}
      tip: {position: [1.6, 0, -1.2]}
      ring: {position: [0.05, 0, -0.0375]}
    elements:
      ramp: {type: beam, nodes: [top, tip], section: rod, mesh: 4}
      ring: {type: point_mass, node: ring, mass: 1.0}
    joints: {sliding: {type: slider_on_beam, node: ring, line: [top, ramp.1, ramp.2, ramp.3, tip]}}
    time: {end: 0.75, step: STEP}
"""


def over_an_edge(unknowns, load):
    """Return the misfits (4,) at the edge and the tip, and the tip (2,), of a beam with EI = 1 clamped at the origin.

    ``unknowns``: force and moment of the clamp, and the length of the beam up to the edge at x = 0.5; the other end of
    1 m bears the ``load`` downwards. With the force N of a section, M' = N_x sin(theta) - N_y cos(theta).
    """
    *force, moment, at = unknowns

    def along(start, N, s, end):
        def rate(s, y):
            cosine, sine = np.cos(y[0]), np.sin(y[0])
            return [y[1], N[0] * sine - N[1] * cosine, cosine, sine]

        return solve_ivp(rate, (s, end), start, rtol=1e-10, atol=1e-11).y[:, -1]

    edge = along([0, moment, 0, 0], force, 0.0, at)
    tip = along(edge, [0, -load], at, 1.0)
    reaction = force[0] * np.cos(edge[0]) + (force[1] + load) * np.sin(edge[0])  # of the edge, along the beam
    return [edge[2] - 0.5, edge[3], reaction, tip[1]], tip[2:]


def test_a_beam_that_slides_over_an_edge(verify):
    """An edge is a slider on a fixed node; the beam is inclined by 19 degrees there and drawn over it by 4 mm."""
    found = Equilibrium("""
        mecano: 1
        gravity: none
        sections:
          s: {type: stiffness, EA: 1.0e7, GA2: 1.0e7, GA3: 1.0e7, GJ: 1, EI2: 1, EI3: 1, mass_per_length: 1,
              rotary_inertia: [1, 1, 1]}
        nodes: {clamp: {position: [0, 0, 0], fixed: true}, tip: {position: [1, 0, 0]},
                edge: {position: [0.5, 0, 0], fixed: true}}
        elements: {beam: {type: beam, nodes: [clamp, tip], section: s, up: [0, 0, 1], mesh: 16}}
        joints: {edge: {type: slider_on_beam, node: edge, line: beam}}
        loads: {load: {type: force, node: tip, direction: [0, -1, 0], value: 8}}
        static: {steps: 4}
    """)
    exact = fsolve(lambda unknowns: over_an_edge(unknowns, 8.0)[0], [6.0, 8.0, 1.0, 0.5], xtol=1e-10)
    tip = over_an_edge(exact, 8.0)[1]
    source = "elastica, by shooting"
    verify("Beams at rest", "beam over an edge: tip [m]", found.position("tip")[:2], tip, source, relative=1e-5)
    what = "beam over an edge: length up to it, force of the edge"
    own = [*found.output("joints/edge/position"), *found.output("joints/edge/normal_force")]
    verify("Beams at rest", what, own, [exact[3], np.hypot(exact[0], exact[1] + 8.0)], source, relative=1e-4)


def test_ring_slides_down_a_rod_that_swings():
    """No friction: the energy is kept, to the second order, past three nodes, while the tip comes down by 0.17 m."""
    kept = []
    for step in (2e-3, 1e-3):
        recorded = RecordedRun(deck(RAMP.replace("STEP", str(step))))
        balance = recorded["energy/balance"]
        kept.append(np.abs(balance - balance[0]).max())
    assert sum(h.name == "passes" for h in recorded.event_records) == 3
    assert recorded["nodes/tip/position"][:, 2].min() < -1.36
    assert kept[1] < kept[0] / 3.0 and kept[1] < 1e-5, kept


def test_slider_needs_a_line():
    check = KINDS["slider_on_beam"].check
    frame = (np.zeros(3), np.eye(3))
    assert check({"line": ["a"]}, [frame, frame]) == ["'line' must name at least 2 nodes"]
    assert "consecutive nodes of 'line' must not coincide" in check({"line": ["a", "b"]}, [frame, frame, frame])[0]

"""Wheels on drums and on decks that move: geometry of the contact, exchange of momentum, motions against references."""

import math
import shutil
import textwrap
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar
from time_runs import INPUTS, RecordedRun, deck, input_deck

from mecano.constraints.carried_surface import touch_carried
from mecano.deck.read import read_deck
from mecano.errors import DeckError
from mecano.maths.vector import Vec3

DRUM = (INPUTS / "tyre_drum.yaml").read_text()

BRAKE = """
loads:
  stop: {type: brake, nodes: [carriage, hub], axis: [0, 1, 0], torque: 9, wheel: tyre, adhesion: 0.5}
"""


def test_a_drum_spins_a_wheel_up(verify):
    """inputs/tyre_drum.yaml: the angular momenta about both axles change by the same friction; the rest is heat."""
    recorded = RecordedRun(input_deck("tyre_drum"))
    R, J, inertia, W, N = 1.5, 200.0, 2.0, 20.0, 600.0 * 9.81
    r = 0.36 - N / 4e5
    share = R**2 / J + r**2 / inertia
    sliding = R * W / (0.6 * N * share)
    drum = W - 0.6 * N * R * sliding / J
    source = "angular momentum about both axles"
    found = -recorded["nodes/drum/angular_velocity"][-1, 1]
    verify("Tyres", "a tyre on a drum: rate of the drum after the spin-up [rad/s]", found, drum, source, relative=1e-7)
    assert recorded["elements/tyre/spin_rate"].ravel()[-1] == pytest.approx(drum * R / r, rel=1e-7)
    lost = recorded["energy/dissipated"][-1]
    verify("Tyres", "a tyre on a drum: energy lost in sliding [J]", lost, 0.5 * (R * W) ** 2 / share, source,
           relative=1e-5)  # fmt: skip
    assert abs(recorded["energy/given"][-1]) < 1e-9 * lost
    assert np.ptp(recorded["energy/balance"]) < 1e-6 * lost
    early = recorded.time < 0.9 * sliding
    rate = 0.6 * N * r / inertia * recorded.time[early]
    np.testing.assert_allclose(recorded["elements/tyre/spin_rate"].ravel()[early], rate, rtol=1e-6, atol=1e-9)


ROLLING = (
    "tire_laws.rubber.rolling_radius_coefficient=0.25",
    "tire_laws.rubber.rolling_resistance={coefficient: 0.02}",
    "time.end=0.4",
)


def test_a_wheel_rolls_on_a_drum_at_its_rolling_radius(verify):
    """The belt runs as fast as the drum, r_e w = R W; the resistance f N brakes the drum and the wheel geared to it."""
    recorded = RecordedRun(input_deck("tyre_drum", *ROLLING))
    R, N = 1.5, 600.0 * 9.81
    ratio = R / (0.36 - 0.25 * N / 4e5)
    rolls = recorded.time > 0.25
    drum, wheel = -recorded["nodes/drum/angular_velocity"][rolls, 1], recorded["elements/tyre/spin_rate"].ravel()[rolls]
    creep = 0.05 * 0.5 * 0.02 / 0.6  # [m/s] of the rim, where the regularized friction is 0.02 N; it needs less
    verify("Tyres", "a tyre on a drum: rate at its rolling radius over that of the drum", wheel / drum, ratio,
           "the belt does not slip", relative=creep / (R * drum.min()))  # fmt: skip
    braked = np.polyfit(recorded.time[rolls], drum, 1)[0]
    exact = -0.02 * N * R / (200.0 + 2.0 * ratio**2)
    verify("Tyres", "a tyre on a drum: deceleration by rolling resistance [rad/s2]", braked, exact,
           "energy of drum and wheel", relative=1e-6)  # fmt: skip
    assert np.ptp(recorded["energy/balance"]) < 1e-6 * recorded["energy/dissipated"][-1]


def _ship(t):
    """Heave [m] and pitch [rad] of inputs/ship_deck.yaml with their rates."""
    a, b, low, high = 0.8, math.radians(4.0), 2 * math.pi * 0.12, 2 * math.pi * 0.1
    return a * math.sin(low * t), a * low * math.cos(low * t), b * math.sin(high * t), b * high * math.cos(high * t)


def _forces(t, state):
    """Depth [m], normal force and friction [N], normal n and direction t (x, z) of the wheel on the ship's deck."""
    x, z, vx, vz, spin = state
    heave, heave1, theta, theta1 = _ship(t)
    n, ahead = np.array([math.sin(theta), math.cos(theta)]), np.array([math.cos(theta), -math.sin(theta)])
    X = np.array([x, z - heave])
    h = n @ X - 3.0
    C = X - h * n
    deck_v = np.array([theta1 * C[1], heave1 - theta1 * C[0]])
    rim_v = np.array([vx - spin * h * n[1], vz + spin * h * n[0]])
    w, w1, slip = 0.36 - h, -n @ (rim_v - deck_v), ahead @ (rim_v - deck_v)
    N = 4e5 * w * (1.0 + 0.5 * w1)
    s = min(abs(slip) / 0.1, 1.0)
    return h, N, -0.6 * N * s * (2.0 - s) * math.copysign(1.0, slip), n, ahead


def _ship_wheel(t, state):
    h, N, F, n, ahead = _forces(t, state)
    ax, az = (N * n + F * ahead) / 500.0
    return [state[2], state[3], ax, az - 9.81, -h * F / 20.0]


def test_a_wheel_on_a_heaving_and_pitching_deck_moves_as_integrated_independently(verify):
    """inputs/ship_deck.yaml: the plane equations of motion, written by hand, with the same laws."""
    recorded = RecordedRun(input_deck("ship_deck", "time.adaptive.tolerance=1.0e-4"))
    start = [0.0, 3.3477375, 0.0, 2 * math.pi * 0.096, 0.0]
    exact = solve_ivp(_ship_wheel, (0.0, 6.0), start, "LSODA", rtol=1e-8, atol=1e-9, t_eval=recorded.time).y
    x, source = recorded["nodes/hub/position"], "independent integration of the plane motion"
    rolled = exact[0]
    verify("Tyres", "a wheel rolls on the deck of a ship: distance over the largest one [-]",
           x[:, 0] / np.abs(rolled).max(), rolled / np.abs(rolled).max(), source, absolute=1e-4)  # fmt: skip
    assert np.abs(rolled).max() > 5.0
    np.testing.assert_allclose(x[:, 2], exact[1], atol=1e-4)
    N = [_forces(t, state)[1] for t, state in zip(recorded.time, exact.T, strict=True)]
    np.testing.assert_allclose(recorded["elements/wheel/normal_force"].ravel(), N, atol=2e-3 * 4905.0)


@pytest.mark.parametrize(("side", "radius"), [(1.0, 2.0), (-1.0, 2.0)])
def test_the_contact_is_the_point_of_the_disc_nearest_to_the_drum(side, radius):
    """In the plane of a leaning, turned wheel, along the direction to the contact, the drum is nearest to the centre.

    The distance from the centre to the drum in the plane of the wheel is found by a search over all directions there.
    """
    rng = np.random.default_rng(3)
    for _ in range(20):
        main, away = rng.normal(size=3), rng.normal(size=3)
        main /= np.linalg.norm(main)
        away -= (away @ main) * main
        away /= np.linalg.norm(away)
        x = (radius + side * 0.5) * away + rng.normal() * main
        axis = np.cross(away, rng.normal(size=3))
        axis = axis / np.linalg.norm(axis) + 0.4 * rng.uniform(-1, 1) * away
        axis /= np.linalg.norm(axis)
        p = SimpleNamespace(cylindrical=1.0, drum_radius=radius, drum_side=side, crown=0.0)
        g = touch_carried(p, *(Vec3(*v) for v in (x, axis, np.zeros(3), main)))
        C = x + np.array(g.arm)
        assert np.linalg.norm(C - (C @ main) * main) == pytest.approx(radius, rel=1e-12)
        assert abs(axis @ np.array(g.c)) < 1e-12
        e1, e2 = np.array(g.c), np.cross(axis, g.c)

        def reach(angle, e1=e1, e2=e2, x=x, main=main):
            d = math.cos(angle) * e1 + math.sin(angle) * e2
            d, X = d - (d @ main) * main, x - (x @ main) * main  # |X + s d| = radius
            a, b, c = d @ d, d @ X, X @ X - radius**2
            root = b * b - a * c
            return (-b - side * math.sqrt(root)) / a if root > 0.0 else 10.0

        nearest = minimize_scalar(reach, bounds=(-0.8, 0.8), method="bounded", options={"xatol": 1e-9})
        assert nearest.fun == pytest.approx(g.r, rel=1e-9)
        assert abs(nearest.x) < 1e-6


ROCKING = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {hub: {position: [0.05, 0, 0.35125156445]}}
    elements:
      rim: {type: rigid_body, node: hub, mass: 10, inertia: [0.2, 0.4, 0.2]}
      tyre:
        type: wheel_on_body
        nodes: [ground, hub]
        axis: [0, 1, 0]
        tire_law: hard
        cylinder: {axis: [0, 1, 0], radius: 1.35, center: [0, 0, 1.35], inside: true}
    joints:
      upright: {type: planar, nodes: [ground, hub], axis: [0, 1, 0]}
    tire_laws:
      hard: {radius: 0.35, radial: {linear: {slope: 1.0e8}}, friction: 0.9, slip_regularization: 1.0e-3}
    time: {end: 12, step: 5.0e-3}
"""


def test_a_wheel_rocks_inside_a_drum(verify):
    """Small oscillation of a wheel that rolls in a drum at rest: w^2 = g/((R - r)(1 + I/(m r^2)))."""
    recorded = RecordedRun(deck(ROCKING))
    x, t = recorded["nodes/hub/position"][:, 0], recorded.time
    crossings = np.flatnonzero(x[:-1] * x[1:] < 0.0)
    times = t[crossings] - x[crossings] * (t[crossings + 1] - t[crossings]) / (x[crossings + 1] - x[crossings])
    period = 2.0 * np.diff(times).mean()
    exact = 2.0 * math.pi * math.sqrt(1.0 / 9.81 * (1.0 + 0.4 / (10.0 * 0.35**2)))
    exact *= 1.0 + 0.05**2 / 16.0  # of the amplitude
    verify("Tyres", "a wheel rocks inside a drum: period [s]", period, exact,
           "w^2 = g/((R - r)(1 + I/(m r^2)))", relative=1e-3)  # fmt: skip


def test_a_plane_fixed_to_the_ground_is_a_ground():
    """A leaning, turning wheel with Fiala's tyre: the kinds wheel and wheel_on_body have the same motion."""
    text = """
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {{hub: {{position: [0, 0, 0.3]}}}}
        elements:
          rim: {{type: rigid_body, node: hub, mass: 20, inertia: [0.6, 1.1, 0.6]}}
          tyre: {{{wheel}, axis: [0.1, 1, 0.2], tire_law: rubber}}
        grounds: {{road: {{plane: {{point: [0, 0, 0], normal: [0.1, 0, 1]}}}}}}
        tire_laws:
          rubber:
            radius: 0.3
            radial: {{linear: {{slope: 5.0e4}}}}
            fiala: {{cornering_stiffness: 3.0e3, friction: 0.8, contact_length: 0.1}}
        initial:
          velocities: [{{nodes: all, velocity: [6, 0.5, 0], angular_velocity: [0, 20, 1], about: own}}]
        time: {{end: 0.3, step: 1.0e-3}}
    """
    plane = "plane: {normal: [0.1, 0, 1], point: [0, 0, 0]}"
    runs = [RecordedRun(deck(text.format(wheel=wheel))) for wheel in (
        "type: wheel, node: hub, ground: road", f"type: wheel_on_body, nodes: [ground, hub], {plane}")]  # fmt: skip
    for path in ("nodes/hub/position", "elements/tyre/contact_force", "energy/dissipated"):
        np.testing.assert_allclose(runs[1][path], runs[0][path], rtol=1e-7, atol=1e-7)


EITHER = """
    mecano: 1
    gravity: none
    nodes: {{base: {{position: [0, 0, 0]}}, hub: {{position: [0.2, 0.1, 1.29]}}}}
    elements:
      base: {{type: rigid_body, node: base, mass: 9, inertia: [1, 1, 1]}}
      rim: {{type: rigid_body, node: hub, mass: 9, inertia: [1, 1, 1]}}
      tyre: {{type: wheel_on_body, nodes: [base, hub], axis: [0.1, 1, -0.08], tire_law: rubber, {surface}}}
    tire_laws: {{rubber: {{radius: 0.3, radial: {{linear: {{slope: 98.1 kN/m}}}}, {law}}}}}
    initial:
      velocities:
        - {{nodes: [hub], velocity: [0.5, 0.1, 0.02], angular_velocity: [0.7, 7, -0.6]}}
        - {{nodes: [{turns}], angular_velocity: {rate}, about: [0, 0, 0]}}
    time: {{end: 1.0e-6, step: 1.0e-6}}
"""
TOP, DRUM_OF_1_M, PIPE_OF_2_M = (
    "plane: {normal: [0, 0, 1], point: [0, 0, 1]}",
    "cylinder: {axis: [0, 1, 0], radius: 1.0, center: [0.2, 0, 0]}",
    "cylinder: {axis: [0, 1, 0], radius: 2.0, center: [0.2, 0, 3], inside: true}",
)
BRUSH = (
    "fiala: {cornering_stiffness: 3.0e4, friction: 0.9, contact_length: 0.12, contact_width: 0.1, "
    "camber_stiffness: 2 kN/rad}"
)


@pytest.mark.parametrize("law", [BRUSH, "magic_formula: {file: passenger_car.tir}"])
@pytest.mark.parametrize(
    ("surface", "rate"),
    [(TOP, (0, 0, 1.7)), (TOP, (0.3, 1.1, 0.4)), (DRUM_OF_1_M, (0, 1.7, 0)), (PIPE_OF_2_M, (0.2, 1.1, 0))],
)
def test_a_surface_that_turns_is_a_wheel_that_is_carried_round_the_other_way(surface, rate, law, tmp_path):
    """Both are the same motion in axes of the surface: so are forces and moments, with camber, slip and turn slip."""
    shutil.copy(INPUTS / "passenger_car.tir", tmp_path)
    forces = []
    for turns, sign in (("base", 1), ("hub", -1)):
        text = EITHER.format(surface=surface, law=law, turns=turns, rate=[sign * one for one in rate])
        (tmp_path / "deck.yaml").write_text(textwrap.dedent(text))
        recorded = RecordedRun(read_deck(tmp_path / "deck.yaml", ()))
        names = ("longitudinal_force", "lateral_force", "normal_force", "slip_moment", "slip_ratio")
        forces.append(np.concatenate([recorded[f"elements/tyre/{name}"][0].ravel() for name in names]))
    np.testing.assert_allclose(forces[1], forces[0], rtol=1e-10, atol=1e-10 * abs(forces[0]).max())
    assert abs(forces[0][:2]).min() > 5.0  # N: the wheel slips both ways


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (", cylinder: {axis: [0, 1, 0], radius: $drum}", "", "exactly one of 'plane', 'cylinder'"),
        ("nodes: [drum, hub], axis", "nodes: [ground, hub], axis", "'cylinder' needs 'center'"),
        ("radius: $drum}", "radius: 0.3, inside: true}", "'cylinder.radius' must exceed the radius of the wheel"),
        ("radius: $drum}", "radius: $drum, center: [0, 0, 1.5]}", "beyond the surface"),
        ("radius: $drum}", "radius: $drum + 0.2}", "more than half of its radius"),
        ("nodes: [drum, hub], axis: [0, 1, 0]", "nodes: [drum, hub], axis: [0, 0, 1]", "lies flat"),
        ("initial:", f"{BRAKE}\ninitial:", "'wheel' must roll on one of the 'grounds'"),
    ],
)
def test_errors_in_a_wheel_on_a_body(old, new, said):
    assert DRUM.count(old) == 1
    with pytest.raises(DeckError) as error:
        deck(DRUM.replace(old, new))
    assert said in str(error.value)

"""Tyres with a rounded tread: static inclined wheel in closed form, and the limit of the rigid torus."""

from types import SimpleNamespace

import numpy as np
import pytest
from convergence import at_times
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares, minimize, minimize_scalar
from scipy.spatial.transform import Rotation
from test_rigid_wheel import MASS, TORUS_TIMES, E, G, R, contact_of_torus, rates_of_torus
from time_runs import RecordedRun, deck

from mecano.constraints.carried_surface import touch_carried_round
from mecano.errors import DeckError
from mecano.maths.vector import Vec3

STIFFNESS, LEAN = 2.0e3, 0.7  # N/m, rad
DEPTH = MASS * G / STIFFNESS  # of the tread in the ground [m]
HEIGHT = E + (R - E) * np.cos(LEAN) - DEPTH

STANDING = f"""
    mecano: 1
    gravity: [0, 0, -{G}]
    nodes: {{hub: {{position: [0, 0, {float(HEIGHT)!r}]}}}}
    elements:
      rim: {{type: rigid_body, node: hub, mass: {MASS}, inertia: [1, 1, 1]}}
      tyre: {{type: wheel, node: hub, axis: [0, {float(np.cos(LEAN))!r}, {float(np.sin(LEAN))!r}], tire_law: round,
             ground: floor}}
    joints: {{guide: {{type: prismatic, nodes: [ground, hub], axis: [0, 0, 1]}}}}
    tire_laws:
      round: {{radius: {R}, crown_radius: {E}, radial: {{linear: {{slope: {STIFFNESS}}}}}, LAW}}
    grounds: {{floor: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
    time: {{end: 0.01, step: 0.01}}
"""
FRICTION = "friction: 0.8, slip_regularization: 0.1"
FIALA = "fiala: {cornering_stiffness: 2 kN, friction: 1, carcass_stiffness: [1 kN/m, 1 kN/m]}"


def lowest_of_torus():
    """Lowest point of a leaning torus from its centre, sought on the whole surface."""
    a, t = np.array([0.0, np.cos(LEAN), np.sin(LEAN)]), np.array([1.0, 0.0, 0.0])
    down = np.cross(t, a)

    def point(angles):
        out = np.cos(angles[0]) * down + np.sin(angles[0]) * t
        return (R - E) * out + E * (np.cos(angles[1]) * out + np.sin(angles[1]) * a)

    return point(minimize(lambda u: point(u)[2], [2.5, 0.3], tol=1e-14).x)


@pytest.mark.parametrize(("kind", "law"), [("wheel", FRICTION), ("transient_wheel", FIALA)])
def test_static_inclined_wheel(kind, law, verify):
    """On a guide along the normal it bears its weight, which acts at the lowest point of the torus."""
    run = RecordedRun(deck(STANDING.replace("type: wheel", f"type: {kind}").replace("LAW", law)))
    names = "contact_point", "deformation", "height", "normal_force"
    outputs = {name: run[f"elements/tyre/{name}"][-1].squeeze() for name in names}
    lowest = lowest_of_torus()
    np.testing.assert_allclose(outputs["contact_point"], [0.0, lowest[1], 0.0], atol=1e-7)
    assert -lowest[2] - HEIGHT == pytest.approx(DEPTH, abs=1e-12)
    assert outputs["deformation"] == pytest.approx(DEPTH, rel=1e-9)
    assert outputs["height"] == pytest.approx(HEIGHT, rel=1e-12)
    what = f"{kind}, inclined, rounded tread"
    verify("Rolling", f"{what}: normal force [N]", outputs["normal_force"], MASS * G, "weight", relative=1e-9)
    found, expected = np.abs(run["joints/guide/moment"][-1]).max(), MASS * G * (R - E) * np.sin(LEAN)
    verify("Rolling", f"{what}: overturning moment [N m]", found, expected, "closed form", relative=1e-9)


WAVE, AMPLITUDE = 1.3, 0.03  # 1/m, m: of the road
ATTITUDES = [(0.0, 0.0, 0.1), (0.5, 0.3, 0.35), (-0.7, 0.8, 0.6), (0.9, -0.5, 0.9)]  # lean, heading [rad], place [m]


def frame(lean, heading):
    """Axis and driving direction of a wheel, and the direction from its centre to its lowest point on level ground."""
    turn = Rotation.from_euler("ZX", [heading, -lean])
    return turn.apply([0.0, 1.0, 0.0]), turn.apply([1.0, 0.0, 0.0]), turn.apply([0.0, 0.0, -1.0])


def nearest(x, lean, heading):
    """Distance of the middle circle from a wavy road, and the point of the road, by a search over both."""
    _, ahead, down = frame(lean, heading)

    def points(u):
        circle = x + (R - E) * (np.cos(u[0]) * down + np.sin(u[0]) * ahead)
        return circle, np.array([u[1], u[2], AMPLITUDE * np.sin(2.0 * np.pi * WAVE * u[1])])

    start = points([0.0, 0.0, 0.0])[0]
    found = least_squares(lambda u: np.subtract(*points(u)), [0.0, *start[:2]], xtol=1e-15, ftol=1e-15, gtol=1e-15)
    circle, road = points(found.x)
    return np.linalg.norm(circle - road), road


def test_rounded_treads_on_a_wavy_road(verify):
    """Depth and contact of tori in several attitudes are those of the shortest way from the middle circle."""
    nodes, elements, expected = [], [], []
    for i, (lean, heading, place) in enumerate(ATTITUDES):
        x = np.array([place, 0.0, -0.03 + E + (R - E) * np.cos(lean)])
        nodes.append(f"hub_{i}: {{position: {x.tolist()}}}")
        elements.append(f"rim_{i}: {{type: rigid_body, node: hub_{i}, mass: 1, inertia: [1, 1, 1]}}")
        axis = frame(lean, heading)[0].tolist()
        elements.append(f"tyre_{i}: {{type: wheel, node: hub_{i}, axis: {axis}, tire_law: round, ground: road}}")
        expected.append(nearest(x, lean, heading))
    run = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: [0, 0, 0]
        nodes: {{{", ".join(nodes)}}}
        elements: {{{", ".join(elements)}}}
        tire_laws:
          round: {{radius: {R}, crown_radius: {E}, radial: {{linear: {{slope: 1.0}}}}, {FRICTION}}}
        grounds:
          road:
            plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}
            profile: {{direction: [1, 0, 0], height: {{sine: {{amplitude: {AMPLITUDE}, frequency: {WAVE}}}}}}}
        time: {{end: 1.0e-6, step: 1.0e-6}}
    """)
    )
    for i, (distance, road) in enumerate(expected):
        assert 0.05 < distance < E
        what = f"tread of a torus on waves, leaning by {ATTITUDES[i][0]} rad: height over the road [m]"
        verify("Rolling", what, E - run[f"elements/tyre_{i}/deformation"][0], distance, "shortest way", absolute=1e-9)
        np.testing.assert_allclose(run[f"elements/tyre_{i}/contact_point"][0], road, atol=1e-6)


ROLLING = f"""
    mecano: 1
    gravity: [0, 0, -{G}]
    nodes: {{centre: {{position: [0, 0, HEIGHT], orientation: [-0.4, 0, 0]}}}}
    elements:
      wheel: {{type: rigid_body, node: centre, mass: {MASS}, inertia: [0.03, 0.05, 0.03]}}
      tyre: {{type: KIND, node: centre, axis: [AXIS], tire_law: round, ground: floor}}
    tire_laws:
      round: {{radius: {R}, crown_radius: {E}, radial: {{linear: {{slope: STIFFNESS}}}}, friction: 20,
              radial_damping: 0.1, slip_regularization: CREEP,
              lateral: {{relaxation: {{cornering_stiffness: 3.0e3, relaxation_length: LENGTH}}}}}}
    grounds: {{floor: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
    initial: {{velocities: [{{nodes: [centre], velocity: [VELOCITY], angular_velocity: [SPIN]}}]}}
    time: {{end: 1.0, step: 1 ms}}
"""


def started(kind, share):
    """Text of ROLLING with the tyre on the ground, its axes, angular velocity, and the height of the rigid torus."""
    c, s = np.cos(0.4), np.sin(0.4)
    A, spin = np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]]), np.array([0.1, 6.0, -1.5])
    velocity, height = -np.cross(spin, contact_of_torus(A[:, 1], spin)[0]), E + (R - E) * c
    text = ROLLING.replace("HEIGHT", repr(float(height - MASS * G * share / 1.0e4))).replace("KIND", kind)
    for name, value in (("STIFFNESS", 1.0e4 / share), ("CREEP", share), ("LENGTH", 0.01 * share)):
        text = text.replace(name, repr(value))
    for name, vector in (("AXIS", A[:, 1]), ("VELOCITY", velocity), ("SPIN", spin)):
        text = text.replace(name, ", ".join(map(repr, vector.tolist())))
    return text, A, spin, height


def released(kind, share):
    """A leaning torus on a stiff tyre of much grip, released in rolling, and the error to the exact rigid motion."""
    text, A, spin, height = started(kind, share)
    exact = solve_ivp(
        rates_of_torus, (0.0, 1.0), np.concatenate([[0.0, 0.0, height], A.ravel(), spin]), t_eval=TORUS_TIMES,
        rtol=1e-11, atol=1e-12,
    ).y  # fmt: skip
    run = RecordedRun(deck(text))
    return run, at_times(run, run["nodes/centre/position"], TORUS_TIMES) - exact[:3].T


def test_a_rigid_torus_rolls_over_a_bump_as_stiff_tyres_do(verify):
    """Its constraints are other equations than the forces of a tyre, which differ from it by compliance and creep."""
    bump = ", profile: {direction: [1, 0.3, 0], height: {bump: {start: 0.1, length: 1.5, height: 0.02}}}"
    places = []
    for kind, share in (("rigid_wheel", 1e-3), ("wheel", 1.0), ("wheel", 0.1)):
        text = started("wheel", share)[0].replace("normal: [0, 0, 1]}", "normal: [0, 0, 1]}" + bump)
        if kind == "rigid_wheel":
            own = f"type: rigid_wheel, radius: {R}, crown_radius: {E},"
            text = text.replace("type: wheel,", own).replace("tire_law: round, ", "")
            text = text[: text.index("tire_laws:")] + text[text.index("grounds:") :]
        run = RecordedRun(deck(text))
        places.append(run["nodes/centre/position"][-1])
        assert np.ptp(run["energy/balance"]) < 1e-5  # J of 11 J
    rigid, soft, stiff = places
    verify("Rolling", "rigid torus over a bump: centre after 1 s [m]", rigid, stiff, "stiff tyre", absolute=5e-4)
    assert np.abs(soft - rigid).max() > 6.0 * np.abs(stiff - rigid).max()
    level = released("wheel", 0.1)[0]["nodes/centre/position"][-1]
    assert np.abs(rigid - level).max() > 0.03  # m, by the bump


@pytest.mark.parametrize("kind", ["wheel", "flexible_wheel", "adhesive_wheel"])
def test_a_stiff_tyre_with_grip_rolls_as_a_rigid_torus(kind, verify):
    """Its error falls with compliance and creep, ``share``; its energy is that of the start."""
    errors = []
    for share in (1.0, 0.1):
        run, error = released(kind, share)
        errors.append(np.abs(error).max())
        assert np.ptp(run["energy/balance"]) < 2e-5  # J of 11 J
    what = f"stiff {kind.replace('_', ' ')} as a rigid torus: error of its centre over 1 s [m]"
    verify("Rolling", what, errors[1], 0.0, "SciPy", absolute=5e-4)
    assert errors[0] > 6.0 * errors[1]


TIR = """{FNOMIN: 1500, UNLOADED_RADIUS: 0.3, PCX1: 1.6, PDX1: 1.2, PKX1: 20, PCY1: 1.3, PDY1: 1, PKY1: -18, PKY2: 1.8,
          VERTICAL_STIFFNESS: 1.5e5, BREFF: 8, DREFF: 0.25, FREFF: 0.07, VERSION: 6.1}"""
FREE = f"""
    mecano: 1
    gravity: [0, 0, -{G}]
    nodes: {{axle: {{position: [0, 0, 0.25]}}, hub: {{position: [0, 0, 0.25]}}}}
    elements:
      load: {{type: rigid_body, node: axle, mass: 150, inertia: [1, 1, 1]}}
      rim: {{type: rigid_body, node: hub, mass: 1, inertia: [1, 1, 1]}}
      tyre: {{type: wheel, node: hub, axis: [0, {float(np.cos(LEAN))!r}, {float(np.sin(LEAN))!r}], tire_law: round,
             ground: floor}}
    joints:
      guide: {{type: generic, nodes: [ground, axle], axis: [0, 0, 1], axis_1: [1, 0, 0], free: [along_1, along_axis]}}
      bearing: {{type: hinge, nodes: [axle, hub], axis: [0, {float(np.cos(LEAN))!r}, {float(np.sin(LEAN))!r}]}}
    tire_laws: {{round: {{crown_radius: 0.08, magic_formula: {{coefficients: {TIR}}}}}}}
    grounds: {{floor: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
    initial: {{steady: {{velocity: [20, 0, 0]}}}}
    time: {{end: 0.01, step: 0.01}}
"""


def test_a_leaning_tyre_of_a_file_rolls_on_a_smaller_radius():
    """R_e of the file, (A3) of Besselink et al., less (e - w) (1 - cos gamma), by which its contact is nearer."""
    run = RecordedRun(deck(FREE))
    w, N, spin = (run[f"elements/tyre/{name}"][0] for name in ("deformation", "normal_force", "spin_rate"))
    assert N == pytest.approx(151 * G, rel=1e-6) and w == pytest.approx(N / 1.5e5, rel=1e-6)
    n = N / 1500.0
    upright = 0.3 - 0.01 * (0.25 * np.arctan(8.0 * n) + 0.07 * n)
    assert spin == pytest.approx(20.0 / (upright - (0.08 - w) * (1.0 - np.cos(LEAN))), rel=1e-6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_rounded_treads_on_a_drum(side):
    """Depth in a drum, outside and inside, by a search along the middle circle for the point nearest to its surface."""
    rng, main, drum = np.random.default_rng(5), np.array([0.0, 0.0, 1.0]), 2.0
    p = SimpleNamespace(cylindrical=1.0, drum_radius=drum, drum_side=side, radius=R, crown=E)
    for lean, heading in rng.uniform(-0.8, 0.8, (8, 2)):
        axis, ahead, down = (Rotation.from_euler("Y", -np.pi / 2.0).apply(v) for v in frame(lean, heading))
        x = np.array([-(drum + side * (R - 0.02)), 0.0, rng.normal()])
        axis, ahead, down = side * axis, ahead, side * down  # frame() has the ground below: the drum is on that side

        def gap(angle, x=x, down=down, ahead=ahead):
            point = x + (R - E) * (np.cos(angle) * down + np.sin(angle) * ahead)
            return side * (np.hypot(*point[:2]) - drum)

        found = minimize_scalar(gap, bracket=(-0.3, 0.3), tol=1e-14)
        g = touch_carried_round(p, *(Vec3(*v) for v in (x, axis, np.zeros(3), main)))
        assert R - g.r == pytest.approx(E - found.fun, abs=1e-10)
        assert np.hypot(*(x + np.array(g.arm))[:2]) == pytest.approx(drum, rel=1e-12)


def test_a_crown_is_smaller_than_the_wheel():
    with pytest.raises(DeckError, match=r"'crown_radius' must be less than the 'radius' of 0\.3225 m"):
        deck(STANDING.replace("LAW", FRICTION).replace(f"crown_radius: {E}", f"crown_radius: {R}"))

"""Contact of an ellipsoid with a plane: distance, rolling, sliding, impact."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.spatial.transform import Rotation
from time_runs import RecordedRun, deck, input_deck

from mecano.constraints.touching import touch_at_start
from mecano.constraints.touching_ellipsoid import ELLIPSOIDS
from mecano.errors import DeckError

S, g, a, b, c, TILT = "Contact", 9.81, 0.06, 0.04, 0.03, 0.5
I_x, I_y = (b**2 + c**2) / 5.0, (a**2 + c**2) / 5.0


@pytest.fixture(scope="module")
def ellipsoids():
    """The run of inputs/ellipsoids.yaml."""
    return RecordedRun(input_deck("ellipsoids"))


@pytest.mark.parametrize("seed", range(6))
def test_the_gap_is_the_height_of_the_lowest_point(seed):
    """The lowest of many points of the surface, which is at most that much higher than the lowest of all."""
    rng = np.random.default_rng(seed)
    axes, normal, (x_a, x_b, center) = rng.uniform(0.1, 1.0, 3), rng.normal(size=3), rng.normal(size=(3, 3))
    turn = Rotation.from_rotvec(rng.normal(size=3))
    u, v = np.meshgrid(np.linspace(0.0, np.pi, 801), np.linspace(0.0, 2.0 * np.pi, 1601))
    ball = np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], axis=-1).reshape(-1, 3)
    heights = (center + turn.apply(axes * ball) - x_a) @ (normal / np.linalg.norm(normal))
    d = {"plane": {"normal": normal, "point": None}, "ellipsoid": {"semi_axes": axes, "center": center}, "radius": 0.0}
    gap = touch_at_start(ELLIPSOIDS, d, [(x_a, np.eye(3)), (x_b, turn.as_matrix())]).gap
    assert gap == pytest.approx(heights.min(), abs=2e-5)


def _quarter(inertia):
    """Return a quarter [s] of the period of an ellipsoid of 1 kg that starts at rest at the tilt of the deck."""

    def height(angle):
        return math.hypot(a * math.sin(angle), c * math.cos(angle))

    def slowness(u):
        angle = TILT * math.sin(u)  # takes the singularity at the turning point away
        return (
            TILT * math.cos(u) * math.sqrt(inertia(angle, height(angle)) / (2.0 * g * (height(TILT) - height(angle))))
        )

    return quad(slowness, 0.0, math.pi / 2.0 - 1e-9)[0]


def _rolling(angle, h):
    return I_y + (a**4 * math.sin(angle) ** 2 + c**4 * math.cos(angle) ** 2) / h**2


def _smooth(angle, h):
    return I_y + ((a**2 - c**2) * math.sin(angle) * math.cos(angle) / h) ** 2


def _first_zero(t, y):
    i = np.flatnonzero((y[:-1] > 0.0) & (y[1:] <= 0.0))[0]
    return t[i] + y[i] * (t[i + 1] - t[i]) / (y[i] - y[i + 1])


def _tilt(run, name, axis):
    """Return the component of the rotation vector [rad] along an inertial axis."""
    return Rotation.from_quat(np.roll(run[f"nodes/{name}/rotation"], -1, axis=1)).as_rotvec()[:, axis]


@pytest.mark.parametrize(("axis", "semi_axis", "inertia"), [(0, b, I_x), (1, a, I_y)])
def test_small_oscillations(verify, ellipsoids, axis, semi_axis, inertia):
    found = _first_zero(ellipsoids.time, _tilt(ellipsoids, "small", axis))
    known = 0.5 * math.pi / math.sqrt(g * (semi_axis**2 / c - c) / (inertia + c**2))
    what = f"ellipsoid rolls by small angles about {'xy'[axis]}: a quarter of its period [s]"
    verify(S, what, found, known, "m g (a^2/c - c)/(I + m c^2)", relative=1e-3)


@pytest.mark.parametrize(("name", "inertia"), [("rolling", _rolling), ("elastic", _rolling), ("smooth", _smooth)])
def test_large_oscillations(verify, ellipsoids, name, inertia):
    found = _first_zero(ellipsoids.time, _tilt(ellipsoids, name, 1))
    what = f"ellipsoid {name}, tilted by 0.5: a quarter of its period [s]"
    verify(S, what, found, _quarter(inertia), "energy in closed form, by quadrature", relative=1e-3)


CELT = np.array([0.1, 0.02, 0.015])  # m, semi-axes of the rattleback
MASS, TURNED, LEAN, SPIN = 0.1, 0.05, 0.01, -5.0  # kg; rad, of the inertia about z, of the start about x; rad/s
SOLID = MASS / 5.0 * np.diag([CELT[1] ** 2 + CELT[2] ** 2, CELT[0] ** 2 + CELT[2] ** 2, CELT[0] ** 2 + CELT[1] ** 2])
ABOUT_Z = Rotation.from_rotvec([0.0, 0.0, TURNED]).as_matrix()
INERTIA = ABOUT_Z @ SOLID @ ABOUT_Z.T  # kg m2, of a solid ellipsoid that is turned against the surface


def _arm(n, turning):
    """Return the arm (3,) [m] to the lowest point and its rate, by normal and angular velocity in body axes."""
    squares = CELT**2
    rate, q = -np.cross(turning, n), math.sqrt(n @ (squares * n))
    return -squares * n / q, -squares * rate / q + squares * n * (n @ (squares * rate)) / q**3


def _celt(_, y):
    """Return the rates of normal and angular velocity (6,), in the axes of the body, of rolling without slip.

    Euler's equations about the contact: J w' + w x J w = r x F with F = m (v' + w x v + g n) and v = -w x r.
    """
    n, w = y[:3], y[3:]
    (r, r_rate), J = _arm(n, w), INERTIA
    about = J + MASS * (r @ r * np.eye(3) - np.outer(r, r))
    push = -np.cross(w, r_rate) - np.cross(w, np.cross(w, r)) + g * n
    return np.concatenate([-np.cross(w, n), np.linalg.solve(about, -np.cross(w, J @ w) + MASS * np.cross(r, push))])


def test_a_rattleback_turns_back(verify):
    """Spun against its sense it begins to rattle, stops, and turns the other way."""
    lean = Rotation.from_rotvec([LEAN, 0.0, 0.0])
    n, w = lean.inv().apply([[0.0, 0.0, 1.0], [0.0, 0.0, SPIN]])
    arm = _arm(n, w)[0]
    speed = lean.apply(np.cross(arm, w))
    text = f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {{celt: {{position: [0, 0, {float(-arm @ n)!r}], orientation: [{LEAN}, 0, 0]}}}}
        elements:
          celt: {{type: rigid_body, node: celt, mass: {MASS}, inertia: {INERTIA.tolist()}}}
          table: {{type: contact, nodes: [ground, celt], plane: {{normal: [0, 0, 1], point: [0, 0, 0]}},
                  ellipsoid: {{semi_axes: {CELT.tolist()}}}, friction: {{coefficient: 2, regularization: 0.01 mm/s}}}}
        initial:
          velocities: [{{nodes: [celt], velocity: {speed.tolist()}, angular_velocity: [0, 0, {SPIN}]}}]
        time: {{end: 3, step: 0.5 ms}}
    """
    recorded = RecordedRun(deck(text))
    times = np.linspace(0.0, 3.0, 31)
    found = solve_ivp(_celt, (0.0, 3.0), np.concatenate([n, w]), "DOP853", times, rtol=1e-6, atol=1e-8)
    spin = (found.y[:3] * found.y[3:]).sum(axis=0)
    assert spin[0] < -4.9 and spin[-1] > 1.0
    ours = np.interp(times, recorded.time, recorded["nodes/celt/angular_velocity"][:, 2])
    verify(S, "rattleback: spin [rad/s]", ours, spin, "rolling without slip, by SciPy", absolute=0.01)


def test_impact(verify, ellipsoids):
    impact = next(e for e in ellipsoids.event_records if e.element == "contact 'on_falling'")
    h = math.hypot(a * math.sin(TILT), c * math.cos(TILT))
    fall = 0.038995 + 0.1 - h
    beside = (a**2 - c**2) * math.sin(TILT) * math.cos(TILT) / h
    known = 1.5 * math.sqrt(2.0 * g * fall) / (1.0 + beside**2 / I_y)
    verify(S, "ellipsoid falls: impulse [N s]", impact.impulse, known, "impulse on a free body", relative=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("elements.on_smooth.radius=0.1", "an 'ellipsoid' has 'semi_axes' only"),
        ("elements.on_smooth.ellipsoid.semi_axes=[1, 0, 1]", "must be greater than zero, each of them"),
        ("elements.on_smooth.ellipsoid.semi_axes=[1, 1, 1]", "the ellipsoid starts 0.961"),
    ],
)
def test_errors(change, message):
    with pytest.raises(DeckError) as error:
        input_deck("ellipsoids", change)
    assert message in error.value.problems[0].message

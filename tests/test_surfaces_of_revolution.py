"""Contact of a ball with pipes, drums, funnels and profiles: distance, rolling, separation, detent, pins in holes."""

import math

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq, minimize_scalar
from scipy.special import ellipk
from time_runs import RecordedRun, input_deck

from mecano.analyses.dynamic import run
from mecano.constraints.touching_revolution import nearest_at_start
from mecano.deck.format import deck_error_text
from mecano.errors import DeckError
from mecano.post.contact_outlines import outlines
from mecano.post.runs import open_runs
from mecano.post.shapes import Motion

S, g = "Contact", 9.81


@pytest.fixture(scope="module")
def balls():
    """The run of inputs/ball_in_pipe.yaml."""
    return RecordedRun(input_deck("ball_in_pipe"))


@pytest.mark.parametrize(("name", "factor"), [("sliding", 1.0), ("rolling", 5.0 / 7.0)])
def test_a_ball_in_a_pipe_is_a_pendulum(verify, balls, name, factor):
    """From the lowest point and back, in half a period, 2 K(sin^2(a/2))/w."""
    t, x, w = balls.time, balls[f"nodes/{name}/position"][:, 0], math.sqrt(factor * g / 0.9)
    i = np.flatnonzero((x[:-1] > 0.0) & (x[1:] <= 0.0))[0]
    back = t[i] + x[i] * (t[i + 1] - t[i]) / (x[i] - x[i + 1])
    known = 2.0 * ellipk((1.5 / (2.0 * w * 0.9)) ** 2) / w
    verify(S, f"ball {name} in a pipe: half a period [s]", back, known, "pendulum of length R - r", relative=2e-5)


def test_a_ball_leaves_a_drum(verify, balls):
    (opens,) = [e for e in balls.event_records if e.element == "contact 'drum'" and e.t > 0.0]
    height = np.interp(opens.t, balls.time, balls["nodes/leaving/position"][:, 2])
    known = 1.1 * (2.0 / 3.0 + 0.5**2 / (3.0 * g * 1.1))
    verify(S, "ball leaves a drum: height of its centre [m]", height, known, "N = 0 in closed form", relative=1e-5)


def test_a_point_circles_in_a_funnel(verify, balls):
    """Level at 0.5 m, and again at the height z with v^2 (1 - (0.5/z)^2)/2 = g (z - 0.5)."""
    square = 1.5**2 * g * 0.5
    known = brentq(lambda z: 0.5 * square * (z + 0.5) - g * z**2, 0.6, 2.0)
    top = balls["nodes/circling/position"][:, 2].max()
    verify(S, "point in a funnel: rises to [m]", top, known, "energy and angular momentum", relative=5e-5)
    assert np.ptp(balls["energy/balance"]) < 5e-4


def test_a_detent_catches_a_shaft_and_pins_move_in_their_holes(verify):
    recorded = RecordedRun(input_deck("snap_pin"))
    z, v = -recorded["nodes/shaft/position"][:, 2], -recorded["nodes/shaft/velocity"][:, 2]
    along, energy = _quasi_static_work()
    first = slice(0, np.argmax(z) + 1)
    for place in (0.008, 0.018):
        found = np.interp(place, z[first], v[first])
        known = math.sqrt(0.5**2 - 2.0 * np.interp(place, along, energy) / 0.5)
        what = f"detent: speed of the shaft after {1e3 * place:g} mm [m/s]"
        verify(S, what, found, known, "work of F tan(a + b), ball without mass", relative=1e-3)
    assert z[-1] == pytest.approx(0.018, abs=1e-3) and abs(v[-1]) < 1e-3
    strikes = [e.t for e in recorded.event_records if e.element == "contact 'hole_of_flying'"]
    known = 2e-3 + 4e-3 * (2.0 ** np.arange(1, 6) - 2.0)
    verify(S, "pin flies in its hole: strikes at [s]", strikes, known, "2 c/(v e^n)", absolute=1e-9)
    gap = recorded["elements/hole_of_loaded/gap"][-1]
    verify(S, "pin loaded in its hole: depth [m]", -gap, 100.0 / 5e5, "F/k", relative=1e-6)


def _quasi_static_work():
    """Return ways of the shaft [m], and the work [J] of spring and friction at each, from the profile of the deck."""
    s, radius = np.array([0.0, 0.008, 0.018]), np.array([0.01, 0.011, 0.009])
    profile = CubicHermiteSpline(s, radius, np.zeros(3))  # extremes of the table, where a monotone cubic is level
    s = np.linspace(0.0, 0.018, 2001)
    slope = np.arctan(profile(s, 1))
    along, away = s - 0.002 * np.sin(slope), profile(s) + 0.002 * np.cos(slope)  # of the ball's centre
    axial = (20.0 + 5000.0 * (away - 0.012)) * np.tan(slope + math.atan(0.1))
    return along, cumulative_trapezoid(axial, along, initial=0.0)


PROFILE = (("polynomial", {"coefficients": [0.5, 0.1, -0.3, 0.1]}),)


@pytest.mark.parametrize("seed", range(6))
def test_the_gap_is_the_least_distance_from_the_meridian(seed):
    rng = np.random.default_rng(seed)
    along, away, inside = rng.uniform(-0.3, 0.3), rng.uniform(0.3, 0.8), seed % 2 == 1
    axis, side = np.linalg.qr(rng.normal(size=(3, 2)))[0].T
    middle = rng.normal(size=3)
    surface = {"axis": axis, "profile": PROFILE, "center": middle, "inside": inside}
    nodes = [(np.zeros(3), np.eye(3)), (middle + along * axis + away * side, np.eye(3))]
    distance, z = nearest_at_start({"revolution": surface, "radius": 0.05}, nodes)

    def radius(s):
        return 0.5 + 0.1 * s - 0.3 * s**2 + 0.1 * s**3

    least = minimize_scalar(
        lambda s: math.hypot(s - along, radius(s) - away), bounds=(along - 0.4, along + 0.4), method="bounded",
        options={"xatol": 1e-10},
    )  # fmt: skip
    sign = math.copysign(1.0, away - radius(along)) * (-1.0 if inside else 1.0)
    assert z == pytest.approx(least.x, abs=1e-6)
    assert distance == pytest.approx(sign * least.fun, abs=1e-9)


def test_pictures_show_the_profile(tmp_path):
    """The meridian lies on the surface, from the ball to the ends of the table, and moves with the shaft."""
    run(input_deck("snap_pin", "time.end=2.0e-3", "output.every=1.0e-3"), tmp_path / "snap.h5")
    (drawn,) = open_runs([tmp_path / "snap.h5"])
    motion = Motion(drawn, slice(None))
    meridian, *_ = outlines(motion, drawn.things["elements/detent"])
    moved = motion.position("shaft")[:, 2]
    assert moved[-1] < -9e-4
    z, radius = meridian[..., 2] - moved[:, None], np.linalg.norm(meridian[..., :2], axis=-1)
    s = np.array([-0.01, 0.0, 0.008, 0.018, 0.028, 0.04])
    profile = CubicHermiteSpline(s, [0.01, 0.01, 0.011, 0.009, 0.0115, 0.0115], np.zeros(6), extrapolate=False)
    inside = (z[0] > s[0]) & (z[0] < s[-1])
    np.testing.assert_allclose(radius[:, inside], np.tile(profile(z[0, inside]), (len(z), 1)), atol=1e-12)
    assert z.min() <= s[0] and z.max() >= s[-1]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("elements.detent.radius=9 mm", "has a hollow at 0.018 m whose radius, 0.006667 m, is less than"),
        ("elements.detent.revolution.inside=true", "node b is outside the surface 'revolution': move it"),
        ("laws.ridge_and_groove.table.interpolation=linear", "has a jump or a corner at 0 m"),
        ("laws.ridge_and_groove={constant: {value: -0.1}}", "'revolution.profile' is -0.1 m at 0 m"),
        ("elements.detent.radius=3 mm", "the ball starts 0.001 m within the surface, which is rigid without 'law'"),
    ],
)
def test_errors(change, message):
    with pytest.raises(DeckError) as info:
        input_deck("snap_pin", change)
    assert message in deck_error_text(info.value)


def test_an_impact_just_after_a_step_opens_no_contact_that_it_does_not_reach():
    """The flying pin strikes 1e-11 s after a step ends: the ball stays on the profile, pressed with 20 N.

    Steps keep velocities off the constraints by O(h^2), here 2e-7 m/s along the normal of the profile.
    """
    speeds = "[{nodes: [shaft], velocity: [0, 0, -0.5]}, {nodes: [flying], velocity: [0.0999999999, 0, 0]}]"
    recorded = RecordedRun(input_deck("snap_pin", f"initial.velocities={speeds}", "time.end=0.011"))
    met = [h.name for h in recorded.event_records if h.element == "contact 'hole_of_flying'"]
    assert met == ["closes", "closes"]
    assert [h.name for h in recorded.event_records if h.element == "contact 'detent'"] == ["closes"]

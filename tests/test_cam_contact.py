"""Contact of a roller with a cam: the gap, the float of a follower, and profiles that are refused."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar
from time_runs import RecordedRun, input_deck

from mecano.analyses.dynamic import run
from mecano.constraints.touching import touch_at_start
from mecano.constraints.touching_cam import CAMS
from mecano.constraints.touching_face import FACES
from mecano.errors import DeckError
from mecano.post.contact_outlines import outlines
from mecano.post.runs import open_runs
from mecano.post.shapes import Motion

RATE, ROLLER, MASS, STIFFNESS, PRELOAD, G = 220.0, 0.008, 0.2, 5e3, 50.0, 9.81
STEP = 1e-5  # [s] of differences


def radius(angle):
    return 0.033 - 0.003 * np.cos(2.0 * angle)


def height(t):
    """Return the height of the roller on the cam: as low as it can be without entering it."""
    turn = RATE * t

    def above(angle):
        x, z = radius(angle) * np.sin(angle + turn), radius(angle) * np.cos(angle + turn)
        return -z - math.sqrt(max(ROLLER**2 - x * x, 0.0))

    found = minimize_scalar(above, bounds=(-turn - 0.2, -turn + 0.2), method="bounded", options={"xatol": 1e-12})
    return -found.fun


def push(t):
    """Return the force with which the cam must press the follower to keep it in contact."""
    upward = (height(t + STEP) - 2.0 * height(t) + height(t - STEP)) / STEP**2
    return MASS * (G + upward) + PRELOAD + STIFFNESS * (height(t) - 0.038)


def test_a_follower_leaves_its_cam_and_falls_back(verify):
    leaves = brentq(push, 4e-3, 7e-3)
    start, speed = height(leaves), (height(leaves + STEP) - height(leaves - STEP)) / (2.0 * STEP)
    rate, middle = math.sqrt(STIFFNESS / MASS), 0.038 - (PRELOAD + MASS * G) / STIFFNESS
    free = lambda t: middle + (start - middle) * np.cos(rate * t) + speed / rate * np.sin(rate * t)  # noqa: E731
    returns = brentq(lambda t: free(t - leaves) - height(t), 10e-3, 14e-3)
    found = [event.t for event in RecordedRun(input_deck("cam_float", "time.end=14 ms")).event_records][-2:]
    what = "follower leaves its cam, and falls back: times [s]"
    verify("Contact", what, np.array(found), np.array([leaves, returns]), "geometry and free flight", absolute=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_the_gap_is_the_least_distance_from_the_profile(seed):
    rng = np.random.default_rng(seed)
    profile = (("sine", {"amplitude": 0.08, "frequency": 3.0 / (2.0 * np.pi), "phase": 0.4, "offset": 0.5}),)
    axis, zero = np.linalg.qr(rng.normal(size=(3, 2)))[0].T
    middle, place, away = rng.normal(size=3), rng.uniform(-3.0, 3.0), rng.uniform(0.62, 0.9)
    x, y = away * np.cos(place), away * np.sin(place)
    nodes = [(np.zeros(3), np.eye(3)), (middle + x * zero + y * np.cross(axis, zero) + 0.3 * axis, np.eye(3))]
    cam = {"axis": axis, "zero": zero, "profile": profile, "center": middle}
    angle = np.linspace(0.0, 2.0 * np.pi, 200001)
    rho = 0.5 + 0.08 * np.sin(3.0 * angle + 0.4)
    least = np.hypot(rho * np.cos(angle) - x, rho * np.sin(angle) - y).min()
    assert touch_at_start(CAMS, {"cam": cam, "radius": 0.05}, nodes).gap == pytest.approx(least - 0.05, abs=1e-8)


def test_pictures_show_the_cam(tmp_path):
    """Its curve has the radii of the profile, and turns with the shaft."""
    run(input_deck("cam_float", "time.end=1 ms", "output.every=1 ms"), tmp_path / "cam.h5")
    (drawn,) = open_runs([tmp_path / "cam.h5"])
    curve, *_ = outlines(Motion(drawn, slice(None)), drawn.things["elements/profile"])
    angle = np.linspace(0.0, 2.0 * np.pi, curve.shape[1])
    np.testing.assert_allclose(np.linalg.norm(curve, axis=-1), np.tile(radius(angle), (len(curve), 1)), atol=1e-12)
    np.testing.assert_allclose(curve[-1, 0], 0.03 * np.array([math.sin(0.22), 0.0, math.cos(0.22)]), atol=1e-12)


CHANGES = [
    ("elements.profile.cam.zero=[0, 1, 0]", "'cam.zero' must not be along 'cam.axis'"),
    ("laws.lift={linear: {slope: 1 mm, offset: 30 mm}}", "'cam.profile' must be closed"),
    ("laws.lift={sine: {amplitude: 40 mm, frequency: 1/pi, offset: 33 mm}}", "'cam.profile' is -0.007 m at 135 deg"),
    ("laws.lift={sine: {amplitude: 10 mm, frequency: 3/pi, offset: 33 mm}}", "has a hollow at 45 deg whose radius"),
    (
        "laws.lift={table: {points: [[0, 0.03], [2, 0.04], [2*pi, 0.03]], interpolation: linear}}",
        "has a jump or a corner",
    ),
    ("nodes.roller.position=[0, 0, 20 mm]", "node b is inside the cam"),
    ("nodes.roller.position=[0, 0, 37 mm]", "the ball starts 0.001 m within the surface, which is rigid without 'law'"),
]


@pytest.mark.parametrize(("change", "message"), CHANGES)
def test_cams_that_a_roller_cannot_follow_are_refused(change, message):
    with pytest.raises(DeckError) as info:
        input_deck("cam_float", change)
    assert any(message in problem.message for problem in info.value.problems)


@pytest.mark.parametrize("beyond", [0, 10])
def test_a_table_of_a_cam_that_is_not_level_at_its_ends_needs_points_beyond_them(beyond):
    """A circle of 30 mm whose centre is 6 mm from the axis, every 5 degrees, from its flank on."""
    angle = np.radians(5.0) * np.arange(-beyond, 73 + beyond)
    radius = 6.0 * np.sin(angle) + np.sqrt(30.0**2 - (6.0 * np.cos(angle)) ** 2)
    points = ", ".join(f"[{a!r}, {r / 1e3!r}]" for a, r in zip(angle.tolist(), radius.tolist(), strict=True))
    change = f"laws.lift={{table: {{points: [{points}], interpolation: spline}}}}"
    if not beyond:
        with pytest.raises(DeckError, match="repeat ten points of a table beyond both ends"):
            input_deck("cam_float", change)
    else:
        input_deck("cam_float", change)


@pytest.mark.parametrize("seed", range(3))
def test_the_gap_of_a_face_is_to_the_farthest_point_of_the_profile(seed):
    """The least distance from the face of many points of the curve, also of a face that is not parallel to the axis."""
    rng = np.random.default_rng(seed)
    profile = (("sine", {"amplitude": 0.04, "frequency": 3.0 / (2.0 * np.pi), "phase": 0.4, "offset": 0.5}),)
    axis, zero = np.linalg.qr(rng.normal(size=(3, 2)))[0].T
    middle, place, on_face = rng.normal(size=(3, 3))
    normal = place + 0.2 * axis
    d = {
        "cam": {"axis": axis, "zero": zero, "profile": profile, "center": middle},
        "face": {"normal": -normal, "center": on_face}, "radius": 0.0,
    }  # fmt: skip
    angle = np.linspace(0.0, 2.0 * np.pi, 200001)[:, None]
    rho = 0.5 + 0.04 * np.sin(3.0 * angle + 0.4)
    curve = middle + rho * (np.cos(angle) * zero + np.sin(angle) * np.cross(axis, zero))
    least = ((on_face - curve) @ normal).min() / np.linalg.norm(normal)
    nodes = [(np.zeros(3), np.eye(3)), (rng.normal(size=3), np.eye(3))]
    assert touch_at_start(FACES, d, nodes).gap == pytest.approx(least, abs=1e-8)


FACE = (
    "elements.profile={type: contact, nodes: [shaft, roller], cam: {axis: [0, 1, 0], zero: [0, 0, 1], profile: lift}, "
)
FLAT = (
    f"{FACE}face: {{normal: [0, 0, -1]}}}}", "nodes.roller.position=[0, 0, 30 mm]",
    "laws.lift={sine: {amplitude: 1 mm, frequency: 1/pi, phase: -90 deg, offset: 31 mm}}",
)  # fmt: skip


def test_a_flat_follower_rides_on_a_cam_of_any_profile(verify):
    """A tappet under a spring that never lets it go: the highest point of the turned cam, and the force of its lift."""
    run = RecordedRun(input_deck("cam_float", *FLAT, "elements.spring.law.spring.stiffness=15 kN/m", "time.end=15 ms"))
    angle, t = np.linspace(0.0, 2.0 * np.pi, 400001), run.time[2:-2:5]

    def lift(t):
        return ((0.031 - 0.001 * np.cos(2.0 * angle)) * np.cos(angle + RATE * t)).max()

    high, up = (np.array([lift(s + h) for s in t]) for h in (0.0, 1e-4))
    down = np.array([lift(s - 1e-4) for s in t])
    force = MASS * (G + (up - 2.0 * high + down) / 1e-8) + PRELOAD + 15e3 * (high - 0.030)
    found = run["nodes/roller/position"][2:-2:5, 2], run["elements/profile/normal_force"].ravel()[2:-2:5]
    np.testing.assert_allclose(found[0], high, atol=1e-8)
    source = "highest point of the turned profile, differences of it"
    what = "flat tappet on a cam of two lobes: force of the cam over the largest [-]"
    verify("Contact", what, found[1] / force.max(), force / force.max(), source, absolute=5e-4)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (("laws.lift={sine: {amplitude: 8 mm, frequency: 1/pi, offset: 33 mm}}",), "a face touches convex cams only"),
        ((f"{FACE}radius: 1 mm, face: {{normal: [0, 0, -1]}}}}",), "'radius' is that of a ball or rod"),
        ((f"{FACE}face: {{normal: [0, 1, 0]}}}}",), "'face.normal' must not be along 'cam.axis'"),
        ((f"{FACE}face: {{normal: [0, 0, -1]}}, rod: {{axis: [0, 1, 0], length: 1}}}}",), "give only one of 'rod'"),
        (("nodes.roller.position=[0, 0, 29 mm]",), "the face starts 0.001 m within the surface"),
    ],
)
def test_faces_that_cannot_follow_a_cam_are_refused(changes, message):
    with pytest.raises(DeckError) as info:
        input_deck("cam_float", *FLAT, *changes)
    assert any(message in problem.message for problem in info.value.problems)

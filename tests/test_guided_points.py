"""Points on curves and along beams: decks of inputs/ and others against closed forms, and what they refuse."""

import numpy as np
import pytest
from convergence import at_times, check_second_order
from marching import March, deck, input_deck

from mecano.elements import KINDS
from mecano.errors import ConvergenceError
from mecano.run import run

G = 9.81


def test_cam_lifts_its_follower():
    """Position, pressure angle and place on the cam are geometry; m (g + z'') gives the force, to (omega h)^2."""
    march = March(input_deck("cam"))
    theta, e, rho = 15.0 * march.time, 0.02, 0.05
    sine, cosine = e * np.sin(theta), e * np.cos(theta)
    root = np.sqrt(rho**2 - sine**2)
    np.testing.assert_allclose(march["nodes/roller/position"][:, 2], cosine + root, rtol=0, atol=1e-12)
    np.testing.assert_allclose(march["joints/profile/position"], -rho * (theta + np.arcsin(sine / rho)), atol=1e-11)
    np.testing.assert_allclose(march["joints/profile/pressure_angle"], np.arcsin(abs(sine) / rho), rtol=0, atol=1e-8)
    by_angle = -sine - sine * cosine / root
    second = -cosine - (cosine**2 - sine**2) / root - (sine * cosine) ** 2 / root**3
    lifting = 0.5 * (G + 15.0**2 * second)
    np.testing.assert_allclose(march["joints/profile/normal_force"], lifting * rho / root, rtol=0, atol=1e-3)
    np.testing.assert_allclose(march["joints/motor/moment"], by_angle * lifting, rtol=0, atol=2e-5)
    assert march.prepared.analysis.redundant == ()


BEAD = """
    mecano: 1
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
        march = March(bead([1.0 + r, 0.0, 0.0], helix, 2.0, step))
        pair.append(at_times(march, march["joints/wire/position"], times))
    check_second_order(*pair, 0.5 * along * times**2, 1e-4)
    expected = 2.0 * np.hypot(G * r / length, r / length**2 * (along * march.time) ** 2)
    np.testing.assert_allclose(march["joints/wire/normal_force"], expected, rtol=1e-3)


@pytest.mark.parametrize("amplitude", [0.9, 1.8])
def test_cycloid_is_a_tautochrone(amplitude):
    """From every place at rest a bead is at the bottom after pi sqrt(a/g): a quarter of T = 4 pi sqrt(a/g)."""
    a = 0.5

    def place(u):
        return np.array([a * (u + np.sin(u)), 0.0 * u, a * (1.0 - np.cos(u))]).T

    points = place(np.linspace(-2.4, 2.4, 41)).round(12).tolist()
    march = March(bead(place(amplitude), f"points: {points}", 1.0, 2e-3))
    x = march["nodes/bead/position"][:, 0]
    passing = np.interp(0.0, -x, march.time)
    assert passing == pytest.approx(np.pi * np.sqrt(a / G), rel=2e-5)  # the spline is 1e-5 off the curvature
    energy = 2.0 * G * march["nodes/bead/position"][:, 2] + np.sum(march["nodes/bead/velocity"] ** 2, axis=1)
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
    march = March(ring)
    radius = np.linalg.norm(march["nodes/bead/position"], axis=1)
    assert np.abs(radius - 1.0).max() < 2e-3
    assert march["joints/wire/position"][-1] > 3.5 * 2 * np.pi
    np.testing.assert_allclose(march["joints/wire/speed"], 8.0, rtol=2e-4)  # (v h)^2/r^2 is 4e-4


def test_run_ends_at_the_end_of_the_curve(tmp_path):
    path = tmp_path / "out.h5"
    with pytest.raises(ConvergenceError, match="point_on_curve 'wire' has come to the end of its curve"):
        run(bead([0.0, 0.0, 1.0], "points: [[0, 0, 1], [1, 0, 0.5]]", 1.0, 0.01), path)
    assert path.exists()


CIRCLE = {"points": None, "closed": False, "across": "held", "advance": None}
CIRCLE |= {"center": [0, 0, 0], "semi_axis_1": [1, 0, 0], "semi_axis_2": [0, 1, 0]}
SPLINE = dict.fromkeys(CIRCLE) | {"points": [[0, 0, 0], [1, 0, 0], [1, 1, 1]], "closed": False, "across": "held"}
REFUSED = [
    (CIRCLE | {"center": None}, "missing 'center'; or give 'points'"),
    (CIRCLE | {"semi_axis_2": [2, 0, 0]}, "'semi_axis_2' must not be parallel"),
    (CIRCLE | {"closed": True}, "'closed' is of 'points' only"),
    (CIRCLE | {"advance": [0, 0, 1], "across": "free"}, "'across' cannot be free"),
    (SPLINE | {"center": [0, 0, 0]}, "'center' and 'points' exclude one another"),
    (SPLINE | {"points": [[0, 0, 0]]}, "'points' must be at least 2"),
    (SPLINE | {"points": [[0, 0, 0], [0, 0, 0]]}, "'points' must not follow one another at one place"),
    (SPLINE | {"points": [[0, 0, 0], [1, 0, 0], [2, 0, 0]], "across": "free"}, "lies in no plane, or in many"),
]


@pytest.mark.parametrize("values, text", REFUSED)
def test_what_is_no_curve_is_refused(values, text):
    (found,) = KINDS["point_on_curve"].check(values, None)
    assert text in found

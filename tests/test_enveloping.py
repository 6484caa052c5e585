"""Tyres that envelop short obstacles: the path of a cam, the plane of two cams, and the forces on it."""

import numpy as np
import pytest
from time_runs import INPUTS, RecordedRun, deck, input_deck

from mecano.elements.wheels.enveloping import cam_path
from mecano.errors import DeckError
from mecano.laws.probe import curve_values

TEXT = (INPUTS / "cleat.yaml").read_text()
TABLE = next(line.strip() for line in TEXT.splitlines() if "height: {table" in line)
RADIUS, DISTANCE, STIFFNESS = 0.3, 0.08, 2e5
CAMS = {"cam_length": 1.0, "cam_height": 1.0, "cam_exponent": 1.8}


def below(x):
    """Return the height of an ellipse of the exponent 1.8 above its lowest point."""
    return RADIUS - RADIUS * (1.0 - (np.abs(x) / RADIUS) ** 1.8) ** (1.0 / 1.8)


def on_the_cleat(s, height=0.01, half=0.015):
    """Return the height of a cam above a cleat: on top of it, or with its flank on one of its edges."""
    beside = np.minimum(np.maximum(np.abs(s) - half, 0.0), 0.99 * RADIUS)
    return np.maximum(height - below(beside), 0.0)


def table(points, interpolation="linear"):
    return (("table", {"points": points, "interpolation": interpolation, "beyond": "hold"}),)


def test_a_cam_follows_a_cleat_on_its_edges():
    cleat = table([[-0.0150001, 0.0], [-0.015, 0.01], [0.015, 0.01], [0.0150001, 0.0]])
    s = np.linspace(-0.3, 0.3, 2001)
    np.testing.assert_allclose(curve_values(cam_path(cleat, CAMS, RADIUS), s)[:, 0], on_the_cleat(s), atol=1e-4)


def test_a_cam_bridges_a_hole_and_rides_over_a_hump():
    """Of the ground that it can reach, it rests on the highest point: maximum over its outline, on a dense grid."""
    points = [[0.0, 0.0], [0.1, 0.02], [0.15, 0.02], [0.2, -0.05], [0.3, -0.05], [0.35, 0.01]]
    path = cam_path(table(points), CAMS, RADIUS)
    x = np.linspace(-0.999 * RADIUS, 0.999 * RADIUS, 20001)
    for s in (-0.1, 0.05, 0.17, 0.25, 0.4):
        ground = np.interp(s + x, *np.transpose(points))
        assert curve_values(path, np.array([s]))[0, 0] == pytest.approx((ground - below(x)).max(), abs=1e-5)


@pytest.fixture(scope="module")
def crossing():
    return RecordedRun(input_deck("cleat"))


def test_forces_on_a_cleat_are_those_on_the_plane_of_two_cams(crossing, verify):
    """A spring between the axle at its constant height and the plane, along the normal of the plane."""
    s = crossing["nodes/hub/position"][:, 0]
    front, rear = on_the_cleat(s + 0.5 * DISTANCE), on_the_cleat(s - 0.5 * DISTANCE)
    slope = (front - rear) / DISTANCE
    length = np.sqrt(1.0 + slope**2)
    push = STIFFNESS * (RADIUS - (0.28 - 0.5 * (front + rear)) / length)
    force = crossing["elements/tyre/contact_force"]
    np.testing.assert_allclose(force[:, 2], push / length, atol=10.0)
    np.testing.assert_allclose(force[:, 0], -push * slope / length, atol=15.0)
    middle = np.abs(s).argmin()
    source = "ellipses on the edges of the cleat (Schmeitz 2004)"
    verify("Tyres", "a tyre above the middle of a cleat: force [N]", force[middle, 2], 5618.7, source, relative=1e-4)


def test_no_energy_is_missing_on_a_cleat(crossing):
    """The work of the towing motor and of the moving plane; a finer step reduces the error of the corners."""
    finer = RecordedRun(input_deck("cleat", "time.step=2.5e-4"))
    error, smaller = (np.ptp(run["energy/balance"]) for run in (crossing, finer))
    assert smaller < 0.4 * error < 1e-3 * np.ptp(crossing["energy/potential"])
    given = finer["energy/given"].ravel()
    assert abs(given[-1] - given[0]) < 1e-2 * np.ptp(given)


def test_a_long_bump_is_that_of_the_ground_itself():
    """A bump of 3 m: cams 80 mm apart see its slope and its height."""
    bump = "parameters.speed=5 m/s", "nodes.carriage.position=[-0.25,0,0.28]", "time.end=0.7"
    text = TEXT.replace(TABLE, "height: {bump: {start: 0, length: 3 m, height: 15 mm}}")
    with_cams = RecordedRun(with_overrides(text, bump))
    without = RecordedRun(with_overrides(text.replace("enveloping: {contact_length: 100 mm}", ""), bump))
    found, expected = (run["elements/tyre/contact_force"] for run in (with_cams, without))
    assert np.ptp(expected[:, 2]) > 2500.0
    np.testing.assert_allclose(found, expected, atol=15.0)


def with_overrides(text, overrides):
    from mecano.deck.read import deck_of_bytes

    return deck_of_bytes(text.encode(), "test.yaml", overrides=overrides)


def test_a_wheel_in_the_air_touches_down_on_a_cleat():
    """With the axle 2 mm above the touching height, the tyre meets the effective plane at 2 mm, and leaves it there."""
    text = TEXT.replace("0.28]", "0.302]").replace("step: 1 ms", "step: 1 ms, adaptive: {tolerance: 1.0e-5}")
    run = RecordedRun(deck(text))
    assert [event.name for event in run.event_records] == ["touch_down", "lift_off"]
    for event in run.event_records:
        s = -0.25 + 0.5 * event.t
        front, rear = on_the_cleat(s + 0.5 * DISTANCE), on_the_cleat(s - 0.5 * DISTANCE)
        depth = RADIUS - (0.302 - 0.5 * (front + rear)) / np.hypot(1.0, (front - rear) / DISTANCE)
        assert depth == pytest.approx(0.0, abs=2e-5)


ANGLE, WIDTH = np.radians(30.0), 0.08
OBLIQUE = TEXT.replace("direction: [1, 0, 0]\n", f"direction: [{np.cos(ANGLE)}, {np.sin(ANGLE)}, 0]\n").replace(
    "{contact_length: 100 mm}", f"{{contact_length: 100 mm, contact_width: {WIDTH}}}"
)


def test_a_cleat_met_at_an_angle_is_met_by_one_cam_after_the_other(verify):
    """Five cams in two rows: the cleat is longer by 1/cos(30 deg) for each of them; the plane leans across, too."""
    run = RecordedRun(deck(OBLIQUE))
    x, across = run["nodes/hub/position"][:, 0, None], WIDTH * np.linspace(-0.5, 0.5, 5)
    front, rear = (
        on_the_cleat(x + ahead * DISTANCE + across * np.tan(ANGLE), half=0.015 / np.cos(ANGLE)) for ahead in (0.5, -0.5)
    )
    slope = (front.mean(axis=1) - rear.mean(axis=1)) / DISTANCE
    lean = (front + rear) @ across / (2.0 * across @ across)
    length = np.sqrt(1.0 + slope**2 + lean**2)
    q = np.sqrt(1.0 - (lean / length) ** 2)
    push = STIFFNESS * (RADIUS - (0.28 - 0.5 * (front + rear).mean(axis=1)) / length / q) / q
    assert np.abs(lean).max() > 0.05
    found = run["elements/tyre/normal_force"].ravel()
    source = "cams on the edges of the cleat, in the plane of the wheel (Schmeitz 2004)"
    verify("Tyres", "a tyre over a cleat at 30 degrees: normal force over 4 kN [-]", found / 4e3, push / 4e3, source,
           absolute=4e-3)  # fmt: skip


def test_rows_of_cams_that_meet_a_cleat_squarely_are_one_cam_each(crossing):
    run = RecordedRun(deck(TEXT.replace("{contact_length: 100 mm}", "{contact_length: 100 mm, contact_width: 80 mm}")))
    np.testing.assert_allclose(run["elements/tyre/contact_force"], crossing["elements/tyre/contact_force"], atol=1e-4)


def test_no_energy_is_missing_on_an_oblique_cleat():
    """The lateral friction of a plane that leans dissipates; a step of half the length has less than half the error."""
    fewer, more = (RecordedRun(deck(OBLIQUE.replace("step: 1 ms", f"step: {h} ms"))) for h in (1.0, 0.25))
    errors = [np.ptp(run["energy/balance"]) for run in (fewer, more)]
    assert errors[1] < 0.4 * errors[0] < 1e-3 * np.ptp(fewer["energy/potential"])


ENDLESS = "'ground.profile.height' must be level before its first and beyond its last obstacle"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (TABLE, "height: {sine: {amplitude: 10 mm, frequency: 1}}", ENDLESS),
        (TABLE, "height: {table: {points: [[0, 0], [1, 0.1]], beyond: extend}}", ENDLESS),
        (TABLE, "height: {table: {points: [[0, 0], [400, 0.1]]}}", "at most 300 m are possible"),
        ("enveloping: {contact_length: 100 mm}", "", "has a jump or a corner at -0.0151 m"),
        ("type: wheel,", "type: flexible_wheel,", "'tire_law.enveloping' is available for the kinds wheel and"),
    ],
)
def test_what_a_tyre_cannot_envelop_is_refused(old, new, message):
    with pytest.raises(DeckError) as info:
        deck(TEXT.replace(old, new))
    assert any(message in problem.message for problem in info.value.problems)

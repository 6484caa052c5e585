"""Where wheels can go no further, or must not start: what the user is told, in the words of the deck."""

from dataclasses import replace

import numpy as np
import pytest
from marching import deck, input_deck

import mecano
from mecano.deck.read import deck_of_bytes
from mecano.elements import KINDS
from mecano.errors import ConvergenceError, DeckError
from mecano.run import run

WHEEL = """
    mecano: 1
    nodes:
      hub: {{position: [0, 0.1, {height}], orientation: [-0.5, 0, 0]}}
    elements:
      rim: {{type: rigid_body, node: hub, mass: 5.0, inertia: [0.1, 0.2, 0.1]}}
      tire: {{type: {kind}, node: hub, axis: [0, 0.877583, -0.479426], tire_law: rubber, ground: road}}
    tire_laws:
      rubber:
        radius: 0.3
        radial: {radial}
        radial_damping: 0.2
        friction: 0.9
        slip_regularization: 0.05
        lateral: {{moreland: {{lateral_stiffness: 1.0e5, lateral_damping: 200, yaw_coefficient: 3e-5, yaw_time: 1e-3}}}}
    grounds:
      road: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}, profile: {profile}}}
    time: {{end: 2.0, step: 1.0e-3}}
"""


def leaning(kind="wheel", height=0.2625, radial="{linear: {slope: 1.0e5}}", profile="null"):
    return deck(WHEEL.format(kind=kind, height=height, radial=radial, profile=profile))


@pytest.mark.parametrize("kind", ["rigid_wheel", "wheel", "flexible_wheel"])
def test_a_wheel_that_falls_over_ends_the_run(kind, tmp_path):
    """It lies flat where |n x a| falls to 0.1, as at the start; every step up to then is in the file."""
    fallen = input_deck("rolling_disc", "initial.velocities=[]") if kind == "rigid_wheel" else leaning(kind)
    name, path = "rim" if kind == "rigid_wheel" else "tire", tmp_path / "flat.h5"
    with pytest.raises(ConvergenceError, match=f"{kind} '{name}' lies flat: its axis has come along the normal"):
        run(fallen, path)
    results = mecano.open_results(path)
    lean = np.abs(results[f"elements/{name}/lean"].values)
    assert results.status == "failed" and "lies flat" in results.reason
    assert lean[:-1].max() < np.arccos(0.1) and len(lean) > 20


def test_a_wheel_without_slip_that_can_neither_stay_nor_leave_ends_the_run(tmp_path):
    """Near the top of a bump its normal force vanishes and its longitudinal force of 0.5 kN does not.

    Without it the wheel would go into the ground, with it the ground would have to pull.
    """
    settings = "elements.wheel.unilateral=true", "parameters.speed=25", "time.adaptive={tolerance: 1.0e-4}"
    path = tmp_path / "stuck.h5"
    with pytest.raises(ConvergenceError, match="(?s)'wheel' has met 'touch_down' .* 21 times.*that cannot slip"):
        run(input_deck("trailing_wheel_bump", *settings), path)
    with mecano.open_results(path) as results:
        assert results.time[-1] >= 0.07 and results["elements/wheel/friction_needed"].values[-1] > 0.5
        assert results["elements/wheel/normal_force"].values[-1] > 0.0


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"height": -0.01}, "the wheel's centre is 0.01 m below the ground"),
        ({"height": 0.3, "profile": "{direction: [0, 1, 0], height: 0.5}"}, "the wheel's centre is 0.2 m below"),
        ({"radial": "{polynomial: {coefficients: [0, 1.0e5, -1.0e6]}}"}, "'tire_law.radial' falls to -"),
    ],
)
def test_what_a_wheel_may_not_start_with(values, text):
    with pytest.raises(DeckError) as error:
        leaning(**values)
    assert "wheel 'tire'" in str(error.value) and text in str(error.value)


def test_a_law_that_softens_beyond_its_validity_may_be_used():
    soft = WHEEL.replace("radial_damping: 0.2", "valid_deformation: 0.09")
    values = {"kind": "wheel", "height": 0.2625, "radial": "{polynomial: {coefficients: [0, 1.0e5, -1.0e6]}}"}
    assert deck(soft.format(profile="null", **values)).values["tire_laws"]["rubber"]["valid_deformation"] == 0.09


def on(height, direction="[1, 0, 0]", end="time: {end: 2.0, step: 1.0e-3}", kind="rigid_wheel"):
    """The deck of a wheel of radius 0.3 m that rolls along x over a profile."""
    text = WHEEL.format(kind=kind, height=0.6, radial="{linear: {slope: 1.0e5}}",
                        profile=f"{{direction: {direction}, height: {height}}}")  # fmt: skip
    if kind == "rigid_wheel":
        text = text.replace("tire_law: rubber", "radius: 0.3")
    return deck(text.replace("time: {end: 2.0, step: 1.0e-3}", end))


@pytest.mark.parametrize(
    ("height", "fits", "place", "radius"),
    [
        # 1/(A (2 pi f)^2) in the troughs; s = -1/(4 f) is one
        ("{{sine: {{amplitude: {}, frequency: 2.0}}}}", 0.02, -0.125, 1 / (0.03 * (4 * np.pi) ** 2)),
        # (length/pi)^2/(2 height) at both ends
        ("{{bump: {{start: 5.0, length: 1.0, height: {}}}}}", 0.16, 5.0, 1 / (2 * 0.24 * np.pi**2)),
        # H'' = 6 rise/width^2 where the straight ends and the cubic begins
        ("{{table: {{points: [[0, 0], [8, 0], [9, {}], [10, 0], [11, 0]]}}}}", 0.5, 8.0, 1 / (6 * 0.75)),
        # the same bottom of a valley in a straight slope, where 1 + H'^2 = 1 still
        ("{{polynomial: {{coefficients: [0, 0, {}]}}}}", 1.6, 0.0, 1 / (2 * 2.4)),
    ],
    ids=["sine", "bump", "table", "polynomial"],
)
def test_hollows_must_be_wider_than_the_wheel(height, fits, place, radius):
    """Half as high again as one of nearly the radius of the wheel, 0.3 m: the closed form of the radius is told."""
    on(height.format(fits))
    with pytest.raises(DeckError) as error:
        on(height.format(1.5 * fits))
    text = str(error.value)
    assert f"hollow at {place:.5g} m whose radius, {radius:.4g} m, is less than that of the wheel, 0.3 m" in text
    assert "rigid_wheel 'tire'" in text
    [problem] = error.value.problems
    assert problem.mark.text[problem.mark.column - 1 :].startswith(height.format(1.5 * fits))
    heights = float(problem.hint.split()[1])
    assert 0.98 * radius / 0.3 < heights < radius / 0.3
    on(height.format(1.5 * fits * heights))


def test_a_hollow_counts_where_and_how_the_wheel_crosses_it():
    """Along its furrows no wheel meets a hollow; at 60 degrees to a sine the waves are twice as long, R is fourfold."""
    wave = "{sine: {amplitude: 0.03, frequency: 2.0}}"
    on(wave, direction="[0, 1, 0]")
    on(wave, direction="[1, 1.7320508, 0]", kind="flexible_wheel")
    with pytest.raises(DeckError, match="less than that of the wheel"):
        on(wave, direction="[1, 0.5, 0]", kind="flexible_wheel")


def test_a_wheel_is_checked_once():
    """Also one on waves, which are looked at for hollows behind the check of what the wheel says of itself."""
    told, wheel = [], KINDS["rigid_wheel"]
    counting = replace(wheel, check=lambda d, nodes: told.append(d) or wheel.check(d, nodes))
    text = on("{sine: {amplitude: 0.02, frequency: 2.0}}").text
    deck_of_bytes(text.encode(), "test.yaml", kinds={**KINDS, "rigid_wheel": counting})
    assert len(told) == 1


def test_of_a_random_road_the_way_of_the_run_counts():
    """Of a very rough road (five times class E of ISO 8608) the wheel meets narrow hollows only when it moves on."""
    road = "{random: {density: 0.02, lowest: 0.2, seed: 4}}"
    on(road, end="time: {end: 0.05, step: 1.0e-3}\n    initial: {velocities: [{nodes: all, velocity: [3, 0, 0]}]}")
    with pytest.raises(DeckError, match=r"; so have \d+ hollows between -0.3 and 20.\d+ m"):
        on(road, end="time: {end: 2, step: 1.0e-3}\n    initial: {velocities: [{nodes: all, velocity: [10, 0, 0]}]}")


@pytest.mark.parametrize("kind", ["skate", "plane_contact, radius: 0.1"])
def test_what_needs_a_plane_says_so_of_a_narrow_hollow(kind):
    text = f"{{type: {kind}, node: hub, ground: road" + (", axis: [0, 1, 0]}" if kind == "skate" else "}")
    whole = WHEEL.format(kind="wheel", height=0.6, radial="{linear: {slope: 1.0e5}}",
                         profile="{direction: [1, 0, 0], height: {sine: {amplitude: 0.1, frequency: 2}}}")  # fmt: skip
    before, _, after = whole.partition("      tire: ")
    with pytest.raises(DeckError, match="plane") as error:
        deck(f"{before}      tire: {text}\n{after.partition(chr(10))[2]}")
    assert len(error.value.problems) == 1


def test_errors_of_a_tire_law_stand_at_the_law():
    radial = "{polynomial: {coefficients: [0, 1.0e5, -1.0e6]}}"
    with pytest.raises(DeckError) as error:
        leaning(radial=radial)
    [problem] = error.value.problems
    assert problem.message.startswith("wheel 'tire': 'tire_law.radial' falls to -")
    assert problem.mark.text[problem.mark.column - 1 :].startswith(radial)
    with pytest.raises(DeckError) as error:
        deck(WHEEL.format(kind="flexible_wheel", height=0.2625, radial="{linear: {slope: 1.0e5}}", profile="null")
             .partition("        lateral:")[0] + "    time: {end: 1, step: 0.1}\n    grounds:\n      road: {plane: "
             "{point: [0, 0, 0], normal: [0, 0, 1]}}\n")  # fmt: skip
    [problem] = error.value.problems
    assert "flexible_wheel 'tire': 'tire_law.lateral' is missing" in problem.message
    assert problem.mark.text.strip() == "rubber:"

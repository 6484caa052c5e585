"""Limits of wheels, in motion and at the start: messages in the words of the deck."""

import re
from dataclasses import replace

import numpy as np
import pytest
from time_runs import deck, input_deck

import mecano
from mecano.analyses.dynamic import run
from mecano.analyses.prepare import prepare, startup_warnings
from mecano.constraints.tread import tread_above
from mecano.deck.read import deck_of_bytes
from mecano.elements import KINDS
from mecano.errors import AssemblyError, ConvergenceError, DeckError

WHEEL = """
    mecano: 1
    gravity: [0, 0, -9.81]
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
    with pytest.raises(ConvergenceError, match=f"{kind} '{name}' lies flat: its axis is along the normal"):
        run(fallen, path)
    results = mecano.open_results(path)
    lean, force = (np.abs(results[f"elements/{name}/{output}"].values) for output in ("lean", "normal_force"))
    assert results.status == "failed" and "lies flat" in results.reason
    assert lean[:-1][force[:-1] > 0.0].max() < np.arccos(0.1) and len(lean) > 20


def test_a_wheel_without_slip_that_can_neither_stay_nor_leave_ends_the_run(tmp_path):
    """Near the top of a bump its normal force vanishes and its longitudinal force of 0.5 kN does not.

    Without it the wheel would go into the ground, with it the ground would have to pull.
    """
    settings = "elements.wheel.unilateral=true", "parameters.speed=25", "time.adaptive={tolerance: 1.0e-4}"
    path = tmp_path / "stuck.h5"
    stuck = "(?s)'wheel' had the event '(touch_down|lift_off)' .* 21 times.*that cannot slip"
    with pytest.raises(ConvergenceError, match=stuck):
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
def test_errors_in_the_start_of_a_wheel(values, text):
    with pytest.raises(DeckError) as error:
        leaning(**values)
    assert "wheel 'tire'" in str(error.value) and text in str(error.value)


UPRIGHT = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {{hub: {{position: [0, 0, {height}]}}}}
    elements:
      disc: {{type: rigid_body, node: hub, mass: 10, inertia: [0.3, 0.5, 0.3]}}
      rim: {{type: {kind}, node: hub, axis: [0, 1, 0], radius: 0.3, ground: road}}
    {joints}
    grounds: {{road: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
    time: {{end: 0.1, step: 1.0e-3}}
"""
LEAVING = "rigid_wheel, unilateral: true"


def upright(kind, height, joints=""):
    return deck(UPRIGHT.format(kind=kind, height=height, joints=joints))


@pytest.mark.parametrize(
    ("kind", "height", "text"),
    [
        (LEAVING, 0.05, "the rim is 0.25 m below the ground at the start; it just touches with its node 0.25 m higher"),
        (LEAVING, 0.2996, "the rim is 0.0004 m below the ground"),
        ("rigid_wheel", 0.2, "the rim is 0.1 m below the ground"),
        ("rigid_wheel", 0.5, "the rim is 0.2 m above the ground at the start, but this wheel must touch it: lower "
         "its node by 0.2 m along the normal of the ground, or let it leave the ground ('unilateral: true')"),
        ("cardona_wheel", 0.2, "the rim is 0.1 m below the ground"),
        ("cardona_wheel", 0.5, "lower its node by 0.2 m along the normal of the ground"),
    ],
)  # fmt: skip
def test_a_rim_far_from_the_ground_is_refused(kind, height, text):
    with pytest.raises(DeckError) as error:
        upright(kind, height)
    assert f"{kind.split(',')[0]} 'rim': " in str(error.value) and str(error.value).count("the rim is") == 1
    assert text in str(error.value)


@pytest.mark.parametrize(
    ("kind", "height", "start"),
    [
        (LEAVING, 0.2998, 0.3), (LEAVING, 0.3002, 0.3), (LEAVING, 0.3004, 0.3004), (LEAVING, 0.5, 0.5),
        ("rigid_wheel", 0.28, 0.3), ("rigid_wheel", 0.32, 0.3), ("cardona_wheel", 0.28, 0.3),
    ],
)  # fmt: skip
def test_a_wheel_starts_on_the_ground_or_in_the_air(kind, height, start):
    """Within a thousandth of its radius it stands, and the displacement is reported; further up it is in the air."""
    prepared = prepare(upright(kind, height))
    assert prepared.state.z[2] == pytest.approx(start, abs=1e-12)
    reported = [text for text in startup_warnings(prepared) if "moved the initial positions" in text]
    gap = abs(height - start)
    moved = (
        f"the assembly moved the initial positions by up to {gap:.3g} m, to the nearest that satisfy the constraints"
    )
    assert len(reported) == (height != start)
    assert all(text.startswith(moved) and f"'rim' is most off, by {1e3 * gap:.3g} mm" in text for text in reported)
    in_air = "air" in {b.kind.phases[prepared.state.phases[b.first_phase]] for b in prepared.system.batches}
    assert in_air == (start > 0.3)


def test_a_wheel_that_the_assembly_brings_below_the_ground_closes_there():
    """Moved down by 0.2 m its rim touches, by more it cannot be."""
    moved = "joints: {{down: {{type: prescribed_position, node: hub, direction: [0, 0, 1], value: {}}}}}"
    assert prepare(upright(LEAVING, 0.5, moved.format(-0.1))).state.z[2] == pytest.approx(0.4)
    with pytest.raises(AssemblyError, match="rigid_wheel 'rim': radial force of the ground: off by"):
        prepare(upright(LEAVING, 0.5, moved.format(-0.25)))


def test_how_far_a_rim_is_above_the_ground():
    """A wheel that leans by 0.5 rad over a plane; one upright over the crest of a bump."""
    plane = {"point": [0, 0, 0], "normal": [0, 0, 2]}
    leaning_axis = [0, np.cos(0.5), np.sin(0.5)]
    gap, along_normal = tread_above({"plane": plane, "profile": None}, 0.3, 0.0, [1, 2, 0.5], leaning_axis)
    assert gap == pytest.approx(0.5 / np.cos(0.5) - 0.3) and along_normal == pytest.approx(0.5 - 0.3 * np.cos(0.5))
    bump = {"direction": [1, 0, 0], "height": (("bump", {"start": 1.0, "length": 4.0, "height": 0.1}),)}
    gaps = tread_above({"plane": plane, "profile": bump}, 0.3, 0.0, [3, 0, 0.3], [0, 1, 0])
    assert gaps == pytest.approx((-0.1, -0.1))


@pytest.mark.parametrize(
    ("w", "valid", "text"),
    [
        (0.16, "", "the rim is 0.16 m below the ground at the start, more than half of its radius of 0.3 m; it just "
         "touches with its node 0.1404 m higher"),
        (0.075, "valid_deformation: 0.07", "0.075 m below the ground at the start, its law is valid up to 0.07 m"),
    ],
)  # fmt: skip
def test_an_axle_too_low_for_the_law_of_its_tire_is_refused(w, valid, text):
    """Leaning by 0.5 rad the centre stands cos(0.5) r high; a deformation of 0.065 m is allowed without a word."""
    values = {"kind": "wheel", "radial": "{linear: {slope: 1.0e5}}", "profile": "null"}
    allowed = WHEEL.replace("radial_damping: 0.2", valid)
    deck(allowed.format(height=(0.3 - 0.065) * np.cos(0.5), **values))
    with pytest.raises(DeckError) as error:
        deck(allowed.format(height=(0.3 - w) * np.cos(0.5), **values))
    [problem] = error.value.problems
    assert "wheel 'tire': " in problem.message and text in problem.message


def test_a_law_that_softens_beyond_its_validity_may_be_used():
    soft = WHEEL.replace("radial_damping: 0.2", "valid_deformation: 0.09")
    values = {"kind": "wheel", "height": 0.2625, "radial": "{polynomial: {coefficients: [0, 1.0e5, -1.0e6]}}"}
    assert deck(soft.format(profile="null", **values)).values["tire_laws"]["rubber"]["valid_deformation"] == 0.09


def on(height, direction="[1, 0, 0]", end="time: {end: 2.0, step: 1.0e-3}", kind="rigid_wheel"):
    """The deck of a wheel of radius 0.3 m that rolls along x over a profile."""
    text = WHEEL.format(kind=kind, height=0.6, radial="{linear: {slope: 1.0e5}}",
                        profile=f"{{direction: {direction}, height: {height}}}")  # fmt: skip
    if kind == "rigid_wheel":
        text = text.replace("tire_law: rubber", "radius: 0.3, unilateral: true")
    return deck(text.replace("time: {end: 2.0, step: 1.0e-3}", end))


@pytest.mark.parametrize(
    ("height", "fits", "place", "radius"),
    [
        # 1/(A (2 pi f)^2) in the troughs; s = -1/(4 f) is one
        ("{{sine: {{amplitude: {}, frequency: 2.0}}}}", 0.02, -0.125, 1 / (0.03 * (4 * np.pi) ** 2)),
        # (length/pi)^2/(2 height) at both ends
        ("{{bump: {{start: 5.0, length: 1.0, height: {}}}}}", 0.16, 5.0, 1 / (2 * 0.24 * np.pi**2)),
        # the same far away, where the positions are rounded
        ("{{bump: {{start: 500.0, length: 0.1, height: {}}}}}", 0.0016, 500.0, 1 / (2 * 0.24 * np.pi**2)),
        # H'' = 6 rise/width^2 where the straight ends and the cubic begins
        ("{{table: {{points: [[0, 0], [8, 0], [9, {}], [10, 0], [11, 0]]}}}}", 0.5, 8.0, 1 / (6 * 0.75)),
        # the same bottom of a valley in a straight slope, where 1 + H'^2 = 1 still
        ("{{polynomial: {{coefficients: [0, 0, {}]}}}}", 1.6, 0.0, 1 / (2 * 2.4)),
    ],
    ids=["sine", "bump", "far bump", "table", "polynomial"],
)
def test_hollows_must_be_wider_than_the_wheel(height, fits, place, radius):
    """A hollow half as high again as one of nearly the radius of the wheel, 0.3 m, is refused with its radius."""
    on(height.format(fits))
    with pytest.raises(DeckError) as error:
        on(height.format(1.5 * fits))
    text = str(error.value)
    assert f"hollow at {place:.5g} m whose radius, {radius:.4g} m, is less than that of the wheel, 0.3 m" in text
    assert "rigid_wheel 'tire'" in text
    [problem] = error.value.problems
    assert problem.mark.text[problem.mark.column - 1 :].startswith(height.format(1.5 * fits))
    heights = float(re.search("heights by ([^ ]+)", problem.hint)[1])
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
    """Also one on waves, whose hollows are checked after the values of the wheel."""
    reported, wheel = [], KINDS["rigid_wheel"]
    counting = replace(wheel, check=lambda d, nodes: reported.append(d) or wheel.check(d, nodes))
    text = on("{sine: {amplitude: 0.02, frequency: 2.0}}").text
    deck_of_bytes(text.encode(), "test.yaml", kinds={**KINDS, "rigid_wheel": counting})
    assert len(reported) == 1


def test_of_a_random_road_the_way_of_the_run_counts():
    """Of a very rough road (five times class E of ISO 8608) the wheel meets narrow hollows only when it moves on."""
    road = "{random: {density: 0.02, lowest: 0.2, seed: 4}}"
    on(road, end="time: {end: 0.05, step: 1.0e-3}\n    initial: {velocities: [{nodes: all, velocity: [3, 0, 0]}]}")
    with pytest.raises(DeckError, match=r"; there are \d+ such hollows between -0.3 and 20.\d+ m"):
        on(road, end="time: {end: 2, step: 1.0e-3}\n    initial: {velocities: [{nodes: all, velocity: [10, 0, 0]}]}")


@pytest.mark.parametrize("kind", ["skate", "plane_contact, radius: 0.1"])
def test_kinds_that_need_a_plane_refuse_a_profile(kind):
    text = f"{{type: {kind}, node: hub, ground: road" + (", axis: [0, 1, 0]}" if kind == "skate" else "}")
    whole = WHEEL.format(kind="wheel", height=0.6, radial="{linear: {slope: 1.0e5}}",
                         profile="{direction: [1, 0, 0], height: {sine: {amplitude: 0.1, frequency: 2}}}")  # fmt: skip
    before, _, after = whole.partition("      tire: ")
    with pytest.raises(DeckError, match="plane") as error:
        deck(f"{before}      tire: {text}\n{after.partition(chr(10))[2]}")
    assert len(error.value.problems) == 1


def test_a_wheel_named_as_a_law_gets_a_hint():
    text = WHEEL.format(kind="flexible_wheel", height=0.2625, radial="{linear: {slope: 1.0e5}}", profile="null")
    with pytest.raises(DeckError) as error:
        deck(text.replace("friction: 0.9", "friction: adhesive"))
    [problem] = error.value.problems
    assert problem.message == "tire law 'rubber': unknown law 'adhesive'"
    assert problem.hint == "the deck has no 'laws'; there is the type 'adhesive_wheel'"


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


@pytest.mark.parametrize(
    ("points", "reported"),
    [("[0, 0.6], [70, -0.2]", "; it is -0.2 at 70"), ("[0, -0.6], [70, 0.2]", ""), ("[0, 0.6], [70, 0]", None)],
)
def test_friction_must_not_be_negative_at_any_point_of_its_curve(points, reported):
    change = f"tire_laws.linear.friction={{table: {{points: [{points}]}}}}"
    if reported is None:
        assert input_deck("wheel_spin_up", change)
        return
    with pytest.raises(DeckError) as info:
        input_deck("wheel_spin_up", change)
    assert info.value.problems[0].message.endswith(f"'tire_law.friction' must not be negative{reported}")


@pytest.mark.parametrize("kind", ["wheel", "flexible_wheel"])
@pytest.mark.parametrize("given", ["", "string and relaxation"])
def test_a_lateral_law_has_one_form(kind, given):
    """Also where no wheel uses it."""
    cornering = "cornering_stiffness: 3, relaxation_length: 1"
    forms = given and f", string: {{{cornering}, contact_length: 0.1}}, relaxation: {{{cornering}}}"
    head = WHEEL.format(kind=kind, height=0.2625, radial="{linear: {slope: 1.0e5}}", profile="null")
    text = head.partition("        lateral:")[0] + (
        f"        lateral: {{relaxation_in_air: 0.01{forms}}}\n    time: {{end: 1, step: 0.1}}\n    grounds:\n"
        "      road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}\n"
    )
    with pytest.raises(DeckError) as error:
        deck(text)
    [problem] = error.value.problems
    assert "tire law 'rubber': lateral: give exactly one of 'matrices', 'moreland', 'relaxation'" in problem.message
    assert problem.message.endswith("; it has 'relaxation', 'string'" if given else "'straight_tangent'")


@pytest.mark.parametrize("kind", ["wheel", "flexible_wheel"])
def test_a_retracting_wheel_passes_through_lying_flat(kind, tmp_path):
    """A strut swings its wheel to 1.7 rad in the air, past the horizontal: |s| reaches 1.

    No moment about its axis acts on the wheel: its spin of 50 rad/s stays.
    """
    swinging = f"""
    mecano: 1
    gravity: none
    nodes:
      pin: {{position: [0, 0, 2.0]}}
      axle: {{position: [0, 0, 1.0]}}
      hub: {{position: [0, 0, 1.0]}}
    elements:
      leg: {{type: rigid_body, node: pin, mass: 10, inertia: [1, 1, 1], attached: [axle]}}
      rim: {{type: rigid_body, node: hub, mass: 5.0, inertia: [0.2, 0.2, 0.2]}}
      tire: {{type: {kind}, node: hub, axis: [0, 1, 0], tire_law: rubber, ground: road}}
    joints:
      trunnion: {{type: hinge, nodes: [ground, pin], axis: [1, 0, 0]}}
      jack: {{type: prescribed_angle, nodes: [ground, pin], axis: [1, 0, 0],
             value: {{polynomial: [0, 1.7]}}}}
      bearing: {{type: hinge, nodes: [axle, hub], axis: [0, 1, 0]}}
    tire_laws:
      rubber: {{radius: 0.3, radial: {{linear: {{slope: 1.0e5}}}}, friction: 0.9, slip_regularization: 0.05,
               lateral: {{relaxation: {{cornering_stiffness: 1.0e4, relaxation_length: 0.3}}}}}}
    grounds:
      road: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}
    initial:
      velocities: [{{nodes: [hub], angular_velocity: [0, 50, 0], about: own}}]
    time: {{end: 1.0, step: 1.0e-2}}
    """
    path = tmp_path / "bay.h5"
    run(deck(swinging), path)
    with mecano.open_results(path) as results:
        assert results.status == "complete"
        lean = results["elements/tire/lean"].values
        assert np.abs(lean).max() > 1.55 and abs(lean[-1]) == pytest.approx(np.pi - 1.7, abs=1e-6)
        np.testing.assert_allclose(results["elements/tire/spin_rate"].values, 50.0, rtol=1e-5)


def test_a_wheel_that_starts_flat_in_the_air_is_allowed_and_one_near_the_ground_is_not():
    start = WHEEL.replace("orientation: [-0.5, 0, 0]", "orientation: ['=-pi/2', 0, 0]")
    start = start.replace("axis: [0, 0.877583, -0.479426]", "axis: [0, 0, -1]")
    settings = {"kind": "flexible_wheel", "radial": "{linear: {slope: 1.0e5}}", "profile": "null"}
    prepared = prepare(deck(start.format(height=0.61, **settings)))
    assert prepared.system is not None
    with pytest.raises(DeckError, match="lies flat"):
        prepare(deck(start.format(height=0.59, **settings)))

"""Tyre data unsuitable for a sliding or twisting patch: warnings before a run, and their repetition in failures."""

import numpy as np
import pytest
from time_runs import deck, input_deck
from towed_wheel import MORELAND, SIGMA, SPEED, SPIN_INERTIA, STRING, towed

from mecano.analyses.dynamic import run
from mecano.analyses.failure_text import failure_text
from mecano.analyses.prepare import prepare, warnings_of
from mecano.errors import ConvergenceError
from mecano.results.reader import open_results

KAP, ROLLING = 1e4, float(np.radians(5.0))


def test_a_law_whose_rates_run_away_is_warned_of():
    """A1 of Moreland's law has a negative symmetric part below C1 = kap C^2 D/4: 2e-5 s here."""
    (found,) = towed(MORELAND % (500.0, 1.9e-5, KAP), led="down and up").warnings
    assert found.message.startswith(
        "tire law 'rubber': 'lateral.moreland.yaw_time' is 1.9e-05 s, less than torsional_stiffness yaw_coefficient^2 "
        "lateral_damping/4 = 2e-05 s: the rates of a sliding patch may grow without bound"
    )
    assert found.mark.text.strip().startswith("lateral: {moreland")
    assert towed(MORELAND % (500.0, 2.1e-5, KAP), led="down and up").warnings == ()
    full = "{{matrices: {{stiffness: [7e5, 0, 0, 1e4], damping: [9, 0, -{0}, 4]}}}}"
    found = [towed(full.format(mixed), led="down and up").warnings for mixed in (11.9, 12.1)]
    assert list(map(len, found)) == [0, 1]  # 9 x 4 = (12/2)^2


@pytest.mark.parametrize(("share", "warned"), [(0.9, True), (1.1, False)])
def test_a_twist_that_swings_with_the_spin_is_warned_of(share, warned):
    """Routh's bound for the slip angle of the start, with the radius of the tyre without load, leaning or not."""
    y, r = ROLLING * SIGMA, 0.45
    needed = SPEED * SPIN_INERTIA * y * y / (SIGMA * r * r * KAP)
    for lean in (0.0, 10.0):
        law = MORELAND % (0.0, share * needed, KAP)
        found = warnings_of(prepare(towed(law, angle=ROLLING, lean=lean, led="down and up")))
        said = [text for text in found if "body of revolution" not in text]  # the rim does not lean
        assert len(said) == warned
        for text in said:
            assert "flexible_wheel 'tire': rolling at its initial slip angle, 5 deg at 60 m/s" in text
            assert f"'tire_law.lateral.moreland.yaw_time' ({share * needed:g} s) is more than {needed:.2g} s" in text


def test_a_wheel_that_starts_backward_or_deep_is_warned_of():
    """At 60 m/s with the axis reversed; 82.5 mm deep with 1.2 MN/m. Nothing is said of a wheel in place."""
    reverse = "elements.%s.axis=[0, -1, 0]"
    (said,) = warnings_of(prepare(input_deck("wheel_spin_up", reverse % "tire")))
    assert (
        "wheel 'tire': it starts backward, at 60 m/s against its forward direction [-1, 0, 0], which is 'axis'" in said
    )
    assert said.endswith("with 'axis: [0, 1, 0]' it rolls forward")
    deep = [f"nodes.{node}.position=[0, 0, 0.24]" for node in ("fork", "hub")]
    (said,) = warnings_of(prepare(input_deck("wheel_spin_up", *deep)))
    assert "its tyre starts 82.5 mm deep in the ground, 0.26 of its radius, which pushes with 9.9e+04 N; it" in said
    assert said.endswith("just touches with its node 82.5 mm higher along the normal of the ground")
    assert len(warnings_of(prepare(input_deck("wheel_spin_up", reverse % "tire", *deep)))) == 2
    for speed in ("-60", "0"):
        assert warnings_of(prepare(input_deck("wheel_spin_up", reverse % "tire", f"parameters.speed={speed}"))) == []
    (said,) = warnings_of(prepare(input_deck("wheel_spin_up", "gravity=[0, 0, 9.81]")))
    assert "wheel 'tire': 'gravity' [0, 0, 9.81] pulls it off its ground, whose normal [0, 0, 1]" in said
    for lean, warned in ((59, 0), (61, 1)):
        gravity = f"gravity=[0, {9.81 * np.sin(np.radians(lean))}, {-9.81 * np.cos(np.radians(lean))}]"
        said = warnings_of(prepare(input_deck("wheel_spin_up", gravity)))
        assert ["hardly presses it onto its ground, whose normal [0, 0, 1]" in text for text in said] == [True] * warned
    for name, wheel in (("step_slip", "tire"), ("nose_landing_gear", "wheel")):  # a transient and a flexible wheel
        warnings = warnings_of(prepare(input_deck(name, reverse % wheel)))
        assert any("it starts backward" in said for said in warnings)


@pytest.mark.parametrize(("spin", "warned"), [(-0.6, True), (-0.4, False), (1.0, False)])
def test_a_wheel_that_spins_against_its_rolling_is_warned_of(spin, warned):
    """A share of the spin of rolling, 60 m/s over the radius; one of an aircraft that lands does not spin."""
    rolling = 60.0 / 0.3225
    forward = "{nodes: all, velocity: [60, 0, -3.05]}"
    turning = f"[{forward}, {{nodes: [hub], angular_velocity: [0, {spin * rolling}, 0]}}]"
    said = warnings_of(prepare(input_deck("wheel_spin_up", f"initial.velocities={turning}")))
    expected = f"wheel 'tire': it starts forward, at 60 m/s, but spins backward, at {-spin * rolling:.4g} rad/s about"
    assert [expected in text for text in said] == [True] * warned


@pytest.mark.parametrize(("height", "spin", "warned"), [(0.315, 0.0, 1), (0.315, 120.0, 0), (0.3225, 0.0, 0)])
def test_a_loaded_wheel_that_does_not_spin_is_warned_of(height, spin, warned):
    """7.5 mm deep in the ground at 60 m/s, where it rolls at 186 rad/s; a wheel that just touches may land."""
    nodes = [f"nodes.{node}.position=[0, 0, {height}]" for node in ("fork", "hub")]
    turning = f"[{{nodes: all, velocity: [60, 0, 0]}}, {{nodes: [hub], angular_velocity: [0, {spin}, 0]}}]"
    said = warnings_of(prepare(input_deck("wheel_spin_up", *nodes, f"initial.velocities={turning}")))
    expected = (
        "it starts at 60 m/s on its tyre deformed by 7.5 mm, and spins at 0 rad/s: it slides until it is spun up to"
    )
    assert [expected in text for text in said] == [True] * warned


def test_a_wheel_that_cannot_spin_is_warned_of():
    """On a guide to the ground; not one that is locked on purpose, as that of icy_runway.yaml."""
    guide = "joints.locked={type: prismatic, nodes: [ground, hub], axis: [1, 0, 0]}"
    (said,) = (w for w in input_deck("icy_runway", guide).warnings if "turn" in w.message)
    assert said.message == (
        "wheel 'tire': its node 'hub' cannot turn, so the wheel slides; is a hinge about [0, 1, 0] missing?"
    )
    assert str(said.mark).endswith("icy_runway.yaml:14:3") and input_deck("icy_runway").warnings == ()


def test_a_wheel_beside_its_bearing_or_without_one_is_warned_of():
    (said,) = warnings_of(prepare(input_deck("wheel_spin_up", "elements.tire.node=fork")))
    assert "lets node 'hub' spin, and nothing is on it: is the wheel meant to be there, not on 'fork'?" in said
    said = warnings_of(prepare(input_deck("wheel_spin_up", "joints.bearing=null")))
    assert any("no joint or member holds its node 'hub'; is a bearing missing?" in text for text in said)


@pytest.mark.parametrize(
    ("inertia", "turned", "warned"),
    [
        ("[1.2, 2.0, 1.2]", "[0, 0, 0]", True),
        ("[1.2, 2.0, 1.2]", "[0, 0, 0.3]", False),
        ("[1.2, 2.0, 1.2, 0, 0, 0]", "[0, 0, 0.25]", False),
        ("[1.2, 1.3, 1.2]", "[0, 0, -0.3]", True),
        ("[2.0, 2.0, 2.0]", "[0, 0, 0]", False),
        ("[1.2, 2.0, 1.3]", "[0, 0, 0]", False),
    ],
)
def test_a_wheel_whose_body_is_not_turned_with_its_axis_is_warned_of(inertia, turned, warned):
    """Steered by 0.3 rad; toe of less than 0.1 rad is not warned of, nor are bodies without an axis of revolution."""
    axis = "[-0.29552, 0.955336, 0]"
    steered = [f"elements.tire.axis={axis}", f"joints.bearing.axis={axis}", f"nodes.hub.orientation={turned}"]
    said = [w.message for w in input_deck("wheel_spin_up", *steered, f"elements.rim.inertia={inertia}").warnings]
    assert [text.startswith("rigid_body 'rim': the body of revolution") for text in said] == [True] * warned, said


@pytest.mark.parametrize(
    ("axis", "said"),
    [
        ([0, 1, 0], None),
        ([0, -1, 0], "it starts backward, at 15 m/s against its forward direction [-1, 0, 0]"),
        ([1, 0, 0], "it starts sideways, at 15 m/s across its forward direction [0, -1, 0]"),
    ],
)
def test_a_wheel_that_is_to_run_astray_is_warned_of_before_steady_running_is_solved(axis, said):
    """The velocity of steady running counts, although the nodes of the deck are at rest."""
    speed = "parameters.speed=15"
    warnings = warnings_of(prepare(input_deck("caster_shimmy", speed, f"elements.tire.axis={axis}")))
    assert [said in text for text in warnings if "it starts" in text] == ([True] if said else [])
    assert any("the wheel cannot spin" in text for text in warnings) == (axis == [1, 0, 0])


@pytest.mark.parametrize(("law", "one_way"), [(STRING, True), (MORELAND % (500.0, 2e-3, KAP), False)])
def test_a_law_for_rolling_forward_is_named(law, one_way):
    (said,) = (text for text in warnings_of(prepare(towed(law, angle=np.pi))) if "it starts backward" in text)
    assert ("as 'tire_law.lateral' holds for rolling forward; with 'axis" in said) == one_way


def test_a_wheel_on_a_body_that_starts_backward_or_deep_is_warned_of():
    """On the deck of a ship, relative to it; 3.36 m is the height at which the tyre just touches the deck."""
    place = "nodes.hub.position=[0, 0, %g]"
    velocity = "initial.velocities.1={nodes: [hub], velocity: [4, 0, 0]}"
    (said,) = warnings_of(prepare(input_deck("ship_deck", "elements.wheel.axis=[0, -1, 0]", velocity)))
    assert "it starts backward, at 4 m/s against its forward direction [-1, 0, 0]" in said
    (said,) = warnings_of(prepare(input_deck("ship_deck", place % 3.26)))
    assert "its tyre starts 100 mm deep in the ground, 0.28 of its radius, which pushes with 4e+04 N; it" in said
    assert warnings_of(prepare(input_deck("ship_deck", velocity))) == []
    on_ground = "elements.wheel.nodes=[ground, hub]"
    assert len(warnings_of(prepare(input_deck("ship_deck", on_ground, place % 3.26)))) == 1


@pytest.mark.parametrize("name", ["nose_landing_gear", "step_steer", "caster_shimmy"])
def test_no_warning_of_good_tyres(name):
    assert warnings_of(prepare(input_deck(name))) == []


def test_a_failure_says_what_to_try_in_the_elements_that_failed():
    """With the warnings on them, once each; nothing on elements that did not fail."""
    error = ConvergenceError("no step")
    warnings = ["flexible_wheel 'tire': soft", "flexible_wheel 'tire': soft", "rigid_body 'rim': light"]
    given = towed(STRING)
    assert failure_text(error, given, warnings) == "no step"
    error.elements = ("flexible_wheel 'tire'", "hinge 'bearing'")
    assert failure_text(error, given, warnings).splitlines() == [
        "no step",
        "flexible_wheel 'tire' is at test.yaml:10:3",
        "hinge 'bearing' is at test.yaml:17:3",
        "in flexible_wheel 'tire': a greater 'tire_law.lateral.string.torsional_stiffness' (now 10000 N m/rad); a "
        "greater 'tire_law.slip_regularization' (now 0.1 m/s); a greater "
        "'tire_law.lateral.relaxation_in_air' (now 0.001 s), for a leaning wheel that leaves the "
        "ground and meets it again at once",
        "warning: flexible_wheel 'tire': soft",
    ]


def test_a_failure_repeats_the_warnings_about_its_nodes():
    error, light = ConvergenceError("no step"), "deck.yaml:7:3: node rim: nothing gives mass to its rotation"
    error.places = ("node rim",)
    assert failure_text(error, towed(STRING), [light, "node rim2: light"]).splitlines() == [
        "no step",
        f"warning: {light}",
    ]


def test_a_failed_run_repeats_its_warnings(tmp_path):
    """Newton's method may not iterate, so that the patch, which is stiff, cannot be followed."""
    text = towed(MORELAND % (0.0, 1e-5, KAP), led="down and up").text
    given = deck(text.replace("maximum_step: 1.0e-3}", "minimum_step: 1.0e-5}, newton: {maximum_iterations: 1}"))
    with pytest.raises(ConvergenceError) as error:
        run(given, tmp_path / "r.h5")
    said = str(error.value)
    assert (
        "in flexible_wheel 'tire': a greater 'tire_law.lateral.moreland.torsional_stiffness' (now 10000 N m/rad); "
        in said
    )
    assert "a greater 'tire_law.lateral.moreland.yaw_time' (now 1e-05 s)" in said
    assert said.count("warning: test.yaml:") == 1 and "oscillate with growing amplitude" in said


@pytest.mark.parametrize(("end", "touched"), [(0.002, False), (0.5, True)])
def test_a_run_in_which_no_wheel_touches_its_ground_is_warned_of(end, touched, tmp_path):
    run(input_deck("wheel_drop", f"time.end={end}"), tmp_path / "r.h5")
    with open_results(tmp_path / "r.h5") as results:
        assert any("no wheel touched its ground" in text for text in results.warnings) != touched


@pytest.mark.parametrize(("speed", "warned"), [(1.0, False), (-1.0, True), (0.0, True)])
def test_a_gear_that_is_retracted_need_not_touch_the_ground(speed, warned, tmp_path):
    """A leg of 1 m with its wheel, hinged 3 m above the ground, turns by 0.5 rad from the vertical or towards it."""
    at = -0.6 if speed < 0 else 0.0
    given = deck(f"""
mecano: 1
gravity: none
nodes: {{leg: {{position: [0, 0, 3]}}, axle: {{position: ['sin({at})', 0, '3-cos({at})']}}}}
elements:
  leg: {{type: rigid_body, node: leg, mass: 20, inertia: [1, 1, 1], attached: [axle]}}
  tyre: {{type: wheel, node: axle, axis: [0, 1, 0], ground: runway, tire_law: tyre}}
joints:
  pintle: {{type: hinge, nodes: [ground, leg], axis: [0, -1, 0]}}
  drive: {{type: prescribed_angle, nodes: [ground, leg], axis: [0, -1, 0], value: {{linear: {{slope: {abs(speed)}}}}}}}
tire_laws: {{tyre: {{radius: 0.3, radial: {{polynomial: [0, 5e5]}}, friction: 0.8, slip_regularization: 0.1}}}}
grounds: {{runway: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
time: {{end: 0.5, step: 10 ms}}
""")
    run(given, tmp_path / "r.h5")
    with open_results(tmp_path / "r.h5") as results:
        assert any("no wheel touched its ground" in text for text in results.warnings) == warned

"""Modes about the equilibrium near a moving state: `mecano modes --at ... --at-rest`."""

import numpy as np
import pytest
import scipy.linalg as la
from equilibria import arm
from time_runs import INPUTS, deck

from mecano.analyses.dynamic import run
from mecano.analyses.modal import modes
from mecano.analyses.operating_point import operating_point
from mecano.analyses.static import run as run_static
from mecano.cli import commands
from mecano.commands.solving import About
from mecano.deck.read import read_deck
from mecano.errors import ConvergenceError, ResultsError, UsageError
from mecano.post.pictures import draw_alone

FOLDED = 0.9 * np.pi
ROOT, FLAP = 8.0, 3.0  # N m/rad
ELBOW = 6


def array(process, end=3.0):
    """Two rods of 1 m, folded, that a spring opens until its latch locks them; a flap swings at their end.

    Springs at the root and at the flap are unstressed where all is straight.
    """
    x, y = float(1.0 + np.cos(FOLDED)), float(-np.sin(FOLDED))
    return f"""
        mecano: 1
        gravity: [0, 0, 0]
        nodes:
          root: {{position: [0, 0, 0]}}
          elbow: {{position: [1, 0, 0]}}
          tip: {{position: [1, 0, 0], orientation: [0, 0, -{FOLDED!r}]}}
          edge: {{position: [{x!r}, {y!r}, 0], orientation: [0, 0, -{FOLDED!r}]}}
          flap: {{position: [{x!r}, {y!r}, 0], orientation: [0, 0, -{FOLDED!r}]}}
        elements:
          inner: {{type: rigid_body, node: root, mass: 1, center_of_mass: [0.5, 0, 0],
                  inertia: [1.0e-4, {1 / 12!r}, {1 / 12!r}], attached: [elbow]}}
          outer: {{type: rigid_body, node: tip, mass: 1, center_of_mass: [0.5, 0, 0],
                  inertia: [1.0e-4, {1 / 12!r}, {1 / 12!r}], attached: [edge]}}
          flap: {{type: rigid_body, node: flap, mass: 0.5, center_of_mass: [0.4, 0, 0], inertia: [1.0e-4, 0.02, 0.02]}}
        joints:
          root: {{type: hinge, nodes: [ground, root], axis: [0, 0, 1], turning_law: {{spring: {{stiffness: {ROOT}}}}}}}
          elbow: {{type: hinge, nodes: [elbow, tip], axis: [0, 0, 1], turning_law: {{spring: {{stiffness: {ELBOW}}}}},
                  natural_angle: {FOLDED!r}, latch: {{angle: {FOLDED!r}}}}}
          edge: {{type: hinge, nodes: [edge, flap], axis: [0, 0, 1], turning_law: {{spring: {{stiffness: {FLAP}}}}}}}
        {process}
        """


def latched():
    """Circular frequencies of the locked rods with the flap, straight: two motions, root and flap."""
    at_flap = np.array([2.4, 0.4])  # velocity of its centre by the rates of root and flap
    M = 0.5 * np.outer(at_flap, at_flap) + 0.02 * np.ones((2, 2)) + np.diag([2.0 * 2.0**2 / 3.0, 0.0])
    return np.sqrt(la.eigvalsh(np.diag([ROOT, FLAP]), M))


@pytest.fixture(scope="module")
def swinging(tmp_path_factory):
    """The deck of the array and its results, while it unfolds and after it has latched."""
    path, checked = tmp_path_factory.mktemp("array") / "array.h5", deck(array("time: {end: 2.0, step: 2.0e-3}"))
    run(checked, path)
    return checked, path


def test_a_latched_array_that_swings(swinging):
    """At rest it does not flutter, and the latch holds; the modes of the instant seem to be damped and to grow."""
    checked, path = swinging
    _, instant, base = modes(checked, None, at=f"{path}:2.0")
    assert np.abs(base.state.v).max() > 0.5 and len(instant.values) == 2
    assert np.abs(instant.values.real).max() > 0.02 * np.abs(instant.values).max()
    text, found, base = modes(checked, None, at=f"{path}:2.0", at_rest=True)
    np.testing.assert_allclose(found.values, 1j * latched(), rtol=1e-8)
    assert np.abs(base.state.v).max() == 0.0
    assert "equilibrium at rest near" in text and "not constant" not in text and "flutter" not in text


@pytest.mark.parametrize("time", [-0.5, 9.0])
def test_no_saved_state_beyond_the_run_is_taken(swinging, time):
    checked, path = swinging
    with pytest.raises(UsageError, match=f"has saved states from 0 to 2 s, and none near {time:g} s"):
        modes(checked, None, at=f"{path}:{time}")


def test_before_the_latch_the_elbow_is_free(swinging):
    """The modes of the unlatched array at rest are those of the same deck in static equilibrium, where it unfolds."""
    checked, path = swinging
    _, found, _ = modes(checked, None, at=f"{path}:0.1", at_rest=True)
    text = array("static: {method: relaxation}").replace(f", latch: {{angle: {FOLDED!r}}}", "")
    _, expected, _ = modes(deck(text), None)
    assert len(found.values) == 3
    np.testing.assert_allclose(found.values, expected.values, rtol=1e-7)


def test_events_that_would_happen_at_rest_are_reported(swinging):
    """Before it latches the elbow rests where the latch would close."""
    checked, path = swinging
    text, _, _ = modes(checked, None, at=f"{path}:0.1", at_rest=True)
    assert "these events" not in text  # it rests at the angle of the latch, not beyond it
    push = "loads: {push: {type: couple, nodes: [elbow, tip], axis: [0, 0, 1], value: 0.5}}\n        time:"
    beyond = deck(array("time: {end: 2.0, step: 2.0e-3}").replace("time:", push))
    text, _, _ = modes(beyond, None, at=f"{path}:0.1", at_rest=True)
    assert "at rest these events would occur, and were ignored: hinge 'elbow' (" in text.replace("\nmecano: ", " ")


def test_where_there_is_no_rest(tmp_path):
    """A pendulum without a pivot falls; one of statics rests already."""
    text = """
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {a: {position: [0, 0, 0]}}
        elements: {m: {type: point_mass, node: a, mass: 1}}
        time: {end: 0.1, step: 0.01}
        """
    run(deck(text), tmp_path / "fall.h5")
    with pytest.raises(ConvergenceError, match="no equilibrium was found at t 0.1 s"):
        operating_point(deck(text), str(tmp_path / "fall.h5"), at_rest=True)
    static = deck(arm("static: {}"))
    run_static(static, tmp_path / "arm.h5")
    with pytest.raises(UsageError, match="omit --at-rest"):
        operating_point(static, str(tmp_path / "arm.h5"), at_rest=True)


def test_a_driven_mechanism_without_an_equilibrium_is_explained(tmp_path):
    """The shafts of a differential turn on however large the drag: the error says what they do."""
    given = read_deck(INPUTS / "differential.yaml")
    run(given, tmp_path / "r.h5")
    with pytest.raises(ConvergenceError, match=r"was found at t 1.5 s: it moves by more than 0.3 in a step"):
        operating_point(given, str(tmp_path / "r.h5"), at_rest=True)


def test_at_rest_on_the_command_line(swinging, tmp_path, capsys):
    import click

    checked, path = swinging
    file = tmp_path / "array.yaml"
    file.write_text(checked.text)
    commands(
        ["modes", str(file), "--at", f"{path}:2.0", "--at-rest", "-o", str(tmp_path / "m.h5")], standalone_mode=False
    )
    assert "modes about: equilibrium at rest near" in capsys.readouterr()[0]
    assert [About(at, rest).suffix for at, rest in ((None, False), ("a:b.h5:0.25", False), ("b.h5:2.0", True))] == [
        "", "_at_0.25", "_at_rest_2.0"
    ]  # fmt: skip
    with pytest.raises(click.BadParameter, match="belongs to --at"):
        commands(["modes", str(file), "--at-rest"], standalone_mode=False)
    with pytest.raises(click.BadParameter, match="use --set initial.from=FILE:TIME"):
        commands(["modes", str(file), "--at", f"{path}:2.0", "--sweep", "time.step=1,2"], standalone_mode=False)


def test_where_nothing_moves_there_are_no_shapes_to_draw(tmp_path, capsys):
    """A mass guided in three directions has no mode: the command says so, and its file has no picture."""
    file, modes_file = tmp_path / "fixed.yaml", tmp_path / "m.h5"
    file.write_text(
        "mecano: 1\ngravity: none\nnodes: {a: {position: [1, 0, 0]}}\n"
        "elements: {m: {type: point_mass, node: a, mass: 1}}\njoints:\n"
        "  x: {type: prescribed_position, node: a, direction: [1, 0, 0], value: 0}\n"
        "  y: {type: prescribed_position, node: a, direction: [0, 1, 0], value: 0}\n"
        "  z: {type: prescribed_position, node: a, direction: [0, 0, 1], value: 0}\ntime: {end: 0.1, step: 0.01}\n"
    )
    commands(["modes", str(file), "--plot", "-o", str(modes_file)], standalone_mode=False)
    assert capsys.readouterr()[0].rstrip().endswith("\nnothing moves, so there are no shapes to draw")
    assert not modes_file.with_suffix(".png").exists()
    with pytest.raises(ResultsError, match="nothing moves"):
        draw_alone(modes_file)


def test_a_model_without_mass_has_no_modes():
    """A prestressed net of cables without mass, by either solver: it has stiffness alone."""
    net = deck("""
        mecano: 1
        gravity: none
        nodes:
          left: {position: [0, 0, 0], fixed: true}
          middle: {position: [1, 0, 0]}
          right: {position: [2, 0, 0], fixed: true}
        elements:
          a: {type: cable, nodes: [left, middle], axial_stiffness: 1000, pretension: 10}
          b: {type: cable, nodes: [middle, right], axial_stiffness: 1000, pretension: 10}
        static: {steps: 1}
        """)
    for solver in ("dense", "sparse"):
        text, found, _ = modes(net, None, method=solver)
        assert len(found.values) == 0 and "nothing has inertia or damping; 0 computed" in text.splitlines()[0]


def test_a_drive_at_its_turning_point_is_at_rest():
    """Its velocity, a cosine of 90 degrees, is rounding: a turn by 1 rad would take an age, and the pendulum falls."""
    text, _, _ = modes(
        deck("""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {support: {position: [0, 0, 0.01]}, pin: {position: [0, 0, 0.01]}}
        elements:
          support: {type: rigid_body, node: support, mass: 1, inertia: [0.01, 0.01, 0.01]}
          bar: {type: rigid_body, node: pin, mass: 0.1, center_of_mass: [0.1, 0, 0], inertia: [1.0e-4, 1.0e-3, 1.0e-3]}
        joints:
          guide: {type: prismatic, nodes: [ground, support], axis: [0, 0, 1]}
          shaker:
            type: prescribed_position
            node: support
            direction: [0, 0, 1]
            value: {sine: {amplitude: 10 mm, frequency: 60, phase: 90 deg, offset: -10 mm}}
          hinge: {type: hinge, nodes: [support, pin], axis: [0, 1, 0]}
        time: {end: 1, step: 1 ms}
        """),
        None,
    )
    assert "the start is not an equilibrium" in text and "not constant in these axes" not in text


@pytest.mark.parametrize(("rate", "changes"), [(1.0, True), (1e-6, False)])
def test_a_mechanism_that_has_all_but_come_to_rest_has_constant_modes(rate, changes):
    """A bar that is held by an oblique spring; at 1e-6 rad/s it turns by a radian in eleven days."""
    text = modes(
        deck(f"""
        mecano: 1
        gravity: none
        nodes:
          hook: {{position: [1, 0, 2], fixed: true}}
          bar: {{position: [0, 0, 0]}}
          tip: {{position: [1, 0, 0]}}
        elements:
          bar: {{type: rigid_body, node: bar, mass: 1, inertia: [0.1, 0.2, 0.3], attached: [tip]}}
          spring: {{type: spring_damper, nodes: [hook, tip], law: {{spring: 100}}}}
        joints: {{hinge: {{type: hinge, nodes: [ground, bar], axis: [0, 1, 0]}}}}
        initial: {{velocities: [{{nodes: [bar, tip], about: [0, 0, 0], angular_velocity: [0, {rate}, 0]}}]}}
        time: {{end: 1, step: 1 ms}}
        """),
        None,
    )[0]
    assert ("they change by" in text) == changes


def test_a_mechanism_without_forces_is_free_at_rest(tmp_path):
    """Reactions of 1e-31 N are rounding, and so is the stiffness that they cause, of either sign."""
    four_bar = read_deck(INPUTS / "four_bar.yaml", ("gravity=none", "time.end=0.3", "output.every=0.1"))
    run(four_bar, tmp_path / "four_bar.h5")
    _, found, base = modes(four_bar, None, at=f"{tmp_path / 'four_bar.h5'}:0.3", at_rest=True)
    assert found.kinds == ["free"] and found.values.tolist() == [0.0]
    assert "1 direction(s) without stiffness" in base.warnings[-1] and len(base.warnings) == 2


def test_what_is_strained_later_is_not_strained_at_the_start(tmp_path):
    """A damper without a spring has its length at the start as its natural one; 0.3 s later it is twice as long."""
    falling = deck("""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {top: {position: [0, 0, 0.2], fixed: true}, bob: {position: [0, 0, 0]}}
        elements:
          bob: {type: point_mass, node: bob, mass: 1}
          damper: {type: spring_damper, nodes: [top, bob], law: {damper: 0.1}}
        time: {end: 0.3, step: 0.01}
        """)
    run(falling, tmp_path / "falling.h5")
    assert operating_point(falling, f"{tmp_path / 'falling.h5'}:0.3").warnings == ()


@pytest.mark.parametrize(("time", "reported"), [(0.0, True), (1.0, False)])
def test_a_saved_state_at_rest_that_is_no_equilibrium_is_reported(swinging, time, reported):
    """Folded, the array is at rest and about to be opened by its spring; later it moves, which is no mistake."""
    checked, path = swinging
    text = modes(checked, None, at=f"{path}:{time}")[0]
    assert ("the state is not an equilibrium" in text and "add --at-rest" in text) == reported

"""Redundant constraints: named, solved with the same motion as without them, at singular positions too."""

import re

import numpy as np
import pytest
from linkage import FourBar
from time_runs import INPUTS, RecordedRun, deck, input_deck

from mecano.analyses import dynamic, static
from mecano.analyses.prepare import prepare, startup_warnings
from mecano.analyses.summary import summary
from mecano.errors import AssemblyError, ConvergenceError
from mecano.results.reader import open_results
from mecano.solve.time.run_state import from_plain, to_plain

HINGES = {
    "hinge_b": "hinge_b: {type: hinge, nodes: [crank_end, coupler], axis: [0, -1, 0]}",
    "hinge_c": "hinge_c: {type: hinge, nodes: [coupler_end, rocker_end], axis: [0, -1, 0]}",
}
# joints that hold 3 constraints less than the two hinges: pins along y and across the coupler
ISOSTATIC = {
    "universal and spherical": (
        "hinge_b: {type: universal, nodes: [crank_end, coupler], axis_a: [0, 1, 0], axis_b: [-0.766, 0, 0.642857]}",
        "hinge_c: {type: spherical, nodes: [coupler_end, rocker_end]}",
    ),
    "cylindrical and spherical": (
        "hinge_b: {type: spherical, nodes: [crank_end, coupler]}",
        "hinge_c: {type: cylindrical, nodes: [coupler_end, rocker_end], axis: [0, -1, 0]}",
    ),
}


def four_bar(*joints, end=1.0, step=2e-3):
    """The deck of the four-bar, joints at b and c replaced, tightly solved."""
    text = (INPUTS / "four_bar.yaml").read_text()
    for old, new in zip(HINGES.values(), joints, strict=False):
        assert old in text
        text = text.replace(old, new)
    head, _, _ = text.partition("time: {")
    tolerances = "newton: {force_tolerance: 1.0e-12, constraint_tolerance: 1.0e-13}"
    return deck(f"{head}\ntime: {{end: {end}, step: {step}, {tolerances}}}\n")


def test_the_group_and_the_mechanism_are_named():
    """Out of the plane: along y the offsets of the bars, about axes in the plane all hinges."""
    analysis = prepare(input_deck("four_bar")).analysis
    assert (analysis.mobility, [group.count for group in analysis.redundant]) == (1, [3])
    named = {name.split(":")[0].split("'")[1] for name in analysis.redundant[0].names}
    assert named == {"crank_bar", "coupler_bar", "rocker_bar", "hinge_a", "hinge_b", "hinge_c", "hinge_d"}
    assert [group.count for group in analysis.mechanisms] == [1]
    motions = analysis.mechanisms[0].names
    assert any("rocker" in name and "rotation about material y" in name for name in motions)
    assert not any("displacement y" in name for name in motions)


BLOCKED = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {{pin: {{position: [0, 0, 0]}}, free: {{position: [1, 0, 0]}}}}
    elements:
      bar: {{type: rigid_body, node: pin, mass: 1, inertia: [0.01, 0.1, 0.1]}}
      dot: {{type: point_mass, node: free, mass: 1}}
    joints:
      hold: {{type: fixed, nodes: [ground, pin]}}
      turn: {{type: prescribed_angle, nodes: [ground, pin], axis: [0, 1, 0], value: {}}}
    time: {{end: 0.02, step: 1.0e-3}}
"""


@pytest.mark.parametrize("method", ["generalized_alpha", "radau"])
def test_redundant_constraints_that_contradict_one_another_are_reported(method):
    """A motor on a blocked joint whose compliance gives 1e-11 only, from the start or from 5 ms."""
    by_method = BLOCKED.replace("step: 1.0e-3", f"step: 1.0e-3, method: {method}")
    RecordedRun(deck(by_method.format(0.0)))
    motor = "to prescribed_angle 'turn': moment that holds the angle"
    with pytest.raises(
        AssemblyError, match=f"contradict one another: the other constraints leave a rate of -1 rad/s {motor}"
    ):
        RecordedRun(deck(by_method.format("{linear: {slope: 1}}")))
    for law, left in (
        ("ramp: {start: 5.0e-3, end: 1}", "a rate of -1.01 rad/s"),
        ("step: {time: 5.0e-3, rise: 0.1}", "a gap"),
    ):
        with pytest.raises(ConvergenceError, match=f"at t = 0.00.*contradict .* {left}.* {motor}") as error:
            RecordedRun(deck(by_method.format("{" + law.replace("}", ", from: 0, to: 1}") + "}")))
        assert "what to try: remove one of these constraints" in str(error.value)


@pytest.mark.parametrize("orientation", ["0, 0, 0", "90 deg, 0, 0"])
def test_the_bolt_is_named_beside_the_motor_that_it_contradicts(orientation):
    """`fixed` shares unknowns, and no multiplier of its own stands in the equations; axes are those of the deck."""
    turned = BLOCKED.replace(
        "pin: {{position: [0, 0, 0]}}", f"pin: {{{{position: [0, 0, 0], orientation: [{orientation}]}}}}"
    )
    with pytest.raises(AssemblyError, match="contradict") as error:
        RecordedRun(deck(turned.format("{linear: {slope: 1}}")))
    *_, last = str(error.value).splitlines()
    assert "; the others are:\n" in str(error.value)
    assert last == "  fixed 'hold': moment about initial y (1 of 6 constraints)"


BOLTED_LATER = """
    mecano: 1
    gravity: [0, 0, 0]
    nodes: {block: {position: [0, 0, 0]}, tail: {position: [0, 0, 0]}}
    elements:
      block: {type: rigid_body, node: block, mass: 1, inertia: [0.01, 0.01, 0.01]}
      tail: {type: rigid_body, node: tail, mass: 1, inertia: [0.01, 0.01, 0.01]}
    joints:
      guide: {type: prismatic, nodes: [ground, block], axis: [1, 0, 0], stops: {upper: 0.1}}
      bolt: {type: fixed, nodes: [block, tail]}
      wall: {type: prismatic, nodes: [ground, tail], axis: [1, 0, 0], stops: {upper: 0.1}}
    initial: {velocities: [{nodes: [block, tail], velocity: [1, 0, 0]}]}
    time: {end: 0.2, step: 1.0e-3}
"""


def test_a_redundancy_that_begins_in_a_run_names_the_bolt():
    """Two stops close at once on two bodies that are bolted together: without the bolt each would hold its own."""
    recorded = RecordedRun(deck(BOLTED_LATER))
    (text,) = [text for text in recorded.integrator.warnings if text.startswith("since t = 0.1 s")]
    assert all(name in text for name in ("prismatic 'guide'", "prismatic 'wall'", "fixed 'bolt': force x"))


def test_constraints_of_the_same_joints_that_become_redundant_are_one_warning():
    """A grip closes on the nodes of a hinge: it repeats three forces and two moments, in groups that do not couple."""
    recorded = RecordedRun(
        deck("""
        mecano: 1
        gravity: none
        nodes: {a: {position: [0, 0, 0]}, b: {position: [0, 0, 0]}}
        elements:
          one: {type: rigid_body, node: a, mass: 1, inertia: [0.1, 0.2, 0.2]}
          two: {type: rigid_body, node: b, mass: 1, inertia: [0.1, 0.2, 0.2]}
        joints:
          pin: {type: hinge, nodes: [a, b], axis: [0, 1, 0]}
          hold: {type: grip, nodes: [a, b], close: {time: 0.01}}
        time: {end: 0.02, step: 5.0e-3}
        """)
    )
    (text,) = [text for text in recorded.integrator.warnings if text.startswith("since t = 0.01 s")]
    assert "5 constraint(s) are redundant" in text and "hinge 'pin'" in text and "grip 'hold'" in text


BESIDE = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {pin: {position: [0, 0, 0]}, beside: {position: [3, 0, 0]}}
    elements:
      bar: {type: rigid_body, node: pin, mass: 1, inertia: [0.01, 0.1, 0.1]}
      other: {type: rigid_body, node: beside, mass: 1, center_of_mass: [1, 0, 0], inertia: [0.01, 0.1, 0.1]}
    joints:
      axle: {type: hinge, nodes: [ground, pin], axis: [0, 1, 0]}
      beside: {type: hinge, nodes: [ground, beside], axis: [0, 1, 0]}
      slow: {type: prescribed_angle, nodes: [ground, pin], axis: [0, 1, 0], value: {linear: {slope: 1}}}
      fast: {type: prescribed_angle, nodes: [ground, pin], axis: [0, 1, 0], value: {linear: {slope: 2}}}
    time: {end: 0.02, step: 1.0e-3}
"""


def test_all_constraints_that_contradict_one_another_are_named():
    with pytest.raises(AssemblyError, match="contradict") as error:
        RecordedRun(deck(BESIDE))
    assert all(f"prescribed_angle '{name}'" in str(error.value) for name in ("slow", "fast"))
    assert "beside" not in str(error.value) and "axle" not in str(error.value)


def test_a_motor_that_drives_on_a_stop_ends_the_run_with_both_names():
    """The run ends at the stop with exit code 3, not as a deck that cannot be assembled."""
    text = """
    mecano: 1
    gravity: [0, 0, 0]
    nodes: {block: {position: [0, 0, 0]}}
    elements: {block: {type: rigid_body, node: block, mass: 1, inertia: [0.01, 0.01, 0.01]}}
    joints:
      guide: {type: prismatic, nodes: [ground, block], axis: [1, 0, 0], stops: {upper: 0.1}}
      drive: {type: prescribed_position, node: block, direction: [1, 0, 0], value: {linear: {slope: 0.5}}}
    time: {end: 0.6, step: 1.0e-3}
    """
    with pytest.raises(ConvergenceError, match="at t = 0.2 s constraints contradict one another") as error:
        RecordedRun(deck(text))
    assert "prescribed_position 'drive'" in str(error.value) and "prismatic 'guide': force of the stop" in str(
        error.value
    )
    assert "what to try: remove one of these constraints" in str(error.value)


def test_a_moment_on_a_node_without_inertia_is_reported():
    """The rotation of a point mass: nothing resists the moment."""
    text = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {a: {position: [0, 0, 0]}, b: {position: [1, 0, 0]}}
    elements: {m: {type: point_mass, node: a, mass: 1}, falls: {type: point_mass, node: b, mass: 1}}
    loads: {turn: {type: moment, node: a, direction: [0, 1, 0], value: 3}}
    time: {end: 0.1, step: 0.01}
    """
    with pytest.raises(ConvergenceError, match="node a: rotation about material y; on it act moment 'turn'") as error:
        RecordedRun(deck(text))
    assert "what to try: a mass, an inertia or a stiffness where one is missing above" in str(error.value)
    assert "node b" not in str(error.value) and "displacement" not in str(error.value)


def test_summary_and_warnings_name_redundant_constraints():
    text = summary(input_deck("four_bar"))
    assert "mobility         1" in text and "redundant        3 constraint(s)" in text
    assert "hinge 'hinge_a', 'hinge_b', 'hinge_c', 'hinge_d': moment that keeps two axes perp" in text
    said = startup_warnings(prepare(input_deck("four_bar")))
    assert len(said) == 1 and said[0].startswith("3 redundant constraint(s) among: ") and "not unique" in said[0]


@pytest.mark.parametrize("joints", ISOSTATIC.values(), ids=ISOSTATIC)
def test_isostatic_version_has_no_redundancy(joints):
    prepared = prepare(four_bar(*joints))
    assert (prepared.analysis.mobility, prepared.analysis.redundant) == (1, ())
    assert prepared.compliance is None and startup_warnings(prepared) == []


@pytest.mark.parametrize("joints", ISOSTATIC.values(), ids=ISOSTATIC)
def test_motion_is_that_of_the_isostatic_version(joints):
    """Every position to 1e-9 m at every step, angles and the force in the plane on the crank likewise."""
    redundant, isostatic = RecordedRun(four_bar()), RecordedRun(four_bar(*joints))
    for path in redundant.columns:
        if path.endswith("/position"):
            np.testing.assert_allclose(isostatic[path], redundant[path], rtol=0, atol=1e-9, err_msg=path)
    force = redundant["joints/hinge_a/force"]
    np.testing.assert_allclose(isostatic["joints/hinge_a/force"], force, rtol=0, atol=1e-9 * np.abs(force).max())
    for path in ("joints/hinge_a/angle", "joints/hinge_d/angle"):
        np.testing.assert_allclose(isostatic[path], redundant[path], rtol=0, atol=1e-9)


def test_motion_is_planar_and_closes():
    """Coupler and rocker angles are those of the closed form at every step."""
    recorded, linkage = RecordedRun(four_bar()), FourBar()
    theta = recorded["joints/hinge_a/angle"]
    coupler, rocker = linkage.angles(theta) - linkage.angles(0.0)[:, None]
    np.testing.assert_allclose(theta + recorded["joints/hinge_b/angle"], coupler, rtol=0, atol=1e-9)
    np.testing.assert_allclose(recorded["joints/hinge_d/angle"], rocker, rtol=0, atol=1e-9)
    assert max(np.abs(recorded[f"nodes/{name}/position"][:, 1]).max() for name in ("crank_end", "rocker_end")) < 1e-12


def leaning(g_y, steps=1000, step=1e-3):
    """Run the linkage with the component ``g_y`` of gravity [m/s2] normal to its plane."""
    across = four_bar(end=steps * step, step=step)
    across.values["gravity"][1] = g_y
    return RecordedRun(across)


def loads_along_the_hinges(recorded):
    """Forces (n, 2) of crank and rocker on the ground, along y."""
    return np.stack([recorded[f"joints/hinge_{name}/force"][:, 2] for name in "ad"], axis=1)


WEIGHT = 2.0 * (0.3 + 0.9 + 0.7) * 3.0  # of the bars, across the plane [N]


def test_load_across_the_plane():
    """It does not change the motion; the ground hinges carry it together, each its part, smoothly."""
    upright, lean = leaning(0.0), leaning(-3.0)
    for path in ("joints/hinge_a/angle", "joints/hinge_d/angle", "nodes/coupler_end/position"):
        np.testing.assert_allclose(lean[path], upright[path], rtol=0, atol=1e-9)
    loads = loads_along_the_hinges(lean)
    np.testing.assert_allclose(loads.sum(axis=1), -WEIGHT, rtol=1e-8)
    assert np.all(np.abs(loads) > 0.4 * WEIGHT)
    assert np.abs(np.diff(loads, 3, axis=0)).max() < 1e-4 * WEIGHT


def test_its_share_does_not_depend_on_the_step():
    """Down to steps at which the compliance vibrates with the bars: the shares of the start stay, within 1e-3."""
    start = loads_along_the_hinges(leaning(-3.0, 1))[0]
    for step in (1e-6, 1e-5, 1e-4):
        loads = loads_along_the_hinges(leaning(-3.0, 20, step))
        np.testing.assert_allclose(loads, np.tile(start, (21, 1)), rtol=0, atol=1e-3 * WEIGHT)


def test_isostatic_joints_carry_their_load():
    """With a ball and a pin sleeve at b and c the rocker carries itself alone across the plane."""
    linkage = four_bar(*ISOSTATIC["cylindrical and spherical"], end=0.1)
    linkage.values["gravity"][1] = -3.0
    loads = loads_along_the_hinges(RecordedRun(linkage))
    np.testing.assert_allclose(loads, np.tile([-(0.6 + 1.8) * 3.0, -1.4 * 3.0], (len(loads), 1)), rtol=1e-8)


def test_planets_share_the_load_at_any_speed():
    """Three planets between a sun that turns at 150 rad/s and a ring; two are redundant.

    With the ratio 3 of sun and carrier, -3 of planet and carrier, and the inertia J at the carrier, each tooth of the
    sun carries (M - 3 J_s a)/(3 r) with a = 3 M/J. The centripetal accelerations of 1,100 m/s2 have rounding errors.
    """
    rate, angles = 50.0, "{repeat: {i: 0..2}, position: [0.15*cos(2*pi*$i/3), 0.15*sin(2*pi*$i/3), 0]}"
    planets, seats = (", ".join(f"{name}{i}" for i in range(3)) for name in ("planet", "seat"))
    gear = "repeat: {i: 0..2}, type: gear_pair, axis_a: [0, 0, 1]"
    body = "repeat: {i: 0..2}, type: rigid_body, mass: 0.3, inertia: [0.001, 0.001, 0.0011]"
    run = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{sun: {{position: [0, 0, 0]}}, carrier: {{position: [0, 0, 0]}}, planet$i: {angles}, seat$i: {angles}}}
        elements:
          sun: {{type: rigid_body, node: sun, mass: 1, inertia: [0.01, 0.01, 0.012]}}
          carrier: {{type: rigid_body, node: carrier, mass: 1, inertia: [0.01, 0.01, 0.016], attached: [{seats}]}}
          planet$i: {{{body}, node: planet$i}}
        joints:
          sun: {{type: hinge, nodes: [ground, sun], axis: [0, 0, 1]}}
          carrier: {{type: hinge, nodes: [ground, carrier], axis: [0, 0, 1]}}
          pin$i: {{repeat: {{i: 0..2}}, type: hinge, nodes: [seat$i, planet$i], axis: [0, 0, 1]}}
          inner$i: {{{gear}, nodes: [carrier, sun, planet$i], radius_a: 0.1, radius_b: 0.05}}
          outer$i: {{{gear}, nodes: [carrier, planet$i, ground], radius_a: 0.05, radius_b: 0.2}}
        loads: {{motor: {{type: joint_moment, joint: sun, value: 3}}}}
        initial:
          velocities:
            - {{nodes: [carrier, {planets}, {seats}], angular_velocity: [0, 0, {rate}], about: [0, 0, 0]}}
            - {{nodes: [sun], angular_velocity: [0, 0, {3 * rate}]}}
            - {{nodes: [{planets}], angular_velocity: [0, 0, {-4 * rate}], about: own}}
        time: {{end: 2 ms, step: 1 ms, method: radau}}
    """)
    )
    a = 3 * 3 / (9 * 0.012 + 0.016 + 3 * (0.3 * 0.15**2 + 9 * 0.0011))
    for i in range(3):
        np.testing.assert_allclose(run[f"joints/inner{i}/force"], -(3 - 3 * 0.012 * a) / 0.3, rtol=1e-4)


@pytest.mark.parametrize(("joints", "share"), [(1, 1.0), (2, 0.5)])
def test_redundant_joints_of_a_mass_that_circles_take_no_energy(joints, share):
    """A mass on equal joints of a hub that turns freely at 100 rad/s, in steps of 0.1 and 0.01 rad.

    The rate is constant by the moment of momentum, and each joint carries its share of m r w^2. One joint has an error
    of 2.4e-9 in steps of 0.1 rad, that of the method.
    """
    for step, lost in ((1e-3, 1e-8), (1e-4, 1e-11)):
        run = RecordedRun(
            deck(f"""
            mecano: 1
            gravity: none
            nodes:
              hub: {{position: [0, 0, 0]}}
              seat: {{position: [0.05, 0.01, 0]}}
              mass: {{position: [0.05, 0.01, 0]}}
            elements:
              hub: {{type: rigid_body, node: hub, mass: 1, inertia: [0.001, 0.001, 0.001], attached: [seat]}}
              mass: {{type: rigid_body, node: mass, mass: 1, inertia: [0.001, 0.001, 0.001]}}
            joints:
              axle: {{type: hinge, nodes: [ground, hub], axis: [0, 0, 1]}}
              pin$i:
                {{repeat: {{i: 1..{joints}}}, type: generic, nodes: [seat, mass], axis: [0, 0, 1], free: [about_axis]}}
            initial: {{velocities: [{{nodes: all, angular_velocity: [0, 0, 100], about: [0, 0, 0]}}]}}
            time: {{end: {100 * step}, step: {step}, method: radau}}
        """)
        )
        np.testing.assert_allclose(run["joints/axle/rate"], 100.0, rtol=lost)
        pull = [[-500.0 * share, -100.0 * share, 0.0]]
        for i in range(joints):
            np.testing.assert_allclose(run[f"joints/pin{i + 1}/force"], pull * len(run.time), rtol=0, atol=1e-4)


@pytest.mark.parametrize("step", [1e-3, 1e-5])
def test_two_bearings_carry_the_whole_load_in_any_step(step):
    """Each carries m g/2, with friction mu r m g in all: the penalty must not carry a share that friction ignores."""
    run = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: [0, -9.81, 0]
        nodes: {{shaft: {{position: [0, 0, 0]}}, end1: {{position: [0, 0, -0.3]}}, end2: {{position: [0, 0, 0.3]}}}}
        elements: {{shaft: {{type: rigid_body, node: shaft, mass: 20, inertia: [1, 1, 0.1], attached: [end1, end2]}}}}
        joints:
          bearing$i:
            repeat: {{i: 1..2}}
            type: hinge
            nodes: [ground, end$i]
            axis: [0, 0, 1]
            friction: {{coefficient: 0.1, radius: 0.03, regularization: 1 mm/s}}
        initial: {{velocities: [{{nodes: all, angular_velocity: [0, 0, 50], about: [0, 0, 0]}}]}}
        time: {{end: {20 * step}, step: {step}}}
    """)
    )
    for bearing in (1, 2):
        np.testing.assert_allclose(run[f"joints/bearing{bearing}/force"][:, 1], 98.1, rtol=1e-6)
    slows = 0.1 * 0.03 * 196.2 / 0.1 * 20 * step
    np.testing.assert_allclose(50.0 - run["joints/bearing1/rate"][-1], slows, rtol=1e-6)


SHAFT = """
    mecano: 1
    gravity: none
    nodes: {{shaft: {{position: [0, 0, 0]}}, end1: {{position: [0, 0, -0.3]}}, end2: {{position: [0, 0, 0.3]}}}}
    elements: {{shaft: {{type: rigid_body, node: shaft, mass: 20, inertia: [1, 1, 0.1], attached: [end1, end2]}}}}
    joints: {{bearing$i: {{repeat: {{i: 1..2}}, type: hinge, nodes: [ground, end$i], axis: [0, 0, 1]}}}}
    signals: {{late: "max(0, time - 100)"}}
    loads: {{pull: {{type: force, node: shaft, direction: [0, 1, 0], value: {}}}}}
    time: {{end: 200, step: 0.5, method: {}}}
"""


@pytest.mark.parametrize("method", ["generalized_alpha", "radau"])
@pytest.mark.parametrize(("load", "size"), [("1e5*late", 1e7), ("1e-5*sin(time/20)", 1e-5)])
def test_bearings_share_loads_of_signals_however_large(load, size, method):
    """Half of a load that is not known at the start each, to SHARING; neither bearing yields by 1e-8 m."""
    run = RecordedRun(deck(SHAFT.format(load, method)))
    half = -0.5 * eval(load, {"late": np.maximum(0.0, run.time - 100.0), "time": run.time, "sin": np.sin})  # noqa: S307
    for bearing in (1, 2):
        np.testing.assert_allclose(run[f"joints/bearing{bearing}/force"][:, 1], half, rtol=0, atol=1e-3 * size)
    assert np.abs(run["nodes/shaft/position"]).max() < 1e-8
    assert run.run.compliance.stiffens


def test_a_run_continues_with_the_compliances_that_it_has_found():
    """A run that is saved behind the change ends with the same bits as one without a pause."""
    whole = RecordedRun(deck(SHAFT.format("1e5*late", "generalized_alpha")))

    def saved(integrator, run):
        run = integrator.to(150.0, run)
        return from_plain(to_plain(run))

    parts = RecordedRun(deck(SHAFT.format("1e5*late", "generalized_alpha")), change=saved)
    assert parts.run.compliance.force == whole.run.compliance.force > 1e3
    np.testing.assert_array_equal(parts.rows[-1], whole.rows[-1])


@pytest.mark.parametrize("method", ["generalized_alpha", "radau"])
def test_constraints_that_nearly_fit_keep_their_compliances(method):
    """A motor turns a blocked joint by 1e-7 rad: its moment is 1e4 times the weight at 1 m, not more."""
    text = BLOCKED.replace("step: 1.0e-3", f"step: 1.0e-3, method: {method}")
    run = RecordedRun(deck(text.format("{step: {time: 5.0e-3, rise: 0.01, from: 0, to: 1.0e-7}}")))
    assert np.abs(run["joints/turn/moment"]).max() < 1e6
    assert len(run.time) == 21


BRACKET = """
    mecano: 1
    gravity: none
    sections:
      s: {type: stiffness, EA: 1.2e10, GA2: 4.0e9, GA3: 4.0e9, GJ: 2.0e7, EI2: 4.0e7, EI3: 4.0e7, mass_per_length: 470,
          rotary_inertia: [1, 1, 1]}
    nodes: {root: {position: [0, 0, 0]}, tip: {position: [0.5, 0, 0]}}
    elements: {bracket: {type: beam, nodes: [root, tip], section: s, up: [0, 0, 1], mesh: 2}}
    joints: {bolt$i: {repeat: {i: 1..2}, type: generic, nodes: [ground, root], axis: [0, 0, 1]}}
    loads: {load: {type: force, node: tip, direction: [0, 0, -1], value: LOAD}}
    static: {over: time, end: 1, steps: 2}
"""


def test_a_load_that_grows_does_not_displace_redundant_supports(tmp_path):
    """A stiff cantilever on two bolts, loaded by 1 MN from zero: the tip sinks by F L/(G A) + F L^3/(3 E I).

    Terms of second order are the square of the slope, 5e-6; the supports yield by 1e-8 of the deflection.
    """
    notes, grows = [], BRACKET.replace("LOAD", "{linear: {slope: 1 MN/s}}")
    end = static.run(deck(grows), tmp_path / "bracket.h5", announce=notes.append).state
    sinks = 1e6 * 0.5 / 4e9 + 1e6 * 0.5**3 / (3 * 4e7)
    np.testing.assert_allclose(-end.z[height_of("tip")], sinks, rtol=1e-5)
    assert not any("yielded" in text for text in notes)


def test_redundant_supports_that_yield_are_reported(tmp_path):
    """A load by a formula is not known at the start; the displacement of the root is the reported one."""
    notes = []
    end = static.run(deck(BRACKET.replace("LOAD", "1.0e6*time")), tmp_path / "bracket.h5", announce=notes.append).state
    [reported] = (float(found[1]) for text in notes if (found := re.search(r"yielded by up to some (\S+) m", text)))
    np.testing.assert_allclose(-end.z[height_of("root")], reported, rtol=0.1)


def height_of(node):
    """Return the index of the vertical position of a node of the bracket."""
    system = prepare(deck(BRACKET.replace("LOAD", "1"))).system
    return system.numbering.x[[n.name for n in system.nodes].index(node)] + 2


def test_a_linkage_whose_axes_are_not_parallel_is_said_to_bind(tmp_path):
    """A hinge of a four-bar linkage leans by 0.01 rad: the crank swings to and fro by about that, and does not fall."""
    dynamic.run(input_deck("four_bar", "joints.hinge_c.axis=[0, -1, 0.01]", "time.end=0.3"), tmp_path / "r.h5")
    with open_results(tmp_path / "r.h5") as results:
        assert abs(results["hinge_a.angle"].values).max() < 0.02
        (said,) = (text for text in results.warnings if "redundant constraints yielded" in text)
    assert "bind: are axes exactly parallel, or in one line, that should be?" in said

"""Messages about a run, on the terminal and in the results: warnings, limits, chosen defaults."""

import re
import textwrap
from contextlib import nullcontext
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
import yaml
from process import flowing, mecano_process, settings
from time_runs import INPUTS, RecordedRun, deck, input_deck

import mecano
from mecano.analyses import dynamic
from mecano.analyses.circle_accuracy import circle_warnings
from mecano.analyses.diagnostics import energy_warnings, step_cut_warnings
from mecano.analyses.modal import modes
from mecano.analyses.operating_point import operating_point
from mecano.analyses.prepare import prepare, startup_warnings
from mecano.analyses.progress import Progress
from mecano.analyses.summary import summary
from mecano.cli import commands
from mecano.deck.read import deck_of_bytes
from mecano.deck.run_size import result_bytes, saved_times, steps
from mecano.jit import machine_code
from mecano.model.model import length_scale
from mecano.post.info import info as info_of
from mecano.post.runs import open_runs
from mecano.post.sheets import default_sheets

WARNINGS = {  # deck: overrides, what is said at the start
    "four_bar": (
        ["time.end=0.1"],
        "3 redundant constraint(s) among: rigid_body 'crank_bar', 'coupler_bar', 'rocker_bar': force y of the ",
    ),
    "double_pendulum": (
        ["time.end=0.01", "initial.velocities=[{nodes: [elbow], velocity: [1, 0, 0]}]"],
        "the initial velocities violate the constraints and were replaced by the nearest admissible ones",
    ),
    "spherical_pendulum": (["time.end=0.01"], ""),
}


def run_of(tmp_path, name, *overrides):
    """(errors printed, results) of a run of a deck of inputs/ that succeeds."""
    path = tmp_path / "reported.h5"
    code, out, err = mecano_process("run", INPUTS / f"{name}.yaml", "-o", path, *settings(*overrides))
    assert (code, out) == (0, "")
    return err, mecano.open_results(path)


def info(tmp_path):
    """What `mecano info` says of the last run."""
    code, out, _ = mecano_process("info", tmp_path / "reported.h5")
    assert code == 0
    return flowing(out)


def check(*overrides):
    """What `mecano check` says of the pendulum."""
    code, out, _ = mecano_process("check", INPUTS / "pendulum.yaml", *settings(*overrides))
    assert code == 0
    return flowing(out)


@pytest.mark.parametrize("name", WARNINGS)
def test_warnings_are_printed_once_and_stored(name, tmp_path):
    overrides, text = WARNINGS[name]
    err, results = run_of(tmp_path, name, *overrides)
    warnings = results.warnings
    if not text:
        assert warnings == []
        return
    (warning,) = warnings
    assert warning.startswith(text)
    assert flowing(err).count(f"mecano: {warning}") == 1 and flowing(err).count(text.strip()) == 1
    assert max(map(len, err.splitlines())) <= 110 and len(err.splitlines()) >= 3
    assert f"warning {warning}" in info(tmp_path)
    assert results.status == "complete" and results.reason == "the end was reached"


@pytest.mark.parametrize(
    ("name", "nodes", "motion", "reported"),
    [
        ("pendulum", "[pin]", "velocity: [0, 0, 1]", "node 'pin' from [0, 0, 1] to [0, 0, 0] m/s"),  # on the ground
        ("pendulum", "[pin]", "angular_velocity: [2, 3, 0]", "node 'pin' from [2, 3, 0] to [0, 3, 0] rad/s"),
        ("pendulum", "[pin]", "angular_velocity: [0, 3, 0]", ""),
        ("pendulum", "all", "angular_velocity: [0, 3, 0], about: own", ""),
        ("spherical_pendulum", "[ball]", "angular_velocity: [0, 0, 3], about: [0, 0, 0]", ""),  # a point does not turn
        ("caster_shimmy", "[hub]", "angular_velocity: [0, 0.1, 0]", ""),  # beside steady running
    ],
)
def test_initial_velocities_that_cannot_be_are_reported(name, nodes, motion, reported):
    base = operating_point(input_deck(name, f"initial.velocities=[{{nodes: {nodes}, {motion}}}]"))
    said = [text for text in base.warnings if "initial velocities" in text]
    changes = [text.partition("(momenta kept): ")[2].partition(". Nodes that are not named")[0] for text in said]
    assert changes == ([reported] if reported else [])


SUNK = """
    mecano: 1
    gravity: [0, 0, -10]
    nodes: {hub: {position: [0, 0, 0.35]}, body: {position: [0, 0, 1]}}
    elements:
      rim: {type: rigid_body, node: hub, mass: 10, inertia: [1, 1, 1]}
      body: {type: rigid_body, node: body, mass: 100, inertia: [1, 1, 1]}
      coil: {type: spring_damper, nodes: [hub, body], law: {spring: STIFFNESS}}
      tire: {type: wheel, node: hub, axis: [0, 1, 0], tire_law: rubber, ground: road}
    joints:
      upright: {type: held_rotation, nodes: [ground, body]}
      guide: {type: prismatic, nodes: [body, hub], axis: [0, 0, 1]}
    tire_laws: {rubber: {radius: 0.4, radial: {linear: {slope: 6.0e3}}, friction: 0, slip_regularization: 0.1}}
    grounds: {road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
    initial: {steady: {velocity: [5, 0, 0]}}
    time: {end: 1, step: 0.01}
"""


@pytest.mark.parametrize(("stiffness", "said"), [("1.0e6", []), ("4.0e3", ["moves by 0.125 m"])])
def test_steady_running_that_needs_another_shape_names_a_node_of_the_deck(stiffness, said):
    """On a stiff spring wheel and body sink together, by 133 mm; on a soft one the body sinks by 250 mm more.

    The node that holds the rotation stays in place and is not part of the deck, so it is not named.
    """
    found = operating_point(deck(SUNK.replace("STIFFNESS", stiffness))).warnings
    shapes = [text for text in found if "another shape" in text]
    assert len(shapes) == len(said) and all(part in text for part, text in zip(said, shapes, strict=True))


SLIDER = b"""
mecano: 1
gravity: none
nodes: {block: {position: [0, 0, 0]}, link: {position: [0, 0, 0]}}
elements:
  block: {type: rigid_body, node: block, mass: 1, inertia: [1, 1, 1]}
  link: {type: rigid_body, node: link, mass: 1, inertia: [1, 1, 1], center_of_mass: [0, 0, 1]}
joints:
  rail: {type: prismatic, nodes: [ground, block], axis: [1, 0, 0]}
  pin: {type: hinge, nodes: [block, link], axis: [0, 1, 0]}
initial: {velocities: [{nodes: [block], velocity: [1, 0, 1]}]}
time: {end: 1, step: 0.01}
"""


def test_check_says_that_initial_velocities_cannot_be():
    """On the ground, and on a rail that keeps a block from rising; the link shares its position, and moves along."""
    violated = "warning the initial velocities violate the constraints"
    said = check("initial.velocities=[{nodes: [pin], velocity: [0, 0, 1]}]")
    assert violated in said and "node 'pin' from [0, 0, 1] to [0, 0, 0] m/s" in said and "at start" not in said
    said = flowing(summary(deck_of_bytes(SLIDER, "slider.yaml")))
    assert violated in said and "node 'block' from [1, 0, 1] to [1, 0, 0] m/s" in said and "at start" not in said


@pytest.mark.parametrize(("velocity", "warned"), [("[1, 0, 0]", False), ("[1, 0, 1]", True)])
def test_a_velocity_of_all_nodes_that_none_of_them_can_have_is_reported(velocity, warned):
    """The rail lets block and link move along x only; `mecano.check` has the warnings of the text."""
    text = SLIDER.decode().replace("nodes: [block], velocity: [1, 0, 1]", f"nodes: all, velocity: {velocity}")
    found = mecano.check(yaml.safe_load(text))
    said = "node 'block' from [1, 0, 1] to [1, 0, 0] m/s. No node can move as 'nodes: all' demands"
    assert [said in warning for warning in found.warnings] == warned * [True]
    assert (said in flowing(str(found))) == warned


def test_what_a_drive_sets_in_motion_is_listed(tmp_path):
    """The end of a crank of 50 mm at 50 rad/s moves at 2.5 m/s; this is no warning."""
    crank = "the constraints set nodes in motion that the deck leaves at rest: node 'crank_pin' by 2.5 m/s; "
    assert f"at start {crank}" in flowing(summary(input_deck("slider_crank")))
    dynamic.run(input_deck("slider_crank", "time.end=0.001"), tmp_path / "reported.h5")
    with mecano.open_results(tmp_path / "reported.h5") as results:
        assert f"at start {crank}" in flowing(info_of(results.path)) and not results.warnings
    given = "initial.velocities=[{nodes: all, velocity: [0, 0, 0]}]"  # the deck gives all
    assert "at start" not in summary(input_deck("slider_crank", given))


SHAFT = b"""
mecano: 1
gravity: none
nodes: {bearing: {position: [0, 0, 0]}, end: {position: [0.9, 0.3, 0]}}
elements: {shaft: {type: rigid_body, node: bearing, mass: 1, inertia: [1, 1, 1], attached: [end]}}
joints:
  bearing: {type: hinge, nodes: [ground, bearing], axis: [3, 1, 0]}
  drive: {type: prescribed_angle, nodes: [ground, bearing], axis: [3, 1, 0], value: 10*time}
time: {end: 1, step: 1 ms}
"""


def test_what_a_moving_body_carries_is_not_listed():
    """The end of an arm whose bearing turns by a velocity of the deck, unlike that of one which a drive turns."""
    arm = SHAFT.replace(b"[3, 1, 0]", b"[0, 0, 1]")
    drive = b"  drive: {type: prescribed_angle, nodes: [ground, bearing], axis: [0, 0, 1], value: 10*time}\n"
    turning = b"initial: {velocities: [{nodes: [bearing], angular_velocity: [0, 0, 10], about: own}]}\n"
    assert "at start" not in summary(deck_of_bytes(arm.replace(drive, b"") + turning, "arm.yaml"))
    assert "at rest: node 'end' by 9.487 m/s; node 'bearing' by" in flowing(summary(deck_of_bytes(arm, "arm.yaml")))


def test_rounding_is_not_listed_as_motion():
    """The end of a shaft stays on its axis, but for rounding: only its turning is motion."""
    said = flowing(summary(deck_of_bytes(SHAFT, "shaft.yaml")))
    assert "at rest: node 'bearing' by 10 rad/s; node 'end' by 10 rad/s" in said, said
    for rate, listed in (("1.0e-60", False), ("1.0e-14", True)):  # the first is the rounding of a spline that begins
        said = summary(deck_of_bytes(SHAFT.replace(b"10*", f"{rate}*".encode()), "shaft.yaml"))
        assert ("at start" in said) == listed


ROTOR = b"""
mecano: 1
gravity: none
sections: {tube: {type: tube, diameter: 0.1, thickness: 5 mm, E: 70 GPa, nu: 0.3, density: 2700}}
templates:
  blade:
    nodes:
      {root: {position: [0.3, 0, 0]}, mid: {position: [0.3, 0, 0]}, cuff: {position: [0.3, 0, 0]},
       tip: {position: [5, 0, 0]}}
    elements: {blade: {type: beam, nodes: [cuff, tip], section: tube, mesh: 2}}
    joints:
      flap: {type: hinge, nodes: [root, mid], axis: [0, -1, 0]}
      lag: {type: hinge, nodes: [mid, cuff], axis: [0, 0, 1]}
place:
  b$k: {repeat: {k: 1..3}, template: blade, orientation: [0, 0, ($k - 1)*2*pi/3]}
nodes: {base: {position: [0, 0, 0]}, hub: {position: [0, 0, 0]}}
elements:
  base: {type: rigid_body, node: base, mass: 500, inertia: [10, 10, 10]}
  hub: {type: rigid_body, node: hub, mass: 20, inertia: [2, 2, 3], attached: [b1_root, b2_root, b3_root]}
joints:
  pylon: {type: generic, nodes: [ground, base], axis: [0, 0, 1], free: [along_1, along_2]}
  shaft: {type: hinge, nodes: [base, hub], axis: [0, 0, 1]}
initial:
  velocities:
    - {nodes: all, angular_velocity: [0, 0, 20], about: [0, 0, 0]}
    - {nodes: [base], angular_velocity: [0, 0, -20]}
time: {end: 1, step: 1 ms}
"""


def test_rounding_of_initial_velocities_is_not_reported():
    """The base is at rest; that it moves at 1e-17 m/s follows from the velocities of the blades, up to 40 m/s."""
    base = operating_point(deck_of_bytes(ROTOR, "rotor.yaml"))
    assert not [text for text in base.warnings if "initial velocities" in text]


def test_rounding_of_the_velocity_of_a_body_that_turns_in_place_is_not_reported():
    """A rotor out of balance in a bearing along [2, 3, 7] that is elastic across its axis: 1e-20 m/s."""
    soft = "{along_1: {spring: 1.0e+5}, along_2: {spring: 1.0e+5}}"
    bearing = f"{{type: hinge, nodes: [ground, shaft], axis: [2, 3, 7], compliance: {soft}}}"
    turning = "initial.velocities=[{nodes: [shaft], angular_velocity: [2, 3, 7]}]"
    base = operating_point(input_deck("elastic_bearing", f"joints={{bearing: {bearing}}}", turning))
    assert not [text for text in base.warnings if "initial velocities" in text]


FALLING = """
mecano: 1
gravity: [0, 0, -9.81]
nodes: {top: {position: [0, 0, 1]}, low: {position: [0, 0, 0]}}
elements:
  ball: {type: point_mass, node: low, mass: 1}
  strut: {type: spring_damper, nodes: [top, low], law: {spring: 1000}}
initial: static
time: {end: 1, step: 1 ms}
"""


def test_warnings_are_printed_before_a_start_that_fails(tmp_path):
    """The upper end of the strut, which nothing holds, is why there is no equilibrium."""
    (tmp_path / "falling.yaml").write_text(FALLING)
    code, _, err = mecano_process("run", "falling.yaml", cwd=tmp_path)
    warning, failure = err.find("node top: nothing gives mass"), err.find("no equilibrium was found")
    assert code == 3 and 0 <= warning < failure


def test_a_limit_that_was_exceeded_is_printed_and_stored(tmp_path):
    """The deformation of the tyre against the validity of its law; nothing is said where it holds."""
    name, short = "nose_gear_rigid", "time.end=0.1"
    err, results = run_of(tmp_path, name, short, "tire_laws.nose_tire.valid_deformation=0.05")
    highest = results.extremes["elements/wheel/deformation"]
    wanted = f"wheel 'wheel': deformation reached {highest.maximum:.4g} at t = {highest.maximum_time:.4g} s, but "
    assert highest.maximum > 0.05 and wanted in results.reason and wanted in flowing(err)
    assert results.status == "complete" and results.reason.startswith("the end was reached; ")
    assert "0.05 m" in results.reason and [text for text in results.warnings if text.startswith(wanted)]
    results.close()
    (tmp_path / "reported.h5").unlink()
    err, results = run_of(tmp_path, name, short)
    assert results.reason == "the end was reached" and "deformation" not in err


def test_a_bushing_that_turns_by_half_a_turn_is_reported(tmp_path):
    """Its moment jumps there; a bushing without moments may turn freely."""
    text = (
        "mecano: 1\ngravity: none\nnodes: {hub: {position: [0, 0, 0]}}\nelements:\n"
        "  rotor: {type: rigid_body, node: hub, mass: 1, inertia: [0.1, 0.1, 0.1]}\n"
        "  mount: {type: bushing, nodes: [ground, hub], stiffness: [9, 9, 9, 0, 0, MOMENT]}\n"
        "initial: {velocities: [{nodes: [hub], angular_velocity: [0, 0, 5]}]}\ntime: {end: 0.7, step: 1 ms}\n"
    )
    for moment, wanted in ((0.0, "the end was reached"), (0.1, "bushing 'mount': rotation_vector.z reached 3.1")):
        path = tmp_path / f"{moment}.yaml"
        path.write_text(text.replace("MOMENT", str(moment)))
        with mecano.run(path, tmp_path / f"{moment}.h5", quiet=True) as results:
            assert wanted in results.reason and ("half a turn" in results.reason) == (moment > 0.0)


def test_chosen_defaults_are_stored_and_shown(tmp_path):
    _, results = run_of(tmp_path, "double_pendulum", "time.end=2")
    chosen = results.automatic
    deck = input_deck("double_pendulum")
    assert set(chosen) == {
        "length_scale",
        "minimum_step",
        "maximum_step",
        "k",
        "penalty",
        "increment_tolerance",
        "force_tolerance",
    }
    positions = [node["position"] for node in deck.values["nodes"].values()]
    assert chosen["length_scale"] == length_scale([type("Node", (), {"x": x}) for x in positions])
    assert 0 < chosen["penalty"] < chosen["k"]  # of bars that are thin
    assert chosen["maximum_step"] == deck.values["time"]["step"]
    shown = info(tmp_path)
    assert f"automatic length scale {chosen['length_scale']:.4g}" in shown and f"k {chosen['k']:.4g}" in shown


def test_radau_has_no_criteria_of_generalized_alpha(tmp_path):
    _, results = run_of(tmp_path, "double_pendulum", "time.end=0.01", "time.method=radau")
    assert set(results.automatic) == {"length_scale", "minimum_step", "maximum_step", "k"}


def test_nodes_of_the_ground_are_no_outputs(tmp_path):
    """A joint to the ground makes a node of its own, which no deck names."""
    _, results = run_of(tmp_path, "double_pendulum", "time.end=2")
    names = {name.split("/")[1] for name in results.names("nodes/*")}
    assert names == set(input_deck("double_pendulum").values["nodes"])


def test_values_of_the_deck_are_no_defaults(tmp_path):
    _, results = run_of(tmp_path, "double_pendulum", "time.end=0.01", "time.scale={k: 123.0, penalty: 0.0}")
    assert (results.automatic["k"], results.automatic["penalty"]) == (123.0, 0.0)


@pytest.mark.parametrize(
    ("overrides", "shown"),
    [((), "[0, 0, -9.81] m/s2"), (("gravity=[0, 0, -1.62]",), "[0, 0, -1.62] m/s2"), (("gravity=none",), "none")],
)
def test_check_shows_the_gravity(overrides, shown):
    assert f"gravity {shown} " in check(*overrides)


AMOUNTS = [  # overrides of the pendulum, steps and saved times foreseen, made
    ((), (2000, 201), (2000, 201)),
    (("time.step=3.0e-3",), (667, 201), (667, 201)),
    (("output.every=step",), (2000, 2001), (2000, 2001)),
    (("output.every=0.3",), (2000, 8), (2000, 8)),
    (("time.adaptive={tolerance: 1.0e-3}",), (None, 201), (None, 201)),
    (("time.adaptive={tolerance: 1.0e-3}", "output.every=step"), (None, None), (None, None)),
]


@pytest.mark.parametrize(("overrides", "foreseen", "made"), AMOUNTS)
def test_predicted_steps_and_saved_times_are_those_of_the_run(overrides, foreseen, made, tmp_path):
    values = input_deck("pendulum", *overrides).values
    assert (steps(values), saved_times(values)) == foreseen
    _, results = run_of(tmp_path, "pendulum", *overrides)
    counts = len(results.steps), len(results.time)
    assert all(wanted in (None, found) for wanted, found in zip(made, counts, strict=True)), counts
    if None not in foreseen:
        with h5py.File(tmp_path / "reported.h5", locking=False) as file:
            tables = [file[f"storage/{name}"] for name in ("output", "solver")]
            row, history = (table.shape[1] for table in tables)
            assert result_bytes(values, row, history) == sum(8 * table.size for table in tables)


def test_absurd_amounts_are_warned_of_before_the_run():
    out = check("time.step=1.0e-8")
    assert "2e+08 steps of 1e-08 s are needed: is 'time.step' intended?" in out
    assert "the results file will have about 14.4 GB" in out
    out = check("output.every=1.0e-8")
    assert "the results file will have about 56 GB" in out and "are asked for" not in out
    assert "only the start and the end are saved" in check("output.every=5") and "only" not in check("output.every=2")
    assert "warning" not in check()
    said = startup_warnings(prepare(input_deck("pendulum", "time.step=1.0e-8")))
    assert len(said) == 2 and said[0].startswith("2e+08 steps") and said[1].startswith("the results file")


def test_a_fixed_step_that_newton_cannot_take_is_reported():
    values = {"adaptive": None, "step": 0.1}
    (text,) = step_cut_warnings(values, [(0.0, 0.025), (0.3, 0.00625)], SimpleNamespace(steps=199))
    assert "failed in 2 trials, first at t = 0 s, and steps were cut to as little as 0.00625 s (199 steps" in text
    assert not list(step_cut_warnings(values, [(0.0, 0.025)], SimpleNamespace(steps=100)))
    assert not list(
        step_cut_warnings({**values, "adaptive": {"tolerance": 1e-4}}, [(0.0, 0.025)], SimpleNamespace(steps=5))
    )


def test_energy_that_is_lost_or_comes_from_nothing_is_reported(tmp_path):
    """Steps of a fifth of a period: numerical damping takes energy; without it, the balance only wavers."""
    long = ("time.step=0.3", "time.end=3", "output.every=step")
    err, results = run_of(tmp_path, "pendulum", *long)
    balance = results.extremes["energy/balance"]
    exchanged = max(np.ptp(results[f"energy.{name}"].values) for name in ("kinetic", "potential"))
    share = (balance.maximum - balance.minimum) / exchanged
    assert share > 0.01 and f"J, {100 * share:.3g} % of the largest change of an energy" in results.reason
    first, last = f"{balance.maximum_time:.4g} s", f"{balance.minimum_time:.4g} s"
    assert f"highest at t = {first} and lowest at t = {last}" in results.reason
    assert "Energy is lost by numerical damping" in flowing(err) and "smaller 'time.step'" in flowing(err)


@pytest.mark.parametrize(
    ("low_at", "rho", "reported"),
    [(2.0, 0.8, "lost by numerical damping of"), (2.0, 1.0, "lost by integration error"), (0.5, 0.8, "creates energy")],
)
def test_a_balance_is_judged_by_the_energy_exchanged_before(low_at, rho, reported):
    """Kinetic and potential energy exchange 10 J, the balance is off by 0.2 J; at 0.05 J nothing is said."""
    names = ("kinetic", "potential", "dissipated", "given", "balance")
    sampler = SimpleNamespace(starts={f"energy/{name}": i for i, name in enumerate(names)})
    extremes = SimpleNamespace(
        high=np.array([10.0, 0.0, 0.0, 0.0, 0.0]), low=np.array([0.0, -10.0, 0.0, 0.0, -0.2]),
        high_time=np.full(5, 1.0), low_time=np.full(5, low_at),
    )  # fmt: skip
    values = {"adaptive": {"tolerance": 1e-3}, "step": 0.1, "rho_inf": rho}
    (text,) = energy_warnings(values, sampler, extremes, 1.0, 1.0)
    assert reported in text and "by 0.2 J, 2 % of" in text and "smaller 'time.adaptive.tolerance'" in text
    extremes.low[4] = -0.05
    assert not list(energy_warnings(values, sampler, extremes, 1.0, 1.0))


def test_the_energy_of_rounding_errors_is_not_judged(tmp_path):
    """The axis of the hinge is vertical: nothing moves, but by rounding errors in the constraints of the tip."""
    text = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {pin: {position: [0, 0, 0]}, tip: {position: [1, 0, 0]}}
    elements:
      bar:
        {type: rigid_body, node: pin, mass: 2, center_of_mass: [0.5, 0, 0], inertia: [1.0e-3, 0.17, 0.17],
         attached: [tip]}
    joints: {hinge: {type: hinge, nodes: [ground, pin], axis: [0, 0, 1]}}
    time: {end: 0.1, step: 1 ms}
    """
    path = tmp_path / "r.h5"
    dynamic.run(deck_of_bytes(textwrap.dedent(text).encode(), "test.yaml"), path)
    with mecano.open_results(path) as results:
        assert 0.0 < results.extremes["energy/kinetic"].maximum < 1e-30 and results.warnings == []


def test_an_error_of_a_conserved_kinetic_energy_is_compared_with_it(tmp_path):
    """A free body spins about changing axes: all that changes its energy is the error of the steps."""
    err, results = run_of(tmp_path, "free_body", "time.step=0.5", "output.every=step")
    energy, balance = results.extremes["energy/kinetic"], results.extremes["energy/balance"]
    share = (balance.maximum - balance.minimum) / energy.maximum
    assert share > 0.01 and f"J, {100 * share:.3g} % of the kinetic energy" in results.reason
    assert f"J, {share:.2g} of the kinetic energy" in info(tmp_path)
    drawn = {sheet.name: sheet for sheet in default_sheets(open_runs([tmp_path / "reported.h5"]))}["energy"].panels[-1]
    saved = results["energy.balance"].values
    np.testing.assert_allclose(drawn.curves[0].y.values, (saved - saved[0]) / energy.maximum, rtol=1e-14)
    assert drawn.note == "relative to the kinetic energy"


@pytest.mark.parametrize(
    ("read", "speed", "warned"), [("g.angle", 3, True), ("g.angle", 1, False), ("g.rate", 3, False)]
)
def test_an_angle_within_one_turn_that_jumps_in_a_formula_is_reported(read, speed, warned, tmp_path):
    """A generic joint turns by 6 rad, by 2 rad, or nothing reads its angle."""
    text = f"""
    mecano: 1
    gravity: none
    nodes: {{a: {{position: [0, 0, 0]}}}}
    elements: {{body: {{type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}}}}
    joints: {{g: {{type: generic, nodes: [ground, a], free: [about_axis], axis: [0, 0, 1]}}}}
    signals: {{seen: {read}}}
    initial: {{velocities: [{{nodes: [a], angular_velocity: [0, 0, {speed}]}}]}}
    time: {{end: 2, step: 10 ms}}
    """
    path = tmp_path / "r.h5"
    dynamic.run(deck_of_bytes(textwrap.dedent(text).encode(), "test.yaml"), path)
    with mecano.open_results(path) as results:
        said = [text for text in results.warnings if "jumped by 2 pi" in text]
    assert bool(said) == warned and all("generic 'g': its angle, read by 'g.angle'" in text for text in said)


UNBALANCED = """
    mecano: 1
    gravity: none
    nodes: {hub: {position: [0, 0, 0]}, weight: {position: [0.5, 0, 0]}}
    elements:
      rotor: {type: rigid_body, node: hub, mass: 3, inertia: [4, 4, 4], attached: [weight]}
      mass: {type: point_mass, node: weight, mass: 0.01}
    joints:
      axle: {type: hinge, nodes: [ground, hub], axis: [0, 1, 0]}
    initial: {velocities: [{nodes: [hub, weight], angular_velocity: [0, 300, 0], about: [0, 0, 0]}]}
    time: {end: 0.05, step: 1 ms}
"""


CARRIED = """
    joints:
      rails: {type: prismatic, nodes: [ground, carriage], axis: [1, 0, 0]}
      axle: {type: hinge, nodes: [carriage, hub], axis: [0, 1, 0]}
"""


@pytest.mark.parametrize(
    ("step", "rho", "reported", "speed"),
    [
        (1e-3, 0.8, True, 0),
        (5e-4, 0.8, False, 0),
        (3.125e-4, 0.0, True, 0),
        (1e-3, 0.8, True, 40),
        (5e-4, 0.8, False, 40),
    ],
)
def test_a_mass_that_circles_far_in_each_step_is_reported(step, rho, reported, speed):
    """The centrifugal force of 450 N is wrong by what is reported, to a tenth; also on a carriage that moves."""
    text = UNBALANCED.replace("1 ms", f"{step}, rho_inf: {rho}")
    if speed:
        text = text.replace("nodes: {hub", "nodes: {carriage: {position: [0, 0, 0]}, hub")
        text = text.replace(
            "mass: {type",
            "carriage: {type: rigid_body, node: carriage, mass: 1e6, inertia: [1, 1, 1]}\n      mass: {type",
        )
        text = text.replace(
            "    joints:\n      axle: {type: hinge, nodes: [ground, hub], axis: [0, 1, 0]}\n", CARRIED[1:]
        )
        text = text.replace("velocities: [", f"velocities: [{{nodes: all, velocity: [{speed}, 0, 0]}}, ")
    given = deck(text)
    recorded = RecordedRun(given)
    off, rows = np.linalg.norm(recorded["joints/axle/force"][-1]) / 450.0 - 1, recorded.rows
    extremes = SimpleNamespace(high=rows.max(axis=0), low=rows.min(axis=0))
    texts = list(
        circle_warnings(given.values["time"], recorded.integrator.method, recorded.run, recorded.sampler, extremes)
    )
    assert bool(texts) == reported == (off > 0.007)
    if reported:
        assert "node 'weight' moves on a circle of 0." in texts[0] and "N of its mass is wrong by" in texts[0]
        assert float(texts[0].split("some ")[1].split(" %")[0]) == pytest.approx(100 * off, rel=0.1)


@pytest.mark.parametrize("command", ["check", "modes --force", "modes --force --sweep elements.bar.mass=1,2"])
def test_modes_and_check_say_that_they_compile(command, tmp_path, monkeypatch, capsys):
    """As a run does: nothing else is reported while it compiles."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("mecano.analyses.progress.while_compiling", lambda listener: nullcontext(listener(0, 1)))
    for quiet in ((), ("-q",)):
        name, *options = command.split()
        commands([name, str(INPUTS / "pendulum.yaml"), *options, *quiet], standalone_mode=False)
        assert ("mecano: compiling elements used for the first time" in capsys.readouterr().err) == (not quiet)


def test_time_for_compiling_is_separate(monkeypatch, capsys):
    """100 s before and 500 s in between, which count as if they had passed."""
    monkeypatch.setattr(machine_code, "_times", [100.0])
    progress = Progress({"start": 0.0, "end": 1.0}, False, "r.h5")
    machine_code._times.append(500.0)
    progress.begun -= 500.0
    progress.finished("3 steps")
    reported = capsys.readouterr().err
    assert re.match(r"mecano: 3 steps, in 0\.\d\d s and 500\.00 s for compiling\n", reported)


def test_friction_at_rest_is_reported_as_a_damper():
    """The joint of the deck swings; at rest its friction is a damper, at 1 rad/s it is beyond its regularization."""
    at_rest = "while it sticks, and small motions include that damper"
    rest = input_deck("friction_pendulum", "initial.velocities=[]")
    reported = modes(rest, None)[0]
    assert (
        "mecano: hinge 'hinge': regularized friction acts as a strong viscous damper" in reported
        and at_rest in reported
    )
    swinging = input_deck("friction_pendulum", "initial.velocities=[{nodes: [pin], angular_velocity: [0, 1, 0]}]")
    assert at_rest not in modes(swinging, None)[0]


def test_dry_friction_of_a_law_at_rest_is_reported_as_a_damper():
    """The seals of a strut: at rest, but neither while it moves faster than its regularization nor without friction."""
    at_rest = "spring_damper 'absorber': regularized friction acts as a strong viscous damper"
    assert at_rest in modes(input_deck("nose_gear_rigid"), None)[0]
    apart = "initial.velocities=[{nodes: [leg_head], velocity: [0, 0, 1]}]"
    for changes in ("laws.oleo.dry_friction.force=0", apart):
        assert at_rest not in modes(input_deck("nose_gear_rigid", changes), None)[0]


@pytest.mark.parametrize(("turned", "within"), [(0.0, True), (0.003, False)])
def test_small_motions_within_free_play_are_reported(turned, within):
    """The torque link has no stiffness up to 2 mrad; the springs of its damper and tyre alone do not count as play."""
    play = "torsion_spring_damper 'torque_link': small motions lie within the free play"
    natural = f"elements.torque_link.natural_angle={turned}"
    assert (play in modes(input_deck("shimmy_freeplay", natural), None)[0]) == within
    without_play = "spring: 5.0e4", "dead_band: {lower: 0, upper: 0, stiffness: 5.0e4}"
    for spring in without_play:
        law = f"laws.link={{damper: {{coefficient: 10}}, {spring}}}"
        assert play not in modes(input_deck("shimmy_freeplay", law), None)[0]


@pytest.mark.parametrize(
    ("name", "mass", "loose"),
    [
        ("superelement_arm", 12, "80: 0 with flexible members held rigid, 80 by their deformation redundant 0"),
        ("beam_spin_up", 12, "48: 0 with flexible members held rigid, 48 by their deformation redundant 0"),
        ("flexible_pendulum", 0.0863938, "49: 1 with flexible members held rigid, 48 by their deformation mech"),
        ("caster_shimmy", 12, "5: 2 with flexible members and tyres held rigid, 3 by their deformation 1 independent"),
        ("digital_control", 4, "2 2 independent motion(s): node cart: displacement x; node shuttle: displacement x"),
        ("hanging_chain", 1.5, "5 3 independent motion(s): node p1: displacement y; node p2: displacement y; node p3"),
    ],
)
def test_check_reports_mass_and_mobility(name, mass, loose):
    """Masses: 1.2 kg/m over 10 m, twice; 1100 kg/m3 in a rod of 10 mm and 1 m; 2 + 10 kg; 2 of 2 kg; 3 of 0.5 kg."""
    said = flowing(summary(input_deck(name)))
    assert f" mass {mass} kg " in said and f" mobility {loose}" in said


def test_check_says_why_motions_of_a_large_model_are_not_named(monkeypatch):
    """Three points on four rods: they are counted."""
    monkeypatch.setattr("mecano.solve.diagnostics.mobility.MANY", 2)
    chain = input_deck("hanging_chain")
    assert "mobility         5\n  free motions are not listed for more than" in summary(chain)
    assert startup_warnings(prepare(chain)) == []


def test_check_names_the_first_of_many_mechanisms():
    """Six chains of three masses, each with two motions in its plane and three across it."""
    links = "{repeat: {c: 1..6, i: 1..4}, type: rigid_rod, nodes: [p$(c)_$(i - 1), p$(c)_$i]}"
    deck = deck_of_bytes(f"""
mecano: 1
gravity: [0, 0, -9.81]
nodes:
  p$(c)_$i: {{repeat: {{c: 1..6, i: 0..4}}, position: [$i, '$c', '-0.1 * $i * (4 - $i)'], fixed: false}}
elements: {{m$(c)_$i: {{repeat: {{c: 1..6, i: 1..3}}, type: point_mass, node: p$(c)_$i, mass: 1}}}}
joints: {{rod$(c)_$i: {links}, a$(c): {{repeat: {{c: 1..6}}, type: spherical, nodes: [ground, p$(c)_0]}},
  b$(c): {{repeat: {{c: 1..6}}, type: spherical, nodes: [ground, p$(c)_4]}}}}
time: {{end: 1, step: 0.1}}
""".encode(), "chains.yaml")  # fmt: skip
    short, long = flowing(summary(deck)), flowing(summary(deck, every=True))
    assert "18 independent motion(s): node p1_1: displacement y; node p1_2: displacement y;" in short
    assert "and 12 more mechanism of 2 degree(s) of freedom" in short and "more" not in long
    assert "and 2 more mechanism(s) of 4 degree(s) of freedom together" in short
    assert short.count("mechanism of") == 4 and long.count("mechanism of") == 6


@pytest.mark.parametrize("start, line", [(0.0, "t = 1.53 of 2 s"), (1e6, "t = 1000001.53 of 1000002 s")])
def test_progress_shows_hundredths_of_a_run_however_late(start, line, capsys):
    progress = Progress({"start": start, "end": start + 2.0}, quiet=False, path="results.h5")
    progress(SimpleNamespace(motion=SimpleNamespace(t=start + 1.53), h=1e-3))
    assert capsys.readouterr().err == f"{line}, step 0.001 s\n"


def test_progress_shows_a_line_each_minute_and_the_remaining_time_at_the_present_pace(monkeypatch, capsys):
    """Half of the run takes 50 s, then 1e-4 of it takes 1 s: 0.5/1e-4 s are left; tenths follow one another fast."""
    now = [0.0]
    monkeypatch.setattr("mecano.analyses.progress.time.monotonic", lambda: now[0])
    progress = Progress({"start": 0.0, "end": 1.0}, quiet=False, path="results.h5")
    for second in range(180):
        now[0], t = float(second), min(0.01 * second, 0.5) + 1e-4 * max(second - 50, 0)
        progress(SimpleNamespace(motion=SimpleNamespace(t=t), h=1e-3))
    *tenths, minute, last = capsys.readouterr().err.splitlines()
    assert [line.split()[2] for line in tenths] == ["0.1", "0.2", "0.3", "0.4", "0.5"]
    assert tenths[-1].endswith("50 s left")
    assert minute == "t = 0.506 of 1 s, step 0.001 s, 4940 s left"
    assert last == "t = 0.512 of 1 s, step 0.001 s, 4880 s left"


@pytest.mark.parametrize(("rate", "warned"), [(0.99995, False), (0.999, True)])
def test_velocities_with_the_digits_of_decks_are_not_reported(rate, warned, tmp_path):
    """The upper bar turns at 1 rad/s, its end 1 m away moves at 1 m/s: that is corrected by 5e-5 or by 1e-3 of it."""
    whole = "{nodes: [pin, elbow, lower_end], angular_velocity: [0, 1, 0], about: [0, 0, 0]}"
    less = f"{{nodes: [elbow, lower_end], velocity: [0, 0, {1 - rate:.5f}]}}"
    given = input_deck("double_pendulum", f"initial.velocities=[{whole}, {less}]", "time.end=2")
    dynamic.run(given, tmp_path / "r.h5")
    said = mecano.open_results(tmp_path / "r.h5").warnings
    assert any("violate the constraints" in text for text in said) == warned

"""Error control: the error of a run is proportional to the tolerance; see the tables in docs/step-control.md."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck, input_deck, one_by_one
from work_precision import CASES, adaptive, fixed

from mecano.analyses.prepare import control_of, prepare, startup_warnings
from mecano.errors import ConvergenceError
from mecano.solve.time.step_control import StepControl

FAST = {"four_bar": (1e-3, 1e-4, 1e-5), "wheel_drop": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)}
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
MOST = {"heavy_top": 10.0}  # times the tolerance: it amplifies errors of its axis (docs/step-control.md); 3 for others
REJECTED = 0.08  # share of the trial steps that the controller may waste


def check_tolerances(name, tolerances):
    """Errors within a factor (MOST) of each tolerance, each smaller than the one before; few rejections."""
    errors = []
    for tolerance in tolerances:
        recorded, error = adaptive(name, tolerance)
        errors.append(error)
        assert 0.1 <= error / tolerance <= MOST.get(name, 3.0)
        assert recorded.run.rejected <= REJECTED * recorded.run.steps
    assert np.all(np.diff(errors) < 0.0)


@pytest.mark.parametrize("name", FAST)
def test_error_follows_the_tolerance(name):
    check_tolerances(name, FAST[name])


def test_newton_leaves_less_than_a_tight_tolerance():
    """A bicycle on rolling wheels at 1e-8, beside Radau IIA: forces of 1e-7 left by Newton would cause 9e-8."""
    run = RecordedRun(input_deck("bicycle", "time.end=1", "time.adaptive={tolerance: 1e-8}"))
    exact = RecordedRun(input_deck("bicycle", "time.end=1", "time.adaptive={tolerance: 1e-11}", "time.method=radau"))
    for path in ("nodes/frame/position", "nodes/fork/position", "nodes/rear_hub/position"):
        np.testing.assert_allclose(run[path][-1], exact[path][-1], rtol=0, atol=1e-8)


PRECESSION = """
mecano: 1
gravity: [0, 0, -9.81]
nodes:
  pivot: {{position: [0, 0, 0], orientation: [{tilt}, 0, 0]}}
elements:
  top:
    type: rigid_body
    node: pivot
    mass: 15.0
    center_of_mass: [0, {length}, 0]
    inertia: [0.234375, 0.46875, 0.234375]
joints:
  ball: {{type: spherical, nodes: [ground, pivot]}}
initial:
  velocities: [{{nodes: [pivot], angular_velocity: {velocity}}}]
time: {{end: 1.0, step: 2.0e-4, adaptive: {{tolerance: {tolerance}}}}}
"""


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4])
@pytest.mark.parametrize(("length", "most"), [(0.5, 3.0), (1.0, 11.0)])
def test_error_of_a_steady_precession_follows_the_tolerance(length, most, tolerance):
    """The height of the centre of mass stays l/2: m g l = Omega (C n - A Omega cos(theta)), Goldstein, ch. 5.7.

    The axis is 60 degrees from the vertical; A is the moment of inertia about the pivot. A top with A = 32 C amplifies
    errors of its axis: by them its angular momentum is wrong in A, its gyroscopic moment in C.
    """
    A, C, weight, tilt, n = 0.234375 + 15.0 * length**2, 0.46875, 15.0 * length * 9.81, np.pi / 3, 150.0
    rate = min(np.roots([-A * np.cos(tilt), C * n, -weight]))
    axis = np.array([0.0, np.sin(tilt), np.cos(tilt)])
    velocity = rate * np.array([0.0, 0.0, 1.0]) + (n - rate * np.cos(tilt)) * axis
    values = {"tilt": np.pi / 2 - tilt, "velocity": velocity.tolist(), "tolerance": tolerance, "length": length}
    recorded = RecordedRun(deck(PRECESSION.format(**values)))
    error = np.abs(recorded["elements/top/center_of_mass"][:, 2] - 0.5 * length).max() / length
    assert 0.1 * tolerance <= error <= most * tolerance


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_error_follows_every_tolerance(name):
    check_tolerances(name, TOLERANCES)


@pytest.mark.parametrize(("name", "h", "gain"), [("four_bar", 2e-3, 1.5), ("wheel_drop", 1e-3, 2.0)])
def test_fewer_steps_than_fixed_ones(name, h, gain):
    """At the error of fixed steps, which falls with the square of their size, error control takes fewer."""
    recorded, error = adaptive(name, 1e-4)
    every, error_of_fixed = fixed(name, h)
    needed = every.run.steps * np.sqrt(error_of_fixed / error)
    assert gain * recorded.run.steps < needed


def test_step_sizes_follow_the_motion():
    """Long steps in flight, short ones on the ground; a step keeps its size most of the time."""
    recorded, _ = adaptive("wheel_drop", 1e-5)
    h, load = np.diff(recorded.time), recorded["elements/tire/normal_force"][1:]
    assert np.median(h[load == 0.0]) > 3.0 * np.median(h[load > 0.0])
    changes = np.abs(np.diff(h)) > 1e-9 * h[1:]
    assert changes.mean() < 0.2


GEAR_DROP = """
mecano: 1
gravity: [0, 0, -9.81]
nodes:
  top: {{position: [0, 0, 1.8325]}}
  slider: {{position: [0, 0, 0.3325]}}
  axle: {{position: [0, 0, 0.3325]}}
elements:
  top_mass: {{type: rigid_body, node: top, mass: 6440, inertia: [5000, 5000, 5000]}}
  slider_mass: {{type: rigid_body, node: slider, mass: 150, inertia: [5, 5, 2]}}
  wheel_mass: {{type: rigid_body, node: axle, mass: 60, inertia: [1.8, 3.0, 1.8]}}
  strut: {{type: spring_damper, nodes: [top, slider], natural_length: 1.5, law: oleo}}
  wheel: {{type: wheel, node: axle, axis: [0, 1, 0], tire_law: tyre, ground: runway}}
joints:
  upright: {{type: held_rotation, nodes: [ground, top]}}
  straight: {{type: prescribed_position, node: top, direction: [0, 1, 0], value: 0.0}}
  slide: {{type: prismatic, nodes: [top, slider], axis: [0, 0, 1]}}
  bearing: {{type: hinge, nodes: [slider, axle], axis: [0, 1, 0]}}
laws:
  oleo: {{spring: {{stiffness: 1.2e5}}, damper: {{coefficient: 4.0e4}}}}
tire_laws:
  tyre: {{radius: 0.3225, radial: {{linear: {{slope: 1.2e6}}}}, friction: 0.6, slip_regularization: 0.5}}
grounds:
  runway: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}
initial: {{velocities: [{{nodes: all, velocity: [60, 0, -3.05]}}]}}
time: {{end: 3.0, step: 1.0e-3, rho_inf: 0.8, adaptive: {{tolerance: {tolerance}}}}}
"""

LOOSE = (1e-1, 1e-2, 1e-3)


def test_a_looser_tolerance_never_costs_more():
    """Trials of a landing gear whose wheel spins at 186 rad/s, which no step may turn by more than 2.4 rad."""
    work = []
    for tolerance in (1e-1, 1e-2, 1e-3, 1e-4):
        recorded = RecordedRun(deck(GEAR_DROP.format(tolerance=tolerance)))
        work.append(recorded.run.steps + recorded.run.rejected)
        assert len(recorded.integrator.cuts) <= 3
    assert work == sorted(work) and work[-1] > 5 * work[0]


@pytest.mark.parametrize("name", ["main_gear", "wheel_drop", "oleo_drop"])
def test_a_looser_tolerance_never_costs_more_iterations(name):
    """A step after many iterations shrinks, and one after a failed trial does not grow."""
    runs = [RecordedRun(input_deck(name, f"time.adaptive={{tolerance: {tolerance}}}")).run for tolerance in LOOSE]
    work = [run.iterations for run in runs]
    assert work[0] <= 1.2 * work[1] <= 1.2 * work[2]  # 0.03 costs the same as 0.01, within a fifth


def test_the_loosest_tolerance():
    prepared = prepare(input_deck("main_gear", "time.adaptive={tolerance: 0.5}"))
    assert control_of(prepared.deck.values["time"]).tolerance == 0.03
    assert [text for text in startup_warnings(prepared) if "is taken as 0.03, not 0.5" in text]


@pytest.mark.parametrize("control", [StepControl(1e-3, 10.0, 1e-9, 1.0), StepControl(1e-3, 10.0, 1e-9, 1.0, 5)])
@pytest.mark.parametrize("error", [np.nan, np.inf])
def test_a_step_whose_error_is_not_finite_is_cut(control, error):
    """To a fifth, the most that one rejection cuts, whatever the order of the method; nan is no small error."""
    assert not control.accept(error, 1e-2)
    assert control.retry(error, 1e-2) == pytest.approx(2e-3, rel=1e-15)


def test_what_scalars_without_inertia_forget():
    """Their error in a step may be a thousandth of the tolerance, or the share of the step where that is more."""
    control = StepControl(1e-3, 10.0, 1e-9, 1.0)
    for h, most in ((1e-6, 1e-6), (1e-3, 1e-6), (0.1, 1e-5)):
        assert control.accept(control.forgotten(0.999 * most, h), h)
        assert not control.accept(control.forgotten(1.001 * most, h), h)
    assert StepControl.fixed(1e-3, 1e-9).forgotten(0.5, 1e-3) == 0.5


DASHPOT = """
mecano: 1
gravity: none
nodes: {a: {position: [0, 0, 0]}, b: {position: [1, 0, 0]}}
elements:
  a: {type: point_mass, node: a, mass: 1}
  b: {type: point_mass, node: b, mass: 1}
  damper: {type: spring_damper, nodes: [a, b], law: {damper: 5.0e+7}}
initial: {velocities: [{nodes: [a], velocity: [0.1, 0, 0]}]}
time: {end: 20, step: 1 ms, adaptive: {tolerance: 1.0e-6}}
"""


def test_a_damped_transient_much_faster_than_the_run():
    """The relative velocity decays as exp(-r t), r = 2 c/m = 1e8/s, over 5e-10 m: positions within 1e-6."""
    recorded = RecordedRun(deck(DASHPOT))
    t, approach = recorded.time, 0.05 / 1e8 * -np.expm1(-1e8 * recorded.time)
    assert np.abs(recorded["nodes/a/position"][:, 0] - 0.05 * t - approach).max() < 1e-6
    assert np.abs(recorded["nodes/b/position"][:, 0] - 1.0 - 0.05 * t + approach).max() < 1e-6
    assert t[1] < 1e-8


STEERED = """
mecano: 1
gravity: none
nodes:
  yoke: {position: [0, 0, 0]}
  seat: {position: [1, 0, 0]}
  hub: {position: [1, 0, 0]}
elements:
  yoke: {type: rigid_body, node: yoke, mass: 10, inertia: [1, 1, 1], attached: [seat]}
  wheel: {type: rigid_body, node: hub, mass: 18, inertia: [0.5, 0.9, 0.5]}
joints:
  steering: {type: hinge, nodes: [ground, yoke], axis: [0, 0, 1]}
  motor: {type: prescribed_angle, nodes: [ground, yoke], axis: [0, 0, 1], value: 0.5*time}
  axle: {type: hinge, nodes: [seat, hub], axis: [0, 1, 0]}
initial:
  velocities:
    - {nodes: all, angular_velocity: [0, 0, 0.5], about: [0, 0, 0]}
    - {nodes: [hub], angular_velocity: [0, 65, 0], about: own}
time: {end: 1, step: 1 ms, adaptive: {tolerance: 1.0e-4}}
"""


def test_a_steered_wheel_takes_long_steps():
    """A wheel keeps its spin of 65 rad/s; the axle bears the gyroscopic moment C n times the rate of steering."""
    recorded = RecordedRun(deck(STEERED))
    assert recorded.run.steps < 250
    assert np.abs(recorded["joints/axle/angle"] - 65.0 * recorded.time).max() < 1e-4
    moment = np.linalg.norm(recorded["joints/axle/moment"], axis=1)
    assert np.abs(moment / (0.9 * 65.0 * 0.5) - 1.0).max() < 1e-3


def test_redundant_constraints_change_no_error_of_a_step():
    """A second bearing of the yoke repeats constraints; their compliance lets no part of an error pass."""
    steps = []
    for second in ("", "  again: {type: hinge, nodes: [ground, yoke], axis: [0, 0, 1]}\n"):
        steps.append(RecordedRun(deck(STEERED.replace("initial:", f"{second}initial:"))).run.steps)
    assert steps[1] == pytest.approx(steps[0], rel=0.02)


DRIVEN = """
mecano: 1
gravity: [0, 0, -9.81]
nodes: {arm: {position: [0, 0, 0]}}
elements:
  bar: {type: rigid_body, node: arm, mass: 1, center_of_mass: [0.5, 0, 0], inertia: [0.01, 0.1, 0.1]}
joints:
  motor: {type: prescribed_angle, nodes: [ground, arm], axis: [0, 1, 0], value: LAW}
  turn: {type: hinge, nodes: [ground, arm], axis: [0, 1, 0]}
time: {end: 1, step: 1 ms, adaptive: {tolerance: 1.0e-4}}
"""


@pytest.mark.parametrize(
    "law", ["{ramp: {start: 0.2, end: 0.5, from: 0, to: 1}}", "{table: {points: [[0.2, 0], [0.5, 1]], beyond: hold}}"]
)
def test_corners_of_a_motion_that_is_prescribed_wholly(law):
    """No step size resolves a jump of its velocity, of which the constraints leave nothing."""
    recorded = RecordedRun(deck(DRIVEN.replace("LAW", law)))
    expected = np.interp(recorded.time, [0.2, 0.5], [0.0, 1.0])
    assert np.abs(recorded["joints/motor/angle"] - expected).max() < 1e-9


def test_steps_without_numerical_damping_are_as_long_as_others():
    """What the modal filter leaves out at the start alternates without end if rho_inf = 1; it is no error."""
    steps = [
        len(
            RecordedRun(
                deck(f"""
                mecano: 1
                gravity: [0, 0, -9.81]
                nodes: {{wall: {{position: [0, 0, 0], fixed: true}}, tip: {{position: [0.8, 0, 0]}}}}
                elements:
                  body: {{type: rigid_body, node: tip, mass: 6, inertia: [0.1, 0.2, 0.2]}}
                  arm: {{type: beam, nodes: [wall, tip], section: tube, mesh: 3}}
                sections:
                  tube: {{type: tube, diameter: 0.04, thickness: 0.002, E: 5.7e9, nu: 0.3, density: 1500,
                         damping: 0.001}}
                initial: {{velocities: [{{nodes: [tip], velocity: [0, 0, 1]}}]}}
                time: {{end: 0.02, step: 2 ms, rho_inf: {rho}, adaptive: {{tolerance: 1.0e-4}}}}
                """)
            ).time
        )
        for rho in (0.9, 1.0)
    ]
    assert steps[1] < 1.2 * steps[0]


def test_a_tolerance_that_rounding_defeats_is_refused():
    """At 1e-12 each step of 1e-8 s may be off by 2e-19 m: steps would fall without end. At 1e-10 none is refused."""
    with pytest.raises(ConvergenceError, match="(?s)tolerance of 1e-12 cannot be met.* rounding .*radau") as raised:
        RecordedRun(input_deck("four_bar", "time.end=0.05", "time.adaptive.tolerance=1e-12"), change=one_by_one)
    rejected, trials = (int(part.split()[-1]) for part in str(raised.value).split(" trials")[0].split(" of the last "))
    assert 0.2 * trials <= rejected < trials < 3000
    usual = RecordedRun(input_deck("four_bar", "time.end=0.01", "time.adaptive.tolerance=1e-10"))
    assert usual.run.rejected < 10


def test_the_least_step_is_said_to_be_lost_in_rounding():
    """The rounding of steps of 1e-6 s exceeds 1e-12: a smaller least step would not help, Radau IIA would."""
    tight = "time.adaptive={tolerance: 1.0e-12, minimum_step: 1.0e-6}"
    with pytest.raises(ConvergenceError, match="(?s)less than the rounding of positions.*try: a larger.*method: radau"):
        RecordedRun(input_deck("four_bar", "time.end=0.05", tight))


@pytest.mark.parametrize("method", ["generalized_alpha", "radau"])
def test_a_motion_that_grows_without_bound_ends_the_run(method):
    """Positive feedback: its steps would become ever shorter, and fill the disk with their history."""
    checked = deck(f"""
        mecano: 1
        gravity: none
        nodes: {{m: {{position: [0, 0, 0]}}}}
        elements: {{m: {{type: point_mass, node: m, mass: 1}}}}
        joints: {{rail: {{type: prismatic, nodes: [ground, m], axis: [1, 0, 0]}}}}
        signals: {{push: 100*rail.displacement}}
        loads: {{motor: {{type: joint_force, joint: rail, value: push}}}}
        initial: {{velocities: [{{nodes: [m], velocity: [0.01, 0, 0]}}]}}
        time: {{end: 100, step: 1 ms, method: {method}, adaptive: {{tolerance: 1.0e-3, length_scale: 1}}}}
    """)
    message = r"(?s)t = [23]\.\d+ s the motion has grown to .* length scales, and still grows.*is a gain, a stiffness"
    with pytest.raises(ConvergenceError, match=message):
        RecordedRun(checked)

"""Orders of generalized-alpha on the index-3 pendulum: positions, velocities and multipliers, at any steps.

Reference errors: f1_genalpha, a point mass of 1 kg at 1 m, g = 9.81 m/s2, from the horizontal with 2 m/s upwards;
errors of q, v (2-norms) and of the multiplier at 1 s, found independently in Cartesian coordinates.
"""

from functools import cache

import numpy as np
import pytest
from convergence import at_times, check_second_order, pair
from scipy.integrate import solve_ivp
from time_runs import RecordedRun, deck, in_python, input_deck, with_history

from mecano.analyses.dynamic import run
from mecano.analyses.prepare import integrator_of, prepare
from mecano.model.numbering import LENGTH_CONSTRAINT, ROTATION
from mecano.results.reader import open_results

G = np.array([0.0, 0.0, -9.81])
X0, V0 = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 2.0])
STEPS = [2.0**-k for k in range(4, 10)]  # 1/16 ... 1/512 s
VARIED = (1.0, 1.3, 0.7, 0.4, 1.7)  # factors of a step size that changes every step

# (method, rho_inf, history): errors of q, v and multiplier for each of STEPS
REFERENCE = {
    ("generalized_alpha", 0.8, "plain"): [
        (0.0553557, 0.262819, 9.90638),
        (0.0142219, 0.0543225, 0.448159),
        (0.0035734, 0.0134373, 0.0539759),
        (0.000894378, 0.00336194, 0.0138276),
        (0.000223649, 0.000840631, 0.00346082),
        (5.59147e-05, 0.000210164, 0.000865533),
    ],
    ("generalized_alpha", 0.8, "shift"): [
        (0.0554784, 0.264978, 10.2029),
        (0.0142509, 0.0544924, 0.478285),
        (0.00358023, 0.0134687, 0.0541016),
        (0.000896036, 0.00336958, 0.0138746),
        (0.000224059, 0.000842517, 0.00347244),
        (5.60163e-05, 0.000210633, 0.000868416),
    ],
    ("generalized_alpha", 0.5, "shift"): [
        (0.0792173, 0.303992, 0.993817),
        (0.0204421, 0.0777516, 0.293736),
        (0.00512816, 0.0194773, 0.0768386),
        (0.00128051, 0.00486389, 0.0195521),
        (0.000319716, 0.00121471, 0.00492544),
        (7.98646e-05, 0.000303483, 0.00123569),
    ],
    ("generalized_alpha", 0.0, "shift"): [
        (0.231882, 0.946865, 1.12115),
        (0.0725816, 0.288788, 0.661169),
        (0.0191461, 0.0745908, 0.23093),
        (0.00479011, 0.0185422, 0.0658755),
        (0.00118914, 0.00459945, 0.0174255),
        (0.000295701, 0.00114413, 0.00447048),
    ],
    ("hht", 0.8, "shift"): [
        (0.0677727, 0.278551, 1.77113),
        (0.0174179, 0.0669047, 0.176344),
        (0.0043698, 0.0167363, 0.0662273),
        (0.00109185, 0.00418366, 0.0167868),
        (0.000272741, 0.00104543, 0.00421957),
        (6.81483e-05, 0.000261273, 0.0010575),
    ],
}


def pendulum(method, rho, step):
    """The deck of the reference."""
    return deck(f"""\
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes:
          pivot: {{position: [0, 0, 0], fixed: true}}
          mass: {{position: [1, 0, 0]}}
        elements:
          mass: {{type: point_mass, node: mass, mass: 1.0}}
        joints:
          rod: {{type: rigid_rod, nodes: [pivot, mass]}}
        initial: {{velocities: [{{nodes: [mass], velocity: [0, 0, 2]}}]}}
        time: {{end: 1.0, step: {step!r}, method: {method}, rho_inf: {rho}}}
        """)


@cache
def exact():
    """Angle from the horizontal and its rate as a function of time, to 1e-12."""
    return solve_ivp(
        lambda t, y: [y[1], -9.81 * np.cos(y[0])], (0.0, 1.0), [0.0, 2.0],
        method="DOP853", rtol=1e-13, atol=1e-14, dense_output=True,
    ).sol  # fmt: skip


def errors(recorded):
    """Errors (n, 3) of position, velocity and tension at every accepted step."""
    angle, rate = exact()(recorded.time)
    along = np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=1)
    across = np.stack([-along[:, 2], 0 * angle, along[:, 0]], axis=1)
    q = np.linalg.norm(recorded["nodes/mass/position"] - along, axis=1)
    v = np.linalg.norm(recorded["nodes/mass/velocity"] - rate[:, None] * across, axis=1)
    return np.stack([q, v, np.abs(recorded["joints/rod/tension"] - rate**2 + 9.81 * np.sin(angle))], axis=1)


def acceleration(x, v):
    """Of the mass, with the multiplier eliminated."""
    return G - x * (x @ G + v @ v)


def jerk():
    """Rate of the acceleration at the start."""
    a = acceleration(X0, V0)
    return -V0 * (X0 @ G + V0 @ V0) - X0 * (V0 @ G + 2.0 * V0 @ a)


def start_of_the_reference(history):
    """The history of the reference: a_0 = q''_0, for ``shift`` a_0 = q''_0 + (am - af) h q'''_0; v_0 not shifted."""

    def change(integrator, run):
        c, first = integrator.method.coefficients, integrator.system.numbering.x[1]
        a = np.zeros_like(run.history.a)
        shift = (c.am - c.af) * run.h if history == "shift" else 0.0
        a[first : first + 3] = acceleration(X0, V0) + shift * jerk()
        return with_history(run, a=a, v_shift=np.zeros_like(a))

    return change


@pytest.mark.parametrize(("method", "rho", "history"), REFERENCE)
def test_errors_of_the_reference(method, rho, history):
    """To 3 digits of the error: the integrator is the published one."""
    change = start_of_the_reference(history)
    found = [errors(RecordedRun(pendulum(method, rho, h), change=change))[-1] for h in STEPS]
    np.testing.assert_allclose(found, REFERENCE[method, rho, history], rtol=1e-3)


class Pattern:
    """Step sizes that change at every step by given factors of ``step``."""

    minimum = 1e-9

    def __init__(self, step, factors):
        self.step, self.factors, self.taken = step, factors, 0

    def forgotten(self, lag, h):
        return lag

    def accept(self, error, h):
        return True

    def holds(self, error, h):
        return False

    def after(self, error, h, iterations=0):
        self.taken += 1
        return self.step * self.factors[self.taken % len(self.factors)]


def with_pattern(factors):
    def change(integrator, run):
        integrator.control = integrator.trials.control = Pattern(run.h, factors)
        return in_python(integrator, run)

    return change


METHODS = [("generalized_alpha", 0.8), ("generalized_alpha", 0.5), ("hht", 0.8)]


def orders(method, rho, change, reduce):
    """Orders (2, 3) of the errors, reduced over the run, between 1/128, 1/256 and 1/512 s."""
    found = [reduce(errors(RecordedRun(pendulum(method, rho, h), change=change))) for h in (1 / 128, 1 / 256, 1 / 512)]
    return np.log2(np.array(found[:-1]) / np.array(found[1:]))


@pytest.mark.parametrize(("method", "rho"), METHODS)
def test_order_of_fixed_steps(method, rho, verify):
    """Two for all, at the end and for the largest error of the run, the first step among them."""
    change = with_pattern((1.0,))
    what = f"index-3 pendulum, {method}, rho = {rho}: orders of angle, rate and multiplier, "
    at_end = orders(method, rho, change, lambda e: e[-1])
    verify("Integrator", what + "at the end", at_end, 2.0, "order of the method", absolute=0.05)
    greatest = orders(method, rho, change, lambda e: e.max(axis=0))
    verify("Integrator", what + "largest errors of the run", greatest, 2.0, "order of the method", absolute=0.05)


@pytest.mark.parametrize(("method", "rho"), METHODS)
def test_order_of_steps_that_always_change(method, rho, verify):
    greatest = orders(method, rho, with_pattern(VARIED), lambda e: e.max(axis=0))
    what = f"index-3 pendulum, {method}, rho = {rho}: orders, steps that always change"
    verify("Integrator", what, greatest, 2.0, "order of the method", absolute=0.05)


def constraints_watched(worst):
    """A change of the integrator: record the largest constraint of each step, over length scale or one radian."""

    def change(integrator, run):
        system, n_q, n = integrator.system, integrator.system.n_q, integrator.system.n
        scale = np.where(system.numbering.kind[n_q:n] == LENGTH_CONSTRAINT, integrator.method.length, 1.0)
        integrator.observers += (
            lambda step: worst.append(np.abs(system.constraint_derivatives(step.run.motion)[:, 0] / scale).max()),
        )
        return run

    return change


@pytest.mark.parametrize(("name", "most"), [("pendulum", 2), ("spherical_pendulum", 2), ("four_bar", 3)])
def test_newton_does_not_depend_on_the_step_size(name, most):
    """100 steps each of 1e-6, 1e-4 and 1e-2 s: one or two iterations with new tangents, constraints to 1e-10.

    Redundant constraints, to 1e-14, need a third one.
    """
    iterations, worst = [], []
    for h in (1e-6, 1e-4, 1e-2):
        values = (
            f"time.step={h}",
            f"time.end={100 * h}",
            f"output.every={h}",
            f"time.newton={{maximum_iterations: {most}}}",
        )
        recorded = RecordedRun(input_deck(name, *values), change=constraints_watched(worst))
        assert len(recorded.iterations) == 100
        iterations += [recorded.iterations.min(), recorded.iterations.max()]
    assert {1} <= {*iterations} <= {*range(1, most + 1)}
    assert len(worst) == 300 and max(worst) <= 1e-10


SWINGING = (
    "elements.spring.law={spring: {stiffness: 200.0}}",  # no damper
    "initial.velocities=[{nodes: [weight], velocity: [1, 0.5, 0]}]",
)
UNCONSTRAINED = [("free_body", 1e-2, ("time.rho_inf=1.0",)), ("oscillator", 2e-3, ("time.rho_inf=1.0", *SWINGING))]


@pytest.mark.parametrize(("name", "h", "overrides"), UNCONSTRAINED)
def test_energy_of_unconstrained_models_does_not_drift(name, h, overrides, tmp_path):
    """With rho = 1: its oscillation falls as h^2, its mean stays within 1e-6 over 1e5 steps."""
    swings = []
    for step in (4 * h, 2 * h):
        energy = RecordedRun(input_deck(name, f"time.step={step}", f"time.end={2000 * h}", *overrides))["energy/total"]
        swings.append(np.ptp(energy))
    check_second_order(*np.array(swings), 0.0, swings[1] / 20)
    long = f"time.step={h}", f"time.end={1e5 * h}", f"output.every={10 * h}"
    run(input_deck(name, *long, *overrides), tmp_path / "long.h5")
    with open_results(tmp_path / "long.h5") as results:
        assert len(results.time) == 10_001
        energy = results["energy/total"].values
    tenth = len(energy) // 10
    assert abs(energy[-tenth:].mean() - energy[:tenth].mean()) < 1e-6 * abs(energy[0])


@pytest.mark.parametrize("name", ["pendulum", "double_pendulum", "four_bar"])
def test_dissipation_of_the_method_falls_as_the_step_squared(name):
    """Constrained, rho = 0.95: energy lost in the first second."""
    coarse, fine = pair(name, lambda m: m["energy/total"] - m["energy/total"][0], [1.0], 2e-3, "time.rho_inf=0.95")
    assert coarse[0] < 0
    check_second_order(coarse, fine, 0.0, abs(fine[0]) / 100)


def test_a_start_in_full_motion_fits_the_constraints_whatever_the_last_step_turned():
    found = RecordedRun(
        deck("""
            mecano: 1
            gravity: [0, 0, -9.81]
            nodes:
              a: {position: [0, 0, 0]}
              b: {position: [1, 0, 0]}
              c: {position: [1, 0, 0]}
            elements:
              upper:
                {type: rigid_body, node: a, mass: 1, center_of_mass: [0.5, 0, 0], inertia: [0.01, 0.1, 0.1],
                 attached: [b]}
              lower: {type: rigid_body, node: c, mass: 1, center_of_mass: [0.5, 0, 0], inertia: [0.01, 0.1, 0.1]}
            joints:
              shoulder: {type: hinge, nodes: [ground, a], axis: [0, 1, 0]}
              elbow: {type: hinge, nodes: [b, c], axis: [0, 1, 0.2]}
            time: {end: 0.6, step: 0.02}
        """)
    )
    s, _ = found.integrator.method.start(found.run.motion, 0.02)
    of = found.system.numbering
    turned = np.abs(found.run.motion.z[: of.n_q][of.kind[: of.n_q] == ROTATION]).max()
    assert turned > 0.01 and np.linalg.norm(s.v) > 1.0
    level, rate, second = np.abs(found.system.constraint_derivatives(s)).max(axis=0)
    assert level < 1e-10 and rate < 1e-13 and second < 1e-11


GYRO = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      arm: {{position: [0, 0, 0]}}
      tip: {{position: [0.5, 0, 0.1]}}
      disc: {{position: [0.5, 0, 0.1]}}
    elements:
      bar:
        type: rigid_body
        node: arm
        mass: 2.0
        center_of_mass: [0.25, 0, 0.05]
        inertia: [0.02, 0.05, 0.06]
        attached: [tip]
      rotor: {{type: rigid_body, node: disc, mass: 1.0, inertia: [0.01, 0.005, 0.007]}}
    joints:
      foot: {{type: universal, nodes: [ground, arm], axis_a: [0, 0, 1], axis_b: [0, 1, 0]}}
      bearing: {{type: hinge, nodes: [tip, disc], axis: [1, 0, 0.2]}}
    initial:
      velocities:
        - {{nodes: [arm], angular_velocity: [0, 0, 3.0], about: [0, 0, 0]}}
        - {{nodes: [disc], angular_velocity: [20.0, 0, 7.0], about: [0, 0, 0]}}
    time: {{end: 0.016, step: {step}}}
"""


@pytest.mark.parametrize("path", ["joints/foot/force", "joints/bearing/moment"])
def test_reactions_of_a_spinning_body_are_of_second_order_from_the_first_step_on(path):
    """Rotations in space do not commute: against steps of 20 us, the errors of the first steps fall fourfold.

    Those of the moment, a fifteenth of the error of the force, hardly exceed the errors of the reference.
    """
    exact, *marches = (RecordedRun(deck(GYRO.format(step=h))) for h in (2e-5, 2e-3, 1e-3))
    coarse, fine = (
        np.abs(recorded[path][:9] - at_times(exact, exact[path], recorded.time[:9])).max() for recorded in marches
    )
    if path == "joints/foot/force":
        assert coarse / fine == pytest.approx(4.0, abs=0.3)
    assert coarse < 2e-4 * np.abs(exact[path]).max()


def test_a_start_just_before_a_jump_of_curvature_is_one_behind_it():
    """The profile of the detent begins to curve, by r'', where the ball stands: it jumps to r'' v^2, 28.8 m/s2.

    Taken for a rate of change over 2 % of a step, the jump would shift the velocity by 0.036 m/s.
    """
    alone = [f"{name}=null" for name in ("nodes.flying", "nodes.loaded", "loads.load", "elements.detent.friction")]
    alone += [f"elements.{name}=null" for name in ("flying", "loaded", "hole_of_flying", "hole_of_loaded")]
    moving = "initial.velocities=[{nodes: [shaft], velocity: [0, 0, -0.5]}]"
    places = [f"nodes.ball.position=[12 mm, 0, {z}]" for z in (-1e-9, 1e-9)]  # the shaft moves towards -z
    before, behind = (RecordedRun(input_deck("snap_pin", *alone, moving, x, "time.end=1e-3")) for x in places)
    ball = "nodes/ball/velocity"
    np.testing.assert_allclose(before[ball], behind[ball], rtol=0, atol=0.05 * 28.8 * 2e-4)  # of a step


def test_predicted_multipliers_do_not_grow_in_steps_of_changing_size():
    """The parabola through the last three values: one through values that were extrapolated would grow to 1e15 N."""
    prepared = prepare(input_deck("spherical_pendulum"))
    integrator, n_q = integrator_of(prepared), prepared.system.n_q
    method, step = integrator.method, prepared.deck.values["time"]["step"]
    run = integrator.begin(prepared.state, step)
    s, history = run.motion, run.history
    for size in [1.0, 1e-2, 2e-2, 1.0, 0.3, 1e-3, 0.5] * 30:
        history = method.restart(s, history, size * step)
        reactions = s.z[n_q : prepared.system.n]
        assert np.abs(history.slope + history.bend)[n_q:].max() < np.abs(reactions).max()
        s, history, info = method.step(s, history, size * step)
        assert info.ok


def test_residuals_are_recorded_in_whole_tolerances(tmp_path):
    """Also those of steps that end by a correction whose residual is not evaluated: below 1."""
    path = tmp_path / "r.h5"
    run(input_deck("double_pendulum", "time.end=1"), path)
    with open_results(path) as results:
        steps = results.steps
    assert len(steps) == 1000 and (steps["iterations"] > 1).any()
    assert max(steps["force_residual"].max(), steps["constraint_residual"].max()) <= 1.0

"""Runs that cannot continue: messages in the words of the deck, and the data kept."""

import re
import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from time_runs import RecordedRun, deck, in_python, input_deck

import mecano
import mecano.analyses.prepare
from mecano.analyses import dynamic
from mecano.analyses.dynamic import begun
from mecano.analyses.operating_point import operating_point
from mecano.analyses.summary import summary
from mecano.deck.read import read_deck
from mecano.errors import ConvergenceError, NonFiniteError
from mecano.jit.memory import LANES
from mecano.model.numbering import LENGTH_CONSTRAINT, TRANSLATION, EquationName
from mecano.solve.diagnostics.failure import worst_equations

CATAPULT = """\
mecano: 1
gravity: [0, 0, 0]
nodes:
  wall: {position: [0, 0, 0], fixed: true}
  ball: {position: [1, 0, 0]}
elements:
  ball: {type: point_mass, node: ball, mass: 1.0}
  catapult:
    type: spring_damper
    nodes: [wall, ball]
    natural_length: 0
    law: {polynomial: {coefficients: [0, 0, 0, -2.0]}}
initial:
  velocities: [{nodes: [ball], velocity: [1, 0, 0]}]
time: {end: 2.0, step: 1.0e-2}
"""  # x'' = 2 x^3 from x = x' = 1: x = 1/(1 - t), infinite at t = 1
OVERFLOW = """\
mecano: 1
gravity: [0, 0, -9.81]
nodes:
  pin: {position: [0, 0, 0]}
elements:
  bar: {type: rigid_body, node: pin, mass: 1.0, center_of_mass: [0.5, 0, 0], inertia: [1.0e-4, 0.0833, 0.0833]}
loads:
  pull: {type: force, node: pin, direction: [1, 0, 0], value: {polynomial: {coefficients: [POWERS]}}}
time: {end: 10.0, step: 0.1}
""".replace("POWERS", "0, " * 300 + "1.0e+100")  # 1e100 t^300 is infinite from t = 4.93 s on
# a step is given up before it is cut to 1e-7 of its length, which a force that grows so takes very long to need
SHORT = "import mecano.analyses.prepare as p; p.SMALLEST_STEP = 0.5; from mecano.cli import main; main()"


def failed_run(tmp_path, text, *overrides, code="from mecano.cli import main; main()"):
    """(exit code, errors, results) of a run of a deck."""
    (tmp_path / "deck.yaml").write_text(text)
    options = [word for override in overrides for word in ("--set", override)]
    command = [sys.executable, "-W", "ignore", "-c", code, "run", "deck.yaml", *options]
    ended = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert ended.stdout == "" and "Traceback" not in ended.stderr
    results = mecano.open_results(tmp_path / "deck.h5")
    assert results.status == "failed"
    said = ended.stderr[ended.stderr.rindex("mecano: ") :].removeprefix("mecano: ").strip()
    assert said == results.reason  # the file says the same
    return ended.returncode, said, results


def check_kept(results):
    """Every step before the failure is in the file, up to the time reported."""
    time = results.time
    assert len(time) == len(results.steps) + 1 > 10
    assert np.array_equal(time[1:], results.steps["time"])
    assert f"t = {time[-1]:.9g} s" in results.reason
    assert np.all(np.isfinite(results["ball.position" if "ball" in results.reason else "pin.position"].values))


def test_no_convergence(tmp_path):
    code, said, results = failed_run(tmp_path, CATAPULT)
    assert code == 3 and said.startswith("no step could be taken at t = 0.99")
    assert "no convergence: corrections grow beyond the size of the mechanism" in said
    _, worst = said.split("worst equations:\n")
    first, *_ = worst.splitlines()
    assert first.startswith("  node ball: force x: residual ")
    assert first.endswith("; on it act point_mass 'ball', spring_damper 'catapult'")
    assert "what to try: a smaller time.step" in said and "mecano check" in said
    assert said.splitlines()[-2:] == [
        "point_mass 'ball' is at deck.yaml:7:3",
        "spring_damper 'catapult' is at deck.yaml:8:3",
    ]
    check_kept(results)
    near = np.searchsorted(results.time, 0.5)
    assert results["ball.position.x"].values[near] == pytest.approx(1 / (1 - results.time[near]), rel=1e-3)


def test_forces_that_are_not_finite(monkeypatch):
    def unrecorded(integrator, run):  # energies are not finite before
        integrator.recorder = None
        return run

    monkeypatch.setattr(mecano.analyses.prepare, "SMALLEST_STEP", 0.5)  # as in SHORT
    with pytest.raises(NonFiniteError, match="a residual is not finite") as error:
        RecordedRun(deck(OVERFLOW), change=unrecorded)
    head, worst = str(error.value).split("worst equations:\n")
    first, *_ = worst.splitlines()
    assert first.startswith("  node pin: force x: residual ")
    assert "rigid_body 'bar'" in first and "force 'pull'" in first
    assert "what to try: laws that stay finite near this state" in worst
    assert error.value.places == ("node pin",)
    assert 4.0 < float(head.split("t = ")[1].split(" s")[0]) < 5.0


def test_energies_that_are_not_finite(tmp_path):
    """The same run by the command ends before, where the square of a velocity is infinite."""
    code, said, results = failed_run(tmp_path, OVERFLOW, code=SHORT)
    assert code == 6 and "rigid_body 'bar': kinetic_energy is not finite" in said
    assert "what to try: laws that stay finite near this state" in said
    assert len(results.time) == len(results.steps) + 1 > 10 and 1.0 < results.time[-1] < 4.0
    assert all(np.isfinite(results[name].values).all() for name in results.names())


NOT_FINITE = """\
mecano: 1
gravity: [0, 0, -9.81]
sections:
  rod: {type: circle, diameter: 0.02, E: 2.0e11, nu: 0.3, density: 7800}
nodes:
  top: {position: [0, 0, 0], fixed: true}
  tip: {position: [1, 0, 0]}
elements:
  rod: {type: beam, nodes: [top, tip], section: rod, mesh: 4}
  ball: {type: rigid_body, node: tip, mass: 1.0, inertia: [0.1, 0.1, 0.1]}
time: {end: 0.1, step: 0.01}
"""


@pytest.mark.parametrize(
    ("kind", "field", "name"), [("rigid_body", "c", "rigid_body 'ball'"), ("beam", "E", "beam 'rod.3'")]
)
def test_the_element_that_is_not_finite_is_named(tmp_path, kind, field, name):
    """A number of one element becomes NaN during the run, as a law may give it: this element alone is at fault.

    The forces of the body make all others NaN within the same step; the modulus of the rod is that of its stresses.
    """
    with begun(deck(NOT_FINITE), tmp_path / "r.h5", False) as run:
        run.advance(0.05)
        batch = next(b for b in run.recorder.sampler.system.batches if b.kind.name == kind)
        e = batch.names.index(name)
        if batch.kind.by_lanes:
            batch.groups[field][divmod(e, LANES)] = np.nan
        else:
            batch.p[field][e] = np.nan
        with pytest.raises(NonFiniteError) as error:
            run.advance(0.1)
    first, second, *_ = str(error.value).splitlines()
    assert re.findall(r"\w+ '[^']+'", f"{first} {second}") == [name] and "t = 0.0" in first


@pytest.mark.parametrize("mesh", [4, 40])
def test_a_tangent_of_radau_that_is_not_finite_is_not_called_singular(tmp_path, mesh):
    """Small matrices are factored by LAPACK, larger ones, of more than 150 equations, by SuperLU."""
    text = NOT_FINITE.replace("mesh: 4", f"mesh: {mesh}").replace("step: 0.01", "step: 0.01, method: radau")
    with begun(deck(text), tmp_path / "r.h5", False) as run:
        run.advance(0.02)
        next(b for b in run.recorder.sampler.system.batches if b.kind.name == "rigid_body").p["c"] = np.nan
        with pytest.raises(NonFiniteError, match="rigid_body 'ball'"):
            run.advance(0.1)


def test_the_place_of_a_formula_that_is_not_finite_is_named(tmp_path):
    """A signal at the start, and a formula in place where it ends to be defined."""
    text = (
        "mecano: 1\ngravity: none\nnodes: {a: {position: [0, 0, 0]}}\n"
        "elements: {m: {type: point_mass, node: a, mass: 1}}\nsignals: {pole: log(0.05 - time)}\n"
        "loads:\n  f: {type: force, node: a, direction: [1, 0, 0], value: 2*sqrt(0.04 - time)}\n"
        "time: {start: %g, end: 0.1, step: 0.01}\n"
    )
    file = tmp_path / "poles.yaml"
    for start, place in ((0.07, "formula 'pole' is at {}:5:11"), (0.0, "formula '2*sqrt(0.04 - time)' is at {}:7:58")):
        file.write_text(text % start)
        with pytest.raises(NonFiniteError) as error, begun(read_deck(file), tmp_path / "r.h5", True) as run:
            run.advance(0.1)
        assert place.format(file) in str(error.value).splitlines()


@pytest.mark.parametrize(
    "process", ["static: {}", "initial: static\ntime: {end: 1, step: 0.1}", "time: {end: 1, step: 0.1}"]
)
def test_the_place_of_a_formula_that_is_not_finite_is_named_in_statics_and_modes(process, tmp_path):
    """1/angle at the angle zero; `mecano check` fails where the run begins there, and not at an equilibrium."""
    file = tmp_path / "pole.yaml"
    file.write_text(
        "mecano: 1\ngravity: none\nnodes: {a: {position: [0, 0, 0]}}\n"
        "elements: {m: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}}\n"
        "joints: {hinge: {type: hinge, nodes: [ground, a], axis: [0, 1, 0]}}\n"
        f"loads:\n  motor: {{type: joint_moment, joint: hinge, value: 1/hinge.angle}}\n{process}\n"
    )
    at_start = process.startswith("time")
    for use in (operating_point, summary)[: 1 + at_start]:
        with pytest.raises(NonFiniteError) as error:
            use(read_deck(file))
        assert f"formula '1/hinge.angle' is at {file}:7:52" in str(error.value).splitlines()
    assert at_start or "mobility         1" in summary(read_deck(file))


def test_failures_name_the_joints_that_act(tmp_path):
    """A hinge whose pendulum is hit so hard that it cannot be followed within one iteration."""
    text = (
        "mecano: 1\ngravity: [0, 0, -9.81]\nnodes:\n  pin: {position: [0, 0, 0]}\nelements:\n"
        "  bar: {type: rigid_body, node: pin, mass: 1.0, center_of_mass: [0.5, 0, 0], inertia: [1.0e-4, 0.1, 0.1]}\n"
        "joints:\n  pivot: {type: hinge, nodes: [ground, pin], axis: [0, 1, 0]}\n"
        "loads:\n  blow: {type: moment, node: pin, direction: [1, 1, 0],\n"
        "    value: {step: {time: 0.5, rise: 0.01, from: 0, to: 1e4}}}\n"
        "time: {end: 1, step: 0.02, adaptive: {tolerance: 0.9, minimum_step: 0.02}, newton: {maximum_iterations: 2}}\n"
    )
    code, said, results = failed_run(tmp_path, text)
    assert code == 3
    assert "node pin: moment about" in said and "; on it act rigid_body 'bar', hinge 'pivot', moment 'blow'" in said
    check_kept(results)


def test_the_worst_equations_are_of_different_places_and_no_rounding():
    """Of the two forces at 'tip' the larger; nothing below a thousandth of it, alone of its kind or not."""
    places = ("node tip", "force x"), ("node tip", "force z"), ("node root", "force x"), ("node far", "force x")
    names = [EquationName(*place) for place in (*places, ("rod 'r'", "length"))]
    system = SimpleNamespace(
        n=5, n_q=0, numbering=SimpleNamespace(kind=np.array([*[TRANSLATION] * 4, LENGTH_CONSTRAINT]), name=names),
        nodes=[SimpleNamespace(x=(0.0, 0.0, 0.0))],
    )  # fmt: skip
    assembly = SimpleNamespace(residual=np.array([2.0, 3.0, -1.0, 2.9e-3, 1e-13]), size=np.array([*[10.0] * 4, 1e-13]))
    assert worst_equations(system, assembly) == "  node tip: force z: residual 3 N\n  node root: force x: residual 1 N"
    assembly.residual[4] = 6.0
    assert worst_equations(system, assembly).startswith("  rod 'r': length: residual 6\n  node tip")
    assembly.residual[2] = np.inf
    assert worst_equations(system, assembly) == "  node root: force x: residual inf N"


SLIDER_WITHOUT_MASS = """
mecano: 1
gravity: none
laws: {rough: {dry_friction: {force: 5, regularization: 1.0e-3}}}
nodes: {slide: {position: [0, 0, 0]}, weight: {position: [1, 0, 0]}}
elements:
  load: {type: rigid_body, node: weight, mass: 1, inertia: [1, 1, 1]}
  spring: {type: spring_damper, nodes: [slide, weight], law: {spring: {stiffness: 1000}}}
joints:
  rough: {type: prismatic, nodes: [ground, slide], axis: [1, 0, 0], sliding_law: rough}
  smooth: {type: prismatic, nodes: [ground, weight], axis: [1, 0, 0]}
initial: {velocities: [{nodes: [weight], velocity: [1, 0, 0]}]}
time: {end: 2, step: 1.0e-3, method: radau, adaptive: {tolerance: 1.0e-5}}
"""


def test_the_end_without_mass_of_a_spring_is_named(tmp_path):
    """Friction at its limit leaves its rate undetermined; the worst equation is that of the mass at the other end."""
    code, said, _ = failed_run(tmp_path, SLIDER_WITHOUT_MASS)
    assert code == 3 and "worst equations:\n  node weight: force x" in said
    _, _, advice = said.partition("what to try")
    assert "node slide: nothing gives mass to its displacement" in advice
    mass = "elements:\n  small: {type: point_mass, node: slide, mass: 1.0e-3}"
    run = RecordedRun(deck(SLIDER_WITHOUT_MASS.replace("elements:", mass)))
    assert run.time[-1] == 2.0 and run["joints/rough/velocity"].max() > 0.1


def test_a_step_of_the_least_size_that_is_too_rough_stops_the_run(tmp_path):
    adaptive = "time.adaptive={tolerance: 1.0e-3, minimum_step: 1.0e-3}"
    fast = "signals={fast: 1e6*ball.velocity.x}"  # the estimate leaves out signals
    code, said, results = failed_run(tmp_path, CATAPULT, adaptive, fast)
    assert code == 3 and "a step of 0.001 s, the smallest allowed, has " in said
    times = float(said.split("allowed, has ")[1].split(" times")[0])
    assert 1.0 < times < 3.0  # the first that is too rough
    assert "node ball: displacement x; on it act point_mass 'ball', spring_damper 'catapult'" in said
    assert "what to try: a smaller time.adaptive.minimum_step; a larger time.adaptive.tolerance" in said
    assert "a fixed step, if the mechanism passes a singular position" in said
    check_kept(results)
    assert results.steps["step_size"].min() >= 1e-3 * (1 - 1e-9)
    allowed = 1e-3 * results.steps["step_size"] / 2.0
    np.testing.assert_allclose(
        results.steps["error_over_tolerance"], results.steps["error_estimate"] / allowed, rtol=1e-12
    )
    assert 0.5 < results.steps["error_over_tolerance"].max() <= 1.0


WHEEL = ("time={end: 0.2, step: 1.0e-3}",)
FALL = 0.14278431229270644  # [s] from 0.4 m to the radius of 0.3 m: sqrt(2 x 0.1/9.81)


def failing(step, when):
    """The step of a method that fails in Newton where ``when(state, h)``."""

    def wrapped(s, history, h):
        new, made, info = step(s, history, h)
        if when(s, h):
            info = replace(info, ok=False, message="no convergence in 15 iterations")
        return new, made, info

    return wrapped


def with_failing(when):
    """Return a change of a run that makes steps fail if ``when(state, h)``."""

    def change(integrator, run):
        in_python(integrator)
        integrator.method.step = failing(integrator.method.step, when)
        return run

    return change


def test_a_search_of_an_event_that_fails_once_tries_a_smaller_step():
    """The step in which the event lies is given up, as one that fails itself: the event is found all the same."""
    failures = []

    def when(s, h):
        inside = h < 0.999e-3 and s.t > 0.14 and not failures
        failures.extend([h] * inside)
        return inside

    recorded = RecordedRun(input_deck("wheel_drop", *WHEEL), change=with_failing(when))
    assert len(failures) == 1
    assert recorded.event_records[0].name == "touch_down" and recorded.event_records[0].t == pytest.approx(
        FALL, abs=1e-9
    )
    assert recorded.run.rejected == 1


def test_a_search_of_an_event_that_always_fails_stops_the_run():
    with pytest.raises(ConvergenceError, match="no step could be taken at t = 0.142"):
        RecordedRun(input_deck("wheel_drop", *WHEEL), change=with_failing(lambda s, h: h < 0.999e-3 and s.t > 0.14))


STRUTS = """
    mecano: 1
    gravity: [0, 0, 0]
    nodes:
      wall: {position: [0, 0, 0], fixed: true}
      ball: {position: [1, 0, 0]}
    elements:
      ball: {type: point_mass, node: ball, mass: 1.0}
      strut: {type: spring_damper, nodes: [wall, ball], law: {stop: {stiffness: 1.0e4, lower: -0.1, upper: 0.2}}}
    initial:
      velocities: [{nodes: [ball], velocity: [-2, 0, 0]}]
    time: {end: 0.5, step: 1.0e-3}
"""


def contradicting(occur):
    """Return the change of a run in which events occur in every phase while ``occur(t, captured)`` is true."""

    def contradict(integrator, run):
        plain, monitor = integrator.system.event_values, integrator.monitor

        def event_values(s):
            return np.ones_like(plain(s)) if occur(s.t, monitor.captures) else plain(s)

        integrator.system.event_values = event_values
        return in_python(integrator, run)

    return contradict


def test_elastic_events_that_follow_one_another_while_time_stands_still_are_captured():
    """The run goes on in the phases that fit the ends of steps, and its motion is the same."""
    recorded = RecordedRun(deck(STRUTS), change=contradicting(lambda t, captured: 0.0195 <= t < 0.021 and not captured))
    capture = recorded.integrator.capture
    assert capture.first == pytest.approx(0.0195) and not capture.monitor.captures
    plain = RecordedRun(deck(STRUTS))
    assert recorded["nodes/ball/position"][-1] == pytest.approx(plain["nodes/ball/position"][-1], rel=1e-3)


def test_lines_that_leave_a_knot_without_mass_loose_are_explained(tmp_path):
    """Thrown up, the load leaves both lines slack; when it falls again nothing places the knot between them."""
    text = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {ceiling: {position: [0, 0, 1], fixed: true}, knot: {position: [0, 0, 0.5]}, load: {position: [0, 0, 0]}}
    elements:
      load: {type: point_mass, node: load, mass: 1}
      upper: {type: cable, nodes: [ceiling, knot], axial_stiffness: 1.0e4}
      lower: {type: cable, nodes: [knot, load], axial_stiffness: 1.0e4}
    initial: {velocities: [{nodes: [load], velocity: [0, 0, 2]}]}
    time: {end: 2, step: 1 ms}
    """
    with pytest.raises(ConvergenceError, match="time does not advance|no step could be taken") as error:
        dynamic.run(deck(text), tmp_path / "r.h5")
    said = str(error.value)
    assert "node knot: nothing gives mass to its displacement, and only lines that may go slack hold it" in said


def test_events_that_follow_one_another_while_time_stands_still_stop_the_run():
    """An event that occurs in every phase: the run ends, and the element is named."""
    with pytest.raises(ConvergenceError) as error:
        RecordedRun(deck(STRUTS), change=contradicting(lambda t, captured: t >= 0.02))
    said = str(error.value)
    assert said.startswith("time does not advance beyond t = 0.02") and "'strut' had the event 'lower stop" in said
    assert "(between -> below) 41 times" in said or "(below -> between) 41 times" in said  # captured after 21
    assert "laws of this element without jumps" in said


SHORT_ROCKER = """
    mecano: 1
    gravity: none
    nodes:
      crank: {position: [0, 0, 0]}
      a: {position: [0.3, 0, 0]}
      coupler: {position: [0.3, 0, 0]}
      b: {position: [0.3, 0.4, 0]}
      rocker: {position: [0.65, 0, 0]}
      c: {position: [0.3, 0.4, 0]}
    elements:
      crank: {type: rigid_body, node: crank, mass: 1, inertia: [0.01, 0.01, 0.01], attached: [a]}
      coupler: {type: rigid_body, node: coupler, mass: 1, inertia: [0.01, 0.01, 0.01], attached: [b]}
      rocker: {type: rigid_body, node: rocker, mass: 1, inertia: [0.01, 0.01, 0.01], attached: [c]}
    joints:
      foot: {type: hinge, nodes: [ground, crank], axis: [0, 0, 1]}
      knee: {type: hinge, nodes: [a, coupler], axis: [0, 0, 1]}
      pin: {type: hinge, nodes: [b, c], axis: [0, 0, 1]}
      hip: {type: hinge, nodes: [ground, rocker], axis: [0, 0, 1]}
      motor: {type: prescribed_angle, nodes: [ground, crank], axis: [0, 0, 1], value: 2*time}
    time: {end: 3, step: 5 ms, METHOD}
"""


PULLED_SLIDER = """
    mecano: 1
    gravity: none
    nodes:
      crank: {position: [0, 0, 0]}
      knee: {position: [0.18, 0.24, 0]}
      rod: {position: [0.18, 0.24, 0]}
      wrist: {position: [0.84, 0, 0]}
      slider: {position: [0.84, 0, 0]}
    elements:
      crank: {type: rigid_body, node: crank, mass: 1, center_of_mass: [0.09, 0.12, 0], BAR, attached: [knee]}
      rod: {type: rigid_body, node: rod, mass: 1, center_of_mass: [0.33, -0.12, 0], BAR, attached: [wrist]}
      slider: {type: rigid_body, node: slider, mass: 1, BAR}
    joints:
      main: {type: hinge, nodes: [ground, crank], axis: [0, 0, 1]}
      pin: {type: spherical, nodes: [knee, rod]}
      end: {type: hinge, nodes: [wrist, slider], axis: [0, 0, 1]}
      rail: {type: prismatic, nodes: [ground, slider], axis: [1, 0, 0]}
      pull: {type: prescribed_position, node: slider, direction: [1, 0, 0], value: 0.3*time}
    time: {end: 2, step: 1 ms, METHOD}
""".replace("BAR", "inertia: [0.01, 0.04, 0.04]")


@pytest.mark.parametrize("method", ["rho_inf: 0.8", "method: radau", "method: radau, adaptive: {tolerance: 1.0e-5}"])
def test_a_slider_pulled_beyond_its_reach_is_named(method):
    """Crank and rod, 0.3 m and sqrt(0.66^2 + 0.24^2) m, are in one line when it has moved from 0.84 m to their sum."""
    t = (0.3 + np.hypot(0.66, 0.24) - 0.84) / 0.3
    with pytest.raises(ConvergenceError, match="(?s)singular position.*prescribed_position 'pull'.*reach") as info:
        RecordedRun(deck(PULLED_SLIDER.replace("METHOD", method)))
    assert float(re.search("at t = ([0-9.]+) s", str(info.value))[1]) == pytest.approx(t, abs=1e-6)


@pytest.mark.parametrize("method", ["rho_inf: 0.8", "adaptive: {tolerance: 1.0e-4}", "method: radau"])
def test_a_motor_beyond_the_reach_of_its_linkage_is_named(method):
    """The crank comes no further than to 2.716 rad, where coupler and rocker of 0.9315 m in all are in one line."""
    with pytest.raises(ConvergenceError, match="(?s)t = 1.35.* singular position.*prescribed_angle 'motor'.*reach"):
        RecordedRun(deck(SHORT_ROCKER.replace("METHOD", method)))

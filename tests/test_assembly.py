"""Initial positions: brought onto the constraints, or refused by name; motions between steps."""

import re

import numpy as np
import pytest
from time_runs import RecordedRun, deck, in_python, input_deck

import mecano
from mecano.analyses.prepare import prepare, startup_warnings
from mecano.errors import AssemblyError
from mecano.model.system import System
from mecano.solve.time.interpolate import interpolate

ROD = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      a: {position: [0, 0, 0], fixed: true}
      m: {position: [1.02, 0, 0.01]}
      b: {position: [%s, 0, 0], fixed: true}
    elements: {mass: {type: point_mass, node: m, mass: 1}}
    joints:
      left: {type: rigid_rod, nodes: [a, m], length: 1.0}
      right: {type: rigid_rod, nodes: [m, b], length: 1.0}
    time: {end: 0.1, step: 0.001}
"""


def test_positions_are_brought_to_the_nearest_that_fit():
    prepared = prepare(deck(ROD % 1.6))
    system, state = prepared.system, prepared.state
    x = state.z[system.numbering.x[1] :][:3]
    assert np.linalg.norm(x) == pytest.approx(1.0, abs=1e-11)
    assert np.linalg.norm(x - [1.6, 0, 0]) == pytest.approx(1.0, abs=1e-11)
    assert x[0] == pytest.approx(0.8, abs=1e-11) and x[2] > 0  # of the two solutions the one on the deck's side
    assert prepared.displacement == pytest.approx(np.abs(x - [1.02, 0, 0.01]).max(), abs=1e-9)
    off = 1.0 - np.hypot(0.58, 0.01)  # of the right rod, of 1 m between [1.02, 0, 0.01] and [1.6, 0, 0]
    text = f"as given, rigid_rod 'right' is most off, by {1e3 * off:.3g} mm (force that pushes the nodes apart)"
    assert any(text in warning for warning in startup_warnings(prepared))


def test_what_cannot_be_met_is_refused_by_name():
    with pytest.raises(AssemblyError, match="cannot be assembled") as refusal:
        prepare(deck(ROD % 2.5))  # two rods of 1 m between supports 2.5 m apart
    assert "rigid_rod 'left'" in str(refusal.value) and "rigid_rod 'right'" in str(refusal.value)
    assert "rigid_rod 'right' is most off, by 480 mm" in str(refusal.value)  # 2.5 m - 1.02 m - 1 m
    assert re.search("50 iterations from there moved nodes by up to .* mm, and at best leave", str(refusal.value))
    assert refusal.value.exit_code == 4


def test_axes_at_a_right_angle_are_off_by_it():
    """Not by the sine of it; with the place of the joint in the deck. The assembly is at a maximum of the error."""
    text = """
        mecano: 1
        gravity: none
        nodes: {a: {position: [0, 0, 0]}}
        elements: {m: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}}
        joints: {pin: {type: hinge, nodes: [ground, a], axis: [0, 0, 1], axis_b: [0, 1, 0]}}
        time: {end: 1.0, step: 0.01}
    """
    with pytest.raises(AssemblyError) as refusal:
        prepare(deck(text))
    said = str(refusal.value)
    assert "as given, hinge 'pin' is most off, by 90 deg" in said and said.endswith("hinge 'pin' is at test.yaml:6:10")


MOTORS = """mecano: 1
gravity: none
nodes: {a: {position: [0, 0, 0]}}
elements: {m: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}}
joints:
  pin: {type: hinge, nodes: [ground, a], axis: [0, 0, 1]}
  slow: {type: prescribed_angle, nodes: [ground, a], axis: [0, 0, 1], value: 1*time}
  fast: {type: prescribed_angle, nodes: [ground, a], axis: [0, 0, 1], value: 2*time}
time: {end: 1.0, step: 0.01}
"""


@pytest.mark.parametrize("use", [mecano.check, lambda path: mecano.run(path, path.with_suffix(".h5"), quiet=True)])
def test_motions_that_contradict_one_another_have_places(use, tmp_path):
    path = tmp_path / "motors.yaml"
    path.write_text(MOTORS)
    with pytest.raises(AssemblyError, match="contradict") as refusal:
        use(path)
    for i, name in enumerate(("slow", "fast")):
        assert f"prescribed_angle '{name}' is at {path}:{7 + i}:3" in str(refusal.value)


def test_a_hinge_closed_the_wrong_way_round_is_refused():
    flipped = """
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {a: {position: [0, 0, 0]}}
        elements: {m: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}}
        joints: {pin: {type: hinge, nodes: [ground, a], axis: [0, 0, 1], axis_b: [0, 0, -1]}}
        time: {end: 1.0, step: 0.01}
    """
    with pytest.raises(AssemblyError, match="hinge 'pin'.*flipped"):
        prepare(deck(flipped))


def test_mechanisms_and_redundant_constraints_are_named():
    analysis = prepare(input_deck("four_bar")).analysis
    assert analysis.mobility == 1 and len(analysis.mechanisms) == 1 and analysis.mechanisms[0].count == 1
    assert sum(group.count for group in analysis.redundant) == 3
    named = " ".join(name for group in analysis.redundant for name in group.names)
    assert all(f"hinge 'hinge_{letter}'" in named for letter in "abcd")
    assert any("not unique" in text for text in startup_warnings(prepare(input_deck("four_bar"))))


def values_of(observation, assembly):
    """All arrays of the two values."""
    return (
        observation.outputs, observation.energies, observation.energy,
        assembly.residual, assembly.size, assembly.data, assembly.forces,
    )  # fmt: skip


def test_outputs_do_not_depend_on_earlier_assemblies():
    """The reaction of the pendulum's hinge follows from the state, also after an assembly at another one."""
    prepared = prepare(input_deck("pendulum"))
    system, state = prepared.system, prepared.state
    before, assembly = system.observe(state), system.assemble(state, cK=1.0, cC=1.0, cM=1.0)
    kept = [array.tobytes() for array in values_of(before, assembly)]
    moving = state.copy()
    moving.v = moving.v + 1.0
    foreign = system.assemble(moving, 2.0, 3.0, cK=1.0, cC=1.0, cM=1.0)
    system.observe(moving)
    for again in (before, system.observe(state), system.observe(state, assembly.forces)):
        assert [array.tobytes() for array in values_of(again, assembly)] == kept
    assert (system.observe(state, foreign.forces).outputs != before.outputs).any()


def test_a_run_does_not_depend_on_assemblies_between_its_calls(monkeypatch):
    """Between a step and its outputs, which ``commit`` separates, everything is evaluated at another state."""
    commit = System.commit

    def at_another_state(system, s):
        other = s.copy()
        other.v, other.a = other.v + 1.0, other.a - 1.0
        system.assemble(other, 2.0, 3.0, cK=1.0, cC=1.0, cM=1.0)
        system.observe(other)
        system.event_values(other)
        return commit(system, s)

    pendulum = input_deck("pendulum", "time.end=0.03")
    alone = RecordedRun(pendulum, change=in_python)
    monkeypatch.setattr(System, "commit", at_another_state)
    disturbed = RecordedRun(pendulum, change=in_python)
    assert disturbed.rows.tobytes() == alone.rows.tobytes() and len(alone.rows) == 31


@pytest.mark.parametrize("what, order", [("position", 4), ("velocity", 3)])
def test_motion_between_steps_is_as_good_as_the_steps(what, order):
    """Errors of a step's interpolation against a run that ends there: h^4 and h^3, beyond the method's h^2."""
    errors = []
    for h in (0.02, 0.01):
        kept = []

        def keep(integrator, run, kept=kept):
            integrator.observers = (*integrator.observers, kept.append)
            return run

        # nearly exact states at the ends of long steps and a quarter into them, from a run with fine steps
        m = RecordedRun(input_deck("double_pendulum", "time.end=0.4", f"time.step={h / 40}"), change=keep)
        of, x = m.system.numbering, m.system.numbering.x[m.system.numbering.x < m.system.numbering.n_q]
        worst = 0.0
        for i in range(19, len(kept) - 40, 40):
            left, middle, right = (kept[i + n].run.motion for n in (0, 10, 40))
            between = interpolate(left, right, middle.t, of)
            array, exact = (between.z, middle.z) if what == "position" else (between.v, middle.v)
            worst = max(worst, max(np.abs(array[i : i + 3] - exact[i : i + 3]).max() for i in x))
        errors.append(worst)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.4)

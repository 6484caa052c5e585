"""Cost of a step in Python, in calls, which do not depend on the machine; docs/benchmarks.md has times."""

import pytest
from calls import calls
from time_runs import INPUTS, deck, input_deck

from mecano import Deck, Simulation
from mecano.analyses import recorder
from mecano.analyses.dynamic import begun
from mecano.analyses.equilibria import follow
from mecano.analyses.prepare import integrator_of, prepare

MOST_WRITES = 1300  # calls by which 16 MB of outputs go to the disk
MOST = 0.2  # calls of Python's functions and of built-in ones for each step
MOST_ADAPTIVE = 0.5  # where the step size changes, steps are rejected, and oscillations are looked for
MOST_SAVED = 0.5  # with what goes into the results file, whose blocks have checksums


@pytest.mark.parametrize(("name", "steps"), [("pendulum", 1000), ("axle_on_slope", 2000)])
def test_steps_make_hardly_any_calls(name, steps):
    """Steps of one hinged bar, and of two wheels on one axle, with what ends them at their time."""
    prepared = prepare(input_deck(name))
    integrator = integrator_of(prepared)
    run = integrator.to(0.1, integrator.begin(prepared.state, 1e-3))
    assert calls(lambda: integrator.to(0.1 + 1e-3 * steps, run)) <= MOST * steps


DOOR = """
    mecano: 1
    gravity: [5, 0, -9.81]
    nodes: {low: {position: [0, 0, 0]}, high: {position: [0, 0, 2]}}
    elements:
      leaf:
        {type: rigid_body, node: low, mass: 30, center_of_mass: [0, 0.4, 1], inertia: [12, 10, 2], attached: [high]}
    joints:
      hinge_$i: {repeat: {i: [low, high]}, type: hinge, nodes: [ground, $i], axis: [0, 0, 1]}
    time: {end: 2.1, step: 1 ms}
"""


def test_redundant_joints_under_load_are_checked_in_compiled_code():
    """Two hinges divide the weight of a door, and yield to it by 1e-11 of its size: no contradiction."""
    prepared = prepare(deck(DOOR))
    integrator = integrator_of(prepared)
    run = integrator.to(0.1, integrator.begin(prepared.state, 1e-3))
    assert prepared.compliance is not None and calls(lambda: integrator.to(2.1, run)) <= MOST * 2000


LATE = "late: {type: delay, input: torque, time: 0.35 ms}"


@pytest.mark.parametrize(("moment", "more", "steps"), [("torque", "", 5000), ("late", LATE, 10_000)])
def test_a_digital_controller_is_sampled_in_compiled_code(moment, more, steps):
    """A motor holds an arm; its moment jumps at the end of each step, or 0.35 ms later."""
    prepared = prepare(
        deck(f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {{arm: {{position: [0, 0, 0]}}}}
        elements: {{arm: {{type: rigid_body, node: arm, mass: 2, inertia: [0.4, 0.4, 0.4]}}}}
        joints: {{shoulder: {{type: hinge, nodes: [ground, arm], axis: [0, 1, 0]}}}}
        signals:
          torque: {{type: sample_and_hold, input: 60*(0.5 - shoulder.angle) - 8*shoulder.rate, period: 1 ms}}
          {more}
        loads: {{motor: {{type: joint_moment, joint: shoulder, value: {moment}}}}}
        time: {{end: 5.1 s, step: 1 ms}}
        """)
    )
    integrator = integrator_of(prepared)
    run = integrator.to(0.1, integrator.begin(prepared.state, 1e-3))
    assert calls(lambda: integrator.to(5.1, run)) <= MOST * steps


def test_step_sizes_change_in_compiled_code():
    """An adaptive run with redundant constraints, rejected steps, and errors with oscillations bounded."""
    prepared = prepare(input_deck("four_bar", "time.adaptive={tolerance: 1.0e-4}"))
    integrator = integrator_of(prepared)
    before, after = integrator.to(0.1, integrator.begin(prepared.state, 1e-3)), []
    made = calls(lambda: after.append(integrator.to(1.5, before)))
    assert after[0].rejected > 0 and made <= MOST_ADAPTIVE * (after[0].steps - before.steps)


def test_radau_steps_in_compiled_code():
    """An adaptive run by Radau IIA; a hundred steps are few, so its end counts."""
    prepared = prepare(input_deck("heavy_top", "time.method=radau", "time.adaptive={tolerance: 1.0e-8}"))
    integrator = integrator_of(prepared)
    before, after = integrator.to(0.01, integrator.begin(prepared.state, 1e-3)), []
    made = calls(lambda: after.append(integrator.to(0.4, before)))
    steps = after[0].steps - before.steps
    assert steps > 500 and made <= MOST_ADAPTIVE * steps


def test_equilibria_are_found_in_compiled_code():
    """Kernels also run as plain Python, a hundred times slower: none of their operators may be called."""
    prepared = prepare(input_deck("princeton_beam"))
    assert calls(lambda: follow(prepared), of="jit/methods.py") == 0


def test_saved_steps_make_few_calls(tmp_path):
    with begun(input_deck("pendulum", "time.end=30"), tmp_path / "r.h5", False) as ongoing:
        ongoing.advance(1.0)
        before = ongoing.state.steps
        made = calls(lambda: ongoing.advance(29.0))
        assert ongoing.state.steps - before == 28000 and made <= MOST_SAVED * 28000


def test_rows_of_many_numbers_take_few_writes(tmp_path, monkeypatch):
    """Those of 2 MB together."""
    monkeypatch.setattr(recorder, "INTERVAL", 1e9)  # s
    with begun(input_deck("reflector"), tmp_path / "r.h5", False) as ongoing:
        assert calls(lambda: ongoing.advance(3.5), of="results/disk.py") <= MOST_WRITES


def test_a_controller_in_python_makes_few_calls_for_a_new_value(tmp_path):
    """It restarts in compiled code; rows go to the file at intervals."""
    model = Deck.read(INPUTS / "pendulum.yaml")
    model["signals"] = {"torque": {"type": "external", "unit": "N m"}}
    model["loads"] = {"motor": {"type": "joint_moment", "joint": "hinge", "value": "torque"}}
    with Simulation(model, tmp_path / "r.h5") as simulation:

        def control(steps):
            for _ in range(steps):
                simulation["torque"] = -8 * simulation["hinge.rate"]
                simulation.advance(0.001)

        control(20)
        assert calls(lambda: control(100)) <= 510 * 100

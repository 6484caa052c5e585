"""Powers of elements as signals, and their integrals: the energy that each gives or dissipates."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck

from mecano.analyses.prepare import prepare
from mecano.errors import DeckError
from mecano.model.signal_units import signal_units

H = 0.01
BAR = f"""
    mecano: 1
    gravity: none
    nodes: {{a: {{position: [-1, 0, 0]}}, b: {{position: [0, 0, 0]}}, c: {{position: [1, 0, 0]}}}}
    elements:
      body: {{type: rigid_body, node: b, mass: 4, inertia: [1, 1, 1]}}
      left: {{type: rigid_link, nodes: [b, a]}}
      right: {{type: rigid_link, nodes: [b, c]}}
    time: {{end: 1, step: {H}}}
    """


def test_the_work_of_a_load_along_a_line():
    """Of 20 N/m on 2 m, F = 40 N on 4 kg: F^2 t/m, and its integral; a moment about the third axis does no work."""
    run = RecordedRun(
        deck(f"""{BAR}signals:
      power: line.given_power
      work: {{type: integrator, input: power}}
      none: turn.given_power
    loads:
      line: {{type: line_load, line: [a, b, c], direction: [0, 0, 1], value: 20}}
      turn: {{type: line_moment, line: [a, b, c], direction: [0, 1, 0], value: 1.0e-3*sin(time)}}
    joints: {{rail: {{type: prismatic, nodes: [ground, b], axis: [0, 0, 1]}}}}
    """)
    )
    np.testing.assert_allclose(run["signals/power/value"], 400.0 * run.time, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(run["signals/work/value"], 200.0 * run.time**2, atol=100.0 * H**2)
    np.testing.assert_allclose(run["signals/none/value"], 0.0, atol=1e-12)


MASS = f"""
    mecano: 1
    gravity: none
    nodes: {{a: {{position: [0, 0, 0]}}}}
    elements: {{body: {{type: point_mass, node: a, mass: 2}}}}
    time: {{end: 1, step: {H}}}
    """


def test_the_energy_that_the_law_of_a_joint_dissipates():
    """A mass of 2 kg at 3 m/s with a damper of 5 N s/m on a rail: m v^2/2 falls as exp(-2 c t/m)."""
    found = deck(f"""{MASS}joints:
      rail: {{type: prismatic, nodes: [ground, a], axis: [1, 0, 0], sliding_law: {{damper: 5}}}}
    initial: {{velocities: [{{nodes: [a], velocity: [3, 0, 0]}}]}}
    signals:
      power: rail.dissipated_power
      lost: {{type: integrator, input: rail.dissipated_power}}
    """)
    run = RecordedRun(found)
    np.testing.assert_allclose(run["signals/power/value"], 45.0 * np.exp(-5.0 * run.time), rtol=4.0 * H**2 * 25.0)
    np.testing.assert_allclose(run["signals/lost/value"], 9.0 * (1.0 - np.exp(-5.0 * run.time)), atol=25.0 * H**2)
    np.testing.assert_allclose(run["signals/lost/value"], run["energy/dissipated"], atol=9.0 * 25.0 * H**2)
    units = signal_units(prepare(found).system.model)
    assert units["signals/power/value"] == "W" and units["signals/lost/value"] == "J"


def test_the_power_of_a_prescribed_motion():
    """Of x = sin(3 t)/2 with 2 kg: m a v = -(27/2) sin(6 t)/2."""
    run = RecordedRun(
        deck(f"""{MASS}joints:
      drive: {{type: prescribed_position, node: a, direction: [1, 0, 0], value: 0.5*sin(3*time)}}
    signals: {{power: drive.given_power}}
    """)
    )
    np.testing.assert_allclose(run["signals/power/value"], -6.75 * np.sin(6.0 * run.time), atol=6.75 * 36.0 * H**2)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("beam.dissipated_power", "'energy.dissipated'"),
        ("push.given_powr", "did you mean 'given_power'?"),
        ("push.work", "it is the integral, by a signal of the type 'integrator', of its 'given_power'"),
    ],
)
def test_powers_that_cannot_be_read(name, said):
    with pytest.raises(DeckError) as error:
        deck(f"""
    mecano: 1
    gravity: none
    nodes: {{a: {{position: [0, 0, 0]}}, b: {{position: [1, 0, 0]}}}}
    sections: {{rod: {{type: circle, diameter: 0.01, E: 2.0e+11, nu: 0.3, density: 7800}}}}
    elements: {{beam: {{type: beam, nodes: [a, b], section: rod}}}}
    loads: {{push: {{type: force, node: a, direction: [1, 0, 0], value: 2}}}}
    signals: {{power: {name}}}
    time: {{end: 1, step: 0.1}}
    """)
    assert said in " ".join(str(problem) for problem in error.value.problems)

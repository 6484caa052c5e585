"""Events that accumulate are captured at the ends of steps: masses that rattle between cables in a carriage."""

from collections import Counter

import numpy as np
import pytest
from surviving import check_same, contents
from time_runs import RecordedRun, deck

from mecano.analyses.dynamic import begun, resume
from mecano.results.reader import open_results

MASSES, STIFFNESS, AMPLITUDE = 4, 100.0, 0.01  # of 1 g, in a carriage of 1 kg; [N/m], [m]
OMEGA = np.sqrt(STIFFNESS / (1.0 + 0.001 * MASSES))
TIMES = np.arange(0.1, 0.65, 0.1)  # in the first period


def rattling(time, end=0.63, damping=0.0, located=10):
    """A carriage on a spring; each mass lies slack between two cables, 1 to 2 um longer than its distances."""
    masses = "".join(
        f"""
          m{i}: {{type: point_mass, node: m{i}, mass: 1 g}}
          left{i}: {{type: cable, nodes: [c, m{i}], axial_stiffness: 1.0e5, damping: {damping},
                 natural_length: {0.100001 + 3e-7 * i}}}
          right{i}: {{type: cable, nodes: [m{i}, r], axial_stiffness: 1.0e5, damping: {damping},
                  natural_length: {0.100001 + 2e-7 * i}}}"""
        for i in range(MASSES)
    )
    return deck(f"""
        mecano: 1
        gravity: none
        nodes:
          c: {{position: [0, 0, 0]}}
          r: {{position: [0.2, 0, 0]}}
          {"".join(f"m{i}: {{position: [0.1, 0, 0]}}{chr(10)}          " for i in range(MASSES))}
        elements:
          c: {{type: point_mass, node: c, mass: 1}}
          link: {{type: rigid_link, nodes: [c, r]}}{masses}
        joints:
          guide: {{type: prismatic, nodes: [ground, c], axis: [1, 0, 0], natural_displacement: {-AMPLITUDE},
                   sliding_law: {{spring: {{stiffness: {STIFFNESS}}}}}}}
        time: {{end: {end}, {time}, located_events: {located}}}
    """)


def errors(recorded):
    """Displacement of the carriage minus that of one body with the masses, at the accepted steps [m]."""
    return recorded["joints/guide/displacement"] - AMPLITUDE * (np.cos(OMEGA * recorded.time) - 1.0)


def test_the_carriage_moves_as_one_body_with_what_rattles(verify):
    """Of second order in steps of many events; the energy balance closes to that error."""
    found = []
    for step in (5e-3, 2.5e-3):
        recorded = RecordedRun(rattling(f"step: {step}"))
        capture = recorded.integrator.capture
        assert capture.by_element.total() > 300 and capture.steps > 0.25 * len(recorded.time)
        assert np.ptp(recorded["energy/balance"]) < 2e-4 * 0.5 * STIFFNESS * AMPLITUDE**2
        found.append(np.interp(TIMES, recorded.time, errors(recorded)))
    verify.second_order(
        "Shocks", "carriage with masses that rattle in it: error of its position [m]", *found, 0.0, 2e-7,
        "closed form of one body on a spring; the masses move by some micrometres in it",
    )  # fmt: skip


def test_steps_of_adaptive_size_are_as_accurate_as_their_tolerance():
    recorded = RecordedRun(rattling("step: 5 ms, adaptive: {tolerance: 1.0e-3}", end=0.2))
    assert recorded.integrator.capture.steps > 10
    assert np.abs(errors(recorded)).max() < 1e-3 * 0.2  # of the length scale, the distance of the nodes


@pytest.mark.parametrize("damping", [3.0e-7, 1.0e-5, 2.0e-4])  # zeta = 0.005 to 3
def test_strongly_damped_lines_change_phase_once_at_an_instant(damping):
    """Where no phases fit the ends of steps, events are located: no line takes its phases in turn at one instant.

    Steps far longer than m/c, which is 5 us of the strongest, overshoot: a line goes slack where its force would grow.
    """
    recorded = RecordedRun(rattling("step: 2.5 ms", end=0.33, damping=damping))
    at_once = Counter((event.t, event.element, event.name) for event in recorded.event_records)
    assert max(at_once.values()) == 1
    energy = recorded["energy/total"]
    assert energy.max() < 1.001 * energy[0]
    assert np.abs(errors(recorded)).max() < AMPLITUDE * (OMEGA * 2.5e-3) ** 2


def test_steps_of_a_thousand_time_constants_pass_events_of_damped_lines():
    """The tension of a damped line does not depend on its phase, so that the step ends at its events all the same."""
    recorded = RecordedRun(rattling("step: 20 ms", end=0.1, damping=2.0e-3, located=100000))
    assert len(recorded.time) < 20 and 4 < len(recorded.event_records) < 20
    energy = recorded["energy/total"]
    assert energy.max() < 1.001 * energy[0]
    assert np.abs(errors(recorded)).max() < 1e-4


def test_events_that_the_end_of_a_trial_does_not_show_are_located_before_later_ones():
    """A mass rebounds within a trial of 16 ms; the step to a later event of another line ends while its line is taut.

    Left slack, the line would keep 8 % of the energy as that of its elongation, without a force.
    """
    energy = RecordedRun(rattling("step: 2 ms, adaptive: {tolerance: 1.0e-3}", 0.33, damping=2.0e-6))["energy/total"]
    assert energy.max() < 1.001 * energy[0]


def test_a_resumed_run_has_the_same_bits_and_the_results_name_what_was_captured(tmp_path):
    checked = rattling("step: 5 ms", end=0.15)
    for name in ("whole", "parts"):
        with begun(checked, tmp_path / f"{name}.h5", False) as ongoing:
            ongoing.advance(0.07)
            assert ongoing.integrator.monitor.captures
            ongoing.to_the_end() if name == "whole" else ongoing.leave()
    resume(checked, tmp_path / "parts.h5")
    check_same(contents(tmp_path / "parts.h5"), contents(tmp_path / "whole.h5"))
    with open_results(tmp_path / "whole.h5") as results:
        (text,) = [text for text in results.warnings if "located" in text]
        assert "time.located_events = 10" in text and "cable 'left" in text and "'time.step'" in text
        assert len(results.events) > 100

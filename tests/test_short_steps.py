"""Runs in which steps are very short for long: a warning names the unknown that limits them."""

import pytest
from time_runs import deck

import mecano
from mecano.analyses.dynamic import run

HUM = """
    mecano: 1
    gravity: none
    nodes: {{a: {{position: [0, 0, 0]}}, b: {{position: [1, 0, 0]}}}}
    elements:
      left: {{type: point_mass, node: a, mass: 1}}
      right: {{type: point_mass, node: b, mass: 1}}
      coil: {{type: spring_damper, nodes: [a, b], law: {{spring: 10}}}}
    joints:
      guide_a: {{type: prismatic, nodes: [ground, a], axis: [1, 0, 0]}}
      guide_b: {{type: prismatic, nodes: [ground, b], axis: [1, 0, 0]}}
    loads: {{hum: {{type: force, node: b, direction: [1, 0, 0], value: hum}}}}
    signals: {{hum: "{amplitude}*sin(1.0e5*time)*max(0, 1 - abs(time - 0.51)/1.0e-4)"}}
    time: {{end: 10, step: 1 ms, adaptive: {{tolerance: 1.0e-4}}}}
"""


@pytest.mark.parametrize(("amplitude", "warned"), [(1e6, True), (1.0, False)])
def test_short_steps_are_warned_of(amplitude, warned, tmp_path):
    """A force of 16 kHz for 0.2 ms, in a run of 10 s; a small one displaces nothing."""
    run(deck(HUM.format(amplitude=amplitude)), tmp_path / "hum.h5")
    with mecano.open_results(tmp_path / "hum.h5") as results:
        found = [text for text in results.warnings if "times less than the others" in text]
    assert len(found) == warned
    for text in found:
        assert "there the acceleration changes most in node b: displacement x; on it act point_mass 'right'" in text
        begin, end = (float(text.partition(before)[2].split()[0]) for before in ("between t = ", " s and "))
        assert begin < end == pytest.approx(0.5101, abs=1e-4)

"""Runs in which steps are very short for long: a warning names the unknown that limits them."""

from collections import Counter
from types import SimpleNamespace

import pytest
from time_runs import deck

import mecano
from mecano.analyses import dynamic, outlook
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


def test_a_run_that_will_take_long_says_so_once(tmp_path, monkeypatch):
    """While it goes on: here after no time, with what limits the steps."""
    monkeypatch.setattr(dynamic, "AT_ONCE", -1.0)
    monkeypatch.setattr(outlook, "WATCHED", 0.0)
    monkeypatch.setattr(outlook, "LONG", 0.0)
    said = []
    run(deck(HUM.format(amplitude=1e6)), tmp_path / "hum.h5", announce=said.append, interval=1e-3)
    [text] = [text for text in said if "at this pace the rest of the run takes" in text]
    assert "The acceleration changes most in node " in text and "displacement x; on it act point_mass" in text


@pytest.mark.parametrize(
    ("step", "at", "said"),
    [
        (
            1e-6,
            1.0,
            "1e-06 s on average, 1e+04 times less than the longest; at this pace the rest of the run takes 5 hours",
        ),
        (1e-4, 1.0, ""),  # not so much shorter than the longest
        (1e-6, 9.9, ""),  # soon at its end: 3 minutes
    ],
)
def test_the_pace_of_a_run(monkeypatch, step, at, said):
    """A thousand seconds for half a second of motion, which ends at 10 s."""
    times, texts = iter([0.0, 1000.0]), []
    monkeypatch.setattr(outlook.clock, "monotonic", lambda: next(times))
    runs = [
        SimpleNamespace(steps=0, motion=SimpleNamespace(t=at - 0.5)),
        SimpleNamespace(steps=round(0.5 / step), motion=SimpleNamespace(t=at)),
    ]
    events = SimpleNamespace(instants=0, happened=Counter())
    method = SimpleNamespace(method=SimpleNamespace(order=5), events=events)
    outlook.Outlook(method, 10.0, texts.append, runs[0]).look(runs[1], 0.01)
    assert len(texts) == bool(said) and all(said in text for text in texts)


def test_a_run_whose_steps_end_at_events_names_their_elements(tmp_path, monkeypatch):
    """A ball between two cables, which it makes taut in turn within each step."""
    monkeypatch.setattr(dynamic, "AT_ONCE", -1.0)
    monkeypatch.setattr(outlook, "WATCHED", 0.0)
    monkeypatch.setattr(outlook, "LONG", 0.0)
    said = []
    checked = deck("""
        mecano: 1
        gravity: none
        nodes: {a: {position: [0, 0, 0], fixed: true}, b: {position: [1, 0, 0]}, c: {position: [2, 0, 0], fixed: true}}
        elements:
          ball: {type: point_mass, node: b, mass: 1}
          left: {type: cable, nodes: [a, b], axial_stiffness: 1e8, natural_length: 1.001}
          right: {type: cable, nodes: [b, c], axial_stiffness: 1e8, natural_length: 1.001}
        initial: {velocities: [{nodes: [b], velocity: [1, 0, 0]}]}
        time: {end: 0.5, step: 5 ms, located_events: 100000}
    """)
    run(checked, tmp_path / "ball.h5", announce=said.append, interval=1e-3)
    [text] = [text for text in said if "at this pace the rest of the run takes" in text]
    assert "instants of events, most of cable '" in text and "'time.located_events: 1'" in text

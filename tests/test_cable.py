"""Bars and cables: a fall on a slack rope, a hoist, damping that never pushes, refusals."""

import math
import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.dynamic import run
from mecano.analyses.modal import modes
from mecano.elements import KINDS
from mecano.errors import ConvergenceError

g = 9.81
M, FALL, STIFFNESS = 50.0, 0.5, 5000.0
OMEGA, TAUT = math.sqrt(STIFFNESS / M), math.sqrt(2 * FALL / g)
SLACK = TAUT + (2 * math.pi - 2 * math.atan(g * TAUT * OMEGA / g)) / OMEGA
PEAK = M * g * (1 + math.sqrt(1 + 2 * FALL * STIFFNESS / (M * g)))


def test_fall_on_a_slack_rope():
    """Taut at sqrt(2 h/g), exactly; slack again and peak with errors of the second order (closed form)."""
    errors, drifts = [], []
    for step in (2e-3, 1e-3, 5e-4):
        recorded = RecordedRun(input_deck("cable_snatch", f"time.step={step}", "time.end=0.75"))
        assert [h.name for h in recorded.event_records] == ["goes taut", "goes slack"]
        assert recorded.event_records[0].t == pytest.approx(TAUT, abs=1e-9)
        tension = recorded["elements/rope/tension"]
        errors.append((abs(recorded.event_records[1].t - SLACK), abs(tension.max() - PEAK) / PEAK))
        assert tension.min() > -1e-9 * PEAK
        np.testing.assert_allclose(recorded["elements/rope/stress"], tension / 8e-5, rtol=1e-14)
        drifts.append(np.ptp(recorded["energy/balance"]))
    errors = np.array(errors)
    assert errors[-1].max() < 2e-6
    assert errors[0, 0] / errors[2, 0] == pytest.approx(16.0, rel=0.02)
    assert drifts[2] < 2e-4 and drifts[0] / drifts[2] == pytest.approx(16.0, rel=0.02)  # [J] of 245


def length_of_the_wire(recorded):
    """The one equation of the hoist, integrated to 1e-11: the length at the times of the run."""
    m, mu, EA, tau = 200.0, 8.0, 5e5, 0.02

    def natural(t):
        u = min(max((t - 0.5) / 3.0, 0.0), 1.0)
        return 10 - 4 * u**3 * (10 - 15 * u + 6 * u**2), -4 * 30 * u**2 * (1 - u) ** 2 / 3.0

    def rate(t, y):
        L, L1 = natural(t)
        strain, strain_rate = y[0] / L - 1, y[1] / L - y[0] * L1 / L**2
        return y[1], ((m + mu / 2) * g - EA * (strain + tau * strain_rate)) / (m + mu / 3)

    ends = (0.0, 0.5, 3.5, recorded.time[-1])
    y, found = np.array([10.04, 0.0]), []
    for start, end in zip(ends, ends[1:], strict=False):
        times = recorded.time[(recorded.time > start) & (recorded.time <= end)]
        part = solve_ivp(rate, (start, end), y, method="DOP853", rtol=1e-12, atol=1e-13, dense_output=True)
        y = part.y[:, -1]
        found.append(part.sol(times)[0])
    return np.concatenate([[10.04], *found])


def test_hoist():
    """Length, hanging state and the work of the winch; errors of the second order."""
    errors, drifts = [], []
    for step in (4e-3, 2e-3):
        recorded = RecordedRun(input_deck("hoist", f"time.step={step}"))
        errors.append(np.abs(recorded["elements/wire/length"] - length_of_the_wire(recorded)).max())
        drifts.append(np.ptp(recorded["energy/balance"]))
    assert errors[1] < 1e-6 and drifts[1] < 0.005  # [m] of 10, [J] of 8000
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.01)
    assert drifts[0] / drifts[1] == pytest.approx(4.0, rel=0.01)
    weight = 204.0 * g
    assert recorded["elements/wire/length"][-1] == pytest.approx(6 * (1 + weight / 5e5), rel=1e-6)
    work = recorded["energy/given"][-1]
    change = recorded["energy/potential"][-1] - recorded["energy/potential"][0]
    assert work == pytest.approx(change + recorded["energy/dissipated"][-1], abs=0.1)
    assert change == pytest.approx(weight * (10.04 - recorded["elements/wire/length"][-1]), rel=0.01)


BOUNCE = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      anchor: {{position: [0, 0, 0], fixed: true}}
      load: {{position: [0, 0, -1]}}
    elements:
      load: {{type: point_mass, node: load, mass: 2.0}}
      rope: {{type: cable, nodes: [anchor, load], axial_stiffness: 2000, natural_length: {length}, damping: {damping}}}
    time: {{end: 2.0, step: {step}}}
"""


@pytest.mark.parametrize("damping", [2e-3, 2e-2])
def test_a_damped_cable_never_pushes_and_keeps_the_balance_of_energy(damping):
    """Its damping does not double the elastic force as it becomes taut; it is slack again before it is short."""
    drift = []
    for step in (2e-3, 1e-3):
        recorded = RecordedRun(deck(BOUNCE.format(length=1.2, damping=damping, step=step)))
        tension, strain = recorded["elements/rope/tension"], recorded["elements/rope/strain"]
        assert tension.min() == 0.0
        assert {h.name for h in recorded.event_records} == {"goes taut", "goes slack", "is relaxed"}
        left = strain[
            [np.argmin(np.abs(recorded.time - h.t)) for h in recorded.event_records if h.name == "goes slack"]
        ]
        assert left[0] > 1e-4  # slack while longer than natural
        drift.append(np.ptp(recorded["energy/balance"]) / np.ptp(recorded["energy/dissipated"]))
    assert drift[1] < 2e-3 and drift[1] < 0.5 * drift[0]
    assert np.all(np.diff(recorded["energy/dissipated"]) >= -1e-12)


@pytest.mark.parametrize(
    ("length", "said"),
    [
        (
            '"0.5*time"',
            "t = 0 s: cable 'rope' has 'natural_length' 0 m, at a distance of its nodes of 1 m: it must stay",
        ),
        ('"1.2 - time"', "cable 'rope' has 'natural_length' "),
        ("{linear: {slope: -1, offset: 1.2}}", "cable 'rope' has 'natural_length' "),
    ],
)
def test_a_natural_length_that_vanishes_ends_the_run(length, said, tmp_path):
    """At the start, where a formula lacks the initial length, or later under a load that the cable cannot lift."""
    held = "joints: {hold: {type: prescribed_position, node: load, direction: [0, 0, 1], value: 0}}"
    given = deck(BOUNCE.format(length=length, damping=0, step=1e-3) + f"    {held}\n")
    with pytest.raises(ConvergenceError, match=re.escape(said)):
        run(given, tmp_path / "r.h5")


def test_the_damping_of_a_cable_is_limited_by_its_elastic_force(verify):
    """A fall of 2 kg on a slack cable: m x'' = m g - N(x - L, x'), N within 0 and twice the elastic force, by SciPy."""
    k, found = 2000.0 / 1.2, []

    def rates(_, y):
        elastic = k * max(y[0] - 1.2, 0.0)
        return y[1], g - (elastic + min(max(2e-2 * k * y[1], -elastic), elastic)) / 2.0

    exact = solve_ivp(rates, (0.0, 1.5), (1.0, 0.0), method="DOP853", rtol=1e-11, atol=1e-13, max_step=1e-4)
    for step in (2e-3, 1e-3):
        recorded = RecordedRun(deck(BOUNCE.format(length=1.2, damping=2e-2, step=step).replace("end: 2.0", "end: 1.5")))
        found.append(recorded["elements/rope/length"][-1])
    assert abs(found[1] - exact.y[0, -1]) < 0.5 * abs(found[0] - exact.y[0, -1])
    verify(
        "Cables", "bounce on a damped cable: length after 1.5 s [m]", found[1], exact.y[0, -1], "SciPy", relative=2e-4
    )


def test_a_cable_relaxes_for_its_damping_time():
    """It goes slack where eps + tau deps/dt = 0, and flies freely: its strain vanishes after tau, and energy balances.

    The relative error of the balance is of the order of the tolerance of Radau IIA.
    """
    lines = BOUNCE.format(length=0.95, damping=2e-2, step="1 ms, method: radau, adaptive: {tolerance: 1e-8}")
    recorded = RecordedRun(deck(lines.replace("[0, 0, -9.81]", "none").replace("end: 2.0", "end: 0.2")))
    slack, relaxed = recorded.event_records
    assert (slack.name, relaxed.name) == ("goes slack", "is relaxed")
    assert relaxed.t - slack.t == pytest.approx(2e-2, abs=1e-10)
    assert np.ptp(recorded["energy/balance"]) < 1e-8 * recorded["energy/potential"][0]


def test_stiffness_and_length_are_checked():
    nodes = [(np.zeros(3), np.eye(3)), (np.array([2.0, 0, 0]), np.eye(3))]
    for d, texts in (
        ({}, ["give either 'axial_stiffness' or 'E' with 'area'"]),
        (
            {"axial_stiffness": 1.0, "E": 1.0},
            ["give either 'axial_stiffness' or 'E' with 'area'"],
        ),
        ({"E": 1.0}, ["'area' is missing: 'E' alone gives no axial stiffness"]),
        ({"axial_stiffness": 1.0, "natural_length": 0.0}, ["'natural_length' must be greater than zero at t = 0"]),
        ({"E": 1.0, "area": 1.0}, []),
        (
            {"axial_stiffness": 1.0, "natural_length": 1.0, "pretension": 1.0},
            ["give either 'natural_length' or 'pretension', from which it follows"],
        ),
        ({"axial_stiffness": 1.0, "pretension": -1.0}, ["'pretension' must be greater than -EA"]),
    ):
        for kind in (KINDS["bar"], KINDS["cable"]):
            values = {**{f.name: f.default for f in kind.fields}, **d}
            negative = kind is KINDS["cable"] and values["pretension"] < 0.0
            assert kind.check(values, nodes) == texts + ["'pretension' of a cable must not be negative"] * negative


WIRES = """
    mecano: 1
    gravity: none
    nodes:
      left: {position: [0, 0, 0], fixed: true}
      bead: {position: [0.5, 0, 0], velocity: [0, 0.01, 0]}
      right: {position: [1.5, 0, 0], fixed: true}
    elements:
      bead: {type: point_mass, node: bead, mass: 0.2}
      a: {type: cable, nodes: [left, bead], axial_stiffness: 20 kN, pretension: 50}
      b: {type: cable, nodes: [bead, right], axial_stiffness: 30 kN, pretension: 50}
    time: {end: 0.05, step: 1.0e-4}
"""


def test_a_bead_on_prestressed_wires(verify):
    """Across the wires T/l_1 + T/l_2 is its stiffness; along them EA/L of both, L = l/(1 + T/EA)."""
    checked = deck(WIRES.replace(", velocity: [0, 0.01, 0]", ""))
    frequencies = np.sort(np.abs(modes(checked, None)[1].values))
    stiffness = np.array([50.0 / 0.5 + 50.0, 50.0 / 0.5 + 50.0, 20e3 * 1.0025 / 0.5 + 30e3 * (1.0 + 50.0 / 30e3)])
    what = "prestressed wires: frequencies [rad/s]"
    verify("Cables", what, frequencies, np.sqrt(stiffness / 0.2), "closed form", relative=1e-9)


HOOKED = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {top: {position: [0, 0, 0], fixed: true}, b: {position: [0, 0, -1]}}
    elements:
      b: {type: point_mass, node: b, mass: 2}
      line: {type: cable, nodes: [top, b], axial_stiffness: 2 kN, pretension: 40,
             activate: {time: 0.2, stress_free: true}}
    time: {end: 0.3, step: 5.0e-4}
"""


def test_a_cable_is_hooked_on_a_falling_weight():
    """Its natural length makes the pretension T at the distance l that it finds; u'' = g - (T + k u)/m from then on."""
    run = RecordedRun(deck(HOOKED))
    (activated,) = run.event_records
    length, speed = 1.0 + 0.5 * g * 0.04, 0.2 * g
    natural = length / (1.0 + 40.0 / 2e3)
    k, after = 2e3 / natural, run.time > 0.2 + 1e-9
    assert activated.t == pytest.approx(0.2, abs=1e-9) and activated.after == "taut"
    assert activated.lost == pytest.approx(-0.5 * 40.0**2 / k, rel=1e-8)
    np.testing.assert_allclose(run["elements/line/natural_length"][after], natural, rtol=1e-8)
    w, mean, t = math.sqrt(k / 2.0), (2.0 * g - 40.0) / k, run.time[after] - 0.2
    u = mean * (1.0 - np.cos(w * t)) + speed / w * np.sin(w * t)
    np.testing.assert_allclose(run["elements/line/length"][after], length + u, atol=1e-5)
    assert np.ptp(run["energy/balance"]) < 1e-4 * activated.lost * -1.0

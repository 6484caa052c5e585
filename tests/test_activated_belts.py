"""Belts that are engaged or cut at a time or by a condition: motion, energy, resuming, modes."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from surviving import check_same, contents, resumed
from time_runs import INPUTS, RecordedRun, deck

from mecano.analyses.dynamic import run
from mecano.analyses.kind_tests import OF_EVERY_KIND
from mecano.analyses.operating_point import operating_point
from mecano.constraints.belt_span import span_kind
from mecano.errors import DeckError
from mecano.solve.modal.linearize import linearize
from mecano.solve.modal.modes import solve

S = "Belts and cables over pulleys"
KINDS = [span_kind(*of) for of in [(False, False, None), (True, True, None), (False, True, False), (True, False, True)]]


@pytest.mark.parametrize("check", OF_EVERY_KIND, ids=lambda check: check.__name__)
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: "-".join((kind.name, *kind.phases)))
def test_spans_in_every_phase(kind, check):
    check(kind)


DRIVE = """
    mecano: 1
    gravity: none
    nodes:
      motor: {position: [0, 0, 0]}
      machine: {position: [0.8, 0, 0.2]}
    elements:
      motor: {type: rigid_body, node: motor, mass: 2, inertia: [0.02, 0.02, 0.02]}
      machine: {type: rigid_body, node: machine, mass: 8, inertia: [0.3, 0.5, 0.3]}
      belt: {type: belt, nodes: [motor, machine], radii: [0.1, 0.25], axis: [0, 1, 0], closed: true,
             axial_stiffness: 80 kN, damping: 1 ms, pretension: 200, MORE}
    joints:
      motor: {type: hinge, nodes: [ground, motor], axis: [0, 1, 0]}
      machine: {type: hinge, nodes: [ground, machine], axis: [0, 1, 0]}
    initial: {velocities: [{nodes: [motor], angular_velocity: [0, 60, 0]}]}
    time: {end: END, step: STEP}
"""
SPAN = math.sqrt(0.68 - 0.15**2)
STIFFNESS = 80e3 / SPAN


def drive(more, end, step):
    return deck(DRIVE.replace("MORE", more).replace("END", str(end)).replace("STEP", str(step)))


def tension(stretch, rate):
    """Return the tension of a span, which only pulls; its viscous part is at most as large as the elastic one."""
    return STIFFNESS * (stretch + min(max(1e-3 * rate, -stretch), stretch)) if stretch > 0.0 else 0.0


def engaged(duration):
    """Return the rates (2,) of motor and machine ``duration`` after the belt lies down, by SciPy."""
    rest = 200.0 / STIFFNESS

    def motion(_, y):
        s, motor, machine = y
        rate = 0.1 * motor - 0.25 * machine
        pull = tension(rest + s, rate) - tension(rest - s, -rate)
        return rate, -0.1 * pull / 0.02, 0.25 * pull / 0.5

    return solve_ivp(motion, (0.0, duration), (0.0, 60.0, 0.0), rtol=1e-9, atol=1e-12, max_step=1e-5).y[1:, -1]


@pytest.mark.parametrize("trigger", ["time: 0.3", "when: motor.angle > 18"])
def test_a_drive_is_engaged(verify, trigger):
    """After 18 rad of the motor the belt lies down on both pulleys: momentum gives the speeds that are left."""
    activate = f"activate: {{{trigger}, stress_free: true}}"
    m = RecordedRun(drive(activate, 0.31, 2.5e-5))
    first, second, *_ = m.event_records
    assert [(e.name, e.before) for e in (first, second)] == [("activates", "inactive")] * 2
    assert {first.after, second.after} == {"taut", "relaxing"}  # by damping one span would push
    assert first.t == pytest.approx(0.3, abs=1e-9)
    assert [first.lost, second.lost] == pytest.approx([-0.5 * 200.0**2 / STIFFNESS] * 2, rel=1e-9)
    rates = [m[f"joints/{name}/rate"][-1] for name in ("motor", "machine")]
    verify(
        S, f"belt drive engaged ({trigger}): rates after 10 ms [rad/s]", rates, engaged(0.01), "SciPy", relative=1e-5
    )
    m = RecordedRun(drive(activate, 0.6, 1e-3))
    rates = [m[f"joints/{name}/rate"][-1] for name in ("motor", "machine")]
    verify(S, f"belt drive engaged ({trigger}): rates at last [rad/s]", rates, [12.0, 4.8], "momentum", relative=1e-6)
    np.testing.assert_array_equal(m["elements/belt/tension_1"][m.time <= 0.3], 0.0)


HOIST = """
    mecano: 1
    gravity: [0, 0, -10]
    nodes:
      drum: {position: [0, 0, 0]}
      weight: {position: [0.1, 0, -1]}
    elements:
      drum: {type: rigid_body, node: drum, mass: 5, inertia: [0.06, 0.06, 0.06]}
      weight: {type: point_mass, node: weight, mass: 4}
      rope: {type: belt, nodes: [weight, drum], radii: [0, -0.1], axis: [0, 1, 0], axial_stiffness: 2.0e3,
             activate: {time: 0.1}, release: {when: rope.stretch_1 > 0.058}}
    joints:
      bearing: {type: hinge, nodes: [ground, drum], axis: [0, 1, 0]}
    time: {end: 0.2, step: STEP}
"""


def test_a_rope_takes_hold_of_a_drum_and_breaks(verify):
    """The stretch s, 50 mm at the activation, grows by s'' = g - k (1/m + r^2/I) s, and the rope breaks at 58 mm."""
    k, m, inertia = 2e3, 4.0, 6.0
    w, mean = math.sqrt(k * (1 / m + 1 / inertia)), 10.0 / (k * (1 / m + 1 / inertia))
    size, phase = math.hypot(0.05 - mean, 1.0 / w), math.atan2(0.05 - mean, 1.0 / w)
    after = (math.asin((0.058 - mean) / size) - phase) / w
    pull = k * (mean * after + size / w * (math.cos(phase) - math.cos(w * after + phase)))  # impulse
    known, found = [0.1 + after, -2.0 + pull / m, pull * 0.1 / 0.06], []
    for step in (4e-4, 2e-4):
        r = RecordedRun(deck(HOIST.replace("STEP", str(step))))
        begins, ends = r.event_records
        assert [(e.name, e.before, e.after) for e in (begins, ends)] == [
            ("activates", "inactive", "taut"),
            ("releases", "taut", "released"),
        ]
        assert [begins.lost, ends.lost] == pytest.approx([-0.5 * k * 0.05**2, 0.5 * k * 0.058**2], rel=1e-7)
        assert np.ptp(r["energy/balance"]) < 1e-3 * np.ptp(r["energy/kinetic"])
        speed, rate = r["nodes/weight/velocity"][-1, 2], r["joints/bearing/rate"][-1]
        found.append(np.array([ends.t, speed, abs(rate)]))
    verify.second_order(S, "rope that is activated and breaks: instant, speeds", *found, known, 1e-7, "oscillation")


def test_a_drive_that_is_cut():
    """Both spans of the drive at rest lose their energy, and the pulleys keep their speeds."""
    m = RecordedRun(drive("release: {time: 0.01}", 0.02, 1e-4))
    rates = np.array([m[f"joints/{name}/rate"] for name in ("motor", "machine")])
    np.testing.assert_allclose(np.ptp(rates[:, m.time > 0.0101], axis=1), 0.0, atol=1e-9)
    assert [event.after for event in m.event_records if event.name == "releases"] == ["released"] * 2
    assert np.ptp(m["energy/balance"]) < 1e-3 * np.ptp(m["energy/kinetic"])


def test_a_drive_that_was_engaged_is_resumed_and_linearized(tmp_path):
    """Resumed to the same bits; about the replayed end the pulleys oscillate on both spans, with their damping."""
    model = drive("activate: {time: 0.03, stress_free: true}", 0.5, 1e-3)
    run(model, tmp_path / "whole.h5")
    resumed(model, tmp_path / "r.h5", (20, 40))
    check_same(contents(tmp_path / "r.h5"), contents(tmp_path / "whole.h5"))
    base = operating_point(model, f"{tmp_path / 'r.h5'}:0.5")
    found = solve(linearize(base.prepared.system, base.state, 1.0)).values
    square = 2.0 * STIFFNESS * (0.1**2 / 0.02 + 0.25**2 / 0.5)
    root = np.roots([1.0, 1e-3 * square, square])[0]
    assert np.abs(np.abs(found.imag) - abs(root.imag)).min() < 1e-6 * abs(root)


PASSING = """
    mecano: 1
    gravity: none
    nodes:
      drum: {position: [0, 0, 0]}
      weight: {position: [1, 0, -0.05]}
    elements:
      drum: {type: rigid_body, node: drum, mass: 5, inertia: [0.06, 0.06, 0.06]}
      weight: {type: point_mass, node: weight, mass: 4}
      rope: {type: belt, nodes: [weight, drum], radii: [0, -0.1], axis: [0, 1, 0], axial_stiffness: 2.0e3,
             pretension: 5, activate: {time: 1.8, stress_free: true}}
    joints:
      bearing: {type: hinge, nodes: [ground, drum], axis: [0, 1, 0]}
    initial: {velocities: [{nodes: [weight], velocity: [-1, 0, 0]}]}
    time: {end: 1.805, step: 5.0e-3}
"""


def test_before_its_activation_a_belt_may_have_no_tangent():
    """The weight flies through the drum, where the outputs are zero, and is caught behind it with the pretension."""
    m = RecordedRun(deck(PASSING))
    assert np.all(np.isfinite(m.rows))
    inside = np.hypot(*m["nodes/weight/position"][:, [0, 2]].T) < 0.1
    assert inside.any()
    np.testing.assert_array_equal(m["elements/rope/span_1"] == 0.0, inside)
    (event,) = m.event_records
    k = 2e3 / math.sqrt(1.0 + 0.05**2 - 0.1**2)
    assert event.lost == pytest.approx(-0.5 * 5.0**2 / k, rel=1e-9)


def test_a_belt_of_many_spans_is_engaged_at_once():
    """Each of them has its event and its energy, N^2/(2 k), which is no repetition of an event at standstill."""
    angles = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    places = "".join(
        f"  p{i}: {{position: [{math.cos(a)}, {math.sin(a)}, 0], fixed: true}}\n" for i, a in enumerate(angles)
    )
    names = ", ".join(f"p{i}" for i in range(24))
    ring = f"nodes: [{names}], radii: {[0.05] * 24}, axis: [0, 0, 1], closed: true, axial_stiffness: 1000"
    m = RecordedRun(
        deck(
            f"mecano: 1\ngravity: none\nnodes:\n{places}  mass: {{position: [3, 0, 0]}}\nelements:\n"
            "  mass: {type: point_mass, node: mass, mass: 1}\n"
            f"  belt: {{type: belt, {ring}, pretension: 10, activate: {{time: 0.01}}}}\n"
            "time: {end: 0.02, step: 1.0e-3}\n"
        )
    )
    span = 2.0 * math.sin(math.pi / 24)
    assert [event.lost for event in m.event_records] == pytest.approx([-0.5 * 10.0**2 / 1000.0 * span] * 24, rel=1e-9)
    assert m["energy/given"][-1] == pytest.approx(24 * 0.05 * span, rel=1e-9)


def test_a_belt_needs_a_time_or_a_condition():
    text = (INPUTS / "belt_drive.yaml").read_text()
    for name in ("activate", "release"):
        with pytest.raises(DeckError) as error:
            deck(text.replace("pretension: 200", f"pretension: 200\n    {name}: {{}}"))
        assert f"'{name}' needs either 'time' or 'when'" in error.value.problems[0].message

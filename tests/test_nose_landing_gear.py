"""inputs/nose_landing_gear.yaml: comparison with the paper, accuracy, and the sheet of its drop test.

The paper: section 4.2 of Cardona, Geradin & Doan, CMAME 89 (1991). Times of contact are read there to 0.05 s.
"""

import re

import numpy as np
import pytest
from planar_gear import PlanarGear
from time_runs import RecordedRun, input_deck

import mecano
from mecano.analyses.dynamic import run
from mecano.post.drop_test import drop_sheet, efficiency, spin_up_and_spring_back
from mecano.post.request import Request, requested_sheet
from mecano.post.runs import open_runs

SLIP_REGULARIZATION = 0.1  # m/s, of the deck
WAVE = 80.0 / 60.0  # s


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Results of (a) and (b), all steps."""
    folder = tmp_path_factory.mktemp("landing")
    cases = {"a": (), "b": ("parameters.bump_amplitude=0.03",)}
    for name, overrides in cases.items():
        run(input_deck("nose_landing_gear", "output.every=step", *overrides), folder / f"{name}.h5")
    return {name: folder / f"{name}.h5" for name in cases}


@pytest.fixture(scope="module")
def cases(files):
    return {name: mecano.open_results(path) for name, path in files.items()}


@pytest.fixture(scope="module")
def flat(cases):
    return cases["a"]


def values(results, name):
    return results.find(name).values


def contacts(happened):
    """Times at which the wheel leaves and meets the ground after the first touch-down."""
    times = [(e.name, e.time) for e in happened if e.name in ("touch_down", "lift_off")]
    assert [name for name, _ in times] == ["touch_down", *["lift_off", "touch_down"] * (len(times) // 2)]
    return np.array([time for _, time in times[1:]])


def swing(t, y, start, end):
    """How far y (n,) swings about its mean over 50 ms, within a time [s]."""
    at = np.arange(start, end, 2e-4)
    y, window = np.interp(at, t, y), np.ones(251) / 251
    return np.ptp(y[125:-125] - np.convolve(y, window, "valid"))


def test_two_rebounds_as_in_the_paper(flat):
    """Off the ground from 0.45 to 0.8 s and from 1.1 to 1.2 s, then no more."""
    times = contacts(flat.events)
    assert times == pytest.approx([0.45, 0.8, 1.1, 1.2], abs=0.08)
    assert times[1] - times[0] == pytest.approx(0.35, abs=0.10)
    assert times[3] - times[2] == pytest.approx(0.10, abs=0.05)


@pytest.mark.parametrize("case", ["a", "b"])
def test_it_rolls_without_slip_and_brakes_without_skid(cases, case):
    """After 1.8 s (paper); the regularized friction creeps: at less than twice its regularization counts as rolling."""
    results = cases[case]
    t, along, across = results.time, values(results, "wheel.longitudinal_slip"), values(results, "wheel.lateral_slip")
    assert len(contacts(results.events)) == 4
    assert np.hypot(along, across)[t > 1.8].max() < 2 * SLIP_REGULARIZATION
    torque, bound = values(results, "brake.torque"), values(results, "brake.bound")
    assert np.all(torque[t < 2.5] == 0.0) and np.all(torque <= bound) and torque[t > 3.0].min() > 4.3e3
    assert values(results, "top.velocity")[-1, 0] < 57.0


def test_strongest_loads_in_the_impact(flat):
    """Before the first rebound (paper)."""
    t, lift_off = flat.time, contacts(flat.events)[0]
    for name in ("wheel.radial_force", "wheel.contact_force", "absorber.force", "leg_foot.stress", "attitude.moment"):
        size = np.linalg.norm(values(flat, name).reshape(len(t), -1), axis=1)
        assert t[np.argmax(size)] < lift_off
        assert size[t > lift_off].max() < 0.85 * size.max()


def test_deformations_stay_in_their_range(flat):
    """The quartic holds to 0.12 m; braking stays far from what makes the patch diverge; the absorber never bottoms."""
    assert values(flat, "wheel.deformation").max() == pytest.approx(0.1128, abs=1e-4)
    assert values(flat, "wheel.divergence").max() < 0.5
    assert {e.name for e in flat.events if "stop" in e.name} == {"upper stop opens", "upper stop closes"}


@pytest.mark.parametrize("case", ["a", "b"])
def test_lateral_oscillations_die_when_it_rolls(cases, case):
    """As in the paper. The drift excites them at every touch-down; what stays is its own slow decay."""
    results = cases[case]
    t, y = results.time, values(results, "wheel.y")
    touch_down = contacts(results.events)[-1]
    assert swing(t, y, touch_down, touch_down + 0.3) > 1e-3
    assert swing(t, y, 1.5, 2.4) < 1e-5
    assert 0.0 < y[-1] < 0.2 * y.max()


def test_height_on_waves_swings_about_that_on_flat_ground(cases):
    """Over the last wave; as high as the waves, which the wheel follows."""
    at = np.linspace(4.0 - WAVE, 4.0, 400)
    flat, wavy = (
        np.interp(at, results.time, values(results, "axle.position")[:, 2]) for results in cases.values()
    )  # fmt: skip
    assert np.mean(wavy - flat) == pytest.approx(0.0, abs=2e-3)
    assert np.ptp(wavy - flat) == pytest.approx(0.06, abs=0.01)


@pytest.mark.parametrize("case", ["a", "b"])
def test_energy_is_accounted_for(cases, case):
    """To 1e-6 of the energy at the start."""
    results = cases[case]
    assert np.ptp(values(results, "energy/balance")) < 1e-6 * values(results, "energy/total")[0]


def test_accuracy_of_the_tolerance(flat):
    """Beside a run with a hundredth of the tolerance: a tenth of the 2 ms and 1 % that are asked for."""
    assert contacts(flat.events) == pytest.approx([0.470669, 0.739683, 1.090283, 1.201655], abs=2e-4)
    assert values(flat, "wheel.radial_force").max() == pytest.approx(203609.2, rel=1e-3)
    assert values(flat, "wheel.height").max() == pytest.approx(0.410496, rel=1e-3)
    assert len(flat.time) < 2300


def planar_gear(deck):
    """The PlanarGear of the deck's beams, tubes of which only those of the arm turn."""
    at = {name: d["position"][0] + 1j * d["position"][2] for name, d in deck.values["nodes"].items()}
    load, parts = deck.values["elements"]["aircraft"]["mass"], []
    for name, d in deck.values["elements"].items():
        if d["type"] != "beam":
            continue
        (a, b), tube = (at[node] - at["arm_elbow"] for node in d["nodes"]), d["section"]
        outer, inner = tube["diameter"], tube["diameter"] - 2 * tube["thickness"]
        mass = tube["density"] * np.pi / 4 * (outer**2 - inner**2) * abs(b - a)
        if name.startswith("arm"):
            across = mass * (abs(b - a) ** 2 / 12 + (outer**2 + inner**2) / 16)
            parts.append((mass, (a + b) / 2, across))
        else:
            load += mass
    mass = sum(m for m, _, _ in parts)
    centre = sum(m * c for m, c, _ in parts) / mass
    return PlanarGear(deck, load, (mass, centre, sum(J + m * abs(c - centre) ** 2 for m, c, J in parts)))


def test_stiff_beams_move_as_rigid_bodies():
    """Without drift and flexibility: the planar model in minimal coordinates, integrated at 1e-9."""
    stiff = [f"sections.{name}.E=2.1e16" for name in ("leg", "arm", "brace")]
    settings = ["parameters.drift=0", "time.end=1.6", "time.adaptive.tolerance=1e-3"]
    recorded = RecordedRun(input_deck("nose_landing_gear", *stiff, *settings))
    planar = planar_gear(input_deck("nose_landing_gear"))
    times, states = planar.run(1.6, -3.05, 60.0)
    w, s = np.array([planar.deformation(y) for y in states]).T
    happened = [h.t for h in recorded.event_records if h.name in ("touch_down", "lift_off")]
    assert happened[1:] == pytest.approx(times[1:], abs=5e-5)
    assert recorded["elements/wheel/deformation"].max() == pytest.approx(w.max(), rel=1e-5)
    assert recorded["elements/absorber/stroke"].max() == pytest.approx(-s.min(), rel=1e-4)
    assert np.abs(recorded["nodes/axle/position"][:, 1]).max() < 1e-12


@pytest.mark.parametrize(("force", "expected"), [(lambda s: 3.0 + 0 * s, 1.0), (lambda s: s, 0.5)])
def test_efficiency(force, expected):
    """1 for a constant force, 1/2 for a spring; the way back does not count."""
    stroke = np.concatenate([np.linspace(0.0, 0.2, 50), np.linspace(0.2, 0.0, 20)])
    assert efficiency(stroke, force(stroke)) == pytest.approx(expected, rel=1e-12)


def test_spring_back_comes_after_spin_up():
    assert spin_up_and_spring_back(np.array([0.0, -9.0, 5.0, 8.0, 1.0, -4.0, 2.0, -3.0])) == (3, 5)


def test_page_of_the_drop_test(files):
    """The first impact only; the drag on the axle is that of the ground but for the momentum of the wheel."""
    (flat,) = open_runs([files["a"]])
    panels = {panel.label: panel for panel in drop_sheet([flat]).panels}
    assert list(panels) == [
        "load on the absorber", "force of the ground", "load on the tyre", "drag on the axle", "travel",
        "change of energy",
    ]  # fmt: skip
    lift_off = contacts(flat.results.events)[0]
    (axle,), (_, ground) = panels["drag on the axle"].curves, panels["force of the ground"].curves
    t = axle.x.values
    assert t[0] == 0.0 and lift_off - 2e-3 < t[-1] <= lift_off
    velocity = values(flat.results, "axle.velocity")[flat.results.time <= t[-1], 0]
    axle_impulse, ground_impulse = (
        0.5 * (curve.y.values[1:] + curve.y.values[:-1]) @ np.diff(t) for curve in (axle, ground)
    )
    assert axle_impulse == pytest.approx(ground_impulse + 50.0 * (velocity[-1] - velocity[0]), rel=5e-3)
    assert panels["load on the absorber"].note == "efficiency 0.89"
    reported = re.match(r"spin-up (.*) kN at (.*) s, spring-back (.*) kN", panels["drag on the axle"].note)
    found = [float(number) for number in reported.groups()]
    assert found == pytest.approx([86.6, 0.0416, 32.6], rel=5e-3)  # by the step


def test_several_runs_share_the_page(files):
    sheet = drop_sheet(open_runs(files.values()))
    assert sheet.panels[0].note == "efficiency 0.89, 0.88"
    assert {curve.run for panel in sheet.panels for curve in panel.curves} == {0, 1}


def test_plots_of_a_node_show_the_events_of_what_is_on_it(files):
    """Of the wheel on its axle; of everything where nothing happens to what is on the node."""
    runs = open_runs([files["a"]])
    shown = {
        node: {mark.element for mark in requested_sheet(Request.parse(f"{node}.position.z"), runs).events}
        for node in ("axle", "top")
    }
    assert shown == {"axle": {"wheel"}, "top": {"wheel", "absorber"}}

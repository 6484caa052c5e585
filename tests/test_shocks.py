"""Shocks with known answers: latches, stops, cables, contacts, wheels. Rigid ones to 1e-9, times by their order.

Closed forms, and shared/reference/e3_latch_cable.json: momentum-conserving latching and cable snap.
"""

import math

import h5py
import numpy as np
import pytest
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.dynamic import run
from mecano.analyses.load_state import state_at
from mecano.analyses.prepare import integrator_of, prepare
from mecano.errors import AssemblyError
from mecano.results.reader import open_results
from mecano.results.state import load_state, save_state
from mecano.solve.events.complementarity import solve_complementarity
from mecano.solve.time.run_state import from_plain, to_plain

g = 9.81
RODS = """
    mecano: 1
    gravity: [0, 0, 0]
    nodes: {{a: {{position: [0, 0, 0]}}, b: {{position: [1, 0, 0]}}, c: {{position: [1, 0, 0]}}}}
    elements:
      inner: {{type: rigid_body, node: a, mass: 1, center_of_mass: [0.5, 0, 0],
              inertia: [1.0e-4, 0.08333333333333333, 0.08333333333333333], attached: [b]}}
      outer: {{type: rigid_body, node: c, mass: 1, center_of_mass: [0.5, 0, 0],
              inertia: [1.0e-4, 0.08333333333333333, 0.08333333333333333]}}
    joints:
      root: {{type: hinge, nodes: [ground, a], axis: [0, 0, 1]}}
      elbow: {{type: hinge, nodes: [b, c], axis: [0, 0, 1], {ends}}}
    time: {{end: 1, step: 1.0e-3}}
"""


def struck(checked, rates):
    """Return (TimeIntegrator, state before, Shock) of all shocks at the start of a deck, with rates of joints."""
    prepared = prepare(checked)
    integrator, s = integrator_of(prepared), prepared.state
    s.memory = integrator.system.commit(s)
    of, names = integrator.system.numbering, [node.name for node in integrator.system.nodes]
    for name, (velocity, rate) in rates.items():
        i = names.index(name)
        s.v[of.x[i] : of.x[i] + 3], s.v[of.r[i] + 2] = velocity, rate
    s, _ = integrator.method.start(s, 1e-3)
    hit = np.zeros(len(integrator.monitor.values(s)), bool)
    hit[[c.event for c in integrator.shocks.impact_candidates if "upper" not in c.closing.name]] = True
    return integrator, s, integrator.shocks.solve_impact(s, hit)


S, MOMENTUM, SWING = "Shocks", "balance of momentum", "half a swing of the masses on the cable"


def test_two_rods_lock_straight(verify):
    """e3, two_rods_ground_hinge: rates 1 and 4 rad/s become 1.9375; -0.21875 N m s; 0.328125 J."""
    recorded, _, shock = struck(
        deck(RODS.format(ends="latch: {angle: 1}")), {"a": ((0, 0, 0), 1.0), "c": ((0, 1, 0), 4.0)}
    )
    of = recorded.system.numbering
    after = [shock.state.v[of.r[i] + 2] for i in (0, 2)]
    verify(S, "two rods that lock: rates after it [rad/s]", after, 1.9375, MOMENTUM, absolute=1e-12)
    (locked,) = shock.event_records
    assert (locked.name, locked.before, locked.after, locked.unit) == ("locks", "free", "locked", "N m s")
    verify(S, "two rods that lock: impulse [N m s]", locked.impulse, -0.21874999999999994, MOMENTUM, absolute=1e-12)
    verify(S, "two rods that lock: energy lost [J]", locked.lost, 0.3281249999999999, MOMENTUM, absolute=1e-12)


@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
def test_two_rods_meet_a_stop(e, verify):
    """The same with restitution: 1 + e times the impulse, 1 - e^2 of the loss."""
    stops = f"stops: {{lower: -1, restitution: {e}}}"
    recorded, _, shock = struck(deck(RODS.format(ends=stops)), {"a": ((0, 0, 0), 4.0), "c": ((0, 4, 0), 1.0)})
    of = recorded.system.numbering
    rates = [shock.state.v[of.r[i] + 2] for i in (0, 2)]
    assert rates[1] - rates[0] == pytest.approx(3.0 * e, abs=1e-12)
    (met,) = shock.event_records
    impulse = (1 + e) * 0.21875
    verify(S, f"two rods at a stop, e = {e:g}: impulse [N m s]", met.impulse, impulse, MOMENTUM, absolute=1e-12)
    assert met.lost == pytest.approx((1 - e * e) * 0.328125, abs=1e-12)
    assert met.after == ("between" if e else "lower stop")


LOCK_TIME, STATE = 1.0951727303795789, (-2.3137370578593996, 5.090221527290709)
STORED = 1.9985948912205949


def test_spring_driven_elbow_locks():
    """e3, two_rod_spring_elbow_lock: time and rates before converge with h^2; locked joints stand still."""
    errors = []
    for step in (4e-3, 2e-3, 1e-3):
        recorded = RecordedRun(input_deck("deployment_lock", "time.adaptive=null", f"time.step={step}", "time.end=1.2"))
        (locked,) = recorded.event_records
        i = int(np.argmax(recorded.time >= locked.t))
        inner, outer = recorded["joints/root/rate"][i], recorded["joints/elbow/rate"][i]
        errors.append(np.abs([locked.t - LOCK_TIME, inner - STATE[0], inner + outer - STATE[1]]))
        assert np.abs(recorded["joints/elbow/rate"][i + 1 :]).max() < 1e-9
        assert np.abs(recorded["joints/root/rate"][-1]) < 50 * step**2
        assert locked.lost == pytest.approx(STORED, abs=50 * step**2)
        assert recorded.run.dissipated == pytest.approx(locked.lost, abs=1e-12)
    assert errors[0][0] < 1e-4
    for coarse, fine in zip(errors[:-1], errors[1:], strict=True):
        assert coarse / fine == pytest.approx(4.0, abs=0.1)


def test_a_panel_locks_to_the_ground_and_the_file_records_it(tmp_path):
    """e3, spring_deploy_lock: time, impulse and energy; the file has them, and the steps continue as before."""
    checked = input_deck("panel_lock", "output.every=step")
    run(checked, tmp_path / "panel.h5")
    with open_results(tmp_path / "panel.h5") as results:
        (locked,) = results.events
        assert locked.time == pytest.approx(0.641274915080932, abs=1e-6)
        assert abs(locked.impulse) == pytest.approx(1.2825498301618639, rel=1e-5)
        assert locked.impulse_unit == "N m s" and locked.element == "hinge 'hinge'"
        assert locked.energy_lost == pytest.approx(2.4674011002723395, rel=1e-5)
        assert results["energy.dissipated"].values[-1] == pytest.approx(locked.energy_lost, rel=1e-12)
        assert np.ptp(results["energy.balance"].values) < 1e-5 * 2.4674
        assert results["hinge.latched"].values[-1] == 1.0
        after = results.time > locked.time
        assert np.abs(results["hinge.rate"].values[after]).max() < 1e-9
        i = int(np.searchsorted(results.steps["time"], locked.time))
        steps = results.steps["step_size"]
        assert steps[i + 1] >= 0.999 * steps[i - 1]


def test_modes_about_a_saved_time_include_locked_joints(tmp_path):
    """The latch is in the phase of the events, and holds its position; at an earlier saved time it is free."""
    checked = input_deck("deployment_lock", "output.every=0.1")
    run(checked, tmp_path / "rods.h5")
    for time, locked in ((1.0, 0.0), (1.2, 1.0), (1.6, 1.0)):
        prepared = prepare(checked)
        _, state, *_ = state_at(prepared, f"{tmp_path / 'rods.h5'}:{time}")
        (latch,) = (b for b in prepared.system.batches if b.kind.name == "angle_latch")
        assert state.phases[latch.first_phase] == locked
        assert np.abs(prepared.system.constraint_derivatives(state)[:, 0]).max() < 1e-9


@pytest.mark.parametrize("choice", ["hold", "shock"])
def test_two_masses_caught_by_a_cable(choice, verify):
    """e3, cable_snap inextensible: 1.7142857142857142 N s, 1.0285714285714285 J, then together."""
    recorded = RecordedRun(input_deck("cable_catch", f"elements.cable.at_full_length={choice}"))
    (caught,) = recorded.event_records
    assert caught.t == pytest.approx(0.5 / 1.2, abs=1e-12)
    verify(S, f"masses caught by a cable ({choice}): impulse [N s]", caught.impulse, 12 / 7, MOMENTUM, absolute=1e-11)
    assert caught.lost == pytest.approx(1.0285714285714285, abs=1e-11)
    for name in ("first", "second"):
        assert recorded[f"nodes/{name}/velocity"][-1] == pytest.approx([-2.4 / 7, 0.0, 0.0], abs=1e-10)
    assert recorded["energy/balance"] == pytest.approx(1.44, abs=1e-12)


def test_an_elastic_cable_gives_back_what_it_takes(verify):
    """e3, cable_snap two_mass: taut for pi sqrt(m/k), at most 438.178 N, the relative velocity turned round."""
    recorded = RecordedRun(
        input_deck("cable_catch", "elements.cable.at_full_length=stretch", "time.step=1e-4", "time.end=0.5")
    )
    taut, slack = recorded.event_records
    tension = recorded["elements/cable/tension"].max()
    verify(S, "elastic cable: time of contact [s]", slack.t - taut.t, 0.012290865449026021, SWING, relative=1e-3)
    verify(S, "elastic cable: greatest tension [N]", tension, 438.1780460041329, SWING, relative=1e-3)
    velocities = [recorded[f"nodes/{name}/velocity"][-1, 0] for name in ("first", "second")]
    assert velocities == pytest.approx([-1.2 + 2 * 5 / 7 * 1.2, -2 * 2 / 7 * 1.2], rel=5e-5)
    assert all(h.unit == "" and h.impulse == h.lost == 0.0 for h in recorded.event_records)


def test_a_winder_pays_out_and_is_fully_uncoiled():
    """Closed form in the deck, minus the stretch of the cable."""
    recorded = RecordedRun(input_deck("winder"))
    assert [h.name for h in recorded.event_records] == ["goes taut", "pays out", "is fully uncoiled"]
    end = recorded.event_records[-1]
    assert end.t == pytest.approx(2 - math.sqrt(2), abs=1e-7)
    assert end.impulse == pytest.approx(4 * math.sqrt(2), rel=1e-7) and end.lost == pytest.approx(4.0, rel=1e-7)
    assert recorded.run.dissipated == pytest.approx(10.0, rel=1e-6)
    assert recorded["elements/cable/tension"][-1] == pytest.approx(2.0, rel=1e-6)
    assert recorded["elements/cable/state"][-1] == 1.0
    assert recorded["nodes/mass/velocity"][-1] == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert recorded["nodes/mass/position"][-1, 0] == pytest.approx(2.0, abs=1e-7)


def test_a_winder_of_a_heavy_mass_pays_out_at_a_small_strain():
    """All masses and forces a thousand times those of the deck: the same motion, at the same strain of 1e-8."""
    heavier = {"mass.mass": 4e3, "cable.axial_stiffness": 6e11, "cable.payout_tension": 6e3}
    changes = [f"elements.{key}={value}" for key, value in heavier.items()]
    recorded = RecordedRun(input_deck("winder", *changes, "loads.pull.value=2e3"))
    assert [h.name for h in recorded.event_records] == ["goes taut", "pays out", "is fully uncoiled"]
    end = recorded.event_records[-1]
    assert end.t == pytest.approx(2 - math.sqrt(2), abs=1e-7)
    assert end.impulse == pytest.approx(4e3 * math.sqrt(2), rel=1e-7)


def test_a_line_that_holds_keeps_the_energy_of_its_strain():
    """Paid out with 6 N at EA = 200 N it is strained by 0.03, 0.18 J of 2 m; they are dissipated while it shortens."""
    pull = "loads.pull.value={linear: {slope: -4.0, offset: 4.0}}"  # drives the mass back in the end
    recorded = RecordedRun(
        input_deck("winder", "elements.cable.axial_stiffness=200", pull, "time={end: 1.9, step: 2.0e-3}")
    )
    names = [h.name for h in recorded.event_records]
    assert names == ["goes taut", "pays out", "is fully uncoiled", "goes slack"]
    held, slack = (h.t for h in recorded.event_records[2:])
    on = (recorded.time > held + 1e-9) & (recorded.time < slack - 1e-9)
    np.testing.assert_allclose(recorded["energy/potential"][on], 0.5 * 200 * 0.03**2 * 2, rtol=1e-6)
    assert recorded["energy/potential"][-1] == 0.0 and recorded["elements/cable/length"][-1] < 2.0
    assert np.ptp(recorded["energy/balance"][recorded.time > 0.5]) < 1e-6 * recorded["energy/total"][0]


def test_a_damped_line_relaxes_behind_its_full_length():
    """Taut after the shock it throws the mass back; slack with strain left, it is relaxed after its damping time."""
    line = "elements.cable.at_full_length=shock", "elements.cable.axial_stiffness=200", "elements.cable.damping=0.05"
    recorded = RecordedRun(input_deck("winder", *line, "loads.pull.value=0", "time={end: 1.5, step: 2.5 ms}"))
    *_, pays, full, slack, relaxed = recorded.event_records
    half, whole = (
        1.0 * 0.015**2,
        1.015 / 1.03 * 0.03**2,
    )  # the damped tension of half of the strain is that of the winder
    assert pays.lost == pytest.approx(0.5 * 200.0 * (half - whole), rel=1e-6)
    assert np.ptp(recorded["energy/balance"]) < 1e-4  # [J] of 8
    assert [full.name, slack.name, relaxed.name] == ["is fully uncoiled", "goes slack", "is relaxed"]
    assert relaxed.t - slack.t == pytest.approx(0.05, abs=1e-9)


def test_a_winder_that_is_too_strong_holds():
    """A pull of 2 N does not move a brake of 6 N: the cable stretches, and the mass oscillates on it."""
    recorded = RecordedRun(
        input_deck("winder", "initial.velocities=[]", "elements.cable.axial_stiffness=1e3", "time.end=2")
    )
    assert {h.name for h in recorded.event_records} <= {"goes taut", "goes slack"}
    assert recorded["nodes/mass/position"][:, 0].max() == pytest.approx(1.0 + 2 * 2.0 / 1e3, abs=2e-5)


def test_a_bouncing_ball_comes_to_rest(verify):
    """Flights of 2 v e^n/g end at sqrt(2 h/g) (1 + e)/(1 - e); what the rest speed leaves out is 2 v/g."""
    recorded = RecordedRun(input_deck("bouncing_ball"))
    e, v = 0.8, math.sqrt(2 * g)
    touches = np.array([h.t for h in recorded.event_records])
    n = np.arange(20)
    exact = v / g + 2 * v * e / g * (1 - e**n) / (1 - e)
    verify(S, "bouncing ball: times of 20 bounces [s]", touches[:20], exact, "flights in closed form", absolute=1e-9)
    assert {h.name for h in recorded.event_records} == {"touches"}
    assert [h.after for h in recorded.event_records] == ["air"] * (len(touches) - 1) + ["contact"]
    assert 0.0 < math.sqrt(2 / g) * (1 + e) / (1 - e) - touches[-1] < 2e-4 / (g * (1 - e))
    assert recorded["nodes/ball/position"][-1, 2] == pytest.approx(0.0, abs=1e-8)
    assert recorded["elements/contact/normal_force"][-1] == pytest.approx(2 * g, rel=1e-9)
    assert recorded.run.dissipated == pytest.approx(2 * g, rel=1e-9)
    assert np.abs(recorded["energy/balance"] / (2 * g) - 1).max() < 1e-9


def test_a_ball_comes_to_rest_in_long_steps():
    """Rebounds soon follow one another within a thousandth of a step, which no rest speed of the deck foresees."""
    recorded = RecordedRun(input_deck("bouncing_ball", "time.step=0.5", "time.rest_speed=1e-9"))
    assert recorded.event_records[-1].after == "contact"
    assert abs(math.sqrt(2 / g) * (1 + 0.8) / (1 - 0.8) - recorded.event_records[-1].t) < 0.01 * 0.5
    assert recorded.run.dissipated == pytest.approx(2 * g, rel=1e-9)


def test_a_pendulum_rebounds_from_a_stop(verify):
    """Closed form in the deck; it rises to the angle with a quarter of the height."""
    recorded = RecordedRun(input_deck("pendulum_stop", "time.step=5e-4"))
    met = recorded.event_records[0]
    assert met.t == pytest.approx(0.59196049, abs=1e-6)
    impulse = 1.5 * 0.75 * math.sqrt(3 * g / 1.5)
    verify(S, "pendulum at a stop: impulse [N m s]", met.impulse, impulse, MOMENTUM, relative=1e-6)
    assert met.lost == pytest.approx(0.75 * g * 0.75, rel=1e-6)
    after = recorded.time > met.t
    assert recorded["joints/hinge/angle"][after].min() == pytest.approx(math.pi / 2 - math.acos(0.75), abs=1e-5)


LETTING_GO = """
    mecano: 1
    gravity: [0, 0, -10]
    nodes: {ball: {position: [0, 0, 0.0]}}
    elements:
      ball: {type: point_mass, node: ball, mass: 2}
      contact: {type: plane_contact, node: ball, ground: floor}
    grounds: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
    loads: {lift: {type: force, node: ball, direction: [0, 0, 1], value: {linear: {slope: 40, offset: 0}}}}
    time: {end: 1, step: 1.0e-2}
"""


def test_a_contact_opens_where_its_force_falls_to_zero():
    """A pull of 40 N/s lifts 20 N after 0.5 s; z = (40/2) (t - 0.5)^3/6 from then on."""
    recorded = RecordedRun(deck(LETTING_GO))
    assert [h.name for h in recorded.event_records] == ["touches", "lifts off"]
    assert recorded.event_records[1].t == pytest.approx(0.5, abs=1e-9)
    closed = recorded.time < 0.499
    assert recorded["elements/contact/normal_force"][closed] == pytest.approx(20 - 40 * recorded.time[closed])
    assert recorded["nodes/ball/position"][-1, 2] == pytest.approx(20 * 0.5**3 / 6, rel=2e-3)


PILE = """
    mecano: 1
    gravity: [0, 0, -10]
    nodes: {low: {position: [0, 0, 0.125]}, middle: {position: [0, 0, 0.375]}, high: {position: [0, 0, HEIGHT]}}
    elements:
      low: {type: rigid_body, node: low, mass: 1, inertia: [1, 1, 1]}
      middle: {type: rigid_body, node: middle, mass: 2, inertia: [1, 1, 1]}
      high: {type: rigid_body, node: high, mass: 3, inertia: [1, 1, 1]}
      on_floor: {type: plane_contact, node: low, ground: floor, radius: 0.125}
      on_low: {type: contact, nodes: [low, middle], sphere: {radius: 0.125}, radius: 0.125}
      on_middle: {type: contact, nodes: [middle, high], sphere: {radius: 0.125}, radius: 0.125}
    grounds: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
    MORE
    time: {end: 0.02, step: 1.0e-3}
"""


@pytest.mark.parametrize(
    ("height", "gravity", "weights"),
    [(0.625, -10, (60, 50, 30)), (0.75, -10, (30, 20, 0)), (0.625, 0, (0, 0, 0)), (0.625, 10, (0, 0, 0))],
)
def test_a_pile_rests_from_the_start(height, gravity, weights):
    """The first row has the weights above each contact; without gravity, or pulled up, nothing presses."""
    text = PILE.replace("HEIGHT", str(height)).replace("-10", str(gravity)).replace("MORE", "")
    recorded = RecordedRun(deck(text))
    for name, weight in zip(("on_floor", "on_low", "on_middle"), weights, strict=True):
        assert recorded[f"elements/{name}/normal_force"][[0, -1]] == pytest.approx(weight, abs=1e-9)
        assert recorded[f"elements/{name}/closed"][0] == (weight > 0)
    assert all((event.t, event.impulse, event.lost) == (0, 0, 0) for event in recorded.event_records)


@pytest.mark.parametrize("gap", [-1e-10, -1.2e-16, 0.0, 1.2e-16, 1e-10])
def test_touching_bodies_separate_from_the_start(gap):
    """The uppermost ball of a pile without weight moves up; the others do not follow, however rounding falls."""
    more = "initial: {velocities: [{nodes: [high], velocity: [0, 0, 1]}]}"
    text = PILE.replace("HEIGHT", repr(0.625 + gap)).replace("-10", "0").replace("MORE", more)
    recorded = RecordedRun(deck(text))
    assert not recorded.event_records
    for node, speed in (("low", 0.0), ("middle", 0.0), ("high", 1.0)):
        assert recorded[f"nodes/{node}/velocity"][:, 2] == pytest.approx(speed, abs=1e-12)


def test_a_shock_at_the_start_is_recorded_behind_the_state_before_it():
    """The lowest of three balls in a pile moves down with 1 m/s: its momentum 1 N s is that of the first impulse."""
    more = "initial: {velocities: [{nodes: [low], velocity: [0, 0, -1]}]}"
    recorded = RecordedRun(deck(PILE.replace("HEIGHT", "0.625").replace("MORE", more)))
    assert recorded["elements/on_floor/closed"][0] == 0
    assert recorded["nodes/low/velocity"][0, 2] == -1
    met = recorded.event_records[0]
    assert (met.element, met.t) == ("plane_contact 'on_floor'", 0)
    assert (met.impulse, met.lost) == pytest.approx((1, 0.5))
    assert recorded["elements/on_floor/normal_force"][-1] == pytest.approx(60, rel=1e-6)


BEAM_ON_TWO = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {{m: {{position: [0, 0, 1]}}, l: {{position: [-0.5, 0, 1]}}, r: {{position: [0.5, 0, 1]}}{more}}}
    elements:
      bar: {{type: rigid_body, node: m, mass: 2, inertia: [{J}, {J}, {J}], attached: [{feet}]}}
      left: {{type: plane_contact, node: l, ground: floor, restitution: {e}}}
      right: {{type: plane_contact, node: r, ground: floor, restitution: {e}}}
      {contacts}
    grounds: {{floor: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
    time: {{end: {end}, step: 1.0e-2}}
"""


def bar(J=0.1, e=0.5, end=1.5, four=False):
    more = ", f: {position: [0, 0.4, 1]}, b: {position: [0, -0.4, 1]}" if four else ""
    contact = "{}: {{type: plane_contact, node: {}, ground: floor, restitution: {}}}"
    contacts = [contact.format(name, name[0], e) for name in ("front", "back")]
    return deck(BEAM_ON_TWO.format(
        more=more, J=J, e=e, end=end, feet="l, r, f, b" if four else "l, r",
        contacts="\n      ".join(contacts) if four else "",
    ))  # fmt: skip


@pytest.mark.parametrize("four", [False, True], ids=["two feet", "four feet"])
def test_equal_feet_meet_together_and_push_equally(four):
    """Two feet, or four, of which one is too many: always together, equal impulses, no turning."""
    recorded = RecordedRun(bar(four=four))
    n = 4 if four else 2
    assert len(recorded.event_records) % n == 0 and len(recorded.event_records) >= 10 * n
    for i in range(0, len(recorded.event_records), n):
        group = recorded.event_records[i : i + n]
        assert len({h.t for h in group}) == 1 and len({h.element for h in group}) == n
        assert [h.impulse for h in group] == pytest.approx([group[0].impulse] * n, rel=1e-9)
    assert np.abs(recorded["nodes/m/angular_velocity"]).max() < 1e-9
    assert recorded.run.dissipated == pytest.approx(2 * g, rel=1e-6)
    assert len(recorded.integrator.warnings) == (1 if four else 0)
    feet = [recorded[f"elements/{name}/normal_force"][-1] for name in ("left", "right", "front", "back")[:n]]
    assert feet == pytest.approx([2 * g / n] * n, rel=1e-6)


def test_a_rocking_bar_lifts_its_other_foot():
    """One foot rests, the other comes down: with J > m a^2 the resting one would have to be pulled, so it lifts.

    An impulse under the right foot, a = 0.5 m from the middle, moves the left one by 1/m - a^2/J times it.
    """
    for J, lifts in ((0.8, True), (0.3, False)):
        prepared = prepare(bar(J=J, e=0.0))
        integrator, s = integrator_of(prepared), prepared.state
        s.memory = integrator.system.commit(s)
        left, right = integrator.shocks.impact_candidates
        s = integrator.shocks.impact_candidates.in_phase(s, [left], "after")
        of = integrator.system.numbering
        s.v[of.x[0] + 2], s.v[of.r[0] + 1] = -0.5, 1.0  # about y: the left foot at rest, the right one at -1 m/s
        s, _ = integrator.method.start(s, 1e-3)
        hit = np.zeros(4, bool)
        hit[right.event] = True
        shock = integrator.shocks.solve_impact(s, hit)
        names = [(h.name, h.element.split("'")[1]) for h in shock.event_records]
        assert names == [("touches", "right")] + ([("lifts off", "left")] if lifts else [])
        alone = 1.0 / (1 / 2 + 0.25 / J)  # impulse that stops the right foot alone, from -1 m/s
        expected = [0.0, alone] if lifts else None
        impulses = shock.impulses[[left.lead, right.lead]]
        if lifts:
            assert impulses == pytest.approx(expected, abs=1e-12)
        else:
            assert impulses.min() > 0.0
            assert np.abs(shock.state.v[of.x[0] + 2]) < 1e-14 and abs(shock.state.v[of.r[0] + 1]) < 1e-14


WHEEL = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {hub: {position: [0, 0, 0.3]}}
    elements:
      disc: {type: rigid_body, node: hub, mass: 10, inertia: [0.3, 0.5, 0.3]}
      wheel: {type: rigid_wheel, node: hub, axis: [0, 1, 0], radius: 0.3, ground: road, unilateral: true}
    grounds: {road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
    time: {end: 0.3, step: 1.0e-3}
"""


def test_a_rigid_wheel_that_touches_down():
    """A disc that does not turn, at 10 m/s and 2 m/s down: v keeps m/(m + J/r^2), by the friction that turns it."""
    prepared = prepare(deck(WHEEL))
    integrator, s = integrator_of(prepared), prepared.state
    (candidate,) = integrator.shocks.impact_candidates
    s = integrator.shocks.impact_candidates.in_phase(s, [candidate], "before")
    s.v[:3] = 10.0, 0.0, -2.0
    s, _ = integrator.method.start(s, 1e-3)
    shock = integrator.shocks.solve_impact(s, np.array([True, False, False]))
    (down,) = shock.event_records
    v = 10 * 10 / (10 + 0.5 / 0.09)
    assert shock.state.v[:6] == pytest.approx([v, 0.0, 0.0, 0.0, v / 0.3, 0.0], abs=1e-12)
    assert (down.name, down.after, down.unit) == ("touch_down", "contact", "N s")
    assert down.impulse == pytest.approx(20.0, abs=1e-12)
    assert down.lost == pytest.approx(0.5 * 10 * 104 - 0.5 * (10 + 0.5 / 0.09) * v * v, abs=1e-10)


def test_a_rigid_wheel_dropped_from_the_air_falls_and_is_caught():
    """From 0.2 m, at 2 m/s without turning: v_z = sqrt(2 g h), and the slip is gone with 1/m = 1/10 + 0.3^2/0.5."""
    recorded = RecordedRun(
        deck(WHEEL.replace("0, 0.3]", "0, 0.5]") + "    initial: {velocities: [{nodes: [hub], velocity: [2, 0, 0]}]}\n")
    )
    assert recorded.prepared.displacement == 0.0 and recorded["nodes/hub/position"][0, 2] == 0.5
    assert recorded["nodes/hub/velocity"][0] == pytest.approx([2.0, 0.0, 0.0], abs=1e-15)
    (down,) = recorded.event_records
    assert down.t == pytest.approx(math.sqrt(0.4 / g), abs=1e-9)
    assert down.impulse == pytest.approx(10 * math.sqrt(0.4 * g), rel=1e-9)
    assert down.lost == pytest.approx(10 * g * 0.2 + 0.5 * 4 / (1 / 10 + 0.09 / 0.5), rel=1e-9)
    assert np.ptp(recorded["energy/balance"]) < 1e-9
    assert recorded["nodes/hub/position"][-1, 2] == pytest.approx(0.3, abs=1e-12)


def test_a_rigid_wheel_over_a_bump_keeps_the_balance():
    """It leaves the ground and lands again: the balance includes the energy lost in the shocks."""
    bump = "profile: {direction: [1, 0, 0], height: {bump: {start: 0.5, length: 2.0, height: 0.2}}}"
    rolling = "{nodes: [hub], velocity: [4, 0, 0], angular_velocity: [0, 13.333333333333334, 0]}"
    text = WHEEL.replace("normal: [0, 0, 1]}}", f"normal: [0, 0, 1]}}, {bump}}}").replace("end: 0.3", "end: 0.7")
    recorded = RecordedRun(deck(f"{text}    initial: {{velocities: [{rolling}]}}\n"))
    assert [h.name for h in recorded.event_records][:3] == ["bend", "lift_off", "touch_down"]
    lost = sum(h.lost for h in recorded.event_records)
    assert lost > 0.05
    assert recorded.run.dissipated == pytest.approx(lost, rel=1e-12)
    assert np.ptp(recorded["energy/balance"]) < 0.05 * lost


DRIVEN = """
    mecano: 1
    gravity: [0, 0, 0]
    nodes: {arm: {position: [0, 0, 0]}, tip: {position: [1, 0, 0]}, load: {position: [3, 0, 0]}}
    elements:
      arm: {type: rigid_body, node: arm, mass: 1, inertia: [1, 1, 1], attached: [tip]}
      load: {type: point_mass, node: load, mass: 2}
      rope: {type: cable, nodes: [tip, load], axial_stiffness: 1, natural_length: 2.5, at_full_length: hold}
    joints:
      hinge: {type: hinge, nodes: [ground, arm], axis: [0, 0, 1]}
      motor: {type: prescribed_angle, nodes: [ground, arm], axis: [0, 0, 1], value: {linear: {slope: 3, offset: 0}}}
    time: {end: 0.35, step: 1.0e-3}
"""


def test_prescribed_motion_gives_work_in_a_shock():
    """The motor keeps 3 rad/s when the rope becomes taut: the work of the shock counts as given energy."""
    recorded = RecordedRun(deck(DRIVEN))
    (caught,) = recorded.event_records
    assert caught.impulse > 0.0
    i = int(np.argmax(recorded.time >= caught.t))
    assert recorded["joints/hinge/rate"] == pytest.approx(3.0, abs=1e-8)
    given, lost = np.diff(recorded["energy/given"][i : i + 2])[0], caught.lost
    assert given == pytest.approx(2 * lost, rel=0.01)  # from rest to w by an e = 0 shock: half of the work is lost
    assert np.ptp(recorded["energy/balance"]) < 1e-3 * lost


def test_redundant_locks_are_solved_and_reported():
    """A door on two hinges, each with a latch: one is too many; each takes half; I w = 4.5 2."""
    text = """
        mecano: 1
        gravity: [0, 0, 0]
        nodes: {low: {position: [0, 0, 0]}, top: {position: [0, 0, 2]}}
        elements:
          door: {type: rigid_body, node: low, mass: 10, center_of_mass: [0.5, 0, 1], inertia: [1, 1, 2],
                 attached: [top]}
        joints:
          a: {type: hinge, nodes: [ground, low], axis: [0, 0, 1], latch: {angle: 1.2}}
          b: {type: hinge, nodes: [ground, top], axis: [0, 0, 1], latch: {angle: 1.2}}
        initial: {velocities: [{nodes: all, about: [0, 0, 0], angular_velocity: [0, 0, 2]}]}
        time: {end: 1, step: 1.0e-2}
    """
    recorded = RecordedRun(deck(text))
    assert [h.impulse for h in recorded.event_records] == pytest.approx([-4.5, -4.5], rel=1e-9)
    assert recorded.run.dissipated == pytest.approx(9.0, rel=1e-9)
    assert np.abs(recorded["nodes/low/angular_velocity"][-1]).max() < 1e-9
    (remark,) = recorded.integrator.warnings
    assert "1 constraint(s) are redundant among: hinge 'a', 'b': moment of the latch" in remark


@pytest.mark.parametrize("name, times", [("bouncing_ball", (0.4, 1.0, 4.06)), ("deployment_lock", (1.09, 1.1))])
def test_a_resumed_run_has_the_same_bits_across_shocks(name, times, tmp_path):
    """Saved before, between and after shocks."""
    checked = input_deck(name, "time.end=4.2" if name == "bouncing_ball" else "time.end=1.2")
    end = checked.values["time"]["end"]
    for t in times:
        prepared = prepare(checked)
        integrator = integrator_of(prepared)
        middle = integrator.to(t, integrator.begin(prepared.state, checked.values["time"]["step"]))
        whole = integrator.to(end, middle)
        with h5py.File(tmp_path / f"{t}.h5", "w") as file:
            save_state(file, "middle", to_plain(middle))
            loaded = from_plain(load_state(file["middle"]))
        other = integrator_of(prepare(checked)).to(end, loaded)
        assert np.array_equal(other.motion.v, whole.motion.v) and other.dissipated == whole.dissipated


def test_a_damped_cable_that_goes_slack_beyond_its_full_length_stays_slack():
    """Its tension, of strain and rate, falls to zero while it is longer: pushed on, it has one shock and no other."""
    recorded = RecordedRun(deck("""
    mecano: 1
    gravity: none
    nodes: {top: {position: [0, 0, 0], fixed: true}, m: {position: [0, 0, -0.99]}}
    elements:
      mass: {type: point_mass, node: m, mass: 1}
      rope:
        {type: cable, nodes: [top, m], axial_stiffness: 1000, natural_length: 1, damping: 0.05, at_full_length: shock}
    loads:
      pull: {type: force, node: m, direction: [0, 0, 1], value: {step: {time: 0.5, rise: 0.01, from: -10, to: 30}}}
    time: {end: 0.6, step: 1 ms}
    output: {every: step}
    """))  # fmt: skip
    taut, slack, *relaxed = recorded.event_records
    assert (taut.name, slack.name) == ("becomes taut at full length", "goes slack")
    assert [event.name for event in relaxed] == ["is relaxed"]
    assert taut.impulse == pytest.approx(np.sqrt(2 * 10 * 0.01), rel=1e-9)  # the momentum after 10 mm under 10 N
    row = np.argmin(np.abs(recorded.time - slack.t))
    strain, rate = (recorded[f"elements/rope/{name}"][row] for name in ("strain", "strain_rate"))
    assert strain > 1e-3 and abs(strain + 0.05 * rate) < 1e-9


PUSHED = """
    mecano: 1
    gravity: [0, 0, 0]
    nodes: {{a: {{position: [0, 0, 0]}}, m: {{position: [{apart}, 0, 0]}}, b: {{position: [{far}, 0, 0]}}}}
    elements:
      A: {{type: rigid_body, node: a, mass: 2, inertia: [1, 1, 1]}}
      B: {{type: point_mass, node: b, mass: 3}}
      spring: {{type: spring_damper, nodes: [m, b], law: {{spring: {{stiffness: 1000}}}}, natural_length: 1}}
      {cable}
    joints: {{{joint}}}
    initial: {{velocities: [{{nodes: [a], velocity: [-1, 0, 0]}}, {{nodes: [b, m], velocity: [0.5, 0, 0]}}]}}
    time: {{end: 0.15, step: 1.0e-3}}
"""


@pytest.mark.parametrize(
    "apart, cable, joint",
    [
        (
            1,
            "rope: {type: cable, nodes: [a, m], axial_stiffness: 1.0e5, natural_length: 1.1, at_full_length: shock}",
            "",
        ),
        (
            1,
            "rope: {type: cable, nodes: [a, m], axial_stiffness: 1.0e5, natural_length: 1.1, at_full_length: hold}",
            "",
        ),
        (0, "", "slide: {type: prismatic, nodes: [a, m], axis: [1, 0, 0], stops: {upper: 0.1, restitution: 0.5}}"),
    ],
    ids=["shock", "hold", "stop"],
)
def test_massless_nodes_take_no_impulse(apart, cable, joint):
    """The limit of a small mass m between 2 and 3 kg: no impulse, no loss, momentum stays -0.5 N s."""
    recorded = RecordedRun(deck(PUSHED.format(apart=apart, far=apart + 1, cable=cable, joint=joint)))
    (shock,) = recorded.event_records
    assert abs(shock.t - 0.1 / 1.5) < 1e-9 and shock.impulse == 0.0 and shock.lost == 0.0
    momentum = 2.0 * recorded["nodes/a/velocity"][:, 0] + 3.0 * recorded["nodes/b/velocity"][:, 0]
    assert np.abs(momentum + 0.5).max() < 1e-12
    assert recorded["nodes/a/velocity"][-1, 0] > -0.99  # the spring brakes it from then on


def test_complementarity():
    """Random problems, some with contacts that repeat one another: conditions to rounding; equals push equally.

    Neither a guess, right or wrong, nor the order of the contacts changes their shares.
    """
    rng = np.random.default_rng(3)
    for n in (1, 2, 5, 20):
        for rank in (n, max(1, n // 2)):
            B = rng.normal(size=(n, rank)) * np.exp(rng.normal(size=(n, 1)))
            W, b = B @ B.T, B @ rng.normal(size=rank)
            x = solve_complementarity(W, b)
            z = W @ x + b
            scale = np.abs(b).max()
            assert x.min() >= 0.0 and z.min() >= -1e-9 * scale
            assert abs(x @ z) <= 1e-9 * scale * max(x.max(), 1e-300)
            for guess in (x > 0.0, x == 0.0, rng.random(n) < 0.5):
                again = solve_complementarity(W, b, guess=guess)
                np.testing.assert_allclose(again, x, rtol=0, atol=1e-9 * x.max())
            order = rng.permutation(n)
            again = solve_complementarity(W[np.ix_(order, order)], b[order])
            np.testing.assert_allclose(again, x[order], rtol=0, atol=1e-9 * x.max())
    assert solve_complementarity(np.ones((3, 3)), -np.ones(3)) == pytest.approx([1 / 3] * 3, rel=1e-9)
    apart = np.pad(np.ones((3, 3)), (0, 1))
    apart[3, 3] = 1.0  # the response of a body without a load beside one on three feet
    assert solve_complementarity(apart, np.array([-1.0, -1.0, -1.0, 1.0])) == pytest.approx([1 / 3] * 3 + [0.0])
    assert not solve_complementarity(np.eye(2), np.ones(2)).any()
    for wrong in (2.0, np.nan):
        with pytest.raises(AssemblyError, match="too near a singular position"):
            solve_complementarity(np.array([[1.0, wrong], [wrong, 1.0]]), np.array([-1.0, 1.0]))


CARTS = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}, b: {position: [0, 0, 0]}, c: {position: [0, 0, 0]}}
    elements:
      a: {type: point_mass, node: a, mass: 1}
      b: {type: point_mass, node: b, mass: 1}
      c: {type: point_mass, node: c, mass: 1}
    joints:
      a: {type: prismatic, nodes: [ground, a], axis: [1, 0, 0], stops: {upper: 1, restitution: 0.5}}
      b: {type: prismatic, nodes: [ground, b], axis: [1, 0, 0], stops: {upper: 2, restitution: 0.8}}
      c: {type: prismatic, nodes: [ground, c], axis: [1, 0, 0]MORE}
      COUPLER
    initial: {velocities: [{nodes: [a], velocity: [1, 0, 0]}, {nodes: [b], velocity: [2, 0, 0]},
                           {nodes: [c], velocity: [SPEED, 0, 0]}]}
    time: {end: 1.5, step: 0.02}
"""


@pytest.mark.parametrize(
    ("more", "coupler", "speed", "after"),
    [
        ("", "", 3, [-0.5, -1.6, 3.0]),
        (", latch: {displacement: 3}", "", 3, [-0.5, -1.6, 0.0]),
        ("", "both: {type: coupler, displacements: [a, b], factors: [2, -1]}", 3, [-0.5, -1.0, 3.0]),
        (
            ", latch: {displacement: 3}",
            "both: {type: coupler, displacements: [c, b], factors: [2, -3]}",
            3,
            [-0.5, 0.0, 0.0],
        ),
    ],
    ids=["apart", "with a latch apart", "coupled", "coupled to a latch"],
)
def test_carts_that_are_not_connected_keep_their_restitutions(more, coupler, speed, after):
    """At one instant: each stop has its own coefficient, connected ones the least, 0 with a latch."""
    text = CARTS.replace("MORE", more).replace("COUPLER", coupler).replace("SPEED", str(speed))
    m = RecordedRun(deck(text))
    np.testing.assert_allclose([event.t for event in m.event_records], 1.0, atol=1e-9)
    np.testing.assert_allclose([m[f"nodes/{name}/velocity"][-1, 0] for name in "abc"], after, rtol=1e-9, atol=1e-9)


HAMMER = """
mecano: 1
gravity: none
nodes: {pin: {position: [0, 0, 0]}, tip: {position: [1, 0, 0]}}
elements:
  bar: {type: rigid_body, node: pin, mass: 1, center_of_mass: [0.5, 0, 0], inertia: [1e-4, INERTIA], attached: [tip]}
  anvil: {type: plane_contact, node: tip, ground: anvil, restitution: 0.5}
grounds: {anvil: {plane: {normal: [0, 0, 1], point: [0, 0, -0.1]}}}
joints:
  pin: {type: hinge, nodes: [ground, pin], axis: [0, 1, 0], FRICTION}
initial: {velocities: [{nodes: [pin, tip], angular_velocity: [0, 2, 0], about: [0, 0, 0]}]}
time: {end: 0.06, step: 1 ms}
""".replace("INERTIA", f"{1 / 12}, {1 / 12}")
RUBS = "friction: {coefficient: 0.3, radius: 0.01, regularization: 1e-4}"


def test_the_friction_of_a_joint_that_a_shock_leaves_out_is_reported():
    """A thin bar meets an anvil at an angle a: the pin carries P/2 cos(a) across it and P sin(a) along it, of P."""
    recorded = RecordedRun(deck(HAMMER.replace("FRICTION", RUBS)))
    (event,), a = recorded.event_records, np.arcsin(0.1)
    reaction = event.impulse * np.hypot(0.5 * np.cos(a), np.sin(a))
    (said,) = recorded.integrator.warnings
    assert said.startswith("the friction of hinge 'pin' has no impulse in shocks: at t = 0.05")
    assert float(said.split("brake it by ")[1].split(" N m s")[0]) == pytest.approx(0.3 * 0.01 * reaction, rel=5e-3)
    without = RecordedRun(deck(HAMMER.replace(", FRICTION", "")))
    assert not without.integrator.warnings

    def resumed(integrator, run):
        integrator.from_plain(recorded.integrator.to_plain())
        return run

    again = RecordedRun(deck(HAMMER.replace("FRICTION", RUBS)), change=resumed)  # a joint is named once in a run
    assert again.event_records and again.integrator.warnings == [said]

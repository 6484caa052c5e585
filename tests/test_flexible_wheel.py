"""The wheel whose patch deforms laterally and in torsion: shimmy, relaxation, touch-down; roads and brakes.

Reference: a trailing wheel with Moreland's tyre, characteristic polynomial
(I s^2 + c s + k)[C1 s^2 + (1 + V C D) s + V C K] + L (K + D s)(V + L s)(1 + C1 s); roots found a second way to 1e-9.
"""

import numpy as np
import pytest
from small_motions import eigenvalues
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.initial_state import set_initial_state
from mecano.analyses.prepare import prepare
from mecano.analyses.static import run as static_run
from mecano.elements.wheels.flexible_wheel import FLEXIBLE_WHEEL
from mecano.elements.wheels.lateral_law import FORMS, check_forms, check_lateral, matrices, twists
from mecano.errors import ConvergenceError
from mecano.laws.probe import curve_at
from mecano.results.reader import open_results

# (c, k, D, C1): speed -> eigenvalues with positive or no imaginary part; I = 1, L = 0.1, K = 2e5, C = 1/6e4
UNDAMPED = (
    (0.0, 0.0, 0.0, 0.0),
    {
        1.0: [-9.700433047915645, 3.1835498572911582 + 45.2949073825838j],
        20.0: [-92.10422194845353, 12.718777640893416 + 64.66172695514139j],
        80.0: [-279.9392779163, 6.636305624816851 + 75.30926010086841j],
    },
)
DAMPED = (
    (20.0, 0.0, 0.0, 0.0),
    {
        1.0: [-10.350423679338075, -6.491454826997639 + 43.475844619584954j],
        20.0: [-95.57801859820677, 4.455675965770043 + 64.53843541386249j],
        80.0: [-280.8407513207005, -2.9129576729830413 + 75.4234285088978j],
    },
)
MORELAND = (
    (4.0, 50000.0, 0.0, 0.001),
    {
        1.0: [-996.6618613422507, -3.601335116943836, -1.8684017704026559 + 228.0410971577739j],
        40.0: [-841.8357905390401, -165.95183211876565, 1.8938113289024443 + 231.17671652377732j],
        80.0: [-503.6245817100345 + 130.9767769489729j, 1.624581710034514 + 234.82782870661936j],
    },
)


def caster(V, c=20.0, k=0.0, D=0.0, C1=0.0, kind="adhesive_wheel", eps=0.01, kap=1.0e4):
    """Overrides of caster_shimmy.yaml for straight running at V [m/s]."""
    law = f"{{spring: {{stiffness: {k}}}, damper: {{coefficient: {c}}}}}"
    constants = (
        f"lateral_stiffness: 2.0e5, yaw_coefficient: {1 / 6e4!r}, lateral_damping: {D}, yaw_time: {C1}, "
        f"torsional_stiffness: {kap}"
    )
    return (
        f"parameters.speed={V!r}",
        f"elements.damper.law={law}", f"elements.tire.type={kind}", f"tire_laws.rubber.slip_regularization={eps!r}",
        f"tire_laws.rubber.lateral={{moreland: {{{constants}}}}}",
    )  # fmt: skip


def shimmy(*arguments, **values):
    """Eigenvalues of small motions, those with negative imaginary part and free motions left out."""
    found = eigenvalues(input_deck("caster_shimmy", *caster(*arguments, **values)), largest=1e4)
    return found[(found.imag > -1e-9) & (abs(found) > 1e-6)]


@pytest.mark.parametrize("case", [UNDAMPED, DAMPED, MORELAND], ids=["undamped", "damped", "moreland"])
def test_eigenvalues_of_the_trailing_wheel(case):
    (c, k, D, C1), table = case
    for V, expected in table.items():
        found = np.sort_complex(shimmy(V, c, k, D, C1))
        np.testing.assert_allclose(found, np.sort_complex(np.array(expected, complex)), rtol=1e-8)


def test_torsional_stiffness_does_not_matter_in_free_rolling():
    for kap in (1e3, 1e5):
        found = shimmy(20.0, 4.0, 5e4, 300.0, 1e-3, kap=kap)
        I, L, K, D, C, C1, V = 1.0, 0.1, 2e5, 300.0, 1 / 6e4, 1e-3, 20.0
        left = np.polymul([I, 4.0, 5e4], [C1, 1 + V * C * D, V * C * K])
        right = L * np.polymul(np.polymul([D, K], [L, V]), [C1, 1.0])
        roots = np.roots(np.polyadd(left, right))
        np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(roots[roots.imag > -1e-9]), rtol=1e-8)


def test_creep_shifts_the_eigenvalues_as_the_regularization():
    exact = 4.455675965770043 + 64.53843541386249j
    shifts = [abs(shimmy(20.0, kind="flexible_wheel", eps=eps)[-2:] - exact).min() for eps in (1e-1, 1e-2, 1e-3)]
    assert shifts[0] / shifts[1] == pytest.approx(10.0, rel=0.02)
    assert shifts[1] / shifts[2] == pytest.approx(10.0, rel=0.02)


@pytest.mark.parametrize("kind", ["adhesive_wheel", "flexible_wheel"])
def test_growth_of_shimmy_in_time(kind):
    """Growth rate and frequency of a small oscillation, to 1 percent."""
    recorded = RecordedRun(input_deck("caster_shimmy", f"elements.tire.type={kind}", "time.step=5e-4", "time.end=0.6",
                             "tire_laws.rubber.slip_regularization=1e-4"))  # fmt: skip
    angle = recorded["joints/caster/angle"]
    peaks = [i for i in range(1, len(angle) - 1) if angle[i - 1] < angle[i] >= angle[i + 1] and recorded.time[i] > 0.1]
    rate = np.polyfit(recorded.time[peaks], np.log(angle[peaks]), 1)[0]
    assert rate == pytest.approx(4.455675965770043, rel=0.01)
    assert 2 * np.pi / np.diff(recorded.time[peaks]).mean() == pytest.approx(64.538, rel=0.01)


def test_the_lateral_force_builds_up_over_the_relaxation_length():
    recorded = RecordedRun(input_deck("step_steer", "tire_laws.rubber.slip_regularization=1e-3"))
    force = recorded["elements/tire/tire_force"]
    expected = 6e4 * 0.02 * (1 - np.exp(-10.0 * recorded.time / 0.3))
    assert np.abs(np.abs(force) - expected).max() < 5e-3 * 1200.0
    assert np.abs(force[-1]) == pytest.approx(expected[-1], rel=2e-3)
    assert np.ptp(recorded["energy/balance"]) < 1e-4 * recorded["energy/kinetic"][0]


def test_error_control_takes_a_law_without_a_rate_of_psi():
    """C1 = 0: psi = C F from the start on, rates included; the steps are those of the motion, not of a start-up."""
    adaptive = "time.adaptive={tolerance: 1e-5}", "tire_laws.rubber.slip_regularization=1e-3"
    recorded = RecordedRun(input_deck("step_steer", *adaptive))
    force = recorded["elements/tire/tire_force"]
    expected = 6e4 * 0.02 * (1 - np.exp(-10.0 * recorded.time / 0.3))
    assert len(recorded.time) < 300
    assert np.abs(np.abs(force) - expected).max() < 2e-3 * 1200.0
    np.testing.assert_allclose(recorded["elements/tire/psi"], force / 6e4, rtol=1e-9, atol=1e-8)
    assert recorded["elements/tire/psi_rate"][0] == pytest.approx(-10.0 * 0.02 / 0.3, rel=1e-3)


DROP = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      hub: {{position: [0, 0, 0.33]}}
    elements:
      rim: {{type: rigid_body, node: hub, mass: 20.0, inertia: [0.6, 1.0, 0.6]}}
      tire: {{type: {kind}, node: hub, axis: [0, 1, 0], tire_law: rubber, ground: road}}
    tire_laws:
      rubber:
        radius: 0.3
        radial: {{polynomial: {{coefficients: [0, 2.0e5, 5.0e5]}}}}
        friction: {{exponential: {{start: 0.8, limit: 0.4, rate: 0.05}}}}
        friction_by_speed: {{exponential: {{start: 1.0, rate: 0.01}}}}
        slip_regularization: 0.2
        radial_damping: 0.1
        {lateral}
    grounds:
      road:
        plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}
        profile: {{direction: [1, 0, 0], height: {{random: {{density: {rough}, highest: 0.5}}}}}}
    initial:
      velocities: [{{nodes: [hub], velocity: [20, 1, 0], angular_velocity: [0, 50, 0]}}]
    time: {{end: 0.3, step: {step}, {control}}}
"""
MORELAND_LAW = "lateral_stiffness: 1.0e5, lateral_damping: 500, yaw_coefficient: 3.0e-5, yaw_time: 2.0e-3"
LATERAL = f"lateral: {{moreland: {{{MORELAND_LAW}}}}}"


def drop(kind="flexible_wheel", rough=0.0, step=2e-4, control="rho_inf: 0.8", lateral=LATERAL):
    return RecordedRun(deck(DROP.format(kind=kind, rough=rough, step=step, control=control, lateral=lateral)))


def test_energy_across_touch_down_slip_and_lift_off():
    """Dropped spinning on rough ground and sideways: the budget closes at second order."""
    leaks = []
    for step in (2e-4, 1e-4, 5e-5):
        recorded = drop(rough=1e-5, step=step)
        assert [h.name for h in recorded.event_records][:2] == ["touch_down", "lift_off"]
        leaks.append(np.ptp(recorded["energy/balance"]))
    assert leaks[2] < leaks[1] < leaks[0]
    assert leaks[2] < 1e-4 * recorded["energy/total"][0]


def test_y_and_psi_relax_in_the_air():
    """dy/dt = -(K/D) y; M = 0 likewise with F = 0: dpsi/dt = -psi/C1."""
    recorded = drop(step=5e-5)
    up = next(h.t for h in recorded.event_records if h.name == "lift_off")
    later = (recorded.time > up) & (recorded.time < up + 0.006)
    y, psi, t = (v[later] for v in (recorded["elements/tire/y"], recorded["elements/tire/psi"], recorded.time))
    assert abs(y[0]) > 1e-4
    np.testing.assert_allclose(y / y[0], np.exp(-(1e5 / 500) * (t - t[0])), atol=2e-3)
    np.testing.assert_allclose(psi / psi[0], np.exp(-(t - t[0]) / 2e-3), atol=5e-3)


def test_an_adhesive_wheel_is_spun_up_at_once():
    """The slip of 20 - 15 m/s is gone in a shock: with 1/m = 1/20 + 0.3^2/1, 5 m N s against the motion, 12.5 m J."""
    recorded = drop("adhesive_wheel", step=1e-4)
    down, m = recorded.event_records[0], 1 / (1 / 20 + 0.3**2)
    assert (down.name, down.after, down.unit) == ("touch_down", "contact", "N s")
    assert down.impulse == pytest.approx(-5 * m, rel=1e-9) and down.lost == pytest.approx(12.5 * m, rel=1e-9)
    assert np.ptp(recorded["energy/balance"]) < 1e-6 * recorded["energy/total"][0]
    assert recorded.run.dissipated > down.lost
    touching = recorded["elements/tire/normal_force"] > 0.0
    for name in ("longitudinal_slip", "lateral_slip"):
        slip = recorded[f"elements/tire/{name}"][touching]
        assert np.abs(slip).max() < 4e-9  # 1e-3 of the tolerance, 1e-10 m in a step
    before, after = (recorded["elements/tire/spin_rate"][i] for i in (0, np.argmax(touching)))
    assert before == pytest.approx(50.0) and after == pytest.approx(50 + 0.3 * 5 / (1 / 20 + 0.3**2), abs=0.05)


def test_moreland_and_relaxation_are_cases_of_the_matrices():
    none = dict.fromkeys(FORMS)
    moreland = {"lateral_stiffness": 2e5, "lateral_damping": 3.0, "yaw_coefficient": 1e-5, "yaw_time": 0.1,
                "torsional_stiffness": 50.0}  # fmt: skip
    A0, A1 = matrices({**none, "moreland": moreland})
    np.testing.assert_allclose(A0, [[2e5, 0.0], [-100.0, 50.0]])
    np.testing.assert_allclose(A1, [[3.0, 0.0], [-1.5e-3, 5.0]])
    relaxation = {"cornering_stiffness": 6e4, "relaxation_length": 0.3}
    A0, A1 = matrices({**none, "relaxation": relaxation})
    np.testing.assert_allclose(A0, [[2e5, 0.0], [-6e4, 1.8e4]])  # kap = K sigma^2
    assert not A1.any()


def test_errors_in_lateral_laws():
    none = dict.fromkeys(FORMS)
    grows = {"stiffness": [1e5, 0, 0, 1e4], "damping": [-10.0, 0, 0, 10.0]}
    singular = {"stiffness": [1e5, 0, 0, 0], "damping": [10.0, 0, 0, 10.0]}
    assert "'tire_law.lateral' is missing" in check_lateral(None)[0]
    assert check_forms(none).endswith("one of " + ", ".join(f"'{name}'" for name in FORMS))
    assert check_forms({**none, "matrices": grows, "string": singular}).endswith("; it has 'matrices', 'string'")
    assert check_forms({**none, "matrices": grows}) is None
    assert "grow in the air" in check_lateral({**none, "matrices": grows})[0]
    assert "singular" in check_lateral({**none, "matrices": singular})[0]


def test_limits_are_those_of_deformation_and_divergence():
    for values, _, _ in FLEXIBLE_WHEEL.sample(np.random.default_rng(1)):
        tire_law = {**values["tire_law"], "valid_deformation": 0.12}
        limits = FLEXIBLE_WHEEL.limits({**values, "tire_law": tire_law})
        divergence = [("divergence", 1.0)] if twists(tire_law["lateral"]) else []  # a slip angle bears no torque
        assert [(name, value) for name, value, _ in limits] == [("deformation", 0.12), *divergence]


LOADED = """
    mecano: 1
    gravity: [0, 0, -10]
    nodes: {hub: {position: [0, 0, 0.3]}}
    elements:
      rim: {type: rigid_body, node: hub, mass: 100, inertia: [1, 1, 1]}
      tire: {type: wheel, node: hub, axis: [0, 1, 0], tire_law: rubber, ground: road}
    joints: {upright: {type: prismatic, nodes: [ground, hub], axis: [0, 0, 1]}}
    tire_laws:
      rubber: {radius: 0.3, radial: {linear: {slope: 1.0e5}}, valid_deformation: VALID, friction: 0.5,
               slip_regularization: 0.1}
    grounds: {road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
    static: {steps: 4}
"""


@pytest.mark.parametrize(("valid", "warned"), [("9 mm", True), ("11 mm", False)])
def test_an_equilibrium_beyond_the_limit_of_a_law_is_warned_of(tmp_path, valid, warned):
    """The weight of 1000 N deforms the tyre by 10 mm."""
    texts = []
    static_run(deck(LOADED.replace("VALID", valid)), tmp_path / "r.h5", announce=texts.append)
    expected = "wheel 'tire': deformation reached 0.01 at load factor 1, but the radial law is valid up to 0.009 m only"
    assert (expected in texts) == warned and (not any("deformation" in text for text in texts)) == (not warned)
    with open_results(tmp_path / "r.h5") as results:
        assert (expected in results.reason) == warned


def test_friction_falls_with_the_speed_of_the_axle():
    """mu_0 exp(-kappa u): a sliding wheel that does not turn slows down by v' = -g mu_0 exp(-kappa v)."""
    text = """
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes:
          hub: {position: [0, 0, 0.2999019]}
        elements:
          rim: {type: rigid_body, node: hub, mass: 20.0, inertia: [1, 1, 1]}
          tire: {type: wheel, node: hub, axis: [0, 1, 0], tire_law: rubber, ground: road}
        joints:
          upright: {type: held_rotation, nodes: [ground, hub]}
        tire_laws:
          rubber:
            radius: 0.3
            radial: {linear: {slope: 2.0e6}}
            friction: 0.6
            friction_by_speed: {exponential: {start: 1.0, rate: 0.05}}
            slip_regularization: 0.1
        grounds:
          road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
        initial:
          velocities: [{nodes: [hub], velocity: [20, 0, 0]}]
        time: {end: 2.0, step: 2.0e-3}
        """
    recorded = RecordedRun(deck(text))
    expected = np.log(np.exp(0.05 * 20.0) - 0.05 * 0.6 * 9.81 * recorded.time) / 0.05
    np.testing.assert_allclose(recorded["nodes/hub/velocity"][:, 0], expected, rtol=1e-5)


def test_a_brake_keeps_its_bound_and_holds_a_stopped_wheel():
    text = """
        mecano: 1
        gravity: [0, 0, 0]
        nodes:
          post: {position: [0, 0, 0], fixed: true}
          hub: {position: [0, 0, 0]}
        elements:
          rim: {type: rigid_body, node: hub, mass: 1, inertia: [1, 2.0, 1]}
        joints:
          bearing: {type: hinge, nodes: [post, hub], axis: [0, 1, 0]}
        loads:
          drive: {type: couple, nodes: [post, hub], axis: [0, 1, 0], value: 5.0}
          brake:
            {type: brake, nodes: [post, hub], axis: [0, 1, 0], torque: 40.0, bound: 25.0, rate_regularization: 0.01}
        initial:
          velocities: [{nodes: [hub], angular_velocity: [0, 10, 0]}]
        time: {end: 2.0, step: 1.0e-3}
        """
    recorded = RecordedRun(deck(text))
    torque, rate = recorded["loads/brake/torque"], recorded["loads/brake/rate"]
    least = 0.5 * (65 - np.sqrt(15**2 + 4 * 0.02**2 * 1000))  # the smaller of 40 and 25 N m, smooth
    assert torque.max() == pytest.approx(least, rel=1e-9) and 24.9 < least < 25.0
    moving = recorded.time < 0.9
    np.testing.assert_allclose(rate[moving], 10 - (least - 5.0) / 2.0 * recorded.time[moving], rtol=1e-7)
    # creeps at the rate whose friction balances 5 N m: T x (2 - x) = 5
    x = 1 - np.sqrt(1 - 5.0 / least)
    assert rate[-1] == pytest.approx(0.01 * x, rel=1e-6) and torque[-1] == pytest.approx(5.0, rel=1e-6)


def test_the_random_road_has_its_spectrum():
    """Mean square of ISO 8608's density G = G0 (n/n0)^-2 over the waves: G0 n0^2 (1/n1 - 1/n2); the seed decides."""
    values = {"density": 64e-6, "reference": 0.1, "exponent": 2.0, "lowest": 0.011, "highest": 2.83, "waves": 200}
    values |= {"seed": 3, "lead_in": 0.0, "start": 0.0, "origin": 0.0}
    road = (("random", values),)
    s = np.linspace(0.0, 4000.0, 20001)
    height = np.array([curve_at(road, x)[0] for x in s[::10]])
    assert np.mean(height**2) == pytest.approx(64e-6 * 0.01 * (1 / 0.011 - 1 / 2.83), rel=0.1)
    same, other = (curve_at((("random", {**values, "seed": seed}),), 1.0)[0] for seed in (3, 4))
    assert same == curve_at(road, 1.0)[0] != other


def test_a_random_road_begins_flat_and_rises_smoothly_over_its_lead_in():
    values = {"density": 64e-6, "reference": 0.1, "exponent": 2.0, "lowest": 0.011, "highest": 2.83, "waves": 20}
    values |= {"seed": 3, "lead_in": 0.0, "start": 0.0, "origin": 0.0}
    endless, led = (("random", values),), (("random", {**values, "lead_in": 5.0, "start": 2.0}),)
    assert curve_at(led, -3.0) == curve_at(led, 2.0) == (0.0, 0.0, 0.0)
    assert curve_at(led, 7.0) == curve_at(endless, 7.0) and curve_at(led, 50.0) == curve_at(endless, 50.0)
    assert curve_at(led, 4.5)[0] == pytest.approx(0.5 * curve_at(endless, 4.5)[0], rel=1e-12)
    assert abs(curve_at(led, 2.0 + 1e-6)[1]) < 1e-6 * abs(curve_at(endless, 2.0)[1]) + 1e-9


def test_steady_running_begins_on_the_flat_part_of_a_random_road():
    """The bicycle, whose front wheel stands at 1.02 m, starts as on a plane; without a lead-in it cannot."""
    rough = "grounds.road.profile={direction: [1, 0, 0], height: {random: {density: 4e-6, lowest: 0.05, highest: 0.3}}}"
    led = rough.replace("highest", "lead_in: 2, start: 1.5, highest")
    plane, road = (prepare(input_deck("bicycle", *overrides)) for overrides in ((), (led,)))
    assert set_initial_state(plane) == set_initial_state(road) == ()
    np.testing.assert_array_equal(road.state.z, plane.state.z)
    with pytest.raises(ConvergenceError, match="no straight steady running"):
        set_initial_state(prepare(input_deck("bicycle", rough)))


LANDING = [0.0, 469064.3846532291, 19244229.974871956, -219455084.02402905, 843323797.0102023]
LANDING_FORCE = {0.02: 15640.085902495546, 0.06: 60326.04562391141, 0.10: 105012.00534532724, 0.12: 127354.98520603517}


def test_the_quartic_of_the_landing_gear_tyre():
    """c1_landing: a surrogate of Smiley & Horne's curve, to 1.4 percent, up to 0.12 m; it warns beyond."""
    law = (("polynomial", {"coefficients": LANDING}),)
    for w, F in LANDING_FORCE.items():
        assert curve_at(law, w)[0] == pytest.approx(F, rel=0.03)
    assert all(curve_at(law, w)[1] > 0.0 for w in np.linspace(0.0, 0.12, 25))


def test_a_wheel_at_rest_under_braking_stays():
    """A flexible wheel rolls to a stop under a brake and stays: no drift, energy closed."""
    text = """
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes:
          leg: {position: [0, 0, 0.3]}
          hub: {position: [0, 0, 0.3]}
        elements:
          load: {type: rigid_body, node: leg, mass: 90, inertia: [10, 10, 10]}
          rim: {type: rigid_body, node: hub, mass: 10, inertia: [0.2, 0.4, 0.2]}
          tire: {type: flexible_wheel, node: hub, axis: [0, 1, 0], tire_law: rubber, ground: road}
        joints:
          upright: {type: held_rotation, nodes: [ground, leg]}
          bearing: {type: hinge, nodes: [leg, hub], axis: [0, 1, 0]}
        loads:
          brake: {type: brake, nodes: [leg, hub], axis: [0, 1, 0], torque: 100}
        tire_laws:
          rubber:
            radius: 0.301
            radial: {linear: {slope: 9.81e5}}
            friction: 0.8
            slip_regularization: 0.05
            radial_damping: 1.0
            lateral:
              moreland: {lateral_stiffness: 1.0e5, lateral_damping: 100, yaw_coefficient: 3.0e-5, yaw_time: 1e-3}
        grounds:
          road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
        initial:
          velocities:
            - {nodes: all, velocity: [3, 0, 0]}
            - {nodes: [hub], angular_velocity: [0, 10, 0]}
        time: {end: 1.5, step: 1.0e-3, adaptive: {tolerance: 1.0e-4}}
        """
    recorded = RecordedRun(deck(text))
    v = recorded["nodes/leg/velocity"][:, 0]
    decel = 100 / 0.3 / (100 + 0.4 / 0.09)
    i = np.searchsorted(recorded.time, 0.5)
    assert v[i] == pytest.approx(3.0 - decel * recorded.time[i], rel=0.02)
    assert abs(v[-1]) < 1e-3 and np.ptp(recorded["energy/balance"]) < 1e-3 * recorded["energy/kinetic"][0]

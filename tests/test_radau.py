"""Radau IIA on the Lie group: orders, tolerance, output between steps, events, resumed runs (docs/theory.md, 2.6)."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from time_runs import RecordedRun, deck, input_deck
from work_precision import adaptive

from mecano.analyses.dynamic import run
from mecano.errors import ConvergenceError
from mecano.maths.hermite import quintic
from mecano.maths.so3 import tangent, tangent_rate
from mecano.maths.vector import Vec3
from mecano.model.numbering import ROTATION
from mecano.results.reader import open_results
from mecano.solve.linear import factors

RADAU = "time.method=radau"


def last(name, h, end, tolerance=1e-14):
    """Motion at the end of a run in steps of size h, and the system."""
    newton = f"time.newton.constraint_tolerance={tolerance}"
    recorded = RecordedRun(input_deck(name, RADAU, f"time.end={end}", f"time.step={h}", newton))
    return recorded.run.motion, recorded.system


def distances(system, s, exact):
    """Largest differences of positions and rotations, velocities, accelerations, multipliers."""
    of, n_q = system.numbering, system.n_q
    place = np.where(of.kind[:n_q] == ROTATION, 0.0, (s.z - exact.z)[:n_q])
    turn = np.einsum("rji,rjk->rik", exact.R, s.R) - np.eye(3)
    return np.array([
        max(np.abs(place).max(), np.abs(turn).max(initial=0.0)), np.abs(s.v - exact.v).max(),
        np.abs(s.a - exact.a).max(), np.abs((s.z - exact.z)[n_q : system.n]).max(initial=0.0),
    ])  # fmt: skip


@pytest.mark.parametrize(
    ("name", "h", "end", "less"),
    [("heavy_top", 2.5e-3, 0.05, 2), ("four_bar", 0.02, 0.4, 4), ("bicycle", 0.02, 0.2, 2)],
)
def test_all_components_have_order_five(name, h, end, less):
    """A spinning top, holonomic constraints, and wheels that roll; accelerations and reactions too."""
    exact, system = last(name, h / 16, end)
    errors = [distances(system, last(name, step, end)[0], exact) for step in (h, h / less)]
    there = [True, True, True, system.n_l > 0]
    errors = np.array(errors)[:, there]
    assert np.all(errors[0] > 1e-10)  # rounding is far below
    assert np.all(np.log(errors[0] / errors[1]) / np.log(less) >= 4.7)


@pytest.mark.parametrize(
    ("name", "end", "tolerances"),
    [("four_bar", 1.0, (1e-4, 1e-6, 1e-8)), ("heavy_top", 0.5, (1e-4, 1e-6, 1e-8)), ("wheel_drop", 1.0, (1e-4, 1e-6))],
)
def test_error_follows_the_tolerance(name, end, tolerances):
    """Within 3 tolerances of independent solutions, also over the events of a bouncing wheel."""
    errors = []
    for tolerance in tolerances:
        recorded, error = adaptive(name, tolerance, "radau", end)
        errors.append(error)
        assert error <= 3.0 * tolerance
    assert np.all(np.diff(errors) < 0.0)


def test_saved_motion_has_the_accuracy_of_the_steps(tmp_path):
    """Positions at 1 ms between steps of 20 ms and more: to 1e-8 those of a run with a hundredth of the tolerance."""
    found = []
    for tolerance in (1e-8, 1e-10):
        path = tmp_path / f"{tolerance}.h5"
        control = f"time.adaptive.tolerance={tolerance}", "time.end=1"
        run(input_deck("four_bar", RADAU, *control, "output.every=1e-3"), path)
        with open_results(path) as results:
            names = ("joints/hinge_a/angle", "joints/hinge_a/rate", "nodes/coupler_end/position")
            found.append([results[name].values for name in names])
    for saved, exact, tolerance in zip(*found, (3e-8, 1e-6, 3e-8), strict=True):
        assert np.abs(saved - exact).max() <= tolerance


PARALLELOGRAM = """
mecano: 1
gravity: none
nodes:
  crank_0: {position: [0, 0, 0]}
  tip_0: {position: [0, 0, 1]}
  crank_1: {position: [1, 0, 0]}
  tip_1: {position: [1, 0, 1]}
  coupler: {position: [0, 0, 1]}
  end: {position: [1, 0, 1]}
elements:
  bar_0: {BAR, node: crank_0, center_of_mass: [0, 0, 0.5], attached: [tip_0]}
  bar_1: {BAR, node: crank_1, center_of_mass: [0, 0, 0.5], attached: [tip_1]}
  link: {BAR, node: coupler, center_of_mass: [0.5, 0, 0], attached: [end]}
joints:
  hinge_0: {type: hinge, nodes: [ground, crank_0], axis: [0, 1, 0]}
  hinge_1: {type: hinge, nodes: [ground, crank_1], axis: [0, 1, 0]}
  hinge_2: {type: hinge, nodes: [tip_0, coupler], axis: [0, 1, 0]}
  hinge_3: {type: hinge, nodes: [tip_1, end], axis: [0, 1, 0]}
initial:
  velocities:
    - {nodes: [crank_0, tip_0], angular_velocity: [0, 1, 0], about: [0, 0, 0]}
    - {nodes: [crank_1, tip_1], angular_velocity: [0, 1, 0], about: [1, 0, 0]}
    - {nodes: [coupler, end], velocity: [1, 0, 0]}
time: {end: END, step: STEP, method: radau}
""".replace("BAR", "type: rigid_body, mass: 1.0, inertia: [0.1, 0.1, 0.1]")


def parallelogram(before, steps=10, end=None):
    """Deck of a parallelogram at 1 rad/s in steps one of which ends an angle ``before`` its singular position."""
    h = (np.pi / 2 - before) / steps
    return deck(PARALLELOGRAM.replace("STEP", repr(h)).replace("END", repr(end or (steps + 2) * h)))


@pytest.mark.parametrize("before", [1e-3, 1e-5, 1e-7, 0.0])
def test_a_step_may_end_at_a_singular_position(before):
    """All bars lie in one line: angles grow by 1 rad/s, each bearing carries 1 N (half a bar and half the coupler)."""
    recorded = RecordedRun(parallelogram(before))
    for hinge in ("hinge_0", "hinge_1"):
        assert np.abs(recorded[f"joints/{hinge}/angle"] - recorded.time).max() < 1e-7
        force = np.linalg.norm(recorded[f"joints/{hinge}/force"], axis=1)
        assert np.abs(force - 1.0).max() < 1e-6
    assert not recorded.integrator.cuts


def test_steps_that_are_too_short_for_a_singular_position_are_refused():
    """A step from 1e-4 rad before it to 1e-4 rad behind it: the error names the loop."""
    run = RecordedRun(parallelogram(1e-4, end=np.pi / 2 - 1e-4))
    with pytest.raises(ConvergenceError, match="(?s)is at a singular position.*hinge 'hinge_3'.*too short") as raised:
        run.integrator.method.step(run.run.motion, run.run.history, 2e-4)
    assert "rigid_body 'link'" in raised.value.elements


@pytest.mark.parametrize("name", ["andrews", "four_bar", "bicycle", "car", "reflector"])
def test_stages_need_no_row_exchanges_everywhere(name, monkeypatch):
    """Rows of unknowns without mass take part of the constraints: no factorization is repeated by SuperLU."""

    def behind_the_start(integrator, run):
        run = integrator.to(1e-5, run)  # rounding decides when cables as long as their paths go taut: in 1e-13 s
        monkeypatch.setattr(factors.Factors, "_factor", lambda *_: pytest.fail("by SuperLU"))
        return run

    control = f"time.end={1e-3 if name == 'andrews' else 0.02}", "time.adaptive={tolerance: 1.0e-6}"
    assert RecordedRun(input_deck(name, RADAU, *control), change=behind_the_start).run.steps > 1


DAMPED = """
mecano: 1
gravity: none
nodes:
  end: {position: [1, 0, 0]}
  post: {position: [0, 0, 0], fixed: true}
elements:
  ball: {type: point_mass, node: end, mass: 2.0}
  strut:
    type: spring_damper
    nodes: [post, end]
    natural_length: 0.9
    law: {spring: {stiffness: 800.0}, damper: {coefficient: 24.0}}
time: {end: 1.0, step: 0.05, method: radau}
"""


def test_a_linear_oscillation_converges_at_once_and_balances_its_energy():
    """x = exp(-6 t) sin/cos along a line: one correction is exact, and the work follows from the stages."""
    recorded = RecordedRun(deck(DAMPED))
    d, w = 24.0 / 4.0, np.sqrt(400.0 - 36.0)
    t = recorded.time
    exact = 0.9 + np.exp(-d * t) * 0.1 * (np.cos(w * t) + d / w * np.sin(w * t))
    assert np.abs(recorded["nodes/end/position"][:, 0] - exact).max() < 3e-5
    assert all(info.iterations <= 2 for info in recorded.infos)
    assert np.ptp(recorded["energy/balance"]) < 1e-3 * recorded["energy/total"][0]


def test_a_passage_and_return_within_a_step_is_not_missed():
    """A ball thrown up between two steps that both end below a stop meets it."""
    recorded = RecordedRun(input_deck("bouncing_ball", RADAU, "time.step=0.5", "time.end=2"))
    usual = RecordedRun(input_deck("bouncing_ball", "time.end=2"))
    times = [[e.t for e in one.event_records] for one in (recorded, usual)]
    assert len(times[0]) == len(times[1]) > 1
    assert np.allclose(*times, atol=1e-5)


def test_a_resumed_run_has_the_same_bits(tmp_path):
    from surviving import check_same, contents, resumed

    of, whole, parts = (
        input_deck("four_bar", RADAU, "time.adaptive.tolerance=1e-7", "time.end=0.5"),
        *(tmp_path / name for name in ("whole.h5", "parts.h5")),
    )
    run(of, whole)
    resumed(of, parts, (10, 20))
    check_same(contents(parts), contents(whole))


def test_forces_between_steps_stay_within_those_of_the_stages(tmp_path):
    """At 1 ms between steps of 20 ms no force exceeds the extremes of ends and stages."""
    rows, steps = tmp_path / "rows.h5", tmp_path / "steps.h5"
    for path, every in ((rows, "1e-3"), (steps, "step")):
        run(input_deck("four_bar", RADAU, "time.step=0.02", f"output.every={every}"), path)
    with open_results(rows) as saved, open_results(steps) as accepted:
        for name in ("joints/hinge_a/force", "joints/hinge_c/force"):
            force = saved[name].values
            assert len(force) == 3001
            for of, component in zip(force.T, "xyz", strict=True):
                extreme = accepted.extremes[f"{name}.{component}"]
                assert extreme.minimum <= of.min() <= of.max() <= extreme.maximum


def test_reactions_that_move_nothing_stay_accurate_between_steps(tmp_path):
    """The joint of a puck that turns by 1 rad in a step transmits no moment; its weight of 17 N acts 0.1 m above."""
    run(input_deck("planar_slide", RADAU, "time.adaptive={tolerance: 1.0e-7}"), tmp_path / "r.h5")
    with open_results(tmp_path / "r.h5") as results:
        moment, force = (results[f"joints/slope/{name}"] for name in ("moment", "force"))
    assert np.abs(moment).max() <= 1e-3
    assert force == pytest.approx(2.0 * 9.81 * np.cos(np.radians(30.0)), rel=1e-9)


def test_a_step_that_is_too_long_is_named():
    text = deck(
        "mecano: 1\ngravity: none\nnodes: {a: {position: [0, 0, 0]}}\nelements:\n"
        "  top: {type: rigid_body, node: a, mass: 1.0, inertia: [1.0, 2.0, 3.0]}\n"
        "initial: {velocities: [{nodes: [a], angular_velocity: [1.0, 2000.0, 3.0]}]}\n"
        "time: {end: 10.0, step: 1.0, method: radau, adaptive: {tolerance: 1e-6, minimum_step: 0.5}}\n"
    )
    with pytest.raises(ConvergenceError, match="(?s)no step could be taken at t = 0 s.*node a: moment about material"):
        RecordedRun(text)


LOOSE = """
mecano: 1
gravity: none
nodes: {hub: {position: [0, 0, 0]}, disc: {position: [0, 0, 0]}}
elements:
  disc: {type: rigid_body, node: disc, mass: 2, inertia: [1, 1, 1]}
  seat: {type: bushing, nodes: [ground, hub], stiffness: [2.0e4, 2.0e4, 2.0e4, 0, 0, 0]}
joints:
  ball: {type: spherical, nodes: [hub, disc]}
initial: {velocities: [{nodes: all, velocity: [1, 0, 0]}]}
time: {end: 0.03, step: 1.0e-3, method: radau, adaptive: {tolerance: 1.0e-6, length_scale: 1}}
"""


def test_a_rotation_that_nothing_moves_or_resists_stays():
    """That of the hub has neither inertia nor stiffness: the disc oscillates with sqrt(k/m) = 100 rad/s."""
    recorded = RecordedRun(deck(LOOSE))
    assert recorded["nodes/disc/position"][-1, 0] == pytest.approx(np.sin(3.0) / 100.0, abs=1e-8)
    turned = LOOSE.replace(
        "initial:", "loads: {turn: {type: moment, node: hub, direction: [0, 0, 1], value: 3}}\ninitial:"
    )
    with pytest.raises(ConvergenceError, match="nothing resists:\n  node hub: rotation about material z"):
        RecordedRun(deck(turned))


def test_no_step_turns_a_body_by_more_than_joints_can_follow():
    """A wheel of 1000 rad/s in steps of 10 ms: they are cut, and all turns are counted."""
    recorded = RecordedRun(deck(WHEEL))
    assert recorded["joints/axle/angle"][-1] == pytest.approx(100.0, abs=1e-6)
    assert recorded.integrator.cuts


WHEEL = """
mecano: 1
gravity: none
nodes: {hub: {position: [0, 0, 0]}}
elements:
  wheel: {type: rigid_body, node: hub, mass: 1.0, inertia: [0.1, 0.2, 0.1]}
joints:
  axle: {type: hinge, nodes: [ground, hub], axis: [0, 1, 0]}
initial: {velocities: [{nodes: [hub], angular_velocity: [0, 1000, 0]}]}
time: {end: 0.1, step: 0.01, method: radau}
"""


def test_the_rate_of_the_tangent_by_differences():
    psi, rate, h = np.array([0.7, -1.1, 0.4]), np.array([1.3, 0.2, -2.0]), 1e-6
    for scale in (1.0, 1e-3):
        turned = [np.array(tangent(Vec3(*(scale * psi + sign * h * rate)))) @ rate for sign in (1.0, -1.0)]
        found = tangent_rate(Vec3(*(scale * psi)), Vec3(*rate))
        assert np.allclose(found, (turned[0] - turned[1]) / (2 * h), atol=1e-8)


def test_the_quintic_is_exact_for_polynomials_of_degree_five():
    p = np.polynomial.Polynomial([0.3, -1.0, 2.0, 0.5, -0.7, 1.1])
    ends = [part for q in (p, p.deriv(), p.deriv(2)) for part in (q(0.0), q(0.4))]
    value, rate = quintic(0.3, 0.4, *ends)
    assert value == pytest.approx(p(0.12), abs=1e-14) and rate == pytest.approx(p.deriv()(0.12), abs=1e-13)


STRUT = """
mecano: 1
gravity: [0, 0, -9.81]
nodes: {base: {position: [0, 0, 0], fixed: true}, mass: {position: [0, 0, 1]}}
elements:
  mass: {type: point_mass, node: mass, mass: 800}
  strut: {type: oleo, nodes: [base, mass], gas: {pressure: 1.2e6, volume: 1.4e-3, area: 4.0e-3},
          oil: {area: 3.5e-3, orifice: 2.0e-4, volume: 1.5e-3}}
joints:
  x: {type: prescribed_position, node: mass, direction: [1, 0, 0], value: 0}
  y: {type: prescribed_position, node: mass, direction: [0, 1, 0], value: 0}
initial: {velocities: [{nodes: [mass], velocity: [0, 0, -2]}]}
time: {end: 0.02, step: 1.0e-4, method: radau, MORE}
"""


def fallen():
    """Position of the mass of STRUT at its end, whose oil is not compressed at the start: its equations, integrated."""
    drag, k, u_0 = 860 * 3.5e-3**3 / (2 * (0.7 * 2e-4) ** 2), 1.4e9 * 3.5e-3**2 / 1.5e-3, 1e-3

    def rate(t, y):
        z, v, c = y
        u = np.sign(c) * 0.5 * (np.sqrt(u_0**2 + 4 * k * abs(c) / drag) - u_0)
        gas = 1.2e6 * (1.4e-3 / (1.4e-3 - 4e-3 * (1 - z))) ** 1.3 - 101325
        return v, (4e-3 * gas + k * c) / 800 - 9.81, -v - u

    return solve_ivp(rate, (0.0, 0.02), (1.0, -2.0, 0.0), method="Radau", rtol=1e-10, atol=1e-13).y[0, -1]


@pytest.mark.parametrize("control", ["", "adaptive: {tolerance: 1.0e-5}"])
def test_a_strut_starts_at_a_speed(control):
    """Its oil flows with the square root of its compression, which the tangent at the start does not show."""
    recorded = RecordedRun(deck(STRUT.replace("MORE", control)))
    assert recorded["nodes/mass/position"][-1, 2] == pytest.approx(fallen(), abs=1e-8)
    assert len(recorded.time) < 220


DASHPOT = """
mecano: 1
gravity: [0, 0, -9.81]
nodes: {foot: {position: [0, 0, 0.005]}}
elements: {mass: {type: point_mass, node: foot, mass: 130}}
signals:
  depth: {type: formula, value: "max(-foot.position.z, 0)", unit: m}
  stiffness: {type: formula, value: 2e8*depth}
  damping: {type: formula, value: "2.3*sqrt(stiffness)*max(-foot.velocity.z, 0)", unit: N}
loads: {ground: {type: force, node: foot, direction: [0, 0, 1], value: 1e8*depth**2 + damping}}
initial: {velocities: [{nodes: [foot], velocity: [0, 0, -4.945]}]}
time: {end: 10 ms, step: 0.2 ms, method: radau, adaptive: {tolerance: 1e-8, length_scale: 10 mm}}
"""


def test_a_damper_whose_slope_is_infinite_at_contact_is_passed():
    """A force like the root of the depth, by signals of signals; by solve_ivp from the instant of contact on."""
    recorded = RecordedRun(deck(DASHPOT))
    g, v = 9.81, 4.945
    touch = (np.sqrt(v * v + 2.0 * g * 0.005) - v) / g

    def rates(t, y):
        depth = max(-y[0], 0.0)
        return y[1], -g + (1e8 * depth**2 + 2.3 * np.sqrt(2e8 * depth) * max(-y[1], 0.0)) / 130.0

    exact = solve_ivp(rates, (touch, 0.01), (0.0, -v - g * touch), method="DOP853", rtol=1e-12, atol=1e-14)
    assert recorded.run.motion.z[2] == pytest.approx(exact.y[0, -1], abs=3e-10)
    assert recorded.run.motion.v[2] == pytest.approx(exact.y[1, -1], abs=3e-7)


def test_a_short_last_step_with_unknowns_without_mass_is_accepted():
    """The lateral deformation of a tyre holds at its beginning as well as the longer step before satisfied it."""
    angles = [
        RecordedRun(input_deck("caster_shimmy", RADAU, "time.end=0.25", f"time.adaptive={{tolerance: {tolerance}}}"))[
            "joints/caster/angle"
        ][-1]
        for tolerance in (1e-7, 1e-9)
    ]
    assert angles[0] == pytest.approx(angles[1], abs=1e-7 * 0.25)

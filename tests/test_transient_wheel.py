"""Wheels with a carcass: relaxation, unique rates, energy, the wheel without a carcass as their limit."""

import math

import numpy as np
import pytest
from magic_formula import read
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from time_runs import INPUTS, RecordedRun, deck, input_deck

from mecano.analyses.kind_samples import Instance, duals, expand, seed_of
from mecano.constraints.ground import slope_below
from mecano.elements.wheels.fiala import FIALA
from mecano.elements.wheels.magic_formula import MAGIC_FORMULA, completed
from mecano.elements.wheels.slip_law import default_values
from mecano.elements.wheels.transient_wheel import TRANSIENT_WHEEL, X, Y
from mecano.elements.wheels.yawed_rolling import YAWED_ROLLING

C, LOAD, K, CREEP, V, ALPHA = 6e4, 4000.0, 1.5e5, 0.02, 10.0, 0.03


def brush(v_l):
    """Fiala's lateral force against a lateral slip velocity in pure side slip, rolling with V cos(alpha)."""
    z = v_l / (V * math.cos(ALPHA))
    x = min(C * abs(z) / (3.0 * LOAD), 1.0)
    return LOAD * math.copysign(3 * x - 3 * x * x + x**3, z)


def build_up(times):
    """Lateral force over the time: K (y + b dy/dt/V) = F, by Radau's method, dy/dt from a root search."""
    damping = K * CREEP / math.hypot(V * math.cos(ALPHA), 1.0)

    def rate(t, y):
        v_l = -V * math.sin(ALPHA)
        found = brentq(lambda y1: K * y[0] + damping * y1 + brush(v_l + y1), -50.0, 50.0, xtol=1e-13, rtol=1e-13)
        return [found]

    y = solve_ivp(rate, (0.0, times[-1]), [0.0], "Radau", t_eval=times, rtol=1e-9, atol=1e-13).y[0]
    return np.array([K * one + damping * rate(0.0, [one])[0] for one in y])


def test_the_force_builds_up_over_the_relaxation_length(verify):
    """inputs/step_slip.yaml against an independent integration; the end is the closed form of Fiala."""
    recorded = RecordedRun(input_deck("step_slip", "signals={force: tire.lateral_force}"))
    np.testing.assert_allclose(recorded["signals/force/value"], recorded["elements/tire/lateral_force"], atol=1e-6)
    force, way = recorded["elements/tire/lateral_force"].ravel(), V * recorded.time
    own = build_up(recorded.time)
    np.testing.assert_allclose(force[1:], own[1:], atol=5e-4 * own[-1])
    steady = brush(V * math.sin(ALPHA))
    verify("Tyres", "a tyre with a carcass after a step of slip angle: force [N] at the end", force[-1], steady,
           "Fiala 1954", relative=2e-3)  # fmt: skip
    assert steady == pytest.approx(1543.89, abs=0.01)
    assert np.interp((1.0 - math.exp(-1.0)) * steady, own, way) == pytest.approx(0.322, abs=1e-3)


def test_small_slip_has_the_relaxation_length_of_the_data():
    angle = 1e-4
    recorded = RecordedRun(
        input_deck(
            "step_slip", f"elements.tire.axis=[{-math.sin(angle)!r}, {math.cos(angle)!r}, 0]",
            f"joints.bearing.axis=[{-math.sin(angle)!r}, {math.cos(angle)!r}, 0]", "time.end=0.1",
        )
    )  # fmt: skip
    force, way = recorded["elements/tire/lateral_force"].ravel(), V * recorded.time
    sigma = C / K + CREEP
    expected = C * angle * (1.0 - C / K / sigma * np.exp(-way / sigma))  # the creep responds at once
    np.testing.assert_allclose(force, expected, atol=6e-3 * C * angle)


def tyres():
    """Values of tyre laws with a carcass: a brush whose friction falls with the slip speed, a car tyre from a file."""
    falling = (("exponential", {"start": 1.0, "limit": 0.4, "rate": 0.5, "origin": 0.0}),)
    numbers = {**read(INPUTS / "passenger_car.tir"), "VERSION": 6.1}
    fiala = {"cornering_stiffness": C, "friction": falling, "carcass_stiffness": [3e5, K]}
    radial = {"radius": 0.32, "radial": (("linear", {"slope": 2e5, "offset": 0.0}),), "radial_damping": 1e-3}
    common = {"friction": None, "friction_by_speed": 1.0, "slip_regularization": None, "valid_deformation": None}
    one = {**common, **radial, "fiala": default_values(FIALA.type.options, fiala)}
    file = {**common, "magic_formula": default_values(MAGIC_FORMULA.type.options, {"coefficients": numbers})}
    sliding = {"coefficients": {**numbers, "RBX1": 13.0, "RBX2": -14.0, "RCX1": 1.25, "RCY1": 1.2}}
    steep = {**common, "magic_formula": default_values(MAGIC_FORMULA.type.options, sliding)}
    yawed = default_values(YAWED_ROLLING.type.options, fiala)
    return {
        "fiala": one, "magic_formula": {**file, **completed(file)}, "falling_weights": {**steep, **completed(steep)},
        "yawed_rolling": {**common, **radial, "yawed_rolling": yawed},
    }  # fmt: skip


def damping_of_deflections(instance, q, v):
    """Return the derivatives (2, 2) of the forces along x and y by dx/dt and dy/dt, by dual numbers."""
    columns = []
    for j in (X, Y):
        out, at_rest = duals(np.zeros(8), np.zeros(8)), np.zeros(8)
        moving = duals(q, at_rest), duals(v, np.eye(8)[j]), duals(at_rest, at_rest)
        instance.run("residual", 0.0, (*moving, duals(np.eye(3)[None], np.zeros((1, 3, 3)))), out)
        columns.append([out[i].slope for i in (X, Y)])
    return np.array(columns).T


@pytest.mark.parametrize(
    ("name", "angle"), [("fiala", 0.3), ("magic_formula", 0.3), ("yawed_rolling", 0.3), ("falling_weights", 30.0)]
)
def test_rates_of_the_deflections_are_unique(name, angle):
    """The forces along x and y never fall with dx/dt and dy/dt: monotone, sliding or not, at all loads and speeds.

    "falling_weights" are of a tyre that slides sideways, where cos(C atan ...) of combined slip is negative.
    """
    rng, least = seed_of(name), []
    ground, normal, level = slope_below(rng)
    ground["plane"]["point"] = -0.3 * normal
    values = {"node": "hub", "axis": level, "tire_law": tyres()[name], "ground": ground}
    [instance] = expand(TRANSIENT_WHEEL, values, [(np.zeros(3), np.eye(3))], "contact", np.zeros(3), rng)
    assert isinstance(instance, Instance)
    forward = np.cross(level, normal)
    for _ in range(150):
        speed = 10.0 ** rng.uniform(-1.0, 1.7)
        q, v = np.zeros(8), np.zeros(8)
        q[:3] = rng.uniform(-0.02, 0.015) * normal
        q[X], q[Y] = rng.normal(size=2) * 0.02
        v[:3] = speed * (forward + rng.normal() * angle * level)
        v[3:6] = level * speed / 0.3 * rng.uniform(0.0, 2.0)
        v[[X, Y]] = rng.normal(size=2) * speed * 10.0 ** rng.uniform(-3.0, -0.5)
        block = damping_of_deflections(instance, q, v)
        least.append(np.linalg.eigvalsh(block + block.T)[0] / np.abs(block).max())
    assert min(least) > 0.0


def test_the_car_tyre_of_the_examples_relaxes(verify):
    """A wheel with inputs/passenger_car.tir at 0.2 degrees: lengths of the file, C/K at its nominal load."""
    recorded = RecordedRun(
        input_deck(
            "magic_formula_sweep", "elements.tire.type=transient_wheel", "joints.steer.value=0.0",
            "initial.velocities=[{nodes: all, velocity: [20, 0, 0]}, {nodes: [hub], angular_velocity: [0, 64.4, 0]}]",
            "joints.track.value={ramp: {start: 0, end: 0.6, from: 0, to: 0.0420}}", "time.end=0.6",
            "time.step=2e-4", "time.adaptive=null",
        )
    )  # fmt: skip
    force, way = recorded["elements/tire/lateral_force"].ravel(), 20.0 * recorded.time
    numbers = read(INPUTS / "passenger_car.tir")
    dp = numbers["INFLPRES"] / numbers["NOMPRES"] - 1.0
    slip = 24.0 * 4e3 * (1 - 0.45 * dp) * math.sin(2 * math.atan(1.0 / (1.9 * (1 - 0.1 * dp))))
    sigma = slip / (110e3 * (1 + 0.2 * dp))
    left = np.interp([0.5, 2.5], way, force) - force[-1]  # an exponential of the way
    found = 2.0 / math.log(left[0] / left[1])
    what = "relaxation length of inputs/passenger_car.tir [m]"
    verify("Tyres", what, found, sigma, "slip stiffness over carcass stiffness of the file", relative=0.015)


def test_energy_of_a_slalom():
    """What tow and track do is stored, dissipated or exchanged; the balance closes with the square of the step."""
    leaks = []
    for h in (1e-3, 5e-4):
        recorded = RecordedRun(
            input_deck(
                "step_slip", "joints.track.value={sine: {amplitude: 0.05, frequency: 3}}", f"time.step={h}",
                "initial.velocities=[{nodes: all, velocity: [10, 0.94247779608, 0]}, {nodes: [hub], "
                "angular_velocity: [-1.0707856, 35.6821359, 0]}]",
            )
        )  # fmt: skip
        leaks.append(np.ptp(recorded["energy/balance"]))
        lost, stored = recorded["energy/dissipated"][-1], 0.5 * K * recorded["elements/tire/y"].ravel() ** 2
    assert lost > 50.0 and stored.max() > 5.0
    assert leaks[0] < 2e-3 * lost and leaks[1] < 0.35 * leaks[0]


CASTER = """
    mecano: 1
    gravity: [0, 0, -9.81]
    parameters: {V: 12.0, trail: 0.06}
    nodes:
      carriage: {position: [0, 0, 0.3]}
      arm: {position: [0, 0, 0.3]}
      axle: {position: [-$trail, 0, 0.3]}
      hub: {position: [-$trail, 0, 0.3]}
    elements:
      swivel: {type: rigid_body, node: arm, mass: 1, inertia: [0.3, 0.3, 0.3], attached: [axle]}
      rim: {type: rigid_body, node: hub, mass: 5, inertia: [0.1, 1.0e-4, 0.1]} # 0.3 + 0.1 + 5 trail^2 = 0.418 kg m2
      tyre: {type: transient_wheel, node: hub, axis: [0, 1, 0], tire_law: brush, ground: road}
    joints:
      level: {type: held_rotation, nodes: [ground, carriage]}
      height: {type: prescribed_position, node: carriage, direction: [0, 0, 1], value: 0.0}
      track: {type: prescribed_position, node: carriage, direction: [0, 1, 0], value: 0.0}
      tow: {type: prescribed_position, node: carriage, direction: [1, 0, 0], value: {linear: {slope: $V}}}
      caster: {type: hinge, nodes: [carriage, arm], axis: [0, 0, 1], turning_law: {damper: {coefficient: 1.0}}}
      bearing: {type: hinge, nodes: [axle, hub], axis: [0, 1, 0]}
    tire_laws:
      brush:
        radius: 0.32
        radial: {linear: {slope: 2.0e5}}
        fiala: {cornering_stiffness: 3.0e4, friction: 0.8, contact_length: 0.1, carcass_stiffness: [3.0e5, 1.5e5]}
    grounds: {road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
    initial:
      steady: {velocity: [$V, 0, 0]}
      velocities: [{nodes: [arm, axle, hub], angular_velocity: [0, 0, 30], about: [0, 0, 0]}]
    time: {end: 0.8, step: 0.25 ms}
"""


def caster(t, state):
    """Rates of the angle of the caster, of its rate and of the deflection of the tyre, by Fiala's force and moment."""
    angle, rate, y = state
    speed, sideways, slide = 12.0 * math.cos(angle), -12.0 * math.sin(angle) - 0.06 * rate, 3 * 0.8 * 4000.0

    def force(v):
        G = -3e4 * v / math.hypot(speed, 0.1)
        x = min(abs(G) / slide, 1.0)
        return math.copysign(slide / 3 * (3 * x - 3 * x * x + x**3), G), x

    def gap(y1):
        return force(sideways + y1)[0] - 1.5e5 * (y + CREEP * y1 / math.hypot(speed, 1.0))

    v = sideways + brentq(gap, -50.0, 50.0, xtol=1e-13)
    F, x = force(v)
    M = 0.05 / 3 * 3e4 * v * speed / (speed**2 + 0.01) * (1 - x) ** 3
    return [rate, (-0.06 * F + M - rate) / 0.418, v - sideways]


def test_a_kicked_caster_on_a_brush_tyre_falls_to_its_limit_cycle(verify):
    """Shimmy: trail, relaxation and sliding together."""
    recorded = RecordedRun(deck(CASTER))
    found, t = recorded["joints/caster/angle"].ravel(), recorded.time
    own = solve_ivp(caster, (0.0, 0.8), [0.0, 30.0, 0.0], t_eval=t, rtol=1e-8, atol=1e-10).y[0]
    verify("Tyres", "caster on a brush tyre, kicked, falls to its shimmy: angle [rad]", found, own,
           "independent integration", absolute=5e-4)  # fmt: skip
    assert 0.55 < found[t > 0.6].max() < 0.72 < found.max()  # the limit cycle, approached from outside: 0.577 rad

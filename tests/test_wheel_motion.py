"""Motions of a wheel on the ground: spin-up, bounces, order, energy, error against tolerance.

The spin-up times are those of an independent study of a wheel at touch-down (closed forms, and integration of the two
equations of motion by a Runge-Kutta method at 1e-12), with friction of Coulomb: here regularized friction in the limit.
"""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import BarycentricInterpolator
from time_runs import RecordedRun, deck, input_deck

from mecano.maths.so3 import log

# A wheel of radius 0.3725 m on which 60 kN rest rolls on a radius of 0.3225 m.
TOWED = """
    mecano: 1
    gravity: [0, 0, 0]
    nodes:
      fork: {{position: [0, 0, 0.3225]}}
      hub: {{position: [0, 0, 0.3225]}}
    elements:
      load: {{type: rigid_body, node: fork, mass: 6390, inertia: [10, 10, 10]}}
      rim: {{type: rigid_body, node: hub, mass: 50, inertia: [1.2, 2.0, 1.2]}}
      tire: {{type: wheel, node: hub, axis: [0, 1, 0], tire_law: linear, ground: runway}}
    joints:
      attitude: {{type: held_rotation, nodes: [ground, fork]}}
      bearing: {{type: hinge, nodes: [fork, hub], axis: [0, 1, 0]}}
      height: {{type: prescribed_position, node: fork, direction: [0, 0, 1], value: 0.0}}
      {tow}
    tire_laws:
      linear: {{radius: 0.3725, radial: {{linear: {{slope: 1.2e6}}}}, friction: 0.6, slip_regularization: {eps}}}
    grounds:
      runway: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}
    initial:
      velocities:
        - {{nodes: all, velocity: [60, 0, 0]}}
        - {{nodes: [hub], angular_velocity: [0, {spin}, 0]}}
    time: {{end: {end}, step: {step}, {control}}}
"""
TOW = "tow: {type: prescribed_position, node: fork, direction: [1, 0, 0], value: {linear: {slope: 60}}}"


def towed(eps, tow=TOW, spin=0.0, end=0.033, step=1e-5, control="adaptive: {tolerance: 1.0e-5}"):
    """Run a wheel pressed down by 60 kN, with its hub at 60 m/s."""
    return RecordedRun(deck(TOWED.format(eps=eps, tow=tow, spin=spin, end=end, step=step, control=control)))


def at_slip(recorded, eps, values):
    """``values`` when the slip velocity falls to ``eps`` [m/s]: the parabola through the last three steps before.

    Beyond, friction is regularized and the slip no longer a smooth function of time.
    """
    slip = recorded["elements/tire/longitudinal_slip"]
    last = slice(int(np.argmax(slip < eps)) - 3, int(np.argmax(slip < eps)))
    return float(BarycentricInterpolator(slip[last] - eps, values[last])(0.0))


def coulomb_limit(marches, values=lambda integrator: integrator.time):
    """Extrapolate a quantity linear in eps at the end of slip to eps = 0, from eps = 0.1 and 0.01."""
    coarse, fine = (at_slip(marches[eps], eps, values(marches[eps])) for eps in (0.1, 0.01))
    return fine + (fine - coarse) / 9.0


def test_spin_up_of_a_towed_wheel():
    """t = I V/(mu N r^2); the wheel takes half of the work of the tow, friction the other half, whatever eps is."""
    marches = {eps: towed(eps) for eps in (0.1, 0.01)}
    assert coulomb_limit(marches) == pytest.approx(0.03204935600825271, rel=1e-10)
    for recorded in marches.values():
        assert recorded["elements/tire/normal_force"] == pytest.approx(60000.0, rel=1e-9)
        assert recorded["elements/tire/spin_rate"][-1] == pytest.approx(186.04651162790697, rel=1e-7)
        assert recorded["energy/dissipated"][-1] == pytest.approx(34613.30448891293, rel=1e-7)
        assert recorded["energy/given"][-1] == pytest.approx(2 * 34613.30448891293, rel=1e-6)
    angle = coulomb_limit(marches, lambda recorded: recorded["joints/bearing/angle"])
    assert angle == pytest.approx(2.98133544262816, rel=1e-6)  # quadratic in eps beyond the extrapolation


def test_spin_up_under_a_free_mass():
    """6440 kg that are slowed down by the wheel they spin up."""
    marches = {eps: towed(eps, tow="") for eps in (0.1, 0.01)}
    assert coulomb_limit(marches) == pytest.approx(0.03195394265879875, rel=1e-10)
    for recorded in marches.values():
        assert recorded["nodes/fork/velocity"][-1, 0] == pytest.approx(59.82137547582038, rel=1e-9)
        assert recorded["elements/tire/spin_rate"][-1] == pytest.approx(185.49263713432677, rel=1e-7)
        assert recorded["energy/dissipated"][-1] == pytest.approx(34510.25807150263, rel=1e-7)


def test_spin_up_on_a_tyre_that_gives_way():
    """inputs/wheel_spin_up.yaml: arm and contact velocity use the current radius r0 - w."""
    control = "time.adaptive.tolerance=1e-6"
    marches = {
        eps: RecordedRun(input_deck("wheel_spin_up", control, f"tire_laws.linear.slip_regularization={eps}"))
        for eps in (0.1, 0.01)
    }

    def at_stick(path):
        return coulomb_limit(marches, lambda recorded: recorded[path])

    assert coulomb_limit(marches) == pytest.approx(0.04774233856997895, abs=1e-7)
    assert at_stick("elements/tire/spin_rate") == pytest.approx(233.14975469860212, rel=1e-6)
    assert at_stick("elements/tire/deformation") == pytest.approx(0.0651546724, abs=2e-7)
    assert at_stick("elements/tire/normal_force") == pytest.approx(78185.60689, abs=0.2)


SLIP_AFTER = {1: 0.0755081337596291, 2: 0.053788284273999024, 4: 0.02384058440442351, 8: 0.0035972419924183113}


def test_slip_dies_out_under_regularized_friction():
    """Slip 2 eps/(1 + exp(2 b t/eps)) after it has come down to eps = 0.1 m/s, b = mu N r^2/I; errors of order 2."""
    unit, errors = 1.3353898336771964e-05, []
    for n in (8, 16):
        recorded = towed(0.1, spin=(60.0 - 0.1) / 0.3225, end=8 * unit, step=unit / n, control="rho_inf: 0.8")
        slip = recorded["elements/tire/longitudinal_slip"]
        assert len(slip) == 8 * n + 1
        errors.append(max(abs(slip[n * i] - wanted) for i, wanted in SLIP_AFTER.items()))
    assert errors[1] < 1e-5
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.05)


class Bounces:
    """Closed form of inputs/wheel_drop.yaml on flat ground while the wheel slides."""

    m, inertia, r0, k, mu, g, drop, speed = 20.0, 1.0, 0.3, 2e5, 0.5, 9.81, 0.1, 20.0

    def __init__(self):
        self.p = math.sqrt(self.k / self.m)
        self.v = math.sqrt(2 * self.g * self.drop)
        self.fall = self.v / self.g
        self.contact = (2 * math.pi - 2 * math.atan(self.v * self.p / self.g)) / self.p
        self.period = 2 * self.fall + self.contact

    def touch_down(self, n):
        """Time of the n-th touch-down, from 0 [s]."""
        return self.fall + n * self.period

    def deformation(self, t):
        """w [m] and its rate, t after the touch-down."""
        c, s = math.cos(self.p * t), math.sin(self.p * t)
        g, v, p = self.g, self.v, self.p
        return g / p**2 * (1 - c) + v / p * s, g / p * s + v * c

    def impulse(self, t):
        """Of the normal force [N s], t after the touch-down."""
        return self.m * (self.v + self.g * t - self.deformation(t)[1])

    def spin(self, t):
        """Gain of angular velocity [rad/s], t after the touch-down."""
        squared = quad(lambda u: self.deformation(u)[0] ** 2, 0.0, t, epsabs=1e-15, epsrel=1e-12)[0]
        return self.mu / self.inertia * (self.r0 * self.impulse(t) - self.k * squared)

    def after_one(self, t):
        """x, z, angle of the wheel at the time t, between the first lift-off and the second touch-down."""
        T, free = self.contact, t - self.fall - self.contact
        lost = self.mu * (self.v * T + 0.5 * self.g * T**2)  # the integral of w' is zero over the contact
        loss = self.mu * self.impulse(T) / self.m
        turned = quad(self.spin, 0.0, T, epsabs=1e-13, epsrel=1e-11)[0]
        x = self.speed * t - lost - loss * free
        return x, self.r0 + self.v * free - 0.5 * self.g * free**2, turned + self.spin(T) * free


def test_bounces_of_a_sliding_wheel():
    """Times, heights, loss of speed and spin of three bounces in closed form."""
    exact = Bounces()
    recorded = RecordedRun(input_deck("wheel_drop", "time.adaptive.tolerance=1e-6"))
    assert [h.name for h in recorded.event_records] == ["touch_down", "lift_off"] * 3
    for n in range(3):
        down, up = recorded.event_records[2 * n : 2 * n + 2]
        # the first fall is a parabola, which the method solves exactly
        assert down.t == pytest.approx(exact.touch_down(n), abs=1e-9 if n == 0 else 1e-7)
        assert up.t == pytest.approx(exact.touch_down(n) + exact.contact, abs=1e-7)
    loss = 3 * exact.mu * exact.impulse(exact.contact) / exact.m
    assert recorded["nodes/hub/velocity"][-1, 0] == pytest.approx(exact.speed - loss, abs=1e-6)
    assert recorded["elements/tire/spin_rate"][-1] == pytest.approx(3 * exact.spin(exact.contact), abs=1e-5)
    w = exact.g / exact.p**2 + math.hypot(exact.g / exact.p**2, exact.v / exact.p)
    assert recorded["elements/tire/deformation"].max() == pytest.approx(w, rel=1e-5)
    assert recorded["nodes/hub/position"][-1, 2] == pytest.approx(
        0.4 - 0.5 * exact.g * (1.0 - 3 * exact.period) ** 2, abs=1e-6
    )


def pose(recorded):
    """x, z and angle of the wheel at the end; it has turned by less than half a turn."""
    x, R = recorded.run.motion.z[:3], recorded.run.motion.R[-1]
    return np.array([x[0], x[2], log(tuple(map(tuple, R)))[1]])


def test_error_follows_the_tolerance():
    """Largest error of position (over the length scale of 1 m) and angle at the end, with two events on the way."""
    exact, end = Bounces(), 0.3
    wanted, errors = np.array(exact.after_one(end)), []
    tolerances = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7]
    for tolerance in tolerances:
        recorded = RecordedRun(input_deck("wheel_drop", f"time.end={end}", f"time.adaptive.tolerance={tolerance}"))
        assert len(recorded.event_records) == 2
        errors.append(np.abs(pose(recorded) - wanted).max())
    assert all(fine < coarse for coarse, fine in zip(errors, errors[1:], strict=False))
    assert all(error < 10 * tolerance for error, tolerance in zip(errors, tolerances, strict=True))
    assert errors[-1] > 1e-3 * tolerances[-1]  # steps far more accurate than asked would be a waste


SMOOTH = (
    "tire_laws.rubber.friction={exponential: {start: 0.8, limit: 0.3, rate: 0.05}}",
    "tire_laws.rubber.radial={polynomial: {coefficients: [0, 1.0e5, 5.0e6]}}",
    "tire_laws.rubber.radial_damping=0.1",
)


@pytest.mark.parametrize("waves", [0.0, 0.02], ids=["flat", "waves"])
def test_second_order_and_energy_across_events(waves):
    """Fall, touch-down, contact with damping and falling friction, lift-off, flight, at h, h/2, h/4 against h/16."""
    ends, leaks = [], []
    for n in (300, 600, 1200, 4800):
        recorded = RecordedRun(
            input_deck(
                "wheel_drop", *SMOOTH, f"parameters.wave_amplitude={waves}", f"time={{end: 0.3, step: {0.3 / n}}}"
            )
        )
        assert [h.name for h in recorded.event_records] == ["touch_down", "lift_off"]
        velocity = recorded["nodes/hub/velocity"][-1, [0, 2]]
        ends.append(np.r_[pose(recorded), 0.1 * velocity, 0.1 * recorded["elements/tire/spin_rate"][-1]])
        leaks.append(np.ptp(recorded["energy/balance"]))
    errors = [np.linalg.norm(end - ends[-1]) for end in ends[:3]]
    for coarse, fine in ((0, 1), (1, 2)):
        exact_order = 4.0 if coarse == 0 else 4.0 * (1 - 1 / 64) / (1 - 1 / 16)
        assert errors[coarse] / errors[fine] == pytest.approx(exact_order, abs=0.5)
        assert leaks[coarse] / leaks[fine] == pytest.approx(4.0, abs=0.1)
    assert leaks[2] < 1e-3 * recorded["energy/dissipated"][-1]

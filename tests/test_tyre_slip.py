"""Sliding tyres: rates of a massless patch are unique, an independent integration, the twist in rolling."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from time_runs import RecordedRun
from towed_wheel import (
    ANGLE,
    CORNERING,
    DAMPING,
    DOWN,
    LAWS,
    MORELAND,
    RADIUS,
    RELAXATION,
    SIGMA,
    SINK,
    SPEED,
    SPIN_INERTIA,
    towed,
)

from mecano.analyses.prepare import prepare


@pytest.mark.parametrize("law", [name for name in LAWS if name != "string"])
def test_a_patch_rolls_backward_as_forward(law):
    """A wheel does not know the sign of its axis: the same landing, turned by half a turn about the normal."""
    ahead, astern = (
        RecordedRun(towed(LAWS[law], lean=lean, end=0.1, tolerance=1e-4, angle=angle, spin=spin))
        for lean, angle, spin in ((2.0, 0.02, 130.0), (-2.0, 0.02 + np.pi, -130.0))
    )
    force, turned = (run["elements/tire/contact_force"][-1] for run in (ahead, astern))
    assert 1e3 < np.abs(force[1]) < 0.2 * force[2]  # far below friction
    np.testing.assert_allclose(turned, force * [-1, -1, 1], atol=1e-6 * np.abs(force).max())
    moment, other = (run["elements/tire/aligning_moment"][-1] for run in (ahead, astern))
    np.testing.assert_allclose(other, moment, atol=1e-6 * np.abs(force).max())


@pytest.mark.parametrize("law", LAWS)
def test_rates_of_the_patch_are_unique(law):
    """The forces along y and psi never fall with dy/dt and dpsi/dt, sliding or not: they are monotone, leaning or not.

    Friction falls with the slip speed, and radial damping acts: neither may push the patch along by its own rates.
    """
    rng, system = np.random.default_rng(5), prepare(towed(LAWS[law], lean=4.0)).system
    names, least = system.numbering.name, []
    hub, y = names.index("node carriage, hub: force x"), names.index("flexible_wheel 'tire': y")
    own = [y, names.index("flexible_wheel 'tire': psi")]
    for _ in range(200):
        s = system.initial_state(0.0)
        for batch in system.batches:
            s.phases[batch.phases] = min(1, len(batch.kind.phases) - 1)
        s.z[hub + 2] = 0.452 - rng.uniform(0.01, 0.1)
        s.z[own] = rng.uniform(-0.08, 0.08), rng.uniform(-0.2, 0.2)
        s.v[hub : hub + 3] = rng.uniform(0.0, 70.0), rng.uniform(-7.0, 7.0), rng.uniform(-2.0, 2.0)
        s.v[hub + 4] = rng.uniform(0.0, 200.0)
        s.v[own] = rng.uniform(-20.0, 20.0, 2) * 10.0 ** rng.uniform(-3.0, 0.0)
        C = np.zeros((system.n + 1, system.n + 1))
        np.add.at(C, (system.rows, system.cols), system.assemble(s, cC=1.0).data[: system.nnz])
        block = C[np.ix_(own, own)]
        if block[1, 0] and block[1, 1] == 0.0:  # without a rate of psi it is M = 0 that settles psi
            block = block[:1, :1]
        least.append(np.linalg.eigvalsh(block + block.T)[0] / max(np.abs(block).max(), 1.0))
    assert min(least) > -1e-9


def planar(end):
    """(t, y, spin) of the upright wheel with a relaxation length, from its own equations, by Radau's method.

    Unknowns are y and the spin; dy/dt solves K y = F_y - psi F_x, with psi = y/sigma, at every time. A tiny damping (1
    N s/m) keeps dy/dt unique where the patch slides.
    """
    K, vx, vy = CORNERING / SIGMA, SPEED * np.cos(ANGLE), SPEED * np.sin(ANGLE)

    def height(t):
        return 0.452 - 0.08 * min(t / DOWN, 1.0), -SINK if t < DOWN else 0.0

    def friction(y1, t, y, spin):
        (r, sink), psi = height(t), y / SIGMA
        w = RADIUS - r
        load = (7e5 * w + 2e6 * w * w) * max(0.0, 1.0 - DAMPING * sink) if w > 0.0 else 0.0
        held = np.array([vx - spin * r, vy - psi * spin * r])
        v = held + y1 * np.array([psi, -1.0])
        slip = np.hypot(*v)
        factor = 1.0 / slip if slip > 0.1 else (2.0 - slip / 0.1) / 0.1
        return (0.5 + 0.3 * np.exp(-0.03 * np.hypot(*held))) * factor * load * v, r, psi

    def unbalanced(y1, t, y, spin):
        (Fx, Fy), _, psi = friction(y1, t, y, spin)
        return K * y + y1 - (Fy - psi * Fx)

    def rates(t, state):
        y, spin = state
        if height(t)[0] >= RADIUS:
            return [0.0, 0.0]
        y1 = brentq(unbalanced, -1e5, 1e5, (t, y, spin), xtol=1e-12, rtol=1e-14, maxiter=300)
        (Fx, Fy), r, psi = friction(y1, t, y, spin)
        return [y1, r * (Fx + psi * Fy) / SPIN_INERTIA]

    parts, state, start = [], np.zeros(2), 0.0
    for stop in (0.001, DOWN, end):  # the rim touches, the way down ends
        part = solve_ivp(rates, (start, stop), state, "Radau", rtol=1e-8, atol=1e-10)
        parts.append((part.t, *part.y))
        start, state = stop, part.y[:, -1]
    return np.hstack(parts)


def test_a_landing_at_a_slip_angle_against_an_independent_integration():
    """Spin-up with friction that falls, sliding at 6 degrees, then rolling at the limit of adhesion."""
    recorded = RecordedRun(towed(RELAXATION, end=0.2, tolerance=1e-5))
    t, y, spin = planar(0.2)
    found_y, found_spin = (
        np.interp(t, recorded.time, recorded[f"elements/tire/{what}"].ravel()) for what in ("y", "spin_rate")
    )
    assert np.abs(y).max() > 0.03 and spin.max() > 150.0  # it has slid to the side, and has been spun up
    assert np.abs(found_y - y).max() < 1e-3 * np.abs(y).max()
    assert np.abs(found_spin - spin).max() < 1e-3 * spin.max()


@pytest.mark.parametrize("angle", [0.002, 0.02])
@pytest.mark.parametrize("law", ["relaxation", "straight_tangent"])
def test_a_wheel_that_rolls_lands_at_a_small_slip_angle(law, angle):
    """It sticks from the touch-down on, in the ratio of both forces that grow from zero; rolling, F = C tan(alpha).

    The regularized contact creeps with v, where phi(v) mu N = F, and so reduces alpha: tan(alpha) = (v_y - v)/v_x.
    The terms of psi^2, by which the patch turns the force, are neglected.
    """
    recorded = RecordedRun(towed(LAWS[law], end=0.1, tolerance=1e-4, angle=angle, spin=SPEED / RADIUS))
    normal = recorded["elements/tire/contact_force"][-1][2]
    v_x, v_y = SPEED * np.cos(angle), SPEED * np.sin(angle)
    grip = (0.5 + 0.3 * np.exp(-0.03 * v_y)) * normal
    creep = brentq(lambda v: 10.0 * v * (2.0 - 10.0 * v) * grip - CORNERING * (v_y - v) / v_x, 0.0, 0.1)
    force = CORNERING * (v_y - creep) / v_x
    assert -recorded["elements/tire/contact_force"][-1][1] == pytest.approx(force, rel=1e-4 + angle**2)


@pytest.mark.parametrize("law", [name for name in LAWS if name != "moreland without rates"])
@pytest.mark.parametrize("lean", [0.0, 4.0])
def test_every_law_lands_at_a_slip_angle(law, lean):
    """Down and up again: its force is within friction, and the budget closes to 1e-4 of what friction takes."""
    recorded = RecordedRun(towed(LAWS[law], lean=lean, end=0.2, tolerance=1e-4, led="down and up"))
    assert [h.name for h in recorded.event_records] == ["touch_down", "lift_off"]
    deformed, N = recorded["elements/tire/y"].ravel(), recorded["elements/tire/normal_force"].ravel()
    side, ahead = (recorded[f"elements/tire/{way}_force"].ravel() for way in ("lateral", "longitudinal"))
    assert np.all(np.hypot(side, ahead) <= 0.8 * N + 1e-6 * N.max())
    assert np.abs(deformed).max() < 0.2
    balance, lost = recorded["energy/balance"].ravel(), recorded["energy/dissipated"].ravel()
    assert np.ptp(balance) < 1e-4 * np.ptp(lost)


@pytest.mark.parametrize(("share", "lasts"), [(0.5, True), (2.0, False)])
def test_the_twist_of_a_rolling_patch_needs_damping(share, lasts):
    """C1 > V C K I y^2/(r^2 kap): by Routh's criterion for y, psi and the spin of a wheel that rolls at a slip angle.

    dy = -V psi, y dpsi = r spin, I dspin = r kap (C K y - psi - C1 dpsi)/y about y = slip angle/(C K).
    """
    angle, kap, r = 0.05, 2e4, 0.372
    y, C_K = angle * SIGMA, 1.0 / SIGMA
    needed = SPEED * C_K * SPIN_INERTIA * y * y / (r * r * kap)
    law = MORELAND % (0.0, share * needed, kap)
    recorded = RecordedRun(towed(law, end=0.14, angle=angle, spin=SPEED / r))
    spin, t = recorded["elements/tire/spin_rate"].ravel(), recorded.time
    early, late = (np.ptp(spin[(t > a) & (t < a + 0.02)]) for a in (0.08, 0.12))
    assert late > 0.9 * early > 1.0 if lasts else late < 0.5 * early  # a limit cycle of stick and slip, or a decay

"""Shimmy of a trailing wheel with free play in its torque link: the limit cycle of inputs/shimmy_freeplay.yaml."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from time_runs import RecordedRun, input_deck

INERTIA, DAMPING, LINK, PLAY, TRAIL = 1.0, 10.0, 5.0e4, 2.0e-3, 0.1
SIDE, YAW, YAW_TIME = 2.0e5, 1 / 6e4, 1.0e-3  # K, C, C1 of Moreland's tyre

# speed [m/s] -> amplitude [mrad]: by the equations of motion, of the describing function (docs/tyre-equations.md)
TABLE = {5.0: (2.470, 2.423), 20.0: (4.146, 4.093), 40.0: (7.094, 7.109), 60.0: (5.125, 5.264)}


def growth(V, stiffness):
    """Largest growth rate of small motions with a link of the given stiffness, and the frequency."""
    left = np.polymul([INERTIA, DAMPING, stiffness], [YAW_TIME, 1.0, V * YAW * SIDE])
    right = TRAIL * SIDE * np.polymul([TRAIL, V], [YAW_TIME, 1.0])
    found = np.roots(np.polyadd(left, right))
    worst = found[np.argmax(found.real)]
    return worst.real, abs(worst.imag)


def describing_function(V):
    """Amplitude and frequency at which the link with its play is as stiff as at the border of stability."""
    stiffness = brentq(lambda k: growth(V, k)[0], 0.0, LINK)
    share = brentq(lambda p: 1 - 2 / np.pi * (np.arcsin(p) + p * np.sqrt(1 - p * p)) - stiffness / LINK, 1e-9, 1.0)
    return PLAY / share, growth(V, stiffness)[1]


def integrated(V, end=2.5):
    """Amplitude and frequency of the last half second of the four equations of motion."""

    def rate(t, state):
        angle, spin, y, psi = state  # y to the left
        moment = LINK * np.sign(angle) * max(abs(angle) - PLAY, 0.0)
        swing = (-DAMPING * spin - moment - TRAIL * SIDE * y) / INERTIA
        return [spin, swing, V * (angle + psi) + TRAIL * spin, (-YAW * SIDE * y - psi) / YAW_TIME]

    times = np.linspace(end - 0.5, end, 50001)
    found = solve_ivp(rate, (0.0, end), [0.0, 0.3, 0.0, 0.0], rtol=1e-9, atol=1e-12, max_step=1e-3, t_eval=times)
    return cycle(times, found.y[0])


def cycle(time, angle):
    """Amplitude and angular frequency of an oscillation."""
    peaks = np.flatnonzero((angle[1:-1] > angle[:-2]) & (angle[1:-1] >= angle[2:])) + 1
    return angle[peaks].max(), 2 * np.pi * (len(peaks) - 1) / np.ptp(time[peaks])


def run_at(V, *overrides):
    recorded = RecordedRun(
        input_deck("shimmy_freeplay", f"parameters.speed={V!r}", f"parameters.spin={V / 0.3!r}", *overrides)
    )
    late = recorded.time > recorded.time[-1] - 0.5
    return cycle(recorded.time[late], recorded["joints/caster/angle"][late])


def test_the_describing_function_is_near_the_motion():
    """Check the table in docs/tyre-equations.md and the header of the deck without a run."""
    for V, (_, amplitude) in TABLE.items():
        assert describing_function(V)[0] == pytest.approx(1e-3 * amplitude, rel=1e-3)
    assert integrated(20.0) == pytest.approx((4.146e-3, 150.53), rel=1e-3)
    assert growth(1.56, 0.0)[0] < 0.0 < growth(1.57, 0.0)[0] and growth(73.3, 0.0)[0] > 0.0 > growth(73.4, 0.0)[0]


@pytest.mark.slow
def test_limit_cycle_at_twenty_metres_per_second():
    """Against the equations: within 0.05 % with the deck's tolerance, 0.02 % with less than half of it."""
    assert run_at(20.0) == pytest.approx((4.146e-3, 150.53), rel=5e-4)
    assert run_at(20.0, "time.adaptive.tolerance=1e-4")[0] == pytest.approx(4.146e-3, rel=2e-4)


@pytest.mark.slow
def test_amplitude_against_speed():
    for V, (amplitude, _) in TABLE.items():
        assert run_at(V, "time={end: 4, step: 1.0e-3}")[0] == pytest.approx(1e-3 * amplitude, rel=7e-3)

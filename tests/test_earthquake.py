"""Motion from a measured acceleration: the law by hand, and the response of a building by matrix exponentials."""

import numpy as np
import pytest
from scipy.signal import StateSpace, lsim
from time_runs import INPUTS, RecordedRun, input_deck

from mecano.laws.probe import curve_at

POINTS = [[1.0, 0.0], [2.0, 6.0], [4.0, 0.0]]
MASS, STIFFNESS, DAMPING = 20e3, 9e6, 60e3
PEAK = 0.066716  # m, of the upper floor relative to the ground


def law(**more):
    given = {"points": POINTS, "factor": 1.0, "initial_rate": 0.0, "baseline": "as_given", **more}
    return (("acceleration", given),)


@pytest.mark.parametrize(
    ("t", "expected"),
    [(0.0, (0, 0, 0)), (1.5, (0.125, 0.75, 3)), (2.0, (1, 3, 6)), (4.0, (15, 9, 0)), (5.0, (24, 9, 0))],
)
def test_it_is_integrated_twice(t, expected):
    """y = t^3 and 6 (t^2/2 - t^3/12) after the start and the peak, by hand."""
    np.testing.assert_allclose(curve_at(law(), t), expected, rtol=1e-14, atol=1e-14)


def test_factor_and_rate():
    y, rate, acceleration = curve_at(law(factor=9.80665, initial_rate=-2.0), 2.0)
    assert (y, rate, acceleration) == pytest.approx((9.80665 - 2.0, 3 * 9.80665 - 2.0, 6 * 9.80665), rel=1e-14)


def test_a_corrected_motion_ends_at_rest():
    law_ = law(baseline="end_at_rest")
    np.testing.assert_allclose(curve_at(law_, 4.0)[:2], 0.0, atol=1e-13)
    drift = [curve_at(law_, t)[2] - curve_at(law(), t)[2] for t in (1.2, 2.2, 3.2)]
    assert drift[2] - drift[1] == pytest.approx(drift[1] - drift[0], rel=1e-12) and drift[0] != drift[1]


def corrected():
    """Times and accelerations of the ground, less the line that leaves no velocity and no displacement."""
    t, a = np.loadtxt(INPUTS / "ground_motion.csv", delimiter=",", skiprows=2).T
    a = 9.80665 * a
    ends = [_ends(t, column) for column in (np.ones_like(t), t, a)]
    c = np.linalg.solve(np.array(ends[:2]).T, ends[2])
    return t, a - c[0] - c[1] * t


def _ends(t, a):
    """Velocity and displacement at the last point, by Simpson's rule, which is exact for each piece."""
    h, middle = np.diff(t), (a[1:] + a[:-1]) / 2
    weighted = [(t[-1] - t[:-1]) * a[:-1], (t[-1] - (t[:-1] + t[1:]) / 2) * middle, (t[-1] - t[1:]) * a[1:]]
    return [np.sum(h * middle), np.sum(h * (weighted[0] + 4 * weighted[1] + weighted[2])) / 6]


def test_a_building_in_an_earthquake():
    """Relative displacements; measured 0.36 % of the largest at steps of 5 ms, a quarter of it at half the step."""
    K, C = (np.array([[2 * c, -c], [-c, c]]) / MASS for c in (STIFFNESS, DAMPING))
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-K, -C]])
    system = StateSpace(A, np.array([[0], [0], [-1.0], [-1.0]]), np.eye(4), np.zeros((4, 1)))
    t, a = corrected()
    fine = np.linspace(0, 12, 12 * 1000 + 1)
    _, exact, _ = lsim(system, np.interp(fine, t, a), fine)
    errors = []
    for step in (5e-3, 2.5e-3):
        m = RecordedRun(input_deck("earthquake", "time.end=12", f"time.step={step}"))
        top = m["joints/storey_1/displacement"] + m["joints/storey_2/displacement"]
        errors.append(np.abs(top - np.interp(m.time, fine, exact[:, 1])).max())
    assert np.abs(exact[:, 1]).max() == pytest.approx(PEAK, abs=1e-6)
    assert errors[0] < 4e-3 * PEAK and 3.5 < errors[0] / errors[1] < 4.5

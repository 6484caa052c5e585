"""Flutter of a wing section: the air as formulas of the motion, the lag of the wake as a transfer function."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve
from scipy.special import hankel2
from time_runs import INPUTS, RecordedRun, input_deck

from mecano.analyses.sweep import sweep

B, RHO, A = 0.5, 1.225, -0.2  # half chord [m], density [kg/m3], place of the axis
AIR = np.pi * RHO * B**2
MASS = 20.0 * AIR
INERTIA = 0.24 * MASS * B**2
COUPLING = 0.1 * B * MASS - A * B * AIR
M = np.array([[MASS + AIR, COUPLING], [COUPLING, INERTIA + AIR * B**2 * (0.125 + A**2)]])
K = np.diag([MASS * 16.0**2, INERTIA * 40.0**2])
DOWNWASH = B * (0.5 - A)  # distance of the place of the downwash from the axis [m]


def generalized(circulation, turning):
    """Return the force along the plunge and the moment of the lift."""
    return np.array([-circulation - turning, B * ((0.5 + A) * circulation - (0.5 - A) * turning)])


def equations(speed):
    """Return (A, b) of x' = A x + b gust of (plunge, pitch, their rates, states of Jones' approximation)."""
    matrix, unit = np.zeros((6, 6)), np.eye(6)
    slow, fast = 0.01365 * (speed / B) ** 2, 0.3455 * speed / B
    downwash = speed * unit[1] + unit[2] + DOWNWASH * unit[3]
    effective = 0.5 * downwash + 0.5 * slow * unit[4] + (0.2808 * speed / B - 0.5 * fast) * unit[5]
    lift = 2.0 * np.pi * RHO * speed * B
    forces = generalized(lift * effective, AIR * speed * unit[3])
    forces[:, :2] -= K
    matrix[0, 2] = matrix[1, 3] = matrix[4, 5] = 1.0
    matrix[2:4] = np.linalg.solve(M, forces)
    matrix[5] = downwash - slow * unit[4] - fast * unit[5]
    of_gust = np.zeros(6)
    of_gust[2:4], of_gust[5] = np.linalg.solve(M, generalized(0.5 * lift, 0.0)), 1.0
    return matrix, of_gust


def growth(speed):
    """Return the largest growth of an oscillation [1/s]."""
    return max(value.real for value in np.linalg.eigvals(equations(speed)[0]) if abs(value.imag) > 1.0)


def theodorsen(x):
    """Return the determinant (real, imaginary part) of the section at a frequency [rad/s] and a speed [m/s]."""
    frequency, speed = x
    first, zeroth = (hankel2(n, frequency * B / speed) for n in (1, 0))
    s = 1j * frequency
    downwash = np.array([s, speed + DOWNWASH * s])
    circulation = 2.0 * np.pi * RHO * speed * B * first / (first + 1j * zeroth) * downwash
    found = np.linalg.det(s * s * M + K - generalized(circulation, AIR * speed * s * np.array([0.0, 1.0])))
    return [found.real / np.linalg.det(K), found.imag / np.linalg.det(K)]


def test_the_flutter_speed_and_the_divergence_speed(verify):
    """The speed of Theodorsen's function is that given in the deck, 0.6 % above that of Jones' approximation."""
    (locus,) = sweep(INPUTS / "flutter.yaml", (), ["speed=20:60:4"]).loci
    flutter, divergence = (one.place for one in locus.critical)
    verify("Modes", "wing section in air: flutter speed [m/s]", flutter, brentq(growth, 40.0, 50.0, xtol=1e-12),
           "eigenvalues of the equations of Theodorsen with the lag of Jones, NumPy", relative=1e-9)  # fmt: skip
    known = 40.0 * B * np.sqrt(0.24 * 20.0 / (1.0 + 2.0 * A))
    verify("Modes", "wing section in air: divergence speed [m/s]", divergence, known, "closed form", relative=1e-9)
    exact = fsolve(theodorsen, [26.0, 43.0])[1]
    assert flutter == pytest.approx(exact, rel=7e-3)
    text = (INPUTS / "flutter.yaml").read_text()
    assert all(f"{speed:.3f} m/s" in text for speed in (flutter, exact, divergence))


def test_the_oscillation_after_a_gust_grows(verify):
    """By 2 mm and 0.2 deg, which are small enough for linear equations."""
    matrix, of_gust = equations(44.0)

    def smooth(t, start):
        u = np.clip((t - start) / 0.05, 0.0, 1.0)
        return u**3 * (10.0 - 15.0 * u + 6.0 * u**2)

    rate = lambda t, x: matrix @ x + of_gust * 0.02 * (smooth(t, 0.0) - smooth(t, 0.1))  # noqa: E731
    known = solve_ivp(rate, (0.0, 3.0), np.zeros(6), method="DOP853", rtol=1e-11, atol=1e-14, max_step=0.01).y[:2, -1]
    found = []
    for step in ("1e-3", "5e-4"):
        m = RecordedRun(input_deck("flutter", f"time.step={step}"))
        found.append(np.array([m["joints/plunge/displacement"][-1], m["joints/pitch/angle"][-1]]))
    what = "wing section slightly above its flutter speed, 3 s after a gust: plunge [m] and pitch [rad]"
    verify.second_order("Control", what, *found, known, 5e-7, "SciPy")

"""Error against tolerance and work: `python tests/work_precision.py` prints the numbers of docs/step-control.md."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from linkage import FourBar
from scipy.integrate import quad, solve_ivp
from test_wheel_motion import Bounces
from time_runs import RecordedRun, input_deck


@cache
def heavy_top(end):
    """State (12,) of the heavy top as a function of time, R by rows and the angular velocity: Euler's equations."""
    J, arm, weight = np.array([15.234375, 0.46875, 15.234375]), np.array([0.0, 1.0, 0.0]), np.array([0, 0, -147.15])

    def rate(t, y):
        R, w = y[:9].reshape(3, 3), y[9:]
        spin = np.cross(w, R)  # rows of dR/dt = R hat(w) are those of R turned by w
        return np.concatenate([-spin.ravel(), (np.cross(J * w, w) + np.cross(arm, R.T @ weight)) / J])

    start = np.concatenate([np.eye(3).ravel(), [0.0, 150.0, -4.61538]])
    return solve_ivp(rate, (0.0, end), start, method="DOP853", rtol=1e-11, atol=1e-12, dense_output=True).sol


def some(recorded):
    """About 2000 of the accepted steps, the last one among them."""
    return np.linspace(0, len(recorded.time) - 1, min(len(recorded.time), 2000)).astype(int)


def four_bar_error(recorded):
    """Of the crank angle, which turns most [rad]; largest over the run."""
    at = some(recorded)
    return np.abs(recorded["joints/hinge_a/angle"][at] - FourBar().motion(recorded.time[at])[:, 0]).max()


def heavy_top_error(recorded):
    """Of the centre of mass over the length scale of 1 m; largest over the run."""
    at = some(recorded)
    exact = heavy_top(recorded.time[-1])(recorded.time[at])[[1, 4, 7]].T
    return np.linalg.norm(recorded["elements/top/center_of_mass"][at] - exact, axis=1).max()


def wheel_at(bounces, n, t):
    """x, z and angle of the dropped wheel in closed form at ``t``, in flight after ``n`` bounces."""
    T, speed, spin = bounces.contact, bounces.speed, 0.0
    x, angle, now = speed * bounces.fall, 0.0, bounces.fall
    turned = quad(bounces.spin, 0.0, T, epsabs=1e-13, epsrel=1e-11)[0]
    for bounce in range(n):
        x += speed * T - bounces.mu * (bounces.v * T + 0.5 * bounces.g * T**2)
        angle += spin * T + turned
        speed -= bounces.mu * bounces.impulse(T) / bounces.m
        spin += bounces.spin(T)
        flight = 2 * bounces.fall if bounce < n - 1 else t - now - T
        now += T + flight
        x, angle = x + speed * flight, angle + spin * flight
    return np.array([x, bounces.r0 + bounces.v * flight - 0.5 * bounces.g * flight**2, angle])


def wheel_error(recorded):
    """Of position (over the length scale of 1 m) and angle [rad] at the end, after three bounces."""
    x, z, angle = wheel_at(Bounces(), 3, recorded.time[-1])
    w, _, y, _ = recorded["nodes/hub/rotation"][-1]
    turn = np.angle(complex(w, y) ** 2 * np.exp(-1j * angle))
    position = recorded["nodes/hub/position"][-1]
    return max(abs(position[0] - x), abs(position[2] - z), abs(turn))


@dataclass(frozen=True)
class Case:
    """A deck, how wrong it is, the end [s], its first step and fixed steps for comparison."""

    error: object
    end: float
    step: float
    fixed: tuple


CASES = {
    "four_bar": Case(four_bar_error, 3.0, 1e-3, (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4)),
    "heavy_top": Case(heavy_top_error, 2.0, 1e-4, (1e-3, 5e-4, 2.5e-4, 1.25e-4, 6.25e-5)),
    "wheel_drop": Case(wheel_error, 1.0, 1e-3, (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4)),
}


def adaptive(name, tolerance, method="generalized_alpha", end=None):
    """Return (RecordedRun, error) of a deck with error control, up to ``end`` [s] if it is given."""
    case = CASES[name]
    end = end or case.end
    control = f"time={{end: {end}, step: {case.step}, method: {method}, adaptive: {{tolerance: {tolerance}}}}}"
    recorded = RecordedRun(input_deck(name, control))
    return recorded, case.error(recorded)


def fixed(name, h):
    """Return (RecordedRun, error) of a deck with fixed steps."""
    recorded = RecordedRun(input_deck(name, f"time={{end: {CASES[name].end}, step: {h}}}"))
    return recorded, CASES[name].error(recorded)


def main():
    """Print one table for each deck."""
    for name, case in CASES.items():
        print(f"### {name}.yaml, {case.end:g} s\n")
        print("| tolerance | step | accepted | rejected | error | error/tolerance |")
        print("|---|---|---|---|---|---|")
        for tolerance in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7):
            recorded, error = adaptive(name, tolerance)
            run, h = recorded.run, np.diff(recorded.time)
            share = 100 * run.rejected / (run.steps + run.rejected)
            print(
                f"| {tolerance:.0e} | {h.min():.1e} to {h.max():.1e} s | {run.steps} | {run.rejected} ({share:.1f} %) "
                f"| {error:.2e} | {error / tolerance:.2f} |"
            )
        for h in case.fixed:
            recorded, error = fixed(name, h)
            print(f"| fixed | {h:.2e} s | {recorded.run.steps} | 0 | {error:.2e} | |")
        print()


if __name__ == "__main__":
    main()

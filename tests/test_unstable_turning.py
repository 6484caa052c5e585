"""Masses on rigid arms gain energy in fixed steps that turn them too far for rho_inf: the limit, and the warning."""

import numpy as np
import pytest
from scipy.optimize import fsolve
from time_runs import RecordedRun, deck

import mecano
from mecano.analyses.circle_accuracy import STABLE
from mecano.errors import ConvergenceError

ARM = """
    mecano: 1
    gravity: none
    nodes: {pivot: {position: [0, 0, 0]}, weight: {position: [1, 0, 0]}}
    elements: {arm: {type: rigid_body, node: weight, attached: [pivot], mass: 5, inertia: [1.0e-3, 1.0e-3, 1.0e-3]}}
    joints: {hub: {type: hinge, nodes: [ground, pivot], axis: [0, 0, 1]}}
    initial: {velocities: [{nodes: [weight], velocity: [0, 1, 0], angular_velocity: [0, 0, 1], about: own}]}
    time: {end: END, step: STEP, rho_inf: RHO}
"""
BLADE = """
    mecano: 1
    gravity: none
    sections: {rod: {type: circle, E: 2.0e+11, nu: 0.3, density: 7800, diameter: 0.05}}
    nodes: {root: {position: [0, 0, 0]}, tip: {position: [1, 0, 0]}}
    elements: {blade: {type: beam, nodes: [root, tip], section: rod, mesh: 2}}
    joints: {hub: {type: hinge, nodes: [ground, root], axis: [0, 0, 1]}}
    initial:
      velocities:
      - {nodes: [root, blade.1, tip], velocity: [0, 0, 0], angular_velocity: [0, 0, 10], about: [0, 0, 0]}
    time: {end: 20, step: 0.03, rho_inf: 0.8}
"""


def limit(rho):
    """Largest angle of a step."""
    return STABLE * (1.0 - rho) / (1.0 + rho)


@pytest.mark.parametrize("rho", [0.5, 0.8, 0.9])
def test_the_limit_is_that_of_the_method_for_a_point_on_a_circle(rho):
    """The alternating eigenvalues of one step of the formulas of Chung & Hulbert (1993), written down again here.

    The step is linearized about steady motion of a point at x = (1, 0), in axes that turn with it.
    """
    am, af = (2 * rho - 1) / (1 + rho), rho / (1 + rho)
    gamma, beta = 0.5 + af - am, 0.25 * (1 + af - am) ** 2

    def step(y):
        x, v, a, second = y.reshape(4, 2)
        carried = (af * second - am * a) / (1 - am)
        place = x + v + (0.5 - beta) * a + beta * carried  # but for the reaction, which acts along the new place
        size, share = np.linalg.norm(place), (1 - af) / (1 - am)
        new = -(size - 1) / (beta * share) * place / size
        a_1 = share * new + carried
        return np.concatenate([place / size, v + (1 - gamma) * a + gamma * a_1, a_1, new])

    def largest(angle):
        back = np.kron(np.eye(4), [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        steady = fsolve(
            lambda z: (back @ step(np.array([1, 0, *z[:4], -z[4], 0])))[2:7] - [*z[:4], -z[4]],
            [0, angle, -(angle**2), 0, angle**2], xtol=1e-12,
        )  # fmt: skip
        y = np.array([1, 0, *steady[:4], -steady[4], 0])
        columns = [back @ (step(y + d) - step(y - d)) / 2e-6 for d in 1e-6 * np.eye(8)]
        found = np.linalg.eigvals(np.array(columns).T)
        return np.abs(found[found.real < 0.0]).max()

    assert largest(0.97 * limit(rho)) < 1.0 < largest(1.03 * limit(rho))


@pytest.mark.parametrize(("share", "grows"), [(0.95, False), (1.15, True)])
def test_an_arm_turns_stably_up_to_the_limit(share, grows):
    """600 steps: below the limit the energy falls slowly by numerical damping, above it grows, and a run says so."""
    step = share * limit(0.8)
    found = deck(ARM.replace("STEP", str(step)).replace("END", str(600 * step)).replace("RHO", "0.8"))
    run = RecordedRun(found)
    assert (run["energy/kinetic"].max() > 1.5 * run["energy/kinetic"][0]) == grows


@pytest.mark.parametrize("step", [0.01, 0.03])
def test_without_numerical_damping_errors_grow_by_e_in_each_radian(step):
    """The error of the reaction m w^2 r = 5 N grows from 0.01 to 1 N while the arm turns by ln 100 rad, at any step."""
    run = RecordedRun(deck(ARM.replace("STEP", str(step)).replace("END", "16").replace("RHO", "1")))
    off = np.abs(np.linalg.norm(run["joints/hub/force"], axis=1) - 5.0)
    first, last = (run.time[np.argmax(off > limit)] for limit in (0.01, 1.0))
    assert last - first == pytest.approx(np.log(100.0), abs=0.1)


def test_a_blade_that_fails_in_long_steps_is_explained(tmp_path):
    """0.3 rad in a step: unstable at rho_inf 0.8, stable at 0.3."""
    (tmp_path / "blade.yaml").write_text(BLADE)
    advice = "bodies turn by more than 0.15 rad in a step of 0.03 s: with rho_inf = 0.8"
    with pytest.raises(ConvergenceError, match=advice):
        mecano.run(tmp_path / "blade.yaml", tmp_path / "b.h5")
    results = mecano.run(tmp_path / "blade.yaml", tmp_path / "s.h5", set={"time.rho_inf": 0.3, "time.end": 6})
    assert results.extremes["energy/balance"].maximum_time == 0.0 and "unstable" not in results.reason

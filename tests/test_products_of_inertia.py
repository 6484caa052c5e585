"""The products of inertia of a deck are elements of the tensor, minus the integrals of the products of coordinates."""

import numpy as np
import pytest
from time_runs import deck

from mecano.analyses.prepare import prepare

POINTS = np.array(
    [[0.3, 0.2, -0.1], [-0.4, 0.1, 0.2], [0.1, -0.3, -0.1]]
)  # m, of 1 kg each; their centre is the origin
SPIN = np.array([2.0, -3.0, 5.0])  # rad/s


@pytest.mark.parametrize("written", ["{0}", "[{1}, {2}, {3}, {4}, {5}, {6}]"])
def test_the_energy_is_that_of_three_points(written):
    """The sum of |w x r|^2/2; products of the opposite sign would give another one."""
    J = sum(r @ r * np.eye(3) - np.outer(r, r) for r in POINTS)
    numbers = [J[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    text = f"""
        mecano: 1
        gravity: none
        nodes: {{body: {{position: [0, 0, 0]}}}}
        elements: {{body: {{type: rigid_body, node: body, mass: 3, inertia: {written.format(J.tolist(), *numbers)}}}}}
        initial: {{velocities: [{{nodes: [body], angular_velocity: {SPIN.tolist()}}}]}}
        time: {{end: 1, step: 0.1}}
        """
    prepared = prepare(deck(text))
    found = prepared.system.observe(prepared.state).outputs[-1]
    expected, other = (0.5 * SPIN @ tensor @ SPIN for tensor in (J, 2.0 * np.diag(np.diag(J)) - J))
    assert expected == pytest.approx(0.5 * sum(np.sum(np.cross(SPIN, r) ** 2) for r in POINTS), rel=1e-14)
    assert found == pytest.approx(expected, rel=1e-14) and abs(other - expected) > 0.1 * expected

"""Steady turns: a disc that rolls on a circle, a wheel on a carousel, and turns that do not exist."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck

from mecano.analyses.prepare import prepare
from mecano.errors import ConvergenceError
from mecano.solve.modal.steadiness import require_steady
from mecano.solve.modal.steady import Steady
from mecano.solve.modal.steady_turn import Turn

MASS, RADIUS, G = 2.0, 0.5, 9.81
ACROSS, ALONG = 0.25 * MASS * RADIUS**2, 0.5 * MASS * RADIUS**2  # moments of inertia of a thin disc [kg m2]

DISC = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {{disc: {{position: [0, 0, {height}]}}}}
    elements:
      body: {{type: rigid_body, node: disc, mass: 2, inertia: {inertia}}}
      wheel: {{type: rigid_wheel, node: disc, radius: 0.5, axis: {axis}, ground: table}}
    grounds: {{table: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
    initial: {{steady: {{angular_velocity: [0, 0, {rate}], about: [0, {centre}, 0]}}}}
    time: {{end: 1, step: 1 ms}}
"""


def disc(rate, centre, lean):
    """Return the deck of a disc that rolls along x, leans to its left by ``lean``, and turns left."""
    axis = np.array([0.0, np.cos(lean), np.sin(lean)])
    inertia = ACROSS * np.eye(3) + (ALONG - ACROSS) * np.outer(axis, axis)
    where = {"height": RADIUS * axis[1], "axis": axis.tolist(), "inertia": inertia.tolist()}
    return deck(DISC.format(**where, rate=rate, centre=centre))


def test_a_disc_on_a_circle_leans_as_the_balance_of_momenta_requires(verify):
    """Found from a disc that leans too little: its weight balances dH/dt and the acceleration towards the axis.

    With the spin that rolling requires, H = J omega, omega = w e_z + sigma a: r x F = w e_z x H, F = m (acceleration +
    g e_z) at the contact.
    """
    rate, lean = 2.5, 0.25
    run = RecordedRun(disc(rate, 1.2, lean))
    x, v, omega = (run[f"nodes/disc/{name}"] for name in ("position", "velocity", "angular_velocity"))
    arm = run["elements/wheel/contact_point"][0] - x[0]
    axis = omega[0] - [0.0, 0.0, rate]
    spin = np.linalg.norm(axis)
    axis /= spin
    H = ACROSS * omega[0] + (ALONG - ACROSS) * (axis @ omega[0]) * axis
    turn = np.array([0.0, 0.0, rate])
    force = MASS * (np.cross(turn, v[0]) + [0.0, 0.0, G])
    found = np.cross(arm, force)
    np.testing.assert_allclose(found, np.cross(turn, H), atol=1e-9)
    np.testing.assert_allclose(v[0] + np.cross(omega[0], arm), 0.0, atol=1e-12)
    distance = np.linalg.norm(x[:, :2] - [0.0, 1.2], axis=1)
    assert np.ptp(distance) < 1e-5 and abs(axis[2] - np.sin(lean)) > 1e-3
    verify("Wheels", "disc on a circle: moment of its weight and centrifugal force [N m]", np.linalg.norm(found),
           np.linalg.norm(np.cross(turn, H)), "rate of the angular momentum", relative=1e-9)  # fmt: skip


def test_a_turn_that_is_not_found_is_named():
    """The message speaks of the turn and of a drive."""
    prepared = prepare(disc(2.5, 1.2, 0.25))
    turn = Turn(prepared.system, [0.0, 0.0, 2.5], [0.0, 1.2, 0.0])
    steady = Steady(prepared.system, prepared.length, turn)
    with pytest.raises(ConvergenceError) as info:
        require_steady(steady, steady.in_motion(prepared.state), False)
    assert str(info.value).startswith("no steady turn with the angular velocity [0.0, 0.0, 2.5] rad/s was found")
    assert "a drive that balances the drag in a turn" in str(info.value)

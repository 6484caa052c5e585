"""Nets of damped cables that a mass hits: cables go taut and slack together, many times in a step."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck

SPACING, SIDE, CENTRE = 0.25, 6, 2  # [m], knots along a side, row and column of the mass


def net(damping, time, end=0.02, stiffness=1.0e5):
    """A net of knots of 20 g, held at its corners, without slack; a mass of 1 kg in a knot falls with 20 m/s."""
    knots, cables = [], []
    for i in range(SIDE):
        for j in range(SIDE):
            held = ", fixed: true" if {i, j} <= {0, SIDE - 1} else ""
            knots.append(f"n{i}_{j}: {{position: [{SPACING * i}, {SPACING * j}, 0]{held}}}")
            mass = 1.0 if i == j == CENTRE else 0.02
            cables.append(f"m{i}_{j}: {{type: point_mass, node: n{i}_{j}, mass: {mass}}}")
            cables += [
                f"c{i}_{j}_{a}_{b}: {{type: cable, nodes: [n{i}_{j}, n{a}_{b}], axial_stiffness: {stiffness}, "
                f"natural_length: {SPACING}, damping: {damping}}}"
                for a, b in ((i + 1, j), (i, j + 1))
                if max(a, b) < SIDE
            ]  # fmt: skip
    return deck(
        "mecano: 1\ngravity: [0, 0, -9.81]\n"
        f"initial: {{velocities: [{{nodes: [n{CENTRE}_{CENTRE}], velocity: [0.3, 0.2, -20]}}]}}\n"
        f"time: {{end: {end}, {time}}}\n"
        + "nodes:\n  " + "\n  ".join(knots) + "\nelements:\n  " + "\n  ".join(cables)
    )  # fmt: skip


def lost(recorded):
    """Return the energy that the cables dissipate [J]."""
    return recorded["energy/dissipated"][-1]


@pytest.mark.parametrize("damping", [1.0e-3, 1.0e-2])  # zeta = 2 to 60 of a knot on its cables
def test_a_net_of_strongly_damped_cables_keeps_the_balance_of_energy(damping):
    """Steps longer than m/c, in which cables are slack and taut in turn; the same loss by three ways to make steps.

    Located events restart the steps, captured ones do not.
    """
    adaptive = RecordedRun(net(damping, "step: 1 ms, adaptive: {tolerance: 1.0e-4}"))
    short = RecordedRun(net(damping, "step: 0.1 ms"))
    captured = RecordedRun(net(damping, "step: 0.1 ms, located_events: 1"))
    for recorded in (adaptive, short, captured):
        assert np.ptp(recorded["energy/balance"]) < 0.01 * recorded["energy/kinetic"][0]
        assert np.all(np.diff(recorded["energy/dissipated"]) >= -1e-12)
        assert min(recorded[path].min() for path in recorded.columns if path.endswith("/tension")) == 0.0
    assert [lost(short), lost(captured)] == pytest.approx([lost(adaptive)] * 2, rel=0.05)
    assert len(adaptive.time) < 800  # steps and instants of events; several thousand events could be located
    assert captured.integrator.capture.by_element.total() > 20

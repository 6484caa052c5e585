"""The woodpecker toy, a limit cycle of impacts and friction, against Moreau's time stepping of two planar bodies."""

import numpy as np
import pytest
from time_runs import RecordedRun, input_deck

from mecano.analyses.prepare import mass_of, prepare

SLEEVE, SLEEVE_INERTIA, BIRD, BIRD_INERTIA, SPRING, G = 0.3e-3, 5e-9, 4.5e-3, 7e-7, 5.6e-3, 9.81
POLE, BORE, HALF, TO_SPRING, TO_BIRD, UP, BEAK = 2.5e-3, 3.1e-3, 5.8e-3, 10e-3, 15e-3, 20e-3, 20.1e-3
RESTITUTION, FRICTION = (0.5, 0.0, 0.0), 0.3  # of the beak, and of the lower and the upper edge of the sleeve
START = (0.0, 0.1036, 0.2788), (-0.3411, 0.0, 7.4583)  # height, tilts of sleeve and bird down, and their rates


def small(q, u):
    """Return mass, forces, gaps and the directions of normal and tangential rates (Leine et al. 2003)."""
    lever = np.array([1.0, -TO_SPRING, -TO_BIRD])
    mass = np.diag([SLEEVE, SLEEVE_INERTIA, BIRD_INERTIA]) + BIRD * np.outer(lever, lever)
    moment = SPRING * (q[1] - q[2])
    force = np.array([-SLEEVE * G, -moment, moment]) - BIRD * G * lever
    gap = [TO_SPRING + TO_BIRD - BEAK - POLE + UP * q[2], BORE - POLE - HALF * q[1], BORE - POLE + HALF * q[1]]
    normal = np.array([[0, 0, UP], [0, -HALF, 0], [0, HALF, 0]])
    return mass, force, gap, normal, np.array([[1, -TO_SPRING, BEAK - TO_BIRD], [1, -BORE, 0], [1, -BORE, 0]])


def finite(q, u):
    """Return the same for rotations of any size."""
    (c, cb), (s, sb) = np.cos(q[1:]), np.sin(q[1:])
    x, z = np.array([0.0, -TO_SPRING * s, -TO_BIRD * sb]), np.array([1.0, -TO_SPRING * c, -TO_BIRD * cb])
    bent = u[1:] ** 2 * [TO_SPRING, TO_BIRD]  # accelerations at constant rates
    mass = np.diag([SLEEVE, SLEEVE_INERTIA, BIRD_INERTIA]) + BIRD * (np.outer(x, x) + np.outer(z, z))
    moment = SPRING * (q[1] - q[2])
    force = np.array([-SLEEVE * G, -moment, moment]) + BIRD * (x * (bent @ [c, cb]) - z * (bent @ [s, sb] + G))
    back = TO_BIRD - BEAK
    gap = [TO_SPRING * c + back * cb + UP * sb - POLE, BORE * c - HALF * s - POLE, BORE * c + HALF * s - POLE]
    normal = [[0, -TO_SPRING * s, UP * cb - back * sb], [0, -BORE * s - HALF * c, 0], [0, HALF * c - BORE * s, 0]]
    along = [[1, -TO_SPRING * c, -back * cb - UP * sb], [1, HALF * s - BORE * c, 0], [1, -HALF * s - BORE * c, 0]]
    return mass, force, gap, np.array(normal), np.array(along)


def pecks(equations, end, dt):
    """Return instants and heights of the impacts of the beak by Moreau's midpoint rule, with Newton's impact law."""
    q, u, found = *map(np.array, START), []
    for i in range(round(end / dt)):
        q = q + 0.5 * dt * u
        mass, force, gap, normal, along = equations(q, u)
        inverse = np.linalg.inv(mass)
        closed, new = [k for k in range(3) if gap[k] <= 0.0], u + dt * inverse @ force
        pushed, rubbed, last = np.zeros(3), np.zeros(3), np.inf
        while closed and np.abs(new - last).max() > 1e-12 * np.abs(new).max():
            last = new
            for k in closed:
                n, t = inverse @ normal[k], inverse @ along[k]
                push = max(0.0, pushed[k] - (normal[k] @ new + RESTITUTION[k] * (normal[k] @ u)) / (normal[k] @ n))
                new, pushed[k] = new + n * (push - pushed[k]), push
                rub = np.clip(rubbed[k] - along[k] @ new / (along[k] @ t), -FRICTION * push, FRICTION * push)
                new, rubbed[k] = new + t * (rub - rubbed[k]), rub
        if pushed[0] > 1e-4:
            found.append(((i + 1) * dt, q[0]))
        u, q = new, q + 0.5 * dt * new
    return np.array(found).T


def test_the_deck_has_the_bodies_of_the_toy():
    prepared = prepare(input_deck("woodpecker"))
    system, s = prepared.system, prepared.state
    x = {node.name: s.z[at : at + 3] for node, at in zip(system.nodes, system.numbering.x, strict=True)}
    tilts = np.array([0.0, 0.1, 0.2788])
    _, _, gap, _, _ = finite(tilts, np.zeros(3))
    reached = [x[name][0] - POLE for name in ("bird_beak", "sleeve_low", "sleeve_high")]
    np.testing.assert_allclose(reached, gap, atol=1e-15)
    assert mass_of(system) == pytest.approx(SLEEVE + BIRD) and prepared.analysis.mobility == 3


@pytest.mark.slow
def test_the_published_start_lies_on_the_limit_cycle_of_small_rotations():
    """So the time stepping is that of the published model: the pecks have one period from the first on."""
    t, z = pecks(small, 0.8, 5e-5)
    np.testing.assert_allclose(np.diff(t), 0.146, rtol=3e-3)
    np.testing.assert_allclose(np.diff(z), -19.5e-3, rtol=0.02)


@pytest.mark.slow
def test_the_woodpecker_hops_as_by_moreaus_time_stepping(verify):
    m = RecordedRun(input_deck("woodpecker", "output.every=1e-4"))
    t = np.array([event.t for event in m.event_records if event.element == "contact 'peck'" and event.name == "closes"])
    z = np.interp(t, m.time, m["nodes/sleeve_middle/position"][:, 2])
    reference_t, reference_z = pecks(finite, 0.75, 2e-5)
    period, fall = np.diff(t)[2:], -np.diff(z)[2:]
    assert len(period) == 3 and np.ptp(period) < 1e-5 and np.ptp(fall) < 2e-5
    where, what = "Woodpecker toy", "limit cycle: {} [{}]"
    source = "Moreau's time stepping, steps of 20 us"
    verify(where, what.format("period", "s"), period[-1], np.diff(reference_t)[2:].mean(), source, relative=1.5e-3)
    verify(where, what.format("fall", "m"), fall[-1], -np.diff(reference_z)[2:].mean(), source, relative=6e-3)

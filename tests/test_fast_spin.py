"""A rotor that spins fast in a ring: a gyrocompass against its equation, and the limit of stability of its steps."""

import math
from contextlib import suppress

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigvals
from time_runs import RecordedRun, deck, input_deck

import mecano
from mecano.analyses import dynamic
from mecano.errors import MecanoError

S = "Mechanisms"
EARTH, LATITUDE, SPIN, RATE = 0.2, math.radians(30), 200.0, 0.2  # rad/s, rad
C, A = 0.02, 0.03  # kg m2, along and across the axis of the rotor

COMPASS = f"""
    mecano: 1
    gravity: none
    parameters: {{earth: {EARTH}, latitude: {LATITUDE}, spin: {SPIN}, rate: {RATE}, ring: 1.0e-9}}
    nodes:
      base: {{position: [0, 0, 0]}}
      ring: {{position: [0, 0, 0]}}
      rotor: {{position: [0, 0, 0], orientation: [0, -pi/2 - $latitude, 0]}}
    elements:
      ring: {{type: rigid_body, node: ring, mass: 1, inertia: [$ring, $ring, $ring]}}
      rotor: {{type: rigid_body, node: rotor, mass: 1, inertia: [{C}, {A}, {A}]}}
    joints:
      earth: {{type: hinge, nodes: [ground, base], axis: [0, 0, 1]}}
      turn: {{type: prescribed_angle, nodes: [ground, base], axis: [0, 0, 1], value: $earth*time}}
      azimuth: {{type: hinge, nodes: [base, ring], axis: [cos($latitude), 0, sin($latitude)]}}
      bearing: {{type: hinge, nodes: [ring, rotor], axis: [-sin($latitude), 0, cos($latitude)]}}
    initial:
      velocities:
        - {{nodes: all, angular_velocity: [0, 0, $earth], about: own}}
        - {{nodes: [ring, rotor], angular_velocity: ['$rate*cos($latitude)', 0, $rate*sin($latitude)], about: own}}
        - {{nodes: [rotor], angular_velocity: [-$spin*sin($latitude), 0, $spin*cos($latitude)], about: own}}
    time: {{end: 2, step: 0.4 ms}}
"""


def compass(**values):
    """Return the RecordedRun of the gyrocompass with replaced values, by what they follow in the deck."""
    text = COMPASS
    for key, value in values.items():
        old = {"step": "step: 0.4 ms", "ring": "ring: 1.0e-9", "end": "end: 2"}[key]
        text = text.replace(old, f"{key}: {value}")
    return RecordedRun(deck(text))


def test_a_gyrocompass_swings_about_north(verify):
    """Its axis stays horizontal on a body that turns; the momentum H along it is constant.

    A a'' = A (w cos l)^2 sin a cos a - H w cos l sin a for the azimuth a, at the latitude l of a body that turns by w.
    """
    coarse, fine = compass(), compass(step="0.2 ms")
    north, H = EARTH * math.cos(LATITUDE), C * (SPIN + EARTH * math.cos(LATITUDE))

    def equation(_, y):
        return y[1], north**2 * math.sin(y[0]) * math.cos(y[0]) - H * north / A * math.sin(y[0])

    found = solve_ivp(equation, (0, 2), (0, RATE), t_eval=coarse.time, rtol=1e-11, atol=1e-13)
    angles = coarse["joints/azimuth/angle"], fine["joints/azimuth/angle"][::2]
    verify.second_order(S, "gyrocompass: azimuth [rad]", *angles, found.y[0], 4e-6, "its equation, by SciPy")


@pytest.mark.parametrize(("turned", "grows"), [(0.14, False), (0.17, True)])
def test_a_rotor_in_a_light_ring_is_stable_up_to_the_limit(turned, grows):
    """At rho_inf = 0.8 in steps in which the rotor turns by less than 0.152 rad."""
    recorded = compass(step=turned / SPIN, end=1500 * turned / SPIN)
    balance = recorded["energy/balance"]
    assert (np.ptp(balance) > 1.0) == grows and (np.ptp(balance) < 0.01) == (not grows)


LIMITS = {  # docs/step-control.md: by rho_inf, for the inertias of the ring over that of the rotor
    0.95: {0.0: 0.04, 0.1: 0.04, 1.0: 0.07, 10.0: 0.15},
    0.8: {0.0: 0.15, 0.1: 0.18, 1.0: 0.31, 10.0: 0.64},
    0.5: {0.0: 0.45, 0.1: 0.52, 1.0: 0.92, 10.0: 1.68},
}


@pytest.mark.parametrize(("rho", "ring", "turned"), [(r, i, f) for r, row in LIMITS.items() for i, f in row.items()])
def test_limits_of_the_linear_recursion(rho, ring, turned):
    """The spectral radius exceeds one beyond the angles of the table, and not below."""
    assert spectral_radius(turned - 0.01, rho, ring) < 1 + 1e-6 and spectral_radius(turned + 0.01, rho, ring) > 1 + 1e-4


def spectral_radius(turned, rho, ring):
    """Return that of small motions of a rotor (C = A = 1) that turns by ``turned`` [rad] in each step of 1.

    Unknowns are, across the axis of the rotor, as complex numbers x exp(-i n turned) in its axes: rate, acceleration,
    algorithmic acceleration, and the angle in space; then the same of the ring, about the axis in which it is free,
    and the moments between both. The real part of the angle is held, the imaginary part is that of the ring.
    """
    am, af = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    beta, gamma = 0.25 * (1 + af - am) ** 2, 0.5 + af - am
    new, old = np.zeros((14, 14)), np.zeros((14, 14))

    def complex_block(matrix, row, column, factor):
        z = complex(factor)
        matrix[2 * row : 2 * row + 2, 2 * column : 2 * column + 2] += [[z.real, -z.imag], [z.imag, z.real]]

    turn, mean = np.exp(-1j * turned), np.exp(0.5j * turned) * np.sinc(turned / 2 / np.pi)
    rows = [  # of the rotor: (row, column, factor of the new value, of the old one)
        (0, 0, turn, 1), (0, 2, -gamma * turn, 1 - gamma), (1, 2, (1 - am) * turn, -am), (1, 1, -(1 - af) * turn, af),
        (2, 3, 1, 1), (2, 0, 0, mean), (2, 2, -mean * beta * turn, mean * (0.5 - beta)),
        (3, 1, 1, 0), (3, 6, -1, 0),  # no gyroscopic moment in its axes, as C = A
    ]  # fmt: skip
    for row, column, now, before in rows:
        complex_block(new, row, column, now)
        complex_block(old, row, column, before)
    new[8, [8, 10]], old[8, [8, 10]] = (1, -gamma), (1, 1 - gamma)
    new[9, [10, 9]], old[9, [10, 9]] = (1 - am, -(1 - af)), (-am, af)
    new[10, [11, 10]], old[10, [11, 8, 10]] = (1, -beta), (1, 1, 0.5 - beta)
    new[11, [9, 13]] = ring, 1
    new[12, 6], new[13, [7, 11]] = 1, (1, -1)
    roots = eigvals(old, new)
    return np.abs(roots[np.isfinite(roots)]).max()


@pytest.mark.parametrize(("rho", "swings"), [(0.8, False), (0.95, True)])
def test_a_caster_that_is_stable_may_swing_out_by_the_steps_alone(rho, swings, tmp_path):
    """At 75 m/s in steps of 1 ms, in which the wheel turns by 0.25 rad; eigenvalues: inputs/caster_shimmy.yaml."""
    values = ("parameters.speed=75", f"time.rho_inf={rho}", "time.end=1.2", "output.every=step")
    with suppress(MecanoError):
        dynamic.run(input_deck("caster_shimmy", *values), tmp_path / "r.h5")
    with mecano.open_results(tmp_path / "r.h5") as results:
        angle = np.abs(results["caster.angle"].values)
    assert (angle.max() > 0.1) == swings and (angle[-200:].max() < 1e-5) == (not swings)

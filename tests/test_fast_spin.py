"""Rotors that spin fast: against closed forms, and the stability of steps in which they turn far."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigvals
from scipy.sparse import coo_array
from scipy.spatial.transform import Rotation
from test_generalized_alpha import GYRO
from time_runs import RecordedRun, deck, input_deck

from mecano.model.assembly import Assembly
from mecano.model.numbering import ROTATION
from mecano.solve.time.increments import correct

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
    angles = coarse["joints/azimuth/angle"], fine["joints/azimuth/angle"][::2]
    verify.second_order(S, "gyrocompass: azimuth [rad]", *angles, azimuth(coarse.time), 5e-8, "its equation, by SciPy")


def azimuth(times, inertia=A):
    """Return its solution, where ``inertia`` is that of the first term."""
    north, H = EARTH * math.cos(LATITUDE), C * (SPIN + EARTH * math.cos(LATITUDE))

    def equation(_, y):
        return y[1], (A * north**2 * math.cos(y[0]) - H * north) / inertia * math.sin(y[0])

    return solve_ivp(equation, (0, 2), (0, RATE), t_eval=times, rtol=1e-11, atol=1e-13).y[0]


@pytest.mark.parametrize("rho", [0.8, 1.0])
def test_steps_change_the_inertia_of_a_gyrocompass_that_swings(rho):
    """It swings as one with the moment of inertia A + Ce (C - A) p^2 across its axis, for turns of p in a step.

    Velocities of the method are off by Ce h^2 q''' in constrained directions: that across the axis by Ce h^2 s w',
    for the spin s and the rate w at which the axis turns. Times s C that is a moment, as is the change of s A.
    """
    am, af = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    Ce = 0.25 * (1 + af - am) ** 2 + 0.5 * (am - af) - 1 / 6
    recorded = RecordedRun(deck(COMPASS.replace("step: 0.4 ms", f"step: 2 ms, rho_inf: {rho}")))
    found = recorded["joints/azimuth/angle"]
    changed, unchanged = (azimuth(recorded.time, A + Ce * (C - A) * turned**2) for turned in (0.002 * SPIN, 0.0))
    assert np.abs(found - changed).max() < 5e-4 * np.abs(found).max() < 0.03 * np.abs(found - unchanged).max()


@pytest.mark.parametrize("turned", [0.2, 0.6, 1.5])
def test_a_rotor_in_a_light_ring_is_stable_however_far_it_turns_in_a_step(turned):
    recorded = compass(step=turned / SPIN, end=1500 * turned / SPIN)
    assert np.ptp(recorded["energy/balance"]) < 1e-5 * recorded["energy/kinetic"].max()


FORK = """
    mecano: 1
    gravity: none
    nodes:
      fork: {{position: [0, 0, 0]}}
      rotor: {{position: [0, 0, 0]}}
    elements:
      fork: {{type: rigid_body, node: fork, mass: 1, inertia: [0.1, 0.1, 0.1]}}
      rotor: {{type: rigid_body, node: rotor, mass: 1, inertia: [0.05, 0.03, 0.03]}}
    joints:
      base: {{type: hinge, nodes: [ground, fork], axis: [0, 0, 1]}}
      turn: {{type: prescribed_angle, nodes: [ground, fork], axis: [0, 0, 1], value: 1.5*time}}
      bearing: {{type: hinge, nodes: [fork, rotor], axis: [1, 0, 0]}}
    initial:
      velocities:
        - {{nodes: [fork], angular_velocity: [0, 0, 1.5]}}
        - {{nodes: [rotor], angular_velocity: [300, 0, 1.5]}}
    time: {{end: 100*{step}, step: {step}}}
"""


@pytest.mark.parametrize(("turned", "off"), [(0.1, 1e-7), (0.3, 1e-6), (1.2, 1e-5)])
def test_the_gyroscopic_moment_of_a_rotor_in_a_fork(turned, off):
    """It is C s w for the spin s and the rate w of the fork, after the first transient of the steps."""
    recorded = RecordedRun(deck(FORK.format(step=turned / 300)))
    moments = np.linalg.norm(recorded["joints/bearing/moment"][-20:], axis=1)
    np.testing.assert_allclose(moments, 0.05 * 300 * 1.5, rtol=off)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8, 0.95, 1.0])
@pytest.mark.parametrize("ring", [0.0, 0.1, 1.0, 10.0])
@pytest.mark.parametrize("disc", [1.0, 2.0])
def test_no_root_of_the_linear_recursion_exceeds_one(rho, ring, disc):
    """Of a rotor with the moments of inertia ``disc`` and 1 along and across its axis, up to the largest step."""
    for turned in (0.05, 0.2, 0.6, 1.2, 1.8, 2.4):
        assert spectral_radius(turned, rho, ring, disc) < 1 + 1e-4


def spectral_radius(turned, rho, ring, disc):
    """Return that of small motions of a rotor that turns by ``turned`` [rad] in each step of 1.

    Unknowns are, across the axis e of the spin, as complex numbers: angular velocity w, acceleration, algorithmic
    acceleration, position n of the axis of the rotor, moment, rotation vector d; then rate, both accelerations and
    angle of the ring, in which the axis is held along the real direction. The last equations are
    n' = exp(i p) n - (exp(i p) - 1)/p d with p = ``turned``, A a - i (C - A) p (w - p n) = m.
    """
    am, af = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    beta, gamma = 0.25 * (1 + af - am) ** 2, 0.5 + af - am
    new, old = np.zeros((16, 16)), np.zeros((16, 16))

    def complex_block(matrix, row, column, factor):
        z = complex(factor)
        matrix[2 * row : 2 * row + 2, 2 * column : 2 * column + 2] += [[z.real, -z.imag], [z.imag, z.real]]

    p, w, a, a_n, n, m, d = (turned, *range(6))
    turn, axis = np.exp(1j * p), (1.0 - 0.5 * p / np.tan(0.5 * p)) / p
    rows = [  # of the rotor: (row, column, factor of the new value, of the old one)
        (0, w, 1, 1), (0, a_n, -gamma, 1 - gamma), (1, a_n, 1 - am, -am), (1, a, -(1 - af), af),
        (2, d, 1, 0), (2, a_n, -beta, 0.5 - beta), (2, w, 1j * axis, 1 + 1j * axis),
        (3, n, 1, turn), (3, d, (turn - 1) / p, 0),
        (4, a, 1, 0), (4, w, -1j * (disc - 1) * p, 0), (4, n, 1j * (disc - 1) * p * p, 0), (4, m, -1, 0),
    ]  # fmt: skip
    for row, column, now, before in rows:
        complex_block(new, row, column, now)
        complex_block(old, row, column, before)
    rate, change, algorithmic, angle = range(12, 16)
    new[10, [rate, algorithmic]], old[10, [rate, algorithmic]] = (1, -gamma), (1, 1 - gamma)
    new[11, [algorithmic, change]], old[11, [algorithmic, change]] = (1 - am, -(1 - af)), (-am, af)
    new[12, [angle, algorithmic]], old[12, [angle, rate, algorithmic]] = (1, -beta), (1, 1, 0.5 - beta)
    new[13, [change, 2 * m]] = ring, 1
    new[14, 2 * n], new[15, [2 * n + 1, angle]] = 1, (1, 1)
    roots = eigvals(old, new)
    return np.abs(roots[np.isfinite(roots)]).max()


ROD = """
    mecano: 1
    gravity: none
    nodes: {rod: {position: [0, 0, 0]}}
    elements: {rod: {type: rigid_body, node: rod, mass: 1, inertia: [0.2, 1, 1]}}
    initial: {velocities: [{nodes: [rod], angular_velocity: [100, 1, 0]}]}
    time: {end: 30, step: 6 ms, rho_inf: RHO}
"""


@pytest.mark.parametrize(("rho", "grows"), [(1.0, 1e-4), (0.8, 0.01), (0.5, 0.5)])
def test_the_nutation_of_a_free_rod_grows_by_numerical_damping(rho, grows):
    """Damping takes energy at constant momentum, so that the rod tends to turn about an axis across it."""
    recorded = RecordedRun(deck(ROD.replace("RHO", str(rho))))
    turns = Rotation.from_quat(recorded["nodes/rod/rotation"], scalar_first=True)
    across = np.linalg.norm(turns.inv().apply(recorded["nodes/rod/angular_velocity"])[:, 1:], axis=1)
    assert -1e-4 < across[-1] / across[0] - 1.0 < grows
    assert (across[-1] - across[0] > 0.003) == (rho < 1.0)


@pytest.mark.parametrize("rho", [0.8, 0.95])
def test_a_caster_that_is_stable_does_not_swing_out(rho):
    """At 75 m/s in steps of 1 ms, in which the wheel turns by 0.25 rad; eigenvalues: inputs/caster_shimmy.yaml."""
    recorded = RecordedRun(input_deck("caster_shimmy", "parameters.speed=75", f"time.rho_inf={rho}", "time.end=1.2"))
    angle = np.abs(recorded["joints/caster/angle"])
    assert angle.max() < 0.1 and angle[-200:].max() < 1e-5


def test_the_tangent_of_a_step_in_which_bodies_turn_far():
    """That of Newton's iteration against central differences, for a rotor that turns by 0.6 rad in a step."""
    recorded = RecordedRun(deck(GYRO.format(step=0.03).replace("end: 0.016", "end: 0.12")))
    method, start, history, of = recorded.integrator.method, recorded.run.motion, recorded.run.history, recorded.system
    s = method.step(start, history, 0.03)[0]
    s.start_spins = start.v[of.numbering.rotation_dof[:, None] + np.arange(3)]
    by, penalty = method._weights(history, 0.03)
    method._assemble(s, by, penalty)
    tangent = coo_array((method.assembly.data[: of.nnz], (of.rows, of.cols)), (of.n, of.n)).toarray()
    assert np.abs(s.z[: of.n_q][of.numbering.kind[: of.n_q] == ROTATION]).max() > 0.5

    def residual(dz):
        moved, found = s.copy(), Assembly(of)
        correct(of.numbering, 1.0, -dz, by, start, moved)
        return of.assemble(moved, by.k, penalty, into=found).residual[: of.n].copy()

    for j, dz in enumerate(1e-5 * np.eye(of.n)):
        found = (residual(dz) - residual(-dz)) / 2e-5
        np.testing.assert_allclose(found, tangent[:, j], rtol=0, atol=1e-7 * np.abs(tangent[:, j]).max())

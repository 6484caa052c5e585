"""Run-up of an unbalanced rotor on an elastic shaft: a weak motor cannot pass the critical speed (Sommerfeld 1902).

A disc with the eccentricity e turns by phi on springs k and dampers c; z = x + i y is the displacement of its bearing:
m (z + e exp(i phi))'' + c z' + k z = 0, and about its centre of mass I phi'' = T + e Im((c z' + k z) exp(-i phi)), the
moment of the force -(c z' + k z) of the shaft at -e exp(i phi) (Laval 1889, Jeffcott 1919).
"""

import numpy as np
import pytest
from convergence import at_times
from scipy.integrate import solve_ivp
from time_runs import RecordedRun, deck

MASS, INERTIA, ECCENTRIC, STIFFNESS, DAMPING = 10.0, 0.05, 2e-3, 4e4, 40.0
CRITICAL = np.sqrt(STIFFNESS / MASS)  # rad/s


def rotor(torque, end, step):
    return deck(f"""
    mecano: 1
    gravity: none
    nodes: {{disc: {{position: [0, 0, 0]}}}}
    elements:
      disc:
        {{type: rigid_body, node: disc, mass: {MASS}, inertia: [1, 1, {INERTIA}], center_of_mass: [{ECCENTRIC}, 0, 0]}}
      shaft:
        {{type: bushing, nodes: [ground, disc], stiffness: [{STIFFNESS}, {STIFFNESS}, 0, 0, 0, 0],
         damping: [{DAMPING}, {DAMPING}, 0, 0, 0, 0]}}
    joints: {{plane: {{type: planar, nodes: [ground, disc], axis: [0, 0, 1]}}}}
    loads: {{motor: {{type: joint_moment, joint: plane, value: {torque}}}}}
    time: {{end: {end}, step: {step}}}
    """)


def laval(t, state, torque):
    """Rates of (x, y, phi, x', y', phi') [m, rad, s]."""
    z, speed, phi, rate = complex(*state[:2]), complex(*state[3:5]), state[2], state[5]
    force, turned = DAMPING * speed + STIFFNESS * z, ECCENTRIC * np.exp(1j * phi)
    moment = torque + (force * turned.conjugate()).imag
    angular = moment / INERTIA
    z_rate = -force / MASS - turned * (1j * angular - rate**2)
    return [*state[3:], z_rate.real, z_rate.imag, angular]


@pytest.mark.parametrize(("torque", "passes"), [(1.0, False), (3.0, True)])
def test_a_weak_motor_is_caught_at_the_critical_speed(torque, passes, verify):
    """1 N m leaves the rotor 4 % below its critical speed; without unbalance it would be 58 % above it after 5 s."""
    times = [1.0, 2.0, 3.0, 4.0, 5.0]
    exact = solve_ivp(laval, (0, 5), [0.0] * 6, "DOP853", t_eval=times, args=(torque,), rtol=1e-11, atol=1e-13).y[5]
    found = []
    for step in ("1 ms", "0.5 ms"):
        run = RecordedRun(rotor(torque, 5.0, step))
        found.append(at_times(run, run["nodes/disc/angular_velocity"][:, 2], times))
    assert (found[1][-1] > CRITICAL) == passes
    what = f"unbalanced rotor with a motor of {torque:g} N m: speed [rad/s]"
    verify.second_order("Rotors", what, *found, exact, 1e-4, "equations of Laval and Jeffcott, SciPy")

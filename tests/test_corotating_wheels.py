"""Shimmy of a trailing gear with two wheels, on one axle (co-rotating) or on bearings of their own.

Besselink (Shimmy of aircraft main landing gears, Delft 2000) compares both. Two wheels at a distance 2b trail by e
behind an elastic vertical axis; their tyres have the relaxation length sigma. On one axle they slip when the gear yaws,
which damps the yaw; with bearings of their own they roll, and their spins differ from the mean by d and -d. With the
yaw psi, the lateral force F of each wheel and the longitudinal forces G and -G of the left and the right one:

    I psi'' + c psi' + k psi = -2 e F - 2 b G,    sigma F' + V F = C_l (V psi + e psi'),
    sigma G' + V G = C_t (b psi' + r d),          J d' = -r G  (d = 0 on one axle)
"""

import numpy as np
import pytest
from small_motions import eigenvalues
from time_runs import deck

TRAIL, HALF, RADIUS, MASS, SPIN, ACROSS, SWIVEL = 0.12, 0.25, 0.4, 20.0, 1.0, 0.6, 2.0  # m, kg, kg m2
SPRING, DAMPER, LATERAL, DRIVING, RELAXATION = 5e4, 20.0, 6e4, 1.5e5, 0.3  # N m/rad, N m s/rad, N/rad, N, m
TRACK = 2 * (ACROSS + MASS * HALF**2)  # kg m2, of both wheels about the vertical axis between them

ONE_AXLE = (
    f"axle: {{type: rigid_body, node: hub, mass: {2 * MASS}, inertia: [{TRACK}, {2 * SPIN}, {TRACK}], "
    "attached: [a, b]}",
    "bearing: {type: hinge, nodes: [fork, hub], axis: [0, 1, 0]}",
)
TWO_AXLES = (
    "\n      ".join(
        f"{w}_rim: {{type: rigid_body, node: {w}, mass: {MASS}, inertia: [{ACROSS}, {SPIN}, {ACROSS}]}}" for w in "ab"
    ),
    "\n      ".join(f"{w}_bearing: {{type: hinge, nodes: [fork_{w}, {w}], axis: [0, 1, 0]}}" for w in "ab"),
)


def gear(speed, bodies, bearings):
    places = "".join(
        f"\n      {name}: {{position: [{-TRAIL}, {y}, {RADIUS}]}}"
        for name, y in (("fork", 0), ("hub", 0), ("a", HALF), ("b", -HALF), ("fork_a", HALF), ("fork_b", -HALF))
        if name != "hub" or "hub" in bodies
    )
    return deck(f"""
    mecano: 1
    gravity: none
    nodes:
      carriage: {{position: [0, 0, {RADIUS}]}}
      arm: {{position: [0, 0, {RADIUS}]}}{places}
    elements:
      swivel:
        {{type: rigid_body, node: arm, mass: 1, inertia: [2, 2, {SWIVEL}], attached: [fork, fork_a, fork_b]}}
      {bodies}
      a_tyre: {{type: transient_wheel, node: a, axis: [0, 1, 0], tire_law: rubber, ground: road}}
      b_tyre: {{type: transient_wheel, node: b, axis: [0, 1, 0], tire_law: rubber, ground: road}}
    joints:
      level: {{type: held_rotation, nodes: [ground, carriage]}}
      height: {{type: prescribed_position, node: carriage, direction: [0, 0, 1], value: 0}}
      track: {{type: prescribed_position, node: carriage, direction: [0, 1, 0], value: 0}}
      tow: {{type: prescribed_position, node: carriage, direction: [1, 0, 0], value: {{linear: {{slope: {speed}}}}}}}
      caster:
        {{type: hinge, nodes: [carriage, arm], axis: [0, 0, 1], turning_law: {{spring: {SPRING}, damper: {DAMPER}}}}}
      {bearings}
    tire_laws:
      rubber:
        radius: {RADIUS + 4e-4}
        radial: {{linear: {{slope: 5.0e7}}}}
        fiala:
          cornering_stiffness: {LATERAL}
          longitudinal_stiffness: {DRIVING}
          friction: 500
          least_speed: 1.0e-3
          creep_length: 1.0e-6
          carcass_stiffness: [{DRIVING / RELAXATION}, {LATERAL / RELAXATION}]
    grounds: {{road: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
    initial: {{steady: {{velocity: [{speed}, 0, 0]}}}}
    time: {{end: 1, step: 1 ms}}
    """)


def linear(speed, one_axle):
    """Return the eigenvalues (4,) or (5,) of the equations above, in the order psi, psi', F, G, d."""
    inertia = SWIVEL + TRACK + 2 * MASS * TRAIL**2
    A = np.zeros((5, 5))
    A[0, 1] = 1.0
    A[1, :4] = np.array([-SPRING, -DAMPER, -2 * TRAIL, -2 * HALF]) / inertia
    A[2, :3] = np.array([LATERAL * speed, LATERAL * TRAIL, -speed]) / RELAXATION
    A[3, 1], A[3, 3:] = DRIVING * HALF / RELAXATION, np.array([-speed, DRIVING * RADIUS]) / RELAXATION
    A[4, 3] = -RADIUS / SPIN
    return np.linalg.eigvals(A[:4, :4] if one_axle else A)


@pytest.mark.parametrize(("speed", "one_axle"), [(40.0, True), (40.0, False), (80.0, False)])
def test_shimmy_of_wheels_on_one_axle_and_on_two(speed, one_axle, verify):
    """Wheels on two axles shimmy at 40 m/s, on one they do not. The creep of the tyres, 1 um, changes 4e-6."""
    found, exact = eigenvalues(gear(speed, *(ONE_AXLE if one_axle else TWO_AXLES))), linear(speed, one_axle)
    exact = exact[exact.imag >= 0.0]
    near = [found[np.argmin(np.abs(found - value))] for value in exact]  # among others, of wheels that turn together
    assert np.any(found.real > 0.0) == np.any(exact.real > 0.0) == (not one_axle and speed < 50.0)
    what = f"two wheels on {'one axle' if one_axle else 'two axles'} at {speed:g} m/s: eigenvalues [1/s]"
    verify("Tyres", what, near, exact, "linear equations of shimmy", relative=1e-5)

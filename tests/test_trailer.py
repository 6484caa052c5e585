"""A car with a trailer, which snakes above a critical speed: three axles of linear tyres in a plane.

With the lateral displacement y of the car, its heading psi, and the heading phi of the trailer, axle i at y + r_i.(psi,
phi) with the heading h_i.(psi, phi) is pushed by -C_i (y' + r_i.(psi', phi') - v h_i.(psi, phi))/V, where V^2 = v^2 +
(0.1 m/s)^2 as in the law 'fiala'.
"""

import numpy as np
import pytest
from time_runs import deck

from mecano.analyses.modal import modes

CAR, TRAILER = (1400.0, 2400.0), (900.0, 1500.0)  # mass [kg], moment of inertia about the centre of mass [kg m2]
FRONT, REAR, HITCH = 1.3, -1.5, -2.3  # along the car, from its centre of mass [m]
CENTRE, AXLE = -3.3, -3.4  # along the trailer, from the hitch [m]
STIFFNESS = {"front": 90e3, "rear": 100e3, "trailer": 70e3}  # cornering stiffness [N/rad]
POINTS = np.array([[1, 0, 0], [1, HITCH, CENTRE]])  # of (y, psi, phi): centres of mass
AXLES = np.array([[1, FRONT, 0], [1, REAR, 0], [1, HITCH, AXLE]])
HEADINGS = np.array([[0, 1, 0], [0, 1, 0], [0, 0, 1]])
WHEEL = "{type: rigid_body, node: %s, mass: 1.0e-3, inertia: [6.0e-4, 1.0e-3, 6.0e-4]}"
TYRE = "{radius: 0.31, radial: {linear: {slope: 500 kN/m}}, fiala: {cornering_stiffness: %g, friction: 50}}"


def train(speed):
    """The deck; its wheels are so light that they react 1e5 times as fast as the trailer."""
    return deck(f"""
        mecano: 1
        gravity: none
        nodes:
          car: {{position: [0, 0, 0.3]}}
          front_axle: {{position: [{FRONT}, 0, 0.3]}}
          rear_axle: {{position: [{REAR}, 0, 0.3]}}
          hitch: {{position: [{HITCH}, 0, 0.3]}}
          trailer: {{position: [{HITCH}, 0, 0.3]}}
          trailer_axle: {{position: [{HITCH + AXLE}, 0, 0.3]}}
          front: {{position: [{FRONT}, 0, 0.3]}}
          rear: {{position: [{REAR}, 0, 0.3]}}
          last: {{position: [{HITCH + AXLE}, 0, 0.3]}}
        elements:
          car:
            {{type: rigid_body, node: car, mass: {CAR[0]}, inertia: [500, 2000, {CAR[1]}],
             attached: [front_axle, rear_axle, hitch]}}
          trailer:
            {{type: rigid_body, node: trailer, mass: {TRAILER[0]}, center_of_mass: [{CENTRE}, 0, 0],
             inertia: [300, 1500, {TRAILER[1]}], attached: [trailer_axle]}}
          front: {WHEEL % "front"}
          rear: {WHEEL % "rear"}
          last: {WHEEL % "last"}
          front_tyre: {{type: wheel, node: front, axis: [0, 1, 0], tire_law: front, ground: road}}
          rear_tyre: {{type: wheel, node: rear, axis: [0, 1, 0], tire_law: rear, ground: road}}
          last_tyre: {{type: wheel, node: last, axis: [0, 1, 0], tire_law: trailer, ground: road}}
        joints:
          plane: {{type: planar, nodes: [ground, car], axis: [0, 0, 1]}}
          ball: {{type: hinge, nodes: [hitch, trailer], axis: [0, 0, 1]}}
          front_bearing: {{type: hinge, nodes: [front_axle, front], axis: [0, 1, 0]}}
          rear_bearing: {{type: hinge, nodes: [rear_axle, rear], axis: [0, 1, 0]}}
          last_bearing: {{type: hinge, nodes: [trailer_axle, last], axis: [0, 1, 0]}}
        tire_laws: {{{", ".join(f"{name}: {TYRE % C}" for name, C in STIFFNESS.items())}}}
        grounds: {{road: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
        initial: {{steady: {{velocity: [{speed}, 0, 0]}}}}
        time: {{end: 1, step: 1 ms}}
        """)


def single_track(speed):
    """The nonzero eigenvalues of the equations above, those with a positive imaginary part."""
    masses, turns = np.array([CAR[0], TRAILER[0]]), np.diag([0.0, CAR[1], TRAILER[1]])
    M, C = POINTS.T * masses @ POINTS + turns, np.array(list(STIFFNESS.values()))
    D, K = (AXLES.T * C @ part / np.hypot(speed, 0.1) for part in (AXLES, -speed * HEADINGS))
    values = np.linalg.eigvals(np.vstack([np.eye(6)[3:], -np.linalg.solve(M, np.hstack([K, D]))]))
    return np.sort_complex(values[values.imag > 1e-6])


@pytest.mark.parametrize("speed", [15.0, 35.0, 45.0])
def test_a_trailer_snakes(speed, verify):
    """Both oscillations; above 37 m/s one grows. Motions along the road are free, and converged."""
    _, found, _ = modes(train(speed), None, number=7)
    assert found.converged.all() and np.sum(found.values == 0.0) == 5
    swings = np.sort_complex(found.values[found.values.imag > 1e-6])
    what = f"car with a trailer at {speed:g} m/s: real and imaginary parts of the eigenvalues [1/s]"
    of = [np.concatenate([part.real, part.imag]) for part in (swings, single_track(speed))]
    verify("Tyres", what, *of, "single-track model", relative=1e-5)

"""Capsize, weave and wobble of a motorcycle whose tyres relax, after Sharp (J. Mech. Eng. Sci. 13 (1971) 316-329).

The reference is the linear model of his paper: two rigid frames on a steering axis, thin wheels that spin, and tyres
with cornering stiffness, camber stiffness and relaxation length; with other numbers, and the stiffness of the weight
differentiated from the height of the frames on discs that stand on the road. mecano has no linear model: its bodies,
hinges and tyres are those of any vehicle, on stiff springs, and its equations are linearized about steady running.
"""

import numpy as np
import pytest
from scipy.optimize import root
from scipy.spatial.transform import Rotation
from time_runs import deck, input_deck

from mecano.analyses.modal import modes
from mecano.solve.modal import steady

RAKE, WHEELBASE, RADIUS, HEAD = 0.4702, 1.4283, 0.3048, 0.8
MEETS = WHEELBASE + 0.1158 / np.cos(RAKE)  # the steering axis meets the road
AXIS = np.array([-np.sin(RAKE), 0.0, np.cos(RAKE)])
PIVOT = np.array([MEETS - HEAD * np.tan(RAKE), 0.0, HEAD])
FORK = np.array([MEETS - 0.55 * np.tan(RAKE) + 0.0244 / np.cos(RAKE), 0.0, 0.55])
BODIES = (  # mass, centre, inertia (xx, zz, xz), whether it turns with the steering
    (217.45, np.array([0.4798, 0.0, 0.6157]), (30.654, 20.539, 1.735), 0),
    (30.65, FORK, (0.8747, 0.0823, 0.0), 1),
    (0.01, np.array([0.0, 0.0, RADIUS]), (0.53, 0.53, 0.0), 0),
    (0.01, np.array([WHEELBASE, 0.0, RADIUS]), (0.3594, 0.3594, 0.0), 1),
)
WHEELS = ((0.0, 1.05, 15831.0, 1325.6, 0), (WHEELBASE, 0.7186, 11174.0, 938.6, 1))  # x, spin inertia, C_alpha, C_gamma
RELAXATION, DAMPER, CROWN = 0.2438, 6.78, 0.09

DECK = f"""
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      frame: {{position: [0.4798, 0, 0.6157]}}
      frame_rear: {{position: [0, 0, {RADIUS}]}}
      frame_head: {{position: [{PIVOT[0]}, 0, {HEAD}]}}
      fork_head: {{position: [{PIVOT[0]}, 0, {HEAD}]}}
      fork: {{position: [{FORK[0]}, 0, 0.55]}}
      fork_axle: {{position: [{WHEELBASE}, 0, {RADIUS}]}}
      rear_hub: {{position: [0, 0, {RADIUS}]}}
      front_hub: {{position: [{WHEELBASE}, 0, {RADIUS}]}}
    elements:
      frame: {{type: rigid_body, node: frame, mass: 217.45, inertia: [30.654, 40, 20.539, 0, 1.735, 0],
              attached: [frame_rear, frame_head]}}
      fork: {{type: rigid_body, node: fork, mass: 30.65, inertia: [0.8747, 0.9, 0.0823],
             attached: [fork_head, fork_axle]}}
      rear: {{type: rigid_body, node: rear_hub, mass: 0.01, inertia: [0.53, 1.05, 0.53]}}
      front: {{type: rigid_body, node: front_hub, mass: 0.01, inertia: [0.3594, 0.7186, 0.3594]}}
      rear_tyre: {{type: transient_wheel, node: rear_hub, axis: [0, 1, 0], tire_law: rear, ground: road}}
      front_tyre: {{type: transient_wheel, node: front_hub, axis: [0, 1, 0], tire_law: front, ground: road}}
    joints:
      rear_axle: {{type: hinge, nodes: [frame_rear, rear_hub], axis: [0, 1, 0]}}
      front_axle: {{type: hinge, nodes: [fork_axle, front_hub], axis: [0, 1, 0]}}
      steering: {{type: hinge, nodes: [frame_head, fork_head], axis: [{AXIS[0]}, 0, {AXIS[2]}],
                 turning_law: {{damper: {DAMPER}}}}}
    tire_laws:
      rear:
        radius: {RADIUS}
        radial: {{linear: {{slope: 1.0e8}}}}
        fiala: {{cornering_stiffness: 15831, camber_stiffness: 1325.6, friction: 1.2, creep_length: 1.0e-6,
                carcass_stiffness: [15831/RELAXATION, 15831/RELAXATION]}}
      front:
        radius: {RADIUS}
        radial: {{linear: {{slope: 1.0e8}}}}
        fiala: {{cornering_stiffness: 11174, camber_stiffness: 938.6, friction: 1.2, creep_length: 1.0e-6,
                carcass_stiffness: [11174/RELAXATION, 11174/RELAXATION]}}
    grounds: {{road: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
    initial: {{steady: {{velocity: [SPEED, 0, 0]}}}}
    time: {{end: 1, step: 1 ms}}
"""


def sideways(x, steered):
    """Return the lateral displacement of the point x by unit lateral displacement, yaw, roll and steering angle."""
    arm = x - PIVOT
    return np.array([1.0, x[0], -x[2], steered * (AXIS[2] * arm[0] - AXIS[0] * arm[2])])


def turning(steered):
    """Return the rotations about x and z by the same."""
    return np.array([[0.0, 0.0, 1.0, AXIS[0] * steered], [0.0, 1.0, 0.0, AXIS[2] * steered]])


def weight(roll, steer, crown):
    """Return the potential of the weight on two wheels that stand on the road, which pitch and heave make them do.

    The wheels are discs, or tori whose treads have the radius ``crown``.
    """

    def place(x, steered, pitch, heave):
        frame = Rotation.from_euler("X", roll) * Rotation.from_euler("Y", pitch)
        fork = frame * Rotation.from_rotvec(steer * AXIS)
        moved = frame.apply(PIVOT) + fork.apply(x - PIVOT) if steered else frame.apply(x)
        return moved[2] + heave, (fork if steered else frame).apply([0.0, 1.0, 0.0])[2]

    def lowest(unknown):
        hubs = (place(np.array([x, 0.0, RADIUS]), steered, *unknown) for x, _, _, _, steered in WHEELS)
        return [height - crown - (RADIUS - crown) * np.sqrt(1.0 - lean**2) for height, lean in hubs]

    found = root(lowest, [0.0, 0.0], tol=1e-12).x
    return sum(mass * 9.81 * place(x, steered, *found)[0] for mass, x, _, steered in BODIES)


def sharp(speed, share=0.0, crown=0.0):
    """Return the eigenvalues (10,) [1/s] of lateral displacement, yaw, roll, steering angle and two tyre forces.

    A ``share`` of the tyre force does not wait for the relaxation; it is zero in Sharp's model, as is the ``crown``.
    """
    M, C, K = np.zeros((3, 4, 4))
    for mass, x, (xx, zz, xz), steered in BODIES:
        t = turning(steered)
        M += mass * np.outer(sideways(x, steered), sideways(x, steered)) + t.T @ [[xx, xz], [xz, zz]] @ t
    C[3, 3] = DAMPER
    h = 2e-3
    U = {(i, j): weight(i * h, j * h, crown) for i in (-1, 0, 1) for j in (-1, 0, 1)}
    K[2, 2] = (U[1, 0] - 2 * U[0, 0] + U[-1, 0]) / h**2
    K[3, 3] = (U[0, 1] - 2 * U[0, 0] + U[0, -1]) / h**2
    K[2, 3] = K[3, 2] = (U[1, 1] - U[1, -1] - U[-1, 1] + U[-1, -1]) / (4 * h**2)
    A = np.zeros((10, 10))
    A[:4, 4:8] = np.eye(4)
    for j, (x, spin, cornering, camber, steered) in enumerate(WHEELS):
        contact, t = sideways(np.array([x, 0.0, 0.0]), steered), turning(steered)
        C += t.T @ (spin * speed / RADIUS * np.array([[0.0, -1.0], [1.0, 0.0]])) @ t
        force = np.concatenate([cornering * t[1] - camber * t[0], -cornering * contact / speed])
        A[8 + j, :8], A[8 + j, 8 + j] = force * speed / RELAXATION, -speed / RELAXATION
        A[4:8, :8] += share * np.linalg.solve(M, np.outer(contact, force))
        A[4:8, 8 + j] = (1.0 - share) * np.linalg.solve(M, contact)
    A[4:8, :8] -= np.linalg.solve(M, np.hstack([K, C]))
    return np.linalg.eigvals(A)


@pytest.mark.parametrize(("speed", "creep"), [(10.0, 1e-6), (30.0, 1e-6), (47.5, 1e-6), (30.0, 0.02)])
def test_capsize_weave_and_wobble(speed, creep):
    """The wheels sink by 2e-5 m. Position, heading, speed and spins are free: eigenvalues of zero."""
    text = (
        DECK.replace("SPEED", str(speed)).replace("1.0e-6", str(creep)).replace("RELAXATION", f"{RELAXATION - creep}")
    )
    found = modes(deck(text), None, number=20)[1]
    assert found.converged.all()
    assert not np.any((np.abs(found.values) > 1e-8) & (np.abs(found.values) < 1e-4))
    assert_contains(found, sharp(speed, creep / RELAXATION))


def assert_contains(found, expected):
    """Assert that the modes ``found`` contain the ``expected`` eigenvalues of linear theory, but for those of zero."""
    for value in expected[(np.abs(expected) > 1e-6) & (expected.imag >= 0.0)]:
        assert np.abs(found.values - value).min() < 2e-4 * max(abs(value), 1.0), (value, found.values)


@pytest.mark.parametrize("speed", [5.0, 20.0, 40.0])
def test_rounded_treads(speed, verify):
    """Contacts that move aside with the lean make the capsize grow six times as fast at 20 m/s."""
    overrides = (f"parameters.{name}={value}" for name, value in (("crown", CROWN), ("speed", speed)))
    found, expected = modes(input_deck("motorcycle", *overrides), None, number=20)[1], sharp(speed, crown=CROWN)
    assert_contains(found, expected)
    capsize, known = found.values.real.max(), expected.real.max()
    what, source = f"motorcycle on rounded treads: capsize at {speed:g} m/s [1/s]", "linear model after Sharp"
    verify("Tyres", what, capsize, known, source, relative=2e-4)
    assert speed != 20.0 or capsize > 6.0 * sharp(speed).real.max()


def test_a_start_on_wheels_that_just_touch(monkeypatch):
    """Newton's method alone halves its steps 110 times, and finds the frame on one wheel.

    Eigenvalues of zero are not mistaken for growth of 6e-6 1/s.
    """
    tangent, count = steady.Steady.tangent, []
    monkeypatch.setattr(steady.Steady, "tangent", lambda self, s: count.append(1) or tangent(self, s))
    found = modes(deck(DECK.replace("SPEED", "32.5").replace("1.0e8", "1.0e7").replace("RELAXATION", "0.2438")), None)[
        1
    ]
    assert len(count) < 200
    assert not np.any((np.abs(found.values) > 1e-8) & (np.abs(found.values) < 1e-4))


def test_the_share_that_acts_at_once_damps_the_wobble():
    """By a fifth at 30 m/s, of a creep length of 2 cm."""
    late, early = (next(v for v in sharp(30.0, share) if v.imag > 40.0) for share in (0.0, 0.02 / RELAXATION))
    assert early.real / late.real == pytest.approx(1.2, abs=0.05)

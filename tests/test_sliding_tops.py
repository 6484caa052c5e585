"""Bodies of revolution that spin and slide on a surface: a tippe top, an egg that stands up, a ball in a cup."""

import numpy as np
from convergence import pair
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from time_runs import RecordedRun, deck

S, g = "Motions of textbooks", 9.81


def rotation(quaternions):
    """Return the Rotation of quaternions (..., 4) with the scalar first."""
    return Rotation.from_quat(np.asarray(quaternions)[..., [1, 2, 3, 0]])


class Slider:
    """A rigid body on the plane z = 0 with friction: y is quaternion, mass centre, its velocity, angular velocity.

    ``lever(R)`` is the vector from the mass centre to the contact, for a rotation matrix R.
    """

    def __init__(self, mass, inertia, lever, friction, regularization):
        self.mass, self.inertia, self.lever = mass, np.diag(inertia), lever
        self.friction, self.regularization = friction, regularization

    def forces(self, y):
        """Return the normal force N, the push of the plane over N, and the angular acceleration free and by the push.

        Newton and Euler; N keeps the acceleration of the contact in the plane.
        """
        v, w = y[7:10], y[10:]
        R = rotation(y[:4]).as_matrix()
        before, r, after = (self.lever(Rotation.from_rotvec(s * w).as_matrix() @ R) for s in (-1e-6, 0, 1e-6))
        slip = (v + np.cross(w, r)) * [1, 1, 0]
        speed = np.linalg.norm(slip)
        share = min(speed / self.regularization, 1.0)
        push = np.array([0, 0, 1.0]) - self.friction * share * (2.0 - share) * slip / max(speed, 1e-300)
        J = R @ self.inertia @ R.T
        free, pushed = np.linalg.solve(J, np.transpose([-np.cross(w, J @ w), np.cross(r, push)])).T
        falling = -g + np.cross(free, r)[2] + np.cross(w, (after - before) / 2e-6)[2]
        return -falling / (1.0 / self.mass + np.cross(pushed, r)[2]), push, free, pushed

    def rates(self, _, y):
        """Return the rates of y."""
        N, push, free, pushed = self.forces(y)
        q, w = y[:4], y[10:]
        turning = 0.5 * np.r_[-q[1:] @ w, q[0] * w + np.cross(w, q[1:])]
        return np.r_[turning, y[7:10], N * push / self.mass - [0, 0, g], free + N * pushed]

    def motion(self, tilt, spin, center, times):
        """Return the direction of the body's axis 3 (n, 3) at ``times``, and when N becomes zero, if it does.

        The axis starts tilted about y, the body spins about z. The ``center`` of its surface, from the mass centre in
        the axes of the body, is at rest at the start.
        """
        start = Rotation.from_rotvec([0, tilt, 0])
        w, c = np.array([0, 0, spin]), start.apply(center)
        y = np.r_[start.as_quat()[[3, 0, 1, 2]], -c, -np.cross(w, c), w]
        lifts = lambda _, y: self.forces(y)[0]
        lifts.terminal = True
        found = solve_ivp(
            self.rates, (0, max(times)), y, rtol=1e-9, atol=1e-12, t_eval=times, method="DOP853", events=lifts
        )
        return rotation(found.y[:4].T).apply([0, 0, 1]), found.t_events[0]


RADIUS, OFFSET, INERTIA, TILT = 0.02, 0.004, 2.9e-6, 0.1  # those of inputs/tippe_top.yaml
RISEN = np.array([0.2, 0.4, 0.6, 0.8, 1.0])


def axis_and_jellett(run):
    """Return the axis of the tippe top, and 1e6 times its angular momentum along the vector to the contact."""
    axis = rotation(run["nodes/centre/rotation"]).apply([0, 0, 1])
    to_contact = OFFSET * axis - [0, 0, RADIUS]
    momentum = INERTIA * run["nodes/centre/angular_velocity"]
    return np.column_stack([axis, 1e6 * np.sum(momentum * to_contact, axis=1)])


def test_a_tippe_top_turns_over(verify):
    """Jellett's constant holds for any friction; it turns from 6 to 155 degrees within a second."""
    coarse, fine = pair("tippe_top", axis_and_jellett, RISEN, 4e-4)
    top = Slider(0.02, [INERTIA] * 3, lambda R: OFFSET * R[:, 2] - [0, 0, RADIUS], 0.3, 0.01)
    exact, _ = top.motion(TILT, 150.0, [0, 0, OFFSET], RISEN)
    jellett = 150e6 * INERTIA * (OFFSET * np.cos(TILT) - RADIUS)
    verify.second_order(S, "tippe top: direction of its axis", coarse[:, :3], fine[:, :3], exact, 2e-4, "SciPy")
    verify(S, "tippe top: Jellett's constant [1e-6 kg m3/s]", fine[:, 3], jellett, "Jellett 1872", relative=1e-4)
    assert exact[-1, 2] < np.cos(np.radians(150))


EGG = """
    mecano: 1
    gravity: [0, 0, -9.81]
    parameters: {short: 20 mm, long: 30 mm, tilt: 1.4, m: 0.08}
    nodes: {egg: {position: [0, 0, '=hypot($short*sin($tilt), $long*cos($tilt))'], orientation: [0, $tilt, 0]}}
    elements:
      egg:
        type: rigid_body
        node: egg
        mass: $m
        inertia: [$m*($short**2 + $long**2)/5, $m*($short**2 + $long**2)/5, $m*2*$short**2/5]
      table:
        {type: contact, nodes: [ground, egg], plane: {normal: [0, 0, 1], point: [0, 0, 0]},
         ellipsoid: {semi_axes: [$short, $short, $long]}, friction: {coefficient: 0.3, regularization: 20 mm/s}}
    initial: {velocities: [{nodes: [egg], angular_velocity: [0, 0, 180]}]}
    time: {end: 0.3, step: 0.2 ms}
"""


def test_an_egg_that_spins_rises_until_it_hops(verify):
    """Moffatt & Shimomura 2002; that it leaves the table for moments was measured by Mitsui et al. 2006."""
    run = RecordedRun(deck(EGG))
    hop = next(event.t for event in run.event_records if event.name == "opens")
    at = np.searchsorted(run.time, [0.04, 0.08, 0.12, 0.16, 0.25])
    squares = np.array([0.02, 0.02, 0.03]) ** 2

    def lever(R):
        return -R @ (squares * R[2]) / np.sqrt(squares @ R[2] ** 2)

    egg = Slider(0.08, 0.08 * (squares.sum() - squares) / 5, lever, 0.3, 0.02)
    rises = rotation(run["nodes/egg/rotation"]).apply([0, 0, 1])[at, 2]
    axes, lifts = egg.motion(1.4, 180.0, [0, 0, 0], run.time[at])
    verify(S, "spinning egg: cosine of the tilt as it rises", rises[:4], axes[:, 2], "SciPy", absolute=1e-4)
    verify(S, "spinning egg: hops after [s]", hop, lifts, "SciPy", relative=2e-4)


CUP = """
    mecano: 1
    gravity: [0, 0, -9.81]
    parameters: {R: 0.5, r: 0.05, m: 0.1, speed: 3, J: 0.4*$m*$r**2}
    nodes: {ball: {position: [$R - $r, 0, 0]}}
    elements:
      ball: {type: rigid_body, node: ball, mass: $m, inertia: [$J, $J, $J]}
      cup:
        {type: contact, nodes: [ground, ball], cylinder: {axis: [0, 0, 1], radius: $R, center: [0, 0, 0], inside: true},
         radius: $r, friction: {coefficient: 20, regularization: 0.01 mm/s}}
    initial: {velocities: [{nodes: [ball], velocity: [0, $speed, 0], angular_velocity: [0, 0, -$speed/$r]}]}
    time: {end: 3, step: 1 ms}
"""


def test_a_ball_that_rolls_in_a_cup_comes_up_again(verify):
    """It bobs at sqrt(2/7) of the rate at which it circles, whatever its weight (Gualtieri et al. 2006)."""
    run = RecordedRun(deck(CUP))
    rate = np.sqrt(2 / 7) * 3 / 0.45
    deepest = 10 / 7 * g / rate**2
    exact = -0.5 * deepest * (1 - np.cos(rate * run.time))
    height = run["nodes/ball/position"][:, 2]
    source = "closed form (golfer's dilemma)"
    verify(S, "ball in a cup: height over its depth", height / deepest, exact / deepest, source, absolute=1e-4)

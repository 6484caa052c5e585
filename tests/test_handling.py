"""Handling of a car in a plane, with four tyres of Fiala and Ackermann steering: braking in a turn, modes in a turn.

The reference has its own equations: velocities (u, v) of the centre of mass along the car and to its left, yaw rate,
spins of the wheels, and the brush tyre of Pacejka (Tire and Vehicle Dynamics, 2012, section 3.2) in combined slip. The
chassis moves in a plane, so the wheels keep their loads.
"""

import numpy as np
from convergence import at_times
from scipy.integrate import solve_ivp
from scipy.optimize import root
from time_runs import RecordedRun, deck

from mecano.analyses.modal import modes
from mecano.analyses.response import ResponseRequest, response

MASS, YAW, SPIN, HEIGHT = 1200.0, 1800.0, 1.2, 0.3  # kg; kg m2, of the chassis about z and of a wheel; of the hubs, m
LATERAL, DRIVING, FRICTION, CONTACT, SLOW, LOAD = 5e4, 8e4, 0.9, 0.12, 0.1, 3000.0  # as in 'fiala'; N
FRONT, REAR, HALF = 1.1, -1.5, 0.75  # of the axles, half a track [m]
WHEELS = {"a": (FRONT, HALF), "b": (FRONT, -HALF), "c": (REAR, HALF), "d": (REAR, -HALF)}

WHEEL = """
      {w}_rim: {{type: rigid_body, node: {w}, mass: 1.0e-6, inertia: [1.2, 1.2, 1.2]}}
      {w}_tyre: {{type: wheel, node: {w}, axis: [{l[0]}, {l[1]}, 0], tire_law: rubber, ground: road}}"""


def steer(radius):
    """Return the angles of the wheels, whose axles meet in one point (Ackermann), ``radius`` from the middle."""
    return {name: np.arctan2(x - REAR, radius - y) for name, (x, y) in WHEELS.items()}


def car(torques, start, time="end: 1, step: 1 ms", radius=25.0, signals="{}", initial=""):
    """Return the deck; ``start`` is (u, v, yaw rate, spins (4,)), at y = 0 with the heading zero, or ``initial``."""
    u, v, rate, *spins = (float(x) for x in start)
    left = {w: (-np.sin(angle), np.cos(angle)) for w, angle in steer(radius).items()}
    hinge = "{{type: hinge, nodes: [{w}_knuckle, {w}], axis: [{l[0]}, {l[1]}, 0]}}"
    turns = "{{nodes: [{w}], angular_velocity: [{s} * {l[0]}, {s} * {l[1]}, 0], about: own}}"
    places = "".join(
        f", {w}{part}: {{position: [{x}, {y}, 0.3]}}" for w, (x, y) in WHEELS.items() for part in ("_knuckle", "")
    )
    joints = "".join(f"\n      {w}: " + hinge.format(w=w, l=left[w]) for w in WHEELS)
    spinning = "".join("\n        - " + turns.format(w=w, s=s, l=left[w]) for w, s in zip(WHEELS, spins, strict=True))
    velocities = f"""
      velocities:
        - {{nodes: all, velocity: [{u}, {v}, 0], angular_velocity: [0, 0, {rate}], about: [0, 0, 0.3]}}
        {spinning}"""
    moment = "{{type: joint_moment, joint: {w}, value: {t}}}"
    loads = ", ".join(f"{w}: " + moment.format(w=w, t=t) for w, t in zip(WHEELS, torques, strict=True))
    return deck(f"""
    mecano: 1
    gravity: none
    nodes: {{car: {{position: [0, 0, 0.3]}}{places}}}
    elements:
      body: {{type: rigid_body, node: car, mass: {MASS}, inertia: [500, 1500, {YAW}],
              attached: [a_knuckle, b_knuckle, c_knuckle, d_knuckle]}}
      {"".join(WHEEL.format(w=w, l=left[w]) for w in WHEELS)}
    joints:
      plane: {{type: planar, nodes: [ground, car], axis: [0, 0, 1]}}
      {joints}
    loads: {{{loads}}}
    signals: {signals}
    tire_laws:
      rubber:
        radius: {HEIGHT + LOAD / 5e6}
        radial: {{linear: {{slope: 5.0e6}}}}
        fiala: {{cornering_stiffness: {LATERAL}, longitudinal_stiffness: {DRIVING}, friction: {FRICTION},
                contact_length: {CONTACT}, least_speed: {SLOW}}}
    grounds: {{road: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
    initial: {initial or velocities}
    time: {{{time}}}
    """)


def brush(forward, sideways, spin):
    """Return (force along the wheel, force to its left, aligning moment) of a tyre at the velocity of its contact."""
    slip = forward - HEIGHT * spin
    rolling = forward - slip
    G = -np.array([DRIVING * slip, LATERAL * sideways]) / np.hypot(rolling, SLOW)
    x = np.hypot(*G) / (3 * FRICTION * LOAD)
    if x >= 1.0:
        return *(G / (3 * x)), 0.0
    aligning = CONTACT / 6 * LATERAL * sideways * rolling / (rolling**2 + SLOW**2) * (1 - x) ** 3
    return *(G * (1 - x + x**2 / 3)), aligning


def rates(state, torques, radius=25.0):
    """Return the rates of (u, v, yaw rate, spins (4,))."""
    u, v, rate, *spins = state
    total, turning, angles = np.zeros(3), [], steer(radius)
    for (w, (x, y)), spin, torque in zip(WHEELS.items(), spins, torques, strict=True):
        c, s = np.cos(angles[w]), np.sin(angles[w])
        along, left = u - rate * y, v + rate * x
        F, S, M = brush(c * along + s * left, c * left - s * along, spin)
        fx, fy = c * F - s * S, s * F + c * S
        total += fx, fy, x * fy - y * fx + M
        turning.append((torque - HEIGHT * F) / SPIN)
    return [total[0] / MASS + rate * v, total[1] / MASS - rate * u, total[2] / (YAW + 4 * SPIN), *turning]


def test_a_car_brakes_in_a_turn(verify):
    """From 15 m/s, at 4.4 m/s2 along the path and up to 4.8 m/s2 across it; friction admits 9 m/s2 in all."""
    torques, start, times = (-500.0, -500.0, -300.0, -300.0), [15.0, 0.0, 0.0, *[50.0] * 4], [0.4, 0.8, 1.2]

    def motion(t, state):
        heading, u, v = state[2], state[3], state[4]
        c, s = np.cos(heading), np.sin(heading)
        return [c * u - s * v, s * u + c * v, state[5], *rates(state[3:], torques)]

    exact = solve_ivp(motion, (0, 1.2), [0, 0, 0, *start], "Radau", t_eval=times, rtol=1e-9, atol=1e-10).y
    found = []
    for step in ("1 ms", "0.5 ms"):
        run = RecordedRun(car(torques, start, f"end: 1.2, step: {step}"))
        place, turn = run["nodes/car/position"], run["nodes/car/angular_velocity"]
        found.append(at_times(run, np.column_stack([place[:, :2], turn[:, 2]]), times))
    what = "car that brakes in a turn: place [m] and yaw rate [rad/s]"
    verify.second_order("Tyres", what, *found, exact[[0, 1, 5]].T, 5e-8, "two-track equations, SciPy")


def steady(radius):
    """Return (torques, start) of a car that keeps its 13 m/s in a turn: the rear wheels drive it."""

    def balance(unknown):
        return rates([13.0, *unknown[:6]], (0.0, 0.0, unknown[6], unknown[6]), radius)

    found = root(balance, [0.0, 13 / radius, *[13 / HEIGHT] * 4, 10.0], tol=1e-13).x
    return (0.0, 0.0, found[6], found[6]), np.array([13.0, *found[:6]])


def test_modes_of_a_car_in_a_steady_turn(verify):
    """At 5.4 m/s2 across, in axes that turn with the car.

    Besides those of the reference there are the free motions: place and heading, and the angles of the wheels.
    """
    torques, start = steady(25.0)
    steps = 1e-5 * np.eye(7)
    slopes = [np.subtract(rates(start + d, torques), rates(start - d, torques)) / 2e-5 for d in steps]
    exact = np.linalg.eigvals(np.transpose(slopes))
    _, found, _ = modes(car(torques, start), None, number=12, frame="car")
    assert found.residuals.max() < 1e-8
    moving = [value for value in found.values if abs(value - 1j * start[2]) > 1e-6 and abs(value) > 1e-6]
    exact = [value for value in exact if value.imag >= 0.0]
    parts = [np.sort_complex(values).view(float) for values in (np.array(moving, complex), np.array(exact, complex))]
    what = "car in a steady turn at 5.4 m/s2: real and imaginary parts of the eigenvalues [1/s]"
    verify("Tyres", what, *parts, "two-track equations", absolute=1e-6)


def test_growth_that_inertial_axes_cause_is_reported():
    """A turn of 250 m: the equations change little while a wheel turns, but as fast as the slow motions of the car."""
    torques, start = steady(250.0)
    turning = car(torques, start, radius=250.0)
    text, found, _ = modes(turning, None, number=12)
    assert found.values.real.max() > 0.5 * start[2]
    assert "hold for this instant only, and may grow" in text and "see --frame" in text
    text, found, _ = modes(turning, None, number=12, frame="car")
    assert found.values.real.max() < 1e-6 and "in these axes" not in text
    for frame, low, reported in (("inertial", 0.01, True), ("inertial", 1.0, False), ("car", 0.01, False)):
        request = ResponseRequest(
            inputs=["c.value"], outputs=["car.angular_velocity.z"], low=low, high=2.0, frame=frame
        )
        text, _ = response(turning, None, request)
        assert ("Hz the response holds for this instant only" in text) == reported


def turning(rate, centre, radius=25.0):
    """Return the RecordedRun of a car that starts in a steady turn of the yaw ``rate`` about the ``centre`` (2,).

    Its steering is that of a turn of ``radius``; an integrator finds the torque of the rear wheels.
    """
    signals = f"""
      missing: {rate} - car.angular_velocity.z
      stored: {{type: integrator, input: missing}}
      torque: {{type: formula, value: 1000*stored, unit: N m}}"""
    initial = f"{{steady: {{angular_velocity: [0, 0, {rate}], about: [{centre[0]}, {centre[1]}, 0]}}}}"
    still = np.zeros(7)
    return RecordedRun(car((0.0, 0.0, "torque", "torque"), still, "end: 0.5, step: 5 ms", radius, signals, initial))


def test_a_car_starts_in_a_steady_turn(verify):
    """Found from a place 6 m off, without slip: speed, slip angle and torque of the two-track equations, which last."""
    torques, (u, v, rate, *_) = steady(25.0)
    run = turning(rate, (0.0, 25.0))
    place = run["nodes/car/position"][:, :2] - [0.0, 25.0]
    speed, torque = np.linalg.norm(run["nodes/car/velocity"], axis=1), run["signals/torque/value"].ravel()
    ahead = run["nodes/a_knuckle/position"][0, :2] - run["nodes/c_knuckle/position"][0, :2]
    moves, most = run["nodes/car/velocity"][0, :2], np.hypot(u, v)
    aside = (ahead[0] * moves[1] - ahead[1] * moves[0]) / np.linalg.norm(ahead)
    found, exact = [speed[0], np.linalg.norm(place[0]), aside, torque[0]], [most, most / rate, v, torques[2]]
    what = "car in a steady turn of given yaw rate: speed [m/s], radius [m], sideslip [m/s], torque [N m]"
    verify("Tyres", what, np.array(found), np.array(exact), "two-track equations", relative=1e-6)
    assert np.ptp(np.linalg.norm(place, axis=1)) < 1e-5 and np.ptp(speed) < 1e-5

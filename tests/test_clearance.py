"""Pins with clearance: a slider-crank whose rod bounces in the slider, and a Geneva drive."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from time_runs import RecordedRun, deck

R, L, SPEED, G = 0.05, 0.15, 60.0, 9.81  # crank and rod [m], rad/s
ROD, SLIDER, J = 0.3, 0.5, 0.3 * 0.15**2 / 12  # kg, kg m2
CLEARANCE, RESTITUTION, END = 0.5e-3, 0.4, 0.03
MASSES = np.array([J + ROD * L**2 / 4, SLIDER])  # of the angle of the rod and of the slider
SLIDER_CRANK = f"""
    mecano: 1
    gravity: [0, {-G}, 0]
    nodes:
      crank: {{position: [0, 0, 0]}}
      crank_pin: {{position: [{R}, 0, 0]}}
      rod: {{position: [{R}, 0, 0]}}
      pin: {{position: [{R + L}, 0, 0]}}
      slider: {{position: [{R + L}, 0, 0]}}
    elements:
      crank: {{type: rigid_link, nodes: [crank, crank_pin]}}
      rod:
        {{type: rigid_body, node: rod, mass: {ROD}, center_of_mass: [{L / 2}, 0, 0], inertia: [1.0e-5, {J}, {J}],
         attached: [pin]}}
      slider: {{type: point_mass, node: slider, mass: {SLIDER}}}
      hole:
        {{type: contact, nodes: [slider, pin], cylinder: {{axis: [0, 0, 1], radius: {0.01 + CLEARANCE}, inside: true}},
         radius: 10 mm, restitution: {RESTITUTION}}}
    joints:
      bearing: {{type: hinge, nodes: [ground, crank], axis: [0, 0, 1]}}
      motor: {{type: prescribed_angle, nodes: [ground, crank], axis: [0, 0, 1], value: {{linear: {{slope: {SPEED}}}}}}}
      big_end: {{type: hinge, nodes: [crank_pin, rod], axis: [0, 0, 1]}}
      bore: {{type: prismatic, nodes: [ground, slider], axis: [1, 0, 0]}}
    initial:
      velocities:
        - {{nodes: [crank, crank_pin], angular_velocity: [0, 0, {SPEED}], about: [0, 0, 0]}}
        - {{nodes: [rod, pin], velocity: [0, {R * SPEED}, 0], angular_velocity: [0, 0, {-R * SPEED / L}],
           about: [{R}, 0, 0]}}
    time: {{end: {END}, step: 1.0e-4, method: radau, adaptive: {{tolerance: 1.0e-7}}}}
"""


def pin_in_hole(t, q):
    """Distance of pin and hole, its normal, gradient by the angle of the rod and the slider, and rate.

    q: angle of the rod and place of the slider, and their rates.
    """
    rod, x, rod_rate, x_rate = q
    along, across = np.array([np.cos(rod), np.sin(rod)]), np.array([-np.sin(rod), np.cos(rod)])
    crank = R * np.array([np.cos(SPEED * t), np.sin(SPEED * t)])
    d = crank + L * along - [x, 0.0]
    v = SPEED * np.array([-crank[1], crank[0]]) + L * rod_rate * across - [x_rate, 0.0]
    n = d / np.hypot(*d)
    free = -(SPEED**2) * crank - L * rod_rate**2 * along  # acceleration without those of the coordinates
    curved = n @ free + (v @ v - (n @ v) ** 2) / np.hypot(*d)
    return np.hypot(*d), np.array([L * across @ n, -n[0]]), n @ v, curved


def accelerations(t, q, touches):
    """Of both coordinates, and the force (< 0 pushes) with which the pin is held at its distance if it touches."""
    across, crank = np.array([-np.sin(q[0]), np.cos(q[0])]), R * np.array([np.cos(SPEED * t), np.sin(SPEED * t)])
    moment = ROD * L / 2 * (SPEED**2 * across @ crank - G * np.cos(q[0]))
    a = np.array([moment, 0.0]) / MASSES
    if not touches:
        return a, 0.0
    _, gradient, _, curved = pin_in_hole(t, q)
    force = -(gradient @ a + curved) / (gradient**2 @ (1.0 / MASSES))
    return a + force * gradient / MASSES, force


def bounces():
    """Times of the shocks and their impulses, ever smaller until the pin stays; and (angle, place) at the end."""
    t, q, touches, shocks = 0.0, np.array([0.0, R + L, -R * SPEED / L, 0.0]), False, []
    while t < END:

        def rates(t, q, touches=touches):
            return [*q[2:], *accelerations(t, q, touches)[0]]

        def event(t, q, touches=touches):
            return -accelerations(t, q, True)[1] if touches else CLEARANCE - pin_in_hole(t, q)[0]

        event.terminal, event.direction = True, -1
        found = solve_ivp(rates, (t, END), q, "DOP853", rtol=1e-12, atol=1e-14, events=event, max_step=1e-4)
        t, q = found.t[-1], found.y[:, -1].copy()
        if found.status == 1 and touches:
            touches = False
        elif found.status == 1:
            distance, gradient, approach, _ = pin_in_hole(t, q)
            e = RESTITUTION if approach > 2e-5 else 0.0
            impulse = (1.0 + e) * approach / (gradient**2 @ (1.0 / MASSES))
            q[2:] -= impulse * gradient / MASSES
            q[:2] -= gradient / (gradient @ gradient) * (distance - CLEARANCE + 1e-15)
            shocks.append((t, impulse))
            touches = e == 0.0
    return np.array(shocks), q


@pytest.mark.filterwarnings("ignore:invalid value")  # in the middle of the hole, where there is no normal
def test_a_rod_bounces_in_its_slider(verify):
    """Thirteen shocks, ever smaller, until the pin lies in the hole; at 0.029 s it lifts off."""
    recorded = RecordedRun(deck(SLIDER_CRANK))
    shocks, (rod, x, *_) = bounces()
    closes = [record for record in recorded.event_records if record.name == "closes"]
    large = slice(0, 6)
    found = np.array([(record.t, record.impulse) for record in closes])
    assert [record.name for record in recorded.event_records][-1] == "opens" and len(shocks) == len(found) == 13
    source = "SciPy with both coordinates, events and impulses"
    verify("Shocks", "pin with clearance: times [s]", found[:, 0], shocks[:, 0], source, absolute=1e-9)
    verify("Shocks", "pin with clearance: impulses [N s]", found[large, 1], shocks[large, 1], source, relative=1e-6)
    place, angle = recorded["nodes/slider/position"][-1, 0], recorded["joints/big_end/angle"][-1] + SPEED * END
    verify("Shocks", "pin with clearance: slider and rod at the end", [place, angle], [x, rod], source, absolute=1e-8)


APART, PIN, PLAY, WALL = 0.1, 5e-3, 2e-5, 2e-3  # m: the axes; radius of the pin, play at each wall, radius of the walls
CRANK, TURNING, BEGINS = APART / np.sqrt(2.0), 10.0, np.radians(-50.0)  # m, rad/s; the pin enters at -45 degrees


def geneva():
    """The deck of a Geneva drive of four slots: a pin between two walls, which are capsules on the wheel."""
    out, across, length = -np.array([1.0, 1.0]) / np.sqrt(2.0), np.array([1.0, -1.0]) / np.sqrt(2.0), 0.055
    inner = np.array([APART, 0.0]) + out * (APART / np.sqrt(2.0) - length)
    centers = {name: inner + side * (PIN + PLAY + WALL) * across for name, side in (("fore", 1.0), ("aft", -1.0))}
    walls = "".join(
        f"""
      {name}:
        {{type: contact, nodes: [wheel, pin], radius: {PIN},
         capsule: {{axis: [-1, -1, 0], length: {length}, radius: {WALL}, center: [{x}, {y}, 0]}}}}"""
        for name, (x, y) in centers.items()
    )
    return deck(f"""
    mecano: 1
    gravity: none
    nodes:
      crank: {{position: [0, 0, 0]}}
      pin: {{position: [{CRANK * np.cos(BEGINS)}, {CRANK * np.sin(BEGINS)}, 0]}}
      wheel: {{position: [{APART}, 0, 0]}}
    elements:
      crank: {{type: rigid_link, nodes: [crank, pin]}}
      wheel: {{type: rigid_body, node: wheel, mass: 1, inertia: [1.0e-4, 1.0e-4, 1.0e-4]}}{walls}
    joints:
      shaft: {{type: hinge, nodes: [ground, crank], axis: [0, 0, 1]}}
      axle: {{type: hinge, nodes: [ground, wheel], axis: [0, 0, 1]}}
      motor: {{type: prescribed_angle, nodes: [ground, crank], axis: [0, 0, 1], value: "{TURNING}*time"}}
    initial: {{velocities: [{{nodes: [crank, pin], angular_velocity: [0, 0, {TURNING}], about: [0, 0, 0]}}]}}
    time: {{end: {np.pi / 20 - 2 * (BEGINS + np.pi / 4) / 10}, step: 1.0e-4}}
    """)


def test_a_geneva_drive_turns_its_wheel_by_a_quarter():
    """Driven by one wall until it is fastest, braked by the other: the angle is that of the pin, but for the play."""
    recorded = RecordedRun(geneva())
    crank = BEGINS + TURNING * recorded.time
    driven = np.abs(crank) < np.radians(44.9)
    x, y = APART - CRANK * np.cos(crank), CRANK * np.sin(crank)
    angle = np.arctan2(y, -x) % (2.0 * np.pi) - 1.25 * np.pi  # the slot points to the pin
    play = PLAY / np.hypot(x, y)
    error = (recorded["joints/axle/angle"] - angle)[driven] / play[driven]
    assert np.abs(error).max() < 1.0 + 1e-3 and error.max() - error.min() > 1.9  # from one wall to the other
    names = [(record.element.split("'")[1], record.name) for record in recorded.event_records]
    assert names == [("aft", "closes"), ("aft", "opens"), ("fore", "closes"), ("fore", "opens")]
    fastest = np.argmax(-recorded["joints/axle/rate"])
    assert recorded["joints/axle/rate"][fastest] == pytest.approx(-TURNING / (np.sqrt(2.0) - 1.0), rel=1e-6)
    assert recorded.event_records[1].t == pytest.approx(-BEGINS / TURNING, abs=1e-4)
    assert recorded["joints/axle/angle"][-1] == pytest.approx(-np.pi / 2.0, abs=1e-3)

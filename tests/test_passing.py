"""Contacts, taut cables and conditions that begin and end within what would be one step of the motion without them."""

import math

import pytest
from time_runs import RecordedRun, deck

G = 9.81
STACK = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {big: {position: [0, 0, 1.12]}, small: {position: [0, 0, 1.275]}}
    elements:
      big: {type: rigid_body, node: big, mass: 0.6, inertia: [1.0e-3, 1.0e-3, 1.0e-3]}
      small: {type: point_mass, node: small, mass: 0.06}
      floor:
        {type: contact, nodes: [ground, big], plane: {normal: [0, 0, 1], point: [0, 0, 0]}, radius: 0.12,
         restitution: 0.8}
      kiss: {type: contact, nodes: [big, small], sphere: {radius: 0.12}, radius: 0.033, restitution: 0.7}
    time: {end: 0.8, step: 1 ms, METHOD, adaptive: {tolerance: 1.0e-4}}
"""
CEILING = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {ball: {position: [0, 0, 0]}}
    elements:
      ball: {type: point_mass, node: ball, mass: 1}
      lamp: {type: CONTACT, restitution: 0.5}
    grounds: {ceiling: {plane: {point: [0, 0, 0.51], normal: [0, 0, -1]}}}
    initial: {velocities: [{nodes: [ball], velocity: [0, 0, 3.2]}]}
    time: {end: 0.52, step: 130 ms}
"""
TETHER = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {foot: {position: [0, 0, -1], fixed: true}, ball: {position: [0, 0, 0]}}
    elements:
      ball: {type: point_mass, node: ball, mass: 1}
      tether:
        {type: cable, nodes: [foot, ball], axial_stiffness: 1.0e+5, natural_length: 1.51, at_full_length: CAUGHT}
    initial: {velocities: [{nodes: [ball], velocity: [0, 0, 3.2]}]}
    time: {end: 0.52, step: 130 ms, METHOD}
"""
BAR = """
    mecano: 1
    gravity: none
    nodes: {bar: {position: [0, 0, 0.499]}, tip: {position: [0.5, 0, 0.499]}}
    elements:
      bar: {type: rigid_body, node: bar, mass: 2, inertia: [0.1, 0.1, 0.1], attached: [tip]}
      floor: {type: contact, nodes: [ground, tip], plane: {normal: [0, 0, 1], point: [0, 0, 0]}}
    initial: {velocities: [{nodes: [bar], angular_velocity: [0, 1, 0]}]}
    time: {end: 2.1, step: 0.7}
"""


@pytest.mark.parametrize("method", ["rho_inf: 0.8", "method: radau"])
def test_a_small_ball_is_thrown_up_by_one_that_bounces_below_it(method):
    """The balls meet 0.25 ms behind the bounce of the lower one, at 8 m/s; a step of 40 ms would pass over it."""
    recorded = RecordedRun(deck(STACK.replace("METHOD", method)))
    first = math.sqrt(2.0 / G)
    second = first + 0.002 / (1.8 * G * first)
    up, down = 0.8 * G * first - G * (second - first), -G * second
    thrown = (0.6 * up + 0.06 * down + 0.7 * 0.6 * (up - down)) / 0.66
    height = 1.275 - 0.5 * G * second**2 + thrown * (0.8 - second) - 0.5 * G * (0.8 - second) ** 2
    assert recorded["nodes/small/position"][-1, 2] == pytest.approx(height, abs=1e-9)


@pytest.mark.parametrize(
    "contact",
    [
        "plane_contact, node: ball, ground: ceiling",
        "contact, nodes: [ground, ball], plane: {normal: [0, 0, -1], point: [0, 0, 0.51]}",
    ],
)
def test_a_ball_bounces_off_a_ceiling_that_it_would_pass_up_and_down_in_one_step(contact):
    recorded = RecordedRun(deck(CEILING.replace("CONTACT", contact)))
    speed = math.sqrt(3.2**2 - 2.0 * G * 0.51)
    (met,) = recorded.event_records
    assert met.t == pytest.approx((3.2 - speed) / G, abs=1e-9)
    assert recorded["nodes/ball/velocity"][-1, 2] == pytest.approx(-0.5 * speed - G * (0.52 - met.t), abs=1e-9)


@pytest.mark.parametrize("caught", ["shock", "hold"])
@pytest.mark.parametrize("method", ["rho_inf: 0.8", "method: radau"])
def test_a_ball_pulls_a_cable_taut_that_would_be_slack_at_both_ends_of_a_step(method, caught):
    """It rises to 0.522 m, the cable ends at 0.51 m; without restitution it falls from there."""
    recorded = RecordedRun(deck(TETHER.replace("METHOD", method).replace("CAUGHT", caught)))
    taut = (3.2 - math.sqrt(3.2**2 - 2.0 * G * 0.51)) / G
    assert recorded.event_records[0].t == pytest.approx(taut, abs=1e-9)
    height = 0.51 - 0.5 * G * (0.52 - taut) ** 2
    assert recorded["nodes/ball/position"][-1, 2] == pytest.approx(height, abs=1e-9)


def test_an_elastic_cable_goes_taut_within_a_step():
    recorded = RecordedRun(deck(TETHER.replace("METHOD", "rho_inf: 0.8").replace("CAUGHT", "stretch")))
    taut = (3.2 - math.sqrt(3.2**2 - 2.0 * G * 0.51)) / G
    assert recorded.event_records[0].t == pytest.approx(taut, abs=1e-9)


@pytest.mark.parametrize(("speed", "times"), [(0.0, 1), (10.0, 0)])
def test_an_elastic_cable_stays_slack_if_its_stretch_is_within_the_error_of_the_step(speed, times):
    """It is stretched by 1 um; an oscillator of 100 Hz, which no step resolves, moves by 16 mm or rests."""
    recorded = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes:
          foot: {{position: [0, 0, -1], fixed: true}}
          ball: {{position: [0, 0, 0]}}
          mass: {{position: [0, 0, -2]}}
        elements:
          ball: {{type: point_mass, node: ball, mass: 1}}
          tether: {{type: cable, nodes: [foot, ball], axial_stiffness: 1.0e+5,
                   natural_length: {1.0 + 3.2**2 / (2.0 * G) - 1e-6!r}}}
          mass: {{type: point_mass, node: mass, mass: 1}}
          spring: {{type: spring_damper, nodes: [foot, mass], natural_length: 0.999975,
                   law: {{spring: {{stiffness: 3.924e+5}}}}}}
        initial:
          velocities: [{{nodes: [ball], velocity: [0, 0, 3.2]}}, {{nodes: [mass], velocity: [0, 0, {speed}]}}]
        time: {{end: 0.52, step: 130 ms, rho_inf: 0.8}}
        """)
    )
    assert sum(event.name == "goes taut" for event in recorded.event_records) == times


def test_a_bar_that_turns_strikes_the_floor_with_its_end():
    """It would dip into it for 0.13 s of a step of 0.7 s; the impulse m v J/(J + m x^2) acts at the distance x."""
    recorded = RecordedRun(deck(BAR))
    met = recorded.event_records[0]
    angle = math.asin(0.499 / 0.5)
    x = 0.5 * math.cos(angle)
    assert met.t == pytest.approx(angle, abs=1e-6)
    assert met.impulse == pytest.approx(2.0 * x * 0.1 / (0.1 + 2.0 * x**2), rel=1e-6)


def test_a_ball_that_passes_beside_another_one_meets_nothing():
    """The least distance of the centres is 0.1 mm more than the sum of the radii."""
    text = STACK.replace("METHOD", "rho_inf: 0.8").replace(
        "small: {position: [0, 0, 1.275]}", "small: {position: [0.1531, 0, 1.5]}"
    )
    assert {record.element for record in RecordedRun(deck(text)).event_records} == {"contact 'floor'"}


DOCKING = """
    mecano: 1
    gravity: none
    nodes: {target: {position: [0, 0, 0]}, chaser: {position: [-10, 0.05, 0]}}
    elements:
      target: {type: rigid_body, node: target, mass: 100, inertia: [10, 10, 10]}
      chaser: {type: rigid_body, node: chaser, mass: 50, inertia: [5, 5, 5]}
    signals: {distance: "hypot(chaser.position.x - target.position.x, chaser.position.y - target.position.y)"}
    joints: {port: {type: grip, nodes: [target, chaser], close: {when: distance < 0.1}}}
    initial: {velocities: [{nodes: [chaser], velocity: [0.02, 0, 0]}]}
    time: {end: 1000, step: 1, METHOD}
"""


@pytest.mark.parametrize("method", ["adaptive: {tolerance: 1.0e-4}", "method: radau, adaptive: {tolerance: 1.0e-4}"])
def test_a_spacecraft_is_gripped_that_would_pass_its_port_in_one_step(method):
    """It comes within 0.1 m for 9 s; steps of its free flight take 50 s. Momentum: 50/150 of its speed remain."""
    recorded = RecordedRun(deck(DOCKING.replace("METHOD", method)))
    (closed,) = recorded.event_records
    assert closed.t == pytest.approx((10.0 - math.sqrt(0.1**2 - 0.05**2)) / 0.02, abs=1e-6)
    common = [50 * recorded["nodes/chaser/velocity"][-1], 100 * recorded["nodes/target/velocity"][-1]]
    assert sum(common)[0] == pytest.approx(1.0)

"""Motions of textbooks with contacts, spinning bodies, shafts and cars, compared with closed forms."""

from textwrap import dedent

import numpy as np
from convergence import pair
from scipy.linalg import eigvals
from scipy.spatial.transform import Rotation
from small_motions import eigenvalues
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.sweep import sweep

S, g = "Motions of textbooks", 9.81


def test_a_cat_turns_over_without_angular_momentum(verify):
    """Each half turns by -psi about its axis, and the bent body by psi/2 about the line of the spine."""
    at = np.arange(1, 9) / 20
    u = at / 0.4
    psi = 2 * np.pi * u**3 * (10 - 15 * u + 6 * u**2)
    body = Rotation.from_rotvec(-psi[:, None] * [np.sqrt(0.75), 0, 0.5])
    space = Rotation.from_rotvec(psi[:, None] * [0.5, 0, 0])
    exact = (space * body * Rotation.from_rotvec([0, -np.pi / 6, 0])).as_quat()[:, [3, 0, 1, 2]]
    coarse, fine = pair("falling_cat", lambda run: run["nodes/front/rotation"], at, 5e-3)
    signs = np.sign(np.sum(exact * fine, axis=1))[:, None]
    source = "Kane & Scher 1969"
    verify.second_order(S, "falling cat: attitude of a half", coarse, fine, signs * exact, 1e-5, source)
    waist = RecordedRun(input_deck("falling_cat"))["nodes/waist/position"][-1]
    lowest = 1 - 0.5 * g * 0.4**2 + 2 * 0.06  # the centre of mass is now below the waist
    np.testing.assert_allclose(waist, [0, 0, lowest], atol=1e-5)


LADDER = """
    mecano: 1
    gravity: [0, 0, -9.81]
    parameters: {length: 2 m, lean: 60 deg}
    nodes:
      middle: {position: [$length/2*cos($lean), 0, $length/2*sin($lean)]}
      foot: {position: [$length*cos($lean), 0, 0]}
      top: {position: [0, 0, $length*sin($lean)]}
    elements:
      ladder: {type: rigid_body, node: middle, mass: 3, inertia: [1, 1, 1], attached: [foot, top]}
      floor: {type: contact, nodes: [ground, foot], plane: {normal: [0, 0, 1], point: [0, 0, 0]}}
      wall: {type: contact, nodes: [ground, top], plane: {normal: [1, 0, 0], point: [0, 0, 0]}}
    joints: {plane: {type: planar, nodes: [ground, middle], axis: [0, 1, 0]}}
    time: {end: 1, step: 1 ms, until: wall.closed < 0.5}
"""


def test_a_ladder_that_slides_leaves_the_wall(verify):
    """Smooth wall and floor: the push of the wall ends at two thirds of the height at the start."""
    run = RecordedRun(deck(LADDER))
    assert [event.name for event in run.event_records] == ["closes", "closes", "opens", "ends the run"]
    rises = run["nodes/top/position"][[0, -1], 2]
    source = "closed form (Whittaker, Analytical Dynamics 1937)"
    verify(S, "sliding ladder: height where it leaves the wall [m]", rises[1], rises[0] * 2 / 3, source, relative=2e-6)


MASSE = """
    mecano: 1
    gravity: [0, 0, -9.81]
    parameters: {r: 30 mm, J: 0.4*0.17*$r**2}
    nodes: {ball: {position: [0, 0, $r]}}
    elements:
      ball: {type: rigid_body, node: ball, mass: 0.17, inertia: [$J, $J, $J]}
      cloth:
        {type: contact, nodes: [ground, ball], plane: {normal: [0, 0, 1], point: [0, 0, 0]}, radius: $r,
         friction: {coefficient: 0.2, regularization: 0.1 mm/s}}
    initial: {velocities: [{nodes: [ball], velocity: [1, 0, 0], angular_velocity: [20, -40, 0]}]}
    time: {end: 0.6, step: 1 ms}
"""


def test_a_billiard_ball_with_masse(verify):
    """It slides on a parabola, in a constant direction, until it rolls straight on (Coriolis, Jeu de billard, 1835)."""
    run = RecordedRun(deck(MASSE))
    speed = np.array([1.0, 0.0])
    slip = speed + 0.03 * np.array([40.0, 20.0])  # v + w x (-r e_z)
    braking, ends = 0.2 * g * slip / np.linalg.norm(slip), 2 * np.linalg.norm(slip) / (7 * 0.2 * g)
    t = run.time[:, None]
    slides = np.minimum(t, ends)
    exact = speed * slides - 0.5 * braking * slides**2 + (speed - braking * ends) * (t - slides)
    found = run["nodes/ball/position"][:, :2]
    verify(S, "billiard ball with masse: path [m]", found, exact, "Coriolis 1835", absolute=1e-8)


TABLE = """
    mecano: 1
    gravity: [0, 0, -9.81]
    parameters: {w: 20*pi, e: 0.5, u: 9.81*0.05*(1 - $e)/(1 + $e), A: 1.25*$u/$w, phase: acos($u/($A*$w))}
    nodes: {table: {position: [0, 0, 0]}, ball: {position: [0, 0, 1.0e-9]}}
    elements:
      ball: {type: point_mass, node: ball, mass: 1}
      table: {type: rigid_body, node: table, mass: 1, inertia: [1.0e-6, 1.0e-6, 1.0e-6]}
      top: {type: contact, nodes: [table, ball], plane: {normal: [0, 0, 1], point: [0, 0, 0]}, restitution: $e}
    joints:
      guide: {type: prismatic, nodes: [ground, table], axis: [0, 0, 1]}
      shaker:
        {type: prescribed_position, node: table, direction: [0, 0, 1], value: $A*(sin($w*time + $phase) - sin($phase))}
    initial:
      velocities: [{nodes: [ball], velocity: [0, 0, 9.81*0.05]}, {nodes: [table], velocity: [0, 0, $u]}]
    time: {end: 1.05, step: 0.5 ms}
"""


def test_a_ball_bounces_once_in_each_period_of_its_table(verify):
    """A stable motion: the table is at g T/2 (1 - e)/(1 + e) in each impact (Holmes, J. Sound Vib. 84, 1982)."""
    run = RecordedRun(deck(TABLE))
    found = [event.t for event in run.event_records if event.name == "closes"]
    verify(S, "ball on a shaking table: impacts [s]", found, 0.1 * np.arange(1, 11), "Holmes 1982", absolute=2e-8)


SHAFT = """
    mecano: 1
    gravity: none
    parameters: {speed: 50}
    nodes: {shaft: {position: [0, 0, 0]}, disc: {position: [0, 0, 0]}}
    elements:
      shaft: {type: rigid_body, node: shaft, mass: 1, inertia: [0.1, 0.1, 0.1]}
      disc: {type: point_mass, node: disc, mass: 2}
      bending: {type: bushing, nodes: [shaft, disc], stiffness: [1.0e5, 2.0e4, 3.2e4, 0, 0, 0]}
    joints: {bearing: {type: hinge, nodes: [ground, shaft], axis: [1, 0, 0]}}
    initial: {steady: {angular_velocity: [$speed, 0, 0], about: [0, 0, 0]}}
    time: {end: 1, step: 1 ms}
"""


def test_a_shaft_that_is_not_round_is_unstable_between_its_critical_speeds(verify, tmp_path):
    """Disc of 2 kg, stiffnesses of the shaft 20 and 32 kN/m (Smith, Proc. Royal Society A 142, 1933)."""
    (tmp_path / "shaft.yaml").write_text(dedent(SHAFT))
    (locus,) = sweep(tmp_path / "shaft.yaml", (), ["speed=95:135:20"], frame="shaft").loci
    found = [one.place for one in locus.critical]
    verify(S, "flat shaft: limits of instability [rad/s]", found, [100.0, np.sqrt(1.6e4)], "Smith 1933", relative=1e-9)


DAMPER = """
    mecano: 1
    gravity: none
    nodes: {hub: {position: [0, 0, 0]}, tube: {position: [0.6, 0, 0]}, bob: {position: [0.6, 0, 0]},
            other: {position: [-0.6, 0, 0]}}
    elements:
      hub: {type: rigid_body, node: hub, mass: 100, inertia: [10, 10, 15], attached: [tube, other]}
      bob: {type: point_mass, node: bob, mass: 0.2}
      other: {type: point_mass, node: other, mass: 0.2}
    joints:
      slide: {type: prismatic, nodes: [tube, bob], axis: [0, 0, 1], sliding_law: {spring: 5, damper: 0.3}}
    initial: {steady: {angular_velocity: [0, 0, 6], about: [0, 0, 0]}}
    time: {end: 1, step: 1 ms}
"""


def test_a_nutation_damper(verify):
    """A bob slides parallel to the spin axis; angular momentum about the body axes, and the force along the tube."""
    found = [z for z in eigenvalues(deck(DAMPER), frame="hub") if abs(z.real) > 1e-5]
    A, B, C, mh, w = 10.0, 10.0 + 2 * 0.2 * 0.36, 15.0 + 2 * 0.2 * 0.36, 0.2 * 0.6, 6.0
    mass = 0.2 * (1 - 0.2 / 100.4)  # the hub recoils
    left = [[A, 0, 0, 0], [0, B, 0, -mh], [0, 0, 1, 0], [0, -mh, 0, mass]]  # of w_x, w_y, z and its rate
    right = [[0, (B - C) * w, 0, 0], [(C - A) * w, 0, mh * w**2, 0], [0, 0, 0, 1], [-mh * w, 0, -5, -0.3]]
    exact = eigvals(right, left)
    exact = exact[np.lexsort((exact.imag, abs(exact).round(9)))]
    what = "spinning satellite with a nutation damper: eigenvalues [1/s]"
    verify(S, what, found, exact, "linear equations (Likins 1966)", relative=1e-8)


CAR = """
    mecano: 1
    gravity: [0, 0, -9.81]
    parameters: {speed: 20}
    nodes:
      $name:
        {repeat: [{name: frame, x: 0}, {name: body, x: 0}, {name: front, x: 1.5}, {name: rear, x: -1.2},
         {name: hub_1, x: 1.5}, {name: hub_2, x: -1.2}], position: [$x, 0, 0.3]}
    elements:
      body: {type: rigid_body, node: body, mass: 1500, inertia: [500, 2500, 2500], attached: [front, rear]}
      rim_$i: {repeat: {i: 1..2}, type: rigid_body, node: hub_$i, mass: 20, inertia: [0.5, 1, 0.5]}
      wheel_$i: {repeat: {i: 1..2}, type: wheel, node: hub_$i, axis: [0, 1, 0], tire_law: tyre, ground: road}
    joints:
      upright:
        {type: generic, nodes: [ground, frame], axis: [0, 0, 1], free: [along_1, along_2, along_axis, about_axis]}
      pitch: {type: hinge, nodes: [frame, body], axis: [0, 1, 0]}
      bearing_1: {type: hinge, nodes: [front, hub_1], axis: [0, 1, 0]}
      bearing_2: {type: hinge, nodes: [rear, hub_2], axis: [0, 1, 0]}
    tire_laws:
      tyre: {radius: 0.3, radial: {linear: {slope: 2.0e6}},
             fiala: {cornering_stiffness: 60 kN, friction: 1, least_speed: 1 mm/s}}
    grounds: {road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
    initial: {steady: {velocity: [$speed, 0, 0]}}
    time: {end: 1, step: 1 ms}
"""


def test_an_oversteering_car_diverges_above_its_critical_speed(verify, tmp_path):
    """V^2 = L^2 C_f C_r/(m (a C_f - b C_r)); frame and body lets it pitch about an axis that turns with its heading."""
    (tmp_path / "car.yaml").write_text(dedent(CAR))
    (locus,) = sweep(tmp_path / "car.yaml", (), ["speed=20:40:10"]).loci
    (found,) = [one.place for one in locus.critical]
    exact = np.sqrt(2.7**2 * 60e3 / (1540 * 0.3 - 20 * 2 * 0.3))  # a - b about the centre of mass of all
    source = "Pacejka, Tire and Vehicle Dynamics, 2012, (1.62)"
    verify(S, "single-track car: critical speed [m/s]", found, exact, source, relative=1e-6)

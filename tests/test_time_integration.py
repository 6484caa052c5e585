"""Critical cases of time integration: jumps of loads, corners of motions, many turns in few steps, redundancy."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck

MASS = """
    mecano: 1
    gravity: [0, 0, 0]
    nodes: {a: {position: [0, 0, 0]}}
    elements: {m: {type: point_mass, node: a, mass: 1}}
"""
ROD = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {a: {position: [1, 0, 0.3]}, o: {position: [0, 0, 0], fixed: true}}
    elements: {m: {type: point_mass, node: a, mass: 1}}
    joints: {r: {type: rigid_rod, nodes: [o, a]}}
    time: {end: 0.1, step: 1.0e-3}
"""
BODY = """
    mecano: 1
    gravity: [0, 0, 0]
    nodes: {a: {position: [0, 0, 0]}}
    elements: {m: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}}
"""


@pytest.mark.parametrize("h", [0.1, 0.01])
def test_a_jump_of_a_load_acts_from_its_time_on(h):
    law = "{step: {time: 0.5, rise: 0, from: 0, to: 1}}"
    loads = f"    loads: {{f: {{type: force, node: a, direction: [1, 0, 0], value: {law}}}}}\n"
    m = RecordedRun(deck(MASS + loads + f"    time: {{end: 1.0, step: {h}}}\n"))
    # a constant force for half a second: exact for the integrator, v = 1/2, x = 1/8, work = 1/8
    assert m["nodes/a/velocity"][-1][0] == pytest.approx(0.5, abs=1e-13)
    assert m["nodes/a/position"][-1][0] == pytest.approx(0.125, abs=1e-13)
    assert m["energy/given"][-1] == pytest.approx(0.125, abs=1e-13)


RISES = [1e-4, 1e-8, 1e-10, 1e-12, 1e-13, 1e-15, 7e-18, 1e-18, 1e-90]  # numbers next to 0.05 are 7e-18 apart


@pytest.mark.parametrize("control", ["step: 1.0e-3", "step: 1.0e-3, adaptive: {tolerance: 1.0e-6}"])
@pytest.mark.parametrize("rise", RISES)
def test_an_edge_may_be_as_short_as_time_can_tell(rise, control):
    law = f"{{step: {{time: 0.05, rise: {rise}, from: 0, to: 5}}}}"
    loads = f"    loads: {{f: {{type: force, node: a, direction: [1, 0, 0], value: {law}}}}}\n"
    m = RecordedRun(deck(MASS + loads + f"    time: {{end: 0.1, {control}}}\n"))
    # momentum 5 (0.05 - rise/2), for the edge is symmetric; the step over it may take the force at its end for that in
    # all of it, and the last one be longer by 1e-6 rather than leave so little, of 0.01 s at most
    assert m["nodes/a/velocity"][-1][0] == pytest.approx(0.25 - 2.5 * rise, abs=2.5 * rise + 5e-8)
    assert m.time[-1] == 0.1 and len(m.time) <= 103


def test_steps_end_at_times_that_are_next_to_one_another():
    points = [[0.0, 0.0], [0.05, 0.0], [np.nextafter(0.05, 1.0), 5.0], [np.nextafter(0.1, 0.0), 5.0], [0.1, 5.0]]
    law = f"{{table: {{points: {[[float(x), y] for x, y in points]}, interpolation: linear}}}}"
    loads = f"    loads: {{f: {{type: force, node: a, direction: [1, 0, 0], value: {law}}}}}\n"
    m = RecordedRun(deck(MASS + loads + "    time: {end: 0.1, step: 1.0e-3}\n"))
    assert m["nodes/a/velocity"][-1][0] == pytest.approx(0.25, abs=1e-13) and m.run.motion.t == 0.1


@pytest.mark.parametrize("rise", [1e-7, 1e-8, 1e-9, 1e-10, 1e-12])
def test_reactions_at_the_end_of_a_very_short_step_are_no_rounding(rise):
    """That of the positions, 1e-16 m, over the square of the step would be 4 N of the 2.8 N that there are."""
    extremes = []
    for value in (0.0, rise):
        law = f"{{step: {{time: 0.05, rise: {value}, from: 0, to: 5}}}}"
        m = RecordedRun(deck(ROD + f"    loads: {{f: {{type: force, node: a, direction: [1, 0, 1], value: {law}}}}}\n"))
        tension = m["joints/r/tension"]
        extremes.append((tension.min(), tension.max()))
    np.testing.assert_allclose(extremes[1], extremes[0], rtol=1e-5)


@pytest.mark.parametrize(
    ("control", "error"), [("step: 5.0e-3", 2e-5), ("step: 5.0e-3, method: radau, adaptive: {tolerance: 1e-6}", 1e-6)]
)
def test_a_motion_stops_where_its_table_ends(control, error):
    """A mass on a spring of 10 rad/s runs at 0.2 m/s behind the first, and swings by 0.2/10 m once that stops."""
    law = "{table: {points: [[0, 0], [0.5, 0.1]], interpolation: linear}}"
    m = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{a: {{position: [0, 0, 0]}}, b: {{position: [1, 0, 0]}}}}
        elements:
          b: {{type: point_mass, node: b, mass: 1}}
          s: {{type: spring_damper, nodes: [a, b], law: {{spring: {{stiffness: 100}}}}}}
        joints:
          x: {{type: prescribed_position, node: a, direction: [1, 0, 0], value: {law}}}
          y: {{type: prescribed_position, node: a, direction: [0, 1, 0], value: 0}}
          z: {{type: prescribed_position, node: a, direction: [0, 0, 1], value: 0}}
        initial: {{velocities: [{{nodes: [a, b], velocity: [0.2, 0, 0]}}]}}
        time: {{end: 1, {control}}}
    """)
    )
    assert m["nodes/a/velocity"][m.time > 0.5001, 0] == pytest.approx(0.0, abs=1e-9)
    assert m["nodes/b/position"][-1][0] == pytest.approx(1.1 + 0.02 * np.sin(5.0), abs=error)


def test_reactions_of_a_prescribed_motion_are_of_second_order_across_its_corners():
    errors = []
    for h in (1e-3, 5e-4, 2.5e-4):
        law = "{step: {time: 0.05, rise: 0.1, from: 0, to: 1}}"
        joint = f"    joints: {{f: {{type: prescribed_position, node: a, direction: [1, 0, 0], value: {law}}}}}\n"
        m = RecordedRun(deck(MASS + joint + f"    time: {{end: 0.2, step: {h}}}\n"))
        u = np.clip((m.time - 0.05) / 0.1, 0, 1)
        exact = (60 * u - 180 * u**2 + 120 * u**3) / 0.1**2  # second derivative of the quintic edge
        errors.append(np.abs(m["joints/f/force"].ravel() - exact).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx([2.0, 2.0], abs=0.05)


@pytest.mark.parametrize("control, step", [("rho_inf: 0.8", 1e-2), ("adaptive: {tolerance: 1.0e-4}", 1e-3)])
def test_angles_are_followed_however_long_the_steps(control, step):
    joint = "    joints: {h: {type: hinge, nodes: [ground, a], axis: [0, 0, 1]}}\n"
    spin = "    initial: {velocities: [{nodes: [a], angular_velocity: [0, 0, 400]}]}\n"
    m = RecordedRun(deck(BODY + joint + spin + f"    time: {{end: 1.0, step: {step}, {control}}}\n"))
    assert m["joints/h/angle"][-1] == pytest.approx(400.0, rel=1e-12)  # 64 turns, 4 rad in a step of 1e-2 s


@pytest.mark.parametrize("moment", [1.0, 1e3])
def test_redundant_hinges_without_weight_hold_a_moment_across_their_axis(moment):
    joints = "    joints: {g: {type: hinge, nodes: [ground, a], axis: [0, 0, 1]}, "
    joints += "h: {type: hinge, nodes: [ground, a], axis: [0, 0, 1]}}\n"
    law = f"{{ramp: {{start: 0, end: 1, from: 0, to: {moment}}}}}"
    loads = f"    loads: {{t: {{type: moment, node: a, direction: [1, 0, 0], value: {law}}}}}\n"
    m = RecordedRun(deck(BODY + joints + loads + "    time: {end: 1.0, step: 0.01}\n"))
    tilt = 2.0 * np.linalg.norm(m["nodes/a/rotation"][:, 1:3], axis=1).max()
    assert sum(group.count for group in m.prepared.analysis.redundant) == 2
    assert tilt <= 1e-11 * max(moment, 1.0)  # 1e-11 rad under the weight of the body, in proportion beyond
    carried = m["joints/g/moment"][-1] + m["joints/h/moment"][-1]
    assert np.linalg.norm(carried) == pytest.approx(moment, rel=1e-6)


def test_newmark_without_damping_is_of_second_order():
    errors = []
    for h in (0.02, 0.01, 0.005):
        spring = "    nodes: {a: {position: [1, 0, 0]}, o: {position: [0, 0, 0], fixed: true}}\n"
        text = MASS.replace("    nodes: {a: {position: [0, 0, 0]}}\n", spring)
        text = text.replace(
            "mass: 1}}",
            "mass: 1}, s: {type: spring_damper, nodes: [o, a], natural_length: 0.5, law: {spring: {stiffness: 4}}}}",
        )
        m = RecordedRun(deck(text + f"    time: {{end: 2.0, step: {h}, method: newmark, rho_inf: 1.0}}\n"))
        errors.append(abs(m["nodes/a/position"][-1][0] - (0.5 + 0.5 * np.cos(4.0))))  # omega = 2 rad/s
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx([2.0, 2.0], abs=0.05)


CARRIED = """
    mecano: 1
    gravity: none
    nodes: {wall: {position: [0, 0, 0], fixed: true}, mid: {position: [0, 0, 0.1]}, end: {position: [0, 0, 0.2]}}
    elements:
      block: {type: point_mass, node: end, mass: 1}
      mount: {type: spring_damper, nodes: [wall, mid], law: {spring: 4e5}}
      damper: {type: spring_damper, nodes: [mid, end], law: {damper: 2000}}
    joints: {drive: {type: prescribed_position, node: end, direction: [0, 0, 1], rate: 0.06}}
    initial: {velocities: [{nodes: [end, NODE], velocity: [0, 0, 0.06]}]}
    time: {end: 0.02, step: STEP}
"""


def test_a_node_without_mass_that_a_damper_carries():
    """x = v T (1 - exp(-t/T)), T = 5 ms: first order from rest, off by h v/2; second order from the velocity v."""
    errors = {}
    for node in ("end", "mid"):
        for h in (5e-4, 2.5e-4):
            text = CARRIED.replace("[end, NODE]", "[end]" if node == "end" else "[end, mid]").replace("STEP", f"{h}")
            m = RecordedRun(deck(text))
            x = m["nodes/mid/position"][:, 2] - 0.1
            errors[node, h] = np.abs(x - 0.06 * 5e-3 * (1.0 - np.exp(-m.time / 5e-3))).max()
            assert errors[node, h] < 0.5 * 0.06 * h
    assert errors["end", 5e-4] / errors["end", 2.5e-4] == pytest.approx(2.0, abs=0.15)
    assert errors["mid", 5e-4] / errors["mid", 2.5e-4] == pytest.approx(4.0, abs=0.2)

"""Contact of a ball with planes, spheres, cylinders and capsules, rigid and elastic, with and without friction."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipk
from time_runs import RecordedRun, deck, input_deck

from mecano.deck.format import deck_error_text
from mecano.deck.read import deck_of_bytes
from mecano.errors import DeckError

S, g = "Contact", 9.81


def test_a_follower_with_a_flat_face_leaves_its_cam(verify):
    """It separates where m (g - e w^2 cos w t) falls to zero, and meets the cam again after a parabola."""
    recorded = RecordedRun(input_deck("flat_follower", "time.end=0.3", "time.step=2.5e-4"))
    e, w = 0.02, 25.0
    leaves = math.acos(-g / (e * w**2)) / w

    def height(t):
        """Of the parabola above the cam."""
        dt = t - leaves
        return e * (math.cos(w * t) - math.cos(w * leaves)) + e * w * math.sin(w * leaves) * dt - g / 2 * dt**2

    meets = brentq(height, leaves + 0.05, leaves + 0.2)
    speed = e * w * (math.sin(w * meets) - math.sin(w * leaves)) + g * (meets - leaves)
    opens, closes = (event for event in recorded.event_records if event.t > 0.0)
    verify(S, "flat follower: leaves the cam [s]", opens.t, leaves, "N = 0 in closed form", absolute=1e-6)
    verify(S, "flat follower: meets the cam again [s]", closes.t, meets, "parabola and sine", absolute=1e-6)
    assert closes.impulse == pytest.approx(0.5 * speed, rel=1e-5)
    assert closes.lost == pytest.approx(0.25 * speed**2, rel=1e-5)
    held = recorded.time < leaves - 1e-3
    force = 0.5 * (g + e * w**2 * np.cos(w * recorded.time[held]))
    np.testing.assert_allclose(recorded["elements/contact/normal_force"][held], force, atol=1e-4 * force[0])


def test_a_struck_ball_slides_rolls_and_hits_another(verify):
    recorded = RecordedRun(input_deck("billiards"))
    v, mu = 2.0, 0.2
    t, cue, other = recorded.time, recorded["nodes/cue/velocity"][:, 0], recorded["nodes/object/velocity"][:, 0]
    slides = recorded["elements/under_cue/sliding_speed"]
    rolls = np.interp(-0.01, -slides[t < 0.4], t[t < 0.4])
    verify(S, "billiards: begins to roll [s]", rolls, 2 * v / (7 * mu * g), "Coriolis 1835", relative=1e-2)
    before = t < 0.45
    verify(S, "billiards: speed of rolling [m/s]", cue[before][-1], 5 / 7 * v, "Coriolis 1835", relative=1e-4)
    closes, opens = recorded.event_records
    deepest = (5 / 8 * 0.17 * (5 / 7 * v) ** 2 / 1e8) ** 0.4
    lasts = 2.9432749 * deepest / (5 / 7 * v)
    verify(S, "billiards: duration of the impact [s]", opens.t - closes.t, lasts, "Hertz", relative=2e-3)
    assert -recorded["elements/impact/gap"].min() == pytest.approx(deepest, rel=2e-3)
    rubbed = mu * g * lasts  # change of the speeds by the cloth during the impact, which Coriolis neglects
    for ball, speed, share in (("second", other, 25 / 49), ("first", cue, 10 / 49)):
        verify(
            S,
            f"billiards: in the end the {ball} ball rolls at [m/s]",
            speed[-1],
            share * v,
            "Coriolis 1835",
            absolute=rubbed,
        )
    assert np.ptp(recorded["energy/balance"]) < 1e-3 * 0.34


def cradle(body, radius, angle, time):
    """Return the run of five touching balls on rods of 1 m, each with a ``body``; the first is raised by an angle."""
    nodes, elements, joints = "", "", ""
    for i in range(5):
        x, z = (2 * radius * i, -1.0) if i else (-math.sin(angle), -math.cos(angle))
        nodes += f"p{i}: {{position: [{2 * radius * i}, 0, 0], fixed: true}}, b{i}: {{position: [{x}, 0, {z}]}}, "
        elements += f"ball{i}: {{{body}, node: b{i}}}, "
        joints += f"rod{i}: {{type: rigid_rod, nodes: [p{i}, b{i}]}}, "
    for i in range(4):
        ball = f"sphere: {{radius: {radius}}}, radius: {radius}, restitution: 1"
        elements += f"c{i}: {{type: contact, nodes: [b{i}, b{i + 1}], {ball}}}, "
    return RecordedRun(
        deck(f"""
        mecano: 1
        gravity: [0, 0, {-g}]
        nodes: {{{nodes}}}
        elements: {{{elements}}}
        joints: {{{joints}}}
        time: {{{time}}}
    """)
    )


def test_newtons_cradle(verify):
    """Touching balls pass the momentum on to the last one, in both directions, whichever contacts rounding closes."""
    angle, body = 0.3, "type: rigid_body, mass: 0.1, inertia: [1.6e-5, 1.6e-5, 1.6e-5]"
    run = cradle(body, 0.02, angle, "end: 1.6, step: 5 ms")
    quarter = ellipk(math.sin(angle / 2) ** 2) / math.sqrt(g)
    momentum = 0.1 * math.sqrt(2 * g * (1 - math.cos(angle)))
    shocks = [event for event in run.event_records if event.impulse]
    names = [f"contact 'c{i}'" for i in range(4)]
    assert [event.element for event in shocks] == names + names[::-1]
    np.testing.assert_allclose([event.t for event in shocks], np.repeat([1, 3], 4) * quarter, rtol=1e-4)
    np.testing.assert_allclose([event.impulse for event in shocks], momentum, rtol=1e-4)
    first, last = shocks[0], shocks[-1]
    verify(S, "Newton's cradle: first impact [s]", first.t, quarter, "elliptic integral", relative=1e-4)
    verify(S, "Newton's cradle: last impulse [N s]", last.impulse, momentum, "energy of a pendulum", relative=1e-4)
    np.testing.assert_allclose(run["energy/balance"], run["energy/balance"][0], atol=1e-4 * momentum)


def test_a_row_of_balls_that_is_hit_slowly_moves_on_together():
    """Below the rest speed the impact of a row of touching balls is one: all have a fifth of the speed after it."""
    v, places = 1e-5, [-1e-7, 0.1, 0.2, 0.3, 0.4]
    nodes = ", ".join(f"b{i}: {{position: [{x}, 0, 0]}}" for i, x in enumerate(places))
    body, ball = "mass: 1, inertia: [1e-3, 1e-3, 1e-3]", "sphere: {radius: 0.05}, radius: 0.05, restitution: 0.8"
    elements = [f"ball{i}: {{type: rigid_body, node: b{i}, {body}}}" for i in range(5)]
    elements += [f"c{i}: {{type: contact, nodes: [b{i}, b{i + 1}], {ball}}}" for i in range(4)]
    run = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{{nodes}}}
        elements: {{{", ".join(elements)}}}
        initial: {{velocities: [{{nodes: [b0], velocity: [{v}, 0, 0]}}]}}
        time: {{end: 0.02, step: 1 ms}}
    """)
    )
    np.testing.assert_allclose([event.t for event in run.event_records], 0.01, rtol=1e-6)
    assert len({event.t for event in run.event_records}) == 1
    np.testing.assert_allclose([event.impulse for event in run.event_records], v * np.array([4, 3, 2, 1]) / 5)
    np.testing.assert_allclose([run[f"nodes/b{i}/velocity"][-1, 0] for i in range(5)], v / 5)


def carts(n, moving, restitutions):
    """The run of n carts of 1 kg in line, the last one at a wall: the first ``moving`` ones hit the others with 1 m/s.

    ``restitutions`` (n,) are those of the wall and of the n - 1 contacts between carts.
    """
    places = [0.2 * i + (0.1 if i >= moving else 0.0) for i in range(n)]
    body, ball = "mass: 1, inertia: [0.01, 0.01, 0.01]", "radius: 0.1, restitution:"
    nodes = ", ".join(f"c{i}: {{position: [{x}, 0, 0]}}" for i, x in enumerate(places))
    wall = f"ground, c{n - 1}], plane: {{normal: [-1, 0, 0], point: [{places[-1] + 0.1}, 0, 0]}}"
    shapes = [wall, *(f"c{i - 1}, c{i}], sphere: {{radius: 0.1}}" for i in range(1, n))]
    elements = [f"cart{i}: {{type: rigid_body, node: c{i}, {body}}}" for i in range(n)]
    elements += [f"k{i}: {{type: contact, nodes: [{shapes[i]}, {ball} {e}}}" for i, e in enumerate(restitutions)]
    rails = [f"rail{i}: {{type: prismatic, nodes: [ground, c{i}], axis: [1, 0, 0]}}" for i in range(n)]
    return RecordedRun(
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{{nodes}}}
        elements: {{{", ".join(elements)}}}
        joints: {{{", ".join(rails)}}}
        initial: {{velocities: [{{nodes: {[f"c{i}" for i in range(moving)]}, velocity: [1, 0, 0]}}]}}
        time: {{end: 0.2, step: 1 ms}}
    """)
    )


@pytest.mark.parametrize(
    ("moving", "restitutions"),
    [
        *((1, own) for own in ((0, 0), (0, 0, 0), (0, 0.5, 0), (1, 0.5, 0), (0.5, 0.5, 0), (0, 1, 0, 0))),
        *((1, own) for own in ((0, 0.5, 0.5), (0, 1, 0, 0.5))),  # touching carts that part are not held together
        (2, (0.5, 1, 0)),
    ],
)
def test_impacts_that_run_to_and_fro_between_idle_contacts_end(moving, restitutions):
    """Carts that touch without force, the last one at a wall, are hit: energy is balanced, none enters another."""
    n = len(restitutions)
    run = carts(n, moving, restitutions)
    speeds = np.array([run[f"nodes/c{i}/velocity"][-1, 0] for i in range(n)])
    assert sum(event.lost for event in run.event_records) == pytest.approx(0.5 * (moving - speeds @ speeds), abs=1e-9)
    assert np.diff([*speeds, 0.0]).min() > -1e-9  # no cart enters another, or the wall


def test_balls_that_touch_are_hit_together_whatever_rounding_makes_of_their_gaps():
    """Two balls hit one between them, with gaps of -3e-17 m and 0: it stays, and they rebound with half their speed."""
    body, ball = "mass: 1, inertia: [1e-3, 1e-3, 1e-3]", "sphere: {radius: 0.1}, radius: 0.1, restitution: 0.5"
    run = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{a: {{position: [0.1, 0, 0]}}, b: {{position: [0.3, 0, 0]}}, c: {{position: [0.5, 0, 0]}}}}
        elements:
          a: {{type: rigid_body, node: a, {body}}}
          b: {{type: rigid_body, node: b, {body}}}
          c: {{type: rigid_body, node: c, {body}}}
          ab: {{type: contact, nodes: [a, b], {ball}}}
          bc: {{type: contact, nodes: [b, c], {ball}}}
        initial: {{velocities: [{{nodes: [a], velocity: [1, 0, 0]}}, {{nodes: [c], velocity: [-1, 0, 0]}}]}}
        time: {{end: 0.01, step: 1 ms}}
    """)
    )
    assert run["elements/ab/gap"][0] < 0.0 == run["elements/bc/gap"][0]
    np.testing.assert_allclose([run[f"nodes/{n}/velocity"][-1, 0] for n in "abc"], [-0.5, 0, 0.5], atol=1e-12)


def test_impacts_pass_along_a_row_after_another_ball_has_come_to_rest():
    """Elsewhere a ball rebounds ever faster until it rests; later the last of three touching balls takes the speed."""
    ball, places = "mass: 1, inertia: [1e-3, 1e-3, 1e-3]", {"a": -0.3, "b": 0.2, "c": 0.4}
    nodes = ", ".join(f"{name}: {{position: [{x}, 0, 0]}}" for name, x in places.items())
    elements = [f"{name}: {{type: rigid_body, node: {name}, {ball}}}" for name in (*places, "low")]
    pairs = [f"{i}{j}: {{type: contact, nodes: [{i}, {j}], sphere: {{radius: 0.1}}, radius: 0.1, restitution: 1}}"
             for i, j in ("ab", "bc")]  # fmt: skip
    rails = [f"{name}: {{type: prismatic, nodes: [ground, {name}], axis: [1, 0, 0]}}" for name in places]
    floor = "plane: {normal: [0, 0, 1], point: [0, 1, 0]}, radius: 0.1, restitution: 0.5"
    run = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: [0, 0, -{g}]
        nodes: {{{nodes}, low: {{position: [0, 1, 0.105]}}}}
        elements: {{{", ".join(elements + pairs)}, floor: {{type: contact, nodes: [ground, low], {floor}}}}}
        joints: {{{", ".join(rails)}}}
        initial: {{velocities: [{{nodes: [a], velocity: [1, 0, 0]}}]}}
        time: {{end: 0.4, step: 0.1, rest_speed: 1.0e-9}}
    """)
    )
    assert len([event for event in run.event_records if event.element == "contact 'floor'"]) > 15
    passed = [event.element for event in run.event_records if event.impulse and event.t > 0.2]
    assert passed == ["contact 'ab'", "contact 'bc'"]
    np.testing.assert_allclose([run[f"nodes/{name}/velocity"][-1, 0] for name in "abc"], [0, 0, 1], atol=1e-9)


def test_a_row_of_masses_on_rods_keeps_its_energy():
    """Spheres around point masses, on nodes whose rotations have no mass: the first passes its speed to the last.

    Its speed is that of a fall from 0.5 rad on rods of 1 m; the impulses have no lever arm, up to rounding.
    """
    run = cradle("type: point_mass, mass: 1", 0.05, 0.5, "end: 0.511, step: 1 ms")
    speed = math.sqrt(2 * g * (1 - math.cos(0.5)))
    assert [event.element for event in run.event_records] == [f"contact 'c{i}'" for i in range(4)]
    np.testing.assert_allclose([event.impulse for event in run.event_records], speed, rtol=1e-5)
    np.testing.assert_allclose([run[f"nodes/b{i}/velocity"][-1, 0] for i in range(5)], [0, 0, 0, 0, speed], atol=2e-4)


def test_a_light_ball_leaves_a_heavy_plate():
    """It leaves where 0.1 w^2 cos(w t) falls to -g, up to (w h)^2; its force is 1e-7 of those that drive the plate."""
    w = 12.0
    recorded = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: [0, 0, -{g}]
        nodes: {{plate: {{position: [0, 0, 0]}}, ball: {{position: [0, 0, 0.1]}}}}
        elements:
          plate: {{type: rigid_body, node: plate, mass: 1.0e4, inertia: [1, 1, 1]}}
          ball: {{type: point_mass, node: ball, mass: 1 g}}
          touch: {{type: contact, nodes: [plate, ball], plane: {{normal: [0, 0, 1]}}, radius: 0.1, restitution: 0}}
        joints:
          upright: {{type: held_rotation, nodes: [ground, plate]}}
          shaker: {{type: prescribed_position, node: plate, direction: [0, 0, 1], value: 0.1*(1 - cos({w}*time))}}
          along: {{type: prescribed_position, node: plate, direction: [1, 0, 0], value: 0}}
          across: {{type: prescribed_position, node: plate, direction: [0, 1, 0], value: 0}}
        time: {{end: 0.25, step: 1 ms}}
    """)
    )
    [opens] = [event for event in recorded.event_records if event.name == "opens"]
    assert opens.t == pytest.approx(math.acos(-g / (0.1 * w**2)) / w, rel=(w * 1e-3) ** 2)


def test_a_mass_lifts_off_as_slowly_as_a_force_grows():
    """Its overlap of 2.5e-12 m, as rounding leaves it, shrinks as 17 kN/s t^3/6: in the first step not to nothing."""
    recorded = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: [0, 0, -{g}]
        nodes: {{mass: {{position: [0, 0, -2.5e-12]}}}}
        elements:
          mass: {{type: point_mass, node: mass, mass: 1}}
          floor: {{type: contact, nodes: [ground, mass], plane: {{normal: [0, 0, 1], point: [0, 0, 0]}}}}
        loads:
          lift: {{type: force, node: mass, direction: [0, 0, 1], value: {{polynomial: [{g} + 1.0e-12, 1.7e4]}}}}
        time: {{end: 1 ms, step: 5 us}}
    """)
    )
    assert not recorded.event_records
    assert recorded["nodes/mass/position"][-1, 2] == pytest.approx(1.7e4 * 1e-9 / 6, rel=1e-4)


def test_a_ball_on_a_turntable_runs_on_a_circle(verify):
    """Its velocity turns at 2/7 of the rate of the table: 0.875 m about x = -0.375 m."""
    last = [RecordedRun(input_deck("ball_on_turntable", f"time.step={h}"))["nodes/ball/position"] for h in (2e-3, 1e-3)]
    error = [abs(x[-1, 1]) for x in last]
    assert error[0] / error[1] == pytest.approx(4.0, abs=0.1)
    radius = np.hypot(last[1][:, 0] + 0.375, last[1][:, 1])
    verify(S, "ball on a turntable: distance from the centre [m]", radius, 0.875, "Earnshaw 1844", relative=1e-3)


BALL = """
    mecano: 1
    gravity: [{gx}, 0, {gz}]
    nodes:
      ball: {{position: {start}}}
    elements:
      ball: {{type: rigid_body, node: ball, mass: 2, inertia: [8.0e-3, 8.0e-3, 8.0e-3]}} # solid, radius 0.1 m
      contact: {{type: contact, nodes: [ground, ball], {contact}}}
    time: {{end: {end}, step: {step}}}
"""
FLOOR = "plane: {normal: [0, 0, 1], point: [0, 0, 0]}"
SOFT = "law: {power: {coefficient: 2.0e7, exponent: 1.5}}, damping: 0.5"


@pytest.mark.parametrize("mu", [0.1, 0.4])
def test_a_ball_on_an_incline_rolls_or_slips(mu):
    """It rolls with 5/7 g sin a if mu >= 2/7 tan a, and slips with g (sin a - mu cos a) otherwise."""
    gx, gz = g * math.sin(0.5), -g * math.cos(0.5)
    height = 0.1 - (-2 * gz / 2e7) ** (2 / 3)
    contact = f"{FLOOR}, radius: 0.1, {SOFT}, friction: {{coefficient: {mu}, regularization: 1.0e-4}}"
    text = BALL.format(gx=gx, gz=gz, start=f"[0, 0, {height!r}]", contact=contact, end=0.5, step=2e-3)
    recorded = RecordedRun(deck(text))
    expected = 5 / 7 * gx if mu > 2 / 7 * math.tan(0.5) else gx + mu * gz
    assert recorded["nodes/ball/velocity"][-1, 0] == pytest.approx(0.5 * expected, rel=1e-3)


RUBBING = f"{FLOOR}, radius: 0.1, friction: {{coefficient: MU, regularization: 1.0e-4}}"


@pytest.mark.parametrize("mu", [0.1, 0.4])
def test_a_ball_on_a_rigid_incline_rolls_or_slips(verify, mu):
    gx, gz = g * math.sin(0.5), -g * math.cos(0.5)
    contact = RUBBING.replace("MU", str(mu))
    recorded = RecordedRun(deck(BALL.format(gx=gx, gz=gz, start="[0, 0, 0.1]", contact=contact, end=0.5, step=2e-3)))
    what, expected = ("rolls", 5 / 7 * gx) if mu > 2 / 7 * math.tan(0.5) else ("slips", gx + mu * gz)
    v = recorded["nodes/ball/velocity"][-1, 0]
    verify(S, f"ball on a rigid incline, {what}: speed after 0.5 s [m/s]", v, 0.5 * expected, "Newton", relative=5e-4)
    np.testing.assert_allclose(recorded["elements/contact/normal_force"][recorded.time > 1e-3], -2 * gz, rtol=1e-8)
    assert np.ptp(recorded["energy/balance"]) < 1e-4 * recorded["energy/kinetic"][-1]


def test_a_ball_slides_on_a_rigid_floor_until_it_rolls(verify):
    """From 2 m/s: it rolls after 2 v/(7 mu g), having slid 12 v^2/(49 mu g); the error is of second order."""
    text = BALL.format(gx=0, gz=-g, start="[0, 0, 0.1]", contact=RUBBING.replace("MU", "0.2"), end=1, step="STEP")
    text = text.replace("    time:", "    initial: {velocities: [{nodes: [ball], velocity: [2, 0, 0]}]}\n    time:")
    run = RecordedRun(deck(text.replace("STEP", "5.0e-4")))
    slides = 2 * 2.0 / (7 * 0.2 * g)
    x = 12 * 2.0**2 / (49 * 0.2 * g) + 5 / 7 * 2.0 * (1.0 - slides)
    verify(
        S, "ball on a rigid floor: way after 1 s [m]", run["nodes/ball/position"][-1, 0], x, "Coriolis", relative=1e-4
    )
    verify(
        S, "ball on a rigid floor: speed of rolling [m/s]", run["nodes/ball/velocity"][-1, 0], 10 / 7,
        "Coriolis", relative=1e-4,
    )  # fmt: skip
    rolling = run["elements/contact/sliding_speed"] < 1e-3
    assert run.time[np.argmax(rolling)] == pytest.approx(slides, abs=2e-3)


def test_a_ball_swings_in_a_bowl():
    """Without friction its centre is a pendulum of the length R - r, from the horizontal: T = 4 K(sin^2 45 deg)/w."""
    contact = "sphere: {radius: 1.1, center: [0, 0, 0], inside: true}, radius: 0.1"
    period = 4 * ellipk(0.5) / math.sqrt(g)
    text = BALL.format(gx=0, gz=-g, start="[1.0, 0, 0]", contact=contact, end=period, step=period / 800)
    recorded = RecordedRun(deck(text))
    np.testing.assert_allclose(recorded["nodes/ball/position"][-1], [1.0, 0.0, 0.0], atol=1e-6)
    assert recorded["elements/contact/normal_force"].max() == pytest.approx(3 * 2 * g, rel=1e-4)
    assert np.abs(recorded["elements/contact/gap"]).max() < 1e-9


def test_a_ball_bounces_off_the_end_of_a_capsule():
    """At 45 degrees to the line of the centres, with e = 0.5: v' = v - 1.5 (n.v) n."""
    contact = "capsule: {axis: [0, 1, 0], length: 2, radius: 0.3, center: [0, 0, 0]}, radius: 0.1, restitution: 0.5"
    apart = 0.4 / math.sqrt(2)
    text = BALL.format(gx=0, gz=0, start=f"[1, {2 + apart!r}, 0]", contact=contact, end=1.0, step=0.02)
    text += "    initial: {velocities: [{nodes: [ball], velocity: [-2, 0, 0]}]}\n"
    recorded = RecordedRun(deck(text))
    assert recorded.event_records[0].t == pytest.approx((1 - apart) / 2, abs=1e-9)
    np.testing.assert_allclose(recorded["nodes/ball/velocity"][-1], [-0.5, 1.5, 0.0], atol=1e-9)


@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_damping_takes_the_energy_of_hunt_and_crossley(exponent):
    """For small losses the coefficient of restitution is 1 - 2/3 c v."""
    law = f"law: {{power: {{coefficient: 1.0e6, exponent: {exponent}}}}}, damping: 0.03"
    text = BALL.format(gx=0, gz=0, start="[0, 0, 0.11]", contact=f"{FLOOR}, radius: 0.1, {law}", end=0.1, step=1e-4)
    text += "    initial: {velocities: [{nodes: [ball], velocity: [0, 0, -1]}]}\n"
    rebound = RecordedRun(deck(text))["nodes/ball/velocity"][-1, 2]
    assert 1 - rebound == pytest.approx(2 / 3 * 0.03, rel=0.03)


@pytest.mark.parametrize(
    "contact, message",
    [
        ("radius: 0.1", "give exactly one of 'plane', 'sphere', 'cylinder', 'capsule'"),
        ("plane: {normal: [0, 0, 1]}, radius: 0.1", "'plane' needs 'point': the ground has no position"),
        ("sphere: {radius: 1, center: [0, 0, 0]}", "node b is 0.5 m from the middle of the sphere, inside it"),
        ("sphere: {radius: 1, center: [0, 0, 0], inside: true}, radius: 2", "'radius' of the ball must be less"),
        (f"{FLOOR}, radius: 0.6", "the ball starts 0.1 m within the surface"),
        (f"{FLOOR}, {SOFT}, restitution: 0.5", "'restitution' applies to a rigid"),
        (f"{FLOOR}, damping: 2", "'damping' needs 'law': a rigid contact has none"),
        (FLOOR + ", law: {constant: {value: 1}}", "'law' must be zero at zero depth"),
    ],
)  # fmt: skip
def test_errors(contact, message):
    text = BALL.format(gx=0, gz=-g, start="[0, 0, 0.5]", contact=contact, end=1, step=0.01)
    with pytest.raises(DeckError) as info:
        deck_of_bytes(text.replace("\n    ", "\n").strip().encode(), "deck.yaml")
    found = deck_error_text(info.value)
    assert found.startswith("deck.yaml:7:") and message in found


@pytest.mark.parametrize(("law", "depth"), [("", 1e-15), (SOFT, 1e-15), (SOFT, 1e-3)])
def test_a_node_on_or_pressed_into_a_sphere_is_outside_of_it(law, depth):
    """Also where rounding has put it within: the nodes of a chain that lies on a sprocket."""
    contact = ", ".join(filter(None, ("sphere: {radius: 1, center: [0, 0, 0]}", law)))
    text = BALL.format(gx=0, gz=-g, start=f"[0, 0, {1 - depth!r}]", contact=contact, end=1, step=0.01)
    assert deck_of_bytes(text.replace("\n    ", "\n").strip().encode(), "deck.yaml").values["elements"]


def test_a_ball_on_the_ground_is_refused():
    """Its place would be that of the body: nodes in the wrong order. A rod there has a place."""
    text = BALL.format(gx=0, gz=-g, start="[0, 0, 0.5]", contact=f"{FLOOR}, radius: 0.1", end=1, step=0.01)
    swapped = text.replace("nodes: [ground, ball]", "nodes: [ball, ground]")
    with pytest.raises(DeckError, match=r"node b cannot be the ground, .* as in \[ground, ball\]"):
        deck(swapped)
    rod = "cylinder: {axis: [0, 1, 0], radius: 0.1}, rod: {axis: [1, 0, 0], length: 1, center: [0, 0, 0]}, radius: 0.1"
    deck(swapped.replace(f"{FLOOR}, radius: 0.1", rod))


IMPACTS = """
    mecano: 1
    gravity: none
    nodes: {slides: {position: [0, 0, 0.1005]}, rolls: {position: [0, 1, 0.1005]}}
    elements:
      slides: {type: rigid_body, node: slides, mass: 2, inertia: [8.0e-3, 8.0e-3, 8.0e-3]}
      rolls: {type: rigid_body, node: rolls, mass: 2, inertia: [8.0e-3, 8.0e-3, 8.0e-3]}
      smooth: {type: contact, nodes: [ground, slides], SURFACE, friction: {coefficient: 0.1, regularization: 1.0e-4}}
      rough: {type: contact, nodes: [ground, rolls], SURFACE, friction: {coefficient: 0.6, regularization: 1.0e-4}}
    initial: {velocities: [{nodes: [slides, rolls], velocity: [2, 0, -1]}]}
    time: {end: 5.0e-3, step: 1.0e-5}
    """


def test_friction_in_an_elastic_impact(verify):
    """Of the speed along the plane, friction takes 2 mu v_n from a ball that slides throughout, else 2/7: it rolls."""
    surface = "plane: {normal: [0, 0, 1], point: [0, 0, 0]}, radius: 0.1, law: {polynomial: [0, 2.0e6]}"
    run = RecordedRun(deck(IMPACTS.replace("SURFACE", surface)))
    for ball, speed in (("slides", 2.0 - 2.0 * 0.1), ("rolls", 2.0 * 5.0 / 7.0)):
        v, spin = run[f"nodes/{ball}/velocity"][-1], run[f"nodes/{ball}/angular_velocity"][-1, 1]
        what = f"elastic impact with friction, a ball that {ball}: velocity [m/s]"
        verify(S, what, v, [speed, 0.0, 1.0], "Coulomb's law in the impact", absolute=1e-4)
        assert spin == pytest.approx(2.0 * (2.0 - speed) / 8e-3 * 0.1, abs=1e-5)


PAIR = """
    mecano: 1
    gravity: none
    nodes: {one: {position: [0, 0, 0]}, other: {position: [0.3, 0.05, 0]}}
    elements:
      one: {type: rigid_body, node: one, mass: 1, inertia: [0.004, 0.004, 0.004]}
      other: {type: rigid_body, node: other, mass: 2, inertia: [0.02, 0.02, 0.02]}
      hit:
        type: contact
        nodes: NODES
        sphere: {radius: R_A}
        radius: R_B
        law: {linear: {slope: 300}}
        friction: {coefficient: 0.4, regularization: 0.01}
    initial: {velocities: [{nodes: [one], velocity: [2, 0, 0], angular_velocity: [0, 0, 9]}]}
    time: {end: 0.4, step: 0.001}
"""


def test_either_of_two_balls_may_carry_the_surface():
    """They overlap by a quarter of a radius; the force divides the distance of the centres as the radii."""
    runs = []
    for nodes, a, b in (("[one, other]", 0.1, 0.15), ("[other, one]", 0.15, 0.1)):
        text = PAIR.replace("NODES", nodes).replace("R_A", str(a)).replace("R_B", str(b))
        runs.append(RecordedRun(deck(text)))
    assert runs[0]["elements/hit/gap"].min() < -0.02
    for path in (
        "nodes/one/position",
        "nodes/other/position",
        "nodes/one/angular_velocity",
        "elements/hit/normal_force",
    ):
        np.testing.assert_allclose(runs[1][path], runs[0][path], rtol=0, atol=1e-9, err_msg=path)


def test_an_elastic_rod_meets_a_wall_once_and_leaves_it_with_its_wave(verify):
    """The wave runs to the free end and back in 2 L/c, with the force rho c A v on the wall.

    At the impact the rod is not strained: its first force on the wall is rounding, by which the contact must not open.
    """
    recorded = RecordedRun(deck("""
        mecano: 1
        gravity: none
        parameters: {EA: 7e6 N, line: 0.27 kg/m}
        sections: {rod: {type: stiffness, EA: $EA, GA2: $EA, GA3: $EA, GJ: 100, EI2: 100, EI3: 100,
                         mass_per_length: $line, rotary_inertia: [1.0e-4, 1.0e-4, 1.0e-4]}}
        nodes: {front: {position: [0.1 mm, 0, 0]}, back: {position: [1000.1 mm, 0, 0]}}
        elements:
          rod: {type: beam, nodes: [front, back], section: rod, mesh: 100}
          wall: {type: contact, nodes: [ground, front], plane: {normal: [1, 0, 0], point: [0, 0, 0]}}
        initial: {velocities: [{nodes: all, velocity: [-1 m/s, 0, 0]}]}
        time: {end: 0.52 ms, step: 1 us}
    """))  # fmt: skip
    closes, opens = recorded.event_records
    c, time, force = math.sqrt(7e6 / 0.27), recorded.time, recorded["elements/wall/normal_force"]
    middle = (time > closes.t + 0.4 / c) & (time < closes.t + 1.6 / c)
    source = "wave equation"
    verify(S, "elastic rod on a wall: force [N]", force[middle].mean(), 0.27 * c, source, relative=1e-4)
    verify(S, "elastic rod on a wall: duration [s]", opens.t - closes.t, 2.0 / c, source, relative=5e-3)
    assert closes.t == pytest.approx(1e-4, rel=1e-9)

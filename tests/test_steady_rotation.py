"""Steady rotation as initial state: blades, pendulums and shafts deformed by centrifugal forces."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_bvp, solve_ivp
from scipy.optimize import fsolve, minimize
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses import initial_state
from mecano.analyses.modal import modes
from mecano.analyses.operating_point import operating_point
from mecano.analyses.prepare import prepare
from mecano.analyses.summary import summary
from mecano.errors import ConvergenceError, DeckError
from mecano.solve.modal.spin_up import spin_up
from mecano.solve.modal.steady import Steady
from mecano.solve.modal.steady_rotation import Rotation

S = "Steady rotation"
ROD = """
    mecano: 1
    gravity: none
    sections: {rod: {type: circle, diameter: 0.02, E: 1.0e9, nu: 0.3, density: 1000}}
    nodes: {root: {position: [0.2, 1, 3]}, tip: {position: [1.2, 1, 3]}}
    elements: {rod: {type: beam, nodes: [root, tip], section: rod, mesh: MESH}}
    joints:
      bearing: {type: hinge, nodes: [ground, root], axis: [0, 0, 1]}
      motor: {type: prescribed_angle, nodes: [ground, root], axis: [0, 0, 1], value: 300*time}
    initial: {steady: {angular_velocity: [0, 0, 300], about: [0.2, 1, 0]}}
    time: {end: 1.0e-3, step: 1.0e-4}
"""


def place(base, name):
    """Return the position (3,) of a node of an OperatingPoint."""
    system = base.prepared.system
    x = system.numbering.x[[node.name for node in system.nodes].index(name)]
    return base.state.z[x : x + 3]


def arm_between_stops(speed):
    """Return an OperatingPoint of an arm of 0.3 m that hangs at 0.3 rad on its lower stop; the upper one is at 1.1."""
    x, z = 0.3 * np.sin(0.3), -0.3 * np.cos(0.3)
    return operating_point(
        deck(f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {{shaft: {{position: [0, 0, 0]}}, arm: {{position: [0, 0, 0]}},
                 tip: {{position: [{x}, 0, {z}]}}}}
        elements:
          shaft: {{type: rigid_body, node: shaft, mass: 1, inertia: [1, 1, 1]}}
          arm: {{type: rigid_body, node: arm, mass: 2, center_of_mass: [{x}, 0, {z}], inertia: [1.0e-6, 1.0e-6, 1.0e-6],
            attached: [tip]}}
        joints:
          axle: {{type: hinge, nodes: [ground, shaft], axis: [0, 0, 1]}}
          motor: {{type: prescribed_angle, nodes: [ground, shaft], axis: [0, 0, 1], rate: {speed}}}
          pin: {{type: hinge, nodes: [shaft, arm], axis: [0, -1, 0], stops: {{lower: 0, upper: 0.8}}}}
        initial: {{steady: {{angular_velocity: [0, 0, {speed}], about: [0, 0, 0]}}}}
        time: {{end: 1, step: 1 ms}}
        """)
    )


def test_an_arm_stays_on_its_stop():
    x, y, z = place(arm_between_stops(4.0), "tip")
    assert np.arctan2(np.hypot(x, y), -z) == pytest.approx(0.3, abs=1e-9)


@pytest.mark.parametrize("speed", [7.0, 12.0])
def test_an_arm_that_its_stop_would_have_to_pull_is_refused(speed):
    """In steady rotation it is between its stops, or on the upper one."""
    with pytest.raises(ConvergenceError, match=r"do not settle: hinge 'pin' \(leaves lower stop\)"):
        arm_between_stops(speed)


@pytest.mark.parametrize("start", [0.15, 0.9, 1.2])
def test_a_bead_slides_past_the_nodes_of_a_turning_hoop(start, verify):
    """On the stiff hoop of radius 1 m that turns about its vertical diameter the bead rests at cos(a) = g/w^2 = 1/2."""
    x, w, d = np.sin(start), np.sqrt(2.0 * 9.81), np.sqrt(0.5)
    base = operating_point(
        deck(f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        sections: {{s: {{type: circle, diameter: 50 mm, E: 2.0e11, nu: 0.3, density: 100}}}}
        nodes:
          low: {{position: [0, 0, -1]}}
          end: {{position: [1, 0, 0]}}
          bead: {{position: [{x}, 0, {-np.cos(start)}]}}
        elements:
          hoop: {{type: beam, nodes: [low, end], section: s, via: [{d}, 0, {-d}], mesh: 12}}
          bead: {{type: point_mass, node: bead, mass: 0.01}}
        joints:
          axle: {{type: hinge, nodes: [ground, low], axis: [0, 0, 1]}}
          motor: {{type: prescribed_angle, nodes: [ground, low], axis: [0, 0, 1], rate: {w}}}
          sliding: {{type: slider_on_beam, node: bead, line: hoop}}
        initial: {{steady: {{angular_velocity: [0, 0, {w}], about: [0, 0, 0]}}}}
        time: {{end: 1, step: 1 ms}}
        """)
    )
    x, y, z = place(base, "bead")
    what = f"bead on a turning hoop of 12 beams, from {start} rad: angle [rad]"
    verify(S, what, np.arctan2(np.hypot(x, y), -z), np.pi / 3.0, "cos a = g/(w^2 r)", absolute=1e-4)


def test_a_stiff_skipping_rope_is_relaxed(verify):
    """An inextensible rope of the length 1.5 m with its ends on the axis: T x' = H, (T y')' = -m w^2 y along it.

    It starts unstretched, so no tension holds it, and EA is a million times its tension.
    """
    n, length, distance, w, mass = 40, 1.5, 1.0, 20.0, 0.1

    def shape(p):
        """Return (x, y, V) in the middle and at the end from the tension (H, V) at the start."""
        along = lambda _, y: [p[0] / np.hypot(p[0], y[2]), y[2] / np.hypot(p[0], y[2]), -mass * w * w * y[1]]  # noqa: E731
        return solve_ivp(along, (0.0, length), [0.0, 0.0, p[1]], "DOP853", [length / 2, length], rtol=1e-10).y.T

    def places(height):
        """Return points (n + 1, 2) at equal distances along half a wave of a sine."""
        x = np.linspace(0.0, distance, 2001)
        y = height * np.sin(np.pi * x / distance)
        arc = np.append(0.0, np.cumsum(np.hypot(np.diff(x), np.diff(y))))
        return np.array([np.interp(np.linspace(0.0, arc[-1], n + 1), arc, z) for z in (x, y)]).T

    tension = fsolve(lambda p: shape(p)[1, :2] - [distance, 0.0], [5.0, 10.0])
    nodes = ", ".join(f"n{i}: {{position: [{x}, {y}, 0]}}" for i, (x, y) in enumerate(places(0.51)))
    base = operating_point(
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{{nodes}}}
        elements:
          c$i: {{repeat: {{i: 1..{n}}}, type: cable, nodes: [n$(i - 1), n$i], axial_stiffness: 1.0e7,
            natural_length: {length / n}, mass_per_length: {mass}}}
        joints:
          a: {{type: spherical, nodes: [ground, n0]}}
          b: {{type: spherical, nodes: [ground, n{n}]}}
        initial: {{steady: {{angular_velocity: [{w}, 0, 0], about: [0, 0, 0], at_rest: [n0, n{n}]}}}}
        time: {{end: 1, step: 1 ms}}
        """)
    )
    found = np.hypot(*place(base, f"n{n // 2}")[1:])
    known = shape(tension)[0, 1]
    verify(S, "stiff skipping rope of 40 cables: radius of its middle [m]", found, known, "SciPy", relative=1e-3)


def test_a_turning_rod_is_stretched(verify):
    """Tension EA (r' - 1) and (EA r')' + m w^2 r = 0: r(L) = tan(kL)/k, k = w sqrt(rho/E); the error falls with h^2."""
    k = 300.0 * math.sqrt(1000.0 / 1e9)
    tips = [place(operating_point(deck(ROD.replace("MESH", str(n)))), "tip")[0] - 0.2 for n in (8, 16)]
    verify(S, "rod at 300 rad/s: radius of the tip [m]", (4 * tips[1] - tips[0]) / 3, math.tan(k) / k,
           "closed form", relative=1e-7)  # fmt: skip
    assert abs(tips[1] - math.tan(k) / k) < 0.26 * abs(tips[0] - math.tan(k) / k)


SPINDLE = """
    mecano: 1
    gravity: none
    sections: {shaft: {type: circle, diameter: 50 mm, E: 210 GPa, nu: 0.3, density: 7850}}
    nodes: {rear: {position: [0.1, 0, 0]}, front: {position: [0.45, 0, 0]}, disc: {position: [0.6, 0, 0]}}
    elements:
      span: {type: beam, nodes: [rear, front], section: shaft, mesh: 6}
      nose: {type: beam, nodes: [front, disc], section: shaft, mesh: 3}
      disc: {type: rigid_body, node: disc, mass: 15, inertia: [0.12, 0.065, 0.065], center_of_mass: [0, ECCENTRIC, 0]}
      rear: {type: bushing, nodes: [ground, rear], stiffness: [8.0e7, 1.2e8, 1.0e8, 0, 0, 0]}
      front: {type: bushing, nodes: [ground, front], stiffness: [1.0e8, 1.6e8, 1.2e8, 0, 0, 0]}
    initial: {steady: {angular_velocity: [1250, 0, 0], about: [0, 0, 0]}}
    time: {end: 1, step: 1 ms}
"""


def test_a_straight_shaft_is_in_balance_to_the_rounding_of_its_positions():
    """No force acts on it but the rounding of its positions times its stiffness, some 1e-6 N."""
    shift = place(operating_point(deck(SPINDLE.replace("ECCENTRIC", "0"))), "disc") - [0.6, 0.0, 0.0]
    assert np.abs(shift).max() < 1e-14


def test_unbalance_in_bearings_that_differ_in_two_directions():
    """5 g mm of unbalance are 8 N, which the bearings resist with more stiffness in one direction."""
    with pytest.raises(ConvergenceError, match=r"the forces change over time(.|\n)*a rotor without unbalance"):
        operating_point(deck(SPINDLE.replace("ECCENTRIC", "0.33e-6")))


CORNER = """
    loads:
      push:
        type: force
        node: weight
        direction: [1, 0, 0]
        value: {table: {points: [[0, 0], [5.5e-4, 0], [1, 1]], interpolation: linear}}
"""


@pytest.mark.parametrize(("modulus", "load"), [("1.0e9", ""), ("1.0e11", ""), ("1.0e11", CORNER)])
def test_a_run_from_steady_rotation_stays_there(modulus, load):
    """The rod does not ring: steps of 0.03 rad change its stretch by 0.18 * 0.03^2 of it (docs/step-control.md).

    Nor does a stiff one, whose vibrations along its axis, from 15,700 rad/s on, are faster than the steps of 1e-4 s;
    nor where a load on another body has a corner.
    """
    text = ROD.replace("MESH", "8").replace("1.0e9", modulus) + load
    if load:
        text = text.replace("tip: {", "weight: {position: [0, 5, 0]}, tip: {")
        text = text.replace("rod: {type: beam", "weight: {type: point_mass, node: weight, mass: 1}, rod: {type: beam")
        text = text.replace("about: [0.2, 1, 0]", "about: [0.2, 1, 0], at_rest: [weight]")
    recorded = RecordedRun(deck(text))
    radius = np.linalg.norm(recorded["nodes/tip/position"] - [0.2, 1.0, 3.0], axis=1)
    assert np.ptp(radius) < 2 * 0.18 * 0.03**2 * (radius[0] - 1.0)


PENDULUM = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {shaft: {position: [0, 0, 0]}, rod: {position: [0.1, 0, 0]}, bob: {position: [0.2, 0, -0.5]}}
    elements:
      shaft: {type: rigid_body, node: shaft, mass: 1, inertia: [1, 1, 1], attached: [hook]}
      rod: {type: rigid_link, nodes: [rod, bob]}
      bob: {type: point_mass, node: bob, mass: 2}
    joints:
      bearing: {type: hinge, nodes: [ground, shaft], axis: [0, 0, 1]}
      pin: {type: hinge, nodes: [hook, rod], axis: [0, 1, 0]}
    initial: {steady: {angular_velocity: [0, 0, 7], about: [0, 0, 0]}}
    time: {end: 1.0e-2, step: 1 ms}
""".replace("nodes: {shaft", "nodes: {hook: {position: [0.1, 0, 0]}, shaft")


BLADE = """
    mecano: 1
    gravity: [0, 0, -9.81]
    sections: {blade: {type: rectangle, width: 0.3, height: 0.02, E: 2.0e10, nu: 0.3, density: 1800}}
    nodes: {root: {position: [0, 0, 0]}, tip: {position: [10, 0, 0]}}
    elements: {blade: {type: beam, nodes: [root, tip], section: blade, mesh: 5, up: [0, 0, 1]}}
    joints: {bearing: {type: hinge, nodes: [ground, root], axis: [0, 0, 1]}}
    initial: {steady: {angular_velocity: [0, 0, SPEED], about: [0, 0, 0]}}
    time: {end: 1.0e-3, step: 1.0e-3}
"""


def sagging_tip(speed):
    """Return (x, z) [m] of the tip of BLADE without shear and extension: EI t' = M, M' = H sin t - m g (L - s) cos t.

    t is the slope downwards, and H' = -m w^2 x the force across the axis. Its weight grows step by step.
    """
    s, m, EI = np.linspace(0.0, 10.0, 101), 1800 * 0.3 * 0.02, 2e10 * 0.3 * 0.02**3 / 12
    y = np.array([0 * s, 0 * s, s, 0 * s, 0 * s])
    for share in np.linspace(0.1, 1.0, 10):

        def slope(s, y, share=share):
            t, M, x, _, H = y
            bending = H * np.sin(t) - share * m * 9.81 * (10.0 - s) * np.cos(t)
            return np.array([M / EI, bending, np.cos(t), -np.sin(t), -m * speed**2 * x])

        found = solve_bvp(slope, lambda a, b: np.array([a[0], b[1], a[2], a[3], b[4]]), s, y, tol=1e-6)
        s, y = found.x, found.y
    return y[2, -1], y[3, -1]


def test_a_blade_that_sags_far_at_low_speed(verify):
    """The tip hangs 2.8 m below the root, as the equations of the elastica say; five elements err by 1e-3 of it."""
    tip = place(operating_point(deck(BLADE.replace("SPEED", "2.0"))), "tip")
    verify(S, "blade of 10 m at 2 rad/s: sag of the tip [m]", tip[2], sagging_tip(2.0)[1], "elastica", relative=2e-3)
    assert tip[0] == pytest.approx(sagging_tip(2.0)[0], rel=1e-4) and abs(tip[1]) < 1e-5


def test_arms_of_a_governor_on_stiff_springs():
    """Found from rest, where they hang, at 3 rad/s: the slider stands where the potential of gravity, centrifugal
    forces and springs is least (masses and lengths of inputs/flyball_governor.yaml)."""
    prepared = prepare(input_deck("flyball_governor"))
    motion = Rotation(prepared.system, (0.0, 0.0, 3.0), (0.0, 0.0, 0.0))
    s, arrived = spin_up(Steady(prepared.system, prepared.length, motion), motion, prepared.state)
    assert arrived

    def potential(at):
        c, d, slider = math.cos(at[0]), math.sin(at[0]), at[1]
        gravity = 9.81 * (2 * (5 * (1 - d) + 0.3 * (1 - d / 2)) + 3 * slider)
        spread = 5 * (0.05 + c) ** 2 + 0.3 * (0.05 + c / 2) ** 2 + 0.025 * c**2 + 2.5e-6 * d**2
        stretch = math.hypot(c / 2, 1 - d / 2 - slider) - 0.5
        return gravity - 9.0 * spread + 800e3 * stretch**2

    least = minimize(potential, [1.4, 0.01], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-13}).x
    node = [node.name for node in prepared.system.nodes].index("slider")
    assert s.z[prepared.system.numbering.x[node] + 2] == pytest.approx(least[1], abs=1e-6)


def test_a_pendulum_on_a_turning_shaft_swings_out():
    """tan(p) = w^2 (e + l sin p)/g; the shaft is not driven, and nothing brakes it."""
    bob = place(base := operating_point(deck(PENDULUM)), "bob")
    sine = (math.hypot(bob[0], bob[1]) - 0.1) / math.hypot(0.1, 0.5)
    assert sine / math.sqrt(1 - sine**2) == pytest.approx(49.0 * (0.1 + math.hypot(0.1, 0.5) * sine) / 9.81, rel=1e-9)
    assert any("the steady motion requires another shape" in text for text in base.warnings)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[0, 0, -9.81]", "[0, -9.81, 0]", "no steady rotation with the angular velocity"),
        ("time:", "loads: {push: {type: force, node: bob, direction: [1, 0, 0], value: 1}}\n    time:", "was found"),
        ("axis: [0, 0, 1]}", "axis: [0, 0, 1]}\n      motor: {type: prescribed_angle, nodes: [ground, shaft], "
         "axis: [0, 0, 1], value: 6*time}", "'prescribed_angle 'motor'"),
    ],
    ids=["gravity across", "a push", "another speed"],
)  # fmt: skip
@pytest.mark.parametrize("find", [operating_point, summary])
def test_where_there_is_no_steady_rotation(old, new, said, find):
    with pytest.raises(ConvergenceError, match="no steady rotation with the angular velocity") as info:
        find(deck(PENDULUM.replace(old, new)))
    assert said in str(info.value)


def test_the_check_of_a_deck_finds_steady_rotation_and_leaves_the_model_unchanged():
    given = deck(PENDULUM)
    text = summary(given)
    assert "steady rotation at [0, 0, 7] rad/s, found" in text and "requires another shape of the mechanism" in text
    at_rest = summary(deck(PENDULUM.partition("initial:")[0] + "time: {end: 1, step: 1}"))
    assert text.partition("mobility")[2] == at_rest.partition("mobility")[2]


def test_a_long_search_is_announced(monkeypatch):
    monkeypatch.setattr(initial_state, "PATIENCE", 0.0)
    notes = []
    initial_state.set_initial_state(prepare(deck(PENDULUM)), announce=notes.append)
    assert "still searching steady motion at the start, for 0 s: iteration 1, forces out of balance by " in notes[0]


@pytest.mark.parametrize(
    ("steady", "said"),
    [
        ("{}", "give either 'velocity', of straight running, or 'angular_velocity'"),
        ("{velocity: [1, 0, 0], angular_velocity: [0, 0, 1], about: [0, 0, 0]}", "give either 'velocity'"),
        ("{angular_velocity: [0, 0, 1]}", "'about' is missing: a point of the axis of rotation"),
        ("{velocity: [1, 0, 0], about: [0, 0, 0]}", "'about' belongs to 'angular_velocity'"),
        ("{velocity: [1, 0, 0], at_rest: [shaft]}", "'at_rest' belongs to 'angular_velocity'"),
    ],
)
def test_errors_in_a_steady_motion(steady, said):
    with pytest.raises(DeckError) as info:
        deck(PENDULUM.replace("{angular_velocity: [0, 0, 7], about: [0, 0, 0]}", steady))
    assert said in str(info.value)


def test_a_support_that_does_not_turn():
    """The hub on springs stays in place, and the rod on it is stretched as on a rigid bearing."""
    text = ROD.replace("MESH", "8").replace("[ground, root]", "[pylon, root]")
    text = text.replace("nodes: {root", "nodes: {pylon: {position: [0.2, 1, 3]}, other: {position: [-0.8, 1, 3]}, root")
    text = text.replace("elements: {rod", "elements: {pylon: {type: bushing, nodes: [ground, pylon], stiffness: "
                        "[1.0e8, 1.0e8, 1.0e8, 1.0e6, 1.0e6, 1.0e6]}, rod")  # fmt: skip
    text = text.replace("mesh: 8}}", "mesh: 8}, back: {type: beam, nodes: [root, other], section: rod, mesh: 8}}")
    text = text.replace("about: [0.2, 1, 0]", "about: [0.2, 1, 0], at_rest: [pylon]")
    base, alone = operating_point(deck(text)), operating_point(deck(ROD.replace("MESH", "8")))
    np.testing.assert_allclose(place(base, "pylon"), [0.2, 1, 3], atol=1e-10)
    np.testing.assert_allclose(place(base, "tip"), place(alone, "tip"), rtol=1e-9)
    assert "not an equilibrium" not in modes(deck(text), None, frame="root")[0]


BEAD = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {hoop: {position: [0, 0, 0]}, bead: {position: [0.1, 0, 0]}}
    elements:
      hoop: {type: rigid_body, node: hoop, mass: 1, inertia: [1.0e-3, 1.0e-3, 1.0e-3]}
      bead: {type: point_mass, node: bead, mass: 0.1}
    joints:
      shaft: {type: hinge, nodes: [ground, hoop], axis: [0, 0, 1]}
      wire:
        type: point_on_curve
        nodes: [hoop, bead]
        center: [0, 0, 0]
        semi_axis_1: [0.1, 0, 0]
        semi_axis_2: [0, 0, 0.1]
    initial: {steady: {angular_velocity: [0, 0, 12], about: [0, 0, 0]}}
    time: {end: 1, step: 1 ms}
"""


def test_the_bead_on_a_turning_hoop_is_displaced_and_not_the_hoop():
    """The bead slides from the height of the centre to cos p = g/(w^2 r), where 0.1 m is the radius."""
    base, p = operating_point(deck(BEAD)), math.acos(9.81 / (144.0 * 0.1))
    assert place(base, "bead") == pytest.approx([0.1 * math.sin(p), 0.0, -0.1 * math.cos(p)], abs=1e-9)
    assert f"node 'bead' moves by {0.2 * math.sin(0.25 * math.pi - 0.5 * p):.3g} m" in base.warnings[0]


BOLTED = """
    mecano: 1
    gravity: none
    sections: {strip: {type: rectangle, width: 10 mm, height: 4 mm, E: 70 GPa, nu: 0.3, density: 2700}}
    nodes: {hub: {position: [0, 0, 0]}, seat: {position: [0.05, 0, 0]}, root: {position: [0.05, 0, 0]},
            tip: {position: [0.25, 0, 0]}}
    elements:
      hub: {type: rigid_body, node: hub, mass: 1, inertia: [0.1, 0.1, 0.1], attached: [seat]}
      blade: {type: beam, nodes: [root, tip], section: strip, up: [0, 0, 1], mesh: 4}
    joints:
      axle: {type: hinge, nodes: [ground, hub], axis: [0, 0, 1]}
      bolt$i: {repeat: {i: 1..BOLTS}, type: generic, nodes: [seat, root], axis: [0, 0, 1]}
    initial: {steady: {angular_velocity: [0, 0, 300], about: [0, 0, 0]}}
    time: {end: 0.2 ms, step: 10 us}
"""


def test_a_second_bolt_changes_neither_modes_nor_forces():
    """A redundant joint at the root of a blade; its compliance must not strain the stiff blade from the start.

    The modes are those with one bolt; the free rotation neither oscillates nor grows. Shares of the centrifugal force
    stay within 1e-4 of it, those of one bolt within 1e-5.
    """
    decks = [deck(BOLTED.replace("BOLTS", str(bolts))) for bolts in (1, 2)]
    one, two = (modes(d, None, number=4, frame="hub")[1] for d in decks)
    assert one.kinds == two.kinds == ["free"] + 3 * ["oscillation"]
    np.testing.assert_allclose(two.values, one.values, rtol=1e-8)
    for bolts, d in enumerate(decks, start=1):
        pull = RecordedRun(d)["joints/bolt1/force"][:, 0]
        np.testing.assert_allclose(pull, pull[0], rtol=1e-4)
        np.testing.assert_allclose(bolts * pull[0], -(300.0**2) * blade_moment(), rtol=1e-3)


def blade_moment():
    """Return the integral of the mass over the radius [kg m] of the unstrained blade."""
    return 2700 * 0.01 * 0.004 * (0.25**2 - 0.05**2) / 2


ARTICULATED = """
    mecano: 1
    gravity: none
    parameters: {offset: 0.3, length: 5, J: 40*$length**2/12, thin: 1.0e-7}
    nodes:
      hub: {position: [0, 0, 0]}
      arm: {position: [$offset, 0, 0]}
      cuff: {position: [$offset, 0, 0]}
      blade: {position: [$offset, 0, 0]}
    elements:
      hub: {type: rigid_body, node: hub, mass: 10, inertia: [1, 1, 1], attached: [arm]}
      cuff: {type: rigid_body, node: cuff, mass: 1, inertia: [$thin, $thin, $thin]}
      blade: {type: rigid_body, node: blade, mass: 40, center_of_mass: [$length/2, 0, 0], inertia: [$thin, $J, $J]}
    joints:
      shaft: {type: hinge, nodes: [ground, hub], axis: [0, 0, 1]}
      motor: {type: prescribed_angle, nodes: [ground, hub], axis: [0, 0, 1], value: 30*time}
      flap: {type: hinge, nodes: [arm, cuff], axis: [0, 1, 0]}
      lag: {type: hinge, nodes: [cuff, blade], axis: [0, 0, 1]}
    initial: {steady: {angular_velocity: [0, 0, 30], about: [0, 0, 0]}}
    time: {end: 0.1, step: 1 ms}
"""


def test_flap_and_lag_of_an_articulated_blade(verify):
    """n sqrt(1 + q) and n sqrt(q) with q = 3 e/(2 L), at the hinge offset e (Bramwell, Helicopter Dynamics, 1976)."""
    q = 3.0 * 0.3 / (2.0 * 5.0)
    found = modes(deck(ARTICULATED), None, frame="hub")[1].frequency
    known = 30.0 / (2.0 * math.pi) * np.sqrt([q, 1.0 + q])
    verify(S, "articulated blade: lag and flap [Hz]", found, known, "uniform rigid blade", relative=1e-7)


def test_modes_of_a_rotor_in_inertial_axes_name_the_remedy():
    assert "for a rotor take axes that turn with its hub, by --frame NODE" in modes(deck(ARTICULATED), None)[0]

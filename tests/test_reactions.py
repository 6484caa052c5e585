"""Signals that read reactions: of joints that otherwise share unknowns, in loops, conditions, modes and equilibria."""

import numpy as np
import pytest
from small_motions import eigenvalues
from time_runs import RecordedRun, deck

from mecano.errors import DeckError

CHAIN = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      a: {position: [0, 0, 0]}
      b: {position: [0, 0, 0]}
      c: {position: [1, 0, 0]}
      d: {position: [1, 1, 0]}
      e: {position: [1, 1, 0]}
      f: {position: [1, 1, 0]}
    elements:
      one: {type: rigid_body, node: b, mass: 2, center_of_mass: [0.5, 0, 0], inertia: [0.1, 0.3, 0.2]}
      two: {type: rigid_body, node: c, mass: 3, center_of_mass: [0, 0.5, 0], inertia: [0.2, 0.1, 0.2]}
      three: {type: rigid_body, node: d, mass: 1, center_of_mass: [0.2, 0, 0.1], inertia: [0.2, 0.1, 0.2]}
      four: {type: rigid_body, node: e, mass: 1, center_of_mass: [0, 0, 0.2], inertia: [0.2, 0.1, 0.2]}
      five: {type: rigid_body, node: f, mass: 1, inertia: [0.2, 0.1, 0.2]}
      tip: {type: rigid_link, nodes: [b, tip_b]}
      end: {type: rigid_link, nodes: [c, tip_c]}
    joints:
      clamp: {type: fixed, nodes: [ground, a]}
      pin: {type: hinge, nodes: [a, b], axis: [0, 1, 0]}
      ball: {type: spherical, nodes: [tip_b, c]}
      cross: {type: universal, nodes: [tip_c, d], axis_a: [1, 0, 0], axis_b: [0, 1, 0]}
      slide: {type: prismatic, nodes: [d, e], axis: [0, 0, 1], sliding_law: {spring: 900}}
      weld: {type: fixed, nodes: [e, f]}
    SIGNALS
    time: {end: 0.3, step: 0.005}
    """.replace("      f: {", "      tip_b: {position: [1, 0, 0]}\n      tip_c: {position: [1, 1, 0]}\n      f: {")
FORCES = ("clamp.force", "clamp.moment", "pin.force", "ball.force", "cross.force", "slide.moment", "weld.force")


def test_joints_with_multipliers_transmit_the_forces_of_joints_that_share_unknowns():
    """The reactions of the latter are sums of the forces of all other elements."""
    names = [f"{of}.{axis}" for of in FORCES for axis in "xyz"]
    read = ", ".join(f"{name.replace('.', '_')}: {name}" for name in names)
    plain, measured = (RecordedRun(deck(CHAIN.replace("SIGNALS", text))) for text in ("", f"signals: {{{read}}}"))
    assert plain.system.n_l == measured.system.n_l - 6 - 3 - 3 - 3 - 3 - 6
    for of in FORCES:
        expected, own = plain["joints/" + of.replace(".", "/")], measured["joints/" + of.replace(".", "/")]
        scale = np.abs(expected).max()
        assert scale > 0.0
        np.testing.assert_allclose(own, expected, atol=1e-6 * scale, err_msg=of)
        for i, axis in enumerate("xyz"):
            signal = measured[f"signals/{of.replace('.', '_')}_{axis}/value"]
            np.testing.assert_allclose(signal, own[:, i], atol=1e-9 * scale, err_msg=of)


# Two masses m1 and m2 on a rail, joined by a load cell; a force P pushes the first. The cell acts on the second with R:
# m2 a = R + A, where the actuator pushes the second with A = -g R, or lags behind it.
CELL = """
    mecano: 1
    gravity: [0, 0, 0]
    nodes: {first: {position: [0, 0, 0]}, second: {position: [0, 0, 0]}}
    elements:
      first: {type: rigid_body, node: first, mass: 2, inertia: [1, 1, 1]}
      second: {type: rigid_body, node: second, mass: 3, inertia: [1, 1, 1]}
    joints:
      rail: {type: prismatic, nodes: [ground, first], axis: [1, 0, 0], SPRING}
      cell: {type: fixed, nodes: [first, second], RELEASE}
    signals: {answer: ANSWER}
    loads:
      push: {type: force, node: first, direction: [1, 0, 0], value: PUSH}
      actuator: {type: force, node: second, direction: [1, 0, 0], value: answer}
    time: {end: 1, step: 0.01, method: METHOD}
    """


def cell(answer="0*time", spring="", release="", push=10, method="generalized_alpha"):
    text = CELL.replace("ANSWER", answer).replace("SPRING", spring).replace("RELEASE", release)
    return deck(text.replace("PUSH", str(push)).replace("METHOD", method))


@pytest.mark.parametrize("method", ["generalized_alpha", "radau"])
def test_a_force_that_depends_on_a_reaction_at_once(method):
    """With A = -R/2: R = 2 m2 a and P = (m1 + 2 m2) a."""
    m = RecordedRun(cell("-0.5*cell.force.x", method=method))
    a = 10.0 / (2.0 + 2.0 * 3.0)
    # from the first instant on, to a hundredth of the tolerance of forces, of which kept tangents leave a thousandth
    np.testing.assert_allclose(m["joints/cell/force"][:, 0], 6.0 * a, rtol=1e-9)
    np.testing.assert_allclose(m["joints/rail/velocity"], a * m.time, atol=1e-9)


def test_poles_with_a_reaction_in_the_loop(verify):
    """T dA/dt + A = -R/2 and a spring on the rail: (m s^2 + k)(T s + 1/2) + m2 s^2/2 = 0 with m = m1 + m2."""
    lag = "{type: lag, input: -0.5*cell.force.x, time_constant: 0.1}"
    found = eigenvalues(cell(lag, "sliding_law: {spring: 50}"))
    poles = np.roots(np.polyadd(np.polymul([5.0, 0.0, 50.0], [0.1, 0.5]), [1.5, 0.0, 0.0]))
    expected = np.array(sorted(poles, key=lambda x: (abs(x), x.imag)))
    what = "poles of a loop with the reaction of a joint [1/s]"
    verify("Signals and control", what, found, expected, "roots of their polynomial", relative=1e-9)
    at_once = eigenvalues(cell("-0.5*cell.force.x", "sliding_law: {spring: 50}"))
    np.testing.assert_allclose(np.abs(at_once), np.sqrt(50.0 / (2.0 + 2.0 * 3.0)), rtol=1e-12)


def test_a_pin_breaks_at_a_force(verify):
    """The cell transmits m2/(m1 + m2) of a force that grows by 20 N/s: 6 N at 0.5 s."""
    m = RecordedRun(cell(release="release: {when: cell.force.x > 6}", push="20*time"))
    (broken,) = m.event_records
    verify("Release", "joint that breaks at 6 N: instant [s]", broken.t, 0.5, "20 N/s, 3/5 of it", absolute=1e-9)
    speed = m["nodes/second/velocity"][m.time > broken.t, 0]
    np.testing.assert_allclose(speed, 2.0 * 0.5**2, rtol=0.1 * 0.01**2)  # of second order in steps of 0.01 s
    np.testing.assert_allclose(speed, speed[0], rtol=1e-14)
    np.testing.assert_allclose(m["signals/answer/value"], 0.0, atol=0.0)


@pytest.mark.parametrize(
    ("formula", "text"),
    [
        ("cell.force", "'force' of 'cell' cannot be measured: write force.x, force.y, force.z, force.magnitude"),
        ("joints.rail.angle", "'angle' of 'rail' cannot be measured"),
        ("rail.friction_force", "'friction_force' of 'rail' cannot be measured"),
    ],
)
def test_outputs_that_cannot_be_measured(formula, text):
    with pytest.raises(DeckError, match=text.replace("'", ".")):
        cell(formula)


HELD_TWICE = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {a: {position: [0, 0, 0]}, b: {position: [0, 0, 0]}, c: {position: [1, 0, 0]}, d: {position: [1, 0, 0]}}
    elements:
      one: {type: rigid_body, node: a, mass: 2, center_of_mass: [0.3, 0.1, 0], inertia: [0.1, 0.3, 0.2]}
      two: {type: rigid_body, node: b, mass: 3, center_of_mass: [0.5, 0, 0], inertia: [0.2, 0.1, 0.2]}
      three: {type: rigid_body, node: d, mass: 1, center_of_mass: [0, 0, 0.2], inertia: [0.2, 0.1, 0.2]}
      arm: {type: rigid_link, nodes: [b, c]}
    joints:
      support: {type: hinge, nodes: [ground, a], axis: [0, 1, 0]}
      pin: {type: hinge, nodes: [a, b], axis: [0, 1, 0]}
      weld: {type: fixed, nodes: [c, d]}
      AGAIN
    time: {end: 0.1, step: 0.005, newton: {force_tolerance: 1.0e-12, constraint_tolerance: 1.0e-14}}
    """


def test_joints_in_parallel_divide_the_force_that_they_transmit():
    """Two supports at one place, two pins between two bodies, two welds: the sums are the forces of single ones."""
    again = """
      support_2: {type: hinge, nodes: [ground, a], axis: [0, 1, 0]}
      pin_2: {type: hinge, nodes: [a, b], axis: [0, 1, 0]}
      weld_2: {type: fixed, nodes: [c, d]}
    """
    single, double = (RecordedRun(deck(HELD_TWICE.replace("      AGAIN\n", text))) for text in ("", again[1:-4]))
    for joint in ("support", "pin", "weld"):
        for what in ("force", "moment") if joint == "weld" else ("force",):
            expected = single[f"joints/{joint}/{what}"]
            first, second = (double[f"joints/{name}/{what}"] for name in (joint, f"{joint}_2"))
            scale = np.abs(expected).max()
            assert scale > 0.1
            np.testing.assert_allclose(first + second, expected, atol=1e-9 * scale, err_msg=joint)
            np.testing.assert_allclose(first, second, atol=1e-9 * scale, err_msg=joint)


def test_supports_at_both_ends_of_a_chain_divide_its_weight():
    """Three masses at one place in a row of spherical joints: f_1 = 3/4 F_1 + 1/2 F_2 + 1/4 F_3 is least squares."""
    weights = np.array([1.0, 2.0, 4.0]) * 10.0
    recorded = RecordedRun(
        deck("""
        mecano: 1
        gravity: [0, 0, -10]
        nodes: {a: {position: [0, 0, 0]}, b: {position: [0, 0, 0]}, c: {position: [0, 0, 0]}}
        elements:
          one: {type: rigid_body, node: a, mass: 1, inertia: [0.1, 0.3, 0.2]}
          two: {type: rigid_body, node: b, mass: 2, inertia: [0.1, 0.3, 0.2]}
          three: {type: rigid_body, node: c, mass: 4, inertia: [0.1, 0.3, 0.2]}
        joints:
          first: {type: spherical, nodes: [ground, a]}
          second: {type: spherical, nodes: [a, b]}
          third: {type: spherical, nodes: [b, c]}
          last: {type: spherical, nodes: [c, ground]}
        time: {end: 0.01, step: 0.005}
        """)
    )
    first, second, third, last = (
        recorded[f"joints/{name}/force"][-1, 2] for name in ("first", "second", "third", "last")
    )
    np.testing.assert_allclose(first, np.array([0.75, 0.5, 0.25]) @ weights, rtol=1e-12)
    np.testing.assert_allclose([first - second, second - third, third - last], weights, rtol=1e-12)
    np.testing.assert_allclose(last, first - weights.sum(), rtol=1e-12)

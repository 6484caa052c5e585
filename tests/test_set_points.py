"""Springs whose set point is a law of time: closed form of the oscillator, energy."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck

DRIVE = """
    mecano: 1
    gravity: none
    nodes: {body: {position: [0, 0, 0]}FOOT}
    elements:
      body: {type: rigid_body, node: body, mass: 0.5, inertia: [0.5, 0.5, 0.5]}
      ELEMENTS
    joints: {joint: {type: JOINT, nodes: [ground, body], axis: Z, OPTIONS}}
    laws:
      spring: {spring: {stiffness: 20}, damper: {coefficient: 1}}
      motion: {linear: {slope: 1.25}}
    time: {end: 1.0, step: 0.002}
    """
CASES = {
    "hinge": ("", "hinge", "turning_law: spring, natural_angle: motion", "angle"),
    "slide": ("", "prismatic", "sliding_law: spring, natural_displacement: motion", "displacement"),
    "coil": (
        "coil: {type: torsion_spring_damper, nodes: [ground, body], axis: Z, law: spring, natural_angle: motion}",
        "hinge",
        "",
        "angle",
    ),
    "spring": (
        "coil: {type: spring_damper, nodes: [foot, body], law: spring, natural_length: {linear: {slope: 1.25, "
        "offset: 2}}}",
        "prismatic",
        "",
        "displacement",
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_a_drive_follows_its_set_point(case):
    """With s = c - n and n'' = 0, m s'' + d s' + k s = 0 with s(0) = 0, s'(0) = -n'."""
    elements, joint, options, output = CASES[case]
    text = (
        DRIVE.replace("ELEMENTS", elements)
        .replace("FOOT", ", foot: {position: [0, 0, -2], fixed: true}" if "foot" in elements else "")
        .replace("JOINT", joint)
        .replace("OPTIONS", options)
        .replace("Z", "[0, 0, 1]")
    )
    m = RecordedRun(deck(text.replace(", }}", "}}")))
    slope, decay = 1.25, 1.0
    w = np.sqrt(40.0 - decay**2)
    exact = slope * (m.time - np.exp(-decay * m.time) * np.sin(w * m.time) / w)
    np.testing.assert_allclose(m[f"joints/joint/{output}"], exact, atol=3e-5)
    assert np.ptp(m["energy/balance"]) < 1e-4 * m["energy/given"].max()
    assert m["energy/given"][-1] > 0.1


def test_extension_and_its_rate_follow_a_moving_natural_length():
    """Of both nodes at rest: the extension is that of the law alone, also for signals that read it."""
    m = RecordedRun(
        deck("""
        mecano: 1
        nodes: {a: {position: [0, 0, 0], fixed: true}, b: {position: [0, 0, 2], fixed: true}}
        elements:
          s: {type: spring_damper, nodes: [a, b], law: {spring: {stiffness: 20}, damper: {coefficient: 3}},
              natural_length: {sine: {amplitude: 0.5, frequency: 1, offset: 1.5}}}
        signals: {stretch: s.extension, stretching: s.extension_rate, lengthening: s.rate}
        time: {end: 1, step: 0.01}
        """)
    )
    turned = 2.0 * np.pi * m.time
    extension, rate = 0.5 - 0.5 * np.sin(turned), -np.pi * np.cos(turned)
    force = 20.0 * extension + 3.0 * rate
    expected = {
        "elements/s/extension": extension, "elements/s/stroke": -extension, "elements/s/extension_rate": rate,
        "elements/s/rate": 0.0, "elements/s/force": force, "signals/stretch/value": extension,
        "signals/stretching/value": rate, "signals/lengthening/value": 0.0,
    }  # fmt: skip
    for path, values in expected.items():
        np.testing.assert_allclose(m[path], values, rtol=1e-10, atol=1e-10, err_msg=path)

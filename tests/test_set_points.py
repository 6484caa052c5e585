"""Springs whose set point is a law of time: closed form of the oscillator, energy."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck

DRIVE = """
    mecano: 1
    gravity: none
    nodes: {body: {position: [0, 0, 0]}}
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
}


@pytest.mark.parametrize("case", CASES)
def test_a_drive_follows_its_set_point(case):
    """With s = c - n and n'' = 0, m s'' + d s' + k s = 0 with s(0) = 0, s'(0) = -n'."""
    elements, joint, options, output = CASES[case]
    text = (
        DRIVE.replace("ELEMENTS", elements)
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

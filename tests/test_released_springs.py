"""Springs and bushings that are detached at a time or by a condition: motion, momentum, energy."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck, input_deck

from mecano.errors import DeckError

NODES = ("carrier", "satellite")
K, STROKE, STAGE, PAYLOAD = 2000.0, 0.05, 20.0, 5.0


def test_a_spring_pushes_a_satellite_off(verify):
    """The stroke is STROKE cos(w t) until it is zero, after a quarter of a period; then both move uniformly."""
    w = np.sqrt(K * (1.0 / STAGE + 1.0 / PAYLOAD))
    quarter = 0.5 * np.pi / w
    end = 0.3 - 0.1 - quarter  # of the free flight
    apart = 0.3 + STROKE + STROKE * w * end
    share = np.array([-PAYLOAD, STAGE]) / (STAGE + PAYLOAD)
    places = share * apart + 0.3 * PAYLOAD / (STAGE + PAYLOAD)
    known = np.array([0.1 + quarter, *(share * STROKE * w), *places])
    found = []
    for h in (2e-3, 1e-3):
        m = RecordedRun(input_deck("separation", f"time.step={h}"))
        (released,) = [event for event in m.event_records if event.element == "spring_damper 'spring'"]
        ends = [
            m[f"nodes/{node}/{what}"][-1, 2] for what in ("velocity", "position") for node in ("carrier", "satellite")
        ]
        found.append(np.array([released.t, *ends]))
        np.testing.assert_array_equal(m["elements/spring/force"][m.time > released.t + 1e-9], 0.0)
    what = "satellite pushed off: instant of the release, speeds [m/s] and places [m]"
    verify.second_order("Release", what, *found, known, 2e-7, "oscillation of two masses")


LOSS = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}}
    elements:
      body: {type: rigid_body, node: a, mass: 2, inertia: [0.5, 0.5, 0.5]}
      mount: {type: TYPE, nodes: [ground, a], PROPERTIES, release: {time: 0.25}}
    joints: {guide: {type: JOINT, nodes: [ground, a], axis: [0, 0, 1]}}
    initial: {velocities: [{nodes: [a], velocity: [0, 0, 0.8], angular_velocity: [0, 0, 0.8]}]}
    time: {end: 0.5, step: 0.001}
    """
COIL = "axis: [0, 0, 1], law: {spring: 18}"
MOUNTS = {
    "torsion_spring_damper": ("torsion_spring_damper", COIL, "hinge", "angle", 0.5, 18.0),
    "torsion spring by a signal": (
        "torsion_spring_damper", f"{COIL}, natural_angle: 0*time", "hinge", "angle", 0.5, 18.0,
    ),
    "bushing": ("bushing", "stiffness: [9, 9, 72, 9, 9, 9]", "prismatic", "displacement", 2.0, 72.0),
    "bushing by a signal": (
        "bushing", "stiffness: [9, 9, 72, 9, 9, 9], natural: {about_1: 0*time}", "prismatic", "displacement", 2.0, 72.0,
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", MOUNTS)
def test_a_strained_spring_is_detached(case):
    """c = v/w sin(w t) until 0.25 s, then a uniform motion; the elastic energy of that instant is lost."""
    kind, properties, joint, output, inertia, stiffness = MOUNTS[case]
    text = LOSS.replace("TYPE", kind).replace("PROPERTIES", properties).replace("JOINT", joint)
    m = RecordedRun(deck(text))
    w = np.sqrt(stiffness / inertia)
    at, rate = 0.8 / w * np.sin(0.25 * w), 0.8 * np.cos(0.25 * w)
    exact = np.where(m.time < 0.25, 0.8 / w * np.sin(w * m.time), at + rate * (m.time - 0.25))
    np.testing.assert_allclose(m[f"joints/guide/{output}"], exact, atol=2e-6)
    (released,) = m.event_records
    lost = 0.5 * stiffness * at**2
    assert released.t == pytest.approx(0.25, abs=1e-12) and released.lost == pytest.approx(lost, rel=1e-5)
    assert np.ptp(m["energy/balance"]) < 1e-5 * lost


def test_a_bushing_with_laws_is_not_released():
    text = LOSS.replace("TYPE", "bushing").replace("PROPERTIES", "laws: {along_1: {spring: 3}}")
    with pytest.raises(DeckError, match="'release' and 'laws' exclude one another"):
        deck(text.replace("JOINT", "prismatic"))

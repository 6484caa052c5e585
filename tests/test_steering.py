"""Nose-wheel steering: following error, rate with the valve fully open, poles of the servo."""

import numpy as np
from small_motions import eigenvalues
from time_runs import INPUTS, RecordedRun, input_deck

from mecano.deck.read import read_deck

SERVO = "Signals and control"
GAIN, K, DAMPING, I = 10.0, 3.0e4, 300.0, 0.5 + 0.2 + 10.0 * 0.05**2  # 1/s, N m/rad, N m s/rad, kg m2
C, TRAIL, RELAXATION, SPEED = 6.0e4, 0.05, 0.3, 10.0  # N/rad, m, m, m/s
SHARE = TRAIL * C / K  # of the angle of the collar by which the oil is compressed
FASTEST = np.radians(20.0)


def test_the_collar_follows_the_command(verify):
    """A ramp w of the command: GAIN e = w (1 + SHARE); fully open: (1 + SHARE) dtheta/dt = 20 deg/s.

    The tyre turns the collar back by TRAIL C tan(theta), and by 1e-4 rad less where it builds up: within 1e-3.
    """
    m = RecordedRun(input_deck("nose_wheel_steering"))
    end_of_ramp, open_valve = (np.searchsorted(m.time, t - 1e-4) for t in (1.19, 2.28))
    error = m["signals/error/value"][end_of_ramp]
    what = "steering that follows a ramp: error [rad]"
    verify(SERVO, what, error, np.radians(5.0) * (1.0 + SHARE) / GAIN, "closed form", relative=1e-3)
    rate = m["joints/steering/rate"][open_valve]
    verify(SERVO, "steering with its valve fully open: rate [rad/s]", rate, -FASTEST / (1.0 + SHARE), "closed form",
           relative=1e-3)  # fmt: skip
    assert [event.name for event in m.event_records] == ["lower limit", "lower limit left"]
    units = {column.path: column.unit for column in m.sampler.columns}
    assert {units[f"signals/{name}/value"] for name in ("command", "error", "piston")} == {"rad"}
    assert units["signals/opening/value"] == "-"


def test_poles_of_the_servo(verify, tmp_path):
    """I theta'' = K (s - theta) + DAMPING (s' - theta') - TRAIL F, s' = -GAIN theta.

    (RELAXATION/V) F' + F = C (theta + TRAIL theta'/V).
    A signal that reads a reaction of the tyre has no pole: all poles found are these, and zeros.
    """
    text = (INPUTS / "nose_wheel_steering.yaml").read_text()
    deck = tmp_path / "gauge.yaml"
    deck.write_text(text.replace("signals:\n", "signals:\n  side_load: tyre.lateral_force\n", 1))
    found = eigenvalues(read_deck(deck))
    collar = np.polymul([I, DAMPING, K], [1.0, 0.0])
    servo = np.polymul([DAMPING, K], [GAIN])
    tyre = TRAIL * C * np.array([TRAIL / SPEED, 1.0, 0.0])
    polynomial = np.polyadd(np.polymul(np.polyadd(collar, servo), [RELAXATION / SPEED, 1.0]), tyre)
    expected = np.array(sorted(np.roots(polynomial), key=lambda x: (abs(x), x.imag)))
    nearest = np.array([found[np.argmin(np.abs(found - pole))] for pole in expected])
    assert np.count_nonzero(found) == len(expected)
    verify(SERVO, "poles of the steering [1/s]", nearest, expected, "roots of their polynomial", relative=1e-6)

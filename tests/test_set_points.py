"""Springs whose set point is a law of time: closed form of the oscillator, energy."""

import numpy as np
import pytest
from scipy.linalg import expm
from time_runs import RecordedRun, deck, input_deck

from mecano.errors import DeckError

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
    "bushing": (
        "coil: {type: bushing, nodes: [ground, body], axis: Z, stiffness: [0, 0, 20, 0, 0, 0], "
        "damping: [0, 0, 1, 0, 0, 0], natural: {along_axis: motion}}",
        "prismatic",
        "",
        "displacement",
    ),
    "bushing by a signal": (
        "coil: {type: bushing, nodes: [ground, body], axis: Z, stiffness: [0, 0, 0, 0, 0, 20], "
        "damping: [0, 0, 0, 0, 0, 1], natural: {about_axis: 1.25*time, along_1: 3}}",
        "hinge",
        "",
        "angle",
    ),
    "law of a bushing": (
        "coil: {type: bushing, nodes: [ground, body], axis: Z, laws: {about_axis: spring}, "
        "natural: {about_axis: motion}}",
        "hinge",
        "",
        "angle",
    ),
    "law of a bushing by a signal": (
        "coil: {type: bushing, nodes: [ground, body], axis: Z, laws: {along_axis: spring}, "
        "natural: {along_axis: 1.25*time}}",
        "prismatic",
        "",
        "displacement",
    ),
    "slide by a signal": ("", "prismatic", "sliding_law: spring, natural_displacement: 1.25*time", "displacement"),
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


def _arms(times):
    """Angles of the command and of both arms at ``times``: x = (n, a, a', b, b', 1), x' = A x from 0.2 s on."""
    first, second, k, d, T = 0.08 + 1.0 * 0.5**2, 0.03 + 0.5 * 0.4**2, 40.0, 1.5, 0.1
    A = np.zeros((6, 6))
    A[0, [0, 5]] = -1.0 / T, 0.6 / T
    A[1, 2] = A[3, 4] = 1.0
    A[2] = (k * np.eye(6)[0] - k * np.eye(6)[1] - d * np.eye(6)[2] + d * A[0]) / first
    A[4] = (2.0 * k * np.eye(6)[1] - k * np.eye(6)[3] - d * np.eye(6)[4] + 2.0 * d * np.eye(6)[2]) / second
    x = np.array([expm(A * max(t - 0.2, 0.0))[:, 5] for t in times])
    return x[:, [0, 1, 3]]


def test_drives_follow_signals(verify):
    """A set point that is a lag of a switch, and one that is twice the angle of another joint.

    The rate of the second is a difference quotient: its error of third order remains in the extrapolated values.
    """
    found, balance = [], []
    for h, stride in ((4e-3, 1), (2e-3, 2)):
        m = RecordedRun(input_deck("elastic_drive", f"time.step={h}"))
        times = m.time[::stride]
        paths = "signals/command/value", "joints/drive/angle", "joints/copy/angle"
        found.append(np.stack([m[path][::stride] for path in paths], axis=1))
        balance.append(np.ptp(m["energy/balance"]) / m["energy/given"].max())
    what = "elastic drives by signals: command and angles of both arms [rad]"
    verify.second_order("Signals", what, *found, _arms(times), 3e-6, "exponential of the matrix")
    assert balance[0] / balance[1] == pytest.approx(4.0, abs=0.5) and balance[1] < 1e-3


SIGNAL = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0], fixed: true}, b: {position: [0, 0, 2]}}
    elements:
      b: {type: point_mass, node: b, mass: 1}
      s: {type: spring_damper, nodes: [a, b], law: {spring: 3}, natural_length: motion}
    signals: {SIGNALS}
    time: {end: 1, step: 0.01}
    """


@pytest.mark.parametrize(
    ("signals", "message"),
    [
        (
            "motion: {type: switch, input: time, upper: 0.2}",
            "a set point must not jump, as the switch 'motion' does",
        ),
        (
            "motion: 2*held, held: {type: sample_and_hold, input: time, period: 0.1}",
            "as the sample_and_hold 'held' does",
        ),
        ("motion: {type: delay, input: sign(time - 1), time: 0.1}", "as 'sign' does"),
        (
            "motion: {type: curve, input: time, law: {step: {time: 0.5, rise: 0, from: 1, to: 2}}}",
            "as the curve 'motion' does",
        ),
    ],
)
def test_a_set_point_must_not_jump(signals, message):
    """The energy that the surroundings give in a jump would depend on how fast it is."""
    with pytest.raises(DeckError) as error:
        deck(SIGNAL.replace("SIGNALS", signals))
    assert message in error.value.problems[0].message


JUMP = "{step: {time: 0.5, rise: 0, from: 1, to: 2}}"


@pytest.mark.parametrize("motion", ["motion", JUMP])
def test_a_law_of_a_set_point_must_not_jump(motion):
    """It is refused by name and in place; with a rise it is accepted."""
    text = SIGNAL.replace("signals: {SIGNALS}", f"laws: {{motion: {JUMP}}}")
    text = text.replace("natural_length: motion", f"natural_length: {motion}")
    assert deck(text.replace("rise: 0", "rise: 0.1"))
    with pytest.raises(DeckError) as error:
        deck(text)
    (problem,) = error.value.problems
    assert "'s': a set point must not jump, as this law does at 0.5 s" in problem.message and problem.mark.line == 7


def test_a_bushing_has_formulas_or_laws_as_set_points():
    text = SIGNAL.replace("SIGNALS", "motion: 1").replace("spring_damper", "bushing")
    text = text.replace("law: {spring: 3}, natural_length: motion", "stiffness: [1, 1, 1, 1, 1, 1], natural: {NATURAL}")
    with pytest.raises(DeckError, match="a law can be a signal, a 'curve' of the time"):
        deck(text.replace("NATURAL", "along_1: motion, along_2: {linear: {slope: 1}}"))


@pytest.mark.parametrize(
    "signals",
    [
        "motion: {type: lag, input: on, time_constant: 0.1}, on: {type: switch, input: time, upper: 0.2}",
        "motion: {type: transfer_function, input: sign(time), numerator: [1], denominator: [1, 0.1]}",
        "motion: other, other: 0.1 + motion/2",
    ],
)
def test_a_set_point_may_be_any_continuous_signal(signals):
    deck(SIGNAL.replace("SIGNALS", signals))


HANGING = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {top: {position: [0, 0, 0], fixed: true}, load: {position: [0.1, 0, -1]}}
    elements:
      load: {type: point_mass, node: load, mass: 2}
      rope: {type: KIND, nodes: [top, load], PROPERTIES, natural_length: LENGTH}
    time: {end: 1, step: 0.005, adaptive: {tolerance: 1.0e-6}}
    """
ELASTIC = "axial_stiffness: 2000, damping: 0.01"


@pytest.mark.parametrize(
    ("kind", "properties"),
    [
        ("cable", ELASTIC),
        ("cable", f"{ELASTIC}, release: {{time: 0.7}}"),
        ("bar", ELASTIC),
        ("spring_damper", "law: {spring: 2000, damper: 20}"),
    ],
)
def test_a_length_by_a_signal_is_that_by_a_law(kind, properties):
    """A winch that hauls in at a constant rate, by a law of time and by a formula."""
    recorded = []
    for length in ("{linear: {slope: -0.3, offset: 1}}", "1 - 0.3*time"):
        text = HANGING.replace("KIND", kind).replace("PROPERTIES", properties).replace("LENGTH", length)
        recorded.append(RecordedRun(deck(text)))
    by_law, by_signal = recorded
    for path in ("nodes/load/position", "energy/given", "energy/balance"):
        values = np.interp(by_law.time, by_signal.time, by_signal[path].reshape(len(by_signal.time), -1)[:, -1])
        np.testing.assert_allclose(values, by_law[path].reshape(len(by_law.time), -1)[:, -1], atol=1e-6, err_msg=path)
    assert by_law["energy/given"][-1] > 1.0


@pytest.mark.parametrize(("case", "law"), [("hinge", "turning_law"), ("slide", "sliding_law")])
@pytest.mark.parametrize("value", ["motion", "0.3", "0"])
def test_a_set_point_without_its_law_is_refused(case, law, value):
    foot, joint, options, _ = CASES[case]
    point = options.rpartition(", ")[2].partition(":")[0]
    text = DRIVE.replace("FOOT", foot).replace("ELEMENTS", "").replace("Z", "[0, 0, 1]").replace("JOINT", joint)
    text = text.replace("OPTIONS", f"{point}: {value}")
    if value == "0":  # the default
        deck(text)
        return
    with pytest.raises(DeckError, match=f"'{point}' is that of a '{law}', which is missing"):
        deck(text)

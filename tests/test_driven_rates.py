"""Drives of a given rate: laws of time, integrated without drift, and signals, which prescribe velocities."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck

from mecano.analyses.prepare import prepare, warnings_of
from mecano.analyses.response import ResponseRequest, response
from mecano.errors import AssemblyError, ConvergenceError, DeckError
from mecano.solve.modal.state_space import state_space

ARM, WEIGHT = 0.75, 9.81 * 0.75  # moment of inertia about the pin [kg m2], largest moment of the weight [N m]
PENDULUM = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {{pin: {{position: [0, 0, 0]}}}}
    elements:
      bar: {{type: rigid_body, node: pin, mass: 1, center_of_mass: [0.75, 0, 0], inertia: [1e-4, 0.1875, 0.1875]}}
    joints:
      hinge: {{type: hinge, nodes: [ground, pin], axis: [0, 1, 0]}}
      motor: {{type: prescribed_angle, nodes: [ground, pin], axis: [0, 1, 0], rate: {rate}}}
    time: {{end: 2, step: {step}, rho_inf: 0.8{more}}}
"""
SIGNAL, LAW = '"2 + sin(3*time + 1)"', "[{constant: {value: 2}}, {sine: {amplitude: 1, frequency: 3/(2*pi), phase: 1}}]"


def pendulum(rate, step=1e-3, more=""):
    return RecordedRun(deck(PENDULUM.format(rate=rate, step=step, more=more)))


def known(t):
    """Angle, rate and moment of the motor of the rate 2 + sin(3 t + 1)."""
    angle = 2.0 * t + (np.cos(1.0) - np.cos(3.0 * t + 1.0)) / 3.0
    return angle, 2.0 + np.sin(3.0 * t + 1.0), 3.0 * ARM * np.cos(3.0 * t + 1.0) - WEIGHT * np.cos(angle)


@pytest.mark.parametrize("rate", [SIGNAL, LAW], ids=["signal", "law"])
def test_motion_and_moment_of_a_motor_of_given_rate(verify, rate):
    """Of second order; errors that the start leaves in the moment are of second order, too, and decay."""
    runs, found = [pendulum(rate, step) for step in (2e-3, 1e-3)], []
    for m, every in zip(runs, (100, 200), strict=True):
        found.append(np.concatenate([m[f"joints/motor/{name}"][every::every] for name in ("angle", "moment")]))
    angle, _, moment = known(runs[0].time)
    np.testing.assert_allclose(runs[0]["joints/motor/moment"], moment, rtol=0.0, atol=2e-5)
    exact = np.concatenate([angle[100::100], moment[100::100]])
    what = f"pendulum driven at a rate, {'a signal' if rate is SIGNAL else 'a law of time'}: angle [rad], moment [N m]"
    verify.second_order("Drives of given rate", what, *found, exact, 4e-7, "closed form")


def test_a_law_of_the_rate_has_no_drift():
    m = pendulum("10 rev/s", 2e-3)
    np.testing.assert_allclose(m["joints/motor/angle"], 20.0 * np.pi * m.time, rtol=0.0, atol=2e-12)
    np.testing.assert_allclose(m["joints/hinge/angle"], 20.0 * np.pi * m.time, rtol=0.0, atol=2e-12)


@pytest.mark.parametrize(("rate", "begins"), [("{linear: {slope: 0.5}}", 0.25), ("0.5*time", 0.0)])
def test_a_law_turns_from_the_time_0_and_a_formula_from_the_start(rate, begins):
    m = pendulum(rate, 1e-2, ", start: 1")
    np.testing.assert_allclose(m["joints/hinge/angle"], begins + 0.25 * (m.time**2 - 1.0), rtol=0.0, atol=1e-12)


def test_radau_follows_a_signal():
    m = pendulum(SIGNAL, 1e-2, ", method: radau")
    for name, value, within in zip(("angle", "rate", "moment"), known(m.time), (1e-9, 1e-12, 1e-6), strict=True):
        np.testing.assert_allclose(m[f"joints/motor/{name}"], value, rtol=0.0, atol=within)


def test_the_motor_supplies_its_power():
    """The energy of the bar is what the motor gives, also by signals, to the error of the trapezoidal rule."""
    for rate in (SIGNAL, LAW):
        m = pendulum(rate)
        given, *stored = (m[f"energy/{name}"] for name in ("given", "kinetic", "potential"))
        np.testing.assert_allclose(given, sum(stored) - sum(stored)[0], rtol=0.0, atol=2e-5)


CARRIAGE = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {tool: {position: [0.3, 0.1, 0]}, end: {position: [0.3, 0.1, 2]}}
    elements:
      tool: {type: rigid_body, node: tool, mass: 2, inertia: [0.1, 0.2, 0.3]}
      end: {type: point_mass, node: end, mass: 1}
    joints:
      axes: {type: generic, nodes: [ground, tool], axis: [0, 0, 1], axis_1: [1, 0, 0], free: [along_2, about_2],
        driven: {along_1: 0.5*time**2},
        driven_rates: {about_axis: {sine: {amplitude: 2, frequency: 1}}, along_axis: "1 - axes.displacement.z"}}
      leg: {type: prescribed_length, nodes: [tool, end], rate: "0.2*cos(time)"}
      rail_1: {type: prescribed_position, node: end, direction: [1, 0, 0], rate: axes.velocity.x}
      rail_2: {type: prescribed_position, node: end, direction: [0, 1, 0], rate: {constant: {value: 0}}}
    time: {end: 1, step: 1e-3}
"""


def test_rates_along_all_axes_of_a_generic_joint():
    """Motions in closed form; the force along the axis accelerates the tool and carries both weights."""
    m = RecordedRun(deck(CARRIAGE))
    t, moved = m.time, m["joints/axes/displacement"]
    np.testing.assert_allclose(moved[:, 0], 0.5 * t**2, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(moved[:, 2], 1.0 - np.exp(-t), rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(m["joints/axes/angle"], (1.0 - np.cos(2.0 * np.pi * t)) / np.pi, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(m["joints/rail_1/displacement"], 0.5 * t**2, rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(m["joints/leg/length"], 2.0 + 0.2 * np.sin(t), rtol=0.0, atol=1e-7)
    of_end = 9.81 - np.exp(-t) - 0.2 * np.sin(t)
    np.testing.assert_allclose(m["joints/leg/force"], of_end, rtol=0.0, atol=1e-5)
    force = 2.0 * (9.81 - np.exp(-t)) + of_end
    np.testing.assert_allclose(m["joints/axes/force"][:, 2], force, rtol=0.0, atol=1e-5)
    given, *stored = (m[f"energy/{name}"] for name in ("given", "kinetic", "potential"))
    np.testing.assert_allclose(given, sum(stored) - sum(stored)[0], rtol=0.0, atol=1e-5)


FOLLOWER = (
    PENDULUM.replace("nodes: {{pin", "nodes: {{disc: {{position: [0, 1, 0]}}, pin")
    .replace(
        "joints:",
        "  disc: {{type: rigid_body, node: disc, mass: 1, inertia: [0.1, 0.2, 0.1]}}\n    joints:\n"
        "      axle: {{type: hinge, nodes: [ground, disc], axis: [0, 1, 0]}}",
    )
    .replace("nodes: [ground, pin], axis: [0, 1, 0], rate", "nodes: [ground, disc], axis: [0, 1, 0], rate")
)


@pytest.mark.parametrize("more", ["", ", method: radau"], ids=["generalized_alpha", "radau"])
def test_a_disc_follows_the_rate_of_a_falling_pendulum(more):
    """A signal of velocities: the moment is J 3 a with the acceleration a of the pendulum, from the first step on."""
    m = RecordedRun(deck(FOLLOWER.format(rate="3*hinge.rate", step=1e-3, more=more)))
    np.testing.assert_allclose(m["joints/axle/rate"], 3.0 * m["joints/hinge/rate"], rtol=0.0, atol=1e-9)
    moment = 0.2 * 3.0 * WEIGHT / ARM * np.cos(m["joints/hinge/angle"])
    np.testing.assert_allclose(m["joints/motor/moment"], moment, rtol=0.0, atol=1e-4)


def test_the_start_has_the_velocities_that_signals_prescribe():
    text = FOLLOWER.format(rate="3*hinge.rate", step=1e-3, more="")
    start = "initial: {velocities: [{nodes: [pin], angular_velocity: [0, 2, 0]}]}\n    time:"
    m = RecordedRun(deck(text.replace("time:", start, 1)))
    assert m["joints/hinge/rate"][0] == pytest.approx(2.0, abs=1e-12)
    assert m["joints/motor/rate"][0] == pytest.approx(6.0, abs=1e-9)
    assert m["joints/motor/moment"][0] == pytest.approx(0.6 * WEIGHT / ARM, abs=1e-8)


def test_a_rate_that_is_its_own_signal_is_refused():
    with pytest.raises(AssemblyError, match="such that no velocities satisfy them"):
        pendulum("1 + motor.rate")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("rate: 1, value: 0", "give exactly one of 'value', 'rate'"),
        ("", "give exactly one of 'value', 'rate'"),
        ("rate: {step: {time: 1, rise: 0, from: 0, to: 1}}", "a set point must not jump"),
        ("rate: sign(hinge.angle)", "a set point must not jump"),
    ],
)
def test_errors_of_decks(given, message):
    text = PENDULUM.format(rate="GIVEN", step=1e-3, more="")
    with pytest.raises(DeckError, match=message):
        deck(text.replace(", rate: GIVEN", f", {given}" if given else ""))


def test_a_search_for_an_equilibrium_refuses_a_rate_by_a_signal():
    text = PENDULUM.format(rate="0.1*cos(time)", step=1e-3, more="").replace("time: {", "initial: static\n    time: {")
    with pytest.raises(AssemblyError, match="'motor' prescribes a rate by a signal"):
        RecordedRun(deck(text))


def test_an_equilibrium_holds_the_angle_of_a_law_of_the_rate():
    text = PENDULUM.format(rate="{sine: {amplitude: 1, frequency: 1}}", step=1e-3, more="")
    m = RecordedRun(deck(text.replace("time: {", "initial: static\n    time: {")))
    assert m["joints/motor/angle"][0] == pytest.approx(0.0, abs=1e-12)
    assert m["joints/motor/moment"][0] == pytest.approx(2.0 * np.pi * ARM - WEIGHT, abs=1e-9)


ROTOR = """
    mecano: 1
    gravity: none
    nodes: {{shaft: {{position: [0, 0, 0]}}, ring: {{position: [0, 0, 0]}}}}
    elements:
      shaft: {{type: rigid_body, node: shaft, mass: 1, inertia: [1, 2, 1]}}
      ring: {{type: rigid_body, node: ring, mass: 1, inertia: [1, 0.5, 1]}}
      coil: {{type: torsion_spring_damper, nodes: [shaft, ring], axis: [0, 1, 0], law: {{spring: 50, damper: 0.5}}}}
    joints:
      axle: {{type: hinge, nodes: [ground, shaft], axis: [0, 1, 0]}}
      bearing: {{type: hinge, nodes: [shaft, ring], axis: [0, 1, 0]}}
      motor: {{type: prescribed_angle, nodes: [ground, shaft], axis: [0, 1, 0], rate: {rate}}}
    signals: {{command: {{type: lag, input: 0*time, time_constant: 0.1}}}}
    time: {{end: 1, step: 1e-3}}
"""


@pytest.mark.parametrize(("rate", "channel"), [("command", "command"), ("0", "motor.rate")])
def test_the_response_to_a_rate(rate, channel):
    """Of a shaft with a ring on a coil: the moment, s (J + C k(s)/(C s^2 + k(s))), and both angles, over the rate."""
    model, frequencies = deck(ROTOR.format(rate=rate)), {"low": 0.1, "high": 10.0}
    found = response(model, None, ResponseRequest(inputs=[channel], outputs=["motor.moment"], **frequencies))[1]
    s = 2j * np.pi * found.frequency
    coil = 50.0 + 0.5 * s
    moment = s * (2.0 + 0.5 * coil / (0.5 * s**2 + coil))
    np.testing.assert_allclose(found.values[:, 0, 0], moment, rtol=1e-9)
    of_angles = ResponseRequest(inputs=[channel], outputs=["axle.angle", "bearing.angle"], **frequencies)
    found = response(model, None, of_angles)[1]
    s = 2j * np.pi * found.frequency
    angles = np.array([1.0 / s, -0.5 * s / (0.5 * s**2 + 0.5 * s + 50.0)]).T
    small = state_space(found.plant)
    own = [(small.C @ small.motion(one) + small.D)[:, 0] for one in s]
    np.testing.assert_allclose(found.values[:, :, 0], angles, rtol=1e-9)
    np.testing.assert_allclose(own, angles, rtol=1e-7)


STOPPED = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}, b: {position: [0, 1, 0]}}
    elements:
      first: {type: rigid_body, node: a, mass: 1, inertia: [1, 0.5, 1]}
      disc: {type: rigid_body, node: b, mass: 1, inertia: [1, 0.2, 1]}
    joints:
      first: {type: hinge, nodes: [ground, a], axis: [0, 1, 0], stops: {lower: -10, upper: 1, restitution: 0.5}}
      disc: {type: hinge, nodes: [ground, b], axis: [0, 1, 0]}
      drive: DRIVE
    initial: {velocities: [{nodes: [a], angular_velocity: [0, 2, 0]}, {nodes: [b], angular_velocity: [0, 6, 0]}]}
    time: {end: 1, step: 1e-3MORE}
"""


@pytest.mark.parametrize("more", ["", ", method: radau"], ids=["generalized_alpha", "radau"])
def test_a_rate_that_jumps_with_a_shock(more):
    """The drive gives the change of the energy of the disc, 0.2 (3^2 - 6^2)/2 J; the stop takes that of the first."""
    drive = "{type: prescribed_angle, nodes: [ground, b], axis: [0, 1, 0], rate: 3*first.rate}"
    m = RecordedRun(deck(STOPPED.replace("DRIVE", drive).replace("MORE", more)))
    assert m["joints/first/rate"][-1] == pytest.approx(-1.0, abs=1e-9)
    assert m["joints/disc/rate"][-1] == pytest.approx(-3.0, abs=1e-9)
    assert m["energy/given"][-1] == pytest.approx(-2.7, abs=1e-9)
    assert m["energy/dissipated"][-1] == pytest.approx(0.75, abs=1e-9)
    assert np.ptp(m["energy/balance"]) < 1e-9


@pytest.mark.parametrize("more", ["", ", method: radau"], ids=["generalized_alpha", "radau"])
def test_a_ratio_that_jumps_with_a_shock(more):
    """Behind the stop the ratio is r = 2 + a'/2; the variator then turns a by -r J and b by J to b' = r a'."""
    drive = "{type: coupler, angles: [disc, first], ratio: 2 + first.rate/2}"
    m = RecordedRun(deck(STOPPED.replace("DRIVE", drive).replace("MORE", more)))
    a, b = m["joints/first/rate"][-1], m["joints/disc/rate"][-1]
    r = 2.0 + a / 2.0
    impulse = 0.2 * (b + 3.0)
    assert b == pytest.approx(r * a, abs=1e-9) and 0.5 * (a + 1.0) == pytest.approx(-r * impulse, abs=1e-8)
    assert np.ptp(m["energy/balance"]) < 1e-8


def test_steps_of_a_microsecond():
    """Rates of signals are differences over a fiftieth of a step, whose rounding is not an error."""
    text = PENDULUM.format(rate=SIGNAL.replace("2 +", "200 +"), step=1e-6, more="")
    m = RecordedRun(deck(text.replace("end: 2,", "end: 2e-5,")))
    np.testing.assert_allclose(m["joints/motor/moment"][0], known(0.0)[2], rtol=0.0, atol=1e-3)


def test_a_model_that_only_drives_move_is_not_immobile():
    text = """
        mecano: 1
        gravity: none
        nodes: {a: {position: [0, 0, 0]}}
        elements: {body: {type: rigid_body, node: a, mass: 1, inertia: [1, 2, 1]}}
        joints: {axes: {type: generic, nodes: [ground, a], axis: [0, 0, 1], GIVEN}}
        time: {end: 1, step: 0.1}
    """
    warned = [
        any("nothing can move" in text for text in warnings_of(prepare(deck(text.replace("GIVEN", given)))))
        for given in ("driven_rates: {about_axis: 1}", "free: []")
    ]
    assert warned == [False, True]


CART = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      body: {position: [0, 0, 0.35]}
      front_pin: {position: [1, 0, 0.3]}
      rear_pin: {position: [-1, 0, 0.3]}
      front: {position: [1, 0, 0.3]}
      rear: {position: [-1, 0, 0.3]}
    elements:
      body: {type: rigid_body, node: body, mass: 200, inertia: [50, 50, 50], attached: [front_pin, rear_pin]}
      front: {type: rigid_body, node: front, mass: 10, inertia: [0.3, 0.5, 0.3]}
      rear: {type: rigid_body, node: rear, mass: 10, inertia: [0.3, 0.5, 0.3]}
      tyre_front: {type: wheel, node: front, axis: [0, 1, 0], tire_law: tyre, ground: road}
      tyre_rear: {type: wheel, node: rear, axis: [0, 1, 0], tire_law: tyre, ground: road}
    joints:
      upright: {type: planar, nodes: [ground, body], axis: [0, 1, 0]}
      axle_front: {type: hinge, nodes: [front_pin, front], axis: [0, 1, 0]}
      axle_rear: {type: hinge, nodes: [rear_pin, rear], axis: [0, 1, 0]}
      motor: {type: prescribed_angle, nodes: [front_pin, front], axis: [0, 1, 0], rate: command}
    signals:
      command: {type: integrator, input: 10*(10 - body.velocity.x), initial: FIRST}
    loads:
      drag: {type: force, node: body, direction: [-1, 0, 0], value: 0.5*body.velocity.x**2}
    tire_laws:
      tyre: {radius: 0.3, radial: {linear: 200 kN/m}, fiala: {cornering_stiffness: 30 kN/rad, friction: 0.9}}
    grounds: {road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
    initial: {steady: {velocity: [10, 0, 0]}}
    time: {end: 0.2, step: 0.002}
"""


def test_steady_running_with_a_rate_by_a_signal():
    """The integrator reaches the spin at which the tyre pulls against the drag; then nothing changes."""
    m = RecordedRun(deck(CART.replace("FIRST", "34")))
    force, height = m["elements/tyre_front/longitudinal_force"], m["nodes/front/position"][0, 2]
    np.testing.assert_allclose(force, 0.5 * 10.0**2, rtol=1e-6)
    np.testing.assert_allclose(m["joints/motor/moment"], 50.0 * height, rtol=1e-6)
    np.testing.assert_allclose(m["joints/axle_front/rate"], m["signals/command/value"], rtol=1e-9)
    np.testing.assert_allclose(m["nodes/body/velocity"][:, 0], 10.0, rtol=1e-9)


def test_steady_running_far_from_the_first_rate_of_an_integrator():
    with pytest.raises(ConvergenceError, match="'initial' value of its integrator near the rate in steady motion"):
        RecordedRun(deck(CART.replace("FIRST", "0")))

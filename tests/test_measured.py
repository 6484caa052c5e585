"""Signals that measure the loads of elements: they equal the outputs of the elements, also in conditions."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck

from mecano.analyses.kind_samples import samples
from mecano.analyses.output_tests import sensor_of
from mecano.analyses.prepare import prepare
from mecano.elements import KINDS
from mecano.errors import DeckError
from mecano.jit import ahead, store
from mecano.jit.ahead import compile_ahead
from mecano.model import loops
from mecano.model.loop_code import codes_of
from mecano.model.measured_outputs import measurable
from mecano.model.signal_units import signal_units

SWINGING = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {top: {position: [0, 0, 0], fixed: true}, load: {position: [0.3, 0, -1]}}
    elements:
      load: {type: rigid_body, node: load, mass: 2, inertia: [0.1, 0.1, 0.1]}
      held: {type: point_mass, node: top, mass: 1}
      measured: {type: TYPE, PROPERTIES}
    grounds: {road: {plane: {normal: [0, 0, 1], point: [0, 0, -1.5]}}}
    tire_laws: {rubber: {radius: 0.2, radial: {linear: {slope: 4000}}, friction: 0.6, slip_regularization: 0.5}}
    initial: {velocities: [{nodes: [load], velocity: [0.4, 0.2, 0]}]}
    signals: {SIGNALS}
    time: {end: 0.6, step: 0.002}
    """
ON_A_PIN = """
        mecano: 1
        gravity: none
        nodes: {bob: {position: [0, 0, 0]}}
        elements: {bob: {type: rigid_body, node: bob, mass: 1, inertia: [1, 1, 1]}}
        joints: {pin: {type: hinge, nodes: [ground, bob], axis: [0, 0, 1]}}
"""  # a body, to which sections of this indent are added
SINE = "{sine: {amplitude: 0.1, frequency: 2, offset: 1.04}}"
LINE = "nodes: [top, load], axial_stiffness: 4000, damping: 0.002, natural_length: "
TURNING = "nodes: [top, load], axis: [0, 1, 0], law: {spring: 3, damper: 0.4}, natural_angle: "
CASES = {
    "bar": ("bar", f"{LINE} 1", ("length", "strain", "tension")),
    "cable that goes slack": ("cable", f"{LINE} {SINE}", ("tension",)),
    "cable by a signal": ("cable", f"{LINE} 1.04 + 0.1*sin(9*time)", ("length", "strain", "tension")),
    "torsion spring": ("torsion_spring_damper", f"{TURNING} {{linear: {{slope: 2}}}}", ("angle", "moment")),
    "torsion spring by a signal": ("torsion_spring_damper", f"{TURNING} 2*time", ("moment",)),
    "spring by a signal": (
        "spring_damper", "nodes: [top, load], law: {spring: 900, damper: 2}, natural_length: 1 - 0.1*time",
        ("extension", "extension_rate", "force"),
    ),
    "contact": (
        "contact", "nodes: [top, load], plane: {normal: [0, 0, 1], point: [0, 0, -1.5]}, radius: 0.1",
        ("gap", "normal_force", "force.z"),
    ),
    "wheel that slips": (
        "wheel", "node: load, axis: [0, 1, 0], ground: road, tire_law: rubber",
        (
            "normal_force", "contact_force.x", "contact_force.magnitude", "longitudinal_slip", "spin_rate",
            "slip_ratio", "lateral_slip",
        ),
    ),
    "oleo": (
        "oleo", "nodes: [top, load], extended_length: 1.2, gas: {pressure: 1.1e5, volume: 1.0e-3, area: 1.0e-3}, "
        "oil: {area: 1.0e-3, volume: 1.0e-3, orifice: 1.0e-4}",
        ("force", "gas_pressure", "oil_pressure", "flow"),
    ),
}  # fmt: skip
FEW = "cable that goes slack", "spring by a signal", "contact", "wheel that slips"  # each sensor is compiled
MORE = [pytest.param(case, marks=pytest.mark.slow) for case in CASES if case not in FEW]


@pytest.mark.parametrize("case", [*FEW, *MORE])
def test_a_signal_equals_the_output_that_it_measures(case):
    kind, properties, outputs = CASES[case]
    signals = ", ".join(f"of_{output.replace('.', '_')}: measured.{output}" for output in outputs)
    text = SWINGING.replace("TYPE", kind).replace("PROPERTIES", properties).replace("SIGNALS", signals)
    m = RecordedRun(deck(text))
    smooth = ~np.isin(m.time, [event.t for event in m.event_records])  # the damping force of a cable jumps there
    for output in outputs:
        name, _, axis = output.partition(".")
        values = m[f"elements/measured/{name}"][smooth]
        if axis:
            values = np.linalg.norm(values, axis=1) if axis == "magnitude" else values[:, "xyz".index(axis)]
        scale = np.abs(values).max()
        assert scale > 0.0
        signal = m[f"signals/of_{output.replace('.', '_')}/value"][smooth]
        np.testing.assert_allclose(signal, values, atol=1e-9 * scale, err_msg=output)


def test_a_cable_breaks_at_a_tension(verify):
    """A force of 20 N/s is added to a weight of 19.62 N: the tension is their sum once the cable lengthens steadily.

    The oscillation before has decayed by exp(-40): w = sqrt(EA/(L m)) = 316 rad/s, and the damping is tau w/2 = 0.32.
    """
    m = RecordedRun(
        deck("""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {top: {position: [0, 0, 0], fixed: true}, load: {position: [0, 0, -1]}}
        elements:
          load: {type: point_mass, node: load, mass: 2}
          rope: {type: cable, nodes: [top, load], axial_stiffness: 2.0e5, damping: 2 ms, natural_length: 1/1.0000981,
                 release: {when: rope.tension > 27.62}}
        loads: {pull: {type: force, node: load, direction: [0, 0, -1], value: {linear: {slope: 20}}}}
        time: {end: 0.5, step: 1.0e-3}
        """)
    )
    (broken,) = m.event_records
    what = "cable that breaks at 27.62 N: instant [s]"
    verify("Release", what, broken.t, 0.4, "20 N/s added to the weight", absolute=1e-7)
    z, speed = m["nodes/load/position"][:, 2], m["nodes/load/velocity"][:, 2]
    after = m.time > broken.t
    i = int(np.flatnonzero(after)[0])
    fall = speed[i] - 9.81 * (m.time - m.time[i]) - 10.0 * (m.time**2 - m.time[i] ** 2) / 2.0
    np.testing.assert_allclose(speed[after], fall[after], atol=1e-6)
    assert z[-1] < z[i]


def test_the_motion_of_a_node_and_that_of_its_body_of_the_same_name():
    """The centre of mass is (0, 0, -1) m from the node; about a fixed node it moves and the node does not."""
    text = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {bar: {position: [0, 0, 0]}}
    elements: {bar: {type: rigid_body, node: bar, mass: 2, center_of_mass: [0, 0, -1], inertia: [0.1, 0.1, 0.1]}}
    joints: {pin: {type: hinge, nodes: [ground, bar], axis: [0, 1, 0]}}
    initial: {velocities: [{nodes: [bar], angular_velocity: [0, 0.5, 0]}]}
    signals: {of_node: bar.velocity.x, of_body: elements.bar.velocity.x}
    time: {end: 0.1, step: 0.01}
    """
    m = RecordedRun(deck(text))
    np.testing.assert_allclose(m["signals/of_node/value"], 0.0, atol=1e-12)
    np.testing.assert_allclose(m["signals/of_body/value"], m["elements/bar/velocity"][:, 0], atol=1e-12)
    assert np.abs(m["signals/of_body/value"]).min() > 0.3


@pytest.mark.parametrize(
    ("formula", "unit"),
    [
        ("sin(pin.angle)", "-"), ("1 + tanh(pin.angle)", "-"), ("sqrt(abs(pin.angle))", "SI"), ("exp(pin.angle)", "-"),
        ("atan(pin.rate) - pin.angle", "rad"), ("-abs(pin.angle)", "rad"), ("max(pin.force.x, 2)", "N"),
        ("sqrt(bob.velocity.x**2 + bob.velocity.y**2)", "m/s"), ("bob.velocity.x/hypot(bob.velocity.y, 0.1)", "-"),
        ("nodes.bob.position.x*pin.rate", "m/s"), ("pin.moment.x*pin.rate", "W"), ("pin.moment.x/pin.angle", "N m/rad"),
        ("pin.rate - bob.velocity.x/nodes.bob.position.y", "rad/s"), ("pin.rate*time", "rad"), ("2*pin.rate", "SI"),
        ("pin.force.x/nodes.bob.position.x**2", "Pa"), ("pin.force.x/time/bob.velocity.x**2", "N s/m2"),
        ("2**3 + pin.angle", "rad"), ("pin.rate**2*nodes.bob.position.x", "m/s2"), ("1/pin.rate", "SI"),
    ],
)  # fmt: skip
def test_functions_have_units_of_their_own(formula, unit):
    of_pendulum = (
        ON_A_PIN
        + """
        signals: {read: "FORMULA"}
        time: {end: 1, step: 0.1}
        """
    )
    model = prepare(deck(of_pendulum.replace("FORMULA", formula))).system.model
    assert signal_units(model) == {"signals/read/value": unit}


def test_states_of_a_controller_have_the_units_of_value_and_error():
    """Of u = K_P e + x_I + K_D/T_D (e - x_D), x_I has the unit of u and x_D that of e, here an angular velocity."""
    text = (
        ON_A_PIN
        + """
        signals:
          torque: {type: pid, input: 3 - pin.rate, integral: 2, derivative: 1, derivative_time: 0.1, unit: kN m}
          fast: {type: washout, input: pin.angle, gain: 10, time_constant: 0.1}
          turned: {type: integrator, input: fast*pin.moment.z}
          slow: {type: washout, input: pin.angle, gain: 5, time_constant: 0.1}
        time: {end: 1, step: 0.1}
        """
    )
    assert signal_units(prepare(deck(text)).system.model) == {
        "signals/torque/value": "N m", "signals/torque/integral": "N m", "signals/torque/filtered": "rad/s",
        "signals/fast/value": "rad/s", "signals/fast/state": "rad", "signals/turned/value": "N m",
        "signals/slow/value": "SI", "signals/slow/state": "rad",
    }  # fmt: skip


def test_signals_have_the_unit_of_the_field_whose_value_they_are():
    """So has the signal that a lag follows; one that is a force and a moment has none, and a unit in the deck holds."""
    text = (
        ON_A_PIN
        + """
        signals:
          wanted: 20*(0.1 - pin.angle)
          torque: {type: lag, input: wanted, time_constant: 0.1}
          both: 3*time
          target: {type: curve, input: time, law: {linear: {slope: 2 deg/s}}}
          slow: {type: lag, input: later, time_constant: 0.1}
          later: 0.3*time
          missing: max(target - pin.angle, slow)
          share: {type: formula, value: 2*time, unit: "1"}
        loads:
          motor: {type: joint_moment, joint: pin, value: torque}
          brake: {type: joint_moment, joint: pin, value: "0.2*hypot(bob.velocity.x, bob.velocity.y)"}
          turn: {type: moment, node: bob, direction: [0, 0, 1], value: both}
          push: {type: force, node: bob, direction: [0, 0, 1], value: both}
          pull: {type: force, node: bob, direction: [0, 0, 1], value: share}
          rub: {type: force, node: bob, direction: [0, 0, 1], value: pin.angle + pin.moment.x/pin.moment.y}
        time: {end: 1, step: 0.1}
        """
    )
    assert prepare(deck(text)).system.signal_units == {
        "signals/wanted/value": "N m", "signals/torque/value": "N m", "signals/both/value": "SI",
        "signals/target/value": "rad", "signals/slow/value": "rad", "signals/later/value": "rad",
        "signals/missing/value": "rad", "signals/share/value": "-", "formulas/time/value": "s",
        "formulas/0.2*hypot(bob.velocity.x, bob.velocity.y)/value": "SI",
        "formulas/pin.angle + pin.moment.x\N{DIVISION SLASH}pin.moment.y/value": "rad",
    }  # fmt: skip


def test_an_unknown_name_in_what_is_measured_is_the_only_error():
    """The outputs of a wheel depend on its tyre law; if this is unknown, only its name is reported."""
    text = SWINGING.replace("TYPE", "wheel").replace("PROPERTIES", CASES["wheel that slips"][1])
    text = text.replace("SIGNALS", "slip: measured.slip_ratio").replace("tire_law: rubber", "tire_law: ruber")
    with pytest.raises(DeckError) as error:
        deck(text)
    assert [problem.message for problem in error.value.problems] == ["wheel 'measured': unknown tire law 'ruber'"]


@pytest.mark.slow
def test_sensors_of_all_kinds_compile(monkeypatch):
    """The generic tests call them as plain Python, which accepts more."""
    monkeypatch.setattr(ahead, "cores", lambda: 2)  # one process would compile none of them ahead
    codes = {}
    for kind in KINDS.values():
        for instance in (one for sample in samples(kind) for one in sample.instances):
            if instance.kind.observe is not None and measurable(instance.kind):
                sensor = sensor_of(instance, 0).kind
                codes |= {
                    (sensor.name, loop): codes_of(sensor, loop).function for loop in (loops.tangent, loops.residual)
                }
    compile_ahead(list(codes.values()))
    assert [name for (name, _), code in codes.items() if not store.contains(code.file)] == []

"""Springs, bushings and contacts that begin to act at a time or by a condition: motion and energy."""

import math
import textwrap
from itertools import product

import numpy as np
import pytest
from test_released_cables import HANGING
from test_released_springs import LOSS, MOUNTS
from time_runs import RecordedRun, deck, input_deck

import mecano
from mecano.errors import DeckError


@pytest.fixture(scope="module")
def carts():
    return [RecordedRun(input_deck("release", f"time.step={h}")) for h in (4e-3, 2e-3)]


def event_of(run, element):
    (event,) = [event for event in run.event_records if event.element == element]
    assert event.name == "activates"
    return event


def test_springs_that_begin_to_act_on_carts(verify, carts):
    """x = 0.4 + sin(10 (t - 0.4))/10, which passes 0.45 m at t_2; then the other one is 0.1 (1 - cos(10 (t - t_2)))."""
    instant = 0.4 + math.asin(0.5) / 10.0
    known = [0.4, instant, 0.4 + 0.1 * math.sin(6.0), 0.1 * (1.0 - math.cos(10.0 * (1.0 - instant)))]
    found = []
    for run in carts:
        events = [event_of(run, f"spring_damper '{name}'") for name in ("catch", "push")]
        places = [run[f"nodes/cart_{i}/position"][-1, 0] for i in (1, 2)]
        found.append(np.array([*(event.t for event in events), *places]))
        assert [event.lost for event in events] == pytest.approx([0.0, -1.0], abs=1e-9)
    what = "springs activated: instants, places of the carts [m]"
    verify.second_order("Release", what, *found, known, 2e-6, "harmonic oscillation")
    np.testing.assert_array_equal(run["elements/push/force"][run.time < instant], 0.0)


STRESS_FREE = {"as given": "false", "stress-free": "true"}
COMPILED = {  # each kind in both ways; the other pairs, of code of their own, are compiled by hand
    ("torsion_spring_damper", "as given"), ("torsion spring by a signal", "stress-free"),
    ("bushing", "stress-free"), ("bushing by a signal", "as given"),
}  # fmt: skip
PAIRS = [
    pytest.param(*pair, marks=[] if pair in COMPILED else pytest.mark.slow) for pair in product(MOUNTS, STRESS_FREE)
]


@pytest.mark.parametrize(("case", "free"), PAIRS)
def test_a_spring_of_any_kind_is_activated(case, free):
    """Uniform motion to c = 0.2 at 0.25 s, then an oscillation about 0.2, or about 0 with the energy k c^2/2 given."""
    kind, properties, joint, output, inertia, stiffness = MOUNTS[case]
    text = LOSS.replace("release: {time: 0.25}", f"activate: {{time: 0.25, stress_free: {STRESS_FREE[free]}}}")
    m = RecordedRun(deck(text.replace("TYPE", kind).replace("PROPERTIES", properties).replace("JOINT", joint)))
    w, after, strain = math.sqrt(stiffness / inertia), m.time - 0.25, 0.2 if free == "as given" else 0.0
    oscillation = 0.2 - strain + strain * np.cos(w * after) + 0.8 / w * np.sin(w * after)
    exact = np.where(after < 0.0, 0.8 * m.time, oscillation)
    np.testing.assert_allclose(m[f"joints/guide/{output}"], exact, atol=2e-6)
    (event,) = m.event_records
    assert (event.t, event.lost) == pytest.approx((0.25, -0.5 * stiffness * strain**2), rel=1e-9, abs=1e-12)
    assert np.ptp(m["energy/balance"]) < 1e-5 * np.ptp(m["energy/kinetic"])


CONTACT = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0.09]}}
    elements:
      ball: {type: rigid_body, node: a, mass: 2, inertia: [0.1, 0.1, 0.1]}
      pad: {type: contact, nodes: [ground, a], plane: {normal: [0, 0, 1], point: [0, 0, 0]}, radius: 0.1, MATERIAL}
    time: {end: 0.4, step: 1.0e-3}
    """


@pytest.mark.parametrize("friction", ["", ", friction: {coefficient: 0.3, regularization: 1.0e-3}"])
def test_a_contact_is_activated(friction):
    """A ball 10 mm within the surface is pushed off with the speed depth sqrt(k/m) by the energy k depth^2/2."""
    material = "activate: {time: 0.1}, law: {polynomial: [0, 800]}" + friction
    run = RecordedRun(deck(CONTACT.replace("MATERIAL", material)))
    activated, opens = run.event_records
    assert (activated.name, activated.after, opens.name) == ("activates", "closed", "opens")
    assert activated.lost == pytest.approx(-0.5 * 800 * 0.01**2, rel=1e-9)
    assert run["nodes/a/velocity"][-1, 2] == pytest.approx(0.01 * 20.0, rel=1e-4)
    assert np.ptp(run["energy/balance"]) < 1e-4 * 0.04


def test_a_spring_that_is_activated_and_released():
    """It acts between both instants: from 0.4 s it stops the cart in a quarter of a period and is released there."""
    release, read = "elements.catch.release={when: time > 0.4 + pi/20}", "signals={force: catch.force}"
    run = RecordedRun(input_deck("release", release, read, "time.step=5e-4"))
    assert [event.name for event in run.event_records if "catch" in event.element] == ["activates", "releases"]
    assert run["nodes/cart_1/position"][-1, 0] == pytest.approx(0.5, abs=1e-5)
    np.testing.assert_allclose(run["signals/force/value"], run["elements/catch/force"], atol=1e-9)
    assert np.ptp(run["energy/balance"]) < 1e-4 * np.ptp(run["energy/kinetic"])


def test_a_cable_is_activated():
    """A load that has fallen for 0.1 s swings about its equilibrium; the energy of the strained cable is given."""
    text = HANGING.replace("MORE", "activate: {time: 0.1}").replace("end: 0.5, step: 0.005", "end: 0.2, step: 5.0e-4")
    run, EA, natural = RecordedRun(deck(text)), 1000.0, 1.0 / 1.02
    (event,) = run.event_records
    strain, w = 1.05 / natural - 1.0, math.sqrt(EA / natural / 2.0)
    assert (event.name, event.after) == ("activates", "taut")
    assert (event.t, event.lost) == pytest.approx((0.1, -0.5 * EA * strain**2 * natural), rel=1e-9)
    after = run.time - 0.1
    exact = np.where(after < 0.0, -1.0 - 5.0 * run.time**2, -1.0 - 0.05 * np.cos(w * after) - np.sin(w * after) / w)
    np.testing.assert_allclose(run["nodes/load/position"][:, 2], exact, atol=5e-6)
    np.testing.assert_array_equal(run["elements/rope/tension"][after < 0.0], 0.0)
    assert np.ptp(run["energy/balance"]) < 1e-4 * -event.lost


RIGID = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      a: {position: [0, 0, 0.6]}
      b: {position: [1, 0, 0.05]}
      c: {position: [2, 0, 0.1]}
      d: {position: [3, 0, 0.1]}
    elements:
      a: {type: rigid_body, node: a, mass: 2, inertia: [0.1, 0.1, 0.1]}
      c: {type: rigid_body, node: c, mass: 2, inertia: [0.1, 0.1, 0.1]}
      d: {type: rigid_body, node: d, mass: 2, inertia: [0.1, 0.1, 0.1]}
      table: {type: contact, nodes: [ground, c], SURFACE, activate: {time: 0}, release: {when: time > 0.5}}
      support: {type: contact, nodes: [ground, d], SURFACE, release: {time: 0.5}}
      b: {type: rigid_body, node: b, mass: 2, inertia: [0.1, 0.1, 0.1]}
      floor: {type: contact, nodes: [ground, a], SURFACE, activate: {time: 0.1}, release: {time: 0.7}}
      lid: {type: contact, nodes: [ground, b], SURFACE, activate: {when: time > 0.01}}
    initial: {velocities: [{nodes: [b], velocity: [0, 0, 2]}]}
    time: {end: 1.0, step: 2.0e-3}
    """
PLANE = "plane: {normal: [0, 0, 1], point: [0, 0, 0]}, radius: 0.1, restitution: 0.5"


def test_a_rigid_contact_is_activated_and_released():
    """One ball bounces, and falls through the plane from 0.7 s on; another one rises through it beforehand.

    Two more rest on it until 0.5 s.
    """
    run, g = RecordedRun(deck(RIGID.replace("SURFACE", PLANE))), 9.81
    floor, lid = ([e for e in run.event_records if e.element == f"contact '{name}'"] for name in ("floor", "lid"))
    fall, up = math.sqrt(1.0 / g), math.sqrt(4.0 - 2.0 * g * 0.05)
    assert [(e.name, e.t) for e in floor] == [
        ("activates", pytest.approx(0.1)), ("closes", pytest.approx(fall, abs=1e-6)),
        ("closes", pytest.approx(2.0 * fall, abs=1e-6)), ("releases", pytest.approx(0.7)),
    ]  # fmt: skip
    assert (floor[1].impulse, floor[1].lost) == pytest.approx((2.0 * 1.5 * g * fall, 0.75 * (g * fall) ** 2), rel=1e-6)
    assert [(e.name, e.t) for e in lid[:3]] == [
        ("waits", pytest.approx(0.01, abs=1e-6)),
        ("activates", pytest.approx((2.0 - up) / g, abs=1e-6)),
        ("closes", pytest.approx((2.0 + up) / g, abs=1e-6)),
    ]  # fmt: skip
    v, after = 0.25 * g * fall, 1.0 - 2.0 * fall
    assert run["nodes/a/position"][-1, 2] == pytest.approx(0.1 + v * after - 0.5 * g * after**2, abs=1e-5)
    for rests in "cd":
        fallen = 0.5 * g * np.maximum(run.time - 0.5, 0.0) ** 2
        np.testing.assert_allclose(run[f"nodes/{rests}/position"][:, 2], 0.1 - fallen, atol=1e-8)
    assert np.ptp(run["energy/balance"]) < 1e-6 * np.ptp(run["energy/kinetic"])


MOMENT = """
    mecano: 1
    gravity: [0, 0, -10]
    nodes: {a: {position: [0, 0, -0.15]}}
    elements:
      ball: {type: rigid_body, node: a, mass: 2, inertia: [0.1, 0.1, 0.1]}
      floor: {type: contact, nodes: [ground, a], plane: {normal: [0, 0, 1], point: [0, 0, 0]}, TRIGGERS}
    initial: {velocities: [{nodes: [a], velocity: [0, 0, 2]}]}
    time: {end: 0.4, step: 1.0e-3}
    """


@pytest.mark.parametrize("friction", ["", ", friction: {coefficient: 0.3, regularization: 1.0e-3}"])
def test_a_rigid_contact_that_overlaps_waits(friction):
    """It is activated for 10 ms only, in which a rising ball is below the plane: from 0.1 s the ball is above it.

    z = -0.15 + 2 t - 5 t^2 is zero at 0.1 s and 0.3 s; there the ball stops, with 2 kg (10 m/s^2 0.3 s - 2 m/s).
    """
    run = RecordedRun(deck(MOMENT.replace("TRIGGERS", "activate: {when: 0.005 > abs(time - 0.02)}" + friction)))
    waits, activates, closes = run.event_records
    assert [(e.name, e.before, e.after) for e in (waits, activates)] == [
        ("waits", "inactive", "overlapping"), ("activates", "overlapping", "open")
    ]  # fmt: skip
    assert (waits.t, activates.t, closes.t) == pytest.approx((0.015, 0.1, 0.3), abs=1e-6)
    assert (closes.name, closes.impulse) == ("closes", pytest.approx(2.0, rel=1e-5))
    assert run["elements/floor/normal_force"][-1] == pytest.approx(20.0, rel=1e-9)
    assert run["nodes/a/position"][-1, 2] == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize(
    ("triggers", "names"),
    [
        ("activate: {time: 0}", ["activates", "closes"]),  # it waits from the start, which is no event
        ("activate: {time: 0.2}", ["activates", "closes"]),  # above the plane
        ("activate: {time: 0.05}, release: {time: 0.08}", ["waits", "releases"]),
        ("activate: {time: 0.05}, release: {time: 0.2}", ["waits", "activates", "releases"]),
        ("activate: {time: 0.35}", ["waits"]),  # falling
    ],
)
def test_when_a_rigid_contact_acts(triggers, names):
    run = RecordedRun(deck(MOMENT.replace("TRIGGERS", triggers)))
    assert [event.name for event in run.event_records] == names
    falls = "closes" not in names
    exact = -0.15 + 2 * run.time - 5 * run.time**2
    np.testing.assert_allclose(
        run["nodes/a/position"][:, 2], exact if falls else np.where(run.time > 0.3, 0, exact), atol=1e-5
    )


@pytest.mark.parametrize(
    ("material", "message"),
    [
        ("activate: {}, law: {polynomial: [0, 800]}", "'activate' needs either 'time' or 'when'"),
    ],
)
def test_wrong_activations(material, message):
    with pytest.raises(DeckError, match=message):
        deck(CONTACT.replace("MATERIAL", material))


def test_a_contact_that_waits_until_the_end_is_reported(tmp_path):
    """The ball falls below the plane at 0.3 s, before the contact is due."""
    (tmp_path / "deck.yaml").write_text(MOMENT.replace("TRIGGERS", "activate: {time: 0.35}"))
    results = mecano.run(tmp_path / "deck.yaml", tmp_path / "deck.h5", quiet=True)
    assert "activated without effect, as the bodies overlapped until the end: contact 'floor'" in results.reason


def test_conditions_that_did_not_become_true_are_reported(tmp_path):
    """Those of a release and an activation, but not that of a fuse, nor one that was met."""
    (tmp_path / "deck.yaml").write_text(
        textwrap.dedent("""
        mecano: 1
        gravity: [0, 0, -10]
        nodes: {a: {position: [1, 0, 0]}, b: {position: [2, 0, 0]}}
        elements:
          a: {type: point_mass, node: a, mass: 1}
          b: {type: point_mass, node: b, mass: 1}
          late: {type: spring_damper, nodes: [a, b], law: {spring: 1}, activate: {when: guide.displacement > 5}}
          met: {type: spring_damper, nodes: [a, b], law: {spring: 1}, activate: {when: time > 0.05}}
        joints:
          guide: {type: prismatic, nodes: [ground, a], axis: [0, 0, 1], release: {when: guide.displacement > 1}}
          fuse: {type: fixed, nodes: [ground, b], release: {when: "abs(fuse.force.z) > 1e3"}}
        time: {end: 0.1, step: 0.01}
        """)
    )
    results = mecano.run(tmp_path / "deck.yaml", tmp_path / "deck.h5", quiet=True)
    wanted = "conditions that did not become true: "
    wanted += "spring_damper 'late', 'activate: {when: guide.displacement > 5}'; "
    wanted += "prismatic 'guide', 'release: {when: guide.displacement > 1}'"
    assert wanted in results.reason
    assert "fuse" not in results.reason and "'met'" not in results.reason

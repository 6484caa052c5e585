"""Statics with constraints on velocities: rigid wheels, skates, adhesive tyres, against closed forms."""

import numpy as np
import pytest
import yaml
from equilibria import Path
from time_runs import INPUTS, deck

from mecano.analyses.equilibria import equilibrium, loaded
from mecano.analyses.modal import modes
from mecano.analyses.prepare import integrator_of, prepare
from mecano.analyses.static import StaticSample
from mecano.errors import DeckError
from mecano.model.sampler import Sampler

DOWN, INTO = 1.7, 9.66  # m/s2: gravity along the slope and into it
MASS, RADIUS, STIFFNESS = 10.0, 0.5, 100.0


def wheel(process, held, height=RADIUS, options="axle: level"):
    """A disc of 10 kg on a slope, x down it, ``held`` by an element."""
    wall = f", wall: {{position: [-1, 0, {height}], fixed: true}}" if "wall" in held else ""
    return f"""
        mecano: 1
        gravity: [{DOWN}, 0, -{INTO}]
        nodes: {{hub: {{position: [0, 0, {height}]}}{wall}}}
        elements:
          disc: {{type: rigid_body, node: hub, mass: {MASS}, inertia: [1, 2, 1]}}
          wheel: {{type: rigid_wheel, node: hub, radius: {RADIUS}, axis: [0, 1, 0], ground: slope, {options}}}
          holder: {held}
        grounds: {{slope: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
        {process}
        """


SPRING = f"{{type: spring_damper, nodes: [wall, hub], law: {{spring: {{stiffness: {STIFFNESS}}}}}}}"
BRAKE = (
    "{type: torsion_spring_damper, nodes: [ground, hub], axis: [0, 1, 0], "
    f"law: {{spring: {{stiffness: {STIFFNESS}}}}}}}"
)
METHODS = ("{}", "{steps: 3}", "{method: relaxation}", "{method: arc_length, steps: 4}")


def reactions(path, name):
    """Normal, longitudinal and lateral force of a rigid wheel at the last point [N]."""
    system, s, sampler = path.system, path.points[-1].state, Sampler(path.system)
    row, places = sampler.take(StaticSample(s), system.observe(s)), {c.path: c.start for c in sampler.columns}
    return row[
        [places[f"elements/{name}/{force}"] for force in ("normal_force", "longitudinal_force", "lateral_force")]
    ]


@pytest.mark.parametrize("method", METHODS)
def test_wheel_held_by_a_spring_at_its_hub(method):
    """The spring bears the weight along the slope, and the wheel that is free to spin transmits nothing."""
    path = Path(wheel(f"static: {method}", SPRING))
    assert path.positions("hub")[-1, 0] == pytest.approx(MASS * DOWN / STIFFNESS, rel=1e-9)
    assert path.turns_about_y("hub")[-1] == pytest.approx(MASS * DOWN / STIFFNESS / RADIUS, rel=1e-9)
    np.testing.assert_allclose(reactions(path, "wheel"), (MASS * INTO, 0.0, 0.0), atol=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_wheel_held_by_a_brake(method):
    """Adhesion bears the weight along the slope: its moment about the axle winds up the brake, r m g' = k phi."""
    path = Path(wheel(f"static: {method}", BRAKE))
    turn = RADIUS * MASS * DOWN / STIFFNESS
    assert path.turns_about_y("hub")[-1] == pytest.approx(turn, rel=1e-9)
    assert path.positions("hub")[-1, 0] == pytest.approx(RADIUS * turn, rel=1e-9)
    np.testing.assert_allclose(reactions(path, "wheel"), (MASS * INTO, -MASS * DOWN, 0.0), atol=1e-6)


@pytest.mark.parametrize("start", ["static", "{static: {method: steps}}"])
def test_run_of_a_braked_wheel_starts_at_rest(start):
    prepared = prepare(deck(wheel(f"initial: {start}\n        time: {{end: 0.1, step: 0.01}}", BRAKE)))
    equilibrium(prepared)
    run = integrator_of(prepared).begin(prepared.state, 0.01)
    assert np.abs(run.motion.a).max() < 1e-11 * INTO
    np.testing.assert_allclose(run.motion.z[prepared.system.n_q :][:1], MASS * INTO, rtol=1e-9)


def test_modes_about_a_wheel_at_rest():
    """On the spring at its hub it rolls to and fro with k/(m + I/r^2).

    Free are the heading, and two constants that only rolling ties to it: the place across, the angle of the spin.
    """
    _, found, _ = modes(deck(wheel("static: {}", SPRING)), None)
    rolling = np.sqrt(STIFFNESS / (MASS + 2.0 / RADIUS**2))
    assert np.abs(found.values.imag).max() == pytest.approx(rolling, rel=1e-9)
    assert found.kinds == ["free", "free", "free", "oscillation"]


@pytest.mark.parametrize("method", ["relaxation", "steps"])
def test_wheel_that_begins_above_the_ground(method):
    """One that may leave the ground comes down, and its ground bears the weight."""
    text = wheel(f"static: {{method: {method}}}", BRAKE, 0.6, "unilateral: true").replace(f"[{DOWN}, 0,", "[0, 0,")
    upright = "joints: {upright: {type: planar, nodes: [ground, hub], axis: [0, 1, 0]}}\n        grounds:"
    text = text.replace("grounds:", upright)
    path = Path(text)
    assert path.positions("hub")[-1, 2] == pytest.approx(RADIUS, abs=1e-12)
    assert [h.name for point in path.points for h in point.event_records] == ["touch_down"]
    np.testing.assert_allclose(reactions(path, "wheel"), (MASS * INTO, 0.0, 0.0), atol=1e-6)


def test_wheel_that_may_not_leave_the_ground_begins_on_it():
    with pytest.raises(DeckError, match="unilateral: true") as caught:
        prepare(deck(wheel("initial: static\n        time: {end: 1, step: 0.1}", BRAKE, 0.6)))
    assert "0.1 m above the ground" in str(caught.value)


def car(process, locked, gravity=f"[{DOWN}, 0, -{INTO}]"):
    """A body of 1000 kg on two rigid wheels of 20 kg, 1.6 m ahead of its centre of mass and 0.9 m behind."""
    return f"""
        mecano: 1
        gravity: {gravity}
        nodes:
          body: {{position: [0, 0, 0.6]}}
          front_axle: {{position: [1.6, 0, 0.3]}}
          rear_axle: {{position: [-0.9, 0, 0.3]}}
          front: {{position: [1.6, 0, 0.3]}}
          rear: {{position: [-0.9, 0, 0.3]}}
        elements:
          car: {{type: rigid_body, node: body, mass: 1000, inertia: [200, 900, 900], attached: [front_axle, rear_axle]}}
          front_rim: {{type: rigid_body, node: front, mass: 20, inertia: [0.5, 1, 0.5]}}
          rear_rim: {{type: rigid_body, node: rear, mass: 20, inertia: [0.5, 1, 0.5]}}
          front_wheel: {{type: rigid_wheel, node: front, radius: 0.3, axis: [0, 1, 0], ground: road}}
          rear_wheel: {{type: rigid_wheel, node: rear, radius: 0.3, axis: [0, 1, 0], ground: road, axle: level}}
          brake: {{type: torsion_spring_damper, nodes: [{locked}_axle, {locked}], axis: [0, 1, 0],
                  law: {{spring: {{stiffness: 1.0e5}}}}}}
        joints:
          front_bearing: {{type: hinge, nodes: [front_axle, front], axis: [0, 1, 0]}}
          rear_bearing: {{type: hinge, nodes: [rear_axle, rear], axis: [0, 1, 0]}}
        grounds: {{road: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
        {process}
        """


@pytest.mark.parametrize("locked", ["front", "rear"])
def test_load_distribution_of_a_car_parked_on_a_slope(locked):
    """Moments about the contacts: the slope presses the front down by the height of the masses over the wheelbase."""
    path = Path(car("static: {}", locked))
    along, height = 1040.0 * DOWN, (1000.0 * 0.6 + 40.0 * 0.3) / 1040.0
    front = INTO * (1000.0 * 0.9 / 2.5 + 20.0) + along * height / 2.5
    ends = {"front": (front, 0.0, 0.0), "rear": (1040.0 * INTO - front, 0.0, 0.0)}
    ends[locked] = (ends[locked][0], -along, 0.0)
    for name, expected in ends.items():
        np.testing.assert_allclose(reactions(path, f"{name}_wheel"), expected, atol=1e-5)
    wind_up = 0.3 * along / 1.0e5
    assert path.positions("body")[-1, 0] == pytest.approx(0.3 * wind_up, rel=1e-6)


def test_side_slope_is_borne_by_lateral_forces():
    """Across the slope, too, the car stands: each wheel bears the share of its axle."""
    path = Path(car("static: {}", "rear", f"[0, {DOWN}, -{INTO}]"))
    front = DOWN * (1000.0 * 0.9 / 2.5 + 20.0)
    assert reactions(path, "front_wheel")[2] == pytest.approx(-front, rel=1e-7)
    assert reactions(path, "rear_wheel")[2] == pytest.approx(front - 1040.0 * DOWN, rel=1e-7)


def test_wheel_on_a_trailing_arm():
    """The ground bears what the moments about the pivot ask for; across, the hinges hold already, and bear all."""
    path = Path(f"""
        mecano: 1
        gravity: [0, 0, -{INTO}]
        nodes: {{pivot: {{position: [-1, 0, 0.5]}}, axle: {{position: [0, 0, 0.3]}}, hub: {{position: [0, 0, 0.3]}}}}
        elements:
          arm: {{type: rigid_body, node: pivot, mass: 4, center_of_mass: [0.5, 0, -0.1], inertia: [1, 1, 1],
                attached: [axle]}}
          rim: {{type: rigid_body, node: hub, mass: {MASS}, inertia: [1, 2, 1]}}
          wheel: {{type: rigid_wheel, node: hub, radius: 0.3, axis: [0, 1, 0], ground: road}}
        joints:
          bearing: {{type: hinge, nodes: [axle, hub], axis: [0, 1, 0]}}
          foot: {{type: hinge, nodes: [ground, pivot], axis: [0, 1, 0]}}
        loads:
          down: {{type: force, node: axle, direction: [0, 0, -1], value: 60}}
          across: {{type: force, node: axle, direction: [0, 1, 0], value: 20}}
        grounds: {{road: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
        static: {{}}
        """)
    assert len(path.prepared.compliance.released) == 1
    normal, along, across = reactions(path, "wheel")
    assert normal == pytest.approx(60.0 + INTO * (MASS + 4 * 0.5), rel=1e-9)
    assert (along, across) == (pytest.approx(0.0, abs=1e-7), pytest.approx(0.0, abs=1e-7))


def skate(steps):
    """A skate turned by 1.2 rad while its place along x goes as on a circle of 2 m, in equal steps of the time."""
    return f"""
        mecano: 1
        gravity: [0, 0, 0]
        nodes: {{blade: {{position: [0, 0, 0]}}}}
        elements:
          body: {{type: rigid_body, node: blade, mass: 1, inertia: [1, 1, 1]}}
          edge: {{type: skate, node: blade, axis: [0, 1, 0], ground: ice}}
        joints:
          flat: {{type: planar, nodes: [ground, blade], axis: [0, 0, 1]}}
          along: {{type: prescribed_position, node: blade, direction: [1, 0, 0],
                  value: {{sine: {{amplitude: 2, frequency: {0.5 / np.pi!r}, offset: 0, phase: 0}}}}}}
          heading: {{type: prescribed_angle, nodes: [ground, blade], axis: [0, 0, 1], value: {{linear: {{slope: 1}}}}}}
        grounds: {{ice: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
        static: {{over: time, end: 1.2, steps: {steps}}}
        """


def test_skate_follows_its_edge():
    """y = 2 (1 - cos t) beside x = 2 sin t; the displacement along a path is of first order in its steps."""
    errors = [Path(skate(n)).positions("blade")[-1, 1] - 2.0 * (1.0 - np.cos(1.2)) for n in (40, 80, 160)]
    assert np.abs(errors[2]) < 0.02
    np.testing.assert_allclose(np.divide(errors[:2], errors[1:]), 2.0, atol=0.1)


def test_tangent_with_constraints_on_velocities():
    """Derivative of the residual in a step that rolls and turns, against central differences."""
    prepared = prepare(deck(car("static: {}", "rear")))
    statics, system = loaded(prepared, prepared.deck.values["static"]), prepared.system
    rng, n_q = np.random.default_rng(5), system.n_q
    start = prepared.state
    start.z[n_q : system.n] = rng.normal(size=system.n_l)
    step = statics.step(statics.begin(start), start.phases)

    def residual(z, tangent=False):
        s = statics.begin(start)
        statics.move(s, start, z, 1.0)
        statics.evaluate(s, 0.7, 1.0, 3.0, tangent, step)
        return statics.assembly.residual[: system.n].copy()

    at, h = 0.1 * rng.normal(size=system.n), 1e-6
    differences = np.array([(residual(at + h * e) - residual(at - h * e)) / (2.0 * h) for e in np.eye(system.n)]).T
    residual(at, True)
    tangent = np.zeros((system.n, system.n))
    tangent[system.rows, system.cols] = statics.assembly.data[: system.nnz]
    np.testing.assert_allclose(tangent, differences, atol=1e-5 * np.abs(tangent).max())
    assert np.abs(tangent[n_q:][system.numbering.of_rates]).max(axis=1).min() > 0.1


@pytest.mark.parametrize(("method", "orders", "z"), [("relaxation", 3, -0.27413042), ("steps", 8, 0.9)])
def test_an_equilibrium_does_not_depend_on_the_order_of_the_deck(method, orders, z):
    """A bicycle that falls over through its road, or stays upright: free to roll, which rounding must not decide."""
    given, found = yaml.safe_load((INPUTS / "bicycle.yaml").read_text()), []
    given["initial"] = {"static": {"method": method}}
    for seed in range(orders):
        rng, text = np.random.default_rng(seed), dict(given)
        for section in ("nodes", "elements", "joints"):
            items = list(given[section].items())
            text[section] = dict(items[i] for i in rng.permutation(len(items)))
        prepared = prepare(deck(yaml.safe_dump(text, sort_keys=False)))
        equilibrium(prepared)
        place = prepared.system.numbering.x[[node.name for node in prepared.system.nodes].index("frame")]
        found.append(prepared.state.z[place : place + 3])
    np.testing.assert_allclose(found, np.broadcast_to(found[0], (orders, 3)), atol=1e-7)
    assert found[0][2] == pytest.approx(z, abs=1e-8)

"""Steady running from a start in which wheels are in the air or just touch: lowered onto them, or the wheels named."""

import textwrap

import numpy as np
import pytest
from test_motorcycle import BODIES, DECK, WHEELBASE
from time_runs import deck, input_deck

from mecano.analyses.initial_state import set_initial_state
from mecano.analyses.prepare import prepare
from mecano.deck.read import read_deck
from mecano.errors import ConvergenceError
from mecano.maths.root import root

CART = """
    mecano: 1
    gravity: [0, 0, -10]
    parameters: {level: 0, pitch: 0, lift: 0 N m, drag: 0 N, rise: sin($pitch)}
    nodes:
      body: {position: [0, 0, 0.4 + $rise]}
      front_axle: {position: [cos($pitch), 0, 0.4 + 2*$rise]}
      rear_axle: {position: [-cos($pitch), 0, 0.4]}
      front: {position: [cos($pitch), 0, 0.4 + 2*$rise]}
      rear: {position: [-cos($pitch), 0, 0.4]}
    elements:
      body: {type: rigid_body, node: body, mass: 100, inertia: [10, 40, 40], attached: [front_axle, rear_axle]}
      front: {type: rigid_body, node: front, mass: 5, inertia: [0.2, 0.4, 0.2]}
      rear: {type: rigid_body, node: rear, mass: 5, inertia: [0.2, 0.4, 0.2]}
      front_tyre: {type: wheel, node: front, axis: [0, 1, 0], tire_law: rubber, ground: road}
      rear_tyre: {type: wheel, node: rear, axis: [0, 1, 0], tire_law: rubber, ground: road}
    joints:
      upright: {type: planar, nodes: [ground, body], axis: [0, 1, 0]}
      front_bearing: {type: hinge, nodes: [front_axle, front], axis: [0, 1, 0]}
      rear_bearing: {type: hinge, nodes: [rear_axle, rear], axis: [0, 1, 0]}
    loads:
      lift:
        type: moment
        node: body
        direction: [0, -1, 0]
        value: $lift - 1000*(front.position.z - rear.position.z)
      drag: {type: force, node: body, direction: [-1, 0, 0], value: $drag}
    tire_laws: {rubber: {radius: 0.4, radial: {linear: {slope: 1.0e6}}, friction: 0.8, slip_regularization: 0.1}}
    grounds: {road: {plane: {point: [0, 0, $level], normal: [0, 0, 1]}}}
    initial: {steady: {velocity: [10, 0, 0]}}
    time: {end: 1, step: 0.01}
"""


def steady(text, **parameters):
    """Return (Prepared in steady running, warnings) with other ``parameters`` that are zero in the text."""
    for name, value in parameters.items():
        text = text.replace(f"{name}: 0", f"{name}: {value}", 1)
    prepared = prepare(deck(text))
    return prepared, set_initial_state(prepared)


def loads(prepared):
    """Return {wheel: normal force [N]}."""
    system, found = prepared.system, {}
    outputs = system.observe(prepared.state).outputs
    for batch in system.batches:
        names = [output.name for output in batch.kind.outputs]
        if "normal_force" in names:
            values = batch.outputs(outputs)[:, names.index("normal_force")]
            found |= {path: float(value) for (path, _), value in zip(batch.paths, values, strict=True)}
    return found


@pytest.mark.parametrize("height", [0.02, 1e-3, 0.0])
def test_a_motorcycle_above_its_road_stands_on_both_wheels(height):
    """Not on the rear one. The loads are those of the weights on a level beam; the wheels sink by 1.4e-4 m."""
    text = DECK.replace("SPEED", "32.5").replace("1.0e8", "1.0e7").replace("RELAXATION", "0.2438")
    prepared, warnings = steady(text.replace("point: [0, 0, 0]", f"point: [0, 0, {-height}]"))
    masses, centres = np.array([b[0] for b in BODIES]), np.array([b[1][0] for b in BODIES])
    front = 9.81 * float(masses @ centres) / WHEELBASE
    found = loads(prepared)
    assert found["elements/front_tyre"] == pytest.approx(front, rel=1e-3)
    assert found["elements/rear_tyre"] == pytest.approx(9.81 * masses.sum() - front, rel=1e-3)
    assert warnings == ()


def tilted(roll, pitch, height, speed):
    """Return overrides that turn road, gravity and velocity under a vehicle, and put the road ``height`` [m] lower."""
    normal = np.array([-np.sin(pitch) * np.cos(roll), np.sin(roll), np.cos(pitch) * np.cos(roll)])
    ahead = np.cross([0.0, 1.0, 0.0], normal)
    vectors = -9.81 * normal, normal, -height * normal, speed * ahead / np.linalg.norm(ahead)
    gravity, normal, point, velocity = (list(map(float, vector)) for vector in vectors)
    road = f"grounds.road.plane={{normal: {normal}, point: {point}}}"
    return f"gravity={gravity}", road, f"initial={{steady: {{velocity: {velocity}}}}}"


def read(folder, text, overrides):
    """Return the Prepared of a deck with overrides."""
    path = folder / "deck.yaml"
    path.write_text(textwrap.dedent(text), encoding="utf-8")
    return prepare(read_deck(path, overrides))


@pytest.mark.parametrize(("roll", "pitch", "height"), [(3.0, 0.0, 0.0), (-2.0, -6.0, 0.1)])
def test_a_motorcycle_that_leans_and_pitches_is_levelled(roll, pitch, height):
    """Onto both wheels, upright."""
    prepared = prepare(input_deck("motorcycle", *tilted(np.radians(roll), np.radians(pitch), height, 20.0)))
    assert set_initial_state(prepared) == ()
    found, masses = loads(prepared), sum(b[0] for b in BODIES)
    assert sum(found.values()) == pytest.approx(9.81 * masses, rel=1e-6)
    assert found["elements/front_tyre"] == pytest.approx(992.0, abs=1.0)  # as from a level start, above


CAR = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {body: {position: [0, 0, 0.5]}}
    elements: {body: {type: rigid_body, node: body, mass: 800, inertia: [200, 900, 900], attached: [MOUNTS]}}
    templates:
      corner:
        nodes: {mount: {position: [0, 0, 0.2]}, axle: {position: [0, 0, 0]}, hub: {position: [0, 0, 0]}}
        elements:
          upright: {type: rigid_body, node: axle, mass: 15, inertia: [0.3, 0.3, 0.3]}
          rim: {type: rigid_body, node: hub, mass: 15, inertia: [0.5, 0.9, 0.5]}
          tyre: {type: wheel, node: hub, axis: [0, 1, 0], tire_law: rubber, ground: road}
        joints:
          guide:
            {type: prismatic, nodes: [mount, axle], axis: [0, 0, 1], sliding_law: {spring: 25 kN/m, preload: -2 kN}}
          bearing: {type: hinge, nodes: [axle, hub], axis: [0, 1, 0]}
    place:
      front_left: {template: corner, position: [1.2, 0.7, 0.3]}
      front_right: {template: corner, position: [1.2, -0.7, 0.3]}
      rear_left: {template: corner, position: [-1.4, 0.7, 0.3]}
      rear_right: {template: corner, position: [-1.4, -0.7, 0.3]}
    tire_laws: {rubber: {radius: 0.31, radial: {linear: {slope: 2.0e5}}, friction: 0.9, slip_regularization: 0.1}}
    grounds: {road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
    initial: {steady: {velocity: [20, 0, 0]}}
    time: {end: 1, step: 0.01}
""".replace("MOUNTS", ", ".join(f"{end}_{side}_mount" for end in ("front", "rear") for side in ("left", "right")))


@pytest.mark.parametrize(("roll", "pitch", "height"), [(3.0, 0.0, 0.0), (3.0, 3.0, 0.1)])
def test_a_car_that_rolls_and_pitches_is_levelled(roll, pitch, height, tmp_path):
    """Onto four wheels, which bear the weight by the lengths of a level beam."""
    prepared = read(tmp_path, CAR, tilted(np.radians(roll), np.radians(pitch), height, 20.0))
    assert set_initial_state(prepared) == ()
    for end, arm in (("front", 1.4), ("rear", 1.2)):
        for side in ("left", "right"):
            bears = 9.81 * (30.0 + 400.0 * arm / 2.6)
            assert loads(prepared)[f"elements/{end}_{side}_tyre"] == pytest.approx(bears, rel=2e-3)


AIRCRAFT = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {body: {position: [0.6, 0, 2.6]}}
    elements: {body: {type: rigid_body, node: body, mass: 12000, inertia: [5.0e4, 1.5e5, 1.8e5], attached: [TOPS]}}
    templates:
      gear:
        parameters: {force: 0 N}
        nodes:
          top: {position: [-0.1, 0, 1.5]}
          knee: {position: [0.4, 0, 0.4]}
          pivot: {position: [0.4, 0, 0.4]}
          lug: {position: [0, 0, 0.3]}
          axle: {position: [-0.1, 0, 0]}
          hub: {position: [-0.1, 0, 0]}
        elements:
          arm: {type: rigid_body, node: pivot, mass: 60, inertia: [3, 6, 6], attached: [lug, axle]}
          rim: {type: rigid_body, node: hub, mass: 60, inertia: [2, 4, 2]}
          strut: {type: spring_damper, nodes: [top, lug],
                  law: {gas_spring: {force: $force, length: 0.45 m, exponent: 1.3},
                        stop: {stiffness: 20 kN/mm, lower: -400 mm, upper: -1 mm}}}
          wheel: {type: wheel, node: hub, axis: [0, 1, 0], tire_law: tyre, ground: road}
        joints:
          pivot: {type: hinge, nodes: [knee, pivot], axis: [0, 1, 0]}
          bearing: {type: hinge, nodes: [axle, hub], axis: [0, 1, 0]}
    place:
      left: {template: gear, position: [0, 2.5, 0.45], with: {force: 15 kN}}
      right: {template: gear, position: [0, -2.5, 0.45], with: {force: 15 kN}}
      nose: {template: gear, position: [5.5, 0, 0.45], with: {force: 4 kN}}
    tire_laws: {tyre: {radius: 0.45, radial: {linear: {slope: 9.0e5}}, friction: 0.7, slip_regularization: 0.1}}
    grounds: {road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
    initial: {steady: {velocity: [50, 0, 0]}}
    time: {end: 1, step: 1 ms}
""".replace("TOPS", ", ".join(f"{gear}_{node}" for gear in ("left", "right", "nose") for node in ("top", "knee")))


@pytest.mark.parametrize(("roll", "pitch", "height"), [(0.0, 0.0, 0.05), (2.0, 2.0, 0.4)])
def test_an_aircraft_on_extended_struts_above_the_runway(roll, pitch, height, tmp_path):
    """Levered gears, with oleos preloaded against their stops, through which the weight pushes them at once.

    Their pivots leave the way between to no equilibrium. Loads balance the weights in the places where they come to be.
    """
    prepared = read(tmp_path, AIRCRAFT, tilted(np.radians(roll), np.radians(pitch), height, 50.0))
    set_initial_state(prepared)
    of, names, found = prepared.system.numbering, [node.name for node in prepared.system.nodes], loads(prepared)
    gravity = np.array(prepared.system.context.gravity)
    along = np.cross([0.0, 1.0, 0.0], -gravity / 9.81)
    along /= np.linalg.norm(along)

    def place(name):
        return along @ prepared.state.z[of.x[names.index(name)] + np.arange(3)]

    gears = "left", "right", "nose"
    weights = [(12000.0, "body"), *((60.0, f"{gear}_{node}") for gear in gears for node in ("pivot", "hub"))]
    assert sum(found.values()) == pytest.approx(9.81 * sum(mass for mass, _ in weights), rel=1e-9)
    moment = sum(9.81 * mass * place(name) for mass, name in weights)
    assert sum(found[f"elements/{gear}_wheel"] * place(f"{gear}_hub") for gear in gears) == pytest.approx(
        moment, rel=1e-6
    )
    assert found["elements/left_wheel"] == pytest.approx(found["elements/right_wheel"], rel=1e-6)
    assert found["elements/nose_wheel"] > 1e4


def pitch_on_one_wheel(lift):
    """Return the pitch [rad] of the cart in the air in front, at which the moments about its rear axle balance."""
    return root(lambda a: 1000.0 * np.cos(a) + 50.0 * 2.0 * np.cos(a) - lift + 2000.0 * np.sin(a), 0.0, 1.0)


@pytest.mark.parametrize("level", [-0.05, 0.0, 2e-3])
def test_a_wheel_that_a_moment_lifts_off_is_named(level):
    """The cart stands steadily on its rear wheel, which sinks by 1.1 mm."""
    with pytest.raises(ConvergenceError) as error:
        steady(CART, lift=1500, level=level)
    said = str(error.value)
    assert "steady motion was found only with wheels in the air" in said and "rear_tyre" not in said
    height = float(said.partition("wheel 'front_tyre', ")[2].partition(" mm above its ground")[0])
    assert height == pytest.approx(2e3 * np.sin(pitch_on_one_wheel(1500.0)) - 1.1, abs=0.51)


def test_a_wheel_that_starts_in_the_air_may_stay_there():
    """With a warning, from a start with the pitch of one wheel on the ground."""
    pitch = pitch_on_one_wheel(1500.0)
    prepared, (warning,) = steady(CART, lift=1500, pitch=pitch)
    assert warning.startswith("wheel 'front_tyre' is in the air in the steady motion at the start")
    assert loads(prepared)["elements/rear_tyre"] == pytest.approx(1100.0, rel=1e-6)
    assert steady(CART, lift=500)[1] == ()


def test_a_failure_names_the_wheels_without_load_at_the_start():
    """No drive balances the drag, so that there is no steady running at this speed."""
    for level, named in ((-0.05, True), (0.0, False), (0.01, False)):
        with pytest.raises(ConvergenceError, match="no straight steady running") as error:
            steady(CART, drag=100, level=level)
        for name in ("front_tyre", "rear_tyre"):
            assert (f"wheel '{name}' carries no load at the start: lower it by 50 mm" in str(error.value)) == named


@pytest.mark.parametrize("stiffness", [2700.0, 2800.0])
@pytest.mark.parametrize("start", ["{steady: {velocity: [10, 0, 0]}}", "static"])
def test_a_tyre_that_sinks_by_more_than_half_of_its_radius_is_refused(stiffness, start):
    """Each wheel carries (50 + 5) 10 N, which deforms its tyre by 0.2 m, half of its radius, at 2750 N/m."""
    text = CART.replace("initial: {steady: {velocity: [10, 0, 0]}}", f"initial: {start}")
    text = text.replace("slope: 1.0e6", f"slope: {stiffness}")
    if stiffness > 2750.0:
        assert loads(steady(text)[0])["elements/front_tyre"] == pytest.approx(550.0, rel=1e-6)
        return
    with pytest.raises(ConvergenceError, match="only with tyres deformed beyond their range") as error:
        steady(text)
    assert f"wheel 'front_tyre' carries 550 N with its rim {550.0 / stiffness:.4g} m below" in str(error.value)


def test_equations_that_cannot_be_solved_are_a_failure_of_the_search(monkeypatch):
    """LAPACK's singular values may not converge for singular equations."""

    lstsq = np.linalg.lstsq

    def failing(a, b, rcond=None):
        if a.shape[0] == a.shape[1]:
            return lstsq(a, b, rcond)
        raise np.linalg.LinAlgError("SVD did not converge in Linear Least Squares")

    monkeypatch.setattr(np.linalg, "lstsq", failing)
    with pytest.raises(ConvergenceError, match="no straight steady running"):
        steady(CART)

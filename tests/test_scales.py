"""k and penalty only scale the linear system: motion and reactions do not depend on them."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.equilibria import loaded
from mecano.analyses.prepare import integrator_of, prepare
from mecano.model.numbering import LENGTH_CONSTRAINT, MASSLESS, ROTATION, SCALAR, TRANSLATION, Unknowns
from mecano.model.state import Motion
from mecano.solve.diagnostics.scales import TINY, Limits, Scales, norms
from mecano.solve.statics.continuation import Follower

TIGHT = ("time.newton.constraint_tolerance=1e-12",)  # forces are met to 1e-7
DECKS = {"double_pendulum": 0.5, "slider_crank": 0.05, "four_bar": 0.5, "wheel_drop": 0.3}
SCALES = [
    "k: 1.0",
    "k: 1.0e+4",
    "k: 1.0e+7",
    "penalty: 0",
    "penalty: 1.0",
    "penalty: 1.0e+6",
    "k: 30.0, penalty: 2000.0",
]


@pytest.fixture(scope="module", params=DECKS)
def plain(request):
    """Return (name of a deck, its end, the run with automatic k and penalty)."""
    name, end = request.param, DECKS[request.param]
    return name, end, RecordedRun(input_deck(name, f"time.end={end}", "time.adaptive=null", *TIGHT))


@pytest.mark.parametrize("scale", SCALES)
def test_motion_and_reactions_do_not_depend_on_them(plain, scale):
    name, end, wanted = plain
    recorded = RecordedRun(input_deck(name, f"time.end={end}", f"time.scale={{{scale}}}", "time.adaptive=null", *TIGHT))
    given = dict(part.split(": ") for part in scale.split(", "))
    if "k" in given:
        assert recorded.integrator.method.k == float(given["k"])
    if "penalty" in given:
        assert recorded.integrator.method.penalty == float(given["penalty"])
    assert len(recorded.time) == len(wanted.time) > 50
    np.testing.assert_allclose(recorded.time, wanted.time, rtol=0, atol=1e-9)
    sizes = {}
    for c in wanted.columns.values():
        sizes[c.unit] = max(sizes.get(c.unit, TINY), np.abs(wanted[c.path]).max())
    redundant = bool(wanted.prepared.analysis.redundant)
    for path, c in wanted.columns.items():
        if redundant and c.unit in ("N", "N m"):
            continue  # not unique
        close = 1e-6 if c.unit in ("N", "N m", "W", "J") else 1e-9
        np.testing.assert_allclose(recorded[path], wanted[path], rtol=0, atol=close * sizes[c.unit], err_msg=path)


@pytest.mark.parametrize("kind", [TRANSLATION, SCALAR, MASSLESS])
@pytest.mark.parametrize(
    ("share", "stiffness", "allowed"), [(1.0, 1e15, 1e-3), (1e-3, 1e15, 1e-3), (1e-3, 1e9, 3.52e-4), (1e-3, 1.0, 1e-6)]
)
def test_no_share_of_a_tolerance_is_less_than_rounding(kind, share, stiffness, allowed):
    """1e-7 of 1e4 N is 1e-3 N; rounding of 100 m, 3.52e-13 m, is 3.52e-4 N with 1e9 N/m."""
    residual, size, none = np.array([0.0, allowed]), np.array([1e4, 1e4]), np.zeros(2)
    kinds = np.array([TRANSLATION, kind], np.int64)
    of, still = Unknowns(kinds, np.zeros(0, np.int64), 2, 2), Motion(none, none, none, np.zeros((0, 3, 3)))
    scales, limits = Scales(1.0, 1.0, stiffness, 1.0, 0.0), Limits(1e-7, 1e-10, share, 1.0, 100.0)
    over = norms(residual, size, of, still, scales, limits)
    assert over[0] == pytest.approx(1.0, rel=1e-12)


def test_the_size_of_the_mechanism_is_rounded_where_no_position_is_free():
    """Arms of 2 m are rounded to 16 x 2.2e-16 x 2 m = 7.04e-15 m, also those of bodies that turn about fixed points."""
    residual, size, none = np.array([0.0, 7.04e-15 * 1e9]), np.zeros(2), np.zeros(2)
    kinds = np.array([TRANSLATION, LENGTH_CONSTRAINT], np.int64)
    of, still = Unknowns(kinds, np.zeros(0, np.int64), 1, 2), Motion(none, none, none, np.zeros((0, 3, 3)))
    scales, limits = Scales(2.0, 1e9, 1e9, 1.0, 0.0), Limits(1e-7, 1e-10, 1.0, np.inf, 1.0)
    over = norms(residual, size, of, still, scales, limits)
    assert over[0] == pytest.approx(1.0, rel=1e-12)


def test_a_gear_lands_far_from_the_origin_as_at_it():
    """Positions at 1e5 m are known to 1.5e-11 m: in a step the speed of the wheel to that over step and radius."""
    nodes, runs, step = input_deck("nose_gear_rigid").values["nodes"], [], 1e-5
    at = {name: node["position"] for name, node in nodes.items()}
    for distance in (0.0, 1e5):
        places = [f"nodes.{name}.position={[distance + x, y, z]}" for name, (x, y, z) in at.items()]
        times = f"time.step={step}", f"time.end={1000 * step}", "time.adaptive=null"
        runs.append(RecordedRun(input_deck("nose_gear_rigid", *places, *times)))
    at_origin, away = (run["elements/wheel/spin_rate"] for run in runs)
    np.testing.assert_allclose(away, at_origin, rtol=0, atol=4.0 * 1.5e-11 / (0.3225 * step))


@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_the_unit_of_length_does_not_change_the_steps(size):
    """With lengths times ``size``, and masses and times as they are, moments are times size^2 and forces times size."""
    as_it_is, sized = (RecordedRun(deck(ELLIPSOIDS.replace("SIZE", str(s)))) for s in (1.0, size))
    assert [len(sized.time), len(sized.event_records)] == [len(as_it_is.time), len(as_it_is.event_records)]
    iterations = [sum(info.iterations for info in run.infos) for run in (as_it_is, sized)]
    assert iterations[1] == pytest.approx(iterations[0], rel=0.01)
    for path in ("nodes/rolling/position", "nodes/falling/position"):
        np.testing.assert_allclose(sized[path] / size, as_it_is[path], rtol=0, atol=1e-9)


BARS = range(8)
CHAIN = """
    mecano: 1
    parameters: {{s: {size}}}
    gravity: [0, 0, {gravity}*$s]
    nodes:
{nodes}
    elements:
{elements}
    joints:
{joints}
    {process}
"""
PLACES = "\n".join(
    f"      b{i}: {{position: [{i}*$s, 0, 0]}}\n      e{i}: {{position: [{i + 1}*$s, 0, 0]}}" for i in BARS
)
BODIES = "\n".join(
    f"      b{i}: {{type: rigid_body, node: b{i}, mass: 1, inertia: [$s**2/9, $s**2/9, $s**2/9], attached: [e{i}]}}"
    for i in BARS
)
HINGES = "\n".join(
    f"      h{i}: {{type: hinge, nodes: [{f'e{i - 1}' if i else 'ground'}, b{i}], axis: [0, 1, 0]}}" for i in BARS
)
COILS = "\n".join(
    f"      c{i}: {{type: torsion_spring_damper, nodes: [{f'b{i - 1}' if i else 'ground'}, b{i}], axis: [0, 1, 0], "
    "law: {spring: 100*$s**2}}"
    for i in BARS
)


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("size", [1e-6, 1e3, 1e6])
def test_the_unit_of_length_does_not_change_initial_accelerations(size, closed):
    """Of bars that hang between hinges, to rounding: masses and inertias are compared at the length scale."""
    last = "\n      last: {type: hinge, nodes: [ground, e7], axis: [0, 1, 0]}" if closed else ""
    found = []
    for s in (1.0, size):
        text = CHAIN.format(size=s, gravity=-9.81, nodes=PLACES, elements=BODIES, joints=HINGES + last, process=RUN)
        prepared = prepare(deck(text))
        a = integrator_of(prepared).begin(prepared.state, 1e-3).motion.a[: prepared.system.n_q]
        turning = prepared.system.numbering.kind[: prepared.system.n_q] == ROTATION
        found.append(np.where(turning, a, a / s))
    np.testing.assert_allclose(found[1], found[0], rtol=0, atol=1e-13 * np.abs(found[0]).max())


RUN = "time: {end: 1, step: 0.001}"


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize(("load", "unstable"), [(1.0, 0), (4.0, 1), (40.0, 2)])
def test_the_unit_of_length_does_not_change_the_stability(size, load, unstable):
    """Of a column of bars on springs, by the pivots of the sparse tangent and by the eigenvalues of the dense one."""
    push = f"loads: {{push: {{type: force, node: e7, direction: [-1, 0, 0], value: {load}*$s}}}}\n    static: {{}}"
    parts = {"nodes": PLACES, "elements": f"{BODIES}\n{COILS}", "joints": HINGES}
    prepared = prepare(deck(CHAIN.format(size=size, gravity=0, process=push, **parts)))
    follower = Follower(loaded(prepared, prepared.deck.values["static"]))
    s, _ = follower.find(follower.statics.begin(prepared.state), 1.0)
    dense = follower.stability(s, 1.0)
    follower.stability_test.dense = False
    sparse = follower.stability(s, 1.0)
    assert (sparse.unstable, sparse.neutral) == (dense.unstable, dense.neutral) == (unstable, 0)
    if unstable:
        assert sparse.stiffness == pytest.approx(dense.stiffness, rel=1e-3)


# two solid ellipsoids on a plane, as in inputs/ellipsoids.yaml
ELLIPSOIDS = """
    mecano: 1
    parameters: {size: SIZE, a: 0.06*$size, b: 0.04*$size, c: 0.03*$size, height: 0.038995*$size}
    gravity: [0, 0, -9.81*$size]
    nodes:
      rolling: {position: [0, 0, $height], orientation: [0, 0.5, 0]}
      falling: {position: [0, 0.8*$size, $height + 0.1*$size], orientation: [0, 0.5, 0]}
    elements:
      $body:
        repeat: [{body: rolling}, {body: falling}]
        type: rigid_body
        node: $body
        mass: 1
        inertia: [($b**2 + $c**2)/5, ($a**2 + $c**2)/5, ($a**2 + $b**2)/5]
      on_rolling:
        type: contact
        nodes: [ground, rolling]
        plane: &floor {normal: [0, 0, 1], point: [0, 0, 0]}
        ellipsoid: &shape {semi_axes: [$a, $b, $c]}
        friction: {coefficient: 0.9, regularization: 1.0e-4*$size}
      on_falling: {type: contact, nodes: [ground, falling], plane: *floor, ellipsoid: *shape, restitution: 0.5}
    time: {end: 0.2, step: 1.0e-3}
"""


def test_wheels_share_the_weight_far_from_the_origin():
    """Three rigid wheels would carry the vehicle; the shares of four are those at the origin to 2e-3.

    Positions at 1 km are known to 1.1e-13 m, of which the compliances are 1000 times as much under the weight.
    """
    x, y, z = 1e3, -700.0, 300.0
    nodes = input_deck("mecanum").values["nodes"]
    at = {name: node["position"] for name, node in nodes.items()}
    places = [f"nodes.{name}.position={[x + p[0], y + p[1], z + p[2]]}" for name, p in at.items()]
    here = RecordedRun(input_deck("mecanum"))
    there = RecordedRun(input_deck("mecanum", *places, f"grounds.floor.plane.point={[x, y, z]}"))
    for wheel in ("front_left", "front_right", "rear_left", "rear_right"):
        path = f"elements/{wheel}_wheel/normal_force"
        np.testing.assert_allclose(there[path], here[path], rtol=2e-3)

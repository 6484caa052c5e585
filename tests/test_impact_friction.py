"""Friction in the impacts of rigid contacts: closed forms, balances, Coulomb's law."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.prepare import integrator_of, prepare
from mecano.solve.events.complementarity import solve_complementarity
from mecano.solve.events.impact_friction import solve_with_friction, within_disc
from mecano.solve.time.consistent import Consistent

S = "Contact"
BALL = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0.11]}}
    elements:
      ball: {type: rigid_body, node: a, mass: 2, inertia: [8.0e-3, 8.0e-3, 8.0e-3]}
      floor:
        {type: contact, nodes: [ground, a], plane: {normal: [0, 0, 1], point: [0, 0, 0]}, radius: 0.1,
         restitution: RESTITUTION, friction: {coefficient: MU, regularization: 1.0e-3}}
    initial: {velocities: [{nodes: [a], velocity: [VX, VY, -2], angular_velocity: [0, SPIN, 0], about: own}]}
    time: {end: 0.02, step: 1.0e-3}
"""


@pytest.mark.parametrize(
    ("e", "mu", "vx", "vy", "spin", "what"),
    [
        (1.0, 0.2, 3, 0, 0, "slides"),
        (1.0, 0.8, 3, 0, 0, "rolls"),
        (0.5, 0.1, 3, 4, 0, "slides askew"),
        (0.5, 0.9, 3, 4, 20, "rolls askew"),
        (0.5, 0.3, 0, 0, 50, "spins"),
    ],
)
def test_a_ball_on_the_floor(verify, e, mu, vx, vy, spin, what):
    """The impulse -u/(1/m + r^2/J) stops the sliding u, unless the friction mu (1 + e) m v_n is too small for it."""
    text = BALL.replace("RESTITUTION", str(e)).replace("MU", str(mu)).replace("SPIN", str(spin))
    run = RecordedRun(deck(text.replace("VX", str(vx)).replace("VY", str(vy))))
    u = np.array([vx - 0.1 * spin, vy])
    P, bound = -u / (1 / 2 + 0.1**2 / 8e-3), mu * (1 + e) * 2 * 2
    P *= min(1.0, bound / np.linalg.norm(P))
    velocity, turning = [vx + P[0] / 2, vy + P[1] / 2, 2 * e], [0.1 * P[1] / 8e-3, spin - 0.1 * P[0] / 8e-3, 0]
    source = "Coulomb's law for the impulse"
    found = run["nodes/a/velocity"][-1], run["nodes/a/angular_velocity"][-1]
    case = f"rigid impact with friction, a ball that {what}: velocity [m/s]"
    verify(S, case, found[0], velocity, source, absolute=1e-12)
    np.testing.assert_allclose(found[1], turning, atol=1e-11)
    lost = 0.5 * 2 * (np.array([vx, vy, -2]) @ [vx, vy, -2] - np.dot(velocity, velocity))
    lost += 0.5 * 8e-3 * (spin**2 - np.dot(turning, turning))
    (event,) = run.event_records
    assert (event.impulse, event.lost) == (pytest.approx((1 + e) * 4), pytest.approx(lost))


def test_a_block_rocks(verify):
    """At each impact it turns about the other edge, with 1 - 3/2 sin^2 a of its speed, tan a = b/h (Housner 1963)."""
    b, h = 0.2, 1.0
    run = RecordedRun(input_deck("rocking_block", "time.end=1.5", "output.every=null"))
    about_edge = 10 * 4 / 3 * (b * b + h * h)
    hits = [event for event in run.event_records if event.name == "closes" and event.t > 0.0]
    assert len(hits) == 3
    for number, hit in enumerate(hits):
        before = run["nodes/body/angular_velocity"][np.searchsorted(run.time, hit.t), 1]
        ratio = math.sqrt(1.0 - 2.0 * hit.lost / (about_edge * before**2))
        what = f"rocking block, impact {number + 1}: angular velocity after over before"
        source = "Housner, Bull. Seismol. Soc. Am. 53 (1963)"
        verify(S, what, ratio, 1 - 1.5 * b * b / (b * b + h * h), source, relative=2e-5)
    assert np.ptp(run["energy/balance"]) < 1e-4 * sum(hit.lost for hit in hits)


ROD = """
    mecano: 1
    gravity: none
    nodes:
      rod: {position: [0, 0, HEIGHT]}
      tip: {position: [AHEAD, 0, 0.01]}
    elements:
      rod: {type: rigid_body, node: rod, attached: [tip], mass: 1, inertia: [0.4, THIRD, 0.4]}
      floor:
        {type: contact, nodes: [ground, tip], plane: {normal: [0, 0, 1], point: [0, 0, 0]}, restitution: 1,
         friction: {coefficient: 0.6, regularization: 1.0e-4}}
    initial: {velocities: [{nodes: all, velocity: [1, 0, -1], angular_velocity: [0, 6, 0], about: [0, 0, HEIGHT]}]}
    time: {end: 3.0e-3, step: 1.0e-4}
"""


@pytest.mark.parametrize("e", [0.0, 0.5])
def test_the_loss_of_an_impact_includes_the_friction_of_contacts_at_rest(e):
    """A ball with backspin hits a wall, whose friction presses it to the floor: (1 + mu^2) P = m (1 + e) v."""
    mu, m, J, r = 0.4, 2.0, 8e-3, 0.1
    rough = f"radius: {r}, friction: {{coefficient: {mu}, regularization: 0.1 mm/s}}"
    run = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {{a: {{position: [0, 0, {r}]}}}}
        elements:
          ball: {{type: rigid_body, node: a, mass: {m}, inertia: [{J}, {J}, {J}]}}
          floor: {{type: contact, nodes: [ground, a], plane: {{normal: [0, 0, 1], point: [0, 0, 0]}}, {rough}}}
          wall:
            {{type: contact, nodes: [ground, a], plane: {{normal: [-1, 0, 0], point: [0.11, 0, 0]}}, {rough},
             restitution: {e}}}
        initial: {{velocities: [{{nodes: [a], velocity: [2, 0, 0], angular_velocity: [0, -60, 0], about: own}}]}}
        time: {{end: 0.006, step: 1 ms}}
    """)
    )
    hit = next(event for event in run.event_records if event.element == "contact 'wall'")
    v, spin = 2.0 - mu * 9.81 * hit.t, 60.0 - mu * m * 9.81 * r / J * hit.t
    P = (1 + e) * m * v / (1 + mu**2)
    after = spin - r * (mu + mu**2) * P / J
    assert hit.impulse == pytest.approx(P, rel=1e-6)
    assert hit.lost == pytest.approx(0.5 * m * (1 - e**2) * v**2 + 0.5 * J * (spin**2 - after**2), rel=1e-6)


def test_a_rod_does_not_gain_energy_by_friction():
    """With e = 1 it would gain 3.09 J (Kane 1984): it rebounds with the energy that it had."""
    text = ROD.replace("HEIGHT", repr(0.01 + math.sin(0.7))).replace("AHEAD", repr(math.cos(0.7)))
    run = RecordedRun(deck(text.replace("THIRD", repr(1 / 3))))
    hit = run.event_records[0]
    assert hit.name == "closes" and hit.lost == pytest.approx(0.0, abs=1e-9)
    kinetic = run["energy/kinetic"]
    np.testing.assert_allclose(kinetic, 7.0, rtol=1e-6)
    v = run["nodes/rod/velocity"]
    along, normal = abs(v[-1, 0] - 1.0), v[-1, 2] + 1.0
    assert along <= 0.6 * normal * (1 + 1e-9) and hit.impulse == pytest.approx(normal)


COLLISION = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}, b: {position: [0.21, 0.03, -0.02]}}
    elements:
      a: {type: rigid_body, node: a, mass: 2, inertia: [8.0e-3, 8.0e-3, 8.0e-3]}
      b: {type: rigid_body, node: b, mass: 3, inertia: [1.2e-2, 1.3e-2, 1.4e-2]}
      touch:
        {type: contact, nodes: [a, b], sphere: {radius: 0.1}, radius: 0.1, restitution: 0.7,
         friction: {coefficient: 0.15, regularization: 1.0e-4}}
    initial:
      velocities:
        - {nodes: [a], velocity: [3, 0.2, 0], angular_velocity: [4, -9, 30], about: own}
        - {nodes: [b], velocity: [-1, 0, 0.5], angular_velocity: [0, 7, 12], about: own}
    time: {end: 0.01, step: 1.0e-4}
"""


def test_balls_that_throw_one_another_keep_momentum_and_angular_momentum():
    run = RecordedRun(deck(COLLISION))
    (event,) = run.event_records
    J = {"a": np.full(3, 8e-3), "b": np.array([1.2e-2, 1.3e-2, 1.4e-2])}
    momentum, moment, energy = np.zeros((len(run.time), 3)), np.zeros((len(run.time), 3)), 0.0
    for node, mass in (("a", 2.0), ("b", 3.0)):
        x, v, w, q = (run[f"nodes/{node}/{of}"] for of in ("position", "velocity", "angular_velocity", "rotation"))
        turned = Rotation.from_quat(np.roll(q, -1, axis=1))
        spin = turned.apply(J[node] * turned.inv().apply(w))
        momentum, moment = momentum + mass * v, moment + mass * np.cross(x, v) + spin
        energy += 0.5 * (mass * (v * v).sum(1) + (w * spin).sum(1))
    np.testing.assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), atol=1e-12)
    np.testing.assert_allclose(moment, np.broadcast_to(moment[0], moment.shape), atol=1e-7)  # of the steps' spins
    assert event.lost == pytest.approx(energy[0] - energy[-1], rel=1e-6)
    assert run["nodes/a/velocity"][-1, 2] != pytest.approx(0.0, abs=0.01)  # thrown off the plane of the centres


def test_a_bouncing_ball_rolls_from_its_first_impact():
    """The friction of the impact could stop a sliding of 7/2 mu (1 + e) v_n = 2.6 m/s, more than 0.7 m/s."""
    text = BALL.replace("gravity: none", "gravity: [0, 0, -9.81]").replace("[0, 0, 0.11]", "[0, 0, 0.15]")
    text = text.replace("MU", "0.5").replace("RESTITUTION", "0.5").replace("end: 0.02", "end: 1.2")
    run = RecordedRun(deck(text.replace("[VX, VY, -2]", "[0.7, 0, 0]").replace("SPIN", "0")))
    v, falls = run["nodes/a/velocity"][:, 0], run.time <= math.sqrt(0.1 / 9.81)
    np.testing.assert_allclose(v[falls], 0.7, atol=1e-9)
    np.testing.assert_allclose(v[~falls][2:], 0.5, atol=1e-9)
    assert run["elements/floor/closed"][-1] == 1.0


def box(rng, n):
    """Return W, rates before the impact (3 n,) and coefficients of a random body that hits a plane at n corners."""
    J = rng.uniform(0.4, 0.8, 3)
    inverse = np.diag([1.0, 1.0, 1.0, *(1.0 / J)])
    R = Rotation.random(rng=rng).as_matrix()
    inverse[3:, 3:] = R @ inverse[3:, 3:] @ R.T
    corners = rng.uniform(-1.0, 1.0, (n, 3)) * [1, 1, 0] - [0, 0, 0.7]
    axes = np.eye(3)
    along = [axes[2]] * n + [axes[i] for _ in range(n) for i in (0, 1)]
    at = [*corners, *np.repeat(corners, 2, axis=0)]
    gradients = np.array([[*d, *np.cross(r, d)] for d, r in zip(along, at, strict=True)])
    v = rng.normal(size=6) * [1, 1, 0, 1, 1, 1] - [0, 0, 1.5, 0, 0, 0]
    contacts = [SimpleNamespace(contact=i, mu=rng.uniform(0.0, 1.0)) for i in range(n)]
    return gradients @ inverse @ gradients.T, gradients @ v, contacts


@pytest.mark.parametrize("n", [1, 2, 4])
def test_impulses_obey_coulombs_law(n):
    """Contacts push or separate, and stick or slide against the impulse; plastic impacts lose energy."""
    rng = np.random.default_rng(n)
    for _ in range(15):
        W, rates, contacts = box(rng, n)

        def normal(b, W=W):
            return solve_complementarity(W[:n, :n], b)

        x, y = solve_with_friction(normal, W[:n, n:], W[n:, n:], rates[:n], rates[n:], contacts)
        after = W @ np.concatenate([x, y]) + rates
        size = x.max()
        assert x.min() >= 0.0 and after[:n].min() >= -1e-9 and np.abs(x * after[:n]).max() < 1e-9
        for contact, P, u in zip(contacts, y.reshape(-1, 2), after[n:].reshape(-1, 2), strict=True):
            bound = contact.mu * x[contact.contact]
            assert np.linalg.norm(P) <= bound + 1e-9 * size
            unstuck = P * np.linalg.norm(u) + u * min(np.linalg.norm(P), bound)
            assert np.linalg.norm(u) <= 1e-8 or np.linalg.norm(unstuck) <= 1e-8 * size
        assert np.concatenate([x, y]) @ (rates + after) < 1e-9


def test_contacts_that_repeat_one_another_up_to_rounding_need_few_sweeps():
    """Two contacts of one mass stick; without impulses they would slide at velocities that differ by 1e-9."""
    called = []

    def normal(b):
        called.append(b)
        return np.full(2, 10.0)

    u, contacts = np.array([1.0, 0.5, 1.0 + 1e-9, 0.5]), [SimpleNamespace(contact=i, mu=1.0) for i in range(2)]
    W = np.tile(np.eye(2), (2, 2))
    pushes, along = solve_with_friction(normal, np.zeros((2, 4)), W, np.zeros(2), u, contacts)
    np.testing.assert_allclose(W @ along + u, 0.0, atol=2e-9)
    assert len(called) < 20


def test_a_ball_begins_to_slide_down_a_slope():
    """It touches the slope, along which it moves up to rounding, and is slowed by mu m g cos a.

    x = v t + (g sin a - mu g cos a) t^2/2 along the slope, a parabola, which steps integrate without error.
    """
    mu, v, a, g, end = 0.13544662461964327, 3.8942930205229787, 0.8290324670139506, 9.81, 0.02
    run = RecordedRun(deck(f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {{ball: {{position: [0.07372780612563244, 0.0, 0.06755894170205122]}}}}
        elements:
          b: {{type: rigid_body, node: ball, mass: 1.7219403105680948, inertia: [0.004, 0.004, 0.004]}}
          c:
            {{type: contact, nodes: [ground, ball], radius: 0.1, friction: {{coefficient: {mu}, regularization: 1e-3}},
             plane: {{normal: [0.7372780612563243, 0.0, 0.6755894170205122], point: [0, 0, 0]}}}}
        initial: {{velocities: [{{nodes: [ball], velocity: [2.630943151442169, 0.0, -2.871176808135217]}}]}}
        time: {{end: {end}, step: 0.001}}
        """))  # fmt: skip
    moved = np.linalg.norm(np.ptp(run["nodes/ball/position"][[0, -1]], axis=0))
    assert moved == pytest.approx(v * end + 0.5 * g * (math.sin(a) - mu * math.cos(a)) * end**2, rel=1e-8)


def test_a_box_in_flight_needs_no_iterations_on_friction(monkeypatch):
    """Its reactions are rounding, beside its weight: one correction of Newton at the start is enough."""
    corrections = []
    solve = Consistent._couple_signals
    monkeypatch.setattr(Consistent, "_couple_signals", lambda *given: corrections.append(given) or solve(*given))
    RecordedRun(deck("""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {box: {position: [0, 0, 1], orientation: [0.3, 0.5, 0.2]}, corner: {position: [0.1, 0.05, 0.9]}}
        elements:
          box: {type: rigid_body, node: box, mass: 0.5, inertia: [1.0e-3, 1.0e-3, 1.0e-3], attached: [corner]}
          floor: {type: contact, nodes: [ground, corner], plane: {normal: [0, 0, 1], point: [0, 0, 0]},
                  friction: {coefficient: 0.5, regularization: 1.0e-3}}
        initial: {velocities: [{nodes: all, velocity: [1, 0, 0], angular_velocity: [3, 8, 2], about: [0, 0, 1]}]}
        time: {end: 2.0e-3, step: 1.0e-3}
        """))  # fmt: skip
    assert len(corrections) == 1


def test_the_nearest_impulse_within_a_disc():
    """Inside, where the minimum is; on the edge otherwise, with a gradient along the radius; also in tiny discs."""
    rng = np.random.default_rng(5)
    for size in 50 * [1.0] + 50 * [1e-17]:
        root, c, radius = rng.normal(size=(2, 2)), rng.normal(size=2), size * rng.uniform(0.01, 2.0)
        A = root @ root.T
        x = within_disc(*np.linalg.eigh(A), c, radius)
        gradient = A @ x + c
        assert np.linalg.norm(x) <= radius * (1 + 1e-12)
        if np.linalg.norm(x) < radius * (1 - 1e-9):
            np.testing.assert_allclose(gradient, 0.0, atol=1e-9)
        else:
            np.testing.assert_allclose(gradient, -np.linalg.norm(gradient) * x / radius, atol=1e-8)


@pytest.mark.parametrize(("of", "along"), [(1e-16, 1e-17), (-1e-17, -2e-17), (0.0, 1e-16)])
def test_rounding_has_no_impulse_where_none_moves_a_contact(of, along):
    """A body in planar motion, in axes turned by 0.3 rad: across the plane it neither moves nor yields."""
    Q = np.array([[math.cos(0.3), -math.sin(0.3)], [math.sin(0.3), math.cos(0.3)]])
    x = within_disc(np.array([of, 1.0]), Q, Q @ [along, 0.5], 1.0)
    np.testing.assert_allclose(Q.T @ x, [0.0, -0.5], atol=1e-12)


def test_a_disc_of_no_size_has_no_impulse():
    """Its radius is the friction of an impulse that has vanished: numbers do not overflow."""
    with np.errstate(all="raise"):
        assert not within_disc(np.array([1.0, 2.0]), np.eye(2), np.array([3.0, 4.0]), 1e-310).any()


STACK = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {low: {position: [0, 0, 0.1]}, high: {position: [0, 0, 0.3]}}
    elements:
      low: {type: rigid_body, node: low, mass: 2, inertia: [8.0e-3, 8.0e-3, 8.0e-3]}
      high: {type: rigid_body, node: high, mass: 2, inertia: [8.0e-3, 8.0e-3, 8.0e-3]}
      floor: {type: contact, nodes: [ground, low], plane: {normal: [0, 0, 1], point: [0, 0, 0]}, radius: 0.1}
      stack: {type: contact, nodes: [low, high], sphere: {radius: 0.1}, radius: 0.1}
      wall: {type: contact, nodes: [ground, low], plane: {normal: [1, 0, 0], point: [-0.1, 0, 0]}, radius: 0.1}
    time: {end: 1, step: 1.0e-3}
"""


@pytest.mark.parametrize(("towards_wall", "upward"), [(1e-18, 1e-22), (1e-9, 1e-13)])
def test_a_stack_does_not_part_when_it_leans_on_a_wall(towards_wall, upward):
    """Velocities that are rounding, or below the speed of rest, do not lift what 20 and 39 N press together."""
    prepared = prepare(deck(STACK))
    integrator, s = integrator_of(prepared), prepared.state
    s.memory = integrator.system.commit(s)
    floor, stack, wall = integrator.shocks.impact_candidates
    s = integrator.shocks.impact_candidates.in_phase(s, [floor, stack], "after")
    s, _ = integrator.method.start(s, 1e-3)
    x = integrator.system.numbering.x[[node.name for node in integrator.system.nodes].index("low")]
    s.v[x : x + 3] = -towards_wall, 0.0, upward
    hit = np.zeros(integrator.system.n_events, bool)
    hit[wall.event] = True
    shock = integrator.shocks.solve_impact(s, hit, h=1e-3)
    assert [(record.element, record.name) for record in shock.event_records] == [("contact 'wall'", "closes")]
    s, _ = integrator.method.start(shock.state, 1e-3, shock.consistent)
    forces = s.z[integrator.system.n_q + np.array([floor.lead, stack.lead, wall.lead])]
    assert forces == pytest.approx([4 * 9.81, 2 * 9.81, 0.0], rel=1e-12, abs=1e-12)


WALLS = {  # normals and points
    "floor": ("[0, 0, 1]", "[0, 0, 0]"),
    "left": ("[1, 0, 0]", "[-0.06, 0, 0]"),
    "right": ("[-1, 0, 0]", "[0.18, 0, 0]"),
    "front": ("[0, 1, 0]", "[0, -0.06, 0]"),
    "rear": ("[0, -1, 0]", "[0, 0.06, 0]"),
}
ROUGH = "radius: 0.05, restitution: 0.3, friction: {coefficient: 0.3, regularization: 1.0e-3}"


def box_of_balls():
    """Balls of 0.5 kg that fall into a box little wider than two of them, side by side and on one another."""
    rng, nodes, elements = np.random.default_rng(1), [], []
    for i in range(4):
        place = [0.105 * (i % 2) + 0.01 * rng.random(), 0.008 * (rng.random() - 0.5), 0.06 + 0.12 * (i // 2)]
        nodes += [f"  b{i}: {{position: {place}}}"]
        elements += [f"  b{i}: {{type: rigid_body, node: b{i}, mass: 0.5, inertia: [5.0e-4, 5.0e-4, 5.0e-4]}}"]
        elements += [
            f"  {name}{i}: {{type: contact, nodes: [ground, b{i}], plane: {{normal: {n}, point: {x}}}, {ROUGH}}}"
            for name, (n, x) in WALLS.items()
        ]
        elements += [
            f"  pair{j}{i}: {{type: contact, nodes: [b{j}, b{i}], sphere: {{radius: 0.05}}, {ROUGH}}}" for j in range(i)
        ]
    head, steps = ["mecano: 1", "gravity: [0, 0, -9.81]"], "{end: 0.6, step: 1 ms, adaptive: {tolerance: 1.0e-3}}"
    lines = [*head, "nodes:", *nodes, "elements:", *elements, f"time: {steps}", "output: {every: 10 ms}"]
    return deck("\n".join(lines))


@pytest.mark.slow  # 7 s
def test_balls_settle_in_a_box():
    """Contacts touch, press and part by rounding, dozens at a time: their energy falls, and they hardly overlap."""
    run = RecordedRun(box_of_balls())
    energy = run["energy/kinetic"] + run["energy/potential"]
    assert np.diff(energy).max() < 1e-6 < 0.3 < energy[0] - energy[-1]
    assert min(run[f"elements/{name}{i}/gap"].min() for i in range(4) for name in WALLS) > -1e-7


ROLLING_OVER = """
mecano: 1
gravity: [0, 0, -9.81]
nodes: {{low: {{position: [0, 0, 0.2]}}, high: {{position: [0.001, 0, 0.45]}}}}
elements:
  a: {{type: rigid_body, node: low, mass: 1.5, inertia: [0.004, 0.004, 0.004]}}
  b: {{type: rigid_body, node: high, mass: 1.4, inertia: [0.004, 0.004, 0.004]}}
  floor: {{type: contact, nodes: [ground, low], plane: {{normal: [0, 0, 1], point: [0, 0, 0]}}, {rough}}}
  pair: {{type: contact, nodes: [low, high], sphere: {{radius: 0.1}}, {rough}}}
initial: {{velocities: [{{nodes: all, velocity: [1.5, 0, 0]}}]}}
time: {{end: 0.2, step: 1 ms, adaptive: {{tolerance: 1.0e-4}}, rho_inf: 0}}
"""


@pytest.mark.parametrize("e", [0.12, 0.15, 0.2])
def test_a_long_step_leads_through_no_surface_and_back(e):
    """Balls bounce on one another in ever shorter hops: steps of 15 ms pass through the side of the lower one."""
    rough = f"radius: 0.1, restitution: {e}, friction: {{coefficient: 1, regularization: 1 mm/s}}"
    run = RecordedRun(deck(ROLLING_OVER.format(rough=rough)))
    assert run["elements/pair/gap"].min() > -1e-10 and run["elements/floor/gap"].min() > -1e-10
    assert len(run.event_records) > 10


def test_a_contact_that_opens_for_a_moment_closes_again():
    """Three balls tumble; the lower two part by less than 1e-9 m for 1 ms: rounding shows an impact at once."""
    rough = "radius: 0.1, restitution: 0.136, friction: {coefficient: 0.5, regularization: 1 mm/s}"
    masses, places = (1.3177, 1.3752, 1.8502), (0.0, -0.0223, -0.0472)
    nodes = [f"  b{i}: {{position: [{x}, 0, {0.2 + 0.25 * i}]}}" for i, x in enumerate(places)]
    parts = [
        f"  b{i}: {{type: rigid_body, node: b{i}, mass: {m}, inertia: [4e-3, 4e-3, 4e-3]}}"
        for i, m in enumerate(masses)
    ]
    floor = "plane: {normal: [0, 0, 1], point: [0, 0, 0]}"
    parts += [f"  floor{i}: {{type: contact, nodes: [ground, b{i}], {floor}, {rough}}}" for i in range(3)]
    pairs = [(0, 1), (0, 2), (1, 2)]
    parts += [
        f"  pair{i}{j}: {{type: contact, nodes: [b{i}, b{j}], sphere: {{radius: 0.1}}, {rough}}}" for i, j in pairs
    ]
    head, steps = ["mecano: 1", "gravity: [0, 0, -9.81]"], "{end: 0.5, step: 1 ms, rho_inf: 0.9}"
    run = RecordedRun(deck("\n".join([*head, "nodes:", *nodes, "elements:", *parts, f"time: {steps}"])))
    energy = run["energy/kinetic"] + run["energy/potential"]
    assert (energy - np.minimum.accumulate(energy)).max() < 1e-5 * energy[0]
    assert min(run[f"elements/pair{i}{j}/gap"].min() for i, j in pairs) > -1e-8


BELT = """
    mecano: 1
    gravity: [-3, 0, -9.3]
    nodes: {belt: {position: [0, 0, 0]}, puck: {position: [0, 0, 0]}}
    elements:
      body: {type: rigid_body, node: puck, mass: 2, inertia: [0.1, 0.1, 0.1]}
      bed: {type: contact, nodes: [belt, puck], plane: {normal: [0, 0, 1], point: [0, 0, 0]}, friction: FRICTION}
      stop: {type: contact, nodes: [ground, puck], plane: {normal: [-1, 0, 0], point: [0.5, 0, 0]}}
    joints:
      upright: {type: held_rotation, nodes: [ground, puck]}
      guide: {type: prismatic, nodes: [ground, belt], axis: [1, 0, 0]}
      drive: {type: prescribed_position, node: belt, direction: [1, 0, 0], value: time}
    time: {end: 1, step: 1.0e-3, rho_inf: 0}
"""


GROOVE = """
mecano: 1
gravity: [0, 0, -9.81]
nodes: {{ball: {{position: [0, 0, 0.5]}}}}
elements:
  ball: {{type: rigid_body, node: ball, mass: 2, inertia: [0.01, 0.01, 0.01]}}
  left: {{type: contact, nodes: [ground, ball], plane: {{normal: [{c}, 0, {s}], point: [0, 0, 0]}}, {rough}}}
  right: {{type: contact, nodes: [ground, ball], plane: {{normal: [-{c}, 0, {s}], point: [0, 0, 0]}}, {rough}}}
time: {{end: 0.21, step: 1 ms}}
"""


@pytest.mark.parametrize("mu", [0.2, 0.33, 0.37, 1.5])
def test_a_ball_jams_in_a_groove_narrower_than_its_friction_cone(mu):
    """Two walls at 20 degrees: each pushes with m (1 + e) v/2/(sin a - mu cos a), or for e = 0 if that is negative."""
    a = np.radians(20.0)
    rough = f"radius: 0.1, restitution: 0.5, friction: {{coefficient: {mu}, regularization: 1 mm/s}}"
    run = RecordedRun(deck(GROOVE.format(c=np.cos(a), s=np.sin(a), rough=rough)))
    speed, rebounds = 9.81 * run.event_records[0].t, mu < np.tan(a)
    pushes = 1.5 / (np.sin(a) - mu * np.cos(a)) if rebounds else 1.0 / np.sin(a)
    assert [event.impulse for event in run.event_records] == pytest.approx([speed * pushes] * 2, rel=1e-6)
    assert sum(event.lost for event in run.event_records) == pytest.approx((0.75 if rebounds else 1.0) * speed**2)
    expected = 0.5 * speed - 9.81 * (0.21 - run.event_records[0].t) if rebounds else 0.0
    assert run["nodes/ball/velocity"][-1, 2] == pytest.approx(expected, abs=1e-9)


def test_impacts_that_run_to_and_fro_between_balls_end():
    """Three balls wedged between walls: impacts pass along the chain at one instant; no impact creates energy."""
    rough, places = "restitution: 0.3, friction: {coefficient: 1.5, regularization: 1 mm/s}", [0.052, 0.075, 0.052]
    walls = {"floor": ("[0, 0, 1]", 0.0), "left": ("[1, 0, 0]", 0.0), "right": ("[-1, 0, 0]", 0.168)}
    lines = ["mecano: 1", "gravity: [0, 0, -9.81]", "nodes:"]
    lines += [f"  b{i}: {{position: [{x}, 0, {0.06 + 0.11 * i}]}}" for i, x in enumerate(places)]
    lines += ["elements:"]
    for i in range(3):
        lines += [f"  b{i}: {{type: rigid_body, node: b{i}, mass: 0.5, inertia: [5.0e-4, 5.0e-4, 5.0e-4]}}"]
        surfaces = {
            f"{name}{i}": ("ground", f"plane: {{normal: {n}, point: [{x}, 0, 0]}}") for name, (n, x) in walls.items()
        }
        surfaces |= {f"pair{j}{i}": (f"b{j}", "sphere: {radius: 0.05}") for j in range(i)}
        lines += [
            f"  {name}: {{type: contact, nodes: [{on}, b{i}], {surface}, radius: 0.05, {rough}}}"
            for name, (on, surface) in surfaces.items()
        ]
    run = RecordedRun(deck("\n".join([*lines, "time: {end: 0.22, step: 1 ms, adaptive: {tolerance: 1.0e-3}}"])))
    energy = run["energy/kinetic"] + run["energy/potential"]
    assert (energy - np.minimum.accumulate(energy)).max() < 1e-4 * energy[0]


def test_a_rod_that_painleves_paradox_stops(verify):
    """Friction of 2 would press the tip of a rod, which slides at 1 rad, into the floor: no force has an acceleration.

    The tip stops at once. The angular momentum about it stays, m v h = (I + m l^2) omega with h = l sin 1.
    """
    mass, inertia, half, angle, v = 1.0, 1 / 12, 0.5, 1.0, 3.0
    height = half * math.sin(angle)
    run = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes:
          rod: {{position: [0, 0, {height}], orientation: [0, {-angle}, 0]}}
          tip: {{position: [{-half * math.cos(angle)}, 0, 0]}}
        elements:
          rod: {{type: rigid_body, node: rod, mass: {mass}, inertia: [1e-3, {inertia}, {inertia}], attached: [tip]}}
          tip:
            {{type: contact, nodes: [ground, tip], plane: {{normal: [0, 0, 1], point: [0, 0, 0]}},
             friction: {{coefficient: 2, regularization: 0.1 mm/s}}}}
        joints: {{plane: {{type: planar, nodes: [ground, rod], axis: [0, 1, 0]}}}}
        initial: {{velocities: [{{nodes: all, velocity: [{-v}, 0, 0]}}]}}
        time: {{end: 0.2, step: 1 ms}}
    """)
    )
    (shock,) = [event for event in run.event_records if event.impulse]
    omega = mass * v * height / (inertia + mass * half**2)
    lost = 0.5 * mass * v**2 - 0.5 * (inertia + mass * half**2) * omega**2
    verify(S, "Painlevé's rod: energy lost as its tip stops [J]", shock.lost, lost, "angular momentum", relative=1e-9)
    assert shock.impulse == pytest.approx(mass * omega * half * math.cos(angle), rel=1e-9)
    assert np.ptp(run["energy/balance"]) < 1e-4 * lost


def test_friction_presses_what_would_part_without_it():
    """A belt carries a puck uphill against a stop: the impact closes it for good, though gravity pulls it away."""
    run = RecordedRun(deck(BELT.replace("FRICTION", "{coefficient: 0.8, regularization: 1.0e-3}")))
    bed, stop = run.event_records
    assert (bed.element, stop.element, stop.after) == ("contact 'bed'", "contact 'stop'", "closed")
    creep = 1e-3 * (1 - np.sqrt(1 - 3 / (0.8 * 9.3)))  # where the regularized friction, u (2 - u), carries the weight
    assert stop.impulse == pytest.approx(2 * (1 - creep), rel=1e-7)
    assert run["elements/stop/normal_force"][-1] == pytest.approx(0.8 * 2 * 9.3 - 2 * 3, rel=1e-9)


FLUSH = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {body: {position: [0.2, 0, 2]}, low: {position: [0, 0, 1.5]}, high: {position: [0, 0, 2.5]}}
    initial:
      velocities:
      - {nodes: [body, low, high], velocity: [-1, 0, -1], angular_velocity: [0, TURNING, 0], about: [0.2, 0, 2]}
    elements:
      box: {type: rigid_body, node: body, attached: [low, high], mass: 2, inertia: [1, 0.19, 1]}
      low_edge: {type: contact, nodes: [ground, low], WALL}
      high_edge: {type: contact, nodes: [ground, high], WALL}
    joints: {plane: {type: planar, nodes: [ground, body], axis: [0, 1, 0]}}
    time: {end: 0.5, step: 1.0e-3, rho_inf: 0}
"""
WALL = "plane: {normal: [1, 0, 0], point: [-0.1, 0, 0]}, friction: {coefficient: 0.5, regularization: 1.0e-3}"


@pytest.mark.parametrize("turning", [-0.7, -0.1, 0.5])
def test_a_box_falls_flush_with_a_wall(turning):
    """Both edges touch the wall without a force: it falls with g, and rounding errors do not open and close them."""
    run = RecordedRun(deck(FLUSH.replace("TURNING", str(turning)).replace("WALL", WALL)))
    flush = run["nodes/body/velocity"][(run.time > 0.3) & (run.time < 0.4)]
    np.testing.assert_allclose(np.diff(flush[:, 2]), -9.81 * 1e-3, rtol=1e-9)
    np.testing.assert_allclose(flush[:, 0], 0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("overlap", "later", "keeps"),
    [(2e-9, 1e-9, True), (2e-9, 3e-9, False), (0.0, 1e-10, True), (0.0, 3e-9, False), (-1e-15, 1e-10, True)],
)
def test_a_ball_that_lifts_off_keeps_its_phase_where_rounding_decides(overlap, later, keeps):
    """Ten times the tolerance of constraints are 2e-10 m here: a larger overlap counts, unless it shrinks."""
    prepared = prepare(deck(STACK))
    integrator, s = integrator_of(prepared), prepared.state
    s.memory = integrator.system.commit(s)
    stack = next(c for c in integrator.shocks.impact_candidates if c.element == "contact 'stack'")
    s, _ = integrator.method.start(s, 1e-3)
    x = integrator.system.numbering.x[[node.name for node in integrator.system.nodes].index("high")]
    s.z[x + 2], s.a[x + 2] = 0.3 - overlap, 1e-3
    g0 = integrator.shocks.departing(s, integrator.monitor.values(s))
    end = s.copy()
    end.t, end.z[x + 2] = s.t + 1e-3, 0.3 - later
    assert integrator.shocks.undecided(g0, s, end, 1e6)[stack.event] == keeps


def test_a_contact_that_is_kept_closed_opens_when_that_time_is_over():
    """As one that friction makes open and close without end; until then it pulls, which does no work."""
    prepared = prepare(
        deck("""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {ball: {position: [0, 0, 0.1]}}
        elements:
          ball: {type: rigid_body, node: ball, mass: 1, inertia: [4e-3, 4e-3, 4e-3]}
          floor: {type: contact, nodes: [ground, ball], plane: {normal: [0, 0, 1], point: [0, 0, 0]}, radius: 0.1}
        loads: {lift: {type: force, node: ball, direction: [0, 0, 1], value: {linear: {slope: 2000}}}}
        time: {end: 0.02, step: 1 ms}
    """)
    )
    for until, opens in ((-np.inf, 9.81 / 2000), (0.0105, 0.01)):
        integrator, found = integrator_of(prepared), []
        integrator.observers = (lambda accepted, found=found: found.extend(accepted.event_records),)
        run = integrator.begin(prepared.state, 1e-3)
        integrator.shocks.keep_closed({("contact 'floor'", "opens")}, until)
        run = integrator.to(0.02, run)
        (opened,) = found
        assert opened.name == "opens" and opened.t == pytest.approx(opens, rel=1e-6)

"""Superelements: rigid motions, momentum, frequencies of the full model, spin-up, recovery of inner nodes."""

import numpy as np
import pytest
import scipy.linalg as la
from scipy.spatial.transform import Rotation
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.dynamic import run
from mecano.analyses.kind_samples import expand, samples
from mecano.analyses.modal import modes
from mecano.analyses.reduction import part_of, reduce_part
from mecano.analyses.static import run as run_static
from mecano.deck.build import build, set_velocities
from mecano.deck.read import deck_of_bytes
from mecano.elements.bodies.reduced_matrices import buckling_load, first_clamped_frequency
from mecano.elements.bodies.superelement import SUPERELEMENT
from mecano.errors import AssemblyError, DeckError, UsageError
from mecano.model.system import System
from mecano.post.mode_shapes import AMPLITUDE, mode_sketches
from mecano.post.pictures import draw_alone
from mecano.post.quantity import find
from mecano.post.recovered import recover
from mecano.results.modes_file import read_modes
from mecano.results.reader import open_results
from mecano.solve.modal.linearize import linearize
from mecano.solve.modal.reduction import reduce

BAR = """
mecano: 1
gravity: [0, 0, 0]
nodes:
  root: {position: [0.2, 0.1, 0], orientation: [0.3, -0.2, 0.5]}
  tip: {position: [1.1, 0.4, 0.3], orientation: [0, 0, 1.0]}
sections:
  bar: {type: rectangle, width: 0.04, height: 0.02, E: 7.0e10, nu: 0.3, density: 2700}
elements:
  arm: {type: beam, nodes: [root, tip], section: bar, up: [0, 0, 1], mesh: 8}
time: {end: 0.1, step: 0.001}
"""


def reduced(text, nodes, number):
    system = System(part_of(deck(text), (), nodes))
    return system, reduce(system, nodes, number, 1.0)


def squares(M, K, held):
    """Squares of the circular frequencies, ascending, with the unknowns ``held`` fixed."""
    free = np.setdiff1d(np.arange(len(K)), held)
    inverse = la.eigh(M[np.ix_(free, free)], K[np.ix_(free, free)], eigvals_only=True)[::-1]
    return 1.0 / inverse


@pytest.mark.parametrize(("number", "first", "tolerance"), [(None, 48, 1e-9), (10, 3, 1e-4)])
def test_frequencies_are_those_of_the_full_model(number, first, tolerance, verify):
    """A clamped bar of 8 beams: with all modes kept, all of them; with 10 modes the first three, from above."""
    system, result = reduced(BAR, ["root", "tip"], number)
    lin, of = linearize(system, system.initial_state(), 1.0), system.numbering
    held = np.concatenate([of.x[0] + np.arange(3), of.r[0] + np.arange(3)])
    full = np.sqrt(squares(lin.M.toarray(), lin.K.toarray(), held))
    own = np.sqrt(squares(result.content["mass"], result.content["stiffness"], np.arange(6)))
    assert len(own) == 6 + (48 - 6 if number is None else 10)
    ratio = own[:first] / full[:first] - 1.0
    what = f"superelement with {number or 'all 42'} modes: frequencies over those of the full model"
    verify("Frequencies", what, own[:first] / full[:first], 1.0, "eigenvalues of the full model", absolute=tolerance)
    if number:
        assert np.all(ratio > 1e-8)  # fewer motions are stiffer: the comparison is with another model


def test_static_shapes_are_exact():
    """Forces on the tip of the clamped bar: tip and inner nodes move as in the full model."""
    system, result = reduced(BAR, ["root", "tip"], 2)
    of, c = system.numbering, result.content
    K = linearize(system, system.initial_state(), 1.0).K.toarray()
    free = np.setdiff1d(np.arange(system.n_q), np.concatenate([of.x[0] + np.arange(3), of.r[0] + np.arange(3)]))
    axes, load = system.nodes[0].R, np.array([3.0, -1.0, 2.0, 0.3, 0.2, -0.4])
    f = np.zeros(system.n_q)
    f[of.x[1] : of.x[1] + 3], f[of.r[1] : of.r[1] + 3] = axes @ load[:3], axes @ load[3:]
    u = np.zeros(system.n_q)
    u[free] = la.solve(K[np.ix_(free, free)], f[free], assume_a="pos")
    b = np.zeros(len(c["stiffness"]))
    b[6:12] = la.solve(c["stiffness"][6:12, 6:12], load, assume_a="pos")
    inner = np.concatenate([axes.T @ u[of.x[i] : of.x[i] + 3] for i in range(2, len(system.nodes))])
    size = np.abs(inner).max()
    np.testing.assert_allclose(b[6:9], axes.T @ u[of.x[1] : of.x[1] + 3], rtol=0, atol=1e-9 * size)
    np.testing.assert_allclose(c["interior_basis"] @ b, inner, rtol=0, atol=1e-9 * size)


def test_a_part_of_a_frame_with_joints_inside():
    """Two bars that a fixed joint holds together have the frequencies of one bar; damping is reduced with them."""
    two = BAR.replace(
        "  tip: {position: [1.1, 0.4, 0.3], orientation: [0, 0, 1.0]}",
        "  tip: {position: [1.1, 0.4, 0.3]}\n"
        "  m1: {position: [0.65, 0.25, 0.15]}\n  m2: {position: [0.65, 0.25, 0.15]}",
    )
    two = two.replace("density: 2700}", "density: 2700, damping: 1.0e-4}").replace(
        "  arm: {type: beam, nodes: [root, tip], section: bar, up: [0, 0, 1], mesh: 8}",
        "  a: {type: beam, nodes: [root, m1], section: bar, up: [0, 0, 1], mesh: 4}\n"
        "  b: {type: beam, nodes: [m2, tip], section: bar, up: [0, 0, 1], mesh: 4}\n"
        "joints:\n  weld: {type: fixed, nodes: [m1, m2]}",
    )
    one, other = reduced(BAR, ["root", "tip"], 6)[1], reduced(two, ["root", "tip"], 6)[1]
    np.testing.assert_allclose(other.frequencies, one.frequencies, rtol=1e-8)
    K, C = other.content["stiffness"], other.content["damping"]
    np.testing.assert_allclose(C, 1e-4 * K, rtol=0, atol=1e-11 * np.abs(K).max())


@pytest.mark.parametrize(
    ("change", "nodes", "error", "text"),
    [
        ("", ["root", "top"], UsageError, "node 'top' does not belong to the part"),
        ("joint", ["ground"], UsageError, "node 'ground' does not belong to the part; it has root, tip"),
        ("", ["root", "root"], UsageError, "share unknowns or are named twice"),
        ("fixed", ["root"], UsageError, "node 'tip' is fixed: it can only be a boundary node"),
        ("joint", ["root"], AssemblyError, "resists rigid motions|hold its boundary nodes"),
        ("mass", ["root", "tip"], AssemblyError, "can still move freely: node pin"),
        ("spring", ["root", "tip"], AssemblyError, "forces act in the part at the start"),
    ],
)
def test_parts_that_cannot_be_reduced(change, nodes, error, text):
    text_of = {
        "": BAR,
        "fixed": BAR.replace("orientation: [0, 0, 1.0]", "fixed: true"),
        "joint": BAR + "joints:\n  g: {type: hinge, nodes: [ground, tip], axis: [0, 0, 1]}\n",
        "mass": BAR.replace("sections:", "  pin: {position: [0, 0, 0]}\nsections:").replace(
            "time:", "  m: {type: point_mass, node: pin, mass: 1}\ntime:"
        ),
        "spring": BAR.replace(
            "time:", "  s: {type: spring_damper, nodes: [root, tip], law: {spring: {stiffness: 1.0e6}, "
            "preload: {force: 100.0}}}\ntime:",
        ),
    }  # fmt: skip
    with pytest.raises(error, match=text):
        reduced(text_of[change], nodes, 2)


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ("natural_length: span", "reads 'span', which the part does not contain"),
        ("natural_length: 1 + tip.position.z", "spring_damper 's' has a formula or a release"),
        ("release: {time: 0.05}", "spring_damper 's' has a formula or a release"),
    ],
)
def test_parts_that_are_not_constant(tmp_path, option, message):
    spring = f"  s: {{type: spring_damper, nodes: [root, tip], law: {{spring: 1000}}, {option}}}\n"
    text = BAR.replace("time:", f"{spring}signals: {{span: 1 + time}}\ntime:")
    with pytest.raises(UsageError, match=message):
        reduce_part(deck(text), tmp_path / "part.npz", nodes=["root", "tip"])


def test_signals_and_loads_are_no_part():
    """Also those that read one another, the motion and the part."""
    more = (
        "signals: {height: tip.position.z, push: 1 + height - pull.force, late: {type: lag, input: push, "
        "time_constant: 0.1}}\n"
        "loads: {pull: {type: line_force, nodes: [root, tip], value: height}}\n"
    )
    alone, among = reduced(BAR, ["root", "tip"], 2)[1], reduced(BAR + more, ["root", "tip"], 2)[1]
    assert among.inner == alone.inner and among.content.keys() == alone.content.keys()
    for key, values in alone.content.items():
        assert np.array_equal(among.content[key], values), key


def momentum(instance, motion):
    """Linear and angular momentum (6,): dT/dv = M v of the nodes, about the origin."""
    q, v, a, R = instance.local(motion)
    p = instance.force(motion.t, (q, v, a, R))[3] @ v
    return wrench(p, q, R)


def wrench(f, q, R):
    """Sum of forces and of moments about the origin of rows of nodes."""
    total = np.zeros(6)
    for i in range(len(R)):
        force, moment = f[6 * i : 6 * i + 3], R[i] @ f[6 * i + 3 : 6 * i + 6]
        total += np.concatenate([force, np.cross(q[6 * i : 6 * i + 3], force) + moment])
    return total


def test_momentum_changes_by_the_forces_on_the_nodes():
    """For any deformed motion; the weight is that of the whole mass."""
    for sample in samples(SUPERELEMENT):
        rng = np.random.default_rng(3)
        free = expand(SUPERELEMENT, sample.values, sample.nodes, "", np.zeros(3), rng)[0]
        heavy = expand(SUPERELEMENT, sample.values, sample.nodes, "", np.array([0.0, 3.0, -4.0]), rng)[0]
        heavy.scalars = free.scalars

        def at(h, free=free, motion=sample.motion):
            return momentum(free.after(h), motion.after(h))

        h = 1e-3
        change = (8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h)
        q, v, a, R = state = free.local(sample.motion)
        f = free.force(sample.motion.t, state)[0]
        np.testing.assert_allclose(wrench(f, q, R), change, rtol=0, atol=1e-8 * np.abs(f).max())
        weight = wrench(f - heavy.force(sample.motion.t, state)[0], q, R)[:3]
        np.testing.assert_allclose(weight, 2.0 * np.array([0.0, 3.0, -4.0]), rtol=0, atol=1e-9 * np.abs(f).max())


def test_thousand_turns_leave_no_strain():
    sample = samples(SUPERELEMENT)[1]
    instance, motion = sample.instances[0], sample.motion
    instance.scalars = 0.0 * instance.scalars
    x, R = (np.array(part) for part in zip(*sample.nodes, strict=True))
    for i in range(200):
        turn = Rotation.from_rotvec((10.0 * np.pi * i + 0.3) * np.array([0.48, 0.6, 0.64])).as_matrix()
        motion.x[:, 0], motion.R = x @ turn.T + 5.0, turn @ R
        y, _ = instance.observe(motion.t, instance.local(motion), np.zeros(12))
        np.testing.assert_allclose(y[12:18], 0.0, atol=1e-13)  # displacement and rotation of the first node
        assert y[0] < 1e-24


def test_rigid_motions_have_the_energy_of_the_full_model(tmp_path):
    """A bent frame in flight: kinetic energy, momentum of all its parts, potential energy of its weight."""
    frame = BAR.replace("mesh: 8}", "mesh: 4, via: [0.5, 0.4, 0.4]}").replace(
        "gravity: [0, 0, 0]", "gravity: [1, 2, 3]"
    )
    reduce_part(deck(frame), tmp_path / "part.npz", nodes=["root", "tip"], number=3)

    small = frame.split("sections:")[0] + "elements: {s: {type: superelement, nodes: [root, tip], file: part.npz}}\n"
    small = deck_of_bytes((small + "time: {end: 1, step: 0.1}\n").encode(), str(tmp_path / "small.yaml"))
    motion = (
        "initial: {velocities: [{nodes: all, velocity: [1, 2, -1], angular_velocity: [3, -5, 2], about: [0, 0, 0]}]}"
    )

    found = []
    for one in (deck(frame + motion), small):
        system = System(build(one))
        state = system.initial_state()
        set_velocities(deck(frame + motion) if one is not small else _with(small, motion, tmp_path), system, state)
        found.append(system.observe(state).energy[:2])
    np.testing.assert_allclose(found[1], found[0], rtol=1e-9)


def test_a_bar_that_turns_as_it_flies_is_not_bent_by_its_speed(tmp_path):
    """At 70 m/s and 2 rad/s it deforms as in place, where only its centrifugal forces stretch it."""
    reduce_part(deck(BAR), tmp_path / "part.npz", nodes=["root", "tip"], number=3)
    text = BAR.split("sections:")[0] + "elements: {s: {type: superelement, nodes: [root, tip], file: part.npz}}\n"
    turning = "angular_velocity: [0, 2, 1], about: [0.65, 0.25, 0.15]"
    motion = f"initial: {{{{velocities: [{{{{nodes: all, velocity: {{}}, {turning}}}}}]}}}}\n"
    runs = []
    for velocity in ([0, 0, 0], [70, -20, 10]):
        whole = text + motion.format(velocity) + "time: {end: 0.02, step: 2.0e-4}\n"
        runs.append(RecordedRun(deck_of_bytes(whole.encode(), str(tmp_path / "bar.yaml"))))
    still, flying = ([run[f"elements/s/{name}_2"] for name in ("displacement", "rotation")] for run in runs)
    assert np.abs(still[0]).max() > 1e-9
    for one, other in zip(flying, still, strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-12)


def _with(small, motion, folder):

    return deck_of_bytes((small.text + motion).encode(), str(folder / "small.yaml"))


def test_spin_up():
    """inputs/superelement_arm.yaml: 0.57526 m of lag is that of 32 beams (tests/benchmarks/superelements.py)."""
    recorded = RecordedRun(input_deck("superelement_arm"))
    x, t = recorded["nodes/tip/position"], recorded.time
    angle = 0.2 * t**2 + 2.279726631 * (np.cos(2 * np.pi * 0.0666666667 * t) - 1.0)
    lag = np.sin(angle) * x[:, 0] - np.cos(angle) * x[:, 1]
    assert lag.max() == pytest.approx(0.57526, rel=0.01)
    stretch = np.linalg.norm(x[-1]) - 10.0
    assert stretch == pytest.approx(1.2 * 36.0 * 1e3 / (3 * 2.8e7), rel=0.01)  # rho A w^2 L^3/(3 EA)
    assert not any(info.error > 1e9 for info in recorded.infos)


def test_signals_read_the_deformation():
    """Not the forces on the nodes, which depend on accelerations."""
    signal = "signals={bent: {type: formula, value: s8.strain_energy}}"
    recorded = RecordedRun(input_deck("superelement_arm", "time.end=2", signal))
    energy = recorded["elements/s8/strain_energy"]
    np.testing.assert_allclose(recorded["signals/bent/value"], energy, rtol=0, atol=1e-6 * energy.max())
    with pytest.raises(DeckError, match="measure a reaction of a joint"):
        input_deck("superelement_arm", signal.replace("strain_energy", "force_2.x"))


def test_inner_nodes_are_recovered(tmp_path):
    """Between the ends of each piece, where the beam theory has them; by name in post."""
    path = tmp_path / "arm.h5"
    run(input_deck("superelement_arm", "time.end=4", "output.every=1"), path)
    with open_results(path) as results:
        inner = recover(results, "s5", results.resolved["elements"]["s5"])
        assert inner.names == ["piece.1", "piece.2", "piece.3"]
        ends = [results[f"nodes/{name}/position"].values for name in ("n4", "n5")]
        for i in range(3):
            on_chord = ends[0] + (i + 1) / 4 * (ends[1] - ends[0])
            np.testing.assert_allclose(inner.positions[:, i], on_chord, rtol=0, atol=2e-3)
        np.testing.assert_allclose(inner.positions[0, :, 0], [5.3125, 5.625, 5.9375], rtol=0, atol=1e-9)
        assert np.abs(inner.positions[-1, 1] - 0.5 * (ends[0] + ends[1])[-1]).max() > 1e-5  # it is bent
        x, y, z = find(results, "s5.piece.2.position")
        np.testing.assert_array_equal(np.stack([x.values, y.values, z.values], -1), inner.positions[:, 1])
        (one,) = find(results, "elements/s5/piece.2/displacement.magnitude")
        np.testing.assert_allclose(one.values, np.linalg.norm(inner.displacements[:, 1], axis=1))
        assert one.unit == "m"


def test_inner_nodes_follow_the_full_model(tmp_path):
    """The middle of a reduced bar in fast bending vibration against that of the original beams."""
    base = BAR.replace("root: {position: [0.2, 0.1, 0], ", "root: {position: [0.2, 0.1, 0], fixed: true, ").replace(
        "time: {end: 0.1, step: 0.001}", "loads:\n  f: {type: force, node: tip, value: 2.0, direction: [0, 0, 1]}\n"
        "time: {end: 0.05, step: 0.0005}",
    )  # fmt: skip
    reduce_part(deck(BAR), tmp_path / "bar.npz", nodes=["root", "tip"], number=None)
    head, tail = base.split("sections:")
    small = (
        head
        + "elements: {s: {type: superelement, nodes: [root, tip], file: bar.npz}}\n"
        + "loads:"
        + tail.split("loads:")[1]
    )

    run(deck(base), tmp_path / "full.h5")
    run(deck_of_bytes(small.encode(), str(tmp_path / "small.yaml")), tmp_path / "small.h5")
    with open_results(tmp_path / "full.h5") as full, open_results(tmp_path / "small.h5") as own:
        expected = full["nodes/arm.4/position"].values
        (z,) = find(own, "s.arm.4.position.z")
        size = np.ptp(expected[:, 2])
        assert size > 5e-5
        np.testing.assert_allclose(z.values, expected[:, 2], rtol=0, atol=2e-3 * size)


def clamped(folder, rest):
    """The bar reduced with all modes, clamped at its root, with more sections of the deck."""
    reduce_part(deck(BAR), folder / "bar.npz", nodes=["root", "tip"], number=None)
    head = BAR.split("sections:")[0].replace("root: {", "root: {fixed: true, ")
    text = head + "elements: {s: {type: superelement, nodes: [root, tip], file: bar.npz}}\n" + rest
    return deck_of_bytes(text.encode(), str(folder / "small.yaml"))


def test_modes_of_a_deck_and_of_a_saved_state(tmp_path):
    """First bending of the clamped bar, about the start and about a state of a run, whose amplitudes it takes up."""
    small = clamped(tmp_path, "time: {end: 0.002, step: 0.001}")
    full = deck(BAR.replace("root: {", "root: {fixed: true, "))
    expected = modes(full, None, number=3)[1].frequency
    found = modes(small, tmp_path / "modes.h5", number=3)[1]
    np.testing.assert_allclose(found.frequency, expected, rtol=1e-7)
    assert draw_alone(tmp_path / "modes.h5").stat().st_size > 10_000
    modes(full, tmp_path / "full_modes.h5", number=3)
    own, whole = read_modes(tmp_path / "modes.h5"), read_modes(tmp_path / "full_modes.h5")
    names = small.values["elements"]["s"]["file"]["interior_names"]
    inside = np.stack([whole.nodes[name]["translation"] for name in names], axis=1)
    assert np.abs(inside[0]).max() > 0.1  # of the largest displacement, the same of both, which is 1
    sign = np.sign(np.sum((own.inner["s"]["translation"] * inside).real, axis=(1, 2)))
    np.testing.assert_allclose(own.inner["s"]["translation"] * sign[:, None, None], inside, rtol=0, atol=1e-5)
    for file in (own, whole):
        rod = next(shape.points for shape in mode_sketches(file)[0].shapes if shape.style == "rod")
        moved = np.linalg.norm(rod[-1] - rod[2], axis=1)  # the largest, less the state itself
        size = np.linalg.norm(np.ptp(rod[2], axis=0))
        assert len(moved) > 2 and moved.max() == pytest.approx(AMPLITUDE * size, rel=0.05)
        assert 0.2 < moved[len(moved) // 2] / moved[-1] < 0.45  # 0.339 of a clamped bar, 0.5 of a straight line
    run(small, tmp_path / "small.h5")
    again = modes(small, None, at=str(tmp_path / "small.h5"), number=3)[1].frequency
    np.testing.assert_allclose(again, expected, rtol=1e-7)


def test_one_boundary_node(tmp_path):
    """A bar reduced to its clamped root keeps its frequencies; of the root alone every motion is rigid."""
    result = reduce_part(deck(BAR), tmp_path / "bar.npz", nodes=["root"], number=None)[1]
    np.testing.assert_array_equal(result.content["stiffness"][:6], 0.0)
    head = BAR.split("sections:")[0].replace("root: {", "root: {fixed: true, ")
    text = head + "elements: {s: {type: superelement, nodes: [root], file: bar.npz}}\ntime: {end: 1, step: 1}\n"
    small = "\n".join(line for line in text.splitlines() if not line.strip().startswith("tip:"))
    found = modes(deck_of_bytes(small.encode(), str(tmp_path / "small.yaml")), None, number=3)[1].frequency
    expected = modes(deck(BAR.replace("root: {", "root: {fixed: true, ")), None, number=3)[1].frequency
    np.testing.assert_allclose(found, expected, rtol=1e-7)


def test_static_deflection(tmp_path):
    """P L^3/(3 EI) + P L/(k GA) across the bar towards the wide side of its section, for a small force."""
    load = "f: {type: force, node: tip, value: 0.01, direction: [0.316227766, -0.948683298, 0]}"
    small = clamped(tmp_path, f"loads: {{{load}}}\nstatic: {{}}\n")
    final = run_static(small, tmp_path / "static.h5")
    assert final is not None
    with open_results(tmp_path / "static.h5") as results:
        x = results["nodes/tip/position"].values[-1] - np.array([1.1, 0.4, 0.3])
    L, E, area, inertia = np.sqrt(0.99), 7.0e10, 0.04 * 0.02, 0.02 * 0.04**3 / 12.0
    bending, shear = 0.01 * L**3 / (3 * E * inertia), 0.01 * L / (5 / 6 * E / 2.6 * area)
    assert np.linalg.norm(x) == pytest.approx(bending + shear, rel=1e-3)


STIFFNESS, LENGTH, WEIGHT = 7.0e10 * 0.04 * 0.02**3 / 12.0, np.sqrt(0.99), 2700 * 0.04 * 0.02 * np.sqrt(0.99)


def test_first_clamped_frequency_and_buckling_load():
    """22.373 sqrt(EI/(m L^3)) of a bar with clamped ends, 3.516 with one, and Euler's pi^2 EI/L^2."""
    both, one = (reduced(BAR, nodes, None)[1].content for nodes in (["root", "tip"], ["root"]))
    bending = np.sqrt(STIFFNESS / (WEIGHT * LENGTH**3))
    assert first_clamped_frequency(both) == pytest.approx(22.373 * bending, rel=0.01)
    assert first_clamped_frequency(one) == pytest.approx(3.516 * bending, rel=0.01)
    assert buckling_load(both) == pytest.approx(np.pi**2 * STIFFNESS / LENGTH**2, rel=0.02)
    assert buckling_load(one) == np.inf


@pytest.mark.parametrize(("share", "reported"), [(0.08, False), (0.15, True)])
def test_forces_near_the_buckling_load_are_reported(tmp_path, share, reported):
    """A superelement neither buckles nor stiffens; a tenth of its buckling load changes its stiffness by a tenth."""
    size = share * np.pi**2 * STIFFNESS / LENGTH**2
    load = f"f: {{type: force, node: tip, value: {size}, direction: [-0.9, -0.3, -0.3]}}"
    run_static(clamped(tmp_path, f"loads: {{{load}}}\nstatic: {{}}\n"), tmp_path / "static.h5")
    with open_results(tmp_path / "static.h5") as results:
        assert ("forces in it would change its stiffness by more than a tenth" in results.reason) == reported


@pytest.mark.parametrize(("share", "reported"), [(0.25, False), (0.4, True)])
def test_fast_rotation_is_reported(tmp_path, share, reported):
    """Above 0.316 of the first clamped frequency centrifugal terms are more than a tenth of the stiffness."""
    reduce_part(deck(BAR), tmp_path / "bar.npz", nodes=["root"], number=2)
    rate = share * 3.516 * np.sqrt(STIFFNESS / (WEIGHT * LENGTH**3))
    head = BAR.split("sections:")[0].replace("  tip: {position: [1.1, 0.4, 0.3], orientation: [0, 0, 1.0]}\n", "")
    text = f"""{head}elements: {{blade: {{type: superelement, nodes: [root], file: bar.npz}}}}
joints: {{hub: {{type: hinge, nodes: [ground, root], axis: [0, 0, 1]}}}}
initial: {{velocities: [{{nodes: [root], velocity: [0, 0, 0], angular_velocity: [0, 0, {rate}], about: own}}]}}
time: {{end: 0.01, step: 1.0e-3}}
"""
    run(deck_of_bytes(text.encode(), str(tmp_path / "blade.yaml")), tmp_path / "blade.h5")
    with open_results(tmp_path / "blade.h5") as results:
        np.testing.assert_allclose(results["blade.frame_spin"].values[0], [0, 0, rate], atol=1e-9)
        assert ("superelement 'blade': frame_spin.z reached" in results.reason) == reported


ROUND = """
mecano: 1
gravity: none
sections: {s: {type: circle, diameter: 20 mm, E: 70 GPa, nu: 0.3, density: 2700}}
nodes: {a: {position: [0, 0, 0]}, b: {position: [1, 0, 0]}}
elements: {boom: {type: beam, nodes: [a, b], section: s, mesh: 6}}
time: {end: 1, step: 0.01}
"""


@pytest.mark.parametrize(("number", "split"), [(1, True), (2, False), (3, True), (0, False), (None, False)])
def test_a_cut_between_modes_of_one_frequency_is_reported(tmp_path, number, split):
    """The first four modes of a clamped round bar are two pairs, of bending in both planes."""
    text, result = reduce_part(
        deck_of_bytes(ROUND.encode(), "round.yaml"), tmp_path / "boom.npz", nodes=["a", "b"], number=number
    )
    assert (f"(--modes {(number or 0) + 1})" in text) == split
    assert np.isfinite(result.next_frequency) == bool(number)

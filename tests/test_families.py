"""Families of modes, and modes that are not converged, in tables, files and sweeps."""

from dataclasses import replace

import numpy as np
import pytest
from time_runs import INPUTS, deck, input_deck

from mecano.analyses import modal, sweep
from mecano.analyses.modal import modes
from mecano.analyses.operating_point import operating_point
from mecano.analyses.sweep import sweep_into
from mecano.post.info_other_files import info_other
from mecano.results.modes_file import read_modes
from mecano.results.sweep_file import read_sweep
from mecano.solve.modal.families import FAMILIES, families, running_axes
from mecano.solve.modal.linearize import linearize
from mecano.solve.modal.modes import damping, solve
from mecano.solve.modal.tracking import least_damped


def block(velocity):
    """A body on a bushing with six different frequencies, 1 to 6 rad/s in the order of FAMILIES along x, y, z."""
    matrix = np.diag(np.arange(1.0, 7.0) ** 2).tolist()
    along_x, along_y = (f"value: {{linear: {{slope: {v}}}}}" for v in velocity)
    return deck(f"""
        mecano: 1
        nodes: {{cart: {{position: [0, 0, 0]}}, body: {{position: [0, 0, 0]}}}}
        gravity: [0, 0, 0]
        elements:
          body: {{type: rigid_body, node: body, mass: 1, inertia: [1, 1, 1]}}
          mount: {{type: bushing, nodes: [cart, body], stiffness: {matrix}}}
          cart: {{type: point_mass, node: cart, mass: 1}}
        joints:
          level: {{type: held_rotation, nodes: [ground, cart]}}
          x: {{type: prescribed_position, node: cart, direction: [1, 0, 0], {along_x}}}
          y: {{type: prescribed_position, node: cart, direction: [0, 1, 0], {along_y}}}
          z: {{type: prescribed_position, node: cart, direction: [0, 0, 1], value: 0}}
        initial: {{velocities: [{{nodes: all, velocity: [{velocity[0]}, {velocity[1]}, 0]}}]}}
        time: {{end: 1, step: 0.1}}
        """)


@pytest.mark.parametrize("velocity,order", [((0, 0), (0, 1, 2, 3, 4, 5)), ((3, 0), (0, 1, 2, 3, 4, 5)),
                                            ((0, -3), (1, 0, 2, 4, 3, 5))])  # fmt: skip
def test_families_of_a_body_on_six_springs(velocity, order):
    """Along and about the axes of the running; along x, y and z where nothing runs."""
    base = operating_point(block(velocity))
    system = base.prepared.system
    lin = linearize(system, base.state, 1.0)
    found = solve(lin)
    np.testing.assert_allclose(found.values.imag, np.arange(1, 7), rtol=1e-9)
    axes = running_axes(system, base.state)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    np.testing.assert_array_equal(families(lin, system.numbering.kind[: system.n_q], axes, found.shapes), order)


def test_families_of_motions_without_inertia():
    """A scalar of its own is a deformation, whatever it moves; vertical is against gravity."""
    base = operating_point(input_deck("caster_shimmy"))
    system = base.prepared.system
    lin = linearize(system, base.state, 1.0)
    kind = system.numbering.kind[: system.n_q]
    own = np.zeros(system.n_q)
    own[int(np.flatnonzero(kind == 2)[0])] = 1.0
    axes = running_axes(system, base.state)
    np.testing.assert_allclose(axes, np.eye(3), atol=1e-9)
    assert [FAMILIES[i] for i in families(lin, kind, axes, own[None])] == ["deformation"]


@pytest.mark.parametrize("count", [1, 2, 3])
def test_families_of_a_deck_with_signals(count, tmp_path):
    """An actuated slide of 1 kg: its motion along x, not its signals, determines the family, at any gain."""
    signals = ["u: -$k*t.displacement - 2*t.velocity", "v: 2*u", "w: 1.0e9*u"][:count]
    (tmp_path / "slide.yaml").write_text(slide(signals))
    sweep_into(tmp_path / "s.h5", tmp_path / "slide.yaml", (), ["k=100,400"])
    file = read_sweep(tmp_path / "s.h5")
    assert file.families == [["longitudinal"] * 2]
    np.testing.assert_allclose(file.modes["imaginary_part"][0], np.sqrt([99.0, 399.0]), rtol=1e-9)


def test_the_pole_of_a_filter_is_no_motion(tmp_path):
    """A signal that follows the force with a lag of 0.1 s moves nothing: the pole is at -10/s, of no direction."""
    signals = ["u: -$k*t.displacement - 2*t.velocity", "f: {type: lag, input: u, time_constant: 0.1}"]
    (tmp_path / "slide.yaml").write_text(slide(signals))
    sweep_into(tmp_path / "s.h5", tmp_path / "slide.yaml", (), ["k=100,400"])
    file = read_sweep(tmp_path / "s.h5")
    poles = {name: file.modes["real_part"][file.families.index([name] * 2)] for name in ("longitudinal", "deformation")}
    np.testing.assert_allclose(poles["longitudinal"], -1.0, rtol=1e-9)
    np.testing.assert_allclose(poles["deformation"], -10.0, rtol=1e-9)


def test_families_of_a_deck_with_a_release(tmp_path):
    """A joint that is released brings a signal of its own, which is hidden."""
    held = "spare: {type: fixed, nodes: [ground, c], release: {time: 0.5 s}}"
    text = slide(["u: -$k*t.displacement - 2*t.velocity"], "c: {position: [0, 1, 0]}", held)
    (tmp_path / "slide.yaml").write_text(text)
    sweep_into(tmp_path / "s.h5", tmp_path / "slide.yaml", (), ["k=100,400"])
    assert ["longitudinal"] * 2 in read_sweep(tmp_path / "s.h5").families


def slide(signals, node="", joint=""):
    """A body of 1 kg on a prismatic joint along x, pushed by the signal u; k is a parameter."""
    more = "  C: {type: rigid_body, node: c, mass: 1, inertia: [1, 1, 1]}" if node else ""
    return "\n".join([
        "mecano: 1", "gravity: none", "parameters: {k: 100}", "nodes:", "  b: {position: [1, 0, 0]}", f"  {node}",
        "joints:", "  t: {type: prismatic, nodes: [ground, b], axis: [1, 0, 0]}", f"  {joint}",
        "elements:", "  B: {type: rigid_body, node: b, mass: 1, inertia: [1, 1, 1]}", more,
        "signals:", *(f"  {text}" for text in signals),
        "loads:", "  act: {type: joint_force, joint: t, value: u}", "time: {end: 1, step: 1 ms}",
    ])  # fmt: skip


def test_least_damped():
    values = np.array([-1 + 2j, -0.1 + 5j, np.nan, 1e-9, -3.0])
    assert least_damped(values, 1e-6) == 1 and least_damped(values) == 3
    assert least_damped(np.array([-3.0, -2.0, np.nan])) == 1  # both decay: the slower one
    np.testing.assert_allclose(damping(np.array([-3.0 + 4j, 2.0])), [0.6, -1.0])


def test_sweep_lists_modes_by_family(tmp_path):
    """Each mode with its family and what moves in it, and the least damped one of each family."""
    text, _ = sweep_into(tmp_path / "b.h5", INPUTS / "bicycle.yaml", (), ["speed=5,6.5"], columns=True)
    lines = text.splitlines()
    first, last = lines.index("modes, where they are least damped:"), lines.index("least damped of each family:")
    listed = [line.split() for line in lines[first + 2 : last]]
    assert [row[0] for row in listed] == ["1", "2", "3"] and all("node" in row for row in listed)
    file = read_sweep(tmp_path / "b.h5")
    ratios = file.modes["damping_ratio"]
    for family, mode, _, ratio, speed in (line.split() for line in lines[last + 2 : -2]):
        own = np.array(file.families) == family
        b, i = int(mode) - 1, list(file.parameter).index(float(speed))
        assert own[b, i] and ratios[b, i] == pytest.approx(float(ratio), abs=1e-5)
        assert ratios[b, i] <= ratios[own].min() + 1e-9
    assert {"lateral"} <= {name for row in file.families for name in row} <= set(FAMILIES)
    assert lines[-2] == "unstable at speed 6.5" and lines[-1].startswith("critical speed 6.02")
    head, row, *_ = (tmp_path / "b.csv").read_text().splitlines()
    assert row.split(",")[head.split(",").index("mode 2 family")] == file.families[1][0]


def not_found(*arguments, **options):
    """``solve`` as if the slowest oscillation had not converged."""
    found = solve(*arguments, **options)
    residuals = found.residuals.copy()
    residuals[np.argmax(found.values.imag > 0.0)] = 1e-3
    return replace(found, residuals=residuals)


def test_modes_that_are_not_converged_are_marked(tmp_path, monkeypatch):
    monkeypatch.setattr(modal, "solve", not_found)
    text, found, _ = modes(block((0, 0)), tmp_path / "m.h5")
    lines = text.splitlines()
    assert "oscillation, not converged" in lines[2] and "not converged" not in "".join(lines[3:8])
    assert "modes marked 'not converged' do not satisfy the equations (residual up to 0.001" in lines[-1]
    assert not found.converged[0] and found.converged[1:].all()
    np.testing.assert_array_equal(read_modes(tmp_path / "m.h5").converged, found.converged)
    assert info_other(tmp_path / "m.h5").count("oscillation, not converged") == 1


def test_sweeps_mark_modes_that_have_not_converged(tmp_path, monkeypatch):
    monkeypatch.setattr(sweep, "solve", not_found)
    text, _ = sweep_into(tmp_path / "c.h5", INPUTS / "caster_shimmy.yaml", (), ["speed=57,73"])
    assert "(not converged at 2 of 2 values)" in text and "modes marked 'not converged'" in text
    file = read_sweep(tmp_path / "c.h5")
    np.testing.assert_array_equal(file.modes["converged"].sum(axis=1), [0, 2])  # the oscillation, the decay
    assert text.splitlines()[3].endswith("not converged")  # the least stable mode at 57 m/s

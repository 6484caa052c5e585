"""Kinds that are computed several elements at once: the results of each element alone, in plain Python."""

import numpy as np
import pytest
from time_runs import deck

from mecano.analyses.kind_samples import Instance
from mecano.analyses.prepare import prepare
from mecano.jit.memory import LANES
from mecano.maths.so3 import exp
from mecano.maths.vector import Vec3

# Sections without and with damping, of different numbers of fibres, and with an offset of the mass.
HEAD = """
    mecano: 1
    gravity: [0.3, -0.2, -9.81]
    sections:
      tube: {type: tube, diameter: 0.06, thickness: 0.01, E: 1.0e6, nu: 0.3, density: 700}
      plank: {type: rectangle, width: 0.05, height: 0.03, E: 2.0e6, nu: 0.3, density: 500, damping: 0.01}
      whole: {type: matrix, E: 3.0, G: 1.0, torsion_radius: 0.2, damping: 0.1, points: [[0.1, 0.2]],
        stiffness: [[9, 1, 0, 0, 0, 1], [1, 8, 0, 0, 1, 0], [0, 0, 7, 0, 0, 0], [0, 0, 0, 6, 0, 0],
          [0, 1, 0, 0, 6, 0], [1, 0, 0, 0, 0, 6]],
        mass: [[1.3, 0, 0, 0, 0.2, -0.1], [0, 1.3, 0, -0.2, 0, 0], [0, 0, 1.3, 0.1, 0, 0],
          [0, -0.2, 0.1, 3, 0, 0], [0.2, 0, 0, 0, 2, 0], [-0.1, 0, 0, 0, 0, 2]]}
    time: {end: 1.0, step: 0.01}
    nodes:
"""
SECTIONS = ("tube", "plank", "whole", "tube", "plank", "tube", "whole")
X, Y, Z, OBLIQUE = (1, 0, 0), (0, 1, 0), (0, 0, 1), (0.6, -0.64, 0.48)
# Rotations from end to end [rad], for which the logarithm and its derivatives take different formulas.
TURNS = (
    ((OBLIQUE, 1e-4), (OBLIQUE, 0.9), (X, 2.9), (Y, 3.0), (Z, 2.8), (OBLIQUE, 1.3), (Z, 0.0)),
    ((OBLIQUE, 0.1),) * len(SECTIONS),
)


def beams():
    """A deck of beams that touch nothing else, in more than one group."""
    nodes = "".join(
        f"      a{i}: {{position: [0, {i}, 0]}}\n      b{i}: {{position: [0.8, {i}, 0]}}\n"
        for i in range(len(SECTIONS))
    )
    elements = "".join(
        f"      e{i}: {{type: beam, nodes: [a{i}, b{i}], section: {section}, up: [0, 0, 1]}}\n"
        for i, section in enumerate(SECTIONS)
    )
    return deck(HEAD + nodes + "    elements:\n" + elements)


def turned(axis, angle):
    """The rotation about an axis."""
    return np.array(exp(angle * Vec3(*map(float, axis))))


def moved(prepared, batch, turns):
    """A state with random positions, rates and orientations, and these rotations from end to end of the elements."""
    state, rng = prepared.state.copy(), np.random.default_rng(7)
    state.z, state.v, state.a = (rng.normal(size=len(state.z)) for _ in range(3))
    state.z[prepared.system.numbering.rotation_dof[:, None] + np.arange(3)] = 0.0
    for (first, second), (axis, angle) in zip(batch.rots, turns, strict=True):
        state.R[first] = turned(rng.normal(size=3), 1.0)
        state.R[second] = state.R[first] @ turned(axis, angle)
    return state


def alone(batch, e, state):
    """One element and its local state."""
    kind, dofs = batch.kind, batch.dofs[e]
    instance = Instance(
        kind, batch.p[e : e + 1], (0, 1), 0, np.zeros(0), np.zeros(0), np.zeros((3, 0)), np.zeros(0)
    )  # fmt: skip
    return instance, (state.z[dofs], state.v[dofs], state.a[dofs], state.R[batch.rots[e]])


@pytest.mark.parametrize("turns", TURNS)
def test_each_element_of_a_group_is_computed_as_if_alone(turns):
    prepared = prepare(beams())
    system = prepared.system
    (batch,) = (b for b in system.batches if b.kind.by_lanes)
    assert LANES < len(batch.p) < 2 * LANES  # the last group is not full
    state = moved(prepared, batch, turns)
    cK, cC, cM = 0.7, 0.4, 0.2
    n = len(state.R)
    T = np.random.default_rng(8).normal(size=(3 * n, 3, 3))
    assembly = system.assemble(state, cK=cK, cC=cC, cM=cM, T=T)
    observed = batch.outputs(system.observe(state).outputs)
    for e in range(len(batch.p)):
        instance, local = alone(batch, e, state)
        f, K, C, M = instance.force(0.0, local)
        size = np.abs(f).max()
        np.testing.assert_allclose(assembly.forces[batch.slots[e]], f, atol=1e-12 * size)
        for first, rotation in zip(batch.columns, batch.rots[e], strict=True):
            for i, matrix in enumerate((K, C, M)):
                matrix[:, first : first + 3] = matrix[:, first : first + 3] @ T[i * n + rotation]
        tangent = cK * K + cC * C + cM * M
        np.testing.assert_allclose(assembly.data[batch.entries[e]], tangent, atol=1e-12 * np.abs(tangent).max())
        y, _ = instance.observe(0.0, local, np.zeros(12))
        np.testing.assert_allclose(observed[e], y, rtol=1e-9, atol=1e-12 * np.abs(y).max())


def test_the_forces_alone_are_those_with_tangents():
    prepared = prepare(beams())
    (batch,) = (b for b in prepared.system.batches if b.kind.by_lanes)
    state = moved(prepared, batch, TURNS[0])
    forces = prepared.system.assemble(state, cK=1.0).forces
    np.testing.assert_array_equal(prepared.system.forces(state), forces)

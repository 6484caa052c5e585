"""Null spaces of sparse matrices: against singular value decompositions, and of a large mast of scissors."""

import numpy as np
import pytest

from mecano.analyses.prepare import prepare
from mecano.analyses.summary import summary_of
from mecano.deck.read import deck_of_bytes
from mecano.solve.diagnostics.null_space import Entries, left_null_space


def random_rows(rng, kind):
    """Return a matrix with rows of unit length or zero, of low rank or sparse with repeated rows."""
    m, n = rng.integers(1, 40, 2)
    if kind == "low rank":
        rank = rng.integers(1, min(m, n) + 1)
        D = rng.normal(size=(m, rank)) @ rng.normal(size=(rank, n))
    else:
        D = rng.normal(size=(m, n)) * (rng.random((m, n)) < 0.12)
        again = rng.integers(0, m, rng.integers(0, m + 1))
        D[again] = D[rng.permutation(again)]
    size = np.linalg.norm(D, axis=1, keepdims=True)
    return np.divide(D, size, out=np.zeros_like(D), where=size > 0)


def coupled(P):
    """Return the sets of rows that a projector couples, by exploring its entries above 1e-10."""
    left, sets = set(np.flatnonzero(np.diag(P) > 1e-12)), []
    while left:
        members = {min(left)}
        while new := {j for i in members for j in np.flatnonzero(np.abs(P[i]) > 1e-10)} & left - members:
            members |= new
        sets.append(sorted(members))
        left -= members
    return sets


@pytest.mark.parametrize("kind", ["low rank", "sparse"])
def test_the_null_space_is_that_of_a_singular_value_decomposition(kind):
    """300 matrices: dimension, projector, and sets of coupled rows; singular values are above 1e-6 or rounding."""
    rng = np.random.default_rng(3)
    for _ in range(150):
        D = random_rows(rng, kind)
        rows, cols = np.nonzero(D)
        groups = np.sort(rng.integers(0, max(1, D.shape[1] // 4), D.shape[1]))
        null = left_null_space(Entries(rows, cols, D[rows, cols], D.shape), groups)
        U, sigma, _ = np.linalg.svd(D)
        wanted = U[:, int(np.sum(sigma > 1e-9)) :]
        Y, P = null.dense(np.arange(len(D))), wanted @ wanted.T
        assert null.dimension == wanted.shape[1]
        assert np.abs(Y @ Y.T - P).max() < 1e-9
        assert [list(members) for members in null.components()] == coupled(P)


def test_blocks_of_sets_are_those_of_the_projector():
    """Rows without a set are left out."""
    rng = np.random.default_rng(5)
    D = random_rows(rng, "low rank")
    rows, cols = np.nonzero(D)
    null = left_null_space(Entries(rows, cols, D[rows, cols], D.shape), np.arange(D.shape[1]))
    sets = rng.integers(-1, 4, len(D))
    P = null.dense(np.arange(len(D))) @ null.dense(np.arange(len(D))).T
    found = null.among(sets)
    assert sorted(found) == sorted({*sets[sets >= 0].tolist()})
    for number, (members, block) in found.items():
        assert np.array_equal(members, np.flatnonzero(sets == number))
        assert np.allclose(block, P[np.ix_(members, members)], atol=1e-12)


def test_rows_that_do_not_hold_take_no_part():
    """The second of three equal rows does not hold."""
    B = Entries(np.arange(3), np.zeros(3, np.int64), np.ones(3), (3, 1))
    null = left_null_space(B, np.zeros(1, np.int64), np.array([True, False, True]))
    assert null.dimension == 1 and null.members.tolist() == [0, 2]


def scissors(cells):
    """Return the deck of a planar mast of scissors of bars of 1 m, which folds as one."""
    w, h = 0.5, 0.75**0.5
    nodes, bars, hinges = [], [], ["  foot: {type: hinge, nodes: [ground, a0lo], axis: [0, 1, 0]}"]
    for k in range(cells):
        for bar, low, high in (("a", 0.0, w), ("b", w, 0.0)):
            places = (f"{bar}{k}", w / 2, k + 0.5), (f"{bar}{k}lo", low, k), (f"{bar}{k}hi", high, k + 1)
            nodes += [f"  {name}: {{position: [{x}, 0, {level * h}]}}" for name, x, level in places]
            bars.append(
                f"  bar_{bar}{k}: {{type: rigid_body, node: {bar}{k}, mass: 1, inertia: [0.01, 0.08, 0.08], "
                f"attached: [{bar}{k}lo, {bar}{k}hi]}}"
            )
        pairs = [(f"mid{k}", f"a{k}", f"b{k}")]
        if k:
            pairs += [(f"right{k}", f"a{k - 1}hi", f"b{k}lo"), (f"left{k}", f"b{k - 1}hi", f"a{k}lo")]
        hinges += [f"  {name}: {{type: hinge, nodes: [{i}, {j}], axis: [0, 1, 0]}}" for name, i, j in pairs]
    slide = "  slide: {type: prescribed_position, node: b0lo, direction: [0, 0, 1], value: 0}"
    text = [
        "mecano: 1",
        "gravity: none",
        "nodes:",
        *nodes,
        "elements:",
        *bars,
        "joints:",
        *hinges,
        slide,
        "time: {end: 1, step: 1 ms}",
    ]
    return deck_of_bytes("\n".join(text).encode(), "scissors.yaml")


def test_the_work_grows_with_the_size_of_a_mast_of_scissors():
    """All its cells fold together; of each loop of four bars in space 3 constraints are redundant.

    Each cell adds 7 motions: two rotations, and displacements along x and z in the middle and at the right, along z at
    the left; the first one has a sliding foot more. Null vectors of most loops have components on a few cells: four
    times the cells have less than six times as many.
    """
    entries = []
    for cells in (25, 100):
        prepared = prepare(scissors(cells))
        analysis, of = prepared.analysis, prepared.system.numbering
        said, _ = summary_of(prepared)
        assert "mobility         1\n" in said and f"redundant        {3 * cells - 3} constraint(s)\n" in said
        (mechanism,) = analysis.mechanisms
        assert mechanism.count == 1 and len(mechanism.names) == 7 * cells + 1
        null = left_null_space(analysis.gradient, of.group, analysis.active)
        entries.append(sum(basis.size for _, basis in null.blocks))
    assert entries[1] < 6 * entries[0]

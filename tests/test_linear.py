"""The linear solver on matrices like those of mechanisms: saddle points, unsymmetric, of any size."""

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from mecano.solve.linear import factors
from mecano.solve.linear.dense_front import NULL_PIVOT
from mecano.solve.linear.scaled_superlu import ScaledSuperLU
from mecano.solve.linear.sparse import LinearSolver, multifrontal
from mecano.solve.linear.symbolic_analysis import SIZE, Pattern, analyse

ACCURATE = 1e-13  # backward error


class Problem:
    """A matrix by its pattern and values, in a random order of the entries."""

    def __init__(self, matrix, groups, n_q, seed=0):
        matrix = sp.coo_matrix(matrix)
        mixed = np.random.default_rng(seed).permutation(matrix.nnz)
        self.n, self.n_q, self.groups = matrix.shape[0], n_q, np.asarray(groups)
        self.rows, self.cols, self.data = matrix.row[mixed], matrix.col[mixed], matrix.data[mixed].astype(float)
        self.matrix = matrix.tocsc()

    def solver(self, parts=None, **options):
        return LinearSolver(self.pattern()._replace(parts=parts), **options)

    def analysis(self):
        return analyse(self.pattern())

    def pattern(self):
        return Pattern(self.n, self.rows, self.cols, self.groups)

    def rhs(self, seed=1):
        return np.random.default_rng(seed).standard_normal(self.n)

    def error(self, x, b):
        """Backward error in the largest entries."""
        size = abs(self.matrix).max() * np.abs(x).max() + np.abs(b).max()
        return np.abs(self.matrix @ x - b).max() / size


def mechanism(n_nodes, beams, hinges, ground, penalty=1.0, friction=0.1):
    """Nodes of 6 unknowns with inertia, beams (i, j), hinges (i, j) of 5 multipliers, (i, count) to the ground."""
    random = np.random.default_rng(n_nodes)
    blocks, n_q = [], 6 * n_nodes

    def dofs(*nodes):
        return np.concatenate([np.arange(6 * i, 6 * i + 6) for i in nodes])

    for i in range(n_nodes):
        gyroscopic = 0.1 * random.standard_normal((6, 6))
        blocks.append((dofs(i), np.diag(1 + random.random(6)) + gyroscopic - gyroscopic.T))
    for i, j in beams:
        B = random.standard_normal((6, 12))
        B[:, 6:] = -B[:, :6] + 0.1 * random.standard_normal((6, 6))
        stiffness = B.T @ np.diag([50, 5, 5, 1, 2, 2]) @ B + 0.05 * random.standard_normal((12, 12))
        blocks.append((dofs(i, j), stiffness))
    n = n_q
    for nodes, count in [((i, j), 5) for i, j in hinges] + [((i,), count) for i, count in ground]:
        own = dofs(*nodes)
        B, k = random.standard_normal((count, len(own))), len(own)
        block = np.zeros((k + count, k + count))
        block[:k, :k] = penalty * B.T @ B
        block[k:, :k] = B
        block[:k, k:] = B.T + friction * random.standard_normal((k, count))
        blocks.append((np.concatenate([own, np.arange(n, n + count)]), block))
        n += count
    rows = np.concatenate([np.repeat(d, len(d)) for d, _ in blocks])
    cols = np.concatenate([np.tile(d, len(d)) for d, _ in blocks])
    matrix = sp.coo_matrix((np.concatenate([v.ravel() for _, v in blocks]), (rows, cols)), shape=(n, n)).tocsc()
    return Problem(matrix, np.arange(n_q) // 6, n_q)


def chain(n):
    """Rigid bodies in a row, hinged to each other and to the ground: 11 n equations."""
    return mechanism(n, [], [(i, i + 1) for i in range(n - 1)], [(0, 5)])


def ring():
    """Twelve modules of 8 nodes and 3 hinges around a ring: 756 equations."""
    beams, hinges = [], []
    for i in range(0, 96, 8):
        j = (i + 8) % 96
        beams += [(i, i + 1), (i + 1, i + 2), (i + 4, i + 5), (i + 6, i + 7), (i + 2, i + 4)]
        beams += [(i + 1, j), (i + 5, j + 4), (i + 7, j + 6)]
        hinges += [(i + 2, i + 3), (i + 3, j + 2), (i + 5, i + 6)]
    return mechanism(96, beams, hinges, [])


def mesh(n):
    """Square grid of n x n nodes; one edge in 20 is a hinge, the others are beams."""
    edges = [(i * n + j, i * n + j + 1) for i in range(n) for j in range(n - 1)]
    edges += [(i * n + j, i * n + j + n) for i in range(n - 1) for j in range(n)]
    hinged = np.random.default_rng(n).random(len(edges)) < 0.05
    beams = [e for e, h in zip(edges, hinged, strict=True) if not h]
    return mechanism(n * n, beams, [e for e, h in zip(edges, hinged, strict=True) if h], [(0, 6)])


def star(n):
    """One body that n others are hinged to."""
    return mechanism(n + 1, [], [(0, i) for i in range(1, n + 1)], [(0, 6)])


def beam_chain(n):
    edges = [(i, i + 1) for i in range(n - 1)]
    return mechanism(n, [e for e in edges if e[0] % 20 != 19], [e for e in edges if e[0] % 20 == 19], [(0, 6)])


MODELS = {
    "one body": lambda: chain(1),
    "two bodies": lambda: chain(2),
    "six bodies": lambda: chain(6),
    "star": lambda: star(12),
    "ring": ring,
    "beams": lambda: beam_chain(500),
    "mesh": lambda: mesh(26),
    "no penalty": lambda: mechanism(20, [], [(i, i + 1) for i in range(19)], [(0, 5)], penalty=0.0),
    "no multipliers": lambda: mechanism(30, [(i, i + 1) for i in range(29)], [], []),
    "in pieces": lambda: mechanism(12, [(0, 1), (4, 5), (9, 8)], [(2, 3), (5, 6)], [(7, 3), (11, 6)]),
}


@pytest.mark.parametrize("name", MODELS)
def test_solves_mechanisms(name):
    problem = MODELS[name]()
    b, x = problem.rhs(), np.full(problem.n, np.nan)
    status = problem.solver().solve(problem.data, b, x)
    assert status and not status.fallback and not status.singular and status.null_pivots == 0
    assert status.backward_error <= ACCURATE
    assert problem.error(x, b) <= ACCURATE
    np.testing.assert_allclose(x, spla.spsolve(problem.matrix, b), rtol=1e-7, atol=1e-9 * np.abs(x).max())


def test_large_fronts_in_the_mesh_little_fill_in_the_ring():
    assert mesh(26).analysis().largest > 200
    assert ring().analysis().factor_length < 80_000


def test_a_front_too_large_for_its_places_is_a_lack_of_memory(monkeypatch):
    monkeypatch.setattr("mecano.solve.linear.symbolic_analysis.COLUMN_BITS", 3)
    with pytest.raises(MemoryError, match="a front of"):
        mesh(4).analysis()


def test_more_values_than_entries():
    problem = chain(2)
    b, x, y = problem.rhs(), np.empty(22), np.empty(22)
    solver = problem.solver()
    solver.solve(problem.data, b, x)
    solver.solve(np.concatenate([problem.data, [np.nan, 7.0]]), b, y)
    np.testing.assert_array_equal(x, y)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 31, 33, 70, 131, 300])
def test_one_front_with_row_exchanges(n):
    """Random dense matrices need exchanges; fronts beyond 32 and 64 are eliminated in blocks and tiles."""
    problem = Problem(np.random.default_rng(n).standard_normal((n, n)), np.zeros(n, int), n)
    b, x = problem.rhs(), np.empty(n)
    solver = problem.solver()
    status = solver.solve(problem.data, b, x)
    assert status and not status.fallback and status.backward_error <= ACCURATE
    assert problem.error(x, b) <= 10 * ACCURATE
    if n > 30:
        assert np.any(solver._lu.exchanges != np.arange(n))


def test_row_exchanges_in_fronts_with_a_border():
    """Two random diagonal blocks of 150, coupled to a third: exchanges within each, contributions of large fronts."""
    A = np.random.default_rng(0).standard_normal((400, 400))
    A[:150, 150:300] = A[150:300, :150] = 0.0
    problem = Problem(A, np.repeat([0, 1, 2], [150, 150, 100]), 400)
    b, x = problem.rhs(), np.empty(400)
    status = problem.solver().solve(problem.data, b, x)
    assert status and not status.fallback and status.backward_error <= ACCURATE
    assert problem.error(x, b) <= 10 * ACCURATE


@pytest.mark.parametrize("seed", range(40))
def test_random_patterns(seed):
    """Unsymmetric patterns, groups of any size and order, multipliers that tie any number of groups."""
    random = np.random.default_rng(seed)
    n_q, n_l = int(random.integers(1, 40)), int(random.integers(0, 8))
    n_l = min(n_l, n_q)
    S = np.where(random.random((n_q, n_q)) < 0.1, random.standard_normal((n_q, n_q)), 0.0)
    S += np.diag(3.0 + np.abs(S).sum(0) + np.abs(S).sum(1))
    B = np.where(random.random((n_l, n_q)) < 0.1, random.standard_normal((n_l, n_q)), 0.0)
    B[:, :n_l] += 3.0 * np.eye(n_l)
    A = np.block([[S, B.T], [1.1 * B, np.zeros((n_l, n_l))]])
    problem = Problem(A, random.integers(-5, 12, n_q), n_q, seed)
    b, x = problem.rhs(), np.empty(problem.n)
    status = problem.solver().solve(problem.data, b, x)
    assert status and not status.fallback and status.backward_error <= ACCURATE
    np.testing.assert_allclose(x, np.linalg.solve(A, b), rtol=1e-9, atol=1e-11)


def test_zeros_are_left_out_of_the_borders_of_fronts():
    """Of all pairs of nodes that may touch, others do in each matrix: the fronts shrink, and keep nothing."""
    random, nodes, sizes = np.random.default_rng(3), 40, []
    pairs = np.array([(i, j) for i in range(nodes) for j in range(i)])
    n_q, n = 6 * nodes, 6 * nodes + len(pairs)
    rows, cols = np.repeat(np.arange(n_q, n), 12), (6 * pairs[:, :, None] + np.arange(6)).ravel()
    entries = np.concatenate([np.arange(n), rows, cols]), np.concatenate([np.arange(n), cols, rows])
    solver = LinearSolver(Pattern(n, *entries, np.arange(n_q) // 6))
    for share in (0.01, 0.1, 1.0, 0.0, 0.03):
        B = np.repeat(random.random(len(pairs)) < share, 12) * random.standard_normal(len(rows))
        data = np.concatenate([1.0 + random.random(n_q), np.full(n - n_q, -0.1), B, B])
        b, x = random.standard_normal(n), np.zeros(n)
        assert solver.solve(data, b, x).backward_error < ACCURATE
        matrix = sp.coo_matrix((data, entries), shape=(n, n)).tocsc()
        np.testing.assert_allclose(x, spla.spsolve(matrix, b), rtol=0, atol=1e-11 * np.abs(x).max())
        sizes.append(int(solver._lu.sizes.sum()))
    assert sizes[3] < sizes[0] < sizes[4] < sizes[1] < sizes[2] == solver.analysis.fronts[:, SIZE].sum()
    assert sizes[4] < 0.5 * sizes[2]


def test_multipliers_follow_the_last_of_their_unknowns():
    problem = mesh(12)
    place = np.empty(problem.n, int)
    place[problem.solver().order] = np.arange(problem.n)
    below = (problem.rows >= problem.n_q) & (problem.cols < problem.n_q)
    assert below.sum() > 100
    assert np.all(place[problem.rows[below]] > place[problem.cols[below]])
    for group in range(144):  # unknowns of a node stand together
        assert np.ptp(place[: problem.n_q][problem.groups == group]) == 5


def test_only_multipliers_and_single_equations():
    for n_q in (0, 1):
        x = np.empty(1)
        status = Problem([[4.0]], [0] * n_q, n_q).solver().solve(np.array([4.0]), np.array([2.0]), x)
        assert status and x[0] == 0.5


def test_resolve_keeps_the_factors():
    problem = ring()
    solver, b, x = problem.solver(), problem.rhs(2), np.empty(problem.n)
    solver.solve(problem.data, problem.rhs(1), x)
    solver.solve_again(b, x)
    assert problem.error(x, b) <= ACCURATE
    solver.solve_again(b, b)
    np.testing.assert_array_equal(b, x)


def test_same_bits_from_run_to_run():
    problem = mesh(15)
    b = problem.rhs()
    first, again, afresh = np.empty((3, problem.n))
    solver = problem.solver()
    solver.solve(problem.data, b, first)
    solver.solve(1.7 * problem.data, b, again)
    assert not np.array_equal(first, again)
    solver.solve(problem.data, b, again)
    problem.solver().solve(problem.data, b, afresh)
    assert first.tobytes() == again.tobytes() == afresh.tobytes()


def test_backward_error_is_that_of_the_definition():
    problem = chain(3)
    b, x = problem.rhs(3), problem.rhs(4)
    r = np.empty(problem.n)
    error = multifrontal.residual(problem.data, problem.analysis().equations, b, x, r)
    expected = b - problem.matrix @ x
    np.testing.assert_allclose(r, expected, rtol=0, atol=1e-13 * np.abs(expected).max())
    scale = (abs(problem.matrix) @ np.abs(x) + np.abs(b)).max()
    assert error == pytest.approx(np.abs(expected).max() / scale, rel=1e-12)


@pytest.mark.parametrize("size", [1e-280, 1e-300, 1e-318, 3e-323])
def test_a_right_hand_side_that_underflows_is_solved(size):
    """As where all forces have decayed: rounding is absolute there, 5e-324, and no error relative to it counts."""
    problem = chain(30)
    b, x = size * problem.rhs(), np.empty(problem.n)
    status = problem.solver().solve(problem.data, b, x)
    assert status and not status.fallback
    assert np.abs(problem.matrix @ x - b).max() <= max(1e-12 * size, 1e-320)


def two_groups(a):
    """A pivot a that no exchange can replace, small against 1."""
    return Problem([[a, 1.0], [1.0, 1.0]], [0, 1], 2)


def test_small_pivot_is_refined():
    problem, b, x = two_groups(1e-6), np.array([1.0, 3.0]), np.empty(2)
    status = problem.solver(tolerance=0.0).solve(problem.data, b, x)
    assert status and status.refined and not status.fallback
    np.testing.assert_allclose(x, np.linalg.solve(problem.matrix.toarray(), b), rtol=1e-13)


def massless_leaves(n, stiffness):
    """A body that n nodes are clamped to, which have no mass, no penalty and this stiffness: no pivot before that."""
    random = np.random.default_rng(n)
    n_q = 6 * (n + 1)
    A = np.zeros((2 * n_q - 6, 2 * n_q - 6))
    A[:n_q, :n_q] = np.diag(np.repeat([stiffness, 2.0], [n_q - 6, 6]))
    for i in range(n):
        own, own_multipliers = slice(6 * i, 6 * i + 6), slice(n_q + 6 * i, n_q + 6 * i + 6)
        A[own_multipliers, own], A[own_multipliers, n_q - 6 : n_q] = random.standard_normal((2, 6, 6))
    A[:n_q, n_q:] = A[n_q:, :n_q].T
    return Problem(np.where(A == 0.0, 0.0, A), np.arange(n_q) // 6, n_q)


@pytest.mark.parametrize("stiffness, fallback", [(0.0, True), (1e-12, False)])
def test_without_a_pivot_falls_back_and_with_a_tiny_one_refines(stiffness, fallback):
    problem = massless_leaves(8, stiffness)
    b, x, expected = problem.rhs(), np.empty(problem.n), np.linalg.solve(problem.matrix.toarray(), problem.rhs())
    solver = problem.solver()
    status = solver.solve(problem.data, b, x)
    assert status and status.fallback == fallback and status.refined and not status.singular
    assert status.backward_error <= ACCURATE
    np.testing.assert_allclose(x, expected, rtol=1e-9, atol=1e-10 * np.abs(expected).max())
    if fallback:
        solver.solve_again(2.0 * b, x)
        np.testing.assert_allclose(x, 2.0 * expected, rtol=1e-9, atol=1e-10 * np.abs(expected).max())


def test_exchange_within_a_front_needs_no_fallback():
    """No mass, no penalty: only the multiplier holds x0. Without exchange this is hopeless."""
    matrix = np.array([[0.0, 0.0, 1.0], [0.0, 2.0, 1.0], [1.0, 1.0, 0.0]])
    rows, cols = np.divmod(np.arange(9), 3)
    b, x = np.array([1.0, 3.0, 5.0]), np.empty(3)
    for tolerance, fallback in ((0.1, False), (0.0, True)):
        status = LinearSolver(Pattern(3, rows, cols, [0, 1]), tolerance).solve(matrix.ravel(), b, x)
        assert status.ok and status.fallback == fallback and not status.singular
        np.testing.assert_allclose(x, np.linalg.solve(matrix, b), rtol=1e-12)


def redundant_loop(n, k=1.0, spread=0.0):
    """n bodies in a loop, each tied to the next in the same 5 directions: 5 constraints too many.

    Constraints are scaled by k, masses differ by 10**(2 spread).
    """
    random = np.random.default_rng(n)
    P, n_q = random.standard_normal((5, 6)), 6 * n
    S, B = np.zeros((n_q, n_q)), np.zeros((5 * n, n_q))
    for i in range(n):
        j, T = (i + 1) % n, random.standard_normal((6, 6))
        S[6 * i : 6 * i + 6, 6 * i : 6 * i + 6] = (T @ T.T + np.eye(6)) * 10 ** random.uniform(-spread, spread)
        B[5 * i : 5 * i + 5, 6 * i : 6 * i + 6] += P
        B[5 * i : 5 * i + 5, 6 * j : 6 * j + 6] -= P
    A = np.block([[S + k * B.T @ B, k * B.T], [k * B, np.zeros((5 * n, 5 * n))]])
    return Problem(A, np.arange(n_q) // 6, n_q)


@pytest.mark.parametrize("n, k, spread", [(3, 1, 0), (12, 1, 0), (12, 1e3, 0), (20, 1, 3), (60, 1, 2)])
def test_redundant_constraints_are_left_out(n, k, spread):
    problem = redundant_loop(n, k, spread)
    expected, x = problem.rhs(), np.empty(problem.n)
    solver = problem.solver()
    status = solver.solve(problem.data, problem.matrix @ expected, x)
    assert status.ok and status.singular and not status.fallback
    assert status.null_pivots == 5
    left_out = np.flatnonzero(solver.cancellation() <= NULL_PIVOT)
    assert np.all(left_out >= problem.n_q) and len(left_out) == 5
    assert np.all(x[left_out] == 0.0)
    np.testing.assert_allclose(x[: problem.n_q], expected[: problem.n_q], rtol=1e-8, atol=1e-9)
    ratios = np.sort(solver.cancellation())
    assert ratios[4] < 1e-14 and ratios[5] > 1e-7


def test_redundant_constraints_with_a_little_compliance_are_regular():
    loop = redundant_loop(12)
    compliance = np.diag(np.where(np.arange(loop.n) < loop.n_q, 0.0, -1e-10))
    problem, x = Problem(loop.matrix.toarray() + compliance, loop.groups, loop.n_q), np.empty(loop.n)
    expected = problem.rhs()
    status = problem.solver().solve(problem.data, problem.matrix @ expected, x)
    assert status.ok and not status.singular and not status.fallback and status.backward_error <= ACCURATE
    np.testing.assert_allclose(x[: problem.n_q], expected[: problem.n_q], rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize("seed", range(8))
def test_constraint_given_twice_within_a_front(seed):
    """Its diagonal is zero until its unknowns are eliminated, just before itself."""
    random = np.random.default_rng(seed)
    A = np.zeros((8, 8))
    A[:4, :4] = np.eye(4)
    A[4:6, 4:6] = random.standard_normal((2, 2)) + 3.0 * np.eye(2)
    A[6, 4:6] = random.standard_normal(2)
    A[7] = A[6] / 3.0
    A[4:6, 6:] = A[6:, 4:6].T
    problem = Problem(A, np.zeros(6, int), 6)
    x, expected = np.empty(8), problem.rhs()
    status = problem.solver().solve(problem.data, A @ expected, x)
    assert status.ok and status.singular and status.null_pivots == 1
    np.testing.assert_allclose(x[:6], expected[:6], rtol=1e-12)


def test_contradictory_constraints_have_no_solution():
    problem = redundant_loop(4)
    b = problem.rhs()
    status = problem.solver().solve(problem.data, b, np.empty(problem.n))
    assert not status and not status.ok and status.singular and status.finite


def test_cancellation_does_not_depend_on_scaling():
    problem = redundant_loop(5)
    plain, scaled, x = problem.solver(tolerance=0.0), problem.solver(tolerance=0.0), np.empty(problem.n)
    powers = 2.0 ** np.random.default_rng(0).integers(-40, 40, (2, problem.n))
    plain.solve(problem.data, problem.rhs(), x)
    scaled.solve(problem.data * powers[0, problem.rows] * powers[1, problem.cols], problem.rhs(), x)
    np.testing.assert_array_equal(plain.cancellation(), scaled.cancellation())


@pytest.mark.parametrize("b, ok", [([1.0, 0.0], True), ([1.0, 1.0], False)])
def test_empty_row(b, ok):
    """An unknown without any term: fine without a load, else no solution."""
    solver, x = LinearSolver(Pattern(2, [0, 1], [0, 1], [0, 1])), np.empty(2)
    status = solver.solve(np.array([2.0, 0.0]), np.array(b), x)
    assert status.singular and status.ok == ok and status.null_pivots == 1
    assert not ok or (x[0] == 0.5 and x[1] == 0.0)


def test_no_information_lost_is_no_singularity():
    """Stiff against soft by 1e12, without cancellation: neither null nor refined away."""
    solver, x = LinearSolver(Pattern(2, [0, 1], [0, 1], [0, 1])), np.empty(2)
    status = solver.solve(np.array([1e12, 1e-3]), np.array([1e12, 2e-3]), x)
    assert status and not status.singular and not status.fallback
    np.testing.assert_allclose(x, [1.0, 2.0], rtol=1e-15)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("where", ["first", "last", "all", "b"])
def test_non_finite_numbers_are_reported_and_leave_no_trace(bad, where):
    problem = chain(4)
    b, x, before = problem.rhs(), np.empty(problem.n), np.empty(problem.n)
    solver = problem.solver()
    solver.solve(problem.data, b, before)
    data, load = problem.data.copy(), b.copy()
    place = {"first": (data, 0), "last": (data, -1), "all": (data, slice(None)), "b": (load, 7)}[where]
    place[0][place[1]] = bad
    status = solver.solve(data, load, x)
    assert not status.ok and not status.finite and not status.singular
    assert solver.solve(problem.data, b, x)
    np.testing.assert_array_equal(x, before)


def test_overflow_is_no_solution():
    problem = Problem(np.diag([1e-200, 1.0]), [0, 1], 2)
    status = problem.solver().solve(problem.data, np.array([1e200, 1.0]), np.empty(2))
    assert not status.ok and status.finite


def test_pivots_in_the_numbering_of_the_unknowns():
    """Without exchanges their product is the determinant, and that of a multiplier is -B S^-1 B^T."""
    problem, x = chain(3), np.empty(33)
    solver = problem.solver(tolerance=0.0)
    solver.solve(problem.data, problem.rhs(), x)
    sign, logarithm = np.linalg.slogdet(problem.matrix.toarray())
    assert np.prod(np.sign(solver.pivots())) == sign
    assert np.log(np.abs(solver.pivots())).sum() == pytest.approx(logarithm, rel=1e-12)
    small = Problem([[2.0, 3.0], [3.0, 0.0]], [0], 1)
    solver = small.solver()
    solver.solve(small.data, np.ones(2), np.empty(2))
    np.testing.assert_array_equal(solver.pivots(), [2.0, -4.5])


@pytest.mark.parametrize("b", [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
def test_a_null_vector_is_found_whether_or_not_the_residual_excites_it(b):
    """Rows and columns of diag(2, 0, 3): the second unknown is free."""
    singular = ScaledSuperLU(3, np.arange(3), np.arange(3), np.array([2.0, 0.0, 3.0]), 1e-13)
    found = np.abs(singular.driven_null_vector(np.array(b)))
    np.testing.assert_allclose(found, [0.0, 1.0, 0.0], rtol=0, atol=1e-12)


def of_saddle_point(kind, rng):
    """Pattern of a chain of constrained nodes, with unsymmetric random values of the kind."""
    problem = chain(4)
    pattern = Pattern(problem.n, problem.rows, problem.cols, problem.groups)
    values = problem.data * (1.0 + 0.2 * rng.standard_normal(len(problem.data)))
    return pattern, values * np.exp(0.3j) if kind is complex else values


def with_null_pivots(kind, rng, n=400):
    """Pattern of equations each for the next unknown alone, with random values of the kind."""
    values = rng.uniform(1.0, 2.0, n) + (1j * rng.standard_normal(n) if kind is complex else 0.0)
    return Pattern(n, np.arange(n), np.roll(np.arange(n), -1), np.arange(n)), values


@pytest.mark.parametrize("kind", [float, complex])
@pytest.mark.parametrize("case", [of_saddle_point, with_null_pivots])
def test_real_and_complex_factors_solve(kind, case):
    """By the multifrontal solver, and by SuperLU where a pivot in its order is zero."""
    rng = np.random.default_rng(3)
    pattern, values = case(kind, rng)
    b = rng.standard_normal(pattern.n) + (1j * rng.standard_normal(pattern.n) if kind is complex else 0.0)
    found = factors.Factors(pattern, kind)
    found.values[:] = values
    factors.factor(found.record)
    found.right[:] = b
    factors.solve(found.record)
    matrix = sp.csr_matrix((values, (pattern.rows, pattern.cols)))
    assert found.outcome[0] == 0 and found.record["kept"][0] == (case is of_saddle_point)
    np.testing.assert_allclose(matrix @ found.right, b, atol=1e-10 * np.abs(b).max())


@pytest.mark.parametrize("values", [[0.0, 1.0], [np.nan, 1.0]])
def test_factors_of_a_singular_matrix_have_an_outcome(values):
    found = factors.Factors(Pattern(2, np.array([0, 1]), np.array([0, 1]), np.array([0, 1])), float)
    found.values[:] = values
    factors.factor(found.record)
    assert found.outcome[0] != 0 and found.error is None


def test_what_python_raises_in_a_factorization_is_kept(monkeypatch):
    def full(*arguments):
        raise MemoryError

    found = factors.Factors(*with_null_pivots(float, np.random.default_rng(3))[:1], float)
    found.values[:] = 1.0
    monkeypatch.setattr("mecano.solve.linear.scaled_superlu.ScaledSuperLU", full)
    factors.factor(found.record)
    assert found.outcome[0] != 0 and isinstance(found.error, MemoryError)


def test_entry_given_twice_is_refused():
    with pytest.raises(ValueError, match="twice"):
        LinearSolver(Pattern(2, [0, 1, 0], [0, 1, 0], [0, 1]))

"""Factors of real and complex matrices of one pattern, for compiled code: two calls, ``factor`` and ``solve``.

A complex matrix is factored as the real one of twice its size in which an entry x + iy is the block [[x, -y], [y, x]],
so that one solver serves both. Where its fixed order of elimination does not suffice, SuperLU factors with row
exchanges everywhere.
"""

import ctypes
from collections.abc import Callable

import numpy as np

from mecano.jit.entry import PackedCall, Records, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats, integers
from mecano.model.loop_records import Pointers, fields
from mecano.solve.linear import multifrontal
from mecano.solve.linear.sparse import ACCEPT_BELOW, LinearSolver
from mecano.solve.linear.symbolic_analysis import Pattern

# Lengths, and addresses of arrays and functions; ``kept``: the factors are those of the multifrontal solver
FACTORS = fields(
    words="n n_values n_data is_complex values data rows right solution outcome kept "
    "solve solve_words solve_results substitute substitute_words factor_otherwise solve_otherwise"
)


@entry
def factor(matrix: Records(FACTORS)):
    """Factor the matrix; ``outcome`` is zero if it is regular.

    The factors of the multifrontal solver are accepted if no pivot is null and they reproduce a solution of ones.
    """
    m = matrix[0]
    data, rows, b = floats(m.data, m.n_data), integers(m.rows, m.n_data), floats(m.right, m.n)
    if m.is_complex:
        double(floats(m.values, 2 * m.n_values), data)
    b[:] = 0.0
    for i in range(m.n_data):
        b[rows[i]] += data[i]
    call(m.solve, m.solve_words, m.solve_results)
    results = floats(m.solve_results, 3)
    m.kept = 1 if results[0] == 0.0 and results[2] <= ACCEPT_BELOW else 0
    integers(m.outcome, 1)[0] = 0
    if not m.kept:
        call(m.factor_otherwise, 0, 0)


@kernel
def double(values, data_out):
    """Write the blocks [[x, -y], [y, x]] of the entries x + iy, one after the other."""
    for i in range(values.shape[0] // 2):
        x, y = values[2 * i], values[2 * i + 1]
        data_out[4 * i], data_out[4 * i + 1], data_out[4 * i + 2], data_out[4 * i + 3] = x, -y, y, x


@entry
def solve(matrix: Records(FACTORS)):
    """Solve A x = b with the factors; b becomes x."""
    m = matrix[0]
    if not m.kept:
        call(m.solve_otherwise, 0, 0)
        return
    call(m.substitute, m.substitute_words, 0)
    b, x = floats(m.right, m.n), floats(m.solution, m.n)
    for i in range(m.n):
        b[i] = x[i]


class Factors(Pointers):
    """The factors of one matrix at a time.

    Parameters
    ----------
    pattern : Pattern
    dtype : type
        float or complex.

    Attributes
    ----------
    values : (nnz,) float or complex
        Entries of the matrix, in the order of the pattern, to be changed in place.
    right : (n,) float or complex
        Right-hand side, which ``solve`` replaces by the solution.
    outcome : (1,) int64
        Zero if the last ``factor`` found a regular matrix.
    factor, solve : PackedCall
    error : BaseException or None
        Exception that the last call of Python raised; the outcome is then not zero, or the solution nan.
    """

    def __init__(self, pattern: Pattern, dtype: type[float] | type[complex]):
        super().__init__(FACTORS)
        self._pattern, is_complex = pattern, dtype is complex
        self.values, self.right = np.zeros(len(pattern.rows), dtype), np.zeros(pattern.n, dtype)
        self.outcome, right, self.error = np.zeros(1, np.int64), self.right.view(float), None
        real = _doubled(pattern) if is_complex else pattern
        data, solution = np.zeros(len(real.rows)) if is_complex else self.values, np.zeros(real.n)
        linear = LinearSolver(real)
        new, kept = linear.calls(data, right, solution)
        otherwise = [_from_compiled_code(method) for method in (self._factor, self._solve)]
        self._kept = linear, new, kept, otherwise
        self.point_to(
            n=real.n, n_values=len(self.values), n_data=len(data), is_complex=is_complex, values=self.values, data=data,
            rows=np.ascontiguousarray(real.rows, np.int64), right=right, solution=solution, outcome=self.outcome,
            solve=new.function, solve_words=new.words, solve_results=np.zeros(len(multifrontal.solve.returns)),
            substitute=kept.function, substitute_words=kept.words,
            factor_otherwise=otherwise[0].function, solve_otherwise=otherwise[1].function,
        )  # fmt: skip
        self.factor, self.solve = (each.call_from_compiled_code(self.record) for each in (factor, solve))

    def _factor(self, *_):
        """Factor the matrix by SuperLU."""
        from mecano.solve.linear.scaled_superlu import ScaledSuperLU  # hardly any run needs it

        self.outcome[0], self.error, (n, rows, cols) = 1, None, self._pattern[:3]
        try:
            if np.isfinite(self.values).all():
                self._superlu = ScaledSuperLU(n, rows, cols, self.values)
                self.outcome[0] = 0
        except RuntimeError:  # a pivot is zero
            pass
        except BaseException as error:
            self.error = error

    def _solve(self, *_):
        try:
            self.right[:] = self._superlu.solve(self.right)
        except BaseException as error:
            self.right[:], self.error = np.nan, error


def _doubled(pattern: Pattern) -> Pattern:
    """Return the Pattern of the real matrix of twice the size, with its entries block by block."""
    rows = 2 * np.repeat(pattern.rows, 4) + np.tile([0, 0, 1, 1], len(pattern.rows))
    cols = 2 * np.repeat(pattern.cols, 4) + np.tile([0, 1, 0, 1], len(pattern.cols))
    return Pattern(2 * pattern.n, rows, cols, np.repeat(pattern.groups, 2))


def _from_compiled_code(method: Callable[..., None]) -> PackedCall:
    """Return the PackedCall by which compiled code calls a method of Python."""
    function = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(method)
    address = ctypes.cast(function, ctypes.c_void_p).value
    assert address is not None, "a function has an address"
    return PackedCall(address, np.zeros(1, np.int64), [function])

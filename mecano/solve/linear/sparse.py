"""Linear solver for matrices of one pattern; every solution is checked by its residual."""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mecano.jit.named_tuple import spread
from mecano.solve.linear import multifrontal
from mecano.solve.linear.multifrontal import (
    CORRECTION,
    MAGNITUDE,
    PIVOT,
    REFINE_ABOVE,
    RESIDUAL,
    VECTORS,
    Factor,
    Substitution,
)
from mecano.solve.linear.symbolic_analysis import ENTRIES, Analysis, Pattern, analyse, padded, work_length

if TYPE_CHECKING:
    from mecano.jit.entry import PackedCall
    from mecano.model.system import System
    from mecano.solve.linear.scaled_superlu import ScaledSuperLU

ACCEPT_BELOW = 1e-9  # backward error of a solution that is used
MOST_SWEEPS = 8  # of refinement with the factor of a similar matrix, which cost as much as a factorization
SINGULAR_BELOW = 1e-15  # reciprocal condition number of the scaled matrix


class LinearStatus(NamedTuple):
    """Status of a solution; true if it is accurate."""

    ok: bool  # x solves all equations, to a backward error below ACCEPT_BELOW
    backward_error: float  # max |A x - b| / max(|A| |x| + |b|)
    singular: bool = False  # the matrix is singular to working precision; ok: the equations have a solution
    finite: bool = True  # no infinity and no nan in the matrix and in b
    null_pivots: int = 0  # equations omitted from the factorization, their unknowns set to zero
    refined: bool = False
    fallback: bool = False  # by SuperLU, with row exchanges everywhere

    def __bool__(self):
        return self.ok


def pattern_of(system: "System") -> Pattern:
    """Return the Pattern of the tangent of a System."""
    return Pattern(system.n, system.rows, system.cols, system.numbering.group, system.halves)


class LinearSolver:
    """Solves A x = b for many matrices of one pattern."""

    def __init__(self, pattern: Pattern, tolerance: float = 0.1, analysis: Analysis | None = None):
        """Analyse a Pattern; raises ValueError if it has an entry twice.

        Parameters
        ----------
        pattern : Pattern
            If it has parts, two threads factor the two halves.
        tolerance : float
            Rows are exchanged within a front where a pivot is smaller than this times the largest entry of its
            column; 0 never exchanges, so that ``pivots`` belong to equations, too.
        analysis : Analysis, optional
            That of another solver for the same pattern.
        """
        self.pattern, self.n, self.tolerance = pattern, pattern.n, float(tolerance)
        n, analysis = pattern.n, analysis or analyse(pattern)
        self.analysis = analysis
        self.order = analysis.order
        self._equations = analysis.equations
        self._vectors = np.zeros((VECTORS, padded(n)))
        values, exchanges = np.zeros(analysis.factor_length), np.zeros(n, dtype=np.int64)
        fronts, links = analysis.fronts, analysis.links
        sizes, borders = np.zeros(len(fronts), np.int64), np.zeros(int(fronts[0, ENTRIES]), np.uint32)
        self._lu = Factor(analysis.order, fronts, links, sizes, borders, values, exchanges, self._vectors)
        if pattern.parts is None:
            self._bind(analysis)
        else:
            self._bind_divided(analysis)
        self._superlu: ScaledSuperLU | None = None  # the factorization by SuperLU, if the last matrix needed it
        self.label: Any = None  # set and compared by the caller: identifies the factored matrix

    def _bind(self, analysis):
        """Set the compiled functions that factor and substitute, and their constant arguments."""
        self._substitute_arguments: tuple
        self._solve_arguments: tuple
        self._solve, self._substitute = multifrontal.solve, multifrontal.substitute
        scratch = np.zeros(work_length(analysis.largest) + analysis.stack_length)
        self._substitute_arguments = (self._lu,)
        self._solve_arguments = self._lu, scratch, self._equations, self.tolerance, self._substitution()

    def _bind_divided(self, analysis):
        """Set the functions for a model in halves, and their constant arguments."""
        from mecano.solve.linear import divided_multifrontal as divided  # no small model needs it

        self._solve, self._substitute = divided.solve, divided.substitute
        parts = self._parts = divided.Parts(analysis, self.tolerance, self._lu)
        self._substitute_arguments = self._lu, parts.halves
        more = parts.work, self._equations, self.tolerance, self._substitution()
        self._solve_arguments = *self._substitute_arguments, *more

    def _substitution(self):
        """Return the Substitution by which compiled code refines a solution."""
        vectors = self._vectors[:, : self.n]
        self._packed = self._substitute.call_from_compiled_code(
            vectors[RESIDUAL], *self._substitute_arguments, vectors[CORRECTION]
        )
        return Substitution(self._packed.function, self._packed.words.ctypes.data)

    def solve(self, data: np.ndarray, b: np.ndarray, x_out: np.ndarray, label: Any = None) -> LinearStatus:
        """Factor the matrix and solve A x = b; returns a LinearStatus.

        data (>= nnz,): values of the entries, in the order of the pattern. b (n,), x_out (n,): different arrays.
        All are contiguous arrays of floats. x_out holds the best attempt, which may be useless if not ok.
        """
        self._superlu, self.label = None, label
        null, refined, error = self._solve(data, b, *self._solve_arguments, x_out)
        if error <= ACCEPT_BELOW:
            return LinearStatus(True, error, null > 0, True, null, refined)
        return self._solve_with_superlu(data, b, x_out, null)

    def calls(self, data: np.ndarray, b: np.ndarray, x_out: np.ndarray) -> "tuple[PackedCall, PackedCall]":
        """Return the PackedCalls with which compiled code solves A x = b anew, and with the kept factor.

        ``data``: values of A, in the order of the pattern; b and x_out (n,).
        """
        new = self._solve.call_from_compiled_code(data, b, *self._solve_arguments, x_out)
        return new, self._substitute.call_from_compiled_code(b, *self._substitute_arguments, x_out)

    def solved(self, label: Any) -> None:
        """Note that compiled code has factored the matrix of this ``label``."""
        self._superlu, self.label = None, label

    def twin(self) -> "LinearSolver":
        """Return another solver for the same pattern, which keeps factors of its own."""
        return LinearSolver(self.pattern, self.tolerance, self.analysis)

    def solve_similar(self, data: np.ndarray, b: np.ndarray, x_out: np.ndarray) -> bool:
        """Refine ``x_out`` to solve A x = b with the factor of a similar matrix; return whether that converged quickly.

        x_out (n,) holds a guess on entry. The arguments are those of ``solve``.
        """
        r, correction = self._vectors[RESIDUAL, : self.n], np.zeros(self.n)
        error = multifrontal.residual(data, self._equations, b, x_out, r)
        for sweeps in range(MOST_SWEEPS - 1, -1, -1):
            self.solve_again(r, correction)
            x_out += correction
            last, error = error, multifrontal.residual(data, self._equations, b, x_out, r)
            if error <= REFINE_ABOVE:
                return True
            if not error * min(error / last, 1.0) ** sweeps <= REFINE_ABOVE:
                return False
        return False

    @property
    def nbytes(self) -> int:
        """Memory of the factors and of the work arrays [B]."""
        kinds = [*self._solve.parameters.values()][2:-1]
        values = {id(x): x for x in spread(kinds, self._solve_arguments)}
        return sum(x.nbytes for x in values.values() if isinstance(x, np.ndarray))

    @property
    def kept(self) -> bool:
        """True if the last ``solve`` left a multifrontal factor."""
        return self._superlu is None

    def solve_again(self, b: np.ndarray, x_out: np.ndarray) -> None:
        """Solve for ``x_out`` (n,) with the factor of the last ``solve``, without checks; b (n,) may be that array."""
        if self._superlu is None:
            self._substitute(b, *self._substitute_arguments, x_out)
        else:
            x_out[:] = self._superlu.solve(b)

    @property
    def pivots_by_position(self) -> np.ndarray:
        """The diagonal (n,) of U of the last ``solve``, in the order of elimination."""
        return self._vectors[PIVOT, : self.n]

    def pivots(self) -> np.ndarray:
        """Return the diagonal (n,) of U of the last ``solve``, in the numbering of the unknowns."""
        return self._original(self._vectors[PIVOT])

    def cancellation(self) -> np.ndarray:
        """Return the pivots over the largest intermediate value of their diagonal (n,): about 1e-16 for dependent rows.

        Unlike the pivots it is invariant to scaling of rows and columns.
        """
        size = self._original(self._vectors[MAGNITUDE])
        return np.abs(self.pivots()) / np.where(size > 0.0, size, 1.0)

    def _original(self, values):
        out = np.empty(self.n)
        out[self.order] = values[: self.n]
        return out

    @np.errstate(all="ignore")  # overflow shows in the backward error
    def _solve_with_superlu(self, data, b, x_out, null):
        """Solve by SuperLU with partial pivoting after the multifrontal factorization failed; return a LinearStatus."""
        values = data[: len(self.pattern.rows)]
        if not (np.isfinite(values).all() and np.isfinite(b).all()):
            return LinearStatus(False, np.inf, finite=False, null_pivots=null)
        from mecano.solve.linear.scaled_superlu import ScaledSuperLU  # no ordinary run needs it

        try:
            self._superlu = ScaledSuperLU(*self.pattern[:3], values)
        except RuntimeError:  # exactly singular
            return LinearStatus(False, np.inf, singular=True, null_pivots=null, fallback=True)
        x_out[:] = self._superlu.solve(b)
        error = self._backward_error(data, b, x_out)
        if error < np.inf:
            x_out += self._superlu.solve(self._vectors[RESIDUAL, : self.n])
            error = self._backward_error(data, b, x_out)
        singular = self._superlu.reciprocal_condition() < SINGULAR_BELOW
        ok = error <= ACCEPT_BELOW and not singular
        return LinearStatus(ok, error, singular, True, null, True, True)

    def _backward_error(self, data, b, x):
        return multifrontal.residual(data, self._equations, b, x, self._vectors[RESIDUAL])

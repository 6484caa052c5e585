r"""Modal filter: the part of accelerations that a step resolves, without oscillations faster than the step.

.. math:: \begin{bmatrix} S & k B^T \\ k B & 0 \end{bmatrix} \begin{bmatrix} y \\ \mu \end{bmatrix} =
   \begin{bmatrix} c_M M a \\ 0 \end{bmatrix}, \qquad S = K + c_C C + c_M M

with the effective tangent S of a step of size h: a mode of circular frequency omega keeps the share 1/(1 + beta'
omega^2 h^2) of its acceleration. A slow mode keeps its acceleration to O(h^2). A mode far too fast for the step, whose
displacement d has the acceleration omega^2 d, keeps d/(beta' h^2), which displaces it by d in one step. Other weights
of K and M shift the limit to another frequency.

step_change.py filters at the beginning of a step; this module filters at its end, with a factor of its own.
"""

import numpy as np

from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats, integers, items
from mecano.model.assembly import Assembly
from mecano.model.assembly_driver import assemble_lagging, tangent_loops
from mecano.model.loop_records import SYSTEM
from mecano.model.system import System
from mecano.solve.linear import multifrontal
from mecano.solve.linear.newton import soften_tangent
from mecano.solve.linear.sparse import ACCEPT_BELOW, LinearSolver
from mecano.solve.time.workspace import TRIAL, in_own_axes, state_of

NO_LAG = 1e-20  # of constraints on velocities: nothing, but for the own entries of those that are inactive
HARDER = 1e-4  # times the compliances of the step: still far above rounding

# Numbers and addresses of a filter, fields of a record
FLOATS = "cM"  # weight of the masses [1/s^2]
WORDS = (
    "system masses mirrored n_mirrored solve solve_words solve_results substitute substitute_words right solution "
    "pivots"
)


@kernel
def assemble_at_end(w, f, k, penalty, cK, cM):
    """Assemble a tangent of these weights at TRIAL, for variations in its axes.

    Constraints on velocities restrict accelerations as they restrict velocities: their rows are those of the gradients
    by velocities, the columns of their multipliers, instead of those by positions. They have no penalty.
    """
    s, system = state_of(w, TRIAL), items(f.system, 1, SYSTEM)
    assemble_lagging(tangent_loops(w), system, s, in_own_axes(w), k, penalty, cK, 0.0, cM, NO_LAG)
    data, entries = floats(system[0].data, w.nnz), integers(f.mirrored, (f.n_mirrored, 2))
    for i in range(f.n_mirrored):
        data[entries[i, 0]] = data[entries[i, 1]]


@kernel
def keep_masses(w, f):
    """Keep the values (nnz,) of the mass matrix at TRIAL."""
    assemble_at_end(w, f, 1.0, 0.0, 0.0, 1.0)
    data, masses = floats(items(f.system, 1, SYSTEM)[0].data, w.nnz), floats(f.masses, w.nnz)
    for i in range(w.nnz):
        masses[i] = data[i]


@kernel
def factor_filter(w, f, cM):
    """Factor the tangent K + cM M at TRIAL; return whether it is finite.

    The compliances of redundant constraints are scaled with the mobility of the masses, so that the constraints remain
    stiff relative to them. They are smaller than in the step, where they would let some thousandths of an acceleration
    pass if it is short.
    """
    f.cM = cM
    assemble_at_end(w, f, w.k, w.penalty, 1.0, cM)
    soften_tangent(w, items(f.system, 1, SYSTEM)[0], HARDER * min(w.cM / cM, 1.0))
    floats(f.right, w.n)[:] = 0.0
    w.factorizations += 1
    call(f.solve, f.solve_words, f.solve_results)
    return floats(f.solve_results, 3)[2] <= ACCEPT_BELOW


@kernel
def resolve(w, f, a, part_out):
    """Write the part (n_q,) of the accelerations ``a`` (>= n_q,) that the factored filter passes."""
    load_masses(w, f, f.cM, a, floats(f.right, w.n))
    call(f.substitute, f.substitute_words, 0)
    x = floats(f.solution, w.n)
    for i in range(w.n_q):
        part_out[i] = x[i]


@kernel
def load_masses(w, f, cM, a, b_out):
    """Write the right-hand side cM M ``a`` (n,), with the kept masses."""
    masses, rows, columns = floats(f.masses, w.nnz), integers(w.rows, w.nnz), integers(w.columns, w.nnz)
    b_out[:] = 0.0
    for i in range(w.nnz):
        if rows[i] < w.n_q and columns[i] < w.n_q:
            b_out[rows[i]] += masses[i] * a[columns[i]]
    for i in range(w.n):
        b_out[i] *= cM


@kernel
def negative_pivots(w, f):
    """Return the number of negative pivots of the factored tangent."""
    pivots, number = floats(f.pivots, w.n), 0
    for i in range(w.n):
        if pivots[i] < 0.0:
            number += 1
    return number


def filter_fields(system: System, linear: LinearSolver) -> tuple[dict[str, int], tuple[object, ...]]:
    """Return the values of the fields FLOATS and WORDS for a system, and the objects that own the arrays.

    The factor is that of another solver for the pattern of ``linear``. It exchanges no rows, so that the signs of its
    pivots are those of the eigenvalues.
    """
    assembly, solver = Assembly(system), LinearSolver(linear.pattern, 0.0, linear.analysis)
    right, solution = np.zeros(system.n), np.zeros(system.n)
    new, kept = solver.calls(assembly.data, right, solution)
    mirrored = _mirrored(system)
    arrays = {
        "system": assembly.record, "mirrored": mirrored, "masses": np.zeros(system.nnz), "right": right,
        "solution": solution,
        "pivots": solver.pivots_by_position, "solve_results": np.zeros(len(multifrontal.solve.returns)),
        "solve_words": new.words, "substitute_words": kept.words,
    }  # fmt: skip
    values = {name: array.ctypes.data for name, array in arrays.items()}
    values |= {"solve": new.function, "substitute": kept.function, "n_mirrored": len(mirrored)}
    return values, (assembly, solver, new, kept, arrays)


def _mirrored(system):
    """Return the entries (m, 2) of the tangent in rows of constraints on velocities, and those opposite of them."""
    of_rates = np.append(np.zeros(system.n_q, bool), system.numbering.of_rates)
    own = np.flatnonzero(of_rates[system.rows] & (system.cols < system.n_q))
    opposite = np.searchsorted(system.rows * system.n + system.cols, system.cols[own] * system.n + system.rows[own])
    return np.stack([own, opposite], 1).astype(np.int64)

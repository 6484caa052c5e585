r"""Multifrontal LU factorization with a fixed pattern, compiled: factor, substitute, check the backward error.

Each front is a dense matrix over the unknowns that it eliminates (pivots) and those coupled to them (border). Its
entries and the contributions of its children are summed, the pivots are eliminated,

.. math:: F = \begin{bmatrix} F_{11} & F_{12} \\ F_{21} & F_{22} \end{bmatrix}, \quad
          \begin{bmatrix} L_{11} \\ L_{21} \end{bmatrix} U_{11} = \begin{bmatrix} F_{11} \\ F_{21} \end{bmatrix}, \quad
          U_{12} = L_{11}^{-1} F_{12}, \quad C = F_{22} - L_{21} U_{12},

and the contribution C waits on a stack for the parent. The factors of a front are its eliminated columns (L and,
above the diagonal, U11), then the columns of U12. Rows are exchanged among the pivots of a front only, where the
diagonal falls below ``tolerance`` times the largest entry of its column; 0 never exchanges.

A pivot that elimination has cancelled to rounding errors is *null*: its equation is omitted and its unknown set to
zero. The cancellation is measured relative to the largest value that its diagonal has had, which makes the criterion
independent of the scaling of rows and columns. This is correct for redundant constraints; the residual shows if it is
not.

Fixed order, one thread and no fastmath: the same numbers give the same bits. With fastmath, even the process that
compiles would give other bits than those that load its code, since functions are inlined differently. Loops compute
STRIP numbers at once nevertheless (dense_front.py): elementwise, without sums.
"""

from typing import NamedTuple

import numpy as np

from mecano.jit.entry import Indices, Matrix, Short, Table, Vector, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import call, integers
from mecano.solve.linear.dense_front import Front, apply_strip, eliminate_block, part, stride_of, strips
from mecano.solve.linear.symbolic_analysis import (
    BORDER,
    COLUMN_BITS,
    CONTRIBUTION,
    ELDER,
    ENTRIES,
    ENTRY_COUNT,
    FACTOR,
    FIRST,
    LAST_CHILD,
    PARENT_ROWS,
    PIVOTS,
    ROW_BITS,
    SIZE,
    STRIP,
)

# Rows of the work array ``vectors`` (VECTORS, n + STRIP); the first three are by elimination position
PIVOT, INVERSE, MAGNITUDE, PERMUTED, FRONT, RESIDUAL, CORRECTION = range(7)
VECTORS = 7

WHOLE = 32  # unknowns of a border that is not searched for zeros
BLOCK = 32  # pivots eliminated before the rest of a front is updated, multiple of STRIP
REFINE_ABOVE = 1e-13  # backward error
UNDERFLOW = 1e-290  # below it rounding is absolute


class Factor(NamedTuple):
    """A factorization: its pattern (Analysis of symbolic_analysis.py), values, sizes and inverses of the pivots."""

    order: Indices
    fronts: Table
    links: Short
    sizes: Indices  # (n_fronts,) of the fronts without unknowns that only zeros couple to them
    borders: Short  # positions and rows in the parent of their borders, at the same offsets as in links
    values: Vector
    exchanges: Indices
    vectors: Matrix


class Substitution(NamedTuple):
    """The call of ``substitute`` that solves for CORRECTION from RESIDUAL, which are rows of ``vectors``."""

    function: int  # address
    words: int  # address


@kernel
def _assemble(f, data, lu, stack, front_out, magnitude_out):
    """Add entries of the matrix and contributions of the children to a front; record the magnitude of its diagonal."""
    fronts, links, begin = lu.fronts, lu.links, lu.fronts[f, ENTRIES]
    first, pivots, count = fronts[f, FIRST], fronts[f, PIVOTS], fronts[f, ENTRY_COUNT]
    pairs = links[begin : begin + 2 * count]
    row_of = _select_border(f, data, pairs, lu, front_out)
    size = lu.sizes[f]
    stride = stride_of(size)
    for i in range(size * stride):
        front_out[i] = 0.0
    for k in range(count):
        place = pairs[2 * k + 1]
        if size == fronts[f, SIZE]:
            front_out[(place >> ROW_BITS) * stride + (place & COLUMN_BITS)] = data[pairs[2 * k]]
        elif data[pairs[2 * k]] != 0.0:
            front_out[row_of[place >> ROW_BITS] * stride + row_of[place & COLUMN_BITS]] = data[pairs[2 * k]]
    child, rows = fronts[f, LAST_CHILD], integers(row_of.ctypes.data + 8 * row_of.size, row_of.size)
    while child >= 0:
        width = lu.sizes[child] - fronts[child, PIVOTS]
        place = lu.borders[fronts[child, PARENT_ROWS] : fronts[child, PARENT_ROWS] + width]
        begin = fronts[child, CONTRIBUTION]
        for i in range(width):
            rows[i] = row_of[place[i]]
        for i in range(width):
            row = front_out[rows[i] * stride : (rows[i] + 1) * stride]
            addend = stack[begin + i * width : begin + (i + 1) * width]
            for j in range(width):
                row[rows[j]] += addend[j]
        child = fronts[child, ELDER]
    for i in range(pivots):
        magnitude_out[first + i] = max(magnitude_out[first + i], abs(front_out[i * stride + i]))
    border = lu.borders[fronts[f, BORDER] : fronts[f, BORDER] + size - pivots]
    for i in range(size - pivots):
        at = border[i]
        magnitude_out[at] = max(magnitude_out[at], abs(front_out[(pivots + i) * (stride + 1)]))


@kernel
def _select_border(f, data, pairs, lu_out, work):
    """Choose the border of a front, and write its size; return the rows, in the front, of those of its pattern."""
    fronts, links = lu_out.fronts, lu_out.links
    pivots, size, begin, above = fronts[f, PIVOTS], fronts[f, SIZE], fronts[f, BORDER], fronts[f, PARENT_ROWS]
    row_of, whole, n = integers(work.ctypes.data + 8 * size * stride_of(size), size), size - pivots <= WHOLE, pivots
    if not whole:
        _mark_coupled(f, data, pairs, lu_out, row_of)
    for i in range(size if whole else pivots):
        row_of[i] = i
    if whole and lu_out.sizes[f] == size:
        return row_of
    for i in range(size - pivots):
        if row_of[pivots + i]:
            lu_out.borders[begin + n - pivots], lu_out.borders[above + n - pivots] = links[begin + i], links[above + i]
            row_of[pivots + i] = n
            n += 1
    if lu_out.sizes[f] != n:
        lu_out.sizes[f] = n
        columns = lu_out.values[fronts[f, FACTOR] :]
        for i in range(pivots * stride_of(n), stride_of(pivots) * stride_of(n)):
            columns[i] = 0.0
    return row_of


@kernel
def _mark_coupled(f, data, pairs, lu, marks_out):
    """Mark the rows of the pattern of a front to which it has entries, or contributions of children: 1, else 0."""
    for i in range(marks_out.size):
        marks_out[i] = 0
    for k in range(pairs.size // 2):
        if data[pairs[2 * k]] != 0.0:
            marks_out[pairs[2 * k + 1] >> ROW_BITS] = marks_out[pairs[2 * k + 1] & COLUMN_BITS] = 1
    child = lu.fronts[f, LAST_CHILD]
    while child >= 0:
        begin = lu.fronts[child, PARENT_ROWS]
        for i in range(begin, begin + lu.sizes[child] - lu.fronts[child, PIVOTS]):
            marks_out[lu.borders[i]] = 1
        child = lu.fronts[child, ELDER]


@kernel
def _store(f, size, fronts, front, factors_out, stack_out):
    """Store U12 of a front of this size, by columns, and push its contribution on the stack."""
    pivots = fronts[f, PIVOTS]
    stride, height, width = stride_of(size), stride_of(pivots), size - pivots
    begin = fronts[f, FACTOR] + height * stride
    for k in range(pivots):
        row = front[k * stride + pivots : k * stride + size]
        for j in range(row.size):
            factors_out[begin + j * height + k] = row[j]
    begin = fronts[f, CONTRIBUTION]
    for i in range(width):
        kept = stack_out[begin + i * width : begin + (i + 1) * width]
        row = front[(pivots + i) * stride + pivots :]
        for j in range(kept.size):
            kept[j] = row[j]


@kernel
def factor(data, tolerance, scratch, lu_out):
    """Factor the matrix with the values ``data``; returns the number of null pivots."""
    largest, fronts = 0, lu_out.fronts
    for f in range(fronts.shape[0]):
        largest = max(largest, fronts[f, SIZE])
    stack, magnitude = scratch[largest * (stride_of(largest) + 2) :], lu_out.vectors[MAGNITUDE]
    for i in range(magnitude.size):
        magnitude[i] = 0.0
    return factor_fronts(0, fronts.shape[0], data, tolerance, scratch, stack, magnitude, lu_out)


@kernel
def factor_fronts(begin, end, data, tolerance, work, stack, magnitude, lu_out):
    """Factor the fronts begin ... end - 1, whose children are factored; returns the number of null pivots.

    ``work`` holds one front and its rows, ``stack`` the contributions that wait for their parents.
    """
    fronts, pivot, inverse = lu_out.fronts, lu_out.vectors[PIVOT], lu_out.vectors[INVERSE]
    null = 0
    for f in range(begin, end):
        _assemble(f, data, lu_out, stack, work, magnitude)
        first, pivots, size = fronts[f, FIRST], fronts[f, PIVOTS], lu_out.sizes[f]
        columns, exchanges = lu_out.values[fronts[f, FACTOR] :], lu_out.exchanges[first:]
        front = Front(work, columns, pivot[first:], inverse[first:], magnitude[first:], exchanges)
        for k in range(0, pivots, BLOCK):
            null += eliminate_block(k, min(k + BLOCK, pivots), pivots, size, tolerance, front)
        _store(f, size, fronts, work, lu_out.values, stack)
    return null


@kernel
def forward(f, lu, work, y_out):
    """Eliminate the pivots of a front in the right-hand side y (n,), in elimination order."""
    fronts, exchanges = lu.fronts, lu.exchanges
    first, pivots, size = fronts[f, FIRST], fronts[f, PIVOTS], lu.sizes[f]
    stride = stride_of(size)
    columns = lu.values[fronts[f, FACTOR] :]
    border = lu.borders[fronts[f, BORDER] : fronts[f, BORDER] + size - pivots]
    for k in range(pivots):
        work[k] = y_out[first + k]
    for k in range(pivots):
        row = exchanges[first + k]
        value = work[k]
        work[k] = work[row]
        work[row] = value
    for i in range(border.size):
        work[pivots + i] = y_out[border[i]]
    for strip in range(0, pivots, STRIP):
        apply_strip(strip, stride, columns, part(work, 0, stride))
    for k in range(pivots):
        y_out[first + k] = work[k]
    for i in range(border.size):
        y_out[border[i]] = work[pivots + i]


@kernel
def backward(f, lu, work, y_out):
    """Solve for the pivots of a front in y (n,); the border is known."""
    fronts, factors, inverse = lu.fronts, lu.values, lu.vectors[INVERSE]
    first, pivots, size = fronts[f, FIRST], fronts[f, PIVOTS], lu.sizes[f]
    stride, height = stride_of(size), stride_of(pivots)
    border = lu.borders[fronts[f, BORDER] : fronts[f, BORDER] + size - pivots]
    own, scale = part(work, 0, height), part(inverse, first, pivots)
    for k in range(pivots):
        own[k] = y_out[first + k]
    begin, last = fronts[f, FACTOR] + height * stride, border.size // STRIP * STRIP
    for j in range(0, last, STRIP):
        _subtract_strip(
            begin + j * height, height, factors, y_out[border[j]], y_out[border[j + 1]], y_out[border[j + 2]],
            y_out[border[j + 3]], own,
        )  # fmt: skip
    for j in range(last, border.size):
        _subtract_column(part(factors, begin + j * height, height), y_out[border[j]], own)
    columns, last = part(factors, fronts[f, FACTOR], height * stride), pivots // STRIP * STRIP
    for k in range(pivots - 1, last - 1, -1):
        own[k] *= scale[k]
        _subtract_column(part(columns, k * stride, k), own[k], part(own, 0, k))
    for k in range(last - STRIP, -1, -STRIP):
        at = k * stride + k
        x3 = own[k + 3] * scale[k + 3]
        x2 = (own[k + 2] - columns[at + 3 * stride + 2] * x3) * scale[k + 2]
        x1 = (own[k + 1] - columns[at + 3 * stride + 1] * x3 - columns[at + 2 * stride + 1] * x2) * scale[k + 1]
        x0 = own[k] - columns[at + 3 * stride] * x3 - columns[at + 2 * stride] * x2 - columns[at + stride] * x1
        own[k], own[k + 1], own[k + 2], own[k + 3] = x0 * scale[k], x1, x2, x3
        _subtract_strip((k + 3) * stride, -stride, columns, x3, x2, x1, own[k], part(own, 0, k))
    for k in range(pivots):
        y_out[first + k] = own[k]


@kernel
def _subtract_column(column, x, out):
    """Subtract the column times x from ``out``."""
    whole = out.size // STRIP * STRIP
    groups, subtracted = strips(out, 0, whole), strips(column, 0, whole)
    for i in range(groups.size):
        groups[i] -= subtracted[i] * x
    for i in range(whole, out.size):
        out[i] -= column[i] * x


@kernel
def _subtract_strip(begin, step, columns, x0, x1, x2, x3, out):
    """Subtract STRIP columns, of which the next begins a ``step`` later, one after the other from ``out``.

    The length of ``out`` is a multiple of STRIP.
    """
    n = out.size
    groups, c0, c1 = strips(out, 0, n), strips(columns, begin, n), strips(columns, begin + step, n)
    c2, c3 = strips(columns, begin + 2 * step, n), strips(columns, begin + 3 * step, n)
    for i in range(groups.size):
        groups[i] = groups[i] - c0[i] * x0 - c1[i] * x1 - c2[i] * x2 - c3[i] * x3


@entry
def substitute(b: Vector, lu: Factor, x_out: Vector):
    """Solve with the kept factors: x_out (n,) from b (n,); b and x_out may be the same array."""
    order, n_fronts, y, work = lu.order, lu.fronts.shape[0], lu.vectors[PERMUTED], lu.vectors[FRONT]
    for i in range(order.size):
        y[i] = b[order[i]]
    for f in range(n_fronts):
        forward(f, lu, work, y)
    for f in range(n_fronts - 1, -1, -1):
        backward(f, lu, work, y)
    for i in range(order.size):
        x_out[order[i]] = y[i]


@entry
def residual(data: Vector, equations: Short, b: Vector, x: Vector, residual_out: Vector) -> float:
    """Compute r = b - A x; return the backward error max |r| / max(|A| |x| + |b|), infinite if not finite.

    Oettli & Prager 1964, with the norms taken over all equations. Zero for b = 0 and x = 0, up to underflow.
    """
    n = b.size
    count = equations[n]
    columns, sources = equations[n + 1 : n + 1 + count], equations[n + 1 + count :]
    largest = scale = total = 0.0
    for i in range(n):
        r, size = b[i], abs(b[i])
        begin, end = equations[i], equations[i + 1]
        column, source = columns[begin:end], sources[begin:end]
        for k in range(column.size):
            product = data[source[k]] * x[column[k]]
            r -= product
            size += abs(product)
        residual_out[i] = r
        largest, scale, total = max(largest, abs(r)), max(scale, size), total + size
    if not total < np.inf:
        return np.inf
    return largest / scale if scale > UNDERFLOW else 0.0


@entry
def solve(
    data: Vector, b: Vector, lu: Factor, scratch: Vector, equations: Short, tolerance: float, again: Substitution,
    x_out: Vector,
) -> (int, bool, float):  # fmt: skip
    """Factor, solve A x = b, and refine once if that helps: (null pivots, refined, backward error).

    ``lu`` is overwritten; ``scratch`` holds a front, its rows and the stack, ``equations`` the pattern by rows.
    """
    null = factor(data, tolerance, scratch, lu)
    refined, error = refine(data, b, equations, lu.vectors, again, x_out)
    return null, refined, error


@kernel
def refine(data, b, equations, vectors, again, x_out):
    """Solve A x = b with the present factors, and refine once if that helps: (refined, backward error)."""
    n = b.size
    remainder, correction = vectors[RESIDUAL][:n], vectors[CORRECTION]
    for i in range(n):
        remainder[i] = b[i]
        x_out[i] = 0.0
    error, sweeps = np.inf, 0
    while sweeps == 0 or (sweeps == 1 and REFINE_ABOVE < error < np.inf):
        call(again.function, again.words, 0)
        for i in range(n):
            x_out[i] += correction[i]
        error = residual(data, equations, b, x_out, remainder)
        sweeps += 1
    return sweeps > 1, error

r"""Multifrontal LU factorization with a fixed pattern, compiled: factor, substitute, check the backward error.

Each front is a dense matrix over the unknowns that it eliminates (pivots) and those coupled to them (border). Its
entries and the contributions of its children are summed, the pivots are eliminated,

.. math:: F = \begin{bmatrix} F_{11} & F_{12} \\ F_{21} & F_{22} \end{bmatrix}, \quad
          \begin{bmatrix} L_{11} \\ L_{21} \end{bmatrix} U_{11} = \begin{bmatrix} F_{11} \\ F_{21} \end{bmatrix}, \quad
          U_{12} = L_{11}^{-1} F_{12}, \quad C = F_{22} - L_{21} U_{12},

and the contribution C waits on a stack for the parent. The factors of a front are its eliminated columns (L and,
above the diagonal, U11), then the columns of U12. Rows are exchanged among the pivots of a front only, where the
diagonal falls below ``tolerance`` times the largest entry of its column; 0 never exchanges.

Rows of a front and columns of L are stored with a stride rounded up to STRIP, and so is the number of columns of L:
columns beyond the pivots stay zero, values beyond the last row of a column are never used.

A pivot that elimination has cancelled to rounding errors is *null*: its equation is omitted and its unknown set to
zero. The cancellation is measured relative to the largest value that its diagonal has had, which makes the criterion
independent of the scaling of rows and columns. This is correct for redundant constraints; the residual shows if it is
not.

Fixed order, one thread and no fastmath: the same numbers give the same bits. With fastmath, even the process that
compiles would give other bits than those that load its code, since functions are inlined differently. Loops are written
so that they are vectorized nevertheless: elementwise, without sums.
"""

import numpy as np

from mecano.jit.entry import Indices, Matrix, Short, Table, Vector, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import call
from mecano.solve.linear.ordering import (
    BORDER,
    CONTRIBUTION,
    ELDER,
    ENTRIES,
    ENTRY_COUNT,
    FACTOR,
    FIRST,
    LAST_CHILD,
    PARENT_ROWS,
    PIVOTS,
    SIZE,
    STRIP,
)

# Rows of the work array ``vectors`` (VECTORS, n + STRIP); the first three are by elimination position
PIVOT, INVERSE, MAGNITUDE, PERMUTED, FRONT, RESIDUAL, CORRECTION = range(7)
VECTORS = 7

BLOCK = 32  # pivots eliminated before the rest of a front is updated, multiple of STRIP
TILE_ROWS, TILE_COLUMNS = 64, 256  # part of a front updated at once, to stay in cache

NULL_PIVOT = 1e-14  # of the largest value the diagonal has had
REFINE_ABOVE = 1e-13  # backward error


@kernel
def _stride(size):
    return (size + STRIP - 1) // STRIP * STRIP


@kernel
def _assemble(f, data, fronts, links, stack, front_out, magnitude_out):
    """Add entries of the matrix and contributions of the children to a front; record the magnitude of its diagonal."""
    first, pivots, size = fronts[f, FIRST], fronts[f, PIVOTS], fronts[f, SIZE]
    stride = _stride(size)
    for i in range(size * stride):
        front_out[i] = 0.0
    begin, count = fronts[f, ENTRIES], fronts[f, ENTRY_COUNT]
    pairs = links[begin : begin + 2 * count]
    for k in range(count):
        front_out[pairs[2 * k + 1]] = data[pairs[2 * k]]
    child = fronts[f, LAST_CHILD]
    while child >= 0:
        width = fronts[child, SIZE] - fronts[child, PIVOTS]
        place = links[fronts[child, PARENT_ROWS] : fronts[child, PARENT_ROWS] + width]
        begin = fronts[child, CONTRIBUTION]
        for i in range(width):
            row = front_out[place[i] * stride : (place[i] + 1) * stride]
            addend = stack[begin + i * width : begin + (i + 1) * width]
            for j in range(width):
                row[place[j]] += addend[j]
        child = fronts[child, ELDER]
    for i in range(pivots):
        magnitude_out[first + i] = max(magnitude_out[first + i], abs(front_out[i * stride + i]))
    border = links[fronts[f, BORDER] : fronts[f, BORDER] + size - pivots]
    for i in range(size - pivots):
        at = border[i]
        magnitude_out[at] = max(magnitude_out[at], abs(front_out[(pivots + i) * (stride + 1)]))


@kernel
def _choose_row(column, k, pivots, tolerance):
    """Return the pivot row of column k: k itself unless its value is small relative to the largest pivot row."""
    best, largest = k, abs(column[k])
    limit = largest
    for i in range(k + 1, pivots):
        if abs(column[i]) > largest:
            best, largest = i, abs(column[i])
    return k if limit >= tolerance * largest else best


@kernel
def _exchange(i, j, end, stride, front_out, columns_out):
    """Exchange rows i and j: of the ``end`` columns already taken out of the front, and of the rest of the front."""
    for c in range(0, end * stride, stride):
        value = columns_out[c + i]
        columns_out[c + i] = columns_out[c + j]
        columns_out[c + j] = value
    for c in range(end, stride):
        value = front_out[i * stride + c]
        front_out[i * stride + c] = front_out[j * stride + c]
        front_out[j * stride + c] = value


@kernel
def _eliminate_strip(
    begin, end, block_end, pivots, stride, tolerance,  # in
    front_out, columns_out, pivot_out, inverse_out, magnitude_out, exchanges_out,  # out, from the first pivot on
):  # fmt: skip
    """Factor the columns begin ... end - 1 of a front, right-looking; returns the number of null pivots."""
    null = 0
    for c in range(begin, block_end):
        magnitude_out[c] = max(magnitude_out[c], abs(columns_out[c * stride + c]))
    for k in range(begin, end):
        column = columns_out[k * stride : (k + 1) * stride]
        row = _choose_row(column, k, pivots, tolerance) if tolerance > 0.0 else k
        exchanges_out[k] = row
        if row != k:
            _exchange(k, row, block_end, stride, front_out, columns_out)
        pivot_out[k] = column[k]
        factor = 1.0 / column[k]
        if abs(column[k]) <= NULL_PIVOT * magnitude_out[k]:
            factor = 0.0
            null += 1
        inverse_out[k] = factor
        lower = column[k + 1 :]
        for i in range(lower.size):
            lower[i] *= factor
        for c in range(k + 1, end):
            magnitude_out[c] = max(magnitude_out[c], abs(columns_out[c * stride + c]))
            other = columns_out[c * stride + k + 1 : (c + 1) * stride]
            u = columns_out[c * stride + k]
            for i in range(other.size):
                other[i] -= lower[i] * u
    return null


@kernel
def _apply_strip(begin, stride, columns, targets_out):
    """Eliminate the STRIP pivots from ``begin`` in further columns or right-hand sides, one after the other."""
    at = begin * stride + begin
    l0, l1 = columns[at : at + stride - begin], columns[at + stride : at + 2 * stride - begin]
    l2, l3 = columns[at + 2 * stride : at + 3 * stride - begin], columns[at + 3 * stride : at + 4 * stride - begin]
    for c in range(targets_out.size // stride):
        target = targets_out[c * stride + begin : (c + 1) * stride]
        u0 = target[0]
        u1 = target[1] - l0[1] * u0
        u2 = target[2] - l0[2] * u0 - l1[2] * u1
        u3 = target[3] - l0[3] * u0 - l1[3] * u1 - l2[3] * u2
        target[1], target[2], target[3] = u1, u2, u3
        for i in range(STRIP, target.size):
            target[i] -= l0[i] * u0 + l1[i] * u1 + l2[i] * u2 + l3[i] * u3


@kernel
def _update(begin, last, rows_begin, rows_end, left, right, stride, columns, front_out):
    """Subtract from rows and columns [left, right) of a front the products of the STRIP pivots from ``begin``.

    Pivots beyond ``last`` do not exist; their columns are zero, so that any row can be used for them.
    """
    r1, r2, r3 = min(begin + 1, last) * stride, min(begin + 2, last) * stride, min(begin + 3, last) * stride
    u0 = front_out[begin * stride + left : begin * stride + right]
    u1, u2, u3 = front_out[r1 + left : r1 + right], front_out[r2 + left : r2 + right], front_out[r3 + left : r3 + right]
    for i in range(rows_begin, rows_end):
        at = begin * stride + i
        x0, x1, x2, x3 = columns[at], columns[at + stride], columns[at + 2 * stride], columns[at + 3 * stride]
        row = front_out[i * stride + left : i * stride + right]
        for j in range(row.size):
            row[j] -= x0 * u0[j] + x1 * u1[j] + x2 * u2[j] + x3 * u3[j]


@kernel
def _update_pivot_rows(begin, end, left, right, stride, columns, front_out):
    """Compute the rows begin ... end - 1 of U, columns [left, right)."""
    for strip in range(begin, end, STRIP):
        strip_end = min(strip + STRIP, end)
        for k in range(strip + 1, strip_end):
            row = front_out[k * stride + left : k * stride + right]
            for c in range(strip, k):
                above, x = front_out[c * stride + left : c * stride + right], columns[c * stride + k]
                for j in range(row.size):
                    row[j] -= x * above[j]
        _update(strip, strip_end - 1, strip_end, end, left, right, stride, columns, front_out)


@kernel
def _eliminate_block(
    begin, end, pivots, size, tolerance,  # in
    front_out, columns_out, pivot_out, inverse_out, magnitude_out, exchanges_out,  # out, from the first pivot on
):  # fmt: skip
    """Eliminate the pivots begin ... end - 1 of a front; returns the number of null pivots.

    The columns of the block are finished first, with all their row exchanges; only then are the columns to the right
    updated, with rows in their final order.
    """
    stride = _stride(size)
    null = 0
    for k in range(begin, end):
        column = columns_out[k * stride : (k + 1) * stride]
        for i in range(size):
            column[i] = front_out[i * stride + k]
    for strip in range(begin, end, STRIP):
        strip_end = min(strip + STRIP, end)
        null += _eliminate_strip(
            strip, strip_end, end, pivots, stride, tolerance,
            front_out, columns_out, pivot_out, inverse_out, magnitude_out, exchanges_out,
        )  # fmt: skip
        _apply_strip(strip, stride, columns_out, columns_out[strip_end * stride : end * stride])
    for left in range(end, stride, TILE_COLUMNS):
        right = min(left + TILE_COLUMNS, stride)
        _update_pivot_rows(begin, end, left, right, stride, columns_out, front_out)
        for top in range(end, size, TILE_ROWS):
            bottom = min(top + TILE_ROWS, size)
            for strip in range(begin, end, STRIP):
                _update(strip, end - 1, top, bottom, left, right, stride, columns_out, front_out)
    return null


@kernel
def _store(f, fronts, front, factors_out, stack_out):
    """Store U12 of a front, by columns, and push its contribution on the stack."""
    pivots, size = fronts[f, PIVOTS], fronts[f, SIZE]
    stride, width = _stride(size), size - pivots
    begin = fronts[f, FACTOR] + _stride(pivots) * stride
    for k in range(pivots):
        row = front[k * stride + pivots : k * stride + size]
        for j in range(row.size):
            factors_out[begin + j * pivots + k] = row[j]
    begin = fronts[f, CONTRIBUTION]
    for i in range(width):
        kept = stack_out[begin + i * width : begin + (i + 1) * width]
        row = front[(pivots + i) * stride + pivots :]
        for j in range(kept.size):
            kept[j] = row[j]


@kernel
def factor(data, fronts, links, tolerance, scratch, factors_out, vectors_out, exchanges_out):
    """Factor the matrix with the values ``data``; returns the number of null pivots."""
    largest = 0
    for f in range(fronts.shape[0]):
        largest = max(largest, fronts[f, SIZE])
    front, stack, magnitude = scratch, scratch[largest * _stride(largest) :], vectors_out[MAGNITUDE]
    for i in range(magnitude.size):
        magnitude[i] = 0.0
    return factor_fronts(
        0, fronts.shape[0], data, fronts, links, tolerance, front, stack, factors_out, vectors_out, magnitude,
        exchanges_out,
    )  # fmt: skip


@kernel
def factor_fronts(
    begin, end, data, fronts, links, tolerance,  # in
    front, stack, factors_out, vectors_out, magnitude, exchanges_out,  # work arrays, out
):  # fmt: skip
    """Factor the fronts begin ... end - 1, whose children are factored; returns the number of null pivots."""
    null, pivot, inverse = 0, vectors_out[PIVOT], vectors_out[INVERSE]
    for f in range(begin, end):
        _assemble(f, data, fronts, links, stack, front, magnitude)
        first, pivots, size = fronts[f, FIRST], fronts[f, PIVOTS], fronts[f, SIZE]
        columns, exchanges = factors_out[fronts[f, FACTOR] :], exchanges_out[first:]
        for k in range(0, pivots, BLOCK):
            null += _eliminate_block(
                k, min(k + BLOCK, pivots), pivots, size, tolerance,
                front, columns, pivot[first:], inverse[first:], magnitude[first:], exchanges,
            )  # fmt: skip
        _store(f, fronts, front, factors_out, stack)
    return null


@kernel
def forward(f, fronts, links, factors, exchanges, work, y_out):
    """Eliminate the pivots of a front in the right-hand side y (n,), in elimination order."""
    first, pivots, size = fronts[f, FIRST], fronts[f, PIVOTS], fronts[f, SIZE]
    stride = _stride(size)
    columns = factors[fronts[f, FACTOR] :]
    border = links[fronts[f, BORDER] : fronts[f, BORDER] + size - pivots]
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
        _apply_strip(strip, stride, columns, work[:stride])
    for k in range(pivots):
        y_out[first + k] = work[k]
    for i in range(border.size):
        y_out[border[i]] = work[pivots + i]


@kernel
def backward(f, fronts, links, factors, inverse, y_out):
    """Solve for the pivots of a front in y (n,); the border is known."""
    first, pivots, size = fronts[f, FIRST], fronts[f, PIVOTS], fronts[f, SIZE]
    stride = _stride(size)
    border = links[fronts[f, BORDER] : fronts[f, BORDER] + size - pivots]
    own = y_out[first : first + pivots]
    begin = fronts[f, FACTOR] + _stride(pivots) * stride
    for j in range(border.size):
        column, x = factors[begin + j * pivots : begin + (j + 1) * pivots], y_out[border[j]]
        for i in range(own.size):
            own[i] -= column[i] * x
    for k in range(pivots - 1, -1, -1):
        x = own[k] * inverse[first + k]
        own[k] = x
        begin = fronts[f, FACTOR] + k * stride
        above = factors[begin : begin + k]
        for i in range(above.size):
            own[i] -= above[i] * x


@entry
def substitute(
    b: Vector, order: Indices, fronts: Table, links: Short, factors: Vector, exchanges: Indices, vectors: Matrix,
    x_out: Vector,
):  # fmt: skip
    """Solve with the kept factors: x_out (n,) from b (n,); b and x_out may be the same array."""
    y, work, inverse = vectors[PERMUTED], vectors[FRONT], vectors[INVERSE]
    for i in range(order.size):
        y[i] = b[order[i]]
    for f in range(fronts.shape[0]):
        forward(f, fronts, links, factors, exchanges, work, y)
    for f in range(fronts.shape[0] - 1, -1, -1):
        backward(f, fronts, links, factors, inverse, y)
    for i in range(order.size):
        x_out[order[i]] = y[i]


@entry
def residual(data: Vector, equations: Short, b: Vector, x: Vector, residual_out: Vector) -> float:
    """Compute r = b - A x; return the backward error max |r| / max(|A| |x| + |b|), infinite if not finite.

    Oettli & Prager 1964, with the norms taken over all equations. Zero for b = 0 and x = 0.
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
    return largest / scale if scale > 0.0 else 0.0


@entry
def solve(
    # in
    data: Vector, b: Vector,
    # pattern
    fronts: Table, links: Short, equations: Short, tolerance: float,
    # kept
    scratch: Vector, factors: Vector, vectors: Matrix, exchanges: Indices,
    # ``substitute``: its address, and that of its arguments, which solve for CORRECTION from RESIDUAL
    substitution: int, words: int,
    # out
    x_out: Vector,
) -> (int, bool, float):  # fmt: skip
    """Factor, solve A x = b, and refine once if that helps: (null pivots, refined, backward error)."""
    null = factor(data, fronts, links, tolerance, scratch, factors, vectors, exchanges)
    refined, error = refine(data, b, equations, vectors, substitution, words, x_out)
    return null, refined, error


@kernel
def refine(data, b, equations, vectors, substitution, words, x_out):
    """Solve A x = b with the present factors, and refine once if that helps: (refined, backward error)."""
    n = b.size
    remainder, correction = vectors[RESIDUAL][:n], vectors[CORRECTION]
    for i in range(n):
        remainder[i] = b[i]
        x_out[i] = 0.0
    error, sweeps = np.inf, 0
    while sweeps == 0 or (sweeps == 1 and REFINE_ABOVE < error < np.inf):
        call(substitution, words, 0)
        for i in range(n):
            x_out[i] += correction[i]
        error = residual(data, equations, b, x_out, remainder)
        sweeps += 1
    return sweeps > 1, error

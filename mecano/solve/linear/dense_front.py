"""Elimination of the pivots of one dense front, in blocks of columns: L and U, and the update of the rest.

Rows of a front and columns of L are stored with a stride rounded up to STRIP, and so is the number of columns of L:
columns beyond the pivots stay zero, values beyond the last row of a column are never used.

Loops along rows and columns compute STRIP numbers at once, by the instructions that processors have for it: most fronts
are so small that a loop that a compiler divides into such groups and a remainder would spend its time in the remainder.
A group may include numbers that are no longer used.
"""

from typing import NamedTuple

from mecano.jit.entry import Indices, Vector
from mecano.jit.kernel import kernel
from mecano.jit.memory import floats, lanes
from mecano.solve.linear.symbolic_analysis import STRIP

TILE_ROWS, TILE_COLUMNS = 64, 256  # part of a front updated at once, to stay in cache
NULL_PIVOT = 1e-14  # of the largest value the diagonal has had


class Front(NamedTuple):
    """A front while it is eliminated; all but its values are parts of larger arrays, from its first pivot on."""

    values: Vector  # rows one after the other
    columns: Vector  # of L, eliminated
    pivot: Vector
    inverse: Vector
    magnitude: Vector  # largest value that each diagonal has had
    exchanges: Indices  # row with which that of each pivot was exchanged


@kernel
def part(vector, begin, n):
    """Return ``vector[begin : begin + n]``; a slice in numba takes a dozen more instructions."""
    return floats(vector.ctypes.data + 8 * begin, n)


@kernel
def strips(vector, begin, n):
    """Return ``vector[begin : begin + n]`` in groups of STRIP numbers, computed at once; STRIP divides n."""
    return lanes(vector.ctypes.data + 8 * begin, n // STRIP)


@kernel
def stride_of(size):
    """Return the stride of rows or columns of this size."""
    return (size + STRIP - 1) // STRIP * STRIP


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
    """Exchange rows i and j: of the ``end`` columns already eliminated from the front, and of the rest of the front."""
    for c in range(0, end * stride, stride):
        value = columns_out[c + i]
        columns_out[c + i] = columns_out[c + j]
        columns_out[c + j] = value
    for c in range(end, stride):
        value = front_out[i * stride + c]
        front_out[i * stride + c] = front_out[j * stride + c]
        front_out[j * stride + c] = value


@kernel
def _eliminate_strip(begin, end, block_end, pivots, stride, tolerance, front_out):
    """Factor the columns begin ... end - 1 of a Front, right-looking; returns the number of null pivots."""
    values_out, columns_out, pivot_out, inverse_out, magnitude_out, exchanges_out = front_out
    null, below = 0, begin + STRIP
    for c in range(begin, block_end):
        magnitude_out[c] = max(magnitude_out[c], abs(columns_out[c * stride + c]))
    for k in range(begin, end):
        column = columns_out[k * stride : (k + 1) * stride]
        row = _choose_row(column, k, pivots, tolerance) if tolerance > 0.0 else k
        exchanges_out[k] = row
        if row != k:
            _exchange(k, row, block_end, stride, values_out, columns_out)
        pivot_out[k] = column[k]
        factor = 1.0 / column[k]
        if abs(column[k]) <= NULL_PIVOT * magnitude_out[k]:
            factor = 0.0
            null += 1
        inverse_out[k] = factor
        for i in range(k + 1, below):
            column[i] *= factor
        lower = strips(columns_out, k * stride + below, stride - below)
        for i in range(lower.size):
            lower[i] *= factor
        for c in range(k + 1, end):
            magnitude_out[c] = max(magnitude_out[c], abs(columns_out[c * stride + c]))
            other, rest = columns_out[c * stride :], strips(columns_out, c * stride + below, stride - below)
            u = other[k]
            if u == 0.0:
                continue
            for i in range(k + 1, below):
                other[i] -= column[i] * u
            for i in range(rest.size):
                rest[i] -= lower[i] * u
    return null


@kernel
def apply_strip(begin, stride, columns, targets_out):
    """Eliminate the STRIP pivots from ``begin`` in further columns or right-hand sides, one after the other."""
    n, at = stride - begin - STRIP, begin * stride + begin
    below = at + STRIP
    l0, l1 = strips(columns, below, n), strips(columns, below + stride, n)
    l2, l3 = strips(columns, below + 2 * stride, n), strips(columns, below + 3 * stride, n)
    for c in range(targets_out.size // stride):
        top = part(targets_out, c * stride + begin, STRIP)
        u0 = top[0]
        u1 = top[1] - columns[at + 1] * u0
        u2 = top[2] - columns[at + 2] * u0 - columns[at + stride + 2] * u1
        u3 = top[3] - columns[at + 3] * u0 - columns[at + stride + 3] * u1 - columns[at + 2 * stride + 3] * u2
        if u0 == 0.0 and u1 == 0.0 and u2 == 0.0 and u3 == 0.0:
            continue
        top[1], top[2], top[3] = u1, u2, u3
        rest = strips(targets_out, c * stride + begin + STRIP, n)
        for i in range(rest.size):
            rest[i] -= l0[i] * u0 + l1[i] * u1 + l2[i] * u2 + l3[i] * u3


@kernel
def _update(begin, last, rows_begin, rows_end, left, right, stride, columns, front_out):
    """Subtract from rows and columns [left, right) of a front the products of the STRIP pivots from ``begin``.

    ``left`` and ``right`` are multiples of STRIP. Pivots beyond ``last`` do not exist; their columns are zero, so that
    any row can be used for them.
    """
    n, at = right - left, begin * stride + left
    r1, r2, r3 = min(begin + 1, last) * stride, min(begin + 2, last) * stride, min(begin + 3, last) * stride
    u0, u1 = strips(front_out, at, n), strips(front_out, r1 + left, n)
    u2, u3 = strips(front_out, r2 + left, n), strips(front_out, r3 + left, n)
    for i in range(rows_begin, rows_end):
        at = begin * stride + i
        x0, x1, x2, x3 = columns[at], columns[at + stride], columns[at + 2 * stride], columns[at + 3 * stride]
        if x0 == 0.0 and x1 == 0.0 and x2 == 0.0 and x3 == 0.0:  # most are, of contacts that are open
            continue
        row = strips(front_out, i * stride + left, n)
        for j in range(row.size):
            row[j] -= x0 * u0[j] + x1 * u1[j] + x2 * u2[j] + x3 * u3[j]


@kernel
def _update_pivot_rows(begin, end, left, right, stride, columns, front_out):
    """Compute the rows begin ... end - 1 of U, columns [left, right)."""
    for strip in range(begin, end, STRIP):
        strip_end = min(strip + STRIP, end)
        for k in range(strip + 1, strip_end):
            row = strips(front_out, k * stride + left, right - left)
            for c in range(strip, k):
                above, x = strips(front_out, c * stride + left, right - left), columns[c * stride + k]
                for j in range(row.size):
                    row[j] -= x * above[j]
        _update(strip, strip_end - 1, strip_end, end, left, right, stride, columns, front_out)


@kernel
def eliminate_block(begin, end, pivots, size, tolerance, front_out):
    """Eliminate the pivots begin ... end - 1 of a Front; returns the number of null pivots.

    The columns of the block are finished first, with all their row exchanges; only then are the columns to the right
    updated, with rows in their final order.
    """
    stride, values_out, columns_out = stride_of(size), front_out.values, front_out.columns
    null = 0
    for k in range(begin, end):
        column = columns_out[k * stride : (k + 1) * stride]
        for i in range(size):
            column[i] = values_out[i * stride + k]
    for strip in range(begin, end, STRIP):
        strip_end = min(strip + STRIP, end)
        null += _eliminate_strip(strip, strip_end, end, pivots, stride, tolerance, front_out)
        right = part(columns_out, strip_end * stride, (end - strip_end) * stride)
        apply_strip(strip, stride, columns_out, right)
    for left in range(end // STRIP * STRIP, stride, TILE_COLUMNS):
        right = min(left + TILE_COLUMNS, stride)
        _update_pivot_rows(begin, end, left, right, stride, columns_out, values_out)
        for top in range(end, size, TILE_ROWS):
            bottom = min(top + TILE_ROWS, size)
            for strip in range(begin, end, STRIP):
                _update(strip, end - 1, top, bottom, left, right, stride, columns_out, values_out)
    return null

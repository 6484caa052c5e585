"""Multifrontal factorization of a matrix in halves (model/halves.py), by two threads.

The fronts of a half form subtrees of their own; the unknowns between the halves are eliminated after both. Each half
has its own work arrays (OWN), in which it also collects its terms in the equations between the halves: they are added
in a fixed order, so that the bits do not depend on the number of threads.
"""

import numpy as np

from mecano.jit import thread_pool
from mecano.jit.entry import Indices, Matrices, Matrix, Short, Table, Vector, entry
from mecano.jit.memory import floats
from mecano.jit.thread_pool import PARTS, run_parts
from mecano.solve.linear.multifrontal import (
    FRONT,
    INVERSE,
    MAGNITUDE,
    PERMUTED,
    backward,
    factor_fronts,
    forward,
    refine,
)
from mecano.solve.linear.ordering import FIRST, PIVOTS, SIZE, padded

OWN = SIZES, ORDERED, WORK = range(3)  # rows (n + STRIP,) of a half: MAGNITUDE, PERMUTED and FRONT of multifrontal.py
AT_HAND = DATA, LENGTH, B, X = range(4)  # addresses of the arrays at hand, and the length of the first
RANGE = BEGIN, END, LOW, HIGH, MIDDLE = range(5)  # fronts of a half; its unknowns, and the first between, in order
TASKS = FACTOR, FORWARD, BACKWARD = range(3)  # addresses of the functions below, and of their packed arguments


@entry
def factor_half(
    at_hand: Indices, own_range: Indices, fronts: Table, links: Short, tolerance: float, front: Vector, stack: Vector,
    factors: Vector, vectors: Matrix, exchanges: Indices, own: Matrix, null_out: Indices,
):  # fmt: skip
    """Factor the fronts of a half."""
    own[SIZES][:] = 0.0
    data = floats(at_hand[DATA], at_hand[LENGTH])
    null_out[0] = factor_fronts(
        own_range[BEGIN], own_range[END], data, fronts, links, tolerance,
        front, stack, factors, vectors, own[SIZES], exchanges,
    )  # fmt: skip
    sizes = vectors[MAGNITUDE]
    for i in range(own_range[LOW], own_range[HIGH]):
        sizes[i] = own[SIZES, i]


@entry
def forward_half(
    at_hand: Indices, own_range: Indices, order: Indices, fronts: Table, links: Short, factors: Vector,
    exchanges: Indices, own: Matrix,
):  # fmt: skip
    """Eliminate the unknowns of a half in the right-hand side."""
    b, y = floats(at_hand[B], order.size), own[ORDERED]
    for i in range(own_range[LOW], own_range[HIGH]):
        y[i] = b[order[i]]
    y[own_range[MIDDLE] :] = 0.0
    for f in range(own_range[BEGIN], own_range[END]):
        forward(f, fronts, links, factors, exchanges, own[WORK], y)


@entry
def backward_half(
    at_hand: Indices, own_range: Indices, order: Indices, fronts: Table, links: Short, factors: Vector,
    vectors: Matrix, own: Matrix,
):  # fmt: skip
    """Solve for the unknowns of a half; those between the halves are known."""
    x, y, inverse = floats(at_hand[X], order.size), own[ORDERED], vectors[INVERSE]
    for i in range(own_range[MIDDLE], order.size):
        y[i] = vectors[PERMUTED, i]
    for f in range(own_range[END] - 1, own_range[BEGIN] - 1, -1):
        backward(f, fronts, links, factors, inverse, y)
    for i in range(own_range[LOW], own_range[HIGH]):
        x[order[i]] = y[i]


@entry
def substitute(
    b: Vector, order: Indices, fronts: Table, links: Short, factors: Vector, exchanges: Indices, vectors: Matrix,
    own: Matrices, at_hand: Indices, own_ranges: Table, pool: int, tasks: Table, x_out: Vector,
):  # fmt: skip
    """Solve with the kept factors: x_out (n,) from b (n,); b and x_out may be the same array."""
    at_hand[B], at_hand[X] = b.ctypes.data, x_out.ctypes.data
    begin, first = own_ranges[PARTS - 1, END], own_ranges[0, MIDDLE]
    run_parts(pool, tasks[FORWARD, 0], tasks[FORWARD, 1], tasks[FORWARD, 2])
    y = vectors[PERMUTED]
    for i in range(first, order.size):
        y[i] = b[order[i]]
    for part in range(PARTS):
        for i in range(first, order.size):
            y[i] += own[part, ORDERED, i]
    for f in range(begin, fronts.shape[0]):
        forward(f, fronts, links, factors, exchanges, vectors[FRONT], y)
    for f in range(fronts.shape[0] - 1, begin - 1, -1):
        backward(f, fronts, links, factors, vectors[INVERSE], y)
    run_parts(pool, tasks[BACKWARD, 0], tasks[BACKWARD, 1], tasks[BACKWARD, 2])
    for i in range(first, order.size):
        x_out[order[i]] = y[i]


@entry
def solve(
    # in
    data: Vector, b: Vector,
    # as those of ``substitute``
    order: Indices, fronts: Table, links: Short, factors: Vector, exchanges: Indices, vectors: Matrix,
    own: Matrices, at_hand: Indices, own_ranges: Table, pool: int, tasks: Table,
    # front and stack of what is between the halves; null pivots of the halves
    front: Vector, stack: Vector, nulls: Indices,
    equations: Short, tolerance: float, substitution: int, words: int,
    # out
    x_out: Vector,
) -> (int, bool, float):  # fmt: skip
    """Factor, solve A x = b, and refine once if that helps: (null pivots, refined, backward error)."""
    at_hand[DATA], at_hand[LENGTH] = data.ctypes.data, data.size
    begin, first = own_ranges[PARTS - 1, END], own_ranges[0, MIDDLE]
    run_parts(pool, tasks[FACTOR, 0], tasks[FACTOR, 1], tasks[FACTOR, 2])
    sizes = vectors[MAGNITUDE]
    for i in range(first, sizes.size):
        sizes[i] = max(own[0, SIZES, i], own[1, SIZES, i])
    null = factor_fronts(
        begin, fronts.shape[0], data, fronts, links, tolerance,
        front, stack, factors, vectors, sizes, exchanges,
    )  # fmt: skip
    for i in range(PARTS):
        null += nulls[i]
    refined, error = refine(data, b, equations, vectors, substitution, words, x_out)
    return null, refined, error


class Parts:
    """The arrays of a factorization in halves.

    Parameters
    ----------
    analysis : Analysis
        Of a pattern with parts (ordering.py): the halves, then what is between them.
    tolerance, factors, vectors, exchanges :
        Those of the LinearSolver.

    Attributes
    ----------
    arguments : tuple
        Those of ``substitute`` between ``b`` and ``x_out``.
    further : tuple
        Those of ``solve`` that come next.
    """

    def __init__(self, analysis, tolerance, factors, vectors, exchanges):
        order, fronts, links = analysis.order, analysis.fronts, analysis.links
        ranges, stack = _ranges(analysis, len(order)), np.zeros(analysis.stack_length)
        own, at_hand = np.zeros((PARTS, len(OWN), vectors.shape[1])), np.zeros(len(AT_HAND), np.int64)
        scratch = [np.zeros(_largest(fronts[begin:end])) for begin, end, *_ in ranges]
        nulls = np.zeros(PARTS, np.int64)
        calls = {FACTOR: [], FORWARD: [], BACKWARD: []}
        for i in range(PARTS):
            here, tables = (at_hand, ranges[i]), (fronts, links)
            calls[FACTOR].append(
                factor_half.call_from_compiled_code(
                    *here, *tables, tolerance, scratch[i], stack, factors, vectors, exchanges, own[i], nulls[i : i + 1]
                )
            )
            calls[FORWARD].append(
                forward_half.call_from_compiled_code(*here, order, *tables, factors, exchanges, own[i])
            )
            calls[BACKWARD].append(
                backward_half.call_from_compiled_code(*here, order, *tables, factors, vectors, own[i])
            )
        words = [np.array([call.words for call in calls[task]]) for task in TASKS]
        tasks = np.array([(calls[task][0].function, words[task].ctypes.data, words[task].strides[0]) for task in TASKS])
        self._kept = calls, words
        self.arguments = (
            order,
            fronts,
            links,
            factors,
            exchanges,
            vectors,
            own,
            at_hand,
            ranges,
            thread_pool.pool(),
            tasks,
        )
        rest = np.zeros(_largest(fronts[ranges[-1, END] :]))
        self.further = rest, stack, nulls


def _ranges(analysis, n):
    """Return the ranges (PARTS, RANGE) of fronts and of places in the order of each half."""
    ends = analysis.ends[:PARTS]
    last = analysis.fronts[ends - 1]
    highs = last[:, FIRST] + last[:, PIVOTS]
    begins, lows = ([0, *numbers[:-1]] for numbers in (ends, highs))
    return np.array([begins, ends, lows, highs, np.full(PARTS, highs[-1])], np.int64).T.copy()


def _largest(fronts):
    """Return the length of the work array for one of these fronts."""
    largest = int(fronts[:, SIZE].max(initial=0))
    return largest * padded(largest)

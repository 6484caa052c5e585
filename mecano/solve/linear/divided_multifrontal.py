"""Multifrontal factorization of a matrix in halves (model/halves.py), by two threads.

The fronts of a half form subtrees of their own; the unknowns between the halves are eliminated after both. Each half
has its own work arrays (OWN), in which it also collects its terms in the equations between the halves: they are added
in a fixed order, so that the bits do not depend on the number of threads.
"""

from typing import NamedTuple

import numpy as np

from mecano.jit import thread_pool
from mecano.jit.entry import Indices, Matrices, Matrix, Short, Table, Vector, entry
from mecano.jit.memory import floats
from mecano.jit.thread_pool import PARTS, run_parts
from mecano.solve.linear.multifrontal import (
    FRONT,
    MAGNITUDE,
    PERMUTED,
    Factor,
    Substitution,
    backward,
    factor_fronts,
    forward,
    refine,
)
from mecano.solve.linear.symbolic_analysis import FIRST, PIVOTS, SIZE, work_length

OWN = SIZES, ORDERED, WORK = range(3)  # rows (n + STRIP,) of a half: MAGNITUDE, PERMUTED and FRONT of multifrontal.py
CURRENT = DATA, LENGTH, B, X = range(4)  # addresses of the current arrays, and the length of the first
RANGE = BEGIN, END, LOW, HIGH, MIDDLE = range(5)  # fronts of a half; its unknowns, and the first between, in order
TASKS = FACTOR, FORWARD, BACKWARD = range(3)  # addresses of the functions below, and of their packed arguments


class Halves(NamedTuple):
    """Arrays, threads and tasks of both halves."""

    own: Matrices  # (PARTS, OWN, n + STRIP)
    current: Indices  # (CURRENT,)
    ranges: Table  # (PARTS, RANGE)
    pool: int  # address
    tasks: Table  # (TASKS, 3): address, that of the arguments of the first half, distance to those of the other


class Work(NamedTuple):
    """Work arrays of the factorization, apart from the Factor."""

    front: Vector  # a front between the halves
    stack: Vector
    nulls: Indices  # (PARTS,) null pivots of the halves


@entry
def factor_half(
    current: Indices, own_range: Indices, tolerance: float, front: Vector, stack: Vector, lu: Factor, own: Matrix,
    null_out: Indices,
):  # fmt: skip
    """Factor the fronts of a half."""
    own[SIZES][:] = 0.0
    data, begin, end = floats(current[DATA], current[LENGTH]), own_range[BEGIN], own_range[END]
    null_out[0] = factor_fronts(begin, end, data, tolerance, front, stack, own[SIZES], lu)
    sizes = lu.vectors[MAGNITUDE]
    for i in range(own_range[LOW], own_range[HIGH]):
        sizes[i] = own[SIZES, i]


@entry
def forward_half(current: Indices, own_range: Indices, lu: Factor, own: Matrix):
    """Eliminate the unknowns of a half in the right-hand side."""
    order = lu.order
    b, y = floats(current[B], order.size), own[ORDERED]
    for i in range(own_range[LOW], own_range[HIGH]):
        y[i] = b[order[i]]
    y[own_range[MIDDLE] :] = 0.0
    for f in range(own_range[BEGIN], own_range[END]):
        forward(f, lu, own[WORK], y)


@entry
def backward_half(current: Indices, own_range: Indices, lu: Factor, own: Matrix):
    """Solve for the unknowns of a half; those between the halves are known."""
    order = lu.order
    x, y = floats(current[X], order.size), own[ORDERED]
    for i in range(own_range[MIDDLE], order.size):
        y[i] = lu.vectors[PERMUTED, i]
    for f in range(own_range[END] - 1, own_range[BEGIN] - 1, -1):
        backward(f, lu, own[WORK], y)
    for i in range(own_range[LOW], own_range[HIGH]):
        x[order[i]] = y[i]


@entry
def substitute(b: Vector, lu: Factor, halves: Halves, x_out: Vector):
    """Solve with the kept factors: x_out (n,) from b (n,); b and x_out may be the same array."""
    order, n_fronts, pool, tasks = lu.order, lu.fronts.shape[0], halves.pool, halves.tasks
    halves.current[B], halves.current[X] = b.ctypes.data, x_out.ctypes.data
    begin, first = halves.ranges[PARTS - 1, END], halves.ranges[0, MIDDLE]
    run_parts(pool, tasks[FORWARD, 0], tasks[FORWARD, 1], tasks[FORWARD, 2])
    y = lu.vectors[PERMUTED]
    for i in range(first, order.size):
        y[i] = b[order[i]]
    for part in range(PARTS):
        for i in range(first, order.size):
            y[i] += halves.own[part, ORDERED, i]
    for f in range(begin, n_fronts):
        forward(f, lu, lu.vectors[FRONT], y)
    for f in range(n_fronts - 1, begin - 1, -1):
        backward(f, lu, lu.vectors[FRONT], y)
    run_parts(pool, tasks[BACKWARD, 0], tasks[BACKWARD, 1], tasks[BACKWARD, 2])
    for i in range(first, order.size):
        x_out[order[i]] = y[i]


@entry
def solve(
    data: Vector, b: Vector, lu: Factor, halves: Halves, work: Work, equations: Short, tolerance: float,
    again: Substitution, x_out: Vector,
) -> (int, bool, float):  # fmt: skip
    """Factor, solve A x = b, and refine once if that helps: (null pivots, refined, backward error)."""
    halves.current[DATA], halves.current[LENGTH] = data.ctypes.data, data.size
    begin, first, own, tasks = halves.ranges[PARTS - 1, END], halves.ranges[0, MIDDLE], halves.own, halves.tasks
    run_parts(halves.pool, tasks[FACTOR, 0], tasks[FACTOR, 1], tasks[FACTOR, 2])
    sizes = lu.vectors[MAGNITUDE]
    for i in range(first, sizes.size):
        sizes[i] = max(own[0, SIZES, i], own[1, SIZES, i])
    null = factor_fronts(begin, lu.fronts.shape[0], data, tolerance, work.front, work.stack, sizes, lu)
    for i in range(PARTS):
        null += work.nulls[i]
    refined, error = refine(data, b, equations, lu.vectors, again, x_out)
    return null, refined, error


class Parts:
    """The arrays of a factorization in halves.

    Parameters
    ----------
    analysis : Analysis
        Of a pattern with parts (symbolic_analysis.py): the halves, then the equations between them.
    tolerance, lu :
        Those of the LinearSolver.

    Attributes
    ----------
    halves : Halves
    work : Work
    """

    def __init__(self, analysis, tolerance, lu):
        fronts, stack, nulls = lu.fronts, np.zeros(analysis.stack_length), np.zeros(PARTS, np.int64)
        ranges = _ranges(analysis)
        own, current = np.zeros((PARTS, len(OWN), lu.vectors.shape[1])), np.zeros(len(CURRENT), np.int64)
        calls = {FACTOR: [], FORWARD: [], BACKWARD: []}
        for i, (begin, end, *_) in enumerate(ranges):
            here, scratch, null = (current, ranges[i]), np.zeros(_work_length(fronts[begin:end])), nulls[i : i + 1]
            calls[FACTOR].append(
                factor_half.call_from_compiled_code(*here, tolerance, scratch, stack, lu, own[i], null)
            )
            calls[FORWARD].append(forward_half.call_from_compiled_code(*here, lu, own[i]))
            calls[BACKWARD].append(backward_half.call_from_compiled_code(*here, lu, own[i]))
        words = [np.array([call.words for call in calls[task]]) for task in TASKS]
        tasks = np.array([(calls[task][0].function, words[task].ctypes.data, words[task].strides[0]) for task in TASKS])
        self._kept = calls, words
        self.halves = Halves(own, current, ranges, thread_pool.pool(), tasks)
        self.work = Work(np.zeros(_work_length(fronts[ranges[-1, END] :])), stack, nulls)


def _ranges(analysis):
    """Return the ranges (PARTS, RANGE) of fronts and of places in the order of each half."""
    ends = analysis.ends[:PARTS]
    last = analysis.fronts[ends - 1]
    highs = last[:, FIRST] + last[:, PIVOTS]
    begins, lows = ([0, *numbers[:-1]] for numbers in (ends, highs))
    return np.array([begins, ends, lows, highs, np.full(PARTS, highs[-1])], np.int64).T.copy()


def _work_length(fronts):
    """Return the length of the work array for one of these fronts."""
    return work_length(int(fronts[:, SIZE].max(initial=0)))

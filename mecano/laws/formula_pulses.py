"""Pulses of formulas of the time: short changes that steps of a quiet motion might pass over.

A formula such as ``200*exp(-((time - 5)/0.003)**2)`` is zero at almost all times at which it could be sampled, but the
parts of which it consists are not: its pulse is where ``time - 5`` vanishes. Pulses and edges of a formula are where
one of its parts changes its sign or has an extremum, and between two such places.
"""

from collections.abc import Iterator, Sequence
from typing import TypeAlias

import numpy as np

from mecano.laws import formula as op

Program: TypeAlias = Sequence[tuple[int, float]]  # (operation, number) of every step (formula.py)

SAMPLES = 1000  # intervals of the run between the times at which parts of a formula are evaluated
MOST = 100  # changes of sign and extrema of a part: an oscillation has more
FINER, TIMES = 32, 8  # an interval is divided so often, and one of its parts again
WIDTH = 1 / 40  # of the run: half of the longest step
NARROW = 0.1  # of the range of the values: a smaller pulse is neglected
QUIET = 0.25  # of a pulse: what changes more at its sides is no pulse that a step passes over
SIDES = np.array([0.0, -2.0, -1.5, -1.0, 1.0, 1.5, 2.0])  # WIDTHs from a pulse, at which a formula is compared
CONSTANT = 1e-9  # of a value: a smaller change is rounding
SAME = 1e-4  # of a WIDTH: closer places are one

UNARY = {
    op.NEGATIVE: np.negative, op.SIN: np.sin, op.COS: np.cos, op.TAN: np.tan, op.ASIN: np.arcsin, op.ACOS: np.arccos,
    op.ATAN: np.arctan, op.SQRT: np.sqrt, op.EXP: np.exp, op.LOG: np.log, op.TANH: np.tanh, op.ABS: np.abs,
    op.SIGN: np.sign, op.STEP: lambda u: _smooth_step(np.clip(u, 0.0, 1.0)),
}  # fmt: skip
BINARY = {
    op.ADD: np.add, op.SUBTRACT: np.subtract, op.MULTIPLY: np.multiply, op.DIVIDE: np.divide, op.POWER: np.power,
    op.MIN: np.minimum, op.MAX: np.maximum, op.ATAN2: np.arctan2, op.HYPOT: np.hypot,
}  # fmt: skip


def _smooth_step(u):
    return u**3 * (10.0 - u * (15.0 - 6.0 * u))


def pulses(program: Program, start: float, end: float) -> list[float]:
    """Return the times [s], ascending, of pulses from ``start`` to ``end`` of the parts that depend on time alone."""
    t = np.linspace(start, end, SAMPLES + 1)
    return _distinct([_pulses_of(part, t) for part in _outer_parts(program)], end - start).tolist()


def _outer_parts(program):
    """Return the parts of a program that depend on time alone and are no operands of such a part, but of a sum.

    A pulse may be small beside a wave to which it is added.
    """
    found = []
    for part, operands in parts(program):
        if part[-1][0] not in (op.ADD, op.SUBTRACT):
            found = [one for one in found if one not in operands]
        found.append(part)
    return found


def parts(program: Program) -> "Iterator[tuple[Program, list[Program]]]":
    """Yield (part, operands) of the parts of a program that depend on time alone, each after its own parts."""
    stack: list[tuple] = []
    for step in program:
        operands = [stack.pop() for _ in range((step[0] >= op.NEGATIVE) + (step[0] >= op.ADD))][::-1]
        stack.append((*(one for operand in operands for one in operand), step))
        codes = {code for code, _ in stack[-1]}
        if op.TIME in codes and op.INPUT not in codes:
            yield stack[-1], operands


def _pulses_of(part, t):
    """Return the times of the pulses of a program of the time alone between the first and the last of the times t."""
    inner, duration = {one for one, _ in parts(part)}, t[-1] - t[0]
    if len(inner) < 3:  # linear, or a single function of it
        return t[:0]
    places = _distinct([_places(one, t) for one in inner], duration)
    places = np.concatenate([places, 0.5 * (places[1:] + places[:-1])])
    near = values(part, places[:, None] + WIDTH * duration * SIDES)
    whole = np.concatenate([values(part, t), near.ravel()])
    if not np.isfinite(whole).all():
        return t[:0]
    height = np.abs(near[:, 0] - near[:, 1:].mean(axis=1))
    alone = np.ptp(near[:, 1:], axis=1) < QUIET * height
    return places[alone & (height > NARROW * np.ptp(whole)) & (height > CONSTANT * np.abs(whole).max())]


def _distinct(times, duration):
    """Return the union of arrays of times, ascending, without those that follow another one immediately."""
    every = np.sort(np.concatenate([*times, np.zeros(0)]))
    return every[np.diff(every, prepend=-np.inf) > SAME * WIDTH * duration]


def _places(part, t):
    """Return the times at which a program of the time alone changes its sign, or has an extremum between samples t."""
    y = values(part, t)
    if not np.isfinite(y).all() or np.ptp(y) <= CONSTANT * np.abs(y).max():
        return t[:0]
    rising = np.diff(y)
    crossed, turned = np.flatnonzero(y[:-1] * y[1:] <= 0.0), np.flatnonzero(rising[:-1] * rising[1:] < 0.0)
    if len(crossed) + len(turned) > MOST:
        return t[:0]
    sense, top = np.where(y[crossed] > 0.0, 1.0, -1.0), np.sign(rising[turned])
    zeros = _refined(lambda x: np.argmax(sense[:, None] * values(part, x) <= 0.0, axis=1), t[crossed], t[crossed + 1])
    peaks = _refined(lambda x: np.argmax(top[:, None] * values(part, x), axis=1), t[turned], t[turned + 2])
    return np.concatenate([zeros, peaks])


def _refined(index, low, high):
    """Return the times (n,) between ``low`` and ``high`` (n,) about which ``index`` of times (n, FINER + 1) narrows."""
    share, rows = np.linspace(0.0, 1.0, FINER + 1), np.arange(len(low))
    for _ in range(TIMES if len(low) else 0):
        x = low[:, None] + (high - low)[:, None] * share
        i = index(x)
        low, high = x[rows, np.maximum(i - 1, 0)], x[rows, np.minimum(i + 1, FINER)]
    return 0.5 * (low + high)


def values(part: Program, t: np.ndarray) -> np.ndarray:
    """Return the values of a program of the time alone at the times t, an array of any shape."""
    stack: list[np.ndarray] = []
    with np.errstate(all="ignore"):
        for code, number in part:
            if code < op.NEGATIVE:
                stack.append(t if code == op.TIME else np.full(t.shape, number))
            elif code < op.ADD:
                stack.append(UNARY[code](stack.pop()))
            else:
                second = stack.pop()
                stack.append(BINARY[code](stack.pop(), second))
    return stack[0]

"""Corners of formulas of the time: of abs, min and max, and at both ends of the edge of a step.

They are where the argument of abs vanishes, where both arguments of min or max are equal, and where the share of the
edge is 0 or 1. Only parts of a formula that depend on the time alone have them.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from mecano.laws import formula as op
from mecano.laws.formula_pulses import MOST, SAMPLES, Program, parts, values

WITH_CORNERS = {op.ABS, op.MIN, op.MAX, op.STEP}
HALVINGS = 64  # of an interval, after which its ends are neighbouring numbers


def corners(program: Program, start: float, end: float) -> list[float]:
    """Return the times [s], ascending, between ``start`` and ``end`` at which parts of a program have corners.

    A part that has more than MOST is an oscillation, and has none.
    """
    if not WITH_CORNERS & {code for code, _ in program}:
        return []
    return _between(_conditions(program), start, end)


def crossings(program: Program, levels: Sequence[float], start: float, end: float) -> list[float]:
    """Return the times [s], ascending, between ``start`` and ``end`` at which a program of the time crosses levels.

    They are the first times at or above a level, or below it. None are returned of an oscillation, as of ``corners``.
    """
    return _between(((*program, (op.NUMBER, level), (op.SUBTRACT, 0.0)) for level in levels), start, end)


def _between(programs, start, end):
    t = np.linspace(start, end, SAMPLES + 1)
    times = np.unique(np.concatenate([*(_zeros(one, t) for one in programs), np.zeros(0)]))
    return times[(times > start) & (times < end)].tolist()


def _conditions(program: Program) -> Iterator[Program]:
    """Yield the programs that vanish at corners."""
    for part, operands in parts(program):
        code = part[-1][0]
        if code in (op.ABS, op.STEP):
            yield operands[0]
        if code == op.STEP:
            yield (*operands[0], (op.NUMBER, 1.0), (op.SUBTRACT, 0.0))
        if code in (op.MIN, op.MAX):
            yield (*operands[0], *operands[1], (op.SUBTRACT, 0.0))


def _zeros(program, t):
    """Return the first times at which a program has changed its sign between samples t; zero counts as positive."""
    y = values(program, t)
    changed = np.flatnonzero((y[:-1] != 0.0) & (y[:-1] * y[1:] <= 0.0))
    if len(changed) > MOST:
        return t[:0]
    low, high, sense = t[changed], t[changed + 1], -np.sign(y[changed])
    for _ in range(HALVINGS if len(changed) else 0):
        middle = 0.5 * (low + high)
        beyond = (values(program, middle) >= 0.0) == (sense > 0.0)
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    return high

"""Evaluation of one law from Python, for example in checks; kernels evaluate laws in the table of a model."""

import numpy as np

from mecano.jit.entry import Matrix, Vector, entry
from mecano.laws import TERMS
from mecano.laws.law_table import LawTable, breakpoints, evaluate_curve, terms_of
from mecano.laws.tabulated import TABLE, held_ends
from mecano.maths.distinct import distinct

ROUNDED = 1e-12  # of the largest value of a curve
JUMP = 1e-6  # of a value, a derivative or a second derivative, in SI units: smaller jumps are round-off


def curve_at(law, s):
    """Return (y, dy/ds, d2y/ds2) of a checked law of curves, or of a number, at s."""
    return tuple(curve_values(law, np.array([float(s)]))[0].tolist())


def curve_values(law, s):
    """Return (y, dy/ds, d2y/ds2) (n, 3) of a checked law of curves, or of a number, at s (n,)."""
    table = LawTable()
    start, values = table.add(law), np.zeros((len(s), 3))
    _evaluate(table.array(), start, s, values)
    return values


def negative_curves(place, curves):
    """Return an error for each of the ``curves`` {name: checked law, number or None} at ``place`` that is negative.

    A curve is evaluated at zero and at the points of its tables, between which it is not lower.
    """
    texts = []
    for name, law in curves.items():
        if law is None:
            continue
        s = np.array([0.0, *(x for _, values in terms_of(law) for x, _ in values.get("points") or ())], float)
        y = curve_values(law, s)[:, 0]
        least = -ROUNDED * np.abs(y).max()
        lowest = 0 if y[0] < least else int(np.argmin(y))
        if y[lowest] < least:
            where = f"; it is {y[lowest]:g} at {s[lowest]:g}" if lowest else ""
            texts.append(f"'{place}.{name}' must not be negative{where}")
    return texts


def shape_of_curve(law, low, high):
    """Return arguments (n,), ascending, that resolve a checked law of curves, and (y, dy/ds, d2y/ds2) (n, 3) there.

    For unbounded terms they lie between ``low`` and ``high``.
    """
    places = [TERMS[name].shape(values, low, high) for name, values in terms_of(law)]
    s = distinct(np.concatenate([np.zeros(0), *places]))
    return s, curve_values(law, s)


def held_beyond(law):
    """Return the arguments (low, high) beyond which a table of a checked law holds a value that changes up to there.

    They are -inf and inf if no table does.
    """
    ends = [held_ends(values) for name, values in terms_of(law) if name == TABLE.name]
    return max((low for low, _ in ends), default=-np.inf), min((high for _, high in ends), default=np.inf)


def table_bounds(output, law, what, zero=0.0):
    """Return ``bounds`` of a Kind: where tables of the ``law`` of an output hold its value.

    ``what`` names the value of the law in the texts; ``zero`` is the output at the argument zero of the law.
    """
    text = f"a table of {what} ends at {{:g}} and holds its last value beyond: add points, or 'beyond: extend'"
    low, high = (end + zero for end in held_beyond(law))
    ranges = {high: (-np.inf, high), low: (low, np.inf)}
    return [(output, ranges[end], text.format(end)) for end in ranges if np.isfinite(end)]


def jumps(law, s):
    """Return whether (y, dy/ds, d2y/ds2) of a checked law of curves jump at s, (3,) of booleans."""
    step = 1e-9 * (1.0 + abs(s))
    after, before = np.array(curve_at(law, s + step)), np.array(curve_at(law, s - step))
    continuous = step * np.append(np.abs(after) + np.abs(before), 0.0)[1:]  # change by the derivative over 2 steps
    return np.abs(after - before) > JUMP + continuous


def places_of_jumps(law):
    """Return the arguments, ascending, at which the value of a checked law of curves jumps."""
    return [s for s in breakpoints(law) if jumps(law, s)[0]]


def corners(law):
    """Return the arguments, ascending, at which a checked law of curves jumps or has a corner."""
    return [s for s in breakpoints(law) if jumps(law, s)[:2].any()]


@entry
def _evaluate(laws: Vector, start: int, s: Vector, values_out: Matrix):
    for i in range(s.shape[0]):
        values_out[i, 0], values_out[i, 1], values_out[i, 2] = evaluate_curve(laws, start, s[i])

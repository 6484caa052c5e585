"""Values of one law for callers in Python, such as checks; kernels evaluate laws in the table of a model."""

from numba import njit

from mecano.laws.table import LawTable, evaluate_curve


def curve_at(law, s):
    """(y, dy/ds, d2y/ds2) of a checked law of curves, or of a number, at s."""
    table = LawTable()
    start = table.add(law)
    return _evaluate(table.array(), start, float(s))


@njit(cache=True)
def _evaluate(laws, start, s):
    return evaluate_curve(laws, start, s)

"""Values of one law for callers in Python, such as checks; kernels evaluate laws in the table of a model."""

from mecano.compiled.entry import Vector, entry
from mecano.laws.table import LawTable, evaluate_curve


def curve_at(law, s):
    """(y, dy/ds, d2y/ds2) of a checked law of curves, or of a number, at s."""
    table = LawTable()
    start = table.add(law)
    return _evaluate(table.array(), start, float(s))


@entry
def _evaluate(laws: Vector, start: int, s: float) -> (float, float, float):
    return evaluate_curve(laws, start, s)

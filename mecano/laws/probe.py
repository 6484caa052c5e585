"""Values of one law for callers in Python, such as checks; kernels evaluate laws in the table of a model."""

import numpy as np

from mecano.compiled.entry import Vector, entry
from mecano.laws import TERMS
from mecano.laws.table import LawTable, evaluate_curve, terms_of


def curve_at(law, s):
    """(y, dy/ds, d2y/ds2) of a checked law of curves, or of a number, at s."""
    table = LawTable()
    start = table.add(law)
    return _evaluate(table.array(), start, float(s))


def shape_of_curve(law, low, high):
    """Arguments (n,), ascending, that show the shape of a checked law of curves, and (y, dy/ds, d2y/ds2) (n, 3) there.

    Of what is endless in the law they lie between ``low`` and ``high``.
    """
    places = [TERMS[name].shape(values, low, high) for name, values in terms_of(law)]
    s = np.unique(np.concatenate([np.zeros(0), *places]))
    table = LawTable()
    start, numbers = table.add(law), table.array()
    return s, np.array([_evaluate(numbers, start, place) for place in s.tolist()]).reshape(-1, 3)


@entry
def _evaluate(laws: Vector, start: int, s: float) -> (float, float, float):
    return evaluate_curve(laws, start, s)

"""Curves as comma-separated values, in SI units."""

from collections.abc import Iterable, Sequence
from itertools import zip_longest

import numpy as np

from mecano.post.quantity import STEPS
from mecano.post.sheet import Curve


def columns_of(curves: Iterable[Curve], run_labels: Sequence[str] = ()) -> list[Sequence[str]]:
    """Return curves as rows of a table: columns with names and units, each after the one over which it is plotted.

    ``run_labels`` prefix the names if there are several runs. Columns shared by curves are written once. Columns may
    differ in length, as files or step sizes differ. Measured curves are left out.
    """
    columns: dict[tuple[str, str, str], tuple[str, np.ndarray]] = {}  # by run, clock and path: heading and values
    for curve in (curve for curve in curves if not curve.measured):
        run = run_labels[curve.run] if run_labels else ""
        for quantity in (curve.x, curve.y):
            key = (run, quantity.clock, quantity.path)
            columns.setdefault(key, (_heading(quantity, run), quantity.values))
    rows = zip_longest(*(map(repr, values.tolist()) for _, values in columns.values()), fillvalue="")
    return [[heading for heading, _ in columns.values()], *rows]


def _heading(quantity, run):
    unit = "" if quantity.unit in ("", "-") else f" [{quantity.unit}]"
    path = "solver.time" if (quantity.path, quantity.clock) == ("time", STEPS) else quantity.path
    name = path.replace("/", ".") + unit
    return f"{run}: {name}" if run else name

"""Curves as comma-separated values, in SI units."""

import csv
from itertools import zip_longest

from mecano.post.quantity import STEPS


def write_columns(path, curves, run_labels=()):
    """Write curves as columns with names and units, each after the column over which it is plotted.

    ``run_labels`` prefix the names if there are several runs. Columns shared by curves are written once. Columns may
    differ in length, as files or step sizes differ.
    """
    columns = {}
    for curve in curves:
        run = run_labels[curve.run] if run_labels else ""
        for quantity in (curve.x, curve.y):
            key = (run, quantity.clock, quantity.path)
            columns.setdefault(key, (_heading(quantity, run), quantity.values))
    rows = zip_longest(*(map(repr, values.tolist()) for _, values in columns.values()), fillvalue="")
    write_table(path, [[heading for heading, _ in columns.values()], *rows])


def write_table(path, rows):
    """Write rows, the first of them the heading, as comma-separated values."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)


def _heading(quantity, run):
    unit = "" if quantity.unit in ("", "-") else f" [{quantity.unit}]"
    path = "solver.time" if (quantity.path, quantity.clock) == ("time", STEPS) else quantity.path
    name = path.replace("/", ".") + unit
    return f"{run}: {name}" if run else name

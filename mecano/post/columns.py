"""The numbers of a sheet as comma-separated values, in SI units."""

import csv
from itertools import zip_longest


def write_columns(path, sheet):
    """Write all curves of a sheet, a column each, after the column that they are plotted over; names with units.

    Columns that several curves share stand there once. Shorter ones, of other files or step sizes, end earlier.
    """
    columns = {}
    for curve in sheet.curves:
        run = sheet.run_labels[curve.run] if sheet.run_labels else ""
        for quantity in (curve.x, curve.y):
            key = (run, quantity.clock, quantity.path)
            columns.setdefault(key, (_heading(quantity, run), quantity.values))
    rows = zip_longest(*(map(repr, values.tolist()) for _, values in columns.values()), fillvalue="")
    write_table(path, [[heading for heading, _ in columns.values()], *rows])


def write_table(path, rows):
    """Write rows, the heading among them."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)


def _heading(quantity, run):
    unit = "" if quantity.unit in ("", "-") else f" [{quantity.unit}]"
    name = quantity.path.replace("/", ".") + unit
    return f"{run}: {name}" if run else name

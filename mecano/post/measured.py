"""Measured curves in a CSV file, drawn as points into the plots of the outputs that its headers name.

The first line has the names of outputs, with units: ``time [ms], strut.stroke [mm], wheel.radial_force [kN]``. Names
are those of ``mecano post --plot``; numbers without a unit are in SI units. ``#`` begins a comment.
"""

import csv
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mecano.deck.csv_tables import delimiter_of
from mecano.deck.scalar import number
from mecano.deck.units import ANY, UnitError, factor_of
from mecano.deck.wording import quoted
from mecano.errors import ResultsError, UsageError
from mecano.post.quantity import Quantity
from mecano.post.request import found
from mecano.post.runs import Run
from mecano.post.sheet import Curve, Panel, Sheet


@dataclass(frozen=True)
class Measured:
    """Columns of a file of measurements: name of the file, headers, quantities with the measured values."""

    name: str
    headers: tuple[str, ...]
    quantities: tuple[Quantity, ...]

    def plots(self) -> tuple[str, ...]:
        """Return the plots "Y:X" of all columns over the first."""
        x, *ys = self.headers
        return tuple(f"{y}:{x}" for y in ys)

    def added(self, sheet: Sheet) -> Sheet:
        """Return the sheet with the measured curves of its outputs, where both of their quantities were measured."""
        panels = [self._of_panel(panel) if isinstance(panel, Panel) else panel for panel in sheet.panels]
        return replace(sheet, panels=tuple(panels))

    def _of_panel(self, panel):
        return replace(panel, curves=(*panel.curves, *self._curves(panel)))

    def _curves(self, panel):
        values = {quantity.path: quantity for quantity in self.quantities}
        pairs = {(curve.x.path, curve.y.path): curve for curve in reversed(panel.curves)}
        for (x, y), curve in reversed(pairs.items()):
            if x in values and y in values:
                yield Curve(values[x], values[y], curve.run, curve.subject, measured=self.name)


def read_measured(path: str | os.PathLike[str], run: Run) -> Measured:
    """Read the measured values of outputs of a run.

    Raises ResultsError if the file cannot be read, UsageError if it is no table of numbers or a unit does not fit,
    UnknownNameError if a header is no output.
    """
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ResultsError(f"cannot read {path}: {error}") from None
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    header, *rows = csv.reader(lines, delimiter=delimiter_of(lines), skipinitialspace=True) if lines else [[]]
    if len(header) < 2 or not rows or any(number(cell.strip()) is not None for cell in header):
        raise UsageError(
            f"{path}: a line of headers, such as 'time [s], strut.stroke [mm]', and rows of numbers needed"
        )
    values = np.array([_numbers(path, header, row) for row in rows]).T
    columns = [_column(path, cell.strip(), column, run) for cell, column in zip(header, values, strict=True)]
    return Measured(Path(path).name, tuple(name for name, _ in columns), tuple(quantity for _, quantity in columns))


def _numbers(path, header, row):
    """Return the numbers of a row, as many as there are headers; an empty cell is a gap."""
    found = [np.nan if not cell.strip() else number(cell.strip()) for cell in row]
    if len(found) != len(header) or None in found:
        raise UsageError(f"{path}: {len(header)} numbers needed in each row, got {quoted(', '.join(row))}")
    return found


def _column(path, cell, values, run):
    """Return the name of a column and its Quantity in SI units."""
    name, bracket, unit = cell.rstrip("]) ").replace("(", "[").partition("[")
    quantity = _quantity(run, name.strip())
    own = factor_of(quantity.unit, ANY) if quantity.unit.strip("-") else 1.0
    try:
        factor = factor_of(unit, quantity.unit) if bracket else 1.0
    except UnitError as error:
        raise UsageError(f"{path}: {quoted(cell)}: {error}") from None
    return name.strip(), replace(quantity, values=factor / own * values)


def _quantity(run, name):
    """Return the output of a name, which must be a number."""
    quantities = found(run, name)
    if len(quantities) > 1:
        raise UsageError(f"{quoted(name)} has several numbers; name one, such as {quantities[0].path}")
    return quantities[0]


def with_measured(sheets: Sequence[Sheet], measured: Measured) -> list[Sheet]:
    """Return the sheets with measured curves. Raises UsageError if none of them shows measured outputs."""
    found = [measured.added(sheet) for sheet in sheets]
    if not any(curve.measured for sheet in found for curve in sheet.curves):
        columns = ", ".join(measured.headers)
        raise UsageError(f"no requested plot shows two of the columns of {measured.name}: {columns}")
    return found

"""Tables of laws in CSV files next to the deck: a header is optional, ``#`` begins a comment.

If a table has more than two columns, ``columns`` selects x and y by header or number. A header may have a unit, as in
``force [kN]``; ``units`` gives units otherwise.
"""

import csv
import os
import re
from array import array
from collections.abc import Iterable
from dataclasses import field
from typing import Any

import numpy as np

from mecano.deck.compose import Node
from mecano.deck.named_file import source_of
from mecano.deck.scalar import number
from mecano.deck.scope import Scope
from mecano.deck.source import Source
from mecano.deck.units import UnitError, factor_of, parsed, unit_of
from mecano.deck.values import in_range
from mecano.deck.wording import quoted
from mecano.immutable import mutable

HEADER = r"(?s)(.*?)\s*(?:\[([^\]]*)\]|\(([^)]*)\))?"
MOST_COLUMNS = 10_000
DECIMAL_COMMA = r"[-+]?\d+,\d+(?:[eE][-+]?\d+)?"
SEPARATED = "columns are separated by ',', ';' or tabs"


@mutable
class Table:
    """Points (x, y) of a file in SI units, with the line of each."""

    source: Source
    numbers: array = field(default_factory=lambda: array("d"))  # x, y of each point in turn
    rows: array = field(default_factory=lambda: array("q"))  # line number of each point, from 0
    units: list[tuple[str, Node] | None] = field(default_factory=list)  # of x and y: unit, node at its place

    @property
    def points(self) -> np.ndarray:
        """Return the points, (n, 2)."""
        return np.array(self.numbers).reshape(-1, 2)

    def place(self, i: int) -> Node:
        """Return a node at the line of point i."""
        return Node(None, self.source, self.rows[i] if i < len(self.rows) else 0)


@mutable
class ColumnRequest:
    """Request of a law to a table: for x and y (node of a header or number, or None) and (node of a unit, or None)."""

    columns: list[Node | None]
    units: list[Node | None]
    declared: str  # units of x and y in the deck

    def key(self) -> tuple[Any, ...]:
        """Return a key that distinguishes this request from others to the same file."""
        return tuple(node and node.value for node in (*self.columns, *self.units)), self.declared


def table(name: str, node: Node, request: ColumnRequest, scope: Scope) -> Table | None:
    """Return the Table of a file named in a deck at ``node``, or None after reporting the problems; each is read once.

    The file must be in the folder of the deck or below it.
    """
    name = os.path.normpath(os.path.join(scope.included.get(node.source.file, ""), name)) if name else name
    key = (name, request.key())
    if key not in scope.tables:
        source = source_of(name, node, scope)
        scope.tables[key] = _read(source, request, scope) if source else None
    return scope.tables[key]


def factor(unit: str, declared: str, place: Node, scope: Scope) -> float | None:
    """Return the factor from the ``unit`` of a column, given at a ``place``, to SI units; None after reporting one."""
    try:
        return factor_of(unit, declared)
    except UnitError as error:
        in_deck = place.value is not None
        scope.refuse(place, f"unit of a column: {error}", "" if in_deck else "or give 'units: [.., ..]'")
        return None


def _read(source, request, scope):
    """Return the Table of a source, or None after reporting the problems."""
    before, subject = len(scope.problems), scope.subject
    scope.subject = ""
    found = _Reading(source, request, scope).table()
    if not found.rows and len(scope.problems) == before:
        scope.refuse(Node(None, source), "the table has no points")
    scope.subject = subject
    return found if len(scope.problems) == before else None


class _Reading:
    """One traversal of the rows of a table."""

    def __init__(self, source, request, scope):
        self.source, self.request, self.scope = source, request, scope
        self.found = Table(source)
        self.columns: tuple[int, int] | None = None  # these three are set by the first row
        self.factors, self.width = (1.0, 1.0), 2
        self.is_plain = source.text.isascii() and "_" not in source.text  # float() agrees with ``number``

    def table(self):
        """Return the Table of all valid rows."""
        delimiter = delimiter_of(self.source.each_line())
        rows = csv.reader(self._lines(), delimiter=delimiter, skipinitialspace=True)
        try:
            for cells in rows:
                line = rows.line_num - 1
                if self._added(cells, line) or not cells or cells[0].startswith("#") or not any(map(str.strip, cells)):
                    continue
                if self.columns is None:
                    cells = [cell.strip() for cell in cells]
                    header = all(number(cell) is None for cell in cells)
                    if not self._choose(cells, header, line):
                        break
                    if header:
                        continue
                if point := self._checked_point(cells, self.columns, line):
                    self._keep(point, line)
        except csv.Error as error:
            self._refuse(rows.line_num - 1, f"not valid CSV: {error}")
        return self.found

    def _lines(self):
        """Return the lines; with their ends, a quote that is never closed exceeds the longest cell soon."""
        lines = self.source.each_line()
        return (line + "\n" for line in lines) if '"' in self.source.text else lines

    def _choose(self, cells, header, line):
        """Find the columns and their factors from the first row; return False if they are unknown."""
        if len(cells) > MOST_COLUMNS:
            self._refuse(line, f"the table has {len(cells)} columns; {MOST_COLUMNS} are allowed")
            return False
        matches = [match for cell in cells if (match := re.fullmatch(HEADER, cell))] if header else []
        names = [match[1] for match in matches]
        first, second = self.request.columns
        x, y = 0, 1
        if first is None or second is None:
            if len(cells) > 2:
                given = ", ".join(names[:12]) or f"numbers from 1 to {len(cells)}"
                hint = f"choose with 'columns: [x, y]' from {given}"
                self._refuse(line, f"two columns are needed, got {len(cells)}", hint)
                return False
        else:
            x, y = (self._column(node, names, len(cells)) for node in (first, second))
            self.width = len(cells)
        if x is None or y is None:
            return False
        units = [match[2] or (match[3] if parsed(match[3] or "") else None) for match in matches]
        to_x, to_y = self._factor(0, x, units, line), self._factor(1, y, units, line)
        if to_x is None or to_y is None:
            return False
        self.columns, self.factors = (x, y), (to_x, to_y)
        return True

    def _column(self, node, names, count):
        """Return the column with a header or a number from 1; None after reporting an unknown one."""
        if type(node.value) is int and 1 <= node.value <= count:
            return node.value - 1
        if node.value in names:
            return names.index(node.value)
        if type(node.value) is int:
            self.scope.refuse(node, f"the table has {count} columns, numbered from 1, and no {node.value}")
        else:
            hint = self.scope.suggest(node.value, names) if names else "the table has no headers: give numbers, from 1"
            self.scope.refuse(node, f"the table has no column {quoted(node.value)}", hint)
        return None

    def _factor(self, i, column, units, line):
        """Return the factor from the ``column`` of x (i = 0) or y (1) to SI units; None after reporting its unit."""
        declared, node = unit_of(self.request.declared, i, 2), self.request.units[i]
        unit = node.value if node else (units[column] if column < len(units) else None)
        if not unit:
            self.found.units.append(None)
            return 1.0
        place = node or Node(None, self.source, line, max(self.source.lines[line].find(unit), 0))
        self.found.units.append((unit, place))
        return factor(unit, declared, place, self.scope)

    def _added(self, cells, line):
        """Add the point of a row of plain numbers, the usual case in a long table; return False for other rows."""
        if len(cells) != self.width or not self.is_plain or self.columns is None:
            return False
        (i, j), (to_x, to_y) = self.columns, self.factors
        try:
            x, y = float(cells[i]), float(cells[j])
        except ValueError:
            return False
        return in_range(x) and in_range(y) and self._keep((x * to_x, y * to_y), line)

    def _keep(self, point, line):
        self.found.numbers.extend(point)
        self.found.rows.append(line)
        return True

    def _checked_point(self, cells, columns, line):
        """Return the point of a row; None after reporting the problem."""
        if self.request.columns[0] is None and len(cells) != 2:
            return self._refuse(line, f"two columns are needed, got {len(cells)}", SEPARATED)
        if max(columns) >= len(cells):
            text = f"the row has {len(cells)} columns, and column {max(columns) + 1} is needed"
            return self._refuse(line, text, SEPARATED)
        point = []
        for column, factor in zip(columns, self.factors, strict=True):
            cell = cells[column].strip()
            value = number(cell)
            if value is None or not in_range(value):
                place = Node(None, self.source, line, max(self.source.lines[line].find(cell), 0))
                hint = (
                    f"a decimal point, not a comma: {cell.replace(',', '.')}"
                    if re.fullmatch(DECIMAL_COMMA, cell)
                    else ""
                )
                self.scope.refuse(place, f"must be a finite number, got {quoted(cell)}", hint)
                return None
            point.append(float(value) * factor)
        return point

    def _refuse(self, line, message, hint=""):
        self.scope.refuse(Node(None, self.source, line), message, hint)


def delimiter_of(lines: Iterable[str]) -> str:
    """Return the mark that separates columns: that of the first line which is neither empty nor a comment."""
    first = next((line for line in lines if line.strip() and not line.lstrip().startswith("#")), "")
    return next((mark for mark in "\t;" if mark in first), ",")

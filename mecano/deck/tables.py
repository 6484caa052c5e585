"""Tables in CSV files beside the deck: two columns of numbers, a header is optional, ``#`` begins a comment."""

import csv
import os
from dataclasses import dataclass

from mecano.deck.compose import Node
from mecano.deck.include import confined
from mecano.deck.scalar import number
from mecano.deck.source import Unreadable, read_source
from mecano.deck.values import LARGEST
from mecano.deck.wording import quoted
from mecano.errors import DeckError


@dataclass
class Table:
    """Points [x, y] of a file, and where each was written."""

    points: list
    rows: list  # number of the line of each point, from 0
    source: object

    def place(self, i):
        """A node at the point i."""
        return Node(None, self.source, self.rows[i] if i < len(self.rows) else 0)


def table(name, node, scope):
    """The Table of a file named in a deck at ``node``, or None with the problems noted; each file is read once.

    The file must lie in the folder of the deck or below it.
    """
    name = os.path.normpath(os.path.join(scope.included.get(node.source.file, ""), name)) if name else name
    if name not in scope.tables:
        scope.tables[name] = None
        source = _source(name, node, scope)
        before = len(scope.problems)
        found = _table(source, scope) if source else None
        if found and not found.points and len(scope.problems) == before:
            scope.refuse(Node(None, source), "the table has no points")
        scope.tables[name] = found if len(scope.problems) == before else None
    return scope.tables[name]


def within(name, node, scope):
    """The path of a file in the folder of the deck or below it; None with the problem noted when it is elsewhere."""
    path = confined(scope.folder, name)
    if path is None:
        scope.refuse(node, f"file {quoted(name)} must lie in the folder of the deck")
    return path


def _source(name, node, scope):
    path = within(name, node, scope)
    if path is None:
        return None
    try:
        source, digest = read_source(path, os.path.join(scope.folder, name))
    except Unreadable as error:
        scope.refuse(node, f"file {quoted(name)} cannot be read: {error}")
        return None
    except DeckError as error:
        scope.problems.extend(error.problems)
        return None
    scope.files[name] = digest
    return source


def _table(source, scope):
    subject, scope.subject = scope.subject, ""
    found = Table([], [], source)
    header_allowed = True
    rows = csv.reader(source.lines, delimiter=_delimiter(source.lines), skipinitialspace=True)
    try:
        for cells in rows:
            cells = [cell.strip() for cell in cells]
            if not any(cells) or cells[0].startswith("#"):
                continue
            if header_allowed and all(number(cell) is None for cell in cells):
                header_allowed = False
                continue
            header_allowed = False
            _add_row(found, cells, rows.line_num - 1, scope)
    except csv.Error as error:
        scope.refuse(Node(None, source, rows.line_num - 1), f"not valid CSV: {error}")
    scope.subject = subject
    return found


def _delimiter(lines):
    first = next((line for line in lines if line.strip() and not line.lstrip().startswith("#")), "")
    return next((mark for mark in "\t;" if mark in first), ",")


def _add_row(found, cells, line, scope):
    if len(cells) != 2:
        hint = "columns are separated by ',', ';' or tabs"
        scope.refuse(Node(None, found.source, line), f"two columns are needed, got {len(cells)}", hint)
        return
    values = [number(cell) for cell in cells]
    for cell, value in zip(cells, values, strict=True):
        if value is None or not abs(value) <= LARGEST:
            column = max(found.source.lines[line].find(cell), 0)
            scope.refuse(Node(None, found.source, line, column), f"must be a finite number, got {quoted(cell)}")
            return
    found.points.append([float(value) for value in values])
    found.rows.append(line)

"""Cases of a study: rows of values from grids, lists, tables and random numbers; several sources are combined."""

import csv
import math
from collections.abc import Callable
from itertools import product

import numpy as np

from mecano.deck.compose import Node
from mecano.deck.scalar import resolved
from mecano.deck.scope import Scope
from mecano.deck.source import Source
from mecano.deck.wording import quoted
from mecano.schema import Values
from mecano.study.grammar import NAME, Entries, Entry, node_at, node_in_unit, path_of

MOST = 100_000  # cases
ROWS = {"list", "csv"}  # sources whose rows may replace values of 'set'


def rows_of(values: Values, root: Node, source: Callable[[str], Source | None], scope: Scope) -> list[Entries]:
    """Return [{path: Entry}] of all cases from the checked values of a study; the last source varies fastest.

    ``root`` is the tree of the study; ``source(name)`` returns the Source of a file, or None. Errors are reported to
    the scope.
    """
    ways = {
        "grid": _axes(values["grid"]), "list": [values["list"]], "csv": [_table(values["csv"], source, scope)],
        "latin_hypercube": [_hypercube(values["latin_hypercube"])], "seeds": [_seeds(values["seeds"], root)],
    }  # fmt: skip
    given = {name: tables for name, tables in ways.items() if values[name] is not None}
    seen: dict[str, str] = {}
    for name, tables in given.items():
        entries = {path: entry for rows in tables for row in rows for path, entry in row.items()}
        common = {} if name in ROWS else dict.fromkeys(values["set"], "set")
        for path, entry in entries.items():
            if other := seen.get(path) or common.get(path):
                scope.refuse(entry.key, f"{quoted(path)} is given by '{other}' and by '{name}': keep one")
            seen[path] = name
    for name in given.keys() & ROWS:
        _check_names(given[name][0], scope)
    if not given:
        names = "', '".join(ways)
        scope.refuse(root, f"nothing is varied: a study has at least one of '{names}'")
    if scope.problems:
        return []
    combined = [rows for tables in given.values() for rows in tables]
    count = math.prod(map(len, combined))
    if count > MOST:
        scope.refuse(root, f"{count} cases are more than {MOST}")
        return []
    return [{path: entry for row in rows for path, entry in row.items()} for rows in product(*combined)]


def _check_names(rows, scope):
    """Report names of cases that a list or table gives to several rows: nothing would tell them apart."""
    first: dict[str, Node] = {}
    for entry in (row[NAME] for row in rows if NAME in row):
        before = first.setdefault(str(entry.node.value), entry.node)
        if before is not entry.node and entry.node.value is not None:
            text = f"case {quoted(str(entry.node.value))} is named twice, first in line {before.line + 1}"
            scope.refuse(entry.node, text)


def _axes(grid):
    """Return the rows of each varied value of a grid, which are combined with those of all others."""
    return [[{path: Entry(key, item)} for item in node.value] for path, (key, node) in (grid or {}).items()]


def _hypercube(cube):
    """Return rows in which each of ``number`` equal parts of every range has one value, at a random position."""
    if cube is None:
        return []
    random, number = np.random.default_rng(cube["seed"] & (2**63 - 1)), cube["number"]
    columns = {}
    for path, (key, node) in cube["ranges"].items():
        low, high = node.value
        places = (random.permutation(number) + random.random(number)) / number
        values = (low + (high - low) * places).tolist()
        columns[path] = [Entry(key, node_in_unit(node, value, node.raw)) for value in values]
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def _seeds(seeds, root):
    if seeds is None:
        return []
    _, node = root.value["seeds"][1].value["path"]
    return [{seeds["path"]: Entry(node, node_at(node, seeds["first"] + i))} for i in range(seeds["number"])]


def _table(name, source, scope):
    """Return the rows of a CSV file; ``#`` begins a comment."""
    found = source(name) if name else None
    if found is None:
        return []
    lines = csv.reader(found.lines, skipinitialspace=True)
    head: list[Node] = []
    rows: list[Entries] = []
    before = len(scope.problems)
    try:
        for cells in lines:
            cells, place = [cell.strip() for cell in cells], Node(None, found, lines.line_num - 1)
            if not any(cells) or cells[0].startswith("#"):
                continue
            if not head and ";" in "".join(cells):
                scope.refuse(place, "the table has ';' between its columns", "write ',', and points in decimals")
                return []
            if not head:
                head = [node_at(place, path_of(node_at(place, cell), scope)) for cell in cells]
            elif len(cells) != len(head):
                scope.refuse(place, f"the row has {len(cells)} columns, the first line {len(head)}")
            else:
                values = [node_at(place, resolved(cell), cell) for cell in cells]
                rows.append({key.value: Entry(key, value) for key, value in zip(head, values, strict=True)})
    except csv.Error as error:
        scope.refuse(Node(None, found, lines.line_num - 1), f"not valid CSV: {error}")
    if not rows and len(scope.problems) == before:
        scope.refuse(Node(None, found), "the table has no rows: the first line names the varied values")
    return rows

"""The report on a study as data: governing cases, statistics, all cases, pictures, the study file."""

import os
import re
from pathlib import Path

import numpy as np

from mecano.errors import name_list
from mecano.post.report import Picture, Report, Section, Table, Text, number
from mecano.post.study_outputs import displayed_outputs, severity, study_unit
from mecano.post.study_plots import study_figure
from mecano.post.study_statistics import statistics
from mecano.post.style import with_unit
from mecano.results.study_file import FAIL, read_study

COMPLETE = "complete"
NUMBER = re.compile(r"(?<![\w'.])-?\d[\d.]*(?:e[-+]?\d+)?(?![\w'])")  # in a warning, not in the name of an element
MOST_WARNINGS = 20  # different ones that are shown
MOST_CASES = 8  # beyond a limit, that are named


def study_report(path: str | os.PathLike[str], title: str | None = None) -> Report:
    """Return the Report of the table of a study. Raises ResultsError."""
    table = read_study(path)
    sections = (
        Section("Limits", tuple(_limits(table))), Section("Governing cases", tuple(_extreme_cases(table))),
        Section("Statistics", tuple(statistics(table))), Section("Cases", tuple(_cases(table))),
        Section("Cases that are not complete", tuple(_incomplete(table))), Section("Warnings", tuple(_warnings(table))),
        Section("Pictures", tuple(_pictures(table))),
        Section("Study", (Text(f"Deck: {os.path.normpath(table.deck)}"), Text(table.text, True, "The study file"))),
    )  # fmt: skip
    kept = tuple(section for section in sections if section.parts)
    complete = all(status == COMPLETE for status in table["case/status"])
    sound = complete and not any(table.warnings) and FAIL not in table.verdicts
    return Report(title or table.title or Path(table.deck).stem, table.verdict, sound, "", kept)


def _limits(table):
    """Yield the table of the limits of outputs, and of the cases beyond them."""
    names, rows = np.array(table.case_names, object), []
    for output in (one for one in table.group("outputs") if one.limits != (None, None)):
        known = [limit for limit in output.limits if limit is not None]
        factor, unit = study_unit(output.unit, np.append(output.values, known))
        beyond = names[output.beyond & (table["case/status"] == COMPLETE)]
        shown = ("" if limit is None else number(limit / factor) for limit in output.limits)
        beyond = name_list(list(beyond), MOST_CASES) or "none"
        rows.append((output.name.replace("_", " "), output.doc, beyond, unit, *shown))
    if rows:
        yield Table(("output", "which is", "cases beyond", "unit", "at least", "at most"), rows, 4)


def _extreme_cases(table):
    """Yield the table of the smallest and largest value of each output, with the one that governs."""
    rows: list[tuple[str, ...]] = []
    names, governing = table.case_names, set()
    for output in displayed_outputs(table):
        if not np.any(np.isfinite(output.values)):
            continue
        factor, unit = study_unit(output.unit, output.values)
        low, high = int(np.nanargmin(output.values)), int(np.nanargmax(output.values))
        sizes = severity(output)[[low, high]]
        if sizes[0] != sizes[1]:
            governing |= {(len(rows), column) for column in ((3, 4) if sizes[0] > sizes[1] else (5, 6))}
        rows.append((
            output.name.replace("_", " "), output.doc, unit, number(output.values[low] / factor), names[low],
            number(output.values[high] / factor), names[high],
        ))  # fmt: skip
    if rows:
        yield Table(("output", "which is", "unit", "smallest", "in case", "largest", "in case"), rows, 3,
                    governing=frozenset(governing))  # fmt: skip


def _cases(table):
    """Yield the table of varied values and outputs of all cases."""
    columns = (*table.group("parameters"), *displayed_outputs(table))
    scales = [study_unit(one.unit, one.values) if one.numeric else (None, one.unit) for one in columns]
    head = [
        with_unit(one.name.removeprefix("parameters."), unit) for one, (_, unit) in zip(columns, scales, strict=True)
    ]
    rows = [
        (name, *(_cell(one.values[i], factor) for one, (factor, _) in zip(columns, scales, strict=True)))
        for i, name in enumerate(table.case_names)
    ]
    complete = table["case/status"] == COMPLETE
    beyond = {(int(i), j) for j, one in enumerate(columns, 1) for i in np.flatnonzero(one.beyond & complete)}
    yield Table(("case", *head), rows, marked=frozenset(beyond))


def _cell(value, factor):
    if factor is None:
        return value
    return "" if np.isnan(value) else number(value / factor)


def _incomplete(table):
    """Yield the table of the cases that are not complete, with their reasons."""
    facts = zip(table["case/status"], table["case/exit_code"], table["case/reason"], strict=True)
    rows = [
        (name, status, "" if np.isnan(code) else f"{code:.0f}", reason)
        for name, (status, code, reason) in zip(table.case_names, facts, strict=True)
        if status != COMPLETE
    ]
    if rows:
        yield Table(("case", "status", "exit code", "reason"), rows, 4)


def _warnings(table):
    """Yield the table of the warnings of complete cases, those of most cases first.

    Warnings that differ in numbers only, which vary from case to case, are one row with the text of the first case.
    """
    cases: dict[str, list[tuple[str, str]]] = {}  # text of a warning without numbers -> (text, name) of the cases
    for name, warnings in zip(table.case_names, table.warnings, strict=False):
        for text in warnings:
            cases.setdefault(NUMBER.sub("#", text), []).append((text, name))
    ordered = sorted(cases.values(), key=lambda found: -len(found))
    rows = [(found[0][0], str(len(found)), found[0][1]) for found in ordered]
    if rows:
        yield Table(("warning, with the numbers of the first case", "cases", "first case"), rows[:MOST_WARNINGS], 1)
    if len(rows) > MOST_WARNINGS:
        yield Text(f"and {len(rows) - MOST_WARNINGS} others, see table.csv")


def _pictures(table):
    figure = study_figure(table)
    if figure:
        yield Picture("Outputs of all cases", figure)

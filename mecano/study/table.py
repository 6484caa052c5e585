"""Table of a study: varied values, how each case ended, and its outputs."""

from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np

from mecano.errors import ResultsError, UnknownNameError, name_list
from mecano.results.reader import open_results
from mecano.results.study_file import (
    BETWEEN,
    FAIL,
    StudyTable,
    column,
    counts_text,
    within,
    write_columns,
    write_study,
)  # fmt: skip
from mecano.study.folder import COMPLETE, STATUSES, Folder, Record
from mecano.study.read import Case
from mecano.study.unvaried_values import unvaried_values

ENDED = (
    ("status", "", "complete, failed, stopped (--resume continues it) or waiting"),
    ("exit_code", "", "exit code of the process; negative: the signal that ended it"),
    ("processor_time", "s", "processor time of all processes of the case"),
    ("wall_time", "s", "wall-clock time"),
    ("memory", "MB", "peak memory; missing if the case ended before it was measured"),
)
VERDICT = "pass: all outputs of a complete case are within their limits; fail: some are not"
BEYOND = "outputs of a complete case that are beyond their limits, or missing"
MOST_REASONS = 10  # shown in the summary


class Table:
    """Table filled as cases end; ``written`` writes it to files. ``varied``: units of the varied paths."""

    def __init__(self, folder: Folder, varied: Mapping[str, str]):
        self.folder, self.study, self.varied = folder, folder.study, varied
        self.records: dict[int, Record] = {}  # by the number of the case; so are the next two
        self.numbers: dict[int, dict[str, float]] = {}  # by the name of the output
        self.warnings: dict[int, str] = {}
        self.units: dict[str, str] = {}  # of the outputs
        self.limited = tuple(output for output in self.study.outputs if output.limits != (None, None))

    def take(self, case: Case, record: Record) -> None:
        """Record how a case ended, and read its outputs and warnings if it is complete."""
        self.records[case.number] = record
        if record.status == COMPLETE:
            self.numbers[case.number] = self._outputs(case)

    def _outputs(self, case):
        """Return {name: number} of a complete case, without outputs that its model lacks; {} without a file."""
        found = {}
        try:
            with open_results(self.folder.file(case, ".h5")) as results:
                self.warnings[case.number] = BETWEEN.join(results.warnings)
                for output in self.study.outputs:
                    with suppress(UnknownNameError):
                        value, unit = output.value(results)
                        found[output.name] = float(value)
                        self.units[output.name] = unit or self.units.get(output.name, "")  # none without event
        except ResultsError:
            return {}
        return found

    def gather(self) -> None:
        """Take all cases that have not been taken."""
        for case in self.study.cases:
            if case.number not in self.records:
                self.take(case, self.folder.record(case))

    def written(self) -> Path:
        """Write table.h5 and table.csv of all cases into the folder; return the path of the latter."""
        self.gather()
        table = StudyTable(self.study.title, self.study.text, self.study.deck, tuple(self._columns()))
        path = self.folder.path / "table.csv"
        write_study(self.folder.table, table)
        write_columns(path, table)
        return path

    def _columns(self):
        cases, records = self.study.cases, [self.records[case.number] for case in self.study.cases]
        shown, unchanged = [case.shown for case in cases], unvaried_values(self.study)
        yield column("case", "case", "", "number of the case, and name of its files", [case.number for case in cases])
        if any(case.name for case in cases):
            yield column("case", "name", "", "name of the case", [case.name for case in cases])
        for path in self.study.paths:
            varied = [values.get(path, unchanged.get(path)) for values in shown]
            yield column("parameters", path, self.varied.get(path, ""), "value of the deck", varied)
        for name, unit, doc in ENDED:
            reported = [getattr(record, name) for record in records]
            measured = [v / 1e6 or None for v in reported] if unit == "MB" else reported  # 0: ended before that
            yield column("case", name, unit, doc, measured)
        for output in self.study.outputs:
            numbers = [self.numbers.get(case.number, {}).get(output.name, np.nan) for case in cases]
            yield column("outputs", output.name, self.units.get(output.name, ""), output.doc, numbers, output.limits)
        if self.limited:
            yield column("case", "verdict", "", VERDICT, [self._verdict(case.number) for case in cases])
            yield column("case", "beyond_limits", "", BEYOND, [", ".join(self._beyond(case.number)) for case in cases])
        yield column("case", "reason", "", "why a case is not complete", [record.reason for record in records])
        warned = [self.warnings.get(case.number, "") for case in cases]
        yield column("case", "warnings", "", f"warnings of a complete case, with '{BETWEEN}' between them", warned)

    def _beyond(self, number):
        """Return the names of the outputs of a complete case that are not within their limits."""
        if number not in self.numbers:
            return []
        found = self.numbers[number]
        return [output.name for output in self.limited if not within(output.limits, found.get(output.name, np.nan))]

    def _verdict(self, number):
        return "" if number not in self.numbers else FAIL if self._beyond(number) else "pass"

    @property
    def beyond(self) -> list[int]:
        """Numbers of the complete cases with outputs beyond their limits."""
        return [case.number for case in self.study.cases if self._beyond(case.number)]

    def summary(self) -> str:
        """Return the numbers of cases by status, and the reasons of those that are not complete, as lines of text."""
        warned = sum(map(bool, self.warnings.values()))
        counts = counts_text(warned, len(self.beyond))
        lines = [f"{len(self.study.cases)} cases: {self._counted(STATUSES)}{counts}"]
        lines += self._exceeded()
        reasons = Counter((r.exit_code, r.reason) for r in self.records.values() if r.reason).most_common()
        lines += [f"  {count} x exit code {code}: {reason}" for (code, reason), count in reasons[:MOST_REASONS]]
        more = sum(count for _, count in reasons[MOST_REASONS:])
        return "\n".join([*lines, f"  and {more} others, see table.csv"] if more else lines)

    def _exceeded(self):
        """Return a line for each limited output that is beyond its limits in some case."""
        lines, names = [], {number: self._beyond(number) for number in self.beyond}
        for output in self.limited:
            numbers = [str(number) for number, beyond in names.items() if output.name in beyond]
            if numbers:
                lines.append(f"  {output.name}: beyond its limits in case {name_list(numbers, MOST_REASONS)}")
        return lines

    @property
    def incomplete(self) -> str:
        """Numbers of incomplete cases by status, as text; empty if all are complete."""
        return self._counted(STATUSES[1:])

    def _counted(self, statuses):
        counts = Counter(record.status for record in self.records.values())
        return ", ".join(f"{counts[status]} {status}" for status in statuses if counts[status])

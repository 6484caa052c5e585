"""The report on a run as data: sections of tables, texts and pictures, which report_page.py turns into a page."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import yaml

from mecano.element_interface import SECTIONS
from mecano.errors import ResultsError
from mecano.post.event_groups import groups, most_notable, repeated
from mecano.post.extremes import notable
from mecano.post.figure import overview_figure, sheet_figure
from mecano.post.info import count, facts, one_line
from mecano.post.overview import overview
from mecano.post.request import requested_sheets
from mecano.post.sheets import default_sheets
from mecano.post.spectrum import NO_TRANSFORMS, Transforms
from mecano.post.verdict import is_sound, verdict
from mecano.results.energy_balance import EXCHANGED, scale_of_balance

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mecano.post.runs import Run

MOST_EVENTS = 200
MANY_EVENTS = 30  # groups of like ones, of which the repeated ones are merged if there are more
MOST_EXTREMES = 400
LONGEST_LIST = 24  # entries of a list of the deck that are shown
HEALTH = {
    "step_size": "size of the step", "iterations": "Newton iterations", "rejected": "rejected trials of a step",
    "error_over_tolerance": "estimated error over its allowed value",
    "force_residual": "force residual over its tolerance",
    "constraint_residual": "constraint residual over its tolerance",
}  # fmt: skip

RESIDUAL = (
    "All these steps converged. A force residual above its tolerance is the rounding error of positions times the "
    "stiffness of the model: a further correction of the positions would have been within its tolerance."
)


@dataclass(frozen=True)
class Table:
    """Rows of texts; columns with an index of at least ``first_number`` hold numbers.

    ``marked`` cells (row, column) exceed a limit, ``governing`` ones are the largest in magnitude. A table with a
    ``title`` is in a collapsed block.
    """

    columns: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    first_number: int = 1
    marked: frozenset[tuple[int, int]] = frozenset()
    governing: frozenset[tuple[int, int]] = frozenset()
    title: str = ""


@dataclass(frozen=True)
class Text:
    """A paragraph, or ``verbatim`` text in a collapsed block."""

    text: str
    verbatim: bool = False
    title: str = ""


@dataclass(frozen=True)
class Picture:
    """A figure of matplotlib with a title."""

    title: str
    figure: "Figure"


@dataclass(frozen=True)
class Section:
    """Parts under a heading."""

    heading: str
    parts: tuple[Table | Text | Picture, ...]


@dataclass(frozen=True)
class Report:
    """A whole report: title, verdict, whether it is sound, why the run ended, sections."""

    title: str
    verdict: str
    sound: bool
    reason: str
    sections: tuple[Section, ...]


def report_of(
    run: "Run", title: str | None = None, plots: Sequence[str] = (), transforms: Transforms = NO_TRANSFORMS
) -> Report:
    """Return the Report of a run; ``plots`` and ``transforms``, as for ``mecano post``, come first.

    Raises ResultsError if there are no saved times, UsageError and UnknownNameError for invalid plots.
    """
    results = run.results
    if not len(results.time):
        raise ResultsError(f"{results.path}: no saved times yet")
    requested, sheets = requested_sheets(plots, [run]) + transforms.sheets([run]), default_sheets([run])
    sections = (
        Section("Warnings", tuple(Text(text) for text in results.warnings)),
        Section("Overview", tuple(_overview(run, sheets))), Section("Model", tuple(_model(run))),
        Section("Run", tuple(_provenance_table(results))), Section("Solution", tuple(_solver_history(results))),
        Section("Energy", tuple(_energy(results))), Section("Events", tuple(_events(results))),
        Section("Pictures", tuple(_pictures([*requested, *sheets]))), Section("Extremes", tuple(_extremes(results))),
        Section("Deck", tuple(_deck(results))),
    )  # fmt: skip
    reason = results.end.strip()
    kept = tuple(section for section in sections if section.parts)
    return Report(title or run.title, verdict(results), is_sound(results), reason, kept)


def number(value: float) -> str:
    """Return a number as text for tables, without negative zeros."""
    return f"{value + 0.0:.5g}"


def _model(run):
    """Yield the parts on the model: counts by kind, mass, unknowns, mobility, warnings."""
    rows = [("nodes", str(len(run.deck.get("nodes", {}))))]
    for section in SECTIONS:
        kinds = Counter(d["type"] for d in run.deck.get(section, {}).values())
        reported = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
        rows.append((section, f"{sum(kinds.values())}: {reported}" if kinds else "none"))
    for name, value in run.results.model.items():
        if name != "set_in_motion":  # a fact of the run, see ``facts``
            rows.append((name.replace("_", " "), f"{value:.6g} kg" if name == "mass" else f"{value:g}"))
    rows.append(("gravity", ", ".join(number(g) for g in run.deck.get("gravity") or (0.0,) * 3) + " m/s2"))
    yield Table(("", ""), rows, 2)


def _provenance_table(results):
    """Yield the table of provenance, without facts of other sections."""
    yield Table(("", ""), [row for row in facts(results) if row[0] not in ("title", "run", "energy")], 2)


def _solver_history(results):
    """Yield the parts on the solver history: smallest, mean and largest values, with times of the extremes."""
    steps, unit = results.steps, results.axis.unit
    if not len(steps):
        yield Text("No step was accepted.")
        return
    rows = []
    for column, reported in HEALTH.items():
        if column in steps.dtype.names and np.any(steps[column]):
            values, own = steps[column], results.step_columns[column][0]
            low, high = int(np.argmin(values)), int(np.argmax(values))
            low_high = [(number(values[i]), number(steps["time"][i])) for i in (low, high)]
            rows.append((f"{reported} [{own}]" if own else reported, *low_high[0], number(values.mean()), *low_high[1]))
    at = f"at {results.axis.path} [{unit}]" if unit else f"at {results.axis.path}"
    yield Text(f"{count(results)}.")
    yield Table(("", "smallest", at, "mean", "largest", at), rows)
    if "force_residual" in steps.dtype.names and np.any(steps["force_residual"] > 1.0):
        yield Text(RESIDUAL)


def _energy(results):
    """Yield the parts on energies: values at start and end, and the error of the balance."""
    names = [name for name in (*EXCHANGED, "balance") if f"energy/{name}" in results.series]
    rows, extremes = [], results.extremes
    for name in names:
        values, extreme = results.find(f"energy/{name}").values, extremes[f"energy/{name}"]
        spread = extreme.maximum - extreme.minimum
        rows.append((name, *map(number, (values[0], values[-1], values[-1] - values[0], spread))))
    if rows:
        yield Table(("energy [J]", "start", "end", "change", "range over all steps"), rows)
    if "balance" not in names:
        return
    ranges = {name: (extremes[f"energy/{name}"].minimum, extremes[f"energy/{name}"].maximum) for name in names}
    off, (compared, scale) = ranges["balance"][1] - ranges["balance"][0], scale_of_balance(ranges)
    if scale > 0.0:
        yield Text(
            f"The balance, kinetic + potential + dissipated - given, varies by {off:.3g} J: {off / scale:.2g} of "
            f"{compared}. An exact solution keeps it."
        )


def _events(results):
    """Yield the parts on events: groups of like ones, as in ``mecano info``, and all events if these are more."""
    events, at = results.events, f"{results.axis.path} [{results.axis.unit}]"
    found = groups(results)
    found = repeated(found) if len(found) > MANY_EVENTS else found
    listed = most_notable(found, MANY_EVENTS)
    shocks = any(event.impulse_unit for event in events)
    losses = ("impulse", "energy lost [J]") if shocks or any(event.energy_lost for event in events) else ()
    if len(found) < len(events):
        again = ("times", f"last [{results.axis.unit}]") if any(group.times > 1 for group in found) else ()
        rows = [_group(group, again, losses) for group in listed]
        yield Table((at, "where", "what", "phase", *again, *losses), rows, 4)
    if len(listed) < len(found):
        yield Text(f"These are {len(listed)} of {len(found)} groups of like events, shocks and releases first.")
    shown = events[:MOST_EVENTS]
    if shown:
        title = f"The first {len(shown)} of {len(events)} events" if len(shown) < len(events) else "All events"
        rows = [_event(event)[: 4 + len(losses)] for event in shown]
        yield Table((at, "where", "what", "phase", *losses), rows, 4, title=title if len(found) < len(events) else "")
    if shocks:
        lost = sum(event.energy_lost for event in events if event.impulse_unit)
        yield Text(f"Shocks took {lost:.6g} J in all.")


def _group(group, again, losses):
    """Return the row of a Group, with the columns ``again`` of repeated ones and ``losses`` of impulse and energy."""
    first, last = group.events[0], group.events[-1]
    row = [number(group.time), group.title, *_event(first)[2:4]]
    if again:
        row += [str(group.times), number(last.time)] if group.times > 1 else ["", ""]
    if losses:
        up_to = "up to " if len(group.events) > 1 else ""
        row.append(f"{up_to}{number(group.impulse)} {first.impulse_unit}" if group.is_shock else "")
        row.append(number(group.lost) if group.is_shock or group.lost else "")
    return tuple(row)


def _event(event):
    modes = f"{event.before} to {event.after}" if event.before != event.after else ""
    reported = (number(event.time), event.element, event.name.replace("_", " "), modes)
    if not event.impulse_unit:
        return (*reported, "", number(event.energy_lost) if event.energy_lost else "")
    return (*reported, f"{number(event.impulse)} {event.impulse_unit}", number(event.energy_lost))


def _extremes(results):
    """Yield the table of extremes over all accepted steps."""
    found = [
        (name, e.unit.strip("-"), *map(number, (e.minimum, e.minimum_time, e.maximum, e.maximum_time)))
        for name, e in notable(results.extremes)
    ]
    at = f"at [{results.axis.unit}]" if results.axis.unit else "at"
    if found:
        yield Table(("over all accepted steps", "unit", "min", at, "max", at), found[:MOST_EXTREMES], 2)
    if len(found) > MOST_EXTREMES:
        yield Text(f"These are the first {MOST_EXTREMES} of {len(found)}; mecano info --names shows all.")


def _overview(run, sheets):
    if sheets:
        yield Picture("Overview", overview_figure(overview(sheets), run.title, one_line([run])))


def _pictures(sheets):
    for sheet in sheets:
        title, _, rest = sheet.heading.partition(": ")
        yield Picture(sheet.heading, sheet_figure(replace(sheet, heading=rest), title))


def _deck(results):
    """Yield the overrides, the deck as written, and the resolved deck."""
    for text in results.metadata["overrides"]:
        yield Text(f"Set on the command line: {text}")
    yield Text(results.deck_text, True, "As written")
    plain = _shortened(results.resolved)
    resolved = yaml.safe_dump(plain, sort_keys=False, allow_unicode=True, default_flow_style=None, width=110)
    yield Text(resolved, True, "Resolved, with all defaults")


def _shortened(value):
    """Return plain data with long lists truncated and their lengths given."""
    if isinstance(value, dict):
        return {key: _shortened(one) for key, one in value.items()}
    if isinstance(value, list):
        whole = len(value) <= LONGEST_LIST
        kept = [_shortened(one) for one in (value if whole else value[:3])]
        return kept if whole else [*kept, f"... {len(value)} entries"]
    return value

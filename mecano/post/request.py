"""Requested plots ``--plot Y[,Y2]:X`` as sheets: a panel for each unit, with the curves of all runs."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Self

from mecano.deck.wording import quoted
from mecano.errors import UnknownNameError, UsageError
from mecano.post.event_marks import event_marks
from mecano.post.panels import with_peaks
from mecano.post.quantity import Quantity, find, time_of
from mecano.post.runs import Run
from mecano.post.sheet import Curve, Panel, Sheet

LONGEST_NAME = 80
LONGEST_LABEL = 40
GRAMMAR = "write Y, Y:X or Y,Y2:X with names as `mecano info --names` shows them"


@dataclass(frozen=True)
class Request:
    """Names of the quantities to plot, and of the quantity on the horizontal axis."""

    ys: tuple[str, ...]
    x: str = "time"

    @classmethod
    def parse(cls, text: str) -> Self:
        """Parse "Y[,Y2]:X". Raises UsageError."""
        left, *right = text.split(":")
        ys = tuple(name.strip() for name in left.split(","))
        x = [name.strip() for name in right] or ["time"]
        if not all(ys) or len(x) > 1 or not x[0]:
            raise UsageError(f"--plot {quoted(text)} cannot be understood; {GRAMMAR}")
        return cls(ys, x[0])

    @property
    def name(self) -> str:
        """The request as part of the name of a file."""
        whole = "_".join(self.ys) + ("" if self.x == "time" else f"-{self.x}")
        return re.sub(r"[^A-Za-z0-9_.-]+", "_", whole).strip("_")[:LONGEST_NAME] or "plot"


def requested_sheets(plots: Iterable[str], runs: Sequence[Run]) -> list[Sheet]:
    """Return the Sheets of ``plots`` "Y[,Y2]:X". Raises UsageError, UnknownNameError."""
    return [requested_sheet(Request.parse(text), runs) for text in plots]


def requested_sheet(request: Request, runs: Sequence[Run]) -> Sheet:
    """Return the Sheet of a Request. Raises UnknownNameError, UsageError, ResultsError.

    Runs without one of the quantities have no curve of it, which the heading says.
    """
    names = [*request.ys] if request.x == "time" else [*request.ys, request.x]
    quantities = {name: found_in(runs, name) for name in names}
    curves = [curve for number, run in enumerate(runs) for curve in _curves(request, run, number, quantities)]
    if not curves:
        raise UsageError(f"no file has both {' or '.join(map(quoted, request.ys))} and {quoted(request.x)}")
    subjects = tuple(dict.fromkeys(curve.subject for curve in curves))
    panels = []
    for unit in dict.fromkeys(curve.y.unit for curve in curves):
        of_unit = tuple(curve for curve in curves if curve.y.unit == unit)
        panels.append(with_peaks(Panel(curve_label(of_unit, subjects), of_unit), runs))
    heading = f"{', '.join(request.ys)} over {request.x}{lacking(quantities, runs)}"
    labels = tuple(run.label for run in runs) if len(runs) > 1 else ()
    return Sheet(request.name, heading, tuple(panels), _marks(runs, subjects), labels)


def _marks(runs, subjects):
    """Return the events of the subjects and of the elements at nodes among them, or all if these have none."""
    marks = event_marks(runs)
    owners = {path.partition("/")[2] for run in runs for path, d in run.things.items() if d.get("node") in subjects}
    return tuple(mark for mark in marks if mark.element in owners.union(subjects)) or marks


def _curves(request, run, number, quantities):
    """Yield the Curves of a run of index ``number``; ``quantities``: {name: [those of each run]}."""
    x = None
    if request.x != "time":
        if not quantities[request.x][number]:
            return
        x = _one(request.x, quantities[request.x][number])
    for name in request.ys:
        for y in quantities[name][number]:
            if x is not None and x.clock != y.clock:
                known = f"{quoted(name)} is known at the {y.clock}, {quoted(request.x)} at the {x.clock}"
                raise UsageError(f"{known}; plot both over time")
            yield Curve(x or time_of(y), y, number, y.subject)


def _one(name, quantities):
    """Return the only one of the quantities of a name. Raises UsageError."""
    if len(quantities) > 1:
        components = ", ".join(q.path.rpartition(".")[2] for q in quantities)
        raise UsageError(f"{quoted(name)} has several numbers ({components}), the horizontal axis needs one")
    return quantities[0]


def found_in(runs: Sequence[Run], name: str) -> list[list[Quantity]]:
    """Return the Quantities of a name in each run, none where a run lacks it.

    Raises UnknownNameError, that of the first run, if all lack it.
    """
    quantities: list[list[Quantity]] = []
    errors = []
    for run in runs:
        try:
            quantities.append(found(run, name))
        except UnknownNameError as error:
            quantities.append([])
            errors.append(error)
    if len(errors) == len(runs):
        raise errors[0]
    return quantities


def lacking(quantities: Mapping[str, list[list[Quantity]]], runs: Sequence[Run]) -> str:
    """Return the text "; 'name' is not in run", or "", for {name: quantities of each run}."""
    texts = []
    for name, of_runs in quantities.items():
        without = [run.label for run, own in zip(runs, of_runs, strict=True) if not own]
        texts += [f"; {quoted(name)} is not in {', '.join(without)}"] if without else []
    return "".join(texts)


def found(run: Run, name: str) -> list[Quantity]:
    """Return the Quantities of a name in a run. Raises UnknownNameError, which names the file."""
    try:
        return find(run.results, name)
    except UnknownNameError as error:
        raise UnknownNameError(f"{run.results.path}: {error}") from None


def curve_label(curves: Iterable[Curve], subjects: Sequence[str] | None = None) -> str:
    """Return the label of curves, with the owner if there is only one among ``subjects``, or among the curves."""
    subjects = subjects or tuple(dict.fromkeys(curve.subject for curve in curves))
    quantities = dict.fromkeys(curve.y.whole for curve in curves)
    text = ", ".join(quantities)
    if len(text) > LONGEST_LABEL:
        text = next(iter(quantities)) + ", ..."
    return f"{subjects[0]} {text}" if len(subjects) == 1 and text != subjects[0] else text

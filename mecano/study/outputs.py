"""Numbers of a run for the table of a study, from a series or from the occurrences of an event."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np

from mecano.analyses.dynamic import layout_of
from mecano.analyses.prepare import Prepared
from mecano.deck.compose import Node
from mecano.deck.scope import Scope
from mecano.deck.units import UnitError, converted, is_quantity
from mecano.deck.wording import quoted, suggestion
from mecano.errors import UnknownNameError
from mecano.model.sampler import Sampler
from mecano.post.deployment import MARGINS, least_margins, motors
from mecano.post.runs import Run
from mecano.results.lookup import Lookup
from mecano.results.reader import Results
from mecano.results.recorded import MAGNITUDE
from mecano.results.study_file import Bounds

EVENT_UNITS = {"first": "s", "last": "s", "count": "-", "impulse": "N s or N m s", "energy_lost": "J"}
SIGNS = {"largest": True, "largest_magnitude": False}  # whether the value of the largest magnitude keeps its sign
ONLY_IN_PLOTS = {
    "compression_force": ("force", "use {}, whose minimum (take: min) is the largest compression"),
    "drag_force": ("longitudinal_force", "use {}, whose minimum (take: min) is the largest drag"),
    "rolling_rate": ("spin_rate", "use {}, or the slip ratio"),
}
"""Quantities derived from outputs for plots: name -> the output to use in a study, and the hint."""


def _word(event):
    """Return the name of an event as it is written in a study: meets_lower_stop."""
    return event.replace(" ", "_")


@dataclass(frozen=True)
class Output:
    """A column of the table: ``take`` of a series ``of``, or of an ``event`` "element name", the element
    possibly a pattern with * and ?.
    """

    name: str
    of: str | None
    event: str | None
    take: str
    at_least: float | None = None
    at_most: float | None = None

    @property
    def limits(self) -> Bounds:
        """Smallest and largest number of a case that passes, each None if it is absent."""
        return self.at_least, self.at_most

    @property
    def doc(self) -> str:
        """Description of the output."""
        signed = ", with its sign" if SIGNS.get(self.take) else ""
        return f"{self.take.replace('_', ' ')} of {self.of or self.event}{signed}"

    def value(self, results: Results) -> tuple[float, str]:
        """Return the number and its unit from open Results; nan without such an event. Raises UnknownNameError."""
        if self.event:
            return self._of_events(self.event, results)
        assert self.of is not None, "an output is of an event or of a series"
        return self._of_series(self.of, results)

    def _of_events(self, event, results):
        element, name = event.split()
        found = [e for e in results.events if _word(e.name) == name and fnmatchcase(results.subject(e)[1], element)]
        if self.take == "count":
            return float(len(found)), ""
        if self.take == "energy_lost":
            return sum(event.energy_lost for event in found), "J"
        if not found:
            return np.nan, "" if self.take == "impulse" else results.axis.unit
        if self.take == "impulse":
            if len(units := {event.impulse_unit for event in found}) > 1:
                return np.nan, ""  # linear and angular impulses cannot be compared
            return max(abs(event.impulse) for event in found), units.pop()
        return found[0 if self.take == "first" else -1].time, results.axis.unit

    def _of_series(self, series, results):
        if series in MARGINS:
            return least_margins(Run(results))[series], "-"
        trace = results.find(series)
        values = trace.values
        if self.take == "final":
            return values[-1], trace.unit
        if self.take == "mean":
            span = trace.time[-1] - trace.time[0]
            return np.sum(0.5 * (values[1:] + values[:-1]) * np.diff(trace.time)) / span, trace.unit
        extreme = results.extremes.get(trace.path)
        if self.take in SIGNS:
            ends = np.array((extreme.maximum, extreme.minimum)) if extreme else values
            largest = ends[np.argmax(np.abs(ends))]
            return largest if SIGNS[self.take] else abs(largest), trace.unit
        return self._extreme(extreme, trace, values, results.axis.unit)

    def _extreme(self, extreme, trace, values, axis_unit):
        """Return the extreme over all accepted steps if these are recorded, else over the saved times."""
        largest, of_time = self.take.endswith("max"), self.take.startswith("time")
        if extreme:
            found = (extreme.maximum, extreme.maximum_time) if largest else (extreme.minimum, extreme.minimum_time)
        else:
            i = np.argmax(values) if largest else np.argmin(values)
            found = values[i], trace.time[i]
        return (found[1], axis_unit) if of_time else (found[0], trace.unit)


def checked_outputs(
    outputs: Iterable[Output], prepared: Prepared, node_of: Callable[[str], Node], scope: Scope
) -> None:
    """Report outputs that the model of a Prepared does not have; ``node_of(name)`` is the node of an output."""
    lookup = Lookup(layout_of(Sampler(prepared.system)).series)
    event_records = _events_of_elements(prepared.system)
    for output in outputs:
        node = node_of(output.name)
        scope.subject = f"output {quoted(output.name)}"
        if output.event:
            _check_event(output.event, event_records, node.value["event"][1], scope)
            _check_limits(node, EVENT_UNITS[output.take], scope)
        elif output.of in MARGINS:
            _check_margin(output, prepared.deck.values, node, scope)
        elif series := _checked_series(output.of, lookup, node.value["of"][1], scope):
            _check_limits(node, "s" if output.take.startswith("time") else series.unit, scope)


def _check_margin(output, values, node, scope):
    """Report a deployment margin of which not the least value is taken, or of a model without motors."""
    if output.take != "min":
        scope.refuse(node.value["take"][1], f"of {quoted(output.of)} only the least value is known", "write 'min'")
    if not motors(values):
        scope.refuse(node.value["of"][1], f"{quoted(output.of)}: no hinge has a 'turning_law' and a 'latch'")
    _check_limits(node, "-", scope)


def _check_limits(node, unit, scope):
    """Report limits that are quantities of another kind than the output, in ``unit``, or look like degrees."""
    for name in ("at_least", "at_most"):
        limit = node.value[name][1] if name in node.value else None
        if limit is not None and is_quantity(limit.raw):
            try:
                converted(limit.raw, unit or "-")
            except UnitError as error:
                scope.refuse(limit, f"{quoted(name)}: {error}")
        elif limit is not None and unit == "rad" and type(limit.value) in (int, float) and _is_large(limit.value):
            text = f"{quoted(name)} is {limit.raw} rad, more than a turn, as the output is an angle"
            scope.refuse(limit, text, f"write '{limit.raw} deg', or '{limit.raw} rad' if it is meant")


def _is_large(angle):
    """Return whether a number looks like degrees."""
    from mecano.model.signal_units import looks_like_degrees

    return looks_like_degrees(float(angle))


def _checked_series(name, lookup, node, scope):
    """Return the series of an output, or None after reporting that the model lacks it."""
    try:
        series, component = lookup.find(name.removesuffix(MAGNITUDE))
    except UnknownNameError as error:
        if set(name) & set("*?"):
            hint = "for the largest of several, define a signal, such as max(a.force, b.force)"
            scope.refuse(node, f"{quoted(name)} is a pattern, but an output is of one series", hint)
            return None
        stem, _, last = name.rpartition(".")
        if last in ONLY_IN_PLOTS:
            other, hint = ONLY_IN_PLOTS[last]
            scope.refuse(node, f"{quoted(name)} exists only in plots", hint.format(f"{stem}.{other}"))
        else:
            scope.refuse(node, str(error).replace("in this file", "in the results"))
        return None
    if (len(series.shape) > 0) == (component is None and not name.endswith(MAGNITUDE)):
        components = ", ".join(series.components)
        hint = f"add one of {components}, or magnitude" if components else "it is one number"
        scope.refuse(node, f"{quoted(name)} is not one number", hint)
        return None
    return series


def _check_event(event, event_records, node, scope):
    element, name = event.split()
    if set(element) & set("*?"):
        if not any(name in events for one, events in event_records.items() if fnmatchcase(one, element)):
            scope.refuse(node, f"no element that matches {quoted(element)} has events {quoted(name)}")
    elif element not in event_records:
        scope.refuse(node, f"nothing named {quoted(element)} has events", suggestion(element, event_records))
    elif name not in event_records[element]:
        scope.refuse(node, f"{quoted(element)} has no event {quoted(name)}", suggestion(name, event_records[element]))


def _events_of_elements(system):
    """Return {name of an element: names of the events of the element and its parts}."""
    found: dict[str, list[str]] = {}
    for batch in system.batches:
        for path, _ in batch.paths:
            if batch.kind.events:
                found.setdefault(path.partition("/")[2], []).extend(_word(event.name) for event in batch.kind.events)
    return found

"""Events of a run that are alike and happen at one instant, together; the sheet and the table of its shocks."""

import re
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mecano.post.quantity import Quantity, time_of
from mecano.post.sheet import QUOTED, Curve, Panel, Sheet

MOST_NAMES = 3  # of the elements of one line
TOGETHER = 1e-6  # of the time of a run: events that are no farther apart are at one instant
BESIDE, LEAST = 0.2, 0.05  # of the time of the shocks, of that of the run: shown before and behind them
SHOCKS = "shocks"  # to whose times quantities belong
HEADING = ("run", "time [s]", "group", "element", "event", "impulse", "unit of the impulse", "energy lost [J]")


@dataclass(frozen=True)
class Group:
    """Events at one instant, of elements of one kind, with one name and one change of mode."""

    events: tuple

    @property
    def time(self):
        """That of the first [s]."""
        return self.events[0].time

    @cached_property
    def kind(self):
        """The kind of the elements."""
        return _kind(self.events[0])

    @cached_property
    def names(self):
        """Names of the elements."""
        return [name[1] if (name := QUOTED.search(event.element)) else event.element for event in self.events]

    @property
    def single(self):
        """A Group for each of the events."""
        return [Group((event,)) for event in self.events]

    @property
    def title(self):
        """The element, or the kind, how many they are, and the names of the first of them."""
        if len(self.events) == 1:
            return self.events[0].element
        more = f" and {len(self.names) - MOST_NAMES} more" if len(self.names) > MOST_NAMES else ""
        return f"{len(self.names)} {self.kind}: {', '.join(self.names[:MOST_NAMES])}{more}"

    @property
    def what(self):
        """What happened to what, in words: hinge locks."""
        return f"{self.kind} {self.events[0].name}".replace("_", " ")

    @property
    def is_shock(self):
        """True when momentum is exchanged."""
        return bool(self.events[0].impulse_unit)

    @property
    def impulse(self):
        """The impulse of largest size."""
        return max((event.impulse for event in self.events), key=abs)

    @property
    def lost(self):
        """Energy lost in all of them [J]."""
        return sum(event.energy_lost for event in self.events)


def groups(results):
    """The events of a file as Groups, in their order."""
    within = TOGETHER * float(np.ptp(results.time)) if len(results.time) else 0.0
    found, here = [], {}
    for event in results.events:
        key = (_kind(event), event.name, event.before, event.after)
        if key not in here or event.time > here[key][0].time + within:
            here[key] = []
            found.append(here[key])
        here[key].append(event)
    return [Group(tuple(events)) for events in found]


def _kind(event):
    return re.sub(r"\s*'.*", "", event.element)


def shock_sheet(runs):
    """The sheet of the shocks: largest impulse at each instant, energy lost so far; its table has every one of them."""
    found = [(number, run, [g for g in groups(run.results) if g.is_shock]) for number, run in enumerate(runs)]
    impulses, energies = [], []
    for number, run, of_run in (one for one in found if one[2]):
        window = _window(run, of_run)
        for what, unit in dict.fromkeys((group.what, group.events[0].impulse_unit) for group in of_run):
            alike = [group for group in of_run if group.what == what]
            impulses.append(_curve(window, number, f"shocks/{what}/impulse", unit, *_stems(alike)))
        energies.append(_curve(window, number, "energy/lost_in_shocks", "J", *_sums(of_run)))
    panels = [
        Panel("largest impulse", tuple(curve for curve in impulses if curve.y.unit == unit))
        for unit in dict.fromkeys(curve.y.unit for curve in impulses)
    ]
    if energies:
        panels.append(Panel("energy lost in shocks", tuple(energies), note=_count(found)))
    return Sheet("shocks", "Shocks", tuple(panels), table=_table(runs))


def _window(run, of_run):
    """Times [s] around the shocks of a run, from which to which they are shown."""
    (start, end), (first, last) = run.results.time[[0, -1]], (of_run[0].time, of_run[-1].time)
    beside = max(BESIDE * (last - first), LEAST * (end - start))
    return max(start, first - beside), max(last, min(end, last + beside))


def _curve(window, number, path, unit, times, values):
    """A curve within a window, zero before and as at last behind it."""
    times, values = np.array([window[0], *times, window[1]]), np.array([0.0, *values, values[-1]])
    y = Quantity(path, unit, path.rpartition("/")[2].replace("_", " "), SHOCKS, times, values)
    return Curve(time_of(y), y, number, y.subject)


def _stems(of_one):
    return np.repeat([g.time for g in of_one], 3), np.array([(0.0, g.impulse, 0.0) for g in of_one]).ravel()


def _sums(of_run):
    total = np.cumsum([group.lost for group in of_run])
    return np.repeat([g.time for g in of_run], 2), np.stack([np.append(0.0, total[:-1]), total], axis=1).ravel()


def _count(found):
    reported = []
    for _, _, of_run in found:
        if of_run:
            lost = sum(group.lost for group in of_run)
            reported.append(f"{sum(len(g.events) for g in of_run)} in {len(of_run)} groups, {lost:.3g} J")
    return "; ".join(reported)


def _table(runs):
    """Heading and a line for each shock of all runs."""
    lines = [
        (run.label or run.title, e.time, number, e.element, e.name, e.impulse, e.impulse_unit, e.energy_lost)
        for run in runs
        for number, group in enumerate((group for group in groups(run.results) if group.is_shock), start=1)
        for e in group.events
    ]
    return (HEADING, *lines) if lines else ()

"""Groups of like events at one instant; the sheet and the table of the shocks of a run."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mecano.element_interface import RELEASES
from mecano.errors import name_list
from mecano.post.quantity import Quantity, time_of
from mecano.post.runs import Run
from mecano.post.sheet import Curve, Panel, Sheet
from mecano.results.reader import Event, Results

MOST_NAMES = 3  # elements named in a line
REPEATED = 3  # least number of like groups that are merged
TOGETHER = 1e-6  # of the duration of a run: events no farther apart are at one instant
BESIDE, LEAST = 0.2, 0.05  # margin shown around shocks, of their duration; least margin, of the duration of the run
SHOCKS = "shocks"  # clock of the quantities
HEADING = ("run", "time [s]", "group", "element", "event", "impulse", "unit of the impulse", "energy lost [J]")


@dataclass(frozen=True)
class Group:
    """Events of the elements ``names`` of one kind, with the same name and change of phase, in order of time.

    They are at one instant, except in a group made by ``repeated``, where ``times`` is the number of instants.
    """

    events: tuple[Event, ...]
    names: tuple[str, ...]
    kind: str
    times: int = 1

    @property
    def time(self) -> float:
        """Time of the first event [s]."""
        return self.events[0].time

    @property
    def single(self) -> "list[Group]":
        """A list of Groups of one event each."""
        return [Group((event,), (name,), self.kind) for event, name in zip(self.events, self.names, strict=True)]

    @property
    def title(self) -> str:
        """The element, or number and kind of the elements with the first of their names."""
        if len({event.element for event in self.events}) == 1 and (self.times > 1 or len(self.events) == 1):
            return self.events[0].element
        return f"{len(self.names)} {self.kind}: {name_list(self.names, MOST_NAMES)}"

    @property
    def what(self) -> str:
        """Kind and name of the event: hinge locks."""
        return f"{self.kind} {self.events[0].name}".replace("_", " ")

    @property
    def is_shock(self) -> bool:
        """True if the events are shocks, which exchange momentum."""
        return bool(self.events[0].impulse_unit)

    @property
    def impulse(self) -> float:
        """The impulse of largest magnitude."""
        return max((event.impulse for event in self.events), key=abs)

    @property
    def lost(self) -> float:
        """Energy lost in all events [J]."""
        return sum(event.energy_lost for event in self.events)


def groups(results: Results) -> list[Group]:
    """Return the events of a file as a list of Groups, in order of time."""
    within = TOGETHER * float(np.ptp(results.time)) if len(results.time) else 0.0
    found: list[tuple[str, list[tuple[Event, str]]]] = []
    here: dict[tuple[str, ...], list[tuple[Event, str]]] = {}  # the last of each kind, name and change of phase
    for event in results.events:
        kind, name = results.subject(event)
        key = (kind, event.name, event.before, event.after)
        if key not in here or event.time > here[key][0][0].time + within:
            here[key] = []
            found.append((kind, here[key]))
        here[key].append((event, name))
    return [Group(tuple(event for event, _ in alike), tuple(name for _, name in alike), kind) for kind, alike in found]


def repeated(found: list[Group]) -> list[Group]:
    """Return Groups in which REPEATED or more groups of the same elements, event and change of phase are one."""
    alike: dict[tuple[object, ...], list[Group]] = {}
    for group in found:
        first = group.events[0]
        alike.setdefault((*sorted(group.names), group.kind, first.name, first.before, first.after), []).append(group)
    merged = [[_merged(own)] if len(own) >= REPEATED else own for own in alike.values()]
    return sorted((group for own in merged for group in own), key=lambda group: group.time)


def most_notable(found: list[Group], most: int) -> list[Group]:
    """Return at most ``most`` Groups, shocks and releases before others, in order of time."""
    ranked = sorted(found, key=lambda group: not (group.is_shock or group.events[0].name == RELEASES))
    return sorted(ranked[:most], key=lambda group: group.time)


def _merged(own):
    events = tuple(event for group in own for event in group.events)
    return Group(events, own[0].names, own[0].kind, len(own))


def shock_sheet(runs: Sequence[Run]) -> Sheet:
    """Return the Sheet of shocks: largest impulse at each instant, cumulative energy loss; its table lists all."""
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
    return Sheet("shocks", "Shocks", tuple(panels), table=_table(runs), lead=0)


def _window(run, of_run):
    """Return the start and end [s] of the window in which the shocks of a run are shown."""
    (start, end), (first, last) = run.results.time[[0, -1]], (of_run[0].time, of_run[-1].time)
    beside = max(BESIDE * (last - first), LEAST * (end - start))
    return max(start, first - beside), max(last, min(end, last + beside))


def _curve(window, number, path, unit, times, values):
    """Return a Curve within a window, zero before the first time and constant after the last."""
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
            count = sum(len(group.events) for group in of_run)
            reported.append(f"{count} shock{'s' if count > 1 else ''}, {lost:.3g} J")
    return "; ".join(reported)


def _table(runs):
    """Return the heading and a line for each shock of all runs; () without shocks."""
    lines = [
        (run.label or run.title, e.time, number, e.element, e.name, e.impulse, e.impulse_unit, e.energy_lost)
        for run in runs
        for number, group in enumerate((group for group in groups(run.results) if group.is_shock), start=1)
        for e in group.events
    ]
    return (HEADING, *lines) if lines else ()

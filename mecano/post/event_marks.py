"""Events of runs as marks, each the same in all pictures of these runs."""

from collections.abc import Iterable
from dataclasses import dataclass

from mecano.errors import name_list
from mecano.post.runs import Run
from mecano.results.reader import Event

MOST_NAMES = 4  # elements named in an entry of the legend
MARKERS = "v^sDoPX*<>pH"
OTHERS = "|"  # common marker of all further events


@dataclass(frozen=True)
class EventMark:
    """An event of an element at a time [s] in run number ``run``; ``key`` names it in the legend by its ``marker``."""

    time: float
    element: str
    text: str
    run: int
    marker: str
    key: str


def event_marks(runs: Iterable[Run]) -> tuple[EventMark, ...]:
    """Return an EventMark for each event of all runs.

    Each event of each element has a marker, shared by elements for which it occurs at the same times. If these are too
    many, each event has a marker for all elements; if even these are too many, the last ones share one. Markers are
    assigned in order of time.
    """
    found: list[tuple[float, str, str, int]] = [
        (event.time, *_named(run, event), number) for number, run in enumerate(runs) for event in run.results.events
    ]
    found.sort(key=lambda event: event[0])
    names = _simultaneous(found)
    apart = len(set(names.values())) <= len(MARKERS)
    keys = [names[element, text] if apart else text for _, element, text, _ in found]
    markers = dict(zip(dict.fromkeys(keys), MARKERS, strict=False))
    return tuple(EventMark(*event, markers.get(key, OTHERS), key) for event, key in zip(found, keys, strict=True))


def _named(run: Run, event: Event) -> tuple[str, str]:
    _, name = run.results.subject(event)
    return name, event.name.replace("_", " ")


def _simultaneous(found):
    """Return {(element, text): "elements: text"} with all elements for which an event occurs at the same times."""
    times: dict[tuple[str, str], list[tuple[int, str]]] = {}
    alike: dict[tuple, list[str]] = {}  # by the text of an event and its times
    for time, element, text, run in found:
        times.setdefault((element, text), []).append((run, f"{time:.6g}"))
    for (element, text), own in times.items():
        alike.setdefault((text, *own), []).append(element)
    return {one: f"{name_list(alike[one[1], *own], MOST_NAMES)}: {one[1]}" for one, own in times.items()}

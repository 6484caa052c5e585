"""Events of runs as marks, each the same in all pictures of these runs."""

from dataclasses import dataclass

MARKERS = "v^sDoPX*<>pH"
OTHERS = "|"  # common mark of all further events


@dataclass(frozen=True)
class EventMark:
    """An event of an element at a time [s] in run number ``run``; ``key`` names it in the legend by its ``marker``."""

    time: float
    element: str
    text: str
    run: int
    marker: str
    key: str


def event_marks(runs):
    """Return an EventMark for each event of all runs.

    Each event of each element has a marker, or each event alone where these are too many; of still more, the others
    share one. Markers are assigned in order of time.
    """
    found = [
        (event.time, *_named(run, event), number) for number, run in enumerate(runs) for event in run.results.events
    ]
    found.sort(key=lambda event: event[0])
    apart = len({(element, text) for _, element, text, _ in found}) <= len(MARKERS)
    keys = [f"{element}: {text}" if apart else text for _, element, text, _ in found]
    markers = dict(zip(dict.fromkeys(keys), MARKERS, strict=False))
    return tuple(EventMark(*event, markers.get(key, OTHERS), key) for event, key in zip(found, keys, strict=True))


def _named(run, event):
    _, name = run.results.subject(event)
    return name, event.name.replace("_", " ")

"""The overview: the mechanism, and as many of the most important panels of all sheets as fit."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from mecano.post.panels import TURNS
from mecano.post.plans import SIGNALS
from mecano.post.sheet import Curve, Panel, Sheet
from mecano.post.sketch import Sketch

PLACES = 9  # cells; a sketch takes one of them, or a row of its own if it is wide
APART = ("solver", "members", "members_peak")  # of the computation, which the heading summarizes; at one instant
SAME = 0.01  # of the largest value: curves that differ by less look the same, and so do a line and a curve
STEADY = 1e-3  # of the largest value: a quantity that varies less is steady
UNKNOWN = "SI"  # unit of a signal of which no unit is declared
TELLING, STRAIGHT, DULL = range(3)


def overview(sheets: Sequence[Sheet]) -> Sheet:
    """Return the Sheet of a sketch and of the most important panels.

    Signals, which the deck defines, come first, then the leading panels of each sheet, then their other panels.
    Straight lines, such as the force of a linear spring, fill the room that is left. Panels that repeat the curves of
    another one are left out, and steady quantities and angles of many turns unless there is nothing else.
    """
    sketches = [panel for sheet in sheets for panel in sheet.panels if isinstance(panel, Sketch)][:1]
    room = PLACES - sum(not one.wide for one in sketches)
    ranked = sorted(_ranked(sheets))
    first = [place for *rank, place in ranked if rank[0] < DULL] or [place for *_, place in ranked]
    chosen = sorted(_without_repetition(sheets, first)[:room], key=lambda place: (not _defined(sheets, place), place))
    panels = (*sketches, *(_named(sheets[k], i) for k, i in chosen))
    return Sheet("overview", "Overview", panels, sheets[0].events, sheets[0].run_labels)


def _defined(sheets, place):
    """Return whether the sheet of a place is that of the signals, which the deck defines."""
    return sheets[place[0]].name == SIGNALS.name


def _ranked(sheets: Sequence[Sheet]) -> Iterator[tuple[int, int, bool, tuple[int, int]]]:
    """Yield a rank, smallest first, with the place (sheet, panel) of each panel that varies."""
    for k, sheet in enumerate(sheets):
        own = [(i, panel) for i, panel in enumerate(sheet.panels) if isinstance(panel, Panel) and not panel.constant]
        kinds = [_interest(panel) for _, panel in own]
        for n, (i, _) in enumerate(own if sheet.name not in APART else ()):
            before = sum(kind <= kinds[n] for kind in kinds[:n])
            yield kinds[n], max(0, before - sheet.lead + 1), not _defined(sheets, (k, i)), (k, i)


def _interest(panel):
    """Return whether a panel is TELLING, STRAIGHT, or DULL, from all its curves except references."""
    curves = [curve for curve in panel.curves if not curve.reference]
    if panel.over_time and all(curve.y.unit == "rad" and np.ptp(_known(curve.y)) > TURNS for curve in curves):
        return DULL
    y = np.concatenate([_known(curve.y) for curve in curves])
    span, size = np.ptp(y), np.abs(y).max()
    if all(np.ptp(_known(curve.y)) <= max(SAME * span, STEADY * size) for curve in curves):
        return DULL
    return STRAIGHT if all(_off_line(curve) <= SAME * span for curve in curves) else TELLING


def _known(quantity):
    return quantity.values[np.isfinite(quantity.values)]


def _off_line(curve: Curve) -> float:
    """Return the largest distance of the values from the straight line that fits them best."""
    known = np.isfinite(curve.x.values) & np.isfinite(curve.y.values)
    x, y = curve.x.values[known], curve.y.values[known]
    design = np.stack([np.ones_like(x), x - x.mean()], axis=1)
    return float(np.abs(y - design @ np.linalg.lstsq(design, y, rcond=None)[0]).max(initial=0.0))


def _without_repetition(sheets, places):
    """Return the places of panels of which not all curves have been shown by panels before them."""
    shown: list[Curve] = []
    kept = []
    for k, i in places:
        curves = [curve for curve in sheets[k].panels[i].curves if not curve.reference]
        if not all(any(_look_alike(curve, other) for other in shown) for curve in curves):
            kept.append((k, i))
            shown += curves
    return kept


def _look_alike(curve, other):
    """Return whether two curves of one run have the same values in magnitude, as a velocity and a speed."""
    units = {curve.y.unit, other.y.unit} - {UNKNOWN}
    if curve.run != other.run or len(units) > 1 or len(curve.y.values) != len(other.y.values):
        return False
    pairs = (curve.x.values, other.x.values), (np.abs(curve.y.values), np.abs(other.y.values))
    return all(
        np.array_equal(np.isfinite(a), np.isfinite(b))
        and np.all(np.abs(a - b)[np.isfinite(a)] <= SAME * np.abs(a[np.isfinite(a)]).max(initial=0.0))
        for a, b in pairs
    )


def _named(sheet, i):
    """Return a panel labelled with its owner, for use without the heading of its sheet."""
    panel = sheet.panels[i]
    if len(panel.subjects) > 1 or panel.subjects[0] in (panel.label, sheet.name):
        return panel
    name = panel.subjects[0]
    return replace(panel, label=name if panel.curves[0].y.of_signal else f"{name}: {panel.label}")

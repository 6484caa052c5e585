"""Styles that distinguish the curves of a panel: colours, dashes, and their legends."""

from typing import Any

from matplotlib.lines import Line2D

from mecano.post.equal_curves import equal_curves, first_subjects, joined
from mecano.post.quantity import largest
from mecano.post.sheet import Curve, Panel, Sheet
from mecano.post.style import COLOURS, DASHES, INK, PALE

REFERENCE = {"linestyle": "-", "linewidth": 3.5, "alpha": 0.3, "zorder": 1.5}
MEASURED: dict[str, Any] = {
    "color": INK, "linestyle": "none", "marker": "o", "markersize": 3.5, "markerfacecolor": "none", "zorder": 3,
}  # fmt: skip
OTHERS: dict[str, Any] = {"color": PALE, "linestyle": "-", "linewidth": 0.8, "zorder": 1.2}
MOST_STYLED = 16  # elements with a style of their own: more could not be identified in the legend


class CurveStyles:
    """Distinct styles for the curves of a sheet.

    Colours distinguish runs, otherwise elements, otherwise quantities; dashes distinguish the rest. Elements have the
    same style in the whole sheet, with one legend for all panels, or styles of their own in each panel. If there are
    more elements than styles, those with the largest values get them, and all others are pale.

    Equal curves of one run are drawn once, with all their names in the legend: "a = b". With one legend for all panels
    these are elements with equal curves in all panels.
    """

    def __init__(self, sheet: Sheet, panel_by_panel: bool = False):
        self.runs = sheet.run_labels
        panels = [panel for panel in sheet.panels if isinstance(panel, Panel)]
        count = max((len(panel.quantities) for panel in panels), default=1)
        alone = all(len(panel.subjects) * len(panel.quantities) == 1 for panel in panels)
        self._legend_runs = self.runs[: len(COLOURS) * (len(DASHES) if alone else 1)]
        self._sheet = None if panel_by_panel or self.runs else self._largest(panels, sheet.subjects, count)
        self._owners = None if panel_by_panel else sheet.subjects
        several = len(sheet.subjects) > 1
        self._common = self._sheet if self._sheet is not None and several else ()  # elements of one common legend
        self._others = len(sheet.subjects) - len(self._common)  # elements without an entry in it
        self._first = first_subjects(panels, self._common)

    def drawn(self, panel: Panel) -> list[list[Curve]]:
        """Return the curves of a panel in lists of equal ones; the first of each list is drawn."""
        if self.runs or self._common:
            return [[c] for c in panel.curves if self._first.get(c.subject, c.subject) == c.subject]
        return equal_curves(panel.curves)

    def owners(self, panel: Panel) -> tuple[str, ...]:
        """Return the elements whose events are named: those of the sheet, or of the panel."""
        return panel.subjects if self._owners is None else self._owners

    def style(self, curve: Curve, panel: Panel) -> dict[str, Any]:
        """Return options of ``Axes.plot`` for a curve."""
        if curve.measured:
            return dict(MEASURED)
        colour, dashes = self._key(curve, panel)
        if dashes >= len(DASHES):
            return OTHERS
        style = {"color": COLOURS[colour], "linestyle": DASHES[dashes]}
        return style | REFERENCE if curve.reference else style

    def _key(self, curve, panel):
        """Return the indices of colour and dashes; len(DASHES) or more for a curve without a style of its own."""
        subjects = self._subjects(panel)
        if curve.subject not in subjects or curve.run >= len(self._legend_runs or [0]):
            return 0, len(DASHES)
        many = max(len(panel.quantities), 1)
        quantity = panel.quantities.index(curve.y.what) if curve.y.what in panel.quantities else 0
        subject = subjects.index(curve.subject)
        if self.runs:
            main, other, others = curve.run, subject * many + quantity, 1
        elif len(subjects) > 1:
            main, other, others = subject, quantity, many
        else:
            main, other, others = quantity, 0, 1
        return main % len(COLOURS), other + others * (main // len(COLOURS))

    def _subjects(self, panel):
        """Return the elements with a style of their own in a panel."""
        if self._sheet is not None:
            return self._sheet
        return self._largest([panel], panel.subjects, len(panel.quantities))

    def _largest(self, panels, subjects, count):
        """Return the subjects with the largest values, as many as there are styles for ``count`` quantities each."""
        rounds = max(1, len(DASHES) // max(count, 1))
        most = rounds if self.runs else min(MOST_STYLED, rounds * len(COLOURS))
        if len(subjects) <= most:
            return subjects
        sizes = dict.fromkeys(subjects, 0.0)
        for panel in panels:
            own = [largest(curve.y.values) for curve in panel.curves]
            for curve, size in zip(panel.curves, own, strict=True):
                sizes[curve.subject] = max(sizes[curve.subject], size / (max(own) or 1.0))
        chosen = sorted(subjects, key=sizes.__getitem__, reverse=True)[:most]
        return tuple(subject for subject in subjects if subject in chosen)

    def handles(self) -> list[Line2D]:
        """Return the legend of the whole sheet: runs, or elements if there are several."""
        if self.runs:
            handles = [_handle(i, name) for i, name in enumerate(self._legend_runs)]
            return handles + _others(len(self.runs) - len(self._legend_runs))
        if not self._common:
            return []
        equal = {first: [s for s in self._common if self._first[s] == first] for first in self._first.values()}
        handles = [_handle(i, joined(equal[name])) for i, name in enumerate(self._common) if name in equal]
        return handles + _others(self._others)

    def legend(self, panel: Panel) -> list[Line2D]:
        """Return the legend of a panel, without the entries of the legend of the sheet."""
        several = len(panel.subjects) > 1 and self._sheet is None
        named = len(panel.quantities) > 1 or any(curve.reference or curve.measured for curve in panel.curves)
        if several and named and (apart := self._elements_and_quantities(panel)):
            return apart
        handles, others = {}, set()
        for equal in self.drawn(panel):
            curve, style = equal[0], self.style(equal[0], panel)
            text = curve.measured or _text(equal, several, named)
            if style is OTHERS:
                reported = several or curve.subject in self._subjects(panel)
                others |= {text} if reported and text else set()
            elif text and text not in handles:
                if self.handles() and not curve.reference and not curve.measured:
                    style["color"] = INK
                handles[text] = Line2D([], [], label=text, **style)
        return list(handles.values()) + _others(len(others - set(handles)))

    def _elements_and_quantities(self, panel):
        """Return entries of the elements, by colour, and then of the quantities, by dashes.

        None if not all of several elements have all quantities and a style, if colours distinguish runs, or if a curve
        is measured.
        """
        found: dict[tuple[str, ...], dict[str, dict[str, Any]]] = {}
        for equal in self.drawn(panel):
            names, quantities = tuple(one.subject for one in equal), {one.y.what for one in equal}
            style = self.style(equal[0], panel)
            if len(quantities) > 1 or style is OTHERS or equal[0].measured:
                return None
            found.setdefault(names, {})[quantities.pop()] = style
        styles = next(iter(found.values()))
        if (
            self.runs
            or not 1 < len(found) <= len(COLOURS)
            or any(own.keys() != styles.keys() for own in found.values())
        ):
            return None
        colours = [next(iter(own.values()))["color"] for own in found.values()]
        elements = [
            Line2D([], [], color=colour, label=joined(names)) for names, colour in zip(found, colours, strict=True)
        ]
        return elements + [Line2D([], [], **style | {"color": INK}, label=what) for what, style in styles.items()]


def _text(equal, several, named):
    """Return the entry of equal curves: elements, if there are ``several``, and quantities, if they are ``named``."""
    if named and not several and any(one.y.of_signal for one in equal):
        return joined(one.y.owned for one in equal)
    quantities = {one.y.what for one in equal}
    if several and named and len(quantities) == 1:
        return f"{joined(one.subject for one in equal)}: {quantities.pop()}"
    return joined(": ".join([one.subject] * several + [one.y.what] * named) for one in equal)


def _handle(i, name):
    return Line2D([], [], color=COLOURS[i % len(COLOURS)], linestyle=DASHES[i // len(COLOURS)], label=name)


def _others(count):
    return [Line2D([], [], label=f"{count} other{'s' * (count > 1)}", **OTHERS)] if count else []

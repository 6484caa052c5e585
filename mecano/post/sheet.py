"""What is shown, before anything is drawn: sheets of panels of curves."""

import re
from dataclasses import dataclass, field

import numpy as np

from mecano.post.quantity import Quantity

QUOTED = re.compile("'(.+)'")  # the name in "wheel 'left'"
CONSTANT = 1e-5  # of its size: what varies less is constant


@dataclass(frozen=True)
class Curve:
    """One quantity over another: of run number ``run`` and of the element, joint, load or node ``subject``.

    A ``reference`` is what other curves are compared with. ``peak``: value and time [s] of largest magnitude over all
    accepted steps, which saved times may miss; empty when it is not known.
    """

    x: Quantity
    y: Quantity
    run: int
    subject: str
    reference: bool = False
    peak: tuple = ()


@dataclass(frozen=True)
class Panel:
    """Curves in one pair of axes.

    Attributes
    ----------
    label : str
        What the vertical axis shows, without the unit.
    curves : tuple of Curve
        All y of one unit, all x of one unit.
    logarithmic : bool
        The vertical axis is.
    stepped : bool
        A value holds for the whole step that ends at its time.
    peak : (value, time [s])
        That of the only curve, of one run, to be told in words; may be empty.
    note : str
        Said in small print.
    """

    label: str
    curves: tuple
    logarithmic: bool = False
    stepped: bool = False
    peak: tuple = ()
    note: str = ""

    @property
    def over_time(self):
        """True when the horizontal axis is the time."""
        return all(curve.x.path == "time" for curve in self.curves)

    @property
    def constant(self):
        """True when nothing in it changes."""
        return all(_constant(curve.y.values) for curve in self.curves)

    @property
    def subjects(self):
        """What the curves are quantities of."""
        return tuple(dict.fromkeys(curve.subject for curve in self.curves))

    @property
    def whats(self):
        """The different quantities that are not references, in words."""
        return tuple(dict.fromkeys(curve.y.what for curve in self.curves if not curve.reference))


def _constant(values):
    known = values[np.isfinite(values)]
    return not known.size or np.ptp(known) <= CONSTANT * np.abs(known).max()


@dataclass(frozen=True)
class EventMark:
    """Something that happened at a time [s] to an element in run number ``run``."""

    time: float
    element: str
    text: str
    run: int


@dataclass(frozen=True)
class Sheet:
    """One picture.

    Attributes
    ----------
    name : str
        In the name of its file.
    heading : str
        What it shows, in words.
    panels : tuple of Panel or Sketch
    events : tuple of EventMark
    run_labels : tuple of str
        Of all runs; empty for one run.
    lead : int
        How many of its panels are as important as the first of another sheet.
    table : tuple of tuple
        Lines, a heading first, that are written beside the picture in the place of the numbers of its curves.
    """

    name: str
    heading: str
    panels: tuple
    events: tuple = ()
    run_labels: tuple = ()
    lead: int = field(default=1, compare=False)
    table: tuple = ()

    @property
    def subjects(self):
        """What its curves are quantities of."""
        return tuple(dict.fromkeys(curve.subject for curve in self.curves))

    @property
    def curves(self):
        """The curves of all its panels."""
        return tuple(curve for panel in self.panels if isinstance(panel, Panel) for curve in panel.curves)


def event_marks(runs):
    """Marks of all events of all runs."""
    marks = []
    for number, run in enumerate(runs):
        for event in run.results.events:
            quoted = QUOTED.search(event.element)
            element = quoted[1] if quoted else event.element
            marks.append(EventMark(event.time, element, event.name.replace("_", " "), number))
    return tuple(marks)

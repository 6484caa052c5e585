"""Content of pictures before drawing: sheets of panels of curves."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from mecano.post.quantity import Quantity

if TYPE_CHECKING:
    from mecano.post.event_marks import EventMark
    from mecano.post.sketch import Sketch

Peak: TypeAlias = tuple[float, float] | tuple[()]  # value and time [s] of largest magnitude; empty if unknown
CONSTANT = 1e-5  # of the magnitude: a quantity that varies less is constant
EQUAL = 1e-6  # of the magnitude: curves that differ by less are equal


@dataclass(frozen=True)
class Curve:
    """One quantity over another, of the run of index ``run`` and the element, joint, load or node ``subject``.

    A ``reference`` is shown for comparison. ``measured`` is the name of the file of a measured curve, empty for that of
    a run. ``peak`` is value and time [s] of largest magnitude over all accepted
    steps, which saved times may miss; empty if unknown.
    """

    x: Quantity
    y: Quantity
    run: int
    subject: str
    reference: bool = False
    peak: Peak = ()
    measured: str = ""

    def equals(self, other: "Curve") -> bool:
        """Return whether a curve of the same run has the same values over the same abscissae."""
        kinds = (self.run, self.reference, self.measured), (other.run, other.reference, other.measured)
        pairs = (self.x.values, other.x.values), (self.y.values, other.y.values)
        return kinds[0] == kinds[1] and all(len(a) == len(b) and _equal(a, b) for a, b in pairs)


@dataclass(frozen=True)
class Panel:
    """Curves in one pair of axes.

    Attributes
    ----------
    label : str
        Label of the vertical axis, without the unit.
    curves : tuple of Curve
        Curves with a common unit of y and a common unit of x.
    logarithmic : bool
        Whether the vertical axis is logarithmic.
    decades : bool
        Whether the horizontal axis is logarithmic.
    stepped : bool
        Whether a value holds for the whole step that ends at its time.
    peak : (value, time [s])
        Peak of a single curve of one run, to be written below; may be empty.
    note : str
        Text in small print.
    level : float
        Variation, as a share of the magnitude, up to which the curves are drawn as constant.
    """

    label: str
    curves: tuple[Curve, ...]
    logarithmic: bool = False
    stepped: bool = False
    peak: Peak = ()
    note: str = ""
    decades: bool = False
    level: float = CONSTANT

    @property
    def over_time(self) -> bool:
        """True if the horizontal axis is time."""
        return all(curve.x.path == "time" for curve in self.curves)

    @property
    def constant(self) -> bool:
        """True if all curves are constant."""
        return all(_constant(curve.y.values) for curve in self.curves)

    @property
    def subjects(self) -> tuple[str, ...]:
        """Names of the owners of the curves."""
        return tuple(dict.fromkeys(curve.subject for curve in self.curves))

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of the different quantities except references and measured ones."""
        own = [curve for curve in self.curves if not curve.reference and not curve.measured]
        return tuple(dict.fromkeys(curve.y.what for curve in own))


def _equal(a, b):
    known = np.isfinite(a)
    size = np.abs(a[known]).max(initial=0.0)
    return np.array_equal(known, np.isfinite(b)) and np.all(np.abs(a - b)[known] <= EQUAL * size)


def _constant(values):
    known = values[np.isfinite(values)]
    return not known.size or np.ptp(known) <= CONSTANT * np.abs(known).max()


@dataclass(frozen=True)
class Sheet:
    """One picture.

    Attributes
    ----------
    name : str
        Part of the name of the file.
    heading : str
        Heading of the picture.
    panels : tuple of Panel or Sketch
    events : tuple of EventMark
    run_labels : tuple of str
        Labels of all runs; empty for one run.
    lead : int
        Number of panels as important as the first panel of another sheet.
    table : tuple of tuple
        Lines, the first a heading, written next to the picture instead of the numbers of the curves.
    """

    name: str
    heading: str
    panels: "tuple[Panel | Sketch, ...]"
    events: "tuple[EventMark, ...]" = ()
    run_labels: tuple[str, ...] = ()
    lead: int = field(default=1, compare=False)
    table: tuple[tuple, ...] = ()

    @property
    def subjects(self) -> tuple[str, ...]:
        """Names of the owners of all curves."""
        return tuple(dict.fromkeys(curve.subject for curve in self.curves))

    @property
    def curves(self) -> tuple[Curve, ...]:
        """The curves of all panels."""
        return tuple(curve for panel in self.panels if isinstance(panel, Panel) for curve in panel.curves)

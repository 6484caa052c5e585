"""Layout of a results file: declared series, their names, units and descriptions, and the names of the groups.

A series is a number, vector or matrix written at every saved time. Its path is its name in the file:

    nodes/<name>/position, rotation, velocity, angular_velocity
    elements/<name>/<output>    joints/<name>/<output>    loads/<name>/<output>
    energy/kinetic, potential, dissipated, given, total, balance

The values of one saved time are one flat float64 array: all series in the declared order, each in C order.
docs/results-file.md describes the whole file.
"""

import itertools
import json
import re
from collections.abc import Iterable
from math import prod
from typing import Any, NamedTuple, Self

FORMAT = "mecano results"
FORMAT_VERSION = 1
RESERVED = set("time step_time storage run deck solver events extremes checkpoints VTKHDF xyz wxyz".split())
"""Reserved names at the top of the file, besides index_3, index2_3 and the like."""

AXES = {3: ("x", "y", "z"), 4: ("w", "x", "y", "z")}
"""Names of the components of vectors and of unit quaternions."""


class Series(NamedTuple):
    """Declaration of a series: path in the file, unit, description, shape of one value."""

    path: str
    unit: str
    doc: str
    shape: tuple[int, ...] = ()

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the components in C order: x, y, z of a vector, 0.0, 0.1, ... of a matrix, none of a number."""
        if not self.shape:
            return ()
        if len(self.shape) == 1 and self.shape[0] in AXES:
            return AXES[self.shape[0]]
        return tuple(".".join(map(str, index)) for index in itertools.product(*map(range, self.shape)))

    @property
    def width(self) -> int:
        """Number of components of one value."""
        return prod(self.shape)

    @property
    def plain(self) -> dict[str, Any]:
        """The declaration as plain data."""
        return {"path": self.path, "unit": self.unit, "doc": self.doc, "shape": self.shape}

    @property
    def scalars(self) -> tuple[str, ...]:
        """Paths of its numbers: the path itself, or path.component for each component."""
        return tuple(f"{self.path}.{component}" for component in self.components) or (self.path,)


STEPS = (
    Series("step_size", "s", "size of the accepted step"),
    Series("iterations", "", "Newton iterations of the accepted step"),
    Series("error_estimate", "", "estimated local error, relative to the length scale or to one radian"),
    Series("error_over_tolerance", "", "estimated local error over its allowed value; 0 for fixed steps"),
    Series("rejected", "", "attempts rejected before this step was accepted"),
    Series("force_residual", "", "largest residual force over its tolerance; above 1, rounding of positions"),
    Series("constraint_residual", "", "largest residual constraint over its tolerance"),
    Series("increment", "", "largest last Newton increment over its tolerance"),
)
"""Usual columns of the solver history."""

EXTREMES = {
    "maximum": "largest value",
    "maximum_time": "time of the largest value",
    "minimum": "smallest value",
    "minimum_time": "time of the smallest value",
}
"""Datasets of the extremes of every number over all accepted steps."""

EVENT_TEXTS = {
    "element": "element, joint or load of the event",
    "name": "name of the event",
    "before": "phase before",
    "after": "phase after",
    "impulse_unit": "unit of the impulse; empty for an event without shock",
}
"""Texts of an event."""

EVENT_NUMBERS = {
    "impulse": ("", "impulse of a shock, in impulse_unit, along the growing constraint"),
    "energy_lost": ("J", "energy lost in a shock or release, negative if given in an activation"),
}
"""Numbers of an event besides its time: units and descriptions."""


TIME = Series("time", "s", "saved time")
"""The axis of dynamic runs."""


class Layout:
    """The declared series of a run and the columns of its solver history.

    Parameters
    ----------
    series : sequence of Series
        In the order of the flat array of values.
    steps : sequence of Series
        Columns of the solver history, all numbers, without the time.
    axis : Series
        Independent variable of the rows, usually the time: name, unit, description.

    Raises
    ------
    ValueError
        A path is duplicate, empty, reserved or inside another series; a step column is not a scalar.
    """

    def __init__(self, series: Iterable[Series], steps: Iterable[Series] = STEPS, axis: Series = TIME):
        self.axis = axis
        self.series = tuple(series)
        self.steps = tuple(steps)
        ends = tuple(itertools.accumulate((one.width for one in self.series), initial=0))
        self.slices = {one.path: slice(*ends[i : i + 2]) for i, one in enumerate(self.series)}
        self.size = ends[-1]
        self._check()

    def _check(self):
        if len(self.slices) < len(self.series) or len({one.path for one in self.steps}) < len(self.steps):
            raise ValueError("two series have the same path")
        if any(one.shape or "/" in one.path or one.path in ("", ".", "time", "step_time") for one in self.steps):
            raise ValueError("columns of the solver history are numbers, other than the time")
        for one in self.series:
            parts = one.path.split("/")
            inside = any("/".join(parts[:i]) in self.slices for i in range(1, len(parts)))
            reserved = parts[0] in RESERVED or re.fullmatch(r"index\d*_\d+", parts[0])
            if reserved or inside or {"", ".", ".."} & set(parts) or "\0" in one.path:
                raise ValueError(f"'{one.path}' cannot be the path of a series")

    @property
    def scalars(self) -> list[str]:
        """Paths of all numbers in the order of the flat array."""
        return [path for one in self.series for path in one.scalars]

    @property
    def longest_name(self) -> int:
        """Length in bytes of the longest part of a path."""
        return max((len(part.encode()) for one in self.series for part in one.path.split("/")), default=0)

    def to_json(self) -> str:
        """Return the declarations as JSON text, as stored in the file."""
        series, steps = ([one.plain for one in some] for some in (self.series, self.steps))
        return json.dumps({"series": series, "steps": steps, "axis": self.axis.plain})

    @classmethod
    def from_json(cls, text: str | bytes) -> Self:
        """Return the Layout of a JSON text from a file."""
        stored = json.loads(text)
        series, steps = (
            [Series(**{**one, "shape": tuple(one["shape"])}) for one in stored[key]] for key in ("series", "steps")
        )
        return cls(series, steps, Series(**{**stored["axis"], "shape": ()}))

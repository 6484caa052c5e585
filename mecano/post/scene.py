"""A motion in space as it is played: shapes at some saved times, what they can be coloured by, the ground."""

from dataclasses import dataclass

import numpy as np

from mecano.errors import ResultsError
from mecano.model.mesh import piece_names
from mecano.post.ground import ground_path
from mecano.post.shapes import WHEEL, Motion, shapes

FAR = 3.0  # sizes: the view follows a mechanism that travels farther
STRESS, AXIAL = ("stress", "Pa"), ("axial force", "N")
"""What elements can be coloured by: name, unit."""


@dataclass(frozen=True)
class Scene:
    """What is played of a run.

    Attributes
    ----------
    rows : (n,) array of int
        Numbers of the saved times.
    times : (n,) array
    axis : (str, str)
        What the times are, and their unit.
    shapes : list of Shape
    colours : list of dict
        Of each shape: name -> values (n, pieces).
    ranges : list of (name, unit, lowest, highest)
        Of all that something can be coloured by.
    middle : (n, 3) array
        Of the mechanism at each time [m].
    size : float
        Largest distance from the middle along an axis [m].
    up : int
        The vertical inertial axis.
    grounds : list of (k, 3) arrays
        Lines on the ground [m].
    """

    rows: np.ndarray
    times: np.ndarray
    axis: tuple
    shapes: list
    colours: list
    ranges: list
    middle: np.ndarray
    size: float
    up: int
    grounds: list

    @property
    def follow(self):
        """True when the view has to go along."""
        return bool(np.ptp(self.middle, axis=0).max() > FAR * self.size)


def scene_of(run, most):
    """The Scene of a run, of at most so many saved times. Raises ResultsError where there is nothing to be seen."""
    count = len(run.results.time)
    if not count:
        raise ResultsError(f"{run.results.path}: no saved times yet")
    rows = np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))
    drawn = shapes(Motion(run, rows))
    if not drawn:
        raise ResultsError(f"{run.results.path}: nothing to be drawn, no node has a position")
    cloud = np.concatenate([s.points[:, -1:] if s.style == WHEEL else s.points for s in drawn], axis=1)
    middle = 0.5 * (cloud.min(axis=1) + cloud.max(axis=1))
    size = max(float(np.abs(s.points - middle[:, None]).max()) for s in drawn) or 1.0
    coloured = [_colours(run, shape, rows) for shape in drawn]
    ranges = list(_ranges(coloured))
    told = {what for what, *_ in ranges}
    coloured = [{what: values for what, values in colours.items() if what in told} for colours in coloured]
    gravity, axis = run.deck.get("gravity"), (run.results.axis.path, run.results.axis.unit)
    up = 2 if gravity is None or not any(gravity) else int(np.argmax(np.abs(gravity)))
    grounds = list(_grounds(run, drawn))
    return Scene(rows, run.results.time[rows], axis, drawn, coloured, ranges, middle, size, up, grounds)


def _colours(run, shape, rows):
    """What an element can be coloured by: name -> values (instants, pieces)."""
    d, found = run.deck.get("elements", {}).get(shape.name), {}
    for (what, _), output in ((STRESS, "stress"), (AXIAL, run.display(d).axial)) if d else ():
        paths = [f"elements/{piece}/{output}" for piece in piece_names(shape.name, d)]
        if output and all(path in run.paths for path in paths):
            values = np.stack([run.results.find(path).values[rows] for path in paths], axis=1)
            found[what] = values.reshape(*values.shape[:2], -1)[..., 0]
    return found


def _ranges(coloured):
    """Name, unit, lowest and highest value of all that something can be coloured by and that is not zero throughout."""
    for what, unit in (STRESS, AXIAL):
        arrays = [colours[what] for colours in coloured if what in colours]
        if any(array.any() for array in arrays):
            yield [what, unit, min(float(a.min()) for a in arrays), max(float(a.max()) for a in arrays)]


def _grounds(run, drawn):
    """Lines (k, 3) on the ground along the way of each wheel."""
    for shape in drawn:
        d = run.deck.get("elements", {}).get(shape.name, {})
        if shape.style == WHEEL and "ground" in d:
            radius = np.ptp(shape.points[0, :-1], axis=0).max() * 0.5
            yield from ground_path(run.deck, run.deck["grounds"][d["ground"]], shape.points[:, -1], radius)

"""Contents of a results file: series over time, events, extremes."""

from dataclasses import dataclass

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

MAGNITUDE = ".magnitude"  # of a vector, in the place of a component


@dataclass(frozen=True, repr=False, eq=False)
class Trace(NDArrayOperatorsMixin):
    """A series over the saved times, or one component of it, or a column of the solver history over the steps.

    Attributes
    ----------
    path : str
        Path in the file, with the name of the component if it is one.
    unit, doc : str
    components : tuple of str
        Names of the components; empty for numbers.
    time : (n,) array
        Saved times, or ends of the accepted steps [s].
    values : (n, ...) array
        Functions of NumPy, arithmetic, comparisons and indices take them from the Trace itself, and return arrays.
    """

    path: str
    unit: str
    doc: str
    components: tuple[str, ...]
    time: np.ndarray
    values: np.ndarray

    def __array__(self, dtype=None, copy=None):
        """Return the values as an array."""
        values = np.asarray(self.values, dtype)
        return values.copy() if copy else values

    def __array_ufunc__(self, ufunc, method, *inputs, **options):
        """Return what a function of NumPy gives for the values."""
        return getattr(ufunc, method)(*(np.asarray(x) if isinstance(x, Trace) else x for x in inputs), **options)

    def __getitem__(self, index):
        """Return values by index, as ``values[index]``."""
        return self.values[index]

    def __len__(self):
        return len(self.values)

    def __repr__(self):
        components = f" of {', '.join(self.components)}" if self.components else ""
        return f"Trace {self.path!r}{components} [{self.unit}]: {self.doc}; {len(self)} values"

    @property
    def magnitude(self) -> "Trace":
        """The lengths of the vectors, a Trace of numbers."""
        lengths = np.linalg.norm(self.values.reshape(len(self.time), -1), axis=1)
        return Trace(self.path + MAGNITUDE, self.unit, f"magnitude: {self.doc}", (), self.time, lengths)


@dataclass(frozen=True)
class Event:
    """An event of an element, joint or load at a time [s], with its phases before and after.

    A shock also has an impulse, with its unit, and the energy lost [J]; other events have 0, "" and 0.
    """

    time: float
    element: str
    name: str
    before: str
    after: str
    impulse_unit: str = ""
    impulse: float = 0.0
    energy_lost: float = 0.0


@dataclass(frozen=True)
class Extreme:
    """Largest and smallest value of a number over all accepted steps, with their times [s]."""

    maximum: float
    maximum_time: float
    minimum: float
    minimum_time: float
    unit: str

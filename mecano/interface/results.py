"""Results in Python: conversion to xarray and pandas, plots, display in notebooks."""

import os
from dataclasses import replace
from html import escape
from importlib import import_module
from io import BytesIO
from typing import TYPE_CHECKING, Any

from mecano.errors import ResultsError, UnknownNameError, UsageError
from mecano.results import reader
from mecano.results.layout import AXES
from mecano.results.lookup import require_names

if TYPE_CHECKING:
    from types import ModuleType

    import pandas
    import xarray
    from matplotlib.figure import Figure


class Results(reader.Results):
    """An open results file, with conversion to xarray and pandas, and plots; displayed as a table in notebooks.

    Examples
    --------
    >>> results = mecano.run("pendulum.yaml", quiet=True)
    >>> results.status
    'complete'
    >>> angle = results["hinge.angle"]
    >>> angle.unit, len(angle.time)
    ('rad', 201)
    >>> "hinge.torque" in results
    False
    >>> round(results.extremes["hinge.angle"].maximum, 4)
    3.1416
    """

    def __fspath__(self) -> str:
        """Return the path of the file, so that results may stand for their file."""
        return str(self.path)

    def to_xarray(self, *patterns: str) -> "xarray.Dataset":
        """Return outputs at the saved times as a Dataset: all, or those that match patterns such as "wheel.*".

        Every variable has the attributes ``units`` and ``long_name``. Raises UnknownNameError if no output matches,
        ImportError without xarray.
        """
        xarray = imported("xarray", "Results.to_xarray")
        variables = {}
        for trace in self._matching(patterns):
            attributes = {"units": trace.unit, "long_name": trace.doc}
            variables[_dotted(trace.path)] = (self._dimensions(trace.values.shape[1:]), trace.values, attributes)
        coordinates: dict[str, Any] = {
            self.axis.path.replace(" ", "_"): ((self._dimension,), self.time, {"units": self.axis.unit})
        }
        widths = {variables[name][1].shape[1] for name in variables if variables[name][1].ndim == 2}
        coordinates |= {"".join(AXES[width]): list(AXES[width]) for width in widths & AXES.keys()}
        attributes = {"title": self.metadata["title"], "status": self.status, "mecano": self.metadata["version_mecano"]}
        return xarray.Dataset(variables, coordinates, attributes)

    @property
    def _dimension(self):
        return self.axis.path.replace(" ", "_")

    def _dimensions(self, shape):
        """Names of the dimensions of a series, as in the file."""
        if len(shape) == 1 and shape[0] in AXES:
            return (self._dimension, "".join(AXES[shape[0]]))
        return (self._dimension, *(f"index{i or ''}_{size}" for i, size in zip((0, 2, 3), shape, strict=False)))

    def to_pandas(self, *patterns: str) -> "pandas.DataFrame":
        """Return outputs at the saved times as a DataFrame: a column per scalar, all or those that match patterns.

        ``frame.attrs["units"]`` has the unit of each column. Raises UnknownNameError if no output matches,
        ImportError without pandas.
        """
        pandas = imported("pandas", "Results.to_pandas")
        columns: dict[str, Any] = {}
        units: dict[str, str] = {}
        for trace in self._matching(patterns):
            names = [f"{_dotted(trace.path)}.{c}" for c in trace.components] or [_dotted(trace.path)]
            numbers = trace.values.reshape(len(self.time), len(names)).T
            columns |= dict(zip(names, numbers, strict=True))
            units |= dict.fromkeys(names, trace.unit)
        frame = pandas.DataFrame(columns, index=pandas.Index(self.time, name=self.axis.path))
        frame.attrs["units"] = units
        return frame

    def _matching(self, patterns):
        """Return the Traces of all outputs that match patterns; of single components if a pattern names these."""
        require_names(patterns)
        return [self.find(name) for pattern in patterns or ("*",) for name in self._names_of(pattern)]

    def _names_of(self, pattern):
        names = self.names(pattern)
        if not names and pattern != "*":
            if "*" in pattern or "?" in pattern:
                raise UnknownNameError(f"no output of {self.path} matches '{pattern}'; Results.names() lists them")
            self._lookup.find(pattern)  # raises with similar names
            names = [pattern]
        return names

    def plot(self, *names: str, title: str | None = None) -> "Plot":
        """Plot outputs over time or over another output: "hinge.angle", "a,b" in one panel, "force:stroke".

        Without names, plot the overview of the model. Raises UnknownNameError, UsageError, and ResultsError without
        saved times.
        """
        from mecano.post.figure import overview_figure, sheet_figure
        from mecano.post.info import one_line
        from mecano.post.overview import overview
        from mecano.post.request import requested_sheets
        from mecano.post.runs import Run
        from mecano.post.sheet import Panel
        from mecano.post.sheets import default_sheets

        require_names(names)
        if not len(self.time):
            raise ResultsError(f"{self.path}: no saved times yet")
        run = Run(self)
        heading = title or run.title
        if not names:
            sheets = default_sheets([run])
            if not sheets:
                raise UsageError("nothing moves and no force acts in these results; ask for a plot by name")
            return Plot(overview_figure(overview(sheets), heading, one_line([run])))
        sheets = requested_sheets(names, [run])
        panels = tuple(panel for sheet in sheets for panel in sheet.panels if isinstance(panel, Panel))
        return Plot(sheet_figure(replace(sheets[0], panels=panels, heading=", ".join(names)), heading))

    def __repr__(self):
        if self._opened is None:
            return f"Results {str(self.path)!r}: closed"
        return f"Results {str(self.path)!r}: {self.status}, {len(self.time)} saved times, {len(self.names())} outputs"

    def _repr_html_(self) -> str:
        """Return the table that notebooks display: status, solver statistics, provenance."""
        from mecano.post.info import facts

        if self._opened is None:
            return escape(repr(self))
        rows = [("status", f"{self.status}: {self.reason}" if self.reason else self.status), *facts(self)]
        cells = "".join(
            f'<tr><th style="text-align:left">{escape(label)}</th><td style="text-align:left">{escape(text)}</td></tr>'
            for label, text in rows
        )
        return f"<table><caption>{escape(str(self.path))}</caption>{cells}</table>"


class Plot:
    """A plot displayed by notebooks; ``figure`` is the Figure of matplotlib."""

    def __init__(self, figure: "Figure"):
        self.figure = figure

    def __repr__(self):
        return "Plot: notebooks display it, save('plot.png') writes it"

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the plot in the format of the file extension: .png, .svg, .pdf, ..."""
        self._write(path)

    def _repr_png_(self):
        stream = BytesIO()
        self._write(stream, format="png")
        return stream.getvalue()

    def _write(self, target, **options):
        import matplotlib

        from mecano.post.style import SETTINGS

        with matplotlib.rc_context(SETTINGS):  # type: ignore[arg-type]  # matplotlib lists the names of all settings
            self.figure.savefig(target, **options)


def open_results(path: str | os.PathLike[str]) -> Results:
    """Open a results file; usable in a ``with`` block. Raises ResultsError."""
    return Results(path)


def preformatted(text: str) -> str:
    """Return a text as notebooks display it, with its lines and columns."""
    return f"<pre>{escape(text)}</pre>"


def _dotted(path):
    return path.replace("/", ".")


def imported(library: str, method: str) -> "ModuleType":
    """Import an optional library. Raises ImportError with the command that installs it."""
    try:
        return import_module(library)
    except ImportError as error:
        raise ImportError(f"{method} needs {library}: pip install {library}") from error

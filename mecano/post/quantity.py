"""Quantities of a results file by name: outputs, components, magnitudes, solver history, and derived quantities.

Names are those of the results reader (``wheel.radial_force``, ``axle.position.z``) and in addition

    <vector>.magnitude      length of a vector
    <wheel>.rolling_rate    spin rate of rolling without slip
    <superelement>.<node>.position, displacement    of a node inside a superelement
    <spring>.compression_force   axial force, > 0 in compression, as usual for shock absorbers
    <wheel>.drag_force      force of the ground on the wheel, > 0 against its motion
    solver.<column>         solver history, a value for each accepted step; also with * or ?
    time
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

import numpy as np

from mecano.deck.units import ANY, factor_of
from mecano.deck.wording import suggestion
from mecano.errors import UnknownNameError, UsageError
from mecano.post import recovered
from mecano.results.recorded import MAGNITUDE

if TYPE_CHECKING:
    from mecano.post.sheet import Peak
    from mecano.results.reader import Results

BY_SIGNALS = dict.fromkeys(
    ("given_power", "dissipated_power"), "signals read these powers in a run: add one that does to the deck"
) | {"work": "the work is a signal of the type 'integrator' of the 'given_power' in the deck"}
"""Hints on quantities that only signals compute, by their last word."""
SAVED, STEPS = "saved times", "accepted steps"
SAME = 1e-9  # of a peak: saved values nearer to it are the peak, but for rounding


@dataclass(frozen=True)
class Quantity:
    """A number over time.

    Attributes
    ----------
    path : str
        Path in the file, with the component: elements/wheel/contact_force.z.
    unit, doc : str
    clock : str
        The times of the values: SAVED or STEPS, or a name for those of a derived quantity.
    time, values : (n,) arrays
    axis : (str, str)
        Name and unit of the times; for statics those of the load factor.
    """

    path: str
    unit: str
    doc: str
    clock: str
    time: np.ndarray
    values: np.ndarray
    axis: tuple[str, str] = ("time", "s")

    @property
    def subject(self) -> str:
        """Name of the owner: an element, joint, load or node, or "energy", "solver"."""
        return self.path.split("/")[-2] if "/" in self.path else ""

    @property
    def what(self) -> str:
        """The quantity as text: radial force, position z."""
        if self.path == "time":
            return self.axis[0]
        if self.path.endswith(MAGNITUDE):
            return f"|{self.whole}|"
        return self.path.split("/")[-1].replace("_", " ").replace(".", " ") if not self.of_signal else "signal"

    @property
    def of_signal(self) -> bool:
        """True for the value of a signal, whose name is that of its owner."""
        return self.path.startswith("signals/") and self.path.endswith("/value")

    @property
    def whole(self) -> str:
        """The quantity as text, without a component."""
        return self.subject if self.of_signal else self.path.split("/")[-1].partition(".")[0].replace("_", " ")

    @property
    def owned(self) -> str:
        """The quantity as text with its owner: wheel radial force."""
        return self.subject if self.of_signal else f"{self.subject} {self.what}".strip()


@dataclass(frozen=True)
class Derived:
    """A function of outputs of the same element; ``factor`` is set if it is a multiple of a single output."""

    unit: str
    doc: str
    needs: tuple[str, ...]
    function: Callable[..., np.ndarray]
    factor: float | None = None


DERIVED = {
    "rolling_rate": Derived(
        "rad/s",
        "v/r: spin rate without longitudinal slip",
        ("spin_rate", "longitudinal_slip", "loaded_radius"),
        lambda spin, slip, radius: spin + slip / radius,  # slip along t = v - r spin, exact for any lean
    ),
    "compression_force": Derived(
        "N", "axial force, > 0 pushes the nodes apart", ("force",), lambda force: -force, factor=-1.0
    ),
    "drag_force": Derived(
        "N", "force of the ground against the motion", ("longitudinal_force",), lambda force: -force, factor=-1.0
    ),
}


def find(results: "Results", name: str) -> list[Quantity]:
    """Return the Quantities of a name, one per component of a vector; with * or ?, those of all matching names.

    Raises UnknownNameError with similar names, UsageError if nothing matches, ResultsError for an unreadable file.
    """
    axis = results.axis.path, results.axis.unit
    return [replace(_as_declared(results, quantity), axis=axis) for quantity in _found(results, name)]


def _as_declared(results, quantity):
    """Return the values of a signal in the unit that its deck declares, such as deg; the results have SI units."""
    unit, factor = _declared_unit(results, quantity.path)
    return replace(quantity, unit=unit, values=quantity.values / factor) if unit else quantity


def unit_of(results: "Results", path: str) -> str:
    """Return the unit of an output in the file or derived from it, of a signal the one that its deck declares."""
    last, series = path.rpartition("/")[2], results.series
    if last in DERIVED:
        return DERIVED[last].unit
    return _declared_unit(results, path)[0] or (series.get(path) or series[path.rpartition(".")[0]]).unit


def _declared_unit(results, path):
    """Return (unit, its value in SI) that the deck declares for an output, or ("", 1)."""
    section, _, rest = path.partition("/")
    owner, _, output = rest.rpartition("/")
    known = results.resolved.get("signals", {}) if (section, output) == ("signals", "value") else {}
    unit = known.get(owner, {}).get("unit", "-")
    return ("", 1.0) if unit == "-" else (unit, factor_of(unit, ANY))


def _found(results, name):
    if name == "time":
        return [Quantity("time", results.axis.unit, results.axis.doc, SAVED, results.time, results.time)]
    if name.startswith(("solver.", "solver/")):
        return _of_solver(results, name[len("solver.") :])
    if "*" in name or "?" in name:
        paths = results.names(name)
        if not paths:
            raise UsageError(f"no output of {results.path} matches '{name}'; `mecano info --names` lists them")
        return [q for path in paths for q in _components(results.find(path))]
    if inner := recovered.named(results, name):
        return _recovered(results, *inner)
    stem, _, last = name.replace("/", ".").rpartition(".")
    if last in DERIVED:
        return [_derived(results, stem, last)]
    try:
        return _components(results.find(name))
    except UnknownNameError as error:
        if last not in BY_SIGNALS:
            raise
        raise UnknownNameError(f"{error} ({BY_SIGNALS[last]})") from None


def peak_of(results: "Results", quantity: Quantity) -> "Peak":
    """Return value and time [s] of largest magnitude over all accepted steps, or () if unknown."""
    owner, _, name = quantity.path.rpartition("/")
    derived = DERIVED.get(name)
    factor = derived.factor if derived else 1.0
    if factor is None:  # of several outputs
        return ()
    extreme = results.extremes.get(f"{owner}/{derived.needs[0]}" if derived else quantity.path)
    if extreme is None or not np.isfinite([extreme.maximum, extreme.minimum]).all():
        return ()
    factor /= _declared_unit(results, quantity.path)[1]
    if abs(extreme.maximum) >= abs(extreme.minimum):
        return first_of_peak(quantity, factor * extreme.maximum, extreme.maximum_time)
    return first_of_peak(quantity, factor * extreme.minimum, extreme.minimum_time)


def first_of_peak(quantity: Quantity, peak: float, time: float) -> tuple[float, float]:
    """Return a ``peak`` and its ``time`` [s]; of a value that is then kept but for rounding, the first time saved."""
    before = quantity.time[np.abs(quantity.values - peak) <= SAME * abs(peak)]
    return peak, min(time, float(before[0])) if len(before) else time


def time_of(quantity: Quantity) -> Quantity:
    """Return the times of a quantity as a Quantity."""
    name, unit = quantity.axis
    return replace(quantity, path="time", unit=unit, doc=name, values=quantity.time)


def largest(values: np.ndarray) -> float:
    """Return the largest magnitude of the finite values, 0 if there are none."""
    return float(np.max(np.abs(values), where=np.isfinite(values), initial=0.0))


def _components(trace):
    numbers = trace.values.reshape(len(trace.time), -1)
    paths = [f"{trace.path}.{component}" for component in trace.components] or [trace.path]
    return [
        Quantity(path, trace.unit, trace.doc, SAVED, trace.time, values)
        for path, values in zip(paths, numbers.T, strict=True)
    ]


def _recovered(results, path, doc, values, component):
    """Return the Quantities of all components of ``values``, of a single component, or of the magnitude."""
    columns = dict(zip("xyz", values.T, strict=True))
    columns["magnitude"] = np.linalg.norm(values, axis=1)
    wanted = [component] if component else ["x", "y", "z"]
    return [Quantity(f"{path}.{c}", "m", doc, SAVED, results.time, columns[c]) for c in wanted]


def _derived(results, stem, name):
    derived = DERIVED[name]
    traces = [results.find(f"{stem}.{needed}") for needed in derived.needs]
    if any(trace.components for trace in traces):
        raise UsageError(f"'{name}' exists for springs and dampers only, whose force is a scalar, not for '{stem}'")
    path = traces[0].path.rpartition("/")[0] + "/" + name
    values = derived.function(*(trace.values for trace in traces))
    return Quantity(path, derived.unit, derived.doc, SAVED, results.time, values)


def _of_solver(results, pattern):
    known = results.step_columns
    columns = [column for column in known if fnmatchcase(column, pattern)]
    if not columns:
        raise UsageError(f"no column '{pattern}' in the solver history; {suggestion(pattern, known)}")
    traces = [results.find(f"solver.{column}") for column in columns]
    return [Quantity(trace.path, trace.unit, trace.doc, STEPS, trace.time, trace.values) for trace in traces]

"""The standard sheets of a model: those of its kinds, energies, solver, and the mechanism itself."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mecano.post.deployment import deployment_sheet
from mecano.post.drop_test import drop_sheet
from mecano.post.event_groups import shock_sheet
from mecano.post.event_marks import event_marks
from mecano.post.members import member_sheets
from mecano.post.panels import planned_panels, worth_showing
from mecano.post.plans import plans
from mecano.post.quantity import find, time_of
from mecano.post.runs import Run
from mecano.post.sheet import Curve, Panel, Sheet
from mecano.post.sketch import sketch
from mecano.results.energy_balance import EXCHANGED, scale_of_balance

MOST_SKETCHES = 4  # runs sketched on one sheet
WIDE_RANGE = 3.0  # ratio of largest to smallest value above which the axis is logarithmic
SMALLEST = 1e-16  # shown on logarithmic axes
NOTES = {
    "step size": lambda values: f"{len(values)} steps",
    "Newton iterations": lambda values: f"{np.mean(values):.2f} per step",
    "rejected trials": lambda values: f"{np.sum(values):.0f} in all",
}
RESIDUALS, ERROR = "residuals over their tolerances", "error of a step over its allowed value"
ESTIMATE = "estimated error of a step"
EXPLAINED = {
    RESIDUALS: "below 1: converged; a force above 1: rounding of positions",
    ESTIMATE: "over the length scale, or in rad",
    ERROR: "steps above 1 are repeated with a smaller size",
}


def default_sheets(runs: Sequence[Run]) -> list[Sheet]:
    """Return all sheets of these runs, the sketches of the mechanism first."""
    planned = [_planned(plan, runs) for plan in plans(runs)]
    sheets = [
        _mechanism(runs),
        _path(runs),
        *member_sheets(runs),
        *planned,
        drop_sheet(runs),
        deployment_sheet(runs),
        _energies(runs),
        _solver(runs),
    ]
    labels = tuple(run.label for run in runs) if len(runs) > 1 else ()
    marks = event_marks(runs)
    sheets = [replace(sheet, events=marks) for sheet in sheets]
    sheets.append(shock_sheet(runs))  # without marks, as its curves are the events
    return [replace(sheet, run_labels=labels) for sheet in sheets if sheet.panels]


def _planned(plan, runs):
    panels, remark = planned_panels(plan, runs)
    heading = f"{plan.heading} ({remark})" if remark else plan.heading
    sheet = Sheet(plan.name, heading, tuple(panels), lead=plan.lead)
    return replace(sheet, heading=f"{heading}: {sheet.subjects[0]}") if len(sheet.subjects) == 1 else sheet


def _mechanism(runs):
    sketches = [one for run in runs[:MOST_SKETCHES] if (one := sketch(run)) is not None]
    return Sheet("mechanism", "Mechanism", tuple(sketches))


def _path(runs):
    """Return the Sheet of the equilibrium path: load factor over the coordinate that changes most, and stability."""
    static = [(number, run) for number, run in enumerate(runs) if "static/load_factor" in run.paths]
    loads, unstable = [], []
    for number, run in static:
        positions = [name for name in run.ranges if name.startswith("nodes/") and "/position." in name]
        moves = max(positions, key=run.ranges.get, default="")
        factor, x = find(run.results, "static/load_factor")[0], find(run.results, moves) if moves else []
        loads += [Curve(one, factor, number, one.subject) for one in x]
        count = find(run.results, "static/unstable_directions")[0]
        unstable.append(Curve(time_of(count), count, number, "static"))
    panels = [Panel("load factor", tuple(loads))] if any(np.ptp(c.y.values) for c in loads) else []
    if any(np.any(curve.y.values) for curve in unstable):
        panels.append(Panel("unstable directions", tuple(unstable), stepped=True))
    return Sheet("path", "Path of equilibria", tuple(panels))


def _energies(runs):
    changes, errors = [], []
    scales: dict[str, None] = {}
    for number, run in enumerate(runs):
        energies = {name: y for name in (*EXCHANGED, "balance") for y in _found(run, f"energy/{name}")}
        changes += [Curve(time_of(y), _changed(y), number, "energy") for n, y in energies.items() if n != "balance"]
        balance = energies.get("balance")
        if balance is not None and balance.values.size:
            compared, scale = scale_of_balance({n: (y.values.min(), y.values.max()) for n, y in energies.items()})
            errors.append(Curve(time_of(balance), _relative(_changed(balance), scale), number, "energy"))
            scales[compared] = None
    main = Panel("change of energy", tuple(changes))
    error = Panel("error of the energy balance", tuple(errors), note=f"relative to {' or '.join(scales)}")
    panels = (*worth_showing([main], runs), *worth_showing([error], runs))
    return Sheet("energy", "Energy: changes since the start", panels)


def _found(run, path):
    return find(run.results, path) if path in run.paths else []


def _changed(quantity):
    """Return the change of a quantity since the start, because the zero of potential energies is arbitrary."""
    return replace(quantity, values=quantity.values - quantity.values[:1])


def _relative(quantity, size):
    """Return a quantity divided by ``size`` of the same unit; zeros if ``size`` is zero."""
    return replace(quantity, unit="-", values=quantity.values / size if size else 0.0 * quantity.values)


def _solver(runs):
    panels = (
        _history(runs, "step size", ("step_size",)),
        _history(runs, "Newton iterations", ("iterations",)),
        _history(runs, RESIDUALS, ("force_residual", "constraint_residual", "increment")),
        _history(runs, ESTIMATE, ("error_estimate",)),
        _history(runs, ERROR, ("error_over_tolerance",)),
        _history(runs, "rejected trials", ("rejected",)),
    )
    return Sheet("solver", "Solver", tuple(panel for panel in panels if panel is not None))


def _history(runs, label, columns):
    """Return a Panel of columns of the solver history, or None if all values are zero."""
    found = [
        Curve(time_of(q), q, number, "solver")
        for number, run in enumerate(runs)
        for column in columns
        if column in run.results.step_columns
        for q in find(run.results, f"solver.{column}")
    ]
    curves = tuple(curve for curve in found if np.any(curve.y.values > 0.0))
    if not curves:
        return None
    logarithmic = _ranges_widely(curves)
    note = NOTES[label](curves[0].y.values) if len(runs) == 1 and label in NOTES else EXPLAINED.get(label, "")
    return Panel(label, curves, logarithmic=logarithmic, stepped=True, note=note)


def _ranges_widely(curves):
    values = np.concatenate([curve.y.values for curve in curves])
    values = values[values > SMALLEST]
    return bool(values.size) and values.max() > WIDE_RANGE * values.min() and not _whole_numbers(values)


def _whole_numbers(values):
    return np.array_equal(values, np.round(values))

"""Panels of outputs of elements: selection of curves, removal of noise, and peaks."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mecano.post.plans import ON_GROUND, Plan, pictures_of
from mecano.post.quantity import DERIVED, Quantity, find, largest, peak_of, time_of, unit_of
from mecano.post.runs import Run
from mecano.post.sheet import Curve, Panel
from mecano.results.recorded import MAGNITUDE

MOST = 6  # elements of one run shown together
MOST_OF_SEVERAL = 2  # elements of each of several runs
FAR_APART = 20.0  # ratio of magnitudes above which curves do not share a panel
MOST_COMPARED = 8  # times the number shown: how many elements are compared with one another
TURNS = 4.0 * np.pi  # rad; a larger angle is that of something that spins, of which the rate says more
ALIKE = 0.1  # of the range of a curve: one that differs by less from a curve shown is shown last
NOTHING = 1e-8  # of the largest value of the same unit: smaller values are numerical noise


def planned_panels(plan: Plan, runs: Sequence[Run]) -> tuple[list[Panel], str]:
    """Return the panels of a plan for the most active elements, and a note on elements omitted."""
    things = _element_paths(plan, runs)
    shown = _most_active(things, plan.views[0], runs)
    panels = [panel for view in plan.views if (panel := _panel(view, shown, runs)).curves]
    remark = f"{len(shown)} of {len(things)}, those with events or that vary most" if len(shown) < len(things) else ""
    own_unit = [part for panel in panels for part in _by_unit(panel)]
    parts = [part for panel in worth_showing(own_unit, runs) for part in _by_size(panel)]
    return [with_peaks(part, runs) for part in parts], remark


def _by_unit(panel):
    """Split a panel into panels of one unit, because signals may have any."""
    units = dict.fromkeys(curve.y.unit for curve in panel.curves)
    return [replace(panel, curves=tuple(c for c in panel.curves if c.y.unit == unit)) for unit in units]


def _by_size(panel):
    """Split a panel into panels for elements with values of similar magnitude, so that all are visible.

    Angles of what spins, which grow all the time, have a panel of their own.
    """
    angles = panel.over_time and panel.curves[0].y.unit == "rad"
    size: dict[str, float] = {}  # by subject
    for curve in panel.curves:
        size[curve.subject] = max(size.get(curve.subject, 0.0), largest(curve.y.values))
    groups: list[list[str]] = []
    for subject in sorted(size, key=size.__getitem__, reverse=True):
        first = size[groups[-1][0]] if groups else 0.0
        if not groups or size[subject] * FAR_APART < first or (angles and size[subject] <= TURNS < first):
            groups.append([])
        groups[-1].append(subject)
    return [replace(panel, curves=tuple(c for c in panel.curves if c.subject in group)) for group in groups]


def worth_showing(panels: Sequence[Panel], runs: Sequence[Run]) -> list[Panel]:
    """Return the panels without curves that are noise compared with others or with the whole motion.

    Curves over outputs that are noise become curves over time.
    """
    scale: dict[str, float] = {}  # by unit
    for unit, value in (item for run in runs for item in run.scales.items()):
        scale[unit] = max(scale.get(unit, 0.0), value)
    for curve in (curve for panel in panels for curve in panel.curves):
        scale[curve.y.unit] = max(scale.get(curve.y.unit, 0.0), largest(curve.y.values))
    if "m" in scale:  # moments are compared with forces times the size of the mechanism, and vice versa
        size, force, moment = scale["m"], scale.get("N", 0.0), scale.get("N m", 0.0)
        scale |= {"N m": max(moment, force * size), "N": max(force, moment / size if size else 0.0)}
    left = max((run.force_noise for run in runs), default=0.0)
    least = {unit: max(NOTHING, left if unit in ("N", "N m") else 0.0) * size for unit, size in scale.items()}
    for unit, size in (item for run in runs for item in run.rounding.items() if item[0] in least):
        least[unit] = max(least[unit], size)
    kept = []
    for panel in panels:
        curves = tuple(c for c in panel.curves if largest(c.y.values) > least[c.y.unit])
        if any(not curve.reference for curve in curves):
            if all(largest(curve.x.values) <= least.get(curve.x.unit, 0.0) for curve in curves):
                curves = tuple(replace(curve, x=time_of(curve.y)) for curve in curves)
            kept.append(replace(panel, curves=curves))
    return kept


def _element_paths(plan, runs):
    """Return the paths of the elements, joints and loads of the plan's kinds, in the order of the decks."""
    return list(dict.fromkeys(path for run in runs for path in run.pieces if plan.name in pictures_of(run, path)))


def _most_active(things, view, runs):
    """Return as many elements as colours distinguish; of signals, as many of each unit."""
    most = MOST if len(runs) == 1 else MOST_OF_SEVERAL
    if len(things) <= most:
        return things
    rank = {thing: max(_activity(view, thing, run) for run in runs if thing in run.pieces) for thing in things}
    alike: dict[str, list[str]] = {}
    for thing in sorted(things, key=rank.__getitem__, reverse=True):
        run = next(run for run in runs if thing in run.pieces)
        unit = _unit(run, _first_name(view, thing, run)) if thing.startswith("signals/") else ""
        alike.setdefault(unit, []).append(thing)
    chosen = {thing for some in alike.values() for thing in _distinct(some, view, runs, most)}
    return [thing for thing in things if thing in chosen]


def _distinct(ordered, view, runs, most):
    """Return the first ``most`` of elements in an order, those whose first curve is like that of an earlier one last.

    Many alike, as the feet of a table, would leave no place for others.
    """
    chosen: list[str] = []
    alike: list[str] = []
    curves: list[Quantity] = []
    for thing in ordered[: MOST_COMPARED * most]:
        if len(chosen) == most:
            break
        run = next(run for run in runs if thing in run.pieces)
        quantity = next((one for output in view.outputs if (one := _quantity(run, thing, output))), None)
        if quantity is not None and any(_like(quantity, other) for other in curves):
            alike.append(thing)
        else:
            chosen.append(thing)
            curves += [quantity] if quantity is not None else []
    return (chosen + alike + ordered[MOST_COMPARED * most :])[:most]


def _like(one, other):
    """Return whether two quantities of one unit at the same times differ by less than ALIKE of their range."""
    a, b = one.values, other.values
    if one.unit != other.unit or len(a) != len(b) or not len(a):
        return False
    known = np.isfinite(a) & np.isfinite(b)
    return bool(known.any()) and np.abs(a - b)[known].max() <= ALIKE * max(np.ptp(a[known]), np.ptp(b[known]))


def _activity(view, thing, run):
    """Return a rank, larger for elements to show first: whether it has events, does not spin, and how much it varies.

    The last is the range of the first output of the view over all accepted steps; of the speed of a body that of its
    momentum, by which a chassis comes before its wheels.
    """
    d, name = run.pieces[thing], _first_name(view, thing, run)
    extent, unit = _range(run, name), _unit(run, name)
    if unit == "m/s":
        extent *= d.get("mass", 1.0)
    return (d["type"], thing.partition("/")[2]) in run.with_events, unit != "rad" or extent <= TURNS, extent


def _first_name(view, thing, run):
    """Return the name of the first output of a view that an element has, or ""."""
    return next((name for output in view.outputs if (name := _name_of(run, thing, output))), "")


def _range(run, name):
    """Return the range of an output, of a derived one that of the first output on which it depends."""
    owner, _, last = name.removesuffix(MAGNITUDE).rpartition("/")
    return run.ranges.get(f"{owner}/{DERIVED[last].needs[0] if last in DERIVED else last}", 0.0)


def _unit(run, name):
    return unit_of(run.results, name) if name else ""


def _panel(view, things, runs):
    curves = [
        curve
        for number, run in enumerate(runs)
        for thing in things
        if thing in run.pieces
        for curve in _curves(view, thing, run, number)
    ]
    lengths = curves and all(curve.y.path.endswith(MAGNITUDE) and curve.y.whole == view.label for curve in curves)
    return Panel(f"|{view.label}|" if lengths else view.label, tuple(curves))


def _curves(view, thing, run, number):
    subject = thing.partition("/")[2]
    x = None if view.against == "time" else _quantity(run, thing, view.against)
    for output in (*view.outputs, view.reference):
        y = _quantity(run, thing, output)
        if y is not None:
            yield Curve(x or time_of(y), y, number, subject, output == view.reference)


def _quantity(run, thing, output):
    name = _name_of(run, thing, output)
    quantity = find(run.results, name)[0] if name else None
    if output in ON_GROUND and quantity and f"{thing}/normal_force" in run.paths:
        return _while_pressed(quantity, run.results.find(f"{thing}/normal_force").values > 0.0)
    return quantity


def _while_pressed(quantity, pressed):
    """Return the quantity with gaps while a wheel is in the air, except at the row before touch-down."""
    begins = np.append(pressed[1:], False)
    return replace(quantity, values=np.where(pressed | begins, quantity.values, np.nan))


def _name_of(run, thing, output):
    """Return the name of the first alternative of an output that the file has for this element, or ""."""
    for alternative in filter(None, output.split("|")):
        owner, name = thing, alternative
        if alternative.startswith("node."):
            owner, name = f"nodes/{run.pieces[thing].get('node')}", alternative.removeprefix("node.")
        stem = name.partition(".")[0]
        needed = DERIVED[stem].needs if stem in DERIVED else (stem,)
        if all(f"{owner}/{one}" in run.paths for one in needed):
            return _signed(run, f"{owner}/{name}")
    return ""


def _signed(run, name):
    """Return the name without ".magnitude" for a scalar, whose sign would be lost."""
    stem = name.removesuffix(MAGNITUDE)
    return name if stem != name and run.results.series[stem].shape else stem


def with_peaks(panel: Panel, runs: Sequence[Run]) -> Panel:
    """Return the panel with the peaks of its curves over all accepted steps, if it is over time."""
    if not panel.over_time:
        return panel
    curves = tuple(replace(curve, peak=_peak(curve, runs[curve.run].results)) for curve in panel.curves)
    own = [curve for curve in curves if not curve.reference]
    return replace(panel, curves=curves, peak=own[0].peak if len(runs) == len(own) == 1 else ())


def _peak(curve, results):
    """Return the peak of a curve, or () if it lies in a gap."""
    peak = peak_of(results, curve.y)
    return peak if peak and np.isfinite(np.interp(peak[1], curve.y.time, curve.y.values)) else ()

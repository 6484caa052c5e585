"""Pictures and tables of results files."""

import csv
import math
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import every_kind
import h5py
import matplotlib
import matplotlib.figure
import matplotlib.image
import numpy as np
import pytest
from time_runs import INPUTS, deck

import mecano
from mecano.cli import commands
from mecano.elements import KINDS
from mecano.errors import ResultsError, UnknownNameError, UsageError
from mecano.model.extremes import Extremes
from mecano.post import configurations, draw_panel, figure, pictures, plans, report_page, sheets, style
from mecano.post.animation import animate
from mecano.post.configurations import configurations_figure
from mecano.post.curve_styles import CurveStyles
from mecano.post.draw_events import EventLegend
from mecano.post.draw_sketch import draw_shapes
from mecano.post.event_marks import EventMark, event_marks
from mecano.post.extremes import notable
from mecano.post.info import info
from mecano.post.overview import PLACES, overview
from mecano.post.panels import planned_panels, worth_showing
from mecano.post.pictures import post
from mecano.post.plans import Plan, View
from mecano.post.quantity import Quantity, find, first_of_peak, peak_of, time_of
from mecano.post.request import Request, requested_sheet
from mecano.post.runs import labels, open_runs
from mecano.post.shapes import BODY, CABLE, Shape
from mecano.post.sheet import Curve, Panel, Sheet
from mecano.results.recorded import Extreme


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return every_kind.write(tmp_path_factory.mktemp("post") / "each.h5")


@pytest.fixture(scope="module")
def runs(path):
    return open_runs([path])


@pytest.fixture(scope="module")
def shown(runs):
    return {sheet.name: sheet for sheet in sheets.default_sheets(runs)}


def upright_lines(ax):
    """Lines of events: upright, and not their marks."""
    return [line for line in ax.lines if line.get_linestyle() != "None" and len(set(line.get_xdata())) == 1]


def values(run, name):
    return run.results[name].values


def test_every_kind_with_outputs_is_on_a_sheet(tmp_path):
    """Or, where there are more of them than one sheet takes, counted in the heading of that sheet."""
    runs = open_runs([every_kind.write(tmp_path / "all.h5", kinds=KINDS)])
    shown = {sheet.name: sheet for sheet in sheets.default_sheets(runs)}
    subjects = {subject for sheet in shown.values() for subject in sheet.subjects}
    members = {}
    for path in runs[0].pieces:
        for name in plans.pictures_of(runs[0], path):
            members.setdefault(name, []).append(path.rpartition("/")[2])
    full = {
        name
        for name in shown
        if f"6 of {len(members.get(name, ()))}, those with events or that vary most" in shown[name].heading
    }
    assert full == {"wheels", "reactions", "loads", "signals"}
    left_out = {f"one_{kind.name}" for kind in KINDS.values() if kind.outputs} - subjects
    assert left_out <= {member for name in full for member in members[name]}
    named = {plan.name for plan in plans.plans(runs)}
    for path, d in runs[0].pieces.items():
        assert not KINDS[d["type"]].outputs or named & set(plans.pictures_of(runs[0], path)), path


def test_a_kind_without_a_plan_shows_all_its_outputs_but_points(tmp_path, monkeypatch):
    monkeypatch.setattr(plans, "_PLANS", ())
    runs = open_runs([every_kind.write(tmp_path / "wheel.h5", kinds={"wheel": KINDS["wheel"]})])
    (own,) = plans.plans(runs)
    names = [o.name for o in KINDS["wheel"].outputs if o.name != "contact_point"]
    assert [view.outputs[0].partition(".")[0] for view in own.views] == names


def test_wheel_sheet_has_the_figures_of_the_paper(shown, runs):
    by_label = {panel.label: panel for panel in shown["wheels"].panels}
    expected = ["radial force", "force in the ground", "spin rate", "height of the centre", "slip velocity"]
    assert list(by_label)[:5] == expected
    spin, rolling = by_label["spin rate"].curves
    assert rolling.reference and not spin.reference
    radius, slip = values(runs[0], "one_wheel.loaded_radius"), values(runs[0], "one_wheel.longitudinal_slip")
    known = np.isfinite(rolling.y.values)
    assert np.array_equal(rolling.y.values[known], (values(runs[0], "one_wheel.spin_rate") + slip / radius)[known])


def test_slip_has_gaps_where_the_wheel_is_in_the_air(shown, runs):
    """The value at touch-down is kept, peaks in the air are not; quantities independent of the ground have no gaps."""
    by_label = {panel.label: panel for panel in shown["wheels"].panels}
    pressed = values(runs[0], "one_wheel.normal_force") > 0.0
    drawn = pressed | np.append(pressed[1:], False)
    assert 3 < np.count_nonzero(~drawn) < 30
    for curve in (*by_label["slip velocity"].curves, by_label["spin rate"].curves[1]):
        assert np.array_equal(np.isfinite(curve.y.values), drawn)
        assert not curve.peak or drawn[np.searchsorted(curve.y.time, curve.peak[1])]
    assert np.isfinite(by_label["spin rate"].curves[0].y.values).all()
    assert np.isfinite(find(runs[0].results, "one_wheel.longitudinal_slip")[0].values).all()


def test_events_have_a_mark_for_each_element_or_for_all_at_the_same_times_or_for_all_where_these_are_too_many(runs):
    (force,) = find(runs[0].results, "one_wheel.normal_force")
    panel = Panel("force", (Curve(time_of(force), force, 0, "a"),))

    def legend(*events):
        sheet = Sheet("s", "", (panel,), marks_of(*events))
        handles = EventLegend(sheet, CurveStyles(sheet)).handles()
        shown = {handle.get_marker() for handle in handles}
        assert len(shown) == len(handles) and all(mark.marker in shown for mark in sheet.events if mark.time < 1.0)
        return [handle.get_label() for handle in handles]

    assert legend((0.5, "left", "lands"), (0.1, "right", "lands")) == ["right: lands", "left: lands"]
    assert legend((0.5, "left", "lands"), (9.0, "right", "lands")) == ["left: lands"]  # beyond the panel
    assert legend(*((0.1, e, "locks") for e in "bc"), (0.2, "b", "opens")) == ["b, c: locks", "b: opens"]
    assert legend(*((0.1, e, "locks") for e in "bc"), (0.2, "b", "locks")) == ["b: locks", "c: locks"]
    assert legend(*((i / 50, f"e{i}", "locks") for i in range(20)), (0.2, "e1", "opens")) == ["locks", "opens"]
    assert legend(*((0.1, "e", f"event {i}") for i in range(14)))[-1] == "2 other events"


def test_values_between_gaps_are_drawn_as_dots():
    """A line alone would leave them out: the first value, the one at 3, and none of those that a line joins."""
    y = Quantity("e/y", "N", "y", "time", np.arange(7.0), np.array([1.0, np.nan, np.nan, 4.0, np.nan, 6.0, 7.0]))
    panel = Panel("y", (Curve(time_of(y), y, 0, "e"),))
    ax, sheet = matplotlib.figure.Figure().subplots(), Sheet("s", "", (panel,))
    draw_panel.draw_panel(ax, panel, CurveStyles(sheet), (), EventLegend(sheet, CurveStyles(sheet)))
    dots = [line.get_xdata().tolist() for line in ax.lines if line.get_linestyle() == "None"]
    assert dots == [[0.0, 3.0]]


def marks_of(*events):
    """The EventMarks of events (time, element, name) of one run."""
    found = [SimpleNamespace(time=t, element=element, name=name) for t, element, name in events]
    return event_marks([SimpleNamespace(results=SimpleNamespace(events=found, subject=lambda e: ("", e.element)))])


def test_an_event_has_the_same_mark_in_all_pictures(tmp_path):
    """The later event is the only one of the second sheet, and has there the mark that it has beside the earlier."""
    runs = open_runs([every_kind.write(tmp_path / "one.h5", events=((0.5, "touch_down"), (1.5, "lift_off")))])
    marks = marks_of((0.5, "one_hinge", "locks"), (1.5, "one_wheel", "lifts off"))
    drawn = {}
    for name in ("one_hinge.angle", "one_wheel.normal_force", "energy.total"):
        (y,) = find(runs[0].results, name)
        sheet = Sheet("s", "", (Panel("", (Curve(time_of(y), y, 0, y.subject),)),), marks)
        handles = EventLegend(sheet, CurveStyles(sheet)).handles()
        drawn[name] = {handle.get_label(): handle.get_marker() for handle in handles}
    assert [len(of_one) for of_one in drawn.values()] == [1, 1, 2]
    hinge, wheel, both = drawn.values()
    assert both == {**hinge, **wheel} and len(set(both.values())) == 2


def test_strut_force_is_shown_over_its_stroke(shown, runs):
    panel = shown["struts"].panels[0]
    assert np.array_equal(panel.curves[0].x.values, values(runs[0], "one_spring_damper.stroke"))
    assert np.array_equal(panel.curves[0].y.values, -values(runs[0], "one_spring_damper.force"))  # a push is positive
    assert panel.label == "compression force" and not panel.over_time


def test_single_numbers_keep_their_sign_and_lengths_are_named(shown, runs):
    plan = Plan("torsion_springs", "Moments", (View("moment", ("moment.magnitude",)),))
    (panel,) = planned_panels(plan, runs)[0]
    expected = values(runs[0], "one_torsion_spring_damper.moment")
    assert expected.min() < 0.0 and panel.label == "moment" and panel.quantities == ("moment",)
    assert np.array_equal(panel.curves[0].y.values, expected)
    lengths = [curve.y for panel in shown["reactions"].panels for curve in panel.curves if "magnitude" in curve.y.path]
    assert lengths and {y.what for y in lengths} <= {"|force|", "|moment|"}


def test_energies_are_changes_since_the_start(shown, runs):
    for curve in shown["energy"].panels[0].curves:
        stored = values(runs[0], curve.y.path)
        assert np.array_equal(curve.y.values, stored - stored[0])


def test_the_error_of_the_balance_is_relative_to_the_energy_exchanged(shown, runs):
    main, error = shown["energy"].panels
    (curve,) = error.curves
    stored = values(runs[0], "energy/balance")
    largest = max(np.ptp(other.y.values) for other in main.curves)  # over the run, as in the warning
    np.testing.assert_allclose(curve.y.values, (stored - stored[0]) / largest, rtol=1e-15)
    assert curve.y.unit == "-" and error.label == "error of the energy balance"


def test_a_peak_is_that_of_all_accepted_steps(shown, runs):
    panel = next(panel for panel in shown["wheels"].panels if panel.label == "radial force")
    extreme = runs[0].results.extremes["elements/one_wheel/radial_force"]
    assert panel.peak == (extreme.maximum, extreme.maximum_time)
    panel = next(panel for panel in shown["struts"].panels if panel.label == "compression force" and panel.over_time)
    (curve,) = (curve for curve in panel.curves if curve.subject == "one_spring_damper")
    extreme = runs[0].results.extremes["elements/one_spring_damper/force"]
    assert curve.peak == (-extreme.maximum, extreme.maximum_time)


def test_a_peak_that_the_saved_times_miss_is_marked(tmp_path, monkeypatch):
    """One step between two saved times has ten times the radial force."""
    place, take = every_kind.layout().slices["elements/one_wheel/radial_force"].start, Extremes.take

    def with_a_peak(extremes, t, row):
        take(extremes, t, row)
        if t == 0.5:
            take(extremes, 0.51, np.where(np.arange(len(row)) == place, 10.0, row))

    monkeypatch.setattr(Extremes, "take", with_a_peak)
    runs = open_runs([every_kind.write(tmp_path / "peak.h5", events=())])
    wheels = next(sheet for sheet in sheets.default_sheets(runs) if sheet.name == "wheels")
    marked = {}
    for ax, panel in zip(figure.sheet_figure(wheels, "title").axes, wheels.panels, strict=True):
        marked[panel.label] = [(*line.get_xdata(), *line.get_ydata()) for line in ax.lines if line.get_marker() == "o"]
    assert marked["radial force"] == [(0.51, 10.0)]
    for panel in wheels.panels:
        shown = [curve for curve in panel.curves if curve.peak] if len(panel.curves) <= draw_panel.MARKED else []
        assert sorted(marked[panel.label]) == sorted((time, value) for value, time in (curve.peak for curve in shown))


def test_curves_of_very_different_size_do_not_share_a_panel(tmp_path, monkeypatch):
    small = every_kind.layout().slices["joints/one_universal/angle_a"]
    usual = every_kind.row

    def row(declared, t):
        numbers = usual(declared, t)
        numbers[small.start : small.start + 3 : 2] *= 1e-3  # angle_a and angle_b
        return numbers

    monkeypatch.setattr(every_kind, "row", row)
    (run,) = open_runs([every_kind.write(tmp_path / "small.h5")])
    angles = next(sheet for sheet in sheets.default_sheets([run]) if sheet.name == "angles")
    panels = [panel.subjects for panel in angles.panels if panel.label == "angle"]
    assert panels == [("one_hinge", "one_cylindrical", "one_prescribed_angle"), ("one_universal",)]


def test_noise_beside_a_signal_is_not_shown(runs):
    (signal,), (other,) = find(runs[0].results, "one_wheel.normal_force"), find(runs[0].results, "one_hinge.force.x")
    curves = [
        Curve(signal, y, 0, name) for name, y in (("a", signal), ("b", replace(other, values=1e-12 * other.values)))
    ]
    (kept,) = worth_showing([Panel("force", tuple(curves))], runs)
    assert [curve.subject for curve in kept.curves] == ["a"]
    assert (
        worth_showing([Panel("force", tuple(replace(c, y=replace(c.y, values=0 * c.y.values)) for c in curves))], runs)
        == []
    )


@pytest.mark.parametrize(("size", "over"), [(1e-19, "time"), (1e-3, "nodes/tip/position.x")])
def test_a_curve_over_noise_is_drawn_over_time(runs, size, over):
    (x,), (y,) = find(runs[0].results, "tip.position.x"), find(runs[0].results, "tip.position.z")
    x = replace(x, values=size * np.sin(np.arange(len(x.time))))
    (panel,) = worth_showing([Panel("position z", (Curve(x, y, 0, "tip"),))], runs)
    assert panel.curves[0].x.path == over


@pytest.mark.parametrize("unit", ["rad", "deg"])
def test_angles_of_rounding_errors_are_not_shown(runs, unit):
    """Also not those of a signal, for which its deck declares degrees."""
    (angle,) = find(runs[0].results, "one_hinge.angle")
    for size, shown in ((1e-13, 0), (1e-3, 1)):
        small = replace(angle, unit=unit, values=size * angle.values / np.abs(angle.values).max())
        assert len(worth_showing([Panel("angle", (Curve(angle, small, 0, "a"),))], runs)) == shown


def test_all_default_pictures_are_drawn_with_labels_and_units(path, tmp_path, shown, monkeypatch):
    drawn = {}
    monkeypatch.setitem(style.SETTINGS, "figure.dpi", 60)
    monkeypatch.setattr(
        pictures, "save", lambda made, target: (drawn.update({target: made}), figure.save(made, target))
    )
    written = list(post([path], output=f"{tmp_path}/pictures/", columns=True))
    assert {p.name for p in written if p.suffix == ".png"} == {f"each_{name}.png" for name in ["overview", *shown]}
    assert {p.name for p in written if p.suffix == ".csv"} == {f"each_{n}.csv" for n in shown if n != "mechanism"}
    for picture in written:
        if picture.suffix == ".png":
            pixels = matplotlib.image.imread(picture)
            assert min(pixels.shape[:2]) > 120 and 0.01 < np.mean(pixels[..., :3].min(axis=2) < 0.9) < 0.5
    for name, sheet in shown.items():
        axes = drawn[tmp_path / "pictures" / f"each_{name}.png"].axes
        for ax, panel in zip(axes, sheet.panels, strict=True):
            if isinstance(panel, Panel):
                unitless = panel.curves[0].y.unit in ("", "-")
                assert ax.get_ylabel() and ("[" in ax.get_ylabel()) != unitless
                assert "[" in ax.get_xlabel()


@pytest.mark.parametrize("call", [
    lambda path, folder: list(post([path], ["energy.total"], output=f"{folder}/")),
    lambda path, folder: list(post([path, folder / "none.h5"])),
    lambda path, folder: animate(path, folder / "page.html"),
])  # fmt: skip
def test_files_are_closed_when_they_are_drawn(tmp_path, call):
    """By pictures, a page, and where another file cannot be opened."""
    own = every_kind.write(tmp_path / "own.h5", kinds={"wheel": KINDS["wheel"]})
    with suppress(ResultsError):
        call(own, tmp_path)
    links = [link for link in Path("/proc/self/fd").iterdir() if link.is_symlink()]
    assert own.resolve() not in [link.resolve() for link in links]


def test_the_picture_of_the_solver_explains_what_is_a_large_residual_and_error(shown):
    notes = {panel.label: panel.note for panel in shown["solver"].panels}
    assert notes["residuals over their tolerances"].startswith("below 1: converged")
    assert notes["error of a step over its allowed value"].startswith("steps above 1 are repeated")
    assert all(notes.values())


def wheels_with(events, folder, panels=None):
    """Return the sheet of wheels with these events, of so many panels, and its figure."""
    runs = open_runs([every_kind.write(folder / "events.h5", events=events)])
    wheels = next(sheet for sheet in sheets.default_sheets(runs) if sheet.name == "wheels")
    wheels = replace(wheels, panels=wheels.panels[:panels])
    return wheels, figure.sheet_figure(wheels, "title")


def test_events_are_lines_with_marks_that_a_legend_explains(tmp_path):
    wheels, drawn = wheels_with(((0.5, "touch_down"), (0.501, "lift_off"), (1.0, "touch_down")), tmp_path)
    assert [line.get_xdata()[0] for line in upright_lines(drawn.axes[0])] == [0.5, 0.501, 1.0]
    [legend] = drawn.legends
    assert [text.get_text() for text in legend.get_texts()][-2:] == ["one_wheel: touch down", "one_wheel: lift off"]
    markers = [handle.get_marker() for handle in legend.legend_handles[-2:]]
    for ax, panel in zip(drawn.axes, wheels.panels, strict=True):
        marks = {line.get_marker(): list(line.get_xdata()) for line in ax.lines if line.get_marker() in markers}
        assert marks == ({markers[0]: [0.5, 1.0], markers[1]: [0.501]} if panel.over_time else {})
        assert not any(text.get_rotation() for text in ax.texts)


@pytest.mark.parametrize(("times", "fewest", "most"), [
    ([0.1 * i for i in range(1, 10)], 9, 9),
    ([1.0 + 1e-3 * i for i in range(60)], 2, 4),  # 60 in 0.06 of 2 s, 3 % of the axis, do not become a bar
])  # fmt: skip
def test_many_events_are_lines(times, fewest, most, tmp_path):
    _, drawn = wheels_with([(t, "touch_down") for t in times], tmp_path, 1)
    assert fewest <= len(upright_lines(drawn.axes[0])) <= most


def test_very_many_events_leave_the_panel_free(tmp_path):
    """Hundreds of lines would grey it: they end just above the axis, and are no denser than can be seen."""
    _, drawn = wheels_with([(0.01 * i, "touch_down") for i in range(1, 200)], tmp_path, 1)
    upright = upright_lines(drawn.axes[0])
    assert 150 < len(upright) < 200 and max(max(line.get_ydata()) for line in upright) < 0.1
    marker = drawn.legends[0].legend_handles[-1].get_marker()
    assert [list(line.get_xdata()) for line in drawn.axes[0].lines if line.get_marker() == marker] == [[0.01]]


def test_marks_of_repeated_events_leave_room_for_those_of_rare_ones(tmp_path):
    """A lock amid 40 limits: these have one mark, where it does not cover that of the lock."""
    limits = [(0.5 + 0.03 * i, "lower limit") for i in range(40)]
    _, drawn = wheels_with([(0.499, "locks"), *limits], tmp_path, 1)
    lock, limit = (handle.get_marker() for handle in drawn.legends[0].legend_handles[-2:])
    marks = {line.get_marker(): list(line.get_xdata()) for line in drawn.axes[0].lines}
    assert marks[lock] == [0.499] and marks[limit] == [pytest.approx(0.53)]


def test_lines_that_are_covered_are_wider(runs):
    """Curves that nearly coincide, whatever the range of the axis of a constant."""
    (force,) = find(runs[0].results, "one_wheel.normal_force")
    for values in (np.full(41, 4.3), force.values):
        covered = [replace(force, values=values * (1.0 + i * 3e-6)) for i in range(3)]
        panel = Panel("force", tuple(Curve(time_of(y), y, 0, f"e{i}") for i, y in enumerate(covered)))
        (ax,) = figure.sheet_figure(Sheet("s", "", (panel,)), "").axes
        widths = [line.get_linewidth() for line in ax.lines]
        assert widths == sorted(widths, reverse=True) and len(set(widths)) == 3


def test_equal_curves_are_drawn_once_with_all_names(runs):
    """In the legend of a panel and, if equal in all panels, in that of a sheet; those of several runs stay apart."""
    (force,) = find(runs[0].results, "one_wheel.normal_force")
    other = replace(force, values=2.0 * force.values)
    named = {"a": force, "b": force, "c": other, "d": replace(force, values=force.values * (1.0 + 1e-9))}
    panel = Panel("force", tuple(Curve(time_of(y), y, 0, name) for name, y in named.items()))
    drawn = figure.sheet_figure(Sheet("s", "", (panel,)), "")
    assert [text.get_text() for text in drawn.legends[0].get_texts()] == ["a = b = d", "c"]
    assert len(drawn.axes[0].lines) == 2
    second = Panel("one more", tuple(replace(c, y=other) if c.subject == "b" else c for c in panel.curves))
    assert [h.get_label() for h in CurveStyles(Sheet("s", "", (panel, second))).handles()] == ["a = d", "b", "c"]
    each = CurveStyles(Sheet("s", "", (panel, second)), panel_by_panel=True)
    assert [h.get_label() for h in each.legend(second)] == ["a = d", "b = c"]
    rate = replace(force, path="elements/a/rate", values=3.0 * force.values)
    pairs = Panel("", tuple(Curve(time_of(y), y, 0, name) for y in (force, rate) for name in ("left_wheel", "right")))
    labels = [h.get_label() for h in CurveStyles(Sheet("s", "", (pairs, panel)), panel_by_panel=True).legend(pairs)]
    assert labels == [f"left_wheel = right: {what}" for what in (force.what, rate.what)]
    two = Panel("force", tuple(Curve(time_of(force), force, run, "a") for run in (0, 1)))
    assert len(CurveStyles(Sheet("s", "", (two,), (), ("x", "y"))).drawn(two)) == 2


def test_a_legend_names_elements_and_quantities_once_if_each_element_has_all(runs):
    (force,) = find(runs[0].results, "one_wheel.normal_force")
    names = ("front_left", "front_right", "rear")

    def entries(curves):
        panel = Panel("", tuple(curves))
        handles = CurveStyles(Sheet("s", "", (panel,) * 2), panel_by_panel=True).legend(panel)
        return {handle.get_label(): (handle.get_color(), handle.get_linestyle()) for handle in handles}

    curves = [
        Curve(time_of(force), replace(force, path=f"elements/{name}/{what}", values=(i + j) * force.values), 0, name)
        for i, name in enumerate(names)
        for j, what in ((1, "lateral_force"), (7, "drag_force"))
    ]
    found = entries(curves)
    assert list(found) == [*names, "lateral force", "drag force"]
    assert len({found[name] for name in names}) == 3 and found["drag force"] == (style.INK, "--")
    assert list(entries(curves[:-1]))[-1] == "rear: lateral force"  # one without a quantity


def test_legends_and_names_of_events_take_no_room_from_the_panels(runs):
    """Panels are as high with six elements and a named event each as with one element and none."""
    (force,) = find(runs[0].results, "one_wheel.normal_force")
    heights = []
    for names in (["a"], [f"element_with_a_long_name_{i}" for i in range(6)]):
        panel = Panel("force", tuple(Curve(time_of(force), force, 0, name) for name in names))
        events = tuple(EventMark(1.0, name, "touches down", 0, "v", name) for name in names if len(names) > 1)
        drawn = figure.overview_figure(Sheet("overview", "", (panel,) * 6, events), "title", "facts")
        drawn.draw_without_rendering()
        heights.append(drawn.axes[0].get_window_extent().height / drawn.dpi)
    assert heights[1] > 0.93 * heights[0]


def test_a_step_without_error_does_not_stretch_a_logarithmic_axis(runs):
    (force,) = find(runs[0].results, "one_wheel.normal_force")
    error = replace(force, unit="-", values=np.where(np.arange(41) == 3, 1e-30, 1e-2))
    panel = Panel("error", (Curve(time_of(error), error, 0, "solver"),), logarithmic=True)
    (ax,) = figure.sheet_figure(Sheet("solver", "", (panel,)), "title").axes
    assert 1e-15 < ax.get_ylim()[0] < 1e-3


def test_forces_that_are_rounding_errors_beside_the_energy_are_not_shown(runs):
    """Those of bearings of balanced rotors, if the model has no others."""
    (force,) = find(runs[0].results, "one_wheel.normal_force")
    energy = max(abs(e.maximum) for e in runs[0].results.extremes.values() if e.unit == "J")
    shape = force.values / np.abs(force.values).max()
    for size, shown in ((1e-14, 0), (1e-6, 1)):
        small = replace(force, values=size * energy / runs[0].scales["m"] * shape)
        assert len(worth_showing([Panel("force", (Curve(force, small, 0, "a"),))], runs)) == shown


def test_a_moment_that_is_nothing_beside_the_forces_is_not_shown(runs):
    (force,) = find(runs[0].results, "one_wheel.normal_force")
    panels = [Panel("force", (Curve(force, force, 0, "a"),))]
    for size, shown in ((1e-13, 1), (1e-3, 2)):
        moment = replace(force, unit="N m", values=size * force.values)
        assert len(worth_showing([*panels, Panel("moment", (Curve(force, moment, 0, "a"),))], runs)) == shown


def test_a_moment_below_the_tolerance_of_forces_is_not_shown(tmp_path):
    """Between two spacecraft that turn as one body acts a force of 7 mN; the moment is 5e-9 N m, 6e-7 of it."""
    mecano.run(INPUTS / "docking.yaml", tmp_path / "docking.h5", quiet=True).close()
    (run,) = open_runs([tmp_path / "docking.h5"])
    assert 0.0 < run.results.extremes["joints/port/moment.z"].maximum < 1e-8
    panels = [panel for sheet in sheets.default_sheets([run]) for panel in sheet.panels if isinstance(panel, Panel)]
    shown = [curve.y.path for panel in panels for curve in panel.curves]
    assert any("port/force" in path for path in shown) and not any("port/moment" in path for path in shown)


def test_panels_show_the_events_of_their_own_elements(tmp_path):
    events = ((0.5, "touch_down"), (1.5, "lift_off"))
    runs = open_runs([every_kind.write(tmp_path / "events.h5", events=events)])
    whole = overview([sheet for sheet in sheets.default_sheets(runs) if sheet.name in ("wheels", "angles")])
    other = tuple(EventMark(0.1 * i, "one_hinge", "click", 0, "v", "click") for i in range(3))
    drawn = figure.overview_figure(replace(whole, events=(*whole.events, *other)), "title", "facts")
    panels = [panel for panel in whole.panels if isinstance(panel, Panel)]
    upright = {
        panel.subjects: [line.get_xdata()[0] for line in upright_lines(ax)]
        for ax, panel in zip(drawn.axes, panels, strict=True)
    }
    assert upright[("one_wheel",)] == [0.5, 1.5]
    assert all(len(found) == 3 for subjects, found in upright.items() if subjects and "one_hinge" in subjects)


def test_overview_takes_the_first_panels_of_all_sheets(shown):
    whole = overview(list(shown.values()))
    panels = [panel for panel in whole.panels if isinstance(panel, Panel)]
    assert len(panels) == PLACES - 1  # the sketch stays in place and takes one
    shown_sheets = [
        next(sheet.name for sheet in shown.values() if any(panel.curves[0] is curve for curve in sheet.curves))
        for panel in panels
    ]
    wanted = ["wheels"] * 3 + ["struts"] * 2  # as many as each sheet puts in the lead, after those of signals
    signals = [panel.curves[0].y.path.startswith("signals/") for panel in panels]
    assert any(signals) and signals == sorted(signals, reverse=True)
    assert shown_sheets[sum(signals) :][: len(wanted)] == wanted[: PLACES - 1 - sum(signals)]
    figure.overview_figure(whole, "title", "facts").canvas.draw()


class TestRequests:
    def sheet(self, text, runs):
        return requested_sheet(Request.parse(text), runs)

    def test_one_output_over_another(self, runs):
        (panel,) = self.sheet("one_wheel.radial_force:one_wheel.deformation", runs).panels
        assert np.array_equal(panel.curves[0].x.values, values(runs[0], "one_wheel.deformation"))
        assert panel.label == "one_wheel radial force"

    def test_time_is_the_default_horizontal_axis(self, runs):
        (panel,) = self.sheet("one_hinge.angle", runs).panels
        assert np.array_equal(panel.curves[0].x.values, runs[0].results.time) and panel.over_time

    def test_vectors_have_components_and_a_magnitude(self, runs):
        force = values(runs[0], "one_hinge.force")
        (panel,) = self.sheet("one_hinge.force", runs).panels
        assert np.array_equal([curve.y.values for curve in panel.curves], force.T)
        (panel,) = self.sheet("one_hinge.force.y,joints.one_hinge.force.magnitude", runs).panels
        assert np.array_equal(panel.curves[0].y.values, force[:, 1])
        assert np.allclose(panel.curves[1].y.values, np.linalg.norm(force, axis=1), rtol=1e-15, atol=0)

    def test_each_unit_has_a_panel(self, runs):
        panels = self.sheet("one_wheel.radial_force,one_wheel.height,one_hinge.force.x", runs).panels
        assert [[curve.y.unit for curve in panel.curves] for panel in panels] == [["N", "N"], ["m"]]

    def test_patterns(self, runs):
        (panel,) = self.sheet("joints.*.angle", runs).panels
        joints = [kind for kind in every_kind.ONE_WHEEL.values() if kind.section == "joints"]
        angled = {f"one_{kind.name}" for kind in joints if "angle" in {output.name for output in kind.outputs}}
        assert {c.subject for c in panel.curves} == angled >= {"one_hinge", "one_cylindrical", "one_screw"}

    def test_the_solver_history(self, runs):
        (panel,) = self.sheet("solver.step_size", runs).panels
        assert np.array_equal(panel.curves[0].y.values, runs[0].results.steps["step_size"])
        with pytest.raises(UsageError, match="did you mean 'step_size'"):
            self.sheet("solver.stepsize", runs)
        with pytest.raises(UsageError, match="known at the accepted steps, 'one_hinge.angle' at the saved times"):
            self.sheet("solver.step_size:one_hinge.angle", runs)

    @pytest.mark.parametrize("text", ["", "a:", ":b", "a,,b", "a:b:c", "a,:time"])
    def test_what_cannot_be_understood_is_refused(self, text):
        with pytest.raises(UsageError, match="cannot be understood"):
            Request.parse(text)

    def test_a_run_without_the_quantity_is_named_and_the_others_are_drawn(self, tmp_path):
        """A flexible and a rigid link, of which one has stress."""
        files = [
            every_kind.write(tmp_path / f"{name}.h5", kinds={one: KINDS[one] for one in kinds})
            for name, kinds in (("flexible", ("beam", "hinge")), ("rigid", ("hinge",)))
        ]
        runs = open_runs(files)
        sheet = self.sheet("one_beam.stress,one_hinge.angle", runs)
        assert sheet.heading == "one_beam.stress, one_hinge.angle over time; 'one_beam.stress' is not in rigid"
        assert [(curve.y.whole, curve.run) for panel in sheet.panels for curve in panel.curves] == [
            ("stress", 0), ("angle", 0), ("angle", 1)
        ]  # fmt: skip
        [panel] = self.sheet("one_hinge.angle:one_beam.stress", runs).panels
        assert [curve.run for curve in panel.curves] == [0]
        with pytest.raises(UnknownNameError, match="flexible.h5: no output 'one_spring"):
            self.sheet("one_spring.force", runs)

    def test_unknown_names_are_answered_with_similar_ones(self, runs):
        with pytest.raises(UnknownNameError, match=r"'one_wheel.work'.* \(the work is a signal of the type 'int"):
            self.sheet("one_wheel.work", runs)
        with pytest.raises(UnknownNameError, match="each.h5.*'one_wheel.radal_force'.*did you mean.*radial_force"):
            self.sheet("one_wheel.radal_force", runs)
        assert UnknownNameError.exit_code == UsageError.exit_code == 2
        with pytest.raises(UsageError, match="matches 'nothing.*'"):
            self.sheet("nothing.*", runs)
        with pytest.raises(UsageError, match="several numbers .x, y, z., the horizontal axis needs one"):
            self.sheet("one_hinge.angle:one_hinge.force", runs)

    def test_names_of_files(self):
        assert Request.parse("wheel.radial_force : wheel.deformation").name == "wheel.radial_force-wheel.deformation"
        assert Request.parse("joints/*/angle,energy.total").name == "joints_angle_energy.total"


def test_columns_are_the_numbers_of_the_file(path, tmp_path, runs):
    plots = ["one_wheel.radial_force,one_wheel.height:one_wheel.deformation"]
    picture, table = post([path], plots, output=tmp_path / "p.svg", columns=True)
    assert (picture.name, table.name) == ("p.svg", "p.csv")
    header, *rows = csv.reader(table.read_text().splitlines())
    names = ["deformation", "radial_force", "height"]
    assert header == [f"elements.one_wheel.{n} [{u}]" for n, u in zip(names, ("m", "N", "m"), strict=True)]
    expected = np.stack([values(runs[0], f"one_wheel.{name}") for name in names], axis=1)
    assert np.array_equal(np.array(rows, float), expected)


def test_columns_of_several_files_of_different_length(path, tmp_path, monkeypatch):
    monkeypatch.setattr(every_kind, "TIMES", every_kind.TIMES[:11])
    short = every_kind.write(tmp_path / "short.h5")
    _, table = post([path, short], ["one_hinge.angle"], output=tmp_path / "both.png", columns=True)
    header, *rows = csv.reader(table.read_text().splitlines())
    assert header == [
        f"{run}: {name}" for run in ("each", "short") for name in ("time [s]", "joints.one_hinge.angle [rad]")
    ]
    assert len(rows) == 41 and all(rows[10]) and rows[11][2:] == ["", ""] and all(rows[11][:2])


def test_configurations_say_their_times_where_others_were_asked_for(runs):
    """A file has its times every 0.05 s."""
    titles = [ax.get_title() for ax in configurations_figure(runs[0], [0.5, 0.51, 9.0], "").axes]
    assert titles == ["t = 0.5 s", "t = 0.5 s, saved nearest to 0.51 s", "t = 2 s, saved nearest to 9 s"]


@pytest.mark.parametrize(("gravity", "upward"), [([0, 0, -9.81], 2), ([0, -9.81, 0], 1)])
@pytest.mark.parametrize("depth", [0.0, 0.3])
def test_configurations_of_a_plane_mechanism_are_seen_from_the_side(gravity, upward, depth):
    """The vertical is that of the gravity in both views."""
    points = np.zeros((1, 3, 3))
    points[0, 1, 0], points[0, 2, upward], points[0, 2, 3 - upward] = 2.0, 1.0, depth
    matrix = configurations._matrix(SimpleNamespace(deck={"gravity": gravity}), [Shape(BODY, "bar", points)])
    if not depth:
        np.testing.assert_array_equal(matrix, np.eye(3)[[0, upward]])
    assert matrix[1, upward] > 0.9 and matrix[0, upward] == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(2), atol=1e-15)


def test_configurations_that_travel_far_are_drawn_about_their_middle():
    """A square of size 1 that goes three sizes away keeps its size in the picture; half a size away it is there."""
    square = np.array([[0.0, 0.0], [1.0, 1.0]])
    shift, low, high = configurations._frame(np.stack([square, square + (3.0, 0.0)]))
    assert shift.tolist() == [[0.5, 0.5], [3.5, 0.5]] and low.tolist() == [-0.5, -0.5] and high.tolist() == [0.5, 0.5]
    shift, low, high = configurations._frame(np.stack([square, square + (0.5, 0.0)]))
    assert not shift.any() and low.tolist() == [0.0, 0.0] and high.tolist() == [1.5, 1.0]


def test_bodies_with_more_than_two_points_are_drawn_as_outlines():
    square = np.array([[0.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.6, 0.5], [1.0, 0.0]])
    placed = [(Shape(style, style, square[None]), square) for style in (BODY, CABLE)]
    ax = matplotlib.figure.Figure().add_subplot()
    draw_shapes(ax, placed, {BODY: "black", CABLE: "grey"})
    assert ax.lines[0].get_xydata().tolist() == [[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]
    np.testing.assert_array_equal(ax.collections[0].get_segments()[0], square)


def test_configurations_show_ground_and_axes_and_say_whose_they_are(runs):
    drawn = configurations_figure(replace(runs[0], label="speed = 40"), [0.5], "")
    assert drawn.axes[0].patches and {"x", "y", "z"} <= {
        text.get_text() for text in drawn.axes[0].texts
    }  # ground, axes
    assert any(text.get_text().startswith("configurations of speed = 40, all on one scale") for text in drawn.texts)


def test_configurations_mark_supports_of_nodes_and_of_joints_on_the_ground(tmp_path):
    """Of a pendulum that hangs on a hinge, and of a spring that hangs on a fixed node."""
    example = (INPUTS / "pendulum.yaml").read_text()
    deck = example.replace("nodes:\n", "nodes:\n  hook: {position: [0.5, 0, 1], fixed: true}\n", 1)
    spring = "elements:\n  spring: {type: spring_damper, nodes: [hook, pin], law: {spring: 1}}\n"
    (tmp_path / "deck.yaml").write_text(deck.replace("elements:\n", spring, 1))
    mecano.run(tmp_path / "deck.yaml", tmp_path / "run.h5", set={"time.end": 0.01}, quiet=True)
    drawn = configurations_figure(open_runs([tmp_path / "run.h5"])[0], [0.0], "")
    marks = {tuple(np.ravel(line.get_xydata())) for line in drawn.axes[0].lines if line.get_marker() == "o"}
    assert marks == {(0.5, 1.0), (0.0, 0.0)}


def test_the_same_numbers_give_the_same_picture(path, tmp_path):
    (first,) = post([path], ["one_hinge.angle"], output=tmp_path / "a.svg")
    (second,) = post([path], ["one_hinge.angle"], output=tmp_path / "b.svg")
    assert first.read_bytes() == second.read_bytes()


def test_a_picture_is_drawn_once(tmp_path, runs, monkeypatch):
    """savefig draws a figure that has a layout engine twice, which took a seventh of the time of all pictures."""
    drawn = figure.sheet_figure(requested_sheet(Request.parse("one_wheel.spin_rate"), runs), "")
    times, draw = [], matplotlib.figure.Figure.draw
    monkeypatch.setattr(matplotlib.figure.Figure, "draw", lambda *given: (times.append(1), draw(*given)))
    figure.save(drawn, tmp_path / "once.png")
    assert len(times) == 1


def test_several_runs_share_pictures_in_colours_of_their_own(path, tmp_path):
    other = every_kind.write(tmp_path / "other.h5", overrides=("parameters.wave=0.7", "time.step=1e-3"))
    runs = open_runs([path, other])
    assert [run.label for run in runs] == ["wave = 0.4", "wave = 0.7, time.step = 0.001"]
    shown = sheets.default_sheets(runs)
    wheels = next(sheet for sheet in shown if sheet.name == "wheels")
    drawn = figure.sheet_figure(wheels, "title")
    assert [text.get_text() for text in drawn.legends[0].get_texts()][:2] == [run.label for run in runs]
    styles = CurveStyles(wheels)
    colours = [styles.style(curve, wheels.panels[0])["color"] for curve in wheels.panels[0].curves]
    assert colours == list(style.COLOURS[:2])
    (mechanism,) = (sheet for sheet in shown if sheet.name == "mechanism")
    assert len(mechanism.panels) == 2


TEN = tuple("abcdefghij")


@pytest.mark.parametrize(
    "names, quantities, labels",
    [(40, 1, ()), (5, 8, ()), (12, 3, ()), (1, 20, ()), (6, 2, ("a", "b")), (2, 1, TEN), (1, 1, TEN)],
)
def test_no_two_curves_look_the_same(runs, names, quantities, labels):
    """The smallest curves, without colours of their own, are pale and counted in the legend."""
    (force,) = find(runs[0].results, "one_wheel.normal_force")
    curves = []
    for run, i, j in np.ndindex(len(labels) or 1, names, quantities):
        y = replace(force, path=f"elements/e{i}/what_{j}", values=(i + 1.0) * (1.0 + 0.01 * j) * force.values)
        curves.append(Curve(time_of(force), y, run, f"e{i}"))
    panel = Panel("force", tuple(curves))
    sheet = Sheet("s", "", (panel,), (), labels)
    for styles in (CurveStyles(sheet), CurveStyles(sheet, panel_by_panel=True)):
        found = [styles.style(curve, panel) for curve in curves]
        reported = [(one["color"], str(one["linestyle"])) for one in found if one["color"] != style.PALE]
        assert len(set(reported)) == len(reported) >= min(len(curves), 6)
        pale = {curve.subject for curve, one in zip(curves, found, strict=True) if one["color"] == style.PALE}
        if quantities <= len(style.DASHES):
            assert pale == {f"e{i}" for i in range(len(pale))}
        texts = [handle.get_label() for handle in (*styles.handles(), *styles.legend(panel))]
        assert any(text.endswith("others") for text in texts) == bool(pale)


def test_an_overview_of_several_runs_says_whose_sketch_it_shows_and_keeps_events_at_the_axis(tmp_path):
    events = tuple((0.2 * i, "touch_down") for i in range(1, 6))
    written = [
        every_kind.write(tmp_path / f"{i}.h5", events=events, overrides=(f"parameters.wave=0.{i}",)) for i in (5, 6)
    ]
    runs = open_runs(written)
    chosen = [sheet for sheet in sheets.default_sheets(runs) if sheet.name in ("mechanism", "wheels")]
    first, *axes = figure.overview_figure(overview(chosen), "title", "").axes
    assert first.get_title(loc="left") == "wave = 0.5"
    upright = [line for ax in axes for line in upright_lines(ax)]
    assert upright and max(max(line.get_ydata()) for line in upright) < 0.1


def test_labels_name_the_differences(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # a long path would be cut
    same = []
    for folder in (Path("a"), Path("b")):
        folder.mkdir()
        same.append(every_kind.write(folder / "run.h5"))
    assert labels([mecano.open_results(p) for p in same]) == [str(p) for p in same]
    assert labels([mecano.open_results(p) for p in (path, same[0])]) == ["each", "run"]
    assert labels([mecano.open_results(path)]) == [""]


def test_places_of_pictures(path, tmp_path):
    plots = ["one_hinge.angle", "one_hinge.angle"]
    assert [p.name for p in post([path], plots[:1])] == ["each_one_hinge.angle.png"]
    assert next(post([path], plots[:1])).parent == path.parent
    (named,) = post([path], plots[:1], output=tmp_path / "prefix", kind="svg")
    assert named == tmp_path / "prefix_one_hinge.angle.svg"
    inside = list(post([path], plots, output=tmp_path))
    assert [p.name for p in inside] == ["each_one_hinge.angle.png", "each_one_hinge.angle_2.png"]
    with pytest.raises(UsageError, match="names one picture"):
        list(post([path], plots, output=tmp_path / "one.png"))
    for name, picture in (("one.JPG", plots[:1]), ("all.pdf", ())):
        with pytest.raises(UsageError, match="pictures are written as png or svg"):
            list(post([path], picture, output=tmp_path / name))
    blocked = tmp_path / "file"
    blocked.write_text("")
    with pytest.raises(ResultsError, match="cannot make the folder .*file: File exists"):
        list(post([path], plots, output=f"{blocked}/"))


@pytest.mark.parametrize(
    ("unit", "largest", "factor", "shown"),
    [
        ("N", 1999.0, 1.0, "N"),
        ("N", 2000.0, 1e3, "kN"),
        ("N m", 5e6, 1e6, "MN m"),
        ("m", 0.09, 1e-3, "mm"),
        ("m", 0.11, 1.0, "m"),
        ("m", 1.7e-6, 1e-6, "µm"),
        ("m", 1.7e-9, 1e-9, "nm"),
        ("s", 5e-5, 1e-6, "µs"),
        ("m/s", 1.7e-3, 1e-3, "mm/s"),
        ("rad/s", 3e5, 1e3, "10³ rad/s"),
        ("J", 3e-7, 1e-9, "10⁻⁹ J"),
        ("-", 0.5, 1.0, ""),
        ("1", 0.5, 1.0, ""),
        ("N", 0.0, 1.0, "N"),
    ],
)
def test_units_suit_the_numbers(unit, largest, factor, shown):
    found, text = style.shown_unit(unit, np.array([0.0, -largest, math.nan]))
    assert (math.isclose(found, factor, rel_tol=1e-12), text) == (True, shown)


@pytest.mark.parametrize(
    ("label", "unit", "shown"),
    [
        ("wire: strain", "", "wire: strain"),
        ("tire: force in the ground", "kN", "tire:\nforce in the ground [kN]"),
        ("tire: lateral displacement of the patch", "mm", "tire:\nlateral displacement of the\npatch [mm]"),
    ],
)
def test_long_labels_have_several_lines(label, unit, shown):
    assert style.with_unit(label, unit) == shown


def test_a_peak_without_a_unit_is_reported_without_a_gap(runs):
    (ratio,) = find(runs[0].results, "one_wheel.friction_coefficient")
    panel = Panel("friction", (Curve(time_of(ratio), ratio, 0, "one_wheel"),), peak=(0.5, 1.25))
    (ax,) = figure.sheet_figure(Sheet("s", "", (panel,)), "").axes
    assert "max 0.5 at 1.25 s" in [text.get_text() for text in ax.texts]


def test_a_peak_is_not_read_as_two_numbers(runs):
    """A strain of 0.00101 is 1010·10⁻⁶, not 1010 10⁻⁶."""
    (ratio,) = find(runs[0].results, "one_wheel.friction_coefficient")
    strain = replace(ratio, values=1e-3 * ratio.values / np.abs(ratio.values).max())
    panel = Panel("strain", (Curve(time_of(strain), strain, 0, "one_wheel"),), peak=(0.00101, 1.25))
    (ax,) = figure.sheet_figure(Sheet("s", "", (panel,)), "").axes
    assert "max 1010·10⁻⁶ at 1.25 s" in [text.get_text() for text in ax.texts]


def test_what_is_constant_but_for_rounding_looks_constant():
    assert style.range_of(np.array([9.81, 9.81 + 1e-12])) == pytest.approx((8.829, 10.791), rel=1e-9)
    assert style.range_of(np.zeros(3)) == (-1.0, 1.0)
    assert style.range_of(np.array([1.0, 1.1])) is None
    assert style.range_of(np.array([6.16905, 6.16918]), 1e-3) == pytest.approx((5.5522, 6.7860), abs=1e-4)


class TestInfo:
    def test_how_the_run_went(self, path):
        text = info(path)
        assert "One of each" in text and "complete" in text
        assert "40 steps, 20 rejected, 80 Newton iterations (2.00 per step), of 0.05 s" in text
        assert "41 times from 0 to 2 s, every 0.05 s" in text
        assert "Events: 2" in text and "0.5 s  wheel 'one_wheel'  touch down  (air -> contact)" in text
        assert f"mecano {mecano.__version__}" in text and "joints, hinge: one_hinge: angle, rate, force, moment" in text

    def test_times_say_of_which_clock_they_are(self, path, runs):
        text, data = " ".join(info(path).split()), runs[0].results.metadata
        assert f"{data['wall_time']:.2f} s of wall-clock time for the run" in text
        assert f"{data['processor_time']:.2f} s of CPU time for the whole process" in text

    def test_compiling_is_separate(self, tmp_path):
        path = every_kind.write(tmp_path / "compiled.h5")
        with h5py.File(path, "a") as file:
            file["run/compile_time"][()] = 12.5
        assert "s of wall-clock time for the run and 12.50 s for compiling;" in " ".join(info(path).split())

    def test_only_the_first_events(self, tmp_path):
        events = tuple((0.01 * i, f"event_{i}") for i in range(30))
        text = info(every_kind.write(tmp_path / "many.h5", events=events))
        assert "Events: 30; 20 lines, shocks and releases first, mecano info" in text
        assert "event 19" in text and "event 20" not in text
        together = tuple((0.1, "same") for _ in range(3)) + tuple((0.2 + 0.01 * i, f"event_{i}") for i in range(27))
        text = info(every_kind.write(tmp_path / "together.h5", events=together))
        assert "Events: 30, like ones at one instant merged, in 28 lines; 20 lines, shocks" in text

    def test_repeated_events_leave_rare_ones_in_sight(self, tmp_path):
        """40 limits before the one release would fill all lines."""
        limits = tuple((0.01 * i, "lower limit") for i in range(1, 41))
        path = every_kind.write(tmp_path / "limits.h5", events=(*limits, (1.5, "releases")))
        text = info(path)
        assert "Events: 41, repeated ones merged, in 2 lines; mecano info FILE --events '*' lists all events" in text
        assert info(path, events="**") in text and len(info(path, events="*").splitlines()) == 42
        first, last = text.split("Events")[1].splitlines()[1:3]
        assert first.split()[0] == "0.01" and first.endswith("40 times, to 0.4 s") and "releases" in last

    def test_extremes(self, path, runs):
        extreme = runs[0].results.extremes["elements/one_wheel/radial_force"]
        (line,) = (x for x in info(path, "one_wheel.radial_force").splitlines() if x.endswith("N"))
        name, *numbers, unit = line.split()
        assert (name, unit) == ("elements.one_wheel.radial_force", "N")
        expected = [extreme.minimum, extreme.minimum_time, extreme.maximum, extreme.maximum_time]
        assert [float(x) for x in numbers] == pytest.approx(expected, rel=1e-4)

    def test_extremes_without_zeros_and_rounding(self):
        """Extremes below 1e-10 of the largest of a unit, nodes and formulas are left out; nan is reported."""
        values = {
            "a/f": (-9.0, 2.0, "N"),
            "joints/j/f": (0.0, 3.0, "N"),
            "a/g": (0.0, 8e-10, "N"),
            "a/u": (0.0, 8e-10, "m"),
            "a/zero": (0.0, 0.0, "J"),
            "a/bad": (math.nan, math.nan, "Pa"),
            "nodes/p/position.x": (0.0, 5.0, "m"),
            "formulas/time - (0.3)/value": (-0.3, 14.7, "SI"),
        }
        extremes = {path: Extreme(high, 1.0, low, 2.0, unit) for path, (low, high, unit) in values.items()}
        assert [name for name, _ in notable(extremes)] == ["joints.j.f", "a.f", "a.u", "a.bad"]

    def test_names(self, tmp_path):
        path = every_kind.write(tmp_path / "all.h5", kinds=KINDS)
        text = info(path, "*")
        for kind in KINDS.values():
            for output in kind.outputs:
                unit = f" [{output.unit}]" if output.unit != "-" else ""
                assert f"{kind.section}.one_{kind.name}.{output.name}{unit}" in text
        with pytest.raises(UnknownNameError, match="matches 'nothing'"):
            info(path, "nothing")


def test_a_file_without_saved_times(tmp_path, monkeypatch):
    monkeypatch.setattr(every_kind, "TIMES", ())
    path = every_kind.write(tmp_path / "empty.h5", events=())
    with pytest.raises(ResultsError, match="no saved times"):
        list(post([path]))
    assert "nothing yet" in info(path) and "no step" in info(path)


def with_overrides(folder, given):
    """Return open results of runs with the given overrides each."""
    return [
        mecano.open_results(every_kind.write(folder / f"{i}.h5", overrides=overrides, kinds={}))
        for i, overrides in enumerate(given)
    ]


def test_labels_are_the_values_that_differ(tmp_path):
    """Labels of runs of one deck: values of overrides, or of the deck; equal numbers in other notation are equal."""
    given = [(), ("parameters.wave=0.50", "nodes.tip.fixed=true"), ("parameters.wave=5e-1", "nodes.tip.fixed=false")]
    opened = with_overrides(tmp_path, given)
    both = [("0.4", "false"), ("0.5", "true"), ("0.5", "false")]
    assert labels(opened) == [f"wave = {wave}, tip.fixed = {fixed}" for wave, fixed in both]
    assert labels(opened[1:]) == ["tip.fixed = true", "tip.fixed = false"]


def test_values_of_one_legend_have_one_unit(tmp_path):
    """Of the deck 0.4 m, of overrides 50 cm and 2 m, which is written without its unit."""
    opened = with_overrides(tmp_path, [(), ("parameters.wave=50 cm",), ("parameters.wave=2",)])
    assert labels(opened) == ["wave = 40 cm", "wave = 50 cm", "wave = 200 cm"]


def test_a_signal_is_labelled_by_its_name(path):
    """Alone and with its unit beside an output of an element; no axis or legend says "value"."""
    [run] = open_runs([path])
    for names, expected in (
        ("one_delay.value", ["one_delay"]), ("one_delay.value,one_curve.value", ["one_delay, one_curve"]),
    ):  # fmt: skip
        sheet = requested_sheet(Request.parse(names), [run])
        assert [panel.label for panel in sheet.panels] == expected
        assert {what for panel in sheet.panels for what in panel.quantities} == {"signal"}
    sheet = requested_sheet(Request.parse("one_delay:one_curve"), [run])
    [axes] = figure.sheet_figure(sheet, "title").axes
    assert axes.get_xlabel().startswith("one_curve") and axes.get_ylabel().startswith("one_delay")


def test_no_label_is_empty(tmp_path):
    """A run without a value that the other one sets, such as an optional field."""
    given = [(), ("time.adaptive={tolerance: 1e-3}",)]
    assert labels(with_overrides(tmp_path, given)) == ["no time.adaptive", "time.adaptive = {tolerance: 1e-3}"]


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (["title=One;parameters.wave={height: 0.4}", "title=Two;nodes.tip.fixed=true"], ["false", "true"]),
        (["nodes.tip.fixed=" + "a" * 90, "nodes.tip.fixed=" + "b" * 90], ["a" * 64 + " ...", "b" * 64 + " ..."]),
    ],
)
def test_labels_are_short(tmp_path, monkeypatch, given, expected):
    """Of a mapping what differs in it; no titles; and no more than 80 characters."""
    monkeypatch.setitem(every_kind.DECK, "parameters", {"wave": {"height": 0.4, "length": 2.0}})
    opened = with_overrides(tmp_path, [text.split(";") for text in given])
    assert labels(opened) == [f"tip.fixed = {value}" for value in expected]


def test_labels_that_are_alike_when_cut_are_names_of_files(tmp_path):
    given = [("nodes.tip.fixed=" + "a" * length,) for length in (90, 91)]
    assert labels(with_overrides(tmp_path, given)) == ["0", "1"]


@pytest.mark.parametrize(("title", "ends"), [("short", "short"), ("long one " * 11, "one "), ("endless " * 30, " ...")])
def test_titles_fit_their_pictures(title, ends):
    """A long one is written smaller, a very long one cut; 8 inches have room for some 70 bold letters of 12 points."""
    with matplotlib.rc_context(style.SETTINGS):
        drawn = figure.plain_figure(8.0, 3.0, title, "heading " * 40)
        drawn.draw_without_rendering()
    head, below = drawn.texts
    assert head.get_text() == f"{title}\n" or len(title) > 100
    assert head.get_text().endswith(f"{ends}\n") and below.get_text().endswith(" ...")
    assert (head.get_fontsize() == 12) == (len(title) < 70) and 8 <= head.get_fontsize() <= 12
    assert max(text.get_window_extent().x1 for text in drawn.texts) <= 8.0 * drawn.dpi


def test_pictures_of_mecano_are_replaced_and_others_only_with_force(tmp_path, monkeypatch):
    """As results files are: drawing again replaces what was drawn, never a photograph of the same name."""
    monkeypatch.setattr(report_page, "_image", lambda figure: "")  # a report draws all pictures, which takes seconds
    path = every_kind.write(tmp_path / "wheel.h5", kinds={"wheel": every_kind.ONE_WHEEL["wheel"]})
    one, page = tmp_path / "spin.png", tmp_path / "report.html"
    plot = ["one_wheel.spin_rate"]
    for _ in range(2):
        assert list(post([path], plot, output=one)) == [one]
    for other in (one, tmp_path / "spin.svg"):
        other.write_bytes(b"a photograph")
        with pytest.raises(ResultsError, match=f"{other.name} already exists, and is not known .* mecano; --force"):
            list(post([path], plot, output=other))
        assert other.read_bytes() == b"a photograph"
        assert list(post([path], plot, output=other, force=True)) == [other]
    table = tmp_path / "spin.csv"
    for text in ("time [s],elements.one_wheel.spin_rate [rad/s]\n1,2\n", "time [s],price [EUR]\n1,2\n"):
        table.write_text(text)
        if "price" in text:
            with pytest.raises(ResultsError, match="spin.csv already exists; --force"):
                list(post([path], plot, output=one, columns=True))
        drawn = list(post([path], plot, output=one, columns=True, force="price" in text))
        assert drawn == [one, table] and table.read_text().count("\n") > 2
    film = tmp_path / "wheel.webp"
    film.write_bytes(b"")
    with pytest.raises(ResultsError, match="wheel.webp already exists; --force"):
        commands(["post", str(path), "--animate", str(film)], standalone_mode=False)
    page.write_text("<html>minutes of a meeting</html>")
    arguments = ["post", str(path), "--report", str(page)]
    with pytest.raises(ResultsError, match="not known to be written by mecano"):
        commands(arguments, standalone_mode=False)
    commands([*arguments, "--force"], standalone_mode=False)


def test_signals_are_drawn_in_the_unit_of_the_deck(tmp_path):
    """Results are in SI units, values and peaks of pictures in degrees: those of the dots lie on the curve."""
    given = deck("""
        mecano: 1
        gravity: none
        nodes: {a: {position: [0, 0, 0]}}
        elements: {body: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}}
        joints: {hinge: {type: hinge, nodes: [ground, a], axis: [0, 0, 1]}}
        signals: {turned: {type: formula, value: hinge.angle, unit: deg}, plain: hinge.angle}
        loads: {motor: {type: joint_moment, joint: hinge, value: 2}}
        time: {end: 1, step: 0.01}
        """)
    with mecano.run(mecano.Deck(given.resolved()), tmp_path / "turned.h5", quiet=True) as results:
        [shown], [plain] = (find(results, name) for name in ("turned", "plain"))
        assert (shown.unit, plain.unit, results["turned.value"].unit) == ("deg", "rad", "rad")
        np.testing.assert_allclose(shown.values, np.degrees(results["hinge.angle"].values), rtol=1e-12, atol=1e-12)
        assert peak_of(results, shown) == pytest.approx((shown.values[-1], 1.0))
        assert results.resolved["signals"]["turned"]["unit"] == "deg"


def test_the_peak_of_a_value_that_is_kept_is_where_it_is_reached():
    """A latched angle varies by rounding: the largest of its values is anywhere, the first of them at 2 s."""
    time, values = np.arange(6.0), np.array([0.0, 0.9, 1.0, 1.0, 1.0 + 1e-13, 1.0])
    kept = Quantity("joints/hinge/angle", "rad", "", "saved times", time, values)
    assert first_of_peak(kept, 1.0 + 1e-13, 4.0) == (1.0 + 1e-13, 2.0)
    passing = replace(kept, values=np.array([0.0, 0.9, 1.0, 0.9, 1.1, 1.0]))
    assert first_of_peak(passing, 1.15, 3.7) == (1.15, 3.7)

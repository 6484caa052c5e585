"""The overview, and the elements that a sheet of many shows: what an engineer of the subject looks for first."""

import every_kind
import numpy as np
import pytest

from mecano.elements import KINDS
from mecano.post.overview import PLACES, overview
from mecano.post.panels import MOST
from mecano.post.quantity import Quantity, time_of
from mecano.post.runs import open_runs
from mecano.post.sheet import Curve, Panel, Sheet
from mecano.post.sheets import default_sheets
from mecano.results.layout import Layout, Series
from mecano.results.provenance import Source
from mecano.results.recorded import Event
from mecano.results.writer import Writer

T = np.linspace(0.0, 2.0, 41)
WAVE = np.sin(3.0 * T)


def panel(path, values, unit="N", x=None):
    y = Quantity(path, unit, "", "saved times", T, np.asarray(values, float))
    across = time_of(y) if x is None else Quantity(path + "_x", "m", "", "saved times", T, x)
    return Panel(y.what, (Curve(across, y, 0, y.subject),))


def labels(*sheets):
    return [panel.label for panel in overview(sheets).panels]


def test_signals_come_first_then_the_leading_panels_of_each_sheet_and_never_the_solver():
    wheels = Sheet("wheels", "", tuple(panel(f"elements/w/force_{i}", WAVE**2 + i * WAVE) for i in range(4)), lead=2)
    bodies = Sheet("bodies", "", tuple(panel(f"elements/b/speed_{i}", WAVE**3 - i * WAVE) for i in range(9)))
    signals = Sheet("signals", "", (panel("signals/slip/value", np.cos(T)),))
    solver = Sheet("solver", "", (panel("solver/residual", T**3),))
    shown = labels(wheels, bodies, signals, solver)
    assert shown[:1] == ["slip"] and len(shown) == PLACES
    assert shown[1:5] == [f"w: force {i}" for i in range(4)] and "solver" not in "".join(shown)
    assert shown[5:] == [f"b: speed {i}" for i in range(4)]  # a third one of the wheels and a second body are equal


@pytest.mark.parametrize(("unit", "values"), [
    ("rad", 750.0 * T),  # the bearing of a wheel
    ("rad", 6.3 * T**2),  # just beyond two turns
    ("kN", 63.176 + 4e-4 * WAVE),  # steady, but for what no axis should be stretched
], ids=("spinning", "two turns", "steady"))  # fmt: skip
def test_what_spins_or_is_steady_is_left_out_unless_there_is_nothing_else(unit, values):
    dull = Sheet("dull", "", (panel("joints/bearing/angle", values, unit),))
    telling = Sheet("telling", "", (panel("joints/elbow/angle", WAVE, "rad"),))
    assert labels(dull, telling) == ["elbow: angle"]
    assert labels(dull) == ["bearing: angle"]


def test_an_angle_of_less_than_two_turns_is_shown():
    assert labels(Sheet("angles", "", (panel("joints/crank/angle", 3.1 * T**2, "rad"),))) == ["crank: angle"]


def test_straight_lines_fill_the_room_that_is_left():
    """The force of a linear spring over its stroke says less than its stroke."""
    springs = Sheet("struts", "", (panel("elements/s/force", 5.0 * WAVE, x=WAVE), panel("elements/s/stroke", WAVE)))
    others = [Sheet(f"{i}", "", (panel(f"elements/e/number_{i}", WAVE ** (i + 2), "m"),)) for i in range(PLACES - 1)]
    assert "s: force" in labels(springs, *others[:-1])
    assert "s: force" not in labels(springs, *others) and "s: stroke" in labels(springs, *others)


@pytest.mark.parametrize(("name", "values", "repeats"), [
    ("velocity", -WAVE, True), ("speed", np.abs(WAVE), True), ("slower", 0.995 * WAVE, True),
    ("slow", 0.97 * WAVE, False),
])  # fmt: skip
def test_a_panel_that_repeats_another_one_is_left_out(name, values, repeats):
    first = Sheet("slides", "", (panel("joints/rail/rate", WAVE, "m/s"),))
    second = Sheet("bodies", "", (panel(f"elements/cart/{name}", values, "m/s"),))
    assert (f"cart: {name}" in labels(first, second)) == (not repeats)


def run_of(path, section, kind, names, series, values, events=(), deck=None):
    """The Run of a file of many things of one kind, each with the outputs ``series`` and its own ``values``."""
    one = next(iter(every_kind.deck({kind: KINDS[kind]})[section].values()))
    things = {name: one | (deck or {}).get(name, {}) for name in names}
    layout = Layout([Series(f"{section}/{name}/{output}", *declared) for name in names for output, *declared in series])
    whole = every_kind.DECK | {"elements": {}, "joints": {}, "loads": {}, "signals": {}} | {section: things}
    with Writer.create(path, layout, Source("mecano: 1\n", whole)) as writer:
        for t in T:
            row = np.concatenate([np.atleast_1d(values(i, t)) for i in range(len(names))])
            writer.extremes.take(t, row)
            writer.append(t, row)
        for t, name in events:
            writer.append_event(Event(t, f"{kind} '{name}'", "locks", "free", "locked"))
    return open_runs([path])


def subjects(runs, name):
    return set(next(sheet for sheet in default_sheets(runs) if sheet.name == name).subjects)


NAMES = [f"e{i}" for i in range(MOST + 3)]


def test_springs_with_the_largest_forces_are_shown_not_the_gauges_before_them(tmp_path):
    """The force over the stroke is the negative of the recorded force."""
    runs = run_of(tmp_path / "a.h5", "elements", "spring_damper", NAMES, (("force", "N", ""), ("stroke", "m", "")),
                  lambda i, t: (i * np.sin(t), np.sin(t + i)))  # fmt: skip
    assert subjects(runs, "struts") == set(NAMES[-MOST:])


def test_curves_like_those_shown_leave_room_for_another(tmp_path):
    """All but one, which varies least, differ by a few percent from one another."""
    runs = run_of(tmp_path / "a.h5", "joints", "hinge", NAMES, (("angle", "rad", ""),),
                  lambda i, t: (1.0 + 0.01 * i) * np.sin(t) if i else 0.1 * np.cos(t))  # fmt: skip
    assert subjects(runs, "angles") == {NAMES[0], *NAMES[-MOST + 1 :]}


def test_joints_that_lock_come_before_those_that_move_most_and_spinning_ones_last(tmp_path):
    runs = run_of(tmp_path / "a.h5", "joints", "hinge", NAMES, (("angle", "rad", ""),),
                  lambda i, t: 700.0 * t if i < 3 else np.sin(t) / (i + 1))  # fmt: skip
    assert subjects(runs, "angles") == set(NAMES[3:])
    few = run_of(tmp_path / "b.h5", "joints", "hinge", NAMES, (("angle", "rad", ""),),
                 lambda i, t: 700.0 * t if i else np.sin(t), events=[(1.0, NAMES[-1])])  # fmt: skip
    assert {NAMES[0], NAMES[-1]} <= subjects(few, "angles")


def test_what_spins_has_a_panel_of_its_own(tmp_path):
    """A crank that turns three times beside a rocker that swings by 1 rad."""
    runs = run_of(tmp_path / "a.h5", "joints", "hinge", NAMES[:3], (("angle", "rad", ""),),
                  lambda i, t: 9.5 * t if i == 1 else np.sin(t + i))  # fmt: skip
    [angles] = [sheet for sheet in default_sheets(runs) if sheet.name == "angles"]
    assert [panel.subjects for panel in angles.panels] == [("e1",), ("e0", "e2")]


def test_a_chassis_comes_before_its_wheels(tmp_path):
    """By the range of the momentum, not of the speed."""
    masses = {name: {"mass": 1.0 if i else 1e3} for i, name in enumerate(NAMES)}
    speeds = lambda i, t: ((1.0 + i) * np.sin(t), 0.0, 0.0)  # noqa: E731
    runs = run_of(
        tmp_path / "a.h5", "elements", "point_mass", NAMES, (("velocity", "m/s", "", (3,)),), speeds, deck=masses
    )
    assert NAMES[0] in subjects(runs, "bodies")


def test_signals_of_each_unit_are_shown(tmp_path):
    """A pressure varies by 1e7, a slip by 0.1: the sheet has as many of each as colours distinguish."""
    units = {name: {"unit": "Pa" if i < MOST + 1 else "m"} for i, name in enumerate(NAMES)}
    runs = run_of(tmp_path / "a.h5", "signals", "formula", NAMES, (("value", "SI", ""),),
                  lambda i, t: np.sin(t) * (1e7 + i if i < MOST + 1 else 0.1), deck=units)  # fmt: skip
    assert subjects(runs, "signals") == set(NAMES) - {NAMES[0]}

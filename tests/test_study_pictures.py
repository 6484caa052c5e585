"""Pictures and reports of studies: units, layouts, the cases shown."""

import math

import numpy as np
import pytest

from mecano.post.study_outputs import severity
from mecano.post.study_plots import is_geometric, study_figure
from mecano.post.study_report import study_report
from mecano.results.study_file import Column, StudyTable, column, read_study, write_study


def test_angles_of_a_study_are_displayed_in_degrees(tmp_path):
    """In the picture and in the tables of the report; the files of numbers have radians."""
    angles = np.deg2rad([5.0, 30.0, -20.0])
    columns = (
        Column("case", "case", "", "", np.arange(1.0, 4.0)),
        column("case", "status", "", "", ["complete"] * 3),
        column("case", "exit_code", "", "", [0.0] * 3),
        column("case", "reason", "", "", [""] * 3),
        Column("parameters", "parameters.steer", "rad", "", angles),
        Column("outputs", "lean", "rad", "most", 0.5 * angles, (None, math.radians(12.0))),
    )
    table = StudyTable("", "", "", columns)
    [ax] = study_figure(table).axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("steer [deg]", "lean [deg]")
    np.testing.assert_allclose(ax.lines[0].get_data(), [[-20.0, 5.0, 30.0], [-10.0, 2.5, 15.0]], rtol=1e-14)
    np.testing.assert_allclose(ax.lines[1].get_ydata(), 12.0, rtol=1e-14)
    write_study(tmp_path / "table.h5", table)
    limits, governing, cases = (section.parts[0] for section in study_report(tmp_path / "table.h5").sections[:3])
    assert limits.rows == [("lean", "most", "2", "deg", "", "12")]
    assert governing.rows == [("lean", "most", "deg", "-10", "3", "15", "2")]
    assert cases.columns == ("case", "steer [deg]", "lean [deg]")
    assert cases.rows == [("1", "5", "2.5"), ("2", "30", "15"), ("3", "-20", "-10")]
    assert np.array_equal(read_study(tmp_path / "table.h5")["parameters/parameters.steer"], angles)


@pytest.mark.parametrize("named", [False, True])
def test_what_is_beyond_a_limit_is_shaded(named):
    """Above the upper, below the lower limit, to the ends of the axis, in kN; a limit far away is not drawn."""
    names = [Column("case", "name", "", "", np.array(["soft", "firm"], object))] if named else []
    limits = {"load": (2000.0, 9000.0), "side": (None, 1e6)}
    columns = (
        Column("case", "status", "", "", ["complete"] * 2),
        Column("case", "case", "", "", np.arange(1.0, 3.0)),
        *names,
        Column("parameters", "speed", "m/s", "", np.array([1.0, 2.0])),
        *(Column("outputs", name, "N", "", np.array([3000.0, 9500.0]), own) for name, own in limits.items()),
    )
    figure = study_figure(StudyTable("", "", "", columns))
    first, second = figure.axes
    bars, (below, above) = first.patches[:-2], first.patches[-2:]
    ends = first.get_xlim() if named else first.get_ylim()
    spans = [np.sort(patch.get_extents().transformed(first.transData.inverted()).get_points()[:, 0 if named else 1])
             for patch in (below, above)]  # fmt: skip
    np.testing.assert_allclose(spans, [(ends[0], 2.0), (9.0, ends[1])])
    assert ends[0] < 2.0 and ends[1] > 9.5
    assert len(second.patches) == len(bars) == (2 if named else 0)
    assert "shaded: beyond a limit" in " ".join(text.get_text() for text in figure.texts)


def test_the_case_nearest_to_the_only_limit_of_an_output_governs():
    def most_severe(limits):
        return int(
            np.nanargmax(severity(Column("outputs", "gap", "m", "", np.array([1.0, 3.0, -4.0, np.nan]), limits)))
        )

    assert [most_severe(one) for one in [(None, None), (0.0, 5.0), (None, 5.0), (0.0, None)]] == [2, 2, 1, 2]


@pytest.mark.parametrize(("outputs", "varied"), [(9, 1), (7, 4), (9, 2), (20, 3)])
def test_a_picture_of_many_outputs_fits_a_screen(outputs, varied):
    """It is not higher than wide, and each column of panels has a label below."""
    columns = [Column("parameters", f"p{i}", "", "", np.arange(3.0) + i) for i in range(varied)]
    columns += [Column("outputs", f"y{i}", "", "", np.arange(3.0) * i) for i in range(outputs)]
    figure = study_figure(StudyTable("", "", "", (Column("case", "status", "", "", ["complete"] * 3), *columns)))
    assert figure.get_figheight() <= figure.get_figwidth()
    below = {ax.get_subplotspec().colspan.start for ax in figure.axes if ax.get_xlabel()}
    assert len(figure.axes) == outputs * varied
    assert below == {ax.get_subplotspec().colspan.start for ax in figure.axes}


def test_bars_of_many_cases_are_those_of_the_most_severe():
    names = [f"case {i}" for i in range(40)]
    loads = np.arange(40.0) - 15.0
    columns = (
        Column("case", "status", "", "", ["complete"] * 40),
        Column("case", "name", "", "", np.array(names, object)),
        Column("case", "case", "", "", np.arange(1.0, 41.0)),
        *(Column("outputs", f"y{i}", "N", "", loads * (-1.0) ** i) for i in range(5)),
        Column("outputs", "least", "N", "", loads, (0.0, None)),
    )
    figure = study_figure(StudyTable("", "", "", columns))
    assert "in each panel the 20 most severe" in " ".join(text.get_text() for text in figure.texts)
    assert figure.get_figheight() <= 1.2 * figure.get_figwidth()
    first, *_, last = figure.axes
    shown = [label.get_text() for label in first.get_yticklabels()]
    assert shown[:3] == ["case 39", "case 38", "case 37"] and len(shown) == len(first.patches) == 20
    assert [label.get_text() for label in last.get_yticklabels()][:2] == ["case 0", "case 1"]
    assert first.patches[0].get_width() == 24.0 and first.patches[0].get_alpha() == 1.0


def test_numbers_of_bars_that_are_too_small_to_be_seen_are_zero():
    """As the side loads of the symmetric cases, which are residuals of iterations."""
    columns = (
        Column("case", "status", "", "", ["complete"] * 3),
        Column("case", "name", "", "", np.array(["left", "level", "right"], object)),
        Column("case", "case", "", "", np.arange(1.0, 4.0)),
        Column("outputs", "side", "N", "", np.array([-900.0, -8e-4, 0.5])),
    )
    [ax] = study_figure(StudyTable("", "", "", columns)).axes
    assert [text.get_text() for text in ax.texts] == ["-900", "0", "0.5"]


@pytest.mark.parametrize(
    ("values", "geometric"),
    [([4.0, 2.0, 1.0, 0.5, 2.0], True), ([1.0, 2.0, 5.0, 10.0], True), ([1e-3, 1e-5, 1e-7], True),
     ([1.0, 2.0, 3.0, 4.0], False), ([0.0, 1.0, 2.0, 4.0], False), ([1.0, 2.0], False), ([40.0, 50.0, 60.0], False)],
)  # fmt: skip
def test_values_in_a_geometric_series_have_a_logarithmic_axis(values, geometric):
    """Steps and meshes of a study of convergence; speeds at equal distances have a linear axis."""
    step = Column("parameters", "time.step", "s", "", np.array(values))
    assert is_geometric(step) == geometric
    status = column("case", "status", "", "", ["complete"] * len(values))
    table = StudyTable("", "", "", (status, step, Column("outputs", "error", "m", "final", np.array(values) ** 2)))
    [ax] = study_figure(table).axes
    assert ax.get_xscale() == ("log" if geometric else "linear")

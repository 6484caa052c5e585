"""Measured curves in plots of a run."""

import numpy as np
import pytest
from time_runs import deck

import mecano
from mecano.errors import ResultsError, UnknownNameError, UsageError
from mecano.post.columns import columns_of
from mecano.post.curve_styles import CurveStyles
from mecano.post.measured import read_measured, with_measured
from mecano.post.pictures import post
from mecano.post.request import requested_sheets
from mecano.post.runs import opened_runs


@pytest.fixture(scope="module")
def turned(tmp_path_factory):
    """A hinge that turns at 2 rad/s; its angle as an output, and as a signal in degrees."""
    given = deck("""
        mecano: 1
        gravity: none
        nodes: {a: {position: [0, 0, 0]}}
        elements: {body: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}}
        joints: {hinge: {type: hinge, nodes: [ground, a], axis: [0, 0, 1]}}
        signals: {turned: {type: formula, value: hinge.angle, unit: deg}}
        initial: {velocities: [{nodes: [a], angular_velocity: [0, 0, 2]}]}
        time: {end: 1, step: 0.01}
        """)
    path = tmp_path_factory.mktemp("measured") / "turned.h5"
    mecano.run(mecano.Deck(given.resolved()), path, quiet=True).close()
    return path


def table(folder, text):
    path = folder / "test.csv"
    path.write_text(text)
    return path


def points(run, path, *plots):
    [sheet] = with_measured(requested_sheets(plots, [run]), read_measured(path, run))
    return sheet, [curve for curve in sheet.curves if curve.measured]


def test_columns_are_drawn_in_the_units_of_the_plot(turned, tmp_path):
    """Milliseconds and degrees, for an output in radians and a signal in degrees; an empty cell is a gap."""
    path = table(tmp_path, "# bench\ntime [ms]; hinge.angle (deg); turned\n250; 30; 0.5\n500; ; 1\n")
    with opened_runs([turned]) as [run]:
        for plot, values in (("hinge.angle", [np.pi / 6, np.nan]), ("turned", np.degrees([0.5, 1]))):
            sheet, [curve] = points(run, path, plot)
            np.testing.assert_allclose(curve.x.values, [0.25, 0.5])
            np.testing.assert_allclose(curve.y.values, values)
            assert curve.measured == "test.csv"
            assert [handle.get_label() for handle in CurveStyles(sheet).legend(sheet.panels[0])][1:] == ["test.csv"]
            assert len(columns_of(sheet.curves)[0]) == 2  # without the measured values


def test_a_plot_over_another_output_and_one_that_was_not_measured(turned, tmp_path):
    path = table(tmp_path, "hinge.angle, hinge.rate\n0.1, 2\n0.2, 2\n")
    with opened_runs([turned]) as [run]:
        assert len(points(run, path, "hinge.rate:hinge.angle")[1]) == 1
        with pytest.raises(UsageError, match="no requested plot shows two of the columns of test.csv: hinge.angle"):
            points(run, path, "hinge.rate")


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        ("0, 1\n1, 2\n", UsageError, "a line of headers"),
        ("time, hinge.angle\n", UsageError, "rows of numbers"),
        ("time, hinge.angle\n0, 1\n1\n", UsageError, "2 numbers needed in each row, got '1'"),
        ("time, hinge.angle\n0, x\n", UsageError, "2 numbers needed in each row, got '0, x'"),
        ("time, hinge.angle [kN]\n0, 1\n", UsageError, "'hinge.angle .kN.': an angle .* is expected"),
        ("time, hinge.angel\n0, 1\n", UnknownNameError, "hinge.angle"),
        ("time, a.position\n0, 1\n", UsageError, "several numbers"),
    ],
)
def test_what_is_refused(turned, tmp_path, text, error, message):
    with opened_runs([turned]) as [run], pytest.raises(error, match=message):
        read_measured(table(tmp_path, text), run)


def test_a_file_that_cannot_be_read(turned, tmp_path):
    with opened_runs([turned]) as [run], pytest.raises(ResultsError, match=r"cannot read .*absent\.csv"):
        read_measured(tmp_path / "absent.csv", run)


def test_a_single_signal_has_no_legend(turned):
    """Its name is the label of the axis."""
    with opened_runs([turned]) as [run]:
        [sheet] = requested_sheets(["turned"], [run])
        assert not CurveStyles(sheet).legend(sheet.panels[0])


def test_without_plots_every_column_has_a_picture(turned, tmp_path):
    path = table(tmp_path, "time, hinge.angle, hinge.rate\n0, 0, 2\n1, 2, 2\n")
    drawn = list(post([turned], measured=path, output=f"{tmp_path}/"))
    assert [picture.name for picture in drawn] == ["turned_hinge.angle.png", "turned_hinge.rate.png"]


def test_time_over_an_output(turned, tmp_path):
    [picture] = post([turned], ["time:hinge.angle"], output=f"{tmp_path}/")
    assert picture.exists()

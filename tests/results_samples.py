"""A small run with known values in every row, and checks of the content of its file."""

import numpy as np

from mecano.results.layout import Layout, Series
from mecano.results.provenance import Source
from mecano.results.recorded import Event
from mecano.results.writer import Writer

LAYOUT = Layout(
    [
        Series("nodes/axle/position", "m", "position, inertial", (3,)),
        Series("nodes/axle/rotation", "", "unit quaternion", (4,)),
        Series("elements/wheel/radial_force", "N", "force along the radius"),
        Series("elements/wheel/slip", "m/s", "slip velocity", (3,)),
        Series("joints/knee/angle", "rad", "angle, continuous over many turns"),
        Series("joints/knee/stiffness", "N m/rad", "tangent", (3, 3)),
        Series("energy/total", "J", "kinetic + potential"),
    ]
)
SOURCE = Source(
    deck_text="mecano: 1\ntitle: Prüfstand\n",
    resolved={"title": "Prüfstand", "gravity": np.array([0.0, 0.0, -9.81])},
    deck_path="deck.yaml",
    title="Prüfstand",
    overrides=("time.end=2",),
    includes={"table.csv": "ab12"},
)
STEP = np.arange(8.0)


def time_of(index):
    """Saved time of a row [s]; not a round binary number."""
    return 0.1 * np.asarray(index)


def rows_of(index):
    """All values of the rows ``index``: any wrong bit of any row shows."""
    return np.sin(np.asarray(index)[..., None] + np.arange(LAYOUT.size) * 1e3)


def append(writer, index):
    """What an accepted step leaves in the file: a row, a line of the history, an event, extremes."""
    time, row = float(time_of(index)), rows_of(index)
    writer.extremes.take(time, row)
    writer.append(time, row)
    writer.append_step(time, STEP + index)
    writer.append_event(Event(time, f"wheel {index}", "touch-down", "airborne", "rolling"))


def create(path, **options):
    """A new file of this run."""
    return Writer.create(path, LAYOUT, SOURCE, **options)


def check(results):
    """Every value of every row of every kind in the file is right, bit for bit; returns the number of saved times."""
    count = len(results.time)
    index = np.arange(count)
    expected = rows_of(index)
    assert np.array_equal(results.time, time_of(index))
    for series in LAYOUT.series:
        part = expected[:, LAYOUT.slices[series.path]].reshape(count, *series.shape)
        assert np.array_equal(results[series.path].values, part), series.path
    steps = results.steps
    assert np.array_equal(steps["time"], time_of(np.arange(len(steps))))
    assert np.array_equal(steps["increment"], 7.0 + np.arange(len(steps)))
    assert [event.element for event in results.events] == [f"wheel {i}" for i in range(len(results.events))]
    return count


def check_extremes(results, count):
    """The extremes in the file are those of the first ``count`` steps."""
    rows = rows_of(np.arange(count))
    found = list(results.extremes.values())
    assert [e.maximum for e in found] == rows.max(axis=0).tolist()
    assert [e.minimum for e in found] == rows.min(axis=0).tolist()
    assert [e.maximum_time for e in found] == time_of(rows.argmax(axis=0)).tolist()
    assert [e.minimum_time for e in found] == time_of(rows.argmin(axis=0)).tolist()

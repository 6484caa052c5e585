"""The results file: round trip, names, attributes, refusals, state, speed."""

import io
import os
import re
import subprocess
import sys

import h5py
import numpy as np
import pytest
import results_samples as samples
from calls import calls

from mecano.errors import ResultsError, UnknownNameError
from mecano.jit import machine_code, store
from mecano.results import empty_file
from mecano.results.layout import Layout, Series
from mecano.results.lookup import Lookup, similar_outputs
from mecano.results.opening import cut_short
from mecano.results.provenance import Source, is_running
from mecano.results.reader import open_results
from mecano.results.recorded import Event
from mecano.results.state import load_state, save_state
from mecano.results.study_file import StudyTable, write_study
from mecano.results.writer import Writer


@pytest.fixture
def finished(tmp_path):
    path = tmp_path / "results.h5"
    with samples.create(path) as writer:
        for index in range(40):
            samples.append(writer, index)
        writer.close("stopped", "the wheel left the ground")
    return path


def test_round_trip(finished):
    with open_results(finished) as results:
        assert samples.check(results) == 40
        samples.check_extremes(results, 40)
        assert len(results.steps) == len(results.events) == 40
        assert (results.status, results.reason) == ("stopped", "the wheel left the ground")
        assert results.deck_text == samples.SOURCE.deck_text
        assert results.resolved == {"title": "Prüfstand", "gravity": [0.0, 0.0, -9.81]}
        event = results.events[3]
        assert (event.time, event.name, event.before, event.after) == (0.1 * 3, "touch-down", "airborne", "rolling")
    assert os.listdir(finished.parent) == ["results.h5"]


def test_more_rows_than_a_block(tmp_path):
    with samples.create(tmp_path / "r.h5") as writer:
        for index in range(2500):
            samples.append(writer, index)
        assert 2000 < writer.acknowledged < 2500  # blocks of 1024 rows were flushed
    with open_results(tmp_path / "r.h5") as results:
        assert samples.check(results) == 2500
        assert results.status == "complete"


def test_metadata(finished):
    with open_results(finished) as results:
        metadata = results.metadata
    assert metadata["overrides"] == ["time.end=2"] and metadata["includes"] == {"table.csv": "ab12"}
    assert metadata["title"] == "Prüfstand" and metadata["deck_path"] == "deck.yaml"
    assert metadata["version_numpy"] == np.__version__ and metadata["version_h5py"] == h5py.__version__
    assert metadata["threads"] == 1 and metadata["process"] == os.getpid() and metadata["format_version"] == 1
    assert metadata["command_line"] and metadata["host"] and metadata["started"] and metadata["processor"]
    assert 0 < metadata["wall_time"] < 60 and metadata["processor_time"] > 0


def test_the_clock_of_the_run_leaves_compiling_out(tmp_path, monkeypatch):
    """3 s of compiling before the run, 500 s during it."""
    monkeypatch.setattr(machine_code, "_times", [3.0])
    with samples.create(tmp_path / "r.h5") as writer:
        writer._started -= 500.0
        machine_code._times.append(500.0)
        samples.append(writer, 0)
    with open_results(tmp_path / "r.h5") as results:
        assert 0 < results.metadata["wall_time"] < 60 and results.metadata["compile_time"] == 503.0


def test_status_and_rows_are_of_the_same_time(tmp_path):
    """A run that ends while it is read: what was opened as running stays so until the file is opened again."""
    with samples.create(tmp_path / "r.h5") as writer:
        samples.append(writer, 0)
        writer.flush()
        with open_results(tmp_path / "r.h5") as results:
            before = results.status, len(results.time)
            samples.append(writer, 1)
            writer.close()
            assert (results.status, len(results.time)) == before
            results.refresh()
            assert (results.status, len(results.time)) == ("complete", 2)


def test_named_views_carry_units_meanings_and_time(finished):
    with h5py.File(finished, "r") as file:
        for series in samples.LAYOUT.series:
            view = file[series.path]
            expected = samples.rows_of(np.arange(40))[:, samples.LAYOUT.slices[series.path]]
            assert np.array_equal(view[:], expected.reshape(40, *series.shape))
            assert view.attrs["units"] == series.unit and view.attrs["long_name"] == series.doc
            assert view.dims[0][0].name == "/time"
        assert file["nodes/axle/position"].dims[1][0].name == "/xyz"
        assert file["xyz"][:].tolist() == [b"x", b"y", b"z"] and file["wxyz"][:].tolist() == [b"w", b"x", b"y", b"z"]
        assert file["time"].attrs["units"] == "s" and np.array_equal(file["time"][:], samples.time_of(np.arange(40)))
        assert np.array_equal(file["solver/step_size"][:], np.arange(40.0)) and "checkpoints" in file
        assert file["run/status"][()] == b"stopped" and file["run/acknowledged"][:3].tolist() == [40, 40, 40]


@pytest.mark.parametrize(
    "name, path, component",
    [
        ("elements/wheel/radial_force", "elements/wheel/radial_force", None),
        ("wheel.radial_force", "elements/wheel/radial_force", None),
        ("joints.knee.angle", "joints/knee/angle", None),
        ("axle.position.z", "nodes/axle/position.z", 2),
        ("axle.position[1]", "nodes/axle/position.y", 1),
        ("axle.rotation.w", "nodes/axle/rotation.w", 0),
        ("knee.stiffness.1.2", "joints/knee/stiffness.1.2", 5),
        ("knee.stiffness[2][0]", "joints/knee/stiffness.2.0", 6),
        ("energy.total", "energy/total", None),
    ],
)
def test_names_people_write(finished, name, path, component):
    with open_results(finished) as results:
        trace = results.find(name)
    series = next(one for one in samples.LAYOUT.series if one.path == path.split(".")[0])
    expected = samples.rows_of(np.arange(40))[:, samples.LAYOUT.slices[series.path]]
    expected = expected.reshape(40, *series.shape) if component is None else expected[:, component]
    assert (trace.path, trace.unit, trace.doc) == (path, series.unit, series.doc)
    assert np.array_equal(trace.values, expected) and np.array_equal(trace.time, samples.time_of(np.arange(40)))


def test_the_magnitude_of_a_vector(finished):
    with open_results(finished) as results:
        trace, position = results["axle.position.magnitude"], results["axle.position"]
        assert (trace.path, trace.unit) == ("nodes/axle/position.magnitude", "m") and trace.components == ()
        np.testing.assert_allclose(trace.values, np.hypot(np.hypot(*position.values.T[:2]), position.values.T[2]))


def test_the_solver_history_has_names_too(finished):
    with open_results(finished) as results:
        for name in ("solver.step_size", "solver/step_size"):
            trace = results[name]
            assert np.array_equal(trace.values, results.steps["step_size"])
            assert np.array_equal(trace.time, results.steps["time"])
            assert (trace.path, trace.unit, trace.components) == ("solver/step_size", "s", ())
            assert trace.doc == "size of the accepted step"
        with pytest.raises(ResultsError, match="no output 'solver.stepsize'"):
            results["solver.stepsize"]


def test_similar_outputs_are_different_ones():
    """Not hinge.angle and joints.hinge.angle, which are the same."""
    paths = [f"joints/hinge/{name}" for name in ("angle", "rate", "force")]
    assert similar_outputs("hinge.angel", paths) == ["hinge.angle", "hinge.rate", "hinge.force"]


def test_notebooks_complete_names_that_can_be_used(finished):
    """By any ending, such as that without the section."""
    with open_results(finished) as results:
        names = results._ipython_key_completions_()
        assert {"wheel.radial_force", "elements.wheel.radial_force", "axle.position"} <= set(names)
        assert all(name in results for name in names)


@pytest.mark.parametrize(
    "name, message",
    [
        ("wheel.radial_froce", "did you mean wheel.radial_force"),
        ("axle.positon.z", "did you mean axle.position"),
        ("axle.position.q", "no component 'q' in 'axle.position.q': there are x, y, z"),
        ("axle.position.3", "no component '3'"),
        ("axle.positon.magnitude", "no output 'axle.positon' in this file; did you mean axle.position"),
        ("wheel.radial_force.x", "no output 'wheel.radial_force.x'"),
        (
            "abs(wheel.radial_force)",
            "no output 'abs(wheel.radial_force)' in this file; for a formula of outputs define a signal in the deck",
        ),
        (
            "axle.acceleration.z",
            "no output 'axle.acceleration.z' in this file: add an element {type: attitude, node: axle} to the deck",
        ),
        ("qqqqqq", "no output 'qqqqqq' in this file; `mecano info` lists them"),
        ("axle", "no output 'axle' in this file, but axle.position, axle.rotation"),
        ("radial_force", "no output 'radial_force' in this file; there are wheel.radial_force"),
    ],
)
def test_names_that_are_wrong(finished, name, message):
    with open_results(finished) as results, pytest.raises(ResultsError) as error:
        results.find(name)
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("name", "answer"),
    [
        ("arm.moment", "write arm.1.moment to arm.11.moment"),
        ("arm.moment.y", "write arm.1.moment to arm.11.moment"),
        ("tip.displacement.z", "nodes have positions only; write tip.position"),
    ],
)
def test_names_of_divided_members_and_displacements_are_answered(name, answer):
    paths = [*(f"elements/arm.{i}/moment" for i in (10, 2, 1, 11)), "nodes/tip/position"]
    with pytest.raises(UnknownNameError, match=re.escape(answer)):
        Lookup([Series(path, "", "", (3,)) for path in paths]).find(name)


def test_a_signal_has_its_own_name():
    """A name of a signal and of an element is that of the signal, as outputs of elements have longer ones."""
    paths = ["signals/torque/integral", "signals/torque/value", "joints/torque/force"]
    lookup = Lookup([Series(path, "", "", ()) for path in paths])
    assert [lookup.find(name)[0].path for name in ("torque", "torque.value", "torque.integral")] == [
        paths[1], paths[1], paths[0],
    ]  # fmt: skip
    with pytest.raises(UnknownNameError, match=re.escape("no output 'torque.x'")):
        lookup.find("torque.x")


def test_a_name_of_several_series_is_refused(tmp_path):
    layout = Layout([Series("elements/leg/force", "N", "a"), Series("joints/leg/force", "N", "b")])
    Writer.create(tmp_path / "r.h5", layout, Source("", {})).close()
    with open_results(tmp_path / "r.h5") as results:
        with pytest.raises(ResultsError, match="elements.leg.force, joints.leg.force: write more"):
            results.find("leg.force")
        assert results.find("joints.leg.force").doc == "b"


def test_results_are_asked_for_names(finished):
    with open_results(finished) as results:
        assert "wheel.radial_force" in results and "solver.step_size" in results and "wheel.force" not in results
        assert list(results) == results.names()
        assert results.extremes["axle.position.z"] == results.extremes["nodes/axle/position.z"]
        with pytest.raises(UnknownNameError, match=r"'axle.position' has .*: write nodes/axle/position.x or"):
            results.extremes["axle.position"]
        with pytest.raises(UnknownNameError, match="did you mean wheel.radial_force"):
            results.extremes["wheel.radial_fors"]


def test_a_trace_stands_for_its_values(finished):
    with open_results(finished) as results:
        trace = results.find("axle.position")
        np.testing.assert_array_equal(trace, trace.values)
        assert np.asarray(trace).shape == trace.values.shape == (len(trace.time), 3)
        assert trace[-1, 2] == trace.values[-1, 2] and np.max(trace) == trace.values.max()
        assert np.array_equal(abs(2 * trace - trace), abs(trace.values)) and np.array_equal(-trace, -trace.values)
        assert np.array_equal(trace > 0.1, trace.values > 0.1) and np.array_equal(
            trace == trace[0], trace.values == trace[0]
        )


def test_closed_results_are_refused_until_they_are_opened_again(finished):
    with open_results(finished) as results:
        pass
    for read in (lambda: results["wheel.slip"], lambda: results.extremes, lambda: results.status):
        with pytest.raises(ResultsError, match="have been closed: read them before, or open the file again"):
            read()
    results.refresh()
    assert results["wheel.slip"].unit
    results.close()


def test_names_by_pattern(finished):
    with open_results(finished) as results:
        assert results.names() == [one.path for one in samples.LAYOUT.series]
        assert results.names("wheel.*") == ["elements/wheel/radial_force", "elements/wheel/slip"]
        assert results.names("joints/*") == ["joints/knee/angle", "joints/knee/stiffness"]
        assert results.names("nothing*") == []


@pytest.mark.parametrize(
    "paths",
    [["a/b", "a/b"], ["a/b", "a/b/c"], ["run/x"], ["VTKHDF"], ["a//b"], ["index_3"], ["time"], ["a/../b"], [""]],
)
def test_layouts_that_cannot_be_stored(paths):
    with pytest.raises(ValueError):
        Layout([Series(path, "", "") for path in paths])


def test_an_existing_file_is_kept_unless_forced(finished):
    before = finished.read_bytes()
    with pytest.raises(ResultsError, match="already exists.*--force"):
        samples.create(finished)
    assert finished.read_bytes() == before and os.listdir(finished.parent) == ["results.h5"]
    samples.create(finished, force=True).close()
    with open_results(finished) as results:
        assert len(results.time) == 0 and results.status == "complete" and results.events == []
        assert np.isnan(results.extremes["energy/total"].maximum)
    assert os.listdir(finished.parent) == ["results.h5"]


def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "r.h5")
    assert list(cut_short([tmp_path / "r.h5"])) == []


@pytest.mark.parametrize("target, message", [("none/r.h5", "No such file"), (".", "it is a folder"), ("p", "a pipe")])
def test_paths_that_cannot_be_written(tmp_path, target, message):
    os.mkfifo(tmp_path / "p")
    with pytest.raises(ResultsError, match=message) as error:
        samples.create(tmp_path / target)
    assert error.value.exit_code == 5


def test_an_exception_ends_the_file_as_failed(tmp_path):
    with pytest.raises(ZeroDivisionError), samples.create(tmp_path / "r.h5") as writer:
        samples.append(writer, 0)
        raise ZeroDivisionError("mass is zero")
    with open_results(tmp_path / "r.h5") as results:
        assert (samples.check(results), results.status, results.reason) == (1, "failed", "mass is zero")


def test_nothing_is_written_after_the_end(finished, tmp_path):
    writer = samples.create(tmp_path / "r.h5")
    writer.close()
    writer.close()
    with pytest.raises(ResultsError, match="is closed"):
        writer.flush()
    with pytest.raises(ValueError, match="'running' is not a status"):
        samples.create(tmp_path / "s.h5").close("running")


def test_long_texts_are_cut_between_letters(tmp_path):
    with samples.create(tmp_path / "r.h5") as writer:
        writer.append_event(Event(1.0, "ü" * 100, "n", "b", "a"))
        writer.close("failed", "ä" * 5000)
    with open_results(tmp_path / "r.h5") as results:
        assert results.events[0].element == "ü" * 32 and results.reason == "ä" * 4000


def _other_hdf5(path):
    with h5py.File(path, "w") as file:
        file["x"] = 1.0


def _study(path):
    write_study(path, StudyTable("", "", "deck.yaml", ()))


def _newer(path):
    samples.create(path).close()
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = 99


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda path: None, "No such file"),
        (lambda path: path.mkdir(), "it is a folder"),
        (lambda path: os.mkfifo(path), "it is a pipe"),
        (lambda path: path.write_bytes(b""), "not a results file"),
        (lambda path: path.write_text("time: 1\n" * 1000), "not a results file"),
        (lambda path: path.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(10)), "cannot be read"),
        (_other_hdf5, "not a results file of mecano"),
        (_study, "not a results file of a run, but of the format 'mecano study'"),
        (_newer, "format 99 of a newer mecano"),
    ],
)
def test_files_that_are_no_results(tmp_path, make, message):
    make(tmp_path / "r.h5")
    with pytest.raises(ResultsError, match=message) as error:
        open_results(tmp_path / "r.h5")
    assert error.value.exit_code == 5


def test_decks_and_folders_of_studies_as_results_are_answered(tmp_path):
    (tmp_path / "deck.yaml").write_text("mecano: 1")
    with pytest.raises(ResultsError, match="not an HDF5 file; if it is a deck: mecano run .*deck.yaml"):
        open_results(tmp_path / "deck.yaml")
    (tmp_path / "table.h5").touch()
    with pytest.raises(ResultsError, match="it is a folder; the table of its study is .*table.h5"):
        open_results(tmp_path)


def test_similar_outputs():
    paths = ["joints/hinge/angle", "joints/hinge/rate", "nodes/pin/position"]
    assert similar_outputs("hinge.angel", paths)[0] == "hinge.angle"


STATE = {
    "positions": np.random.default_rng(1).normal(size=(5, 3)),
    "odd": np.array([np.nan, -0.0, np.inf, 5e-324, np.frombuffer(b"\1\0\0\0\0\0\xf8\x7f")[0]]),
    "single": np.float32([0.1, 0.2]),
    "modes": np.array([[1, -2], [3, 4]], dtype=np.int32, order="F"),
    "flags": np.array([True, False]),
    "names": np.array(["Knie", "ä\0b", ""]),
    "bytes": np.array([b"a\0b", b"c"]),
    "empty": np.zeros((0, 4)),
    "zero_dimensional": np.array(3.5),
    "complex": np.array([1 + 2j]),
    "records": np.zeros(2, dtype=np.dtype([("mass", "f8"), ("n", "i4"), ("J", "f8", (3, 3))], align=True)),
    "time": 0.1,
    "step": 12,
    "big": 2**127 + 1,
    "accepted": True,
    "nothing": None,
    "method": "generalized_alpha ρ",
    "size": np.float32(0.1),
    "controller": {"history": {"error": np.array([1e-3])}, "rejected": 0},
}


def _same(one, other):
    assert type(one) is type(other)
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for key in one:
            _same(one[key], other[key])
    elif isinstance(one, np.ndarray):
        assert (one.dtype, one.shape, one.tobytes()) == (other.dtype, other.shape, other.tobytes())
    else:
        assert one == other


def test_a_state_comes_back_bit_for_bit(tmp_path):
    with h5py.File(tmp_path / "s.h5", "w") as file:
        save_state(file.create_group("checkpoints"), "0", STATE)
    with h5py.File(tmp_path / "s.h5") as file:
        _same(load_state(file["checkpoints/0"]), STATE)


@pytest.mark.parametrize(
    "state, error",
    [({"a/b": 1}, ValueError), ({1: 1}, ValueError), ({"a": [1, 2]}, TypeError), ({"a": np.array([None])}, TypeError)],
)
def test_states_that_cannot_be_saved(tmp_path, state, error):
    with h5py.File(tmp_path / "s.h5", "w") as file, pytest.raises(error):
        save_state(file, "0", state)


def _contents(data):
    """What stands in the file of these bytes; HDF5 stamps its groups with the second they were made in."""
    with h5py.File(io.BytesIO(data)) as file:
        found = {}
        file.visititems(lambda name, one: found.update({name: _content(one)}))
        return found | {"/": _content(file)}


def _content(one):
    names = sorted(name for name in one.attrs if name not in ("DIMENSION_LIST", "REFERENCE_LIST"))
    return [(name, repr(one.attrs[name])) for name in names], repr(one[()]) if isinstance(one, h5py.Dataset) else ""


def test_runs_of_one_layout_begin_with_a_copy(tmp_path, monkeypatch):
    """Kept bytes that were damaged are made anew, to the same contents; of many layouts the last are kept."""
    kept = tmp_path / "kept"
    kept.mkdir()
    monkeypatch.setattr(store, "folder", lambda: kept)
    monkeypatch.setattr(empty_file, "MOST_KEPT", 2)
    layouts = [Layout([Series(f"elements/e{i}/force", "N", "force", (3,))]) for i in range(4)]
    first = empty_file.empty_file(layouts[0])
    assert [path.read_bytes() for path in kept.iterdir()] != [first] and empty_file.empty_file(layouts[0]) == first
    (path,) = kept.iterdir()
    path.write_bytes(path.read_bytes()[:-9])
    anew = empty_file.empty_file(layouts[0])
    assert empty_file.empty_file(layouts[0]) == anew and _contents(anew) == _contents(first)
    for layout in layouts[1:]:
        assert _contents(empty_file.empty_file(layout)) != _contents(first)
    assert len(list(kept.iterdir())) == 2
    monkeypatch.setattr(store, "folder", lambda: tmp_path / "not there")
    assert _contents(empty_file.empty_file(layouts[0])) == _contents(first)


def test_many_series_have_no_views_but_are_read(tmp_path):
    layout = Layout([Series(f"elements/e{i}/force", "N", "force", (3,)) for i in range(3001)])
    with Writer.create(tmp_path / "r.h5", layout, Source("", {})) as writer:
        writer.append(0.0, np.arange(layout.size, dtype=float))
    with open_results(tmp_path / "r.h5") as results:
        assert results["e3000.force"].values.tolist() == [[9000.0, 9001.0, 9002.0]]
    with h5py.File(tmp_path / "r.h5") as file:
        assert "elements" not in file


def test_appending_makes_few_calls(tmp_path):
    """Rows of 500 numbers with all their flushes: some 20 us each; a flush of one row: some 3 ms."""
    layout = Layout([Series(f"elements/e{i}/force", "N", "force", (5,)) for i in range(100)])
    row = np.ones(500)
    with Writer.create(tmp_path / "r.h5", layout, Source("", {}), flush_interval=1e9) as writer:

        def append():
            for index in range(2048):
                writer.append(index, row)

        def flush():
            writer.append(2048, row)
            writer.flush()

        append()
        assert calls(append) < 15 * 2048
        flush()
        assert calls(flush) < 1500


def test_the_reader_needs_no_compiler():
    code = "import sys, mecano.results.reader; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


def test_a_killed_process_does_not_live_though_nobody_has_taken_note():
    process = subprocess.Popen(["sleep", "60"])
    assert is_running(process.pid)
    process.kill()
    os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)  # dead, and still listed
    assert not is_running(process.pid)
    process.wait()
    assert not is_running(process.pid)

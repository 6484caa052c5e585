"""Results for other programs: columns, and points and cells over time in the format of VTK."""

import csv

import every_kind
import h5py
import numpy as np
import pytest
from process import mecano_process
from time_runs import input_deck

from mecano.analyses.dynamic import run
from mecano.elements import KINDS
from mecano.errors import ResultsError, UnknownNameError, UsageError
from mecano.post import grid
from mecano.post.export import export
from mecano.post.runs import open_runs
from mecano.results.layout import Layout, Series
from mecano.results.provenance import Source
from mecano.results.reader import open_results
from mecano.results.verify import verify
from mecano.results.vtk_group import LINE, POLY_LINE, VERTEX
from mecano.results.writer import Writer


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return every_kind.write(tmp_path_factory.mktemp("export") / "each.h5")


@pytest.fixture
def own(tmp_path):
    return every_kind.write(tmp_path / "own.h5", kinds={"beam": KINDS["beam"]})


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """A wheel that flies before it touches down."""
    file = tmp_path_factory.mktemp("rolling") / "wheel.h5"
    run(input_deck("wheel_drop", "time.end=0.02", "output.every=1e-3", "time.adaptive=null", "time.step=1e-3"), file)
    return file


def table(path):
    header, *rows = csv.reader(path.read_text().splitlines())
    return header, np.array([[float(cell) if cell else np.nan for cell in row] for row in rows])


def test_columns_are_all_series_with_units(path, tmp_path):
    header, numbers = table(export(path, tmp_path / "all.csv"))
    with open_results(path) as results:
        scalars = [name for series in results.series.values() for name in series.scalars]
        expected = np.column_stack(
            [results.time, *(results[name].values.reshape(len(results.time), -1) for name in results.names())]
        )
    assert header[0] == "time [s]" and [name.partition(" [")[0] for name in header[1:]] == [
        name.replace("/", ".") for name in scalars
    ]
    assert header[header.index("elements.one_wheel.radial_force [N]") - 1].startswith("elements.one_wheel.deformation")
    assert np.array_equal(numbers, expected)  # every bit


def test_chosen_columns_with_the_steps_in_columns_of_their_own(path, tmp_path):
    chosen = ["one_wheel.contact_force.magnitude", "joints.*.angle", "solver.step_size"]
    header, numbers = table(export(path, tmp_path / "some.csv", series=chosen))
    assert header[:2] == ["time [s]", "elements.one_wheel.contact_force.magnitude [N]"]
    assert header[-2:] == ["solver.time [s]", "solver.step_size [s]"] and "joints.one_hinge.angle [rad]" in header
    assert np.isfinite(numbers[:-1]).all() and np.isnan(numbers[-1, -2:]).all()  # one step fewer than saved times


def test_formulas_that_are_products_have_columns(tmp_path):
    """Their names have the * of a pattern; each is written once."""
    paths = ["formulas/2*hinge.angle/value", "formulas/2*3*hinge.angle/value"]
    layout = Layout([Series(path, "SI", "value of the signal") for path in paths])
    with Writer.create(tmp_path / "r.h5", layout, Source("", {}, "deck.yaml", "")) as writer:
        writer.append(0.0, np.array([2.0, 6.0]))
    for series in ((), ["formulas.*"], [path.replace("/", ".") for path in paths]):
        header, numbers = table(export(tmp_path / "r.h5", series=series, force=True))
        assert header == ["time [s]", "formulas.2*hinge.angle.value [SI]", "formulas.2*3*hinge.angle.value [SI]"]
        assert numbers.tolist() == [[0.0, 2.0, 6.0]]


def test_a_file_beside_the_results_which_is_not_overwritten(own):
    written = export(own)
    assert written == own.with_suffix(".csv")
    with pytest.raises(ResultsError, match="own.csv already exists"):
        export(own)
    written.write_text("old")
    assert export(own, force=True) == written and written.read_text().startswith("time")
    with pytest.raises(ResultsError, match="not a results file"):
        export(own, own.with_suffix(".csv").rename(own.with_suffix(".vtkhdf")), force=True)


def test_an_ending_that_is_left_out_is_added(path, tmp_path):
    assert export(path, tmp_path / "cells", vtk=True) == tmp_path / "cells.vtkhdf"
    assert export(path, tmp_path / "columns", series=["one_hinge.angle"]) == tmp_path / "columns.csv"
    with h5py.File(tmp_path / "cells.vtkhdf") as file:
        assert "VTKHDF" in file


def test_all_columns_of_the_solver_history(path, tmp_path):
    header, _ = table(export(path, tmp_path / "solver.csv", series=["solver.*"]))
    with open_results(path) as results:
        names = [f"solver.{name}" for name in results.step_columns]
    assert [name.partition(" [")[0] for name in header] == ["solver.time", *names] and len(names) > 5
    with pytest.raises(UsageError, match=r"no column 'step_\*x' in the solver history; "):
        export(path, tmp_path / "a.csv", series=["solver.step_*x"])


def test_what_cannot_be_exported_is_reported(path, tmp_path):
    for options in ({"output": tmp_path / "a.txt"}, {"vtk": True, "output": tmp_path / "a.csv"}):
        with pytest.raises(UsageError, match=".vtkhdf"):
            export(path, **options)
    with pytest.raises(UsageError, match="selects columns"):
        export(path, tmp_path / "a.vtkhdf", series=["one_hinge.angle"])
    with pytest.raises(UnknownNameError, match="each.h5.*did you mean"):
        export(path, tmp_path / "a.csv", series=["one_hinge.angel"])
    with pytest.raises(ResultsError, match="cannot write"):
        export(path, "/proc/a.csv")
    assert list(tmp_path.iterdir()) == []


def test_points_are_the_nodes_first_and_cells_know_their_owners(path):
    [run] = open_runs([path])
    [cells] = grid.grids_of(run)
    assert cells.names["node"] == ["base", "tip"]
    expected = np.stack([run.results[f"{node}.position"].values for node in ("base", "tip")], axis=1)
    assert np.array_equal(cells.points.values[:, :2], expected)
    by_owner = {cells.names["owner"][i]: cell for i, cell in zip(cells.cell_owner, cells.cells, strict=True)}
    assert by_owner["elements/one_beam"] == (LINE, (0, 1)) and by_owner["joints/one_hinge"] == (VERTEX, (1,))
    kind, rim = by_owner["elements/one_wheel"]
    assert kind == POLY_LINE and rim[-1] == 1 and len(rim) == 50
    assert np.array_equal(cells.point_data["displacement"].values, cells.points.values - cells.points.values[:1])


def test_cells_carry_their_own_forces_and_nothing_of_others(path):
    [run] = open_runs([path])
    [cells] = grid.grids_of(run)
    owners = [cells.names["owner"][i] for i in cells.cell_owner]
    places = {
        "stress": ("elements/one_beam", "stress"), "radial_force": ("elements/one_wheel", "radial_force"),
        "moment": ("joints/one_hinge", "moment"), "tension": ("elements/one_cable", "tension"),
        "force_along_axis": ("elements/one_spring_damper", "force"),
    }  # fmt: skip
    for name, (owner, output) in places.items():
        field = cells.cell_data[name]
        assert np.array_equal(field.values[:, owners.index(owner)], run.results[f"{owner}/{output}"].values)
        without = [i for i, one in enumerate(owners) if f"{one}/{output}" not in run.paths]
        assert without and np.isnan(field.values[:, without]).all()
        assert field.unit == run.results.series[f"{owner}/{output}"].unit
    axial = cells.cell_data["axial_force"].values
    for owner, output in (("one_beam", "force.x"), ("one_cable", "tension"), ("one_spring_damper", "force")):
        assert np.array_equal(axial[:, owners.index(f"elements/{owner}")], run.results[f"{owner}.{output}"].values)


def test_a_long_file_is_taken_in_blocks_with_the_same_result(wheel, path, tmp_path, monkeypatch):
    """Blocks of two saved times, and all at once: every dataset is the same."""
    for file in (wheel, path):
        monkeypatch.setattr(grid, "NUMBERS", 2**20)
        whole = export(file, tmp_path / "whole.vtkhdf", force=True)
        [run] = open_runs([file])
        assert len(list(grid.grids_of(run))) == 1
        monkeypatch.setattr(grid, "NUMBERS", 2 * run.results.layout.size)
        assert [len(one.times) for one in grid.grids_of(run)][:-1] == [2] * ((len(run.results.time) - 1) // 2)
        parts = export(file, tmp_path / "parts.vtkhdf", force=True)
        assert len(datasets(whole)) > 30 and datasets(whole) == datasets(parts)


def datasets(path):
    """{name: shape and bytes} of all datasets of numbers."""
    found = {}

    def take(name, item):
        if isinstance(item, h5py.Dataset) and item.dtype.kind != "O":
            found[name] = item.shape, item[...].tobytes()

    with h5py.File(path) as file:
        file.visititems(take)
    return found


def test_a_line_that_begins_as_a_point_is_in_all_blocks(own, monkeypatch):
    with open_results(own) as results:
        base, tip = (1 + results.layout.slices[f"nodes/{node}/position"].start for node in ("base", "tip"))
    with h5py.File(own, "r+") as file:
        rows = file["storage/output"]
        rows[:5, tip : tip + 3] = rows[:5, base : base + 3]
    [run] = open_runs([own])
    monkeypatch.setattr(grid, "NUMBERS", 2 * run.results.layout.size)
    assert {one.cells for one in grid.grids_of(run)} == {((LINE, (0, 1)),)}


def test_the_velocity_of_a_rim_is_the_rate_of_its_position(wheel):
    """Central differences of 1 ms are off by h^2 w^3 r / 6 at w about 100 rad/s: below 0.1 m/s of 60."""
    [run] = open_runs([wheel])
    [cells] = grid.grids_of(run)
    flying = slice(0, 8)  # before the rim is flattened
    x, v = cells.points.values[flying], cells.point_data["velocity"].values[flying]
    rate = (x[2:] - x[:-2]) / (2.0 * np.diff(cells.times[:2]))
    omega = np.abs(run.results["hub.angular_velocity"].values[flying]).max()
    bound = 1e-6 * omega**3 * 0.6 / 6.0 + 1e-9
    np.testing.assert_allclose(v[1:-1], rate, rtol=0, atol=bound)


def test_cells_are_added_to_the_results_file_which_keeps_the_rest(own):
    with open_results(own) as results:
        before = {name: results[name].values for name in results.names()}
    assert export(own, vtk=True) == own
    with pytest.raises(ResultsError, match="already has a group /VTKHDF; --force"):
        export(own, vtk=True)
    export(own, vtk=True, force=True)
    with open_results(own) as results:
        assert results.status == "complete"
        assert all(np.array_equal(results[name].values, values) for name, values in before.items())
    with h5py.File(own) as file:
        assert file["VTKHDF"].attrs["Type"] == b"UnstructuredGrid" and file["VTKHDF/Steps"].attrs["NSteps"] == 41
    assert [p.name for p in own.parent.iterdir()] == ["own.h5"]


def test_a_file_with_cells_is_checked_to_the_last_byte(own):
    export(own, vtk=True)
    assert verify(own).endswith("all bytes are unchanged")
    whole = own.read_bytes()
    place = whole.rindex(b"UnstructuredGrid")
    own.write_bytes(whole[:place] + b"X" + whole[place + 1 :])
    with pytest.raises(ResultsError, match="is damaged"):
        export(own, vtk=True, force=True)


def test_nothing_is_added_to_a_file_that_is_being_written(tmp_path):
    layout = every_kind.layout({})
    writer = Writer.create(tmp_path / "open.h5", layout, Source("mecano: 1\n", every_kind.deck({})))
    writer.append(0.0, every_kind.row(layout, 0.0))
    writer.flush()
    with pytest.raises(ResultsError, match="still being written"):
        export(tmp_path / "open.h5", vtk=True)
    writer.close()


def test_the_command(own, tmp_path):
    assert mecano_process("export", own, "--vtk", "-o", tmp_path / "a.vtkhdf")[:2] == (0, f"{tmp_path / 'a.vtkhdf'}\n")
    code, _, reported = mecano_process("export", own, "--vtk", "-o", tmp_path / "a.vtkhdf")
    assert code == 5 and "--force" in reported


def test_released_joints_are_hidden(tmp_path):
    """The clamp of the deck is released at 0.3 s."""
    path = tmp_path / "r.h5"
    run(input_deck("release", "time.end=0.36"), path)
    export(path, vtk=True)
    with h5py.File(path) as file:
        group, times = file["VTKHDF"], file["time"][:]
        owners = [name.decode() for name in group["FieldData/owner"][:]]
        hidden = group["CellData/vtkGhostType"][:].reshape(len(times), -1)
        cells = dict(zip((owners[i] for i in group["CellData/owner"][:]), hidden.T, strict=True))
    assert hidden.dtype == np.uint8
    np.testing.assert_array_equal(cells["joints/clamp"], np.where(times > 0.3, 32, 0))
    assert not cells["joints/hinge"].any()

"""The results file in other programs: VTK (that is, ParaView), xarray with both of its engines, h5dump.

Each test is skipped where the other program is not installed.
"""

import shutil
import subprocess

import every_kind
import numpy as np
import pytest
from process import mecano_process, settings
from time_runs import INPUTS

from mecano.post.export import export
from mecano.results.reader import open_results


@pytest.fixture(scope="module")
def rod(tmp_path_factory):
    """A pendulum of four beams, with its cells in the results file itself."""
    file = tmp_path_factory.mktemp("readers") / "rod.h5"
    overrides = settings("time.end=0.1", "elements.rod.mesh=4")
    assert mecano_process("run", INPUTS / "flexible_pendulum.yaml", "-q", "-o", file, *overrides)[0] == 0
    return export(file, vtk=True)


@pytest.fixture(scope="module")
def each(tmp_path_factory):
    """One of each kind."""
    return export(every_kind.write(tmp_path_factory.mktemp("readers") / "each.h5"), vtk=True)


class Vtk:
    """A file as the reader of VTK has it."""

    def __init__(self, path):
        vtk = pytest.importorskip("vtk")
        self._key = vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS()
        self._numpy = pytest.importorskip("vtkmodules.util.numpy_support").vtk_to_numpy
        self._reader = vtk.vtkHDFReader()
        self._reader.SetFileName(str(path))
        assert self._reader.CanReadFile(str(path))
        self._reader.UpdateInformation()
        info = self._reader.GetOutputInformation(0)
        self.times = [info.Get(self._key, i) for i in range(info.Length(self._key))]

    def at(self, i):
        """(points, point data, cell data, field data, points of each cell) at saved time number i."""
        self._reader.UpdateTimeStep(self.times[i])
        grid = self._reader.GetOutput()
        data = [
            {part.GetArrayName(k): self._numpy(part.GetArray(k)) for k in range(part.GetNumberOfArrays())}
            for part in (grid.GetPointData(), grid.GetCellData())
        ]
        fields = grid.GetFieldData()
        names = {
            name: [texts.GetValue(k) for k in range(texts.GetNumberOfValues())]
            for name in ("node", "owner")
            for texts in [fields.GetAbstractArray(name)]
        }
        cells = grid.GetCells()
        ends, ids = self._numpy(cells.GetOffsetsArray()), self._numpy(cells.GetConnectivityArray())
        return self._numpy(grid.GetPoints().GetData()), *data, names, np.split(ids, ends[1:-1])


@pytest.mark.parametrize("i", [0, 7, -1])
def test_vtk_reads_beams_at_any_time(rod, i):
    read = Vtk(rod)
    points, at_points, at_cells, names, cells = read.at(i)
    owners = [names["owner"][k] for k in at_cells["owner"]]
    with open_results(rod) as results:
        assert np.array_equal(read.times, results.time)
        for k, node in enumerate(names["node"]):
            assert np.array_equal(points[k], results[f"nodes/{node}/position"].values[i])
            assert np.array_equal(at_points["velocity"][k], results[f"nodes/{node}/velocity"].values[i])
        for number in range(1, 5):
            k = owners.index(f"elements/rod.{number}")
            assert at_cells["stress"][k] == results[f"rod.{number}.stress"].values[i]
            assert np.array_equal(at_cells["moment"][k], results[f"rod.{number}.moment"].values[i])
            assert at_cells["axial_force"][k] == results[f"rod.{number}.force.x"].values[i]
    ends = [[names["node"][k] for k in cells[owners.index(f"elements/rod.{number}")]] for number in (1, 2, 4)]
    assert ends[1] == ["rod.1", "rod.2"] and ends[0][1] == "rod.1" and ends[2] == ["rod.3", "tip"]


@pytest.mark.parametrize("i", [0, 20])
def test_vtk_reads_wheels_and_joints(each, i):
    points, _, at_cells, names, cells = Vtk(each).at(i)
    owners = [names["owner"][k] for k in at_cells["owner"]]
    with open_results(each) as results:
        for name, owner in (("radial_force", "elements/one_wheel"), ("moment", "joints/one_hinge")):
            assert np.array_equal(at_cells[name][owners.index(owner)], results[f"{owner}/{name}"].values[i])
        hub = results["tip.position"].values[i]
    rim = points[list(cells[owners.index("elements/one_wheel")])]
    assert np.array_equal(rim[-1], hub)
    np.testing.assert_allclose(rim[0], rim[48], atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(rim[:-1] - hub, axis=1), every_kind.VALUES["radius"], rtol=1e-12)


def test_vtk_reads_a_file_of_cells_alone(rod, tmp_path):
    """The same as in the results file itself."""
    alone, within = Vtk(export(rod, tmp_path / "rod.vtkhdf")), Vtk(rod)
    for one, other in zip(alone.at(5)[:3], within.at(5)[:3], strict=True):
        np.testing.assert_equal(one, other)


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
@pytest.mark.parametrize("name", ["rod", "each"])
def test_xarray_reads_the_whole_tree(request, engine, name):
    pytest.importorskip({"netcdf4": "netCDF4"}.get(engine, engine))
    xarray, path = pytest.importorskip("xarray"), request.getfixturevalue(name)
    with xarray.open_datatree(path, engine=engine) as opened:
        tree = opened.load()
    with open_results(path) as results:
        for series in results.names("*.force") + results.names("nodes/*"):
            assert np.array_equal(tree[series].values, results[series].values)
            assert tree[series].attrs["units"] == results[series].unit and tree[series].dims[0] == "time"
        assert np.array_equal(tree["time"].values, results.time)
        position = tree["nodes/tip/position"].sel(time=results.time[3], method="nearest")
        assert np.array_equal(position.values, results["tip.position"].values[3])
        assert tree["events"].sizes["event_time"] == len(results.events)
        assert "VTKHDF" in tree


def test_h5dump_prints_everything(rod, each):
    if shutil.which("h5dump") is None:
        pytest.skip("needs h5dump")
    for path in (rod, each):
        ended = subprocess.run(["h5dump", path], capture_output=True, text=True)
        assert (ended.returncode, ended.stderr) == (0, "")
        assert 'GROUP "VTKHDF"' in ended.stdout
    of_one = subprocess.run(["h5dump", "-y", "-w", "1", "-d", "/time", rod], capture_output=True, text=True).stdout
    lines = of_one.partition("DATA {")[2].partition("}")[0].replace(",", " ").split()
    with open_results(rod) as results:
        np.testing.assert_allclose(np.array(lines, float), results.time, rtol=1e-5)

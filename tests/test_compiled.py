"""Compiled functions: how Python calls them, and how they come from the disk."""

import os
import subprocess
import sys
import textwrap
import time

import numpy as np
import pytest

from mecano.compiled import store
from mecano.compiled.entry import Indices, Matrices, Matrix, Records, Short, Table, Vector, entry
from mecano.compiled.kernel import kernel

POINT = np.dtype([("x", "f8"), ("n", "i8")])


@kernel
def twice(x):
    return 2.0 * x


@entry
def mixed(
    a: float, x: Vector, A: Matrix, n: int, B: Matrices, i: Indices, T: Table, yes: bool, s: Short, p: Records(POINT)
) -> (float, int, bool):
    """Something of every argument."""
    x[0] = A[1, 2] + B[1, 0, 1]
    p[1].x = twice(a)
    total = n + i[-1] + T[1, 0] + s[2] + p[0].n
    return a + x[1], total, not yes


@entry
def one(x: Vector) -> float:
    """The length of an array."""
    return float(x.shape[0])


@entry
def half(n: int) -> int:
    """A whole number."""
    return n // 2


@entry
def positive(x: float) -> bool:
    """A condition."""
    return x > 0.0


@entry
def over(x: float) -> float:
    """What C has for a division by zero."""
    return 1.0 / x


@entry
def allocates(n: int) -> float:
    """What no compiled function may do."""
    return np.zeros(n).sum()


@pytest.fixture(scope="module", autouse=True)
def own_store(tmp_path_factory):
    """A store of its own: the code of this file does not belong to that of mecano."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(store.FOLDER, str(tmp_path_factory.mktemp("store")))
        store.folder.cache_clear()
        yield store.folder()
    store.folder.cache_clear()


def arguments():
    B = np.arange(18.0).reshape(2, 3, 3)
    p = np.zeros(2, POINT)
    p["n"] = 1000, 0
    return [
        0.5, np.array([1.0, 2.0]), np.arange(6.0).reshape(2, 3), 3, B, np.array([1, 20]), np.array([[1], [300]]), False,
        np.array([0, 0, 4000], np.uint32), p,
    ]  # fmt: skip


class TestEntry:
    def test_arguments_and_results_of_every_type(self):
        given = arguments()
        assert mixed(*given) == (2.5, 5323, True)
        assert given[1][0] == 5.0 + 10.0 and given[-1]["x"][1] == 1.0
        assert one(np.zeros(0)) == 0.0 and half(7) == 3 and positive(1.0) is True and positive(-1.0) is False

    @pytest.mark.parametrize(
        ("place", "value"),
        [
            (1, np.zeros((2, 2))),
            (1, np.zeros(4)[::2]),
            (1, np.zeros(2, np.float32)),
            (1, [1.0, 2.0]),
            (2, np.zeros((3, 2)).T),
            (4, np.zeros((2, 3))),
            (5, np.zeros(2)),
            (6, np.zeros((2, 1))),
            (8, np.zeros(3, np.int64)),
            (9, np.zeros(2)),
        ],
    )
    def test_an_array_of_another_type_dimension_or_order_is_refused(self, place, value):
        given = arguments()
        given[place] = value
        name = mixed.names[place]
        with pytest.raises(TypeError, match=rf"^mixed: {name} must be a contiguous array of [^;]*$"):
            mixed(*given)

    def test_divisions_are_those_of_c(self):
        assert over(0.0) == np.inf and over(4.0) == 0.25

    def test_memory_cannot_be_allocated(self):
        with pytest.raises(SystemError, match="NRT_MemInfo_alloc.*may not allocate"):
            allocates(3)


SCRIPT = """
    import sys
    import numpy as np
    from mecano.maths.so3 import exp
    from mecano.solve.increments import place_rotations

    z, R, out = np.array([0.3, -0.2, 0.7]), np.eye(3)[None], np.zeros((1, 3, 3))
    place_rotations(np.array([0]), 3, z, R, out)
    np.testing.assert_allclose(out[0], np.array(exp(tuple(z))), rtol=0, atol=1e-15)
    print("numba" in sys.modules, out.tobytes().hex())
"""


def run_script(folder):
    environment = {**os.environ, store.FOLDER: str(folder)}
    command = [sys.executable, "-c", textwrap.dedent(SCRIPT)]
    found = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return found.stdout.split()


class TestStore:
    def test_the_second_process_needs_no_compiler_and_gets_the_same_bits(self, tmp_path):
        compiled, first = run_script(tmp_path)
        loaded, second = run_script(tmp_path)
        assert (compiled, loaded) == ("True", "False") and first == second
        (path,) = tmp_path.rglob("*.o")
        assert path.name == "mecano.solve.increments.place_rotations.o"
        path.write_bytes(path.read_bytes()[:-100])
        again, third = run_script(tmp_path)
        assert (again, third) == ("True", first)

    def test_a_folder_that_cannot_be_written_costs_nothing_but_time(self, tmp_path, monkeypatch):
        (tmp_path / "file").write_text("")
        monkeypatch.setenv(store.FOLDER, str(tmp_path / "file"))
        assert store.folder.__wrapped__().name.startswith("mecano-")

    def test_folders_that_nobody_has_used_for_long_are_removed_when_one_is_made(self, tmp_path, monkeypatch):
        monkeypatch.setenv(store.FOLDER, str(tmp_path))
        names = [f"mecano-{16 * letter}" for letter in "ab"] + ["mecano-studies"]
        for name in names:
            (tmp_path / name).mkdir()
        for name in (names[0], names[2]):
            os.utime(tmp_path / name, times=(0.0, time.time() - 1.01 * store.UNUSED))
        found = store.folder.__wrapped__()
        assert {path.name for path in tmp_path.iterdir()} == {*names[1:], found.name}

    def test_other_processors_have_other_folders(self, monkeypatch):
        here = store.folder.__wrapped__()
        monkeypatch.setattr(store.llvm, "get_host_cpu_name", lambda: "another")
        assert store.folder.__wrapped__() != here

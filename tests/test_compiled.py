"""Compiled functions: calls from Python, and loading from the disk."""

import math
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import textwrap
import threading
import time
import types
from collections import namedtuple
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from llvmlite.binding import get_host_cpu_name

from mecano.errors import CompilationError, ResultsError
from mecano.jit import compiler, image, machine_code, processor, shipped, store, trust
from mecano.jit.digest import digest, is_digested
from mecano.jit.entry import Indices, Matrices, Matrix, Records, Short, Table, Vector, entry
from mecano.jit.kernel import kernel
from mecano.solve.time.increments import largest

Spec = namedtuple("Spec", "origin")
SYMBOLS = 2  # a section of symbols
HIDDEN = 2
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


class Inner(NamedTuple):
    x: Vector
    n: int


class Outer(NamedTuple):
    scale: float
    inner: Inner


@entry
def grouped(a: float, given: Outer, found_out: Inner) -> float:
    """Named tuples, one within another."""
    found_out.x[0] = given.scale * given.inner.x[0]
    return a + given.inner.n + found_out.n


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
    """Allocate, which no compiled function may do."""
    return np.zeros(n).sum()


@entry
def scaled(n: int) -> float:
    """Call a function that numba takes from its own library."""
    return math.ldexp(1.0, n)


@entry
def counted(p: Records(POINT)) -> int:
    """How many records there are."""
    return p.shape[0]


@entry
def fill(x_out: Vector, value: float):
    """Write an array."""
    x_out[:] = value


@pytest.fixture(scope="module", autouse=True)
def own_store(tmp_path_factory):
    """A separate store, so that the code of this file is kept apart from that of mecano."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(store.FOLDER, str(tmp_path_factory.mktemp("store")))
        patch.setenv("XDG_CONFIG_HOME", str(tmp_path_factory.mktemp("secret")))
        for known in (store.folder, store._secret):
            known.cache_clear()
        yield store.folder()
    for known in (store.folder, store._secret):
        known.cache_clear()


def refuse(*_, **__):
    raise PermissionError


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

    @pytest.mark.parametrize("n", range(11))
    def test_arguments_that_are_packed_once_count_as_if_they_were_given(self, n):
        given = arguments()
        bound = mixed.bind(*given[:n])
        assert bound(*given[n:]) == (2.5, 5323, True) == bound(*given[n:])
        given[5][1] = 21
        assert bound(*given[n:]) == (2.5, 5324, True)

    @pytest.mark.parametrize("n", [1, 5])
    def test_an_array_of_another_type_is_refused_bound_or_given(self, n):
        given = arguments()
        given[4] = np.zeros((2, 3))
        with pytest.raises(TypeError, match=r"^mixed: B must be a contiguous array of [^;]*$"):
            mixed.bind(*given[:n])(*given[n:])

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
            (1, np.zeros(2, ">f8")),
            (1, None),
            (1, 2.0),
            (1, np.zeros(2).view(np.recarray)),
            (1, np.frombuffer(bytes(17), np.float64, 2, offset=1)),
            (9, np.zeros(2, [("n", "i8")])),
        ],
    )
    def test_an_array_of_another_type_dimension_or_order_is_refused(self, place, value):
        given = arguments()
        given[place] = value
        name = mixed.names[place]
        with pytest.raises(TypeError, match=rf"^mixed: {name} must be a contiguous array of [^;]*$"):
            mixed(*given)

    @pytest.mark.parametrize("n", range(4))
    def test_named_tuples_are_taken_from_any_object_with_their_fields(self, n):
        """0.5 + 3 + 40, and 2 times 7 in the array that is written."""
        inner, found = types.SimpleNamespace(x=np.array([7.0]), n=3), Inner(np.zeros(1), 40)
        given = 0.5, types.SimpleNamespace(scale=2.0, inner=inner, more="not read"), found
        assert grouped.bind(*given[:n])(*given[n:]) == 43.5 and found.x[0] == 14.0

    def test_an_array_of_a_named_tuple_is_refused_by_its_path(self):
        good, fixed = Inner(np.zeros(1), 1), Inner(np.frombuffer(bytes(8)), 1)
        for given, name in (
            ((Outer(1.0, Inner(np.zeros((1, 1)), 1)), good), "given.inner.x"),
            ((Outer(1.0, good), fixed), "found_out.x"),
            ((Outer(1.0, good._replace(n=1.5)), good), "given.inner.n"),
        ):
            with pytest.raises(TypeError, match=rf"^grouped: {name} must be [^;]*$"):
                grouped(1.0, *given)
        assert grouped(1.0, Outer(1.0, fixed), good) == 3.0  # what is not written need not be writable

    def test_arrays_may_be_empty(self):
        some = np.zeros(3, POINT)
        assert counted(some[np.zeros(3, bool)]) == 0 and counted(some[:0]) == 0 and counted(some[1:2]) == 1

    def test_numbers_that_are_none_are_refused_and_arrays_to_be_written_that_cannot_be(self):
        for call, text in (
            (lambda: half(3.0), "half: n must be a whole number"),
            (lambda: over("3"), "over: x must be a number"),
            (lambda: fill(np.frombuffer(bytes(16)), 1.0), "fill: x_out must be .* that can be written"),
        ):
            with pytest.raises(TypeError, match=f"^{text}$"):
                call()
        given = arguments()
        given[7] = np.False_
        assert mixed(*given)[2] is True

    def test_divisions_are_those_of_c(self):
        assert over(0.0) == np.inf and over(4.0) == 0.25

    def test_memory_cannot_be_allocated(self):
        with pytest.raises(
            CompilationError, match="allocates' cannot be compiled: it needs NRT_MemInfo_alloc.*may not allocate"
        ):
            allocates(3)

    def test_functions_of_numba_are_not_there(self):
        with pytest.raises(CompilationError, match="needs numba_ldexp: .* call libraries"):
            scaled(3)

    def test_an_error_that_no_compiled_function_should_have_ends_the_program_with_a_word(self, tmp_path):
        found = run_script(FAILING, tmp_path, check=False)
        assert found.returncode < 0 and "an error in compiled code of mecano" in found.stderr


SCRIPT = """
    import sys
    import numpy as np
    from mecano.solve.time.increments import largest

    found = largest(np.array([0.3, -0.7, 0.2]), np.zeros(3, np.int64), 3, 0.3)
    assert found == 0.7 / 0.3
    print(bool(sys.modules.get("numba")), found.hex())
"""  # one that takes little time to compile
WITHOUT_NUMBA = "import sys\nsys.modules['numba'] = None\n"  # as if it were not installed


FAILING = """
    import mecano.jit.entry as of

    def refuse(n: int):
        assert n < 0

    of.entry(refuse)(1)
"""


def run_script(script, folder, check=True, **variables):
    environment = {**os.environ, store.FOLDER: str(folder), **variables}
    command = [sys.executable, "-c", textwrap.dedent(script)]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=check)


@pytest.fixture(scope="module")
def filled(own_store, tmp_path_factory):
    """A folder with the function compiled by a process, and what that process has printed."""
    folder = tmp_path_factory.mktemp("filled")
    return folder, run_script(SCRIPT, folder).stdout.split()


@pytest.fixture
def copied(filled, tmp_path):
    """A copy of the folder, and the result that the process has printed."""
    return shutil.copytree(filled[0], tmp_path / "copied"), filled[1][1]


class TestStore:
    def test_the_second_process_needs_no_compiler_and_gets_the_same_bits(self, filled, copied):
        (compiled, _), (folder, first) = filled[1], copied
        loaded, second = run_script(SCRIPT, folder).stdout.split()
        assert (compiled, loaded) == ("True", "False") and first == second
        (path,) = folder.rglob("*.o")
        assert re.fullmatch(r"mecano\.solve\.time\.increments\.largest-[0-9a-f]{32}\.o", path.name)
        for damage in (lambda data: data[:-100], lambda data: b"name check\n" + data):
            path.write_bytes(damage(path.read_bytes()))
            again, third = run_script(SCRIPT, folder).stdout.split()
            assert (again, third) == ("True", first)
            assert list(path.parent.iterdir()) == [path]

    @pytest.mark.skipif(not image.POSSIBLE, reason="all code is loaded by LLVM")
    def test_where_images_are_not_possible_llvm_loads_the_same_code(self, filled, tmp_path):
        script = "from mecano.jit import image\nimage.POSSIBLE = False\n" + textwrap.dedent(SCRIPT)
        for compiled in "True", "False":
            assert run_script(script, tmp_path).stdout.split() == [compiled, filled[1][1]]
        (path,) = tmp_path.rglob("*.o")
        assert b"\x7fELF" in path.read_bytes()

    @pytest.mark.skipif(not image.POSSIBLE, reason="all code is loaded by LLVM")
    def test_an_image_is_not_made_of_unknown_relocations(self, monkeypatch):
        symbol, code = compiler.entry_code(largest)
        assert image.linked(symbol, code).startswith(b"0 ")
        monkeypatch.setattr(image, "RELATIVE", ())
        assert image.linked(symbol, code) is None

    @pytest.mark.skipif(not image.POSSIBLE, reason="all code is loaded by LLVM")
    def test_llvm_loads_what_has_unknown_relocations(self, filled, tmp_path):
        script = "from mecano.jit import image\nimage.RELATIVE = ()\n" + textwrap.dedent(SCRIPT)
        assert run_script(script, tmp_path).stdout.split() == ["True", filled[1][1]]
        assert run_script(SCRIPT, tmp_path).stdout.split() == ["False", filled[1][1]]

    def test_where_linux_does_not_describe_the_processor_llvm_does(self, monkeypatch):
        monkeypatch.setattr(processor, "description", dict)
        monkeypatch.delenv("NUMBA_CPU_NAME", raising=False)
        assert get_host_cpu_name() in processor.key()

    def test_code_that_the_user_has_not_signed_is_not_loaded(self, copied):
        """Another user can compute any hash without the secret; the object is compiled again."""
        folder, first = copied
        (path,) = folder.rglob("*.o")
        _, data = path.read_bytes().split(b"\n", 1)
        path.write_bytes(trust.sign(bytes(32), path.name, data).encode() + b"\n" + data)
        assert run_script(SCRIPT, folder).stdout.split() == ["True", first]
        path.rename(path.with_name(path.name.replace("-", "-0", 1)))
        assert run_script(SCRIPT, folder).stdout.split() == ["True", first]

    def test_an_installation_with_machine_code_needs_no_compiler(self, tmp_path):
        """On a processor of its level, of the user who installed it, and as long as nobody else can write there."""
        if not {*shipped.LEVELS["x86-64-v2"].split()} <= {*processor.description().get("flags", "").split()}:
            pytest.skip("not a processor of this level")
        head = f"from mecano.jit import shipped, store\nshipped.OBJECTS = store.Path({str(tmp_path / 'objects')!r})\n"
        script, level = head + textwrap.dedent(SCRIPT), {"NUMBA_CPU_NAME": "x86-64-v2", "NUMBA_CPU_FEATURES": ""}
        first = run_script(script, tmp_path / "a", **level).stdout.split()[1]
        ship = f"{head}print(*store.ship('x86-64-v2'))"
        folder = run_script(ship, tmp_path / "a", **level).stdout.split()[0]
        assert "this process compiles for" in run_script(ship, tmp_path / "a", check=False).stderr
        assert run_script(WITHOUT_NUMBA + script, tmp_path / "b").stdout.split() == ["False", first]
        assert not list((tmp_path / "b").rglob("*.o"))
        Path(folder).chmod(0o777)
        assert run_script(script, tmp_path / "c").stdout.split()[0] == "True"
        assert "is missing: pip install numba" in run_script(WITHOUT_NUMBA + script, tmp_path / "d", check=False).stderr

    def test_folders_are_private_and_those_of_others_are_refused(self, tmp_path, monkeypatch):
        monkeypatch.setenv(store.FOLDER, str(tmp_path / "new" / "base"))
        found = store.folder.__wrapped__()
        assert found.stat().st_mode & 0o777 == 0o700
        found.chmod(0o770)
        with pytest.raises(ResultsError, match=f"{found} can be written by other users: .* MECANO_CACHE_DIR"):
            store.folder.__wrapped__()
        found.chmod(0o700)
        monkeypatch.setattr(os, "getuid", lambda: 4711)
        with pytest.raises(ResultsError, match=r"belongs to another user \(uid \d+\): it is not used"):
            store.folder.__wrapped__()
        monkeypatch.undo()
        monkeypatch.setenv(store.FOLDER, str(tmp_path / "other"))
        link = tmp_path / "other" / found.name
        link.parent.mkdir()
        link.symlink_to(found)
        with pytest.raises(ResultsError, match="is a symbolic link"):
            store.folder.__wrapped__()

    def test_a_shared_store_is_read_where_only_trusted_users_can_write(self, copied, tmp_path, monkeypatch):
        """Without a compiler; objects that others could have written are not used."""
        shared, own, (admin, first) = tmp_path / "shared", tmp_path / "own", copied
        run_script(f"from mecano.jit import store; store.share({str(shared)!r})", admin)
        monkeypatch.setenv(store.SHARED, str(shared))
        assert run_script(SCRIPT, own).stdout.split() == ["False", first]
        (path,) = shared.rglob("*.o")
        assert path.stat().st_mode & 0o777 == 0o644 and not list(own.rglob("*.o"))
        path.chmod(0o666)
        assert run_script(SCRIPT, own).stdout.split() == ["True", first]
        path.parent.chmod(0o777)
        found = run_script(SCRIPT, own, check=False)
        assert found.returncode and "can be written by other users" in found.stderr

    def test_a_secret_that_others_can_read_is_replaced(self, tmp_path, monkeypatch):
        monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
        first = trust.secret()
        assert trust.secret() == first and len(first) == 32
        (tmp_path / "mecano" / "store.key").chmod(0o644)
        assert trust.secret() != first and trust.secret() == trust.secret()
        (tmp_path / "file").write_text("")
        monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "file"))
        assert trust.secret() != trust.secret()

    def test_a_secret_that_another_process_creates_at_the_same_time_is_used(self, tmp_path, monkeypatch):
        """It is there after this process has found none and before it makes one of its own."""
        monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
        read, others = trust._read, []

        def late(path):
            found = read(path)
            if not others:
                others.append(b"")
                others[0] = trust._create(path)
            return found

        monkeypatch.setattr(trust, "_read", late)
        assert trust.secret() == others[0] == trust.secret()

    def test_files_that_another_process_removes_do_not_count(self, tmp_path, monkeypatch):
        """A lock is listed with the other files, and gone when its size is read."""
        monkeypatch.setattr(store, "folder", lambda: tmp_path)
        for name in ("a.o", "b.o", "a.o.lock"):
            (tmp_path / name).write_bytes(b"1234")
        is_file = Path.is_file

        def late(path):
            found = is_file(path)
            if path.suffix == ".lock":
                path.unlink()
            return found

        monkeypatch.setattr(Path, "is_file", late)
        assert store.size() == 8

    def test_compiling_is_announced_once_and_only_where_something_is_compiled(self, tmp_path):
        script = "from mecano.jit.machine_code import while_compiling\n"
        script += "with while_compiling(lambda done, n: print('compiling')):\n"
        script += textwrap.indent(textwrap.dedent(SCRIPT), "    ")
        assert run_script(script, tmp_path).stdout.split()[0] == "compiling"
        assert "compiling" not in run_script(script, tmp_path).stdout

    def test_where_no_folder_can_be_made_one_lives_as_long_as_the_process(self, tmp_path):
        (tmp_path / "file").write_text("")
        script = "from mecano.jit import store; print(store.folder(), store.folder().is_dir())"
        path, is_there = run_script(script, tmp_path / "file").stdout.split()
        assert Path(path).parent == Path(tempfile.gettempdir()) and is_there == "True" and not Path(path).exists()

    def test_a_folder_that_is_there_is_used_though_nothing_can_be_written_there(self, tmp_path, monkeypatch):
        monkeypatch.setenv(store.FOLDER, str(tmp_path))
        found = store.folder.__wrapped__()
        monkeypatch.setattr(os, "utime", refuse)
        monkeypatch.setattr(Path, "mkdir", refuse)
        assert store.folder.__wrapped__() == found and found.parent == tmp_path

    def test_codes_are_loaded_as_one_library_and_only_once(self, monkeypatch):
        codes, addresses = [half.code, one.code], {}
        for code in codes:
            machine_code.compile_code(code)
        monkeypatch.setattr(machine_code, "_addresses", addresses)
        libraries = len(machine_code._kept)
        for _ in range(2):
            machine_code.load(codes)
            assert len(machine_code._kept) == libraries + 1
        assert set(addresses) == {code.file for code in codes} and len(set(addresses.values())) == 2

    def test_an_object_that_cannot_be_stored_leaves_no_file(self, tmp_path, monkeypatch):
        monkeypatch.setattr(Path, "replace", refuse)
        store.write_atomically(tmp_path / "a.o", b"code")
        assert not list(tmp_path.iterdir())

    def test_folders_that_nobody_has_used_for_long_are_removed_when_one_is_made(self, tmp_path, monkeypatch):
        monkeypatch.setenv(store.FOLDER, str(tmp_path))
        names = [f"mecano-{16 * letter}" for letter in "ab"] + ["mecano-studies"]
        for name in names:
            (tmp_path / name).mkdir()
        for name in (names[0], names[2]):
            os.utime(tmp_path / name, times=(0.0, time.time() - 1.01 * store.UNUSED))
        found = store.folder.__wrapped__()
        assert {path.name for path in tmp_path.iterdir()} == {*names[1:], found.name}

    @pytest.mark.parametrize(
        ("of", "name", "value"),
        [
            (processor, "description", lambda: {"model": "another"}),
            (processor.platform, "machine", lambda: "another"),
            (store.llvmlite, "__version__", "0.0"),
            (sys, "abiflags", "t"),
            (store, "COMPILER", ("compiler",)),
            (store, "find_spec", None),
        ],
    )
    def test_the_folder_depends_on_compiler_and_machine(self, monkeypatch, tmp_path, of, name, value):
        (tmp_path / "_version.py").write_text("")
        key = store._key.__wrapped__
        here = key()
        monkeypatch.setattr(of, name, value if name != "find_spec" else lambda _: Spec(str(tmp_path / "__init__.py")))
        assert key() != here


class TestDigest:
    """Objects are compiled again if, and only if, their sources have changed."""

    HEAD = """
        from mecano.jit.kernel import kernel
        FACTOR = 2.0

        @kernel
        def inner(x):
            return FACTOR * x

        def outer(x):
            \"\"\"The doubled square.\"\"\"
            return inner(x) * x  # here
    """

    def digest(self, text):
        names = {"__name__": "mecano.made_up"}
        exec(compile(textwrap.dedent(text), "made up", "exec"), names)
        return digest(names["outer"])

    @pytest.mark.parametrize(
        ("old", "new"),
        [
            ("FACTOR = 2.0", "FACTOR = 3.0"),
            ("FACTOR * x", "FACTOR + x"),
            ("(x) * x", "(x) - x"),
            ("@kernel", "@inlined"),
        ],
    )
    def test_code_and_constants_of_all_functions_called_count(self, old, new):
        head = self.HEAD.replace("import kernel", "import inlined, kernel")
        assert old in head and self.digest(head) != self.digest(head.replace(old, new))

    @pytest.mark.parametrize(
        ("old", "new"),
        [("The doubled square.", "Twice x squared."), ("# here", ""), ("FACTOR = 2.0", "\n        FACTOR = 2.0")],
    )
    def test_docstrings_comments_and_places_do_not(self, old, new):
        assert old in self.HEAD and self.digest(self.HEAD) == self.digest(self.HEAD.replace(old, new))

    def test_the_fields_of_named_tuples_count(self):
        def take(given):
            return given

        digests = []
        for kind in (float, int):
            take = types.FunctionType(take.__code__, take.__globals__)
            take.__annotations__ = {"given": NamedTuple("Given", [("x", kind)])}
            digests.append(digest(take))
        assert len(set(digests)) == 2

    def test_values_of_unknown_influence_are_refused_each_time(self):
        def outer(x):
            return values

        values = {2.0}
        for _ in range(2):
            with pytest.raises(TypeError, match="uses a global set"):
                digest(outer)
        assert not is_digested(outer)

    def test_two_threads_find_the_same_digest_at_the_same_time(self, monkeypatch):
        module, found = sys.modules["mecano.jit.digest"], []
        describe = module._describe_function

        def meanwhile(function):
            if threading.current_thread() is threading.main_thread():
                other = threading.Thread(target=lambda: found.append(digest(function)))
                other.start()
                other.join()
            return describe(function)

        monkeypatch.setattr(module, "_describe_function", meanwhile)
        assert self.digest(self.HEAD) in found and "recursive" not in found

    def test_two_kinds_have_loops_of_their_own(self):
        from mecano.elements import KINDS

        kernels = [(KINDS[name].force or KINDS[name].residual) for name in ("point_mass", "rigid_body", "beam")]
        assert len({digest(one.__wrapped__) for one in kernels}) == 3


def _symbols(code):
    """Name and visibility of the symbols of an ELF object of 64 bits (ELF-64 Object File Format 1.5, 1998)."""
    sections, size, count = (*struct.unpack_from("<Q", code, 40), *struct.unpack_from("<HH", code, 58))
    heads = [struct.unpack_from("<IIQQQQIIQQ", code, sections + i * size) for i in range(count)]
    (start, length, link) = next((head[4], head[5], head[6]) for head in heads if head[1] == SYMBOLS)
    for name, _, other, _, _, _ in struct.iter_unpack("<IBBHQQ", code[start : start + length]):
        at = heads[link][4] + name
        yield code[at : code.index(b"\0", at)].decode(), other & 3


@pytest.mark.skipif(sys.platform != "linux", reason="objects have another form")
def test_code_needs_no_table_of_addresses():
    """On 64-bit Arm the loader may put one farther away than code reaches: it then ended the process."""
    symbols = dict(_symbols(compiler.entry_code(mixed)[1]))
    assert "Py_FatalError" in symbols
    assert {seen for name, seen in symbols.items() if name.startswith("PyExc_")} <= {HIDDEN}  # old numba has none

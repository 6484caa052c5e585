"""The command line: exit codes, messages, files left, interruptions."""

import os
import re
import resource
import signal
import subprocess
import sys
import time
from textwrap import dedent

import pytest
from click.testing import CliRunner
from process import COMMAND, processor_time
from test_deck_physics import MOTOR, problems
from time_runs import INPUTS

import mecano
from mecano.cli import commands, main
from mecano.deck.catalogue import explain
from mecano.deck.expanded_sections import EXPANDED_SECTIONS, REPEAT
from mecano.deck.sections import SECTIONS
from mecano.elements import KINDS, MODULES
from mecano.elements.members.cross_section import SHAPES
from mecano.elements.wheels.slip_laws import SLIP_LAWS
from mecano.errors import UsageError
from mecano.laws import TERMS
from mecano.process.interrupt import EXIT_CODES

DECK = """\
mecano: 1
title: Bar on a hinge
gravity: [0, 0, -9.81]
nodes:
  pin: {position: [0, 0, 0]}
elements:
  bar: {type: rigid_body, node: pin, mass: 1.0, center_of_mass: [0.5, 0, 0], inertia: [1.0e-4, 0.0833, 0.0833]}
joints:
  hinge: {type: hinge, nodes: [ground, pin], axis: [0, 1, 0]}
time: {end: 0.1, step: 1.0e-3}
output: {every: 0.01}
"""
NEVER_ENDING = ("--set", "time.end=1e5", "--set", "output.every=0.002")
TRIES = 8  # of a limit on the processor time, which other processes lengthen
LIBRARIES = ("numpy", "h5py", "yaml", "click")
HEAVY = ("numpy", "scipy", "llvmlite", "numba", "h5py", "matplotlib", "yaml")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty current folder with a deck in it."""
    (tmp_path / "deck.yaml").write_text(DECK)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def call(monkeypatch, capsys):
    """Function that calls the command line in this process: arguments -> (exit code, output, errors)."""
    handlers = {number: signal.getsignal(number) for number in EXIT_CODES}
    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["mecano", *map(str, arguments)])
        try:
            main()
            code = 0
        except SystemExit as ended:
            code = ended.code
        return code, *capsys.readouterr()

    yield run
    for number, handler in handlers.items():
        signal.signal(number, handler)
    signal.setitimer(signal.ITIMER_REAL, 0.0)


def started(folder, *arguments, **options):
    """A process of its own that runs the deck in the folder."""
    return subprocess.Popen([*COMMAND, "run", "deck.yaml", *arguments], cwd=folder, stderr=subprocess.PIPE, **options)


def loaded_by(*words):
    """Return the names of the modules that a command has loaded at its end."""
    return modules_of("import mecano.cli; mecano.cli.commands(standalone_mode=False)", *words)


def modules_of(code, *words):
    """Return the names of the modules that a program has loaded at its end."""
    command = [sys.executable, "-c", f"import sys; {code}; print(*sys.modules)", *words]
    return set(subprocess.run(command, capture_output=True, text=True, check=True).stdout.split())


class TestHelp:
    def test_it_comes_at_once(self):
        code = f"import sys, mecano.cli; print([name for name in {HEAVY!r} if name in sys.modules])"
        loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        assert loaded.stdout.strip() == "[]"
        assert any(processor_time("--help") < 0.3 for _ in range(TRIES))

    def test_every_command_has_one(self, call):
        code, out, _ = call("--help")
        assert code == 0 and all(f"\n  {name} " in out for name in ("run", "check", "post", "info", "list", "explain"))
        for name in ("run", "check", "post", "info", "list", "explain"):
            code, out, _ = call(name, "--help")
            assert code == 0 and out.startswith(f"Usage: mecano {name}")

    def test_version(self, call):
        assert call("--version") == (0, f"mecano, version {mecano.__version__}\n", "")


@pytest.mark.parametrize(
    "arguments",
    [
        ("runn",),
        ("run",),
        ("run", "deck.yaml", "--speed"),
        ("post",),
        ("post", "a.h5", "--format", "bmp"),
        ("reduce", "deck.yaml", "--nodes", "a", "--modes", "²"),
    ],
)
def test_usage_errors(call, arguments):
    code, out, err = call(*arguments)
    assert (code, out) == (2, "") and "Error:" in err and "Traceback" not in err


class TestDeckErrors:
    def test_all_are_shown_with_their_places(self, call, folder):
        broken = DECK.replace("mass: 1.0", "mass: -1.0").replace("axis:", "axes:")
        (folder / "deck.yaml").write_text(broken)
        for command in ("run", "check"):
            code, out, err = call(command, "deck.yaml")
            assert (code, out) == (2, "") and "\n2 errors; consistency is checked once" in err
            lines = err.splitlines()
            assert lines[0].startswith(
                "deck.yaml:7:44: rigid_body 'bar': 'mass' must be greater than zero [kg], got -1.0"
            )
            assert lines[1][lines[2].index("^") :].startswith("-1.0,")
            assert any(
                line.startswith("deck.yaml:9:46: hinge 'hinge': unknown key 'axes'; did you mean 'axis'?")
                for line in lines
            )
        assert not (folder / "deck.h5").exists()

    def test_a_deck_that_is_not_there(self, call, folder):
        code, _, err = call("run", "other.yaml")
        assert code == 2 and "other.yaml:1:1: the deck cannot be read" in err and "No such file" in err
        assert "did you mean" not in err and "did you mean 'deck.yaml'?" in call("run", "dekc.yml")[2]

    def test_overrides(self, call, folder):
        code, _, err = call("run", "deck.yaml", "--set", "time.stop=1")
        assert code == 2 and "time.stop" in err


class TestRun:
    def test_a_run_leaves_a_complete_file(self, call, folder):
        code, out, err = call("run", "deck.yaml", "--set", "time.end=0.05")
        assert (code, out) == (0, "") and "50 steps, 0 rejected" in err and "results in deck.h5" in err
        with mecano.open_results("deck.h5") as results:
            assert results.status == "complete" and len(results.time) == 6
            assert results.metadata["overrides"] == ["time.end=0.05"]

    def test_a_warm_one_takes_little_time(self, folder):
        deck = INPUTS / "pendulum.yaml"
        processor_time("run", deck, "-q", "-o", "cold.h5", cwd=folder)  # compiles, if need be
        times = []
        for i in range(TRIES):
            libraries = processor_time("-c", f"import {', '.join(LIBRARIES)}", command=[sys.executable])
            times.append((processor_time("run", deck, "-q", "-o", f"{i}.h5", cwd=folder), libraries))
            if times[-1][0] < max(1.5, 2.2 * libraries):  # the latter on a busy machine: there all takes longer
                break
        else:
            raise AssertionError(times)

    @pytest.mark.parametrize("words", [("run", "deck.yaml", "-q"), ("check", "deck.yaml")])
    def test_a_warm_one_imports_neither_compiler_nor_scipy_nor_other_kinds(self, call, folder, words):
        call(*words)  # compiles, if need be
        loaded = loaded_by(*words, *(("-o", "warm.h5") if words[0] == "run" else ()))
        assert "mecano.solve.time.time_integration" in loaded
        assert not {"numba", "llvmlite.binding", "scipy", "matplotlib"} & loaded
        kinds = set(MODULES.values()) & {name.removeprefix("mecano.elements.") for name in loaded}
        assert kinds == {"bodies.rigid_body", "joints.hinge", "signals.formula"}  # any deck may contain the last

    @pytest.mark.parametrize(("deck", "most"), [("pendulum", 274), ("four_bar", 275), ("two_bodies", 258)])
    def test_a_short_run_imports_few_modules(self, folder, deck, most):
        """Their import takes most of the processor time of a short run: at most 3 % more of mecano's than now."""
        words = "run", INPUTS / f"{deck}.yaml", "-q", "--force", "-o", "short.h5", "--set", "time.end=0.01"
        loaded = loaded_by(*words)
        loaded = loaded_by(*words) if "mecano.jit.compiler" in loaded else loaded  # the first has compiled
        assert not {"scipy", "numpy.ma", "secrets"} & (loaded - modules_of("import numpy"))  # that of 1.26 has some
        assert sum(name.startswith("mecano") for name in loaded) <= most

    def test_a_short_run_compiles_few_methods_of_dataclasses(self, folder):
        """A text for each method takes 0.1 ms: those of mecano.immutable serve most classes."""
        head = "import sys; n = []; sys.addaudithook(lambda event, of: n.append(of) if event == 'compile' else None)"
        code = f"{head}; import mecano.cli; mecano.cli.commands(standalone_mode=False)"
        code += "; print(sum(b'__create_fn__' in (text or b'') for text, _ in n))"
        words = "run", INPUTS / "pendulum.yaml", "-q", "-o", "short.h5", "--set", "time.end=0.01"
        ended = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, check=True)
        assert int(ended.stdout) <= 20

    def test_scipy_is_not_imported_for_little(self, folder):
        """Not for shocks, curved beams, steady running, signals that only measure, and control of a large model."""
        decks = "rocking_block", "woodpecker", "beam_45_degrees", "caster_shimmy", "separation", "car"
        runs = [["run", str(INPUTS / f"{deck}.yaml"), "-q", "--force", "-o", f"{deck}.h5"] for deck in decks]
        code = f"""
            import sys, mecano.cli
            needed_by = []
            for words in {runs!r}:
                mecano.cli.commands(words, standalone_mode=False)
                needed_by += [words[1]] * ("scipy" in sys.modules)
            sys.exit(needed_by[0] if needed_by else 0)
            """
        for _ in range(2):  # the first compiles, if need be, by numba, which imports SciPy
            ended = subprocess.run([sys.executable, "-c", dedent(code)], stderr=subprocess.PIPE, text=True)
            if ended.returncode == 0:
                break
        assert (ended.returncode, ended.stderr) == (0, "")

    def test_quiet(self, call, folder):
        assert call("run", "deck.yaml", "-q", "-o", "quiet.h5") == (0, "", "")
        assert (folder / "quiet.h5").exists()

    def test_results_and_modes_have_names_of_hdf5_files(self, folder):
        for call, words in ((mecano.run, "mecano export"), (mecano.modes, "prints the table of modes")):
            with pytest.raises(UsageError, match=f"results are HDF5, not '.csv': name them .h5; .*{words}"):
                call("deck.yaml", "x.csv")
        assert not (folder / "x.csv").exists()

    @pytest.mark.parametrize("file,command", [("deck.yaml", "run"), ("deck.h5", "post")])
    def test_files_in_place_of_commands_are_answered(self, file, command):
        output = CliRunner().invoke(commands, [file]).output
        assert f"No such command '{file}'. Did you mean 'mecano {command} {file}'?" in output

    @pytest.mark.parametrize(("word", "meant"), [("report", "post --report"), ("help", "--help")])
    def test_other_names_of_commands_are_answered(self, word, meant):
        output = CliRunner().invoke(commands, [word]).output
        assert f"No such command '{word}'. Did you mean 'mecano {meant}'?" in output

    def test_no_file_is_overwritten_without_force(self, call, folder):
        (folder / "deck.h5").write_text("precious")
        code, _, err = call("run", "deck.yaml")
        assert code == 5 and "deck.h5 already exists" in err and "--force" in err
        assert (folder / "deck.h5").read_text() == "precious"
        code, _, err = call("run", "deck.yaml", "--force", "-q")
        assert code == 5 and "not a results file" in err
        assert (folder / "deck.h5").read_text() == "precious"
        assert call("run", "deck.yaml", "-q", "-o", "own.h5")[0] == 0
        (folder / "own.h5").replace(folder / "deck.h5")
        assert call("run", "deck.yaml", "--force", "-q")[0] == 0
        assert mecano.open_results("deck.h5").status == "complete"

    @pytest.mark.parametrize("command", ["run", "modes"])
    def test_a_name_without_an_ending_gets_one(self, call, folder, command):
        for name in ("at_1.25", "own.results"):
            assert call(command, "deck.yaml", "-q", "-o", name)[0] == 0
        assert {path.name for path in folder.iterdir()} == {"deck.yaml", "at_1.25.h5", "own.results"}

    @pytest.mark.parametrize("name", ["deck.csv", "deck.YAML"])
    def test_results_have_no_name_of_another_format(self, call, folder, name):
        code, _, err = call("run", "deck.yaml", "-o", name)
        assert code == 2 and "name them .h5; `mecano export` writes columns" in err and not (folder / name).exists()

    def test_a_folder_that_is_not_there(self, call, folder):
        code, _, err = call("run", "deck.yaml", "-o", "nowhere/deck.h5")
        assert code == 5 and "cannot write nowhere/deck.h5: No such file or directory" in err

    def test_no_convergence(self, call, folder):
        time = (
            "time: {end: 1, step: 0.2, adaptive: {tolerance: 0.5, minimum_step: 0.2}, newton: {maximum_iterations: 1}}"
        )
        (folder / "deck.yaml").write_text(DECK.partition("time:")[0] + time)
        code, _, err = call("run", "deck.yaml")
        assert code == 3 and "no step could be taken" in err and "what to try" in err and "node pin" in err
        with mecano.open_results("deck.h5") as results:
            assert results.status == "failed" and "no step could be taken" in results.reason

    def test_positions_that_cannot_be_assembled(self, call, folder):
        away = "  away: {type: prescribed_position, node: tip, direction: [1, 0, 0], value: 5.0}\n"
        deck = DECK.replace("elements:", "  tip: {position: [1, 0, 0]}\nelements:").replace(
            "joints:\n", "joints:\n" + away
        )
        (folder / "deck.yaml").write_text(deck.replace("node: pin, mass", "node: pin, attached: [tip], mass"))
        for command in ("check", "run"):
            code, _, err = call(command, "deck.yaml")
            assert code == 4 and "away" in err
        assert not (folder / "deck.h5").exists()

    def test_forces_that_become_infinite(self, call, folder):
        value = f"{{polynomial: {{coefficients: {[0] * 60 + [1e100]}}}}}"  # infinite from 3000 s on
        pull = f"loads:\n  pull: {{type: force, node: pin, direction: [1, 0, 0], value: {value}}}\n"
        free = DECK.partition("joints:")[0] + pull + "time: {start: 5000, end: 6000, step: 10}\n"
        (folder / "deck.yaml").write_text(free)
        process = started(folder, "-q")  # numpy's warnings are no errors there
        _, err = process.communicate(timeout=150)
        assert process.returncode == 6 and b"not finite" in err and b"Traceback" not in err

    def test_out_of_memory(self, call, folder, monkeypatch):
        import mecano.analyses.dynamic

        def greedy(*arguments, **options):
            raise MemoryError

        monkeypatch.setattr(mecano.analyses.dynamic, "run", greedy)
        code, _, err = call("run", "deck.yaml", "-q")
        assert code == 7 and err.startswith("mecano: out of memory; ")

    @pytest.mark.parametrize("megabytes", [150, 200, 265, 350, 500])
    def test_a_limit_of_memory(self, folder, megabytes):
        """Exit code 7 without a traceback, whichever library cannot be loaded or start a thread first."""
        limit = megabytes * 2**20
        ended = subprocess.run(
            [*COMMAND, "run", "deck.yaml", "-q", "--force"], capture_output=True, text=True,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)),
        )  # fmt: skip
        assert ended.returncode in (0, 7) and "Traceback" not in ended.stderr
        assert megabytes > 200 or ended.stderr.startswith("mecano: out of memory; ")

    @pytest.mark.parametrize("module", ["scipy.linalg", "scipy.sparse.linalg", "scipy.optimize"])
    @pytest.mark.parametrize(("room", "expected"), [(20, "MemoryError"), (90, "MemoryError"), (300, "done")])
    def test_no_room_for_scipy(self, module, room, expected):
        """Its OpenBLAS would try for ever at 70 to 100 MB, while it is loaded."""
        code = f"""
import resource, importlib, numpy
from mecano.process.memory import guard_imports, is_lack_of_memory
size = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize() + {room} * 2**20
resource.setrlimit(resource.RLIMIT_AS, (size, size))
guard_imports()
try:
    importlib.import_module("{module}")
    print("done")
except Exception as error:
    print("MemoryError" if is_lack_of_memory(error) else repr(error))
"""
        ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
        assert (ended.returncode, ended.stdout.strip()) == (0, expected)

    @pytest.mark.parametrize("library", ["numpy.linalg", "scipy.linalg.lapack"])
    @pytest.mark.parametrize(("room", "expected"), [(20, "MemoryError"), (80, "done")])
    def test_no_room_for_the_buffer_of_blas(self, library, room, expected):
        """OpenBLAS would end the process (that of NumPy) or try for ever (that of SciPy)."""
        code = f"""
import resource, {library} as la
from mecano.process.memory import reserve_blas_buffer
size = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize() + {room} * 2**20
resource.setrlimit(resource.RLIMIT_AS, (size, size))
try:
    reserve_blas_buffer(getattr(la, "dgesv", None))
    print("done")
except MemoryError:
    print("MemoryError")
"""
        ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
        assert (ended.returncode, ended.stdout.strip()) == (0, expected)

    def test_a_bug_is_not_hidden(self, folder):
        patch = "from mecano.analyses import dynamic; dynamic.run = lambda *a, **k: 1 / 0"
        code = f"{patch}; from mecano import cli; cli.main()"
        ended = subprocess.run([sys.executable, "-c", code, "run", "deck.yaml", "-q"], capture_output=True, text=True)
        assert ended.returncode == 1
        assert ended.stderr.startswith("Traceback") and ended.stderr.endswith("ZeroDivisionError: division by zero\n")


@pytest.mark.parametrize(
    "words,message",
    [
        (("a.h5", "--animate", "a.html", "--at", "1"), "--at: only for pictures, not drawn with --animate"),
        (("a.h5", "--report", "a.html", "-o", "b", "--csv"), "--output, --csv: only for pictures"),
        (("a.h5", "--animate", "a.html", "--format", "svg"), "--format: only for pictures"),
        (("a.h5", "--animate", "a.html", "--spectrum", "x"), "--spectrum: the page of --animate has plots over time"),
        (("a.h5", "b.h5", "--report", "a.html"), "--animate and --report take one results file"),
        (("--animate", "a.h5"), "--animate takes the name of the page to write: mecano post a.h5 --animate a.html"),
        (("--report", "a.h5"), "--report takes the name of the page to write: mecano post a.h5 --report a.html"),
        ((), "Missing argument 'RESULTS...': the file that `mecano run` has written"),
        (("a.h5", "--plot", "x.angle", "y.rate"), "'y.rate' is not a file; --plot takes one text: --plot x.angle,"),
    ],
)
def test_what_post_refuses_before_it_reads(call, words, message):
    code, _, err = call("post", *words)
    assert code == 2 and message in err


@pytest.mark.parametrize(
    "words",
    [
        ("post", "a.h5", "--animate", ""), ("post", "a.h5", "--at="), ("run", "deck.yaml", "-o", ""), ("info", ""),
    ],
)  # fmt: skip
def test_an_empty_text_is_not_left_out(call, words):
    code, _, err = call(*words)
    assert code == 2 and "an empty text; leave it out, or give a value" in err


def test_an_interval_is_a_number(call):
    code, _, err = call("run", "deck.yaml", "--checkpoint", "nan")
    assert code == 2 and "'--checkpoint': it is not a number" in err


def test_equilibria_have_no_checkpoints(call, folder):
    code, _, err = call("run", "deck.yaml", "-q", "--checkpoint", "5", "--set", "static.end=1", "--set", "time=null")
    assert code == 2 and "checkpoint: this deck asks for equilibria ('static'), which have no checkpoints" in err
    assert [path.name for path in folder.iterdir()] == ["deck.yaml"]


class TestInterruptions:
    @pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
    def test_a_stopped_run_leaves_a_valid_file(self, folder, number, code):
        process = started(folder, "-q", *NEVER_ENDING)
        path, deadline = folder / "deck.h5", time.monotonic() + 150  # more than compiling takes
        while not path.exists() or not len(mecano.open_results(path).time):
            assert time.monotonic() < deadline and process.poll() is None
            time.sleep(0.05)
        process.send_signal(number)
        _, err = process.communicate(timeout=20)
        assert process.returncode == code and number.name in err.decode() and b"Traceback" not in err
        with mecano.open_results(path) as results:
            assert results.status == "stopped" and number.name in results.reason
            assert len(results.time) > 1 and results.time[-1] == pytest.approx(
                0.002 * (len(results.time) - 1), rel=1e-9
            )
        assert [p.name for p in folder.iterdir() if p.suffix == ".part"] == []

    def test_a_full_disk(self, folder, monkeypatch):
        monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")  # Python would leave incomplete files
        subprocess.run([*COMMAND, "run", "deck.yaml", "-q", "-o", "first.h5"], cwd=folder, check=True)  # compiles
        limit = 2 * (folder / "first.h5").stat().st_size

        def small_disk():
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

        process = started(folder, "-q", *NEVER_ENDING, preexec_fn=small_disk)
        _, err = process.communicate(timeout=150)
        assert process.returncode == 5 and b"Traceback" not in err
        assert b"cannot write deck.h5: File too large" in err and b"saved times up to" in err
        with mecano.open_results(folder / "deck.h5") as results:
            assert results.status == "failed" and "File too large" in results.reason and len(results.time) > 100

    def test_a_system_without_some_signals(self, folder):
        """As Windows, which has no SIGUSR1, no SIGALRM and no timer that sends it."""
        code = (
            "import signal\nfor name in ('SIGUSR1', 'SIGALRM', 'setitimer'): delattr(signal, name)\n"
            "signal.valid_signals = lambda: {signal.SIGINT, signal.SIGTERM}\n"
            "from mecano.cli import main; main()"
        )
        words = ["run", "deck.yaml", "-q", "--max-walltime"]
        assert subprocess.run([sys.executable, "-c", code, *words, "1h"]).returncode == 0
        ended = subprocess.run([sys.executable, "-c", code, *words, "1s", "--force", *NEVER_ENDING])
        assert ended.returncode == 75

    def test_a_reader_that_has_seen_enough(self, folder):
        reading, writing = os.pipe()
        os.close(reading)
        ended = subprocess.run([*COMMAND, "list"], stdout=writing, stderr=subprocess.PIPE)
        assert (ended.returncode, ended.stderr) == (0, b"")
        assert subprocess.run([*COMMAND, "run", "deck.yaml"], cwd=folder, stderr=writing).returncode == 0
        os.close(writing)
        assert mecano.open_results(folder / "deck.h5").status == "complete"


def test_arguments_that_are_no_text(call):
    """A file name of other bytes cannot be written into results files."""
    code, out, err = call("run", b"pend\xffulum.yaml".decode(errors="surrogateescape"))
    assert (code, out) == (2, "") and r"'pend\udcffulum.yaml' is not UTF-8 text" in err


def test_check_summarizes_the_model(call, folder):
    code, out, err = call("check", "deck.yaml")
    assert (code, err) == (0, "") and "Bar on a hinge" in out and "mobility         1" in out
    assert list(folder.iterdir()) == [folder / "deck.yaml"]
    assert call("check", "deck.yaml", "-q") == (0, "", "")


@pytest.mark.parametrize("members", [1, 600])
def test_check_foresees_the_memory_of_a_run(call, folder, members):
    """To a quarter: of a small model, and of one whose file has 18,000 series."""
    nodes = "".join(f"  n{i}: {{position: [{i}, 0, 0]}}\n" for i in range(members + 1))
    beams = "".join(f"  b{i}: {{type: beam, nodes: [n{i}, n{i + 1}], section: s}}\n" for i in range(members))
    section = "sections: {s: {type: circle, diameter: 0.1, E: 210 GPa, nu: 0.3, density: 7800}}\n"
    time = "time: {end: 2e-3, step: 1e-3}\n"
    (folder / "large.yaml").write_text(f"mecano: 1\ngravity: none\nnodes:\n{nodes}elements:\n{beams}{section}{time}")
    subprocess.run([*COMMAND, "warmup", "large.yaml"], check=True, capture_output=True)  # a compiler takes more
    foreseen, unit = re.search(r"memory +about (\S+) (MB|GB) in a run", call("check", "large.yaml")[1]).groups()
    assert unit == "MB" and float(foreseen) == pytest.approx(memory_of("run", "large.yaml", "-q"), rel=0.25)


def memory_of(*words):
    """Largest resident memory [MB] of the command, which must end with 0.

    A process counts as large as the one that has started it, so this one starts a small one that starts it.
    """
    code = "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True)"
    code += "; print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024)"
    return float(subprocess.run([sys.executable, "-c", code, *COMMAND, *words], check=True, capture_output=True).stdout)


class TestResults:
    @pytest.fixture
    def results(self, call, folder):
        assert call("run", "deck.yaml", "-q")[0] == 0
        return folder

    def test_pictures(self, call, results):
        code, out, err = call("post", "deck.h5", "-o", "pictures/")
        assert (code, err) == (0, "")
        names = out.splitlines()
        assert {"pictures/deck_overview.png", "pictures/deck_mechanism.png", "pictures/deck_angles.png"} <= set(names)
        assert all((results / name).stat().st_size > 5000 for name in names)

    def test_a_plot_of_named_outputs(self, call, results):
        plot = ("--plot", "hinge.angle:hinge.rate", "--csv", "--format", "svg", "--title", "Phase plane")
        code, out, _ = call("post", "deck.h5", *plot)
        assert (code, out.split()) == (0, ["deck_hinge.angle-hinge.rate.svg", "deck_hinge.angle-hinge.rate.csv"])
        assert (results / out.split()[0]).read_text().count("<svg") == 1
        assert (results / out.split()[1]).read_text().startswith("joints.hinge.rate [rad/s],joints.hinge.angle [rad]\n")

    def test_unknown_names(self, call, results):
        code, out, err = call("post", "deck.h5", "--plot", "hinge.angel")
        assert (code, out) == (2, "") and "no output 'hinge.angel'" in err and "did you mean hinge.angle" in err
        code, _, err = call("info", "deck.h5", "--names", "nothing.*")
        assert code == 2 and "matches 'nothing.*'" in err
        assert list(results.glob("*.png")) == []

    def test_info(self, call, results):
        code, out, err = call("info", "deck.h5")
        assert (code, err) == (0, "") and "100 steps" in out and "joints.hinge.angle" in out
        assert "joints.hinge.angle [rad]\n    rotation of b" in call("info", "deck.h5", "--names")[1]

    def test_info_of_an_element_or_of_an_output(self, call, results):
        """By its name alone; an output that two elements have is listed for both."""
        every, named = (call("info", "deck.h5", "--names", pattern)[1] for pattern in ("hinge.*", "hinge"))
        assert named == every and "joints.hinge.rate [rad/s]" in named
        assert "nodes.pin.velocity" in call("info", "deck.h5", "--names", "velocity")[1]
        code, _, err = call("info", "deck.h5", "--names", "hing")
        assert code == 2 and "matches 'hing'" in err

    @pytest.mark.parametrize("command", ["post", "info"])
    def test_files_that_are_not_results(self, call, folder, command):
        code, _, err = call(command, "other.h5")
        assert code == 5 and "cannot read other.h5: No such file" in err
        (folder / "other.yaml").write_text("mecano: 1")
        assert "; `mecano run other.yaml -o other.h5` writes it" in call(command, "other.h5")[2]
        code, _, err = call(command, "deck.yaml")
        assert code == 5 and "deck.yaml is not a results file" in err


class TestCatalogue:
    def test_the_list_of_commands_cuts_no_sentence(self, call):
        listed = call("--help")[1].partition("Commands:")[2].strip().splitlines()
        assert len(listed) == len(commands.commands) and all(line.endswith(".") for line in listed)
        assert not [line for line in listed if "..." in line]

    def test_list_names_everything(self, call):
        code, out, _ = call("list")
        listed = {line.split()[0] for line in out.splitlines() if line.startswith("  ") and line[2] != " "}
        assert code == 0 and listed == {
            *KINDS, *TERMS, *SHAPES, *SLIP_LAWS, *(field.name for field in (*SECTIONS, *EXPANDED_SECTIONS, REPEAT))
        }  # fmt: skip

    def test_list_names_one_group(self, call):
        code, out, _ = call("list", "laws")
        listed = {line.split()[0] for line in out.splitlines() if line.startswith("  ") and line[2] != " "}
        assert code == 0 and listed == {*TERMS, *SLIP_LAWS}
        code, _, err = call("list", "lows")
        assert code == 2 and "there is no list of 'lows'; there are lists of elements; joints; loads" in err

    @pytest.mark.parametrize("name", ["reduce", "post"])
    def test_explain_of_a_command_leads_to_its_help(self, call, name):
        code, out, err = call("explain", name)
        assert (code, out) == (2, "") and f"'{name}' is a command: `mecano {name} --help` describes it" in err

    @pytest.mark.parametrize("name", [*KINDS, *TERMS, *(section.name for section in SECTIONS)])
    def test_explain_lists_all_fields_and_outputs(self, call, name):
        code, out, _ = call("explain", name)
        assert code == 0 and name in out and ":math:" not in out and ".. math::" not in out and "\\" not in out
        if name in KINDS:
            for item in (*KINDS[name].fields, *KINDS[name].outputs):
                unit = "" if item.unit == "-" else f" [{item.unit}]"
                assert f"\n  {item.name}{unit}" in out

    @pytest.mark.parametrize(
        ("name", "event"),
        [
            ("wheel", "touch_down"),
            ("hinge", "meets upper stop"),
            ("hinge", "locks"),
            ("gear_pair", "leaves upper flank"),
        ],
    )
    def test_explain_lists_the_events_of_options_and_variants(self, name, event):
        assert f"\n  {event}: " in explain(name)

    @pytest.mark.parametrize("name", KINDS)
    def test_explain_lists_each_event_once(self, name):
        """A contact with a law and a rigid one both close; what differs is a second meaning of the event."""
        for lines in re.findall(r"^Events.*\n((?:  .*\n)+)", explain(name), re.MULTILINE):
            events = re.findall(r"^  (\S.*?):", lines, re.MULTILINE)
            assert len(set(events)) == len(events)

    @pytest.mark.parametrize("name", KINDS)
    def test_explain_lists_each_output_of_an_option_once(self, name):
        for lines in re.findall(r"^Outputs with .*\n((?:  .*\n)+)", explain(name), re.MULTILINE):
            outputs = re.findall(r"^  (\S+)", lines, re.MULTILINE)
            assert len(set(outputs)) == len(outputs)

    @pytest.mark.parametrize("name", [*KINDS, *SHAPES, *TERMS])
    def test_explain_speaks_to_users(self, name):
        """No source files, nor reasons for their code."""
        assert not re.search(r"\.py|by hand|dual number|compil", explain(name))

    def test_explain_separates_factors_by_one_blank(self):
        assert "power kλ f\u0307 is supplied" in explain("prescribed_angle")
        assert "V = 1/2 EA L ε²" in explain("bar")

    def test_explain_fields_and_words_of_fields(self, call):
        friction, of_hinge = call("explain", "friction")[1], call("explain", "hinge.friction")[1]
        assert "friction (in hinge)" in of_hinge and "collar_radius [m]" in of_hinge and of_hinge in friction
        assert "friction (in spherical)" in friction and "spherical" not in of_hinge
        assert "arc_length (in static.method)" in call("explain", "arc_length")[1]
        assert "mesh (in beam, cable)" in call("explain", "mesh")[1]
        law = call("explain", "law")[1]
        example = law[law.index("  laws:\n") : law.index("  value: rising")]
        assert problems(f"{MOTOR}{dedent(example)}".replace("value: 1.0", "value: rising")) == []
        assert "shaking: {sine: {amplitude: 2 mm, frequency: 5 Hz}}" in call("explain", "sine")[1]
        assert "with: a mapping of numbers and words" in call("explain", "place")[1]
        assert "kt" in call("explain", "units")[1] and "0..5" in call("explain", "repeat")[1]

    def test_explain_unknown_names(self, call):
        code, out, err = call("explain", "hnge")
        assert (code, out) == (2, "") and "'hnge'; did you mean 'hinge'?" in err
        assert "did you mean 'hinge.latch'?" in call("explain", "hinge.lach")[2]

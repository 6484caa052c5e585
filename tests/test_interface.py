"""`mecano.run` and the other names of `dir(mecano)`: the commands, called from Python."""

import doctest
import pickle
import re
import signal
import subprocess
import sys
import threading
from datetime import date
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import results_samples
from click.testing import CliRunner

import mecano
from mecano.analyses.dynamic import resume
from mecano.cli import commands
from mecano.deck.read import read_deck
from mecano.errors import (
    AssemblyError,
    ConvergenceError,
    DeckError,
    Failure,
    ResultsError,
    UnknownNameError,
    UsageError,
)
from mecano.interface import deck as deck_module
from mecano.interface import margins as margins_module
from mecano.interface import modes as modes_module
from mecano.interface import response as response_module
from mecano.interface import results as results_module
from mecano.interface import simulation as simulation_module
from mecano.interface import solving as solving_module
from mecano.process.interrupt import Stopped

MODULES = [
    deck_module, margins_module, modes_module, response_module, results_module, simulation_module, solving_module,
]  # fmt: skip
ROOT = Path(__file__).parent.parent
INPUTS = ROOT / "inputs"
PENDULUM = INPUTS / "pendulum.yaml"
STUDY = """
study: 1
deck: pendulum.yaml
set: {time.end: 0.1}
grid: {elements.bar.mass: [1.0, 2.0]}
outputs: {swing: {of: hinge.angle, take: max}}
"""

PUSH = """
mecano: 1
gravity: none
nodes: {a: {position: [0, 0, 0]}}
elements: {m: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}}
joints: {t: {type: prismatic, nodes: [ground, a], axis: [1, 0, 0]}}
loads: {push: {type: joint_force, joint: t, value: {step: {time: 0.5, rise: 0, from: 0, to: 1}}}}
time: {end: 1, step: 0.1}
output: {every: step}
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A working folder with the pendulum in it."""
    (tmp_path / "pendulum.yaml").write_bytes(PENDULUM.read_bytes())
    monkeypatch.chdir(tmp_path)
    return tmp_path


class TestNames:
    def test_public_names_are_documented(self):
        page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
        assert set(dir(mecano)) == {*mecano.__all__, "__version__"}
        assert all(f"`mecano.{name}" in page for name in mecano.__all__)
        assert all(getattr(mecano, name).__doc__ for name in mecano.__all__)
        with pytest.raises(AttributeError, match="no attribute 'solve_it'"):
            _ = mecano.solve_it

    def test_nothing_is_imported_before_it_is_used(self):
        code = "import sys, mecano; print([name for name in sys.modules if name.startswith('mecano')])"
        loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        assert loaded.stdout.strip() == "['mecano']"

    def test_the_classes_of_errors_are_at_hand_before_the_first_call(self):
        code = "import mecano; print(issubclass(mecano.errors.ConvergenceError, mecano.MecanoError))"
        printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        assert printed.stdout.strip() == "True"

    @pytest.mark.parametrize("module", MODULES)
    def test_examples_are_right(self, module, folder):
        tested = doctest.testmod(module, extraglobs={"mecano": mecano}, optionflags=doctest.ELLIPSIS)
        assert tested.failed == 0 and tested.attempted > 0

    def test_the_examples_of_the_page_run(self, folder):
        page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
        names = {}
        for block in re.findall("^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE):
            if not re.search("xarray|pandas", block):
                exec(block, names)


class TestErrors:
    def test_errors_are_passed_between_processes_with_their_text(self, folder):
        with pytest.raises(DeckError) as caught:
            mecano.check("pendulum.yaml", set={"elements.bar.mas": 1})
        passed = pickle.loads(pickle.dumps(caught.value))
        assert str(passed) == str(caught.value) and "did you mean 'mass'?" in str(passed)
        assert passed.problems[0].mark.line == caught.value.problems[0].mark.line

    @pytest.mark.parametrize(
        "error",
        [
            Stopped(signal.SIGINT, " at t = 1 s"),
            AssemblyError("nothing fits", Failure.SINGULAR, timed=True),
            ConvergenceError("no step"),
        ],
        ids=lambda error: type(error).__name__,
    )
    def test_what_ends_a_run_is_passed_between_processes(self, error):
        """A pool of processes whose parent cannot make the exception of a worker waits for ever."""
        passed = pickle.loads(pickle.dumps(error))
        assert type(passed) is type(error) and str(passed) == str(error) and vars(passed) == vars(error)


class TestRun:
    def test_run_gives_the_results_of_the_command(self, folder, capfd):
        with mecano.run("pendulum.yaml", set={"time.end": 0.1}) as own:
            reported = capfd.readouterr()
            CliRunner().invoke(commands, ["run", "pendulum.yaml", "--set", "time.end=0.1", "-o", "b.h5"])
            with mecano.open_results("b.h5") as other:
                assert own.metadata["overrides"] == other.metadata["overrides"] == ["time.end=0.1"]
                np.testing.assert_array_equal(own["hinge.angle"].values, other["hinge.angle"].values)
        assert (
            reported.out == "" and "100 steps, 0 rejected" in reported.err and "results in pendulum.h5" in reported.err
        )

    def test_no_file_is_replaced_unless_asked(self, folder):
        short = {"time.end": 0.01}
        mecano.run("pendulum.yaml", set=short, quiet=True)
        with pytest.raises(ResultsError, match=r"pendulum.h5 already exists.*--force.*force=True"):
            mecano.run("pendulum.yaml", set=short, quiet=True)
        with pytest.raises(UsageError, match="resume=True continues"):
            mecano.run("pendulum.yaml", resume=True, force=True)
        assert mecano.run("pendulum.yaml", set=short, quiet=True, force=True).status == "complete"

    def test_names_that_are_no_text(self, folder):
        """The results file names its deck as text, and so does the command of a case."""
        name = b"p\xff.yaml".decode(errors="surrogateescape")
        (folder / name).write_bytes(PENDULUM.read_bytes())
        (folder / "study.yaml").write_text(STUDY)
        with pytest.raises(DeckError, match="its name is not UTF-8 text"):
            mecano.run(name, quiet=True)
        with pytest.raises(UsageError, match="is not UTF-8 text"):
            mecano.sweep("study.yaml", name, quiet=True)

    def test_it_is_quiet_when_asked(self, folder, capfd):
        mecano.run("pendulum.yaml", set={"time.end": 0.01}, quiet=True)
        assert capfd.readouterr() == ("", "")

    def test_equilibria_too(self, folder):
        """Tip of a cantilever: F L^3/(3 E I) = 7.634 mm, and the shear."""
        CliRunner().invoke(commands, ["new", "beam"])
        with pytest.raises(UsageError, match="have no checkpoints"):
            mecano.run("beam.yaml", checkpoint=1.0)
        assert mecano.run("beam.yaml", quiet=True)["tip.position.z"].values[-1] == pytest.approx(-7.65e-3, rel=5e-3)

    def test_interruption_leaves_a_checkpoint_and_the_handlers(self, folder, monkeypatch):
        """A SIGINT after some steps; the run is resumed to the same bits."""
        whole = mecano.run("pendulum.yaml", "whole.h5", quiet=True)
        handler, hook = signal.getsignal(signal.SIGINT), sys.unraisablehook
        seen = []

        def interrupt(self, run):
            if run.motion.t > 0.0995 and not seen:
                seen.append(run)
                signal.raise_signal(signal.SIGINT)

        with monkeypatch.context() as patched:
            patched.setattr("mecano.analyses.progress.Progress.__call__", interrupt)
            with pytest.raises(KeyboardInterrupt, match=r"SIGINT at t = 0.1 s.*'pendulum.h5', resume=True\)"):
                mecano.run("pendulum.yaml", quiet=True, checkpoint=0.0)
            seen.clear()
            with pytest.raises(KeyboardInterrupt, match=r"'b.h5', set=\{'time.end': 1\}, resume=True"):
                mecano.run("pendulum.yaml", "b.h5", set={"time.end": 1}, checkpoint=0.0)
        assert (signal.getsignal(signal.SIGINT), sys.unraisablehook) == (handler, hook)
        assert mecano.open_results("pendulum.h5").status == "stopped"
        resumed = mecano.run("pendulum.yaml", resume=True, quiet=True)
        np.testing.assert_array_equal(resumed["hinge.angle"].values, whole["hinge.angle"].values)

    def test_other_threads_run_too(self, folder):
        found = []
        work = threading.Thread(
            target=lambda: found.append(mecano.run("pendulum.yaml", set={"time.end": 0.01}, quiet=True).status)
        )
        work.start()
        work.join()
        assert found == ["complete"]


class TestDeck:
    @pytest.mark.parametrize("path", sorted(INPUTS.glob("*.yaml")), ids=lambda path: path.stem)
    def test_a_deck_read_from_a_file_resolves_as_the_file(self, path):
        """Units, expressions, templates and files that are read: all come through."""
        own = deck_module.checked_deck(mecano.Deck.read(path), {}).resolved()
        assert own == read_deck(path).resolved()

    def test_one_is_built_of_python_objects(self, folder):
        deck = mecano.Deck({
            "gravity": np.array([0.0, 0.0, -9.81]),
            "parameters": {"length": "1.5 m"},
            "nodes": {"pin": {"position": (0, 0, 0)}},
            "elements": {"bar": {
                "type": "rigid_body", "node": "pin", "mass": np.float64(1.0), "center_of_mass": ["$length / 2", 0, 0],
                "inertia": [1e-4, 0.1875, 0.1875],
            }},
            "joints": {"hinge": {"type": "hinge", "nodes": ["ground", "pin"], "axis": [0, 1, 0]}},
            "time": {"end": 2, "step": 1e-3},
            "output": {"every": 0.01},
        })  # fmt: skip
        known = read_deck(PENDULUM).resolved()
        own = deck_module.checked_deck(deck, {}).resolved()
        assert {key for key in known if own[key] != known[key]} == {"title", "parameters"}
        deck.save("own.yaml")
        assert read_deck("own.yaml").resolved() == own
        with pytest.raises(UsageError, match="own.yaml already exists.*replace=True"):
            deck.save("own.yaml")
        assert mecano.run(deck, set={"time.end": 0.01}, quiet=True).path == Path("deck.h5")

    def test_a_plain_dict_is_one_too(self, folder):
        deck = dict(mecano.Deck.read(PENDULUM))
        assert mecano.check(deck).mass == 1.0 and len(mecano.modes(deck).frequency) > 0
        assert mecano.run(deck, set={"time.end": 0.01}, quiet=True).path == Path("deck.h5")

    def test_objects_that_a_deck_cannot_hold_are_refused(self, folder):
        deck = mecano.Deck.read(PENDULUM)
        for call in (
            lambda: mecano.check(deck, set={"time.end": object()}),
            lambda: mecano.Deck({"time": object()}).text,
        ):
            with pytest.raises(TypeError, match="a deck holds dicts, lists, numbers and strings, .*object"):
                call()
        places = {"nodes": {"a": {"position": [0, object(), 0]}}}
        with pytest.raises(TypeError, match=r"'nodes.a.position.1' is of the type object"):
            mecano.check(places)
        with pytest.raises(TypeError, match="'elements.bar.mass' is of the type date"):  # 2026-11-29 would be 1986
            mecano.check({"elements": {"bar": {"mass": date(2026, 11, 29)}}})
        places["nodes"]["a"]["position"] = {0.1, 0.2}
        with pytest.raises(TypeError, match=r"'nodes.a.position' is of the type set"):
            mecano.check(places)
        places["nodes"]["a"] = places
        with pytest.raises(TypeError, match="a deck cannot hold itself"):
            mecano.check(places)
        with pytest.raises(TypeError, match=r"'set' takes a dict such as \{'time.end': 2\}, not 'time.end=1'"):
            mecano.check(deck, set="time.end=1")
        with pytest.raises(TypeError, match="a deck is a path, a mecano.Deck or a dict, not int"):
            mecano.check(1)
        with pytest.raises(TypeError, match="expected str"):
            deck.save(1)  # the number of an open file

    def test_names_of_files_may_be_paths(self, folder):
        deck = mecano.Deck.read(PENDULUM)
        (folder / "moved.csv").write_text("time [s],x [m]\n0,0\n2,1\n")
        deck["nodes"]["shaker"] = {"position": [0, 0, 1]}
        deck["joints"]["shaking"] = {
            "type": "prescribed_position", "node": "shaker", "direction": [0, 0, 1],
            "value": {"table": {"file": Path("moved.csv")}},
        }  # fmt: skip
        deck.folder = str(folder)
        assert deck_module.checked_deck(deck, {}).resolved()["joints"]["shaking"]["node"] == "shaker"

    def test_a_copy_is_changed_by_itself(self):
        deck = mecano.Deck.read(PENDULUM)
        other = deck.copy()
        other["time"]["end"] = 9
        del other["output"]
        assert deck["time"]["end"] == 2.0 and "output" in deck and len(other) == len(deck) - 1
        assert "elements, joints" in repr(deck)

    def test_texts_that_look_like_numbers_stay_texts(self):
        deck = mecano.Deck({"title": "1e3"})
        assert 'title: "1e3"' in deck.text

    def test_errors_are_those_of_the_command_line(self, folder):
        deck = mecano.Deck.read("pendulum.yaml")
        deck["joints"]["hinge"]["axsi"] = deck["joints"]["hinge"].pop("axis")
        with pytest.raises(mecano.DeckError) as raised:
            mecano.check(deck)
        text = str(raised.value)
        assert "did you mean 'axis'?" in text and "1 error;" in text
        place = re.search(r"<pendulum>:(\d+):(\d+): hinge 'hinge': unknown key 'axsi'", text)
        line, column = map(int, place.groups())
        assert deck.text.splitlines()[line - 1][column - 1 :].startswith("axsi")
        with pytest.raises(mecano.DeckError, match=r"override time.ned:1:6: unknown key .*; did you mean 'end'"):
            mecano.check("pendulum.yaml", set={"time.ned": 1})
        with pytest.raises(mecano.DeckError, match="No such file"):
            mecano.Deck.read("other.yaml")
        with pytest.raises(mecano.DeckError, match="not valid YAML"):
            (folder / "broken.yaml").write_text("mecano: 1\nnodes: [")
            mecano.Deck.read("broken.yaml")
        with pytest.raises(TypeError, match="but .time.end. is of the type complex"):
            _ = mecano.Deck({"time": {"end": 1j}}).text
        with pytest.raises(TypeError, match="of a mapping of sections, not of str; Deck.read reads a file"):
            mecano.Deck("pendulum.yaml")
        deck = mecano.Deck.read("pendulum.yaml")
        deck["end"] = 1
        with pytest.raises(mecano.DeckError, match="^\n<pendulum>:.*unknown key 'end'"):
            mecano.check(deck)


class TestSimulation:
    @pytest.mark.parametrize("duration", [0.5, 0.7 - 0.2])
    def test_a_duration_that_ends_where_a_load_jumps_changes_no_bit(self, folder, duration):
        """A mass at rest is pushed by 1 N from 0.5 s on: x = (t - 0.5)^2/2, of which fixed steps have no error.

        0.7 - 0.2 is 0.49999999999999994.
        """
        (folder / "push.yaml").write_text(PUSH)
        with mecano.Simulation("push.yaml", "stepped.h5") as s:
            s.advance(duration)
            s.advance(0.6)
        whole, stepped = mecano.run("push.yaml", "whole.h5", quiet=True), s.results()
        found = stepped["t.displacement"].values
        np.testing.assert_allclose(found, 0.5 * np.maximum(stepped.time - 0.5, 0.0) ** 2, rtol=1e-9, atol=1e-15)
        assert np.array_equal(found, whole["t.displacement"].values)

    def test_the_steps_of_a_simulation_are_those_of_a_run(self, folder):
        """Advanced by whole steps, to the end: the same rows, up to rounding of the times."""
        short = {"time.end": 0.2}
        with mecano.Simulation("pendulum.yaml", "stepped.h5", set=short) as s:
            while s.time < s.end:
                s.advance(0.01)
        with s.results() as stepped, mecano.run("pendulum.yaml", set=short, quiet=True) as whole:
            assert stepped.status == "complete" and len(stepped.steps) == len(whole.steps) == 200
            np.testing.assert_allclose(stepped["hinge.angle"].values, whole["hinge.angle"].values, atol=1e-12)

    def test_outputs_are_current(self, folder):
        with mecano.Simulation("pendulum.yaml") as s:
            s.advance(0.1)
            angle, position = s["hinge.angle"], s["pin.position"]
            with s.results() as until_now:
                assert until_now["hinge.angle"].values[-1] == angle and until_now.status == "running"
            assert s["pin.position.x"] == position[0] and position.shape == (3,)
            assert s["hinge.force.magnitude"] == pytest.approx(np.linalg.norm(s["hinge.force"]), rel=1e-15)
            with pytest.raises(UnknownNameError, match="did you mean|similar|no output"):
                _ = s["hinge.angel"]
            assert "hinge.angle" in s and "hinge.angel" not in s and s.names("*.angle") == ["joints/hinge/angle"]
        with s.results() as results:
            assert results["hinge.angle"].values[-1] == angle and results.time[-1] == pytest.approx(0.1)
            assert results.status == "stopped" and results.resumable

    def test_one_that_was_left_is_resumed(self, folder):
        with mecano.Simulation("pendulum.yaml", "a.h5") as s:
            s.advance(0.5)
        resume(read_deck("pendulum.yaml"), "a.h5")
        with mecano.open_results("a.h5") as results:
            assert results.status == "complete" and results.time[-1] == 2.0

    def test_an_interruption_that_the_block_catches_ends_the_simulation(self, folder, monkeypatch):
        """The state of the run is that before ``advance``, the file and its checkpoint are later."""
        whole = mecano.run("pendulum.yaml", "whole.h5", quiet=True)
        with mecano.Simulation("pendulum.yaml", "cut.h5") as s:
            s.advance(0.5)
            with monkeypatch.context() as patched:
                patched.setattr(s._run.integrator, "observers", (lambda step: signal.raise_signal(signal.SIGINT),))
                with pytest.raises(KeyboardInterrupt):
                    s.advance(1.5)
            with pytest.raises(UsageError, match="has ended.* SIGINT at t = 0.501 s"):
                s.advance(0.1)
        with s.results() as stopped:
            assert stopped.status == "stopped" and len(stopped.steps) == 501
        with mecano.run("pendulum.yaml", "cut.h5", resume=True, quiet=True) as resumed:
            assert len(resumed.steps) == len(whole.steps)
            assert np.all(np.diff(resumed.steps["time"]) > 0.0)
            np.testing.assert_allclose(resumed["hinge.angle"].values, whole["hinge.angle"].values, atol=1e-12)

    def test_an_error_in_the_block_is_kept(self, folder):
        with pytest.raises(ZeroDivisionError):
            with mecano.Simulation("pendulum.yaml") as s:
                s.advance(0.1)
                _ = 1 / 0
        assert mecano.open_results("pendulum.h5").status == "failed"

    def test_errors_of_a_simulation(self, folder):
        with mecano.Simulation("pendulum.yaml", set={"time.end": 0.01}) as s:
            for wrong in (-1, None, "1"):
                with pytest.raises(UsageError, match=f"greater than zero, in seconds, got {wrong!r}"):
                    s.advance(wrong)
            s.advance(5.0)
            assert s.time == 0.01
            with pytest.raises(UsageError, match="the deck ends at t = 0.01 s"):
                s.advance(0.01)
        with pytest.raises(UsageError, match="has ended"):
            s.advance(0.01)
        with pytest.raises(UsageError, match="begins in a block"):
            mecano.Simulation("pendulum.yaml").advance(0.1)
        with pytest.raises(UsageError, match="begins in a block"):
            mecano.Simulation("pendulum.yaml").names()
        with pytest.raises(UsageError, match="equilibria"):
            mecano.Simulation(INPUTS / "princeton_beam.yaml")

    def test_another_working_folder_within_the_block(self, folder, monkeypatch):
        (folder / "elsewhere").mkdir()
        with mecano.Simulation("pendulum.yaml", "s.h5") as s:
            s.advance(0.1)
            monkeypatch.chdir(folder / "elsewhere")
            s.advance(0.1)
            with s.results() as results:
                assert results.status == "running"
        with s.results() as results:
            assert results.status == "stopped" and len(results.time) == 21
        assert sorted(path.name for path in folder.iterdir()) == ["elsewhere", "pendulum.yaml", "s.h5"]
        assert not list((folder / "elsewhere").iterdir())

    def test_the_text_is_the_time(self, folder):
        s = mecano.Simulation("pendulum.yaml", "s.h5")
        assert repr(s) == "Simulation 's.h5': not begun"
        with s:
            s.advance(0.5)
            assert repr(s) == "Simulation 's.h5': at t = 0.5 of 2 s"
        assert repr(s) == "Simulation 's.h5': ended at t = 0.5 of 2 s"


@pytest.mark.parametrize(
    ("call", "options", "message"),
    [
        (mecano.run, {"checkpoint": -1.0}, "checkpoint=-1.0: write a time"),
        (mecano.run, {"checkpoint": float("nan")}, "checkpoint=nan: write a time"),
        (mecano.modes, {"number": 0}, "number=0: write a whole number of 1 or more"),
        (mecano.modes, {"solver": "lapack"}, "solver='lapack': write 'automatic' or 'dense' or 'sparse'"),
        (mecano.sweep, {"jobs": 0}, "jobs=0: write 1 or more"),
    ],
)
def test_invalid_options_are_refused(folder, call, options, message):
    """As by the commands; no file is read or written."""
    with pytest.raises(UsageError, match=message):
        call("none.yaml", **options)
    assert sorted(path.name for path in folder.iterdir()) == ["pendulum.yaml"]


class TestCheckAndModes:
    def test_check_returns_the_text_of_the_command(self, folder):
        found = mecano.check("pendulum.yaml")
        assert str(found) + "\n" == CliRunner().invoke(commands, ["check", "pendulum.yaml"]).output
        assert (found.unknowns, found.multipliers, found.warnings) == (5, 2, ())

    def test_modes_returns_the_text_of_the_command(self, folder):
        """Small swings of a point mass on 1 m: sqrt(g/L)/(2 pi)."""
        found = mecano.modes("pendulum.yaml", "own.h5", set={"initial": "static"})
        arguments = ["modes", "pendulum.yaml", "--set", "initial=static", "-q"]
        assert str(found) + "\n" == CliRunner().invoke(commands, arguments).output
        assert found.frequency[0] == pytest.approx(np.sqrt(9.81) / (2 * np.pi), rel=1e-6)
        assert (folder / "own.h5").exists() and found.kinds[0] == "oscillation"

    def test_a_saved_state_may_be_a_pair(self, folder):
        mecano.run("pendulum.yaml", set={"time.end": 0.1}, quiet=True).close()
        expected = mecano.modes("pendulum.yaml", at="pendulum.h5:0.05")
        for at in (("pendulum.h5", 0.05), (Path("pendulum.h5"), np.float64(0.05))):
            found = mecano.modes("pendulum.yaml", at=at)
            assert found.about == expected.about and "0.05" in found.about
            np.testing.assert_array_equal(found.eigenvalues, expected.eigenvalues)
        assert "0.1 s" in mecano.modes("pendulum.yaml", at=Path("pendulum.h5")).about

    def test_modes_and_responses_take_the_same_saved_states(self, folder):
        mecano.run("pendulum.yaml", set={"time.end": 0.1}, quiet=True).close()
        channels = {"inputs": "motor.value", "outputs": "hinge.angle", "low": 0.1, "high": 10.0, "number": 3}
        motor = {"loads": {"motor": {"type": "joint_moment", "joint": "hinge", "value": 0}}}
        path = Path("pendulum.h5")
        for at in ("pendulum.h5:0.05", ("pendulum.h5", 0.05), (path, np.float64(0.05)), path):
            expected = mecano.modes("pendulum.yaml", at=at).about
            assert mecano.response("pendulum.yaml", at=at, set=motor, **channels).about == expected
        with pytest.raises(TypeError, match=r"write 'results.h5:1.25' or \('results.h5', 1.25\)"):
            mecano.response("pendulum.yaml", at=0.05, set=motor, **channels)
        with pytest.raises(TypeError, match=r"write 'results.h5:1.25' or \('results.h5', 1.25\)"):
            mecano.modes("pendulum.yaml", at=("pendulum.h5", "end"))
        with pytest.raises(UsageError, match=r"frame=\(0, 0, 3\): write 'inertial', the name of a node, or 'wx,wy,wz'"):
            mecano.modes("pendulum.yaml", frame=(0, 0, 3))
        for analysis in (mecano.modes, partial(mecano.response, **channels)):
            with pytest.raises(UsageError, match="at_rest=True belongs to a saved state"):
                analysis("pendulum.yaml", at_rest=True)

    def test_errors_of_responses_speak_of_frequencies_and_names(self, folder):
        motor = {"loads": {"motor": {"type": "joint_moment", "joint": "hinge", "value": 0}}}
        motor["grounds"] = {"road": {"plane": {"point": [0, 0, -9], "normal": [0, 0, 1]}}}
        channels = {"inputs": "motor.value", "outputs": "hinge.angle", "low": 0.1, "high": 10.0}
        for wrong, message in (
            ({"high": 0.01}, "the highest frequency, 0.01 Hz, is less than the lowest, 0.1 Hz"),
            ({"inputs": []}, "no input is given: name one or more"),
            ({"inputs": "moter.value"}, "there is no input moter.value; did you mean motor.value"),
            ({"inputs": "road.profile"}, "input road.profile: a ground does not move; stand wheels on plates"),
            ({"outputs": "hinge.angel"}, "output hinge.angel: .*; did you mean angle"),
        ):
            with pytest.raises(UsageError, match=message):
                mecano.response("pendulum.yaml", set=motor, **channels | wrong)


@pytest.fixture(scope="class")
def study(tmp_path_factory):
    """A study in a folder that remains the working folder."""
    folder = tmp_path_factory.mktemp("study")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        (folder / "pendulum.yaml").write_bytes(PENDULUM.read_bytes())
        (folder / "study.yaml").write_text(STUDY)
        yield mecano.sweep("study.yaml", jobs=1, quiet=True)


class TestSweep:
    def test_a_study_is_a_file(self, folder):
        with pytest.raises(TypeError, match="a study is the path of a file, not a dict; json.dump writes"):
            mecano.sweep({"study": 1})

    def test_a_study_is_run_and_read(self, folder, capfd):
        (folder / "study.yaml").write_text(STUDY)
        found = mecano.sweep("study.yaml", jobs=2, quiet=True)
        assert repr(found) == "Study of 2 cases: 2 complete"
        np.testing.assert_array_equal(found["elements.bar.mass"], [1.0, 2.0])
        for mass, swing in zip(
            (1.0, 2.0), found["swing"], strict=True
        ):  # m g c t^2 / (2 (J + m c^2)), first order in t^2
            assert swing == pytest.approx(mass * 9.81 * 0.75 * 0.1**2 / 2 / (0.1875 + mass * 0.75**2), rel=1e-3)
        assert found.units["swing"] == "rad" and "case" in found and tuple(found) == found.columns
        with pytest.raises(UnknownNameError, match=r"no column 'swung' in this study: there are case, .*swing"):
            _ = found["swung"]
        with pytest.raises(UsageError, match="study_runs has cases"):
            mecano.sweep("study.yaml")
        with pytest.raises(mecano.DeckError, match="unknown key"):
            (folder / "wrong.yaml").write_text(STUDY.replace("grid", "gird"))
            mecano.sweep("wrong.yaml")
        assert capfd.readouterr().out == ""

    def test_columns_and_results_of_cases_are_named(self, study):
        assert len(study) == 2 and study.folder == Path("study_runs")
        np.testing.assert_array_equal(study["bar.mass"], study["elements.bar.mass"])
        with pytest.raises(UnknownNameError, match="no column 'ass'"):
            study["ass"]
        with study.results(2) as results:
            assert results.resolved["elements"]["bar"]["mass"] == 2.0
            assert results.extremes["hinge.angle"].maximum == study["swing"][1]
        with pytest.raises(ResultsError, match="0003.h5"):
            study.results(3)

    def test_a_data_frame_has_whole_numbers_of_cases(self, study):
        pandas = pytest.importorskip("pandas")
        frame = study.to_pandas()
        assert frame["case"].tolist() == [1, 2] and frame["exit_code"].tolist() == [0, 0]
        assert pandas.api.types.is_integer_dtype(frame["exit_code"]) and frame["swing"].dtype == float

    def test_notebooks_display_tables(self, study):
        shown = study._repr_html_()
        assert "Study of 2 cases: 2 complete" in shown and "<td>elements.bar.mass [kg]</td>" in shown
        assert shown.count("<tr>") == 3 and f"<td>{study['swing'][1]:.6g}</td>" in shown
        assert "mobility         1" in mecano.check("pendulum.yaml")._repr_html_()
        assert "damped [Hz]" in mecano.modes("pendulum.yaml")._repr_html_()

    def test_failed_cases_run_again(self, folder):
        (folder / "study.yaml").write_text(STUDY)
        first = mecano.sweep("study.yaml", jobs=1, quiet=True)
        report = first.folder / "0002.json"
        report.write_text(report.read_text().replace('"complete"', '"failed"'))
        (first.folder / "0002.h5").unlink()
        assert mecano.sweep("study.yaml", resume=True, quiet=True)["status"].astype(str).tolist()[1] == "failed"
        assert mecano.sweep("study.yaml", again="failed", quiet=True)["status"].astype(str).tolist()[1] == "complete"
        with pytest.raises(UsageError, match="write 'failed'"):
            mecano.sweep("study.yaml", again="all")
        with pytest.raises(UsageError, match="force=True replaces"):
            mecano.sweep("study.yaml", again="failed", force=True)


class TestResults:
    @pytest.fixture
    def results(self, folder):
        with mecano.run("pendulum.yaml", set={"time.end": 0.1}, quiet=True) as results:
            yield results

    def test_xarray(self, results):
        pytest.importorskip("xarray")
        found = results.to_xarray()
        assert found["nodes.pin.position"].dims == ("time", "xyz") and found.attrs["status"] == "complete"
        assert found["joints.hinge.angle"].attrs["units"] == "rad"
        np.testing.assert_array_equal(found["time"], results.time)
        np.testing.assert_array_equal(found["joints.hinge.angle"], results["hinge.angle"].values)
        np.testing.assert_array_equal(found["nodes.pin.rotation"].sel(wxyz="w"), results["pin.rotation.w"].values)

    def test_pandas(self, results):
        pytest.importorskip("pandas")
        found = results.to_pandas("hinge.*")
        assert found.index.name == "time" and found.attrs["units"]["joints.hinge.angle"] == "rad"
        np.testing.assert_array_equal(found["joints.hinge.force.y"], results["hinge.force.y"].values)

    def test_several_patterns(self, results):
        pytest.importorskip("pandas")
        found = results.to_pandas("hinge.angle", "hinge.force.y")
        assert list(found.columns) == ["joints.hinge.angle", "joints.hinge.force.y"]

    def test_what_is_no_name_is_refused(self, results):
        for wrong in (
            lambda: results[1],
            lambda: results.plot(["hinge.angle"]),
            lambda: results.plot("hinge.angle", 1),
        ):
            with pytest.raises(TypeError, match="an output is named by a text such as 'hinge.angle', not by"):
                wrong()

    @pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="counts open files as Linux lists them")
    def test_results_that_nothing_refers_to_are_closed(self, results):
        def number():
            return len(list(Path("/proc/self/fd").iterdir()))

        before = number()
        for _ in range(5):
            assert mecano.open_results("pendulum.h5")["hinge.angle"][0] == 0.0
        assert number() == before

    def test_texts_are_short_also_after_the_end(self, results):
        angle = results["hinge.angle"]
        assert repr(angle).startswith("Trace 'joints/hinge/angle' [rad]: ") and len(angle) == len(results.time)
        results.close()
        assert repr(results) == results._repr_html_().replace("&#x27;", "'") == "Results 'pendulum.h5': closed"

    def test_another_working_folder_and_another_process_read_the_same_file(self, results, folder, monkeypatch):
        (folder / "elsewhere").mkdir()
        monkeypatch.chdir(folder / "elsewhere")
        results.refresh()
        with pickle.loads(pickle.dumps(results)) as other:
            np.testing.assert_array_equal(other["hinge.angle"], results["hinge.angle"])

    @pytest.mark.parametrize("library", ["xarray", "pandas"])
    def test_patterns_name_components_and_must_match_an_output(self, results, library):
        pytest.importorskip(library)
        convert = getattr(results, f"to_{library}")
        for pattern in ("hinge.force.y", "*.force.y"):
            found = convert(pattern)
            names = found.columns if library == "pandas" else found.data_vars
            assert list(names) == ["joints.hinge.force.y"]
            np.testing.assert_array_equal(found["joints.hinge.force.y"], results["hinge.force.y"].values)
        with pytest.raises(UnknownNameError, match=r"no output of pendulum.h5 matches 'hinges\.\*'"):
            convert("hinges.*")
        with pytest.raises(UnknownNameError, match="did you mean hinge.angle"):
            convert("hinge.angel")

    @pytest.mark.parametrize("library", ["xarray", "pandas"])
    def test_libraries_that_are_missing_are_named(self, results, monkeypatch, library):
        monkeypatch.setitem(sys.modules, library, None)
        with pytest.raises(ImportError, match=f"Results.to_{library} needs {library}: pip install {library}"):
            getattr(results, f"to_{library}")()

    def test_plots_are_pictures(self, results, folder):
        for names in ((), ("hinge.angle",), ("hinge.rate:hinge.angle", "hinge.force")):
            plot = results.plot(*names)
            assert "save('plot.png')" in repr(plot)
            assert plot._repr_png_().startswith(b"\x89PNG")
        assert len(plot.figure.axes) == 2 and plot.figure.axes[0].get_xlabel() == "angle [rad]"
        plot.save("own.svg")
        assert b"<svg" in (folder / "own.svg").read_bytes()
        with pytest.raises(UnknownNameError, match="hinge.angel"):
            results.plot("hinge.angel")

    def test_a_run_without_saved_times_has_nothing_to_plot(self, folder, monkeypatch):
        """A run that has just begun; its tables have no rows."""
        results_samples.create("new.h5").close()
        tables = SimpleNamespace(Index=lambda times, name: times, DataFrame=lambda c, index: SimpleNamespace(attrs={}))
        monkeypatch.setitem(sys.modules, "pandas", tables)
        with mecano.open_results("new.h5") as results:
            for names in ((), ("knee.angle",)):
                with pytest.raises(ResultsError, match="new.h5: no saved times yet"):
                    results.plot(*names)
            assert results.to_pandas("knee.*").attrs["units"]["joints.knee.angle"] == "rad"

    def test_a_notebook_shows_how_the_run_went(self, results):
        page = results._repr_html_()
        assert "complete: the end was reached" in page and "<caption>pendulum.h5" in page
        assert repr(results) == "Results 'pendulum.h5': complete, 11 saved times, 17 outputs"

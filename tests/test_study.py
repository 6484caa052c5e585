"""Studies: study files, cases in parallel, their files, the table and its picture."""

import csv
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from textwrap import dedent
from types import SimpleNamespace

import numpy as np
import pytest
import results_samples
from click.testing import CliRunner
from process import COMMAND, mecano_process, settings
from time_runs import INPUTS

import mecano
from mecano.analyses import warmup as warming
from mecano.analyses.warmup import all_kinds, warmup
from mecano.cli import commands
from mecano.deck.format import deck_error_text
from mecano.deck.read import read_deck
from mecano.elements import KINDS
from mecano.errors import DeckError, ResultsError, UnknownNameError, UsageError
from mecano.jit import store
from mecano.post.pictures import post
from mecano.post.report_page import page_of
from mecano.post.study_outputs import displayed_outputs
from mecano.post.study_plots import study_figure
from mecano.post.study_report import _warnings, study_report
from mecano.post.study_requests import requested_figures
from mecano.post.study_statistics import statistics
from mecano.post.value_labels import LONGEST, legible, short_texts
from mecano.results.recorded import Event
from mecano.results.study_file import Column, StudyTable, within
from mecano.results.study_file import read_study as read_table
from mecano.study import dask, slurm
from mecano.study.execution import clear, collect, due
from mecano.study.folder import COMPLETE, FAILED, Folder, Record
from mecano.study.outputs import Output
from mecano.study.pool import Limits
from mecano.study.read import read_study, try_deck
from mecano.study.slurm import ranges, script
from mecano.study.table import Table
from mecano.study.units import units_of
from mecano.study.unvaried_values import unvaried_values

HEAD = "study: 1\ndeck: deck.yaml\n"
BALL = """\
mecano: 1
gravity: [0, 0, -9.81]
parameters: {speed: 10}
nodes:
  ball: {position: [0, 0, 1]}
elements:
  ball: {type: point_mass, node: ball, mass: 2.0}
time: {end: 0.2, step: 1.0e-2}
initial:
  velocities:
    - {nodes: [ball], velocity: [$speed, 0, 0]}
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty current folder with the deck of a ball in it."""
    (tmp_path / "deck.yaml").write_text(BALL)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def study(folder, text, head=HEAD):
    """The Study of a text."""
    (folder / "study.yaml").write_text(head + dedent(text))
    return read_study("study.yaml")


def values(folder, text):
    """The values of all cases of a study, row by row."""
    return [tuple(case.values.values()) for case in study(folder, text).cases]


class TestCases:
    def test_a_grid_has_all_combinations(self, folder):
        found = values(folder, "grid: {parameters.speed: [1, 2], time.end: {from: 1, to: 2, number: 3}}")
        assert found == [(1, 1.0), (1, 1.5), (1, 2.0), (2, 1.0), (2, 1.5), (2, 2.0)]

    def test_rows_of_a_list_and_of_a_table_go_together(self, folder):
        assert values(folder, "list: [{parameters.speed: 1, time.end: 2}, {parameters.speed: 3, time.end: 4}]") == [
            (1, 2), (3, 4),
        ]  # fmt: skip
        (folder / "rows.csv").write_text("# speeds\nparameters.speed, time.method\n1e1, hht\n20 km/h, newmark\n")
        found = study(folder, "csv: rows.csv")
        assert [tuple(case.values.values()) for case in found.cases] == [(10.0, "hht"), ("20 km/h", "newmark")]
        assert found.overrides(found.cases[1]) == ('parameters.speed="20 km/h"', 'time.method="newmark"')
        assert found.cases[1].shown["parameters.speed"] == pytest.approx(20 / 3.6)

    def test_rows_that_leave_a_value_show_that_of_the_deck(self, folder):
        """Not those of expressions, which may vary with other values, and of sections that the deck does not have."""
        (folder / "deck.yaml").write_text(BALL.replace("{speed: 10}", "{speed: 36 km/h, twice: 2 * $speed}"))
        rows = "list: [{parameters.speed: 1, parameters.twice: 9}, {elements.ball.mass: 3, output.every: 1}]"
        left = {"parameters.speed": pytest.approx(10.0), "elements.ball.mass": 2.0}
        assert unvaried_values(study(folder, rows)) == left
        assert unvaried_values(study(folder, "grid: {parameters.speed: [1, 2]}")) == {}

    def test_a_hypercube_has_one_value_in_each_part_of_every_range(self, folder):
        text = "latin_hypercube: {{ranges: {{parameters.speed: [10, 20], time.end: [1, 2 s]}}, number: 8, seed: {}}}"
        found = np.array(values(folder, text.format(3)))
        for column, low, width in zip(found.T, (10.0, 1.0), (10.0, 1.0), strict=True):
            assert sorted(np.floor(8 * (column - low) / width)) == list(range(8))
        assert np.array_equal(found, values(folder, text.format(3)))
        assert not np.array_equal(found, values(folder, text.format(4)))

    def test_seeds_and_ways_together(self, folder):
        found = values(folder, "seeds: {path: parameters.speed, number: 2, first: 7}\ngrid: {time.end: [1, 2]}\n")
        assert found == [(1, 7), (1, 8), (2, 7), (2, 8)]

    def test_overrides_of_all_cases_come_first(self, folder):
        found = study(folder, "set: {time.end: 2}\ngrid: {parameters.speed: [1]}")
        assert found.overrides(found.cases[0]) == ("time.end=2", "parameters.speed=1")

    def test_a_row_may_replace_a_value_of_all_cases(self, folder):
        rows = "list: [{parameters.speed: 1}, {parameters.speed: 2, time.end: 3}]"
        found = study(folder, f"set: {{time.end: 2}}\ngrid: {{time.step: [0.5]}}\n{rows}")
        settings = [found.overrides(case) for case in found.cases]
        assert settings[0] == ("time.end=2", "time.step=0.5", "parameters.speed=1")
        assert settings[1] == ("time.end=3", "time.step=0.5", "parameters.speed=2")
        assert unvaried_values(found) == {"time.end": 2}


@pytest.mark.parametrize(
    "text,place,message",
    [
        ("grids: {time.end: [1]}", "3:1", "unknown key 'grids'; did you mean 'grid'?"),
        ("grid: {time.end: 1}", "3:18", "'time.end' must be a list, or {from: 1, to: 2, number: 5}, got 1"),
        ("grid: {time.end: {from: 1, to: 2}}", "3:", "missing 'time.end.number', a whole number"),
        ("grid:\n  time.end: {from: 1, to: 2}", "4:3", "missing 'time.end.number', a whole number"),
        ("grid: {time.end: {start: 1, to: 2, number: 3}}", "3:19", "'time.end.start'; here it is called 'from'"),
        ("parameters: {time.end: [1]}", "3:1", "unknown key 'parameters'; here it is called 'grid'"),
        ("grid: {time..end: [1]}", "3:8", "'time..end' is not a path of keys separated by dots"),
        ("latin_hypercube: {ranges: {time.end: [2, 1]}, number: 3}", "3:38", "must be ascending, got [2, 1]"),
        ("latin_hypercube: {ranges: {time.end: [1, 2]}, number: 0}", "3:", "must be at least 1, got 0"),
        (
            "latin_hypercube: {ranges: {a.b: [1 m, 2 kg]}, number: 3}", "3:",
            "'a.b': 1 m and 2 kg are different quantities",
        ),
        ("grid: {a.b: {from: 1 N m, to: 2 kg, number: 3}}", "3:", "'a.b': 1 N m and 2 kg are different quantities"),
        ("csv: rows.csv", "3:6", "the table rows.csv cannot be read: No such file or directory"),
        ("grid: {time.end: [1]}\nlist: [{time.end: 2}]", "4:9", "'time.end' is given by 'grid' and by 'list'"),
        ("set: {time.end: 2}\ngrid: {time.end: [1]}", "4:8", "'time.end' is given by 'set' and by 'grid'"),
        ("grid: {time.end: [1]}\nsignals: {a: time}", "4:1", "'signals' is a section of decks, not of this file"),
        ("grid: {}", "3:1", "grid: must not be empty"),
        ("list: []", "3:7", "'list' must not be empty, got []"),
        ("list: [{}]", "3:8", "'list[0]' must not be empty"),
        (
            "list:\n- {case: hard, time.end: 1}\n- {time.end: 2}\n- {case: hard, time.end: 3}", "6:10",
            "case 'hard' is named twice, first in line 4",
        ),
        ("title: nothing", "1:1", "nothing is varied: a study has at least one of 'grid', 'list'"),
        ("grid: {a: {from: 1, to: 2, number: 90000}, b: [1, 2]}", "1:1", "180000 cases are more than 100000"),
        (
            "grid: {a: {from: 1, to: 2, number: 9000}, b: {from: 1, to: 2, number: 9000}, c: [1, 2, 3, 4]}",
            "1:1",
            "324000000 cases are more than 100000",
        ),
        ("vary: {time.end: [1]}", "3:1", "unknown key 'vary'; here it is called 'grid'"),
        ("grid: {time.end: [1]}\noutputs: {a: max(x)}", "4:", "must be a mapping, such as {of: hinge.angle, ta"),
        ("grid: {time.end: [1]}\noutputs: {a: {take: max}}", "4:", "an output is 'of' a series, or of an 'event'"),
        ("grid: {time.end: [1]}\noutputs: {a: {of: x, take: first}}", "4:28", "'take' of a series is one of: max, min"),
        ("grid: {time.end: [1]}\noutputs: {a: {event: x, take: first}}", "4:22", "'event' is the name of an element"),
    ],
)  # fmt: skip
def test_errors_of_a_study_have_places(folder, text, place, message):
    with pytest.raises(DeckError) as info:
        study(folder, text)
    reported = deck_error_text(info.value)
    assert re.match(rf"study.yaml:{place}.*", reported) and message in reported, reported


@pytest.mark.parametrize(
    "rows,messages",
    [
        ("time.end,case\n1\n", ["2:1: the row has 1 columns, the first line 2"]),
        ("time.end;case\n1;1,5\n", ["1:1: the table has ';' between its columns; write ','"]),
        ("time.end,case\n1,a\n2,a\n", ["3:1: case 'a' is named twice, first in line 2"]),
        ("time.end\n# none\n", ["1:1: the table has no rows"]),
    ],
)
def test_errors_of_a_table_of_rows(folder, rows, messages):
    """Each mistake is reported once."""
    (folder / "rows.csv").write_text(rows)
    with pytest.raises(DeckError) as info:
        study(folder, "csv: rows.csv")
    reported = [
        f"{problem.mark.line}:{problem.mark.column}: {problem.message}; {problem.hint}"
        for problem in info.value.problems
    ]
    assert len(reported) == len(messages) and all(map(str.startswith, reported, messages)), reported


def test_numbers_that_json_does_not_have(folder):
    """They are passed to the deck as it writes them, so that its message is about them; a case may have no name."""
    found = study(folder, "list: [{case: , parameters.speed: .inf, time.end: [-.inf]}, {parameters.speed: .nan}]")
    assert found.overrides(found.cases[0])[0] == "parameters.speed=.inf" and found.cases[0].name == ""
    assert found.overrides(found.cases[1]) == ("parameters.speed=.nan",)


@pytest.mark.parametrize(
    "head,message",
    [
        (BALL, "missing 'study', the version of the study file; this is a deck: run it by `mecano run`"),
        ("study: 1\ndeck: dekc.yaml\n", "cannot be read: No such file or directory; did you mean 'deck.yaml'?"),
        ("study: 2\ndeck: deck.yaml\n", "this program reads studies of version 1"),
        ("study: 1\ndeck: other.yaml\n", "study.yaml:2:7: the deck other.yaml cannot be read: No such file"),
        ("", "missing 'study'"),
    ],
)
def test_errors_in_a_study_file(folder, head, message):
    with pytest.raises(DeckError) as info:
        study(folder, "grid: {time.end: [1]}" if head else "", head=head)
    assert message in deck_error_text(info.value)


def test_wrong_folders_of_a_study(folder):
    found = study(folder, "grid: {time.end: [1]}")
    with pytest.raises(UsageError, match="deck.yaml is a file; the cases need a folder"):
        due(Folder("deck.yaml", found))
    with pytest.raises(UsageError, match="there is no folder none with cases: run the study first"):
        collect(Folder("none", found), {})


@pytest.mark.parametrize(
    "path,unit",
    [
        ("time.end", "s"), ("time.adaptive.tolerance", ""), ("time.method", ""), ("gravity.2", "m/s2"),
        ("nodes.ball.position.0", "m"), ("elements.ball.mass", "kg"), ("initial.velocities.0.velocity.1", "m/s"),
        ("output.every", "s"), ("parameters.speed", "m/s"), ("parameters.turn", ""),
        ("tire_laws.tyre.friction_by_speed.exponential.start", ""), ("tire_laws.tyre.radial.linear.slope", ""),
        ("tire_laws.tyre.radial.linear.offset", "N"), ("laws.any.constant.value", ""),
        ("loads.push.value.sine.phase", "rad"),
    ],
)  # fmt: skip
def test_units_of_varied_values(folder, path, unit):
    """Those that are declared, of a parameter the one it is written with, in SI; none where it hangs on the use."""
    text = BALL.replace("speed: 10", "speed: 36 km/h, turn: 3") + dedent("""\
        laws: {any: 3}
        tire_laws: {tyre: {radius: 0.3, radial: {linear: {slope: 1e5}}, friction: 0.8, slip_regularization: 0.1}}
        loads: {push: {type: force, node: ball, direction: [1, 0, 0], value: {sine: {amplitude: 1, frequency: 2}}}}
        """)
    (folder / "deck.yaml").write_text(text)
    found = study(folder, f"grid: {{{path}: [1, 2]}}")
    assert units_of(found, read_deck("deck.yaml")) == {path: unit}


@pytest.mark.parametrize(
    "way",
    [
        "grid: {parameters.speed: {from: 36 km/h, to: 20 m/s, number: 2}}",
        "latin_hypercube: {ranges: {parameters.speed: [36 km/h, 20 m/s]}, number: 2}",
        "list: [{parameters.speed: 10}, {parameters.speed: 36 km/h}]",
        "csv: rows.csv",
    ],
)
def test_units_of_parameters_are_those_of_the_cases(folder, way):
    (folder / "rows.csv").write_text("parameters.speed\n10\n36 km/h\n")
    assert units_of(study(folder, way), read_deck("deck.yaml")) == {"parameters.speed": "m/s"}


class TestDecks:
    def test_a_value_that_no_deck_has_is_refused(self, folder):
        with pytest.raises(DeckError, match="unknown key 'time.stop'"):
            try_deck(study(folder, "grid: {time.stop: [1, 2, 3]}"))

    @pytest.mark.parametrize(
        "text,place,message",
        [
            ("set: {elements.ball.mass: -1}\ngrid: {time.end: [1]}", "study.yaml:3:27", "'mass' must be greater than"),
            ("grid: {elements.ball.mass: [-1, -2]}", "study.yaml:3:29", "'mass' must be greater than"),
            ("grid: {elements.ball.mas: [1, 2]}", "study.yaml:3:8", "unknown key 'mas'"),
            ("grid: {time.end: {from: -2, to: -1, number: 3}}", "study.yaml:3:18", "'end' must be later than 'start'"),
            ("list: [{time.end: 1,\n  elements.ball.mass: 2 s}]", "study.yaml:4:23", "a mass [kg] is expected"),
            ("csv: rows.csv", "rows.csv:2:1", "'mass' must be greater than"),
            ("latin_hypercube: {ranges: {time.step: [-2, -1]}, number: 3}", "study.yaml:3:39", "'time.step' must be"),
            ("seeds: {path: elements.ball.mass, number: 1, first: 0}", "study.yaml:3:15", "'mass' must be greater"),
            ("grid: {elements.ball.mass: {from: 1 s, to: 2 s, number: 2}}", "study.yaml:3:28", "a mass [kg]"),
            ("latin_hypercube: {ranges: {elements.ball.mass: [1 N, 2 N]}, number: 3}", "study.yaml:3:48", "a mass"),
        ],
        ids=["set", "grid", "key", "span", "list", "csv", "hypercube", "seeds", "unit of span", "unit of range"],
    )  # fmt: skip
    def test_an_invalid_value_of_a_case_is_reported_at_its_line(self, folder, text, place, message):
        (folder / "rows.csv").write_text("time.end, elements.ball.mass\n1, -3\n")
        with pytest.raises(DeckError) as error:
            try_deck(study(folder, text))
        reported = deck_error_text(error.value)
        assert reported.startswith(f"{place}: ") and message in reported and "--set" not in reported, reported

    def test_an_error_of_a_deck_names_its_case(self, folder):
        (folder / "deck.yaml").write_text(BALL.replace("mass: 2.0", "mass: $speed"))
        with pytest.raises(DeckError) as error:
            try_deck(study(folder, "grid: {parameters.speed: [-1, -2]}"))
        reported = deck_error_text(error.value)
        assert re.match("deck.yaml:7:.*got -1.* in case 1 of the study \\(parameters.speed = -1\\)", reported), reported

    def test_an_error_of_a_deck_shows_where_the_study_gives_the_parameter(self, folder):
        (folder / "deck.yaml").write_text(BALL.replace("mass: 2.0", "mass: $speed"))
        with pytest.raises(DeckError) as error:
            try_deck(study(folder, "grid: {parameters.speed: [1 m, 2 m]}"))
        assert "is a length; $speed is given in study.yaml:3:27; in case 1" in deck_error_text(error.value)

    def test_a_case_that_is_wrong_is_not(self, folder):
        found = try_deck(study(folder, "grid: {time.end: [-1, 2]}"))
        assert found.overrides == ("time.end=2",) and found.values["time"]["end"] == 2.0

    @pytest.mark.parametrize(
        "output,message",
        [
            ("of: 'ball*.position.z', take: max", "'ball*.position.z' is a pattern, but an output is of one series"),
            ("of: ball.positon.z, take: max", "no output 'ball.positon.z' in the results; did you mean"),
            ("of: ball.position, take: max", "'ball.position' is not one number; add one of x, y, z, or magnitude"),
            ("event: bal touch_down, take: first", "nothing named 'bal' has events"),
            ("event: '* locks', take: first", "no element that matches '*' has events 'locks'"),
            (
                "of: strut.compression_force, take: max",
                "'strut.compression_force' exists only in plots",
            ),
        ],
    )
    def test_outputs_that_the_model_has_not(self, folder, output, message):
        with pytest.raises(DeckError) as info:
            try_deck(study(folder, f"grid: {{time.end: [1]}}\noutputs: {{a: {{{output}}}}}"))
        reported = deck_error_text(info.value)
        assert reported.startswith("study.yaml:4:") and f"output 'a': {message}" in reported


class TestFolder:
    def test_due_cases(self, folder):
        found = study(folder, "grid: {time.end: [1, 2, 3]}")
        runs = Folder("runs", found)
        with runs.held():
            for case, status in zip(found.cases[:2], (COMPLETE, FAILED), strict=True):
                runs.write(case, Record(status, 0, 1.0))
        with pytest.raises(UsageError, match="runs has cases: --resume"):
            due(runs)
        for option, cases, again in (("resume", [3], []), ("failed", [2, 3], [2]), ("force", [1, 2, 3], [1, 2, 3])):
            found = due(runs, **{option: True})
            assert ([case.number for case in found.cases], [case.number for case in found.again]) == (cases, again)
        clear(runs, found.again)
        assert not runs.begun()

    def test_a_study_that_has_changed_is_noticed(self, folder):
        found = study(folder, "grid: {time.end: [1, 2, 3]}")
        runs = Folder("runs", found)
        with runs.held():
            runs.write(found.cases[0], Record(COMPLETE, 0))
        (folder / "deck.yaml").write_text(BALL.replace("mass: 2.0", "mass: 3.0"))
        with pytest.raises(UsageError, match="case 1 in runs was run with other values, or another deck"):
            due(Folder("runs", read_study("study.yaml")), resume=True)

    def test_two_at_a_time_are_refused(self, folder):
        runs = Folder("runs", study(folder, "grid: {time.end: [1]}"))
        with runs.held(), pytest.raises(UsageError, match="another process"), runs.held():
            pass

    def test_one_that_runs_is_not_cleared(self, folder):
        runs = Folder("runs", study(folder, "grid: {time.end: [1]}"))
        with runs.held():
            runs.write(runs.study.cases[0], Record(FAILED, 3))
            for begin in (clear, lambda runs, cases: runs.set_aside(cases).__enter__()):
                with pytest.raises(UsageError, match="another process is running cases in runs"):
                    begin(runs, runs.study.cases)
            assert runs.file(runs.study.cases[0], ".json").exists()


def test_a_study_from_its_beginning_to_its_table(folder):
    """One process after the other: x = v t and z = 1 - g t^2/2 in free fall; a case with another fault each."""
    (folder / "study.yaml").write_text(HEAD + dedent("""\
        title: Throws
        set: {output.every: 0.1}
        list:
          - {parameters.speed: 10, elements.ball.mass: 1}
          - {parameters.speed: 20, elements.ball.mass: -1}
          - {parameters.speed: 36 km/h, elements.ball.mass: 2}
          - {parameters.speed: 30, elements.ball.mass: 1}
        outputs:
          way: {of: ball.position.x, take: final}
          fall: {of: ball.velocity.z, take: largest}
          height: {of: ball.position.z, take: min}
          mean_speed: {of: ball.velocity.magnitude, take: mean}
          when: {of: ball.position.x, take: time_of_max}
        """))  # fmt: skip
    code, out, err = mecano_process("sweep", "study.yaml", "--plot")
    assert code == 3 and "4 cases: 3 complete, 1 failed" in out and "not all cases are complete: 1 failed" in err
    assert "1 x exit code 2: study.yaml:7:" in out and "'mass' must be greater than zero" in out
    table = read_table("study_runs/table.h5")
    assert table.title == "Throws" and table["case/status"].tolist() == ["complete", "failed", "complete", "complete"]
    assert table["parameters/parameters.speed"].tolist() == [10.0, 20.0, 10.0, 30.0]
    speed = np.array([10.0, np.nan, 10.0, 30.0])
    np.testing.assert_allclose(table["outputs/way"], 0.2 * speed, rtol=1e-9)
    np.testing.assert_allclose(table["outputs/height"], 1.0 - 0.5 * 9.81 * 0.04 + 0.0 * speed, rtol=1e-3)
    np.testing.assert_allclose(table["outputs/fall"], -9.81 * 0.2 + 0.0 * speed, rtol=1e-9)
    np.testing.assert_allclose(table["outputs/when"], 0.2 + 0.0 * speed, rtol=1e-12)
    fall = np.hypot(speed[:, None], 9.81 * np.array([0.0, 0.1, 0.2]))  # at the saved times
    np.testing.assert_allclose(table["outputs/mean_speed"], fall @ [0.25, 0.5, 0.25], rtol=1e-9)
    assert all(table["case/processor_time"] > 0.01) and table["case/exit_code"].tolist() == [0, 2, 0, 0]
    with open("study_runs/table.csv") as file:
        rows = list(csv.DictReader(file))
    assert [row["parameters.speed [m/s]"] for row in rows] == ["10", "20", "10", "30"]  # one case says 36 km/h
    assert [row["elements.ball.mass [kg]"] for row in rows] == ["1", "-1", "2", "1"]
    assert [row["way [m]"] for row in rows] == [repr(float(x)) if x == x else "" for x in table["outputs/way"]]
    assert (folder / "study_runs" / "table.png").stat().st_size > 10_000
    before = {path.name: path.stat().st_mtime_ns for path in (folder / "study_runs").glob("*.h5")}
    os.remove("study_runs/0004.json")  # as if it had been killed before it could be noted
    code, out, _ = mecano_process("sweep", "study.yaml", "--resume")
    assert code == 3 and "3 complete" in out
    after = {path.name: path.stat().st_mtime_ns for path in (folder / "study_runs").glob("000*.h5")}
    assert all(after[name] == before[name] for name in ("0001.h5", "0003.h5", "0004.h5"))
    assert list(post(["study_runs/table.h5"], output="own.svg", kind="svg")) == [Path("own.svg")]


def test_warnings_of_complete_cases_are_counted_and_reported(folder):
    """The second case saves nothing between its start and its end, the third warns of nothing: it fails."""
    (folder / "study.yaml").write_text(HEAD + dedent("""\
        list: [{output.every: 0.1}, {output.every: 10, time.end: 0.3}, {output.every: 0.1, time.end: -1}]
        outputs: {way: {of: ball.position.x, take: final}}
        """))  # fmt: skip
    code, out, _ = mecano_process("sweep", "study.yaml")
    assert code == 3 and "3 cases: 2 complete, 1 failed; 1 with warnings\n" in out
    table = read_table("study_runs/table.h5")
    assert [len(warnings) for warnings in table.warnings] == [0, 1, 0] and table.verdict in out
    report = study_report("study_runs/table.h5")
    [warnings] = [section.parts for section in report.sections if section.heading == "Warnings"]
    assert warnings[0].rows == [(table.warnings[1][0], "1", "2")] and not report.sound
    assert "only the start and the end are saved" in table.warnings[1][0]


def test_a_resumed_case_is_no_warning(folder):
    """Its bits are those of a run that was not interrupted."""
    (folder / "study.yaml").write_text(HEAD + "list: [{parameters.speed: 10}]\n")
    assert mecano_process("sweep", "study.yaml")[0] == 0
    with mecano.Simulation("deck.yaml", "study_runs/0001.h5", force=True) as simulation:
        simulation.advance(0.1)
    resumed = mecano.run("deck.yaml", "study_runs/0001.h5", resume=True)
    assert "resumed at" in resumed.resumptions[0]
    code, out, _ = mecano_process("sweep", "study.yaml", "--collect")
    assert code == 0 and out.startswith("1 cases: 1 complete\n")


def test_the_largest_value_with_and_without_its_sign(folder):
    results = mecano.run("deck.yaml", "deck.h5")
    taken = [Output("speed", "ball.velocity.z", None, take) for take in ("largest", "largest_magnitude", "max")]
    assert [one.value(results) for one in taken] == [
        (pytest.approx(-9.81 * 0.2, rel=1e-9), "m/s"),
        (pytest.approx(9.81 * 0.2, rel=1e-9), "m/s"),
        (0.0, "m/s"),
    ]
    assert taken[0].doc == "largest of ball.velocity.z, with its sign"


LIMITED = """\
grid: {parameters.speed: [10, 20, 30]}
outputs:
  way: {of: ball.position.x, take: final, at_least: 3 m, at_most: 500 cm}
  when: {of: ball.position.x, take: time_of_max, at_most: 300 ms}
"""


def test_limits_of_outputs_give_verdicts_and_an_exit_code(folder):
    """The ways are 2, 4 and 6 m; a limit that is added later applies to the cases that exist."""
    (folder / "study.yaml").write_text(HEAD + LIMITED)
    code, out, err = mecano_process("sweep", "study.yaml", "--plot")
    assert code == 8 and "3 cases: 3 complete; 2 beyond limits\n  way: beyond its limits in case 1, 3\n" in out
    assert "2 of 3 cases have outputs beyond their limits: see study_runs/table.csv" in err
    table = read_table("study_runs/table.h5")
    assert list(table.verdicts) == ["fail", "pass", "fail"] and list(table["case/beyond_limits"]) == ["way", "", "way"]
    way, when = table.group("outputs")
    assert way.limits == (3.0, 5.0) and when.limits == (None, 0.3) and table.verdict in out
    report = study_report("study_runs/table.h5")
    limits, governing, cases = (section.parts[0] for section in report.sections[:3])
    assert limits.rows == [
        ("way", "final of ball.position.x", "1, 3", "m", "3", "5"),
        ("when", "time of max of ball.position.x", "none", "s", "", "0.3"),
    ]
    assert cases.marked == {(0, 2), (2, 2)} and not report.sound
    assert [row[3:] for row in governing.rows] == [("2", "1", "6", "3"), ("0.2", "1", "0.2", "1")]
    assert governing.governing == {(0, 5), (0, 6)}  # the times are equal
    assert page_of(report).count('class="number beyond"') == 2
    study = (folder / "study.yaml").read_text()
    (folder / "study.yaml").write_text(study.replace("at_least: 3 m, at_most: 500 cm", "at_most: 7 m"))
    code, out, _ = mecano_process("sweep", "study.yaml", "--collect")
    assert code == 0 and out.startswith("3 cases: 3 complete\n")
    assert set(read_table("study_runs/table.h5").verdicts) == {"pass"}


@pytest.mark.parametrize(
    "limits,place,message",
    [
        ("of: ball.position.x, take: max, at_most: 3 N", "4:56", "'at_most': a length [m] is expected"),
        ("of: ball.position.x, take: time_of_max, at_least: 3 m", "4:65", "'at_least': a time [s] is expected"),
        (
            "of: ball.position.x, take: max, at_least: 3, at_most: 2",
            "4:57",
            "'at_least' must not be greater than 'at_most'",
        ),
    ],
)
def test_limits_that_do_not_fit_are_refused(folder, limits, place, message):
    with pytest.raises(DeckError) as info:
        try_deck(study(folder, f"grid: {{time.end: [1]}}\noutputs: {{a: {{{limits}}}}}"))
    reported = deck_error_text(info.value)
    assert reported.startswith(f"study.yaml:{place}") and message in reported, reported


@pytest.mark.parametrize(
    "limit, said", [("45", "write '45 deg', or '45 rad' if it is meant"), ("45 deg", ""), ("45 rad", ""), ("6", "")]
)
def test_a_limit_of_an_angle_that_looks_like_degrees_needs_a_unit(folder, limit, said):
    (folder / "deck.yaml").write_text((INPUTS / "pendulum.yaml").read_text())
    text = f"grid: {{time.end: [1]}}\noutputs: {{a: {{of: hinge.angle, take: max, at_most: {limit}}}}}"
    if not said:
        try_deck(study(folder, text))
        return
    with pytest.raises(DeckError, match="'at_most' is 45 rad, more than a turn, as the output is an angle") as info:
        try_deck(study(folder, text))
    assert said in deck_error_text(info.value)


@pytest.mark.parametrize("low, high", [(None, 5.0), (3.0, None), (None, None)])
def test_a_missing_output_is_not_within_limits(low, high):
    output = Output("way", "ball.position.x", None, "final", low, high)
    column = Column("outputs", "way", "m", "", np.array([np.nan, 4.0]), (low, high))
    assert within(output.limits, np.nan) == (low is high) and within(output.limits, 4.0)
    assert column.beyond.tolist() == [low is not high, False]


def test_the_unit_of_a_parameter_of_an_included_file(folder):
    """The deck overrides what it includes, also the unit."""
    (folder / "base.yaml").write_text("mecano: 1\nparameters: {height: 2 m, mass: 3 kg, push: 4 kN}\n")
    text = (folder / "deck.yaml").read_text()
    (folder / "deck.yaml").write_text(text.replace("mecano: 1\n", "mecano: 1\ninclude: base.yaml\n", 1))
    (folder / "study.yaml").write_text(HEAD + "grid: {parameters.height: [1, 2], parameters.push: [5]}\n")
    study = read_study(folder / "study.yaml")
    assert units_of(study, read_deck(folder / "deck.yaml")) == {"parameters.height": "m", "parameters.push": "N"}


def test_the_unit_of_an_impulse_is_that_of_the_cases_that_have_one(folder):
    """The last case has none."""
    found = study(folder, """\
        grid: {time.end: [1, 2]}
        set: {output.every: 0.1}
        outputs: {hit: {event: ball closes, take: impulse}}
        """)  # fmt: skip
    table, runs = Table(Folder("runs", found), {}), Folder("runs", found)
    runs.path.mkdir()
    for case, impulses in zip(found.cases, ((2.0, -3.0), ()), strict=True):
        with results_samples.create(runs.file(case, ".h5")) as writer:
            for impulse in impulses:
                writer.append_event(Event(0.1, "ball", "closes", "open", "closed", "N s", impulse, 1.0))
        table.take(case, Record(COMPLETE, 0))
    np.testing.assert_equal(table.numbers, {1: {"hit": 3.0}, 2: {"hit": np.nan}})
    assert table.units == {"hit": "N s"}


def test_an_output_that_a_case_lacks_leaves_the_others(folder):
    outputs = "outputs: {way: {of: cube.position.x, take: max}, end: {of: knee.angle, take: final}}\n"
    found = study(folder, "grid: {time.end: [1]}\n" + outputs)
    table, runs = Table(Folder("runs", found), {}), Folder("runs", found)
    runs.path.mkdir()
    with results_samples.create(runs.file(found.cases[0], ".h5")) as writer:
        results_samples.append(writer, 2)
    table.take(found.cases[0], Record(COMPLETE, 0))
    assert table.numbers == {1: {"end": results_samples.rows_of(2)[11]}} and table.units == {"end": "rad"}
    [memory] = (column for column in table._columns() if column.name == "memory")
    assert np.isnan(memory.values).all(), "it was not measured"


def test_counts_have_whole_ticks():
    status, varied = (
        Column("case", "status", "", "", ["complete"] * 3),
        Column("parameters", "a", "", "", np.arange(3.0)),
    )
    count = Column("outputs", "latches", "", "", np.array([4.0, 4.0, 4.0]))
    [ax] = study_figure(StudyTable("", "", "", (status, varied, count))).axes
    assert [tick for tick in ax.get_yticks() if np.prod(np.array(ax.get_ylim()) - tick) <= 0.0] == [4.0]


def test_rounding_of_an_output_does_not_fill_its_panel():
    """The angle at which latches hold, which differs in the last digits."""
    status, varied = Column("case", "status", "", "", np.array(["complete"] * 3)), np.array([1.0, 2.0, 3.0])
    angle = Column("outputs", "angle", "rad", "", 1.5 + np.array([0.0, 3e-13, -2e-13]))
    columns = (status, Column("parameters", "parameters.friction", "N m", "", varied), angle)
    [ax] = study_figure(StudyTable("", "", "", columns)).axes
    assert ax.get_ylim() == pytest.approx(np.degrees((1.35, 1.65)), rel=1e-9)


def test_varied_values_of_one_key_differ_in_pictures():
    """And the numbers below a panel do not touch one another."""
    values = {
        "place.left.with.k": np.linspace(23043.5, 26988.0, 7),
        "place.right.with.k": np.linspace(23043.5, 26988.0, 7),
    }
    varied = [Column("parameters", name, "N/m", "", found) for name, found in values.items()]
    status = Column("case", "status", "", "", np.array(["complete"] * 7))
    figure = study_figure(StudyTable("", "", "", (status, *varied, Column("outputs", "load", "N", "", np.arange(7.0)))))
    assert [ax.get_xlabel() for ax in figure.axes] == ["left.with.k [N/m]", "right.with.k [N/m]"]
    figure.draw_without_rendering()
    for ax in figure.axes:
        low, high = ax.get_xlim()
        labels = [label for label in ax.get_xticklabels() if low <= label.get_position()[0] <= high]
        boxes = [label.get_window_extent() for label in labels]
        assert all(a.x1 < b.x0 for a, b in pairwise(boxes))


@pytest.mark.parametrize(("values", "joined"), [(5, True), (20, False)])
def test_dots_are_joined_only_along_one_parameter(values, joined):
    """Random cases of two parameters are no function of either."""
    a, b = np.arange(20.0), np.arange(20.0) * 7 % values
    columns = [
        Column("case", "status", "", "", ["complete"] * 20),
        Column("parameters", "a", "", "", a),
        Column("parameters", "b", "", "", b),
        Column("outputs", "x", "", "", a + b),
    ]
    over_a, over_b = study_figure(StudyTable("", "", "", tuple(columns))).axes
    assert [line.get_linestyle() for line in over_a.lines] == (["-"] * values if joined else ["None"])
    assert [line.get_linestyle() for line in over_b.lines] == ["None"]


SPEEDS, ANGLES = np.repeat([10.0, 20.0, 30.0], 2), np.tile([-0.1, 0.1], 3)
COLUMNS = (
    Column("case", "status", "", "", np.array(["complete"] * 6)),
    Column("parameters", "parameters.speed", "m/s", "", SPEEDS),
    Column("parameters", "parameters.steer", "rad", "", ANGLES),
    Column("outputs", "load", "N", "", 1e4 + 100.0 * SPEEDS),
    Column("outputs", "lateral", "m/s2", "", SPEEDS * ANGLES),
)


def test_an_output_over_another():
    """A series for each of the two angles, along which the speeds are joined."""
    [(name, figure)] = requested_figures(StudyTable("Cases", "", "", COLUMNS), ["load:lateral"])
    (ax,) = figure.axes
    assert name == "load-lateral" and (ax.get_xlabel(), ax.get_ylabel()) == ("lateral [m/s2]", "load [kN]")
    assert [line.get_label() for line in ax.lines] == ["-0.1", "0.1"]
    for line, sign in zip(ax.lines, (-1.0, 1.0), strict=True):
        x, y = line.get_data()
        np.testing.assert_allclose(sorted(sign * x), [1.0, 2.0, 3.0])
        np.testing.assert_allclose(y, 10.0 + np.abs(x), rtol=1e-12)  # 100 N per m/s are 1 kN per m/s2
        assert line.get_linestyle() == "-"


def test_outputs_over_a_varied_value():
    """A panel for each; the name of a value is any end of its path."""
    [(name, figure)] = requested_figures(StudyTable("Cases", "", "", COLUMNS), ["load,lateral:speed"])
    assert name == "load_lateral-speed" and figure.axes[-1].get_xlabel() == "speed [m/s]"
    assert [ax.get_ylabel() for ax in figure.axes] == ["load [kN]", "lateral [m/s2]"]
    alone = StudyTable("", "", "", (*COLUMNS[:2], COLUMNS[3]))
    [(_, figure)] = requested_figures(alone, ["load:parameters.speed"])
    assert [line.get_linestyle() for line in figure.axes[0].lines] == ["-"]


@pytest.mark.parametrize(
    ("plot", "said"),
    [
        ("load", "the cases of a study have no time; write Y:X"),
        ("load:speeed", "no output or varied value 'speeed'; did you mean 'speed'?"),
        ("load:lateral:speed", "cannot be understood"),
    ],
)
def test_plots_of_a_study_that_cannot_be(plot, said):
    with pytest.raises((UnknownNameError, UsageError)) as error:
        list(requested_figures(StudyTable("", "", "", COLUMNS), [plot]))
    assert said in str(error.value)


def test_statistics_and_rank_correlations_of_unnamed_cases():
    """Of 1 ... 20 kN with two cases that failed; b falls where the output grows, and says nothing with a."""
    a, load = np.arange(20.0), np.array([*np.arange(1e3, 19e3, 1e3), np.nan, np.nan])
    columns = [
        Column("parameters", "speed", "m/s", "", a**3),
        Column("parameters", "b", "", "", -a),
        Column("parameters", "same", "", "", 0.0 * a),
        Column("outputs", "peak_load", "N", "", load),
        Column("outputs", "no_load", "N", "", 0.0 * a),
    ]
    spread, _, correlation = statistics(StudyTable("", "", "", tuple(columns)))
    assert spread.rows[0] == ("peak load", "kN", "18", "9.5", "5.3385", "1.85", "9.5", "17.15")
    assert correlation.columns == ("output", "speed", "b")
    assert correlation.rows == [("peak load", "1.00", "-1.00"), ("no load", "", "")]
    named = Column("case", "name", "", "", np.array(["x"] * 20, object))
    assert not list(statistics(StudyTable("", "", "", (named, *columns))))
    assert not list(statistics(StudyTable("", "", "", tuple(replace(one, values=one.values[:9]) for one in columns))))


def test_rounding_errors_are_displayed_as_zero():
    """The side load of a symmetric landing beside that of a drift landing, as in the report and the picture."""
    values = {"left": ("N", [4.8e-5, -1e5]), "link": ("N m", [-3.7e-6, 2.0]), "gap": ("N m", [1e-9, np.nan])}
    outputs = tuple(Column("outputs", name, unit, "", np.array(found)) for name, (unit, found) in values.items())
    left, link, gap = displayed_outputs(StudyTable("", "", "", outputs))
    assert left.values.tolist() == [0.0, -1e5] and link.values.tolist() == [-3.7e-6, 2.0]
    np.testing.assert_equal(gap.values, [0.0, np.nan])


def test_limits_and_signals(folder):
    """A case that would never end is stopped by its time, taken up again, stopped by Ctrl-C, and killed for memory."""
    (folder / "study.yaml").write_text(HEAD + "list: [{time.end: 1.0e5}]\n")
    code, out, _ = mecano_process("sweep", "study.yaml", "--time-limit", "3")
    assert code == 3 and "1 cases: 1 stopped\n  1 x exit code 75: stopped by the limit of wall-clock time" in out
    file = folder / "study_runs" / "0001.h5"
    before = file.exists() and file.stat().st_ino
    process = subprocess.Popen([*COMMAND, "sweep", "study.yaml", "--resume", "-q"], stderr=subprocess.PIPE, text=True)
    wait_until(lambda: file.exists() and file.stat().st_ino != before)  # the run has been taken up again
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130 and "continue with: mecano sweep study.yaml -q --resume" in err
    assert read_table("study_runs/table.h5")["case/status"].tolist() == ["stopped"]
    code, out, _ = mecano_process("sweep", "study.yaml", "--resume", "--memory-limit", "20")
    assert code == 3 and "1 x exit code -9: used more than 20 MB of memory" in out


def wait_until(true, seconds=60.0):
    """Wait until something is true; AssertionError when that takes too long."""
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.05)


def test_the_script_of_an_array(folder):
    assert ranges([1, 2, 3, 7, 9, 10]) == "1-3,7,9-10"
    found = study(folder, "grid: {time.end: [1, 2, 3]}")
    text = script(Folder("runs", found), found.cases[1:], Limits(60, 10**9))
    assert "#SBATCH --array=2-3\n" in text and "--time-limit 60" in text and "--memory-limit 1000" in text
    assert subprocess.run(["bash", "-n"], input=text, text=True).returncode == 0


REQUEUED = """\
#!/bin/sh
[ "$1" = info ] && {{ cat steps 2>/dev/null; exit; }}
echo '  run         {steps} steps, 0 rejected' > steps
exit {code}
"""


def script_of_the_page():
    """The script of a long run in docs/cluster.md."""
    page = (INPUTS.parent / "docs" / "cluster.md").read_text()
    return next(text for text in re.findall(r"```bash\n(.*?)```", page, re.DOTALL) if "=long" in text)


@pytest.mark.parametrize("of_page", (True, False), ids=("page", "array"))
@pytest.mark.parametrize(
    ("before", "code", "ended", "requeued"),
    [(0, 75, 75, True), (7, 75, 2, False), (0, 138, 138, True), (7, 152, 2, False), (7, 3, 3, False), (7, 0, 0, False)],
)
def test_a_task_without_progress_is_not_requeued(folder, monkeypatch, of_page, before, code, ended, requeued):
    """A program that always reports 7 steps at its end, and a queue that notes what is put into it."""
    monkeypatch.setattr(slurm, "PROGRAM", ("mecano",))
    text = (
        script_of_the_page()
        if of_page
        else script(Folder("runs", found := study(folder, "grid: {time.end: [1]}")), found.cases, Limits())
    )
    for name, own in (("mecano", REQUEUED.format(steps=7, code=code)), ("scontrol", '#!/bin/sh\necho "$@" > queue\n')):
        (folder / name).write_text(own)
        (folder / name).chmod(0o755)
    (folder / "steps").write_text(f"  run         {before} steps, 0 rejected\n")
    own = {
        "PATH": f"{folder}:{os.environ['PATH']}",
        "SLURM_JOB_ID": "5",
        "SLURM_ARRAY_JOB_ID": "5",
        "SLURM_ARRAY_TASK_ID": "1",
    }
    done = subprocess.run(["bash"], input=text, text=True, env=own, capture_output=True)
    assert done.returncode == ended and (folder / "queue").exists() == requeued
    assert ("no step was made" in done.stderr) == (ended == 2)


def test_the_output_of_tasks_is_one_word_of_the_script(folder):
    """In a folder with blanks and a per cent sign, which begins a number in the patterns of Slurm."""
    found = study(folder, "grid: {time.end: [1]}")
    lines = script(Folder("5 % more", found), found.cases, Limits()).splitlines()
    written = [shlex.split(line)[1:] for line in lines if line.startswith("#SBATCH --output")]
    assert written == [[f"--output={Path.cwd()}/5 %% more/%4a.slurm"]]


def test_the_cases_as_tasks_of_dask(folder):
    """On workers of this machine: one is complete, one fails, one that would never end is ended by Ctrl-C."""
    pytest.importorskip("distributed")
    cases = "list: [{parameters.speed: 10}, {elements.ball.mass: -1}, {time.end: 1.0e5}]\n"
    (folder / "study.yaml").write_text(HEAD + cases + "outputs: {way: {of: ball.position.x, take: final}}\n")
    words = ["sweep", "study.yaml", "--executor", "dask", "--jobs", "2"]
    process = subprocess.Popen([*COMMAND, *words], stderr=subprocess.PIPE, text=True)
    runs = folder / "study_runs"
    wait_until(lambda: all((runs / name).exists() for name in ("0001.json", "0002.json", "0003.h5")))
    process.send_signal(signal.SIGINT)
    err = process.communicate(timeout=60)[1]
    assert process.returncode == 130 and "stopped by SIGINT after 3 of 3 cases; continue with: mecano sweep" in err, err
    table = read_table(runs / "table.h5")
    assert table["case/status"].tolist() == ["complete", "failed", "stopped"] and "Traceback" not in err
    assert table["case/exit_code"].tolist() == [0, 2, 143] and table["outputs/way"][0] == pytest.approx(2.0)


def test_dask_that_is_not_there(folder, monkeypatch):
    runs = Folder("runs", study(folder, "grid: {time.end: [1]}"))
    monkeypatch.setattr(dask, "PATIENCE", 0.5)
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "distributed", None)
        with pytest.raises(UsageError, match=r"not installed: pip install mecano\[dask\]"):
            dask.run_in_tasks(runs, [], None, limits=Limits(), jobs=1)
    pytest.importorskip("distributed")
    for address in ("tcp://127.0.0.1:9", "strange://a"):
        with pytest.raises(UsageError, match=f"no Dask scheduler answers at {address}"):
            dask.run_in_tasks(runs, [], None, limits=Limits(), jobs=1, scheduler=address)


@pytest.mark.parametrize(
    "options,message",
    [
        (["--scheduler", "tcp://127.0.0.1:9"], "--scheduler belongs to --executor dask"),
        (["--wait"], "--sbatch and --wait belong to --executor slurm"),
        (["--executor", "slurm", "--jobs", "2"], "--jobs is for this machine"),
        (["--executor", "slurm", "--sbatch", "--comment='two words"], "'--sbatch': no closing quotation"),
        (["--resume", "--force"], "--force runs all anew"),
        (["--again", "failed", "--force"], "--force runs all anew"),
    ],
)
def test_options_that_are_wrong_or_exclude_each_other(folder, options, message):
    result = CliRunner().invoke(commands, ["sweep", "study.yaml", *options])
    assert result.exit_code == 2 and message in result.output


@pytest.mark.parametrize("executor", ["slurm", "dask"])
@pytest.mark.parametrize("option", [["--force"], ["--again", "failed"]])
def test_no_case_is_deleted_that_cannot_run_again(folder, monkeypatch, executor, option):
    runs = Folder("study_runs", study(folder, "grid: {time.end: [0.1, -1]}"))
    with runs.held():
        for case in runs.study.cases:
            runs.write(case, Record(FAILED, 2))
    monkeypatch.setattr(slurm.shutil, "which", lambda name: None)
    monkeypatch.setattr(dask, "find_spec", lambda name: None)
    result = CliRunner().invoke(commands, ["sweep", "study.yaml", "--executor", executor, *option])
    assert isinstance(result.exception, UsageError), result.output
    assert [runs.record(case).status for case in runs.study.cases] == [FAILED, FAILED]


def test_no_case_is_deleted_if_the_scheduler_does_not_answer(folder, monkeypatch):
    def refuse(address, timeout):
        raise OSError("timed out")

    runs = Folder("study_runs", study(folder, "grid: {time.end: [0.1]}"))
    with runs.held():
        runs.write(runs.study.cases[0], Record(FAILED, 2))
    monkeypatch.setattr(dask, "find_spec", lambda name: True)
    monkeypatch.setitem(sys.modules, "distributed", SimpleNamespace(Client=refuse))
    words = ["sweep", "study.yaml", "--executor", "dask", "--scheduler", "tcp://a:1", "--force"]
    result = CliRunner().invoke(commands, words)
    assert "no Dask scheduler answers at tcp://a:1: timed out" in str(result.exception), result.output
    assert runs.record(runs.study.cases[0]).status == FAILED


SBATCH = """\
#!/bin/sh
ls study_runs > seen
{answer}
"""


@pytest.mark.parametrize("accepts", (True, False))
def test_cases_are_replaced_when_sbatch_has_accepted_the_study(folder, monkeypatch, accepts):
    """The files of cases that start again are gone when tasks may begin, and back if sbatch refuses its options."""
    runs = Folder("study_runs", study(folder, "grid: {time.end: [0.1, -1]}"))
    with runs.held():
        for case in runs.study.cases:
            runs.write(case, Record(FAILED, 2))
            runs.file(case, ".h5").write_text("results")
    answer = "echo Submitted batch job 7" if accepts else "echo invalid partition specified: x >&2; exit 1"
    (folder / "sbatch").write_text(SBATCH.format(answer=answer))
    (folder / "sbatch").chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}:{os.environ['PATH']}")
    result = CliRunner().invoke(commands, ["sweep", "study.yaml", "--executor", "slurm", "--force"])
    assert (folder / "seen").read_text().split() == ["array.sbatch", "replaced"]
    left = [path.name for path in sorted(runs.path.iterdir())]
    if accepts:
        assert result.exit_code == 0 and left == ["array.sbatch"]
    else:
        assert isinstance(result.exception, ResultsError) and "invalid partition" in str(result.exception)
        assert left == ["0001.h5", "0001.json", "0002.h5", "0002.json", "array.sbatch"]
        assert [runs.record(case).status for case in runs.study.cases] == [FAILED, FAILED]


def test_one_case_alone_ends_with_the_exit_code_of_its_run(folder):
    (folder / "study.yaml").write_text(HEAD + "grid: {time.end: [0.1, -1]}\n")
    assert mecano_process("sweep", "study.yaml", "--case", "2")[0] == 2
    code, out, _ = mecano_process("sweep", "study.yaml", "--collect")
    assert code == 3 and "2 cases: 1 failed, 1 waiting" in out
    assert mecano_process("sweep", "study.yaml", "--case", "3")[0] == 2


def test_the_study_of_the_page(folder):
    """That of docs/studies.md: 15 cases, whose deck and outputs there are."""
    text = (Path(__file__).parent.parent / "docs" / "studies.md").read_text()
    (folder / "study.yaml").write_text(re.search(r"```yaml\n(study: 1\n.*?)```", text, re.DOTALL)[1])
    (folder / "nose_gear_rigid.yaml").write_text((INPUTS / "nose_gear_rigid.yaml").read_text())
    found = read_study("study.yaml")
    assert len(found.cases) == 15 and try_deck(found).values["parameters"]["sink"] == -2.0


def test_warmup_knows_all_kinds_and_runs_the_beginning_of_decks(folder):
    assert {kind.name for kind in all_kinds()} > set(KINDS)
    reported = list(warmup(["deck.yaml"], ["parameters.speed=3"]))
    assert reported[0] == "running the first steps of deck.yaml" and str(store.folder()) in reported[-1]
    assert [path.name for path in folder.iterdir()] == ["deck.yaml"]


def test_warmup_compiles_on_a_single_core_what_it_compiles_on_several(monkeypatch):
    """There compile_ahead leaves all to the first use."""
    ahead, used = [], []
    monkeypatch.setattr(warming, "compile_ahead", ahead.extend)
    # a copy, as modules imported meanwhile would keep the function that is replaced
    monkeypatch.setattr(
        warming, "machine_code", SimpleNamespace(**{**vars(warming.machine_code), "address": used.append})
    )
    monkeypatch.setattr(warming, "starters", dict)
    list(warmup())
    assert used == ahead and "mecano.solve.time.radau_step.attempt" in [code.name for code in used]


@pytest.mark.slow
def test_warmup_leaves_nothing_to_be_compiled(tmp_path):
    """Of a deck that it does not contain; some 6 minutes of processor time."""
    environment = {**os.environ, "MECANO_CACHE_DIR": str(tmp_path / "cache")}
    subprocess.run([*COMMAND, "warmup"], env=environment, check=True)
    before = sorted((tmp_path / "cache").rglob("*.o"))
    deck, overrides = INPUTS / "nose_landing_gear.yaml", settings("time.end=0.05")
    subprocess.run([*COMMAND, "run", deck, "-q", "-o", tmp_path / "r.h5", *overrides], env=environment, check=True)
    assert len(before) > 400 and sorted((tmp_path / "cache").rglob("*.o")) == before


def test_values_are_shown_in_usual_units():
    pressure = Column("parameters", "parameters.pressure", "Pa", "", np.array([1.2e6, 1.6e6]))
    shown = legible(pressure)
    assert shown.unit == "kPa" and shown.values.tolist() == [1200.0, 1600.0]
    assert legible(replace(pressure, unit="", values=np.array([1.0, 5.0]))).values.tolist() == [1.0, 5.0]


def test_warnings_that_differ_in_numbers_are_one_row_of_the_report():
    said = "oleo 'strut_{}': oil_pressure reached -{} at t = {} s, but below zero the oil cavitates"
    warnings = [(said.format(1, "6.5e+05", 0.39),), (said.format(1, "81", 0.4),), (said.format(2, "81", 0.4),)]
    [found] = _warnings(SimpleNamespace(case_names=["one", "two", "three"], warnings=warnings))
    assert found.rows == [(warnings[0][0], "2", "one"), (warnings[2][0], "1", "three")]


def test_values_that_are_mappings_have_short_texts_in_pictures():
    band = "{{'stiffness': 5, 'lower': '-{0} mrad', 'upper': '{0} mrad'}}"
    shown = short_texts([band.format(1), band.format(3)])
    assert list(shown.values()) == ["lower -1 mrad, upper 1 mrad", "lower -3 mrad, upper 3 mrad"]
    assert short_texts(["radau", "generalized_alpha"]) == {name: name for name in ("radau", "generalized_alpha")}
    long = short_texts(["a" * 90 + end for end in "xy"])
    assert len(set(long.values())) == 2 and max(map(len, long.values())) <= LONGEST

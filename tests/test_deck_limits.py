"""Decks at the limits: vanishing numbers, long names and chains, files that claim to be huge, models without motion."""

import contextlib
import subprocess
import sys
import time

import numpy as np
import pytest
import yaml

from mecano.analyses.prepare import control_of, prepare
from mecano.deck.compose import compose
from mecano.deck.format import deck_error_text
from mecano.deck.read import deck_of_bytes
from mecano.deck.source import Source
from mecano.errors import DeckError

DECK = """\
mecano: 1
gravity: [0, 0, -9.81]
parameters: {a: 1/3, word: "0.5"}
nodes:
  a: {position: [0, 0, 0], fixed: true}
  b: {position: [1, 0, 0]}
elements:
  m: {type: rigid_body, node: b, mass: 1, inertia: [1, 1, 1]}
  beam: {type: beam, nodes: [a, b], section: s}
sections: {s: {type: circle, diameter: 0.01, E: 2.0e+11, nu: 0.3, density: 7800}}
loads: {f: {type: force, node: b, direction: [1, 0, 0], value: 1.0}}
time: {end: 1, step: 0.1}
output: {every: 0.2}
"""


def values(*changes):
    """Checked values of the deck with texts replaced."""
    text = DECK
    for old, new in changes:
        assert text.count(old) == 1
        text = text.replace(old, new)
    return deck_of_bytes(text.encode(), "deck.yaml").values


def refused(*changes):
    """The text of the one error of such a deck."""
    with pytest.raises(DeckError) as info:
        values(*changes)
    (problem,) = info.value.problems
    assert problem.mark.line and problem.mark.column
    return deck_error_text(info.value).splitlines()[0]


@pytest.mark.parametrize("tiny", ["5e-324", "1e-300", "9.9e-101"])
@pytest.mark.parametrize(
    "old", ["E: 2.0e+11", "step: 0.1", "every: 0.2", "mass: 1", "diameter: 0.01", "position: [1", "value: 1.0"]
)
def test_numbers_that_vanish_are_refused_by_place(old, tiny):
    number = old.replace("[", " ").split()[-1]
    line = 1 + DECK[: DECK.index(old)].count("\n")
    text = refused((old, old.replace(number, tiny)))
    assert text.startswith(f"deck.yaml:{line}:") and "is not zero, but less than 1e-100" in text
    assert ("write 0" in text) == (old in ("position: [1", "value: 1.0"))  # where zero is allowed


def test_numbers_that_vanish_together_are_refused_by_place():
    text = refused(("E: 2.0e+11", "E: 1e-90"), ("diameter: 0.01", "diameter: 1e-50"))
    assert text.startswith("deck.yaml:10:12: circle 's': gives stiffnesses or a mass that overflow or vanish")
    assert "'step' must be at least 1e-12 s here" in refused(("step: 0.1", "step: 1e-13"), ("end: 1", "end: 1"))
    assert "'output.every' must be at least 1e-12 s here" in refused(("every: 0.2", "every: 1e-13"))


def test_more_saved_times_in_a_step_than_can_be_meant_are_refused_with_their_number():
    text = refused(("every: 0.2", "every: 1e-10"))
    assert text.startswith("deck.yaml:13:17: 'output.every' asks for 1e+09 saved times in one step of 'time.step', 0.1")
    assert text.endswith("write 'step', or 1e-06 s or more")
    assert values(("every: 0.2", "every: 1.1e-6"))


@pytest.mark.parametrize(("tolerance", "wrong"), [("9e-13", True), ("1e-12", False)])
def test_tolerances_of_the_motion_below_rounding_are_refused(tolerance, wrong):
    change = "step: 0.1", f"step: 0.1, adaptive: {{tolerance: {tolerance}}}"
    assert ("must lie between 1e-12 and 1" in refused(change)) if wrong else values(change)


@pytest.mark.parametrize(("start", "finest"), [("0", 3.55e-15), ("1e9", 1.91e-6)])
def test_steps_that_rounding_swallows_are_refused(start, finest):
    """16 spacings of floating-point numbers at the greatest time of the run; 2^-52 and 2^-23 s here."""
    time = f"time: {{start: {start}, end: 1e9 + 1, " if start != "0" else "time: {end: 1.5, "
    least = f"'adaptive.minimum_step' must be at least {finest:.3g} s here"
    step = "step: 0.1, adaptive: {tolerance: 1e-3, minimum_step: %g}"
    for share, wrong in ((0.9, True), (1.1, False)):
        change = ("time: {end: 1, ", time), ("step: 0.1", step % (share * finest))
        assert (least in refused(*change)) if wrong else values(*change)


def test_no_step_is_cut_to_less_than_rounding_of_times():
    text = DECK.replace("time: {end: 1, step: 0.1}", "time: {start: 1e9, end: 1e9 + 1, step: 1e-2}")
    for more in ("", ", adaptive: {tolerance: 1e-3}"):
        values = deck_of_bytes(text.replace("1e-2}", f"1e-2{more}}}").encode(), "deck.yaml").values["time"]
        assert 1e9 + control_of(values).minimum > 1e9 + 1e-6


def test_a_million_entries_are_refused_without_reading_them():
    start = time.process_time()
    entries = "".join(f"  n{i}: {{position: [0, 0, 0]}}\n" for i in range(10**6))
    assert "more than 4000000 values" in refused(("  a: {position", entries + "  a: {position"))
    assert time.process_time() - start < 5.0


def test_errors_in_a_long_line_share_its_text():
    """Each with a copy of a line of 1 MB, 20,000 errors took 20 GB, and minutes."""
    source = Source("deck.yaml", "first\n" + "x" * 1000 + "\nlast")
    assert source.mark(1, 3).text is source.mark(1, 7).text and source.mark(0, 0).text == "first"
    assert [source.lines[i] for i in (2, 1, 2)] == ["last", "x" * 1000, "last"] and source.lines[-1] == "last"


def test_an_override_with_a_line_break_in_its_key_has_its_place_in_the_first_line():
    with pytest.raises(DeckError) as info:
        deck_of_bytes(DECK.encode(), "deck.yaml", overrides=["time\u2028\n.end 11"])
    assert deck_error_text(info.value).startswith("override time\\u2028\\n.end 11:1:1: an override is written")


def test_long_lists_are_refused_at_once(monkeypatch):
    """To read 4 million numbers took 20 s and 580 MB; a table in a file takes a hundredth of the time for each."""
    read, parse = [], yaml.parse
    monkeypatch.setattr(
        yaml, "parse", lambda *given, **more: (read.append(1) or event for event in parse(*given, **more))
    )
    text = refused(("value: 1.0", "value: {table: {points: [" + "1, " * 3_000_000 + "1]}}"))
    assert text.startswith("deck.yaml:11:") and "a list of more than 100000 values; put a long table into a CSV" in text
    assert 100_000 < len(read) < 100_200


@pytest.mark.parametrize(
    ("written", "number"),
    [
        ("1/3", 1 / 3), ('"2"', 2.0), ("'1e3'", 1000.0), ("2*pi", 2 * np.pi), ("sqrt(2)/2", np.sqrt(2) / 2),
        ("(1 + 2) * 3", 9.0), ("11/4", 2.75), ("1e3 * 2", 2000.0), ('"0x10"', 16.0), ("$a * 3", 1.0),
        ("$word * 2", 1.0), ("$word", 0.5), ('"3 kg"', 3.0),
    ],
)  # fmt: skip
def test_arithmetic_and_quoted_numbers_are_numbers(written, number):
    assert values(("mass: 1", f"mass: {written}"))["elements"]["m"]["mass"] == pytest.approx(number, rel=1e-15)
    if "kg" not in written:
        assert values(("end: 1", f"end: {written} * 10" if "'" not in written and '"' not in written else "end: 5"))


@pytest.mark.parametrize("written", ["pi", "1_000", "12:30:45", "'1,5'", "one/3", "'-'", "1/", "1//2", "(1", "1 2"])
def test_other_texts_are_no_numbers(written):
    assert refused(("mass: 1", f"mass: {written}")).startswith("deck.yaml:8:")


def test_long_texts_of_digits_are_read_at_once():
    """The pattern of arithmetic does not go back over what it has read."""
    start = time.process_time()
    refused(("mass: 1", "mass: " + "1" * 400 + "x"))
    refused(("mass: 1", "mass: " + "1e" * 200 + "x"))
    assert time.process_time() - start < 1.0


@pytest.mark.parametrize("count", [250, 3000])
def test_long_chains_of_parameters(count):
    chain = ", ".join(f"p{i}: $p{i + 1} + 1" for i in range(count))
    found = values(("parameters: {", f"parameters: {{{chain}, p{count}: 1, "))
    assert found["parameters"]["p0"] == count + 1
    text = refused(("parameters: {", f"parameters: {{{chain}, p{count}: $p0, "))
    assert "p0 -> p1 -> p2" in text


def test_a_model_in_which_nothing_can_move_is_refused():
    text = DECK.replace("position: [1, 0, 0]", "position: [1, 0, 0], fixed: true")
    with pytest.raises(DeckError, match="nothing can move") as info:
        prepare(deck_of_bytes(text.encode(), "deck.yaml"))
    assert str(info.value.problems[0].mark) == "deck.yaml:5:3"


NAMES = ["a" * 303, "z/" * 2500 + "z"]


@pytest.mark.parametrize("name", NAMES, ids=["long", "deep"])
def test_long_names_of_files(name):
    assert "File name too long" in refused(("parameters:", f"include: {name}\nparameters:"))
    assert "File name too long" in refused(("value: 1.0", f"value: {{table: {{file: {name}.csv}}}}"))
    for suffix in ("yaml", "npz", "h5"):
        wing = f"  wing: {{type: superelement, nodes: [a, b], file: {name}.{suffix}}}\nsections:"
        assert "File name too long" in refused(("sections:", wing))


def market(size, entry="1 1 1.0", kind="real"):
    """The text of a Matrix Market file of one entry."""
    return f"%%MatrixMarket matrix coordinate {kind} general\n{size} 1\n{entry}\n".encode()


def npy(shape):
    """The bytes of an .npy file without its numbers."""
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode()


@pytest.mark.parametrize(
    ("name", "data", "text"),
    [
        ("k.mtx", market("999999999 999999999"), "too large"),
        ("k.mtx", market("60000 60000"), "too large"),
        ("k.mtx", market("99999999999999999999999 9"), "out of range"),
        ("k.mtx", market("12 12", "1 1 99999999999999999999999999", "integer"), "out of range"),
        ("k.npy", npy((10**11, 10**8)), "too large"),
        ("k.npy", npy((100_000, 100_000)), "too large"),
    ],
)  # fmt: skip
def test_matrices_that_no_memory_holds(tmp_path, monkeypatch, name, data, text):
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_bytes(data)
    (tmp_path / "wing.yaml").write_text(f"positions: [[0, 0, 0], [1, 0, 0]]\nstiffness: {name}\nmass: {name}\n")
    wing = "  wing: {type: superelement, nodes: [a, b], file: wing.yaml}\nsections:"
    with pytest.raises(DeckError) as info:
        values(("sections:", wing))
    assert text in info.value.problems[0].message and info.value.problems[0].mark.file == "wing.yaml"


def test_archives_that_grow(tmp_path, monkeypatch):
    import h5py

    monkeypatch.chdir(tmp_path)
    np.savez_compressed("bomb.npz", positions=np.zeros((2, 3)), stiffness=np.zeros((3000, 3000)), mass=np.eye(12))
    with h5py.File("bomb.h5", "w") as file:
        file["positions"], file["mass"] = np.zeros((2, 3)), np.eye(12)
        file.create_dataset("stiffness", shape=(10**6, 10**6), dtype=float, chunks=(1000, 1000))
    for name in ("bomb.npz", "bomb.h5"):
        wing = f"  wing: {{type: superelement, nodes: [a, b], file: {name}}}\nsections:"
        assert "too large" in refused(("sections:", wing))


def test_warnings_of_python_stay_off_the_terminal(tmp_path):
    """The compiler of Python warns of a number before a keyword."""
    path = tmp_path / "deck.yaml"
    path.write_text(DECK.replace("mass: 1", "mass: '=1or 2'"))
    done = subprocess.run([sys.executable, "-m", "mecano", "check", path], capture_output=True, text=True)
    assert done.returncode == 2 and "Warning" not in done.stderr and done.stderr.startswith(str(path))


def test_a_long_list_without_brackets_is_refused_quickly():
    """Its items are appended to one value; a formula without quotes is cut, not copied for each of its items."""
    for text in ("1" + ", 2" * 110_000, "max(1" + ", 2" * 110_000 + ")"):
        begun, problems = time.process_time(), []
        with contextlib.suppress(DeckError):
            compose(Source("f", f"a: {{b: {text}}}"), problems)
        assert time.process_time() - begun < 5.0
        assert [problem.message for problem in problems] == ["a key must be a name, got '2'"]

"""Tables from CSV files beside the deck."""

import hashlib
import os
import tracemalloc

import pytest
from deck_samples import FAKE, VALID

from mecano.deck.read import read_deck
from mecano.errors import DeckError

DECK = VALID.replace("points: [[0, 0], [1, 1e3]]", "file: tables/push.csv")


def read_table(folder, data):
    """The deck that takes its load from a table."""
    (folder / "tables").mkdir(exist_ok=True)
    (folder / "deck.yaml").write_text(DECK)
    (folder / "tables" / "push.csv").write_bytes(data if isinstance(data, bytes) else data.encode())
    return read_deck(str(folder / "deck.yaml"), **FAKE)


def test_a_misspelt_file_is_answered_with_a_similar_one(tmp_path):
    (tmp_path / "pushes.csv").write_text("0,0\n1,1\n")
    (tmp_path / "deck.yaml").write_text(DECK.replace("tables/push.csv", "pushs.csv"))
    with pytest.raises(DeckError) as info:
        read_deck(str(tmp_path / "deck.yaml"), **FAKE)
    assert info.value.problems[0].hint == "did you mean 'pushes.csv'?"


@pytest.mark.parametrize(
    "data",
    [
        "0,0\n1,1e3\n",
        "time [s], force [N]\n0, 0\n1, 1000\n",
        "# measured\n\ntime;force\n0;0\n # more\n1;1.0e3",
        "t\tF\r\n0\t0\r\n1\t1000\r\n",
        '\ufeff"time","force"\n"0","0"\n"1","1e3"\n',
        "t,F\r0,0\u20281,1e3\x85",
        '"time\nfrom the start","force [N]"\n0,0\n1,1e3\n',
    ],
)
def test_tables_are_read(tmp_path, data):
    deck = read_table(tmp_path, data)
    ((term, values),) = deck.values["loads"]["push"]["value"]
    assert term == "table" and values["points"].tolist() == [[0.0, 0.0], [1.0, 1000.0]] and values["file"] is None
    assert deck.files == {"tables/push.csv": hashlib.sha256(data.encode()).hexdigest()}
    assert deck.sha256 == hashlib.sha256(DECK.encode()).hexdigest()
    assert deck.resolved()["loads"]["push"]["value"]["table"]["points"] == [[0.0, 0.0], [1.0, 1000.0]]


def test_a_long_table_takes_little_memory(tmp_path):
    """Two numbers of 8 bytes for each row; Python's lists of floats take 128."""
    rows, data = 20_000, "0,0\n1,1e3\n"
    read_table(tmp_path, data)
    long = "".join(f"{i},{i % 7}\n" for i in range(rows))
    tracemalloc.start()
    try:
        deck = read_table(tmp_path, long)
        kept, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert len(deck.values["loads"]["push"]["value"][0][1]["points"]) == rows
    assert kept < 30 * rows


@pytest.mark.parametrize(
    ("data", "place", "text"),
    [
        ("0,0\n1,x\n", "2:3", "must be a finite number, got 'x'"),
        ("0,0\n1,nan\n", "2:3", "must be a finite number, got 'nan'"),
        ("0,0\n1,1e999\n", "2:3", "must be a finite number, got '1e999'"),
        ("t,F\nt,F\n1,2\n", "2:1", "must be a finite number, got 't'"),
        ("0,0\n1,2,3\n", "2:1", "two columns are needed, got 3"),
        ("0,0\n1\n", "2:1", "two columns are needed, got 1"),
        ("0;0\n0,5;1\n", "2:1", "must be a finite number, got '0,5'"),
        ("# only\n", "1:1", "the table has no points"),
        ("a,b\n\n0,0\n# c\n2,1\n1,0\n", "6:1", "the points must have strictly increasing x: point 3 has 1.0 after 2.0"),
        ("0,0\n", "1:1", "the points must hold at least 2 points"),
        (b"0,0\n1,\xff\n", "2:3", "byte 0xff is not UTF-8"),
        (b"0,0\n1,\0\n", "2:3", "character U+0000 is not allowed in a deck"),
        ("0,0\n1," + "1" * 200_000, "2:1", "not valid CSV: field larger than field limit (131072)"),
        ('0,0\n1,"' + "\n" * 200_000, "131074:1", "not valid CSV: field larger than field limit (131072)"),
    ],
)
def test_problems_point_into_the_table(tmp_path, data, place, text):
    with pytest.raises(DeckError) as info:
        read_table(tmp_path, data)
    (problem,) = info.value.problems
    assert str(problem.mark) == f"{tmp_path}/tables/push.csv:{place}"
    assert problem.message.removeprefix("force 'push': ") == text


def test_a_decimal_comma_is_told_from_a_word(tmp_path):
    with pytest.raises(DeckError) as info:
        read_table(tmp_path, "0;0\n1;-1,5e3\n2;two\n")
    hints = [problem.hint for problem in info.value.problems]
    assert hints == ["a decimal point, not a comma: -1.5e3", ""]


def test_several_problems_of_one_table(tmp_path):
    with pytest.raises(DeckError) as info:
        read_table(tmp_path, "0,0\nx,1\n2,y\n3\n")
    assert [problem.mark.line for problem in info.value.problems] == [2, 3, 4]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("none.csv", "file 'none.csv' cannot be read: No such file or directory"),
        ("../push.csv", "file '../push.csv' must lie in the folder of the deck"),
        ("/etc/hostname", "file '/etc/hostname' must lie in the folder of the deck"),
        ("link.csv", "file 'link.csv' must lie in the folder of the deck"),
        ("loop.csv", "file 'loop.csv' cannot be read: Too many levels of symbolic links"),
        ("pipe", "file 'pipe' cannot be read: it is not a regular file"),
        ("''", "file '' cannot be read: it is not a regular file"),
    ],
)
def test_files_that_may_not_be_read(tmp_path, name, text):
    folder = tmp_path / "decks"
    folder.mkdir()
    (tmp_path / "push.csv").write_text("0,0\n1,1\n")
    (folder / "link.csv").symlink_to(tmp_path / "push.csv")
    (folder / "loop.csv").symlink_to(folder / "loop.csv")
    os.mkfifo(folder / "pipe")
    (folder / "deck.yaml").write_text(DECK.replace("tables/push.csv", name))
    with pytest.raises(DeckError) as info:
        read_deck(folder / "deck.yaml", **FAKE)
    (problem,) = info.value.problems
    assert problem.message == f"force 'push': {text}"
    assert problem.mark.text[problem.mark.column - 1 :].startswith(name)


def test_either_points_or_file(tmp_path):
    (tmp_path / "deck.yaml").write_text(DECK.replace("file: tables", "points: [[0, 0], [1, 1]], file: tables"))
    with pytest.raises(DeckError, match="give either 'points' or 'file', not both"):
        read_deck(tmp_path / "deck.yaml", **FAKE)


def test_a_table_used_twice_is_read_and_reported_once(tmp_path):
    text = DECK.replace("smooth: 0.8", "smooth: {table: {file: tables/push.csv}}")
    (tmp_path / "tables").mkdir()
    (tmp_path / "deck.yaml").write_text(text)
    (tmp_path / "tables" / "push.csv").write_text("0,0\n1,x\n")
    with pytest.raises(DeckError) as info:
        read_deck(tmp_path / "deck.yaml", **FAKE)
    assert len(info.value.problems) == 1
    (tmp_path / "tables" / "push.csv").write_text("0,0\n1,2\n")
    assert len(read_deck(tmp_path / "deck.yaml", **FAKE).files) == 1


def read_columns(folder, data, more):
    """The points of the load from a table, with further keys beside ``file``."""
    (folder / "deck.yaml").write_text(DECK.replace("tables/push.csv", f"push.csv, {more}" if more else "push.csv"))
    (folder / "push.csv").write_text(data)
    deck = read_deck(str(folder / "deck.yaml"), **FAKE)
    assert "file" not in deck.resolved()["loads"]["push"]["value"]["table"]
    return deck.values["loads"]["push"]["value"][0][1]["points"].tolist()


WIDE = "time [ms], note, load (kN), speed (of the head) [km/h]\n0, a, 1, 36\n500, b, 2.5, 72\n"


@pytest.mark.parametrize(
    ("data", "more", "points"),
    [
        ("t [ms],F [kN]\n0,0\n20,3\n", "", [[0.0, 0.0], [0.02, 3000.0]]),
        (WIDE, "columns: [time, load]", [[0.0, 1000.0], [0.5, 2500.0]]),
        (WIDE.replace("km/h", "cN"), "columns: [time, speed (of the head)]", [[0.0, 0.36], [0.5, 0.72]]),
        (WIDE, "columns: [3, 3]", [[1000.0, 1000.0], [2500.0, 2500.0]]),
        (WIDE, "columns: [1, 3], units: [s, N]", [[0.0, 1.0], [500.0, 2.5]]),
        ("0,0\n20,3\n", "units: [mm, kN]", [[0.0, 0.0], [0.02, 3e3]]),
        ("0;7;0\n20;7;3\n", "columns: [1, 3]", [[0.0, 0.0], [20.0, 3.0]]),
        ("t (measured),F\n0,0\n1,3\n", "", [[0.0, 0.0], [1.0, 3.0]]),
    ],
)
def test_columns_and_units(tmp_path, data, more, points):
    assert read_columns(tmp_path, data, more) == [pytest.approx(point, rel=1e-15) for point in points]


@pytest.mark.parametrize(
    ("data", "more", "place", "text"),
    [
        (
            WIDE,
            "",
            "push.csv:1:1",
            "two columns are needed, got 4; choose with 'columns: [x, y]' from time, note, load, speed",
        ),
        (
            "1,2,3\n",
            "",
            "push.csv:1:1",
            "two columns are needed, got 3; choose with 'columns: [x, y]' from numbers from 1 to 3",
        ),
        (WIDE, "columns: [time, laod]", "deck.yaml:20:82", "the table has no column 'laod'; did you mean 'load'?"),
        (WIDE, "columns: [0, 1]", "deck.yaml:20:76", "the table has 4 columns, numbered from 1, and no 0"),
        ("1,2,3\n", "columns: [t, 1]", "deck.yaml:20:76", "the table has no column 't'; the table has no headers"),
        (WIDE, "columns: [time, note]", "push.csv:2:4", "must be a finite number, got 'a'"),
        (WIDE + "7\n", "columns: [time, load]", "push.csv:4:1", "the row has 1 columns, and column 3 is needed"),
        ("t [fortnight],F\n0,0\n", "", "push.csv:1:4", "unit of a column: 'fortnight' is not a unit; or give 'units"),
        (
            WIDE,
            "columns: [time, load], units: [s, kn]",
            "deck.yaml:20:100",
            "unit of a column: 'kn' is not a unit; did you mean",
        ),
        (WIDE, "columns: [1, 4]", "push.csv:1:50", "unit of a column: a force [N] is expected, and 'km/h' is a speed"),
        (
            "0,0\n20,3\n",
            "units: [mm, bar]",
            "deck.yaml:20:78",
            "unit of a column: a force [N] is expected, and 'bar' is",
        ),
        (WIDE, "columns: [time]", "deck.yaml:20:75", "'value.table.columns' must be a list of 2 column headers"),
        (
            WIDE.replace("500", "0"),
            "columns: [time, load]",
            "push.csv:3:1",
            "the points must have strictly increasing x",
        ),
    ],
)
def test_wrong_columns_and_units(tmp_path, data, more, place, text):
    with pytest.raises(DeckError) as info:
        read_columns(tmp_path, data, more)
    problem, *_ = info.value.problems
    assert str(problem.mark).removeprefix(f"{tmp_path}/") == place
    assert f"{problem.message}; {problem.hint}".removeprefix("force 'push': ").startswith(text)

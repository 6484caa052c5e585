"""Bytes and YAML: texts that are read, and texts refused before interpretation."""

import os

import pytest
import yaml
from deck_samples import FAKE, VALID

from mecano.deck.compose import MAX_DEPTH, compose
from mecano.deck.read import deck_of_bytes, read_deck
from mecano.deck.scalar import resolved
from mecano.deck.source import Source
from mecano.errors import DeckError

LOADERS = [yaml.SafeLoader] + ([yaml.CSafeLoader] if yaml.__with_libyaml__ else [])


def plain(node):
    """The values of a tree of nodes."""
    if isinstance(node.value, dict):
        return {key: plain(value) for key, (_, value) in node.value.items()}
    return [plain(item) for item in node.value] if isinstance(node.value, list) else node.value


@pytest.mark.parametrize(
    ("text", "value"),
    [
        # YAML 1.2.2, section 10.3.2 (core schema)
        ("7e10", 7e10), ("1e5", 1e5), ("1.0e5", 1e5), ("-.5", -0.5), ("1.", 1.0), ("+12", 12), ("012", 12),
        ("0o14", 12), ("0xFF", 255), ("1E-3", 1e-3), ("0", 0), ("-0.0", 0.0),
        ("true", True), ("False", False), ("null", None), ("~", None), ("", None),
        ("no", "no"), ("yes", "yes"), ("on", "on"), ("off", "off"), ("12:30:45", "12:30:45"), ("1_000", "1_000"),
        ("1,5", "1,5"), ("0b11", "0b11"), ("-0x1", "-0x1"), ("1e", "1e"), (".", "."), ("-", "-"), ("nan", "nan"),
        ("inf", "inf"), ("2026-01-01", "2026-01-01"), ("٣", "٣"), ("1d-3", "1d-3"),
    ],
)  # fmt: skip
def test_plain_scalars(text, value):
    found = resolved(text)
    assert found == value and type(found) is type(value)


def test_numbers_beyond_the_floats_are_infinite():
    assert resolved("1e400") == float("inf") == resolved("9" * 5000) == resolved("0x" + "f" * 500)
    assert resolved("-.inf") == -float("inf") and resolved(".NaN") != resolved(".NaN")
    assert resolved("12345678901234567890") == 12345678901234567890.0


@pytest.mark.parametrize("loader", LOADERS)
def test_tree_and_marks(loader):
    problems = []
    text = 'a: &x [1, "2", {b: no}]\nc: *x\nd: |\n  text\n"é": 3\n'
    root = compose(Source("f", text), problems, loader)
    assert problems == []
    assert plain(root) == {"a": [1, "2", {"b": "no"}], "c": [1, "2", {"b": "no"}], "d": "text\n", "é": 3}
    key, value = root.value["é"]
    assert (str(key.mark), str(value.mark)) == ("f:5:1", "f:5:6")
    assert str(root.value["a"][1].value[2].value["b"][1].mark) == "f:1:20"
    assert value.mark.text == '"é": 3'


HOSTILE = {
    "[" * 200_000: f"nested more than {MAX_DEPTH} levels deep",
    "{a: " * 200_000: f"nested more than {MAX_DEPTH} levels deep",
    "- " * 5_000: f"nested more than {MAX_DEPTH} levels deep",
    "a: &x [1, *x]": "alias '*x' is inside the value that it refers to",
    "a: &x {b: [*x]}": "alias '*x' is inside the value that it refers to",
    "a: *x": "unknown alias '*x'",
    "a: &top 1\nb: *tpo": "unknown alias '*tpo'",
    "a: 1\n---\nb: 2": "a deck is one YAML document; this is the second",
    "a: [1, 2": "not valid YAML",
    "a: b: c": "not valid YAML: mapping values are not allowed",
    "a: @b": "not valid YAML",
    "a: !!python/object/apply:os.system [ls]": "tags such as 'tag:yaml.org,2002:python/object/apply:os.system'",
    "a: !x 1": "tags such as '!x' are not used in decks",
    "a: 1\na: 2": "duplicate key 'a', first given in line 1",
    "1: 2": "a key must be a name, got '1'",
    "? [a, b]\n: 2": "a key must be a name, got a list or mapping",
    "true: 2": "a key must be a name, got 'true'",
    "&a a: 1\n*a : 2": "duplicate key 'a'",
    'a: "\\0"': "control characters are not allowed",
    'a: "\\e[31m"': "control characters are not allowed",
}  # fmt: skip


@pytest.mark.parametrize("loader", LOADERS)
@pytest.mark.parametrize("text", HOSTILE, ids=range(len(HOSTILE)))
def test_hostile_yaml(text, loader):
    if loader is yaml.SafeLoader and len(text) > 100_000:
        text = text[:2000]  # the pure loader is slow
    problems = []
    try:
        compose(Source("f", text), problems, loader)
    except DeckError as error:
        problems = error.problems
    assert problems[-1].message.startswith(HOSTILE[text] if text in HOSTILE else "nested more than")
    assert problems[-1].mark.line >= 1 and problems[-1].mark.file == "f"


@pytest.mark.parametrize("loader", LOADERS)
@pytest.mark.parametrize("text", ['a: "\\uD800"', 'a: "\\UFFFFFFFF"', "a: \tb\n\tc: 1", "%FOO", "%YAML 1.2", "'"])
def test_odd_yaml_is_refused_or_read(text, loader):
    problems = []
    try:
        compose(Source("f", text), problems, loader)
    except DeckError as error:
        problems = error.problems
    assert all(problem.mark is not None for problem in problems)


@pytest.mark.parametrize("loader", LOADERS)
def test_aliases_may_not_explode(loader):
    lines = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 9)]
    with pytest.raises(DeckError, match="aliases expand to more than 100000 values"):
        compose(Source("f", "\n".join(lines)), [], loader)
    deep = ["a0: &a0 [1]"] + [f"a{i}: &a{i} [*a{i - 1}]" for i in range(1, 100)]
    with pytest.raises(DeckError, match="nested more than"):
        compose(Source("f", "\n".join(deep)), [], loader)


SLIPS = {  # what is wrong -> what would be right
    "a: 1\n!include b.yaml\nc: 1": "write 'include: FILE' in line 2",
    "mecano:1\ntitle: x": "write a space after 'mecano:' in line 1",
    "mecano 1\ntitle: x": "write ': ' after 'mecano' in line 1",
    "time:\n  end 2\n  step: 1": "write ': ' after 'end' in line 2",
    "a:\n  mass = 2 kg\n  c: 1": "write ': ' after 'mass' in line 2",
    "a:\n  * b\n": "an item of a list begins with '-', not with '*'",
    "a:\n  type: body:\n  c: 1": "delete the ':' at the end of the line",
    "nodes\n  a: {b: 1}": "write ': ' after 'nodes' in line 1",
    "nodes:\n  a {b: [1]}": "write ': ' after 'a'",
    "nodes:\n  a = {b: [1]}": "write ': ' after 'a'",
    "nodes: {a [1, 2]}": "write ': ' after 'a'",
    "nodes: {a:[1, 2]}": "write a space after ':'",
    "nodes:\n  a: 1\n  - b: 2": "an entry of a mapping begins with its name, not with '-'",
    "- a: 1\nb: 2": "lines above begin with '-', as items of a list",
    " a: 1\nb: 2": "keys that belong together begin in the same column",
    "// deck\na: 1": "comments begin with '#', not as in line 1",
    "% deck\na: 1": "comments begin with '#'",
    'a: "C:\\data"': "within double quotes a \\ begins an escape; use single quotes",
    "a: 'It's'\nb: 1": "within single quotes an apostrophe is written twice",
    "a: {b: ${c}}": "a parameter is written without brackets: $name",
    "a: {b: 1 [kg], c: 2}": "a unit is written without brackets: 2 kN/m",
    "a: {b: [1, 2] m}": "write ',' before it; in a list each number has its own unit",
    "a: {b: 1; c: 2}": "write ',' instead of ';'",
    "a: {b: 1 c: 2}": "write ',' before 'c'",
    "a: {b: 1,, c: 2}": "there is nothing before the ','",
    "a: {b: 1 # total, c: 2}\nd: 3": "the bracket opened in line 1 is not closed before this; "
    "the '#' in line 1 begins a comment",
}


@pytest.mark.parametrize("text", SLIPS)
def test_slips_get_hints(text):
    with pytest.raises(DeckError) as info:
        compose(Source("f", text), [])
    assert info.value.problems[-1].hint == SLIPS[text]


def test_tab_gets_a_hint():
    with pytest.raises(DeckError) as info:
        compose(Source("f", "a:\n\tb: 1\n"), [])
    assert info.value.problems[0].hint == "indent with spaces, not with tabs"


def test_results_in_place_of_a_deck_get_a_hint(tmp_path):
    results = tmp_path / "run.h5"
    results.write_bytes(b"\x89HDF\r\n\x1a\n".ljust(65 * 2**20))  # larger than any deck
    with pytest.raises(DeckError, match="the results of a run, not a deck") as info:
        read_deck(results)
    assert info.value.problems[0].hint.endswith(f"take the deck and --at {results}:TIME, in Python at=")


@pytest.mark.parametrize(
    ("data", "place", "text"),
    [
        (b"mecano: 1\ntitle: \xff\n", "d:2:8", "byte 0xff is not UTF-8"),
        ("mecano: 1\n".encode("utf-16"), "d:1:1", "byte 0xff is not UTF-8"),
        (b"a: \xed\xa0\x80", "d:1:4", "byte 0xed is not UTF-8"),  # a lone surrogate
        ("é: 1\r\nb: \0".encode(), "d:2:4", "character U+0000 is not allowed in a deck"),
        ("a: \ufeffb".encode(), "d:1:4", "character U+FEFF is not allowed in a deck"),
        (b"a: \x1b[31m", "d:1:4", "character U+001B is not allowed in a deck"),
        (b"", "d:1:1", "the deck is empty"),
        (b"# nothing\n", "d:1:1", "the deck is empty"),
        (b"- 1\n", "d:1:1", "a deck is a mapping of sections"),
        (b"x", "d:1:1", "a deck is a mapping of sections"),
    ],
)
def test_bytes_and_top(data, place, text):
    with pytest.raises(DeckError) as info:
        deck_of_bytes(data, "d", **FAKE)
    assert [(str(p.mark), p.message) for p in info.value.problems] == [(place, text)]


def test_byte_order_mark_and_line_ends_are_read():
    assert deck_of_bytes(b"\xef\xbb\xbf" + VALID.replace("\n", "\r\n").encode(), "d", **FAKE).values["mecano"] == 1


def test_files_that_cannot_be_read(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path, reason in (
        (tmp_path / "none.yaml", "No such file or directory"),
        (tmp_path, "it is not a regular file"),
        (tmp_path / "pipe", "it is not a regular file"),
        (tmp_path / ("x" * 5000), "File name too long"),
        ("a\0b", "embedded null byte"),
    ):
        with pytest.raises(DeckError) as info:
            read_deck(path, **FAKE)
        assert info.value.problems[0].message == f"the deck cannot be read: {reason}"
        assert info.value.exit_code == 2


def test_too_large_file(tmp_path, monkeypatch):
    monkeypatch.setattr("mecano.deck.source.MAX_BYTES", 100)
    (tmp_path / "deck.yaml").write_text(VALID)
    with pytest.raises(DeckError, match="larger than"):
        read_deck(tmp_path / "deck.yaml", **FAKE)


def test_too_many_values(monkeypatch):
    monkeypatch.setattr("mecano.deck.compose.MAX_NODES", 10)
    with pytest.raises(DeckError, match="more than 10 values"):
        compose(Source("f", VALID), [])

"""The README: short, its links are valid, its deck runs, its numbers agree with their source pages."""

import re
from pathlib import Path

from mecano.deck.read import read_deck
from mecano.deck.sample_decks import examples

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
DECK = re.search("^```yaml\n(.*?)^```", TEXT, re.DOTALL | re.MULTILINE)[1]


def test_it_is_short():
    assert len(TEXT.split()) <= 600
    assert len(DECK.splitlines()) == 10
    blocks = re.findall("^```[a-z]*\n(.*?)^```", TEXT, re.DOTALL | re.MULTILINE)
    assert max(len(line) for block in blocks for line in block.splitlines()) <= 66  # fit beside the pictures
    for picture, percent in re.findall('<img src="(.*?)" align="right" width="(.*?)%"', TEXT):
        assert (ROOT / picture).stat().st_size < 1_000_000 and int(percent) < 40  # text fits beside it, on phones, too
    assert TEXT.count("<img") == TEXT.count('%" alt=') == 3


def test_its_links_lead_to_files():
    links = re.findall(r"\]\((.*?)\)", TEXT)
    assert len(links) > 20 and all((ROOT / link).exists() for link in links)
    assert "docs/python.md" in links


def test_its_deck_is_the_example_of_that_name(tmp_path):
    (tmp_path / "pendulum.yaml").write_text(DECK)
    shown, known = (read_deck(path).values for path in (tmp_path / "pendulum.yaml", ROOT / "inputs/pendulum.yaml"))
    assert {key for key in shown if shown[key] != known[key]} == {"title"}


def test_its_lines_of_python_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pendulum.yaml").write_text(DECK)
    [code] = re.findall("^```python\n(.*?)^```", TEXT, re.DOTALL | re.MULTILINE)
    names = {}
    exec(code, names)
    with names["results"] as results:
        assert results.status == "complete" and results.time[-1] == 1.0


def test_its_numbers_are_those_of_their_pages():
    speeds = (ROOT / "docs/benchmarks.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (?:chain|four-bar).*\|$", TEXT, re.MULTILINE)
    assert len(rows) == 3 and all(row in speeds for row in rows)  # without their last columns
    assert f"one\nof {len(examples())} decks" in TEXT

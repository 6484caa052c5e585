"""The tutorial can be followed: its decks are valid, its commands run, and the outputs shown are those printed."""

import re
import shlex
import signal
from pathlib import Path

import pytest
from click.testing import CliRunner
from process import flowing

from mecano.cli import commands
from mecano.deck.format import deck_error_text

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)([^\n]*)\n(.*?)^```", TEXT, re.DOTALL | re.MULTILINE)


@pytest.fixture(autouse=True)
def handlers():
    """A run sets handlers of signals, which are the test's own."""
    kept = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in kept.items():
        signal.signal(number, handler)


def test_the_tutorial_can_be_followed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert {language for language, _, _ in BLOCKS} == {"yaml", "sh", "text"}
    output = ""
    for language, mark, text in BLOCKS:
        if language == "yaml":
            (tmp_path / text.splitlines()[0].removeprefix("# ")).write_text(text, encoding="utf-8")
        elif language == "sh":
            output = flowing("\n".join(said(line, mark.strip()) for line in text.splitlines()))
        else:
            assert all(flowing(line) in output for line in text.splitlines()), text


def said(line, mark):
    """Return the output of a command; of one marked as long, only the arguments are parsed."""
    program, *arguments = shlex.split(line)
    assert program == "mecano"
    if mark == "parsed":
        commands.commands[arguments[0]].make_context(arguments[0], arguments[1:])
        assert not arguments[1].startswith("inputs/") or (ROOT / arguments[1]).exists()
        return ""
    result = CliRunner().invoke(commands, arguments)
    if mark == "fails":
        return deck_error_text(result.exception)
    assert result.exception is None, (line, result.output, result.exception)
    return result.output

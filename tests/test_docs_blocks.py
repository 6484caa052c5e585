"""Fragments of decks and commands on all pages are valid: fields and kinds exist, options are accepted."""

import re
import shlex
from pathlib import Path

import pytest
import yaml

from mecano.cli import commands
from mecano.deck.expanded_sections import REPEAT
from mecano.deck.read import deck_of_bytes
from mecano.elements import KINDS

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), *sorted((ROOT / "docs" / "examples").glob("*.md"))]
BLOCK = re.compile(r"^```(yaml|sh|)[^\n]*\n(.*?)^```", re.DOTALL | re.MULTILINE)
EVERY = {"type", REPEAT.name}


def blocks(page, *languages):
    return [text for language, text in BLOCK.findall(page.read_text(encoding="utf-8")) if language in languages]


def fragments(text):
    """Return the mappings of a block; alternatives below one another, with the same key, are separate."""
    alternatives = re.split(r"^(?=\w+:)", text, flags=re.MULTILINE)
    parts = [yaml.safe_load(part) for part in alternatives if part.strip()]
    return [part for part in parts if isinstance(part, dict)]


def kinds_in(node):
    """Yield the mappings at any depth that have a type which is a kind."""
    if isinstance(node, dict):
        if node.get("type") in KINDS:
            yield node
        for value in node.values():
            yield from kinds_in(value)
    elif isinstance(node, list):
        for value in node:
            yield from kinds_in(value)


def test_pages_have_blocks():
    """Half of their number: the tests below would pass without any."""
    texts = [text for page in PAGES for text in blocks(page, "sh", "")]
    assert sum(len(blocks(page, "yaml")) for page in PAGES) > 35
    assert sum("mecano " in text for text in texts) > 28


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_fragments_of_decks_have_fields_that_exist(page):
    for text in blocks(page, "yaml"):
        for fragment in fragments(text):
            for entry in kinds_in(fragment):
                fields = {field.name for field in KINDS[entry["type"]].fields}
                assert set(entry) <= fields | EVERY, (entry["type"], set(entry) - fields - EVERY)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_complete_decks_are_valid(page):
    """Decks that begin with their version; those on the page of plugins need the kinds defined there."""
    for text in blocks(page, "yaml"):
        if re.search("^mecano: 1", text, re.MULTILINE) and page.stem != "plugins":
            assert deck_of_bytes(text.encode(), "deck.yaml").values["nodes"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_commands_are_accepted(page):
    for text in blocks(page, "sh", ""):
        for line in re.sub(r"\\\n *", " ", text).splitlines():
            if line.startswith("mecano ") and "..." not in line:
                check_command(line)


def check_command(line):
    name, *arguments = shlex.split(re.split(r" \| | && | > ", line)[0], comments=True)[1:]
    if name.startswith("-"):
        return
    known = {option for parameter in commands.commands[name].params for option in parameter.opts}
    options = [word.split("=")[0] for word in arguments if re.fullmatch(r"--?[a-z][^ ]*", word)]
    assert set(options) <= known | {"--help"}, line

"""The documentation builds to a site without a warning, and the site loads nothing from other servers."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote

import pytest
from verification import Verify

from mecano.cli import commands
from mecano.elements import KINDS

ROOT = Path(__file__).parent.parent
FASTER = """
import gc

gc.disable()

def setup(app):
    app.connect("builder-inited", without_search)
    app.connect("html-page-context", without_navigation, priority=1)

def without_search(app):
    app.builder.search = False

def without_navigation(app, page, template, context, doctree):
    if page != "index":
        context["toctree"] = lambda **options: ""
"""  # an extension that omits the index of words, and the list of all pages on each: half of the time


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The built site; of a copy, so that nothing is written beside the sources, and with two numbers of tests."""
    pytest.importorskip("sphinx")
    pytest.importorskip("furo")
    folder = tmp_path_factory.mktemp("site")
    for name in ("docs", "inputs"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("generated"))
    reported = []
    Verify(reported)("Rolling", "disc: speed [m/s]", [2.0, 3.00000001], [2.0, 3.0], "closed form", relative=1e-8)
    Verify(reported).second_order("Shocks", "a ball", 1.04, 1.01, 1.0, 1e-3, "its flight")
    (folder / "build").mkdir()
    (folder / "build" / "verification.json").write_text(json.dumps([record for _, record in reported]))
    (folder / "faster.py").write_text(FASTER)
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-D", "extensions=myst_parser,faster"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])}
    words = [*command, folder / "docs", folder / "built"]
    built = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    return folder / "built"


def test_every_kind_has_a_page_with_its_fields_and_outputs(site):
    for kind in KINDS.values():
        if kind.section:
            page = (site / "generated" / "reference" / f"{kind.name}.html").read_text(encoding="utf-8")
            for name in (*(field.name for field in kind.fields), *(output.name for output in kind.outputs)):
                assert f">{name}<" in page, f"{kind.name}: {name}"


def test_formulas_are_drawn_by_the_browser_alone(site):
    pages = {path.stem: path.read_text(encoding="utf-8") for path in (site / "generated" / "reference").glob("*.html")}
    assert "<math" in pages["hinge"]
    for name, page in pages.items():
        assert not re.search(r":math:|\{math\}|\.\. math|mathjax", page), name


def test_every_deck_has_a_picture_that_leads_to_it(site):
    page = (site / "generated" / "decks.html").read_text(encoding="utf-8")
    pictures = ROOT / "docs" / "images" / "gallery"
    decks = {path.stem for path in (ROOT / "inputs").glob("*.yaml")}
    assert {path.stem.removesuffix("_film") for path in pictures.iterdir()} == decks
    for path in pictures.iterdir():
        assert path.stat().st_size < (150_000 if path.stem.endswith("_film") else 40_000), path.name
    shown = re.findall(r'href="[^"]*/(\w+)\.yaml"><span[^>]*><img [^>]*src="[^"]*/(\w+?)(?:_film)?\.webp"', page)
    assert {deck for deck, _ in shown} == decks and all(deck == picture for deck, picture in shown)


def test_the_evidence_is_that_of_its_pages(site):
    page = (site / "generated" / "trust.html").read_text(encoding="utf-8")
    points = re.search(r"\|  \| all \|.*\| ([\d.]+ of 100) \|", (ROOT / "docs/reliability.md").read_text())[1]
    for shown in ("lists 2 comparisons", "<td><p>Rolling</p></td>", f"{points} points", "chain-100", "scipy"):
        assert shown in page, shown


def test_pages_ask_for_nothing_from_elsewhere(site):
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        asked = re.findall(r"<(?:script|img|iframe)[^>]*\bsrc=\"([^\"]*)\"", text)
        asked += re.findall(r"<link[^>]*rel=\"stylesheet\"[^>]*href=\"([^\"]*)\"", text)
        assert not [address for address in asked if re.match(r"(https?:)?//", address)], page.name


def test_pages_and_pictures_that_are_linked_exist(site):
    for page in site.rglob("*.html"):
        if page.name != "search.html":
            text = page.read_text(encoding="utf-8")
            addresses = re.findall(r"<(?:a|img|script)[^>]*\b(?:href|src)=\"([^\"#?:]+)[\"#?]", text)
            missing = {address for address in addresses if not (page.parent / unquote(address)).exists()}
            assert not missing, f"{page.name}: {missing}"


def test_the_manual_shows_the_values_reported_by_tests(site):
    page = (site / "generated" / "verification.html").read_text(encoding="utf-8")
    for shown in ("3.00000001", "disc: speed [m/s], 2 numbers", "order 2.00", "its flight", "verification_shocks.svg"):
        assert shown in page


def test_a_number_beyond_its_tolerance_fails_and_is_reported():
    reported = []
    with pytest.raises(AssertionError, match="speed"):
        Verify(reported)("Rolling", "speed", 1.1, 1.0, "closed form", relative=0.01)
    assert reported[0][1]["error"] == pytest.approx(0.1)


def test_every_command_and_option_is_on_the_page_of_commands(site):
    page = (site / "generated" / "commands.html").read_text(encoding="utf-8")
    for name, command in commands.commands.items():
        assert f">mecano {name}<" in page
        options = [param for param in command.params if param.param_type_name == "option"]
        assert all(name in page for option in options for name in option.opts)

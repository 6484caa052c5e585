"""The documentation builds to a site without a warning, and the site asks for nothing from elsewhere."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from mecano.elements import KINDS

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The built site; of a copy, so that nothing is written beside the sources."""
    pytest.importorskip("sphinx")
    pytest.importorskip("furo")
    folder = tmp_path_factory.mktemp("site")
    for name in ("docs", "inputs"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("generated"))
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", folder / "docs", folder / "built"]
    built = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    return folder / "built"


def test_every_kind_has_a_page_with_its_fields_and_outputs(site):
    for kind in KINDS.values():
        if kind.section:
            page = (site / "generated" / "reference" / f"{kind.name}.html").read_text(encoding="utf-8")
            for name in (*(field.name for field in kind.fields), *(output.name for output in kind.outputs)):
                assert f">{name}<" in page, f"{kind.name}: {name}"


def test_formulas_are_drawn_by_the_browser_alone(site):
    page = (site / "generated" / "reference" / "hinge.html").read_text(encoding="utf-8")
    assert "<math" in page and ":math:" not in page and "mathjax" not in page.lower()


def test_pages_ask_for_nothing_from_elsewhere(site):
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        asked = re.findall(r"<(?:script|img|iframe)[^>]*\bsrc=\"([^\"]*)\"", text)
        asked += re.findall(r"<link[^>]*rel=\"stylesheet\"[^>]*href=\"([^\"]*)\"", text)
        assert not [address for address in asked if re.match(r"(https?:)?//", address)], page.name

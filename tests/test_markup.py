"""Titles and names of files that look like markup are plain text in reports, animations and pictures."""

import json
import re
from html.parser import HTMLParser
from xml.etree import ElementTree

import pytest
from time_runs import deck

from mecano.analyses.dynamic import run
from mecano.post.animation import animate
from mecano.post.pictures import post
from mecano.post.report_page import write_report

TITLE = """<!--<script>alert(1)</script> "a" & 'b' $\\frac{x$ </title><marquee onload=x> --> ]]>"""
NAME = "<i>&<i>.h5"  # of the file; those of a deck cannot have such letters


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    text = f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        title: {json.dumps(TITLE)}
        nodes: {{a: {{position: [0, 0, 1]}}}}
        elements: {{b: {{type: point_mass, node: a, mass: 2}}}}
        time: {{end: 0.1, step: 1.0e-2}}
    """
    path = tmp_path_factory.mktemp("markup") / NAME
    run(deck(text), path)
    return path


class Page(HTMLParser):
    """Elements of a page, and the text that stands in some of them."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.attributes, self.texts = [], [], {}
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.attributes += [name for name, _ in attributes]

    def handle_data(self, text):
        self.texts[self.tags[-1] if self.tags else ""] = self.texts.get(self.tags[-1] if self.tags else "", "") + text

    def handle_comment(self, text):
        assert "alert" not in text


def test_a_report(path):
    page = Page(write_report(path, path.with_name("report.html")).read_text())
    assert not {"marquee", "i", "script"} & set(page.tags) and "onload" not in page.attributes
    assert page.texts["title"].strip() == TITLE and page.tags.count("title") == 1


def test_the_page_of_an_animation(path):
    text = animate(path, path.with_name("motion.html")).read_text()
    (line,) = re.findall(r"const data = .*", text)
    assert not set("<>&") & set(line)
    data = json.loads(line.removeprefix("const data = ").rstrip(";"))
    assert data["title"] == TITLE
    page = Page(text)
    assert page.tags.count("script") == text.count("<script") == text.count("</script>") == 2


def test_pictures(path, tmp_path):
    pictures = list(post([path], ["a.position.z"], output=tmp_path / "p.svg", kind="svg"))
    for picture in pictures:
        root = ElementTree.parse(picture).getroot()
        assert not [one for one in root.iter() if one.tag.rpartition("}")[2] in ("script", "marquee", "i")]
    assert pictures

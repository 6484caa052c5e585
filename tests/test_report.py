"""The page of a report on a run."""

import base64
import json
import re
from html.parser import HTMLParser
from types import SimpleNamespace

import every_kind
import numpy as np
import pytest
from browser import asked, browser

from mecano.elements import KINDS
from mecano.errors import ResultsError, UsageError
from mecano.post import report_page
from mecano.post.report import Picture, Table, Text, _solver_history, report_of
from mecano.post.report_page import page_of, write_report
from mecano.post.runs import open_runs
from mecano.post.spectrum import Transforms
from mecano.post.style import COLOURS, GREY, INK, LIMIT
from mecano.post.verdict import is_sound, verdict
from mecano.results.layout import Layout, Series
from mecano.results.provenance import Source
from mecano.results.reader import open_results
from mecano.results.recorded import Event
from mecano.results.writer import Writer

KIND = {"spring_damper": KINDS["spring_damper"]}


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return every_kind.write(
        tmp_path_factory.mktemp("report") / "each.h5", overrides=("parameters.wave=<0.7>",), kinds=KIND
    )


@pytest.fixture(scope="module")
def report(path):
    return report_of(open_runs([path])[0])


@pytest.fixture(scope="module")
def page(path):
    return write_report(path, path.parent / "pages" / "report.html")


class Structure(HTMLParser):
    """Tags that are left open, and addresses that are asked for."""

    def __init__(self, text):
        super().__init__()
        self.open, self.addresses, self.headings = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        if tag not in ("meta", "img"):
            self.open.append(tag)
        self.addresses += [value for name, value in attributes if name in ("src", "href")]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open[-1:] == ["h2"]:
            self.headings.append(data)


def rows(report, heading):
    [section] = [section for section in report.sections if section.heading == heading]
    return [row for part in section.parts if isinstance(part, Table) for row in part.rows]


def test_the_page_is_whole_and_asks_for_nothing_outside(page):
    text = page.read_text()
    found = Structure(text)
    assert found.open == [] and "default-src 'none'" in text and "<script" not in text
    assert all(address.startswith(("#", "data:image/svg+xml;base64,")) for address in found.addresses)
    anchors = {address[1:] for address in found.addresses if address.startswith("#")}
    assert anchors == set(re.findall('section id="([^"]+)"', text))
    for address in found.addresses:
        if address.startswith("data:"):
            assert b"<svg" in base64.b64decode(address.partition(",")[2])
    order = ["Overview", "Model", "Run", "Solution", "Energy", "Events", "Pictures", "Extremes", "Deck"]
    assert found.headings == order


@browser
def test_a_browser_shows_all_pictures(page):
    shown, count, requests = asked(page, """
    const shown = [...document.images].filter(image => image.complete && image.naturalWidth > 300).length;
    const requests = performance.getEntriesByType("resource").filter(one => !one.name.startsWith("data:")).length;
    return [shown, document.images.length, requests];
    """)  # fmt: skip
    assert shown == count == page.read_text().count("<img") > 3 and requests == 0


def luminance(colour):
    """The relative luminance of #rrggbb or of (r, g, b) from 0 to 1 (WCAG 2)."""
    channels = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)] if isinstance(colour, str) else colour
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(*colours):
    dark, light = sorted(map(luminance, colours))
    return (light + 0.05) / (dark + 0.05)


def filtered(colour, inverted=0.9):
    """What invert() and hue-rotate(180deg) make of a colour (Filter Effects 1)."""
    weights = np.array([0.213, 0.715, 0.072])
    channels = inverted + (1.0 - 2.0 * inverted) * np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    return np.clip(2.0 * weights @ channels - channels, 0.0, 1.0)


def test_the_page_is_readable_in_a_light_and_in_a_dark_scheme(page):
    """Texts have the contrast 4.5 of WCAG 2, and the colours of pictures at least that which they have on white."""
    style = re.search(r"<style>(.*?)</style>", page.read_text(), re.DOTALL)[1]
    light, dark = (
        dict(re.findall(r"--(\w+): (#\w{6})", block)) for block in re.findall(r":root \{([^}]*--[^}]*)\}", style)
    )
    assert light.keys() == dark.keys() and not re.search(r"#\w{3,6}", re.sub(r"--\w+: #\w{6}|#ffffff", "", style))
    for scheme in (light, dark):
        for text, paper in [(name, "paper") for name in ("ink", "faint", "accent", "beyond")] + [("ink", "block")]:
            assert contrast(scheme[text], scheme[paper]) > 4.5, (text, scheme)
        assert min(contrast(scheme[badge], "#ffffff") for badge in ("bad", "good")) > 4.5
    paper = filtered("#ffffff")
    assert "filter: invert(0.9) hue-rotate(180deg)" in style
    assert dark["paper"] == "#" + f"{round(255 * paper[0]):02x}" * 3
    for colour in (*COLOURS, GREY, INK, LIMIT):
        assert contrast(filtered(colour), paper) > min(4.5, contrast(colour, "#ffffff")), colour


def test_what_users_write_is_text(page):
    assert "Set on the command line: parameters.wave=&lt;0.7&gt;" in page.read_text()


def test_the_model_is_counted(report):
    reported = dict(rows(report, "Model"))
    assert reported["elements"] == "1: 1 spring_damper" and reported["nodes"] == "2" and reported["loads"] == "none"


def test_what_a_drive_sets_in_motion_is_reported_of_the_run(path):
    run = open_runs([path])[0]
    run.results.model.update(mass=1.5, set_in_motion="node 'pin' by 2 m/s")  # as a run writes them
    found = report_of(run)
    assert dict(rows(found, "Model"))["mass"] == "1.5 kg" and "set in motion" not in dict(rows(found, "Model"))
    assert dict(rows(found, "Run"))["at start"].endswith("leaves at rest: node 'pin' by 2 m/s")


def test_the_solver_history_is_reported_with_its_times(report):
    """As every_kind.write fills the columns: 1 + i mod 3 iterations in step i, i mod 2 rejections, steps of 0.05 s."""
    reported = {row[0]: row[1:] for row in rows(report, "Solution")}
    assert reported["Newton iterations"] == ("1", "0.15", "2", "3", "0.1")
    assert reported["rejected trials of a step"] == ("0", "0.1", "0.5", "1", "0.05")
    assert reported["size of the step [s]"] == ("0.05", "0.05", "0.05", "0.05", "0.05")


@pytest.mark.parametrize(("largest", "explained"), [(0.9, False), (3.5e6, True)])
def test_a_force_residual_above_its_tolerance_is_explained(largest, explained):
    """Where positions are rounded; without a word it looks like a run that failed."""
    steps = np.array([(0.1, 0.5), (0.2, largest)], dtype=[("time", "f8"), ("force_residual", "f8")])
    results = SimpleNamespace(
        steps=steps, step_columns={"force_residual": ("", "")}, axis=SimpleNamespace(unit="s", path="time")
    )
    parts = [part.text for part in _solver_history(results) if isinstance(part, Text)]
    assert any("rounding error of positions" in text for text in parts) == explained


@pytest.mark.parametrize(("warnings", "remarks"), [
    (["resumed at t = 2 s; results may differ"], []),
    ([], ["resumed at t = 2 s"]),
    (["slow"], ["resumed at t = 2 s"]),
])  # fmt: skip
def test_a_resumed_run_has_no_warning_unless_its_bits_may_differ(tmp_path, warnings, remarks):
    source = Source("mecano: 1\n", {}, warnings=warnings, resumptions=remarks)
    with Writer.create(tmp_path / "a.h5", Layout([]), source) as writer:
        writer.close("complete", "the end was reached")
    with open_results(tmp_path / "a.h5") as results:
        assert (results.warnings, results.resumptions) == (warnings, remarks)
        assert is_sound(results) == (not warnings)
        assert verdict(results) == ("complete with warnings" if warnings else "complete")


def test_energies_and_their_closure(report, path):
    [run] = open_runs([path])
    values = run.results["energy/kinetic"].values
    reported = {row[0]: row[1:] for row in rows(report, "Energy")}
    expected = (values[0], values[-1], values[-1] - values[0], values.max() - values.min())
    assert reported["kinetic"] == tuple(f"{x:.5g}" for x in expected)
    [section] = [section for section in report.sections if section.heading == "Energy"]
    assert "of the largest change of an energy" in section.parts[1].text


def test_events_have_impulses_only_where_there_are_shocks(report, tmp_path):
    assert rows(report, "Events")[0] == ("0.5", "wheel 'one_wheel'", "touch down", "air to contact")
    layout = Layout([Series("energy/kinetic", "J", "kinetic energy")])
    with Writer.create(tmp_path / "shock.h5", layout, Source("mecano: 1\n", {})) as writer:
        writer.append(0.0, [1.0])
        writer.append_event(Event(0.25, "hinge 'a'", "locks", "free", "locked", "N m s", -1.5, 2.0))
        writer.append_event(Event(0.5, "wheel 'b'", "lift_off", "contact", "air"))
    shocks = report_of(open_runs([tmp_path / "shock.h5"])[0])
    assert rows(shocks, "Events") == [
        ("0.25", "hinge 'a'", "locks", "free to locked", "-1.5 N m s", "2"),
        ("0.5", "wheel 'b'", "lift off", "contact to air", "", ""),
    ]


@pytest.mark.parametrize(("count", "title"), [(40, "All events"), (300, "The first 200 of 300 events")])
def test_many_events_are_counted_and_listed_in_a_collapsed_block(tmp_path, count, title):
    layout = Layout([Series("energy/kinetic", "J", "kinetic energy")])
    with Writer.create(tmp_path / "many.h5", layout, Source("mecano: 1\n", {})) as writer:
        writer.append(0.0, [1.0])
        for i in range(count):
            writer.append_event(Event(0.25 * i, "cylindrical 'strut'", ("opens", "lower_stop")[i % 2], "a", "b"))
    many = report_of(open_runs([tmp_path / "many.h5"])[0])
    [section] = [section for section in many.sections if section.heading == "Events"]
    counted, listed = section.parts
    last = [f"{0.25 * i:.5g}" for i in (count - 2, count - 1)]
    assert counted.columns == ("time [s]", "where", "what", "phase", "times", "last [s]")
    assert counted.rows == [
        ("0", "cylindrical 'strut'", "opens", "a to b", str(count // 2), last[0]),
        ("0.25", "cylindrical 'strut'", "lower stop", "a to b", str(count // 2), last[1]),
    ]
    assert (listed.title, len(listed.rows)) == (title, min(count, 200))
    text = page_of(many)
    assert f"<details><summary>{title}</summary><table>" in text and Structure(text).open == []


def test_like_events_are_grouped_and_shocks_and_releases_come_first(tmp_path):
    """As in ``mecano info``: four hinges lock together, 40 sticking joints leave them in the table."""
    layout, deck = Layout([Series("energy/kinetic", "J", "kinetic energy")]), {"joints": {}}
    deck["joints"] = {name: {"type": "hinge"} for name in "abcd"} | {f"s{i}": {"type": "prismatic"} for i in range(40)}
    with Writer.create(tmp_path / "many.h5", layout, Source("mecano: 1\n", deck)) as writer:
        for t in (0.0, 50.0):
            writer.append(t, [1.0])
        for i in range(40):
            writer.append_event(Event(0.1 * i, f"prismatic 's{i}'", "sticks", "slides", "sticks"))
        for name, impulse in zip("abcd", (1.0, -3.0, 2.0, 0.5), strict=True):
            writer.append_event(Event(41.0, f"hinge '{name}'", "locks", "free", "locked", "N m s", impulse, 0.25))
    [section] = [s for s in report_of(open_runs([tmp_path / "many.h5"])[0]).sections if s.heading == "Events"]
    grouped, share, listed, lost = section.parts
    assert grouped.rows[-1] == ("41", "4 hinge: a, b, c, and 1 more", "locks", "free to locked", "up to -3 N m s", "1")
    assert len(grouped.rows) == 30 and "30 of 41 groups" in share.text
    assert listed.title == "All events" and len(listed.rows) == 44 and lost.text == "Shocks took 1 J in all."


def test_the_pictures_are_those_of_post(report):
    shown = [part.title for section in report.sections for part in section.parts if isinstance(part, Picture)]
    assert shown[:2] == ["Overview", "Mechanism"] and {"Springs and struts", "Solver"} <= {
        s.partition(":")[0] for s in shown
    }


def test_pictures_that_are_asked_for_come_first(path):
    asked = report_of(open_runs([path])[0], None, ["one_spring_damper.force"], Transforms(["one_spring_damper.rate"]))
    shown = [part.title for section in asked.sections for part in section.parts if isinstance(part, Picture)]
    assert shown[1] == "one_spring_damper.force over time" and shown[2].startswith("Amplitudes over the frequency")


def test_the_deck_is_there_as_written_and_as_understood(report, path):
    parts = report.sections[-1].parts
    written, understood = (part.text for part in parts if part.verbatim)
    assert written == every_kind.DECK_TEXT
    assert "one_spring_damper:" in understood and json.dumps(every_kind.WAVE) in understood


def test_what_cannot_be_reported_is_refused(path, tmp_path, monkeypatch):
    monkeypatch.setattr(report_page, "_image", lambda figure: "")  # what is refused need not be drawn
    with pytest.raises(UsageError, match="end with .html; print it in a browser to get a PDF"):
        write_report(path, tmp_path / "page.pdf")
    with pytest.raises(ResultsError, match="cannot make the folder /proc/pages"):
        write_report(path, "/proc/pages/page.html")
    with Writer.create(tmp_path / "empty.h5", Layout([]), Source("mecano: 1\n", {})):
        pass
    with pytest.raises(ResultsError, match="no saved times"):
        write_report(tmp_path / "empty.h5", tmp_path / "page.html")

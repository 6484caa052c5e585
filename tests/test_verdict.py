"""The verdict: a run that warns is not praised, in no picture and on no page."""

from html import escape

import every_kind
import pytest

from mecano.elements import KINDS
from mecano.post import report, report_page
from mecano.post.animation import page_data
from mecano.post.info import info, one_line
from mecano.post.report_page import write_report
from mecano.post.runs import open_runs
from mecano.results.provenance import Source
from mecano.results.recorded import Event
from mecano.results.writer import Writer

KIND = {name: KINDS[name] for name in ("hinge", "wheel", "spring_damper", "force")}
CASES = {  # warnings before, status, reason -> verdict, whether it is sound
    "sound": ((), "complete", "the end was reached", "complete", True),
    "warned before": (("a pole is near",), "complete", "the end was reached", "complete with warnings", False),
    "warned at the end": (
        (),
        "complete",
        "the end was reached;\nenergy is off;\na; b",
        "complete with warnings",
        False,
    ),
    "warned at another end": ((), "complete", "node 'a' was displaced;\nit is off", "complete with warnings", False),
    "at another end": ((), "complete", "node 'a' was displaced; so far", "complete", True),
    "failed": ((), "failed", "no way on from t = 1 s", "failed", False),
    "failed, warned": (("a pole is near",), "failed", "no way on", "failed with warnings", False),
}


END_OF = {  # reason -> warnings at the end of the run
    "the end was reached;\nenergy is off;\na; b": ["energy is off", "a; b"],
    "node 'a' was displaced;\nit is off": ["it is off"],
}


def written(path, warnings, status, reason):
    declared = every_kind.layout(KIND)
    source = Source(every_kind.DECK_TEXT, every_kind.deck(KIND), "each.yaml", "One of each", warnings=warnings)
    with Writer.create(path, declared, source) as writer:
        for t in every_kind.TIMES:
            writer.extremes.take(t, every_kind.row(declared, t))
            writer.append(t, every_kind.row(declared, t))
        writer.append_event(Event(0.5, "wheel 'one_wheel'", "touch_down", "air", "contact"))
        writer.close(status, reason)
    return path


@pytest.mark.parametrize(("warnings", "status", "reason", "words", "sound"), CASES.values(), ids=CASES)
def test_all_pages_and_pictures_say_the_same(tmp_path, warnings, status, reason, words, sound, monkeypatch):
    for name in ("overview_figure", "sheet_figure"):  # drawing takes seconds; titles are those of one_line
        monkeypatch.setattr(report, name, lambda *_: None)
    monkeypatch.setattr(report_page, "_image", lambda figure: "")
    path = written(tmp_path / "each.h5", warnings, status, reason)
    text = write_report(path, tmp_path / "report.html").read_text()
    [run] = open_runs([path])
    end, at_the_end = run.results.end, run.results.warnings[len(warnings) :]
    assert at_the_end == END_OF.get(reason, []) and "; ".join([end, *at_the_end]) == reason.replace("\n", " ")
    assert f'<b class="{"sound" if sound else ""}">{words}</b>{escape(end)}' in text
    assert ("<h2>Warnings</h2>" in text) == bool(run.results.warnings)
    assert all(f"{remark}<" in text and f"warning     {remark}\n" in info(path) for remark in run.results.warnings)
    assert f"status      {words}: {end}" in info(path)
    assert one_line([run]).startswith(f"{words}; ")
    data = page_data(run)
    assert (data["status"], data["sound"]) == (words, sound)


def test_info_begins_with_the_verdict(tmp_path):
    """Events, then outputs of joints, wheels, other elements, loads and nodes."""
    text = info(written(tmp_path / "each.h5", (), "complete", "the end was reached"))
    order = ["Events: 1", "joints, hinge", "elements, wheel", "elements, spring_damper", "loads, force", "nodes: ",
             "energy: ", "Extremes"]  # fmt: skip
    places = [text.index(one) for one in order]
    assert places == sorted(places)


def test_info_names_the_option_that_shows_all(tmp_path):
    names = [f"{number}th" for number in range(9)]
    kinds = {name: KINDS["spring_damper"] for name in names}
    deck = every_kind.deck({"spring_damper": KINDS["spring_damper"]})
    one = deck["elements"].pop("one_spring_damper")
    deck["elements"] = {name: one for name in kinds}
    declared = every_kind.layout({"spring_damper": KINDS["spring_damper"]})
    series = [s for s in declared.series if "one_spring_damper" not in s.path]
    from mecano.results.layout import Layout, Series

    series += [Series(f"elements/{name}/force", "N", "force") for name in names]
    with Writer.create(tmp_path / "many.h5", Layout(series), Source("mecano: 1\n", deck)) as writer:
        writer.append(0.0, [0.0] * Layout(series).size)
    text = info(tmp_path / "many.h5")
    assert "and 3 more" in text and "all names: mecano info FILE --names" in text

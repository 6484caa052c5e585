"""Printed problems of a deck, and descriptions of kinds."""

import pytest
from deck_samples import FAKE_KINDS, VALID, read_fake

from mecano.deck.check import UNCHECKED
from mecano.deck.describe import describe, describe_section, describe_term
from mecano.deck.format import deck_error_text, problem_text
from mecano.deck.sections import SECTIONS
from mecano.errors import DeckError, Mark, Problem
from mecano.laws import TERMS


def printed(text, overrides=()):
    """Return the printed text of an invalid deck."""
    with pytest.raises(DeckError) as info:
        read_fake(text, overrides=overrides)
    return deck_error_text(info.value)


def test_line_caret_hint_and_count():
    text = VALID.replace("axis: [0, 1, 0], stop_axis: [1, 0, 0]", "axsi: [0, 1, 0]").replace("sink: 3.05", "sink: x")
    assert printed(text, ["time.end=late"]) == (
        "deck.yaml:3:20: parameter 'sink': must be a number, got the text 'x'; a word is a name or a part of one, such "
        "as axle_$sink, and no name here contains $sink\n"
        "    parameters: {sink: x, mass: 82.0, steps: 4}\n"
        "                       ^\n"
        "deck.yaml:17:42: hinge 'pin': unknown key 'axsi'; did you mean 'axis'?\n"
        "      pin: {type: hinge, nodes: [top, knee], axsi: [0, 1, 0]}\n"
        "                                             ^\n"
        "override time.end:1:10: 'time.end' must be a number [s], got the text 'late'\n"
        "    time.end=late\n"
        "             ^\n"
        f"3 errors; {UNCHECKED} once these errors are fixed"
    )


def test_one_error_is_counted_as_one():
    assert printed(VALID.replace("title:", "titel:")).endswith(f"\n1 error; {UNCHECKED} once this error is fixed")


def test_many_errors_are_cut():
    unknown = "".join(f"n{i}: 1\n" for i in range(60))
    text = printed(f"mecano: 1\n{unknown}")
    assert text.count("^") == 50 and text.endswith(f"and 13 more; 63 errors; {UNCHECKED} once these errors are fixed")


def test_long_lines_and_tabs():
    line = "a" * 500 + "\tb\x07" + "c" * 500
    _, shown, caret = problem_text(Problem("wrong", Mark("d", 1, 502, (), line))).split("\n")
    assert len(shown) <= 104 and shown[caret.index("^")] == "b"
    assert shown == "    …" + 48 * "a" + " b?" + 47 * "c" + "…"
    for column, wanted in ((3, 99 * "x" + "…"), (250, "…" + 50 * "x")):
        assert problem_text(Problem("wrong", Mark("d", 1, column, (), 250 * "x"))).split("\n")[1] == f"    {wanted}"
    assert problem_text(Problem("wrong", Mark("d", 1, 1, (), 100 * "x" + "  "))).split("\n")[1].endswith("xx")
    _, shown, caret = problem_text(Problem("wrong", Mark("d", 1, 3, (), "\t\tb\x07"))).split("\n")
    assert (shown, caret) == ("      b?", "      ^")


def test_stack_and_no_mark():
    stack = (Mark("top.yaml", 3, 1), Mark("part.yaml", 7, 2))
    text = problem_text(Problem("wrong", Mark("inner.yaml", 1, 1, stack), "do so"))
    assert text == "inner.yaml:1:1: wrong; do so\n  in part.yaml:7:2\n  in top.yaml:3:1"
    assert problem_text(Problem("wrong")) == "wrong"


def test_kinds_in_words():
    text = describe(FAKE_KINDS["body"])
    assert text.startswith("body (section 'elements')\n\nA rigid body.\n\nFields\n")
    assert "  mass [kg]: a number; required\n      mass\n" in text
    assert "  center_of_mass [m]: a list of 3 numbers, in the axes of the node; default [0.0, 0.0, 0.0]\n" in text
    assert "  attached: a list of node names; optional\n" in text
    assert "Outputs\n  velocity [m/s], 3 numbers\n      velocity of the centre of mass\n" in text


@pytest.mark.parametrize("term", TERMS.values(), ids=list(TERMS))
def test_terms_in_words(term):
    text = describe_term(term)
    assert text.startswith(f"{term.name} (term of a law, ")
    assert all(field.name in text for field in term.fields) and "inf" not in text


@pytest.mark.parametrize("section", SECTIONS, ids=lambda field: field.name)
def test_sections_in_words(section):
    text = describe_section(section)
    assert section.doc.split()[0] in text and "object at" not in text
    if section.name == "time":
        assert "    rho_inf: a number; default 0.8\n" in text
        assert "      force_tolerance: a number; default 1e-07\n" in text

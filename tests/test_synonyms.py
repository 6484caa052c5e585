"""Words of other programs and their equivalents in mecano, each of which can be explained or called."""

import functools
import re

import pytest
from click.testing import CliRunner

from mecano.cli import commands
from mecano.deck import catalogue
from mecano.deck.catalogue import explain
from mecano.deck.synonyms import NOTES, SYNONYMS, synonym, synonym_of_end
from mecano.elements import KINDS
from mecano.errors import UsageError

ASKED = """motor, actuator, pulley, revolute, ball joint, slider, translational joint, bushing, damper, spring, contact,
    modes, eigenvalues, tyre, tire, oleo, shock absorber, latch, stop, cable, rope, winch, truss, rod, link, weld,
    gimbal, cardan, rail, friction, brake, runway, initial conditions, output, units, parameters, sweep, gear, belt,
    strut, backlash, superelement, roller, point on plane, outputs, tires, Revolute_Joint, ball-joint,
    stewart, bogie, gust, LossyGear, WorldForce, ElastoBacklash, freejoint, FixedTranslation, site, frictionloss"""


@pytest.fixture(autouse=True, scope="module")
def listed():
    """The fields of all kinds, listed once for thousands of words."""
    fields = list(catalogue._fields())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(catalogue, "_fields", lambda: fields)
        yield


@functools.cache  # targets of several words
def explained(name):
    """What `mecano explain` prints; it must succeed."""
    result = CliRunner().invoke(commands, ["explain", *name.split()])
    assert result.exception is None, (name, result.output)
    return result.output


@pytest.mark.parametrize("word", re.split(r",\s+", ASKED))
def test_words_are_answered(word):
    assert len(explained(word).splitlines()) >= 3


@pytest.mark.parametrize("words", NOTES, ids=lambda words: words.partition(",")[0])
def test_all_targets_exist(words):
    """And are named in the answer; words in quotes of a command are commands."""
    targets, note = NOTES[words]
    assert targets or note
    for target in targets.split():
        assert explained(target)
    for command in re.findall(r"`mecano (\w+)", note):
        assert command in commands.commands
    for word in words.split(", "):
        answer = explained(word)
        assert all(f"  {target}  " in answer or f"  {target}\n" in answer for target in targets.split())


def test_every_word_stands_once():
    assert len(SYNONYMS) == sum(len(words.split(", ")) for words in NOTES)


def test_names_of_mecano_with_spaces_or_hyphens():
    assert explain("metering pin") == explain("metering-pin") == explain("metering_pin")
    assert explain("STEP") == explain("step")


def test_forms_of_a_word():
    assert synonym("Motors") == synonym("motor") and synonym("Universal_Joint") == synonym("cardan")


def test_words_are_found_by_their_end():
    assert synonym_of_end("double wishbones") == synonym("wishbone") != synonym_of_end("left trailing-arm bushing")
    assert synonym_of_end("wishbone") is None and synonym("leaf spring") != synonym("spring")
    assert explain("double wishbone").partition("\n")[2] == explain("wishbone").partition("\n")[2]


def test_a_field_of_a_section_may_be_given_by_two_words():
    assert explain("initial from") == explain("initial.from")
    assert synonym("flux capacitor") is None


def test_no_kind_is_hidden():
    """A word that is the name of a kind is answered with the kind first."""
    for name in KINDS:
        assert explain(name).startswith(f"{name} (section ")


def test_an_unknown_word_gets_the_nearest():
    with pytest.raises(UsageError, match="did you mean 'motor'"):
        explain("motro")


def test_without_a_name_all_are_listed():
    runner = CliRunner()
    assert runner.invoke(commands, ["explain"]).output == runner.invoke(commands, ["list"]).output != ""


@pytest.mark.parametrize("name", ["ground", "node", "tire law", "signal", "element", "law"])
def test_an_entry_of_a_section_is_explained_by_the_section(name):
    """A user who wants to know what a ground has asks for it in the singular."""
    assert explain(name).startswith(f"{name.replace(' ', '_')}s (section of the deck)")


@pytest.mark.parametrize("name", ["oleo_drop", "oleo_drop.yaml"])
def test_the_name_of_an_example_is_explained_as_such(name):
    text = explain(name)
    assert text.startswith("oleo_drop (example deck): Drop test of an oleo-pneumatic strut\n")
    assert "Known answer: SciPy integrates" in text and "mecano example oleo_drop " in text


def test_a_kind_is_explained_before_the_example_of_its_name():
    text = explain("bushing")
    assert text.startswith("bushing (section ") and "bushing (example deck): " in text

"""Documentation of study files: `mecano explain study`, `mecano schema --study`."""

import json
import math
import re
from pathlib import Path

import jsonschema
import pytest
from click.testing import CliRunner
from test_deck_schema import plain

from mecano.cli import commands
from mecano.deck.compose import compose
from mecano.deck.describe import field_lines, inner_fields
from mecano.deck.source import Source
from mecano.study.describe import EXAMPLE, explain_study, study_schema
from mecano.study.grammar import FIELDS, SPAN_FIELDS
from mecano.study.read import read_study

PAGE = re.search(
    r"```yaml\n(study: 1\n.*?)```", (Path(__file__).parents[1] / "docs/studies.md").read_text(), re.DOTALL
)[1]
WRONG_STUDIES = [  # what is written in the example, what instead, where the schema sees it
    ("study: 1", "study: 2", "study"),
    ("deck: nose_gear_rigid.yaml", "deck: 3", "deck"),
    ("deck: nose_gear_rigid.yaml", "decks: nose_gear_rigid.yaml", ""),
    ("radial_damping: [0.1, 0.2]", "radial_damping: 200", "grid.tire_laws.nose_tire.radial_damping"),
    ("number: 5", "numbers: 5", "grid.parameters.speed"),
    ("[0 mm, 30 mm]", "[0 mm, 30 mm, 40 mm]", "latin_hypercube.ranges.parameters.bump_amplitude"),
    ("number: 20", "number: many", "latin_hypercube.number"),
    ("path: laws.road.random.seed, ", "", "seeds"),
    ("take: max", "take: most", "outputs.peak_load.take"),
    ("take: max", "take: max, repeat: {i: 1..2}", "outputs.peak_load"),
]


@pytest.fixture(scope="module")
def validator():
    jsonschema.Draft7Validator.check_schema(study_schema())
    return jsonschema.Draft7Validator(study_schema())


def errors(validator, text):
    """Places of what is wrong in a study."""
    found = validator.iter_errors(plain(compose(Source("study", text), [])))
    return [".".join(map(str, error.absolute_path)) for error in found]


@pytest.mark.parametrize("text", [EXAMPLE, PAGE], ids=["example", "page"])
def test_studies_fit(validator, text):
    assert errors(validator, text) == []


@pytest.mark.parametrize("old,new,place", WRONG_STUDIES)
def test_wrong_studies_do_not_fit(validator, old, new, place):
    assert old in EXAMPLE and place in errors(validator, EXAMPLE.replace(old, new, 1))


def test_the_example_can_be_read_and_has_every_field(tmp_path):
    (tmp_path / "study.yaml").write_text(EXAMPLE)
    (tmp_path / "nose_gear_rigid.yaml").write_text("mecano: 1\n")
    (tmp_path / "cases.csv").write_text("parameters.wind\n1\n2\n3\n")
    assert len(read_study(str(tmp_path / "study.yaml")).cases) == 5 * 2 * 2 * 3 * 20 * 10
    fields = [*FIELDS, *SPAN_FIELDS, *(inner for field in FIELDS for inner in inner_fields(field.type))]
    assert len(fields) > 20 and all(re.search(rf"\b{field.name}:", EXAMPLE) for field in fields)


def test_the_commands():
    reported = CliRunner().invoke(commands, ["explain", "study"], catch_exceptions=False).output
    assert reported.rstrip() == explain_study() and all(
        line in reported for line in field_lines((*FIELDS, *SPAN_FIELDS))
    )
    written = CliRunner().invoke(commands, ["schema", "--study"], catch_exceptions=False).output
    assert json.loads(written) == study_schema()


def test_values_of_ranges_have_the_unit_of_their_ends(tmp_path):
    """Also in the case that a message names; in the table they are in SI units."""
    (tmp_path / "deck.yaml").write_text("mecano: 1\nparameters: {angle: 1 rad}\n")
    grid = "grid: {parameters.angle: {from: 5 deg, to: 20 deg, number: 3}}"
    (tmp_path / "study.yaml").write_text(f"study: 1\ndeck: deck.yaml\n{grid}\n")
    cases = read_study(str(tmp_path / "study.yaml")).cases
    assert [case.values["parameters.angle"] for case in cases] == ["5 deg", "12.5 deg", "20 deg"]
    assert [case.shown["parameters.angle"] for case in cases] == [x * math.pi / 180.0 for x in (5.0, 12.5, 20.0)]

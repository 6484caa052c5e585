"""Description of the study file as text and as JSON Schema, from the declarations used to read it."""

from mecano.deck.describe import field_lines
from mecano.deck.json_schema import Schema, file_schema
from mecano.study.grammar import FIELDS, SPAN_FIELDS

EXAMPLE = """\
study: 1
title: Touch-down speeds
deck: nose_gear_rigid.yaml
set: {parameters.sink: -2.0, time.end: 1.5}                      # in all cases
grid:                                                            # 5 x 2 cases
  parameters.speed: {from: 40 m/s, to: 80 m/s, number: 5}
  tire_laws.nose_tire.radial_damping: [0.1, 0.2]
list:                                                            # times these 2
  - {case: light, elements.rim.mass: 40, elements.aircraft.mass: 6 t}
  - {case: heavy, elements.rim.mass: 50, elements.aircraft.mass: 7 t}
csv: cases.csv                                                   # such rows from a file
latin_hypercube: {ranges: {parameters.bump_amplitude: [0 mm, 30 mm]}, number: 20, seed: 1}
seeds: {path: laws.road.random.seed, number: 10, first: 1}       # of a deck with a random road
outputs:
  peak_load: {of: wheel.radial_force, take: max, at_most: 120 kN} # a case with more fails
  last_touch_down: {event: wheel touch_down, take: last, at_least: 0.1 s}
"""


def explain_study() -> str:
    """Return the text on study files: the meaning of each field, and an example."""
    lines = ["study (a file of its own, for mecano sweep)", "", "Fields", *field_lines(FIELDS)]
    lines += ["", "Values of a grid at equal distances", *field_lines(SPAN_FIELDS), "", "Example"]
    return "\n".join([*lines, *(f"  {line}" for line in EXAMPLE.splitlines()), "", "More: docs/studies.md"])


def study_schema() -> Schema:
    """Return the JSON Schema of study files as plain data."""
    schema = file_schema("study", FIELDS, [field.name for field in FIELDS if field.required], {})
    del schema["properties"]["outputs"]["additionalProperties"]["properties"]["repeat"]  # only decks repeat
    return schema

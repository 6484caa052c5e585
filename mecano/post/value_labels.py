"""Values that a study varies as shown in the pictures of its table: short texts, numbers in usual units."""

import ast
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from mecano.post.study_outputs import study_unit
from mecano.results.study_file import Column

LONGEST = 32  # characters of a text


def legible(column: Column) -> Column:
    """Return a Column of texts with short ones, of mappings the values that differ; one of numbers in a usual unit."""
    if column.numeric:
        factor, unit = study_unit(column.unit, column.values)
        return replace(column, values=column.values / factor, unit=unit)
    short = short_texts(dict.fromkeys(map(str, column.values)))
    return replace(column, values=np.array([short[str(value)] for value in column.values], object))


def short_texts(texts: Iterable[str]) -> dict[str, str]:
    """Return {text: short text}, all different from one another."""
    data = {text: _plain(text) for text in texts}
    if all(type(value) is dict for value in data.values()):
        keys = dict.fromkeys(key for value in data.values() for key in value)
        differing = [key for key in keys if len({repr(value.get(key)) for value in data.values()}) > 1]
        shown = {text: _cut(", ".join(f"{k} {v[k]}" for k in differing if k in v)) for text, v in data.items()}
    else:
        shown = {text: _cut(text) for text in data}
    unique = len(set(shown.values())) == len(shown)
    return shown if unique else {text: f"{i + 1}: {_cut(shown[text], LONGEST - 4)}" for i, text in enumerate(shown)}


def _plain(text: str) -> Any:
    """Return the list or mapping of a text of a table, or the text."""
    try:
        return ast.literal_eval(text) if text[:1] in ("{", "[") else text
    except (ValueError, SyntaxError):
        return text


def _cut(text, longest=LONGEST):
    return text if len(text) <= longest else text[: longest - 3] + "..."

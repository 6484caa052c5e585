"""Warnings about coefficients of friction that no pair of materials has: those given in percent."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mecano.deck.lint import Remark
    from mecano.schema import Values

LARGEST = 3.0  # racing tyres reach 2
OF_TYRES = (("friction",), ("fiala", "friction"), ("yawed_rolling", "friction"))  # paths in a tyre law
OF_JOINTS = (("friction", "coefficient"),)
LEVELS = {"constant": "value", "exponential": "start"}  # term of a curve: the field of its largest value


def large_frictions(values: "Values") -> "Iterator[Remark]":
    """Yield (path, text) on the tyre laws and joints with a coefficient of friction above ``LARGEST``."""
    for section, paths in (("tire_laws", OF_TYRES), ("joints", OF_JOINTS)):
        for name, d in values[section].items():
            for path in paths:
                most = max(_levels(d, path), default=0.0)
                if most > LARGEST:
                    owner = f"{d.get('type', 'tire law')} '{name}'"
                    text = (
                        f"{owner}: a coefficient of friction of {most:g} is larger than of any materials; is it in %?"
                    )
                    yield (section, name, *path), text


def _levels(d, path):
    """Return the largest values of the terms of a curve at the end of a path; none if it is absent."""
    for key in path:
        d = (d or {}).get(key)
    levels = [values[LEVELS[term]] for term, values in d or () if term in LEVELS]
    return levels + [y for term, values in d or () if term == "table" for _, y in values["points"]]

"""Warnings about coefficients of friction that no pair of materials has: those given in percent."""

from collections.abc import Iterator

from mecano.errors import LocatedWarning
from mecano.schema import Values

OF_TYRES = {  # path in a tyre law: largest value; racing tyres reach 2, tyres in sand roll with 0.3
    ("friction",): 3.0, ("fiala", "friction"): 3.0, ("yawed_rolling", "friction"): 3.0,
    ("rolling_resistance", "coefficient"): 0.5,
}  # fmt: skip
OF_JOINTS = {("friction", "coefficient"): 3.0}
LEVELS = {"constant": "value", "exponential": "start"}  # term of a curve: the field of its largest value


def large_frictions(values: Values) -> Iterator[LocatedWarning]:
    """Yield (path, text) on the tyre laws and joints with a coefficient of friction that is too large."""
    for section, paths in (("tire_laws", OF_TYRES), ("joints", OF_JOINTS)):
        for name, d in values[section].items():
            for path, largest in paths.items():
                most = max(_levels(d, path), default=0.0)
                if most > largest:
                    owner = f"{d.get('type', 'tire law')} '{name}'"
                    text = (
                        f"{owner}: a coefficient {_of(path)} of {most:g} is larger than for any material; is it in %?"
                    )
                    yield (section, name, *path), text


def _of(path):
    return "of rolling resistance" if "rolling_resistance" in path else "of friction"


def _levels(d, path):
    """Return the largest values of the terms of a curve at the end of a path; none if it is absent."""
    for key in path:
        d = (d or {}).get(key)
    levels = [values[LEVELS[term]] for term, values in d or () if term in LEVELS]
    return levels + [y for term, values in d or () if term == "table" for _, y in values["points"]]

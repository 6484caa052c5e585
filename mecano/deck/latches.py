"""Warnings about latches from which the law of their joint pushes away, as by a wrong sign."""

from collections.abc import Iterator

from mecano.constraints.along_coordinate.demand import as_formula
from mecano.errors import LocatedWarning
from mecano.laws.law_table import LawTable, evaluate_force
from mecano.schema import Values

LAWS = {"angle": ("turning_law", "natural_angle"), "displacement": ("sliding_law", "natural_displacement")}


def latches_pushed_away(values: Values) -> Iterator[LocatedWarning]:
    """Yield (path, text) on joints whose law pushes away from their latch at the start, if nothing else drives them."""
    driven = {id(joint) for section in ("joints", "loads") for d in values[section].values() for joint in _joints(d)}
    for name, d in values["joints"].items():
        if not d.get("latch") or id(d) in driven or values["initial"]["from"]:
            continue
        what, place = next(iter(d["latch"].items()))
        law, natural = (d.get(key) for key in LAWS[what])
        push = _at_start(law, natural)
        if push * place > 0.0:
            text = f"{d['type']} '{name}': '{LAWS[what][0]}' pushes it away from its latch at the start"
            yield (
                ("joints", name, "latch", what),
                f"{text}; is a sign wrong, of the axis, the latch or '{LAWS[what][1]}'?",
            )


def _joints(d):
    """Return the checked values of the joints that a joint or load names."""
    named = [value for value in d.values() if type(value) in (dict, list)]
    return [joint for value in named for joint in (value if type(value) is list else [value]) if type(joint) is dict]


def _at_start(law, natural):
    """Return the force of a law, > 0 against the coordinate, at the coordinate zero; 0 where a set point varies."""
    constant = as_formula(natural)
    try:
        natural = float(constant)
    except (TypeError, ValueError):  # it varies
        return 0.0
    table = LawTable()
    start = table.add(law)
    return evaluate_force(table.array(), start, -natural, 0.0)[0] if start else 0.0

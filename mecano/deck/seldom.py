"""Laws of force with the sign of a mistake: some mechanisms need them, so they are told and not refused."""

from mecano.contract import SECTIONS
from mecano.elements import KINDS

PUSHES = "it pushes away from its zero instead of back to it; is it meant so, as where something snaps through?"
DRIVES = "it drives slow motions on instead of braking them; is it meant so, as in what keeps itself swinging?"
SUSPECT = {  # term of a law: what may be negative in it, its number, what follows
    "spring": ("stiffness", lambda values: values["stiffness"], PUSHES),
    "linear": ("slope", lambda values: values["slope"], PUSHES),
    "damper_polynomial": ("coefficients[1]", lambda values: sum(values["coefficients"][1:2]), DRIVES),
}
MOST_NAMES = 3


def remarks(values):
    """Texts on negative stiffness and damping in checked deck ``values``, one for all that is alike."""
    found = {}
    for section in SECTIONS:
        for name, d in values[section].items():
            for path, what, number, follows in _negative(d):
                found.setdefault((d["type"], f"{path}.{what}", follows), {})[name] = number
    for (kind, path, follows), numbers in found.items():
        names, lowest, highest = [f"'{name}'" for name in numbers], min(numbers.values()), max(numbers.values())
        more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
        value = f"{lowest:g}" if lowest == highest else f"{lowest:g} to {highest:g}"
        yield f"{kind} {', '.join(names[:MOST_NAMES])}{more}: '{path}' is negative ({value}): {follows}"


def _negative(d):
    """(path of a law, what is negative in it, the number, what follows) of the values of an element."""
    for path, law in _laws(KINDS[d["type"]].fields, d):
        for term, values in law:
            if term in SUSPECT:
                what, number, follows = SUSPECT[term]
                if number(values) < 0.0:
                    yield path, f"{term}.{what}", number(values), follows


def _laws(fields, values, path=""):
    """(path, terms) of the laws of force among checked values."""
    for field in fields:
        value = values[field.name]
        if value is not None and field.type.name == "law":
            yield f"{path}{field.name}", value
        elif value is not None and field.type.name == "mapping":
            yield from _laws(field.type.options, value, f"{path}{field.name}.")

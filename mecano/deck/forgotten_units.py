"""Warnings about overrides by plain numbers of quantities that the deck gives in another unit than that of SI."""

import math
from collections.abc import Iterable

from mecano.deck.compose import Node
from mecano.deck.units import ANY, UnitError, converted, is_in_si, is_quantity, number_and_unit, si_unit
from mecano.deck.wording import quoted
from mecano.errors import Problem


def forgotten_units(before: Node, after: Node, paths: Iterable[str]) -> list[Problem]:
    """Return warnings (list of Problem) about the numbers at ``paths``, "a.b.c", of the trees of a deck.

    A number without a unit is in SI units: 50 in the place of 60 km/h is 50 m/s. Only numbers are warned of whose ratio
    to the number in the deck is nearer to 1 than that to its value in SI units: 50, but not 20.
    """
    found = []
    for path in paths:
        keys = path.strip().split(".")
        old, new = _at(before, keys), _at(after, keys)
        if old is None or new is None or type(new.value) not in (int, float) or not new.value:
            continue
        given = old.raw if type(old.value) is str and is_quantity(old.raw) else ""
        if given and _is_nearer(abs(new.value), given):
            unit, wanted = number_and_unit(given)[1], si_unit(given)
            found.append(
                Problem(
                    f"{quoted(path)}: {new.raw} without a unit is in {wanted}, and the deck gives {given}; write "
                    f"'{new.raw} {unit}' or '{new.raw} {wanted}'",
                    new.mark,
                )
            )
    return found


def _is_nearer(number, given):
    """Return whether a positive number is nearer to that of the quantity ``given`` than to its value in SI units."""
    try:
        if is_in_si(given):
            return False
        written, in_si = abs(float(number_and_unit(given)[0])), abs(converted(given, ANY))
    except UnitError:
        return False  # another message reports the wrong unit
    return written > 0.0 and abs(math.log(number / written)) < abs(math.log(number / in_si))


def _at(node, keys):
    """Return the node at the ``keys`` below a node, or None."""
    for key in keys:
        if type(node.value) is dict and key in node.value:
            node = node.value[key][1]
        elif type(node.value) is list and key.isdecimal() and int(key) < len(node.value):
            node = node.value[int(key)]
        else:
            return None
    return node

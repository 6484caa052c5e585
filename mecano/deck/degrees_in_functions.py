"""Warnings of angles in expressions and formulas that look like degrees: sin(30), cos($tilt) of a plain number."""

import math
import re
from collections.abc import Callable

CALL = re.compile(r"\b(?:sin|cos|tan)\(\s*[-+]?\s*(?:(\d+\.?\d*)|\$([A-Za-z_]\w*))\s*\)")

EDGE = re.compile(r"(?<![\w.$*/])(\d+\.?\d*)\s*\*\s*step\(")


def edge_in_degrees(formula: str) -> str:
    """Return what is suspicious about the first edge of an angle of more than a turn, in whole or half numbers; or "".

    A formula with pi converts its angles itself.
    """
    for edge in () if re.search(r"\bpi\b", formula) else EDGE.finditer(formula):
        if float(edge[1]) > 2.0 * math.pi and (2.0 * float(edge[1])).is_integer():
            return (
                f"the edge '{edge[1]}*step(...)' is one of {edge[1]} rad, more than a turn; is this intended? Degrees "
                f"are written as {edge[1]}*pi/180, or as a parameter with the unit deg"
            )
    return ""


def meant_degrees(text: str, parameter: Callable[[str], float]) -> str:
    """Return what is suspicious about the first angle of more than a turn, in whole or half numbers, in a text; or "".

    ``parameter(name)`` returns the number of a parameter.
    """
    for call in CALL.finditer(text):
        angle = float(call[1]) if call[1] else parameter(call[2])
        if abs(angle) > 2.0 * math.pi and (2.0 * angle).is_integer():
            inner = call[1] or f"${call[2]}"
            return (
                f"in {call[0]!r} the angle is {angle:g} rad, more than a turn; is this intended? Degrees are written "
                f"as {inner}*pi/180, or as a parameter with the unit deg"
            )
    return ""

"""Warnings of angles in expressions and formulas that look like degrees: sin(30), cos($tilt) of a plain number."""

import math
import re
from collections.abc import Callable

CALL = re.compile(r"\b(?:sin|cos|tan)\(\s*[-+]?\s*(?:(\d+\.?\d*)|\$([A-Za-z_]\w*))\s*\)")


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

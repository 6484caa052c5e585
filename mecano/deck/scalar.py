"""Plain scalars of YAML 1.2, core schema: ``7e10`` is a number; ``no``, ``on`` and ``12:30:45`` are texts."""

import re
from typing import TypeAlias

Scalar: TypeAlias = None | bool | int | float | str
NUMBER_START = frozenset("-+.0123456789")
INTEGER = re.compile(r"[-+]?[0-9]+")
RADIX = re.compile(r"0o[0-7]+|0x[0-9a-fA-F]+")
FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
WORDS: dict[str, Scalar] = {word: None for word in ("", "~", "null", "Null", "NULL")}
WORDS |= {word: True for word in ("true", "True", "TRUE")}
WORDS |= {word: False for word in ("false", "False", "FALSE")}
EXACT_DIGITS = 15  # whole numbers with more digits are not all exact as floats


def resolved(text: str) -> Scalar:
    """Return the value of a plain scalar: None, bool, int, float or the text itself."""
    if text[:1] in NUMBER_START:
        value = number(text)
        return text if value is None else value
    return WORDS.get(text, text)


def number(text: str) -> int | float | None:
    """Return the int or float of a plain scalar, or None; numbers that are too large become infinite."""
    if INTEGER.fullmatch(text):
        return int(text) if len(text) <= EXACT_DIGITS else float(text)
    if FLOAT.fullmatch(text):
        return float(text)
    if RADIX.fullmatch(text):
        return _radix(text)
    if NOT_FINITE.fullmatch(text):
        return float(text.replace(".", ""))
    return None


def _radix(text):
    value = int(text[2:], 16 if text[1] == "x" else 8)
    return value if value < 10**EXACT_DIGITS else (float(value) if value < 2**1000 else float("inf"))

"""Errors of the compiler in the words of mecano."""

import re
from contextlib import contextmanager

from numba.core.errors import NumbaError

from mecano.errors import CompilationError

COLOUR = re.compile("\x1b\\[[0-9;]*m")
PLACE = re.compile(r"^During: .* at (\S+) \((\d+)\)$", re.MULTILINE)  # first the innermost one
STAGES = ("Failed in", "During:", "File ", "[", "<source")  # beginnings of lines that give no reason


@contextmanager
def compilation_errors():
    """Raise CompilationError with place and reason for an error of numba."""
    try:
        yield
    except NumbaError as error:
        raise CompilationError(_in_words(COLOUR.sub("", str(error)))) from error


def _in_words(text):
    """Return the innermost place and the reason in the text of an error of numba, on one line."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    reasons = [line for line in lines if not line.startswith(STAGES)] or lines
    reason = " ".join(reasons[:2]) if reasons[0].endswith(":") else reasons[0]
    place = PLACE.search(text)
    return f"{f'{place[1]}:{place[2]}: ' if place else ''}a kernel cannot be compiled: {reason}"

"""Errors of the compiler in the words of mecano."""

import math
import os
import re
from contextlib import contextmanager
from traceback import walk_tb

import numba
from numba.core.errors import NumbaError
from numba.core.types import Record

from mecano.errors import CompilationError

COLOUR = re.compile("\x1b\\[[0-9;]*m")
PLACE = re.compile(r"^During: .* at (\S+) \((\d+)\)$", re.MULTILINE)  # first the innermost one
OF_NUMBA = os.path.dirname(numba.__file__) + os.sep
CALLED = re.compile(r"^During: resolving callee type: .*<function (?:\S+\.)?(\w+) at", re.MULTILINE)  # the same
STAGES = ("Failed in", "During:", "File ", "[", "<source")  # beginnings of lines that give no reason
ADDRESS = re.compile(r" object at 0x\w+")
PLAIN_MATH = (
    "functions of Python's math and the operator ** take plain numbers only, power(a, 3) any: "
    "write those of mecano.maths.dual"
)
REMEDIES = (  # (what the reason contains, what to write instead)
    (re.compile(rf"function (?:{'|'.join(vars(math))})>.*signature: >>> \w+\(.*(?:Dual|Lanes)"), PLAIN_MATH),
    (
        re.compile(r"bool\(Mask\)"),
        "the condition differs between the elements that are computed at once: write select(condition, a, b), or "
        "branch on everywhere(condition) or anywhere(condition), of mecano.maths.dual",
    ),
    (
        re.compile(r"(?:matmul|dot|cross|add_vec|_impl)\(.*array\(|numba_xxgem"),
        "at.R[0] and p.axis are arrays: their matrix and vector are mat(at.R[0]) and vec(p.axis, 0), of "
        "mecano.maths.vector",
    ),
)


@contextmanager
def compilation_errors(name=""):
    """Raise CompilationError with place and reason for an error of numba, or for code that is no kernel.

    ``name``: of the Code that is compiled. The error of numba, 150 lines of its stages, is not chained.
    """
    try:
        yield
    except NumbaError as error:
        raise CompilationError(_in_words(ADDRESS.sub("", COLOUR.sub("", str(error))))) from None
    except SystemError as error:  # of compiler.py, with the symbol of the code
        if (start := str(error).find("needs ")) < 0:
            raise
        reason = str(error)[start:]
        raise CompilationError(f"the kernel '{name}' cannot be compiled: it {reason}{_remedy(reason)}") from None
    except KeyError as error:  # so numba says that a record has no such field
        if not (text := _unknown_field(error)):
            raise
        raise CompilationError(text) from error


def _unknown_field(error):
    """Return the text on a field that a record does not have, with the place that reads it; "" for another error."""
    frames = [frame for frame, _ in walk_tb(error.__traceback__)]
    record = frames[-1].f_locals.get("self")
    if not isinstance(record, Record):
        return ""
    readers = [frame.f_locals["self"] for frame in frames if hasattr(frame.f_locals.get("self"), "loc")]
    place = f"{readers[-1].loc.filename}:{readers[-1].loc.line}: " if readers else ""
    return (
        f"{place}a kernel cannot be compiled: the record p has no field '{error.args[0]}'; "
        f"known: {', '.join(record.fields)}"
    )


def _in_words(text):
    """Return the innermost place and the reason in the text of an error of numba, on one line.

    A name that is not defined has no place: the function that uses it is named instead.
    """
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    reasons = [line for line in lines if not line.startswith(STAGES)] or lines
    reason = " ".join(reasons[:2]) if reasons[0].endswith(":") else reasons[0]
    places = [found for found in PLACE.finditer(text) if not found[1].startswith(OF_NUMBA)]
    place, used = (places or [None])[0], CALLED.search(text)
    if reason.startswith("NameError") and used:
        return f"the kernel '{used[1]}' cannot be compiled: {reason.removeprefix('NameError: ')}"
    return f"{f'{place[1]}:{place[2]}: ' if place else ''}a kernel cannot be compiled: {reason}{_remedy(reason)}"


def _remedy(reason):
    """Return what to write instead, after a semicolon; "" if no remedy is known."""
    return "".join(f"; {instead}" for pattern, instead in REMEDIES if pattern.search(reason))

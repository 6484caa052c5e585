"""The reason of the end of a run, as stored in ``run/reason``, with the warnings found at its end."""

from collections.abc import Iterable

SEPARATOR = ";\n"
ENDED = "the end was reached"  # reason of most complete runs
UNTIL = "{} was met"  # of runs that a condition ends


def with_warnings(reason: str, warnings: Iterable[str]) -> str:
    """Return the text to store of a complete run that ends for a ``reason``, with ``warnings`` found at its end."""
    return SEPARATOR.join([reason, *(text.replace("\n", " ") for text in warnings)])


def split_reason(stored: str) -> tuple[str, list[str]]:
    """Return (reason, list of warnings) of the stored text of a complete run."""
    reason, *warnings = stored.split(SEPARATOR)
    return reason, warnings

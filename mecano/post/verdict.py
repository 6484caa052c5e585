"""The verdict on a run: how it ended, and whether there are warnings."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mecano.results.reader import Results

WARNED = "with warnings"
RESUMED, DOUBT = "resumed at", ";"  # a resumed run has the same bits, unless its note gives a doubt


def warnings_and_remarks(results: "Results") -> tuple[list[str], list[str]]:
    """Return the warnings of a run, and the remarks that it was resumed, which leave its results as they are."""
    remarks = [text for text in results.warnings if text.startswith(RESUMED) and DOUBT not in text]
    return [text for text in results.warnings if text not in remarks], remarks


def is_sound(results: "Results") -> bool:
    """Return whether the run is complete or running, without warnings."""
    return results.status in ("complete", "running") and not warnings_and_remarks(results)[0]


def verdict(results: "Results") -> str:
    """Return the status of the run, with "with warnings" if there are any."""
    return f"{results.status} {WARNED}" if warnings_and_remarks(results)[0] else results.status

"""The verdict on a run: how it ended, and whether there are warnings."""

from mecano.results.reader import Results

WARNED = "with warnings"


def is_sound(results: Results) -> bool:
    """Return whether the run is complete or running, without warnings."""
    return results.status in ("complete", "running") and not results.warnings


def verdict(results: Results) -> str:
    """Return the status of the run, with "with warnings" if there are any."""
    return f"{results.status} {WARNED}" if results.warnings else results.status

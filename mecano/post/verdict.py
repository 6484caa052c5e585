"""The verdict on a run: how it ended, and whether there are warnings."""

WARNED = "with warnings"


def sound(results):
    """Return whether the run is complete or running, without warnings."""
    return results.status in ("complete", "running") and not results.warnings


def verdict(results):
    """Return the status of the run, with "with warnings" if there are any."""
    return f"{results.status} {WARNED}" if results.warnings else results.status

"""The verdict on a run: how it ended, and whether there are warnings."""

ENDED = "the end was reached"  # beginning of the reason of a completed run
WARNED = "with warnings"


def warned(results):
    """Return whether there are warnings from the start or from the end of the run."""
    at_the_end = results.status == "complete" and results.reason.strip().removeprefix(ENDED)
    return bool(results.warnings or (at_the_end and results.reason.startswith(ENDED)))


def sound(results):
    """Return whether the run is complete or running, without warnings."""
    return results.status in ("complete", "running") and not warned(results)


def verdict(results):
    """Return the status of the run, with "with warnings" if there are any."""
    return f"{results.status} {WARNED}" if warned(results) else results.status

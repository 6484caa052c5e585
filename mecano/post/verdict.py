"""The verdict on a run: how it ended, and whether it warns of something."""

ENDED = "the end was reached"  # how the reason of a run begins that came to its end
WARNED = "with warnings"


def warned(results):
    """Return True when the run warned at its start, or at its end of what happened in it."""
    at_the_end = results.status == "complete" and results.reason.strip().removeprefix(ENDED)
    return bool(results.warnings or (at_the_end and results.reason.startswith(ENDED)))


def sound(results):
    """Return True when the run came to its end, or goes on, and warns of nothing."""
    return results.status in ("complete", "running") and not warned(results)


def verdict(results):
    """Return how the run ended, with its warnings, in words."""
    return f"{results.status} {WARNED}" if warned(results) else results.status

"""The verdict on a run: how it ended, and what it warns of."""


def sound(results):
    """Return True when the run came to its end, or goes on, and warns of nothing."""
    return results.status in ("complete", "running") and not results.remarks


def verdict(results):
    """Return how the run ended and how many warnings there are, in words."""
    count = len(results.remarks)
    warnings = f", {count} warning{'s' * (count > 1)}" if count else ""
    return f"{results.status}{warnings}"

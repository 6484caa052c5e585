"""The verdict on a run: how it ended, and what it warns of."""


def sound(results):
    """Return True when the run came to its end and warns of nothing."""
    return results.status == "complete" and not results.warnings


def verdict(results):
    """Return how the run ended and how many warnings there are, in words."""
    count = len(results.warnings)
    warnings = f", {count} warning{'s' * (count > 1)}" if count else ""
    return f"{results.status}{warnings}"

"""Lists of names in messages."""


def name_list(names, most, separator=", "):
    """Return up to ``most`` names as text, with the number of further ones: "a, b, and 3 more"."""
    more = len(names) - most
    return separator.join([*names[:most], *([f"and {more} more"] if more > 0 else [])])

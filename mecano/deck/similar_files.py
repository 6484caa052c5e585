"""Files with names similar to that of a file that cannot be read."""

import os

from mecano.deck.similar_names import similar
from mecano.deck.wording import quoted

LONGEST_NAME, MOST_NAMES = 80, 1000  # among which a similar one is searched


def similar_files(path, endings):
    """Return a hint on files with these endings in the folder of a path whose names are similar to its own, or ""."""
    folder, name = os.path.split(path)
    try:
        names = {os.path.splitext(n)[0]: n for n in sorted(os.listdir(folder or ".")) if n.endswith(endings)}
    except (OSError, ValueError):
        return ""
    few = len(name) <= LONGEST_NAME and len(names) <= MOST_NAMES
    near = [quoted(names[stem]) for stem in similar(os.path.splitext(name)[0], names)] if few else []
    return f"did you mean {' or '.join(near)}?" if near else ""

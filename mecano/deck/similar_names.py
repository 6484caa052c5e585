"""Names similar to a mistyped word: those with the fewest letters wrong, omitted, added or exchanged."""

from collections import Counter
from collections.abc import Iterable

LIMITS = (0, 0, 1)  # admissible wrong letters by length of the word; two in longer words
MOST = 8  # names at equal distance: as many as bodies are numbered in most mechanisms


def similar(word: str, known: Iterable[str]) -> list[str]:
    """Return at most ``MOST`` names of ``known`` that are nearest to ``word``; none if no name is similar."""
    from difflib import SequenceMatcher, get_close_matches  # not needed by decks without mistakes

    limit, word = LIMITS[len(word)] if len(word) < len(LIMITS) else 2, word.lower()
    letters = Counter(word)
    found: dict[int, list[str]] = {}  # by their distance
    for name in dict.fromkeys(known):
        lower = name.lower()
        if abs(len(lower) - len(word)) > limit or (letters - Counter(lower)).total() > limit:
            continue
        distance = edits(word, lower)
        if distance <= limit:
            found.setdefault(distance, []).append(name)
    if found:
        nearest = found[min(found)]
        likeness = {name: SequenceMatcher(None, word, name.lower()).ratio() for name in nearest}
        return sorted(nearest, key=lambda name: likeness[name], reverse=True)[:MOST]  # equal ones in their order
    return get_close_matches(word, known, n=1, cutoff=0.6)


def edits(a: str, b: str) -> int:
    """Return the number of letters replaced, omitted, added, or exchanged with the next, from ``a`` to ``b``.

    The optimal string alignment distance, a restricted Damerau-Levenshtein distance.
    """
    before: list[int] = []
    row = list(range(len(b) + 1))
    for i, x in enumerate(a, 1):
        last, before, row = before, row, [i]
        for j, y in enumerate(b, 1):
            cost = min(before[j] + 1, row[j - 1] + 1, before[j - 1] + (x != y))
            if i > 1 and j > 1 and x == b[j - 2] and a[i - 2] == y:
                cost = min(cost, last[j - 2] + 1)
            row.append(cost)
    return row[-1]

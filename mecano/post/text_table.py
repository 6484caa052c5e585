"""Tables for a terminal."""

from collections.abc import Iterable, Sequence


def aligned(rows: Iterable[Sequence[str]], signs: str) -> list[str]:
    """Return rows of texts as lines with aligned columns; a sign is "<" for a column on the left, ">" on the right."""
    rows = list(rows)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(f"{x:{s}{w}}" for x, s, w in zip(row, signs, widths, strict=True)).rstrip() for row in rows]

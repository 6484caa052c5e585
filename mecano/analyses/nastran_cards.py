"""Read the cards of a bulk data file of Nastran: small fields of 8 columns, large ones of 16, or free ones."""

import re
from collections.abc import Iterator
from typing import NamedTuple

from mecano.errors import UsageError

SMALL, LARGE = 8, 16  # columns of a field
NAME = 8  # columns of the first field of a line, which names the card or continues it
LAST = 72  # columns of a line with fields, without the mark of its continuation
WITHOUT_E = re.compile(r"([0-9.])([-+][0-9]+)$")  # 1.5-3 is 1.5e-3


class Card(NamedTuple):
    """A card: its line in the file, its name and its fields, without blanks."""

    line: int
    name: str
    fields: list[str]

    def number(self, i: int) -> float:
        """Return field i as a number, 0 if it is empty. Raises UsageError."""
        text = self.field(i)
        try:
            return float(WITHOUT_E.sub(r"\1e\2", text.upper().replace("D", "E"))) if text else 0.0
        except ValueError:
            raise UsageError(f"line {self.line}: '{text}' in a card {self.name} is not a number") from None

    def integer(self, i: int) -> int:
        """Return field i as an integer, 0 if it is empty. Raises UsageError."""
        text = self.field(i)
        if text and not re.fullmatch("-?[0-9]+", text):
            raise UsageError(f"line {self.line}: '{text}' in a card {self.name} is not a whole number")
        return int(text or 0)

    def field(self, i: int) -> str:
        """Return field i, empty if the card ends before it."""
        return self.fields[i] if i < len(self.fields) else ""


def read_cards(text: str) -> Iterator[Card]:
    """Yield the cards of a file with their continuations."""
    card: Card | None = None
    for number, line in enumerate(text.splitlines(), 1):
        line = line.partition("$")[0].expandtabs(SMALL).rstrip()
        if not line:
            continue
        first, fields = _fields(line)
        if first.strip() and first[0] not in "+*":
            if card is not None:
                yield card
            card = Card(number, first.strip("* ").upper(), fields)
        elif card is not None:
            card.fields.extend(fields)
    if card is not None:
        yield card


def _fields(line):
    """Return the first field of a line, and the others: 8 small ones, 4 large ones, or free ones filled to 8 or 4."""
    if "," in line:
        first, *fields = [field.strip() for field in line.split(",")]
        count = 4 if "*" in first else 8
        return first, [*fields, *[""] * count][:count]
    width = LARGE if "*" in line[:NAME] else SMALL
    return line[:NAME], [line[i : i + width].strip() for i in range(NAME, LAST, width)]

"""A page that lists the decks of inputs/ with what is known of each."""

from pathlib import Path

FOLDER = Path(__file__).parents[2] / "inputs"


def decks():
    """{file name: text} of all decks of inputs/."""
    return {path.name: path.read_text(encoding="utf-8") for path in sorted(FOLDER.glob("*.yaml"))}


def page(known):
    """Markdown: every deck of ``known`` with the comment at its head, which says what its answer is."""
    lines = ["# Decks with known answers", "", "The decks of `inputs/`; what comes out of each is known, and tested."]
    for name, text in known.items():
        lines += ["", f"## {name.removesuffix('.yaml')}", "", f"[{name}](../../inputs/{name})"]
        for paragraph in _head(text):
            lines += ["", *paragraph]
    return "\n".join(lines) + "\n"


def _head(text):
    """Paragraphs, lists of lines, of the comment with which a deck begins; indented lines stand as they are."""
    paragraphs = [[]]
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        words = line.removeprefix("#").removeprefix(" ").rstrip()
        if words:
            paragraphs[-1].append(words if words[0] == " " else _escaped(words))
        else:
            paragraphs.append([])
    return [paragraph for paragraph in paragraphs if paragraph]


def _escaped(words):
    return words.replace("*", "\\*").replace("_", "\\_").replace("<", "&lt;")

"""The page that lists the decks of inputs/ with their known answers."""

from pathlib import Path

FOLDER = Path(__file__).parents[2] / "inputs"


def decks():
    """Return {file name: text} of all decks of inputs/."""
    return {path.name: path.read_text(encoding="utf-8") for path in sorted(FOLDER.glob("*.yaml"))}


def page(known):
    """Return Markdown: every deck of ``known`` with the comment at its head, which gives its known answer."""
    lines = ["# Decks with known answers", "", "The decks of `inputs/`. The results of each are known, and tested."]
    for name, text in known.items():
        lines += ["", f"## {name.removesuffix('.yaml')}", "", f"[{name}](../../inputs/{name})"]
        for paragraph in _head(text):
            lines += ["", *paragraph]
    return "\n".join(lines) + "\n"


def _head(text):
    """Return the paragraphs, lists of lines, of the comment at the head of a deck; indented lines are kept."""
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

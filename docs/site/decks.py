"""The gallery: the decks of inputs/ with pictures and known answers."""

import re
from pathlib import Path

from mecano.elements import KINDS

FOLDER = Path(__file__).parents[2] / "inputs"
PICTURES = Path(__file__).parents[1] / "images" / "gallery"
FLEXIBLE = {"beam", "bar", "cable", "superelement"}
TITLE = re.compile("^title: *(.+)$", re.MULTILINE)
HEAD = """# Gallery: decks with known answers

The decks of `inputs/`; `mecano example NAME` writes a copy. A picture leads to its deck, the name below to its
description. The answer to each is known, and tested.
"""


def decks():
    """Return {file name: text} of all decks of inputs/."""
    return {path.name: path.read_text(encoding="utf-8") for path in sorted(FOLDER.glob("*.yaml"))}


def page(known):
    """Return Markdown: pictures by subject, then every deck of ``known`` with the comment at its head."""
    lines, subjects = [HEAD], {}
    for name, text in known.items():
        subjects.setdefault(_subject(text), []).append(name.removesuffix(".yaml"))
    for subject, names in sorted(subjects.items()):
        lines += [f"## {subject}", "", '<div class="gallery">', ""]
        for name in names:
            lines += [_thumbnail(name, known[f"{name}.yaml"]), ""]
        lines += ["</div>", ""]
    lines += ["## What they show"]
    for name, text in known.items():
        lines += ["", f"### {name.removesuffix('.yaml')}", "", f"[{name}](../../inputs/{name})"]
        for paragraph in _head(text):
            lines += ["", *paragraph]
    return "\n".join(lines) + "\n"


def _subject(text):
    """Return the heading under which a deck is shown, from the sections and kinds that it uses."""
    used = set(re.findall(r"\btype: (\w+)", text))
    if "skate" in used or any(KINDS[name].display.shape == "wheel" for name in used & KINDS.keys()):
        return "Wheels, tyres and landing gears"
    if re.search("^signals:", text, re.MULTILINE):
        return "Signals and control"
    if re.search("^static:", text, re.MULTILINE):
        return "Statics and stability"
    return "Beams, cables and superelements" if used & FLEXIBLE else "Mechanisms of rigid bodies"


def _thumbnail(name, text):
    """Return the picture of a deck, a film if there is one, which leads to the deck, and its name."""
    film = (PICTURES / f"{name}_film.webp").exists()
    picture = f"../images/gallery/{name}{'_film' * film}.webp"
    title = TITLE.search(text)[1].strip("\"'")
    return f"[![{title}]({picture})](../../inputs/{name}.yaml)\n[{name}](#{name.replace('_', '-')})"


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

"""The generated pages: commands, reference, example decks, verification."""

import commands
import decks
import reference
import trust
import verification


def write(folder):
    """Write all pages into a folder; files with the right content stay untouched, for quick builds."""
    known = decks.decks()
    made = {
        **reference.pages(known),
        "decks.md": decks.page(known),
        "commands.md": commands.page(),
        **verification.pages(),
        "trust.md": trust.page(),
    }
    for path, content in made.items():
        _write(folder / path, content.encode() if isinstance(content, str) else content)
    for old in folder.rglob("*.*"):
        if old.relative_to(folder).as_posix() not in made:
            old.unlink()


def _write(path, content):
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_bytes() != content:
        path.write_bytes(content)

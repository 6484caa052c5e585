"""``include: [laws.yaml, wheel.yaml]``: sections of other files, merged with those of the deck name by name.

``set: {time.end: 3}`` replaces values of the included files, as an override of the command line does.
"""

import os
from collections.abc import Iterable
from dataclasses import replace

from mecano.deck.compose import Node, Pair, compose
from mecano.deck.source import Unreadable, read_source
from mecano.deck.wording import quoted, similar_files
from mecano.errors import DeckError, Problem
from mecano.schema import Field

MOST_FILES = 100


def confined(folder: str, name: str) -> str | None:
    """Return the real path of a file named in a deck; None if it is not in the folder of the deck or below it."""
    folder = os.path.realpath(folder)
    try:
        path = os.path.realpath(os.path.join(folder, name))
    except ValueError:  # a null character
        return None
    return None if os.path.isabs(name) or os.path.commonpath([folder, path]) != folder else path


class Inclusion:
    """Merger of the sections of a deck and of all files that it includes.

    ``settings`` are the (path, value) of ``set``, those of included files first.
    ``files`` is {name relative to the folder of the deck: SHA-256}; ``beside`` is {file as shown: its folder relative
    to that of the deck}, for the files that it names itself.
    """

    def __init__(self, folder: str, sections: Iterable[Field], problems: list[Problem]):
        self.folder, self.problems = folder, problems
        self.named = {field.name for field in sections if field.type.name == "named"}
        self.sections: dict[str, Pair] = {}
        self.settings: list[Pair] = []
        self.files: dict[str, str] = {}
        self.beside: dict[str, str] = {}
        self.unread = False  # whether a file could not be read
        self._open: list[str] = []  # paths of the files that are being read

    def merged(self, root: Node) -> Node:
        """Return the tree of a deck with the sections of all included files."""
        self._open = [os.path.realpath(root.source.file)]
        self.take(root, "")
        return Node(self.sections, root.source, root.line, root.column)

    def take(self, root: Node, beside: str) -> None:
        """Add the sections of a file in the folder ``beside``, after those of its included files."""
        include = root.value.get("include")
        if include:
            for node in include[1].value if type(include[1].value) is list else [include[1]]:
                self._include(node, beside)
        for section, (key, node) in root.value.items():
            if section == "set":
                self._set(node)
            elif section != "include":
                self._add(section, key, node)

    def _include(self, node, beside):
        if type(node.value) is not str:
            return self._refuse(node, "'include' must be the name of a file, or a list of names")
        name = os.path.normpath(os.path.join(beside, node.value))
        path = confined(self.folder, name)
        if path is None or os.path.isabs(node.value):
            return self._refuse(node, f"file {quoted(node.value)} must lie in the folder of the deck")
        if path in self._open:
            circle = [*self._open[self._open.index(path) :], path]
            shown = " -> ".join(os.path.relpath(file, os.path.realpath(self.folder)) for file in circle)
            return self._refuse(node, f"files include one another in a circle: {shown}")
        if name in self.files:
            return None
        if len(self.files) >= MOST_FILES:
            raise DeckError([*self.problems, Problem(f"more than {MOST_FILES} files are included", node.mark)])
        root = self._read(node, name, path)
        if root is not None:
            self._open.append(path)
            self.take(root, os.path.dirname(name))
            self._open.pop()
        return None

    def _read(self, node, name, path):
        """Return the tree of a file, or None after reporting why it cannot be read."""
        try:
            source, self.files[name] = read_source(path, os.path.join(self.folder, name))
        except Unreadable as error:
            self.unread = True
            hint = similar_files(path, (".yaml", ".yml"))
            return self._refuse(node, f"file {quoted(node.value)} cannot be read: {error}", hint)
        mark = replace(node.mark, role="included at", stack=())
        source = replace(source, stack=(*node.source.stack, mark))
        self.beside[source.file] = os.path.dirname(name)
        root = compose(source, self.problems)
        if root is None or type(root.value) is not dict:
            return self._refuse(root or Node(None, source), "an included file is a mapping of sections")
        return root

    def _add(self, section, key, node):
        if section not in self.sections:
            self.sections[section] = (key, node)
            return
        first_key, first = self.sections[section]
        if section in self.named and type(node.value) is type(first.value) is dict:
            self.sections[section] = (first_key, self._joined(section, first, node))
        elif section != "mecano" or node.value != first.value:
            hint = "" if section == "mecano" else f"a variant changes it by 'set: {{{section}.KEY: VALUE}}'"
            self._refuse(key, f"{quoted(section)} is given twice; first at {first_key.mark}", hint)

    def _set(self, node):
        if type(node.value) is dict:
            self.settings += node.value.values()
        elif node.value is not None:
            self._refuse(node, "'set' must be a mapping of paths in the deck to values: {time.end: 2}")

    def _joined(self, section, first, node):
        for name, (key, _) in node.value.items():
            if name in first.value:
                hint = f"a variant replaces it by 'set: {{{section}.{name}: VALUE}}'"
                self._refuse(key, f"{quoted(name)} is given twice; first at {first.value[name][0].mark}", hint)
        return Node({**first.value, **node.value}, first.source, first.line, first.column)

    def _refuse(self, node, message, hint=""):
        self.problems.append(Problem(message, node.mark, hint))

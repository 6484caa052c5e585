"""YAML events -> a tree of nodes with their positions in the text.

The tree is built from the events without recursion and under limits, because the composer of the C library
crashes on deeply nested input and expands aliases without bound. Anchors and aliases are allowed, tags are not.
"""

import re
from typing import Any, NoReturn, TypeAlias

import yaml

from mecano.deck.scalar import resolved
from mecano.deck.source import Source
from mecano.deck.wording import quoted, suggestion
from mecano.errors import DeckError, Mark, Problem

LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
MAX_DEPTH = 64
TOO_DEEP = f"nested more than {MAX_DEPTH} levels deep"
MAX_NODES = 4_000_000
MAX_MARKS = 3_500_000  # ':' and ',' in a text: a deck with far more values is refused before it is parsed
MAX_EXPANDED = 100_000  # nodes that aliases may add
MAX_ITEMS = 100_000  # of one list: YAML takes 5 us and 150 B for each
NAME = r"[^\W\d][\w$()-]*"
LONGEST_FORMULA = 1000  # characters of one without quotes
ITEM_START = frozenset("-+.0123456789$(")  # of an item of a list that is a number
CONTROL = "[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff]"

Content: TypeAlias = Any  # of a node: a scalar, a list of nodes, or {key: (node of the key, node)}

Pair: TypeAlias = "tuple[Node, Node]"  # of a mapping: the node of a key, and that of its value


class Node:
    """A value and its position: ``value`` is a scalar, a list of nodes, or {key: (node of the key, node)}."""

    __slots__ = ("value", "raw", "source", "line", "column")

    def __init__(self, value: Content, source: Source, line: int = 0, column: int = 0, raw: str = ""):
        self.value = value
        self.raw = raw
        self.source = source
        self.line = line
        self.column = column

    @property
    def mark(self) -> Mark:
        """Mark of the beginning of the value."""
        return self.source.mark(self.line, self.column)


class CopiedFormula(Node):
    """A formula with values of parameters written into it, whose i-th operands have ``units`` {i: SI unit}."""

    __slots__ = ("units",)

    def __init__(self, node: Node, value: str, units: dict[int, str]):
        super().__init__(value, node.source, node.line, node.column, node.raw)
        self.units = units


class Given(Node):
    """The number of the parameter ``text``, "$name", that is ``given`` with a unit."""

    __slots__ = ("text", "given")

    def __init__(self, value: float, node: Node, text: str, given: str):
        super().__init__(value, node.source, node.line, node.column, f"{value} ({text})")
        self.text = text
        self.given = given


class Continued(Node):
    """A list without brackets, or a formula without quotes, with the items that follow its first comma."""

    __slots__ = ()

    def __init__(self, node: Node):
        formula = type(node.value) is str and _is_open(node.raw)
        value = node.raw if formula else [_without_brackets(node)]
        super().__init__(value, node.source, node.line, node.column, node.raw)

    def add(self, item: Node) -> None:
        """Append an item."""
        if type(self.value) is str and len(self.value) <= LONGEST_FORMULA:
            self.value = self.raw = f"{self.value}, {item.raw}"
        elif type(self.value) is list:
            self.value.append(_without_brackets(item))

    def hint(self, name: str) -> str:
        """Return what to write for the key ``name``; more items may follow."""
        if type(self.value) is str:
            return "put a formula with commas in quotes"
        return f"a list is written in brackets: {name}: [{', '.join(item.raw for item in self.value)}, ...]"


class Frame:
    """A list or mapping that is still open."""

    __slots__ = ("node", "key", "size", "height", "anchor")

    def __init__(self, node: Node, anchor: str | None):
        self.node = node
        self.key: Node | None = None
        self.size = 1  # nodes in it, aliases expanded
        self.height = 0  # levels below it
        self.anchor = anchor


class Composer:
    """Builder of the tree of one document: ``root`` is the tree, ``problems`` are errors that do not stop it."""

    def __init__(self, source: Source, problems: list[Problem]):
        self.source = source
        self.problems = problems
        self.root: Node | None = None
        self.frames: list[Frame] = []
        self.anchors: dict[str, tuple[Node, int, int] | None] = {}  # (node, size, height), or None while it is open
        self.count = 0
        self.expanded = 0
        self.documents = 0

    def take(self, event: yaml.Event) -> None:
        """Add one event to the tree."""
        handler = HANDLERS.get(type(event))
        if handler:
            handler(self, event)

    def scalar(self, event: yaml.ScalarEvent) -> None:
        """Add a scalar: plain ones become numbers, booleans or null; quoted ones and blocks are texts."""
        text = event.value
        plain = event.implicit[0] and event.tag is None
        node = self.new(event, resolved(text) if plain else text, text)
        if event.style == '"' and re.search(CONTROL, text):
            self.problem("control characters are not allowed", node)
        if event.anchor:
            self.anchors[event.anchor] = (node, 1, 0)
        self.add(node, 1, 0)

    def open_list(self, event: yaml.SequenceStartEvent) -> None:
        """Open a list."""
        self.open(event, [])

    def open_mapping(self, event: yaml.MappingStartEvent) -> None:
        """Open a mapping."""
        self.open(event, {})

    def open(self, event: yaml.CollectionStartEvent, value: Content) -> None:
        """Open a list or mapping; attach it now and count it when it is closed."""
        node = self.new(event, value)
        if len(self.frames) >= MAX_DEPTH:
            self.stop(TOO_DEEP, node)
        self.attach(node)
        if event.anchor:
            self.anchors[event.anchor] = None
        self.frames.append(Frame(node, event.anchor))

    def close(self, _: yaml.CollectionEndEvent) -> None:
        """Close a list or mapping."""
        frame = self.frames.pop()
        if frame.anchor:
            self.anchors[frame.anchor] = (frame.node, frame.size, frame.height)
        self.measure(frame.size, frame.height)

    def alias(self, event: yaml.AliasEvent) -> None:
        """Add a referenced node; refuse one that contains itself or expands to too many values."""
        place = Node(None, self.source, event.start_mark.line, event.start_mark.column)
        if event.anchor not in self.anchors:
            hint = suggestion(event.anchor, self.anchors)
            self.stop(f"unknown alias {quoted('*' + event.anchor)}", place, hint)
        anchored = self.anchors[event.anchor]
        if anchored is None:
            self.stop(f"alias {quoted('*' + event.anchor)} is inside the value that it refers to", place)
        node, size, height = anchored
        self.expanded += size
        if self.expanded > MAX_EXPANDED:
            self.stop(f"aliases expand to more than {MAX_EXPANDED} values", place)
        if len(self.frames) + height > MAX_DEPTH:
            self.stop(TOO_DEEP, place)
        self.add(node, size, height)

    def document(self, event: yaml.DocumentStartEvent) -> None:
        """Begin a document; refuse a second one."""
        self.documents += 1
        if self.documents > 1:
            self.stop("a deck is one YAML document; this is the second", self.new(event, None))

    def new(self, event: yaml.Event, value: Content, raw: str = "") -> Node:
        """Return a new node at the position of an event."""
        mark = event.start_mark
        node = Node(value, self.source, mark.line, mark.column, raw)
        self.count += 1
        if self.count > MAX_NODES:
            self.stop(f"more than {MAX_NODES} values", node)
        if getattr(event, "tag", None) is not None:
            self.problem(f"tags such as {quoted(event.tag)} are not used in decks", node)
        return node

    def add(self, node: Node, size: int, height: int) -> None:
        """Attach a complete node."""
        self.attach(node)
        self.measure(size, height)

    def measure(self, size: int, height: int) -> None:
        """Count a complete node in the collection around it."""
        if self.frames:
            frame = self.frames[-1]
            frame.size += size
            if height >= frame.height:
                frame.height = height + 1

    def attach(self, node: Node) -> None:
        """Put a node into the collection around it, as a key, a value or an item."""
        if not self.frames:
            self.root = node
            return
        frame = self.frames[-1]
        if type(frame.node.value) is list:
            frame.node.value.append(node)
            if len(frame.node.value) > MAX_ITEMS:
                hint = "put a long table into a CSV file next to the deck: 'table: {file: NAME.csv}'"
                self.stop(f"a list of more than {MAX_ITEMS} values", frame.node, hint)
        elif frame.key is None:
            frame.key = node
        else:
            key, frame.key = frame.key, None
            self.pair(frame.node.value, key, node)

    def pair(self, mapping: dict[str, Pair], key: Node, node: Node) -> None:
        """Put a key and its value into a mapping, unless the key is not a text, a duplicate, or belongs to a value."""
        if node.value is None and _is_item(mapping, key, node):
            self.continued(mapping, key)
        elif type(key.value) is not str:
            shown = quoted(key.raw) if key.raw else "nothing" if key.value is None else "a list or mapping"
            hint = "a name begins with a letter, such as n1"
            if _is_bare(key, node):
                hint = "write a key and ':' before it"
            elif key.raw and (key.value is None or type(key.value) is bool):
                hint = "put it in quotes"
            self.problem(f"a key must be a name, got {shown}", key, hint)
        elif key.value in mapping:
            line = mapping[key.value][0].line + 1
            self.problem(f"duplicate key {quoted(key.value)}, first given in line {line}", key)
        else:
            mapping[key.value] = (key, node)

    def continued(self, mapping: dict[str, Pair], item: Node) -> None:
        """Report an item that continues the last value of a mapping, and correct this value, to report it once."""
        name, (key, value) = next(reversed(mapping.items()))
        if type(value) is Continued:
            if len(value.value) > MAX_ITEMS:
                self.stop(f"a list of more than {MAX_ITEMS} values", value)
            value.add(item)
            return
        if whole := _with_comma(value, item):
            hint = f"a decimal point, not a comma: {whole}" if "." not in item.raw else f"write {whole}"
            correct = Node(resolved(whole), self.source, value.line, value.column, whole)
        else:
            correct = Continued(value)
            correct.add(item)
            hint = correct.hint(name)
        mapping[name] = (key, correct)
        self.problem(f"a key must be a name, got {quoted(item.raw)}", item, hint)

    def problem(self, message: str, node: Node, hint: str = "") -> None:
        """Record a problem and continue."""
        self.problems.append(Problem(message, node.mark, hint))

    def stop(self, message: str, node: Node, hint: str = "") -> NoReturn:
        """Raise DeckError with all problems and this one."""
        raise DeckError([*self.problems, Problem(message, node.mark, hint)])


HANDLERS = {
    yaml.ScalarEvent: Composer.scalar,
    yaml.SequenceStartEvent: Composer.open_list,
    yaml.MappingStartEvent: Composer.open_mapping,
    yaml.SequenceEndEvent: Composer.close,
    yaml.MappingEndEvent: Composer.close,
    yaml.AliasEvent: Composer.alias,
    yaml.DocumentStartEvent: Composer.document,
}


def compose(source: Source, problems: list[Problem], loader: type = LOADER) -> Node | None:
    """Return the root Node of a Source, or None if it is empty; adds to ``problems``, raises DeckError."""
    composer = Composer(source, problems)
    if (marks := sum(map(source.text.count, ":,"))) > MAX_MARKS:
        composer.stop(f"more than {MAX_NODES} values: {marks} of ':' and ','", Node(None, source))
    try:
        for event in yaml.parse(source.text[source.begin :], Loader=loader):
            composer.take(event)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = Node(None, source, mark.line, mark.column) if mark else Node(None, source)
        from mecano.deck.syntax_errors import syntax_error, syntax_hint  # few decks need it

        too_deep = "nesting depth" in (error.problem or "")  # libyaml reads ahead and has a limit of its own
        if too_deep:
            composer.stop(TOO_DEEP, place)
        composer.stop(syntax_error(error), place, syntax_hint(error, place))
    except (yaml.YAMLError, ValueError, OverflowError) as error:
        composer.stop(f"not valid YAML: {error}".splitlines()[0], Node(None, source))
    return composer.root


def _is_item(mapping, key, node):
    """Return True if a key is not a name, stands alone and follows a scalar: the "0" of {position: 1, 0, 0}."""
    if not mapping or not _is_bare(key, node):
        return False
    _, before = next(reversed(mapping.values()))
    if type(before.value) is str and _is_open(before.value):
        return True
    if re.fullmatch(NAME, key.raw) or ":" in key.raw or "=" in key.raw:
        return False
    scalar = type(before.value) not in (list, dict, type(None))
    return type(before) is Continued or (scalar and key.raw[0] in ITEM_START)


def _is_open(text):
    """Return True if a text is the beginning of a call of a function, "max(time"."""
    return len(text) <= LONGEST_FORMULA and text[:1] != "(" and text.count("(") > text.count(")")


def _without_brackets(item):
    """Return an item of a list in round brackets, (1, 0, 0), without the brackets."""
    opened, closed = "(" in item.raw, ")" in item.raw
    text = item.raw if opened == closed else item.raw.lstrip("(") if opened else item.raw.rstrip(")")
    return Node(resolved(text), item.source, item.line, item.column, text)


def _is_bare(key, node):
    """Return True if a key of a mapping in one line has neither a colon nor a value."""
    end = (key.line, key.column + len(key.raw))
    return key.raw != "" and node.raw == "" and node.value is None and (node.line, node.column) == end


def _with_comma(before, item):
    """Return the number with ``before`` and ``item`` as the digits around a comma, "1,5 kg", or ""."""
    behind = item.line == before.line and item.column == before.column + len(before.raw) + 1
    if not behind or type(before.value) is not int or not item.raw[0].isdigit():
        return ""
    return before.raw + ("" if "." in item.raw else ".") + item.raw

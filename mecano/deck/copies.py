"""Expansion of entries with ``repeat``, of templates placed by ``place``, and of words, into plain entries.

Any entry of a section of names may have ``repeat``; its values are inserted into the name and the expressions:

    nodes:
      p$i: {repeat: {i: 0..5}, position: [0.1 * $i, 0, 0]}

So may an item of a list in an entry: ``[first, {repeat: {i: 1..6}, items: [a$i, b$i]}, last]``.

A template is a small deck with parameters of its own; ``place`` puts copies of it into the deck. Entries that refer to
a parameter that is a word are copied once, with the word in its place.
"""

from collections.abc import Iterable
from contextlib import contextmanager
from dataclasses import field, replace
from typing import TypeAlias

from mecano.deck.compose import CopiedFormula, Given, Node, Pair
from mecano.deck.containers import singular
from mecano.deck.copied_formulas import filled_in, is_formula
from mecano.deck.expressions import ExpressionError, check_inserts, has_inserts, inserted, mentions
from mecano.deck.formulas import has_units
from mecano.deck.parameters import Parameters, Refused, is_word
from mecano.deck.placing import Placement, Placing, Word
from mecano.deck.repeat import VALUE, rows
from mecano.deck.scope import INVALID, Scope
from mecano.deck.source import Source
from mecano.deck.templates import Templates, place_values
from mecano.deck.values import number
from mecano.deck.wording import quoted
from mecano.errors import DeckError, Mark, Problem
from mecano.immutable import mutable
from mecano.schema import Field

Entries: TypeAlias = dict[str, Pair]  # of a section, by name
HOW_IN_A_LIST = "write [first, {repeat: {i: 1..6}, items: [a$i, b$i]}, last]"
MOST_VALUES = 400_000
MOST_PLACED = 10_000


@mutable
class Level:
    """The deck, or a copy of a template: its parameters, its place, and its sources as seen from there."""

    parameters: Parameters
    stack: tuple[Mark, ...] = ()
    sources: dict[int, Source] = field(default_factory=dict)

    def source(self, source: Source) -> Source:
        """Return the Source with marks that include the place of the copy."""
        if not self.stack:
            return source
        if id(source) not in self.sources:
            self.sources[id(source)] = replace(source, stack=self.stack)
        return self.sources[id(source)]


class Copies:
    """Expansion of the copies of one deck."""

    def __init__(self, root: Node, sections: Iterable[Field], scope: Scope):
        self.scope = scope
        self.fields = {f.name: f for f in sections if f.type.name == "named" and f.name != "parameters"}
        self.problems = len(scope.problems)
        self.without_value: Node | None = None  # that needs a parameter without a value, which is refused elsewhere
        self.templates = Templates(root, self.fields, scope)
        self.deck = Level(scope.parameters)
        self.words = scope.parameters.words = _words(root, scope.parameters)
        self.count = self.count_placed = 0

    @property
    def incomplete(self) -> bool:
        """True if anything was refused."""
        return self.without_value is not None or len(self.scope.problems) > self.problems

    def written_out(self, root: Node) -> Node:
        """Return the tree of the deck without templates, places, repeats, and words among the parameters."""
        value = {key: pair for key, pair in root.value.items() if key not in ("templates", "place")}
        for name in [name for name in value if name not in self.fields and name != "parameters"]:
            key, node = value[name]
            if self._is_inserted_into(node) or repeats_items(node):
                value[name] = (key, self.copy(node, self.deck))
        for section, entries in self.sections(root, self.deck).items():
            if entries or section in value:
                key, node = root.value.get(section, (root, root))
                value[section] = (key, Node(entries, node.source, node.line, node.column))
        self.scope.unplaced = self.templates.unplaced(root)
        if self.words and "parameters" in value:
            from mecano.deck.words import without

            key, node = root.value["parameters"]
            value["parameters"] = (key, without(node, self.words))  # those that remain are numbers
        return Node(value, root.source, root.line, root.column)

    def with_items(self, node: Node) -> Node:
        """Return a value of an override with words, and the repeated items of its lists, written out."""
        return self.copy(node, self.deck) if self._is_inserted_into(node) or repeats_items(node) else node

    def sections(self, body: Node, level: Level) -> dict[str, Entries]:
        """Return {section: {name: (key, node)}} of the deck or of a template, including the templates it places."""
        found = {}
        for section in self.fields:
            given = body.value.get(section)
            if given is None or type(given[1].value) is dict:
                found[section] = self.entries(given, section, level) if given else {}
        placed = body.value.get("place")
        for name, (key, node) in self.entries(placed, "place", level).items() if placed else ():
            for section, entries in self.placed(name, key, node).items():
                for inner, (inner_key, entry) in entries.items():
                    self._add(found.get(section, {}), inner, inner_key, entry)
        return found

    def entries(self, given: Pair, section: str, level: Level) -> Entries:
        """Return {name: (key, node)} of a section, with the copies made by ``repeat``."""
        found: Entries = {}
        if type(given[1].value) is not dict:
            self.scope.refuse(given[1], f"{quoted(section)} must be a mapping of names")
            return found
        for name, (key, node) in given[1].value.items():
            repeated = is_repeated(node)
            plain = level is self.deck and not repeated and section != "place"
            if plain and not (self._is_inserted_into(key) or self._is_inserted_into(node) or repeats_items(node)):
                found[name] = (key, node)
                continue
            with self._about(f"{singular(section)} {quoted(name)}", level.parameters):
                for parameters in self._rows(key, node, level, level.parameters) if repeated else [level.parameters]:
                    self.scope.parameters = parameters
                    self._copy_entry(key, _without_repeat(node) if repeated else node, level, found)
        return found

    def _is_inserted_into(self, node):
        """Return whether a tree has an expression with a word among the parameters of the deck, or a name with any."""
        return mentions(node, self.words, self.deck.parameters.nodes)

    def _copy_entry(self, key, node, level, found):
        before = len(self.scope.problems)
        copied, entry = self.copy(key, level), self.copy(node, level)
        if type(copied.value) is not str:
            self.scope.refuse(copied, f"a name begins with a letter or '_': {quoted(key.value)} is {copied.value:g}")
        elif len(self.scope.problems) > before:
            return
        elif "$" in copied.value:  # it was not the name of a value, nor an expression in brackets
            self.scope.refuse(copied, "what follows a $ in a name is a value or in brackets: p$i, p$(i + 1)")
        else:
            self._add(found, copied.value, copied, entry)

    def _rows(self, key, node, level, outer):
        """Return the Parameters of each copy of an entry or of the items of a list, within the ``outer`` ones."""
        values = rows(node.value["repeat"][1], self.scope, MOST_VALUES - self.count)
        if values is INVALID:
            self.without_value = key
            return []
        if len(values) > 1 and key is not node and "$" not in key.value:
            how = f"put a value of 'repeat' into it, as in '{key.value}$({next(iter(values[0]))})'"
            self.scope.refuse(key, f"all copies would have the name {quoted(key.value)}", how)
            return []
        placed = [{name: self._at(value, level) for name, value in row.items()} for row in values]
        return [Parameters(row, outer) for row in placed]

    def copy(self, node: Node, level: Level) -> Node:
        """Return the tree with the values of the current parameters in place of expressions and inserts."""
        self.count += 1
        if self.count > MOST_VALUES:
            text = f"'repeat' and 'place' make more than {MOST_VALUES} values"
            raise DeckError([*self.scope.problems, Problem(text, node.mark)])
        value, source = node.value, level.source(node.source)
        if type(value) is str and "$" in value:
            return self._text(Node(value, source, node.line, node.column, node.raw))
        if type(value) is dict:
            value = {name: (key, self.copy(inner, level)) for name, (key, inner) in value.items()}
            if level.stack:
                value = {name: (self._at(key, level), inner) for name, (key, inner) in value.items()}
        elif type(value) is list:
            value = [copied for item in value for copied in self._items(item, level)]
        return Node(value, source, node.line, node.column, node.raw)

    def _items(self, node, level):
        """Return the copies of an item of a list: one, or for each value of its ``repeat`` those of its ``items``."""
        if not is_repeated(node):
            return [self.copy(node, level)]
        if set(node.value) != {"repeat", "items"} or type(node.value["items"][1].value) is not list:
            self.scope.refuse(node, "in a list, 'repeat' comes with a list of 'items'", HOW_IN_A_LIST)
            return []
        outer, copies = self.scope.parameters, []
        for parameters in self._rows(node, node, level, outer):
            self.scope.parameters = parameters
            copies += [copied for item in node.value["items"][1].value for copied in self._items(item, level)]
        self.scope.parameters = outer
        return copies

    def _at(self, node, level):
        """Return a scalar with the place of the copy."""
        return Node(node.value, level.source(node.source), node.line, node.column, node.raw)

    def _text(self, node):
        """Evaluate a text with $: a formula, a name with inserts, a parameter that is a word, or an expression."""
        text, scope = node.value, self.scope
        try:
            check_inserts(text)
            if is_formula(text, scope.parameters):
                return self._formula(node)
            if has_inserts(text):
                node.value = inserted(text, scope.parameters)
                return node
        except Refused:
            self.without_value = node
            return node
        except ExpressionError as error:
            scope.refuse_expression(node, error)
            return node
        word = scope.parameters.word(text.strip()[1:])
        if word:
            return Word(word.value, word, word.rise if type(word) is Word else 0)  # at its own place, to be corrected
        value = scope.evaluated(node)
        assert value is not None, "a text with a $ is an expression"
        if value is INVALID:
            self.without_value = node
            return node
        given = scope.quantity_of(text)
        if given:
            return Given(value, node, text, given)
        return Node(value, node.source, node.line, node.column, f"{value} ({text})")

    def _formula(self, node):
        """Return a formula with the values of its parameters, whose units it keeps."""
        text, scope = node.value, self.scope
        node.value = filled_in(text, scope.parameters)
        if not has_units(text, scope):
            return node
        from mecano.deck.expression_units import units_in_copy  # few formulas have such parameters

        return CopiedFormula(node, node.value, units_in_copy(text, scope))

    def placed(self, name: str, key: Node, node: Node) -> dict[str, Entries]:
        """Return {section: {name: (key, node)}} of a copy of a template."""
        before = len(self.scope.problems)
        self.count_placed += 1
        if self.count_placed > MOST_PLACED:
            raise DeckError([*self.scope.problems, Problem(f"more than {MOST_PLACED} templates are placed", key.mark)])
        with self._about(f"place {quoted(name)}", self.deck.parameters):
            self.scope.owner = key
            values = place_values(node, self.scope)
            if values is INVALID:
                self.without_value = key
                return {}
            template = self.templates.body(values["template"], node.value["template"][1])
            if template is None:
                return {}
            mark = replace(key.mark, stack=(), role="placed at")
            parameters = self.templates.parameters(template, values, key, node, self.deck.parameters)
            level = Level(parameters, (*key.source.stack, mark))
            self._work_out(level)
        if len(self.scope.problems) > before:
            return {}
        with self.templates.being_placed(values["template"]):
            found = self.sections(template, level)
        return self._moved(found, name, Placement(values["position"], values["orientation"]))

    def _moved(self, found, name, placement):
        """Return the sections of a template with the names and positions of its copy ``name``."""
        placing = Placing(f"{name}_", placement, found, self.scope)
        moved: dict[str, Entries] = {}
        for section, entries in found.items():
            moved[section] = {}
            inner = Field("", self.fields[section].type.options[0], "-", "")
            for own, (key, node) in entries.items():
                with self._about(f"{singular(section)} '{name}_{own}'", self.deck.parameters):
                    placing.take(node, inner)
                moved[section][f"{name}_{own}"] = (key, node)
        return moved

    def _work_out(self, level):
        """Evaluate the numbers among the parameters of a copy, and report wrong ones at their own positions."""
        for name, node in level.parameters.nodes.items():
            if not is_word(node) and node.value is not None:
                self.scope.parameters = level.parameters
                at = Node(node.value, level.source(node.source), node.line, node.column, node.raw)
                with level.parameters.working_on(name):
                    value = number(at, replace(VALUE, name=name), self.scope)
                level.parameters.values[name] = None if value is INVALID else value

    def _add(self, entries, name, key, node):
        if name in entries:
            self.scope.refuse(key, f"{quoted(name)} is given twice; first at {entries[name][0].mark}")
        else:
            entries[name] = (key, node)

    @contextmanager
    def _about(self, subject, parameters):
        scope = self.scope
        before = scope.subject, scope.parameters, scope.owner, scope.path
        scope.subject, scope.parameters, scope.path = subject, parameters, []
        try:
            yield
        finally:
            scope.subject, scope.parameters, scope.owner, scope.path = before


def _words(root, parameters):
    """Return the names of the parameters of the deck that are words."""
    if not any(map(is_word, parameters.nodes.values())):
        return set()
    from mecano.deck.words import words_of  # few decks need it

    return words_of(root, parameters)


def is_repeated(node: Node) -> bool:
    """Return whether an entry, or an item of a list, has a ``repeat``."""
    return type(node.value) is dict and "repeat" in node.value


def repeats_items(node: Node) -> bool:
    """Return whether a list in an entry has an item with a ``repeat``."""
    if type(node.value) is list:
        return any(is_repeated(item) or repeats_items(item) for item in node.value)
    return type(node.value) is dict and any(repeats_items(inner) for _, inner in node.value.values())


def _without_repeat(node):
    """Return an entry without its 'repeat'."""
    value = {name: pair for name, pair in node.value.items() if name != "repeat"}
    return Node(value, node.source, node.line, node.column)

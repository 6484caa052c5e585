"""Templates (small decks with their own parameters), and the fields of ``place``, which puts copies into the deck."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace

from mecano.deck.compose import Node
from mecano.deck.containers import SECTION_NAMES, filled
from mecano.deck.parameters import Parameters
from mecano.deck.placing import Word
from mecano.deck.scope import Invalid, Scope
from mecano.deck.similar_names import similar
from mecano.deck.wording import quoted
from mecano.errors import Mark
from mecano.schema import ORIENTATION, POSITION, TEXT, Field, Type, Values, mapping, named

DEEPEST = 12  # templates inside templates
ZERO = (0.0, 0.0, 0.0)
ARGUMENTS = Type("arguments", "a mapping of numbers and words")
PLACE_FIELDS = (
    Field("template", TEXT, "-", "name of the template"),
    Field("position", POSITION, "m", "position of the origin of the template, inertial", ZERO),
    Field(
        "orientation", ORIENTATION, "rad", "rotation vector by which the template is turned about its origin", ZERO
    ),
    Field("with", ARGUMENTS, "-", "values of parameters of the template: numbers, or names from outside", {}),
)  # fmt: skip
PLACE = Field(
    "place", named(mapping(*PLACE_FIELDS)), "-",
    "copies of templates: the name of a copy and '_' begin the names of all its entries", {},
)  # fmt: skip


def arguments(node: Node, declared: Field, scope: Scope) -> dict[str, Node] | Invalid:
    """Return the checked values for parameters: {name: node of a number or word}."""
    if type(node.value) is not dict:
        return scope.refuse_value(node, declared)
    for _, value in node.value.values():
        if type(value.value) not in (int, float, str):
            return scope.refuse_value(value, replace(declared, type=replace(ARGUMENTS, expects="a number or a word")))
    return {name: value for name, (_, value) in node.value.items()}


def place_values(node: Node, scope: Scope) -> Values | Invalid:
    """Return the checked values of an entry of ``place``, or INVALID."""
    return filled(node, Field("", PLACE.type.options[0], "-", "a copy of a template"), PLACE_FIELDS, scope)


class Templates:
    """Templates of a deck, by name."""

    def __init__(self, root: Node, sections: Iterable[str], scope: Scope):
        """Check the templates of the deck ``root``; ``sections``: sections of names that a template may have."""
        self.sections, self.scope = ["parameters", "place", *sections], scope
        self.bodies = self._declared(root)
        self._open: list[str] = []  # names of the templates being placed
        self._placed: set[str] = set()

    def _declared(self, root):
        """Return {name: node}, each a mapping of sections; also of a misspelt section, which is refused elsewhere."""
        meant = (pair for key, pair in root.value.items() if key not in SECTION_NAMES and similar(key, ("templates",)))
        given = root.value.get("templates") or next(meant, None)
        if given is None or given[1].value is None:
            return {}
        if type(given[1].value) is not dict:
            self.scope.refuse(given[1], "'templates' must be a mapping of names")
            return {}
        for name, (key, node) in given[1].value.items():
            self._check(name, key, node)
        return {name: node for name, (_, node) in given[1].value.items()}

    def _check(self, name, key, node):
        if type(node.value) is not dict:
            self.scope.refuse(key, f"template {quoted(name)}: must be a mapping of sections")
            node.value = {}
        for section, (key, inner) in list(node.value.items()):
            if section not in self.sections:
                hint = self.scope.suggest(section, self.sections)
                self.scope.refuse(key, f"template {quoted(name)}: unknown section {quoted(section)}", hint)
            elif type(inner.value) is not dict:
                if inner.value is not None or inner.raw == "":  # null omits it
                    self.scope.refuse(inner, f"template {quoted(name)}: {quoted(section)} must be a mapping of names")
                del node.value[section]

    @contextmanager
    def being_placed(self, name: str) -> Iterator[None]:
        """Mark a template as being placed, so that it is not placed inside itself."""
        self._open.append(name)
        self._placed.add(name)
        try:
            yield
        finally:
            self._open.pop()

    def unplaced(self, root: Node) -> dict[str, Mark]:
        """Return {name: mark} of the templates of the deck ``root`` itself, not of included files, without a copy."""
        keys = {name: root.value["templates"][1].value[name][0] for name in self.bodies if "templates" in root.value}
        own = {name: key for name, key in keys.items() if key.source.file == root.source.file}
        return {name: key.mark for name, key in own.items() if name not in self._placed}

    def body(self, name: str, node: Node) -> Node | None:
        """Return the template with a name used at ``node``, or None if it cannot be placed."""
        if name not in self.bodies:
            self.scope.refuse(node, f"unknown template {quoted(name)}", self.scope.suggest(name, self.bodies))
            return None
        if name in self._open:
            circle = " -> ".join([*self._open[self._open.index(name) :], name])
            self.scope.refuse(node, f"templates place one another in a circle: {circle}")
            return None
        if len(self._open) >= DEEPEST:
            self.scope.refuse(node, f"templates are placed more than {DEEPEST} levels deep")
            return None
        return self.bodies[name]

    def parameters(self, body: Node, values: Values, key: Node, node: Node, outer: Parameters) -> Parameters:
        """Return the Parameters of a copy: values from its entry of ``place``, and defaults; each must have a value.

        ``values`` come from ``place_values``, ``key`` and ``node`` are the entry, ``outer`` the Parameters of the deck.
        """
        declared = body.value.get("parameters")
        defaults = {name: value for name, (_, value) in declared[1].value.items()} if declared else {}
        given = {name: value for name, value in values["with"].items() if value.value is not None}
        for name in given:
            if name not in defaults:
                place, hint = node.value["with"][1].value[name][0], self.scope.suggest(name, defaults)
                self.scope.refuse(place, f"the template has no parameter {quoted(name)}", hint)
        missing = [name for name, value in defaults.items() if value.value is None and name not in given]
        if missing:
            self.scope.refuse(key, f"missing 'with.{missing[0]}', a parameter of the template without a default")
        return Parameters({**defaults, **{name: _marked_outside(value) for name, value in given.items()}}, outer)


def _marked_outside(node):
    """Return a word given to a template, marked as a name outside it."""
    if type(node.value) is not str:
        return node
    return Word(node.value, node, 1 + (node.rise if type(node) is Word else 0))

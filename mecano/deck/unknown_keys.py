"""Errors and hints for unknown keys of mappings, and for entries without a known type."""

import re
from collections.abc import Iterable

from mecano.deck.compose import Node
from mecano.deck.key_synonyms import keys_meant
from mecano.deck.laws import MEANT, TERM
from mecano.deck.scope import Invalid, Scope
from mecano.deck.similar_names import similar
from mecano.deck.synonyms import synonym
from mecano.deck.wording import quoted
from mecano.schema import Field

MERGED = "merge keys of YAML are not read; 'templates' and 'repeat' write similar entries"
EXPANDED_KEYS = ("include", "set", "templates", "place", "repeat")  # of a deck or of an entry, removed by the expansion
OF_LAWS = ("stiffness", "damping", "spring", "damper", "k", "c")
LAWS = ("law", "turning_law", "sliding_law")  # that have them as terms
IN_PLACE = {  # key -> (key that is known in its place, hint)
    "radius": ("diameter", "give the 'diameter', twice the radius"),
    "outer_radius": ("diameter", "give the 'diameter', twice the radius"),
    "diameter": ("radius", "give the 'radius', half the diameter"),
    "inner_diameter": ("thickness", "give the 'thickness' of the wall, half the difference of both diameters"),
    "inner_radius": ("thickness", "give the 'thickness' of the wall, the difference of both radii"),
}
CLUTCH = "a hinge with a 'lock' between its wheel and the shaft engages and disengages it (docs/gears.md, Dog clutches)"
ELSEWHERE = {  # names of keys: a key that is known there, where the value is given
    ("velocity", "velocities", "angular_velocity"): (
        "position", "give it in 'initial': velocities: [{nodes: [...], velocity: [...], angular_velocity: [...]}]"
    ),
    ("torque", "moment", "motor", "drive", "actuator"): (
        "turning_law",
        "a torque is a load, {type: joint_moment, joint: ..., value: ...}; a given motion is a joint 'prescribed_angle'"
    ),
    ("rate", "speed", "driven_rate"): ("turning_law", "a given motion is a joint, {type: prescribed_angle, rate: ...}"),
    ("angle", "angles", "position", "positions", "displacement", "displacements"): (
        "velocities", "the positions at the start are those of the nodes"
    ),
    ("rate", "rates", "speed", "speeds"): (
        "velocities", "give the velocities of the bodies, velocities: [{nodes: [...], angular_velocity: [...]}]"
    ),
    ("release", "activate", "lock", "clutch"): ("radius_a", CLUTCH),
    ("release", "activate", "lock"): ("factors", CLUTCH),
    ("joints",): ("radius_a", "a relation of the coordinates of joints is a 'coupler', or a 'nonlinear_coupler'"),
    ("release", "activate"): ("value", "a load ends when its value does, such as a signal 'switch' of the time"),
    ("plane", "planar", "dimension", "dimensions"): (
        "gravity", "all models are in space: parallel hinges, or joints 'planar', keep a mechanism in its plane"
    ),
    ("relaxation_length", "relaxation_lengths"): (
        "carcass_stiffness", "it is cornering_stiffness / carcass_stiffness + creep_length"
    ),
}  # fmt: skip
FEW = 8  # kinds that have a field, which are named
MOST_LONGER = 2  # names of keys that contain the unknown one as a word
UNKNOWN_KIND = "`mecano list` lists all; name the file of a plugin by --plugin, in Python by mecano.load_plugin"


def refuse_key(
    pair: tuple[Node, Node], before: Node | None, known: set[str], fields: Iterable[Field], field: Field, scope: Scope
) -> str:
    """Report the unknown key of a pair (key, value); return the hint, and the key that is written in it as "mass:1".

    ``before``: the value before this pair; ``known``: all keys that the mapping ``field`` may have, ``fields`` among
    them.
    """
    key_node, value_node = pair
    key = key_node.value
    hint = _of_list(before, key_node, value_node) or _meant(key, known, fields, field, scope)
    if not field.name and not hint and _is_entry(value_node):
        hint = "indent it, if it is an entry of the section above"
    scope.refuse(key_node, f"unknown key {quoted(scope.name_of(key))}", hint)
    return hint + _unseparated(key)


def _meant(key, known, fields, field, scope):
    """Return a hint for an unknown key."""
    if ":" in key:
        return "write a space after ':'"
    if "=" in key:
        return "write ': ' instead of '='"
    if key == "<<":
        return MERGED
    if key in ("include", "set") and not field.name:  # they were expanded before: this is of --set
        return f"{quoted(key)} is allowed in the file of the deck only"
    allowed = known if field.name else known.union(EXPANDED_KEYS)
    if key.lower() in OF_LAWS and (laws := [quoted(name) for name in LAWS if name in known]):
        return f"write it in the {' or '.join(laws)}: {{spring: ..., damper: ...}}"
    if key.lower() in IN_PLACE and IN_PLACE[key.lower()][0] in known:
        return IN_PLACE[key.lower()][1]
    here = [quoted(name) for name in keys_meant(key) if name in allowed]
    if here:
        return f"here it is called {' or '.join(here)}"
    if field.type is TERM and (term := MEANT.get(key, key)) in scope.terms:
        return f"it is a term of its own: {{{field.name}: ..., {term}: ...}}"
    for keys, (there, hint) in ELSEWHERE.items():
        if key in keys and there in known:
            return hint
    if not similar(key, sorted(known)) and (kinds := _kinds_with(key, field, scope)):
        return f"it is a field of {', '.join(kinds)}"
    longer = [quoted(name) for name in sorted(allowed) if key in name.split("_")]
    if 0 < len(longer) <= MOST_LONGER:
        return f"did you mean {' or '.join(longer)}?"
    near = similar(key, sorted(allowed))
    inside = [f"{outer.name}.{key}" for outer in fields if key in _keys_of(outer)]
    meant = inside or [inner.name for inner in fields if re.match(rf"{re.escape(key)}\b", inner.doc)]
    return f"did you mean {quoted(meant[0])}?" if meant and not near else scope.suggest(key, near or sorted(known))


def _is_entry(node):
    """Return True if a value looks like an entry of a section: an element, a joint, a load or a node."""
    return type(node.value) is dict and not {"type", "position", "repeat"}.isdisjoint(node.value)


def _unseparated(key):
    """Return the word in quotes before the first ':' or '=' of a key that contains its value, "mass:1", or ""."""
    word = re.split("[:=]", key)[0].strip()
    return quoted(word) if word != key else ""


def _of_list(before, key_node, value_node):
    """Return a hint for a key without a value after a text: items of a list without brackets, or ""."""
    alone = value_node.value is None and value_node.raw == "" and key_node.value.isidentifier()
    if not alone or before is None or type(before.value) is not str or before.line != key_node.line:
        return ""
    return f"a list is written in brackets: [{before.value}, {key_node.value}]"


def _kinds_with(key, field, scope):
    """Return the names of the kinds of a section whose entries have a field ``key``; none if they are many."""
    section = field.type.options[0] if field.type.name == "kind" else ""
    kinds = [name for name in _kinds_of(section, scope) if any(key == own.name for own in scope.kinds[name].fields)]
    return kinds if len(kinds) <= FEW else []


def _keys_of(field):
    """Return the keys of a field that is a mapping."""
    return [inner.name for inner in field.type.options] if field.type.name == "mapping" else ()


def refuse_untyped(node: Node, section: str, scope: Scope) -> Invalid:
    """Report an entry without 'type', or a key that resembles 'type'."""
    kinds = _kinds_of(section, scope)
    for key, (key_node, value) in node.value.items():
        if key == "<<":  # it may have the type
            return scope.refuse(key_node, f"unknown key {quoted(key)}", MERGED)
        if key in kinds:
            return scope.refuse(key_node, f"unknown key {quoted(key)}", f"write 'type: {key}'")
        if type(value.value) is not str or value.value not in kinds:
            continue
        if "type" in keys_meant(key):
            return scope.refuse(key_node, f"unknown key {quoted(key)}", "here it is called 'type'")
        if similar(key, ("type",)):
            return scope.refuse(key_node, f"unknown key {quoted(key)}", scope.suggest(key, ("type",)))
    fitting = [kind for kind in kinds if _fits(node.value, scope.kinds[kind].fields)]
    hint = "with these keys: " + ", ".join(fitting) if fitting else "known: " + ", ".join(kinds)
    return scope.refuse(scope.owner or node, "missing 'type'", hint)


def _fits(keys, fields):
    """Return whether all keys are fields, and none that is required is absent."""
    return {*keys} <= {own.name for own in fields} and all(own.name in keys for own in fields if own.required)


def refuse_kind(type_node: Node, section: str, scope: Scope) -> Invalid:
    """Report a 'type' that is no kind of the section."""
    if type(type_node.value) is not str:
        return scope.refuse(type_node, f"'type' must be the name of a kind, got {scope.got(type_node)}")
    found = scope.kinds.get(type_node.value)
    if found and found.section:
        text = f"kind {quoted(found.name)} belongs to '{found.section}', not '{section}'"
        return scope.refuse(type_node, text)
    meant, _ = synonym(type_node.value) or ((), "")
    known = next((name for name in meant if name in _kinds_of(section, scope)), None)
    known = known or next((name for name in meant if name in scope.kinds), None)
    hint = f"here it is called {quoted(known)}" if known else ""
    hint = hint or scope.suggest(type_node.value, _kinds_of(section, scope)) or UNKNOWN_KIND
    return scope.refuse(type_node, f"unknown type {quoted(type_node.value)}", hint)


def _kinds_of(section, scope):
    """Return the names of the kinds of a section."""
    return [name for name, kind in scope.kinds.items() if kind.section == section]

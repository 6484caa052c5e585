"""Tree of nodes -> checked values: version, structure, names, physics."""

import math
from collections import ChainMap
from collections.abc import Mapping, MutableMapping, Sequence
from dataclasses import replace
from typing import Any

from mecano.deck import values
from mecano.deck.compose import Node
from mecano.deck.containers import either, filled, kind, list_, mapping, named, shorthand
from mecano.deck.copies import Copies
from mecano.deck.expanded_sections import EXPANDED_SECTIONS
from mecano.deck.formulas import check_continuous, check_formulas, condition, drive, formula, function, signal_entry
from mecano.deck.key_synonyms import keys_meant
from mecano.deck.law_units import check_named_laws
from mecano.deck.laws import law_in_place, law_or_name
from mecano.deck.parameters import Parameters, is_word
from mecano.deck.physics import check_model
from mecano.deck.resolve import resolve, unknown_names
from mecano.deck.scope import INVALID, Invalid, Scope
from mecano.deck.sections import SECTIONS, shortest_interval
from mecano.deck.similar_names import similar
from mecano.deck.templates import arguments
from mecano.deck.turning_axes import check_axes
from mecano.deck.units import ANY
from mecano.deck.wording import found, quoted
from mecano.element_interface import Kind
from mecano.elements.members.cross_section import SHAPES
from mecano.errors import DeckError, Problem
from mecano.laws.term import Term
from mecano.schema import TEXT, Field, Values
from mecano.schema import mapping as mapping_type

VERSION = 1
MOST_IN_A_STEP = 1e5  # saved times; they take a second or two
OTHER_MEANINGS = {"time": "the time of the run", "pi": "3.14159..."}  # names in formulas that are no signals
MOST_SAMPLES = 2_000_000  # sampling times of a signal, each of which is kept and ends a step
UNCHECKED = "consistency is checked"  # once the errors are fixed


def parameter(node: Node, field: Field, scope: Scope) -> float | Invalid:
    """Return a number of the section ``parameters``, which the whole deck may use."""
    assert scope.owner is not None, "the key of the parameter"
    name = scope.owner.value
    with scope.parameters.working_on(name):
        if is_word(node) and node.value.isidentifier():
            hint = f"a word is a name or a part of one, such as axle_${name}, and no name here contains ${name}"
            value: float | Invalid = scope.refuse_value(node, field, hint=hint)
        else:
            value = values.number(node, replace(field, unit=ANY), scope)
    scope.parameters.values[name] = None if value is INVALID else value
    return value


def _of_superelements(name):
    """Return the check of this name in reduced_file.py, which few decks need."""

    def check(node, field, scope):
        from mecano.deck import reduced_file

        return getattr(reduced_file, name)(node, field, scope)

    return check


CHECKS = {
    "number": values.number,
    "integer": values.integer,
    "boolean": values.boolean,
    "text": values.text,
    "choice": values.choice,
    "numbers": values.numbers,
    "coefficients": values.coefficients,
    "vector": values.vector,
    "direction": values.direction,
    "inertia": values.inertia,
    "matrix": values.matrix,
    "matrix_6": values.matrix_6,
    "points": values.points,
    "columns": values.columns,
    "units": values.units,
    "unit": values.unit,
    "node": values.node_name,
    "nodes": values.node_names,
    "ground": values.named,
    "tire_law": values.named,
    "section": values.named,
    "wheel": values.named,
    "reduced": _of_superelements("reduced"),
    "rows": _of_superelements("rows"),
    "law": law_or_name,
    "curve": law_or_name,
    "law_in_place": law_in_place,
    "drive": drive,
    "formula": formula,
    "condition": condition,
    "function": function,
    "signal_entry": signal_entry,
    "joint": values.named,
    "parameter": parameter,
    "arguments": arguments,
    "mapping": mapping,
    "named": named,
    "list": list_,
    "either": either,
    "shorthand": shorthand,
    "kind": kind,
}


def scope_of(
    root: Node, kinds: MutableMapping[str, Kind], terms: Mapping[str, Term], folder: str, problems: list[Problem]
) -> Scope:
    """Return the Scope of the check of a deck; ``problems`` were found before. Raises DeckError for another version."""
    _check_version(root, problems)
    parameters = Parameters(_written_parameters(root))
    return Scope(CHECKS, ChainMap[str, Any](kinds, SHAPES), terms, folder, problems, parameters=parameters)


def written_out(root: Node, sections: Sequence[Field], scope: Scope) -> tuple[Node, Copies]:
    """Return the tree with all copies of templates and repeated entries expanded, and the Copies that expand more."""
    copies = Copies(root, sections, scope)
    root = copies.written_out(root)
    if copies.incomplete:
        known = dict.fromkeys(f.name for f in (*sections, *EXPANDED_SECTIONS))
        filled(root, Field("", TEXT, "-", ""), [f for f in sections if f.name == "parameters"], scope, known)
        if not scope.problems and copies.without_value:
            scope.refuse(
                copies.without_value,
                "this must be a number: it contains a value of 'repeat' or 'place' that is not a number",
            )
        raise DeckError(scope.problems, UNCHECKED)
    return root, copies


def checked_values(root: Node, sections: Sequence[Field], scope: Scope) -> Values:
    """Check the expanded tree of a deck and return its values.

    Raises DeckError with all problems of the first step of the check that finds any.
    """
    problems = scope.problems
    result = filled(root, Field("", mapping_type(*sections), "-", "a deck"), sections, scope)
    _check_process(root, sections, scope)
    _check_gravity(root, scope)
    if problems:
        unknown_names(root, scope)
    missing = tuple(f"missing '{name}'" for name in scope.misplaced)
    _stop_at([problem for problem in problems if not problem.message.startswith(missing)], UNCHECKED)
    assert result is not INVALID, "a value that is refused has a problem"
    for start in ("static", "steady", "from"):
        if result.get("static") and result["initial"][start]:
            scope.refuse(root.value["initial"][0], f"'initial.{start}' belongs to a deck with 'time'")
    _check_saved_times(result, root, scope)
    _check_samples(result, root, scope)
    _check_signal_names(result, root, scope)
    if result.get("tire_laws"):
        from mecano.deck.tyres import complete_tyres  # with the slip laws, which few decks need

        complete_tyres(result["tire_laws"], root, scope)
    resolve(result, scope)
    check_formulas(result, scope)
    _stop_at(problems, UNCHECKED)
    check_named_laws(root, scope)
    check_continuous(result, scope)
    check_model(result, root, scope)
    check_axes(result, root, scope)
    _stop_at(problems)
    return result


def _written_parameters(root):
    """Return {name: node} of the section ``parameters``, or {} if it is not a mapping."""
    section = root.value.get("parameters") or next(iter(_miswritten(root, "parameters")), None)
    return {name: node for name, (_, node) in section[1].value.items()} if section and _is_mapping(section[1]) else {}


def _miswritten(root, section):
    """Return the pairs (key, value) of a deck whose key seems to be meant as a section; each is refused as unknown."""
    sections = {field.name for field in (*SECTIONS, *EXPANDED_SECTIONS)}
    unknown = [(key, pair) for key, pair in root.value.items() if key not in sections]
    return [pair for key, pair in unknown if section in (keys_meant(key) or similar(key, (section,)))]


def _is_mapping(node):
    return type(node.value) is dict


def _stop_at(problems, unchecked=""):
    if problems:
        raise DeckError(problems, unchecked)


def _check_process(root, sections, scope):
    """Refuse a deck that has both or neither of ``time`` and ``static``."""
    fields = {section.name: section for section in sections}
    if "static" not in fields:
        return
    time, static = (key in root.value and root.value[key][1].value is not None for key in ("time", "static"))
    if not time and not static and not _miswritten(root, "time") and not _miswritten(root, "static"):
        section = fields["time"]
        text = f"missing 'time', {section.type.expects}: {section.doc}; or 'static': {fields['static'].doc}"
        scope.refuse(root, text)
    if time and static:
        hint = "to start a dynamic analysis from an equilibrium write 'initial: static'"
        scope.refuse(root.value["static"][0], "'static' and 'time' exclude one another", hint)


def _check_gravity(root, scope):
    """Refuse a deck without ``gravity`` if an element has weight."""
    section = root.value["elements"][1].value if "elements" in root.value else None
    given = "gravity" in root.value and root.value["gravity"][1].value is not None
    if type(section) is not dict or given or _miswritten(root, "gravity"):
        return
    heavy = next((name for name, (_, node) in section.items() if _has_weight(node, scope.kinds)), None)
    if heavy is not None:
        text = f"missing 'gravity', the acceleration of gravity [m/s2]: {quoted(heavy)} has mass"
        scope.refuse(root, text, "write 'gravity: [0, 0, -9.81]' or 'gravity: none'")


def _has_weight(node, kinds):
    """Return True if gravity acts on an element: its record has gravity and a mass, if optional, that is not zero."""
    entry = node.value if type(node.value) is dict else {}
    type_ = entry["type"][1].value if "type" in entry else None
    kind = kinds.get(type_) if type(type_) is str else None
    if kind is None or kind.section != "elements" or "gravity" not in kind.dtype.names:
        return False
    optional = [field.name for field in kind.fields if field.name == "mass_per_length"]
    return all(name in entry and entry[name][1].value not in (None, 0) for name in optional)


def _check_saved_times(result, root, scope):
    """Refuse an interval of saved results that is shorter than the rounding of times or far shorter than a step."""
    time, every = result["time"], result["output"]["every"]
    if time and type(every) is float and every < (shortest := shortest_interval(time)):
        _, node = root.value["output"][1].value["every"]
        scope.refuse(node, f"'output.every' must be at least {shortest:g} s here, got {found(node)}", "write 'step'")
    elif time and type(every) is float and (count := time["step"] / every) > MOST_IN_A_STEP:
        _, node = root.value["output"][1].value["every"]
        text = f"'output.every' asks for {count:.3g} saved times in one step of 'time.step', {time['step']:g} s"
        hint = f"between steps results are interpolated: write 'step', or {time['step'] / MOST_IN_A_STEP:.3g} s or more"
        scope.refuse(node, text, hint)


def _check_signal_names(result, root, scope):
    """Refuse signals whose names mean something else in formulas."""
    for name in set(OTHER_MEANINGS) & set(result.get("signals", {})):
        text = f"signal {quoted(name)}: in formulas {quoted(name)} is {OTHER_MEANINGS[name]}"
        scope.refuse(root.value["signals"][1].value[name][0], text, "give the signal another name")


def _check_samples(result, root, scope):
    """Refuse a sampling period with too many sampling times, each of which ends a step, to the end of the run."""
    time = result["time"]
    for name, d in result.get("signals", {}).items():
        if time and (count := (time["end"] - time["start"]) / d.get("period", math.inf)) > MOST_SAMPLES:
            node = root.value["signals"][1].value[name][1].value["period"][1]
            text = f"signal {quoted(name)}: 'period' asks for {count:.3g} sampling times to the end of the run"
            scope.refuse(node, text, f"at most {MOST_SAMPLES:,} are possible")


def _check_version(root, problems):
    """Refuse another version first: nothing else can be said about such a deck."""
    if "mecano" not in root.value:
        key = next((node for key, (node, _) in root.value.items() if similar(key, ("mecano",))), None)
        text = f"unknown key {quoted(key.value)}" if key else "missing 'mecano', the version of the deck"
        of_file = "this is a study: run it by `mecano sweep`" if "study" in root.value else "begin with 'mecano: 1'"
        hint = "did you mean 'mecano'?" if key else of_file
        raise DeckError([*problems, Problem(text, (key or root).mark, hint)])
    node = root.value["mecano"][1]
    if type(node.value) is not int or node.value != VERSION:
        text = f"this program reads decks of version {VERSION}, got {found(node)}"
        raise DeckError([Problem(text, node.mark, f"write 'mecano: {VERSION}'")])

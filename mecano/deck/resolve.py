"""Resolution of references: nodes must exist; laws, grounds and tire laws replace their names."""

import re
from typing import Any

from mecano.deck.compose import Node
from mecano.deck.containers import singular, wrong_name
from mecano.deck.formulas import note_continuous
from mecano.deck.laws import fits
from mecano.deck.motions import NotAMotion, motion_of, put_curves_of_time
from mecano.deck.scope import Scope
from mecano.deck.similar_names import similar
from mecano.deck.wording import quoted
from mecano.laws.formula import read_formula
from mecano.model.mesh import divided_nodes, divides, inner_names
from mecano.schema import LINE, MOTION, Values

OTHERS = ("nodes", "elements", "joints", "loads", "sections", "grounds", "tire_laws")  # where a name may be


def resolve(values: Values, scope: Scope) -> None:
    """Resolve every reference of the scope in the checked values, which are changed in place."""
    nodes = dict.fromkeys([*values["nodes"], *_nodes_of_members(values["elements"], scope.kinds)])
    members = {name: d for name, d in values["elements"].items() if scope.kinds[d["type"]].divide and name not in nodes}
    motions = [reference for reference in scope.references if _prescribes(reference)]
    for reference in scope.references:
        if not _prescribes(reference):
            _resolve(reference, nodes, members, values, scope)
    put_curves_of_time(values["signals"], _sloping(scope))  # their laws are known now, and motions may be such curves
    for reference in motions:
        _resolve(reference, nodes, members, values, scope)
    for line in scope.lines:
        line[:] = _nodes_of_line(line, members)
    for names in scope.node_sets:
        nodes_of = (divided_nodes(name, members[name]) if name in members else [name] for name in names)
        names[:] = dict.fromkeys(node for nodes in nodes_of for node in nodes)


def _sloping(scope):
    """Return the names of the signals whose slope, relative to their input as it is written, some formula reads."""
    names = (name.removeprefix("signals.") for found, _, _ in scope.formulas for name in found.references)
    return {name.removesuffix(".slope") for name in names if name.endswith(".slope")}


def _resolve(reference, nodes, members, values, scope):
    """Put what a reference names in its place, or note an error."""
    scope.subject = reference.subject
    if reference.wanted == "motion":
        _put_motion(reference, values["signals"], scope)
        return
    known = nodes if reference.section == "nodes" else values[reference.section]
    is_formula = reference.name == "time" or reference.name in values["signals"]
    if reference.wanted == "drive" and is_formula and reference.name not in known:
        if _prescribes(reference):
            _put_motion(reference, values["signals"], scope)
            return
        _put(reference, reference.name)
        note_continuous(read_formula(reference.name), reference.node, reference.options, scope)
        return
    of_line = reference.options == LINE.options
    if of_line and reference.name in members:
        return
    if reference.name not in known:
        more = values["signals"] if reference.wanted == "drive" else members if of_line else ()
        _unknown(reference, [*known, *more], values, scope)
        return
    found: Any = known[reference.name]
    if reference.section == "laws":
        if reference.wanted == "drive" and reference.name in values["signals"]:
            scope.refuse(reference.node, f"{quoted(reference.name)} is both a law and a signal")
        _check_terms(reference, found, scope)
        note_continuous(found, reference.node, reference.options, scope)
    _put(reference, found)
    if reference.section == "joints":
        _check_joint(reference, found, scope)


def _nodes_of_line(names, members):
    """Return the names of nodes along a line; a member begins where the line before it ends."""
    line: list[str] = []
    for name in names:
        nodes = divided_nodes(name, members[name]) if name in members else [name]
        if line[-1:] == nodes[-1:]:
            nodes = nodes[::-1]
        line += nodes[1:] if line[-1:] == nodes[:1] and name in members else nodes
    return line


def _put(reference, value):
    if reference.home:
        container, key = reference.home
        container[key] = value


def _prescribes(reference):
    """Return whether a prescribed motion is referred to; it may be a signal, whose law must be known."""
    return reference.wanted == "motion" or (reference.wanted == "drive" and reference.options == MOTION.options)


def _put_motion(reference, signals, scope):
    """Replace a formula, or the name of a signal, by the motion that it prescribes, or note why it prescribes none."""
    try:
        _put(reference, motion_of(reference.name, signals))
        scope.motions += [(*reference.home, reference.name)] if reference.home else []
    except NotAMotion as error:
        scope.refuse(reference.node, str(error))


def unknown_names(root: Node, scope: Scope) -> None:
    """Report references to names that are in no section of the tree ``root``, in a deck with other errors.

    Sections that are missing, misplaced or have invalid names are skipped; so are nodes inside members, which may be
    among the errors.
    """
    known = {name: node.value for name, (_, node) in root.value.items() if type(node.value) is dict}
    known = {section: names for section, names in known.items() if not any(wrong_name(n, section) for n in names)}
    for reference in scope.references:
        scope.subject = reference.subject
        if reference.wanted == "motion":
            continue
        names = [*known.get(reference.section, (reference.name,))]
        if reference.options == LINE.options:
            names += known.get("elements", (reference.name,))
        if reference.wanted == "drive":
            names = [*known.get("laws", ()), *known.get("signals", ())]
        if scope.misplaced & ({"laws", "signals"} if reference.wanted == "drive" else {reference.section}):
            continue
        inside = reference.section == "nodes" and "." in reference.name
        time = reference.wanted == "drive" and reference.name == "time"
        if reference.name not in names and not inside and not time:
            _unknown(reference, names, known, scope)


def _nodes_of_members(elements, kinds):
    """Return the names of the nodes between the elements of members."""
    members = {name: d for name, d in elements.items() if divides(kinds[d["type"]], d)}
    return [node for name, d in members.items() for node in inner_names(name, d)]


def _unknown(reference, known, sections, scope):
    """Report an unknown name; ``sections``: {section: its entries, checked or as nodes of the deck}."""
    drive = reference.wanted == "drive"
    what = "law or signal" if drive else singular(reference.section)
    if reference.name == "ground" and reference.section == "nodes":
        hint = "'ground' is allowed only as one of two nodes; otherwise use a node with 'fixed: true'"
    elif "$" in reference.name:
        hint = (
            "names contain parameters, and values of a 'repeat' of the same entry: p$last, "
            "{repeat: {i: 1..$last}, node: p$i}"
        )
    elif len(parts := re.split(r"[\s,;]+", reference.name)) > 1 and set(parts) <= {*known}:
        hint = f"each name is an item of its own: {', '.join(parts)}"
    elif elsewhere := _other_section_hint(reference, sections):
        near = similar(reference.name, known)
        hint = "; ".join(filter(None, (elsewhere, scope.suggest(reference.name, near) if near else "")))
    elif known:
        own = scope.own_names.get(id(reference.node), ())
        hint = scope.suggest(reference.name, [*own, *known, *(["ground"] if reference.wanted == "end" else ())])
    else:
        hint = "the deck has no 'laws' and no 'signals'" if drive else f"the deck has no '{reference.section}'"
    meant = [kind for kind in scope.kinds if kind.startswith(f"{reference.name}_")]
    if reference.section == "laws" and len(meant) == 1:  # friction: adhesive
        hint = "; ".join(part for part in (hint, f"there is the type '{meant[0]}'") if part)
    scope.refuse(reference.node, f"unknown {what} {quoted(reference.name)}", hint)


def _other_section_hint(reference, sections):
    """Return a hint if the name of a reference is that of an entry of another section, or ""."""
    for section in OTHERS:
        entry = (sections.get(section) or {}).get(reference.name)
        if entry is None or section == reference.section:
            continue
        hint = f"{quoted(reference.name)} is {'an' if section[0] in 'aeiou' else 'a'} {singular(section)}"
        entry = entry[1].value if type(entry) is tuple else entry
        node = entry.get("node") if type(entry) is dict and reference.section == "nodes" else None
        node = node[1].value if type(node) is tuple else node
        return f"{hint}, whose node is {quoted(node)}" if type(node) is str and node != reference.name else hint
    return ""


def _check_terms(reference, law, scope):
    for name, _ in law:
        if not fits(scope.terms[name], reference.wanted):
            text = f"law {quoted(reference.name)} is a force of extension and rate ({quoted(name)}); "
            scope.refuse(reference.node, text + "a curve is required here")
            return


def _check_joint(reference, joint, scope):
    """Report a load on a joint that lacks the coordinate along which the load acts."""
    output, kind = reference.options[0], scope.kinds[joint["type"]]
    if output not in kind.measures:
        can = [kind.name for kind in scope.kinds.values() if kind.section == "joints" and output in kind.measures]
        text = f"{joint['type']} {quoted(reference.name)} has no {output} along which a load could work"
        scope.refuse(reference.node, text, f"joints that have one: {', '.join(can)}")

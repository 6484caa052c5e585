"""Resolution of references: nodes must exist; laws, grounds and tire laws replace their names."""

from mecano.deck.containers import singular, wrong_name
from mecano.deck.laws import fits
from mecano.deck.wording import quoted
from mecano.model.mesh import divides, inner_names


def resolve(values, scope):
    """Resolve every reference of the scope in the checked values, which are changed in place."""
    nodes = dict.fromkeys([*values["nodes"], *_nodes_of_members(values["elements"], scope.kinds)])
    for reference in scope.references:
        scope.subject = reference.subject
        known = nodes if reference.section == "nodes" else values[reference.section]
        if reference.name not in known:
            _unknown(reference, known, scope)
            continue
        found = known[reference.name]
        if reference.section == "laws":
            _check_terms(reference, found, scope)
        if reference.home:
            container, key = reference.home
            container[key] = found


def unknown_names(root, scope):
    """Report references to names that are in no section of the tree ``root``, in a deck with other errors.

    Sections that are missing or have invalid names are skipped; so are nodes inside members, which may be among the
    errors.
    """
    known = {name: node.value for name, (_, node) in root.value.items() if type(node.value) is dict}
    known = {section: names for section, names in known.items() if not any(wrong_name(n, section) for n in names)}
    for reference in scope.references:
        scope.subject = reference.subject
        names = known.get(reference.section, (reference.name,))
        inside = reference.section == "nodes" and "." in reference.name
        if reference.name not in names and not inside:
            _unknown(reference, list(names), scope)


def _nodes_of_members(elements, kinds):
    """Return the names of the nodes between the elements of members."""
    members = {name: d for name, d in elements.items() if divides(kinds[d["type"]], d)}
    return [node for name, d in members.items() for node in inner_names(name, d)]


def _unknown(reference, known, scope):
    what = singular(reference.section)
    if reference.name == "ground" and reference.section == "nodes":
        hint = "'ground' is allowed only as one of two nodes; otherwise use a node with 'fixed: true'"
    elif known:
        hint = scope.suggest(reference.name, [*known, "ground"] if reference.wanted == "end" else known)
    else:
        hint = f"the deck has no '{reference.section}'"
    meant = [kind for kind in scope.kinds if kind.startswith(f"{reference.name}_")]
    if reference.section == "laws" and len(meant) == 1:  # friction: adhesive
        hint = "; ".join(part for part in (hint, f"there is the type '{meant[0]}'") if part)
    scope.refuse(reference.node, f"unknown {what} {quoted(reference.name)}", hint)


def _check_terms(reference, law, scope):
    for name, _ in law:
        if not fits(scope.terms[name], reference.wanted):
            text = f"law {quoted(reference.name)} is a force of extension and rate ({quoted(name)}); "
            scope.refuse(reference.node, text + "a curve is required here")
            return

"""Complete the tyre laws of a deck: read their files, and fill in the fields that their slip laws provide."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from mecano.deck.tyre_file import read_tyre
from mecano.deck.wording import quoted
from mecano.elements.wheels.slip_laws import SLIP_LAWS
from mecano.elements.wheels.tire_law import slip_law_of

if TYPE_CHECKING:
    from mecano.deck.compose import Node
    from mecano.deck.scope import Scope
    from mecano.schema import Values

REQUIRED = {"radius": "undeformed radius [m]", "radial": "radial force [N], a curve of the radial deformation [m]"}


def complete_tyres(tire_laws: "Mapping[str, Values]", root: "Node", scope: "Scope") -> None:
    """Read files of tyres, fill in fields that slip laws provide, and note errors for missing or excess fields.

    ``tire_laws``: checked values by name, changed in place; ``root``: tree of the deck.
    """
    for name, values in tire_laws.items():
        key, node = root.value["tire_laws"][1].value[name]
        scope.subject = f"tire law {quoted(name)}"
        found = [law for law in SLIP_LAWS if values.get(law) is not None]
        if len(found) != 1:
            some = ", ".join(map(quoted, SLIP_LAWS))
            text = f"{quoted(found[1])}: a tyre has one slip law" if found else f"missing a slip law, one of {some}"
            scope.refuse(node.value[found[1]][0] if found else key, text)
            continue
        if values.get("magic_formula") and not _with_file(values["magic_formula"], node.value["magic_formula"], scope):
            continue
        known = slip_law_of(values).completed(values)
        values |= {field: value for field, value in known.items() if not values.get(field)}
        for field, what in REQUIRED.items():
            if values.get(field, 0.0) is None:
                scope.refuse(key, f"missing {quoted(field)}, {what}")


def _with_file(values, entry, scope):
    """Replace the file of a Magic Formula by its coefficients; return False, with errors noted, if that fails."""
    key, node = entry
    if (values["file"] is None) == (values["coefficients"] is None):
        scope.refuse(key, "a Magic Formula needs either 'file' or 'coefficients'")
        return False
    if values["file"] is not None:
        found = read_tyre(values["file"], node.value["file"][1], scope)
        if found is None:
            return False
        values |= {"coefficients": found, "file": None}
    return True

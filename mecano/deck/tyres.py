"""Complete the tyre laws of a deck by files, by the size of aircraft tyres, and by values of their slip laws."""

from collections.abc import Mapping

from mecano.deck.compose import Node
from mecano.deck.scope import Scope
from mecano.deck.tyre_file import read_tyre
from mecano.deck.wording import quoted
from mecano.elements.wheels import smiley_horne
from mecano.elements.wheels.magic_formula import missing_coefficients
from mecano.elements.wheels.slip_laws import SLIP_LAWS
from mecano.elements.wheels.tire_law import slip_law_of
from mecano.schema import Values

WITH_TURN_SLIP = 5  # last digit of USE_MODE
REQUIRED = {"radius": "undeformed radius [m]", "radial": "radial force [N], a curve of the radial deformation [m]"}


def complete_tyres(tire_laws: Mapping[str, Values], root: Node, scope: Scope) -> None:
    """Read files of tyres, fill in fields by size and slip law, and note errors for missing or excess fields.

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
        by_size = bool(values.get("smiley_horne"))
        if by_size and not _with_size(values, node, scope):
            continue
        known = {**slip_law_of(values).completed(values), **(smiley_horne.completed(values) if by_size else {})}
        values |= {field: value for field, value in known.items() if not values.get(field)}
        for field, what in REQUIRED.items():
            if values.get(field, 0.0) is None:
                scope.refuse(key, f"missing {quoted(field)}, {what}")


def _with_size(values, node, scope):
    """Compute an aircraft tyre under its load, and what its slip law lacks; return False, with errors noted."""
    d, place = values["smiley_horne"], node.value["smiley_horne"][1]
    found = smiley_horne.errors(d)
    for field, text in found:
        scope.refuse(place.value[field][0], f"'smiley_horne.{field}' {text}")
    if found:
        return False
    d |= smiley_horne.under_load(d)
    own = values.get("yawed_rolling")
    if own is None:
        return True
    if d["relaxation_length"] <= own["creep_length"]:
        text = f"'smiley_horne.load' ({d['load']:g} N) gives a relaxation length of {d['relaxation_length']:.4g} m"
        least = f"'yawed_rolling.creep_length', {own['creep_length']:g} m"
        scope.refuse(place.value["load"][0], f"{text}, which must exceed {least}")
        return False
    known = smiley_horne.rolling_stiffnesses(d, own["creep_length"])
    own |= {field: value for field, value in known.items() if own[field] is None}
    return True


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
        coefficients, curve = found
        values |= {
            "coefficients": coefficients,
            "file": None,
            "deflection_load": values["deflection_load"] or curve or None,
        }
    given = values["coefficients"]
    if missing := missing_coefficients(given):
        scope.refuse(key, f"'magic_formula' has no {', '.join(missing)}")
        return False
    if values["turn_slip"] is None:
        known = abs(int(given.get("USE_MODE", 0))) % 10 == WITH_TURN_SLIP
        values["turn_slip"] = known and given.get("VERSION", 0.0) >= 6.0
    if values["turn_slip"] and values["torsional_stiffness"] is None:
        values["torsional_stiffness"] = given.get("YAW_STIFFNESS")
    return True

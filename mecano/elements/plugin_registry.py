"""Registration of each Kind of a deck section, SlipLaw and Term that a plugin defines at its top level."""

from mecano.element_interface import SECTIONS, Kind
from mecano.elements import KINDS
from mecano.elements.wheels.record_names import names_of_wheels
from mecano.elements.wheels.slip_law import SlipLaw
from mecano.elements.wheels.slip_laws import SLIP_LAWS
from mecano.elements.wheels.tire_law import register as register_slip_law
from mecano.errors import UsageError
from mecano.jit.digest import is_digested
from mecano.laws import TERMS
from mecano.laws.law_table import evaluate_curve, number_terms
from mecano.laws.term import Term

REGISTRIES = {Kind: ("kind", KINDS), SlipLaw: ("slip law", SLIP_LAWS), Term: ("term of a law", TERMS)}


def register(source, module):
    """Register the kinds and laws of a module and return them; raises UsageError, and registers none, if a name is in
    use.
    """
    own = {id(value): value for name, value in vars(module).items() if not name.startswith("_") and _is_new(value)}
    found = tuple(own.values())
    _refuse_sections(source, module)
    if not found:
        raise UsageError(f"plugin {source} defines no Kind, SlipLaw or Term at its top level")
    for item in found:
        what, registry = REGISTRIES[type(item)]
        if item.name in registry:
            raise UsageError(f"plugin {source}: the name of the {what} '{item.name}' is already in use")
        if isinstance(item, SlipLaw):
            _refuse_names(source, item)
    if any(isinstance(item, Term) for item in found) and is_digested(evaluate_curve.__wrapped__):
        raise UsageError(f"plugin {source} has terms of laws: load it before the first model of the process")
    for item in found:
        if isinstance(item, SlipLaw):
            register_slip_law(item)
        else:
            REGISTRIES[type(item)][1][item.name] = item
    if any(isinstance(item, Term) for item in found):
        number_terms()
    return found


def _refuse_sections(source, module):
    """Raise UsageError for a kind of a section that decks do not have; basic constraints belong to none."""
    for value in vars(module).values():
        if isinstance(value, Kind) and value.section and value.section not in SECTIONS:
            text = f"the kind '{value.name}' has the section '{value.section}'"
            raise UsageError(f"plugin {source}: {text}; known: {', '.join(SECTIONS)}")


def _refuse_names(source, law):
    """Raise UsageError for a value of a slip law that is named like another one of its wheels."""
    taken = names_of_wheels().intersection(law.record)
    if taken:
        raise UsageError(
            f"plugin {source}: the slip law '{law.name}' has values named {', '.join(sorted(taken))}, as its wheels "
            "have; rename these fields, or write 'record' and 'prepare' with other names"
        )


def _is_new(value):
    """Return whether a value is a kind or law that a deck can name and that is not registered yet."""
    if type(value) not in REGISTRIES or (isinstance(value, Kind) and value.section not in SECTIONS):
        return False
    return all(value is not known for known in REGISTRIES[type(value)][1].values())

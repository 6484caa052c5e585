"""Check formulas of signals, and fields that accept a function of time or a formula; names are resolved last."""

from dataclasses import replace

from mecano.deck.compose import CopiedFormula, Node
from mecano.deck.containers import IDENTIFIER, kind
from mecano.deck.expressions import NAME, ExpressionError, is_arithmetic
from mecano.deck.laws import Law, law_or_name
from mecano.deck.parameters import Refused
from mecano.deck.scope import INVALID, Invalid, Reference, Scope
from mecano.deck.units import is_quantity
from mecano.deck.values import in_range, note_degrees, number
from mecano.deck.wording import quoted
from mecano.element_interface import SECTIONS
from mecano.elements.signals.formula import FORMULA
from mecano.laws.formula import NUMBER as NUMBER_STEP
from mecano.laws.formula import SIGN, Formula, FormulaError, difference_of, read_formula
from mecano.laws.formula_rate import ARGUMENT, with_slopes
from mecano.model.quantity_names import UnknownQuantity, resolve
from mecano.schema import CONTINUOUS_DRIVE, MOTION, NUMBER, Field, Values


def signal_entry(node: Node, field: Field, scope: Scope) -> Values | Invalid:
    """Check an entry of the section ``signals``: a formula, or a mapping with a type."""
    if type(node.value) is dict:
        return kind(node, field, scope)
    written = Node(
        {"type": (node, _as(FORMULA.name, node)), "value": (node, node)}, node.source, node.line, node.column
    )
    return kind(written, field, scope)


def drive(node: Node, field: Field, scope: Scope) -> Law | Reference | str | Invalid:
    """Return a checked curve, a formula as text, or a Reference for the name of a law or a signal."""
    text = node.value
    if type(text) is str and IDENTIFIER.fullmatch(text):
        return Reference(text, "laws", "drive", node, scope.subject, field.type.options, use=field)
    if type(text) is str and not is_quantity(text) and not is_arithmetic(text):
        found = _read(text, node, scope)
        if found is INVALID or found.references or found.depends_on_time:
            note_continuous(found, node, field.type.options, scope)
            checked = _noted(found, node, scope)
            of_time = field.type == MOTION and checked is not INVALID
            return Reference(checked, "laws", "motion", node, scope.subject) if of_time else checked
    law = law_or_name(node, replace(field, type=replace(field.type, name="curve"), argument="s"), scope)
    if not isinstance(law, Reference):
        note_continuous(law, node, field.type.options, scope)
    return law


def note_continuous(found: Formula | Law | Invalid, node: Node, options: tuple[str, ...], scope: Scope) -> None:
    """Note a Formula or a law whose value must not jump: that of a field with these ``options`` of its type."""
    if found is not INVALID and options == CONTINUOUS_DRIVE.options:
        scope.continuous.append((found, node, scope.subject))


def formula(node: Node, field: Field, scope: Scope) -> str | Invalid:
    """Return a checked formula as text, with parameters replaced by their values."""
    if type(node.value) in (int, float):
        value = number(node, replace(field, type=NUMBER), scope)
        return INVALID if value is INVALID else repr(value)
    if type(node.value) is not str:
        return scope.refuse_value(node, field)
    return _noted(_read(node.value, node, scope), node, scope)


def condition(node: Node, field: Field, scope: Scope) -> str | Invalid:
    """Return a checked condition as text, with parameters replaced by their values."""
    if type(node.value) is not str:
        return scope.refuse_value(node, field)
    text = _with_numbers(node.value, node, scope)
    if text is INVALID:
        return INVALID
    try:
        found = read_formula(difference_of(text))
    except FormulaError as error:
        return scope.refuse(node, f"the condition {node.value!r}: {error.message}")
    _note_formula(found, node, scope)
    return text


def function(node: Node, field: Field, scope: Scope) -> str | Invalid:
    """Return a checked formula of s alone as text, with parameters replaced by their values."""
    if type(node.value) not in (str, int, float):
        return scope.refuse_value(node, field)
    found = _read(str(node.value), node, scope)
    if found is INVALID:
        return INVALID
    if found.depends_on_time or not {ARGUMENT}.issuperset(found.references):
        return scope.refuse(node, f"the formula {quoted(found.text)} must depend on {ARGUMENT} alone, its argument")
    try:
        with_slopes(found.text)
    except FormulaError as error:
        return scope.refuse(node, f"the formula {quoted(found.text)}: {error.message}")
    return found.text


def _as(text, node):
    return Node(text, node.source, node.line, node.column, text)


def _read(text, node, scope):
    """Return the Formula of a text, with parameters replaced by their values, or INVALID with the error noted."""
    numbers = _with_numbers(text, node, scope)
    if numbers is INVALID:
        return INVALID
    try:
        found = read_formula(numbers)
    except FormulaError as error:
        exact = numbers == text
        message = f"the formula {quoted(text)}: {error.message}"
        return scope.refuse_expression(node, ExpressionError(message, error.column if exact else 0))
    for code, x in found.program:
        if code == NUMBER_STEP and not in_range(x):
            return scope.refuse_expression(node, ExpressionError(f"the formula {quoted(text)}: {x:g} is out of range"))
    if "(" in text:
        note_degrees(node, scope)
    return found


def _with_numbers(text, node, scope):
    """Return the text with parameters replaced by their values, or INVALID with the error noted."""
    try:
        return NAME.sub(lambda match: _number(match, scope), text)
    except Refused:
        return INVALID
    except ExpressionError as error:
        return scope.refuse_expression(node, error)


def _number(match, scope):
    value = scope.parameters(match[1], match.start())
    return f"({value!r})" if value < 0.0 else repr(value)


def _noted(found, node, scope):
    if found is INVALID:
        return INVALID
    _note_formula(found, node, scope)
    return found.text


def _note_formula(found, node, scope):
    """Note the Formula of a node, and the units of the parameters in it."""
    scope.formulas.append((found, node, scope.subject))
    if type(node) is CopiedFormula:
        scope.units_in_formulas[found.text] = node.units
    elif has_units(node.value, scope):
        from mecano.deck.expression_units import units_in_formula  # few formulas have such parameters

        scope.units_in_formulas[found.text] = units_in_formula(node.value, scope)


def has_units(text: str, scope: Scope) -> bool:
    """Return whether a formula has parameters that are quantities or expressions, and may have units."""
    parameters = map(scope.parameters.node, NAME.findall(text))
    return any(parameter and type(parameter.value) is str for parameter in parameters)


def check_formulas(values: Values, scope: Scope) -> None:
    """Note errors for names in formulas that are unknown or ambiguous in the checked ``values`` of a deck."""
    entries = {(s, name): (scope.kinds[d["type"]], d) for s in SECTIONS for name, d in values[s].items()}
    wrong = {name for (_, name), (_, d) in entries.items() if any(type(value) is Reference for value in d.values())}
    for found, node, subject in scope.formulas:
        scope.subject = subject
        for name, column in zip(found.references, found.columns, strict=True):
            if wrong.intersection(name.split(".")):
                continue  # its outputs depend on the meaning of an unknown name
            try:
                resolve(name, entries, values["nodes"])
            except UnknownQuantity as error:
                exact = found.text == node.value
                hint = _meant(error, node.value, {*values["nodes"], *(name for _, name in entries)}, scope)
                scope.refuse_at(node, ExpressionError(error.message, column if exact else 0), hint)


def _meant(error, text, names, scope):
    """Return a hint on the word of an UnknownQuantity in the ``text`` of a formula of a deck with these ``names``."""
    if scope.parameters.known(error.word):
        return f"the parameter is written '${error.word}'"
    divided = (name for name in names if "-" in name and name in text and error.word in name.split("-"))
    if name := min(divided, default=""):
        return f"in formulas '-' is a minus: to read {quoted(name)}, name it {quoted(name.replace('-', '_'))}"
    return scope.suggest(error.word, error.known) if error.known else ""


def check_continuous(values: Values, scope: Scope) -> None:
    """Note errors for set points that jump, in the checked ``values`` of a deck: their energy would be unknown."""
    for found, node, subject in scope.continuous:
        scope.subject = subject
        if isinstance(found, Formula):
            what = _jump(found, values["signals"], scope.kinds, set())
            remedy = "pass it through a 'lag' with the time constant of the actuator"
        else:
            what = _jump_of_law(found)
            remedy = "give it the time that the actuator takes, such as the 'rise' of a step"
        if what:
            scope.refuse(node, f"a set point must not jump, as {what}", remedy)


def _jump_of_law(law):
    """Return a clause on the first jump of a law of time, or ""."""
    from mecano.laws.probe import places_of_jumps  # compiled, and needed for few decks

    places = places_of_jumps(law)
    return f"this law does at {places[0]:g} s" if places else ""


def _jump(found, signals, kinds, seen):
    """Return a clause on what makes a Formula jump, or ""."""
    if any(code == SIGN for code, _ in found.program):
        return "'sign' does"
    for name in (name.removeprefix("signals.") for name in found.references):
        owner, _, output = name.partition(".")
        if name in seen or owner not in signals:
            continue
        seen.add(name)
        d = signals[owner]
        kind = kinds[d["type"]]
        if kind.output_jumps(d, output) if output else kind.jumps(d):
            return f"the {kind.name} {quoted(name)} does"
        inputs = () if (output in kind.chosen(d).states if output else kind.smooths(d)) else kind.chosen(d).read(d)
        if jump := next(filter(None, (_jump(read_formula(text), signals, kinds, seen) for text in inputs)), ""):
            return jump
    return ""

"""Units of signals: given by the deck, or derived from the quantities in their formulas, or from their use.

A signal that is the value of a load has the unit of this load, and so has the input of a filter of this signal. A
signal that is added to or compared with a quantity has the unit of that quantity.
"""

import math
from collections.abc import Iterable, Iterator

from mecano.constraints.along_coordinate.demand import is_formula
from mecano.constraints.along_coordinate.signal import OF_INPUT, OF_SLOPE, OF_VALUE, VALUE
from mecano.element_interface import Output
from mecano.laws.formula import (
    ABS,
    ACOS,
    ADD,
    ASIN,
    ATAN,
    ATAN2,
    COS,
    DIVIDE,
    EXP,
    HYPOT,
    INPUT,
    LOG,
    MAX,
    MIN,
    MULTIPLY,
    NEGATIVE,
    NUMBER,
    POWER,
    SIGN,
    SIN,
    SQRT,
    STEP,
    SUBTRACT,
    TAN,
    TANH,
    TIME,
    read_formula,
)
from mecano.model.measured_outputs import measured_outputs, powers, quantities
from mecano.model.model import Element, Model
from mecano.model.quantity_names import resolve
from mecano.model.sampler import NODE_OUTPUTS
from mecano.model.unit_products import product_unit
from mecano.model.wiring import text_of
from mecano.schema import Field

UNKNOWN = VALUE.unit
ANY = ""  # unit of a number, which adopts that of a sum or comparison
LIKE = (ADD, SUBTRACT, MIN, MAX, HYPOT)  # of two numbers of one unit
OWN = dict.fromkeys((SIN, COS, TAN, TANH, SIGN, EXP, LOG, STEP), "-") | dict.fromkeys((ASIN, ACOS, ATAN, ATAN2), "rad")
OF_NO_QUANTITY = (UNKNOWN, "-", "s", "1/s", "1/s2")
"""Units of formulas that any field accepts: a ramp is a number times time, a quotient of lengths may be an angle."""
OF_NODES = {name: unit for name, unit, _, _ in NODE_OUTPUTS}


def signal_units(model: Model, formulas: Iterable[str] = ()) -> dict[str, str]:
    """Return {path: unit} of the outputs of the signals of a Model that depend on its deck.

    ``formulas``: paths of the formulas written in place (wiring.py).
    """
    units = _Units(model)
    found = {f"{path}/{VALUE.name}": units.of_formula(text_of(path)) for path in formulas}
    for element in _signals(model):
        for output in element.kind.outputs:
            if output.name == VALUE.name or output.unit in (OF_VALUE, OF_INPUT, OF_SLOPE):
                found[f"signals/{element.name}/{output.name}"] = units.of_output(element.name, output)
    return found


def drives_with_units(model: Model) -> Iterator[tuple[Element, Field, str, str]]:
    """Yield (Element, Field, formula, unit) of the formulas of loads, set points and laws whose units are known."""
    if not _signals(model):
        return
    units = _Units(model)
    for element in model.elements:
        for field, text in _drives(element.kind.fields, element.values):
            unit = units.of_formula(text)
            if unit not in OF_NO_QUANTITY:
                yield element, field, text, unit


def unlike_sums(model: Model, formulas: Iterable[str]) -> tuple[list[tuple[str, str, str]], list[tuple[str, float]]]:
    """Return what the ``formulas`` (texts) add or compare: quantities of two units, and angles with large numbers.

    These are (formula, unit, other unit), and (formula, number) of whole or half numbers beyond a turn, which look like
    degrees.
    """
    units = _Units(model)
    for text in formulas:
        units.of_formula(text)
    pairs = [(text, *pair) for text in formulas for pair in units.unlike[text]]
    return pairs, [(text, number) for text in formulas for number in units.degrees[text]]


def looks_like_degrees(angle: float) -> bool:
    """Return whether an angle [rad] is more than a turn, in whole or half numbers."""
    return abs(angle) > 2.0 * math.pi and (2.0 * angle).is_integer()


def _signals(model):
    return [element for element in model.elements if element.kind.section == "signals"]


def _drives(fields, values):
    """Yield (Field, formula) of those fields, also inside mappings, that are given as formulas of signals."""
    for field in fields:
        value = values.get(field.name)
        if field.type.name == "drive" and is_formula(value):
            yield field, value
        elif field.type.name == "mapping" and type(value) is dict:
            yield from _drives(field.type.options, value)


class _Units:
    """Units of signals by name, found one after another."""

    def __init__(self, model):
        self.nodes = {node.name for node in model.nodes}
        self.in_formulas = model.units_in_formulas
        self.entries = {(e.kind.section, e.name): (e.kind, e.values) for e in model.elements}
        self.found: dict[str, str] = {}  # units by signal
        self.unlike: dict[str, list[tuple[str, str]]] = {}  # pairs of units that a formula adds or compares
        self.degrees: dict[str, list[float]] = {}  # numbers that a formula adds to or compares with an angle
        self.used: dict[str, str] = {}  # units by signal, of fields whose value it is, and of its comparisons
        for element in model.elements:
            for field, text in _drives(element.kind.fields, element.values):
                self._use(text, field.unit)
        before: dict[str, str] | None = None
        while self.used != before:  # the use of one signal determines that of another
            before = dict(self.used)
            self.found.clear()
            for element in _signals(model):
                self.of_signal(element.name)
                for text in element.kind.chosen(element.values).read(element.values):
                    self.of_formula(text)

    def _use(self, text, unit):
        """Note that the value of a formula is a quantity in ``unit``, if it is a signal; of two units none is noted."""
        name = read_formula(text).reference.removeprefix("signals.")
        if ("signals", name) not in self.entries or not product_unit((unit, 1.0)) or self.used.get(name) == unit:
            return
        known = name in self.used
        self.used[name] = UNKNOWN if known else unit
        kind, d = self.entries["signals", name]
        if not known and kind.same_unit_as(d) and not kind.power_of_seconds(d):
            self._use(kind.same_unit_as(d), unit)

    def of_output(self, name: str, output: Output) -> str:
        """Return the unit of an output of a signal: that of its value, of its input, or of their quotient."""
        value = self.of_signal(name)
        if output.unit not in (OF_INPUT, OF_SLOPE):
            return value
        kind, d = self.entries["signals", name]
        of_input = self.of_formula(kind.read(d)[0])
        return of_input if output.unit == OF_INPUT else _product((value, 1.0), (of_input, -1.0))

    def of_signal(self, name: str) -> str:
        """Return the unit of a signal; in a loop of signals only units given by the deck are known."""
        if name not in self.found:
            self.found[name] = UNKNOWN
            kind, d = self.entries["signals", name]
            like = self.of_formula(kind.same_unit_as(d)) if kind.same_unit_as(d) else UNKNOWN
            power = kind.power_of_seconds(d)
            unit = _product((like, 1.0), ("s", power)) if power else like
            self.found[name] = d["unit"] or (self.used.get(name, UNKNOWN) if unit == UNKNOWN else unit)
        return self.found[name]

    def of_formula(self, text: str) -> str:
        """Return the unit of a formula, as far as those of its quantities determine it.

        A number that is a factor may have any unit, and so may the product.
        """
        formula, stack, self.unlike[text], self.degrees[text] = read_formula(text), [], [], []
        of_operands = iter(self._of_operands(formula))
        for i, (code, _) in enumerate(formula.program):
            if code < NEGATIVE:
                stack.append(next(of_operands))
            elif code < ADD:
                stack.append(_of_one(code, stack.pop()))
            else:
                second, first = stack.pop(), stack.pop()
                exponent = formula.program[i - 1]
                power = exponent[1] if code == POWER and exponent[0] == NUMBER else 0.0
                stack.append(_product((first, power)) if power else _of_two(code, first, second))
                if code in LIKE:
                    self._compare(formula, i, first, second)
        return stack[0] or UNKNOWN

    def _compare(self, formula, i, first, second):
        """Note the units of the numbers that the step ``i`` of a formula adds or compares, and the use of signals.

        The least or largest of several differences, as in a condition, may be of different quantities.
        """
        if formula.program[i][0] in (MIN, MAX) and formula.program[i - 1][0] == SUBTRACT:
            return
        if first != second and not {ANY, UNKNOWN} & {first, second}:
            self.unlike[formula.text].append((first, second))
        before = formula.program[:i][::-1]  # the last number stands before the step, the other before that
        for unit, other, place in ((second, first, 0), (first, second, 1)):
            alone = place < len(before) and all(code < NEGATIVE for code, _ in before[: place + 1])
            if unit == ANY and other == "rad" and alone and looks_like_degrees(before[place][1]):
                self.degrees[formula.text].append(before[place][1])
            if unit == UNKNOWN and other not in (ANY, UNKNOWN) and alone and before[place][0] == INPUT:
                self._use(formula.references[int(before[place][1])], other)

    def _of_operands(self, formula):
        """Yield the units of the numbers, inputs and times of a formula, in their order."""
        known = self.in_formulas.get(formula.text, {})
        for i, (code, x) in enumerate(formula.operands):
            if code == INPUT:
                yield self._of_quantity(formula.references[int(x)])
            else:
                yield "s" if code == TIME else known.get(i, ANY)

    def _of_quantity(self, name):
        section, owner, what = resolve(name, self.entries, self.nodes)
        if section == "nodes":
            return OF_NODES[what.partition(".")[0]]
        if section == "signals" and not what:
            return self.of_signal(owner)
        kind, d = self.entries[section, owner]
        if what in powers(kind.chosen(d)):
            return "W"
        outputs = measured_outputs(kind, d)
        found = next(output for output, label in outputs if what in quantities(output, label))
        return self.of_output(owner, found) if section == "signals" else found.unit


def _of_one(code, unit):
    """Return the unit of a function of a number with this unit."""
    if code == SQRT:
        return _product((unit, 0.5))
    return unit if code in (NEGATIVE, ABS) else OWN[code]


def _of_two(code, first, second):
    """Return the unit of an operation on two numbers with these units."""
    if code in OWN:
        return OWN[code]
    if code in (MULTIPLY, DIVIDE):
        return _product((first, 1.0), (second, 1.0 if code == MULTIPLY else -1.0))
    if code not in LIKE or UNKNOWN in (first, second):
        return UNKNOWN
    if ANY in (first, second) or first == second:
        return first or second
    return next((one for one, other in ((first, second), (second, first)) if _without_radians(one) == other), UNKNOWN)


def _without_radians(unit):
    return product_unit((unit, 1.0), ("rad", -1.0))


def _product(*factors):
    """Return the unit of a product of ``factors`` (unit, power); that of numbers alone is ANY, with others UNKNOWN."""
    units = {unit for unit, _ in factors}
    if units == {ANY}:
        return ANY
    return UNKNOWN if {ANY, UNKNOWN} & units else product_unit(*factors) or UNKNOWN

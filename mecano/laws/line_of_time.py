"""Curves of an argument that is a straight line of the time, such as the place of a wheel at a constant speed."""

from mecano.laws import TERMS
from mecano.laws.formula import TIME, FormulaError, evaluate_formula, read_formula
from mecano.laws.formula_rate import LONGEST, rate_of
from mecano.maths.dual import value


def line_of_time(text):
    """Return (slope, offset) of a formula (text) of the time alone that is slope t + offset; None for any other."""
    formula = read_formula(text, LONGEST)
    if formula.references or not formula.depends_on_time:
        return None
    try:
        rate = read_formula(rate_of(text), LONGEST)
    except FormulaError:  # it has corners, or is too long
        return None
    return None if (TIME, 0.0) in rate.program else (_at_start(rate), _at_start(formula))


def _at_start(formula):
    """Return the value of a Formula without references at the time zero."""
    return float(value(evaluate_formula(formula.numbers, 0, 0.0, [0.0], 0)))


def along_line(law, slope, offset):
    """Return the law of the argument t whose value is that of ``law`` at slope t + offset.

    None if there is none: for a slope that is not positive, for terms that it does not turn into a term, and where
    rounding makes points of a table equal.
    """
    if slope <= 0.0 or not all(TERMS[name].along_line for name, _ in law):
        return None
    changes = [TERMS[name].along_line(values, slope, offset) for name, values in law]
    if None in changes:
        return None
    found = tuple((name, {**values, **changed}) for (name, values), changed in zip(law, changes, strict=True))
    return found if all(_is_valid(TERMS[name], values) for name, values in found) else None


def _is_valid(term, values):
    """Return whether a term can have these values; rounding may make points of a table equal."""
    checked = [(field, values[field.name]) for field in term.fields if field.check and values.get(field.name)]
    return not any(field.check(value) for field, value in checked) and not term.check(values)

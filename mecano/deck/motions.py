"""Prescribed motions by formulas: functions of the time that have two rates, into which signals are inserted."""

import re
from collections.abc import Container, Mapping

from mecano.deck.laws import Law
from mecano.deck.wording import quoted
from mecano.laws.formula import FormulaError, read_formula
from mecano.laws.formula_rate import LONGEST, TOO_LONG, with_rates
from mecano.schema import Values

INSTEAD = (
    "a prescribed motion needs the second rate of its value; use a spring or a law of the joint with this set point, a "
    "force or a moment with a controller, or a coupler of joints"
)
SMOOTH = (
    "a prescribed motion needs the second rate of its value; write step(time, a, b), which rises smoothly from 0 to 1, "
    "or a law of time with smooth edges"
)


def put_curves_of_time(signals: dict[str, Values], sloping: Container[str]) -> None:
    """Turn the curves of a straight line of the time, in place, into curves of the time.

    Curves whose names are ``sloping`` stay as they are, as their slopes would be others.
    """
    curves = [
        d for name, d in signals.items() if d["type"] == "curve" and type(d["law"]) is tuple and name not in sloping
    ]
    for d in (d for d in curves if d["input"].strip() != "time"):
        from mecano.laws.line_of_time import along_line, line_of_time  # few decks need it

        try:
            line = line_of_time(_of_time(d["input"], signals, ()))
        except NotAMotion:
            continue
        if line and (law := along_line(d["law"], *line)):
            d["input"], d["law"] = "time", law


class NotAMotion(Exception):
    """A signal or formula that is no prescribed motion, and the reason."""


def motion_of(text: str, signals: Mapping[str, Values]) -> Law | str:
    """Return the motion of a formula (text): a formula of the time alone, or the terms of a law of time.

    ``signals`` are the checked values of the signals of the deck, with their laws. Raises NotAMotion.
    """
    d = signals.get(text.removeprefix("signals."), {"type": ""})
    if d["type"] == "curve" and d["input"].strip() == "time":
        return d["law"]
    found = _of_time(text, signals, ())
    try:
        with_rates(found)
    except FormulaError as error:
        raise NotAMotion(TOO_LONG if error.message == TOO_LONG else f"{error.message}; {SMOOTH}") from None
    return found


def _of_time(text, signals, outer):
    """Return the formula with the formulas of the signals that it reads in their place."""
    for name in read_formula(text).references:
        signal = name.removeprefix("signals.")
        d = signals.get(signal)
        if signal in outer:
            raise NotAMotion(f"the signal {quoted(signal)} depends on itself")
        if d is not None and d["type"] == "curve" and d["input"].strip() == "time":
            raise NotAMotion(
                f"the curve {quoted(name)} can be the whole value, but no part of a formula: write the motion as one "
                "law, a list of terms such as [{step: {...}}, {step: {...}}], or as a formula of the time"
            )
        if d is None or d["type"] != "formula":
            of_signal = signal.partition(".")[0] in signals
            what = "is the output of a signal" if of_signal else "depends on the motion"
            what = f"{quoted(name)} {what}" if d is None else f"{quoted(name)} is a {d['type']}"
            if d is not None and d["type"] == "curve":
                what += ", of another input than a straight line of the time, such as 20*time - 3, that rises"
                what += ", or one whose slope is read" if _is_of_time(d["input"]) else ""
            raise NotAMotion(f"it is not a function of time alone: {what}; {INSTEAD}")
        inner = _of_time(d["value"], signals, (*outer, signal))
        text = _inserted(text, name, inner)
        if len(text) > LONGEST:
            raise NotAMotion(TOO_LONG)
    return text


def _is_of_time(text):
    """Return whether a formula is one of the time alone, without signals."""
    formula = read_formula(text)
    return formula.depends_on_time and not formula.references


def _inserted(text, name, inner):
    """Return a formula with the formula ``inner`` in place of a name."""
    return re.sub(rf"(?<![\w.]){re.escape(name)}(?![\w.])", lambda _: f"({inner})", text)

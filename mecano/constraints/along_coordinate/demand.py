"""Demanded value of a load: a function of time, or a formula of signals, which is then an input of its element."""

from dataclasses import replace

from mecano.jit.kernel import kernel
from mecano.laws.table import evaluate_curve
from mecano.maths.dual import number


@kernel
def of_time(p, at):
    """Return the value of the record's law at the current time."""
    return evaluate_curve(at.laws, p.law, at.t)[0]


def of_input(i):
    """Return the compiled function (p, at) -> value of the local unknown i."""

    @kernel
    def read(p, at):
        return number(at.q[i])

    return read


def is_formula(value):
    """Return whether a checked value of the type DRIVE is a formula, not a law."""
    return isinstance(value, str)


def law_of(value, context):
    """Return the start, in the table of laws, of a checked value of the type DRIVE; 0 for a formula."""
    return 0 if is_formula(value) else int(context.laws.add(value))


def on_demand(make, field, i):
    """Return the Kind ``make(demand)`` for a function of time, whose variant reads a formula in the deck's ``field``.

    ``i``: local index of the input, which follows the slots and the scalars.
    """
    by_law, by_signal = make(of_time), replace(make(of_input(i)), inputs=(field,))
    return replace(by_law, variant=lambda d: by_signal if is_formula(d[field]) else by_law)
